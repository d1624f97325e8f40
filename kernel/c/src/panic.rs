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

#[cfg(all(feature = "panic-loop", not(feature = "panic-never")))]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
