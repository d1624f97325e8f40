//! Statistics and envelope of a signal.

use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::{Exact, twin};

/// Statistics of one block.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct BlockStatistics {
    /// Mean.
    pub mean: f32,
    /// Root mean square about the mean.
    pub rms: f32,
    /// Greatest less least value.
    pub peak_to_peak: f32,
    /// Greatest distance from the mean divided by the rms; 0 for a constant signal.
    pub crest_factor: f32,
    /// Fourth moment divided by the squared second; 0 for a constant signal.
    pub kurtosis: f32,
}

/// State of the statistics. Opaque: `ballrace_statistics_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Statistics {
    /// Private.
    pub words: [u64; 8],
}

/// Envelope of a frequency band. Opaque: `ballrace_envelope_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Envelope {
    /// Private.
    pub words: [u64; 11],
}

impl Stored for twin::Statistics<f32> {
    const KIND: u32 = 3;
}

impl Stored for twin::Envelope<f32> {
    const KIND: u32 = 4;
}

/// Initialises statistics over blocks of `length` samples, 1 or more.
///
/// # Safety
/// `statistics` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_statistics_init(statistics: *mut Statistics, length: u32) -> u32 {
    check_pointers!(statistics);
    // SAFETY: by the contract of the function.
    unsafe { state::write(statistics, twin::Statistics::<f32>::new(length)) };
    status::OK
}

/// Adds a sample; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block and has written `block`.
///
/// # Safety
/// `statistics` points to an initialised state that no other thread or interrupt uses, `block` to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_statistics_add(
    statistics: *mut Statistics,
    sample: f32,
    block: *mut BlockStatistics,
) -> u32 {
    check_pointers!(statistics, block);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(statistics) = state::get::<twin::Statistics<f32>, _>(statistics) else {
            return status::STATE_INVALID;
        };
        let Some(result) = statistics.add::<Exact>(sample) else { return status::OK };
        let twin::BlockStatistics { mean, rms, peak_to_peak, crest_factor, kurtosis } = result;
        block.write(BlockStatistics { mean, rms, peak_to_peak, crest_factor, kurtosis });
    }
    status::BLOCK_COMPLETE
}

/// Initialises the envelope of the band `centre` plus and minus `half_width` at the sampling rate `rate`, all in Hz; the
/// band must be below half the rate. For set-up: uses `double`.
///
/// # Safety
/// `envelope` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_envelope_init(
    envelope: *mut Envelope,
    centre: f64,
    half_width: f64,
    rate: f64,
) -> u32 {
    check_pointers!(envelope);
    if !(half_width > 0.0 && centre >= 0.0 && centre + half_width < 0.5 * rate) {
        return status::INVALID_ARGUMENT;
    }
    // SAFETY: by the contract of the function.
    unsafe { state::write(envelope, twin::Envelope::<f32>::new(centre, half_width, rate)) };
    status::OK
}

/// Adds a sample and writes the envelope: for a sine in the band, its amplitude. Constant number of instructions.
///
/// # Safety
/// `envelope` points to an initialised state that no other thread or interrupt uses, `amplitude` to a float.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_envelope_add(envelope: *mut Envelope, sample: f32, amplitude: *mut f32) -> u32 {
    check_pointers!(envelope, amplitude);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(envelope) = state::get::<twin::Envelope<f32>, _>(envelope) else { return status::STATE_INVALID };
        *amplitude = envelope.add::<Exact>(sample);
    }
    status::OK
}
