//! `ballrace balance`: influence coefficients, unknown masses and correction masses from vibration vectors, or from recordings of a scene.

use super::{Format, check_distinct_paths};
use crate::error::UsageError;
use anyhow::{Result, bail};
use ballrace_report::balance::{correction_csv, csv, html, text};
use ballrace_twin::balance::table::VectorTable;
use ballrace_twin::balance::{
    HoleOptions, Holes, MOST_WEIGHTS, Placement, Plane, Requirement, TolerancePlane, TwinCoefficients, balance,
};
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::Scene;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::{Dimension, parse};
use ballrace_twin::vectors::{RecordedRuns, vector_table};
use std::f64::consts::TAU;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `balance`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file of the machine, whose recordings are given by --run and --trial; its twin has influence coefficients of its own.
    #[arg(required_unless_present = "vectors", requires = "runs")]
    scene: Option<PathBuf>,
    /// Recording of the machine without added masses; repeat it for another one.
    #[arg(long = "run", value_name = "FILE", requires = "scene")]
    runs: Vec<PathBuf>,
    /// Recording with trial masses: "FILE: PLANE MOMENT at ANGLE", further masses after commas, e.g. "trial.csv: DE 5 g mm at 30 deg".
    ///
    /// PLANE is a bearing or a station as the scene draws it, such as "310 mm". ANGLE counts from the keyphasor mark in the direction of
    /// positive rotation.
    #[arg(long = "trial", value_name = "MASSES", requires = "scene")]
    trials: Vec<String>,
    /// Recording with correction masses that stay mounted, as --trial; the correction is then that of the rotor with the masses of the last one.
    #[arg(long = "trim", value_name = "MASSES", requires = "scene")]
    trims: Vec<String>,
    /// Planes of the correction, a bearing or a station each, separated by commas [default: those of the trials, else of the unbalances
    /// or disks of the scene].
    #[arg(long = "plane", value_name = "PLANE", requires = "scene", value_delimiter = ',', allow_hyphen_values = true)]
    planes: Vec<String>,
    /// Table of once-per-turn vectors: id, set (baseline, trial, trim or blind), `speed_rpm`, `PLANE_g_mm` and `PLANE_deg`, `PROBE_re_um` and `PROBE_im_um`.
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    vectors: Option<PathBuf>,
    /// Times of the runs: condition, speed, `unix_time_of_one_record` [default: times.csv beside the vectors, if it is there].
    #[arg(long, value_name = "FILE", requires = "vectors")]
    times: Option<PathBuf>,
    /// CSV file to write with the masses of the blind conditions.
    #[arg(short, long, value_name = "FILE", requires = "vectors")]
    output: Option<PathBuf>,
    /// Holes of a plane, evenly spread: "16" for all planes, "fan 12" for one, "fan 12 from 15 deg" where the first is not at 0.
    ///
    /// An entry of --holes, --radius, --hole-limit and --stock holds for the plane in front of it, or for all planes that the option does not name.
    /// Several are separated by commas.
    #[arg(long, value_name = "HOLES", requires = "radius", value_delimiter = ',', allow_hyphen_values = true)]
    holes: Vec<String>,
    /// Radius of the circle of holes, e.g. "30 mm", or "30 mm,fan 100 mm".
    #[arg(long, value_name = "R", requires = "holes", value_delimiter = ',', allow_hyphen_values = true)]
    radius: Vec<String>,
    /// Weights in stock, one for a hole, e.g. "0.4 g,0.8 g"; "3 x 0.8 g" where there are 3 for all planes, "fan 2 g" for the holes of a plane
    /// [default: any weight].
    #[arg(long, value_name = "M", requires = "holes", value_delimiter = ',', allow_hyphen_values = true)]
    stock: Vec<String>,
    /// Most weights of the stock in a plane.
    #[arg(long, value_name = "N", requires = "stock", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=MOST_WEIGHTS as i64))]
    weights: u8,
    /// Hole that takes no mass: "PLANE HOLE", e.g. "fan 3"; further ones after commas.
    #[arg(long, value_name = "HOLES", requires = "holes", value_delimiter = ',', allow_hyphen_values = true)]
    taken: Vec<String>,
    /// Largest mass of a hole, e.g. "5 g", or "fan 20 g"; what it does not hold goes to the holes beside it.
    #[arg(long, value_name = "M", requires = "holes", value_delimiter = ',', allow_hyphen_values = true)]
    hole_limit: Vec<String>,
    /// Remove masses, as by drilling, opposite to where they would be added.
    #[arg(long, conflicts_with = "stock")]
    remove: bool,
    /// Take off the masses of the last trim run: the correction is instead of them, not beside them.
    #[arg(long)]
    replace: bool,
    /// HTML page with polar plots of the vectors before and after the correction.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Balance quality grade of ISO 21940-11 that is asked for, e.g. G2.5.
    #[arg(long, value_name = "G", value_parser = parse_grade)]
    grade: Option<f64>,
    /// Mass of the rotor, e.g. "12 kg" [default: that of the scene].
    #[arg(long, value_name = "M", requires = "grade", value_parser = parse_mass)]
    mass: Option<f64>,
    /// Service speed, for which the grade is asked [default: the highest speed of the runs].
    #[arg(long, value_name = "SPEED", requires = "grade", value_parser = parse_speed)]
    service_speed: Option<f64>,
}

fn parse_mass(text: &str) -> Result<f64, String> {
    let mass = parse(text.trim(), Dimension::Mass).ok().filter(|mass| *mass > 0.0);
    mass.ok_or_else(|| format!("expected {}", Dimension::Mass.expected("above 0")))
}

fn parse_speed(text: &str) -> Result<f64, String> {
    let speed = parse(text, Dimension::Speed).ok().filter(|speed| *speed > 0.0);
    speed.ok_or_else(|| format!("expected {}", Dimension::Speed.expected("above 0")))
}

/// Parses a grade such as `G2.5`, mm/s.
fn parse_grade(text: &str) -> Result<f64, String> {
    let number = text.trim().strip_prefix(['G', 'g']).and_then(|number| number.trim().parse::<f64>().ok());
    let grade = number.filter(|grade| *grade > 0.0 && grade.is_finite());
    grade.ok_or_else(|| "expected a grade of ISO 21940-11, such as G2.5 or G6.3".to_owned())
}

/// Vectors of the runs, with what is known of the machine besides.
struct Input {
    table: VectorTable,
    /// Scene, its planes, and the coefficients of its twin.
    machine: Option<(Scene, Vec<Plane>, TwinCoefficients)>,
    /// File of the table or scene, for errors.
    file: PathBuf,
    /// File with the times of the runs.
    times: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the vectors are invalid or do not determine the coefficients, or the output cannot be written.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let Input { table, machine, file, times } = match (&args.scene, &args.vectors) {
        (Some(scene), _) => of_recordings(args, scene)?,
        (None, Some(vectors)) => of_table(args, vectors)?,
        (None, None) => bail!(UsageError("missing vectors, expected a scene with --run, or --vectors".to_owned())),
    };
    let required = requirement(args, &table, machine.as_ref())?;
    let placement = Placement { holes: holes(args, &table.planes)?, removes: args.remove, replaces: args.replace };
    let of_file = |error| UsageError(format!("{}: {error}", file.display()));
    let twin = machine.as_ref().map(|(.., twin)| twin);
    let mut balance = balance(&table, twin, &placement).map_err(of_file)?;
    balance.quality = required.map(|required| required.quality(&balance.correction));
    if let Some(output) = &args.output {
        AtomicFile::write(output, csv(&balance))?;
    }
    if let Some(report) = &args.report {
        let name = machine.as_ref().map_or_else(|| file.display().to_string(), |(scene, ..)| scene.name.clone());
        AtomicFile::write(report, &html(&name, &balance)?)?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&balance)?)?,
        Format::Csv if machine.is_some() => out.write_all(correction_csv(&balance).as_bytes())?,
        Format::Csv => out.write_all(csv(&balance).as_bytes())?,
        Format::Text => {
            if let Some(times) = times {
                writeln!(out, "Times of the runs: {}\n", times.display())?;
            }
            out.write_all(text(&balance)?.as_bytes())?;
            let written: Vec<String> =
                args.output.iter().chain(&args.report).map(|path| path.display().to_string()).collect();
            if !written.is_empty() {
                writeln!(out, "\nWritten: {}", written.join(", "))?;
            }
        }
    }
    Ok(out.flush()?)
}

/// Returns the holes and weights that are given.
fn holes(args: &Args, planes: &[String]) -> Result<Option<Holes>, UsageError> {
    let options = HoleOptions {
        holes: args.holes.clone(),
        radius: args.radius.clone(),
        hole_limit: args.hole_limit.clone(),
        stock: args.stock.clone(),
        taken: args.taken.clone(),
        weights: args.weights.into(),
    };
    options.read(planes).map_err(|error| UsageError(format!("--{error}")))
}

/// Reads a table of vectors.
fn of_table(args: &Args, vectors: &Path) -> Result<Input> {
    let beside = vectors.with_file_name("times.csv");
    let mut inputs: Vec<&Path> = vec![vectors, &beside];
    inputs.extend(args.times.as_deref());
    let outputs = [("--output", args.output.as_deref()), ("--report", args.report.as_deref())];
    let outputs: Vec<(&str, &Path)> = outputs.into_iter().filter_map(|(name, path)| Some((name, path?))).collect();
    check_distinct_paths(&outputs, &inputs)?;
    let (table, times) = VectorTable::read(vectors, args.times.as_deref()).map_err(UsageError::new)?;
    Ok(Input { table, machine: None, file: vectors.to_owned(), times })
}

/// Reads the recordings of a scene.
fn of_recordings(args: &Args, path: &Path) -> Result<Input> {
    let scene = read_file(path)?;
    let masses = |option: &'static str| {
        move |text: &String| {
            let expected = "FILE: PLANE MOMENT at ANGLE, such as \"trial.csv: DE 5 g mm at 30 deg\"";
            let parts = text.split_once(": ").map(|(file, masses)| (PathBuf::from(file), masses.to_owned()));
            parts.ok_or_else(|| UsageError(format!("{option}: no \": \" in {text:?}, expected {expected}")))
        }
    };
    let trials = args.trials.iter().map(masses("--trial")).collect::<Result<Vec<_>, UsageError>>()?;
    let trims = args.trims.iter().map(masses("--trim")).collect::<Result<Vec<_>, UsageError>>()?;
    let runs = RecordedRuns::new(&scene, &args.runs, [&trials, &trims], &args.planes).map_err(UsageError::new)?;
    let inputs: Vec<&Path> = runs.runs.iter().map(|run| run.file.as_path()).chain([path]).collect();
    if let Some(report) = &args.report {
        check_distinct_paths(&[("--report", report.as_path())], &inputs)?;
    }
    let table = vector_table(&scene, &runs)?;
    let twin = TwinCoefficients::new(&scene, &runs.planes, &table)?;
    Ok(Input { table, machine: Some((scene, runs.planes, twin)), file: path.to_owned(), times: None })
}

/// Returns the balance quality that is asked for.
fn requirement(
    args: &Args,
    table: &VectorTable,
    machine: Option<&(Scene, Vec<Plane>, TwinCoefficients)>,
) -> Result<Option<Requirement>> {
    let Some(grade) = args.grade else { return Ok(None) };
    let of_scene = machine.and_then(|(scene, ..)| scene.rotor.as_ref()).map(|rotor| rotor.mass);
    let Some(mass) = args.mass.or(of_scene) else {
        bail!(UsageError("--mass: missing, expected the mass of the rotor for --grade, such as \"12 kg\"".to_owned()));
    };
    let highest = table.speeds().1.into_iter().map(f64::abs).fold(0.0, f64::max);
    let planes = machine.map(|(scene, planes, _)| TolerancePlane::of_scene(scene, planes));
    Ok(Some(Requirement {
        grade,
        mass,
        speed_rpm: args.service_speed.map_or(highest, |speed| speed * 60.0 / TAU),
        planes: planes.unwrap_or_else(|| TolerancePlane::of_correction(&table.planes)),
    }))
}
