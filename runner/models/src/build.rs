//! Conversion of a scene to kernel types.

mod balls;
mod error;
mod kinematics;
mod lumped;
mod preload;
mod service_load;

pub use balls::{
    DESKTOP_TABLE, ElementContact, FIRMWARE_TABLE, Solved, TableData, TableSize, inertia_params, of_table,
    point_contact_approach, point_contact_load, quasi_static, solved_in, static_limit, table,
};
pub use error::BuildError;
use kinematics::outer_ratio;
pub use kinematics::{Kinematics, element_azimuth, kinematics, kinematics_of, rolling_speed, rotation_at};
pub use lumped::{Exponent, law};
pub use preload::{loaded, preload_force, preload_offset, preloaded};

use crate::handle::BearingHandle;
pub use crate::handle::{AnyBearing, AnyForceModel, Shared};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::{BallBearingGeometry, InvalidParameter};
use ballrace::bearing::linear::{Linear as LinearBearing, two_spring_ball};
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape, SurfaceDeviation, Wave};
use ballrace::bearing::{BLOCK_SIZE, Bearing as _, BlockedPositions, ElementBlock, ElementPosition};
use ballrace::contact::hertz::{Material, Race};
use ballrace::rotor::{MovingBallsParams, RotorParams, Support, Unbalance};
use ballrace::{Displacement, Exact, Math, Phase, Scalar, Stiffness, Wrench};
use ballrace_scene::{Bearing as BearingScene, DefectShape, Facing, FreeAngle, Linear, Model, Rotor, Scene, Surface};

/// Returns the kernel's geometry, where the scene has one.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn geometry(bearing: &BearingScene) -> Result<Option<BallBearingGeometry>, BuildError> {
    let Some(g) = bearing.geometry else { return Ok(None) };
    let steel = Material { youngs_modulus: g.youngs_modulus, poissons_ratio: g.poissons_ratio };
    let built = BallBearingGeometry {
        ball_diameter: g.ball_diameter,
        pitch_diameter: g.pitch_diameter,
        inner_conformity: g.inner_conformity,
        outer_conformity: g.outer_conformity,
        contact_angle: 0.0,
        ball: steel,
        race: steel,
    };
    let built = match g.fit {
        FreeAngle::ContactAngle(contact_angle) => BallBearingGeometry { contact_angle, ..built },
        FreeAngle::DiametralClearance(s) if s >= 0.0 => built.with_clearance(s).map_err(|e| named(bearing, e))?,
        // An interference fit: the balls sit at the bottom of the grooves.
        FreeAngle::DiametralClearance(_) => built,
    };
    Ok(Some(built.checked().map_err(|e| named(bearing, e))?))
}

/// Returns the error of a parameter that the kernel rejects, with the name of the bearing.
pub fn named(bearing: &BearingScene, error: InvalidParameter) -> BuildError {
    BuildError::Parameter { bearing: bearing.name.clone(), error }
}

/// Returns the error of a value of a bearing, or of a missing one.
fn invalid(bearing: &BearingScene, key: impl Into<String>, found: impl Into<String>, expected: &str) -> BuildError {
    BuildError::Value {
        bearing: bearing.name.clone(),
        key: key.into(),
        found: found.into(),
        expected: expected.to_owned(),
    }
}

/// Builds the model `model` of one bearing. A linear model derived from another one requires the rotor's equilibrium
/// (see `ballrace_plant`) and is rejected here.
///
/// # Errors
/// Returns an error if the scene lacks a value of this model or the kernel rejects one.
pub fn bearing(scene: &Scene, of: &BearingScene, model: Model) -> Result<AnyBearing<f64>, BuildError> {
    built::<f64, Exact, _>(scene, of, model)
}

/// Builds the force of the model `model` of one bearing, in any precision and with any math backend.
///
/// # Errors
/// As [`bearing`].
pub fn force_model<T: Scalar, M: Math<T>>(
    scene: &Scene,
    of: &BearingScene,
    model: Model,
) -> Result<AnyForceModel<T>, BuildError> {
    built::<T, M, _>(scene, of, model)
}

fn built<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &Scene,
    of: &BearingScene,
    model: Model,
) -> Result<H, BuildError> {
    match model {
        Model::Linear => linear(of),
        // The quasi-static limit of moving balls.
        Model::Lumped | Model::Dynamic => lumped::lumped::<T, M, H>(of),
        Model::Angular => angular::<T, M, H>(of),
        Model::QuasiStatic => balls::quasi_static_bearing::<T, M, H>(of),
        Model::Tabulated => balls::tabulated::<T, M, H>(scene, of),
    }
}

/// Returns the positions of the elements with the cage at angle 0, mirrored where the bearing faces -Z.
#[must_use]
pub fn places<T: Scalar>(scene: &BearingScene) -> Vec<ElementPosition<T>> {
    let mirror = |p: ElementPosition<T>| if scene.facing == Facing::MinusZ { p.mirrored() } else { p };
    (0..scene.elements).map(|j| place(scene, j)).map(mirror).collect()
}

/// Returns the positions of [`places`], also in SIMD blocks.
fn blocked_places<T: Scalar>(
    scene: &BearingScene,
) -> BlockedPositions<Vec<ElementPosition<T>>, Vec<ElementBlock<T, BLOCK_SIZE>>> {
    BlockedPositions::new(places(scene))
}

/// Returns the position of element `j` (0 is the first) with the cage at angle 0.
#[must_use]
pub fn place<T: Scalar>(scene: &BearingScene, j: usize) -> ElementPosition<T> {
    ElementPosition::from_azimuth(element_azimuth(scene, j))
}

/// Returns the bearing, rotated about X by pi where it faces -Z.
fn facing<T: Scalar, H: BearingHandle<T>>(scene: &BearingScene, bearing: H) -> H {
    if scene.facing == Facing::MinusZ { bearing.mirrored() } else { bearing }
}

/// Returns waviness and damage as features of the kernel.
#[must_use]
pub fn features<T: Scalar>(scene: &BearingScene) -> Vec<Feature<T>> {
    let waves = scene.waviness.iter().map(|w| {
        Feature::Wave(Wave {
            component: part(scene, w.surface),
            direction: if w.axial { Direction::Axial } else { Direction::Radial },
            order: w.order,
            amplitude: T::from_f64(w.amplitude),
            phase: Phase::from_radians(w.phase),
        })
    });
    let spalls = scene.defect.iter().map(|defect| {
        let shape = match defect.shape {
            DefectShape::HalfSine => SpallShape::HalfSine,
            DefectShape::Rectangular => SpallShape::Rectangular,
        };
        let centre = Phase::from_radians(defect.azimuth);
        let (half_width, depth) = (T::from_f64(defect.half_width), T::from_f64(defect.depth));
        Feature::Spall(Spall::new(part(scene, defect.surface), centre, half_width, depth, shape))
    });
    let mirror = |feature: Feature<T>| if scene.facing == Facing::MinusZ { feature.mirrored() } else { feature };
    waves.chain(spalls).map(mirror).collect()
}

fn part(scene: &BearingScene, surface: Surface) -> BearingComponent {
    match surface {
        Surface::Inner => BearingComponent::Inner,
        Surface::Outer => BearingComponent::Outer,
        Surface::Ball(j) => BearingComponent::Ball(place::<f64>(scene, j).azimuth()),
    }
}

/// Returns the surface deviations; `None` for a bearing without waviness and damage.
fn uneven<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Option<SurfaceDeviation<M, Vec<Feature<T>>>> {
    let features = features(scene);
    (!features.is_empty()).then(|| SurfaceDeviation::new(features))
}

fn angular<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &BearingScene) -> Result<H, BuildError> {
    let (geometry, zero) = contact_geometry(scene, "angular")?;
    let built = Angular::<T, M, _>::try_new(geometry, blocked_places(scene), zero).map_err(|e| named(scene, e))?;
    Ok(match uneven::<T, M>(scene) {
        None => facing(scene, H::dispatched(built)),
        Some(surface) => facing(scene, H::dispatched(built.with_surface(surface))),
    })
}

/// Returns the geometry of a model with a contact angle, and its displacement datum.
pub fn contact_geometry(
    scene: &BearingScene,
    model: &str,
) -> Result<(BallBearingGeometry, DisplacementDatum), BuildError> {
    let Some(geometry) = geometry(scene)? else {
        let keys = "ball_diameter, pitch_diameter, the conformities and contact_angle or diametral_clearance";
        return Err(invalid(scene, format!("model {model}"), "no geometry", keys));
    };
    if let Some(ballrace_scene::Geometry { fit: FreeAngle::DiametralClearance(s), .. }) = scene.geometry
        && s < 0.0
    {
        let expected = format!("0 or more with model {model}");
        return Err(invalid(scene, "diametral_clearance", format!("invalid value: {s} m"), &expected));
    }
    Ok((geometry, if scene.facing == Facing::Both { DisplacementDatum::Centred } else { DisplacementDatum::Touching }))
}

fn linear<T: Scalar, H: BearingHandle<T>>(scene: &BearingScene) -> Result<H, BuildError> {
    match &scene.linear {
        Some(Linear::Matrix(rows)) => {
            let k = Stiffness::from_fn(|i, j| T::from_f64(rows[i][j]));
            Ok(H::new(LinearBearing::new(k)))
        }
        Some(Linear::TwoSpring { static_load }) => {
            let Some(g) = geometry(scene)? else {
                return Err(invalid(scene, "two_spring", "no geometry", "ball_diameter and the others"));
            };
            let springs = two_spring_ball(scene.elements, g.ball_diameter, *static_load, g.contact_angle)
                .map_err(|e| named(scene, e))?;
            // Along the static load: gravity acts along Y.
            Ok(H::new(LinearBearing::new(springs.stiffness(std::f64::consts::FRAC_PI_2))))
        }
        Some(Linear::Of(_)) => Err(invalid(
            scene,
            "linearise",
            "a bearing taken alone",
            "a scene with a [rotor], at whose equilibrium it is linearised",
        )),
        None => Err(invalid(scene, "model linear", "no stiffness", "stiffness_matrix, two_spring or linearise")),
    }
}

/// Returns springs with the mean force and tangent of a bearing at the given states.
pub fn linearised(states: &[(Displacement<f64>, Wrench<f64>, Stiffness<f64>)]) -> AnyBearing<f64> {
    let weight = 1.0 / states.len().max(1) as f64;
    let (mut u, mut f, mut k) = ([0.0; 5], [0.0; 5], Stiffness::from_element(0.0));
    for (displacement, wrench, tangent) in states {
        for (sum, x) in u.iter_mut().zip(displacement.to_array()) {
            *sum += weight * x;
        }
        for (sum, x) in f.iter_mut().zip(wrench.to_array()) {
            *sum += weight * x;
        }
        k += tangent * weight;
    }
    AnyBearing::new(LinearBearing::about(k, Displacement::from_array(u), Wrench::from_array(f)))
}

/// Returns a spring bearing in any precision, from its tangent and its force at zero displacement.
pub fn spring_of<T: Scalar, H: BearingHandle<T>>(spring: &AnyBearing<f64>) -> H {
    let zero = Displacement::default();
    let (reaction, k) = spring.reaction_and_stiffness(&zero, &Phase::ZERO.into());
    let force = Wrench::from_array(reaction.wrench.to_array().map(T::from_f64));
    H::new(LinearBearing::about(k.map(T::from_f64), Displacement::default(), force))
}

/// Returns the parameters of the rotor.
#[must_use]
pub fn rotor_params(rotor: &Rotor) -> RotorParams {
    RotorParams {
        mass: rotor.mass,
        diametral_inertia: rotor.diametral_inertia,
        polar_inertia: rotor.polar_inertia,
        damping: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { rotor.damping[i] } else { 0.0 })),
        stiffness: rotor.stiffness,
        gravity: rotor.gravity,
        load: rotor.load,
    }
}

/// Returns the parameters of a support.
#[must_use]
pub fn support(support: &ballrace_scene::Support) -> Support {
    let ([x, y], cross, c) = (support.stiffness, support.cross_stiffness, support.damping);
    Support { mass: support.mass, stiffness: [[x, cross], [cross, y]], damping: [[c, 0.0], [0.0, c]] }
}

/// The moving balls of the `dynamic` model.
#[derive(Clone)]
pub struct Balls {
    /// Parameters of the kernel.
    pub params: MovingBallsParams,
    /// Damping of each ball's radial motion, N s/m.
    pub damping: f64,
    /// Positions at cage angle 0.
    pub places: Vec<ElementPosition<f64>>,
}

/// Returns the moving balls of a bearing with the `dynamic` model.
///
/// # Errors
/// Returns an error if the bearing has no geometry, from which mass and contact stiffness of the balls follow.
pub fn moving_balls(scene: &Scene, of: &BearingScene) -> Result<Balls, BuildError> {
    let Some(geometry) = geometry(of)? else {
        return Err(invalid(of, "model dynamic", "no geometry", "ball_diameter and the others"));
    };
    let gravity = scene.rotor.as_ref().map_or([0.0; 3], |r| r.gravity);
    let density = of.geometry.map_or(0.0, |g| g.density);
    let (_, _, radial_play) = law(of)?;
    Ok(Balls {
        params: MovingBallsParams {
            stiffness: [Race::Inner, Race::Outer].map(|race| geometry.contact(race).stiffness),
            pitch_radius: 0.5 * geometry.pitch_diameter,
            radial_play,
            ball_mass: density * std::f64::consts::PI / 6.0 * geometry.ball_diameter.powi(3),
            cage_ratio: kinematics(scene, of)?.cage_ratio,
            gravity: [gravity[0], gravity[1]],
        },
        damping: of.element_damping,
        places: places(of),
    })
}

/// Returns the unbalances of the rotor.
#[must_use]
pub fn unbalances(rotor: &Rotor) -> Vec<Unbalance> {
    let one = |u: &ballrace_scene::Unbalance| Unbalance { moment: u.moment, angle: u.angle, station: u.station };
    rotor.unbalance.iter().map(one).collect()
}

/// Returns the bearing of this name, or the only one.
///
/// # Errors
/// No bearing of this name, or several without a name given.
pub fn pick<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a BearingScene, BuildError> {
    let failed = || BuildError::Selection {
        file: scene.path.clone(),
        found: name.map(str::to_owned),
        names: scene.bearings.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", "),
    };
    match (name, scene.bearings.as_slice()) {
        (Some(name), all) => all.iter().find(|b| b.name == name).ok_or_else(failed),
        (None, [only]) => Ok(only),
        (None, _) => Err(failed()),
    }
}
