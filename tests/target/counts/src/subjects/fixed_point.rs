//! Bearings on counts: radial and axial elements, balls in a table.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use baked::bearings::{bearing_de, bearing_nde};
use ballrace::bearing::ElementPositions;
use ballrace::bearing::fixed_point::{self, AxialParams, RadialParams, TabulatedParams, TabulatedReaction};
use ballrace::bearing::tabulated::{Node, Tabulated};
use ballrace::{Exact, Phase};
use core::hint::black_box;

/// Counts that a branch on a value would betray itself on.
const SPECIAL: [i32; 8] = [0, 1, -1, i32::MAX, i32::MIN, 1 << 30, -(1 << 30), 21_474];

pub fn all(bench: &Bench) {
    of::<8>(bench);
    of::<9>(bench);
    of::<16>(bench);
    let de = bearing_de::bearing();
    table::<8, 2>(bench, "tabulated", &de, false);
    // Without its waviness and spall, which are of floats.
    let of = &bearing_nde::bearing().0;
    let nde = Tabulated::new(bearing_nde::POSITIONS, *of.constants(), *of.table(), false);
    table::<9, 3>(bench, "tabulated, friction, mirrored", &nde, true);
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

#[inline(never)]
fn looked_up<const N: usize, const F: usize>(
    bearing: &OnCounts<N, F>,
    [u, v, w, x, y]: [i32; 5],
    cage: Phase,
) -> TabulatedReaction {
    bearing.reaction(u, v, w, x, y, cage)
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

/// Nodes of one speed of the baked tables: 19 along the approach, 11 along the angle.
const LAYER: usize = 19 * 11;

type OnCounts<const N: usize, const F: usize> = fixed_point::Tabulated<N, [[i32; F]; LAYER], F>;
type OfFloats<const N: usize, const F: usize> =
    Tabulated<f32, Exact, ElementPositions<f32, N>, &'static [Node<f32, F>], F>;

/// Input number `i` of the floats as five counts, tilts at the lever arm, one or two of them special.
fn five_counts(i: u32) -> ([i32; 5], Phase) {
    let (u, cage) = input::<f32>(i);
    let mut counts = [u.u, u.v, u.w, 0.02 * u.thu, 0.02 * u.thv].map(|x| (x * 2e12) as i32);
    if i.is_multiple_of(3) {
        let k = i as usize / 3;
        for (place, special) in [(k % 5, k / 5 % 8), ((k + 1) % 5, k / 40 % 8)] {
            if let (Some(count), Some(special)) = (counts.get_mut(place), SPECIAL.get(special)) {
                *count = *special;
            }
        }
    }
    (counts, cage)
}

fn table<const N: usize, const F: usize>(bench: &Bench, what: &'static str, of: &OfFloats<N, F>, mirrored: bool) {
    let params = TabulatedParams { speed: 1256.0, range: 1e-3, mirrored };
    let Ok(bearing) = OnCounts::<N, F>::try_new(of, &params, [[0; F]; LAYER]) else { return };
    let bearing = black_box(bearing);
    let name = Name { what, elements: N, precision: "Q31", math: "exact", function: "force" };
    bench.measure(name, looked_up::<N, F> as *const (), five_counts, |(counts, cage)| {
        looked_up(&bearing, *counts, *cage)
    });
}
