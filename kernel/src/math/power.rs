//! `x^n` in `f32` by logarithm and exponential of base 2, with a fixed number of instructions.
//!
//! Minimax polynomials with relative errors of 7e-10 and 2e-9; rounding dominates with 2.3e-7 for `n` from 1 to 2.2. The
//! product of exponent and `n` is computed in two parts, the larger of them exact: one rounding would cost an order of
//! magnitude.

use super::polynomial;

/// `log2((1 + s)/(1 - s)) / s` in `s^2`, constant term first.
const LOGARITHM: [f32; 4] = [2.885_39, 0.961_798_84, 0.576_714_4, 0.431_735_88];

/// `2^r` on -1/2..1/2, constant term first.
const EXPONENTIAL: [f32; 7] =
    [1.0, core::f32::consts::LN_2, 0.240_226_46, 0.055_503_29, 0.009_618_489, 0.001_339_993_1, 0.000_153_458_17];

/// Bits of the square root of 1/2: mantissas are taken from there to twice that.
const MIN_MANTISSA: i32 = 0x3f35_04f3;

/// Rounds to the nearest integer, as a float: a float beyond 1.5 * 2^23 has no fraction.
#[inline(always)]
fn rounded(x: f32) -> f32 {
    const SHIFT: f32 = 12_582_912.0;
    (x + SHIFT) - SHIFT
}

/// Returns the exponent of `x > 0` and the logarithm of its mantissa, base 2.
#[inline(always)]
fn log2_parts(x: f32) -> (f32, f32) {
    let bits = x.to_bits() as i32;
    let exponent = bits.wrapping_sub(MIN_MANTISSA) >> 23;
    let m = f32::from_bits(bits.wrapping_sub(exponent << 23) as u32);
    let s = (m - 1.0) / (m + 1.0);
    (exponent as f32, s * polynomial(s * s, LOGARITHM))
}

/// Returns the natural logarithm of a normal `x > 0`, accurate to 1e-7 or a rounding error.
#[inline]
pub fn ln_f32(x: f32) -> f32 {
    let (exponent, logarithm) = log2_parts(x);
    (exponent + logarithm) * core::f32::consts::LN_2
}

/// Returns `x^n` for `x >= 0`, `n >= 1`: 0 for 0 and underflow, infinity for overflow and non-finite input.
#[inline]
pub fn pow_f32(x: f32, n: f32) -> f32 {
    let (exponent, logarithm) = log2_parts(x);
    let n_high = f32::from_bits(n.to_bits() & 0xffff_ff00);
    let high = n_high * exponent;
    let whole = rounded(high);
    let low = (high - whole) + ((n - n_high) * exponent + n * logarithm);
    let more = rounded(low);
    scaled(polynomial(low - more, EXPONENTIAL), whole + more)
}

/// Returns `x * 2^k` for `x` about 1 and an integer `k`: 0 for `k <= -127`, infinity for `k >= 128`.
#[inline(always)]
fn scaled(x: f32, k: f32) -> f32 {
    let biased = (k as i32 + 127).clamp(0, 255);
    x * f32::from_bits((biased as u32) << 23)
}
