//! Fit of a candidate that changes the stiffness, in the weights that its residual has with it.

use super::super::cage::{self, SLIPS};
use super::super::faults::candidates::{Candidate, FAR};
use super::super::fit::{Fitted, MIN_FALL, MODEL_ERROR, evaluate, fit, fit_beside};
use super::super::machine::Machine;
use super::super::means::{fit_with_means, squares};
use super::super::parameter::Unknown;
use super::super::residual::Evidence;
use super::super::residual::site::DEPENDENT;
use super::super::{Prepared, Result};
use ballrace_base::parallel;

/// Most fits at a site of a machine that differs in stiffness: each to the readings without the errors that the machine before leaves.
const ROUNDS_OF_SITE: usize = 4;
/// Move of every parameter over its standard deviation by noise below which it stays.
const SETTLED: f64 = 0.2;

/// Fits a candidate with all cages searched again: in the fit of the machine without the fault, false cage angles explain part of
/// the fault.
pub(super) fn with_cages(of: &Prepared, candidate: &Candidate, first: &Fitted) -> Result<(Fitted, Vec<bool>)> {
    let (settled, observable) = cage::fit_cages(&of.evidence, &of.band, &first.machine, SLIPS)?;
    let mut unknowns = cage::unknowns(&observable, &settled.machine);
    unknowns.extend(candidate.own_unknowns());
    let again = fit(&of.evidence, &settled, &unknowns, 10)?;
    Ok(if again.chi_square < first.chi_square { (again, observable) } else { (first.clone(), of.observable.clone()) })
}

/// Machine with a fault that changes the stiffness, in weights of its own.
pub(super) struct Weighted<'a> {
    pub evidence: Evidence<'a>,
    pub fitted: Fitted,
    pub observable: Vec<bool>,
    /// Found from the trial of the candidate alone.
    pub is_trial: bool,
}

impl Weighted<'_> {
    /// Returns chi-squared of lines and gaps.
    fn chi_square(&self) -> f64 {
        self.fitted.chi_square + self.evidence.chi_square_of_gaps()
    }
}

/// Fits a candidate that changes the stiffness, weighted by the noise that the residual has with it.
///
/// With its own weights each machine has its residual in units of the noise of the probes, so that the likelihoods of machines of
/// different stiffness can be compared by their chi-squared.
pub(super) fn weighted<'a>(
    of: &Prepared<'a>,
    candidate: &Candidate,
    first: &Fitted,
    target: f64,
) -> Result<Weighted<'a>> {
    // The cages are found in the weights of the machine before, or in those of the first fit: either may be far from the truth.
    let (found, _) = with_cages(of, candidate, first)?;
    let further = (first.chi_square - found.chi_square >= MIN_FALL).then_some(&first.machine);
    let mut best = weighted_from(of, candidate, candidate.trial.as_ref().unwrap_or(&found.machine), target)?;
    best.is_trial = candidate.trial.is_some();
    for start in candidate.trial.is_some().then_some(&found.machine).into_iter().chain(further) {
        let values = best.fitted.residual.len() as f64;
        if !best.is_trial && best.fitted.chi_square < (1.0 + MODEL_ERROR) * values {
            break;
        }
        // Less than one value of a site does not tell two minima apart.
        let least = best.chi_square() + if best.is_trial { DEPENDENT } else { 0.0 };
        let other = weighted_from(of, candidate, start, target.min(least))?;
        if other.chi_square() < least {
            best = other;
        }
    }
    Ok(best)
}

/// Machine of a trial.
struct Trial {
    machine: Machine,
    /// Fall of chi-squared.
    gain: f64,
    /// Minus twice the logarithm of its likelihood by lines and means.
    square: f64,
}

/// Tries the machines of candidates that move the shaft, each in weights of its own, and round by round further ones about the best of all. The best
/// of a candidate is a further start of its fit where it explains more than is expected.
pub(super) fn with_trials(of: &Prepared, list: &mut [Candidate], now: &Fitted) -> Result<()> {
    let trial = |machine: &Machine| -> Result<Trial> {
        let [chi_square, square] = squares(of, machine)?;
        Ok(Trial { machine: machine.clone(), gain: now.chi_square - chi_square, square })
    };
    let best_of = |machines: Vec<Machine>| -> Result<Option<Trial>> {
        let trials = parallel::map(&machines, trial).into_iter().collect::<Result<Vec<Trial>>>()?;
        Ok(trials.into_iter().min_by(|a, b| a.square.total_cmp(&b.square)))
    };
    let first = list.iter().map(|candidate| best_of(candidate.fault.trials(&now.machine, 0)));
    let mut tried = first.collect::<Result<Vec<_>>>()?;
    let best = tried.iter_mut().zip(&*list).filter_map(|(tried, candidate)| Some((tried.as_mut()?, candidate.fault)));
    if let Some((best, fault)) = best.min_by(|a, b| a.0.square.total_cmp(&b.0.square)) {
        for round in 1.. {
            let Some(next) = best_of(fault.trials(&best.machine, round))? else { break };
            if next.square < best.square {
                *best = next;
            }
        }
    }
    for (candidate, tried) in list.iter_mut().zip(tried) {
        if let Some(Trial { machine, gain, .. }) = tried.filter(|tried| tried.gain > candidate.gain) {
            (candidate.gain, candidate.trial) = (gain, Some(machine));
        }
    }
    list.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(())
}

fn weighted_from<'a>(of: &Prepared<'a>, candidate: &Candidate, start: &Machine, target: f64) -> Result<Weighted<'a>> {
    let first = of.weighted_for(start)?;
    let (settled, observable) = cage::fit_cages(&first, &of.band, start, SLIPS)?;
    let mut unknowns = cage::unknowns(&observable, &settled.machine);
    unknowns.extend(candidate.own_unknowns());
    let fitted = fit(&first, &settled, &unknowns, 12)?;
    if fitted.chi_square > FAR * target {
        return Ok(Weighted { evidence: first, fitted, observable, is_trial: false });
    }
    if of.has_known_gaps() && candidate.fault.moves_shaft() {
        let moving = candidate.own_unknowns();
        let (evidence, with_means) = fit_with_means(of, &fitted.machine, &moving, target)?;
        unknowns.retain(|unknown| !moving.contains(unknown));
        let fitted = fit_beside(&evidence, &with_means, &unknowns, 12)?;
        return Ok(Weighted { evidence, fitted, observable, is_trial: false });
    }
    let (own, fitted) = in_own_weights(of, fitted, target)?;
    Ok(Weighted { evidence: own.unwrap_or(first), fitted, observable, is_trial: false })
}

/// Fits a machine in weights of its own, at a site until chi-squared or its parameters stay, or falls as large as the last one would not lead below `target`;
/// returns it with the recording so weighted, `None` without a round.
pub(super) fn in_own_weights<'a>(
    of: &Prepared<'a>,
    mut fitted: Fitted,
    target: f64,
) -> Result<(Option<Evidence<'a>>, Fitted)> {
    let mut last = None;
    let rounds = if of.site.is_some() { ROUNDS_OF_SITE } else { 1 };
    for round in 1..=rounds {
        let own = of.weighted_for(&fitted.machine)?;
        let next = fit(&own, &evaluate(&own, &fitted.machine)?, &fitted.unknowns, 12)?;
        last = Some(own);
        let before = std::mem::replace(&mut fitted, next);
        let moved = |unknown: &Unknown| (unknown.get(&fitted.machine) - unknown.get(&before.machine)).abs();
        let stays = |unknown: &Unknown| moved(unknown) < SETTLED * fitted.deviation(*unknown);
        let fall = before.chi_square - fitted.chi_square;
        // The first fall is also one of the weights.
        let is_hopeless = round > 1 && fitted.chi_square - (rounds - round) as f64 * fall.max(0.0) > target;
        if is_hopeless || fall.abs() < fitted.least_fall() || fitted.unknowns.iter().all(stays) {
            break;
        }
    }
    Ok((last, fitted))
}
