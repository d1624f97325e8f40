//! Hypotheses: faults added to the machine, one after the other, as long as the recording supports them.

use super::candidates::{Candidate, SLIPS, Search};
use super::cause::Cause;
use super::fit::{Fitted, MIN_FALL, MODEL_ERROR, changed, evaluate, fit};
use super::machine::{Machine, MachineBearing, Unknown, clearance, union};
use super::residual::{Evidence, dot};
use super::{Prepared, Result, cage};
use ballrace_base::parallel;
use nalgebra::{DMatrix, DVector};

/// Identified fault, with the machine that contains it and all faults before it.
#[derive(Clone)]
pub struct Fault {
    pub cause: Cause,
    /// Fall of chi-squared by it.
    pub gain: f64,
    /// Cause of the second-best candidate, and the logarithm of the odds against it.
    pub next: Option<(Cause, f64)>,
    pub fitted: Fitted,
    /// Bearings whose cage can be observed with it.
    observable: Vec<bool>,
}

/// Scored candidate fault.
struct Judged<'a> {
    fault: Fault,
    /// Minus twice the logarithm of its probability before the recording, and of the share of it that the recording leaves.
    prior: f64,
    /// Fall of chi-squared where the uncertain parameters of a calibrated machine may act on its force.
    tolerated: f64,
    /// The recording weighted for the machine with the fault, where that differs in stiffness.
    evidence: Option<Evidence<'a>>,
}

impl Judged<'_> {
    fn chi_square(&self) -> f64 {
        self.fault.fitted.chi_square - self.tolerated
    }

    /// Fits the fault together with the cages that it shows: candidates whose lines coincide differ by less than what a first fit leaves.
    fn fit_further(&mut self, of: &Prepared) -> Result<()> {
        let Fault { fitted, observable, gain, .. } = &mut self.fault;
        let unknowns = union(cage::unknowns(observable, &fitted.machine), &fitted.unknowns);
        let evidence = self.evidence.as_ref().unwrap_or(&of.evidence);
        let further = fit(evidence, fitted, &unknowns, 10)?;
        *gain += fitted.chi_square - further.chi_square;
        *fitted = further;
        self.tolerated = tolerated(evidence, fitted)?;
        self.prior += precision_of_slip(self.fault.cause, &self.fault.fitted);
        Ok(())
    }
}

/// Returns the fall of chi-squared where the uncertain parameters of a calibrated machine may act on the force of the fault.
fn tolerated(e: &Evidence, fitted: &Fitted) -> Result<f64> {
    Ok(fall_by_uncertain(&e.uncertain_changes(&fitted.spectra, &fitted.machine)?, &fitted.residual))
}

/// Returns the fall of minus twice the log-likelihood where the covariance of the residual is that of the noise plus that of the uncertain
/// parameters: with the changes `C` of the residual `r` by one deviation of each, `r^T C (1 + C^T C)^-1 C^T r - ln det(1 + C^T C)`.
fn fall_by_uncertain(changes: &[Vec<f64>], residual: &[f64]) -> f64 {
    let n = changes.len();
    let covariance = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) + dot(&changes[i], &changes[j]));
    let along = DVector::from_iterator(n, changes.iter().map(|change| dot(change, residual)));
    let Some(factors) = covariance.cholesky() else { return 0.0 };
    let logarithm = 2.0 * factors.l_dirty().diagonal().map(f64::ln).sum();
    along.dot(&factors.solve(&along)) - logarithm
}

/// Largest ratio of the chi-squared of a start to the chi-squared before, for which a fit is started.
const FAR: f64 = 1.5;
/// Starts of a fit that are tried for a spall.
const STARTS: usize = 3;
/// Share of the expected gain of a spall below which further starts are tried, and of the largest expected gain below which they are not.
const EXPECTED: f64 = 0.5;

/// Returns the unknowns of a candidate without those of the cages.
fn own(candidate: &Candidate) -> Vec<Unknown> {
    let is_of_cage = |u: &Unknown| matches!(u, Unknown::CagePhase(_) | Unknown::CageSlip(_) | Unknown::CageDrift(_));
    candidate.unknowns.iter().copied().filter(|u| !is_of_cage(u)).collect()
}

/// Fits a candidate from the best of its first starts, and a likely spall from further ones, however far, if that leads nowhere; `None` if
/// no start is near enough to the recording (see [`FAR`]).
fn fitted(e: &Evidence, candidate: &Candidate, now: &Fitted, is_likely: bool) -> Result<Option<Fitted>> {
    let (first, others) = candidate.starts.split_at(STARTS.min(candidate.starts.len()));
    let evaluated =
        |machines: &[Machine]| machines.iter().map(|machine| changed(e, now, machine)).collect::<Result<Vec<_>>>();
    let closest = |starts: Vec<Fitted>| starts.into_iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    let Some(start) = closest(evaluated(first)?) else { return Ok(None) };
    let is_near = start.chi_square < FAR * now.chi_square;
    if let Cause::Spall(..) = candidate.cause {
        let fitted = if is_near { Some(fit(e, &start, &candidate.unknowns, 30)?) } else { None };
        let gain = fitted.as_ref().map_or(0.0, |fitted| now.chi_square - fitted.chi_square);
        if !is_likely || gain > EXPECTED * candidate.gain {
            return Ok(fitted);
        }
        // The fit ended in another minimum than that of the linear search.
        let mut others = evaluated(others)?;
        others.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        others.truncate(STARTS);
        let others = others.iter().map(|start| fit(e, start, &candidate.unknowns, 30)).collect::<Result<Vec<_>>>()?;
        return Ok(closest(others.into_iter().chain(fitted).collect()));
    }
    if !is_near {
        return Ok(None);
    }
    let first = fit(e, &start, &own(candidate), 8)?;
    Ok(Some(match candidate.cause {
        Cause::Waviness(..) => fit(e, &first, &candidate.unknowns, 10)?,
        _ => first,
    }))
}

/// Fits a candidate with all cages searched again: in the fit of the machine without the fault, false cage angles explain part of
/// the fault.
fn with_cages(of: &Prepared, candidate: &Candidate, first: &Fitted) -> Result<(Fitted, Vec<bool>)> {
    let (settled, observable) = cage::fit_cages(&of.evidence, &of.band, &first.machine, SLIPS)?;
    let mut unknowns = cage::unknowns(&observable, &settled.machine);
    unknowns.extend(own(candidate));
    let again = fit(&of.evidence, &settled, &unknowns, 10)?;
    Ok(if again.chi_square < first.chi_square { (again, observable) } else { (first.clone(), of.observable.clone()) })
}

/// Returns the machine without a fault, as it was `before` in that respect; `at` is the index of its spall or first wave.
pub(super) fn without(machine: &Machine, cause: Cause, at: usize, before: &Machine) -> Machine {
    let mut machine = machine.clone();
    match cause {
        Cause::Unbalance => machine.unbalance = before.unbalance,
        Cause::Load => machine.load = before.load,
        Cause::Clearance(b) => Unknown::Clearance(b).set(&mut machine, clearance(&before.bearings[b].scene)),
        Cause::Misalignment(b) => machine.bearings[b].tilt = before.bearings[b].tilt,
        Cause::Spall(b, _) => {
            machine.bearings[b].scene.defect.remove(at);
        }
        Cause::Waviness(b, ..) => {
            machine.bearings[b].scene.waviness.drain(at..at + 2);
        }
    }
    machine
}

/// Returns true if a fault is larger than the deviations of healthy bearings and rotors.
fn is_material(before: &Fitted, cause: Cause, after: &Fitted) -> bool {
    let (old, new) = (&before.machine, &after.machine);
    match cause {
        Cause::Unbalance => {
            let change =
                |i: usize| (new.unbalance[i] - old.unbalance[i]).hypot(new.unbalance[i + 1] - old.unbalance[i + 1]);
            let given = |i: usize| old.unbalance[i].hypot(old.unbalance[i + 1]);
            change(0) > 0.05 * given(0) || change(2) > 0.05 * given(2).max(0.02 * given(0))
        }
        Cause::Load => (0..3).any(|i| (new.load[i] - old.load[i]).abs() > 1.0),
        Cause::Clearance(b) => {
            let (old, new) = (clearance(&old.bearings[b].scene), clearance(&new.bearings[b].scene));
            (new - old).abs() > 3e-7_f64.max(0.03 * old)
        }
        Cause::Misalignment(b) => new.bearings[b].tilt[0].hypot(new.bearings[b].tilt[1]) > 3e-5,
        Cause::Spall(b, _) => {
            let depths = (0..after.unknowns.len())
                .filter(|&i| matches!(after.unknowns[i], Unknown::SpallDepth(of, _) if of == b));
            let deviation = depths.max().map_or(0.0, |i| after.covariance[(i, i)].max(0.0).sqrt());
            new.bearings[b].scene.defect.last().is_some_and(|d| d.depth > f64::max(1e-7, SIGNIFICANT * deviation))
        }
        Cause::Waviness(b, ..) => {
            let waves = &new.bearings[b].scene.waviness;
            waves.iter().rev().take(2).map(|w| w.amplitude * w.amplitude).sum::<f64>().sqrt() > 1e-8
        }
    }
}

/// Least significant ratio of the depth of a spall to its standard deviation; 1 of 40 spalls with depth 0 exceeds it.
const SIGNIFICANT: f64 = 2.0;
/// Largest number of faults in one diagnosis.
const MAX_FAULTS: usize = 3;
/// Largest number of fitted candidates, and their least share of the gain of the first.
const FITTED: (usize, f64) = (6, 0.2);
/// Share of the excess of chi-squared from which a candidate, or the faults found, explain it, so that less likely candidates are not
/// fitted.
const EXPLAINED: f64 = 0.8;
/// Less likely candidates that are fitted, at most, besides those that change the stiffness.
const FURTHER: usize = 3;
/// Fitted candidates for which the cages are searched again.
const SEARCHED: usize = 2;
/// Least significant fall of chi-squared by a fault: odds of e^50 against chance, with thousands of alternatives tried.
pub const MIN_GAIN: f64 = 100.0;
/// Relative error of the force of a spall: a real spall has no half-sine profile. Only the product of depth and width is well determined.
pub const PROFILE_ERROR: f64 = 0.05;
/// Relative error of the force of a fault in the model, twice that of the stiffness of the bearings. A candidate that is off by so
/// much leaves its square of the gain, so that smaller differences of chi-squared do not decide between candidates.
const FORCE_ERROR: f64 = 0.01;
/// Share of the largest gain by which a wave may be worse and is fitted further: where its line coincides with that of another, a first fit and
/// uncertain parameters leave as much.
const NEARLY: f64 = 0.02;
/// Least share that a further fault explains of the excess of chi-squared over the noise left by the faults before it.
const MIN_SHARE: f64 = 0.3;

/// Fits along the axial motion of the fit before.
const AXIAL_ROUNDS: usize = 2;

/// Mean and standard deviation of cage slip in practice: 0 to 3 %, up to 6 % under light load (NASA TN D-7870). It only selects
/// between lines that coincide for different slips.
const USUAL_SLIP: [f64; 2] = [0.005, 0.01];

/// Adds faults to the healthy machine as long as they explain enough.
pub fn diagnose(of: &mut Prepared, progress: &dyn Fn(f64)) -> Result<Vec<Fault>> {
    let mut locked = vec![false; of.observable.len()];
    let mut now = of.healthy.clone();
    let mut faults: Vec<Fault> = vec![];
    let values = now.residual.len() as f64;
    let first_excess = now.chi_square - (1.0 + MODEL_ERROR) * values;
    while faults.len() < MAX_FAULTS {
        let excess = now.chi_square - (1.0 + MODEL_ERROR) * values;
        let least = (MIN_SHARE * excess).max(MIN_GAIN).max(left_by_profiles(&faults));
        let cages = cage::unknowns(&of.observable, &now.machine);
        let list = Search { e: &of.evidence, band: &of.band, now: &now, cages }.candidates(&locked)?;
        progress(0.3 + 0.2 * faults.len() as f64);
        let Some(top) = list.iter().find(|c| faults.iter().all(|fault| fault.cause != c.cause)).map(|c| c.gain) else {
            break;
        };
        let is_new = |cause: Cause| faults.iter().all(|fault| fault.cause != cause);
        let is_likely = |c: &&Candidate| c.gain > (FITTED.1 * top).max(0.6 * least);
        let (likely, others): (Vec<&Candidate>, _) = list.iter().filter(|c| is_new(c.cause)).partition(is_likely);
        let mut tried = judged_all(of, &now, likely.into_iter().take(FITTED.0), SEARCHED)?;
        let is_fault =
            |judged: &&Judged| judged.fault.gain > least && is_material(&now, judged.fault.cause, &judged.fault.fitted);
        let best = tried.iter().filter(is_fault).map(|judged| judged.fault.gain).fold(0.0, f64::max);
        if best < EXPLAINED * excess && excess > MIN_GAIN.max((1.0 - EXPLAINED) * first_excess) {
            // The gain before the fit shows little of a candidate that changes the stiffness or starts far from its best.
            let changes = |c: &&Candidate| matches!(c.cause, Cause::Clearance(_) | Cause::Misalignment(_));
            let (nonlinear, others): (Vec<&Candidate>, Vec<&Candidate>) = others.into_iter().partition(changes);
            let further = nonlinear.into_iter().chain(others.into_iter().take(FURTHER));
            tried.extend(judged_all(of, &now, further, 1)?);
        }
        tried.retain(|judged| is_fault(&judged));
        let closest = |tried: &[Judged]| tried.iter().map(Judged::chi_square).fold(f64::INFINITY, f64::min);
        let left = FORCE_ERROR * FORCE_ERROR * best;
        let nearly = closest(&tried) + left + MIN_GAIN;
        let is_near = |judged: &Judged| {
            let is_wave = matches!(judged.fault.cause, Cause::Waviness(..));
            judged.chi_square() < nearly + if is_wave { NEARLY * best } else { 0.0 }
        };
        if tried.iter().filter(|judged| is_near(judged)).count() > 1 {
            for judged in tried.iter_mut().filter(|judged| is_near(judged)) {
                judged.fit_further(of)?;
            }
        }
        let equal = closest(&tried) + left;
        let score = |judged: &Judged| (judged.chi_square() - equal).max(0.0) + judged.prior;
        tried.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let next = if let [first, next, ..] = tried.as_slice() {
            Some((next.fault.cause, 0.5 * (score(next) - score(first))))
        } else {
            None
        };
        let Some(Judged { mut fault, mut evidence, .. }) = tried.into_iter().next() else { break };
        fault.next = next;
        if evidence.is_none() && of.evidence.follows_axially() && fault.cause.shows_cage().is_some() {
            evidence = moved_axially(of, &mut fault)?;
        }
        now = fault.fitted.clone();
        of.observable.clone_from(&fault.observable);
        if let Some(evidence) = evidence {
            of.evidence = evidence;
        }
        if let Some(b) = fault.cause.shows_cage() {
            locked[b] = true;
        }
        faults.push(fault);
        now = pruned(of, &mut faults, now)?;
        progress(0.4 + 0.2 * faults.len() as f64);
    }
    Ok(faults)
}

/// Returns the chi-squared that the spalls leave if their profiles are off by [`PROFILE_ERROR`].
fn left_by_profiles(faults: &[Fault]) -> f64 {
    let spalls = faults.iter().filter(|fault| matches!(fault.cause, Cause::Spall(..)));
    spalls.map(|spall| PROFILE_ERROR * PROFILE_ERROR * spall.gain).sum()
}

/// Returns true for a cause that changes the stiffness of the bearings along the motion: an unbalance moves those of an elastic rotor.
fn changes_stiffness(cause: Cause, e: &Evidence) -> bool {
    matches!(cause, Cause::Clearance(_) | Cause::Misalignment(_) | Cause::Load)
        || (cause == Cause::Unbalance && e.is_elastic())
}

/// Fits candidates and scores them; the cages are searched again for those that fit best.
fn judged_all<'a, 'b>(
    of: &Prepared<'a>,
    now: &Fitted,
    candidates: impl Iterator<Item = &'b Candidate>,
    searched: usize,
) -> Result<Vec<Judged<'a>>> {
    let candidates: Vec<&Candidate> = candidates.collect();
    let top = candidates.iter().map(|candidate| candidate.gain).fold(0.0, f64::max);
    let fit = |candidate: &&'b Candidate| -> Result<Option<(&'b Candidate, Fitted)>> {
        let is_likely = candidate.gain > EXPECTED * top;
        Ok(fitted(&of.evidence, candidate, now, is_likely)?.map(|fitted| (*candidate, fitted)))
    };
    let fits = parallel::map(&candidates, fit).into_iter().collect::<Result<Vec<_>>>()?;
    let mut fits: Vec<(&Candidate, Fitted)> = fits.into_iter().flatten().collect();
    fits.sort_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square));
    let ranked: Vec<(usize, (&Candidate, Fitted))> = fits.into_iter().enumerate().collect();
    let judge = |(rank, (candidate, fitted)): &(usize, (&Candidate, Fitted))| {
        judged(of, now, candidate, fitted, *rank < searched)
    };
    parallel::map(&ranked, judge).into_iter().collect()
}

/// Scores a fitted candidate, after a search of the cages where `search` allows it and something is left to explain.
fn judged<'a>(
    of: &Prepared<'a>,
    now: &Fitted,
    candidate: &Candidate,
    first: &Fitted,
    search: bool,
) -> Result<Judged<'a>> {
    let values = now.residual.len() as f64;
    let is_explained = first.chi_square < (1.0 + MODEL_ERROR) * values;
    let mut evidence = None;
    let (mut fitted, mut observable) = (first.clone(), of.observable.clone());
    match candidate.cause {
        cause if search && changes_stiffness(cause, &of.evidence) => {
            let (own, again, seen) = weighted(of, candidate, first)?;
            // Without contact, a machine has no stiffness to be weighted by.
            if again.chi_square < FAR * now.chi_square {
                (fitted, observable) = (again, seen);
                evidence = Some(own);
            }
        }
        Cause::Spall(b, _) => observable[b] = true,
        _ if search && !is_explained => (fitted, observable) = with_cages(of, candidate, first)?,
        _ => {}
    }
    if let Some(b) = candidate.cause.shows_cage() {
        observable[b] = true;
    }
    let penalty = values.ln() * candidate.unknowns.len() as f64;
    let unusual = |(b, bearing): (usize, &MachineBearing)| {
        // The cage ratio of the scene may be an estimate from this recording.
        let kinematics = &of.evidence.plant.bearings[b].kinematics;
        let slip = 1.0 - kinematics.cage_ratio * (1.0 - bearing.cage.slip) / kinematics.rolling_cage_ratio;
        ((slip - USUAL_SLIP[0]) / USUAL_SLIP[1]).powi(2)
    };
    let slips: f64 = fitted.machine.bearings.iter().enumerate().map(unusual).sum();
    // Only the gain of the fault counts, not that of the cages that are fitted with it.
    let at = candidate.cause.next_index(&now.machine);
    let before = evaluate(&of.evidence, &without(&fitted.machine, candidate.cause, at, &now.machine))?.chi_square;
    let before = before.min(now.chi_square);
    let prior = penalty + slips;
    let gain = before - fitted.chi_square - prior;
    Ok(Judged {
        fault: Fault { cause: candidate.cause, gain, next: None, fitted, observable },
        prior,
        tolerated: 0.0,
        evidence,
    })
}

/// Fits a machine with a fault of a surface along the axial motion that the fault causes, where no probe measures it; returns the recording
/// with that motion. Until then the axial motion is that of the machine without the fault, and what the fault adds is linear.
fn moved_axially<'a>(of: &Prepared<'a>, fault: &mut Fault) -> Result<Option<Evidence<'a>>> {
    let mut evidence = of.evidence.clone();
    let mut fitted = fault.fitted.clone();
    for _ in 0..AXIAL_ROUNDS {
        evidence.weight_for(&fitted.machine)?;
        fitted = fit(&evidence, &evaluate(&evidence, &fitted.machine)?, &fitted.unknowns, 12)?;
    }
    if fitted.chi_square >= fault.fitted.chi_square {
        return Ok(None);
    }
    fault.gain += fault.fitted.chi_square - fitted.chi_square;
    fault.fitted = fitted;
    Ok(Some(evidence))
}

/// Returns what the logarithm of the likelihood (times -2) loses because the slip must lie within its standard deviation: of two
/// waves whose lines coincide, that of the higher harmonic of the ball pass fits a narrower range of slips (Laplace's approximation).
fn precision_of_slip(cause: Cause, fitted: &Fitted) -> f64 {
    let at = cause.shows_cage().and_then(|b| fitted.unknowns.iter().position(|u| *u == Unknown::CageSlip(b)));
    let deviation = at.map(|i| fitted.covariance[(i, i)].sqrt()).filter(|deviation| *deviation > 0.0);
    deviation.map_or(0.0, |deviation| 2.0 * (USUAL_SLIP[1] / deviation).max(1.0).ln())
}

/// Removes the faults before the last one that explain nothing in addition to it: each was selected without the later faults.
fn pruned(of: &Prepared, faults: &mut Vec<Fault>, mut now: Fitted) -> Result<Fitted> {
    let mut i = 0;
    while i + 1 < faults.len() {
        let cause = faults[i].cause;
        if matches!(cause, Cause::Spall(..) | Cause::Waviness(..)) {
            i += 1;
            continue;
        }
        let others = faults.iter().filter(|fault| fault.cause != cause);
        let of_cages = cage::unknowns(&of.observable, &now.machine);
        let unknowns = others.fold(of_cages, |all, fault| union(all, &fault.fitted.unknowns));
        let start = evaluate(&of.evidence, &without(&now.machine, cause, 0, &of.healthy.machine))?;
        let fitted = fit(&of.evidence, &start, &unknowns, 20)?;
        if fitted.chi_square - now.chi_square < MIN_GAIN {
            now = fitted;
            faults.remove(i);
            if let Some(last) = faults.last_mut() {
                last.fitted = now.clone();
            }
        } else {
            i += 1;
        }
    }
    Ok(now)
}

/// Fits a candidate that changes the stiffness, weighted by the noise that the residual has with it.
///
/// With its own weights each machine has its residual in units of the noise of the probes, so that the likelihoods of machines of
/// different stiffness can be compared by their chi-squared.
fn weighted<'a>(of: &Prepared<'a>, candidate: &Candidate, first: &Fitted) -> Result<(Evidence<'a>, Fitted, Vec<bool>)> {
    // The cages are found in the weights of the machine before, or in those of the first fit: either may be far from the truth.
    let (found, _) = with_cages(of, candidate, first)?;
    let best = weighted_from(of, candidate, &found.machine)?;
    let is_explained = best.1.chi_square < (1.0 + MODEL_ERROR) * best.1.residual.len() as f64;
    if is_explained || first.chi_square - found.chi_square < MIN_FALL {
        return Ok(best);
    }
    let other = weighted_from(of, candidate, &first.machine)?;
    Ok(if other.1.chi_square < best.1.chi_square { other } else { best })
}

fn weighted_from<'a>(
    of: &Prepared<'a>,
    candidate: &Candidate,
    start: &Machine,
) -> Result<(Evidence<'a>, Fitted, Vec<bool>)> {
    let mut evidence = of.evidence.clone();
    evidence.weight_for(start)?;
    let (settled, observable) = cage::fit_cages(&evidence, &of.band, start, SLIPS)?;
    let mut unknowns = cage::unknowns(&observable, &settled.machine);
    unknowns.extend(own(candidate));
    let closer = fit(&evidence, &settled, &unknowns, 12)?;
    evidence.weight_for(&closer.machine)?;
    let fitted = fit(&evidence, &evaluate(&evidence, &closer.machine)?, &unknowns, 12)?;
    Ok((evidence, fitted, observable))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the logarithm of a normal distribution with the whole covariance matrix of the residual.
    #[test]
    fn uncertain_parameters_tolerate_a_residual_along_their_changes() {
        let value = |i: usize, k: usize| (0.7 * i as f64 + 2.1 * k as f64).sin();
        let changes: Vec<Vec<f64>> = (0..3).map(|k| (0..20).map(|i| 2.0 * value(i, k)).collect()).collect();
        let along: Vec<f64> = (0..20).map(|i| 3.0 * value(i, 0) - 2.0 * value(i, 2)).collect();
        let covariance = DMatrix::from_fn(20, 20, |i, j| {
            f64::from(u8::from(i == j)) + changes.iter().map(|change| change[i] * change[j]).sum::<f64>()
        });
        let logarithm = covariance.determinant().ln();
        let inverse = covariance.try_inverse().unwrap_or_default();
        for across in [0.0, 5.0] {
            let residual: Vec<f64> =
                along.iter().enumerate().map(|(i, x)| x + across * (2.9 * i as f64).cos()).collect();
            let vector = DVector::from_column_slice(&residual);
            let expected = vector.dot(&vector) - vector.dot(&(&inverse * &vector)) - logarithm;
            let found = fall_by_uncertain(&changes, &residual);
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
        }
        // A residual along the changes is tolerated nearly whole, one that is not there falls by nothing and costs the uncertainty.
        let whole = dot(&along, &along);
        assert!(fall_by_uncertain(&changes, &along) + logarithm > 0.95 * whole);
        assert!((fall_by_uncertain(&changes, &[0.0; 20]) + logarithm).abs() < 1e-9);
        assert!(fall_by_uncertain(&[], &along).abs() < f64::EPSILON);
    }
}
