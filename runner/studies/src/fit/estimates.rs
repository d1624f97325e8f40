//! Estimates with their intervals, and the parameters that a recording does not identify.

use super::Estimate;
use super::intervals::unbalance;
use super::model::Model;
use super::parameters::{Parameter, ParameterKind};
use super::search::Solution;
use ballrace_base::statistics::quantile;
use ballrace_scene::{KeyphasorSignal, RotationSource};
use nalgebra::DMatrix;

/// Largest posterior uncertainty of an identifiable parameter, over the prior one.
pub(super) const IDENTIFIABLE: f64 = 0.3;

/// Estimates from a solution.
pub(super) struct Estimates {
    /// Values with their intervals.
    pub(super) parameters: Vec<Estimate>,
    /// Parameters that are not identifiable.
    pub(super) notes: Vec<String>,
    /// Values to write, SI.
    pub(super) values: Vec<(Parameter, f64)>,
    /// One plane of unbalance is enough.
    pub(super) one_plane: bool,
}

impl Model<'_> {
    /// Returns values with their intervals, and the parameters that are not identifiable.
    pub(super) fn estimates(&self, solution: &Solution, covariance: &DMatrix<f64>) -> Estimates {
        let scene = self.of.scene;
        let n = self.unknown.len();
        // Simultaneous 95 % intervals (Bonferroni).
        let z = quantile(0.025 / n as f64);
        let values = self.values(&solution.x);
        let (mut all, mut notes) = (Vec::new(), Vec::new());
        let index = |wanted: ParameterKind| self.unknown.iter().position(|p| p.kind == wanted);
        let mut one_plane = false;
        if let (Some(e), Some(c)) = (index(ParameterKind::Unbalance(0)), index(ParameterKind::Couple(0))) {
            let angle_step = self.angle_step();
            let (more, single) =
                unbalance(&values, covariance, self.unknown, [e, c], z, angle_step, scene.drawn_station(0.0));
            // A flexible rotor bends differently under the same sum and couple in another plane.
            one_plane = single && scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_none());
            all.extend(more);
        }
        for (i, parameter) in self.unknown.iter().enumerate() {
            if matches!(parameter.kind, ParameterKind::Unbalance(_) | ParameterKind::Couple(_)) {
                continue;
            }
            let (name, unit, size) = parameter.kind.name(scene);
            let mut reach = z * covariance[(i, i)].max(0.0).sqrt();
            if let ParameterKind::CageAngle(b) = parameter.kind {
                // The cage turns with the shaft, whose angle is known to the resolution of the keyphasor: an error that is the
                // same in all readings.
                let ratio = scene.bearings.get(b).and_then(|b| b.cage_ratio).unwrap_or(0.0);
                reach += ratio * self.angle_step() / parameter.scale;
            }
            let identified = self.identified(covariance, i);
            if !identified {
                notes.push(format!(
                    "{name} is not identifiable from this recording: {:.0} % of the prior uncertainty remains{}. The scene's value is kept.",
                    100.0 * reach / z,
                    self.partner(covariance, i).map_or_else(String::new, |other| format!("; it is correlated with {other}"))
                ));
            }
            all.push(Estimate {
                name,
                unit,
                given: parameter.given / size,
                value: values[i] / size,
                low: Some(parameter.value(solution.x[i] - reach) / size),
                high: Some(parameter.value(solution.x[i] + reach) / size),
                identified,
            });
        }
        let kept = |i: usize| {
            let parameter = &self.unknown[i];
            let identified = self.identified(covariance, i);
            (parameter.clone(), if identified { values[i] } else { parameter.start })
        };
        Estimates { parameters: all, notes, values: (0..n).map(kept).collect(), one_plane }
    }

    /// Returns true if the posterior uncertainty is below [`IDENTIFIABLE`] of the prior one. Unbalance is always identified, and so
    /// are cages, which are free only if they are observable.
    pub(super) fn identified(&self, covariance: &DMatrix<f64>, i: usize) -> bool {
        use ParameterKind::{CageAngle, CageRatio, Couple, Unbalance};
        let always = matches!(self.unknown[i].kind, Unbalance(_) | Couple(_) | CageAngle(_) | CageRatio(_));
        always || covariance[(i, i)].max(0.0).sqrt() < IDENTIFIABLE
    }

    /// Returns the other unknown with the largest correlation with unknown `i`, where it is above 0.7.
    fn partner(&self, covariance: &DMatrix<f64>, i: usize) -> Option<String> {
        let correlation = |j: usize| (covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()).abs();
        let others = (0..self.unknown.len()).filter(|&j| j != i);
        let best = others.max_by(|&a, &b| correlation(a).total_cmp(&correlation(b)))?;
        (correlation(best) > 0.7).then(|| self.unknown[best].kind.name(self.of.scene).0)
    }

    /// Returns half the angular resolution of a keyphasor sampled as 0 and 1, rad.
    fn angle_step(&self) -> f64 {
        let keyphasor = self.of.scene.recording.as_ref().map(|r| &r.rotation);
        let speed = self.of.samples.first().map_or(0.0, |s| s.speed.abs());
        match keyphasor {
            Some(RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. }) => 0.0,
            Some(RotationSource::Keyphasor { .. }) => 0.5 * speed * self.of.period,
            _ => 0.0,
        }
    }
}
