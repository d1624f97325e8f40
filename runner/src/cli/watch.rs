//! `ballrace watch`: live monitoring in the terminal.

use super::ReplayStatus;
use super::live::{self, LiveArgs};
use crate::dashboard;
use crate::error::UsageError;
use crate::live as monitor;
use crate::live::address::Address;
use crate::live::view::{Conclusion, MonitorState, SharedView};
use anyhow::{Result, bail};
use ballrace_report as report;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::printable;
use ballrace_twin::replay::Options;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Arguments of `watch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file; without one, the built-in demonstration.
    scene: Option<PathBuf>,
    /// Write an HTML report at the end.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Compare with a baseline stored by `replay --learn`.
    #[arg(long, value_name = "BASELINE.json")]
    baseline: Option<PathBuf>,
    /// Diagnose samples that are not plausible for the scene all the same.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
    #[command(flatten)]
    live: LiveArgs,
}

/// Runs the command and returns the status for the exit code.
///
/// # Errors
/// Returns an error if scene, source or outputs are invalid, or if standard output is not a terminal.
pub fn run(args: &Args, error: Option<f64>) -> Result<ReplayStatus> {
    if !std::io::stdout().is_terminal() {
        bail!(UsageError(
            "watch: standard output is not a terminal, expected a terminal; use `ballrace replay --paced` without one"
                .to_owned()
        ));
    }
    let scene = live::read_scene(args.scene.as_deref())?;
    let view = SharedView::default();
    // Without a scene, the endless simulation is shown instead of the built-in recording.
    let source = args.live.source(&scene, None, args.scene.is_none().then_some(Address::Demonstration))?;
    let name = source.to_string();
    let baseline = args.baseline.as_deref();
    let replay =
        Options { error, baseline, live: true, viewed: true, force_diagnosis: args.force, ..Options::default() };
    let options = args.live.options(source, Some(view.clone()), replay);
    let (signals, failed) = (live::handle_signals()?, AtomicBool::new(false));
    let stop = &signals.stop;
    let (outcome, view_result) = std::thread::scope(|scope| {
        let run_monitor = || {
            let outcome = monitor::monitor(&scene, &options, &signals);
            match &outcome {
                // The final state is displayed until the user presses q.
                Ok(outcome) => view.update(|view| {
                    view.set_state(MonitorState::Ended);
                    view.conclusion =
                        Some(Conclusion { verdict: outcome.verdict.clone(), diagnoses: outcome.diagnoses.clone() });
                }),
                Err(_) => failed.store(true, Ordering::Relaxed),
            }
            outcome
        };
        let thread = std::thread::Builder::new().name("monitor".to_owned()).spawn_scoped(scope, run_monitor)?;
        let view_result = dashboard::show(&scene, &name, &view, stop, &failed);
        stop.store(true, Ordering::Relaxed);
        Ok::<_, std::io::Error>((thread.join(), view_result))
    })?;
    let Ok(outcome) = outcome else { bail!("the monitor thread panicked") };
    let outcome = outcome?;
    view_result?;
    if let Some(path) = &args.report {
        AtomicFile::write(path, &report::html(&outcome)?)?;
    }
    // The terminal may be closed; report and state have been written.
    let mut out = std::io::stdout().lock();
    for sentence in std::iter::once(outcome.verdict.clone()).chain(report::pacing(&outcome.timing)) {
        let _ = writeln!(out, "{}", printable::lines(&sentence));
    }
    Ok(ReplayStatus::from(&outcome))
}
