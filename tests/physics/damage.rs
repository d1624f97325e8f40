//! The damage detector: impacts of known origin in noise, and signals without damage.

use ballrace::bearing::kinematics::{Orders, orders};
use ballrace::twin::{DamageDetector, DamageVerdict, DamagedComponent};
use ballrace::{Exact, Math, Phase, Scalar};
use std::f64::consts::TAU;

const RATE: f64 = 12_000.0;
const TURN_HZ: f64 = 29.3;
/// Learning and three blocks.
const TURNS: f64 = 202.0;

/// Uniform numbers, -1 to 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn bearing() -> Orders {
    let ratio = 7.94 / 39.04;
    orders(9, ratio, ratio)
}

/// An acceleration and the revolutions of the shaft, sample by sample.
struct Machine {
    /// Impacts in a revolution, the resonance that each excites, Hz, and their strength over the noise.
    impacts: f64,
    ring: f64,
    strength: f64,
    /// Depth and order of the modulation: impacts are stronger while the damage is in the load zone.
    modulation: (f64, f64),
    /// Amplitudes of the multiples of the shaft speed.
    shaft: [f64; 3],
    /// Share by which the shaft speed rises.
    run_up: f64,
    /// Constant acceleration: gravity.
    offset: f64,
    seed: u64,
}

const QUIET: Machine = Machine {
    impacts: 1.0,
    ring: 2500.0,
    strength: 0.0,
    modulation: (0.0, 1.0),
    shaft: [0.0; 3],
    run_up: 0.0,
    offset: 0.0,
    seed: 1,
};

impl Machine {
    fn samples(&self) -> Vec<(f64, f64)> {
        let mut noise = noise(self.seed);
        let duration = TURNS / (TURN_HZ * (1.0 + 0.5 * self.run_up));
        let (decay, turn) = ((-900.0 / RATE).exp(), TAU * self.ring / RATE);
        let (mut next, mut last) = (0.3, [0.0; 2]);
        let sample = |i: u32| {
            let t = f64::from(i) / RATE;
            let turns = TURN_HZ * (t + 0.5 * self.run_up * t * t / duration);
            let mut blow = 0.0;
            if turns >= next {
                let (depth, order) = self.modulation;
                blow = self.strength * (1.0 + depth * (TAU * order * turns).cos()) / (1.0 + depth);
                // The slip of the elements varies the interval.
                next += (1.0 + 5e-4 * noise()) / self.impacts;
            }
            let ringing = blow + 2.0 * decay * turn.cos() * last[0] - decay * decay * last[1];
            last = [ringing, last[0]];
            let shaft = self.shaft.iter().zip(1..).map(|(a, k)| a * (TAU * f64::from(k) * turns).sin()).sum::<f64>();
            (ringing + 0.3 * noise() + shaft + self.offset, turns)
        };
        (0..(duration * RATE) as u32).map(sample).collect()
    }

    fn verdict(&self) -> DamageVerdict<f32> {
        verdict(&self.samples())
    }
}

fn verdict<T: Scalar>(samples: &[(f64, f64)]) -> DamageVerdict<T>
where
    Exact: Math<T>,
{
    let mut detector = DamageDetector::new();
    let mut verdict = DamageVerdict::default();
    for (x, turns) in samples {
        if detector.add(T::from_f64(*x), Phase::from_revolutions(*turns)) {
            verdict = detector.close::<Exact>(&bearing());
        }
    }
    verdict
}

#[test]
fn each_component_is_named_by_its_impacts() {
    let Orders { outer_race, inner_race, ball_spin, cage } = bearing();
    let parts = [
        (DamagedComponent::OuterRace, outer_race, (0.0, 1.0)),
        (DamagedComponent::InnerRace, inner_race, (0.8, 1.0)),
        (DamagedComponent::Element, 2.0 * ball_spin, (0.0, 1.0)),
        (DamagedComponent::Element, 2.0 * ball_spin, (0.8, cage)),
    ];
    for (seed, (component, order, modulation)) in (0..).zip(parts) {
        for (ring, slip, run_up) in [(1300.0, -0.01, 0.0), (2500.0, 0.0, 0.5), (4700.0, 0.01, 0.0)] {
            let impacts = order * (1.0 + slip);
            let machine = Machine { impacts, ring, strength: 2.0, modulation, run_up, offset: 9.81, seed, ..QUIET };
            let found = machine.verdict();
            assert_eq!(found.named, Some(component), "{ring} {slip}: {found:?}");
            let hypothesis = found.hypotheses[DamagedComponent::ALL.iter().position(|c| *c == component).unwrap()];
            assert!((f64::from(hypothesis.order) / impacts - 1.0).abs() < 2e-3, "{found:?}");
            assert_eq!(found.blocks, 3);
        }
    }
}

#[test]
fn noise_and_the_shaft_are_no_damage() {
    for seed in 0..20 {
        let quiet = Machine { seed, ..QUIET };
        assert_eq!(quiet.verdict().named, None, "noise {seed}");
        let unbalanced = Machine { shaft: [5.0, 2.0, 1.0], ..quiet };
        assert_eq!(unbalanced.verdict().named, None, "shaft {seed}");
        for impacts in [1.0, 2.0, 3.0] {
            let knocks = Machine { impacts, strength: 2.0, shaft: [5.0, 2.0, 1.0], seed, ..QUIET };
            assert_eq!(knocks.verdict().named, None, "{impacts} a turn {seed}");
        }
    }
}

/// The lines of another bearing, or a wrong geometry: impacts 4 % beside the orders of the components.
#[test]
fn a_family_at_another_order_is_no_damage() {
    let Orders { outer_race, inner_race, ball_spin, .. } = bearing();
    for order in [outer_race, inner_race, 2.0 * ball_spin] {
        for share in [-0.04, 0.04] {
            let other = Machine { impacts: order * (1.0 + share), strength: 2.0, ..QUIET };
            assert_eq!(other.verdict().named, None, "{order} {share}: {:?}", other.verdict());
        }
    }
}

/// A reading that is no number spoils its block.
#[test]
fn the_detector_recovers_from_readings_that_are_no_numbers() {
    let machine = Machine { impacts: bearing().outer_race, strength: 2.0, ..QUIET };
    let mut samples = machine.samples();
    let middle = samples.len() / 2;
    for (sample, bad) in samples[middle..].iter_mut().zip([f64::NAN, f64::INFINITY, 1e30]) {
        sample.0 = bad;
    }
    let found = verdict::<f32>(&samples);
    assert_eq!((found.named, found.blocks), (Some(DamagedComponent::OuterRace), 2), "{found:?}");
    let constant: Vec<_> = samples.iter().map(|(_, turns)| (1.0, *turns)).collect();
    let found = verdict::<f32>(&constant);
    assert_eq!((found.named, found.blocks), (None, 0), "{found:?}");
}

/// Samples that arrive during a verdict are lost, on a machine with a strong tone.
#[test]
fn samples_between_blocks_may_be_missing() {
    let machine = Machine { impacts: bearing().outer_race, strength: 1.0, shaft: [0.0, 0.0, 40.0], ..QUIET };
    let samples = machine.samples();
    let (mut detector, mut verdict, mut deaf) = (DamageDetector::<f32>::new(), DamageVerdict::default(), 0);
    for (x, turns) in &samples {
        deaf = (deaf - 1).max(0);
        if deaf == 0 && detector.add(*x as f32, Phase::from_revolutions(*turns)) {
            verdict = detector.close::<Exact>(&bearing());
            deaf = 500;
        }
    }
    let whole = machine.verdict();
    assert_eq!((verdict.named, whole.named), (Some(DamagedComponent::OuterRace), Some(DamagedComponent::OuterRace)));
    let modulation = |verdict: &DamageVerdict<f32>| verdict.hypotheses[0].modulation;
    assert!((modulation(&verdict) / modulation(&whole) - 1.0).abs() < 0.05, "{verdict:?} {whole:?}");
}

/// One sensor takes less than 32 kB, the stack of a verdict included.
#[test]
fn the_detector_fits_a_small_memory() {
    assert!(size_of::<DamageDetector<f32>>() <= 25_600, "{}", size_of::<DamageDetector<f32>>());
}

#[test]
fn both_precisions_and_both_senses_of_rotation_agree() {
    let samples = Machine { impacts: bearing().inner_race, strength: 1.0, modulation: (0.8, 1.0), ..QUIET }.samples();
    let (single, double) = (verdict::<f32>(&samples), verdict::<f64>(&samples));
    let back: Vec<_> = samples.iter().map(|(x, turns)| (*x, -turns)).collect();
    let back = verdict::<f64>(&back);
    assert_eq!((single.named, back.named), (double.named, double.named));
    for ((single, double), back) in single.hypotheses.iter().zip(&double.hypotheses).zip(&back.hypotheses) {
        assert!((f64::from(single.evidence) - double.evidence).abs() < 0.02, "{single:?} {double:?}");
        assert!((back.evidence - double.evidence).abs() < 1e-6, "{back:?} {double:?}");
    }
}
