//! Output of the example: a line of text over semihosting, or a frame of defmt.

use ballrace::{Status, Wrench};

/// One evaluated sample.
#[cfg(not(feature = "defmt"))]
pub fn sample(number: u32, wrench: &Wrench<f32>, status: Status) {
    let Wrench { fx, fy, fz, .. } = wrench;
    cortex_m_semihosting::hprintln!("{},{:.3},{:.3},{:.3},{}", number, fx, fy, fz, status.bits());
}

/// Number of samples that were replaced by an older value.
#[cfg(not(feature = "defmt"))]
pub fn held(count: u32) {
    cortex_m_semihosting::hprintln!("held,{}", count);
}

/// One evaluated sample.
#[cfg(feature = "defmt")]
pub fn sample(number: u32, wrench: &Wrench<f32>, status: Status) {
    defmt::info!("{} {} {}", number, wrench, status);
}

/// Number of samples that were replaced by an older value.
#[cfg(feature = "defmt")]
pub fn held(count: u32) {
    defmt::info!("held {}", count);
}

#[cfg(feature = "defmt")]
use defmt_semihosting as _;
