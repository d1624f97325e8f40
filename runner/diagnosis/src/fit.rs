//! Maximum-likelihood fit of a few unknowns of a machine to the residual at the probes.

use super::machine::Machine;
use super::parameter::{ForceSource, Unknown};
use super::residual::{Evidence, Spectra};
use super::{BuildError, Result};
use ballrace_base::least_squares::{Problem, Progress, dot, minimise};
use ballrace_base::time_limit::TimeLimit;
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

impl Fitted {
    /// Returns the standard deviation of an unknown; 0 where it is not one of the fit.
    pub fn deviation(&self, unknown: Unknown) -> f64 {
        let at = self.unknowns.iter().position(|own| *own == unknown);
        at.map_or(0.0, |i| self.covariance[(i, i)].max(0.0).sqrt())
    }

    /// Returns the machine with the covariance of further unknowns, which were fitted apart from those of this fit.
    fn with_covariance(mut self, unknowns: &[Unknown], covariance: &DMatrix<f64>) -> Self {
        let (own, more) = (self.unknowns.len(), unknowns.len());
        self.unknowns.extend(unknowns);
        self.covariance = self.covariance.resize(own + more, own + more, 0.0);
        self.covariance.view_mut((own, own), (more, more)).copy_from(covariance);
        self
    }

    /// Returns the least significant fall of chi-squared: while its excess is large, a fall by a small share of it is none.
    pub fn least_fall(&self) -> f64 {
        MIN_FALL + MIN_SHARE * (self.chi_square - self.residual.len() as f64).max(0.0)
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
        if old != new || before.machine.position != machine.position {
            spectra = e.changed(&spectra, machine, ForceSource::Bearing(i))?;
        }
    }
    // What is neither of a bearing nor of a reading is of the rotor.
    let of_rotor = |Machine { bearings: _, readings: _, position: _, load, damping, unbalance, coupling }: &Machine| {
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
const FURTHER_FALLS: f64 = 10.0;
const SETTLING: usize = 2;

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

/// End of a fit before its minimum.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub iterations: usize,
    pub time_limit: Option<TimeLimit>,
    /// A fit that would need more than [`FURTHER_FALLS`] further falls as large as the last one to come below it ends.
    pub target: f64,
}

impl Limits {
    pub const fn iterations(iterations: usize) -> Self {
        Self { iterations, time_limit: None, target: f64::INFINITY }
    }
}

/// Fits `unknowns` from `start`.
pub fn fit(e: &Evidence, start: &Fitted, unknowns: &[Unknown], iterations: usize) -> Result<Fitted> {
    fit_within(e, start, unknowns, Limits::iterations(iterations))
}

/// Fits `unknowns` from `start` within limits.
pub(crate) fn fit_within(e: &Evidence, start: &Fitted, unknowns: &[Unknown], limits: Limits) -> Result<Fitted> {
    Fit { e, unknowns, weights: Weights::Given, prior: None, limits }.from(start, None)
}

/// Fits `unknowns` with a prior of some of them, in the weights of each machine tried.
pub(crate) fn fit_whole(
    e: &Evidence,
    start: &Fitted,
    unknowns: &[Unknown],
    prior: &Prior,
    limits: Limits,
) -> Result<Fitted> {
    Fit { e, unknowns, weights: Weights::Own, prior: None, limits }.from(start, Some(prior))
}

/// Returns true for a search that will not come below a target.
pub(super) fn is_hopeless(Progress { iterations, square, fall }: Progress, target: f64) -> bool {
    iterations > SETTLING && fall > 0.0 && square - FURTHER_FALLS * fall > target
}

/// Fits further unknowns of a machine beside those of its own fit, which keep their values and covariance.
pub(super) fn fit_beside(e: &Evidence, start: &Fitted, unknowns: &[Unknown], iterations: usize) -> Result<Fitted> {
    let is_kept = |i: &usize| !unknowns.contains(&start.unknowns[*i]);
    let kept: Vec<usize> = (0..start.unknowns.len()).filter(is_kept).collect();
    let covariance = DMatrix::from_fn(kept.len(), kept.len(), |i, j| start.covariance[(kept[i], kept[j])]);
    let kept: Vec<Unknown> = kept.into_iter().map(|i| start.unknowns[i]).collect();
    Ok(fit(e, start, unknowns, iterations)?.with_covariance(&kept, &covariance))
}

/// Fit of some unknowns of a machine to a recording.
struct Fit<'a, 'b> {
    e: &'a Evidence<'b>,
    unknowns: &'a [Unknown],
    weights: Weights,
    prior: Option<Prior>,
    limits: Limits,
}

impl Fit<'_, '_> {
    fn from(mut self, start: &Fitted, prior: Option<&Prior>) -> Result<Fitted> {
        if self.unknowns.is_empty() {
            return evaluate(self.e, &start.machine);
        }
        let start = self.weighted(Fitted { unknowns: self.unknowns.to_vec(), ..start.clone() })?;
        // A model that leaves more than noise is as far from the machine as if its noise were higher by that factor.
        let inflation = (start.chi_square / start.residual.len().max(1) as f64).max(1.0);
        self.prior = prior.map(|prior| prior.times(inflation));
        let found = minimise(&self, start, self.limits.iterations)?;
        Ok(Fitted { covariance: found.covariance, ..found.point })
    }

    /// Returns a machine with its residual in the weights of this fit.
    fn weighted(&self, of: Fitted) -> Result<Fitted> {
        let residual = match self.weights {
            Weights::Given => self.e.residual(&of.spectra),
            Weights::Own => self.e.own_residual(&of.machine, &of.spectra)?,
        };
        Ok(Fitted { chi_square: square(&residual), residual, ..of })
    }
}

impl Problem for Fit<'_, '_> {
    type Point = Fitted;
    type Error = BuildError;

    fn unknowns(&self, at: &Fitted) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| unknown.get(&at.machine)).collect()
    }

    fn residuals<'p>(&self, at: &'p Fitted) -> &'p [f64] {
        &at.residual
    }

    fn slopes(&self, at: &Fitted, _: Progress) -> Result<Vec<Vec<f64>>> {
        match self.weights {
            Weights::Given => self.e.slopes(&at.spectra, &at.machine, self.unknowns),
            Weights::Own => self.e.own_slopes(&at.spectra, &at.machine, self.unknowns),
        }
    }

    /// The parameters are set to the nearest values within their bounds.
    fn moved(&self, from: &Fitted, unknowns: &[f64]) -> Result<Fitted> {
        let mut machine = from.machine.clone();
        self.unknowns.iter().zip(unknowns).for_each(|(unknown, x)| unknown.set(&mut machine, *x));
        let mut next = changed(self.e, from, &machine)?;
        if self.weights == Weights::Given {
            return Ok(next);
        }
        if self.e.site.is_some() {
            self.e.keep_mean_force(&mut machine, &next.spectra, &from.spectra)?;
            next = changed(self.e, &next, &machine)?;
        }
        self.weighted(next)
    }

    fn longest_step(&self, unknown: usize) -> f64 {
        self.e.longest_step(self.unknowns[unknown])
    }

    fn prior_square(&self, at: &Fitted) -> f64 {
        self.prior.as_ref().map_or(0.0, |prior| prior.chi_square(&at.machine))
    }

    fn add_prior(&self, at: &Fitted, normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        // An unknown that the recording does not determine keeps its value.
        for (i, unknown) in self.unknowns.iter().enumerate() {
            normal[(i, i)] += self.e.longest_step(*unknown).powi(-2);
        }
        if let Some(prior) = &self.prior {
            prior.add(&at.machine, self.unknowns, normal, gradient);
        }
    }

    fn least_fall(&self, at: &Fitted) -> f64 {
        at.least_fall()
    }

    fn may_continue(&self, progress: Progress) -> bool {
        !is_hopeless(progress, self.limits.target) && !self.limits.time_limit.is_some_and(|limit| limit.is_over())
    }
}
