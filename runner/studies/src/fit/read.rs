//! Samples of a recording for a fit.

use super::turns_of;
use ballrace_diagnosis::block::Block;
use ballrace_plant::error::{FitError, Result};
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_recording::{Reader, Sample};
use ballrace_scene::Scene;

/// Largest number of samples of a fit.
const MAX_SAMPLES: usize = 1 << 17;

/// Samples of a recording.
#[derive(Debug)]
pub struct RecordingSamples {
    /// Samples of the fit.
    pub samples: Vec<Sample>,
    /// Consecutive samples with a reading of every probe, from which the cages are estimated.
    pub cage_samples: Vec<Sample>,
}

/// Reads the first `turns` turns of a recording, and as many as the cages need.
///
/// # Errors
/// Returns an error if the scene has no recording or the recording cannot be read.
pub fn read(scene: &Scene, mut reader: Reader, turns: f64) -> Result<RecordingSamples> {
    let Some(recording) = &scene.recording else {
        return Err(FitError::NoRecording { file: scene.path.clone() }.into());
    };
    let mut tracker = Tracker::of(recording, reader.rate(), scene.shaft.speed).with_run_out(RunOut::of(scene)?);
    let mut samples: Vec<Sample> = Vec::new();
    let mut block = Block::default();
    let mut row = tracker.blank();
    let long = |all: &[Sample]| match all {
        [first, .., last] => (turns_of(last) - turns_of(first)).abs() >= turns || all.len() >= MAX_SAMPLES,
        _ => false,
    };
    let mut take = |tracker: &mut Tracker, samples: &mut Vec<Sample>| {
        while let Some(sample) = tracker.pop() {
            if !block.is_full() {
                block.add(&sample);
            }
            if !long(samples) {
                samples.push(sample);
            }
        }
        block.is_full() && long(samples)
    };
    let (mut is_done, mut count) = (false, 0);
    while !is_done && count < MAX_SAMPLES * recording.average as usize && reader.next_row(&mut row)? {
        tracker.push(row)?;
        is_done = take(&mut tracker, &mut samples);
        row = tracker.blank();
        count += 1;
    }
    if !is_done {
        tracker.finish()?;
        take(&mut tracker, &mut samples);
    }
    Ok(RecordingSamples { samples, cage_samples: block.into_samples() })
}
