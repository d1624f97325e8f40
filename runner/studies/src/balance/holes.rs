//! Holes of the correction planes and the masses in them: any masses, within a limit, or weights of a stock.

use super::plane::MassesError;
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

/// Returns the squares that a departure adds.
pub(super) fn squares(metric: &DMatrix<C>, errors: &[C]) -> f64 {
    let row = |i: usize| errors.iter().enumerate().map(|(j, e)| metric[(i, j)] * e).sum::<C>();
    errors.iter().enumerate().map(|(i, e)| (e.conj() * row(i)).re).sum()
}

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
    pub(super) fn moment(&self, masses: &[f64]) -> C {
        masses.iter().enumerate().map(|(hole, mass)| self.unit(hole) * *mass).sum()
    }

    /// Returns the mass (kg) that a hole may have.
    pub(super) fn room(&self, plane: usize, hole: usize) -> f64 {
        if self.taken.contains(&[plane, hole]) { 0.0 } else { self.limit.unwrap_or(f64::INFINITY) }
    }

    /// Returns the masses (kg) in the holes of each plane by their holes.
    pub(super) fn named(&self, masses: &[Vec<f64>]) -> Vec<Vec<HoleMass>> {
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
    pub(super) fn filled(&self, wanted: &[C], metric: &DMatrix<C>) -> Vec<Vec<f64>> {
        let fill = |(plane, moment): (usize, &C)| self.fill(plane, *moment);
        let mut masses: Vec<Vec<f64>> = wanted.iter().enumerate().map(fill).collect();
        let squares = |errors: &[C]| squares(metric, errors);
        let mut errors: Vec<C> = masses.iter().zip(wanted).map(|(masses, u)| self.moment(masses) - u).collect();
        let mut left = squares(&errors);
        let enough = REACHED * squares(wanted);
        for _ in 0..ROUNDS.0 {
            if left <= enough {
                break;
            }
            for plane in 0..wanted.len() {
                let curvature = metric[(plane, plane)].re;
                for (hole, mass) in masses[plane].iter_mut().enumerate() {
                    let unit = self.unit(hole);
                    let row: C = (0..wanted.len()).map(|k| metric[(plane, k)] * errors[k]).sum();
                    let slope = (unit.conj() * row).re / (curvature * unit.norm_sqr()).max(f64::MIN_POSITIVE);
                    let next = (*mass - slope).clamp(0.0, self.room(plane, hole));
                    errors[plane] += unit * (next - *mass);
                    *mass = next;
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
    pub(super) fn fill(&self, plane: usize, moment: C) -> Vec<f64> {
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
