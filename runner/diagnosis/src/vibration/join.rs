//! One list of diagnoses from shaft motion and vibration.

use ballrace_outcome::{Diagnosis, EvidenceSource, FaultKind};

/// Joins the diagnoses of shaft motion and of vibration. A fault that both show is one diagnosis with both evidences.
/// `is_motion_judged` is true where the shaft motion was diagnosed.
#[must_use]
pub fn join(motion: Vec<Diagnosis>, vibration: Vec<Diagnosis>, is_motion_judged: bool) -> Vec<Diagnosis> {
    let (mut all, unexplained): (Vec<Diagnosis>, Vec<Diagnosis>) =
        motion.into_iter().partition(|diagnosis| diagnosis.kind != FaultKind::Other);
    let mut alone = vec![];
    for diagnosis in vibration {
        let is_same =
            |known: &&mut Diagnosis| known.kind == diagnosis.kind && can_be_of(&diagnosis, known.bearing.as_deref());
        match all.iter_mut().find(is_same) {
            Some(known) => add_evidence(known, diagnosis),
            None => alone.push(seen_alone(diagnosis, is_motion_judged)),
        }
    }
    all.extend(alone);
    all.extend(unexplained);
    all
}

/// Returns true where a diagnosis of vibration can have its cause in `bearing`.
fn can_be_of(diagnosis: &Diagnosis, bearing: Option<&str>) -> bool {
    let others = diagnosis.vibration.iter().flat_map(|line| &line.not_excluded);
    bearing.is_some_and(|bearing| {
        diagnosis.bearing.as_deref() == Some(bearing) || others.into_iter().any(|b| b == bearing)
    })
}

/// Adds the evidence of `vibration` to a diagnosis of shaft motion.
fn add_evidence(known: &mut Diagnosis, vibration: Diagnosis) {
    // A second sensor, or a bearing with the same lines, adds nothing.
    if known.vibration.is_some() {
        return;
    }
    if let Some(line) = &vibration.vibration {
        known.sentence += &format!(
            " The vibration at {} shows it too: {:.1} Hz in the envelope of {:.0} to {:.0} Hz, {:.0} dB.",
            line.sensor, line.line_hz, line.band_hz[0], line.band_hz[1], line.level_db
        );
    }
    known.evidence.push(EvidenceSource::Vibration);
    known.vibration = vibration.vibration;
    // Two independent measurements: both would have to be wrong.
    known.confidence = 1.0 - (1.0 - known.confidence) * (1.0 - vibration.confidence);
}

/// States that only the vibration shows a fault.
fn seen_alone(mut diagnosis: Diagnosis, is_motion_judged: bool) -> Diagnosis {
    diagnosis.sentence += if is_motion_judged {
        " The vibration alone shows it, the shaft motion does not."
    } else {
        " The shaft motion was not diagnosed."
    };
    diagnosis
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_outcome::{FaultFigures, FaultParameters, VibrationLine};

    fn diagnosis(kind: FaultKind, bearing: Option<&str>, not_excluded: Option<&[&str]>) -> Diagnosis {
        let line = |others: &[&str]| VibrationLine {
            sensor: "A".to_owned(),
            band_hz: [2000.0, 4000.0],
            line_hz: 107.3,
            order: 3.58,
            modulation: 0.6,
            level_db: 22.0,
            not_excluded: others.iter().map(|b| (*b).to_owned()).collect(),
        };
        let source = if not_excluded.is_some() { EvidenceSource::Vibration } else { EvidenceSource::ShaftMotion };
        Diagnosis {
            kind,
            bearing: bearing.map(str::to_owned),
            failure_modes: vec![],
            line_hz: 107.0,
            order: 3.58,
            level_db: 20.0,
            confidence: 0.8,
            evidence: vec![source],
            vibration: not_excluded.map(line),
            parameters: FaultParameters::default(),
            sentence: "Fault.".to_owned(),
            lines: vec![],
            figures: FaultFigures::default(),
        }
    }

    #[test]
    fn a_fault_that_both_show_is_one_diagnosis() {
        let motion = vec![diagnosis(FaultKind::OuterRace, Some("DE"), None)];
        // The strongest bearing with these lines, and each that the sensor cannot distinguish from it.
        for of in ["DE", "NDE"] {
            let seen = vec![
                diagnosis(FaultKind::OuterRace, Some(of), Some(&["DE"])),
                diagnosis(FaultKind::OuterRace, Some("DE"), Some(&["NDE"])),
            ];
            let all = join(motion.clone(), seen, true);
            assert_eq!(all.len(), 1);
            assert_eq!(all[0].evidence, [EvidenceSource::ShaftMotion, EvidenceSource::Vibration]);
            assert_eq!(all[0].vibration.as_ref().unwrap().sensor, "A");
            assert!((all[0].confidence - 0.96).abs() < 1e-12);
            assert_eq!(
                all[0].sentence,
                "Fault. The vibration at A shows it too: 107.3 Hz in the envelope of 2000 to 4000 Hz, 22 dB."
            );
        }
    }

    #[test]
    fn a_fault_of_the_vibration_alone_stands_before_an_unexplained_residual() {
        let motion = vec![diagnosis(FaultKind::Unbalance, None, None), diagnosis(FaultKind::Other, None, None)];
        let seen = vec![diagnosis(FaultKind::InnerRace, Some("DE"), Some(&[]))];
        let all = join(motion, seen.clone(), true);
        let kinds: Vec<FaultKind> = all.iter().map(|f| f.kind).collect();
        assert_eq!(kinds, [FaultKind::Unbalance, FaultKind::InnerRace, FaultKind::Other]);
        assert!(all[1].sentence.ends_with("The vibration alone shows it, the shaft motion does not."));
        assert_eq!(all[1].evidence, [EvidenceSource::Vibration]);
        assert!(join(vec![], seen, false)[0].sentence.ends_with("The shaft motion was not diagnosed."));
    }
}
