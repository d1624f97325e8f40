//! Amplitude of lines that turn with the shaft or a cage: demodulation by the turn counters.
//!
//! The phase of each line comes from a counter, not from time, so a run-up smears nothing. Blocks of
//! [`BLOCK_TURNS`] turns under a Hann window over the angle keep neighbouring orders apart and let a real cage slip a
//! little between blocks; amplitudes are averaged over blocks by their squares.

use super::comparison::Angles;
use ballrace::math::Math;
use ballrace::{Exact, Phase};
use std::f64::consts::TAU;

/// Turns of one block. Lines 3/16 of an order apart are told apart.
pub const BLOCK_TURNS: f64 = 16.0;

/// What a line's phase follows: whole multiples of the shaft's and of a cage's angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    /// Multiple of the shaft's angle.
    pub shaft: i32,
    /// Bearing whose cage counts, and the multiple of its angle.
    pub cage: Option<(usize, i32)>,
}

impl Line {
    /// `n` times the shaft.
    #[must_use]
    pub const fn shaft(n: i32) -> Self {
        Self { shaft: n, cage: None }
    }

    /// Order per turn of the shaft.
    #[must_use]
    pub fn order(&self, cage_ratios: &[f64]) -> f64 {
        let cage = self.cage.map_or(0.0, |(i, n)| f64::from(n) * cage_ratios.get(i).copied().unwrap_or(0.0));
        f64::from(self.shaft) + cage
    }

    fn phase(&self, shaft: Phase, cages: &[Phase]) -> Phase {
        let times = |angle: Phase, n: i32| angle.wrapping_mul(i64::from(n) as u64);
        let cage = self.cage.map_or(Phase::ZERO, |(i, n)| times(cages.get(i).copied().unwrap_or_default(), n));
        times(shaft, self.shaft).wrapping_add(cage)
    }
}

/// Demodulates several signals at several lines.
#[derive(Debug, Clone)]
pub struct Demodulator {
    lines: Vec<Line>,
    signals: usize,
    /// Sums of the running block with cosine and with sine, line-major.
    cosines: Vec<f64>,
    sines: Vec<f64>,
    /// This sample's signals about their means, under the window.
    windowed: Vec<f64>,
    /// Amplitudes of cosine and sine in the last finished block.
    last: Vec<[f64; 2]>,
    weight: f64,
    /// Turns gone in the running block.
    turns: f64,
    /// Squared amplitudes summed over finished blocks, times their weight.
    power: Vec<f64>,
    blocks: f64,
    /// Subtracted before demodulation so that a large mean does not leak: the mean of what came before.
    means: Vec<f64>,
    seen: f64,
}

impl Demodulator {
    /// For `signals` signals.
    #[must_use]
    pub fn new(lines: Vec<Line>, signals: usize) -> Self {
        let cells = lines.len() * signals;
        Self {
            lines,
            signals,
            cosines: vec![0.0; cells],
            sines: vec![0.0; cells],
            windowed: vec![0.0; signals],
            last: vec![[0.0; 2]; cells],
            weight: 0.0,
            turns: 0.0,
            power: vec![0.0; cells],
            blocks: 0.0,
            means: vec![0.0; signals],
            seen: 0.0,
        }
    }

    /// One sample of all signals; true when it finished a block.
    pub fn add(&mut self, values: &[f64], angles: Angles) -> bool {
        self.seen += 1.0;
        let window = 0.5 * (1.0 - (TAU * self.turns / BLOCK_TURNS).cos());
        self.weight += window;
        // A slow average: fixed within rounding over a block, whatever the recording's length.
        let rate = 1.0 / self.seen.min(20_000.0);
        for ((mean, value), to) in self.means.iter_mut().zip(values).zip(&mut self.windowed) {
            *mean += (value - *mean) * rate;
            *to = window * (value - *mean);
        }
        let width = self.signals.max(1);
        let cells = self.cosines.chunks_exact_mut(width).zip(self.sines.chunks_exact_mut(width));
        for (line, (cosines, sines)) in self.lines.iter().zip(cells) {
            let (sin, cos): (f64, f64) = Exact::sin_cos(line.phase(angles.shaft, angles.cages));
            for ((c, s), y) in cosines.iter_mut().zip(sines).zip(&self.windowed) {
                *c += y * cos;
                *s += y * sin;
            }
        }
        self.turns += angles.arc.abs();
        let full = self.turns >= BLOCK_TURNS;
        if full {
            self.close();
            self.turns -= BLOCK_TURNS;
        }
        full
    }

    fn close(&mut self) {
        if self.weight > 0.0 {
            let sums = self.cosines.iter().zip(&self.sines);
            for ((power, last), (c, s)) in self.power.iter_mut().zip(&mut self.last).zip(sums) {
                *last = [2.0 * c / self.weight, 2.0 * s / self.weight];
                *power += last[0] * last[0] + last[1] * last[1];
            }
            self.blocks += 1.0;
        }
        self.cosines.fill(0.0);
        self.sines.fill(0.0);
        self.weight = 0.0;
    }

    /// Ends the recording: a part block counts only where there is no whole one.
    pub fn finish(&mut self) {
        if self.blocks == 0.0 {
            self.close();
        }
    }

    /// Amplitudes of cosine and sine of line `line` in every signal of the last finished block.
    #[must_use]
    pub fn block(&self, line: usize) -> &[[f64; 2]] {
        self.last.get(line * self.signals..(line + 1) * self.signals).unwrap_or_default()
    }

    /// Amplitude (zero to peak) of line `line` in signal `signal`.
    #[must_use]
    pub fn amplitude(&self, line: usize, signal: usize) -> f64 {
        let power = self.power.get(line * self.signals + signal).copied().unwrap_or(0.0);
        if self.blocks > 0.0 { (power / self.blocks).sqrt() } else { 0.0 }
    }

    /// The lines in order.
    #[must_use]
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }
}
