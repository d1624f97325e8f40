//! The leapfrog of Verlet and Stormer: symplectic, one evaluation of every bearing a step.

use super::solve::Factored;
use super::vector::{add, add_scaled, along};
use super::{Coupling, Drive, Integrator, Machine, RotorState, System, accept};
use crate::scalar::Scalar;
use crate::status::Status;

/// Fixed step `h`, order 2, stable up to `h = 2 / w_max`: half a step along the rate, the whole push, half a step along
/// the new rate.
///
/// Without damping the map is symplectic: energy swings within a bound that falls as `h^2` and does not drift. Damping
/// and gyroscopic moments, which depend on the rate, enter as the mean of the rates before and after, solved for exactly,
/// so that the gyroscopic moment does no work and neither limits the step. Cost: one evaluation of every bearing and one
/// solution of `D` equations.
///
/// Source: Hairer, Lubich, Wanner, Geometric Numerical Integration (2006), I.1 and VI.3; the treatment of the rates is
/// that of Boris (1970) for charged particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verlet<T> {
    /// Step, s.
    pub step: T,
}

impl<T: Scalar> Integrator<T> for Verlet<T> {
    // Part of its caller, who may be compiled for a processor with wider registers than the rest of the program.
    #[inline(always)]
    fn step<R: System<T, D>, C: Coupling<T, D>, const D: usize, const N: usize>(
        &self,
        machine: &Machine<R, C, N>,
        state: &mut RotorState<T, D, N>,
        drive: &Drive<T>,
    ) -> Status {
        let h = self.step;
        let half = T::HALF * h;
        let start = machine.parts_after(&state.parts, drive.angle.since(state.shaft));
        let middle = drive.after(half);
        let at = machine.rotations(&machine.parts_after(&start, drive.arc_after(half)), &middle);
        let q = along(&state.q, half, &state.rate);
        // (M + h/2 (B + w G)) a = f - (B + w G) v: the mean of the rates is v + h/2 a. All that does not wait for the
        // bearings comes before them: a desktop processor does both at once.
        let effective = Factored::new(machine.rotor.effective([T::ONE, half, T::ZERO], middle.speed));
        let mut push = machine.rotor.excitation(&middle);
        add(&mut push, &machine.rotor.internal(&q, &state.rate, middle.speed));
        let bearings = machine.push(&q, &at);
        add(&mut push, &bearings.force);
        let acceleration = effective.solve(push);
        let rate = along(&state.rate, h, &acceleration);
        let mut end = q;
        add_scaled(&mut end, half, &rate);
        let next = RotorState { q: end, rate, acceleration, parts: start, shaft: drive.angle, held: state.held };
        accept(state, &next, drive.is_finite(), (bearings.load, bearings.status))
    }
}
