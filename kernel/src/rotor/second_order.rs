//! What is linear of a system, and what excites it.

use super::ShaftMotion;
use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// A linear mechanical system of `D` coordinates under a turning excitation:
/// `M q'' + (B + w G) q' + K q = f_E(t)` (Hajzman, eq. 6 without its bearings).
pub trait SecondOrderSystem<T: Scalar, const D: usize> {
    /// The part of `f_E` that does not change: weight and constant load.
    fn constant_load(&self) -> [T; D];

    /// `f_E`, weight and unbalance with the shaft as `shaft` says.
    fn excitation(&self, shaft: &ShaftMotion<T>) -> [T; D];

    /// `-(B + w G) q' - K q`.
    fn internal_force(&self, q: &[T; D], rate: &[T; D], speed: T) -> [T; D];

    /// `M^-1 f`.
    fn acceleration(&self, f: &[T; D]) -> [T; D];

    /// `M a`.
    fn inertia_force(&self, a: &[T; D]) -> [T; D];

    /// `m M + c (B + w G) + k K` for `[m, c, k]`: what an implicit step has to solve with.
    fn effective_matrix(&self, parts: [T; 3], speed: T) -> SMatrix<T, D, D>;
}
