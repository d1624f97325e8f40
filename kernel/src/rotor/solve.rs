//! Linear equations of a fixed number, solved without pivoting and without a panic path.

use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// `x` of `A x = b` by elimination in the given order. Cost: `D^3/3` multiplications.
///
/// No pivoting: the matrices here have a positive definite symmetric part (mass, damping and a contact tangent
/// that only pushes, plus a skew gyroscopic part), for which elimination in any order is stable (Golub and
/// Van Loan, Matrix Computations, 4.2.2). A singular matrix gives entries that are not finite, which the step flags.
pub fn solve<T: Scalar, const D: usize>(mut a: SMatrix<T, D, D>, mut b: [T; D]) -> [T; D] {
    for k in 0..D {
        let inverse = T::ONE / a[(k, k)];
        for i in (k + 1)..D {
            let factor = a[(i, k)] * inverse;
            for j in (k + 1)..D {
                let above = a[(k, j)];
                a[(i, j)] -= factor * above;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..D).rev() {
        let mut sum = b[k];
        for j in (k + 1)..D {
            sum -= a[(k, j)] * b[j];
        }
        b[k] = sum / a[(k, k)];
    }
    b
}
