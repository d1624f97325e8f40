//! Progress on standard error where it is no terminal: a line now and then, so that a long computation in a pipe is seen to go on.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time without a line after which the next progress is printed.
const INTERVAL: Duration = Duration::from_secs(5);

/// Lines of progress; none on a terminal, which has a progress bar.
#[derive(Debug)]
pub(super) struct ProgressLines {
    last: Mutex<Instant>,
    is_terminal: bool,
}

impl ProgressLines {
    /// Creates lines of which the first is printed after [`INTERVAL`].
    pub(super) fn new() -> Self {
        Self { last: Mutex::new(Instant::now()), is_terminal: std::io::stderr().is_terminal() }
    }

    /// Prints `text` if [`INTERVAL`] has passed since the last line.
    pub(super) fn now_and_then(&self, text: impl FnOnce() -> String) {
        let last = *self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= INTERVAL {
            self.print(text);
        }
    }

    /// Prints `text`.
    pub(super) fn print(&self, text: impl FnOnce() -> String) {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        if !self.is_terminal {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "{}", text());
        }
    }
}
