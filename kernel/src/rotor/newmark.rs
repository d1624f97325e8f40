//! Newmark method with beta = 1/4, gamma = 1/2 (trapezoidal rule: no numerical damping, unconditionally stable for a linear
//! system) and a fixed number of Newton steps with the analytic tangent of the bearings.

use super::vector::{add, add_scaled, all_finite};
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept, solve};
use crate::scalar::Scalar;
use crate::status::Status;
use nalgebra::SMatrix;

/// Newmark integrator with a fixed step. Cost: one tangent of each bearing and one solution of `D` equations per Newton
/// step.
///
/// Source: Newmark (1959); with Newton's method on rotors: Harsha et al. (2004).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newmark<T> {
    /// Time step, s.
    pub step: T,
    /// Newton steps per time step; 3 reach the rounding of `f64` for smooth contact at usual time steps.
    pub newton_steps: u8,
}

impl<T: Scalar> Newmark<T> {
    /// Sets the acceleration of `state` by the equation of motion, with the shaft motion at the start of the next step.
    ///
    /// A state whose coordinates or velocities were set from outside has no valid acceleration; without it, the first step is of order 1.
    /// A result that is not finite leaves the state unchanged.
    pub fn start<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) {
        let parts = system.advance_components(&state.component_angles, shaft.angle.since(state.shaft_angle));
        let bearings = system.bearing_forces(&state.q, &system.kinematic_states(&parts, shaft));
        let mut force = system.rotor.excitation(shaft);
        add(&mut force, &bearings.force);
        add(&mut force, &system.rotor.internal_force(&state.q, &state.velocity, shaft.speed));
        let acceleration = system.rotor.acceleration(&force);
        if all_finite(&acceleration) {
            state.acceleration = acceleration;
        }
    }
}

impl<T: Scalar> Integrator<T> for Newmark<T> {
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let h = self.step;
        let two_over_h = T::from_f64(2.0) / h;
        let (per_rate, per_acceleration) = (two_over_h, two_over_h * two_over_h);
        let start = system.advance_components(&state.component_angles, shaft.angle.since(state.shaft_angle));
        let end = shaft.after(h);
        let at = system.kinematic_states(&system.advance_components(&start, shaft.delta_after(h)), &end);
        let excitation = system.rotor.excitation(&end);
        let effective = system.rotor.effective_matrix([per_acceleration, per_rate, T::ONE], end.speed);

        let mut a = state.acceleration;
        let mut v = state.velocity;
        let mut q = state.q;
        for ((q, v), a) in q.iter_mut().zip(&mut v).zip(&a) {
            *q += h * (*v + T::HALF * h * *a);
            *v += h * *a;
        }
        let mut answer = (T::ONE, Status::OK);
        for _ in 0..self.newton_steps {
            let mut tangent = SMatrix::from_element(T::ZERO);
            let bearings = system.bearing_forces_adding_stiffness(&q, &at, &mut tangent);
            answer = (bearings.load, bearings.status);
            let mut residual = excitation;
            add(&mut residual, &bearings.force);
            add(&mut residual, &system.rotor.internal_force(&q, &v, end.speed));
            add_scaled(&mut residual, -T::ONE, &system.rotor.inertia_force(&a));
            tangent += &effective;
            let correction = solve(tangent, residual);
            add(&mut q, &correction);
            add_scaled(&mut v, per_rate, &correction);
            add_scaled(&mut a, per_acceleration, &correction);
        }
        let next = RotorState {
            q,
            velocity: v,
            acceleration: a,
            component_angles: start,
            shaft_angle: shaft.angle,
            held_steps: state.held_steps,
        };
        accept(state, &next, shaft.is_finite(), answer)
    }
}
