//! A second static library of Rust in an image of C, with a panic handler of its own.
#![no_std]

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// Returns an entry of a table. An index out of range panics.
#[unsafe(no_mangle)]
pub extern "C" fn other_library_entry(index: u32) -> u32 {
    const TABLE: [u32; 4] = [3, 1, 4, 1];
    TABLE[index as usize]
}
