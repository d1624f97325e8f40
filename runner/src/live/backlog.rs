//! Events of a monitor that is slower than its source: a full ring, its end, and the samples dropped meanwhile.

use super::feed::{Note, Receiver};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Share of the ring below which a backlog has ended.
const ENDED: f64 = 0.5;
/// Interval of the events that report dropped samples.
const INTERVAL: Duration = Duration::from_secs(1);

/// Samples that wait, and those that were dropped because too many waited.
pub struct Backlog {
    /// The source cannot wait.
    drops: bool,
    is_full: bool,
    /// Dropped samples that an event has reported.
    reported: u64,
    reported_at: Instant,
}

impl Backlog {
    /// Creates the state of an empty ring; `drops` is true for a source that cannot wait.
    #[must_use]
    pub fn new(drops: bool) -> Self {
        Self { drops, is_full: false, reported: 0, reported_at: Instant::now() }
    }

    /// Returns the events since the last call. `waiting` samples wait for the twin, of a source at `rate`, Hz.
    pub fn poll(&mut self, receiver: &Receiver, waiting: usize, rate: f64) -> Vec<Note> {
        let has_dropped = receiver.counts.dropped.load(Ordering::Relaxed) > self.reported;
        let mut notes = vec![];
        // Between two looks a ring without room may have got some.
        if !self.is_full && (has_dropped || receiver.fill() >= 1.0) {
            self.is_full = true;
            let waiting = waiting + (receiver.fill() * super::CAPACITY as f64) as usize;
            let effect = if self.drops { "further samples are dropped" } else { "the source has to wait" };
            let seconds = waiting as f64 / rate;
            let sentence = format!(
                "The monitor is slower than its source: {waiting} samples ({seconds:.1} s) wait, and {effect}."
            );
            notes.push(Note { kind: "backlog-full", sentence });
        }
        if has_dropped && self.reported_at.elapsed() >= INTERVAL {
            notes.extend(self.dropped(receiver));
        }
        if self.is_full && receiver.fill() < ENDED {
            notes.extend(self.dropped(receiver));
            self.is_full = false;
            notes.push(Note {
                kind: "backlog-ended",
                sentence: "The monitor keeps up with its source again.".to_owned(),
            });
        }
        notes.into_iter().filter_map(|note| receiver.limited(note)).collect()
    }

    /// Returns the event of the samples that no event has reported.
    pub fn dropped(&mut self, receiver: &Receiver) -> Option<Note> {
        let all = receiver.counts.dropped.load(Ordering::Relaxed);
        let new = all.checked_sub(self.reported).filter(|new| *new > 0)?;
        (self.reported, self.reported_at) = (all, Instant::now());
        let sentence = format!("{new} samples found no room and were dropped, {all} since the start.");
        Some(Note { kind: "samples-dropped", sentence })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::feed::{Item, feed};
    use super::*;
    use ballrace_twin::recording::Row;

    fn kinds(notes: &[Note]) -> Vec<&'static str> {
        notes.iter().map(|note| note.kind).collect()
    }

    #[test]
    fn a_backlog_has_a_beginning_a_count_and_an_end() {
        let (mut sender, mut receiver) = feed(16);
        let mut backlog = Backlog::new(true);
        (0..16).for_each(|_| sender.push_or_drop(Row::default()));
        assert_eq!(kinds(&backlog.poll(&receiver, 0, 1.0)), ["backlog-full"]);
        (0..20).for_each(|_| sender.push_or_drop(Row::default()));
        assert!(backlog.poll(&receiver, 0, 1.0).is_empty());
        (0..9).for_each(|_| assert!(matches!(receiver.pop_if(|_| true).unwrap(), Item::Row(_))));
        let notes = backlog.poll(&receiver, 0, 1.0);
        assert_eq!(kinds(&notes), ["samples-dropped", "backlog-ended"]);
        assert!(notes.first().unwrap().sentence.starts_with("20 samples"), "{notes:?}");
        assert_eq!((backlog.poll(&receiver, 0, 1.0).len(), backlog.dropped(&receiver)), (0, None));
    }
}
