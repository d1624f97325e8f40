//! Writes the constants of a scene as source code for firmware, with a certificate.
//!
//! The source has the bearings (element positions, table and surface deviations, without arithmetic at start-up), the observer of a
//! scene with `[observer]` and, in Rust, the matrices of a flexible or supported rotor.

mod accuracy;
mod c;
mod certificate;
mod direct;
mod embedded;
mod observer;
mod range;
mod rotor;
pub mod verify;

pub use accuracy::PoseSource;
pub use certificate::{BearingCertificate, Certificate, Field};
pub use range::Coverage;

use ballrace::Displacement;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::angular::AngularConstants;
use ballrace::bearing::checksum::ChecksumRange;
use ballrace::bearing::quasi_static::TableConstants;
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape};
use ballrace::bearing::tabulated::Axis;
use ballrace_models::build::{self, TableData};
use ballrace_plant::error::{BakeError, Result};
use ballrace_scene::{Bearing, Facing, Model, Scene};
use certificate::ConstantBytes;
use std::fmt::Write;

/// Language of the constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Language {
    /// A module of Rust for the crate `ballrace`.
    Rust,
    /// A header and a source file of C99 for the library `ballrace-c`.
    C,
}

impl Language {
    /// All languages by their names.
    pub const ALL: [(&'static str, Self); 2] = [("rust", Self::Rust), ("c", Self::C)];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }
}

/// Processor core with a table of measured costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Core {
    /// Arm Cortex-M4 with its floating-point unit.
    CortexM4f,
}

impl Core {
    /// All cores by their names.
    pub const ALL: [(&'static str, Self); 1] = [("cortex-m4f", Self::CortexM4f)];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }
}

/// Options of [`bake`].
#[derive(Debug, Clone, Copy)]
pub struct BakeOptions<'a> {
    /// Name of the only bearing to write; every bearing, the rotor and the observer when absent.
    pub bearing: Option<&'a str>,
    /// Language of the constants.
    pub language: Language,
    /// Core whose cost the certificate states.
    pub core: Core,
    /// Source of the poses at which errors are computed; the first source that the scene allows if `None`.
    pub poses: Option<PoseSource>,
    /// Name of the files without extension, for the include directives of C.
    pub name: &'a str,
}

/// Constants of a scene.
#[derive(Debug, Clone)]
pub struct BakedScene {
    /// Files of the source; the file with the certificate is first.
    pub files: Vec<BakedFile>,
    /// Bearings in the order of the source.
    pub bearings: Vec<Baked>,
}

/// One file of the source.
#[derive(Debug, Clone)]
pub struct BakedFile {
    /// Extension of the file name; `None` if any extension is allowed.
    pub extension: Option<&'static str>,
    /// Content.
    pub source: String,
}

/// One bearing to write.
struct Part<'a> {
    of: &'a Bearing,
    table: Option<TableData>,
    certificate: BearingCertificate,
}

/// Returns the source with the constants of one bearing, or of every bearing, the flexible or supported rotor and the observer.
///
/// `text` is the text of the scene.
///
/// # Errors
/// Returns an error if a model, an effect, the rotor or the observer has no constants, if a state of the table has no equilibrium, or
/// if the source of the poses cannot be read.
pub fn bake(scene: &Scene, text: &str, options: &BakeOptions<'_>) -> Result<BakedScene> {
    let chosen: Vec<&Bearing> = match options.bearing {
        Some(_) => vec![build::pick(scene, options.bearing)?],
        None => scene.bearings.iter().collect(),
    };
    check_names(scene, &chosen)?;
    if options.language == Language::C {
        c::check(scene, &chosen, options.bearing.is_none())?;
    }
    for of in &chosen {
        check_model(scene, of)?;
    }
    let tables: Vec<Option<TableData>> = chosen.iter().map(|of| table(scene, of)).collect::<Result<_>>()?;
    let with_tables: Vec<_> = chosen.iter().copied().zip(tables.iter().map(Option::as_ref)).collect();
    let certificate = Certificate::try_new((scene, text), options, &with_tables)?;
    let parts = chosen.iter().zip(tables).zip(&certificate.bearings);
    let parts: Vec<Part<'_>> =
        parts.map(|((of, table), certificate)| Part { of, table, certificate: certificate.clone() }).collect();
    let comments = Comments { certificate: certificate.text(), scene: text };
    let files = match options.language {
        Language::Rust => {
            vec![BakedFile { extension: None, source: source(scene, &parts, &comments, options.bearing.is_none())? }]
        }
        Language::C => c::files((scene, options.bearing.is_none()), &parts, &comments, options.name)?,
    };
    Ok(BakedScene { files, bearings: parts.into_iter().map(Baked::of).collect() })
}

/// Text for the comments of the source.
struct Comments<'a> {
    certificate: String,
    scene: &'a str,
}

/// Returns the module of Rust.
fn source(scene: &Scene, parts: &[Part<'_>], comments: &Comments<'_>, whole: bool) -> Result<String> {
    let mut source = head(scene, &comments.certificate);
    for part in parts {
        source += &module(scene, part)?;
    }
    if whole {
        rotor::module(&mut source, scene)?;
        observer::module(&mut source, scene)?;
    }
    source += "\n// Text of the scene.\n";
    source += &embedded::SCENE.write(comments.scene);
    Ok(source)
}

/// Returns the table of a bearing whose constants have one.
fn table(scene: &Scene, of: &Bearing) -> Result<Option<TableData>> {
    Ok(match baked_model(of.model) {
        Model::Tabulated => Some(build::table(scene, of, build::FIRMWARE_TABLE)?),
        _ => None,
    })
}

/// Rejects models without constants.
fn check_model(scene: &Scene, of: &Bearing) -> Result<(), BakeError> {
    let rigid = of.has_rigid_outer_ring();
    match of.model {
        Model::Lumped if !rigid => {}
        Model::Dynamic => {}
        _ => return Ok(()),
    }
    Err(BakeError::Model { file: scene.path.clone(), bearing: of.name.clone(), found: of.model.name() })
}

/// Checks that no two bearings have the same module name.
fn check_names(scene: &Scene, chosen: &[&Bearing]) -> Result<(), BakeError> {
    for (i, of) in chosen.iter().enumerate() {
        let same = |other: &&&Bearing| identifier(&other.name) == identifier(&of.name);
        if let Some(other) = chosen.iter().take(i).find(same) {
            return Err(BakeError::SameModule {
                file: scene.path.clone(),
                module: identifier(&of.name),
                bearings: [other.name.clone(), of.name.clone()],
            });
        }
    }
    Ok(())
}

/// Constants of one bearing.
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
    /// Accuracy, cost and checksum.
    #[serde(flatten)]
    pub certificate: BearingCertificate,
}

/// Returns the model of the written constants: a table for the quasi-static model, else `model` itself.
fn baked_model(model: Model) -> Model {
    if model == Model::QuasiStatic { Model::Tabulated } else { model }
}

/// Returns the displacement by preload in the constants; zero for springs, whose force includes the preload.
fn preload_offset(scene: &Scene, of: &Bearing) -> Result<Displacement<f64>> {
    let model = match of.model {
        Model::Linear => return Ok(Displacement::default()),
        Model::Tabulated => Model::QuasiStatic,
        model => model,
    };
    let plain = build::bearing(scene, of, model)?;
    Ok(build::preload_offset(scene, of, &plain)?.unwrap_or_default())
}

impl Baked {
    fn of(part: Part<'_>) -> Self {
        let Part { of, table, certificate } = part;
        Self {
            bearing: of.name.clone(),
            module: certificate.module.clone(),
            nodes: table.map_or(0, |made| made.nodes.len()),
            bytes: certificate.table_bytes,
            certificate,
        }
    }
}

/// Bytes of an element, of a table's grid with its flag, and of the displacement by preload, on a core of 32 bits.
const ELEMENT_BYTES: usize = size_of::<ElementPosition<f32>>();
const GRID_BYTES: usize = 2 * 4 + 3 * (4 + 4 * 4) + 4;
const OFFSET_BYTES: usize = size_of::<Displacement<f32>>();

impl ConstantBytes {
    fn of(of: &Bearing, table: Option<&TableData>) -> Self {
        let table = table.map_or(0, |made| made.nodes.len() * made.fields() * size_of::<f32>());
        Self { table, others: constant_bytes(of) }
    }
}

/// Returns the size of a bearing's constants without its table, bytes.
fn constant_bytes(of: &Bearing) -> usize {
    let features = of.waviness.len() + of.defect.len();
    let elements = of.elements * ELEMENT_BYTES + features * size_of::<Feature<f32>>() + OFFSET_BYTES;
    let law = |exponent| if matches!(build::Exponent::of(exponent), build::Exponent::Other) { 8 } else { 4 };
    let radial_exponent = of.law.map_or(1.5, |law| law.exponent);
    match of.model {
        Model::Linear => 4 * (25 + 5 + 5),
        Model::Angular => elements + size_of::<AngularConstants<f32>>(),
        Model::Tabulated | Model::QuasiStatic => elements + size_of::<TableConstants<f32>>() + GRID_BYTES,
        Model::Lumped | Model::Dynamic => {
            let axial = of.axial.map_or(0, |axial| of.elements * ELEMENT_BYTES + law(axial.exponent) + 2 * 4);
            elements + law(radial_exponent) + 4 + axial
        }
    }
}

/// Writes range, value and function of the checksum.
fn checksum_constants(out: &mut String, certificate: &BearingCertificate) -> Result<()> {
    let ChecksumRange { centre, amplitude, inner_speed, outer_speed } = &certificate.range;
    writeln!(out, "\n    use ballrace::bearing::checksum::ChecksumRange;\n")?;
    writeln!(out, "    /// Displacements and speeds of the checksum.")?;
    writeln!(out, "    pub const CHECKSUM_RANGE: ChecksumRange = ChecksumRange {{")?;
    writeln!(out, "        centre: {},", displacement_text(centre))?;
    writeln!(out, "        amplitude: {},", displacement_text(amplitude))?;
    writeln!(out, "        inner_speed: {inner_speed:?},\n        outer_speed: {outer_speed:?},\n    }};")?;
    writeln!(out, "    /// Checksum of 1024 forces, computed on the desktop.")?;
    writeln!(out, "    pub const CHECKSUM: u64 = {:#018x};\n", certificate.checksum)?;
    writeln!(out, "    /// Computes the checksum; every target returns [`CHECKSUM`]. For start-up: 1024 forces.")?;
    writeln!(
        out,
        "    #[must_use]\n    pub fn checksum() -> u64 {{\n        CHECKSUM_RANGE.checksum(&bearing())\n    }}"
    )?;
    Ok(())
}

fn displacement_text(of: &Displacement<f32>) -> String {
    let Displacement { u, v, w, thu, thv } = of;
    format!("Displacement {{ u: {u:?}, v: {v:?}, w: {w:?}, thu: {thu:?}, thv: {thv:?} }}")
}

/// Returns rows of numbers as a Rust array of arrays in `f64`.
fn matrix_text<R: AsRef<[f64]>>(rows: &[R]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| format!("{:?}", row.as_ref())).collect();
    format!("[{}]", rows.join(", "))
}

fn head(scene: &Scene, certificate: &str) -> String {
    format!(
        "//! Made by `ballrace bake` from the scene {:?}. Do not edit: bake the scene again.\n\
         #![allow(dead_code, unused_imports, clippy::excessive_precision, clippy::unreadable_literal)]\n\n\
         // `ballrace verify` computes these fields and all constants again from the scene at the end of this file.\n{}",
        scene.name,
        embedded::CERTIFICATE.write(certificate)
    )
}

/// Returns a valid module name.
fn identifier(name: &str) -> String {
    let letters = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
    format!("bearing_{}", letters.collect::<String>())
}

fn module(scene: &Scene, part: &Part<'_>) -> Result<String> {
    let mut out = String::new();
    let of = part.of;
    writeln!(out, "\n/// Bearing {:?}.\npub mod {} {{", of.name, part.certificate.module)?;
    if let Some(made) = &part.table {
        constants(&mut out, scene, of, made)?;
        bearing_function(&mut out, of, made.fields())?;
    } else {
        direct::module(&mut out, scene, of)?;
    }
    checksum_constants(&mut out, &part.certificate)?;
    writeln!(out, "}}")?;
    Ok(out)
}

/// Writes station, speed ratios, displacement by preload, and element positions.
fn position_constants(out: &mut String, scene: &Scene, of: &Bearing) -> Result<()> {
    let kinematics = build::kinematics(scene, of)?;
    let offset = preload_offset(scene, of)?.to_array().map(|x| x as f32);
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

fn constants(out: &mut String, scene: &Scene, of: &Bearing, made: &TableData) -> Result<()> {
    let fields = made.fields();
    let constants = made.constants.rounded::<f32>();
    let grid = made.grid.rounded::<f32>();
    writeln!(out, "    use ballrace::bearing::ElementPosition;")?;
    writeln!(out, "    use ballrace::bearing::quasi_static::TableConstants;")?;
    surface_imports(out, of)?;
    writeln!(out, "    use ballrace::bearing::tabulated::{{Axis, Grid, Node, Table, Tabulated}};")?;
    writeln!(out, "    use ballrace::{{Displacement, Exact, Phase}};\n")?;
    position_constants(out, scene, of)?;
    writeln!(
        out,
        "    const CONSTANTS: TableConstants<f32> = TableConstants {{ couple: {:?}, distance: {:?}, axis: {:?}, offset: {:?}, arm: {:?} }};",
        constants.couple, constants.distance, constants.axis, constants.offset, constants.arm
    )?;
    writeln!(out, "    const GRID: Grid<f32> = Grid {{")?;
    writeln!(out, "        scale: {:?},\n        speed_scale: {:?},", grid.scale, grid.speed_scale)?;
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
