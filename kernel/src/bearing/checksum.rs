//! Checksum of the forces of a bearing over a fixed sequence of displacements: the same on every target.
//!
//! `ballrace bake` writes the checksum that the desktop computes beside the constants of a bearing. Firmware computes it at
//! start-up: a difference shows a damaged image, or a compiler or a processor that rounds otherwise.

use super::{Bearing, LastValidWrench};
use crate::frame::{Displacement, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::phase::Phase;
use crate::status::Status;

/// Number of evaluations of a checksum.
pub const CHECKSUM_SAMPLES: u16 = 1024;

/// Multiplier and increment of the linear congruential generator of Numerical Recipes (Press et al., 1992, section 7.1).
const LCG: [u32; 2] = [1_664_525, 1_013_904_223];
/// First state of the generator.
const LCG_SEED: u32 = 1;
/// 2^-23, the scale of a signed integer of 24 bits.
const PER_COUNT: f32 = 1.0 / 8_388_608.0;
/// Angles per sample of cage, inner ring, outer ring and balls: 2^64 divided by an irrational number, odd.
const ANGLES: [u64; 4] = [0x9E37_79B9_7F4A_7C15, 0xC13F_A9A9_02A6_328F, 0x91E1_0DA5_C79E_7B1D, 0xD1B5_4A32_D192_ED03];
/// Offset basis and prime of FNV-1a with 64 bits (RFC 9923).
const FNV: [u64; 2] = [0xCBF2_9CE4_8422_2325, 0x0000_0100_0000_01B3];
/// Bits by which every NaN counts.
const NAN_BITS: u32 = 0x7FC0_0000;

/// Displacements and speeds of the evaluations of a checksum.
///
/// ```
/// use ballrace::bearing::checksum::ChecksumRange;
/// use ballrace::bearing::linear::Linear;
/// use ballrace::{Displacement, Stiffness};
///
/// let range = ChecksumRange {
///     centre: Displacement::default(),
///     amplitude: Displacement { u: 1e-5, v: 1e-5, w: 1e-5, thu: 1e-4, thv: 1e-4 },
///     inner_speed: [0.0, 0.0],
///     outer_speed: [0.0, 0.0],
/// };
/// let spring = Linear::new(Stiffness::from_diagonal_element(1e8_f32));
/// assert_eq!(range.checksum(&spring), range.checksum(&spring));
/// let other = Linear::new(Stiffness::from_diagonal_element(100_000_010.0_f32));
/// assert_ne!(range.checksum(&spring), range.checksum(&other));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChecksumRange {
    /// Centre of the displacements, m and rad.
    pub centre: Displacement<f32>,
    /// Largest deviation from the centre, m and rad.
    pub amplitude: Displacement<f32>,
    /// Speed of the inner ring at the first sample and its increment per sample, rad/s.
    pub inner_speed: [f32; 2],
    /// Speed of the outer ring at the first sample and its increment per sample, rad/s.
    pub outer_speed: [f32; 2],
}

impl ChecksumRange {
    /// Returns the displacements and kinematic states of the [`CHECKSUM_SAMPLES`] evaluations. Cost per sample: 20 integer
    /// operations, 7 conversions, 12 products and 7 sums.
    #[must_use]
    pub fn samples(&self) -> ChecksumPoses {
        ChecksumPoses { range: *self, count: 0, random: LCG_SEED }
    }

    /// Computes the checksum of [`Bearing::sample`]: FNV-1a with 64 bits over the bits of force, moment and status of each sample,
    /// each number with its least significant byte first. -0 counts as 0 and every NaN as the same number. Cost: 1024 forces; [`Checksum`]
    /// takes them in parts.
    pub fn checksum<B: Bearing<f32> + ?Sized>(&self, bearing: &B) -> u64 {
        let mut last_valid = LastValidWrench::new();
        self.checksum_of(|u, at| bearing.sample(&mut last_valid, u, at))
    }

    /// Computes the checksum of a function that returns force and status, such as one in another language.
    pub fn checksum_of(
        &self,
        mut force: impl FnMut(&Displacement<f32>, &BearingKinematicState<f32>) -> (Wrench<f32>, Status),
    ) -> u64 {
        let mut checksum = Checksum::begin(self);
        while checksum.next_of(&mut force) {}
        checksum.hash
    }
}

/// A checksum that is computed in parts, so that firmware resets its watchdog between them.
///
/// ```
/// use ballrace::bearing::checksum::{Checksum, ChecksumRange};
/// use ballrace::bearing::linear::Linear;
/// use ballrace::{Displacement, Stiffness};
///
/// # let about = Displacement { u: 1e-5, v: 1e-5, w: 1e-5, thu: 1e-4, thv: 1e-4 };
/// # let range = ChecksumRange { centre: Displacement::default(), amplitude: about, inner_speed: [0.0; 2], outer_speed: [0.0; 2] };
/// let spring = Linear::new(Stiffness::from_diagonal_element(1e8_f32));
/// let mut checksum = Checksum::begin(&range);
/// let whole = loop {
///     if let Some(whole) = checksum.advance(&spring, 100) {
///         break whole;
///     }
///     // Reset the watchdog here.
/// };
/// assert_eq!(whole, range.checksum(&spring));
/// ```
#[derive(Debug, Clone)]
pub struct Checksum {
    poses: ChecksumPoses,
    last_valid: LastValidWrench<f32>,
    hash: u64,
}

impl Checksum {
    /// Returns the checksum before its first force.
    #[must_use]
    pub fn begin(range: &ChecksumRange) -> Self {
        let [basis, _] = FNV;
        Self { poses: range.samples(), last_valid: LastValidWrench::new(), hash: basis }
    }

    /// Takes further `samples` forces. Returns the checksum once all 1024 are taken.
    pub fn advance<B: Bearing<f32> + ?Sized>(&mut self, bearing: &B, samples: u16) -> Option<u64> {
        let mut last_valid = self.last_valid;
        let checksum = self.advance_of(|u, at| bearing.sample(&mut last_valid, u, at), samples);
        self.last_valid = last_valid;
        checksum
    }

    /// As [`Checksum::advance`] for a function that returns force and status.
    pub fn advance_of(
        &mut self,
        mut force: impl FnMut(&Displacement<f32>, &BearingKinematicState<f32>) -> (Wrench<f32>, Status),
        samples: u16,
    ) -> Option<u64> {
        for _ in 0..samples {
            if !self.next_of(&mut force) {
                break;
            }
        }
        (self.poses.count >= CHECKSUM_SAMPLES).then_some(self.hash)
    }

    /// Takes a force; returns false where all are taken.
    fn next_of(
        &mut self,
        force: &mut impl FnMut(&Displacement<f32>, &BearingKinematicState<f32>) -> (Wrench<f32>, Status),
    ) -> bool {
        let Some((u, at)) = self.poses.next() else { return false };
        let (wrench, status) = force(&u, &at);
        let bits = wrench.to_array().map(canonical_bits);
        let hash = bits.into_iter().fold(self.hash, |hash, x| hashed(hash, &x.to_le_bytes()));
        self.hash = hashed(hash, &[status.bits()]);
        true
    }
}

/// Returns the hash after further bytes.
fn hashed(hash: u64, bytes: &[u8]) -> u64 {
    let [_, prime] = FNV;
    bytes.iter().fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(prime))
}

/// Returns the bits of a number; those of 0 for -0, and one pattern for every NaN.
fn canonical_bits(x: f32) -> u32 {
    if x.is_nan() { NAN_BITS } else { (x + 0.0).to_bits() }
}

/// Iterator over the evaluations of a checksum; see [`ChecksumRange::samples`].
#[derive(Debug, Clone)]
pub struct ChecksumPoses {
    range: ChecksumRange,
    count: u16,
    random: u32,
}

impl ChecksumPoses {
    /// Returns the next number of the sequence, -1 to 1: a signed integer of 24 bits, which a conversion keeps exactly.
    fn fraction(&mut self) -> f32 {
        let [multiplier, increment] = LCG;
        self.random = self.random.wrapping_mul(multiplier).wrapping_add(increment);
        let signed = i32::from_ne_bytes(self.random.to_ne_bytes()) >> 8;
        signed as f32 * PER_COUNT
    }
}

impl Iterator for ChecksumPoses {
    type Item = (Displacement<f32>, BearingKinematicState<f32>);

    fn next(&mut self) -> Option<Self::Item> {
        if self.count >= CHECKSUM_SAMPLES {
            return None;
        }
        let ChecksumRange { centre, amplitude, inner_speed, outer_speed } = self.range;
        let mut about = |centre: f32, amplitude: f32| centre + amplitude * self.fraction();
        let u = Displacement {
            u: about(centre.u, amplitude.u),
            v: about(centre.v, amplitude.v),
            w: about(centre.w, amplitude.w),
            thu: about(centre.thu, amplitude.thu),
            thv: about(centre.thv, amplitude.thv),
        };
        let (count, i) = (u64::from(self.count), f32::from(self.count));
        let [cage, inner, outer, ball] = ANGLES.map(|per_sample| Phase(per_sample.wrapping_mul(count)));
        let speed = |[first, increment]: [f32; 2]| first + increment * i;
        let at = BearingKinematicState {
            cage,
            inner,
            outer,
            ball,
            inner_speed: speed(inner_speed),
            outer_speed: speed(outer_speed),
        };
        self.count += 1;
        Some((u, at))
    }
}
