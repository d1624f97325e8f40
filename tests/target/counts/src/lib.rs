//! What is measured, and how.
#![no_std]

mod counter;
pub mod inputs;
mod measure;
mod subjects;

use measure::Bench;

/// Measures everything over the first `inputs` inputs, prints a line each, and ends the emulator's run.
pub fn run(inputs: u32) -> ! {
    measured(inputs, subjects::all)
}

/// Measures what firmware takes, for the comparison of processors.
pub fn run_hot() -> ! {
    measured(inputs::COUNT, subjects::hot)
}

/// Measures what firmware takes on a core without a floating-point unit.
pub fn run_without_fpu() -> ! {
    measured(inputs::COUNT, subjects::without_fpu)
}

fn measured(inputs: u32, subjects: fn(&Bench)) -> ! {
    if let Some(bench) = Bench::start(inputs) {
        subjects(&bench);
    }
    semihosting::process::exit(0)
}
