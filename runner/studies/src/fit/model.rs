//! The twin over the samples of a recording as a function of the unknowns: residuals at the probes, and their priors.

use super::parameters::{Parameter, with};
use super::{FitInput, turns_of};
use ballrace_base::least_squares::Bounds;
use ballrace_base::time_limit::TimeLimit;
use ballrace_plant::Plant;
use ballrace_plant::error::{FitError, Result};
use ballrace_plant::motion::check_overflow;
use ballrace_plant::probes::reading;

/// Units of the unknowns of the initial state: m, rad, m/s, rad/s.
const STATE: [f64; 4] = [50e-6, 5e-4, 0.05, 0.5];

#[derive(Clone, Copy)]
pub(super) struct Model<'a> {
    pub(super) of: &'a FitInput<'a>,
    /// Plant of the scene: those of the search have its coordinates.
    pub(super) plant: &'a Plant,
    pub(super) rows: &'a [Vec<f64>],
    pub(super) sigma: &'a [f64],
    pub(super) unknown: &'a [Parameter],
    /// Prior mean of every unknown, each with a standard deviation of 1.
    pub(super) prior: &'a [f64],
    /// Number of shaft revolutions in all samples of the fit.
    pub(super) all_turns: f64,
    pub(super) time_limit: TimeLimit,
}

impl Model<'_> {
    pub(super) fn values(&self, x: &[f64]) -> Vec<f64> {
        self.unknown.iter().zip(x).map(|(p, x)| p.value(*x)).collect()
    }

    /// Returns the residuals with those of the priors, each with a weight.
    pub(super) fn weighted_residuals(&self, x: &[f64], weight: f64) -> Result<Vec<f64>> {
        let mut left = self.residuals(x)?;
        left.extend(x.iter().zip(self.prior).map(|(x, prior)| weight * (x - prior)));
        Ok(left)
    }

    /// Returns the error that the time has ended.
    fn too_long(&self) -> FitError {
        FitError::TooLong {
            recording: self.of.recording.to_owned(),
            limit_s: self.time_limit.seconds(),
            turns: self.turns(),
            all_turns: self.all_turns,
        }
    }

    /// Returns the rms of the residuals `left` at probe `p`, m.
    pub(super) fn rms(&self, left: &[f64], p: usize) -> f64 {
        let own = left.iter().take(self.of.samples.len() * self.rows.len()).skip(p).step_by(self.rows.len());
        (own.clone().map(|r| r * r).sum::<f64>() / own.count().max(1) as f64).sqrt() * self.sigma[p]
    }

    /// Returns the number of shaft revolutions in the samples.
    pub(super) fn turns(&self) -> f64 {
        match self.of.samples {
            [first, .., last] => (turns_of(last) - turns_of(first)).abs(),
            _ => 0.0,
        }
    }

    /// Returns the bounds of unknowns that move together: the intersection of their bounds.
    pub(super) fn bounds(&self, tied: &[usize]) -> Bounds {
        let each = tied.iter().filter_map(|&i| self.unknown.get(i)).map(Parameter::unknown_bounds);
        each.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [a, b]| [low.max(a), high.min(b)])
    }

    /// Computes the residuals by sample and probe, in units of the probes' noise; 0 for a missing reading.
    ///
    /// After the end of the time it is an error. A search takes that at a trial step for a bad step, and at the slopes it ends.
    pub(super) fn residuals(&self, x: &[f64]) -> Result<Vec<f64>> {
        if self.time_limit.is_over() {
            return Err(self.too_long().into());
        }
        let (values, state) = (self.values(x), x.get(self.unknown.len()..).unwrap_or_default());
        let scene = with(self.of.scene, self.unknown, &values);
        let plant = Plant::alike(&scene, self.plant)?;
        let probes = scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
        let given = self.of.scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
        let Some(first) = self.of.samples.first() else { return Ok(vec![]) };
        let mut twin = plant.start(self.of.period, turns_of(first))?;
        let first_state: Vec<f64> = state.iter().zip(state_units(&plant)).map(|(x, unit)| x * unit).collect();
        let (q, rate) = first_state.split_at(first_state.len() / 2);
        twin.place(q, rate);
        let mut left = Vec::with_capacity(self.of.samples.len() * self.rows.len());
        for (i, sample) in self.of.samples.iter().enumerate() {
            let coordinates = twin.coordinates();
            for (p, (row, measured)) in self.rows.iter().zip(&sample.row.probes).enumerate() {
                // The reader has already subtracted the scene's own offset.
                let more = probes[p].offset - given[p].offset;
                let off = (measured - more - reading(row, coordinates)) / self.sigma[p];
                left.push(if off.is_finite() { off.clamp(-1e6, 1e6) } else { 0.0 });
            }
            let steps = self.of.samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
            let drive = sample.shaft_motion();
            for k in 0..steps {
                let is_held = twin.step(&drive.after(k as f64 * self.of.period)).is_held();
                let time = (sample.row.index + k + 1) as f64 * self.of.period;
                check_overflow((&plant, self.of.period), (twin.as_ref(), is_held), time)?;
            }
        }
        Ok(left)
    }
}

/// Returns the unit of each entry of the first state.
pub(super) fn state_units(plant: &Plant) -> Vec<f64> {
    let [position, tilt, rate, tilt_rate] = STATE;
    let of =
        |along: f64, about: f64| (0..plant.layout.order).map(move |i| if i == 3 || i == 4 { about } else { along });
    of(position, tilt).chain(of(rate, tilt_rate)).collect()
}
