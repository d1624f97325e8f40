//! Figures of a vibration sensor.

use serde::Serialize;

/// Vibration velocity at one sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorOutcome {
    /// Column.
    pub name: String,
    /// Root mean square of the velocity.
    pub velocity_rms_mm_s: f64,
    /// Range of frequencies.
    pub band_hz: [f64; 2],
    /// Zone; none without `[machine]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zone: Option<VelocityZone>,
}

/// Zone of the vibration velocity (ISO 20816-1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum VelocityZone {
    /// Newly commissioned machines.
    A,
    /// Acceptable for unrestricted long-term operation.
    B,
    /// Unsatisfactory for long-term operation, until there is an opportunity for remedial action.
    C,
    /// Severe enough to damage the machine.
    D,
}

impl VelocityZone {
    /// Returns the zone of a velocity; `limits` are those between the zones.
    #[must_use]
    pub fn of(velocity: f64, [a, b, c]: [f64; 3]) -> Self {
        match velocity {
            v if v <= a => Self::A,
            v if v <= b => Self::B,
            v if v <= c => Self::C,
            _ => Self::D,
        }
    }

    /// Returns the meaning, as the end of a sentence.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::A => "as of a newly commissioned machine",
            Self::B => "acceptable for long-term operation",
            Self::C => "unsatisfactory for long-term operation",
            Self::D => "severe enough to damage the machine",
        }
    }
}
