//! Influence coefficients with their covariance.

use super::drift::{Drift, Solution};
use super::moments::MASS_ERROR;
use super::runs::{Run, Runs};
use super::table::{C, VectorTable};
use ballrace_base::statistics::largest_chi_square;
use nalgebra::{DMatrix, DVector};

/// Moments that stay mounted.
pub(super) struct Mounted {
    /// Moments of the planes, g mm.
    pub(super) moments: Vec<C>,
    /// Covariance that the errors of their masses leave.
    pub(super) covariance: DMatrix<C>,
}

/// Coefficients with their covariance.
pub(super) struct Vectors<'a> {
    runs: &'a Runs,
    pub(super) planes: &'a [String],
    probes: &'a [String],
    drift: &'a Drift,
    solution: Solution,
    /// Usual moment: mean square of the trial moments; without trials, of the moment that moves the probes as the rotor does.
    usual: f64,
}

impl<'a> Vectors<'a> {
    pub(super) fn new(runs: &'a Runs, table: &'a VectorTable, drift: &'a Drift, solution: Solution) -> Self {
        let mut vectors =
            Self { runs, planes: &table.planes, probes: &table.probes, drift, solution, usual: runs.usual };
        if vectors.usual == 0.0 {
            vectors.usual = 1.0;
            let of_baseline: f64 =
                (0..vectors.channels()).map(|c| vectors.baseline(c).norm_sqr() / vectors.noise(c)).sum();
            let largest = vectors.weighted().singular_values().max();
            vectors.usual = of_baseline / (largest * largest).max(f64::MIN_POSITIVE);
        }
        vectors
    }

    pub(super) fn channels(&self) -> usize {
        self.runs.channels()
    }

    pub(super) fn probe(&self, channel: usize) -> &str {
        &self.probes[channel % self.runs.probes]
    }

    pub(super) fn speed(&self, channel: usize) -> f64 {
        self.runs.speeds[channel / self.runs.probes]
    }

    /// Returns the vector of a channel without added masses.
    pub(super) fn baseline(&self, channel: usize) -> C {
        self.solution.theta[self.runs.column(channel, 0)]
    }

    /// Returns the influence coefficient of plane `k`, per g mm.
    pub(super) fn coefficient(&self, channel: usize, k: usize) -> C {
        self.solution.theta[self.runs.column(channel, 1 + k)]
    }

    /// Returns the standard deviation of a coefficient.
    pub(super) fn deviation(&self, channel: usize, k: usize) -> f64 {
        let at = self.runs.column(channel, 1 + k);
        self.solution.covariance[(at, at)].re.max(0.0).sqrt()
    }

    /// Returns the variance of the vector of a channel by drift and error.
    fn noise(&self, channel: usize) -> f64 {
        (self.drift.covariance[(channel, channel)].re + self.drift.variance[channel]).max(f64::MIN_POSITIVE)
    }

    /// Returns the coefficients with the usual moment in units of drift and error.
    pub(super) fn weighted(&self) -> DMatrix<C> {
        DMatrix::from_fn(self.channels(), self.planes.len(), |channel, k| {
            self.coefficient(channel, k) * C::new((self.usual / self.noise(channel)).sqrt(), 0.0)
        })
    }

    /// Returns the moments that stay mounted as they act: the stated ones with the errors of their masses that the vectors of the last trim
    /// run show.
    pub(super) fn mounted(&self) -> Mounted {
        let (stated, planes) = (self.runs.mounted(), self.planes.len());
        let stated = DVector::from_vec(stated);
        let errors = |i: usize, j: usize| {
            let deviation = if i == j { MASS_ERROR * stated[i].norm() } else { 0.0 };
            C::new(deviation * deviation, 0.0)
        };
        let covariance = DMatrix::from_fn(planes, planes, errors);
        let found = (|| {
            let runs: Vec<&Run> = self.runs.last_trim().collect();
            let rows = runs.iter().flat_map(|run| (0..self.runs.probes).map(move |p| (*run, p)));
            let rows: Vec<(&Run, usize, usize)> =
                rows.map(|(run, p)| (run, p, run.speed * self.runs.probes + p)).collect();
            if rows.is_empty() {
                return None;
            }
            let matrix = DMatrix::from_fn(rows.len(), planes, |i, k| self.coefficient(rows[i].2, k));
            let fitted = &matrix * &stated;
            let left = |i: usize, _: usize| rows[i].0.response[rows[i].1] - self.baseline(rows[i].2) - fitted[i];
            let left = DVector::from_fn(rows.len(), left);
            let drift = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
                let (run, _, channel) = rows[i];
                let own = self.drift.variance[channel] + self.drift.repeat[channel] / run.count as f64;
                self.drift.covariance[(channel, rows[j].2)] + C::new(if i == j { own } else { 0.0 }, 0.0)
            });
            let moved = &matrix * &covariance;
            let gain = (drift + &moved * matrix.adjoint()).cholesky()?.solve(&moved).adjoint();
            Some((&stated + &gain * left, &covariance - gain * moved))
        })();
        let (moments, covariance) = found.unwrap_or((stated.clone(), covariance));
        Mounted { moments: moments.iter().copied().collect(), covariance }
    }

    /// Returns the metric of a departure `e` from the moments: the squares `e^H M e` that it adds to all vectors, as expected with the errors of the
    /// coefficients.
    pub(super) fn metric(&self) -> DMatrix<C> {
        let planes = self.planes.len();
        let matrix = DMatrix::from_fn(self.channels(), planes, |channel, k| self.coefficient(channel, k));
        let at = |channel: usize, k: usize| self.runs.column(channel, 1 + k);
        let error = |i: usize, j: usize| -> C {
            (0..self.channels()).map(|c| self.solution.covariance[(at(c, j), at(c, i))]).sum()
        };
        matrix.adjoint() * &matrix + DMatrix::from_fn(planes, planes, error)
    }

    /// Returns the squares that moments on the planes leave of the vectors without added masses, over their largest sum by errors alone;
    /// `None` where the planes explain any vectors.
    pub(super) fn unexplained(&self, moments: &[C]) -> Option<f64> {
        let (channels, planes) = (self.channels(), self.planes.len());
        let spare = channels.checked_sub(planes).filter(|spare| *spare > 0)?;
        let factors = self.errors(moments).cholesky()?;
        let baseline = DVector::from_fn(channels, |channel, _| self.baseline(channel));
        let matrix = DMatrix::from_fn(channels, planes, |channel, k| self.coefficient(channel, k));
        let (weighted, of_baseline) = (factors.solve(&matrix), factors.solve(&baseline));
        let least = (matrix.adjoint() * weighted).cholesky()?.solve(&(matrix.adjoint() * &of_baseline));
        let left = baseline - matrix * least;
        Some(over_largest(left.dotc(&factors.solve(&left)).re, spare))
    }

    /// Returns the covariance of the vectors with these moments: by the coefficients, by the drift and by the error of a run.
    pub(super) fn errors(&self, moments: &[C]) -> DMatrix<C> {
        let channels = self.channels();
        let mut design = DMatrix::<C>::zeros(channels, self.runs.coefficients());
        for channel in 0..channels {
            design[(channel, self.runs.column(channel, 0))] = C::new(1.0, 0.0);
            for (k, moment) in moments.iter().enumerate() {
                design[(channel, self.runs.column(channel, 1 + k))] = *moment;
            }
        }
        let mut sum = &design * &self.solution.covariance * design.adjoint() + &self.drift.covariance;
        for (channel, variance) in self.drift.variance.iter().enumerate() {
            sum[(channel, channel)] += C::new(*variance, 0.0);
        }
        sum
    }

    /// Returns the covariance of `C^H r` by the errors of the coefficients `C`, with the vectors `r` that the moments leave.
    pub(super) fn errors_of_left(&self, left: &[C]) -> DMatrix<C> {
        let planes = self.planes.len();
        let at = |channel: usize, k: usize| self.runs.column(channel, 1 + k);
        let mut carried = DMatrix::<C>::zeros(self.solution.covariance.nrows(), planes);
        for (channel, left) in left.iter().enumerate() {
            (0..planes).for_each(|k| carried[(at(channel, k), k)] = *left);
        }
        // The covariance of conjugates is the transposed one.
        carried.transpose() * self.solution.covariance.transpose() * carried.map(|x| x.conj())
    }

    /// Returns the covariance of the vectors by the errors of masses: their weights and the radius of the holes.
    pub(super) fn errors_of_masses(&self, moments: &[C]) -> DMatrix<C> {
        let square = |i: usize, j: usize| if i == j { (MASS_ERROR * moments[i].norm()).powi(2) } else { 0.0 };
        self.carried(&DMatrix::from_fn(moments.len(), moments.len(), |i, j| C::new(square(i, j), 0.0)))
    }

    /// Returns the covariance of the vectors by a covariance of the moments.
    pub(super) fn carried(&self, covariance: &DMatrix<C>) -> DMatrix<C> {
        let matrix = DMatrix::from_fn(self.channels(), covariance.ncols(), |channel, k| self.coefficient(channel, k));
        &matrix * covariance * matrix.adjoint()
    }
}

/// Returns the weighted squares of complex numbers that errors leave, over their largest sum by errors alone. Each counts as one degree of
/// freedom: a parameter of the twin changes it along one direction, errors of vectors along two.
pub(super) fn over_largest(squares: f64, numbers: usize) -> f64 {
    let freedom = numbers.max(1) as f64;
    squares / freedom / largest_chi_square(freedom)
}
