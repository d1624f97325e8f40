//! Unbalance other than the scene's.

use super::super::Result;
use super::super::estimates::{Estimates, around, described, described_size};
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, LINEAR, Parameter};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{Estimate, FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Static unbalance along X or Y.
pub static UNBALANCE: Parameter = Parameter {
    step: 1e-7,
    longest_step: LINEAR,
    changes_stiffness: false,
    access: Access::Rotor { get: |machine, i| machine.unbalance[i], set: |machine, i, x| machine.unbalance[i] = x },
};

/// Couple unbalance along X or Y.
pub static COUPLE: Parameter = Parameter {
    step: 1e-9,
    longest_step: LINEAR,
    changes_stiffness: false,
    access: Access::Rotor {
        get: |machine, i| machine.unbalance[2 + i],
        set: |machine, i, x| machine.unbalance[2 + i] = x,
    },
};

/// Least change over the scene's unbalance.
const TOLERANCE: f64 = 0.05;
/// The same between recordings of a site: deposits and temperature change the unbalance of a sound rotor.
const TOLERANCE_OF_SITE: f64 = 0.3;
/// Least couple, over the scene's static unbalance in m, to which a change of it is compared.
pub const LEAST_COUPLE: f64 = 0.02;

/// Unbalance other than the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unbalance;

impl Fault for Unbalance {
    fn of_machine(_: &Machine) -> Vec<Self> {
        vec![Self]
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        let unknowns = [UNBALANCE.of_rotor(0), UNBALANCE.of_rotor(1), COUPLE.of_rotor(0), COUPLE.of_rotor(1)];
        search.linear(AnyFault::Unbalance(*self), &unknowns).map(Some)
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.unbalance = before.unbalance;
    }

    fn exceeds_tolerance(&self, e: &Evidence, before: &Fitted, after: &Fitted) -> bool {
        let (old, new) = (before.machine.unbalance, after.machine.unbalance);
        let change = |i: usize| (new[i] - old[i]).hypot(new[i + 1] - old[i + 1]);
        let given = |i: usize| old[i].hypot(old[i + 1]);
        let share = e.site.as_ref().map_or(TOLERANCE, |_| TOLERANCE_OF_SITE);
        change(0) > share * given(0) || change(2) > share * given(2).max(LEAST_COUPLE * given(0))
    }

    /// An unbalance moves the bearings of an elastic rotor.
    fn changes_stiffness(&self, e: &Evidence) -> bool {
        e.is_elastic()
    }

    fn kind(&self) -> FaultKind {
        FaultKind::Unbalance
    }

    fn name(&self, _: &Plant) -> String {
        "unbalance".to_owned()
    }

    fn order(&self, _: &Estimates) -> f64 {
        1.0
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let [moment, angle] = of.vector([UNBALANCE.of_rotor(0), UNBALANCE.of_rotor(1)], 1e-6);
        let angle = of.with_pulse_error(angle);
        let [ex, ey, cx, cy] = of.last.machine.unbalance;
        let square = (ex * ex + ey * ey).max(1e-30);
        let station = (cx * ex + cy * ey) / square;
        let of_couple = of.deviation(COUPLE.of_rotor(0)).max(of.deviation(COUPLE.of_rotor(1)));
        let of_force = of.deviation(UNBALANCE.of_rotor(0)).max(of.deviation(UNBALANCE.of_rotor(1)));
        let deviation = of_couple.hypot(station * of_force) / square.sqrt();
        FaultParameters {
            moment_g_mm: Some(moment),
            angle_deg: Some(angle),
            station_mm: Some(around(station * 1e3, deviation * 1e3)),
            ..FaultParameters::default()
        }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        let value = |of: Option<Estimate>| of.map_or(0.0, |estimate| estimate.value);
        let correction = p.moment_g_mm.filter(|moment| moment.low > 0.0).map_or_else(String::new, |moment| {
            let opposite = (value(p.angle_deg) + 180.0).rem_euclid(360.0);
            format!("; {:.1} g mm at {opposite:.1} deg there balance it", moment.value)
        });
        format!(
            "Unbalance other than the scene's: {} g mm at {} deg from the keyphasor mark, station {:.1} mm{correction}",
            described_size(p.moment_g_mm, 1),
            described(p.angle_deg, 1),
            value(p.station_mm) + 1e3 * of.e.scene.drawn_station(0.0)
        )
    }
}
