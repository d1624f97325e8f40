//! Loop of a monitor: samples that are due, outputs and view.

use super::acknowledgement::Acknowledgement;
use super::backlog::Backlog;
use super::display::Display;
use super::feed::{CAPACITY, FeedItem, FeedReceiver, SourceCounters};
use super::out::Outputs;
use super::pace::{BLOCK_PERIOD, BlockSchedule};
use super::page::Page;
use super::service::Service;
use super::silence::{Silence, arrived_rows};
use super::source::Resume;
use super::state::StateFile;
use super::state_lines::StateLines;
use super::status::Status;
use super::view::MonitorState;
use super::{Options, Signals};
use anyhow::Result;
use ballrace_twin::record::{EventMessage, EventRecord};
use ballrace_twin::recording::Row;
use ballrace_twin::replay::Replay;
use ballrace_twin::replay::outcome::SourceFigures;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time limit for the end of the reader thread, which may be blocked by standard input.
pub(super) const READER_TIMEOUT: Duration = Duration::from_millis(500);
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

/// State of the monitor loop.
pub(super) struct Monitor<'a, 'o> {
    pub(super) options: &'a Options<'o>,
    pub(super) replay: Replay<'a>,
    pub(super) receiver: FeedReceiver,
    pub(super) outputs: Outputs,
    pub(super) state: Option<&'a mut StateFile>,
    pub(super) acknowledgement: Acknowledgement<'a>,
    /// Sampling rate of the source, Hz.
    pub(super) rate: f64,
    /// Number of samples of the source in one sample of the replay.
    pub(super) average: u64,
    /// First sample after the last second that was passed to the outputs.
    pub(super) seconds_index: u64,
    /// End of that second, s.
    pub(super) seconds_time: f64,
    /// Time of the first row, s.
    pub(super) first_time: Option<f64>,
    /// Time of the latest row, s.
    pub(super) time: f64,
    /// End of the last published second, s.
    pub(super) published_time: f64,
    pub(super) silence: Silence,
    pub(super) backlog: Backlog,
    pub(super) source: SourceFigures,
    pub(super) schedule: BlockSchedule,
    pub(super) display: Display,
    pub(super) lines: StateLines,
    pub(super) page: Option<Page>,
    /// The state has to be written.
    pub(super) is_state_changed: bool,
    pub(super) service: Service,
}

impl Monitor<'_, '_> {
    pub(super) fn run(&mut self, signals: &Signals) -> Result<()> {
        let stop = &signals.stop;
        while !stop.load(Ordering::Relaxed) && !self.receiver.is_finished() && !self.has_reached_duration() {
            let block_time = self.schedule.wait();
            self.service.keep_alive();
            let block_start = Instant::now();
            // Counted before the block, so that the events that precede a row in the ring are recorded before it ends a silence.
            let arrived_rows = arrived_rows(&self.receiver);
            let caught_up = self.process_block(block_time)?;
            self.publish()?;
            self.check_silence(arrived_rows)?;
            self.acknowledgement.send_again(&self.receiver.counters);
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
        if has_indicators
            && has_state
            && has_events
            && let Some(file) = self.state.as_deref_mut()
        {
            self.acknowledgement.send(&mut file.state, &self.receiver.counters);
        }
    }

    /// Writes everything that is pending at the end.
    pub(super) fn save_remaining(&mut self) {
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

    /// Raises an event when the source becomes silent, and when it sends samples again.
    fn check_silence(&mut self, arrived_rows: u64) -> Result<()> {
        // A recording is never silent. A source with rows in the ring may be blocked by the full ring.
        self.silence.update(arrived_rows, self.receiver.has_row() || self.options.source.is_recording());
        if self.first_time.is_none() {
            return Ok(());
        }
        let message = self.silence.change(&mut self.source).and_then(|message| self.receiver.limited(message));
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
        while let Some(id) = self.page.as_ref().and_then(Page::next_acknowledgement) {
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
        view.set_state(match (self.first_time, self.silence.is_silent(), self.replay.has_started()) {
            (None, ..) => MonitorState::Waiting,
            (_, true, _) => MonitorState::Silent,
            (_, _, false) => MonitorState::Starting,
            _ => MonitorState::Running,
        });
        view.time_s = self.time;
        (view.diagnoses, view.diagnosis) = (self.replay.diagnoses(), self.replay.diagnosis_state());
        view.limits = self.replay.limit_status();
        view.pacing = pacing;
        view.source = self.source.clone();
        if is_line_due {
            self.lines.write(&Status::of(view), view.time_s);
        }
        if is_display_due {
            self.display.publish();
        }
    }
}

pub(super) fn copy_counters(counters: &SourceCounters, figures: &mut SourceFigures) {
    let read = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
    figures.rows = read(&counters.rows);
    figures.lost_frames = read(&counters.lost);
    figures.repeated_frames = read(&counters.repeated);
    figures.malformed_frames = read(&counters.malformed);
    figures.dropped_rows = read(&counters.dropped);
    figures.ring_highest = read(&counters.ring_highest);
    figures.connections = read(&counters.connections);
}
