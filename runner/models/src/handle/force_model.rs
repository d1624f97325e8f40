//! Forces of a bearing without its tangent.

use super::lumped::{ElementForces, Lumped};
use super::{AnyBearing, BearingHandle, Housing, Shared};
use ballrace::bearing::flexible::FlexibleRing;
use ballrace::bearing::{Bearing, CageFrame, LastValidWrench, Reaction};
use ballrace::{BearingKinematicState, Displacement, Math, Scalar, Status, Wrench};
use std::sync::Arc;

/// Force of a bearing model on the inner ring.
pub trait ForceModel<T: Scalar>: Send + Sync {
    /// Computes the force as [`Bearing::reaction`] does.
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>;

    /// Computes force and status as [`Bearing::sample`] does.
    fn sample(
        &self,
        last_valid: &mut LastValidWrench<T>,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Wrench<T>, Status) {
        last_valid.update(u.is_finite(), || self.reaction(u, at))
    }

    /// Computes the forces as [`Bearing::reactions`] does.
    fn reactions(&self, u: &[Displacement<T>], at: &[BearingKinematicState<T>], reactions: &mut [Reaction<T>]) {
        for ((u, at), reaction) in u.iter().zip(at).zip(reactions) {
            *reaction = self.reaction(u, at);
        }
    }
}

/// A force model behind a shared pointer.
pub type AnyForceModel<T> = Shared<dyn ForceModel<T>>;

impl<T: Scalar> ForceModel<T> for AnyForceModel<T> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
}

impl<T: Scalar> ForceModel<T> for AnyBearing<T> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
    fn reactions(&self, u: &[Displacement<T>], at: &[BearingKinematicState<T>], reactions: &mut [Reaction<T>]) {
        self.0.reactions(u, at, reactions);
    }
}

/// The force of a bearing.
struct ForceOf<B>(B);

impl<T: Scalar, B: Bearing<T>> ForceModel<T> for ForceOf<B> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
}

/// A force model turned about X by pi.
struct MirroredForce<T: Scalar>(AnyForceModel<T>);

impl<T: Scalar> ForceModel<T> for MirroredForce<T> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let local = self.0.reaction(&u.mirrored(), &at.reversed());
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
}

impl<T: Scalar> ForceModel<T> for Lumped<dyn ElementForces<T>> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.force(u, at)
    }
}

impl<T: Scalar> BearingHandle<T> for AnyForceModel<T> {
    type Elements = Box<dyn ElementForces<T>>;
    // The fixed number of steps of a microcontroller.
    type Registers<M: Math<T>> = M;

    fn new(bearing: impl Bearing<T> + 'static) -> Self {
        Self(Arc::new(ForceOf(bearing)))
    }
    fn dispatched(bearing: impl Bearing<T> + CageFrame<T> + 'static) -> Self {
        Self::new(bearing)
    }
    fn mirrored(self) -> Self {
        Self(Arc::new(MirroredForce(self)))
    }
    fn elements(elements: impl Bearing<T> + FlexibleRing<T> + 'static) -> Self::Elements {
        Box::new(elements)
    }
    fn lumped(radial: Self::Elements, axial: Option<Self::Elements>, housing: Option<Housing>) -> Self {
        Self(Arc::new(Lumped { radial, axial, housing }))
    }
}
