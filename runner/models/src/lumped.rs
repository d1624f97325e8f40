//! Lumped model: radial and axial elements with any contact law, on a rigid, displaced or bending outer ring.

use crate::construction::{
    BuildError, blocked_places, element_azimuth, facing, geometry, invalid, named, places, uneven,
};
use crate::handle::{AnyForceModel, BearingHandle, BendingRing, Housing, HousingShape};
use crate::model::BearingModel;
use crate::model::c::{CStruct, Member};
use crate::model::{self as firmware, Constants, ELEMENT_BYTES, FirmwareModel, NotCounted, rust};
use ballrace::bearing::ElementPosition;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use ballrace::{Exact, Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, FreeAngle, Model, Scene};

/// [`Model::Lumped`]
pub(crate) struct LumpedModel;

impl BearingModel for LumpedModel {
    fn model(&self) -> Model {
        Model::Lumped
    }
    fn firmware(&self, of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        if of.has_rigid_outer_ring() { Some(&Self) } else { None }
    }
    fn counted_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
        let axial = of.axial.map(|axial| Exponent::of(axial.exponent));
        match (Exponent::of(radial_exponent(of)), axial) {
            (Exponent::Point, Some(Exponent::Point)) => Ok("radial and axial 3/2"),
            (_, Some(_)) => Err(NotCounted::Law),
            (Exponent::Point, None) => Ok("radial 3/2"),
            (Exponent::Line, None) => Ok("radial 10/9"),
            (Exponent::Other, None) => Ok("radial, any power"),
        }
    }
}

impl FirmwareModel for LumpedModel {
    fn constant_bytes(&self, of: &BearingScene) -> usize {
        let law = |exponent| if matches!(Exponent::of(exponent), Exponent::Other) { 8 } else { 4 };
        let axial = of.axial.map_or(0, |axial| of.elements * ELEMENT_BYTES + law(axial.exponent) + 2 * 4);
        firmware::element_bytes(of) + law(radial_exponent(of)) + 4 + axial
    }

    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError> {
        let of = constants.of;
        let n = of.elements;
        let (stiffness, exponent, play) = law(of)?;
        let (kind, value) = law_text(stiffness, exponent);
        let (surface, with) = rust::surface(of);
        let mut kind = format!("Radial<f32, Exact, {kind}, [ElementPosition<f32>; {n}]{surface}>");
        let mut value = format!("Radial::from_constants(POSITIONS, {value}, {:?}){with}", play as f32);
        if let Some(axial) = of.axial {
            let (axial_law, axial_value) = law_text(axial.stiffness, axial.exponent);
            kind = format!("Combined<{kind}, Axial<f32, Exact, {axial_law}, [ElementPosition<f32>; {n}]>>");
            let (play, radius) = (axial.play as f32, axial.radius as f32);
            value = format!("Combined({value}, Axial::from_constants(POSITIONS, {axial_value}, {play:?}, {radius:?}))");
        }
        rust::imports(
            out,
            of,
            "    use ballrace::bearing::lumped::{Axial, Combined, Radial};\n    use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};",
        )?;
        rust::position_constants(out, constants)?;
        rust::feature_constants(out, of)?;
        rust::function(out, of, &kind, &value)
    }

    /// The force of radial elements does not depend on the facing.
    fn in_c(&self, of: &BearingScene) -> BearingScene {
        BearingScene { facing: if of.axial.is_none() { Facing::Both } else { of.facing }, ..of.clone() }
    }

    /// C computes radial and axial elements with different laws as powers.
    fn force_in_c(&self, of: &BearingScene) -> Result<Option<AnyForceModel<f32>>, BuildError> {
        let Some(axial) = of.axial.filter(|axial| law_of(of, axial) == CommonLaw::Power) else {
            return Ok(None);
        };
        let (stiffness, exponent, play) = law(of)?;
        let law = |stiffness: f64, exponent: f64| PowerLaw { stiffness: stiffness as f32, exponent: exponent as f32 };
        let places = || places::<f32>(of);
        let radial = Radial::<f32, Exact, _, _>::from_constants(places(), law(stiffness, exponent), play as f32);
        let (play, radius) = (axial.play as f32, axial.radius as f32);
        let axial =
            Axial::<f32, Exact, _, _>::from_constants(places(), law(axial.stiffness, axial.exponent), play, radius);
        let force = AnyForceModel::new(Combined(radial, axial));
        Ok(Some(if of.facing == Facing::MinusZ { force.mirrored() } else { force }))
    }

    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError> {
        let of = constants.of;
        let (stiffness, exponent, play) = law(of)?;
        let mut members = vec![("stiffness", stiffness), ("exponent", exponent), ("play", play)];
        let (law, kind) = match of.axial {
            None => (CommonLaw::of(exponent), "ballrace_lumped_radial"),
            Some(axial) => {
                members.extend([
                    ("axial_stiffness", axial.stiffness),
                    ("axial_exponent", axial.exponent),
                    ("axial_play", axial.play),
                    ("radius", axial.radius),
                ]);
                (law_of(of, &axial), "ballrace_lumped_radial_axial")
            }
        };
        let new = match (law, of.axial.is_some()) {
            (CommonLaw::Point, false) => CStruct::new::<RadialInFirmware<'_, PointContactLaw<f32>>>,
            (CommonLaw::Line, false) => CStruct::new::<RadialInFirmware<'_, LineContactLaw<f32>>>,
            (CommonLaw::Power, false) => CStruct::new::<RadialInFirmware<'_, PowerLaw<f32>>>,
            (CommonLaw::Point, true) => CStruct::new::<BothInFirmware<'_, PointContactLaw<f32>>>,
            (CommonLaw::Line, true) => CStruct::new::<BothInFirmware<'_, LineContactLaw<f32>>>,
            (CommonLaw::Power, true) => CStruct::new::<BothInFirmware<'_, PowerLaw<f32>>>,
        };
        let members = members.into_iter().map(|(name, x)| (name, Member::Number(x as f32))).collect();
        Ok(new(of, kind, &format!("{kind}{}", law.suffix()), members))
    }
}

/// Radial elements as firmware has them.
type RadialInFirmware<'a, L> = Radial<f32, Exact, L, &'a [ElementPosition<f32>]>;
/// Radial and axial elements as firmware has them.
type BothInFirmware<'a, L> = Combined<RadialInFirmware<'a, L>, Axial<f32, Exact, L, &'a [ElementPosition<f32>]>>;

/// Returns the exponent of the law of the radial elements.
fn radial_exponent(of: &BearingScene) -> f64 {
    of.law.map_or(1.5, |law| law.exponent)
}

/// Returns type and value of a law.
fn law_text(stiffness: f64, exponent: f64) -> (&'static str, String) {
    let stiffness = stiffness as f32;
    match Exponent::of(exponent) {
        Exponent::Point => ("PointContactLaw<f32>", format!("PointContactLaw {{ stiffness: {stiffness:?} }}")),
        Exponent::Line => ("LineContactLaw<f32>", format!("LineContactLaw {{ stiffness: {stiffness:?} }}")),
        Exponent::Other => {
            ("PowerLaw<f32>", format!("PowerLaw {{ stiffness: {stiffness:?}, exponent: {:?} }}", exponent as f32))
        }
    }
}

/// Law of all elements of a bearing in C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CommonLaw {
    Point,
    Line,
    Power,
}

impl CommonLaw {
    fn of(exponent: f64) -> Self {
        match Exponent::of(exponent) {
            Exponent::Point => Self::Point,
            Exponent::Line => Self::Line,
            Exponent::Other => Self::Power,
        }
    }

    /// Returns the suffix of the model's name in C.
    const fn suffix(self) -> &'static str {
        match self {
            Self::Point => "",
            Self::Line => "_line",
            Self::Power => "_power",
        }
    }
}

/// Returns the law of radial and axial elements: powers where they differ.
fn law_of(of: &BearingScene, axial: &ballrace_scene::Axial) -> CommonLaw {
    let radial = CommonLaw::of(radial_exponent(of));
    if radial == CommonLaw::of(axial.exponent) { radial } else { CommonLaw::Power }
}

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

/// Builds the lumped model of a bearing.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(_: &Scene, scene: &BearingScene) -> Result<H, BuildError> {
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
