//! Speeds at which recordings have vectors: the one speed of a recording, or several that a run-up or a coast-down passes.

use super::C;
use ballrace_outcome::Block;
use ballrace_plant::error::VectorError;
use ballrace_studies::balance::SAME_SPEED;
use std::path::{Path, PathBuf};

/// Least ratio of two neighbouring speeds of a run-up.
const STEP: f64 = 1.05;
/// Most speeds of run-ups.
const MOST: i32 = 8;
/// Largest difference of the speeds of two neighbouring blocks, as a share, between which vectors are interpolated.
const LARGEST_CHANGE: f64 = 0.1;

/// Blocks of a recording.
pub(super) struct Passed {
    file: PathBuf,
    blocks: Vec<Block>,
    /// Least and largest speed, without its sign, of blocks between which it changes slowly, rpm.
    range: [f64; 2],
}

/// Returns by which share the speed changes from one block to the next.
fn change(pair: &[Block]) -> f64 {
    (pair[1].speed_rpm / pair[0].speed_rpm - 1.0).abs()
}

impl Passed {
    /// # Errors
    /// Returns an error for a recording without a block, or whose speed changes too fast everywhere.
    pub(super) fn new(file: &Path, blocks: Vec<Block>) -> Result<Self, VectorError> {
        let turns = crate::trend::TURNS;
        let Some(first) = blocks.first().map(|block| block.speed_rpm.abs()) else {
            return Err(VectorError::Short { file: file.to_owned(), turns: turns + 1 });
        };
        let least = blocks.windows(2).map(change).fold(f64::INFINITY, f64::min);
        if least > LARGEST_CHANGE && least.is_finite() {
            let [found, most] = [least, LARGEST_CHANGE].map(|share| 100.0 * share);
            return Err(VectorError::FastChange { file: file.to_owned(), turns, found, most });
        }
        // A run-up from standstill is fast at first.
        let slow = blocks.windows(2).filter(|pair| change(pair) <= LARGEST_CHANGE).flatten();
        let speeds = slow.map(|block| block.speed_rpm.abs());
        let [low, high] = speeds.fold([f64::INFINITY, 0.0_f64], |[low, high], x| [low.min(x), high.max(x)]);
        let range = if low <= high { [low, high] } else { [first, first] };
        Ok(Self { file: file.to_owned(), blocks, range })
    }

    fn is_constant(&self) -> bool {
        let [low, high] = self.range;
        high - low <= SAME_SPEED * high
    }

    /// Returns the speeds (rpm) and readings of the vectors: every block of a recording at one speed; of others the passes of `speeds`, between two
    /// blocks each.
    pub(super) fn vectors(&self, probes: &[usize], speeds: &[f64]) -> Vec<(f64, Vec<C>)> {
        let reading = |block: &Block, i: &usize| {
            block.probes.get(*i).map(|probe| C::new(probe.one_x_um[0], -probe.one_x_um[1])).unwrap_or_default()
        };
        if self.is_constant() {
            let all = |block: &Block| (block.speed_rpm, probes.iter().map(|i| reading(block, i)).collect());
            let is_in = |block: &&Block| (self.range[0]..=self.range[1]).contains(&block.speed_rpm.abs());
            return self.blocks.iter().filter(is_in).map(all).collect();
        }
        let mut found = vec![];
        for speed in speeds {
            for pair in self.blocks.windows(2).filter(|pair| change(pair) <= LARGEST_CHANGE) {
                let [from, to] = [pair[0].speed_rpm.abs(), pair[1].speed_rpm.abs()];
                // A pass at the speed of a block is counted once.
                if (from <= *speed) == (to <= *speed) {
                    continue;
                }
                let share = (speed - from) / (to - from);
                let between = |i: &usize| reading(&pair[0], i) * (1.0 - share) + reading(&pair[1], i) * share;
                found.push((speed.copysign(pair[0].speed_rpm), probes.iter().map(between).collect()));
            }
        }
        found
    }
}

/// Returns the speeds (rpm) at which recordings of changing speed have vectors: those of the recordings at one speed, and others in the
/// range that all pass, evenly spread in proportion.
///
/// # Errors
/// Returns an error where recordings have no speed in common.
pub(super) fn common(all: &[Passed]) -> Result<Vec<f64>, VectorError> {
    let passing = || all.iter().filter(|one| !one.is_constant());
    let low = passing().map(|one| one.range[0]).fold(0.0, f64::max);
    let high = passing().map(|one| one.range[1]).fold(f64::INFINITY, f64::min);
    let Some(first) = passing().next() else { return Ok(vec![]) };
    let constant = all.iter().filter(|one| one.is_constant()).map(|one| 0.5 * (one.range[0] + one.range[1]));
    let mut speeds: Vec<f64> = constant.filter(|speed| (low..=high).contains(speed)).collect();
    if low >= high {
        return Err(VectorError::NoCommonSpeed { file: first.file.clone(), low, high });
    }
    let count = ((high / low).ln() / STEP.ln()).floor().clamp(0.0, f64::from(MOST - 1)) as i32 + 1;
    let spread = |i: i32| low * (high / low).powf((f64::from(i) + 0.5) / f64::from(count));
    for speed in (0..count).map(spread) {
        if speeds.iter().all(|other| (speed / other).max(other / speed) > STEP) {
            speeds.push(speed);
        }
    }
    Ok(speeds)
}
