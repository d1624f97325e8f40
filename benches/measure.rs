//! Timing in rounds: in each round every subject has its turn, so all of them meet the same disturbances. Processor time is measured, so that
//! waiting beside other work does not count.

use crate::subjects::Subject;
#[cfg(unix)]
use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;

/// Rounds; odd, so that the median is one of them.
pub const ROUNDS: usize = 301;
/// Duration of one round: far above the clock's resolution, far below a time slice.
const TURN: Duration = Duration::from_micros(100);

/// Time of a call of each subject in each round, ns.
pub struct Times(Vec<Vec<f64>>);

/// Measures them all, some seconds long.
pub fn times(subjects: &mut [Subject]) -> Times {
    let runs: Vec<u32> = subjects.iter_mut().map(runs_a_turn).collect();
    let mut times = vec![Vec::with_capacity(ROUNDS); subjects.len()];
    for _ in 0..ROUNDS {
        for ((subject, &runs), times) in subjects.iter_mut().zip(&runs).zip(&mut times) {
            times.push(turn(subject, runs).as_secs_f64() * 1e9 / f64::from(runs * subject.calls));
        }
    }
    Times(times)
}

impl Times {
    /// Median time of subject `index`, ns.
    pub fn median(&self, index: usize) -> Option<f64> {
        median(self.0.get(index)?.clone())
    }

    /// Median of the ratios of two subjects, each ratio taken within a round.
    pub fn ratio(&self, numerator: usize, denominator: usize) -> Option<f64> {
        let (above, below) = (self.0.get(numerator)?, self.0.get(denominator)?);
        median(above.iter().zip(below).map(|(a, b)| a / b).collect())
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Returns the processor time of some runs: that of this thread, or what another process reports.
fn turn(subject: &mut Subject, runs: u32) -> Duration {
    let start = processor_time();
    let mut reported = Duration::ZERO;
    for _ in 0..runs {
        reported += (subject.run)().unwrap_or_default();
    }
    if reported.is_zero() { processor_time().saturating_sub(start) } else { reported }
}

/// Returns the processor time of this thread.
#[cfg(unix)]
fn processor_time() -> Duration {
    Duration::try_from(clock_gettime(ClockId::ThreadCPUTime)).unwrap_or_default()
}

/// Returns the time since the first call, where the system has no clock of the processor time.
#[cfg(not(unix))]
fn processor_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// Runs that fill a turn, found by doubling, which warms up as well.
fn runs_a_turn(subject: &mut Subject) -> u32 {
    let mut runs = 1;
    while turn(subject, runs) < TURN && runs < 1 << 20 {
        runs *= 2;
    }
    runs
}
