//! Nonlinear least squares: Levenberg-Marquardt steps within bounds; Broyden's update of the slopes between their evaluations.

use crate::parallel;
use nalgebra::{DMatrix, DVector};

/// Step of the differences, in units of the scale of an unknown.
const DIFFERENCE: f64 = 1e-4;
/// Relative fall of the sum of squares from which on the minimum is near.
const NEAR: f64 = 1e-3;
/// Fall over the excess of the sum of squares beyond noise that is not worth a further step.
const LEAST_SHARE: f64 = 1e-4;
/// Largest number of iterations of a search without another limit.
const ITERATIONS: usize = 40;
/// First damping, and the least one.
const DAMPING: [f64; 2] = [1e-4, 1e-9];
/// Dampings tried in a step.
const DAMPINGS: usize = 8;

/// Smallest and largest value of an unknown.
pub type Bounds = [f64; 2];

/// Bounds of an unknown that has none.
pub const OPEN: Bounds = [f64::NEG_INFINITY, f64::INFINITY];

/// A sum of squares as a function of some unknowns.
pub trait Problem {
    /// Unknowns with what is computed from them.
    type Point;
    /// Error of a point that cannot be computed.
    type Error;

    /// Returns the unknowns of a point.
    fn unknowns(&self, at: &Self::Point) -> Vec<f64>;

    /// Returns the residuals at a point.
    fn residuals<'p>(&self, at: &'p Self::Point) -> &'p [f64];

    /// Returns the change of the residuals by each unknown.
    ///
    /// # Errors
    /// Returns an error if a point next to it cannot be computed.
    fn slopes(&self, at: &Self::Point, progress: Progress) -> Result<Vec<Vec<f64>>, Self::Error>;

    /// Returns the point with these unknowns, near `from`.
    ///
    /// # Errors
    /// Returns an error if it cannot be computed.
    fn moved(&self, from: &Self::Point, unknowns: &[f64]) -> Result<Self::Point, Self::Error>;

    /// Returns the bounds of an unknown.
    fn bounds(&self, _unknown: usize) -> Bounds {
        OPEN
    }

    /// Returns the longest step of an unknown. A longer one is shortened with those of the other unknowns.
    fn longest_step(&self, unknown: usize) -> f64;

    /// Returns true where the slopes of a point are good enough to be updated from step to step: exact ones of a smooth function.
    fn updates_slopes(&self) -> bool {
        true
    }

    /// Returns how many dampings a step tries at most: few where a point is expensive.
    fn dampings(&self) -> usize {
        DAMPINGS
    }

    /// Returns what is known of the unknowns besides the residuals, as a sum of squares.
    fn prior_square(&self, _at: &Self::Point) -> f64 {
        0.0
    }

    /// Adds the same to the normal equations, and what holds unknowns that the residuals do not determine.
    fn add_prior(&self, _at: &Self::Point, _normal: &mut DMatrix<f64>, _gradient: &mut DVector<f64>) {}

    /// Returns the fall of the sum of squares in a step below which the search ends.
    fn least_fall(&self, at: &Self::Point) -> f64;

    /// Returns false where the search has to end before an iteration.
    fn may_continue(&self, _progress: Progress) -> bool {
        true
    }
}

/// State of a search before an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Iterations so far.
    pub iterations: usize,
    /// Sum of squares.
    pub square: f64,
    /// Fall in the last iteration; 0 where its step was rejected, or was small by updated slopes.
    pub fall: f64,
}

/// End of a search.
#[derive(Debug)]
pub struct Minimum<P> {
    /// The point.
    pub point: P,
    /// Inverse of the normal matrix of the last step.
    pub covariance: DMatrix<f64>,
    /// Iterations of the search.
    pub iterations: usize,
    /// Relative fall of the sum of squares in the last iteration where the search ended before a minimum; `None` where it ended at one.
    pub still_falls: Option<f64>,
}

/// Searches the minimum of the sum of squares from `start` in at most `most` iterations.
///
/// The slopes are evaluated at the start and wherever the step by updated ones reduces little: the search ends where that is so for slopes that
/// are evaluated.
///
/// # Errors
/// Returns an error of the slopes at an accepted point. A point that cannot be computed is rejected, and a shorter step is tried.
pub fn minimise<P: Problem>(problem: &P, start: P::Point, most: usize) -> Result<Minimum<P::Point>, P::Error> {
    let sum_of_squares = |at: &P::Point| {
        let residuals = problem.residuals(at);
        dot(residuals, residuals) + problem.prior_square(at)
    };
    let mut now = start;
    let mut progress = Progress { iterations: 0, square: sum_of_squares(&now), fall: 0.0 };
    let (mut slopes, mut is_exact) = (vec![], true);
    let (mut system, mut still_falls) = (None, None);
    let mut damping = DAMPING[0];
    while progress.iterations < most && problem.may_continue(progress) {
        if is_exact {
            slopes = problem.slopes(&now, progress)?;
        }
        progress.iterations += 1;
        let equations = system.insert(NormalEquations::new(problem, &now, &slopes));
        let mut next = None;
        for _ in 0..if is_exact { problem.dampings() } else { 1 } {
            let Some(to) = equations.step(problem, &now, damping) else { break };
            let tried = problem.moved(&now, &to).ok().map(|point| (sum_of_squares(&point), point));
            next = tried.filter(|(square, _)| *square < progress.square);
            if next.is_some() {
                damping = (damping * 0.1).max(DAMPING[1]);
                break;
            }
            if is_exact {
                damping = (damping * 10.0).max(1e3 * DAMPING[1]);
            }
        }
        (still_falls, progress.fall) = (None, 0.0);
        if let Some((square, point)) = next {
            progress.fall = progress.square - square;
            still_falls = Some(progress.fall / progress.square);
            if problem.updates_slopes() {
                equations.update(problem, &mut slopes, [&now, &point]);
            }
            (now, progress.square) = (point, square);
        }
        let is_large = progress.fall > 0.0 && progress.fall >= problem.least_fall(&now);
        if is_exact && !is_large {
            still_falls = None;
            break;
        }
        // A step with updated slopes may be short far from the minimum.
        if !is_large {
            progress.fall = 0.0;
        }
        is_exact = !(is_large && problem.updates_slopes());
    }
    let count = problem.unknowns(&now).len();
    let covariance = system.map_or_else(|| DMatrix::zeros(count, count), |system| system.inverse());
    Ok(Minimum { point: now, covariance, iterations: progress.iterations, still_falls })
}

/// Normal equations of a step, scaled to a unit diagonal.
struct NormalEquations {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    scale: Vec<f64>,
}

impl NormalEquations {
    fn new<P: Problem>(problem: &P, at: &P::Point, slopes: &[Vec<f64>]) -> Self {
        let n = slopes.len();
        let mut normal = DMatrix::from_fn(n, n, |i, j| if i <= j { dot(&slopes[i], &slopes[j]) } else { 0.0 });
        normal.fill_lower_triangle_with_upper_triangle();
        let residuals = problem.residuals(at);
        let mut gradient = DVector::from_fn(n, |i, _| dot(&slopes[i], residuals));
        problem.add_prior(at, &mut normal, &mut gradient);
        let scale: Vec<f64> = (0..n).map(|i| normal[(i, i)].max(1e-300).sqrt()).collect();
        let matrix = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        Self { matrix, gradient: DVector::from_fn(n, |i, _| gradient[i] / scale[i]), scale }
    }

    /// Returns the inverse of the normal matrix in the units of the unknowns.
    fn inverse(&self) -> DMatrix<f64> {
        let n = self.scale.len();
        let inverse = self.matrix.clone().try_inverse().filter(|inverse| inverse.iter().all(|x| x.is_finite()));
        let inverse = inverse.unwrap_or_else(|| DMatrix::identity(n, n));
        DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (self.scale[i] * self.scale[j]))
    }

    /// Returns the unknowns after a damped step of bounded length; `None` if the equations have no finite solution. An unknown at a bound
    /// that the step would cross is fixed there while the others move.
    fn step<P: Problem>(&self, problem: &P, from: &P::Point, damping: f64) -> Option<Vec<f64>> {
        let mut x = problem.unknowns(from);
        // A step goes against the gradient.
        let is_held = |i: usize| {
            let [low, high] = problem.bounds(i);
            (x[i] <= low && self.gradient[i] > 0.0) || (x[i] >= high && self.gradient[i] < 0.0)
        };
        let free: Vec<usize> = (0..x.len()).filter(|&i| !is_held(i)).collect();
        let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            self.matrix[(free[i], free[j])] + if i == j { damping } else { 0.0 }
        });
        let downhill = DVector::from_fn(free.len(), |i, _| self.gradient[free[i]]);
        let step =
            matrix.lu().solve(&downhill).filter(|step| !step.is_empty() && step.iter().all(|x| x.is_finite()))?;
        let lengths: Vec<(usize, f64)> =
            free.iter().zip(step.iter()).map(|(&i, step)| (i, step / self.scale[i])).collect();
        let excess = lengths.iter().map(|(i, length)| length.abs() / problem.longest_step(*i)).fold(1.0, f64::max);
        for (i, length) in lengths {
            let [low, high] = problem.bounds(i);
            x[i] = (x[i] - length / excess).clamp(low, high);
        }
        Some(x)
    }

    /// Corrects the slopes from a step by Broyden's update, in unknowns scaled to equal slopes. It replaces an evaluation of a point
    /// for each unknown.
    fn update<P: Problem>(&self, problem: &P, slopes: &mut [Vec<f64>], [before, after]: [&P::Point; 2]) {
        let [from, to] = [before, after].map(|point| problem.unknowns(point));
        let step: Vec<f64> = from.iter().zip(&to).map(|(from, to)| to - from).collect();
        let square: f64 = step.iter().zip(&self.scale).map(|(x, scale)| (scale * x).powi(2)).sum();
        if square <= 0.0 {
            return;
        }
        let residuals = problem.residuals(after).iter().zip(problem.residuals(before));
        let mut error: Vec<f64> = residuals.map(|(after, before)| after - before).collect();
        for (slope, x) in slopes.iter().zip(&step) {
            error.iter_mut().zip(slope).for_each(|(error, slope)| *error -= slope * x);
        }
        for ((slope, x), scale) in slopes.iter_mut().zip(&step).zip(&self.scale) {
            let share = scale * scale * x / square;
            slope.iter_mut().zip(&error).for_each(|(slope, error)| *slope += share * error);
        }
    }
}

/// Returns the scalar product of two series of equal length.
#[inline]
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight independent sums allow vectorisation.
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 8];
    for (a, b) in a8.zip(b8) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Limits of a search.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Bounds of each unknown.
    pub bounds: Vec<Bounds>,
    /// Longest step of an unknown, in units of its scale.
    pub longest_step: f64,
    /// Largest number of iterations.
    pub iterations: usize,
    /// Fall of the sum of squares in a step below which the search ends, for residuals in units of their noise: a fall of 1 is one standard
    /// deviation. Where more than noise is left, a fall by a small share of the excess ends the search as well.
    pub least_fall: f64,
}

impl Limits {
    /// Creates infinite limits for `count` unknowns.
    #[must_use]
    pub fn none(count: usize, least_fall: f64) -> Self {
        Self { bounds: vec![OPEN; count], longest_step: f64::INFINITY, iterations: ITERATIONS, least_fall }
    }
}

/// Residuals as a function of the unknowns, in units of their scales.
pub type Residuals<'a, E> = &'a (dyn Fn(&[f64]) -> Result<Vec<f64>, E> + Sync);

/// Unknowns with their residuals.
#[derive(Debug)]
pub struct Evaluated {
    /// Unknowns, in units of their scale.
    pub x: Vec<f64>,
    /// Residuals.
    pub residuals: Vec<f64>,
}

/// Residuals of a function, whose slopes are one-sided differences.
struct OfFunction<'a, E> {
    residuals: Residuals<'a, E>,
    limits: &'a Limits,
    progress: &'a dyn Fn(usize),
}

impl<E: Send> Problem for OfFunction<'_, E> {
    type Point = Evaluated;
    type Error = E;

    fn unknowns(&self, at: &Evaluated) -> Vec<f64> {
        at.x.clone()
    }

    fn residuals<'p>(&self, at: &'p Evaluated) -> &'p [f64] {
        &at.residuals
    }

    /// One-sided differences far from the minimum, central ones near it, where a flat valley is not followed otherwise.
    fn slopes(&self, at: &Evaluated, Progress { iterations, square, fall }: Progress) -> Result<Vec<Vec<f64>>, E> {
        let is_near = iterations > 0 && fall < NEAR * square;
        let here = Some(at.residuals.as_slice()).filter(|_| !is_near);
        slopes(&at.x, here, &self.limits.bounds, self.residuals)
    }

    fn moved(&self, _: &Evaluated, unknowns: &[f64]) -> Result<Evaluated, E> {
        Ok(Evaluated { x: unknowns.to_vec(), residuals: (self.residuals)(unknowns)? })
    }

    fn bounds(&self, unknown: usize) -> Bounds {
        self.limits.bounds[unknown]
    }

    fn longest_step(&self, _: usize) -> f64 {
        self.limits.longest_step
    }

    fn updates_slopes(&self) -> bool {
        false
    }

    fn least_fall(&self, at: &Evaluated) -> f64 {
        let excess = dot(&at.residuals, &at.residuals) - at.residuals.len() as f64;
        self.limits.least_fall + LEAST_SHARE * excess.max(0.0)
    }

    fn may_continue(&self, progress: Progress) -> bool {
        (self.progress)(progress.iterations);
        true
    }
}

/// Minimises the sum of squares of a function from `start`, with `residuals` evaluated only within `limits`; calls `progress` with the
/// number of iterations before each of them.
///
/// # Errors
/// Returns an error of `residuals` at the start or next to an accepted point.
pub fn solve<E: Send>(
    start: &[f64],
    limits: &Limits,
    residuals: Residuals<E>,
    progress: &dyn Fn(usize),
) -> Result<Minimum<Evaluated>, E> {
    let x: Vec<f64> = start.iter().zip(&limits.bounds).map(|(x, [low, high])| x.clamp(*low, *high)).collect();
    let start = Evaluated { residuals: residuals(&x)?, x };
    minimise(&OfFunction { residuals, limits, progress }, start, limits.iterations)
}

/// Computes the Jacobian by central differences, one-sided at a bound: twice as expensive as the slopes of a search and more exact.
///
/// # Errors
/// Returns an error of `residuals`.
pub fn jacobian<E: Send>(x: &[f64], bounds: &[Bounds], residuals: Residuals<E>) -> Result<DMatrix<f64>, E> {
    let columns = slopes(x, None, bounds, residuals)?;
    let rows = columns.first().map_or(0, Vec::len);
    Ok(DMatrix::from_fn(rows, x.len(), |i, j| columns[j][i]))
}

/// Computes the change of the residuals by each unknown, the unknowns in parallel: by one-sided differences from the residuals `here`, or
/// by central ones, one-sided at a bound.
fn slopes<E: Send>(
    x: &[f64],
    here: Option<&[f64]>,
    bounds: &[Bounds],
    residuals: Residuals<E>,
) -> Result<Vec<Vec<f64>>, E> {
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
            Some(here) if above > x[i] => quotients(&at(above)?, here, above - x[i]),
            Some(here) => quotients(here, &at(below)?, x[i] - below),
            None => quotients(&at(above)?, &at(below)?, above - below),
        })
    };
    let unknowns: Vec<usize> = (0..x.len()).collect();
    parallel::map(&unknowns, |i| column(*i)).into_iter().collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn solved(start: &[f64], bounds: &[Bounds], residuals: Residuals<std::io::Error>) -> Evaluated {
        let limits = Limits { bounds: bounds.to_vec(), longest_step: 10.0, ..Limits::none(start.len(), 1e-20) };
        solve(start, &limits, residuals, &|_| {}).unwrap().point
    }

    #[test]
    fn the_least_squares_of_a_line() {
        let line = |x: &[f64]| Ok((0..5).map(|i| x[0] + f64::from(i) * x[1] - (2.0 + 3.0 * f64::from(i))).collect());
        let found = solved(&[0.0, 0.0], &[OPEN; 2], &line);
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
            let found = solved(&[start, 0.0], &[[0.0, 5.0], OPEN], &residuals);
            assert!(found.x[0].abs() < 1e-9 && (found.x[1] - 2.0).abs() < 1e-6, "{start}: {:?}", found.x);
        }
    }

    /// The search leaves a bound at which it starts.
    #[test]
    fn a_start_at_a_bound() {
        let residuals = |x: &[f64]| Ok(vec![x[0] - 1.0]);
        for start in [0.0, 9.0] {
            let found = solved(&[start], &[[0.0, 9.0]], &residuals);
            assert!((found.x[0] - 1.0).abs() < 1e-6, "{start}: {:?}", found.x);
        }
    }

    /// A search whose minimum is at infinity ends at its largest number of iterations.
    #[test]
    fn a_search_without_a_minimum_ends() {
        let limits = Limits { longest_step: 1.0, iterations: 7, ..Limits::none(1, 1e-12) };
        let residuals = |x: &[f64]| Ok::<_, std::io::Error>(vec![(-x[0]).exp()]);
        let count = std::cell::Cell::new(0);
        let found = solve(&[0.0], &limits, &residuals, &|_| count.set(count.get() + 1)).unwrap();
        assert_eq!((found.iterations, count.get()), (7, 7));
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
        let found = solved(&[0.5], &[OPEN], &residuals);
        assert!((found.x[0] - 2.0).abs() < 1e-5, "{:?}", found.x);
    }

    /// A point on a circle about (1, 2), measured from three places, with analytic slopes that are counted.
    struct Distances {
        evaluated: std::cell::Cell<usize>,
        may_continue: bool,
    }

    const PLACES: [[f64; 2]; 3] = [[0.0, 0.0], [4.0, 0.0], [0.0, 5.0]];
    const TRUTH: [f64; 2] = [1.0, 2.0];

    impl Problem for Distances {
        type Point = Evaluated;
        type Error = std::io::Error;

        fn unknowns(&self, at: &Evaluated) -> Vec<f64> {
            at.x.clone()
        }

        fn residuals<'p>(&self, at: &'p Evaluated) -> &'p [f64] {
            &at.residuals
        }

        fn slopes(&self, at: &Evaluated, _: Progress) -> std::io::Result<Vec<Vec<f64>>> {
            self.evaluated.set(self.evaluated.get() + 1);
            let along = |i: usize| PLACES.map(|p| (at.x[i] - p[i]) / (at.x[0] - p[0]).hypot(at.x[1] - p[1])).to_vec();
            Ok(vec![along(0), along(1)])
        }

        fn moved(&self, _: &Evaluated, x: &[f64]) -> std::io::Result<Evaluated> {
            let distance = |of: &[f64], p: [f64; 2]| (of[0] - p[0]).hypot(of[1] - p[1]);
            Ok(Evaluated { residuals: PLACES.map(|p| distance(x, p) - distance(&TRUTH, p)).to_vec(), x: x.to_vec() })
        }

        fn longest_step(&self, unknown: usize) -> f64 {
            [f64::INFINITY, 0.5][unknown]
        }

        fn least_fall(&self, _: &Evaluated) -> f64 {
            1e-16
        }

        fn may_continue(&self, progress: Progress) -> bool {
            self.may_continue || progress.iterations == 0
        }
    }

    fn located(may_continue: bool) -> (Minimum<Evaluated>, usize) {
        let problem = Distances { evaluated: std::cell::Cell::new(0), may_continue };
        let start = problem.moved(&Evaluated { x: vec![], residuals: vec![] }, &[3.0, 4.0]).unwrap();
        let found = minimise(&problem, start, 40).unwrap();
        (found, problem.evaluated.get())
    }

    /// Updated slopes lead to the minimum with few evaluations; the covariance is the inverse of the normal matrix there.
    #[test]
    fn updated_slopes_lead_to_the_minimum() {
        let (found, evaluated) = located(true);
        assert!(found.point.x.iter().zip(TRUTH).all(|(x, truth)| (x - truth).abs() < 1e-7), "{:?}", found.point.x);
        assert!(found.still_falls.is_none() && evaluated < found.iterations, "{evaluated} of {}", found.iterations);
        let units = PLACES.map(|p| [0, 1].map(|i| (TRUTH[i] - p[i]) / (TRUTH[0] - p[0]).hypot(TRUTH[1] - p[1])));
        let normal = DMatrix::from_fn(2, 2, |i, j| units.iter().map(|unit| unit[i] * unit[j]).sum::<f64>());
        let error = (normal.try_inverse().unwrap() - &found.covariance).amax();
        assert!(error < 1e-3 * found.covariance.amax(), "{error}");
    }

    /// The first step is no longer than allowed, and the problem ends the search after it.
    #[test]
    fn a_problem_ends_its_search() {
        let (found, evaluated) = located(false);
        assert_eq!((found.iterations, evaluated), (1, 1));
        assert!((found.point.x[1] - 4.0).abs() <= 0.5 + 1e-12 && found.still_falls.is_some(), "{:?}", found.point.x);
    }
}
