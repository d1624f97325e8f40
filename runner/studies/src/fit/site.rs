//! Fit to a recording of a site, by the method of the diagnosis: gap, drift, run-out and hum of each probe are unknown, and sound bearings have
//! the waves and unequal elements of their class.

use super::estimates::IDENTIFIABLE;
use super::intervals::unbalance;
use super::parameters::{Group, OPEN, Parameter, ParameterKind, sums};
use super::{Estimate, FitInput, FitProgress, Fitted, Residual, not_converged, turns_of};
use ballrace_base::statistics::quantile;
use ballrace_base::time_limit::TimeLimit;
use ballrace_diagnosis::{self as diagnosis, Calibrated, CalibrationPlan, DiagnosisInput};
use ballrace_outcome::ParameterName;
use ballrace_plant::Plant;
use ballrace_plant::error::{FitError, Result};
use ballrace_plant::observer::noise;
use ballrace_scene::{FreeAngle, Rotor, Scene};
use nalgebra::DMatrix;
use std::cell::RefCell;

/// Share of machines of which an interval does not contain the true parameter, all parameters together.
const MISSED: f64 = 0.05;

/// Fit to a recording of a site.
pub(super) struct AtSite {
    pub(super) fitted: Fitted,
    /// True where more than gaps is wrong with the readings and the bearings of the scene: no fit along the time describes them.
    pub(super) is_clear: bool,
}

/// Returns the fit to a recording of a site; `None` for a recording without errors of the readings, or where they may be gaps alone and the
/// search does not converge.
pub(super) fn fitted(
    of: &FitInput,
    plant: &Plant,
    (groups, time_limit): (&[Group], TimeLimit),
    progress: &mut dyn FnMut(FitProgress),
) -> Result<Option<AtSite>> {
    let (scene, samples) = (of.scene, of.cage_samples);
    let parameters: Vec<ParameterName> = groups.iter().flat_map(|group| names(*group)).copied().collect();
    if parameters.is_empty() || diagnosis::not_applicable(scene, samples).is_some() {
        return Ok(None);
    }
    let turns = match samples {
        [first, .., last] => turns_of(last) - turns_of(first),
        _ => 0.0,
    };
    let report = RefCell::new(progress);
    let begin = |iteration: usize| {
        let at = FitProgress { iteration, most: diagnosis::MAX_ROUNDS, turns: turns.abs(), all_turns: turns.abs() };
        (report.borrow_mut())(at);
    };
    let probes = scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
    let input =
        DiagnosisInput { scene, plant, probes, samples, period: of.period, calibration: None, is_corrected: false };
    let plan_of_calibration = CalibrationPlan { parameters: &parameters, begin: &begin, time_limit: Some(time_limit) };
    let Some(found) = diagnosis::calibrate_site(&input, &plan_of_calibration)? else { return Ok(None) };
    let [before, after] = &found.unexplained_rms;
    let residual = |(p, probe): (usize, &ballrace_scene::Probe)| Residual {
        probe: probe.column.clone(),
        before_um: 1e6 * before.get(p).copied().unwrap_or(0.0),
        after_um: 1e6 * after.get(p).copied().unwrap_or(0.0),
        noise_um: 1e6 * noise(samples, p, None),
    };
    let residuals: Vec<Residual> = probes.iter().enumerate().map(residual).collect();
    let is_clear = found.leaves_lines();
    match found.not_converged.clone() {
        Some(_) if !is_clear => return Ok(None),
        Some(_) if time_limit.is_over() => {
            let (recording, limit_s, turns) = (of.recording.to_owned(), time_limit.seconds(), turns.abs());
            return Err(FitError::TooLong { recording, limit_s, turns, all_turns: turns }.into());
        }
        Some(reason) => return Err(not_converged(of, reason, &residuals).into()),
        None => {}
    }
    let consistent = found.explains();
    let Parameters { estimates, values, mut notes, one_plane } = estimates(scene, &found);
    let of_offsets = if groups.contains(&Group::Offset) { offsets(scene, &found) } else { vec![] };
    let interval = |end: Option<f64>| end.filter(|_| consistent);
    let estimates = estimates.into_iter().chain(of_offsets.iter().map(|(estimate, ..)| estimate.clone()));
    let values = values.into_iter().chain(of_offsets.iter().map(|(_, parameter, value)| (parameter.clone(), *value)));
    if groups.contains(&Group::Unbalance) && found.has_unknown_run_out {
        notes.push(
            "Without a recording at slow roll the unbalance is not told from the run-out: its interval is that of the scene's value."
                .to_owned(),
        );
    }
    let per_value = found.calibration.chi_square_per_value;
    let fitted = Fitted {
        scene: scene.name.clone(),
        recording: of.recording.to_owned(),
        samples: samples.len(),
        turns,
        chi_square: per_value * found.values as f64,
        readings: found.values,
        chi_square_per_reading: per_value,
        largest_chi_square_per_reading: found.largest_chi_square_per_value(),
        consistent,
        residuals,
        parameters: estimates.map(|p| Estimate { low: interval(p.low), high: interval(p.high), ..p }).collect(),
        errors: found.errors,
        notes,
        values: values.collect(),
        one_plane,
    };
    Ok(Some(AtSite { fitted, is_clear }))
}

/// Returns the parameters of a group that the diagnosis calibrates.
const fn names(group: Group) -> &'static [ParameterName] {
    use ParameterName::{
        CoupleX, CoupleY, DiametralClearance, RotationDamping, TranslationDamping, UnbalanceX, UnbalanceY,
        YoungsModulus,
    };
    match group {
        Group::Unbalance => &[UnbalanceX, UnbalanceY, CoupleX, CoupleY],
        Group::Clearance => &[DiametralClearance],
        Group::Damping => &[TranslationDamping, RotationDamping],
        Group::Stiffness => &[YoungsModulus],
        // Gaps are errors of the readings.
        Group::Offset => &[],
    }
}

/// Estimates with their values in the scene.
struct Parameters {
    estimates: Vec<Estimate>,
    values: Vec<(Parameter, f64)>,
    notes: Vec<String>,
    one_plane: bool,
}

/// A parameter of the scene that changes with a calibrated one.
struct Changed {
    kind: ParameterKind,
    given: f64,
    /// Its change over that of the calibrated parameter.
    per_calibrated: f64,
}

/// Returns the parameters of the scene that change with a calibrated one; nothing where its value follows from other keys.
fn changed(scene: &Scene, rotor: &Rotor, name: ParameterName, bearing: Option<&str>) -> Vec<Changed> {
    let (force, couple) = sums(&rotor.unbalance);
    let own = |kind, given| vec![Changed { kind, given, per_calibrated: 1.0 }];
    let b = scene.bearings.iter().position(|b| Some(b.name.as_str()) == bearing).unwrap_or(0);
    let of_bearing = scene.bearings.get(b);
    let geometry = of_bearing.and_then(|b| b.geometry);
    match name {
        ParameterName::DiametralClearance => {
            let play = of_bearing.and_then(|b| b.law).and_then(|law| law.radial_play);
            match (play, geometry.map(|g| g.fit)) {
                (Some(play), _) => vec![Changed { kind: ParameterKind::Play(b), given: play, per_calibrated: 0.5 }],
                (None, Some(FreeAngle::DiametralClearance(clearance))) => own(ParameterKind::Clearance(b), clearance),
                _ => vec![],
            }
        }
        ParameterName::YoungsModulus => {
            geometry.map_or_else(Vec::new, |g| own(ParameterKind::Modulus(b), g.youngs_modulus))
        }
        ParameterName::TranslationDamping => {
            let [across, _, along, ..] = rotor.damping;
            let along = Changed { kind: ParameterKind::Damping(1), given: along, per_calibrated: along / across };
            own(ParameterKind::Damping(0), across).into_iter().chain([along]).collect()
        }
        ParameterName::RotationDamping => own(ParameterKind::Damping(2), rotor.damping[3]),
        ParameterName::UnbalanceX => own(ParameterKind::Unbalance(0), force[0]),
        ParameterName::UnbalanceY => own(ParameterKind::Unbalance(1), force[1]),
        ParameterName::CoupleX => own(ParameterKind::Couple(0), couple[0]),
        ParameterName::CoupleY => own(ParameterKind::Couple(1), couple[1]),
    }
}

const fn parameter(kind: ParameterKind, given: f64) -> Parameter {
    Parameter { kind, given, start: given, scale: 1.0, bounds: OPEN }
}

fn estimates(scene: &Scene, found: &Calibrated) -> Parameters {
    let calibration = &found.calibration;
    let mut all = Parameters { estimates: vec![], values: vec![], notes: vec![], one_plane: false };
    let Some(rotor) = &scene.rotor else { return all };
    // Simultaneous intervals (Bonferroni).
    let z = quantile(0.5 * MISSED / calibration.parameters.len().max(1) as f64);
    let of_unbalance: Vec<usize> = (0..calibration.parameters.len())
        .filter(|&i| names(Group::Unbalance).contains(&calibration.parameters[i].name))
        .collect();
    for (i, calibrated) in calibration.parameters.iter().enumerate() {
        for Changed { kind, given, per_calibrated } in
            changed(scene, rotor, calibrated.name, calibrated.bearing.as_deref())
        {
            let (value, deviation) = (per_calibrated * calibrated.value, per_calibrated * found.deviation(i));
            all.values.push((parameter(kind, given), value));
            if of_unbalance.contains(&i) {
                continue;
            }
            let (name, unit, size) = kind.name(scene);
            let known = found.scene_deviation(i, given / per_calibrated);
            let remains = known.map_or(0.0, |known| found.deviation(i) / known);
            let identified = remains < IDENTIFIABLE;
            if !identified {
                all.notes.push(format!(
                    "{name} is not identifiable from this recording: {:.0} % of the prior uncertainty remains. The fitted value is the likeliest \
                     beside the scene's.",
                    100.0 * remains.min(1.0)
                ));
            }
            all.estimates.push(Estimate {
                name,
                unit,
                given: given / size,
                value: value / size,
                low: Some((value - z * deviation).max(0.0) / size),
                high: Some((value + z * deviation) / size),
                identified,
            });
        }
    }
    if of_unbalance.len() == names(Group::Unbalance).len() {
        let covariance = DMatrix::from_fn(4, 4, |a, b| {
            let (i, j) = (of_unbalance[a], of_unbalance[b]);
            calibration.correlation[i][j] * found.deviation(i) * found.deviation(j)
        });
        let (unknown, values): (Vec<Parameter>, Vec<f64>) =
            all.values.iter().filter(|(p, _)| is_unbalance(p.kind)).cloned().unzip();
        let (estimates, one_plane) =
            unbalance(&values, &covariance, &unknown, [0, 2], z, 0.0, scene.drawn_station(0.0));
        all.one_plane = one_plane && rotor.flexible.is_none();
        all.estimates.splice(0..0, estimates);
    }
    all
}

const fn is_unbalance(kind: ParameterKind) -> bool {
    matches!(kind, ParameterKind::Unbalance(_) | ParameterKind::Couple(_))
}

/// Returns the offset of each probe with the gap that was found, without an interval: it contains the error of the shaft's position.
fn offsets(scene: &Scene, found: &Calibrated) -> Vec<(Estimate, Parameter, f64)> {
    let probes = scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
    let of = |(p, (probe, error)): (usize, (&ballrace_scene::Probe, &ballrace_outcome::ReadingOutcome))| {
        let kind = ParameterKind::Offset(p);
        let (name, unit, size) = kind.name(scene);
        let value = probe.offset + 1e-6 * error.gap_um;
        let estimate = Estimate {
            name,
            unit,
            given: probe.offset / size,
            value: value / size,
            low: None,
            high: None,
            identified: true,
        };
        (estimate, parameter(kind, probe.offset), value)
    };
    probes.iter().zip(&found.errors).enumerate().map(of).collect()
}
