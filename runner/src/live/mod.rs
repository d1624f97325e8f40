//! The monitor: samples from a source, in real time, through kernel and twin.
//!
//! A thread reads the source into a ring buffer; the loop wakes at absolute times, processes the samples that are due, and
//! passes indicators and events to the outputs.
//!
//! With a state, the order of writing makes every second and every limit event appear once, whenever the process is killed:
//! first the indicators, then the state with the positions of indicators and limits and with the new event lines, then
//! these lines in the event log, and then the acknowledgement. A restart appends the lines of the state that the log does not
//! have, and ignores samples before either position.

pub mod address;
mod backlog;
mod connections;
mod datagrams;
pub mod feed;
pub mod frames;
mod lock;
pub mod out;
pub mod pace;
pub mod realtime;
pub mod source;
pub mod state;
pub mod view;

use crate::error::UsageError;
use address::Address;
use anyhow::{Result, bail};
use backlog::Backlog;
use ballrace_twin::recording::Row;
use ballrace_twin::recording::flaws::FlawSummary;
use ballrace_twin::replay::outcome::{Outcome, SourceFigures};
use ballrace_twin::replay::{self, Replay};
use ballrace_twin::scene::{Recording, Scene};
use feed::{CAPACITY, Counts, Item, Receiver};
use out::{EventRecord, Network, Outputs};
use pace::{BLOCK, Pace};
use source::{Encoding, Reading, Resume, lock};
use state::{State, StateFile};
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use view::Shared;

/// A source from which nothing came for so long is silent.
const SILENT: Duration = Duration::from_secs(1);
/// Between two pictures for those who look on.
const GLANCE: Duration = Duration::from_millis(200);
/// How long the end waits for a reader.
const FAREWELL: Duration = Duration::from_millis(500);
/// Longest time for which the twin works at once.
const SLICE: Duration = Duration::from_millis(50);

/// Options of a monitor.
pub struct Options<'a> {
    /// Where samples come from.
    pub source: Address,
    /// Their form on a stream.
    pub encoding: Encoding,
    /// Seconds of the recording after which it ends; as long as the source where absent.
    pub duration: Option<f64>,
    /// Where its state is kept.
    pub state: Option<&'a Path>,
    /// Outputs.
    pub outputs: &'a out::RequestedOutputs,
    /// Ask for real-time scheduling and locked memory.
    pub realtime: bool,
    /// Ask for this processor only.
    pub core: Option<usize>,
    /// Who looks on.
    pub view: Option<Shared>,
    /// Options of the replay.
    pub replay: replay::Options<'a>,
}

/// Runs until the source, the duration or `stop` ends it.
///
/// # Errors
/// A scene without probes, a source that cannot be opened or understood, an output that cannot be written.
pub fn monitor(scene: &Scene, options: &Options, stop: &AtomicBool) -> Result<Outcome> {
    let recording = probed(scene)?;
    // The state is locked and every port bound before a file is touched: a start that fails changes nothing.
    let mut state = options.state.map(|folder| StateFile::open(folder, &scene.name)).transpose()?;
    let network = Network::bind(options.outputs)?;
    let can_repeat = options.encoding != Encoding::Csv || options.source.is_recording();
    let before = state.as_ref().map_or_else(State::default, |file| file.state.clone());
    let (resume, done, goes_on) = (before.resume(can_repeat), before.time_s, before.starts > 0);
    let (sender, mut receiver) = feed::feed(CAPACITY);
    if state.is_some() {
        receiver.counts.acknowledged.store(resume.index, Ordering::Relaxed);
    }
    let reading = source::start(&options.source, options.encoding, scene, recording, resume, sender)?;
    let mut outputs = Outputs::open(options.outputs, network, state.as_ref().map(|file| &file.state))?;
    state.as_mut().map_or(Ok(()), StateFile::begin)?;
    show(options, |view| view.state = "waiting for the source");
    let rate = first_rate(&reading, &mut receiver, stop, |note| {
        let told = EventRecord::note(note, done);
        show(options, |view| view.add_event(&told));
        outputs.event(&told)?;
        outputs.save_events();
        Ok(())
    });
    let Some(rate) = rate? else { bail!("{}: stopped before a sample came", options.source) };
    let scheduling = realtime::request(options.realtime, options.core);
    let mut replay = Replay::try_new(scene, rate, &options.replay)?;
    let average = u64::from(recording.average);
    if let Some(limits) = &before.limits {
        replay.restore_limits(&limits.clone().map_positions(|index| index.div_ceil(average)));
    }
    if goes_on {
        let sentence = format!("Started again, at sample {} ({:.3} s).", resume.index, done);
        outputs.event(&EventRecord::note(feed::Note { kind: "monitor-resumed", sentence }, done))?;
    }
    let mut monitor = Monitor {
        options,
        replay,
        receiver,
        outputs,
        state: state.as_mut(),
        back: &reading.back,
        rate,
        average,
        seconds: (before.seconds_index, done),
        acknowledged: None,
        first: None,
        time: done,
        heard_at: Instant::now(),
        heard: 0,
        shown: f64::NEG_INFINITY,
        silent: false,
        backlog: Backlog::new(matches!(options.source, Address::Udp(_))),
        source: SourceFigures { ring_capacity: CAPACITY as u64, ..SourceFigures::default() },
        pace: Pace::begin()?,
        glanced: Instant::now(),
    };
    let end = monitor.run(stop);
    // Also after an error, what was found until then is written.
    monitor.save_the_rest();
    end?;
    let Monitor { replay, receiver, outputs, pace, mut source, .. } = monitor;
    let counts = receiver.counts.clone();
    let left_out = receiver.left_out();
    drop(receiver);
    let not_written = outputs.finish();
    let flaws = flaws(reading.end)?;
    let told = flaws.is_some();
    let mut outcome = replay.finish(&options.source.to_string(), flaws.unwrap_or_default())?;
    if !told {
        outcome
            .notes
            .push("The reader still waited for its source: what it found wrong with it is not listed.".to_owned());
    }
    outcome.notes.extend(left_out);
    read_counts(&counts, &mut source);
    outcome.timing.paced = true;
    outcome.timing.pacing = Some(pace.finish(scheduling));
    outcome.timing.source = Some(source);
    outcome.timing.outputs = Some(not_written);
    Ok(outcome)
}

fn probed(scene: &Scene) -> Result<&Recording> {
    let lacking = |found: &str| {
        let told =
            format!("{}: [recording]: found {found}, allowed: probes of the shaft's motion", scene.path.display());
        UsageError(told).into()
    };
    match &scene.recording {
        None => Err(lacking("none")),
        Some(recording) if !recording.sensors.is_empty() => Err(lacking("sensors, which are judged as a whole")),
        Some(recording) => Ok(recording),
    }
}

/// Returns the source's rate as soon as it is known, none where the monitor was stopped before; `tell` takes the events that
/// come before it.
fn first_rate(
    reading: &Reading,
    receiver: &mut Receiver,
    stop: &AtomicBool,
    mut tell: impl FnMut(feed::Note) -> Result<()>,
) -> Result<Option<f64>> {
    loop {
        while let Some(Item::Note(note)) = receiver.pop_if(|_| false) {
            tell(note)?;
        }
        while let Some(note) = receiver.note() {
            tell(note)?;
        }
        match reading.rate.recv_timeout(Duration::from_millis(50)) {
            Ok(rate) => return rate.map(Some),
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) if !stop.load(Ordering::Relaxed) => {}
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => return Ok(None),
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => bail!("the source ended before a sample came"),
        }
    }
}

/// Result of the reader; `None` while it waits for standard input.
fn flaws(end: std::thread::JoinHandle<Result<Vec<FlawSummary>>>) -> Result<Option<Vec<FlawSummary>>> {
    let since = Instant::now();
    while !end.is_finished() && since.elapsed() < FAREWELL {
        std::thread::sleep(BLOCK);
    }
    if !end.is_finished() {
        return Ok(None);
    }
    end.join().unwrap_or_else(|_| bail!("the reader of the source broke")).map(Some)
}

fn show(options: &Options, change: impl FnOnce(&mut view::View)) {
    if let Some(view) = &options.view {
        change(&mut lock(view));
    }
}

fn read_counts(counts: &Counts, figures: &mut SourceFigures) {
    let read = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
    figures.rows = read(&counts.rows);
    figures.lost_frames = read(&counts.lost);
    figures.repeated_frames = read(&counts.repeated);
    figures.malformed_frames = read(&counts.malformed);
    figures.dropped_rows = read(&counts.dropped);
    figures.ring_highest = read(&counts.highest);
    figures.connections = read(&counts.connections);
}

struct Monitor<'a, 'o> {
    options: &'a Options<'o>,
    replay: Replay<'a>,
    receiver: Receiver,
    outputs: Outputs,
    state: Option<&'a mut StateFile>,
    back: &'a source::AckChannel,
    /// Hz
    rate: f64,
    average: u64,
    /// The first sample after the last second that was handed to the outputs, and that second's end, s.
    seconds: (u64, f64),
    /// The sequence number that was acknowledged last.
    acknowledged: Option<u32>,
    /// Time of the first row, s.
    first: Option<f64>,
    /// Time of the last row, s.
    time: f64,
    heard_at: Instant,
    /// Rows that had come when the source was last looked at.
    heard: u64,
    /// End of the last second shown, s.
    shown: f64,
    silent: bool,
    backlog: Backlog,
    source: SourceFigures,
    pace: Pace,
    glanced: Instant,
}

impl Monitor<'_, '_> {
    fn run(&mut self, stop: &AtomicBool) -> Result<()> {
        while !stop.load(Ordering::Relaxed) && !self.receiver.is_over() && !self.is_long_enough() {
            let until = self.pace.wait();
            let begun = Instant::now();
            let caught_up = self.block(until)?;
            self.tell()?;
            self.listen()?;
            self.report_backlog()?;
            self.glance();
            self.pace.done(begun, caught_up);
        }
        self.receiver.stop();
        if stop.load(Ordering::Relaxed) && !self.options.source.is_recording() {
            self.take_rest()?;
        }
        self.replay.end()?;
        self.work_off(stop)
    }

    /// Takes what was read until the reader has ended, which may wait for standard input for ever.
    fn take_rest(&mut self) -> Result<()> {
        let since = Instant::now();
        while !self.receiver.is_over() && since.elapsed() < FAREWELL {
            match self.receiver.pop_if(|_| true) {
                Some(item) => self.item(item)?,
                None => std::thread::sleep(BLOCK),
            }
        }
        while let Some(item) = self.receiver.pop_if(|_| true) {
            self.item(item)?;
        }
        self.tell()
    }

    /// Passes the samples that still wait to the twin.
    fn work_off(&mut self, stop: &AtomicBool) -> Result<()> {
        loop {
            if stop.load(Ordering::Relaxed) {
                self.replay.cancel_search();
            }
            if self.replay.is_searching() {
                std::thread::sleep(BLOCK);
            }
            self.replay.work(Some(Instant::now() + SLICE))?;
            self.tell()?;
            self.glance();
            if self.replay.is_idle() {
                return Ok(());
            }
        }
    }

    fn is_long_enough(&self) -> bool {
        self.options.duration.zip(self.first).is_some_and(|(duration, first)| self.time - first >= duration)
    }

    /// Works off what is due; true where nothing that is due waits any more.
    fn block(&mut self, until: Duration) -> Result<bool> {
        let own_time = self.options.source.is_recording();
        let has_started = self.replay.has_started();
        let end = self.first.map_or(f64::INFINITY, |first| first + until.as_secs_f64());
        let due = |row: &Row| !own_time || !has_started || row.time < end;
        let mut worked = 0_u64;
        // No more at once than comes in while they are worked off several times over, so that others get their turn.
        let most = if self.first.is_none() { 1 } else { (self.rate * 0.25) as u64 + 1 };
        // A recording waits while its twin is started.
        while worked < most
            && !(own_time && self.replay.is_searching())
            && self.replay.waiting() < CAPACITY
            && let Some(item) = self.receiver.pop_if(due)
        {
            worked += 1;
            self.item(item)?;
        }
        while let Some(note) = self.receiver.note() {
            self.event(&EventRecord::note(note, self.time))?;
        }
        self.replay.work(Some(Instant::now() + SLICE))?;
        if own_time && !has_started && self.replay.has_started() {
            // Its time begins now.
            self.pace.restart();
            return Ok(false);
        }
        Ok(worked < most && self.replay.has_started() && self.replay.is_idle())
    }

    fn item(&mut self, item: Item) -> Result<()> {
        match item {
            Item::Row(row) => self.row(row),
            Item::Note(note) => self.event(&EventRecord::note(note, self.time)),
        }
    }

    fn row(&mut self, row: Row) -> Result<()> {
        if self.first.is_none() {
            self.first = Some(row.time);
            // A source's time begins with its first sample.
            self.pace = Pace::begin()?;
        }
        self.time = row.time;
        let spare = self.replay.blank();
        self.receiver.recycle(spare);
        Ok(self.replay.push(row)?)
    }

    fn event(&mut self, told: &EventRecord) -> Result<()> {
        show(self.options, |view| view.add_event(told));
        self.outputs.event(told)
    }

    /// Hands events and seconds to the outputs, and writes them.
    fn tell(&mut self) -> Result<()> {
        let news = self.replay.take_update();
        let is_new = !news.events.is_empty() || !news.seconds.is_empty();
        for event in news.events {
            self.event(&EventRecord::limit(event))?;
        }
        for notice in news.notices {
            let note = feed::Note { kind: notice.kind, sentence: notice.sentence };
            self.event(&EventRecord::note(note, notice.time_s))?;
        }
        for second in &news.seconds {
            let next_index = second.next_index * self.average;
            if next_index <= self.seconds.0 {
                // On disk since before a restart; the limits alone needed its samples again.
                continue;
            }
            self.seconds = (next_index, second.time_s);
            self.outputs.second(second, next_index)?;
        }
        // While the twin catches up, its seconds are behind those of the readings.
        for second in news.preliminary.iter().chain(&news.seconds) {
            show(self.options, |view| view.add_second(second));
            if second.time_s >= self.shown {
                self.shown = second.time_s;
                self.outputs.show(second, &self.receiver.counts, self.pace.misses());
            }
        }
        if is_new || self.outputs.is_retry_due() {
            self.save();
        } else {
            // Events of the source are in no state.
            self.outputs.save_events();
        }
        for note in self.outputs.take_notes() {
            self.event(&EventRecord::note(note, self.time))?;
        }
        Ok(())
    }

    /// Writes indicators, then the state with the events that wait, then these events, and only then acknowledges.
    fn save(&mut self) {
        let has_indicators = self.outputs.save_indicators();
        if let Some(StateFile { state, .. }) = self.state.as_deref_mut() {
            if has_indicators {
                (state.seconds_index, state.time_s) = self.seconds;
            }
            let average = self.average;
            state.limits = self.replay.limit_state().map(|limits| limits.map_positions(|index| index * average));
            let index = state.first_unprocessed();
            // The distance in samples is the distance in frames, whatever was lost between.
            let sequence = self.receiver.sequence_at(index).or(state.resume.sequence);
            state.resume = Resume { index, sequence };
        }
        let has_state = self.outputs.save_state(self.state.as_deref_mut());
        let has_events = self.outputs.save_events();
        if has_indicators && has_state && has_events {
            self.acknowledge();
        }
    }

    /// Writes what waits for the last time.
    fn save_the_rest(&mut self) {
        self.outputs.retry_now();
        if let Some(note) = self.backlog.dropped(&self.receiver) {
            let _ = self.event(&EventRecord::note(note, self.time));
        }
        // The limits' state is that after these events.
        let _ = self.tell();
        self.save();
        for note in self.outputs.take_notes() {
            let _ = self.event(&EventRecord::note(note, self.time));
        }
        self.outputs.save_events();
        // Without the events that are in the log now.
        self.outputs.save_state(self.state.as_deref_mut());
    }

    /// Tells the source which frames it need not keep.
    fn acknowledge(&mut self) {
        let Some(file) = &self.state else { return };
        let Some(last) = file.state.resume.sequence.map(|sequence| sequence.wrapping_sub(1)) else { return };
        if self.acknowledged == Some(last) || file.state.resume.index == 0 {
            return;
        }
        self.receiver.counts.acknowledged.store(file.state.resume.index, Ordering::Relaxed);
        if let Some(stream) = lock(self.back).as_mut() {
            self.acknowledged = Some(last);
            // Who does not listen to acknowledgements may leave them.
            let _ = writeln!(stream, "acknowledged {last}");
        }
    }

    /// Notices a source that has fallen silent, and one that speaks again.
    fn listen(&mut self) -> Result<()> {
        let counts = &self.receiver.counts;
        let heard = counts.rows.load(Ordering::Relaxed) + counts.dropped.load(Ordering::Relaxed);
        // A recording is never silent; a source is not while what it sent waits.
        if heard != self.heard || self.receiver.has_row() || self.options.source.is_recording() {
            self.heard = heard;
            self.heard_at = Instant::now();
        }
        let quiet = self.heard_at.elapsed();
        if self.first.is_none() || (quiet < SILENT && !self.silent) {
            return Ok(());
        }
        if quiet >= SILENT {
            self.source.longest_stall_s = self.source.longest_stall_s.max(quiet.as_secs_f64());
        }
        let note = match (quiet >= SILENT, self.silent) {
            (true, false) => {
                self.source.stalls += 1;
                feed::Note { kind: "source-silent", sentence: "The source sends no data.".to_owned() }
            }
            (false, true) => {
                feed::Note { kind: "source-speaks", sentence: "Samples come from the source again.".to_owned() }
            }
            _ => return Ok(()),
        };
        self.silent = quiet >= SILENT;
        let note = self.receiver.limited(note);
        note.map_or(Ok(()), |note| self.event(&EventRecord::note(note, self.time)))
    }

    /// Reports samples that wait or were dropped because the monitor is slower than its source. A recording waits unnoticed.
    fn report_backlog(&mut self) -> Result<()> {
        if self.first.is_none() || self.options.source.is_recording() {
            return Ok(());
        }
        let waiting = self.replay.waiting() * self.average as usize;
        for note in self.backlog.poll(&self.receiver, waiting, self.rate) {
            self.event(&EventRecord::note(note, self.time))?;
        }
        Ok(())
    }

    fn glance(&mut self) {
        if self.options.view.is_none() || self.glanced.elapsed() < GLANCE {
            return;
        }
        self.glanced = Instant::now();
        read_counts(&self.receiver.counts, &mut self.source);
        let state = match (self.first, self.silent, self.replay.has_started()) {
            (None, ..) => "waiting for the source",
            (_, true, _) => "source silent",
            (_, _, false) => "starting",
            _ => "running",
        };
        let glance = self.replay.snapshot();
        let pacing = self.pace.finish(String::new());
        show(self.options, |view| {
            view.state = state;
            view.glance = glance;
            (view.lateness, view.compute) = (pacing.lateness, pacing.compute);
            (view.misses, view.idle_percent) = (pacing.deadline_misses, pacing.idle_percent);
            view.source = self.source.clone();
        });
    }
}
