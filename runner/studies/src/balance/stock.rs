//! Weights of a stock in the holes of all planes: the choice that adds least to the vectors, by branch and bound.
//!
//! A departure `e` from the wanted moments adds the squares `e^H M e = |L^H e|^2` to the vectors, with the Cholesky factor `L` of `M`. The planes
//! are taken from the last to the first: that part of the sum which the chosen planes determine is a lower bound for all choices of the
//! others, and a branch ends where it is no less than the best sum that was found. The choices of a plane are sorted, so that those within
//! the radius that the bound leaves are found by bisection. Each weight has an error of its own, by which a choice of many or heavy
//! weights against each other counts more.
//!
//! Source: Fincke and Pohst, Mathematics of Computation 44 (1985) 463, for lattices.

use super::error::BalanceError;
use super::holes::{HoleCircle, Holes};
use super::moments::MASS_ERROR;
use super::table::C;
use nalgebra::DMatrix;
use serde::Serialize;

/// Most weights in a plane.
pub const MOST_WEIGHTS: usize = 4;
/// Most choices of a plane.
const MOST_CHOICES: usize = 1_000_000;
/// Choices that are compared before the search ends with the best one so far, and its bound.
const MOST_STEPS: usize = 50_000_000;

/// What a choice of weights of the stock leaves.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct StockChoice {
    /// Choices of the plane that has most.
    pub choices: usize,
    /// Vibration that the departure from the exact moments adds, rms of all vectors.
    pub added: f64,
    /// The least that any choice may add: `added` where the choice is proven to be the best.
    pub bound: f64,
}

/// Weights of a plane: hole and kind of each.
#[derive(Clone)]
struct Choice {
    moment: C,
    /// Square of the error of the weights, (g mm)^2.
    spread: f64,
    weights: [Option<(u32, u32)>; MOST_WEIGHTS],
}

/// Returns the number of choices of a plane with `holes` holes; `None` beyond the largest number.
fn number(holes: usize, kinds: usize, most: usize) -> Option<usize> {
    let mut sum = 1_usize;
    let mut of_count = 1_usize;
    for weights in 0..most.min(holes) {
        of_count = of_count.checked_mul(holes - weights)? / (weights + 1);
        sum = sum.checked_add(of_count.checked_mul(kinds.checked_pow(u32::try_from(weights + 1).ok()?)?)?)?;
    }
    Some(sum)
}

/// Returns all choices of a plane, by the real part of their moments.
fn choices(holes: &Holes, circle: &HoleCircle) -> Vec<Choice> {
    let empty = Choice { moment: C::new(0.0, 0.0), spread: 0.0, weights: [None; MOST_WEIGHTS] };
    let mut all = vec![empty];
    for hole in 0..circle.count {
        let (unit, room) = (circle.unit(hole), circle.room(hole));
        let fits = |kind: &usize| holes.stock[*kind].mass <= room;
        let fitting: Vec<usize> = circle.weights.iter().copied().filter(fits).collect();
        // With each choice of the holes before that has a weight less than the most.
        for i in 0..all.len() {
            let Some(place) = all[i].weights[..holes.most.min(MOST_WEIGHTS)].iter().position(Option::is_none) else {
                continue;
            };
            for &kind in &fitting {
                let mut next = all[i].clone();
                let moment = unit * holes.stock[kind].mass;
                next.moment += moment;
                next.spread += moment.norm_sqr() * MASS_ERROR * MASS_ERROR;
                next.weights[place] = Some((hole as u32, kind as u32));
                all.push(next);
            }
        }
    }
    all.sort_by(|a, b| a.moment.re.total_cmp(&b.moment.re));
    all
}

struct Search<'a> {
    wanted: &'a [C],
    metric: &'a DMatrix<C>,
    factor: DMatrix<C>,
    choices: Vec<Vec<Choice>>,
    /// Weights of each kind that are left.
    left: Vec<usize>,
    /// Choice of each plane on the branch, and its departure from the wanted moment.
    branch: Vec<usize>,
    errors: Vec<C>,
    best: (f64, Vec<usize>),
    /// Least bound of the branches that were not searched.
    open: f64,
    steps: usize,
}

impl Search<'_> {
    /// Searches the choices of the planes below `planes`; `sum` is the sum of the others.
    fn descend(&mut self, planes: usize, sum: f64) {
        let Some(plane) = planes.checked_sub(1) else {
            if sum < self.best.0 {
                self.best = (sum, self.branch.clone());
            }
            return;
        };
        let pivot = self.factor[(plane, plane)].re;
        let others: C = (planes..self.wanted.len()).map(|j| self.factor[(j, plane)].conj() * self.errors[j]).sum();
        let target = self.wanted[plane] - others / pivot;
        let (curvature, own) = (pivot * pivot, self.metric[(plane, plane)].re);
        let radius = ((self.best.0 - sum) / curvature).sqrt();
        let all = &self.choices[plane];
        let from = all.partition_point(|choice| choice.moment.re < target.re - radius);
        let to = all.partition_point(|choice| choice.moment.re <= target.re + radius);
        self.steps += to.saturating_sub(from);
        let cost = |choice: &Choice| sum + curvature * (choice.moment - target).norm_sqr() + own * choice.spread;
        let within = (from..to).map(|i| (cost(&all[i]), i)).filter(|(cost, _)| *cost < self.best.0);
        let mut within: Vec<(f64, usize)> = within.collect();
        within.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (cost, i) in within {
            if cost >= self.best.0 {
                return;
            }
            if self.steps > MOST_STEPS && self.best.0.is_finite() {
                self.open = self.open.min(cost);
                return;
            }
            if !self.takes(plane, i) {
                continue;
            }
            self.branch[plane] = i;
            self.errors[plane] = self.choices[plane][i].moment - self.wanted[plane];
            self.descend(plane, cost);
            self.give_back(plane, i);
        }
    }

    /// Takes the weights of a choice from the stock; false, with the stock as it was, where it has not enough.
    fn takes(&mut self, plane: usize, i: usize) -> bool {
        let mut left = self.left.clone();
        for (_, kind) in self.choices[plane][i].weights.iter().flatten() {
            let of_kind = &mut left[*kind as usize];
            let Some(fewer) = of_kind.checked_sub(1) else { return false };
            *of_kind = fewer;
        }
        self.left = left;
        true
    }

    fn give_back(&mut self, plane: usize, i: usize) {
        for (_, kind) in self.choices[plane][i].weights.iter().flatten() {
            self.left[*kind as usize] += 1;
        }
    }
}

/// Returns the masses (kg) in the holes of each plane that add least to the squares of `channels` vectors, and what they add.
///
/// # Errors
/// Returns an error if a plane has more choices than can be compared.
pub(super) fn nearest(
    holes: &Holes,
    wanted: &[C],
    metric: &DMatrix<C>,
    channels: usize,
) -> Result<(Vec<Vec<f64>>, StockChoice), BalanceError> {
    let number = |circle: &HoleCircle| {
        number(circle.count, circle.weights.len(), holes.most).filter(|number| *number <= MOST_CHOICES)
    };
    let compared = holes.circles.iter().map(number).collect::<Option<Vec<usize>>>();
    let Some(compared) = compared else { return Err(BalanceError::Choices { most: MOST_CHOICES }) };
    let factor = metric.clone().cholesky().ok_or(BalanceError::Dependent { speed: 0.0 })?.l();
    let planes = wanted.len();
    let mut search = Search {
        wanted,
        metric,
        factor,
        choices: holes.circles.iter().map(|circle| choices(holes, circle)).collect(),
        left: holes.stock.iter().map(|weight| weight.count.unwrap_or(usize::MAX / 2)).collect(),
        branch: vec![0; planes],
        errors: vec![C::new(0.0, 0.0); planes],
        best: (f64::INFINITY, vec![0; planes]),
        open: f64::INFINITY,
        steps: 0,
    };
    search.descend(planes, 0.0);
    let mut masses: Vec<Vec<f64>> = holes.circles.iter().map(|circle| vec![0.0; circle.count]).collect();
    for (plane, i) in search.best.1.iter().enumerate() {
        for (hole, kind) in search.choices[plane][*i].weights.iter().flatten() {
            masses[plane][*hole as usize] = holes.stock[*kind as usize].mass;
        }
    }
    let rms = |squares: f64| (squares / channels.max(1) as f64).sqrt();
    let bound = rms(search.best.0.min(search.open));
    let choices = compared.into_iter().max().unwrap_or_default();
    Ok((masses, StockChoice { choices, added: rms(search.best.0), bound }))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::holes::{Weight, squares};
    use super::*;

    /// Pseudorandom number in -1 to 1 (Park and Miller).
    fn random(state: &mut u64) -> f64 {
        *state = *state * 48_271 % 0x7fff_ffff;
        2.0 * *state as f64 / 2_147_483_647.0 - 1.0
    }

    /// Kind in each hole of a plane, 0 for none: every arrangement with at most `most` weights.
    fn arrangements(holes: &Holes, plane: usize) -> Vec<Vec<usize>> {
        let (states, circle) = (holes.stock.len() + 1, &holes.circles[plane]);
        let all = 0..states.pow(u32::try_from(circle.count).unwrap());
        let kinds = |n: usize| (0..circle.count).map(|hole| n / states.pow(hole as u32) % states).collect::<Vec<_>>();
        let is_allowed = |kinds: &Vec<usize>| {
            let fits = |(hole, kind): (usize, &usize)| {
                let has_room = || holes.stock[kind - 1].mass <= circle.limit.unwrap() && !circle.taken.contains(&hole);
                *kind == 0 || circle.weights.contains(&(kind - 1)) && has_room()
            };
            kinds.iter().filter(|kind| **kind > 0).count() <= holes.most && kinds.iter().enumerate().all(fits)
        };
        all.map(kinds).filter(is_allowed).collect()
    }

    /// Sum of a choice, or nothing where the stock does not suffice.
    fn sum(holes: &Holes, wanted: &[C], metric: &DMatrix<C>, chosen: [&Vec<usize>; 2]) -> Option<f64> {
        let (mut errors, mut spread) = (vec![], 0.0);
        for (plane, kinds) in chosen.iter().enumerate() {
            let mut moment = -wanted[plane];
            for (hole, kind) in kinds.iter().enumerate().filter(|(_, kind)| **kind > 0) {
                let one = holes.circles[plane].unit(hole) * holes.stock[kind - 1].mass;
                moment += one;
                spread += metric[(plane, plane)].re * (MASS_ERROR * one.norm()).powi(2);
            }
            errors.push(moment);
        }
        for (kind, weight) in holes.stock.iter().enumerate() {
            let used = chosen.iter().flat_map(|kinds| kinds.iter()).filter(|of| **of == kind + 1).count();
            if used > weight.count.unwrap_or(usize::MAX) {
                return None;
            }
        }
        Some(squares(metric, &errors) + spread)
    }

    /// The choice is that of an exhaustive search: planes that act alike and planes that do not, a stock that suffices and one that does not,
    /// full and taken holes, planes of the same holes and weights and of others.
    #[test]
    fn the_choice_is_the_best_of_all() {
        let mut state = 20_261_130;
        for case in 0..12 {
            let count = |n| if case % 2 == 0 { None } else { Some(n) };
            let stock = vec![
                Weight { mass: 0.4e-3, count: count(1) },
                Weight { mass: 0.9e-3, count: count(2) },
                Weight { mass: 5e-3, count: None },
            ];
            let circle = HoleCircle {
                count: 7,
                radius: 0.03,
                first: 0.0,
                limit: Some(2e-3),
                taken: vec![2],
                weights: vec![0, 1, 2],
            };
            // Another circle with other weights in half of the cases.
            let own = HoleCircle { count: 5, radius: 0.05, first: 0.3, weights: vec![0, 2], ..circle.clone() };
            let other = if case % 4 < 2 { own } else { HoleCircle { taken: vec![5], ..circle.clone() } };
            let holes = Holes { circles: vec![circle, other], stock, most: 1 + case % 3 };
            let wanted: Vec<C> = (0..2).map(|_| C::new(60.0 * random(&mut state), 60.0 * random(&mut state))).collect();
            // Coefficients of three channels; in every third case the second plane is nearly the first one.
            let mut matrix = DMatrix::from_fn(3, 2, |_, _| C::new(random(&mut state), random(&mut state)));
            if case % 3 == 0 {
                for channel in 0..3 {
                    let small = C::new(0.01 * random(&mut state), 0.01 * random(&mut state));
                    matrix[(channel, 1)] = matrix[(channel, 0)] * C::new(0.8, 0.1) + small;
                }
            }
            let metric = matrix.adjoint() * &matrix;
            let (masses, found) = nearest(&holes, &wanted, &metric, 1).unwrap();
            let [first, second] = [0, 1].map(|plane| arrangements(&holes, plane));
            let sums = first.iter().flat_map(|a| second.iter().map(move |b| [a, b]));
            let least = sums.filter_map(|chosen| sum(&holes, &wanted, &metric, chosen)).fold(f64::INFINITY, f64::min);
            assert!((found.added - least.sqrt()).abs() < 1e-9 * least.sqrt(), "{case}: {found:?}: {}", least.sqrt());
            assert!(found.bound <= found.added && found.bound > found.added * (1.0 - 1e-12), "{case}: {found:?}");
            // The masses that are returned are those of the sum.
            let kind =
                |mass: &f64| holes.stock.iter().position(|weight| weight.mass == *mass).map_or(0, |kind| kind + 1);
            let kinds: Vec<Vec<usize>> = masses.iter().map(|plane| plane.iter().map(kind).collect()).collect();
            let of_masses = sum(&holes, &wanted, &metric, [&kinds[0], &kinds[1]]).unwrap();
            assert!((of_masses - least).abs() < 1e-9 * least, "{case}: {masses:?}");
        }
    }

    #[test]
    fn number_of_choices() {
        assert_eq!(number(16, 4, 2), Some(1 + 16 * 4 + 120 * 16));
        assert_eq!(number(3, 1, 4), Some(8));
        assert_eq!(number(usize::MAX, 2, 2), None);
        let circle = HoleCircle { count: 60, radius: 0.03, weights: (0..40).collect(), ..HoleCircle::default() };
        let holes = Holes { circles: vec![circle], stock: vec![Weight { mass: 1e-3, count: None }; 40], most: 3 };
        let error = nearest(&holes, &[C::new(1.0, 0.0)], &DMatrix::identity(1, 1), 1).err().unwrap().to_string();
        assert!(error.contains("more than 1000000 choices"), "{error}");
    }
}
