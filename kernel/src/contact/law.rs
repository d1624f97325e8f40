//! Load-deflection laws `F = K Delta^n` for `Delta > 0` (Hajzman, eq. 1, with `C = K^(-1/n)`).

use crate::math::Math;
use crate::scalar::Scalar;

/// A load-deflection law: an unscaled load per element, and a scale factor for their sum.
///
/// The argument is twice the deflection, because `x + |x|`, twice the positive part, takes two instructions.
pub trait LoadDeflectionLaw<T: Scalar, M: Math<T>>: Copy + Send + Sync + 'static {
    /// Returns `sign(x) |x|^n` for each `x`, twice a deflection; 0 at 0.
    fn unscaled_load<const K: usize>(&self, twice_deflection: [T; K]) -> [T; K];

    /// Returns the unscaled load for `x >= 0` and its derivative by the deflection.
    fn unscaled_load_and_slope(&self, twice_deflection: T) -> (T, T);

    /// Returns the factor from unscaled loads to newtons: `K / 2^n`.
    fn scale(&self) -> T;

    /// Returns the load at a deflection (m, 0 or more), N.
    #[inline(always)]
    fn load(&self, deflection: T) -> T {
        let [unscaled] = self.unscaled_load([deflection + deflection]);
        self.scale() * unscaled
    }
}

/// Point contact, `n = 3/2`: one square root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointContactLaw<T> {
    /// K, N/m^1.5.
    pub stiffness: T,
}

/// Line contact, `n = 10/9`: one ninth root, no logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineContactLaw<T> {
    /// K, N/m^(10/9).
    pub stiffness: T,
}

/// Any exponent of 1 or more, by the backend's power function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw<T> {
    /// K, N/m^n.
    pub stiffness: T,
    /// n, 1 or more.
    pub exponent: T,
}

/// 2^(-10/9)
const TWO_TO_MINUS_TEN_NINTHS: f64 = 0.462_937_356_143_645_2;

impl<T: Scalar, M: Math<T>> LoadDeflectionLaw<T, M> for PointContactLaw<T> {
    #[inline(always)]
    fn unscaled_load<const K: usize>(&self, twice_deflection: [T; K]) -> [T; K] {
        M::three_halves(twice_deflection)
    }
    #[inline(always)]
    fn unscaled_load_and_slope(&self, twice_deflection: T) -> (T, T) {
        let root = M::sqrt(twice_deflection);
        (root * twice_deflection, T::from_f64(3.0) * root)
    }
    #[inline(always)]
    fn scale(&self) -> T {
        self.stiffness * T::from_f64(core::f64::consts::FRAC_1_SQRT_2 / 2.0)
    }
}

impl<T: Scalar, M: Math<T>> LoadDeflectionLaw<T, M> for LineContactLaw<T> {
    #[inline(always)]
    fn unscaled_load<const K: usize>(&self, twice_deflection: [T; K]) -> [T; K] {
        twice_deflection.map(|x| x * M::ninth_root(x.abs()))
    }
    #[inline(always)]
    fn unscaled_load_and_slope(&self, twice_deflection: T) -> (T, T) {
        let root = M::ninth_root(twice_deflection);
        // The ninth root of 0 is a small number instead of 0; unloaded elements must add no stiffness.
        let slope = if twice_deflection > T::ZERO { T::from_f64(20.0 / 9.0) * root } else { T::ZERO };
        (root * twice_deflection, slope)
    }
    #[inline(always)]
    fn scale(&self) -> T {
        self.stiffness * T::from_f64(TWO_TO_MINUS_TEN_NINTHS)
    }
}

impl<T: Scalar, M: Math<T>> LoadDeflectionLaw<T, M> for PowerLaw<T> {
    #[inline(always)]
    fn unscaled_load<const K: usize>(&self, twice_deflection: [T; K]) -> [T; K] {
        twice_deflection.map(|x| M::powf(T::HALF * x.abs(), self.exponent).xor_sign(x))
    }
    #[inline(always)]
    fn unscaled_load_and_slope(&self, twice_deflection: T) -> (T, T) {
        let deflection = T::HALF * twice_deflection;
        let unscaled = M::powf(deflection, self.exponent);
        let slope = if deflection > T::ZERO { self.exponent * unscaled / deflection } else { T::ZERO };
        (unscaled, slope)
    }
    #[inline(always)]
    fn scale(&self) -> T {
        // `unscaled_load` halves its argument: 2^n would need a power.
        self.stiffness
    }
}
