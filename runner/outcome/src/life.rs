//! Load ratings and life of one bearing under the loads of a recording.

use crate::field::NumericField;
use serde::Serialize;

/// Load ratings and life of one bearing, for 90 % reliability, under the loads of its elements along the recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LifeOutcome {
    /// Basic dynamic radial load rating `C` (ISO 281).
    pub dynamic_rating_n: f64,
    /// Basic static radial load rating `C0` (ISO 76).
    pub static_rating_n: f64,
    /// Dynamic equivalent reference load (ISO/TS 16281), whose life is `L10r`.
    pub reference_load_n: f64,
    /// Basic reference rating life `L10r` from the loads of the elements (ISO/TS 16281); none without load.
    pub reference_life_h: Option<f64>,
    /// Viscosity ratio `kappa` at the mean speed; none without lubrication and its contamination in the scene.
    pub viscosity_ratio: Option<f64>,
    /// Life modification factor `a_ISO` (ISO 281); none also with a viscosity ratio below 0.1.
    pub modification_factor: Option<f64>,
    /// Modified reference rating life `L10mr = a_ISO L10r`.
    pub modified_life_h: Option<f64>,
    /// Mean dynamic equivalent load `P` (ISO 281); none where its factors are not listed for the contact angle.
    pub equivalent_load_n: Option<f64>,
    /// Basic rating life `L10` by `P` (ISO 281); none without load.
    pub basic_life_h: Option<f64>,
}

impl LifeOutcome {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 9] = [
        NumericField::new("dynamic_rating_n", "C", "N", |life: &Self| life.dynamic_rating_n).short("C").decimals(0),
        NumericField::new("static_rating_n", "C0", "N", |life: &Self| life.static_rating_n).short("C0").decimals(0),
        NumericField::new("reference_load_n", "Reference load", "N", |life: &Self| life.reference_load_n)
            .short("ref. load")
            .decimals(1),
        NumericField::new("reference_life_h", "L10r", "h", |life: &Self| number(life.reference_life_h))
            .short("L10r")
            .decimals(0),
        NumericField::new("viscosity_ratio", "kappa", "", |life: &Self| number(life.viscosity_ratio)).decimals(2),
        NumericField::new("modification_factor", "a_ISO", "", |life: &Self| number(life.modification_factor))
            .decimals(2),
        NumericField::new("modified_life_h", "L10mr", "h", |life: &Self| number(life.modified_life_h))
            .short("L10mr")
            .decimals(0),
        NumericField::new("equivalent_load_n", "P", "N", |life: &Self| number(life.equivalent_load_n))
            .short("P")
            .decimals(1),
        NumericField::new("basic_life_h", "L10", "h", |life: &Self| number(life.basic_life_h)).short("L10").decimals(0),
    ];
}

const fn number(value: Option<f64>) -> f64 {
    match value {
        Some(value) => value,
        None => f64::NAN,
    }
}
