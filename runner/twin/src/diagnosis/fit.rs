//! Maximum-likelihood fit of a few unknowns of a machine: Levenberg-Marquardt on the residual at the probes.

use super::Result;
use super::machine::{Machine, Part, Unknown};
use super::residual::{Evidence, Spectra};
use nalgebra::{DMatrix, DVector};

/// A machine with its unknowns fitted.
#[derive(Clone)]
pub struct Fitted {
    pub machine: Machine,
    pub unknowns: Vec<Unknown>,
    pub spectra: Spectra,
    pub residual: Vec<f64>,
    /// Sum of the squares of the residual, in units of the noise.
    pub chi_square: f64,
    /// Inverse of the normal matrix of the unknowns, in their units.
    pub covariance: DMatrix<f64>,
}

pub fn square(r: &[f64]) -> f64 {
    dot(r, r)
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight sums side by side.
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 8];
    for (a, b) in a8.zip(b8) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Returns the machine as it is.
pub fn evaluate(e: &Evidence, machine: &Machine) -> Result<Fitted> {
    let spectra = e.spectra(machine)?;
    let residual = e.residual(&spectra);
    let chi_square = square(&residual);
    Ok(Fitted {
        machine: machine.clone(),
        unknowns: vec![],
        spectra,
        residual,
        chi_square,
        covariance: DMatrix::zeros(0, 0),
    })
}

/// Returns another machine; parts that are as before are not evaluated again.
pub fn changed(e: &Evidence, before: &Fitted, machine: &Machine) -> Result<Fitted> {
    let mut spectra = before.spectra.clone();
    for (i, (old, new)) in before.machine.bearings.iter().zip(&machine.bearings).enumerate() {
        if old != new {
            spectra = e.changed(&spectra, machine, Part::Bearing(i))?;
        }
    }
    let of_rotor = |m: &Machine| (m.load, m.damping, m.unbalance);
    if of_rotor(&before.machine) != of_rotor(machine) {
        spectra = e.changed(&spectra, machine, Part::Rotor)?;
    }
    let residual = e.residual(&spectra);
    let chi_square = square(&residual);
    Ok(Fitted { machine: machine.clone(), spectra, residual, chi_square, ..before.clone() })
}

/// Fall of chi-squared in a step below which a fit ends.
const LEAST_FALL: f64 = 0.5;
/// The same, over the excess of chi-squared.
const LEAST_SHARE: f64 = 1e-3;
/// Dampings tried in a step.
const DAMPINGS: usize = 6;

/// Fits `unknowns` from `start`.
pub fn fit(e: &Evidence, start: &Fitted, unknowns: &[Unknown], iterations: usize) -> Result<Fitted> {
    let n = unknowns.len();
    if n == 0 {
        return evaluate(e, &start.machine);
    }
    let mut now = Fitted { unknowns: unknowns.to_vec(), ..start.clone() };
    let mut damping = 1e-4;
    let mut inverse = DMatrix::zeros(n, n);
    for _ in 0..iterations {
        let slopes = unknowns.iter().map(|u| e.slope(&now.spectra, &now.machine, *u)).collect::<Result<Vec<_>>>()?;
        let mut normal = DMatrix::from_fn(n, n, |i, j| if i <= j { dot(&slopes[i], &slopes[j]) } else { 0.0 });
        for i in 0..n {
            for j in 0..i {
                normal[(i, j)] = normal[(j, i)];
            }
        }
        // An unknown that the recording does not determine keeps its value.
        for (i, u) in unknowns.iter().enumerate() {
            normal[(i, i)] += e.longest_step(*u).powi(-2);
        }
        let gradient = DVector::from_fn(n, |i, _| dot(&slopes[i], &now.residual));
        // Scaled to a unit diagonal.
        let scale: Vec<f64> = (0..n).map(|i| normal[(i, i)].max(1e-300).sqrt()).collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        let right = DVector::from_fn(n, |i, _| gradient[i] / scale[i]);
        inverse = scaled.clone().try_inverse().unwrap_or_else(|| DMatrix::identity(n, n));
        inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let mut improved = None;
        for _ in 0..DAMPINGS {
            let damped = &scaled + DMatrix::identity(n, n) * damping;
            let Some(step) = damped.lu().solve(&right) else { break };
            let mut machine = now.machine.clone();
            let excess = unknowns.iter().enumerate().map(|(i, u)| (step[i] / scale[i]).abs() / e.longest_step(*u));
            let shorten = 1.0 / excess.fold(1.0, f64::max);
            for (i, u) in unknowns.iter().enumerate() {
                u.set(&mut machine, u.get(&now.machine) - shorten * step[i] / scale[i]);
            }
            let next = changed(e, &now, &machine)?;
            if next.chi_square < now.chi_square {
                improved = Some(next);
                damping = (damping * 0.1).max(1e-9);
                break;
            }
            damping = (damping * 10.0).max(1e-6);
        }
        let Some(next) = improved else { break };
        let fall = now.chi_square - next.chi_square;
        now = Fitted { unknowns: unknowns.to_vec(), ..next };
        // Far from the recording, a small share of what is left decides nothing.
        if fall < LEAST_FALL + LEAST_SHARE * (now.chi_square - now.residual.len() as f64).max(0.0) {
            break;
        }
    }
    now.covariance = inverse;
    Ok(now)
}
