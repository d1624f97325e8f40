//! One force after the other, each from the one before, as in an integration: the time of the whole chain, and that of C tuned by hand.

use super::yardstick::{self, States};
use super::{COLUMNS, INPUTS, RADIAL_PLAY, Subject, geometry, scattered};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, BlockedPositions, ElementPositions, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::{Displacement, Exact, Phase};
use ballrace_twin::simd::Dispatched;
use std::fmt::Write as _;
use std::hint::black_box;

/// The force of the kernel as it is compiled for every processor of the target.
pub const CHAIN: &str = "lumped, point contact, N = 8: force from the force before";
/// As [`CHAIN`] in the form of the program: positions in blocks, registers selected at run time.
pub const CHAIN_WIDE: &str = "lumped, point contact, N = 8: force from the force before, widest registers";
/// The same in C, tuned by hand and for this processor.
pub const CHAIN_C: &str = "tuned C, point contact, N = 8: force from the force before";

/// Change of the displacement per newton of the force before, m: it changes no digit of the force that matters.
const FEEDBACK: f64 = 1e-15;
/// Turn of the cage from sample to sample, revolutions.
const TURN: f64 = 0.0131;

/// All of them; without a C compiler the last one is left out.
pub fn all() -> Result<Vec<Subject>, InvalidParameter> {
    let law = PointContactLaw { stiffness: geometry()?.stiffness() };
    let places: ElementPositions<f64, 8> = evenly_spaced(Phase::ZERO);
    let bearing = Radial::<f64, Exact, _, _>::try_new(places, law, RADIAL_PLAY)?;
    let blocked = BlockedPositions::<_, Vec<_>>::new(places);
    let wide = Dispatched::new(Radial::<f64, Exact, _, _>::try_new(blocked, law, RADIAL_PLAY)?);
    let mut subjects = vec![chain(CHAIN, bearing), chain(CHAIN_WIDE, wide)];
    let mut input = format!("{:e} {RADIAL_PLAY:e} {TURN} {INPUTS}\n", law.stiffness);
    for Displacement { u, v, .. } in poses() {
        // Writing to a string cannot fail.
        let _ = writeln!(input, "{u:e} {v:e}");
    }
    let states = States { input: &input, count: INPUTS, passes: 1024 };
    subjects.extend(yardstick::subject(CHAIN_C, "lumped", &["-march=native"], states));
    Ok(subjects)
}

fn poses() -> Vec<Displacement<f64>> {
    let pose = |i| {
        let [u, v] = [0.618, 0.414].map(|stride| 20e-6 * scattered(i, stride));
        Displacement { u, v, ..Displacement::default() }
    };
    (0..INPUTS).map(pose).collect()
}

fn chain(row: &str, bearing: impl Bearing<f64> + 'static) -> Subject {
    let (poses, turn) = (poses(), Phase::from_revolutions(TURN));
    let mut cage = Phase::ZERO;
    let run = Box::new(move || {
        let [mut fx, mut fy] = [0.0; 2];
        for pose in black_box(&poses) {
            let u = Displacement { u: pose.u + FEEDBACK * fx, v: pose.v + FEEDBACK * fy, ..*pose };
            let wrench = bearing.reaction(&u, &cage.into()).wrench;
            (fx, fy) = (wrench.fx, wrench.fy);
            cage = cage.wrapping_add(turn);
        }
        black_box((fx, fy));
    });
    Subject::new(row, COLUMNS[0], INPUTS, run)
}
