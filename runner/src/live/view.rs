//! Data of the live view.

use super::out::EventRecord;
use ballrace_twin::replay::Snapshot;
use ballrace_twin::replay::outcome::{Finding, Quantiles, SourceFigures};
use ballrace_twin::replay::second::Second;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Seconds of the trends.
pub const TREND: usize = 600;
/// Events that are kept for display.
const EVENTS: usize = 100;

/// The state of things, renewed a few times a second.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// In one word or two: waiting, starting, running, silent, over.
    pub state: &'static str,
    /// Orbits, last samples, loads.
    pub glance: Snapshot,
    /// The last ten minutes.
    pub seconds: VecDeque<Second>,
    /// The last events, oldest first.
    pub events: VecDeque<EventRecord>,
    /// How much later than due the program woke.
    pub lateness: Quantiles,
    /// All work of a block.
    pub compute: Quantiles,
    /// Blocks not done in time.
    pub misses: u64,
    /// Percentage of one processor that is idle, where the system reports it.
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

/// Between the loop and the screen.
pub type Shared = Arc<Mutex<View>>;

impl View {
    /// Adds a second, in place of the one of the same time where there is one.
    pub fn add_second(&mut self, second: &Second) {
        if let Some(same) = self.seconds.iter_mut().rev().find(|other| other.time_s == second.time_s) {
            same.clone_from(second);
            return;
        }
        if self.seconds.len() == TREND {
            self.seconds.pop_front();
        }
        self.seconds.push_back(second.clone());
    }

    /// An event more.
    pub fn add_event(&mut self, told: &EventRecord) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(told.clone());
    }
}
