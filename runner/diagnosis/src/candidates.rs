//! Candidates: every fault that the machine may have, with the machines from which its fit starts.

use super::Result;
use super::cause::Cause;
use super::fit::{Fitted, square};
use super::machine::{ForceSource, Machine, Unknown, clearance, union, waves};
use super::residual::{Evidence, dot};
use super::surface::{Baseband, Compliance, Component, Family, best_family, with_spall};
use ballrace_base::parallel;
use ballrace_scene::Surface;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Candidate fault with the start machines and the free unknowns of its fit.
pub struct Candidate {
    pub cause: Cause,
    /// Fall of chi-squared expected before the fit.
    pub gain: f64,
    /// Machines to start a fit from; further ones are tried if the first ones lead nowhere.
    pub starts: Vec<Machine>,
    pub unknowns: Vec<Unknown>,
}

/// Range of slips searched.
pub const SLIPS: [f64; 2] = [-0.01, 0.06];

fn linear(e: &Evidence, now: &Fitted, unknowns: &[Unknown]) -> Result<(f64, Machine)> {
    let slope = |u: &Unknown| e.slope(&now.spectra, &now.machine, *u);
    let slopes = parallel::map(unknowns, slope).into_iter().collect::<Result<Vec<_>>>()?;
    let n = slopes.len();
    let normal = DMatrix::from_fn(n, n, |i, j| dot(&slopes[i], &slopes[j]));
    let right = DVector::from_fn(n, |i, _| -dot(&slopes[i], &now.residual));
    let Some(x) = normal.lu().solve(&right) else { return Ok((0.0, now.machine.clone())) };
    let mut machine = now.machine.clone();
    for (u, x) in unknowns.iter().zip(x.iter()) {
        u.set(&mut machine, u.get(&now.machine) + x);
    }
    Ok((x.dot(&right), machine))
}

/// Tries `machines` and returns the best with its fall of chi-squared.
fn best_of(
    e: &Evidence,
    now: &Fitted,
    bearing: usize,
    machines: impl Iterator<Item = Machine>,
) -> Result<(f64, Machine)> {
    let mut best = (f64::NEG_INFINITY, now.machine.clone());
    for machine in machines {
        let spectra = e.changed(&now.spectra, &machine, ForceSource::Bearing(bearing))?;
        let gain = now.chi_square - square(&e.residual(&spectra));
        if gain > best.0 {
            best = (gain, machine);
        }
    }
    Ok(best)
}

/// Clearances that are tried, over the present one.
const CLEARANCES: [f64; 8] = [0.3, 0.6, 0.85, 1.15, 1.4, 1.8, 2.3, 3.0];
/// Number of golden-section steps about the best of them.
const CLOSER: usize = 5;
/// Share of the largest gain by which an equal one may be smaller.
const EQUAL_GAIN: f64 = 0.02;
/// Tilts that are tried, rad: one about a number of axes, others about the best axis.
const TILTS: (f64, [f64; 2], u32) = (0.4e-3, [0.15e-3, 0.8e-3], 8);

/// Returns the best of the clearances that are tried, as factors of the present one, and of some about it.
///
/// A clearance so large that no ball touches its race leaves the same residual as any larger one, and a fit has no slope there: of equal
/// clearances, the smallest is the start.
fn largest_gain<T: Clone>(of: impl Fn(f64) -> Result<(f64, T)>) -> Result<(f64, T)> {
    let mut tried = CLEARANCES.into_iter().map(&of).collect::<Result<Vec<_>>>()?;
    let high = tried.iter().fold(f64::NEG_INFINITY, |high, (gain, _)| high.max(*gain));
    let equal = high - EQUAL_GAIN * high.abs();
    let at = tried.iter().position(|(gain, _)| *gain >= equal).unwrap_or(0);
    let mut best = tried.swap_remove(at);
    let [mut from, mut to] = [at.saturating_sub(1), (at + 1).min(CLEARANCES.len() - 1)].map(|i| CLEARANCES[i]);
    let inner = |from: f64, to: f64| [0.382, 0.618].map(|share| from + share * (to - from));
    let [mut lower, mut upper] = inner(from, to).map(|factor| of(factor).map(|tried| (factor, tried)));
    for _ in 0..CLOSER {
        let ((below, (first, machine)), (above, (second, other))) = (lower?, upper?);
        for (gain, machine) in [(first, &machine), (second, &other)] {
            if gain > best.0 {
                best = (gain, machine.clone());
            }
        }
        if first >= second {
            to = above;
            let next = inner(from, to)[0];
            (lower, upper) = (of(next).map(|tried| (next, tried)), Ok((below, (first, machine))));
        } else {
            from = below;
            let next = inner(from, to)[1];
            (lower, upper) = (Ok((above, (second, other))), of(next).map(|tried| (next, tried)));
        }
    }
    Ok(best)
}

/// Part of the machine, of which the candidates are searched apart.
enum Part {
    Unbalance,
    Load,
    Clearance(usize),
    Misalignment(usize),
    Surface(usize, Component),
}

/// State of the search for candidates.
pub struct Search<'a, 'b> {
    pub e: &'a Evidence<'b>,
    pub band: &'a Baseband,
    pub now: &'a Fitted,
    /// Unknowns of the observable cages, free in every fit.
    pub cages: Vec<Unknown>,
}

impl Search<'_, '_> {
    /// Returns candidates, best first. The cages of `locked` bearings are known from a fault found before.
    pub fn candidates(&self, locked: &[bool]) -> Result<Vec<Candidate>> {
        let bearings: Vec<usize> = (0..locked.len()).collect();
        let of = |b: &usize| Compliance::new(self.e, self.band, *b, &self.now.machine);
        let compliance = parallel::map(&bearings, of).into_iter().collect::<Result<Vec<_>>>()?;
        let mut parts = vec![Part::Unbalance, Part::Load];
        for b in bearings {
            let components = [Component::Outer, Component::Inner, Component::Ball].map(|c| Part::Surface(b, c));
            parts.extend([Part::Clearance(b), Part::Misalignment(b)].into_iter().chain(components));
        }
        let candidates = |part: &Part| -> Result<Vec<Candidate>> {
            Ok(match *part {
                Part::Unbalance => vec![self.linear(Cause::Unbalance, (0..4).map(Unknown::Unbalance).collect())?],
                Part::Load => vec![self.linear(Cause::Load, (0..3).map(Unknown::Load).collect())?],
                Part::Clearance(b) => self.clearance(b)?.into_iter().collect(),
                Part::Misalignment(b) => vec![self.misalignment(b)?],
                Part::Surface(b, component) => {
                    let (compliance, is_locked) = (&compliance[b], locked[b]);
                    let family = best_family(self.e, self.band, self.now, compliance, component, SLIPS, is_locked);
                    self.spall(b, &family, is_locked).into_iter().chain(self.waviness(b, &family)).collect()
                }
            })
        };
        let parts = parallel::map(&parts, candidates).into_iter().collect::<Result<Vec<_>>>()?;
        let mut all: Vec<Candidate> = parts.into_iter().flatten().collect();
        all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        Ok(all)
    }

    /// Returns `own` with the unknowns of the observable cages.
    fn with_cages(&self, own: &[Unknown]) -> Vec<Unknown> {
        union(self.cages.clone(), own)
    }

    fn linear(&self, cause: Cause, own: Vec<Unknown>) -> Result<Candidate> {
        let (gain, start) = linear(self.e, self.now, &own)?;
        Ok(Candidate { cause, gain, starts: vec![start], unknowns: self.with_cages(&own) })
    }

    fn clearance(&self, b: usize) -> Result<Option<Candidate>> {
        let given = clearance(&self.now.machine.bearings[b].scene);
        if given <= 0.0 {
            return Ok(None);
        }
        let of = |factor: f64| {
            let mut machine = self.now.machine.clone();
            Unknown::Clearance(b).set(&mut machine, factor * given);
            best_of(self.e, self.now, b, std::iter::once(machine))
        };
        let (gain, start) = largest_gain(of)?;
        let unknowns = self.with_cages(&[Unknown::Clearance(b)]);
        Ok(Some(Candidate { cause: Cause::Clearance(b), gain, starts: vec![start], unknowns }))
    }

    /// Returns a tilt of the ring of a bearing. A small tilt is found by the slopes of the force; a large one, and one whose force is
    /// the same for both directions, by trial: first the axis, then the size.
    fn misalignment(&self, b: usize) -> Result<Candidate> {
        let own = vec![Unknown::Tilt(b, 0), Unknown::Tilt(b, 1)];
        let tilted = |size: f64, axis: f64| {
            let mut machine = self.now.machine.clone();
            machine.bearings[b].tilt = [size * axis.cos(), size * axis.sin()];
            machine
        };
        let (first, others, axes) = TILTS;
        let (_, small) = linear(self.e, self.now, &own)?;
        let about = (0..axes).map(|i| tilted(first, TAU * f64::from(i) / f64::from(axes)));
        let best = best_of(self.e, self.now, b, about)?;
        let [x, y] = best.1.bearings[b].tilt;
        let more = others.into_iter().map(|size| tilted(size, y.atan2(x))).chain([small]);
        let other = best_of(self.e, self.now, b, more)?;
        let (gain, start) = if other.0 > best.0 { other } else { best };
        let unknowns = self.with_cages(&own);
        Ok(Candidate { cause: Cause::Misalignment(b), gain, starts: vec![start], unknowns })
    }

    fn spall(&self, b: usize, family: &Family, is_locked: bool) -> Option<Candidate> {
        let bearing = &self.now.machine.bearings[b];
        let per = if family.component == Component::Ball { 1.0 } else { self.e.plant.bearings[b].elements as f64 };
        let known = is_locked.then_some((bearing.cage.phase + bearing.scene.first_element_azimuth / TAU) * per);
        let guesses = family.spalls(known);
        let gain = guesses.first()?.0;
        let starts = guesses.iter().map(|(_, guess)| with_spall(self.now, family, guess, is_locked)).collect();
        let d = bearing.scene.defect.len();
        let mut own = vec![
            Unknown::CagePhase(b),
            Unknown::CageSlip(b),
            Unknown::SpallAzimuth(b, d),
            Unknown::SpallWidth(b, d),
            Unknown::SpallDepth(b, d),
        ];
        if family.component == Component::Ball {
            own.push(Unknown::SpinSlip(b));
        }
        let cause = Cause::Spall(b, family.component);
        Some(Candidate { cause, gain, starts, unknowns: self.with_cages(&own) })
    }

    /// Returns a wave of a race, or of all elements.
    fn waviness(&self, b: usize, family: &Family) -> Option<Candidate> {
        let surface = match family.component {
            Component::Outer => Surface::Outer,
            Component::Inner => Surface::Inner,
            Component::Ball => Surface::Ball(0),
        };
        let (gain, order, _) = family.wave()?;
        let mut start = self.now.machine.clone();
        let bearing = &mut start.bearings[b];
        let slip = if family.component == Component::Ball {
            bearing.cage.spin_slip = family.slip;
            Unknown::SpinSlip(b)
        } else {
            bearing.cage.slip = family.slip;
            Unknown::CageSlip(b)
        };
        let w = bearing.scene.waviness.len();
        bearing.scene.waviness.extend(waves(surface, false, order, [0.0; 2]));
        let own = vec![Unknown::Wave(b, w), Unknown::Wave(b, w + 1), slip];
        let cause = Cause::Waviness(b, family.component, order);
        Some(Candidate { cause, gain, starts: vec![start], unknowns: self.with_cages(&own) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gain with a peak at 1.55 and with all balls lifted from 2 on.
    #[test]
    fn the_smallest_of_equal_clearances_is_the_start() {
        let of = |gain: &dyn Fn(f64) -> f64| {
            largest_gain(|factor| Ok((gain(factor), factor))).map_or(f64::NAN, |best| best.1)
        };
        let peak = of(&|factor| 100.0 - 100.0 * (factor - 1.55_f64).powi(2));
        assert!((peak - 1.55).abs() < 0.05, "{peak}");
        let lifted = of(&|factor| factor.min(2.0));
        assert!((2.0..=2.3).contains(&lifted), "{lifted}");
        // Gains may all be negative.
        let negative = of(&|factor| -1.0 - factor);
        assert!((0.3..0.35).contains(&negative), "{negative}");
    }
}
