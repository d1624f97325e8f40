//! The same loop without a bearing.
#![no_std]
#![no_main]

use ballrace::{Displacement, Phase, Status, Wrench};
use core::hint::black_box;
use cortex_m_rt::entry;
use panic_halt as _;

#[entry]
fn main() -> ! {
    loop {
        let (_, _): (Displacement<f32>, Phase) = black_box((Displacement::default(), Phase::ZERO));
        black_box((Wrench::<f32>::default(), Status::OK));
    }
}
