//! Initial state of the observer: the state from which the model follows the first revolutions best.

use super::model::{self, Levers};
use super::{Gains, IdentificationData, InitialState, estimator};
use crate::Plant;
use crate::error::Result;
use crate::probes::reading;
use ballrace_base::least_squares::{self, Limits};
use nalgebra::{DMatrix, DVector};

/// Number of samples in the fit.
const SAMPLES: usize = 1024;
/// Numbers of samples in fits that each start from the one before: up to [`DESCRIBED`], and beyond where the fit of all samples from the guess
/// fails. Over a few samples any motion is nearly linear in its first state, while a chaotic one over many is not.
const FEW_FIRST: [usize; 6] = [32, 64, 128, 256, 512, SAMPLES];
/// Samples over which the scene describes the machine before the fit of all samples is tried.
const DESCRIBED: usize = 128;
/// Mean square of the residual over the noise above which a fit has failed: as for an observer that is not trusted.
const FAILED: f64 = 4.0;
/// Prior standard deviations of the first state: m, m/s, and unknown loads over the weight of the rotor.
const PRIOR: [f64; 4] = [50e-6, 50e-3, 1.0, 1.0];
/// Fall of chi-squared per iteration below which the fit ends: it is not significant.
const MIN_FALL: f64 = 0.5;

/// Finds the state at the first sample, starting from `guess`.
///
/// # Errors
/// Returns an error if the kernel rejects the plant or the search is cancelled.
pub fn start(plant: &Plant, data: &IdentificationData, noise: &[f64], guess: InitialState) -> Result<InitialState> {
    let IdentificationData { samples, rows, period, .. } = *data;
    let Some(first) = samples.first() else { return Ok(guess) };
    let (levers, weight) = (Levers::new(plant)?, model::weight(plant)?);
    let (loads, rotating) = (model::loads(plant), model::rotating_loads(plant));
    let n = plant.layout.order;
    let lengths = |size: f64| levers.coordinates.iter().map(move |lever| size / lever);
    let forces = |size: f64| levers.loads.iter().map(move |lever| size * weight * lever);
    let [position, rate, load, turning] = PRIOR;
    let units: Vec<f64> = lengths(position).chain(lengths(rate)).chain(forces(load)).chain(forces(turning)).collect();
    let at = |x: &[f64]| {
        let x: Vec<f64> = x.iter().zip(&units).map(|(x, unit)| x * unit).collect();
        let (q, x) = x.split_at(n);
        let (rate, x) = x.split_at(n);
        let (load, turning) = x.split_at(model::LOADS);
        let sum = |from: &[f64], x: &[f64]| from.iter().zip(x).map(|(a, b)| a + b).collect();
        let spread = |of: &DMatrix<f64>, x: &[f64]| (of * DVector::from_column_slice(x)).as_slice().to_vec();
        InitialState {
            q: sum(&guess.q, q),
            rate: sum(&guess.rate, rate),
            load: sum(&guess.load, &spread(&loads, load)),
            turning: sum(&guess.turning, &spread(&rotating, turning)),
        }
    };
    let no_gains = Gains::none(n);
    let residuals = |x: &[f64], count: usize| -> Result<Vec<f64>> {
        data.check_cancelled()?;
        let samples = samples.get(..count.min(samples.len())).unwrap_or_default();
        let mut estimator = estimator(plant, rows, &no_gains, at(x), first, period)?;
        let mut left = Vec::with_capacity(samples.len() * rows.len() + x.len());
        for (i, sample) in samples.iter().enumerate() {
            let position = estimator.coordinates();
            for ((row, measured), sigma) in rows.iter().zip(&sample.row.probes).zip(noise) {
                let off = (measured - reading(row, position)) / sigma;
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
    let limits = Limits::none(units.len(), MIN_FALL);
    let fit = |from: &[f64], count: usize| -> Result<Vec<f64>> {
        Ok(least_squares::solve(from, &limits, &|x: &[f64]| residuals(x, count), &|_| {})?.point.x)
    };
    let is_good = |x: &[f64], count: usize| -> Result<bool> {
        let left = residuals(x, count)?;
        Ok(left.iter().map(|r| r * r).sum::<f64>() < FAILED * left.len() as f64)
    };
    let from_guess = |count: usize| fit(&vec![0.0; units.len()], count);
    let mut best: Option<Vec<f64>> = None;
    for count in FEW_FIRST {
        let closer = best.as_ref().map_or_else(|| from_guess(count), |best| fit(best, count))?;
        // A machine that the scene does not describe is followed no longer than this.
        if !is_good(&closer, count)? {
            break;
        }
        best = Some(closer);
        if count == DESCRIBED {
            let all = from_guess(SAMPLES)?;
            if is_good(&all, SAMPLES)? {
                return Ok(at(&all));
            }
        }
    }
    Ok(at(&best.map_or_else(|| from_guess(SAMPLES), Ok)?))
}
