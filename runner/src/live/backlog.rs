//! Events of a monitor that is slower than its source: full buffer, end of the backlog, dropped samples.

use super::feed::FeedReceiver;
use ballrace_twin::record::EventMessage;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Fill level of the ring below which a backlog has ended.
const ENDED_BELOW: f64 = 0.5;
/// Minimum interval of the events that report dropped samples.
const INTERVAL: Duration = Duration::from_secs(1);

/// Monitor of the ring's fill level and of dropped samples.
pub struct Backlog {
    /// The source has no flow control: samples are dropped while the ring is full.
    drops_samples: bool,
    is_full: bool,
    /// Number of dropped samples reported so far.
    reported: u64,
    reported_at: Instant,
}

impl Backlog {
    /// Creates the state of an empty ring; `drops_samples` is `true` for a source without flow control.
    #[must_use]
    pub fn new(drops_samples: bool) -> Self {
        Self { drops_samples, is_full: false, reported: 0, reported_at: Instant::now() }
    }

    /// Returns the events since the last call. `waiting` is the number of samples queued for the twin, `rate` the sampling
    /// rate, Hz.
    pub fn poll(&mut self, receiver: &FeedReceiver, waiting: usize, rate: f64) -> Vec<EventMessage> {
        let has_dropped = receiver.counters.dropped.load(Ordering::Relaxed) > self.reported;
        let mut events = vec![];
        // A ring that was full between two calls may have free space again; dropped samples show it.
        if !self.is_full && (has_dropped || receiver.fill() >= 1.0) {
            self.is_full = true;
            let waiting = waiting + (receiver.fill() * super::CAPACITY as f64) as usize;
            let effect = if self.drops_samples { "further samples are dropped" } else { "the source is blocked" };
            let seconds = waiting as f64 / rate;
            let sentence = format!(
                "The monitor is slower than its source: {waiting} samples ({seconds:.1} s) are queued, and {effect}."
            );
            events.push(EventMessage { kind: "backlog-full", sentence });
        }
        if has_dropped && self.reported_at.elapsed() >= INTERVAL {
            events.extend(self.dropped(receiver));
        }
        if self.is_full && receiver.fill() < ENDED_BELOW {
            events.extend(self.dropped(receiver));
            self.is_full = false;
            events.push(EventMessage {
                kind: "backlog-ended",
                sentence: "The backlog has ended: the monitor keeps up with its source.".to_owned(),
            });
        }
        events.into_iter().filter_map(|event| receiver.limited(event)).collect()
    }

    /// Returns an event with the number of dropped samples that are not reported yet.
    pub fn dropped(&mut self, receiver: &FeedReceiver) -> Option<EventMessage> {
        let total = receiver.counters.dropped.load(Ordering::Relaxed);
        let new = total.checked_sub(self.reported).filter(|new| *new > 0)?;
        (self.reported, self.reported_at) = (total, Instant::now());
        let sentence = format!("{new} samples were dropped because the buffer was full, {total} since the start.");
        Some(EventMessage { kind: "samples-dropped", sentence })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::feed::{FeedItem, feed};
    use super::*;
    use ballrace_twin::recording::Row;

    fn kinds(events: &[EventMessage]) -> Vec<&'static str> {
        events.iter().map(|event| event.kind).collect()
    }

    #[test]
    fn a_backlog_raises_events_at_start_and_end_and_for_dropped_samples() {
        let (mut sender, mut receiver) = feed(16);
        let mut backlog = Backlog::new(true);
        (0..16).for_each(|_| sender.push_or_drop(Row::default()));
        assert_eq!(kinds(&backlog.poll(&receiver, 0, 1.0)), ["backlog-full"]);
        (0..20).for_each(|_| sender.push_or_drop(Row::default()));
        assert!(backlog.poll(&receiver, 0, 1.0).is_empty());
        (0..9).for_each(|_| assert!(matches!(receiver.pop_if(|_| true).unwrap(), FeedItem::Row(_))));
        let events = backlog.poll(&receiver, 0, 1.0);
        assert_eq!(kinds(&events), ["samples-dropped", "backlog-ended"]);
        assert!(events.first().unwrap().sentence.starts_with("20 samples"), "{events:?}");
        assert_eq!((backlog.poll(&receiver, 0, 1.0).len(), backlog.dropped(&receiver)), (0, None));
    }
}
