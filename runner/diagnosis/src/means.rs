//! Fit of a machine to the lines and the means of the readings of a site together.
//!
//! Where a parameter moves the rotor, the gaps of the probes are those of the machine: each machine has readings of its own. A gap is one value;
//! of the values of lines, [`DEPENDENT`] are evidence of one.

use super::fit::{Fitted, evaluate, is_hopeless, square};
use super::machine::Machine;
use super::parameter::Unknown;
use super::residual::Evidence;
use super::residual::site::DEPENDENT;
use super::{BuildError, Prepared, Result};
use ballrace_base::least_squares::{Problem, Progress, minimise};
use nalgebra::{DMatrix, DVector};

/// Most steps of a fit, and dampings tried in each: a point has the errors of its readings and its weights found anew.
const STEPS: usize = 12;
const DAMPINGS: usize = 3;
/// Longest step over that of a fit in given weights: a point has weights of its own.
const LONGER: f64 = 2.0;
/// Fall of minus twice the logarithm of the likelihood in a step below which a fit ends.
const LEAST_FALL: f64 = 0.05;

/// Fits unknowns of a machine that move the rotor to lines and gaps; returns it with the recording weighted for it. A fit that cannot lead to a chi-squared
/// of `target` ends before its minimum.
pub(super) fn fit_with_means<'a>(
    of: &Prepared<'a>,
    start: &Machine,
    unknowns: &[Unknown],
    target: f64,
) -> Result<(Evidence<'a>, Fitted)> {
    let problem = Means { of, unknowns, target };
    let found = minimise(&problem, problem.point(start)?, STEPS)?;
    let covariance = found.covariance / DEPENDENT;
    Ok((found.point.evidence, Fitted { covariance, ..found.point.fitted }))
}

/// Returns chi-squared of the lines of a machine in weights of its own, and minus twice the logarithm of its likelihood by lines and gaps, both in units of
/// an independent value of lines.
pub(super) fn squares(of: &Prepared, machine: &Machine) -> Result<[f64; 2]> {
    let point = Means { of, unknowns: &[], target: f64::INFINITY }.point(machine)?;
    Ok([point.fitted.chi_square, DEPENDENT * square(&point.residuals)])
}

struct Means<'a, 'b> {
    of: &'b Prepared<'a>,
    unknowns: &'b [Unknown],
    target: f64,
}

/// Machine with the recording weighted for it.
struct Point<'a> {
    evidence: Evidence<'a>,
    fitted: Fitted,
    residuals: Vec<f64>,
}

impl<'a> Means<'a, '_> {
    fn point(&self, of: &Machine) -> Result<Point<'a>> {
        let evidence = self.of.weighted_for(of)?;
        let fitted = Fitted { unknowns: self.unknowns.to_vec(), ..evaluate(&evidence, of)? };
        let residuals = together(&fitted.residual, &evidence.gaps());
        Ok(Point { evidence, fitted, residuals })
    }
}

/// Returns values of lines and gaps in units of one independent value.
fn together(lines: &[f64], gaps: &[f64]) -> Vec<f64> {
    lines.iter().map(|x| x / DEPENDENT.sqrt()).chain(gaps.iter().copied()).collect()
}

impl<'a> Problem for Means<'a, '_> {
    type Point = Point<'a>;
    type Error = BuildError;

    fn unknowns(&self, at: &Point<'a>) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| unknown.get(&at.fitted.machine)).collect()
    }

    fn residuals<'p>(&self, at: &'p Point<'a>) -> &'p [f64] {
        &at.residuals
    }

    fn slopes(&self, Point { evidence, fitted, .. }: &Point<'a>, _: Progress) -> Result<Vec<Vec<f64>>> {
        let slopes = evidence.moving_slopes(&fitted.spectra, &fitted.machine, self.unknowns)?;
        Ok(slopes.iter().map(|[lines, gaps]| together(lines, gaps)).collect())
    }

    fn moved(&self, from: &Point<'a>, unknowns: &[f64]) -> Result<Point<'a>> {
        let mut machine = from.fitted.machine.clone();
        self.unknowns.iter().zip(unknowns).for_each(|(unknown, x)| unknown.set(&mut machine, *x));
        self.point(&machine)
    }

    fn longest_step(&self, unknown: usize) -> f64 {
        LONGER * self.of.evidence.longest_step(self.unknowns[unknown])
    }

    fn add_prior(&self, _: &Point<'a>, normal: &mut DMatrix<f64>, _: &mut DVector<f64>) {
        // An unknown that neither lines nor gaps determine keeps its value.
        for (i, unknown) in self.unknowns.iter().enumerate() {
            normal[(i, i)] += self.of.evidence.longest_step(*unknown).powi(-2) / DEPENDENT;
        }
    }

    fn least_fall(&self, _: &Point<'a>) -> f64 {
        LEAST_FALL
    }

    fn may_continue(&self, progress: Progress) -> bool {
        !is_hopeless(progress, self.target / DEPENDENT)
    }

    fn dampings(&self) -> usize {
        DAMPINGS
    }
}
