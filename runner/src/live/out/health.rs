//! Outputs that fail for a while, such as on a full disk: attempts, and events at each change.

use super::super::feed::Note;
use anyhow::Result;
use std::time::{Duration, Instant};

/// Time between two attempts to write an output that fails.
const RETRY: Duration = Duration::from_secs(1);

/// Whether an output can be written.
pub struct Health {
    failing_since: Option<Instant>,
    next_attempt: Instant,
}

impl Default for Health {
    fn default() -> Self {
        Self { failing_since: None, next_attempt: Instant::now() }
    }
}

impl Health {
    /// True where the last attempt failed.
    #[must_use]
    pub const fn is_failing(&self) -> bool {
        self.failing_since.is_some()
    }

    /// True where the last attempt failed and the next one is due.
    #[must_use]
    pub fn is_retry_due(&self) -> bool {
        self.is_failing() && Instant::now() >= self.next_attempt
    }

    /// Makes the next attempt due now.
    pub fn retry_now(&mut self) {
        self.next_attempt = Instant::now();
    }

    /// Calls `write` unless an output that fails has its next attempt later; true where it succeeded. Adds an event to
    /// `notes` where the output begins to fail, and where it works again.
    pub fn attempt(&mut self, notes: &mut Vec<Note>, write: impl FnOnce() -> Result<()>) -> bool {
        if self.is_failing() && !self.is_retry_due() {
            return false;
        }
        match (write(), self.failing_since) {
            (Ok(()), None) => true,
            (Ok(()), Some(since)) => {
                self.failing_since = None;
                let seconds = since.elapsed().as_secs_f64();
                let sentence = format!("The output is written again, after {seconds:.0} s.");
                notes.push(Note { kind: "output-recovered", sentence });
                true
            }
            (Err(error), since) => {
                self.next_attempt = Instant::now() + RETRY;
                if since.is_none() {
                    self.failing_since = Some(Instant::now());
                    let sentence = format!("{error:#}; the monitor continues and tries again every second.");
                    notes.push(Note { kind: "output-failing", sentence });
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
    fn each_change_gives_one_event() {
        let (mut health, mut notes) = (Health::default(), vec![]);
        assert!(health.attempt(&mut notes, || Ok(())) && notes.is_empty());
        for _ in 0..3 {
            assert!(!health.attempt(&mut notes, || anyhow::bail!("a.jsonl: no space")));
        }
        assert!(health.is_failing() && !health.is_retry_due());
        health.retry_now();
        assert!(health.attempt(&mut notes, || Ok(())) && !health.is_failing());
        let kinds: Vec<&str> = notes.iter().map(|note| note.kind).collect();
        assert_eq!(kinds, ["output-failing", "output-recovered"]);
        assert!(notes.iter().any(|note| note.sentence.contains("a.jsonl: no space")));
    }
}
