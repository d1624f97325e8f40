//! Conversion of time stamps to sample numbers, by a grid that follows the clock of the recording.

use ballrace_base::printable::number;
use ballrace_base::statistics::median;
use ballrace_scene::{Clock, Recording, Scene, Speed, units};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Fewest samples in a revolution at the scene's shaft speed: 1X and a keyphasor pulse need more than two.
const MIN_PER_TURN: f64 = 4.0;
/// Highest sampling rate, Hz: ten times that of the fastest displacement probes.
const HIGHEST_RATE: f64 = 1e7;

/// Error returned for a sampling rate at which the scene's shaft cannot have been recorded.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("implausible rate at a shaft speed of {speed_rpm:.0} rpm: {} Hz, expected {} Hz to 10 MHz{hint}", number(*rate), number(*least), hint = self.hint())]
pub struct ImplausibleRate {
    /// Samples a second, averaged ones counted once, Hz.
    rate: f64,
    speed_rpm: f64,
    /// Lowest rate, Hz.
    least: f64,
    /// The scene states the rate.
    by_scene: bool,
    /// The scene states the unit of the time stamps.
    is_unit_given: bool,
}

impl ImplausibleRate {
    /// Returns the units in which the time stamps have a plausible rate.
    fn hint(&self) -> String {
        if self.by_scene || self.is_unit_given {
            return String::new();
        }
        let fits = |rate: f64| rate >= self.least && rate <= HIGHEST_RATE;
        match units::time_units_with(self.rate, fits).as_slice() {
            [] => String::new(),
            units => format!(
                "; in {} the rate is plausible, expected time = {{ column, unit }} where the column is not in seconds",
                units.join(" or ")
            ),
        }
    }

    /// Returns the error with its place: the scene where that states the rate, else the recording `name`.
    #[must_use]
    pub fn of(self, scene: &Scene, name: &str) -> RateError {
        if self.by_scene {
            RateError::Scene { file: scene.path.clone(), rate: self }
        } else {
            RateError::TimeStamps { recording: name.to_owned(), rate: self }
        }
    }
}

/// Error returned for an implausible sampling rate, with the place that states it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RateError {
    /// The scene states the rate.
    #[error("{}: [recording] rate: {rate}", file.display())]
    Scene {
        /// Scene file.
        file: PathBuf,
        /// Rate found and range expected. Not a `source`: the message contains it.
        rate: ImplausibleRate,
    },
    /// The rate follows from the time stamps.
    #[error("{recording}: sampling rate from its time stamps: {rate}")]
    TimeStamps {
        /// Name of the recording.
        recording: String,
        /// Rate found and range expected. Not a `source`: the message contains it.
        rate: ImplausibleRate,
    },
}

/// Checks the sampling rate (Hz) of a recording against the scene's shaft speed.
///
/// # Errors
/// Fewer than 4 samples in a revolution after averaging, or more than 10 MHz.
pub fn check_rate(rate: f64, recording: &Recording, speed: Speed) -> Result<(), ImplausibleRate> {
    let turns_per_second = speed.nominal().abs() / TAU;
    let least = MIN_PER_TURN * turns_per_second * f64::from(recording.average);
    if rate >= least && rate <= HIGHEST_RATE {
        return Ok(());
    }
    let is_unit_given = matches!(recording.clock, Clock::Column { seconds: Some(_), .. });
    let by_scene = !matches!(recording.clock, Clock::Column { .. });
    // The last digits of a rate from time stamps are rounding.
    let rate = format!("{rate:.8e}").parse().unwrap_or(rate);
    Err(ImplausibleRate { rate, speed_rpm: 60.0 * turns_per_second, least, by_scene, is_unit_given })
}

/// Number of rows from which the step is determined.
pub(crate) const LEARN: usize = 1000;

/// Share of the difference between stamp and grid by which the grid is corrected at each sample. It averages the rounding of
/// printed stamps and still follows a clock that drifts by 1 % of the step.
const FOLLOW: f64 = 1.0 / 16.0;

/// Share of repeated stamps above which the resolution of the clock is coarser than a sample.
const COARSE: f64 = 0.05;

/// Position of a row after the last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampPosition {
    /// The next sample.
    Next,
    /// The row follows a gap of this many samples.
    After(u64),
    /// The row repeats the stamp of an earlier one.
    Repeated,
    /// The stamp is before that of an earlier row.
    Backward,
}

/// Error returned for time stamps without a sampling period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockError {
    /// Fewer than two stamps.
    TooFew,
    /// The median step is not above 0.
    NotRising {
        /// Median step, s.
        step: f64,
    },
    /// The stamps do not distinguish samples: their clock is too coarse, or they have too few decimals.
    Coarse {
        /// Number of stamps that repeat the previous one.
        repeated: usize,
        /// Number of stamps.
        of: usize,
        /// Smallest step above 0, s; none where all stamps are equal.
        resolution: Option<f64>,
        /// Stamps a second, Hz, to the accuracy of the resolution; none where all stamps are equal.
        rate: Option<f64>,
    },
}

impl core::fmt::Display for ClockError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFew => write!(f, "fewer than two time stamps"),
            Self::NotRising { step } => write!(f, "time stamps whose usual step is {step} s"),
            Self::Coarse { repeated, of, resolution: Some(resolution), rate } => {
                write!(
                    f,
                    "a clock with a resolution of {} s, coarser than a sample: {repeated} of the first {of} time stamps repeat the one before",
                    significant(*resolution)
                )?;
                match rate {
                    Some(rate) => write!(f, " (about {} rows a second)", significant(*rate)),
                    None => Ok(()),
                }
            }
            Self::Coarse { of, .. } => {
                write!(f, "a clock with a resolution coarser than a sample: the first {of} time stamps are equal")
            }
        }
    }
}

/// The running grid of sample times.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    step: f64,
    /// Time of the last sample by the grid, s.
    at: f64,
    /// Highest stamp so far; NaN before the first.
    stamp: f64,
    /// Number of the next sample.
    next: u64,
}

impl Grid {
    /// Determines the step from the first stamps of a recording, s (NaN where there is none).
    ///
    /// # Errors
    /// Stamps that give no step above 0.
    pub fn learn(stamps: &[f64]) -> Result<Self, ClockError> {
        let known: Vec<f64> = stamps.iter().copied().filter(|stamp| stamp.is_finite()).collect();
        let steps: Vec<f64> = known.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let median = median(&steps).ok_or(ClockError::TooFew)?;
        let repeated = steps.iter().filter(|step| **step == 0.0).count();
        let coarse = repeated as f64 > COARSE * steps.len() as f64;
        if median >= 0.0 && coarse && repeated > 1 {
            return Err(coarse_clock(&known, &steps, repeated));
        }
        if median <= 0.0 {
            return Err(ClockError::NotRising { step: median });
        }
        let step = slope(&known, mean_near(&steps, median));
        let lead = stamps.iter().take_while(|stamp| !stamp.is_finite()).count();
        let first = known.first().copied().unwrap_or(0.0);
        Ok(Self { step, at: first - (lead + 1) as f64 * step, stamp: f64::NAN, next: 0 })
    }

    /// Returns the nominal step, s.
    #[must_use]
    pub const fn step(&self) -> f64 {
        self.step
    }

    /// Returns the number of the next sample, if none is missing.
    #[must_use]
    pub const fn next(&self) -> u64 {
        self.next
    }

    /// Returns the time of the next sample by the grid, s.
    #[must_use]
    pub fn next_time(&self) -> f64 {
        self.at + self.step
    }

    /// Returns the position of a row with this stamp (NaN: none), without adding it.
    #[must_use]
    pub fn place(&self, stamp: f64) -> StampPosition {
        if stamp.is_nan() {
            return StampPosition::Next;
        }
        if stamp == self.stamp {
            return StampPosition::Repeated;
        }
        if stamp < self.stamp {
            return StampPosition::Backward;
        }
        let steps = (stamp - self.at) / self.step;
        // A stamp that rises at all is a new sample, however large the jitter of the clock.
        if steps <= 1.5 {
            StampPosition::Next
        } else {
            StampPosition::After((steps.round() as u64).saturating_sub(1).max(1))
        }
    }

    /// Returns true where the stamp continues from the last sample as if the row between them had a regular stamp.
    #[must_use]
    pub(crate) fn skips_one(&self, stamp: f64) -> bool {
        ((stamp - self.at) / self.step - 2.0).abs() < 0.5
    }

    /// Adds the next sample after `missing` others; returns its number.
    pub fn accept(&mut self, stamp: f64, missing: u64) -> u64 {
        let index = self.next.saturating_add(missing);
        self.next = index.saturating_add(1);
        let due = self.at + self.step;
        self.at = match missing {
            _ if stamp.is_nan() => due,
            0 => due + FOLLOW * (stamp - due),
            // The grid has no information on the clock within a gap.
            _ => stamp,
        };
        if !stamp.is_nan() {
            self.stamp = stamp;
        }
        index
    }
}

/// Returns the error of `stamps` of which `repeated` repeat the one before.
fn coarse_clock(stamps: &[f64], steps: &[f64], repeated: usize) -> ClockError {
    let rising = steps.iter().copied().filter(|step| *step > 0.0);
    let resolution = rising.clone().fold(f64::INFINITY, f64::min);
    // The rows between the first and the last rise are whole blocks of equal stamps.
    let mut rises = (0..steps.len()).filter(|place| steps[*place] > 0.0);
    let (first, last) = (rises.next(), rises.next_back());
    let rate = first.zip(last).map(|(first, last)| (last - first) as f64 / (stamps[last + 1] - stamps[first + 1]));
    ClockError::Coarse {
        repeated,
        of: stamps.len(),
        resolution: resolution.is_finite().then_some(resolution),
        rate: rate.filter(|rate| rate.is_finite() && *rate > 0.0),
    }
}

/// Formats a number with three significant digits.
fn significant(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    number(rounded).to_string()
}

/// Returns the mean of the steps between 0.5 and 1.5 times `about`, those of one sample.
fn mean_near(steps: &[f64], about: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for step in steps.iter().filter(|step| **step > 0.5 * about && **step < 1.5 * about) {
        sum += step;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { about }
}

/// Returns the slope of the least-squares line through stamps over sample numbers. The rounding of printed stamps averages out
/// far better than in a mean of steps, which depends on the first and the last stamp only.
fn slope(stamps: &[f64], about: f64) -> f64 {
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(stamps.len());
    let origin = stamps.first().copied().unwrap_or(0.0);
    for time in stamps.iter().map(|stamp| stamp - origin) {
        match points.last() {
            None => points.push((0.0, time)),
            Some((index, last)) if time > *last => {
                points.push((index + ((time - last) / about).round().max(1.0), time));
            }
            Some(_) => {}
        }
    }
    let count = points.len() as f64;
    let middle = points.iter().map(|point| point.0).sum::<f64>() / count;
    let (mut product, mut square) = (0.0, 0.0);
    for (index, time) in points {
        product += (index - middle) * time;
        square += (index - middle) * (index - middle);
    }
    if square > 0.0 { product / square } else { about }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Stamps of `rate` with `decimals`, as a logger prints them.
    fn printed(rate: f64, decimals: usize, count: usize) -> Vec<f64> {
        (0..count).map(|i| format!("{:.*}", decimals, i as f64 / rate).parse().unwrap()).collect()
    }

    #[test]
    fn few_decimals_give_the_rate() {
        let grid = Grid::learn(&printed(12_800.0, 7, 1000)).unwrap();
        assert!((1.0 / grid.step() / 12_800.0 - 1.0).abs() < 2e-7, "{}", 1.0 / grid.step());
        let grid = Grid::learn(&printed(12_800.0, 5, 1000)).unwrap();
        assert!((1.0 / grid.step() / 12_800.0 - 1.0).abs() < 2e-5, "{}", 1.0 / grid.step());
    }

    #[test]
    fn drifting_clock_makes_no_gap() {
        let mut grid = Grid::learn(&printed(12_800.0, 7, 1000)).unwrap();
        let mut time: f64 = 0.0;
        for index in 0..3_000_000_u64 {
            let stamp = (time * 1e7).round() / 1e7;
            assert_eq!(grid.place(stamp), StampPosition::Next, "{index}");
            assert_eq!(grid.accept(stamp, 0), index);
            time += (1.0 + 300e-6 * (index as f64 * 1e-6).sin()) / 12_800.0;
        }
    }

    #[test]
    fn gaps_jumps_and_repeats() {
        let mut grid = Grid::learn(&printed(1000.0, 3, 10)).unwrap();
        assert_eq!(grid.accept(0.0, 0), 0);
        assert_eq!(grid.place(0.0), StampPosition::Repeated);
        assert_eq!(grid.place(-0.001), StampPosition::Backward);
        assert_eq!(grid.place(0.0014), StampPosition::Next);
        assert_eq!(grid.place(0.005), StampPosition::After(4));
        assert_eq!(grid.accept(0.005, 4), 5);
        assert_eq!(grid.place(f64::NAN), StampPosition::Next);
        assert_eq!(grid.accept(f64::NAN, 0), 6);
        assert_eq!(grid.place(0.007), StampPosition::Next);
        assert_eq!(grid.accept(0.007, 0), 7);
        assert!(grid.skips_one(0.009));
    }

    #[test]
    fn outliers_do_not_move_the_step() {
        let mut stamps = printed(12_800.0, 7, 900);
        stamps.truncate(800);
        stamps.extend((1200..1300).map(|i| f64::from(i) / 12_800.0));
        stamps[300] = stamps[299];
        stamps[400] = 0.0;
        let grid = Grid::learn(&stamps).unwrap();
        assert!((grid.step() * 12_800.0 - 1.0).abs() < 1e-6, "{}", 1.0 / grid.step());
    }

    #[test]
    fn stamps_without_a_step() {
        assert_eq!(Grid::learn(&[1.0]), Err(ClockError::TooFew));
        assert_eq!(Grid::learn(&[1.0, f64::NAN]), Err(ClockError::TooFew));
        assert!(matches!(Grid::learn(&[3.0, 2.0, 1.0]), Err(ClockError::NotRising { .. })));
        assert!(matches!(Grid::learn(&printed(12_800.0, 4, 1000)), Err(ClockError::Coarse { .. })));
    }

    /// Blocks of equal stamps from a clock of 1 ms, and of 1 s.
    #[test]
    fn a_coarse_clock_is_named() {
        let found = Grid::learn(&printed(25_600.0, 3, 1000)).unwrap_err().to_string();
        let expected = "a clock with a resolution of 0.001 s, coarser than a sample: 960 of the first 1000 time stamps \
                        repeat the one before (about 25600 rows a second)";
        assert_eq!(found, expected);
        let found = Grid::learn(&[5.0; 1000]).unwrap_err().to_string();
        assert_eq!(found, "a clock with a resolution coarser than a sample: the first 1000 time stamps are equal");
        // Half a block at either end does not count.
        let stamps: Vec<f64> = (0..100).map(|i| f64::from(i / 30)).collect();
        let found = Grid::learn(&stamps).unwrap_err().to_string();
        assert!(found.ends_with("(about 30 rows a second)"), "{found}");
    }
}
