//! Precision as a type parameter: `f32` or `f64`, and nothing else.

use core::fmt::Debug;
use core::ops::Neg;
use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point number of the hot path. Sealed: `f32` and `f64`.
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
    /// -0, which added to any number leaves it as it is
    const NEGATIVE_ZERO: Self;
    /// 1
    const ONE: Self;
    /// 1/2
    const HALF: Self;
    /// Unbalanced force over largest load below which a ball counts as in equilibrium.
    const EQUILIBRIUM_TOLERANCE: Self;

    /// The nearest number of this precision. Set-up time on targets whose `f64` is soft.
    fn from_f64(x: f64) -> Self;
    /// A count (rounded).
    fn from_u32(count: u32) -> Self;
    /// As `f64`, exactly.
    fn to_f64(self) -> f64;
    /// Magnitude: clears the sign bit.
    fn abs(self) -> Self;
    /// Negated where `sign` has its sign bit set.
    fn xor_sign(self, sign: Self) -> Self;
    /// A number whose sign bit is set where either's is; the rest of it means nothing.
    fn or_sign(self, other: Self) -> Self;
    /// The sign bit.
    fn is_sign_negative(self) -> bool;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// +0 or -0, seen in the bits: a comparison of floats invites a branch.
    fn is_zero(self) -> bool;
    /// `a` where `mask` is all ones, `b` where it is 0.
    fn select_by_mask(mask: u32, a: Self, b: Self) -> Self;
    /// `a` if `first`, else `b`, by masks: the same instructions either way.
    #[inline(always)]
    fn select(first: bool, a: Self, b: Self) -> Self {
        Self::select_by_mask(u32::from(first).wrapping_neg(), a, b)
    }
    /// The smaller of two, `other` where either is NaN; no branch.
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // A desktop processor has an instruction for it, which the compiler finds in this form only.
        if cfg!(target_arch = "x86_64") {
            if self < other { self } else { other }
        } else {
            Self::select(self < other, self, other)
        }
    }
    /// The larger of two, `other` where either is NaN; no branch.
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            if self > other { self } else { other }
        } else {
            Self::select(self > other, self, other)
        }
    }
    /// Radians of an arc given in counts of 2^-64 turn; `f32` looks at the upper 32 bits only.
    fn radians_from_counts(counts: i64) -> Self;
    /// Counts of 2^-64 turn of an arc in radians, saturating at half a turn; NaN gives 0.
    fn to_phase_counts(self) -> i64;

    /// The whole part of `self`, 0 to `most`; NaN gives 0. A whole number may count to the one below.
    fn clamped_floor(self, most: LatticeIndex<Self>) -> LatticeIndex<Self>;
    /// `row * length + column` as index.
    fn row_major_index(row: LatticeIndex<Self>, length: LatticeIndex<Self>, column: LatticeIndex<Self>) -> usize;
    /// `x^(2/3)` to 0.2 %, `x >= 0`: a first guess of a Hertz deflection.
    fn approximate_two_thirds_power(self) -> Self;

    /// `x + |x|`: twice the positive part, without a branch or a library call.
    #[inline(always)]
    fn twice_positive_part(self) -> Self {
        self + self.abs()
    }
    /// `x - |x|`: twice the negative part.
    #[inline(always)]
    fn twice_negative_part(self) -> Self {
        self - self.abs()
    }
}

/// A whole number, both ways: what is not asked for costs nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatticeIndex<T> {
    /// To count with.
    pub count: u32,
    /// To compute with.
    pub number: T,
}

impl<T: Scalar> LatticeIndex<T> {
    /// Of a count.
    #[inline(always)]
    pub fn new(count: u32) -> Self {
        Self { count, number: T::from_u32(count) }
    }
}

/// Where 1 is the last bit there is, an addition rounds to whole numbers, in every lane of a desktop processor.
const LAST_BIT_IS_ONE: f64 = (1_u64 << 52) as f64;

/// Two thirds of the exponent by the bits, then a Newton step on `y^3 = x^2`.
#[inline]
fn approximate_two_thirds_power(x: f32) -> f32 {
    /// A third of the bits of 1, and less so that the error is the same to both sides.
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
        // In floats, in every lane of a desktop processor.
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
