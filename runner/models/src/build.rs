//! Conversion of a scene to kernel types: what programs call.

pub use crate::construction::*;
pub use crate::dynamic::{Balls, moving_balls};
pub use crate::handle::{AnyBearing, AnyForceModel, Shared};
pub use crate::linear::{linearised, spring_of};
pub use crate::lumped::{Exponent, law};
pub use crate::preload::{loaded, mounted_offset, offset_as_mounted, preload_force, preloaded};
pub use crate::quasi_static::{quasi_static, solved_in};
pub use crate::roller::{BearingRollers, RollerStates, roller_states};
pub use crate::solved::Solved;
pub use crate::tabulated::{DESKTOP_TABLE, FIRMWARE_TABLE, TableSize, of_table, table};

use ballrace::{Exact, Math, Scalar};
use ballrace_scene::{Bearing, Model, Scene};

/// Builds the model `model` of one bearing. A linear model derived from another one requires the rotor's equilibrium
/// (see `ballrace_plant`) and is rejected here.
///
/// # Errors
/// Returns an error if the scene lacks a value of this model or the kernel rejects one.
pub fn bearing(scene: &Scene, of: &Bearing, model: Model) -> Result<AnyBearing<f64>, BuildError> {
    crate::construct::<f64, Exact, _>(scene, of, model)
}

/// Builds the force of the model `model` of one bearing, in any precision and with any math backend.
///
/// # Errors
/// As [`bearing`].
pub fn force_model<T: Scalar, M: Math<T>>(
    scene: &Scene,
    of: &Bearing,
    model: Model,
) -> Result<AnyForceModel<T>, BuildError> {
    crate::construct::<T, M, _>(scene, of, model)
}
