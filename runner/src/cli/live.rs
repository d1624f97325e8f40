//! Options and set-up shared by `replay --paced` and `watch`.

use crate::error::UsageError;
use crate::live as monitor;
use crate::live::Signals;
use crate::live::address::{Address, DEMONSTRATION};
use crate::live::out::RequestedOutputs;
use crate::live::page::HttpOptions;
use crate::live::source::Encoding;
use crate::live::view::SharedView;
use anyhow::{Context, Result};
use ballrace_twin::scene::read::{read_file, read_str};
use ballrace_twin::scene::{Scene, units};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Scene of the built-in demonstration: a healthy machine.
pub(super) const DEMO_SCENE: &str = crate::live::demonstration::SCENE;
/// Recording of the built-in demonstration: the same machine with a spall on an outer race.
pub(super) const DEMO_RECORDING: &[u8] = include_bytes!("../../demo/outer-spall.csv");
/// Name of the demonstration's recording.
pub(super) const DEMO_NAME: &str = "outer-spall.csv (built in)";

/// Options of live monitoring: source, duration, state, outputs and scheduling.
#[derive(Debug, Clone, clap::Args)]
pub struct LiveArgs {
    /// Source of the samples: a file, - for standard input, tcp:PORT or udp:PORT to listen on this machine, or
    /// tcp:ADDRESS:PORT, or demonstration without SCENE, which is simulated without an end [default: the scene's recording].
    #[arg(long, value_name = "SOURCE")]
    pub source: Option<Address>,
    /// Encoding of the samples on a stream.
    #[arg(long, value_enum, default_value_t = Encoding::Csv)]
    pub encoding: Encoding,
    /// Stop after this much recorded time, e.g. "10 min".
    #[arg(long = "for", value_name = "DURATION", value_parser = parse_duration)]
    pub duration: Option<f64>,
    /// Folder for the monitor's state; a restarted monitor continues at the first unprocessed sample.
    #[arg(long, value_name = "FOLDER")]
    pub state: Option<PathBuf>,
    #[command(flatten)]
    pub outputs: RequestedOutputs,
    #[command(flatten)]
    pub http: HttpOptions,
    /// Request first-in-first-out scheduling (SCHED_FIFO) and locked memory (Linux).
    #[arg(long)]
    pub realtime: bool,
    /// Request to run on this processor (Linux).
    #[arg(long, value_name = "NUMBER")]
    pub core: Option<usize>,
}

impl LiveArgs {
    /// Returns the name of the first given option that requires real-time monitoring.
    #[must_use]
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            (self.source.is_some(), "--source"),
            (self.encoding != Encoding::Csv, "--encoding"),
            (self.duration.is_some(), "--for"),
            (self.state.is_some(), "--state"),
            (self.outputs.events.is_some(), "--events"),
            (self.outputs.indicators.is_some(), "--indicators"),
            (self.outputs.prometheus.is_some(), "--prometheus"),
            #[cfg(feature = "opcua")]
            (self.outputs.opcua.is_some(), "--opcua"),
            #[cfg(feature = "mqtt")]
            (self.outputs.broker.mqtt.is_some(), "--mqtt"),
            #[cfg(feature = "sparkplug")]
            (self.outputs.broker.sparkplug.is_some(), "--sparkplug"),
            (self.http.address.is_some(), "--http"),
            (self.realtime, "--realtime"),
            (self.core.is_some(), "--core"),
        ];
        given.into_iter().find(|(is_given, _)| *is_given).map(|(_, option)| option)
    }

    /// Returns the monitor's options.
    #[must_use]
    pub fn options<'a>(
        &'a self,
        source: Address,
        view: Option<SharedView>,
        mut replay: ballrace_twin::replay::Options<'a>,
    ) -> monitor::Options<'a> {
        replay.viewed = view.is_some() || self.http.address.is_some();
        monitor::Options {
            source,
            encoding: self.encoding,
            duration: self.duration,
            state: self.state.as_deref(),
            outputs: &self.outputs,
            http: &self.http,
            realtime: self.realtime,
            core: self.core,
            view,
            replay,
        }
    }

    /// Returns the address of the source: `--source`, else `recording`, else the scene's recording, else `demonstration`.
    ///
    /// # Errors
    /// Returns an error if the simulated demonstration is requested for another scene.
    pub fn source(
        &self,
        scene: &Scene,
        recording: Option<&Path>,
        demonstration: Option<Address>,
    ) -> Result<Address, UsageError> {
        match (&self.source, recording, &scene.recording, demonstration) {
            (Some(Address::Demonstration), _, _, None) => Err(UsageError(format!(
                "--source {DEMONSTRATION}: simulates the built-in machine, expected no SCENE, or another source"
            ))),
            (Some(source), ..) => Ok(source.clone()),
            (None, Some(path), ..) => Ok(Address::File(path.to_owned())),
            (None, None, Some(recording), None) => Ok(Address::File(recording.file.clone())),
            (None, None, _, demonstration) => Ok(demonstration.unwrap_or(Address::BuiltIn(DEMO_RECORDING, DEMO_NAME))),
        }
    }
}

pub(super) fn parse_duration(text: &str) -> Result<f64, String> {
    let expected = || "expected a time above 0 with its unit, such as \"10 s\"".to_owned();
    let seconds = units::parse(text, units::Dimension::Time).map_err(|_| expected())?;
    if seconds > 0.0 && seconds.is_finite() { Ok(seconds) } else { Err(expected()) }
}

/// Reads the scene file at `path`, or the demonstration's scene without a path.
///
/// # Errors
/// Returns an error if the scene is invalid.
pub fn read_scene(path: Option<&Path>) -> Result<Scene> {
    match path {
        Some(path) => Ok(read_file(path)?),
        None => Ok(read_str(DEMO_SCENE, Path::new("built-in demonstration"))?),
    }
}

/// Installs signal handlers and returns the flags that they set: Ctrl-C and termination signals stop the monitor, SIGHUP reopens
/// its event log. Called before other threads are started.
///
/// # Errors
/// Returns an error if a signal handler cannot be installed.
pub fn handle_signals() -> Result<Arc<Signals>> {
    const FAILED: &str = "signal handler cannot be installed";
    let signals = Arc::new(Signals::default());
    // Before any other thread is started: they inherit the mask, so that no other one receives the signal.
    #[cfg(unix)]
    let hangup = hangup::block().context(FAILED)?;
    let flags = signals.clone();
    ctrlc::set_handler(move || flags.stop.store(true, Ordering::Relaxed)).context(FAILED)?;
    #[cfg(unix)]
    hangup::wait(hangup, signals.clone()).context(FAILED)?;
    Ok(signals)
}

/// SIGHUP: a request to reopen the event log, or the end of the terminal.
#[cfg(unix)]
mod hangup {
    use crate::live::Signals;
    use nix::sys::signal::{SigSet, Signal};
    use std::io::{IsTerminal, stderr, stdin, stdout};
    use std::sync::Arc;
    use std::sync::atomic::Ordering;

    /// Blocks the signal for this thread and those that it starts.
    pub(super) fn block() -> nix::Result<SigSet> {
        let mut set = SigSet::empty();
        set.add(Signal::SIGHUP);
        set.thread_block()?;
        Ok(set)
    }

    /// Waits for the signal on a thread.
    pub(super) fn wait(set: SigSet, signals: Arc<Signals>) -> std::io::Result<()> {
        let terminals = terminals();
        let work = move || {
            while set.wait().is_ok() {
                // A terminal that was closed is none any more, and the monitor ends with it.
                let is_closed = terminals.iter().zip(self::terminals()).any(|(before, now)| *before && !now);
                let flag = if is_closed { &signals.stop } else { &signals.reopen };
                flag.store(true, Ordering::Relaxed);
            }
        };
        std::thread::Builder::new().name("hangup".to_owned()).spawn(work).map(drop)
    }

    fn terminals() -> [bool; 3] {
        [stdin().is_terminal(), stdout().is_terminal(), stderr().is_terminal()]
    }
}
