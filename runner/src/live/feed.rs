//! Channel from the reader thread to the monitor loop: a bounded ring of rows, events, and counters.

use ballrace_twin::record::EventMessage;
use ballrace_twin::recording::Row;
use rtrb::{Consumer, Producer, RingBuffer};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Capacity of the ring, rows: several seconds at 51.2 kHz, the time in which the twin starts.
pub const CAPACITY: usize = 1 << 18;
/// Interval at which a reader checks a full ring for free space.
const PAUSE: Duration = Duration::from_millis(20);
/// Maximum number of consecutive events of one kind that pass without delay.
const BURST: u32 = 10;
/// Interval at which further events of the same kind pass.
const INTERVAL: Duration = Duration::from_secs(10);

/// Item in the ring.
pub enum FeedItem {
    /// Sample.
    Row(Row),
    /// Event between two samples.
    Event(EventMessage),
}

/// Counters of a source, which other threads may read at any time.
#[derive(Debug)]
pub struct SourceCounters {
    /// Rows pushed into the ring.
    pub rows: AtomicU64,
    /// Frames that are missing between two received frames.
    pub lost: AtomicU64,
    /// Frames that arrived twice or too late.
    pub repeated: AtomicU64,
    /// Frames or datagrams of a wrong size.
    pub malformed: AtomicU64,
    /// Rows of a source without flow control that arrived while the ring was full.
    pub dropped: AtomicU64,
    /// Highest number of items in the ring.
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
    sender: mpsc::Sender<EventMessage>,
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

/// End of the channel for the reader thread.
pub struct FeedSender {
    ring: Producer<FeedItem>,
    spare: Consumer<Row>,
    /// Counters of the source.
    pub counters: Arc<SourceCounters>,
    stop: Arc<AtomicBool>,
    events: EventSender,
}

/// End of the channel for the monitor loop.
pub struct FeedReceiver {
    ring: Consumer<FeedItem>,
    spare: Producer<Row>,
    /// Counters of the source.
    pub counters: Arc<SourceCounters>,
    stop: Arc<AtomicBool>,
    limiter: Arc<Mutex<EventLimiter>>,
    events: mpsc::Receiver<EventMessage>,
}

/// Creates the channel with a ring of `capacity` items, and a ring of the same size that returns used rows for reuse.
#[must_use]
pub fn feed(capacity: usize) -> (FeedSender, FeedReceiver) {
    let (ring_producer, ring_consumer) = RingBuffer::new(capacity);
    let (spare_producer, spare_consumer) = RingBuffer::new(capacity);
    let counters = Arc::new(SourceCounters::default());
    let stop = Arc::new(AtomicBool::new(false));
    let limiter = Arc::new(Mutex::default());
    let (event_sender, events) = mpsc::channel();
    let sender = FeedSender {
        ring: ring_producer,
        spare: spare_consumer,
        counters: counters.clone(),
        stop: stop.clone(),
        events: EventSender { limiter: limiter.clone(), sender: event_sender },
    };
    let receiver = FeedReceiver { ring: ring_consumer, spare: spare_producer, counters, stop, limiter, events };
    (sender, receiver)
}

impl FeedSender {
    /// Returns a row to fill: a returned one if available, else a new one.
    #[must_use]
    pub fn spare_row(&mut self) -> Row {
        self.spare.pop().unwrap_or_default()
    }

    /// Returns `true` if the monitor loop has ended.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
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

    /// Pushes an event into the ring, between the samples before and after it, unless the rate limit omits it.
    pub fn push_event(&mut self, kind: &'static str, sentence: String) {
        let message = lock(&self.events.limiter).pass(EventMessage { kind, sentence });
        if let Some(message) = message {
            self.push(FeedItem::Event(message));
        }
    }

    /// Pushes an item; blocks while the ring is full.
    pub fn push(&mut self, mut item: FeedItem) {
        let is_row = matches!(item, FeedItem::Row(_));
        while let Err(rtrb::PushError::Full(rejected)) = self.ring.push(item) {
            if self.is_stopped() {
                return;
            }
            item = rejected;
            std::thread::sleep(PAUSE);
        }
        if is_row {
            self.count_row();
        }
    }

    /// Pushes a row; drops and counts it if the ring is full.
    pub fn push_or_drop(&mut self, row: Row) {
        match self.ring.push(FeedItem::Row(row)) {
            Ok(()) => self.count_row(),
            Err(_) => add(&self.counters.dropped, 1),
        }
    }

    fn count_row(&self) {
        add(&self.counters.rows, 1);
        let level = (self.ring.buffer().capacity() - self.ring.slots()) as u64;
        self.counters.ring_highest.fetch_max(level, Ordering::Relaxed);
    }
}

impl FeedReceiver {
    /// Returns the next item if it is an event, or a row that satisfies `condition`.
    pub fn pop_if(&mut self, condition: impl Fn(&Row) -> bool) -> Option<FeedItem> {
        match self.ring.peek().ok()? {
            FeedItem::Row(row) if !condition(row) => None,
            _ => self.ring.pop().ok(),
        }
    }

    /// Returns a row to the sender for reuse.
    pub fn recycle(&mut self, row: Row) {
        // A row that does not fit is freed.
        let _ = self.spare.push(row);
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

    /// Returns the fill level of the ring, 0 to 1.
    #[must_use]
    pub fn fill(&self) -> f64 {
        self.ring.slots() as f64 / self.ring.buffer().capacity() as f64
    }

    /// Returns `true` if the next item is a row.
    #[must_use]
    pub fn has_row(&self) -> bool {
        matches!(self.ring.peek(), Ok(FeedItem::Row(_)))
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

    /// Returns `true` if the reader thread has ended and the ring is empty.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.ring.is_abandoned() && self.ring.is_empty()
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
