//! A run of the monitor on a machine.

use super::machine::{BLOCKS, Machine};
use ballrace::twin::DamageDetector;
use monitor::{CHANNELS, FRAME, Frames, Monitor, SAMPLES, Verdict};

/// Runs the monitor; passes on each block with its frames and, once in a second, the verdict. Returns none where the constants of the
/// bearing are damaged.
pub fn run(
    is_damaged: bool,
    detector: &'static mut DamageDetector<f32>,
    mut each: impl FnMut(&Monitor, &Frames, Option<Verdict>),
) -> Option<()> {
    let (mut machine, mut monitor) = (Machine::new(is_damaged), Monitor::try_new(detector)?);
    let (mut counts, mut frames) = ([0; CHANNELS * SAMPLES], [0; FRAME * SAMPLES]);
    for _ in 0..BLOCKS {
        let turned = machine.block(&mut counts);
        let verdict = monitor.block(&counts, turned, &mut frames);
        each(&monitor, &frames, verdict);
    }
    Some(())
}

/// Returns the CRC-32 of the bits of the forces and of the status of a block.
pub fn checksum(monitor: &Monitor) -> u32 {
    let mut checksums = [0; 4 * SAMPLES];
    for ((wrench, status), checksum) in monitor.forces().iter().zip(checksums.as_chunks_mut().0) {
        let mut bytes = [0; 24];
        for (word, x) in bytes.as_chunks_mut().0.iter_mut().zip(wrench.to_array()) {
            *word = x.to_bits().to_le_bytes();
        }
        bytes[20] = status.bits();
        *checksum = ballrace::log::crc32(&bytes).to_le_bytes();
    }
    ballrace::log::crc32(&checksums)
}
