//! The Runge-Kutta-Nystrom method of order 4.

use super::vector::{add, add_scaled, along};
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept};
use crate::scalar::Scalar;
use crate::status::Status;

/// Runge-Kutta-Nystrom integrator of order 4 with a fixed step `h`; stable up to `h = 2.58 / w_max`, accurate well below. Cost: three
/// evaluations of each bearing.
///
/// With `a(t, q, v)` the acceleration:
///
/// ```text
/// a1 = a(t,       q,                          v)
/// a2 = a(t + h/2, q + h/2 v + h^2/8 a1,       v + h/2 a1)
/// a3 = a(t + h/2, q + h/2 v + h^2/8 a1,       v + h/2 a2)
/// a4 = a(t + h,   q + h v + h^2/2 a3,         v + h a3)
/// q(t + h) = q + h v + h^2/6 (a1 + a2 + a3)
/// v(t + h) = v + h/6 (a1 + 2 a2 + 2 a3 + a4)
/// ```
///
/// The two stages in the middle are at the same coordinates and so have the same bearing forces, which depend on the coordinates and not on
/// their rates. For an undamped frequency `w` the relative frequency error is `(w h)^4 / 320` and the numerical damping ratio
/// `(w h)^5 / 576`; with the classical method of four evaluations, they are `(w h)^4 / 120` and `(w h)^5 / 144`.
///
/// Source: Nystrom 1925, Acta Societatis Scientiarum Fennicae 50; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I
/// (1993), II.14.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RungeKuttaNystrom<T> {
    /// Time step, s.
    pub step: T,
}

impl<T: Scalar> Integrator<T> for RungeKuttaNystrom<T> {
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
        let start = (state.q, state.velocity);
        let (mut q, mut velocity) = start;
        let mut next =
            RotorState { q: along(&start.0, h, &start.1), component_angles: parts, shaft_angle: shaft.angle, ..*state };
        let mut at_start = (T::ZERO, Status::OK);
        // Time of the evaluations, weights of their accelerations in the coordinates (over h) and in the rates, and time of the next.
        let evaluations = [(T::ZERO, sixth, sixth, half), (half, sixth, third, h), (h, T::ZERO, sixth, T::ZERO)];
        for (i, (time, in_coordinates, in_rates, to_next)) in evaluations.into_iter().enumerate() {
            let now = shaft.after(time);
            let states = system.kinematic_states(&system.advance_components(&parts, shaft.delta_after(time)), &now);
            let bearings = system.bearing_forces(&q, &states);
            if i == 0 {
                at_start = (bearings.load, bearings.status);
            }
            let mut external = system.rotor.excitation(&now);
            add(&mut external, &bearings.force);
            let stages = if i == 1 { 2 } else { 1 };
            for stage in 0..stages {
                let mut force = external;
                add(&mut force, &system.rotor.internal_force(&q, &velocity, now.speed));
                next.acceleration = system.rotor.acceleration(&force);
                add_scaled(&mut next.q, h * in_coordinates, &next.acceleration);
                add_scaled(&mut next.velocity, in_rates, &next.acceleration);
                let to_next = if stage + 1 < stages { half } else { to_next };
                velocity = along(&start.1, to_next, &next.acceleration);
            }
            q = along(&start.0, to_next, &start.1);
            add_scaled(&mut q, T::HALF * to_next * to_next, &next.acceleration);
        }
        accept(state, &next, shaft.is_finite(), at_start)
    }
}
