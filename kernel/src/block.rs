//! Forces for a block of samples: a buffer of interleaved channels, as a converter with direct memory access (DMA) fills it.

use crate::bearing::{Bearing, LastValidWrench};
use crate::frame::{Displacement, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::phase::{Phase, PhaseDelta, SpeedRatio};
use crate::probe::Probe;
use crate::scalar::Scalar;
use crate::status::Status;

/// A channel of a buffer: a reading to metres.
pub trait Channel<T, R> {
    /// Returns the displacement of this reading, m, and whether the channel is OK. Takes a constant number of instructions.
    fn read(&mut self, reading: R) -> (T, Status);
}

impl<T: Scalar> Channel<T, u16> for Probe<T> {
    #[inline]
    fn read(&mut self, counts: u16) -> (T, Status) {
        self.sample(u32::from(counts))
    }
}

/// A count of a converter with a sign: the probe takes it in offset binary, in which -32768 is the count 0 and 0 the count 32768.
impl<T: Scalar> Channel<T, i16> for Probe<T> {
    #[inline]
    fn read(&mut self, counts: i16) -> (T, Status) {
        self.sample(u32::from(counts.cast_unsigned() ^ 0x8000))
    }
}

/// A channel whose readings are metres already. A reading that is not finite is flagged by the bearing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Metres;

impl<T: Scalar> Channel<T, T> for Metres {
    #[inline]
    fn read(&mut self, reading: T) -> (T, Status) {
        (reading, Status::OK)
    }
}

/// Returns the displacement `offset + sum_i directions_i x_i` of a bearing from one reading of each channel, summed in the order of the
/// channels, and the status of all. What the longer of them have more has no effect.
#[inline]
pub fn displacement<T: Scalar, R: Copy, C: Channel<T, R>>(
    offset: Displacement<T>,
    channels: &mut [C],
    directions: impl IntoIterator<Item = Displacement<T>>,
    readings: &[R],
) -> (Displacement<T>, Status) {
    let (mut u, mut status) = (offset, Status::OK);
    for ((channel, along), &reading) in channels.iter_mut().zip(directions).zip(readings) {
        let (x, of_channel) = channel.read(reading);
        u = Displacement {
            u: u.u + along.u * x,
            v: u.v + along.v * x,
            w: u.w + along.w * x,
            thu: u.thu + along.thu * x,
            thv: u.thv + along.thv * x,
        };
        status |= of_channel;
    }
    (u, status)
}

/// A bearing whose displacement `N` channels measure, and where its shaft and cage are.
///
/// ```
/// use ballrace::bearing::{LastValidWrench, linear::Linear};
/// use ballrace::block::{Metres, ProbedBearing};
/// use ballrace::phase::{PhaseDelta, SpeedRatio};
/// use ballrace::{Displacement, Phase, Status, Stiffness, Wrench};
///
/// let still = Displacement::default();
/// let mut end = ProbedBearing {
///     bearing: Linear::new(Stiffness::from_diagonal_element(1e8_f32)),
///     channels: [Metres; 2],
///     directions: [Displacement { u: 1.0, ..still }, Displacement { v: 1.0, ..still }],
///     offset: still,
///     cage_ratio: SpeedRatio::new(0.4),
///     shaft: Phase::ZERO,
///     cage: Phase::ZERO,
///     last_valid: LastValidWrench::new(),
/// };
/// let mut forces = [(Wrench::ZERO, Status::OK); 2];
/// let turned = PhaseDelta(1 << 56);
/// assert_eq!(end.samples(&[1e-6, 0.0, f32::NAN, 2e-6], turned, 314.0, &mut forces), 2);
/// assert!((forces[0].0.fx + 100.0).abs() < 1e-3 && forces[1].1 == Status::INPUT_NOT_FINITE);
/// assert_eq!(end.shaft, Phase(1 << 57));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ProbedBearing<T, B, C, const N: usize> {
    /// Model of the bearing.
    pub bearing: B,
    /// The channels in the order in which the buffer has them: [`Probe`] for counts, [`Metres`] for metres.
    pub channels: [C; N],
    /// Displacement of the bearing per metre of each channel: the probe along X has `u` = 1 and else 0.
    pub directions: [Displacement<T>; N],
    /// Displacement where all channels read 0, such as that by preload.
    pub offset: Displacement<T>,
    /// Speed of the cage by that of the shaft.
    pub cage_ratio: SpeedRatio,
    /// Angle of the shaft at the last sample.
    pub shaft: Phase,
    /// Angle of the cage at the last sample.
    pub cage: Phase,
    /// Last valid force.
    pub last_valid: LastValidWrench<T>,
}

impl<T: Scalar, B: Bearing<T>, C, const N: usize> ProbedBearing<T, B, C, N> {
    /// Computes force and status of each sample of `buffer`: `N` readings a sample, in the order of the channels. The shaft turns by `turned`
    /// before each sample, at `inner_speed` (rad/s).
    ///
    /// Returns the number of samples: those that the buffer has completely, or the length of `results` where that is less. Readings after them
    /// are not taken, and results after them not written.
    ///
    /// Each sample takes the same number of instructions: [`Bearing::sample`], `N` channels, `5 N` products and sums, and the advance of the
    /// angles.
    pub fn samples<R: Copy>(
        &mut self,
        buffer: &[R],
        turned: PhaseDelta,
        inner_speed: T,
        results: &mut [(Wrench<T>, Status)],
    ) -> usize
    where
        C: Channel<T, R>,
    {
        let (samples, _) = buffer.as_chunks::<N>();
        let cage_turned = self.cage_ratio.apply(turned);
        for (readings, result) in samples.iter().zip(results.iter_mut()) {
            self.shaft = self.shaft.advanced(turned);
            self.cage = self.cage.advanced(cage_turned);
            let (u, of_channels) = displacement(self.offset, &mut self.channels, self.directions, readings);
            let (cage, inner) = (self.cage, self.shaft);
            let at = BearingKinematicState { cage, inner, inner_speed, ..BearingKinematicState::default() };
            let (wrench, status) = self.bearing.sample(&mut self.last_valid, &u, &at);
            *result = (wrench, status | of_channels);
        }
        samples.len().min(results.len())
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::bearing::evenly_spaced;
    use crate::bearing::lumped::Radial;
    use crate::contact::law::PointContactLaw;
    use crate::math::Exact;
    use crate::probe::ProbeParams;

    type Ball = Radial<f32, Exact, PointContactLaw<f32>, [crate::bearing::ElementPosition<f32>; 9]>;

    const STILL: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };
    const TURNED: PhaseDelta = PhaseDelta(0x0123_4567_89ab_cdef);

    fn probe() -> Probe<f32> {
        Probe::from_constants(ProbeParams {
            at_zero: -32.768e-3,
            per_count: 1e-6,
            linear_range: [1000, 60_000],
            stuck_after: 3,
        })
    }

    fn probed<C>(channels: [C; 2]) -> ProbedBearing<f32, Ball, C, 2> {
        ProbedBearing {
            bearing: Radial::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness: 8e9 }, 2e-6).unwrap(),
            channels,
            directions: [Displacement { u: 1.0, ..STILL }, Displacement { v: 1.0, ..STILL }],
            offset: Displacement { u: 3e-6, ..STILL },
            cage_ratio: SpeedRatio::new(0.4),
            shaft: Phase::ZERO,
            cage: Phase::ZERO,
            last_valid: LastValidWrench::new(),
        }
    }

    /// A block gives the forces of the calls that it replaces, one by one, also with a railed and a stuck channel.
    #[test]
    fn a_block_is_its_samples() {
        let counts: [u16; 12] = [32_780, 32_760, 65_535, 32_761, 32_781, 32_761, 32_782, 32_761, 32_783, 32_761, 1, 2];
        let mut block = probed([probe(); 2]);
        let mut found = [(Wrench::ZERO, Status::OK); 6];
        assert_eq!(block.samples(&counts, TURNED, 300.0, &mut found), 6);

        let mut one = probed([probe(); 2]);
        for (reading, found) in counts.as_chunks::<2>().0.iter().zip(found) {
            one.shaft = one.shaft.advanced(TURNED);
            one.cage = one.cage.advanced(one.cage_ratio.apply(TURNED));
            let [(x, of_x), (y, of_y)] = [0, 1].map(|i| one.channels[i].sample(u32::from(reading[i])));
            let u = Displacement { u: x, v: y, ..STILL } + one.offset;
            let at =
                BearingKinematicState { cage: one.cage, inner: one.shaft, inner_speed: 300.0, ..Default::default() };
            let (wrench, status) = one.bearing.sample(&mut one.last_valid, &u, &at);
            assert_eq!(found, (wrench, status | of_x | of_y));
        }
        assert_eq!((block.shaft, block.cage, block.channels), (one.shaft, one.cage, one.channels));
        let not_ok = found.map(|(_, status)| status.contains(Status::INPUT_NOT_OK));
        assert_eq!(not_ok, [false, true, false, false, true, true], "railed, then stuck, then below the range");
    }

    /// Counts with a sign are those in offset binary, and metres those that the counts mean.
    #[test]
    fn readings_of_every_kind_give_the_same_forces() {
        let counts: [u16; 6] = [32_780, 32_760, 32_781, 32_761, 32_790, 32_755];
        let mut found = [[(Wrench::ZERO, Status::OK); 3]; 3];
        let [of_counts, of_signed, of_metres] = &mut found;
        probed([probe(); 2]).samples(&counts, TURNED, 0.0, of_counts);
        let signed = counts.map(|x| (i32::from(x) - 32_768) as i16);
        probed([probe(); 2]).samples(&signed, TURNED, 0.0, of_signed);
        let mut there = probe();
        let metres = counts.map(|x| there.sample(u32::from(x)).0);
        probed([Metres; 2]).samples(&metres, TURNED, 0.0, of_metres);
        assert!(found[0].iter().any(|(wrench, _)| wrench.fx != 0.0), "{found:?}");
        assert_eq!(found[0], found[1]);
        assert_eq!(found[0], found[2]);
    }

    /// Too few results and an incomplete sample leave the rest as it is.
    #[test]
    fn the_shorter_slice_ends_the_block() {
        let mut end = probed([Metres; 2]);
        let mut results = [(Wrench::ZERO, Status::NOT_CONVERGED); 3];
        assert_eq!(end.samples(&[1e-5, 0.0, 1e-5], TURNED, 0.0, &mut results), 1);
        assert_eq!((end.shaft, results[1].1), (Phase::ZERO.advanced(TURNED), Status::NOT_CONVERGED));
        assert_eq!(end.samples(&[1e-5; 10], TURNED, 0.0, &mut results[..2]), 2);
        assert_eq!(end.samples(&[], TURNED, 0.0, &mut results), 0);
    }
}

#[cfg(all(test, feature = "serde"))]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod data {
    use crate::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
    use crate::phase::SpeedRatio;
    use crate::probe::ProbeParams;
    use crate::{BearingKinematicState, Displacement, Phase, Status, Wrench};

    extern crate std;

    /// Names are those of the fields; a phase, a ratio and a status are numbers.
    #[test]
    fn public_data_comes_back_from_json() {
        fn back<D: serde::Serialize + serde::de::DeserializeOwned + PartialEq + core::fmt::Debug>(data: D, text: &str) {
            let written = serde_json::to_string(&data).unwrap();
            assert!(written.contains(text), "{written}");
            assert_eq!(serde_json::from_str::<D>(&written).unwrap(), data);
        }
        back(Displacement { u: 1e-6_f32, v: -0.0, w: 0.1, thu: 0.0, thv: 0.0 }, r#""u":0.000001,"v":-0.0,"w":0.1"#);
        back(Wrench { fx: 1.0_f64, ..Wrench::default() }, r#""fx":1.0"#);
        back(
            BearingKinematicState { cage: Phase(u64::MAX), inner_speed: 3.0_f32, ..Default::default() },
            "18446744073709551615",
        );
        back(SpeedRatio::new(0.25), "18014398509481984");
        back(Status::CONTACT_LOST | Status::OUT_OF_TABLE, "36");
        let probe = ProbeParams { at_zero: -1e-3_f32, per_count: 1e-6, linear_range: [4, 4000], stuck_after: 7 };
        back(probe, r#""linear_range":[4,4000]"#);
        let geometry = BallBearingGeometry {
            ball_diameter: 7.94e-3,
            pitch_diameter: 39.04e-3,
            inner_conformity: 0.52,
            outer_conformity: 0.52,
            contact_angle: 0.1,
            ball: BEARING_STEEL,
            race: BEARING_STEEL,
        };
        back(geometry, r#""race":{"youngs_modulus":206000000000.0"#);
    }
}
