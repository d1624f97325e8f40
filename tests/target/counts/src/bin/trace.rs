//! Calls every subject with one ordinary input, for the emulator to write down the path it takes.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    counts::run(1)
}
