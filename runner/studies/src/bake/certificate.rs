//! Certificate of a baked scene: origin, accuracy, cost and checksum, as fields in the comments of the source.

use super::accuracy::{Accuracy, BakedModel, PoseSource, accuracy, poses, totals};
use super::embedded::escaped;
use super::range::{Coverage, range};
use super::{BakeOptions, Core, Language, Selected, identifier};
use crate::trade::{Cost, cores};
use ballrace::bearing::LastValidWrench;
use ballrace::bearing::checksum::{CHECKSUM_SAMPLES, ChecksumRange};
use ballrace_base::bounded::open_regular;
use ballrace_base::sha256;
use ballrace_models::build::TableData;
use ballrace_models::handle::ForceModel;
use ballrace_plant::error::{BakeError, Result};
use ballrace_scene::{Bearing, Facing, Scene};
use std::iter;
use std::path::{Path, PathBuf};

/// Program and version that write a certificate.
pub const PROGRAM: &str = concat!("ballrace ", env!("CARGO_PKG_VERSION"));

/// Names of the fields that `verify` reads.
pub(crate) const PROGRAM_FIELD: &str = "program";
pub(crate) const LANGUAGE_FIELD: &str = "language";
pub(crate) const BEARINGS_FIELD: &str = "bearings";
pub(crate) const SCENE_FILE_FIELD: &str = "scene file";
pub(crate) const POSES_FIELD: &str = "poses from";
pub(crate) const CORE_FIELD: &str = "core";
/// Value of [`BEARINGS_FIELD`] for a whole scene, and start of the value for one bearing.
pub(crate) const ALL_BEARINGS: &str = "all";
pub(crate) const ONE_BEARING: &str = "only ";

/// One line of a certificate.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Field {
    /// Name; the field of a bearing starts with the name of its module.
    pub name: String,
    /// Value with its unit.
    pub value: String,
}

/// File that the scene refers to.
#[derive(Debug, Clone, PartialEq, Eq)]
struct ReferencedFile {
    /// Path as in the scene.
    name: String,
    /// SHA-256; `None` if the file cannot be read.
    hash: Option<String>,
}

/// Certificate of a baked scene.
#[derive(Debug, Clone)]
pub struct Certificate {
    language: Language,
    core: Core,
    selected: Option<String>,
    scene: String,
    scene_file: String,
    scene_hash: String,
    files: Vec<ReferencedFile>,
    pose_source: PoseSource,
    /// Bearings in the order of the source.
    pub bearings: Vec<BearingCertificate>,
}

/// Accuracy, cost and checksum of one bearing.
#[derive(Debug, Clone, serde::Serialize)]
pub struct BearingCertificate {
    /// Name of its module, or of its constants in C.
    #[serde(skip)]
    pub module: String,
    #[serde(skip)]
    bearing: String,
    /// Model of the constants.
    pub model: &'static str,
    /// Number of rolling elements.
    pub elements: usize,
    /// Source of the poses.
    pub poses_from: PoseSource,
    /// Number of poses.
    pub poses: usize,
    /// Reference model of the error, in double precision.
    pub reference: String,
    /// Largest load of the reference over the poses, N.
    pub largest_load: f64,
    /// Largest error over the poses, N, rounded up.
    pub error: f64,
    /// Largest error over the largest load, rounded up; `None` without load.
    pub relative_error: Option<f64>,
    /// Cost of one sample on the core; `None` if the model has no counted cost.
    pub cost: Option<Cost>,
    /// Flash memory of the table, bytes.
    pub table_bytes: usize,
    /// Flash memory of the other constants, bytes.
    pub constant_bytes: usize,
    /// Checksum of the evaluations.
    #[serde(serialize_with = "hexadecimal")]
    pub checksum: u64,
    /// Samples of the checksum at the limits of the model.
    pub coverage: Coverage,
    /// Displacements and speeds of the checksum.
    #[serde(skip)]
    pub range: ChecksumRange,
}

fn hexadecimal<S: serde::Serializer>(checksum: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&format!("{checksum:#018x}"))
}

/// Bytes of the constants of one bearing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct ConstantBytes {
    /// Nodes of the table.
    pub table: usize,
    /// Elements, model, surface deviations.
    pub others: usize,
}

impl Certificate {
    /// Computes the certificate of the bearings `chosen`, with their tables.
    ///
    /// # Errors
    /// Returns an error if a bearing or its poses cannot be built.
    pub(super) fn try_new(
        (scene, text): (&Scene, &str),
        options: &BakeOptions<'_>,
        chosen: &[(Selected<'_>, Option<&TableData>)],
    ) -> Result<Self> {
        let (pose_source, poses) = poses(scene, options.poses)?;
        let bearing = |&(selected, table): &(Selected<'_>, Option<&TableData>)| -> Result<BearingCertificate> {
            let of = selected.of;
            let index = scene.bearings.iter().position(|bearing| bearing.name == of.name).unwrap_or_default();
            let baked = BakedModel::try_new(scene, selected, table, options.language)?;
            let totals = poses.as_ref().and_then(|poses| poses.get(index)).map(|poses| totals(poses, &baked.offset));
            let (range, coverage) = range((scene, of), &baked, totals.as_deref());
            let found = accuracy((scene, text), index, &baked, (poses.as_ref(), &range))?;
            check_finite((scene, of), &found, &range)?;
            Ok(BearingCertificate::new(
                of,
                &baked,
                &found,
                (pose_source, options),
                ConstantBytes::of(selected, table),
                (range, coverage),
            ))
        };
        Ok(Self {
            language: options.language,
            core: options.core,
            selected: options.bearing.map(str::to_owned),
            scene: scene.name.clone(),
            scene_file: scene.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            scene_hash: sha256::of(text.as_bytes()).map(|(hash, _)| hash).unwrap_or_default(),
            files: referenced_files(scene),
            pose_source,
            bearings: chosen.iter().map(bearing).collect::<Result<_>>()?,
        })
    }

    /// Returns the fields in the order of the source.
    #[must_use]
    pub fn fields(&self) -> Vec<Field> {
        let field = |name: &str, value: &str| Field { name: name.to_owned(), value: value.to_owned() };
        let selected = self.selected.as_ref();
        let mut fields = vec![
            field(PROGRAM_FIELD, PROGRAM),
            field(LANGUAGE_FIELD, self.language.name()),
            field(BEARINGS_FIELD, &selected.map_or(ALL_BEARINGS.to_owned(), |name| format!("{ONE_BEARING}{name}"))),
            field("scene", &self.scene),
            field(SCENE_FILE_FIELD, &self.scene_file),
            field("scene SHA-256", &self.scene_hash),
        ];
        for file in &self.files {
            fields.push(field(&format!("{} SHA-256", file.name), file.hash.as_deref().unwrap_or("absent")));
        }
        fields.push(field(POSES_FIELD, self.pose_source.name()));
        fields.push(field(CORE_FIELD, self.core.name()));
        fields.push(field("arithmetic", "f32, exact"));
        for bearing in &self.bearings {
            let own = bearing.values().into_iter();
            fields.extend(own.map(|(name, value)| field(&format!("{} {name}", bearing.module), &value)));
        }
        fields
    }

    /// Returns the text of the block of comments.
    #[must_use]
    pub fn text(&self) -> String {
        let line = |field: &Field| format!("{}: {}", one_line(&field.name), one_line(&field.value));
        self.fields().iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

/// Rejects figures that are no numbers.
fn check_finite(
    (scene, of): (&Scene, &Bearing),
    found: &Accuracy,
    range: &ChecksumRange,
) -> std::result::Result<(), BakeError> {
    let figures = [
        (found.largest_load.is_finite(), "the largest load"),
        (found.error.is_finite(), "the largest error"),
        (range.centre.is_finite() && range.amplitude.is_finite(), "a displacement of the checksum"),
    ];
    match figures.into_iter().find(|(is_finite, _)| !is_finite) {
        Some((_, figure)) => Err(BakeError::NotFinite { file: scene.path.clone(), bearing: of.name.clone(), figure }),
        None => Ok(()),
    }
}

/// Returns a name from a scene without line breaks.
fn one_line(text: &str) -> String {
    if text.contains('\n') { escaped(text) } else { text.to_owned() }
}

/// Returns the fields of a block of comments; `None` if a line has no name.
#[must_use]
pub fn parsed(text: &str) -> Option<Vec<Field>> {
    let field = |line: &str| {
        let (name, value) = line.split_once(": ")?;
        Some(Field { name: name.to_owned(), value: value.to_owned() })
    };
    text.lines().map(field).collect()
}

impl BearingCertificate {
    fn new(
        of: &Bearing,
        baked: &BakedModel,
        found: &Accuracy,
        (poses_from, options): (PoseSource, &BakeOptions<'_>),
        bytes: ConstantBytes,
        (range, coverage): (ChecksumRange, Coverage),
    ) -> Self {
        let as_written = Bearing { model: baked.model, own: vec![], ..of.clone() };
        let cost = cores::sample(options.core, &as_written, "f32", "exact").ok();
        // A mirrored model and a call from C have a few more instructions than the counted function.
        let exact_row = of.facing != Facing::MinusZ && options.language == Language::Rust;
        let mut last_valid = LastValidWrench::new();
        Self {
            module: identifier(&of.name),
            bearing: of.name.clone(),
            model: baked.model.name(),
            elements: of.elements,
            poses_from: if found.is_of_checksum { PoseSource::Checksum } else { poses_from },
            poses: found.poses,
            reference: found.reference.clone(),
            largest_load: found.largest_load,
            error: rounded_up(found.error),
            relative_error: (found.largest_load > 0.0).then(|| rounded_up(found.error / found.largest_load)),
            cost: cost.map(|cost| Cost { counted: cost.counted && exact_row, ..cost }),
            table_bytes: bytes.table,
            constant_bytes: bytes.others,
            checksum: range.checksum_of(|u, at| baked.force.sample(&mut last_valid, u, at)),
            coverage,
            range,
        }
    }

    /// Returns names and values of the fields.
    fn values(&self) -> Vec<(&'static str, String)> {
        let cost = |part: fn(&Cost) -> Option<f64>, unit: &str| match &self.cost {
            Some(cost) => part(cost).map_or_else(
                || "not measured".to_owned(),
                |figure| format!("{}{figure:.0}{unit}", if cost.counted { "" } else { "~" }),
            ),
            None => "not counted".to_owned(),
        };
        let instructions = match self.cost.and_then(|cost| cost.least_instructions) {
            Some(least) => {
                let most = cost(|cost| Some(cost.instructions), "");
                let (about, most) = most.strip_prefix('~').map_or(("", most.as_str()), |most| ("~", most));
                format!("{about}{least:.0} to {most}, by the input")
            }
            None => cost(|cost| Some(cost.instructions), ""),
        };
        let Coverage { contact_lost, out_of_table } = self.coverage;
        let relative = self.relative_error.map_or("-".to_owned(), |error| format!("{error:.1e}"));
        vec![
            ("bearing", self.bearing.clone()),
            ("model", format!("{}, {} elements", self.model, self.elements)),
            ("poses", format!("{}, {}", self.poses, self.poses_from.name())),
            ("reference", format!("{}, f64", self.reference)),
            ("largest load", format!("{:.3e} N", self.largest_load)),
            ("largest error", format!("{:.1e} N", self.error)),
            ("largest relative error", relative),
            ("instructions", instructions),
            ("cycles", cost(|cost| cost.cycles, "")),
            ("stack", cost(|cost| cost.stack, " bytes")),
            ("flash of code", cost(|cost| cost.flash, " bytes")),
            ("flash of table", format!("{} bytes", self.table_bytes)),
            ("flash of other constants", format!("{} bytes", self.constant_bytes)),
            (
                "checksum samples",
                format!("{CHECKSUM_SAMPLES}, {contact_lost} without contact, {out_of_table} outside the table"),
            ),
            ("checksum", format!("{:#018x}", self.checksum)),
        ]
    }
}

/// Returns the number rounded up to two digits.
fn rounded_up(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return x;
    }
    let unit = 10.0_f64.powi(x.log10().floor() as i32 - 1);
    let digits = (x / unit).ceil();
    // The decimal text gives the same number on every desktop.
    format!("{:.1e}", digits * unit).parse().unwrap_or(x)
}

/// Returns the files that the scene refers to, in the order of its keys.
fn referenced_files(scene: &Scene) -> Vec<ReferencedFile> {
    let folder = scene.path.parent().unwrap_or(Path::new(""));
    let system = scene.system.iter().flat_map(|system| {
        let required = [Some(&system.mass), system.damping.as_ref(), system.gyroscopic.as_ref()];
        required.into_iter().chain([Some(&system.stiffness), system.load.as_ref()]).flatten()
    });
    let paths = system
        .chain(scene.recording.iter().flat_map(|recording| iter::once(&recording.file).chain(&recording.run_out)));
    let file = |path: &PathBuf| ReferencedFile {
        name: path.strip_prefix(folder).unwrap_or(path).to_string_lossy().into_owned(),
        hash: open_regular(path).and_then(sha256::of).map(|(hash, _)| hash).ok(),
    };
    paths.map(file).collect()
}

#[cfg(test)]
mod tests {
    use super::{Field, parsed, rounded_up};

    #[test]
    fn errors_are_rounded_up_to_two_digits() {
        for (x, up) in [(0.001_23, 0.0013), (0.0012, 0.0012), (9.91, 10.0), (99.0, 99.0), (3.0e-8, 3.0e-8), (0.0, 0.0)]
        {
            assert_eq!(rounded_up(x), up, "{x}");
        }
        assert!(rounded_up(f64::INFINITY).is_infinite());
    }

    #[test]
    fn fields_are_lines_with_a_name() {
        let field = |name: &str, value: &str| Field { name: name.to_owned(), value: value.to_owned() };
        assert_eq!(parsed("a: 1\nb c: x: y"), Some(vec![field("a", "1"), field("b c", "x: y")]));
        assert_eq!(parsed("a: 1\nb"), None);
    }
}
