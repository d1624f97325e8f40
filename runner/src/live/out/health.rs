//! Retries of an output that fails temporarily, for example on a full disk, with an event at each change.

use anyhow::Result;
use ballrace_twin::record::EventMessage;
use std::time::{Duration, Instant};

/// Interval between two attempts to write a failing output.
const RETRY_INTERVAL: Duration = Duration::from_secs(1);

/// State of an output: working or failing.
pub struct OutputHealth {
    failing_since: Option<Instant>,
    next_attempt: Instant,
}

impl Default for OutputHealth {
    fn default() -> Self {
        Self { failing_since: None, next_attempt: Instant::now() }
    }
}

impl OutputHealth {
    /// Returns `true` if the last attempt failed.
    #[must_use]
    pub const fn is_failing(&self) -> bool {
        self.failing_since.is_some()
    }

    /// Returns `true` if the last attempt failed and the next attempt is due.
    #[must_use]
    pub fn is_retry_due(&self) -> bool {
        self.is_failing() && Instant::now() >= self.next_attempt
    }

    /// Makes the next attempt due immediately.
    pub fn retry_now(&mut self) {
        self.next_attempt = Instant::now();
    }

    /// Calls `write` unless the output is failing and its next attempt is not due; returns `true` on success. Adds an event
    /// when the output starts to fail and when it works again.
    pub fn attempt(&mut self, events: &mut Vec<EventMessage>, write: impl FnOnce() -> Result<()>) -> bool {
        if self.is_failing() && !self.is_retry_due() {
            return false;
        }
        match (write(), self.failing_since) {
            (Ok(()), None) => true,
            (Ok(()), Some(since)) => {
                self.failing_since = None;
                let seconds = since.elapsed().as_secs_f64();
                let sentence = format!("The output works again, after {seconds:.0} s.");
                events.push(EventMessage { kind: "output-recovered", sentence });
                true
            }
            (Err(error), since) => {
                self.next_attempt = Instant::now() + RETRY_INTERVAL;
                if since.is_none() {
                    self.failing_since = Some(Instant::now());
                    let sentence = format!("{error:#}; the monitor continues and retries every second.");
                    events.push(EventMessage { kind: "output-failing", sentence });
                }
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_change_raises_one_event() {
        let (mut health, mut events) = (OutputHealth::default(), vec![]);
        assert!(health.attempt(&mut events, || Ok(())) && events.is_empty());
        for _ in 0..3 {
            assert!(!health.attempt(&mut events, || anyhow::bail!("a.jsonl: no space")));
        }
        assert!(health.is_failing() && !health.is_retry_due());
        health.retry_now();
        assert!(health.attempt(&mut events, || Ok(())) && !health.is_failing());
        let kinds: Vec<&str> = events.iter().map(|event| event.kind).collect();
        assert_eq!(kinds, ["output-failing", "output-recovered"]);
        assert!(events.iter().any(|event| event.sentence.contains("a.jsonl: no space")));
    }
}
