//! Estimates of the unknowns of a fitted machine, with their 95 % intervals.

use super::Result;
use super::fit::{Fitted, changed, fit};
use super::parameter::Unknown;
use super::residual::Evidence;
use super::residual::site::{DEPENDENT, GAIN_ERROR};
use super::surface::Component;
use ballrace_outcome::Estimate;
use ballrace_scene::RotationSource;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// Number of standard deviations within which a normally distributed error lies in 95 of 100 cases.
const WITHIN_95: f64 = 1.96;
/// Relative standard deviation of sizes by the model: Young's modulus of bearing steel, and with it every force, is not known better.
pub(crate) const STIFFNESS_ERROR: f64 = 0.005;
/// The same at a site: with catalogue dimensions the stiffness of a bearing is known to 5 %.
const STIFFNESS_ERROR_OF_SITE: f64 = 0.05;
/// Search for the end of an interval: share of the error of the profile below which it is not made, factor of its steps, steps of the
/// fit of the other unknowns, and largest size over that of a parabola.
const SMALL: f64 = 0.4;
const WIDER: f64 = 1.6;
const REFITTED: usize = 3;
const FARTHEST: f64 = 10.0;

/// A fitted machine whose unknowns are estimated.
pub struct Estimates<'a, 'b> {
    pub e: &'a Evidence<'b>,
    pub last: &'a Fitted,
    /// Factor of deviations: residual over noise.
    pub inflation: f64,
    /// Relative standard deviation of a size by what the fault leaves at its lines.
    pub error_at_lines: f64,
}

impl Estimates<'_, '_> {
    /// Returns the relative standard deviation of a size, by its model, and by the gain of the probes and the stiffness of the bearings of a
    /// site.
    fn scale_error(&self, model_error: f64) -> f64 {
        if self.e.site.is_some() { model_error.hypot(GAIN_ERROR).hypot(STIFFNESS_ERROR_OF_SITE) } else { model_error }
    }

    /// Returns the standard deviation of an angle by the direction of the probes of a site, rad.
    fn direction_error(&self) -> f64 {
        if self.e.site.is_some() { GAIN_ERROR } else { 0.0 }
    }

    pub fn deviation(&self, unknown: Unknown) -> f64 {
        let at = self.last.unknowns.iter().position(|u| *u == unknown);
        let variance = at.map_or(0.0, |i| self.last.covariance.get((i, i)).copied().unwrap_or(0.0));
        self.inflation * variance.max(0.0).sqrt()
    }

    /// Returns the deviation of two unknowns along a direction.
    fn deviation_along(&self, unknowns: [Unknown; 2], direction: [f64; 2]) -> f64 {
        let at = |u: Unknown| self.last.unknowns.iter().position(|other| *other == u);
        let [Some(i), Some(j)] = unknowns.map(at) else { return 0.0 };
        let c = |i: usize, j: usize| self.last.covariance.get((i, j)).copied().unwrap_or(0.0);
        let [x, y] = direction;
        let variance = x * x * c(i, i) + 2.0 * x * y * c(i, j) + y * y * c(j, j);
        self.inflation * variance.max(0.0).sqrt()
    }

    /// Returns the decrease and the increase of an unknown at which chi-squared has risen as by [`WITHIN_95`] deviations, with the other
    /// unknowns fitted again. The rise is not a parabola where an element loses contact: more depth changes no force.
    fn reach(&self, unknown: Unknown, model_error: f64) -> [f64; 2] {
        let linear = WITHIN_95 * self.deviation(unknown);
        if linear < SMALL * model_error * unknown.get(&self.last.machine) {
            return [linear; 2];
        }
        let Some(i) = self.last.unknowns.iter().position(|u| *u == unknown) else { return [linear; 2] };
        let variance = self.last.covariance[(i, i)];
        if variance.is_nan() || variance <= 0.0 {
            return [linear; 2];
        }
        let allowed = WITHIN_95 * self.inflation;
        let is_other = |u: &Unknown| *u != unknown && u.part() == unknown.part();
        let others: Vec<Unknown> = self.last.unknowns.iter().copied().filter(is_other).collect();
        // Returns the machine with the unknown changed, from one with another change.
        let moved = |from: &Fitted, change: f64| {
            let mut machine = from.machine.clone();
            let step = unknown.get(&self.last.machine) + change - unknown.get(&from.machine);
            for (j, other) in self.last.unknowns.iter().enumerate() {
                other.set(&mut machine, other.get(&from.machine) + step * self.last.covariance[(i, j)] / variance);
            }
            changed(self.e, from, &machine).and_then(|moved| fit(self.e, &moved, &others, REFITTED)).ok()
        };
        let rise = |of: &Fitted| (of.chi_square - self.last.chi_square).max(0.0).sqrt();
        [-1.0, 1.0].map(|sign| {
            let (mut reach, most) = (linear, FARTHEST * linear);
            let (mut before, mut last) = ((linear, 0.0), Cow::Borrowed(self.last));
            while let Some(next) = moved(&last, sign * reach) {
                let rise = rise(&next);
                if rise > allowed {
                    let share = (allowed - before.1) / (rise - before.1);
                    return before.0 + share * (reach - before.0);
                }
                if reach >= most {
                    break;
                }
                before = (reach, rise);
                last = Cow::Owned(next);
                reach *= WIDER;
            }
            reach.min(most)
        })
    }

    /// Returns an unknown whose size the model changes by a relative standard deviation of `model_error`.
    pub fn estimate(&self, unknown: Unknown, unit: f64, model_error: f64) -> Estimate {
        let value = unknown.get(&self.last.machine) / unit;
        // At a site, what was not known of it in the baseline is not known now.
        let known = if self.e.site.is_some() { self.e.known_deviation(unknown) } else { 0.0 };
        let deviation = self.deviation(unknown).hypot(known) / unit.abs();
        around(value, deviation.hypot(self.scale_error(model_error) * value))
    }

    /// Returns an unknown as [`Estimates::estimate`], with the ends of its interval by the profile of chi-squared.
    pub(crate) fn profile_estimate(&self, unknown: Unknown, unit: f64, model_error: f64) -> Estimate {
        let value = unknown.get(&self.last.machine) / unit;
        let reach = self.reach(unknown, model_error);
        let scale_error = self.scale_error(model_error);
        let [down, up] = reach.map(|reach| (reach / unit).hypot(WITHIN_95 * scale_error * value));
        Estimate { value, low: value - down, high: value + up }
    }

    /// Angle on a component; on the inner race it is counted from the keyphasor mark.
    pub fn angle(&self, unknown: Unknown, component: Component) -> Estimate {
        let value = unknown.get(&self.last.machine).to_degrees();
        let angle = around(value, self.deviation(unknown).hypot(self.direction_error()).to_degrees());
        within_turn(if component == Component::Inner { self.with_pulse_error(angle) } else { angle })
    }

    /// Widens an angle from the keyphasor mark: its pulse is detected at the first sample after it, up to one sample late.
    pub(crate) fn with_pulse_error(&self, angle: Estimate) -> Estimate {
        let rotation = self.e.scene.recording.as_ref().map(|recording| &recording.rotation);
        if !matches!(rotation, Some(RotationSource::Keyphasor { .. })) {
            return angle;
        }
        let late = (self.e.motion.mean_speed() * self.e.motion.period).to_degrees() / 3.0_f64.sqrt();
        around(angle.value, ((angle.high - angle.value) / WITHIN_95).hypot(late))
    }

    /// Size and direction of a vector of two unknowns.
    pub fn vector(&self, [x, y]: [Unknown; 2], unit: f64) -> [Estimate; 2] {
        let (a, b) = (x.get(&self.last.machine), y.get(&self.last.machine));
        let size = a.hypot(b).max(1e-30);
        let (along, across) =
            (self.deviation_along([x, y], [a / size, b / size]), self.deviation_along([x, y], [-b / size, a / size]));
        let across = (across / size).hypot(self.direction_error());
        let along = (along / unit).hypot(self.scale_error(STIFFNESS_ERROR) * size / unit);
        // An error of the model multiplies the size.
        let factor = 1.0 + WITHIN_95 * self.error_at_lines;
        let Estimate { value, low, high } = around(size / unit, along);
        [
            not_negative(Estimate { value, low: low / factor, high: high * factor }),
            within_turn(around(b.atan2(a).to_degrees(), across.to_degrees())),
        ]
    }
}

/// Adds the contribution of the uncertain parameters of the machine to the covariance of a fit, of whose unknowns some were fitted to means as well as to
/// lines. Of a site, [`DEPENDENT`] values of the residual are evidence of one.
pub(crate) fn with_uncertain_parameters(e: &Evidence, mut last: Fitted, of_means: &[Unknown]) -> Result<Fitted> {
    let changes = e.uncertain_changes(&last.spectra, &last.machine)?;
    if changes.is_empty() || last.unknowns.is_empty() {
        return Ok(last);
    }
    let dependent = if e.site.is_some() { DEPENDENT } else { 1.0 };
    let (spectra, machine) = (&last.spectra, &last.machine);
    let of_lines: Vec<Unknown> = last.unknowns.iter().copied().filter(|unknown| !of_means.contains(unknown)).collect();
    let mut slopes = e.slopes(spectra, machine, &of_lines)?;
    slopes.extend(e.moving_slopes(spectra, machine, of_means)?.into_iter().map(|[lines, _]| lines));
    let weights: Vec<f64> =
        last.unknowns.iter().map(|unknown| if of_means.contains(unknown) { 1.0 / DEPENDENT } else { 1.0 }).collect();
    let residual = DVector::from_column_slice(&last.residual);
    last.covariance +=
        by_uncertain((&last.covariance, &weights), &matrix(&slopes), matrix(&changes), &residual, dependent);
    Ok(last)
}

/// Returns what uncertain parameters add to the covariance `C` of unknowns with the slopes `J`, in whose fit each value had the weights `D`.
///
/// With the changes `V` of the residual `r` by one deviation of each parameter, the unknowns change by `-C D J^T V` per deviation. What the
/// unknowns do not make up for, `W = V - J C D J^T V`, limits the parameters to the covariance `S = (1 + W^T W)^-1` about the mean `S W^T r`.
fn by_uncertain(
    (covariance, weights): (&DMatrix<f64>, &[f64]),
    slopes: &DMatrix<f64>,
    changes: DMatrix<f64>,
    residual: &DVector<f64>,
    dependent: f64,
) -> DMatrix<f64> {
    let along = slopes.tr_mul(&changes);
    let moved = covariance * DMatrix::from_fn(along.nrows(), along.ncols(), |i, j| weights[i] * along[(i, j)]);
    let left = changes - slopes * &moved;
    let precision = DMatrix::<f64>::identity(left.ncols(), left.ncols()) + left.tr_mul(&left) / dependent;
    let known = precision.try_inverse().unwrap_or_else(|| DMatrix::identity(left.ncols(), left.ncols()));
    let mean = &known * left.tr_mul(residual) / dependent;
    &moved * (known + &mean * mean.transpose()) * moved.transpose()
}

/// Returns the matrix of some columns.
fn matrix(columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.first().map_or(0, Vec::len), columns.len(), |i, j| columns[j][i])
}

/// Returns the estimate of a size, whose interval has no negative part.
pub fn not_negative(e: Estimate) -> Estimate {
    Estimate { low: e.low.max(0.0), ..e }
}

/// Describes an estimate by its value and interval.
pub fn described(estimate: Option<Estimate>, digits: usize) -> String {
    estimate.map_or(String::new(), |e| format!("{:.digits$} ({:.digits$} to {:.digits$})", e.value, e.low, e.high))
}

/// Describes a size that is not negative; by its interval alone if that includes 0.
pub(crate) fn described_size(estimate: Option<Estimate>, digits: usize) -> String {
    match estimate {
        Some(e) if e.low <= 0.0 => format!("between 0 and {:.digits$}", e.high),
        _ => described(estimate, digits),
    }
}

/// Returns an estimate from its standard deviation.
pub fn around(value: f64, deviation: f64) -> Estimate {
    let half = WITHIN_95 * deviation;
    Estimate { value, low: value - half, high: value + half }
}

/// Returns an angle with its value between 0 and 360 degrees.
pub(crate) fn within_turn(e: Estimate) -> Estimate {
    let shift = e.value.rem_euclid(360.0) - e.value;
    Estimate { value: e.value + shift, low: e.low + shift, high: e.high + shift }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the covariance of a fit of both together, whose parameters are known with a deviation of 1.
    #[test]
    fn uncertain_parameters_add_what_a_fit_of_both_has() {
        let value = |i: usize, j: usize| ((0.7 + 0.4 * j as f64) * i as f64).sin();
        let slopes = DMatrix::from_fn(40, 3, |i, j| 3.0 * value(i, j));
        let changes = DMatrix::from_fn(40, 2, |i, j| value(i, j) + 0.3 * value(i, j + 5));
        let inverse = |x: DMatrix<f64>| x.try_inverse().unwrap_or_default();
        let covariance = inverse(slopes.tr_mul(&slopes));
        let none = DVector::zeros(40);
        let added = by_uncertain((&covariance, &[1.0; 3]), &slopes, changes.clone(), &none, 1.0);
        let both = DMatrix::from_fn(40, 5, |i, j| if j < 3 { slopes[(i, j)] } else { changes[(i, j - 3)] });
        let mut normal = both.tr_mul(&both);
        (3..5).for_each(|j| normal[(j, j)] += 1.0);
        let whole = inverse(normal);
        let expected = whole.view((0, 0), (3, 3)) - &covariance;
        assert!((&added - &expected).norm() < 1e-9 * expected.norm(), "{added} instead of {expected}");
        // Values of a quarter of the weight determine the unknowns with four times the covariance, and move them as much.
        let quarter = by_uncertain((&(4.0 * &covariance), &[0.25; 3]), &slopes, changes.clone(), &none, 1.0);
        assert!((&quarter - &added).norm() < 1e-9 * added.norm());
        // A residual along what the unknowns do not make up for is a parameter that is off: they are as well.
        let left = &changes - &slopes * (&covariance * slopes.tr_mul(&changes));
        let off = by_uncertain((&covariance, &[1.0; 3]), &slopes, changes.clone(), &(5.0 * left.column(0)), 1.0);
        assert!(off.trace() > 2.0 * added.trace());
        // Where many values are evidence of one, the parameters are known as before.
        let vague = by_uncertain((&covariance, &[1.0; 3]), &slopes, changes.clone(), &none, 1e9);
        let moved = &covariance * slopes.tr_mul(&changes);
        let unlimited = &moved * moved.transpose();
        assert!((&vague - &unlimited).norm() < 1e-6 * unlimited.norm());
    }

    #[test]
    fn a_size_has_no_negative_part() {
        let unclear = not_negative(around(3.93, 46.4));
        assert_eq!((unclear.low, unclear.value), (0.0, 3.93));
        assert_eq!(described_size(Some(unclear), 1), "between 0 and 94.9");
        assert_eq!(described_size(Some(not_negative(around(3.0, 0.1))), 2), "3.00 (2.80 to 3.20)");
    }

    #[test]
    fn an_angle_or_a_preload_may_be_zero_or_less() {
        assert_eq!(described(Some(around(0.0, 0.0)), 1), "0.0 (0.0 to 0.0)");
        assert_eq!(described(Some(around(-2.0, 1.0)), 1), "-2.0 (-4.0 to -0.0)");
    }
}
