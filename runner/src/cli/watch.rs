//! `ballrace watch`

use super::Ending;
use super::live::{self, LiveArgs};
use crate::dashboard;
use crate::error::UsageError;
use crate::live as monitor;
use crate::live::source::lock;
use crate::live::view::{Conclusion, SharedView};
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
    #[command(flatten)]
    live: LiveArgs,
}

/// Runs the command; returns what the exit code reports.
///
/// # Errors
/// Returns an error if scene, source or outputs are invalid, or standard output is no terminal.
pub fn run(args: &Args, error: Option<f64>) -> Result<Ending> {
    if !std::io::stdout().is_terminal() {
        bail!(UsageError(
            "watch: found a standard output that is no terminal, allowed: a terminal, or `ballrace replay --paced`"
                .to_owned()
        ));
    }
    let scene = live::scene(args.scene.as_deref())?;
    let view = SharedView::default();
    let source = args.live.source(&scene, None, args.scene.is_none());
    let name = source.to_string();
    let replay = Options { error, baseline: args.baseline.as_deref(), live: true, viewed: true, ..Options::default() };
    let options = args.live.options(source, Some(view.clone()), replay);
    let (stop, over) = (live::stop_on_signal()?, AtomicBool::new(false));
    let (outcome, shown) = std::thread::scope(|scope| {
        let work = || {
            let outcome = monitor::monitor(&scene, &options, &stop);
            match &outcome {
                // The last picture stays until a key is pressed.
                Ok(outcome) => {
                    let mut view = lock(&view);
                    view.state = "ended: press q";
                    view.conclusion =
                        Some(Conclusion { verdict: outcome.verdict.clone(), findings: outcome.findings.clone() });
                }
                Err(_) => over.store(true, Ordering::Relaxed),
            }
            outcome
        };
        let work = std::thread::Builder::new().name("monitor".to_owned()).spawn_scoped(scope, work)?;
        let shown = dashboard::show(&scene, &name, &view, &stop, &over);
        stop.store(true, Ordering::Relaxed);
        Ok::<_, std::io::Error>((work.join(), shown))
    })?;
    let Ok(outcome) = outcome else { bail!("the monitor failed") };
    let outcome = outcome?;
    shown?;
    if let Some(path) = &args.report {
        AtomicFile::write(path, &report::html(&outcome)?)?;
    }
    // The terminal may have gone; report and state are written.
    let mut out = std::io::stdout().lock();
    for sentence in std::iter::once(outcome.verdict.clone()).chain(report::pacing(&outcome.timing)) {
        let _ = writeln!(out, "{}", printable::lines(&sentence));
    }
    Ok(Ending::from(&outcome))
}
