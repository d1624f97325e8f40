//! Reports: HTML pages, text for the terminal, JSON and CSV.

pub mod balance;
pub mod campbell;
pub mod catalogue;
pub mod check;
mod csv;
pub mod element_motion;
pub mod equilibria;
pub mod equilibrium;
mod figures;
pub mod fit;
#[cfg(test)]
pub(crate) mod fixture;
pub mod fleet;
mod html;
pub mod live;
pub mod number;
mod page;
pub mod sweep;
mod text;
pub mod trade;
mod words;

use anyhow::{Context, Result};
use ballrace_twin::replay::outcome::Outcome;

pub use csv::csv;
pub use html::html;
pub use text::text;
pub use words::{EVENT_ACTION, diagnosis, pacing, reduced_rotor};

/// Returns the outcome as JSON, without the data of the figures. A number that is not finite becomes `null`.
///
/// # Errors
/// Returns the error of the serialiser.
pub fn json(outcome: &Outcome) -> Result<String> {
    serde_json::to_string_pretty(outcome).context("writing the outcome as JSON")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn json_has_no_nan() {
        for outcome in [fixture::usual(), fixture::bare(), fixture::broken()] {
            let text = json(&outcome).unwrap();
            let value: serde_json::Value = serde_json::from_str(&text).unwrap();
            assert!(value.get("probes").unwrap().is_array());
            assert!(value.get("pictures").is_none());
        }
        let value: serde_json::Value = serde_json::from_str(&json(&fixture::broken()).unwrap()).unwrap();
        assert!(value["probes"][0]["residual_rms_um"].is_null());
    }
}
