//! Indicators against signals whose figures are known, over lengths at which plain sums would drift.

use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::rotor::{ComponentAngles, SpeedRatios};
use ballrace::twin::{CompensatedSum, Envelope, Life, LifeParams, OrderLine, OrderTracker, Statistics};
use ballrace::{Exact, Phase};
use std::f64::consts::TAU;

#[test]
fn sums_lose_nothing() {
    let mut sum = CompensatedSum::<f32>::new();
    for _ in 0..10_000_000 {
        sum.add(0.1);
    }
    // Ten million times the f32 next to 0.1; a plain sum is off by 9 %.
    let truth = 1e7 * f64::from(0.1_f32);
    assert!((f64::from(sum.value()) / truth - 1.0).abs() < 1e-7, "{}", sum.value());
}

/// A sine on an offset a thousand times as large, in `f32`.
#[test]
fn statistics_of_a_sine() {
    let mut statistics = Statistics::<f32>::new(1000);
    let mut last = None;
    for i in 0..5000 {
        let x = 1e-3 + 1e-6 * (TAU * f64::from(i) / 100.0).sin();
        last = statistics.add::<Exact>(x as f32).or(last);
    }
    let found = last.unwrap();
    // The samples themselves are rounded to 1e-10.
    assert!((f64::from(found.mean) - 1e-3).abs() < 1e-9);
    assert!((f64::from(found.rms) / (1e-6 / 2_f64.sqrt()) - 1.0).abs() < 1e-3, "{found:?}");
    assert!((found.peak_to_peak / 2e-6 - 1.0).abs() < 1e-3);
    assert!((found.crest_factor - 2_f32.sqrt()).abs() < 2e-3);
    assert!((found.kurtosis - 1.5).abs() < 3e-3);
}

#[test]
fn statistics_of_nothing() {
    let mut statistics = Statistics::<f64>::new(8);
    for _ in 0..7 {
        assert!(statistics.add::<Exact>(2.5).is_none());
    }
    let found = statistics.add::<Exact>(2.5).unwrap();
    assert_eq!((found.mean, found.rms, found.crest_factor, found.kurtosis), (2.5, 0.0, 0.0, 0.0));
}

const LINES: [OrderLine; 4] = [
    OrderLine { shaft: 1, cage: 0, ball: 0 },
    OrderLine { shaft: 2, cage: 0, ball: 0 },
    OrderLine { shaft: 0, cage: 9, ball: 0 },
    OrderLine { shaft: 10, cage: -9, ball: 0 },
];

/// 1X, 2X, outer ball pass and a side band of the inner one through a run-up from 600 to 6000 rpm, either way round, and
/// after the counters have turned a hundred million times.
#[test]
fn orders_through_a_run_up() {
    let truth = [[3.0, -1.0], [0.5, 0.25], [0.0, 0.8], [0.1, 0.2]];
    for sense in [1.0, -1.0] {
        let speed_ratios = SpeedRatios::<f64>::new(0.398_31);
        let mut shaft = Phase::from_revolutions(0.3).wrapping_mul(100_000_001);
        let mut parts = ComponentAngles::from(Phase::from_revolutions(0.77));
        let mut tracker = OrderTracker::<f64, 4>::new(LINES, 16, shaft);
        let (mut time, rate, mut blocks) = (0.0, 12_800.0, 0);
        while blocks < 4 {
            let mut x = 5.0;
            for (line, [c, s]) in LINES.iter().zip(truth) {
                let p = line.angle(shaft, &parts).radians();
                x += c * p.cos() + s * p.sin();
            }
            if tracker.add::<Exact>(x, shaft, &parts) {
                blocks += 1;
                for (found, truth) in tracker.vectors().iter().zip(truth) {
                    for (a, b) in found.iter().zip(truth) {
                        // What an offset of 5 and the neighbours leak through the window.
                        assert!((a - b).abs() < 0.02, "block {blocks}: {:?}", tracker.vectors());
                    }
                }
            }
            let speed = sense * (10.0 + 45.0 * time);
            let arc = ballrace::phase::PhaseDelta::from_radians(TAU * speed / rate);
            (shaft, parts) = (shaft.advanced(arc), speed_ratios.advance(parts, arc));
            time += 1.0 / rate;
        }
    }
}

/// A tone that swells by 40 % 90 times a second, and another one outside of the band that does not matter.
#[test]
fn envelope_of_a_swelling_tone() {
    let rate = 20_000.0;
    let mut envelope = Envelope::<f64>::new(4000.0, 500.0, rate);
    for i in 0..40_000 {
        let t = f64::from(i) / rate;
        let loud = 1.0 + 0.4 * (TAU * 90.0 * t).cos();
        let found = envelope.add::<Exact>(loud * (TAU * 4100.0 * t).sin() + 2.0 * (TAU * 1000.0 * t).sin());
        // The filter delays by 0.87 turn of its corner: sqrt(4 + 2 sqrt 2)/(2 pi 500 Hz).
        let delayed = 1.0 + 0.4 * (TAU * 90.0 * (t - 2.613_126 / (TAU * 500.0))).cos();
        assert!(i < 4000 || (found - delayed).abs() < 0.03, "{t}: {found} {delayed}");
    }
}

/// A deep groove bearing under 1000 N radially, without play; ISO 16281 with ISO's constants says 13162.77 and
/// MASTA 13163.019 million turns.
#[test]
fn life_of_the_published_bearing() {
    let geometry = BallBearingGeometry {
        ball_diameter: 11.5e-3,
        pitch_diameter: 43.5e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.53,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    let params = LifeParams::try_new(geometry, 7, 23_400.0).unwrap();
    let loads = [619.614, 305.046, 0.0, 0.0, 0.0, 0.0, 305.046];
    let mut life = Life::<f64>::new(&params);
    life.add::<Exact>(&loads);
    let found = life.close::<Exact>(1e6);
    assert!((found / 13_162.77 - 1.0).abs() < 1e-4, "{found}");
    assert!((life.used() * found - 1.0).abs() < 1e-9);
    // A year at 3000 rpm in blocks of a second, in f32: the sum of the parts.
    let mut life = Life::<f32>::new(&params);
    for _ in 0..365 * 24 * 3600 {
        life.add::<Exact>(&loads.map(|q| q as f32));
        life.close::<Exact>(50.0);
    }
    let used = 365.0 * 24.0 * 3600.0 * 50e-6 / found;
    assert!((f64::from(life.used()) / used - 1.0).abs() < 1e-5, "{} {used}", life.used());
    assert!(LifeParams::try_new(geometry, 7, -1.0).is_err());
    let mut idle = Life::<f64>::new(&params);
    idle.add::<Exact>(&[0.0; 7]);
    assert!(idle.close::<Exact>(1e6).is_infinite() && idle.used() == 0.0);
}
