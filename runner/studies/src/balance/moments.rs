//! Moments of one condition: estimates with intervals from all choices of loaded planes.

use super::table::C;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Moment on a plane with its 95 % intervals.
#[derive(Debug, Clone, Serialize)]
pub struct MomentEstimate {
    /// Size, g mm.
    pub moment_g_mm: f64,
    /// Lower end of its interval; 0 where the plane may carry nothing.
    pub moment_low: f64,
    /// Upper end.
    pub moment_high: f64,
    /// Angle, 0 to 360 degrees.
    pub angle_deg: f64,
    /// Lower end of its interval, counted from the angle without a jump at 360.
    pub angle_low: f64,
    /// Upper end.
    pub angle_high: f64,
    /// Probability that the plane carries a mass.
    pub loaded: f64,
}

/// Points by which the distribution of a moment is described, about.
const POINTS: usize = 2000;
/// Relative standard deviation of a moment by the weights and by the radius of the holes, which trials and the sought masses have alike.
pub(super) const MASS_ERROR: f64 = 0.02;
/// Shares of a distribution outside its interval of 95 %.
const OUTSIDE: f64 = 0.025;

/// Returns the moments of a condition from the estimate by least squares and its covariance; `usual` is the mean square of
/// the trial moments. `None` if the covariance has no inverse.
///
/// With the least-squares estimate `m`, covariance `V` and the prior covariance `S` of the loaded planes of a choice, its evidence is
/// `exp(-m^H (V + S)^-1 m) / det(V + S)`, and its moments are `S (V + S)^-1 m` with the covariance `S - S (V + S)^-1 S`.
pub fn estimates(mean: &DVector<C>, covariance: &DMatrix<C>, usual: f64) -> Option<Vec<MomentEstimate>> {
    let planes = mean.len();
    let alone = covariance.clone().cholesky()?.inverse().diagonal().map(|x| 1.0 / x.re);
    let sizes = if planes <= ALL_SIZES { SIZES.as_slice() } else { &SIZES[..1] };
    // Of each plane a digit: 0 for an empty one, else its size.
    let states = 1 + sizes.len();
    let digit = |choice: usize, plane: usize| match u32::try_from(plane) {
        Ok(power) if plane < MOST_CHOICES => choice / states.pow(power) % states,
        _ => 1,
    };
    let choices = states.pow(u32::try_from(planes.min(MOST_CHOICES)).unwrap_or_default());
    let choice = |choice: usize| {
        let variance = |i: usize| match digit(choice, i) {
            0 => 0.0,
            size => (usual * sizes[size - 1].powi(2)).max(alone[i]),
        };
        let prior = DMatrix::from_fn(planes, planes, |i, j| C::new(if i == j { variance(i) } else { 0.0 }, 0.0));
        let loaded = (0..planes).filter(|&i| digit(choice, i) > 0).count();
        let factors = (covariance + &prior).cholesky()?;
        let logarithm = 2.0 * factors.l_dirty().diagonal().iter().map(|x| x.re.ln()).sum::<f64>();
        let weighted = factors.solve(mean);
        let evidence = -logarithm - mean.dotc(&weighted).re - loaded as f64 * (sizes.len() as f64).ln();
        let variance = &prior - &prior * factors.solve(&prior);
        Some((evidence, &prior * weighted, variance))
    };
    let found = (0..choices).map(choice).collect::<Option<Vec<_>>>()?;
    let most = found.iter().map(|one| one.0).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = found.iter().map(|one| (one.0 - most).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let plane = |k: usize| {
        let mut sizes: Vec<(f64, f64)> = vec![];
        let mut points: Vec<(C, f64)> = vec![];
        let mut empty = 0.0;
        for (choice, ((_, mean, variance), weight)) in found.iter().zip(&weights).enumerate() {
            let weight = weight / sum;
            if digit(choice, k) == 0 {
                empty += weight;
                continue;
            }
            let deviation = variance[(k, k)].re.max(0.0).sqrt().hypot(MASS_ERROR * mean[k].norm());
            let count = (weight * POINTS as f64).ceil();
            points.extend(normal(mean[k], deviation, count as usize).map(|point| (point, weight / count)));
        }
        sizes.push((0.0, empty));
        sizes.extend(points.iter().map(|(point, weight)| (point.norm(), *weight)));
        let [moment_low, moment_g_mm, moment_high] = quantiles(sizes);
        let middle: C = points.iter().map(|(point, weight)| *point * *weight).sum();
        let angle = middle.arg();
        // An empty plane has no angle.
        let spread = if moment_low > 0.0 {
            let turned = points.iter().map(|(point, weight)| ((*point * C::from_polar(1.0, -angle)).arg(), *weight));
            let [low, _, high] = quantiles(turned.collect());
            [low, high]
        } else {
            [-PI, PI]
        };
        let angle = angle.rem_euclid(TAU);
        MomentEstimate {
            moment_g_mm,
            moment_low,
            moment_high,
            angle_deg: angle.to_degrees(),
            angle_low: (angle + spread[0]).to_degrees(),
            angle_high: (angle + spread[1]).to_degrees(),
            loaded: 1.0 - empty,
        }
    };
    Some((0..planes).map(plane).collect())
}

/// Planes whose choices are compared; further ones count as loaded.
const MOST_CHOICES: usize = 8;
/// Planes up to which all sizes are compared, else the first alone.
const ALL_SIZES: usize = 4;
/// Sizes of a moment over that of the trial masses, each as likely as the others, and all together as likely as an empty plane: an unknown
/// mass may be far smaller than a trial mass. 0 stands for the smallest that a plane shows, its standard deviation.
const SIZES: [f64; 4] = [1.0, 0.25, 0.0625, 0.0];

/// Returns `count` points of a complex normal distribution of equal weight, evenly spread: a spiral of the golden angle.
fn normal(mean: C, deviation: f64, count: usize) -> impl Iterator<Item = C> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let share = (i as f64 + 0.5) / count as f64;
        mean + C::from_polar(deviation * (-(1.0 - share).ln()).sqrt(), golden * i as f64)
    })
}

/// Returns lower end, median and upper end of weighted values.
fn quantiles(mut values: Vec<(f64, f64)>) -> [f64; 3] {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sum: f64 = values.iter().map(|value| value.1).sum();
    [OUTSIDE, 0.5, 1.0 - OUTSIDE].map(|share| {
        let mut before = 0.0;
        let reached = values.iter().find(|(_, weight)| {
            before += weight;
            before >= share * sum
        });
        reached.or(values.last()).map_or(0.0, |value| value.0)
    })
}
