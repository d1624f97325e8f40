//! Radial and axial elements in parallel, on a rigid or displaced housing.

use super::housing::HousingShape;
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Scalar, Stiffness};

/// Force of the elements of one kind.
pub trait ElementForces<T: Scalar>: Send + Sync {
    /// Computes the force on the inner ring and adds the reaction to the points of `housing`, if there are any.
    fn force_and_housing(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T>;
}

impl<T: Scalar, B: Bearing<T> + FlexibleRing<T>> ElementForces<T> for B {
    fn force_and_housing(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T> {
        if housing.is_empty() { self.reaction(u, at) } else { self.reaction_flexible(u, at, housing) }
    }
}

/// Elements of one kind. With dynamic dispatch, the size of the program grows with the sum of the kinds instead of their product.
pub trait Elements<T: Scalar>: ElementForces<T> + Bearing<T> + FlexibleRing<T> {}
impl<T: Scalar, B: Bearing<T> + FlexibleRing<T>> Elements<T> for B {}

/// Radial and axial elements together, and Hajzman's flexible outer ring with given `q_S`.
pub(super) struct Lumped<E: ?Sized> {
    pub(super) radial: Box<E>,
    pub(super) axial: Option<Box<E>>,
    /// None where the outer ring is rigid.
    pub(super) housing: Option<HousingShape>,
}

impl<E: ?Sized> Lumped<E> {
    fn kinds(&self) -> impl Iterator<Item = &E> {
        [Some(&self.radial), self.axial.as_ref()].into_iter().flatten().map(Box::as_ref)
    }

    /// Returns the housing at every element; empty where the outer ring is rigid.
    fn housing_at<T: Scalar>(&self, at: &BearingKinematicState<T>) -> Vec<HousingPoint<T>> {
        self.housing.as_ref().map_or_else(Vec::new, |shape| shape.at_elements(at.cage))
    }

    pub(super) fn force<T: Scalar>(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>
    where
        E: ElementForces<T>,
    {
        let mut housing = self.housing_at(at);
        let one = |kind: &E| kind.force_and_housing(u, at, &mut housing);
        self.kinds().map(one).fold(Reaction::default(), |sum, one| sum + one)
    }
}

impl<T: Scalar> Bearing<T> for Lumped<dyn Elements<T>> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.force(u, at)
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let mut housing = self.housing_at(at);
        let one = |kind: &dyn Elements<T>| match housing.as_mut_slice() {
            [] => kind.reaction_and_stiffness(u, at),
            points => kind.reaction_and_stiffness_flexible(u, at, points),
        };
        let start = (Reaction::default(), Stiffness::from_element(T::ZERO));
        self.kinds().map(one).fold(start, |(sum, stiffness), (reaction, k)| (sum + reaction, stiffness + k))
    }

    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        if self.housing.is_some() {
            self.element_loads(u, at, loads);
            return self.force(u, at);
        }
        let radial = self.radial.reaction_and_loads(u, at, loads);
        self.axial.iter().fold(radial, |sum, axial| sum + axial.reaction(u, at))
    }

    /// Computes the loads of the radial elements, which show the load zone; on a displaced housing, the size of the reaction
    /// of the housing on each element.
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        if self.housing.is_none() {
            return self.radial.element_loads(u, at, loads);
        }
        let mut points = self.housing_at(at);
        for kind in self.kinds() {
            kind.reaction_flexible(u, at, &mut points);
        }
        for (load, point) in loads.iter_mut().zip(&points) {
            let square = point.reaction.iter().map(|r| r.to_f64() * r.to_f64()).sum::<f64>();
            *load = T::from_f64(square.sqrt());
        }
    }
}
