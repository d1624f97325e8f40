//! Oil film of a point contact: central thickness after Hamrock and Dowson (`docs/src/models.md#oil-film`), and the contact
//! load with a film.
//!
//! `h_c/R_x = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 kappa))` with `U = eta_0 u/(E' R_x)`, `G = C E'`, `W = Q/(E'
//! R_x^2)`. For one contact `h = A u^0.67 Q^-0.067` with `A` computed at set-up. The thickness is constant for loads below
//! [`FLOOR`]. With [`InletHeating`] the share [`thermal_reduction`] of it is left.

use crate::contact::hertz::PointContact;
use crate::math::Math;
use crate::math::lanes::Lanes;
use crate::scalar::Scalar;

/// Load below which the film thickness is constant, N: the formula has no limit at 0.
pub const FLOOR: f64 = 1e-3;

const BY_SPEED: f64 = 0.67;
/// Factors and exponents of [`thermal_reduction`].
const PRESSURE_FACTOR: f64 = 13.2;
const PRESSURE_POWER: f64 = 0.42;
const HEATING_FACTOR: f64 = 0.213;
const HEATING_POWER: f64 = 0.64;
/// Exponent of the load.
pub(super) const BY_LOAD: f64 = -0.067;

/// Parameters of the lubricant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Lubricant {
    /// eta_0, dynamic viscosity at the inlet, Pa s.
    pub viscosity: f64,
    /// Pressure-viscosity coefficient, 1/Pa.
    pub pressure_viscosity: f64,
}

/// Heating of the oil by shear in the inlet of a contact, which thins the film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InletHeating {
    /// beta, relative decrease of the viscosity per kelvin, 1/K; about 0.04 for mineral oils.
    pub temperature_coefficient: f64,
    /// k, thermal conductivity of the oil, W/(m K); about 0.14 for mineral oils.
    pub conductivity: f64,
}

/// Film of the contacts, if any.
pub trait Film<T: Scalar>: Copy + Send + Sync + 'static {
    /// Returns true if there is a film. A constant of the type costs no instruction.
    fn is_present(&self) -> bool;
    /// Returns the constants of both contacts.
    fn constants(&self) -> FilmConstants<T>;
    /// Returns the constants of the heating of the inlet; none where the film is isothermal.
    #[inline(always)]
    fn heating(&self) -> Option<HeatingConstants<T>> {
        None
    }
}

/// No oil film.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dry;

/// Film of Hamrock and Dowson on both races.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HamrockDowson<T>(pub(super) FilmConstants<T>);

/// A film, isothermal or heated, or none, selected at run time: one compiled type serves all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectedFilm<T>(pub(super) Option<FilmConstants<T>>, pub(super) Option<HeatingConstants<T>>);

impl<T: Scalar> Film<T> for SelectedFilm<T> {
    #[inline(always)]
    fn is_present(&self) -> bool {
        self.0.is_some()
    }
    #[inline(always)]
    fn constants(&self) -> FilmConstants<T> {
        self.0.unwrap_or_default()
    }
    #[inline(always)]
    fn heating(&self) -> Option<HeatingConstants<T>> {
        self.1
    }
}

/// Film thickness at unit entrainment speed and load of both contacts, m, and half the pitch diameter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FilmConstants<T> {
    pub(super) inner: T,
    pub(super) outer: T,
    pub(super) orbit_radius: T,
    /// `FLOOR^-0.067`
    pub(super) at_floor: T,
    /// Deflections under the load `FLOOR`, m.
    pub(super) inner_floor: T,
    pub(super) outer_floor: T,
}

/// Constants of the heating of the inlet of both contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeatingConstants<T> {
    /// `eta_0 beta/k` times half the pitch diameter squared, s^2: L over the square of a speed in rad/s.
    by_speed: T,
    /// `13.2 (p/E')` over the root of the deflection, 1/sqrt(m).
    inner: T,
    outer: T,
}

/// Film of a contact at its speed.
#[derive(Debug, Clone, Copy)]
pub struct UnitFilm<L> {
    /// Thickness under a load of 1 N without the influence of the pressure, m.
    pub thickness: L,
    /// Share lost to the heating of the inlet over the root of the deflection, 1/sqrt(m); 0 for an isothermal film.
    pub loss: L,
}

impl<T: Scalar> Film<T> for Dry {
    #[inline(always)]
    fn is_present(&self) -> bool {
        false
    }
    #[inline(always)]
    fn constants(&self) -> FilmConstants<T> {
        FilmConstants::default()
    }
}

impl<T: Scalar> Film<T> for HamrockDowson<T> {
    #[inline(always)]
    fn is_present(&self) -> bool {
        true
    }
    #[inline(always)]
    fn constants(&self) -> FilmConstants<T> {
        self.0
    }
}

/// Returns the central film thickness, m: `2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 kappa)) R_x` (Hamrock and
/// Dowson). For set-up.
///
/// `along` is R_x, the radius of curvature along the rolling direction, m.
///
/// ```
/// use ballrace::bearing::quasi_static::film::{Lubricant, central_film};
/// // 0.04 Pa s and 2.2e-8 1/Pa between steel bodies, 2.94 m/s, 50 N: less than half a micrometre.
/// let oil = Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 };
/// let h = central_film(oil, 226e9, 2.9e-3, 9.08, 2.94, 50.0);
/// assert!(h > 0.4e-6 && h < 0.45e-6);
/// ```
#[must_use]
pub fn central_film(oil: Lubricant, modulus: f64, along: f64, ellipticity: f64, entrainment: f64, load: f64) -> f64 {
    film_constant(oil, modulus, along, ellipticity)
        * libm::pow(entrainment, BY_SPEED)
        * libm::pow(load.max(FLOOR), BY_LOAD)
}

/// Returns the share of an isothermal film that the heating of its inlet leaves, without sliding: `(1 - 13.2 (p/E')
/// L^0.42)/(1 + 0.213 L^0.64)` with `L = eta_0 beta u^2/k`, 0 or more (Gupta, Cheng, Zhu, Forster and Schrand 1992). For set-up.
///
/// ```
/// use ballrace::bearing::quasi_static::film::{InletHeating, thermal_reduction};
/// // 0.1 Pa s at 20 m/s, 1 GPa between steel bodies: less than half of the isothermal film is left.
/// let oil = InletHeating { temperature_coefficient: 0.04, conductivity: 0.14 };
/// let left = thermal_reduction(0.1, oil, 20.0, 1e9 / 226e9);
/// assert!(left > 0.4 && left < 0.5);
/// ```
#[must_use]
pub fn thermal_reduction(viscosity: f64, oil: InletHeating, entrainment: f64, pressure_over_modulus: f64) -> f64 {
    let parameter = viscosity * oil.temperature_coefficient * entrainment * entrainment / oil.conductivity;
    let by_pressure = PRESSURE_FACTOR * pressure_over_modulus * libm::pow(parameter, PRESSURE_POWER);
    ((1.0 - by_pressure) / (1.0 + HEATING_FACTOR * libm::pow(parameter, HEATING_POWER))).max(0.0)
}

/// Returns `A` in `h_c = A u^0.67 Q^-0.067`, SI units: [`central_film`] at unit speed and load.
pub(super) fn film_constant(oil: Lubricant, modulus: f64, along: f64, ellipticity: f64) -> f64 {
    let speed = libm::pow(oil.viscosity / (modulus * along), BY_SPEED);
    let material = libm::pow(oil.pressure_viscosity * modulus, 0.53);
    let load = libm::pow(1.0 / (modulus * along * along), BY_LOAD);
    2.69 * along * speed * material * load * (1.0 - 0.61 * libm::exp(-0.73 * ellipticity))
}

/// Returns the minimum film thickness, m: `3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 kappa)) R_x` (Hamrock and Dowson).
/// For set-up.
#[must_use]
pub fn minimum_film(oil: Lubricant, contact: &PointContact, along: f64, entrainment: f64, load: f64) -> f64 {
    let modulus = contact.effective_modulus;
    let u = oil.viscosity * entrainment / (modulus * along);
    let g = oil.pressure_viscosity * modulus;
    let w = load.max(FLOOR) / (modulus * along * along);
    let shape = 1.0 - libm::exp(-0.68 * contact.ellipticity);
    3.63 * along * libm::pow(u, 0.68) * libm::pow(g, 0.49) * libm::pow(w, -0.073) * shape
}

impl<T: Scalar> FilmConstants<T> {
    /// Creates the constants of both contacts, computed in `f64` and rounded once.
    pub(super) fn new(oil: Lubricant, inner: (&PointContact, f64), outer: (&PointContact, f64), pitch: f64) -> Self {
        let constant = |(c, along): (&PointContact, f64)| {
            T::from_f64(film_constant(oil, c.effective_modulus, along, c.ellipticity))
        };
        Self {
            inner: constant(inner),
            outer: constant(outer),
            orbit_radius: T::from_f64(0.5 * pitch),
            at_floor: T::from_f64(libm::pow(FLOOR, BY_LOAD)),
            inner_floor: T::from_f64(libm::pow(FLOOR / inner.0.stiffness, 2.0 / 3.0)),
            outer_floor: T::from_f64(libm::pow(FLOOR / outer.0.stiffness, 2.0 / 3.0)),
        }
    }

    /// Returns the isothermal film on both races at the speeds `w_c - w_o` and `w_i - w_c`.
    #[inline(always)]
    pub(super) fn at_speed<M: Math<T>, const K: usize>(
        &self,
        outer_speed: Lanes<T, K>,
        inner_speed: Lanes<T, K>,
    ) -> (UnitFilm<Lanes<T, K>>, UnitFilm<Lanes<T, K>>) {
        let radius = Lanes::splat(self.orbit_radius);
        let loss = Lanes::splat(T::ZERO);
        let at = |constant: T, speed: Lanes<T, K>| {
            let by_speed = (speed.abs() * radius).powf::<M>(T::from_f64(BY_SPEED));
            UnitFilm { thickness: Lanes::splat(constant) * by_speed, loss }
        };
        (at(self.outer, outer_speed), at(self.inner, inner_speed))
    }
}

impl<T: Scalar> HeatingConstants<T> {
    /// Creates the constants of both contacts, computed in `f64` and rounded once.
    pub(super) fn new(
        viscosity: f64,
        oil: InletHeating,
        inner: &PointContact,
        outer: &PointContact,
        pitch: f64,
    ) -> Self {
        // p ~ Q^(1/3) and Q = K delta^1.5
        let constant = |c: &PointContact| {
            let pressure = c.ellipse(1.0).2 * libm::cbrt(c.stiffness);
            T::from_f64(PRESSURE_FACTOR * pressure / c.effective_modulus)
        };
        let by_speed = viscosity * oil.temperature_coefficient / oil.conductivity * 0.25 * pitch * pitch;
        Self { by_speed: T::from_f64(by_speed), inner: constant(inner), outer: constant(outer) }
    }

    /// Returns what the heating at the speeds `w_c - w_o` and `w_i - w_c` leaves of the films on both races.
    #[inline(always)]
    pub(super) fn heated<M: Math<T>, const K: usize>(
        &self,
        (outer, outer_speed): (UnitFilm<Lanes<T, K>>, Lanes<T, K>),
        (inner, inner_speed): (UnitFilm<Lanes<T, K>>, Lanes<T, K>),
    ) -> (UnitFilm<Lanes<T, K>>, UnitFilm<Lanes<T, K>>) {
        let one = Lanes::splat(T::ONE);
        let left = |film: UnitFilm<Lanes<T, K>>, constant: T, speed: Lanes<T, K>| {
            let parameter = Lanes::splat(self.by_speed) * speed * speed;
            let hot = Lanes::splat_f64(HEATING_FACTOR) * parameter.powf::<M>(T::from_f64(HEATING_POWER));
            let loss = Lanes::splat(constant) * parameter.powf::<M>(T::from_f64(PRESSURE_POWER));
            UnitFilm { thickness: film.thickness / (one + hot), loss }
        };
        (left(outer, self.outer, outer_speed), left(inner, self.inner, inner_speed))
    }
}

/// Deflection of a contact with a film.
#[derive(Clone, Copy)]
pub struct FilmContact<L> {
    /// Elastic deflection `approach + h`, m; negative without contact.
    pub deflection: L,
    /// d(deflection)/d(approach).
    pub slope: L,
    /// h, film thickness, m.
    pub film: L,
}

/// Performs a Newton step on `d - h(Q(d)) = approach` from the deflection `before`; `floor` is the deflection under
/// [`FLOOR`]. With `heated` the film is `h(Q) (1 - loss sqrt(d))`, 0 or more.
///
/// The left side is increasing and concave in `d`, so that the steps converge from below.
#[inline(always)]
pub(super) fn film_newton_step<T: Scalar, M: Math<T>, const K: usize>(
    constants: &FilmConstants<T>,
    (unit, heated): (UnitFilm<Lanes<T, K>>, bool),
    (stiffness, floor): (Lanes<T, K>, Lanes<T, K>),
    approach: Lanes<T, K>,
    before: Lanes<T, K>,
) -> FilmContact<Lanes<T, K>> {
    let one = Lanes::splat(T::ONE);
    let d = before.larger(floor);
    let root = d.sqrt::<M>();
    let load = stiffness * d * root;
    let mut film = unit.thickness * load.powf::<M>(T::from_f64(BY_LOAD));
    // A film so thick that the load stays below the floor has a closed solution.
    let mut thickest = unit.thickness * Lanes::splat(constants.at_floor);
    // h ~ d^-0.1005
    let mut steepness = Lanes::splat_f64(-1.5 * BY_LOAD) * film / d;
    if heated {
        let zero = Lanes::splat(T::ZERO);
        let left = (one - unit.loss * root).positive();
        let by_loss = Lanes::splat(T::HALF) * unit.loss * film / root;
        steepness = steepness * left + Lanes::select(zero.less_than(left), by_loss, zero);
        film = film * left;
        thickest = thickest * (one - unit.loss * floor.sqrt::<M>()).positive();
    }
    let slope = one / (one + steepness);
    let after = d + (approach + film - d) * slope;
    let light = approach + thickest;
    let is_light = light.less_than(floor);
    FilmContact {
        deflection: Lanes::select(is_light, light, after.larger(floor)),
        slope: Lanes::select(is_light, one, slope),
        film: Lanes::select(is_light, thickest, film),
    }
}
