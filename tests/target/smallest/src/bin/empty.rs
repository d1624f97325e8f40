//! The same loop without a bearing.
#![no_std]
#![no_main]

use ballrace::{Displacement, Status, Turn, Wrench};
use core::hint::black_box;
use cortex_m_rt::entry;
use panic_halt as _;

#[entry]
fn main() -> ! {
    loop {
        let (_, _): (Displacement<f32>, Turn) = black_box((Displacement::default(), Turn::ZERO));
        black_box((Wrench::<f32>::default(), Status::OK));
    }
}
