//! Life of a bearing under the loads of its elements along a recording.

use crate::elements::BearingElements;
use crate::equilibrium::resting;
use crate::life::{BearingLife, MeanLoads, Rated, moving};
use ballrace::{BearingKinematicState, Displacement};
use ballrace_models::build;
use ballrace_outcome::LifeOutcome;
use ballrace_plant::error::Result;
use ballrace_scene::{Bearing as BearingScene, Scene};
use std::f64::consts::TAU;

/// Accumulates the loads of a bearing over a recording.
///
/// Loads of different times are combined as those of different elements: by the mean of their powers, weighted by the revolutions of the rings
/// against each other. The memory does not grow with the recording.
pub struct RecordedLife {
    of: BearingScene,
    elements: BearingElements,
    loads: MeanLoads,
    /// Weighted sum of `P_r^p`; `None` where the factors of `P_r` are not listed.
    equivalent: Option<f64>,
    /// Sum of the revolutions per second of one ring relative to the other, 1/s.
    turning: f64,
    samples: u64,
}

impl RecordedLife {
    /// Creates the sums of a bearing; `None` where its contacts are not known.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of the model or the kernel rejects one.
    pub fn try_new(scene: &Scene, of: &BearingScene) -> Result<Option<Self>> {
        let Some(rated) = Rated::of(of)? else { return Ok(None) };
        let plain = build::bearing(scene, of, of.evaluated_model())?;
        let at = resting(scene, of)?;
        Ok(Some(Self {
            elements: BearingElements::try_new(scene, of, &plain)?,
            of: of.clone(),
            loads: MeanLoads::new(rated, moving([at.inner_speed, at.outer_speed])),
            equivalent: Some(0.0),
            turning: 0.0,
            samples: 0,
        }))
    }

    /// Adds a sample: the displacement of the inner ring against the outer ring with the preload, and the force there.
    pub fn add(&mut self, u: &Displacement<f64>, force: &[f64; 5], at: &BearingKinematicState<f64>) {
        let turning = (at.inner_speed - at.outer_speed).abs() / TAU;
        self.loads.add_elements(&self.elements.loads(u, at), turning);
        let rated = self.loads.rated();
        let load = rated.equivalent(&self.of, force);
        self.equivalent = self.equivalent.zip(load).map(|(sum, load)| sum + turning * load.powf(rated.power()));
        self.turning += turning;
        self.samples += 1;
    }

    /// Returns the ratings and the life for an outcome.
    #[must_use]
    pub fn outcome(&self) -> Option<LifeOutcome> {
        let life = self.life()?;
        let hours = |turns: Option<f64>| turns.and_then(|turns| life.hours(turns));
        Some(LifeOutcome {
            dynamic_rating_n: life.dynamic_rating,
            static_rating_n: life.static_rating,
            reference_load_n: life.reference_load,
            reference_life_h: hours(life.reference_life),
            viscosity_ratio: life.modified.map(|modified| modified.viscosity_ratio),
            modification_factor: life.modified.and_then(|modified| modified.factor),
            modified_life_h: hours(life.modified.and_then(|modified| modified.life)),
            equivalent_load_n: life.equivalent_load,
            basic_life_h: hours(life.basic_life),
        })
    }

    /// Returns the life at the mean speed; `None` before the first sample and at rest.
    fn life(&self) -> Option<BearingLife> {
        let load = |sum: f64| (sum / self.turning).powf(1.0 / self.loads.rated().power());
        let turning = self.turning / self.samples as f64;
        (self.turning > 0.0).then(|| self.loads.life(&self.of, self.equivalent.map(load), turning))
    }
}
