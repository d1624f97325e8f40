//! A bearing on the rotor.

use super::machine::nothing;
use super::plant_error::Result;
use super::warm::{ColdAndFew, Held, WARM_STEPS, Warm};
use ballrace::bearing::quasi_static::BallState;
use ballrace::rotor::{ComponentAngles, ShaftMotion};
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_models::bearing_model;
pub use ballrace_models::build::Balls;
use ballrace_models::build::{self, AnyBearing, Kinematics};
use ballrace_multibody::{MultibodyBearing, Params};
use ballrace_scene::{Bearing as BearingScene, Model, ModelProperties, Scene};
use std::sync::Arc;

/// A bearing on the rotor, ready to be evaluated.
#[derive(Clone)]
pub struct MountedBearing {
    /// Name in the scene.
    pub name: String,
    /// Station along Z from the centre of mass, m.
    pub station: f64,
    /// Number of rolling elements.
    pub elements: usize,
    /// Azimuth of each element with the cage at angle 0.
    pub element_azimuths: Vec<Phase>,
    /// Speeds of its parts and orders.
    pub kinematics: Kinematics,
    /// Displacement by preload and tilt of the outer ring.
    pub offset: Displacement<f64>,
    /// The scene's model; for moving balls the lumped model, which is their limit without mass.
    pub bearing: AnyBearing<f64>,
    /// Description of the model.
    pub description: String,
    /// Balls that are coordinates of the system.
    pub balls: Option<Balls>,
    /// Balls and cage that are bodies beside the coordinates.
    pub multibody: Option<Arc<MultibodyBearing>>,
    /// The quasi-static model for a cold start, and with the few solver steps of a warm start.
    solved: Option<ColdAndFew>,
}

impl MountedBearing {
    /// Creates the mounted bearing of a scene.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of the model or the kernel rejects one.
    pub fn new(scene: &Scene, bearing: &BearingScene) -> Result<Self> {
        // A model that is linearised is replaced by its tangent once the rotor's equilibrium is known.
        let model = bearing.evaluated_model();
        let mut kinematics = build::kinematics(scene, bearing)?;
        if !model.has_elements() {
            kinematics.cage_ratio = 0.0;
        }
        let ModelProperties { moving_elements: is_moving, bodies: is_multibody, .. } = *model.properties();
        let (loaded, offset) = loaded(scene, bearing, model)?;
        Ok(Self {
            name: bearing.name.clone(),
            station: bearing.station,
            elements: bearing.elements,
            element_azimuths: (0..bearing.elements).map(|j| build::element_azimuth(bearing, j)).collect(),
            kinematics,
            offset,
            bearing: loaded,
            description: describe(bearing),
            solved: solved(bearing)?,
            balls: (is_moving && !is_multibody).then(|| build::moving_balls(scene, bearing)).transpose()?,
            multibody: is_multibody
                .then(|| Params::of(scene, bearing).map(MultibodyBearing::new))
                .transpose()?
                .map(Arc::new),
        })
    }

    /// Returns the kinematic state of the bearing for component angles `parts` and shaft motion `drive`.
    #[must_use]
    pub fn rotation(&self, parts: ComponentAngles, drive: &ShaftMotion<f64>) -> BearingKinematicState<f64> {
        self.kinematics.speed_ratios().kinematic_state(parts, drive)
    }

    /// Returns the azimuth of each element with the cage at `cage`.
    pub fn azimuths(&self, cage: Phase) -> impl Iterator<Item = Phase> {
        self.element_azimuths.iter().map(move |azimuth| cage.wrapping_add(*azimuth))
    }

    /// Replaces the bearing.
    pub fn replace(&mut self, bearing: AnyBearing<f64>) {
        self.bearing = bearing;
        self.solved = None;
    }

    /// Returns the bearing without memory of earlier samples.
    #[must_use]
    pub fn cold(&self) -> AnyBearing<f64> {
        self.bearing.clone()
    }

    /// Returns the bearing for one machine at rest.
    pub(crate) fn resting(&self) -> Held {
        Held::Plain(self.cold())
    }

    /// Returns the bearing for one twin in which the bodies of other bearings move: none where it has bodies itself.
    pub(crate) fn beside_bodies(&self) -> Held {
        if self.multibody.is_some() { nothing() } else { self.moving() }
    }

    /// Returns the states of balls in equilibrium at a displacement without preload; none for another model.
    pub(crate) fn ball_states(&self, u: Displacement<f64>, at: &BearingKinematicState<f64>) -> Vec<BallState<f64>> {
        let Some(solved) = &self.solved else { return vec![] };
        let mut states = vec![BallState::default(); self.elements];
        solved.cold.ball_states(&(u + self.offset), at, &mut states);
        states
    }

    /// Returns the bearing for one twin: the quasi-static one starts from its last ball positions.
    pub(crate) fn moving(&self) -> Held {
        match &self.solved {
            Some(solved) => Held::Warm(Box::new(Warm::new(solved.clone(), self.offset, self.elements))),
            None => self.resting(),
        }
    }
}

fn solved(bearing: &BearingScene) -> Result<Option<ColdAndFew>> {
    let model = bearing_model(bearing.model);
    let (cold, few) = (model.solved(bearing, None)?, model.solved(bearing, Some(WARM_STEPS))?);
    Ok(cold.zip(few).map(|(cold, few)| ColdAndFew { cold, few }))
}

/// Returns the bearing with its preload and the tilt of its outer ring, and the displacement by these.
fn loaded(scene: &Scene, bearing: &BearingScene, model: Model) -> Result<(AnyBearing<f64>, Displacement<f64>)> {
    let plain = build::bearing(scene, bearing, model)?;
    match build::mounted_offset(scene, bearing, &plain)? {
        Some(offset) => Ok((build::preloaded(plain, offset), offset)),
        None => Ok((plain, Displacement::default())),
    }
}

fn describe(bearing: &BearingScene) -> String {
    let damage = if bearing.defect.is_empty() { "" } else { ", damaged" };
    let designation =
        bearing.catalogue.as_ref().map_or_else(String::new, |used| format!("{}, ", used.listed.entry.designation));
    format!("{designation}{}, {} elements{damage}", bearing.model.name(), bearing.elements)
}
