//! Independent pieces of work on all processors.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread::Builder;

thread_local! {
    /// True while other threads have the other processors.
    static IS_ONE_OF_MANY: Cell<bool> = const { Cell::new(false) };
}

/// Does `work` on this thread alone: other work has the other processors.
pub fn on_this_thread<R>(work: impl FnOnce() -> R) -> R {
    /// Restores the state before, also after a panic.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            IS_ONE_OF_MANY.set(self.0);
        }
    }
    let _before = Before(IS_ONE_OF_MANY.replace(true));
    work()
}

/// Returns the number of processors for the work of this thread.
fn processors() -> usize {
    if IS_ONE_OF_MANY.get() { 1 } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// Returns `of` of each item, in their order, computed on all processors; on this thread alone within [`on_this_thread`] and within
/// another call of this function. A panic of `of` is one of this function.
pub fn map<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = processors().min(items.len());
    if threads <= 1 {
        return items.iter().map(of).collect();
    }
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(items.len()));
    let work = || {
        on_this_thread(|| {
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(item) = items.get(i) else { return };
                let result = of(item);
                results.lock().unwrap_or_else(PoisonError::into_inner).push((i, result));
            }
        });
    };
    std::thread::scope(|scope| {
        // A thread that cannot be started leaves its share to the others.
        let start = |_| Builder::new().name("parallel".to_owned()).spawn_scoped(scope, work).ok();
        let others: Vec<_> = (1..threads).filter_map(start).collect();
        work();
        for other in others {
            other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Items that [`chain`] hands over together, so that the threads seldom wait for each other.
const BATCH: usize = 64;
/// Batches that wait between the two steps of [`chain`].
const BATCHES_WAITING: usize = 2;

/// Passes the items that `first` returns, until it returns none, to `second`, in their order: on another thread where there is a processor
/// for it. `first` receives an item that `second` has had, where there is one, for its memory.
///
/// # Errors
/// The first error of either step, after which both end; a thread that cannot be started.
pub fn chain<T: Send, E: Send + From<std::io::Error>>(
    mut first: impl FnMut(Option<T>) -> Result<Option<T>, E>,
    mut second: impl FnMut(&mut T) -> Result<(), E> + Send,
) -> Result<(), E> {
    if processors() == 1 {
        let mut used = None;
        while let Some(mut item) = first(used.take())? {
            second(&mut item)?;
            used = Some(item);
        }
        return Ok(());
    }
    let (sender, batches) = mpsc::sync_channel::<Vec<T>>(BATCHES_WAITING);
    let (used_sender, used_batches) = mpsc::channel::<Vec<T>>();
    std::thread::scope(|scope| {
        let other = Builder::new().name("chain".to_owned()).spawn_scoped(scope, move || {
            for mut batch in batches {
                batch.iter_mut().try_for_each(&mut second)?;
                // The other thread may have ended.
                let _ = used_sender.send(batch);
            }
            Ok(())
        })?;
        let (mut used, mut batch, mut failed) = (Vec::new(), Vec::with_capacity(BATCH), Ok(()));
        loop {
            let next = first(used.pop());
            let is_last = !matches!(next, Ok(Some(_)));
            match next {
                Ok(item) => batch.extend(item),
                Err(error) => failed = Err(error),
            }
            if batch.len() == BATCH || is_last {
                // Fails where the other thread has failed.
                let sent = sender.send(std::mem::replace(&mut batch, Vec::with_capacity(BATCH)));
                if is_last || sent.is_err() {
                    break;
                }
                used.extend(used_batches.try_iter().flatten());
            }
        }
        drop(sender);
        other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)).and(failed)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::thread::ThreadId;

    fn threads_of(items: usize) -> HashSet<ThreadId> {
        let slow = |_: &usize| {
            std::thread::sleep(std::time::Duration::from_millis(2));
            std::thread::current().id()
        };
        map(&(0..items).collect::<Vec<_>>(), slow).into_iter().collect()
    }

    #[test]
    fn results_have_the_order_of_the_items() {
        let items: Vec<usize> = (0..100).collect();
        assert_eq!(map(&items, |i| i * i), items.iter().map(|i| i * i).collect::<Vec<_>>());
        assert!(map(&[] as &[usize], |i| *i).is_empty());
    }

    #[test]
    fn one_of_many_threads_works_alone() {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        assert_eq!(threads_of(50).len() > 1, processors > 1);
        let own = HashSet::from([std::thread::current().id()]);
        assert_eq!(on_this_thread(|| threads_of(50)), own);
        assert!(map(&[0, 1, 2], |_| threads_of(50).len()).iter().all(|count| *count == 1));
        assert_eq!(threads_of(50).len() > 1, processors > 1);
    }

    /// Passes the numbers up to `count` through a chain; returns those that the second step received, and the items that the first one
    /// received back. The steps fail at the numbers `failing`.
    fn numbers(count: usize, failing: [Option<usize>; 2]) -> (std::io::Result<()>, Vec<usize>, usize) {
        let (mut next, mut returned, mut received) = (0, 0, vec![]);
        let fails = |step: usize, i: usize| {
            if failing[step] == Some(i) { Err(std::io::Error::other(format!("step {step}"))) } else { Ok(()) }
        };
        let first = |used: Option<Box<usize>>| {
            returned += usize::from(used.is_some());
            fails(0, next)?;
            let mut item = used.unwrap_or_default();
            *item = next;
            next += 1;
            Ok((next <= count).then_some(item))
        };
        let second = |item: &mut Box<usize>| {
            fails(1, **item)?;
            received.push(**item);
            Ok(())
        };
        let ended = chain(first, second);
        (ended, received, returned)
    }

    #[test]
    fn a_chain_keeps_the_order_and_returns_the_items() {
        for count in [0, 1, BATCH - 1, BATCH, 20 * BATCH + 7] {
            let (on_two, alone) = (numbers(count, [None; 2]), on_this_thread(|| numbers(count, [None; 2])));
            for (ended, received, _) in [&on_two, &alone] {
                assert!(ended.is_ok());
                assert_eq!(received, &(0..count).collect::<Vec<_>>());
            }
            assert_eq!(alone.2, count);
            assert!(count < 10 * BATCH || on_two.2 > 0, "no item of {count} came back");
        }
    }

    #[test]
    fn either_step_of_a_chain_ends_it_with_its_error() {
        let run = |failing| {
            let (ended, received, _) = numbers(20 * BATCH, failing);
            (ended.map_err(|error| error.to_string()), received.len())
        };
        for failing in [3, BATCH, 5 * BATCH + 1] {
            for ended in [run([Some(failing), None]), on_this_thread(|| run([Some(failing), None]))] {
                assert_eq!(ended, (Err("step 0".to_owned()), failing), "what was made before the error is used");
            }
            for ended in [run([None, Some(failing)]), on_this_thread(|| run([None, Some(failing)]))] {
                assert_eq!(ended, (Err("step 1".to_owned()), failing));
            }
        }
    }

    #[test]
    fn a_panic_is_passed_on() {
        let second = |item: &mut i32| {
            assert!(*item != 1, "second step");
            Ok::<_, std::io::Error>(())
        };
        let failed = std::panic::catch_unwind(|| chain(|_| Ok(Some(1)), second));
        assert!(failed.is_err());
        let failed = std::panic::catch_unwind(|| map(&[1, 2, 3, 4], |i| assert!(*i != 3, "third")));
        assert!(failed.is_err());
        assert!(!IS_ONE_OF_MANY.get());
    }
}
