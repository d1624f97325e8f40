//! Wave around a surface of a bearing.

use super::super::Result;
use super::super::estimates::{Estimates, described_size};
use super::super::fit::{Fitted, fit_within};
use super::super::machine::Machine;
use super::super::parameter::{Access, CAGE_SLIP, LINEAR, Parameter, SPIN_SLIP, Unknown};
use super::super::residual::Evidence;
use super::super::residual::site::sound_wave;
use super::super::surface::Component;
use super::candidates::{Candidate, Extent, FAR, Search, closest, evaluated};
use super::{AnyFault, Fault};
use ballrace_outcome::{FaultForm, FaultKind, FaultParameters};
use ballrace_plant::Plant;
use ballrace_scene::{Surface, Wave};
use std::f64::consts::PI;

/// Amplitude of one wave of the pair.
static AMPLITUDE: Parameter = Parameter {
    step: 1e-10,
    longest_step: LINEAR,
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, w| bearing.scene.waviness[w].amplitude,
        set: |bearing, w, x| bearing.scene.waviness[w].amplitude = x,
    },
};

/// Phases of the cosine and the sine wave of a pair.
const PHASES: [f64; 2] = [0.0, -0.5 * PI];
/// Least amplitude, m.
const TOLERANCE: f64 = 1e-8;
/// Waves of sound bearings, over which one is a fault at a site: those of a machine with a baseline are in its lines.
const EXCEEDS: f64 = 3.0;
/// Least amplitude of a wave that is a fault there, m: elements of sound bearings of ordinary class differ by up to 0.1 um.
const LEAST_OF_SITE: f64 = 0.15e-6;
/// Orders of a surface that are compared: another slip of its cage, with another order, may explain more until it is fitted, and the lines of
/// bearings of one kind coincide.
const RANKS: usize = 2;
/// Share of the largest gain by which a wave may be worse and is fitted further: where its line coincides with that of another, a first fit and
/// uncertain parameters leave as much.
const NEARLY: f64 = 0.02;

/// Wave around a race, or around all elements alike.
#[derive(Debug, Clone, Copy)]
pub struct Waviness {
    bearing: usize,
    component: Component,
    /// Waves around the surface; 0 until the search has found it.
    order: u32,
    /// Index of the first of its two waves among those of the bearing.
    index: usize,
    /// 0 for the most likely order of the surface, 1 for the next.
    rank: usize,
}

/// Waves of one order on a surface are the same fault, whatever their index.
impl PartialEq for Waviness {
    fn eq(&self, other: &Self) -> bool {
        (self.surface(), self.order) == (other.surface(), other.order)
    }
}

impl Waviness {
    /// Returns the in-phase and the quadrature amplitude.
    fn amplitudes(&self) -> [Unknown; 2] {
        [self.index, self.index + 1].map(|index| AMPLITUDE.of_bearing_at(self.bearing, index))
    }
}

impl Fault for Waviness {
    fn of_machine(machine: &Machine) -> Vec<Self> {
        let of = |(bearing, index): (usize, usize)| {
            let ranks = move |component| (0..RANKS).map(move |rank| Self { bearing, component, order: 0, index, rank });
            Component::ALL.into_iter().flat_map(ranks)
        };
        machine.bearings.iter().map(|bearing| bearing.scene.waviness.len()).enumerate().flat_map(of).collect()
    }

    fn candidate(&self, search: &Search) -> Result<Option<Candidate>> {
        let families = &search.families(self.bearing, self.component).of_wave;
        let waves: Vec<(f64, f64, u32)> = families
            .iter()
            .filter_map(|family| family.wave().map(|(gain, order, _)| (family.slip, gain, order)))
            .collect();
        let is_first = |i: &usize| waves[..*i].iter().all(|(.., order)| *order != waves[*i].2);
        let Some(first) = (0..waves.len()).filter(is_first).nth(self.rank) else { return Ok(None) };
        let (slip, gain, order) = waves[first];
        let other = waves[first + 1..].iter().filter(|(.., other)| *other == order).map(|(slip, ..)| *slip);
        let (surface, parameter) = match self.component {
            Component::Outer => (Surface::Outer, &CAGE_SLIP),
            Component::Inner => (Surface::Inner, &CAGE_SLIP),
            Component::Ball => (Surface::Ball(0), &SPIN_SLIP),
        };
        let start = |slip: f64| {
            let mut start = search.now.machine.clone();
            let bearing = &mut start.bearings[self.bearing];
            if self.component == Component::Ball {
                bearing.cage.spin_slip = slip;
            } else {
                bearing.cage.slip = slip;
            }
            let wave = |phase| Wave { surface, axial: false, order, amplitude: 0.0, phase };
            bearing.scene.waviness.extend(PHASES.map(wave));
            start
        };
        let [in_phase, quadrature] = self.amplitudes();
        let own = [in_phase, quadrature, parameter.of_bearing(self.bearing)];
        let starts = std::iter::once(slip).chain(other).map(start).collect();
        Ok(Some(search.found(AnyFault::Waviness(Self { order, ..*self }), gain, starts, &own)))
    }

    /// The amplitudes are fitted before the angles of the cages.
    fn fit(&self, e: &Evidence, candidate: &Candidate, now: &Fitted, extent: Extent) -> Result<Option<Fitted>> {
        let starts = evaluated(e, now, &candidate.starts)?;
        let fitted = starts.iter().filter(|start| start.chi_square < FAR * now.chi_square).map(|start| {
            let first = fit_within(e, start, &candidate.own_unknowns(), extent.limits(8))?;
            fit_within(e, &first, &candidate.unknowns, extent.limits(10))
        });
        Ok(closest(fitted.collect::<Result<Vec<_>>>()?.into_iter()))
    }

    fn remove(&self, machine: &mut Machine, _: &Machine) {
        machine.bearings[self.bearing].scene.waviness.drain(self.index..self.index + 2);
    }

    fn exceeds_tolerance(&self, e: &Evidence, _: &Fitted, after: &Fitted) -> bool {
        let [x, y] = self.amplitudes().map(|amplitude| amplitude.get(&after.machine));
        let exceeds = if e.is_without_baseline() { EXCEEDS } else { 1.0 };
        let least =
            e.site.as_ref().map_or(TOLERANCE, |_| LEAST_OF_SITE.max(exceeds * sound_wave(f64::from(self.order))));
        (x * x + y * y).sqrt() > least
    }

    fn surface(&self) -> Option<(usize, Component)> {
        Some((self.bearing, self.component))
    }

    /// A wave that all elements share shows no cage.
    fn shows_cage(&self) -> Option<usize> {
        (self.component != Component::Ball).then_some(self.bearing)
    }

    fn nearly(&self) -> f64 {
        NEARLY
    }

    fn kind(&self) -> FaultKind {
        self.component.kind()
    }

    fn name(&self, plant: &Plant) -> String {
        let surface = match self.component {
            Component::Outer => "on outer race",
            Component::Inner => "on inner race",
            Component::Ball => "of the rolling elements",
        };
        format!("waviness of order {} {surface} of {}", self.order, plant.bearings[self.bearing].name)
    }

    fn parameters(&self, of: &Estimates) -> FaultParameters {
        // Waves of the elements are along their contacts.
        let is_of_race = self.component != Component::Ball;
        let evaluated = of.e.evaluated(&of.last.machine, self.bearing).ok().filter(|_| is_of_race);
        let normal = evaluated.map_or(1.0, |bearing| bearing.contact_cosine(&of.e.motion));
        let [amplitude, _] = of.vector(self.amplitudes(), 1e-6 / normal);
        FaultParameters {
            form: Some(FaultForm::Waviness),
            waviness_order: Some(self.order),
            amplitude_um: Some(amplitude),
            ..FaultParameters::default()
        }
    }

    fn sentence(&self, of: &Estimates, p: &FaultParameters) -> String {
        let surface = match self.component {
            Component::Outer => "Outer race",
            Component::Inner => "Inner race",
            Component::Ball => "Rolling elements",
        };
        format!(
            "{surface} of {}: waviness of order {}, amplitude {} um",
            of.e.plant.bearings[self.bearing].name,
            self.order,
            described_size(p.amplitude_um, 3)
        )
    }
}
