//! Indicators against signals whose figures are known, over lengths at which plain sums would drift.

use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::rotor::{ComponentAngles, SpeedRatios};
use ballrace::twin::{
    CompensatedSum, Envelope, ForceLine, ForceOrderTracker, ForceOrders, Life, LifeParams, OrderLine, OrderTracker,
    Statistics,
};
use ballrace::{BearingKinematicState, Exact, Math, Phase, Scalar};
use nalgebra::Complex;
use std::f64::consts::TAU;

#[test]
fn compensated_sums_keep_their_digits() {
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

/// The same in `f64` with plain sums about a reading, over a second of a fast recording.
#[test]
fn plain_sums_about_a_reading_have_digits_to_spare() {
    let mut statistics = Statistics::<f64, f64>::about(1.001e-3, u32::MAX);
    for i in 0..51_200 {
        let x = 1e-3 + 1e-6 * (TAU * f64::from(i) / 100.0).sin();
        assert!(statistics.add::<Exact>(x).is_none());
    }
    let found = statistics.close::<Exact>();
    assert!((found.mean - 1e-3).abs() < 1e-15, "{found:?}");
    // The samples themselves are rounded to 1e-13 of the amplitude.
    assert!((found.rms / (1e-6 / 2_f64.sqrt()) - 1.0).abs() < 1e-10, "{found:?}");
    assert!((found.kurtosis - 1.5).abs() < 1e-9, "{found:?}");
}

#[test]
fn statistics_without_samples() {
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

/// 1X, 2X, outer ball pass and a side band of the inner one through a run-up from 600 to 6000 rpm, in both senses of rotation, and
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

const ELEMENTS: u32 = 9;
const BLOCK: u32 = 32;
/// Harmonics of the pulses of a made-up defect, N.
const PULSES: [f64; 3] = [4.0, 2.0, 1.0];

/// Component of a bearing that carries a force.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Component {
    Outer,
    Inner,
    Element,
}

const COMPONENTS: [Component; 3] = [Component::Outer, Component::Inner, Component::Element];

impl Component {
    /// Angles of the frame and of the fundamental in rad, written out independently of the kernel's.
    fn angles(self, at: &BearingKinematicState<f64>) -> [f64; 2] {
        let [inner, cage, outer, ball] = [at.inner, at.cage, at.outer, at.ball].map(Phase::radians);
        let n = f64::from(ELEMENTS);
        match self {
            Self::Outer => [outer, n * (cage - outer)],
            Self::Inner => [inner, n * (inner - cage)],
            Self::Element => [cage, -2.0 * ball],
        }
    }

    /// A force of the fixed direction `azimuth` in the frame of this component.
    fn force(self, azimuth: f64, at: &BearingKinematicState<f64>) -> Complex<f64> {
        let [frame, fundamental] = self.angles(at);
        let pulses = PULSES.iter().zip(1..).map(|(a, k)| a * (f64::from(k) * fundamental - 0.4).cos());
        Complex::from_polar(pulses.sum(), frame + azimuth)
    }

    fn of<T: Copy, const H: usize>(self, orders: &ForceOrders<T, H>) -> [ForceLine<T>; H] {
        match self {
            Self::Outer => orders.outer,
            Self::Inner => orders.inner,
            Self::Element => orders.element,
        }
    }
}

/// Kinematic states of a run-up that ends with the block, from any angles.
fn run_up(sense: f64, outer: f64) -> Vec<BearingKinematicState<f64>> {
    // A ball spin whose lines are ten cycles per block or more from those of the rings.
    let ratios = SpeedRatios::<f64>::new(0.398_31).with_ball(-2.156_17).with_outer(outer);
    let mut parts = ComponentAngles { cage: Phase::from_revolutions(0.77), ball: Phase(12), outer: Phase(1 << 61) };
    let (mut shaft, mut states, mut done) = (Phase::from_revolutions(0.3), vec![], 0.0);
    let turns = f64::from(BLOCK) / (1.0 - outer).abs();
    loop {
        states.push(BearingKinematicState {
            cage: parts.cage,
            inner: shaft,
            outer: parts.outer,
            ball: parts.ball,
            ..BearingKinematicState::default()
        });
        if done > turns {
            return states;
        }
        // The speed doubles.
        let step = (1.0 + done / turns) / 400.0;
        let arc = ballrace::phase::PhaseDelta::from_radians(TAU * sense * step);
        (shaft, parts) = (shaft.advanced(arc), ratios.advance(parts, arc));
        done += step;
    }
}

fn tracked<T: Scalar, const H: usize>(
    states: &[BearingKinematicState<f64>],
    force: impl Fn(&BearingKinematicState<f64>) -> Complex<f64>,
) -> ForceOrders<T, H>
where
    Exact: Math<T>,
{
    let of = |at: &BearingKinematicState<f64>| BearingKinematicState::<T> {
        cage: at.cage,
        inner: at.inner,
        outer: at.outer,
        ball: at.ball,
        ..BearingKinematicState::default()
    };
    let mut tracker = ForceOrderTracker::<T, H>::new(ELEMENTS, BLOCK, &of(&states[0]));
    for (i, at) in states.iter().enumerate() {
        let force = force(at);
        let complete = tracker.add::<Exact>([force.re, force.im].map(T::from_f64), &of(at));
        assert_eq!(complete, i + 1 == states.len(), "sample {i} of {}", states.len());
    }
    tracker.close()
}

fn complex<T: Scalar>([re, im]: [T; 2]) -> Complex<f64> {
    Complex::new(re.to_f64(), im.to_f64())
}

/// Each component in its own frame, and nothing in the two others.
#[test]
fn a_force_of_fixed_direction_has_lines_in_its_own_frame_only() {
    for (sense, outer) in [(1.0, 0.0), (-1.0, 0.0), (1.0, -0.3)] {
        let states = run_up(sense, outer);
        for component in COMPONENTS {
            for azimuth in [-1.2_f64, 0.3, 1.5] {
                let orders: ForceOrders<f64, 3> = tracked(&states, |at| component.force(azimuth, at));
                for other in COMPONENTS {
                    for (line, amplitude) in other.of(&orders).iter().zip(PULSES) {
                        let [forward, backward] = [line.forward, line.backward].map(|a| complex(a).norm());
                        let says = format!("{component:?} in {other:?}: {line:?}");
                        if other == component {
                            // A linear oscillation is the sum of two equal circular motions.
                            assert!((forward - 0.5 * amplitude).abs() < 1e-3, "{says}");
                            assert!((backward - 0.5 * amplitude).abs() < 1e-3, "{says}");
                            assert!(line.polarisation().abs() < 1e-3, "{says}");
                            let found = 0.5 * complex(line.double_direction()).arg();
                            assert!((found - azimuth).sin().abs() < 1e-3, "{found} {azimuth}: {says}");
                        } else {
                            assert!(forward.max(backward) < 1e-3, "{says}");
                        }
                    }
                }
            }
        }
    }
}

/// A rotating force: one amplitude, in both senses of rotation.
#[test]
fn a_rotating_force_is_circular() {
    for sense in [1.0, -1.0] {
        let states = run_up(sense, 0.0);
        for (direction, expected) in [(1.0, 1.0), (-1.0, -1.0)] {
            let pass = |at: &BearingKinematicState<f64>| Component::Outer.angles(at)[1];
            let orders: ForceOrders<f64, 2> = tracked(&states, |at| Complex::from_polar(3.0, direction * pass(at)));
            let [line, second] = orders.outer;
            assert!((line.polarisation() - expected).abs() < 1e-6, "{line:?}");
            assert!((complex(line.forward).norm() + complex(line.backward).norm() - 3.0).abs() < 1e-3, "{line:?}");
            assert!(complex(second.forward).norm() < 1e-3, "{second:?}");
        }
    }
    assert_eq!(ForceLine::<f32>::default().polarisation(), 0.0);
}

/// All three components and a constant load at once, against sums written out in `f64`.
#[test]
fn force_orders_are_those_of_direct_summation() {
    let states = run_up(1.0, -0.3);
    let force = |at: &BearingKinematicState<f64>| {
        COMPONENTS.iter().zip([0.2, -0.9, 1.1]).map(|(c, azimuth)| c.force(azimuth, at)).sum::<Complex<f64>>()
            + Complex::new(7.0, -40.0)
    };
    let (doubles, singles) = (tracked::<f64, 4>(&states, force), tracked::<f32, 4>(&states, force));
    let start = (states[0].inner, states[0].outer);
    let turned = |at: &BearingKinematicState<f64>| {
        let part = at.inner.wrapping_add(at.outer.reversed()).since(start.0.wrapping_add(start.1.reversed()));
        TAU.recip() * part.radians::<f64>()
    };
    let mut weights = vec![];
    let (mut last, mut turns) = (0.0, 0.0);
    for at in &states {
        let now = turned(at);
        turns += now - last - (now - last).round();
        last = now;
        weights.push((std::f64::consts::PI * turns / f64::from(BLOCK)).sin().powi(2));
    }
    let weight: f64 = weights.iter().sum();
    for component in COMPONENTS {
        for k in 1..=4 {
            let sum = |sign: f64| {
                let of = |(at, w): (&BearingKinematicState<f64>, &f64)| {
                    let [frame, fundamental] = component.angles(at);
                    force(at) * Complex::from_polar(w / weight, -frame - sign * k as f64 * fundamental)
                };
                states.iter().zip(&weights).map(of).sum::<Complex<f64>>()
            };
            for (sign, is_forward) in [(1.0, true), (-1.0, false)] {
                let truth = sum(sign);
                let (double, single) = (component.of(&doubles)[k - 1], component.of(&singles)[k - 1]);
                let double = complex(if is_forward { double.forward } else { double.backward });
                let single = complex(if is_forward { single.forward } else { single.backward });
                assert!((double - truth).norm() < 1e-11, "{component:?} {k} {sign}: {double} {truth}");
                assert!((single - truth).norm() < 2e-5, "{component:?} {k} {sign}: {single} {truth}");
            }
        }
    }
}

/// A defect of the inner race in the fixed frame: shaft side bands, forward above and backward below, and nothing between
/// them.
#[test]
fn an_inner_race_force_has_only_side_bands_in_the_fixed_frame() {
    let (n, azimuth) = (ELEMENTS as i32, 0.6);
    let at_side_band = |k: i32, side| OrderLine { shaft: k * n + side, cage: -k * n, ball: 0 };
    let lines: [OrderLine; 9] = std::array::from_fn(|i| at_side_band(i as i32 / 3 + 1, i as i32 % 3 - 1));
    let states = run_up(1.0, 0.0);
    let mut trackers = [OrderTracker::<f64, 9>::new(lines, BLOCK, states[0].inner); 2];
    for at in &states {
        let force = Component::Inner.force(azimuth, at);
        let parts = ComponentAngles { cage: at.cage, ball: at.ball, outer: at.outer };
        for (tracker, x) in trackers.iter_mut().zip([force.re, force.im]) {
            tracker.add::<Exact>(x, at.inner, &parts);
        }
    }
    let [x, y] = trackers.each_ref().map(OrderTracker::vectors);
    for (i, ([cx, sx], [cy, sy])) in x.iter().zip(y).enumerate() {
        let (forward, backward) = (0.5 * (cx + sy).hypot(cy - sx), 0.5 * (cx - sy).hypot(cy + sx));
        let half = 0.5 * PULSES[i / 3];
        let expected = match i % 3 {
            0 => [0.0, half],
            1 => [0.0, 0.0],
            _ => [half, 0.0],
        };
        for (found, expected) in [forward, backward].into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{:?}: {forward} forward, {backward} backward", lines[i]);
        }
    }
}

/// A reading that is no number spoils one block.
#[test]
fn a_force_block_forgets_the_last() {
    let states = run_up(1.0, 0.0);
    let mut tracker = ForceOrderTracker::<f64, 1>::new(ELEMENTS, BLOCK, &states[0]);
    tracker.add::<Exact>([f64::NAN, 1.0], &states[40]);
    assert!(tracker.close().outer[0].forward[0].is_nan());
    assert_eq!(tracker.close().outer[0], ForceLine::default());
    tracker.add::<Exact>([1.0, 0.0], &states[80]);
    assert!(tracker.close().outer[0].forward[0].is_finite());
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

/// A deep groove bearing under 1000 N radially, without play; ISO 16281 with ISO's constants gives 13162.77 and
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
