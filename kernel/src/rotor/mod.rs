//! Rotors on bearings, and the integrators that move them.
//!
//! `M q'' + (B + w G) q' + K q = f_E(t) + f_B(q, t)` (Hajzman, eq. 6). A [`SecondOrderSystem`] is the linear side and what excites
//! it: [`RigidRotor`], five coordinates `q = [u v w thu thv]` of the centre of mass, at the least cost; [`LinearSystem`], any
//! coordinates from matrices, among them the rigid rotor on flexible [`supported`] bearings and a reduced finite-element
//! rotor. A [`ForceElement`] is what pushes on the coordinates: a bearing [`Mounted`] on a rigid rotor or [`AttachedElement`] to any
//! coordinates, and [`MovingBalls`], whose balls are coordinates themselves.

mod equilibrium;
mod force_element;
mod linear_system;
mod moving_balls;
mod newmark;
mod rigid;
mod runge_kutta;
mod second_order;
mod shaft_motion;
mod solve;
mod speed_ratios;
mod supported;
mod vector;
mod verlet;

pub use equilibrium::{Equilibrium, equilibrium};
pub use force_element::{AttachedElement, Attachment, ForceElement, HasSpeedRatios, Mounted};
pub use linear_system::{InvalidMatrix, LinearSystem, Matrices};
pub use moving_balls::{MovingBalls, MovingBallsParams};
pub use newmark::Newmark;
pub use rigid::{RigidRotor, RotorParams, Unbalance};
pub use runge_kutta::RungeKutta4;
pub use second_order::SecondOrderSystem;
pub use shaft_motion::ShaftMotion;
pub use solve::solve;
pub use speed_ratios::{ComponentAngles, SpeedRatios};
pub use supported::{Support, supported};
pub use verlet::{SteadyVerlet, Verlet};

use crate::choice::Choice;
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::phase::{Phase, PhaseDelta};
use crate::scalar::Scalar;
use crate::status::Status;
use nalgebra::SMatrix;

/// A rotor and its `N` bearings: the parameters of the hot path.
///
/// ```
/// use ballrace::bearing::linear::Linear;
/// use ballrace::rotor::{ShaftMotion, SpeedRatios, Integrator, RotorBearingSystem, Mounted, RigidRotor, RotorParams, RotorState, RungeKutta4};
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
/// let at = |station| Mounted { bearing: springs, station, gear: SpeedRatios::new(0.4) };
/// let machine = RotorBearingSystem { rotor, bearings: [at(-0.1), at(0.1)] };
///
/// // 1 kg on 2e6 N/m: let go at 1 um, it is at -1 um half a period later.
/// let start = Displacement { u: 1e-6, ..Displacement::default() };
/// let mut state = RotorState::at_rest(start, Phase::ZERO, [Phase::ZERO; 2]);
/// let half_period = std::f64::consts::PI / 2e6_f64.sqrt();
/// let standing = ShaftMotion { angle: Phase::ZERO, speed: 0.0, acceleration: 0.0 };
/// for _ in 0..100 {
///     let status = RungeKutta4 { step: half_period / 100.0 }.step(&machine, &mut state, &standing);
///     assert!(!status.is_held());
/// }
/// assert!((state.displacement().u + 1e-6).abs() < 1e-13);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct RotorBearingSystem<R, C, const N: usize> {
    /// The rotor and what acts on it: a [`SecondOrderSystem`].
    pub rotor: R,
    /// Its bearings: each a [`ForceElement`].
    pub bearings: [C; N],
}

/// What changes from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorState<T, const D: usize, const N: usize> {
    /// The coordinates: of a rigid rotor, the displacement of its centre of mass.
    pub q: [T; D],
    /// Their rate, per second.
    pub rate: [T; D],
    /// Their second derivative, carried by Newmark from step to step.
    pub acceleration: [T; D],
    /// Angles of each bearing's parts at shaft angle `shaft`.
    pub parts: [ComponentAngles; N],
    /// Shaft angle up to which the parts have been turned.
    pub shaft: Phase,
    /// Steps answered with the state held (saturating).
    pub held: u32,
}

impl<T: Scalar, const D: usize, const N: usize> RotorState<T, D, N> {
    /// At rest at `q`, with the shaft and the bearings' parts (or only their cages) at these angles.
    pub fn at_rest(q: impl Into<[T; D]>, shaft: Phase, parts: [impl Into<ComponentAngles>; N]) -> Self {
        let zero = [T::ZERO; D];
        Self { q: q.into(), rate: zero, acceleration: zero, parts: parts.map(Into::into), shaft, held: 0 }
    }

    fn is_finite(&self) -> bool {
        vector::all_finite(&self.q) & vector::all_finite(&self.rate) & vector::all_finite(&self.acceleration)
    }
}

impl<T: Scalar, const N: usize> RotorState<T, 5, N> {
    /// Displacement of a rigid rotor's centre of mass.
    pub fn displacement(&self) -> Displacement<T> {
        Displacement::from_array(self.q)
    }
}

/// One way to step a [`RotorBearingSystem`] forward by a fixed time.
pub trait Integrator<T: Scalar> {
    /// From the state at the start of the step, whose shaft moves as `drive` says, to its end.
    ///
    /// A drive or result that is not finite leaves motion as it was, flagged and counted.
    fn step<R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
        &self,
        machine: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<T, D, N>,
        drive: &ShaftMotion<T>,
    ) -> Status;
}

/// What all bearings of a machine answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneralizedForce<T, const D: usize> {
    /// Forces on the coordinates.
    pub force: [T; D],
    /// Sum of the element loads, N: 0 where contact is lost.
    pub load: T,
    /// What the evaluation has to say of itself.
    pub status: Status,
}

// The loops over the bearings count by hand: the compiler takes these apart, those of iterators over two arrays it does not.
impl<R, C, const N: usize> RotorBearingSystem<R, C, N> {
    /// What each bearing sees at `drive` with its parts at `parts`.
    #[inline(always)]
    pub fn rotations<T: Scalar>(
        &self,
        parts: &[ComponentAngles; N],
        drive: &ShaftMotion<T>,
    ) -> [BearingKinematicState<T>; N]
    where
        C: HasSpeedRatios<T>,
    {
        let mut rotations = [BearingKinematicState::default(); N];
        let mut i = 0;
        while i < N {
            rotations[i] = self.bearings[i].gear().rotation(parts[i], drive);
            i += 1;
        }
        rotations
    }

    /// Forces of all bearings on the coordinates, sum of loads, status.
    #[inline(always)]
    pub fn push<T: Scalar, const D: usize>(
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
            let (load, status) = self.bearings[i].push(q, &at[i], &mut sum.force);
            sum.load += load;
            sum.status = sum.status.and(status);
            i += 1;
        }
        sum
    }

    /// As [`RotorBearingSystem::push`], with the tangent stiffness `-df/dq`.
    pub fn push_and_stiffness<T: Scalar, const D: usize>(
        &self,
        q: &[T; D],
        at: &[BearingKinematicState<T>; N],
    ) -> (GeneralizedForce<T, D>, SMatrix<T, D, D>)
    where
        C: ForceElement<T, D>,
    {
        let mut stiffness = SMatrix::from_element(T::ZERO);
        (self.push_with_stiffness(q, at, &mut stiffness), stiffness)
    }

    /// As [`RotorBearingSystem::push`], and adds the tangent stiffness `-df/dq` to `stiffness`.
    pub fn push_with_stiffness<T: Scalar, const D: usize>(
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
            let (load, status) = bearing.push_with_stiffness(q, at, &mut sum.force, stiffness);
            sum.load += load;
            sum.status = sum.status.and(status);
        }
        sum
    }

    /// The bearings' parts after the shaft has gone `arc` further.
    #[inline(always)]
    fn parts_after<T: Scalar>(&self, parts: &[ComponentAngles; N], arc: PhaseDelta) -> [ComponentAngles; N]
    where
        C: HasSpeedRatios<T>,
    {
        let mut after = *parts;
        let mut i = 0;
        while i < N {
            after[i] = self.bearings[i].gear().after(parts[i], arc);
            i += 1;
        }
        after
    }
}

/// Common end of a step: keeps `next` if it is good, else holds the motion; says which. `load` and `status` are what the
/// bearings answered at the end of the step, or close to it.
#[inline(always)]
fn accept<T: Scalar, const D: usize, const N: usize>(
    state: &mut RotorState<T, D, N>,
    next: &RotorState<T, D, N>,
    drive_ok: bool,
    (load, status): (T, Status),
) -> Status {
    let result_ok = next.is_finite();
    let status = Status::INPUT_NOT_FINITE
        .when(!drive_ok)
        .and(Status::RESULT_NOT_FINITE.when(drive_ok & !result_ok))
        .and(Status::CONTACT_LOST.when(drive_ok & load.is_zero()))
        .and(status);
    let good = !status.is_held();
    if cfg!(target_pointer_width = "64") {
        // A desktop processor foresees the branch, and is at the next step while it still looks at the numbers of this one.
        if good {
            *state = *next;
        } else {
            state.held = state.held.saturating_add(1);
        }
        return status;
    }
    // No branch here: a held step costs what a good one costs.
    let choice = Choice::new(good);
    vector::take(choice, &next.q, &mut state.q);
    vector::take(choice, &next.rate, &mut state.rate);
    vector::take(choice, &next.acceleration, &mut state.acceleration);
    state.shaft = choice.of_turns(next.shaft, state.shaft);
    let mut i = 0;
    while i < N {
        state.parts[i] = ComponentAngles::chosen(choice, next.parts[i], state.parts[i]);
        i += 1;
    }
    state.held = state.held.saturating_add(u32::from(!good));
    status
}
