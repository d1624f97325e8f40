//! Alignment stage: removes the lag between keyphasor and motion.
//!
//! A keyphasor sampled as 0 and 1 gives the shaft angle to one sample at best. Where a revolution is a whole number of samples,
//! averaging over pulses gains nothing. The first revolutions of the motion give the remainder: a least-squares fit of
//! `measured - twin` against the rate of the twin. The lag is limited to half a sample, so it never hides a real phase error.

use ballrace::phase::PhaseDelta;
use ballrace_plant::Twin;
use ballrace_plant::probes::reading;
use ballrace_recording::Sample;
use std::sync::atomic::{AtomicBool, Ordering};

/// Revolutions of the recording from which the lag is computed.
pub const TURNS: f64 = 8.0;
/// Largest number of samples from which the lag is computed.
pub const MAX_SAMPLES: usize = 1 << 16;
/// Smallest lag that is removed, in standard errors.
const SIGNIFICANCE: f64 = 5.0;

/// Alignment of samples with a known lag.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct AlignmentStage {
    /// Lag, s.
    lag: f64,
}

impl AlignmentStage {
    pub(super) const fn new(lag: f64) -> Self {
        Self { lag }
    }

    /// Returns the sample with the lag removed from its shaft angle.
    pub(super) fn align(&self, sample: Sample) -> Sample {
        shifted(sample, self.lag)
    }

    /// Returns the lag as a note of the report; none where there is no lag.
    pub(super) fn note(&self, rate: f64) -> Option<String> {
        (self.lag != 0.0).then(|| {
            format!(
                "Lag removed: {:.1} us ({:.2} samples), within the keyphasor's resolution; found from the first turns.",
                self.lag * 1e6,
                self.lag * rate
            )
        })
    }
}

/// Returns the sample with its shaft angle advanced by `lag` (s).
#[must_use]
pub fn shifted(mut sample: Sample, lag: f64) -> Sample {
    let arc = PhaseDelta::from_radians(sample.speed * lag);
    // The revolution count changes where the shift crosses the mark.
    let turns = sample.angle.revolutions() + arc.radians::<f64>() / std::f64::consts::TAU;
    sample.angle = sample.angle.advanced(arc);
    sample.revolution += turns.floor() as i64;
    sample
}

/// Returns the lag in seconds from the first samples; positive where the machine is ahead of its keyphasor.
///
/// `twin` is at the first sample. Samples after `cancelled` is set are not used.
pub fn lag(samples: &[Sample], twin: &mut dyn Twin, rows: &[Vec<f64>], period: f64, cancelled: &AtomicBool) -> f64 {
    let mut sums = Sums::default();
    for (i, sample) in samples.iter().enumerate() {
        if cancelled.load(Ordering::Relaxed) {
            break;
        }
        sums.add(sample, rows, twin.coordinates(), twin.rates());
        let steps = samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
        let drive = sample.shaft_motion();
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
    fn add(&mut self, sample: &Sample, rows: &[Vec<f64>], coordinates: &[f64], rates: &[f64]) {
        for (row, measured) in rows.iter().zip(&sample.row.probes).filter(|(_, y)| y.is_finite()) {
            let (error, rate) = (measured - reading(row, coordinates), reading(row, rates));
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
