//! The baked flexible rotor in motion, followed by its observer.

use super::flexible::observer::{GAINS, GATE, MEMORY, PERIOD, PROBES, SPEEDS, SUBSTEPS};
use super::flexible::rotor::{self, COORDINATES};
use super::flexible::{bearing_de, bearing_nde};
use ballrace::rotor::{
    AttachedBearing, Integrator, InvalidMatrix, RotorBearingSystem, RotorState, ShaftMotion, SpeedRatios, Verlet,
};
use ballrace::twin::{Observer, ObserverState};
use ballrace::{Exact, Phase};

const SAMPLES: u16 = 32;
/// Shaft speed, rad/s.
const SPEED: f32 = 314.159_27;

/// Calls `line` after each sample with its number, the coordinates of the rotor and those of the observer, which starts 5 um above
/// the rotor.
///
/// # Errors
/// None with the baked matrices.
pub fn run(mut line: impl FnMut(u16, &[f32; COORDINATES], &[f32; COORDINATES])) -> Result<(), InvalidMatrix> {
    let speed_ratios = SpeedRatios::new(bearing_de::CAGE_RATIO);
    let [de, nde] = rotor::attachments();
    let on_coordinates = [
        AttachedBearing { bearing: bearing_de::bearing(), attachment: de, speed_ratios },
        AttachedBearing { bearing: bearing_nde::bearing(), attachment: nde, speed_ratios },
    ];
    let step = PERIOD / SUBSTEPS as f32;
    let integrator = Verlet { step };
    let observer = Observer {
        system: RotorBearingSystem { rotor: rotor::rotor()?, bearings: on_coordinates },
        integrator,
        step,
        substeps: SUBSTEPS,
        probes: PROBES,
        gains: &GAINS,
        speeds: SPEEDS,
        load_retention: MEMORY,
        gate: GATE,
    };
    let mut motion = RotorState::stationary([0.0; COORDINATES], Phase::ZERO, [Phase::ZERO; 2]);
    let mut observed = ObserverState::new(motion);
    let [_, v, ..] = &mut observed.motion.q;
    *v = 5e-6;
    let mut shaft = ShaftMotion { angle: Phase::ZERO, speed: SPEED, acceleration: 0.0 };
    for i in 0..SAMPLES {
        let start = shaft;
        for _ in 0..SUBSTEPS {
            integrator.step(&observer.system, &mut motion, &shaft);
            shaft = shaft.after(step);
        }
        let readings = PROBES.map(|row| row.iter().zip(&motion.q).fold(0.0, |sum, (c, q)| sum + c * q));
        observer.sample::<Exact>(&mut observed, &start, &readings);
        line(i, &motion.q, &observed.motion.q);
    }
    Ok(())
}
