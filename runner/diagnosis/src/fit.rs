//! Maximum-likelihood fit of a few unknowns of a machine: Levenberg-Marquardt on the residual at the probes.

use super::Result;
use super::machine::Machine;
use super::parameter::{ForceSource, Unknown};
use super::residual::{Evidence, Spectra, dot};
use nalgebra::{DMatrix, DVector};
use std::time::Instant;

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

impl Fitted {
    /// Returns the standard deviation of an unknown; 0 where it is not one of the fit.
    pub fn deviation(&self, unknown: Unknown) -> f64 {
        let at = self.unknowns.iter().position(|own| *own == unknown);
        at.map_or(0.0, |i| self.covariance[(i, i)].max(0.0).sqrt())
    }
}

pub fn square(r: &[f64]) -> f64 {
    dot(r, r)
}

/// Evaluates a machine without a fit.
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

/// Evaluates another machine; parts that are the same as in `before` are not evaluated again.
pub fn changed(e: &Evidence, before: &Fitted, machine: &Machine) -> Result<Fitted> {
    let mut spectra = before.spectra.clone();
    for (i, (old, new)) in before.machine.bearings.iter().zip(&machine.bearings).enumerate() {
        if old != new {
            spectra = e.changed(&spectra, machine, ForceSource::Bearing(i))?;
        }
    }
    // What is neither of a bearing nor of a reading is of the rotor.
    let of_rotor = |Machine { bearings: _, readings: _, load, damping, unbalance, coupling }: &Machine| {
        (*load, *damping, *unbalance, *coupling)
    };
    if of_rotor(&before.machine) != of_rotor(machine) {
        // A change of the rotor may also move the bearings.
        spectra = e.changed(&spectra, machine, ForceSource::Rotor)?;
    }
    if before.machine.readings != machine.readings {
        spectra = e.changed(&spectra, machine, ForceSource::Readings)?;
    }
    let residual = e.residual(&spectra);
    let chi_square = square(&residual);
    Ok(Fitted { machine: machine.clone(), spectra, residual, chi_square, ..before.clone() })
}

/// Relative amount by which the chi-squared of a true machine may exceed the number of values: the force is evaluated at samples
/// and interpolated between them.
pub(crate) const MODEL_ERROR: f64 = 0.03;
/// Fall of chi-squared in a step below which a fit ends.
pub const MIN_FALL: f64 = 0.5;
/// The same, over the excess of chi-squared.
const MIN_SHARE: f64 = 1e-3;
/// Falls as large as the last one within which a fit comes close to its minimum, after its first steps.
const AHEAD: f64 = 10.0;
const SETTLING: usize = 2;
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
    /// Returns the mean of an unknown; 0 without one.
    pub(crate) fn mean_of(&self, unknown: Unknown) -> f64 {
        self.unknowns.iter().zip(&self.mean).find(|(own, _)| **own == unknown).map_or(0.0, |(_, mean)| *mean)
    }

    /// Returns the standard deviation of an unknown that no other correlates with.
    pub fn deviation(&self, unknown: Unknown) -> f64 {
        let own = self.unknowns.iter().position(|own| *own == unknown);
        own.map_or(f64::INFINITY, |i| self.precision[(i, i)].powf(-0.5))
    }

    /// Returns the prior with its precision multiplied.
    pub fn times(&self, factor: f64) -> Self {
        Self { unknowns: self.unknowns.clone(), mean: self.mean.clone(), precision: &self.precision * factor }
    }

    fn distance(&self, machine: &Machine) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|u| u.get(machine))) - &self.mean
    }

    /// Returns minus twice the logarithm of the density, up to a constant.
    fn chi_square(&self, machine: &Machine) -> f64 {
        let distance = self.distance(machine);
        distance.dot(&(&self.precision * &distance))
    }

    /// Adds the terms of the prior to the normal equations of `unknowns`.
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

/// Weights of the residual in a fit.
#[derive(Clone, Copy, PartialEq)]
enum Weights {
    /// Weights of the evidence, the same for all machines.
    Given,
    /// Weights of each machine tried.
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
            Self::Given => e.slopes(&now.spectra, &now.machine, unknowns),
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

/// End of a fit before its minimum.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub iterations: usize,
    pub end: Option<Instant>,
    /// A fit that would need more than [`AHEAD`] further falls as large as the last one to come below it ends.
    pub target: f64,
}

impl Limits {
    pub const fn iterations(iterations: usize) -> Self {
        Self { iterations, end: None, target: f64::INFINITY }
    }
}

/// Fits `unknowns` from `start`.
pub fn fit(e: &Evidence, start: &Fitted, unknowns: &[Unknown], iterations: usize) -> Result<Fitted> {
    fit_within(e, start, unknowns, Limits::iterations(iterations))
}

/// Fits `unknowns` from `start` within limits.
pub(crate) fn fit_within(e: &Evidence, start: &Fitted, unknowns: &[Unknown], limits: Limits) -> Result<Fitted> {
    levenberg_marquardt(e, start, unknowns, (Weights::Given, None), limits)
}

/// Fits `unknowns` with a prior of some of them, in the weights of each machine tried.
pub(crate) fn fit_whole(
    e: &Evidence,
    start: &Fitted,
    unknowns: &[Unknown],
    prior: &Prior,
    limits: Limits,
) -> Result<Fitted> {
    levenberg_marquardt(e, start, unknowns, (Weights::Own, Some(prior)), limits)
}

fn levenberg_marquardt(
    e: &Evidence,
    start: &Fitted,
    unknowns: &[Unknown],
    (weights, prior): (Weights, Option<&Prior>),
    Limits { iterations, end, target }: Limits,
) -> Result<Fitted> {
    let n = unknowns.len();
    if n == 0 {
        return evaluate(e, &start.machine);
    }
    let mut now = Fitted { unknowns: unknowns.to_vec(), ..start.clone() };
    now.residual = weights.residual(e, &now.machine, &now.spectra)?;
    now.chi_square = square(&now.residual);
    // A model that leaves more than noise is as far from the machine as if its noise were higher by that factor.
    let inflation = (now.chi_square / now.residual.len().max(1) as f64).max(1.0);
    let prior = prior.map(|prior| prior.times(inflation));
    let objective = |of: &Fitted| of.chi_square + prior.as_ref().map_or(0.0, |prior| prior.chi_square(&of.machine));
    let mut damping = 1e-4;
    let mut inverse = DMatrix::zeros(n, n);
    let mut slopes = weights.slopes(e, &now, unknowns)?;
    let mut is_exact = true;
    for i in 0..iterations {
        if end.is_some_and(|end| Instant::now() > end) {
            break;
        }
        let system = NormalEquations::new(e, &now, unknowns, &slopes, prior.as_ref());
        inverse = system.inverse();
        let mut improved = None;
        for _ in 0..DAMPINGS {
            let Some(machine) = system.step(e, &now.machine, unknowns, damping) else { break };
            // A machine that cannot be built is rejected like one with a larger residual.
            let next = weights.changed(e, &now, &machine).ok();
            if let Some(next) = next.filter(|next| objective(next) < objective(&now)) {
                improved = Some(next);
                damping = (damping * 0.1).max(1e-9);
                break;
            }
            if !is_exact {
                break;
            }
            damping = (damping * 10.0).max(1e-6);
        }
        let mut fall = 0.0;
        if let Some(next) = improved {
            fall = objective(&now) - objective(&next);
            update(&mut slopes, &system.scale, &now, &next, unknowns);
            now = Fitted { unknowns: unknowns.to_vec(), ..next };
        } else if is_exact {
            break;
        }
        if i >= SETTLING && fall > 0.0 && objective(&now) - AHEAD * fall > target {
            break;
        }
        // While the excess of chi-squared is large, a fall by a small share of it is not significant.
        let least = MIN_FALL + MIN_SHARE * (now.chi_square - now.residual.len() as f64).max(0.0);
        if fall >= least {
            is_exact = false;
            continue;
        }
        if is_exact {
            break;
        }
        // A step with updated slopes may be short far from the minimum.
        slopes = weights.slopes(e, &now, unknowns)?;
        is_exact = true;
    }
    now.covariance = inverse;
    Ok(now)
}

/// Corrects the slopes from the last step by Broyden's update, in unknowns scaled to equal slopes. It replaces an evaluation of the
/// machine for each unknown.
fn update(slopes: &mut [Vec<f64>], scale: &[f64], before: &Fitted, after: &Fitted, unknowns: &[Unknown]) {
    let step: Vec<f64> = unknowns.iter().map(|u| u.get(&after.machine) - u.get(&before.machine)).collect();
    let square: f64 = step.iter().zip(scale).map(|(x, scale)| (scale * x).powi(2)).sum();
    if square <= 0.0 {
        return;
    }
    let mut error: Vec<f64> =
        after.residual.iter().zip(&before.residual).map(|(after, before)| after - before).collect();
    for (slope, x) in slopes.iter().zip(&step) {
        error.iter_mut().zip(slope).for_each(|(error, slope)| *error -= slope * x);
    }
    for ((slope, x), scale) in slopes.iter_mut().zip(&step).zip(scale) {
        let share = scale * scale * x / square;
        slope.iter_mut().zip(&error).for_each(|(slope, error)| *slope += share * error);
    }
}

/// Normal equations of a step, scaled to a unit diagonal.
struct NormalEquations {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    scale: Vec<f64>,
}

impl NormalEquations {
    fn new(e: &Evidence, now: &Fitted, unknowns: &[Unknown], slopes: &[Vec<f64>], prior: Option<&Prior>) -> Self {
        let n = unknowns.len();
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
        let scale: Vec<f64> = (0..n).map(|i| normal[(i, i)].max(1e-300).sqrt()).collect();
        let matrix = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        Self { matrix, gradient: DVector::from_fn(n, |i, _| gradient[i] / scale[i]), scale }
    }

    /// Returns the inverse of the normal matrix in the units of the unknowns.
    fn inverse(&self) -> DMatrix<f64> {
        let n = self.scale.len();
        let inverse = self.matrix.clone().try_inverse().filter(|inverse| inverse.iter().all(|x| x.is_finite()));
        let inverse = inverse.unwrap_or_else(|| DMatrix::identity(n, n));
        DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (self.scale[i] * self.scale[j]))
    }

    /// Returns the machine after a damped step of bounded length; `None` if the equations have no finite solution.
    fn step(&self, e: &Evidence, from: &Machine, unknowns: &[Unknown], damping: f64) -> Option<Machine> {
        let n = unknowns.len();
        let step = (&self.matrix + DMatrix::identity(n, n) * damping).lu().solve(&self.gradient)?;
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        let length = |i: usize| step[i] / self.scale[i];
        let excess = unknowns.iter().enumerate().map(|(i, u)| length(i).abs() / e.longest_step(*u));
        let shorten = 1.0 / excess.fold(1.0, f64::max);
        let mut machine = from.clone();
        for (i, u) in unknowns.iter().enumerate() {
            u.set(&mut machine, u.get(from) - shorten * length(i));
        }
        Some(machine)
    }
}
