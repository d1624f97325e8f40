//! Angle and speed of a cage from the variable compliance of its bearing.

use super::Result;
use super::fit::{Fitted, MIN_FALL, changed, evaluate, fit};
use super::machine::{Cage, Machine, Unknown};
use super::motion::{C, D};
use super::residual::Evidence;
use super::surface::Baseband;
use ballrace::Phase;
use std::f64::consts::TAU;

/// Cage angles over one pitch at which the force is evaluated.
const PHASES: usize = 8;

/// Returns the slips to search, in steps in which the ball pass gains a quarter of a revolution over the record.
pub fn slips(e: &Evidence, bearing: usize, [from, to]: [f64; 2]) -> Vec<f64> {
    let mounted = &e.plant.bearings[bearing];
    let turns = (e.motion.turns[e.motion.len() - 1] - e.motion.turns[0]).abs();
    let passes = mounted.elements as f64 * mounted.kinematics.cage_ratio * turns;
    let step = 0.25 / passes;
    let count = ((to - from) / step).ceil() as usize;
    (0..=count).map(|i| from + (to - from) * i as f64 / count as f64).collect()
}

/// Returns candidates for slip and phase of the cage of `bearing` with their falls of chi-squared, best first.
///
/// The first harmonic of the ball pass is fitted at each slip of `range`.
pub fn search(
    e: &Evidence,
    band: &Baseband,
    start: &Fitted,
    bearing: usize,
    range: [f64; 2],
) -> Result<Vec<(f64, Cage)>> {
    let n = e.plant.bearings[bearing].elements as f64;
    let ratio = e.plant.bearings[bearing].kinematics.cage_ratio;
    let of = &start.machine.bearings[bearing];
    let len = e.motion.len();
    // Mean and first harmonic of the force by the cage angle.
    let evaluated = e.evaluated(&start.machine, bearing)?;
    let mut mean = vec![[0.0; D]; len];
    let mut first = vec![[C::new(0.0, 0.0); D]; len];
    for p in 0..PHASES {
        let part = p as f64 / PHASES as f64;
        let turn = C::from_polar(2.0 / PHASES as f64, -TAU * part);
        let cage = Phase::from_revolutions(part / n);
        for t in 0..len {
            let f = evaluated.force_at(&e.motion, t, cage);
            for i in 0..D {
                mean[t][i] += f[i] / PHASES as f64;
                first[t][i] += turn * f[i];
            }
        }
    }
    // Residual with the mean force of this bearing.
    let force = e.force(&start.spectra.replaced(bearing, e.about_centre(bearing, &|t| mean[t])));
    let residual = e.at_probes(&force);
    let series = band.thin(e, |t| first[t]);
    let mut found = Vec::new();
    for slip in slips(e, bearing, range) {
        let order = n * ratio * (1.0 - slip);
        let Some((line, column)) = band.column(e, &series, bearing, order, |turns| order * turns) else { continue };
        let part = band.part(e, &residual, line);
        // The residual is -F1 e^(i psi)/2 at positive frequencies.
        let square: f64 = column.iter().map(|c| c.norm_sqr()).sum();
        let right: C = column.iter().zip(&part).map(|(c, r)| -c.conj() * r).sum();
        let gain = right.norm_sqr() / square.max(1e-300);
        // The amplitude is known; the phase alone is free.
        found.push((gain, Cage { phase: right.arg() / TAU / n, slip, ..of.cage }));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(found)
}

/// Fall of chi-squared from which the angle of a cage counts as observable: four unknowns found among a few hundred
/// independent trials.
pub const OBSERVABLE: f64 = 40.0;

/// Cages of the search that are tried with the whole residual.
const TRIED: usize = 6;
/// Largest number of rounds over all bearings.
const ROUNDS: usize = 3;

/// Returns the unknowns of the observable cages; the change of the speed is one of them if it is not 0.
pub fn unknowns(observable: &[bool], machine: &Machine) -> Vec<Unknown> {
    let of = |b: usize| {
        let drift = (machine.bearings[b].cage.drift != 0.0).then_some(Unknown::CageDrift(b));
        [Unknown::CagePhase(b), Unknown::CageSlip(b)].into_iter().chain(drift)
    };
    observable.iter().enumerate().filter(|(_, o)| **o).flat_map(|(b, _)| of(b)).collect()
}

/// Fits a change of the speed of every observable cage, each where chi-squared falls by [`OBSERVABLE`] or more.
fn with_drift(e: &Evidence, settled: Fitted, observable: &[bool]) -> Result<Fitted> {
    let mut now = settled;
    for (b, _) in observable.iter().enumerate().filter(|(_, o)| **o) {
        let unknowns = [Unknown::CagePhase(b), Unknown::CageSlip(b), Unknown::CageDrift(b)];
        let tried = fit(e, &now, &unknowns, 3)?;
        if now.chi_square - tried.chi_square > threshold(&now) {
            now = tried;
        }
    }
    Ok(now)
}

/// Returns the least significant fall of chi-squared: [`OBSERVABLE`], times chi-squared per value where that exceeds 1.
fn threshold(now: &Fitted) -> f64 {
    OBSERVABLE * (now.chi_square / now.residual.len() as f64).max(1.0)
}

/// Fits slip and phase of every cage; returns which are observable.
pub fn fit_cages(e: &Evidence, band: &Baseband, machine: &Machine, range: [f64; 2]) -> Result<(Fitted, Vec<bool>)> {
    let mut now = evaluate(e, machine)?;
    let mut observable = vec![false; machine.bearings.len()];
    for round in 0..ROUNDS {
        let before = now.chi_square;
        for (bearing, is_observable) in observable.iter_mut().enumerate() {
            let candidates = search(e, band, &now, bearing, range)?;
            *is_observable = candidates.first().is_some_and(|c| c.0 > threshold(&now));
            if !*is_observable {
                continue;
            }
            let mut best = now.clone();
            for (_, cage) in candidates.iter().take(TRIED) {
                let mut machine = now.machine.clone();
                machine.bearings[bearing].cage = *cage;
                let tried = changed(e, &now, &machine)?;
                if tried.chi_square < best.chi_square {
                    best = tried;
                }
            }
            now = best;
            now = fit(e, &now, &[Unknown::CagePhase(bearing), Unknown::CageSlip(bearing)], 6)?;
        }
        now = fit(e, &now, &unknowns(&observable, &now.machine), 8)?;
        // The cages of the other bearings may mask one in the first round; a second round is useless if the first finds nothing.
        let fall = before - now.chi_square;
        if fall < MIN_FALL || (round > 0 && fall < 0.01 * now.chi_square) {
            break;
        }
    }
    Ok((with_drift(e, now, &observable)?, observable))
}
