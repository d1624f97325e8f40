//! Panic handler of the static library for firmware. No call of the interface reaches it.

use core::panic::PanicInfo;

#[cfg(feature = "panic-never")]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        safe fn ballrace_a_panic_can_be_reached() -> !;
    }
    ballrace_a_panic_can_be_reached()
}

/// Function that can panic, the control of the proof that no call panics. An image that references it does not link.
///
/// cbindgen:ignore
#[cfg(feature = "panic-never")]
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_control_that_can_panic(index: u32) -> u32 {
    const TABLE: [u32; 4] = [3, 1, 4, 1];
    TABLE[index as usize]
}

#[cfg(all(feature = "panic-loop", not(feature = "panic-never")))]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
