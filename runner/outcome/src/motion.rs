//! Motion at a probe: mean, size, 1X, and the ball-pass lines.

use crate::field::NumericField;
use serde::Serialize;

/// Motion at one probe. Amplitudes are peak (not peak-to-peak) unless the name states otherwise.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Motion {
    /// Mean position.
    pub mean_um: f64,
    /// Largest less smallest reading.
    pub peak_to_peak_um: f64,
    /// About the mean.
    pub rms_um: f64,
    /// 1X amplitude, zero to peak.
    pub one_x_um: f64,
    /// 1X phase lag behind the keyphasor mark, 0 to 360.
    pub one_x_phase_lag_deg: f64,
}

impl Motion {
    /// No reading.
    pub const NONE: Self = Self {
        mean_um: f64::NAN,
        peak_to_peak_um: f64::NAN,
        rms_um: f64::NAN,
        one_x_um: f64::NAN,
        one_x_phase_lag_deg: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 5] = [
        NumericField::new("mean_um", "Mean", "um", |m| m.mean_um),
        NumericField::new("peak_to_peak_um", "Peak to peak", "um pp", |m: &Self| m.peak_to_peak_um).short("peak-peak"),
        NumericField::new("rms_um", "RMS", "um rms", |m: &Self| m.rms_um).short("rms"),
        NumericField::new("one_x_um", "1X", "um peak", |m| m.one_x_um),
        NumericField::new("one_x_phase_lag_deg", "1X phase", "deg lag", |m: &Self| m.one_x_phase_lag_deg).decimals(1),
    ];
}

/// Returns the phase lag of `cosine cos(angle) + sine sin(angle)` in degrees, 0 to 360: the shaft angle of the peak after the
/// keyphasor mark.
#[must_use]
pub fn phase_lag_deg(cosine: f64, sine: f64) -> f64 {
    sine.atan2(cosine).to_degrees().rem_euclid(360.0)
}

/// Ball-pass line of one bearing at one probe.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BallPassLine {
    /// The bearing.
    pub bearing: String,
    /// Per turn of the shaft.
    pub order: f64,
    /// At the mean speed.
    pub frequency_hz: f64,
    /// Zero to peak, mean over blocks of turns.
    pub measured_um: f64,
    /// The same of the twin.
    pub twin_um: f64,
    /// The same of their difference.
    pub residual_um: f64,
}

impl BallPassLine {
    /// No line.
    pub const NONE: Self = Self {
        bearing: String::new(),
        order: f64::NAN,
        frequency_hz: f64::NAN,
        measured_um: f64::NAN,
        twin_um: f64::NAN,
        residual_um: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 5] = [
        NumericField::new("order", "Order", "X", |line: &Self| line.order).decimals(3),
        NumericField::new("frequency_hz", "Line", "Hz", |line: &Self| line.frequency_hz).decimals(1),
        NumericField::new("measured_um", "Measured", "um peak", |line| line.measured_um),
        NumericField::new("twin_um", "Twin", "um peak", |line| line.twin_um),
        NumericField::new("residual_um", "Residual", "um peak", |line: &Self| line.residual_um).short("difference"),
    ];
}
