//! Rung `tabulated`: the quasi-static physics at a small fixed cost.
//!
//! What one ball does depends on where its groove centres are (two numbers), on speed and on the film. All of it is
//! sampled once ([`fill()`], or constants made ready elsewhere) and interpolated in fixed time. Waviness moves the groove
//! centres, what damage and waviness add to a contact shortens the approach.

pub mod fill;
mod table;

pub use fill::{Domain, fill};
pub use table::{Axis, Grid, Node, Table};

use self::table::{AtSpeed, CellPositions, Rows};
use super::element_position::{BLOCK, ElementBlock, ElementLayout, ElementPosition, groups};
use super::elements::CageFrame;
use super::quasi_static::{Matrix, TableConstants, contact_tangents};
use super::ring::{CageRotation, Contact, ContactTangent, Motion, TangentSum, WrenchSum};
use super::surface::{Smooth, Surface};
use super::{Reaction, bearing_in_cage};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::lanes::{Lanes, Plane};
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;
use crate::status::Status;
use core::marker::PhantomData;

/// A ball bearing whose balls are looked up. Cost a ball: three square roots, one division, 9 nodes of two or three numbers (18
/// where the table is of several speeds).
///
/// Outside of what the table was made for the nearest answer is given, and [`Status::OUT_OF_TABLE`] with it.
#[derive(Debug, Clone, Copy)]
pub struct Tabulated<T, M, P, A, const F: usize, S = Smooth> {
    places: P,
    seat: TableConstants<T>,
    table: Table<T, A, F>,
    /// Of the outer ring over the inner, or the other way where the inner ring stands.
    by_outer: bool,
    surface: S,
    math: PhantomData<M>,
}

/// Most balls that go through a stage together: each ball is a long chain of dependent operations, and a desktop processor
/// works at several only where they are near in the code.
const STAGED: usize = 4 * BLOCK;

/// What is the same for all balls of one evaluation.
struct Call<'a, T, const F: usize> {
    speed: AtSpeed<T>,
    rows: Rows<'a, T, F>,
    /// The displacement with its tilt as axial displacement at the radius of the lever arm.
    rim: Displacement<T>,
    at: &'a BearingKinematicState<T>,
    /// From the outer to the inner groove centres where the rings just touch the balls, m.
    rest: Plane<T>,
}

/// Where balls are, as the table asks for it.
#[derive(Clone, Copy)]
struct Aim<L> {
    /// Along the line of groove centres, and its inverse length.
    line: Plane<L>,
    inverse_length: L,
    /// Signed square root of the approach.
    root: L,
}

/// What the table says of balls.
#[derive(Clone, Copy)]
struct Found<L> {
    /// 0 in a gap, N.
    load: L,
    /// Along the contact; cosine and sine of the turn from the line to it.
    contact: Plane<L>,
    turn: Plane<L>,
    friction: L,
}

/// Balls looked up side by side.
struct Look<L, T> {
    aim: Aim<L>,
    found: Found<L>,
    /// The sign bit is set outside of the table.
    inside: T,
}

/// `BLOCK` of the balls that are staged together; what wide registers write comes first, within cache lines.
#[repr(C)]
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
struct BearingComponent<'a, T> {
    line: Plane<Lanes<T, BLOCK>>,
    root: Lanes<T, BLOCK>,
    places: &'a [ElementPosition<T>; BLOCK],
    /// How many of them were in the part before.
    known: usize,
}

/// What a stage has to say of each part.
type Staged<X> = [Option<X>; STAGED / BLOCK];

/// Written within cache lines, as [`CellPositions`].
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
struct Aligned<X>(X);

/// Nothing yet. One by one, so that nothing but the marks is written.
#[inline(always)]
const fn unset<X>() -> Staged<X> {
    [None, None, None, None]
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, const F: usize>
    Tabulated<T, M, P, A, F>
{
    /// From numbers made ready: no arithmetic. `by_outer` where the table's speed is the outer ring's.
    pub const fn new(places: P, seat: TableConstants<T>, table: Table<T, A, F>, by_outer: bool) -> Self {
        Self { places, seat, table, by_outer, surface: Smooth, math: PhantomData }
    }

    /// The same bearing with waviness or damage.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Tabulated<T, M, P, A, F, S> {
        let Self { places, seat, table, by_outer, math, .. } = self;
        Tabulated { places, seat, table, by_outer, surface, math }
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    Tabulated<T, M, P, A, F, S>
{
    /// The table, for those who write it out.
    pub fn table(&self) -> &Table<T, A, F> {
        &self.table
    }

    /// What the bearing needs besides.
    pub fn seat(&self) -> &TableConstants<T> {
        &self.seat
    }

    #[inline(always)]
    fn call<'a>(&'a self, u: &Displacement<T>, at: &'a BearingKinematicState<T>) -> Call<'a, T, F> {
        let speed = if self.by_outer { at.outer_speed } else { at.inner_speed };
        let arm = self.seat.arm;
        let rim = Displacement { thu: arm * u.thu, thv: arm * u.thv, ..*u };
        let rest = Plane { r: self.seat.distance * self.seat.axis[0], z: self.seat.distance * self.seat.axis[1] };
        Call { speed: self.table.at_speed(speed.abs()), rows: self.table.rows(), rim, at, rest }
    }

    #[inline(always)]
    fn aim<const K: usize>(&self, call: &Call<'_, T, F>, balls: &ElementBlock<T, K>) -> Aim<Lanes<T, K>> {
        let all = Lanes::<T, K>::all;
        let seat = &self.seat;
        let motion = Motion::of_each(balls, &call.rim, call.at, &self.surface);
        let a = Plane { r: motion.radial + all(seat.offset), z: motion.axial };
        let bulges = motion.shape.inner + motion.shape.outer;
        let rest = Plane { r: all(call.rest.r), z: all(call.rest.z) };
        let apart = rest.plus(a);
        let length = apart.dot(apart).sqrt::<M>();
        // One division for both the direction and the approach.
        let both = length + all(seat.distance);
        let inverse = all(T::ONE) / (length * both);
        let inverse_length = inverse * both;
        let approach = rest.plus(apart).dot(a) * (inverse * length) + bulges;
        Aim { line: apart.times(inverse_length), inverse_length, root: approach.abs().sqrt::<M>().negated_by(approach) }
    }

    #[inline(always)]
    fn found<const K: usize>(line: Plane<Lanes<T, K>>, fields: &[Lanes<T, K>; F]) -> Found<Lanes<T, K>> {
        let field = |k: usize| fields.get(k).copied().unwrap_or(Lanes::all(T::ZERO));
        // The table holds half the load.
        let (load, sine, friction) = (field(0).twice_positive(), field(1), field(2));
        let cosine = (Lanes::all(T::ONE) - sine * sine).sqrt::<M>();
        let contact = line.times(cosine).plus(line.tangent().times(sine));
        Found { load, contact, turn: Plane { r: cosine, z: sine }, friction }
    }

    #[inline(always)]
    fn contacts<const K: usize>(&self, balls: &Found<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let mut force = balls.contact.times(balls.load);
        let mut tilting = force.z;
        if F > 2 {
            force = force.minus(balls.contact.tangent().times(balls.friction));
            tilting = force.z + balls.friction * Lanes::all(self.seat.couple);
        }
        Contact { radial: force.r, axial: force.z, tilting, load: balls.load }
    }

    /// Balls looked up, and what tells by its sign bits whether they are inside the table.
    #[inline(always)]
    fn look<const K: usize>(&self, call: &Call<'_, T, F>, balls: &ElementBlock<T, K>) -> Look<Lanes<T, K>, T> {
        let aim = self.aim(call, balls);
        let spots = self.table.spots(&call.rows, aim.line.z, aim.root);
        let (fields, missing) = self.table.fields::<0, K>(&call.speed, &call.rows, &spots, 0);
        let inside = self.table.inside(aim.root, aim.line.z).any_sign().either_sign(missing);
        Look { aim, found: Self::found(aim.line, &fields), inside }
    }

    /// Adds one ball after the other. Gives what tells by its sign bit whether they are inside the table.
    #[inline(always)]
    fn add(
        &self,
        call: &Call<'_, T, F>,
        places: impl Iterator<Item = ElementPosition<T>>,
        sum: &mut WrenchSum<T>,
    ) -> T {
        let mut inside = T::ZERO;
        for place in places {
            let ball = ElementBlock::of(&[place]);
            let look = self.look(call, &ball);
            sum.add_each(&[place], &self.contacts(&look.found), 0);
            inside = inside.either_sign(look.inside);
        }
        inside
    }

    /// Adds the balls from the `begin`-th `BLOCK` on, up to `STAGED` of them together, stage by stage.
    #[inline(always)]
    fn add_staged(&self, call: &Call<'_, T, F>, begin: usize, sum: &mut WrenchSum<T>) -> T {
        let (mut parts, mut spots, mut contacts) = (unset(), unset(), unset());
        let mut inside = Lanes::<T, BLOCK>::all(T::ZERO);
        let (mut next, table) = (begin, self.places.table());
        for part in &mut parts {
            let Some(balls) = self.places.abreast(next) else { break };
            let Some(places) = table.get(balls.from..).and_then(<[_]>::first_chunk) else { break };
            let Aim { line, root, .. } = self.aim(call, &balls);
            *part = Some(BearingComponent { line, root, places, known: balls.known });
            next += 1;
        }
        for (part, spots) in parts.iter().zip(&mut spots) {
            let Some(BearingComponent { line, root, .. }) = part else { break };
            *spots = Some(self.table.spots(&call.rows, line.z, *root));
            inside = inside.either_sign(self.table.inside(*root, line.z));
        }
        let mut inside = inside.any_sign();
        // Asked once: what is in the loop is asked for every ball.
        let missing = if self.table.is_of_one_speed() {
            self.touch::<1>(call, &parts, &spots, &mut contacts)
        } else {
            self.touch::<2>(call, &parts, &spots, &mut contacts)
        };
        inside = inside.either_sign(missing);
        for (part, contact) in parts.iter().zip(&contacts) {
            let (Some(part), Some(contact)) = (part, contact) else { break };
            sum.add_each(part.places, &contact.0, part.known);
        }
        inside
    }

    /// The contacts of balls at their spots in a table of one speed, or mixed from two. Gives what tells by its sign bit whether
    /// nodes are missing.
    #[inline(always)]
    fn touch<const SPEEDS: usize>(
        &self,
        call: &Call<'_, T, F>,
        parts: &Staged<BearingComponent<'_, T>>,
        spots: &Staged<CellPositions<T, BLOCK>>,
        contacts: &mut Staged<Aligned<Contact<Lanes<T, BLOCK>>>>,
    ) -> T {
        let mut inside = T::ZERO;
        for ((part, spots), contact) in parts.iter().zip(spots).zip(contacts) {
            let (Some(part), Some(spots)) = (part, spots) else { break };
            let (fields, missing) = self.table.fields::<SPEEDS, BLOCK>(&call.speed, &call.rows, spots, part.known);
            *contact = Some(Aligned(self.contacts(&Self::found(part.line, &fields))));
            inside = inside.either_sign(missing);
        }
        inside
    }

    /// Slopes of the contacts' forces along the radial and axial displacement of the groove centres.
    #[inline(always)]
    fn tangents<const K: usize>(&self, call: &Call<'_, T, F>, look: &Look<Lanes<T, K>, T>) -> [ContactTangent<T>; K] {
        let all = Lanes::<T, K>::all;
        let Look { aim, found, .. } = look;
        let [by_sine, by_root] = self.table.slopes(&call.speed, &call.rows, aim.line.z, aim.root);
        // d(root)/d(approach) = 1/(2 |root|); where the root is 0 so is what it multiplies.
        let per_approach = all(T::HALF) / (aim.root.abs() + Lanes::constant(1e-9));
        let per_across = aim.line.r * aim.inverse_length;
        let across = aim.line.tangent();
        let zero = all(T::ZERO);
        let nothing = Plane { r: zero, z: zero };
        // Displacement along the line is approach, across it the angle's sine grows by cos/l.
        let slope = |k: usize| match (by_root.get(k), by_sine.get(k)) {
            (Some(&root), Some(&sine)) => aim.line.times(root * per_approach).plus(across.times(sine * per_across)),
            _ => nothing,
        };
        let gap = found.load.below(Lanes::constant(f64::MIN_POSITIVE));
        let load = Plane::choose(gap, nothing, slope(0).times(Lanes::constant(2.0)));
        // The contact turns with the line and by d(asin w) = dw/sqrt(1 - w^2).
        let turning = across.times(aim.inverse_length).plus(slope(1).times(all(T::ONE) / found.turn.r));
        let (e, t) = (found.contact, found.contact.tangent());
        // p = Q e - tau t: dp = e dQ + (Q t + tau e) da - t dtau
        let mut force = Matrix::outer(e, load).plus(Matrix::outer(t.times(found.load), turning));
        let mut couple = nothing;
        if F > 2 {
            let friction = slope(2);
            force = force.plus(Matrix::outer(e.times(found.friction), turning)).minus(Matrix::outer(t, friction));
            couple = friction.times(all(self.seat.couple));
        }
        contact_tangents(force, couple)
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    CageFrame<T> for Tabulated<T, M, P, A, F, S>
{
    #[inline(always)]
    fn turn(cage: Phase) -> CageRotation<T> {
        M::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let (call, mut sum) = (self.call(u, at), WrenchSum::new());
        let (mut inside, places) = (call.speed.inside(), self.places.table());
        if BLOCK > 1 && places.len() >= BLOCK {
            let mut begin = 0;
            while begin * BLOCK < places.len() {
                inside = inside.either_sign(self.add_staged(&call, begin, &mut sum));
                begin += STAGED / BLOCK;
            }
        } else {
            inside = inside.either_sign(self.add(&call, places.iter().copied(), &mut sum));
        }
        if P::PAIRS {
            inside = inside.either_sign(self.add(&call, places.iter().map(|place| place.opposite()), &mut sum));
        }
        Reaction { status: Status::OUT_OF_TABLE.when(inside.has_sign()), ..sum.finish(self.seat.arm, T::ONE) }
    }

    #[inline]
    fn reaction_in_cage_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let call = self.call(u, at);
        let (mut sum, mut tangent, mut inside) = (WrenchSum::new(), TangentSum::new(), call.speed.inside());
        for group in groups::<T, BLOCK>(&self.places) {
            let look = self.look(&call, &ElementBlock::of(&group.places));
            inside = inside.either_sign(look.inside);
            sum.add_each(group.real(), &self.contacts(&look.found), 0);
            for (place, k) in group.real().iter().zip(&self.tangents(&call, &look)) {
                tangent.add(place, k);
            }
        }
        let status = Status::OUT_OF_TABLE.when(inside.has_sign());
        let reaction = Reaction { status, ..sum.finish(self.seat.arm, T::ONE) };
        (reaction, tangent.finish(self.seat.arm, turn))
    }

    #[inline]
    fn element_loads_in_cage(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        let call = self.call(u, at);
        let mut loads = loads.iter_mut();
        for group in groups::<T, BLOCK>(&self.places) {
            let balls = self.look(&call, &ElementBlock::of(&group.places)).found;
            for (_, (found, load)) in group.real().iter().zip(balls.load.0.into_iter().zip(&mut loads)) {
                *load = found;
            }
        }
    }
}

bearing_in_cage!(
    Tabulated<T, M, P, A, F, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize
);
