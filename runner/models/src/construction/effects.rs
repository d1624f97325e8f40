//! Effects of the scene on balls in equilibrium.

use ballrace::bearing::quasi_static::film::{InletHeating, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace_scene::Bearing as BearingScene;

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

/// Returns the oil of the film, where that is an effect of the scene.
pub fn lubricant(scene: &BearingScene) -> Option<(Lubricant, Option<InletHeating>)> {
    let oil = scene.effects.film?;
    Some((oil.for_film(), oil.inlet_heating.map(ballrace_scene::InletHeating::of_film)))
}
