//! Constant-time selection between two values.

use crate::phase::Phase;
use crate::scalar::Scalar;

/// A selection that applies to many numbers.
#[derive(Clone, Copy)]
pub struct Choice {
    /// All ones for the first value, 0 for the second.
    mask: u32,
}

impl Choice {
    #[inline(always)]
    pub fn new(first: bool) -> Self {
        // `black_box` hides the mask: the optimiser turns a known mask into a conditional store, a branch.
        Self { mask: core::hint::black_box(u32::from(first).wrapping_neg()) }
    }

    #[inline(always)]
    pub fn select<T: Scalar>(self, a: T, b: T) -> T {
        T::select_by_mask(self.mask, a, b)
    }

    #[inline(always)]
    pub fn select_phase(self, a: Phase, b: Phase) -> Phase {
        let mask = i64::from(self.mask.cast_signed()) as u64;
        Phase((a.0 & mask) | (b.0 & !mask))
    }
}
