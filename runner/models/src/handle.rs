//! Shared handles of bearings whose model is chosen at run time.
//!
//! Plants take [`AnyBearing`]. The commands that compare precisions and math backends need forces only: [`AnyForceModel`]
//! leaves tangents and element loads of three arithmetics out of the compiled program.

mod force_model;
mod housing;
mod lumped;
mod outer_ring;

pub use force_model::{AnyForceModel, ForceModel};
pub use housing::HousingShape;
pub use lumped::Housing;
use lumped::{Elements, Lumped};
pub use outer_ring::BendingRing;

use crate::simd::{Dispatched, OnWideRegisters};
use ballrace::bearing::flexible::FlexibleRing;
use ballrace::bearing::{Bearing, CageFrame, Mirrored, Reaction};
use ballrace::{BearingKinematicState, Displacement, Math, Scalar, Stiffness};
use std::sync::Arc;

/// A bearing behind a shared pointer.
pub struct Shared<B: ?Sized>(pub Arc<B>);

/// A bearing whose model is chosen at run time.
pub type AnyBearing<T> = Shared<dyn Bearing<T>>;

impl<B: ?Sized> Clone for Shared<B> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T: Scalar, B: Bearing<T> + ?Sized> Bearing<T> for Shared<B> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        self.0.reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.0.element_loads(u, at, loads);
    }
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        self.0.reaction_and_loads(u, at, loads)
    }
    fn reactions(&self, u: &[Displacement<T>], at: &[BearingKinematicState<T>], reactions: &mut [Reaction<T>]) {
        self.0.reactions(u, at, reactions);
    }
}

/// Handle of a bearing that is built at run time.
pub trait BearingHandle<T: Scalar>: Sized {
    /// Elements of one kind, radial or axial, that may be on a flexible ring.
    type Elements;
    /// A math backend as the solver of quasi-static balls uses it here.
    type Registers<M: Math<T>>: Math<T>;

    /// Returns the handle of any bearing.
    fn new(bearing: impl Bearing<T> + 'static) -> Self;
    /// Returns the handle of a bearing that uses the widest SIMD registers of this processor.
    fn dispatched(bearing: impl Bearing<T> + CageFrame<T> + 'static) -> Self;
    /// Returns the handle of the same bearing turned about X by pi.
    fn mirrored(self) -> Self;
    /// Returns elements of one kind.
    fn elements(elements: impl Bearing<T> + FlexibleRing<T> + 'static) -> Self::Elements;
    /// Returns the handle of radial and axial elements together; `housing` is none if the outer ring is rigid.
    fn lumped(radial: Self::Elements, axial: Option<Self::Elements>, housing: Option<Housing>) -> Self;
}

impl<T: Scalar> BearingHandle<T> for AnyBearing<T> {
    type Elements = Box<dyn Elements<T>>;
    type Registers<M: Math<T>> = OnWideRegisters<M>;

    fn new(bearing: impl Bearing<T> + 'static) -> Self {
        Self(Arc::new(bearing))
    }
    fn dispatched(bearing: impl Bearing<T> + CageFrame<T> + 'static) -> Self {
        Self(Arc::new(Dispatched::new(bearing)))
    }
    fn mirrored(self) -> Self {
        Self(Arc::new(Mirrored(self)))
    }
    fn elements(elements: impl Bearing<T> + FlexibleRing<T> + 'static) -> Self::Elements {
        Box::new(elements)
    }
    fn lumped(radial: Self::Elements, axial: Option<Self::Elements>, housing: Option<Housing>) -> Self {
        Self(Arc::new(Lumped { radial, axial, housing }))
    }
}
