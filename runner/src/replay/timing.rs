//! The deadline ledger: compute time and lateness of every sample, in histograms of fixed size.

use super::outcome::{Quantiles, Timing};
use hdrhistogram::Histogram;
use std::time::{Duration, Instant};

/// Keeps the times of one replay.
pub struct Ledger {
    compute: Histogram<u64>,
    lateness: Histogram<u64>,
    paced: bool,
    period: f64,
    start: Instant,
    misses: u64,
    first: Option<f64>,
    last: f64,
}

impl Ledger {
    /// For a sample period in seconds.
    ///
    /// # Errors
    /// None in practice: the histogram's bounds are constants.
    pub fn try_new(period: f64, paced: bool) -> anyhow::Result<Self> {
        // 1 ns to 1000 s at three digits: 50 kB each, whatever the recording's length.
        let histogram = || Histogram::new_with_bounds(1, 1_000_000_000_000, 3);
        Ok(Self {
            compute: histogram()?,
            lateness: histogram()?,
            paced,
            period,
            start: Instant::now(),
            misses: 0,
            first: None,
            last: 0.0,
        })
    }

    /// Waits for the instant of the sample at `time` (s) when paced.
    pub fn wait(&mut self, time: f64) {
        let first = *self.first.get_or_insert_with(|| {
            self.start = Instant::now();
            time
        });
        self.last = time;
        if self.paced {
            // Absolute: an early or late wake does not shift the ones after it.
            let due = self.start + Duration::from_secs_f64((time - first).max(0.0));
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            let late = Instant::now().saturating_duration_since(due);
            self.lateness.saturating_record(nanoseconds(late));
        }
    }

    /// One sample's work, begun at `begun` and finished now.
    pub fn worked(&mut self, begun: Instant) {
        self.compute.saturating_record(nanoseconds(begun.elapsed()));
        if let (true, Some(first)) = (self.paced, self.first) {
            let next_due = Duration::from_secs_f64((self.last - first).max(0.0) + self.period);
            self.misses += u64::from(self.start.elapsed() > next_due);
        }
    }

    /// The figures.
    #[must_use]
    pub fn finish(&self) -> Timing {
        let wall = self.start.elapsed().as_secs_f64();
        let span = self.last - self.first.unwrap_or(self.last) + self.period;
        Timing {
            paced: self.paced,
            samples: self.compute.len(),
            compute: quantiles(&self.compute),
            lateness: self.paced.then(|| quantiles(&self.lateness)),
            deadline_misses: self.paced.then_some(self.misses),
            sample_period_ns: (self.period * 1e9).round() as u64,
            wall_s: wall,
            times_real_time: span / wall.max(1e-9),
            peak_memory_bytes: peak_memory(),
        }
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX).max(1)
}

fn quantiles(histogram: &Histogram<u64>) -> Quantiles {
    Quantiles {
        p50_ns: histogram.value_at_quantile(0.5),
        p99_ns: histogram.value_at_quantile(0.99),
        p999_ns: histogram.value_at_quantile(0.999),
        max_ns: histogram.max(),
    }
}

/// Peak resident memory of this process, from Linux's status file; None elsewhere.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024)
}
