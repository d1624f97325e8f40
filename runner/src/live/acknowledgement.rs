//! Acknowledgement of the frames whose results are on disk.

use super::feed::SourceCounters;
use super::source::{AckChannel, AckReceiver, Resume, lock};
use super::state::State;
use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time after which a source has an acknowledgement, or its connection has ended.
const TRANSIT_TIME: Duration = Duration::from_secs(20);

/// Acknowledgements to a source.
pub(super) struct Acknowledgement<'a> {
    channel: &'a AckChannel,
    /// Last sequence number that is acknowledged, or was before a restart.
    last: Option<u32>,
    /// Frames that the source has sent twice.
    repeated: u64,
    /// Acknowledgements that may be in transit: time, and number of the first sample after it.
    in_transit: VecDeque<(Instant, u64)>,
}

impl<'a> Acknowledgement<'a> {
    /// Creates the acknowledgements of a monitor that resumes at `resume`: the state of an earlier run is on disk.
    pub(super) fn new(channel: &'a AckChannel, resume: &Resume) -> Self {
        let last = resume.sequence.filter(|_| resume.index > 0).map(|sequence| sequence.wrapping_sub(1));
        Self { channel, last, repeated: 0, in_transit: VecDeque::new() }
    }

    /// Sends the source the sequence number up to which it may discard frames.
    pub(super) fn send(&mut self, state: &mut State, counters: &SourceCounters) {
        let Some(last) = state.resume.sequence.map(|sequence| sequence.wrapping_sub(1)) else { return };
        let index = state.resume.index;
        if self.last == Some(last) || index == 0 {
            return;
        }
        let mut receiver = lock(self.channel);
        if matches!(&*receiver, AckReceiver::Absent) {
            return;
        }
        receiver.send(last);
        self.last = Some(last);
        // The source may not have the latest ones: a kill or the end of the connection may come first.
        let transit_time = if matches!(&*receiver, AckReceiver::Unread) { Duration::ZERO } else { TRANSIT_TIME };
        self.in_transit.push_back((Instant::now(), index));
        while let Some((_, received)) = self.in_transit.front().filter(|(sent, _)| sent.elapsed() >= transit_time) {
            state.acknowledged = Some(*received);
            counters.acknowledged.store(*received, Ordering::Relaxed);
            self.in_transit.pop_front();
        }
    }

    /// Sends the last acknowledgement again to a source that repeats frames: the end of a connection may have taken it, and a source that
    /// keeps only so many frames would wait for it.
    pub(super) fn send_again(&mut self, counters: &SourceCounters) {
        let repeated = counters.repeated.load(Ordering::Relaxed);
        if std::mem::replace(&mut self.repeated, repeated) == repeated {
            return;
        }
        if let Some(last) = self.last {
            lock(self.channel).send(last);
        }
    }
}
