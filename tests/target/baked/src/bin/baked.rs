//! Forces of both bearings on an orbit and the motion of a flexible rotor, as bits: the desktop prints the same.
#![no_std]
#![no_main]

use baked::bearings::{bearing_de, bearing_nde};
use baked::motion;
use ballrace::{Bearing, BearingKinematicState, Displacement, Phase, Wrench};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprint, hprintln};
use panic_semihosting as _;

const SAMPLES: u16 = 64;

/// Sample `i`: an orbit in steps that every machine computes alike.
fn displacement(i: u16) -> Displacement<f32> {
    let part = f32::from(i) / 64.0;
    let half = if i < 32 { part } else { 1.0 - part };
    Displacement { u: 6e-6 * half, v: 4e-6 * (0.25 - half), w: 5e-6 + 4e-6 * part, thu: 1e-4 * half, thv: -5e-5 * part }
}

fn rotation(i: u16) -> BearingKinematicState<f32> {
    let turn = Phase(u64::from(i) << 57);
    BearingKinematicState {
        cage: turn,
        inner: turn.wrapping_mul(3),
        inner_speed: 1256.0,
        ..BearingKinematicState::default()
    }
}

fn print(name: &str, i: u16, wrench: &Wrench<f32>, status: u8) {
    let [fx, fy, fz, mx, my] = wrench.to_array().map(f32::to_bits);
    hprintln!("{},{},{:08x},{:08x},{:08x},{:08x},{:08x},{}", name, i, fx, fy, fz, mx, my, status);
}

#[entry]
fn main() -> ! {
    let (de, nde) = (bearing_de::bearing(), bearing_nde::bearing());
    for i in 0..SAMPLES {
        let (u, at) = (displacement(i), rotation(i));
        let (drive_end, other_end) = (de.reaction(&u, &at), nde.reaction(&u.mirrored(), &at));
        print("DE", i, &drive_end.wrench, drive_end.status.bits());
        print("NDE", i, &other_end.wrench, other_end.status.bits());
    }
    let printed = motion::run(|i, moved, observed| {
        hprint!("rotor,{}", i);
        for x in moved.iter().chain(observed) {
            hprint!(",{:08x}", x.to_bits());
        }
        hprintln!("");
    });
    if printed.is_err() {
        hprintln!("the matrices are rejected");
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
