//! Leapfrog integrator of Verlet and Stormer: symplectic, one evaluation of each bearing per step.

use super::solve::{Factored, Inverse};
use super::vector::{add, add_scaled, along};
use super::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion, accept};
use crate::scalar::Scalar;
use crate::status::Status;
use core::borrow::BorrowMut;
use nalgebra::SMatrix;

/// Leapfrog integrator of order 2 with a fixed step `h`, stable up to `h = 2 / w_max`: half a step along the velocity, the
/// whole force, half a step along the new velocity.
///
/// Without damping the map is symplectic: the energy oscillates within a bound proportional to `h^2` and does not drift.
/// Damping and gyroscopic moments use the mean of the velocities before and after, solved exactly; the gyroscopic moment
/// then does no work, and neither limits the step. Cost: one evaluation of each bearing and one solution of `D` equations.
///
/// Source: Hairer, Lubich, Wanner, Geometric Numerical Integration (2006), I.1 and VI.3; velocity-dependent forces after
/// Boris (1970).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verlet<T> {
    /// Time step, s.
    pub step: T,
}

impl<T: Scalar> Verlet<T> {
    /// Returns the shaft motion in the middle of a step; its speed applies to the whole step.
    #[inline(always)]
    fn middle(self, shaft: &ShaftMotion<T>) -> ShaftMotion<T> {
        shaft.after(T::HALF * self.step)
    }

    /// Factors `M + h/2 (B + w G)`.
    #[inline(always)]
    fn effective_matrix<R: SecondOrderSystem<T, D>, A, const D: usize>(self, rotor: &R, speed: T) -> Factored<A>
    where
        A: BorrowMut<SMatrix<T, D, D>> + From<SMatrix<T, D, D>>,
    {
        Factored::new(A::from(rotor.effective_matrix([T::ONE, T::HALF * self.step, T::ZERO], speed)))
    }

    /// Performs a step with the solution of `M + h/2 (B + w G)` by `solve`.
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
        // (M + h/2 (B + w G)) a = f - (B + w G) v: the mean of the velocities is v + h/2 a. Terms that do not depend on the
        // bearings come first: a desktop processor overlaps both.
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
    // Always inlined: the caller may be compiled for wider SIMD registers than the rest of the program.
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

/// [`Verlet`] for a mostly constant shaft speed: same steps to rounding, with the inverse of the equations reused.
///
/// A step at the speed of the last one costs `D^2` multiplications instead of `D^3/3`; the first such step computes the
/// inverse. A step at another speed equals that of [`Verlet`] bit for bit.
///
/// `A` stores one matrix: in place, or behind a pointer such as `Box` for a large `D`.
#[derive(Debug, Clone, Copy)]
pub struct SteadyVerlet<T: Scalar, const D: usize, A = SMatrix<T, D, D>> {
    verlet: Verlet<T>,
    /// The equations at `speed`, and their inverse where it is made.
    effective: Factored<A>,
    speed: T,
    inverse: Option<Inverse<A>>,
    /// Speed of the inverse; infinite without inverse. One comparison serves both cases, so that invalid input costs as
    /// much as valid input.
    inverse_speed: T,
}

impl<T: Scalar, const D: usize> SteadyVerlet<T, D> {
    /// Creates the integrator for this rotor, prepared for `speed`, rad/s (for 0 if it is not finite).
    #[must_use]
    pub fn new<R: SecondOrderSystem<T, D>>(verlet: Verlet<T>, rotor: &R, speed: T) -> Self {
        Self::with_storage(verlet, rotor, speed)
    }
}

impl<T: Scalar, const D: usize, A> SteadyVerlet<T, D, A>
where
    A: BorrowMut<SMatrix<T, D, D>> + From<SMatrix<T, D, D>>,
{
    /// Creates the integrator as [`SteadyVerlet::new`], with each matrix stored in an `A` such as `Box<SMatrix<T, D, D>>`.
    #[must_use]
    pub fn with_storage<R: SecondOrderSystem<T, D>>(verlet: Verlet<T>, rotor: &R, speed: T) -> Self {
        let speed = if speed.is_finite() { speed } else { T::ZERO };
        let effective = verlet.effective_matrix(rotor, speed);
        let inverse = Some(Inverse::new(&effective));
        Self { verlet, effective, speed, inverse, inverse_speed: speed }
    }

    /// Performs a step as [`Integrator::step`], for systems with the rotor of the constructor.
    #[inline(always)]
    pub fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const N: usize>(
        &mut self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status {
        let speed = self.verlet.middle(shaft).speed;
        // A speed that is not finite holds the state, whatever the equations.
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

    /// Factors the equations for another speed. Inverts them only when a speed occurs a second time: an inverse is useless
    /// during a run-up.
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
