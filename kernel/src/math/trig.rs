//! Sine and cosine of a wrapping angle: exact range reduction by shifts, then a polynomial.
//!
//! `f32`: minimax polynomial of degree 9 on a quarter revolution (relative error 5e-9 before rounding, absolute 2e-7 after;
//! exact at the four quarters). `f64`: Taylor series to degrees 17 and 18 (remainder below 1e-19).

use super::{polynomial, polynomial_by_pairs};
use crate::math::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Returns the nearest quarter revolution (0 to 3) and the remainder, -1/8 to 1/8 revolution, in counts.
#[inline]
fn reduce(angle: Phase) -> (u64, i64) {
    let quarter = angle.0.wrapping_add(1 << 61) >> 62;
    (quarter, angle.0.wrapping_sub(quarter << 62) as i64)
}

/// Rotates (sin, cos) of the remainder by the quarters.
#[inline]
fn unreduce<T: Scalar>(quarter: u64, sin: T, cos: T) -> (T, T) {
    let (s, c) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let s = if quarter & 2 == 0 { s } else { -s };
    let c = if (quarter + 1) & 2 == 0 { c } else { -c };
    (s, c)
}

/// Computes both as a sine of at most a quarter revolution: `cos(a) = sin(1/4 - |a|)`, `sin(a) = cos(a - 1/4)`, in
/// revolutions.
// Always inlined: otherwise the decision of the compiler, and the count of instructions, changes with the calling program.
#[inline(always)]
pub fn sin_cos_f32(angle: Phase) -> (f32, f32) {
    const QUARTER: i32 = 1 << 30;
    const TURNS: f32 = 1.0 / 4_294_967_296.0;
    const COEFFICIENTS: [f32; 5] = [core::f32::consts::TAU, -41.341_68, 81.602_234, -76.574_99, 39.710_92];
    let cos = |angle: i32| {
        let y = QUARTER.wrapping_sub(angle.wrapping_abs()) as f32 * TURNS;
        y * polynomial(y * y, COEFFICIENTS)
    };
    let angle = (angle.0 >> 32) as i32;
    (cos(angle.wrapping_sub(QUARTER)), cos(angle))
}

#[inline]
pub fn sin_cos_f64(angle: Phase) -> (f64, f64) {
    let (quarter, rest) = reduce(angle);
    let x = f64::radians_from_counts(rest);
    let xx = x * x;
    // Both series without their first terms, side by side. The cosine has the opposite sign, so that the operations are the
    // same.
    let Lanes(rest) = polynomial_by_pairs(
        Lanes::splat(xx),
        [
            Lanes([-1.0 / 6.0, -1.0 / 24.0]),
            Lanes([1.0 / 120.0, 1.0 / 720.0]),
            Lanes([-1.0 / 5_040.0, -1.0 / 40_320.0]),
            Lanes([1.0 / 362_880.0, 1.0 / 3_628_800.0]),
            Lanes([-1.0 / 39_916_800.0, -1.0 / 479_001_600.0]),
            Lanes([1.0 / 6_227_020_800.0, 1.0 / 87_178_291_200.0]),
            Lanes([-1.0 / 1_307_674_368_000.0, -1.0 / 20_922_789_888_000.0]),
            Lanes([1.0 / 355_687_428_096_000.0, 1.0 / 6_402_373_705_728_000.0]),
        ],
    );
    // `black_box` makes the compiler load both values at once where registers hold two numbers.
    let [sines, cosines] = if cfg!(target_pointer_width = "64") { core::hint::black_box(rest) } else { rest };
    let sin = x + x * xx * sines;
    let cos = 1.0 - 0.5 * xx - xx * xx * cosines;
    unreduce(quarter, sin, cos)
}
