//! Checksums of both bearings, a log of their forces on an orbit, the motion of a flexible rotor, and the bearings of a blob, as bits: the
//! desktop prints the same.
#![no_std]
#![no_main]

use baked::bearings::{bearing_de, bearing_nde};
use baked::{blob, framed, log, motion};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprint, hprintln};
use panic_semihosting as _;

#[entry]
fn main() -> ! {
    hprintln!("checksum,DE,{:#018x},{:#018x}", bearing_de::checksum(), bearing_de::CHECKSUM);
    hprintln!("checksum,NDE,{:#018x},{:#018x}", bearing_nde::checksum(), bearing_nde::CHECKSUM);
    let (de, nde) = (bearing_de::bearing(), bearing_nde::bearing());
    for i in 0..log::SAMPLES {
        let (u, at) = (log::displacement(i), log::rotation(i));
        hprintln!("DE,{}", log::Row::new(&de, &u, &at));
        hprintln!("NDE,{}", log::Row::new(&nde, &u.mirrored(), &at));
    }
    let printed = motion::run(|i, moved, observed| {
        hprint!("rotor,{}", i);
        for x in moved.iter().chain(observed) {
            hprint!(",{:08x}", x.to_bits());
        }
        hprintln!("");
    });
    let mut device = framed::device();
    for i in 0..framed::SAMPLES {
        hprintln!("frame,{}", framed::Row::new(&mut device, i));
    }
    if let Err(reason) = blob::run(|row| hprintln!("blob,{}", row)) {
        hprintln!("blob,{}", reason);
    }
    if printed.is_err() {
        hprintln!("the matrices are rejected");
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
