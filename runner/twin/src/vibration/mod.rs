//! Recordings of vibration (housing acceleration, velocity or force), without a twin. Damage is diagnosed from the lines of
//! envelope spectra.

mod envelope;
mod judge;
mod picture;
mod suspect;
#[cfg(test)]
mod tests;

use crate::baseline::Baseline;
use crate::error::{Result, VibrationError};
use crate::outcome::{Outcome, Pictures, Record, RotorDrawing, Timing};
use crate::recording::Reader;
use crate::recording::Row;
use crate::scene::{Recording, RotationSource, Scene, Sensor, Speed, build};
use ballrace::Exact;
use ballrace::twin::{BlockStatistics, Statistics};
use judge::Judge;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;
use suspect::Suspect;

/// Smallest number of revolutions for a verdict.
const LEAST_TURNS: f64 = 16.0;
/// Largest number of samples, which need half a gigabyte of memory.
const MOST_SAMPLES: u64 = 1 << 26;
/// Number of rows between two calls of the progress function.
const PROGRESS_ROWS: u64 = 4096;

/// Recording of one sensor.
struct SensorSignal {
    sensor: Sensor,
    signal: Vec<f64>,
}

/// Replays `recording`, that of `scene`'s sensors.
///
/// # Errors
/// A speed that is not constant, a recording that is too short or cannot be read.
pub fn replay(
    scene: &Scene,
    recording: &Recording,
    mut reader: Reader,
    name: &str,
    baseline: Option<&Path>,
    progress: Option<&(dyn Fn(u64, Option<u64>) + Sync)>,
) -> Result<Outcome> {
    let (Speed::Constant(speed), RotationSource::Scene) = (scene.shaft.speed, &recording.rotation) else {
        return Err(VibrationError::Speed { file: scene.path.clone() }.into());
    };
    if !scene.limits.is_empty() {
        return Err(VibrationError::Limits { file: scene.path.clone() }.into());
    }
    let unknown = |s: &&Sensor| s.bearing.as_ref().is_some_and(|name| scene.bearings.iter().all(|b| b.name != *name));
    if let Some(sensor) = recording.sensors.iter().find(unknown) {
        let (sensor, found) = (sensor.column.clone(), sensor.bearing.clone().unwrap_or_default());
        return Err(VibrationError::Bearing { file: scene.path.clone(), sensor, found }.into());
    }
    let (turn_hz, rate) = (speed.abs() / TAU, reader.rate());
    let begun = Instant::now();
    let mut signals: Vec<SensorSignal> =
        recording.sensors.iter().map(|sensor| SensorSignal { sensor: sensor.clone(), signal: vec![] }).collect();
    let mut row = Row { probes: vec![f64::NAN; signals.len()], ..Row::default() };
    let mut rows = 0;
    let mut is_complete = true;
    while reader.next_row(&mut row)? {
        // A gap in the time stamps counts too, because its samples are stored.
        if row.index >= MOST_SAMPLES {
            is_complete = false;
            break;
        }
        for (one, &x) in signals.iter_mut().zip(&row.probes) {
            // A missing reading repeats the last one, which disturbs the spectrum less than a zero.
            let last = one.signal.last().copied().unwrap_or(0.0);
            let until = row.index as usize;
            one.signal.resize(until.max(one.signal.len()), last);
            one.signal.push(if x.is_finite() { x } else { last });
        }
        rows += 1;
        if rows % PROGRESS_ROWS == 0
            && let Some(progress) = progress
        {
            let (read, total) = reader.progress();
            progress(read, total);
        }
    }
    let samples = signals.first().map_or(0, |s| s.signal.len());
    let turns = samples as f64 / rate * turn_hz;
    if turns < LEAST_TURNS {
        return Err(VibrationError::TooShort { recording: name.to_owned(), found: turns, least: LEAST_TURNS }.into());
    }
    let suspects = suspects(scene)?;
    let baseline = baseline.map(|path| Baseline::read_sensors(path, &recording.sensors)).transpose()?;
    let judge = Judge { suspects: &suspects, turn_hz, rate, baseline: baseline.as_ref() };
    let (findings, learned, envelopes) = judge.all(signals.iter().map(|s| (&s.sensor, s.signal.as_slice())));
    let verdict = findings.first().map_or_else(
        || "No line of a bearing stands out of the envelope of any band.".to_owned(),
        |f| f.sentence.clone(),
    );
    let rpm = turn_hz * 60.0;
    let record = Record {
        samples: rows,
        compared: rows,
        rate_hz: rate,
        duration_s: samples as f64 / rate,
        turns,
        mean_speed_rpm: rpm,
        min_speed_rpm: rpm,
        max_speed_rpm: rpm,
        angle_source: "the scene's shaft speed".to_owned(),
        ..Record::default()
    };
    let mut notes = vec![
        "Vibration without a twin: forces and displacements are not computed, damage is diagnosed from envelope spectra."
            .to_owned(),
    ];
    notes.extend(signals.iter().map(|s| statistics_note(&s.sensor, &s.signal)));
    notes.extend(reader.notes());
    if !is_complete {
        notes.push(format!("Only the first {MOST_SAMPLES} samples were looked at."));
    }
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
        timing,
        findings,
        flaws: reader.flaws().summary(),
        notes,
        learned: Baseline::of_sensors(&scene.name, name, learned),
        pictures: Pictures { envelopes, rotor: RotorDrawing::new(scene), ..Pictures::default() },
        ..Outcome::default()
    })
}

fn suspects(scene: &Scene) -> Result<Vec<Suspect>> {
    let suspect = |b: &crate::scene::Bearing| {
        let kinematics = build::kinematics(scene, b)?;
        Ok(Suspect {
            name: b.name.clone(),
            station: scene.drawn_station(b.station),
            orders: kinematics.orders,
            elements: b.elements,
        })
    };
    scene.bearings.iter().map(suspect).collect()
}

/// Returns the statistics of a signal as a note of the report.
fn statistics_note(sensor: &Sensor, signal: &[f64]) -> String {
    let mut statistics = Statistics::<f64>::new(u32::MAX);
    for &x in signal {
        statistics.add::<Exact>(x);
    }
    let BlockStatistics { rms, crest_factor, kurtosis, .. } = statistics.close::<Exact>();
    format!(
        "{}: {rms:.4} {unit} rms, peak {peak:.4} {unit}, crest factor {crest_factor:.2}, kurtosis {kurtosis:.2} (3 is noise).",
        sensor.column,
        peak = crest_factor * rms,
        unit = sensor.unit
    )
}
