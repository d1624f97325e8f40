//! Balance quality of a rigid rotor: the residual unbalance of its tolerance planes against the grade that is asked for.
//!
//! The permissible residual unbalance of a rotor of mass `m` at the speed `w` is `U = G m / w`, `9549 G m / n` in g mm with `G` in mm/s, `m` in
//! kg and `n` in rpm. It is divided over two bearings by their distances from the centre of mass, each with 30 to 70 % of it (30 to 130 %
//! where the centre of mass is beyond both).
//!
//! Source: ISO 21940-11:2016, chapters 5 to 7.

use super::correction::Correction;
use super::plane::Plane;
use super::table::C;
use ballrace_scene::Scene;
use nalgebra::DVector;
use serde::Serialize;
use std::f64::consts::TAU;

/// Least and largest share of a bearing, for a centre of mass between the bearings and beyond them.
const SHARES: [[f64; 2]; 2] = [[0.3, 0.7], [0.3, 1.3]];

/// A plane in which a residual unbalance is allowed.
#[derive(Debug, Clone, PartialEq)]
pub struct TolerancePlane {
    /// Name.
    pub name: String,
    /// Share of the permissible residual unbalance of the rotor.
    pub share: f64,
    /// Moment here by a moment of 1 on each correction plane.
    pub weights: Vec<f64>,
}

/// Balance quality that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// Grade, mm/s: 2.5 for G 2.5.
    pub grade: f64,
    /// Mass of the rotor, kg.
    pub mass: f64,
    /// Service speed, rpm.
    pub speed_rpm: f64,
    /// Tolerance planes.
    pub planes: Vec<TolerancePlane>,
}

/// Residual unbalance of a tolerance plane.
#[derive(Debug, Clone, Serialize)]
pub struct PlaneQuality {
    /// Plane.
    pub plane: String,
    /// Permissible residual unbalance, g mm.
    pub permissible_g_mm: f64,
    /// Unbalance before the correction, g mm.
    pub before_g_mm: f64,
    /// Unbalance with the correction, g mm.
    pub after_g_mm: f64,
    /// Its upper end with 95 %.
    pub after_high_g_mm: f64,
}

/// Balance quality before and after the correction.
#[derive(Debug, Clone, Serialize)]
pub struct Quality {
    /// Grade that is asked for, mm/s.
    pub grade: f64,
    /// Mass of the rotor, kg.
    pub mass_kg: f64,
    /// Service speed, rpm.
    pub speed_rpm: f64,
    /// Permissible residual unbalance of the rotor, g mm.
    pub permissible_g_mm: f64,
    /// By tolerance plane.
    pub planes: Vec<PlaneQuality>,
    /// Grade before the correction: that of the plane farthest beyond its tolerance, mm/s.
    pub before: f64,
    /// Grade with the correction.
    pub after: f64,
    /// Its upper end with 95 %.
    pub after_high: f64,
}

impl TolerancePlane {
    /// Returns the correction planes themselves, each with the same share.
    #[must_use]
    pub fn of_correction(names: &[String]) -> Vec<Self> {
        let of = |i: usize| Self {
            name: names[i].clone(),
            share: 1.0 / names.len() as f64,
            weights: (0..names.len()).map(|k| if k == i { 1.0 } else { 0.0 }).collect(),
        };
        (0..names.len()).map(of).collect()
    }

    /// Returns the two bearings of a scene, with shares by their distances from the centre of mass; the correction planes
    /// where it does not have two bearings apart from each other.
    #[must_use]
    pub fn of_scene(scene: &Scene, planes: &[Plane]) -> Vec<Self> {
        let names: Vec<String> = planes.iter().map(|plane| plane.name.clone()).collect();
        let [a, b] = scene.bearings.as_slice() else { return Self::of_correction(&names) };
        let length = b.station - a.station;
        if length == 0.0 {
            return Self::of_correction(&names);
        }
        let [least, most] = SHARES[usize::from(a.station * b.station > 0.0)];
        [(a, b), (b, a)]
            .map(|(own, other)| {
                let towards = |station: f64| (other.station - station) / (other.station - own.station);
                Self {
                    name: own.name.clone(),
                    share: towards(0.0).abs().clamp(least, most),
                    weights: planes.iter().map(|plane| towards(plane.station)).collect(),
                }
            })
            .to_vec()
    }
}

impl Requirement {
    /// Returns the permissible residual unbalance of the rotor, g mm.
    #[must_use]
    pub fn permissible(&self) -> f64 {
        // mm/s times kg over rad/s are kg mm.
        1e3 * self.grade * self.mass / (self.speed_rpm.abs() / 60.0 * TAU)
    }

    /// Returns the quality before and after a correction.
    #[must_use]
    pub fn quality(&self, correction: &Correction) -> Quality {
        let permissible = self.permissible();
        let with = |mounted: &[C]| -> Vec<C> { correction.moments.iter().zip(mounted).map(|(u, m)| m - u).collect() };
        let (before, after) = (with(&correction.mounted), with(&correction.added));
        let plane = |of: &TolerancePlane| {
            let sum = |u: &[C]| of.weights.iter().zip(u).map(|(weight, u)| u * *weight).sum::<C>().norm();
            let weights = DVector::from_iterator(of.weights.len(), of.weights.iter().map(|w| C::new(*w, 0.0)));
            let variance = weights.dotc(&(&correction.covariance * &weights)).re.max(0.0);
            PlaneQuality {
                plane: of.name.clone(),
                permissible_g_mm: of.share * permissible,
                before_g_mm: sum(&before),
                after_g_mm: sum(&after),
                after_high_g_mm: sum(&after) + 2.0 * variance.sqrt(),
            }
        };
        let planes: Vec<PlaneQuality> = self.planes.iter().map(plane).collect();
        let worst = |of: fn(&PlaneQuality) -> f64| {
            self.grade * planes.iter().map(|plane| of(plane) / plane.permissible_g_mm).fold(0.0, f64::max)
        };
        Quality {
            grade: self.grade,
            mass_kg: self.mass,
            speed_rpm: self.speed_rpm,
            permissible_g_mm: permissible,
            before: worst(|plane| plane.before_g_mm),
            after: worst(|plane| plane.after_g_mm),
            after_high: worst(|plane| plane.after_high_g_mm),
            planes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 12 kg rotor of G 2.5 at 3000 rpm may have 9549 * 2.5 * 12 / 3000 = 95.5 g mm.
    #[test]
    fn permissible_unbalance() {
        let planes = TolerancePlane::of_correction(&["1".to_owned(), "2".to_owned()]);
        let asked = Requirement { grade: 2.5, mass: 12.0, speed_rpm: 3000.0, planes };
        assert!((asked.permissible() - 95.49).abs() < 0.01, "{}", asked.permissible());
    }
}
