//! Maximum-likelihood estimates of the scene's parameters from a recording.
//!
//! A recording of a site, whose readings have errors that no machine of the scene explains, is compared line by line (`site`). For another one,
//! angle and slip of the cages are estimated first, by the method of the diagnosis. Then the twin runs over the recording from an
//! unknown initial state. The fit minimises the sum of squares of the residuals at the probes, in units of their noise, over the
//! scene's unknowns and that state. Intervals are computed from the Jacobian and the residuals at the minimum, and are wider where the
//! residuals are correlated.

mod cages;
mod estimates;
mod intervals;
mod model;
pub mod parameters;
mod read;
mod search;
mod site;
mod written;

use ballrace_base::statistics::largest_chi_square;
use ballrace_base::time_limit::TimeLimit;
use ballrace_outcome::ReadingOutcome;
use ballrace_plant::error::{FitError, Result};
use ballrace_plant::observer::noise;
use ballrace_plant::{Plant, only_observable, only_rotor};
use ballrace_recording::Reader;
use ballrace_recording::Sample;
use ballrace_recording::clock::check_rate;
use ballrace_scene::Scene;
use cages::{Cages, cages};
use estimates::Estimates;
use intervals::{covariance, expanded};
use model::{Model, state_units};
use parameters::{Group, Parameter, ParameterKind, parameters};
use search::{Tied, probe_residuals};
use serde::Serialize;
use site::AtSite;
use std::time::Duration;

pub use read::{RecordingSamples, read};
pub use search::FitProgress;
pub use written::written;

/// Parameters, part of the recording and time of a fit.
#[derive(Debug, Clone, Copy)]
pub struct FitPlan<'a> {
    /// Groups of the scene's numbers that are fitted.
    pub groups: &'a [Group],
    /// Number of shaft revolutions used, from the start of the recording.
    pub turns: f64,
    /// Time after which the fit is given up.
    pub time_limit: Duration,
}

/// A scene fitted to a recording.
#[derive(Debug, Clone, Serialize)]
pub struct Fitted {
    /// Name of the scene.
    pub scene: String,
    /// Name of the recording.
    pub recording: String,
    /// Samples that were used.
    pub samples: usize,
    /// Number of shaft revolutions in the samples.
    pub turns: f64,
    /// Sum of the squared residuals in units of the probes' noise: about the number of readings where the scene is true.
    pub chi_square: f64,
    /// Number of readings; at a site, of values of their spectra.
    pub readings: usize,
    /// Chi-squared per degree of freedom (readings less unknowns), about 1 where the scene is true.
    pub chi_square_per_reading: f64,
    /// Largest chi-squared per reading by noise alone.
    pub largest_chi_square_per_reading: f64,
    /// True if chi-squared per reading is at most `largest_chi_square_per_reading`; if false, no interval is given.
    pub consistent: bool,
    /// Residual at each probe before and after the fit, um rms.
    pub residuals: Vec<Residual>,
    /// Estimates.
    pub parameters: Vec<Estimate>,
    /// Errors of the readings that are no parameters of the scene, at a site.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ReadingOutcome>,
    /// Cages that are not estimated and parameters that are not identifiable, with the reason.
    pub notes: Vec<String>,
    /// Values to write, SI.
    #[serde(skip)]
    values: Vec<(Parameter, f64)>,
    #[serde(skip)]
    one_plane: bool,
}

/// Residual at one probe.
#[derive(Debug, Clone, Serialize)]
pub struct Residual {
    /// Column of the probe.
    pub probe: String,
    /// With the scene's values and the estimated cages.
    pub before_um: f64,
    /// With the fitted values.
    pub after_um: f64,
    /// Noise of the probe.
    pub noise_um: f64,
}

/// Estimate of one parameter.
#[derive(Debug, Clone, Serialize)]
pub struct Estimate {
    /// Name in the scene.
    pub name: String,
    /// Unit of all values.
    pub unit: &'static str,
    /// The scene's value.
    pub given: f64,
    /// The fitted value.
    pub value: f64,
    /// Lower end of its interval; `None` if [`Fitted::consistent`] is false.
    pub low: Option<f64>,
    /// Upper end, as `low`.
    pub high: Option<f64>,
    /// True where the recording identifies the parameter.
    pub identified: bool,
}

/// Data of the fit.
#[derive(Clone, Copy)]
pub struct FitInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Name of its recording.
    pub recording: &'a str,
    /// The samples, in order.
    pub samples: &'a [Sample],
    /// Consecutive samples with a reading of every probe, from which the cages are estimated.
    pub cage_samples: &'a [Sample],
    /// Sample period, s.
    pub period: f64,
}

/// Fits the scene's numbers of a `plan` to a recording with the name `recording`; calls `progress` before each iteration.
///
/// # Errors
/// Returns the errors of [`read`] and [`fit`].
pub fn fit_recording(
    scene: &Scene,
    reader: Reader,
    recording: &str,
    plan: &FitPlan,
    progress: &mut dyn FnMut(FitProgress),
) -> Result<Fitted> {
    let average = scene.recording.as_ref().map_or(1, |recording| recording.average);
    if let Some(keys) = &scene.recording {
        check_rate(reader.rate(), keys, scene.shaft.speed).map_err(|e| e.of(scene, recording))?;
    }
    let rate = reader.rate() / f64::from(average);
    let RecordingSamples { samples, cage_samples } = read(scene, reader, plan.turns)?;
    fit(
        &FitInput { scene, recording, samples: &samples, cage_samples: &cage_samples, period: 1.0 / rate },
        plan,
        progress,
    )
}

/// Fits the scene's numbers of a `plan`; calls `progress` before each iteration.
///
/// # Errors
/// Returns an error if the scene has no rotor, no probes or no parameter to fit, if there is no sample, if the kernel rejects a
/// parameter, or if the search does not converge in its iterations and its time.
pub fn fit(of: &FitInput, plan: &FitPlan, progress: &mut dyn FnMut(FitProgress)) -> Result<Fitted> {
    only_rotor(of.scene, "fit")?;
    only_observable(of.scene, "fit")?;
    let plant = Plant::try_new(of.scene)?;
    let time_limit = TimeLimit::start(plan.time_limit);
    let mut unknown = parameters(of.scene, &plant, plan.groups);
    let (Some(_), Some(recording)) = (of.samples.first(), &of.scene.recording) else {
        return Err(FitError::NoSample { recording: of.recording.to_owned() }.into());
    };
    if recording.probes.is_empty() {
        return Err(FitError::NoProbes { file: of.scene.path.clone() }.into());
    }
    if unknown.is_empty() {
        return Err(FitError::NothingToFit { file: of.scene.path.clone() }.into());
    }
    let at_site = match site::fitted(of, &plant, (plan.groups, time_limit), progress)? {
        Some(AtSite { fitted, is_clear: true }) => return Ok(fitted),
        other => other.map(|other| other.fitted).filter(|fitted| fitted.consistent),
    };
    // Far from the offsets, a search along the time ends in another minimum.
    for (known, value) in at_site.iter().flat_map(|at_site| &at_site.values) {
        let is_offset = |own: &&mut Parameter| own.kind == known.kind && matches!(own.kind, ParameterKind::Offset(_));
        unknown.iter_mut().filter(is_offset).for_each(|own| own.start = *value);
    }
    match (along_time(of, plant, unknown, time_limit, progress), at_site) {
        (Ok(fitted), Some(at_site)) => Ok(if fitted.consistent { fitted } else { at_site }),
        (Err(_), Some(at_site)) => Ok(at_site),
        (found, _) => found,
    }
}

/// Fits the unknowns to the readings, sample by sample.
fn along_time(
    of: &FitInput,
    plant: Plant,
    mut unknown: Vec<Parameter>,
    time_limit: TimeLimit,
    progress: &mut dyn FnMut(FitProgress),
) -> Result<Fitted> {
    let (Some(first), Some(recording)) = (of.samples.first(), &of.scene.recording) else {
        return Err(FitError::NoSample { recording: of.recording.to_owned() }.into());
    };
    let Cages { parameters: of_cages, scene, notes } = cages(of, &plant)?;
    unknown.extend(of_cages);
    let plant = Plant::try_new(&scene)?;
    let of = &FitInput { scene: &scene, ..*of };
    let rows: Vec<Vec<f64>> = recording.probes.iter().map(|probe| plant.layout.probe_row(probe)).collect();
    let sigma: Vec<f64> = (0..rows.len()).map(|p| noise(of.samples, p, recording.probes[p].noise)).collect();
    let total = turns_of(first);
    let drive = first.shaft_motion();
    let twin = plant.run_in(of.period, total, &drive)?;
    let start = [twin.coordinates(), twin.rates()].concat();
    let given: Vec<f64> = unknown.iter().map(Parameter::prior_mean).collect();
    let state: Vec<f64> = start.iter().zip(state_units(&plant)).map(|(x, unit)| x / unit).collect();
    let at = [given, state].concat();
    let last = of.samples.last().unwrap_or(first);
    let turns = turns_of(last) - total;
    let all_turns = turns.abs();
    let model =
        Model { of, plant: &plant, rows: &rows, sigma: &sigma, unknown: &unknown, prior: &at, all_turns, time_limit };
    let before = model.residuals(&at)?;
    let everything = model.search(progress)?;
    let open = covariance(&everything, &model);
    let identified: Vec<usize> =
        (0..everything.x.len()).filter(|&i| i >= unknown.len() || model.identified(&open, i)).collect();
    // Parameters that are not identifiable return to the scene's value; the others are fitted again.
    let mut at = everything.x.clone();
    (0..at.len()).filter(|i| !identified.contains(i)).for_each(|i| at[i] = model.prior[i]);
    let free: Vec<Tied> = identified.iter().map(|&i| vec![i]).collect();
    let solution = if identified.len() < at.len() { model.solution(&at, &free, progress)? } else { everything };
    let rms = |left: &[f64], p: usize| 1e6 * model.rms(left, p);
    let residual = |(p, probe): (usize, &ballrace_scene::Probe)| Residual {
        probe: probe.column.clone(),
        before_um: rms(&before, p),
        after_um: rms(&solution.residuals, p),
        noise_um: sigma[p] * 1e6,
    };
    let residuals: Vec<Residual> = recording.probes.iter().enumerate().map(residual).collect();
    if let Some(still_falls) = solution.still_falls {
        return Err(not_converged(of, search::reason(still_falls), &residuals).into());
    }
    let covariance = expanded(&covariance(&solution, &model), &open, &identified);
    let estimates = model.estimates(&solution, &covariance);
    let readings = of.samples.iter().flat_map(|s| &s.row.probes).filter(|x| x.is_finite()).count();
    let chi_square: f64 = probe_residuals(&solution, rows.len(), of).iter().map(|r| r * r).sum();
    let freedom = readings.saturating_sub(solution.x.len()).max(1) as f64;
    let chi_square_per_reading = chi_square / freedom;
    let largest_chi_square_per_reading = largest_chi_square(freedom);
    let consistent = chi_square_per_reading <= largest_chi_square_per_reading;
    let interval = |end: Option<f64>| end.filter(|_| consistent);
    let Estimates { parameters, notes: not_identified, values, one_plane } = estimates;
    let parameters = parameters.into_iter();
    let parameters = parameters.map(|p| Estimate { low: interval(p.low), high: interval(p.high), ..p }).collect();
    Ok(Fitted {
        scene: scene.name.clone(),
        recording: of.recording.to_owned(),
        samples: of.samples.len(),
        turns,
        chi_square,
        readings,
        chi_square_per_reading,
        largest_chi_square_per_reading,
        consistent,
        parameters,
        errors: vec![],
        notes: [notes, not_identified].concat(),
        residuals,
        values,
        one_plane,
    })
}

/// Returns the error that a search ended before a minimum for a reason, with the probe that leaves most over its noise.
fn not_converged(of: &FitInput, reason: String, residuals: &[Residual]) -> FitError {
    let share = |probe: &&Residual| probe.after_um / probe.noise_um;
    let worst = residuals.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
    FitError::NotConverged {
        recording: of.recording.to_owned(),
        reason,
        probe: worst.map_or_else(String::new, |probe| probe.probe.clone()),
        left_um: worst.map_or(0.0, |probe| probe.after_um),
        noise_um: worst.map_or(0.0, |probe| probe.noise_um),
    }
}

fn turns_of(sample: &Sample) -> f64 {
    sample.total_revolutions()
}
