//! The radial bearing on counts, and beside it the one in software floats.

use super::bearings::force;
use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::fixed_point::{self, RadialParams};
use ballrace::bearing::lumped::Radial;
use ballrace::contact::law::PointContactLaw;
use ballrace::{Exact, Phase};
use core::hint::black_box;

/// Counts that a branch on a value would betray itself on.
const SPECIAL: [i32; 8] = [0, 1, -1, i32::MAX, i32::MIN, 1 << 30, -(1 << 30), 21_474];

pub fn all(bench: &Bench) {
    of::<8>(bench);
    of::<9>(bench);
    of::<16>(bench);
}

#[inline(never)]
fn reaction<const N: usize>(bearing: &fixed_point::Radial<N>, u: i32, v: i32, cage: Phase) -> fixed_point::Reaction {
    bearing.reaction(u, v, cage)
}

/// Input number `i` of the floats as counts, or special ones.
fn counts(i: u32) -> (i32, i32, Phase) {
    let (u, cage) = input::<f32>(i);
    let count = |x: f32, k: u32| match SPECIAL.get(k as usize) {
        Some(special) if i.is_multiple_of(3) => *special,
        _ => (x * 2e13) as i32,
    };
    (count(u.u, i / 3 % 11), count(u.v, i / 33 % 11), cage)
}

fn of<const N: usize>(bench: &Bench) {
    let params = RadialParams { stiffness: 8e9, exponent: 1.5, radial_play: 5e-6, range: 100e-6 };
    let Ok(bearing) = fixed_point::Radial::<N>::try_new(Phase::ZERO, &params) else { return };
    let bearing = black_box(bearing);
    let name = |precision| Name { what: "radial", elements: N, precision, math: "exact", function: "force" };
    bench.measure(name("Q31"), reaction::<N> as *const (), counts, |(u, v, cage)| reaction(&bearing, *u, *v, *cage));
    let law = PointContactLaw { stiffness: 8e9 };
    let float = Radial::<f32, Exact, _, _>::from_constants(evenly_spaced::<f32, N>(Phase::ZERO), law, 5e-6);
    let float = black_box(float);
    bench.measure(name("f32"), reaction::<N> as *const (), input::<f32>, |(u, cage)| force(&float, u, *cage));
}
