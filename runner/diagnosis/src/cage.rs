//! Angle and speed of a cage from the variable compliance of its bearing.

use super::Result;
use super::fit::{Fitted, MIN_FALL, MODEL_ERROR, changed, evaluate, fit};
use super::machine::{Cage, Machine};
use super::motion::{C, D};
use super::parameter::{CAGE_DRIFT, CAGE_PHASE, CAGE_SLIP, Unknown};
use super::residual::{Evidence, Spectra};
use super::surface::Baseband;
use ballrace::Phase;
use ballrace_base::parallel;
use std::f64::consts::TAU;

/// Range of slips searched.
pub const SLIPS: [f64; 2] = [-0.01, 0.06];
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

/// Mean and first harmonic of the force of a bearing by the angle of its cage, at each sample.
struct CageHarmonics {
    bearing: usize,
    mean: Vec<[f64; D]>,
    first: Vec<[C; D]>,
}

impl CageHarmonics {
    fn of(e: &Evidence, start: &Fitted, bearing: usize) -> Result<Self> {
        let n = e.plant.bearings[bearing].elements as f64;
        let evaluated = e.evaluated(&start.machine, bearing)?;
        let (mut mean, mut first) = (vec![[0.0; D]; e.motion.len()], vec![[C::new(0.0, 0.0); D]; e.motion.len()]);
        for p in 0..PHASES {
            let part = p as f64 / PHASES as f64;
            let turn = C::from_polar(2.0 / PHASES as f64, -TAU * part);
            let forces = evaluated.forces_at(&e.motion, Phase::from_revolutions(part / n));
            for ((mean, first), force) in mean.iter_mut().zip(&mut first).zip(forces) {
                for i in 0..D {
                    mean[i] += force[i] / PHASES as f64;
                    first[i] += turn * force[i];
                }
            }
        }
        Ok(Self { bearing, mean, first })
    }

    /// Returns the spectra of `start` with the mean force of this bearing.
    fn mean_alone(&self, e: &Evidence, start: &Fitted) -> Spectra {
        start.spectra.replaced(self.bearing, e.at_bearing(self.bearing, self.mean.clone()))
    }

    /// Returns candidates for slip and phase of the cage with their falls of chi-squared, best first.
    ///
    /// The first harmonic of the ball pass is fitted at each slip of `range`.
    fn search(&self, e: &Evidence, band: &Baseband, start: &Fitted, range: [f64; 2]) -> Vec<(f64, Cage)> {
        let bearing = self.bearing;
        let n = e.plant.bearings[bearing].elements as f64;
        let ratio = e.plant.bearings[bearing].kinematics.cage_ratio;
        let of = &start.machine.bearings[bearing];
        let residual = e.residual(&self.mean_alone(e, start));
        let series = band.thin(e, |t| self.first[t]);
        let tried = |slip: &f64| {
            let order = n * ratio * (1.0 - slip);
            let carrier = band.carrier(e, order, order)?;
            let column = band.column(e, &series, bearing, &carrier);
            let part = band.part(e, &residual, carrier.line);
            // The residual is -F1 e^(i psi)/2 at positive frequencies.
            let square: f64 = column.iter().map(|c| c.norm_sqr()).sum();
            let right: C = column.iter().zip(&part).map(|(c, r)| -c.conj() * r).sum();
            let gain = right.norm_sqr() / square.max(1e-300);
            // The amplitude is known; the phase alone is free.
            Some((gain, Cage { phase: right.arg() / TAU / n, slip: *slip, ..of.cage }))
        };
        let mut found: Vec<(f64, Cage)> =
            parallel::map(&slips(e, bearing, range), tried).into_iter().flatten().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
    }
}

/// Fall of chi-squared from which the angle of a cage counts as observable: four unknowns found among a few hundred
/// independent trials.
pub(crate) const OBSERVABLE: f64 = 40.0;

/// Cages of the search that are tried with the whole residual.
const TRIED: usize = 6;
/// Largest number of rounds over all bearings.
const ROUNDS: usize = 3;

/// Returns the unknowns of the observable cages; the change of the speed is one of them if it is not 0.
pub fn unknowns(observable: &[bool], machine: &Machine) -> Vec<Unknown> {
    let of = |b: usize| {
        let drift = (machine.bearings[b].cage.drift != 0.0).then_some(CAGE_DRIFT.of_bearing(b));
        [CAGE_PHASE.of_bearing(b), CAGE_SLIP.of_bearing(b)].into_iter().chain(drift)
    };
    observable.iter().enumerate().filter(|(_, o)| **o).flat_map(|(b, _)| of(b)).collect()
}

/// Fits a change of the speed of every observable cage, each where chi-squared falls by [`OBSERVABLE`] or more.
fn with_drift(e: &Evidence, settled: Fitted, observable: &[bool]) -> Result<Fitted> {
    let mut now = settled;
    for (b, _) in observable.iter().enumerate().filter(|(_, o)| **o) {
        let unknowns = [CAGE_PHASE.of_bearing(b), CAGE_SLIP.of_bearing(b), CAGE_DRIFT.of_bearing(b)];
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

/// Slips of each of two cages that are tried together.
const TRIED_TOGETHER: usize = 8;
/// Least distance of such slips, in steps of the search: the width of a line.
const APART: f64 = 4.0;

/// Fits slip and phase of both cages of a rotor on two bearings, and of each cage of another rotor; returns which are observable.
///
/// Where the lines of both cages overlap, the first cage may take the line of the second, and a fit of one after the other does not leave that
/// minimum: the likeliest slips of both are tried together.
pub(crate) fn fit_cages_together(
    e: &Evidence,
    band: &Baseband,
    machine: &Machine,
    range: [f64; 2],
) -> Result<(Fitted, Vec<bool>)> {
    let found = fit_cages(e, band, machine, range)?;
    let now = &found.0;
    if machine.bearings.len() != 2 || now.chi_square < (1.0 + MODEL_ERROR) * now.residual.len() as f64 {
        return Ok(found);
    }
    let start = evaluate(e, machine)?;
    let mut tried: [Vec<(Cage, Vec<f64>)>; 2] = Default::default();
    let harmonics = [CageHarmonics::of(e, &start, 0)?, CageHarmonics::of(e, &start, 1)?];
    for (bearing, tried) in tried.iter_mut().enumerate() {
        // The other cage has no line: at an unknown angle it would be a false one.
        let alone = Fitted { spectra: harmonics[1 - bearing].mean_alone(e, &start), ..start.clone() };
        let candidates = harmonics[bearing].search(e, band, &alone, range);
        let all = slips(e, bearing, range);
        let apart = APART * (range[1] - range[0]) / all.len() as f64;
        let mut peaks: Vec<Cage> = vec![];
        for (_, cage) in candidates {
            if peaks.len() < TRIED_TOGETHER && peaks.iter().all(|peak| (peak.slip - cage.slip).abs() > apart) {
                peaks.push(cage);
            }
        }
        let with_cage = |cage: &Cage| -> Result<(Cage, Vec<f64>)> {
            let mut machine = start.machine.clone();
            machine.bearings[bearing].cage = *cage;
            let residual = changed(e, &start, &machine)?.residual;
            Ok((*cage, residual.iter().zip(&start.residual).map(|(a, b)| a - b).collect()))
        };
        *tried = parallel::map(&peaks, with_cage).into_iter().collect::<Result<_>>()?;
    }
    let mut best: Option<(f64, [Cage; 2])> = None;
    for (of_first, first) in &tried[0] {
        for (of_second, second) in &tried[1] {
            let sums = start.residual.iter().zip(first).zip(second).map(|((r, a), b)| r + a + b);
            let square: f64 = sums.map(|r| r * r).sum();
            if best.as_ref().is_none_or(|(least, _)| square < *least) {
                best = Some((square, [*of_first, *of_second]));
            }
        }
    }
    let Some((_, cages)) = best else { return Ok(found) };
    let mut machine = machine.clone();
    for (bearing, cage) in machine.bearings.iter_mut().zip(cages) {
        bearing.cage = cage;
    }
    let together = fit(e, &evaluate(e, &machine)?, &unknowns(&[true; 2], &machine), 12)?;
    if now.chi_square - together.chi_square < threshold(now) {
        return Ok(found);
    }
    Ok((with_drift(e, together, &[true; 2])?, vec![true; 2]))
}

/// Fits slip and phase of every cage; returns which are observable.
pub(crate) fn fit_cages(
    e: &Evidence,
    band: &Baseband,
    machine: &Machine,
    range: [f64; 2],
) -> Result<(Fitted, Vec<bool>)> {
    let mut now = evaluate(e, machine)?;
    let mut observable = vec![false; machine.bearings.len()];
    for round in 0..ROUNDS {
        let before = now.chi_square;
        for (bearing, is_observable) in observable.iter_mut().enumerate() {
            let candidates = CageHarmonics::of(e, &now, bearing)?.search(e, band, &now, range);
            *is_observable = candidates.first().is_some_and(|c| c.0 > threshold(&now));
            if !*is_observable {
                continue;
            }
            let mut best = now.clone();
            let with_cage = |(_, cage): &(f64, Cage)| {
                let mut machine = now.machine.clone();
                machine.bearings[bearing].cage = *cage;
                changed(e, &now, &machine)
            };
            for tried in parallel::map(&candidates[..candidates.len().min(TRIED)], with_cage) {
                let tried = tried?;
                if tried.chi_square < best.chi_square {
                    best = tried;
                }
            }
            now = best;
            now = fit(e, &now, &[CAGE_PHASE.of_bearing(bearing), CAGE_SLIP.of_bearing(bearing)], 6)?;
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
