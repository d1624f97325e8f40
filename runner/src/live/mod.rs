//! Live monitor: processes the samples of a source with kernel and twin in real time.
//!
//! A thread reads the source into a ring. The monitor loop wakes at absolute times, processes the samples that are due, and
//! passes indicators and events to the outputs.
//!
//! With a state folder, every second and every limit event is written exactly once, even if the process is killed. The order
//! of writing ensures this: first the indicators, then the state with the positions of indicators and limits and with the new
//! event lines, then these lines in the event log, then the acknowledgement. A restart appends the lines of the state that
//! are missing in the log, and ignores samples before the positions.

mod acknowledgement;
pub mod address;
pub mod alarms;
mod backlog;
mod connections;
mod datagrams;
pub mod demonstration;
mod display;
pub mod feed;
pub mod frames;
mod http;
mod monitor_loop;
pub mod out;
pub mod pace;
pub mod page;
pub mod realtime;
mod service;
mod silence;
pub mod source;
pub mod state;
mod state_lines;
pub mod status;
pub mod view;

use crate::error::{Interrupted, UsageError};
use acknowledgement::Acknowledgement;
use address::Address;
use anyhow::{Result, bail};
use backlog::Backlog;
use ballrace_twin::record::{EventMessage, EventRecord};
use ballrace_twin::recording::flaws::FlawSummary;
use ballrace_twin::replay::outcome::{Outcome, SourceFigures};
use ballrace_twin::replay::{self, Replay};
use ballrace_twin::scene::{Recording, Scene};
use display::Display;
use feed::{CAPACITY, CAPACITY_OF_RECORDING, FeedItem, FeedReceiver};
use monitor_loop::{Monitor, READER_TIMEOUT, copy_counters};
use out::{Network, Outputs};
use pace::{BLOCK_PERIOD, BlockSchedule};
use service::Service;
use silence::Silence;
use source::{Encoding, ReaderHandle};
use state::{State, StateFile};
use state_lines::StateLines;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use view::{MonitorState, SharedView};

/// Options of a monitor.
pub struct Options<'a> {
    /// Source of the samples.
    pub source: Address,
    /// Encoding of the samples on a stream.
    pub encoding: Encoding,
    /// Recorded time after which the monitor ends, s; `None` for the end of the source.
    pub duration: Option<f64>,
    /// Folder of the state.
    pub state: Option<&'a Path>,
    /// Requested outputs.
    pub outputs: &'a out::RequestedOutputs,
    /// Live page.
    pub http: &'a page::HttpOptions,
    /// Request real-time scheduling and locked memory.
    pub realtime: bool,
    /// Request to run on this processor.
    pub core: Option<usize>,
    /// Data of the live display.
    pub view: Option<SharedView>,
    /// Options of the replay.
    pub replay: replay::Options<'a>,
}

/// Requests to a monitor, set by signals.
#[derive(Debug, Default)]
pub struct Signals {
    /// End.
    pub stop: AtomicBool,
    /// Reopen the event log if its path names another file or none.
    pub reopen: AtomicBool,
}

/// Runs the monitor until the source or the duration ends, or a signal stops it.
///
/// # Errors
/// Returns an error if the scene has no displacement probes, the source cannot be read, or an output cannot be opened.
pub fn monitor(scene: &Scene, options: &Options, signals: &Signals) -> Result<Outcome> {
    let stop = &signals.stop;
    let recording = probe_recording(scene)?;
    // The state is locked and the ports are bound before any file is changed, so that a failed start changes nothing.
    let mut state = options.state.map(|folder| StateFile::open(folder, &scene.name)).transpose()?;
    let network = Network::bind(options.outputs, &options.http.hosts)?;
    let shared = options.view.clone().or_else(|| options.http.address.map(|_| SharedView::default()));
    let previous = state.as_ref().map_or_else(State::default, |file| file.state.clone());
    // The first state that the page shows has the alarms from before a restart.
    let mut display = Display::new(shared.clone());
    display.view.alarms = previous.alarms.clone();
    display.view.set_state(MonitorState::Waiting);
    display.publish();
    let page = shared.as_ref().map(|shared| page::Page::start(options, scene, shared)).transpose()?.flatten();
    let can_repeat = options.encoding != Encoding::Csv || options.source.is_recording();
    let (resume, start_time, is_resumed) = (previous.resume(can_repeat), previous.time_s, previous.starts > 0);
    let capacity = if options.source.is_recording() { CAPACITY_OF_RECORDING } else { CAPACITY };
    let (sender, mut receiver) = feed::feed(capacity);
    if let Some(file) = &mut state {
        let acknowledged = *file.state.acknowledged.get_or_insert(resume.index);
        receiver.counters.acknowledged.store(acknowledged, Ordering::Relaxed);
    }
    let reader = source::start(&options.source, options.encoding, scene, recording, resume, sender)?;
    let mut outputs = Outputs::open(options.outputs, network, state.as_ref().map(|file| &file.state))?;
    state.as_mut().map_or(Ok(()), StateFile::begin)?;
    let mut service = Service::ready();
    let damages = state.as_mut().and_then(|file| file.damage.take()).into_iter().chain(outputs.take_damage());
    for sentence in damages {
        let event = EventRecord::new(EventMessage { kind: "file-damaged", sentence }, start_time);
        display.view.add_event(&event);
        outputs.add_event(&event)?;
    }
    outputs.save_events();
    display.publish();
    let rate = wait_for_rate(&reader, &mut receiver, stop, &mut service, |message| {
        let event = EventRecord::new(message, start_time);
        display.view.add_event(&event);
        display.publish();
        outputs.add_event(&event)?;
        outputs.save_events();
        Ok(())
    });
    let Some(rate) = rate? else {
        bail!(Interrupted(format!("{}: stopped before the first sample arrived", options.source)))
    };
    let scheduling = realtime::request(options.realtime, options.core);
    let mut replay = Replay::try_new(scene, rate, &options.replay)?;
    let average = u64::from(recording.average);
    if let Some(limits) = &previous.limits {
        replay.restore_limits(&limits.clone().map_positions(|index| index.div_ceil(average)));
    }
    replay.restore_faults(&previous.faults);
    display.view.alarms.restore_limits(&replay.limit_status());
    display.view.alarms.update_faults(&replay.diagnoses());
    if is_resumed {
        let sentence = format!("The monitor resumed at sample {} ({:.3} s).", resume.index, start_time);
        outputs.add_event(&EventRecord::new(EventMessage { kind: "monitor-resumed", sentence }, start_time))?;
    }
    let mut monitor = Monitor {
        options,
        replay,
        receiver,
        outputs,
        state: state.as_mut(),
        acknowledgement: Acknowledgement::new(&reader.ack_channel, &resume),
        rate,
        average,
        seconds_index: previous.seconds_index,
        seconds_time: start_time,
        first_time: None,
        time: start_time,
        published_time: f64::NEG_INFINITY,
        silence: Silence::new(),
        backlog: Backlog::new(matches!(options.source, Address::Udp(_))),
        source: SourceFigures { ring_capacity: capacity as u64, ..SourceFigures::default() },
        schedule: BlockSchedule::try_new()?,
        display,
        lines: StateLines::new(options.view.is_some()),
        page,
        is_state_changed: false,
        service,
    };
    let result = monitor.run(signals);
    // After an error, the results up to the error are written.
    monitor.save_remaining();
    result?;
    let Monitor { replay, receiver, outputs, schedule, mut source, .. } = monitor;
    let counters = receiver.counters.clone();
    let omitted_events = receiver.omitted_events();
    drop(receiver);
    let output_figures = outputs.finish();
    let flaws = join_reader(reader.thread)?;
    let has_reader_ended = flaws.is_some();
    let mut outcome = replay.finish(&options.source.to_string(), flaws.unwrap_or_default())?;
    if !has_reader_ended {
        outcome
            .notes
            .push("The reader was still waiting for its source: flaws of the samples are not listed.".to_owned());
    }
    outcome.notes.extend(omitted_events);
    copy_counters(&counters, &mut source);
    outcome.timing.paced = true;
    outcome.timing.pacing = Some(schedule.statistics(scheduling));
    outcome.timing.source = Some(source);
    outcome.timing.outputs = Some(output_figures);
    Ok(outcome)
}

/// Returns the scene's recording of displacement probes.
///
/// # Errors
/// Returns an error if the scene has no recording, or one of vibration sensors alone.
fn probe_recording(scene: &Scene) -> Result<&Recording> {
    let file = scene.path.display();
    match &scene.recording {
        None => bail!(UsageError(format!("{file}: missing table [recording], expected probes of the shaft's motion"))),
        Some(recording) if recording.probes.is_empty() => bail!(UsageError(format!(
            "{file}: [recording]: sensors alone cannot be monitored in real time, expected probes of the shaft's motion beside them"
        ))),
        Some(recording) => Ok(recording),
    }
}

/// Waits for the sampling rate of the source; returns `None` if the monitor is stopped first. Events that arrive before it are
/// passed to `record`.
fn wait_for_rate(
    reader: &ReaderHandle,
    receiver: &mut FeedReceiver,
    stop: &AtomicBool,
    service: &mut Service,
    mut record: impl FnMut(EventMessage) -> Result<()>,
) -> Result<Option<f64>> {
    loop {
        service.keep_alive();
        while let Some(FeedItem::Event(message)) = receiver.pop_if(|_| false) {
            record(message)?;
        }
        while let Some(message) = receiver.next_event() {
            record(message)?;
        }
        match reader.rate.recv_timeout(Duration::from_millis(50)) {
            Ok(rate) => return rate.map(Some),
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) if !stop.load(Ordering::Relaxed) => {}
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => return Ok(None),
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => {
                bail!("the source ended before the first sample arrived")
            }
        }
    }
}

/// Returns the result of the reader thread, or `None` if it is still blocked by standard input.
fn join_reader(thread: std::thread::JoinHandle<Result<Vec<FlawSummary>>>) -> Result<Option<Vec<FlawSummary>>> {
    let start = Instant::now();
    while !thread.is_finished() && start.elapsed() < READER_TIMEOUT {
        std::thread::sleep(BLOCK_PERIOD);
    }
    if !thread.is_finished() {
        return Ok(None);
    }
    thread.join().unwrap_or_else(|_| bail!("the reader thread panicked")).map(Some)
}
