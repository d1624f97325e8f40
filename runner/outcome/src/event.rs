//! Limits that were crossed.

use serde::Serialize;

/// Event: a limit that was crossed.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Event {
    /// The indicator, as the scene names it.
    pub indicator: &'static str,
    /// The probe's column.
    pub probe: String,
    /// The bearing, for the line of a race.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Start of the first block beyond the limit, s.
    pub start_s: f64,
    /// End of the last one; none where it was still beyond at the end of the recording.
    pub end_s: Option<f64>,
    /// Largest value.
    pub worst: f64,
    /// End of the block with the largest value, s.
    pub worst_s: f64,
    /// The limit.
    pub limit: f64,
    /// Unit of `worst` and `limit`: um or empty.
    pub unit: &'static str,
    /// The event as a sentence; empty where a line of the event log has it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sentence: String,
}
