//! Precision as a type parameter: `f32` or `f64`.

use core::fmt::Debug;
use core::ops::Neg;
use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point number of the hot path. Sealed: `f32` and `f64`.
///
/// Selection and sign operations work on the bits, so that their cost does not depend on the data.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Default
    + PartialOrd
    + Debug
    + Send
    + Sync
    + Neg<Output = Self>
    + nalgebra::Scalar
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + ClosedDivAssign
{
    /// 0
    const ZERO: Self;
    /// -0: adding it to any number returns that number, including -0.
    const NEGATIVE_ZERO: Self;
    /// 1
    const ONE: Self;
    /// 1/2
    const HALF: Self;
    /// Largest ratio of unbalanced force to load of an element in equilibrium.
    const EQUILIBRIUM_TOLERANCE: Self;

    /// Rounds to the nearest number of this precision. For set-up: `f64` is emulated on some targets.
    fn from_f64(x: f64) -> Self;
    /// Converts an integer, rounded.
    fn from_u32(count: u32) -> Self;
    /// Converts to `f64`, exactly.
    fn to_f64(self) -> f64;
    /// Rounds to `f32`.
    fn to_f32(self) -> f32;
    /// Converts from `f32`, exactly.
    fn from_f32(x: f32) -> Self;
    /// Returns the magnitude; clears the sign bit.
    fn abs(self) -> Self;
    /// Returns the number with its sign inverted where `sign` has its sign bit set.
    fn xor_sign(self, sign: Self) -> Self;
    /// Returns a number whose sign bit is set where that of `self` or `other` is. Its magnitude is undefined.
    fn or_sign(self, other: Self) -> Self;
    /// Returns the sign bit.
    fn is_sign_negative(self) -> bool;
    /// Returns true if the number is neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Returns true for +0 and -0. Tests the bits: the compiler turns a comparison of floats into a branch.
    fn is_zero(self) -> bool;
    /// Returns `a` where `mask` is all ones, `b` where it is 0.
    fn select_by_mask(mask: u32, a: Self, b: Self) -> Self;
    /// Returns `a` if `first`, else `b`, with the same instructions in both cases.
    #[inline(always)]
    fn select(first: bool, a: Self, b: Self) -> Self {
        Self::select_by_mask(u32::from(first).wrapping_neg(), a, b)
    }
    /// Returns the smaller number, `other` if one of them is NaN. No branch.
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // x86-64 has an instruction for this; the compiler recognises it in this form only.
        if cfg!(target_arch = "x86_64") {
            if self < other { self } else { other }
        } else {
            Self::select(self < other, self, other)
        }
    }
    /// Returns the larger number, `other` if one of them is NaN. No branch.
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            if self > other { self } else { other }
        } else {
            Self::select(self > other, self, other)
        }
    }
    /// Converts counts of 2^-64 revolution to radians; `f32` uses the upper 32 bits only.
    fn radians_from_counts(counts: i64) -> Self;
    /// Converts radians to counts of 2^-64 revolution, saturated at half a revolution; NaN gives 0.
    fn to_phase_counts(self) -> i64;

    /// Returns the integer part, clamped to `0..=most`; NaN gives 0. An exact integer may give the one below.
    fn clamped_floor(self, most: LatticeIndex<Self>) -> LatticeIndex<Self>;
    /// Returns the index `row * length + column`.
    fn row_major_index(row: LatticeIndex<Self>, length: LatticeIndex<Self>, column: LatticeIndex<Self>) -> usize;
    /// Returns `x^(2/3)` within 0.2 % for `x >= 0`: an initial value for a Hertz deflection.
    fn approximate_two_thirds_power(self) -> Self;

    /// Returns `x + |x|`, twice the positive part, without a branch or a library call.
    #[inline(always)]
    fn twice_positive_part(self) -> Self {
        self + self.abs()
    }
    /// Returns `x - |x|`, twice the negative part.
    #[inline(always)]
    fn twice_negative_part(self) -> Self {
        self - self.abs()
    }
}

/// An index of a table in both representations, integer and float. The compiler removes the one that is not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatticeIndex<T> {
    /// As an integer.
    pub count: u32,
    /// As a float.
    pub number: T,
}

impl<T: Scalar> LatticeIndex<T> {
    /// Creates an index.
    #[inline(always)]
    pub fn new(count: u32) -> Self {
        Self { count, number: T::from_u32(count) }
    }
}

/// 2^52: numbers of this size have a resolution of 1, so adding it rounds to an integer, in every lane of a SIMD register.
const LAST_BIT_IS_ONE: f64 = (1_u64 << 52) as f64;

/// Computes two thirds of the exponent from the bits, then one Newton step on `y^3 = x^2`.
#[inline]
fn approximate_two_thirds_power(x: f32) -> f32 {
    /// A third of the bits of 1, reduced so that the errors of both signs are equal.
    const OFFSET: u32 = 0x3f80_0000 / 3 - 0x0004_0000;
    let y = f32::from_bits(x.to_bits() / 3 * 2 + OFFSET);
    let ratio = x / y;
    (2.0 * y + ratio * ratio) * (1.0 / 3.0)
}

const COUNTS_32: f64 = 4_294_967_296.0;
const COUNTS_64: f64 = COUNTS_32 * COUNTS_32;

impl Scalar for f32 {
    const ZERO: Self = 0.0;
    const NEGATIVE_ZERO: Self = -0.0;
    const ONE: Self = 1.0;
    const HALF: Self = 0.5;
    const EQUILIBRIUM_TOLERANCE: Self = 1e-4;

    #[inline]
    fn from_u32(count: u32) -> Self {
        count as Self
    }
    #[inline]
    fn from_f64(x: f64) -> Self {
        x as Self
    }
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn to_f32(self) -> f32 {
        self
    }
    #[inline]
    fn from_f32(x: f32) -> Self {
        x
    }
    #[inline]
    fn abs(self) -> Self {
        Self::from_bits(self.to_bits() & 0x7fff_ffff)
    }
    #[inline]
    fn xor_sign(self, sign: Self) -> Self {
        Self::from_bits(self.to_bits() ^ (sign.to_bits() & 0x8000_0000))
    }
    #[inline]
    fn or_sign(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() | other.to_bits())
    }
    #[inline]
    fn is_sign_negative(self) -> bool {
        self.to_bits() >> 31 != 0
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.to_bits() & 0x7f80_0000 != 0x7f80_0000
    }
    #[inline]
    fn is_zero(self) -> bool {
        self.to_bits() << 1 == 0
    }
    #[inline]
    fn select_by_mask(mask: u32, a: Self, b: Self) -> Self {
        Self::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
    }
    #[inline]
    fn radians_from_counts(counts: i64) -> Self {
        const SCALE: f32 = (core::f64::consts::TAU / COUNTS_32) as f32;
        ((counts >> 32) as i32) as Self * SCALE
    }
    #[inline]
    fn clamped_floor(self, most: LatticeIndex<Self>) -> LatticeIndex<Self> {
        let count = (self as u32).min(most.count);
        LatticeIndex { count, number: count as Self }
    }
    #[inline]
    fn row_major_index(row: LatticeIndex<Self>, length: LatticeIndex<Self>, column: LatticeIndex<Self>) -> usize {
        row.count.wrapping_mul(length.count).wrapping_add(column.count) as usize
    }
    #[inline]
    fn approximate_two_thirds_power(self) -> Self {
        approximate_two_thirds_power(self)
    }
    #[inline]
    fn to_phase_counts(self) -> i64 {
        const SCALE: f32 = (COUNTS_32 / core::f64::consts::TAU) as f32;
        i64::from((self * SCALE) as i32) << 32
    }
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const NEGATIVE_ZERO: Self = -0.0;
    const ONE: Self = 1.0;
    const HALF: Self = 0.5;
    const EQUILIBRIUM_TOLERANCE: Self = 1e-9;

    #[inline]
    fn from_u32(count: u32) -> Self {
        Self::from(count)
    }
    #[inline]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline]
    fn to_f32(self) -> f32 {
        self as f32
    }
    #[inline]
    fn from_f32(x: f32) -> Self {
        Self::from(x)
    }
    #[inline]
    fn abs(self) -> Self {
        Self::from_bits(self.to_bits() & 0x7fff_ffff_ffff_ffff)
    }
    #[inline]
    fn xor_sign(self, sign: Self) -> Self {
        Self::from_bits(self.to_bits() ^ (sign.to_bits() & 0x8000_0000_0000_0000))
    }
    #[inline]
    fn or_sign(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() | other.to_bits())
    }
    #[inline]
    fn is_sign_negative(self) -> bool {
        self.to_bits() >> 63 != 0
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.to_bits() & 0x7ff0_0000_0000_0000 != 0x7ff0_0000_0000_0000
    }
    #[inline]
    fn is_zero(self) -> bool {
        self.to_bits() << 1 == 0
    }
    #[inline]
    fn select_by_mask(mask: u32, a: Self, b: Self) -> Self {
        let mask = i64::from(mask.cast_signed()) as u64;
        Self::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
    }
    #[inline]
    fn radians_from_counts(counts: i64) -> Self {
        counts as Self * (core::f64::consts::TAU / COUNTS_64)
    }
    #[inline]
    fn clamped_floor(self, most: LatticeIndex<Self>) -> LatticeIndex<Self> {
        let rounded = (self - 0.5).larger(0.0).smaller(most.number) + LAST_BIT_IS_ONE;
        LatticeIndex { count: rounded.to_bits() as u32, number: rounded - LAST_BIT_IS_ONE }
    }
    #[inline]
    fn row_major_index(row: LatticeIndex<Self>, length: LatticeIndex<Self>, column: LatticeIndex<Self>) -> usize {
        // Float arithmetic fits every lane of a SIMD register.
        let sum = row.number * length.number + column.number + LAST_BIT_IS_ONE;
        sum.to_bits() as u32 as usize
    }
    #[inline]
    fn approximate_two_thirds_power(self) -> Self {
        Self::from(approximate_two_thirds_power(self as f32))
    }
    #[inline]
    fn to_phase_counts(self) -> i64 {
        (self * (COUNTS_64 / core::f64::consts::TAU)) as i64
    }
}
