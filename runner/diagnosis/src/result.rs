//! Reported faults: kind, bearing, position, size, odds and a sentence.

use super::cage::unknowns;
use super::cause::Cause;
use super::fault_figures::fault_figures;
use super::fit::{Fitted, changed, fit};
use super::hypothesis::{Fault, MIN_GAIN, PROFILE_ERROR};
use super::machine::{Machine, Unknown, clearance, union};
use super::residual::{Evidence, dot};
use super::surface::Component;
use super::unexplained::unexplained_lines;
use super::{DiagnosisInput, Prepared, Result};
use ballrace_outcome::{
    CageOutcome, Diagnosis, DiagnosisOutcome, Estimate, EvidenceSource, FaultFigures, FaultForm, FaultKind,
    FaultParameters, UnexplainedLine,
};
use ballrace_scene::RotationSource;
use nalgebra::DVector;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Number of standard deviations within which a normally distributed error lies in 95 of 100 cases.
const WITHIN_95: f64 = 1.96;
/// Largest odds that are reported: beyond it, the model error dominates.
const LARGEST_ODDS: f64 = 1e12;
/// Least odds against another kind of fault, or another bearing, for one to be named: it is right in 19 of 20 cases.
const LEAST_ODDS: f64 = 19.0;
/// Mean square of the residual, in units of its noise, beyond which a recording is not explained.
const UNEXPLAINED: f64 = 9.0;
/// Relative error of chi-squared by the noise of the residual, which is itself estimated from simulated noise.
const NOISE_ERROR: f64 = 0.01;
/// Relative standard deviation of sizes by the model: Young's modulus of bearing steel, and with it every force, is not known better.
const STIFFNESS_ERROR: f64 = 0.005;
/// Search for the end of an interval: share of the error of the profile below which it is not made, factor of its steps, steps of the
/// fit of the other unknowns, and largest size over that of a parabola.
const SMALL: f64 = 0.4;
const WIDER: f64 = 1.6;
const REFITTED: usize = 3;
const FARTHEST: f64 = 10.0;

/// Result of a diagnosis.
#[derive(Debug, Clone)]
pub struct DiagnosisResult {
    /// Diagnoses, strongest first.
    pub diagnoses: Vec<Diagnosis>,
    /// Cages in the order of the bearings.
    pub cages: Vec<CageEstimate>,
    /// Chi-squared before and after, and the cages.
    pub outcome: DiagnosisOutcome,
    /// Notes for the user.
    pub notes: Vec<String>,
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
pub(super) fn diagnosis(material: &DiagnosisInput, of: &Prepared, faults: &[Fault]) -> Result<DiagnosisResult> {
    let before = of.healthy.chi_square / of.healthy.residual.len().max(1) as f64;
    let last = joint(of, faults)?;
    let e = &of.evidence;
    let after = last.chi_square / last.residual.len().max(1) as f64;
    // The model error may act along the unknowns: each unknown takes its share of the excess of chi-squared.
    let excess = (last.chi_square - (1.0 + NOISE_ERROR) * last.residual.len() as f64).max(0.0);
    let inflation = (1.0 + excess / last.unknowns.len().max(1) as f64).sqrt();
    let last = if faults.is_empty() { last } else { with_uncertain_parameters(e, last)? };
    let reported = Reported { e, last: &last, inflation };
    let mut diagnoses: Vec<Diagnosis> = vec![];
    for (i, fault) in faults.iter().enumerate() {
        // Faults are appended to those of the scene; waviness takes two entries.
        let earlier = faults[..i].iter().filter(|earlier| earlier.cause.shares_list(fault.cause)).count();
        let each = if matches!(fault.cause, Cause::Waviness(..)) { 2 } else { 1 };
        let at = fault.cause.next_index(&of.healthy.machine) + each * earlier;
        let figures = fault_figures(material, e, &of.healthy.machine, &last, (fault.cause, at))?;
        let diagnosis = reported.diagnosis(fault, at, i == 0).with_figures(figures);
        if i > 0 && !diagnosis.parameters.is_significant() {
            continue;
        }
        diagnoses.push(match fault.equally_likely() {
            Some(other) => undecided(diagnosis, fault.cause, other, e, &of.healthy),
            None => diagnosis,
        });
    }
    let strength = |diagnosis: &Diagnosis| diagnosis.parameters.log_likelihood_gain.unwrap_or(0.0);
    diagnoses.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    if after > UNEXPLAINED && faults.is_empty() {
        diagnoses.push(reported.unexplained(after));
    }
    let motion = &e.motion;
    let outcome = DiagnosisOutcome {
        samples: motion.len(),
        revolutions: (motion.turns[motion.len() - 1] - motion.turns[0]).abs(),
        chi_square_before: before,
        chi_square_after: after,
        cages: reported.cages(&of.observable),
    };
    let mut notes = vec![];
    let unseen: Vec<&str> = outcome.cages.iter().filter(|c| !c.observable).map(|c| c.bearing.as_str()).collect();
    if !unseen.is_empty() {
        notes.push(format!(
            "Cage angle and slip of {} are not observable in this recording: no figure depends on them.",
            unseen.join(" and ")
        ));
    }
    if after > 1.5 && !faults.is_empty() {
        notes.push(format!(
            "The motion that the diagnoses leave unexplained is {:.1} times its noise: the machine differs from its scene in further points.",
            after.sqrt()
        ));
    }
    let cages = cages(e, &last, &of.observable);
    Ok(DiagnosisResult { diagnoses, cages, outcome, notes })
}

impl Fault {
    /// Returns the odds against the second-best candidate; `None` without one.
    fn odds(&self) -> Option<f64> {
        self.next.map(|(_, odds)| odds.min(LARGEST_ODDS.ln()).exp())
    }

    /// Returns the second-best candidate if it is another kind of fault, or on another bearing, and the recording does not decide
    /// between the two.
    fn equally_likely(&self) -> Option<Cause> {
        let (next, _) = self.next?;
        let is_other = (next.kind(), next.bearing()) != (self.cause.kind(), self.cause.bearing());
        (is_other && self.odds()? < LEAST_ODDS).then_some(next)
    }
}

/// Returns the diagnosis that a recording does not decide between two causes, from that of the first: lines of two surfaces coincide
/// for different slips of the cage.
fn undecided(first: Diagnosis, cause: Cause, other: Cause, e: &Evidence, healthy: &Fitted) -> Diagnosis {
    let bearings: Vec<String> = e.plant.bearings.iter().map(|b| b.name.clone()).collect();
    let FaultParameters { log_likelihood_gain, odds_to_next, explained, .. } = first.parameters;
    Diagnosis {
        kind: FaultKind::Other,
        bearing: first.bearing.filter(|_| cause.bearing() == other.bearing()),
        sentence: format!(
            "Not decided: {} or {}, odds {:.1}. Either explains {:.0} % of the unexplained motion; a recording at another speed or load may decide.",
            cause.name(&bearings),
            other.name(&bearings),
            odds_to_next.unwrap_or(1.0),
            100.0 * explained.unwrap_or(0.0),
        ),
        lines: unexplained_lines(e, healthy),
        parameters: FaultParameters { log_likelihood_gain, odds_to_next, explained, ..FaultParameters::default() },
        figures: FaultFigures::default(),
        ..first
    }
}

impl Cause {
    /// Returns true where both are spalls, or both waves, of one bearing.
    fn shares_list(self, other: Self) -> bool {
        match (self, other) {
            (Self::Spall(a, _), Self::Spall(b, _)) | (Self::Waviness(a, ..), Self::Waviness(b, ..)) => a == b,
            _ => false,
        }
    }

    pub(super) fn bearing(self) -> Option<usize> {
        match self {
            Self::Unbalance | Self::Load => None,
            Self::Clearance(b) | Self::Misalignment(b) | Self::Spall(b, _) | Self::Waviness(b, ..) => Some(b),
        }
    }

    fn kind(self) -> FaultKind {
        match self {
            Self::Unbalance => FaultKind::Unbalance,
            Self::Load => FaultKind::Load,
            Self::Clearance(_) => FaultKind::Clearance,
            Self::Misalignment(_) => FaultKind::Misalignment,
            Self::Spall(_, component) | Self::Waviness(_, component, _) => match component {
                Component::Outer => FaultKind::OuterRace,
                Component::Inner => FaultKind::InnerRace,
                Component::Ball => FaultKind::Element,
            },
        }
    }

    fn name(self, bearings: &[String]) -> String {
        let of = |b: usize| &bearings[b];
        let surface = |component: Component| match component {
            Component::Outer => "outer race",
            Component::Inner => "inner race",
            Component::Ball => "a rolling element",
        };
        match self {
            Self::Unbalance => "unbalance".to_owned(),
            Self::Load => "another load".to_owned(),
            Self::Clearance(b) => format!("clearance of {}", of(b)),
            Self::Misalignment(b) => format!("misalignment of {}", of(b)),
            Self::Spall(b, component) => format!("a spall on {} of {}", surface(component), of(b)),
            Self::Waviness(b, Component::Ball, order) => {
                format!("waviness of order {order} of the rolling elements of {}", of(b))
            }
            Self::Waviness(b, component, order) => {
                format!("waviness of order {order} on {} of {}", surface(component), of(b))
            }
        }
    }
}

/// Adds the contribution of the uncertain parameters of the machine to the covariance of a fit.
///
/// With the slopes `J` of the unknowns and the change `v` of the residual by one deviation of a parameter, the unknowns change by
/// `-C J^T v`.
fn with_uncertain_parameters(e: &Evidence, mut last: Fitted) -> Result<Fitted> {
    let changes = e.uncertain_changes(&last.spectra, &last.machine)?;
    if changes.is_empty() || last.unknowns.is_empty() {
        return Ok(last);
    }
    let slopes = last.unknowns.iter().map(|u| e.slope(&last.spectra, &last.machine, *u)).collect::<Result<Vec<_>>>()?;
    let mut covariance = last.covariance.clone();
    for change in &changes {
        let along = DVector::from_iterator(slopes.len(), slopes.iter().map(|slope| dot(slope, change)));
        let moved = &last.covariance * along;
        covariance += &moved * moved.transpose();
    }
    last.covariance = covariance;
    Ok(last)
}

/// Fits the unknowns of all faults together.
fn joint(of: &Prepared, faults: &[Fault]) -> Result<Fitted> {
    let Some(last) = faults.last() else { return Ok(of.healthy.clone()) };
    let of_cages = unknowns(&of.observable, &last.fitted.machine);
    let all = faults.iter().fold(of_cages, |all, fault| union(all, &fault.fitted.unknowns));
    fit(&of.evidence, &last.fitted, &all, 30)
}

/// A fitted machine whose unknowns are reported.
struct Reported<'a, 'b> {
    e: &'a Evidence<'b>,
    last: &'a Fitted,
    /// Factor of deviations: residual over noise.
    inflation: f64,
}

impl Reported<'_, '_> {
    fn deviation(&self, unknown: Unknown) -> f64 {
        let at = self.last.unknowns.iter().position(|u| *u == unknown);
        let variance = at.map_or(0.0, |i| self.last.covariance.get((i, i)).copied().unwrap_or(0.0));
        self.inflation * variance.max(0.0).sqrt()
    }

    /// Returns the deviation of two unknowns along a direction.
    fn deviation_along(&self, unknowns: [Unknown; 2], direction: [f64; 2]) -> f64 {
        let at = |u: Unknown| self.last.unknowns.iter().position(|other| *other == u);
        let [Some(i), Some(j)] = unknowns.map(at) else { return 0.0 };
        let c = |i: usize, j: usize| self.last.covariance.get((i, j)).copied().unwrap_or(0.0);
        let [x, y] = direction;
        let variance = x * x * c(i, i) + 2.0 * x * y * c(i, j) + y * y * c(j, j);
        self.inflation * variance.max(0.0).sqrt()
    }

    /// Returns the decrease and the increase of an unknown at which chi-squared has risen as by [`WITHIN_95`] deviations, with the other
    /// unknowns fitted again. The rise is not a parabola where an element loses contact: more depth changes no force.
    fn reach(&self, unknown: Unknown) -> [f64; 2] {
        let linear = WITHIN_95 * self.deviation(unknown);
        if linear < SMALL * PROFILE_ERROR * unknown.get(&self.last.machine) {
            return [linear; 2];
        }
        let Some(i) = self.last.unknowns.iter().position(|u| *u == unknown) else { return [linear; 2] };
        let variance = self.last.covariance[(i, i)];
        if variance.is_nan() || variance <= 0.0 {
            return [linear; 2];
        }
        let allowed = WITHIN_95 * self.inflation;
        let is_other = |u: &Unknown| *u != unknown && u.part() == unknown.part();
        let others: Vec<Unknown> = self.last.unknowns.iter().copied().filter(is_other).collect();
        // Returns the machine with the unknown changed, from one with another change.
        let moved = |from: &Fitted, change: f64| {
            let mut machine = from.machine.clone();
            let step = unknown.get(&self.last.machine) + change - unknown.get(&from.machine);
            for (j, other) in self.last.unknowns.iter().enumerate() {
                other.set(&mut machine, other.get(&from.machine) + step * self.last.covariance[(i, j)] / variance);
            }
            changed(self.e, from, &machine).and_then(|moved| fit(self.e, &moved, &others, REFITTED)).ok()
        };
        let rise = |of: &Fitted| (of.chi_square - self.last.chi_square).max(0.0).sqrt();
        [-1.0, 1.0].map(|sign| {
            let (mut reach, most) = (linear, FARTHEST * linear);
            let (mut before, mut last) = ((linear, 0.0), Cow::Borrowed(self.last));
            while let Some(next) = moved(&last, sign * reach) {
                let rise = rise(&next);
                if rise > allowed {
                    let share = (allowed - before.1) / (rise - before.1);
                    return before.0 + share * (reach - before.0);
                }
                if reach >= most {
                    break;
                }
                before = (reach, rise);
                last = Cow::Owned(next);
                reach *= WIDER;
            }
            reach.min(most)
        })
    }

    fn estimate(&self, unknown: Unknown, unit: f64) -> Estimate {
        let value = unknown.get(&self.last.machine) / unit;
        if matches!(unknown, Unknown::SpallWidth(..) | Unknown::SpallDepth(..)) {
            let [down, up] = self.reach(unknown).map(|reach| (reach / unit).hypot(WITHIN_95 * PROFILE_ERROR * value));
            return Estimate { value, low: value - down, high: value + up };
        }
        let known = match unknown {
            Unknown::Clearance(_) => STIFFNESS_ERROR,
            _ => 0.0,
        };
        around(value, (self.deviation(unknown) / unit.abs()).hypot(known * value))
    }

    /// Angle on a component; on the inner race it is counted from the keyphasor mark.
    fn angle(&self, unknown: Unknown, component: Component) -> Estimate {
        let angle = self.estimate(unknown, TAU / 360.0);
        within_turn(if component == Component::Inner { self.with_pulse_error(angle) } else { angle })
    }

    /// Widens an angle from the keyphasor mark: its pulse is detected at the first sample after it, up to one sample late.
    fn with_pulse_error(&self, angle: Estimate) -> Estimate {
        let rotation = self.e.scene.recording.as_ref().map(|recording| &recording.rotation);
        if !matches!(rotation, Some(RotationSource::Keyphasor { .. })) {
            return angle;
        }
        let late = (self.e.motion.mean_speed() * self.e.motion.period).to_degrees() / 3.0_f64.sqrt();
        around(angle.value, ((angle.high - angle.value) / WITHIN_95).hypot(late))
    }

    /// Size and direction of a vector of two unknowns.
    fn vector(&self, [x, y]: [Unknown; 2], unit: f64) -> [Estimate; 2] {
        let (a, b) = (x.get(&self.last.machine), y.get(&self.last.machine));
        let size = a.hypot(b).max(1e-30);
        let (along, across) =
            (self.deviation_along([x, y], [a / size, b / size]), self.deviation_along([x, y], [-b / size, a / size]));
        let across = across / size;
        [
            not_negative(around(size / unit, (along / unit).hypot(STIFFNESS_ERROR * size / unit))),
            within_turn(around(b.atan2(a).to_degrees(), across.to_degrees())),
        ]
    }

    /// Slip from pure rolling, %.
    fn slip(&self, b: usize, cage: &CageEstimate) -> Estimate {
        let kinematics = &self.e.plant.bearings[b].kinematics;
        let share = kinematics.cage_ratio / kinematics.rolling_cage_ratio;
        let slip = 1.0 - cage.cage_ratio / kinematics.rolling_cage_ratio;
        around(100.0 * slip, 100.0 * share * self.deviation(Unknown::CageSlip(b)))
    }

    fn cages(&self, observable: &[bool]) -> Vec<CageOutcome> {
        let estimates = cages(self.e, self.last, observable);
        let outcome = |(b, cage): (usize, &CageEstimate)| {
            let azimuth = || {
                let deviation = 360.0 * self.deviation(Unknown::CagePhase(b));
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

    fn parameters(&self, cause: Cause, at: usize) -> FaultParameters {
        let machine: &Machine = &self.last.machine;
        match cause {
            Cause::Unbalance => {
                let [moment, angle] = self.vector([Unknown::Unbalance(0), Unknown::Unbalance(1)], 1e-6);
                let angle = self.with_pulse_error(angle);
                let [ex, ey, cx, cy] = machine.unbalance;
                let square = (ex * ex + ey * ey).max(1e-30);
                let station = (cx * ex + cy * ey) / square;
                let of_couple = self.deviation(Unknown::Unbalance(2)).max(self.deviation(Unknown::Unbalance(3)));
                let of_force = self.deviation(Unknown::Unbalance(0)).max(self.deviation(Unknown::Unbalance(1)));
                let deviation = of_couple.hypot(station * of_force) / square.sqrt();
                FaultParameters {
                    moment_g_mm: Some(moment),
                    angle_deg: Some(angle),
                    station_mm: Some(around(station * 1e3, deviation * 1e3)),
                    ..FaultParameters::default()
                }
            }
            Cause::Load => FaultParameters {
                load_n: Some([0, 1, 2].map(|i| self.estimate(Unknown::Load(i), 1.0))),
                ..FaultParameters::default()
            },
            Cause::Clearance(b) => FaultParameters {
                clearance_um: Some(self.estimate(Unknown::Clearance(b), 1e-6)),
                ..FaultParameters::default()
            },
            Cause::Misalignment(b) => {
                let [tilt, axis] = self.vector([Unknown::Tilt(b, 0), Unknown::Tilt(b, 1)], 1e-3);
                FaultParameters { tilt_mrad: Some(tilt), axis_deg: Some(axis), ..FaultParameters::default() }
            }
            Cause::Spall(b, component) => {
                let element = match machine.bearings[b].scene.defect.get(at).map(|d| d.surface) {
                    Some(ballrace_scene::Surface::Ball(j)) => Some(j + 1),
                    _ => None,
                };
                let on_race = component != Component::Ball;
                FaultParameters {
                    form: Some(FaultForm::Spall),
                    azimuth_deg: on_race.then(|| self.angle(Unknown::SpallAzimuth(b, at), component)),
                    element,
                    half_width_deg: Some(not_negative(self.estimate(Unknown::SpallWidth(b, at), TAU / 360.0))),
                    depth_um: Some(not_negative(self.estimate(Unknown::SpallDepth(b, at), 1e-6))),
                    ..FaultParameters::default()
                }
            }
            Cause::Waviness(b, component, order) => {
                // Waves of the elements are along their contacts.
                let is_of_race = component != Component::Ball;
                let evaluated = self.e.evaluated(machine, b).ok().filter(|_| is_of_race);
                let normal = evaluated.map_or(1.0, |bearing| bearing.contact_cosine(&self.e.motion));
                let unknowns = [Unknown::Wave(b, at), Unknown::Wave(b, at + 1)];
                let [amplitude, _] = self.vector(unknowns, 1e-6 / normal);
                FaultParameters {
                    form: Some(FaultForm::Waviness),
                    waviness_order: Some(order),
                    amplitude_um: Some(amplitude),
                    ..FaultParameters::default()
                }
            }
        }
    }

    /// Order of the lines of a cause; 0 where it changes the mean position.
    fn order(&self, cause: Cause) -> f64 {
        let cage = |b: usize| {
            let mounted = &self.e.plant.bearings[b];
            (mounted.elements as f64, mounted.kinematics.cage_ratio * (1.0 - self.last.machine.bearings[b].cage.slip))
        };
        match cause {
            Cause::Unbalance => 1.0,
            Cause::Load | Cause::Clearance(_) | Cause::Misalignment(_) => 0.0,
            Cause::Spall(b, component) | Cause::Waviness(b, component, _) => {
                let (n, ratio) = cage(b);
                match component {
                    Component::Outer => n * ratio,
                    Component::Inner => n * (1.0 - ratio),
                    Component::Ball => 2.0 * self.e.plant.bearings[b].kinematics.orders.ball_spin,
                }
            }
        }
    }

    fn diagnosis(&self, fault: &Fault, at: usize, is_first: bool) -> Diagnosis {
        let cause = fault.cause;
        let bearings: Vec<String> = self.e.plant.bearings.iter().map(|b| b.name.clone()).collect();
        let bearing = cause.bearing().map(|b| bearings[b].clone());
        let gain = 0.5 * fault.gain;
        let odds = fault.odds();
        let explained =
            fault.gain / (fault.gain + (fault.fitted.chi_square - fault.fitted.residual.len() as f64).max(0.0));
        let mut parameters = self.parameters(cause, at);
        parameters.log_likelihood_gain = Some(gain);
        parameters.odds_to_next = Some(odds.unwrap_or(LARGEST_ODDS));
        parameters.explained = Some(explained.clamp(0.0, 1.0));
        let order = self.order(cause);
        let next = fault.next.map_or(String::new(), |(next, _)| {
            format!(
                "; odds against {} {}",
                next.name(&bearings),
                odds.map_or(String::new(), |odds| if odds >= 1e6 {
                    "beyond 1e6".to_owned()
                } else {
                    format!("{odds:.0}")
                })
            )
        });
        let place = self.described(cause, &parameters, bearing.as_deref().unwrap_or_default());
        let sentence = format!(
            "{place}. It explains {:.0} % of {}{next}.",
            100.0 * explained.clamp(0.0, 1.0),
            if is_first { "the unexplained motion" } else { "what the other diagnoses leave" }
        );
        Diagnosis {
            kind: cause.kind(),
            bearing,
            line_hz: order * self.e.motion.mean_speed().abs() / TAU,
            order,
            level_db: 10.0 * (fault.gain / MIN_GAIN).log10(),
            confidence: explained.clamp(0.0, 1.0) * odds.map_or(1.0, |odds| odds / (1.0 + odds)),
            evidence: vec![EvidenceSource::ShaftMotion],
            vibration: None,
            parameters,
            sentence,
            lines: vec![],
            figures: FaultFigures::default(),
        }
    }

    /// Describes a fault with its place and size.
    fn described(&self, cause: Cause, p: &FaultParameters, bearing: &str) -> String {
        let value = |estimate: Option<Estimate>| estimate.map_or(0.0, |e| e.value);
        let scene = |b: usize| clearance(&self.e.scene.bearings[b]) * 1e6;
        match cause {
            Cause::Unbalance => format!(
                "Unbalance other than the scene's: {} g mm at {} deg from the keyphasor mark, station {:.1} mm",
                described_size(p.moment_g_mm, 1),
                described(p.angle_deg, 1),
                value(p.station_mm) + 1e3 * self.e.scene.drawn_station(0.0)
            ),
            Cause::Load => {
                let [x, y, z] = p.load_n.unwrap_or([Estimate { value: 0.0, low: 0.0, high: 0.0 }; 3]);
                format!(
                    "Load other than the scene's: {:.1}, {:.1}, {:.1} N along X, Y, Z besides the weight",
                    x.value, y.value, z.value
                )
            }
            Cause::Clearance(b) => {
                format!("Clearance of {bearing}: {} um instead of {:.1} um", described(p.clearance_um, 2), scene(b))
            }
            Cause::Misalignment(_) => format!(
                "Misalignment of {bearing}: its outer ring is tilted by {} mrad about an axis at {} deg from +X",
                described_size(p.tilt_mrad, 3),
                described(p.axis_deg, 0)
            ),
            Cause::Spall(_, component) => {
                let (surface, place) = match component {
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
                    "{surface} of {bearing}: a spall {place}, {depth}, half width {:.2} deg",
                    value(p.half_width_deg)
                )
            }
            Cause::Waviness(_, component, order) => {
                let surface = match component {
                    Component::Outer => "Outer race",
                    Component::Inner => "Inner race",
                    Component::Ball => "Rolling elements",
                };
                format!(
                    "{surface} of {bearing}: waviness of order {order}, amplitude {} um",
                    described_size(p.amplitude_um, 3)
                )
            }
        }
    }

    /// The diagnosis that no hypothesis explains the residual, with its strongest lines.
    fn unexplained(&self, after: f64) -> Diagnosis {
        let lines = unexplained_lines(self.e, self.last);
        let (line_hz, order) = lines.first().map_or((0.0, 0.0), |line| (line.line_hz, line.order));
        let list: Vec<String> = lines.iter().map(UnexplainedLine::to_string).collect();
        Diagnosis {
            kind: FaultKind::Other,
            bearing: None,
            line_hz,
            order,
            level_db: 10.0 * after.max(1.0).log10(),
            confidence: 0.5,
            evidence: vec![EvidenceSource::ShaftMotion],
            vibration: None,
            parameters: FaultParameters::default(),
            sentence: format!(
                "Unexplained: the residual is {:.1} times its noise, and no fault of a bearing or the rotor explains it. Strongest lines, per turn of the shaft: {}.",
                after.sqrt(),
                list.join(", ")
            ),
            lines,
            figures: FaultFigures::default(),
        }
    }
}

/// Returns the estimate of a size, whose interval has no negative part.
fn not_negative(e: Estimate) -> Estimate {
    Estimate { low: e.low.max(0.0), ..e }
}

/// Describes an estimate by its value and interval.
fn described(estimate: Option<Estimate>, digits: usize) -> String {
    estimate.map_or(String::new(), |e| format!("{:.digits$} ({:.digits$} to {:.digits$})", e.value, e.low, e.high))
}

/// Describes a size that is not negative; by its interval alone if that includes 0.
fn described_size(estimate: Option<Estimate>, digits: usize) -> String {
    match estimate {
        Some(e) if e.low <= 0.0 => format!("between 0 and {:.digits$}", e.high),
        _ => described(estimate, digits),
    }
}

/// Returns an estimate from its standard deviation.
fn around(value: f64, deviation: f64) -> Estimate {
    let half = WITHIN_95 * deviation;
    Estimate { value, low: value - half, high: value + half }
}

/// Returns an angle with its value between 0 and 360 degrees.
fn within_turn(e: Estimate) -> Estimate {
    let shift = e.value.rem_euclid(360.0) - e.value;
    Estimate { value: e.value + shift, low: e.low + shift, high: e.high + shift }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_no_negative_part() {
        let unclear = not_negative(around(3.93, 46.4));
        assert_eq!((unclear.low, unclear.value), (0.0, 3.93));
        assert_eq!(described_size(Some(unclear), 1), "between 0 and 94.9");
        assert_eq!(described_size(Some(not_negative(around(3.0, 0.1))), 2), "3.00 (2.80 to 3.20)");
    }

    #[test]
    fn an_angle_or_a_preload_may_be_zero_or_less() {
        assert_eq!(described(Some(around(0.0, 0.0)), 1), "0.0 (0.0 to 0.0)");
        assert_eq!(described(Some(around(-2.0, 1.0)), 1), "-2.0 (-4.0 to -0.0)");
    }
}
