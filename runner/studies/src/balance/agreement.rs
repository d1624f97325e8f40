//! Agreement of runs with the twin of their machine, and the probable error where they disagree: probes or planes exchanged, angles counted the
//! other way, a trial without its mass.

use super::correction;
use super::departure::{Cause, Measured, pairs};
use super::error::BalanceError;
use super::runs::{Run, Runs, determined};
use super::table::{C, VectorTable};
use super::twin::{TwinCoefficients, flat};
use super::vectors::{Vectors, over_largest};
use ballrace_base::parallel;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Agreement of the vectors with the coefficients of a twin.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Agreement {
    /// The estimate uses the coefficients of the twin.
    pub used: bool,
    /// There were trials.
    pub has_trials: bool,
    /// Chi-squared of the vectors over the largest by errors alone: above 1 they disagree; `None` where there is nothing to compare.
    pub misfit: Option<f64>,
}

impl Runs {
    /// Returns chi-squared of the vectors and the coefficients of a twin over its largest value by errors alone: of trials, and without any,
    /// of the rotor itself, whose vectors the planes explain; `None` where there is nothing to compare.
    fn misfit_of_twin(&self, table: &VectorTable, twin: &TwinCoefficients) -> Option<f64> {
        if determined(self).is_ok() {
            let (_, solution) = self.learned(&self.drift_times())?;
            let at = |i: usize| self.column(i / self.planes, 1 + i % self.planes);
            let mean = flat(&twin.mean);
            let apart = DVector::from_fn(mean.len(), |i, _| solution.theta[at(i)] - mean[i]);
            let trials = DMatrix::from_fn(mean.len(), mean.len(), |i, j| solution.covariance[(at(i), at(j))]);
            let weighted = (trials + &twin.covariance).cholesky()?.solve(&apart);
            return Some(over_largest(apart.dotc(&weighted).re, mean.len()));
        }
        let with = self.with_twin(twin)?;
        let (drift, solution) = with.learned(&self.drift_times())?;
        if self.usual > 0.0 {
            let known: usize = self.all.iter().filter(|run| run.moments.is_some()).count() * self.probes;
            return Some(over_largest(solution.left, known.saturating_sub(self.channels())));
        }
        let vectors = Vectors::new(&with, table, &drift, solution);
        let optimum = correction::optimum(&vectors)?;
        vectors.unexplained(optimum.moments.as_slice())
    }

    /// Returns the runs with the vectors of two probes exchanged.
    fn exchanged(&self, a: usize, b: usize) -> Self {
        let exchanged = |run: &Run| {
            let mut run = run.clone();
            run.response.swap_rows(a, b);
            run
        };
        self.with(self.all.iter().map(exchanged).collect())
    }

    /// Returns the probable errors of the runs, each with the runs as they are without it: those of all runs, then those of one.
    fn probable_errors(&self, table: &VectorTable) -> Vec<(Self, BalanceError)> {
        let mut all = vec![];
        for [a, b] in pairs(self.probes) {
            let [first, second] = [a, b].map(|probe| table.probes[probe].clone());
            all.push((self.exchanged(a, b), BalanceError::Exchanged { first, second }));
        }
        if self.usual > 0.0 {
            all.push((self.mirrored(), BalanceError::Mirrored));
            for [a, b] in pairs(self.planes) {
                let [first, second] = [a, b].map(|plane| table.planes[plane].clone());
                let exchanged = self.with_moments(|_, moments| moments.swap(a, b));
                all.push((exchanged, BalanceError::Planes { first, second }));
            }
        }
        let known = |of: &usize| Some((*of, self.all.iter().find(|run| run.condition == *of)?.moments.as_ref()?));
        let known: Vec<(usize, &Vec<C>)> = (0..self.conditions.len()).filter_map(|of| known(&of)).collect();
        let is_empty = |stated: &[C]| stated.iter().all(|moment| moment.norm_sqr() == 0.0);
        let has_one_baseline = known.iter().filter(|(_, stated)| is_empty(stated)).count() < 2;
        for (condition, stated) in known {
            let measured = Measured::new(self, condition);
            let causes = self.causes(table, (condition, &measured), stated).into_iter();
            // The only baseline with the masses of a trial is a trial without masses.
            let is_own = |cause: &Cause| !(has_one_baseline && is_empty(stated) && cause.has_other_masses(stated));
            all.extend(causes.filter(is_own).map(|cause| {
                let runs = self.without_error(condition, &cause);
                let Cause { likely, expected, .. } = cause;
                (runs, BalanceError::AgainstTwin { condition: self.conditions[condition].clone(), likely, expected })
            }));
        }
        all
    }

    /// Compares the vectors with a twin. One that disagrees is not used where the trials suffice.
    pub(super) fn agreement(&self, table: &VectorTable, twin: &TwinCoefficients) -> Result<Agreement, BalanceError> {
        let has_trials = self.usual > 0.0;
        let misfit = self.misfit_of_twin(table, twin);
        let Some(found) = misfit.filter(|misfit| *misfit > 1.0) else {
            return Ok(Agreement { used: true, has_trials, misfit });
        };
        let errors = self.probable_errors(table);
        let misfits = parallel::map(&errors, |(runs, _)| runs.misfit_of_twin(table, twin).unwrap_or(f64::INFINITY));
        let best = errors.into_iter().zip(misfits).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(((_, error), _)) = best.filter(|best| best.1 <= 1.0) {
            return Err(error);
        }
        if determined(self).is_err() && has_trials {
            return Err(BalanceError::Twin { misfit: found });
        }
        Ok(Agreement { used: !has_trials, has_trials, misfit })
    }
}

/// Checks that the trials move the probes, whatever a twin knows.
pub(super) fn response(runs: &Runs, table: &VectorTable) -> Result<(), BalanceError> {
    let Some((drift, solution)) = runs.learned(&runs.drift_times()) else { return Ok(()) };
    let largest = Vectors::new(runs, table, &drift, solution).weighted().singular_values().max();
    if largest < correction::OBSERVED { Err(BalanceError::NoResponse) } else { Ok(()) }
}
