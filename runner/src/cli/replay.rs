//! `ballrace replay`: compares a recording with the digital twin and diagnoses the machine.

use super::live::{self, DEMO_NAME, DEMO_RECORDING, LiveArgs};
use super::progress::ProgressLines;
use super::{Format, ReplayStatus, check_distinct_paths, parse_time_limit};
use crate::error::UsageError;
use crate::live as monitor;
use crate::live::address::Address;
use anyhow::{Context, Result, bail};
use ballrace_report as report;
use ballrace_twin::diagnosis::MAX_ROUNDS;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::recording::Reader;
use ballrace_twin::replay::outcome::{Outcome, RecordingFile};
use ballrace_twin::replay::{self, Options, Progress, Source};
use ballrace_twin::scene::Scene;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{Cursor, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Arguments of `replay`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file; without one, the built-in demonstration.
    scene: Option<PathBuf>,
    /// Replay this recording, a file or a folder, instead of the scene's own.
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// HTML report to write [default: ballrace-report.html, or SCENE-report.html with a scene, SCENE-RECORDING-report.html
    /// with another recording or source].
    #[arg(long, value_name = "FILE.html", conflicts_with = "no_report")]
    report: Option<PathBuf>,
    /// Write no HTML report.
    #[arg(long)]
    no_report: bool,
    /// Write the force of every bearing at every sample.
    #[arg(long, value_name = "FILE.csv")]
    forces: Option<PathBuf>,
    /// Displacement at which --forces evaluates the bearings: estimated by the observer, or as measured.
    #[arg(long, value_enum, default_value_t = Source::Observer, requires = "forces")]
    force_source: Source,
    /// Store this recording's levels as the baseline of the healthy machine.
    #[arg(long, value_name = "BASELINE.json")]
    learn: Option<PathBuf>,
    /// Time after which --learn is given up, e.g. "1 h" [default: 30 min].
    #[arg(long, value_name = "T", requires = "learn", value_parser = parse_time_limit)]
    time_limit: Option<Duration>,
    /// Compare with a baseline stored by --learn.
    #[arg(long, value_name = "BASELINE.json")]
    baseline: Option<PathBuf>,
    /// Run in real time: replay a recording at its own rate, or process a live source as samples arrive.
    #[arg(long)]
    pub(super) paced: bool,
    /// Diagnose a recording that is not plausible for the scene all the same.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
    #[command(flatten, next_help_heading = "Live operation, only with --paced")]
    live: LiveArgs,
}

/// Time limit of `--learn` without `--time-limit`.
const LEARNING_TIME: Duration = Duration::from_secs(1800);

/// Runs the command and returns the status for the exit code.
///
/// # Errors
/// Returns an error if scene, recording or outputs are invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<ReplayStatus> {
    let scene = live::read_scene(args.scene.as_deref())?;
    if args.paced {
        return replay_paced(args, &scene, format, error);
    }
    if let Some(option) = args.live.first_given() {
        bail!(UsageError(format!("{option}: requires --paced or `ballrace watch`")));
    }
    let (reader, path) = open(args, &scene)?;
    let report = report_path(args);
    check_outputs(args, &scene, &path, report.as_deref())?;
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let bar = progress_bar(&name);
    // Only learning takes long.
    let lines = args.learn.as_ref().map(|_| ProgressLines::new());
    let now_and_then = |text: &dyn Fn() -> String| {
        if let Some(lines) = &lines {
            lines.now_and_then(text);
        }
    };
    let progress = |progress: Progress| match progress {
        Progress::Read(read, total) => {
            now_and_then(&|| match total {
                Some(total) => format!("Replaying {name}: {:.0} %", 100.0 * read as f64 / total.max(1) as f64),
                None => format!("Replaying {name}: {read} bytes"),
            });
            if let Some(total) = total {
                bar.set_length(total);
            }
            bar.set_message(name.clone());
            bar.set_position(read);
        }
        Progress::Learning(round) => {
            let message = || format!("Learning from {name}: round {round} of at most {MAX_ROUNDS}");
            bar.set_message(message());
            now_and_then(&message);
        }
        Progress::Diagnosis(share) => {
            let message = || format!("Diagnosing {name}: {:.0} %", 100.0 * share);
            bar.set_message(message());
            now_and_then(&message);
        }
    };
    let options = Options {
        error,
        forces: args.forces.as_deref(),
        source: args.force_source,
        baseline: args.baseline.as_deref(),
        learn: args.learn.is_some(),
        learning_time: Some(args.time_limit.unwrap_or(LEARNING_TIME)),
        force_diagnosis: args.force,
        progress: Some(&progress),
        ..Options::default()
    };
    let outcome = replay::replay(&scene, reader, &name, &options);
    bar.finish_and_clear();
    write_results(args, Outcome { file: RecordingFile::of(&path), ..outcome? }, report.as_deref(), format)
}

/// Replays in real time.
fn replay_paced(args: &Args, scene: &Scene, format: Format, error: Option<f64>) -> Result<ReplayStatus> {
    let recording = args.scene.is_none().then_some(Address::BuiltIn(DEMO_RECORDING, DEMO_NAME));
    let source = args.live.source(scene, args.recording.as_deref(), recording)?;
    let path = PathBuf::from(source.to_string());
    let report = report_path(args);
    check_outputs(args, scene, &path, report.as_deref())?;
    let replay = Options {
        error,
        forces: args.forces.as_deref(),
        source: args.force_source,
        baseline: args.baseline.as_deref(),
        live: true,
        learn: args.learn.is_some(),
        force_diagnosis: args.force,
        ..Options::default()
    };
    let options = args.live.options(source, None, replay);
    let signals = live::handle_signals()?;
    let outcome = monitor::monitor(scene, &options, &signals)?;
    write_results(args, outcome, report.as_deref(), format)
}

/// Writes the report and the baseline, and prints the outcome. A recording that is not plausible for the scene, or that the
/// model does not describe, is not stored as a baseline.
fn write_results(
    args: &Args,
    mut outcome: Outcome,
    report_path: Option<&Path>,
    format: Format,
) -> Result<ReplayStatus> {
    let reason = outcome.no_baseline();
    let baseline = args.learn.as_deref().filter(|_| reason.is_none());
    if let (Some(path), Some(reason)) = (&args.learn, &reason) {
        let hint = match outcome.is_refused_as_baseline() {
            true => ". --force stores its levels and faults, without parameters",
            false => "",
        };
        outcome.notes.push(format!("No baseline is stored in {}: {reason}{hint}.", path.display()));
    }
    let written = write_files(&outcome, report_path, baseline);
    // The outcome is printed even if a file cannot be written.
    print(&outcome, report_path.filter(|_| written.is_ok()), format)?;
    written?;
    Ok(ReplayStatus::from(&outcome))
}

/// Writes the report and the baseline.
fn write_files(outcome: &Outcome, report_path: Option<&Path>, baseline: Option<&Path>) -> Result<()> {
    if let Some(path) = report_path {
        AtomicFile::write(path, &report::html(outcome)?)?;
    }
    if let Some(path) = baseline {
        AtomicFile::write(path, &serde_json::to_string_pretty(&outcome.learned)?)?;
    }
    Ok(())
}

/// Returns the path of the report; none with `--no-report`. Without `--report` the name has the scene, and the recording or the
/// source where the command line names one, so that runs in one folder have reports of their own.
fn report_path(args: &Args) -> Option<PathBuf> {
    if args.no_report {
        return None;
    }
    if let Some(path) = &args.report {
        return Some(path.clone());
    }
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let source = args.live.source.as_ref().map(|source| match source {
        Address::File(path) => stem(path),
        other => {
            let text = other.to_string();
            let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '.').filter(|word| !word.is_empty());
            words.collect::<Vec<_>>().join("-")
        }
    });
    let recording = source.or_else(|| args.recording.as_deref().map(stem));
    let scene = args.scene.as_deref().map_or_else(|| "ballrace".to_owned(), stem);
    let parts: Vec<String> = [Some(scene), recording, Some("report".to_owned())].into_iter().flatten().collect();
    Some(PathBuf::from(parts.join("-") + ".html"))
}

/// Checks that all outputs can be written, before a long replay starts.
fn check_outputs(args: &Args, scene: &Scene, recording: &Path, report: Option<&Path>) -> Result<()> {
    let mut outputs: Vec<(&str, &Path)> = report.map(|path| ("--report", path)).into_iter().collect();
    outputs.extend(args.forces.as_deref().map(|path| ("--forces", path)));
    outputs.extend(args.learn.as_deref().map(|path| ("--learn", path)));
    outputs.extend(args.live.outputs.events.as_deref().map(|path| ("--events", path)));
    let optional = args.scene.as_deref().into_iter().chain(args.baseline.as_deref());
    let run_out = scene.recording.as_ref().and_then(|recording| recording.run_out.as_deref());
    let inputs: Vec<&Path> = optional.chain([recording]).chain(run_out).collect();
    check_distinct_paths(&outputs, &inputs)?;
    // A pipe is not opened for the check: closing it again would end the input of its reader.
    let is_special = |path: &Path| path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir());
    let check = |path: &Path| if is_special(path) { Ok(()) } else { AtomicFile::create(path).map(|_| ()) };
    Ok(outputs.iter().try_for_each(|(_, path)| check(path))?)
}

/// Opens the recording and returns its reader and its path.
fn open(args: &Args, scene: &Scene) -> Result<(Reader<'static>, PathBuf)> {
    let recording = scene.recording.as_ref().with_context(|| {
        format!("{}: missing table [recording], expected the columns of a recording", scene.path.display())
    });
    let recording = recording.map_err(UsageError::new)?;
    let file = match (&args.recording, &args.scene) {
        (Some(file), _) => Some(file.as_path()),
        (None, Some(_)) => None,
        (None, None) => {
            let bytes = Box::new(Cursor::new(DEMO_RECORDING));
            let size = DEMO_RECORDING.len() as u64;
            let name = PathBuf::from(DEMO_NAME);
            return Ok((Reader::from_reader(bytes, &name, Some(size), recording)?, name));
        }
    };
    let (reader, path) = replay::open(scene, file)?;
    Ok((reader, path.to_owned()))
}

/// Returns a progress bar on standard error, hidden if standard error is not a terminal.
fn progress_bar(name: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {bytes}/{total_bytes}, {eta} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(format!("Replaying {name}"));
    bar
}

fn print(outcome: &Outcome, report_path: Option<&Path>, format: Format) -> Result<()> {
    let text = match format {
        Format::Text => report::text(outcome),
        Format::Json => report::json(outcome)?,
        Format::Csv => report::csv(outcome),
    };
    let mut out = super::standard_output(format);
    out.write_all(text.as_bytes())?;
    if !text.ends_with('\n') {
        out.write_all(b"\n")?;
    }
    if let Some(path) = report_path.filter(|_| format == Format::Text) {
        writeln!(out, "\nReport: {}", path.display())?;
    }
    Ok(out.flush()?)
}
