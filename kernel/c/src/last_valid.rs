//! The last valid force of a stream of samples.

use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::bearing::LastValidWrench;

/// Last valid force and number of samples that it replaced. Opaque: `ballrace_last_valid_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct LastValid {
    /// Private.
    pub words: [u64; 4],
}

impl Stored for LastValidWrench<f32> {
    const KIND: u32 = 1;
}

/// Initialises the state before the first sample; an invalid first sample gives the zero force.
///
/// # Safety
/// `last_valid` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_last_valid_init(last_valid: *mut LastValid) -> u32 {
    check_pointers!(last_valid);
    // SAFETY: by the contract of the function.
    unsafe { state::write(last_valid, LastValidWrench::<f32>::new()) };
    status::OK
}

/// Returns the number of samples replaced by an earlier force (saturating); 0 for a state that is not initialised.
///
/// # Safety
/// `last_valid` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_held_count(last_valid: *const LastValid) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe { state::read::<LastValidWrench<f32>, _>(last_valid) }.map_or(0, |state| state.held_count())
}
