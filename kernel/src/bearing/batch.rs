//! Many samples at once, in arrays, for the desktop.

use super::element_position::{ElementLayout, ElementPosition};
use super::lumped::Radial;
use crate::contact::law::LoadDeflectionLaw;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Samples a pass of [`radial_batch`] goes over: their arrays stay in the first-level cache from pass to pass, and
/// what a pass costs besides is spread over many.
const SAMPLES: usize = 256;

/// Elements a pass takes together: their directions and sums are as much as 16 vector registers hold.
const BLOCK_SIZE: usize = 4;

/// Many samples at once in structure-of-arrays form: `fx[i], fy[i]` from `u[i], v[i]`, the cage standing at `cage`.
///
/// The compiler turns the loops into the system's vector instructions. Stops at the shortest of the four slices.
/// The forces are those of [`super::Bearing::reaction`] but for rounding. Elements that stand in opposite pairs (an even
/// number, evenly spaced) and have no preload share a square root: of two opposite ones at most one is loaded.
pub fn radial_batch<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: AsRef<[ElementPosition<T>]> + Send + Sync>(
    bearing: &Radial<T, M, L, P>,
    cage: Phase,
    input: (&[T], &[T]),
    output: (&mut [T], &mut [T]),
) {
    let Radial { ring, law, play, .. } = bearing;
    let turn = M::sin_cos(cage);
    let load = |deflection: T| {
        let [shape] = law.unscaled_load([deflection.twice_positive_part()]);
        ring.scale * shape
    };
    match one_of_each_pair(ring.positions.stored()) {
        Some(half) if *play >= T::ZERO => {
            sum_of_elements(half, turn, input, output, |radial| load(radial.abs() - *play).xor_sign(radial));
        }
        _ => sum_of_elements(ring.positions.stored(), turn, input, output, |radial| load(radial - *play)),
    }
}
/// The first half of the positions if each position of the second half stands opposite to its own in the first.
fn one_of_each_pair<T: Scalar>(positions: &[ElementPosition<T>]) -> Option<&[ElementPosition<T>]> {
    let (half, other) = positions.split_at(positions.len() / 2);
    let opposite = |(a, b): (&ElementPosition<T>, &ElementPosition<T>)| a.azimuth.opposite() == b.azimuth;
    (half.len() == other.len() && half.iter().zip(other).all(opposite)).then_some(half)
}

/// Sets the force to `-sum(push(e^T u) e)` over the directions `e` of all positions, the cage turned by `(sin, cos)`.
#[inline(always)]
fn sum_of_elements<T: Scalar>(
    positions: &[ElementPosition<T>],
    (sin, cos): (T, T),
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    push: impl Fn(T) -> T + Copy,
) {
    let direction = |p: &ElementPosition<T>| [cos * p.cos - sin * p.sin, cos * p.sin + sin * p.cos];
    let (groups, rest) = positions.as_chunks::<BLOCK_SIZE>();
    let count = u.len().min(v.len()).min(fx.len()).min(fy.len());
    let fx = fx.get_mut(..count).unwrap_or_default().chunks_mut(SAMPLES);
    let fy = fy.get_mut(..count).unwrap_or_default().chunks_mut(SAMPLES);
    for (((u, v), fx), fy) in u.chunks(SAMPLES).zip(v.chunks(SAMPLES)).zip(fx).zip(fy) {
        fx.fill(T::ZERO);
        fy.fill(T::ZERO);
        for group in groups {
            add_forces(group.each_ref().map(direction), (u, v), (&mut *fx, &mut *fy), push);
        }
        for position in rest {
            add_forces([direction(position)], (u, v), (&mut *fx, &mut *fy), push);
        }
    }
}

/// One pass: the forces of `K` elements on every sample of a block.
fn add_forces<T: Scalar, const K: usize>(
    directions: [[T; 2]; K],
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    push: impl Fn(T) -> T,
) {
    for (((&u, &v), fx), fy) in u.iter().zip(v).zip(fx).zip(fy) {
        let (mut x, mut y) = (*fx, *fy);
        for [cos, sin] in directions {
            let load = push(u * cos + v * sin);
            x -= load * cos;
            y -= load * sin;
        }
        (*fx, *fy) = (x, y);
    }
}
