//! A rotor under an unmodelled external force.

use crate::rotor::{SecondOrderSystem, ShaftMotion};
use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// A system with an additional constant load: `M q'' + (B + w G) q' + K q = f_E(t) + f_B(q, t) + d`.
#[derive(Debug, Clone, Copy)]
pub struct WithUnmodelledForce<'a, R, T, const D: usize> {
    /// The modelled system.
    pub system: &'a R,
    /// Additional load on the coordinates, N and N m.
    pub load: [T; D],
}

impl<R, T: Scalar, const D: usize> WithUnmodelledForce<'_, R, T, D> {
    #[inline(always)]
    fn added(&self, mut f: [T; D]) -> [T; D] {
        for (entry, &load) in f.iter_mut().zip(&self.load) {
            *entry += load;
        }
        f
    }
}

impl<R: SecondOrderSystem<T, D>, T: Scalar, const D: usize> SecondOrderSystem<T, D>
    for WithUnmodelledForce<'_, R, T, D>
{
    fn constant_load(&self) -> [T; D] {
        self.added(self.system.constant_load())
    }
    #[inline(always)]
    fn excitation(&self, shaft: &ShaftMotion<T>) -> [T; D] {
        self.added(self.system.excitation(shaft))
    }
    #[inline(always)]
    fn internal_force(&self, q: &[T; D], rate: &[T; D], speed: T) -> [T; D] {
        self.system.internal_force(q, rate, speed)
    }
    #[inline(always)]
    fn acceleration(&self, f: &[T; D]) -> [T; D] {
        self.system.acceleration(f)
    }
    fn inertia_force(&self, a: &[T; D]) -> [T; D] {
        self.system.inertia_force(a)
    }
    fn effective_matrix(&self, parts: [T; 3], speed: T) -> SMatrix<T, D, D> {
        self.system.effective_matrix(parts, speed)
    }
}
