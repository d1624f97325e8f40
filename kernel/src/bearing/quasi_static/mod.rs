//! Model `quasi-static`: every ball in equilibrium between two rings (`docs/src/models.md#quasi-static-bearing`).
//!
//! Two unknowns per ball, the position of its centre in its plane. Hertz contact on both races; the type parameters select
//! [`inertia`] (centrifugal force, gyroscopic moment), [`film`] and [`super::surface`]. An effect that is not selected
//! costs no instruction.
//!
//! Source: Jones 1960, Journal of Basic Engineering 82; with oil film, waviness and both race speeds after Wang, Han and Zhou,
//! Mechanical Systems and Signal Processing 85 (2017).

mod ball;
mod bearing;
mod elements;
pub mod film;
pub mod inertia;
mod solver;
mod tangent;
mod two_precisions;

pub(in crate::bearing) use ball::Matrix;
pub use elements::{BallPosition, BallState, RingReactions};
pub(in crate::bearing) use tangent::contact_tangents;

use self::ball::{Ball, BallConstants};
use self::film::{Dry, FilmConstants, HamrockDowson, HeatingConstants, InletHeating, Lubricant, SelectedFilm};
use self::inertia::{
    BallInertia, Centrifugal, FrictionSharing, Gyroscopic, InertiaEffects, InertiaParams, Massless, OuterControlled,
    RaceControl, SelectedInertia,
};
use super::angular::DisplacementDatum;
use super::geometry::{BallBearingGeometry, InvalidParameter, check};
use super::surface::{Smooth, Surface};
use crate::contact::hertz::{PointContact, Race, in_series};
use crate::math::lanes::Plane;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Newton steps of a cold start. Twice as many make one more ball in a hundred converge, and only in extreme states.
pub const DEFAULT_NEWTON_STEPS: u8 = 8;

/// A ball bearing with every ball in equilibrium, with the inertia `I`, the film `F` and the surfaces `S`.
///
/// Cost per ball: an initial value, a fixed number of Newton steps and one evaluation, independent of the state.
///
/// ```
/// use ballrace::bearing::angular::DisplacementDatum;
/// use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
/// use ballrace::bearing::quasi_static::QuasiStatic;
/// use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
/// use ballrace::bearing::{Bearing, evenly_spaced};
/// use ballrace::{Displacement, Exact, BearingKinematicState, Phase};
///
/// // The 218 bearing of Harris, displaced by 0.0330 mm at 6000 rpm, carries 17.8 kN.
/// let geometry = BallBearingGeometry {
///     ball_diameter: 22.23e-3,
///     pitch_diameter: 125.26e-3,
///     inner_conformity: 11.63 / 22.23,
///     outer_conformity: 11.63 / 22.23,
///     contact_angle: 40_f64.to_radians(),
///     ball: ballrace::contact::hertz::Material { youngs_modulus: 206.91e9, ..BEARING_STEEL },
///     race: ballrace::contact::hertz::Material { youngs_modulus: 206.91e9, ..BEARING_STEEL },
/// };
/// let inertia = InertiaParams {
///     density: 7800.0,
///     centrifugal: true,
///     gyroscopic: true,
///     race_control: RaceControl::Outer,
///     friction_sharing: FrictionSharing::Outer,
/// };
/// let positions = evenly_spaced::<f64, 16>(Phase::ZERO);
/// let bearing = QuasiStatic::<f64, Exact, _>::try_new(geometry, positions, DisplacementDatum::Touching)?.with_inertia(&inertia)?;
/// let turning = BearingKinematicState { inner_speed: 6000.0 * std::f64::consts::TAU / 60.0, ..BearingKinematicState::default() };
/// let pushed = Displacement { w: 32.9819e-6, ..Displacement::default() };
/// let force = bearing.reaction(&pushed, &turning).wrench;
/// assert!((force.fz / -17_800.0 - 1.0).abs() < 1e-5);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct QuasiStatic<T, M, P, I = Massless, F = Dry, S = Smooth> {
    positions: P,
    /// R_i and R_o, m.
    inner_arm: T,
    outer_arm: T,
    /// Radial displacement of the inner groove centres at zero displacement, m.
    offset: T,
    ball: Ball<T, M, I, F>,
    geometry: BallBearingGeometry,
    surface: S,
    newton_steps: u8,
}

/// Result of a constructor that adds an effect.
pub type QuasiStaticResult<T, M, P, I, F, S> = Result<QuasiStatic<T, M, P, I, F, S>, InvalidParameter>;

impl<T: Scalar, M, P> QuasiStatic<T, M, P> {
    /// Creates a bearing with balls without mass and film on ideal surfaces; Hertz stiffness at the free contact angle. For
    /// set-up.
    ///
    /// # Errors
    /// As [`BallBearingGeometry::checked`].
    pub fn try_new(
        geometry: BallBearingGeometry,
        positions: P,
        datum: DisplacementDatum,
    ) -> Result<Self, InvalidParameter> {
        let geometry = geometry.checked()?;
        Ok(Self {
            positions,
            inner_arm: T::from_f64(geometry.inner_groove_radius()),
            outer_arm: T::from_f64(geometry.outer_groove_radius()),
            offset: T::from_f64(offset(&geometry, datum)),
            ball: Ball { constants: ball_constants(&geometry, datum), inertia: Massless, film: Dry, math: PhantomData },
            geometry,
            surface: Smooth,
            newton_steps: DEFAULT_NEWTON_STEPS,
        })
    }
}

/// Returns `-A (1 - cos(alpha_0))`, half the clearance, for centred rings.
fn offset(geometry: &BallBearingGeometry, datum: DisplacementDatum) -> f64 {
    match datum {
        DisplacementDatum::Touching => 0.0,
        DisplacementDatum::Centred => {
            let half = libm::sin(0.5 * geometry.contact_angle);
            -2.0 * geometry.groove_distance() * half * half
        }
    }
}

fn ball_constants<T: Scalar>(geometry: &BallBearingGeometry, datum: DisplacementDatum) -> BallConstants<T> {
    let d = geometry.ball_diameter;
    let (inner, outer) = (geometry.contact(Race::Inner).stiffness, geometry.contact(Race::Outer).stiffness);
    let (l_i, l_o) = ((geometry.inner_conformity - 0.5) * d, (geometry.outer_conformity - 0.5) * d);
    let axis = match datum {
        DisplacementDatum::Touching => (libm::cos(geometry.contact_angle), libm::sin(geometry.contact_angle)),
        DisplacementDatum::Centred => (1.0, 0.0),
    };
    let compliance = |k: f64| libm::pow(k, -2.0 / 3.0);
    let number = T::from_f64;
    BallConstants {
        inner_stiffness: number(inner),
        outer_stiffness: number(outer),
        inner_length: number(l_i),
        outer_length: number(l_o),
        axis: Plane { r: number(axis.0), z: number(axis.1) },
        ratio: number(d / geometry.pitch_diameter),
        inner_couple: number(geometry.inner_conformity * d / geometry.inner_groove_radius()),
        outer_couple: number(geometry.outer_conformity * d / geometry.outer_groove_radius()),
        distance: number(l_i + l_o),
        series: number(in_series(inner, outer)),
        outer_share: number(compliance(outer) / (compliance(outer) + compliance(inner))),
        max_step: number(0.4 * l_i.min(l_o)),
        min_length: number(1e-12 * (l_i + l_o)),
    }
}

/// Returns the contact and its radius of curvature along the rolling direction, R_x.
fn rolling_contact(geometry: &BallBearingGeometry, race: Race) -> (PointContact, f64) {
    let gamma = geometry.gamma();
    let along = match race {
        Race::Inner => 0.5 * geometry.ball_diameter * (1.0 - gamma),
        Race::Outer => 0.5 * geometry.ball_diameter * (1.0 + gamma),
    };
    (geometry.contact(race), along)
}

/// Precomputed constants of a [`super::tabulated::Tabulated`] bearing, besides positions and table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableConstants<T> {
    /// Lever of the friction couple divided by the lever arm.
    pub couple: T,
    /// A, m.
    pub distance: T,
    /// Direction of the line of groove centres with the rings just touching the ball: cosine and sine.
    pub axis: [T; 2],
    /// Radial displacement of the inner groove centres at zero displacement, m.
    pub offset: T,
    /// R_i, lever arm, m.
    pub arm: T,
}

impl<S: Scalar> TableConstants<S> {
    /// Returns the constants in another precision, rounded once.
    #[must_use]
    pub fn rounded<T: Scalar>(&self) -> TableConstants<T> {
        let rounded = |x: S| T::from_f64(x.to_f64());
        TableConstants {
            couple: rounded(self.couple),
            distance: rounded(self.distance),
            axis: self.axis.map(rounded),
            offset: rounded(self.offset),
            arm: rounded(self.arm),
        }
    }
}

impl<M, P, I, F, S> QuasiStatic<f64, M, P, I, F, S> {
    /// Returns the constants of a table of this bearing.
    #[must_use]
    pub fn table_constants(&self) -> TableConstants<f64> {
        let constants = &self.ball.constants;
        let axis = [constants.axis.r, constants.axis.z];
        TableConstants {
            couple: constants.inner_couple,
            distance: constants.distance,
            axis,
            offset: self.offset,
            arm: self.inner_arm,
        }
    }
}

impl<T: Scalar, M, P, I, F, S> QuasiStatic<T, M, P, I, F, S> {
    fn with_ball<J, G>(self, ball: Ball<T, M, J, G>) -> QuasiStatic<T, M, P, J, G, S> {
        QuasiStatic {
            positions: self.positions,
            inner_arm: self.inner_arm,
            outer_arm: self.outer_arm,
            offset: self.offset,
            ball,
            geometry: self.geometry,
            surface: self.surface,
            newton_steps: self.newton_steps,
        }
    }

    fn with_loads<J>(self, inertia: J) -> QuasiStatic<T, M, P, J, F, S>
    where
        F: Copy,
    {
        let Ball { constants, film, math, .. } = self.ball;
        self.with_ball(Ball { constants, inertia, film, math })
    }

    /// Returns the bearing with the inertia of its balls: `m_b (d_m/2) w_c^2` outward, and the gyroscopic moment, as
    /// `params` selects. [`QuasiStatic::with_centrifugal`] is cheaper without a gyroscopic moment.
    ///
    /// # Errors
    /// A density below 0 or not finite.
    pub fn with_inertia(self, params: &InertiaParams) -> QuasiStaticResult<T, M, P, Gyroscopic<T>, F, S>
    where
        F: Copy,
    {
        let constants = self.inertia_constants(params)?;
        Ok(self.with_loads(Gyroscopic(constants)))
    }

    /// Returns the bearing with centrifugal force and gyroscopic moment under outer race control, with all friction at the
    /// outer race; ignores control and sharing in `params`. Same results as [`QuasiStatic::with_inertia`], a quarter
    /// cheaper.
    ///
    /// # Errors
    /// A density below 0 or not finite.
    pub fn with_outer_control(self, params: &InertiaParams) -> QuasiStaticResult<T, M, P, OuterControlled<T>, F, S>
    where
        F: Copy,
    {
        let by_outer =
            InertiaParams { race_control: RaceControl::Outer, friction_sharing: FrictionSharing::Outer, ..*params };
        let constants = self.inertia_constants(&by_outer)?;
        Ok(self.with_loads(OuterControlled(constants)))
    }

    /// Returns the bearing with the centrifugal force of its balls; ignores the gyroscopic moment in `params`.
    ///
    /// # Errors
    /// A density below 0 or not finite.
    pub fn with_centrifugal(self, params: &InertiaParams) -> QuasiStaticResult<T, M, P, Centrifugal<T>, F, S>
    where
        F: Copy,
    {
        let constants = self.inertia_constants(params)?;
        Ok(self.with_loads(Centrifugal(constants)))
    }

    /// Returns the bearing with the inertia loads of `params`, selected at run time: one compiled type serves all. The
    /// results equal, bit for bit, those without inertia, of [`QuasiStatic::with_outer_control`] or of
    /// [`QuasiStatic::with_inertia`], whichever is the cheapest that applies.
    ///
    /// # Errors
    /// A density below 0 or not finite.
    pub fn with_selected_inertia(self, params: &InertiaParams) -> QuasiStaticResult<T, M, P, SelectedInertia<T>, F, S>
    where
        F: Copy,
    {
        let by_outer = params.race_control == RaceControl::Outer && params.friction_sharing == FrictionSharing::Outer;
        let effects = match (params.centrifugal, params.gyroscopic) {
            (false, false) => return Ok(self.with_loads(SelectedInertia::none())),
            (true, true) if by_outer => InertiaEffects::OUTER_CONTROLLED,
            _ => InertiaEffects::GYROSCOPIC,
        };
        let ball = self.inertia_constants(params)?;
        Ok(self.with_loads(SelectedInertia { effects, ball }))
    }

    fn inertia_constants(&self, params: &InertiaParams) -> Result<BallInertia<T>, InvalidParameter> {
        check(params.density >= 0.0, "density", params.density, "0 kg/m^3 or more")?;
        Ok(params.constants(self.geometry.ball_diameter, self.geometry.pitch_diameter))
    }

    /// Returns the bearing with an oil film in both contacts of each ball.
    ///
    /// # Errors
    /// A viscosity or pressure-viscosity coefficient that is not above 0.
    pub fn with_film(self, oil: Lubricant) -> QuasiStaticResult<T, M, P, I, HamrockDowson<T>, S>
    where
        I: Copy,
    {
        let film = HamrockDowson(self.film_constants(oil)?);
        Ok(self.with_contacts(film))
    }

    /// Returns the bearing with or without an oil film and the heating of its inlet, selected at run time: one compiled type
    /// serves all. Without heating the results equal, bit for bit, those of [`QuasiStatic::with_film`] and of the bearing
    /// without film.
    ///
    /// # Errors
    /// As [`QuasiStatic::with_film`], and a temperature coefficient or conductivity that is not above 0.
    pub fn with_selected_film(
        self,
        oil: Option<(Lubricant, Option<InletHeating>)>,
    ) -> QuasiStaticResult<T, M, P, I, SelectedFilm<T>, S>
    where
        I: Copy,
    {
        let constants = oil.map(|(oil, _)| self.film_constants(oil)).transpose()?;
        let heated = oil.and_then(|(oil, heating)| heating.map(|heating| self.heating_constants(oil, heating)));
        let film = SelectedFilm(constants, heated.transpose()?);
        Ok(self.with_contacts(film))
    }

    fn with_contacts<G>(self, film: G) -> QuasiStatic<T, M, P, I, G, S>
    where
        I: Copy,
    {
        let Ball { constants, inertia, math, .. } = self.ball;
        self.with_ball(Ball { constants, inertia, film, math })
    }

    fn film_constants(&self, oil: Lubricant) -> Result<FilmConstants<T>, InvalidParameter> {
        check(oil.viscosity > 0.0, "viscosity", oil.viscosity, "above 0 Pa s")?;
        check(oil.pressure_viscosity > 0.0, "pressure_viscosity", oil.pressure_viscosity, "above 0 1/Pa")?;
        let ((inner, inner_along), (outer, outer_along)) =
            (rolling_contact(&self.geometry, Race::Inner), rolling_contact(&self.geometry, Race::Outer));
        let pitch = self.geometry.pitch_diameter;
        Ok(FilmConstants::new(oil, (&inner, inner_along), (&outer, outer_along), pitch))
    }

    fn heating_constants(&self, oil: Lubricant, of: InletHeating) -> Result<HeatingConstants<T>, InvalidParameter> {
        let InletHeating { temperature_coefficient, conductivity } = of;
        check(temperature_coefficient > 0.0, "temperature_coefficient", temperature_coefficient, "above 0 1/K")?;
        check(conductivity > 0.0, "conductivity", conductivity, "above 0 W/(m K)")?;
        let [inner, outer] = [Race::Inner, Race::Outer].map(|race| self.geometry.contact(race));
        Ok(HeatingConstants::new(oil.viscosity, of, &inner, &outer, self.geometry.pitch_diameter))
    }

    /// Returns the bearing with surface deviations.
    pub fn with_surface<R: Surface<T>>(self, surface: R) -> QuasiStatic<T, M, P, I, F, R> {
        QuasiStatic {
            positions: self.positions,
            inner_arm: self.inner_arm,
            outer_arm: self.outer_arm,
            offset: self.offset,
            ball: self.ball,
            geometry: self.geometry,
            surface,
            newton_steps: self.newton_steps,
        }
    }

    /// Returns the bearing with another number of Newton steps: a trade-off between speed and accuracy.
    #[must_use]
    pub fn with_newton_steps(self, newton_steps: u8) -> Self {
        Self { newton_steps, ..self }
    }
}
