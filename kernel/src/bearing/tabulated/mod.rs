//! Model `tabulated`: the quasi-static model at a small constant cost.
//!
//! The force of one ball depends on the positions of its groove centres (two numbers), the speed and the film.
//! [`fill_table`] samples it once, or `ballrace bake` writes it as constants; the hot path interpolates. Waviness moves the
//! groove centres; damage and waviness of a contact reduce the approach.

pub mod sampling;
mod table;

pub use sampling::{TableDomain, fill_table};
pub use table::{Axis, Grid, Node, Table};

use self::table::{AtSpeed, CellPositions, Rows};
use super::element_position::{BLOCK_SIZE, ElementBlock, ElementLayout, ElementPosition, padded_groups};
use super::elements::{Aligned, CageFrame, MAX_STAGED, Staged, empty_stages};
use super::quasi_static::{Matrix, TableConstants, contact_tangents};
use super::ring::{CageRotation, Contact, ContactTangent, Motion, TangentSum, WrenchSum};
use super::surface::{Smooth, Surface};
use super::{Reaction, bearing_in_cage};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Plane};
use crate::phase::Phase;
use crate::scalar::Scalar;
use crate::status::Status;
use core::marker::PhantomData;

/// A ball bearing with interpolated ball forces. Cost per ball: three square roots, one division, 9 nodes of two or three
/// numbers (18 for a table of several speeds).
///
/// Outside the domain of the table the polynomials of the last nodes continue, with [`Status::OUT_OF_TABLE`].
#[derive(Debug, Clone, Copy)]
pub struct Tabulated<T, M, P, A, const F: usize, S = Smooth> {
    positions: P,
    constants: TableConstants<T>,
    table: Table<T, A, F>,
    /// True if the table is over the speed of the outer ring, false for the inner ring.
    by_outer: bool,
    surface: S,
    math: PhantomData<M>,
}

/// Values common to all balls of one evaluation.
struct Evaluation<'a, T, const F: usize> {
    speed: AtSpeed<T>,
    rows: Rows<'a, T, F>,
    /// Displacement with tilts multiplied by the lever arm.
    rim: Displacement<T>,
    at: &'a BearingKinematicState<T>,
    /// Vector from the outer to the inner groove centres with the rings just touching the balls, m.
    rest: Plane<T>,
}

/// Coordinates of balls in the table.
#[derive(Clone, Copy)]
struct TableQuery<L> {
    /// Direction of the line of groove centres, and its inverse length.
    line: Plane<L>,
    inverse_length: L,
    /// Coordinate of the approach.
    x: L,
    /// `sqrt(|s| + a)` of the approach s.
    root: L,
    /// 1 with the sign of the approach.
    sense: L,
}

/// Interpolated contacts of balls.
#[derive(Clone, Copy)]
struct BallContacts<L> {
    /// Load, N; 0 in a gap.
    load: L,
    /// Direction of the contact; cosine and sine of the angle from the line of groove centres to it.
    contact: Plane<L>,
    turn: Plane<L>,
    friction: L,
}

/// Query and interpolated contacts of balls.
struct Lookup<L, T> {
    query: TableQuery<L>,
    contacts_of_balls: BallContacts<L>,
    /// The sign bit is set outside the domain of the table.
    inside: T,
}

/// One block of the balls that are evaluated together; SIMD stores come first, within cache lines.
#[repr(C)]
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
struct StagedBlock<'a, T> {
    line: Plane<Lanes<T, BLOCK_SIZE>>,
    x: Lanes<T, BLOCK_SIZE>,
    root: Lanes<T, BLOCK_SIZE>,
    positions: &'a [ElementPosition<T>; BLOCK_SIZE],
    /// Index of the first of them.
    first: usize,
    /// Number of them that the block before also contains.
    overlap: usize,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, const F: usize>
    Tabulated<T, M, P, A, F>
{
    /// Creates the bearing from precomputed constants, without arithmetic. `by_outer` is true if the table is over the
    /// speed of the outer ring.
    pub const fn new(positions: P, constants: TableConstants<T>, table: Table<T, A, F>, by_outer: bool) -> Self {
        Self { positions, constants, table, by_outer, surface: Smooth, math: PhantomData }
    }

    /// Returns the bearing with surface deviations.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Tabulated<T, M, P, A, F, S> {
        let Self { positions, constants, table, by_outer, math, .. } = self;
        Tabulated { positions, constants, table, by_outer, surface, math }
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    Tabulated<T, M, P, A, F, S>
{
    /// Returns the table.
    pub fn table(&self) -> &Table<T, A, F> {
        &self.table
    }

    /// Returns the constants besides positions and table.
    pub fn constants(&self) -> &TableConstants<T> {
        &self.constants
    }

    #[inline(always)]
    fn evaluation<'a>(&'a self, u: &Displacement<T>, at: &'a BearingKinematicState<T>) -> Evaluation<'a, T, F> {
        let speed = if self.by_outer { at.outer_speed } else { at.inner_speed };
        let arm = self.constants.arm;
        let rim = Displacement { thu: arm * u.thu, thv: arm * u.thv, ..*u };
        let rest = Plane {
            r: self.constants.distance * self.constants.axis[0],
            z: self.constants.distance * self.constants.axis[1],
        };
        Evaluation { speed: self.table.at_speed(speed.abs()), rows: self.table.rows(), rim, at, rest }
    }

    #[inline(always)]
    fn query<const K: usize>(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        balls: &ElementBlock<T, K>,
    ) -> TableQuery<Lanes<T, K>> {
        let all = Lanes::<T, K>::splat;
        let constants = &self.constants;
        let motion = Motion::of_block(balls, &evaluation.rim, evaluation.at, &self.surface).with_waviness();
        let a = Plane { r: motion.radial + all(constants.offset), z: motion.axial };
        let deviations = motion.deviation.inner + motion.deviation.outer;
        let rest = Plane { r: all(evaluation.rest.r), z: all(evaluation.rest.z) };
        let apart = rest.plus(a);
        let length = apart.dot(apart).sqrt::<M>();
        // One division serves direction and approach.
        let both = length + all(constants.distance);
        let inverse = all(T::ONE) / (length * both);
        let inverse_length = inverse * both;
        let approach = rest.plus(apart).dot(a) * (inverse * length) + deviations;
        let (x, root) = self.table.approach_coordinate::<K, M>(approach);
        TableQuery { line: apart.times(inverse_length), inverse_length, x, root, sense: all(T::ONE).xor_sign(approach) }
    }

    #[inline(always)]
    fn contacts_of_balls<const K: usize>(
        (line, root): (Plane<Lanes<T, K>>, Lanes<T, K>),
        fields: &[Lanes<T, K>; F],
    ) -> BallContacts<Lanes<T, K>> {
        let field = |k: usize| fields.get(k).copied().unwrap_or(Lanes::splat(T::ZERO));
        // The table holds half the load over the cube of the root.
        let load = field(0).twice_positive_part() * (root * root * root);
        let (sine, friction) = (field(1), field(2));
        let cosine = (Lanes::splat(T::ONE) - sine * sine).sqrt::<M>();
        let contact = line.times(cosine).plus(line.tangent().times(sine));
        BallContacts { load, contact, turn: Plane { r: cosine, z: sine }, friction }
    }

    #[inline(always)]
    fn contacts<const K: usize>(&self, balls: &BallContacts<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let mut force = balls.contact.times(balls.load);
        let mut tilting = force.z;
        if F > 2 {
            force = force.minus(balls.contact.tangent().times(balls.friction));
            tilting = force.z + balls.friction * Lanes::splat(self.constants.couple);
        }
        Contact { radial: force.r, axial: force.z, tilting, load: balls.load }
    }

    /// Interpolates balls; the sign bit of `inside` is set outside the table.
    #[inline(always)]
    fn lookup<const K: usize>(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        balls: &ElementBlock<T, K>,
    ) -> Lookup<Lanes<T, K>, T> {
        let query = self.query(evaluation, balls);
        let cells = self.table.cells(&evaluation.rows, query.line.z, query.x);
        let (fields, missing) = self.table.fields::<0, K>(&evaluation.speed, &evaluation.rows, &cells, 0);
        let inside = self.table.inside(query.x, query.line.z).any_sign().or_sign(missing);
        Lookup { query, contacts_of_balls: Self::contacts_of_balls((query.line, query.root), &fields), inside }
    }

    /// Adds balls one by one. The sign bit of the result is set outside the table.
    #[inline(always)]
    fn add(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        positions: impl Iterator<Item = ElementPosition<T>>,
        sum: &mut WrenchSum<T>,
    ) -> T {
        let mut inside = T::ZERO;
        for position in positions {
            let ball = ElementBlock::of(&[position]);
            let lookup = self.lookup(evaluation, &ball);
            sum.add_each(&[position], &self.contacts(&lookup.contacts_of_balls), 0);
            inside = inside.or_sign(lookup.inside);
        }
        inside
    }

    /// Returns true where balls are evaluated in blocks, stage by stage.
    #[inline(always)]
    const fn is_staged(stored: &[ElementPosition<T>]) -> bool {
        BLOCK_SIZE > 1 && stored.len() >= BLOCK_SIZE
    }

    /// Computes the reaction in the cage frame. Where balls are evaluated in stages, writes the loads of the stored positions.
    #[inline(always)]
    fn reaction_of_balls(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        let (evaluation, mut sum) = (self.evaluation(u, at), WrenchSum::new());
        let (mut inside, positions) = (evaluation.speed.inside(), self.positions.stored());
        if Self::is_staged(positions) {
            let mut begin = 0;
            while begin * BLOCK_SIZE < positions.len() {
                inside = inside.or_sign(self.add_staged(&evaluation, begin, &mut sum, loads));
                begin += MAX_STAGED / BLOCK_SIZE;
            }
        } else {
            inside = inside.or_sign(self.add(&evaluation, positions.iter().copied(), &mut sum));
        }
        if P::IS_PAIRED {
            inside =
                inside.or_sign(self.add(&evaluation, positions.iter().map(|position| position.opposite()), &mut sum));
        }
        Reaction {
            status: Status::OUT_OF_TABLE.when(inside.is_sign_negative()),
            ..sum.finish(self.constants.arm, T::ONE)
        }
    }

    /// Adds the balls of the blocks from `begin` on, up to `MAX_STAGED` together, stage by stage.
    #[inline(always)]
    fn add_staged(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        begin: usize,
        sum: &mut WrenchSum<T>,
        loads: &mut [T],
    ) -> T {
        let (mut parts, mut cells, mut contacts) = (empty_stages(), empty_stages(), empty_stages());
        let mut inside = Lanes::<T, BLOCK_SIZE>::splat(T::ZERO);
        let (mut next, table) = (begin, self.positions.stored());
        for part in &mut parts {
            let Some(balls) = self.positions.block(next) else { break };
            let Some(positions) = table.get(balls.first..).and_then(<[_]>::first_chunk) else { break };
            let TableQuery { line, x, root, .. } = self.query(evaluation, &balls);
            *part = Some(StagedBlock { line, x, root, positions, first: balls.first, overlap: balls.overlap });
            next += 1;
        }
        for (part, cells) in parts.iter().zip(&mut cells) {
            let Some(StagedBlock { line, x, .. }) = part else { break };
            *cells = Some(self.table.cells(&evaluation.rows, line.z, *x));
            inside = inside.or_sign(self.table.inside(*x, line.z));
        }
        let mut inside = inside.any_sign();
        // The test is outside the loop over the balls.
        let missing = if self.table.is_of_one_speed() {
            self.interpolate_contacts::<1>(evaluation, &parts, &cells, &mut contacts)
        } else {
            self.interpolate_contacts::<2>(evaluation, &parts, &cells, &mut contacts)
        };
        inside = inside.or_sign(missing);
        for (part, contact) in parts.iter().zip(&contacts) {
            let (Some(part), Some(contact)) = (part, contact) else { break };
            sum.add_each(part.positions, &contact.0, part.overlap);
            for (load, &found) in loads.iter_mut().skip(part.first).zip(&contact.0.load.0).skip(part.overlap) {
                *load = found;
            }
        }
        inside
    }

    /// Interpolates contacts in a table of `SPEEDS` speeds. The sign bit of the result is set where nodes are missing.
    #[inline(always)]
    fn interpolate_contacts<const SPEEDS: usize>(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        parts: &Staged<StagedBlock<'_, T>>,
        cells: &Staged<CellPositions<T, BLOCK_SIZE>>,
        contacts: &mut Staged<Aligned<Contact<Lanes<T, BLOCK_SIZE>>>>,
    ) -> T {
        let mut inside = T::ZERO;
        for ((part, cells), contact) in parts.iter().zip(cells).zip(contacts) {
            let (Some(part), Some(cells)) = (part, cells) else { break };
            let (fields, missing) =
                self.table.fields::<SPEEDS, BLOCK_SIZE>(&evaluation.speed, &evaluation.rows, cells, part.overlap);
            *contact = Some(Aligned(self.contacts(&Self::contacts_of_balls((part.line, part.root), &fields))));
            inside = inside.or_sign(missing);
        }
        inside
    }

    /// Returns the derivatives of the contact forces by the radial and axial displacement of the groove centres.
    #[inline(always)]
    fn tangents<const K: usize>(
        &self,
        evaluation: &Evaluation<'_, T, F>,
        lookup: &Lookup<Lanes<T, K>, T>,
    ) -> [ContactTangent<T>; K] {
        let all = Lanes::<T, K>::splat;
        let Lookup { query, contacts_of_balls, .. } = lookup;
        let [by_sine, by_approach] = self.table.slopes(&evaluation.speed, &evaluation.rows, query.line.z, query.x);
        // At the coordinate 0 the other factor is 0 too.
        let per_approach = self.table.coordinate_slope(query.x, query.root);
        let per_across = query.line.r * query.inverse_length;
        let across = query.line.tangent();
        let zero = all(T::ZERO);
        let nothing = Plane { r: zero, z: zero };
        // Displacement along the line changes the approach, across it the sine of the angle by cos/l.
        let slope = |k: usize| match (by_approach.get(k), by_sine.get(k)) {
            (Some(&along), Some(&sine)) => query.line.times(along * per_approach).plus(across.times(sine * per_across)),
            _ => nothing,
        };
        let gap = contacts_of_balls.load.less_than(Lanes::splat_f64(f64::MIN_POSITIVE));
        // Q = f r^3 with r = sqrt(|s| + a): dQ = r^3 df + (3/2) (Q/r^2) sign(s) ds.
        let (root, two) = (query.root, Lanes::splat_f64(2.0));
        let by_root = Lanes::splat_f64(1.5) * contacts_of_balls.load * query.sense / (root * root);
        let load = slope(0).times(two * root * root * root).plus(query.line.times(by_root));
        let load = Plane::select(gap, nothing, load);
        // The contact rotates with the line and by d(asin w) = dw/sqrt(1 - w^2).
        let turning = across.times(query.inverse_length).plus(slope(1).times(all(T::ONE) / contacts_of_balls.turn.r));
        let (e, t) = (contacts_of_balls.contact, contacts_of_balls.contact.tangent());
        // p = Q e - tau t: dp = e dQ + (Q t + tau e) da - t dtau
        let mut force = Matrix::outer(e, load).plus(Matrix::outer(t.times(contacts_of_balls.load), turning));
        let mut couple = nothing;
        if F > 2 {
            let friction = slope(2);
            force = force
                .plus(Matrix::outer(e.times(contacts_of_balls.friction), turning))
                .minus(Matrix::outer(t, friction));
            couple = friction.times(all(self.constants.couple));
        }
        contact_tangents(force, couple)
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    CageFrame<T> for Tabulated<T, M, P, A, F, S>
{
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<T> {
        M::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.reaction_of_balls(u, at, &mut [])
    }

    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        if P::IS_PAIRED || !Self::is_staged(self.positions.stored()) {
            self.element_loads_in_cage_frame(u, at, loads);
            return self.reaction_in_cage_frame(u, at);
        }
        self.reaction_of_balls(u, at, loads)
    }

    #[inline]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let evaluation = self.evaluation(u, at);
        let (mut sum, mut tangent, mut inside) = (WrenchSum::new(), TangentSum::new(), evaluation.speed.inside());
        for group in padded_groups::<T, P, BLOCK_SIZE>(&self.positions) {
            let lookup = self.lookup(&evaluation, &ElementBlock::of(&group.positions));
            inside = inside.or_sign(lookup.inside);
            sum.add_each(group.without_padding(), &self.contacts(&lookup.contacts_of_balls), 0);
            for (position, k) in group.without_padding().iter().zip(&self.tangents(&evaluation, &lookup)) {
                tangent.add(position, k);
            }
        }
        let status = Status::OUT_OF_TABLE.when(inside.is_sign_negative());
        let reaction = Reaction { status, ..sum.finish(self.constants.arm, T::ONE) };
        (reaction, tangent.finish(self.constants.arm, turn))
    }

    #[inline(always)]
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        let evaluation = self.evaluation(u, at);
        let mut loads = loads.iter_mut();
        for group in padded_groups::<T, P, BLOCK_SIZE>(&self.positions) {
            let balls = self.lookup(&evaluation, &ElementBlock::of(&group.positions)).contacts_of_balls;
            for (_, (contacts_of_balls, load)) in
                group.without_padding().iter().zip(balls.load.0.into_iter().zip(&mut loads))
            {
                *load = contacts_of_balls;
            }
        }
    }
}

bearing_in_cage!(
    Tabulated<T, M, P, A, F, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize
);
