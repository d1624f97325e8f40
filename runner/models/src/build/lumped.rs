//! The lumped model: radial and axial elements with any contact law, on a rigid or displaced housing.

use super::{BuildError, blocked_places, element_azimuth, facing, geometry, invalid, named, uneven};
use crate::handle::{BearingHandle, BendingRing, Housing, HousingShape};
use ballrace::bearing::lumped::{Axial, Radial};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use ballrace::{Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, FreeAngle};

/// Contact law of an exponent; 3/2 and 10/9 (also as a decimal of four digits or more) have laws without a power function.
pub enum Exponent {
    /// 3/2
    Point,
    /// 10/9
    Line,
    /// Any other exponent.
    Other,
}

impl Exponent {
    /// Returns the law of an exponent.
    #[must_use]
    pub fn of(exponent: f64) -> Self {
        if exponent == 1.5 {
            Self::Point
        } else if (exponent - 10.0 / 9.0).abs() < 1.2e-4 {
            Self::Line
        } else {
            Self::Other
        }
    }
}

pub(super) fn lumped<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &BearingScene) -> Result<H, BuildError> {
    let (stiffness, exponent, play) = law(scene)?;
    let stiffness = T::from_f64(stiffness);
    match Exponent::of(exponent) {
        Exponent::Point => with_radial::<T, M, _, H>(scene, PointContactLaw { stiffness }, play),
        Exponent::Line => with_radial::<T, M, _, H>(scene, LineContactLaw { stiffness }, play),
        Exponent::Other => {
            with_radial::<T, M, _, H>(scene, PowerLaw { stiffness, exponent: T::from_f64(exponent) }, play)
        }
    }
}

/// Returns stiffness, exponent and radial play: the scene's, else from geometry.
///
/// # Errors
/// Returns an error if neither the law nor the geometry defines a value.
pub fn law(scene: &BearingScene) -> Result<(f64, f64, f64), BuildError> {
    let geometry = geometry(scene)?;
    let law = scene.law;
    let Some(stiffness) = law.and_then(|l| l.stiffness).or_else(|| geometry.map(|g| g.stiffness())) else {
        let expected = "stiffness, or the geometry from which it follows";
        return Err(invalid(scene, "model lumped", "no stiffness", expected));
    };
    let from_clearance = scene.geometry.and_then(|g| match g.fit {
        FreeAngle::DiametralClearance(s) => Some(0.5 * s),
        FreeAngle::ContactAngle(_) => None,
    });
    let Some(play) = law.and_then(|l| l.radial_play).or(from_clearance) else {
        let expected = "radial_play or diametral_clearance";
        return Err(invalid(scene, "model lumped", "no radial_play", expected));
    };
    Ok((stiffness, law.map_or(1.5, |l| l.exponent), play))
}

fn with_radial<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M> + 'static, H: BearingHandle<T>>(
    scene: &BearingScene,
    law: L,
    play: f64,
) -> Result<H, BuildError> {
    let radial = Radial::<T, M, L, _>::try_new(blocked_places(scene), law, play).map_err(|e| named(scene, e))?;
    let alone = scene.axial.is_none() && scene.has_rigid_outer_ring();
    match uneven::<T, M>(scene) {
        None if alone => Ok(facing(scene, H::dispatched(radial))),
        Some(surface) if alone => Ok(facing(scene, H::dispatched(radial.with_surface(surface)))),
        None => with_axial::<T, M, H>(scene, H::elements(radial)),
        Some(surface) => with_axial::<T, M, H>(scene, H::elements(radial.with_surface(surface))),
    }
}

fn with_axial<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &BearingScene,
    radial: H::Elements,
) -> Result<H, BuildError> {
    let axial = match scene.axial {
        None => None,
        Some(axial) => {
            let stiffness = T::from_f64(axial.stiffness);
            Some(match Exponent::of(axial.exponent) {
                Exponent::Point => axial_elements::<T, M, _, H>(scene, PointContactLaw { stiffness })?,
                Exponent::Line => axial_elements::<T, M, _, H>(scene, LineContactLaw { stiffness })?,
                Exponent::Other => {
                    axial_elements::<T, M, _, H>(scene, PowerLaw { stiffness, exponent: T::from_f64(axial.exponent) })?
                }
            })
        }
    };
    Ok(facing(scene, H::lumped(radial, axial, housing(scene))))
}

fn axial_elements<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M> + 'static, H: BearingHandle<T>>(
    scene: &BearingScene,
    law: L,
) -> Result<H::Elements, BuildError> {
    let (play, radius) = scene.axial.map_or((0.0, 0.0), |a| (a.play, a.radius));
    let axial = Axial::<T, M, L, _>::try_new(blocked_places(scene), law, play, radius).map_err(|e| named(scene, e))?;
    Ok(H::elements(axial))
}

/// Returns the outer ring in the frame of the bearing; none where it is rigid.
fn housing(scene: &BearingScene) -> Option<Housing> {
    let azimuths = || (0..scene.elements).map(|j| element_azimuth(scene, j)).collect();
    if let Some(ring) = &scene.outer_ring {
        return Some(Housing::Bending(BendingRing::new(ring, azimuths())));
    }
    let mirror = scene.facing == Facing::MinusZ;
    let point = |&[x, y, z]: &[f64; 3]| if mirror { [x, -y, -z] } else { [x, y, z] };
    let points: Vec<[f64; 3]> = scene.housing_displacement.iter().map(point).collect();
    (!points.is_empty()).then(|| Housing::Displaced(HousingShape::new(azimuths(), &points)))
}
