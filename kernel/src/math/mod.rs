//! The math backend as a zero-sized type: [`Exact`] and [`Fast`].
//!
//! Sine and cosine come from the turn counter by the same polynomials in both: they are cheaper than a
//! library call and exact to the precision.

mod ninth_root;
mod power;
mod sqrt;
mod trig;

use crate::phase::Phase;
use crate::scalar::Scalar;
use core::ops::{Add, Mul};

/// The functions of the hot path, chosen at compile time.
pub trait Math<T: Scalar>: Copy + Default + Send + Sync + 'static {
    /// Square root of `x >= 0`.
    fn sqrt(x: T) -> T;
    /// Square root of each.
    #[inline(always)]
    fn sqrt_each<const K: usize>(x: [T; K]) -> [T; K] {
        x.map(Self::sqrt)
    }
    /// `x sqrt|x|` of each: the signed power 3/2.
    #[inline(always)]
    fn three_halves<const K: usize>(x: [T; K]) -> [T; K] {
        x.map(|x| x * Self::sqrt(x.abs()))
    }
    /// `x^n` for `x >= 0`, `n >= 1`.
    fn powf(x: T, n: T) -> T;
    /// `x^(1/9)` for `x >= 0`, for the line contact's `x^(10/9)`.
    fn ninth_root(x: T) -> T;
    /// Sine and cosine of a turn counter, in that order.
    fn sin_cos(angle: Phase) -> (T, T);
}

/// Correctly rounded square root (the target's own where it has one).
#[derive(Debug, Clone, Copy, Default)]
pub struct Exact;

/// `micromath`: a square root good to 0.18 %, without dividing or iterating.
///
/// In `f64` it still computes in `f32`: it is meant for targets without a unit for either.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fast;

impl Math<f32> for Exact {
    #[inline]
    fn sqrt(x: f32) -> f32 {
        sqrt::sqrt_f32(x)
    }
    #[inline(always)]
    fn sqrt_each<const K: usize>(x: [f32; K]) -> [f32; K] {
        sqrt::sqrt_each_f32(x)
    }
    #[inline(always)]
    fn three_halves<const K: usize>(x: [f32; K]) -> [f32; K] {
        sqrt::three_halves_f32(x)
    }
    #[inline]
    fn powf(x: f32, n: f32) -> f32 {
        power::pow_f32(x, n)
    }
    #[inline]
    fn ninth_root(x: f32) -> f32 {
        ninth_root::ninth_root_f32(x)
    }
    #[inline(always)]
    fn sin_cos(angle: Phase) -> (f32, f32) {
        trig::sin_cos_f32(angle)
    }
}

impl Math<f64> for Exact {
    #[inline]
    fn sqrt(x: f64) -> f64 {
        sqrt::sqrt_f64(x)
    }
    #[inline]
    fn powf(x: f64, n: f64) -> f64 {
        libm::pow(x, n)
    }
    #[inline]
    fn ninth_root(x: f64) -> f64 {
        ninth_root::ninth_root_f64(x)
    }
    #[inline]
    fn sin_cos(angle: Phase) -> (f64, f64) {
        trig::sin_cos_f64(angle)
    }
}

impl Math<f32> for Fast {
    #[inline]
    fn sqrt(x: f32) -> f32 {
        // micromath's estimate of 1/sqrt(x) is 3.4 % off; one Newton step without a division makes it 0.18 %.
        // Its subtraction overflows below 0: of NaN with a sign, where builds with assertions would stop.
        let inverse = <f32 as micromath::F32Ext>::invsqrt(Scalar::abs(x));
        x * inverse * (1.5 - 0.5 * x * inverse * inverse)
    }
    #[inline]
    fn powf(x: f32, n: f32) -> f32 {
        power::pow_f32(x, n)
    }
    #[inline]
    fn ninth_root(x: f32) -> f32 {
        ninth_root::ninth_root_f32(x)
    }
    #[inline(always)]
    fn sin_cos(angle: Phase) -> (f32, f32) {
        trig::sin_cos_f32(angle)
    }
}

impl Math<f64> for Fast {
    #[inline]
    fn sqrt(x: f64) -> f64 {
        f64::from(<Self as Math<f32>>::sqrt(x as f32))
    }
    #[inline]
    fn powf(x: f64, n: f64) -> f64 {
        f64::from(<Self as Math<f32>>::powf(x as f32, n as f32))
    }
    #[inline]
    fn ninth_root(x: f64) -> f64 {
        f64::from(ninth_root::ninth_root_f32(x as f32))
    }
    #[inline]
    fn sin_cos(angle: Phase) -> (f64, f64) {
        let (sin, cos) = trig::sin_cos_f32(angle);
        (f64::from(sin), f64::from(cos))
    }
}

/// Horner's scheme, the constant term first in `coefficients`.
#[inline(always)]
fn polynomial<T: Scalar, const N: usize>(x: T, coefficients: [T; N]) -> T {
    let mut rising = coefficients.into_iter().rev();
    let highest = rising.next().unwrap_or(T::ZERO);
    rising.fold(highest, |sum, c| sum * x + c)
}

/// The same of eight coefficients by pairs and pairs of pairs: three steps one after the other instead of seven.
#[inline(always)]
fn polynomial_by_pairs<X>(x: X, [c0, c1, c2, c3, c4, c5, c6, c7]: [X; 8]) -> X
where
    X: Copy + Add<Output = X> + Mul<Output = X>,
{
    let xx = x * x;
    let [a, b, c, d] = [c0 + c1 * x, c2 + c3 * x, c4 + c5 * x, c6 + c7 * x];
    (a + b * xx) + (c + d * xx) * (xx * xx)
}
