//! Matrices of one finite element in one plane, and along the axis.
//!
//! Coordinates of an element: displacement and rotation of the section at its two ends, `[x1 phi1 x2 phi2]`, in one plane through
//! the axis. The shaft is axially symmetric: the other plane has the same matrices.

use nalgebra::{Matrix2, Matrix4};
use std::f64::consts::PI;

/// Elastic constants and density of the shaft.
#[derive(Debug, Clone, Copy)]
pub struct Material {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Density, kg/m^3.
    pub density: f64,
}

/// Timoshenko beam element: a short hollow cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Length, m.
    pub length: f64,
    /// Area of the section, m^2.
    area: f64,
    /// Second moment of area about a diameter, m^4.
    second_moment: f64,
    /// Shear coefficient of the section.
    shear_coefficient: f64,
}

impl Element {
    /// Creates the element of a cone between two sections, given by their outer diameters, with one bore: area and second moment
    /// are means over the length.
    pub fn new(length: f64, outer: [f64; 2], inner: f64, poissons_ratio: f64) -> Self {
        // Means of d^2 and d^4 over a cone.
        let [a, b] = outer;
        let square = (a * a + a * b + b * b) / 3.0;
        let fourth = (0..=4).map(|i| a.powi(i) * b.powi(4 - i)).sum::<f64>() / 5.0;
        Self {
            length,
            area: 0.25 * PI * (square - inner * inner),
            second_moment: PI / 64.0 * (fourth - inner.powi(4)),
            shear_coefficient: shear_coefficient(inner / square.sqrt(), poissons_ratio),
        }
    }

    /// Returns the ratio of bending to shear stiffness, `12 E I / (kappa G A L^2)`.
    fn shear_ratio(&self, of: &Material) -> f64 {
        let shear_modulus = of.youngs_modulus / (2.0 * (1.0 + of.poissons_ratio));
        12.0 * of.youngs_modulus * self.second_moment
            / (self.shear_coefficient * shear_modulus * self.area * self.length * self.length)
    }

    /// Returns the stiffness in bending and shear.
    pub fn stiffness(&self, of: &Material) -> Matrix4<f64> {
        let (l, s) = (self.length, self.shear_ratio(of));
        let scale = of.youngs_modulus * self.second_moment / (l.powi(3) * (1.0 + s));
        let (near, far) = ((4.0 + s) * l * l, (2.0 - s) * l * l);
        #[rustfmt::skip]
        let entries = Matrix4::new(
            12.0, 6.0 * l, -12.0, 6.0 * l,
            6.0 * l, near, -6.0 * l, far,
            -12.0, -6.0 * l, 12.0, -6.0 * l,
            6.0 * l, far, -6.0 * l, near,
        );
        scale * entries
    }

    /// Returns the consistent mass of the translation.
    fn translation(&self, of: &Material) -> Matrix4<f64> {
        let (l, s) = (self.length, self.shear_ratio(of));
        let scale = of.density * self.area * l / (1.0 + s).powi(2);
        let a = 13.0 / 35.0 + 0.7 * s + s * s / 3.0;
        let b = (11.0 / 210.0 + 11.0 / 120.0 * s + s * s / 24.0) * l;
        let c = 9.0 / 70.0 + 0.3 * s + s * s / 6.0;
        let d = (13.0 / 420.0 + 3.0 / 40.0 * s + s * s / 24.0) * l;
        let e = (1.0 / 105.0 + s / 60.0 + s * s / 120.0) * l * l;
        let f = (1.0 / 140.0 + s / 60.0 + s * s / 120.0) * l * l;
        #[rustfmt::skip]
        let entries = Matrix4::new(
            a, b, c, -d,
            b, e, d, -f,
            c, d, a, -b,
            -d, -f, -b, e,
        );
        scale * entries
    }

    /// Returns the consistent inertia of the rotation of the sections about a diameter.
    fn rotation(&self, of: &Material) -> Matrix4<f64> {
        let (l, s) = (self.length, self.shear_ratio(of));
        let scale = of.density * self.second_moment / (l * (1.0 + s).powi(2));
        let a = 1.2;
        let b = (0.1 - 0.5 * s) * l;
        let c = (2.0 / 15.0 + s / 6.0 + s * s / 3.0) * l * l;
        let d = (-1.0 / 30.0 - s / 6.0 + s * s / 6.0) * l * l;
        #[rustfmt::skip]
        let entries = Matrix4::new(
            a, b, -a, b,
            b, c, -b, d,
            -a, -b, a, -b,
            b, d, -b, c,
        );
        scale * entries
    }

    /// Returns the consistent mass of translation and rotation.
    pub fn mass(&self, of: &Material) -> Matrix4<f64> {
        self.translation(of) + self.rotation(of)
    }

    /// Returns the polar inertia of the sections, in the coordinates of the rotations: twice the diametral one.
    pub fn polar(&self, of: &Material) -> Matrix4<f64> {
        2.0 * self.rotation(of)
    }

    /// Returns stiffness and mass along the axis, in `[w1 w2]`.
    pub fn axial(&self, of: &Material) -> [Matrix2<f64>; 2] {
        let stiffness = of.youngs_modulus * self.area / self.length;
        let mass = of.density * self.area * self.length / 6.0;
        [stiffness * Matrix2::new(1.0, -1.0, -1.0, 1.0), mass * Matrix2::new(2.0, 1.0, 1.0, 2.0)]
    }
}

/// Returns the shear coefficient of a ring section with this ratio of the diameters (Cowper 1966, Journal of Applied Mechanics 33).
fn shear_coefficient(ratio: f64, poissons_ratio: f64) -> f64 {
    let (m, n) = (ratio * ratio, poissons_ratio);
    let sum = (1.0 + m) * (1.0 + m);
    6.0 * (1.0 + n) * sum / ((7.0 + 6.0 * n) * sum + (20.0 + 12.0 * n) * m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector4;

    const STEEL: Material = Material { youngs_modulus: 2.06e11, poissons_ratio: 0.3, density: 7810.0 };

    /// A rigid motion has no strain, and the inertia of the rigid body.
    #[test]
    fn rigid_motions() {
        let (length, diameter) = (0.08, 0.03);
        let element = Element::new(length, [diameter; 2], 0.01, 0.3);
        let moved = Vector4::new(1.0, 0.0, 1.0, 0.0);
        let turned = Vector4::new(-0.5 * length, 1.0, 0.5 * length, 1.0);
        let stiffness = element.stiffness(&STEEL);
        assert!((stiffness * moved).amax() < 1e-9 * stiffness.amax());
        assert!((stiffness * turned).amax() < 1e-9 * stiffness.amax());
        let mass = STEEL.density * 0.25 * PI * (diameter * diameter - 1e-4) * length;
        let squares = diameter * diameter + 1e-4;
        let about_diameter = mass * (squares / 16.0 + length * length / 12.0);
        let is = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        is(moved.dot(&(element.mass(&STEEL) * moved)), mass);
        is(turned.dot(&(element.mass(&STEEL) * turned)), about_diameter);
        is(turned.dot(&(element.polar(&STEEL) * turned)), mass * squares / 8.0);
    }

    /// A cantilever under a force at its end: bending `F L^3 / 3 E I` plus shear `F L / kappa G A`.
    #[test]
    fn deflection_of_a_cantilever() {
        let element = Element::new(0.05, [0.04; 2], 0.0, 0.3);
        let stiffness = element.stiffness(&STEEL);
        let free = stiffness.fixed_view::<2, 2>(2, 2).into_owned();
        let deflection = free.try_inverse().map(|flexibility| flexibility[(0, 0)]).unwrap_or_default();
        let (area, moment) = (0.25 * PI * 0.04_f64.powi(2), PI / 64.0 * 0.04_f64.powi(4));
        let shear_modulus = STEEL.youngs_modulus / 2.6;
        // The coefficient of the full section: 6 (1 + nu) / (7 + 6 nu).
        let expected =
            0.05_f64.powi(3) / (3.0 * STEEL.youngs_modulus * moment) + 0.05 / (7.8 / 8.8 * shear_modulus * area);
        assert!((deflection / expected - 1.0).abs() < 1e-12, "{deflection} {expected}");
    }
}
