//! Blows of known origin in noise, and what is no blow.

use super::judge::Judge;
use super::suspect::Suspect;
use crate::outcome::{EnvelopeSpectrum, FindingKind};
use crate::scene::Sensor;
use ballrace::bearing::kinematics::{Orders, orders};
use std::f64::consts::TAU;

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

/// Blows `order` times a turn, ringing at `ring` (Hz), in noise; `modulated` with the shaft as a damaged inner race's are.
fn blows(order: f64, ring: f64, modulated: f64, loud: f64, seed: u64) -> Vec<f64> {
    let mut noise = noise(seed);
    let mut signal: Vec<f64> = (0..SAMPLES).map(|_| 0.3 * noise()).collect();
    let mut at = 0.01;
    while at < SAMPLES as f64 / RATE {
        let strength = loud * (1.0 + modulated * (TAU * TURN_HZ * at).cos()) / (1.0 + modulated);
        let first = (at * RATE).ceil() as usize;
        for (i, x) in signal.iter_mut().enumerate().skip(first).take(200) {
            let t = i as f64 / RATE - at;
            *x += strength * (-900.0 * t).exp() * (TAU * ring * t).sin();
        }
        // Rollers are not clockwork: a twentieth of a percent of jitter.
        at += (1.0 + 5e-4 * noise()) / (order * TURN_HZ);
    }
    signal
}

fn suspect() -> Suspect {
    let gamma = 7.94 / 39.04;
    Suspect { name: "DE".to_owned(), station: 0.0, orders: orders(9, gamma, gamma), elements: 9 }
}

fn judged(signal: &[f64]) -> (Vec<(FindingKind, f64)>, Vec<EnvelopeSpectrum>) {
    let sensor = Sensor { column: "a".to_owned(), unit: "g".to_owned(), bearing: None };
    let suspects = [suspect()];
    let judge = Judge { suspects: &suspects, turn_hz: TURN_HZ, rate: RATE, baseline: None };
    let (findings, _, drawn) = judge.all(std::iter::once((&sensor, signal)));
    (findings.iter().map(|f| (f.kind, f.order)).collect(), drawn)
}

fn found(signal: &[f64]) -> Vec<(FindingKind, f64)> {
    judged(signal).0
}

#[test]
fn each_part_is_told_by_its_blows() {
    let Orders { outer_race, inner_race, ball_spin, .. } = suspect().orders;
    let parts = [
        (FindingKind::OuterRace, outer_race, 0.0),
        (FindingKind::InnerRace, inner_race, 0.8),
        (FindingKind::Element, 2.0 * ball_spin, 0.0),
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
        assert!(found(&blows(1.0, 3000.0, 0.0, 0.0, seed)).is_empty(), "noise {seed}");
        assert!(found(&blows(1.0, 3000.0, 0.0, 3.0, seed)).is_empty(), "a blow a turn {seed}");
        assert!(found(&blows(2.0, 5000.0, 0.0, 3.0, seed)).is_empty(), "two blows a turn {seed}");
    }
}

/// The line of the damage is the highest of the drawn spectrum about it; sound signals have a picture too.
#[test]
fn the_band_that_is_drawn_shows_the_line() {
    let order = suspect().orders.outer_race;
    let (_, drawn) = judged(&blows(order, 4100.0, 0.0, 3.0, 1));
    assert_eq!(drawn.len(), 1);
    let envelope = &drawn[0];
    assert_eq!(envelope.reason, "the band on which the finding rests");
    let at = (order * TURN_HZ / envelope.bin_hz).round() as usize;
    let peak = envelope.modulation[at - 1..=at + 1].iter().copied().fold(0.0, f64::max);
    let around = envelope.modulation[at - 12..at + 12].iter().copied().fold(0.0, f64::max);
    assert!(peak == around && peak > 0.25, "{peak} {around}");
    assert!(envelope.lines.iter().any(|line| line.label == "DE outer" && (line.hz - order * TURN_HZ).abs() < 1e-9));
    let (_, sound) = judged(&blows(1.0, 3000.0, 0.0, 0.0, 1));
    assert!(sound.len() == 1 && sound[0].reason.starts_with("the most impulsive band"));
}
