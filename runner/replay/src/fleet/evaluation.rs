//! Evaluation of one machine by one recording.

use super::machine::Machine;
use super::row::{DiagnosisRow, IndicatorValue, Row, State};
use crate::{Options, Progress, open, replay};
use ballrace_base::caught::caught;
use ballrace_base::parallel;
use ballrace_base::printable;
use ballrace_outcome::{Diagnosis, FaultKind, LimitLine, Outcome, ProbeOutcome};
use ballrace_plant::error::{Error, Result, with_causes};
use ballrace_scene::Indicator;
use std::time::Duration;

/// Result of an evaluation.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Row of the table of outcomes.
    pub row: Row,
    /// Outcome with the data of a report; `None` if the row has an error.
    pub outcome: Option<Outcome>,
}

/// Replays the recording of a machine; an error or a panic becomes the error of the row.
///
/// It uses one thread and no state of the process, so that several threads or processes can evaluate at the same time.
#[must_use]
pub fn evaluate(machine: &Machine) -> Evaluation {
    evaluate_with(machine, None)
}

/// Returns the row of a machine whose evaluation ended without a result, such as by the end of its process.
#[must_use]
pub fn failed(machine: &Machine, error: String) -> Row {
    Row { error: Some(printable::message(&error)), ..empty(machine) }
}

/// Returns the evaluation of a machine whose files do not answer: nothing of it is read here.
pub(super) fn without_answer(machine: &Machine, patience: Duration) -> Evaluation {
    let error = format!(
        "no progress for {} s: a file, or the disk or network under it, does not answer; expected files that can be read, \
         or a longer --time-limit",
        patience.as_secs_f64()
    );
    Evaluation { row: Row { error: Some(printable::message(&error)), ..blank(machine, String::new()) }, outcome: None }
}

/// Returns the row of a machine before its evaluation.
fn empty(machine: &Machine) -> Row {
    // Computed before the files are read, so that the next run evaluates a file again that changes meanwhile.
    blank(machine, machine.fingerprint())
}

fn blank(machine: &Machine, inputs: String) -> Row {
    Row {
        machine: machine.name.clone(),
        recording: machine.recording_name.clone(),
        time: machine.time,
        state: State::Error,
        verdict: String::new(),
        diagnoses: vec![],
        indicators: vec![],
        tags: machine.tags.clone(),
        error: None,
        duration_s: None,
        mean_speed_rpm: None,
        inputs,
    }
}

/// Evaluates a machine as [`evaluate`] does, with a tolerated error of the force, as [`Options::error`].
#[must_use]
pub fn evaluate_with(machine: &Machine, force_error: Option<f64>) -> Evaluation {
    evaluate_watched(machine, force_error, &|_| {})
}

/// Evaluates a machine as [`evaluate_with`] does, with calls of `progress`.
pub(super) fn evaluate_watched(
    machine: &Machine,
    force_error: Option<f64>,
    progress: &(dyn Fn(Progress) + Sync),
) -> Evaluation {
    let mut row = empty(machine);
    // Other machines have the other processors.
    let outcome = match caught(|| parallel::on_this_thread(|| outcome(machine, force_error, progress))) {
        Ok(Ok(outcome)) => outcome,
        Ok(Err(error)) => {
            row.state = if error.is_implausible() { State::Implausible } else { State::Error };
            row.error = Some(printable::message(&with_causes(&error)));
            return Evaluation { row, outcome: None };
        }
        Err(panic) => {
            row.error = Some(printable::message(&format!("internal error: {panic}")));
            return Evaluation { row, outcome: None };
        }
    };
    row.state = state(&outcome);
    row.verdict.clone_from(&outcome.verdict);
    row.diagnoses = outcome.diagnoses.iter().map(diagnosis).collect();
    row.indicators = indicators(&outcome);
    row.duration_s = finite(outcome.record.duration_s);
    row.mean_speed_rpm = finite(outcome.record.mean_speed_rpm);
    Evaluation { row, outcome: Some(outcome) }
}

fn outcome(machine: &Machine, error: Option<f64>, progress: &(dyn Fn(Progress) + Sync)) -> Result<Outcome> {
    let scene = machine.read_scene()?;
    let (reader, path) = open(&scene, machine.recording.as_deref())?;
    let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
    let baseline = machine.baseline.as_deref();
    let options = Options { error, baseline, progress: Some(progress), ..Options::default() };
    replay(&scene, reader, &name, &options).map_err(|error| located(error, &scene.path))
}

/// Adds the file of the scene to an error that does not name it.
fn located(error: Error, scene: &std::path::Path) -> Error {
    match error {
        Error::Setup(_) | Error::Plant(_) | Error::Limit(_) => Error::in_file(scene)(error),
        other => other,
    }
}

fn state(outcome: &Outcome) -> State {
    if !outcome.implausible.is_empty() {
        State::Implausible
    } else if !outcome.events.is_empty() {
        State::Limit
    } else if !outcome.not_judged.is_empty() {
        State::NotJudged
    } else if outcome.diagnoses.iter().any(Diagnosis::is_of_machine) {
        State::Fault
    } else {
        State::Normal
    }
}

/// Rounds to nine digits, which JSON and CSV return exactly; `None` if the number is not finite.
fn finite(value: f64) -> Option<f64> {
    let rounded = || format!("{value:.8e}").parse().ok();
    if value.is_finite() { rounded() } else { None }
}

fn diagnosis(diagnosis: &Diagnosis) -> DiagnosisRow {
    let size = diagnosis.parameters.size();
    DiagnosisRow {
        fault: diagnosis.kind,
        form: diagnosis.parameters.form,
        bearing: diagnosis.bearing.clone(),
        size: size.and_then(|(size, _)| finite(size.value)),
        size_low: size.and_then(|(size, _)| finite(size.low)),
        size_high: size.and_then(|(size, _)| finite(size.high)),
        size_unit: size.map_or("", |(_, unit)| unit).to_owned(),
        level_db: finite(diagnosis.level_db).unwrap_or(0.0),
        confidence: finite(diagnosis.confidence).unwrap_or(0.0),
        sentence: diagnosis.sentence.clone(),
    }
}

/// Returns the indicators of the probes or sensors; those with a limit come first.
fn indicators(outcome: &Outcome) -> Vec<IndicatorValue> {
    let mut all: Vec<IndicatorValue> = Vec::new();
    for line in &outcome.pictures.limits {
        let same = |one: &&mut IndicatorValue| {
            one.name == line.indicator && one.probe.as_ref() == Some(&line.probe) && one.bearing == line.bearing
        };
        match (all.iter_mut().find(same), limited(outcome, line)) {
            (Some(known), Some(new)) => known.limit = known.limit.into_iter().chain(new.limit).reduce(f64::min),
            (None, Some(new)) => all.push(new),
            (_, None) => {}
        }
    }
    for probe in &outcome.probes {
        for (indicator, value) in ProbeOutcome::INDICATORS {
            let (name, (unit, _)) = (indicator.name(), indicator.unit());
            let is_known = all.iter().any(|one| one.name == name && one.probe.as_ref() == Some(&probe.name));
            if let (false, Some(value)) = (is_known, finite(value(probe))) {
                let (name, unit, probe) = (name.to_owned(), unit.to_owned(), Some(probe.name.clone()));
                all.push(IndicatorValue { name, unit, probe, bearing: None, value, limit: None, crossed: false });
            }
        }
    }
    all.extend(modulations(outcome));
    all
}

fn limited(outcome: &Outcome, line: &LimitLine) -> Option<IndicatorValue> {
    let probe = outcome.probes.iter().find(|probe| probe.name == line.probe);
    let (_, indicator) = Indicator::ALL.into_iter().find(|(name, _)| *name == line.indicator)?;
    let value = ProbeOutcome::INDICATORS.into_iter().find(|(known, _)| *known == indicator);
    let whole = || Some(value?.1(probe?));
    let event = |event: &&ballrace_outcome::Event| {
        event.indicator == line.indicator && event.probe == line.probe && event.bearing == line.bearing
    };
    // A number too large for JSON is still beyond the limit.
    let largest = line.largest.map(|value| value.min(f64::MAX));
    Some(IndicatorValue {
        name: line.indicator.to_owned(),
        unit: indicator.unit().0.to_owned(),
        probe: Some(line.probe.clone()),
        bearing: line.bearing.clone(),
        value: finite(largest.or_else(whole)?)?,
        limit: finite(line.max),
        crossed: outcome.events.iter().any(|one| event(&one)),
    })
}

/// Returns the modulations of the envelope above 0 at each sensor by the lines of each bearing.
fn modulations(outcome: &Outcome) -> Vec<IndicatorValue> {
    const COMPONENTS: [FaultKind; 4] =
        [FaultKind::OuterRace, FaultKind::InnerRace, FaultKind::Element, FaultKind::Cage];
    let of_sensor = |sensor: &ballrace_outcome::baseline::BaselineSensor| {
        let lines =
            outcome.bearings.iter().flat_map(|bearing| COMPONENTS.map(|kind| (bearing.name.clone(), kind.key())));
        let value = |((bearing, name), modulation): ((String, &str), &f64)| {
            let (value, name) = (finite(*modulation).filter(|value| *value > 0.0)?, format!("{name}-modulation"));
            let (unit, probe, bearing) = (String::new(), Some(sensor.name.clone()), Some(bearing));
            Some(IndicatorValue { name, unit, probe, bearing, value, limit: None, crossed: false })
        };
        lines.zip(&sensor.modulations).filter_map(value).collect::<Vec<_>>()
    };
    outcome.learned.sensors.iter().flat_map(of_sensor).collect()
}
