//! A diagnosis: fault, component, place, size and evidence.

use crate::failure_mode::FailureMode;
use crate::fault::{FaultKind, FaultParameters};
use crate::fault_figures::{FaultFigures, ReferenceFrame};
use ballrace_scene::Scene;
use serde::{Deserialize, Serialize};

/// Measurement that shows a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum EvidenceSource {
    /// Motion of the shaft at the displacement probes.
    ShaftMotion,
    /// Envelope spectrum of a vibration sensor.
    Vibration,
}

/// Line of a fault in the envelope spectrum of a vibration sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VibrationLine {
    /// Column of the sensor.
    pub sensor: String,
    /// Least and greatest frequency of the band.
    pub band_hz: [f64; 2],
    /// Frequency of the line at the mean speed.
    pub line_hz: f64,
    /// Per turn of the shaft.
    pub order: f64,
    /// Amplitude of the line over the band's mean square.
    pub modulation: f64,
    /// Line over its surroundings, or over the baseline.
    pub level_db: f64,
    /// Other bearings with the same lines that the sensor measures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_excluded: Vec<String>,
}

/// Sense in which a force or an orbit turns, compared with the shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Precession {
    /// In the sense of the shaft.
    #[default]
    Forward,
    /// Against the sense of the shaft.
    Backward,
}

/// Line of the unexplained radial force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnexplainedLine {
    /// Per turn of the shaft.
    pub order: f64,
    /// At the mean speed, Hz.
    pub line_hz: f64,
    /// Bearing at which the force is larger; none where the rotor has not two bearings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Sense of the larger part of the force.
    pub precession: Precession,
    /// Frame of reference in which the line is a harmonic of the passing of the elements, of their spin or of the shaft; else the fixed one.
    pub frame: ReferenceFrame,
    /// Amplitude of that part, N.
    pub force_n: f64,
}

impl std::fmt::Display for UnexplainedLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let precession = match self.precession {
            Precession::Forward => "forward",
            Precession::Backward => "backward",
        };
        let frame = match self.frame {
            ReferenceFrame::Fixed => "fixed frame",
            ReferenceFrame::Shaft => "shaft frame",
            ReferenceFrame::Cage => "cage frame",
        };
        write!(f, "{:.2} ({precession}", self.order)?;
        if let Some(bearing) = &self.bearing {
            write!(f, " at {bearing}")?;
        }
        write!(f, ", {frame})")
    }
}

/// Diagnosis of a fault with its evidence.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnosis {
    /// Fault.
    pub kind: FaultKind,
    /// Bearing, where the fault has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Failures of ISO 15243:2017 that leave this fault, that of a spall or of fluting first; empty where it is no failure of a bearing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failure_modes: Vec<FailureMode>,
    /// Frequency of the first line of the fault at the mean speed; 0 where the fault changes the mean position.
    pub line_hz: f64,
    /// Per turn of the shaft.
    pub order: f64,
    /// Shaft motion: fall of chi-squared by the fault over the least significant one. Vibration: the line over its
    /// surroundings or over the baseline. dB.
    pub level_db: f64,
    /// 0 to 1.
    pub confidence: f64,
    /// Measurements that show the fault.
    pub evidence: Vec<EvidenceSource>,
    /// Line of the fault in the vibration, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationLine>,
    /// Place and size.
    #[serde(flatten)]
    pub parameters: FaultParameters,
    /// The diagnosis as a sentence.
    pub sentence: String,
    /// Strongest lines of a residual that no fault explains; empty for other kinds than `other`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<UnexplainedLine>,
    /// Data of its figures, not part of the JSON.
    #[serde(skip)]
    pub figures: FaultFigures,
}

/// Confidence from which a diagnosis recommends to order or to replace a part.
const SURE: f64 = 0.9;
/// Confidence below which it is only possible.
const POSSIBLE: f64 = 0.6;

impl Diagnosis {
    /// Returns false for an error of a reading, which is no fault of the machine.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        self.kind != FaultKind::RunOut
    }

    /// Returns true for a named fault of the machine that is more likely than not to be there: below, its sentence begins with "Possibly".
    #[must_use]
    pub fn is_decided(&self) -> bool {
        self.is_of_machine() && self.kind != FaultKind::Other && self.confidence >= POSSIBLE
    }

    /// Returns the recommended action: it follows the confidence.
    #[must_use]
    pub const fn action(&self) -> &'static str {
        if matches!(self.kind, FaultKind::OuterRace | FaultKind::InnerRace | FaultKind::Element | FaultKind::Cage)
            && self.confidence < SURE
        {
            return "Record again within a week, at another speed or load or with a vibration sensor at the bearing, before anything is ordered.";
        }
        self.kind.action()
    }

    /// Adds the data of the figures, with the numbers of the force rose.
    #[must_use]
    pub fn with_figures(mut self, figures: FaultFigures) -> Self {
        self.parameters.force_direction_deg = figures.rose.as_ref().map(|rose| rose.direction_deg);
        self.parameters.force_n = figures.rose.as_ref().map(|rose| rose.peak_n);
        self.parameters.unexplained_motion = figures.motion.as_ref().and_then(|motion| motion.unexplained.clone());
        self.figures = figures;
        self
    }
}

impl Diagnosis {
    /// Returns the diagnosis with a station from the centre of mass replaced by that of the scene's drawing. The sentence is not changed.
    #[must_use]
    pub fn with_station_as_drawn(mut self, scene: &Scene) -> Self {
        let origin_mm = scene.drawn_station(0.0) * 1e3;
        if let Some(station) = &mut self.parameters.station_mm {
            station.value += origin_mm;
            station.low += origin_mm;
            station.high += origin_mm;
        }
        self
    }

    /// Returns true where both name the same fault, whatever its size.
    #[must_use]
    pub fn is_same_fault(&self, other: &Self) -> bool {
        self.kind == other.kind && self.bearing == other.bearing && self.parameters.form == other.parameters.form
    }
}
