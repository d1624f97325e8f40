//! Flexible outer ring: displacement of the housing at each element (`e^T q_S` of Hajzman).

use super::Reaction;
use super::element_position::ElementLayout;
use super::elements::Elements;
use super::lumped::Combined;
use super::ring::{CageRotation, Contact, Motion, StiffnessSum, WrenchSum, from_cage_frame, to_cage_frame};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::scalar::Scalar;

/// The outer ring or housing at the contact point of one element, along X, Y, Z.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HousingPoint<T> {
    /// Displacement, m.
    pub displacement: [T; 3],
    /// Force of the element on the housing, N; evaluations add to it.
    pub reaction: [T; 3],
    /// Tangent of the radial reaction, N/m: its decrease with a radial displacement of the point. Evaluations with
    /// stiffness add to it.
    pub radial_stiffness: T,
}

/// A bearing whose outer ring is displaced point by point (`e^T q_S` of Hajzman).
///
/// ```
/// use ballrace::bearing::evenly_spaced;
/// use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
/// use ballrace::bearing::lumped::Radial;
/// use ballrace::contact::law::PointContactLaw;
/// use ballrace::{Displacement, Exact, Phase};
///
/// let positions = evenly_spaced::<f64, 8>(Phase::ZERO);
/// let bearing = Radial::<f64, Exact, _, _>::try_new(positions, PointContactLaw { stiffness: 8e9 }, 0.0)?;
/// // The housing moves with the loaded ball: half the deflection; the reaction acts on the housing.
/// let mut housing = [HousingPoint::default(); 8];
/// housing[0].displacement = [1e-6, 0.0, 0.0];
/// let u = Displacement { u: 2e-6, ..Displacement::default() };
/// let force = bearing.reaction_flexible(&u, &Phase::ZERO.into(), &mut housing).wrench;
/// let on_housing: f64 = housing.iter().map(|point| point.reaction[0]).sum();
/// assert!((force.fx + on_housing).abs() < 1e-9);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub trait FlexibleRing<T: Scalar> {
    /// Computes the force on the inner ring with the displacements of `housing`, and adds the reaction to each housing
    /// point.
    ///
    /// Point `j` belongs to element `j`; elements beyond `housing` are on a rigid ring.
    fn reaction_flexible(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T>;

    /// Computes the force and its tangent `-d(wrench)/du` at constant housing displacement, and adds reaction and radial
    /// stiffness to each housing point.
    fn reaction_and_stiffness_flexible(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> (Reaction<T>, Stiffness<T>);
}

impl<T: Scalar> HousingPoint<T> {
    /// Returns the radial displacement (towards `direction`) and the axial one.
    #[inline(always)]
    fn along(&self, (cos, sin): (T, T)) -> (T, T) {
        let [x, y, z] = self.displacement;
        (x * cos + y * sin, z)
    }

    /// Adds the force of a contact, N; that on the inner ring is opposite.
    #[inline(always)]
    fn add_reaction(&mut self, (cos, sin): (T, T), contact: &Contact<T>, scale: T) {
        let [x, y, z] = self.reaction;
        let radial = scale * contact.radial;
        self.reaction = [x + radial * cos, y + radial * sin, z + scale * contact.axial];
    }
}

/// Evaluates `contact` for every element at its motion relative to its housing point.
fn each_element<T: Scalar, E: Elements<Scalar = T>>(
    elements: &E,
    u: &Displacement<T>,
    (at, (sin, cos)): (&BearingKinematicState<T>, CageRotation<T>),
    housing: &mut [HousingPoint<T>],
    mut contact: impl FnMut(&super::ElementPosition<T>, Motion<T>, &mut HousingPoint<T>) -> Contact<T>,
) {
    let ring = elements.ring();
    let rim = ring.at_rim(&to_cage_frame(u, (sin, cos)));
    let mut points = housing.iter_mut();
    for position in ring.positions.all() {
        let mut rigid = HousingPoint::default();
        let point = points.next().unwrap_or(&mut rigid);
        // Housing points are given in the fixed frame.
        let direction = (cos * position.cos - sin * position.sin, cos * position.sin + sin * position.cos);
        let (radial, axial) = point.along(direction);
        let motion = Motion::of(&position, &rim, at, elements.surface());
        let motion = Motion { radial: motion.radial - radial, axial: motion.axial - axial, ..motion };
        let contact = contact(&position, motion, point);
        point.add_reaction(direction, &contact, ring.scale);
    }
}

impl<E: Elements> FlexibleRing<E::Scalar> for E {
    fn reaction_flexible(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
        housing: &mut [HousingPoint<E::Scalar>],
    ) -> Reaction<E::Scalar> {
        let turn = E::Math::sin_cos(at.cage);
        let mut sum = WrenchSum::new();
        each_element(self, u, (at, turn), housing, |position, motion, _| {
            let contact = self.contacts(motion.alone()).alone();
            sum.add(position, &contact);
            contact
        });
        let ring = self.ring();
        let local = sum.finish(ring.arm, ring.scale);
        Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }
    }

    fn reaction_and_stiffness_flexible(
        &self,
        u: &Displacement<E::Scalar>,
        at: &BearingKinematicState<E::Scalar>,
        housing: &mut [HousingPoint<E::Scalar>],
    ) -> (Reaction<E::Scalar>, Stiffness<E::Scalar>) {
        let turn = E::Math::sin_cos(at.cage);
        let (mut sum, mut stiffness) = (WrenchSum::new(), StiffnessSum::new());
        let scale = self.ring().scale;
        each_element(self, u, (at, turn), housing, |position, motion, point| {
            let (contact, k) = self.contact_and_stiffness(motion);
            sum.add(position, &contact);
            stiffness.add(position, &k);
            point.radial_stiffness += scale * k.radial;
            contact
        });
        let ring = self.ring();
        let local = sum.finish(ring.arm, ring.scale);
        let stiffness = stiffness.finish(ring.arm, ring.scale, turn);
        (Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }, stiffness)
    }
}

impl<T: Scalar, A: FlexibleRing<T>, B: FlexibleRing<T>> FlexibleRing<T> for Combined<A, B> {
    fn reaction_flexible(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T> {
        self.0.reaction_flexible(u, at, housing) + self.1.reaction_flexible(u, at, housing)
    }
    fn reaction_and_stiffness_flexible(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> (Reaction<T>, Stiffness<T>) {
        let (a, ka) = self.0.reaction_and_stiffness_flexible(u, at, housing);
        let (b, kb) = self.1.reaction_and_stiffness_flexible(u, at, housing);
        (a + b, ka + kb)
    }
}
