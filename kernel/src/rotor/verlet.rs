//! The leapfrog of Verlet and Stormer: symplectic, one evaluation of every bearing a step.

use super::solve::{Factored, Inverse};
use super::vector::{add, add_scaled, along};
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept};
use crate::scalar::Scalar;
use crate::status::Status;
use core::borrow::BorrowMut;
use nalgebra::SMatrix;

/// Fixed step `h`, order 2, stable up to `h = 2 / w_max`: half a step along the rate, the whole force, half a step along
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

impl<T: Scalar> Verlet<T> {
    /// Where the shaft is in the middle of a step, with the speed that holds for all of it.
    #[inline(always)]
    fn middle(self, shaft: &ShaftMotion<T>) -> ShaftMotion<T> {
        shaft.after(T::HALF * self.step)
    }

    /// `M + h/2 (B + w G)`.
    #[inline(always)]
    fn effective_matrix<R: SecondOrderSystem<T, D>, A, const D: usize>(self, rotor: &R, speed: T) -> Factored<A>
    where
        A: BorrowMut<SMatrix<T, D, D>> + From<SMatrix<T, D, D>>,
    {
        Factored::new(A::from(rotor.effective_matrix([T::ONE, T::HALF * self.step, T::ZERO], speed)))
    }

    /// A step with the equations `M + h/2 (B + w G)` solved as given.
    #[inline(always)]
    fn step_with<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        self,
        solve: impl FnOnce([T; D]) -> [T; D],
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let h = self.step;
        let half = T::HALF * h;
        let start = system.advance_components(&state.component_angles, shaft.angle.since(state.shaft_angle));
        let middle = self.middle(shaft);
        let at = system.kinematic_states(&system.advance_components(&start, shaft.delta_after(half)), &middle);
        let q = along(&state.q, half, &state.velocity);
        // (M + h/2 (B + w G)) a = f - (B + w G) v: the mean of the rates is v + h/2 a. All that does not wait for the
        // bearings comes before them: a desktop processor does both at once.
        let mut force = system.rotor.excitation(&middle);
        add(&mut force, &system.rotor.internal_force(&q, &state.velocity, middle.speed));
        let bearings = system.bearing_forces(&q, &at);
        add(&mut force, &bearings.force);
        let acceleration = solve(force);
        let velocity = along(&state.velocity, h, &acceleration);
        let mut end = q;
        add_scaled(&mut end, half, &velocity);
        let next = RotorState {
            q: end,
            velocity,
            acceleration,
            component_angles: start,
            shaft_angle: shaft.angle,
            held_steps: state.held_steps,
        };
        accept(state, &next, shaft.is_finite(), (bearings.load, bearings.status))
    }
}

impl<T: Scalar> Integrator<T> for Verlet<T> {
    // Part of its caller, who may be compiled for a processor with wider registers than the rest of the program.
    #[inline(always)]
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let effective: Factored<SMatrix<T, D, D>> = self.effective_matrix(&system.rotor, self.middle(shaft).speed);
        self.step_with(
            #[inline(always)]
            |force| effective.solve(force),
            system,
            state,
            shaft,
        )
    }
}

/// [`Verlet`] for a shaft whose speed mostly stays: the same steps, to rounding, with the equations of the last one kept for the
/// next as an inverse, whose product is not a chain of solutions one after the other.
///
/// A step at the speed of the one before costs `D^2` multiplications in place of `D^3/3`; the first of them makes the inverse;
/// a step at another speed is [`Verlet`]'s to the bit.
///
/// `A` stores one matrix: in place, or behind a pointer such as `Box` where `D` is large.
#[derive(Debug, Clone, Copy)]
pub struct SteadyVerlet<T: Scalar, const D: usize, A = SMatrix<T, D, D>> {
    verlet: Verlet<T>,
    /// The equations at `speed`, and their inverse where it is made.
    effective: Factored<A>,
    speed: T,
    inverse: Option<Inverse<A>>,
    /// The speed with nothing to make for: infinite where there is no inverse. One comparison, so that a bad shaft costs what a
    /// good one costs.
    inverse_speed: T,
}

impl<T: Scalar, const D: usize> SteadyVerlet<T, D> {
    /// For this rotor, inverse_speed to start at `speed`, rad/s (from rest where it is not finite).
    #[must_use]
    pub fn new<R: SecondOrderSystem<T, D>>(verlet: Verlet<T>, rotor: &R, speed: T) -> Self {
        Self::with_storage(verlet, rotor, speed)
    }
}

impl<T: Scalar, const D: usize, A> SteadyVerlet<T, D, A>
where
    A: BorrowMut<SMatrix<T, D, D>> + From<SMatrix<T, D, D>>,
{
    /// As [`SteadyVerlet::new`], each matrix stored in an `A` such as `Box<SMatrix<T, D, D>>`.
    #[must_use]
    pub fn with_storage<R: SecondOrderSystem<T, D>>(verlet: Verlet<T>, rotor: &R, speed: T) -> Self {
        let speed = if speed.is_finite() { speed } else { T::ZERO };
        let effective = verlet.effective_matrix(rotor, speed);
        let inverse = Some(Inverse::new(&effective));
        Self { verlet, effective, speed, inverse, inverse_speed: speed }
    }

    /// One step, as [`Integrator::step`] of machines with the rotor that it was made for.
    #[inline(always)]
    pub fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const N: usize>(
        &mut self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let speed = self.verlet.middle(shaft).speed;
        // A speed that is not finite is answered with the state held, whatever the equations: nothing to do for it.
        if (speed != self.inverse_speed) & speed.is_finite() {
            self.factor_for(&system.rotor, speed);
        }
        let (effective, inverse) = (&self.effective, &self.inverse);
        self.verlet.step_with(
            #[inline(always)]
            |force| match inverse {
                Some(inverse) => inverse.solve(force),
                None => effective.solve(force),
            },
            system,
            state,
            shaft,
        )
    }

    /// Equations for another speed; an inverse only for one that comes a second time: in a run-up it would be for nothing.
    #[cold]
    #[inline(never)]
    fn factor_for<R: SecondOrderSystem<T, D>>(&mut self, rotor: &R, speed: T) {
        if speed == self.speed {
            (self.inverse, self.inverse_speed) = (Some(Inverse::new(&self.effective)), speed);
        } else {
            (self.effective, self.speed) = (self.verlet.effective_matrix(rotor, speed), speed);
            (self.inverse, self.inverse_speed) = (None, T::ONE / T::ZERO);
        }
    }
}
