//! Detection of the instants at which a keyphasor pulse begins.

/// Half the hysteresis, in parts of the way between the levels: 20 % in all.
const HYSTERESIS: f64 = 0.1;

/// Beginnings of pulses that the levels are judged by while more may come.
const ENOUGH: usize = 10;

/// The same at the end of a recording.
const FEW: usize = 3;

/// Largest share of readings at either end that may be spikes. A pulse is longer: one sample in 256 at least.
const SPIKES: f64 = 1.0 / 512.0;

/// Share of samples half way between the levels from which on there are no levels: noise has most of its
/// samples there, a sine a quarter.
const BETWEEN: f64 = 0.35;

/// Share of samples on the upper level from which on the pulses are those to the lower one.
const MOSTLY_HIGH: f64 = 0.55;

/// Largest number of samples of a pulse at the start of the recording that counts: the begin of a longer one is unknown.
const NARROW: u64 = 2;

/// An instant in samples since the recording began. The whole number is apart so that it stays exact in
/// recordings of any length.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Instant {
    pub(super) index: u64,
    pub(super) fraction: f64,
}

impl Instant {
    /// Data of a sample.
    pub(super) const fn sample(index: u64) -> Self {
        Self { index, fraction: 0.0 }
    }

    /// Samples since `earlier`.
    pub(super) fn since(self, earlier: Self) -> f64 {
        self.index.wrapping_sub(earlier.index) as i64 as f64 + (self.fraction - earlier.fraction)
    }
}

/// The two levels of the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Levels {
    threshold: f64,
    /// Scales readings to -0.5 (rest) to 0.5 (pulse).
    scale: f64,
}

impl Levels {
    /// Finds the levels in the first samples; none as long as they do not show clearly. At the `end` of the
    /// recording one change of level has to do.
    ///
    /// Spikes beyond the levels hide them: where all readings show no even pulses, those without the few lowest and highest
    /// may, up to [`SPIKES`] of them.
    pub(super) fn learn(readings: impl Iterator<Item = f64> + Clone, end: bool) -> Option<Self> {
        let mut sorted: Vec<f64> = readings.clone().filter(|reading| !reading.is_nan()).collect();
        sorted.sort_by(f64::total_cmp);
        let trimmed = |spikes: usize| {
            let last = sorted.len().checked_sub(1 + spikes)?;
            Some((*sorted.get(spikes)?, *sorted.get(last)?))
        };
        let most = (sorted.len() as f64 * SPIKES) as usize;
        let spikes = std::iter::once(0).chain((0..).map(|k| 1 << k)).take_while(|spikes| *spikes <= most);
        let least = if end { FEW } else { ENOUGH };
        let even = spikes.filter_map(trimmed).find_map(|range| {
            Self::between(range, readings.clone()).filter(|levels| levels.show(readings.clone(), least))
        });
        let all = || trimmed(0).and_then(|range| Self::between(range, readings.clone()));
        even.or_else(|| if end { all() } else { None })
    }

    /// From the lowest and the highest level; none where too many samples are between them.
    fn between((low, high): (f64, f64), readings: impl Iterator<Item = f64>) -> Option<Self> {
        if low >= high {
            return None;
        }
        let levels = Self { threshold: 0.5 * (low + high), scale: 1.0 / (high - low) };
        let (mut known, mut between, mut upper) = (0_u64, 0_u64, 0_u64);
        for value in readings.map(|reading| levels.value(reading)).filter(|value| !value.is_nan()) {
            known += 1;
            between += u64::from(value.abs() < 0.2);
            upper += u64::from(value >= 0.0);
        }
        if between as f64 > BETWEEN * known as f64 {
            return None;
        }
        let inverted = upper as f64 > MOSTLY_HIGH * known as f64;
        Some(if inverted { Self { scale: -levels.scale, ..levels } } else { levels })
    }

    /// The reading is farther beyond a level than half the way between the two.
    pub(super) fn is_spike(self, reading: f64) -> bool {
        self.value(reading).abs() > 1.0
    }

    /// -0.5 at rest to 0.5 in a pulse.
    fn value(self, reading: f64) -> f64 {
        (reading - self.threshold) * self.scale
    }

    /// There are at least so many pulses, and they come evenly: the flicker of a signal's last digit does not.
    fn show(self, readings: impl Iterator<Item = f64>, least: usize) -> bool {
        let mut edges = Edges::new(self);
        let readings = readings.map(|reading| if self.is_spike(reading) { f64::NAN } else { reading });
        let found = readings.zip(0..).filter_map(|(reading, index)| edges.see(index, reading));
        let starts: Vec<Instant> = found.collect();
        let intervals: Vec<f64> = starts.windows(2).map(|pair| pair[1].since(pair[0])).collect();
        let uneven = intervals.windows(2).filter(|pair| pair[1] < 0.6 * pair[0] || pair[1] > 1.6 * pair[0]).count();
        starts.len() >= least && uneven * 5 <= intervals.len()
    }
}

/// Lowest and highest reading, NaN left out.
pub(super) fn range(readings: impl Iterator<Item = f64>) -> (f64, f64) {
    readings.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), reading| (low.min(reading), high.max(reading)))
}

/// Finds the beginnings of pulses, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Edges {
    levels: Levels,
    /// Last sample that has a reading.
    last: Option<(u64, f64)>,
    in_pulse: bool,
    /// Where the signal came up to the threshold, until it is clear that it goes on up.
    crossing: Option<Instant>,
    /// First sample, while the pulse that the recording begins in lasts.
    began_in_pulse: Option<u64>,
}

impl Edges {
    pub(super) const fn new(levels: Levels) -> Self {
        Self { levels, last: None, in_pulse: false, crossing: None, began_in_pulse: None }
    }

    /// Adds a sample; returns the instant at which a pulse began as soon as it is certain.
    pub(super) fn see(&mut self, index: u64, reading: f64) -> Option<Instant> {
        let value = self.levels.value(reading);
        if value.is_nan() {
            return None;
        }
        let Some(last) = self.last.replace((index, value)) else {
            self.in_pulse = value >= 0.0;
            self.began_in_pulse = self.in_pulse.then_some(index);
            return None;
        };
        if self.in_pulse { self.leave(index, value) } else { self.enter(last, index, value) }
    }

    fn leave(&mut self, index: u64, value: f64) -> Option<Instant> {
        if value >= -HYSTERESIS {
            return None;
        }
        self.in_pulse = false;
        let first = self.began_in_pulse.take()?;
        // Half a sample before the first one inside, as for every other pulse of one step.
        (index - first <= NARROW).then_some(Instant { index: first, fraction: -0.5 })
    }

    fn enter(&mut self, last: (u64, f64), index: u64, value: f64) -> Option<Instant> {
        if value < 0.0 {
            self.crossing = None;
            return None;
        }
        // Where samples are missing right at the edge, its instant is unknown: such a pulse is a missed one.
        if last.1 < 0.0 && last.0 + 1 == index {
            let fraction = last.1 / (last.1 - value);
            self.crossing = Some(Instant { index: last.0, fraction });
        }
        if value < HYSTERESIS {
            return None;
        }
        self.in_pulse = true;
        self.crossing.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starts(readings: &[f64]) -> Vec<f64> {
        let Some(levels) = Levels::learn(readings.iter().copied(), true) else { return Vec::new() };
        let mut edges = Edges::new(levels);
        let found = readings.iter().zip(0..).filter_map(|(reading, index)| edges.see(index, *reading));
        found.map(|instant| instant.since(Instant::sample(0))).collect()
    }

    #[test]
    fn steps_cross_half_a_sample_before() {
        assert_eq!(starts(&[0., 0., 1., 0., 0., 1., 1., 0.]), [1.5, 4.5]);
        assert_eq!(starts(&[1., 1., 0., 0., 0., 1., 0., 0.]), [-0.5, 4.5]);
        assert_eq!(starts(&[1., 1., 1., 0., 0., 0., 0., 0., 0., 1., 0.]), [8.5]);
        assert_eq!(starts(&[5., 5., 0., 5., 5., 5., 0., 0., 5.]), [1.5, 5.5]);
    }

    #[test]
    fn slopes_noise_and_holes() {
        assert_eq!(starts(&[-24., -24., -18., -6., 0., 0., -24., -24., -24., -24.]), [2.5]);
        // Noise about the threshold is no second pulse.
        let noisy = [-24., -24., -12.2, -11.8, -12.2, -11.0, 0., -11.5, 0., -24., -24., -24., -24., -24., -24.];
        assert_eq!(starts(&noisy).len(), 1);
        assert_eq!(starts(&[0., 0., f64::NAN, 1., 0., 0., 0., 1., 0.]), [6.5]);
    }

    #[test]
    fn flicker_and_noise_are_no_pulses() {
        let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761).rotate_left(15).wrapping_mul(2_246_822_519) >> 16);
        let bell = (0..4096_u32).map(|i| (0..6).map(|k| noise(i * 6 + k)).sum::<f64>());
        assert_eq!(Levels::learn(bell, false), None);
        let flicker = (0..4096_u32).map(|i| if noise(i / 7) > 40_000.0 { 1.0 } else { 0.0 });
        assert_eq!(Levels::learn(flicker, false), None);
        assert_eq!(Levels::learn([f64::NAN, 3.0, 3.0].into_iter(), true), None);
        let sine = (0..4096_u32).map(|i| (f64::from(i) * 0.05).sin());
        assert!(Levels::learn(sine, false).is_some());
    }
}
