//! Uncertainty of the estimates: covariance of the unknowns, with correlated residuals, and the intervals that follow from it.

use super::Estimate;
use super::model::Model;
use super::parameters::Parameter;
use super::search::{Solution, probe_residuals};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Largest lag of the residual's autocorrelation, samples.
const MEMORY: usize = 64;

/// Returns the covariance of the unknowns in units of their priors: the inverse of the information of the recording, from
/// the slopes over the variance of the correlated residuals, and of the prior.
pub(super) fn covariance(solution: &Solution, model: &Model) -> DMatrix<f64> {
    let normal = solution.jacobian.transpose() * &solution.jacobian;
    let n = solution.jacobian.ncols();
    let probe_residuals = probe_residuals(solution, model.rows.len(), model.of);
    let variance = probe_residuals.iter().map(|r| r * r).sum::<f64>() / probe_residuals.len().max(1) as f64;
    // Correlated samples carry less information; the prior keeps its weight.
    let share = 1.0 / (variance.max(1.0) * memory(probe_residuals, model.rows.len()));
    let prior = DMatrix::identity(n, n);
    let inverse = ((normal - &prior) * share + prior).try_inverse();
    inverse.unwrap_or_else(|| DMatrix::identity(n, n))
}

/// Returns the covariance `of` the identifiable unknowns among all; the others have their variances from `open`.
pub(super) fn expanded(of: &DMatrix<f64>, open: &DMatrix<f64>, identified: &[usize]) -> DMatrix<f64> {
    let mut all = DMatrix::from_diagonal(&open.diagonal());
    for (a, &i) in identified.iter().enumerate() {
        for (b, &j) in identified.iter().enumerate() {
            all[(i, j)] = of[(a, b)];
        }
    }
    all
}

/// Returns the number of correlated samples that carry the information of one independent sample: `1 + 2 sum rho_k`, at least 1.
pub(super) fn memory(left: &[f64], probes: usize) -> f64 {
    let mut worst = 1.0_f64;
    for p in 0..probes {
        let own: Vec<f64> = left.iter().skip(p).step_by(probes.max(1)).copied().collect();
        let square: f64 = own.iter().map(|r| r * r).sum();
        let along = |k: usize| own.iter().zip(own.iter().skip(k)).map(|(a, b)| a * b).sum::<f64>() / square.max(1e-300);
        // Up to the first insignificant value; the standard error is about 1/sqrt(n).
        let chance = 2.0 / (own.len().max(1) as f64).sqrt();
        let sum: f64 = (1..MEMORY).map(along).take_while(|rho| *rho > chance).sum();
        worst = worst.max(1.0 + 2.0 * sum);
    }
    worst
}

/// Returns amount, angle and station of the unbalance, and whether one plane is enough. `origin` is the station of the centre of mass as
/// drawn, m.
pub(super) fn unbalance(
    values: &[f64],
    covariance: &DMatrix<f64>,
    unknown: &[Parameter],
    [e, c]: [usize; 2],
    z: f64,
    angle_step: f64,
    origin: f64,
) -> (Vec<Estimate>, bool) {
    let index = [e, e + 1, c, c + 1];
    let [ex, ey, cx, cy] = index.map(|i| values[i]);
    let amount = ex.hypot(ey).max(1e-30);
    let (angle, station) = (ey.atan2(ex), (cx * ex + cy * ey) / (amount * amount));
    let across = (cy * ex - cx * ey) / amount;
    // Derivatives of amount, angle, station and the couple across by the four unknowns.
    let of_amount = [ex / amount, ey / amount, 0.0, 0.0];
    let of_angle = [-ey / (amount * amount), ex / (amount * amount), 0.0, 0.0];
    let square = amount * amount;
    let of_station = [(cx - 2.0 * station * ex) / square, (cy - 2.0 * station * ey) / square, ex / square, ey / square];
    let of_across =
        [cy / amount - across * ex / square, -cx / amount - across * ey / square, -ey / amount, ex / amount];
    let half = |slopes: [f64; 4]| {
        let mut sum = 0.0;
        for (a, i) in slopes.iter().zip(index) {
            for (b, j) in slopes.iter().zip(index) {
                sum += a * b * covariance[(i, j)] * unknown[i].scale * unknown[j].scale;
            }
        }
        z * sum.max(0.0).sqrt()
    };
    let given = |k: usize| unknown[index[k]].given;
    let given_amount = given(0).hypot(given(1));
    let [given_station, given_across] = if given_amount > 0.0 {
        let along = given(2) * given(0) + given(3) * given(1);
        [along / (given_amount * given_amount), (given(3) * given(0) - given(2) * given(1)) / given_amount]
    } else {
        [0.0; 2]
    };
    let single = across.abs() <= half(of_across);
    let identified = half(of_amount) < amount;
    let estimate = |name: &str, unit, size: f64, given: f64, value: f64, plus_minus: f64| Estimate {
        name: name.to_owned(),
        unit,
        given: given / size,
        value: value / size,
        low: Some((value - plus_minus) / size),
        high: Some((value + plus_minus) / size),
        identified,
    };
    let degree = TAU / 360.0;
    let mut all = vec![
        estimate("unbalance: moment", "g mm", 1e-6, given_amount, amount, half(of_amount)),
        estimate(
            "unbalance: angle",
            "deg",
            degree,
            given(1).atan2(given(0)).rem_euclid(TAU),
            angle.rem_euclid(TAU),
            half(of_angle).hypot(angle_step),
        ),
        estimate("unbalance: station", "mm", 1e-3, origin + given_station, origin + station, half(of_station)),
    ];
    if !single {
        all.push(estimate("unbalance: couple across", "g mm^2", 1e-9, given_across, across, half(of_across)));
    }
    (all, single)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_residual_does_not_widen_intervals() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let white: Vec<f64> = (0..4000).map(|_| noise()).collect();
        assert!(memory(&white, 1) < 1.2);
        // For a first-order process with correlation rho the sum is (1 + rho)/(1 - rho).
        let mut last = 0.0;
        let slow: Vec<f64> = white
            .iter()
            .map(|x| {
                last = 0.8 * last + x;
                last
            })
            .collect();
        assert!((memory(&slow, 1) / 9.0 - 1.0).abs() < 0.3, "{}", memory(&slow, 1));
    }
}
