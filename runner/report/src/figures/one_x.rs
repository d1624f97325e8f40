//! 1X vectors over the speed, as measured and with slow-roll compensation.

use ballrace_twin::replay::outcome::Block;

/// Share of the blocks that determine the slow roll, and their largest number.
const SLOW_SHARE: usize = 16;
const MAX_SLOW: usize = 8;
/// Below this share of the largest amplitude a phase is noise.
const LEAST_SHOWN: f64 = 0.02;

/// Cosine and sine of 1X, um peak.
type Vector = [f64; 2];

/// The 1X vectors of one probe, block by block.
pub(super) struct OneX {
    /// Speed of each block.
    pub(super) speed_rpm: Vec<f64>,
    /// As measured.
    pub(super) raw: Vec<Vector>,
    /// With the slow roll subtracted.
    pub(super) compensated: Vec<Vector>,
    /// 1X vectors of the twin, which has no runout.
    pub(super) twin: Vec<Vector>,
    /// Mean vector of the slowest blocks.
    pub(super) slow_roll: Vector,
    /// Speeds of the slowest and of the fastest of these blocks, rpm.
    pub(super) slow_rpm: (f64, f64),
    /// Number of these blocks.
    slow_blocks: usize,
}

impl OneX {
    /// Collects the 1X vectors of probe `i`.
    pub(super) fn new(blocks: &[Block], i: usize) -> Self {
        let figures = || blocks.iter().filter_map(|block| block.probes.get(i).map(|probe| (block.speed_rpm, probe)));
        let raw: Vec<Vector> = figures().map(|(_, probe)| probe.one_x_um).collect();
        let mut slowest: Vec<(f64, Vector)> = figures().map(|(rpm, probe)| (rpm, probe.one_x_um)).collect();
        slowest.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        slowest.truncate((slowest.len() / SLOW_SHARE).clamp(1, MAX_SLOW));
        let mean = |k: usize| slowest.iter().map(|(_, vector)| vector[k]).sum::<f64>() / slowest.len().max(1) as f64;
        let slow_roll = [mean(0), mean(1)];
        let rpm = |slow: Option<&(f64, Vector)>| slow.map_or(f64::NAN, |(rpm, _)| *rpm);
        Self {
            speed_rpm: figures().map(|(rpm, _)| rpm).collect(),
            compensated: raw.iter().map(|v| [v[0] - slow_roll[0], v[1] - slow_roll[1]]).collect(),
            raw,
            twin: figures().map(|(_, probe)| probe.twin_one_x_um).collect(),
            slow_roll,
            slow_rpm: (rpm(slowest.first()), rpm(slowest.last())),
            slow_blocks: slowest.len(),
        }
    }

    /// Describes the slow roll that was subtracted, and its source.
    pub(super) fn words(&self) -> String {
        let (slow, fast) = self.slow_rpm;
        let from = match self.slow_blocks {
            1 => format!("1X vector of the slowest block of four turns, {slow:.0} rpm"),
            n => format!("mean 1X vector of the {n} slowest blocks of four turns, {slow:.0} to {fast:.0} rpm"),
        };
        format!("Slow roll: {from}: {:.3} um pp at {:.0}\u{b0} lag.", amplitude(&self.slow_roll), lag(&self.slow_roll))
    }

    /// Returns true where the phase is significant: the vector is large enough compared with the largest.
    pub(super) fn has_phase(&self, vector: &Vector) -> bool {
        let largest = self.raw.iter().map(amplitude).filter(|a| a.is_finite()).fold(0.0, f64::max);
        amplitude(vector) > LEAST_SHOWN * largest
    }
}

/// Returns the amplitude of a 1X vector, um pp.
pub(super) fn amplitude(vector: &Vector) -> f64 {
    2.0 * vector[0].hypot(vector[1])
}

/// Returns the phase lag behind the keyphasor, 0 to 360 deg.
pub(super) fn lag(vector: &Vector) -> f64 {
    vector[1].atan2(vector[0]).to_degrees().rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_twin::replay::outcome::BlockFigures;

    /// Runout of 3 um peak on a rotor that swings with the square of its speed: compensated, the runout is gone.
    #[test]
    fn run_out_is_subtracted() {
        let block = |rpm: f64| {
            let size = 1e-6 * (rpm - 300.0).powi(2);
            let probe = BlockFigures { one_x_um: [-size, 3.0], ..BlockFigures::default() };
            Block { speed_rpm: rpm, probes: vec![probe], ..Block::default() }
        };
        // Not in order: a run-down and a run-up.
        let fast = (0..42).map(|i| 2000.0 + 50.0 * f64::from(i));
        let blocks: Vec<Block> = fast.chain([300.0, 301.0, 302.0, 303.0, 305.0, 5000.0]).map(block).collect();
        let one_x = OneX::new(&blocks, 0);
        assert_eq!(one_x.slow_rpm, (300.0, 302.0));
        assert!(one_x.words().contains("of the 3 slowest blocks of four turns, 300 to 302 rpm"), "{}", one_x.words());
        assert!((amplitude(&one_x.slow_roll) - 6.0).abs() < 1e-3 && (lag(&one_x.slow_roll) - 90.0).abs() < 1e-3);
        let fast = one_x.compensated.last().copied().unwrap_or_default();
        assert!((amplitude(&fast) - 2.0 * 22.09).abs() < 1e-3 && (lag(&fast) - 180.0).abs() < 1e-3);
        assert!(one_x.has_phase(&fast) && !one_x.has_phase(&[1e-3, 0.0]));
    }
}
