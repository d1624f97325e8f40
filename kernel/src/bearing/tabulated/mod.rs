//! Rung `tabulated`: the quasi-static physics at a small fixed cost.
//!
//! What one ball does depends on where its groove centres are (two numbers), on speed and on the film. All of it is
//! sampled once ([`fill()`], or constants made ready elsewhere) and interpolated in fixed time. Waviness moves the groove
//! centres, what damage and waviness add to a contact shortens the approach.

pub mod fill;
mod table;

pub use fill::{Domain, fill};
pub use table::{Axis, Grid, Node, Table};

use self::table::AtSpeed;
use super::elements::InCage;
use super::place::{ABREAST, Arrangement, Place, groups};
use super::quasi_static::{Matrix, TableSeat, contact_tangents, contacts};
use super::ring::{CageTurn, Contact, ContactTangent, Motion, TangentSum, WrenchSum};
use super::surface::{Smooth, Surface};
use super::{Reaction, bearing_in_cage};
use crate::frame::{Displacement, Stiffness};
use crate::lanes::{Lanes, Plane};
use crate::math::Math;
use crate::rotation::Rotation;
use crate::scalar::Scalar;
use crate::status::Status;
use crate::turn::Turn;
use core::marker::PhantomData;

/// A ball bearing whose balls are looked up. Cost a ball: three square roots, one division, 18 nodes of two or three numbers.
///
/// Outside of what the table was made for the nearest answer is given, and [`Status::OUT_OF_TABLE`] with it.
#[derive(Debug, Clone, Copy)]
pub struct Tabulated<T, M, P, A, const F: usize, S = Smooth> {
    places: P,
    seat: TableSeat<T>,
    table: Table<T, A, F>,
    /// Of the outer ring over the inner, or the other way where the inner ring stands.
    by_outer: bool,
    surface: S,
    math: PhantomData<M>,
}

/// Groups of balls that go through a stage together: each ball is a long chain of dependent operations, and a desktop
/// processor works at several only where they are near in the code.
const STAGED: usize = if cfg!(target_pointer_width = "64") { 2 } else { 1 };

/// Where balls are, as the table asks for it.
#[derive(Clone, Copy)]
struct Aim<L> {
    /// Along the line of groove centres, and its inverse length.
    line: Plane<L>,
    inverse_length: L,
    /// Signed square root of the approach.
    root: L,
}

/// Balls looked up side by side.
#[derive(Clone, Copy)]
struct Looked<L> {
    /// Along the line of groove centres, and its inverse length.
    line: Plane<L>,
    inverse_length: L,
    root: L,
    /// 0 in a gap, N.
    load: L,
    /// Along the contact; sine and cosine of the turn from the line to it.
    contact: Plane<L>,
    turn: Plane<L>,
    friction: L,
}

impl<T: Scalar, M: Math<T>, P: Arrangement<T>, A: AsRef<[Node<T, F>]> + Send + Sync, const F: usize>
    Tabulated<T, M, P, A, F>
{
    /// From numbers made ready: no arithmetic. `by_outer` where the table's speed is the outer ring's.
    pub const fn new(places: P, seat: TableSeat<T>, table: Table<T, A, F>, by_outer: bool) -> Self {
        Self { places, seat, table, by_outer, surface: Smooth, math: PhantomData }
    }

    /// The same bearing with waviness or damage.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Tabulated<T, M, P, A, F, S> {
        let Self { places, seat, table, by_outer, math, .. } = self;
        Tabulated { places, seat, table, by_outer, surface, math }
    }
}

impl<T: Scalar, M: Math<T>, P: Arrangement<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    Tabulated<T, M, P, A, F, S>
{
    /// The table, for those who write it out.
    pub fn table(&self) -> &Table<T, A, F> {
        &self.table
    }

    /// What the bearing needs besides.
    pub fn seat(&self) -> &TableSeat<T> {
        &self.seat
    }

    #[inline(always)]
    fn at_speed(&self, at: &Rotation<T>) -> AtSpeed<T> {
        let speed = if self.by_outer { at.outer_speed } else { at.inner_speed };
        self.table.at_speed(speed.abs())
    }

    #[inline(always)]
    fn rim(&self, u: &Displacement<T>) -> Displacement<T> {
        let arm = self.seat.arm;
        Displacement { thu: arm * u.thu, thv: arm * u.thv, ..*u }
    }

    #[inline(always)]
    fn aim<const K: usize>(&self, places: &[Place<T>; K], rim: &Displacement<T>, at: &Rotation<T>) -> Aim<Lanes<T, K>> {
        let all = Lanes::<T, K>::all;
        let seat = &self.seat;
        let motions = places.each_ref().map(|place| Motion::of(place, rim, at, &self.surface).with_waviness());
        let a = Plane { r: Lanes::of(&motions, |m| m.radial + seat.offset), z: Lanes::of(&motions, |m| m.axial) };
        let bulges = Lanes::of(&motions, |m| m.shape.inner + m.shape.outer);
        let [c0, s0] = seat.axis;
        let rest = Plane { r: all(seat.distance * c0), z: all(seat.distance * s0) };
        let apart = rest.plus(a);
        let length = apart.dot(apart).sqrt::<M>();
        // One division for both the direction and the approach.
        let both = length + all(seat.distance);
        let inverse = all(T::ONE) / (length * both);
        let inverse_length = inverse * both;
        let approach = rest.plus(apart).dot(a) * (inverse * length) + bulges;
        Aim { line: apart.times(inverse_length), inverse_length, root: approach.abs().sqrt::<M>().negated_by(approach) }
    }

    /// What the table says of them.
    #[inline(always)]
    fn found<const K: usize>(&self, aim: &Aim<Lanes<T, K>>, fields: &[Lanes<T, K>; F]) -> Looked<Lanes<T, K>> {
        let Aim { line, inverse_length, root } = *aim;
        let field = |k: usize| fields.get(k).copied().unwrap_or(Lanes::all(T::ZERO));
        // The table holds half the load.
        let (load, sine, friction) = (field(0).twice_positive(), field(1), field(2));
        let cosine = (Lanes::all(T::ONE) - sine * sine).sqrt::<M>();
        let contact = line.times(cosine).plus(line.tangent().times(sine));
        Looked { line, inverse_length, root, load, contact, turn: Plane { r: cosine, z: sine }, friction }
    }

    /// Balls looked up, and what tells by its sign bits whether they are inside the table.
    #[inline(always)]
    fn look<const K: usize>(
        &self,
        speed: &AtSpeed<T>,
        places: &[Place<T>; K],
        rim: &Displacement<T>,
        at: &Rotation<T>,
    ) -> (Looked<Lanes<T, K>>, T) {
        let aim = self.aim(places, rim, at);
        let values = self.table.values(speed, aim.root, aim.line.z);
        (self.found(&aim, &values.fields), values.inside.any_sign())
    }

    /// Adds balls: where they are, what the table says, the sum. Gives what tells whether they are inside the table.
    #[inline(always)]
    fn add(
        &self,
        speed: &AtSpeed<T>,
        groups: &[[Place<T>; ABREAST]],
        (rim, at): (&Displacement<T>, &Rotation<T>),
        sum: &mut WrenchSum<T>,
    ) -> T {
        let nothing = Lanes::all(T::ZERO);
        let mut aims = [Aim { line: Plane { r: nothing, z: nothing }, inverse_length: nothing, root: nothing }; STAGED];
        let mut found = [[nothing; F]; STAGED];
        let mut inside = nothing;
        for groups in groups.chunks(STAGED) {
            for (aim, places) in aims.iter_mut().zip(groups) {
                *aim = self.aim(places, rim, at);
            }
            for ((fields, aim), _) in found.iter_mut().zip(&aims).zip(groups) {
                let values = self.table.values(speed, aim.root, aim.line.z);
                (*fields, inside) = (values.fields, inside.either_sign(values.inside));
            }
            for ((places, aim), fields) in groups.iter().zip(&aims).zip(&found) {
                self.add_looked(places, &self.found(aim, fields), sum);
            }
        }
        inside.any_sign()
    }

    #[inline(always)]
    fn add_looked<const K: usize>(&self, places: &[Place<T>], balls: &Looked<Lanes<T, K>>, sum: &mut WrenchSum<T>) {
        for (place, contact) in places.iter().zip(&self.contacts(balls)) {
            sum.add(place, contact);
        }
    }

    #[inline(always)]
    fn contacts<const K: usize>(&self, balls: &Looked<Lanes<T, K>>) -> [Contact<T>; K] {
        let mut force = balls.contact.times(balls.load);
        let mut tilting = force.z;
        if F > 2 {
            force = force.minus(balls.contact.tangent().times(balls.friction));
            tilting = force.z + balls.friction * Lanes::all(self.seat.couple);
        }
        contacts(force, tilting, balls.load)
    }

    /// Slopes of the contacts' forces along the radial and axial displacement of the groove centres.
    #[inline(always)]
    fn tangents<const K: usize>(&self, speed: &AtSpeed<T>, balls: &Looked<Lanes<T, K>>) -> [ContactTangent<T>; K] {
        let all = Lanes::<T, K>::all;
        let [by_root, by_sine] = self.table.slopes(speed, balls.root, balls.line.z);
        // d(root)/d(approach) = 1/(2 |root|); where the root is 0 so is what it multiplies.
        let per_approach = all(T::HALF) / (balls.root.abs() + Lanes::constant(1e-9));
        let per_across = balls.line.r * balls.inverse_length;
        let across = balls.line.tangent();
        let zero = all(T::ZERO);
        let nothing = Plane { r: zero, z: zero };
        // Displacement along the line is approach, across it the angle's sine grows by cos/l.
        let slope = |k: usize| match (by_root.get(k), by_sine.get(k)) {
            (Some(&root), Some(&sine)) => balls.line.times(root * per_approach).plus(across.times(sine * per_across)),
            _ => nothing,
        };
        let gap = balls.load.below(Lanes::constant(f64::MIN_POSITIVE));
        let load = Plane::choose(gap, nothing, slope(0).times(Lanes::constant(2.0)));
        // The contact turns with the line and by d(asin w) = dw/sqrt(1 - w^2).
        let turning = across.times(balls.inverse_length).plus(slope(1).times(all(T::ONE) / balls.turn.r));
        let (e, t) = (balls.contact, balls.contact.tangent());
        // p = Q e - tau t: dp = e dQ + (Q t + tau e) da - t dtau
        let mut force = Matrix::outer(e, load).plus(Matrix::outer(t.times(balls.load), turning));
        let mut couple = nothing;
        if F > 2 {
            let friction = slope(2);
            force = force.plus(Matrix::outer(e.times(balls.friction), turning)).minus(Matrix::outer(t, friction));
            couple = friction.times(all(self.seat.couple));
        }
        contact_tangents(force, couple)
    }
}

impl<T: Scalar, M: Math<T>, P: Arrangement<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize>
    InCage<T> for Tabulated<T, M, P, A, F, S>
{
    #[inline(always)]
    fn turn(cage: Turn) -> CageTurn<T> {
        M::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        let (speed, rim) = (self.at_speed(at), self.rim(u));
        let mut sum = WrenchSum::new();
        let (full, rest) = self.places.table().as_chunks::<ABREAST>();
        // What fills no group is looked up before the others, while a desktop processor still waits for nothing else, and
        // added after them; a ball alone costs less by itself than in a group of its likes.
        let alone = if let [place] = rest { Some((place, self.look(&speed, &[*place], &rim, at))) } else { None };
        let few = if rest.len() > 1 { groups::<T, ABREAST>(&rest).next() } else { None };
        let few = few.map(|group| (self.look(&speed, &group.places, &rim, at), group));
        let mut inside = speed.inside().either_sign(self.add(&speed, full, (&rim, at), &mut sum));
        if let Some((place, (ball, within))) = &alone {
            inside = inside.either_sign(*within);
            self.add_looked(core::slice::from_ref(*place), ball, &mut sum);
        }
        if let Some(((balls, within), group)) = &few {
            inside = inside.either_sign(*within);
            self.add_looked(group.real(), balls, &mut sum);
        }
        if P::PAIRS {
            for place in self.places.table() {
                let opposite = [place.opposite()];
                let (ball, within) = self.look(&speed, &opposite, &rim, at);
                inside = inside.either_sign(within);
                self.add_looked(&opposite, &ball, &mut sum);
            }
        }
        Reaction { status: Status::OUT_OF_TABLE.when(inside.has_sign()), ..sum.finish(self.seat.arm, T::ONE) }
    }

    #[inline]
    fn reaction_in_cage_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &Rotation<T>,
        turn: CageTurn<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (speed, rim) = (self.at_speed(at), self.rim(u));
        let (mut sum, mut tangent, mut inside) = (WrenchSum::new(), TangentSum::new(), speed.inside());
        for group in groups::<T, ABREAST>(&self.places) {
            let (balls, within) = self.look(&speed, &group.places, &rim, at);
            inside = inside.either_sign(within);
            let tangents = self.tangents(&speed, &balls);
            for ((place, contact), k) in group.real().iter().zip(&self.contacts(&balls)).zip(&tangents) {
                sum.add(place, contact);
                tangent.add(place, k);
            }
        }
        let status = Status::OUT_OF_TABLE.when(inside.has_sign());
        let reaction = Reaction { status, ..sum.finish(self.seat.arm, T::ONE) };
        (reaction, tangent.finish(self.seat.arm, turn))
    }

    #[inline]
    fn element_loads_in_cage(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        let (speed, rim) = (self.at_speed(at), self.rim(u));
        let mut loads = loads.iter_mut();
        for group in groups::<T, ABREAST>(&self.places) {
            let (balls, _) = self.look(&speed, &group.places, &rim, at);
            for (_, (found, load)) in group.real().iter().zip(balls.load.0.into_iter().zip(&mut loads)) {
                *load = found;
            }
        }
    }
}

bearing_in_cage!(
    Tabulated<T, M, P, A, F, S>,
    T: Scalar, M: Math<T>, P: Arrangement<T>, A: AsRef<[Node<T, F>]> + Send + Sync, S: Surface<T>, const F: usize
);
