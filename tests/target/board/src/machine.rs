//! A machine in front of the converter of a board: counts that every processor computes alike.

use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::{Exact, Math, Phase};
use monitor::bearings::bearing_de;
use monitor::{CHANNELS, Counts, PROBE};

/// Blocks of a run: the detector has learned after 8 revolutions and has its verdict after 64 more, and a second has 25 blocks.
pub const BLOCKS: usize = 75;
/// The probe along X is at the rail of its converter in these samples of the run.
pub const RAILED: core::ops::Range<u32> = 7800..8100;

/// A rotor at about 1500 rpm, one revolution in a block.
pub struct Machine {
    /// Whether the outer race has a spall.
    is_damaged: bool,
    number: u32,
    shaft: Phase,
    cage: Phase,
    noise: u32,
    /// Last two values of the resonance of the housing, counts.
    ringing: [f32; 2],
}

impl Machine {
    /// The machine at rest.
    pub fn new(is_damaged: bool) -> Self {
        Self { is_damaged, number: 0, shaft: Phase::ZERO, cage: Phase::ZERO, noise: 1, ringing: [0.0; 2] }
    }

    /// Fills a buffer; returns the rotation before each sample, from an encoder of 4096 counts per revolution.
    pub fn block(&mut self, counts: &mut Counts) -> PhaseDelta {
        let block = self.number / 256;
        let turned = PhaseDelta(i64::from(4090 + 7 * block % 13) << 44);
        for sample in counts.as_chunks_mut::<CHANNELS>().0 {
            *sample = self.sample(turned);
        }
        turned
    }

    fn sample(&mut self, turned: PhaseDelta) -> [u16; CHANNELS] {
        let before = self.cage.wrapping_mul(9);
        self.shaft = self.shaft.advanced(turned);
        self.cage = self.cage.advanced(SpeedRatio::new(bearing_de::CAGE_RATIO).apply(turned));
        let ball_passes = self.cage.wrapping_mul(9).0 < before.0;
        let blow = if ball_passes && self.is_damaged { 90.0 } else { 0.0 };
        let (sin, cos): (f32, f32) = Exact::sin_cos(self.shaft);
        let [last, before] = self.ringing;
        self.ringing = [blow + 20.0 * self.noise() * (1.0 + 0.3 * cos) + 0.5 * last - 0.9 * before, last];
        // The static equilibrium of the scene and the orbit of its unbalance.
        let [x, y] = [0.06e-6 * cos, -11.3e-6 + 0.02e-6 * sin]
            .map(|u| (u - PROBE.at_zero) / PROBE.per_count)
            .map(|counts| (counts + self.noise()) as u16);
        let is_railed = RAILED.contains(&self.number);
        self.number += 1;
        [if is_railed { 4095 } else { x }, y, (2048.0 + self.ringing[0]) as u16]
    }

    /// Returns a number from -1 to 1.
    fn noise(&mut self) -> f32 {
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.noise >> 16) as f32 / 32_768.0 - 1.0
    }
}
