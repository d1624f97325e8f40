//! Rung `lumped`: Hajzman's separate radial and axial elements between a rigid inner ring and a rigid or
//! flexible outer one.
//!
//! `F = K Delta^n` for `Delta > 0`, radial `Delta = t^T q - e^T q_S - gamma`, axial alike, with the play
//! `gamma` (negative: preload) and the housing displacement `q_S` of each element's contact point
//! (Hajzman, eq. 1 to 5). The exponent and the backend are types; the values are here.

use super::geometry::{InvalidParameter, check};
use super::ring::{Contact, ContactStiffness, Place, Ring, StiffnessSum, WrenchSum, into_cage};
use super::surface::{Smooth, Surface};
use super::{Bearing, Reaction};
use crate::contact::law::Law;
use crate::frame::{Displacement, Stiffness};
use crate::math::Math;
use crate::scalar::Scalar;
use crate::turn::Turn;
use core::marker::PhantomData;

/// Radial elements only: a radial ball or roller bearing.
#[derive(Debug, Clone, Copy)]
pub struct Radial<T, M, L, P, S = Smooth> {
    ring: Ring<T, P>,
    law: L,
    play: T,
    surface: S,
    math: PhantomData<M>,
}

/// Axial elements only: a thrust bearing, pushed when the inner ring moves towards +Z.
#[derive(Debug, Clone, Copy)]
pub struct Axial<T, M, L, P> {
    ring: Ring<T, P>,
    law: L,
    play: T,
    math: PhantomData<M>,
}

/// Both kinds of element side by side: a combined bearing, or any two bearings on one seat.
#[derive(Debug, Clone, Copy)]
pub struct Combined<A, B>(pub A, pub B);

/// The outer ring or housing at one element's contact point, along X, Y, Z.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HousingPoint<T> {
    /// Displacement, m.
    pub displacement: [T; 3],
    /// Force of the element on the housing, N: an evaluation adds to it.
    pub reaction: [T; 3],
}

impl<T: Scalar, M: Math<T>, L: Law<T, M>, P: AsRef<[Place<T>]>> Radial<T, M, L, P> {
    /// From the elements' places, the law and the radial play (m; half the diametral clearance).
    ///
    /// # Errors
    /// A play that is not finite.
    pub fn try_new(places: P, law: L, radial_play: f64) -> Result<Self, InvalidParameter> {
        check(true, "radial_play", radial_play, "a finite length")?;
        Ok(Self {
            ring: Ring::new(places, 0.0),
            law,
            play: T::from_f64(radial_play),
            surface: Smooth,
            math: PhantomData,
        })
    }

    /// The same bearing with damage on its outer race.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Radial<T, M, L, P, S> {
        Radial { ring: self.ring, law: self.law, play: self.play, surface, math: PhantomData }
    }
}

impl<T: Scalar, M: Math<T>, L: Law<T, M>, P: AsRef<[Place<T>]>> Axial<T, M, L, P> {
    /// From the elements' places, the law, the axial play (m) and the radius at which they act (m).
    ///
    /// # Errors
    /// A play or radius that is not finite, a radius below 0.
    pub fn try_new(places: P, law: L, axial_play: f64, radius: f64) -> Result<Self, InvalidParameter> {
        check(true, "axial play", axial_play, "a finite length")?;
        check(radius >= 0.0, "axial radius", radius, "0 m or more")?;
        Ok(Self { ring: Ring::new(places, radius), law, play: T::from_f64(axial_play), math: PhantomData })
    }
}

/// One family of elements: what is common to the radial and the axial ones.
trait Elements<T: Scalar, M: Math<T>> {
    type Law: Law<T, M>;
    type Places: AsRef<[Place<T>]>;
    fn ring(&self) -> &Ring<T, Self::Places>;
    fn law(&self) -> &Self::Law;
    /// Deflection before the positive part, from radial and axial displacement at the element.
    fn deflection(&self, radial: T, axial: T, azimuth: Turn) -> T;
    /// The direction in which the element pushes the inner ring, times the load.
    fn contact(load: T) -> Contact<T>;
    fn contact_stiffness(slope: T) -> ContactStiffness<T>;

    /// Load on one element whose housing point is displaced by (radial, axial).
    #[inline(always)]
    fn delta(&self, place: &Place<T>, u: &Displacement<T>, cage: Turn, housing: (T, T)) -> T {
        let (radial, axial) = self.ring().at(place, u);
        let azimuth = place.azimuth.plus(cage);
        self.deflection(radial - housing.0, axial - housing.1, azimuth).positive_part()
    }

    #[inline(always)]
    fn sum(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
        let turn = M::sin_cos(cage);
        let local = into_cage(u, turn);
        let mut sum = WrenchSum::default();
        for place in self.ring().places() {
            let delta = self.delta(place, &local, cage, (T::ZERO, T::ZERO));
            sum.add(place, &Self::contact(self.law().load(delta)));
        }
        Reaction { wrench: sum.finish(self.ring().arm, turn), load: sum.load }
    }

    fn sum_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
        let turn = M::sin_cos(cage);
        let local = into_cage(u, turn);
        let (mut sum, mut k) = (WrenchSum::default(), StiffnessSum::new());
        for place in self.ring().places() {
            let delta = self.delta(place, &local, cage, (T::ZERO, T::ZERO));
            let (load, slope) = self.law().load_and_slope(delta);
            sum.add(place, &Self::contact(load));
            k.add(place, self.ring().arm, &Self::contact_stiffness(slope));
        }
        (Reaction { wrench: sum.finish(self.ring().arm, turn), load: sum.load }, k.finish(turn))
    }

    fn loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
        let local = into_cage(u, M::sin_cos(cage));
        for (place, load) in self.ring().places().iter().zip(loads) {
            *load = self.law().load(self.delta(place, &local, cage, (T::ZERO, T::ZERO)));
        }
    }

    /// Each element's place and deflection over the displacement of its housing point, and that point.
    fn each_flexible(
        &self,
        u: &Displacement<T>,
        (sin, cos): (T, T),
        cage: Turn,
        housing: &mut [HousingPoint<T>],
        mut visit: impl FnMut(&Place<T>, T, &mut dyn FnMut(&Contact<T>)),
    ) {
        let local = into_cage(u, (sin, cos));
        let mut points = housing.iter_mut();
        for place in self.ring().places() {
            let mut rigid = HousingPoint::default();
            let point = points.next().unwrap_or(&mut rigid);
            // The element's direction in the fixed frame, in which the housing point is given.
            let e = (cos * place.cos - sin * place.sin, cos * place.sin + sin * place.cos);
            let [hx, hy, hz] = point.displacement;
            let delta = self.delta(place, &local, cage, (hx * e.0 + hy * e.1, hz));
            visit(place, delta, &mut |contact| {
                let [rx, ry, rz] = point.reaction;
                point.reaction = [rx - contact.radial * e.0, ry - contact.radial * e.1, rz - contact.axial];
            });
        }
    }

    /// As [`Elements::sum`] with a flexible outer ring.
    fn sum_flexible(&self, u: &Displacement<T>, cage: Turn, housing: &mut [HousingPoint<T>]) -> Reaction<T> {
        let turn = M::sin_cos(cage);
        let mut sum = WrenchSum::default();
        self.each_flexible(u, turn, cage, housing, |place, delta, react| {
            let contact = Self::contact(self.law().load(delta));
            sum.add(place, &contact);
            react(&contact);
        });
        Reaction { wrench: sum.finish(self.ring().arm, turn), load: sum.load }
    }

    /// As [`Elements::sum_and_stiffness`] with a flexible outer ring, the housing standing still.
    fn sum_and_stiffness_flexible(
        &self,
        u: &Displacement<T>,
        cage: Turn,
        housing: &mut [HousingPoint<T>],
    ) -> (Reaction<T>, Stiffness<T>) {
        let turn = M::sin_cos(cage);
        let (mut sum, mut k) = (WrenchSum::default(), StiffnessSum::new());
        self.each_flexible(u, turn, cage, housing, |place, delta, react| {
            let (load, slope) = self.law().load_and_slope(delta);
            let contact = Self::contact(load);
            sum.add(place, &contact);
            k.add(place, self.ring().arm, &Self::contact_stiffness(slope));
            react(&contact);
        });
        (Reaction { wrench: sum.finish(self.ring().arm, turn), load: sum.load }, k.finish(turn))
    }
}

impl<T, M, L, P, S> Elements<T, M> for Radial<T, M, L, P, S>
where
    T: Scalar,
    M: Math<T>,
    L: Law<T, M>,
    P: AsRef<[Place<T>]>,
    S: Surface<T>,
{
    type Law = L;
    type Places = P;
    fn ring(&self) -> &Ring<T, P> {
        &self.ring
    }
    fn law(&self) -> &L {
        &self.law
    }
    #[inline(always)]
    fn deflection(&self, radial: T, _axial: T, azimuth: Turn) -> T {
        radial - self.play - self.surface.drop_at(azimuth)
    }
    #[inline(always)]
    fn contact(load: T) -> Contact<T> {
        Contact { radial: -load, axial: T::ZERO, load }
    }
    fn contact_stiffness(slope: T) -> ContactStiffness<T> {
        ContactStiffness { radial: slope, cross: T::ZERO, axial: T::ZERO }
    }
}

impl<T, M, L, P> Elements<T, M> for Axial<T, M, L, P>
where
    T: Scalar,
    M: Math<T>,
    L: Law<T, M>,
    P: AsRef<[Place<T>]>,
{
    type Law = L;
    type Places = P;
    fn ring(&self) -> &Ring<T, P> {
        &self.ring
    }
    fn law(&self) -> &L {
        &self.law
    }
    #[inline(always)]
    fn deflection(&self, _radial: T, axial: T, _azimuth: Turn) -> T {
        axial - self.play
    }
    #[inline(always)]
    fn contact(load: T) -> Contact<T> {
        Contact { radial: T::ZERO, axial: -load, load }
    }
    fn contact_stiffness(slope: T) -> ContactStiffness<T> {
        ContactStiffness { radial: T::ZERO, cross: T::ZERO, axial: slope }
    }
}

/// A bearing whose outer ring is displaced point by point (Hajzman's `e^T q_S` term).
pub trait FlexibleRing<T: Scalar> {
    /// Force on the inner ring when the housing point of element `j` is displaced as `housing[j]` says, and the
    /// reaction on that point (action = reaction). Elements past the end of `housing` stand on a rigid ring.
    fn reaction_flexible(&self, u: &Displacement<T>, cage: Turn, housing: &mut [HousingPoint<T>]) -> Reaction<T>;

    /// The same with the tangent `-d(wrench)/du` while the housing stands still.
    fn reaction_and_stiffness_flexible(
        &self,
        u: &Displacement<T>,
        cage: Turn,
        housing: &mut [HousingPoint<T>],
    ) -> (Reaction<T>, Stiffness<T>);
}

macro_rules! bearing_of_elements {
    ($kind:ty, $($generics:tt)*) => {
        impl<$($generics)*> Bearing<T> for $kind {
            fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
                self.sum(u, cage)
            }
            fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
                self.sum_and_stiffness(u, cage)
            }
            fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
                self.loads(u, cage, loads);
            }
        }

        impl<$($generics)*> FlexibleRing<T> for $kind {
            fn reaction_flexible(
                &self,
                u: &Displacement<T>,
                cage: Turn,
                housing: &mut [HousingPoint<T>],
            ) -> Reaction<T> {
                self.sum_flexible(u, cage, housing)
            }
            fn reaction_and_stiffness_flexible(
                &self,
                u: &Displacement<T>,
                cage: Turn,
                housing: &mut [HousingPoint<T>],
            ) -> (Reaction<T>, Stiffness<T>) {
                self.sum_and_stiffness_flexible(u, cage, housing)
            }
        }
    };
}

bearing_of_elements!(
    Radial<T, M, L, P, S>,
    T: Scalar, M: Math<T>, L: Law<T, M>, P: AsRef<[Place<T>]> + Send + Sync, S: Surface<T>
);
bearing_of_elements!(
    Axial<T, M, L, P>,
    T: Scalar, M: Math<T>, L: Law<T, M>, P: AsRef<[Place<T>]> + Send + Sync
);

fn both<T: Scalar>(a: Reaction<T>, b: Reaction<T>) -> Reaction<T> {
    Reaction { wrench: a.wrench.plus(b.wrench), load: a.load + b.load }
}

impl<T: Scalar, A: Bearing<T>, B: Bearing<T>> Bearing<T> for Combined<A, B> {
    fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
        both(self.0.reaction(u, cage), self.1.reaction(u, cage))
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
        let (a, ka) = self.0.reaction_and_stiffness(u, cage);
        let (b, kb) = self.1.reaction_and_stiffness(u, cage);
        (both(a, b), ka + kb)
    }
    /// The loads of the first kind only: one entry an element, as the radial ones show the load zone.
    fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
        self.0.element_loads(u, cage, loads);
    }
}

impl<T: Scalar, A: FlexibleRing<T>, B: FlexibleRing<T>> FlexibleRing<T> for Combined<A, B> {
    fn reaction_flexible(&self, u: &Displacement<T>, cage: Turn, housing: &mut [HousingPoint<T>]) -> Reaction<T> {
        both(self.0.reaction_flexible(u, cage, housing), self.1.reaction_flexible(u, cage, housing))
    }
    fn reaction_and_stiffness_flexible(
        &self,
        u: &Displacement<T>,
        cage: Turn,
        housing: &mut [HousingPoint<T>],
    ) -> (Reaction<T>, Stiffness<T>) {
        let (a, ka) = self.0.reaction_and_stiffness_flexible(u, cage, housing);
        let (b, kb) = self.1.reaction_and_stiffness_flexible(u, cage, housing);
        (both(a, b), ka + kb)
    }
}

/// Samples a pass of [`radial_batch`] goes over: their arrays stay in the first-level cache from pass to pass, and
/// what a pass costs besides is spread over many.
const BLOCK: usize = 256;

/// Elements a pass takes together: their directions and sums are as much as 16 vector registers hold.
const ABREAST: usize = 4;

/// Many samples at once in structure-of-arrays form: `fx[i], fy[i]` from `u[i], v[i]`, the cage standing at `cage`.
///
/// The compiler turns the loops into the machine's vector instructions. Stops at the shortest of the four slices.
/// The forces are those of [`Bearing::reaction`] but for rounding. Elements that stand in opposite pairs (an even
/// number, evenly spaced) and have no preload share a square root: of two opposite ones at most one is loaded.
pub fn radial_batch<T: Scalar, M: Math<T>, L: Law<T, M>, P: AsRef<[Place<T>]>>(
    bearing: &Radial<T, M, L, P>,
    cage: Turn,
    input: (&[T], &[T]),
    output: (&mut [T], &mut [T]),
) {
    let Radial { ring, law, play, .. } = bearing;
    let turn = M::sin_cos(cage);
    match one_of_each_pair(ring.places()) {
        Some(half) if *play >= T::ZERO => sum_of_elements(half, turn, input, output, |radial| {
            law.load(positive(radial.abs() - *play)).negated_by(radial)
        }),
        _ => sum_of_elements(ring.places(), turn, input, output, |radial| law.load(positive(radial - *play))),
    }
}

/// The first half of the places if each place of the second half stands opposite to its own in the first.
fn one_of_each_pair<T: Scalar>(places: &[Place<T>]) -> Option<&[Place<T>]> {
    const HALF_TURN: Turn = Turn(1 << 63);
    let (half, other) = places.split_at(places.len() / 2);
    let opposite = |(a, b): (&Place<T>, &Place<T>)| a.azimuth.plus(HALF_TURN) == b.azimuth;
    (half.len() == other.len() && half.iter().zip(other).all(opposite)).then_some(half)
}

/// The positive part as a comparison and a mask, two vector instructions; -0 becomes 0 and NaN stays NaN.
#[inline(always)]
fn positive<T: Scalar>(x: T) -> T {
    if x <= T::ZERO { T::ZERO } else { x }
}

/// Sets the force to `-sum(push(e^T u) e)` over the directions `e` of all places, the cage turned by `(sin, cos)`.
#[inline(always)]
fn sum_of_elements<T: Scalar>(
    places: &[Place<T>],
    (sin, cos): (T, T),
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    push: impl Fn(T) -> T + Copy,
) {
    let direction = |p: &Place<T>| [cos * p.cos - sin * p.sin, cos * p.sin + sin * p.cos];
    let (groups, rest) = places.as_chunks::<ABREAST>();
    let count = u.len().min(v.len()).min(fx.len()).min(fy.len());
    let fx = fx.get_mut(..count).unwrap_or_default().chunks_mut(BLOCK);
    let fy = fy.get_mut(..count).unwrap_or_default().chunks_mut(BLOCK);
    for (((u, v), fx), fy) in u.chunks(BLOCK).zip(v.chunks(BLOCK)).zip(fx).zip(fy) {
        fx.fill(T::ZERO);
        fy.fill(T::ZERO);
        for group in groups {
            add_forces(group.each_ref().map(direction), (u, v), (&mut *fx, &mut *fy), push);
        }
        for place in rest {
            add_forces([direction(place)], (u, v), (&mut *fx, &mut *fy), push);
        }
    }
}

/// One pass: the forces of `K` elements on every sample of a block.
fn add_forces<T: Scalar, const K: usize>(
    directions: [[T; 2]; K],
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    push: impl Fn(T) -> T,
) {
    for (((&u, &v), fx), fy) in u.iter().zip(v).zip(fx).zip(fy) {
        let (mut x, mut y) = (*fx, *fy);
        for [cos, sin] in directions {
            let load = push(u * cos + v * sin);
            x -= load * cos;
            y -= load * sin;
        }
        (*fx, *fy) = (x, y);
    }
}
