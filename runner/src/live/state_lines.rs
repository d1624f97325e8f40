//! State of a monitor without a display as lines on standard error: one where its word changes, and now and then one while no verdict is
//! possible yet, so that the wait for the first diagnosis is seen to go on.

use super::status::{Level, Status};
use ballrace_twin::printable;
use std::io::Write;
use std::time::{Duration, Instant};

/// Time between two tests of the state, and from the start to the first.
const INTERVAL: Duration = Duration::from_secs(5);

/// Lines of the state.
pub struct StateLines {
    /// Time of the last test; `None` where a display shows the state.
    tested: Option<Instant>,
    /// Word of the last line, and the tests until the next line with the same one.
    word: &'static str,
    rest: u32,
    /// Tests from the last line to the next one with the same word.
    pause: u32,
}

impl StateLines {
    /// Creates the lines; none where a display shows the state.
    #[must_use]
    pub fn new(has_display: bool) -> Self {
        Self { tested: (!has_display).then(Instant::now), word: "", rest: 0, pause: 1 }
    }

    /// Returns true where the state is tested now.
    pub fn is_due(&self) -> bool {
        self.tested.is_some_and(|tested| tested.elapsed() >= INTERVAL)
    }

    /// Writes the line of a state at a time of the recording, s, if one is due.
    pub fn write(&mut self, status: &Status, time_s: f64) {
        self.tested = self.tested.map(|_| Instant::now());
        if let Some(line) = self.line(status, time_s) {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "{}", printable::lines(&line));
        }
    }

    /// Returns the line of a state: one with another word, or without a verdict after 1, 2, 4, ... tests.
    fn line(&mut self, status: &Status, time_s: f64) -> Option<String> {
        let is_new = status.word != self.word;
        if is_new {
            (self.word, self.rest, self.pause) = (status.word, 0, 1);
        } else if status.level != Level::Unknown || self.rest > 0 {
            self.rest = self.rest.saturating_sub(1);
            return None;
        } else {
            self.pause = self.pause.saturating_mul(2);
        }
        self.rest = self.pause - 1;
        let sentence = if status.title.is_empty() { status.sentence.clone() } else { format!("{}.", status.title) };
        let line = format!("State at {time_s:.1} s: {}. {sentence} {}", status.word, status.action);
        Some(line.trim_end().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_is_reported_less_and_less_often_and_a_change_at_once() {
        let status = |word, level| Status {
            word,
            level,
            title: String::new(),
            sentence: "A sentence.".to_owned(),
            action: String::new(),
            since: String::new(),
        };
        let mut lines = StateLines::new(false);
        let mut tests = |word, level, count: usize| -> Vec<usize> {
            (0..count).filter(|_| lines.line(&status(word, level), 0.0).is_some()).collect()
        };
        assert_eq!(tests("NO VERDICT YET", Level::Unknown, 32), [0, 1, 3, 7, 15, 31]);
        assert_eq!(tests("NORMAL", Level::Normal, 40), [0]);
        assert_eq!(tests("ALARM", Level::Alarm, 40), [0]);
        assert_eq!(tests("NO VERDICT YET", Level::Unknown, 3), [0, 1]);
        let line = StateLines::new(false).line(&status("NORMAL", Level::Normal), 12.34);
        assert_eq!(line.as_deref(), Some("State at 12.3 s: NORMAL. A sentence."));
        assert!(!StateLines::new(true).is_due());
    }
}
