//! Detection of the instants at which a keyphasor pulse begins.

use ballrace_scene::{PulseDetection, Slope};
use std::fmt;

/// Least and largest half of a hysteresis that is found from the signal, in parts of the way between the levels.
const HYSTERESIS: (f64, f64) = (0.1, 0.3);

/// Half of the hysteresis in standard deviations of the noise: a reading beyond the band falls back through all of it by noise
/// once in 1e5 samples.
const NOISE_MULTIPLE: f64 = 3.0;

/// Distances in samples of the second differences that measure the noise: neighbours, and farther for a recorder whose filter
/// makes neighbours alike.
const NOISE_DISTANCES: [usize; 2] = [1, 4];

/// Least number of samples within the hysteresis for a line through them.
const LINE: f64 = 4.0;

/// Share of the deviation of one pulse by which the levels follow it, and the largest step in parts of the way between them: a spike
/// moves them little.
const FOLLOW: (f64, f64) = (0.5, 0.05);

/// Heights of a pulse in parts of that between the levels which they follow.
const HEIGHTS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// Beginnings of pulses from which the levels are checked before the signal ends.
const ENOUGH: usize = 10;

/// Beginnings of pulses from which the levels are checked at the end of a recording.
const FEW: usize = 3;

/// Beginnings of pulses from which the levels are checked after the signal has left its levels.
const AGAIN: usize = 4;

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
    /// Returns the instant of a sample.
    pub(super) const fn sample(index: u64) -> Self {
        Self { index, fraction: 0.0 }
    }

    /// Returns the number of samples since `earlier`.
    pub(super) fn since(self, earlier: Self) -> f64 {
        self.index.wrapping_sub(earlier.index) as i64 as f64 + (self.fraction - earlier.fraction)
    }
}

/// The two levels of the signal, and the band between them that a pulse has to cross.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Levels {
    threshold: f64,
    /// Half way between the levels.
    middle: f64,
    /// Scales readings to -0.5 (rest) to 0.5 (pulse).
    scale: f64,
    /// Half the hysteresis in parts of the way between the levels.
    half_band: f64,
    /// The threshold is that of the scene.
    is_given: bool,
}

impl Levels {
    /// Finds the levels in the first samples; none as long as they do not show clearly. At the `end` of the
    /// recording one change of level is sufficient. The pulses of a wheel with a gap may have one interval of `gap` others in a turn.
    ///
    /// Spikes beyond the levels hide them: where all readings show no even pulses, those without the few lowest and highest
    /// may, up to [`SPIKES`] of them.
    pub(super) fn learn(
        readings: impl Iterator<Item = f64> + Clone,
        given: &PulseDetection,
        gap: f64,
        end: bool,
    ) -> Option<Self> {
        let mut sorted: Vec<f64> = readings.clone().filter(|reading| !reading.is_nan()).collect();
        let noise = noise(&sorted);
        sorted.sort_by(f64::total_cmp);
        let trimmed = |spikes: usize| {
            let last = sorted.len().checked_sub(1 + spikes)?;
            Some((*sorted.get(spikes)?, *sorted.get(last)?))
        };
        let most = (sorted.len() as f64 * SPIKES) as usize;
        let spikes = std::iter::once(0).chain((0..).map(|k| 1 << k)).take_while(|spikes| *spikes <= most);
        let least = if end { FEW } else { ENOUGH };
        let between = |range| Self::between(range, noise, given, readings.clone());
        let even = spikes
            .filter_map(trimmed)
            .find_map(|range| between(range).filter(|levels| levels.show(readings.clone(), least, gap)));
        let all = || trimmed(0).and_then(between);
        even.or_else(|| if end { all() } else { None })
    }

    /// Finds the levels after the signal has left its earlier ones; the pulses have about their earlier `height`.
    pub(super) fn learn_again(
        readings: impl Iterator<Item = f64> + Clone,
        given: &PulseDetection,
        gap: f64,
        height: f64,
    ) -> Option<Self> {
        let known = || readings.clone().filter(|reading| !reading.is_nan());
        let (low, high) = range(known());
        let noise = noise(&known().collect::<Vec<_>>());
        let levels = Self::between((low, high), noise, given, readings.clone())?;
        (HEIGHTS.contains(&((high - low) / height)) && levels.show(readings, AGAIN, gap)).then_some(levels)
    }

    /// Creates the levels from the lowest and the highest one; `None` where too many samples are between them, or where the threshold
    /// of the scene is not between them.
    fn between(
        (low, high): (f64, f64),
        noise: f64,
        given: &PulseDetection,
        readings: impl Iterator<Item = f64>,
    ) -> Option<Self> {
        let (height, middle) = (high - low, 0.5 * (low + high));
        let threshold = given.threshold.unwrap_or(middle);
        if low >= high || threshold <= low || threshold >= high {
            return None;
        }
        let (least, most) = HYSTERESIS;
        // A threshold near a level leaves less room.
        let room = 1.6 * (threshold - low).min(high - threshold) / height;
        let found = (NOISE_MULTIPLE * noise / height).clamp(least, most).min(0.5 * room);
        let half_band = given.hysteresis.map_or(found, |width| 0.5 * width / height);
        let is_given = given.threshold.is_some();
        let levels = Self { threshold, middle, scale: 1.0 / height, half_band, is_given };
        let (mut known, mut between, mut upper) = (0_u64, 0_u64, 0_u64);
        for value in readings.map(|reading| (reading - middle) / height).filter(|value| !value.is_nan()) {
            known += 1;
            between += u64::from(value.abs() < 0.2);
            upper += u64::from(value >= 0.0);
        }
        if !is_given && between as f64 > BETWEEN * known as f64 {
            return None;
        }
        let is_falling = match given.slope {
            Some(slope) => slope == Slope::Falling,
            None => upper as f64 > MOSTLY_HIGH * known as f64,
        };
        Some(if is_falling { Self { scale: -levels.scale, ..levels } } else { levels })
    }

    /// Returns true for a reading farther beyond a level than half the distance between the two.
    pub(super) fn is_spike(self, reading: f64) -> bool {
        ((reading - self.middle) * self.scale).abs() > 1.0
    }

    /// Returns the scaled distance of a reading from the threshold: below 0 at rest, above 0 in a pulse.
    fn value(self, reading: f64) -> f64 {
        (reading - self.threshold) * self.scale
    }

    /// Follows the lowest and the highest reading of a pulse. The hysteresis keeps its width; so does a threshold of the scene.
    fn follow(&mut self, (low, high): (f64, f64)) {
        let height = 1.0 / self.scale.abs();
        if !HEIGHTS.contains(&((high - low) / height)) {
            return;
        }
        let (share, most) = FOLLOW;
        let step = |deviation: f64| (share * deviation).clamp(-most * height, most * height);
        let grown = height + step(high - low - height);
        self.middle += step(0.5 * (low + high) - self.middle);
        self.half_band *= height / grown;
        self.scale = self.scale.signum() / grown;
        if !self.is_given {
            self.threshold = self.middle;
        }
    }

    /// Returns true for enough pulses at even intervals: the flicker of a signal's last digit does not.
    fn show(self, readings: impl Iterator<Item = f64>, least: usize, gap: f64) -> bool {
        let mut edges = Edges::new(self);
        let readings = readings.map(|reading| if self.is_spike(reading) { f64::NAN } else { reading });
        let found = readings.zip(0..).filter_map(|(reading, index)| edges.see(index, reading));
        let starts: Vec<Instant> = found.collect();
        let intervals: Vec<f64> = starts.windows(2).map(|pair| pair[1].since(pair[0])).collect();
        let is_even = |ratio: f64| (0.6..=1.6).contains(&ratio);
        let uneven = intervals.windows(2).filter(|pair| {
            let ratio = pair[1] / pair[0];
            !is_even(ratio) && !is_even(ratio / gap) && !is_even(ratio * gap)
        });
        starts.len() >= least && uneven.count() * 5 <= intervals.len()
    }
}

/// Returns the standard deviation of the noise of readings from the median of their second differences, which the slopes of
/// rare pulses do not reach.
fn noise(readings: &[f64]) -> f64 {
    let of = |distance: usize| {
        let triples = readings.iter().zip(readings.iter().skip(distance)).zip(readings.iter().skip(2 * distance));
        let mut differences: Vec<f64> = triples.map(|((a, b), c)| (a - 2.0 * b + c).abs()).collect();
        let middle = differences.len() / 2;
        if differences.is_empty() {
            return 0.0;
        }
        // The median of |x| of a normal distribution is 0.6745 of its standard deviation; three readings add to the square root of 6.
        *differences.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.6745 * 6_f64.sqrt())
    };
    NOISE_DISTANCES.into_iter().map(of).fold(0.0, f64::max)
}

/// Threshold of a keyphasor as it was used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UsedThreshold {
    /// Lowest and highest threshold: it follows the levels.
    pub(super) range: (f64, f64),
    /// Full width.
    pub(super) hysteresis: f64,
    pub(super) slope: Slope,
    /// Unit of both with a space before it; empty for a column without one.
    pub(super) unit: &'static str,
}

/// Returns the lowest and the highest reading; NaN is ignored.
pub(super) fn range(readings: impl Iterator<Item = f64>) -> (f64, f64) {
    readings.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), reading| (low.min(reading), high.max(reading)))
}

impl fmt::Display for UsedThreshold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = self.range;
        let slope = match self.slope {
            Slope::Rising => "rising",
            Slope::Falling => "falling",
        };
        let unit = self.unit;
        write!(f, "{slope} through {}{unit}", short(0.5 * (low + high)))?;
        // A threshold that follows noise moves less than the hysteresis.
        if high - low > self.hysteresis {
            write!(f, " ({} to {}{unit})", short(low), short(high))?;
        }
        write!(f, ", hysteresis {}{unit}", short(self.hysteresis))
    }
}

/// Returns a number with four digits.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Finds the beginnings of pulses, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Edges {
    levels: Levels,
    /// Lowest and highest threshold so far.
    thresholds: (f64, f64),
    /// Lowest and highest reading since the last pulse began, without spikes; none before the first.
    cycle: Option<(f64, f64)>,
    /// Last sample that has a reading, and its reading.
    last: Option<(u64, f64)>,
    in_pulse: bool,
    /// Crossing of the threshold that is not confirmed yet.
    crossing: Option<Instant>,
    /// Samples within the hysteresis on the way up.
    slope: SlopeSums,
    /// First sample, while the pulse that the recording begins in lasts.
    began_in_pulse: Option<u64>,
}

impl Edges {
    pub(super) fn new(levels: Levels) -> Self {
        Self {
            levels,
            thresholds: (levels.threshold, levels.threshold),
            cycle: None,
            last: None,
            in_pulse: false,
            crossing: None,
            slope: SlopeSums::default(),
            began_in_pulse: None,
        }
    }

    /// Returns the height of a pulse.
    pub(super) fn height(&self) -> f64 {
        1.0 / self.levels.scale.abs()
    }

    /// Continues with other levels.
    pub(super) fn continue_with(&mut self, levels: Levels) {
        let (low, high) = self.thresholds;
        let thresholds = (low.min(levels.threshold), high.max(levels.threshold));
        *self = Self { thresholds, ..Self::new(levels) };
    }

    /// Returns the threshold as it was used so far.
    pub(super) fn used(&self, given: &PulseDetection) -> UsedThreshold {
        let levels = &self.levels;
        UsedThreshold {
            range: self.thresholds,
            hysteresis: 2.0 * levels.half_band / levels.scale.abs(),
            slope: if levels.scale > 0.0 { Slope::Rising } else { Slope::Falling },
            unit: if given.volts_per_unit.is_some() { " V" } else { "" },
        }
    }

    /// Adds a sample; returns the instant at which a pulse began as soon as it is certain.
    pub(super) fn see(&mut self, index: u64, reading: f64) -> Option<Instant> {
        let value = self.levels.value(reading);
        if value.is_nan() {
            return None;
        }
        if let Some((low, high)) = self.cycle.as_mut().filter(|_| !self.levels.is_spike(reading)) {
            (*low, *high) = (low.min(reading), high.max(reading));
        }
        let Some((last_index, last_reading)) = self.last.replace((index, reading)) else {
            self.in_pulse = value >= 0.0;
            self.began_in_pulse = self.in_pulse.then_some(index);
            return None;
        };
        if self.in_pulse {
            return self.leave(index, value);
        }
        let begun = self.enter((last_index, self.levels.value(last_reading)), index, value);
        if self.in_pulse {
            self.follow(reading);
        }
        begun
    }

    /// Follows the levels at the beginning of a pulse.
    fn follow(&mut self, reading: f64) {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        let first = if self.levels.is_spike(reading) { nothing } else { (reading, reading) };
        if let Some(cycle) = self.cycle.replace(first) {
            self.levels.follow(cycle);
            let (low, high) = self.thresholds;
            self.thresholds = (low.min(self.levels.threshold), high.max(self.levels.threshold));
        }
    }

    fn leave(&mut self, index: u64, value: f64) -> Option<Instant> {
        if value >= -self.levels.half_band {
            return None;
        }
        self.in_pulse = false;
        let first = self.began_in_pulse.take()?;
        // Half a sample before the first one inside, as for every other pulse of one step.
        (index - first <= NARROW).then_some(Instant { index: first, fraction: -0.5 })
    }

    fn enter(&mut self, last: (u64, f64), index: u64, value: f64) -> Option<Instant> {
        let half_band = self.levels.half_band;
        if value < 0.0 {
            self.crossing = None;
        }
        if value < -half_band {
            self.slope = SlopeSums::default();
            return None;
        }
        // Where samples are missing right at the edge, its instant is unknown: such a pulse is a missed one.
        if last.1 < 0.0 && value >= 0.0 && last.0 + 1 == index {
            let fraction = last.1 / (last.1 - value);
            self.crossing = Some(Instant { index: last.0, fraction });
        }
        if value < half_band {
            self.slope.add(index, value);
            return None;
        }
        self.in_pulse = true;
        let crossing = self.crossing.take();
        let slope = std::mem::take(&mut self.slope);
        crossing.map(|crossing| slope.zero(index).unwrap_or(crossing))
    }
}

/// Sums of a line through the samples within the hysteresis, from the first of them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct SlopeSums {
    first: u64,
    count: f64,
    x: f64,
    xx: f64,
    y: f64,
    xy: f64,
}

impl SlopeSums {
    fn add(&mut self, index: u64, value: f64) {
        if self.count == 0.0 {
            self.first = index;
        }
        let x = (index - self.first) as f64;
        self.count += 1.0;
        self.x += x;
        self.xx += x * x;
        self.y += value;
        self.xy += x * value;
    }

    /// Returns where the line passes 0, before sample `end`; none through too few samples, or where that is not among them.
    fn zero(&self, end: u64) -> Option<Instant> {
        if self.count < LINE {
            return None;
        }
        let slope = (self.count * self.xy - self.x * self.y) / (self.count * self.xx - self.x * self.x);
        let zero = (self.x - self.y / slope) / self.count;
        let width = (end - self.first) as f64;
        // A position beyond the samples, or none at all, fails the comparison.
        (slope > 0.0 && zero >= -1.0 && zero <= width).then(|| {
            let whole = zero.floor().max(0.0);
            Instant { index: self.first + whole as u64, fraction: zero - whole }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starts(readings: &[f64]) -> Vec<f64> {
        let Some(levels) = Levels::learn(readings.iter().copied(), &PulseDetection::default(), 1.0, true) else {
            return Vec::new();
        };
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
        let learn =
            |readings: Vec<f64>, end: bool| Levels::learn(readings.into_iter(), &PulseDetection::default(), 1.0, end);
        assert_eq!(learn(bell.collect(), false), None);
        let flicker = (0..4096_u32).map(|i| if noise(i / 7) > 40_000.0 { 1.0 } else { 0.0 });
        assert_eq!(learn(flicker.collect(), false), None);
        assert_eq!(learn(vec![f64::NAN, 3.0, 3.0], true), None);
        let sine = (0..4096_u32).map(|i| (f64::from(i) * 0.05).sin());
        assert!(learn(sine.collect(), false).is_some());
    }
}
