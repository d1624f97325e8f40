//! Parts of a bearing's module of Rust that models have in common.

use super::Constants;
use crate::construction::{self, BuildError};
use ballrace::Displacement;
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape};
use ballrace_scene::{Bearing, Facing};
use std::fmt::Write;

/// Returns a displacement as an expression of Rust.
#[must_use]
pub fn displacement_text(of: &Displacement<f32>) -> String {
    let Displacement { u, v, w, thu, thv } = of;
    format!("Displacement {{ u: {u:?}, v: {v:?}, w: {w:?}, thu: {thu:?}, thv: {thv:?} }}")
}

/// Writes station, speed ratios, displacement by preload, and element positions.
pub(crate) fn position_constants(
    out: &mut String,
    &Constants { scene, of, offset, .. }: &Constants<'_>,
) -> Result<(), BuildError> {
    let kinematics = construction::kinematics(scene, of)?;
    let offset = offset.to_array().map(|x| x as f32);
    writeln!(
        out,
        "    /// Along Z from the rotor's centre of mass, m.\n    pub const STATION: f32 = {:?};",
        of.station as f32
    )?;
    writeln!(out, "    /// Cage, ball and outer ring over shaft.")?;
    writeln!(out, "    pub const CAGE_RATIO: f64 = {:?};", kinematics.cage_ratio)?;
    writeln!(out, "    /// See [`CAGE_RATIO`].\n    pub const BALL_RATIO: f64 = {:?};", kinematics.ball_ratio())?;
    writeln!(out, "    /// See [`CAGE_RATIO`].\n    pub const OUTER_RATIO: f64 = {:?};", kinematics.outer_ratio)?;
    writeln!(out, "    /// By preload, to be added to every displacement.")?;
    let offset = displacement_text(&Displacement::from_array(offset));
    writeln!(out, "    pub const OFFSET: Displacement<f32> = {offset};")?;
    let places = construction::places::<f32>(of);
    writeln!(out, "    /// The elements.\n    pub const POSITIONS: [ElementPosition<f32>; {}] = [", places.len())?;
    for place in places {
        let (cos, sin) = place.direction();
        writeln!(
            out,
            "        ElementPosition::from_constants({cos:?}, {sin:?}, Phase(0x{:016x})),",
            place.azimuth().0
        )?;
    }
    writeln!(out, "    ];")?;
    Ok(())
}

/// Writes the imports of waviness, damage and facing.
pub(crate) fn surface_imports(out: &mut String, of: &Bearing) -> Result<(), BuildError> {
    if !construction::features::<f32>(of).is_empty() {
        writeln!(
            out,
            "    use ballrace::bearing::surface::{{Direction, Feature, BearingComponent, Spall, SpallShape, SurfaceDeviation, Wave}};"
        )?;
    }
    if of.facing == Facing::MinusZ {
        writeln!(out, "    use ballrace::bearing::Mirrored;")?;
    }
    Ok(())
}

/// Writes waviness and damage.
pub(crate) fn feature_constants(out: &mut String, of: &Bearing) -> Result<(), BuildError> {
    let features = construction::features::<f32>(of);
    if !features.is_empty() {
        writeln!(out, "    const FEATURES: [Feature<f32>; {}] = [", features.len())?;
        for feature in &features {
            writeln!(out, "        {},", feature_text(feature))?;
        }
        writeln!(out, "    ];")?;
    }
    Ok(())
}

fn part_text(part: BearingComponent) -> String {
    match part {
        BearingComponent::Inner => "BearingComponent::Inner".to_owned(),
        BearingComponent::Outer => "BearingComponent::Outer".to_owned(),
        BearingComponent::Ball(place) => format!("BearingComponent::Ball(Phase(0x{:016x}))", place.0),
    }
}

fn feature_text(feature: &Feature<f32>) -> String {
    match feature {
        Feature::Wave(w) => format!(
            "Feature::Wave(Wave {{ component: {}, direction: Direction::{}, order: {}, amplitude: {:?}, phase: Phase(0x{:016x}) }})",
            part_text(w.component),
            if w.direction == Direction::Axial { "Axial" } else { "Radial" },
            w.order,
            w.amplitude,
            w.phase.0
        ),
        Feature::Spall(s) => {
            let Spall { component, centre, half_width, depth, shape } = *s;
            let shape = if shape == SpallShape::HalfSine { "HalfSine" } else { "Rectangular" };
            format!(
                "Feature::Spall(Spall::new({}, Phase(0x{:016x}), {half_width:?}, {depth:?}, SpallShape::{shape}))",
                part_text(component),
                centre.0
            )
        }
    }
}

/// Returns the type and the constructor call that waviness and damage add.
pub(crate) fn surface(of: &Bearing) -> (String, &'static str) {
    let features = of.waviness.len() + of.defect.len();
    if features == 0 {
        return (String::new(), "");
    }
    (format!(", SurfaceDeviation<Exact, [Feature<f32>; {features}]>"), ".with_surface(SurfaceDeviation::new(FEATURES))")
}

/// Writes the imports of a model in closed form.
pub(crate) fn imports(out: &mut String, of: &Bearing, model: &str) -> Result<(), BuildError> {
    writeln!(out, "    use ballrace::bearing::ElementPosition;")?;
    surface_imports(out, of)?;
    writeln!(out, "{model}")?;
    writeln!(out, "    use ballrace::{{Displacement, Exact, Phase}};\n")?;
    Ok(())
}

/// Writes type and function of the bearing.
pub(crate) fn function(out: &mut String, of: &Bearing, kind: &str, value: &str) -> Result<(), BuildError> {
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
