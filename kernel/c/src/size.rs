//! Sizes of the structs that the library writes, for languages that do not read the header.

use crate::*;

/// Alignment of all structs of the library, bytes.
pub const ALIGNMENT: u32 = 8;
/// Size of `ballrace_last_valid`, bytes.
pub const LAST_VALID_SIZE: u32 = 32;
/// Size of `ballrace_rotor`, bytes.
pub const ROTOR_SIZE: u32 = 488;
/// Size of `ballrace_rotor_state`, bytes.
pub const ROTOR_STATE_SIZE: u32 = 192;
/// Size of `ballrace_observer`, bytes.
pub const OBSERVER_SIZE: u32 = 696;
/// Size of `ballrace_observer_state`, bytes.
pub const OBSERVER_STATE_SIZE: u32 = 240;
/// Size of `ballrace_order_tracker`, bytes.
pub const ORDER_TRACKER_SIZE: u32 = 80;
/// Size of `ballrace_order_sums`, bytes.
pub const ORDER_SUMS_SIZE: u32 = 16;
/// Size of `ballrace_statistics`, bytes.
pub const STATISTICS_SIZE: u32 = 64;
/// Size of `ballrace_envelope`, bytes.
pub const ENVELOPE_SIZE: u32 = 88;
/// Size of `ballrace_probe`, bytes.
pub const PROBE_SIZE: u32 = 44;

const _: () = {
    assert!(LAST_VALID_SIZE as usize == size_of::<LastValid>() && align_of::<LastValid>() <= ALIGNMENT as usize);
    assert!(ROTOR_SIZE as usize == size_of::<Rotor>() && align_of::<Rotor>() <= ALIGNMENT as usize);
    assert!(ROTOR_STATE_SIZE as usize == size_of::<Motion>() && align_of::<Motion>() <= ALIGNMENT as usize);
    assert!(OBSERVER_SIZE as usize == size_of::<Observer>() && align_of::<Observer>() <= ALIGNMENT as usize);
    assert!(
        OBSERVER_STATE_SIZE as usize == size_of::<ObserverState>() && align_of::<ObserverState>() <= ALIGNMENT as usize
    );
    assert!(
        ORDER_TRACKER_SIZE as usize == size_of::<OrderTracker>() && align_of::<OrderTracker>() <= ALIGNMENT as usize
    );
    assert!(
        ORDER_SUMS_SIZE as usize == size_of::<OrderAccumulators>()
            && align_of::<OrderAccumulators>() <= ALIGNMENT as usize
    );
    assert!(STATISTICS_SIZE as usize == size_of::<Statistics>() && align_of::<Statistics>() <= ALIGNMENT as usize);
    assert!(PROBE_SIZE as usize == size_of::<Probe>() && align_of::<Probe>() <= ALIGNMENT as usize);
    assert!(ENVELOPE_SIZE as usize == size_of::<Envelope>() && align_of::<Envelope>() <= ALIGNMENT as usize);
};
