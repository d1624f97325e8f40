//! Subcommands, one file each, and the exit codes of the program.

pub mod bake;
pub mod balance;
pub mod campbell;
pub mod check;
pub mod completions;
pub mod equilibrium;
pub mod fit;
pub mod fleet;
pub mod fmu;
pub mod force;
mod help;
mod live;
pub mod man;
pub mod new;
mod progress;
pub mod replay;
pub mod scenes;
pub mod schema;
pub mod simulate;
pub mod sweep;
pub mod trade;
pub mod verify;
pub mod watch;

use crate::error::{Interrupted, UsageError};
use anyhow::{Context, Result, bail};
use ballrace_twin::effect_significance::{self, EffectSignificance};
use ballrace_twin::error::Error;
use ballrace_twin::plant::PlantError;
use ballrace_twin::printable::{self, Printable};
use ballrace_twin::recording::error::RecordingError;
use ballrace_twin::replay::outcome::Outcome;
use ballrace_twin::scene::read::SceneError;
use ballrace_twin::scene::units::{Dimension, parse};
use clap::{Parser, Subcommand, ValueEnum};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Rolling-bearing forces in fixed time, and a digital twin that replays measured shaft motion.
#[derive(Debug, Parser)]
#[command(name = "ballrace", version, about, after_help = help::PROGRAM)]
pub struct Cli {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Format of standard output.
    #[arg(long, global = true, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

/// Error of force of the commands that predict effects.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct ErrorLimit {
    /// Acceptable relative force error, e.g. 1%: warns about neglected effects with a larger predicted error; `trade`
    /// chooses the cheapest model within it.
    #[arg(long, value_name = "E", value_parser = parse_fraction)]
    pub error: Option<f64>,
}

/// Parses a fraction above 0 such as `1%` or `0.01`.
fn parse_fraction(text: &str) -> Result<f64, String> {
    let (number, scale) = text.trim().strip_suffix('%').map_or((text.trim(), 1.0), |number| (number.trim(), 0.01));
    match number.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number * scale),
        _ => Err("expected a fraction above 0, such as 1% or 0.01".to_owned()),
    }
}

/// Parses a time above 0 such as `30 min`.
fn parse_time_limit(text: &str) -> Result<Duration, String> {
    let seconds = parse(text, Dimension::Time).ok().filter(|seconds| *seconds > 0.0);
    let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    time.ok_or_else(|| format!("expected {}", Dimension::Time.expected("above 0")))
}

/// Prints the significant and the neglected effects of a scene, with a warning for each neglected effect whose predicted
/// error exceeds `error`.
fn print_effects(out: &mut impl Write, effects: &[EffectSignificance], error: Option<f64>) -> Result<()> {
    for line in effect_significance::describe(effects, error.unwrap_or(effect_significance::DEFAULT_FORCE_ERROR)) {
        writeln!(out, "{line}")?;
    }
    Ok(())
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Replay a recording through the digital twin, compare measured and computed motion, write a report.
    #[command(after_help = help::REPLAY)]
    Replay(replay::Args),
    /// Monitor a machine in real time in the terminal.
    #[command(after_help = help::WATCH)]
    Watch(watch::Args),
    /// Compute the forces of a bearing for given ring displacements.
    #[command(after_help = help::FORCE)]
    Force(force::Args),
    /// Write a scene's bearings as constants for firmware, with a certificate of accuracy and cost.
    #[command(after_help = help::BAKE)]
    Bake(bake::Args),
    /// Bake the scene of a baked file again and compare every constant and field of the certificate.
    #[command(after_help = help::VERIFY)]
    Verify(verify::Args),
    /// Compute the static equilibrium of the rotor or of one bearing, with the load on each element.
    #[command(after_help = help::EQUILIBRIUM)]
    Equilibrium(equilibrium::Args),
    /// Simulate the time response of the scene's rotor.
    #[command(after_help = help::SIMULATE)]
    Simulate(simulate::Args),
    /// Write the rotor or a bearing of a scene as a unit for co-simulation in other programs (FMI 3.0).
    #[command(after_help = help::FMU)]
    Fmu(fmu::Args),
    /// Compute natural frequencies, damping and whirl of the rotor over the shaft speed.
    #[command(after_help = help::CAMPBELL)]
    Campbell(campbell::Args),
    /// Simulate a scene over ranges of its keys: response curve, bifurcation diagram, waterfall.
    #[command(after_help = help::SWEEP)]
    Sweep(sweep::Args),
    /// Estimate unbalance, clearance, damping, stiffness and offsets from a recording, with confidence intervals.
    #[command(after_help = help::FIT)]
    Fit(fit::Args),
    /// Balance a rotor from vibration vectors: influence coefficients, unknown masses, correction masses, with intervals.
    #[command(after_help = help::BALANCE)]
    Balance(balance::Args),
    /// Evaluate the recordings of many machines on all processors: table of outcomes, trends, reports, overview.
    #[command(after_help = help::FLEET)]
    Fleet(fleet::Args),
    /// Compare error and cost of every model, precision, integrator and step on the scene's own motion.
    #[command(after_help = help::TRADE)]
    Trade(trade::Args),
    /// Check a scene and its recording: draw the machine, list what is not plausible and its probable cause.
    #[command(after_help = help::CHECK)]
    Check(check::Args),
    /// Write the draft of a scene from the catalogue of bearings and the columns of a recording.
    #[command(after_help = help::NEW)]
    New(new::Args),
    /// List or print the scenes that come with the program.
    #[command(after_help = help::SCENES)]
    Scenes(scenes::Args),
    /// Print the JSON schema of scene files, with which editors complete and check them.
    #[command(after_help = help::SCHEMA)]
    Schema(schema::Args),
    /// Print the completion script of a shell.
    #[command(after_help = help::COMPLETIONS)]
    Completions(completions::Args),
    /// Print the manual page of the program or of a subcommand, in roff.
    #[command(after_help = help::MAN)]
    Man(man::Args),
}

impl Command {
    /// Returns `true` if the command handles signals itself, so that it can write its report.
    const fn is_live(&self) -> bool {
        matches!(self, Self::Watch(_) | Self::Replay(replay::Args { paced: true, .. }))
    }
}

/// Exit code after a signal: 128 + SIGINT, as shells report it.
const INTERRUPTED: u8 = 130;

/// Installs a signal handler that removes temporary files and exits.
fn exit_on_signal() -> Result<()> {
    ctrlc::set_handler(|| ballrace_twin::output::exit_without_temporary_files(INTERRUPTED.into()))
        .context("signal handler cannot be installed")
}

/// Values of `--format`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Plain text.
    Text,
    /// One JSON document.
    Json,
    /// Comma-separated values with a header.
    Csv,
}

/// Returns standard output. In text format, control characters in names from files are replaced.
fn standard_output(format: Format) -> Box<dyn Write> {
    let out = BufWriter::new(std::io::stdout().lock());
    if format == Format::Text { Box::new(Printable(out)) } else { Box::new(out) }
}

/// Checks that no output overwrites an input or another output.
///
/// # Errors
/// Returns an error that names the option.
fn check_distinct_paths(outputs: &[(&str, &Path)], inputs: &[&Path]) -> Result<()> {
    let real = inputs.iter().filter_map(|path| path.canonicalize().ok());
    let mut used: Vec<PathBuf> = inputs.iter().map(|path| canonical_path(path)).chain(real).collect();
    for (option, path) in outputs {
        let canonical = canonical_path(path);
        if used.contains(&canonical) {
            let problem = "this command already reads or writes this file";
            bail!(UsageError(format!("{option}: {problem}: {}, expected another file", path.display())));
        }
        used.push(canonical);
    }
    Ok(())
}

/// Returns the canonical form of a path, also for a file that does not exist yet.
fn canonical_path(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Runs the command, prints an error as one line to standard error, and returns the exit code.
#[must_use]
pub fn run(cli: &Cli) -> ExitCode {
    if !cli.command.is_live()
        && let Err(error) = exit_on_signal()
    {
        return exit_code(Err(error));
    }
    let result = match &cli.command {
        Command::Replay(args) => {
            return replay_exit_code(replay::run(args, cli.format, args.limit.error));
        }
        Command::Watch(args) => return replay_exit_code(watch::run(args, args.limit.error)),
        Command::Check(args) => return replay_exit_code(check::run(args, cli.format)),
        Command::Fleet(args) => return replay_exit_code(fleet::run(args, cli.format, args.limit.error)),
        Command::Force(args) => force::run(args, cli.format, args.limit.error),
        Command::Bake(args) => bake::run(args, cli.format, args.limit.error),
        Command::Verify(args) => verify::run(args, cli.format),
        Command::Equilibrium(args) => equilibrium::run(args, cli.format, args.limit.error),
        Command::Simulate(args) => simulate::run(args, cli.format, args.limit.error),
        Command::Fmu(args) => fmu::run(args, cli.format),
        Command::Campbell(args) => campbell::run(args, cli.format, args.limit.error),
        Command::Sweep(args) => sweep::run(args, cli.format, args.limit.error),
        Command::Balance(args) => balance::run(args, cli.format),
        Command::Fit(args) => fit::run(args, cli.format),
        Command::Trade(args) => trade::run(args, cli.format, args.limit.error),
        Command::New(args) => new::run(args, cli.format),
        Command::Scenes(args) => scenes::run(args, cli.format),
        Command::Schema(args) => schema::run(args),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
    };
    exit_code(result)
}

/// Exit code of a replay in which a limit of the scene was exceeded.
const LIMIT_CROSSED: u8 = 3;
/// Exit code of a replay whose recording is not plausible for the scene.
const IMPLAUSIBLE: u8 = 4;

/// Result of a replay, reported by the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplayStatus {
    /// Completed without an exceeded limit: exit code 0.
    Completed,
    /// A limit of the scene was exceeded: exit code 3.
    LimitCrossed,
    /// The recording is not plausible for the scene, or is refused as a baseline: exit code 4.
    Implausible,
}

impl From<&Outcome> for ReplayStatus {
    fn from(outcome: &Outcome) -> Self {
        let is_plausible = outcome.implausible.is_empty() && !outcome.is_refused_as_baseline();
        match (is_plausible, outcome.events.is_empty()) {
            (false, _) => Self::Implausible,
            (true, false) => Self::LimitCrossed,
            (true, true) => Self::Completed,
        }
    }
}

fn replay_exit_code(status: Result<ReplayStatus>) -> ExitCode {
    match status {
        Ok(ReplayStatus::LimitCrossed) => ExitCode::from(LIMIT_CROSSED),
        Ok(ReplayStatus::Implausible) => ExitCode::from(IMPLAUSIBLE),
        other => exit_code(other.map(|_| ())),
    }
}

fn exit_code(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "ballrace: {}", printable::message(&format!("{error:#}")));
            ExitCode::from(match error.downcast_ref::<Error>() {
                Some(error) if error.is_implausible() => IMPLAUSIBLE,
                _ if is_usage_error(&error) => 2,
                _ if error.is::<Interrupted>() => INTERRUPTED,
                _ => 1,
            })
        }
    }
}

fn is_usage_error(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.is::<SceneError>()
            || cause.is::<UsageError>()
            || cause.downcast_ref::<Error>().is_some_and(Error::is_usage_error)
            || cause.downcast_ref::<PlantError>().is_some_and(PlantError::is_usage_error)
            || cause.downcast_ref::<RecordingError>().is_some_and(RecordingError::is_scene_fault)
    })
}

/// Returns `true` if the reader of standard output has closed the pipe, as in `ballrace ... | head`.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe))
}
