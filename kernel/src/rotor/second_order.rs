//! Linear part of a rotor-bearing system, with its excitation.

use super::ShaftMotion;
use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// A linear mechanical system of `D` coordinates with rotating excitation: `M q'' + (B + w G) q' + K q = f_E(t)` (Hajzman,
/// eq. 6 without bearings).
pub trait SecondOrderSystem<T: Scalar, const D: usize> {
    /// Returns the constant part of `f_E`: weight and load.
    fn constant_load(&self) -> [T; D];

    /// Returns `f_E`, weight, load and unbalance, at a shaft motion.
    fn excitation(&self, shaft: &ShaftMotion<T>) -> [T; D];

    /// Returns `-(B + w G) q' - K q`.
    fn internal_force(&self, q: &[T; D], rate: &[T; D], speed: T) -> [T; D];

    /// Returns `M^-1 f`.
    fn acceleration(&self, f: &[T; D]) -> [T; D];

    /// Returns `M a`.
    fn inertia_force(&self, a: &[T; D]) -> [T; D];

    /// Returns `m M + c (B + w G) + k K` for `[m, c, k]`: the matrix of an implicit step.
    fn effective_matrix(&self, parts: [T; 3], speed: T) -> SMatrix<T, D, D>;
}
