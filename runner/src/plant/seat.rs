//! A bearing in its place on the rotor.

use crate::scene::build::{self, AnyBearing, Kinematics};
use crate::scene::{Bearing as BearingScene, Linear, Model, Scene};
use anyhow::Result;
use ballrace::bearing::Bearing;
use ballrace::rotor::{Drive, MovingBallsParams, PartAngles};
use ballrace::{Displacement, Exact, Rotation, Wrench};

/// A bearing on the rotor, ready to be evaluated.
#[derive(Clone)]
pub struct Seat {
    /// The scene's name.
    pub name: String,
    /// Along Z from the centre of mass, m.
    pub station: f64,
    /// Rolling elements.
    pub elements: usize,
    /// Azimuth of element 1 with the cage at angle 0, rad.
    pub first_azimuth: f64,
    /// How the elements go round.
    pub kinematics: Kinematics,
    /// Displacement by preload, before anything moves.
    pub offset: Displacement<f64>,
    /// The scene's model; of moving balls the lumped one that they become without mass.
    pub bearing: AnyBearing<f64>,
    /// The model in words.
    pub description: String,
    /// Balls that are coordinates of the system.
    pub balls: Option<Balls>,
}

/// What the `dynamic` model needs besides.
#[derive(Clone)]
pub struct Balls {
    /// As the kernel takes them.
    pub params: MovingBallsParams,
    /// N s/m on each ball's radial motion.
    pub damping: f64,
    /// Where they stand with the cage at angle 0.
    pub places: Vec<ballrace::bearing::Place<f64>>,
}

impl Seat {
    /// The seat of one bearing of a scene.
    ///
    /// # Errors
    /// What the scene does not say for the model, or the kernel refuses.
    pub fn new(scene: &Scene, bearing: &BearingScene) -> Result<Self> {
        let model = match (bearing.model, &bearing.linear) {
            // Made from the other model first, replaced once the rotor's rest is known.
            (Model::Linear, Some(Linear::Of(source))) => *source,
            (model, _) => model,
        };
        let moving = bearing.model != Model::Linear || matches!(bearing.linear, Some(Linear::Of(_)));
        let mut kinematics = build::kinematics(scene, bearing)?;
        if !moving {
            kinematics.cage_ratio = 0.0;
        }
        let (seated, offset) = seated(scene, bearing, model)?;
        Ok(Self {
            name: bearing.name.clone(),
            station: bearing.station,
            elements: bearing.elements,
            first_azimuth: bearing.first_element_azimuth,
            kinematics,
            offset,
            bearing: seated,
            description: describe(bearing),
            balls: (model == Model::Dynamic).then(|| build::moving_balls(scene, bearing)).transpose()?,
        })
    }

    /// What the bearing sees with its parts at `parts` and the shaft as `drive` says.
    #[must_use]
    pub fn rotation(&self, parts: PartAngles, drive: &Drive<f64>) -> Rotation<f64> {
        self.kinematics.gear().rotation(parts, drive)
    }

    /// Force on the inner ring at a displacement of the rotor's centre of mass, the outer ring at rest.
    #[must_use]
    pub fn wrench(&self, pose: &Displacement<f64>, at: &Rotation<f64>) -> Wrench<f64> {
        self.bearing.reaction(&pose.at_station(self.station), at).wrench
    }
}

/// The bearing with its preload: displaced as given, or until it answers with the force given.
fn seated(scene: &Scene, bearing: &BearingScene, model: Model) -> Result<(AnyBearing<f64>, Displacement<f64>)> {
    let plain = build::bearing::<f64, Exact>(scene, bearing, model)?;
    match build::preload_offset(scene, bearing, &plain)? {
        Some(offset) => Ok((build::preloaded(plain, offset), offset)),
        None => Ok((plain, Displacement::default())),
    }
}

fn describe(bearing: &BearingScene) -> String {
    let damage = if bearing.defect.is_empty() { "" } else { ", damaged" };
    format!("{}, {} elements{damage}", bearing.model.name(), bearing.elements)
}
