//! Runs whose vectors are not those that the other runs expect of them, and the probable error: other masses than the stated ones, probes
//! exchanged, another unit, angles counted the other way.

use super::error::BalanceError;
use super::runs::{Run, Runs, determined};
use super::table::{C, VectorTable};
use super::vectors::{Vectors, over_largest};
use ballrace_base::parallel;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Chi-squared over its largest value by errors alone from which a run departs from the others: the errors come from few runs.
const DEPARTS: f64 = 4.0;
/// Runs beyond the coefficients from which the errors of the others are known well enough to say that a run departs without a probable error.
const SPARE: usize = 3;
/// Vectors over those in the unit of the table, and their unit.
const SIZES: [(f64, &str); 8] = [
    (25.4, "um in place of mil"),
    (1.0 / 25.4, "mil in place of um"),
    (1e3, "um in place of mm"),
    (1e-3, "mm in place of um"),
    (2.0, "peak-to-peak in place of peak"),
    (0.5, "peak in place of peak-to-peak"),
    (std::f64::consts::FRAC_1_SQRT_2, "rms in place of peak"),
    (std::f64::consts::SQRT_2, "peak in place of rms"),
];
/// Moments that are stated over those that act, and the unit that is meant instead of g mm.
const MOMENTS: [(f64, &str); 5] =
    [(10.0, "g cm"), (25.4, "g in"), (28.349_523, "oz mm"), (720.077_89, "oz in"), (1e3, "g m or kg mm")];

/// A known condition whose vectors no probable error explains.
#[derive(Debug, Clone, Serialize)]
pub struct Departure {
    /// Condition.
    pub condition: String,
    /// Chi-squared of its vectors less those that the other runs expect, over its largest value by errors alone.
    pub misfit: f64,
}

/// An error that explains the vectors of a condition.
pub(super) struct ProbableError {
    /// Chi-squared without the error over its largest value.
    misfit: f64,
    pub(super) error: BalanceError,
}

/// A condition that departs from the others.
struct Departing {
    condition: usize,
    misfit: f64,
    cause: Option<ProbableError>,
}

/// Runs of one condition as one vector of their channels.
pub(super) struct Measured {
    probes: usize,
    pub(super) channels: Vec<usize>,
    pub(super) response: Vec<C>,
    /// Variance by the records of each mean.
    repeat: Vec<f64>,
}

/// A condition as it is without a probable error.
pub(super) struct Cause {
    moments: Vec<C>,
    response: Vec<C>,
    pub(super) likely: String,
    pub(super) expected: &'static str,
}

impl Cause {
    /// Returns true for an error of the masses.
    pub(super) fn has_other_masses(&self, stated: &[C]) -> bool {
        self.moments != stated
    }
}

impl Measured {
    pub(super) fn new(runs: &Runs, condition: usize) -> Self {
        let mut of = Self { probes: runs.probes, channels: vec![], response: vec![], repeat: vec![] };
        for run in runs.all.iter().filter(|run| run.condition == condition) {
            for probe in 0..runs.probes {
                let channel = run.speed * runs.probes + probe;
                of.channels.push(channel);
                of.response.push(run.response[probe]);
                of.repeat.push(runs.repeat[channel] / run.count as f64);
            }
        }
        of
    }

    /// Returns the covariance of the vectors that are expected with moments, by all errors.
    fn errors(&self, of: &Vectors, moments: &[C]) -> DMatrix<C> {
        let all = of.errors(moments) + of.errors_of_masses(moments);
        let n = self.channels.len();
        DMatrix::from_fn(n, n, |i, j| {
            let repeat = if i == j { self.repeat[i] } else { 0.0 };
            all[(self.channels[i], self.channels[j])] + C::new(repeat, 0.0)
        })
    }

    fn vector(&self, of: &Vectors, moments: &[C], i: usize) -> C {
        let by_masses = moments.iter().enumerate().map(|(k, u)| of.coefficient(self.channels[i], k) * u);
        of.baseline(self.channels[i]) + by_masses.sum::<C>()
    }

    /// Returns the vectors that are expected with moments, each with its standard deviation.
    pub(super) fn expected(&self, of: &Vectors, moments: &[C]) -> Vec<(C, f64)> {
        let errors = self.errors(of, moments);
        let deviation = |i: usize| errors[(i, i)].re.max(0.0).sqrt();
        (0..self.channels.len()).map(|i| (self.vector(of, moments, i), deviation(i))).collect()
    }

    /// Returns chi-squared of vectors less those that are expected with moments, over its largest value by errors alone.
    pub(super) fn misfit(&self, of: &Vectors, moments: &[C], response: &[C]) -> Option<f64> {
        let n = self.channels.len();
        let apart = DVector::from_fn(n, |i, _| response[i] - self.vector(of, moments, i));
        let factors = self.errors(of, moments).cholesky()?;
        Some(over_largest(apart.dotc(&factors.solve(&apart)).re, n))
    }

    /// Returns the vectors with two probes exchanged.
    fn exchanged(&self, a: usize, b: usize) -> Vec<C> {
        let other = |i: usize| match self.channels[i] % self.probes {
            probe if probe == a => i - a + b,
            probe if probe == b => i - b + a,
            _ => i,
        };
        (0..self.response.len()).map(|i| self.response[other(i)]).collect()
    }
}

impl Runs {
    /// Looks for a known condition, other than the last trim run, that departs from what the others expect of it; `None` where all agree.
    ///
    /// # Errors
    /// Returns an error where a probable error explains its vectors.
    pub(super) fn departure(&self, table: &VectorTable, time: f64) -> Result<Option<Departure>, BalanceError> {
        let is_asked = |condition: &usize| {
            let is_known = |run: &Run| run.condition == *condition && run.moments.is_some();
            self.trims.last() != Some(condition) && self.all.iter().any(is_known)
        };
        let asked: Vec<usize> = (0..self.conditions.len()).filter(is_asked).collect();
        let found = parallel::map(&asked, |condition| self.against_the_others(table, time, *condition));
        let mut departing: Vec<Departing> = found.into_iter().flatten().collect();
        let causes = departing.iter_mut().filter_map(|one| one.cause.take());
        if let Some(best) = causes.min_by(|a, b| a.misfit.total_cmp(&b.misfit)) {
            return Err(best.error);
        }
        let largest = departing.into_iter().max_by(|a, b| a.misfit.total_cmp(&b.misfit));
        let named =
            |one: Departing| Departure { condition: self.conditions[one.condition].clone(), misfit: one.misfit };
        Ok(largest.map(named))
    }

    /// Returns a condition where it departs from the others, with its probable error.
    fn against_the_others(&self, table: &VectorTable, time: f64, condition: usize) -> Option<Departing> {
        let others = self.without(condition);
        determined(&others).ok()?;
        let (drift, solution) = others.learned(&[time])?;
        let of = Vectors::new(&others, table, &drift, solution);
        let measured = Measured::new(self, condition);
        let stated = self.all.iter().find(|run| run.condition == condition)?.moments.clone()?;
        let misfit = measured.misfit(&of, &stated, &measured.response)?;
        if misfit <= DEPARTS {
            return None;
        }
        let cause = self.probable_error(table, (condition, &measured), &of, &stated);
        let is_told = cause.is_some() || others.known() > self.planes + SPARE;
        is_told.then_some(Departing { condition, misfit, cause })
    }

    /// Returns the runs of the other conditions.
    pub(super) fn without(&self, condition: usize) -> Self {
        self.with(self.all.iter().filter(|run| run.condition != condition).cloned().collect())
    }

    /// Returns the probable error that explains the vectors of a condition.
    pub(super) fn probable_error(
        &self,
        table: &VectorTable,
        (condition, measured): (usize, &Measured),
        of: &Vectors,
        stated: &[C],
    ) -> Option<ProbableError> {
        let misfit = |cause: &Cause| measured.misfit(of, &cause.moments, &cause.response).unwrap_or(f64::INFINITY);
        let causes = self.causes(table, (condition, measured), stated).into_iter().map(|cause| (misfit(&cause), cause));
        let (misfit, Cause { likely, expected, .. }) = causes.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let condition = self.conditions[condition].clone();
        let error = BalanceError::Mounted { condition, likely, expected };
        (misfit <= 1.0).then_some(ProbableError { misfit, error })
    }

    /// Returns a known condition as it would be without each probable error.
    pub(super) fn causes(
        &self,
        table: &VectorTable,
        (condition, measured): (usize, &Measured),
        stated: &[C],
    ) -> Vec<Cause> {
        let of_masses = |(moments, likely): (Vec<C>, String)| {
            let expected = "the masses that are mounted";
            Cause { moments, response: measured.response.clone(), likely, expected }
        };
        let mut all: Vec<Cause> = self.other_masses(table, condition, stated).into_iter().map(of_masses).collect();
        all.extend(other_vectors(table, measured, stated));
        // Of the rotor's own unbalance alone, vectors in any unit are expected, and those below the errors agree with all.
        if self.usual > 0.0 {
            all.extend(other_units(measured, stated));
        }
        all
    }

    /// Returns the runs with a condition as it is without a probable error.
    pub(super) fn without_error(&self, condition: usize, cause: &Cause) -> Self {
        let mut vectors = cause.response.chunks(self.probes);
        let mut changed = |run: &Run| {
            let mut run = run.clone();
            if run.condition == condition
                && let Some(response) = vectors.next()
            {
                run.response = DVector::from_column_slice(response);
                run.moments = Some(cause.moments.clone());
            }
            run
        };
        self.with(self.all.iter().map(&mut changed).collect())
    }

    /// Returns masses that may be mounted instead of the stated ones, each in words.
    fn other_masses(&self, table: &VectorTable, condition: usize, stated: &[C]) -> Vec<(Vec<C>, String)> {
        let changed = |change: fn(&C) -> C| stated.iter().map(change).collect::<Vec<C>>();
        let mut all = vec![];
        if stated.iter().any(|moment| moment.norm_sqr() > 0.0) {
            all.push((changed(|_| C::new(0.0, 0.0)), "no mass mounted".to_owned()));
            all.push((changed(|u| -u), "the masses half a turn from the stated angles".to_owned()));
            all.push((changed(C::conj), "the angles of the masses counted the other way".to_owned()));
            let scaled = |by: f64| stated.iter().map(|moment| moment * by).collect::<Vec<C>>();
            all.extend(MOMENTS.map(|(size, unit)| (scaled(size), format!("the masses in {unit}"))));
        }
        let loaded: Vec<usize> = (0..self.planes).filter(|&plane| stated[plane].norm_sqr() > 0.0).collect();
        for plane in 0..self.planes {
            let name = &table.planes[plane];
            if loaded.len() > 1 && loaded.contains(&plane) {
                let mut without = stated.to_vec();
                without[plane] = C::new(0.0, 0.0);
                all.push((without, format!("no mass in plane {name}")));
                let mut turned = stated.to_vec();
                turned[plane] = -turned[plane];
                all.push((turned, format!("the mass in plane {name} half a turn from the stated angle")));
            }
            for other in plane + 1..self.planes {
                let mut swapped = stated.to_vec();
                swapped.swap(plane, other);
                all.push((swapped, format!("the masses of planes {name} and {} exchanged", table.planes[other])));
            }
        }
        for run in self.all.iter().filter(|run| run.condition != condition) {
            let Some(moments) = run.moments.as_ref().filter(|of| of.iter().any(|u| u.norm_sqr() > 0.0)) else {
                continue;
            };
            let name = &self.conditions[run.condition];
            let both = stated.iter().zip(moments).map(|(a, b)| a + b).collect();
            all.push((both, format!("the masses of {name} mounted besides")));
        }
        all
    }
}

/// Returns the vectors of a condition without errors of the probes.
fn other_vectors(table: &VectorTable, measured: &Measured, stated: &[C]) -> Vec<Cause> {
    let changed = |change: &dyn Fn(&C) -> C| measured.response.iter().map(change).collect::<Vec<C>>();
    let cause = |response, likely, expected| Cause { moments: stated.to_vec(), response, likely, expected };
    let direction = "angles of all vectors in one direction";
    let mut all =
        vec![cause(changed(&|y| y.conj()), "the angles of the vectors counted the other way".to_owned(), direction)];
    for [a, b] in pairs(measured.probes) {
        let [first, second] = [&table.probes[a], &table.probes[b]];
        let likely = format!("probes {first} and {second} exchanged");
        all.push(cause(measured.exchanged(a, b), likely, "the same probes in the columns of all runs"));
    }
    all
}

/// Returns the vectors of a condition in the unit of the table, where they are in another one.
fn other_units(measured: &Measured, stated: &[C]) -> impl Iterator<Item = Cause> {
    SIZES.into_iter().map(|(size, unit)| Cause {
        moments: stated.to_vec(),
        response: measured.response.iter().map(|y| y / size).collect(),
        likely: format!("vectors in {unit}"),
        expected: "one unit for all runs",
    })
}

/// Returns each pair of two numbers below `count`.
pub(super) fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| [a, b]))
}
