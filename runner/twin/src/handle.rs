//! Shared handles of bearings whose model is chosen at run time.

use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Scalar, Stiffness};
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
}
