//! Five equations, solved without pivoting and without a panic path.

use crate::frame::Stiffness;
use crate::scalar::Scalar;

/// `x` of `A x = b` by elimination in the given order.
///
/// No pivoting: the matrices here have a positive definite symmetric part (mass, damping and a contact tangent
/// that only pushes, plus a skew gyroscopic part), for which elimination in any order is stable (Golub and
/// Van Loan, Matrix Computations, 4.2.2). A singular matrix gives entries that are not finite, which the step flags.
pub fn solve<T: Scalar>(mut a: Stiffness<T>, mut b: [T; 5]) -> [T; 5] {
    for k in 0..5 {
        let inverse = T::ONE / a[(k, k)];
        for i in (k + 1)..5 {
            let factor = a[(i, k)] * inverse;
            for j in (k + 1)..5 {
                let above = a[(k, j)];
                a[(i, j)] -= factor * above;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..5).rev() {
        let mut sum = b[k];
        for j in (k + 1)..5 {
            sum -= a[(k, j)] * b[j];
        }
        b[k] = sum / a[(k, k)];
    }
    b
}
