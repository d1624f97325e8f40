//! A rigid rotor of five degrees of freedom on bearings, and its integrators.
//!
//! `M q'' + (B + w G) q' + K q = f_E(t) + f_B(q, t)` (Hajzman, eq. 6) with `q = [u v w thu thv]` of the centre
//! of mass. A bearing at station `z` sees `u + z thv`, `v - z thu` and answers with a wrench moved back.

mod drive;
mod equilibrium;
mod gear;
mod newmark;
mod rigid;
mod runge_kutta;
mod solve;

pub use drive::Drive;
pub use equilibrium::{Equilibrium, equilibrium};
pub use gear::{Gear, PartAngles};
pub use newmark::Newmark;
pub use rigid::{RigidRotor, RotorParams, Unbalance};
pub use runge_kutta::RungeKutta4;
pub use solve::solve;

use crate::bearing::{Bearing, Reaction};
use crate::frame::{Displacement, Stiffness, stiffness_from_station};
use crate::math::Math;
use crate::rotation::Rotation;
use crate::scalar::Scalar;
use crate::status::Status;
use crate::turn::{Arc, Turn};

/// A bearing on the rotor.
#[derive(Debug, Clone, Copy)]
pub struct Mounted<T, B> {
    /// What it answers to a displacement.
    pub bearing: B,
    /// Along Z from the centre of mass, m.
    pub station: T,
    /// How its parts follow the shaft.
    pub gear: Gear<T>,
}

/// A rotor and its `N` bearings: the parameters of the hot path.
///
/// ```
/// use ballrace::bearing::linear::Linear;
/// use ballrace::rotor::{Drive, Gear, Integrator, Machine, Mounted, RigidRotor, RotorParams, RotorState, RungeKutta4};
/// use ballrace::{Displacement, Exact, Stiffness, Turn};
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
/// let at = |station| Mounted { bearing: springs, station, gear: Gear::new(0.4) };
/// let machine = Machine { rotor, bearings: [at(-0.1), at(0.1)] };
///
/// // 1 kg on 2e6 N/m: let go at 1 um, it is at -1 um half a period later.
/// let start = Displacement { u: 1e-6, ..Displacement::default() };
/// let mut state = RotorState::at_rest(start, Turn::ZERO, [Turn::ZERO; 2]);
/// let half_period = std::f64::consts::PI / 2e6_f64.sqrt();
/// let standing = Drive { angle: Turn::ZERO, speed: 0.0, acceleration: 0.0 };
/// for _ in 0..100 {
///     let status = RungeKutta4 { step: half_period / 100.0 }.step(&machine, &mut state, &standing);
///     assert!(!status.is_held());
/// }
/// assert!((state.q.u + 1e-6).abs() < 1e-13);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Machine<T: Scalar, M, B, const N: usize> {
    /// The rotor and what acts on it.
    pub rotor: RigidRotor<T, M>,
    /// Its bearings.
    pub bearings: [Mounted<T, B>; N],
}

/// What changes from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorState<T, const N: usize> {
    /// Displacement of the centre of mass.
    pub q: Displacement<T>,
    /// Its rate, per second.
    pub rate: Displacement<T>,
    /// Its second derivative, carried by Newmark from step to step.
    pub acceleration: Displacement<T>,
    /// Angles of each bearing's parts at shaft angle `shaft`.
    pub parts: [PartAngles; N],
    /// Shaft angle up to which the parts have been turned.
    pub shaft: Turn,
    /// Steps answered with the state held (saturating).
    pub held: u32,
}

impl<T: Scalar, const N: usize> RotorState<T, N> {
    /// At rest at `q`, with the shaft and the bearings' parts (or only their cages) at these angles.
    pub fn at_rest(q: Displacement<T>, shaft: Turn, parts: [impl Into<PartAngles>; N]) -> Self {
        let zero = Displacement::default();
        Self { q, rate: zero, acceleration: zero, parts: parts.map(Into::into), shaft, held: 0 }
    }

    fn is_finite(&self) -> bool {
        self.q.is_finite() & self.rate.is_finite() & self.acceleration.is_finite()
    }
}

/// One way to step a [`Machine`] forward by a fixed time.
pub trait Integrator<T: Scalar> {
    /// From the state at the start of the step, whose shaft moves as `drive` says, to its end.
    ///
    /// A drive or result that is not finite leaves motion as it was, flagged and counted.
    fn step<M: Math<T>, B: Bearing<T>, const N: usize>(
        &self,
        machine: &Machine<T, M, B, N>,
        state: &mut RotorState<T, N>,
        drive: &Drive<T>,
    ) -> Status;
}

impl<T: Scalar, M: Math<T>, B: Bearing<T>, const N: usize> Machine<T, M, B, N> {
    /// What each bearing sees at `drive` with its parts at `parts`.
    pub fn rotations(&self, parts: &[PartAngles; N], drive: &Drive<T>) -> [Rotation<T>; N] {
        let mut rotations = [Rotation::default(); N];
        for ((rotation, mounted), &angles) in rotations.iter_mut().zip(&self.bearings).zip(parts) {
            *rotation = mounted.gear.rotation(angles, drive);
        }
        rotations
    }

    /// Answer of all bearings on the rotor, taken at its centre of mass: wrench, sum of loads, status.
    pub fn bearing_reaction(&self, q: &Displacement<T>, at: &[Rotation<T>; N]) -> Reaction<T> {
        let start = Reaction { load: T::ZERO, ..Reaction::default() };
        self.bearings.iter().zip(at).fold(start, |sum, (mounted, at)| {
            let reaction = mounted.bearing.reaction(&q.at_station(mounted.station), at);
            sum.plus(reaction.moved_from(mounted.station))
        })
    }

    /// As [`Machine::bearing_reaction`], with the tangent stiffness at the centre of mass.
    pub fn bearing_reaction_and_stiffness(
        &self,
        q: &Displacement<T>,
        at: &[Rotation<T>; N],
    ) -> (Reaction<T>, Stiffness<T>) {
        let start = (Reaction::default(), Stiffness::from_element(T::ZERO));
        self.bearings.iter().zip(at).fold(start, |(sum, stiffness), (mounted, at)| {
            let (reaction, k) = mounted.bearing.reaction_and_stiffness(&q.at_station(mounted.station), at);
            let moved = stiffness_from_station(&k, mounted.station);
            (sum.plus(reaction.moved_from(mounted.station)), stiffness + moved)
        })
    }

    /// The bearings' parts after the shaft has gone `arc` further.
    fn parts_after(&self, parts: &[PartAngles; N], arc: Arc) -> [PartAngles; N] {
        let mut after = *parts;
        for (angles, mounted) in after.iter_mut().zip(&self.bearings) {
            *angles = mounted.gear.after(*angles, arc);
        }
        after
    }

    /// Common end of a step: keeps `next` if it is good, else holds the motion; says which. `bearings` is what they
    /// answered at the end of the step, or close to it.
    fn accept(state: &mut RotorState<T, N>, next: RotorState<T, N>, drive_ok: bool, bearings: &Reaction<T>) -> Status {
        let result_ok = next.is_finite();
        let status = Status::INPUT_NOT_FINITE
            .when(!drive_ok)
            .and(Status::RESULT_NOT_FINITE.when(drive_ok & !result_ok))
            .and(Status::CONTACT_LOST.when(drive_ok & bearings.load.is_zero()))
            .and(bearings.status);
        // No branch here: a held step costs what a good one costs.
        let good = !status.is_held();
        state.q = Displacement::choose(good, next.q, state.q);
        state.rate = Displacement::choose(good, next.rate, state.rate);
        state.acceleration = Displacement::choose(good, next.acceleration, state.acceleration);
        state.shaft = Turn::choose(good, next.shaft, state.shaft);
        for (angles, after) in state.parts.iter_mut().zip(next.parts) {
            *angles = PartAngles::choose(good, after, *angles);
        }
        state.held = state.held.saturating_add(u32::from(!good));
        status
    }
}
