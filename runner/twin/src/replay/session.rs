//! A replay row by row, whoever brings the rows.

use super::limits::{Event, LimitState};
use super::notices::Notice;
use super::outcome::Outcome;
use super::recent::Snapshot;
use super::second::Second;
use super::startup::Startup;
use super::{Options, Run, angle_source};
use crate::error::{UsageError, usage_error};
use crate::recording::Row;
use crate::recording::flaws::FlawSummary;
use crate::recording::rotation::{RotationError, Tracker};
use crate::scene::{Recording, RotationSource, Scene};
use anyhow::{Result, bail};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Seconds for which a machine that is watched may keep its keyphasor's pulse back before it counts as standing still.
const WATCHED_WAIT: f64 = 10.0;
/// A replay under way: rows go in, the outcome comes at the end.
pub struct Replay<'a> {
    scene: &'a Scene,
    rotation: &'a RotationSource,
    tracker: Tracker,
    run: Run<'a>,
    pub(super) rows: u64,
    /// Of the times before the shaft stood still.
    flaws: Vec<FlawSummary>,
    ended: bool,
}

/// What came up since it was last asked for.
#[derive(Default)]
pub struct Update {
    /// Seconds that ended and that the twin has passed through.
    pub seconds: Vec<Second>,
    /// Seconds that ended while the twin was started, without its figures.
    pub preliminary: Vec<Second>,
    /// Limits crossed (without an end) and crossings that ended.
    pub events: Vec<Event>,
    /// Rejected readings, restarts and what else a monitor reports at once.
    pub notices: Vec<Notice>,
}

impl<'a> Replay<'a> {
    /// For samples that come in at `rate`, Hz.
    ///
    /// # Errors
    /// A scene without rotor or recording, probes that do not determine the motion.
    pub fn try_new(scene: &'a Scene, rate: f64, options: &Options) -> Result<Self> {
        let Some(recording) = &scene.recording else { bail!(UsageError("found no [recording]".to_owned())) };
        let tracker = tracker(scene, recording, rate, options.watched);
        let rate = rate / f64::from(recording.average);
        let run = Run::try_new(scene, &recording.probes, rate, options).map_err(|e| usage_error(&e))?;
        Ok(Self { scene, rotation: &recording.rotation, tracker, run, rows: 0, flaws: vec![], ended: false })
    }

    /// A row to read into.
    #[must_use]
    pub fn blank(&mut self) -> Row {
        self.tracker.blank()
    }

    /// Takes in the next row: evaluates limits and indicators of readings and queues the samples for the twin.
    ///
    /// Where the shaft stands still, its samples are set aside; angle, twin and observer start anew with the next revolutions.
    ///
    /// # Errors
    /// A search that cannot be started.
    pub fn push(&mut self, row: Row) -> Result<()> {
        self.rows += 1;
        let time = row.time;
        let pushed = self.tracker.push(row);
        self.drain()?;
        if let Err(error) = pushed {
            let sentence = || format!("{error}; the twin waits until it turns.");
            self.run.notices.add("shaft-not-turning", time, sentence);
            self.set_aside(error);
            self.begin_anew();
        }
        Ok(())
    }

    /// Sets the samples aside that wait for a shaft angle.
    fn set_aside(&mut self, reason: RotationError) {
        while let Some(mut row) = self.tracker.abandon() {
            self.run.set_aside(&mut row);
            self.tracker.recycle(row);
        }
        self.run.standstill.explain(reason);
    }

    fn drain(&mut self) -> Result<()> {
        while let Some(sample) = self.tracker.pop() {
            self.run.take(sample)?;
        }
        Ok(())
    }

    /// Passes samples to the twin until `deadline`, or all that wait; without a deadline it waits for the twin's start.
    ///
    /// # Errors
    /// A machine that cannot be started, an output that cannot be written.
    pub fn work(&mut self, deadline: Option<Instant>) -> Result<()> {
        let tracker = &mut self.tracker;
        self.run.work(deadline, |row| tracker.recycle(row))
    }

    /// The twin has started.
    #[must_use]
    pub fn has_started(&self) -> bool {
        matches!(self.run.startup, Startup::Done) && self.run.has_begun()
    }

    /// The start of the twin is searched for, or it is run in.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        self.run.is_starting()
    }

    /// No sample waits for the twin.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.run.is_idle()
    }

    /// Number of samples that wait for the twin.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.run.queue.len()
    }

    /// Ends the search for the observer and the run-in of the twin: it starts without an observer, at rest.
    pub fn cancel_search(&self) {
        self.run.cancelled.store(true, Ordering::Relaxed);
    }

    /// No row follows: the samples that wait for the shaft angle are evaluated and queued.
    ///
    /// # Errors
    /// A search that cannot be started.
    pub fn end(&mut self) -> Result<()> {
        if std::mem::replace(&mut self.ended, true) {
            return Ok(());
        }
        let finished = self.tracker.finish();
        self.drain()?;
        if let Err(error) = finished {
            self.set_aside(error);
        }
        self.run.end()
    }

    /// Angle, twin and observer start anew.
    fn begin_anew(&mut self) {
        if let Some(recording) = &self.scene.recording {
            let rate = self.run.rate * f64::from(recording.average);
            self.flaws.extend(self.tracker.flaws().summary());
            self.tracker = tracker(self.scene, recording, rate, self.run.watched);
        }
        self.run.restart();
    }

    /// What there is to see now; nothing unless someone looks on.
    #[must_use]
    pub fn glance(&self) -> Snapshot {
        self.run.glance().unwrap_or_default()
    }

    /// What came up since the last call.
    pub fn news(&mut self) -> Update {
        Update {
            seconds: std::mem::take(&mut self.run.ended_seconds),
            preliminary: self.run.readings.ended(),
            events: self.run.guards.news(),
            notices: self.run.notices.take(),
        }
    }

    /// Goes on with limits in a state of an earlier process.
    pub fn restore_limits(&mut self, state: &LimitState) {
        self.run.guards.restore(state);
    }

    /// The limits' state after the events that [`Replay::news`] gave.
    #[must_use]
    pub fn limit_state(&self) -> Option<LimitState> {
        self.run.guards.state()
    }

    /// The end of the recording, its flaws as the reader found them.
    ///
    /// # Errors
    /// Nothing to compare, an output that cannot be written.
    pub fn finish(mut self, name: &str, mut flaws: Vec<FlawSummary>) -> Result<Outcome> {
        self.end()?;
        self.work(None)?;
        flaws.append(&mut self.flaws);
        flaws.extend(self.tracker.flaws().summary());
        let angle_source = angle_source(self.rotation, &self.tracker);
        self.run.finish(self.scene, name, self.rows, angle_source, flaws)
    }
}

/// Of a machine that is watched, memory is bounded while it stands still.
fn tracker(scene: &Scene, recording: &Recording, rate: f64, watched: bool) -> Tracker {
    let tracker = Tracker::of(recording, rate, scene.shaft.speed);
    if watched { tracker.waiting_at_most((WATCHED_WAIT * rate) as usize) } else { tracker }
}
