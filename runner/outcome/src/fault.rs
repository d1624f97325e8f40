//! Kind, form, place and size of a fault.

use crate::field::NumericField;
use serde::{Deserialize, Serialize};

/// Kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// Damage of an outer race.
    OuterRace,
    /// Damage of an inner race.
    InnerRace,
    /// Damage of a rolling element.
    Element,
    /// Cage.
    Cage,
    /// Mass unbalance.
    Unbalance,
    /// Shaft misalignment.
    Misalignment,
    /// Too much or too little clearance.
    Clearance,
    /// Constant load other than the scene's.
    Load,
    /// A ring that is loose in its seat: no damage of the bearing.
    Looseness,
    /// A support that yields more than in the sound machine: no damage of the bearing.
    Support,
    /// A misaligned coupling: no fault of a bearing.
    Coupling,
    /// Changed run-out of the shaft's surface under a probe: no fault of the machine.
    RunOut,
    /// Another fault.
    Other,
}

impl FaultKind {
    /// Returns the key of files, the name in a sentence and the recommended action.
    const fn words(self) -> [&'static str; 3] {
        const SPARE_BEARING: &str =
            "Order a spare bearing, repeat the measurement within a week and replace the bearing where the line grows.";
        match self {
            Self::OuterRace => ["outer-race", "outer race", SPARE_BEARING],
            Self::InnerRace => ["inner-race", "inner race", SPARE_BEARING],
            Self::Element => ["element", "rolling element", SPARE_BEARING],
            Self::Cage => [
                "cage",
                "cage",
                "Check lubrication and load, and plan the replacement: a cage fails without much warning.",
            ],
            Self::Unbalance => [
                "unbalance",
                "unbalance",
                "Look for deposits, lost weights and loose parts, then balance; repeat with the new unbalance in the scene.",
            ],
            Self::Misalignment => {
                ["misalignment", "misalignment", "Check alignment and coupling hot and cold, and pipe or foot strain."]
            }
            Self::Clearance => [
                "clearance",
                "clearance",
                "Check fit, clearance and temperature of the bearing, then fit the scene again.",
            ],
            Self::Load => [
                "load",
                "load",
                "Check mass, load and signs of the probes in the scene first, as each of them shows as a load; then belt, gear or \
                 thrust loads and what the machine drives.",
            ],
            Self::Looseness => [
                "looseness",
                "looseness",
                "Check the fit of the rings on shaft and in housing, the lock nut, and the bolts of housing and foot. No bearing is to be ordered.",
            ],
            Self::Support => [
                "support",
                "yielding support",
                "Check the bolts of feet and housing, shims and grout for a gap (soft foot), and the base for cracks. No bearing is to be ordered.",
            ],
            Self::Coupling => [
                "coupling",
                "coupling",
                "Check the alignment of the coupling hot and cold, its elements and its bolts; look for a crack of the shaft where the line grows. No \
                 bearing is to be ordered.",
            ],
            Self::RunOut => [
                "run-out",
                "run-out under a probe",
                "Look at the shaft under this probe for scratches, dirt, rust and magnetic spots, record a slow roll and learn the baseline anew. No bearing \
                 is to be ordered.",
            ],
            Self::Other => [
                "other",
                "other",
                "If the scene is not fitted to this machine, run ballrace fit on a recording of the machine in good order; else look at the \
                 residual's spectrum and orbit, and check mounting and probes.",
            ],
        }
    }

    /// Returns the key in files, such as `outer-race`.
    #[must_use]
    pub const fn key(self) -> &'static str {
        let [key, ..] = self.words();
        key
    }

    /// Returns the name in a sentence, such as "outer race".
    #[must_use]
    pub const fn name(self) -> &'static str {
        let [_, name, _] = self.words();
        name
    }

    /// Returns the action that a sure diagnosis recommends.
    pub(crate) const fn action(self) -> &'static str {
        let [.., action] = self.words();
        action
    }
}

/// Form of a surface fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FaultForm {
    /// Local damage.
    Spall,
    /// A wave around the whole surface.
    Waviness,
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// Most likely value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Place and size of a fault, as far as it has them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FaultParameters {
    /// Form of a surface fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<FaultForm>,
    /// Place of a spall: on the outer ring from +X towards +Y, on the inner ring from the keyphasor mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<Estimate>,
    /// Number of the damaged element, from 1 at the azimuth of the first element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<usize>,
    /// Half the extent of a spall along its surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_width_deg: Option<Estimate>,
    /// Greatest depth of a spall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_um: Option<Estimate>,
    /// Waves around the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waviness_order: Option<u32>,
    /// Amplitude of the wave, zero to peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_um: Option<Estimate>,
    /// Tilt of the outer ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt_mrad: Option<Estimate>,
    /// Axis of the tilt, from +X towards +Y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis_deg: Option<Estimate>,
    /// Diametral clearance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance_um: Option<Estimate>,
    /// Diametral play of a ring in its seat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seat_play_um: Option<Estimate>,
    /// Stiffness of a yielding support, along the softer of X and Y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support_stiffness_n_um: Option<Estimate>,
    /// Largest force of a coupling during a turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling_force_n: Option<Estimate>,
    /// Unbalance of the whole rotor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment_g_mm: Option<Estimate>,
    /// Its angle from the keyphasor mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<Estimate>,
    /// Station along Z as drawn, of an unbalance or of a coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station_mm: Option<Estimate>,
    /// Direction of the force of a spall, in the frame of its component: from +X, from the keyphasor mark, from element 1. It is
    /// taken from the measured motion without the fit of the spall, 0 to 360.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_direction_deg: Option<f64>,
    /// Largest force of the mean pass of an element over a spall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
    /// Constant load on the rotor along X, Y and Z, without its weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_n: Option<[Estimate; 3]>,
    /// Logarithm of the likelihood ratio against the machine without this fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log_likelihood_gain: Option<f64>,
    /// Odds against the next likely cause, at most 1e12.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odds_to_next: Option<f64>,
    /// Part of the square of the unexplained motion, less its noise, that this fault explains at all probes together, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explained: Option<f64>,
    /// Unexplained motion at the probe that shows the fault best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unexplained_motion: Option<UnexplainedMotion>,
}

/// Unexplained motion at one probe over the samples of a diagnosis: displacement that the unexplained force causes, in the lines that are
/// diagnosed. It is not the residual of the twin, which is simulated from the scene alone.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnexplainedMotion {
    /// Column of the probe.
    pub probe: String,
    /// Rms without the fault.
    pub without_um: f64,
    /// Rms with the fault.
    pub with_um: f64,
    /// Rms that the noise of the probes causes.
    pub noise_um: f64,
    /// Part of the square of the unexplained motion, less that of its noise, that the fault explains at this probe, 0 to 1.
    pub explained: f64,
}

impl UnexplainedMotion {
    /// Creates the figures of a probe from its rms values without the fault, with it, and of the noise, um; `None` where the fault does not
    /// lower the motion.
    #[must_use]
    pub fn new(probe: &str, [without_um, with_um, noise_um]: [f64; 3]) -> Option<Self> {
        let fall = without_um.powi(2) - with_um.powi(2);
        let left = (with_um.powi(2) - noise_um.powi(2)).max(0.0);
        (fall > 0.0).then(|| Self {
            probe: probe.to_owned(),
            without_um,
            with_um,
            noise_um,
            explained: fall / (fall + left),
        })
    }
}

/// Meaning of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EstimateKind {
    /// Place or direction.
    Place,
    /// Size, which a fault of size 0 does not have.
    Size,
    /// Size of the machine itself, which the fault changes.
    MachineSize,
}

/// Estimated field of the place and size of a fault.
pub type FaultField = NumericField<FaultParameters, Option<Estimate>>;

impl FaultParameters {
    /// Estimated fields in the order of texts.
    pub const FIELDS: [(EstimateKind, FaultField); 13] = {
        use EstimateKind::{MachineSize, Place, Size};
        [
            (Place, FaultField::new("azimuth_deg", "at", "deg", |p| p.azimuth_deg).decimals(1)),
            (Size, FaultField::new("depth_um", "depth", "um", |p| p.depth_um).decimals(2)),
            (Place, FaultField::new("half_width_deg", "half width", "deg", |p| p.half_width_deg).decimals(2)),
            (Size, FaultField::new("amplitude_um", "amplitude", "um", |p| p.amplitude_um).decimals(3)),
            (Size, FaultField::new("tilt_mrad", "tilt", "mrad", |p| p.tilt_mrad).decimals(3)),
            (Place, FaultField::new("axis_deg", "axis at", "deg from +X", |p| p.axis_deg).decimals(0)),
            (MachineSize, FaultField::new("clearance_um", "diametral clearance", "um", |p| p.clearance_um).decimals(2)),
            (Size, FaultField::new("seat_play_um", "play in the seat", "um", |p| p.seat_play_um).decimals(1)),
            (
                Size,
                FaultField::new("support_stiffness_n_um", "stiffness of the support", "N/um", |p| {
                    p.support_stiffness_n_um
                })
                .decimals(1),
            ),
            (Size, FaultField::new("coupling_force_n", "force", "N", |p| p.coupling_force_n).decimals(1)),
            (Size, FaultField::new("moment_g_mm", "moment", "g mm", |p| p.moment_g_mm).decimals(1)),
            (Place, FaultField::new("angle_deg", "at", "deg from the keyphasor mark", |p| p.angle_deg).decimals(1)),
            (Place, FaultField::new("station_mm", "station", "mm", |p| p.station_mm).decimals(1)),
        ]
    };

    /// Returns true if no interval of a size contains 0.
    pub fn is_significant(&self) -> bool {
        let sizes = Self::FIELDS.into_iter().filter(|(kind, _)| *kind == EstimateKind::Size);
        sizes.filter_map(|(_, field)| (field.value)(self)).all(|size| size.low > 0.0)
    }

    /// Returns the size of the fault with its unit: depth, amplitude, tilt, clearance or moment.
    #[must_use]
    pub fn size(&self) -> Option<(Estimate, &'static str)> {
        let mut sizes = Self::FIELDS.into_iter().filter(|(kind, _)| *kind != EstimateKind::Place);
        sizes.find_map(|(_, field)| Some(((field.value)(self)?, field.unit)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_whose_interval_contains_zero_is_not_significant() {
        let of = |low: f64| {
            let size = Estimate { value: 0.4, low, high: 0.8 };
            FaultParameters {
                amplitude_um: Some(size),
                clearance_um: Some(Estimate { low: -1.0, ..size }),
                ..Default::default()
            }
        };
        assert!(of(0.1).is_significant() && !of(0.0).is_significant());
    }
}
