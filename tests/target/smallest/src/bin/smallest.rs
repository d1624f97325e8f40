//! Eight radial elements from constants in flash: the forces of one sample after another.
#![no_std]
#![no_main]

use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, HeldWrench, Pairs, Place};
use ballrace::contact::law::Point;
use ballrace::{Displacement, Exact, Turn};
use core::f32::consts::FRAC_1_SQRT_2;
use core::hint::black_box;
use cortex_m_rt::entry;
use panic_halt as _;

const EIGHTH: u64 = 1 << 61;

/// One element of each pair, 45 degrees apart.
const PLACES: Pairs<f32, 4> = Pairs::new([
    Place::ready(1.0, 0.0, Turn(0)),
    Place::ready(FRAC_1_SQRT_2, FRAC_1_SQRT_2, Turn(EIGHTH)),
    Place::ready(0.0, 1.0, Turn(2 * EIGHTH)),
    Place::ready(-FRAC_1_SQRT_2, FRAC_1_SQRT_2, Turn(3 * EIGHTH)),
]);

#[entry]
fn main() -> ! {
    let Ok(bearing) = Radial::<f32, Exact, _, _>::try_new(PLACES, Point { stiffness: 8e9 }, 5e-6) else {
        loop {
            core::hint::spin_loop();
        }
    };
    let mut held = HeldWrench::new();
    loop {
        let (u, cage): (Displacement<f32>, Turn) = black_box((Displacement::default(), Turn::ZERO));
        black_box(bearing.sample(&mut held, &u, &cage.into()));
    }
}
