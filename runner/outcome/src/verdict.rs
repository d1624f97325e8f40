//! The verdict as a sentence.

use crate::diagnosis::{Diagnosis, EvidenceSource};
use crate::diagnosis_outcome::{DiagnosisOutcome, ReadingOutcome};
use crate::implausibility::Implausibility;
use crate::outcome::Outcome;
use crate::predictors::Standing;
use crate::probe::ProbeOutcome;
use crate::twin::ComparedTwin;

/// Returns the root mean square of a figure over the probes; none where a probe lacks it.
fn rms(probes: &[ProbeOutcome], of: impl Fn(&ProbeOutcome) -> Option<f64>) -> Option<f64> {
    let values: Option<Vec<f64>> = probes.iter().map(of).collect();
    values.map(|values| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt())
}

/// Returns true where the twin is as good as any simpler model, or its residual is noise, or has no meaning.
#[must_use]
pub fn follows(twin: &ComparedTwin, probes: &[ProbeOutcome]) -> bool {
    if !twin.is_comparable() {
        return true;
    }
    let residual = rms(probes, |p| Some(p.residual_rms_um)).unwrap_or(0.0);
    let at_noise = rms(probes, |p| p.noise_um).is_some_and(|noise| residual <= 1.5 * noise);
    at_noise || probes.iter().all(|p| p.baselines.worst() != Standing::Worse)
}

/// Returns true where the twin follows, or the diagnosis of a site explains what it does not: by errors of the readings and what is expected
/// of a sound machine.
#[must_use]
pub fn is_explained(outcome: &Outcome) -> bool {
    let is_of_site = |diagnosis: &DiagnosisOutcome| !diagnosis.readings.is_empty();
    outcome.diagnosis.as_ref().is_some_and(is_of_site) || follows(&outcome.twin, &outcome.probes)
}

/// Change of a gap, drift in the record and amplitude of a hum that the verdict names, um: more than is usual between two recordings of one
/// installation.
const NAMED_GAP: f64 = 2.0;
const NAMED_DRIFT: f64 = 1.0;
const NAMED_HUM: f64 = 0.2;

/// Returns a sentence on means that are off: a gap is not told from the position of the shaft. Nothing without one.
fn moved_means(readings: &[ReadingOutcome]) -> String {
    let moved = readings.iter().filter(|one| one.gap_um.abs() > NAMED_GAP);
    let each: Vec<String> = moved.map(|one| format!("{} by {:+.1} um", one.probe, one.gap_um)).collect();
    match each.is_empty() {
        true => String::new(),
        false => format!(
            " Not decided: the mean is off, {}, by the gap of the probe or by the position of the shaft; check probe, load and alignment.",
            each.join(", ")
        ),
    }
}

/// Returns the errors of the readings that are larger than usual; nothing without one.
fn named_errors(readings: &[ReadingOutcome]) -> Vec<String> {
    let of = |one: &ReadingOutcome| {
        let ReadingOutcome { probe, drift_um, hum_um, hum_hz, .. } = one;
        let mut named = vec![];
        if drift_um.abs() > NAMED_DRIFT {
            named.push(format!("{probe} drifts by {drift_um:+.1} um"));
        }
        if *hum_um > NAMED_HUM {
            named.push(format!("{probe} has {hum_um:.2} um of hum at {hum_hz:.0} Hz"));
        }
        named
    };
    readings.iter().flat_map(of).collect()
}

/// Returns the verdict as a sentence: why there is none, else the strongest diagnosis, else whether the twin follows. `undiagnosed` is
/// the reason why the shaft motion was not diagnosed, `diagnosed` are the figures of its diagnosis.
#[must_use]
pub fn verdict(
    diagnoses: &[Diagnosis],
    (twin, probes): (&ComparedTwin, &[ProbeOutcome]),
    implausible: &[Implausibility],
    not_judged: &[String],
    (undiagnosed, diagnosed): (Option<&str>, Option<&DiagnosisOutcome>),
    out_of_range: u64,
) -> String {
    if !implausible.is_empty() {
        let all: Vec<String> = implausible.iter().map(|one| format!("{}: {}", one.subject, one.found)).collect();
        return format!(
            "The recording is not plausible for the scene: {}. Nothing is diagnosed without --force.",
            all.join("; ")
        );
    }
    if !not_judged.is_empty() {
        if let Some(seen) = diagnoses.iter().find(|diagnosis| is_of_vibration_alone(diagnosis)) {
            return format!("The shaft motion has no verdict: {}. {}", not_judged.join("; "), seen.sentence);
        }
        return format!("No verdict: {}.", not_judged.join("; "));
    }
    let left_out = match out_of_range {
        0 => String::new(),
        1 => " 1 sample with a reading out of range is omitted.".to_owned(),
        count => format!(" {count} samples with a reading out of range are omitted."),
    };
    let verdict = judged(diagnoses, (twin, probes), undiagnosed, diagnosed);
    format!("{verdict}{left_out}")
}

/// Returns true for a diagnosis that the shaft motion does not show.
fn is_of_vibration_alone(diagnosis: &Diagnosis) -> bool {
    diagnosis.evidence == [EvidenceSource::Vibration]
}

fn judged(
    diagnoses: &[Diagnosis],
    (twin, probes): (&ComparedTwin, &[ProbeOutcome]),
    undiagnosed: Option<&str>,
    diagnosed: Option<&DiagnosisOutcome>,
) -> String {
    if let Some(worst) = diagnoses.first() {
        if is_of_vibration_alone(worst) {
            return format!("The vibration shows a fault. {}", worst.sentence);
        }
        return format!("The machine departs from its twin. {}", worst.sentence);
    }
    let residual = rms(probes, |p| Some(p.residual_rms_um)).unwrap_or(0.0);
    if let Some(of_site) = diagnosed.filter(|diagnosed| !diagnosed.readings.is_empty()) {
        let named = named_errors(&of_site.readings);
        let errors = match named.is_empty() {
            true => String::new(),
            false => format!(" Errors of the measurement, no fault of the machine: {}.", named.join("; ")),
        };
        let means = moved_means(&of_site.readings);
        let found = if of_site.is_without_baseline {
            "Not decided: no fault exceeds what errors of the scene and of the probes, and sound bearings, may do; with a recording of the machine \
             in good order as a baseline (--learn), smaller faults are found."
        } else {
            "No fault is found: the motion of the shaft is that of the machine in good order, with the gaps and run-out of its probes and what \
             sound bearings do."
        };
        return format!("{found}{means}{errors} Residual of the twin {residual:.3} um rms.");
    }
    let faults = undiagnosed.map_or_else(
        || "no fault is found".to_owned(),
        |reason| format!("the shaft motion is not diagnosed: {reason}"),
    );
    if !twin.is_comparable() {
        return format!(
            "The motion of this machine does not repeat, so that no twin has its phase, and without an observer none can be \
             synchronised with the readings: the comparison has no meaning; {faults}."
        );
    }
    let noise = rms(probes, |p| p.noise_um);
    let against = noise.map_or(String::new(), |noise| format!(", {:.2} times the probe noise", residual / noise));
    let count = |standing| probes.iter().filter(|p| p.baselines.worst() == standing).count();
    let (better, worse) = (count(Standing::Better), count(Standing::Worse));
    let follows = if follows(twin, probes) { "follows" } else { "does not follow" };
    let twin = match (twin.synchronised, &twin.spread) {
        (false, _) => "The twin",
        (true, None) => "The synchronised twin",
        (true, Some(_)) => "The motion of this machine does not repeat. The synchronised twin",
    };
    let rivals = if better == probes.len() {
        "its residual is smaller than that of all four simpler models on every probe".to_owned()
    } else if worse == 0 {
        format!(
            "no simpler model does better, and on {} of {} probes one does as well",
            probes.len() - better,
            probes.len()
        )
    } else {
        format!("a simpler model does better on {worse} of {} probes", probes.len())
    };
    format!("{twin} {follows} the machine: residual {residual:.3} um rms{against}; {rivals}; {faults}.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SimplePredictor, TwinSpread};

    /// What integration and digits leave of an exact prediction makes no simpler model better; a thousandth of the motion does.
    #[test]
    fn a_residual_of_digits_is_not_worse() {
        let standing = |twin: f64, motion: f64| SimplePredictor::new(0.5 * twin, twin, motion).twin_is;
        assert_eq!([standing(1e-7, 1.0), standing(2e-3, 1.0)], [Standing::Same, Standing::Worse]);
    }

    /// A residual far above the noise has no meaning where no twin has the phase of the machine.
    #[test]
    fn a_free_twin_of_a_motion_that_does_not_repeat() {
        let probes = [ProbeOutcome { residual_rms_um: 3.0, noise_um: Some(0.03), ..ProbeOutcome::default() }];
        let spread = TwinSpread { probe: "DE".to_owned(), difference_um: 3.1, time_s: 4.0 };
        let free = ComparedTwin { synchronised: false, spread: Some(spread.clone()) };
        let sentence = verdict(&[], (&free, &probes), &[], &[], (None, None), 0);
        assert!(sentence.ends_with("the comparison has no meaning; no fault is found."), "{sentence}");
        assert!(follows(&free, &probes));
        let synchronised = ComparedTwin { synchronised: true, spread: Some(spread) };
        let sentence = verdict(&[], (&synchronised, &probes), &[], &[], (None, None), 0);
        assert!(
            sentence.starts_with("The motion of this machine does not repeat. The synchronised twin"),
            "{sentence}"
        );
        assert!(verdict(&[], (&ComparedTwin::default(), &probes), &[], &[], (None, None), 0).starts_with("The twin "));
    }

    /// Drift and hum are errors of the measurement; a mean that has moved may be the shaft.
    #[test]
    fn a_site_names_what_its_readings_have() {
        let of = |gap_um: f64, drift_um: f64, is_without_baseline: bool| {
            let probe = "DE".to_owned();
            let readings = vec![ReadingOutcome { probe, gap_um, drift_um, ..ReadingOutcome::default() }];
            let diagnosed = DiagnosisOutcome { readings, is_without_baseline, ..DiagnosisOutcome::default() };
            verdict(&[], (&ComparedTwin::default(), &[]), &[], &[], (None, Some(&diagnosed)), 0)
        };
        let [usual, moved, drifting] = [of(0.5, 0.1, false), of(-5.8, 0.1, false), of(0.5, 1.9, false)];
        let first = of(0.5, 1.9, true);
        assert!(first.starts_with("Not decided: no fault exceeds"), "{first}");
        assert!(first.contains("no fault of the machine: DE drifts by +1.9 um."), "{first}");
        assert!(usual.starts_with("No fault is found") && !usual.contains("Not decided") && !usual.contains("Errors"));
        assert!(moved.contains("Not decided: the mean is off, DE by -5.8 um") && !moved.contains("Errors"), "{moved}");
        assert!(drifting.contains("no fault of the machine: DE drifts by +1.9 um."), "{drifting}");
    }
}
