//! Damage of the cage: one event in a revolution of the cage.

use super::{FaultKind, Pattern, Suspect};

/// Returns the pattern. The slip is that of the outer race, past which the cage carries the elements.
pub(super) fn pattern(suspect: &Suspect) -> Pattern {
    Pattern {
        kind: FaultKind::Cage,
        name: "Cage",
        order: suspect.orders.cage,
        slip: [-0.025, 0.015],
        side_bands: vec![],
    }
}
