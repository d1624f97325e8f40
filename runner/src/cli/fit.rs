//! `ballrace fit`: estimates parameters of the scene from a recording.

use super::progress::ProgressLines;
use super::{Format, check_distinct_paths, parse_time_limit};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report::fit::{csv, html, text};
use ballrace_twin::error::{Error, FitError};
use ballrace_twin::fit::parameters::{ALL, Group};
use ballrace_twin::fit::{FitPlan, FitProgress, Fitted, fit_recording, written};
use ballrace_twin::output::AtomicFile;
use ballrace_twin::recording::Reader;
use ballrace_twin::scene::read::read_file;
use indicatif::ProgressBar;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Arguments of `fit`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file with the start values.
    scene: PathBuf,
    /// Fit to this recording instead of the scene's own.
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// Parameters to fit, separated by commas; the others keep the scene's values [default: all].
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Group>,
    /// Number of shaft revolutions used, from the start of the recording.
    #[arg(long, default_value_t = 64.0)]
    turns: f64,
    /// Time after which the fit is given up, e.g. "1 h".
    #[arg(long, value_name = "T", default_value = "30 min", value_parser = parse_time_limit)]
    time_limit: Duration,
    /// Scene file to write with the fitted values [default: beside the scene, ending in -fitted.toml].
    #[arg(short, long, value_name = "F.toml")]
    output: Option<PathBuf>,
    /// HTML page with the changes of the parameters and the residuals.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene, recording or output is invalid.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let scene = read_file(&args.scene)?;
    let Some(recording) = &scene.recording else {
        bail!(UsageError(format!(
            "{}: missing table [recording], expected the recording to fit to",
            scene.path.display()
        )));
    };
    if !(args.turns >= 1.0 && args.turns.is_finite()) {
        bail!(UsageError(format!("--turns: value out of range: {}, expected 1 or more", args.turns)));
    }
    let path = args.recording.as_ref().unwrap_or(&recording.file);
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene));
    let mut outputs = vec![("--output", output.as_path())];
    outputs.extend(args.report.as_deref().map(|report| ("--report", report)));
    check_distinct_paths(&outputs, &[&args.scene, path])?;
    let reader = Reader::open(path, recording)?;
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let groups = if args.only.is_empty() { ALL.to_vec() } else { args.only.clone() };
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new_spinner() } else { ProgressBar::hidden() };
    let lines = ProgressLines::new();
    let mut part = 0.0;
    let mut progress = |at: FitProgress| {
        let FitProgress { iteration, most, turns, all_turns } = at;
        let message =
            || format!("Fitting {turns:.1} of {all_turns:.1} revolutions, iteration {iteration} of at most {most}");
        bar.set_message(message());
        bar.tick();
        if part == turns {
            lines.now_and_then(message);
        } else {
            lines.print(message);
        }
        part = turns;
    };
    let plan = FitPlan { groups: &groups, turns: args.turns, time_limit: args.time_limit };
    let fitted = fit_recording(&scene, reader, &name, &plan, &mut progress);
    bar.finish_and_clear();
    let fitted = fitted.map_err(|error| match error {
        Error::Motion(_) | Error::Fit(FitError::NotConverged { .. } | FitError::TooLong { .. }) => {
            anyhow::Error::new(error)
        }
        error => anyhow::Error::new(UsageError::new(error)),
    })?;
    let source = std::fs::read_to_string(&args.scene).with_context(|| args.scene.display().to_string())?;
    AtomicFile::write(&output, &written(&fitted, &scene, &source)?)?;
    if let Some(path) = &args.report {
        AtomicFile::write(path, &html(&fitted)?)?;
    }
    print(&fitted, &output, args.report.as_deref(), format)
}

/// Returns the path of the fitted scene: the name of `scene` with the ending -fitted.toml.
fn default_output(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    scene.with_file_name(format!("{stem}-fitted.toml"))
}

fn print(fitted: &Fitted, output: &Path, report: Option<&Path>, format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(fitted)?)?,
        Format::Csv => out.write_all(csv(fitted).as_bytes())?,
        Format::Text => {
            out.write_all(text(fitted).as_bytes())?;
            let report = report.map_or_else(String::new, |report| format!(", {}", report.display()));
            writeln!(out, "\nWritten: {}{report}", output.display())?;
        }
    }
    Ok(out.flush()?)
}
