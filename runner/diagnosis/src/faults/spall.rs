//! Local damage of a surface of a bearing.

use super::super::Result;
use super::super::estimates::{Estimates, described, not_negative};
use super::super::fault_figures::Contrast;
use super::super::fit::{Fitted, fit_within};
use super::super::machine::{Machine, MachineBearing};
use super::super::parameter::{Access, CAGE_PHASE, CAGE_SLIP, Parameter, SPIN_SLIP};
use super::super::residual::Evidence;
use super::super::surface::{Component, Family, SpallGuess, spall};
use super::candidates::{Candidate, EXPECTED, Extent, STARTS, Search, closest, evaluated};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultFigures, FaultForm, FaultKind, FaultParameters};
use ballrace_plant::Plant;
use ballrace_scene::Surface;
use std::f64::consts::{PI, TAU};

/// Angle of a spall on its component.
static AZIMUTH: Parameter = Parameter {
    step: 1e-5,
    longest_step: |_, _| 0.1,
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, d| bearing.scene.defect[d].azimuth,
        set: |bearing, d, x| bearing.scene.defect[d].azimuth = x,
    },
};

/// Half width of a spall.
static HALF_WIDTH: Parameter = Parameter {
    step: 1e-5,
    longest_step: |_, _| 0.01,
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, d| bearing.scene.defect[d].half_width,
        set: |bearing, d, x| {
            let widest = widest(bearing, d);
            bearing.scene.defect[d].half_width = x.clamp(0.004, widest);
        },
    },
};

/// Half width that a damage of a race may have whatever the number of elements, rad.
const NARROW: f64 = 0.1;

/// Half width of a damage of a race as wide as the pitch of the elements, from which it is an error of form: some element is always in it. Half that
/// of a ball.
fn widest(bearing: &MachineBearing, d: usize) -> f64 {
    match bearing.scene.defect[d].surface {
        Surface::Ball(_) => 1.0,
        Surface::Inner | Surface::Outer => (PI / bearing.scene.elements as f64).max(NARROW),
    }
}

/// Depth of a spall.
static DEPTH: Parameter = Parameter {
    step: 1e-10,
    longest_step: |_, _| 5e-7,
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, d| bearing.scene.defect[d].depth,
        set: |bearing, d, x| bearing.scene.defect[d].depth = x.max(1e-9),
    },
};

/// Least depth, m.
const TOLERANCE: f64 = 1e-7;
/// The same at a site: a sound race is not more even.
const TOLERANCE_OF_SITE: f64 = 5e-7;
/// Least significant ratio of the depth of a spall to its standard deviation; 1 of 40 spalls with depth 0 exceeds it.
const SIGNIFICANT: f64 = 2.0;
/// Relative error of the force of a spall: a real spall has no half-sine profile. Only the product of depth and width is well determined.
const PROFILE_ERROR: f64 = 0.05;
/// Relative standard deviation of depth and width at a site: spalls of equal area between the half-sine profile and a flat bottom, whose
/// depths differ by up to pi / 2.
const SHAPE_ERROR_OF_SITE: f64 = 0.165;

/// Places around a race that are tried, and depths over that of the linear search.
const PLACES: usize = 24;
const SHALLOWER: [f64; 2] = [0.3, 0.1];

/// Local damage of a surface of a bearing.
#[derive(Debug, Clone, Copy)]
pub struct Spall {
    bearing: usize,
    component: Component,
    /// Index among the spalls of the bearing.
    index: usize,
}

/// Further spalls of a component are not searched: two of one component are the same, whatever their index.
impl PartialEq for Spall {
    fn eq(&self, other: &Self) -> bool {
        self.surface() == other.surface()
    }
}

impl Fault for Spall {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        let of = |(bearing, index): (usize, usize)| Component::ALL.map(|component| Self { bearing, component, index });
        machine.bearings.iter().map(|bearing| bearing.scene.defect.len()).enumerate().flat_map(of).collect()
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        let (family, is_locked) =
            (&search.families(self.bearing, self.component).of_spall, search.locked[self.bearing]);
        let bearing = &search.now.machine.bearings[self.bearing];
        let elements = search.e.plant.bearings[self.bearing].elements;
        let per = if self.component == Component::Ball { 1.0 } else { elements as f64 };
        let known = is_locked.then_some((bearing.cage.phase + bearing.scene.first_element_azimuth / TAU) * per);
        let guesses = family.spalls(known);
        let Some(&(linear, _)) = guesses.first() else { return Ok(None) };
        // At a site lines count by the errors of their model, so that their strength tells more than their shape before the fit.
        let of_lines = if search.e.site.is_some() { EXPECTED * family.gain() } else { 0.0 };
        let gain = linear.max(of_lines);
        let starts = guesses.iter().map(|(_, guess)| with_spall(search.now, family, guess, is_locked)).collect();
        let mut own = vec![CAGE_PHASE.of_bearing(self.bearing), CAGE_SLIP.of_bearing(self.bearing)];
        own.extend([&AZIMUTH, &HALF_WIDTH, &DEPTH].map(|of| of.of_bearing_at(self.bearing, self.index)));
        if self.component == Component::Ball {
            own.push(SPIN_SLIP.of_bearing(self.bearing));
        }
        Ok(Some(search.found(AnyFault::Spall(*self), gain, starts, &own)))
    }

    /// A likely spall is fitted from further starts, however far, if the first ones lead nowhere.
    fn fit(&self, e: &Evidence, candidate: &Candidate, now: &Fitted, extent: Extent) -> Result<Option<Fitted>> {
        let fitted_from = |start: &Fitted| fit_within(e, start, &candidate.unknowns, extent.limits(30));
        let first = candidate.near_start(e, now)?.as_ref().map(fitted_from).transpose()?;
        let gain = first.as_ref().map_or(0.0, |fitted| now.chi_square - fitted.chi_square);
        if !extent.is_likely || gain > EXPECTED * candidate.gain {
            return Ok(first.filter(|fitted| self.is_local(fitted)));
        }
        // The fit ended in another minimum than that of the linear search.
        let mut starts = candidate.starts.get(STARTS..).unwrap_or_default().to_vec();
        starts.extend(candidate.starts.first().into_iter().flat_map(|start| self.elsewhere(start)));
        let mut others = evaluated(e, now, &starts)?;
        others.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        others.truncate(STARTS);
        let others = others.iter().map(fitted_from).collect::<Result<Vec<_>>>()?;
        Ok(closest(others.into_iter().chain(first).filter(|fitted| self.is_local(fitted))))
    }

    fn remove(&self, machine: &mut Machine, _: &Machine) {
        machine.bearings[self.bearing].scene.defect.remove(self.index);
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let depth = DEPTH.of_bearing_at(self.bearing, self.index);
        let at = after.unknowns.iter().position(|unknown| *unknown == depth);
        let deviation = at.map_or(0.0, |i| after.covariance[(i, i)].max(0.0).sqrt());
        let least = e.site.as_ref().map_or(TOLERANCE, |_| TOLERANCE_OF_SITE);
        depth.get(&after.machine) > f64::max(least, SIGNIFICANT * deviation)
    }

    fn surface(&self) -> Option<(usize, Component)> {
        Some((self.bearing, self.component))
    }

    fn shows_cage(&self) -> Option<usize> {
        Some(self.bearing)
    }

    fn includes_cages(&self) -> bool {
        true
    }

    fn force_error(&self) -> f64 {
        PROFILE_ERROR
    }

    fn kind(&self) -> FaultKind {
        self.component.kind()
    }

    fn name(&self, plant: &Plant) -> String {
        let surface = match self.component {
            Component::Outer => "outer race",
            Component::Inner => "inner race",
            Component::Ball => "a rolling element",
        };
        format!("a spall on {surface} of {}", plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        let [azimuth, width, depth] =
            [&AZIMUTH, &HALF_WIDTH, &DEPTH].map(|parameter| parameter.of_bearing_at(self.bearing, self.index));
        let element = match of.last.machine.bearings[self.bearing].scene.defect[self.index].surface {
            Surface::Ball(j) => Some(j + 1),
            Surface::Inner | Surface::Outer => None,
        };
        let on_race = self.component != Component::Ball;
        let error = if of.e.site.is_some() { SHAPE_ERROR_OF_SITE } else { PROFILE_ERROR };
        let size = |unknown, unit: f64| not_negative(of.profile_estimate(unknown, unit, error));
        FaultParameters {
            form: Some(FaultForm::Spall),
            azimuth_deg: on_race.then(|| of.angle(azimuth, self.component)),
            element,
            half_width_deg: Some(size(width, TAU / 360.0)),
            depth_um: Some(size(depth, 1e-6)),
            ..FaultParameters::default()
        }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        let (surface, place) = match self.component {
            Component::Outer => ("Outer race", format!("at {} deg from +X", described(p.azimuth_deg, 1))),
            Component::Inner => {
                ("Inner race", format!("at {} deg from the keyphasor mark", described(p.azimuth_deg, 1)))
            }
            Component::Ball => ("Rolling element", format!("on element {}", p.element.unwrap_or(1))),
        };
        let depth = match p.depth_um {
            Some(depth) if depth.low <= 0.0 => {
                format!("a depth that is not known apart from its width (at most {:.2} um)", depth.high)
            }
            depth => format!("{} um deep", described(depth, 2)),
        };
        format!(
            "{surface} of {}: a spall {place}, {depth}, half width {:.2} deg",
            of.e.plant.bearings[self.bearing].name,
            p.half_width_deg.map_or(0.0, |width| width.value)
        )
    }

    fn figures(&self, of: &Contrast) -> FaultFigures {
        let azimuth = AZIMUTH.of_bearing_at(self.bearing, self.index).get(of.machine);
        FaultFigures { rose: of.rose(azimuth), spectra: of.spectra(), motion: of.motion() }
    }
}

impl Spall {
    /// Returns true for a damage less wide than the pitch of the elements.
    fn is_local(&self, fitted: &Fitted) -> bool {
        let bearing = &fitted.machine.bearings[self.bearing];
        bearing.scene.defect[self.index].half_width < widest(bearing, self.index)
    }

    /// Returns machines with a spall on a race at other places, which the elements pass at the same instants, and of less depth: a rotor
    /// that sinks into a deep spall changes the force elsewhere as well, which the linear search disregards.
    fn elsewhere(&self, start: &Machine) -> Vec<Machine> {
        let at = |i: usize, share: f64| {
            let turned = i as f64 / PLACES as f64;
            let mut machine = start.clone();
            let bearing = &mut machine.bearings[self.bearing];
            bearing.cage.phase += turned;
            let spall = &mut bearing.scene.defect[self.index];
            spall.azimuth += TAU * turned;
            spall.depth *= share;
            machine
        };
        let places = if self.component == Component::Ball { 0 } else { PLACES };
        (0..places).flat_map(|i| SHALLOWER.map(|share| at(i, share))).collect()
    }
}

/// Returns the machine of `from` with the spall that `family` shows. The cage of an observable bearing keeps its angle.
fn with_spall(from: &Fitted, family: &Family, guess: &SpallGuess, observable: bool) -> Machine {
    let mut machine = from.machine.clone();
    let bearing = &mut machine.bearings[family.bearing];
    let n = family.elements;
    let first = bearing.scene.first_element_azimuth / TAU;
    match family.component {
        Component::Ball => {
            bearing.cage.spin_slip = family.slip;
            bearing.cage.spin_phase = 0.0;
            if !observable {
                bearing.cage.slip = family.slip;
            }
            let mut j = 0;
            if observable {
                j = ((guess.phase - first - bearing.cage.phase) * n).round().rem_euclid(n) as usize;
            } else {
                bearing.cage.phase = guess.phase - first;
            }
            bearing.scene.defect.push(spall(Surface::Ball(j), guess.centre, guess.half_width, guess.depth));
        }
        Component::Outer | Component::Inner => {
            if !observable {
                bearing.cage.phase = guess.phase / n - first;
                bearing.cage.slip = family.slip;
            }
            let surface = if family.component == Component::Outer { Surface::Outer } else { Surface::Inner };
            bearing.scene.defect.push(spall(surface, guess.centre, guess.half_width, guess.depth));
        }
    }
    machine
}
