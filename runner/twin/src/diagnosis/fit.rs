//! Maximum-likelihood fit of a few unknowns of a machine: Levenberg-Marquardt on the residual at the probes.

use super::Result;
use super::machine::{ForceSource, Machine, Unknown};
use super::residual::{Evidence, Spectra, dot};
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
            spectra = e.changed(&spectra, machine, ForceSource::Bearing(i))?;
        }
    }
    let of_rotor = |m: &Machine| (m.load, m.damping, m.unbalance);
    if of_rotor(&before.machine) != of_rotor(machine) {
        // It may move the bearings.
        spectra = e.changed(&spectra, machine, ForceSource::Rotor)?;
    }
    let residual = e.residual(&spectra);
    let chi_square = square(&residual);
    Ok(Fitted { machine: machine.clone(), spectra, residual, chi_square, ..before.clone() })
}

/// Fall of chi-squared in a step below which a fit ends.
pub const MIN_FALL: f64 = 0.5;
/// The same, over the excess of chi-squared.
const MIN_SHARE: f64 = 1e-3;
/// Dampings tried in a step.
const DAMPINGS: usize = 6;

/// A normal distribution of some unknowns, known before the recording.
pub struct Prior {
    pub unknowns: Vec<Unknown>,
    pub mean: DVector<f64>,
    /// Inverse of the covariance.
    pub precision: DMatrix<f64>,
}

impl Prior {
    fn distance(&self, machine: &Machine) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|u| u.get(machine))) - &self.mean
    }

    /// Returns minus twice the logarithm of the density, but for a constant.
    fn chi_square(&self, machine: &Machine) -> f64 {
        let distance = self.distance(machine);
        distance.dot(&(&self.precision * &distance))
    }

    /// Adds its part of the normal equations of `unknowns`.
    fn add(&self, machine: &Machine, unknowns: &[Unknown], normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        let pull = &self.precision * self.distance(machine);
        let at: Vec<Option<usize>> = self.unknowns.iter().map(|own| unknowns.iter().position(|u| u == own)).collect();
        for (a, i) in at.iter().enumerate().filter_map(|(a, i)| Some((a, (*i)?))) {
            gradient[i] += pull[a];
            for (b, j) in at.iter().enumerate().filter_map(|(b, j)| Some((b, (*j)?))) {
                normal[(i, j)] += self.precision[(a, b)];
            }
        }
    }
}

/// How machines are held against a recording.
#[derive(Clone, Copy, PartialEq)]
enum Weights {
    /// By the weights of the evidence: differences of the force decide.
    Given,
    /// By those of each machine.
    Own,
}

impl Weights {
    fn residual(self, e: &Evidence, machine: &Machine, spectra: &Spectra) -> Result<Vec<f64>> {
        match self {
            Self::Given => Ok(e.residual(spectra)),
            Self::Own => e.own_residual(machine, spectra),
        }
    }

    fn slopes(self, e: &Evidence, now: &Fitted, unknowns: &[Unknown]) -> Result<Vec<Vec<f64>>> {
        match self {
            Self::Given => unknowns.iter().map(|u| e.slope(&now.spectra, &now.machine, *u)).collect(),
            Self::Own => e.own_slopes(&now.spectra, &now.machine, unknowns),
        }
    }

    fn changed(self, e: &Evidence, before: &Fitted, machine: &Machine) -> Result<Fitted> {
        let mut next = changed(e, before, machine)?;
        if self == Self::Own {
            next.residual = e.own_residual(machine, &next.spectra)?;
            next.chi_square = square(&next.residual);
        }
        Ok(next)
    }
}

/// Fits `unknowns` from `start`.
pub fn fit(e: &Evidence, start: &Fitted, unknowns: &[Unknown], iterations: usize) -> Result<Fitted> {
    levenberg_marquardt(e, start, unknowns, (Weights::Given, None), iterations)
}

/// Fits `unknowns` of a machine as a whole, some of which are known in part, in the weights of each machine tried.
pub fn fit_whole(
    e: &Evidence,
    start: &Fitted,
    unknowns: &[Unknown],
    prior: &Prior,
    iterations: usize,
) -> Result<Fitted> {
    levenberg_marquardt(e, start, unknowns, (Weights::Own, Some(prior)), iterations)
}

fn levenberg_marquardt(
    e: &Evidence,
    start: &Fitted,
    unknowns: &[Unknown],
    (weights, prior): (Weights, Option<&Prior>),
    iterations: usize,
) -> Result<Fitted> {
    let n = unknowns.len();
    if n == 0 {
        return evaluate(e, &start.machine);
    }
    let mut now = Fitted { unknowns: unknowns.to_vec(), ..start.clone() };
    now.residual = weights.residual(e, &now.machine, &now.spectra)?;
    now.chi_square = square(&now.residual);
    let objective = |of: &Fitted| of.chi_square + prior.map_or(0.0, |prior| prior.chi_square(&of.machine));
    let mut damping = 1e-4;
    let mut inverse = DMatrix::zeros(n, n);
    for _ in 0..iterations {
        let slopes = weights.slopes(e, &now, unknowns)?;
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
        let mut gradient = DVector::from_fn(n, |i, _| dot(&slopes[i], &now.residual));
        if let Some(prior) = prior {
            prior.add(&now.machine, unknowns, &mut normal, &mut gradient);
        }
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
            let next = weights.changed(e, &now, &machine)?;
            if objective(&next) < objective(&now) {
                improved = Some(next);
                damping = (damping * 0.1).max(1e-9);
                break;
            }
            damping = (damping * 10.0).max(1e-6);
        }
        let Some(next) = improved else { break };
        let fall = objective(&now) - objective(&next);
        now = Fitted { unknowns: unknowns.to_vec(), ..next };
        // Far from the recording, a small share of what is left decides nothing.
        if fall < MIN_FALL + MIN_SHARE * (now.chi_square - now.residual.len() as f64).max(0.0) {
            break;
        }
    }
    now.covariance = inverse;
    Ok(now)
}
