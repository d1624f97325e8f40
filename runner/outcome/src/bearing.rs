//! Results of one bearing: orders, clearance, forces.

use crate::field::NumericField;
use crate::life::LifeOutcome;
use ballrace_scene::OperatingClearance;
use serde::Serialize;

/// Results of one bearing.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BearingOutcome {
    /// Its name.
    pub name: String,
    /// Model in words, e.g. "angular, 9 balls".
    pub model: String,
    /// Along Z as drawn.
    pub station_mm: f64,
    /// Orders per turn: cage, outer race, inner race, ball spin; 0 when unknown.
    pub orders: BearingOrders,
    /// FX, FY, FZ (N), MX, MY (N m) on the inner ring, from the measured displacement: of a straight line between the planes of the probes,
    /// unless the scene has a `[system]`.
    pub force_measured: [ForceFigures; 5],
    /// The same at the position that the observer takes to be behind the probes' noise.
    pub force_estimated: [ForceFigures; 5],
    /// The same of the twin.
    pub force_twin: [ForceFigures; 5],
    /// Rms error of the forces from the straight line, computed in the twin; none where the rotor does not bend and no outer ring moves, so that
    /// the line has no error. Where present, the report shows `force_estimated` in place of `force_measured`.
    pub straight_line_error: Option<[f64; 5]>,
    /// Largest load on one element, N, at the displacement of the forces that the report shows.
    pub largest_element_load_n: f64,
    /// Samples in which no element carried load.
    pub contact_lost_samples: u64,
    /// Number of samples with the last valid force because a reading was missing.
    pub held_samples: u64,
    /// Load ratings and life under the loads at the displacement of `force_estimated`; none where the contacts are not known, and at rest.
    pub life: Option<LifeOutcome>,
}

/// One force component over the recording.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForceFigures {
    /// Mean.
    pub mean: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// One standard deviation that probe noise alone puts on a sample (rms over the recording), when known.
    pub noise_sigma: Option<f64>,
}

/// Components of a force, with their units.
pub const FORCE_COMPONENTS: [(&str, &str); 5] = [("FX", "N"), ("FY", "N"), ("FZ", "N"), ("MX", "N m"), ("MY", "N m")];

impl ForceFigures {
    /// Numeric fields, in the unit of their component.
    pub const FIELDS: [NumericField<Self>; 3] = [
        NumericField::new("mean", "Mean", "", |force| force.mean),
        NumericField::new("min", "Smallest", "", |force: &Self| force.min).short("least"),
        NumericField::new("max", "Largest", "", |force| force.max),
    ];
}

/// Operating clearance of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClearanceOutcome {
    /// Diametral clearance in operation.
    pub operating_um: f64,
    /// Diametral clearance before mounting.
    pub unmounted_um: f64,
    /// Reduction by the fits.
    pub by_fits_um: f64,
    /// Reduction by temperature.
    pub by_temperature_um: f64,
}

impl From<OperatingClearance> for ClearanceOutcome {
    fn from(of: OperatingClearance) -> Self {
        let [operating_um, unmounted_um, by_fits_um, by_temperature_um] =
            [of.value(), of.unmounted, of.by_fits, of.by_temperature].map(|x| x * 1e6);
        Self { operating_um, unmounted_um, by_fits_um, by_temperature_um }
    }
}

impl std::fmt::Display for ClearanceOutcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.2} um: {:.2} um before mounting, less {:.2} um by the fits and {:.2} um by temperature",
            self.operating_um, self.unmounted_um, self.by_fits_um, self.by_temperature_um
        )
    }
}

/// Orders of one bearing per turn of the shaft.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BearingOrders {
    /// Cage.
    pub cage: f64,
    /// Outer ball pass.
    pub outer_race: f64,
    /// Inner ball pass.
    pub inner_race: f64,
    /// Ball spin, when the geometry is known.
    pub ball_spin: Option<f64>,
}

impl BearingOrders {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("cage", "Cage", "X", |orders: &Self| orders.cage).decimals(3),
        NumericField::new("outer_race", "Outer race", "X", |orders: &Self| orders.outer_race).decimals(3),
        NumericField::new("inner_race", "Inner race", "X", |orders: &Self| orders.inner_race).decimals(3),
        NumericField::new("ball_spin", "Ball spin", "X", |orders: &Self| orders.ball_spin.unwrap_or(f64::NAN))
            .decimals(3),
    ];
}
