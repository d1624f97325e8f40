//! Detection of stuck and clipped probes.

use super::flaws::Position;

/// Smallest number of consecutive, exactly equal readings of a stuck probe.
const STUCK_SAMPLES: u64 = 64;

/// Shortest duration of the equal readings of a stuck probe, s. The coarse readings of a slow machine in a fast recorder
/// stay constant for shorter times.
const STUCK_TIME: f64 = 0.01;

/// Smallest number of samples of a clipped probe exactly at its highest (or lowest) reading.
const CLIPPED_SAMPLES: u64 = 32;

/// Smallest ratio of that number to the number of samples at the next reading. A sine in coarse steps has a ratio of 1.4.
const CLIPPED_RATIO: u64 = 8;

/// Classification of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadingState {
    /// The reading is valid.
    Good,
    /// The probe is stuck from this reading on; the run began earlier.
    Stuck {
        /// First sample of the run.
        since: Position,
        /// Samples so far, this one among them.
        samples: u64,
    },
    /// The probe is still stuck.
    StillStuck,
}

/// State of the detection for one probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeWatch {
    limit: u64,
    reading: f64,
    run: u64,
    since: Position,
    highest: Extreme,
    lowest: Extreme,
}

/// Samples at the highest reading and at the one next to it, after multiplication with `sign`.
#[derive(Debug, Clone, PartialEq)]
struct Extreme {
    sign: f64,
    level: f64,
    count: u64,
    first: Position,
    next_level: f64,
    next_count: u64,
}

/// Samples exactly at the highest or lowest reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipped {
    /// Reading at which the probe is clipped, m.
    pub reading: f64,
    /// Number of samples.
    pub samples: u64,
    /// The first of them.
    pub first: Position,
}

impl ProbeWatch {
    /// Creates the detection for a probe sampled at `rate`, Hz.
    #[must_use]
    pub fn new(rate: f64) -> Self {
        Self {
            limit: STUCK_SAMPLES.max((STUCK_TIME * rate).ceil() as u64),
            reading: f64::NAN,
            run: 0,
            since: Position::default(),
            highest: Extreme::new(1.0),
            lowest: Extreme::new(-1.0),
        }
    }

    /// Adds a reading (m), which is not NaN, and returns its state. A missing reading is not added and does not end a run.
    pub fn see(&mut self, reading: f64, at: Position) -> ReadingState {
        if reading == self.reading {
            self.run += 1;
        } else {
            self.reading = reading;
            self.run = 1;
            self.since = at;
        }
        if self.run > self.limit {
            return ReadingState::StillStuck;
        }
        if self.run == self.limit {
            // The readings of a stuck probe do not count as clipped.
            self.highest.forget(reading, self.run - 1);
            self.lowest.forget(reading, self.run - 1);
            return ReadingState::Stuck { since: self.since, samples: self.run };
        }
        self.highest.see(reading, at);
        self.lowest.see(reading, at);
        ReadingState::Good
    }

    /// Returns the levels at which the probe is clipped, from all readings so far.
    pub fn clipped(&self) -> impl Iterator<Item = Clipped> {
        let highest = self.highest.clipped(-self.lowest.level);
        let lowest = self.lowest.clipped(-self.highest.level);
        [highest, lowest].into_iter().flatten()
    }
}

impl Extreme {
    fn new(sign: f64) -> Self {
        let (level, next_level) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        Self { sign, level, count: 0, first: Position::default(), next_level, next_count: 0 }
    }

    fn see(&mut self, reading: f64, at: Position) {
        let reading = self.sign * reading;
        if reading < self.next_level {
            return;
        }
        if reading > self.level {
            (self.next_level, self.next_count) = (self.level, self.count);
            (self.level, self.count, self.first) = (reading, 1, at);
        } else if reading == self.level {
            self.count += 1;
        } else if reading == self.next_level {
            self.next_count += 1;
        } else {
            (self.next_level, self.next_count) = (reading, 1);
        }
    }

    fn forget(&mut self, reading: f64, samples: u64) {
        let reading = self.sign * reading;
        if reading == self.level {
            self.count = self.count.saturating_sub(samples);
        } else if reading == self.next_level {
            self.next_count = self.next_count.saturating_sub(samples);
        }
    }

    /// Returns the level where it is clipped. `opposite` is the other extreme, times the sign of this one. A signal of two levels is
    /// coarse, not clipped.
    fn clipped(&self, opposite: f64) -> Option<Clipped> {
        let many = self.count >= CLIPPED_SAMPLES && self.count >= CLIPPED_RATIO * self.next_count;
        let varies = self.next_level > opposite;
        (many && varies).then_some(Clipped { reading: self.sign * self.level, samples: self.count, first: self.first })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(index: u64) -> Position {
        Position { index, line: index + 2, time: 0.0 }
    }

    fn watch(readings: impl Iterator<Item = f64>) -> (ProbeWatch, Vec<(u64, ReadingState)>) {
        let mut watch = ProbeWatch::new(12_800.0);
        let mut verdicts = Vec::new();
        for (index, reading) in readings.enumerate() {
            let verdict = watch.see(reading, at(index as u64));
            if verdict != ReadingState::Good {
                verdicts.push((index as u64, verdict));
            }
        }
        (watch, verdicts)
    }

    #[test]
    fn stuck_after_ten_milliseconds() {
        let (watch, verdicts) = watch((0..1000).map(|i| if (100..400).contains(&i) { 9.0 } else { f64::from(i % 7) }));
        assert_eq!(verdicts.len(), 300 - 127);
        assert_eq!(verdicts[0], (227, ReadingState::Stuck { since: at(100), samples: 128 }));
        assert_eq!(verdicts[1], (228, ReadingState::StillStuck));
        assert_eq!(watch.clipped().count(), 0);
    }

    #[test]
    fn stuck_from_the_start() {
        let (_, verdicts) = watch((0..200).map(|_| 0.0));
        assert_eq!(verdicts.len(), 200 - 127);
    }

    #[test]
    fn clipped_sine_but_no_coarse_sine() {
        let sine = |i: i32| (f64::from(i) * 0.0123).sin();
        let (clipped, _) = watch((0..20_000).map(|i| (sine(i) + 1e-3 * (f64::from(i) * 12.9).sin()).min(0.9)));
        let found: Vec<_> = clipped.clipped().collect();
        assert_eq!(found.len(), 1);
        assert!(found[0].reading == 0.9 && found[0].samples > 2000);
        for steps in [2.0, 3.0, 10.0, 127.0] {
            let (coarse, _) = watch((0..20_000).map(|i| (sine(i) * steps).round()));
            assert_eq!(coarse.clipped().count(), 0, "{steps}");
        }
    }
}
