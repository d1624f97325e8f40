//! Correction masses: the moments that leave the least vibration, and the holes and weights that come nearest to them.

use super::table::C;
use super::vectors::Vectors;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::f64::consts::TAU;

/// Holes and weights of a plane.
#[derive(Debug, Clone)]
pub struct Holes {
    /// Number of holes, the first at angle 0, evenly spread.
    pub count: usize,
    /// Radius of their circle, m.
    pub radius: f64,
    /// Masses in stock, kg; any mass where it is empty.
    pub stock: Vec<f64>,
    /// Largest mass of a hole, kg; `None` without a limit.
    pub limit: Option<f64>,
}

/// How masses are placed.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    /// Holes of each plane; `None` for masses at any angle.
    pub holes: Option<Holes>,
    /// Masses are removed, as by drilling, opposite to those that would be added.
    pub removes: bool,
}

impl Placement {
    /// Returns the masses in holes that come nearest to a moment (g mm).
    fn nearest(&self, moment: C) -> Vec<HoleMass> {
        self.holes.as_ref().map_or_else(Vec::new, |holes| holes.nearest(moment * self.sign()))
    }

    /// Returns the moment that acts with these masses for a planned one, g mm.
    fn acting(&self, planned: C, masses: &[HoleMass]) -> C {
        let in_holes = |holes: &Holes| masses.iter().map(|mass| holes.moment(mass)).sum::<C>() * self.sign();
        self.holes.as_ref().map_or(planned, in_holes)
    }

    const fn sign(&self) -> f64 {
        if self.removes { -1.0 } else { 1.0 }
    }
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

/// Correction of one plane.
#[derive(Debug, Clone, Serialize)]
pub struct PlaneCorrection {
    /// Plane.
    pub plane: String,
    /// Moment to add, g mm.
    pub moment_g_mm: f64,
    /// Its angle, degrees.
    pub angle_deg: f64,
    /// Standard deviation of the moment in any direction, g mm.
    pub deviation_g_mm: f64,
    /// Masses in holes that come nearest to it; empty without holes.
    pub holes: Vec<HoleMass>,
    /// Moment that these masses leave, g mm.
    pub left_g_mm: f64,
}

/// Vibration of a probe before and after the correction.
#[derive(Debug, Clone, Serialize)]
pub struct Predicted {
    /// Probe.
    pub probe: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Size of the vector without added masses.
    pub before: f64,
    /// Its angle, degrees.
    pub before_deg: f64,
    /// Size with the correction.
    pub after: f64,
    /// Its angle, degrees.
    pub after_deg: f64,
    /// Standard deviation of the vector after the correction: by the coefficients and by the drift.
    pub deviation: f64,
}

/// Correction of the rotor without added masses.
#[derive(Debug, Clone, Serialize)]
pub struct Correction {
    /// Moment and masses of each plane.
    pub planes: Vec<PlaneCorrection>,
    /// Masses are removed at the holes, opposite to the moments to add.
    pub removes: bool,
    /// Combinations of the planes that the probes do not show above their errors, and that therefore stay 0.
    pub not_observed: usize,
    /// Vibration before and after.
    pub predicted: Vec<Predicted>,
    /// Moments of the planes, g mm.
    #[serde(skip)]
    pub(super) moments: Vec<C>,
    /// Moments that are put in, g mm.
    #[serde(skip)]
    pub(super) added: Vec<C>,
    /// Covariance of the moments.
    #[serde(skip)]
    pub(super) covariance: DMatrix<C>,
}

/// Least size of a combination of planes at the probes, with the trial moments, in units of the errors of the vectors.
pub(super) const OBSERVED: f64 = 3.0;

/// Finds the moments that leave the least sum of squares of all vectors; combinations of planes that the probes do not show stay 0.
pub(super) fn correction(of: &Vectors, placement: &Placement) -> Option<Correction> {
    let (channels, planes) = (of.channels(), of.planes.len());
    let matrix = DMatrix::from_fn(channels, planes, |channel, k| of.coefficient(channel, k));
    let baseline = DVector::from_fn(channels, |channel, _| of.baseline(channel));
    let factors = of.weighted().svd(false, true);
    let seen: Vec<usize> = (0..planes).filter(|&i| factors.singular_values[i] > OBSERVED).collect();
    let directions = factors.v_t?.adjoint();
    let seen_directions = DMatrix::from_columns(&seen.iter().map(|&i| directions.column(i)).collect::<Vec<_>>());
    let inverse = &seen_directions * (&matrix * &seen_directions).pseudo_inverse(f64::EPSILON).ok()?;
    let moments: DVector<C> = -(&inverse * &baseline);
    let planned: Vec<Vec<HoleMass>> = moments.iter().map(|moment| placement.nearest(*moment)).collect();
    // What is put in is what acts.
    let added: Vec<C> =
        moments.iter().zip(&planned).map(|(moment, masses)| placement.acting(*moment, masses)).collect();
    let by_channel = of.errors(&added);
    let of_moments = &inverse * of.errors(moments.as_slice()) * inverse.adjoint();
    let planes = of.planes.iter().zip(moments.iter().zip(planned)).enumerate().map(|(k, (plane, (moment, holes)))| {
        PlaneCorrection {
            plane: plane.clone(),
            moment_g_mm: moment.norm(),
            angle_deg: moment.arg().to_degrees().rem_euclid(360.0),
            deviation_g_mm: of_moments[(k, k)].re.max(0.0).sqrt(),
            holes,
            left_g_mm: (moment - added[k]).norm(),
        }
    });
    let predicted = |channel: usize| {
        let after = baseline[channel] + added.iter().enumerate().map(|(k, u)| matrix[(channel, k)] * u).sum::<C>();
        Predicted {
            probe: of.probe(channel).to_owned(),
            speed_rpm: of.speed(channel),
            before: baseline[channel].norm(),
            before_deg: baseline[channel].arg().to_degrees().rem_euclid(360.0),
            after: after.norm(),
            after_deg: after.arg().to_degrees().rem_euclid(360.0),
            deviation: by_channel[(channel, channel)].re.max(0.0).sqrt(),
        }
    };
    let planes = planes.collect();
    Some(Correction {
        planes,
        removes: placement.removes,
        not_observed: of.planes.len() - seen.len(),
        predicted: (0..channels).map(predicted).collect(),
        moments: moments.iter().copied().collect(),
        covariance: of_moments,
        added,
    })
}

/// Units of a moment in g mm: kg m.
const G_MM: f64 = 1e-6;

impl Holes {
    fn angle(&self, hole: usize) -> f64 {
        TAU * hole as f64 / self.count as f64
    }

    /// Returns the moment of a mass, g mm.
    fn moment(&self, mass: &HoleMass) -> C {
        C::from_polar(1e-3 * mass.mass_g * self.radius / G_MM, mass.angle_deg.to_radians())
    }

    /// Returns the masses in neighbouring holes that come nearest to a moment (g mm): two, and further ones where those are full.
    fn nearest(&self, moment: C) -> Vec<HoleMass> {
        let mut masses = vec![0.0; self.count];
        if self.stock.is_empty() {
            self.fill(moment, &mut masses);
        } else {
            let first = (moment.arg().rem_euclid(TAU) / TAU * self.count as f64).floor() as usize % self.count;
            let pair = [first, (first + 1) % self.count];
            let [a, b] = pair.map(|hole| self.unit(hole));
            let fits = |mass: &f64| self.limit.is_none_or(|limit| *mass <= limit);
            let all = || std::iter::once(0.0).chain(self.stock.iter().copied().filter(fits));
            let left = |[x, y]: [f64; 2]| (moment - a * x - b * y).norm();
            let pairs = all().flat_map(|x| all().map(move |y| [x, y]));
            let nearest = pairs.min_by(|p, q| left(*p).total_cmp(&left(*q))).unwrap_or_default();
            pair.into_iter().zip(nearest).for_each(|(hole, mass)| masses[hole] = mass);
        }
        let placed = masses.into_iter().enumerate().filter(|(_, mass)| *mass > 0.0);
        placed
            .map(|(hole, mass)| HoleMass {
                hole: hole + 1,
                angle_deg: self.angle(hole).to_degrees(),
                mass_g: 1e3 * mass,
            })
            .collect()
    }

    /// Returns the moment of 1 kg in a hole, g mm.
    fn unit(&self, hole: usize) -> C {
        C::from_polar(self.radius / G_MM, self.angle(hole))
    }

    /// Fills the holes beside the direction of a moment that have room, pair by pair, until nothing is left or no hole has room.
    fn fill(&self, moment: C, masses: &mut [f64]) {
        let mut left = moment;
        // Each round fills a hole or ends.
        for _ in 0..=self.count {
            let turns = left.arg().rem_euclid(TAU) / TAU * self.count as f64;
            let has_room = |hole: usize| self.limit.is_none_or(|limit| masses[hole] < limit);
            let below = (0..self.count).map(|step| (turns.floor() as usize + self.count - step) % self.count);
            let above = (0..self.count).map(|step| (turns.floor() as usize + 1 + step) % self.count);
            let pair = [below.into_iter().find(|hole| has_room(*hole)), above.into_iter().find(|hole| has_room(*hole))];
            let [Some(a), Some(b)] = pair else { return };
            // Holes half a turn or more apart hold no moment between them.
            let cross = |p: C, q: C| p.re * q.im - p.im * q.re;
            let (unit_a, unit_b) = (self.unit(a), self.unit(b));
            let area = cross(unit_a, unit_b);
            if left.norm() < f64::EPSILON * moment.norm() || area <= f64::EPSILON * unit_a.norm_sqr() {
                return;
            }
            // Cramer's rule for masses along two directions.
            for (hole, unit, mass) in [(a, unit_a, cross(left, unit_b) / area), (b, unit_b, cross(unit_a, left) / area)]
            {
                let room = self.limit.map_or(f64::INFINITY, |limit| limit - masses[hole]);
                let put = mass.clamp(0.0, room);
                masses[hole] += put;
                left -= unit * put;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_in_two_holes_have_the_moment() {
        let holes = Holes { count: 16, radius: 0.03, stock: vec![], limit: None };
        for angle in [0.0, 10.0, 22.5, 100.0, 359.0_f64] {
            let moment = C::from_polar(48.0, angle.to_radians());
            let masses = holes.nearest(moment);
            let sum: C = masses.iter().map(|mass| holes.moment(mass)).sum();
            assert!((sum - moment).norm() < 1e-9, "{angle}: {masses:?}");
            assert!(masses.iter().all(|mass| mass.mass_g > 0.0), "{angle}: {masses:?}");
        }
    }

    #[test]
    fn weights_in_stock_come_as_near_as_they_can() {
        let holes = Holes { count: 16, radius: 0.03, stock: vec![0.4e-3, 0.8e-3], limit: None };
        let masses = holes.nearest(C::from_polar(24.0, 22.5_f64.to_radians()));
        assert_eq!(masses.len(), 1, "{masses:?}");
        assert_eq!((masses[0].hole, masses[0].mass_g), (2, 0.8));
    }
    /// A moment of two full holes and more goes to those beside them; one that the half circle does not hold leaves the rest.
    #[test]
    fn full_holes_pass_the_rest_to_their_neighbours() {
        let holes = Holes { count: 16, radius: 0.03, stock: vec![], limit: Some(0.5e-3) };
        let moment = C::from_polar(50.0, 1.0);
        let masses = holes.nearest(moment);
        let sum: C = masses.iter().map(|mass| holes.moment(mass)).sum();
        assert!(masses.len() > 2 && (sum - moment).norm() < 1e-6, "{masses:?}");
        assert!(masses.iter().all(|mass| mass.mass_g <= 0.5 + 1e-9), "{masses:?}");
        let full = holes.nearest(C::from_polar(500.0, 1.0));
        let sum: C = full.iter().map(|mass| holes.moment(mass)).sum();
        assert!(sum.norm() > 60.0 && sum.norm() < 80.0, "{full:?}");
    }

    #[test]
    fn what_is_removed_acts_as_the_opposite() {
        let holes = Some(Holes { count: 12, radius: 0.03, stock: vec![], limit: None });
        let (drilled, moment) = (Placement { holes, removes: true }, C::from_polar(12.0, 0.3));
        let masses = drilled.nearest(moment);
        assert!((drilled.acting(moment, &masses) - moment).norm() < 1e-9, "{masses:?}");
        assert!(masses.iter().all(|mass| (180.0..=211.0).contains(&mass.angle_deg)), "{masses:?}");
    }
}
