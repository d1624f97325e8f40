//! Search of the minimum over growing parts of a recording.

use super::model::Model;
use super::parameters::ParameterKind;
use super::{FitInput, turns_of};
use ballrace_base::least_squares::{self, Bounds, Limits};
use ballrace_plant::error::Result;
use nalgebra::DMatrix;
use std::cell::RefCell;

/// Fall of chi-squared in an iteration below which an early search ends.
const EARLY_FALL: f64 = 1.0;
/// The same for the last search.
const LAST_FALL: f64 = 0.05;
/// Longest step of a search, in prior standard deviations of an unknown.
const LONGEST_STEP: f64 = 10.0;
/// Largest number of iterations of the search over one part of the recording.
const MAX_ITERATIONS: usize = 40;
/// Turns of the first search.
const FIRST_TURNS: f64 = 0.5;
/// Turns from which all unknowns are free.
const EARLY_TURNS: f64 = 5.0;

/// Progress of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitProgress {
    /// Iteration over this part of the recording, from 1.
    pub iteration: usize,
    /// Largest number of iterations.
    pub most: usize,
    /// Number of shaft revolutions in this part of the recording.
    pub turns: f64,
    /// Number of shaft revolutions in all samples.
    pub all_turns: f64,
}

/// Unknowns that move together, at least one.
pub(super) type Tied = Vec<usize>;

/// Unknowns where a search over a part of the recording has ended.
struct Found {
    /// All unknowns.
    x: Vec<f64>,
    /// Residuals of the probes and of the priors.
    residuals: Vec<f64>,
    /// Weight of the priors.
    weight: f64,
    /// Relative fall of the sum of squares in the last iteration, where the search has ended before a minimum.
    still_falls: Option<f64>,
}

/// A solution with its slopes.
pub(super) struct Solution {
    pub(super) x: Vec<f64>,
    pub(super) residuals: Vec<f64>,
    pub(super) jacobian: DMatrix<f64>,
    pub(super) still_falls: Option<f64>,
}

impl Model<'_> {
    /// Fits a short part of the recording first, then twice as much each time. Over a long part, an error of a natural
    /// frequency shifts the phase by whole periods, and each period is a local minimum. On the first parts the offsets of
    /// the probes, the damping and the cages are fixed and the stiffness of all contacts has a common factor: freed too early, they
    /// diverge.
    pub(super) fn search(&self, progress: &mut dyn FnMut(FitProgress)) -> Result<Solution> {
        let first = self.of.samples.first().map_or(0.0, turns_of);
        let all: Vec<Tied> = (0..self.prior.len()).map(|i| vec![i]).collect();
        let early = self.early();
        let (mut at, mut turns) = (self.prior.to_vec(), FIRST_TURNS);
        loop {
            let count = self.of.samples.iter().take_while(|s| (turns_of(s) - first).abs() < turns).count();
            if count == self.of.samples.len() {
                return self.solution(&at, &all, progress);
            }
            let short = FitInput { samples: self.of.samples.get(..count).unwrap_or_default(), ..*self.of };
            let free = if turns < EARLY_TURNS { &early } else { &all };
            at = Model { of: &short, ..*self }.stage(&at, free, EARLY_FALL, progress)?.x;
            turns *= 2.0;
        }
    }

    fn early(&self) -> Vec<Tied> {
        let kind = |i: &usize| self.unknown.get(*i).map(|p| p.kind);
        let stiffness = |i: &usize| matches!(kind(i), Some(ParameterKind::Modulus(_) | ParameterKind::Stiffness(_)));
        let late = |i: &usize| {
            use ParameterKind::{CageAngle, CageRatio, Damping, Offset};
            matches!(kind(i), Some(Damping(_) | Offset(_) | CageAngle(_) | CageRatio(_)))
        };
        let indices = 0..self.prior.len();
        let mut free: Vec<Tied> = indices.clone().filter(|i| !late(i) && !stiffness(i)).map(|i| vec![i]).collect();
        free.extend(Some(indices.filter(stiffness).collect::<Tied>()).filter(|tied| !tied.is_empty()));
        free
    }

    /// Fits the unknowns `free` until the fall is negligible.
    pub(super) fn solution(
        &self,
        start: &[f64],
        free: &[Tied],
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<Solution> {
        let Found { x, residuals, weight, still_falls } = self.stage(start, free, LAST_FALL, progress)?;
        let bounds: Vec<Bounds> = free.iter().map(|tied| self.bounds(tied)).collect();
        let at: Vec<f64> = free.iter().map(|tied| x[tied[0]]).collect();
        let of = |free_x: &[f64]| self.weighted_residuals(&whole(free_x, &x, free), weight);
        Ok(Solution { jacobian: least_squares::jacobian(&at, &bounds, &of)?, x, residuals, still_falls })
    }

    /// Fits the unknowns `free` in at most [`MAX_ITERATIONS`]. While residuals are large, the prior has the same weight as the residuals.
    fn stage(
        &self,
        start: &[f64],
        free: &[Tied],
        least_fall: f64,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<Found> {
        let turns = self.turns();
        let mut x = start.to_vec();
        let mut last = f64::INFINITY;
        let mut made = 0;
        let report = RefCell::new(progress);
        loop {
            let left = self.residuals(&x)?;
            let weight = (left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64).sqrt().max(1.0);
            let residuals = |free_x: &[f64]| self.weighted_residuals(&whole(free_x, &x, free), weight);
            let from: Vec<f64> = free.iter().map(|tied| x[tied[0]]).collect();
            let bounds = free.iter().map(|tied| self.bounds(tied)).collect();
            let limits = Limits { bounds, longest_step: LONGEST_STEP, iterations: MAX_ITERATIONS - made, least_fall };
            let report = |i: usize| {
                let mut report = report.borrow_mut();
                report(FitProgress { iteration: made + i + 1, most: MAX_ITERATIONS, turns, all_turns: self.all_turns });
            };
            let found = least_squares::solve(&from, &limits, &residuals, &report)?;
            made += found.iterations;
            x = whole(&found.point.x, &x, free);
            if weight > 0.7 * last || weight <= 1.0 || made >= MAX_ITERATIONS {
                let residuals = found.point.residuals;
                return Ok(Found { x, residuals, weight, still_falls: found.still_falls });
            }
            last = weight;
        }
    }
}

/// Returns the reason that a search over all samples ended at its largest number of iterations.
pub(super) fn reason(still_falls: f64) -> String {
    format!(
        "the fit does not converge because the scene does not describe the recording: after {MAX_ITERATIONS} iterations over all samples \
         chi-squared still falls by {:.1e} % an iteration",
        100.0 * still_falls
    )
}

/// Returns the residuals at the probes, without the priors.
pub(super) fn probe_residuals<'s>(solution: &'s Solution, probes: usize, of: &FitInput) -> &'s [f64] {
    solution.residuals.get(..probes * of.samples.len()).unwrap_or_default()
}

/// Returns all unknowns from the free ones; the others are those of `from`.
fn whole(x: &[f64], from: &[f64], free: &[Tied]) -> Vec<f64> {
    let mut all = from.to_vec();
    free.iter().zip(x).for_each(|(tied, x)| tied.iter().for_each(|&i| all[i] = *x));
    all
}
