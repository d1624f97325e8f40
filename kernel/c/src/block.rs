//! Forces for a block of samples: a buffer of interleaved channels, as a converter with direct memory access (DMA) fills it.

use crate::bearing::{Bearing, KinematicState, ballrace_sample_at};
use crate::last_valid::LastValid;
use crate::pointer::{self, check_bearing, check_pointers};
use crate::probe::Probe;
use crate::state;
use crate::status;
use ballrace::block::{self, Channel, Metres};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::{Displacement, Phase, Status, probe};

/// A bearing whose displacement channels measure, and where its shaft and cage are.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ProbedBearing {
    /// Head of the bearing.
    pub bearing: *const Bearing,
    /// Last valid force.
    pub last_valid: *mut LastValid,
    /// Initialised probes in the order in which the buffer has their channels; not read where the buffer has metres.
    pub probes: *mut Probe,
    /// Displacement of the bearing per metre of each channel, five floats a channel: the probe along X has 1 and four times 0.
    pub directions: *const f32,
    /// Number of channels.
    pub channel_count: u32,
    /// Displacement where all channels read 0, such as that by preload.
    pub offset: [f32; 5],
    /// Speed of the cage by that of the shaft, from `ballrace_speed_ratio`.
    pub cage_ratio: i64,
    /// Angle of the shaft at the last sample, 2^-64 revolutions.
    pub shaft: u64,
    /// Angle of the cage at the last sample, 2^-64 revolutions.
    pub cage: u64,
}

impl<R> Channel<f32, R> for Probe
where
    probe::Probe<f32>: Channel<f32, R>,
{
    #[inline(always)]
    fn read(&mut self, reading: R) -> (f32, Status) {
        // SAFETY: a reference to a struct.
        match unsafe { state::get::<probe::Probe<f32>, _>(core::ptr::from_mut(self)) } {
            Some(probe) => probe.read(reading),
            None => (0.0, Status::INPUT_NOT_OK),
        }
    }
}

/// Computes force and status of every sample; returns the status bits of all.
///
/// # Safety
/// As `ballrace_block_u16`; `channels` points to as many channels as the bearing has.
#[inline(always)]
unsafe fn samples<R: Copy, C: Channel<f32, R>>(
    end: &mut ProbedBearing,
    channels: *mut C,
    buffer: *const R,
    sample_count: u32,
    turned: i64,
    inner_speed: f32,
    (wrenches, statuses): (*mut f32, *mut u32),
) -> u32 {
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe {
        let count = end.channel_count as usize;
        let channels = core::slice::from_raw_parts_mut(channels, count);
        let directions = core::slice::from_raw_parts(end.directions.cast::<[f32; 5]>(), count);
        let offset = Displacement::from_array(end.offset);
        let cage_turned = SpeedRatio::from_bits(end.cage_ratio).apply(PhaseDelta(turned));
        let mut all = status::OK;
        for i in 0..sample_count as usize {
            end.shaft = Phase(end.shaft).advanced(PhaseDelta(turned)).0;
            end.cage = Phase(end.cage).advanced(cage_turned).0;
            let readings = core::slice::from_raw_parts(buffer.add(i * count), count);
            let (u, of_channels) = block::displacement(
                offset,
                channels,
                directions.iter().map(|d| Displacement::from_array(*d)),
                readings,
            );
            let (displacement, cage, inner) = (u.to_array(), end.cage, end.shaft);
            let at = KinematicState { cage, inner, inner_speed, ..KinematicState::default() };
            let wrench = wrenches.add(5 * i);
            let status = ballrace_sample_at(end.bearing, end.last_valid, displacement.as_ptr(), &raw const at, wrench)
                | u32::from(of_channels.bits());
            *statuses.add(i) = status;
            all |= status;
        }
        all
    }
}

/// As [`samples`] with the probes of the bearing; `BALLRACE_STATE_INVALID` where one of them is not initialised.
///
/// # Safety
/// As [`samples`].
#[inline(always)]
unsafe fn samples_of_probes<R: Copy>(
    end: *mut ProbedBearing,
    buffer: *const R,
    sample_count: u32,
    turned: i64,
    inner_speed: f32,
    wrenches: *mut f32,
    statuses: *mut u32,
) -> u32
where
    probe::Probe<f32>: Channel<f32, R>,
{
    check_pointers!(end, buffer, wrenches, statuses);
    // SAFETY: by the contract of the function.
    let end = unsafe { &mut *end };
    check_bearing!(end.bearing, end.last_valid, end.probes, end.directions);
    let is_valid = |probe: &Probe| {
        // SAFETY: a reference to a struct.
        unsafe { state::read::<probe::Probe<f32>, _>(core::ptr::from_ref(probe)) }.is_some()
    };
    let probes = end.probes;
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe {
        if !pointer::slice(probes, end.channel_count).iter().all(is_valid) {
            return status::STATE_INVALID;
        }
        samples(end, probes, buffer, sample_count, turned, inner_speed, (wrenches, statuses))
    }
}

/// Computes force and status of every sample of a buffer of unsigned counts: `channel_count` of them a sample, in the order of the probes. The
/// shaft turns by `turned` (2^-64 revolutions) before each sample, at `inner_speed` (rad/s). Writes five floats a sample to `wrenches` and the
/// status bits, as of `ballrace_sample_at` and of the probes, to `statuses`; returns the bits of all samples.
///
/// Every sample takes the same number of instructions.
///
/// # Safety
/// `end` points to a struct with valid pointers that no other thread or interrupt uses; `buffer` has `sample_count * channel_count` entries,
/// `wrenches` five times and `statuses` once `sample_count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_block_u16(
    end: *mut ProbedBearing,
    buffer: *const u16,
    sample_count: u32,
    turned: i64,
    inner_speed: f32,
    wrenches: *mut f32,
    statuses: *mut u32,
) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe { samples_of_probes(end, buffer, sample_count, turned, inner_speed, wrenches, statuses) }
}

/// As `ballrace_block_u16`, for a converter with a sign: a probe takes its counts in offset binary, in which -32768 is the count 0 and 0 the
/// count 32768.
///
/// # Safety
/// As `ballrace_block_u16`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_block_i16(
    end: *mut ProbedBearing,
    buffer: *const i16,
    sample_count: u32,
    turned: i64,
    inner_speed: f32,
    wrenches: *mut f32,
    statuses: *mut u32,
) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe { samples_of_probes(end, buffer, sample_count, turned, inner_speed, wrenches, statuses) }
}

/// As `ballrace_block_u16`, for readings that are metres already. A reading that is not finite is flagged by the bearing.
///
/// # Safety
/// As `ballrace_block_u16`; the probes are not read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_block_metres(
    end: *mut ProbedBearing,
    buffer: *const f32,
    sample_count: u32,
    turned: i64,
    inner_speed: f32,
    wrenches: *mut f32,
    statuses: *mut u32,
) -> u32 {
    check_pointers!(end, buffer, wrenches, statuses);
    // SAFETY: by the contract of the function.
    let end = unsafe { &mut *end };
    check_bearing!(end.bearing, end.last_valid, end.directions);
    let channels = core::ptr::NonNull::<Metres>::dangling().as_ptr();
    // SAFETY: by the contract of the function; a channel of metres has no size.
    unsafe { samples(end, channels, buffer, sample_count, turned, inner_speed, (wrenches, statuses)) }
}
