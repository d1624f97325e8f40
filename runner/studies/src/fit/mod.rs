//! Maximum-likelihood estimates of the scene's parameters from a recording.
//!
//! Angle and slip of the cages are estimated first, by the method of the diagnosis. Then the twin runs over the recording from an
//! unknown initial state. The fit minimises the sum of squares of the residuals at the probes, in units of their noise, over the
//! scene's unknowns and that state. Intervals are computed from the Jacobian and the residuals at the minimum, and are wider where the
//! residuals are correlated.

mod intervals;
pub mod parameters;
mod written;

use ballrace_base::least_squares::{self, Bounds, Limits};
use ballrace_base::statistics::{largest_chi_square, quantile};
use ballrace_diagnosis::{self as diagnosis, block::Block};
use ballrace_plant::error::{FitError, Result};
use ballrace_plant::motion::check_overflow;
use ballrace_plant::observer::noise;
use ballrace_plant::probes::reading;
use ballrace_plant::{Plant, only_observable, only_rotor};
use ballrace_recording::Reader;
use ballrace_recording::Sample;
use ballrace_recording::clock::check_rate;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_scene::{KeyphasorSignal, RotationSource, Scene};
use intervals::{covariance, expanded, unbalance};
use nalgebra::DMatrix;
use parameters::{Group, Parameter, ParameterKind, cage_parameters, parameters, with};
use serde::Serialize;
use std::cell::RefCell;
use std::time::{Duration, Instant};

pub use written::written;

/// Units of the unknowns of the initial state: m, rad, m/s, rad/s.
const STATE: [f64; 4] = [50e-6, 5e-4, 0.05, 0.5];
/// Largest posterior uncertainty of an identifiable parameter, over the prior one.
const IDENTIFIABLE: f64 = 0.3;
/// Fall of chi-squared in an iteration below which an early search ends.
const NEAR: f64 = 1.0;
/// The same for the last search.
const THERE: f64 = 0.05;
/// Longest step of a search, in prior standard deviations of an unknown.
const LONGEST_STEP: f64 = 10.0;
/// Largest number of iterations of the search over one part of the recording.
pub const MAX_ITERATIONS: usize = 40;

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

/// Progress of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitProgress {
    /// Iteration over this part of the recording, from 1; at most [`MAX_ITERATIONS`].
    pub iteration: usize,
    /// Number of shaft revolutions in this part of the recording.
    pub turns: f64,
    /// Number of shaft revolutions in all samples.
    pub all_turns: f64,
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
    /// Number of readings.
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

/// Samples of a recording.
#[derive(Debug)]
pub struct RecordingSamples {
    /// Samples of the fit.
    pub samples: Vec<Sample>,
    /// Consecutive samples with a reading of every probe, from which the cages are estimated.
    pub cage_samples: Vec<Sample>,
}

/// Reads the first `turns` turns of a recording, and as many as the cages need.
///
/// # Errors
/// Returns an error if the scene has no recording or the recording cannot be read.
pub fn read(scene: &Scene, mut reader: Reader, turns: f64) -> Result<RecordingSamples> {
    let Some(recording) = &scene.recording else {
        return Err(FitError::NoRecording { file: scene.path.clone() }.into());
    };
    let mut tracker = Tracker::of(recording, reader.rate(), scene.shaft.speed).with_run_out(RunOut::of(scene)?);
    let mut samples: Vec<Sample> = Vec::new();
    let mut block = Block::default();
    let mut row = tracker.blank();
    let long = |all: &[Sample]| match all {
        [first, .., last] => (turns_of(last) - turns_of(first)).abs() >= turns || all.len() >= MAX_SAMPLES,
        _ => false,
    };
    let mut take = |tracker: &mut Tracker, samples: &mut Vec<Sample>| {
        while let Some(sample) = tracker.pop() {
            if !block.is_full() {
                block.add(&sample);
            }
            if !long(samples) {
                samples.push(sample);
            }
        }
        block.is_full() && long(samples)
    };
    let (mut is_done, mut count) = (false, 0);
    while !is_done && count < MAX_SAMPLES * recording.average as usize && reader.next_row(&mut row)? {
        tracker.push(row)?;
        is_done = take(&mut tracker, &mut samples);
        row = tracker.blank();
        count += 1;
    }
    if !is_done {
        tracker.finish()?;
        take(&mut tracker, &mut samples);
    }
    Ok(RecordingSamples { samples, cage_samples: block.into_samples() })
}

const MAX_SAMPLES: usize = 1 << 17;
/// Turns of the first search.
const FIRST_TURNS: f64 = 0.5;
/// Turns from which all unknowns are free.
const EARLY_TURNS: f64 = 5.0;

/// Returns the unit of each entry of the first state.
fn state_units(plant: &Plant) -> Vec<f64> {
    let [position, tilt, rate, tilt_rate] = STATE;
    let of =
        |along: f64, about: f64| (0..plant.layout.order).map(move |i| if i == 3 || i == 4 { about } else { along });
    of(position, tilt).chain(of(rate, tilt_rate)).collect()
}

/// Unknowns that move together, at least one.
type Tied = Vec<usize>;

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
    let end = Instant::now().checked_add(plan.time_limit);
    let mut unknown = parameters(of.scene, &plant, plan.groups);
    let (Some(first), Some(recording)) = (of.samples.first(), &of.scene.recording) else {
        return Err(FitError::NoSample { recording: of.recording.to_owned() }.into());
    };
    if recording.probes.is_empty() {
        return Err(FitError::NoProbes { file: of.scene.path.clone() }.into());
    }
    if unknown.is_empty() {
        return Err(FitError::NothingToFit { file: of.scene.path.clone() }.into());
    }
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
    let (all_turns, time) = (turns.abs(), (plan.time_limit, end));
    let model = Model { of, plant: &plant, rows: &rows, sigma: &sigma, unknown: &unknown, prior: &at, all_turns, time };
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
    if let Some(still_falls) = solution.still_falls {
        return Err(model.not_converged(&solution, still_falls).into());
    }
    let covariance = expanded(&covariance(&solution, &model), &open, &identified);
    let found = model.judged(&solution, &covariance);
    let rms = |left: &[f64], p: usize| 1e6 * model.rms(left, p);
    let residual = |(p, probe): (usize, &ballrace_scene::Probe)| Residual {
        probe: probe.column.clone(),
        before_um: rms(&before, p),
        after_um: rms(&solution.residuals, p),
        noise_um: sigma[p] * 1e6,
    };
    let readings = of.samples.iter().flat_map(|s| &s.row.probes).filter(|x| x.is_finite()).count();
    let chi_square: f64 = probe_residuals(&solution, rows.len(), of).iter().map(|r| r * r).sum();
    let freedom = readings.saturating_sub(solution.x.len()).max(1) as f64;
    let chi_square_per_reading = chi_square / freedom;
    let largest_chi_square_per_reading = largest_chi_square(freedom);
    let consistent = chi_square_per_reading <= largest_chi_square_per_reading;
    let interval = |end: Option<f64>| end.filter(|_| consistent);
    let parameters = found.parameters.into_iter();
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
        notes: [notes, found.notes].concat(),
        residuals: recording.probes.iter().enumerate().map(residual).collect(),
        ..found
    })
}

/// Cages of a scene as estimated from the recording.
struct Cages {
    /// Angle and speed ratio of the observable ones.
    parameters: Vec<Parameter>,
    /// The scene with them.
    scene: Scene,
    /// Which cages are not estimated, with the reason.
    notes: Vec<String>,
}

/// Estimates the cages by the method of the diagnosis.
fn cages(of: &FitInput, plant: &Plant) -> Result<Cages> {
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

/// Unknowns where a search over a part of the recording has ended.
struct Found {
    /// All unknowns.
    x: Vec<f64>,
    /// Residuals of the probes and of the priors.
    residuals: Vec<f64>,
    /// Weight of the priors.
    weight: f64,
    /// Relative fall of the sum of squares in the last iteration, where the search has ended before a minimum.
    still_falls: Option<f64>,
}

/// A solution with its slopes.
struct Solution {
    x: Vec<f64>,
    residuals: Vec<f64>,
    jacobian: DMatrix<f64>,
    still_falls: Option<f64>,
}

/// Returns the residuals at the probes, without the priors.
fn probe_residuals<'s>(solution: &'s Solution, probes: usize, of: &FitInput) -> &'s [f64] {
    solution.residuals.get(..probes * of.samples.len()).unwrap_or_default()
}

fn turns_of(sample: &Sample) -> f64 {
    sample.total_revolutions()
}

/// Returns all unknowns from the free ones; the others are those of `from`.
fn whole(x: &[f64], from: &[f64], free: &[Tied]) -> Vec<f64> {
    let mut all = from.to_vec();
    free.iter().zip(x).for_each(|(tied, x)| tied.iter().for_each(|&i| all[i] = *x));
    all
}

#[derive(Clone, Copy)]
struct Model<'a> {
    of: &'a FitInput<'a>,
    /// Plant of the scene: those of the search have its coordinates.
    plant: &'a Plant,
    rows: &'a [Vec<f64>],
    sigma: &'a [f64],
    unknown: &'a [Parameter],
    /// Prior mean of every unknown, each with a standard deviation of 1.
    prior: &'a [f64],
    /// Number of shaft revolutions in all samples of the fit.
    all_turns: f64,
    /// Time of the fit, and its end; `None` where no clock reaches it.
    time: (Duration, Option<Instant>),
}

impl Model<'_> {
    fn values(&self, x: &[f64]) -> Vec<f64> {
        self.unknown.iter().zip(x).map(|(p, x)| p.value(*x)).collect()
    }

    /// Fits a short part of the recording first, then twice as much each time. Over a long part, an error of a natural
    /// frequency shifts the phase by whole periods, and each period is a local minimum. On the first parts the offsets of
    /// the probes, the damping and the cages are fixed and the stiffness of all contacts has a common factor: freed too early, they
    /// diverge.
    fn search(&self, progress: &mut dyn FnMut(FitProgress)) -> Result<Solution> {
        let first = self.of.samples.first().map_or(0.0, turns_of);
        let all: Vec<Tied> = (0..self.prior.len()).map(|i| vec![i]).collect();
        let early = self.early();
        let (mut at, mut turns) = (self.prior.to_vec(), FIRST_TURNS);
        loop {
            let count = self.of.samples.iter().take_while(|s| (turns_of(s) - first).abs() < turns).count();
            if count == self.of.samples.len() {
                return self.solution(&at, &all, progress);
            }
            let short = FitInput { samples: self.of.samples.get(..count).unwrap_or_default(), ..*self.of };
            let free = if turns < EARLY_TURNS { &early } else { &all };
            at = Model { of: &short, ..*self }.stage(&at, free, NEAR, progress)?.x;
            turns *= 2.0;
        }
    }

    fn early(&self) -> Vec<Tied> {
        let kind = |i: &usize| self.unknown.get(*i).map(|p| p.kind);
        let stiffness = |i: &usize| matches!(kind(i), Some(ParameterKind::Modulus(_) | ParameterKind::Stiffness(_)));
        let late = |i: &usize| {
            use ParameterKind::{CageAngle, CageRatio, Damping, Offset};
            matches!(kind(i), Some(Damping(_) | Offset(_) | CageAngle(_) | CageRatio(_)))
        };
        let indices = 0..self.prior.len();
        let mut free: Vec<Tied> = indices.clone().filter(|i| !late(i) && !stiffness(i)).map(|i| vec![i]).collect();
        free.extend(Some(indices.filter(stiffness).collect::<Tied>()).filter(|tied| !tied.is_empty()));
        free
    }

    /// Fits the unknowns `free` until the fall is negligible.
    fn solution(&self, start: &[f64], free: &[Tied], progress: &mut dyn FnMut(FitProgress)) -> Result<Solution> {
        let Found { x, residuals, weight, still_falls } = self.stage(start, free, THERE, progress)?;
        let bounds: Vec<Bounds> = free.iter().map(|tied| self.bounds(tied)).collect();
        let at: Vec<f64> = free.iter().map(|tied| x[tied[0]]).collect();
        let of = |free_x: &[f64]| self.weighted_residuals(&whole(free_x, &x, free), weight);
        Ok(Solution { jacobian: least_squares::jacobian(&at, &bounds, &of)?, x, residuals, still_falls })
    }

    /// Fits the unknowns `free` in at most [`MAX_ITERATIONS`]. While residuals are large, the prior has the same weight as the residuals.
    fn stage(
        &self,
        start: &[f64],
        free: &[Tied],
        least_fall: f64,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<Found> {
        let turns = self.turns();
        let mut x = start.to_vec();
        let mut last = f64::INFINITY;
        let mut made = 0;
        let report = RefCell::new(progress);
        loop {
            let left = self.residuals(&x)?;
            let weight = (left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64).sqrt().max(1.0);
            let residuals = |free_x: &[f64]| self.weighted_residuals(&whole(free_x, &x, free), weight);
            let from: Vec<f64> = free.iter().map(|tied| x[tied[0]]).collect();
            let bounds = free.iter().map(|tied| self.bounds(tied)).collect();
            let limits = Limits { bounds, longest_step: LONGEST_STEP, iterations: MAX_ITERATIONS - made, least_fall };
            let report = |i: usize| {
                let mut report = report.borrow_mut();
                report(FitProgress { iteration: made + i + 1, turns, all_turns: self.all_turns });
            };
            let found = least_squares::solve(&from, &limits, &residuals, &report)?;
            made += found.iterations;
            x = whole(&found.point.x, &x, free);
            if weight > 0.7 * last || weight <= 1.0 || made >= MAX_ITERATIONS {
                let residuals = found.point.residuals;
                return Ok(Found { x, residuals, weight, still_falls: found.still_falls });
            }
            last = weight;
        }
    }

    /// Returns the residuals with those of the priors, each with a weight.
    fn weighted_residuals(&self, x: &[f64], weight: f64) -> Result<Vec<f64>> {
        let mut left = self.residuals(x)?;
        left.extend(x.iter().zip(self.prior).map(|(x, prior)| weight * (x - prior)));
        Ok(left)
    }

    /// Returns the error that a search over all samples ended at its largest number of iterations, with the probe that leaves most.
    fn not_converged(&self, found: &Solution, still_falls: f64) -> FitError {
        let rms = |p: usize| self.rms(&found.residuals, p);
        let share = |p: &usize| rms(*p) / self.sigma[*p];
        let worst = (0..self.rows.len()).max_by(|a, b| share(a).total_cmp(&share(b))).unwrap_or(0);
        let probes = self.of.scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
        FitError::NotConverged {
            recording: self.of.recording.to_owned(),
            iterations: MAX_ITERATIONS,
            still_falls,
            probe: probes.get(worst).map_or_else(String::new, |probe| probe.column.clone()),
            left_um: 1e6 * rms(worst),
            noise_um: 1e6 * self.sigma.get(worst).copied().unwrap_or(0.0),
        }
    }

    /// Returns the error that the time has ended.
    fn too_long(&self) -> FitError {
        FitError::TooLong {
            recording: self.of.recording.to_owned(),
            limit_s: self.time.0.as_secs_f64(),
            turns: self.turns(),
            all_turns: self.all_turns,
        }
    }

    /// Returns the rms of the residuals `left` at probe `p`, m.
    fn rms(&self, left: &[f64], p: usize) -> f64 {
        let own = left.iter().take(self.of.samples.len() * self.rows.len()).skip(p).step_by(self.rows.len());
        (own.clone().map(|r| r * r).sum::<f64>() / own.count().max(1) as f64).sqrt() * self.sigma[p]
    }

    /// Returns the number of shaft revolutions in the samples.
    fn turns(&self) -> f64 {
        match self.of.samples {
            [first, .., last] => (turns_of(last) - turns_of(first)).abs(),
            _ => 0.0,
        }
    }

    /// Returns the bounds of unknowns that move together: the intersection of their bounds.
    fn bounds(&self, tied: &Tied) -> Bounds {
        let each = tied.iter().filter_map(|&i| self.unknown.get(i)).map(Parameter::unknown_bounds);
        each.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [a, b]| [low.max(a), high.min(b)])
    }

    /// Computes the residuals by sample and probe, in units of the probes' noise; 0 for a missing reading.
    ///
    /// After the end of the time it is an error. A search takes that at a trial step for a bad step, and at the slopes it ends.
    fn residuals(&self, x: &[f64]) -> Result<Vec<f64>> {
        if self.time.1.is_some_and(|end| Instant::now() > end) {
            return Err(self.too_long().into());
        }
        let (values, state) = (self.values(x), x.get(self.unknown.len()..).unwrap_or_default());
        let scene = with(self.of.scene, self.unknown, &values);
        let plant = Plant::alike(&scene, self.plant)?;
        let probes = scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
        let given = self.of.scene.recording.as_ref().map(|r| r.probes.as_slice()).unwrap_or_default();
        let Some(first) = self.of.samples.first() else { return Ok(vec![]) };
        let mut twin = plant.start(self.of.period, turns_of(first))?;
        let first_state: Vec<f64> = state.iter().zip(state_units(&plant)).map(|(x, unit)| x * unit).collect();
        let (q, rate) = first_state.split_at(first_state.len() / 2);
        twin.place(q, rate);
        let mut left = Vec::with_capacity(self.of.samples.len() * self.rows.len());
        for (i, sample) in self.of.samples.iter().enumerate() {
            let coordinates = twin.coordinates();
            for (p, (row, measured)) in self.rows.iter().zip(&sample.row.probes).enumerate() {
                // The reader has already subtracted the scene's own offset.
                let more = probes[p].offset - given[p].offset;
                let off = (measured - more - reading(row, coordinates)) / self.sigma[p];
                left.push(if off.is_finite() { off.clamp(-1e6, 1e6) } else { 0.0 });
            }
            let steps = self.of.samples.get(i + 1).map_or(0, |next| next.row.index - sample.row.index);
            let drive = sample.shaft_motion();
            for k in 0..steps {
                let is_held = twin.step(&drive.after(k as f64 * self.of.period)).is_held();
                let time = (sample.row.index + k + 1) as f64 * self.of.period;
                check_overflow((&plant, self.of.period), (twin.as_ref(), is_held), time)?;
            }
        }
        Ok(left)
    }

    /// Returns values with their intervals, and the parameters that are not identifiable.
    fn judged(&self, solution: &Solution, covariance: &DMatrix<f64>) -> Fitted {
        let scene = self.of.scene;
        let n = self.unknown.len();
        // Simultaneous 95 % intervals (Bonferroni).
        let z = quantile(0.025 / n as f64);
        let values = self.values(&solution.x);
        let (mut all, mut notes) = (Vec::new(), Vec::new());
        let index = |wanted: ParameterKind| self.unknown.iter().position(|p| p.kind == wanted);
        let mut one_plane = false;
        if let (Some(e), Some(c)) = (index(ParameterKind::Unbalance(0)), index(ParameterKind::Couple(0))) {
            let angle_step = self.angle_step();
            let (more, single) =
                unbalance(&values, covariance, self.unknown, [e, c], z, angle_step, scene.drawn_station(0.0));
            // A flexible rotor bends differently under the same sum and couple in another plane.
            one_plane = single && scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_none());
            all.extend(more);
        }
        for (i, parameter) in self.unknown.iter().enumerate() {
            if matches!(parameter.kind, ParameterKind::Unbalance(_) | ParameterKind::Couple(_)) {
                continue;
            }
            let (name, unit, size) = parameter.kind.name(scene);
            let mut reach = z * covariance[(i, i)].max(0.0).sqrt();
            if let ParameterKind::CageAngle(b) = parameter.kind {
                // The cage turns with the shaft, whose angle is known to the resolution of the keyphasor: an error that is the
                // same in all readings.
                let ratio = scene.bearings.get(b).and_then(|b| b.cage_ratio).unwrap_or(0.0);
                reach += ratio * self.angle_step() / parameter.scale;
            }
            let identified = self.identified(covariance, i);
            if !identified {
                notes.push(format!(
                    "{name} is not identifiable from this recording: {:.0} % of the prior uncertainty remains{}. The scene's value is kept.",
                    100.0 * reach / z,
                    self.partner(covariance, i).map_or_else(String::new, |other| format!("; it is correlated with {other}"))
                ));
            }
            all.push(Estimate {
                name,
                unit,
                given: parameter.given / size,
                value: values[i] / size,
                low: Some(parameter.value(solution.x[i] - reach) / size),
                high: Some(parameter.value(solution.x[i] + reach) / size),
                identified,
            });
        }
        let kept = |i: usize| {
            let parameter = &self.unknown[i];
            let identified = self.identified(covariance, i);
            (parameter.clone(), if identified { values[i] } else { parameter.start })
        };
        Fitted {
            scene: String::new(),
            recording: String::new(),
            samples: 0,
            turns: 0.0,
            chi_square: 0.0,
            readings: 0,
            chi_square_per_reading: 0.0,
            largest_chi_square_per_reading: 0.0,
            consistent: true,
            residuals: vec![],
            parameters: all,
            notes,
            values: (0..n).map(kept).collect(),
            one_plane,
        }
    }

    /// Returns true if the posterior uncertainty is below [`IDENTIFIABLE`] of the prior one. Unbalance is always identified, and so
    /// are cages, which are free only if they are observable.
    fn identified(&self, covariance: &DMatrix<f64>, i: usize) -> bool {
        use ParameterKind::{CageAngle, CageRatio, Couple, Unbalance};
        let always = matches!(self.unknown[i].kind, Unbalance(_) | Couple(_) | CageAngle(_) | CageRatio(_));
        always || covariance[(i, i)].max(0.0).sqrt() < IDENTIFIABLE
    }

    /// Returns the other unknown with the largest correlation with unknown `i`, where it is above 0.7.
    fn partner(&self, covariance: &DMatrix<f64>, i: usize) -> Option<String> {
        let correlation = |j: usize| (covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()).abs();
        let others = (0..self.unknown.len()).filter(|&j| j != i);
        let best = others.max_by(|&a, &b| correlation(a).total_cmp(&correlation(b)))?;
        (correlation(best) > 0.7).then(|| self.unknown[best].kind.name(self.of.scene).0)
    }

    /// Returns half the angular resolution of a keyphasor sampled as 0 and 1, rad.
    fn angle_step(&self) -> f64 {
        let keyphasor = self.of.scene.recording.as_ref().map(|r| &r.rotation);
        let speed = self.of.samples.first().map_or(0.0, |s| s.speed.abs());
        match keyphasor {
            Some(RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. }) => 0.0,
            Some(RotationSource::Keyphasor { .. }) => 0.5 * speed * self.of.period,
            _ => 0.0,
        }
    }
}
