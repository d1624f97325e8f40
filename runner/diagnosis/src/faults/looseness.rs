//! Looseness of a bearing: a ring has play in its seat.
//!
//! The force of the bearing presses the ring, which is free to move by half the play, against its seat. The elements so deflect by what is
//! left of the displacement, `u (1 - p / |u|)` with the radial play `p`, and stay as stiff as those of a tight ring: a larger clearance
//! unloads elements, a play does not.

use super::super::Result;
use super::super::estimates::{Estimates, STIFFNESS_ERROR, described};
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, Parameter};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Diametral play of a ring in its seat.
static SEAT_PLAY: Parameter = Parameter {
    step: 1e-9,
    longest_step: |_, _| 5e-6,
    changes_stiffness: true,
    access: Access::Bearing {
        get: |bearing, _| bearing.seat_play,
        set: |bearing, _, x| bearing.seat_play = x.max(0.0),
    },
};

/// Plays that are tried, m.
const PLAYS: [f64; 7] = [3e-6, 6e-6, 12e-6, 20e-6, 32e-6, 50e-6, 80e-6];
/// Least play, m: a ring with a clearance fit (H7/h6) has more.
const TOLERANCE: f64 = 3e-6;

/// Play of a ring of a bearing in its seat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Looseness {
    bearing: usize,
}

impl Fault for Looseness {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        (0..machine.bearings.len()).map(|bearing| Self { bearing }).collect()
    }

    /// A play is searched at a site alone: with exact readings it imitates a tilt of a ring whose clearance differs.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        if search.e.site.is_none() {
            return Ok(None);
        }
        let unknown = SEAT_PLAY.of_bearing(self.bearing);
        let of = |play: f64| {
            let mut machine = search.now.machine.clone();
            unknown.set(&mut machine, play);
            machine
        };
        let (gain, start) = search.best_of(self.bearing, PLAYS.into_iter().map(of))?;
        Ok(Some(search.found(AnyFault::Looseness(*self), gain, vec![start], &[unknown])))
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.bearings[self.bearing].seat_play = before.bearings[self.bearing].seat_play;
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let unknown = SEAT_PLAY.of_bearing(self.bearing);
        unknown.get(&after.machine) > TOLERANCE.max(e.significant() * after.deviation(unknown))
    }

    fn bearing(&self) -> Option<usize> {
        Some(self.bearing)
    }

    fn changes_stiffness(&self, _: &Evidence) -> bool {
        true
    }

    fn is_nonlinear(&self) -> bool {
        true
    }

    fn moves_shaft(&self) -> bool {
        true
    }

    fn gives_way(&self) -> bool {
        true
    }

    fn is_of_sound_machines(&self) -> bool {
        false
    }

    fn kind(&self) -> FaultKind {
        FaultKind::Looseness
    }

    fn name(&self, plant: &Plant) -> String {
        format!("a loose ring of {}", plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let play = of.estimate(SEAT_PLAY.of_bearing(self.bearing), 1e-6, STIFFNESS_ERROR);
        FaultParameters { seat_play_um: Some(play), ..FaultParameters::default() }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        format!(
            "A ring of {} is loose in its seat: play {} um",
            of.e.plant.bearings[self.bearing].name,
            described(p.seat_play_um, 1)
        )
    }
}
