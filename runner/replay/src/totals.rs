//! Time, revolutions and speed of a replay.

use super::statistics::Running;
use ballrace_outcome::Record;
use std::f64::consts::TAU;

/// Time, revolutions and speed of the processed samples.
#[derive(Default)]
pub(super) struct Totals {
    speed: Running,
    /// Time of the first sample, s.
    first_time: f64,
    /// Time of the last sample, s.
    pub(super) last_time: f64,
    revolutions: f64,
}

impl Totals {
    /// Adds a sample at `time` (s) with the shaft speed (rad/s) and the revolutions since the last sample.
    pub(super) fn add(&mut self, time: f64, speed: f64, revolutions: f64) {
        if self.speed.count() == 0.0 {
            self.first_time = time;
        }
        self.last_time = time;
        self.revolutions += revolutions;
        self.speed.add(speed);
    }

    /// Returns the speed over the samples, rad/s.
    pub(super) const fn speed(&self) -> &Running {
        &self.speed
    }

    /// Returns the record of duration, revolutions and speed; its other entries are those of no sample.
    pub(super) fn record(&self) -> Record {
        let rpm = |w: f64| w * 60.0 / TAU;
        let (slow, fast) = self.speed.extremes();
        Record {
            duration_s: self.last_time - self.first_time,
            turns: self.revolutions,
            mean_speed_rpm: rpm(self.speed.mean()),
            min_speed_rpm: rpm(slow),
            max_speed_rpm: rpm(fast),
            ..Record::default()
        }
    }
}
