//! Evaluation of many samples in arrays, for the desktop.

use super::element_position::{ElementLayout, ElementPosition};
use super::lumped::Radial;
use crate::contact::law::LoadDeflectionLaw;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Samples per pass of [`radial_batch`]: their arrays stay in the first-level cache, and the overhead of a pass is
/// distributed over many samples.
const SAMPLES: usize = 256;

/// Elements per pass: their directions and sums fill 16 vector registers.
const BLOCK_SIZE: usize = 4;

/// Computes `fx[i], fy[i]` from `u[i], v[i]` for many samples with the cage at the angle `cage`.
///
/// The compiler vectorises the loops. The shortest of the four slices limits the count. The forces equal those of
/// [`super::Bearing::reaction`] to rounding. Evenly spaced elements in opposed pairs without preload share a square root:
/// at most one of two is loaded.
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
/// Returns the first half of the positions if each of the second half is opposite to its counterpart.
fn one_of_each_pair<T: Scalar>(positions: &[ElementPosition<T>]) -> Option<&[ElementPosition<T>]> {
    let (half, other) = positions.split_at(positions.len() / 2);
    let opposite = |(a, b): (&ElementPosition<T>, &ElementPosition<T>)| a.azimuth.opposite() == b.azimuth;
    (half.len() == other.len() && half.iter().zip(other).all(opposite)).then_some(half)
}

/// Sets the force to `-sum(load(e^T u) e)` over the directions `e` of all positions, rotated by `(sin, cos)`.
#[inline(always)]
fn sum_of_elements<T: Scalar>(
    positions: &[ElementPosition<T>],
    (sin, cos): (T, T),
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    load_at: impl Fn(T) -> T + Copy,
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
            add_forces(group.each_ref().map(direction), (u, v), (&mut *fx, &mut *fy), load_at);
        }
        for position in rest {
            add_forces([direction(position)], (u, v), (&mut *fx, &mut *fy), load_at);
        }
    }
}

/// Adds the forces of `K` elements to every sample of a pass.
fn add_forces<T: Scalar, const K: usize>(
    directions: [[T; 2]; K],
    (u, v): (&[T], &[T]),
    (fx, fy): (&mut [T], &mut [T]),
    load_at: impl Fn(T) -> T,
) {
    for (((&u, &v), fx), fy) in u.iter().zip(v).zip(fx).zip(fy) {
        let (mut x, mut y) = (*fx, *fy);
        for [cos, sin] in directions {
            let load = load_at(u * cos + v * sin);
            x -= load * cos;
            y -= load * sin;
        }
        (*fx, *fy) = (x, y);
    }
}
