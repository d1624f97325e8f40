//! Clearance of a bearing other than the scene's.

use super::super::Result;
use super::super::estimates::{Estimates, STIFFNESS_ERROR, described};
use super::super::fit::Fitted;
use super::super::machine::{Machine, clearance};
use super::super::parameter::{Access, Parameter};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultKind, FaultParameters};
use ballrace_plant::Plant;
use ballrace_scene::FreeAngle;

/// Diametral clearance of a bearing.
pub static CLEARANCE: Parameter = Parameter {
    step: 1e-10,
    longest_step: |_, _| 5e-6,
    changes_stiffness: true,
    access: Access::Bearing {
        get: |bearing, _| clearance(&bearing.scene),
        set: |bearing, _, x| {
            let scene = &mut bearing.scene;
            if let Some(play) = scene.law.as_mut().and_then(|law| law.radial_play.as_mut()) {
                *play = 0.5 * x.max(0.0);
            } else if let Some(g) = &mut scene.geometry {
                g.fit = FreeAngle::DiametralClearance(x.max(0.0));
            }
        },
    },
};

/// Clearances that are tried, over the present one.
const CLEARANCES: [f64; 8] = [0.3, 0.6, 0.85, 1.15, 1.4, 1.8, 2.3, 3.0];
/// Number of golden-section steps about the best of them.
const CLOSER: usize = 5;
/// Share of the largest gain by which an equal one may be smaller.
const EQUAL_GAIN: f64 = 0.02;
/// Least change of the clearance, m, and the same over the clearance.
const TOLERANCE: (f64, f64) = (3e-7, 0.03);
/// Growth of an inner ring over its diameter that is 5 K warmer than the outer ring, between recordings of a site.
const GROWTH: f64 = 5.0 * 12e-6;
/// Least change over the clearance between such recordings.
const SHARE_OF_SITE: f64 = 0.25;
/// Standard deviations of the baseline's clearance that it exceeds: one value is compared with one, without alternatives.
const KNOWN: f64 = 3.0;

/// Clearance of a bearing other than the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    bearing: usize,
}

impl Fault for Clearance {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        let bearings = machine.bearings.iter().enumerate().filter(|(_, bearing)| clearance(&bearing.scene) > 0.0);
        bearings.map(|(bearing, _)| Self { bearing }).collect()
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        let unknown = CLEARANCE.of_bearing(self.bearing);
        let given = unknown.get(&search.now.machine);
        let of = |factor: f64| {
            let mut machine = search.now.machine.clone();
            unknown.set(&mut machine, factor * given);
            search.best_of(self.bearing, std::iter::once(machine))
        };
        let (gain, start) = largest_gain(of)?;
        Ok(Some(search.found(AnyFault::Clearance(*self), gain, vec![start], &[unknown])))
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        let unknown = CLEARANCE.of_bearing(self.bearing);
        unknown.set(machine, unknown.get(before));
    }

    fn exceeds_tolerance(&self, e: &Evidence, before: &Fitted, after: &Fitted) -> bool {
        let unknown = CLEARANCE.of_bearing(self.bearing);
        let [old, new] = [before, after].map(|of| unknown.get(&of.machine));
        let (least, share) = TOLERANCE;
        let change = (new - old).abs();
        let diameters = after.machine.bearings[self.bearing].scene.diameters();
        let growth = diameters.map_or(0.0, |[element, pitch]| GROWTH * (pitch - element));
        let of_site = e.site.as_ref().map_or(0.0, |_| growth.max(SHARE_OF_SITE * old));
        let significant = e.significant();
        change > least.max(share * old).max(of_site)
            && change
                > (significant * after.deviation(unknown)).hypot(significant.min(KNOWN) * e.known_deviation(unknown))
    }

    fn bearing(&self) -> Option<usize> {
        Some(self.bearing)
    }

    fn changes_stiffness(&self, _: &Evidence) -> bool {
        true
    }

    fn is_nonlinear(&self) -> bool {
        true
    }

    fn moves_shaft(&self) -> bool {
        true
    }

    fn gives_way(&self) -> bool {
        true
    }

    fn kind(&self) -> FaultKind {
        FaultKind::Clearance
    }

    fn name(&self, plant: &Plant) -> String {
        format!("clearance of {}", plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let clearance = of.estimate(CLEARANCE.of_bearing(self.bearing), 1e-6, STIFFNESS_ERROR);
        FaultParameters { clearance_um: Some(clearance), ..FaultParameters::default() }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        let given = clearance(&of.e.scene.bearings[self.bearing]) * 1e6;
        let name = &of.e.plant.bearings[self.bearing].name;
        format!("Clearance of {name}: {} um instead of {given:.1} um", described(p.clearance_um, 2))
    }
}

/// Returns the best of the clearances that are tried, as factors of the present one, and of some about it.
///
/// A clearance so large that no ball touches its race leaves the same residual as any larger one, and a fit has no slope there: of equal
/// clearances, the smallest is the start.
fn largest_gain<T: Clone>(of: impl Fn(f64) -> Result<(f64, T)>) -> Result<(f64, T)> {
    let mut tried = CLEARANCES.into_iter().map(&of).collect::<Result<Vec<_>>>()?;
    let high = tried.iter().fold(f64::NEG_INFINITY, |high, (gain, _)| high.max(*gain));
    let equal = high - EQUAL_GAIN * high.abs();
    let at = tried.iter().position(|(gain, _)| *gain >= equal).unwrap_or(0);
    let mut best = tried.swap_remove(at);
    let [mut from, mut to] = [at.saturating_sub(1), (at + 1).min(CLEARANCES.len() - 1)].map(|i| CLEARANCES[i]);
    let inner = |from: f64, to: f64| [0.382, 0.618].map(|share| from + share * (to - from));
    let [mut lower, mut upper] = inner(from, to).map(|factor| of(factor).map(|tried| (factor, tried)));
    for _ in 0..CLOSER {
        let ((below, (first, machine)), (above, (second, other))) = (lower?, upper?);
        for (gain, machine) in [(first, &machine), (second, &other)] {
            if gain > best.0 {
                best = (gain, machine.clone());
            }
        }
        if first >= second {
            to = above;
            let next = inner(from, to)[0];
            (lower, upper) = (of(next).map(|tried| (next, tried)), Ok((below, (first, machine))));
        } else {
            from = below;
            let next = inner(from, to)[1];
            (lower, upper) = (Ok((above, (second, other))), of(next).map(|tried| (next, tried)));
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gain with a peak at 1.55 and with all balls lifted from 2 on.
    #[test]
    fn the_smallest_of_equal_clearances_is_the_start() {
        let of = |gain: &dyn Fn(f64) -> f64| {
            largest_gain(|factor| Ok((gain(factor), factor))).map_or(f64::NAN, |best| best.1)
        };
        let peak = of(&|factor| 100.0 - 100.0 * (factor - 1.55_f64).powi(2));
        assert!((peak - 1.55).abs() < 0.05, "{peak}");
        let lifted = of(&|factor| factor.min(2.0));
        assert!((2.0..=2.3).contains(&lifted), "{lifted}");
        // Gains may all be negative.
        let negative = of(&|factor| -1.0 - factor);
        assert!((0.3..0.35).contains(&negative), "{negative}");
    }
}
