//! Block schedule at absolute times, with statistics of lateness and processing time.

use ballrace_twin::replay::outcome::Pacing;
use ballrace_twin::replay::timing::{histogram, nanoseconds, quantiles};
use hdrhistogram::Histogram;
use std::time::{Duration, Instant};

/// Period of the blocks: long compared with the cost of a wake-up, short compared with a shaft revolution.
pub const BLOCK_PERIOD: Duration = Duration::from_millis(10);

/// Block schedule with wake-ups at `start + n BLOCK_PERIOD`. A late wake-up or a long block does not shift later blocks.
pub struct BlockSchedule {
    created: Instant,
    start: Instant,
    /// Number of the current block, counted from `start`; skipped blocks are included.
    number: u64,
    /// Time from creation until the twin has started and caught up.
    starting_time: Option<Duration>,
    lateness: Histogram<u64>,
    compute: Histogram<u64>,
    misses: u64,
    /// Processor time used, and the time, when the twin had started.
    processor: Option<(Duration, Instant)>,
}

impl BlockSchedule {
    /// Creates a schedule that starts now.
    ///
    /// # Errors
    /// Returns an error if a histogram cannot be created; their constant bounds are valid.
    pub fn try_new() -> anyhow::Result<Self> {
        let now = Instant::now();
        Ok(Self {
            created: now,
            start: now,
            number: 0,
            starting_time: None,
            lateness: histogram()?,
            compute: histogram()?,
            misses: 0,
            processor: None,
        })
    }

    /// Restarts the schedule now; the time before counts as starting time.
    pub fn restart(&mut self) {
        (self.start, self.number) = (Instant::now(), 0);
    }

    /// Sleeps until the start of the next block and returns its time since the start of the schedule.
    pub fn wait(&mut self) -> Duration {
        self.number += 1;
        let time = block_time(self.number);
        let due = self.start + time;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        if self.starting_time.is_some() {
            self.lateness.saturating_record(nanoseconds(Instant::now().saturating_duration_since(due)));
        }
        time
    }

    /// Records the end of a block that started at `block_start`; `caught_up` is `true` if no due sample is left.
    ///
    /// Deadlines are not counted until the twin has started and caught up.
    pub fn finish_block(&mut self, block_start: Instant, caught_up: bool) {
        let now = Instant::now();
        let current = (now.saturating_duration_since(self.start).as_nanos() / BLOCK_PERIOD.as_nanos()) as u64;
        let missed = current.saturating_sub(self.number);
        if self.starting_time.is_none() {
            if caught_up && missed == 0 {
                self.starting_time = Some(self.created.elapsed());
                self.processor = processor_time().map(|used| (used, now));
            }
        } else {
            self.compute.saturating_record(nanoseconds(now.saturating_duration_since(block_start)));
            self.misses += missed;
        }
        // Skipped blocks are not repeated: the next block processes their samples.
        self.number = self.number.max(current);
    }

    /// Returns the number of missed deadlines: blocks skipped because an earlier block took too long.
    #[must_use]
    pub const fn misses(&self) -> u64 {
        self.misses
    }

    /// Returns the load of all threads of this program since the twin has started, in processors; `None` before, or if
    /// the system does not report it.
    #[must_use]
    pub fn processor_load(&self) -> Option<f64> {
        let (before, since) = self.processor?;
        let used = processor_time()?.saturating_sub(before);
        Some(used.as_secs_f64() / since.elapsed().as_secs_f64().max(1e-9))
    }

    /// Returns the statistics.
    #[must_use]
    pub fn statistics(&self, scheduling: String) -> Pacing {
        Pacing {
            block_ns: nanoseconds(BLOCK_PERIOD),
            blocks: self.compute.len(),
            compute: quantiles(&self.compute),
            lateness: quantiles(&self.lateness),
            deadline_misses: self.misses,
            starting_s: self.starting_time.unwrap_or_else(|| self.created.elapsed()).as_secs_f64(),
            idle_percent: self.processor_load().map(|load| 100.0 * (1.0 - load)),
            scheduling,
        }
    }
}

/// Returns the time of block `number` since the start of the schedule.
const fn block_time(number: u64) -> Duration {
    Duration::from_millis(BLOCK_PERIOD.as_millis() as u64 * number)
}

/// Returns the processor time used by all threads of this program.
#[cfg(unix)]
fn processor_time() -> Option<Duration> {
    rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).try_into().ok()
}

/// Returns `None`: the clock of the processor time is available on Unix only.
#[cfg(not(unix))]
const fn processor_time() -> Option<Duration> {
    None
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn the_schedule_goes_on_after_497_days() {
        let mut schedule = BlockSchedule::try_new().unwrap();
        let blocks = u64::from(u32::MAX);
        schedule.start = Instant::now().checked_sub(block_time(blocks)).unwrap();
        schedule.number = blocks;
        let (since, mut time) = (Instant::now(), Duration::ZERO);
        for _ in 0..5 {
            time = schedule.wait();
            schedule.finish_block(Instant::now(), true);
        }
        let passed = time.checked_sub(block_time(blocks)).unwrap();
        assert!(passed >= 5 * BLOCK_PERIOD && since.elapsed() + BLOCK_PERIOD >= passed, "{passed:?}");
    }

    #[test]
    fn a_long_block_misses_deadlines_without_shifting_later_blocks() {
        let mut schedule = BlockSchedule::try_new().unwrap();
        for i in 0..20 {
            let time = schedule.wait();
            assert!(schedule.start.elapsed() >= time);
            let block_start = Instant::now();
            if i == 10 {
                std::thread::sleep(4 * BLOCK_PERIOD);
            }
            schedule.finish_block(block_start, true);
        }
        let pacing = schedule.statistics(String::new());
        assert!((3..=60).contains(&pacing.deadline_misses), "{}", pacing.deadline_misses);
        assert!((10..=19).contains(&pacing.blocks), "{}", pacing.blocks);
        assert!(pacing.compute.max_ns >= 20_000_000 && pacing.lateness.max_ns > 0);
        assert!(schedule.start.elapsed() >= 23 * BLOCK_PERIOD);
    }
}
