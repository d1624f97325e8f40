//! Diagnosis from vibration sensors (housing acceleration, velocity or force): damage is identified by families of
//! lines in envelope spectra. A recording of sensors alone needs no rotor and no twin; beside displacement probes, the
//! diagnoses of both are joined.

mod component;
mod condition;
mod detector;
mod envelope;
mod family;
pub mod join;
mod onset;
mod picture;
pub(crate) mod rotor;
mod severity;
mod shaft;
pub mod signals;
mod snapshots;
mod spall_width;
mod spectrum;
mod speed;
mod suspect;
#[cfg(test)]
#[expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests;

use crate::plausibility::{Collector, Evidence, implausible};
use ballrace_models::build;
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::Options;
use ballrace_outcome::verdict::verdict;
use ballrace_outcome::{ComparedTwin, Outcome, Pictures, Record, RotorDrawing, Timing};
use ballrace_plant::error::{Result, VibrationError};
use ballrace_recording::flaws::FlawSummary;
use ballrace_recording::rotation::{RotationError, Tracker};
use ballrace_recording::{Reader, Row};
use ballrace_scene::{Recording, Scene, Sensor, Sequence};
use signals::{MIN_TURNS, Signals};
use std::time::Instant;
use suspect::Suspect;

/// Number of rows between two calls of the progress function.
const PROGRESS_ROWS: u64 = 4096;

/// Verdict on a machine whose envelopes show no damage.
pub(crate) const SOUND: &str =
    "No damage of a bearing: no family of lines of its components stands out of the envelope.";

/// Checks that every sensor measures a bearing of the scene.
///
/// # Errors
/// A sensor of another bearing.
pub fn check_bearings(scene: &Scene, recording: &Recording) -> Result<(), VibrationError> {
    let unknown = |s: &&Sensor| s.bearing.as_ref().is_some_and(|name| scene.bearings.iter().all(|b| b.name != *name));
    let Some(sensor) = recording.sensors.iter().find(unknown) else { return Ok(()) };
    let (sensor, found) = (sensor.column.clone(), sensor.bearing.clone().unwrap_or_default());
    Err(VibrationError::Bearing { file: scene.path.clone(), sensor, found })
}

/// Replays `recording`, that of `scene`'s sensors, which has no probes.
///
/// # Errors
/// A shaft angle that cannot be determined, a recording that is too short or cannot be read.
pub fn replay(
    scene: &Scene,
    recording: &Recording,
    mut reader: Reader,
    name: &str,
    options: &Options,
    progress: Option<&(dyn Fn(u64, Option<u64>) + Sync)>,
) -> Result<Outcome> {
    if !scene.limits.is_empty() {
        return Err(VibrationError::Limits { file: scene.path.clone() }.into());
    }
    check_bearings(scene, recording)?;
    if recording.sequence == Some(Sequence::Snapshots) {
        return snapshots::replay(scene, recording, &reader, name, options, progress);
    }
    let rate = reader.rate();
    let begun = Instant::now();
    let Some(mut signals) = Signals::new(recording, rate) else {
        return Err(VibrationError::TooShort { recording: name.to_owned(), found: 0.0, least: MIN_TURNS }.into());
    };
    let mut angle = Angle::new(scene, recording, rate);
    let mut row = angle.tracker.blank();
    let mut rows = 0;
    while reader.next_row(&mut row)? && signals.add(&row) {
        angle.collected.add_row(&row);
        rows += 1;
        let next = angle.tracker.blank();
        angle.push(std::mem::replace(&mut row, next), &mut signals);
        if rows % PROGRESS_ROWS == 0
            && let Some(progress) = progress
        {
            let (read, total) = reader.progress();
            progress(read, total);
        }
    }
    let (angle_source, collected, mut flaws) = angle.finish(&mut signals)?;
    flaws.extend(reader.flaws().summary());
    let samples = signals.samples();
    let suspects = suspects(scene)?;
    let baseline = options.baseline.map(|path| Baseline::read_sensors(path, &recording.sensors)).transpose()?;
    let found = signals.evaluate(scene, baseline.as_ref())?;
    if found.turns < MIN_TURNS {
        return Err(
            VibrationError::TooShort { recording: name.to_owned(), found: found.turns, least: MIN_TURNS }.into()
        );
    }
    let collected = &collected;
    let mut implausible =
        implausible(&Evidence { scene, rate_hz: rate, collected, limits: None, rotation: None, samples: &[] });
    let overridden = if options.force_diagnosis { std::mem::take(&mut implausible) } else { vec![] };
    let diagnoses = if implausible.is_empty() { found.diagnoses } else { vec![] };
    let verdict = match (implausible.is_empty(), &found.not_judged) {
        (false, _) => verdict(&[], (&ComparedTwin::default(), &[]), &implausible, &[], (None, None), 0),
        (true, Some(reason)) => format!("No verdict: {reason}."),
        (true, None) => {
            let sentence = diagnoses.first().map_or(SOUND, |diagnosis| &diagnosis.sentence);
            // Every line is at a multiple of the speed.
            let further = [&found.foreign, &found.speed, &found.rotor, &found.severity].into_iter().flatten();
            further.fold(sentence.to_owned(), |verdict, sentence| format!("{verdict} {sentence}"))
        }
    };
    let [least, mean, greatest] = found.speeds_hz.map(|hz| hz * 60.0);
    let record = Record {
        samples: rows,
        compared: rows,
        rate_hz: rate,
        duration_s: samples as f64 / rate,
        turns: found.turns,
        mean_speed_rpm: mean,
        min_speed_rpm: least,
        max_speed_rpm: greatest,
        angle_source,
        ..Record::default()
    };
    let mut notes = vec![
        "Vibration without a twin: forces and displacements are not computed, damage is diagnosed from envelope spectra."
            .to_owned(),
    ];
    notes.extend(overridden.iter().map(|one| format!("Not plausible, diagnosed all the same: {one}.")));
    notes.extend(found.notes);
    notes.extend([found.foreign, found.speed, found.rotor, found.severity].into_iter().flatten());
    notes.extend(reader.notes());
    let mut timing = Timing { samples: rows, ..Timing::default() };
    timing.wall_s = begun.elapsed().as_secs_f64();
    timing.times_real_time = record.duration_s / timing.wall_s.max(1e-9);
    timing.sample_period_ns = (1e9 / rate) as u64;
    Ok(Outcome {
        scene: scene.name.clone(),
        recording: name.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        verdict,
        record,
        bearings: suspects.iter().map(Suspect::outcome).collect(),
        sensors: found.sensors,
        timing,
        implausible,
        not_judged: found.not_judged.into_iter().collect(),
        diagnoses,
        flaws,
        notes,
        learned: Baseline::of_sensors(&scene.name, name, found.learned),
        pictures: Pictures { envelopes: found.envelopes, rotor: RotorDrawing::new(scene), ..Pictures::default() },
        ..Outcome::default()
    })
}

/// Shaft angle of the rows.
struct Angle<'a> {
    scene: &'a Scene,
    recording: &'a Recording,
    rate: f64,
    tracker: Tracker,
    collected: Collector,
    flaws: Vec<FlawSummary>,
    /// Last interruption.
    error: Option<RotationError>,
    has_angle: bool,
}

impl<'a> Angle<'a> {
    fn new(scene: &'a Scene, recording: &'a Recording, rate: f64) -> Self {
        let tracker = Tracker::of(recording, rate, scene.shaft.speed);
        let collected = Collector::new(recording, scene.shaft.speed);
        Self { scene, recording, rate, tracker, collected, flaws: vec![], error: None, has_angle: false }
    }

    fn push(&mut self, row: Row, signals: &mut Signals) {
        let pushed = self.tracker.push(row);
        self.drain(signals);
        if let Err(error) = pushed {
            self.error = Some(error);
            self.flaws.extend(self.tracker.flaws().summary());
            self.tracker = Tracker::of(self.recording, self.rate, self.scene.shaft.speed);
            signals.interrupt();
        }
    }

    fn drain(&mut self, signals: &mut Signals) {
        while let Some(sample) = self.tracker.pop() {
            self.has_angle = true;
            self.collected.add_sample(&sample);
            signals.add_angle(&sample);
            self.tracker.recycle(sample.row);
        }
    }

    /// Returns the source of the angle in words, the figures of readings and speed, and the flaws.
    ///
    /// # Errors
    /// No sample with an angle.
    fn finish(mut self, signals: &mut Signals) -> Result<(String, Collector, Vec<FlawSummary>)> {
        let finished = self.tracker.finish();
        self.drain(signals);
        if !self.has_angle
            && let Some(error) = finished.err().or(self.error)
        {
            return Err(error.into());
        }
        self.flaws.extend(self.tracker.flaws().summary());
        Ok((self.tracker.source(), self.collected, self.flaws))
    }
}

fn suspects(scene: &Scene) -> Result<Vec<Suspect>> {
    let suspect = |b: &ballrace_scene::Bearing| {
        let kinematics = build::kinematics(scene, b)?;
        let mut orders = kinematics.orders;
        // The forces of rollers do not use their spin; the catalogue has it.
        if let Some(catalogue) = b.catalogue.as_ref().filter(|_| !kinematics.spin_known) {
            orders.ball_spin = catalogue.listed.entry.orders().ball_spin * (1.0 - kinematics.outer_ratio).abs();
        }
        Ok(Suspect { name: b.name.clone(), station: scene.drawn_station(b.station), orders, elements: b.elements })
    };
    scene.bearings.iter().map(suspect).collect()
}
