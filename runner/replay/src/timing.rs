//! Compute time of the samples of a replay.

use ballrace_outcome::{Quantiles, StageTimes, Timing};
use hdrhistogram::{CreationError, Histogram};
use std::time::{Duration, Instant};

/// Every how many samples the work is timed: four readings of the clock cost as much as a force. A prime number, because some work is due at
/// every power of two.
const DECIMATION: u64 = 7;
/// Every how many samples the stages are timed: two readings of the clock cost as much as a short stage. A prime number too.
const STAGE_DECIMATION: u64 = 61;

/// Stage of a replay that is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    /// The twin and its linear reference.
    Twin,
    /// The observer.
    Observer,
    /// Forces of the bearings.
    Forces,
    /// Comparison of readings and twin.
    Comparison,
}

/// Clock of the work on one sample, which runs at every 7th.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorkClock(Option<Instant>);

impl WorkClock {
    /// Starts the clock of the sample `index`.
    #[must_use]
    pub fn of(index: u64) -> Self {
        Self(index.is_multiple_of(DECIMATION).then(Instant::now))
    }

    /// Returns the time since the start; none where the sample is not timed.
    #[must_use]
    pub fn elapsed(self) -> Option<Duration> {
        self.0.map(|begun| begun.elapsed())
    }
}

/// Clock of the stages of one sample, which runs at every 61st.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StageClock(Option<RunningClock>);

#[derive(Debug, Clone, Copy)]
struct RunningClock {
    since: Instant,
    /// Time of each [`Stage`].
    stages: [Duration; 4],
}

impl StageClock {
    /// Starts the clock of the sample `index`.
    #[must_use]
    pub fn of(index: u64) -> Self {
        let is_timed = index.is_multiple_of(STAGE_DECIMATION);
        Self(is_timed.then(|| RunningClock { since: Instant::now(), stages: [Duration::ZERO; 4] }))
    }

    /// Adds the time since the last call to `stage`.
    pub fn passed(&mut self, stage: Stage) {
        if let Some(clock) = &mut self.0 {
            let now = Instant::now();
            clock.stages[stage as usize] += now.duration_since(std::mem::replace(&mut clock.since, now));
        }
    }

    /// Returns the clock with the time so far, running from now.
    #[must_use]
    pub fn resumed(self) -> Self {
        Self(self.0.map(|clock| RunningClock { since: Instant::now(), ..clock }))
    }
}

/// Compute times of one replay.
pub(crate) struct Ledger {
    /// Times of the timed samples.
    compute: Histogram<u64>,
    /// Number of samples.
    samples: u64,
    period: f64,
    start: Option<Instant>,
    first: f64,
    last: f64,
    diagnosis: Duration,
    /// Time of each [`Stage`] in the timed samples.
    stages: [Duration; 4],
    /// Number of samples with timed stages.
    timed: u64,
}

/// Returns a histogram from 1 ns to 1000 s with three digits, 50 kB at any number of entries.
///
/// # Errors
/// None in practice: the bounds are constants.
pub fn histogram() -> Result<Histogram<u64>, CreationError> {
    Histogram::new_with_bounds(1, 1_000_000_000_000, 3)
}

impl Ledger {
    /// Creates the ledger for a sample period in seconds.
    ///
    /// # Errors
    /// None in practice.
    pub fn try_new(period: f64) -> Result<Self, CreationError> {
        Ok(Self {
            compute: histogram()?,
            samples: 0,
            period,
            start: None,
            first: 0.0,
            last: 0.0,
            diagnosis: Duration::ZERO,
            stages: [Duration::ZERO; 4],
            timed: 0,
        })
    }

    /// Marks the first row.
    pub fn begin(&mut self) {
        self.start.get_or_insert_with(Instant::now);
    }

    /// Adds the sample at `time`, s.
    pub fn sample(&mut self, time: f64) {
        if self.samples == 0 {
            self.first = time;
        }
        self.last = time;
        self.samples += 1;
    }

    /// Adds the times of the stages of a sample.
    pub fn add(&mut self, clock: StageClock) {
        let Some(clock) = clock.0 else { return };
        self.timed += 1;
        for (sum, stage) in self.stages.iter_mut().zip(clock.stages) {
            *sum += stage;
        }
    }

    /// Records the time of a sample in twin and observer and that in the forces, where the sample is timed.
    pub fn worked(&mut self, took: [Option<Duration>; 2]) {
        if let [Some(followed), Some(evaluated)] = took {
            self.compute.saturating_record(nanoseconds(followed + evaluated));
        }
    }

    /// Adds the time of a calibration or diagnosis.
    pub fn diagnosed(&mut self, took: Duration) {
        self.diagnosis += took;
    }

    /// Returns the timing for the outcome; `startup` is the time of the search for the observer and of the run-in of the twin, which does
    /// not count.
    #[must_use]
    pub fn finish(&self, startup: Duration) -> Timing {
        let wall = self.start.map_or(Duration::ZERO, |start| start.elapsed().saturating_sub(startup)).as_secs_f64();
        let span = self.last - self.first + self.period;
        Timing {
            samples: self.samples,
            compute: quantiles(&self.compute),
            stages: (self.timed > 0).then(|| {
                let mean = |stage: Stage| self.stages[stage as usize].as_nanos() as f64 / self.timed as f64;
                StageTimes {
                    twin_ns: mean(Stage::Twin),
                    observer_ns: mean(Stage::Observer),
                    forces_ns: mean(Stage::Forces),
                    comparison_ns: mean(Stage::Comparison),
                }
            }),
            sample_period_ns: (self.period * 1e9).round() as u64,
            wall_s: wall,
            diagnosis_s: self.diagnosis.as_secs_f64(),
            times_real_time: span / wall.max(1e-9),
            peak_memory_bytes: peak_memory(),
            ..Timing::default()
        }
    }
}

/// Returns a duration in whole nanoseconds, at least 1.
#[must_use]
pub fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX).max(1)
}

/// Returns the quantiles of a histogram of nanoseconds.
#[must_use]
pub fn quantiles(histogram: &Histogram<u64>) -> Quantiles {
    Quantiles {
        p50_ns: histogram.value_at_quantile(0.5),
        p99_ns: histogram.value_at_quantile(0.99),
        p999_ns: histogram.value_at_quantile(0.999),
        max_ns: histogram.max(),
    }
}

/// Returns the peak resident memory of this process from the Linux status file; none on other systems.
#[must_use]
pub(crate) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024)
}
