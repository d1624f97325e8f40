//! The control: one function that can panic, so this image must not link.
#![no_std]
#![no_main]

use core::hint::black_box;
use panic_never as _;

#[inline(never)]
fn index_panicking(values: &[f32], i: usize) -> f32 {
    values[i]
}

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        black_box(index_panicking(black_box(&[1.0, 2.0]), black_box(1)));
    }
}
