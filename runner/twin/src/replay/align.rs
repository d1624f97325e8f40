//! The lag between keyphasor and motion, removed where the keyphasor cannot tell it.
//!
//! A keyphasor sampled as 0 and 1 places the shaft to one sample at best; where the turns are whole numbers of samples,
//! averaging over pulses gains nothing. The first turns of the motion itself tell the rest: `measured - twin` against
//! the twin's rate gives the lag by least squares. It is bounded by half a sample, so it never hides a real phase error.

use super::pose::reading;
use crate::plant::Twin;
use crate::recording::Sample;
use ballrace::Displacement;
use ballrace::phase::PhaseDelta;
use ballrace::rotor::ShaftMotion;
use std::sync::atomic::{AtomicBool, Ordering};

/// Turns of the recording that the lag is taken from.
pub const TURNS: f64 = 8.0;
/// Most samples of it.
pub const MOST_SAMPLES: usize = 1 << 16;
/// A lag this many standard errors from 0 is removed; a smaller one is left.
const SIGNIFICANCE: f64 = 5.0;

/// The sample with its shaft further by `lag` (s).
#[must_use]
pub fn shifted(mut sample: Sample, lag: f64) -> Sample {
    let arc = PhaseDelta::from_radians(sample.speed * lag);
    // Whole turns change where the shift carries the angle over the mark.
    let turns = sample.angle.revolutions() + arc.radians::<f64>() / std::f64::consts::TAU;
    sample.angle = sample.angle.advanced(arc);
    sample.revolution += turns.floor() as i64;
    sample
}

/// Lag in seconds (positive: the machine is ahead of its keyphasor) from the first samples.
///
/// `twin` stands at the first sample; `rows` are the probes' rows. Samples after `cancelled` is set are not used.
pub fn lag(samples: &[Sample], twin: &mut dyn Twin, rows: &[[f64; 5]], period: f64, cancelled: &AtomicBool) -> f64 {
    let mut sums = Sums::default();
    for (i, sample) in samples.iter().enumerate() {
        if cancelled.load(Ordering::Relaxed) {
            break;
        }
        let (pose, rate) = (twin.pose(), twin.rate());
        sums.add(sample, rows, &pose, &rate);
        let steps = samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
        let drive = ShaftMotion { angle: sample.angle, speed: sample.speed, acceleration: sample.acceleration };
        for k in 0..steps {
            twin.step(&drive.after(k as f64 * period));
        }
    }
    sums.lag().clamp(-0.5 * period, 0.5 * period)
}

#[derive(Default)]
struct Sums {
    n: f64,
    error_rate: f64,
    rate_square: f64,
    error_square: f64,
}

impl Sums {
    fn add(&mut self, sample: &Sample, rows: &[[f64; 5]], pose: &Displacement<f64>, rate: &Displacement<f64>) {
        for (row, measured) in rows.iter().zip(&sample.row.probes).filter(|(_, y)| y.is_finite()) {
            let (error, rate) = (measured - reading(row, pose), reading(row, rate));
            self.n += 1.0;
            self.error_rate += error * rate;
            self.rate_square += rate * rate;
            self.error_square += error * error;
        }
    }

    fn lag(&self) -> f64 {
        if self.rate_square == 0.0 {
            return 0.0;
        }
        let lag = self.error_rate / self.rate_square;
        let left = (self.error_square - lag * self.error_rate).max(0.0) / self.n;
        let standard_error = (left / self.rate_square).sqrt();
        if lag.abs() > SIGNIFICANCE * standard_error { lag } else { 0.0 }
    }
}
