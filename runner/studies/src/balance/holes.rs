//! Holes of the correction planes and the masses in them: any masses, within a limit, or weights of a stock.

use super::table::C;
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
    /// How many there are for all planes that take it; `None` for any number.
    pub count: Option<usize>,
}

/// Circle of holes of a plane, evenly spread.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HoleCircle {
    /// Number of holes.
    pub count: usize,
    /// Radius of the circle, m.
    pub radius: f64,
    /// Angle of the first hole, rad.
    pub first: f64,
    /// Largest mass of a hole, kg; `None` without a limit.
    pub limit: Option<f64>,
    /// Holes that take no mass, from 0.
    pub taken: Vec<usize>,
    /// Kinds of weights of the stock that fit these holes, from 0.
    pub weights: Vec<usize>,
}

/// Holes and weights of the planes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Holes {
    /// Holes of each plane.
    pub circles: Vec<HoleCircle>,
    /// Weights in stock, one for a hole; any mass where it is empty.
    pub stock: Vec<Weight>,
    /// Most weights of the stock in a plane.
    pub most: usize,
}

/// A mass in a hole.
#[derive(Debug, Clone, Serialize)]
pub struct HoleMass {
    /// Hole, from 1 at the first angle.
    pub hole: usize,
    /// Its angle, degrees.
    pub angle_deg: f64,
    /// Mass, g.
    pub mass_g: f64,
}

/// Circle of holes in a result.
#[derive(Debug, Clone, Serialize)]
pub struct PlaneHoles {
    /// Number of holes, evenly spread.
    pub number: usize,
    /// Radius of the circle, mm.
    pub radius_mm: f64,
    /// Angle of hole 1, degrees.
    pub first_deg: f64,
    /// Holes that take no mass, from 1.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub taken: Vec<usize>,
}

impl From<&HoleCircle> for PlaneHoles {
    fn from(of: &HoleCircle) -> Self {
        // As it was written.
        let rounded = |x: f64| (1e9 * x).round() / 1e9;
        Self {
            number: of.count,
            radius_mm: rounded(1e3 * of.radius),
            first_deg: rounded(of.first.to_degrees()),
            taken: of.taken.iter().map(|hole| hole + 1).collect(),
        }
    }
}

impl HoleCircle {
    fn angle(&self, hole: usize) -> f64 {
        self.first + TAU * hole as f64 / self.count as f64
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
    pub(super) fn room(&self, hole: usize) -> f64 {
        if self.taken.contains(&hole) { 0.0 } else { self.limit.unwrap_or(f64::INFINITY) }
    }

    /// Returns the masses (kg) in the holes by their holes.
    fn named(&self, masses: &[f64]) -> Vec<HoleMass> {
        let one = |(hole, mass): (usize, &f64)| HoleMass {
            hole: hole + 1,
            angle_deg: self.angle(hole).to_degrees().rem_euclid(360.0),
            mass_g: 1e3 * mass,
        };
        masses.iter().enumerate().filter(|(_, mass)| **mass > LEAST_MASS).map(one).collect()
    }

    /// Fills the holes beside the direction of a moment that have room, pair by pair, until nothing is left or no hole has room.
    pub(super) fn fill(&self, moment: C) -> Vec<f64> {
        let mut masses = vec![0.0; self.count];
        let mut left = moment;
        // Each round fills a hole or ends.
        for _ in 0..=self.count {
            let turns = (left.arg() - self.first).rem_euclid(TAU) / TAU * self.count as f64;
            let has_room = |hole: usize| masses[hole] < self.room(hole);
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
                let put = mass.clamp(0.0, self.room(hole) - masses[hole]);
                masses[hole] += put;
                left -= unit * put;
            }
        }
        masses
    }
}

impl Holes {
    /// Returns the moments of the masses (kg) in the holes of each plane, g mm.
    pub(super) fn moments(&self, masses: &[Vec<f64>]) -> Vec<C> {
        self.circles.iter().zip(masses).map(|(circle, masses)| circle.moment(masses)).collect()
    }

    /// Returns the masses (kg) in the holes of each plane by their holes.
    pub(super) fn named(&self, masses: &[Vec<f64>]) -> Vec<Vec<HoleMass>> {
        self.circles.iter().zip(masses).map(|(circle, masses)| circle.named(masses)).collect()
    }

    /// Returns the masses (kg) in the holes of each plane that come nearest to moments (g mm): two beside each moment, and further ones where
    /// those are full. Where that does not reach the moments, all holes of all planes are changed until the squares are least, a convex
    /// problem.
    pub(super) fn filled(&self, wanted: &[C], metric: &DMatrix<C>) -> Vec<Vec<f64>> {
        let fill = |(circle, moment): (&HoleCircle, &C)| circle.fill(*moment);
        let mut masses: Vec<Vec<f64>> = self.circles.iter().zip(wanted).map(fill).collect();
        let squares = |errors: &[C]| squares(metric, errors);
        let mut errors: Vec<C> = self.moments(&masses).iter().zip(wanted).map(|(moment, u)| moment - u).collect();
        let mut left = squares(&errors);
        let enough = REACHED * squares(wanted);
        for _ in 0..ROUNDS.0 {
            if left <= enough {
                break;
            }
            for (plane, circle) in self.circles.iter().enumerate() {
                let curvature = metric[(plane, plane)].re;
                for (hole, mass) in masses[plane].iter_mut().enumerate() {
                    let unit = circle.unit(hole);
                    let row: C = (0..wanted.len()).map(|k| metric[(plane, k)] * errors[k]).sum();
                    let slope = (unit.conj() * row).re / (curvature * unit.norm_sqr()).max(f64::MIN_POSITIVE);
                    let next = (*mass - slope).clamp(0.0, circle.room(hole));
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
}
