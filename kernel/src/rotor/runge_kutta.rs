//! The classical Runge-Kutta method of order 4.

use super::vector::along;
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept, vector};
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
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let h = self.step;
        let half = T::HALF * h;
        let parts = system.advance_components(&state.component_angles, shaft.angle.since(state.shaft_angle));
        // Acceleration at the time `dt` into the step.
        let slope = |q: &[T; D], rate: &[T; D], dt: T| {
            let now = shaft.after(dt);
            let turned = system.advance_components(&parts, shaft.delta_after(dt));
            let bearings = system.bearing_forces(q, &system.kinematic_states(&turned, &now));
            let mut f = system.rotor.excitation(&now);
            vector::add(&mut f, &bearings.force);
            vector::add(&mut f, &system.rotor.internal_force(q, rate, now.speed));
            (system.rotor.acceleration(&f), (bearings.load, bearings.status))
        };
        let (q0, v0) = (state.q, state.velocity);
        let (a1, bearings) = slope(&q0, &v0, T::ZERO);
        let (q2, v2) = (along(&q0, half, &v0), along(&v0, half, &a1));
        let (a2, _) = slope(&q2, &v2, half);
        let (q3, v3) = (along(&q0, half, &v2), along(&v0, half, &a2));
        let (a3, _) = slope(&q3, &v3, half);
        let (q4, v4) = (along(&q0, h, &v3), along(&v0, h, &a3));
        let (a4, _) = slope(&q4, &v4, h);
        let next = RotorState {
            q: weighted(&q0, h, [&v0, &v2, &v3, &v4]),
            velocity: weighted(&v0, h, [&a1, &a2, &a3, &a4]),
            acceleration: a4,
            component_angles: parts,
            shaft_angle: shaft.angle,
            held_steps: state.held_steps,
        };
        accept(state, &next, shaft.is_finite(), bearings)
    }
}

/// Returns `x + h/6 (k1 + 2 k2 + 2 k3 + k4)`.
fn weighted<T: Scalar, const D: usize>(x: &[T; D], h: T, [k1, k2, k3, k4]: [&[T; D]; 4]) -> [T; D] {
    let sixth = h * T::from_f64(1.0 / 6.0);
    let third = h * T::from_f64(1.0 / 3.0);
    along(&along(&along(&along(x, sixth, k1), third, k2), third, k3), sixth, k4)
}
