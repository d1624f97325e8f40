//! Vibration modes of a free rotor in one plane, and along the axis.

use ballrace_base::eigenvalues::EigenvalueError;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Iterations of the eigenvalue solver per coordinate.
const ITERATIONS: usize = 100;

/// Modes with the modal mass 1, in the order of their frequencies.
pub struct Modes {
    /// Squares of the natural frequencies, (rad/s)^2.
    pub squares: DVector<f64>,
    /// One shape per column.
    pub shapes: DMatrix<f64>,
}

impl Modes {
    /// Solves `K x = w^2 M x` for symmetric matrices, M positive definite.
    ///
    /// # Errors
    /// Returns an error if the mass is not positive definite or the iteration does not converge.
    pub fn try_new(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Result<Self, EigenvalueError> {
        // Displacements and rotations differ in size: the mass is scaled to a unit diagonal.
        let n = mass.nrows();
        let failed = EigenvalueError::NotConverged { order: n, iterations: ITERATIONS * n };
        let scale = DVector::from_fn(n, |i, _| mass[(i, i)].max(f64::MIN_POSITIVE).sqrt());
        let scaled = |m: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| m[(i, j)] / (scale[i] * scale[j]));
        let factor = scaled(mass).cholesky().ok_or(failed)?.l();
        let solved = |m: &DMatrix<f64>| factor.solve_lower_triangular(m).ok_or(failed);
        let half = solved(&scaled(stiffness))?;
        let whole = solved(&half.transpose())?;
        let symmetric = 0.5 * (&whole + whole.transpose());
        let found = SymmetricEigen::try_new(symmetric, f64::EPSILON, ITERATIONS * n).ok_or(failed)?;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
        let sorted = DMatrix::from_fn(n, n, |i, j| found.eigenvectors[(i, order[j])]);
        let mut shapes = factor.transpose().solve_upper_triangular(&sorted).ok_or(failed)?;
        for (mut row, scale) in shapes.row_iter_mut().zip(scale.iter()) {
            row /= *scale;
        }
        Ok(Self { squares: DVector::from_fn(n, |j, _| found.eigenvalues[order[j]].max(0.0)), shapes })
    }

    /// Returns the natural frequencies without the first `skipped`, Hz.
    pub fn frequencies(&self, skipped: usize) -> impl Iterator<Item = f64> {
        self.squares.iter().skip(skipped).map(|square| square.sqrt() / std::f64::consts::TAU)
    }
}
