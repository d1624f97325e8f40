//! Registry of the bearing models.

use crate::construction::BuildError;
use crate::firmware::{FirmwareModel, NotCounted};
use crate::handle::BearingHandle;
use crate::quasi_static::Solved;
use crate::{angular, dynamic, linear, lumped, quasi_static, tabulated};
use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing, Model, Scene};
use std::sync::Arc;

/// All that depends on a bearing model beyond the keys of a scene, whose properties are [`Model::properties`], and its construction.
pub trait BearingModel: Sync {
    /// Returns the model.
    fn model(&self) -> Model;

    /// Returns the levels of fidelity of this model for a scene, in the order of cost; `effects` are those of the scene.
    fn levels(&self, _scene: &Scene, _effects: &[&'static str]) -> Vec<LevelOptions> {
        vec![LevelOptions::plain(self.model())]
    }

    /// Returns the model with its balls in equilibrium in `steps` Newton steps, else in those of the scene; `None` for a model that is
    /// evaluated without iteration.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of this model or the kernel rejects one.
    fn solved(&self, _of: &Bearing, _steps: Option<u8>) -> Result<Option<Arc<dyn Solved<f64>>>, BuildError> {
        Ok(None)
    }

    /// Returns true where a bearing with one of its elements alone is cheap to build.
    fn has_cheap_elements(&self) -> bool {
        true
    }

    /// Returns the model by which the displacement of a preload is computed.
    fn preload_model(&self) -> Model {
        self.model()
    }

    /// Returns the constants of a bearing in firmware; `None` where it has none.
    fn firmware(&self, of: &Bearing) -> Option<&'static dyn FirmwareModel>;

    /// Returns the name of a smooth bearing in the table of costs on a Cortex-M4F.
    ///
    /// # Errors
    /// Returns the reason where the table has no similar bearing.
    fn cortex_row(&self, of: &Bearing) -> Result<&'static str, NotCounted>;
}

/// Options of a level of fidelity.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LevelOptions {
    /// Name of the level.
    pub name: String,
    /// Effects of the scene that are kept.
    pub effects: Vec<&'static str>,
    /// Newton steps of a cold start, where not the kernel's own number.
    pub steps: Option<u8>,
    /// Intervals of the table.
    pub intervals: Option<[i64; 3]>,
}

impl LevelOptions {
    /// Returns the level of a model without options.
    pub(crate) fn plain(model: Model) -> Self {
        Self { name: model.name().to_owned(), ..Self::default() }
    }
}

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
