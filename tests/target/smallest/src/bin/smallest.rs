//! Eight radial elements from constants in flash: the forces of one sample after another.
#![no_std]
#![no_main]

use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, ElementPosition, LastValidWrench, OpposedPairs};
use ballrace::contact::law::PointContactLaw;
use ballrace::{Displacement, Exact, Phase};
use core::f32::consts::FRAC_1_SQRT_2;
use core::hint::black_box;
use cortex_m_rt::entry;
use panic_halt as _;

const EIGHTH: u64 = 1 << 61;

/// One element of each pair, 45 degrees apart.
const POSITIONS: OpposedPairs<f32, 4> = OpposedPairs::new([
    ElementPosition::from_constants(1.0, 0.0, Phase(0)),
    ElementPosition::from_constants(FRAC_1_SQRT_2, FRAC_1_SQRT_2, Phase(EIGHTH)),
    ElementPosition::from_constants(0.0, 1.0, Phase(2 * EIGHTH)),
    ElementPosition::from_constants(-FRAC_1_SQRT_2, FRAC_1_SQRT_2, Phase(3 * EIGHTH)),
]);

#[entry]
fn main() -> ! {
    let Ok(bearing) = Radial::<f32, Exact, _, _>::try_new(POSITIONS, PointContactLaw { stiffness: 8e9 }, 5e-6) else {
        loop {
            core::hint::spin_loop();
        }
    };
    let mut held = LastValidWrench::new();
    loop {
        let (u, cage): (Displacement<f32>, Phase) = black_box((Displacement::default(), Phase::ZERO));
        black_box(bearing.sample(&mut held, &u, &cage.into()));
    }
}
