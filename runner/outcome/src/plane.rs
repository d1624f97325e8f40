//! Motion in a plane of two radial probes.

use crate::field::NumericField;
use serde::Serialize;

/// Motion in a plane of two radial probes: means over blocks of four turns.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlaneOutcome {
    /// Names of its probes.
    pub name: String,
    /// Along Z as drawn.
    pub station_mm: f64,
    /// Farthest from the mean place, zero to peak.
    pub smax_um_peak: f64,
    /// Long axis of the 1X ellipse.
    pub one_x_major_um_pp: f64,
    /// Its short axis.
    pub one_x_minor_um_pp: f64,
    /// The 1X orbit is run through in the sense of rotation.
    pub one_x_forward: bool,
}

impl PlaneOutcome {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("station_mm", "Station", "mm", |plane: &Self| plane.station_mm).decimals(1),
        NumericField::new("smax_um_peak", "Smax", "um peak", |plane| plane.smax_um_peak),
        NumericField::new("one_x_major_um_pp", "1X long axis", "um pp", |plane| plane.one_x_major_um_pp),
        NumericField::new("one_x_minor_um_pp", "1X short axis", "um pp", |plane| plane.one_x_minor_um_pp),
    ];
}
