//! Helpers of the tests.

use ballrace_scene::{Direction, Probe};

/// Returns a radial probe in um without an offset.
pub(crate) fn probe(column: &str, angle: f64) -> Probe {
    Probe {
        column: column.to_owned(),
        metres_per_unit: 1e-6,
        station: 0.0,
        coordinates: None,
        direction: Direction::Radial(angle),
        noise: None,
        offset: 0.0,
        sensitivity: None,
    }
}
