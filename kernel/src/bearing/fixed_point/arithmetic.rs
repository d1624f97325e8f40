//! Integers in the place of floats: directions, the turn of the cage, sine, normalisation, without a branch on a value.

use crate::phase::Phase;
use crate::status::Status;

/// A number in units of 2^-30.
pub const ONE: f64 = 1_073_741_824.0;

/// `sin(pi w / 2)` for `w` from -1 to 1: coefficients of `w`, `w^3` to `w^9`, least largest error (3.3e-9), in units of 2^-30.
const SINE: [i64; 5] = [1_686_629_674, -693_597_876, 85_564_854, -5_016_767, 161_942];

/// Cosine and sine of the azimuth of an element with the cage at angle 0, in units of 2^-30.
pub type Direction = [i32; 2];

/// Returns the direction of element `j` of `count` evenly spaced ones, the first at `first`. For set-up.
#[must_use]
pub fn direction(first: Phase, j: usize, count: usize) -> Direction {
    let (cos, sin) = crate::bearing::ElementPosition::<f64>::evenly_spaced(first, j, count).direction();
    [cos, sin].map(|x| libm::round(x * ONE) as i32)
}

/// Cosine and sine of the angle of the cage, in units of 2^-30.
pub struct Turn {
    cos: i32,
    sin: i32,
}

impl Turn {
    #[inline(always)]
    pub fn of(cage: Phase) -> Self {
        Self { cos: sine(cage.wrapping_add(Phase(1 << 62))), sin: sine(cage) }
    }

    /// Returns a vector in the frame of the cage, in units of 2^-30 of its own.
    #[inline(always)]
    pub fn to_cage(&self, [x, y]: [i32; 2]) -> [i64; 2] {
        let Self { cos, sin } = *self;
        [product(x, cos) + product(y, sin), product(y, cos) - product(x, sin)]
    }

    /// Returns a vector in the frame of the cage in that of the housing, in units of 2^-30 of its own.
    #[inline(always)]
    pub fn to_housing(&self, [x, y]: [i32; 2]) -> [i64; 2] {
        let Self { cos, sin } = *self;
        [product(x, cos) - product(y, sin), product(x, sin) + product(y, cos)]
    }
}

/// Returns the flag of lost contact. The load is below 2^31: the difference borrows where it is 0, without a branch.
#[inline(always)]
pub fn status_at(load: u32) -> Status {
    Status::from_bits(Status::CONTACT_LOST.bits() * (load.wrapping_sub(1) >> 31) as u8)
}

/// Returns a product, in whose units two factors of 2^-30 make 2^-60.
#[inline(always)]
pub fn product(a: i32, b: i32) -> i64 {
    if cfg!(short_products) { product_of_halves(a, b) } else { i64::from(a) * i64::from(b) }
}

/// As [`product`], without sign.
#[inline(always)]
pub fn product_unsigned(a: u32, b: u32) -> u64 {
    if cfg!(short_products) { unsigned_of_halves(a, b) } else { u64::from(a) * u64::from(b) }
}

/// Returns a product by four of 32 bits: on a core without that of 64 bits, half of the instructions of a call.
#[inline(always)]
fn product_of_halves(a: i32, b: i32) -> i64 {
    let (a_high, a_low, b_high, b_low) = (a >> 16, a & 0xffff, b >> 16, b & 0xffff);
    let ends = (i64::from(a_high * b_high) << 32) | i64::from(a_low as u32 * b_low as u32);
    ends + (i64::from(a_high * b_low) << 16) + (i64::from(a_low * b_high) << 16)
}

/// As [`product_of_halves`], without sign.
#[inline(always)]
fn unsigned_of_halves(a: u32, b: u32) -> u64 {
    let (a_high, a_low, b_high, b_low) = (a >> 16, a & 0xffff, b >> 16, b & 0xffff);
    let ends = (u64::from(a_high * b_high) << 32) | u64::from(a_low * b_low);
    ends + (u64::from(a_high * b_low) << 16) + (u64::from(a_low * b_high) << 16)
}

/// Returns `x` if it is positive, else 0, without a branch.
#[inline(always)]
pub fn positive_part(x: i32) -> u32 {
    (x & !(x >> 31)) as u32
}

/// Returns a number below 2^31, shifted to the left until it is 2^30 or more, and the shift; 0 and 31 for 0. Counted without a branch: a core
/// without the instruction for it has a loop or a table.
#[inline(always)]
pub fn normalised(mut x: u32) -> (u32, u32) {
    let mut shift = 0;
    for step in [16, 8, 4, 2, 1] {
        // 1 where the number is below 2^(31 - step): the difference borrows.
        let by = (x.wrapping_sub(1 << (31 - step)) >> 31) * step;
        x <<= by;
        shift += by;
    }
    (x, shift)
}

/// Returns the sine of an angle in units of 2^-30, to 1e-8.
#[inline(always)]
fn sine(angle: Phase) -> i32 {
    let angle = (angle.0 >> 32) as i32;
    // In the second and third quarter of a turn the angle from the other zero: half a turn less the angle.
    let is_beyond = (angle ^ (angle << 1)) >> 31;
    let w = i64::from((angle ^ is_beyond).wrapping_add(is_beyond & (i32::MIN + 1)));
    let square = (w * w) >> 30;
    let [a, b, c, d, e] = SINE;
    let series = a + ((square * (b + ((square * (c + ((square * (d + ((square * e) >> 30))) >> 30))) >> 30))) >> 30);
    ((series * w) >> 30) as i32
}

#[cfg(test)]
pub use tests::numbers;

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers from 0 to 1.
    pub fn numbers() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 9_007_199_254_740_992.0
        }
    }

    #[test]
    fn a_sine_is_that_of_libm() {
        let mut number = numbers();
        let edges = [0.0, 0.25, 0.5, 0.75, 0.999_999_999];
        for turns in edges.into_iter().chain((0..10_000).map(|_| number())) {
            let found = f64::from(sine(Phase::from_revolutions(turns))) / ONE;
            assert!((found - libm::sin(core::f64::consts::TAU * turns)).abs() < 1e-8, "{turns}: {found}");
        }
    }

    #[test]
    fn numbers_are_normalised() {
        for x in (0..31).flat_map(|bit| [1_u32 << bit, (1 << bit) | 1, (2 << bit) - 1]) {
            assert_eq!(normalised(x), (x << (x.leading_zeros() - 1), x.leading_zeros() - 1), "{x}");
        }
        assert_eq!(normalised(0), (0, 31));
    }

    #[test]
    fn a_product_of_halves_is_that_of_64_bits() {
        let edges = [i32::MIN, i32::MIN + 1, -65_537, -65_536, -1, 0, 1, 65_535, 65_536, i32::MAX - 1, i32::MAX];
        let random = (0..2000_u32).map(|i| i.wrapping_mul(2_654_435_761).cast_signed());
        for a in edges.into_iter().chain(random) {
            for b in edges {
                assert_eq!(product_of_halves(a, b), i64::from(a) * i64::from(b), "{a} {b}");
                let [a, b] = [a, b].map(i32::cast_unsigned);
                assert_eq!(unsigned_of_halves(a, b), u64::from(a) * u64::from(b), "{a} {b}");
            }
        }
    }
}
