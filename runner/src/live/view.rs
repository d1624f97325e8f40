//! Data of the live displays.

use super::alarms::AlarmList;
use super::feed::lock;
use ballrace_twin::record::{EventRecord, now};
use ballrace_twin::replay::limits::LimitStatus;
use ballrace_twin::replay::outcome::{Diagnosis, Pacing, SourceFigures};
use ballrace_twin::replay::second::Second;
use ballrace_twin::replay::{DiagnosisState, Snapshot};
use serde::Serialize;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, TryLockError};

/// Length of the trends, s.
pub const TREND_SECONDS: usize = 600;
/// Maximum number of displayed events.
const MAX_EVENTS: usize = 100;

/// State of a monitor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MonitorState {
    /// No sample has arrived yet.
    #[default]
    Waiting,
    /// The twin is starting.
    Starting,
    /// The twin follows the samples.
    Running,
    /// The source sends no data.
    Silent,
    /// The source has ended, or the monitor was stopped.
    Ended,
}

/// Data of the live displays. Cloning is cheap, because large data are shared.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// State of the monitor.
    pub state: MonitorState,
    /// Time of day since which it has this state, RFC 3339 in UTC.
    pub state_since: String,
    /// Time of the latest sample in the recording's time, s.
    pub time_s: f64,
    /// Latest samples and loads.
    pub snapshot: Arc<Snapshot>,
    /// Faults that the last diagnoses found.
    pub diagnoses: Vec<Diagnosis>,
    /// State of the diagnosis.
    pub diagnosis: DiagnosisState,
    /// Present values of limited indicators.
    pub limits: Vec<LimitStatus>,
    /// Alarms that are active or not acknowledged.
    pub alarms: AlarmList,
    /// Indicators of the last ten minutes, one entry per second.
    pub seconds: VecDeque<Arc<Second>>,
    /// Latest events, oldest first.
    pub events: VecDeque<Arc<EventRecord>>,
    /// Timeliness.
    pub pacing: Pacing,
    /// Counts of samples received and lost.
    pub source: SourceFigures,
    /// Verdict and diagnoses at the end of the run.
    pub conclusion: Option<Conclusion>,
}

/// Verdict and diagnoses of a run.
#[derive(Debug, Clone, Default)]
pub struct Conclusion {
    /// Verdict as a sentence.
    pub verdict: String,
    /// Diagnoses, strongest first.
    pub diagnoses: Vec<Diagnosis>,
}

/// Latest view, which the monitor loop replaces and displays read. The lock is held only while a pointer is exchanged, and the loop
/// does not block on it ([`SharedView::try_set`]).
#[derive(Debug, Clone, Default)]
pub struct SharedView(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    view: Mutex<Arc<View>>,
    /// A display has read the view since the monitor last replaced its snapshot.
    is_read: AtomicBool,
}

impl SharedView {
    /// Returns the latest view without a request for a new snapshot.
    #[must_use]
    pub fn peek(&self) -> Arc<View> {
        lock(&self.0.view).clone()
    }

    /// Returns the latest view, and requests a new snapshot.
    #[must_use]
    pub fn get(&self) -> Arc<View> {
        self.0.is_read.store(true, Ordering::Relaxed);
        lock(&self.0.view).clone()
    }

    /// Replaces the view unless a display is reading it at this moment; returns `true` on success.
    pub fn try_set(&self, view: &View) -> bool {
        match self.0.view.try_lock() {
            Ok(mut shared) => *shared = Arc::new(view.clone()),
            Err(TryLockError::Poisoned(poisoned)) => *poisoned.into_inner() = Arc::new(view.clone()),
            Err(TryLockError::WouldBlock) => return false,
        }
        true
    }

    /// Changes the view.
    pub fn update(&self, change: impl FnOnce(&mut View)) {
        change(Arc::make_mut(&mut lock(&self.0.view)));
    }

    /// Returns `true` if a display has read the view since the last call.
    #[must_use]
    pub fn take_is_read(&self) -> bool {
        self.0.is_read.swap(false, Ordering::Relaxed)
    }
}

impl View {
    /// Changes the state of the monitor.
    pub fn set_state(&mut self, state: MonitorState) {
        if self.state != state || self.state_since.is_empty() {
            (self.state, self.state_since) = (state, now());
        }
    }

    /// Adds the indicators of a second; replaces an entry of the same time.
    pub fn add_second(&mut self, second: &Second) {
        let second = Arc::new(second.clone());
        let mut later = self.seconds.iter_mut().rev().take_while(|other| other.time_s >= second.time_s);
        if let Some(entry) = later.find(|other| other.time_s == second.time_s) {
            *entry = second;
            return;
        }
        if self.seconds.len() == TREND_SECONDS {
            self.seconds.pop_front();
        }
        self.seconds.push_back(second);
    }

    /// Adds an event.
    pub fn add_event(&mut self, event: &EventRecord) {
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(Arc::new(event.clone()));
    }
}
