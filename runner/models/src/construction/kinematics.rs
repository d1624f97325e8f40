//! Kinematics of a mounted bearing: speeds of cage, balls and outer ring, orders, and azimuths of the elements.

use super::{BuildError, geometry};
use ballrace::bearing::ElementPosition;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::kinematics::{Orders, orders};
use ballrace::rotor::{ComponentAngles, SpeedRatios};
use ballrace::{BearingKinematicState, Phase};
use ballrace_scene::{Bearing as BearingScene, Scene, Speed};
use std::f64::consts::TAU;

/// Speeds of the parts of a bearing over the shaft speed, and its orders.
#[derive(Debug, Clone, Copy)]
pub struct Kinematics {
    /// Cage speed over shaft speed; 0 where nothing moves.
    pub cage_ratio: f64,
    /// Cage speed over shaft speed in pure rolling; `cage_ratio` where the geometry is not known.
    pub rolling_cage_ratio: f64,
    /// Orders per turn of the shaft.
    pub orders: Orders,
    /// True where the ball-spin order is known, which needs a geometry or the orders of a data sheet.
    pub spin_known: bool,
    /// Outer ring's speed over shaft speed.
    pub outer_ratio: f64,
}

impl Kinematics {
    /// Returns the ratios with which the kernel's rotor advances the parts; those of balls and outer ring only where they
    /// turn.
    #[must_use]
    pub fn speed_ratios(&self) -> SpeedRatios<f64> {
        let ratios = SpeedRatios::new(self.cage_ratio);
        let ratios = if self.spin_known { ratios.with_ball(self.ball_ratio()) } else { ratios };
        if self.outer_ratio == 0.0 { ratios } else { ratios.with_outer(self.outer_ratio) }
    }

    /// Returns the spin of the balls over the shaft speed: negative where the inner ring is the faster.
    #[must_use]
    pub fn ball_ratio(&self) -> f64 {
        -self.orders.ball_spin * (1.0 - self.outer_ratio).signum()
    }

    /// Returns the angles of the parts with the shaft at `revolutions` from its angle 0.
    #[must_use]
    pub fn parts_at(&self, revolutions: f64) -> ComponentAngles {
        let turned = |ratio: f64| Phase::from_revolutions(ratio * revolutions);
        ComponentAngles {
            cage: turned(self.cage_ratio),
            ball: turned(self.ball_ratio()),
            outer: turned(self.outer_ratio),
        }
    }
}

/// Cage speed as a weighted sum of the ring speeds, `w_c = inner w_i + outer w_o`.
///
/// Pure rolling gives `inner = (1 - gamma)/2` and `outer = (1 + gamma)/2` (Harris, Rolling Bearing Analysis). `cage_ratio` of
/// the scene is the cage speed over the shaft speed as it stands, whether or not the outer ring turns: `outer` is then 0.
struct CageSpeed {
    inner: f64,
    outer: f64,
}

impl CageSpeed {
    fn new(bearing: &BearingScene, rolling: Option<&Orders>) -> Self {
        match (bearing.cage_ratio, rolling) {
            (Some(given), _) => Self { inner: given, outer: 0.0 },
            (None, Some(rolling)) => Self { inner: rolling.cage, outer: 1.0 - rolling.cage },
            (None, None) => Self { inner: 0.0, outer: 0.0 },
        }
    }
}

/// Returns the speed of an element about the axis by pure rolling, in the unit of the ring speeds: `w_o + (w_i - w_o)(1 - gamma)/2` with
/// `gamma = D cos(alpha)/d_m`.
#[must_use]
pub fn rolling_speed(gamma: f64, inner_speed: f64, outer_speed: f64) -> f64 {
    outer_speed + 0.5 * (inner_speed - outer_speed) * (1.0 - gamma)
}

/// Returns the orders of pure rolling with the outer ring at rest, by the geometry of balls or rollers, by those of a bearing without model or by
/// the diameters of the catalogue.
fn rolling(bearing: &BearingScene, geometry: Option<BallBearingGeometry>) -> Option<Orders> {
    let of_geometry = |g: BallBearingGeometry| orders(bearing.elements, g.gamma(), g.ball_diameter / g.pitch_diameter);
    let of_catalogue = || {
        let entry = bearing.catalogue.as_ref()?.listed.entry;
        let ratio = entry.element_diameter / entry.pitch_diameter;
        let gamma = ratio * entry.contact_angle.to_radians().cos();
        // Orders of a roller's spin are not used.
        Some(Orders { ball_spin: 0.0, ..orders(bearing.elements, gamma, ratio) })
    };
    let of_rollers = || {
        let rollers = bearing.rollers.as_ref()?;
        Some(orders(bearing.elements, rollers.gamma(), rollers.diameter / rollers.pitch_diameter))
    };
    let without_model = || bearing.kinematics.map(|kinematics| kinematics.orders(bearing.elements));
    geometry.map(of_geometry).or_else(of_rollers).or_else(without_model).or_else(of_catalogue)
}

/// Returns the kinematics of a bearing: with the scene's `cage_ratio`, or by pure rolling at the free contact angle.
///
/// # Errors
/// An outer ring that turns under a shaft whose speed changes, because no ratio is then constant; a cage that is not slower
/// than the faster ring.
pub fn kinematics(scene: &Scene, bearing: &BearingScene) -> Result<Kinematics, BuildError> {
    kinematics_of(scene, bearing, geometry(bearing)?)
}

/// Returns the kinematics with another `geometry` than the bearing's own, such as one with the contact angle under load.
///
/// # Errors
/// As [`kinematics`].
pub fn kinematics_of(
    scene: &Scene,
    bearing: &BearingScene,
    geometry: Option<BallBearingGeometry>,
) -> Result<Kinematics, BuildError> {
    let n = bearing.elements as f64;
    let rolling = rolling(bearing, geometry);
    let spin = rolling
        .filter(|_| geometry.is_some() || bearing.rollers.is_some() || bearing.kinematics.is_some())
        .map(|o| o.ball_spin);
    let outer = outer_ratio(scene)?;
    let cage = CageSpeed::new(bearing, rolling.as_ref());
    let cage_ratio = cage.inner + outer * cage.outer;
    // A cage turns with a speed between those of the rings.
    if cage_ratio.abs() >= outer.abs().max(1.0) {
        return Err(BuildError::CageRatio {
            file: scene.path.clone(),
            bearing: bearing.name.clone(),
            found: cage_ratio,
        });
    }
    let orders = Orders {
        cage: cage_ratio,
        outer_race: n * (cage_ratio - outer).abs(),
        inner_race: n * (1.0 - cage_ratio).abs(),
        ball_spin: spin.unwrap_or(0.0) * (1.0 - outer).abs(),
    };
    let rolling_cage_ratio = rolling.map_or(cage_ratio, |o| o.cage + outer * (1.0 - o.cage));
    Ok(Kinematics { cage_ratio, rolling_cage_ratio, orders, spin_known: spin.is_some(), outer_ratio: outer })
}

pub fn outer_ratio(scene: &Scene) -> Result<f64, BuildError> {
    match (scene.shaft.outer_speed, scene.shaft.speed) {
        (0.0, _) => Ok(0.0),
        (outer, Speed::Constant(shaft)) if shaft != 0.0 => Ok(outer / shaft),
        _ => Err(BuildError::OuterSpeed { file: scene.path.clone(), found: scene.shaft.outer_speed }),
    }
}

/// Returns angles and speeds of a bearing's parts at `time` (s) of the scene, with all angles 0 at time 0. The shaft speed may
/// change while the outer ring turns.
///
/// # Errors
/// A geometry that the kernel rejects.
pub fn rotation_at(scene: &Scene, bearing: &BearingScene, time: f64) -> Result<BearingKinematicState<f64>, BuildError> {
    rotation(scene, bearing, (scene.shaft.speed.revolutions(time), scene.shaft.speed.at(time)), time)
}

/// Returns angles and speeds of a bearing's parts with the shaft at `inner` revolutions from its angle 0 and at `inner_speed`
/// (rad/s); the outer ring turns at the scene's speed from time 0 to `time` (s).
///
/// # Errors
/// A geometry that the kernel rejects.
pub fn rotation(
    scene: &Scene,
    bearing: &BearingScene,
    (inner, inner_speed): (f64, f64),
    time: f64,
) -> Result<BearingKinematicState<f64>, BuildError> {
    let outer_speed = scene.shaft.outer_speed;
    let outer = outer_speed * time / TAU;
    let rolling = rolling(bearing, geometry(bearing)?);
    let cage = CageSpeed::new(bearing, rolling.as_ref());
    let spin = rolling.map_or(0.0, |o| o.ball_spin);
    Ok(BearingKinematicState {
        cage: Phase::from_revolutions(cage.inner * inner + cage.outer * outer),
        inner: Phase::from_revolutions(inner),
        outer: Phase::from_revolutions(outer),
        ball: Phase::from_revolutions(-spin * (inner - outer)),
        inner_speed,
        outer_speed,
    })
}

/// Returns the azimuth of element `j` (0 is the first) with the cage at angle 0: from the scene's `element_azimuths`, else
/// evenly spaced, displaced by the cage run-out (`docs/src/models.md#cage-run-out`), which is constant in the cage frame.
#[must_use]
pub fn element_azimuth(bearing: &BearingScene, j: usize) -> Phase {
    let first = bearing.first_element_azimuth;
    let even = || ElementPosition::<f64>::evenly_spaced(Phase::from_radians(first), j, bearing.elements).azimuth();
    let azimuth = bearing.element_azimuths.get(j).map_or_else(even, |&a| Phase::from_radians(first + a));
    let runout = bearing.cage_runout.map_or(0.0, |r| -r.offset / r.radius * (azimuth.radians() - r.angle).sin());
    azimuth.wrapping_add(Phase::from_radians(runout))
}
