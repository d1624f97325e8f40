//! Exact instruction counts from the emulator's clock.
//!
//! With `-icount shift=8` one instruction takes 256 ns of virtual time, and the system timer counts the core clock of
//! 25 MHz: 40 ns a tick. So instructions = ticks * 40 / 256, whatever the host does meanwhile.

use core::hint::black_box;
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// The running timer.
pub struct Counter {
    bracket: u32,
}

impl Counter {
    /// Starts the timer. Call once.
    pub fn start() -> Option<Self> {
        let mut timer = Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Self { bracket: 0 };
        counter.bracket = counter.count(|| {});
        Some(counter)
    }

    /// Instructions of one call, less those of the bracket around it. The result is used after the second reading.
    #[inline(always)]
    pub fn count<R>(&self, work: impl FnOnce() -> R) -> u32 {
        let before = SYST::get_current();
        let result = work();
        let after = SYST::get_current();
        black_box(result);
        let ticks = before.wrapping_sub(after) & 0x00ff_ffff;
        (ticks * 40 + 128) / 256 - self.bracket
    }
}
