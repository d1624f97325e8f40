//! Data of the figures of one diagnosis.

use crate::fault::UnexplainedMotion;
use serde::{Deserialize, Serialize};

/// Data of the figures of one diagnosis. A figure without data is not drawn.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaultFigures {
    /// Force at the bearing by its direction; `None` if no component of a bearing has local damage.
    pub rose: Option<ForceRose>,
    /// Spectra of the unexplained force, one per frame of reference.
    pub spectra: Vec<ForceSpectrum>,
    /// Motion at one probe with and without the fault.
    pub motion: Option<FaultMotion>,
}

/// Frame of reference in which a force is described.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceFrame {
    /// Fixed, as the outer ring: angles from +X.
    #[default]
    Fixed,
    /// Turns with the shaft and the inner ring: angles from the keyphasor mark.
    Shaft,
    /// Turns with the cage: angles from element 1.
    Cage,
}

/// Energy of the unexplained force at a bearing by its direction, over the mean pass of an element over the damage.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForceRose {
    /// Frame of the damaged component.
    pub frame: ReferenceFrame,
    /// Share of the energy in each sector; the first one is centred at angle 0. Their sum is 1.
    pub energy: Vec<f64>,
    /// Mean direction of the energy, 0 to 360 deg.
    pub direction_deg: f64,
    /// Largest force of the mean pass, N.
    pub peak_n: f64,
    /// Number of passes in the mean.
    pub passes: f64,
    /// The mean pass: angle of the element (of its surface, for a damaged element) from the damage, deg; force along the direction
    /// and 90 deg ahead of it, N.
    pub pass: Vec<[f64; 3]>,
    /// Angle of each element at a keyphasor pulse, rad in `frame`.
    pub element_azimuths: Vec<f64>,
    /// Ball diameter over pitch diameter.
    pub ball_over_pitch: f64,
}

/// Full spectrum of the unexplained force at a bearing in one frame of reference. Forward precession has positive orders.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForceSpectrum {
    /// Frame of reference.
    pub frame: ReferenceFrame,
    /// True if the damaged component is stationary in this frame.
    pub is_of_component: bool,
    /// Order per turn of the shaft and amplitude in N peak: force that the machine without the fault leaves unexplained.
    pub unexplained: Vec<(f64, f64)>,
    /// The same of the force that the fault adds.
    pub explained: Vec<(f64, f64)>,
    /// Orders of the lines that the diagnosis explains, strongest first.
    pub lines: Vec<f64>,
}

/// Motion at a probe over two revolutions, as measured, and as the machine without and with the fault requires it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaultMotion {
    /// Column of the probe.
    pub probe: String,
    /// Revolutions of the shaft from a keyphasor pulse.
    pub revolutions: Vec<f64>,
    /// Readings, um.
    pub measured: Vec<f64>,
    /// Estimate without the fault, um.
    pub without: Vec<f64>,
    /// Estimate with the fault, um.
    pub with: Vec<f64>,
    /// Unexplained motion at this probe over all samples of the diagnosis.
    pub unexplained: Option<UnexplainedMotion>,
}
