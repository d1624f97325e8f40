//! Drift of vibration vectors: a stationary process in time over all channels, found from records with known masses.
//!
//! A channel is a probe at a speed. The vector of a record is `y = A theta + d(t) + e`: coefficients `theta`, drift `d` with covariance
//! `Sigma` over the channels that is lost within the time `tau`, `E d(t) d(s)^H = exp(-|t - s| / tau) Sigma`, and the error `e` of one
//! record. The drift of a machine (bow, temperature, seating of its parts) moves all channels together, so that one channel tells of the
//! others. All is linear in the number of records: a Kalman filter runs over the vectors and the columns of `A` alike, which leaves least
//! squares for `theta`; a smoother gives the moments of the drift from which `Sigma` follows (expectation and maximisation).
//!
//! Source: Durbin and Koopman, Time Series Analysis by State Space Methods, chapters 4 to 7.

use super::table::C;
use nalgebra::{DMatrix, DVector};

/// Vectors of all probes at one time.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Time, s.
    pub time: f64,
    /// First channel; those of the other probes follow.
    pub first: usize,
    /// Mean vector of each probe.
    pub response: DVector<C>,
    /// Records in the mean.
    pub count: usize,
    /// Rows of `A`.
    pub design: DMatrix<C>,
    /// Further covariance of the vectors, that of the errors of its masses.
    pub by_masses: Option<DMatrix<C>>,
}

impl Observation {
    /// Returns true if it holds a channel.
    fn has(&self, channel: usize) -> bool {
        (self.first..self.first + self.response.len()).contains(&channel)
    }
}

/// Covariance of drift and error.
#[derive(Debug, Clone)]
pub struct Drift {
    /// Time within which the drift is lost, s.
    pub time: f64,
    /// Covariance over the channels.
    pub covariance: DMatrix<C>,
    /// Variance of the error of a mean of records that stays, by channel.
    pub variance: Vec<f64>,
    /// Variance of one record about such a mean, by channel.
    pub repeat: Vec<f64>,
    /// What is known of the coefficients before: weighted squares as of further vectors, in the order vectors, columns of `A`.
    pub prior: Option<DMatrix<C>>,
}

/// Least squares of the coefficients under a drift.
#[derive(Clone)]
pub struct Solution {
    pub theta: DVector<C>,
    /// Covariance of the coefficients.
    pub covariance: DMatrix<C>,
    /// Logarithm of the likelihood of what is left after the coefficients (restricted likelihood).
    pub log_likelihood: f64,
    /// Weighted sum of squares that is left.
    pub left: f64,
}

/// State of the filter at one observation.
struct Filtered {
    /// Share of the drift that is kept since the observation before.
    kept: f64,
    /// Covariance before and after the observation.
    predicted: DMatrix<C>,
    updated: DMatrix<C>,
    /// Means before and after it: of the vectors, then of each column of `A`.
    mean_predicted: DMatrix<C>,
    mean: DMatrix<C>,
}

/// Largest factor of covariances by the share of the coefficients.
const MOST_SHARE: f64 = 1.75;
/// Rounds of expectation and maximisation.
const ROUNDS: usize = 40;
/// Records that the scale from which the covariance starts counts as.
const PRIOR: f64 = 4.0;
/// Deviation over the mean size of the vectors of a channel, where no run more than coefficients tells it: vectors of one session repeat within
/// some percent from start to start.
const USUAL: f64 = 0.02;
/// Error of a mean of records at the start, over the scale of what the coefficients leave.
const ERROR: f64 = 0.3;

fn zero() -> C {
    C::new(0.0, 0.0)
}

impl Drift {
    fn channels(&self) -> usize {
        self.variance.len()
    }

    /// Returns the covariance of the error of an observation.
    fn error(&self, of: &Observation) -> DMatrix<C> {
        let probes = of.response.len();
        let at = |p: usize| self.variance[of.first + p] + self.repeat[of.first + p] / of.count as f64;
        let own = DMatrix::from_fn(probes, probes, |i, j| if i == j { C::new(at(i), 0.0) } else { zero() });
        of.by_masses.as_ref().map_or_else(|| own.clone(), |by_masses| &own + by_masses)
    }

    /// Runs the filter over vectors and columns; returns the states, and the weighted squares of the innovations with the logarithm of the
    /// determinant of their covariance.
    fn filter(&self, all: &[Observation]) -> Option<(Vec<Filtered>, DMatrix<C>, f64)> {
        let q = self.channels();
        let columns = all.first()?.design.ncols();
        let mut states: Vec<Filtered> = Vec::with_capacity(all.len());
        let mut squares = DMatrix::<C>::zeros(columns + 1, columns + 1);
        if let Some(prior) = &self.prior {
            squares.view_mut((0, 0), prior.shape()).copy_from(prior);
        }
        let mut logarithm = 0.0;
        let mut before: Option<(f64, DMatrix<C>, DMatrix<C>)> = None;
        for of in all {
            let (kept, predicted, mean_predicted) = match &before {
                None => (0.0, self.covariance.clone(), DMatrix::zeros(q, columns + 1)),
                Some((time, covariance, mean)) => {
                    let kept = (-(of.time - time) / self.time).exp();
                    let square = C::new(kept * kept, 0.0);
                    let rest = C::new(1.0 - kept * kept, 0.0);
                    (kept, covariance * square + &self.covariance * rest, mean * C::new(kept, 0.0))
                }
            };
            let probes = of.response.len();
            let rows = |m: &DMatrix<C>| m.rows(of.first, probes).into_owned();
            let across = predicted.columns(of.first, probes).into_owned();
            let innovation_covariance = rows(&across) + self.error(of);
            let factors = innovation_covariance.cholesky()?;
            logarithm += 2.0 * factors.l_dirty().diagonal().iter().map(|x| x.re.ln()).sum::<f64>();
            let mut innovations = -rows(&mean_predicted);
            let mut first = innovations.column_mut(0);
            first += &of.response;
            let mut others = innovations.columns_mut(1, columns);
            others += &of.design;
            let weighted = factors.solve(&innovations);
            squares += innovations.adjoint() * &weighted;
            let mean = &mean_predicted + &across * &weighted;
            let updated = &predicted - &across * factors.solve(&across.adjoint());
            before = Some((of.time, updated.clone(), mean.clone()));
            states.push(Filtered { kept, predicted, updated, mean_predicted, mean });
        }
        Some((states, squares, logarithm))
    }

    /// Returns the coefficients by least squares under this drift; `None` where the observations do not determine them.
    pub fn solve(&self, all: &[Observation]) -> Option<Solution> {
        let (_, squares, logarithm) = self.filter(all)?;
        solution(&squares, logarithm)
    }

    /// Finds the drift of observations for one time: covariance and error by expectation and maximisation.
    ///
    /// `scale` is the deviation of each channel from which they start.
    fn found(time: f64, all: &[Observation], scale: &[f64], repeat: &[f64]) -> Option<(Self, Solution)> {
        let q = scale.len();
        let start = DMatrix::from_diagonal(&DVector::from_iterator(q, scale.iter().map(|s| C::new(s * s, 0.0))));
        let variance = scale.iter().map(|s| (ERROR * s).powi(2)).collect();
        let mut drift = Self { time, covariance: start.clone(), variance, repeat: repeat.to_vec(), prior: None };
        let coefficients = all.first()?.design.ncols() / q;
        let has_spare = (0..q).all(|c| all.iter().filter(|of| of.has(c)).count() > coefficients);
        // Without a run more than coefficients, nothing but the start is known.
        for _ in 0..if has_spare { ROUNDS } else { 0 } {
            drift = drift.improved(all, &start)?;
        }
        let solution = drift.solve(all)?;
        Some((drift, solution))
    }

    /// Finds the drift of observations: the one of `times` with the largest likelihood.
    pub fn estimated(all: &[Observation], repeat: &[f64], times: &[f64]) -> Option<(Self, Solution)> {
        let scale = scales(all, repeat)?;
        let of = |time: &f64| Self::found(*time, all, &scale, repeat);
        let found = ballrace_base::parallel::map(times, of).into_iter().flatten();
        found.max_by(|a, b| a.1.log_likelihood.total_cmp(&b.1.log_likelihood))
    }

    /// Returns the usual drift of a machine, where observations do not tell it without what is known of the coefficients before.
    pub fn usual(all: &[Observation], repeat: &[f64], prior: DMatrix<C>) -> Option<(Self, Solution)> {
        let q = repeat.len();
        let scale = |channel: usize| {
            let sizes = all.iter().filter(|of| of.has(channel)).map(|of| of.response[channel - of.first].norm());
            let (sum, count) = sizes.fold((0.0, 0), |(sum, count), size| (sum + size, count + 1));
            (USUAL * sum / f64::from(count.max(1))).max(repeat[channel].sqrt()).max(f64::MIN_POSITIVE.sqrt())
        };
        let covariance = DMatrix::from_fn(q, q, |i, j| C::new(if i == j { scale(i).powi(2) } else { 0.0 }, 0.0));
        let variance = (0..q).map(|channel| (ERROR * scale(channel)).powi(2)).collect();
        let drift = Self { time: f64::MIN_POSITIVE, covariance, variance, repeat: repeat.to_vec(), prior: Some(prior) };
        let solution = drift.solve(all)?;
        Some((drift, solution))
    }

    /// Returns the drift after one round of expectation and maximisation.
    fn improved(&self, all: &[Observation], start: &DMatrix<C>) -> Option<Self> {
        let (states, squares, logarithm) = self.filter(all)?;
        let theta = solution(&squares, logarithm)?.theta;
        let of_rest = |mean: &DMatrix<C>| -> DVector<C> { mean.column(0) - mean.columns(1, theta.len()) * &theta };
        let q = self.channels();
        let n = all.len();
        // The coefficients take their share of what is left, and of its covariance. A factor of 2 of both covariances, of drift and error, would
        // let them grow round by round without end.
        let values = all.iter().map(|of| of.response.len()).sum::<usize>() as f64;
        let share = values / (values - theta.len() as f64).max(1.0);
        let of_covariance = share.min(MOST_SHARE);
        let (share, of_covariance) = (C::new(share / of_covariance, 0.0), C::new(of_covariance, 0.0));
        let mut sum = DMatrix::<C>::zeros(q, q);
        let mut steps = 0.0;
        let mut errors = vec![(0.0, 0usize); q];
        let mut later: Option<(DVector<C>, DMatrix<C>, DMatrix<C>)> = None;
        for i in (0..n).rev() {
            let state = &states[i];
            let mean = of_rest(&state.mean);
            let (smoothed, covariance, gain) = match &later {
                None => (mean, state.updated.clone(), None),
                Some((next, next_covariance, _)) => {
                    let following = &states[i + 1];
                    let factors = following.predicted.clone().cholesky()?;
                    let gain = factors.solve(&(&state.updated * C::new(following.kept, 0.0))).adjoint();
                    let smoothed = &mean + &gain * (next - of_rest(&following.mean_predicted));
                    let covariance = &state.updated + &gain * (next_covariance - &following.predicted) * gain.adjoint();
                    (smoothed, covariance, Some(gain))
                }
            };
            if let (Some(gain), Some((next, next_covariance, _))) = (&gain, &later) {
                let kept = C::new(states[i + 1].kept, 0.0);
                let lost = 1.0 - states[i + 1].kept.powi(2);
                if lost > f64::EPSILON {
                    let step = next - &smoothed * kept;
                    let together = next_covariance * gain.adjoint();
                    let moment = &step * step.adjoint() * share + next_covariance + &covariance * (kept * kept)
                        - (&together + together.adjoint()) * kept;
                    sum += moment / C::new(lost, 0.0);
                    steps += 1.0;
                }
            }
            let of = &all[i];
            let fitted = &of.design * &theta;
            // Vectors with errors of mounted masses tell nothing of the smaller errors of a run.
            for p in (0..of.response.len()).filter(|_| of.by_masses.is_none()) {
                let channel = of.first + p;
                let left = (of.response[p] - fitted[p] - smoothed[channel]).norm_sqr();
                let (total, count) = &mut errors[channel];
                *total += share.re * left + covariance[(channel, channel)].re - self.repeat[channel] / of.count as f64;
                *count += 1;
            }
            if i == 0 {
                sum += &smoothed * smoothed.adjoint() * share + &covariance;
                steps += 1.0;
            }
            let gain = gain.unwrap_or_default();
            later = Some((smoothed, covariance, gain));
        }
        let covariance = (sum * of_covariance + start * C::new(PRIOR, 0.0)) / C::new(steps + PRIOR, 0.0);
        let covariance = (&covariance + covariance.adjoint()) * C::new(0.5, 0.0);
        let variance = (0..q).map(|channel| {
            let (total, count) = errors[channel];
            let least = (0.1 * self.repeat[channel]).max(1e-6 * start[(channel, channel)].re);
            (of_covariance.re * total / count.max(1) as f64).max(least)
        });
        Some(Self { variance: variance.collect(), covariance, ..self.clone() })
    }
}

/// Returns coefficients from the squares of innovations: of the vectors in the first row and column, then of the columns of `A`.
fn solution(squares: &DMatrix<C>, logarithm: f64) -> Option<Solution> {
    let columns = squares.ncols() - 1;
    let normal = squares.view((1, 1), (columns, columns)).into_owned();
    let right = squares.view((1, 0), (columns, 1)).column(0).into_owned();
    let factors = normal.cholesky()?;
    let theta = factors.solve(&right);
    let left = squares[(0, 0)].re - right.dotc(&theta).re;
    let of_normal = 2.0 * factors.l_dirty().diagonal().iter().map(|x| x.re.ln()).sum::<f64>();
    Some(Solution { covariance: factors.inverse(), theta, log_likelihood: -(logarithm + of_normal + left), left })
}

/// Returns the deviation of each channel that is left by plain least squares.
fn scales(all: &[Observation], repeat: &[f64]) -> Option<Vec<f64>> {
    let plain = Drift {
        time: f64::MIN_POSITIVE,
        covariance: DMatrix::zeros(repeat.len(), repeat.len()),
        variance: vec![1.0; repeat.len()],
        repeat: vec![0.0; repeat.len()],
        prior: None,
    };
    // Vectors with errors of mounted masses tell less of the scatter.
    let exact: Vec<Observation> = all.iter().filter(|of| of.by_masses.is_none()).cloned().collect();
    let theta = match plain.solve(&exact) {
        Some(solution) => solution.theta,
        None => plain.solve(all)?.theta,
    };
    let mut sums = vec![(0.0, 0usize, 0.0); repeat.len()];
    for of in &exact {
        let fitted = &of.design * &theta;
        for p in 0..of.response.len() {
            let (sum, count, size) = &mut sums[of.first + p];
            *size += of.response[p].norm();
            *sum += (of.response[p] - fitted[p]).norm_sqr();
            *count += 1;
        }
    }
    let coefficients = theta.len() / repeat.len().max(1);
    // Channels that plain least squares fits exactly have the repeatability left; without a run more than coefficients, nothing tells.
    let of = |((sum, count, size), repeat): (&(f64, usize, f64), &f64)| {
        let spare = count.saturating_sub(coefficients);
        let usual = if spare == 0 { USUAL * size / (*count).max(1) as f64 } else { 0.0 };
        (sum / spare.max(1) as f64).max(*repeat).max(usual * usual).sqrt()
    };
    Some(sums.iter().zip(repeat).map(of).collect())
}
