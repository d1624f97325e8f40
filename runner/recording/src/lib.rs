//! Recordings: from the columns of a file to samples with time, shaft angle and flaws.
#![forbid(unsafe_code)]

mod average;
mod bytes;
mod chain;
pub mod clock;
mod compressed;
mod csv;
pub mod error;
pub mod files;
pub mod flaws;
mod format;
pub mod frames;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod harness;
mod hdf5;
mod instants;
pub mod mat;
mod memory;
mod npy;
mod npz;
mod numbers;
mod parquet;
pub mod parquet_table;
pub mod preview;
pub mod probe;
mod reader;
pub mod rotation;
pub mod run_out;
pub mod slow_roll;
pub mod status;
mod table;
mod tdms;
mod time;
mod uff;
mod wav;
pub mod write;

pub use reader::Reader;
pub use time::Time;

use ballrace::Phase;
use ballrace::rotor::ShaftMotion;
use status::SampleStatus;

/// One sample as read from the file, before the shaft's angle is known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Number of the sample at the nominal rate, from 0; over a gap in the time stamps it rises by more than 1.
    pub index: u64,
    /// Line of the file, for messages; in a file without lines the number of the row, from 1.
    pub line: u64,
    /// Time, s: the time stamp, or index / rate.
    pub time: f64,
    /// Reading of each probe, m, in the scene's order; NaN where there is none.
    pub probes: Vec<f64>,
    /// Reading of each vibration sensor in the unit of its column, in the scene's order; NaN where there is none.
    pub sensors: Vec<f64>,
    /// Reading of each temperature channel, K, in the scene's order; NaN where there is none.
    pub temperatures: Vec<f64>,
    /// Value of the keyphasor or speed column (rad/s), NaN where there is none; 0 when the scene names neither.
    pub rotation: f64,
}

/// One sample with angle, speed and acceleration of the shaft.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sample {
    /// Row of the file.
    pub row: Row,
    /// Shaft angle: 0 where the keyphasor first passes.
    pub angle: Phase,
    /// Whole turns below `angle` since the keyphasor first passed: total revolutions = `revolution + angle`, so -1
    /// before the first pulse of a shaft that turns forward.
    pub revolution: i64,
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// Angular acceleration of the shaft, rad/s^2.
    pub acceleration: f64,
    /// Flags of reading and angle.
    pub status: SampleStatus,
}

impl Sample {
    /// Becomes a copy of `other` in its own memory.
    pub fn copy_from(&mut self, other: &Self) {
        let Row { mut probes, mut sensors, mut temperatures, .. } = std::mem::take(&mut self.row);
        let &Row { index, line, time, rotation, .. } = &other.row;
        probes.clone_from(&other.row.probes);
        sensors.clone_from(&other.row.sensors);
        temperatures.clone_from(&other.row.temperatures);
        let &Self { angle, revolution, speed, acceleration, status, .. } = other;
        let row = Row { index, line, time, probes, sensors, temperatures, rotation };
        *self = Self { row, angle, revolution, speed, acceleration, status };
    }

    /// Returns angle, speed and acceleration of the shaft.
    #[must_use]
    pub const fn shaft_motion(&self) -> ShaftMotion<f64> {
        ShaftMotion { angle: self.angle, speed: self.speed, acceleration: self.acceleration }
    }

    /// Returns the revolutions of the shaft since the keyphasor first passed.
    #[must_use]
    pub fn total_revolutions(&self) -> f64 {
        self.revolution as f64 + self.angle.revolutions()
    }
}
