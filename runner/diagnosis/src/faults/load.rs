//! Constant load on the rotor other than the scene's.

use super::super::Result;
use super::super::estimates::Estimates;
use super::super::fault_figures::Contrast;
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, LINEAR, Parameter};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{Estimate, FaultFigures, FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Load along X, Y or Z.
static LOAD: Parameter = Parameter {
    step: 0.1,
    longest_step: LINEAR,
    changes_stiffness: false,
    access: Access::Rotor { get: |machine, i| machine.load[i], set: |machine, i, x| machine.load[i] = x },
};

/// Least change of the load, N.
const TOLERANCE: f64 = 1.0;

/// Constant load other than the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load;

impl Fault for Load {
    fn of_machine(_: &Machine) -> Vec<Self> {
        vec![Self]
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        search.linear(AnyFault::Load(*self), &[0, 1, 2].map(|i| LOAD.of_rotor(i))).map(Some)
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.load = before.load;
    }

    fn exceeds_tolerance(&self, before: &Fitted, after: &Fitted) -> bool {
        (0..3).any(|i| (after.machine.load[i] - before.machine.load[i]).abs() > TOLERANCE)
    }

    fn changes_stiffness(&self, _: &Evidence) -> bool {
        true
    }

    fn kind(&self) -> FaultKind {
        FaultKind::Load
    }

    fn name(&self, _: &Plant) -> String {
        "another load".to_owned()
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let load = [0, 1, 2].map(|i| of.estimate(LOAD.of_rotor(i), 1.0, 0.0));
        FaultParameters { load_n: Some(load), ..FaultParameters::default() }
    }

    fn sentence(&self, _: &Estimates, p: &FaultParameters) -> String {
        let [x, y, z] = p.load_n.unwrap_or([Estimate { value: 0.0, low: 0.0, high: 0.0 }; 3]);
        format!(
            "Load other than the scene's: {:.1}, {:.1}, {:.1} N along X, Y, Z besides the weight",
            x.value, y.value, z.value
        )
    }

    /// A load changes the mean alone.
    fn figures(&self, of: &Contrast) -> FaultFigures {
        FaultFigures { rose: None, spectra: vec![], motion: of.motion() }
    }
}
