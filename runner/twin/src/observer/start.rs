//! Initial state of the observer: the state from which the model follows the first revolutions best.

use super::{D, Gains, IdentificationData, InitialState, model, tune};
use crate::error::Result;
use crate::least_squares;
use crate::plant::Plant;
use crate::probes::reading;

/// Number of samples in the fit.
const SAMPLES: usize = 1024;
/// Prior standard deviations of the first state: m, m/s, and unknown loads over the weight of the rotor.
const PRIOR: [f64; 4] = [50e-6, 50e-3, 1.0, 1.0];
/// Share of the sum of squares by which an iteration reduces it at least: about 0.5 of the few thousand that noise alone leaves, which decides nothing.
const LEAST_FALL: f64 = 1e-4;
const STATES: usize = 4 * D;

/// Finds the state at the first sample, starting from `guess`.
///
/// # Errors
/// A plant that the kernel rejects, a cancelled search.
pub fn start(plant: &Plant, data: &IdentificationData, noise: &[f64], guess: InitialState) -> Result<InitialState> {
    let IdentificationData { samples, rows, period, .. } = *data;
    let samples = samples.get(..SAMPLES.min(samples.len())).unwrap_or_default();
    let Some(first) = samples.first() else { return Ok(guess) };
    let (lever, weight) = (model::lever(plant), model::weight(plant));
    let unit = |i: usize| {
        let size = PRIOR[i / D] * if i < 2 * D { 1.0 } else { weight };
        let by = if i % D < 3 { 1.0 } else { lever };
        if i < 2 * D { size / by } else { size * by }
    };
    let part = |x: &[f64], from: &[f64; D], first: usize| {
        std::array::from_fn(|i| from[i] + unit(first + i) * x.get(first + i).copied().unwrap_or(0.0))
    };
    let at = |x: &[f64]| InitialState {
        q: part(x, &guess.q, 0),
        rate: part(x, &guess.rate, D),
        load: part(x, &guess.load, 2 * D),
        turning: part(x, &guess.turning, 3 * D),
    };
    let none = Gains::none();
    let residuals = |x: &[f64]| -> Result<Vec<f64>> {
        data.check_cancelled()?;
        let mut estimator = tune::estimator(plant, rows, &none, at(x), first, period)?;
        let mut left = Vec::with_capacity(samples.len() * rows.len() + x.len());
        for (i, sample) in samples.iter().enumerate() {
            let position = estimator.position();
            for ((row, measured), sigma) in rows.iter().zip(&sample.row.probes).zip(noise) {
                let off = (measured - reading(row, &position)) / sigma;
                left.push(if off.is_finite() { off } else { 0.0 });
            }
            let steps = samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
            let drive = sample.shaft_motion();
            for k in 0..steps {
                estimator.step(&drive.after(k as f64 * period), &[]);
            }
        }
        left.extend_from_slice(x);
        Ok(left)
    };
    Ok(at(&least_squares::solve(vec![0.0; STATES], &residuals, LEAST_FALL, &mut |_| {})?.x))
}
