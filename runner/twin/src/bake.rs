//! A scene as Rust constants for firmware: its bearings (element positions, table and surfaces, without arithmetic at start), its
//! rotor and its observer.

mod direct;
mod observer;
mod rotor;

use crate::error::Result;
use crate::scene::build::{self, MadeTable};
use crate::scene::{Bearing, Facing, Model, Scene};
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape};
use ballrace::bearing::tabulated::Axis;
use std::fmt::Write;

/// Returns Rust source with a module for the bearing `name`, or for every bearing, a flexible or supported rotor and the observer,
/// and the size of the bearings' tables.
///
/// # Errors
/// A model or an effect without constants, a table with states without equilibrium, a rotor or an observer without constants.
pub fn bake(scene: &Scene, name: Option<&str>) -> Result<(String, Vec<Baked>)> {
    let chosen: Vec<&Bearing> = match name {
        Some(_) => vec![build::pick(scene, name)?],
        None => scene.bearings.iter().collect(),
    };
    let mut source = head(scene);
    let mut all = Vec::new();
    for of in chosen {
        let (text, baked) = module(scene, of)?;
        source += &text;
        all.push(baked);
    }
    if name.is_none() {
        rotor::module(&mut source, scene)?;
        observer::module(&mut source, scene)?;
    }
    Ok((source, all))
}

/// Module of one bearing.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Baked {
    /// Name of the bearing in the scene.
    pub bearing: String,
    /// Name of the module.
    pub module: String,
    /// Number of nodes of the table.
    pub nodes: usize,
    /// Flash memory of the table, bytes.
    pub bytes: usize,
}

/// Returns rows of numbers as a Rust array of arrays in `f64`.
fn matrix_text<R: AsRef<[f64]>>(rows: &[R]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| format!("{:?}", row.as_ref())).collect();
    format!("[{}]", rows.join(", "))
}

fn head(scene: &Scene) -> String {
    format!(
        "//! Made by `ballrace bake` from the scene {:?}. Do not edit: bake the scene again.\n\
         #![allow(dead_code, unused_imports, clippy::excessive_precision, clippy::unreadable_literal)]\n",
        scene.name
    )
}

/// Returns a valid module name.
fn identifier(name: &str) -> String {
    let letters = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
    format!("bearing_{}", letters.collect::<String>())
}

fn module(scene: &Scene, of: &Bearing) -> Result<(String, Baked)> {
    let module = identifier(&of.name);
    let mut out = String::new();
    writeln!(out, "\n/// Bearing {:?}.\npub mod {module} {{", of.name)?;
    let (nodes, bytes) = match of.model {
        Model::Tabulated | Model::QuasiStatic => {
            let made = build::table(scene, of)?;
            let fields = if made.friction { 3 } else { 2 };
            constants(&mut out, scene, of, &made, fields)?;
            bearing_function(&mut out, of, fields)?;
            (made.nodes.len(), made.nodes.len() * fields * 4)
        }
        _ => {
            direct::module(&mut out, scene, of)?;
            (0, 0)
        }
    };
    writeln!(out, "}}")?;
    Ok((out, Baked { bearing: of.name.clone(), module, nodes, bytes }))
}

/// Writes station, speed ratios, displacement by preload, and element positions.
fn position_constants(out: &mut String, scene: &Scene, of: &Bearing, model: Model) -> Result<()> {
    let kinematics = build::kinematics(scene, of)?;
    let plain = build::bearing(scene, of, model)?;
    let offset = build::preload_offset(scene, of, &plain)?.unwrap_or_default().to_array().map(|x| x as f32);
    writeln!(
        out,
        "    /// Along Z from the rotor's centre of mass, m.\n    pub const STATION: f32 = {:?};",
        of.station as f32
    )?;
    writeln!(out, "    /// Cage, ball and outer ring over shaft.")?;
    writeln!(out, "    pub const CAGE_RATIO: f64 = {:?};", kinematics.cage_ratio)?;
    writeln!(out, "    /// See [`CAGE_RATIO`].\n    pub const BALL_RATIO: f64 = {:?};", kinematics.ball_ratio())?;
    writeln!(out, "    /// See [`CAGE_RATIO`].\n    pub const OUTER_RATIO: f64 = {:?};", kinematics.outer_ratio)?;
    let [u, v, w, thu, thv] = offset;
    writeln!(out, "    /// By preload, to be added to every displacement.")?;
    writeln!(
        out,
        "    pub const OFFSET: Displacement<f32> = Displacement {{ u: {u:?}, v: {v:?}, w: {w:?}, thu: {thu:?}, thv: {thv:?} }};"
    )?;
    let places = build::places::<f32>(of);
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

fn surface_imports(out: &mut String, of: &Bearing) -> Result<()> {
    if !build::features::<f32>(of).is_empty() {
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

fn feature_constants(out: &mut String, of: &Bearing) -> Result<()> {
    let features = build::features::<f32>(of);
    if !features.is_empty() {
        writeln!(out, "    const FEATURES: [Feature<f32>; {}] = [", features.len())?;
        for feature in &features {
            writeln!(out, "        {},", feature_text(feature))?;
        }
        writeln!(out, "    ];")?;
    }
    Ok(())
}

fn constants(out: &mut String, scene: &Scene, of: &Bearing, made: &MadeTable, fields: usize) -> Result<()> {
    let constants = made.constants.rounded::<f32>();
    let grid = made.grid.rounded::<f32>();
    writeln!(out, "    use ballrace::bearing::ElementPosition;")?;
    writeln!(out, "    use ballrace::bearing::quasi_static::TableConstants;")?;
    surface_imports(out, of)?;
    writeln!(out, "    use ballrace::bearing::tabulated::{{Axis, Grid, Node, Table, Tabulated}};")?;
    writeln!(out, "    use ballrace::{{Displacement, Exact, Phase}};\n")?;
    position_constants(out, scene, of, Model::QuasiStatic)?;
    writeln!(
        out,
        "    const CONSTANTS: TableConstants<f32> = TableConstants {{ couple: {:?}, distance: {:?}, axis: {:?}, offset: {:?}, arm: {:?} }};",
        constants.couple, constants.distance, constants.axis, constants.offset, constants.arm
    )?;
    writeln!(out, "    const GRID: Grid<f32> = Grid {{")?;
    for (name, axis) in [("approach", &grid.approach), ("angle", &grid.angle), ("speed", &grid.speed)] {
        writeln!(out, "        {name}: {},", axis_text(axis))?;
    }
    writeln!(out, "    }};\n    const BY_OUTER: bool = {};", made.by_outer)?;
    feature_constants(out, of)?;
    writeln!(out, "    /// The table: {} bytes of flash.", made.nodes.len() * fields * 4)?;
    writeln!(out, "    #[rustfmt::skip]\n    pub static NODES: [Node<f32, {fields}>; {}] = [", made.nodes.len())?;
    for row in made.nodes.chunks(6) {
        let text: Vec<String> = row.iter().map(|node| node_text(node, fields)).collect();
        writeln!(out, "        {},", text.join(", "))?;
    }
    writeln!(out, "    ];\n")?;
    Ok(())
}

fn node_text(node: &[f64; 3], fields: usize) -> String {
    let numbers: Vec<String> = node.iter().take(fields).map(|x| format!("{:?}", *x as f32)).collect();
    format!("[{}]", numbers.join(", "))
}

fn axis_text(axis: &Axis<f32>) -> String {
    let [low, high] = axis.range;
    format!(
        "Axis {{ count: {}, origin: {:?}, density: {:?}, range: [{low:?}, {high:?}] }}",
        axis.count, axis.origin, axis.density
    )
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

fn bearing_function(out: &mut String, of: &Bearing, fields: usize) -> Result<()> {
    let n = of.elements;
    let features = of.waviness.len() + of.defect.len();
    let surface =
        if features > 0 { format!(", SurfaceDeviation<Exact, [Feature<f32>; {features}]>") } else { String::new() };
    let kind = format!(
        "Tabulated<f32, Exact, [ElementPosition<f32>; {n}], &'static [Node<f32, {fields}>], {fields}{surface}>"
    );
    let kind = if of.facing == Facing::MinusZ { format!("Mirrored<{kind}>") } else { kind };
    writeln!(out, "    /// The bearing's type.\n    pub type Baked = {kind};\n")?;
    let mut value = "Tabulated::new(POSITIONS, CONSTANTS, Table::new(GRID, NODES.as_slice()), BY_OUTER)".to_owned();
    if features > 0 {
        value += ".with_surface(SurfaceDeviation::new(FEATURES))";
    }
    if of.facing == Facing::MinusZ {
        value = format!("Mirrored({value})");
    }
    writeln!(
        out,
        "    /// The bearing, ready for the hot path.\n    #[must_use]\n    pub fn bearing() -> Baked {{\n        {value}\n    }}"
    )?;
    Ok(())
}
