//! The monitor of the boards on the counts of a sound and of a damaged machine: frames, checksum of the forces and verdict of every
//! block, which the desktop computes to the same bits.
#![no_std]
#![no_main]

mod machine;
mod run;

use ballrace::twin::DamageDetector;
use core::fmt::Write;
use cortex_m::singleton;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio};
use panic_semihosting as _;

#[entry]
fn main() -> ! {
    let detectors = [
        singleton!(: DamageDetector<f32> = DamageDetector::new()),
        singleton!(: DamageDetector<f32> = DamageDetector::new()),
    ];
    let is_done = hio::hstdout().is_ok_and(|mut out| {
        detectors.into_iter().zip([false, true]).all(|(detector, is_damaged)| {
            let Some(detector) = detector else { return false };
            let mut is_written = true;
            let ran = run::run(is_damaged, detector, |monitor, frames, verdict| {
                is_written &= out.write_all(frames).is_ok();
                is_written &= writeln!(out, "{:08x} {verdict:?}", run::checksum(monitor)).is_ok();
            });
            ran.is_some() && is_written
        })
    });
    debug::exit(if is_done { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        core::hint::spin_loop();
    }
}
