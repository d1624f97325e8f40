//! Impacts of known origin in noise, and signals without impacts.

use super::detector::{FaultDetector, Judgement};
use super::envelope::{Rotation, Transforms};
use super::signals::{Evaluation, Signals};
use super::suspect::Suspect;
use ballrace::Phase;
use ballrace::bearing::kinematics::{Orders, orders};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::{EvidenceSource, FaultKind};
use ballrace_recording::{Row, Sample};
use ballrace_scene::read::read_str;
use ballrace_scene::{Recording, Sensor};
use std::f64::consts::TAU;
use std::path::Path;

const RATE: f64 = 20_000.0;
const TURN_HZ: f64 = 24.7;
const SAMPLES: usize = 60_000;

/// Uniform numbers, -1 to 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Depth of a modulation and its order: impacts are stronger while the damage is in the load zone.
type Modulation = (f64, f64);
const STEADY: Modulation = (0.0, 1.0);

/// Returns impacts `order` times a revolution with a resonance at `ring` (Hz) in noise, modulated with the shaft
/// (damaged inner race) or with the cage (damaged element).
fn blows(order: f64, ring: f64, (modulated, by): Modulation, loud: f64, seed: u64) -> Vec<f64> {
    let mut noise = noise(seed);
    let mut signal: Vec<f64> = (0..SAMPLES).map(|_| 0.3 * noise()).collect();
    let mut at = 0.01;
    while at < SAMPLES as f64 / RATE {
        let strength = loud * (1.0 + modulated * (TAU * by * TURN_HZ * at).cos()) / (1.0 + modulated);
        let first = (at * RATE).ceil() as usize;
        for (i, x) in signal.iter_mut().enumerate().skip(first).take(200) {
            let t = i as f64 / RATE - at;
            *x += strength * (-900.0 * t).exp() * (TAU * ring * t).sin();
        }
        // The slip of the elements varies the interval: a jitter of 0.05 %.
        at += (1.0 + 5e-4 * noise()) / (order * TURN_HZ);
    }
    signal
}

fn suspect() -> Suspect {
    let gamma = 7.94 / 39.04;
    Suspect { name: "DE".to_owned(), station: 0.0, orders: orders(9, gamma, gamma), elements: 9 }
}

/// Judges a signal at a speed that the scene states.
fn judgement(signal: &[f64], turn_hz: f64) -> Judgement {
    judged(signal, turn_hz, false, None)
}

/// Judges a signal at a measured speed.
fn judged_against(signal: &[f64], baseline: Option<&Baseline>) -> Judgement {
    judged(signal, TURN_HZ, true, baseline)
}

fn judged(signal: &[f64], turn_hz: f64, is_speed_measured: bool, baseline: Option<&Baseline>) -> Judgement {
    judged_as(signal, suspect(), turn_hz, is_speed_measured, baseline)
}

fn judged_as(
    signal: &[f64],
    suspect: Suspect,
    turn_hz: f64,
    is_speed_measured: bool,
    baseline: Option<&Baseline>,
) -> Judgement {
    let sensor = Sensor { column: "a".to_owned(), unit: "g".to_owned(), bearing: None };
    let suspects = [suspect];
    let rotation = Rotation { turn_hz, fastest_hz: turn_hz, revolutions: None };
    let detector = FaultDetector { suspects: &suspects, rotation, rate: RATE, baseline, is_speed_measured };
    let spectra = detector.spectra(signal, &mut Transforms::default());
    detector.judge(&[(&sensor, spectra)])
}

fn found(signal: &[f64]) -> Vec<(FaultKind, f64)> {
    judged_against(signal, None).diagnoses.iter().map(|f| (f.kind, f.order)).collect()
}

#[test]
fn each_component_is_identified_by_its_impacts() {
    let Orders { outer_race, inner_race, ball_spin, cage } = suspect().orders;
    let parts = [
        (FaultKind::OuterRace, outer_race, STEADY),
        (FaultKind::InnerRace, inner_race, (0.8, 1.0)),
        (FaultKind::Element, 2.0 * ball_spin, STEADY),
        (FaultKind::Element, 2.0 * ball_spin, (0.8, cage)),
    ];
    for (seed, (kind, order, modulated)) in parts.into_iter().enumerate() {
        for (ring, slip) in [(2300.0, -0.01), (4100.0, 0.0), (7700.0, 0.01)] {
            let order = order * (1.0 + slip);
            let all = found(&blows(order, ring, modulated, 3.0, seed as u64));
            assert!(
                matches!(all[..], [(k, o)] if k == kind && (o / order - 1.0).abs() < 0.01),
                "{kind:?} {ring}: {all:?}"
            );
        }
    }
}

#[test]
fn noise_and_the_shaft_are_no_damage() {
    for seed in 0..20 {
        assert!(found(&blows(1.0, 3000.0, STEADY, 0.0, seed)).is_empty(), "noise {seed}");
        assert!(found(&blows(1.0, 3000.0, STEADY, 3.0, seed)).is_empty(), "a blow a turn {seed}");
        assert!(found(&blows(2.0, 5000.0, STEADY, 3.0, seed)).is_empty(), "two blows a turn {seed}");
    }
}

/// Adds lines at multiples of a frequency: 1X and its harmonics of a shaft, or hum.
fn with_lines(mut signal: Vec<f64>, hz: f64, amplitudes: &[f64]) -> Vec<f64> {
    for (i, x) in signal.iter_mut().enumerate() {
        let t = i as f64 / RATE;
        *x += amplitudes
            .iter()
            .zip(1..)
            .map(|(a, k)| a * (TAU * f64::from(k) * hz * t + f64::from(k)).sin())
            .sum::<f64>();
    }
    signal
}

/// The lines of another bearing, or a wrong geometry: impacts 4 % beside the orders of the components, with and
/// without the lines of the shaft.
#[test]
fn families_of_other_orders_are_no_damage() {
    let Orders { outer_race, inner_race, .. } = suspect().orders;
    for (seed, (order, modulated)) in [(outer_race, STEADY), (inner_race, (0.8, 1.0))].into_iter().enumerate() {
        for share in [0.96, 1.04] {
            let signal = blows(order * share, 4100.0, modulated, 3.0, seed as u64);
            assert_eq!(found(&signal), [], "{order} {share}");
            let foreign = judged_against(&signal, None).foreign.unwrap_or_default();

            assert!(foreign.contains("is of no component of these bearings"), "{order} {share} {foreign}");
            assert_eq!(found(&with_lines(signal, TURN_HZ, &[0.1, 0.05, 0.05])), [], "{order} {share}");
        }
    }
}

/// The first 36 revolutions of the same signals.
#[test]
fn families_of_other_orders_are_no_damage_in_short_recordings() {
    let Orders { outer_race, inner_race, .. } = suspect().orders;
    for (seed, (order, modulated)) in [(outer_race, STEADY), (inner_race, (0.8, 1.0))].into_iter().enumerate() {
        for share in [0.96, 1.0, 1.04] {
            let signal = with_lines(blows(order * share, 4100.0, modulated, 3.0, seed as u64), TURN_HZ, &[0.1, 0.05]);
            let excerpt = &signal[..(36.0 / TURN_HZ * RATE) as usize];
            assert_eq!(found(excerpt).len(), usize::from(share == 1.0), "{order} {share}");
        }
    }
}

/// The lower side band of a damaged inner race is where the outer race of another bearing has its line.
#[test]
fn a_side_band_is_no_component() {
    let order = suspect().orders.inner_race;
    let signal = blows(order, 4100.0, (0.8, 1.0), 3.0, 2);
    for below in [1.0, 2.0] {
        let other = Orders { outer_race: order - below, inner_race: 7.3, ball_spin: 2.9, cage: 0.4 };
        let judged = judged_as(&signal, Suspect { orders: other, ..suspect() }, TURN_HZ, true, None);
        assert!(judged.diagnoses.is_empty(), "{below}");
    }
}

/// The speed of the scene is up to 6 % wrong: the shaft shows the true one, and the component is the true one.
#[test]
fn a_wrong_speed_is_corrected() {
    let Orders { outer_race, inner_race, .. } = suspect().orders;
    let parts = [(FaultKind::OuterRace, outer_race, STEADY), (FaultKind::InnerRace, inner_race, (0.8, 1.0))];
    for (kind, order, modulated) in parts {
        let signal = with_lines(blows(order, 4100.0, modulated, 3.0, 7), TURN_HZ, &[0.1, 0.05, 0.05]);
        for share in [0.94, 0.96, 1.0, 1.04, 1.06] {
            let judged = judgement(&signal, share * TURN_HZ);
            let named: Vec<FaultKind> = judged.diagnoses.iter().map(|f| f.kind).collect();
            assert_eq!(named, [kind], "{share} {:?}", judged.speed);
            let turn_hz = judged.turn_hz.unwrap();
            assert!((turn_hz / TURN_HZ - 1.0).abs() < 2e-3, "{share} {turn_hz}");
            assert!(judged.speed.unwrap().starts_with("Shaft speed from the vibration: 148"), "{share}");
        }
    }
}

/// Impacts of the outer race in a signal without a line of the shaft: they are named at the speed that the scene states alone. Noise has
/// neither a speed nor damage at any.
#[test]
fn a_speed_that_nothing_shows_withholds_the_verdict() {
    let order = suspect().orders.outer_race;
    let signal = blows(order, 4100.0, STEADY, 3.0, 7);
    let named: Vec<FaultKind> = judgement(&signal, TURN_HZ).diagnoses.iter().map(|f| f.kind).collect();
    assert_eq!(named, [FaultKind::OuterRace]);
    let judged = judgement(&signal, 1.04 * TURN_HZ);
    assert!(judged.diagnoses.is_empty());
    let reason = judged.not_judged.unwrap();
    assert!(
        reason.starts_with("the speed is not determined: neither a keyphasor nor a column measures it"),
        "{reason}"
    );
    assert!(reason.contains("would be that of the outer race of DE. A keyphasor"), "{reason}");
    // Far from every order of the bearing within 10 % of the speed.
    let foreign = judgement(&blows(4.15, 4100.0, STEADY, 3.0, 7), TURN_HZ).not_judged.unwrap();
    assert!(foreign.contains("The family of lines at 102.5 Hz is then of an unknown order"), "{foreign}");
    for seed in 0..20 {
        let sound = judgement(&blows(1.0, 3000.0, STEADY, 0.0, seed), TURN_HZ);
        assert!(sound.diagnoses.is_empty() && sound.not_judged.is_none(), "{seed}");
        assert!(sound.speed.unwrap().starts_with("Shaft speed not determined"), "{seed}");
    }
}

/// Hum without a turning shaft, at 50 and at 60 Hz.
#[test]
fn a_machine_that_stands_still_has_no_verdict() {
    for mains in [50.0, 60.0] {
        let hum = with_lines(blows(1.0, 3000.0, STEADY, 0.0, 5), mains, &[1.0, 0.6, 0.5, 0.3]);
        let judged = judgement(&hum, TURN_HZ);
        assert!(judged.diagnoses.is_empty());
        assert!(judged.not_judged.unwrap().contains("at multiples of the supply frequency"), "{mains}");
    }
}

/// Against a baseline a line of the shaft that has grown is the rotor's, and damage that was there is not named again.
#[test]
fn growth_against_a_baseline() {
    let shaft = |amplitude: f64| with_lines(blows(1.0, 3000.0, STEADY, 0.0, 6), TURN_HZ, &[amplitude, 0.05]);
    let baseline = |judged: Judgement| Baseline::of_sensors("", "", judged.learned);
    let sound = baseline(judged_against(&shaft(0.1), None));
    let judged = judged_against(&shaft(0.5), Some(&sound));
    assert!(judged.diagnoses.is_empty());
    let sentence = judged.rotor.unwrap();
    assert!(sentence.starts_with("Grown against the baseline: 1X at a by 14 dB to 0.49"), "{sentence}");
    assert_eq!(judged_against(&shaft(0.1), Some(&sound)).rotor, None);
    let still: Vec<f64> = shaft(0.1).iter().map(|x| 0.004 * x).collect();
    assert_eq!(
        judged_against(&still, Some(&sound)).not_judged.as_deref(),
        Some("the level of every sensor is 48 dB or more below the baseline: the machine stands still")
    );
    let damaged = blows(suspect().orders.outer_race, 4100.0, STEADY, 3.0, 8);
    assert_eq!(judged_against(&damaged, Some(&sound)).diagnoses.len(), 1);
    let known = baseline(judged_against(&damaged, None));
    assert!(judged_against(&damaged, Some(&known)).diagnoses.is_empty());
}

/// The line of the damage is the highest of the drawn spectrum about it; sound signals have a picture too.
#[test]
fn the_drawn_spectrum_shows_the_line() {
    let order = suspect().orders.outer_race;
    let drawn = judged_against(&blows(order, 4100.0, STEADY, 3.0, 1), None).envelopes;
    assert_eq!(drawn.len(), 1);
    let envelope = &drawn[0];
    assert_eq!(envelope.reason, "pre-whitened, with the lines of the diagnosis");
    let at = (order * TURN_HZ / envelope.bin_hz).round() as usize;
    let peak = envelope.modulation[at - 1..=at + 1].iter().copied().fold(0.0, f64::max);
    let around = envelope.modulation[at - 12..at + 12].iter().copied().fold(0.0, f64::max);
    assert!(peak == around && peak > 0.1, "{peak} {around}");
    assert!(envelope.lines.iter().any(|line| line.label == "DE outer" && (line.hz - order * TURN_HZ).abs() < 1e-9));
    let sound = judged_against(&blows(1.0, 3000.0, STEADY, 0.0, 1), None).envelopes;
    assert!(sound.len() == 1 && sound[0].reason.ends_with("no family of a bearing stands out"));
}

/// A scene of one bearing with two sensors.
const SCENE: &str = "[shaft]\nspeed = \"1500 rpm\"\n[[bearing]]\nname = \"DE\"\nstation = \"0 mm\"\nfacing = \"both\"\n\
    model = \"angular\"\nelements = 9\nball_diameter = \"7.94 mm\"\npitch_diameter = \"39.04 mm\"\ninner_conformity = 0.52\n\
    outer_conformity = 0.52\ncontact_angle = \"0 deg\"\n[recording]\nfile = \"r.csv\"\nrate = \"20 kHz\"\n\
    sensors = [{ column = \"a\", unit = \"g\" }, { column = \"b\", unit = \"g\" }]\n\
    keyphasor = { column = \"k\", pulses_per_turn = 1 }\n";

/// Impacts `order` times a turn in noise at a shaft angle of `turned(t)` revolutions.
fn impacts_of(order: f64, turned: impl Fn(f64) -> f64, seed: u64) -> Vec<f64> {
    let mut noise = noise(seed);
    let mut signal: Vec<f64> = (0..SAMPLES).map(|_| 0.3 * noise()).collect();
    let mut next = 0.5;
    for first in 0..SAMPLES {
        if order * turned(first as f64 / RATE) < next {
            continue;
        }
        next += 1.0;
        for (i, x) in signal.iter_mut().enumerate().skip(first).take(200) {
            let t = (i - first) as f64 / RATE;
            *x += 3.0 * (-900.0 * t).exp() * (TAU * 4100.0 * t).sin();
        }
    }
    signal
}

/// Evaluates impacts at `order` at the first sensor, and noise at the second.
fn evaluated(order: f64, average: u32, turned: impl Fn(f64) -> f64) -> Evaluation {
    let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
    let recording = Recording { average, ..scene.recording.clone().unwrap() };
    let mut signals = Signals::new(&recording, RATE).unwrap();
    let (damaged, sound) = (impacts_of(order, &turned, 3), impacts_of(1.0, |_| 0.0, 4));
    for (index, (a, b)) in damaged.iter().zip(&sound).enumerate() {
        assert!(signals.add(&Row { index: index as u64, sensors: vec![*a, *b], ..Row::default() }));
    }
    for index in 0..(SAMPLES / average as usize) as u64 {
        let time = (index as f64 * f64::from(average) + 0.5 * f64::from(average - 1)) / RATE;
        let revolutions = turned(time);
        let speed = TAU * (turned(time + 5e-5) - turned(time - 5e-5)) / 1e-4;
        signals.add_angle(&Sample {
            row: Row { index, time, ..Row::default() },
            angle: Phase::from_revolutions(revolutions),
            revolution: revolutions.floor() as i64,
            speed,
            ..Sample::default()
        });
    }
    signals.evaluate(&scene, None).unwrap()
}

#[test]
fn orders_are_tracked_while_the_speed_rises() {
    let order = suspect().orders.outer_race;
    for average in [1, 8] {
        // 22 to 31 rev/s within 3 s: the line smears over 32 Hz and its third multiple over 96 Hz.
        let found = evaluated(order, average, |t| 22.0 * t + 1.5 * t * t);
        assert_eq!(found.not_judged, None);
        let [diagnosis] = &found.diagnoses[..] else { panic!("{:?}", found.diagnoses) };
        assert_eq!((diagnosis.kind, diagnosis.bearing.as_deref()), (FaultKind::OuterRace, Some("DE")));
        assert!((diagnosis.order / order - 1.0).abs() < 0.005, "{}", diagnosis.order);
        assert_eq!(diagnosis.evidence, [EvidenceSource::Vibration]);
        assert_eq!(diagnosis.vibration.as_ref().unwrap().sensor, "a");
        assert!((found.speeds_hz[1] - 26.5).abs() < 0.01, "{:?}", found.speeds_hz);
        assert!(found.notes.iter().any(|note| note.contains("equal steps of the shaft angle")), "{:?}", found.notes);
        assert_eq!(found.envelopes.len(), 2);
    }
}

/// A run-up to 1.7 times the first speed.
#[test]
fn a_run_up_is_judged() {
    let Orders { outer_race, inner_race, .. } = suspect().orders;
    for (kind, order) in [(FaultKind::OuterRace, outer_race), (FaultKind::InnerRace, inner_race)] {
        let found = evaluated(order, 1, |t| 14.0 * t + 1.7 * t * t);
        let [diagnosis] = &found.diagnoses[..] else { panic!("{kind:?} {:?} {:?}", found.diagnoses, found.not_judged) };
        assert_eq!(diagnosis.kind, kind);
        assert!((diagnosis.order / order - 1.0).abs() < 0.005, "{}", diagnosis.order);
    }
}

#[test]
fn a_measured_constant_speed_is_not_resampled() {
    let found = evaluated(suspect().orders.inner_race, 1, |t| 24.7 * t);
    assert!(matches!(&found.diagnoses[..], [f] if f.kind == FaultKind::InnerRace), "{:?}", found.diagnoses);
    assert!(!found.notes.iter().any(|note| note.contains("equal steps")));
}

#[test]
fn speeds_that_have_no_verdict() {
    let order = suspect().orders.outer_race;
    let reason = |turned: fn(f64) -> f64| evaluated(order, 1, turned).not_judged.unwrap();
    let varying = reason(|t| 10.0 * t + 4.0 * t * t);
    assert!(varying.ends_with("expected a ratio of 3 or less"), "{varying}");
    assert_eq!(reason(|t| 4.0 * t), "12.0 revolutions of the shaft, expected 16 or more");
    let fast = reason(|t| 700.0 * t);
    assert!(fast.starts_with("the rate of 20000 Hz has no band with the lines of the bearings, expected"), "{fast}");
}
