//! Where the rotor was at the first sample: the state from which the twin follows the first turns best.

use super::{D, Gains, IdentificationData, Start, model, tune};
use crate::fit::least_squares;
use crate::plant::Plant;
use crate::replay::pose::reading;
use anyhow::Result;
use ballrace::rotor::ShaftMotion;

/// Samples that are looked at.
const SAMPLES: usize = 1024;
/// What is believed of the first state before anything is heard, each within so much: m, m/s, and unknown loads over the
/// rotor's weight.
const ABOUT: [f64; 4] = [50e-6, 50e-3, 1.0, 1.0];
const STATES: usize = 4 * D;

/// Finds the state at the first sample, from what `guess` says it is.
///
/// # Errors
/// What the kernel refuses, a cancelled search.
pub fn start(plant: &Plant, heard: &IdentificationData, noise: &[f64], guess: Start) -> Result<Start> {
    let IdentificationData { samples, rows, period, .. } = *heard;
    let samples = samples.get(..SAMPLES.min(samples.len())).unwrap_or_default();
    let Some(first) = samples.first() else { return Ok(guess) };
    let (lever, weight) = (model::lever(plant), model::weight(plant));
    let unit = |i: usize| {
        let size = ABOUT[i / D] * if i < 2 * D { 1.0 } else { weight };
        let by = if i % D < 3 { 1.0 } else { lever };
        if i < 2 * D { size / by } else { size * by }
    };
    let part = |x: &[f64], from: &[f64; D], first: usize| {
        std::array::from_fn(|i| from[i] + unit(first + i) * x.get(first + i).copied().unwrap_or(0.0))
    };
    let at = |x: &[f64]| Start {
        q: part(x, &guess.q, 0),
        rate: part(x, &guess.rate, D),
        load: part(x, &guess.load, 2 * D),
        turning: part(x, &guess.turning, 3 * D),
    };
    let none = Gains::none();
    let residuals = |x: &[f64]| -> Result<Vec<f64>> {
        heard.go_on()?;
        let mut watch = tune::watch(plant, rows, &none, at(x), first, period)?;
        let mut left = Vec::with_capacity(samples.len() * rows.len() + x.len());
        for (i, sample) in samples.iter().enumerate() {
            let pose = watch.pose();
            for ((row, measured), sigma) in rows.iter().zip(&sample.row.probes).zip(noise) {
                let off = (measured - reading(row, &pose)) / sigma;
                left.push(if off.is_finite() { off } else { 0.0 });
            }
            let steps = samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
            let drive = ShaftMotion { angle: sample.angle, speed: sample.speed, acceleration: sample.acceleration };
            for k in 0..steps {
                watch.sample(&drive.after(k as f64 * period), &[]);
            }
        }
        left.extend_from_slice(x);
        Ok(left)
    };
    Ok(at(&least_squares::solve(vec![0.0; STATES], &residuals, 1e-6, &mut |_| {})?.x))
}
