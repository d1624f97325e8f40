//! The classical Runge-Kutta method of order 4.

use super::vector::along;
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept, vector};
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use crate::status::Status;

/// Runge-Kutta integrator of order 4 with a fixed step `h`; stable up to `h = 2.8 / w_max`, accurate well below. Cost: four
/// evaluations of each bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RungeKutta4<T> {
    /// Time step, s.
    pub step: T,
}

impl<T: Scalar> Integrator<T> for RungeKutta4<T> {
    // Always inlined: the caller may be compiled for wider SIMD registers than the rest of the program.
    #[inline(always)]
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let h = self.step;
        let (half, sixth, third) = (T::HALF * h, h * T::from_f64(1.0 / 6.0), h * T::from_f64(1.0 / 3.0));
        let parts = system.advance_components(&state.component_angles, shaft.angle.since(state.shaft_angle));
        // Coordinates and velocities of a stage, and x + h/6 (k1 + 2 k2 + 2 k3 + k4) so far.
        let (mut q, mut velocity) = (state.q, state.velocity);
        let mut next = RotorState { component_angles: parts, shaft_angle: shaft.angle, ..*state };
        let mut at_start = (T::ZERO, Status::OK);
        let stages = [(T::ZERO, sixth, half), (half, third, half), (half, third, h), (h, sixth, T::ZERO)];
        let (mut now, mut at, mut excitation) = (*shaft, [BearingKinematicState::default(); N], [T::ZERO; D]);
        for (i, (time, weight, to_next)) in stages.into_iter().enumerate() {
            // The two stages in the middle of the step share the shaft motion and what depends on it alone.
            if i != 2 {
                now = shaft.after(time);
                at = system.kinematic_states(&system.advance_components(&parts, shaft.delta_after(time)), &now);
                excitation = system.rotor.excitation(&now);
            }
            let bearings = system.bearing_forces(&q, &at);
            let mut force = excitation;
            vector::add(&mut force, &bearings.force);
            vector::add(&mut force, &system.rotor.internal_force(&q, &velocity, now.speed));
            next.acceleration = system.rotor.acceleration(&force);
            if i == 0 {
                at_start = (bearings.load, bearings.status);
            }
            vector::add_scaled(&mut next.q, weight, &velocity);
            vector::add_scaled(&mut next.velocity, weight, &next.acceleration);
            q = along(&state.q, to_next, &velocity);
            velocity = along(&state.velocity, to_next, &next.acceleration);
        }
        accept(state, &next, shaft.is_finite(), at_start)
    }
}
