//! From the reader's thread to the loop: a ring of rows that never grows, and counts of all that came and did not.

use ballrace_twin::recording::Row;
use rtrb::{Consumer, Producer, RingBuffer};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Rows between reader and loop: some seconds at 51.2 kHz, during which a twin starts.
pub const CAPACITY: usize = 1 << 18;
/// How long a reader sleeps that has to wait for room.
const PAUSE: Duration = Duration::from_millis(20);

/// What a reader sends.
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

/// What a reader counts; all of it may be read at any time.
#[derive(Debug, Default)]
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
}

/// Adds to a count.
pub fn count(counter: &AtomicU64, by: u64) {
    counter.fetch_add(by, Ordering::Relaxed);
}

/// Whether the loop wants no more.
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
    /// Of this feed.
    pub counts: Arc<Counts>,
    stop: Arc<AtomicBool>,
}

/// The loop's end.
pub struct Receiver {
    ring: Consumer<Item>,
    spare: Producer<Row>,
    /// Of this feed.
    pub counts: Arc<Counts>,
    stop: Arc<AtomicBool>,
}

/// Both ends.
#[must_use]
pub fn feed(capacity: usize) -> (Sender, Receiver) {
    let (to, from) = RingBuffer::new(capacity);
    let (give, take) = RingBuffer::new(capacity);
    let counts = Arc::new(Counts::default());
    let stop = Arc::new(AtomicBool::new(false));
    let sender = Sender { ring: to, spare: take, counts: counts.clone(), stop: stop.clone() };
    (sender, Receiver { ring: from, spare: give, counts, stop })
}

impl Sender {
    /// A row to read into, used before where there is one.
    #[must_use]
    pub fn blank(&mut self) -> Row {
        self.spare.pop().unwrap_or_default()
    }

    /// The loop wants no more.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
    }

    /// The same for those who wait elsewhere.
    #[must_use]
    pub fn stopped(&self) -> Stopped {
        Stopped(self.stop.clone())
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

    /// Sequence number of the frame that has or will have the sample number `index`.
    #[must_use]
    pub fn sequence_at(&self, index: u64) -> Option<u32> {
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
