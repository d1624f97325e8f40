//! Time after which work is given up.

use std::time::{Duration, Instant};

/// A time limit that runs.
#[derive(Debug, Clone, Copy)]
pub struct TimeLimit {
    limit: Duration,
    /// `None` where no clock reaches it.
    end: Option<Instant>,
}

impl TimeLimit {
    /// Starts the time.
    #[must_use]
    pub fn start(limit: Duration) -> Self {
        Self { limit, end: Instant::now().checked_add(limit) }
    }

    /// Returns true after the end of the time.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() > end)
    }

    /// Returns the whole time, s.
    #[must_use]
    pub const fn seconds(&self) -> f64 {
        self.limit.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_ends_once() {
        assert!(!TimeLimit::start(Duration::MAX).is_over());
        let limit = TimeLimit::start(Duration::from_millis(1));
        std::thread::sleep(Duration::from_millis(2));
        assert!(limit.is_over() && limit.seconds() == 1e-3);
    }
}
