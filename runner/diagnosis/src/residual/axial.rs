//! The axial coordinate where no probe measures it.

use super::super::Result;
use super::super::machine::{Evaluated, Machine};
use super::super::motion::Motion;
use super::Evidence;
use ballrace::Displacement;
use std::sync::Arc;

/// Share of the record over which a critical damping lets the start decay.
const LEAD_IN: f64 = 0.04;
/// Largest number of Newton steps in a sample, and the change at which they end, m.
const STEPS: usize = 6;
const CLOSE: f64 = 1e-12;
/// Passes over the record where the machine has spalls.
const PASSES: usize = 2;

impl Evidence<'_> {
    /// Finds the axial coordinate where no probe measures it; it stays as it is where no bearing has an axial stiffness.
    ///
    /// The bearings, at the measured radial motion, and load move the rotor axially: `m w'' + c w' = sum Fz(t, w) + load`, integrated
    /// by the rule of the mean acceleration. What the radial motion of another machine changes is left to the weights, in which
    /// the axial coordinate is free.
    pub(super) fn follow_axially(&mut self, machine: &Machine) -> Result<()> {
        let stiffness = self.mean_stiffness(machine)?.tangents.iter().map(|tangent| tangent[(2, 2)]).sum::<f64>();
        let mass = self.scene.rotor.as_ref().map_or(0.0, |rotor| rotor.mass);
        self.is_axially_free = stiffness > 0.0 && mass > 0.0;
        if !self.is_axially_free {
            return Ok(());
        }
        let has_spalls = machine.bearings.iter().any(|bearing| !bearing.scene.defect.is_empty());
        // The pulses of the spalls are those of the axial motion of the pass before.
        for _ in 0..if has_spalls { PASSES } else { 1 } {
            if !self.move_axially(machine, [mass, stiffness])? {
                self.is_axially_free = false;
                break;
            }
        }
        Ok(())
    }

    /// Returns false, with the axial coordinate as it was, where the axial motion leaves the bearings: at the measured radial motion
    /// they do not carry the load.
    fn move_axially(&mut self, machine: &Machine, [mass, stiffness]: [f64; 2]) -> Result<bool> {
        let diameters = machine.bearings.iter().filter_map(|b| b.scene.diameters().map(|[element, _]| element));
        let farthest = diameters.reduce(f64::max).unwrap_or(f64::MAX);
        let bearings = (0..machine.bearings.len()).map(|b| self.evaluated(machine, b)).collect::<Result<Vec<_>>>()?;
        let constant = machine.load[2] + self.gravity[2];
        let motion = &*self.motion;
        let pulses = axial_pulses(&bearings, motion);
        let lead = (LEAD_IN * motion.len() as f64) as usize;
        let critical = 2.0 * (stiffness * mass).sqrt();
        let mut state = State { w: motion.q[0].w, v: 0.0, a: 0.0 };
        let mut q = motion.q.clone();
        for (t, q) in q.iter_mut().enumerate() {
            let pulse = pulses.get(t).copied().unwrap_or_default();
            let force = |w: f64| constant + pulse + axial_force(&bearings, motion, t, w - q.w);
            let damping = if t < lead { critical.max(machine.damping[2]) } else { machine.damping[2] };
            state = state.next(motion.period, mass, damping, stiffness, force);
            if !state.w.is_finite() || state.w.abs() > farthest {
                return Ok(false);
            }
            q.w = state.w;
        }
        let mut moved = motion.clone();
        moved.q = q;
        self.motion = Arc::new(moved);
        self.set_axial_motion();
        self.displace(machine)?;
        Ok(true)
    }
}

/// Returns the axial force of the spalls of all bearings at every sample; empty without spalls.
fn axial_pulses(bearings: &[Evaluated], motion: &Motion) -> Vec<f64> {
    let mut sums = vec![];
    for pulses in bearings.iter().filter_map(|bearing| bearing.pulses(motion)) {
        sums.resize(motion.len(), 0.0);
        sums.iter_mut().zip(pulses).for_each(|(sum, pulse)| *sum += pulse[2]);
    }
    sums
}

/// Returns the axial force of the bearings without their spalls at sample `t` with an axial displacement of the rotor.
fn axial_force(bearings: &[Evaluated], motion: &Motion, t: usize, w: f64) -> f64 {
    let moved = Displacement { w, ..Displacement::from_array([0.0; 5]) };
    bearings.iter().map(|bearing| bearing.force_with(motion, t, &moved)[2]).sum()
}

/// Axial position, velocity and acceleration.
#[derive(Clone, Copy)]
struct State {
    w: f64,
    v: f64,
    a: f64,
}

impl State {
    /// Returns the state a sample period `h` later: Newmark's method with the mean acceleration, and a secant for the stiffness.
    fn next(self, h: f64, mass: f64, damping: f64, stiffness: f64, force: impl Fn(f64) -> f64) -> Self {
        let (w, v) = (self.w + h * self.v + 0.25 * h * h * self.a, self.v + 0.5 * h * self.a);
        let at = |a: f64| Self { w: w + 0.25 * h * h * a, v: v + 0.5 * h * a, a };
        let missing = |state: &Self| mass * state.a + damping * state.v - force(state.w);
        let mut slope = mass + 0.5 * h * damping + 0.25 * h * h * stiffness;
        let mut now = at(self.a);
        let mut left = missing(&now);
        for _ in 0..STEPS {
            let change = -left / slope;
            let next = at(now.a + change);
            let after = missing(&next);
            if (after - left) * change > 0.0 {
                slope = (after - left) / change;
            }
            (now, left) = (next, after);
            if (0.25 * h * h * change).abs() < CLOSE {
                break;
            }
        }
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass on a spring keeps its energy, and its period is that of the exact motion but for (w h)^2 / 12.
    #[test]
    fn a_mass_on_a_spring() {
        let (mass, stiffness, h) = (4.0, 1e7, 2e-5);
        let mut state = State { w: 1e-6, v: 0.0, a: -1e-6 * stiffness / mass };
        let rate = (stiffness / mass).sqrt();
        let steps = (40.0 * std::f64::consts::PI / (rate * h)).round() as usize;
        for _ in 0..steps {
            state = state.next(h, mass, 0.0, stiffness, |w| -stiffness * w);
        }
        let energy = stiffness * state.w * state.w + mass * state.v * state.v;
        assert!((energy / (stiffness * 1e-12) - 1.0).abs() < 1e-6, "{energy}");
        let exact = 1e-6 * (rate * h * steps as f64 * (1.0 - (rate * h).powi(2) / 12.0)).cos();
        assert!((state.w - exact).abs() < 2e-9, "{} {exact}", state.w);
    }
}
