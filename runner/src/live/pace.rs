//! The timeline: blocks at absolute times, and the ledger of how well they were kept.

use ballrace_twin::replay::outcome::Pacing;
use ballrace_twin::replay::timing::{histogram, nanoseconds, quantiles};
use hdrhistogram::Histogram;
use std::time::{Duration, Instant};

/// From one wake to the next. Long enough for the wakes to cost nothing, short beside a turn of the shaft.
pub const BLOCK: Duration = Duration::from_millis(10);

/// Wakes at `start + n BLOCK`. A late wake or a long block does not shift the ones after it.
pub struct Pace {
    begun: Instant,
    start: Instant,
    /// Blocks begun since `start`, those that passed unused included.
    number: u32,
    starting: Option<Duration>,
    lateness: Histogram<u64>,
    compute: Histogram<u64>,
    misses: u64,
    /// Processor time used and the time of day when the start was over.
    processor: Option<(Duration, Instant)>,
}

impl Pace {
    /// A timeline that begins now.
    ///
    /// # Errors
    /// None in practice.
    pub fn begin() -> anyhow::Result<Self> {
        let now = Instant::now();
        Ok(Self {
            begun: now,
            start: now,
            number: 0,
            starting: None,
            lateness: histogram()?,
            compute: histogram()?,
            misses: 0,
            processor: None,
        })
    }

    /// The timeline begins now; what came before was the start.
    pub fn restart(&mut self) {
        (self.start, self.number) = (Instant::now(), 0);
    }

    /// Sleeps until the next block is due; gives the time of the timeline then.
    pub fn wait(&mut self) -> Duration {
        self.number += 1;
        let due = self.start + BLOCK * self.number;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        if self.starting.is_some() {
            self.lateness.saturating_record(nanoseconds(Instant::now().saturating_duration_since(due)));
        }
        BLOCK * self.number
    }

    /// Records the end of a block that began at `begun`; `caught_up` reports that no sample waits.
    ///
    /// Until the twin has started and has caught up, nothing is held against it.
    pub fn done(&mut self, begun: Instant, caught_up: bool) {
        let now = Instant::now();
        let passed = (now.saturating_duration_since(self.start).as_nanos() / BLOCK.as_nanos()) as u32;
        let missed = passed.saturating_sub(self.number);
        if self.starting.is_none() {
            if caught_up && missed == 0 {
                self.starting = Some(self.begun.elapsed());
                self.processor = processor_time().map(|used| (used, now));
            }
        } else {
            self.compute.saturating_record(nanoseconds(now.saturating_duration_since(begun)));
            self.misses += u64::from(missed);
        }
        // Blocks that went by are not made up for: what came in them is taken with the next.
        self.number = self.number.max(passed);
    }

    /// Blocks that took until after the next one was due, counted by the blocks that went by.
    #[must_use]
    pub const fn misses(&self) -> u64 {
        self.misses
    }

    /// Share of one processor that all threads of this program have used since the start was over, 0 to 1; none where
    /// the system does not report it.
    #[must_use]
    pub fn busy(&self) -> Option<f64> {
        let (before, since) = self.processor?;
        let used = processor_time()?.saturating_sub(before);
        Some(used.as_secs_f64() / since.elapsed().as_secs_f64().max(1e-9))
    }

    /// The figures.
    #[must_use]
    pub fn finish(&self, scheduling: String) -> Pacing {
        Pacing {
            block_ns: nanoseconds(BLOCK),
            blocks: self.compute.len(),
            compute: quantiles(&self.compute),
            lateness: quantiles(&self.lateness),
            deadline_misses: self.misses,
            starting_s: self.starting.unwrap_or_else(|| self.begun.elapsed()).as_secs_f64(),
            idle_percent: self.busy().map(|busy| 100.0 * (1.0 - busy)),
            scheduling,
        }
    }
}

/// Processor time that all threads of this program have used.
#[cfg(unix)]
fn processor_time() -> Option<Duration> {
    rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).try_into().ok()
}

/// None: only Unix systems have a clock for it that needs no code of the system's own.
#[cfg(not(unix))]
const fn processor_time() -> Option<Duration> {
    None
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn a_long_block_is_a_miss_and_shifts_nothing() {
        let mut pace = Pace::begin().unwrap();
        for i in 0..20 {
            let at = pace.wait();
            assert!(pace.start.elapsed() >= at);
            let begun = Instant::now();
            if i == 10 {
                std::thread::sleep(4 * BLOCK);
            }
            pace.done(begun, true);
        }
        let pacing = pace.finish(String::new());
        assert!((3..=60).contains(&pacing.deadline_misses), "{}", pacing.deadline_misses);
        assert!((10..=19).contains(&pacing.blocks), "{}", pacing.blocks);
        assert!(pacing.compute.max_ns >= 20_000_000 && pacing.lateness.max_ns > 0);
        assert!(pace.start.elapsed() >= 23 * BLOCK);
    }
}
