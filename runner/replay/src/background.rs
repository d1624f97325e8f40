//! Work of live operation on threads of its own: when it starts and when its result is taken.

use ballrace_base::priority;
use ballrace_outcome::options::BackgroundSchedule;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Largest share of one core that the work of one kind uses by the wall clock: a pause of four times its duration follows.
const SHARE: f64 = 0.2;

/// Work on a thread of its own.
pub(super) struct Task<T> {
    thread: JoinHandle<T>,
    started: Instant,
    /// Index of the sample at the start.
    sample: u64,
}

impl<T> Task<T> {
    /// Creates the task of `thread`, which started at the sample with this index.
    pub(super) fn new(thread: JoinHandle<T>, sample: u64) -> Self {
        Self { thread, started: Instant::now(), sample }
    }

    /// Returns whether the result is taken at the sample with this index.
    pub(super) fn is_due(&self, schedule: BackgroundSchedule, sample: u64) -> bool {
        match schedule {
            BackgroundSchedule::WallClock => self.thread.is_finished(),
            BackgroundSchedule::Samples(delay) => sample.saturating_sub(self.sample) >= delay,
        }
    }

    /// Waits for the result; returns it with the pause that follows.
    pub(super) fn join(self, schedule: BackgroundSchedule) -> (std::thread::Result<T>, Pause) {
        let result = self.thread.join();
        let pause = match schedule {
            BackgroundSchedule::WallClock => Pause::after(self.started.elapsed().mul_f64(1.0 / SHARE - 1.0)),
            BackgroundSchedule::Samples(_) => Pause::default(),
        };
        (result, pause)
    }
}

/// Lowers the priority of this thread where samples do not wait for its result.
pub(super) fn set_priority(schedule: BackgroundSchedule) {
    if schedule == BackgroundSchedule::WallClock {
        priority::lower();
    }
}

/// Pause between two tasks; none by default.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pause(Option<Instant>);

impl Pause {
    fn after(duration: Duration) -> Self {
        Self(Some(Instant::now() + duration))
    }

    /// Returns whether the next task may start.
    pub(super) fn is_over(self) -> bool {
        self.0.is_none_or(|end| Instant::now() >= end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_taken_after_a_number_of_samples() {
        let schedule = BackgroundSchedule::Samples(100);
        let quick = Task::new(std::thread::spawn(|| 3), 40);
        while !quick.thread.is_finished() {
            std::thread::yield_now();
        }
        assert!(!quick.is_due(schedule, 139) && quick.is_due(schedule, 140));
        assert!(quick.is_due(BackgroundSchedule::WallClock, 40));
        let (result, pause) = quick.join(schedule);
        assert!(result.is_ok_and(|result| result == 3) && pause.is_over());
        // A slow thread: the samples wait for it.
        let (release, wait) = std::sync::mpsc::channel::<()>();
        let slow = Task::new(std::thread::spawn(move || wait.recv().is_ok()), 0);
        assert!(slow.is_due(schedule, 100) && !slow.is_due(BackgroundSchedule::WallClock, 100));
        assert!(release.send(()).is_ok());
        assert!(slow.join(schedule).0.is_ok_and(|received| received));
    }
}
