//! A bearing without model, for vibration sensors alone: it has no forces, no levels of fidelity and no constants.

use crate::construction::{BuildError, check_has_forces, invalid};
use crate::handle::BearingHandle;
use crate::model::{BearingModel, FirmwareModel, LevelOptions, NotCounted};
use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Model, Scene};

/// [`Model::Kinematics`]
pub(crate) struct KinematicsModel;

impl BearingModel for KinematicsModel {
    fn model(&self) -> Model {
        Model::Kinematics
    }
    fn levels(&self, _: &Scene, _: &[&'static str]) -> Vec<LevelOptions> {
        vec![]
    }
    fn firmware(&self, _: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        None
    }
    fn counted_row(&self, _: &BearingScene) -> Result<&'static str, NotCounted> {
        Err(NotCounted::Law)
    }
}

/// Returns the error of a bearing without forces.
#[expect(clippy::extra_unused_type_parameters, reason = "the parameters of every model")]
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &Scene, of: &BearingScene) -> Result<H, BuildError> {
    check_has_forces(scene, of)?;
    Err(invalid(of, "model", Model::Kinematics.name(), "a model with forces"))
}
