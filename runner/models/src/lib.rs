//! Bearings of the kernel `ballrace`, built from a scene and chosen at run time. This is the only crate that instantiates the kernel's
//! models: with wide registers, in two precisions.
//!
//! Each model is one file with all that depends on it beyond its row of [`Model`]: its construction, its levels of fidelity, its cost and its
//! constants in firmware. [`bearing_model`] returns it. [`mod@build`] converts a scene to kernel types, [`handle`] holds a bearing of any
//! model, [`simd`] runs it on the widest registers of the processor, [`model`] has the interface of a model and the part of the firmware constants that models have in common.
#![forbid(unsafe_code)]

mod angular;
pub mod build;
mod construction;
mod dynamic;
pub mod handle;
mod kinematics;
mod linear;
mod lumped;
pub mod model;
mod multibody;
mod preload;
mod quasi_static;
mod roller;
pub mod simd;
mod solved;
mod tabulated;

use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing, Model, Scene};
use construction::BuildError;
use handle::BearingHandle;
pub use model::{BearingModel, LevelOptions};

/// Defines what is chosen by a model: its interface and its construction.
macro_rules! registry {
    ($($model:ident: $module:ident::$entry:ident by $build:ident,)+) => {
        /// Returns the model.
        #[must_use]
        pub fn bearing_model(model: Model) -> &'static dyn BearingModel {
            match model {
                $(Model::$model => &$module::$entry,)+
            }
        }

        /// Builds the model `model` of one bearing, in any precision and with any math backend.
        fn construct<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
            scene: &Scene,
            of: &Bearing,
            model: Model,
        ) -> Result<H, BuildError> {
            // A bearing with rollers has models of its own.
            match if of.rollers.is_some() { model.for_rollers() } else { model } {
                $(Model::$model => $module::$build::<T, M, H>(scene, of),)+
            }
        }
    };
}

registry! {
    Kinematics: kinematics::KinematicsModel by build,
    Linear: linear::LinearModel by build,
    Lumped: lumped::LumpedModel by build,
    Angular: angular::AngularModel by build,
    Roller: roller::RollerModel by build,
    QuasiStaticRoller: roller::QuasiStaticRollerModel by build_solved,
    Tabulated: tabulated::TabulatedModel by build,
    QuasiStatic: quasi_static::QuasiStaticModel by build,
    Dynamic: dynamic::DynamicModel by build,
    Multibody: multibody::MultibodyModel by build,
}
