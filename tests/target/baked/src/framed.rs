//! A device that computes the forces of a bearing and logs the readings of its probes in frames, one sample at a time.

use super::bearings::bearing_de;
use ballrace::bearing::LastValidWrench;
use ballrace::block::{Metres, ProbedBearing};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::{Displacement, Phase, Status, Wrench};
use core::fmt;

/// Number of samples.
pub const SAMPLES: u32 = 64;

const STILL: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };

/// The bearing between two probes.
pub type Probed = ProbedBearing<f32, bearing_de::Baked, Metres, 2>;

/// The device before its first sample.
pub fn device() -> Probed {
    ProbedBearing {
        bearing: bearing_de::bearing(),
        channels: [Metres; 2],
        directions: [Displacement { u: 1.0, ..STILL }, Displacement { v: 1.0, ..STILL }],
        offset: Displacement { w: 7e-6, ..STILL },
        cage_ratio: SpeedRatio::new(0.41),
        shaft: Phase::ZERO,
        cage: Phase::ZERO,
        last_valid: LastValidWrench::new(),
    }
}

/// Readings of the probes at sample `i`, m: an orbit in steps that every machine computes alike; one is missing.
pub fn readings(i: u32) -> [f32; 2] {
    let part = (i % 32) as f32 / 32.0;
    [if i == 40 { f32::NAN } else { 6e-6 * (part - 0.5) }, 4e-6 * (0.25 - part * part)]
}

/// Returns force and status at these readings.
pub fn force(device: &mut Probed, readings: &[f32; 2]) -> (Wrench<f32>, Status) {
    let mut results = [(Wrench::ZERO, Status::OK)];
    device.samples(readings, PhaseDelta(0x0123_4567_89ab_cdef), 1256.0, &mut results);
    let [result] = results;
    result
}

/// The frame of sample `i`, and force and status, as bits.
pub struct Row {
    /// Frame of the log.
    pub frame: [u8; 16],
    /// Force and status.
    pub result: (Wrench<f32>, Status),
}

impl Row {
    /// Takes sample `i`.
    pub fn new(device: &mut Probed, i: u32) -> Self {
        let readings = readings(i);
        Self { frame: ballrace::log::frame(i, &readings), result: force(device, &readings) }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for byte in self.frame {
            write!(f, "{byte:02x}")?;
        }
        let (wrench, status) = &self.result;
        for x in wrench.to_array() {
            write!(f, ",{:#010x}", x.to_bits())?;
        }
        write!(f, ",{:#04x}", status.bits())
    }
}
