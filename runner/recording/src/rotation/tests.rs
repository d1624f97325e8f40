use std::f64::consts::TAU;
use std::path::Path;

use ballrace::Phase;

use super::*;
use crate::Reader;
use crate::flaws::Flaw;
use ballrace_scene::{Clock, FileLayout, Recording};

/// Analogue keyphasors, toothed wheels with a gap, counts.
mod signals;

const RATE: f64 = 12_800.0;

fn keyphasor(pulses_per_turn: u32) -> RotationSource {
    RotationSource::keyphasor("key", pulses_per_turn)
}

fn row(index: u64, rotation: f64) -> Row {
    Row { index, line: index + 2, time: index as f64 / RATE, rotation, ..Row::default() }
}

/// 1 in each sample in which `pulses` passes a whole number, as if it had been just below before.
fn steps(count: u64, pulses: impl Fn(f64) -> f64) -> Vec<Row> {
    let mut last = -1.0;
    let sample = |index: u64| {
        let passed = pulses(index as f64 / RATE).floor();
        let pulse = passed > last;
        last = passed;
        row(index, f64::from(u8::from(pulse)))
    };
    (0..count).map(sample).collect()
}

fn track(rows: Vec<Row>, tracker: &mut Tracker) -> Vec<Sample> {
    let (mut samples, count) = (Vec::new(), rows.len());
    for row in rows {
        tracker.push(row).unwrap();
        samples.extend(std::iter::from_fn(|| tracker.pop()));
    }
    tracker.finish().unwrap();
    samples.extend(std::iter::from_fn(|| tracker.pop()));
    assert_eq!(samples.len(), count);
    samples
}

fn tracked(rows: Vec<Row>, per_turn: u32) -> (Vec<Sample>, Tracker) {
    let mut tracker = Tracker::new(&keyphasor(per_turn), RATE, Speed::Constant(1.0));
    let samples = track(rows, &mut tracker);
    (samples, tracker)
}

/// Difference from a truth in revolutions; whole ones have to be right too.
fn miss(sample: &Sample, revolutions: f64) -> f64 {
    sample.revolution as f64 - revolutions + sample.angle.revolutions()
}

/// The same, whole revolutions aside.
fn miss_in_turn(sample: &Sample, revolutions: f64) -> f64 {
    sample.angle.since(Phase::from_revolutions(revolutions)).radians::<f64>() / TAU
}

/// Largest error anywhere, and rms without the mean at least five turns from the ends, in samples.
fn errors(samples: &[Sample], revolutions: impl Fn(f64) -> f64, speed: impl Fn(f64) -> f64) -> (f64, f64) {
    let last = revolutions(samples.last().unwrap().row.time);
    let (mut largest, mut inner) = (0.0_f64, Vec::new());
    for sample in samples {
        let time = sample.row.time;
        let error = miss(sample, revolutions(time)) / speed(time) * RATE;
        largest = largest.max(error.abs());
        if (5.0..last - 5.0).contains(&revolutions(time)) {
            inner.push(error);
        }
    }
    let count = inner.len() as f64;
    let mean = inner.iter().sum::<f64>() / count;
    (largest, (inner.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[test]
fn steady_speeds() {
    for speed in [50.0, 49.37, 51.234, 13.1, 97.77, 83.019, 7.77] {
        let (samples, tracker) = tracked(steps(40_000, |t| speed * t), 1);
        let (largest, rms) = errors(&samples, |t| speed * t, |_| speed);
        assert!(largest < 0.6 && rms < 0.15, "{speed}: {largest} {rms}");
        assert!((tracker.mean_speed().unwrap() / TAU / speed - 1.0).abs() < 1e-3);
        assert!(tracker.flaws().is_empty());
        assert_eq!(tracker.pulses(), (40_000.0 / RATE * speed).ceil() as u64);
    }
}

/// The recording begins within a pulse, so that its first interval is a part of a turn.
#[test]
fn a_first_pulse_that_is_no_mark() {
    for share in [0.03, 0.2, 0.34, 0.5, 0.67, 0.8, 0.9] {
        let (speed, before) = (49.17, 1.0 - share);
        let (samples, tracker) = tracked(steps(40_000, |t| before + speed * t), 1);
        let middle: Vec<f64> = samples.iter().map(|s| miss_in_turn(s, before + speed * s.row.time)).collect();
        let largest = middle.iter().fold(0.0, |most: f64, miss| most.max(miss.abs()));
        assert!(largest < 0.004, "{share}: {largest} of a turn");
        assert!((tracker.mean_speed().unwrap() / TAU / speed - 1.0).abs() < 1e-3, "{share}");
        let flaws = tracker.flaws().summary();
        assert_eq!(
            flaws.iter().map(|flaw| (flaw.kind, flaw.count)).collect::<Vec<_>>(),
            [(Flaw::SpuriousPulse, 1)],
            "{share}"
        );
    }
}

#[test]
fn run_up() {
    let pulses = |t: f64| 10.0 * t + 22.5 * t * t;
    let (samples, tracker) = tracked(steps(25_600, pulses), 1);
    let (largest, rms) = errors(&samples, pulses, |t| 10.0 + 45.0 * t);
    assert!(largest < 0.6 && rms < 0.15, "{largest} {rms}");
    assert!(tracker.flaws().is_empty(), "{:?}", tracker.flaws().summary());
    let middle = &samples[12_800];
    assert!((middle.speed / TAU - 55.0).abs() < 0.1, "{}", middle.speed / TAU);
    assert!((middle.acceleration / TAU - 45.0).abs() < 5.0, "{}", middle.acceleration / TAU);
    assert!((tracker.min_speed().unwrap() / TAU - 10.0).abs() < 0.2);
    assert!((tracker.max_speed().unwrap() / TAU - 100.0).abs() < 1.0);
}

#[test]
fn run_down_to_rest_and_up_again() {
    // Uniform, with the mark just past at rest: the last intervals grow by factors up to 2.
    let pulses = |t: f64| {
        let turns = 16.67 * (3.0 - t).powi(2);
        if t < 3.0 { 150.03 - turns } else { 150.03 + turns }
    };
    let down = steps(12_800 * 3, pulses);
    let (samples, tracker) = tracked(down, 1);
    assert!(tracker.flaws().is_empty(), "{:?}", tracker.flaws().summary());
    for sample in &samples {
        let error = miss(sample, pulses(sample.row.time)).abs();
        assert!(error < 0.02, "{} {error}", sample.row.time);
    }
    // No trend foretells that it starts again, and a pulse or two is doubted; then the beat is found again.
    let (samples, tracker) = tracked(steps(12_800 * 6, pulses), 1);
    assert!(tracker.flaws().summary().iter().map(|flaw| flaw.count).sum::<u64>() <= 3);
    for sample in samples.iter().filter(|sample| sample.row.time < 2.7 || sample.row.time > 4.0) {
        let error = miss_in_turn(sample, pulses(sample.row.time)).abs();
        assert!(error < 0.02, "{} {error}", sample.row.time);
    }
}

#[test]
fn fluctuating_speed_is_followed() {
    let swing = |t: f64| 0.02 * 50.0 * (TAU * 7.0 * t).sin() / (TAU * 7.0);
    let pulses = |t: f64| 50.0 * t + swing(t);
    let (samples, tracker) = tracked(steps(40_000, pulses), 1);
    let (largest, rms) = errors(&samples, pulses, |_| 50.0);
    assert!(largest < 1.5 && rms < 0.4, "{largest} {rms}");
    assert!(tracker.flaws().is_empty());
}

#[test]
fn speed_follows_the_corner_of_a_ramp() {
    let pulses = |t: f64| if t < 1.0 { 30.0 * t } else { 30.0 * t + 20.0 * (t - 1.0) * (t - 1.0) };
    let (samples, _) = tracked(steps(40_000, pulses), 1);
    let (largest, _) = errors(&samples, pulses, |t| 30.0 + 40.0 * (t - 1.0).max(0.0));
    assert!(largest < 1.2, "{largest}");
}

#[test]
fn many_pulses_per_turn() {
    for per_turn in [3, 60] {
        let (samples, _) = tracked(steps(40_000, |t| 20.3 * t * f64::from(per_turn)), per_turn);
        let (largest, rms) = errors(&samples, |t| 20.3 * t, |_| 20.3);
        assert!(largest < 0.6 && rms < 0.15, "{largest} {rms}");
    }
}

#[test]
fn reversed_shaft() {
    let mut tracker = Tracker::new(&keyphasor(1), RATE, Speed::Constant(-300.0));
    let samples = track(steps(20_000, |t| 47.9 * t), &mut tracker);
    for sample in samples {
        assert!(miss(&sample, -47.9 * sample.row.time).abs() < 0.003);
        assert!((sample.speed + 47.9 * TAU).abs() < 1.0);
    }
}

#[test]
fn ten_million_turns_out() {
    // The same pulses at the start and far out have to give the same angles, to the last digit but two.
    let rows = steps(20_000, |t| 50.3 * t);
    let (near, _) = tracked(rows.clone(), 3);
    let mut far_rows = rows;
    for row in &mut far_rows {
        row.index += 1 << 52;
    }
    let (far, _) = tracked(far_rows, 3);
    for (near, far) in near.iter().zip(&far) {
        assert!(near.angle.since(far.angle).radians::<f64>().abs() < 1e-12);
    }
    // And the count itself: pulses numbered from 0 in one tracker, over a gap of 10^7 turns in the other.
    let gap = 2_560_000_000;
    let mut rows = steps(20_000, |t| 50.0 * t);
    for row in rows.iter_mut().skip(10_000) {
        row.index += gap;
    }
    let (samples, tracker) = tracked(rows, 1);
    assert_eq!(tracker.flaws().count(Flaw::MissedPulse), 1);
    for sample in samples {
        let error = miss_in_turn(&sample, 50.0 * (sample.row.index % gap) as f64 / RATE) * 256.0;
        assert!(error.abs() < 0.7, "{} {error}", sample.row.index);
    }
}

#[test]
fn missed_and_surplus_pulses() {
    let mut rows = steps(40_000, |t| 47.9 * t);
    let marks: Vec<usize> = (0..rows.len()).filter(|i| rows[*i].rotation > 0.5).collect();
    for missed in [20, 40, 41, 42] {
        rows[marks[missed]].rotation = 0.0;
    }
    for surplus in [marks[60] + 50, marks[80] + 140] {
        rows[surplus].rotation = 1.0;
    }
    let (samples, tracker) = tracked(rows, 1);
    let (largest, _) = errors(&samples, |t| 47.9 * t, |_| 47.9);
    assert!(largest < 0.8, "{largest}");
    let summary = tracker.flaws().summary();
    assert_eq!(summary.len(), 2);
    assert_eq!((summary[0].kind, summary[0].count, summary[0].samples_affected), (Flaw::MissedPulse, 2, 4));
    assert_eq!((summary[1].kind, summary[1].count, summary[1].samples_affected), (Flaw::SpuriousPulse, 2, 2));
    assert_eq!(summary[1].first_line, marks[60] as u64 + 52);
    assert!(summary[0].sentence.starts_with("key: 4 pulses missing and filled in in 2 places, first at line "));
}

#[test]
fn missed_pulse_in_a_run_up() {
    let pulses = |t: f64| 10.0 * t + 22.5 * t * t;
    let mut rows = steps(25_600, pulses);
    let marks: Vec<usize> = (1..rows.len()).filter(|i| rows[*i].rotation > 0.5).collect();
    rows[marks[8]].rotation = 0.0;
    let (samples, tracker) = tracked(rows, 1);
    assert_eq!(tracker.flaws().count(Flaw::MissedPulse), 1);
    let (largest, _) = errors(&samples, pulses, |t| 10.0 + 45.0 * t);
    assert!(largest < 1.0, "{largest}");
}

#[test]
fn gaps_and_missing_readings() {
    let mut rows = steps(60_000, |t| 48.3 * t);
    for row in &mut rows[20_000..21_500] {
        row.rotation = f64::NAN;
    }
    rows.drain(40_000..42_345);
    let (samples, tracker) = tracked(rows, 1);
    assert!(tracker.flaws().count(Flaw::MissedPulse) <= 2);
    for sample in &samples {
        let error = miss(sample, 48.3 * sample.row.time) / 48.3 * RATE;
        let blind = sample.row.rotation.is_nan();
        assert!(error.abs() < if blind { 5.0 } else { 0.8 }, "{} {error}", sample.row.index);
    }
}

/// A probe over a keyway: `rest` V, `pulse` V for 5 % of a turn, with slopes of three samples and noise. At the
/// start the shaft is `before` turns before the keyway.
fn voltage(count: u64, speed: f64, before: f64, rest: f64, pulse: f64) -> Vec<Row> {
    let mut seed = 1_u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
    };
    let slope = 3.0 * speed / RATE;
    let height = |phase: f64| (phase / slope + 0.5).min((0.05 - phase) / slope + 0.5).clamp(0.0, 1.0);
    let sample = |index: u64| {
        let phase = (speed * index as f64 / RATE - before + 0.5).rem_euclid(1.0) - 0.5;
        row(index, rest + (pulse - rest) * height(phase) + 0.3 * noise())
    };
    (0..count).map(sample).collect()
}

#[test]
fn voltages_of_either_sign() {
    for (rest, pulse) in [(-24.0, 0.0), (0.0, -24.0), (-10.0, -14.0)] {
        // The last one begins in a pulse: where that began is unknown, so angle 0 is where the next one begins.
        for before in [0.3, 0.9, -0.02] {
            let (samples, tracker) = tracked(voltage(30_000, 43.21, before, rest, pulse), 1);
            assert!(tracker.flaws().is_empty());
            let first = if before < 0.0 { before + 1.0 } else { before };
            let (largest, rms) = errors(&samples, |t| 43.21 * t - first, |_| 43.21);
            assert!(largest < 0.6 && rms < 0.15, "{rest} {pulse} {before}: {largest} {rms}");
        }
    }
}

#[test]
fn slow_shaft_with_flicker() {
    // Long before the first pulse there is only the flicker of the last digit.
    let coarse = |row: Row| Row { rotation: (row.rotation * 5.0).round() / 5.0, ..row };
    let rows = voltage(300_000, 0.31, 0.9, -24.0, 0.0).into_iter().map(coarse).collect();
    let (samples, tracker) = tracked(rows, 1);
    assert!(tracker.flaws().is_empty());
    assert_eq!(tracker.pulses(), 7);
    assert!(samples.iter().all(|sample| miss(sample, 0.31 * sample.row.time - 0.9).abs() < 1e-3));
}

#[test]
fn short_recordings() {
    let (samples, tracker) = tracked(steps(300, |t| 50.0 * t), 1);
    assert_eq!((samples.len(), tracker.pulses()), (300, 2));
    let (samples, _) = tracked(steps(3000, |t| 10.0 * t + 22.5 * t * t), 1);
    let (largest, _) = errors(&samples, |t| 10.0 * t + 22.5 * t * t, |t| 10.0 + 45.0 * t);
    assert!(largest < 2.0, "{largest}");
}

fn failure(rows: Vec<Row>) -> RotationError {
    let mut tracker = Tracker::new(&keyphasor(1), RATE, Speed::Constant(1.0));
    let pushed: Result<(), RotationError> = rows.into_iter().try_for_each(|row| tracker.push(row));
    pushed.and_then(|()| tracker.finish()).unwrap_err()
}

#[test]
fn too_few_pulses() {
    let none = failure((0..5000).map(|index| row(index, 0.0)).collect());
    assert_eq!(
        none.to_string(),
        "column key: no keyphasor pulses in 5000 samples: it stays between 0 and 0, expected two levels that alternate once per pulse"
    );
    let one = failure((0..5000).map(|index| row(index, f64::from(u8::from(index == 99)))).collect());
    assert_eq!(one, RotationError::OnePulse { column: "key".into(), line: 101 });
    let blind = failure((0..50).map(|index| row(index, f64::NAN)).collect());
    assert!(blind.to_string().contains("it has no value"));
}

#[test]
fn standstill_is_reported() {
    let still = failure(steps(40_000, |t| 50.0 * t.min(1.0)));
    let RotationError::Standstill { line, samples, .. } = still else { unreachable!("{still}") };
    assert!(line > 12_000 && samples > 20 * 255 && samples < 20 * 260);
}

#[test]
fn no_wait_is_endless() {
    let mut tracker = Tracker::new(&keyphasor(1), RATE, Speed::Constant(1.0));
    let mut row_number = 0;
    let failed = loop {
        if let Err(error) = tracker.push(row(row_number, 0.0)) {
            break error;
        }
        row_number += 1;
    };
    assert!(matches!(failed, RotationError::NoPulse { samples: LONGEST_WAIT, .. }));
}

#[test]
fn few_samples_wait() {
    let mut tracker = Tracker::new(&keyphasor(1), RATE, Speed::Constant(1.0));
    let (mut waiting, mut largest) = (0_u64, 0);
    for row in steps(100_000, |t| 50.0 * t) {
        tracker.push(row).unwrap();
        waiting += 1;
        while let Some(sample) = tracker.pop() {
            tracker.recycle(sample.row);
            waiting -= 1;
        }
        largest = largest.max(waiting);
    }
    assert!(largest <= 11 * 256, "{largest}");
    assert!(waiting <= 7 * 256, "{waiting}");
}

#[test]
fn speed_column() {
    let speed = |t: f64| 100.0 + 40.0 * t;
    let radians = |t: f64| 100.0 * t + 20.0 * t * t;
    let rotation = RotationSource::SpeedColumn { column: "rpm".into(), radians_per_second: 1.0 };
    let mut tracker = Tracker::new(&rotation, RATE, Speed::Constant(1.0));
    let rows: Vec<Row> = (0..50_000).map(|index| row(index, speed(index as f64 / RATE))).collect();
    let samples = track(rows, &mut tracker);
    for sample in &samples {
        let time = sample.row.time;
        assert!(miss(sample, radians(time) / TAU).abs() < 1e-10);
        assert!((sample.speed - speed(time)).abs() < 1e-9 && (sample.acceleration - 40.0).abs() < 1e-6);
    }
    let mut tracker = Tracker::new(&rotation, RATE, Speed::Constant(1.0));
    let mut rows: Vec<Row> = (0..1000).map(|index| row(index, -60.0)).collect();
    for hole in [0, 1, 500, 501, 999] {
        rows[hole].rotation = f64::NAN;
    }
    for row in &mut rows[700..] {
        row.index += 100_000;
        row.time += 100_000.0 / RATE;
    }
    for sample in track(rows, &mut tracker) {
        assert!(miss(&sample, -60.0 * sample.row.time / TAU).abs() < 1e-10);
        assert_eq!((sample.speed, sample.acceleration), (-60.0, 0.0));
    }
    let mut tracker = Tracker::new(&rotation, RATE, Speed::Constant(1.0));
    tracker.push(row(0, f64::NAN)).unwrap();
    assert!(matches!(tracker.finish(), Err(RotationError::NoSpeed { samples: 1, .. })));
}

#[test]
fn scene_speeds_agree_with_their_integrals() {
    let ramp = Speed::Ramp { from: 60.0, to: -500.0, over: 1.5 };
    let fluctuating = Speed::Fluctuating { mean: 314.0, fluctuation: 0.3, frequency: 7.0 };
    for speed in [Speed::Constant(-123.4), ramp, fluctuating] {
        let mut tracker = Tracker::new(&RotationSource::Scene, RATE, speed);
        let samples = track((0..40_000).map(|index| row(index, 0.0)).collect(), &mut tracker);
        assert_eq!(samples[0].angle, Phase::ZERO);
        let mut radians = 0.0;
        for pair in samples.windows(2) {
            let step = pair[1].angle.since(pair[0].angle).radians::<f64>();
            let mean = 0.5 * (pair[0].speed + pair[1].speed);
            assert!((step * RATE - mean).abs() < 0.01, "{speed:?} {step} {mean}");
            let change = (pair[1].speed - pair[0].speed) * RATE;
            let accelerated = 0.5 * (pair[0].acceleration + pair[1].acceleration);
            assert!((change - accelerated).abs() < 200.0, "{speed:?}");
            radians += mean / RATE;
        }
        let last = samples.last().unwrap();
        assert!(miss(last, radians / TAU).abs() < 1e-4, "{speed:?}");
    }
}

#[test]
fn scene_speed_years_on() {
    // A whole number of turns each second: the same angle at the same part of any second.
    let mut tracker = Tracker::new(&RotationSource::Scene, 16_384.0, Speed::Constant(-50.0 * TAU));
    for index in [1_000, 1_000 + (1 << 44)] {
        tracker.push(row(index, 0.0)).unwrap();
    }
    let (near, far) = (tracker.pop().unwrap(), tracker.pop().unwrap());
    assert!(near.angle.since(far.angle).radians::<f64>().abs() < 1e-3);
}

#[test]
fn rig_recordings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings/rig-6205");
    for (name, speed, gain) in
        [("healthy", 50.0, 0.0), ("unbalanced", 50.0, 0.0), ("outer-spall", 50.0, 0.0), ("run-up", 10.0, 22.5)]
    {
        let path = folder.join(format!("{name}.csv"));
        if !path.exists() {
            continue;
        }
        let rotation = RotationSource::keyphasor("keyphasor", 1);
        let recording = Recording {
            file: path.clone(),
            clock: Clock::Rate(RATE),
            average: 1,
            sensors: vec![],
            layout: FileLayout::default(),
            temperatures: vec![],
            probes: vec![],
            rotation: rotation.clone(),
            run_out: None,
            further_files: vec![],
            sequence: None,
        };
        let mut reader = Reader::open(&path, &recording).unwrap();
        let mut tracker = Tracker::new(&rotation, RATE, Speed::Constant(1.0));
        let (mut rows, mut row) = (Vec::new(), tracker.blank());
        while reader.next_row(&mut row).unwrap() {
            rows.push(std::mem::take(&mut row));
        }
        let samples = track(rows, &mut tracker);
        assert!(tracker.flaws().is_empty(), "{name}: {:?}", tracker.flaws().summary());
        let (largest, rms) = errors(&samples, |t| speed * t + gain * t * t, |t| speed + 2.0 * gain * t);
        assert!(largest < 0.7 && rms < 0.15, "{name}: {largest} {rms}");
    }
}
