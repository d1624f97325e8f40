//! Nonlinear least squares within bounds: Levenberg-Marquardt steps projected onto the bounds. The Jacobian of a step is computed
//! by one-sided differences, that of the solution by central ones at twice the cost.

use crate::parallel;
use nalgebra::{DMatrix, DVector};

/// Step of the differences, in units of the scale of an unknown.
const DIFFERENCE: f64 = 1e-4;
/// Largest number of iterations of a search without another limit.
const ITERATIONS: usize = 40;

/// Smallest and largest value of an unknown, in units of its scale.
pub type Bounds = [f64; 2];

/// Limits of a search.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Bounds of each unknown.
    pub bounds: Vec<Bounds>,
    /// Longest step of an unknown, in units of its scale.
    pub longest_step: f64,
    /// Largest number of iterations.
    pub iterations: usize,
}

impl Limits {
    /// Creates infinite limits for `count` unknowns.
    #[must_use]
    pub fn none(count: usize) -> Self {
        Self {
            bounds: vec![[f64::NEG_INFINITY, f64::INFINITY]; count],
            longest_step: f64::INFINITY,
            iterations: ITERATIONS,
        }
    }
}

/// Residuals as a function of the unknowns.
pub type Residuals<'a, E> = &'a (dyn Fn(&[f64]) -> Result<Vec<f64>, E> + Sync);

/// Solution of a search.
pub struct Solution {
    /// Unknowns, in units of their scale.
    pub x: Vec<f64>,
    /// Residuals.
    pub residuals: DVector<f64>,
    /// Jacobian of the residuals.
    pub jacobian: DMatrix<f64>,
    /// Iterations of the search.
    pub iterations: usize,
    /// Relative decrease of the sum of squares in the last iteration where the search ended at its largest number of iterations; `None`
    /// where it ended at a minimum.
    pub still_falls: Option<f64>,
}

/// Returns the unknowns that minimise the sum of squares, from `start`, until an iteration reduces it by less than the share
/// `least_fall`.
///
/// # Errors
/// Returns the errors of [`solve_within`].
pub fn solve<E: Send>(start: Vec<f64>, residuals: Residuals<E>, least_fall: f64) -> Result<Vec<f64>, E> {
    let limits = Limits::none(start.len());
    Ok(minimise(start, &limits, residuals, least_fall, &mut |_| {})?.x)
}

/// Minimises the sum of squares as [`solve`], with `residuals` evaluated only within `limits`; calls `progress` before each
/// iteration.
///
/// # Errors
/// Returns an error of `residuals` at the start or next to an accepted point. A trial step at which it fails is rejected and a
/// shorter one is tried.
pub fn solve_within<E: Send>(
    start: Vec<f64>,
    limits: &Limits,
    residuals: Residuals<E>,
    least_fall: f64,
    progress: &mut dyn FnMut(usize),
) -> Result<Solution, E> {
    let Minimum { x, residuals: r, iterations, still_falls } =
        minimise(start, limits, residuals, least_fall, progress)?;
    let jacobian = slopes(&x, None, &limits.bounds, residuals)?;
    Ok(Solution { x, residuals: r, jacobian, iterations, still_falls })
}

/// Unknowns and residuals where a search ended, as in [`Solution`].
struct Minimum {
    x: Vec<f64>,
    residuals: DVector<f64>,
    iterations: usize,
    still_falls: Option<f64>,
}

/// Searches the minimum.
fn minimise<E: Send>(
    start: Vec<f64>,
    limits: &Limits,
    residuals: Residuals<E>,
    least_fall: f64,
    progress: &mut dyn FnMut(usize),
) -> Result<Minimum, E> {
    let mut x: Vec<f64> = start.iter().zip(&limits.bounds).map(|(x, [low, high])| x.clamp(*low, *high)).collect();
    let mut r = DVector::from_vec(residuals(&x)?);
    let mut damping = 1e-3;
    let mut still_falls = None;
    let mut iterations = 0;
    while iterations < limits.iterations {
        progress(iterations);
        iterations += 1;
        still_falls = None;
        let jacobian = slopes(&x, Some(&r), &limits.bounds, residuals)?;
        let (normal, gradient) = (jacobian.transpose() * &jacobian, jacobian.transpose() * &r);
        let Some((next, reduced)) = step((&x, &r), limits, (&normal, &gradient), &mut damping, residuals) else {
            break;
        };
        let fall = 1.0 - reduced.norm_squared() / r.norm_squared();
        (x, r) = (next, reduced);
        if fall < least_fall {
            break;
        }
        still_falls = Some(fall);
    }
    Ok(Minimum { x, residuals: r, iterations, still_falls })
}

/// Returns the next unknowns; `None` if no step reduces the residuals. An unknown at a bound that the step would cross is
/// fixed there while the others move.
fn step<E>(
    (x, r): (&[f64], &DVector<f64>),
    Limits { bounds, longest_step, .. }: &Limits,
    (normal, gradient): (&DMatrix<f64>, &DVector<f64>),
    damping: &mut f64,
    residuals: Residuals<E>,
) -> Option<(Vec<f64>, DVector<f64>)> {
    // A step goes against the gradient.
    let held = |i: usize| {
        let [low, high] = bounds[i];
        (x[i] <= low && gradient[i] > 0.0) || (x[i] >= high && gradient[i] < 0.0)
    };
    let free: Vec<usize> = (0..x.len()).filter(|&i| !held(i)).collect();
    if free.is_empty() {
        return None;
    }
    let part = DMatrix::from_fn(free.len(), free.len(), |i, j| normal[(free[i], free[j])]);
    let downhill = DVector::from_fn(free.len(), |i, _| gradient[free[i]]);
    let largest = part.diagonal().iter().copied().fold(0.0, f64::max);
    for _ in 0..8 {
        let mut damped = part.clone();
        for i in 0..free.len() {
            damped[(i, i)] += *damping * part[(i, i)].max(1e-12 * largest);
        }
        if let Some(factor) = damped.cholesky() {
            let change = factor.solve(&downhill);
            let shorter = (longest_step / change.amax()).min(1.0);
            let mut next = x.to_vec();
            for (&i, change) in free.iter().zip(change.iter()) {
                next[i] = (x[i] - shorter * change).clamp(bounds[i][0], bounds[i][1]);
            }
            // A point that cannot be computed is rejected like one with larger residuals.
            let reduced = residuals(&next).ok().map(DVector::from_vec);
            if let Some(reduced) = reduced.filter(|reduced| reduced.norm_squared() < r.norm_squared()) {
                *damping = (*damping * 0.1).max(1e-9);
                return Some((next, reduced));
            }
        }
        *damping *= 10.0;
    }
    None
}

/// Computes the Jacobian, the unknowns in parallel: by one-sided differences from the residuals `here`, or by central ones,
/// one-sided at a bound.
fn slopes<E>(
    x: &[f64],
    here: Option<&DVector<f64>>,
    bounds: &[Bounds],
    residuals: Residuals<E>,
) -> Result<DMatrix<f64>, E>
where
    E: Send,
{
    let column = |i: usize| -> Result<Vec<f64>, E> {
        let [low, high] = bounds[i];
        let at = |x_i: f64| {
            let mut there = x.to_vec();
            there[i] = x_i;
            residuals(&there)
        };
        let (above, below) = ((x[i] + DIFFERENCE).min(high), (x[i] - DIFFERENCE).max(low));
        let quotients =
            |up: &[f64], down: &[f64], step: f64| up.iter().zip(down).map(|(a, b)| (a - b) / step).collect();
        Ok(match here {
            Some(here) if above > x[i] => quotients(&at(above)?, here.as_slice(), above - x[i]),
            Some(here) => quotients(here.as_slice(), &at(below)?, x[i] - below),
            None => quotients(&at(above)?, &at(below)?, above - below),
        })
    };
    let unknowns: Vec<usize> = (0..x.len()).collect();
    let columns = parallel::map(&unknowns, |i| column(*i)).into_iter().collect::<Result<Vec<_>, E>>()?;
    let rows = columns.first().map_or(0, Vec::len);
    Ok(DMatrix::from_fn(rows, x.len(), |i, j| columns[j][i]))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    const OPEN: Bounds = [f64::NEG_INFINITY, f64::INFINITY];

    fn solved(start: Vec<f64>, bounds: &[Bounds], residuals: Residuals<std::io::Error>) -> Solution {
        let limits = Limits { bounds: bounds.to_vec(), longest_step: 10.0, iterations: ITERATIONS };
        solve_within(start, &limits, residuals, 1e-12, &mut |_| {}).unwrap()
    }

    #[test]
    fn the_least_squares_of_a_line() {
        let line = |x: &[f64]| Ok((0..5).map(|i| x[0] + f64::from(i) * x[1] - (2.0 + 3.0 * f64::from(i))).collect());
        let found = solved(vec![0.0, 0.0], &[OPEN; 2], &line);
        assert!((found.x[0] - 2.0).abs() < 1e-6 && (found.x[1] - 3.0).abs() < 1e-6, "{:?}", found.x);
    }

    /// Outside the bounds the residuals cannot be computed; the least within them is at a bound for one unknown and
    /// inside for the other.
    #[test]
    fn nothing_is_evaluated_beyond_a_bound() {
        let residuals = |x: &[f64]| {
            if x[0] < 0.0 {
                return Err(std::io::Error::other(format!("below the bound: {}", x[0])));
            }
            Ok(vec![x[0] + 1.0, x[1] - 2.0 + 0.5 * x[0]])
        };
        for start in [0.0, 1e-5, 3.0] {
            let found = solved(vec![start, 0.0], &[[0.0, 5.0], OPEN], &residuals);
            assert!(found.x[0].abs() < 1e-9 && (found.x[1] - 2.0).abs() < 1e-6, "{start}: {:?}", found.x);
        }
    }

    /// The search leaves a bound at which it starts.
    #[test]
    fn a_start_at_a_bound() {
        let residuals = |x: &[f64]| Ok(vec![x[0] - 1.0]);
        for start in [0.0, 9.0] {
            let found = solved(vec![start], &[[0.0, 9.0]], &residuals);
            assert!((found.x[0] - 1.0).abs() < 1e-6, "{start}: {:?}", found.x);
        }
    }

    /// A search whose minimum is at infinity ends at its largest number of iterations.
    #[test]
    fn a_search_without_a_minimum_ends() {
        let limits = Limits { bounds: vec![OPEN], longest_step: 1.0, iterations: 7 };
        let residuals = |x: &[f64]| Ok::<_, std::io::Error>(vec![(-x[0]).exp()]);
        let mut count = 0;
        let found = solve_within(vec![0.0], &limits, &residuals, 1e-7, &mut |_| count += 1).unwrap();
        assert_eq!((found.iterations, count), (7, 7));
        assert!(found.still_falls.is_some_and(|fall| fall > 0.1), "{:?}", found.still_falls);
    }

    /// A step to where nothing can be computed is shortened instead of ending the search.
    #[test]
    fn a_step_that_fails_is_rejected() {
        let residuals = |x: &[f64]| {
            if x[0] > 4.0 {
                return Err(std::io::Error::other("beyond"));
            }
            // Its first Newton step from 0.5 leads beyond 4.
            Ok(vec![x[0].powi(3) - 8.0])
        };
        let found = solved(vec![0.5], &[OPEN], &residuals);
        assert!((found.x[0] - 2.0).abs() < 1e-5, "{:?}", found.x);
    }
}
