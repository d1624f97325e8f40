//! Block of consecutive samples with a reading of every probe, from which a diagnosis is computed.

use ballrace_recording::Sample;
use ballrace_recording::status::SampleStatus;
use std::collections::VecDeque;

/// Smallest number of samples of a full block.
const SAMPLES: usize = 16_384;
/// Revolutions of the shaft in a full block.
const REVOLUTIONS: f64 = 80.0;
/// Largest number of samples of a block.
const MAX_SAMPLES: usize = 65_536;

/// The last samples without an interruption, and the longest such block before.
#[derive(Clone, Default)]
pub struct Block {
    samples: VecDeque<Sample>,
    earlier: VecDeque<Sample>,
    /// A sample that has left the block, whose memory is used again.
    spare: Option<Sample>,
}

impl Block {
    /// Adds a sample.
    pub fn add(&mut self, sample: &Sample) {
        let is_usable = sample.row.probes.iter().all(|x| x.is_finite())
            && !sample.status.has(SampleStatus::ANGLE_NOT_MEASURED)
            && !sample.status.has(SampleStatus::READING_OUT_OF_RANGE);
        let follows = self.samples.back().is_none_or(|last| last.row.index + 1 == sample.row.index);
        if !is_usable || !follows {
            if self.samples.len() > self.earlier.len() {
                self.earlier = std::mem::take(&mut self.samples);
            }
            self.samples.clear();
        }
        if is_usable {
            let mut copy = self.spare.take().unwrap_or_default();
            copy.copy_from(sample);
            self.samples.push_back(copy);
        }
        while self.is_longer_than_full() {
            self.spare = self.samples.pop_front();
        }
    }

    fn revolutions(&self) -> f64 {
        match (self.samples.front(), self.samples.back()) {
            (Some(first), Some(last)) => (last.total_revolutions() - first.total_revolutions()).abs(),
            _ => 0.0,
        }
    }

    fn is_longer_than_full(&self) -> bool {
        let count = self.samples.len();
        count > MAX_SAMPLES || (count > SAMPLES && self.revolutions() > REVOLUTIONS)
    }

    /// Returns true once no further sample makes the block longer.
    pub fn is_full(&self) -> bool {
        let count = self.samples.len();
        count >= MAX_SAMPLES || (count >= SAMPLES && self.revolutions() >= REVOLUTIONS - 1.0)
    }

    /// Returns the number of samples in a row.
    pub fn length(&self) -> usize {
        self.samples.len()
    }

    /// Returns the number of samples after which a block is full at a shaft speed, revolutions per sample.
    pub fn full_length(revolutions_per_sample: f64) -> usize {
        let by_revolutions = (REVOLUTIONS - 1.0) / revolutions_per_sample.abs();
        (by_revolutions.min(MAX_SAMPLES as f64).ceil() as usize).clamp(SAMPLES, MAX_SAMPLES)
    }

    /// Returns the samples of the last block, or of the earlier one if that is longer, without the first few that a fast transform
    /// leaves out.
    pub fn into_samples(self) -> Vec<Sample> {
        let block = if self.samples.len() >= self.earlier.len() { self.samples } else { self.earlier };
        let count = smooth(block.len());
        let first = block.len() - count;
        block.into_iter().skip(first).collect()
    }
}

/// Returns the largest number up to `n` whose Fourier transform is fast: a multiple of 16 without a prime factor above 13, or `n` where
/// it is small.
fn smooth(n: usize) -> usize {
    if n < 2048 {
        return n;
    }
    let is_fast = |count: &usize| {
        [2, 3, 5, 7, 11, 13].into_iter().fold(*count, |mut rest, prime| {
            while rest % prime == 0 {
                rest /= prime;
            }
            rest
        }) == 1
    };
    16 * (1..=n / 16).rev().find(is_fast).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_recording::Row;

    /// Samples that take the memory of earlier ones are those that were added.
    #[test]
    fn a_full_block_has_the_last_samples() {
        let sample = |index: u64| {
            let row =
                Row { index, line: index + 2, time: index as f64, probes: vec![index as f64; 3], ..Row::default() };
            Sample { row, speed: 1.0 + index as f64, revolution: index as i64, ..Sample::default() }
        };
        let (mut block, count) = (Block::default(), SAMPLES as u64 + 300);
        (0..count).for_each(|index| block.add(&sample(index)));
        let expected: Vec<Sample> = (count - SAMPLES as u64..count).map(sample).collect();
        assert!(block.is_full());
        assert_eq!(block.samples, expected);
    }

    #[test]
    fn full_length_is_that_of_a_block_that_fills() {
        for revolutions_per_sample in [1.0 / 2000.0, 1.0 / 400.0, -1.0 / 400.0, 0.1, 0.0] {
            let mut block = Block::default();
            let sample = |index: u64| {
                let row = Row { index, probes: vec![0.0], ..Row::default() };
                let turned = index as f64 * revolutions_per_sample;
                let angle = ballrace::Phase::from_revolutions(turned);
                Sample { row, revolution: turned.floor() as i64, angle, ..Sample::default() }
            };
            let filled = (0..).find(|index| {
                block.add(&sample(*index));
                block.is_full()
            });
            let filled = filled.unwrap_or_default() as f64 + 1.0;
            let expected = Block::full_length(revolutions_per_sample) as f64;
            assert!((filled / expected - 1.0).abs() < 1e-3, "{revolutions_per_sample}: {filled} instead of {expected}");
        }
    }

    #[test]
    fn lengths_of_a_fast_transform() {
        assert_eq!([2047, 2048, 20_480, 37_120, 38_399].map(smooth), [2047, 2048, 20_480, 36_960, 38_016]);
        let omitted = (2048..MAX_SAMPLES).map(|n| 1.0 - smooth(n) as f64 / n as f64).fold(0.0, f64::max);
        assert!(omitted < 0.04, "{omitted}");
    }
}
