//! From the reader's thread to the loop: a ring of rows that never grows, and counts of all that came and did not.

use ballrace_twin::recording::Row;
use rtrb::{Consumer, Producer, RingBuffer};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Rows between reader and loop: some seconds at 51.2 kHz, during which a twin starts.
pub const CAPACITY: usize = 1 << 18;
/// How long a reader sleeps that has to wait for room.
const PAUSE: Duration = Duration::from_millis(20);
/// Events of one kind that are passed on at once.
const BURST: u32 = 10;
/// Interval at which further events of the same kind are passed on.
const INTERVAL: Duration = Duration::from_secs(10);

/// Message of a reader.
pub enum Item {
    /// A sample.
    Row(Row),
    /// Something that happened to the source, in words.
    Note(Note),
}

/// Something that happened to the source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// For programs, such as `source-connected`.
    pub kind: &'static str,
    /// For people.
    pub sentence: String,
}

/// Counters of a reader; other threads may read them at any time.
#[derive(Debug)]
pub struct Counts {
    /// Rows handed on.
    pub rows: AtomicU64,
    /// Frames that never came.
    pub lost: AtomicU64,
    /// Frames that came twice or too late.
    pub repeated: AtomicU64,
    /// Frames or datagrams of a wrong size.
    pub malformed: AtomicU64,
    /// Rows that came while the ring was full and could not be held back.
    pub dropped: AtomicU64,
    /// Most rows that ever waited in the ring.
    pub highest: AtomicU64,
    /// Connections accepted.
    pub connections: AtomicU64,
    /// Sequence number less sample number of the last frame, above `1 << 32`; 0 where there are no frames.
    pub offset: AtomicU64,
    /// Number of the first sample that `offset` holds for.
    pub since: AtomicU64,
    /// Number of the first sample that is not acknowledged; [`u64::MAX`] where nothing is acknowledged.
    pub acknowledged: AtomicU64,
}

impl Default for Counts {
    fn default() -> Self {
        let zero = AtomicU64::default;
        Self {
            rows: zero(),
            lost: zero(),
            repeated: zero(),
            malformed: zero(),
            dropped: zero(),
            highest: zero(),
            connections: zero(),
            offset: zero(),
            since: zero(),
            acknowledged: AtomicU64::new(u64::MAX),
        }
    }
}

/// Limits the number of events of each kind: `BURST` at once, then one in `INTERVAL` with the count of those left out.
#[derive(Debug, Default)]
pub struct EventLimiter {
    kinds: BTreeMap<&'static str, Passed>,
}

#[derive(Debug)]
struct Passed {
    /// Events that may still pass.
    left: u32,
    refilled: Instant,
    /// Events left out since the last one that passed.
    left_out: u64,
}

impl EventLimiter {
    /// Returns the event where it passes, with the count of those left out before it.
    pub fn pass(&mut self, mut note: Note) -> Option<Note> {
        let now = Instant::now();
        let passed = self.kinds.entry(note.kind).or_insert(Passed { left: BURST, refilled: now, left_out: 0 });
        let refills = (now.saturating_duration_since(passed.refilled).as_secs() / INTERVAL.as_secs()) as u32;
        if refills > 0 {
            passed.left = passed.left.saturating_add(refills).min(BURST);
            passed.refilled = now;
        }
        let Some(left) = passed.left.checked_sub(1) else {
            passed.left_out += 1;
            return None;
        };
        passed.left = left;
        let left_out = std::mem::take(&mut passed.left_out);
        if left_out > 0 {
            note.sentence += &format!(" {left_out} events of this kind before it were not logged.");
        }
        Some(note)
    }

    /// Returns the counts of events left out since the last one of their kind, in words.
    #[must_use]
    pub fn left_out(&self) -> Vec<String> {
        let words = |(kind, passed): (&&str, &Passed)| {
            (passed.left_out > 0).then(|| format!("{} further events of kind {kind} were not logged.", passed.left_out))
        };
        self.kinds.iter().filter_map(words).collect()
    }
}

/// A handle on the events of a source that do not follow the order of its samples.
#[derive(Clone)]
pub struct Notes {
    limiter: Arc<Mutex<EventLimiter>>,
    sender: mpsc::Sender<Note>,
}

impl Notes {
    /// Passes an event on.
    pub fn send(&self, kind: &'static str, sentence: String) {
        if let Some(note) = limiter(&self.limiter).pass(Note { kind, sentence }) {
            // Nobody reads events after the end of the monitor.
            let _ = self.sender.send(note);
        }
    }
}

fn limiter(mutex: &Mutex<EventLimiter>) -> MutexGuard<'_, EventLimiter> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Adds to a count.
pub fn count(counter: &AtomicU64, by: u64) {
    counter.fetch_add(by, Ordering::Relaxed);
}

/// Whether the loop has ended.
pub struct Stopped(Arc<AtomicBool>);

impl Stopped {
    /// It does not.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The reader's end.
pub struct Sender {
    ring: Producer<Item>,
    spare: Consumer<Row>,
    /// Counters of this feed.
    pub counts: Arc<Counts>,
    stop: Arc<AtomicBool>,
    notes: Notes,
}

/// The loop's end.
pub struct Receiver {
    ring: Consumer<Item>,
    spare: Producer<Row>,
    /// Counters of this feed.
    pub counts: Arc<Counts>,
    stop: Arc<AtomicBool>,
    limiter: Arc<Mutex<EventLimiter>>,
    notes: mpsc::Receiver<Note>,
}

/// Both ends.
#[must_use]
pub fn feed(capacity: usize) -> (Sender, Receiver) {
    let (to, from) = RingBuffer::new(capacity);
    let (give, take) = RingBuffer::new(capacity);
    let counts = Arc::new(Counts::default());
    let stop = Arc::new(AtomicBool::new(false));
    let limiter = Arc::new(Mutex::default());
    let (send, notes) = mpsc::channel();
    let send = Notes { limiter: limiter.clone(), sender: send };
    let sender = Sender { ring: to, spare: take, counts: counts.clone(), stop: stop.clone(), notes: send };
    (sender, Receiver { ring: from, spare: give, counts, stop, limiter, notes })
}

impl Sender {
    /// A row to read into, used before where there is one.
    #[must_use]
    pub fn blank(&mut self) -> Row {
        self.spare.pop().unwrap_or_default()
    }

    /// The loop has ended.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
    }

    /// The same for those who wait elsewhere.
    #[must_use]
    pub fn stopped(&self) -> Stopped {
        Stopped(self.stop.clone())
    }

    /// A handle on events that do not follow the order of samples.
    #[must_use]
    pub fn notes(&self) -> Notes {
        self.notes.clone()
    }

    /// Passes an event on in the order of samples.
    pub fn note(&mut self, kind: &'static str, sentence: String) {
        let note = limiter(&self.notes.limiter).pass(Note { kind, sentence });
        if let Some(note) = note {
            self.push(Item::Note(note));
        }
    }

    /// Hands an item on; waits for room.
    pub fn push(&mut self, mut item: Item) {
        let is_row = matches!(item, Item::Row(_));
        while let Err(rtrb::PushError::Full(back)) = self.ring.push(item) {
            if self.is_stopped() {
                return;
            }
            item = back;
            std::thread::sleep(PAUSE);
        }
        if is_row {
            self.note_level();
        }
    }

    /// Hands a row on that cannot wait; one that finds the ring full is dropped and counted.
    pub fn push_or_drop(&mut self, row: Row) {
        match self.ring.push(Item::Row(row)) {
            Ok(()) => self.note_level(),
            Err(_) => count(&self.counts.dropped, 1),
        }
    }

    fn note_level(&self) {
        count(&self.counts.rows, 1);
        let level = (self.ring.buffer().capacity() - self.ring.slots()) as u64;
        self.counts.highest.fetch_max(level, Ordering::Relaxed);
    }
}

impl Receiver {
    /// The next item, if it is a note or a row for which `wanted` holds.
    pub fn pop_if(&mut self, wanted: impl Fn(&Row) -> bool) -> Option<Item> {
        match self.ring.peek().ok()? {
            Item::Row(row) if !wanted(row) => None,
            _ => self.ring.pop().ok(),
        }
    }

    /// Takes back a row's memory.
    pub fn recycle(&mut self, row: Row) {
        // With the ring of spares full there are enough of them.
        let _ = self.spare.push(row);
    }

    /// The next event that does not follow the order of samples.
    pub fn note(&self) -> Option<Note> {
        self.notes.try_recv().ok()
    }

    /// Returns an event of the loop itself where it passes the limit.
    #[must_use]
    pub fn limited(&self, note: Note) -> Option<Note> {
        limiter(&self.limiter).pass(note)
    }

    /// Returns the counts of events left out, in words.
    #[must_use]
    pub fn left_out(&self) -> Vec<String> {
        limiter(&self.limiter).left_out()
    }

    /// Ends the reader.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Returns the share of the ring that is in use, 0 to 1.
    #[must_use]
    pub fn fill(&self) -> f64 {
        self.ring.slots() as f64 / self.ring.buffer().capacity() as f64
    }

    /// The next item is a row.
    #[must_use]
    pub fn has_row(&self) -> bool {
        matches!(self.ring.peek(), Ok(Item::Row(_)))
    }

    /// Sequence number of the frame that has or will have the sample number `index`; none where the source has counted anew
    /// since then.
    #[must_use]
    pub fn sequence_at(&self, index: u64) -> Option<u32> {
        if index < self.counts.since.load(Ordering::Acquire) {
            return None;
        }
        let offset = self.counts.offset.load(Ordering::Relaxed);
        (offset >> 32 != 0).then(|| (offset as u32).wrapping_add(index as u32))
    }

    /// The reader has ended and nothing waits any more.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.ring.is_abandoned() && self.ring.is_empty()
    }
}

impl Drop for Receiver {
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
    fn a_source_that_can_wait_loses_nothing() {
        let (mut sender, mut receiver) = feed(16);
        let reader = std::thread::spawn(move || (0..10_000).for_each(|i| sender.push(Item::Row(row(i)))));
        let mut next = 0;
        while !receiver.is_over() {
            while let Some(Item::Row(row)) = receiver.pop_if(|_| true) {
                assert_eq!(row.index, next);
                next += 1;
                receiver.recycle(row);
            }
        }
        reader.join().unwrap();
        assert_eq!(next, 10_000);
        assert!(receiver.counts.highest.load(Ordering::Relaxed) <= 16);
    }

    #[test]
    fn one_that_cannot_wait_has_its_losses_counted() {
        let (mut sender, mut receiver) = feed(16);
        (0..100).for_each(|i| sender.push_or_drop(row(i)));
        assert_eq!(sender.counts.dropped.load(Ordering::Relaxed), 84);
        assert!(receiver.pop_if(|row| row.index > 0).is_none());
        assert_eq!(std::iter::from_fn(|| receiver.pop_if(|_| true)).count(), 16);
    }
}
