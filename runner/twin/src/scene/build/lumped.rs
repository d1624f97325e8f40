//! The lumped model: radial and axial elements with any contact law, on a rigid or displaced housing.

use super::{AnyBearing, BuildError, Shared, facing, geometry, invalid, named, places, uneven};
use crate::scene::{Bearing as BearingScene, Facing, Fit};
use crate::simd::shared;
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::lumped::{Axial, Radial};
use ballrace::bearing::{Bearing, Reaction};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use ballrace::{BearingKinematicState, Displacement, Math, Scalar, Stiffness};
use std::sync::Arc;

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

/// One kind of elements behind a pointer, so that the kinds add up in the compiled program instead of multiplying.
trait OnRing<T: Scalar>: Bearing<T> + FlexibleRing<T> {}
impl<T: Scalar, B: Bearing<T> + FlexibleRing<T>> OnRing<T> for B {}
type Kind<T> = Box<dyn OnRing<T>>;

/// Radial and axial elements together, and Hajzman's flexible outer ring with given `q_S`.
struct Lumped<T> {
    radial: Kind<T>,
    axial: Option<Kind<T>>,
    /// Empty where the outer ring is rigid.
    housing: Vec<HousingPoint<T>>,
}

impl<T: Scalar> Lumped<T> {
    fn kinds(&self) -> impl Iterator<Item = &Kind<T>> {
        [Some(&self.radial), self.axial.as_ref()].into_iter().flatten()
    }
}

impl<T: Scalar> Bearing<T> for Lumped<T> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let mut housing = self.housing.clone();
        let one = |kind: &Kind<T>| match housing.as_mut_slice() {
            [] => kind.reaction(u, at),
            points => kind.reaction_flexible(u, at, points),
        };
        self.kinds().map(one).fold(Reaction::default(), |sum, one| sum + one)
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let mut housing = self.housing.clone();
        let one = |kind: &Kind<T>| match housing.as_mut_slice() {
            [] => kind.reaction_and_stiffness(u, at),
            points => kind.reaction_and_stiffness_flexible(u, at, points),
        };
        let start = (Reaction::default(), Stiffness::from_element(T::ZERO));
        self.kinds().map(one).fold(start, |(sum, stiffness), (reaction, k)| (sum + reaction, stiffness + k))
    }

    /// Loads of the radial elements, which show the load zone; on a displaced housing the reaction at each point.
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        if self.housing.is_empty() {
            return self.radial.element_loads(u, at, loads);
        }
        let mut points = self.housing.clone();
        for kind in self.kinds() {
            kind.reaction_flexible(u, at, &mut points);
        }
        for (load, point) in loads.iter_mut().zip(&points) {
            let square = point.reaction.iter().map(|r| r.to_f64() * r.to_f64()).sum::<f64>();
            *load = T::from_f64(square.sqrt());
        }
    }
}

pub(super) fn lumped<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Result<AnyBearing<T>, BuildError> {
    let (stiffness, exponent, play) = law(scene)?;
    let stiffness = T::from_f64(stiffness);
    match Exponent::of(exponent) {
        Exponent::Point => with_radial::<T, M, _>(scene, PointContactLaw { stiffness }, play),
        Exponent::Line => with_radial::<T, M, _>(scene, LineContactLaw { stiffness }, play),
        Exponent::Other => with_radial::<T, M, _>(scene, PowerLaw { stiffness, exponent: T::from_f64(exponent) }, play),
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
        let expected = "stiffness, or the geometry it follows from";
        return Err(invalid(scene, "model lumped", "no stiffness", expected));
    };
    let from_clearance = scene.geometry.and_then(|g| match g.fit {
        Fit::DiametralClearance(s) => Some(0.5 * s),
        Fit::ContactAngle(_) => None,
    });
    let Some(play) = law.and_then(|l| l.radial_play).or(from_clearance) else {
        let expected = "radial_play or diametral_clearance";
        return Err(invalid(scene, "model lumped", "no radial_play", expected));
    };
    Ok((stiffness, law.map_or(1.5, |l| l.exponent), play))
}

fn with_radial<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>(
    scene: &BearingScene,
    law: L,
    play: f64,
) -> Result<AnyBearing<T>, BuildError> {
    let radial = Radial::<T, M, L, _>::try_new(places(scene), law, play).map_err(|e| named(scene, e))?;
    let alone = scene.axial.is_none() && scene.housing_displacement.is_empty();
    match uneven::<T, M>(scene) {
        None if alone => Ok(facing(scene, shared(radial))),
        Some(surface) if alone => Ok(facing(scene, shared(radial.with_surface(surface)))),
        None => with_axial::<T, M>(scene, Box::new(radial)),
        Some(surface) => with_axial::<T, M>(scene, Box::new(radial.with_surface(surface))),
    }
}

fn with_axial<T: Scalar, M: Math<T>>(scene: &BearingScene, radial: Kind<T>) -> Result<AnyBearing<T>, BuildError> {
    let axial = match scene.axial {
        None => None,
        Some(axial) => {
            let stiffness = T::from_f64(axial.stiffness);
            Some(match Exponent::of(axial.exponent) {
                Exponent::Point => axial_kind::<T, M, _>(scene, PointContactLaw { stiffness })?,
                Exponent::Line => axial_kind::<T, M, _>(scene, LineContactLaw { stiffness })?,
                Exponent::Other => {
                    axial_kind::<T, M, _>(scene, PowerLaw { stiffness, exponent: T::from_f64(axial.exponent) })?
                }
            })
        }
    };
    Ok(facing(scene, Shared(Arc::new(Lumped { radial, axial, housing: housing(scene) }))))
}

fn axial_kind<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>(
    scene: &BearingScene,
    law: L,
) -> Result<Kind<T>, BuildError> {
    let (play, radius) = scene.axial.map_or((0.0, 0.0), |a| (a.play, a.radius));
    let axial = Axial::<T, M, L, _>::try_new(places(scene), law, play, radius).map_err(|e| named(scene, e))?;
    Ok(Box::new(axial))
}

fn housing<T: Scalar>(scene: &BearingScene) -> Vec<HousingPoint<T>> {
    let mirror = scene.facing == Facing::MinusZ;
    let point = |&[x, y, z]: &[f64; 3]| if mirror { [x, -y, -z] } else { [x, y, z] };
    let displaced = |p| HousingPoint { displacement: point(p).map(T::from_f64), reaction: [T::ZERO; 3] };
    scene.housing_displacement.iter().map(displaced).collect()
}
