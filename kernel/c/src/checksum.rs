//! Checksum of the forces of a bearing: the same on every target.

use crate::bearing::{Bearing, KinematicState, ballrace_sample_at};
use crate::last_valid::{LastValid, ballrace_last_valid_init};
use ballrace::{Displacement, Status, Wrench};

/// Displacements and speeds of the 1024 evaluations of a checksum. `ballrace bake --language c` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChecksumRange {
    /// Centre of the displacements, m and rad.
    pub centre: [f32; 5],
    /// Largest deviation from the centre, m and rad.
    pub amplitude: [f32; 5],
    /// Speed of the inner ring at the first sample and its increment per sample, rad/s.
    pub inner_speed: [f32; 2],
    /// Speed of the outer ring at the first sample and its increment per sample, rad/s.
    pub outer_speed: [f32; 2],
}

impl From<&ChecksumRange> for ballrace::bearing::checksum::ChecksumRange {
    fn from(range: &ChecksumRange) -> Self {
        let ChecksumRange { centre, amplitude, inner_speed, outer_speed } = *range;
        let [centre, amplitude] = [centre, amplitude].map(Displacement::from_array);
        Self { centre, amplitude, inner_speed, outer_speed }
    }
}

/// Computes the checksum of 1024 forces by `ballrace_sample_at`: FNV-1a with 64 bits over the bits of force, moment and
/// status. For start-up: a value other than that of `ballrace bake` shows a damaged image. A NULL pointer gives 0.
///
/// # Safety
/// `bearing` is the head of a struct of its model, `range` points to a range; both may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_checksum(bearing: *const Bearing, range: *const ChecksumRange) -> u64 {
    if bearing.is_null() || range.is_null() {
        return 0;
    }
    let mut last_valid = LastValid { words: [0; 4] };
    // SAFETY: the pointers are valid by the contract of the function, the others are those of local values.
    unsafe {
        ballrace_last_valid_init(&raw mut last_valid);
        ballrace::bearing::checksum::ChecksumRange::from(&*range).checksum_of(|u, at| {
            let (displacement, mut wrench) = (u.to_array(), [0.0; 5]);
            let [cage, inner, outer, ball] = [at.cage, at.inner, at.outer, at.ball].map(|phase| phase.0);
            let (inner_speed, outer_speed) = (at.inner_speed, at.outer_speed);
            let state = KinematicState { cage, inner, outer, ball, inner_speed, outer_speed };
            let status = ballrace_sample_at(
                bearing,
                &raw mut last_valid,
                displacement.as_ptr(),
                &raw const state,
                wrench.as_mut_ptr(),
            );
            (Wrench::from_array(wrench), Status::from_bits(status as u8))
        })
    }
}
