//! Signals with a known truth: the angle that the tracker finds is within a stated part of a degree.

use super::*;
use ballrace_scene::{KeyphasorSignal, PulseDetection, Slope};

/// Normally distributed noise (the sum of 12 uniform numbers) of standard deviation 1, the same in every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

fn source(signal: KeyphasorSignal, (pulses_per_turn, missing): (u32, u32)) -> RotationSource {
    RotationSource::Keyphasor { column: "key".into(), pulses_per_turn, missing, signal }
}

fn analogue(detection: PulseDetection) -> RotationSource {
    source(KeyphasorSignal::Pulses(detection), (1, 0))
}

/// A signal over the part of a turn since the mark, sampled with noise.
fn sampled(count: u64, turns: impl Fn(f64) -> f64, signal: impl Fn(f64, f64) -> f64, noise: f64) -> Vec<Row> {
    let mut random = Noise(0x2545_f491_4f6c_dd1d);
    let sample = |index: u64| {
        let time = index as f64 / RATE;
        row(index, signal(turns(time), time) + noise * random.next())
    };
    (0..count).map(sample).collect()
}

/// Largest angle error and its root of the mean square in degrees, without `edge` turns at either end. The constant part of the
/// error, the place of the threshold on the slope, is returned first.
fn angle_errors(samples: &[Sample], turns: impl Fn(f64) -> f64, edge: f64) -> (f64, f64, f64) {
    let last = turns(samples.last().unwrap().row.time);
    let inner = samples.iter().filter(|s| (edge..last - edge).contains(&turns(s.row.time)));
    let errors: Vec<f64> = inner.map(|s| 360.0 * miss_in_turn(s, turns(s.row.time))).collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let largest = errors.iter().fold(0.0_f64, |most, error| most.max((error - mean).abs()));
    (mean, largest, (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt())
}

fn run(rows: Vec<Row>, source: &RotationSource) -> (Vec<Sample>, Tracker) {
    let mut tracker = Tracker::new(source, RATE, Speed::Constant(1.0));
    let samples = track(rows, &mut tracker);
    (samples, tracker)
}

/// A notch under a proximity probe: -8 V over the shaft, -13 V over the notch, with round shoulders; 0.06 turns long.
fn notch(turns: f64) -> f64 {
    let phase = (turns + 0.5).rem_euclid(1.0) - 0.5;
    let shoulder = 0.006;
    let inside = |x: f64| 0.5 * (1.0 + (x / shoulder).tanh());
    -8.0 - 5.0 * inside(phase) * inside(0.06 - phase)
}

#[test]
fn proximity_keyphasor_with_noise() {
    let turns = |t: f64| 20.0 * t - 0.4;
    for (noise, most, rms) in [(0.0, 0.3, 0.05), (0.1, 0.5, 0.12), (0.3, 1.0, 0.3)] {
        let rows = sampled(60_000, turns, |turns, _| notch(turns), noise);
        let (samples, tracker) = run(rows, &analogue(PulseDetection::default()));
        let (mean, largest, deviation) = angle_errors(&samples, turns, 2.0);
        println!(
            "noise {noise} V: mean {mean:.3} largest {largest:.3} rms {deviation:.4} deg, {}",
            tracker.detection().unwrap()
        );
        assert!(tracker.flaws().is_empty(), "{:?}", tracker.flaws().summary());
        assert_eq!(tracker.pulses(), 94);
        assert!(mean.abs() < 0.3 && largest < most && deviation < rms, "{noise}: {mean} {largest} {deviation}");
        assert!(tracker.detection().unwrap().starts_with("falling through -10."), "{:?}", tracker.detection());
    }
}

#[test]
fn levels_that_drift_are_followed() {
    let turns = |t: f64| 20.0 * t - 0.4;
    // A gap that opens by 9 V, twice the height of the pulse, and a signal coupled by alternating current after its transient.
    let drifts: [fn(f64) -> f64; 2] = [|t| -1.5 * t, |t| 4.0 * (-t / 1.5).exp()];
    for drift in drifts {
        let rows = sampled(76_800, turns, |turns, t| notch(turns) + drift(t), 0.05);
        let (samples, tracker) = run(rows, &analogue(PulseDetection::default()));
        assert!(tracker.flaws().is_empty(), "{:?}", tracker.flaws().summary());
        assert_eq!(tracker.pulses(), 120);
        let (mean, largest, deviation) = angle_errors(&samples, turns, 12.0);
        println!("drift: mean {mean:.3} largest {largest:.3} rms {deviation:.4} deg, {}", tracker.detection().unwrap());
        assert!(mean.abs() < 0.3 && largest < 0.5 && deviation < 0.15, "{mean} {largest} {deviation}");
    }
}

#[test]
fn step_of_the_gap_voltage_loses_few_pulses() {
    let turns = |t: f64| 20.0 * t - 0.4;
    for step in [-12.0, 12.0, 6.0] {
        let rows = sampled(60_000, turns, |turns, t| notch(turns) + if t > 2.01 { step } else { 0.0 }, 0.05);
        let (samples, tracker) = run(rows, &analogue(PulseDetection::default()));
        let missed = tracker.flaws().count(Flaw::MissedPulse);
        println!("step {step} V: {missed} pulses missed; {}", tracker.detection().unwrap());
        assert!(missed <= 2 && tracker.flaws().count(Flaw::SpuriousPulse) <= 1, "{:?}", tracker.flaws().summary());
        // The step itself may pass for an edge of a pulse: the parabolas through it are off.
        for sample in samples.iter().filter(|sample| !(1.6..2.7).contains(&sample.row.time)) {
            let error = 360.0 * miss(sample, turns(sample.row.time));
            assert!(error.abs() < 1.0, "{step} V, {} s: {error}", sample.row.time);
        }
    }
}

#[test]
fn sine_and_overshoot() {
    let turns = |t: f64| 33.3 * t - 0.4;
    // A mark that fills half of the turn is timed at its rise through the middle, a sine at its zero.
    let sine = |turns: f64, _| 2.0 * (TAU * turns).sin() - 7.0;
    let ringing = |turns: f64, _| {
        let phase = turns.rem_euclid(1.0);
        let ring = |x: f64| if x < 0.0 { 0.0 } else { 1.0 - (-x / 0.004).exp() * (x * TAU / 0.01).cos() };
        3.0 * (ring(phase) - ring(phase - 0.1))
    };
    for (name, signal, noise) in [("sine", &sine as &dyn Fn(f64, f64) -> f64, 0.04), ("overshoot", &ringing, 0.02)] {
        let rows = sampled(40_000, turns, signal, noise);
        let (samples, tracker) = run(rows, &analogue(PulseDetection::default()));
        let (mean, largest, deviation) = angle_errors(&samples, turns, 2.0);
        println!(
            "{name}: mean {mean:.3} largest {largest:.3} rms {deviation:.4} deg, {}",
            tracker.detection().unwrap()
        );
        assert!(tracker.flaws().is_empty(), "{name}: {:?}", tracker.flaws().summary());
        assert!(mean.abs() < 1.2 && largest < 0.8 && deviation < 0.25, "{name}: {mean} {largest} {deviation}");
    }
}

#[test]
fn keys_of_the_scene_are_used() {
    let turns = |t: f64| 20.0 * t - 0.4;
    let rows = || sampled(40_000, turns, |turns, _| notch(turns), 0.05);
    let rising = PulseDetection { slope: Some(Slope::Rising), ..PulseDetection::default() };
    let (samples, tracker) = run(rows(), &analogue(rising));
    let (mean, largest, _) = angle_errors(&samples, |t| turns(t) - 0.06, 2.0);
    assert!(mean.abs() < 0.3 && largest < 0.5, "{mean} {largest}");
    assert!(tracker.detection().unwrap().starts_with("rising through -10."), "{:?}", tracker.detection());
    let given = PulseDetection {
        volts_per_unit: Some(1.0),
        threshold: Some(-9.0),
        hysteresis: Some(0.8),
        slope: Some(Slope::Falling),
    };
    let (samples, tracker) = run(rows(), &analogue(given));
    assert_eq!(tracker.detection().unwrap(), "falling through -9 V, hysteresis 0.8 V");
    // The shoulder is at a fifth of the height 0.69 of its length earlier: 1.5 degrees.
    let (mean, largest, _) = angle_errors(&samples, turns, 2.0);
    assert!((mean - 1.5).abs() < 0.3 && largest < 0.5, "{mean} {largest}");
    let beyond = PulseDetection { threshold: Some(-5.0), ..given };
    let mut tracker = Tracker::new(&analogue(beyond), RATE, Speed::Constant(1.0));
    rows().into_iter().for_each(|row| tracker.push(row).unwrap());
    let error = tracker.finish().unwrap_err().to_string();
    assert!(error.contains("no keyphasor pulses in 40000 samples: it stays between -13."), "{error}");
    assert!(error.ends_with("expected crossings of the threshold -5 by the hysteresis"), "{error}");
}

/// 1 in the first half of each tooth, with `teeth` places of which the last `missing` are empty, as a soft wave.
fn wheel(teeth: u32, missing: u32) -> impl Fn(f64, f64) -> f64 {
    move |turns, _| {
        let place = turns.rem_euclid(1.0) * f64::from(teeth);
        if place.floor() >= f64::from(teeth - missing) { -1.0 } else { (4.0 * (TAU * place.fract()).sin()).tanh() }
    }
}

#[test]
fn a_missing_tooth_is_angle_zero() {
    for (teeth, missing, begin) in [(60, 1, 0.3), (60, 2, 0.3), (36, 1, 0.99), (12, 1, 0.05), (60, 2, 0.94)] {
        // Speeding up by a third.
        let turns = |t: f64| 5.0 * t + 0.3 * t * t + begin;
        let rows = sampled(40_000, turns, wheel(teeth, missing), 0.02);
        let source = source(KeyphasorSignal::default(), (teeth, missing));
        let (samples, tracker) = run(rows, &source);
        let (mean, largest, deviation) = angle_errors(&samples, turns, 0.05);
        println!("{teeth}-{missing}: mean {mean:.3} largest {largest:.3} rms {deviation:.4} deg");
        assert!(tracker.flaws().is_empty(), "{:?}", tracker.flaws().summary());
        assert!(
            mean.abs() < 0.3 && largest < 0.5 && deviation < 0.1,
            "{teeth} {missing}: {mean} {largest} {deviation}"
        );
        let first = samples.first().unwrap();
        // A recording that begins in the gap has its first whole one a turn later.
        let zero = if begin > 0.98 { 2.0 } else { 1.0 };
        assert!((first.total_revolutions() - (begin - zero)).abs() < 2e-3, "{}", first.total_revolutions());
        let speed = TAU * (5.0 + 0.6 * samples[20_000].row.time);
        assert!((samples[20_000].speed / speed - 1.0).abs() < 0.01, "{} {speed}", samples[20_000].speed);
    }
}

#[test]
fn a_wheel_that_is_not_the_scenes() {
    let turns = |t: f64| 5.0 * t + 0.3;
    let error = |wheel_of: (u32, u32), scene: (u32, u32)| {
        let mut tracker = Tracker::new(&source(KeyphasorSignal::default(), scene), RATE, Speed::Constant(1.0));
        let rows = sampled(40_000, turns, wheel(wheel_of.0, wheel_of.1), 0.02);
        let pushed: Result<(), RotationError> = rows.into_iter().try_for_each(|row| tracker.push(row));
        pushed.and_then(|()| tracker.finish()).unwrap_err().to_string()
    };
    let wrong = error((36, 1), (60, 1));
    assert_eq!(wrong, "column key: 35 pulses from gap to gap, expected 59; the wheel has pulses_per_turn = 36");
    let wrong = error((60, 2), (36, 2));
    assert!(wrong.starts_with("column key: 58 pulses from gap to gap, expected 34"), "{wrong}");
    let wrong = error((60, 2), (60, 1));
    assert!(wrong.contains("no gap of 2 intervals in 1") && wrong.contains("but one of 3 intervals"), "{wrong}");
    assert!(wrong.ends_with("expected one in each turn (missing = 1)"), "{wrong}");
    let wrong = error((60, 0), (60, 2));
    assert!(wrong.contains("no gap of 3 intervals") && !wrong.contains("but one"), "{wrong}");
}

#[test]
fn a_disturbed_wheel_is_counted_and_found_again() {
    let turns = |t: f64| 5.0 * t + 0.3;
    let mut rows = sampled(60_000, turns, wheel(60, 2), 0.02);
    // Two teeth are hidden, as many as are missing, 4.5 turns after the start; then noise fills a gap with a tooth.
    let at = |turn: f64| ((turn - 0.3) / 5.0 * RATE) as usize;
    for row in &mut rows[at(4.5)..at(4.5 + 2.0 / 60.0)] {
        row.rotation = -1.0;
    }
    for row in &mut rows[at(8.0 - 1.4 / 60.0)..at(8.0 - 0.9 / 60.0)] {
        row.rotation = 1.0;
    }
    let (samples, tracker) = run(rows, &source(KeyphasorSignal::default(), (60, 2)));
    assert_eq!(tracker.flaws().count(Flaw::MissedPulse), 1, "{:?}", tracker.flaws().summary());
    assert!(tracker.flaws().count(Flaw::ToothInGap) + tracker.flaws().count(Flaw::SpuriousPulse) >= 1);
    for sample in samples.iter().filter(|s| !(7.9..9.1).contains(&turns(s.row.time))) {
        let error = 360.0 * miss_in_turn(sample, turns(sample.row.time));
        assert!(error.abs() < 1.5, "{} {error}", turns(sample.row.time));
    }
}

#[test]
fn counts_of_pulses() {
    let turns = |t: f64| 20.0 * t + 1.5 * t * t;
    let largest_count = |bits: i32| 2_f64.powi(bits);
    for (per_turn, bits, start) in
        [(60, 32, 7.0), (60, 16, 65_000.0), (1024, 16, 60_000.0), (1, 16, 3.0), (4096, 32, 4_294_960_000.0)]
    {
        let count = |t: f64| ((turns(t) * f64::from(per_turn)).floor() + start) % largest_count(bits);
        let rows = (0..60_000).map(|index| row(index, count(index as f64 / RATE))).collect();
        let (samples, tracker) = run(rows, &source(KeyphasorSignal::Count, (per_turn, 0)));
        assert!(tracker.flaws().is_empty());
        // The first detected pulse is angle 0.
        let seen = |t: f64| turns(t) - f64::from(u8::from(per_turn == 1));
        let (mean, largest, deviation) = angle_errors(&samples, seen, 0.5);
        println!("{per_turn} a turn, 2^{bits}: mean {mean:.3} largest {largest:.3} rms {deviation:.4} deg");
        let tooth = 360.0 / f64::from(per_turn);
        assert!((mean.rem_euclid(tooth)).min(tooth - mean.rem_euclid(tooth)) < 0.5, "{mean}");
        assert!(largest < 0.8 && deviation < 0.25, "{per_turn}: {largest} {deviation}");
        let wraps = tracker.detection();
        let has_wrapped = start > 1000.0;
        assert_eq!(wraps, has_wrapped.then(|| format!("a count that wraps at 2^{bits}")), "{per_turn}");
        let sample = &samples[30_000];
        let speed = TAU * (20.0 + 3.0 * sample.row.time);
        assert!((sample.speed / speed - 1.0).abs() < 0.02, "{} {speed}", sample.speed);
    }
}

#[test]
fn a_count_bridges_missing_readings() {
    let turns = |t: f64| 20.0 * t;
    let mut rows: Vec<Row> = (0..40_000).map(|index| row(index, (turns(index as f64 / RATE) * 60.0).floor())).collect();
    for row in &mut rows[20_000..23_000] {
        row.rotation = f64::NAN;
    }
    rows.drain(30_000..31_000);
    let (samples, tracker) = run(rows, &source(KeyphasorSignal::Count, (60, 0)));
    assert!(tracker.flaws().is_empty());
    let (mean, largest, _) = angle_errors(&samples, turns, 0.5);
    assert!(largest < 1.0, "{mean} {largest}");
    let last = samples.last().unwrap();
    assert!((last.total_revolutions() - turns(last.row.time)).abs() < 0.02, "whole turns are counted");
}

#[test]
fn counts_that_cannot_be_used() {
    let error = |readings: &[f64]| {
        let rows = readings.iter().zip(0..).map(|(reading, index)| row(index, *reading));
        let mut tracker = Tracker::new(&source(KeyphasorSignal::Count, (60, 0)), RATE, Speed::Constant(1.0));
        let pushed: Result<(), RotationError> = rows.into_iter().try_for_each(|row| tracker.push(row));
        pushed.and_then(|()| tracker.finish()).unwrap_err().to_string()
    };
    assert_eq!(
        error(&[1.0, 2.0, 2.5]),
        "column key: line 4: no count of pulses: 2.5, expected whole numbers with kind = \"count\""
    );
    assert_eq!(
        error(&[100.0, 200.0, 5.0]),
        "column key: line 4: the count of pulses falls from 200 to 5, expected a count that rises or wraps at 2^16 or 2^32"
    );
    assert_eq!(
        error(&[7.0; 100]),
        "column key: the count of pulses stays at 7 for 100 samples, expected a count that rises"
    );
    assert!(error(&[70_000.0, 70_001.0, 4000.0]).contains("falls from 70001 to 4000"));
}
