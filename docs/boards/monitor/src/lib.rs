//! Monitor of one bearing, without hardware: counts of a converter become forces, a verdict every second, and a log.
#![no_std]

#[path = "../bearings.rs"]
#[rustfmt::skip]
pub mod bearings;

use ballrace::bearing::LastValidWrench;
use ballrace::bearing::kinematics::{Orders, orders};
use ballrace::block::{Metres, ProbedBearing};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::probe::{Probe, ProbeParams};
use ballrace::twin::{BlockStatistics, DamageDetector, DamageVerdict, Statistics};
use ballrace::{Displacement, Exact, Math, Phase, Status, Wrench, log};
use bearings::bearing_de;

/// Samples a second, Hz.
pub const RATE: u32 = 6400;
/// Samples of a block: half of the buffer that the converter fills, 40 ms.
pub const SAMPLES: usize = 256;
/// Channels of the converter: probe along X, probe along Y, accelerometer.
pub const CHANNELS: usize = 3;
/// Counts of a block, interleaved.
pub type Counts = [u16; CHANNELS * SAMPLES];
/// Bytes of a frame: number, two probes, accelerometer, speed, checksum.
pub const FRAME: usize = 24;
/// Frames of a block.
pub type Frames = [u8; FRAME * SAMPLES];

/// A proximity probe of 7.87 mV/um, shifted from its -9.5 V to the middle of 3.3 V and 12 bits: 0.102 um a count.
pub const PROBE: ProbeParams<f32> =
    ProbeParams { at_zero: -209.66e-6, per_count: 0.102_37e-6, linear_range: [200, 3895], stuck_after: RATE / 10 };
/// An accelerometer of 26.4 mV/g around the middle of 3.3 V: 0.299 m/s^2 a count. Its parameters are m/s^2 instead of m.
pub const ACCELEROMETER: ProbeParams<f32> =
    ProbeParams { at_zero: -612.9, per_count: 0.299_28, linear_range: [100, 3995], stuck_after: RATE / 10 };

/// Verdict on a second.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdict {
    /// Radial force of the bearing, N.
    pub force: BlockStatistics<f32>,
    /// Samples in which a channel was not OK.
    pub not_ok: u32,
    /// Damage, from the last 64 to 512 revolutions.
    pub damage: DamageVerdict<f32>,
}

/// A bearing between two probes, with an accelerometer on its housing.
pub struct Monitor {
    channels: [Probe<f32>; CHANNELS],
    bearing: ProbedBearing<f32, bearing_de::Baked, Metres, 2>,
    forces: [(Wrench<f32>, Status); SAMPLES],
    statistics: Statistics<f32>,
    orders: Orders,
    detector: &'static mut DamageDetector<f32>,
    damage: DamageVerdict<f32>,
    not_ok: u32,
    number: u32,
}

impl Monitor {
    /// Creates the monitor; the detector of 25 kB lies in a `static`. Returns none where the constants in flash are damaged.
    #[must_use]
    pub fn try_new(detector: &'static mut DamageDetector<f32>) -> Option<Self> {
        if bearing_de::checksum() != bearing_de::CHECKSUM {
            return None;
        }
        let still = Displacement::default();
        let bearing = ProbedBearing {
            bearing: bearing_de::bearing(),
            channels: [Metres; 2],
            directions: [Displacement { u: 1.0, ..still }, Displacement { v: 1.0, ..still }],
            offset: bearing_de::OFFSET,
            cage_ratio: SpeedRatio::new(bearing_de::CAGE_RATIO),
            shaft: Phase::ZERO,
            cage: Phase::ZERO,
            last_valid: LastValidWrench::new(),
        };
        // Ball over pitch diameter, times the cosine of the contact angle.
        let ratio = 1.0 - 2.0 * bearing_de::CAGE_RATIO;
        Some(Self {
            channels: [PROBE, PROBE, ACCELEROMETER].map(Probe::from_constants),
            bearing,
            forces: [(Wrench::ZERO, Status::OK); SAMPLES],
            statistics: Statistics::new(RATE),
            orders: orders(bearing_de::POSITIONS.len(), ratio, ratio),
            detector,
            damage: DamageVerdict::default(),
            not_ok: 0,
            number: 0,
        })
    }

    /// Takes a block, during which the shaft turns by `turned` before each sample. Writes the frames of its samples, and returns the verdict
    /// once in [`RATE`] samples.
    ///
    /// A channel that is not OK is missing in the frame; the force is then held, and the detector takes the last valid acceleration.
    pub fn block(&mut self, counts: &Counts, turned: PhaseDelta, frames: &mut Frames) -> Option<Verdict> {
        let speed = turned.radians::<f32>() * RATE as f32;
        let mut shaft = self.bearing.shaft;
        let mut displacements = [0.0; 2 * SAMPLES];
        let samples = counts.as_chunks::<CHANNELS>().0.iter();
        let outputs = displacements.as_chunks_mut().0.iter_mut().zip(frames.as_chunks_mut::<FRAME>().0);
        for (counts, (displacement, frame)) in samples.zip(outputs) {
            let [x, y, acceleration] = &mut self.channels;
            let [of_x, of_y, of_acceleration] = *counts;
            let [x, y, acceleration] =
                [x.sample(of_x.into()), y.sample(of_y.into()), acceleration.sample(of_acceleration.into())];
            shaft = shaft.advanced(turned);
            if self.detector.add(acceleration.0, shaft) {
                self.damage = self.detector.close::<Exact>(&self.orders);
            }
            *displacement = [x, y].map(valid);
            let [u, v] = *displacement;
            *frame = log::frame(self.number, &[u, v, valid(acceleration), speed]);
            self.number = self.number.wrapping_add(1);
            self.not_ok += u32::from([x, y, acceleration].iter().any(|(_, status)| *status != Status::OK));
        }
        self.bearing.samples(&displacements, turned, speed, &mut self.forces);
        let mut verdict = None;
        for (force, _) in &self.forces {
            let radial = Exact::sqrt(force.fx * force.fx + force.fy * force.fy);
            if let Some(force) = self.statistics.add::<Exact>(radial) {
                verdict = Some(Verdict { force, not_ok: core::mem::take(&mut self.not_ok), damage: self.damage });
            }
        }
        verdict
    }

    /// Returns force and status of each sample of the last block.
    #[must_use]
    pub fn forces(&self) -> &[(Wrench<f32>, Status); SAMPLES] {
        &self.forces
    }

    /// Continues with this block after some that were lost, counted from the start: the numbers of the frames have a gap.
    pub fn continue_at(&mut self, block: u32) {
        self.number = block.wrapping_mul(SAMPLES as u32);
    }
}

/// Returns a reading, and NaN where the channel is not OK: a missing reading.
fn valid((reading, status): (f32, Status)) -> f32 {
    if status == Status::OK { reading } else { f32::NAN }
}
