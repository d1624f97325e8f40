//! Changed run-out of the shaft's surface under one probe: no fault of a bearing or of the rotor.

use super::super::Result;
use super::super::estimates::Estimates;
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::measurement::{HARMONICS, harmonic};
use super::super::parameter::{Access, LINEAR, Parameter, Unknown};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Cosine and sine of a multiple of the shaft angle in the reading of a probe.
static RUN_OUT: Parameter =
    Parameter { step: 1e-9, longest_step: LINEAR, changes_stiffness: false, access: Access::Reading };

/// Least change, m, of all multiples together.
const TOLERANCE: f64 = 1e-7;
/// Multiples that a sentence names, at most, and their least share of the largest.
const NAMED: (usize, f64) = (3, 0.3);

/// Changed run-out under a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunOut {
    probe: usize,
}

impl RunOut {
    fn unknowns(self) -> Vec<Unknown> {
        let of = |order: usize| [0, 1].map(|part| RUN_OUT.of_bearing_at(self.probe, harmonic(order, part)));
        (1..=HARMONICS).flat_map(of).collect()
    }

    /// Returns the amplitude of each multiple, m.
    fn amplitudes(self, machine: &Machine) -> Vec<f64> {
        let amplitude = |order: usize| {
            let [c, s] = [0, 1].map(|part| machine.readings[self.probe][harmonic(order, part)]);
            c.hypot(s)
        };
        (1..=HARMONICS).map(amplitude).collect()
    }
}

impl Fault for RunOut {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        (0..machine.readings.len()).map(|probe| Self { probe }).collect()
    }

    /// A run-out is expected at a site alone: elsewhere the readings are the motion of the shaft.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        if search.e.site.is_none() {
            return Ok(None);
        }
        search.linear(AnyFault::RunOut(*self), &self.unknowns()).map(Some)
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.readings[self.probe] = before.readings[self.probe];
    }

    fn exceeds_tolerance(&self, _: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        self.amplitudes(&after.machine).iter().map(|x| x * x).sum::<f64>().sqrt() > TOLERANCE
    }

    fn is_of_measurement(&self) -> bool {
        true
    }

    fn kind(&self) -> FaultKind {
        FaultKind::RunOut
    }

    fn name(&self, _: &Plant) -> String {
        "changed run-out under a probe".to_owned()
    }

    fn order(&self, of: &Estimates) -> f64 {
        let amplitudes = self.amplitudes(&of.last.machine);
        let largest = amplitudes.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        largest.map_or(1.0, |(i, _)| (i + 1) as f64)
    }

    fn parameters(&self, _: &Estimates) -> FaultParameters {
        FaultParameters::default()
    }

    fn sentence(&self, of: &Estimates, _: &FaultParameters) -> String {
        let mut amplitudes: Vec<(usize, f64)> =
            self.amplitudes(&of.last.machine).into_iter().enumerate().map(|(i, x)| (i + 1, 1e6 * x)).collect();
        amplitudes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (count, share) = NAMED;
        let largest = amplitudes.first().map_or(0.0, |one| one.1);
        let named: Vec<String> = amplitudes
            .iter()
            .take(count)
            .filter(|one| one.1 > share * largest)
            .map(|(order, x)| format!("{x:.2} um at {order}X"))
            .collect();
        let probes = of.e.scene.recording.as_ref().map(|recording| recording.probes.as_slice()).unwrap_or_default();
        format!(
            "Run-out under probe {} has changed: {}. This is the surface of the shaft, and no fault of a bearing",
            probes.get(self.probe).map_or("", |probe| probe.column.as_str()),
            named.join(", ")
        )
    }
}
