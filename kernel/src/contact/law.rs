//! Load from deflection, `F = K Delta^n` for `Delta > 0` (Hajzman, eq. 1, with `C = K^(-1/n)`).

use crate::math::Math;
use crate::scalar::Scalar;

/// A load-deflection law. `deflection` is 0 or more; both functions give 0 at 0.
pub trait Law<T: Scalar, M: Math<T>>: Copy + Send + Sync + 'static {
    /// Load, N.
    fn load(&self, deflection: T) -> T;
    /// Load, N, and its slope, N/m.
    fn load_and_slope(&self, deflection: T) -> (T, T);
}

/// Point contact, `n = 3/2`: one square root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T> {
    /// K, N/m^1.5.
    pub stiffness: T,
}

/// Line contact, `n = 10/9`: one ninth root, no logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line<T> {
    /// K, N/m^(10/9).
    pub stiffness: T,
}

/// Any exponent of 1 or more, by the backend's power function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power<T> {
    /// K, N/m^n.
    pub stiffness: T,
    /// n, 1 or more.
    pub exponent: T,
}

impl<T: Scalar, M: Math<T>> Law<T, M> for Point<T> {
    fn load(&self, deflection: T) -> T {
        self.stiffness * M::sqrt(deflection) * deflection
    }
    fn load_and_slope(&self, deflection: T) -> (T, T) {
        let k_root = self.stiffness * M::sqrt(deflection);
        (k_root * deflection, T::from_f64(1.5) * k_root)
    }
}

impl<T: Scalar, M: Math<T>> Law<T, M> for Line<T> {
    fn load(&self, deflection: T) -> T {
        self.stiffness * M::ninth_root(deflection) * deflection
    }
    fn load_and_slope(&self, deflection: T) -> (T, T) {
        let k_root = self.stiffness * M::ninth_root(deflection);
        // The ninth root of 0 is a small number, not 0: unloaded elements must add no stiffness.
        let slope = if deflection > T::ZERO { T::from_f64(10.0 / 9.0) * k_root } else { T::ZERO };
        (k_root * deflection, slope)
    }
}

impl<T: Scalar, M: Math<T>> Law<T, M> for Power<T> {
    fn load(&self, deflection: T) -> T {
        self.stiffness * M::powf(deflection, self.exponent)
    }
    fn load_and_slope(&self, deflection: T) -> (T, T) {
        let load = <Self as Law<T, M>>::load(self, deflection);
        let slope = if deflection > T::ZERO { self.exponent * load / deflection } else { T::ZERO };
        (load, slope)
    }
}
