//! The section `[recording]` of a scene: sampling, probes, sensors and the source of the shaft angle.

use super::{Coordinates, Ring, units};
use std::path::PathBuf;

/// `[recording]`: file, sampling and columns of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Path of the recording, a file or a folder, or of the first file of a list, joined to the scene's folder.
    pub file: PathBuf,
    /// Further files of a list.
    pub further_files: Vec<PathBuf>,
    /// Relation of several files to each other.
    pub sequence: Option<Sequence>,
    /// Layout of the table in the file.
    pub layout: FileLayout,
    /// Sampling: a rate or a column of times.
    pub clock: Clock,
    /// Samples averaged into one before anything is computed from the probes; sensors keep the recording's rate.
    pub average: u32,
    /// At least one, unless there are sensors.
    pub probes: Vec<Probe>,
    /// Vibration sensors; at least one, unless there are probes.
    pub sensors: Vec<Sensor>,
    /// Temperatures of bearing rings, which correct the clearance.
    pub temperatures: Vec<TemperatureChannel>,
    /// Source of the shaft angle.
    pub rotation: RotationSource,
    /// `run_out`: path of a recording at slow roll, joined to the scene's folder, whose run-out is subtracted.
    pub run_out: Option<PathBuf>,
}

/// `sequence`: relation of several files to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sequence {
    /// Each file goes on where the one before ends.
    Continuous,
    /// Each file is a short recording of its own.
    Snapshots,
}

/// `temperature = [{ column, unit, bearing, ring }]`: measured temperature of a ring.
#[derive(Debug, Clone, PartialEq)]
pub struct TemperatureChannel {
    /// Column of the recording.
    pub column: String,
    /// K for one unit of the column.
    pub kelvins_per_unit: f64,
    /// Temperature at a reading of 0, K.
    pub zero: f64,
    /// Name of the bearing.
    pub bearing: String,
    /// Ring that is measured.
    pub ring: Ring,
}

/// Sampling: a constant rate or a column of times.
#[derive(Debug, Clone, PartialEq)]
pub enum Clock {
    /// `rate`, Hz
    Rate(f64),
    /// `rate = "file"`: the rate that the file states
    Stated,
    /// `rate = { column, unit }`: a single number of the file
    Number {
        /// Name of the number.
        name: String,
        /// Hz for one unit of the number
        hertz: f64,
    },
    /// `time`: a column
    Column {
        /// Name of the column.
        name: String,
        /// Seconds for one unit of the column; none for seconds, or date and time.
        seconds: Option<f64>,
    },
}

impl Clock {
    /// Returns the clock of a column of seconds, or of date and time.
    #[must_use]
    pub fn column(name: &str) -> Self {
        Self::Column { name: name.to_owned(), seconds: None }
    }
}

/// Layout of the table in a file whose format does not state it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FileLayout {
    /// `header = false`: the first line of a text has values, and the columns are `c0`, `c1`, ...
    pub is_headless: bool,
    /// `orientation` of an array; detected where it is not given.
    pub orientation: Option<Orientation>,
    /// `skip`: number of lines above the header of a text; detected where it is not given.
    pub skip: Option<u32>,
    /// `comment`: first character of lines of a text that are no rows; detected where it is not given.
    pub comment: Option<u8>,
}

/// Dimension of an array along which the samples follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// `"samples-first"`: a row for each sample.
    SamplesFirst,
    /// `"channels-first"`: a row for each channel.
    ChannelsFirst,
}

/// One probe.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Column of the recording; also the probe's name.
    pub column: String,
    /// SI metres for one unit of the column.
    pub metres_per_unit: f64,
    /// m along Z from the rotor's centre of mass (0 for an axial probe when not given, and on a `[system]`)
    pub station: f64,
    /// `coordinates`: of the shaft at the probe, on a `[system]`
    pub coordinates: Option<Coordinates>,
    /// Measured direction.
    pub direction: Direction,
    /// `noise`: rms, m, where given
    pub noise: Option<f64>,
    /// `offset`, m: reading with the shaft in the middle; subtracted from every reading
    pub offset: f64,
    /// `sensitivity`, V/m, of a column in volts; negative where the voltage falls as the shaft moves along the direction
    pub sensitivity: Option<f64>,
}

impl Probe {
    /// Returns the unit of its column; none where the factor is that of no unit.
    pub fn unit(&self) -> Option<&'static str> {
        match self.sensitivity {
            Some(sensitivity) => units::voltage_name(self.metres_per_unit * sensitivity),
            None => units::length_name(self.metres_per_unit),
        }
    }

    /// Returns its reading per unit of each coordinate from the displacement `u v w thu thv` at the probe per unit of each.
    #[must_use]
    pub fn row(&self, displacement: &[Vec<f64>; 5]) -> Vec<f64> {
        let [x, y, z] = match self.direction {
            Direction::Axial => [0.0, 0.0, 1.0],
            Direction::Radial(angle) => [angle.cos(), angle.sin(), 0.0],
        };
        let [u, v, w, ..] = displacement;
        u.iter().zip(v).zip(w).map(|((u, v), w)| x * u + y * v + z * w).collect()
    }
}

/// One sensor of vibration: housing acceleration, velocity or force.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Column of the recording; also the sensor's name.
    pub column: String,
    /// `unit`, for the reader: levels are ratios.
    pub unit: String,
    /// `bearing`: the only bearing that it measures, where given.
    pub bearing: Option<String>,
}

/// Measuring direction of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// rad from +X towards +Y
    Radial(f64),
    /// along +Z
    Axial,
}

impl Direction {
    /// Returns the angle of a radial direction, rad.
    #[must_use]
    pub const fn angle(self) -> Option<f64> {
        match self {
            Self::Radial(angle) => Some(angle),
            Self::Axial => None,
        }
    }
}

/// Source of the shaft angle.
#[derive(Debug, Clone, PartialEq)]
pub enum RotationSource {
    /// `keyphasor = { column, pulses_per_turn, ... }`
    Keyphasor {
        /// Column of the pulse.
        column: String,
        /// 1 or more; on a toothed wheel with a gap, teeth and absent teeth.
        pulses_per_turn: u32,
        /// `missing`: absent teeth of a toothed wheel, one after another; 0 without a gap.
        missing: u32,
        /// Meaning of the column.
        signal: KeyphasorSignal,
    },
    /// `speed = { column, unit }`
    SpeedColumn {
        /// Column of the speed.
        column: String,
        /// rad/s for one unit of the column
        radians_per_second: f64,
    },
    /// `keyphasor = "synchronous"`: the file states the samples per revolution, and its first sample is at angle 0.
    Synchronous,
    /// Neither: the scene's `[shaft] speed` applies, from angle 0.
    Scene,
}

impl RotationSource {
    /// Returns the source of pulses without further keys.
    #[must_use]
    pub fn keyphasor(column: &str, pulses_per_turn: u32) -> Self {
        Self::Keyphasor { column: column.to_owned(), pulses_per_turn, missing: 0, signal: KeyphasorSignal::default() }
    }

    /// Returns the unit of its column; none without a column or a unit.
    pub fn unit(&self) -> Option<&'static str> {
        match self {
            Self::Keyphasor { signal: KeyphasorSignal::Pulses(pulses), .. } => {
                pulses.volts_per_unit.and_then(units::voltage_name)
            }
            Self::Keyphasor { signal: KeyphasorSignal::Instants { seconds }, .. } => units::time_name(*seconds),
            Self::SpeedColumn { radians_per_second, .. } => units::speed_name(*radians_per_second),
            Self::Keyphasor { .. } | Self::Synchronous | Self::Scene => None,
        }
    }

    /// Returns the factor of its column to SI, or 1 for a column without a unit; none without a column, and for instants, which are no
    /// column with a value for each sample.
    #[must_use]
    pub fn factor(&self) -> Option<f64> {
        match self {
            Self::Keyphasor { signal: KeyphasorSignal::Pulses(pulses), .. } => {
                Some(pulses.volts_per_unit.unwrap_or(1.0))
            }
            Self::Keyphasor { signal: KeyphasorSignal::Count, .. } => Some(1.0),
            Self::SpeedColumn { radians_per_second, .. } => Some(*radians_per_second),
            Self::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. } | Self::Synchronous | Self::Scene => None,
        }
    }
}

/// `keyphasor.kind`: meaning of the column of a keyphasor.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyphasorSignal {
    /// Two levels, digital or analogue.
    Pulses(PulseDetection),
    /// Number of pulses so far.
    Count,
    /// Instants of the pulses, a vector with a length of its own: from 0 at the first sample, or in the time of `time`.
    Instants {
        /// Seconds for one unit of the column.
        seconds: f64,
    },
}

/// Instants that are used per revolution of a wheel with as many pulses. The angle is fitted through 11 of them; more instants only add
/// noise to the speed.
pub(crate) const INSTANTS_PER_TURN: u32 = 16;

impl KeyphasorSignal {
    /// Returns the number of pulses of a wheel from one instant that is used to the next.
    #[must_use]
    pub const fn instant_spacing(pulses_per_turn: u32, missing: u32) -> u32 {
        let spacing = pulses_per_turn / INSTANTS_PER_TURN;
        if spacing == 0 || missing > 0 { 1 } else { spacing }
    }
}

impl Default for KeyphasorSignal {
    fn default() -> Self {
        Self::Pulses(PulseDetection::default())
    }
}

/// Detection of pulses; keys without a value are found from the signal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PulseDetection {
    /// `unit`, V
    pub volts_per_unit: Option<f64>,
    /// `threshold`, V, or in the numbers of a column without a unit
    pub threshold: Option<f64>,
    /// `hysteresis`: full width of the band about the threshold, as the threshold
    pub hysteresis: Option<f64>,
    /// `slope`: edge at which a pulse is timed
    pub slope: Option<Slope>,
}

/// Edge of a pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slope {
    /// Upwards through the threshold.
    Rising,
    /// Downwards through the threshold.
    Falling,
}
