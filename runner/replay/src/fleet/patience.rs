//! Work with a limit of its time without progress.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Interval between two checks of an evaluation's progress.
const POLL: Duration = Duration::from_millis(200);

/// Runs `work` on a thread of its own and returns its result. Work that makes no progress, which it counts, for `patience` is
/// abandoned: a read of a disk or network that does not answer cannot be ended.
pub(super) fn within<T: Send + 'static>(
    patience: Duration,
    work: impl FnOnce(&AtomicU64) -> T + Send + 'static,
) -> std::io::Result<Option<T>> {
    let steps = Arc::new(AtomicU64::new(0));
    let (sender, receiver) = channel();
    let counter = steps.clone();
    // The receiver is gone where the work was abandoned.
    let work = move || drop(sender.send(work(&counter)));
    std::thread::Builder::new().name("machine".to_owned()).spawn(work)?;
    let (mut seen, mut since) = (0, Instant::now());
    loop {
        let left = patience.saturating_sub(since.elapsed());
        match receiver.recv_timeout(left.min(POLL)) {
            Ok(result) => return Ok(Some(result)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let count = steps.load(Ordering::Relaxed);
        if count != seen {
            (seen, since) = (count, Instant::now());
        } else if since.elapsed() >= patience {
            return Ok(None);
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn work_without_progress_is_abandoned() {
        let patience = Duration::from_millis(300);
        assert_eq!(within(patience, |_| 3).unwrap(), Some(3));
        let since = Instant::now();
        let stuck = |_: &AtomicU64| std::thread::sleep(Duration::from_secs(3600));
        assert_eq!(within(patience, stuck).unwrap(), None);
        assert!(since.elapsed() < Duration::from_secs(30));
        // Slow work with progress is not.
        let slow = |steps: &AtomicU64| {
            for _ in 0..10 {
                std::thread::sleep(Duration::from_millis(100));
                steps.fetch_add(1, Ordering::Relaxed);
            }
        };
        assert_eq!(within(Duration::from_secs(1), slow).unwrap(), Some(()));
    }
}
