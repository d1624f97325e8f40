//! Look ahead: the first rows of a recording are read and diagnosed before the twin starts, so that twin, observer and residual
//! have the angle and slip of every cage, which no scene contains.

use super::notices::Notices;
use super::range::ReadingRange;
use crate::diagnosis::block::Block;
use crate::diagnosis::{self, DiagnosisInput, DiagnosisResult};
use crate::error::Result;
use crate::outcome::baseline::Baseline;
use crate::outcome::{Calibration, Implausibility};
use crate::plant::Plant;
use crate::plausibility::implausible_samples;
use crate::recording::rotation::Tracker;
use crate::recording::run_out::RunOut;
use crate::recording::{Reader, Row, Sample};
use crate::scene::{Recording, Scene};
use std::collections::VecDeque;
use std::sync::Arc;

/// Largest number of samples, averaged ones counted once, that are read ahead.
const MAX_ROWS: usize = 1 << 18;

/// The beginning of a recording.
pub(super) struct Ahead {
    /// Rows read, in order.
    pub rows: VecDeque<Row>,
    /// The recording has no further row.
    pub is_whole: bool,
    samples: Vec<Sample>,
    /// Sample period, s.
    period: f64,
}

impl Ahead {
    /// Reads as many rows as a diagnosis takes, after `first_rows`, which are read already.
    pub fn read(
        scene: &Scene,
        plant: &Plant,
        recording: &Recording,
        reader: &mut Reader,
        run_out: Option<Arc<RunOut>>,
        mut first_rows: VecDeque<Row>,
    ) -> Result<Self> {
        let rate = reader.rate();
        let mut tracker = Tracker::of(recording, rate, scene.shaft.speed).with_run_out(run_out);
        let (mut range, mut notices) = (ReadingRange::try_new(scene, plant, &recording.probes)?, Notices::default());
        let mut block = Block::default();
        let mut rows = VecDeque::new();
        let mut is_whole = false;
        let mut has_angle = true;
        while !block.is_full() && rows.len() < MAX_ROWS * recording.average as usize {
            let row = match first_rows.pop_front() {
                Some(row) => row,
                None => {
                    let mut row = Row::default();
                    if !reader.next_row(&mut row)? {
                        is_whole = true;
                        break;
                    }
                    row
                }
            };
            if has_angle {
                has_angle = tracker.push(row.clone()).is_ok();
                while let Some(mut sample) = tracker.pop() {
                    range.check_sample(&mut sample, &mut notices);
                    block.add(&sample);
                }
            }
            rows.push_back(row);
        }
        if is_whole && has_angle && tracker.finish().is_ok() {
            while let Some(mut sample) = tracker.pop() {
                range.check_sample(&mut sample, &mut notices);
                block.add(&sample);
            }
        }
        rows.append(&mut first_rows);
        let period = f64::from(recording.average) / rate;
        Ok(Self { rows, is_whole, samples: block.into_samples(), period })
    }

    /// Returns everything about the samples read that is not plausible.
    pub fn implausible(&self, scene: &Scene) -> Vec<Implausibility> {
        implausible_samples(scene, &self.samples, self.period)
    }

    /// Returns the total revolutions at the first sample.
    pub fn first_turns(&self) -> f64 {
        self.samples.first().map_or(0.0, Sample::total_revolutions)
    }

    /// Diagnoses the samples read; none where they do not allow it.
    pub fn diagnose(
        &self,
        scene: &Scene,
        plant: &Plant,
        recording: &Recording,
        calibration: Option<&Calibration>,
        progress: &dyn Fn(f64),
    ) -> Result<Option<DiagnosisResult>> {
        if diagnosis::not_applicable(scene, &self.samples).is_some() {
            return Ok(None);
        }
        Ok(diagnosis::diagnose(&self.material(scene, plant, recording, calibration), progress)?)
    }

    /// Calibrates the scene; none where the samples do not allow it.
    pub fn calibrate(
        &self,
        scene: &Scene,
        plant: &Plant,
        recording: &Recording,
        earlier: Option<&Calibration>,
    ) -> Result<Option<Calibration>> {
        if diagnosis::not_applicable(scene, &self.samples).is_some() {
            return Ok(None);
        }
        Ok(diagnosis::calibrate(&self.material(scene, plant, recording, earlier))?)
    }

    fn material<'a>(
        &'a self,
        scene: &'a Scene,
        plant: &'a Plant,
        recording: &'a Recording,
        calibration: Option<&'a Calibration>,
    ) -> DiagnosisInput<'a> {
        let (probes, samples) = (&recording.probes, &self.samples);
        DiagnosisInput { scene, plant, probes, samples, period: self.period, calibration }
    }
}

/// Returns the scene with the parameters of its baseline.
pub(super) fn calibrated(scene: &Scene, baseline: Option<&Baseline>) -> Scene {
    match baseline.and_then(|baseline| baseline.calibration.as_ref()) {
        Some(calibration) => calibration.scene(scene),
        None => scene.clone(),
    }
}
