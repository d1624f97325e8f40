//! `ballrace fleet`: evaluates a table of machines.

use super::{Format, ReplayStatus};
use anyhow::{Context, Result};
use ballrace_report::fleet::{Fleet, Folder, text};
use ballrace_twin::error::Error;
use ballrace_twin::fleet::{self, Machine, Row, Settings, State, Store};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

/// Arguments of `fleet`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Table of machines in CSV or Parquet with the columns machine and scene, and optionally recording, baseline and time; other
    /// columns are tags.
    machines: PathBuf,
    /// Folder of the results: outcomes/part-*.parquet, reports/*.html, trends.csv, index.html.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of machines evaluated in parallel [default: number of processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Longest time of a machine without progress, such as on a disk that does not answer; its row is then an error.
    #[arg(long, value_name = "DURATION", default_value = "10 min", value_parser = super::live::parse_duration)]
    time_limit: f64,
    /// Write no report of each machine.
    #[arg(long)]
    no_report: bool,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Runs the command and returns the status for the exit code.
///
/// # Errors
/// Returns an error if the table is invalid or a result cannot be written. An error of one machine is a row of the results.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<ReplayStatus> {
    let machines = fleet::read_table(&args.machines).map_err(Error::from)?;
    let _lock = fleet::lock(&args.output).map_err(Error::from)?;
    let folder = Folder::create(&args.output, &machines)?;
    let mut store = Store::open(&folder.outcomes())?;
    let is_done =
        |machine: &&Machine| store.get(&machine.key()).is_some_and(|row| folder.is_done(machine, row, !args.no_report));
    let (done, missing): (Vec<&Machine>, Vec<&Machine>) = machines.iter().partition(is_done);
    let start = std::time::Instant::now();
    evaluate(args, &folder, &mut store, &missing, error)?;
    let elapsed = start.elapsed();
    let order: Vec<_> = machines.iter().map(Machine::key).collect();
    if !missing.is_empty() || !store.is_compact() {
        store.compact(&order)?;
    }
    let rows: Vec<Row> = order.iter().filter_map(|key| store.get(key).cloned()).collect();
    let trends = fleet::trends(&rows);
    let name = args.machines.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    folder.write_overview(&name, &rows, &trends)?;
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?,
        Format::Csv => fleet::csv(&mut out, &rows)?,
        Format::Text => {
            write!(out, "{}", text(&Fleet { name: &name, rows: &rows, trends: &trends, link: &|_| None }))?;
            let (new, old) = (missing.len(), done.len());
            writeln!(out, "\nEvaluated: {new} in {:.1} s, {old} from an earlier run", elapsed.as_secs_f64())?;
            writeln!(out, "Overview: {}", folder.index().display())?;
        }
    }
    out.flush()?;
    let is_crossed = fleet::current(&rows).iter().any(|row| row.state == State::Limit);
    Ok(if is_crossed { ReplayStatus::LimitCrossed } else { ReplayStatus::Completed })
}

/// Evaluates the machines that are missing in the store, with a progress bar on a terminal.
fn evaluate(
    args: &Args,
    folder: &Folder,
    store: &mut Store,
    missing: &[&Machine],
    force_error: Option<f64>,
) -> Result<()> {
    let processors = || std::thread::available_parallelism().map_or(1, Into::into);
    let jobs = args.jobs.map_or_else(processors, usize::from);
    let bar =
        if std::io::stderr().is_terminal() { ProgressBar::new(missing.len() as u64) } else { ProgressBar::hidden() };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} recordings, {eta} left{msg}") {
        bar.set_style(style);
    }
    let patience = std::time::Duration::try_from_secs_f64(args.time_limit).unwrap_or(std::time::Duration::MAX);
    let settings = Settings { jobs, force_error, patience };
    let mut counts = State::ALL.map(|state| (state, 0_u64));
    let report = |_: &Machine, evaluation: &mut fleet::Evaluation| {
        if args.no_report {
            // The report of an earlier evaluation is removed.
            evaluation.outcome = None;
        }
        Ok(folder.write_report(evaluation)?)
    };
    let count = |row: &Row| {
        counts.iter_mut().filter(|(state, _)| *state == row.state).for_each(|(_, count)| *count += 1);
        let shown = counts.iter().filter(|(state, count)| *state != State::Normal && *count > 0);
        bar.set_message(shown.map(|(state, count)| format!("; {count} {state}")).collect::<String>());
        bar.inc(1);
    };
    let result = fleet::run(missing, store, settings, report, count);
    bar.finish_and_clear();
    result.context("the rows that are finished are kept")
}
