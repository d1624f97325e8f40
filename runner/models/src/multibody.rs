//! Multibody model: balls and cage are bodies that `ballrace-multibody` moves. Its forces at rest are those of the quasi-static model.

use crate::construction::BuildError;
use crate::handle::BearingHandle;
use crate::model::{BearingModel, FirmwareModel, LevelOptions, NotCounted};
use crate::quasi_static::{self, QuasiStaticModel};
use crate::solved::Solved;
use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Model, Scene};
use std::sync::Arc;

/// [`Model::Multibody`]
pub(crate) struct MultibodyModel;

impl BearingModel for MultibodyModel {
    fn model(&self) -> Model {
        Model::Multibody
    }
    /// Too slow for a scene that does not name it.
    fn levels(&self, scene: &Scene, _effects: &[&'static str]) -> Vec<LevelOptions> {
        let is_named = scene.bearings.iter().any(|of| of.model == self.model());
        if is_named { vec![LevelOptions::plain(self.model())] } else { vec![] }
    }
    fn solved(&self, of: &BearingScene, steps: Option<u8>) -> Result<Option<Arc<dyn Solved<f64>>>, BuildError> {
        QuasiStaticModel.solved(of, steps)
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        None
    }
    fn counted_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
        QuasiStaticModel.counted_row(of)
    }
}

/// Builds the balls in equilibrium, with the inertia that the reader gives each bearing of this model.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &Scene, of: &BearingScene) -> Result<H, BuildError> {
    quasi_static::build::<T, M, H>(scene, of)
}
