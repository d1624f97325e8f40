//! Square roots of integers, with a constant number of instructions on every core.

use super::arithmetic::{normalised, product_unsigned};

/// `1 / sqrt(i / 128)` in units of 2^-15, for `i` from 32 on: ends of the lines where Newton's step begins.
const STARTS: [u16; 129] = {
    let (mut starts, mut i) = ([u16::MAX; 129], 33_usize);
    while i < 129 {
        starts[i] = ((1_u64 << 37) / i as u64).isqrt() as u16;
        i += 1;
    }
    starts
};

/// Root of a number below 2^31 as mantissa and shift; the root of 0 is that of 1. Relative error below 2e-8.
#[derive(Clone, Copy)]
pub struct Root {
    /// `sqrt(m / 2^31)` in units of 2^-30, m the number shifted to the left by twice `shift`.
    pub mantissa: u32,
    /// The inverse of the mantissa in units of 2^-30, 1 to 2.
    pub inverse: u32,
    /// Shift of the mantissa to the right.
    pub shift: u32,
}

impl Root {
    #[inline(always)]
    pub fn of(number: u32) -> Self {
        let (from_half, shift) = normalised(number | 1);
        // 1/4 to 1, in units of 2^-31.
        let m = from_half >> (shift & 1);
        let line = (m >> 24) as usize & 127;
        let [from, to] = [STARTS[line], STARTS[line + 1]].map(u32::from);
        let start = from - (((from - to) * ((m >> 8) & 0xffff)) >> 16);
        // One step of Newton: x (3 - m x^2) / 2.
        let near_one = product_unsigned(m, start * start) >> 32;
        let inverse = (product_unsigned(start, (3 << 29) - near_one as u32) >> 15) as u32;
        Self { mantissa: (product_unsigned(m, inverse) >> 31) as u32, inverse, shift: shift >> 1 }
    }

    /// Returns the root in units of 2^-30 of `sqrt(2^31)`.
    #[inline(always)]
    pub fn value(&self) -> u32 {
        self.mantissa >> self.shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_that_of_libm() {
        for i in 0..200_000_u32 {
            let number = i.wrapping_mul(2_654_435_761) >> (1 + i % 31);
            let Root { mantissa, inverse, shift } = Root::of(number);
            let expected = libm::sqrt(f64::from(number | 1) / 2_147_483_648.0);
            let found = f64::from(mantissa) / 1_073_741_824.0 / f64::from(1 << shift);
            let inverse = f64::from(inverse) / 1_073_741_824.0 * f64::from(1 << shift);
            assert!((found / expected - 1.0).abs() < 2e-8, "{number}: {found} {expected}");
            assert!((inverse * expected - 1.0).abs() < 2e-8, "{number}: {inverse} {expected}");
        }
    }
}
