//! Order tracking of a force in the frames of a bearing's components, and the detector of damage in an acceleration.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::kinematics::Orders;
use ballrace::twin::{DamageDetector, DamageVerdict, ForceOrderTracker, ForceOrders};
use ballrace::{BearingKinematicState, Exact, Math, Phase, Scalar};

const HARMONICS: usize = 4;

type Tracker<T> = ForceOrderTracker<T, HARMONICS>;

pub fn all<T: Scalar>(bench: &Bench, precision: &'static str)
where
    Exact: Math<T>,
{
    let name = |function| Name { what: "force orders, 4 harmonics", elements: 0, precision, math: "exact", function };
    let sample = name("sample");
    bench.measure(sample, add::<T> as *const (), ready, |(tracker, force, at)| add(tracker, *force, at));
    bench.measure(name("end of a block"), close::<T> as *const (), added, close);
}

#[inline(never)]
fn add<T: Scalar>(tracker: &mut Tracker<T>, force: [T; 2], at: &BearingKinematicState<T>) -> bool
where
    Exact: Math<T>,
{
    tracker.add::<Exact>(force, at)
}

#[inline(never)]
fn close<T: Scalar>(tracker: &mut Tracker<T>) -> ForceOrders<T, HARMONICS> {
    tracker.close()
}

/// A tracker, and a sample that completes its block for some inputs.
fn ready<T: Scalar>(i: u32) -> (Tracker<T>, [T; 2], BearingKinematicState<T>) {
    let (u, cage) = input::<T>(i);
    let at = BearingKinematicState { inner: cage.wrapping_mul(3), ball: cage.wrapping_mul(7), ..cage.into() };
    (Tracker::new(9, 1 + i % 2, &BearingKinematicState::default()), [u.u, u.v], at)
}

fn added<T: Scalar>(i: u32) -> Tracker<T>
where
    Exact: Math<T>,
{
    let (mut tracker, force, at) = ready(i);
    if !i.is_multiple_of(5) {
        add(&mut tracker, force, &at);
    }
    tracker
}

const ORDERS: Orders = Orders { cage: 0.4, outer_race: 3.6, inner_race: 5.4, ball_spin: 2.4 };

/// The detector, in the precision that firmware takes. A function of its own: it fills a quarter of the memory.
#[inline(never)]
pub fn damage(bench: &Bench) {
    let name = |function| Name { what: "damage detector", elements: 9, precision: "f32", math: "exact", function };
    bench.measure(name("sample"), detect as *const (), listening, |(detector, x, shaft)| detect(detector, *x, *shaft));
    bench.measure(name("verdict on a block"), judge as *const (), heard, |detector| judge(detector, &ORDERS));
}

#[inline(never)]
fn detect(detector: &mut DamageDetector<f32>, x: f32, shaft: Phase) -> bool {
    detector.add(x, shaft)
}

#[inline(never)]
fn judge(detector: &mut DamageDetector<f32>, orders: &Orders) -> DamageVerdict<f32> {
    detector.close::<Exact>(orders)
}

/// A detector, and a sample that completes its block for some inputs.
fn listening(i: u32) -> (DamageDetector<f32>, f32, Phase) {
    let (u, angle) = input::<f32>(i);
    let mut detector = DamageDetector::new();
    for _ in 0..i % 20 {
        detector.add(u.w, Phase::ZERO);
    }
    (detector, u.u, angle)
}

/// Blows with the pass of the outer race in some of the inputs, of whatever size, over one block with its predictor learned.
fn heard(i: u32) -> DamageDetector<f32> {
    let mut detector = DamageDetector::new();
    let mut shaft = Phase::ZERO;
    let ((first, _), (last, _)) = (input::<f32>(i), input::<f32>(i + 1));
    for k in 0..1200_u32 {
        let (noise, _) = input::<f32>(3 * k + 1);
        let pass = shaft.wrapping_mul(36).revolutions() < 0.5;
        let blow = if pass { noise.u * 10.0 } else { noise.u };
        let x = match k {
            50 => first.u,
            1190 if !i.is_multiple_of(4) => last.u,
            _ => blow,
        };
        // Some blocks end early, as do those that begin with their first sample.
        if detector.add(x, shaft) && !i.is_multiple_of(5) {
            detector.close::<Exact>(&ORDERS);
        }
        shaft = shaft.wrapping_add(Phase::from_revolutions(0.11));
    }
    detector
}
