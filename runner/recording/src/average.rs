//! Average of several samples, for a recorder that is faster than the model needs.

use super::{Row, Sample};
use ballrace::Phase;
use std::f64::consts::TAU;

/// Averages groups of samples whose numbers share their quotient by the group's size.
///
/// The mean is assigned to the middle of its group in time and angle. A group with a missing sample or reading has no reading.
pub(super) struct Average {
    size: u64,
    /// Period of the input samples, s.
    period: f64,
    group: Option<Group>,
    sums: Vec<f64>,
}

struct Group {
    number: u64,
    count: u64,
    /// The sample nearest to the middle from above, or the first one where that is missing.
    middle: Sample,
}

impl Average {
    pub(super) const fn new(size: u32, rate: f64) -> Self {
        Self { size: size as u64, period: 1.0 / rate, group: None, sums: Vec::new() }
    }

    /// Adds a sample; returns the mean of the group that it completes, or of the unfinished group before it, and a row whose memory
    /// can be used again.
    pub(super) fn take(&mut self, sample: Sample) -> (Option<Sample>, Option<Row>) {
        if self.size == 1 {
            return (Some(sample), None);
        }
        let number = sample.row.index / self.size;
        let mut done = None;
        if self.group.as_ref().is_some_and(|group| group.number != number) {
            done = self.close();
        }
        let Some(group) = &mut self.group else {
            self.sums.clear();
            self.sums.extend_from_slice(&sample.row.probes);
            self.group = Some(Group { number, count: 1, middle: sample });
            return (done, None);
        };
        for (sum, reading) in self.sums.iter_mut().zip(&sample.row.probes) {
            *sum += reading;
        }
        group.count += 1;
        let status = group.middle.status.and(sample.status);
        group.middle.status = status;
        let mut spare = sample;
        if spare.row.index % self.size == self.size / 2 {
            std::mem::swap(&mut group.middle, &mut spare);
            group.middle.status = status;
        }
        if group.count == self.size {
            done = self.close();
        }
        (done, Some(spare.row))
    }

    /// Ends the current group, where there is one, and returns its mean; the readings are NaN where a sample is missing.
    pub(super) fn close(&mut self) -> Option<Sample> {
        let Group { number, count, mut middle } = self.group.take()?;
        let share = if count == self.size { 1.0 / self.size as f64 } else { f64::NAN };
        for (reading, sum) in middle.row.probes.iter_mut().zip(&self.sums) {
            *reading = sum * share;
        }
        let from_first = (middle.row.index % self.size) as f64;
        let ahead = (0.5 * (self.size - 1) as f64 - from_first) * self.period;
        let arc = ahead * (middle.speed + 0.5 * ahead * middle.acceleration) / TAU;
        let revolutions = middle.angle.revolutions() + arc;
        middle.revolution += revolutions.floor() as i64;
        middle.angle = middle.angle.wrapping_add(Phase::from_revolutions(arc));
        middle.speed += ahead * middle.acceleration;
        middle.row.time += ahead;
        middle.row.index = number;
        Some(middle)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// A shaft at `turns(t)` revolutions, probes that read `a + b t`.
    fn sample(index: u64) -> Sample {
        let time = index as f64 * 1e-3;
        let turns = 7.3 * time + 0.5 * 4.0 * time * time;
        Sample {
            row: Row { index, line: index, time, probes: vec![1.0 + 2.0 * time, -time], ..Row::default() },
            angle: Phase::from_revolutions(turns),
            revolution: turns.floor() as i64,
            speed: TAU * (7.3 + 4.0 * time),
            acceleration: TAU * 4.0,
            status: Default::default(),
        }
    }

    fn averaged(size: u32, numbers: impl Iterator<Item = u64>) -> Vec<Sample> {
        let mut average = Average::new(size, 1000.0);
        let mut all: Vec<Sample> = numbers.filter_map(|i| average.take(sample(i)).0).collect();
        all.extend(average.close());
        all
    }

    #[test]
    fn means_have_the_time_of_their_middle() {
        for size in [2, 3, 4, 7] {
            let all = averaged(size, 0..7000);
            assert_eq!(all.len(), 7000_usize.div_ceil(size as usize));
            for (number, mean) in all.iter().take(7000 / size as usize).enumerate() {
                let time = (number as f64 * f64::from(size) + 0.5 * f64::from(size - 1)) * 1e-3;
                let turns = 7.3 * time + 2.0 * time * time;
                assert_eq!(mean.row.index, number as u64);
                assert!((mean.row.time - time).abs() < 1e-12);
                assert!((mean.row.probes[0] - 1.0 - 2.0 * time).abs() < 1e-12);
                assert!((mean.revolution as f64 + mean.angle.revolutions() - turns).abs() < 1e-8, "{size} {number}");
                assert!((mean.speed - TAU * (7.3 + 4.0 * time)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn average_over_a_gap_has_no_reading() {
        let all = averaged(4, (0..12).filter(|i| *i != 5));
        assert!(all[1].row.probes.iter().all(|y| y.is_nan()));
        assert!(all[0].row.probes[0].is_finite() && all[2].row.probes[0].is_finite());
        let far = averaged(4, (0..8).chain(400..408));
        assert_eq!(far.iter().map(|s| s.row.index).collect::<Vec<_>>(), [0, 1, 100, 101]);
        let mut one = Average::new(1, 1000.0);
        assert_eq!(one.take(sample(3)).0.unwrap().row.probes, sample(3).row.probes);
    }
}
