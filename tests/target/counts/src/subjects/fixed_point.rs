//! Radial and axial elements on counts.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::Phase;
use ballrace::bearing::fixed_point::{self, AxialParams, RadialParams};
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

#[inline(never)]
fn axial<const N: usize>(
    bearing: &fixed_point::Axial<N>,
    [w, x, y]: [i32; 3],
    cage: Phase,
) -> fixed_point::AxialReaction {
    bearing.reaction(w, x, y, cage)
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
    let name = Name { what: "radial 3/2", elements: N, precision: "Q31", math: "exact", function: "force" };
    bench.measure(name, reaction::<N> as *const (), counts, |(u, v, cage)| reaction(&bearing, *u, *v, *cage));
    let params = AxialParams { stiffness: 1e9, exponent: 1.5, axial_play: 5e-6, radius: 20e-3, range: 100e-6 };
    let Ok(bearing) = fixed_point::Axial::<N>::try_new(Phase::ZERO, &params) else { return };
    let bearing = black_box(bearing);
    let name = Name { what: "axial 3/2", ..name };
    bench.measure(name, axial::<N> as *const (), counts, |(u, v, cage)| axial(&bearing, [*v, *u, *v], *cage));
}
