//! Yielding support of a bearing: a foot or its bolts are loose, the base is cracked or hollow.
//!
//! The outer ring moves with the force of its bearing by the compliance `c` of the support beyond that of the sound machine, along X and Y:
//! the elements deflect by `u + c w` with the displacement `u` of the rotor and the force `w` of the bearing on the rotor. The mass of the support
//! is neglected, as below its natural frequency.

use super::super::Result;
use super::super::estimates::{Estimates, around, described};
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, Parameter, Unknown};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{Estimate, FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Compliance along X and Y, m/N.
static COMPLIANCE: Parameter = Parameter {
    step: 1e-11,
    longest_step: |_, _| 5e-8,
    changes_stiffness: true,
    access: Access::Bearing {
        get: |bearing, direction| bearing.compliance[direction],
        set: |bearing, direction, x| bearing.compliance[direction] = x.max(0.0),
    },
};

/// Compliances that are tried along X, along Y and along both, m/N.
const COMPLIANCES: [f64; 4] = [4e-9, 1.5e-8, 5e-8, 1.5e-7];
/// Shares of the best of them that are tried then, along each direction: the fit goes on from there, and the errors of the readings hold it near.
const CLOSER: [[f64; 3]; 2] = [[0.65, 1.0, 1.5], [0.85, 1.0, 1.2]];
/// Least compliance, m/N: a sound support changes by less, with 200 N/um.
const TOLERANCE: f64 = 5e-9;

/// Support of a bearing that yields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    bearing: usize,
}

impl Support {
    fn unknowns(self) -> [Unknown; 2] {
        [0, 1].map(|direction| COMPLIANCE.of_bearing_at(self.bearing, direction))
    }

    /// Returns the softer direction of a machine's support: 0 along X, 1 along Y.
    fn softer(self, machine: &Machine) -> usize {
        let [x, y] = machine.bearings[self.bearing].compliance;
        usize::from(y > x)
    }
}

impl Fault for Support {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        (0..machine.bearings.len()).map(|bearing| Self { bearing }).collect()
    }

    /// A support is searched at a site alone: one of an exact scene is known.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        if search.e.site.is_none() {
            return Ok(None);
        }
        let of = |compliance: [f64; 2]| {
            let mut machine = search.now.machine.clone();
            machine.bearings[self.bearing].compliance = compliance;
            machine
        };
        let tried = COMPLIANCES.into_iter().flat_map(|c| [[c, 0.0], [0.0, c], [c, c]]);
        let (mut gain, mut start) = search.best_of(self.bearing, tried.map(of))?;
        for closer in CLOSER {
            let about = start.bearings[self.bearing].compliance;
            let tried = closer.into_iter().flat_map(|x| closer.map(|y| [x * about[0], y * about[1]]));
            let (next, machine) = search.best_of(self.bearing, tried.map(of))?;
            if next > gain {
                (gain, start) = (next, machine);
            }
        }
        Ok((gain > 0.0).then(|| search.found(AnyFault::Support(*self), gain, vec![start], &self.unknowns())))
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.bearings[self.bearing].compliance = before.bearings[self.bearing].compliance;
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let unknown = self.unknowns()[self.softer(&after.machine)];
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
        FaultKind::Support
    }

    fn name(&self, plant: &Plant) -> String {
        format!("a yielding support of {}", plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let unknown = self.unknowns()[self.softer(&of.last.machine)];
        let compliance = unknown.get(&of.last.machine);
        let Estimate { low, high, .. } = around(compliance, of.deviation(unknown));
        // A stiffness in N/um; an end that no interval of the compliance has is that of a support ten times stiffer.
        let stiffness =
            |compliance: f64| 1e-6 / compliance.max(0.1 * unknown.get(&of.last.machine)).max(f64::MIN_POSITIVE);
        let stiffness = Estimate { value: stiffness(compliance), low: stiffness(high), high: stiffness(low) };
        FaultParameters { support_stiffness_n_um: Some(stiffness), ..FaultParameters::default() }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        format!(
            "The support of {} yields along {}: {} N/um in addition to the sound one",
            of.e.plant.bearings[self.bearing].name,
            ["X", "Y"][self.softer(&of.last.machine)],
            described(p.support_stiffness_n_um, 1)
        )
    }
}
