//! A displacement probe behind an analogue-to-digital converter.

use crate::geometry::{InvalidParameter, report};
use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::probe;

/// Scale and limits of a probe.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeParams {
    /// Displacement at the count 0, m.
    pub at_zero: f32,
    /// Displacement per count, m; its sign is the direction in which the count rises.
    pub per_count: f32,
    /// Smallest and largest count of the linear range of the transducer, both inside the rails of the converter.
    pub linear_range: [u32; 2],
    /// Samples without any change of the count after which the channel is stuck; 0: it may stand still.
    pub stuck_after: u32,
}

/// Parameters and state of one probe. Opaque: `ballrace_probe_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// Private.
    pub words: [u32; 11],
}

impl Stored for probe::Probe<f32> {
    const KIND: u32 = 5;
}

/// Initialises a probe before its first sample. For set-up. `invalid` may be NULL.
///
/// # Safety
/// `probe` and `params` point to structs, `invalid` to a struct or nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_probe_init(
    probe: *mut Probe,
    params: *const ProbeParams,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(probe, params);
    // SAFETY: by the contract of the function.
    unsafe {
        let ProbeParams { at_zero, per_count, linear_range, stuck_after } = *params;
        match probe::Probe::try_new(probe::ProbeParams { at_zero, per_count, linear_range, stuck_after }) {
            Ok(value) => state::write(probe, value),
            Err(error) => return report(error, invalid),
        }
    }
    status::OK
}

/// Writes the displacement at this count, m, or the last valid one with `BALLRACE_INPUT_NOT_OK` where the channel is not OK: a count outside
/// the linear range, or one that does not change. Before a first valid sample the displacement is 0. Constant number of instructions.
///
/// # Safety
/// `probe` points to an initialised probe that no other thread or interrupt uses, `displacement` to a float.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_probe_sample(probe: *mut Probe, counts: u32, displacement: *mut f32) -> u32 {
    check_pointers!(probe, displacement);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(probe) = state::get::<probe::Probe<f32>, _>(probe) else { return status::STATE_INVALID };
        let (there, status) = probe.sample(counts);
        *displacement = there;
        u32::from(status.bits())
    }
}

/// Returns the age of the displacement in samples: 0 where the last one was valid (saturating), or where the probe is not initialised.
///
/// # Safety
/// `probe` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_probe_held_in_a_row(probe: *const Probe) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe { state::read::<probe::Probe<f32>, _>(probe) }.map_or(0, probe::Probe::held_in_a_row)
}

/// Returns the number of samples since the start or the last reset that were not OK (saturating); 0 for a probe that is not initialised.
///
/// # Safety
/// `probe` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_probe_held_count(probe: *const Probe) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe { state::read::<probe::Probe<f32>, _>(probe) }.map_or(0, probe::Probe::held_count)
}

/// Forgets samples and counters, after a repair of the channel.
///
/// # Safety
/// `probe` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_probe_reset(probe: *mut Probe) -> u32 {
    check_pointers!(probe);
    // SAFETY: by the contract of the function.
    let Some(probe) = (unsafe { state::get::<probe::Probe<f32>, _>(probe) }) else { return status::STATE_INVALID };
    probe.reset();
    status::OK
}
