//! Linear model: a constant stiffness.

use crate::construction::{BuildError, geometry, invalid, named};
use crate::handle::{AnyBearing, BearingHandle};
use crate::model::BearingModel;
use crate::model::c::{CStruct, Member};
use crate::model::{Constants, FirmwareModel, NotCounted};
use ballrace::bearing::Bearing as _;
use ballrace::bearing::linear::{Linear as LinearBearing, two_spring_ball};
use ballrace::{Displacement, Exact, Math, Phase, Scalar, Stiffness, Wrench};
use ballrace_scene::{Bearing as BearingScene, Facing, Linear, Model, Scene};
use std::fmt::Write;

/// [`Model::Linear`]
pub(crate) struct LinearModel;

impl BearingModel for LinearModel {
    fn model(&self) -> Model {
        Model::Linear
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        Some(&Self)
    }
    fn counted_row(&self, _of: &BearingScene) -> Result<&'static str, NotCounted> {
        Ok("linear")
    }
}

impl FirmwareModel for LinearModel {
    /// Stiffness, displacement and force.
    fn constant_bytes(&self, _of: &BearingScene) -> usize {
        size_of::<f32>() * (25 + 5 + 5)
    }

    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError> {
        let of = constants.of;
        let ([fx, fy, fz, mx, my], k) = springs(constants)?;
        writeln!(out, "    use ballrace::bearing::linear::Linear;")?;
        writeln!(out, "    use ballrace::{{Displacement, Stiffness, Wrench}};\n")?;
        writeln!(
            out,
            "    /// Along Z from the rotor's centre of mass, m.\n    pub const STATION: f32 = {:?};",
            of.station as f32
        )?;
        writeln!(
            out,
            "    const FORCE: Wrench<f32> = Wrench {{ fx: {fx:?}, fy: {fy:?}, fz: {fz:?}, mx: {mx:?}, my: {my:?} }};"
        )?;
        writeln!(out, "    /// The bearing's type.\n    pub type Baked = Linear<f32>;\n")?;
        writeln!(
            out,
            "    /// The bearing, ready for the hot path.\n    #[must_use]\n    #[rustfmt::skip]\n    pub fn bearing() -> Baked {{"
        )?;
        writeln!(out, "        let stiffness = Stiffness::new(")?;
        for row in k {
            let row = row.map(|entry| format!("{entry:?}"));
            writeln!(out, "            {},", row.join(", "))?;
        }
        writeln!(
            out,
            "        );\n        Linear::about(stiffness, Displacement {{ u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 }}, FORCE)\n    }}"
        )?;
        Ok(())
    }

    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError> {
        let (force, stiffness) = springs(constants)?;
        let members = vec![
            ("stiffness", Member::Rows(stiffness)),
            ("reference", Member::Numbers(vec![0.0; 5])),
            ("force", Member::Numbers(force.into())),
        ];
        // Springs have no facing.
        let of = BearingScene { facing: Facing::Both, ..constants.of.clone() };
        Ok(CStruct::new::<LinearBearing<f32>>(&of, "ballrace_linear", "ballrace_linear", members))
    }
}

/// Returns the force and the stiffness at zero displacement, which define the springs.
fn springs(constants: &Constants<'_>) -> Result<([f32; 5], [[f32; 5]; 5]), BuildError> {
    let springs = match constants.springs {
        Some(springs) => springs.clone(),
        None => build::<f64, Exact, AnyBearing<f64>>(constants.scene, constants.of)?,
    };
    let (reaction, k) = springs.reaction_and_stiffness(&Displacement::default(), &Phase::ZERO.into());
    let row = |i| std::array::from_fn(|j| k[(i, j)] as f32);
    Ok((reaction.wrench.to_array().map(|f| f as f32), std::array::from_fn(row)))
}

/// Builds the springs of a bearing. Those of a linearised one require its rotor's equilibrium and are rejected here.
#[expect(clippy::extra_unused_type_parameters, reason = "the registry builds all models alike")]
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(_: &Scene, scene: &BearingScene) -> Result<H, BuildError> {
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
