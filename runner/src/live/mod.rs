//! Live monitor: processes the samples of a source with kernel and twin in real time.
//!
//! A thread reads the source into a ring. The monitor loop wakes at absolute times, processes the samples that are due, and
//! passes indicators and events to the outputs.
//!
//! With a state folder, every second and every limit event is written exactly once, even if the process is killed. The order
//! of writing ensures this: first the indicators, then the state with the positions of indicators and limits and with the new
//! event lines, then these lines in the event log, then the acknowledgement. A restart appends the lines of the state that
//! are missing in the log, and ignores samples before the positions.

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
pub mod out;
pub mod pace;
pub mod page;
pub mod realtime;
mod service;
pub mod source;
pub mod state;
mod state_lines;
pub mod status;
pub mod view;

use crate::error::{Interrupted, UsageError};
use address::Address;
use anyhow::{Result, bail};
use backlog::Backlog;
use ballrace_twin::record::{EventMessage, EventRecord};
use ballrace_twin::recording::Row;
use ballrace_twin::recording::flaws::FlawSummary;
use ballrace_twin::replay::outcome::{Outcome, SourceFigures};
use ballrace_twin::replay::{self, Replay};
use ballrace_twin::scene::{Recording, Scene};
use display::Display;
use feed::{CAPACITY, CAPACITY_OF_RECORDING, FeedItem, FeedReceiver, SourceCounters};
use out::{Network, Outputs};
use pace::{BLOCK_PERIOD, BlockSchedule};
use service::Service;
use source::{AckReceiver, Encoding, ReaderHandle, Resume, lock};
use state::{State, StateFile};
use state_lines::StateLines;
use status::Status;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use view::{MonitorState, SharedView};

/// Time without samples after which a source is silent.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);
/// Time after which a source has an acknowledgement, or its connection has ended.
const TRANSIT_TIME: Duration = Duration::from_secs(20);
/// Time limit for the end of the reader thread, which may be blocked by standard input.
const READER_TIMEOUT: Duration = Duration::from_millis(500);
/// Longest time for which the twin processes queued samples after a signal.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest time in the recording of the samples of one block, s: many times the real-time rate, but outputs and view
/// stay up to date.
const BLOCK_SPAN: f64 = 0.25;
/// Number of samples that a block may have in any case: those of a slow machine cover minutes, and are processed in some
/// milliseconds.
const MIN_BLOCK: usize = 1000;
/// Longest time for which the twin processes samples in one block.
const WORK_LIMIT: Duration = Duration::from_millis(50);

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
        ack_channel: &reader.ack_channel,
        rate,
        average,
        seconds_index: previous.seconds_index,
        seconds_time: start_time,
        // The state of an earlier run is on disk.
        acknowledged: resume.sequence.filter(|_| resume.index > 0).map(|sequence| sequence.wrapping_sub(1)),
        repeated: 0,
        in_transit: VecDeque::new(),
        first_time: None,
        time: start_time,
        last_arrival: Instant::now(),
        arrived_rows: 0,
        published_time: f64::NEG_INFINITY,
        is_silent: false,
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

fn copy_counters(counters: &SourceCounters, figures: &mut SourceFigures) {
    let read = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
    figures.rows = read(&counters.rows);
    figures.lost_frames = read(&counters.lost);
    figures.repeated_frames = read(&counters.repeated);
    figures.malformed_frames = read(&counters.malformed);
    figures.dropped_rows = read(&counters.dropped);
    figures.ring_highest = read(&counters.ring_highest);
    figures.connections = read(&counters.connections);
}

/// State of the monitor loop.
struct Monitor<'a, 'o> {
    options: &'a Options<'o>,
    replay: Replay<'a>,
    receiver: FeedReceiver,
    outputs: Outputs,
    state: Option<&'a mut StateFile>,
    ack_channel: &'a source::AckChannel,
    /// Sampling rate of the source, Hz.
    rate: f64,
    /// Number of samples of the source in one sample of the replay.
    average: u64,
    /// First sample after the last second that was passed to the outputs.
    seconds_index: u64,
    /// End of that second, s.
    seconds_time: f64,
    /// Last sequence number that is acknowledged, or was before a restart.
    acknowledged: Option<u32>,
    /// Frames that the source has sent twice.
    repeated: u64,
    /// Acknowledgements that may be in transit: time, and number of the first sample after it.
    in_transit: VecDeque<(Instant, u64)>,
    /// Time of the first row, s.
    first_time: Option<f64>,
    /// Time of the latest row, s.
    time: f64,
    /// Time at which new rows were last seen.
    last_arrival: Instant,
    /// Number of rows that had arrived at that time.
    arrived_rows: u64,
    /// End of the last published second, s.
    published_time: f64,
    is_silent: bool,
    backlog: Backlog,
    source: SourceFigures,
    schedule: BlockSchedule,
    display: Display,
    lines: StateLines,
    page: Option<page::Page>,
    /// The state has to be written.
    is_state_changed: bool,
    service: Service,
}

impl Monitor<'_, '_> {
    fn run(&mut self, signals: &Signals) -> Result<()> {
        let stop = &signals.stop;
        while !stop.load(Ordering::Relaxed) && !self.receiver.is_finished() && !self.has_reached_duration() {
            let block_time = self.schedule.wait();
            self.service.keep_alive();
            let block_start = Instant::now();
            // Counted before the block, so that the events that precede a row in the ring are recorded before it ends a silence.
            let arrived_rows = self.arrived_rows();
            let caught_up = self.process_block(block_time)?;
            self.publish()?;
            self.check_silence(arrived_rows)?;
            self.acknowledge_again();
            self.report_backlog()?;
            self.acknowledge_alarms()?;
            if signals.reopen.swap(false, Ordering::Relaxed) {
                self.outputs.reopen();
            }
            self.update_view();
            self.schedule.finish_block(block_start, caught_up);
        }
        self.receiver.stop();
        if stop.load(Ordering::Relaxed) && !self.options.source.is_recording() {
            self.drain_ring()?;
        }
        self.replay.end()?;
        self.process_queue(stop)
    }

    /// Processes the items in the ring until the reader thread has ended, or until the time limit.
    fn drain_ring(&mut self) -> Result<()> {
        let start = Instant::now();
        while !self.receiver.is_finished() && start.elapsed() < READER_TIMEOUT {
            match self.receiver.pop_if(|_| true) {
                Some(item) => self.process_item(item)?,
                None => std::thread::sleep(BLOCK_PERIOD),
            }
        }
        while let Some(item) = self.receiver.pop_if(|_| true) {
            self.process_item(item)?;
        }
        self.publish()
    }

    /// Processes the samples that are queued for the twin; after a signal until a time limit, because the system kills a
    /// process that does not end.
    fn process_queue(&mut self, stop: &AtomicBool) -> Result<()> {
        let mut stopped_at = None;
        loop {
            if stop.load(Ordering::Relaxed) {
                self.replay.cancel_search();
                if stopped_at.get_or_insert_with(Instant::now).elapsed() >= STOP_TIMEOUT {
                    self.replay.discard_waiting();
                }
            }
            if self.replay.is_searching() {
                std::thread::sleep(BLOCK_PERIOD);
            }
            self.service.keep_alive();
            self.replay.work(Some(Instant::now() + WORK_LIMIT))?;
            self.publish()?;
            self.update_view();
            if self.replay.is_idle() {
                return Ok(());
            }
        }
    }

    fn has_reached_duration(&self) -> bool {
        self.options.duration.zip(self.first_time).is_some_and(|(duration, first)| self.time - first >= duration)
    }

    /// Processes the samples that are due at `block_time` since the start of the schedule; returns `true` if none of them is
    /// left.
    fn process_block(&mut self, block_time: Duration) -> Result<bool> {
        let is_recording = self.options.source.is_recording();
        let has_started = self.replay.has_started();
        let end = self.first_time.map_or(f64::INFINITY, |first| first + block_time.as_secs_f64());
        let is_due = |row: &Row| !is_recording || !has_started || row.time < end;
        let mut processed = 0;
        let max_items =
            if self.first_time.is_none() { 1 } else { ((self.rate * BLOCK_SPAN) as usize + 1).max(MIN_BLOCK) };
        // A recording is paused while the twin starts.
        while processed < max_items
            && !(is_recording && self.replay.is_searching())
            && self.replay.waiting() < CAPACITY
            && let Some(item) = self.receiver.pop_if(is_due)
        {
            processed += 1;
            self.process_item(item)?;
        }
        while let Some(message) = self.receiver.next_event() {
            self.record_event(&EventRecord::new(message, self.time))?;
        }
        self.replay.work(Some(Instant::now() + WORK_LIMIT))?;
        if is_recording && !has_started && self.replay.has_started() {
            // The recording is replayed in real time from here on.
            self.schedule.restart();
            return Ok(false);
        }
        Ok(processed < max_items && self.replay.has_started() && self.replay.is_idle())
    }

    fn process_item(&mut self, item: FeedItem) -> Result<()> {
        match item {
            FeedItem::Row(row) => self.process_row(row),
            FeedItem::Event(message) => self.record_event(&EventRecord::new(message, self.time)),
        }
    }

    fn process_row(&mut self, row: Row) -> Result<()> {
        if self.first_time.is_none() {
            self.first_time = Some(row.time);
            // The time before the first sample is not part of the statistics.
            self.schedule = BlockSchedule::try_new()?;
        }
        self.time = row.time;
        let spare = self.replay.blank();
        self.receiver.recycle(spare);
        Ok(self.replay.push(row)?)
    }

    fn record_event(&mut self, event: &EventRecord) -> Result<()> {
        self.display.view.add_event(event);
        self.is_state_changed |= event.changes_state();
        self.outputs.add_event(event)
    }

    /// Passes new events and seconds to the outputs, and writes them.
    fn publish(&mut self) -> Result<()> {
        let update = self.replay.take_update();
        self.is_state_changed |= !update.seconds.is_empty();
        for event in update.events {
            let record = EventRecord::limit(event);
            if let Some(event) = &record.limit {
                self.display.view.alarms.limit_event(event, &record.sentence);
            }
            self.record_event(&record)?;
        }
        if !update.notices.is_empty() {
            self.display.view.alarms.update_faults(&self.replay.diagnoses());
        }
        for notice in update.notices {
            let message = EventMessage { kind: notice.kind, sentence: notice.sentence };
            self.record_event(&EventRecord::new(message, notice.time_s))?;
        }
        for second in &update.seconds {
            let next_index = second.next_index * self.average;
            if next_index <= self.seconds_index {
                // Written before a restart; its samples are processed again for the limits only.
                continue;
            }
            (self.seconds_index, self.seconds_time) = (next_index, second.time_s);
            self.outputs.add_second(second, next_index)?;
        }
        // While the twin catches up, its seconds are older than the preliminary ones, which have readings only.
        let mut latest = None;
        for second in update.preliminary.iter().chain(&update.seconds) {
            self.display.view.add_second(second);
            if second.time_s >= self.published_time {
                self.published_time = second.time_s;
                latest = Some(second);
            }
        }
        if let Some(second) = latest {
            let limits = self.replay.limit_status();
            self.outputs.publish(second, &limits, &self.receiver.counters, self.schedule.misses());
        }
        if std::mem::take(&mut self.is_state_changed) || self.outputs.is_retry_due() {
            self.save();
        } else {
            // Events of the source are not part of the state.
            self.outputs.save_events();
        }
        for message in self.outputs.take_events() {
            self.record_event(&EventRecord::new(message, self.time))?;
        }
        Ok(())
    }

    /// Writes the indicators, then the state with the pending events, then these events, and acknowledges only afterwards.
    fn save(&mut self) {
        let has_indicators = self.outputs.save_indicators();
        if let Some(StateFile { state, .. }) = self.state.as_deref_mut() {
            if has_indicators {
                (state.seconds_index, state.time_s) = (self.seconds_index, self.seconds_time);
            }
            let average = self.average;
            state.alarms.clone_from(&self.display.view.alarms);
            state.faults = self.replay.fault_state();
            state.limits = self.replay.limit_state().map(|limits| limits.map_positions(|index| index * average));
            let index = state.first_unprocessed();
            // Sequence numbers count lost samples too, so that differences of sample numbers apply to them.
            let sequence = self.receiver.sequence_at(index).or(state.resume.sequence);
            state.resume = Resume { index, sequence };
        }
        let has_state = self.outputs.save_state(self.state.as_deref_mut());
        let has_events = self.outputs.save_events();
        if has_indicators && has_state && has_events {
            self.acknowledge();
        }
    }

    /// Writes everything that is pending at the end.
    fn save_remaining(&mut self) {
        self.outputs.retry_now();
        if let Some(message) = self.backlog.dropped(&self.receiver) {
            let _ = self.record_event(&EventRecord::new(message, self.time));
        }
        // The state of the limits already includes these events.
        let _ = self.publish();
        self.save();
        for message in self.outputs.take_events() {
            let _ = self.record_event(&EventRecord::new(message, self.time));
        }
        self.outputs.save_events();
        // The final state does not repeat events that are in the log.
        self.outputs.save_state(self.state.as_deref_mut());
    }

    /// Sends the source the sequence number up to which it may discard frames.
    fn acknowledge(&mut self) {
        let Some(file) = &mut self.state else { return };
        let Some(last) = file.state.resume.sequence.map(|sequence| sequence.wrapping_sub(1)) else { return };
        let index = file.state.resume.index;
        if self.acknowledged == Some(last) || index == 0 {
            return;
        }
        let mut receiver = lock(self.ack_channel);
        if matches!(&*receiver, AckReceiver::Absent) {
            return;
        }
        receiver.send(last);
        self.acknowledged = Some(last);
        // The source may not have the latest ones: a kill or the end of the connection may come first.
        let transit_time = if matches!(&*receiver, AckReceiver::Unread) { Duration::ZERO } else { TRANSIT_TIME };
        self.in_transit.push_back((Instant::now(), index));
        while let Some((_, received)) = self.in_transit.front().filter(|(sent, _)| sent.elapsed() >= transit_time) {
            file.state.acknowledged = Some(*received);
            self.receiver.counters.acknowledged.store(*received, Ordering::Relaxed);
            self.in_transit.pop_front();
        }
    }

    /// Sends the last acknowledgement again to a source that repeats frames: the end of a connection may have taken it, and a source that
    /// keeps only so many frames would wait for it.
    fn acknowledge_again(&mut self) {
        let repeated = self.receiver.counters.repeated.load(Ordering::Relaxed);
        if std::mem::replace(&mut self.repeated, repeated) == repeated {
            return;
        }
        if let Some(last) = self.acknowledged {
            lock(self.ack_channel).send(last);
        }
    }

    /// Returns the number of rows that the source has sent, with the dropped ones.
    fn arrived_rows(&self) -> u64 {
        let counters = &self.receiver.counters;
        counters.rows.load(Ordering::Acquire) + counters.dropped.load(Ordering::Acquire)
    }

    /// Raises an event when the source becomes silent, and when it sends samples again.
    fn check_silence(&mut self, arrived_rows: u64) -> Result<()> {
        // A recording is never silent. A source with rows in the ring may be blocked by the full ring.
        if arrived_rows != self.arrived_rows || self.receiver.has_row() || self.options.source.is_recording() {
            self.arrived_rows = arrived_rows;
            self.last_arrival = Instant::now();
        }
        let silence = self.last_arrival.elapsed();
        let is_silent = silence >= SILENCE_TIMEOUT;
        if self.first_time.is_none() || (!is_silent && !self.is_silent) {
            return Ok(());
        }
        if is_silent {
            self.source.longest_stall_s = self.source.longest_stall_s.max(silence.as_secs_f64());
        }
        let message = match (is_silent, self.is_silent) {
            (true, false) => {
                self.source.stalls += 1;
                EventMessage { kind: "source-silent", sentence: "The source sends no data.".to_owned() }
            }
            (false, true) => {
                EventMessage { kind: "source-speaks", sentence: "The source sends data again.".to_owned() }
            }
            _ => return Ok(()),
        };
        self.is_silent = is_silent;
        let message = self.receiver.limited(message);
        message.map_or(Ok(()), |message| self.record_event(&EventRecord::new(message, self.time)))
    }

    /// Raises events about queued and dropped samples of a source that is faster than the monitor. A recording has no backlog.
    fn report_backlog(&mut self) -> Result<()> {
        if self.first_time.is_none() || self.options.source.is_recording() {
            return Ok(());
        }
        let waiting = self.replay.waiting() * self.average as usize;
        for message in self.backlog.poll(&self.receiver, waiting, self.rate) {
            self.record_event(&EventRecord::new(message, self.time))?;
        }
        Ok(())
    }

    /// Acknowledges the alarms that users of the live page have acknowledged.
    fn acknowledge_alarms(&mut self) -> Result<()> {
        while let Some(id) = self.page.as_ref().and_then(page::Page::next_acknowledgement) {
            if let Some(sentence) = self.display.view.alarms.acknowledge(&id) {
                self.record_event(&EventRecord::acknowledgement(id, &sentence, self.time))?;
            }
        }
        Ok(())
    }

    /// Updates the data of the live displays if they are due.
    fn update_view(&mut self) {
        let (is_display_due, is_line_due) = (self.display.is_due(), self.lines.is_due());
        if !is_display_due && !is_line_due {
            return;
        }
        copy_counters(&self.receiver.counters, &mut self.source);
        let pacing = self.schedule.statistics(String::new());
        if is_display_due && self.display.take_is_read() {
            self.display.view.snapshot = std::sync::Arc::new(self.replay.snapshot());
        }
        let view = &mut self.display.view;
        view.set_state(match (self.first_time, self.is_silent, self.replay.has_started()) {
            (None, ..) => MonitorState::Waiting,
            (_, true, _) => MonitorState::Silent,
            (_, _, false) => MonitorState::Starting,
            _ => MonitorState::Running,
        });
        view.time_s = self.time;
        (view.diagnoses, view.diagnosis) = (self.replay.diagnoses(), self.replay.diagnosis_state());
        view.limits = self.replay.limit_status();
        (view.lateness, view.compute, view.starting_s) = (pacing.lateness, pacing.compute, pacing.starting_s);
        (view.misses, view.idle_percent) = (pacing.deadline_misses, pacing.idle_percent);
        view.source = self.source.clone();
        if is_line_due {
            self.lines.write(&Status::of(view), view.time_s);
        }
        if is_display_due {
            self.display.publish();
        }
    }
}
