//! `ballrace trade`: error and cost of every model that a scene allows, and the recommended model.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report as report;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::{Dimension, parse};
use ballrace_twin::trade::{Goal, Target, Trade, trade, written};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Arguments of `trade`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Choose the most accurate model whose forces of all bearings meet this deadline, e.g. "20 us at 168 MHz" (Cortex-M4F).
    #[arg(long, value_name = "TIME at CLOCK")]
    deadline: Option<String>,
    /// Compare forces only; simulated motions take most of the computing time.
    #[arg(long)]
    forces_only: bool,
    /// Processor whose cost --error minimises.
    #[arg(long, value_enum, default_value_t = Target::CortexM4f)]
    on: Target,
    /// Scene file to write with the chosen model [default: beside the scene, ending in -chosen.toml].
    #[arg(short, long, value_name = "SCENE.toml")]
    output: Option<PathBuf>,
    /// HTML report to write, with the Pareto fronts.
    #[arg(long, value_name = "FILE.html", default_value = "ballrace-trade.html")]
    report: PathBuf,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene, goal or outputs are invalid, or if no model meets the goal.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let goal = parse_goal(args, error)?;
    let scene = read_file(&args.scene)?;
    let text = std::fs::read_to_string(&args.scene).with_context(|| args.scene.display().to_string())?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene));
    let mut outputs = vec![("--report", args.report.as_path())];
    if goal.is_some() {
        outputs.push(("--output", &output));
    } else if args.output.is_some() {
        bail!(UsageError("--output: requires --error or --deadline".to_owned()));
    }
    check_distinct_paths(&outputs, &[&args.scene])?;
    let bar = progress_bar();
    let progress = |completed: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(completed as u64);
    };
    let result = trade(&scene, &text, (goal.as_ref(), !args.forces_only), &progress);
    bar.finish_and_clear();
    let result = result?;
    AtomicFile::write(&args.report, &report::trade::html(&result)?)?;
    if let Some(choice) = &result.choice {
        AtomicFile::write(&output, &written(&scene, &text, &choice.model)?)?;
    }
    print(&result, args, &output, (format, error))
}

/// Returns a progress bar on standard error, hidden if standard error is not a terminal.
fn progress_bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Returns the path of the chosen scene: the name of `scene` with the ending -chosen.toml.
fn default_output(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    scene.with_file_name(format!("{stem}-chosen.toml"))
}

fn parse_goal(args: &Args, error: Option<f64>) -> Result<Option<Goal>> {
    Ok(match (error, &args.deadline) {
        (Some(_), Some(_)) => {
            bail!(UsageError("--deadline: cannot be used together with --error".to_owned()))
        }
        (Some(error), None) => Some(Goal::Error(error, args.on)),
        (None, Some(text)) => Some(parse_deadline(text)?),
        (None, None) => None,
    })
}

fn parse_deadline(text: &str) -> Result<Goal> {
    let invalid = || {
        let expected = "a time and a clock frequency, such as \"20 us at 168 MHz\"";
        UsageError(format!("--deadline: invalid value: {text:?}, expected {expected}"))
    };
    let (time, clock) = text.split_once(" at ").ok_or_else(invalid)?;
    let positive = |text: &str, dimension| match parse(text.trim(), dimension) {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err(invalid()),
    };
    Ok(Goal::Deadline { time: positive(time, Dimension::Time)?, clock: positive(clock, Dimension::Frequency)? })
}

fn print(result: &Trade, args: &Args, output: &Path, (format, error): (Format, Option<f64>)) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(result)?)?,
        Format::Csv => out.write_all(report::trade::csv(result).as_bytes())?,
        Format::Text => {
            out.write_all(report::trade::text(result).as_bytes())?;
            writeln!(out)?;
            print_effects(&mut out, &result.significance, error)?;
            if let Some(choice) = &result.choice {
                writeln!(out, "\n{}", report::trade::chosen(choice))?;
                writeln!(out, "Written: {}, {}", output.display(), args.report.display())?;
            } else {
                writeln!(out, "\nWritten: {}", args.report.display())?;
            }
        }
    }
    Ok(out.flush()?)
}
