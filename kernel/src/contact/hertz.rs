//! Hertz point contact of a ball in a groove, by complete elliptic integrals.
//!
//! For set-up, always in `f64`: every target computes the same constants, rounded once to its precision. Cost: about 400
//! floating-point operations and 20 square roots per contact.

use libm::{exp, log, sqrt};

/// Elastic constants of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
}

/// Returns the effective modulus `E' = 2 / ((1 - nu1^2)/E1 + (1 - nu2^2)/E2)`, Pa (Harris, Rolling Bearing Analysis).
#[must_use]
pub fn effective_modulus(a: Material, b: Material) -> f64 {
    let compliance = |m: Material| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
    2.0 / (compliance(a) + compliance(b))
}

/// Race of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Race {
    /// Convex along the rolling direction.
    Inner,
    /// Concave along the rolling direction.
    Outer,
}

/// A Hertz point contact.
///
/// ```
/// use ballrace::bearing::geometry::BEARING_STEEL;
/// use ballrace::contact::hertz::{PointContact, Race, effective_modulus};
///
/// // A ball of 7 mm at 25 degrees on a pitch circle of 38.5 mm, groove radius 0.52 of the ball's diameter.
/// let gamma = 7.0 * 25.0_f64.to_radians().cos() / 38.5;
/// let modulus = effective_modulus(BEARING_STEEL, BEARING_STEEL);
/// let inner = PointContact::ball_on_race(Race::Inner, 7e-3, 0.52, gamma, modulus);
/// assert!((inner.stiffness / 2.393_295_7e10 - 1.0).abs() < 1e-7);
/// let (_, _, pressure) = inner.ellipse(100.0);
/// assert!((pressure / 1_264.771e6 - 1.0).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointContact {
    /// kappa = a/b, ratio of the semi-axes, 1 or more.
    pub ellipticity: f64,
    /// `1/R`: sum of the four principal curvatures, 1/m.
    pub curvature_sum: f64,
    /// `F(rho)`: normalised difference of the curvatures, 0 to 1.
    pub curvature_difference: f64,
    /// Complete elliptic integral of the first kind, xi = K(m), m = 1 - 1/kappa^2.
    pub first_kind: f64,
    /// Complete elliptic integral of the second kind, eps = E(m).
    pub second_kind: f64,
    /// Effective modulus, Pa.
    pub effective_modulus: f64,
    /// `K = pi kappa E' sqrt(2 eps R / 9) / xi^(3/2)`, N/m^1.5, so that `Q = K delta^1.5`.
    pub stiffness: f64,
}

impl PointContact {
    /// Creates the contact of a ball of diameter `d` in a groove of radius `conformity * d` on `race`.
    ///
    /// `gamma = d cos(alpha) / pitch_diameter`. Valid for `d > 0`, `0.5 < conformity`, `0 <= gamma < 1` (see
    /// [`crate::bearing::geometry`]). Source: Harris, Rolling Bearing Analysis, ch. 6; Hamrock and Brewe for the initial
    /// value.
    #[must_use]
    pub fn ball_on_race(race: Race, d: f64, conformity: f64, gamma: f64, modulus: f64) -> Self {
        let rolling = match race {
            Race::Inner => (2.0 + 2.0 * gamma / (1.0 - gamma)) / d,
            Race::Outer => (2.0 - 2.0 * gamma / (1.0 + gamma)) / d,
        };
        // (2 f - 1)/f instead of 2 - 1/f avoids cancellation.
        let transverse = (2.0 * conformity - 1.0) / conformity / d;
        Self::from_curvatures(rolling, transverse, modulus)
    }

    /// Creates the contact from the relative curvatures along and across the rolling direction, 1/m, `along >= across > 0`.
    #[must_use]
    pub fn from_curvatures(along: f64, across: f64, modulus: f64) -> Self {
        let ratio = along / across;
        let kappa = ellipticity(ratio);
        let (xi, eps) = elliptic_integrals(kappa);
        let sum = along + across;
        Self {
            ellipticity: kappa,
            curvature_sum: sum,
            curvature_difference: (ratio - 1.0) / (ratio + 1.0),
            first_kind: xi,
            second_kind: eps,
            effective_modulus: modulus,
            stiffness: core::f64::consts::PI * kappa * modulus * sqrt(2.0 * eps / (9.0 * sum)) / (xi * sqrt(xi)),
        }
    }

    /// Returns the contact ellipse under the load `q` (N): semi-axes across and along the rolling direction, m, and the
    /// peak pressure `3 q / (2 pi a b)`, Pa.
    #[must_use]
    pub fn ellipse(&self, q: f64) -> (f64, f64, f64) {
        let kappa = self.ellipticity;
        let cube = 6.0 * kappa * kappa * self.second_kind * q
            / (core::f64::consts::PI * self.curvature_sum * self.effective_modulus);
        let a = libm::cbrt(cube);
        let b = a / kappa;
        (a, b, 1.5 * q / (core::f64::consts::PI * a * b))
    }
}

/// Returns the stiffness of two contacts in series: `K_n = (K_i^(-2/3) + K_o^(-2/3))^(-3/2)`, N/m^1.5.
#[must_use]
pub fn in_series(inner: f64, outer: f64) -> f64 {
    let compliance = |k: f64| {
        let root = libm::cbrt(k);
        1.0 / (root * root)
    };
    let sum = compliance(inner) + compliance(outer);
    1.0 / (sum * sqrt(sum))
}

/// Computes the complete elliptic integrals K(m) and E(m) at `m = 1 - 1/kappa^2` by the arithmetic-geometric mean.
///
/// The convergence is quadratic; 7 iterations reach the rounding of `f64` for kappa up to 1e6.
fn elliptic_integrals(kappa: f64) -> (f64, f64) {
    let (mut a, mut g) = (1.0, 1.0 / kappa);
    let mut weight = 0.5;
    let mut sum = 0.5 * (1.0 - g * g);
    for _ in 0..7 {
        let c = 0.5 * (a - g);
        (a, g) = (0.5 * (a + g), sqrt(a * g));
        weight *= 2.0;
        sum += weight * c * c;
    }
    let first = core::f64::consts::FRAC_PI_2 / a;
    (first, first * (1.0 - sum))
}

/// Returns the ellipticity for the ratio of curvatures `R_y/R_x >= 1`.
///
/// The equation `F = ((k^2+1) eps - 2 xi)/((k^2-1) eps)` is equivalent to `R_y/R_x = (k^2 eps - xi)/(xi - eps)`, which is
/// smooth in logarithms. Newton's method from the fit of Brewe and Hamrock (error below 3.4 %) reaches the rounding after
/// four steps.
fn ellipticity(ratio: f64) -> f64 {
    let target = log(ratio);
    if target < 1e-9 {
        return 1.0; // a sphere on a plane; the expression below is 0/0 there
    }
    let mut x = 0.636 * target + log(1.0339);
    for _ in 0..8 {
        let kappa = exp(x);
        let (xi, eps) = elliptic_integrals(kappa);
        let (n, m1) = (kappa * kappa, 1.0 / (kappa * kappa));
        let m = 1.0 - m1;
        // d/dx with x = ln kappa: dm/dx = 2 m1; K' = (E - m1 K)/(2 m m1), E' = (E - K)/(2 m).
        let dxi = (eps - m1 * xi) / m;
        let deps = (eps - xi) * m1 / m;
        let (top, bottom) = (n * eps - xi, xi - eps);
        let slope = (2.0 * n * eps + n * deps - dxi) / top - (dxi - deps) / bottom;
        x -= (log(top / bottom) - target) / slope;
        // Below kappa = 1 the axes swap; there is no root.
        x = if x > 1e-12 { x } else { 1e-12 };
    }
    exp(x)
}
