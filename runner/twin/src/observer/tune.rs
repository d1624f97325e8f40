//! How much the unknown moves: the wander under which the first turns are the most likely.

use super::model::{self, Uncertainty};
use super::{D, Gains, MOST_PROBES, RunningObserverOf, Start, Watch, start};
use crate::plant::{MountedBearing, Plant};
use crate::recording::Sample;
use crate::scene::Speed;
use anyhow::{Result, bail};
use ballrace::rotor::ShaftMotion;
use std::sync::atomic::{AtomicBool, Ordering};

/// What the first turns are.
pub struct IdentificationData<'a> {
    /// In order.
    pub samples: &'a [Sample],
    /// Reading of each probe per unit of each coordinate.
    pub rows: &'a [[f64; D]],
    /// Rms of each probe as the scene gives it, m.
    pub given_noise: &'a [Option<f64>],
    /// From sample to sample, s.
    pub period: f64,
    /// Of the shaft.
    pub speed: Speed,
    /// How far the unknown force wanders where the scene says so, N per root second.
    pub wander: Option<f64>,
    /// Set to end the search with [`Cancelled`].
    pub cancelled: &'a AtomicBool,
}

/// Error returned when the search for an observer is cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the search for the observer was cancelled")]
pub struct Cancelled;

impl IdentificationData<'_> {
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn go_on(&self) -> Result<(), Cancelled> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }
}

/// An observer's making.
#[derive(Clone)]
pub struct TunedObserver {
    /// The gains.
    pub gains: Gains,
    /// The state at the first sample.
    pub start: Start,
    /// Of the unknown force, N per root second.
    pub wander: f64,
    /// Rms of each probe that was reckoned with, m.
    pub noise: Vec<f64>,
}

/// Samples over which the likelihood is taken.
const SAMPLES: usize = 4096;
/// Wanders tried, over the rotor's weight per root second.
const WANDERS: std::ops::RangeInclusive<i32> = -6..=8;
const STRIDE: f64 = 3.162_277_660_168_379_5;
/// Third differences have to show this many times the noise given before they are believed instead.
const LOUDER: f64 = 1.2;
/// Noise that no probe is below, m: a tenth of the last digit of the finest.
const LEAST_NOISE: f64 = 1e-10;

/// Makes the observer of `plant`; `linear` is the same on springs, `guess` where the twin is at the first sample.
///
/// None where the probes do not determine a steady filter: a coordinate that neither a probe nor a bearing holds.
///
/// # Errors
/// More probes than an observer takes, what the kernel refuses.
pub fn tuned(plant: &Plant, linear: &Plant, heard: &IdentificationData, guess: Start) -> Result<Option<TunedObserver>> {
    if heard.rows.len() > MOST_PROBES {
        bail!("recording.probes: found {}, allowed: up to {MOST_PROBES}", heard.rows.len());
    }
    let noise: Vec<f64> =
        (0..heard.rows.len()).map(|p| noise(heard.samples, p, heard.given_noise.get(p).copied().flatten())).collect();
    let start = start::start(plant, heard, &noise, guess)?;
    let weight = model::weight(plant);
    let mut best: Option<(f64, f64, Gains)> = None;
    let ladder = WANDERS.map(|i| weight * STRIDE.powi(i));
    let wanders = heard.wander.map_or_else(|| ladder.collect(), |given| vec![given]);
    for wander in wanders {
        heard.go_on()?;
        let of = Uncertainty::new(&noise, wander, weight);
        let Ok(gains) = Gains::try_new(linear, heard.rows, heard.speed, heard.period, &of) else { continue };
        let unlikely = unlikely(plant, heard, &gains, start)?;
        if best.as_ref().is_none_or(|(least, ..)| unlikely < *least) {
            best = Some((unlikely, wander, gains));
        }
    }
    Ok(best.map(|(_, wander, gains)| TunedObserver { gains, start, wander, noise }))
}

/// Twice the negative logarithm of the likelihood of the innovations, but for a constant.
fn unlikely(plant: &Plant, heard: &IdentificationData, gains: &Gains, start: Start) -> Result<f64> {
    let Some((first, rest)) = heard.samples.split_first() else { return Ok(0.0) };
    let mut watch = watch(plant, heard.rows, gains, start, first, heard.period)?;
    let mut sum = 0.0;
    let mut last = first;
    for sample in rest.iter().take(SAMPLES) {
        let steps = sample.row.index - last.row.index;
        let drive = ShaftMotion { angle: last.angle, speed: last.speed, acceleration: last.acceleration };
        for k in 0..steps {
            let missing = [f64::NAN; MOST_PROBES];
            let readings = if k + 1 == steps { sample.row.probes.as_slice() } else { &missing };
            sum += watch.sample(&drive.after(k as f64 * heard.period), readings).0 + gains.log_determinant;
        }
        last = sample;
    }
    Ok(if sum.is_finite() { sum } else { f64::INFINITY })
}

/// An observer at `sample`.
///
/// # Errors
/// What the kernel refuses.
pub fn watch(
    plant: &Plant,
    rows: &[[f64; D]],
    gains: &Gains,
    start: Start,
    sample: &Sample,
    period: f64,
) -> Result<Box<dyn Watch>> {
    let revolutions = sample.revolution as f64 + sample.angle.revolutions();
    let parts = plant.bearings.iter().map(|seat: &MountedBearing| seat.kinematics.parts_at(revolutions)).collect();
    let task = RunningObserverOf { rows, gains, start, shaft: sample.angle, parts, period };
    Ok(plant.with_rigid(period, task)?)
}

/// Rms of a probe's noise: what the scene gives, or what third differences show where that is clearly more.
///
/// White noise leaves 20 times its variance in them; of motion that is slow against the sampling they keep almost nothing.
#[must_use]
pub fn noise(samples: &[Sample], probe: usize, given: Option<f64>) -> f64 {
    let readings: Vec<f64> = samples.iter().filter_map(|s| s.row.probes.get(probe).copied()).collect();
    let thirds = readings.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).filter(|d| d.is_finite());
    let (sum, count) = thirds.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    let shown = if count > 0.0 { (sum / count / 20.0_f64).sqrt() } else { 0.0 };
    let given = given.unwrap_or(0.0);
    // What is a little more than given is the motion itself.
    let noise = if shown > LOUDER * given { shown } else { given };
    noise.max(LEAST_NOISE)
}
