//! Linear equations of a fixed order, solved without pivoting and without panics.

use crate::scalar::Scalar;
use core::borrow::{Borrow, BorrowMut};
use nalgebra::SMatrix;

/// LU factors of a matrix, for several right sides. `A` stores them: in place, or behind a pointer.
#[derive(Debug, Clone, Copy)]
pub struct Factored<A>(A);

impl<A> Factored<A> {
    /// Factors a matrix in place, in the given order. Cost: `D^3/3` multiplications, `D` divisions.
    #[must_use]
    #[inline(always)]
    pub fn new<T: Scalar, const D: usize>(mut matrix: A) -> Self
    where
        A: BorrowMut<SMatrix<T, D, D>>,
    {
        let a = matrix.borrow_mut();
        for k in 0..D {
            let inverse = T::ONE / a[(k, k)];
            a[(k, k)] = inverse;
            for i in (k + 1)..D {
                let factor = a[(i, k)] * inverse;
                a[(i, k)] = factor;
                for j in (k + 1)..D {
                    let above = a[(k, j)];
                    a[(i, j)] -= factor * above;
                }
            }
        }
        Self(matrix)
    }

    /// Returns `x` of `A x = b`. Cost: `D^2` multiplications.
    #[must_use]
    #[inline(always)]
    pub fn solve<T: Scalar, const D: usize>(&self, mut b: [T; D]) -> [T; D]
    where
        A: Borrow<SMatrix<T, D, D>>,
    {
        let a = self.0.borrow();
        for k in 0..D {
            for i in (k + 1)..D {
                b[i] -= a[(i, k)] * b[k];
            }
        }
        for k in (0..D).rev() {
            b[k] *= a[(k, k)];
            for i in 0..k {
                b[i] -= a[(i, k)] * b[k];
            }
        }
        b
    }
}

/// Inverse of a matrix, for many right sides: a product instead of two chains of `D` dependent steps. `A` stores it.
#[derive(Debug, Clone, Copy)]
pub struct Inverse<A>(A);

impl<A> Inverse<A> {
    /// Inverts a factored matrix column by column. Cost: `D^3` multiplications.
    #[must_use]
    #[inline(always)]
    pub fn new<T: Scalar, const D: usize>(factored: &Factored<A>) -> Self
    where
        A: BorrowMut<SMatrix<T, D, D>> + From<SMatrix<T, D, D>>,
    {
        let mut inverse = A::from(SMatrix::from_element(T::ZERO));
        for (k, column) in inverse.borrow_mut().data.0.iter_mut().enumerate() {
            let mut unit = [T::ZERO; D];
            for (i, entry) in unit.iter_mut().enumerate() {
                *entry = if i == k { T::ONE } else { T::ZERO };
            }
            *column = factored.solve(unit);
        }
        Self(inverse)
    }

    /// Returns `x` of `A x = b`. Cost: `D^2` multiplications.
    #[must_use]
    #[inline(always)]
    pub fn solve<T: Scalar, const D: usize>(&self, b: [T; D]) -> [T; D]
    where
        A: Borrow<SMatrix<T, D, D>>,
    {
        let mut x = [T::NEGATIVE_ZERO; D];
        for (column, &b) in self.0.borrow().data.0.iter().zip(&b) {
            for (entry, &a) in x.iter_mut().zip(column) {
                *entry += a * b;
            }
        }
        x
    }
}

/// Returns `x` of `A x = b` by elimination in the given order. Cost: `D^3/3` multiplications, `D` divisions.
///
/// No pivoting: the matrices have a positive definite symmetric part (mass, damping, contact stiffness) and a
/// skew-symmetric gyroscopic part, for which elimination in any order is stable (Golub and Van Loan, Matrix Computations,
/// 4.2.2). A singular matrix gives entries that are not finite, which the integrator flags.
pub fn solve<T: Scalar, const D: usize>(a: SMatrix<T, D, D>, b: [T; D]) -> [T; D] {
    Factored::new(a).solve(b)
}
