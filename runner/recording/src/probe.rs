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

/// Number of highest (or lowest) readings whose samples are counted: the extreme one and two groups of three below it.
const LEVELS: usize = 7;

/// Smallest ratio of the number of samples at the extreme reading to that at the next where noise makes the numbers fall towards
/// the extreme: without clipping the extreme has the fewest.
const CLIPPED_NOISE_RATIO: u64 = 2;

/// Smallest difference of the two numbers, in standard deviations of counts.
const CLIPPED_DEVIATIONS: f64 = 4.0;

/// Largest ratio of the numbers of samples in the two groups. A waveform turns slowly: a sine without noise has 1.55 where as many
/// samples are at its extreme reading.
const GROUP_RATIO: f64 = 1.1;

/// Largest relative difference between adjacent steps of a converter.
const STEP_TOLERANCE: f64 = 1e-3;

/// Classification of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ReadingState {
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
pub(crate) struct ProbeWatch {
    limit: u64,
    reading: f64,
    run: u64,
    since: Position,
    highest: Extreme,
    lowest: Extreme,
}

/// Samples at the highest readings, after multiplication with `sign`.
#[derive(Debug, Clone, PartialEq)]
struct Extreme {
    sign: f64,
    /// Readings with their number of samples, the highest first.
    levels: [(f64, u64); LEVELS],
    /// First sample at the highest reading.
    first: Position,
}

/// Samples exactly at the highest or lowest reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Clipped {
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
        let highest = self.highest.clipped(-self.lowest.level());
        let lowest = self.lowest.clipped(-self.highest.level());
        [highest, lowest].into_iter().flatten()
    }
}

impl Extreme {
    fn new(sign: f64) -> Self {
        Self { sign, levels: [(f64::NEG_INFINITY, 0); LEVELS], first: Position::default() }
    }

    fn level(&self) -> f64 {
        self.levels.first().map_or(f64::NEG_INFINITY, |(level, _)| *level)
    }

    fn see(&mut self, reading: f64, at: Position) {
        let reading = self.sign * reading;
        if self.levels.last().is_some_and(|(level, _)| reading < *level) {
            return;
        }
        let Some(place) = self.levels.iter().position(|(level, _)| reading >= *level) else { return };
        let Some(from) = self.levels.get_mut(place..) else { return };
        if let [(level, count), ..] = from
            && *level == reading
        {
            *count += 1;
            return;
        }
        from.rotate_right(1);
        if let [first, ..] = from {
            *first = (reading, 1);
        }
        if place == 0 {
            self.first = at;
        }
    }

    fn forget(&mut self, reading: f64, samples: u64) {
        let reading = self.sign * reading;
        for (_, count) in self.levels.iter_mut().filter(|(level, _)| *level == reading) {
            *count = count.saturating_sub(samples);
        }
    }

    /// Returns the level where it is clipped. `opposite` is the other extreme, times the sign of this one. A signal of two levels is
    /// coarse, not clipped.
    fn clipped(&self, opposite: f64) -> Option<Clipped> {
        let [(level, samples), (next_level, next), ..] = self.levels;
        let is_peak = samples >= CLIPPED_RATIO * next || self.is_peak_above_noise(opposite);
        let is_clipped = samples >= CLIPPED_SAMPLES && is_peak && next_level > opposite;
        is_clipped.then_some(Clipped { reading: self.sign * level, samples, first: self.first })
    }

    /// Returns true where many samples are at the highest of adjacent levels and their numbers do not rise towards it.
    fn is_peak_above_noise(&self, opposite: f64) -> bool {
        let [(first, extreme), (second, next), (third, b), (_, c), (_, d), (_, e), (last, f)] = self.levels;
        let step = second - third;
        let mut steps = self.levels.windows(2).skip(1).map(|pair| match pair {
            [(upper, _), (lower, _)] => upper - lower,
            _ => f64::NAN,
        });
        let are_adjacent = step.is_finite()
            && steps.all(|own| (own - step).abs() <= STEP_TOLERANCE * step)
            && first - second <= (1.0 + STEP_TOLERANCE) * step;
        let is_upper_half = last > (first + opposite) / 2.0;
        let rise = extreme.saturating_sub(next) as f64;
        are_adjacent
            && is_upper_half
            && extreme >= CLIPPED_NOISE_RATIO * next
            && rise > CLIPPED_DEVIATIONS * ((extreme + next) as f64).sqrt()
            && (next + b + c) as f64 <= GROUP_RATIO * (d + e + f) as f64
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
        for steps in [2.0, 3.0, 3.49, 10.0, 10.45, 127.0, 127.49] {
            let (coarse, _) = watch((0..20_000).map(|i| (sine(i) * steps).round()));
            assert_eq!(coarse.clipped().count(), 0, "{steps}");
        }
    }

    #[test]
    fn clipped_coarse_signal_with_noise() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut noise = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        for (amplitude, deviation) in [(15.0, 8.0), (40.0, 3.0), (100.0, 5.0), (0.0, 10.0)] {
            let mut signal: Vec<f64> = (0..12_800_i32).map(|i| f64::from(i) * 0.123).collect();
            signal.iter_mut().for_each(|x| *x = (amplitude * x.sin() + deviation * noise()).round());
            let mut sorted = signal.clone();
            sorted.sort_by(f64::total_cmp);
            let rail = sorted[12_800 * 97 / 100];
            let (whole, _) = watch(signal.iter().copied());
            assert_eq!(whole.clipped().count(), 0, "{amplitude} {deviation}");
            for sign in [1.0, -1.0] {
                let (clipped, _) = watch(signal.iter().map(|x| sign * x.min(rail)));
                let found: Vec<_> = clipped.clipped().collect();
                assert_eq!(found.len(), 1, "{amplitude} {deviation}");
                assert!(found[0].reading == sign * rail && found[0].samples > 12_800 * 3 / 100, "{found:?}");
            }
        }
    }
}
