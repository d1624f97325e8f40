//! `ballrace force`: forces of a bearing for given ring displacements.

use super::{Format, print_effects};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace::{BearingKinematicState, Displacement, Phase, Status};
use ballrace_report::number::fixed;
use ballrace_twin::effect_significance::{self, EffectSignificance};
use ballrace_twin::force::{BearingForce, MathBackend, Precision};
use ballrace_twin::printable;
use ballrace_twin::recording::error::listed;
use ballrace_twin::scene::bounded::BoundedLines;
use ballrace_twin::scene::bounded::open_regular;
use ballrace_twin::scene::build;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::{Bearing, Model, Scene};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Maximum length of a line of the displacement file, bytes.
const MAX_LINE_LENGTH: usize = 1 << 20;
/// Maximum number of rows of the displacement file; the forces of this many rows take 2 GB.
const MAX_ROWS: usize = 10_000_000;

/// Columns of the output.
const BITS: [&str; 6] = ["FX", "FY", "FZ", "MX", "MY", "status"];

/// Arguments of `force`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// CSV file with the columns u,v,w,thu,thv (SI), optionally t (s) or cage_angle (rad), or of a device log cage_phase, inner_phase,
    /// outer_phase, ball_phase (2^-64 revolutions), inner_speed, outer_speed (rad/s). A cell that begins with 0x has the bits.
    #[arg(long, value_name = "F.csv")]
    displacements: PathBuf,
    /// Bearing to evaluate; required if the scene has several.
    #[arg(long, value_name = "NAME")]
    bearing: Option<String>,
    /// Model to use instead of the scene's.
    #[arg(long, value_parser = models_with_forces())]
    model: Option<Model>,
    /// Floating-point precision of the kernel.
    #[arg(long, value_enum, default_value_t = Precision::F64)]
    precision: Precision,
    /// Implementation of square roots and powers.
    #[arg(long, value_enum, default_value_t = MathBackend::Exact)]
    math: MathBackend,
    /// Print forces and status as bits in hexadecimal digits, as a device logs them.
    #[arg(long)]
    bits: bool,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Returns the parser of the models with forces of their own.
fn models_with_forces() -> impl TypedValueParser<Value = Model> {
    let models = Model::with_forces().filter(|model| !model.properties().moving_elements);
    PossibleValuesParser::new(models.map(Model::name)).try_map(|name| Model::from_name(&name).ok_or("no such model"))
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the scene or the displacements are invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    let bearing = build::pick(&scene, args.bearing.as_deref()).map_err(UsageError::with_bearing_option)?;
    let model = args.model.unwrap_or(bearing.model);
    let kinematics_at = |time| Ok(build::rotation_at(&scene, bearing, time).map_err(UsageError::new)?);
    // An invalid scene is reported before an invalid file of displacements.
    kinematics_at(0.0)?;
    let rows = read_displacements(&args.displacements, &kinematics_at)?;
    let model_force = BearingForce::try_new(&scene, bearing, model, (args.precision, args.math))?;
    let (displacements, rotations): (Vec<_>, Vec<_>) = rows.iter().map(|row| (row.u, row.at)).unzip();
    let (mut forces, mut status) = (vec![[0.0; 5]; rows.len()], vec![Status::default(); rows.len()]);
    model_force.evaluate(&displacements, &|i| rotations[i], &mut forces, &mut status);
    let forces: Vec<Force> = forces.into_iter().zip(status).map(|(force, status)| Force::new(force, status)).collect();
    let digits = match args.precision {
        Precision::F64 => 16,
        Precision::F32 => 8,
    };
    if args.bits {
        print_bits(&forces, format, args.precision)?;
    } else {
        print(&forces, format, digits)?;
    }
    let significance = significance(&scene, bearing, model, &rows)?;
    if format == Format::Text {
        print_effects(&mut super::standard_output(format), &significance, error)
    } else {
        Ok(())
    }
}

/// Computes the significance of each effect at the largest finite displacement.
fn significance(scene: &Scene, bearing: &Bearing, model: Model, rows: &[Pose]) -> Result<Vec<EffectSignificance>> {
    let size = |row: &&Pose| row.u.iter().take(3).map(|x| x * x).sum::<f64>();
    let finite = rows.iter().filter(|row| size(row).is_finite());
    let Some(row) = finite.max_by(|a, b| size(a).total_cmp(&size(b))) else { return Ok(vec![]) };
    // The displacements already include preload and tilt.
    let alone = Bearing { model, preload: None, outer_ring_tilt: [0.0; 2], ..bearing.clone() };
    // Effects of inertia and film grow with the speed: the fastest one of the scene and of a device log counts.
    let (low, high) = scene.shaft.speed.range();
    let speeds = rows.iter().map(|row| row.at.inner_speed).chain([low, high]);
    let inner_speed = speeds.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(high);
    let at = BearingKinematicState { inner_speed, ..row.at };
    Ok(effect_significance::of_bearing(scene, &alone, &Displacement::from_array(row.u), &at)?)
}

/// A displacement of the inner ring relative to the outer ring, with the kinematic state of the bearing.
struct Pose {
    /// u, v, w (m), thu, thv (rad).
    u: [f64; 5],
    /// Angles and speeds of the components of the bearing.
    at: BearingKinematicState<f64>,
}

#[derive(Serialize)]
struct Force {
    #[serde(rename = "FX")]
    fx: f64,
    #[serde(rename = "FY")]
    fy: f64,
    #[serde(rename = "FZ")]
    fz: f64,
    #[serde(rename = "MX")]
    mx: f64,
    #[serde(rename = "MY")]
    my: f64,
    status: String,
    #[serde(skip)]
    flags: Status,
}

impl Force {
    fn new([fx, fy, fz, mx, my]: [f64; 5], status: Status) -> Self {
        Self { fx, fy, fz, mx, my, status: status_text(status), flags: status }
    }

    /// Returns forces and status as bits.
    fn bits(&self, precision: Precision) -> [String; 6] {
        let bits = |x: f64| match precision {
            Precision::F64 => format!("{:#018x}", x.to_bits()),
            Precision::F32 => format!("{:#010x}", (x as f32).to_bits()),
        };
        let Self { fx, fy, fz, mx, my, flags, .. } = self;
        let [fx, fy, fz, mx, my] = [fx, fy, fz, mx, my].map(|x| bits(*x));
        [fx, fy, fz, mx, my, format!("{:#04x}", flags.bits())]
    }
}

/// Returns the names of the set status flags, joined by `+`, or `ok`.
fn status_text(status: Status) -> String {
    let flags = [
        (Status::INPUT_NOT_FINITE, "input-not-finite"),
        (Status::RESULT_NOT_FINITE, "result-not-finite"),
        (Status::CONTACT_LOST, "contact-lost"),
        (Status::NOT_CONVERGED, "not-converged"),
        (Status::GYROSCOPIC_SLIP, "gyroscopic-slip"),
        (Status::OUT_OF_TABLE, "out-of-table"),
    ];
    let set: Vec<&str> = flags.iter().filter(|(flag, _)| status.contains(*flag)).map(|(_, name)| *name).collect();
    if set.is_empty() { "ok".to_owned() } else { set.join("+") }
}

/// Reads the displacements; `kinematics_at` returns the kinematic state of the bearing at a time.
fn read_displacements(
    path: &Path,
    kinematics_at: &impl Fn(f64) -> Result<BearingKinematicState<f64>>,
) -> Result<Vec<Pose>> {
    let name = path.display();
    if path.is_dir() {
        bail!("{name}: path is a folder, expected a CSV file with the columns u,v,w,thu,thv");
    }
    let file = open_regular(path).with_context(|| format!("{name}: this file cannot be read"))?;
    let mut reader = ::csv::ReaderBuilder::new()
        .trim(::csv::Trim::All)
        .flexible(true)
        .from_reader(BoundedLines::new(file, MAX_LINE_LENGTH));
    let header: Vec<String> =
        reader.headers().map_err(|e| anyhow::anyhow!("{name}: {e}"))?.iter().map(str::to_owned).collect();
    if header.is_empty() {
        bail!("{name}: file is empty, expected a CSV file with the columns u,v,w,thu,thv");
    }
    let column = |wanted: &str| -> Result<Option<usize>> {
        let named = |(i, h): (usize, &String)| (h.trim_start_matches('\u{feff}') == wanted).then_some(i);
        let mut indices = header.iter().enumerate().filter_map(named);
        match (indices.next(), indices.next()) {
            (first, None) => Ok(first),
            (_, Some(_)) => bail!(UsageError(format!("{name}:1: two columns are named {wanted:?}, expected one"))),
        }
    };
    let mut indices = [0; 5];
    for (index, wanted) in indices.iter_mut().zip(["u", "v", "w", "thu", "thv"]) {
        *index = column(wanted)?.ok_or_else(|| {
            UsageError(format!(
                "{name}:1: missing column {wanted} among {}, expected u,v,w,thu,thv and optionally t, cage_angle or cage_phase",
                listed(&header)
            ))
        })?;
    }
    let (time, angle) = (column("t")?, column("cage_angle")?);
    if time.is_some() && angle.is_some() {
        bail!(UsageError(format!("{name}:1: both t and cage_angle are given, expected at most one")));
    }
    let (cage_phase, inner_phase) = (column("cage_phase")?, column("inner_phase")?);
    let (outer_phase, ball_phase) = (column("outer_phase")?, column("ball_phase")?);
    if angle.is_some() && cage_phase.is_some() {
        bail!(UsageError(format!("{name}:1: both cage_angle and cage_phase are given, expected at most one")));
    }
    let (inner_speed, outer_speed) = (column("inner_speed")?, column("outer_speed")?);
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
        let line = record.position().map_or(0, ::csv::Position::line);
        if rows.len() == MAX_ROWS {
            bail!("{name}:{line}: too many rows, expected at most {MAX_ROWS}");
        }
        if record.len() != header.len() {
            let (found, expected) = (record.len(), header.len());
            bail!("{name}:{line}: wrong number of cells: {found}, expected {expected} as in the header");
        }
        let invalid = |i: usize, text: &str, expected: &str| {
            anyhow::anyhow!(
                "{name}:{line}: column {}: invalid value: `{}`, expected {expected}",
                printable::name(header.get(i).map_or("", String::as_str)),
                printable::name(text)
            )
        };
        let cell = |i: usize| -> Result<f64> {
            let text = record.get(i).unwrap_or("");
            number(text).ok_or_else(|| invalid(i, text, "a number"))
        };
        let phase = |i: usize| -> Result<Phase> {
            let text = record.get(i).unwrap_or("");
            let counts = text.strip_prefix("0x").map_or_else(|| text.parse(), |digits| u64::from_str_radix(digits, 16));
            counts.map(Phase).map_err(|_| invalid(i, text, "an integer of 64 bits, in decimal digits or after 0x"))
        };
        let mut u = [0.0; 5];
        for (x, &index) in u.iter_mut().zip(&indices) {
            *x = cell(index)?;
        }
        let t = time.map_or(Ok(0.0), cell)?;
        let cage_angle = angle.map(cell).transpose()?;
        if !t.is_finite() || cage_angle.is_some_and(|a| !a.is_finite()) {
            // The kernel's angles are finite by type; a NaN displacement marks the row as invalid instead.
            u = [f64::NAN; 5];
        }
        let at = kinematics_at(if t.is_finite() { t } else { 0.0 })?;
        let or = |column: Option<usize>, otherwise: Phase| column.map_or(Ok(otherwise), phase);
        let at = BearingKinematicState {
            cage: or(cage_phase, cage_angle.map_or(at.cage, Phase::from_radians))?,
            inner: or(inner_phase, at.inner)?,
            outer: or(outer_phase, at.outer)?,
            ball: or(ball_phase, at.ball)?,
            inner_speed: inner_speed.map_or(Ok(at.inner_speed), cell)?,
            outer_speed: outer_speed.map_or(Ok(at.outer_speed), cell)?,
        };
        if !(at.inner_speed.is_finite() && at.outer_speed.is_finite()) {
            u = [f64::NAN; 5];
        }
        rows.push(Pose { u, at });
    }
    Ok(rows)
}

/// Returns a number from decimal digits, or from the bits of a number in single or double precision after `0x`.
fn number(text: &str) -> Option<f64> {
    match (text.strip_prefix("0x"), text.len()) {
        (Some(digits), 10) => u32::from_str_radix(digits, 16).ok().map(|bits| f64::from(f32::from_bits(bits))),
        (Some(digits), 18) => u64::from_str_radix(digits, 16).ok().map(f64::from_bits),
        (Some(_), _) => None,
        (None, _) => text.parse().ok(),
    }
}

/// Prints forces and status as bits.
fn print_bits(forces: &[Force], format: Format, precision: Precision) -> Result<()> {
    let mut out = super::standard_output(format);
    let rows: Vec<[String; 6]> = forces.iter().map(|force| force.bits(precision)).collect();
    if format == Format::Json {
        let named = |row: &[String; 6]| -> BTreeMap<&str, String> { BITS.into_iter().zip(row.clone()).collect() };
        serde_json::to_writer_pretty(&mut out, &rows.iter().map(named).collect::<Vec<_>>())?;
        writeln!(out)?;
    } else {
        writeln!(out, "{}", BITS.join(","))?;
        for row in rows {
            writeln!(out, "{}", row.join(","))?;
        }
    }
    Ok(out.flush()?)
}

fn print(forces: &[Force], format: Format, digits: usize) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => {
            serde_json::to_writer_pretty(&mut out, forces)?;
            writeln!(out)?;
        }
        Format::Csv => {
            writeln!(out, "FX,FY,FZ,MX,MY,status")?;
            for Force { fx, fy, fz, mx, my, status, .. } in forces {
                writeln!(out, "{fx:.digits$e},{fy:.digits$e},{fz:.digits$e},{mx:.digits$e},{my:.digits$e},{status}")?;
            }
        }
        Format::Text => {
            writeln!(
                out,
                "{:>6} {:>13} {:>13} {:>13} {:>13} {:>13}  status",
                "row", "FX N", "FY N", "FZ N", "MX N m", "MY N m"
            )?;
            for (i, Force { fx, fy, fz, mx, my, status, .. }) in forces.iter().enumerate() {
                let [fx, fy, fz] = [fx, fy, fz].map(|x| fixed(*x, 4));
                let [mx, my] = [mx, my].map(|x| fixed(*x, 6));
                writeln!(out, "{:>6} {fx:>13} {fy:>13} {fz:>13} {mx:>13} {my:>13}  {status}", i + 1)?;
            }
        }
    }
    Ok(out.flush()?)
}
