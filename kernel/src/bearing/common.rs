//! The common bearings with the exact math backend and `N` elements at any positions.
//!
//! Every alias is a plain name for a generic type: all constructors and methods of that type are called through it. Other
//! math backends, layouts and storages need the generic types.

use super::ElementPositions;
use super::angular::Angular;
use super::lumped::{Axial, Combined, Radial};
use super::quasi_static::QuasiStatic;
use super::quasi_static::film::HamrockDowson;
use super::quasi_static::inertia::OuterControlled;
use super::roller::{Lamina, LaminaRoller, QuasiStaticRoller};
use super::tabulated::{Node, Tabulated};
use crate::contact::law::{LineContactLaw, PointContactLaw};
use crate::math::Exact;

/// A radial ball bearing with one stiffness for all contacts. Constructor: [`Radial::try_new`].
///
/// ```
/// use ballrace::bearing::{Bearing, evenly_spaced};
/// use ballrace::contact::law::PointContactLaw;
/// use ballrace::{Displacement, LumpedRadial, Phase};
///
/// let bearing = LumpedRadial::<f32, 8>::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness: 8e9 }, 1e-6)?;
/// let u = Displacement { u: 2e-6, ..Displacement::default() };
/// assert!(bearing.reaction(&u, &Phase::ZERO.into()).wrench.fx < 0.0);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub type LumpedRadial<T, const N: usize> = Radial<T, Exact, PointContactLaw<T>, ElementPositions<T, N>>;

/// A thrust ball bearing with one stiffness for all contacts. Constructor: [`Axial::try_new`].
pub type LumpedAxial<T, const N: usize> = Axial<T, Exact, PointContactLaw<T>, ElementPositions<T, N>>;

/// Separate radial and axial ball contacts: `Combined(radial, axial)`.
pub type LumpedRadialAxial<T, const N: usize> = Combined<LumpedRadial<T, N>, LumpedAxial<T, N>>;

/// A radial roller bearing with one stiffness for all line contacts. Constructor: [`Radial::try_new`].
pub type LumpedRoller<T, const N: usize> = Radial<T, Exact, LineContactLaw<T>, ElementPositions<T, N>>;

/// A deep-groove ball bearing whose contact angles follow the displacement. Constructor: [`Angular::try_new`] with
/// [`DisplacementDatum::Centred`](super::angular::DisplacementDatum::Centred).
///
/// ```
/// use ballrace::bearing::angular::DisplacementDatum;
/// use ballrace::bearing::evenly_spaced;
/// use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
/// use ballrace::{DeepGroove, Phase};
///
/// let geometry = BallBearingGeometry {
///     ball_diameter: 7.94e-3,
///     pitch_diameter: 39.04e-3,
///     inner_conformity: 0.52,
///     outer_conformity: 0.52,
///     contact_angle: 0.0,
///     ball: BEARING_STEEL,
///     race: BEARING_STEEL,
/// };
/// let geometry = geometry.with_clearance(10e-6)?;
/// let bearing = DeepGroove::<f32, 9>::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?;
/// # let _ = bearing;
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub type DeepGroove<T, const N: usize> = Angular<T, Exact, ElementPositions<T, N>>;

/// An angular-contact ball bearing whose contact angles follow the displacement. Constructor: [`Angular::try_new`] with
/// [`DisplacementDatum::Touching`](super::angular::DisplacementDatum::Touching).
pub type AngularContact<T, const N: usize> = Angular<T, Exact, ElementPositions<T, N>>;

/// A ball bearing with every ball in quasi-static equilibrium, without inertia and film. Constructor:
/// [`QuasiStatic::try_new`]; its methods `with_...` add effects.
pub type QuasiStaticBearing<T, const N: usize> = QuasiStatic<T, Exact, ElementPositions<T, N>>;

/// A [`QuasiStaticBearing`] with centrifugal force and gyroscopic moment under outer race control. Constructor:
/// [`QuasiStatic::with_outer_control`].
pub type HighSpeedBearing<T, const N: usize> = QuasiStatic<T, Exact, ElementPositions<T, N>, OuterControlled<T>>;

/// A [`HighSpeedBearing`] with an oil film in all contacts. Constructor: [`QuasiStatic::with_film`].
///
/// ```
/// use ballrace::bearing::angular::DisplacementDatum;
/// use ballrace::bearing::evenly_spaced;
/// use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
/// use ballrace::bearing::quasi_static::film::Lubricant;
/// use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
/// use ballrace::{HighSpeedBearing, LubricatedBearing, Phase, QuasiStaticBearing};
///
/// let geometry = BallBearingGeometry {
///     ball_diameter: 7e-3,
///     pitch_diameter: 38.5e-3,
///     inner_conformity: 0.52,
///     outer_conformity: 0.52,
///     contact_angle: 25_f64.to_radians(),
///     ball: BEARING_STEEL,
///     race: BEARING_STEEL,
/// };
/// let inertia = InertiaParams {
///     density: 7800.0,
///     centrifugal: true,
///     gyroscopic: true,
///     race_control: RaceControl::Outer,
///     friction_sharing: FrictionSharing::Outer,
/// };
/// let oil = Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 };
/// let positions = evenly_spaced(Phase::ZERO);
/// let static_balls = QuasiStaticBearing::<f64, 16>::try_new(geometry, positions, DisplacementDatum::Touching)?;
/// let moving_balls: HighSpeedBearing<f64, 16> = static_balls.with_outer_control(&inertia)?;
/// let lubricated: LubricatedBearing<f64, 16> = moving_balls.with_film(oil)?;
/// # let _ = lubricated;
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub type LubricatedBearing<T, const N: usize> =
    QuasiStatic<T, Exact, ElementPositions<T, N>, OuterControlled<T>, HamrockDowson<T>>;

/// A quasi-static ball bearing read from a table in flash with `F` numbers per node: 2, or 3 with friction at the inner race.
/// Constructor: [`Tabulated::new`], usually in the output of `ballrace bake`.
pub type TabulatedBearing<T, const N: usize, const F: usize = 3> =
    Tabulated<T, Exact, ElementPositions<T, N>, &'static [Node<T, F>], F>;

/// A bearing with `N` rollers of `K` laminae, both contacts in series. Constructor: [`LaminaRoller::try_new`].
pub type RollerBearing<T, const N: usize, const K: usize> =
    LaminaRoller<T, Exact, ElementPositions<T, N>, [Lamina<T>; K]>;

/// A cylindrical roller bearing with each of its `N` rollers of `K` laminae in equilibrium. Constructor:
/// [`QuasiStaticRoller::try_new`].
pub type QuasiStaticRollerBearing<T, const N: usize, const K: usize> =
    QuasiStaticRoller<T, Exact, ElementPositions<T, N>, [Lamina<T>; K]>;
