//! Writes the constants of a scene for firmware, as source code or as a blob, with a certificate.
//!
//! The source has the bearings (element positions, table and surface deviations, without arithmetic at start-up), the observer of a
//! scene with `[observer]` and, in Rust, the matrices of a flexible or supported rotor.

mod accuracy;
mod axial;
mod blob;
mod c;
mod certificate;
mod embedded;
mod fixed_point;
mod observer;
mod range;
mod rotor;
pub mod verify;

pub use accuracy::PoseSource;
pub use axial::UnmeasuredAxial;
pub use certificate::{BearingCertificate, Certificate, Field};
pub use fixed_point::FixedPointPath;
pub use range::Coverage;

pub use crate::trade::Core;
use ballrace::bearing::checksum::ChecksumRange;
use ballrace_models::bearing_model;
use ballrace_models::build::{self, AnyBearing, TableData};
use ballrace_models::model::rust::displacement_text;
use ballrace_models::model::{Constants, FirmwareModel};
use ballrace_plant::Plant;
use ballrace_plant::error::{BakeError, Result};
use ballrace_scene::{Bearing, Model, Scene};
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
    /// A binary file that firmware checks and uses in place, with its certificate as a text.
    Blob,
}

impl Language {
    /// All languages by their names.
    pub const ALL: [(&'static str, Self); 3] = [("rust", Self::Rust), ("c", Self::C), ("blob", Self::Blob)];

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
    pub content: Vec<u8>,
}

impl BakedFile {
    /// Returns the text; empty for a binary file.
    #[must_use]
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.content).unwrap_or_default()
    }
}

/// One selected bearing, whose model has constants.
#[derive(Clone, Copy)]
struct Selected<'a> {
    of: &'a Bearing,
    firmware: &'static dyn FirmwareModel,
}

impl<'a> Selected<'a> {
    /// Rejects models without constants.
    fn try_new(scene: &Scene, of: &'a Bearing) -> Result<Self, BakeError> {
        let error = || {
            let rows = of.rollers.as_ref().map_or(1, |rollers| rollers.kind.rows());
            let (what, expected) = match of.model {
                _ if rows > 1 => {
                    ("two rows of rollers have no constants in bake", "model = \"linear\" with linearise = \"roller\"")
                }
                Model::QuasiStaticRoller => ("rollers in equilibrium have no constants in bake", "model = \"roller\""),
                model if model.properties().moving_elements => {
                    ("elements that move have no constants in bake", "any other model")
                }
                _ => ("an outer ring that is displaced or bends has no constants in bake", "a rigid one"),
            };
            let (file, bearing) = (scene.path.clone(), of.name.clone());
            BakeError::Model { file, bearing, what, found: of.model.name(), expected }
        };
        Ok(Self { of, firmware: bearing_model(of.model).firmware(of).ok_or_else(error)? })
    }
}

/// One bearing to write.
struct Part<'a> {
    selected: Selected<'a>,
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
    chosen.iter().try_for_each(|of| build::check_has_forces(scene, of))?;
    check_names(scene, &chosen)?;
    match options.language {
        Language::Rust => {}
        Language::C => c::check(scene, &chosen, (Language::C, options.bearing.is_none()))?,
        // A blob has the bearings alone.
        Language::Blob => c::check(scene, &chosen, (Language::Blob, false))?,
    }
    let selected = chosen.iter().map(|of| Selected::try_new(scene, of)).collect::<Result<Vec<_>, BakeError>>()?;
    let tables = selected.iter().map(|one| one.firmware.table(scene, one.of)).collect::<Result<Vec<_>, _>>()?;
    let with_tables: Vec<_> = selected.iter().copied().zip(tables.iter().map(Option::as_ref)).collect();
    let certificate = Certificate::try_new((scene, text), options, &with_tables)?;
    let parts = selected.into_iter().zip(tables).zip(&certificate.bearings);
    let parts: Vec<Part<'_>> = parts
        .map(|((selected, table), certificate)| Part { selected, table, certificate: certificate.clone() })
        .collect();
    let comments = Comments { certificate: certificate.text(), scene: text };
    let files = match options.language {
        Language::Rust => {
            let source = source(scene, &parts, &comments, options.bearing.is_none())?;
            vec![BakedFile { extension: None, content: source.into() }]
        }
        Language::C => c::files((scene, options.bearing.is_none()), &parts, &comments, options.name)?,
        Language::Blob => blob::files(scene, &parts, &comments)?,
    };
    let unmeasured = axial::unmeasured(scene);
    let baked = |part: Part<'_>| {
        let index = scene.bearings.iter().position(|of| of.name == part.selected.of.name);
        Baked::of(part, index.and_then(|index| *unmeasured.get(index)?), options.core)
    };
    Ok(BakedScene { files, bearings: parts.into_iter().map(baked).collect() })
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
    /// Axial displacement that the bearing needs and no probe of the scene measures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unmeasured_axial: Option<UnmeasuredAxial>,
    /// Parameters of the path with a constant number of instructions on a core without a floating-point unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed_point: Option<FixedPointPath>,
    /// Accuracy, cost and checksum.
    #[serde(flatten)]
    pub certificate: BearingCertificate,
}

impl Baked {
    fn of(part: Part<'_>, unmeasured_axial: Option<UnmeasuredAxial>, core: Core) -> Self {
        let Part { selected: Selected { of, .. }, table, certificate } = part;
        Self {
            unmeasured_axial,
            fixed_point: FixedPointPath::of(of, core, table.as_ref(), &certificate.range),
            bearing: of.name.clone(),
            module: certificate.module.clone(),
            nodes: table.as_ref().map_or(0, |made| made.nodes.len()),
            bytes: certificate.table_bytes,
            certificate,
        }
    }
}

impl ConstantBytes {
    fn of(Selected { of, firmware }: Selected<'_>, table: Option<&TableData>) -> Self {
        Self { table: table.map_or(0, TableData::bytes), others: firmware.constant_bytes(of) }
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
    let Selected { of, firmware } = part.selected;
    writeln!(out, "\n/// Bearing {:?}.\npub mod {} {{", of.name, part.certificate.module)?;
    let springs = linearised(scene, of)?;
    let offset = build::offset_as_mounted(scene, of)?;
    let constants = Constants { scene, of, table: part.table.as_ref(), offset, springs: springs.as_ref() };
    firmware.write_rust(&mut out, &constants)?;
    checksum_constants(&mut out, &part.certificate)?;
    writeln!(out, "}}")?;
    Ok(out)
}

/// Returns the springs of a linearised bearing, at the equilibrium of its rotor.
fn linearised(scene: &Scene, of: &Bearing) -> Result<Option<AnyBearing<f64>>> {
    if !of.is_linearised() {
        return Ok(None);
    }
    Ok(Some(Plant::try_new(scene)?.mounted(&of.name)?.bearing.clone()))
}
