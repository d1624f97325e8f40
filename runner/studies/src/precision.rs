//! Displacements and kinematic states in another precision.

use ballrace::{BearingKinematicState, Displacement, Scalar};

/// Returns a displacement in the precision `T`.
pub(crate) fn displacement<T: Scalar>(u: &Displacement<f64>) -> Displacement<T> {
    Displacement::from_array(u.to_array().map(T::from_f64))
}

/// Returns a kinematic state in the precision `T`.
pub(crate) fn kinematic_state<T: Scalar>(at: &BearingKinematicState<f64>) -> BearingKinematicState<T> {
    BearingKinematicState {
        cage: at.cage,
        inner: at.inner,
        outer: at.outer,
        ball: at.ball,
        inner_speed: T::from_f64(at.inner_speed),
        outer_speed: T::from_f64(at.outer_speed),
    }
}
