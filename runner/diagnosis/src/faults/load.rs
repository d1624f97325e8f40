//! Constant load on the rotor other than the scene's.

use super::super::Result;
use super::super::estimates::Estimates;
use super::super::fault_figures::Contrast;
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, LINEAR, Parameter, Unknown};
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

/// The same over the weight of the rotor, between recordings of a site.
const SHARE_OF_WEIGHT: f64 = 0.2;

/// Returns the basic static radial rating of a bearing, N (ISO 76): of balls `f0 i Z D^2 cos(alpha)` with the largest factor, 15 N/mm^2, of
/// rollers `44 N/mm^2 (1 - gamma) i Z L D cos(alpha)`.
fn static_rating(bearing: &ballrace_scene::Bearing) -> f64 {
    let elements = bearing.elements as f64;
    let of_rollers = bearing.rollers.as_ref().map(|rollers| {
        let area = rollers.diameter * rollers.length * rollers.contact_angle.cos();
        44e6 * (1.0 - rollers.gamma()) * rollers.kind.rows() as f64 * elements * area
    });
    let of_balls = || bearing.geometry.map(|g| 15e6 * elements * g.ball_diameter * g.ball_diameter);
    of_rollers.or_else(of_balls).unwrap_or(f64::INFINITY)
}

/// Constant load other than the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load;

impl Fault for Load {
    fn of_machine(_: &Machine) -> Vec<Self> {
        vec![Self]
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        // The axial force is as uncertain as the axial position, which no radial probe of a site shows.
        let is_shown = |i: &usize| *i != 2 || search.e.site.is_none() || search.e.has_axial_probe();
        let unknowns: Vec<Unknown> = (0..3).filter(is_shown).map(|i| LOAD.of_rotor(i)).collect();
        search.linear_shift(AnyFault::Load(*self), &unknowns).map(Some)
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.load = before.load;
    }

    fn exceeds_tolerance(&self, e: &Evidence, before: &Fitted, after: &Fitted) -> bool {
        let change = |i: usize| (after.machine.load[i] - before.machine.load[i]).abs();
        let weight = e.scene.rotor.as_ref().map_or(0.0, |rotor| rotor.mass * 9.81);
        let least = e.site.as_ref().map_or(TOLERANCE, |_| SHARE_OF_WEIGHT * weight);
        // What the bearings would not survive is an error of the readings.
        let rating: f64 = after.machine.bearings.iter().map(|bearing| static_rating(&bearing.scene)).sum();
        (0..3).any(|i| change(i) > least && change(i) > e.significant() * after.deviation(LOAD.of_rotor(i)))
            && (0..3).all(|i| change(i) < rating)
    }

    fn changes_stiffness(&self, _: &Evidence) -> bool {
        true
    }

    fn moves_shaft(&self) -> bool {
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
