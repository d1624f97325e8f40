//! Angular model: closed-form variable contact angle.

use crate::construction::{BuildError, blocked_places, contact_geometry, facing, named, uneven};
use crate::handle::BearingHandle;
use crate::model::BearingModel;
use crate::model::c::{CStruct, Member};
use crate::model::{self as firmware, Constants, FirmwareModel, NotCounted, rust};
use ballrace::bearing::ElementPosition;
use ballrace::bearing::angular::{Angular, AngularConstants};
use ballrace::{Exact, Math, Scalar};
use ballrace_scene::{Bearing as BearingScene, Model, Scene};
use std::fmt::Write;

/// [`Model::Angular`]
pub(crate) struct AngularModel;

impl BearingModel for AngularModel {
    fn model(&self) -> Model {
        Model::Angular
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        Some(&Self)
    }
    fn counted_row(&self, _of: &BearingScene) -> Result<&'static str, NotCounted> {
        Ok("angular")
    }
}

impl FirmwareModel for AngularModel {
    fn constant_bytes(&self, of: &BearingScene) -> usize {
        firmware::element_bytes(of) + size_of::<AngularConstants<f32>>()
    }

    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError> {
        let of = constants.of;
        let (surface, with) = rust::surface(of);
        rust::imports(out, of, "    use ballrace::bearing::angular::{Angular, AngularConstants};")?;
        rust::position_constants(out, constants)?;
        let AngularConstants { stiffness, distance, unloaded, excess, arm } = rounded(of)?;
        writeln!(
            out,
            "    const CONSTANTS: AngularConstants<f32> = AngularConstants {{ stiffness: {stiffness:?}, distance: {distance:?}, unloaded: {unloaded:?}, excess: {excess:?}, arm: {arm:?} }};"
        )?;
        let kind = format!("Angular<f32, Exact, [ElementPosition<f32>; {}]{surface}>", of.elements);
        rust::feature_constants(out, of)?;
        rust::function(out, of, &kind, &format!("Angular::from_constants(POSITIONS, CONSTANTS){with}"))
    }

    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError> {
        let of = constants.of;
        let AngularConstants { stiffness, distance: [distance, square], unloaded: [radial, axial], excess, arm } =
            rounded(of)?;
        let members = [
            ("stiffness", stiffness),
            ("distance", distance),
            ("distance_squared", square),
            ("unloaded_radial", radial),
            ("unloaded_axial", axial),
            ("excess", excess),
            ("arm", arm),
        ];
        let members = members.map(|(name, x)| (name, Member::Number(x))).into();
        Ok(CStruct::new::<InFirmware<'_>>(of, "ballrace_angular", "ballrace_angular", members))
    }
}

/// The bearing as firmware has it.
type InFirmware<'a> = Angular<f32, Exact, &'a [ElementPosition<f32>]>;

/// Returns the constants in single precision.
fn rounded(of: &BearingScene) -> Result<AngularConstants<f32>, BuildError> {
    let (geometry, datum) = contact_geometry(of, "angular")?;
    Ok(AngularConstants::try_new(geometry, datum).map_err(|e| named(of, e))?.rounded())
}

/// Builds the angular model of a bearing.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(_: &Scene, scene: &BearingScene) -> Result<H, BuildError> {
    let (geometry, zero) = contact_geometry(scene, "angular")?;
    let built = Angular::<T, M, _>::try_new(geometry, blocked_places(scene), zero).map_err(|e| named(scene, e))?;
    Ok(match uneven::<T, M>(scene) {
        None => facing(scene, H::dispatched(built)),
        Some(surface) => facing(scene, H::dispatched(built.with_surface(surface))),
    })
}
