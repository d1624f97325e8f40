//! Moments that a condition carries, and the known conditions estimated from the others.

use super::drift::{Drift, Observation};
use super::moments::{self, MomentEstimate};
use super::runs::{Run, Runs};
use super::table::C;
use ballrace_base::parallel;
use nalgebra::DVector;
use serde::Serialize;

/// Steps of the search of moments and coefficients together, and the change of a moment over the trial moments at which it ends.
const STEPS: (usize, f64) = (30, 1e-9);

/// Moments that a condition carries.
#[derive(Debug, Clone, Serialize)]
pub struct Condition {
    /// Name.
    pub condition: String,
    /// Moment on each plane.
    pub planes: Vec<MomentEstimate>,
    /// Vectors of the runs that the moments leave, over the standard deviation expected of them: about 1 where all is as modelled.
    pub misfit: f64,
}

/// How well each known condition is estimated from the others.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Proof {
    /// Moments estimated.
    pub moments: usize,
    /// Mean error of their size, g mm.
    pub mean_error_g_mm: f64,
    /// Largest error of their size, g mm.
    pub largest_error_g_mm: f64,
    /// Mean error of the angle of the moments that are not 0, degrees.
    pub mean_angle_error_deg: f64,
    /// Intervals of the size that hold the true moment.
    pub inside: usize,
}

impl Runs {
    /// Estimates the moments of a condition from the known ones and its own runs: one that no masses explain spoils no other.
    pub(super) fn moments(&self, drift: &Drift, known: &DVector<C>, asked: usize) -> Option<Condition> {
        let used: Vec<&Run> = self.all.iter().filter(|run| run.condition == asked || run.moments.is_some()).collect();
        let mut moments = vec![C::new(0.0, 0.0); self.planes];
        let mut theta = known.clone();
        let mut solution = None;
        for _ in 0..STEPS.0 {
            // About the coefficients and moments of the step before: y = B + C u + u' dC + C' du.
            let observed = used.iter().map(|run| {
                if run.condition != asked {
                    return self.observation(run, run.moments.as_deref().unwrap_or_default(), self.planes);
                }
                let mut of = self.observation(run, &moments, self.planes);
                for p in 0..self.probes {
                    for (k, moment) in moments.iter().enumerate() {
                        let coefficient = theta[self.column(of.first + p, 1 + k)];
                        of.design[(p, self.coefficients() + k)] = coefficient;
                        of.response[p] += coefficient * moment;
                    }
                }
                of
            });
            let next = drift.solve(&observed.collect::<Vec<Observation>>())?;
            let mut change = 0.0_f64;
            for (moment, new) in moments.iter_mut().zip(next.theta.iter().skip(self.coefficients())) {
                change = change.max((new - *moment).norm());
                *moment = *new;
            }
            theta = next.theta.rows(0, self.coefficients()).into_owned();
            solution = Some(next);
            if change < STEPS.1 * self.usual.sqrt() {
                break;
            }
        }
        let solution = solution?;
        let wider = few_values(self.known(), self.planes);
        let at = self.coefficients();
        let covariance = solution.covariance.view((at, at), (self.planes, self.planes)) * C::new(wider * wider, 0.0);
        Some(Condition {
            condition: self.conditions[asked].clone(),
            planes: moments::estimates(&DVector::from_column_slice(&moments), &covariance, self.usual)?,
            misfit: self.misfit(drift, known, &moments, asked),
        })
    }

    /// Returns the rms of the vectors of a condition that moments leave, over that expected by drift and error.
    fn misfit(&self, drift: &Drift, theta: &DVector<C>, moments: &[C], condition: usize) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for run in self.all.iter().filter(|run| run.condition == condition) {
            let of = self.observation(run, moments, 0);
            let fitted = &of.design * theta;
            for p in 0..self.probes {
                let channel = of.first + p;
                let expected =
                    drift.covariance[(channel, channel)].re + drift.variance[channel] + drift.repeat[channel];
                sum += (of.response[p] - fitted[p]).norm_sqr() / expected.max(f64::MIN_POSITIVE);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// Estimates each known condition from the others.
    pub(super) fn proof(&self, time: f64) -> Proof {
        let known: Vec<(usize, Vec<C>)> = {
            let of = |condition: usize| {
                let run = self.all.iter().find(|run| run.condition == condition)?;
                Some((condition, run.moments.clone()?))
            };
            (0..self.conditions.len()).filter_map(of).collect()
        };
        let estimated = |(condition, truth): &(usize, Vec<C>)| {
            let asked = |run: &Run| {
                if run.condition == *condition { Run { moments: None, ..run.clone() } } else { run.clone() }
            };
            let others = self.with(self.all.iter().map(asked).collect());
            if others.known() < if self.prior.is_some() { 1 } else { self.planes + 2 } {
                return None;
            }
            let (drift, solution) = others.learned(&[time])?;
            let found = others.moments(&drift, &solution.theta, *condition)?;
            Some((truth.clone(), found))
        };
        let mut proof = Proof::default();
        let (mut errors, mut angles) = (vec![], vec![]);
        for (truth, found) in parallel::map(&known, estimated).into_iter().flatten() {
            for (truth, found) in truth.iter().zip(&found.planes) {
                errors.push((found.moment_g_mm - truth.norm()).abs());
                proof.inside += usize::from((found.moment_low..=found.moment_high).contains(&truth.norm()));
                if truth.norm_sqr() > 0.0 {
                    let turn = C::from_polar(1.0, found.angle_deg.to_radians()) / truth;
                    angles.push(turn.arg().to_degrees().abs());
                }
            }
        }
        let mean = |of: &[f64]| (of.iter().sum::<f64>() + 0.0) / of.len().max(1) as f64;
        proof.moments = errors.len();
        proof.mean_error_g_mm = mean(&errors);
        proof.largest_error_g_mm = errors.iter().copied().fold(0.0, f64::max);
        proof.mean_angle_error_deg = mean(&angles);
        proof
    }
}

/// Returns how much wider an interval of 95 % is where its deviation comes from few runs: Student's t over the normal value, for two
/// degrees of freedom (real and imaginary part) a run beyond the coefficients.
///
/// Source: expansion of Fisher and Cornish, Abramowitz and Stegun 26.7.5.
fn few_values(known: usize, planes: usize) -> f64 {
    const Z: f64 = 1.959_964;
    let n = 2.0 * known.saturating_sub(1 + planes).max(1) as f64;
    let (z3, z5, z7) = (Z.powi(3), Z.powi(5), Z.powi(7));
    let t = Z
        + (z3 + Z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * Z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * Z) / (384.0 * n * n * n);
    t / Z
}
