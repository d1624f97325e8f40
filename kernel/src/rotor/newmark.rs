//! Newmark-beta with beta = 1/4, gamma = 1/2 (the trapezium rule: no numerical damping, any step stable for a
//! linear system) and a fixed number of Newton steps with the bearings' analytic tangent.

use super::{Drive, Integrator, Machine, RotorState, solve};
use crate::bearing::{Bearing, Reaction};
use crate::frame::Displacement;
use crate::math::Math;
use crate::scalar::Scalar;
use crate::status::Status;

/// Fixed step and fixed number of Newton steps. Cost: that many bearing tangents and 5 x 5 solutions.
///
/// Source: Newmark (1959); used with Newton's method on rotors by Harsha et al. (2004).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newmark<T> {
    /// Step, s.
    pub step: T,
    /// Newton steps a time step; 3 reach the rounding of f64 on smooth contact at usual steps.
    pub newton_steps: u8,
}

impl<T: Scalar> Integrator<T> for Newmark<T> {
    fn step<M: Math<T>, B: Bearing<T>, const N: usize>(
        &self,
        machine: &Machine<T, M, B, N>,
        state: &mut RotorState<T, N>,
        drive: &Drive<T>,
    ) -> Status {
        let h = self.step;
        let two_over_h = T::from_f64(2.0) / h;
        let (per_rate, per_acceleration) = (two_over_h, two_over_h * two_over_h);
        let start = machine.parts_after(&state.parts, drive.angle.since(state.shaft));
        let end = drive.after(h);
        let at = machine.rotations(&machine.parts_after(&start, drive.arc_after(h)), &end);
        let excitation = machine.rotor.excitation(&end);
        let effective = machine.rotor.effective((per_acceleration, per_rate), end.speed);

        let mut a = state.acceleration.to_array();
        let mut v = state.rate.to_array();
        let mut q = state.q.to_array();
        for ((q, v), a) in q.iter_mut().zip(&mut v).zip(&a) {
            *q += h * (*v + T::HALF * h * *a);
            *v += h * *a;
        }
        let mut answer = Reaction { load: T::ONE, ..Reaction::default() };
        for _ in 0..self.newton_steps {
            let (pose, rate) = (Displacement::from_array(q), Displacement::from_array(v));
            let (bearings, tangent) = machine.bearing_reaction_and_stiffness(&pose, &at);
            answer = bearings;
            let inertia = machine.rotor.inertia(&Displacement::from_array(a)).to_array();
            let push = excitation.plus(bearings.wrench).plus(machine.rotor.internal(&pose, &rate, end.speed));
            let mut residual = push.to_array();
            for (r, ma) in residual.iter_mut().zip(inertia) {
                *r -= ma;
            }
            let correction = solve(effective + tangent, residual);
            for (((q, v), a), dq) in q.iter_mut().zip(&mut v).zip(&mut a).zip(correction) {
                *q += dq;
                *v += per_rate * dq;
                *a += per_acceleration * dq;
            }
        }
        let next = RotorState {
            q: Displacement::from_array(q),
            rate: Displacement::from_array(v),
            acceleration: Displacement::from_array(a),
            parts: start,
            shaft: drive.angle,
            held: state.held,
        };
        Machine::<T, M, B, N>::accept(state, next, drive.is_finite(), &answer)
    }
}
