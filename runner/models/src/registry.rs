//! Registry of the bearing models.

use crate::construction::BuildError;
use crate::handle::{AnyBearing, AnyForceModel, BearingHandle};
use crate::model::BearingModel;
use crate::{angular, dynamic, linear, lumped, quasi_static, tabulated};
use ballrace::{Exact, Math, Scalar};
use ballrace_scene::{Bearing, Model, Scene};

/// Returns the model.
#[must_use]
pub fn bearing_model(model: Model) -> &'static dyn BearingModel {
    match model {
        Model::Linear => &linear::LinearModel,
        Model::Lumped => &lumped::LumpedModel,
        Model::Angular => &angular::AngularModel,
        Model::Tabulated => &tabulated::TabulatedModel,
        Model::QuasiStatic => &quasi_static::QuasiStaticModel,
        Model::Dynamic => &dynamic::DynamicModel,
    }
}

/// Builds the model `model` of one bearing, in any precision and with any math backend.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &Scene,
    of: &Bearing,
    model: Model,
) -> Result<H, BuildError> {
    match model {
        Model::Linear => linear::build(of),
        Model::Lumped => lumped::build::<T, M, H>(of),
        Model::Angular => angular::build::<T, M, H>(of),
        Model::Tabulated => tabulated::build::<T, M, H>(scene, of),
        Model::QuasiStatic => quasi_static::build::<T, M, H>(of),
        Model::Dynamic => dynamic::build::<T, M, H>(of),
    }
}

/// Builds the model `model` of one bearing. A linear model derived from another one requires the rotor's equilibrium
/// (see `ballrace_plant`) and is rejected here.
///
/// # Errors
/// Returns an error if the scene lacks a value of this model or the kernel rejects one.
pub fn bearing(scene: &Scene, of: &Bearing, model: Model) -> Result<AnyBearing<f64>, BuildError> {
    build::<f64, Exact, _>(scene, of, model)
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
    build::<T, M, _>(scene, of, model)
}
