//! Data of the live display.

use super::out::EventRecord;
use ballrace_twin::replay::Snapshot;
use ballrace_twin::replay::outcome::{Finding, Quantiles, SourceFigures};
use ballrace_twin::replay::second::Second;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Length of the trends, s.
pub const TREND_SECONDS: usize = 600;
/// Maximum number of displayed events.
const MAX_EVENTS: usize = 100;

/// Data of the live display, updated several times per second.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// State of the monitor: waiting, starting, running, silent or ended.
    pub state: &'static str,
    /// Latest samples, loads and findings.
    pub snapshot: Snapshot,
    /// Indicators of the last ten minutes, one entry per second.
    pub seconds: VecDeque<Second>,
    /// Latest events, oldest first.
    pub events: VecDeque<EventRecord>,
    /// Delay of the wake-ups.
    pub lateness: Quantiles,
    /// Processing time of a block.
    pub compute: Quantiles,
    /// Missed deadlines.
    pub misses: u64,
    /// Idle time of one processor, percent; `None` if the system does not report it.
    pub idle_percent: Option<f64>,
    /// Counts of samples received and lost.
    pub source: SourceFigures,
    /// Verdict and findings at the end of the run.
    pub conclusion: Option<Conclusion>,
}

/// Verdict and findings of a run.
#[derive(Debug, Clone, Default)]
pub struct Conclusion {
    /// Verdict as a sentence.
    pub verdict: String,
    /// Findings, strongest first.
    pub findings: Vec<Finding>,
}

/// View shared by the monitor loop and the display.
pub type SharedView = Arc<Mutex<View>>;

impl View {
    /// Adds the indicators of a second; replaces an entry of the same time.
    pub fn add_second(&mut self, second: &Second) {
        if let Some(entry) = self.seconds.iter_mut().rev().find(|other| other.time_s == second.time_s) {
            entry.clone_from(second);
            return;
        }
        if self.seconds.len() == TREND_SECONDS {
            self.seconds.pop_front();
        }
        self.seconds.push_back(second.clone());
    }

    /// Adds an event.
    pub fn add_event(&mut self, event: &EventRecord) {
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
    }
}
