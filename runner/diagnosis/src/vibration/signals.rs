//! Signals of the vibration sensors of a recording, with the shaft angle, and their evaluation.

use super::condition::{clipped, unusable};
use super::detector::FaultDetector;
use super::envelope::{Rotation, Transforms};
use super::shaft::ShaftAngle;
use super::suspects;
use super::{severity, spall_width};
use ballrace::Exact;
use ballrace::twin::{BlockStatistics, Statistics};
use ballrace_outcome::baseline::{Baseline, BaselineSensor};
use ballrace_outcome::{Diagnosis, EnvelopeSpectrum, SensorOutcome};
use ballrace_plant::error::Result;
use ballrace_recording::{Row, Sample};
use ballrace_scene::{Recording, RotationSource, Scene, Sensor};
use std::f64::consts::TAU;

/// Smallest number of revolutions for a verdict.
pub const MIN_TURNS: f64 = 16.0;
/// Largest number of readings of all sensors together, which need half a gigabyte of memory.
const MAX_READINGS: u64 = 1 << 26;
/// Largest ratio of the fastest to the slowest shaft speed for a verdict: amplitudes of impacts rise with the speed.
const MAX_SPEED_RATIO: f64 = 3.0;

/// Signals of all sensors of a recording.
pub struct Signals {
    sensors: Vec<(Sensor, Vec<f64>)>,
    angle: ShaftAngle,
    /// Samples of the recording in one sample with an angle.
    average: u32,
    /// Samples per second.
    rate: f64,
    /// Number of the first sample of the recording in the signals.
    first_index: u64,
    /// Largest number of samples of one sensor.
    most_samples: u64,
    is_complete: bool,
    /// A keyphasor or a speed column measures the speed.
    is_speed_measured: bool,
}

/// Evaluation of the signals.
#[derive(Debug, Default)]
pub struct Evaluation {
    /// Faults, strongest first.
    pub diagnoses: Vec<Diagnosis>,
    /// Baseline of the sensors.
    pub learned: Vec<BaselineSensor>,
    /// One envelope spectrum a sensor.
    pub envelopes: Vec<EnvelopeSpectrum>,
    /// Statistics and restrictions.
    pub notes: Vec<String>,
    /// Statement of a speed that is not measured.
    pub speed: Option<String>,
    /// Lines of the shaft that have grown against the baseline.
    pub rotor: Option<String>,
    /// Sensors whose velocity is known.
    pub sensors: Vec<SensorOutcome>,
    /// Zone of the vibration velocity.
    pub severity: Option<String>,
    /// Strong family of lines that no component explains.
    pub foreign: Option<String>,
    /// Reason why the sensors have no verdict.
    pub not_judged: Option<String>,
    /// Samples that were evaluated.
    pub samples: usize,
    /// Revolutions of the shaft in them.
    pub turns: f64,
    /// Least, mean and greatest speed in them, rev/s.
    pub speeds_hz: [f64; 3],
}

impl Signals {
    /// Creates the signals of a recording at `rate`, Hz; none without sensors.
    pub fn new(recording: &Recording, rate: f64) -> Option<Self> {
        Self::of_block(recording, rate, 0, MAX_READINGS)
    }

    /// Creates the signals of a block that begins at sample `first_index` and holds at most `most_readings` of all
    /// sensors together.
    pub fn of_block(recording: &Recording, rate: f64, first_index: u64, most_readings: u64) -> Option<Self> {
        let count = recording.sensors.len() as u64;
        let most_samples = most_readings.checked_div(count)?;
        let sensors = recording.sensors.iter().map(|sensor| (sensor.clone(), vec![])).collect();
        let (angle, average) = (ShaftAngle::default(), recording.average);
        let is_speed_measured = recording.rotation != RotationSource::Scene;
        Some(Self { sensors, angle, average, rate, first_index, most_samples, is_complete: true, is_speed_measured })
    }

    /// Adds the readings of a row; returns false where the memory for signals is full.
    pub fn add(&mut self, row: &Row) -> bool {
        // A gap in the time stamps counts too, because its samples are stored.
        let index = row.index.saturating_sub(self.first_index);
        if index >= self.most_samples {
            self.is_complete = false;
            return false;
        }
        let until = index as usize;
        for ((_, signal), &x) in self.sensors.iter_mut().zip(&row.sensors) {
            // A missing reading repeats the last one, which disturbs the spectrum less than a zero.
            let last = signal.last().copied().unwrap_or(0.0);
            signal.resize(until.max(signal.len()), last);
            signal.push(if x.is_finite() { x } else { last });
        }
        true
    }

    /// Adds a sample with its shaft angle.
    pub fn add_angle(&mut self, sample: &Sample) {
        // Samples with an angle come later than their readings, and may be those before the block.
        let index = (sample.row.index * u64::from(self.average)).checked_sub(self.first_index);
        if index.is_some_and(|index| index < self.most_samples) {
            self.angle.add(sample, self.average, self.first_index);
        }
    }

    /// Returns the revolutions of the shaft since the last interruption.
    pub fn turns(&self) -> f64 {
        self.angle.revolutions()
    }

    /// Interrupts the shaft angle: the next one has another origin.
    pub const fn interrupt(&mut self) {
        self.angle.interrupt();
    }

    /// Returns the sensors with their signals.
    pub fn signals(&self) -> impl Iterator<Item = (&Sensor, &[f64])> {
        self.sensors.iter().map(|(sensor, signal)| (sensor, signal.as_slice()))
    }

    /// Returns the number of samples of each signal.
    pub fn samples(&self) -> usize {
        self.sensors.first().map_or(0, |(_, signal)| signal.len())
    }

    /// Diagnoses the bearings of the scene.
    ///
    /// # Errors
    /// A bearing without kinematics.
    pub fn evaluate(self, scene: &Scene, baseline: Option<&Baseline>) -> Result<Evaluation> {
        let mut evaluation = Evaluation { samples: self.samples(), ..Evaluation::default() };
        let notes = &mut evaluation.notes;
        notes.extend(self.sensors.iter().map(|(sensor, signal)| statistics_note(sensor, signal)));
        if !self.is_complete {
            notes.push(format!("Only the first {} samples of the sensors were evaluated.", self.most_samples));
        }
        let is_interrupted = self.angle.is_interrupted();
        let Some(stretch) = self.angle.longest() else {
            evaluation.not_judged = Some("the shaft angle is not measured".to_owned());
            return Ok(evaluation);
        };
        let [slowest, fastest] = stretch.extreme_speeds().map(|speed| speed * self.rate);
        let mean = stretch.mean() * self.rate;
        evaluation.turns = stretch.revolutions();
        evaluation.speeds_hz = [slowest, mean, fastest];
        evaluation.not_judged = not_judged(stretch.revolutions(), [slowest, fastest]);
        if evaluation.not_judged.is_some() {
            return Ok(evaluation);
        }
        let suspects = suspects(scene)?;
        let mut detector = FaultDetector {
            suspects: &suspects,
            rotation: Rotation { turn_hz: mean, fastest_hz: fastest.max(mean), revolutions: None },
            rate: self.rate,
            baseline: baseline.filter(|baseline| !baseline.sensors.is_empty()),
            is_speed_measured: self.is_speed_measured,
        };
        let least_rate = detector.least_rate();
        if self.rate < least_rate {
            evaluation.not_judged = Some(format!(
                "the rate of {:.0} Hz has no band with the lines of the bearings, expected {least_rate:.0} Hz or more",
                self.rate
            ));
            return Ok(evaluation);
        }
        let revolutions = stretch.varying(detector.highest_line());
        detector.rotation.revolutions = revolutions.as_ref();
        let samples = stretch.samples();
        if is_interrupted {
            evaluation.notes.push(format!(
                "The shaft angle is interrupted: the sensors were evaluated from {:.2} to {:.2} s.",
                samples.start as f64 / self.rate,
                samples.end as f64 / self.rate
            ));
        }
        if revolutions.is_some() {
            evaluation.notes.push(format!(
                "The shaft speed varies from {:.1} to {:.1} rpm: envelopes of the sensors were resampled at equal steps of the shaft angle.",
                60.0 * slowest,
                60.0 * fastest
            ));
        }
        let part = |signal: &'_ Vec<f64>| samples.start.min(signal.len())..samples.end.min(signal.len());
        let (mut transforms, mut spectra, mut unusable_sensors) = (Transforms::default(), vec![], vec![]);
        for (sensor, signal) in &self.sensors {
            let signal = signal.get(part(signal)).unwrap_or_default();
            let reason = unusable(signal).map(|reason| format!("{} {reason}", sensor.column));
            if reason.is_none() {
                let of = severity::velocity((sensor, signal), (self.rate, mean), scene.machine, &mut transforms);
                evaluation.notes.extend(of.as_ref().map(severity::note));
                evaluation.sensors.extend(of);
            }
            spectra.push((sensor, if reason.is_none() { detector.spectra(signal, &mut transforms) } else { None }));
            evaluation
                .notes
                .extend(clipped(signal).filter(|_| reason.is_none()).map(|text| format!("{} {text}.", sensor.column)));
            unusable_sensors.extend(reason);
        }
        if unusable_sensors.len() == self.sensors.len() {
            evaluation.not_judged = Some(unusable_sensors.join("; "));
            return Ok(evaluation);
        }
        evaluation.severity = severity::statement(&evaluation.sensors, scene.machine);
        evaluation.notes.extend(unusable_sensors.iter().map(|reason| format!("Not evaluated: {reason}.")));
        let mut judgement = detector.judge(&spectra);
        for diagnosis in &mut judgement.diagnoses {
            let column = diagnosis.vibration.as_ref().map(|line| line.sensor.as_str());
            let shown = self.sensors.iter().find(|(sensor, _)| Some(sensor.column.as_str()) == column);
            let damaged = suspects.iter().find(|suspect| Some(&suspect.name) == diagnosis.bearing.as_ref());
            let Some(((_, signal), damaged)) = shown.zip(damaged) else { continue };
            let signal = signal.get(part(signal)).filter(|_| revolutions.is_none()).unwrap_or_default();
            spall_width::add(diagnosis, (signal, self.rate), damaged.elements, &mut transforms);
        }
        if let Some(turn_hz) = judgement.turn_hz {
            let scale = turn_hz / mean;
            evaluation.speeds_hz = evaluation.speeds_hz.map(|speed| speed * scale);
            evaluation.turns *= scale;
        }
        (evaluation.speed, evaluation.rotor, evaluation.foreign) =
            (judgement.speed, judgement.rotor, judgement.foreign);
        evaluation.not_judged = judgement.not_judged;
        (evaluation.diagnoses, evaluation.learned, evaluation.envelopes) =
            (judgement.diagnoses, judgement.learned, judgement.envelopes);
        Ok(evaluation)
    }
}

/// Returns the reason why a stretch with this number of revolutions and these speeds, rev/s, has no verdict.
fn not_judged(turns: f64, [slowest, fastest]: [f64; 2]) -> Option<String> {
    if turns < MIN_TURNS {
        return Some(format!("{turns:.1} revolutions of the shaft, expected {MIN_TURNS} or more"));
    }
    (fastest > MAX_SPEED_RATIO * slowest).then(|| {
        format!(
            "the shaft speed varies from {:.0} to {:.0} rpm, expected a ratio of {MAX_SPEED_RATIO} or less",
            60.0 * slowest,
            60.0 * fastest
        )
    })
}

/// Returns the statistics of a signal.
pub fn statistics(signal: &[f64]) -> BlockStatistics<f64> {
    let mut statistics = Statistics::<f64>::new(u32::MAX);
    for &x in signal {
        statistics.add::<Exact>(x);
    }
    statistics.close::<Exact>()
}

/// Returns the statistics of a signal as a note of the report.
fn statistics_note(sensor: &Sensor, signal: &[f64]) -> String {
    let BlockStatistics { rms, crest_factor, kurtosis, .. } = statistics(signal);
    format!(
        "{}: {rms:.4} {unit} rms, peak {peak:.4} {unit}, crest factor {crest_factor:.2}, kurtosis {kurtosis:.2} (3 is noise).",
        sensor.column,
        peak = crest_factor * rms,
        unit = sensor.unit
    )
}

impl Evaluation {
    /// Returns the mean speed, rad/s.
    pub fn mean_speed(&self) -> f64 {
        self.speeds_hz[1] * TAU
    }
}
