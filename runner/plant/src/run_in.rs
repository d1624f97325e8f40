//! Run-in of a twin: it starts in static equilibrium and runs at a constant speed until its transient has decayed.

use super::plant_error::Result;
use super::{Plant, Twin};
use ballrace::Phase;
use ballrace::rotor::ShaftMotion;
use std::f64::consts::TAU;

/// A twin at a constant speed whose transient decays, sample by sample.
pub struct RunIn {
    twin: Box<dyn Twin>,
    /// Shaft motion at the end.
    drive: ShaftMotion<f64>,
    /// Sample period, s.
    sample_period: f64,
    /// Number of all samples.
    samples: f64,
    /// Number of samples so far.
    passed: u64,
}

impl RunIn {
    /// Starts a twin at rest, [`Plant::settling_time`] before the shaft is at `revolutions`, at the speed of `drive`.
    ///
    /// # Errors
    /// A parameter that the kernel rejects.
    pub fn try_new(plant: &Plant, sample_period: f64, revolutions: f64, drive: &ShaftMotion<f64>) -> Result<Self> {
        Self::longer(plant, sample_period, revolutions, drive, 0)
    }

    /// Starts a twin at rest, `more` samples before [`Self::try_new`] does.
    ///
    /// # Errors
    /// As of [`Self::try_new`].
    pub fn longer(
        plant: &Plant,
        sample_period: f64,
        revolutions: f64,
        drive: &ShaftMotion<f64>,
        more: u64,
    ) -> Result<Self> {
        let samples = (plant.settling_time() / sample_period).ceil() + more as f64;
        let before = samples * sample_period * drive.speed / TAU;
        let twin = plant.start(sample_period, revolutions - before)?;
        Ok(Self { twin, drive: ShaftMotion { acceleration: 0.0, ..*drive }, sample_period, samples, passed: 0 })
    }

    /// Advances the twin by one sample; returns false at the end of the run-in.
    pub fn advance(&mut self) -> bool {
        if self.left() == 0 {
            return false;
        }
        let left = (self.samples - self.passed as f64) * self.sample_period * self.drive.speed / TAU;
        self.passed += 1;
        self.twin
            .step(&ShaftMotion { angle: self.drive.angle.wrapping_add(Phase::from_revolutions(-left)), ..self.drive });
        true
    }

    /// Returns the number of samples to the end.
    #[must_use]
    pub fn left(&self) -> u64 {
        (self.samples as u64).saturating_sub(self.passed)
    }

    /// Returns the coordinates of the twin.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        self.twin.coordinates()
    }

    /// Returns the twin.
    #[must_use]
    pub fn into_twin(self) -> Box<dyn Twin> {
        self.twin
    }
}
