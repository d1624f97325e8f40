//! Plausibility: whether a recording can be one of the scene's machine. Nothing is diagnosed on a recording that fails a check.
//!
//! The checks compare the readings with each other and with the limits of the bearings, and the shaft angle with the lines of
//! the readings. They need no motion of the twin; the two checks that do are made at the end of a replay.

mod checks;
mod lines;
pub mod range;
mod readings;

pub use checks::ReadingLimits;
pub use lines::of_designations;
pub use readings::{Collector, ReadingSummary, VoltageSummary};

use ballrace_outcome::Implausibility;
use ballrace_recording::Sample;
use ballrace_recording::rotation::RotationError;
use ballrace_scene::Scene;

/// Data that the checks compare with the scene.
pub struct Evidence<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Figures of readings and speed.
    pub collected: &'a Collector,
    /// Limits of the readings; none where nothing bounds them.
    pub limits: Option<ReadingLimits>,
    /// Reason why the shaft angle is not known, where it is not.
    pub rotation: Option<&'a RotationError>,
    /// Consecutive samples.
    pub samples: &'a [Sample],
}

/// Returns everything about a recording that is not plausible.
pub fn implausible(evidence: &Evidence) -> Vec<Implausibility> {
    let mut all = checks::of_readings(evidence);
    all.extend(lines::of_lines(evidence));
    all
}

/// Returns everything about a scene that is not plausible.
pub fn implausible_scene(scene: &Scene) -> Vec<Implausibility> {
    checks::directions(scene).into_iter().collect()
}

/// Returns everything about consecutive samples that is not plausible; `period` is that of the samples, s.
pub fn implausible_samples(scene: &Scene, samples: &[Sample], period: f64) -> Vec<Implausibility> {
    let Some(recording) = &scene.recording else { return vec![] };
    let mut collected = Collector::new(recording, scene.shaft.speed);
    for sample in samples {
        collected.add_row(&sample.row);
        collected.add_sample(sample);
    }
    let (collected, rate_hz) = (&collected, 1.0 / period);
    implausible(&Evidence { scene, rate_hz, collected, limits: None, rotation: None, samples })
}
