//! Conclusion of a replay: the outcome from the sums of the stages.

use super::evaluate::Evaluator;
use super::pipeline::Pipeline;
use super::running_diagnosis::RunningDiagnosis;
use super::running_vibration::RunningVibration;
use super::samples::SampleCollector;
use super::standstill::Measured;
use super::totals::Totals;
use super::{list, observe, plausibility, verdict};
use ballrace_diagnosis::block::Block;
use ballrace_diagnosis::plausibility::{Evidence, implausible};
use ballrace_diagnosis::vibration::join::join;
use ballrace_diagnosis::vibration::signals::Evaluation;
use ballrace_diagnosis::{self as diagnosis, DiagnosisInput};
use ballrace_outcome::{
    ComparedTwin, Diagnosis, DiagnosisOutcome, FaultKind, Implausibility, MarkedLine, Outcome, Pictures, Record,
    RotorDrawing, TwinSpread,
};
use ballrace_plant::Plant;
use ballrace_plant::error::{ReplayError, Result};
use ballrace_recording::flaws::FlawSummary;
use ballrace_scene::Scene;
use ballrace_studies::campbell;
use std::f64::consts::TAU;
use std::time::Instant;

/// Facts of a recording that the pipeline does not have.
pub(super) struct RecordingFacts<'a> {
    pub(super) name: &'a str,
    /// Number of rows that the reader delivered.
    pub(super) rows: u64,
    /// Source of the shaft angle.
    pub(super) angle_source: String,
    /// The readings are without run-out.
    pub(super) is_run_out_subtracted: bool,
    pub(super) flaws: Vec<FlawSummary>,
}

impl Pipeline<'_> {
    /// Adds the slips of the cages that the observer followed; returns notes on them.
    fn follow_up(&self, totals: &Totals, outcome: &mut DiagnosisOutcome) -> Vec<String> {
        let mut notes = vec![];
        if totals.speed().count() as usize <= outcome.samples {
            return notes;
        }
        let tracker = &self.follower.cages;
        for ((cage, slips), &is_followed) in outcome.cages.iter_mut().zip(tracker.slips()).zip(tracker.followed()) {
            let Some(slips) = slips.map(|slips| slips.map(|slip| 100.0 * slip)) else { continue };
            let (name, [low, high]) = (&cage.bearing, slips);
            notes.push(if is_followed {
                format!("The observer followed the cage of {name}: its slip was {low:.2} to {high:.2} %.")
            } else {
                format!(
                    "The observer no longer follows the cage of {name}: its passing elements move the shaft too little, the observer does not describe the motion, or the shaft angle was interrupted. Until then its slip was {low:.2} to {high:.2} %."
                )
            });
            cage.followed_slip_percent = Some(slips);
        }
        notes
    }

    /// Returns the outcome.
    ///
    /// # Errors
    /// A recording without a sample, an output that cannot be written.
    pub(super) fn conclude(
        mut self,
        mut evaluator: Evaluator,
        scene: &Scene,
        mut facts: RecordingFacts,
    ) -> Result<Outcome> {
        facts.flaws.extend(self.follower.range.flaws().summary());
        if let Some(file) = evaluator.forces_file.take()
            && let Err(error) = file.finish()
        {
            evaluator.drop_forces_file(error, evaluator.totals.last_time)?;
        }
        if evaluator.totals.speed().count() == 0.0 {
            return self.conclude_at_standstill(evaluator, scene, facts);
        }
        let mut vibration = self.evaluate_vibration(scene)?;
        evaluator.comparison.finish();
        let bearings = self.plant.bearings.as_slice();
        let mean_speed = evaluator.totals.speed().mean();
        let speed_hz = mean_speed.abs() / TAU;
        let mut probes = evaluator.comparison.outcomes(self.probes, bearings, speed_hz);
        let samples = evaluator.block.take().map(Block::into_samples).unwrap_or_default();
        let mut implausible = implausible(&Evidence {
            scene,
            rate_hz: self.rate,
            collected: &self.collected,
            limits: Some(self.follower.range.limits()),
            rotation: None,
            samples: &samples,
        });
        if evaluator.counts.has_overflowed() {
            implausible.extend(evaluator.counts.overflow());
        } else if implausible.is_empty() {
            implausible = plausibility::unlike_twin(&probes, evaluator.force.bearings(), bearings);
        }
        let mut overridden = std::mem::take(&mut self.ahead.overridden);
        if self.force_diagnosis {
            let is_new = |one: &Implausibility| overridden.iter().all(|known| known.subject != one.subject);
            let new: Vec<Implausibility> = implausible.drain(..).filter(is_new).collect();
            overridden.extend(new);
        }
        self.notes.extend(overridden.iter().map(|one| format!("Not plausible, diagnosed all the same: {one}.")));
        let mut not_judged = evaluator.counts.not_judged(evaluator.comparison.compared);
        let is_judged = implausible.is_empty() && not_judged.is_empty();
        let material = DiagnosisInput {
            scene,
            plant: &self.plant,
            probes: self.probes,
            samples: &samples,
            period: 1.0 / self.rate,
            calibration: self.ahead.calibration.as_ref(),
            is_corrected: true,
        };
        let mut undiagnosed = diagnosis::not_applicable(scene, &samples);
        let begun = Instant::now();
        let diagnosed = match self.ahead.diagnosed.take() {
            Some(known) => Some(known),
            None if !is_judged || undiagnosed.is_some() => None,
            // A monitor that is stopped ends with its last diagnosis.
            None if self.follower.startup.is_cancelled() => {
                match self.running_diagnosis.as_mut().and_then(RunningDiagnosis::take) {
                    Some((diagnosis, time)) => {
                        self.notes.push(format!(
                            "The diagnosis is of the samples up to {time:.1} s, the last before the stop."
                        ));
                        Some(diagnosis)
                    }
                    None => {
                        undiagnosed = Some("the monitor was stopped before its first diagnosis".to_owned());
                        None
                    }
                }
            }
            None => {
                let made = diagnosis::diagnose(&material, &|_| {})?;
                undiagnosed = made.is_none().then(|| "the probes do not determine the motion".to_owned());
                made
            }
        };
        evaluator.timing.diagnosed(begun.elapsed());
        let mut diagnosed = diagnosed.filter(|_| is_judged);
        if let Some(diagnosis) = &mut diagnosed {
            diagnosis.notes.extend(self.follow_up(&evaluator.totals, &mut diagnosis.outcome));
        }
        let (mut diagnoses, mut diagnosis_notes) =
            diagnosed.as_ref().map_or_else(Default::default, |d| (d.diagnoses.clone(), d.notes.clone()));
        let mut learned = evaluator.comparison.baseline(&scene.name, facts.name, self.probes, bearings);
        learned.calibration.clone_from(&self.ahead.calibration);
        learned.synchronised = self.follower.is_synchronised();
        learned.set_faults(&diagnoses);
        if let Some(baseline) = &self.baseline {
            let (known, new) = diagnoses.into_iter().partition(|diagnosis| baseline.contains_fault(diagnosis));
            diagnoses = new;
            let known: Vec<Diagnosis> = known;
            diagnosis_notes.extend(known.iter().map(|diagnosis| format!("As in the baseline: {}", diagnosis.sentence)));
        }
        if implausible.is_empty() {
            diagnoses = join(diagnoses, std::mem::take(&mut vibration.diagnoses), diagnosed.is_some());
        }
        learned.sensors = vibration.learned;
        diagnosis_notes.extend(vibration.notes);
        if self.baseline.is_none()
            && let Some(reason) = clearance_is_estimated(scene)
        {
            let imitated = |diagnosis: &Diagnosis| matches!(diagnosis.kind, FaultKind::Clearance | FaultKind::Load);
            let (uncertain, known): (Vec<Diagnosis>, Vec<Diagnosis>) = diagnoses.into_iter().partition(imitated);
            diagnoses = known;
            diagnosis_notes.extend(
                uncertain.iter().map(|diagnosis| format!("Not a diagnosis, as {reason}: {}", diagnosis.sentence)),
            );
            if diagnoses.is_empty() && !uncertain.is_empty() {
                not_judged.push(reason);
            }
        }
        let mut learning = self.ahead.learning.take();
        if let Some(learning) = &mut learning {
            learning.judge(diagnosed.as_ref().map(|of| of.outcome.chi_square_after), self.force_diagnosis);
            diagnosis_notes.extend(learning.notes());
        }
        let observer = self.follower.observer.outcome();
        let twin = self.compared_twin();
        let mut notes = std::mem::take(&mut self.notes);
        notes.append(&mut evaluator.notes);
        notes.extend(self.closing_notes(&evaluator));
        notes.extend(diagnosis_notes);
        let undiagnosed = undiagnosed.filter(|_| diagnosed.is_none() && is_judged);
        notes.extend(undiagnosed.as_ref().map(|reason| format!("The shaft motion is not diagnosed: {reason}.")));
        notes.extend(observer.as_ref().map(observe::sentence));
        let limits = evaluator.limits.lines();
        notes.extend(evaluator.limits.note());
        let events = evaluator.limits.finish();
        notes.extend(events.iter().map(|event| event.sentence.clone()));
        let mut pictures =
            evaluator.figures.finish(&evaluator.comparison, evaluator.force.bearings(), bearings, self.rate, speed_hz);
        pictures.clearances = list::clearances(scene, &self.planes);
        pictures.limits = limits;
        pictures.rotor = RotorDrawing::new(scene);
        pictures.natural_frequencies = natural_frequencies(&self.plant, mean_speed);
        pictures.envelopes = vibration.envelopes;
        let deflection = evaluator.deflection.as_ref();
        pictures.deflected_line = deflection.and_then(|mean| mean.line(scene, &self.plant, &self.planes, &probes));
        let record = Record {
            samples: facts.rows,
            average: scene.recording.as_ref().map_or(1, |recording| recording.average),
            compared: evaluator.comparison.compared,
            rate_hz: self.rate,
            angle_source: facts.angle_source,
            is_run_out_subtracted: facts.is_run_out_subtracted,
            load: load(scene),
            spectra: evaluator.comparison.spectra.settings(self.rate),
            ..evaluator.totals.record()
        };
        list::fill(&mut probes, &pictures.blocks, record.speed_changes());
        Ok(Outcome {
            file: None,
            scene: scene.name.clone(),
            recording: facts.name.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            verdict: verdict::verdict(
                &diagnoses,
                (&twin, &probes),
                &implausible,
                &not_judged,
                (undiagnosed.as_deref(), diagnosed.as_ref().map(|of| &of.outcome)),
                evaluator.counts.out_of_range(),
            ),
            implausible,
            not_judged,
            snapshots: vec![],
            snapshot_trends: vec![],
            record,
            planes: list::planes(&self.planes, &pictures, mean_speed.signum()),
            observation: self.follower.location.observation().clone(),
            twin,
            probes,
            rotor: self.plant.rotor_outcome(scene),
            bearings: evaluator.force.outcomes(bearings),
            sensors: vibration.sensors,
            timing: evaluator.timing.finish(self.follower.startup.took()),
            observer,
            diagnoses,
            diagnosis: diagnosed.map(|d| d.outcome),
            events,
            flaws: facts.flaws,
            notes,
            learning,
            learned,
            pictures,
            samples: evaluator.samples.map(SampleCollector::finish),
        }
        .with_stations_as_drawn(scene))
    }

    /// Returns the twin that the readings are compared with.
    fn compared_twin(&self) -> ComparedTwin {
        let spread = self.follower.spread.map(|spread| TwinSpread {
            probe: self.probes[spread.probe].column.clone(),
            difference_um: 1e6 * spread.difference,
            time_s: spread.time,
        });
        ComparedTwin { synchronised: self.follower.is_synchronised(), spread }
    }

    /// Evaluates the signals of the vibration sensors, with a note where they have no verdict.
    fn evaluate_vibration(&mut self, scene: &Scene) -> Result<Evaluation> {
        let Some(signals) = self.signals.take() else {
            return Ok(self.vibration.as_mut().map(RunningVibration::conclusion).unwrap_or_default());
        };
        let mut found = signals.evaluate(scene, self.baseline.as_ref())?;
        found.notes.extend([found.speed.take(), found.rotor.take(), found.severity.take()].into_iter().flatten());
        found.notes.extend(found.not_judged.as_ref().map(|reason| format!("Sensors: no verdict: {reason}.")));
        Ok(found)
    }

    /// Returns the outcome of a recording in which no sample has a shaft angle.
    fn conclude_at_standstill(mut self, evaluator: Evaluator, scene: &Scene, facts: RecordingFacts) -> Result<Outcome> {
        if self.standstill.samples() == 0 {
            return Err(ReplayError::NoSample { recording: facts.name.to_owned() }.into());
        }
        let implausible = self.standstill.implausible_speed().map_or_else(Vec::new, |speed| {
            implausible(&Evidence {
                scene,
                rate_hz: self.rate,
                collected: &self.collected,
                limits: Some(self.follower.range.limits()),
                rotation: Some(speed),
                samples: &[],
            })
        });
        let vibration = self.evaluate_vibration(scene)?;
        let outcome = self.standstill.outcome(Measured {
            implausible,
            probes: self.probes,
            bearings: evaluator.force.outcomes(&self.plant.bearings),
            observation: self.follower.location.observation().clone(),
            rows: facts.rows,
            rate: self.rate,
            angle_source: facts.angle_source,
            load: load(scene),
            timing: evaluator.timing.finish(self.follower.startup.took()),
        });
        let limits_note = evaluator.limits.note();
        let events = evaluator.limits.finish();
        let (implausible, not_judged) = (&outcome.implausible, &outcome.not_judged);
        let mut notes = outcome.notes;
        notes.extend(vibration.notes);
        notes.extend(self.notes);
        notes.extend(evaluator.notes);
        notes.extend(limits_note);
        notes.extend(events.iter().map(|event| event.sentence.clone()));
        Ok(Outcome {
            scene: scene.name.clone(),
            recording: facts.name.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            rotor: self.plant.rotor_outcome(scene),
            pictures: Pictures { rotor: RotorDrawing::new(scene), ..outcome.pictures },
            verdict: verdict::verdict(&[], (&outcome.twin, &[]), implausible, not_judged, (None, None), 0),
            events,
            flaws: facts.flaws,
            notes,
            ..outcome
        }
        .with_stations_as_drawn(scene))
    }

    /// Returns notes on the assumptions and restrictions of the outcome.
    fn closing_notes(&self, evaluator: &Evaluator) -> Vec<String> {
        let mut notes: Vec<String> = self.standstill.note().into_iter().collect();
        let speed = evaluator.totals.speed();
        let (slow, fast) = speed.extremes();
        if (fast - slow).abs() > 0.05 * speed.mean().abs() {
            notes.push(
                "The speed changes by more than 5 %: spectra in Hz smear; 1X and ball-pass figures follow the shaft and do not.".to_owned(),
            );
        }
        notes.extend(self.follower.alignment.note(self.rate));
        notes.extend(self.follower.location.note().map(str::to_owned));
        if self.probes.iter().any(|p| p.noise.is_none()) {
            notes.push(
                "Not every probe has its noise in the scene (noise = \"0.03 um\"): forces come without a noise band."
                    .to_owned(),
            );
        }
        notes.extend(self.follower.twin.notes());
        if evaluator.comparison.compared == 0 {
            notes
                .push("No sample has a reading of every probe: no force and no spectrum could be computed.".to_owned());
        }
        notes
    }
}

/// Coordinates beyond which natural frequencies are not computed: the time grows with the cube of their number.
const MAX_COORDINATES: usize = 60;

/// Returns the damped natural frequencies at a speed (rad/s), lowest first.
fn natural_frequencies(plant: &Plant, speed: f64) -> Vec<MarkedLine> {
    if plant.layout.order > MAX_COORDINATES || !speed.is_finite() {
        return vec![];
    }
    // The figures have no marks where the modes cannot be computed.
    let modes = campbell::modes(plant, speed, true).unwrap_or_default();
    let line = |(number, mode): (usize, &campbell::Mode)| MarkedLine {
        label: format!("N{number}"),
        order: f64::NAN,
        hz: mode.frequency_hz,
    };
    (1..).zip(&modes).map(line).collect()
}

/// Returns the constant load on the rotor of a scene; not a number where a `[system]` has it on its coordinates.
fn load(scene: &Scene) -> [f64; 5] {
    let none = if scene.system.is_some() { f64::NAN } else { 0.0 };
    scene.rotor.as_ref().map_or([none; 5], |rotor| rotor.load)
}

/// Returns the reason why the position of the shaft does not determine load and clearance: the scene has the clearance of the catalogue.
fn clearance_is_estimated(scene: &Scene) -> Option<String> {
    let estimated = scene.bearings.iter().filter(|bearing| {
        bearing.catalogue.as_ref().is_some_and(|used| used.estimated.iter().any(|value| value.contains("clearance")))
    });
    let names: Vec<&str> = estimated.map(|bearing| bearing.name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the clearance of {} is that of the catalogue, and another one or another load would move the shaft as much; run \
             `ballrace fit` on a recording of the machine in good order, or give a --baseline",
            names.join(" and ")
        )
    })
}
