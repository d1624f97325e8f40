//! Models in closed form: springs, lumped elements, variable contact angle.

use super::{feature_constants, position_constants, surface_imports};
use ballrace::bearing::Bearing as _;
use ballrace::bearing::angular::AngularConstants;
use ballrace::{Displacement, Phase};
use ballrace_models::build;
use ballrace_plant::Plant;
use ballrace_plant::error::Result;
use ballrace_scene::{Bearing, Facing, Linear, Model, Scene};
use std::fmt::Write;

/// Writes the body of the bearing's module.
pub fn module(out: &mut String, scene: &Scene, of: &Bearing) -> Result<()> {
    match of.model {
        Model::Linear => springs(out, scene, of),
        Model::Angular => angular(out, scene, of),
        _ => lumped(out, scene, of),
    }
}

/// Returns the force and the stiffness at zero displacement, which define the spring model.
///
/// # Errors
/// Returns an error if the bearing cannot be linearised.
pub fn spring(scene: &Scene, of: &Bearing) -> Result<([f32; 5], [[f32; 5]; 5])> {
    let spring = if matches!(of.linear, Some(Linear::Of(_))) {
        Plant::try_new(scene)?.mounted(&of.name)?.bearing.clone()
    } else {
        build::bearing(scene, of, Model::Linear)?
    };
    let (reaction, k) = spring.reaction_and_stiffness(&Displacement::default(), &Phase::ZERO.into());
    let row = |i| std::array::from_fn(|j| k[(i, j)] as f32);
    Ok((reaction.wrench.to_array().map(|f| f as f32), std::array::from_fn(row)))
}

fn springs(out: &mut String, scene: &Scene, of: &Bearing) -> Result<()> {
    let ([fx, fy, fz, mx, my], k) = spring(scene, of)?;
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

/// Returns type and value of a law.
fn law(stiffness: f64, exponent: f64) -> (&'static str, String) {
    let stiffness = stiffness as f32;
    match build::Exponent::of(exponent) {
        build::Exponent::Point => ("PointContactLaw<f32>", format!("PointContactLaw {{ stiffness: {stiffness:?} }}")),
        build::Exponent::Line => ("LineContactLaw<f32>", format!("LineContactLaw {{ stiffness: {stiffness:?} }}")),
        build::Exponent::Other => {
            ("PowerLaw<f32>", format!("PowerLaw {{ stiffness: {stiffness:?}, exponent: {:?} }}", exponent as f32))
        }
    }
}

fn lumped(out: &mut String, scene: &Scene, of: &Bearing) -> Result<()> {
    let n = of.elements;
    let (stiffness, exponent, play) = build::law(of)?;
    let (kind, value) = law(stiffness, exponent);
    let (surface, with) = surface(of);
    let mut kind = format!("Radial<f32, Exact, {kind}, [ElementPosition<f32>; {n}]{surface}>");
    let mut value = format!("Radial::from_constants(POSITIONS, {value}, {:?}){with}", play as f32);
    if let Some(axial) = of.axial {
        let (axial_law, axial_value) = law(axial.stiffness, axial.exponent);
        kind = format!("Combined<{kind}, Axial<f32, Exact, {axial_law}, [ElementPosition<f32>; {n}]>>");
        let (play, radius) = (axial.play as f32, axial.radius as f32);
        value = format!("Combined({value}, Axial::from_constants(POSITIONS, {axial_value}, {play:?}, {radius:?}))");
    }
    imports(
        out,
        of,
        "    use ballrace::bearing::lumped::{Axial, Combined, Radial};\n    use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};",
    )?;
    position_constants(out, scene, of)?;
    function(out, of, &kind, &value)
}

fn angular(out: &mut String, scene: &Scene, of: &Bearing) -> Result<()> {
    let (geometry, datum) = build::contact_geometry(of, "angular")?;
    let constants = AngularConstants::try_new(geometry, datum).map_err(|e| build::named(of, e))?.rounded::<f32>();
    let (surface, with) = surface(of);
    imports(out, of, "    use ballrace::bearing::angular::{Angular, AngularConstants};")?;
    position_constants(out, scene, of)?;
    let AngularConstants { stiffness, distance, unloaded, excess, arm } = constants;
    writeln!(
        out,
        "    const CONSTANTS: AngularConstants<f32> = AngularConstants {{ stiffness: {stiffness:?}, distance: {distance:?}, unloaded: {unloaded:?}, excess: {excess:?}, arm: {arm:?} }};"
    )?;
    let kind = format!("Angular<f32, Exact, [ElementPosition<f32>; {}]{surface}>", of.elements);
    function(out, of, &kind, &format!("Angular::from_constants(POSITIONS, CONSTANTS){with}"))
}

/// Returns the type and the constructor call that waviness and damage add.
fn surface(of: &Bearing) -> (String, &'static str) {
    let features = of.waviness.len() + of.defect.len();
    if features == 0 {
        return (String::new(), "");
    }
    (format!(", SurfaceDeviation<Exact, [Feature<f32>; {features}]>"), ".with_surface(SurfaceDeviation::new(FEATURES))")
}

fn imports(out: &mut String, of: &Bearing, model: &str) -> Result<()> {
    writeln!(out, "    use ballrace::bearing::ElementPosition;")?;
    surface_imports(out, of)?;
    writeln!(out, "{model}")?;
    writeln!(out, "    use ballrace::{{Displacement, Exact, Phase}};\n")?;
    Ok(())
}

fn function(out: &mut String, of: &Bearing, kind: &str, value: &str) -> Result<()> {
    feature_constants(out, of)?;
    let mirrored = of.facing == Facing::MinusZ;
    let (kind, value) = if mirrored {
        (format!("Mirrored<{kind}>"), format!("Mirrored({value})"))
    } else {
        (kind.to_owned(), value.to_owned())
    };
    writeln!(out, "    /// The bearing's type.\n    pub type Baked = {kind};\n")?;
    writeln!(
        out,
        "    /// The bearing, ready for the hot path.\n    #[must_use]\n    pub fn bearing() -> Baked {{\n        {value}\n    }}"
    )?;
    Ok(())
}
