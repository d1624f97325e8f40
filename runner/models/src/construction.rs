//! Conversion of a scene to kernel types.

mod contact;
mod effects;
mod error;
mod kinematics;
pub(crate) mod service_load;
mod table;

pub(crate) use contact::PRESSURE_LIMIT;
pub use contact::{ElementContact, point_contact_approach, point_contact_load, static_limit};
pub use effects::{inertia_params, lubricant};
pub use error::BuildError;
pub(crate) use kinematics::outer_ratio;
pub use kinematics::{Kinematics, element_azimuth, kinematics, kinematics_of, rolling_speed, rotation, rotation_at};
pub use table::TableData;
pub(crate) use table::numbers;

use crate::handle::BearingHandle;
use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::{BallBearingGeometry, InvalidParameter};
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape, SurfaceDeviation, Wave};
use ballrace::bearing::{BLOCK_SIZE, BlockedPositions, ElementBlock, ElementPosition};
use ballrace::contact::hertz::Material;
use ballrace::rotor::{RotorParams, Support, Unbalance};
use ballrace::{Math, Phase, Scalar};
use ballrace_scene::{Bearing as BearingScene, DefectShape, Facing, FreeAngle, Rotor, Scene, Surface};

/// Checks that every bearing of a scene has a model of its forces.
///
/// # Errors
/// A bearing without model.
pub fn check_forces(scene: &Scene) -> Result<(), BuildError> {
    scene.bearings.iter().try_for_each(|bearing| check_has_forces(scene, bearing))
}

/// Checks that a bearing of a scene has a model of its forces.
///
/// # Errors
/// A bearing without model.
pub fn check_has_forces(scene: &Scene, bearing: &BearingScene) -> Result<(), BuildError> {
    match bearing.kinematics {
        Some(kinematics) => Err(BuildError::NoForces {
            file: scene.path.clone(),
            bearing: bearing.name.clone(),
            missing: kinematics.keys_of_forces(),
        }),
        None => Ok(()),
    }
}

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
pub(crate) fn invalid(
    bearing: &BearingScene,
    key: impl Into<String>,
    found: impl Into<String>,
    expected: &str,
) -> BuildError {
    BuildError::Value {
        bearing: bearing.name.clone(),
        key: key.into(),
        found: found.into(),
        expected: expected.to_owned(),
    }
}

/// Returns the positions of the elements with the cage at angle 0, mirrored where the bearing faces -Z.
#[must_use]
pub fn places<T: Scalar>(scene: &BearingScene) -> Vec<ElementPosition<T>> {
    let mirror = |p: ElementPosition<T>| if scene.facing == Facing::MinusZ { p.mirrored() } else { p };
    (0..scene.elements).map(|j| place(scene, j)).map(mirror).collect()
}

/// Returns the positions of [`places`], also in SIMD blocks.
pub(crate) fn blocked_places<T: Scalar>(
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
pub(crate) fn facing<T: Scalar, H: BearingHandle<T>>(scene: &BearingScene, bearing: H) -> H {
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
pub(crate) fn uneven<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Option<SurfaceDeviation<M, Vec<Feature<T>>>> {
    let features = features(scene);
    (!features.is_empty()).then(|| SurfaceDeviation::new(features))
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
