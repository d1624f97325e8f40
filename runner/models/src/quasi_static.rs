//! Quasi-static model: every ball in equilibrium between both races, solved ball by ball.

use crate::construction::{BuildError, Shared, contact_geometry, facing, features, named, places};
use crate::firmware::{FirmwareModel, NotCounted};
use crate::handle::BearingHandle;
use crate::registry::{BearingModel, LevelOptions};
use crate::simd::OnWideRegisters;
use crate::tabulated::TabulatedModel;
use ballrace::bearing::quasi_static::film::{Film, InletHeating, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, Inertia, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallPosition, BallState, DEFAULT_NEWTON_STEPS, QuasiStatic};
use ballrace::bearing::surface::{Surface, SurfaceDeviation};
use ballrace::bearing::{Bearing, ElementLayout, Mirrored, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, Model, Scene};
use std::sync::Arc;

/// Newton steps of a cold solution that are compared.
const COMPARED_STEPS: [u8; 4] = [3, 4, 5, 6];

/// [`Model::QuasiStatic`]
pub struct QuasiStaticModel;

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
    fn cortex_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
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

/// Returns the parameters of the balls' inertia.
#[must_use]
pub fn inertia_params(scene: &BearingScene) -> InertiaParams {
    InertiaParams {
        density: scene.geometry.map_or(0.0, |g| g.density),
        centrifugal: scene.effects.centrifugal,
        gyroscopic: scene.effects.gyroscopic,
        race_control: match scene.effects.control {
            ballrace_scene::RaceControl::Outer => RaceControl::Outer,
            ballrace_scene::RaceControl::Inner => RaceControl::Inner,
        },
        friction_sharing: match scene.effects.sharing {
            ballrace_scene::FrictionSharing::Outer => FrictionSharing::Outer,
            ballrace_scene::FrictionSharing::Equal => FrictionSharing::Equal,
            ballrace_scene::FrictionSharing::Proportional => FrictionSharing::Proportional,
        },
    }
}

/// A quasi-static bearing with any of its effects, and its internal states.
pub trait Solved<T: Scalar>: Bearing<T> {
    /// Writes the state of each ball, up to the length of `states`.
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]);

    /// Sets the balls to the positions of a cold start.
    fn initial_ball_positions(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, balls: &mut [BallPosition<T>]);

    /// Returns the reaction, with the solution started from the balls' last positions.
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T>;
}

impl<T, M, P, I, F, S> Solved<T> for QuasiStatic<T, M, P, I, F, S>
where
    T: Scalar,
    M: Math<T>,
    P: ElementLayout<T>,
    I: Inertia<T>,
    F: Film<T>,
    S: Surface<T>,
{
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        QuasiStatic::ball_states(self, u, at, states);
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        QuasiStatic::initial_ball_positions(self, u, at, balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        QuasiStatic::warm_started_reaction(self, u, at, balls)
    }
}

impl<T: Scalar> Solved<T> for Mirrored<Shared<dyn Solved<T>>> {
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        self.0.0.ball_states(&u.mirrored(), &at.reversed(), states);
        // Angles count towards +Z of the scene.
        for state in states {
            let turned = |[cos, sin]: [T; 2]| [cos, -sin];
            state.inner_direction = turned(state.inner_direction);
            state.outer_direction = turned(state.outer_direction);
            state.orbital_speed = -state.orbital_speed;
        }
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        self.0.0.initial_ball_positions(&u.mirrored(), &at.reversed(), balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        let local = self.0.0.warm_started_reaction(&u.mirrored(), &at.reversed(), balls);
        Reaction { wrench: local.wrench.mirrored(), ..local }
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
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &BearingScene) -> Result<H, BuildError> {
    Ok(facing(scene, H::new(unmirrored::<T, H::Registers<M>>(scene, steps(scene))?)))
}

fn steps(scene: &BearingScene) -> u8 {
    scene.solver_steps.unwrap_or(DEFAULT_NEWTON_STEPS)
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

/// Returns the oil of the film, where that is an effect of the scene.
pub fn lubricant(scene: &BearingScene) -> Option<(Lubricant, Option<InletHeating>)> {
    let oil = scene.effects.film?;
    Some((oil.for_film(), oil.inlet_heating.map(ballrace_scene::InletHeating::of_film)))
}
