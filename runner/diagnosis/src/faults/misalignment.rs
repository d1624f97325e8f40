//! Misalignment of a bearing: its outer ring is tilted.

use super::super::Result;
use super::super::estimates::{Estimates, described, described_size};
use super::super::fit::Fitted;
use super::super::machine::Machine;
use super::super::parameter::{Access, Parameter};
use super::super::residual::Evidence;
use super::candidates::{Candidate, Search};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultKind, FaultParameters};
use ballrace_plant::Plant;
use std::f64::consts::{SQRT_2, TAU};

/// Tilt of an outer ring about X (0) or Y (1).
static TILT: Parameter = Parameter {
    step: 1e-8,
    longest_step: |_, _| 2e-4,
    changes_stiffness: true,
    access: Access::Bearing { get: |bearing, axis| bearing.tilt[axis], set: |bearing, axis, x| bearing.tilt[axis] = x },
};

/// Tilts that are tried, rad: one about a number of axes, others about the best axis.
const TILTS: (f64, [f64; 2], u32) = (0.4e-3, [0.15e-3, 0.8e-3], 8);
/// Tilt of the first trials at a site whose means have moved, rad, and the number of their axes; the next are larger about the best axis, then twice closer
/// by axis and by size.
const TRIALS: (f64, u32) = (0.6e-3, 4);
/// Least tilt, rad.
const TOLERANCE: f64 = 3e-5;
/// The same between recordings of a site: one minute of arc, half of the least that catalogues permit for deep groove ball bearings.
const TOLERANCE_OF_SITE: f64 = 2.9e-4;

/// Tilt of the outer ring of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misalignment {
    bearing: usize,
}

impl Fault for Misalignment {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        (0..machine.bearings.len()).map(|bearing| Self { bearing }).collect()
    }

    /// A small tilt is found by the slopes of the force; a large one, and one whose force is the same for both directions, by trial: first
    /// the axis, then the size.
    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        let own = [0, 1].map(|axis| TILT.of_bearing_at(self.bearing, axis));
        let tilted = |size: f64, axis: f64| {
            let mut machine = search.now.machine.clone();
            machine.bearings[self.bearing].tilt = [size * axis.cos(), size * axis.sin()];
            machine
        };
        let (first, others, axes) = TILTS;
        let (_, small) = search.shifted_step(&own)?;
        let about = (0..axes).map(|i| tilted(first, TAU * f64::from(i) / f64::from(axes)));
        let best = search.best_of(self.bearing, about)?;
        let [x, y] = best.1.bearings[self.bearing].tilt;
        let more = others.into_iter().map(|size| tilted(size, y.atan2(x))).chain([small]);
        let other = search.best_of(self.bearing, more)?;
        let (gain, start) = if other.0 > best.0 { other } else { best };
        Ok(Some(search.found(AnyFault::Misalignment(*self), gain, vec![start], &own)))
    }

    fn trials(&self, machine: &Machine, round: usize) -> Vec<Machine> {
        let (size, axes) = TRIALS;
        let [x, y] = machine.bearings[self.bearing].tilt;
        let (now, axis) = (x.hypot(y), y.atan2(x));
        let turned = |by: f64| [-1.0, 1.0].map(|side| (now, axis + side * by * TAU / f64::from(axes))).into();
        let sized = |by: f64| [1.0 / by, by].map(|times| (times * now, axis)).into();
        let vectors: Vec<(f64, f64)> = match round {
            0 => (0..axes).map(|i| (size, TAU * f64::from(i) / f64::from(axes))).collect(),
            1 => [2.0, 4.0].map(|times| (times * now, axis)).into(),
            2 => turned(0.25),
            3 => sized(SQRT_2),
            4 => turned(0.125),
            5 => sized(SQRT_2.sqrt()),
            _ => vec![],
        };
        let tilted = |(size, axis): (f64, f64)| {
            let mut tilted = machine.clone();
            tilted.bearings[self.bearing].tilt = [size * axis.cos(), size * axis.sin()];
            tilted
        };
        vectors.into_iter().map(tilted).collect()
    }

    fn remove(&self, machine: &mut Machine, before: &Machine) {
        machine.bearings[self.bearing].tilt = before.bearings[self.bearing].tilt;
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let [x, y] = after.machine.bearings[self.bearing].tilt;
        let deviation = [0, 1].map(|axis| after.deviation(TILT.of_bearing_at(self.bearing, axis)));
        let least = e.site.as_ref().map_or(TOLERANCE, |_| TOLERANCE_OF_SITE);
        x.hypot(y) > least.max(e.significant() * deviation[0].max(deviation[1]))
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

    fn kind(&self) -> FaultKind {
        FaultKind::Misalignment
    }

    fn name(&self, plant: &Plant) -> String {
        format!("misalignment of {}", plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let [tilt, axis] = of.vector([0, 1].map(|axis| TILT.of_bearing_at(self.bearing, axis)), 1e-3);
        FaultParameters { tilt_mrad: Some(tilt), axis_deg: Some(axis), ..FaultParameters::default() }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        format!(
            "Misalignment of {}: its outer ring is tilted by {} mrad about an axis at {} deg from +X",
            of.e.plant.bearings[self.bearing].name,
            described_size(p.tilt_mrad, 3),
            described(p.axis_deg, 0)
        )
    }
}
