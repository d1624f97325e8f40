//! Equilibrium of each cylindrical roller between the races, with its centrifugal force
//! (`docs/src/models.md#rollers-in-equilibrium`).
//!
//! The unknowns of a roller are the radial displacement `rho` of its centre and its tilt `tau`. With the contact stiffness
//! `K_c = 2^(10/9) K` of each race,
//!
//! ```text
//! delta_o = rho + x tau - P,  delta_i = (u cos phi + v sin phi) - gamma + x psi - (rho + x tau) - P
//! sum (q_i - q_o) + F_c = 0,  sum x (q_i - q_o) = 0,  F_c = m R w_c^2
//! ```
//!
//! Both equations are the gradient of a convex energy: Newton's method with a line search reaches its minimum from every start.
//! A roller that the inner ring does not touch lies on the outer race without tilt.

use super::{Lamina, LaminaRoller, LaminaStiffness, LaminaSum, RollerMotion, RollerState};
use crate::bearing::element_position::{BLOCK_SIZE, ElementLayout};
use crate::bearing::elements::CageFrame;
use crate::bearing::geometry::{InvalidParameter, check};
use crate::bearing::ring::{CageRotation, StiffnessSum, WrenchSum, to_cage_frame};
use crate::bearing::surface::{Smooth, Surface};
use crate::bearing::{Reaction, bearing_in_cage};
use crate::contact::law::{LineContactLaw, LoadDeflectionLaw};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Mask};
use crate::phase::Phase;
use crate::scalar::Scalar;
use crate::status::Status;

/// Evaluations of the equations of each roller.
pub const DEFAULT_ROLLER_STEPS: u8 = 24;
/// Newton steps for the position of a roller that only its centrifugal force loads.
const FREE_STEPS: u8 = 8;
/// Largest slope of the energy after a step over that before it, with which the step is accepted.
const ACCEPTED: f64 = 0.9;
/// Least and largest part of a rejected step that is tried next.
const SHORTENED: [f64; 2] = [0.1, 0.7];

/// Inertia of the rollers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollerInertia {
    /// m, mass of a roller, kg, 0 or more.
    pub mass: f64,
    /// Cage speed as a weighted sum of the speeds of inner and outer ring, `w_c = a w_i + b w_o`.
    pub cage_speed: [f64; 2],
}

impl RollerInertia {
    /// Returns the inertia of solid cylinders in pure rolling: `m = rho_s pi D^2 L / 4`, `w_c = w_i (1 - D/d_m)/2 + w_o (1 + D/d_m)/2`.
    #[must_use]
    pub fn of_cylinders(diameter: f64, length: f64, pitch_diameter: f64, density: f64) -> Self {
        let ratio = diameter / pitch_diameter;
        Self {
            mass: density * core::f64::consts::FRAC_PI_4 * diameter * diameter * length,
            cage_speed: [0.5 * (1.0 - ratio), 0.5 * (1.0 + ratio)],
        }
    }
}

/// A cylindrical roller bearing with each roller in equilibrium. Cost per roller: a fixed number of evaluations of both contacts of each
/// lamina, independent of the state.
///
/// Without rotation its forces are those of [`LaminaRoller`].
#[derive(Debug, Clone, Copy)]
pub struct QuasiStaticRoller<T, M, P, A, S = Smooth> {
    rollers: LaminaRoller<T, M, P, A, S>,
    /// `m R n / K`: centrifugal force without scale over the square of the cage speed.
    centrifugal: T,
    cage_speed: [T; 2],
    steps: u8,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>>
    QuasiStaticRoller<T, M, P, A, S>
{
    /// Creates the bearing from its rollers in series and their inertia. For set-up.
    ///
    /// # Errors
    /// A contact angle other than 0: the flange force of tapered rollers is not modelled. A mass that is negative or not finite.
    pub fn try_new(rollers: LaminaRoller<T, M, P, A, S>, inertia: &RollerInertia) -> Result<Self, InvalidParameter> {
        let [_, sin] = rollers.axis;
        let angle = libm::asin(sin.to_f64());
        check(sin.is_zero(), "contact_angle", angle, "0 rad for rollers in equilibrium")?;
        check(inertia.mass >= 0.0, "mass", inertia.mass, "0 kg or more")?;
        let scale = inertia.mass * rollers.ring.arm.to_f64() / rollers.law.stiffness.to_f64();
        let cage_speed = inertia.cage_speed.map(T::from_f64);
        Ok(Self { rollers, centrifugal: T::from_f64(scale), cage_speed, steps: DEFAULT_ROLLER_STEPS })
    }

    /// Returns the bearing with another number of evaluations of the equations of each roller.
    #[must_use]
    pub fn with_steps(self, steps: u8) -> Self {
        Self { steps, ..self }
    }
}

/// Sums of both contacts of the rollers at a position, unscaled.
struct Balance<L> {
    /// `sum (q_i - q_o) + F_c` and `sum x (q_i - q_o)`.
    force: L,
    moment: L,
    /// Moments of the stiffness of both contacts along the roller.
    stiffness: LaminaStiffness<L>,
    /// `sum (q_i + q_o)`
    load: L,
}

/// Position of the centre and tilt of rollers.
#[derive(Debug, Clone, Copy)]
struct Position<L> {
    radial: L,
    tilt: L,
}

impl<T: Scalar, const K: usize> Position<Lanes<T, K>> {
    #[inline(always)]
    fn select(first: Mask<K>, a: Self, b: Self) -> Self {
        Self { radial: Lanes::select(first, a.radial, b.radial), tilt: Lanes::select(first, a.tilt, b.tilt) }
    }
}

/// Loads at one contact and its stiffness.
#[derive(Debug, Clone, Copy)]
struct ContactSums<T> {
    loads: LaminaSum<Lanes<T, 1>>,
    stiffness: LaminaStiffness<T>,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>>
    QuasiStaticRoller<T, M, P, A, S>
{
    /// Writes the state of each roller in order, as many as `states` takes.
    pub fn roller_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [RollerState<T>]) {
        let mut states = states.iter_mut();
        let scale = self.scale();
        self.solve_each(&to_cage_frame(u, M::sin_cos(at.cage)), at, |solved| {
            for i in 0..solved.count {
                let contact = |sum: &LaminaSum<Lanes<T, BLOCK_SIZE>>| lane(&sum.scaled(scale), i);
                if let Some(state) = states.next() {
                    *state = RollerState {
                        inner: contact(&solved.inner),
                        outer: contact(&solved.outer),
                        tilt: lane(&solved.at.tilt.0, i),
                    };
                }
            }
        });
    }

    /// Writes the loads of the laminae of roller `index` at the inner race in order, N, as many as `loads` takes.
    pub fn lamina_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, index: usize, loads: &mut [T]) {
        let Some(roller) = self.rollers.ring.positions.all().nth(index) else { return };
        let motion = self.rollers.motion(&[roller], &to_cage_frame(u, M::sin_cos(at.cage)), at);
        let (force, free) = self.free(at);
        let position = self.position(motion, force, free).0;
        for (lamina, load) in self.rollers.laminae.as_ref().iter().zip(loads) {
            let Lanes([unscaled]) = self.loads_of(deflections(lamina, motion, position).inner);
            *load = self.scale() * unscaled;
        }
    }

    /// Returns the factor from unscaled loads of [`Self::loads_of`] to newtons: `q = (K/n) (2 delta)^(10/9)`.
    #[inline(always)]
    fn scale(&self) -> T {
        self.rollers.law.stiffness
    }

    #[inline(always)]
    fn loads_of<const K: usize>(&self, deflection: Lanes<T, K>) -> Lanes<T, K> {
        self.rollers.unscaled_load(deflection)
    }

    /// Returns load and derivative of contacts, unscaled.
    #[inline(always)]
    fn load_and_slope<const K: usize>(&self, deflection: Lanes<T, K>) -> [Lanes<T, K>; 2] {
        let mut slopes = deflection.twice_positive_part();
        let mut loads = slopes;
        let mut i = 0;
        while i < K {
            (loads.0[i], slopes.0[i]) =
                <LineContactLaw<T> as LoadDeflectionLaw<T, M>>::unscaled_load_and_slope(&self.rollers.law, slopes.0[i]);
            i += 1;
        }
        [loads, slopes]
    }

    /// Returns the centrifugal force without scale, and the position of a roller that it alone loads.
    #[inline(always)]
    fn free(&self, at: &BearingKinematicState<T>) -> (T, T) {
        let [inner, outer] = self.cage_speed;
        let speed = inner * at.inner_speed + outer * at.outer_speed;
        let force = self.centrifugal * (speed * speed);
        let laminae = self.rollers.laminae.as_ref();
        let deepest = laminae.iter().fold(T::ZERO, |most, lamina| most.larger(lamina.drop));
        let share = force / T::from_u32((laminae.len() as u32).max(1));
        // The power 8/9 is above the power 9/10 of the solution without profile: the steps approach from above without overshoot.
        let mut radial = T::HALF * (deepest + share / M::ninth_root(share));
        for _ in 0..FREE_STEPS {
            let (mut load, mut slope) = (T::ZERO, T::from_f64(LEAST_STIFFNESS));
            for lamina in laminae {
                let [Lanes([q]), Lanes([k])] = self.load_and_slope(Lanes([radial - T::HALF * lamina.drop]));
                load += q;
                slope += k;
            }
            radial += (force - load) / slope;
        }
        (force, radial)
    }

    #[inline(always)]
    fn balance<const K: usize>(
        &self,
        motion: RollerMotion<Lanes<T, K>>,
        at: Position<Lanes<T, K>>,
        force: T,
    ) -> Balance<Lanes<T, K>> {
        let nothing = Lanes::splat(T::ZERO);
        let mut balance = Balance {
            force: Lanes::splat(force),
            moment: nothing,
            stiffness: LaminaStiffness { load: nothing, cross: nothing, tilting: nothing },
            load: nothing,
        };
        for lamina in self.rollers.laminae.as_ref() {
            let Contacts { inner, outer } = deflections(lamina, motion, at);
            let [inner, inner_slope] = self.load_and_slope(inner);
            let [outer, outer_slope] = self.load_and_slope(outer);
            let x = Lanes::splat(lamina.position);
            let (difference, slope) = (inner - outer, inner_slope + outer_slope);
            let cross = x * slope;
            balance.force = balance.force + difference;
            balance.moment = balance.moment + x * difference;
            balance.load = balance.load + (inner + outer);
            balance.stiffness.load = balance.stiffness.load + slope;
            balance.stiffness.cross = balance.stiffness.cross + cross;
            balance.stiffness.tilting = balance.stiffness.tilting + x * cross;
        }
        balance
    }

    /// Returns the positions of rollers in equilibrium, and true for those that have reached it.
    #[inline(always)]
    fn position<const K: usize>(
        &self,
        motion: RollerMotion<Lanes<T, K>>,
        force: T,
        free: T,
    ) -> (Position<Lanes<T, K>>, Mask<K>) {
        let all = Lanes::<T, K>::splat_f64;
        let half = Lanes::splat(T::HALF);
        // Without centrifugal force a roller takes half of the displacement; one without inner contact has no tilt.
        let series = Position { radial: half * motion.approach, tilt: half * motion.tilt };
        let alone = Position { radial: Lanes::splat(free), tilt: all(0.0) };
        let mut accepted = Position::select(series.radial.less_than(alone.radial), alone, series);
        let mut step = Position { radial: all(0.0), tilt: all(0.0) };
        let (mut part, mut slope) = (all(1.0), all(f64::from(f32::MAX)));
        let mut converged = Mask([false; K]);
        let most = Lanes::splat(self.half_length());
        for _ in 0..self.steps {
            let trial =
                Position { radial: accepted.radial + part * step.radial, tilt: accepted.tilt + part * step.tilt };
            let balance = self.balance(motion, trial, force);
            let after = balance.force * step.radial + balance.moment * step.tilt;
            let is_accepted = after.abs().less_than(all(ACCEPTED) * slope).or(slope.less_than(all(LEAST_SLOPE)));
            let next = newton_step(&balance, most);
            let residual = balance.force.abs().larger(balance.moment.abs() / most);
            let tolerance = Lanes::splat(T::EQUILIBRIUM_TOLERANCE) * balance.load;
            let is_near = residual.less_than(tolerance).or(balance.load.less_than(all(LEAST_SLOPE)));
            converged = Mask(core::array::from_fn(|i| {
                if lane(&is_accepted.0, i) { lane(&is_near.0, i) } else { lane(&converged.0, i) }
            }));
            accepted = Position::select(is_accepted, trial, accepted);
            // The slope of a quadratic energy is 0 at this part of the step.
            let [least, largest] = SHORTENED.map(all);
            let shorter = part * (slope / (slope - after)).larger(least).smaller(largest);
            part = Lanes::select(is_accepted, all(1.0), shorter);
            let descent = balance.force * next.radial + balance.moment * next.tilt;
            slope = Lanes::select(is_accepted, descent, slope);
            step = Position::select(is_accepted, next, step);
            if M::STOPS_EARLY && residual.less_than(all(STOPPED) * balance.load).and(is_accepted).all() {
                break;
            }
        }
        (accepted, converged)
    }

    /// Returns the distance of the outermost lamina from the centre of the roller, above 0.
    #[inline(always)]
    fn half_length(&self) -> T {
        let laminae = self.rollers.laminae.as_ref().iter();
        laminae.fold(T::from_f64(1e-6), |most, lamina| most.larger(lamina.position.abs()))
    }

    #[inline(always)]
    fn solve_each(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        mut each: impl FnMut(&SolvedRollers<'_, T, BLOCK_SIZE>),
    ) {
        let (force, free) = self.free(at);
        self.rollers.for_each_group::<BLOCK_SIZE>(
            u,
            at,
            #[inline(always)]
            |group, motion| {
                let (position, converged) = self.position(motion, force, free);
                let (mut inner, mut outer) = (LaminaSum::new(), LaminaSum::new());
                for lamina in self.rollers.laminae.as_ref() {
                    let deflection = deflections(lamina, motion, position);
                    let x = Lanes::splat(lamina.position);
                    inner.add(x, self.loads_of(deflection.inner));
                    outer.add(x, self.loads_of(deflection.outer));
                }
                let positions = group.without_padding();
                each(&SolvedRollers { positions, count: positions.len(), at: position, converged, inner, outer });
            },
        );
    }

    /// Returns the sums of both contacts of one roller, inner and outer.
    #[inline(always)]
    fn contact_sums(&self, motion: RollerMotion<Lanes<T, 1>>, at: Position<Lanes<T, 1>>) -> Contacts<ContactSums<T>> {
        let nothing = ContactSums {
            loads: LaminaSum::new(),
            stiffness: LaminaStiffness { load: T::ZERO, cross: T::ZERO, tilting: T::ZERO },
        };
        let mut sums = Contacts { inner: nothing, outer: nothing };
        for lamina in self.rollers.laminae.as_ref() {
            let deflection = deflections(lamina, motion, at);
            let add = |sum: &mut ContactSums<T>, deflection: Lanes<T, 1>| {
                let [load, Lanes([slope])] = self.load_and_slope(deflection);
                let x = lamina.position;
                sum.loads.add(Lanes([x]), load);
                sum.stiffness.load += slope;
                sum.stiffness.cross += x * slope;
                sum.stiffness.tilting += x * x * slope;
            };
            add(&mut sums.inner, deflection.inner);
            add(&mut sums.outer, deflection.outer);
        }
        sums
    }
}

/// Stiffness (without scale) below which nothing is in contact.
const LEAST_STIFFNESS: f64 = 1e-12;
/// Descent of the energy, and load, that count as none.
const LEAST_SLOPE: f64 = 1e-30;
/// Unbalanced force over the loads at which a desktop processor ends the solution.
const STOPPED: f64 = 1e-13;

/// Rollers of a group in equilibrium.
struct SolvedRollers<'a, T, const K: usize> {
    positions: &'a [crate::bearing::ElementPosition<T>],
    count: usize,
    at: Position<Lanes<T, K>>,
    converged: Mask<K>,
    inner: LaminaSum<Lanes<T, K>>,
    outer: LaminaSum<Lanes<T, K>>,
}

/// A value at each race.
struct Contacts<X> {
    inner: X,
    outer: X,
}

/// Returns the deflections of a lamina at both races.
#[inline(always)]
fn deflections<T: Scalar, const K: usize>(
    lamina: &Lamina<T>,
    motion: RollerMotion<Lanes<T, K>>,
    at: Position<Lanes<T, K>>,
) -> Contacts<Lanes<T, K>> {
    let x = Lanes::splat(lamina.position);
    let drop = Lanes::splat(T::HALF * lamina.drop);
    Contacts {
        inner: (motion.approach - at.radial) + x * (motion.tilt - at.tilt) - drop,
        outer: at.radial + x * at.tilt - drop,
    }
}

/// Returns entry `i`, or the default.
#[inline(always)]
fn lane<X: Copy + Default>(each: &[X], i: usize) -> X {
    each.get(i).copied().unwrap_or_default()
}

/// Returns the Newton step of rollers; `half_length` scales the least stiffness against tilt.
#[inline(always)]
fn newton_step<T: Scalar, const K: usize>(
    balance: &Balance<Lanes<T, K>>,
    half_length: Lanes<T, K>,
) -> Position<Lanes<T, K>> {
    let LaminaStiffness { load, cross, tilting } = balance.stiffness;
    // With one lamina in contact the stiffness is singular.
    let more = Lanes::splat(T::ONE + T::from_f64(if size_of::<T>() > 4 { 1e-12 } else { 1e-5 }));
    let least = Lanes::<T, K>::splat_f64(LEAST_STIFFNESS);
    let (load, tilting) = (load * more + least, tilting * more + least * half_length * half_length);
    let determinant = load * tilting - cross * cross;
    Position {
        radial: (balance.force * tilting - balance.moment * cross) / determinant,
        tilt: (balance.moment * load - balance.force * cross) / determinant,
    }
}

/// Returns `A (A + B)^-1 B`, the stiffness of both contacts of a roller in series.
#[inline(always)]
fn in_series<T: Scalar>(a: &LaminaStiffness<T>, b: &LaminaStiffness<T>, half_length: T) -> LaminaStiffness<T> {
    let least = T::from_f64(LEAST_STIFFNESS);
    let sum = [a.load + b.load + least, a.cross + b.cross, a.tilting + b.tilting + least * half_length * half_length];
    let determinant = sum[0] * sum[2] - sum[1] * sum[1];
    // Rounding may leave no determinant with one lamina in contact.
    let smallest = T::from_f64(if size_of::<T>() > 4 { 1e-14 } else { 1e-6 }) * sum[0] * sum[2];
    let inverse = T::ONE / determinant.larger(smallest);
    // (A + B)^-1 B
    let c = [
        inverse * (sum[2] * b.load - sum[1] * b.cross),
        inverse * (sum[2] * b.cross - sum[1] * b.tilting),
        inverse * (sum[0] * b.cross - sum[1] * b.load),
        inverse * (sum[0] * b.tilting - sum[1] * b.cross),
    ];
    LaminaStiffness {
        load: a.load * c[0] + a.cross * c[2],
        cross: a.load * c[1] + a.cross * c[3],
        tilting: a.cross * c[1] + a.tilting * c[3],
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>> CageFrame<T>
    for QuasiStaticRoller<T, M, P, A, S>
{
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<T> {
        M::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.reaction_and_loads_in_cage_frame(u, at, &mut [])
    }

    /// Writes the loads on the inner race.
    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        let scale = self.scale();
        let (mut sum, mut loads, mut converged) = (WrenchSum::new(), loads.iter_mut(), true);
        self.solve_each(
            u,
            at,
            #[inline(always)]
            |solved| {
                for (i, position) in solved.positions.iter().enumerate() {
                    let (load, moment) = (lane(&solved.inner.load.0, i), lane(&solved.inner.moment.0, i));
                    sum.add(position, &self.rollers.contact_of(load, moment));
                    if let Some(entry) = loads.next() {
                        *entry = scale * load;
                    }
                    converged &= lane(&solved.converged.0, i);
                }
            },
        );
        let reaction = sum.finish(T::ONE, scale);
        Reaction { status: reaction.status.union(Status::NOT_CONVERGED.when(!converged)), ..reaction }
    }

    #[inline]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (mut sum, mut stiffness, mut converged) = (WrenchSum::new(), StiffnessSum::new(), true);
        let (force, free) = self.free(at);
        let half_length = self.half_length();
        for roller in self.rollers.ring.positions.all() {
            let motion = self.rollers.motion(&[roller], u, at);
            let (position, reached) = self.position(motion, force, free);
            let Contacts { inner, outer } = self.contact_sums(motion, position);
            let LaminaSum { load: Lanes([load]), moment: Lanes([moment]), .. } = inner.loads;
            sum.add(&roller, &self.rollers.contact_of(load, moment));
            let k = in_series(&inner.stiffness, &outer.stiffness, half_length);
            stiffness.add_tilting(&roller, &self.rollers.stiffness_of(&k));
            converged &= reached.all();
        }
        let reaction = sum.finish(T::ONE, self.scale());
        let status = reaction.status.union(Status::NOT_CONVERGED.when(!converged));
        (Reaction { status, ..reaction }, stiffness.finish(T::ONE, self.scale(), turn))
    }

    #[inline(always)]
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.reaction_and_loads_in_cage_frame(u, at, loads);
    }
}

bearing_in_cage!(
    QuasiStaticRoller<T, M, P, A, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>
);
