//! Correction masses: the moments that leave the least vibration, and the holes and weights that come nearest to them.

use super::Vectors;
use super::table::C;
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
    /// Size with the correction.
    pub after: f64,
    /// Standard deviation of the vector after the correction: by the coefficients and by the drift.
    pub deviation: f64,
}

/// Correction of the rotor without added masses.
#[derive(Debug, Clone, Serialize)]
pub struct Correction {
    /// Moment and masses of each plane.
    pub planes: Vec<PlaneCorrection>,
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
pub(super) fn correction(of: &Vectors, holes: Option<&Holes>) -> Option<Correction> {
    let (channels, planes) = (of.channels(), of.planes.len());
    let matrix = DMatrix::from_fn(channels, planes, |channel, k| of.coefficient(channel, k));
    let baseline = DVector::from_fn(channels, |channel, _| of.baseline(channel));
    let factors = of.weighted().svd(false, true);
    let seen: Vec<usize> = (0..planes).filter(|&i| factors.singular_values[i] > OBSERVED).collect();
    let directions = factors.v_t?.adjoint();
    let seen_directions = DMatrix::from_columns(&seen.iter().map(|&i| directions.column(i)).collect::<Vec<_>>());
    let inverse = &seen_directions * (&matrix * &seen_directions).pseudo_inverse(f64::EPSILON).ok()?;
    let moments: DVector<C> = -(&inverse * &baseline);
    let planned: Vec<Vec<HoleMass>> =
        moments.iter().map(|moment| holes.map_or_else(Vec::new, |holes| holes.nearest(*moment))).collect();
    // What is put in is what acts.
    let added: Vec<C> = match holes {
        None => moments.iter().copied().collect(),
        Some(holes) => planned.iter().map(|masses| masses.iter().map(|mass| holes.moment(mass)).sum()).collect(),
    };
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
            after: after.norm(),
            deviation: by_channel[(channel, channel)].re.max(0.0).sqrt(),
        }
    };
    let planes = planes.collect();
    Some(Correction {
        planes,
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

    /// Returns the masses in two neighbouring holes, or in one, that come nearest to a moment (g mm).
    fn nearest(&self, moment: C) -> Vec<HoleMass> {
        let turns = moment.arg().rem_euclid(TAU) / TAU * self.count as f64;
        let first = turns.floor() as usize;
        let unit = |hole: usize| C::from_polar(self.radius / G_MM, self.angle(hole));
        let pair = [first % self.count, (first + 1) % self.count];
        let [a, b] = pair.map(unit);
        let masses = if self.stock.is_empty() {
            // Cramer's rule for masses along two directions.
            let cross = |p: C, q: C| p.re * q.im - p.im * q.re;
            [cross(moment, b) / cross(a, b), cross(a, moment) / cross(a, b)]
        } else {
            let all = || std::iter::once(0.0).chain(self.stock.iter().copied());
            let left = |[x, y]: [f64; 2]| (moment - a * x - b * y).norm();
            let pairs = all().flat_map(|x| all().map(move |y| [x, y]));
            pairs.min_by(|p, q| left(*p).total_cmp(&left(*q))).unwrap_or_default()
        };
        let placed = pair.into_iter().zip(masses).filter(|(_, mass)| *mass > 0.0);
        placed
            .map(|(hole, mass)| HoleMass {
                hole: hole + 1,
                angle_deg: self.angle(hole).to_degrees(),
                mass_g: 1e3 * mass,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_in_two_holes_have_the_moment() {
        let holes = Holes { count: 16, radius: 0.03, stock: vec![] };
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
        let holes = Holes { count: 16, radius: 0.03, stock: vec![0.4e-3, 0.8e-3] };
        let masses = holes.nearest(C::from_polar(24.0, 22.5_f64.to_radians()));
        assert_eq!(masses.len(), 1, "{masses:?}");
        assert_eq!((masses[0].hole, masses[0].mass_g), (2, 0.8));
    }
}
