//! Exact instruction counts from the emulator's clock.
//!
//! With `-icount shift=8` one instruction takes 256 ns of virtual time. On Arm the system timer counts the core clock; on RISC-V
//! the counter of instructions counts the nanoseconds of that time.

use core::hint::black_box;

/// Virtual time of one instruction, ns.
const INSTRUCTION: u32 = 256;

/// The running timer.
#[derive(Clone)]
pub struct Counter {
    bracket: u32,
}

impl Counter {
    /// Starts the timer. Call once.
    pub fn start() -> Option<Self> {
        start_clock()?;
        let mut counter = Self { bracket: 0 };
        counter.bracket = counter.count(|| {});
        Some(counter)
    }

    /// Instructions of one call, less those of the bracket around it. The result is used after the second reading.
    #[inline(always)]
    pub fn count<R>(&self, work: impl FnOnce() -> R) -> u32 {
        let before = clock();
        let result = work();
        let after = clock();
        black_box(result);
        (elapsed(before, after) + INSTRUCTION / 2) / INSTRUCTION - self.bracket
    }
}

#[cfg(target_arch = "arm")]
use self::arm::{clock, elapsed, start_clock};
#[cfg(target_arch = "riscv32")]
use self::riscv32::{clock, elapsed, start_clock};

#[cfg(target_arch = "arm")]
mod arm {
    use cortex_m::Peripherals;
    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;

    /// Period of the core clock, ns: 20 MHz on the board of the Cortex-M33, 25 MHz on the others.
    const TICK: u32 = if cfg!(board_an505) { 50 } else { 40 };

    pub fn start_clock() -> Option<()> {
        let mut timer = Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        Some(())
    }

    #[inline(always)]
    pub fn clock() -> u32 {
        SYST::get_current()
    }

    /// Time between two readings, ns.
    #[inline(always)]
    pub fn elapsed(before: u32, after: u32) -> u32 {
        (before.wrapping_sub(after) & 0x00ff_ffff) * TICK
    }
}

#[cfg(target_arch = "riscv32")]
mod riscv32 {
    use riscv::register::minstret;

    pub fn start_clock() -> Option<()> {
        Some(())
    }

    #[inline(always)]
    pub fn clock() -> u32 {
        minstret::read() as u32
    }

    /// Time between two readings, ns.
    #[inline(always)]
    pub fn elapsed(before: u32, after: u32) -> u32 {
        after.wrapping_sub(before)
    }
}
