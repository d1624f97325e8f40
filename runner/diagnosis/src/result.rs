//! Reported faults: kind, bearing, position, size, odds and a sentence.

use super::cage::unknowns;
use super::estimates::{Estimates, around, with_uncertain_parameters};
use super::fault_figures::Contrast;
use super::faults::AnyFault;
use super::fit::{Fitted, evaluate, fit_beside};
use super::hypothesis::{IdentifiedFault, MIN_GAIN};
use super::machine::Machine;
use super::means::fit_with_means;
use super::parameter::{CAGE_PHASE, CAGE_SLIP, Unknown, union};
use super::residual::Evidence;
use super::residual::site::{self, DEPENDENT};
use super::site::{RESOLUTION, SiteRecording};
use super::unexplained::unexplained_lines;
use super::vibration::rotor::GROWTH_DB;
use super::{DiagnosisInput, Prepared, Result};
use ballrace_outcome::{
    CageOutcome, Diagnosis, DiagnosisOutcome, Estimate, EvidenceSource, FailureMode, FaultFigures, FaultForm,
    FaultKind, FaultParameters, ProbeReadings, UnexplainedLine,
};
use std::borrow::Cow;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Largest odds that are reported: beyond it, the model error dominates.
const LARGEST_ODDS: f64 = 1e12;
/// Least share that a fault explains of the motion at its lines, by which its size is estimated.
const LEAST_EXPLAINED: f64 = 0.1;
/// Fits for the sizes of spalls, each in the weights of the machine before.
const ROUNDS: usize = 2;
/// Confidence of a diagnosis that names no cause.
const UNDECIDED: f64 = 0.5;
/// Least odds against another kind of fault, or another bearing, for one to be named: it is right in 19 of 20 cases.
const LEAST_ODDS: f64 = 19.0;
/// Mean square of the residual, in units of its noise, beyond which a recording is not explained.
const UNEXPLAINED: f64 = 9.0;
/// The same up to which it is: what the model of a bearing leaves of the motion of another one.
const EXPLAINED: f64 = 1.5;
/// Share of the unexplained motion from which a fault of a site is named without "possibly", and one that moves the shaft.
const DECIDED: [f64; 2] = [0.6, 0.8];
/// The same from which a fault is named that no other one explains.
const ALONE: f64 = 0.4;
/// Share of the square of the unexplained motion at a probe that a fault which moves the shaft of a site explains at least.
const PROVEN: f64 = 0.5;
/// Relative error of chi-squared by the noise of the residual, which is itself estimated from simulated noise.
const NOISE_ERROR: f64 = 0.01;

/// Result of a diagnosis.
#[derive(Debug, Clone)]
pub struct DiagnosisResult {
    /// Diagnoses, strongest first.
    pub diagnoses: Vec<Diagnosis>,
    /// Cages in the order of the bearings.
    pub cages: Vec<CageEstimate>,
    /// Chi-squared before and after, and the cages.
    pub outcome: DiagnosisOutcome,
    /// Plausible errors of the readings with those of the baseline; nothing where the readings are the motion of the shaft alone.
    pub readings: Vec<ProbeReadings>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl DiagnosisResult {
    /// Returns true where the machine with these faults explains the recording but for the noise of the probes.
    pub(super) fn explains(&self) -> bool {
        self.outcome.chi_square_after < EXPLAINED
    }

    /// Returns true where the strongest diagnosis names a fault that explains too little of the unexplained motion, or beside which more is left
    /// than the error of a model.
    pub(super) fn accuses_without_proof(&self) -> bool {
        let Some(first) = self.diagnoses.first().filter(|first| first.kind != FaultKind::Other) else { return false };
        let FaultParameters { explained, unexplained_motion, .. } = &first.parameters;
        let is_proven = unexplained_motion.as_ref().is_some_and(|motion| motion.explained > PROVEN);
        !is_proven || explained.unwrap_or(0.0) < DECIDED[0] || self.outcome.chi_square_after > UNEXPLAINED
    }
}

/// Angle and speed of one cage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CageEstimate {
    /// Cage speed over shaft speed in the middle of the record.
    pub cage_ratio: f64,
    /// Azimuth of the first element at shaft angle 0, rad, by the cage speed in the middle of the record.
    pub first_element_azimuth: f64,
    /// True if the passing of the elements is observable.
    pub observable: bool,
    /// Change of the cage speed, revolutions per square of a shaft revolution.
    drift: f64,
    /// Total revolutions in the middle of the record.
    middle: f64,
}

impl CageEstimate {
    /// Returns the cage ratio and the azimuth of the first element at shaft angle 0 (rad) of a cage with a constant ratio that has the
    /// speed and the angle of this cage at `turns`, the total revolutions of the shaft.
    #[must_use]
    pub fn tangent(&self, turns: f64) -> (f64, f64) {
        let from_middle = turns - self.middle;
        let faster = self.drift * from_middle;
        let ahead = 0.5 * faster * from_middle - faster * turns;
        (self.cage_ratio + faster, self.first_element_azimuth + TAU * ahead)
    }
}

/// Returns the cages of a fitted machine.
pub(super) fn cages(e: &Evidence, of: &Fitted, observable: &[bool]) -> Vec<CageEstimate> {
    let estimate = |(i, bearing): (usize, &super::machine::MachineBearing)| {
        let mounted = &e.plant.bearings[i];
        let pitch = TAU / mounted.elements as f64;
        let azimuth = bearing.scene.first_element_azimuth + TAU * bearing.cage.phase;
        CageEstimate {
            cage_ratio: mounted.kinematics.cage_ratio * (1.0 - bearing.cage.slip),
            first_element_azimuth: azimuth.rem_euclid(pitch),
            observable: observable[i],
            drift: bearing.cage.drift,
            middle: e.motion.middle,
        }
    };
    of.machine.bearings.iter().enumerate().map(estimate).collect()
}

/// Returns the result of a diagnosis with its figures and notes.
pub(super) fn diagnosis(input: &DiagnosisInput, of: &Prepared, faults: &[IdentifiedFault]) -> Result<DiagnosisResult> {
    let before = of.healthy.chi_square / of.healthy.residual.len().max(1) as f64;
    let Joint { evidence, fitted: last, of_means } = joint(of, faults)?;
    let e = &*evidence;
    let after = last.chi_square / last.residual.len().max(1) as f64;
    // The model error may act along the unknowns: each unknown takes its share of the excess of chi-squared.
    let excess = (last.chi_square - (1.0 + NOISE_ERROR) * last.residual.len() as f64).max(0.0);
    let dependent = if e.site.is_some() { DEPENDENT } else { 1.0 };
    let inflation = (1.0 + excess / (dependent * last.unknowns.len().max(1) as f64)).sqrt();
    let last = if faults.is_empty() { last } else { with_uncertain_parameters(e, last, &of_means)? };
    let estimates = Estimates { e, last: &last, inflation, error_at_lines: 0.0 };
    let mut diagnoses: Vec<Diagnosis> = vec![];
    for (i, identified) in faults.iter().enumerate() {
        let fault = identified.fault;
        // Beside the faults that were found after it, no more of it may be left than a sound machine has.
        if e.site.is_some() && faults.len() > 1 && !fault.exceeds_tolerance(e, &of.healthy, &last) {
            continue;
        }
        let lacking = fault.removed(&last.machine, &of.healthy.machine);
        let contrast = Contrast::new(input, e, &last, &lacking, fault.surface(), fault.bearing())?;
        // A wave has one line, so that no fit shows the error of the model there: half of its square is in phase with the wave.
        let is_wave = e.site.is_some() && matches!(fault, AnyFault::Waviness(_));
        let error_at_lines = if is_wave { identified.error_at_lines() * FRAC_1_SQRT_2 } else { 0.0 };
        let estimates = Estimates { error_at_lines, ..estimates };
        let diagnosis = estimates.diagnosis(identified, i == 0).with_figures(fault.figures(&contrast));
        if i > 0 && !diagnosis.parameters.is_significant() {
            continue;
        }
        if e.site.is_some() && fault.surface().is_some() && diagnoses.iter().any(|known| coincide(e, known, &diagnosis))
        {
            continue;
        }
        let explained = diagnosis.parameters.explained.unwrap_or(0.0);
        // At a site an interval of the size that contains zero is no fault, nor is what the motion at no probe proves.
        let is_sized = e.site.is_none() || diagnosis.parameters.is_significant() && is_proven(&diagnosis, fault);
        diagnoses.push(match identified.equally_likely() {
            _ if !is_sized => {
                // Depth and width of a spall are determined less than their product. Without a baseline, what a worn bearing does looks like one.
                let is_spall = diagnosis.parameters.form == Some(FaultForm::Spall) && !e.is_without_baseline();
                possible(diagnosis, is_spall && identified.is_alone(explained), e, &of.healthy)
            }
            Some(other) => undecided(diagnosis, fault, other, e, &of.healthy),
            None if e.site.is_some() && explained < DECIDED[usize::from(fault.moves_shaft())] => {
                possible(diagnosis, identified.is_alone(explained), e, &of.healthy)
            }
            None => diagnosis,
        });
    }
    let strength = |diagnosis: &Diagnosis| diagnosis.parameters.log_likelihood_gain.unwrap_or(0.0);
    diagnoses.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let most = if e.site.is_some() { site::UNEXPLAINED } else { UNEXPLAINED };
    if faults.is_empty() && after > most {
        diagnoses.push(estimates.unexplained(after));
    } else if faults.is_empty()
        && let Some((site, plain)) = of.site.as_ref().zip(Machine::new(input.scene))
    {
        // A wave that a sound bearing may have moves the shaft too. The last one is removed first: each has its place behind those before it.
        let deviations = of.deviations.iter().rev();
        let without = deviations.fold(of.healthy.machine.clone(), |all, one| one.removed(&all, &plain));
        let without = evaluate(&of.evidence, &without)?;
        let growth = site.growth(&of.evidence.motion_rms([&of.healthy.spectra, &without.spectra]));
        if let Some((p, times)) = largest(&growth)
            && 20.0 * times.log10() > GROWTH_DB
        {
            diagnoses.push(estimates.grown(&input.probes[p].column, times));
        }
    }
    let motion = &e.motion;
    // What a fault does was in the errors of the readings.
    let mut site = of.site.clone();
    if let Some(site) = site.as_mut().filter(|_| !faults.is_empty()) {
        site.evidence(&last.machine)?;
    }
    let outcome = DiagnosisOutcome {
        samples: motion.len(),
        revolutions: (motion.turns[motion.len() - 1] - motion.turns[0]).abs(),
        chi_square_before: before,
        chi_square_after: after,
        cages: estimates.cages(&of.observable),
        readings: site.as_ref().map(SiteRecording::outcomes).unwrap_or_default(),
        is_without_baseline: e.is_without_baseline(),
    };
    let mut notes = vec![];
    let unseen: Vec<&str> = outcome.cages.iter().filter(|c| !c.observable).map(|c| c.bearing.as_str()).collect();
    if !unseen.is_empty() {
        notes.push(format!(
            "Cage angle and slip of {} are not observable in this recording: no figure depends on them.",
            unseen.join(" and ")
        ));
    }
    if !of.deviations.is_empty() {
        let names: Vec<String> = of.deviations.iter().map(|fault| fault.name(e.plant)).collect();
        notes.push(format!(
            "Below the least size of a fault at a site, and taken for part of the sound machine: {}.",
            names.join(", ")
        ));
    }
    if after > 1.5 && !faults.is_empty() {
        notes.push(format!(
            "The motion that the diagnoses leave unexplained is {:.1} times its noise: the machine differs from its scene in further points.",
            after.sqrt()
        ));
    }
    let cages = cages(e, &last, &of.observable);
    let readings = site.map(|site| site.plausible_readings()).unwrap_or_default();
    Ok(DiagnosisResult { diagnoses, cages, outcome, readings, notes })
}

impl IdentifiedFault {
    /// Returns the error of the model at the lines of a fault of a surface, over the motion that it explains there: as large as what it leaves.
    fn error_at_lines(&self) -> f64 {
        (1.0 / self.explained.max(LEAST_EXPLAINED) - 1.0).sqrt()
    }

    /// Returns the odds against the second-best candidate; `None` without one.
    fn odds(&self) -> Option<f64> {
        self.next.map(|(_, odds)| odds.min(LARGEST_ODDS.ln()).exp())
    }

    /// Returns true for a fault that nothing else explains, and for an error of a reading, which accuses nothing.
    fn is_alone(&self, explained: f64) -> bool {
        self.fault.is_of_measurement() || explained > ALONE && self.rival > LEAST_ODDS.ln()
    }

    /// Returns the second-best candidate if it is another kind of fault, or on another bearing, and the recording does not decide
    /// between the two.
    fn equally_likely(&self) -> Option<AnyFault> {
        let (next, _) = self.next?;
        let is_other = (next.kind(), next.bearing()) != (self.fault.kind(), self.fault.bearing());
        (is_other && self.odds()? < LEAST_ODDS).then_some(next)
    }
}

/// Returns the largest of some values and its place.
fn largest(values: &[f64]) -> Option<(usize, f64)> {
    values.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns true where the record does not tell the lines of two faults of a site apart: an error of the model at the lines of the first is no
/// second fault.
fn coincide(e: &Evidence, a: &Diagnosis, b: &Diagnosis) -> bool {
    let turns = (e.motion.turns[e.motion.len() - 1] - e.motion.turns[0]).abs();
    a.order > 0.0 && (a.order - b.order).abs() * turns < RESOLUTION
}

/// Returns true for a fault that does not move the shaft, or lowers the square of the unexplained motion at a probe by more than half.
fn is_proven(diagnosis: &Diagnosis, fault: AnyFault) -> bool {
    let motion = &diagnosis.parameters.unexplained_motion;
    !fault.moves_shaft() || motion.as_ref().is_some_and(|motion| motion.explained > PROVEN)
}

/// Returns the diagnosis that a fault is possible, from that of the fault: too much of the motion is left. A fault that is `alone` keeps its
/// cause, place and size.
fn possible(first: Diagnosis, alone: bool, e: &Evidence, healthy: &Fitted) -> Diagnosis {
    let sentence = format!(
        "Possibly: {} Most likely, but not decided: a recording at another speed or load, or a vibration sensor at the bearings may decide.",
        first.sentence
    );
    let first = Diagnosis { sentence, ..first };
    if alone {
        return first;
    }
    let FaultParameters { log_likelihood_gain, odds_to_next, explained, .. } = first.parameters;
    Diagnosis {
        kind: FaultKind::Other,
        bearing: None,
        failure_modes: vec![],
        lines: unexplained_lines(e, healthy),
        parameters: FaultParameters { log_likelihood_gain, odds_to_next, explained, ..FaultParameters::default() },
        figures: FaultFigures::default(),
        confidence: UNDECIDED,
        ..first
    }
}

/// Returns the diagnosis that a recording does not decide between two faults, from that of the first: lines of two surfaces coincide
/// for different slips of the cage.
fn undecided(first: Diagnosis, fault: AnyFault, other: AnyFault, e: &Evidence, healthy: &Fitted) -> Diagnosis {
    let FaultParameters { log_likelihood_gain, odds_to_next, explained, .. } = first.parameters;
    Diagnosis {
        kind: FaultKind::Other,
        bearing: first.bearing.filter(|_| fault.bearing() == other.bearing()),
        failure_modes: vec![],
        sentence: format!(
            "Not decided: {} or {}, odds {:.1}. Either explains {:.0} % of the unexplained motion; a recording at another speed or load may decide.",
            fault.name(e.plant),
            other.name(e.plant),
            odds_to_next.unwrap_or(1.0),
            100.0 * explained.unwrap_or(0.0),
        ),
        lines: unexplained_lines(e, healthy),
        parameters: FaultParameters { log_likelihood_gain, odds_to_next, explained, ..FaultParameters::default() },
        figures: FaultFigures::default(),
        confidence: UNDECIDED,
        ..first
    }
}

/// Faults fitted together.
struct Joint<'a, 'b> {
    /// The recording in the weights of the fit.
    evidence: Cow<'b, Evidence<'a>>,
    fitted: Fitted,
    /// Unknowns of a site that were fitted to means as well as to lines.
    of_means: Vec<Unknown>,
}

/// Fits the unknowns of all faults together.
///
/// Of a site, those that move the rotor are fitted to means as well. A spall has many lines there: it is fitted again where each counts by the error of the
/// model there, which is as large as what the faults leave.
fn joint<'a, 'b>(of: &'b Prepared<'a>, faults: &[IdentifiedFault]) -> Result<Joint<'a, 'b>> {
    let mut evidence = Cow::Borrowed(&of.evidence);
    let Some(last) = faults.last() else {
        return Ok(Joint { evidence, fitted: of.healthy.clone(), of_means: vec![] });
    };
    let mut fitted = last.fitted.clone();
    let of_cages = unknowns(&of.observable, &fitted.machine);
    let mut of_lines = faults.iter().fold(of_cages, |all, fault| union(all, &fault.fitted.unknowns));
    let moving = faults.iter().filter(|one| of.site.is_some() && one.fault.moves_shaft());
    let mut of_means = moving.fold(vec![], |all, one| union(all, &one.fitted.unknowns));
    of_means.retain(|unknown| !unknown.is_of_cage());
    of_lines.retain(|unknown| !of_means.contains(unknown));
    if of_means.is_empty() {
        fitted.unknowns.clear();
    } else {
        let (own, with_means) = fit_with_means(of, &fitted.machine, &of_means, f64::INFINITY)?;
        evidence = Cow::Owned(own);
        // Of independent values.
        fitted = Fitted { covariance: &with_means.covariance * DEPENDENT, ..with_means };
    }
    fitted = fit_beside(&evidence, &fitted, &of_lines, 30)?;
    let is_spall = |one: &&IdentifiedFault| of.site.is_some() && matches!(one.fault, AnyFault::Spall(_));
    let error = faults.iter().filter(is_spall).map(IdentifiedFault::error_at_lines).reduce(f64::max);
    for error in std::iter::repeat_n(error, ROUNDS).flatten() {
        evidence.to_mut().weight_for_sizes(&fitted.machine, error)?;
        let start = evaluate(&evidence, &fitted.machine)?;
        let start = Fitted { unknowns: fitted.unknowns, covariance: fitted.covariance, ..start };
        fitted = fit_beside(&evidence, &start, &of_lines, 30)?;
    }
    Ok(Joint { evidence, fitted, of_means })
}

impl Estimates<'_, '_> {
    /// Slip from pure rolling, %.
    fn slip(&self, b: usize, cage: &CageEstimate) -> Estimate {
        let kinematics = &self.e.plant.bearings[b].kinematics;
        let share = kinematics.cage_ratio / kinematics.rolling_cage_ratio;
        let slip = 1.0 - cage.cage_ratio / kinematics.rolling_cage_ratio;
        around(100.0 * slip, 100.0 * share * self.deviation(CAGE_SLIP.of_bearing(b)))
    }

    fn cages(&self, observable: &[bool]) -> Vec<CageOutcome> {
        let estimates = cages(self.e, self.last, observable);
        let outcome = |(b, cage): (usize, &CageEstimate)| {
            let azimuth = || {
                let deviation = 360.0 * self.deviation(CAGE_PHASE.of_bearing(b));
                around(cage.first_element_azimuth.to_degrees(), deviation)
            };
            CageOutcome {
                bearing: self.e.plant.bearings[b].name.clone(),
                observable: cage.observable,
                slip_percent: cage.observable.then(|| self.slip(b, cage)),
                followed_slip_percent: None,
                cage_ratio: cage.cage_ratio,
                first_element_azimuth_deg: cage.observable.then(azimuth),
            }
        };
        estimates.iter().enumerate().map(outcome).collect()
    }

    fn diagnosis(&self, identified: &IdentifiedFault, is_first: bool) -> Diagnosis {
        let IdentifiedFault { fault, gain, explained, .. } = identified;
        let bearing = fault.bearing().map(|b| self.e.plant.bearings[b].name.clone());
        let odds = identified.odds();
        let mut parameters = fault.parameters(self);
        parameters.log_likelihood_gain = Some(0.5 * gain);
        parameters.odds_to_next = Some(odds.unwrap_or(LARGEST_ODDS));
        parameters.explained = Some(*explained);
        let order = fault.order(self);
        let next = identified.next.map_or(String::new(), |(next, _)| {
            format!(
                "; odds against {} {}",
                next.name(self.e.plant),
                odds.map_or(String::new(), |odds| if odds >= 1e6 {
                    "beyond 1e6".to_owned()
                } else {
                    format!("{odds:.0}")
                })
            )
        });
        let place = fault.sentence(self, &parameters);
        let sentence = format!(
            "{place}. It explains {:.0} % of {}{}{next}.",
            100.0 * explained,
            if is_first { "the unexplained motion" } else { "what the other diagnoses leave" },
            if self.e.site.is_some() && fault.surface().is_some() { " at its lines" } else { "" },
        );
        Diagnosis {
            kind: fault.kind(),
            bearing,
            failure_modes: FailureMode::of(fault.kind(), parameters.form).to_vec(),
            line_hz: order * self.e.motion.mean_speed().abs() / TAU,
            order,
            level_db: 10.0 * (gain / MIN_GAIN).log10(),
            confidence: explained * odds.map_or(1.0, |odds| odds / (1.0 + odds)),
            evidence: vec![EvidenceSource::ShaftMotion],
            vibration: None,
            parameters,
            sentence,
            lines: vec![],
            figures: FaultFigures::default(),
        }
    }

    /// The diagnosis that no hypothesis explains the residual, with its strongest lines.
    fn unexplained(&self, after: f64) -> Diagnosis {
        let sentence = |list: &str| {
            format!(
                "Unexplained: the residual is {:.1} times its noise, and no fault of a bearing or the rotor explains it. Strongest lines, per turn of the shaft: {list}.",
                after.sqrt()
            )
        };
        self.other(10.0 * after.max(1.0).log10(), &sentence)
    }

    /// The diagnosis that the motion at a probe is so many times that of the baseline, where the errors that the model may have hide the cause.
    fn grown(&self, probe: &str, times: f64) -> Diagnosis {
        let sentence = |list: &str| {
            format!(
                "Not decided: the motion at {probe} is {times:.1} times that of the baseline, and errors that the model of the machine may have, near a \
                 natural frequency, hide the cause. Strongest lines of what is left, per turn of the shaft: {list}. A recording at another speed or load may \
                 decide."
            )
        };
        self.other(20.0 * times.log10(), &sentence)
    }

    /// The diagnosis of no cause, with the sentence on its strongest lines.
    fn other(&self, level_db: f64, sentence: &dyn Fn(&str) -> String) -> Diagnosis {
        let lines = unexplained_lines(self.e, self.last);
        let (line_hz, order) = lines.first().map_or((0.0, 0.0), |line| (line.line_hz, line.order));
        let list: Vec<String> = lines.iter().map(UnexplainedLine::to_string).collect();
        Diagnosis {
            kind: FaultKind::Other,
            bearing: None,
            failure_modes: vec![],
            line_hz,
            order,
            level_db,
            confidence: UNDECIDED,
            evidence: vec![EvidenceSource::ShaftMotion],
            vibration: None,
            parameters: FaultParameters::default(),
            sentence: sentence(&list.join(", ")),
            lines,
            figures: FaultFigures::default(),
        }
    }
}
