//! Common evaluation of all models with independent elements.

use super::Reaction;
use super::element_position::{BLOCK_SIZE, ElementLayout, ElementPosition};
use super::ring::{
    CageRotation, Contact, ContactStiffness, Motion, Ring, StiffnessSum, WrenchSum, from_cage_frame, to_cage_frame,
};
use super::surface::Surface;
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Largest number of elements evaluated together, stage by stage: each element is a chain of dependent operations, which a desktop
/// processor overlaps only if they are close together in the code. A stage ends in memory, a whole block at a time, so that the compiler
/// uses registers as wide as a block.
pub(super) const MAX_STAGED: usize = 4 * BLOCK_SIZE;

/// Result of a stage for each block.
pub(super) type Staged<X> = [Option<X>; MAX_STAGED / BLOCK_SIZE];

/// A value aligned to cache lines.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub(super) struct Aligned<X>(pub X);

/// Returns stages without results. Element by element, so that only the discriminants are written.
#[inline(always)]
pub(super) const fn empty_stages<X>() -> Staged<X> {
    [None, None, None, None]
}

/// Contact mechanics of the rolling elements around one ring, element by element.
///
/// Every implementation is a [`CageFrame`] and, where the outer ring bends, a [`super::flexible::FlexibleRing`].
pub trait Elements {
    /// Precision.
    type Scalar: Scalar;
    /// Math backend.
    type Math: Math<Self::Scalar>;
    /// Positions of the elements.
    type ElementPositions: ElementLayout<Self::Scalar>;
    /// Deviations of the raceways and elements from their ideal shape.
    type Surface: Surface<Self::Scalar>;

    /// Returns positions, lever arm and scale of the elements.
    fn ring(&self) -> &Ring<Self::Scalar, Self::ElementPositions>;

    /// Returns the surface deviations.
    fn surface(&self) -> &Self::Surface;

    /// Computes the contacts of `K` elements side by side, to be multiplied by the scale of the ring.
    fn contacts<const K: usize>(&self, at: Motion<Lanes<Self::Scalar, K>>) -> Contact<Lanes<Self::Scalar, K>>;

    /// Computes the contact of one element and its stiffness, to be multiplied by the scale of the ring.
    fn contact_and_stiffness(
        &self,
        at: Motion<Self::Scalar>,
    ) -> (Contact<Self::Scalar>, ContactStiffness<Self::Scalar>);

    /// Adds the forces of all elements, up to [`MAX_STAGED`] at a time: first their contacts, then the sum in the order of the elements.
    /// Writes the load of as many elements as `loads` takes. Returns `None` for pairs, for fewer elements than a block, and where blocks hold one element.
    #[inline(always)]
    fn staged_sum(
        &self,
        rim: &Displacement<Self::Scalar>,
        at: &BearingKinematicState<Self::Scalar>,
        loads: &mut [Self::Scalar],
    ) -> Option<WrenchSum<Self::Scalar>> {
        let Ring { positions, scale, .. } = self.ring();
        let stored = positions.stored();
        if BLOCK_SIZE == 1 || Self::ElementPositions::IS_PAIRED || stored.len() < BLOCK_SIZE {
            return None;
        }
        let (mut sum, mut begin) = (WrenchSum::new(), 0);
        while begin * BLOCK_SIZE < stored.len() {
            let mut stages = empty_stages();
            for (i, stage) in stages.iter_mut().enumerate() {
                let Some(block) = positions.block(begin + i) else { break };
                let contacts = self.contacts(Motion::of_block(&block, rim, at, self.surface()));
                *stage = Some(Aligned((contacts, block.first, block.overlap)));
            }
            for Aligned((contacts, first, overlap)) in stages.iter().map_while(Option::as_ref) {
                sum.add_each(stored.get(*first..).unwrap_or_default(), contacts, *overlap);
                for (load, &unscaled) in loads.iter_mut().skip(*first).zip(&contacts.load.0).skip(*overlap) {
                    *load = *scale * unscaled;
                }
            }
            begin += MAX_STAGED / BLOCK_SIZE;
        }
        Some(sum)
    }

    /// Computes the reaction of all elements in the cage frame.
    #[inline(always)]
    fn sum(&self, u: &Displacement<Self::Scalar>, at: &BearingKinematicState<Self::Scalar>) -> Reaction<Self::Scalar> {
        let ring = self.ring();
        let rim = ring.at_rim(u);
        let sum = if let Some(sum) = self.staged_sum(&rim, at, &mut []) {
            sum
        } else {
            let mut sum = WrenchSum::new();
            for position in ring.positions.stored() {
                if Self::ElementPositions::IS_PAIRED {
                    sum.add_pair(position, &self.contacts(Motion::of_pair(position, &rim, at, self.surface())));
                } else {
                    sum.add(position, &self.contacts(Motion::of(position, &rim, at, self.surface()).alone()).alone());
                }
            }
            sum
        };
        self.finish(&sum)
    }

    /// Returns the force on the ring from the sum of its elements.
    #[inline(always)]
    fn finish(&self, sum: &WrenchSum<Self::Scalar>) -> Reaction<Self::Scalar> {
        sum.finish(self.ring().arm, self.ring().scale)
    }

    /// Adds the contacts of one element at `K` displacements of the rim, by component, to their sums. The compiler vectorises the loop.
    #[inline(always)]
    fn add_contacts<const K: usize>(
        &self,
        position: &ElementPosition<Self::Scalar>,
        rims: &[[Self::Scalar; K]; 5],
        at: &[BearingKinematicState<Self::Scalar>; K],
        sums: &mut [[Self::Scalar; K]; 6],
    ) {
        for i in 0..K {
            let rim = Displacement::from_array(rims.each_ref().map(|component| component[i]));
            let contact = self.contacts(Motion::of(position, &rim, &at[i], self.surface()).alone()).alone();
            let mut sum = WrenchSum::from_array(sums.each_ref().map(|component| component[i]));
            sum.add(position, &contact);
            for (component, found) in sums.iter_mut().zip(sum.to_array()) {
                component[i] = found;
            }
        }
    }
}

/// A bearing in the frame that rotates with its cage, in which the elements are fixed.
///
/// Use it where the displacement is known in that frame, or for many evaluations at one cage angle: [`super::Bearing`] adds
/// the sine and cosine of the cage angle and two rotations.
pub trait CageFrame<T: Scalar> {
    /// Returns sine and cosine of the cage angle.
    fn cage_rotation(cage: Phase) -> CageRotation<T>;

    /// Computes [`super::Bearing::reaction`] with displacement and wrench in the cage frame. Only surface deviations use
    /// `at`.
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>;

    /// Computes the reaction in the cage frame and the tangent stiffness in the fixed frame, rotated by `turn`.
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>);

    /// Computes [`super::Bearing::element_loads`] with the displacement in the cage frame.
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]);

    /// Computes [`super::Bearing::reaction_and_loads`] with displacement and wrench in the cage frame.
    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        self.element_loads_in_cage_frame(u, at, loads);
        self.reaction_in_cage_frame(u, at)
    }

    /// Computes [`super::Bearing::reaction`], always inlined: a caller compiled for wider SIMD registers than the rest of
    /// the program compiles the bearing with it.
    #[inline(always)]
    fn reaction_inlined(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let turn = Self::cage_rotation(at.cage);
        let local = self.reaction_in_cage_frame(&to_cage_frame(u, turn), at);
        Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }
    }

    /// Computes [`super::Bearing::reaction`] at `K` displacements, with the same bits, always inlined.
    #[inline(always)]
    fn reactions_inlined<const K: usize>(
        &self,
        u: &[Displacement<T>; K],
        at: &[BearingKinematicState<T>; K],
    ) -> [Reaction<T>; K] {
        core::array::from_fn(|i| self.reaction_inlined(&u[i], &at[i]))
    }

    /// Computes [`super::Bearing::reaction_and_loads`], always inlined.
    #[inline(always)]
    fn reaction_and_loads_inlined(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        let turn = Self::cage_rotation(at.cage);
        let local = self.reaction_and_loads_in_cage_frame(&to_cage_frame(u, turn), at, loads);
        Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }
    }
}

#[inline(always)]
fn reaction_and_stiffness<T: Scalar, E: Elements<Scalar = T>>(
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

impl<E: Elements> CageFrame<E::Scalar> for E {
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<E::Scalar> {
        E::Math::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage_frame(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
    ) -> Reaction<E::Scalar> {
        self.sum(u, at)
    }

    // Always inlined: a matrix that a call returns is copied.
    #[inline]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
        turn: CageRotation<E::Scalar>,
    ) -> (Reaction<E::Scalar>, Stiffness<E::Scalar>) {
        reaction_and_stiffness(self, u, at, turn)
    }

    #[inline(always)]
    fn reactions_inlined<const K: usize>(
        &self,
        u: &[Displacement<E::Scalar>; K],
        at: &[BearingKinematicState<E::Scalar>; K],
    ) -> [Reaction<E::Scalar>; K] {
        let ring = self.ring();
        if E::ElementPositions::IS_PAIRED {
            return core::array::from_fn(|i| self.reaction_inlined(&u[i], &at[i]));
        }
        let turns = at.each_ref().map(|at| Self::cage_rotation(at.cage));
        let mut rims = [[E::Scalar::ZERO; K]; 5];
        for i in 0..K {
            let rim = ring.at_rim(&to_cage_frame(&u[i], turns[i]));
            for (component, value) in rims.iter_mut().zip(rim.to_array()) {
                component[i] = value;
            }
        }
        let mut sums = [[E::Scalar::NEGATIVE_ZERO; K]; 6];
        for position in ring.positions.stored() {
            self.add_contacts(position, &rims, at, &mut sums);
        }
        core::array::from_fn(|i| {
            let local = self.finish(&WrenchSum::from_array(sums.each_ref().map(|component| component[i])));
            Reaction { wrench: from_cage_frame(&local.wrench, turns[i]), ..local }
        })
    }

    #[inline(always)]
    fn element_loads_in_cage_frame(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
        loads: &mut [E::Scalar],
    ) {
        let rim = self.ring().at_rim(u);
        if self.staged_sum(&rim, at, loads).is_some() {
            return;
        }
        for (position, load) in self.ring().positions.all().zip(loads) {
            let contact = self.contacts(Motion::of(&position, &rim, at, self.surface()).alone());
            *load = self.ring().scale * contact.alone().load;
        }
    }

    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
        loads: &mut [E::Scalar],
    ) -> Reaction<E::Scalar> {
        let ring = self.ring();
        if let Some(sum) = self.staged_sum(&ring.at_rim(u), at, loads) {
            return sum.finish(ring.arm, ring.scale);
        }
        self.element_loads_in_cage_frame(u, at, loads);
        self.sum(u, at)
    }
}
