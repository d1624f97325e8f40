//! Radial and axial elements in parallel, on a rigid, displaced or bending outer ring.

use super::housing::HousingShape;
use super::outer_ring::{BendingRing, LoadedRing};
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Scalar, Stiffness};

/// Force of the elements of one kind.
pub trait ElementForces<T: Scalar>: Send + Sync {
    /// Computes the force on the inner ring; the outer ring is rigid.
    fn force(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>;
    /// Computes the force on the inner ring and adds the reaction to the points of `housing`.
    fn force_on_points(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T>;
    /// Computes the same and adds the radial stiffness too.
    fn force_and_stiffness_of_points(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T>;
}

impl<T: Scalar, B: Bearing<T> + FlexibleRing<T>> ElementForces<T> for B {
    fn force(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.reaction(u, at)
    }
    fn force_on_points(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T> {
        self.reaction_flexible(u, at, housing)
    }
    fn force_and_stiffness_of_points(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        housing: &mut [HousingPoint<T>],
    ) -> Reaction<T> {
        self.reaction_and_stiffness_flexible(u, at, housing).0
    }
}

/// Elements of one kind. With dynamic dispatch, the size of the program grows with the sum of the kinds instead of their product.
pub trait Elements<T: Scalar>: ElementForces<T> + Bearing<T> + FlexibleRing<T> {}
impl<T: Scalar, B: Bearing<T> + FlexibleRing<T>> Elements<T> for B {}

/// Outer ring that is not rigid (`q_S` of Hajzman).
pub enum Housing {
    /// With a given displacement.
    Displaced(HousingShape),
    /// With a stiffness of its own.
    Bending(BendingRing),
}

/// Radial and axial elements together.
pub(super) struct Lumped<E: ?Sized> {
    pub(super) radial: Box<E>,
    pub(super) axial: Option<Box<E>>,
    /// None where the outer ring is rigid.
    pub(super) housing: Option<Housing>,
}

impl<E: ?Sized> Lumped<E> {
    /// Returns the sum over both kinds of elements.
    fn sum<T: Scalar>(&self, of: impl FnMut(&E) -> Reaction<T>) -> Reaction<T> {
        let kinds = [Some(&self.radial), self.axial.as_ref()].into_iter().flatten();
        kinds.map(Box::as_ref).map(of).fold(Reaction::default(), |sum, one| sum + one)
    }

    /// Returns a bending ring in equilibrium with the elements.
    fn loaded_ring<T: Scalar>(
        &self,
        ring: &BendingRing,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> LoadedRing<T>
    where
        E: ElementForces<T>,
    {
        ring.loaded(at.cage, |points| self.sum(|kind| kind.force_and_stiffness_of_points(u, at, points)))
    }

    pub(super) fn force<T: Scalar>(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>
    where
        E: ElementForces<T>,
    {
        match &self.housing {
            None => self.sum(|kind| kind.force(u, at)),
            Some(Housing::Displaced(shape)) => {
                let mut points = shape.at_elements(at.cage);
                self.sum(|kind| kind.force_on_points(u, at, &mut points))
            }
            Some(Housing::Bending(ring)) => self.loaded_ring(ring, u, at).reaction,
        }
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
        let mut stiffness = Stiffness::from_element(T::ZERO);
        let mut add = |(reaction, k): (Reaction<T>, Stiffness<T>)| {
            stiffness += k;
            reaction
        };
        let on = |points: &mut [HousingPoint<T>], add: &mut dyn FnMut((Reaction<T>, Stiffness<T>)) -> Reaction<T>| {
            self.sum(|kind| add(kind.reaction_and_stiffness_flexible(u, at, points)))
        };
        match &self.housing {
            None => (self.sum(|kind| add(kind.reaction_and_stiffness(u, at))), stiffness),
            Some(Housing::Displaced(shape)) => (on(&mut shape.at_elements(at.cage), &mut add), stiffness),
            Some(Housing::Bending(ring)) => {
                let loaded = self.loaded_ring(ring, u, at);
                on(&mut loaded.points.clone(), &mut add);
                (loaded.reaction, ring.tangent(&loaded, at.cage, stiffness))
            }
        }
    }

    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        if self.housing.is_some() {
            self.element_loads(u, at, loads);
            return self.force(u, at);
        }
        let radial = self.radial.reaction_and_loads(u, at, loads);
        self.axial.iter().fold(radial, |sum, axial| sum + axial.reaction(u, at))
    }

    /// Computes the loads of the radial elements, which show the load zone; on an outer ring that is not rigid, the size of the reaction
    /// of the ring on each element.
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        let points = match &self.housing {
            None => return self.radial.element_loads(u, at, loads),
            Some(Housing::Displaced(shape)) => {
                let mut points = shape.at_elements(at.cage);
                self.sum(|kind| kind.reaction_flexible(u, at, &mut points));
                points
            }
            Some(Housing::Bending(ring)) => self.loaded_ring(ring, u, at).points,
        };
        for (load, point) in loads.iter_mut().zip(&points) {
            let square = point.reaction.iter().map(|r| r.to_f64() * r.to_f64()).sum::<f64>();
            *load = T::from_f64(square.sqrt());
        }
    }
}
