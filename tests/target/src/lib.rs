//! What the images share: the end of a run, the instruction counter, the bearings that are measured.
#![no_std]

pub mod counter;
pub mod inputs;

use cortex_m_semihosting::{debug, hprintln};

/// Ends the emulator with success.
pub fn done() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("{}", info);
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}
