//! Counts every subject over all inputs.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    counts::run(counts::inputs::COUNT)
}
