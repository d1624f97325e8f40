//! Vectors of any fixed order.

use crate::choice::Choice;
use crate::scalar::Scalar;

/// Returns `x + h k`.
#[inline(always)]
pub fn along<T: Scalar, const D: usize>(x: &[T; D], h: T, k: &[T; D]) -> [T; D] {
    let mut sum = *x;
    add_scaled(&mut sum, h, k);
    sum
}

/// Computes `x += h k`.
#[inline(always)]
pub fn add_scaled<T: Scalar, const D: usize>(x: &mut [T; D], h: T, k: &[T; D]) {
    for (entry, &slope) in x.iter_mut().zip(k) {
        *entry += h * slope;
    }
}

/// Computes `x += y`.
#[inline(always)]
pub fn add<T: Scalar, const D: usize>(x: &mut [T; D], y: &[T; D]) {
    for (entry, &other) in x.iter_mut().zip(y) {
        *entry += other;
    }
}

/// Returns true if no entry is NaN or infinite; tests every entry.
#[inline(always)]
pub fn all_finite<T: Scalar, const D: usize>(x: &[T; D]) -> bool {
    // 0 times a non-finite number is NaN, which any sum preserves.
    x.iter().fold(T::ZERO, |sum, &entry| sum + T::ZERO * entry).is_zero()
}

/// Replaces `x` by `next` if selected, with the same instructions in both cases.
#[inline(always)]
pub fn replace_if<T: Scalar, const D: usize>(choice: Choice, next: &[T; D], x: &mut [T; D]) {
    for (entry, &other) in x.iter_mut().zip(next) {
        *entry = choice.select(other, *entry);
    }
}
