//! Trend: indicators of blocks of a few revolutions over the whole recording, in bounded memory.
//!
//! A block begins at a multiple of [`TURNS`] revolutions. Under a Hann window over the shaft angle the mean, 0.5X, 1X and 2X are
//! at the zeros of one another's spectra: none leaks into another, even while the speed changes.

use super::history::{History, Join};
use ballrace::Exact;
use ballrace::twin::{BlockStatistics, OrderSums, OrderVector, Statistics};
use ballrace_outcome::{Block, BlockFigures};
use ballrace_plant::probes::Plane;
use ballrace_recording::Sample;
use std::f64::consts::TAU;

const UM: f64 = 1e6;
/// Revolutions of one block.
pub const TURNS: i64 = 4;
/// Largest number of points in a trend.
const MAX_POINTS: usize = 512;
/// Largest number of samples in a block; a block of a very slow shaft is dropped.
const MAX_SAMPLES: usize = 1 << 18;
/// Smallest share of its revolutions in which a block has readings.
const MIN_COVERED: f64 = 0.98;
/// Steps longer than this many revolutions are gaps.
const GAP: f64 = 0.25;

/// Accumulates samples block by block.
pub struct Trend {
    planes: Vec<Plane>,
    probes: usize,
    /// Number of the current block.
    index: Option<i64>,
    /// Window and angle functions of each sample.
    bases: Vec<Basis>,
    /// Readings of each probe, then those of the twin, m: one column per signal.
    columns: Vec<Vec<f64>>,
    covered: f64,
    start: f64,
    end: f64,
    speed: f64,
    history: History<Block>,
}

impl Trend {
    /// Creates the trend of `probes` probes and these planes.
    #[must_use]
    pub fn new(probes: usize, planes: Vec<Plane>) -> Self {
        Self {
            planes,
            probes,
            index: None,
            bases: vec![],
            columns: vec![vec![]; 2 * probes],
            covered: 0.0,
            start: 0.0,
            end: 0.0,
            speed: 0.0,
            history: History::new(MAX_POINTS),
        }
    }

    /// Adds a sample, the twin's readings, and the revolutions since the last sample.
    pub fn add(&mut self, sample: &Sample, twin: &[f64], revolutions: f64) {
        let index = sample.revolution.div_euclid(TURNS);
        let gap = revolutions.abs() > GAP;
        if self.index != Some(index) || gap || self.bases.len() >= MAX_SAMPLES {
            if !gap {
                self.close();
            }
            self.begin(index, sample.row.time);
        }
        if sample.row.probes.iter().any(|y| y.is_nan()) {
            return;
        }
        let turns = sample.revolution.rem_euclid(TURNS) as f64 + sample.angle.revolutions();
        self.bases.push(Basis::new((TAU * turns / TURNS as f64).sin_cos()));
        for (column, value) in self.columns.iter_mut().zip(sample.row.probes.iter().chain(twin)) {
            column.push(*value);
        }
        self.covered += revolutions.abs();
        self.speed += sample.speed;
        self.end = sample.row.time;
    }

    fn begin(&mut self, index: i64, time: f64) {
        self.index = Some(index);
        self.bases.clear();
        self.columns.iter_mut().for_each(Vec::clear);
        (self.covered, self.speed, self.start, self.end) = (0.0, 0.0, time, time);
    }

    /// Evaluates the current block, where it is complete.
    fn close(&mut self) {
        if self.covered < MIN_COVERED * TURNS as f64 {
            return;
        }
        let count = self.bases.len() as f64;
        let means: Vec<f64> = self.columns.iter().map(|column| column.iter().sum::<f64>() / count).collect();
        let block = Block {
            start_s: self.start,
            end_s: self.end,
            speed_rpm: self.speed / count * 60.0 / TAU,
            probes: (0..self.probes).filter_map(|i| self.figures(i, *means.get(i)?, count)).collect(),
            smax_um: self.planes.iter().filter_map(|plane| self.farthest(plane, &means)).collect(),
        };
        self.history.push(block);
    }

    /// Returns the indicators of probe `i` in the current block.
    fn figures(&self, i: usize, mean: f64, count: f64) -> Option<BlockFigures> {
        let (measured, twin) = (self.columns.get(i)?, self.columns.get(self.probes + i)?);
        let mut sums = BlockSums::default();
        let (mut readings, mut residuals) = (Statistics::<f64, f64>::about(mean, u32::MAX), 0.0);
        for ((basis, y), x) in self.bases.iter().zip(measured).zip(twin) {
            readings.add::<Exact>(*y);
            residuals += (y - x) * (y - x);
            sums.add(basis, y - mean, x - mean);
        }
        let lines = sums.close();
        let residual_rms = (residuals / count).sqrt();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (basis, y) in self.bases.iter().zip(measured) {
            let left = y - lines.one[0] * basis.one.1 - lines.one[1] * basis.one.0;
            (low, high) = (low.min(left), high.max(left));
        }
        Some(lines.figures(&readings.close::<Exact>(), (high - low) * UM, residual_rms * UM))
    }

    /// Returns the largest distance from the mean position in a plane, um.
    fn farthest(&self, plane: &Plane, means: &[f64]) -> Option<f64> {
        let [a, b] = plane.probes;
        let (column_a, column_b, mean_a, mean_b) =
            (self.columns.get(a)?, self.columns.get(b)?, means.get(a)?, means.get(b)?);
        let square = |(a, b): (&f64, &f64)| {
            let (x, y) = plane.xy_from(a - mean_a, b - mean_b);
            x * x + y * y
        };
        Some(column_a.iter().zip(column_b).map(square).fold(0.0, f64::max).sqrt() * UM)
    }

    /// Returns the blocks, with neighbours merged where there are too many.
    #[must_use]
    pub fn finish(mut self) -> Vec<Block> {
        self.close();
        self.history.into_entries()
    }
}

/// Window, and (sine, cosine) of 0.5X, 1X and 2X at one sample.
struct Basis {
    window: f64,
    half: (f64, f64),
    one: (f64, f64),
    two: (f64, f64),
}

impl Basis {
    /// Creates the functions from (sine, cosine) of a quarter of the shaft angle.
    fn new(quarter: (f64, f64)) -> Self {
        let doubled = |(sin, cos): (f64, f64)| (2.0 * sin * cos, cos * cos - sin * sin);
        let half = doubled(quarter);
        let one = doubled(half);
        Self { window: 0.5 * (1.0 - quarter.1), half, one, two: doubled(one) }
    }
}

/// Sums of one probe over one block, about its mean, under the window. The kernel's [`OrderSums`] without its `OrderTracker`, whose
/// lines are whole multiples of angles: 0.5X is not.
#[derive(Debug, Clone, Default)]
struct BlockSums {
    weight: f64,
    half: OrderSums<f64, f64>,
    one: OrderSums<f64, f64>,
    two: OrderSums<f64, f64>,
    twin: OrderSums<f64, f64>,
}

/// Amplitudes of cosine and sine of one probe in one block, m.
struct BlockLines {
    half: OrderVector<f64>,
    one: OrderVector<f64>,
    two: OrderVector<f64>,
    twin: OrderVector<f64>,
}

impl BlockSums {
    fn add(&mut self, basis: &Basis, d: f64, twin: f64) {
        let w = basis.window;
        self.weight += w;
        self.half.add(w * d, basis.half);
        self.one.add(w * d, basis.one);
        self.two.add(w * d, basis.two);
        self.twin.add(w * twin, basis.one);
    }

    fn close(&mut self) -> BlockLines {
        let scale = 2.0 / self.weight.max(f64::MIN_POSITIVE);
        let [half, one, two, twin] =
            [&mut self.half, &mut self.one, &mut self.two, &mut self.twin].map(|sums| sums.close(scale));
        BlockLines { half, one, two, twin }
    }
}

impl BlockLines {
    fn figures(&self, readings: &BlockStatistics<f64>, not_one_x: f64, residual_rms: f64) -> BlockFigures {
        let size = |[cos, sin]: [f64; 2]| cos.hypot(sin) * UM;
        BlockFigures {
            mean_um: readings.mean * UM,
            peak_to_peak_um: readings.peak_to_peak * UM,
            greatest_um_pp: readings.peak_to_peak * UM,
            not_one_x_um_pp: not_one_x,
            rms_um: readings.rms * UM,
            crest_factor: readings.crest_factor,
            kurtosis: readings.kurtosis,
            residual_rms_um: residual_rms,
            one_x_um: self.one.map(|x| x * UM),
            twin_one_x_um: self.twin.map(|x| x * UM),
            two_x_um: size(self.two),
            half_x_um: size(self.half),
        }
    }
}

impl Join for Block {
    fn join(&mut self, later: &Self, share: f64) {
        self.end_s = later.end_s;
        let mix = |to: &mut f64, from: f64| *to += share * (from - *to);
        mix(&mut self.speed_rpm, later.speed_rpm);
        for (to, from) in self.probes.iter_mut().zip(&later.probes) {
            to.join(from, share);
        }
        for (to, from) in self.smax_um.iter_mut().zip(&later.smax_um) {
            mix(to, *from);
        }
    }
}

impl Join for BlockFigures {
    /// Averages the indicators: rms by their squares, 1X as vectors; the largest value is kept.
    fn join(&mut self, later: &Self, share: f64) {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let squares = |a: f64, b: f64| mix(a * a, b * b).sqrt();
        let vectors = |a: [f64; 2], b: [f64; 2]| [mix(a[0], b[0]), mix(a[1], b[1])];
        *self = Self {
            mean_um: mix(self.mean_um, later.mean_um),
            peak_to_peak_um: mix(self.peak_to_peak_um, later.peak_to_peak_um),
            greatest_um_pp: self.greatest_um_pp.max(later.greatest_um_pp),
            not_one_x_um_pp: mix(self.not_one_x_um_pp, later.not_one_x_um_pp),
            rms_um: squares(self.rms_um, later.rms_um),
            crest_factor: mix(self.crest_factor, later.crest_factor),
            kurtosis: mix(self.kurtosis, later.kurtosis),
            residual_rms_um: squares(self.residual_rms_um, later.residual_rms_um),
            one_x_um: vectors(self.one_x_um, later.one_x_um),
            twin_one_x_um: vectors(self.twin_one_x_um, later.twin_one_x_um),
            two_x_um: mix(self.two_x_um, later.two_x_um),
            half_x_um: mix(self.half_x_um, later.half_x_um),
        };
    }
}

/// Returns all blocks merged into one.
#[must_use]
pub fn merged(blocks: &[Block]) -> Option<Block> {
    let (first, rest) = blocks.split_first()?;
    let mut all = first.clone();
    for (i, block) in rest.iter().enumerate() {
        all.join(block, 1.0 / (i + 2) as f64);
    }
    Some(all)
}

#[cfg(test)]
mod tests;
