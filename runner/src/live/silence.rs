//! Silence of a source.

use super::feed::FeedReceiver;
use ballrace_twin::record::EventMessage;
use ballrace_twin::replay::outcome::SourceFigures;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time without samples after which a source is silent.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);

/// Returns the number of rows that the source has sent, with the dropped ones.
pub(super) fn arrived_rows(receiver: &FeedReceiver) -> u64 {
    let counters = &receiver.counters;
    counters.rows.load(Ordering::Acquire) + counters.dropped.load(Ordering::Acquire)
}

/// Silence of a source: no rows for [`SILENCE_TIMEOUT`].
pub(super) struct Silence {
    /// Time at which new rows were last seen.
    last_arrival: Instant,
    /// Number of rows that had arrived at that time.
    arrived_rows: u64,
    is_silent: bool,
}

impl Silence {
    /// Creates the state of a source that has just sent rows.
    pub(super) fn new() -> Self {
        Self { last_arrival: Instant::now(), arrived_rows: 0, is_silent: false }
    }

    /// Returns true while the source is silent.
    pub(super) const fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Notes the rows that have arrived. `is_blocked` states that the source cannot send more, or is a recording, which is never silent.
    pub(super) fn update(&mut self, arrived_rows: u64, is_blocked: bool) {
        if arrived_rows != self.arrived_rows || is_blocked {
            self.arrived_rows = arrived_rows;
            self.last_arrival = Instant::now();
        }
    }

    /// Returns an event when the source becomes silent, and when it sends samples again; counts both in `figures`.
    pub(super) fn change(&mut self, figures: &mut SourceFigures) -> Option<EventMessage> {
        let silence = self.last_arrival.elapsed();
        let is_silent = silence >= SILENCE_TIMEOUT;
        if is_silent {
            figures.longest_stall_s = figures.longest_stall_s.max(silence.as_secs_f64());
        }
        if std::mem::replace(&mut self.is_silent, is_silent) == is_silent {
            return None;
        }
        Some(if is_silent {
            figures.stalls += 1;
            EventMessage { kind: "source-silent", sentence: "The source sends no data.".to_owned() }
        } else {
            EventMessage { kind: "source-speaks", sentence: "The source sends data again.".to_owned() }
        })
    }
}
