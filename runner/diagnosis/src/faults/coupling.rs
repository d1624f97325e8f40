//! Misaligned coupling: a force on the end of the shaft, once and twice per turn.
//!
//! In a turn each element of a coupling yields along and across its offset. The force is free in both directions; its station is one beyond
//! a bearing, so that the motion at all probes is in proportion. A run-out is not: each probe has its own.

use super::super::Result;
use super::super::estimates::{Estimates, around, described, not_negative};
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, LINEAR, Parameter, Unknown};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultKind, FaultParameters};
use ballrace_plant::Plant;

/// Force once and then twice per turn: cosine and sine along X, then along Y.
static FORCE: Parameter = Parameter {
    step: 0.1,
    longest_step: LINEAR,
    changes_stiffness: false,
    access: Access::Rotor {
        get: |machine, i| machine.coupling.force[i / 4][i % 4],
        set: |machine, i, x| machine.coupling.force[i / 4][i % 4] = x,
    },
};

/// Station of the force; it stays beyond the bearings.
static STATION: Parameter = Parameter {
    step: 1e-5,
    longest_step: |_, _| 0.05,
    changes_stiffness: false,
    access: Access::Rotor {
        get: |machine, _| machine.coupling.station,
        set: |machine, _, x| {
            let [first, last] = ends(machine);
            let is_first = machine.coupling.station <= first;
            machine.coupling.station = if is_first { x.min(first) } else { x.max(last) };
        },
    },
};

/// Stations that are tried, beyond an end bearing, over the distance of the bearings.
const BEYOND: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Least force twice per turn over the weight of the rotor: bearings that stand at an angle and an elastic seat lead to less.
const TOLERANCE: f64 = 0.05;

/// Returns the stations of the first and the last bearing, m.
fn ends(machine: &Machine) -> [f64; 2] {
    let stations = machine.bearings.iter().map(|bearing| bearing.scene.station);
    [stations.clone().fold(f64::INFINITY, f64::min), stations.fold(f64::NEG_INFINITY, f64::max)]
}

/// Misaligned coupling at an end of the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// 0 for the end with the least station, else 1.
    end: usize,
}

impl Coupling {
    fn forces() -> [Unknown; 8] {
        std::array::from_fn(|i| FORCE.of_rotor(i))
    }

    /// Returns the largest force twice per turn, N: half the major axis of its ellipse. Once per turn, an unbalance may be part of it.
    fn size(machine: &Machine) -> f64 {
        let [xc, xs, yc, ys] = machine.coupling.force[1];
        let (forward, backward) = ((xc + ys).hypot(yc - xs), (xc - ys).hypot(yc + xs));
        0.5 * (forward + backward)
    }
}

impl Fault for Coupling {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        if machine.bearings.len() < 2 { vec![] } else { vec![Self { end: 0 }, Self { end: 1 }] }
    }

    /// A coupling is searched at a site alone; the force of one bends an elastic shaft in a way that its scene does not tell.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        if search.e.site.is_none() || search.e.is_elastic() {
            return Ok(None);
        }
        let [first, last] = ends(&search.now.machine);
        let mut best: Option<(f64, Machine)> = None;
        for share in BEYOND {
            let beyond = share * (last - first);
            let mut machine = search.now.machine.clone();
            machine.coupling.station = if self.end == 0 { first - beyond } else { last + beyond };
            let (gain, start) = search.linear_from(&machine, &Self::forces())?;
            if best.as_ref().is_none_or(|(least, _)| gain > *least) {
                best = Some((gain, start));
            }
        }
        let own: Vec<Unknown> = Self::forces().into_iter().chain([STATION.of_rotor(0)]).collect();
        Ok(best.map(|(gain, start)| search.found(AnyFault::Coupling(*self), gain, vec![start], &own)))
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.coupling = before.coupling;
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let weight = e.scene.rotor.as_ref().map_or(0.0, |rotor| rotor.mass * 9.81);
        let deviation = Self::forces().into_iter().map(|u| after.deviation(u)).fold(0.0, f64::max);
        let size = Self::size(&after.machine);
        size > TOLERANCE * weight && size > e.significant() * deviation
    }

    fn kind(&self) -> FaultKind {
        FaultKind::Coupling
    }

    fn name(&self, _: &Plant) -> String {
        "a misaligned coupling".to_owned()
    }

    fn order(&self, _: &Estimates) -> f64 {
        2.0
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let machine = &of.last.machine;
        let deviation = Self::forces().into_iter().map(|u| of.deviation(u)).fold(0.0, f64::max);
        let size = Self::size(machine);
        FaultParameters {
            coupling_force_n: Some(not_negative(around(size, deviation))),
            station_mm: Some(of.estimate(STATION.of_rotor(0), 1e-3, 0.0)),
            ..FaultParameters::default()
        }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        let bearings = &of.e.plant.bearings;
        let by_station =
            |a: &&ballrace_plant::MountedBearing, b: &&ballrace_plant::MountedBearing| a.station.total_cmp(&b.station);
        let nearest =
            if self.end == 0 { bearings.iter().min_by(by_station) } else { bearings.iter().max_by(by_station) };
        format!(
            "A force twice per turn beyond bearing {} of {} N, which moves all probes in proportion: misaligned or worn coupling",
            nearest.map_or("", |bearing| bearing.name.as_str()),
            described(p.coupling_force_n, 1)
        )
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    const SCENE: &str = r#"
        [shaft]
        speed = "3000 rpm"
        [rotor]
        mass = "12 kg"
        diametral_inertia = 0.06
        polar_inertia = 0.01
        [[bearing]]
        name = "DE"
        station = "-90 mm"
        bearing = "6309"
        [[bearing]]
        name = "NDE"
        station = "110 mm"
        bearing = "6309"
    "#;

    #[test]
    fn largest_force_and_station_beyond_the_bearings() {
        let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
        let mut machine = Machine::new(&scene).unwrap();
        // 30 N and 10 N along the axes of an ellipse at 30 degrees.
        let (s, c) = 30.0_f64.to_radians().sin_cos();
        machine.coupling.force[1] = [30.0 * c, -10.0 * s, 30.0 * s, 10.0 * c];
        assert!((Coupling::size(&machine) - 30.0).abs() < 1e-12, "{}", Coupling::size(&machine));
        let [first, last] = ends(&machine);
        let station = STATION.of_rotor(0);
        machine.coupling.station = first - 0.05;
        station.set(&mut machine, 0.0);
        assert_eq!(station.get(&machine), first);
        machine.coupling.station = last + 0.05;
        station.set(&mut machine, 0.3);
        assert_eq!(station.get(&machine), 0.3);
    }
}
