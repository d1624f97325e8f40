//! Dynamic model: elements with a mass of their own, which are coordinates of the system. Its forces at rest are those of the lumped model.

use crate::construction::{BuildError, geometry, invalid, kinematics, places};
use crate::handle::BearingHandle;
use crate::lumped::{self, LumpedModel, law};
use crate::model::{BearingModel, LevelOptions};
use crate::model::{FirmwareModel, NotCounted};
use ballrace::bearing::ElementPosition;
use ballrace::contact::hertz::Race;
use ballrace::rotor::MovingBallsParams;
use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Model, Scene};

/// [`Model::Dynamic`]
pub(crate) struct DynamicModel;

impl BearingModel for DynamicModel {
    fn model(&self) -> Model {
        Model::Dynamic
    }
    /// Its damping has no default: it is a level of a scene that has it.
    fn levels(&self, scene: &Scene, _effects: &[&'static str]) -> Vec<LevelOptions> {
        let has_damping = scene.bearings.iter().any(|of| of.model == self.model());
        if has_damping { vec![LevelOptions::plain(self.model())] } else { vec![] }
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        None
    }
    fn counted_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
        LumpedModel.counted_row(of)
    }
}

/// Builds the quasi-static limit of moving balls.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &Scene, of: &BearingScene) -> Result<H, BuildError> {
    lumped::build::<T, M, H>(scene, of)
}

/// The moving balls of the `dynamic` model.
#[derive(Clone)]
pub struct Balls {
    /// Parameters of the kernel.
    pub params: MovingBallsParams,
    /// Damping of each ball's radial motion, N s/m.
    pub damping: f64,
    /// Positions at cage angle 0.
    pub places: Vec<ElementPosition<f64>>,
}

/// Returns the moving balls of a bearing with the `dynamic` model.
///
/// # Errors
/// Returns an error if the bearing has no geometry, from which mass and contact stiffness of the balls follow.
pub fn moving_balls(scene: &Scene, of: &BearingScene) -> Result<Balls, BuildError> {
    let Some(geometry) = geometry(of)? else {
        return Err(invalid(of, "model dynamic", "no geometry", "ball_diameter and the others"));
    };
    let gravity = scene.rotor.as_ref().map_or([0.0; 3], |r| r.gravity);
    let density = of.geometry.map_or(0.0, |g| g.density);
    let (_, _, radial_play) = law(of)?;
    Ok(Balls {
        params: MovingBallsParams {
            stiffness: [Race::Inner, Race::Outer].map(|race| geometry.contact(race).stiffness),
            pitch_radius: 0.5 * geometry.pitch_diameter,
            radial_play,
            ball_mass: density * std::f64::consts::PI / 6.0 * geometry.ball_diameter.powi(3),
            cage_ratio: kinematics(scene, of)?.cage_ratio,
            gravity: [gravity[0], gravity[1]],
        },
        damping: of.own("element_damping").unwrap_or(0.0),
        places: places(of),
    })
}
