//! Look ahead: the first rows of a recording are read and diagnosed before the twin starts, so that twin, observer and residual
//! have the angle and slip of every cage, which no scene contains.

use super::notices::{Notices, check_sample};
use ballrace_diagnosis::block::Block;
use ballrace_diagnosis::plausibility::implausible_samples;
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_diagnosis::{self as diagnosis, Calibrated, CalibrationPlan, DiagnosisInput, DiagnosisResult};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::{Calibration, Implausibility};
use ballrace_plant::Plant;
use ballrace_plant::error::Result;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_recording::{Reader, Row, Sample};
use ballrace_scene::{Recording, Scene};
use std::collections::VecDeque;
use std::sync::Arc;

/// Largest number of samples, averaged ones counted once, that are read ahead.
const MAX_ROWS: usize = 1 << 18;
/// Number of samples up to which a recording is read to its end, so that one diagnosis is that of its end and serves its twin.
const MAX_WHOLE_SAMPLES: usize = 1 << 16;

/// The beginning of a recording.
pub(super) struct Ahead {
    /// Rows read, in order.
    pub rows: VecDeque<Row>,
    /// The recording has no further row.
    pub is_whole: bool,
    /// The recording is longer than the block that is diagnosed.
    pub is_longer_than_block: bool,
    samples: Vec<Sample>,
    /// Sample period, s.
    period: f64,
}

impl Ahead {
    /// Reads as many rows as a diagnosis takes, or a short recording to its end, after `first_rows`, which are read already.
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
        let mut first_block: Option<Block> = None;
        let average = recording.average as usize;
        while rows.len() < average * if first_block.is_some() { MAX_WHOLE_SAMPLES } else { MAX_ROWS } {
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
                    check_sample(&mut range, &mut sample, &mut notices);
                    block.add(&sample);
                }
            }
            rows.push_back(row);
            if first_block.is_none() && block.is_full() {
                first_block = Some(block.clone());
            }
        }
        if is_whole && has_angle && tracker.finish().is_ok() {
            while let Some(mut sample) = tracker.pop() {
                check_sample(&mut range, &mut sample, &mut notices);
                block.add(&sample);
            }
        }
        rows.append(&mut first_rows);
        let period = f64::from(recording.average) / rate;
        let is_longer_than_block = first_block.is_some();
        let block = first_block.filter(|_| !is_whole).unwrap_or(block);
        Ok(Self { rows, is_whole, is_longer_than_block, samples: block.into_samples(), period })
    }

    /// Returns everything about the samples read that is not plausible.
    pub fn implausible(&self, scene: &Scene) -> Vec<Implausibility> {
        implausible_samples(scene, &self.samples, self.period)
    }

    /// Returns the total revolutions at the first sample.
    pub(crate) fn first_turns(&self) -> f64 {
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
        plan: &CalibrationPlan<'_>,
    ) -> Result<Option<Calibrated>> {
        if diagnosis::not_applicable(scene, &self.samples).is_some() {
            return Ok(None);
        }
        Ok(diagnosis::calibrate(&self.material(scene, plant, recording, earlier), plan)?)
    }

    fn material<'a>(
        &'a self,
        scene: &'a Scene,
        plant: &'a Plant,
        recording: &'a Recording,
        calibration: Option<&'a Calibration>,
    ) -> DiagnosisInput<'a> {
        let (probes, samples) = (&recording.probes, &self.samples);
        DiagnosisInput { scene, plant, probes, samples, period: self.period, calibration, is_corrected: false }
    }
}

/// Returns the scene with the parameters of its baseline.
pub(super) fn calibrated(scene: &Scene, baseline: Option<&Baseline>) -> Scene {
    match baseline.and_then(|baseline| baseline.calibration.as_ref()) {
        Some(calibration) => diagnosis::calibrated_scene(calibration, scene),
        None => scene.clone(),
    }
}
