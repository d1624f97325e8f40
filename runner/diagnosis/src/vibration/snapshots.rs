//! Snapshots: short recordings of the sensors at one speed, with an unknown time between them.
//!
//! The squared envelope of each snapshot has its own spectrum, in segments that never extend over two files. Power
//! spectra of segments at equal speed have the same expectation, so they are averaged; signals are not joined, because
//! the phase between two files is unknown. Averaging does not improve the resolution of snapshots with fewer than 16
//! revolutions.

use super::component::in_words;
use super::detector::FaultDetector;
use super::envelope::{Rotation, SensorSpectra, Transforms};
use super::onset::{growth, tenth};
use super::signals::{MIN_TURNS, Signals, statistics};
use super::suspect::Suspect;
use super::{SOUND, suspects};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::Options;
use ballrace_outcome::{
    Diagnosis, FaultKind, LineLevel, Outcome, Pictures, Record, RotorDrawing, SnapshotFigures, SnapshotOutcome,
    SnapshotTrend, Timing,
};
use ballrace_plant::error::{Result, VibrationError};
use ballrace_recording::error::RecordingError;
use ballrace_recording::files::{listed, shown, time_in_name};
use ballrace_recording::{Reader, Row};
use ballrace_scene::{Clock, Recording, Scene, Sensor, Speed};
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

/// Largest relative difference between the sampling rates of two snapshots.
const RATE_TOLERANCE: f64 = 1e-3;

/// Replays the files of `first`, which is the reader of the first readable one.
///
/// # Errors
/// A speed that changes, no readable file.
pub fn replay(
    scene: &Scene,
    recording: &Recording,
    first: &Reader,
    name: &str,
    options: &Options,
    progress: Option<&(dyn Fn(u64, Option<u64>) + Sync)>,
) -> Result<Outcome> {
    let Speed::Constant(speed) = scene.shaft.speed else {
        return Err(VibrationError::SnapshotSpeed { file: scene.path.clone() }.into());
    };
    let begun = Instant::now();
    let (turn_hz, rate) = (speed.abs() / TAU, first.rate());
    let suspects = suspects(scene)?;
    let baseline = options.baseline.map(|path| Baseline::read_sensors(path, &recording.sensors)).transpose()?;
    let rotation = Rotation { turn_hz, fastest_hz: turn_hz, revolutions: None };
    let baseline = baseline.as_ref().filter(|baseline| !baseline.sensors.is_empty());
    let detector = FaultDetector { suspects: &suspects, rotation, rate, baseline, is_speed_measured: false };
    let mut evaluation = Evaluation::new(&detector, recording, first.files().paths.len());
    // Files of another layout may be the last of the folder: the tenths are those of the readable files.
    let mut readable = vec![];
    for (i, path) in first.files().paths.iter().enumerate() {
        match Reader::open_file(path, recording) {
            Ok(_) => readable.push((i, path)),
            Err(error) => evaluation.left_out.push((i, shown(path), reason(path, &error))),
        }
    }
    evaluation.readable = readable.len();
    for (position, (i, path)) in readable.into_iter().enumerate() {
        if let Err(reason) = evaluation.add(i, position, path, rate) {
            evaluation.left_out.push((i, shown(path), reason));
        }
        if let Some(progress) = progress {
            progress(i as u64 + 1, Some(first.files().paths.len() as u64));
        }
    }
    let mut outcome = evaluation.conclude(&suspects);
    outcome.scene.clone_from(&scene.name);
    name.clone_into(&mut outcome.recording);
    outcome.learned = Baseline { scene: scene.name.clone(), recording: name.to_owned(), ..outcome.learned };
    outcome.notes.splice(1..1, first.notes());
    outcome.pictures.rotor = RotorDrawing::new(scene);
    outcome.timing.wall_s = begun.elapsed().as_secs_f64();
    outcome.timing.times_real_time = outcome.record.duration_s / outcome.timing.wall_s.max(1e-9);
    Ok(outcome)
}

/// Evaluation of the snapshots so far. Signals are held for one snapshot only.
struct Evaluation<'a> {
    detector: &'a FaultDetector<'a>,
    recording: &'a Recording,
    /// Number of files.
    files: usize,
    /// Number of files that can be opened.
    readable: usize,
    /// Samples of each snapshot that are evaluated: those of the first.
    samples: Option<usize>,
    snapshots: Vec<SnapshotOutcome>,
    /// Number of the file, its name, reason.
    left_out: Vec<(usize, String, String)>,
    /// First snapshot with flaws, its first flaw, and the number of such snapshots.
    flaws: Option<(String, String, usize)>,
    /// Snapshots of the open group.
    group: usize,
    group_spectra: Vec<Option<SensorSpectra>>,
    /// First snapshot and levels of each complete group, by sensor.
    groups: Vec<(usize, Vec<Vec<LineLevel>>)>,
    /// Snapshots of the verdict.
    judged: usize,
    judged_spectra: Vec<Option<SensorSpectra>>,
    transforms: Transforms,
}

impl<'a> Evaluation<'a> {
    fn new(detector: &'a FaultDetector<'a>, recording: &'a Recording, files: usize) -> Self {
        let empty = || recording.sensors.iter().map(|_| None).collect();
        Self {
            detector,
            recording,
            files,
            readable: files,
            samples: None,
            snapshots: vec![],
            left_out: vec![],
            flaws: None,
            group: 0,
            group_spectra: empty(),
            groups: vec![],
            judged: 0,
            judged_spectra: empty(),
            transforms: Transforms::default(),
        }
    }

    /// Returns the revolutions of the shaft in a snapshot.
    fn turns(&self) -> f64 {
        self.samples.map_or(0.0, |samples| samples as f64 / self.detector.rate * self.detector.rotation.turn_hz)
    }

    /// Returns the number of snapshots that together have the revolutions of a verdict.
    fn group_size(&self) -> usize {
        (MIN_TURNS / self.turns()).ceil().clamp(1.0, 1e9) as usize
    }

    /// Adds the snapshot of file `i`, readable file `position`; the error is the reason why it is omitted.
    fn add(&mut self, i: usize, position: usize, path: &Path, rate: f64) -> Result<(), String> {
        let (signals, first_stamp) = self.read(path, rate)?;
        let samples = *self.samples.get_or_insert(signals.samples());
        if signals.samples() < samples {
            return Err(format!("{} rows, expected {samples} as in the first", signals.samples()));
        }
        let mut snapshot = SnapshotOutcome {
            number: i + 1,
            file: shown(path),
            time: time_in_name(path).map(|time| time.to_string()),
            first_stamp_s: first_stamp,
            sensors: vec![],
        };
        let mut parts: Vec<&[f64]> = vec![];
        for (sensor, signal) in signals.signals() {
            let signal = signal.get(..samples).unwrap_or_default();
            let of = statistics(signal);
            if !(of.rms > 0.0 && of.rms.is_finite()) {
                return Err(format!("no signal of {}", sensor.column));
            }
            let (rms, crest_factor, kurtosis) = (of.rms, of.crest_factor, of.kurtosis);
            let (sensor, peak) = (sensor.column.clone(), rms * crest_factor);
            let figures = SnapshotFigures { sensor, rms, peak, crest_factor, kurtosis, lines: vec![] };
            snapshot.sensors.push(figures);
            parts.push(signal);
        }
        let is_judged = position + tenth(self.readable).max(self.group_size()) >= self.readable;
        for (k, signal) in parts.into_iter().enumerate() {
            let Some(spectra) = self.detector.spectra(signal, &mut self.transforms) else { continue };
            SensorSpectra::average(&mut self.group_spectra[k], &spectra);
            if is_judged {
                SensorSpectra::average(&mut self.judged_spectra[k], &spectra);
            }
        }
        self.judged += usize::from(is_judged);
        self.snapshots.push(snapshot);
        self.group += 1;
        if self.group == self.group_size() {
            self.close_group();
        }
        Ok(())
    }

    fn read(&mut self, path: &Path, rate: f64) -> Result<(Signals, Option<f64>), String> {
        let text = |error: RecordingError| reason(path, &error);
        let mut reader = Reader::open_file(path, self.recording).map_err(text)?;
        if (reader.rate() / rate - 1.0).abs() > RATE_TOLERANCE {
            return Err(format!("sampling rate {} Hz, expected {rate} Hz within 0.1 %", reader.rate()));
        }
        let mut signals = Signals::new(self.recording, rate).ok_or("no sensor")?;
        let (mut row, mut first_stamp) = (Row::default(), None);
        while reader.next_row(&mut row).map_err(text)? && signals.add(&row) {
            if matches!(self.recording.clock, Clock::Column { .. }) {
                first_stamp.get_or_insert(row.time);
            }
        }
        if let Some(flaw) = reader.flaws().summary().first() {
            let flaws = self.flaws.get_or_insert_with(|| (shown(path), flaw.sentence.clone(), 0));
            flaws.2 += 1;
        }
        Ok((signals, first_stamp))
    }

    /// Computes the levels of the lines from the snapshots of the group.
    fn close_group(&mut self) {
        let first = self.snapshots.len() - self.group;
        let of = |(sensor, spectra): (&Sensor, &Option<SensorSpectra>)| {
            spectra.as_ref().map(|spectra| self.detector.levels(sensor, spectra)).unwrap_or_default()
        };
        let levels: Vec<Vec<LineLevel>> = self.recording.sensors.iter().zip(&self.group_spectra).map(of).collect();
        for snapshot in self.snapshots.iter_mut().skip(first) {
            for (figures, lines) in snapshot.sensors.iter_mut().zip(&levels) {
                figures.lines.clone_from(lines);
            }
        }
        self.groups.push((first, levels));
        self.group = 0;
        self.group_spectra.iter_mut().for_each(|spectra| *spectra = None);
    }

    /// Returns the trends of all indicators.
    fn trends(&self) -> Vec<SnapshotTrend> {
        let lines = |k: usize| self.groups.first().and_then(|group| group.1.get(k)).map_or(0, Vec::len);
        let sensors = self.recording.sensors.iter().enumerate();
        let count: usize = sensors.clone().map(|(k, _)| SnapshotFigures::FIELDS.len() + lines(k)).sum();
        let mut trends = vec![];
        for (k, sensor) in sensors {
            let trend = |indicator: &str, growth_db, onset: Option<&SnapshotOutcome>| SnapshotTrend {
                sensor: sensor.column.clone(),
                indicator: indicator.replace('_', "-"),
                bearing: None,
                component: None,
                growth_db,
                onset: onset.map(|snapshot| snapshot.number),
            };
            for field in SnapshotFigures::FIELDS {
                let figures = self.snapshots.iter().filter_map(|s| s.sensors.get(k));
                let values: Vec<f64> = figures.map(field.value).collect();
                if let Some(grown) = growth(&values, count) {
                    let onset = grown.onset.and_then(|i| self.snapshots.get(i));
                    trends.push(trend(field.key, 20.0 * (grown.last / grown.first).log10(), onset));
                }
            }
            for i in 0..lines(k) {
                let line = |group: &(usize, Vec<Vec<LineLevel>>)| group.1.get(k)?.get(i).cloned();
                let of_line: Vec<LineLevel> = self.groups.iter().filter_map(line).collect();
                let values: Vec<f64> = of_line.iter().map(|line| line.level_db).collect();
                if let (Some(grown), Some(line)) = (growth(&values, count), of_line.first()) {
                    let group = grown.onset.and_then(|i| self.groups.get(i));
                    let onset = group.and_then(|(first, _)| self.snapshots.get(*first));
                    trends.push(SnapshotTrend {
                        bearing: Some(line.bearing.clone()),
                        component: Some(line.component),
                        ..trend("line", grown.last - grown.first, onset)
                    });
                }
            }
        }
        trends
    }

    fn conclude(self, suspects: &[Suspect]) -> Outcome {
        let (turns, rate, turn_hz) = (self.turns(), self.detector.rate, self.detector.rotation.turn_hz);
        let trends = self.trends();
        let mut notes = vec![
            "Snapshots of vibration without a twin: damage is diagnosed from envelope spectra, averaged over the last snapshots."
                .to_owned(),
            format!(
                "Each snapshot has {turns:.2} revolutions; the verdict is on {} snapshots ({:.1} revolutions), each level of a line on {}.",
                self.judged,
                self.judged as f64 * turns,
                self.group_size()
            ),
        ];
        notes.extend(self.note_left_out());
        if let Some((file, sentence, count)) = &self.flaws {
            notes.push(format!("{count} snapshots have flaws; the first is {file}: {sentence}"));
        }
        notes.extend(self.note_resolution(suspects));
        let least_rate = self.detector.least_rate();
        let not_judged = if self.judged as f64 * turns < MIN_TURNS {
            let found = self.judged as f64 * turns;
            Some(format!("{found:.1} revolutions of the shaft in the last snapshots, expected {MIN_TURNS} or more"))
        } else if rate < least_rate {
            Some(format!(
                "the rate of {rate:.0} Hz has no band with the lines of the bearings, expected {least_rate:.0} Hz or more"
            ))
        } else {
            None
        };
        let sensors: Vec<_> = self.recording.sensors.iter().zip(self.judged_spectra).collect();
        let judgement = self.detector.judge(&sensors);
        let (mut diagnoses, learned, envelopes) = (judgement.diagnoses, judgement.learned, judgement.envelopes);
        let not_judged = not_judged.or(judgement.not_judged);
        if not_judged.is_some() {
            diagnoses.clear();
        }
        notes.extend([judgement.foreign, judgement.speed, judgement.rotor].into_iter().flatten());
        for diagnosis in &mut diagnoses {
            let sentence = growth_sentence(diagnosis, &trends, &self.snapshots);
            diagnosis.sentence += &sentence;
        }
        let verdict = match (&not_judged, diagnoses.first()) {
            (Some(reason), _) => format!("No verdict: {reason}."),
            (None, Some(diagnosis)) => diagnosis.sentence.clone(),
            (None, None) => SOUND.to_owned(),
        };
        notes.extend(trends.iter().filter_map(|trend| note_of_trend(trend, &self.snapshots)));
        let rows = (self.samples.unwrap_or(0) * self.snapshots.len()) as u64;
        let rpm = 60.0 * turn_hz;
        let record = Record {
            samples: rows,
            compared: rows,
            rate_hz: rate,
            duration_s: rows as f64 / rate,
            turns: turns * self.snapshots.len() as f64,
            mean_speed_rpm: rpm,
            min_speed_rpm: rpm,
            max_speed_rpm: rpm,
            angle_source: "the scene's shaft speed".to_owned(),
            ..Record::default()
        };
        Outcome {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            verdict,
            record,
            bearings: suspects.iter().map(Suspect::outcome).collect(),
            timing: Timing { samples: rows, sample_period_ns: (1e9 / rate) as u64, ..Timing::default() },
            not_judged: not_judged.into_iter().collect(),
            diagnoses,
            notes,
            snapshots: self.snapshots,
            snapshot_trends: trends,
            learned: Baseline::of_sensors("", "", learned),
            pictures: Pictures { envelopes, ..Pictures::default() },
            ..Outcome::default()
        }
    }

    fn note_left_out(&self) -> Option<String> {
        let mut left_out: Vec<_> = self.left_out.iter().collect();
        left_out.sort_by_key(|(i, ..)| *i);
        let names = left_out.into_iter().map(|(_, file, reason)| format!("{file} ({reason})"));
        let (count, files) = (self.left_out.len(), self.files);
        (count > 0).then(|| format!("{count} of {files} snapshots are omitted: {}.", listed(names)))
    }

    /// States the lines that short snapshots do not separate from each other or from multiples of the shaft speed.
    fn note_resolution(&self, suspects: &[Suspect]) -> Option<String> {
        let bin = 1.0 / self.turns();
        if bin <= 1.0 / MIN_TURNS || !bin.is_finite() {
            return None;
        }
        let kinds = [FaultKind::OuterRace, FaultKind::InnerRace, FaultKind::Element, FaultKind::Cage];
        let lines: Vec<(String, f64)> = suspects
            .iter()
            .flat_map(|s| kinds.map(|kind| (format!("{} of {}", in_words(kind), s.name), s.order(kind))))
            .collect();
        let mut close = vec![];
        for (i, (name, order)) in lines.iter().enumerate() {
            if (order - order.round()).abs() < bin {
                close.push(format!("{name} and {:.0}X", order.round()));
            }
            let others = lines.iter().skip(i + 1).filter(|(_, other)| (other - order).abs() < bin);
            close.extend(others.map(|(other, _)| format!("{name} and {other}")));
        }
        let close = if close.is_empty() { String::new() } else { format!(": {}", close.join(", ")) };
        Some(format!(
            "Lines closer than {bin:.2} orders are not separated, however many snapshots are averaged{close}."
        ))
    }
}

/// Returns the reason why a file is omitted, without its path.
fn reason(path: &Path, error: &RecordingError) -> String {
    error.to_string().replace(&path.display().to_string(), "").trim_start_matches([':', ' ']).to_owned()
}

/// Returns the number of a snapshot with its time or file.
fn named(number: usize, snapshots: &[SnapshotOutcome]) -> String {
    let found = snapshots.iter().find(|snapshot| snapshot.number == number);
    let place = found.map(|snapshot| snapshot.time.as_ref().unwrap_or(&snapshot.file).clone());
    format!("snapshot {number} ({})", place.unwrap_or_default())
}

/// Returns the growth of the line of a diagnosis as a sentence.
fn growth_sentence(diagnosis: &Diagnosis, trends: &[SnapshotTrend], snapshots: &[SnapshotOutcome]) -> String {
    let sensor = diagnosis.vibration.as_ref().map(|line| &line.sensor);
    let is_its = |t: &&SnapshotTrend| {
        Some(&t.sensor) == sensor && t.bearing == diagnosis.bearing && t.component == Some(diagnosis.kind)
    };
    match trends.iter().find(is_its) {
        Some(SnapshotTrend { growth_db, onset: Some(onset), .. }) => format!(
            " Its level has grown by {growth_db:.0} dB since the first tenth of the snapshots, beyond their scatter from {} on.",
            named(*onset, snapshots)
        ),
        Some(_) => " Its level has not grown beyond the scatter of the first tenth of the snapshots.".to_owned(),
        None => String::new(),
    }
}

/// Returns a note on an indicator that has grown.
fn note_of_trend(trend: &SnapshotTrend, snapshots: &[SnapshotOutcome]) -> Option<String> {
    let onset = trend.onset?;
    let indicator = match (&trend.bearing, trend.component) {
        (Some(bearing), Some(kind)) => format!("line of the {} of {bearing}", in_words(kind)),
        _ => trend.indicator.replace('-', " "),
    };
    Some(format!(
        "{}: the {indicator} has grown by {:.1} dB since the first tenth of the snapshots, beyond their scatter from {} on.",
        trend.sensor,
        trend.growth_db,
        named(onset, snapshots)
    ))
}
