//! `ballrace equilibrium`: static equilibrium of the rotor or of one bearing.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report as report;
use ballrace_twin::equilibria::{FIGURES, equilibria};
use ballrace_twin::equilibrium::{Element, static_equilibrium};
use ballrace_twin::error::Error;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::output::quoted;
use ballrace_twin::plant::LARGEST_RESIDUAL;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::sweep::Axis;
use ballrace_twin::thermal::thermal_equilibrium;
use indicatif::ProgressBar;
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

/// Arguments of `equilibrium`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Solve one bearing alone, with a fixed outer ring, instead of the rotor.
    #[arg(long, value_name = "NAME")]
    bearing: Option<String>,
    /// Load on that bearing's inner ring: FX,FY,FZ,MX,MY in N and N m (a preload force of the scene is added).
    #[arg(long, value_name = "LOAD", allow_hyphen_values = true)]
    load: Option<String>,
    /// At the temperatures that friction and `cooling` of the scene keep, instead of those of the scene.
    #[arg(long)]
    thermal: bool,
    /// Equilibria over values of a key, repeatable: KEY=FROM..TO:COUNT, KEY=FROM..TO:STEP or KEY=A,B,C; e.g.
    /// shaft.speed=1000rpm..12000rpm:12.
    #[arg(long, value_name = "RANGE")]
    over: Vec<String>,
    /// HTML page with the load distribution and the contact angles, or with the figures over a range.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the scene or the load is invalid, and, after the result is printed, if no equilibrium exists.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    if let Some(path) = &args.report {
        check_distinct_paths(&[("--report", path)], &[&args.scene])?;
    }
    let load = args.load.as_deref().map(parse_load).transpose().map_err(UsageError::new)?;
    if !args.over.is_empty() {
        return over(args, &scene.name, load, format);
    }
    let solve = if args.thermal { thermal_equilibrium } else { static_equilibrium };
    let equilibrium = solve(&scene, args.bearing.as_deref(), load).map_err(failure)?;
    if let Some(path) = &args.report {
        AtomicFile::write(path, &report::equilibrium::html(&equilibrium)?)?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => {
            serde_json::to_writer_pretty(&mut out, &equilibrium)?;
            writeln!(out)?;
        }
        Format::Csv => csv(&mut out, &equilibrium.elements)?,
        Format::Text => {
            out.write_all(report::equilibrium::text(&equilibrium).as_bytes())?;
            print_effects(&mut out, &equilibrium.significance, error)?;
        }
    }
    if format == Format::Text
        && let Some(path) = &args.report
    {
        writeln!(out, "Written: {}", path.display())?;
    }
    out.flush()?;
    if !equilibrium.is_in_equilibrium() {
        bail!(
            "{}: no equilibrium: {:.2e} of the load is not balanced, expected at most {LARGEST_RESIDUAL:.0e}",
            scene.path.display(),
            equilibrium.residual
        );
    }
    Ok(())
}

/// Returns an error of the solution; a machine without steady temperatures is no wrong command.
fn failure(error: Error) -> anyhow::Error {
    if matches!(error, Error::Thermal(_)) && !error.is_usage_error() {
        return error.into();
    }
    UsageError::with_bearing_option(error).into()
}

/// Prints the equilibria over ranges.
fn over(args: &Args, scene: &str, load: Option<[f64; 5]>, format: Format) -> Result<()> {
    let text = std::fs::read_to_string(&args.scene).with_context(|| args.scene.display().to_string())?;
    let axes = args.over.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(0) } else { ProgressBar::hidden() };
    let progress = |points: usize| if points > 0 { bar.set_length(points as u64) } else { bar.inc(1) };
    let points = equilibria((&text, &args.scene), &axes, (args.bearing.as_deref(), load, args.thermal), &progress);
    bar.finish_and_clear();
    let points = points.map_err(UsageError::with_bearing_option)?;
    if let Some(failure) = points.first().and_then(|point| point.failure.as_ref())
        && points.iter().all(|point| point.failure.is_some())
    {
        bail!("no equilibrium at any of {} points; the first: {failure}", points.len());
    }
    if let Some(path) = &args.report {
        AtomicFile::write(path, &report::equilibria::html(scene, &axes, &points)?)?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => {
            let columns = FIGURES.iter().map(|figure| figure.name);
            let axes: Vec<_> = axes.iter().map(|axis| json!({ "key": axis.key, "unit": axis.unit })).collect();
            let whole =
                json!({ "scene": scene, "axes": axes, "figures": columns.collect::<Vec<_>>(), "points": points });
            serde_json::to_writer_pretty(&mut out, &whole)?;
            writeln!(out)?;
        }
        Format::Csv => out.write_all(report::equilibria::csv(&axes, &points).as_bytes())?,
        Format::Text => {
            out.write_all(report::equilibria::text(scene, &axes, &points).as_bytes())?;
            if let Some(path) = &args.report {
                writeln!(out, "Written: {}", path.display())?;
            }
        }
    }
    Ok(out.flush()?)
}

fn parse_load(text: &str) -> Result<[f64; 5]> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match <[f64; 5]>::try_from(numbers) {
        Ok(load) if load.iter().all(|x| x.is_finite()) && text.split(',').count() == 5 => Ok(load),
        _ => {
            bail!(
                "--load: invalid load: {text:?}, expected five numbers FX,FY,FZ,MX,MY in N and N m, such as 0,-500,1000,0,0"
            )
        }
    }
}

fn csv(out: &mut impl Write, elements: &[Element]) -> Result<()> {
    writeln!(
        out,
        "bearing,number,azimuth,inner_load,outer_load,inner_angle,outer_angle,inner_pressure,outer_pressure,inner_film,outer_film,film_ratio"
    )?;
    let optional = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.16e}"));
    for e in elements {
        writeln!(
            out,
            "{},{},{:.16e},{:.16e},{:.16e},{},{},{},{},{:.16e},{:.16e},{}",
            quoted(&e.bearing),
            e.number,
            e.azimuth,
            e.inner_load,
            e.outer_load,
            optional(e.inner_angle),
            optional(e.outer_angle),
            optional(e.inner_pressure),
            optional(e.outer_pressure),
            e.inner_film,
            e.outer_film,
            optional(e.film_ratio)
        )?;
    }
    Ok(())
}
