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

/// A ball bearing with interpolated ball forces. Cost per ball: four square roots, two divisions, 9 nodes of two or three
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
    /// 1/(2 A), 1/m.
    half_inverse_distance: T,
}

/// Coordinates of balls in the table.
#[derive(Clone, Copy)]
struct TableQuery<L> {
    /// Direction of the line of groove centres, its length and inverse length.
    line: Plane<L>,
    length: L,
    inverse_length: L,
    /// Coordinate of the approach.
    x: L,
    /// `sqrt(|e| + a)` of the approach.
    root: L,
    /// 1 with the sign of the approach.
    sense: L,
}

/// Interpolated contacts of balls.
#[derive(Clone, Copy)]
struct BallContacts<L> {
    /// Direction of the line of groove centres.
    line: Plane<L>,
    /// Component of the load along that line, N; 0 in a gap.
    along: L,
    /// Tangent of the angle from the line to the contact.
    tangent: L,
    /// Component of the friction across that line, N.
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

/// Returns `1/cos` of an angle from its tangent.
#[inline(always)]
fn secant<T: Scalar, M: Math<T>, const K: usize>(tangent: Lanes<T, K>) -> Lanes<T, K> {
    (Lanes::splat(T::ONE) + tangent * tangent).sqrt::<M>()
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

    /// Returns the positions of the balls.
    pub(crate) fn positions(&self) -> &P {
        &self.positions
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
        Evaluation {
            speed: self.table.at_speed(speed.abs()),
            rows: self.table.rows(),
            rim,
            at,
            rest,
            half_inverse_distance: T::HALF / self.constants.distance,
        }
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
        let rest = Plane { r: all(evaluation.rest.r), z: all(evaluation.rest.z) };
        let apart = rest.plus(a);
        let length = apart.dot(apart).sqrt::<M>();
        let inverse_length = all(T::ONE) / length;
        // l^2 - A^2 = (l - A) (l + A)
        let per_square = all(evaluation.half_inverse_distance);
        let mut approach = rest.plus(apart).dot(a) * per_square;
        if !S::IS_SMOOTH {
            let deviations = motion.deviation.inner + motion.deviation.outer;
            approach = approach + deviations * (length + length + deviations) * per_square;
        }
        let (x, root) = self.table.approach_coordinate::<K, M>(approach);
        TableQuery {
            line: apart.times(inverse_length),
            length,
            inverse_length,
            x,
            root,
            sense: all(T::ONE).xor_sign(approach),
        }
    }

    #[inline(always)]
    fn contacts_of_balls<const K: usize>(
        (line, root): (Plane<Lanes<T, K>>, Lanes<T, K>),
        fields: &[Lanes<T, K>; F],
    ) -> BallContacts<Lanes<T, K>> {
        let field = |k: usize| fields.get(k).copied().unwrap_or(Lanes::splat(T::ZERO));
        // The table holds half of the load along the line over the cube of the root.
        let along = field(0).twice_positive_part() * (root * root * root);
        BallContacts { line, along, tangent: field(1), friction: field(2) }
    }

    #[inline(always)]
    fn contacts<const K: usize>(&self, balls: &BallContacts<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let BallContacts { line, along, tangent, friction } = *balls;
        let secant = secant::<T, M, K>(tangent);
        let mut force = Plane { r: along, z: along * tangent };
        let mut couple = Lanes::splat(T::NEGATIVE_ZERO);
        if F > 2 {
            force = Plane { r: force.r + friction * tangent, z: force.z - friction };
            couple = friction * secant * Lanes::splat(self.constants.couple);
        }
        let force = line.times(force.r).plus(line.tangent().times(force.z));
        Contact { radial: force.r, axial: force.z, tilting: force.z + couple, load: along * secant }
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
        for (part, contacts) in parts.iter().zip(&contacts) {
            let (Some(part), Some(Aligned(contacts))) = (part, contacts) else { break };
            sum.add_each(part.positions, contacts, part.overlap);
            for (load, &found) in loads.iter_mut().skip(part.first).zip(&contacts.load.0).skip(part.overlap) {
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
        for ((part, cells), contacts) in parts.iter().zip(cells).zip(contacts) {
            let (Some(part), Some(cells)) = (part, cells) else { break };
            let (fields, missing) =
                self.table.fields::<SPEEDS, BLOCK_SIZE>(&evaluation.speed, &evaluation.rows, cells, part.overlap);
            *contacts = Some(Aligned(self.contacts(&Self::contacts_of_balls((part.line, part.root), &fields))));
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
        let Lookup { query, contacts_of_balls: BallContacts { line, along, tangent, friction }, .. } = *lookup;
        let [by_sine, by_approach] = self.table.slopes(&evaluation.speed, &evaluation.rows, line.z, query.x);
        // Displacement along the line changes e by l/A, across it the sine of the angle by cos/l.
        let e_slope = query.length * all(evaluation.half_inverse_distance + evaluation.half_inverse_distance);
        // At the coordinate 0 the other factor is 0 too.
        let per_approach = self.table.coordinate_slope(query.x, query.root) * e_slope;
        let per_across = line.r * query.inverse_length;
        let across = line.tangent();
        let zero = all(T::ZERO);
        let nothing = Plane { r: zero, z: zero };
        let slope = |k: usize| match (by_approach.get(k), by_sine.get(k)) {
            (Some(&by_approach), Some(&by_sine)) => {
                line.times(by_approach * per_approach).plus(across.times(by_sine * per_across))
            }
            _ => nothing,
        };
        let gap = along.less_than(Lanes::splat_f64(f64::MIN_POSITIVE));
        // P = f r^3 with r = sqrt(|e| + a): dP = r^3 df + (3/2) (P/r^2) sign(e) de.
        let (root, two) = (query.root, Lanes::splat_f64(2.0));
        let by_root = Lanes::splat_f64(1.5) * along * query.sense / (root * root) * e_slope;
        let load = slope(0).times(two * root * root * root).plus(line.times(by_root));
        let load = Plane::select(gap, nothing, load);
        // The line n turns by da = (t dx)/l, with t its tangent: p = P (n + tan t), dp = dP (n + tan t) + P dtan t + P (t - tan n) da.
        let turning = across.times(query.inverse_length);
        let mut force = Matrix::outer(line.plus(across.times(tangent)), load)
            .plus(Matrix::outer(across.times(along), slope(1)))
            .plus(Matrix::outer(across.minus(line.times(tangent)).times(along), turning));
        let mut couple = nothing;
        if F > 2 {
            // p = ... + T (tan n - t)
            force = force
                .plus(Matrix::outer(line.times(tangent).minus(across), slope(2)))
                .plus(Matrix::outer(line.times(friction), slope(1)))
                .plus(Matrix::outer(line.plus(across.times(tangent)).times(friction), turning));
            // T sqrt(1 + tan^2)
            let secant = secant::<T, M, K>(tangent);
            couple = slope(2).times(secant).plus(slope(1).times(friction * tangent / secant));
            couple = couple.times(all(self.constants.couple));
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
            let lookup = self.lookup(&evaluation, &ElementBlock::of(&group.positions));
            let BallContacts { along, tangent, .. } = lookup.contacts_of_balls;
            let found = along * secant::<T, M, BLOCK_SIZE>(tangent);
            for (_, (found, load)) in group.without_padding().iter().zip(found.0.into_iter().zip(&mut loads)) {
                *load = found;
            }
        }
    }
}

bearing_in_cage!(
    Tabulated<T, M, P, A, F, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize
);
