//! Holes of the correction planes and the masses in them: any masses, within a limit, or weights of a stock.

use super::error::BalanceError;
use super::plane::MassesError;
use super::stock::{self, StockChoice};
use super::table::C;
use ballrace_scene::units::{Dimension, parse};
use nalgebra::DMatrix;
use serde::Serialize;
use std::f64::consts::TAU;

/// Units of a moment in g mm: kg m.
const G_MM: f64 = 1e-6;
/// Mass below which a hole stays empty, kg.
const LEAST_MASS: f64 = 1e-9;
/// Rounds of the descent over all holes, and the share of the squares by which a round has to lower them.
const ROUNDS: (usize, f64) = (5000, 1e-12);
/// Share of the squares without a mass below which masses are those that are wanted.
const REACHED: f64 = 1e-18;

/// A kind of weight in stock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// Mass, kg.
    pub mass: f64,
    /// How many there are for all planes together; `None` for any number.
    pub count: Option<usize>,
}

impl Weight {
    /// Reads a weight such as `0.8 g`, or `3 x 0.8 g` of which there are three.
    ///
    /// # Errors
    /// Returns what is expected of another text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (count, mass) = text.split_once(" x ").map_or((None, text), |(count, mass)| (Some(count), mass));
        let is_number = |count: &usize| *count > 0;
        let count = count.map(|count| count.trim().parse().ok().filter(is_number)).map_or(Ok(None), |count| {
            count.map(Some).ok_or_else(|| "expected a number of weights above 0, such as \"3 x 0.8 g\"".to_owned())
        })?;
        let mass = parse(mass.trim(), Dimension::Mass).ok().filter(|mass| *mass > 0.0);
        let expected =
            || format!("expected {}, or with a number as \"3 x 0.8 g\"", Dimension::Mass.expected("above 0"));
        Ok(Self { mass: mass.ok_or_else(expected)?, count })
    }
}

/// Holes and weights of the planes.
#[derive(Debug, Clone)]
pub struct Holes {
    /// Number of holes of each plane, the first at angle 0, evenly spread.
    pub count: usize,
    /// Radius of their circle, m.
    pub radius: f64,
    /// Weights in stock, one for a hole; any mass where it is empty.
    pub stock: Vec<Weight>,
    /// Most weights of the stock in a plane.
    pub most: usize,
    /// Largest mass of a hole, kg; `None` without a limit.
    pub limit: Option<f64>,
    /// Holes that take no mass: plane and hole, both from 0.
    pub taken: Vec<[usize; 2]>,
}

/// How masses are placed.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    /// Holes of each plane; `None` for masses at any angle.
    pub holes: Option<Holes>,
    /// Masses are removed, as by drilling, opposite to those that would be added.
    pub removes: bool,
    /// The masses that are mounted are taken off first.
    pub replaces: bool,
}

/// A mass in a hole.
#[derive(Debug, Clone, Serialize)]
pub struct HoleMass {
    /// Hole, from 1 at angle 0.
    pub hole: usize,
    /// Its angle, degrees.
    pub angle_deg: f64,
    /// Mass, g.
    pub mass_g: f64,
}

/// Masses in the holes of each plane.
pub(super) struct Placed {
    /// Masses of each plane; none without holes.
    pub(super) masses: Vec<Vec<HoleMass>>,
    /// Moments that act with them, g mm.
    pub(super) moments: Vec<C>,
    /// What a choice of weights of the stock leaves.
    pub(super) choice: Option<StockChoice>,
}

impl Placement {
    /// Returns the masses that come nearest to the wanted moments (g mm) in the squares of `channels` vectors: a departure `e` adds `e^H M e` with
    /// the metric `M`.
    ///
    /// # Errors
    /// Returns an error if the stock has more choices than can be compared.
    pub(super) fn place(&self, wanted: &[C], metric: &DMatrix<C>, channels: usize) -> Result<Placed, BalanceError> {
        let Some(holes) = &self.holes else {
            return Ok(Placed { masses: vec![vec![]; wanted.len()], moments: wanted.to_vec(), choice: None });
        };
        let sign = if self.removes { -1.0 } else { 1.0 };
        let turned: Vec<C> = wanted.iter().map(|moment| moment * sign).collect();
        let (masses, choice) = if holes.stock.is_empty() {
            (holes.filled(&turned, metric), None)
        } else {
            let (masses, choice) = stock::nearest(holes, &turned, metric, channels)?;
            (masses, Some(choice))
        };
        let moment = |masses: &Vec<f64>| holes.moment(masses) * sign;
        Ok(Placed { moments: masses.iter().map(moment).collect(), masses: holes.named(&masses), choice })
    }
}

impl Holes {
    /// Reads a hole of a plane such as `fan 3` among `count` holes of each plane: plane and hole from 0.
    ///
    /// # Errors
    /// Returns an error for an unknown plane and a hole that is not there.
    pub fn hole(planes: &[String], count: usize, text: &str) -> Result<[usize; 2], MassesError> {
        let found = || {
            let (plane, hole) = text.trim().rsplit_once(' ')?;
            let plane = planes.iter().position(|name| name == plane.trim())?;
            let hole = hole.parse().ok().filter(|hole| (1..=count).contains(hole))?;
            Some([plane, hole - 1])
        };
        let example = planes.first().map_or("DE", String::as_str);
        found().ok_or_else(|| MassesError {
            found: format!("unknown hole: {text:?}"),
            expected: format!("a plane ({}) and a hole from 1 to {count}, such as \"{example} 3\"", planes.join(", ")),
        })
    }

    fn angle(&self, hole: usize) -> f64 {
        TAU * hole as f64 / self.count as f64
    }

    /// Returns the moment of 1 kg in a hole, g mm.
    pub(super) fn unit(&self, hole: usize) -> C {
        C::from_polar(self.radius / G_MM, self.angle(hole))
    }

    /// Returns the moment of the masses (kg) in the holes of a plane, g mm.
    fn moment(&self, masses: &[f64]) -> C {
        masses.iter().enumerate().map(|(hole, mass)| self.unit(hole) * *mass).sum()
    }

    /// Returns the mass (kg) that a hole may have.
    pub(super) fn room(&self, plane: usize, hole: usize) -> f64 {
        if self.taken.contains(&[plane, hole]) { 0.0 } else { self.limit.unwrap_or(f64::INFINITY) }
    }

    /// Returns the masses (kg) in the holes of each plane by their holes.
    fn named(&self, masses: &[Vec<f64>]) -> Vec<Vec<HoleMass>> {
        let one = |(hole, mass): (usize, &f64)| HoleMass {
            hole: hole + 1,
            angle_deg: self.angle(hole).to_degrees(),
            mass_g: 1e3 * mass,
        };
        let of_plane = |masses: &Vec<f64>| {
            masses.iter().enumerate().filter(|(_, mass)| **mass > LEAST_MASS).map(one).collect::<Vec<_>>()
        };
        masses.iter().map(of_plane).collect()
    }

    /// Returns the masses (kg) in the holes of each plane that come nearest to moments (g mm): two beside each moment, and further ones where
    /// those are full. Where that does not reach the moments, all holes of all planes are changed until the squares are least, a convex
    /// problem.
    fn filled(&self, wanted: &[C], metric: &DMatrix<C>) -> Vec<Vec<f64>> {
        let fill = |(plane, moment): (usize, &C)| self.fill(plane, *moment);
        let mut masses: Vec<Vec<f64>> = wanted.iter().enumerate().map(fill).collect();
        let squares = |errors: &[C]| stock::squares(metric, errors);
        let mut errors: Vec<C> = masses.iter().zip(wanted).map(|(masses, u)| self.moment(masses) - u).collect();
        let mut left = squares(&errors);
        let enough = REACHED * squares(wanted);
        for _ in 0..ROUNDS.0 {
            if left <= enough {
                break;
            }
            for plane in 0..wanted.len() {
                let curvature = metric[(plane, plane)].re;
                for hole in 0..self.count {
                    let unit = self.unit(hole);
                    let row: C = (0..wanted.len()).map(|k| metric[(plane, k)] * errors[k]).sum();
                    let slope = (unit.conj() * row).re / (curvature * unit.norm_sqr()).max(f64::MIN_POSITIVE);
                    let before = masses[plane][hole];
                    masses[plane][hole] = (before - slope).clamp(0.0, self.room(plane, hole));
                    errors[plane] += unit * (masses[plane][hole] - before);
                }
            }
            let before = std::mem::replace(&mut left, squares(&errors));
            if before - left <= ROUNDS.1 * before {
                break;
            }
        }
        masses
    }

    /// Fills the holes beside the direction of a moment that have room, pair by pair, until nothing is left or no hole has room.
    fn fill(&self, plane: usize, moment: C) -> Vec<f64> {
        let mut masses = vec![0.0; self.count];
        let mut left = moment;
        // Each round fills a hole or ends.
        for _ in 0..=self.count {
            let turns = left.arg().rem_euclid(TAU) / TAU * self.count as f64;
            let has_room = |hole: usize| masses[hole] < self.room(plane, hole);
            let below = (0..self.count).map(|step| (turns.floor() as usize + self.count - step) % self.count);
            let above = (0..self.count).map(|step| (turns.floor() as usize + 1 + step) % self.count);
            let pair = [below.into_iter().find(|hole| has_room(*hole)), above.into_iter().find(|hole| has_room(*hole))];
            let [Some(a), Some(b)] = pair else { break };
            // Holes half a turn or more apart hold no moment between them.
            let cross = |p: C, q: C| p.re * q.im - p.im * q.re;
            let (unit_a, unit_b) = (self.unit(a), self.unit(b));
            let area = cross(unit_a, unit_b);
            if left.norm() < f64::EPSILON * moment.norm() || area <= f64::EPSILON * unit_a.norm_sqr() {
                break;
            }
            // Cramer's rule for masses along two directions.
            for (hole, unit, mass) in [(a, unit_a, cross(left, unit_b) / area), (b, unit_b, cross(unit_a, left) / area)]
            {
                let put = mass.clamp(0.0, self.room(plane, hole) - masses[hole]);
                masses[hole] += put;
                left -= unit * put;
            }
        }
        masses
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn holes(limit: Option<f64>) -> Holes {
        Holes { count: 16, radius: 0.03, stock: vec![], most: 2, limit, taken: vec![] }
    }

    fn placed(holes: Holes, removes: bool, wanted: &[C], metric: &DMatrix<C>) -> Placed {
        Placement { holes: Some(holes), removes, replaces: false }.place(wanted, metric, 1).unwrap()
    }

    fn one() -> DMatrix<C> {
        DMatrix::identity(1, 1)
    }

    #[test]
    fn masses_in_two_holes_have_the_moment() {
        for angle in [0.0, 10.0, 22.5, 100.0, 359.0_f64] {
            let moment = C::from_polar(48.0, angle.to_radians());
            let found = placed(holes(None), false, &[moment], &one());
            assert!((found.moments[0] - moment).norm() < 1e-9, "{angle}: {:?}", found.masses);
            assert!(found.masses[0].len() <= 2, "{angle}: {:?}", found.masses);
        }
    }

    /// A moment of two full holes and more goes to those beside them; a hole that is taken stays empty.
    #[test]
    fn full_holes_pass_the_rest_to_their_neighbours() {
        let moment = C::from_polar(50.0, 1.0);
        let found = placed(holes(Some(0.5e-3)), false, &[moment], &one());
        assert!(found.masses[0].len() > 2 && (found.moments[0] - moment).norm() < 1e-6, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| mass.mass_g <= 0.5 + 1e-9), "{:?}", found.masses);
        let free = Holes { taken: vec![[0, 2], [1, 3]], ..holes(None) };
        let found = placed(free, false, &[moment], &one());
        assert!((found.moments[0] - moment).norm() < 1e-6, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| mass.hole != 3), "{:?}", found.masses);
    }

    /// Moments beyond the holes: no small change of one hole lowers the squares (the conditions of Karush, Kuhn and Tucker), and the other
    /// plane takes over what the full one cannot hold.
    #[test]
    fn full_planes_leave_the_least_squares() {
        let metric =
            DMatrix::from_row_slice(2, 2, &[C::new(2.0, 0.0), C::new(1.2, 0.9), C::new(1.2, -0.9), C::new(1.5, 0.0)]);
        let wanted = [C::from_polar(500.0, 1.0), C::from_polar(10.0, 4.0)];
        let of = holes(Some(0.5e-3));
        let masses = of.filled(&wanted, &metric);
        let squares = |masses: &[Vec<f64>]| {
            let errors: Vec<C> = masses.iter().zip(&wanted).map(|(masses, u)| of.moment(masses) - u).collect();
            stock::squares(&metric, &errors)
        };
        let least = squares(&masses);
        for plane in 0..2 {
            for hole in 0..of.count {
                for step in [-1e-6, 1e-6] {
                    let mut other = masses.clone();
                    other[plane][hole] = (other[plane][hole] + step).clamp(0.0, 0.5e-3);
                    assert!(squares(&other) >= least * (1.0 - 1e-9), "{plane} {hole} {step}");
                }
            }
        }
        let alone: Vec<Vec<f64>> = wanted.iter().enumerate().map(|(plane, u)| of.fill(plane, *u)).collect();
        assert!(least < 0.98 * squares(&alone), "{least}: {}", squares(&alone));
    }

    #[test]
    fn what_is_removed_acts_as_the_opposite() {
        let moment = C::from_polar(12.0, 0.3);
        let found = placed(Holes { count: 12, ..holes(None) }, true, &[moment], &one());
        assert!((found.moments[0] - moment).norm() < 1e-9, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| (180.0..=211.0).contains(&mass.angle_deg)), "{:?}", found.masses);
    }
}
