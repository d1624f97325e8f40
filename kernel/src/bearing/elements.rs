//! What the rungs with rolling elements have in common: one element's law in, the bearing's answer out.

use super::Reaction;
use super::element_position::ElementLayout;
use super::ring::{
    CageRotation, Contact, ContactStiffness, Motion, Ring, StiffnessSum, WrenchSum, from_cage_frame, to_cage_frame,
};
use super::surface::Surface;
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// One family of elements around a ring: what a ball does in its plane.
pub trait Elements<T: Scalar> {
    /// The backend.
    type Math: Math<T>;
    /// The arrangement of the elements.
    type ElementPositions: ElementLayout<T>;
    /// What the elements run on.
    type Surface: Surface<T>;

    fn ring(&self) -> &Ring<T, Self::ElementPositions>;

    fn surface(&self) -> &Self::Surface;

    /// The contacts of `K` elements, to be multiplied by the ring's scale.
    fn contacts<const K: usize>(&self, at: [Motion<T>; K]) -> [Contact<T>; K];

    fn contact_and_stiffness(&self, at: Motion<T>) -> (Contact<T>, ContactStiffness<T>);

    /// The answer of all elements in the cage's frame.
    #[inline(always)]
    fn sum(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let ring = self.ring();
        let rim = ring.at_rim(u);
        let mut sum = WrenchSum::new();
        for position in ring.positions.stored() {
            if Self::ElementPositions::IS_PAIRED {
                sum.add_pair(position, &self.contacts(Motion::of_pair(position, &rim, at, self.surface())));
            } else {
                let [contact] = self.contacts([Motion::of(position, &rim, at, self.surface())]);
                sum.add(position, &contact);
            }
        }
        sum.finish(ring.arm, ring.scale)
    }
}

/// A bearing as seen from the frame that turns with its cage, in which its elements stand still.
///
/// For those who have the displacement in that frame, or evaluate often at one cage angle: the sine and cosine and the
/// rotation of displacement and wrench are what [`super::Bearing`] adds.
pub trait CageFrame<T: Scalar> {
    /// Sine and cosine of the cage's angle.
    fn cage_rotation(cage: Phase) -> CageRotation<T>;

    /// As [`super::Bearing::reaction`] with displacement and wrench in the cage's frame; `at` only says where damage
    /// on a race is met.
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>;

    /// The same with the tangent, which is turned into the fixed frame by `turn`.
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>);

    /// As [`super::Bearing::element_loads`] with the displacement in the cage's frame.
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]);

    /// [`super::Bearing::reaction`] as part of whoever calls it: a caller that is compiled for a processor with wider
    /// registers than the rest of its program takes the bearing with it.
    #[inline(always)]
    fn reaction_inlined(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let turn = Self::cage_rotation(at.cage);
        let local = self.reaction_in_cage_frame(&to_cage_frame(u, turn), at);
        Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }
    }
}

#[inline(always)]
pub(super) fn reaction_and_stiffness<T: Scalar, E: Elements<T>>(
    elements: &E,
    u: &Displacement<T>,
    at: &BearingKinematicState<T>,
    turn: CageRotation<T>,
) -> (Reaction<T>, Stiffness<T>) {
    let ring = elements.ring();
    let rim = ring.at_rim(u);
    let (mut sum, mut stiffness) = (WrenchSum::new(), StiffnessSum::new());
    for position in ring.positions.all() {
        let (contact, k) = elements.contact_and_stiffness(Motion::of(&position, &rim, at, elements.surface()));
        sum.add(&position, &contact);
        stiffness.add(&position, &k);
    }
    (sum.finish(ring.arm, ring.scale), stiffness.finish(ring.arm, ring.scale, turn))
}

pub(super) fn loads<T: Scalar, E: Elements<T>>(
    elements: &E,
    u: &Displacement<T>,
    at: &BearingKinematicState<T>,
    loads: &mut [T],
) {
    let rim = elements.ring().at_rim(u);
    for (position, load) in elements.ring().positions.all().zip(loads) {
        let [contact] = elements.contacts([Motion::of(&position, &rim, at, elements.surface())]);
        *load = elements.ring().scale * contact.load;
    }
}

/// Implements [`CageFrame`] for types with [`Elements`].
macro_rules! in_cage_by_elements {
    ($kind:ty, $math:ty, $($generics:tt)*) => {
        impl<$($generics)*> $crate::bearing::CageFrame<T> for $kind {
            #[inline(always)]
            fn cage_rotation(cage: $crate::Phase) -> (T, T) {
                <$math as $crate::math::Math<T>>::sin_cos(cage)
            }
            #[inline(always)]
            fn reaction_in_cage_frame(&self, u: &$crate::Displacement<T>, at: &$crate::BearingKinematicState<T>) -> $crate::bearing::Reaction<T> {
                $crate::bearing::elements::Elements::sum(self, u, at)
            }
            #[inline]
            fn reaction_and_stiffness_in_cage_frame(
                &self,
                u: &$crate::Displacement<T>,
                at: &$crate::BearingKinematicState<T>,
                turn: (T, T),
            ) -> ($crate::bearing::Reaction<T>, $crate::Stiffness<T>) {
                $crate::bearing::elements::reaction_and_stiffness(self, u, at, turn)
            }
            #[inline]
            fn element_loads_in_cage_frame(&self, u: &$crate::Displacement<T>, at: &$crate::BearingKinematicState<T>, loads: &mut [T]) {
                $crate::bearing::elements::loads(self, u, at, loads);
            }
        }
    };
}
pub(super) use in_cage_by_elements;
