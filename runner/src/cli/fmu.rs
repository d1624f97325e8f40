//! `ballrace fmu`: writes the rotor or one bearing of a scene as a unit for co-simulation (FMI 3.0).

use super::{Format, check_distinct_paths, simulate};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report::number::counted;
use ballrace_twin::fmu::{Causality, Content, Resources, Unit, Variable, model_description, platform};
use ballrace_twin::output::{AtomicFile, cell_text};
use ballrace_twin::plant::Plant;
use ballrace_twin::scene::read::{load, read_str};
use ballrace_twin::scene::{Scene, build};
use serde::Serialize;
use std::env::consts::{DLL_EXTENSION, DLL_PREFIX, DLL_SUFFIX};
use std::f64::consts::TAU;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Arguments of `fmu`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// File to write.
    #[arg(short, long, value_name = "F.fmu")]
    output: PathBuf,
    /// Write this bearing, displacement in and force out, and not the whole rotor [default without a rotor: the bearing].
    #[arg(long, value_name = "NAME")]
    bearing: Option<String>,
    /// Internal steps of the rotor per second, e.g. "12.8 kHz"; by default the sampling rate of the scene's recording, without one 20 steps
    /// in a period of the highest natural frequency.
    #[arg(long, value_name = "R", conflicts_with = "bearing")]
    rate: Option<String>,
    /// Library to put into the unit [default: the one beside the program].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    bearing: Option<&'a str>,
    platform: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    internal_step_s: Option<f64>,
    variables: Vec<Row<'a>>,
    output: String,
}

#[derive(Serialize)]
struct Row<'a> {
    value_reference: usize,
    name: &'a str,
    causality: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<&'static str>,
    description: &'a str,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the scene or the rate is invalid, the library is missing, or the output cannot be written.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let text = load(&args.scene)?;
    let scene = read_str(&text, &args.scene)?;
    let Args { library, .. } = args;
    let library = library.clone().map_or_else(library_of_program, Ok)?;
    check_distinct_paths(&[("--output", &args.output)], &[&args.scene, &library])?;
    let has_rotor = scene.rotor.is_some() || scene.system.is_some();
    let content = if has_rotor && args.bearing.is_none() {
        Content::Rotor { rate: internal_rate(args.rate.as_deref(), &scene)? }
    } else {
        let bearing = build::pick(&scene, args.bearing.as_deref()).map_err(UsageError::with_bearing_option)?;
        Content::Bearing { name: bearing.name.clone() }
    };
    let unit = Unit::try_new(&scene, &content)?;
    let binary = read_library(&library)?;
    let resources = Resources::of(&scene, &text, &content)?;
    let (description, identifier) = model_description(&unit, &scene, &content, &resources.token)?;
    let mut files = vec![("modelDescription.xml".to_owned(), description.into_bytes())];
    files.push((format!("binaries/{}/{identifier}.{DLL_EXTENSION}", platform()), binary));
    files.extend(resources.files.into_iter().map(|(name, bytes)| (format!("resources/{name}"), bytes)));
    let archive = archive(&files).with_context(|| format!("{}: no archive of the unit", args.output.display()))?;
    AtomicFile::write(&args.output, archive)?;
    let rows = unit.variables().iter().enumerate().map(|(value_reference, variable)| {
        let Variable { name, causality, unit, description, .. } = variable;
        Row { value_reference, name, causality: causality.name(), unit: *unit, description }
    });
    let summary = Summary {
        scene: &scene.name,
        bearing: if let Content::Bearing { name } = &content { Some(name) } else { None },
        platform: platform(),
        internal_step_s: unit.internal_step(),
        variables: rows.collect(),
        output: args.output.display().to_string(),
    };
    print(&summary, format)
}

/// Steps in a period of the highest natural frequency where nothing else sets the rate.
const STEPS_OF_PERIOD: f64 = 20.0;

/// Returns the internal steps per second, Hz.
fn internal_rate(given: Option<&str>, scene: &Scene) -> Result<f64> {
    if given.is_some() || scene.recording.is_some() {
        return simulate::sampling_rate(given, scene);
    }
    let least = STEPS_OF_PERIOD * Plant::try_new(scene)?.highest_frequency() / TAU;
    let decade = 10_f64.powf(least.log10().floor());
    Ok([1.0, 2.0, 5.0].map(|factor| factor * decade).into_iter().find(|rate| *rate >= least).unwrap_or(10.0 * decade))
}

/// Returns the path of the library beside this program.
fn library_of_program() -> Result<PathBuf> {
    let program = std::env::current_exe().context("the path of this program is unknown")?;
    Ok(program.with_file_name(format!("{DLL_PREFIX}ballrace_fmu{DLL_SUFFIX}")))
}

/// Reads a library of units and checks that it is one of this version.
fn read_library(path: &Path) -> Result<Vec<u8>> {
    let file = path.display();
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => bail!(
            "{file}: no library of units, expected the one beside the program in its archive, or --library FILE with the one in \
             target/release after cargo build --release -p ballrace-fmu"
        ),
        Err(error) => bail!("{file}: this library cannot be read: {error}"),
    };
    // The library has these words, with the version, as a constant.
    let version = env!("CARGO_PKG_VERSION");
    let words = format!("ballrace unit library {version}\n");
    if !bytes.windows(words.len()).any(|window| window == words.as_bytes()) {
        bail!(UsageError(format!("--library: no library of units: {file}, expected one of ballrace {version}")));
    }
    Ok(bytes)
}

/// Returns the files as a compressed archive, the same bytes for the same files.
fn archive(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in files {
        archive.start_file(name.as_str(), SimpleFileOptions::default())?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

fn print(summary: &Summary<'_>, format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(summary)?)?,
        Format::Csv => {
            let mut writer = ::csv::Writer::from_writer(&mut out);
            writer.write_record(["value_reference", "name", "causality", "unit", "description"])?;
            for row in &summary.variables {
                let cells = [&row.value_reference.to_string(), row.name, row.causality, row.unit.unwrap_or_default()];
                writer.write_record(
                    cells.into_iter().chain([row.description]).map(|cell| cell_text(cell).into_owned()),
                )?;
            }
            writer.flush()?;
            drop(writer);
        }
        Format::Text => {
            let count = |causality: Causality| {
                summary.variables.iter().filter(|row| row.causality == causality.name()).count() as u64
            };
            let part = summary.bearing.map_or("rotor".to_owned(), |name| format!("bearing {name}"));
            let [inputs, outputs] = [(Causality::Input, "input"), (Causality::Output, "output")]
                .map(|(causality, word)| counted(count(causality), word));
            writeln!(out, "{}, {part}: {inputs}, {outputs}, {}", summary.scene, summary.platform)?;
            match summary.internal_step_s {
                Some(step) => writeln!(out, "Communication steps: whole multiples of {:.6} us", step * 1e6)?,
                None => writeln!(out, "Communication steps: of any length")?,
            }
            writeln!(out, "Written: {}", summary.output)?;
        }
    }
    Ok(out.flush()?)
}
