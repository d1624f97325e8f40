//! Order tracking of a force in the frames of a bearing's components.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::twin::{ForceOrderTracker, ForceOrders};
use ballrace::{BearingKinematicState, Exact, Math, Scalar};

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
