//! Faults that a machine may have, one file each: its candidates, its unknowns with steps and bounds, how it changes the machine, when it
//! exceeds the deviations of healthy machines, its words and its figures.
//!
//! A new fault is a new file and two lines here: its module and its name in the registry.

pub mod candidates;
mod clearance;
mod coupling;
mod load;
mod looseness;
mod misalignment;
mod run_out;
mod spall;
mod support;
mod unbalance;
mod waviness;

pub use clearance::CLEARANCE;
pub use unbalance::{COUPLE, LEAST_COUPLE, UNBALANCE};

use super::Result;
use super::estimates::Estimates;
use super::fault_figures::Contrast;
use super::fit::{Fitted, fit_within};
use super::machine::Machine;
use super::residual::Evidence;
use super::surface::Component;
use ballrace_outcome::{FaultFigures, FaultKind, FaultParameters};
use ballrace_plant::Plant;
use candidates::{Candidate, Extent, Search};
use std::ops::Deref;

/// A fault that a machine may have: departure from the healthy machine with unknowns that are fitted to a recording.
pub trait Fault {
    /// Returns the faults of this type that are searched in a machine.
    fn of_machine(machine: &Machine) -> Vec<Self>
    where
        Self: Sized;

    /// Returns the fault with its unknowns and the machines from which its fit starts; `None` if the recording shows none.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>>;

    /// Fits a candidate of this fault to the recording; `None` if no start is near enough. `now` is the machine without it.
    fn fit(&self, e: &Evidence, candidate: &Candidate, now: &Fitted, extent: Extent) -> Result<Option<Fitted>> {
        let fitted = |start| fit_within(e, &start, &candidate.own_unknowns(), extent.limits(8));
        candidate.near_start(e, now)?.map(fitted).transpose()
    }

    /// Returns machines with the fault to try at a site whose means have moved: each moves the shaft by so much that the position by the gaps of the
    /// baseline, known to a micrometre, does not show its force. Those of a later round than 0 are about `machine`, the best before. None where the force
    /// is about the same, and after the last round.
    fn trials(&self, _machine: &Machine, _round: usize) -> Vec<Machine> {
        vec![]
    }

    /// Removes the fault from a machine, which becomes as it was `before` in that respect.
    fn remove(&self, machine: &mut Machine, before: &Machine);

    /// Returns true if the fault is larger than the deviations of healthy bearings and rotors.
    fn exceeds_tolerance(&self, e: &Evidence, before: &Fitted, after: &Fitted) -> bool;

    /// Returns bearing and component of a damaged surface; `None` for a fault of another kind.
    fn surface(&self) -> Option<(usize, Component)> {
        None
    }

    /// Returns the bearing that has the fault; `None` if the rotor has it.
    fn bearing(&self) -> Option<usize> {
        self.surface().map(|(bearing, _)| bearing)
    }

    /// Returns the bearing whose cage angle the fault makes observable.
    fn shows_cage(&self) -> Option<usize> {
        None
    }

    /// Returns true if the cages are part of the fit, so that they are not searched again.
    fn includes_cages(&self) -> bool {
        false
    }

    /// Returns true if the fault changes the stiffness of the bearings along the motion.
    fn changes_stiffness(&self, _e: &Evidence) -> bool {
        false
    }

    /// Returns true for an error of a reading, which is no fault of bearing or rotor.
    fn is_of_measurement(&self) -> bool {
        false
    }

    /// Returns true if the fault moves the shaft: it is then searched at the readings with the errors that count against their prior.
    fn moves_shaft(&self) -> bool {
        false
    }

    /// Returns true for a fault by which the ring of a bearing gives way across the axis: without a baseline, nothing tells another clearance, a loose
    /// ring and a soft support of this bearing or that apart.
    fn gives_way(&self) -> bool {
        false
    }

    /// Returns true if the gain before the fit shows little of the fault.
    fn is_nonlinear(&self) -> bool {
        false
    }

    /// Returns true if sound machines differ in it between recordings: one below the least size of a fault is then part of the sound machine.
    fn is_of_sound_machines(&self) -> bool {
        true
    }

    /// Returns the share of the largest gain by which the first fit of a candidate may be worse and is continued.
    fn nearly(&self) -> f64 {
        0.0
    }

    /// Returns the relative error of the force of the fault in the model, beyond that of the stiffness: its square of the gain is left.
    fn force_error(&self) -> f64 {
        0.0
    }

    /// Returns the kind under which the fault is reported.
    fn kind(&self) -> FaultKind;

    /// Returns the name in a sentence.
    fn name(&self, plant: &Plant) -> String;

    /// Returns the order of the lines of the fault; 0 where it changes the mean position.
    fn order(&self, of: &Estimates) -> f64 {
        let Some((bearing, component)) = self.surface() else { return 0.0 };
        let mounted = &of.e.plant.bearings[bearing];
        let cage_ratio = mounted.kinematics.cage_ratio * (1.0 - of.last.machine.bearings[bearing].cage.slip);
        component.order(mounted.elements, cage_ratio, mounted.kinematics.orders.ball_spin)
    }

    /// Returns place and size.
    fn parameters(&self, of: &Estimates) -> FaultParameters;

    /// Returns a sentence of place and size, without its full stop.
    fn sentence(&self, of: &Estimates, parameters: &FaultParameters) -> String;

    /// Returns the data of the figures.
    fn figures(&self, of: &Contrast) -> FaultFigures {
        FaultFigures { rose: None, spectra: of.spectra(), motion: of.motion() }
    }
}

/// Defines the enum of all faults, and its methods over them.
macro_rules! registry {
    ($($module:ident::$fault:ident),+ $(,)?) => {
        /// A fault of the registry.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub(crate) enum AnyFault {
            $($fault($module::$fault)),+
        }

        impl Deref for AnyFault {
            type Target = dyn Fault;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$fault(fault) => fault),+
                }
            }
        }

        impl AnyFault {
            /// Returns all faults that are searched in a machine.
            pub(crate) fn of_machine(machine: &Machine) -> Vec<Self> {
                let mut all = vec![];
                $(all.extend($module::$fault::of_machine(machine).into_iter().map(Self::$fault));)+
                all
            }
        }
    };
}

registry!(
    unbalance::Unbalance,
    load::Load,
    clearance::Clearance,
    looseness::Looseness,
    support::Support,
    misalignment::Misalignment,
    coupling::Coupling,
    run_out::RunOut,
    spall::Spall,
    waviness::Waviness,
);

impl AnyFault {
    /// Returns a machine without the fault, as it was `before` in that respect.
    pub fn removed(self, machine: &Machine, before: &Machine) -> Machine {
        let mut machine = machine.clone();
        self.remove(&mut machine, before);
        machine
    }
}
