//! Fatigue life of a bearing under measured loads.

use super::CompensatedSum;
use crate::bearing::geometry::{BallBearingGeometry, InvalidParameter, check};
use crate::math::Math;
use crate::scalar::Scalar;

/// Constants of the fatigue life of a radial ball bearing.
///
/// `Q_ci = C_r/(0.407 Z cos^0.7 a) (1 + t^(10/3))^0.3`, `Q_ce = C_r/(0.389 Z cos^0.7 a) (1 + t^(-10/3))^0.3` with `t =
/// 1.044 ((1 - g)/(1 + g))^1.72 ((r_i/r_e) (2 r_e - D)/(2 r_i - D))^0.41`. Over a block `Q_ei = (mean Q^3)^(1/3)`, `Q_ee =
/// (mean Q^(10/3))^(3/10)` for an inner ring that rotates relative to the load, and `L_10r = ((Q_ci/Q_ei)^(-10/3) +
/// (Q_ce/Q_ee)^(-10/3))^(-9/10)` million revolutions.
///
/// Source: ISO 16281:2025 (as ISO/TS 16281:2008), ISO 281:2007.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LifeParams {
    /// `Q_ci`, load of a ball at the inner race with a life of one million revolutions, N.
    pub inner_rating: f64,
    /// `Q_ce`, the same at the outer race, N.
    pub outer_rating: f64,
}

impl LifeParams {
    /// Computes the constants from geometry, element count and basic dynamic load rating `C_r`, N. For set-up.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn try_new(geometry: BallBearingGeometry, elements: usize, rating: f64) -> Result<Self, InvalidParameter> {
        let g = geometry.checked()?;
        check(rating > 0.0, "dynamic_rating", rating, "above 0 N")?;
        check(elements >= 3, "elements", elements as f64, "3 or more")?;
        let (fi, fe, gamma) = (g.inner_conformity, g.outer_conformity, g.gamma());
        let grooves = (fi / fe) * (2.0 * fe - 1.0) / (2.0 * fi - 1.0);
        let t = 1.044 * libm::pow((1.0 - gamma) / (1.0 + gamma), 1.72) * libm::pow(grooves, 0.41);
        let share = rating / (elements as f64 * libm::pow(libm::cos(g.contact_angle), 0.7));
        let side = |t: f64| libm::pow(1.0 + libm::pow(t, 10.0 / 3.0), 0.3);
        Ok(Self { inner_rating: share / 0.407 * side(t), outer_rating: share / 0.389 * side(1.0 / t) })
    }
}

/// Fatigue life consumed by the element loads, block by block.
///
/// Cost per sample: a ninth root and 25 operations for each element. The sum is compensated: a year of one-second blocks is
/// accurate in `f32`.
#[derive(Debug, Clone, Copy)]
pub struct Life<T> {
    /// Inverse ratings: loads are scaled by them, so that no power overflows.
    inner: T,
    outer: T,
    cubes: CompensatedSum<T>,
    ten_thirds: CompensatedSum<T>,
    elements: CompensatedSum<T>,
    used: CompensatedSum<T>,
}

impl<T: Scalar> Life<T> {
    /// Creates the state with no life consumed.
    #[must_use]
    pub fn new(params: &LifeParams) -> Self {
        Self {
            inner: T::from_f64(1.0 / params.inner_rating),
            outer: T::from_f64(1.0 / params.outer_rating),
            cubes: CompensatedSum::new(),
            ten_thirds: CompensatedSum::new(),
            elements: CompensatedSum::new(),
            used: CompensatedSum::new(),
        }
    }

    /// Adds the element loads of one sample, N.
    pub fn add<M: Math<T>>(&mut self, loads: &[T]) {
        for &load in loads {
            let (q, p) = (self.inner * load, self.outer * load);
            self.cubes.add(q * q * q);
            let ninth = M::ninth_root(p);
            self.ten_thirds.add(p * p * p * ninth * ninth * ninth);
            self.elements.add(T::ONE);
        }
    }

    /// Ends a block of `turns` revolutions of the shaft and returns `L_10r` of its loads, million revolutions (infinite
    /// without load).
    pub fn close<M: Math<T>>(&mut self, turns: T) -> T {
        let count = self.elements.value().larger(T::ONE);
        let (cube, outer) = (self.cubes.value() / count, self.ten_thirds.value() / count);
        // (Q_ei/Q_ci)^(10/3) of the mean cube: its 10/9th power.
        let inner = cube * M::ninth_root(cube);
        let sum = inner + outer;
        // L = s^(-9/10), as s^(9/10) = s^(19/10)/s: `powf` takes exponents of 1 and more.
        let some = sum > T::ZERO;
        let sure = T::select(some, sum, T::ONE);
        let per_million = T::select(some, M::powf(sure, T::from_f64(1.9)) / sure, T::ZERO);
        self.used.add(turns * T::from_f64(1e-6) * per_million);
        (self.cubes, self.ten_thirds, self.elements) =
            (CompensatedSum::new(), CompensatedSum::new(), CompensatedSum::new());
        T::ONE / per_million
    }

    /// Returns the consumed share of the life; at 1, one bearing in ten has failed.
    #[must_use]
    pub fn used(&self) -> T {
        self.used.value()
    }
}
