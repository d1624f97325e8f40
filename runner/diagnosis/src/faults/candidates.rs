//! Candidates: every fault that the machine may have, with the machines from which its fit starts.

use super::super::Result;
use super::super::cage::SLIPS;
use super::super::fit::{Fitted, Limits, changed, square};
use super::super::machine::Machine;
use super::super::parameter::{ForceSource, Unknown, union};
use super::super::residual::Evidence;
use super::super::surface::{Baseband, Compliance, Component, Families, best_families};
use super::AnyFault;
use ballrace_base::least_squares::dot;
use ballrace_base::parallel;
use nalgebra::{DMatrix, DVector};

/// Candidate fault with the start machines and the free unknowns of its fit.
pub struct Candidate {
    pub fault: AnyFault,
    /// Fall of chi-squared expected before the fit.
    pub gain: f64,
    /// Machines to start a fit from; further ones than [`STARTS`] are tried if these lead nowhere.
    pub starts: Vec<Machine>,
    pub unknowns: Vec<Unknown>,
    /// Machine that explains more in weights and with readings of its own than is expected of the candidate: a fit in those of the machine before may
    /// lead elsewhere.
    pub trial: Option<Machine>,
}

/// How far a candidate is fitted.
#[derive(Clone, Copy)]
pub struct Extent {
    /// Much is expected of the candidate, so that further starts are worth their time.
    pub is_likely: bool,
    /// Chi-squared from which on it competes with others.
    pub target: f64,
}

impl Extent {
    pub(crate) fn limits(self, iterations: usize) -> Limits {
        Limits { target: self.target, ..Limits::iterations(iterations) }
    }
}

/// Largest ratio of the chi-squared of a start to the chi-squared before, for which a fit is started.
pub const FAR: f64 = 1.5;
/// Starts of a fit that are tried.
pub(crate) const STARTS: usize = 3;
/// Share of the expected gain of a candidate below which further starts are tried, and of the largest expected gain below which they are
/// not.
pub const EXPECTED: f64 = 0.5;

impl Candidate {
    /// Returns the unknowns without those of the cages.
    pub(crate) fn own_unknowns(&self) -> Vec<Unknown> {
        self.unknowns.iter().copied().filter(|unknown| !unknown.is_of_cage()).collect()
    }

    /// Returns the best of the first starts; `None` if none is near enough to the recording (see [`FAR`]).
    pub(crate) fn near_start(&self, e: &Evidence, now: &Fitted) -> Result<Option<Fitted>> {
        let first = &self.starts[..STARTS.min(self.starts.len())];
        let start = closest(evaluated(e, now, first)?.into_iter());
        Ok(start.filter(|start| start.chi_square < FAR * now.chi_square))
    }
}

/// Evaluates machines that differ from `now` in some parts.
pub fn evaluated(e: &Evidence, now: &Fitted, machines: &[Machine]) -> Result<Vec<Fitted>> {
    machines.iter().map(|machine| changed(e, now, machine)).collect()
}

/// Returns the machine with the least residual.
pub fn closest(machines: impl Iterator<Item = Fitted>) -> Option<Fitted> {
    machines.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
}

/// State of the search for candidates.
pub struct Search<'a, 'b> {
    pub e: &'a Evidence<'b>,
    pub now: &'a Fitted,
    /// The same for faults that move the shaft: the readings with the errors that count against their prior.
    shifted: (&'a Evidence<'b>, &'a Fitted),
    /// Bearings whose cage is known from a fault found before.
    pub locked: &'a [bool],
    /// Unknowns of the observable cages, free in every fit.
    cages: Vec<Unknown>,
    /// Lines of each surface of each bearing.
    families: Vec<Families>,
}

impl<'a, 'b> Search<'a, 'b> {
    pub fn new(
        (e, now): (&'a Evidence<'b>, &'a Fitted),
        shifted: (&'a Evidence<'b>, &'a Fitted),
        band: &Baseband,
        cages: Vec<Unknown>,
        locked: &'a [bool],
    ) -> Result<Self> {
        let bearings: Vec<usize> = (0..locked.len()).collect();
        let of = |b: &usize| Compliance::new(e, band, *b, &now.machine);
        let compliance = parallel::map(&bearings, of).into_iter().collect::<Result<Vec<_>>>()?;
        let surfaces: Vec<(usize, Component)> =
            bearings.into_iter().flat_map(|b| Component::ALL.map(|component| (b, component))).collect();
        let families = parallel::map(&surfaces, |(b, component)| {
            best_families(e, band, now, &compliance[*b], *component, SLIPS, locked[*b])
        });
        Ok(Self { e, now, shifted, locked, cages, families })
    }

    /// Returns candidates, best first.
    pub fn candidates(&self) -> Result<Vec<Candidate>> {
        let faults = AnyFault::of_machine(&self.now.machine);
        let found = parallel::map(&faults, |fault| fault.candidate(self)).into_iter().collect::<Result<Vec<_>>>()?;
        let mut found: Vec<Candidate> = found.into_iter().flatten().collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        Ok(found)
    }

    /// Returns the lines of a surface.
    pub fn families(&self, bearing: usize, component: Component) -> &Families {
        &self.families[Component::ALL.len() * bearing + component as usize]
    }

    /// Returns a candidate; the cages are free in its fit.
    pub fn found(&self, fault: AnyFault, gain: f64, starts: Vec<Machine>, own: &[Unknown]) -> Candidate {
        Candidate { fault, gain, starts, unknowns: union(self.cages.clone(), own), trial: None }
    }

    /// Returns a candidate whose force depends linearly on its unknowns.
    pub fn linear(&self, fault: AnyFault, own: &[Unknown]) -> Result<Candidate> {
        let (gain, start) = linear_step((self.e, self.now, &self.now.machine), own)?;
        Ok(self.found(fault, gain, vec![start], own))
    }

    /// Returns the fall of chi-squared by a step of linear least squares from another machine of the same residual, and the machine after it.
    pub(crate) fn linear_from(&self, machine: &Machine, unknowns: &[Unknown]) -> Result<(f64, Machine)> {
        linear_step((self.e, self.now, machine), unknowns)
    }

    /// Returns a candidate that moves the shaft, and whose force depends linearly on its unknowns.
    pub(crate) fn linear_shift(&self, fault: AnyFault, own: &[Unknown]) -> Result<Candidate> {
        let (gain, start) = self.shifted_step(own)?;
        Ok(self.found(fault, gain, vec![start], own))
    }

    /// Returns the machine after a step of linear least squares in unknowns that move the shaft, with its fall of chi-squared.
    pub(crate) fn shifted_step(&self, unknowns: &[Unknown]) -> Result<(f64, Machine)> {
        let (e, now) = self.shifted;
        let (gain, machine) = linear_step((e, now, &now.machine), unknowns)?;
        Ok((gain - self.cost_of_shift(), machine))
    }

    /// Returns the fall of chi-squared by the errors of the readings that the sound machine has.
    fn cost_of_shift(&self) -> f64 {
        self.shifted.1.chi_square - self.now.chi_square
    }

    /// Tries `machines` that differ in one bearing and move the shaft, and returns the best with its fall of chi-squared.
    pub(crate) fn best_of(&self, bearing: usize, machines: impl Iterator<Item = Machine>) -> Result<(f64, Machine)> {
        let (e, now) = self.shifted;
        let mut best = (f64::NEG_INFINITY, now.machine.clone());
        for machine in machines {
            let spectra = e.changed(&now.spectra, &machine, ForceSource::Bearing(bearing))?;
            let gain = self.now.chi_square - square(&e.residual(&spectra));
            if gain > best.0 {
                best = (gain, machine);
            }
        }
        Ok(best)
    }
}

/// Returns the machine after a step of linear least squares in `unknowns` from a machine with the residual of `now`, with its fall of chi-squared.
fn linear_step((e, now, from): (&Evidence, &Fitted, &Machine), unknowns: &[Unknown]) -> Result<(f64, Machine)> {
    let slopes = e.slopes(&now.spectra, from, unknowns)?;
    let n = slopes.len();
    let normal = DMatrix::from_fn(n, n, |i, j| dot(&slopes[i], &slopes[j]));
    let right = DVector::from_fn(n, |i, _| -dot(&slopes[i], &now.residual));
    let Some(x) = normal.lu().solve(&right) else { return Ok((0.0, from.clone())) };
    let mut machine = from.clone();
    for (u, x) in unknowns.iter().zip(x.iter()) {
        u.set(&mut machine, u.get(from) + x);
    }
    Ok((x.dot(&right), machine))
}
