//! Shaft angle from a speed: a column of the recording, or the scene's speed.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::total::Total;
use super::{LONGEST_WAIT, Motion, Output, RotationError};
use crate::Row;
use crate::flaws::{Flaw, Position};
use crate::status::SampleStatus;
use ballrace_scene::Speed;

/// Integral of a column of speeds, with a delay of one sample for the acceleration.
pub(super) struct SpeedColumn {
    column: String,
    rate: f64,
    /// Samples before the first speed.
    pub(super) waiting: VecDeque<Row>,
    /// Number and speed of the sample before `held`.
    before: Option<(u64, f64)>,
    held: Option<Held>,
    /// Largest magnitude of a plausible speed, rad/s.
    pub(super) fastest: f64,
    /// The column has magnitudes of speeds below 0.
    is_reversed: bool,
    /// Readings beyond it.
    rejected: u64,
    /// The first of them, rad/s.
    first_rejected: f64,
}

/// Sample without acceleration yet.
struct Held {
    row: Row,
    total: Total,
    speed: f64,
    status: SampleStatus,
}

impl SpeedColumn {
    pub(super) fn new(column: &str, rate: f64) -> Self {
        Self {
            column: column.into(),
            rate,
            waiting: VecDeque::new(),
            before: None,
            held: None,
            fastest: f64::INFINITY,
            is_reversed: false,
            rejected: 0,
            first_rejected: f64::NAN,
        }
    }

    /// Creates the integral of the speed of samples in step with the shaft, which has no sign.
    pub(super) fn synchronous(rate: f64, is_reversed: bool) -> Self {
        Self { is_reversed, ..Self::new("speed", rate) }
    }

    pub(super) fn push(&mut self, mut row: Row, output: &mut Output) -> Result<(), RotationError> {
        if self.is_reversed {
            row.rotation = -row.rotation;
        }
        let known = self.held.as_ref().map(|held| held.speed);
        let rejected = row.rotation.abs() > self.fastest;
        if rejected {
            if self.rejected == 0 {
                self.first_rejected = row.rotation;
            }
            self.rejected += 1;
            output.ledger.record(Flaw::ImplausibleSpeed, Some(&self.column), Position::from(&row), 1);
        }
        // Where there is no plausible speed, the last one holds; before the first, the first.
        let speed = if row.rotation.is_nan() || rejected { known } else { Some(row.rotation) };
        let Some(speed) = speed else {
            self.waiting.push_back(row);
            return if self.waiting.len() < LONGEST_WAIT { Ok(()) } else { Err(self.no_speed()) };
        };
        while let Some(row) = self.waiting.pop_front() {
            let status = SampleStatus::ANGLE_NOT_MEASURED.when(!row.rotation.is_nan());
            self.advance(row, speed, status, output);
        }
        self.advance(row, speed, SampleStatus::ANGLE_NOT_MEASURED.when(rejected), output);
        Ok(())
    }

    pub(super) fn finish(&mut self, output: &mut Output) -> Result<(), RotationError> {
        if !self.waiting.is_empty() {
            return Err(self.no_speed());
        }
        if let Some(held) = self.held.take() {
            let next = (held.row.index, held.speed);
            self.give(held, next, output);
        }
        Ok(())
    }

    fn advance(&mut self, row: Row, speed: f64, status: SampleStatus, output: &mut Output) {
        let mut total = Total::default();
        if let Some(held) = self.held.take() {
            let time = row.index.saturating_sub(held.row.index) as f64 / self.rate;
            total = held.total.plus(Total::of(0.5 * (held.speed + speed) * time / TAU));
            self.give(held, (row.index, speed), output);
        }
        self.held = Some(Held { row, total, speed, status });
    }

    /// Delivers a sample once the speed after it is known.
    fn give(&mut self, held: Held, next: (u64, f64), output: &mut Output) {
        let last = self.before.unwrap_or((held.row.index, held.speed));
        let samples = next.0.saturating_sub(last.0) as f64;
        let acceleration = if samples > 0.0 { (next.1 - last.1) / samples * self.rate } else { 0.0 };
        self.before = Some((held.row.index, held.speed));
        let motion = Motion { total: held.total, speed: held.speed, acceleration };
        output.deliver_with(held.row, motion, held.status);
    }

    fn no_speed(&self) -> RotationError {
        if self.rejected > 0 {
            let (rejected, found, fastest) = (self.rejected, self.first_rejected, self.fastest);
            return RotationError::ImplausibleSpeed { column: self.column.clone(), rejected, found, fastest };
        }
        RotationError::NoSpeed { column: self.column.clone(), samples: self.waiting.len() }
    }
}

/// The scene's speed in closed form. Long times are sample numbers times a step, without rounding.
pub(super) struct SceneSpeed {
    speed: Speed,
    rate: f64,
}

impl SceneSpeed {
    pub(super) const fn new(speed: Speed, rate: f64) -> Self {
        Self { speed, rate }
    }

    pub(super) fn motion(&self, index: u64) -> Motion {
        let time = index as f64 / self.rate;
        match self.speed {
            Speed::Constant(speed) => Motion { total: self.steady(speed / TAU, index), speed, acceleration: 0.0 },
            Speed::Ramp { from, to, over } if time < over => {
                let acceleration = (to - from) / over;
                let total = Total::of((from + 0.5 * acceleration * time) * time / TAU);
                Motion { total, speed: from + acceleration * time, acceleration }
            }
            Speed::Ramp { from, to, over } => {
                let total = self.steady(to / TAU, index).plus(Total::of(0.5 * (from - to) * over / TAU));
                Motion { total, speed: to, acceleration: 0.0 }
            }
            Speed::Fluctuating { mean, fluctuation, frequency } => {
                let (sine, cosine) = self.steady(frequency, index).angle().radians().sin_cos();
                let circular = TAU * frequency;
                let swing = Total::of(mean * fluctuation * sine / circular / TAU);
                Motion {
                    total: self.steady(mean / TAU, index).plus(swing),
                    speed: mean * (1.0 + fluctuation * cosine),
                    acceleration: -mean * fluctuation * circular * sine,
                }
            }
        }
    }

    /// Returns the revolutions up to a sample at constant `turns_per_second`.
    fn steady(&self, turns_per_second: f64, index: u64) -> Total {
        Total::of(turns_per_second / self.rate).times(index)
    }
}
