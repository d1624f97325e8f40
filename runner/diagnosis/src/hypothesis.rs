//! Hypotheses: faults added to the machine, one after the other, as long as the recording supports them.

mod own_weights;

use super::faults::AnyFault;
use super::faults::candidates::{Candidate, EXPECTED, Extent, FAR, Search};
use super::fit::{Fitted, MODEL_ERROR, changed, evaluate, fit, fit_beside, square};
use super::machine::{Machine, MachineBearing};
use super::parameter::{CAGE_SLIP, union};
use super::residual::Evidence;
use super::residual::site::{DEPENDENT, GAIN_ERROR, UNEXPLAINED};
use super::site::SiteRecording;
use super::{Prepared, Result, cage};
use ballrace_base::least_squares::dot;
use ballrace_base::parallel;
use nalgebra::{DMatrix, DVector};
use own_weights::{in_own_weights, weighted, with_cages, with_trials};

/// Identified fault, with the machine that contains it and all faults before it.
#[derive(Clone)]
pub(crate) struct IdentifiedFault {
    pub fault: AnyFault,
    /// Fall of chi-squared by it.
    pub gain: f64,
    /// Second-best candidate, and the logarithm of the odds against it.
    pub next: Option<(AnyFault, f64)>,
    /// Logarithm of the odds against a fault of another kind or bearing, where one error of the model changes many values together.
    pub rival: f64,
    /// Share of the unexplained motion that it explains: of a surface of a site, of that at its own lines.
    pub explained: f64,
    /// Values of the residual that it changes.
    values: f64,
    pub fitted: Fitted,
    /// False for a fault of a site that moves the shaft, but explains less than half of the motion.
    explains_motion: bool,
    /// Bearings whose cage can be observed with it.
    observable: Vec<bool>,
}

impl IdentifiedFault {
    /// Finds the share that it explains, against a machine without it.
    fn explain(&mut self, e: &Evidence, without: &Machine) -> Result<()> {
        if e.site.is_none() || self.fault.surface().is_none() {
            let left = (self.fitted.chi_square - self.fitted.residual.len() as f64).max(0.0);
            self.explained = (self.gain / (self.gain + left)).clamp(0.0, 1.0);
            return Ok(());
        }
        let lacking = evaluate(e, &self.fault.removed(&self.fitted.machine, without))?;
        let left = &self.fitted.residual;
        let change: Vec<f64> = lacking.residual.iter().zip(left).map(|(a, b)| a - b).collect();
        AtLines { explained: self.explained, values: self.values } = AtLines::new(&change, left, 2 * e.rows);
        Ok(())
    }
}

/// Scored candidate fault.
struct Scored<'a> {
    identified: IdentifiedFault,
    /// Minus twice the logarithm of its probability before the recording, and of the share of it that the recording leaves.
    prior: f64,
    /// Fall of chi-squared where the uncertain parameters of a calibrated machine may act on its force.
    tolerated: f64,
    /// Chi-squared of the gaps that it leaves.
    of_gaps: f64,
    /// The recording weighted for the machine with the fault, where that differs in stiffness.
    evidence: Option<Evidence<'a>>,
    /// No more than the deviations of healthy bearings and rotors.
    is_sound: bool,
    /// Found from the trial of its candidate alone.
    is_trial: bool,
    /// A fault beside it explains enough as well.
    has_rival: bool,
}

impl Scored<'_> {
    fn chi_square(&self) -> f64 {
        self.identified.fitted.chi_square - self.tolerated + self.of_gaps
    }

    /// Fits the fault together with the cages that it shows: candidates whose lines coincide differ by less than what a first fit leaves.
    fn fit_further(&mut self, of: &Prepared, now: &Fitted) -> Result<()> {
        let IdentifiedFault { fault, fitted, observable, gain, .. } = &mut self.identified;
        let cages = cage::unknowns(observable, &fitted.machine);
        let is_of_means = self.evidence.is_some() && of.has_known_gaps() && fault.moves_shaft();
        let evidence = self.evidence.as_ref().unwrap_or(&of.evidence);
        let further = if is_of_means {
            fit_beside(evidence, fitted, &cages, 10)?
        } else {
            fit(evidence, fitted, &union(cages, &fitted.unknowns), 10)?
        };
        *gain += fitted.chi_square - further.chi_square;
        *fitted = further;
        self.tolerated = tolerated(evidence, fitted)?;
        self.prior += precision_of_slip(*fault, fitted);
        self.identified.explain(self.evidence.as_ref().unwrap_or(&of.evidence), &now.machine)
    }
}

/// What a fault changes, line by line.
struct AtLines {
    /// Mean of the shares that it explains of each line, where the lines count by what it changes of them. What is left of a line counts
    /// beyond its noise.
    explained: f64,
    /// Number of values of as many equal lines.
    values: f64,
}

impl AtLines {
    /// Compares the change by a fault with what it leaves, with so many values in a line.
    fn new(change: &[f64], left: &[f64], values: usize) -> Self {
        let mut sums = [0.0; 3];
        for (change, left) in change.chunks(values).zip(left.chunks(values)) {
            let square = dot(change, change);
            let left = (dot(left, left) - left.len() as f64).max(0.0);
            let explained = square * square / (square + left).max(f64::MIN_POSITIVE);
            sums.iter_mut().zip([explained, square, square * square]).for_each(|(sum, x)| *sum += x);
        }
        let [explained, square, fourth] = sums.map(|sum| sum.max(f64::MIN_POSITIVE));
        Self { explained: explained / square, values: square * square / fourth * values as f64 }
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

/// Largest number of faults in one diagnosis.
pub const MAX_FAULTS: usize = 3;
/// Largest number of fitted candidates, and their least share of the gain of the first.
const FITTED: (usize, f64) = (6, 0.2);
/// Share of the excess of chi-squared from which a candidate, or the faults found, explain it, so that less likely candidates are not
/// fitted.
const EXPLAINED: f64 = 0.8;
/// Less likely candidates that are fitted, at most, besides those that change the stiffness.
const FURTHER: usize = 3;
/// Largest fall of chi-squared by a fit over the expected one.
const GAIN_OVER_EXPECTED: f64 = 2.0;
/// Fitted candidates for which the cages are searched again.
const SEARCHED: usize = 2;
/// Least significant fall of chi-squared by a fault: odds of e^50 against chance, with thousands of alternatives tried.
pub(crate) const MIN_GAIN: f64 = 100.0;
/// Relative error of the force of a fault in the model, twice that of the stiffness of the bearings. A candidate that is off by so
/// much leaves its square of the gain, so that smaller differences of chi-squared do not decide between candidates.
const FORCE_ERROR: f64 = 0.01;
/// Standard deviations of the chi-squared of noise below its mean that a fit of the true machine does not leave.
const FEWER_THAN_NOISE: f64 = 5.0;
/// Share of the largest gain from which an error of a reading is taken before a fault.
const MEASURED: f64 = 0.7;
/// Excess of chi-squared over that of another candidate from which on one is decided against: at a site, odds of more than a thousand.
const DECIDED: f64 = 14.0 * DEPENDENT;
/// Largest share of the square of the unexplained motion that a fault leaves that moves the shaft of a site.
const EXPLAINED_MOTION: f64 = 0.5;
/// Least share that a further fault explains of the excess of chi-squared over the noise left by the faults before it, and that the first
/// fault of a surface of a site does: of what another cause leaves at all lines, such a fault explains some by chance.
const MIN_SHARE: f64 = 0.3;
const MIN_SHARE_OF_SITE: f64 = 0.2;

/// Spreads of the sum of the lines of a surface that a fault of it exceeds.
const SPREADS: f64 = 2.0;

/// Fits along the axial motion of the fit before, at least and at most, and the share of chi-squared by which one more has to lower it.
const AXIAL_ROUNDS: [usize; 2] = [2, 6];
const AXIAL_FALL: f64 = 0.02;

/// Mean and standard deviation of cage slip in practice: 0 to 3 %, up to 6 % under light load (NASA TN D-7870). It only selects
/// between lines that coincide for different slips.
const USUAL_SLIP: [f64; 2] = [0.005, 0.01];

/// Deviations of sound machines that are taken from a recording: one more ends the search.
const MAX_DEVIATIONS: usize = 3;

/// Adds at most `most` faults to the healthy machine, as long as they explain enough. Of a site, what explains more than any fault but does
/// not exceed the deviations of sound machines becomes part of the healthy machine.
pub fn diagnose(of: &mut Prepared, most: usize, progress: &dyn Fn(f64)) -> Result<Vec<IdentifiedFault>> {
    let mut locked = vec![false; of.observable.len()];
    let mut now = of.healthy.clone();
    let mut faults: Vec<IdentifiedFault> = vec![];
    let first_excess = excess(&now);
    while faults.len() < most && of.deviations.len() <= MAX_DEVIATIONS {
        let Some(least) = least_gain(of, &now, &faults) else { break };
        let cages = cage::unknowns(&of.observable, &now.machine);
        let moved = of.shifted.as_ref().map(|e| evaluate(e, &now.machine)).transpose()?;
        let shifted = match (&of.shifted, &moved) {
            (Some(e), Some(moved)) => (e, moved),
            _ => (&of.evidence, &now),
        };
        let mut list = Search::new((&of.evidence, &now), shifted, &of.band, cages, &locked)?.candidates()?;
        let known =
            |fault: &AnyFault| faults.iter().any(|other| other.fault == *fault) || of.deviations.contains(fault);
        list.retain(|candidate| !known(&candidate.fault));
        let is_as_recorded = faults.is_empty() && of.deviations.is_empty();
        if is_as_recorded && of.site.as_ref().is_some_and(SiteRecording::has_moved) {
            with_trials(of, &mut list, &now)?;
        }
        progress(0.3 + 0.2 * faults.len() as f64);
        let is_first = faults.is_empty();
        let round = Round { of, now: &now, shifted, least, is_first, first_excess };
        let Some(Scored { mut identified, mut evidence, is_sound, has_rival, .. }) = round.selected(&list)? else {
            break;
        };
        if evidence.is_none() && of.evidence.follows_axially() && identified.fault.shows_cage().is_some() {
            evidence = moved_axially(of, &now.machine, &mut identified)?;
        }
        let is_of_means = of.has_known_gaps() && identified.fault.moves_shaft();
        if of.site.is_some() && evidence.is_some() && !is_sound && !is_of_means {
            let before = identified.fitted.chi_square;
            let (own, fitted) = in_own_weights(of, identified.fitted, f64::INFINITY)?;
            identified.gain += before - fitted.chi_square;
            identified.fitted = fitted;
            evidence = own.or(evidence);
            identified.explain(evidence.as_ref().unwrap_or(&of.evidence), &now.machine)?;
        }
        now = identified.fitted.clone();
        of.observable.clone_from(&identified.observable);
        if let Some(evidence) = evidence {
            of.evidence = evidence;
        }
        if is_sound {
            of.deviations.push(identified.fault);
            match faults.last_mut() {
                None => of.healthy = now.clone(),
                // The faults so far are those of the machine with the deviation.
                Some(last) => {
                    let unknowns = union(last.fitted.unknowns.clone(), &now.unknowns);
                    last.fitted = Fitted { unknowns, ..now.clone() };
                }
            }
            if !has_rival && excess(&now) < 0.0 {
                break;
            }
            continue;
        }
        if let Some(b) = identified.fault.shows_cage() {
            locked[b] = true;
        }
        faults.push(identified);
        now = pruned(of, &mut faults, now)?;
        progress(0.4 + 0.2 * faults.len() as f64);
    }
    Ok(faults)
}

/// Returns the chi-squared of a machine over that of noise.
fn excess(now: &Fitted) -> f64 {
    now.chi_square - (1.0 + MODEL_ERROR) * now.residual.len() as f64
}

/// Returns the least gain of a further fault; `None` if the faults found need no further one.
fn least_gain(of: &Prepared, now: &Fitted, faults: &[IdentifiedFault]) -> Option<f64> {
    let excess = excess(now);
    let values = now.residual.len() as f64;
    let is_site = of.site.is_some();
    let least = (MIN_SHARE * excess).max(MIN_GAIN).max(left_by_model(faults));
    // What a fault of a site leaves beside what is expected has no further cause, and one that moves the shaft leaves lines of all bearings.
    let is_moved = faults.iter().any(|one| one.fault.moves_shaft());
    let is_expected = is_site && (is_moved || !faults.is_empty() && excess < 0.0);
    // A further fault of this gain would leave less than noise does. What is expected of a site leaves less anyway.
    let is_noise =
        !is_site && !faults.is_empty() && now.chi_square - least < values - FEWER_THAN_NOISE * (2.0 * values).sqrt();
    (!is_expected && !is_noise).then_some(least)
}

/// Search for one further fault.
struct Round<'a, 'b> {
    of: &'b Prepared<'a>,
    now: &'b Fitted,
    /// The same for faults that move the shaft.
    shifted: (&'b Evidence<'a>, &'b Fitted),
    /// Least gain of a fault.
    least: f64,
    /// No fault has been found.
    is_first: bool,
    /// Excess of chi-squared of the healthy machine.
    first_excess: f64,
}

impl<'a> Round<'a, '_> {
    /// Returns the most likely of the candidates; `None` if none explains enough.
    fn selected(&self, list: &[Candidate]) -> Result<Option<Scored<'a>>> {
        let Some(top) = list.first().map(|candidate| candidate.gain) else { return Ok(None) };
        let (mut tried, not_fitted) = self.tried(list, top)?;
        let may_be_sound = |fault: &AnyFault| self.of.site.is_some() && fault.is_of_sound_machines();
        tried.retain(|scored| {
            self.is_significant(scored) && (!scored.is_sound || may_be_sound(&scored.identified.fault))
        });
        let selected = self.compared(tried, not_fitted)?;
        let mut selected = selected.filter(|scored| scored.is_sound || !self.is_of_scene(&scored.identified.fault));
        if let Some(Scored { identified, .. }) = &mut selected
            && let Some(equal) = self.equal_without_baseline(identified.fault, list)
        {
            let odds = identified.next.map_or(0.0, |(_, odds)| odds.min(0.0));
            identified.next = Some((equal, odds));
        }
        Ok(selected)
    }

    /// Returns true for a fault that moves the shaft of a machine that was never recorded in good order, where the errors of its scene explain the recording:
    /// they are bounds, and the shape of all lines within them proves nothing.
    fn is_of_scene(&self, fault: &AnyFault) -> bool {
        let explained = (UNEXPLAINED - 1.0) * self.now.residual.len() as f64;
        self.of.evidence.is_without_baseline() && fault.moves_shaft() && self.first_excess < explained
    }

    /// Returns what else makes a ring of a bearing give way, and explains about as much before a fit, where no baseline tells the two apart.
    fn equal_without_baseline(&self, fault: AnyFault, list: &[Candidate]) -> Option<AnyFault> {
        if !self.of.evidence.is_without_baseline() || !fault.gives_way() {
            return None;
        }
        let own = list.iter().find(|candidate| candidate.fault == fault)?;
        let is_equal =
            |other: &&Candidate| other.fault.gives_way() && other.fault != fault && other.gain > EXPECTED * own.gain;
        list.iter().find(is_equal).map(|other| other.fault)
    }

    /// Returns the candidates that compete, fitted, and those that are not fitted.
    fn tried<'c>(&self, list: &'c [Candidate], top: f64) -> Result<(Vec<Scored<'a>>, Vec<&'c Candidate>)> {
        let (of, excess) = (self.of, excess(self.now));
        let is_likely = |c: &&Candidate| c.gain > (FITTED.1 * top).max(0.6 * self.least_of(&c.fault));
        let (likely, others): (Vec<&Candidate>, _) = list.iter().partition(is_likely);
        // Where the likeliest candidate explains the recording, the others are fitted as far as they compete with it.
        let mut likely = likely.into_iter().take(FITTED.0);
        let alone = Competition { searched: 1, top, explained: None, target: f64::INFINITY };
        let mut tried = self.scored_all(likely.next().into_iter(), alone)?;
        let values = self.now.residual.len() as f64;
        let explains = |scored: &&Scored| {
            of.site.is_none() && excess > 0.0 && scored.identified.fitted.chi_square < (1.0 + MODEL_ERROR) * values
        };
        let explained = tried.iter().filter(|scored| self.is_fault(scored)).find(explains);
        let explained = explained.map(|Scored { identified, .. }| [identified.fitted.chi_square, identified.gain]);
        let searched = if explained.is_some() { SEARCHED - 1 } else { SEARCHED };
        let beside = Competition { searched, explained, target: self.target(&tried), ..alone };
        let (competing, not_fitted): (Vec<&Candidate>, Vec<&Candidate>) =
            likely.partition(|candidate| beside.may_compete(of, candidate, self.now));
        tried.extend(self.scored_all(competing.into_iter(), beside)?);
        if self.best(&tried) < EXPLAINED * excess && excess > MIN_GAIN.max((1.0 - EXPLAINED) * self.first_excess) {
            // The gain before the fit shows little of a candidate that changes the stiffness or starts far from its best.
            let (nonlinear, others): (Vec<&Candidate>, Vec<&Candidate>) =
                others.into_iter().partition(|c| c.fault.is_nonlinear());
            let further = nonlinear.into_iter().chain(others.into_iter().take(FURTHER));
            let further_top = further.clone().map(|candidate| candidate.gain).fold(0.0, f64::max);
            let target = self.target(&tried);
            tried.extend(self.scored_all(further, Competition { top: further_top, target, ..alone })?);
        }
        Ok((tried, not_fitted))
    }

    /// Returns true for the first fault of a site where it is one of a surface: its lines are compared alone, whatever else departs.
    fn is_at_lines(&self, fault: &AnyFault) -> bool {
        self.is_first && self.of.site.is_some() && fault.surface().is_some()
    }

    fn least_of(&self, fault: &AnyFault) -> f64 {
        if self.is_at_lines(fault) { MIN_GAIN.max(MIN_SHARE_OF_SITE * excess(self.now)) } else { self.least }
    }

    /// Returns true where a candidate explains more than an error of the model, and the motion that it has to explain.
    fn is_significant(&self, Scored { identified, .. }: &Scored) -> bool {
        // What moves the shaft is compared in the shape of all lines: it must exceed the spread of their sum by noise. The lines of a sound
        // surface change from one recording to the next, those of one error of the model together.
        let spread = |values: f64| if self.of.site.is_some() { (2.0 * values).sqrt() } else { 0.0 };
        let of_kind = match (identified.fault.moves_shaft(), identified.fault.surface()) {
            (true, _) => spread(self.now.residual.len() as f64),
            (false, Some(_)) => SPREADS * spread(DEPENDENT * identified.values),
            (false, None) => 0.0,
        };
        let explains = if self.is_at_lines(&identified.fault) {
            identified.explained > MIN_SHARE
        } else {
            identified.explains_motion
        };
        identified.gain > self.least_of(&identified.fault).max(of_kind) && explains
    }

    fn is_fault(&self, scored: &Scored) -> bool {
        self.is_significant(scored) && !scored.is_sound
    }

    /// Returns the chi-squared from which on a candidate is decided against by those that were fitted.
    fn target(&self, tried: &[Scored]) -> f64 {
        let faults = tried.iter().filter(|scored| self.is_fault(scored));
        faults.map(Scored::chi_square).fold(f64::INFINITY, f64::min) + DECIDED
    }

    /// Returns the largest gain of a fault.
    fn best(&self, tried: &[Scored]) -> f64 {
        let faults = tried.iter().filter(|scored| self.is_fault(scored));
        faults.map(|scored| scored.identified.gain).fold(0.0, f64::max)
    }

    /// Compares fitted candidates, and returns the most likely one with the odds against the others.
    fn compared(&self, mut tried: Vec<Scored<'a>>, mut not_fitted: Vec<&Candidate>) -> Result<Option<Scored<'a>>> {
        let of = self.of;
        let best = tried.iter().map(|scored| scored.identified.gain).fold(0.0, f64::max);
        // What a probe may have measured accuses no bearing.
        let is_measured =
            |scored: &Scored| scored.identified.fault.is_of_measurement() && scored.identified.gain > MEASURED * best;
        if tried.iter().any(is_measured) {
            tried.retain(is_measured);
            not_fitted.clear();
        }
        let closest = |tried: &[Scored]| tried.iter().map(Scored::chi_square).fold(f64::INFINITY, f64::min);
        let left = force_error(of) * force_error(of) * best;
        let nearly = closest(&tried) + left + MIN_GAIN;
        let is_near = |scored: &Scored| scored.chi_square() < nearly + scored.identified.fault.nearly() * best;
        if tried.iter().filter(|scored| is_near(scored)).count() > 1 {
            for scored in tried.iter_mut().filter(|scored| is_near(scored)) {
                scored.fit_further(of, self.now)?;
            }
        }
        let equal = closest(&tried) + left;
        let score = |scored: &Scored| (scored.chi_square() - equal).max(0.0) + scored.prior;
        tried.sort_by(|a, b| score(a).total_cmp(&score(b)));
        // Of a machine that was never recorded in good order, the shape of the lines is not known well enough to tell faults apart by each. No more is the
        // position at which a fault that was searched with readings of its own would be another one.
        let is_trial = tried.first().is_some_and(|first| first.is_trial);
        let dependent = if of.evidence.is_without_baseline() || is_trial { DEPENDENT } else { 1.0 };
        let next = match (tried.as_slice(), not_fitted.first()) {
            ([first, next, ..], _) => Some((next.identified.fault, 0.5 * (score(next) - score(first)) / dependent)),
            ([first], Some(next)) => {
                Some((next.fault, 0.5 * (self.least_chi_square(next) - first.chi_square()) / dependent))
            }
            _ => None,
        };
        let Some((first, others)) = tried.split_first() else { return Ok(None) };
        let place = |fault: &AnyFault| (fault.kind(), fault.bearing());
        let is_other = |fault: &AnyFault| place(fault) != place(&first.identified.fault);
        let fitted = others.iter().filter(|other| is_other(&other.identified.fault)).map(&score);
        let not_fitted = not_fitted.iter().filter(|candidate| is_other(&candidate.fault));
        let not_fitted = not_fitted.map(|candidate| self.least_chi_square(candidate) - equal);
        let has_rival = others.iter().any(|other| !other.is_sound);
        let rival = (fitted.chain(not_fitted).fold(f64::INFINITY, f64::min) - score(first)) / (2.0 * DEPENDENT);
        Ok(tried.into_iter().next().map(|mut scored| {
            (scored.identified.next, scored.identified.rival) = (next, rival);
            scored.has_rival = has_rival;
            scored
        }))
    }

    /// Returns the least chi-squared of lines and gaps that a fit of a candidate may lead to.
    fn least_chi_square(&self, candidate: &Candidate) -> f64 {
        let of_gaps = if candidate.fault.moves_shaft() { 0.0 } else { self.of.evidence.chi_square_of_gaps() };
        self.now.chi_square - GAIN_OVER_EXPECTED * candidate.gain + of_gaps
    }

    /// Fits candidates and scores them.
    fn scored_all<'c>(
        &self,
        candidates: impl Iterator<Item = &'c Candidate>,
        competition: Competition,
    ) -> Result<Vec<Scored<'a>>> {
        let candidates: Vec<&Candidate> = candidates.collect();
        let fit = |candidate: &&'c Candidate| -> Result<Option<(&'c Candidate, Fitted)>> {
            let is_shifted = candidate.fault.moves_shaft();
            let (e, now) = if is_shifted { self.shifted } else { (&self.of.evidence, self.now) };
            let mut fitted = candidate.fault.fit(e, candidate, now, competition.extent(self.of, candidate))?;
            if let (None, Some(trial)) = (&fitted, &candidate.trial) {
                fitted = Some(changed(e, now, trial)?);
            }
            Ok(fitted.map(|fitted| (*candidate, fitted)))
        };
        let fits = parallel::map(&candidates, fit).into_iter().collect::<Result<Vec<_>>>()?;
        let mut fits: Vec<(&Candidate, Fitted)> = fits.into_iter().flatten().collect();
        fits.sort_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square));
        let ranked: Vec<(usize, (&Candidate, Fitted))> = fits.into_iter().enumerate().collect();
        let score = |(rank, (candidate, fitted)): &(usize, (&Candidate, Fitted))| {
            let is_searched = *rank < competition.searched || candidate.trial.is_some();
            self.scored(candidate, fitted, is_searched.then_some(competition.target))
        };
        parallel::map(&ranked, score).into_iter().collect()
    }

    /// Scores a fitted candidate, after a search of the cages where something is left to explain, towards a target; `None` without a search.
    fn scored(&self, candidate: &Candidate, first: &Fitted, search: Option<f64>) -> Result<Scored<'a>> {
        let Round { of, now, shifted: (shifted, moved), .. } = *self;
        let values = now.residual.len() as f64;
        let is_explained = first.chi_square < (1.0 + MODEL_ERROR) * values;
        let (mut evidence, mut is_trial) = (None, false);
        let (mut fitted, mut observable) = (first.clone(), of.observable.clone());
        let fault = candidate.fault;
        if let Some(target) = search
            && fault.changes_stiffness(&of.evidence)
        {
            // What explains too little competes with nothing.
            let own = weighted(of, candidate, first, target.min(now.chi_square - self.least_of(&fault)))?;
            // Without contact, a machine has no stiffness to be weighted by.
            if own.fitted.chi_square < FAR * now.chi_square {
                (fitted, observable, is_trial) = (own.fitted, own.observable, own.is_trial);
                evidence = Some(own.evidence);
            }
        } else if search.is_some() && !is_explained && !fault.includes_cages() {
            (fitted, observable) = with_cages(of, candidate, first)?;
        }
        if let Some(b) = fault.shows_cage() {
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
        let before = evaluate(&of.evidence, &fault.removed(&fitted.machine, &now.machine))?.chi_square;
        let before = before.min(now.chi_square);
        let prior = penalty + slips;
        let gain = before - fitted.chi_square - prior;
        let explains_motion = match of.shifted {
            Some(_) if fault.moves_shaft() => {
                let e = evidence.as_ref().unwrap_or(shifted);
                let lacking = evaluate(e, &fault.removed(&fitted.machine, &now.machine))?;
                // Both with the gaps that suit them. Without a baseline, no mean says anything.
                let about_mean = |e: &Evidence, of: &Fitted| square(&e.unexplained_rms(&of.spectra));
                let share = if e.is_without_baseline() { EXPLAINED_MOTION } else { 1.0 };
                e.unexplained_square(&fitted.spectra) < EXPLAINED_MOTION * e.unexplained_square(&lacking.spectra)
                    && about_mean(e, &fitted) < share * about_mean(shifted, moved)
            }
            _ => true,
        };
        let is_sound = !fault.exceeds_tolerance(&of.evidence, now, &fitted);
        let identified = IdentifiedFault {
            fault,
            gain,
            next: None,
            rival: f64::INFINITY,
            explained: 0.0,
            values: 0.0,
            fitted,
            explains_motion,
            observable,
        };
        let of_gaps = evidence.as_ref().unwrap_or(&of.evidence).chi_square_of_gaps();
        let mut scored =
            Scored { is_sound, is_trial, identified, prior, tolerated: 0.0, of_gaps, evidence, has_rival: false };
        scored.identified.explain(scored.evidence.as_ref().unwrap_or(&of.evidence), &now.machine)?;
        Ok(scored)
    }
}

/// Returns the relative error of the force of a fault in the model, with that of the gain of the probes at a site.
fn force_error(of: &Prepared) -> f64 {
    if of.site.is_some() { FORCE_ERROR.hypot(GAIN_ERROR) } else { FORCE_ERROR }
}

/// Returns the chi-squared that the faults leave by the error of their force in the model.
fn left_by_model(faults: &[IdentifiedFault]) -> f64 {
    faults.iter().map(|one| one.fault.force_error() * one.fault.force_error() * one.gain).sum()
}

/// Candidates that are fitted together, and what they compete with.
#[derive(Clone, Copy)]
struct Competition {
    /// Candidates for which the cages are searched again: those that fit best.
    searched: usize,
    /// Largest fall of chi-squared expected of a candidate.
    top: f64,
    /// Chi-squared and gain of a candidate that explains the recording.
    explained: Option<[f64; 2]>,
    /// Chi-squared from which on a candidate is decided against by another one.
    target: f64,
}

impl Competition {
    fn extent(&self, of: &Prepared, candidate: &Candidate) -> Extent {
        let is_likely = self.explained.is_none() && candidate.gain > EXPECTED * self.top;
        let Some([chi_square, gain]) = self.explained.filter(|_| !candidate.fault.is_of_measurement()) else {
            return Extent { is_likely, target: f64::INFINITY };
        };
        let near = (force_error(of) * force_error(of) + candidate.fault.nearly()) * gain;
        Extent { is_likely, target: chi_square + near + MIN_GAIN }
    }

    /// Returns false for a candidate that would have to explain far more than is expected of it.
    fn may_compete(&self, of: &Prepared, candidate: &Candidate, now: &Fitted) -> bool {
        candidate.fault.is_nonlinear()
            || now.chi_square - GAIN_OVER_EXPECTED * candidate.gain < self.extent(of, candidate).target
    }
}

/// Fits a machine with a fault of a surface along the axial motion that the fault causes, where no probe measures it; returns the recording
/// with that motion. Until then the axial motion is that of the machine without the fault, and what the fault adds is linear.
fn moved_axially<'a>(
    of: &Prepared<'a>,
    without: &Machine,
    identified: &mut IdentifiedFault,
) -> Result<Option<Evidence<'a>>> {
    let mut evidence = of.evidence.clone();
    let mut fitted = identified.fitted.clone();
    let [least, most] = AXIAL_ROUNDS;
    for round in 1..=most {
        let before = fitted.chi_square;
        evidence.weight_for(&fitted.machine)?;
        fitted = fit(&evidence, &evaluate(&evidence, &fitted.machine)?, &fitted.unknowns, 12)?;
        if round >= least && fitted.chi_square > (1.0 - AXIAL_FALL) * before {
            break;
        }
    }
    if fitted.chi_square >= identified.fitted.chi_square {
        return Ok(None);
    }
    identified.gain += identified.fitted.chi_square - fitted.chi_square;
    identified.fitted = fitted;
    identified.explain(&evidence, without)?;
    Ok(Some(evidence))
}

/// Returns what the logarithm of the likelihood (times -2) loses because the slip must lie within its standard deviation: of two
/// waves whose lines coincide, that of the higher harmonic of the ball pass fits a narrower range of slips (Laplace's approximation).
fn precision_of_slip(fault: AnyFault, fitted: &Fitted) -> f64 {
    let at = fault.shows_cage().and_then(|b| fitted.unknowns.iter().position(|u| *u == CAGE_SLIP.of_bearing(b)));
    let deviation = at.map(|i| fitted.covariance[(i, i)].sqrt()).filter(|deviation| *deviation > 0.0);
    deviation.map_or(0.0, |deviation| 2.0 * (USUAL_SLIP[1] / deviation).max(1.0).ln())
}

/// Removes the faults before the last one that explain nothing in addition to it: each was selected without the later faults.
fn pruned(of: &Prepared, faults: &mut Vec<IdentifiedFault>, mut now: Fitted) -> Result<Fitted> {
    let mut i = 0;
    while i + 1 < faults.len() {
        let fault = faults[i].fault;
        // No other fault has the lines of a surface.
        if fault.surface().is_some() {
            i += 1;
            continue;
        }
        let others = faults.iter().filter(|other| other.fault != fault);
        let of_cages = cage::unknowns(&of.observable, &now.machine);
        let unknowns = others.fold(of_cages, |all, other| union(all, &other.fitted.unknowns));
        let start = evaluate(&of.evidence, &fault.removed(&now.machine, &of.healthy.machine))?;
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

    /// What another cause leaves at lines that a fault hardly changes does not count against it, what is left at its own does.
    #[test]
    fn a_fault_is_compared_at_its_own_lines() {
        const VALUES: usize = 4;
        let line = |x: f64| [x; VALUES];
        let change = [line(10.0), line(10.0), line(0.5)].concat();
        let explained = |left: [f64; 3]| AtLines::new(&change, &left.map(line).concat(), VALUES);
        let noise = explained([1.0, 1.0, 1.0]);
        assert!((noise.explained - 1.0).abs() < 1e-9);
        // Two equal lines, and one of 1/400 of their square.
        assert!((noise.values - 2.0 * VALUES as f64).abs() < 0.1, "{}", noise.values);
        let beside = explained([1.0, 1.0, 300.0]);
        assert!(beside.explained > 0.998, "{}", beside.explained);
        // As much is left of the first line as the fault changes, less the noise.
        let own = explained([10.0, 1.0, 1.0]);
        assert!((own.explained - 0.75).abs() < 0.01, "{}", own.explained);
    }
}
