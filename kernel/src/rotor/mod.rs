//! Rotors on bearings, and integrators.
//!
//! `M q'' + (B + w G) q' + K q = f_E(t) + f_B(q, t)` (Hajzman, eq. 6). A [`SecondOrderSystem`] is the linear part with its
//! excitation: [`RigidRotor`], five coordinates `q = [u v w thu thv]` of the centre of mass, at the lowest cost;
//! [`LinearSystem`], any coordinates from matrices, among them the rigid rotor on flexible supports ([`supported_rotor`])
//! and a reduced finite-element rotor. A [`ForceElement`] is a nonlinear force on the coordinates: a bearing on a rigid
//! rotor ([`BearingAtStation`]) or on any coordinates ([`AttachedBearing`]), and [`MovingBalls`], whose balls are
//! coordinates.

mod equilibrium;
mod force_element;
mod linear_system;
mod moving_balls;
mod newmark;
mod rigid;
mod runge_kutta_nystrom;
mod second_order;
mod shaft_motion;
mod solve;
mod speed_ratios;
mod supported;
mod vector;
mod verlet;

pub use equilibrium::{Equilibrium, equilibrium};
pub use force_element::{AttachedBearing, Attachment, BearingAtStation, ForceElement, HasSpeedRatios};
pub use linear_system::{InvalidMatrix, LinearSystem, SystemMatrices};
pub use moving_balls::{MovingBalls, MovingBallsParams};
pub use newmark::Newmark;
pub use rigid::{RigidRotor, RotorParams, Unbalance};
pub use runge_kutta_nystrom::RungeKuttaNystrom;
pub use second_order::SecondOrderSystem;
pub use shaft_motion::ShaftMotion;
pub use solve::solve;
pub use speed_ratios::{ComponentAngles, SpeedRatios};
pub use supported::{Support, supported_rotor};
pub use verlet::{SteadyVerlet, Verlet};

use crate::choice::Choice;
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::phase::{Phase, PhaseDelta};
use crate::scalar::Scalar;
use crate::status::Status;
use nalgebra::SMatrix;

/// A rotor with its `N` bearings: the parameters of the hot path.
///
/// ```
/// use ballrace::bearing::linear::Linear;
/// use ballrace::rotor::{ShaftMotion, SpeedRatios, Integrator, RotorBearingSystem, BearingAtStation, RigidRotor, RotorParams, RotorState, RungeKuttaNystrom};
/// use ballrace::{Displacement, Exact, Stiffness, Phase};
///
/// let params = RotorParams {
///     mass: 1.0,
///     diametral_inertia: 1e-3,
///     polar_inertia: 5e-4,
///     damping: [[0.0; 5]; 5],
///     stiffness: [0.0; 5],
///     gravity: [0.0; 3],
///     load: [0.0; 5],
/// };
/// let rotor = RigidRotor::<f64, Exact>::try_new(&params, &[])?;
/// let springs = Linear::new(Stiffness::from_diagonal_element(1e6));
/// let at = |station| BearingAtStation { bearing: springs, station, speed_ratios: SpeedRatios::new(0.4) };
/// let system = RotorBearingSystem { rotor, bearings: [at(-0.1), at(0.1)] };
///
/// // 1 kg on 2e6 N/m, released at 1 um, is at -1 um half a period later.
/// let start = Displacement { u: 1e-6, ..Displacement::default() };
/// let mut state = RotorState::stationary(start, Phase::ZERO, [Phase::ZERO; 2]);
/// let half_period = std::f64::consts::PI / 2e6_f64.sqrt();
/// let standing = ShaftMotion { angle: Phase::ZERO, speed: 0.0, acceleration: 0.0 };
/// for _ in 0..100 {
///     let status = RungeKuttaNystrom { step: half_period / 100.0 }.step(&system, &mut state, &standing);
///     assert!(!status.is_held());
/// }
/// assert!((state.displacement().u + 1e-6).abs() < 1e-13);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct RotorBearingSystem<R, C, const N: usize> {
    /// Rotor and its excitation: a [`SecondOrderSystem`].
    pub rotor: R,
    /// Bearings: each a [`ForceElement`].
    pub bearings: [C; N],
}

/// State of a rotor-bearing system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorState<T, const D: usize, const N: usize> {
    /// Coordinates: for a rigid rotor, the displacement of its centre of mass.
    pub q: [T; D],
    /// Velocities of the coordinates, per second.
    pub velocity: [T; D],
    /// Accelerations of the coordinates; [`Newmark`] uses them in the next step, [`Newmark::start`] computes the first ones.
    pub acceleration: [T; D],
    /// Angles of the bearing components at the shaft angle `shaft_angle`.
    pub component_angles: [ComponentAngles; N],
    /// Shaft angle of `component_angles`.
    pub shaft_angle: Phase,
    /// Number of steps without a valid result (saturating).
    pub held_steps: u32,
}

impl<T: Scalar, const D: usize, const N: usize> RotorState<T, D, N> {
    /// Creates a state without velocity at `q`, with these angles of the shaft and of the bearing components (or of the
    /// cages only).
    pub fn stationary(
        q: impl Into<[T; D]>,
        shaft_angle: Phase,
        component_angles: [impl Into<ComponentAngles>; N],
    ) -> Self {
        let zero = [T::ZERO; D];
        Self {
            q: q.into(),
            velocity: zero,
            acceleration: zero,
            component_angles: component_angles.map(Into::into),
            shaft_angle,
            held_steps: 0,
        }
    }

    fn is_finite(&self) -> bool {
        vector::all_finite(&self.q) & vector::all_finite(&self.velocity) & vector::all_finite(&self.acceleration)
    }
}

impl<T: Scalar, const N: usize> RotorState<T, 5, N> {
    /// Returns the displacement of the centre of mass of a rigid rotor.
    pub fn displacement(&self) -> Displacement<T> {
        Displacement::from_array(self.q)
    }
}

/// An integrator with a fixed time step.
pub trait Integrator<T: Scalar> {
    /// Advances the state by one step, with the shaft motion at its start.
    ///
    /// A shaft motion or result that is not finite leaves coordinates and velocities unchanged; the step is flagged and
    /// counted.
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        system: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        shaft: &ShaftMotion<T>,
    ) -> Status;
}

/// Force of all bearings on the coordinates of a system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneralizedForce<T, const D: usize> {
    /// Forces on the coordinates.
    pub force: [T; D],
    /// Sum of the element loads, N; 0 without contact.
    pub load: T,
    /// Status flags of the evaluation.
    pub status: Status,
}

// Loops with counters: the compiler unrolls these, but not iterators over two arrays.
impl<R, C, const N: usize> RotorBearingSystem<R, C, N> {
    /// Returns the kinematic state of each bearing at `shaft` with the component angles `parts`.
    #[inline(always)]
    pub fn kinematic_states<T: Scalar>(
        &self,
        parts: &[ComponentAngles; N],
        shaft: &ShaftMotion<T>,
    ) -> [BearingKinematicState<T>; N]
    where
        C: HasSpeedRatios<T>,
    {
        let mut states = [BearingKinematicState::default(); N];
        let mut i = 0;
        while i < N {
            states[i] = self.bearings[i].speed_ratios().kinematic_state(parts[i], shaft);
            i += 1;
        }
        states
    }

    /// Computes the force of all bearings on the coordinates.
    #[inline(always)]
    pub fn bearing_forces<T: Scalar, const D: usize>(
        &self,
        q: &[T; D],
        at: &[BearingKinematicState<T>; N],
    ) -> GeneralizedForce<T, D>
    where
        C: ForceElement<T, D>,
    {
        let mut sum = GeneralizedForce { force: [T::ZERO; D], load: T::ZERO, status: Status::OK };
        let mut i = 0;
        while i < N {
            let (load, status) = self.bearings[i].add_force(q, &at[i], &mut sum.force);
            sum.load += load;
            sum.status = sum.status.union(status);
            i += 1;
        }
        sum
    }

    /// Computes [`RotorBearingSystem::bearing_forces`] with the tangent stiffness `-df/dq`.
    pub fn bearing_forces_and_stiffness<T: Scalar, const D: usize>(
        &self,
        q: &[T; D],
        at: &[BearingKinematicState<T>; N],
    ) -> (GeneralizedForce<T, D>, SMatrix<T, D, D>)
    where
        C: ForceElement<T, D>,
    {
        let mut stiffness = SMatrix::from_element(T::ZERO);
        (self.bearing_forces_adding_stiffness(q, at, &mut stiffness), stiffness)
    }

    /// Computes [`RotorBearingSystem::bearing_forces`] and adds the tangent stiffness `-df/dq` to `stiffness`.
    pub fn bearing_forces_adding_stiffness<T: Scalar, const D: usize>(
        &self,
        q: &[T; D],
        at: &[BearingKinematicState<T>; N],
        stiffness: &mut SMatrix<T, D, D>,
    ) -> GeneralizedForce<T, D>
    where
        C: ForceElement<T, D>,
    {
        let mut sum = GeneralizedForce { force: [T::ZERO; D], load: T::ZERO, status: Status::OK };
        for (bearing, at) in self.bearings.iter().zip(at) {
            let (load, status) = bearing.add_force_and_stiffness(q, at, &mut sum.force, stiffness);
            sum.load += load;
            sum.status = sum.status.union(status);
        }
        sum
    }

    /// Returns the component angles after a rotation `delta` of the shaft.
    #[inline(always)]
    fn advance_components<T: Scalar>(&self, parts: &[ComponentAngles; N], delta: PhaseDelta) -> [ComponentAngles; N]
    where
        C: HasSpeedRatios<T>,
    {
        let mut after = *parts;
        let mut i = 0;
        while i < N {
            after[i] = self.bearings[i].speed_ratios().advance(parts[i], delta);
            i += 1;
        }
        after
    }
}

/// Completes a step: takes `next` if it is finite, else keeps the motion; returns the status. `load` and `status` are those
/// of the bearings at or near the end of the step.
#[inline(always)]
fn accept<T: Scalar, const D: usize, const N: usize>(
    state: &mut RotorState<T, D, N>,
    next: &RotorState<T, D, N>,
    shaft_is_finite: bool,
    (load, status): (T, Status),
) -> Status {
    let result_ok = next.is_finite();
    let status = Status::INPUT_NOT_FINITE
        .when(!shaft_is_finite)
        .union(Status::RESULT_NOT_FINITE.when(shaft_is_finite & !result_ok))
        .union(Status::CONTACT_LOST.when(shaft_is_finite & load.is_zero()))
        .union(status);
    let good = !status.is_held();
    if cfg!(target_pointer_width = "64") {
        // The processor predicts this branch and continues with the next step before the check is complete.
        if good {
            *state = *next;
        } else {
            state.held_steps = state.held_steps.saturating_add(1);
        }
        return status;
    }
    // No branch: an invalid step costs as much as a valid one.
    let choice = Choice::new(good);
    vector::replace_if(choice, &next.q, &mut state.q);
    vector::replace_if(choice, &next.velocity, &mut state.velocity);
    vector::replace_if(choice, &next.acceleration, &mut state.acceleration);
    state.shaft_angle = choice.select_phase(next.shaft_angle, state.shaft_angle);
    let mut i = 0;
    while i < N {
        state.component_angles[i] =
            ComponentAngles::select(choice, next.component_angles[i], state.component_angles[i]);
        i += 1;
    }
    state.held_steps = state.held_steps.saturating_add(u32::from(!good));
    status
}
