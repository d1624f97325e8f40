//! Least squares of what a simulation leaves: Levenberg and Marquardt with differences on both sides.

use anyhow::Result;
use nalgebra::{DMatrix, DVector};

/// Unknowns in units of their scale: a step of [`DIFFERENCE`] changes the residuals visibly and nearly linearly.
const DIFFERENCE: f64 = 1e-4;
const ITERATIONS: usize = 40;

/// Of a thread: a machine of many coordinates is large before it is boxed.
const STACK: usize = 16 << 20;

/// Residuals as a function of the unknowns.
pub type Residuals<'a> = &'a (dyn Fn(&[f64]) -> Result<Vec<f64>> + Sync);

/// The best unknowns.
pub struct Solution {
    /// In units of their scale.
    pub x: Vec<f64>,
    /// What is left.
    pub residuals: DVector<f64>,
    /// Its slopes there.
    pub jacobian: DMatrix<f64>,
}

/// From `start` until an iteration makes the sum of squares less than `least_fall` of itself smaller; `progress` is called
/// after each.
///
/// # Errors
/// What `residuals` says.
pub fn solve(
    start: Vec<f64>,
    residuals: Residuals,
    least_fall: f64,
    progress: &mut dyn FnMut(usize),
) -> Result<Solution> {
    let mut x = start;
    let mut r = DVector::from_vec(residuals(&x)?);
    let mut jacobian = slopes(&x, residuals)?;
    let mut damping = 1e-3;
    for iteration in 0..ITERATIONS {
        progress(iteration);
        let (normal, gradient) = (jacobian.transpose() * &jacobian, jacobian.transpose() * &r);
        let Some((next, left)) = step(&x, &r, &normal, &gradient, &mut damping, residuals)? else { break };
        let fall = 1.0 - left.norm_squared() / r.norm_squared();
        (x, r) = (next, left);
        jacobian = slopes(&x, residuals)?;
        if fall < least_fall {
            break;
        }
    }
    Ok(Solution { x, residuals: r, jacobian })
}

/// The next unknowns, if any step makes less of the residuals.
fn step(
    x: &[f64],
    r: &DVector<f64>,
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: &mut f64,
    residuals: Residuals,
) -> Result<Option<(Vec<f64>, DVector<f64>)>> {
    let largest = normal.diagonal().max();
    for _ in 0..8 {
        let mut damped = normal.clone();
        for i in 0..x.len() {
            damped[(i, i)] += *damping * normal[(i, i)].max(1e-12 * largest);
        }
        if let Some(factor) = damped.cholesky() {
            let change = factor.solve(gradient);
            let next: Vec<f64> = x.iter().zip(change.iter()).map(|(x, d)| x - d).collect();
            let left = DVector::from_vec(residuals(&next)?);
            if left.norm_squared() < r.norm_squared() {
                *damping = (*damping * 0.1).max(1e-9);
                return Ok(Some((next, left)));
            }
        }
        *damping *= 10.0;
    }
    Ok(None)
}

/// Central differences, the unknowns shared out over all cores.
fn slopes(x: &[f64], residuals: Residuals) -> Result<DMatrix<f64>> {
    let column = |i: usize| -> Result<Vec<f64>> {
        let moved = |by: f64| {
            let mut there = x.to_vec();
            there[i] += by;
            residuals(&there)
        };
        let (up, down) = (moved(DIFFERENCE)?, moved(-DIFFERENCE)?);
        Ok(up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * DIFFERENCE)).collect())
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(x.len().max(1));
    let share = |t: usize| (t..x.len()).step_by(threads).map(|i| Ok((i, column(i)?))).collect::<Result<Vec<_>>>();
    let share = &share;
    let parts = std::thread::scope(|scope| -> Result<Vec<_>> {
        let start = |t| std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, move || share(t));
        let running = (0..threads).map(start).collect::<std::io::Result<Vec<_>>>()?;
        Ok(running.into_iter().map(|one| one.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect())
    })?;
    let mut columns = vec![vec![]; x.len()];
    for part in parts {
        for (i, column) in part? {
            columns[i] = column;
        }
    }
    let rows = columns.first().map_or(0, Vec::len);
    Ok(DMatrix::from_fn(rows, x.len(), |i, j| columns[j][i]))
}
