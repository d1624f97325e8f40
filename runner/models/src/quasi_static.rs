//! Quasi-static model: every ball in equilibrium between both races, solved ball by ball.

use crate::construction::{BuildError, contact_geometry, facing, features, inertia_params, lubricant, named, places};
use crate::handle::{BearingHandle, Shared};
use crate::model::{BearingModel, LevelOptions};
use crate::model::{FirmwareModel, NotCounted};
use crate::simd::OnWideRegisters;
use crate::solved::Solved;
use crate::tabulated::TabulatedModel;
use ballrace::bearing::Mirrored;
use ballrace::bearing::quasi_static::{DEFAULT_NEWTON_STEPS, QuasiStatic};
use ballrace::bearing::surface::SurfaceDeviation;
use ballrace::{Exact, Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, Model, Scene};
use std::sync::Arc;

/// Newton steps of a cold solution that are compared.
const COMPARED_STEPS: [u8; 4] = [3, 4, 5, 6];

/// [`Model::QuasiStatic`]
pub(crate) struct QuasiStaticModel;

impl BearingModel for QuasiStaticModel {
    fn model(&self) -> Model {
        Model::QuasiStatic
    }
    /// From no effect to all; with all of them also in few steps.
    fn levels(&self, _scene: &Scene, effects: &[&'static str]) -> Vec<LevelOptions> {
        let mut levels = Vec::new();
        for kept in 0..=effects.len() {
            let named = effects.get(..kept).unwrap_or_default().to_vec();
            let names = if named.is_empty() { "no effects".to_owned() } else { named.join(", ") };
            let name = format!("{}, {names}", Model::QuasiStatic.name());
            let base = LevelOptions { name, effects: named, ..LevelOptions::default() };
            if kept == effects.len() {
                levels.extend(COMPARED_STEPS.map(|steps| LevelOptions {
                    name: format!("{}, {steps} steps", base.name),
                    steps: Some(steps),
                    ..base.clone()
                }));
            }
            levels.push(base);
        }
        levels
    }
    fn solved(&self, of: &BearingScene, steps: Option<u8>) -> Result<Option<Arc<dyn Solved<f64>>>, BuildError> {
        steps.map_or_else(|| quasi_static(of), |steps| solved_in(of, steps)).map(Some)
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        Some(&TabulatedModel)
    }
    fn counted_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
        let e = &of.effects;
        let plain =
            e.control == ballrace_scene::RaceControl::Outer && e.sharing == ballrace_scene::FrictionSharing::Outer;
        match (e.centrifugal, e.gyroscopic, e.film.is_some()) {
            (false, false, false) => Ok("quasi-static, no effects"),
            (true, false, false) => Ok("quasi-static, centrifugal"),
            (_, true, false) if plain => Ok("quasi-static, gyroscopic"),
            (_, true, false) => Ok("quasi-static, gyroscopic, any control"),
            (_, true, true) if plain => Ok("quasi-static, gyroscopic, film"),
            _ => Err(NotCounted::Effects),
        }
    }
}

/// Builds the quasi-static model of one bearing.
///
/// # Errors
/// Returns an error if the scene lacks a value of this model or the kernel rejects one.
pub fn quasi_static(scene: &BearingScene) -> Result<Arc<dyn Solved<f64>>, BuildError> {
    solved_in(scene, steps(scene))
}

/// Builds the quasi-static model with another number of Newton steps.
///
/// # Errors
/// As [`quasi_static`].
pub fn solved_in(scene: &BearingScene, steps: u8) -> Result<Arc<dyn Solved<f64>>, BuildError> {
    let built: Arc<dyn Solved<f64>> = Arc::new(unmirrored::<f64, OnWideRegisters<Exact>>(scene, steps)?);
    Ok(if scene.facing == Facing::MinusZ { Arc::new(Mirrored(Shared(built))) } else { built })
}

/// Builds the quasi-static model of a bearing.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(_: &Scene, scene: &BearingScene) -> Result<H, BuildError> {
    Ok(facing(scene, H::new(unmirrored::<T, H::Registers<M>>(scene, steps(scene))?)))
}

fn steps(scene: &BearingScene) -> u8 {
    scene.own("solver_steps").map_or(DEFAULT_NEWTON_STEPS, |steps| steps as u8)
}

/// Returns the quasi-static model, facing +Z.
fn unmirrored<T: Scalar, M: Math<T>>(scene: &BearingScene, steps: u8) -> Result<impl Solved<T> + 'static, BuildError> {
    let (geometry, zero) = contact_geometry(scene, "quasi-static")?;
    let built = QuasiStatic::<T, M, _>::try_new(geometry, places(scene), zero)
        .and_then(|b| b.with_selected_inertia(&inertia_params(scene)))
        .and_then(|b| b.with_selected_film(lubricant(scene)))
        .map_err(|e| named(scene, e))?;
    let surface = SurfaceDeviation::<M, _>::new(features(scene));
    Ok(built.with_newton_steps(steps).with_surface(surface))
}
