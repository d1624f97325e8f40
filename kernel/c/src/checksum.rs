//! Checksum of the forces of a bearing: the same on every target.

use crate::bearing::{Bearing, KinematicState, ballrace_sample_at};
use crate::last_valid::{LastValid, ballrace_last_valid_init};
use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::{BearingKinematicState, Displacement, Status, Wrench};

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
    // SAFETY: by the contract of the function.
    let range = ballrace::bearing::checksum::ChecksumRange::from(unsafe { &*range });
    let mut last_valid = LastValid { words: [0; 4] };
    // SAFETY: the pointers are valid by the contract of the function, the others are those of local values.
    unsafe {
        ballrace_last_valid_init(&raw mut last_valid);
        range.checksum_of(|u, at| sample(bearing, &raw mut last_valid, u, at))
    }
}

/// A checksum that is computed in parts. Opaque: `ballrace_checksum_begin` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Checksum {
    /// Private.
    pub words: [u64; 17],
}

/// A checksum, with the last valid force of its samples.
struct Partial {
    checksum: ballrace::bearing::checksum::Checksum,
    last_valid: LastValid,
}

impl Stored for Partial {
    const KIND: u32 = 6;
}

/// Begins a checksum that `ballrace_checksum_advance` computes in parts, so that a watchdog can be reset between them.
///
/// # Safety
/// `checksum` and `range` point to structs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_checksum_begin(checksum: *mut Checksum, range: *const ChecksumRange) -> u32 {
    check_pointers!(checksum, range);
    let mut last_valid = LastValid { words: [0; 4] };
    // SAFETY: by the contract of the function.
    unsafe {
        ballrace_last_valid_init(&raw mut last_valid);
        let begin = ballrace::bearing::checksum::Checksum::begin(&(&*range).into());
        state::write(checksum, Partial { checksum: begin, last_valid });
    }
    status::OK
}

/// Takes further `samples` forces. Returns `BALLRACE_INCOMPLETE` until all 1024 are taken, then `BALLRACE_OK`, with the value of
/// `ballrace_checksum` in `value`.
///
/// # Safety
/// `checksum` points to a struct that `ballrace_checksum_begin` wrote, `bearing` is the head of a struct of its model, `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_checksum_advance(
    checksum: *mut Checksum,
    bearing: *const Bearing,
    samples: u32,
    value: *mut u64,
) -> u32 {
    check_pointers!(checksum, bearing, value);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(partial) = state::get::<Partial, _>(checksum) else { return status::STATE_INVALID };
        let Partial { checksum, last_valid } = partial;
        let samples = u16::try_from(samples).unwrap_or(u16::MAX);
        match checksum.advance_of(|u, at| sample(bearing, last_valid, u, at), samples) {
            Some(whole) => *value = whole,
            None => return status::INCOMPLETE,
        }
    }
    status::OK
}

/// Evaluates one pose.
///
/// # Safety
/// As `ballrace_sample_at`.
unsafe fn sample(
    bearing: *const Bearing,
    last_valid: *mut LastValid,
    u: &Displacement<f32>,
    at: &BearingKinematicState<f32>,
) -> (Wrench<f32>, Status) {
    let (displacement, mut wrench) = (u.to_array(), [0.0; 5]);
    let state = KinematicState::from_kernel(at);
    // SAFETY: the pointers are valid by the contract of the function, the others are those of local values.
    let status = unsafe { ballrace_sample_at(bearing, last_valid, displacement.as_ptr(), state, wrench.as_mut_ptr()) };
    (Wrench::from_array(wrench), Status::from_bits(status as u8))
}
