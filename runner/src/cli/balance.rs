//! `ballrace balance`: influence coefficients, unknown masses and correction masses from vibration vectors.

use super::{Format, check_distinct_paths};
use crate::error::UsageError;
use anyhow::{Result, bail};
use ballrace_report::balance::{csv, text};
use ballrace_twin::balance::table::VectorTable;
use ballrace_twin::balance::{Holes, balance};
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::units::{Dimension, parse};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `balance`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Table of once-per-turn vectors: id, set (baseline, trial or blind), `speed_rpm`, `PLANE_g_mm` and `PLANE_deg`, `PROBE_re_um` and `PROBE_im_um`.
    #[arg(long, value_name = "FILE")]
    vectors: PathBuf,
    /// Times of the runs: condition, speed, `unix_time_of_one_record` [default: times.csv beside the vectors, if it is there].
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// CSV file to write with the masses of the blind conditions.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Holes of each plane, evenly spread, the first at 0 degrees.
    #[arg(long, value_name = "N", requires = "radius", value_parser = clap::value_parser!(u16).range(3..))]
    holes: Option<u16>,
    /// Radius of the circle of holes, e.g. "30 mm".
    #[arg(long, value_name = "R", requires = "holes", value_parser = parse_length)]
    radius: Option<f64>,
    /// Weights in stock, separated by commas, e.g. "0.4 g,0.8 g" [default: any weight].
    #[arg(long, value_name = "M", requires = "holes", value_delimiter = ',', value_parser = parse_mass)]
    stock: Vec<f64>,
}

fn parse_length(text: &str) -> Result<f64, String> {
    let length = parse(text, Dimension::Length).ok().filter(|length| *length > 0.0);
    length.ok_or_else(|| format!("expected {}", Dimension::Length.expected("above 0")))
}

fn parse_mass(text: &str) -> Result<f64, String> {
    let mass = parse(text.trim(), Dimension::Mass).ok().filter(|mass| *mass > 0.0);
    mass.ok_or_else(|| format!("expected {}", Dimension::Mass.expected("above 0")))
}

/// Most weights in stock: all pairs of them are compared.
const MOST_WEIGHTS: usize = 1000;

/// Runs the command.
///
/// # Errors
/// Returns an error if the table is invalid or does not determine the coefficients, or the output cannot be written.
pub fn run(args: &Args, format: Format) -> Result<()> {
    if args.stock.len() > MOST_WEIGHTS {
        bail!(UsageError(format!("--stock: {} weights, expected at most {MOST_WEIGHTS}", args.stock.len())));
    }
    let beside = args.vectors.with_file_name("times.csv");
    let mut inputs: Vec<&Path> = vec![&args.vectors, &beside];
    inputs.extend(args.times.as_deref());
    if let Some(output) = &args.output {
        check_distinct_paths(&[("--output", output.as_path())], &inputs)?;
    }
    let read = |times: Option<&Path>| VectorTable::read(&args.vectors, times).map_err(UsageError::new);
    let mut table = read(args.times.as_deref())?;
    let mut times = args.times.as_deref();
    if !table.has_times() && beside.is_file() {
        times = Some(&beside);
        table = read(times)?;
    }
    let holes = args.holes.zip(args.radius);
    let holes = holes.map(|(count, radius)| Holes { count: count.into(), radius, stock: args.stock.clone() });
    let of_file = |error| UsageError(format!("{}: {error}", args.vectors.display()));
    let balance = balance(&table, holes.as_ref()).map_err(of_file)?;
    if let Some(output) = &args.output {
        AtomicFile::write(output, &csv(&balance))?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&balance)?)?,
        Format::Csv => out.write_all(csv(&balance).as_bytes())?,
        Format::Text => {
            if let Some(times) = times {
                writeln!(out, "Times of the runs: {}\n", times.display())?;
            }
            out.write_all(text(&balance)?.as_bytes())?;
            if let Some(output) = &args.output {
                writeln!(out, "\nWritten: {}", output.display())?;
            }
        }
    }
    Ok(out.flush()?)
}
