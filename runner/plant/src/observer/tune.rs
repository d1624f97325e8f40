//! Identification of the observer: the process noise of the unknown force under which the first revolutions are most likely.

use super::model::{self, Uncertainty};
use super::{Gains, InitialState, MAX_PROBES, estimator, gate, start, wide_gate};
use crate::Plant;
use crate::error::{ObserverError, Result};
use ballrace_recording::Sample;
use ballrace_scene::Speed;
use std::sync::atomic::{AtomicBool, Ordering};

/// Data from which an observer is identified.
pub struct IdentificationData<'a> {
    /// Samples of the first revolutions, in order.
    pub samples: &'a [Sample],
    /// Reading of each probe per unit of each coordinate.
    pub rows: &'a [Vec<f64>],
    /// Rms noise of each probe where the scene gives it, m.
    pub given_noise: &'a [Option<f64>],
    /// Sample period, s.
    pub period: f64,
    /// Speed of the shaft.
    pub speed: Speed,
    /// Process noise of the unknown force where the scene gives it, N per root second.
    pub process_noise: Option<f64>,
    /// The motion repeats: two twins of the scene end in the same one.
    pub repeats: bool,
    /// Set to end the search with [`ObserverError::Cancelled`].
    pub cancelled: &'a AtomicBool,
}

impl IdentificationData<'_> {
    /// Returns an error if the search is cancelled.
    pub(super) fn check_cancelled(&self) -> Result<(), ObserverError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(ObserverError::Cancelled) } else { Ok(()) }
    }
}

/// Result of the identification.
#[derive(Clone)]
pub struct TunedObserver {
    /// Gains of the filter.
    pub gains: Gains,
    /// State at the first sample.
    pub start: InitialState,
    /// Process noise of the unknown force, N per root second.
    pub process_noise: f64,
    /// Rms noise of each probe, m.
    pub noise: Vec<f64>,
    /// Largest normalised innovation squared that corrects it.
    pub gate: f64,
}

/// Number of samples in the likelihood.
const SAMPLES: usize = 4096;
/// Exponents of the process noises: powers of [`STRIDE`] times the weight of the rotor per root second. The likelihood has one
/// maximum over them: every third is tried, then the neighbours of the best.
const PROCESS_NOISES: std::ops::RangeInclusive<i32> = -6..=8;
const COARSE: i32 = 3;
const STRIDE: f64 = 3.162_277_660_168_379_5;
/// Ratio of the noise by third differences to the given noise above which the former is used.
const LARGER_NOISE: f64 = 1.2;
/// Lower bound of the noise of a probe, m: a tenth of the resolution of the finest.
const MIN_NOISE: f64 = 1e-10;

/// Observer with one process noise.
struct Candidate {
    /// Twice the negative logarithm of its likelihood.
    cost: f64,
    exponent: i32,
    process_noise: f64,
    gains: Gains,
}

/// Identifies the observer of `plant`; `linear` is the same plant on linear springs, `guess` the state of the twin at the first
/// sample.
///
/// Returns `None` if no steady filter exists because neither a probe nor a bearing determines some coordinate.
///
/// # Errors
/// Returns an error for more probes than an observer has room for, if the kernel rejects the plant, or if the search is cancelled.
pub fn identify(
    plant: &Plant,
    linear: &Plant,
    data: &IdentificationData,
    guess: InitialState,
) -> Result<Option<TunedObserver>> {
    if data.rows.len() > MAX_PROBES {
        return Err(ObserverError::Probes { found: data.rows.len(), most: MAX_PROBES }.into());
    }
    let noise: Vec<f64> =
        (0..data.rows.len()).map(|p| noise(data.samples, p, data.given_noise.get(p).copied().flatten())).collect();
    let start = start::start(plant, data, &noise, guess)?;
    let weight = model::weight(plant)?;
    let mut best: Option<Candidate> = None;
    let try_one = |best: &mut Option<Candidate>, exponent: i32, process_noise: f64| -> Result<()> {
        data.check_cancelled()?;
        let slow = Uncertainty::new(&noise, process_noise, weight);
        let of = if data.repeats { slow } else { slow.with_unbalance(weight) };
        let Ok(mut gains) = Gains::try_new(linear, data.rows, data.speed, data.period, &of) else { return Ok(()) };
        if !data.repeats && model::is_axially_unmeasured(plant, data.rows) {
            gains.leave_axial();
        }
        let cost = negative_log_likelihood(plant, data, &gains, &start)?;
        if best.as_ref().is_none_or(|best| cost < best.cost) {
            *best = Some(Candidate { cost, exponent, process_noise, gains });
        }
        Ok(())
    };
    match data.process_noise {
        Some(given) => try_one(&mut best, 0, given)?,
        None => {
            let by_exponent = |i: i32| weight * STRIDE.powi(i);
            for i in PROCESS_NOISES.step_by(COARSE as usize) {
                try_one(&mut best, i, by_exponent(i))?;
            }
            let coarse = best.as_ref().map_or(0, |best| best.exponent);
            for i in (coarse - COARSE + 1..coarse + COARSE).filter(|i| *i != coarse && PROCESS_NOISES.contains(i)) {
                try_one(&mut best, i, by_exponent(i))?;
            }
        }
    }
    let gate = if data.repeats { gate(noise.len()) } else { wide_gate(noise.len()) };
    Ok(best.map(|Candidate { process_noise, gains, .. }| TunedObserver { gains, start, process_noise, noise, gate }))
}

/// Returns twice the negative logarithm of the likelihood of the innovations, up to a constant.
fn negative_log_likelihood(
    plant: &Plant,
    data: &IdentificationData,
    gains: &Gains,
    start: &InitialState,
) -> Result<f64> {
    let Some((first, rest)) = data.samples.split_first() else { return Ok(0.0) };
    let mut estimator = estimator(plant, data.rows, gains, start.clone(), first, data.period)?;
    let mut sum = 0.0;
    let mut last = first;
    for sample in rest.iter().take(SAMPLES) {
        let steps = sample.row.index - last.row.index;
        let drive = last.shaft_motion();
        for k in 0..steps {
            let missing = [f64::NAN; MAX_PROBES];
            let readings = if k + 1 == steps { sample.row.probes.as_slice() } else { &missing };
            sum += estimator.step(&drive.after(k as f64 * data.period), readings).0 + gains.log_determinant;
        }
        last = sample;
    }
    Ok(if sum.is_finite() { sum } else { f64::INFINITY })
}

/// Returns the rms noise of a probe: the given one, or that of the third differences where it is clearly larger.
///
/// Third differences of white noise have 20 times its variance; they suppress motion that is slow against the sample rate.
#[must_use]
pub fn noise(samples: &[Sample], probe: usize, given: Option<f64>) -> f64 {
    let readings: Vec<f64> = samples.iter().filter_map(|s| s.row.probes.get(probe).copied()).collect();
    let thirds = readings.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).filter(|d| d.is_finite());
    let (sum, count) = thirds.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    let shown = if count > 0.0 { (sum / count / 20.0_f64).sqrt() } else { 0.0 };
    let given = given.unwrap_or(0.0);
    // A small excess over the given noise is motion.
    let noise = if shown > LARGER_NOISE * given { shown } else { given };
    noise.max(MIN_NOISE)
}
