//! Angle and slip of the cages from the recording, by the method of the diagnosis.

use super::parameters::{Parameter, cage_parameters};
use super::{FitInput, turns_of};
use ballrace_diagnosis as diagnosis;
use ballrace_plant::Plant;
use ballrace_plant::error::Result;
use ballrace_recording::Sample;
use ballrace_scene::Scene;

/// Cages of a scene as estimated from the recording.
pub(super) struct Cages {
    /// Angle and speed ratio of the observable ones.
    pub(super) parameters: Vec<Parameter>,
    /// The scene with them.
    pub(super) scene: Scene,
    /// Which cages are not estimated, with the reason.
    pub(super) notes: Vec<String>,
}

/// Estimates the cages by the method of the diagnosis.
pub(super) fn cages(of: &FitInput, plant: &Plant) -> Result<Cages> {
    let (scene, samples) = (of.scene, of.cage_samples);
    let mut found = Cages { parameters: vec![], scene: scene.clone(), notes: vec![] };
    let kept = "The scene's first_element_azimuth and cage_ratio are kept.";
    if let Some(reason) = diagnosis::not_applicable(scene, samples) {
        found.notes.push(format!("The cages are not estimated: {reason}. {kept}"));
        return Ok(found);
    }
    let probes = scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
    let material = diagnosis::DiagnosisInput {
        scene,
        plant,
        probes,
        samples,
        period: of.period,
        calibration: None,
        is_corrected: false,
    };
    let Some(estimates) = diagnosis::cages(&material)? else {
        found.notes.push(format!("The cages are not estimated: the probes do not determine the motion. {kept}"));
        return Ok(found);
    };
    let turns = match samples {
        [first, .., last] => (turns_of(last) - turns_of(first)).abs(),
        _ => 0.0,
    };
    let middle = samples.get(samples.len() / 2).map_or(0.0, Sample::total_revolutions);
    diagnosis::set_cages(&mut found.scene, &estimates, middle);
    found.parameters = cage_parameters(scene, plant, &estimates, turns);
    let hidden = scene.bearings.iter().zip(&estimates).filter(|(_, cage)| !cage.observable);
    found.notes =
        hidden.map(|(b, _)| format!("{}: the cage is not observable in this recording. {kept}", b.name)).collect();
    Ok(found)
}
