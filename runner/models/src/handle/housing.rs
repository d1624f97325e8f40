//! Displacement of a housing that balls pass: given at points that are fixed in the housing, interpolated round the ring.

use ballrace::bearing::flexible::HousingPoint;
use ballrace::{Phase, Scalar};
use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest do not determine a harmonic.
const LEAST_SHARE: f64 = 1e-9;

/// Displacement of a housing as a trigonometric polynomial of the azimuth:
/// `q(phi) = c_0 + sum over k of c_k cos(k (phi - phi_1)) + s_k sin(k (phi - phi_1))`, of the least order that passes through all points.
#[derive(Debug, Clone)]
pub struct HousingShape {
    /// Azimuth of each element with the cage at angle 0; the point of the same index is there.
    azimuths: Vec<Phase>,
    /// `c_0, c_1, s_1, c_2, s_2, ...` along X, Y, Z, m.
    coefficients: Vec<[f64; 3]>,
}

impl HousingShape {
    /// Creates the shape through `points`, the displacements at `azimuths`, m.
    #[must_use]
    pub fn new(azimuths: Vec<Phase>, points: &[[f64; 3]]) -> Self {
        let count = points.len();
        let first = azimuths.first().copied().unwrap_or_default();
        let mut matrix = DMatrix::zeros(count, count);
        for (row, azimuth) in azimuths.iter().enumerate() {
            let basis = basis(count, azimuth.wrapping_add(first.reversed()).radians());
            basis.enumerate().for_each(|(column, value)| matrix[(row, column)] = value);
        }
        let decomposition = matrix.svd(true, true);
        let least = LEAST_SHARE * decomposition.singular_values.max();
        let along = |axis: usize| {
            let values = DVector::from_iterator(count, points.iter().map(|point| point[axis]));
            decomposition.solve(&values, least).unwrap_or_else(|_| DVector::zeros(count))
        };
        let [x, y, z] = [0, 1, 2].map(along);
        Self { azimuths, coefficients: (0..count).map(|i| [x[i], y[i], z[i]]).collect() }
    }

    /// Returns the housing at every element with the cage at the angle `cage`. Cost: two operations per component and harmonic.
    pub(crate) fn at_elements<T: Scalar>(&self, cage: Phase) -> Vec<HousingPoint<T>> {
        let first = self.azimuths.first().copied().unwrap_or_default();
        let at = |azimuth: &Phase| {
            let angle = azimuth.wrapping_add(first.reversed()).wrapping_add(cage).radians();
            let mut displacement = [0.0; 3];
            for (coefficients, value) in self.coefficients.iter().zip(basis(self.coefficients.len(), angle)) {
                displacement.iter_mut().zip(coefficients).for_each(|(sum, c)| *sum += c * value);
            }
            HousingPoint { displacement: displacement.map(T::from_f64), ..HousingPoint::default() }
        };
        self.azimuths.iter().map(at).collect()
    }
}

/// Returns the first `count` of `1, cos, sin, cos 2, sin 2, ...` of an angle.
fn basis(count: usize, angle: f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| {
        let (sin, cos) = (i.div_ceil(2) as f64 * angle).sin_cos();
        if i % 2 == 0 && i > 0 { sin } else { cos }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The housing of `count` points displaced by the polynomial of order 2 and 3.
    fn displaced(angle: f64) -> [f64; 3] {
        [1e-6 * (2.0 * angle).cos(), 3e-6 - 2e-6 * angle.sin(), 4e-6 * (3.0 * angle + 0.3).cos()]
    }

    fn shape(azimuths: &[f64]) -> HousingShape {
        let points: Vec<[f64; 3]> = azimuths.iter().map(|angle| displaced(*angle)).collect();
        HousingShape::new(azimuths.iter().map(|angle| Phase::from_radians(*angle)).collect(), &points)
    }

    /// Between the points the displacement is that of the ring, for even and uneven spacing, at every angle of the cage.
    #[test]
    fn balls_between_the_points_meet_the_ring_there() {
        let even: Vec<f64> = (0..8).map(|j| 0.4 + TAU * f64::from(j) / 8.0).collect();
        let uneven = [0.0, 0.9, 1.7, 2.4, 3.5, 4.1, 5.2];
        for azimuths in [&even[..], &uneven] {
            let shape = shape(azimuths);
            for cage in [0.0, 0.2, 1.1, 5.0] {
                for (point, azimuth) in shape.at_elements::<f64>(Phase::from_radians(cage)).iter().zip(azimuths) {
                    let expected = displaced(azimuth + cage);
                    for (found, expected) in point.displacement.iter().zip(expected) {
                        assert!(
                            (found - expected).abs() < 1e-17,
                            "{azimuth} + {cage} rad: {found}, {expected} is true"
                        );
                    }
                }
            }
        }
    }
}
