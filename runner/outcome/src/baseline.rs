//! Baseline: the residual of a healthy machine, written by `--learn` and read by `--baseline`.

use crate::calibration::Calibration;
use crate::diagnosis::Diagnosis;
use crate::fault::{FaultForm, FaultKind};
use ballrace_base::bounded::read_text;
use ballrace_scene::{Probe, Sensor};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const UM: f64 = 1e6;
/// Version of the file format.
const FORMAT: u32 = 1;
/// Largest length of the file, bytes.
const LARGEST_FILE: u64 = 64 << 20;

/// Error returned when a baseline cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    /// The file cannot be read.
    #[error("{}: this baseline cannot be read", file.display())]
    Read {
        /// The baseline.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not a baseline.
    #[error("{}:{}: no baseline: {error}, expected a file written by replay --learn", file.display(), error.line())]
    Format {
        /// The file.
        file: PathBuf,
        /// First error in its text. Not a `source`: the message contains it.
        error: serde_json::Error,
    },
    /// The baseline was learned with another scene.
    #[error(
        "{}: baseline of other probes or bearings: of scene {scene:?}, expected one learned with this scene",
        file.display()
    )]
    OtherScene {
        /// The baseline.
        file: PathBuf,
        /// Name of its scene.
        scene: String,
    },
}

/// Residual of a reference recording, probe by probe.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Version of the file format.
    pub ballrace_baseline: u32,
    /// Name of the scene.
    pub scene: String,
    /// Name of the recording.
    pub recording: String,
    /// Orders of the followed lines.
    pub orders: Vec<f64>,
    /// Probes in the order of the scene.
    pub probes: Vec<BaselineProbe>,
    /// The residual is that of a synchronised twin, and so is that of recordings compared with it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub synchronised: bool,
    /// Calibrated parameters of the healthy machine; `None` if the recording does not determine them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// Faults that the machine already had.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<KnownFault>,
    /// Vibration sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<BaselineSensor>,
}

/// A fault that a machine had when its baseline was learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownFault {
    /// Kind.
    pub kind: FaultKind,
    /// Bearing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Form of a surface fault.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<FaultForm>,
    /// Size in the unit of its kind, as [`FaultParameters::size`](crate::FaultParameters::size).
    pub size: f64,
}

/// Growth of a fault beyond which it is reported again.
const GROWTH: f64 = 1.25;

/// Baseline of one vibration sensor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineSensor {
    /// Column.
    pub name: String,
    /// Modulation of the envelope, for outer race, inner race, element and cage of each bearing.
    pub modulations: Vec<f64>,
    /// Root mean square about the mean, in the unit of the sensor; 0 in older files.
    #[serde(default)]
    pub rms: f64,
    /// Amplitude at the first multiples of the shaft speed, in the unit of the sensor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shaft_lines: Vec<f64>,
}

/// Baseline of one probe.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineProbe {
    /// Column.
    pub name: String,
    /// Rms of the residual about its mean.
    pub residual_rms_um: f64,
    /// Amplitude of each followed line in the residual, zero to peak.
    pub lines_um: Vec<f64>,
    /// Amplitude of each followed line in the motion, zero to peak.
    #[serde(default)]
    pub motion_lines_um: Vec<f64>,
}

impl Baseline {
    /// Creates the baseline of a vibration recording.
    #[must_use]
    pub fn of_sensors(scene: &str, recording: &str, sensors: Vec<BaselineSensor>) -> Self {
        let (scene, recording) = (scene.to_owned(), recording.to_owned());
        Self { ballrace_baseline: FORMAT, scene, recording, sensors, ..Self::default() }
    }

    /// Creates the baseline of a displacement recording.
    #[must_use]
    pub fn of_probes(scene: &str, recording: &str, orders: Vec<f64>, probes: Vec<BaselineProbe>) -> Self {
        let (scene, recording) = (scene.to_owned(), recording.to_owned());
        Self { ballrace_baseline: FORMAT, scene, recording, orders, probes, ..Self::default() }
    }

    /// Reads the baseline of a scene with these sensors.
    ///
    /// # Errors
    /// Returns the errors of [`Baseline::read`].
    pub fn read_sensors(path: &Path, sensors: &[Sensor]) -> Result<Self, BaselineError> {
        let found = Self::parse(path)?;
        if found.is_of_sensors(sensors) { Ok(found) } else { Err(found.of_others(path)) }
    }

    fn is_of_sensors(&self, sensors: &[Sensor]) -> bool {
        self.sensors.iter().map(|s| &s.name).eq(sensors.iter().map(|s| &s.column))
    }

    /// Stores the faults of the machine.
    pub fn set_faults(&mut self, diagnoses: &[Diagnosis]) {
        let known = |diagnosis: &Diagnosis| {
            let (bearing, form) = (diagnosis.bearing.clone(), diagnosis.parameters.form);
            Some(KnownFault { kind: diagnosis.kind, bearing, form, size: diagnosis.parameters.size()?.0.value })
        };
        self.faults = diagnoses.iter().filter_map(known).collect();
    }

    /// Returns true for a fault that the machine had when the baseline was learned, and that has not grown by more than 25 %.
    #[must_use]
    pub fn contains_fault(&self, diagnosis: &Diagnosis) -> bool {
        let same = |known: &KnownFault| {
            let is_larger = diagnosis.parameters.size().is_none_or(|(size, _)| size.value > GROWTH * known.size);
            known.kind == diagnosis.kind
                && known.bearing == diagnosis.bearing
                && known.form == diagnosis.parameters.form
                && !is_larger
        };
        self.faults.iter().any(same)
    }

    /// Returns the modulation of family `k` at sensor `i`.
    #[must_use]
    pub fn modulation(&self, i: usize, k: usize) -> f64 {
        self.sensors.get(i).and_then(|s| s.modulations.get(k)).copied().unwrap_or(0.0)
    }

    /// Reads a baseline of any scene.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is not a baseline.
    pub fn parse(path: &Path) -> Result<Self, BaselineError> {
        let file = || path.to_owned();
        let text = read_text(path, LARGEST_FILE).map_err(|source| BaselineError::Read { file: file(), source })?;
        let found: Self = serde_json::from_str(&text).map_err(|error| BaselineError::Format { file: file(), error })?;
        if found.ballrace_baseline == FORMAT { Ok(found) } else { Err(found.of_others(path)) }
    }

    fn of_others(&self, path: &Path) -> BaselineError {
        BaselineError::OtherScene { file: path.to_owned(), scene: self.scene.clone() }
    }

    /// Reads the baseline of a scene with these probes and sensors, whose followed lines have these orders. A baseline without
    /// sensors is accepted: the sensors are then evaluated without one.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not a baseline, or was learned with other probes, sensors or bearings.
    pub fn read(path: &Path, probes: &[Probe], sensors: &[Sensor], orders: &[f64]) -> Result<Self, BaselineError> {
        let found = Self::parse(path)?;
        let same_probes = found.probes.iter().map(|p| &p.name).eq(probes.iter().map(|p| &p.column));
        // The cages of two recordings slip differently.
        let close = |(a, b): (&f64, &f64)| (a - b).abs() < 0.1 * b.abs().max(1.0);
        let same_lines = found.orders.len() == orders.len() && found.orders.iter().zip(orders).all(close);
        let whole = found.probes.iter().all(|p| p.lines_um.len() == found.orders.len());
        let same_sensors = found.sensors.is_empty() || found.is_of_sensors(sensors);
        if same_probes && same_sensors && same_lines && whole { Ok(found) } else { Err(found.of_others(path)) }
    }

    /// Returns the amplitude of a line in the residual of a probe, m.
    #[must_use]
    pub fn line(&self, line: usize, probe: usize) -> f64 {
        self.probes.get(probe).and_then(|p| p.lines_um.get(line)).copied().unwrap_or(0.0) / UM
    }

    /// Returns the amplitude of a line in the motion at a probe, m.
    #[must_use]
    pub fn motion_line(&self, line: usize, probe: usize) -> f64 {
        self.probes.get(probe).and_then(|p| p.motion_lines_um.get(line)).copied().unwrap_or(0.0) / UM
    }

    /// Returns the residual of a probe about its mean, rms, m.
    #[must_use]
    pub fn residual(&self, probe: usize) -> f64 {
        self.probes.get(probe).map_or(0.0, |p| p.residual_rms_um) / UM
    }
}
