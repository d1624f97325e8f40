//! The section `[recording]` of a scene: sampling, probes, sensors and the source of the shaft angle.

use super::{Coordinates, Ring};
use std::path::PathBuf;

/// `[recording]`: file, sampling and columns of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Path of the recording, joined to the scene's folder.
    pub file: PathBuf,
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
    /// `time`: a column in seconds
    Column(String),
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
}

impl Probe {
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
    /// `keyphasor = { column, pulses_per_turn }`
    Keyphasor {
        /// Column of the pulse.
        column: String,
        /// 1 or more
        pulses_per_turn: u32,
    },
    /// `speed = { column, unit }`
    SpeedColumn {
        /// Column of the speed.
        column: String,
        /// rad/s for one unit of the column
        radians_per_second: f64,
    },
    /// Neither: the scene's `[shaft] speed` applies, from angle 0.
    Scene,
}
