//! Channel from the reader thread to the monitor loop: a bounded queue of rows, events, and counters.

use ballrace_twin::record::EventMessage;
use ballrace_twin::recording::Row;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Capacity of the queue, rows: several seconds at 51.2 kHz, the time in which the twin starts. It takes memory for the rows that wait.
pub const CAPACITY: usize = 1 << 18;
/// The same of a recording, which waits until it is read.
pub const CAPACITY_OF_RECORDING: usize = 1 << 14;
/// Maximum number of used rows that are kept for reuse: more than arrive between two passes of the monitor loop.
const SPARE_ROWS: usize = 1 << 12;
/// Interval at which a reader checks a full queue for free space.
const PAUSE: Duration = Duration::from_millis(20);
/// Maximum number of consecutive events of one kind that pass without delay.
const BURST: u32 = 10;
/// Interval at which further events of the same kind pass.
const INTERVAL: Duration = Duration::from_secs(10);

/// Item in the queue.
pub enum FeedItem {
    /// Sample.
    Row(Row),
    /// Event between two samples.
    Event(EventMessage),
}

/// Counters of a source, which other threads may read at any time.
#[derive(Debug)]
pub struct SourceCounters {
    /// Rows pushed into the queue.
    pub rows: AtomicU64,
    /// Frames that are missing between two received frames.
    pub lost: AtomicU64,
    /// Frames that arrived twice or too late.
    pub repeated: AtomicU64,
    /// Frames or datagrams of a wrong size.
    pub malformed: AtomicU64,
    /// Rows of a source without flow control that arrived while the queue was full.
    pub dropped: AtomicU64,
    /// Highest number of items in the queue.
    pub ring_highest: AtomicU64,
    /// Accepted connections.
    pub connections: AtomicU64,
    /// Difference of sequence number and sample number of the last frame, plus `1 << 32`; 0 before the first frame.
    pub sequence_offset: AtomicU64,
    /// Number of the first sample to which `sequence_offset` applies.
    pub offset_since: AtomicU64,
    /// Number of the first sample whose acknowledgement the source may not have; [`u64::MAX`] for a monitor without a state.
    pub acknowledged: AtomicU64,
}

impl Default for SourceCounters {
    fn default() -> Self {
        let zero = AtomicU64::default;
        Self {
            rows: zero(),
            lost: zero(),
            repeated: zero(),
            malformed: zero(),
            dropped: zero(),
            ring_highest: zero(),
            connections: zero(),
            sequence_offset: zero(),
            offset_since: zero(),
            acknowledged: AtomicU64::new(u64::MAX),
        }
    }
}

/// Limits the rate of the events of each kind: `BURST` without delay, then one in each `INTERVAL`, with the number of omitted
/// events.
#[derive(Debug, Default)]
pub struct EventLimiter {
    budgets: BTreeMap<&'static str, EventBudget>,
}

/// Token bucket of one kind of event.
#[derive(Debug)]
struct EventBudget {
    /// Events that may still pass.
    tokens: u32,
    refilled: Instant,
    /// Events omitted since the last event that passed.
    omitted: u64,
}

impl EventLimiter {
    /// Returns the event, with the number of events omitted before it, or `None` if the event is omitted.
    pub fn pass(&mut self, mut message: EventMessage) -> Option<EventMessage> {
        let now = Instant::now();
        let budget =
            self.budgets.entry(message.kind).or_insert(EventBudget { tokens: BURST, refilled: now, omitted: 0 });
        let refills = (now.saturating_duration_since(budget.refilled).as_secs() / INTERVAL.as_secs()) as u32;
        if refills > 0 {
            budget.tokens = budget.tokens.saturating_add(refills).min(BURST);
            budget.refilled = now;
        }
        let Some(tokens) = budget.tokens.checked_sub(1) else {
            budget.omitted += 1;
            return None;
        };
        budget.tokens = tokens;
        let omitted = std::mem::take(&mut budget.omitted);
        if omitted > 0 {
            message.sentence += &format!(" {omitted} events of this kind before it were not logged.");
        }
        Some(message)
    }

    /// Returns one sentence for each kind with omitted events since the last event that passed.
    #[must_use]
    pub fn omitted(&self) -> Vec<String> {
        let sentence = |(kind, budget): (&&str, &EventBudget)| {
            (budget.omitted > 0).then(|| format!("{} further events of kind {kind} were not logged.", budget.omitted))
        };
        self.budgets.iter().filter_map(sentence).collect()
    }
}

/// Sender of events that are not ordered with respect to the samples.
#[derive(Clone)]
pub struct EventSender {
    limiter: Arc<Mutex<EventLimiter>>,
    sender: Sender<EventMessage>,
}

impl EventSender {
    /// Sends an event unless the rate limit omits it.
    pub fn send(&self, kind: &'static str, sentence: String) {
        if let Some(message) = lock(&self.limiter).pass(EventMessage { kind, sentence }) {
            // The receiver is dropped at the end of the monitor.
            let _ = self.sender.send(message);
        }
    }
}

/// Locks a mutex, also after a panic of a thread that held it: the data of the monitor's mutexes stay consistent.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Adds `increment` to a counter.
pub fn add(counter: &AtomicU64, increment: u64) {
    counter.fetch_add(increment, Ordering::Release);
}

/// Flag that is set when the monitor loop has ended.
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Returns `true` if the monitor loop has ended.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Items in the queue, and their maximum.
struct Level {
    items: AtomicUsize,
    capacity: usize,
}

/// End of the channel for the reader thread.
pub struct FeedSender {
    queue: Sender<FeedItem>,
    level: Arc<Level>,
    spare: Receiver<Row>,
    /// Counters of the source.
    pub counters: Arc<SourceCounters>,
    stop: Arc<AtomicBool>,
    events: EventSender,
}

/// End of the channel for the monitor loop.
pub struct FeedReceiver {
    queue: Receiver<FeedItem>,
    level: Arc<Level>,
    /// First item of the queue, once it has been looked at.
    next: Option<FeedItem>,
    /// True if the reader thread has ended and the queue is empty.
    is_finished: bool,
    spare: SyncSender<Row>,
    /// Counters of the source.
    pub counters: Arc<SourceCounters>,
    stop: Arc<AtomicBool>,
    limiter: Arc<Mutex<EventLimiter>>,
    events: Receiver<EventMessage>,
}

/// Creates the channel with a queue of at most `capacity` items, and a shorter one that returns used rows for reuse.
#[must_use]
pub fn feed(capacity: usize) -> (FeedSender, FeedReceiver) {
    let (queue_sender, queue) = mpsc::channel();
    let (spare, spare_receiver) = mpsc::sync_channel(SPARE_ROWS);
    let level = Arc::new(Level { items: AtomicUsize::new(0), capacity });
    let counters = Arc::new(SourceCounters::default());
    let stop = Arc::new(AtomicBool::new(false));
    let limiter = Arc::new(Mutex::default());
    let (event_sender, events) = mpsc::channel();
    let sender = FeedSender {
        queue: queue_sender,
        level: level.clone(),
        spare: spare_receiver,
        counters: counters.clone(),
        stop: stop.clone(),
        events: EventSender { limiter: limiter.clone(), sender: event_sender },
    };
    let (next, is_finished) = (None, false);
    let receiver = FeedReceiver { queue, level, next, is_finished, spare, counters, stop, limiter, events };
    (sender, receiver)
}

impl FeedSender {
    /// Returns a row to fill: a returned one if available, else a new one.
    #[must_use]
    pub fn spare_row(&mut self) -> Row {
        self.spare.try_recv().unwrap_or_default()
    }

    /// Returns `true` if the monitor loop has ended.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns the flag that is set when the monitor loop has ended.
    #[must_use]
    pub fn stop_flag(&self) -> StopFlag {
        StopFlag(self.stop.clone())
    }

    /// Returns a sender of events that are not ordered with respect to the samples.
    #[must_use]
    pub fn event_sender(&self) -> EventSender {
        self.events.clone()
    }

    /// Pushes an event into the queue, between the samples before and after it, unless the rate limit omits it.
    pub fn push_event(&mut self, kind: &'static str, sentence: String) {
        let message = lock(&self.events.limiter).pass(EventMessage { kind, sentence });
        if let Some(message) = message {
            self.push(FeedItem::Event(message));
        }
    }

    /// Pushes an item; blocks while the queue is full.
    pub fn push(&mut self, item: FeedItem) {
        while self.is_full() {
            if self.is_stopped() {
                return;
            }
            std::thread::sleep(PAUSE);
        }
        self.enqueue(item);
    }

    /// Pushes a row; drops and counts it if the queue is full.
    pub fn push_or_drop(&mut self, row: Row) {
        if self.is_full() {
            add(&self.counters.dropped, 1);
        } else {
            self.enqueue(FeedItem::Row(row));
        }
    }

    fn is_full(&self) -> bool {
        self.level.items.load(Ordering::Acquire) >= self.level.capacity
    }

    fn enqueue(&self, item: FeedItem) {
        let is_row = matches!(item, FeedItem::Row(_));
        let level = self.level.items.fetch_add(1, Ordering::AcqRel) + 1;
        // The receiver is dropped at the end of the monitor.
        let _ = self.queue.send(item);
        if is_row {
            add(&self.counters.rows, 1);
            self.counters.ring_highest.fetch_max(level as u64, Ordering::Relaxed);
        }
    }
}

impl FeedReceiver {
    /// Returns the next item without taking it.
    fn peek(&mut self) -> Option<&FeedItem> {
        if self.next.is_none() {
            match self.queue.try_recv() {
                Ok(item) => self.next = Some(item),
                Err(error) => self.is_finished = error == TryRecvError::Disconnected,
            }
        }
        self.next.as_ref()
    }

    /// Returns the next item if it is an event, or a row that satisfies `condition`.
    pub fn pop_if(&mut self, condition: impl Fn(&Row) -> bool) -> Option<FeedItem> {
        match self.peek()? {
            FeedItem::Row(row) if !condition(row) => None,
            _ => {
                self.level.items.fetch_sub(1, Ordering::AcqRel);
                self.next.take()
            }
        }
    }

    /// Returns a row to the sender for reuse.
    pub fn recycle(&mut self, row: Row) {
        // A row that does not fit is freed.
        let _ = self.spare.try_send(row);
    }

    /// Returns the next event that is not ordered with respect to the samples.
    pub fn next_event(&self) -> Option<EventMessage> {
        self.events.try_recv().ok()
    }

    /// Applies the rate limit to an event of the monitor loop itself; returns `None` if the event is omitted.
    #[must_use]
    pub fn limited(&self, message: EventMessage) -> Option<EventMessage> {
        lock(&self.limiter).pass(message)
    }

    /// Returns one sentence for each kind with omitted events.
    #[must_use]
    pub fn omitted_events(&self) -> Vec<String> {
        lock(&self.limiter).omitted()
    }

    /// Requests the end of the reader thread.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Returns the fill level of the queue, 0 to 1.
    #[must_use]
    pub fn fill(&self) -> f64 {
        self.level.items.load(Ordering::Acquire) as f64 / self.level.capacity as f64
    }

    /// Returns `true` if the next item is a row.
    pub fn has_row(&mut self) -> bool {
        matches!(self.peek(), Some(FeedItem::Row(_)))
    }

    /// Returns the sequence number of the frame with sample number `index`, also of a future one; `None` if the source has
    /// restarted its sequence numbers since that sample, or sends no frames.
    #[must_use]
    pub fn sequence_at(&self, index: u64) -> Option<u32> {
        if index < self.counters.offset_since.load(Ordering::Acquire) {
            return None;
        }
        let offset = self.counters.sequence_offset.load(Ordering::Relaxed);
        (offset >> 32 != 0).then(|| (offset as u32).wrapping_add(index as u32))
    }

    /// Returns `true` if the reader thread has ended and the queue is empty.
    pub fn is_finished(&mut self) -> bool {
        self.peek().is_none() && self.is_finished
    }
}

impl Drop for FeedReceiver {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn row(index: u64) -> Row {
        Row { index, ..Row::default() }
    }

    #[test]
    fn push_loses_no_row() {
        let (mut sender, mut receiver) = feed(16);
        let reader = std::thread::spawn(move || (0..10_000).for_each(|i| sender.push(FeedItem::Row(row(i)))));
        let mut next = 0;
        while !receiver.is_finished() {
            while let Some(FeedItem::Row(row)) = receiver.pop_if(|_| true) {
                assert_eq!(row.index, next);
                next += 1;
                receiver.recycle(row);
            }
        }
        reader.join().unwrap();
        assert_eq!(next, 10_000);
        assert!(receiver.counters.ring_highest.load(Ordering::Relaxed) <= 16);
    }

    #[test]
    fn push_or_drop_counts_dropped_rows() {
        let (mut sender, mut receiver) = feed(16);
        (0..100).for_each(|i| sender.push_or_drop(row(i)));
        assert_eq!(sender.counters.dropped.load(Ordering::Relaxed), 84);
        assert!(receiver.pop_if(|row| row.index > 0).is_none());
        assert_eq!(std::iter::from_fn(|| receiver.pop_if(|_| true)).count(), 16);
    }
}
