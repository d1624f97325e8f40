//! What is measured, and how.
#![no_std]

mod counter;
pub mod inputs;
mod measure;
mod subjects;

use cortex_m_semihosting::debug;
use panic_semihosting as _;

/// Measures everything over the first `inputs` inputs, prints a line each, and ends the emulator's run.
pub fn run(inputs: u32) -> ! {
    if let Some(bench) = measure::Bench::start(inputs) {
        subjects::all(&bench);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
