//! Replay of a recording through the bearing models and the digital twin, sample by sample.
//!
//! The modules follow the path of a sample from the row of the recording to the verdict. The twin and the observer come before
//! location and force, because location takes the axial coordinate from the twin where there is no axial probe, and the force
//! is evaluated at the observer's displacement.
#![forbid(unsafe_code)]

// The beginning of a recording is diagnosed first: angle and slip of the cages.
mod ahead;

// A row becomes a sample with a shaft angle.
mod session;
// The stages: those up to the observer (`pipeline`, `follow`), and those behind it (`evaluate`).
mod evaluate;
mod follow;
mod pipeline;

// Readings before the sample waits for the twin.
mod background;
mod readings;
mod repeat;
mod running_diagnosis;
mod running_vibration;
mod standstill;
mod startup;
mod temperature;

// The sample passes through the stages.
mod align;
pub mod comparison;
mod force;
mod locate;
mod observe;
mod twin;

// Indicators.
mod cascade;
mod deflection;
mod excerpt;
mod history;
mod lines;
mod pictures;
pub mod second;
mod statistics;
mod trend;

// Limits and notices.
pub mod limits;
pub mod notices;

// Sinks.
mod forces_file;
mod samples;
pub mod snapshot;
pub mod timing;

// The outcome at the end of the recording.
mod conclusion;
#[cfg(test)]
mod harness;
mod list;
mod plausibility;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
mod totals;

// Use: a check of a scene, a table of machines, records of a running monitor, vectors for balancing.
pub mod check;
pub mod draft;
pub mod fleet;
pub mod record;
pub mod vectors;

pub use ballrace_outcome::baseline;
pub use ballrace_outcome::options::{BackgroundSchedule, Options, Progress, Source};
pub use ballrace_outcome::{self as outcome, verdict};
pub use running_diagnosis::{DiagnosisState, FaultState};
pub use session::{Replay, Update};
pub use snapshot::Snapshot;

use ahead::Ahead;
use ballrace_base::time_limit::TimeLimit;
use ballrace_diagnosis::vibration;
use ballrace_diagnosis::{CalibrationPlan, calibrated_scene, set_cages};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::{Outcome, ParameterName};
use ballrace_plant::error::{Error, ReplayError, Result};
use ballrace_plant::{Plant, only_observable, unbalance_note};
use ballrace_recording::Reader;
use ballrace_recording::clock::check_rate;
use ballrace_recording::run_out::RunOut;
use ballrace_scene::Scene;
use std::path::Path;
use std::time::Instant;

/// Number of rows between two calls of the progress function.
const PROGRESS_ROWS: u64 = 4096;

/// Opens the recording of a scene, or the recording `file` with the columns of the scene; returns its reader and its path.
///
/// # Errors
/// A scene without a recording, a file that cannot be read as one.
pub fn open<'a>(scene: &'a Scene, file: Option<&'a Path>) -> Result<(Reader<'static>, &'a Path)> {
    let Some(recording) = &scene.recording else {
        return Err(ReplayError::NoRecording { file: scene.path.clone() }.into());
    };
    let path = file.unwrap_or(&recording.file);
    Ok((Reader::open(path, recording)?, path))
}

/// Replays `reader` through the bearings and the twin of the scene.
///
/// # Errors
/// A scene without rotor or recording, probes that do not determine the motion, a recording that cannot be used.
pub fn replay(scene: &Scene, mut reader: Reader, recording_name: &str, options: &Options) -> Result<Outcome> {
    let Some(recording) = &scene.recording else {
        return Err(ReplayError::NoRecording { file: scene.path.clone() }.into());
    };
    if recording.probes.is_empty() {
        let read = |read, total| {
            if let Some(progress) = options.progress {
                progress(Progress::Read(read, total));
            }
        };
        return vibration::replay(scene, recording, reader, recording_name, options, Some(&read));
    }
    check_rate(reader.rate(), recording, scene.shaft.speed).map_err(|e| e.of(scene, recording_name))?;
    only_observable(scene, "replay").map_err(Error::setup)?;
    let baseline = options.baseline.map(Baseline::parse).transpose().map_err(Error::setup)?;
    let (given, first_rows) = temperature::corrected(scene, recording, &mut reader, recording_name)?;
    let mut scene = ahead::calibrated(&given, baseline.as_ref());
    let mut plant = Plant::try_new(&scene).map_err(Error::setup)?;
    let run_out = RunOut::of(&given)?;
    let mut ahead = Ahead::read(&scene, &plant, recording, &mut reader, run_out.clone(), first_rows)?;
    let advance = |share: f64| {
        if let Some(progress) = options.progress {
            progress(Progress::Diagnosis(share));
        }
    };
    let mut calibration = baseline.and_then(|baseline| baseline.calibration);
    let begun = Instant::now();
    let implausible = ahead.implausible(&scene);
    let is_diagnosed = options.force_diagnosis || implausible.is_empty();
    let mut learning = None;
    if options.learn && is_diagnosed {
        // An error of the scene is no fault of the machine.
        let begin = |round: usize| {
            if let Some(progress) = options.progress {
                progress(Progress::Learning(round));
            }
        };
        let plan = CalibrationPlan {
            parameters: &ParameterName::ALL,
            begin: &begin,
            time_limit: options.learning_time.map(TimeLimit::start),
        };
        let found = ahead.calibrate(&scene, &plant, recording, calibration.as_ref(), &plan)?;
        learning = found.as_ref().map(|found| found.learning(&given));
        // A recording that the parameters do not describe is compared with the scene as it was.
        if let Some(found) = found.filter(|_| learning.as_ref().is_some_and(|learning| learning.taken)) {
            scene = calibrated_scene(&found.calibration, &scene);
            plant = Plant::try_new(&scene).map_err(Error::setup)?;
            calibration = Some(found.calibration);
        }
    }
    let diagnosed = match is_diagnosed {
        true => ahead.diagnose(&scene, &plant, recording, calibration.as_ref(), &advance)?,
        false => None,
    };
    let took = begun.elapsed();
    drop(plant);
    if let Some(diagnosis) = &diagnosed {
        set_cages(&mut scene, &diagnosis.cages, ahead.first_turns());
    }
    // Without a baseline, a run-out is not told from what an unbalance does. Of a part of a recording, only the errors of the baseline are
    // those of all of it.
    let is_known = calibration.as_ref().is_some_and(|calibration| !calibration.readings.is_empty());
    let run_out = match diagnosed.as_ref().filter(|_| ahead.is_whole && is_known) {
        Some(diagnosis) => session::with_errors(run_out, &diagnosis.readings, "found by the diagnosis"),
        None => session::with_baseline(run_out, calibration.as_ref()),
    };
    let mut replay = Replay::with_run_out(&scene, recording, reader.rate(), options, run_out)?;
    let note = unbalance_note(&given).filter(|_| calibration.is_some());
    replay.set_calibration(calibration, note);
    replay.set_learning(learning);
    replay.add_diagnosis_time(took);
    if let Some(diagnosis) = diagnosed {
        if ahead.is_longer_than_block {
            replay.follow_cages(&diagnosis.cages);
        }
        if ahead.is_whole {
            replay.set_diagnosis(diagnosis);
        }
    }
    let mut rows = 0;
    replay.run(|row| {
        if rows % PROGRESS_ROWS == 0
            && let Some(progress) = options.progress
        {
            let (read, total) = reader.progress();
            progress(Progress::Read(read, total));
        }
        rows += 1;
        match ahead.rows.pop_front() {
            Some(first) => *row = first,
            None => return Ok(reader.next_row(row)?),
        }
        Ok(true)
    })?;
    replay.add_notes(reader.notes());
    if options.force_diagnosis {
        replay.override_checks(implausible);
    }
    replay.finish(recording_name, reader.flaws().summary())
}
