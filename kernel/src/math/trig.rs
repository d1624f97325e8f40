//! Sine and cosine of a turn counter: exact range reduction by shifting, then a polynomial on -pi/4..pi/4.
//!
//! `f32`: minimax polynomials of degree 7 and 8 (relative to 1: 2e-9 and 5e-11 before rounding, so rounding
//! decides). `f64`: the Taylor series to degree 17 and 16 (remainder below 1e-19).

use crate::scalar::Scalar;
use crate::turn::Turn;

/// The quarter turn nearest to the angle (0 to 3) and what is left, -1/8 to 1/8 turn, in counts.
#[inline]
fn reduce(angle: Turn) -> (u64, i64) {
    let quarter = angle.0.wrapping_add(1 << 61) >> 62;
    (quarter, angle.0.wrapping_sub(quarter << 62) as i64)
}

/// Turns (sin, cos) of the remainder by the whole quarters.
#[inline]
fn unreduce<T: Scalar>(quarter: u64, sin: T, cos: T) -> (T, T) {
    let (s, c) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let s = if quarter & 2 == 0 { s } else { -s };
    let c = if (quarter + 1) & 2 == 0 { c } else { -c };
    (s, c)
}

/// Horner's scheme, the constant term first in `coefficients`.
#[inline(always)]
fn polynomial<T: Scalar, const N: usize>(x: T, coefficients: [T; N]) -> T {
    coefficients.into_iter().rev().fold(T::ZERO, |sum, c| sum * x + c)
}

#[inline]
pub fn sin_cos_f32(angle: Turn) -> (f32, f32) {
    let (quarter, rest) = reduce(angle);
    let x = f32::radians_of_counts(rest);
    let xx = x * x;
    // Written about 1 so that the leading term is exact.
    let sin = x + x * xx * polynomial(xx, [-0.166_666_37, 0.008_331_584, -0.000_194_621_03]);
    let cos = 1.0 - 0.5 * xx + xx * xx * polynomial(xx, [0.041_666_617, -0.001_388_661_9, 2.437_991_6e-5]);
    unreduce(quarter, sin, cos)
}

#[inline]
pub fn sin_cos_f64(angle: Turn) -> (f64, f64) {
    let (quarter, rest) = reduce(angle);
    let x = f64::radians_of_counts(rest);
    let xx = x * x;
    let sin = x + x
        * xx
        * polynomial(
            xx,
            [
                -1.0 / 6.0,
                1.0 / 120.0,
                -1.0 / 5_040.0,
                1.0 / 362_880.0,
                -1.0 / 39_916_800.0,
                1.0 / 6_227_020_800.0,
                -1.0 / 1_307_674_368_000.0,
                1.0 / 355_687_428_096_000.0,
            ],
        );
    let cos = 1.0 - 0.5 * xx
        + xx * xx
            * polynomial(
                xx,
                [
                    1.0 / 24.0,
                    -1.0 / 720.0,
                    1.0 / 40_320.0,
                    -1.0 / 3_628_800.0,
                    1.0 / 479_001_600.0,
                    -1.0 / 87_178_291_200.0,
                    1.0 / 20_922_789_888_000.0,
                ],
            );
    unreduce(quarter, sin, cos)
}
