//! Vectors of any fixed order, entry by entry.

use crate::choice::Choice;
use crate::scalar::Scalar;

/// `x + h k`.
#[inline(always)]
pub fn along<T: Scalar, const D: usize>(x: &[T; D], h: T, k: &[T; D]) -> [T; D] {
    let mut sum = *x;
    add_scaled(&mut sum, h, k);
    sum
}

/// `x += h k`.
#[inline(always)]
pub fn add_scaled<T: Scalar, const D: usize>(x: &mut [T; D], h: T, k: &[T; D]) {
    for (entry, &slope) in x.iter_mut().zip(k) {
        *entry += h * slope;
    }
}

/// `x += y`.
#[inline(always)]
pub fn add<T: Scalar, const D: usize>(x: &mut [T; D], y: &[T; D]) {
    for (entry, &other) in x.iter_mut().zip(y) {
        *entry += other;
    }
}

/// No entry is NaN or infinite; every entry is looked at, whatever the ones before it.
#[inline(always)]
pub fn all_finite<T: Scalar, const D: usize>(x: &[T; D]) -> bool {
    // 0 times what is not finite is NaN, which no sum loses and which equals nothing.
    x.iter().fold(T::ZERO, |sum, &entry| sum + T::ZERO * entry).is_zero()
}

/// `x` becomes `next` if that is the choice, the same instructions either way.
#[inline(always)]
pub fn replace_if<T: Scalar, const D: usize>(choice: Choice, next: &[T; D], x: &mut [T; D]) {
    for (entry, &other) in x.iter_mut().zip(next) {
        *entry = choice.select(other, *entry);
    }
}
