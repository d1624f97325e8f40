//! Parameters of a healthy machine, determined from a recording of it.

use serde::{Deserialize, Serialize};

/// Parameters of a healthy machine, determined from a recording of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Parameters with their standard deviations.
    pub parameters: Vec<CalibratedParameter>,
    /// Correlation of each pair of parameters, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// Sum of squares of the residual per value, in units of the noise: about 1 where the calibrated scene describes the recording.
    pub chi_square_per_value: f64,
}

/// Calibrated parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedParameter {
    /// Name.
    pub name: ParameterName,
    /// Name of the bearing; `None` for a parameter of the rotor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub deviation: f64,
}

/// Name of a parameter that a calibration determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterName {
    /// Diametral clearance, m.
    DiametralClearance,
    /// Young's modulus of a bearing, Pa.
    YoungsModulus,
    /// Damping of translations, N s/m.
    TranslationDamping,
    /// Damping of rotations, N m s/rad.
    RotationDamping,
    /// Static unbalance along the keyphasor mark, kg m.
    UnbalanceX,
    /// Static unbalance a quarter of a revolution ahead, kg m.
    UnbalanceY,
    /// Couple unbalance along the keyphasor mark, kg m^2.
    CoupleX,
    /// Couple unbalance a quarter of a revolution ahead, kg m^2.
    CoupleY,
}
