//! `x^(1/9)` without a logarithm: the exponent by division, the mantissa by a polynomial.
//!
//! With `x = 2^(9 q + r) m`, `1 <= m < 2`: `x^(1/9) = 2^q * 2^(r/9) * m^(1/9)`. The polynomial of degree 6 is
//! minimax in relative error (1.1e-7). Subnormal numbers count as 0.

use crate::scalar::Scalar;

/// `2^(r/9)`, padded to 16 entries so that a masked index is always valid.
const POWERS_F32: [f32; 16] = {
    let mut table = [1.0; 16];
    let mut r = 0;
    while r < 16 {
        table[r] = POWERS_F64[r] as f32;
        r += 1;
    }
    table
};

const POWERS_F64: [f64; 16] = [
    1.0,
    1.080_059_738_892_306,
    1.166_529_039_576_116_5,
    1.259_921_049_894_873_2,
    1.360_790_000_174_377,
    1.469_734_492_275_598_8,
    1.587_401_051_968_199_4,
    1.714_487_965_702_247_4,
    1.851_749_424_574_580_7,
    1.0,
    1.0,
    1.0,
    1.0,
    1.0,
    1.0,
    1.0,
];

/// Coefficients of `m^(1/9)` in `m - 1`, constant term first.
const MANTISSA: [f64; 7] = [
    1.000_000_107_445_942_5,
    0.111_099_370_403_715_7,
    -0.049_172_327_914_621_17,
    0.029_645_492_744_316_534,
    -0.017_455_487_973_531_386,
    0.007_531_190_196_839_527,
    -0.001_588_722_056_998_302_7,
];

#[inline]
pub fn ninth_root_f32(x: f32) -> f32 {
    let bits = x.to_bits();
    // The bias 127 and 8 more make 135 = 15 * 9, so the dividend is positive.
    let exponent = (bits >> 23) + 8;
    let (q, r) = (exponent / 9, exponent % 9);
    let m = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0;
    let mantissa = MANTISSA.into_iter().rev().fold(0.0, |sum, c| sum * m + c as f32);
    let scale = f32::from_bits((q + (127 - 15)) << 23);
    mantissa * scale * POWERS_F32[(r & 15) as usize]
}

/// Smaller numbers count as this one. The ninth powers in the Newton steps at 0, and their differences from `x`, would be subnormal numbers,
/// with which some processors take ten times as long.
const SMALLEST: f64 = 1e-280;

#[inline]
pub fn ninth_root_f64(x: f64) -> f64 {
    // Without an FPU for this precision, a comparison of integers is cheaper; the bits of positive numbers have their order.
    let x = if cfg!(target_pointer_width = "32") {
        f64::from_bits(x.to_bits().max(SMALLEST.to_bits()))
    } else {
        x.larger(SMALLEST)
    };
    let bits = x.to_bits();
    // 1023 + 3 = 114 * 9.
    let exponent = (bits >> 52) + 3;
    let (q, r) = (exponent / 9, exponent % 9);
    let m = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000) - 1.0;
    let mantissa = MANTISSA.into_iter().rev().fold(0.0, |sum, c| sum * m + c);
    let scale = f64::from_bits((q + (1023 - 114)) << 52);
    let y = mantissa * scale * POWERS_F64[(r & 15) as usize];
    // The polynomial has an error of 1.1e-7; a Newton step squares it (times 4), the second reaches the rounding.
    let step = |y: f64| {
        let y2 = y * y;
        let y4 = y2 * y2;
        let y8 = y4 * y4;
        y - (y8 * y - x) / (9.0 * y8)
    };
    step(step(y))
}
