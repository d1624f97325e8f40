//! Evaluation of all balls: from the displacements of the rings to ball states and ring forces.

use super::QuasiStatic;
use super::ball::{Balance, Ball, BallInput, NO_LOAD, Position};
use super::film::Film;
use super::inertia::Inertia;
use super::solver::Solution;
use crate::bearing::Reaction;
use crate::bearing::element_position::{BLOCK_SIZE, ElementBlock, ElementLayout, ElementPosition, padded_groups};
use crate::bearing::ring::{Contact, Motion, WrenchSum};
use crate::bearing::surface::{Smooth, Surface};
use crate::frame::{Displacement, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Mask, Plane};
use crate::scalar::Scalar;
use crate::status::Status;

/// Newton steps per node of a table, where cost does not matter.
const TABLE_NEWTON_STEPS: u8 = 60;
/// Ratio of unbalanced force to largest load that is negligible against the error of a table.
const TABLE_TOLERANCE: f64 = 1e-6;

/// Least square of the sine between outer and inner contact with which the load that closes a gap is computed.
const MIN_ASIDE: f64 = 1e-2;
/// Largest load that closes a gap, over the load of the outer contact.
const MAX_GAP_LOAD: f64 = 0.3;

/// Ratio of friction to load above which a contact slips: the upper limit of traction in oil.
const TRACTION_LIMIT: f64 = 0.1;

/// Position of a ball: the start of its next solution.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallPosition<T> {
    centre: [T; 2],
    deflections: [T; 2],
}

impl<T: Scalar> BallPosition<T> {
    #[inline(always)]
    fn of_lane<const K: usize>(at: &Position<Lanes<T, K>>, j: usize) -> Self {
        Self {
            centre: [at.centre.r.0[j], at.centre.z.0[j]],
            deflections: [at.outer_deflection.0[j], at.inner_deflection.0[j]],
        }
    }

    /// Returns the position that follows this one and the two before it on a parabola: a start close to the next solution.
    #[must_use]
    pub fn extrapolated(&self, [before, earlier]: [&Self; 2]) -> Self {
        let three = T::ONE + T::ONE + T::ONE;
        let next = |now: T, before: T, earlier: T| three * (now - before) + earlier;
        let both = |[a, b]: [T; 2], [c, d]: [T; 2], [e, f]: [T; 2]| [next(a, c, e), next(b, d, f)];
        Self {
            centre: both(self.centre, before.centre, earlier.centre),
            deflections: both(self.deflections, before.deflections, earlier.deflections),
        }
    }
}

/// State of one ball.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallState<T> {
    /// Q_i, load of the inner contact, N.
    pub inner_load: T,
    /// Q_o, load of the outer contact, N.
    pub outer_load: T,
    /// Cosine and sine of the inner contact angle.
    pub inner_direction: [T; 2],
    /// Cosine and sine of the outer contact angle.
    pub outer_direction: [T; 2],
    /// h, film thickness at the inner contact, m; 0 without film or load.
    pub inner_film: T,
    /// h, film thickness at the outer contact, m; 0 without film or load.
    pub outer_film: T,
    /// F_c, centrifugal force, N.
    pub centrifugal: T,
    /// M_g, gyroscopic moment, N m, with the sign of the spin.
    pub gyroscopic_moment: T,
    /// w_c, orbital speed, rad/s; 0 for balls without mass.
    pub orbital_speed: T,
    /// True if the ball is in equilibrium within the tolerance of the precision.
    pub converged: bool,
}

/// Displacements of the two rings in the cage frame, tilts multiplied by the lever arm. A fixed outer ring costs no
/// instruction.
#[derive(Clone, Copy)]
pub(super) struct Rims<T> {
    pub inner: Displacement<T>,
    pub outer: Option<Displacement<T>>,
}

/// Forces of the balls on both rings.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RingReactions<T> {
    /// On the inner ring.
    pub inner: Reaction<T>,
    /// On the outer ring.
    pub outer: Wrench<T>,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>>
    QuasiStatic<T, M, P, I, F, S>
{
    /// Returns the ring displacements with tilts multiplied by the lever arm.
    #[inline(always)]
    pub(super) fn rims(&self, inner: &Displacement<T>, outer: Option<&Displacement<T>>) -> Rims<T> {
        let at = |u: &Displacement<T>, arm: T| Displacement { thu: arm * u.thu, thv: arm * u.thv, ..*u };
        Rims { inner: at(inner, self.inner_arm), outer: outer.map(|u| at(u, self.outer_arm)) }
    }

    #[inline(always)]
    pub(super) fn ball_input<const K: usize>(
        &self,
        positions: &[ElementPosition<T>; K],
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
    ) -> BallInput<T, K> {
        if K > 1 && self.surface.is_smooth() {
            self.ball_input_on(&Smooth, positions, rims, at)
        } else {
            self.ball_input_on(&self.surface, positions, rims, at)
        }
    }

    #[inline(always)]
    fn ball_input_on<const K: usize>(
        &self,
        surface: &impl Surface<T>,
        positions: &[ElementPosition<T>; K],
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
    ) -> BallInput<T, K> {
        let block = ElementBlock::of(positions);
        let motion = Motion::of_block(&block, &rims.inner, at, surface).with_waviness();
        let (mut radial, mut axial) = (motion.radial, motion.axial);
        if let Some(rim) = &rims.outer {
            let other = Motion::of_block(&block, rim, at, &Smooth);
            (radial, axial) = (radial - other.radial, axial - other.axial);
        }
        BallInput {
            grooves: Plane { r: radial + Lanes::splat(self.offset), z: axial },
            inner_deviation: motion.deviation.inner,
            outer_deviation: motion.deviation.outer,
            speeds: *at,
            rolling: Lanes::splat(T::ONE),
        }
    }

    /// Solves all balls group by group and passes each solution to `each_group`.
    #[inline(always)]
    pub(super) fn solve_each(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        mut each_group: impl FnMut(&[ElementPosition<T>], &Solution<T, BLOCK_SIZE>),
    ) {
        for group in padded_groups::<T, P, BLOCK_SIZE>(&self.positions) {
            let mut input = self.ball_input(&group.positions, rims, at);
            let solution = self.ball.solve(&mut input, self.newton_steps);
            each_group(group.without_padding(), &solution);
        }
    }

    /// Writes the positions of a cold start.
    pub(super) fn initial_positions(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        let mut groups = balls.chunks_mut(BLOCK_SIZE);
        self.solve_each(rims, at, |_, solution| scatter(&solution.position(), groups.next().unwrap_or_default()));
    }

    /// Solves all balls from their last positions and updates these.
    #[inline(always)]
    fn solve_each_from(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
        mut each_group: impl FnMut(&[ElementPosition<T>], &Solution<T, BLOCK_SIZE>),
    ) {
        let groups = padded_groups::<T, P, BLOCK_SIZE>(&self.positions).zip(balls.chunks_mut(BLOCK_SIZE));
        for (group, balls) in groups {
            let start = gather(balls);
            let input = M::on_registers(
                #[inline(always)]
                || {
                    let input = self.ball_input(&group.positions, rims, at);
                    input.with_rolling(self.ball.inner_approach(&input, &start))
                },
            );
            let solution = self.ball.iterate(&input, &start, self.newton_steps);
            scatter(&solution.position(), balls);
            each_group(group.without_padding(), &solution);
        }
    }

    /// Returns the state of one ball for a table, and whether it converged.
    ///
    /// The groove centres are `approach` further apart than with the rings just touching the ball, along a line at the
    /// angle with the sine `sin`. The state is the load of the inner contact (N), the sine of the angle from that line to
    /// the contact, and the friction at the inner contact (N), on ideal surfaces.
    ///
    /// Without contact at the inner race the load is negative: the force that the outer race and the centrifugal force need
    /// to move the ball aside by the gap. The load then has no kink there.
    pub(in crate::bearing) fn ball_at(&self, approach: T, sin: T, at: &BearingKinematicState<T>) -> ([T; 3], bool) {
        let constants = &self.ball.constants;
        let cos = M::sqrt(T::ONE - sin * sin);
        let length = constants.distance + approach;
        let all = Lanes::<T, 1>::splat;
        let zero = all(T::ZERO);
        let mut input = BallInput {
            grooves: Plane {
                r: all(length * cos - constants.distance * constants.axis.r),
                z: all(length * sin - constants.distance * constants.axis.z),
            },
            inner_deviation: zero,
            outer_deviation: zero,
            speeds: *at,
            rolling: all(T::ONE),
        };
        let solution = self.ball.solve(&mut input, TABLE_NEWTON_STEPS);
        let balance = &solution.balance;
        let direction = balance.inner.direction;
        let turn = all(cos) * direction.z - all(sin) * direction.r;
        let friction = balance.inner_share * balance.inertia.friction.value;
        let aside = balance.outer.direction.tangent().dot(direction);
        let per_metre =
            balance.outer.load * balance.outer.inverse_length / (aside * aside + Lanes::splat_f64(MIN_ASIDE));
        let gap = per_metre * (balance.inner.deflection - balance.inner.deflection.positive());
        // The load without a limit grows steeply beside the line on which both races face each other; no ball there is loaded.
        let most = balance.outer.load * Lanes::splat_f64(MAX_GAP_LOAD) + Lanes::splat_f64(NO_LOAD);
        let load = balance.inner.load + gap * most / (most - gap);
        let ([load], [turn], [friction]) = (load.0, turn.0, friction.0);
        let [converged] = balance.is_converged(T::from_f64(TABLE_TOLERANCE)).0;
        ([load, turn, friction], converged)
    }

    /// Calls `put` with the state of each ball in order.
    pub(super) fn states(&self, rims: &Rims<T>, at: &BearingKinematicState<T>, mut put: impl FnMut(BallState<T>)) {
        let diameter = T::from_f64(self.geometry.ball_diameter);
        self.solve_each(rims, at, |positions, solution| {
            for (_, state) in positions.iter().zip(states(solution, diameter)) {
                put(state);
            }
        });
    }

    /// Computes the reaction on the inner ring in the cage frame.
    #[inline(always)]
    pub(super) fn inner_reaction(&self, rims: &Rims<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        if self.has_two_precisions() {
            return self.reaction_by_two_precisions(rims, at, None, &mut []);
        }
        let mut sum = InnerSum::new();
        self.solve_each(rims, at, |positions, solution| sum.add(positions, &self.ball.inner_forces(solution)));
        sum.finish(self.inner_arm)
    }

    /// Computes the reaction on the inner ring in the cage frame, and the loads on the inner race.
    #[inline(always)]
    pub(super) fn inner_reaction_and_loads(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        if self.has_two_precisions() {
            return self.reaction_by_two_precisions(rims, at, None, loads);
        }
        let (mut sum, mut loads) = (InnerSum::new(), loads.iter_mut());
        self.solve_each(rims, at, |positions, solution| {
            let forces = self.ball.inner_forces(solution);
            sum.add(positions, &forces);
            forces.write_loads(positions, &mut loads);
        });
        sum.finish(self.inner_arm)
    }

    /// Computes the reaction on the inner ring starting from the last ball positions.
    #[inline(always)]
    pub(super) fn inner_reaction_from(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        if self.has_two_precisions() {
            return self.reaction_by_two_precisions(rims, at, Some(balls), &mut []);
        }
        let mut sum = InnerSum::new();
        self.solve_each_from(rims, at, balls, |positions, solution| {
            sum.add(positions, &self.ball.inner_forces(solution));
        });
        sum.finish(self.inner_arm)
    }

    /// Computes the reactions on both rings in the cage frame.
    #[inline(always)]
    pub(super) fn both_reactions(&self, rims: &Rims<T>, at: &BearingKinematicState<T>) -> RingReactions<T> {
        let (mut inner, mut outer) = (InnerSum::new(), WrenchSum::new());
        self.solve_each(rims, at, |positions, solution| {
            inner.add(positions, &self.ball.inner_forces(solution));
            outer.add_each(positions, &self.ball.outer_contacts(&solution.balance), 0);
        });
        RingReactions { inner: inner.finish(self.inner_arm), outer: outer.finish(self.outer_arm, T::ONE).wrench }
    }
}

/// Forces of `K` balls on the inner ring, and their status.
pub(super) struct InnerForces<T, const K: usize> {
    pub contact: Contact<Lanes<T, K>>,
    pub converged: Mask<K>,
    pub slips: Mask<K>,
}

impl<T: Scalar, const K: usize> InnerForces<T, K> {
    pub fn new() -> Self {
        let zero = Lanes::splat(T::ZERO);
        let no = Mask([false; K]);
        Self { contact: Contact { radial: zero, axial: zero, tilting: zero, load: zero }, converged: no, slips: no }
    }
    /// Writes the loads of the balls at `positions` to the next of `loads`.
    #[inline(always)]
    pub fn write_loads<'a>(&self, positions: &[ElementPosition<T>], loads: &mut impl Iterator<Item = &'a mut T>)
    where
        T: 'a,
    {
        for ((_, &found), load) in positions.iter().zip(&self.contact.load.0).zip(loads) {
            *load = found;
        }
    }
}

/// Sum of the forces on the inner ring, and the status flags of the solutions.
pub(super) struct InnerSum<T> {
    forces: WrenchSum<T>,
    status: Status,
}

impl<T: Scalar> InnerSum<T> {
    pub fn new() -> Self {
        Self { forces: WrenchSum::new(), status: Status::OK }
    }

    #[inline(always)]
    pub fn add<const K: usize>(&mut self, positions: &[ElementPosition<T>], forces: &InnerForces<T, K>) {
        self.forces.add_each(positions, &forces.contact, 0);
        // The padding repeats the last ball.
        let open = Status::NOT_CONVERGED.when(!forces.converged.all());
        self.status = self.status.union(open).union(Status::GYROSCOPIC_SLIP.when(forces.slips.any()));
    }

    #[inline(always)]
    pub fn finish(&self, arm: T) -> Reaction<T> {
        Reaction { status: self.status, ..self.forces.finish(arm, T::ONE) }
    }
}

impl<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>> Ball<T, M, I, F> {
    /// Returns the negative force of the balls on the inner ring, `Q_i e_i - lambda_i (M_g/D) t_i`, with the friction
    /// couple.
    #[inline(always)]
    fn inner_contacts<const K: usize>(&self, balance: &Balance<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let contact = &balance.inner;
        let mut force = contact.direction.times(contact.load);
        let mut tilting = force.z;
        if self.inertia.effects().gyroscopic {
            let friction = balance.inner_share * balance.inertia.friction.value;
            force = force.minus(contact.direction.tangent().times(friction));
            tilting = force.z + friction * Lanes::splat(self.constants.inner_couple);
        }
        Contact { radial: force.r, axial: force.z, tilting, load: contact.load }
    }

    /// Returns the forces on the inner ring with their status.
    #[inline(always)]
    pub(super) fn inner_forces<const K: usize>(&self, solution: &Solution<T, K>) -> InnerForces<T, K> {
        let balance = &solution.balance;
        let slips = if self.inertia.effects().gyroscopic { balance.slips() } else { Mask([false; K]) };
        InnerForces { contact: self.inner_contacts(balance), converged: solution.converged, slips }
    }

    /// Returns the negative force of the balls on the outer ring.
    #[inline(always)]
    fn outer_contacts<const K: usize>(&self, balance: &Balance<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let contact = &balance.outer;
        let mut force = contact.direction.times(-contact.load);
        let mut tilting = force.z;
        if self.inertia.effects().gyroscopic {
            let friction = balance.outer_share * balance.inertia.friction.value;
            force = force.plus(contact.direction.tangent().times(friction));
            tilting = force.z + friction * Lanes::splat(self.constants.outer_couple);
        }
        Contact { radial: force.r, axial: force.z, tilting, load: contact.load }
    }
}

impl<T: Scalar, const K: usize> Balance<Lanes<T, K>> {
    /// Returns true for balls whose friction exceeds the traction limit.
    #[inline(always)]
    fn slips(&self) -> Mask<K> {
        let friction = self.inertia.friction.value.abs();
        let traction = Lanes::splat_f64(TRACTION_LIMIT);
        let outer = (traction * self.outer.load).less_than(self.outer_share * friction);
        let inner = (traction * self.inner.load).less_than(self.inner_share * friction);
        outer.or(inner)
    }
}

/// Returns the positions of up to `K` balls side by side, padded with the last one.
#[inline(always)]
pub(super) fn gather<T: Scalar, const K: usize>(balls: &[BallPosition<T>]) -> Position<Lanes<T, K>> {
    let mut padded = [BallPosition::default(); K];
    if let Some(all) = balls.first_chunk() {
        padded = *all;
    } else {
        let mut last = BallPosition::default();
        let mut balls = balls.iter();
        for ball in &mut padded {
            last = balls.next().copied().unwrap_or(last);
            *ball = last;
        }
    }
    Position {
        centre: Plane {
            r: Lanes::gather(&padded, |ball| ball.centre[0]),
            z: Lanes::gather(&padded, |ball| ball.centre[1]),
        },
        outer_deflection: Lanes::gather(&padded, |ball| ball.deflections[0]),
        inner_deflection: Lanes::gather(&padded, |ball| ball.deflections[1]),
        inner_closing: Lanes::splat(T::ONE),
    }
}

/// Writes the positions of the balls that have finite ones.
#[inline(always)]
pub(super) fn scatter<T: Scalar, const K: usize>(at: &Position<Lanes<T, K>>, balls: &mut [BallPosition<T>]) {
    let mut j = 0;
    while j < K {
        let Some(ball) = balls.get_mut(j) else { break };
        let new = BallPosition::of_lane(at, j);
        let ([r, z], [outer, inner]) = (new.centre, new.deflections);
        let good = (r + z + outer + inner).is_finite();
        let keep = |new: T, old: T| T::select(good, new, old);
        let ([old_r, old_z], [old_outer, old_inner]) = (ball.centre, ball.deflections);
        ball.centre = [keep(r, old_r), keep(z, old_z)];
        ball.deflections = [keep(outer, old_outer), keep(inner, old_inner)];
        j += 1;
    }
}

/// Writes positions that are finite.
#[inline(always)]
pub(super) fn scatter_finite<T: Scalar, const K: usize>(at: &Position<Lanes<T, K>>, balls: &mut [BallPosition<T>]) {
    let mut j = 0;
    while j < K {
        let Some(ball) = balls.get_mut(j) else { break };
        *ball = BallPosition::of_lane(at, j);
        j += 1;
    }
}

fn states<T: Scalar, const K: usize>(solution: &Solution<T, K>, diameter: T) -> [BallState<T>; K] {
    let balance = &solution.balance;
    let (inner, outer) = (&balance.inner, &balance.outer);
    let lane = |lanes: &Lanes<T, K>, j: usize| lanes.0.get(j).copied().unwrap_or(T::ZERO);
    let direction = |p: &Plane<Lanes<T, K>>, j| [lane(&p.r, j), lane(&p.z, j)];
    let film = |film, load: T| if load > T::ZERO { film } else { T::ZERO };
    core::array::from_fn(|j| BallState {
        inner_load: lane(&inner.load, j),
        outer_load: lane(&outer.load, j),
        inner_direction: direction(&inner.direction, j),
        outer_direction: direction(&outer.direction, j),
        inner_film: film(lane(&inner.film, j), lane(&inner.load, j)),
        outer_film: film(lane(&outer.film, j), lane(&outer.load, j)),
        centrifugal: lane(&balance.inertia.centrifugal.value, j),
        gyroscopic_moment: diameter * lane(&balance.inertia.friction.value, j),
        orbital_speed: lane(&balance.inertia.orbital, j),
        converged: solution.converged.0.get(j).copied().unwrap_or(false),
    })
}
