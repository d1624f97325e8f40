//! Calibration: parameters of a scene fitted to a recording of the healthy machine.

use super::cage::SLIPS;
use super::faults::{CLEARANCE, COUPLE, LEAST_COUPLE, UNBALANCE};
use super::fit::{Fitted, Limits, MODEL_ERROR, Prior, changed, evaluate, fit_whole};
use super::machine::Machine;
use super::parameter::{DAMPING, MODULUS, Unknown};
use super::residual::Evidence;
use super::residual::site::{DEPENDENT, GAIN_ERROR, UNEXPLAINED};
use super::site::{SiteRecording, UNBALANCE_ERROR};
use super::{Prepared, Result, SHOWN_GAP, cage};
use ballrace_base::statistics::{largest_chi_square, quantile};
use ballrace_base::time_limit::TimeLimit;
use ballrace_outcome::{
    CalibratedParameter, Calibration, LearnedParameter, Learning, ParameterName, ProbeReadings, ReadingOutcome,
};
use ballrace_scene::Scene;
use nalgebra::{DMatrix, DVector};

/// Clearances that are tried where a bearing carries no load, over that of the scene.
const SMALLER_CLEARANCES: [f64; 12] = [0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.45, 0.4];
/// Largest number of rounds of fit, weighting and search of the cages.
pub const MAX_ROUNDS: usize = 16;
/// Precision of the prior until the last fit, over that of the scene: on the way to the minimum the damping may be far from both.
const LOOSE: f64 = 0.25;
/// Relative standard deviation of a damping from which it keeps its earlier value.
const VAGUE: f64 = 0.1;
/// Iterations of a fit: while the cages are false, a fit that converges adapts the other parameters to them.
const ITERATIONS: usize = 8;
/// Fall of chi-squared in a round, over its excess and its standard deviation by noise, below which Young's modulus is fitted as well: far
/// from the recording, the other parameters explain it nearly as well, and with a false cage it leaves for a minimum from which the cage is
/// not found.
const SETTLED: f64 = 0.1;
/// The same, below which the calibration ends.
const DONE: f64 = 0.01;

/// Rounds after which chi-squared per value is at most so much, or the calibration ends early.
const HOPEFUL: (usize, f64) = (3, 6.0);

/// Least gap of a site, m: the parameters of a machine are fitted so that they leave less of a position.
pub(super) const LEAST_GAP: f64 = 1.5e-6;

/// Lines that the machine of a site leaves at each probe on average, at least: the same machine without imperfections leaves two at most.
const LEFT_LINES: usize = 3;

/// Distance of two lines that are one, in orders of the shaft.
const SAME_LINE: f64 = 0.02;

/// Share of machines of the scene of which a learned parameter is called unlikely, all parameters together.
const UNLIKELY: f64 = 1e-3;
/// Share of machines of which an interval does not contain the true parameter, all parameters together.
const MISSED: f64 = 0.05;

/// A calibration with the number of values of its residual.
#[derive(Debug)]
pub struct Calibrated {
    /// The calibration.
    pub calibration: Calibration,
    /// Number of values of the residual.
    pub values: usize,
    /// Number of rounds.
    pub rounds: usize,
    /// Reason why the search does not converge; none where it does.
    pub not_converged: Option<String>,
    /// True where it ended after a few rounds that led to nothing.
    pub(crate) ended_early: bool,
    /// True where the readings have the errors of a site.
    pub(crate) shows_errors: bool,
    /// True where these are larger than a fault may pretend.
    pub(crate) shows_site: bool,
    /// True where neither a slow roll nor a baseline tells the run-out from what an unbalance does.
    pub has_unknown_run_out: bool,
    /// Errors of the readings of a site beyond those of a baseline; nothing where the readings are the motion of the shaft alone.
    pub errors: Vec<ReadingOutcome>,
    /// What the machine before and after the calibration does not explain at each probe, besides the errors of the readings, m rms.
    pub unexplained_rms: [Vec<f64>; 2],
}

/// Parameters, bounds and progress of a calibration.
pub struct CalibrationPlan<'a> {
    /// Parameters that are calibrated; the others keep the scene's values.
    pub parameters: &'a [ParameterName],
    /// Receives the number of each round before it, from 1; at most [`MAX_ROUNDS`].
    pub begin: &'a dyn Fn(usize),
    /// Time after which the calibration is given up; none without a limit.
    pub time_limit: Option<TimeLimit>,
}

/// Returns the name in a table, the unit there, and its size in SI.
const fn printed_name(name: ParameterName) -> (&'static str, &'static str, f64) {
    match name {
        ParameterName::DiametralClearance => ("diametral_clearance", "um", 1e-6),
        ParameterName::YoungsModulus => ("youngs_modulus", "GPa", 1e9),
        ParameterName::TranslationDamping => ("damping of translations", "N s/m", 1.0),
        ParameterName::RotationDamping => ("damping of tilt", "N m s/rad", 1.0),
        ParameterName::UnbalanceX => ("unbalance along X", "g mm", 1e-6),
        ParameterName::UnbalanceY => ("unbalance along Y", "g mm", 1e-6),
        ParameterName::CoupleX => ("unbalance couple along X", "g mm^2", 1e-9),
        ParameterName::CoupleY => ("unbalance couple along Y", "g mm^2", 1e-9),
    }
}

/// Parameters of the rotor.
const OF_ROTOR: [(ParameterName, Unknown); 6] = [
    (ParameterName::TranslationDamping, DAMPING.of_rotor(0)),
    (ParameterName::RotationDamping, DAMPING.of_rotor(1)),
    (ParameterName::UnbalanceX, UNBALANCE.of_rotor(0)),
    (ParameterName::UnbalanceY, UNBALANCE.of_rotor(1)),
    (ParameterName::CoupleX, COUPLE.of_rotor(0)),
    (ParameterName::CoupleY, COUPLE.of_rotor(1)),
];

/// Returns the relative standard deviation of a scene's value; `None` where the scene's value has no relation to the machine.
///
/// Young's modulus of bearing steels differs by 2 %, with catalogue dimensions the stiffness by 5 %; a clearance class spans a
/// factor of two; damping is seldom measured; rotors are rebalanced.
fn scene_deviation(name: ParameterName) -> Option<f64> {
    match name {
        ParameterName::YoungsModulus => Some(0.05),
        ParameterName::DiametralClearance => Some(0.3),
        ParameterName::TranslationDamping | ParameterName::RotationDamping => Some(0.5),
        ParameterName::UnbalanceX | ParameterName::UnbalanceY | ParameterName::CoupleX | ParameterName::CoupleY => None,
    }
}

/// Returns the parameters of bearing `b`.
fn of_bearing(b: usize) -> [(ParameterName, Unknown); 2] {
    [
        (ParameterName::DiametralClearance, CLEARANCE.of_bearing(b)),
        (ParameterName::YoungsModulus, MODULUS.of_bearing(b)),
    ]
}

/// Returns all parameters of a machine, with the bearing of each.
fn parameters(machine: &Machine) -> Vec<(ParameterName, Option<usize>, Unknown)> {
    let of_bearings = machine.bearings.iter().enumerate().flat_map(|(b, bearing)| {
        // Rollers have a clearance and no modulus of their own.
        let exists = |unknown: &Unknown| bearing.scene.geometry.is_some() || unknown.get(machine) > 0.0;
        let own = of_bearing(b).into_iter().filter(move |(_, unknown)| exists(unknown));
        own.map(move |(parameter, unknown)| (parameter, Some(b), unknown))
    });
    let of_rotor = OF_ROTOR.into_iter().map(|(parameter, unknown)| (parameter, None, unknown));
    // Damping that the scene does not have stays 0.
    let exists = |unknown: &Unknown| !unknown.is(&DAMPING) || unknown.get(machine) > 0.0;
    of_bearings.chain(of_rotor).filter(|(.., unknown)| exists(unknown)).collect()
}

impl Calibrated {
    /// Returns the largest chi-squared per value of a recording that the machine explains.
    #[must_use]
    pub fn largest_chi_square_per_value(&self) -> f64 {
        let noise = largest_chi_square(self.values.max(1) as f64) + MODEL_ERROR;
        // At a site the noise contains what is expected.
        if self.calibration.readings.is_empty() { noise } else { noise.max(UNEXPLAINED) }
    }

    /// Returns true where the search has converged on a machine that explains the recording.
    #[must_use]
    pub fn explains(&self) -> bool {
        // NaN is no chi-squared of a machine.
        self.not_converged.is_none() && self.calibration.chi_square_per_value <= self.largest_chi_square_per_value()
    }

    /// Returns true where the machine leaves more lines of the readings than noise and small errors of its parameters do: sound bearings are not
    /// those of the scene.
    #[must_use]
    pub fn leaves_lines(&self) -> bool {
        let readings = &self.calibration.readings;
        readings.iter().map(|probe| probe.lines.len()).sum::<usize>() >= LEFT_LINES * readings.len()
    }

    /// Returns the factor from the standard deviation of a parameter, with the run-out as it is stored beside it, to that with any run-out.
    fn with_any_run_out(&self, name: ParameterName) -> f64 {
        // The prior of an unbalance is narrowed by as much.
        if self.has_unknown_run_out && scene_deviation(name).is_none() { DEPENDENT.sqrt() } else { 1.0 }
    }

    /// Returns the standard deviation of the parameter with an index, whatever the run-out is.
    #[must_use]
    pub fn deviation(&self, i: usize) -> f64 {
        self.calibration.parameters.get(i).map_or(0.0, |of| of.deviation * self.with_any_run_out(of.name))
    }

    /// Returns the standard deviation of the parameter with an index before the recording, by its value in the scene, SI; `None` where nothing
    /// is known.
    #[must_use]
    pub fn scene_deviation(&self, i: usize, given: f64) -> Option<f64> {
        let known = scene_deviation(self.calibration.parameters.get(i)?.name)? * given.abs();
        (known > 0.0).then_some(known)
    }

    /// Returns the calibration compared with its scene, and with the noise of the probes by its residual.
    #[must_use]
    pub fn learning(&self, scene: &Scene) -> Learning {
        let (taken, largest) = (self.explains(), self.largest_chi_square_per_value());
        let mut learning = Learning {
            parameters: vec![],
            rounds: self.rounds,
            not_converged: self.not_converged.clone(),
            chi_square_per_value: self.calibration.chi_square_per_value,
            largest_chi_square_per_value: largest,
            taken,
            stored: taken,
            chi_square_with_faults: None,
        };
        let Some(machine) = Machine::new(scene) else { return learning };
        let present = present(&self.calibration, &machine);
        let each = present.len().max(1) as f64;
        let (unlikely, reach) = (quantile(0.5 * UNLIKELY / each), quantile(0.5 * MISSED / each));
        for (i, unknown) in present {
            let CalibratedParameter { name, bearing, value, .. } = &self.calibration.parameters[i];
            let deviation = self.deviation(i);
            let (printed, unit, size) = printed_name(*name);
            let given = unknown.get(&machine);
            let deviations = self.scene_deviation(i, given).map(|known| (value - given) / known.hypot(deviation));
            let least = if scene_deviation(*name).is_some() { 0.0 } else { f64::NEG_INFINITY };
            learning.parameters.push(LearnedParameter {
                name: bearing.as_ref().map_or_else(|| printed.to_owned(), |bearing| format!("{bearing}: {printed}")),
                unit,
                scene: given / size,
                value: value / size,
                low: (value - reach * deviation).max(least) / size,
                high: (value + reach * deviation) / size,
                deviations,
                unlikely: deviations.is_some_and(|deviations| deviations.abs() > unlikely),
            });
        }
        learning
    }
}

/// Returns the scene with the parameters of a calibration.
#[must_use]
pub fn calibrated_scene(calibration: &Calibration, scene: &Scene) -> Scene {
    let Some(mut machine) = Machine::new(scene) else { return scene.clone() };
    apply(calibration, &mut machine);
    machine.scene(scene)
}

/// Returns the parameters that a machine has, with their indices in the calibration.
fn present(calibration: &Calibration, machine: &Machine) -> Vec<(usize, Unknown)> {
    let place = |(parameter, b, unknown): (ParameterName, Option<usize>, Unknown)| {
        let name = b.map(|b| machine.bearings[b].scene.name.as_str());
        let at = calibration.parameters.iter().position(|p| p.name == parameter && p.bearing.as_deref() == name)?;
        Some((at, unknown))
    };
    parameters(machine).into_iter().filter_map(place).collect()
}

/// Returns the calibrated unknowns with their covariance.
pub(super) fn covariance(calibration: &Calibration, machine: &Machine) -> (Vec<Unknown>, DMatrix<f64>) {
    let present = present(calibration, machine);
    let of = |i: usize, j: usize| {
        let (i, j) = (present[i].0, present[j].0);
        let correlation = calibration.correlation.get(i).and_then(|row| row.get(j)).copied();
        let correlation = if i == j { 1.0 } else { correlation.unwrap_or(0.0) };
        correlation * calibration.parameters[i].deviation * calibration.parameters[j].deviation
    };
    let covariance = DMatrix::from_fn(present.len(), present.len(), of);
    (present.into_iter().map(|(_, unknown)| unknown).collect(), covariance)
}

/// Returns the parameters that the scene of a machine knows with a deviation, and their covariance.
pub(super) fn covariance_of_scene(machine: &Machine) -> (Vec<Unknown>, DMatrix<f64>) {
    let Prior { unknowns, precision, .. } = of_scene(machine, true);
    let covariance = DMatrix::from_diagonal(&precision.diagonal().map(|x| 1.0 / x));
    (unknowns, covariance)
}

fn prior(calibration: &Calibration, machine: &Machine) -> Prior {
    let (unknowns, covariance) = covariance(calibration, machine);
    let n = unknowns.len();
    // Inverted with a unit diagonal: the units of the parameters differ by 20 orders of magnitude.
    let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
    let inverse = scaled.try_inverse().unwrap_or_else(|| DMatrix::identity(n, n));
    let mut known = machine.clone();
    apply(calibration, &mut known);
    let mean = DVector::from_iterator(unknowns.len(), unknowns.iter().map(|u| u.get(&known)));
    let precision = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
    Prior { unknowns, mean, precision }
}

fn apply(calibration: &Calibration, machine: &mut Machine) {
    for (at, unknown) in present(calibration, machine) {
        unknown.set(machine, calibration.parameters[at].value);
    }
}

/// Returns the prior of the parameters of a machine from its scene; with that of its unbalance where no slow roll tells it from the run-out.
fn of_scene(machine: &Machine, has_unknown_run_out: bool) -> Prior {
    let [ex, ey, cx, cy] = machine.unbalance;
    let of_unbalance = |parameter: ParameterName| match parameter {
        ParameterName::UnbalanceX | ParameterName::UnbalanceY => UNBALANCE_ERROR * ex.hypot(ey),
        _ => UNBALANCE_ERROR * cx.hypot(cy).max(LEAST_COUPLE * ex.hypot(ey)),
    };
    let known = parameters(machine).into_iter().filter_map(|(parameter, _, unknown)| {
        let mean = unknown.get(machine);
        let deviation = match scene_deviation(parameter) {
            Some(share) => share * mean.abs(),
            None if has_unknown_run_out => of_unbalance(parameter),
            None => return None,
        };
        (deviation > 0.0).then_some((unknown, mean, deviation))
    });
    let known: Vec<(Unknown, f64, f64)> = known.collect();
    Prior {
        unknowns: known.iter().map(|k| k.0).collect(),
        mean: DVector::from_iterator(known.len(), known.iter().map(|k| k.1)),
        precision: DMatrix::from_diagonal(&DVector::from_iterator(known.len(), known.iter().map(|k| k.2.powi(-2)))),
    }
}

/// Returns a machine whose bearings carry load: where no element touches its race, a fit has no slope.
///
/// A clearance among the `unknowns` of a bearing without load becomes the one that leaves the least.
fn with_load(e: &Evidence, start: &Fitted, unknowns: &[Unknown]) -> Result<Machine> {
    let mut now = start.clone();
    for clearance in unknowns.iter().filter(|unknown| unknown.is(&CLEARANCE)) {
        let b = clearance.bearing;
        let forces = e.evaluated(&now.machine, b)?.forces(&e.motion);
        let loaded = forces.iter().filter(|force| force.iter().any(|f| *f != 0.0)).count();
        if loaded * 2 > forces.len() {
            continue;
        }
        let given = clearance.get(&start.machine);
        for share in SMALLER_CLEARANCES {
            let mut machine = now.machine.clone();
            clearance.set(&mut machine, share * given);
            let tried = changed(e, &now, &machine)?;
            if tried.chi_square < now.chi_square {
                now = tried;
            }
        }
    }
    Ok(now.machine)
}

/// Returns the fit with a damping that the recording hardly determines as it was known before: where the motion is not far above the noise,
/// damping is estimated too high.
fn with_known_damping(e: &Evidence, fitted: Fitted, prior: &Prior, time_limit: Option<TimeLimit>) -> Result<Fitted> {
    let is_vague = |(i, unknown): (usize, &Unknown)| {
        let deviation = fitted.covariance[(i, i)].max(0.0).sqrt();
        unknown.is(&DAMPING) && prior.unknowns.contains(unknown) && deviation > VAGUE * unknown.get(&fitted.machine)
    };
    let vague: Vec<Unknown> =
        fitted.unknowns.iter().enumerate().filter(|of| is_vague(*of)).map(|(_, unknown)| *unknown).collect();
    if vague.is_empty() {
        return Ok(fitted);
    }
    let mut machine = fitted.machine.clone();
    for unknown in &vague {
        unknown.set(&mut machine, prior.mean_of(*unknown));
    }
    let unknowns: Vec<Unknown> = fitted.unknowns.iter().filter(|unknown| !vague.contains(unknown)).copied().collect();
    fit_whole(
        e,
        &changed(e, &fitted, &machine)?,
        &unknowns,
        prior,
        Limits { time_limit, ..Limits::iterations(2 * ITERATIONS) },
    )
}

/// Adds lines and motion of an earlier recording of the sound machine: it may show either.
fn unite(readings: &mut ProbeReadings, earlier: &ProbeReadings) {
    readings.motion_rms = readings.motion_rms.max(earlier.motion_rms);
    for [order, amplitude] in &earlier.lines {
        match readings.lines.iter_mut().find(|line| (line[0] - order).abs() < SAME_LINE) {
            Some(line) => line[1] = line[1].max(*amplitude),
            None => readings.lines.push([*order, *amplitude]),
        }
    }
    readings.lines.sort_by(|a, b| a[0].total_cmp(&b[0]));
}

/// Fits the parameters of the healthy machine, with a prior from the scene or from an `earlier` calibration; unless `to_end`, only a few rounds
/// where these lead to nothing.
pub(super) fn calibrate(
    of: &mut Prepared,
    earlier: Option<&Calibration>,
    plan: &CalibrationPlan<'_>,
    to_end: bool,
) -> Result<Calibrated> {
    let time_limit = plan.time_limit;
    let is_over = || time_limit.is_some_and(|limit| limit.is_over());
    let mut own = parameters(&of.healthy.machine);
    own.retain(|(name, ..)| plan.parameters.contains(name));
    let has_unknown_run_out = of.site.as_ref().is_some_and(SiteRecording::has_unknown_run_out);
    let prior = match earlier {
        Some(calibration) => prior(calibration, &of.healthy.machine),
        None => of_scene(&of.healthy.machine, has_unknown_run_out),
    };
    let all: Vec<Unknown> = own.iter().map(|(.., unknown)| *unknown).collect();
    let mut now = of.healthy.clone();
    let unexplained_before = of.evidence.unexplained_rms(&now.spectra);
    let loaded = with_load(&of.evidence, &now, &all)?;
    if loaded != now.machine {
        of.evidence.weight_for(&loaded)?;
        (now, of.observable) = cage::fit_cages_together(&of.evidence, &of.band, &loaded, SLIPS)?;
    }
    // Parameters that the scene gives are fitted as if its values were known so much better, and their deviations are as much larger.
    let (dependent, loose) = if of.site.is_some() { (DEPENDENT, 1.0) } else { (1.0, LOOSE) };
    let prior = prior.times(dependent);
    let loose = prior.times(loose);
    let mut has_modulus = false;
    let (mut rounds, mut still_falls, mut ended_early) = (0, None, false);
    while rounds < MAX_ROUNDS && !is_over() {
        rounds += 1;
        (plan.begin)(rounds);
        let before = now.chi_square;
        let mut unknowns = [all.clone(), cage::unknowns(&of.observable, &now.machine)].concat();
        unknowns.retain(|unknown| has_modulus || !unknown.is(&MODULUS));
        now =
            fit_whole(&of.evidence, &now, &unknowns, &loose, Limits { time_limit, ..Limits::iterations(ITERATIONS) })?;
        // The gaps are found anew, so that the readings give the position.
        now.machine.position = Default::default();
        of.remeasure(&now.machine)?;
        of.evidence.weight_for(&now.machine)?;
        (now, of.observable) = cage::fit_cages_together(&of.evidence, &of.band, &now.machine, SLIPS)?;
        let values = now.residual.len() as f64;
        let excess = (2.0 * values).sqrt() + (now.chi_square - values).max(0.0) / dependent;
        let fall = (before - now.chi_square) / dependent;
        if !to_end && rounds == HOPEFUL.0 && now.chi_square > HOPEFUL.1 * values {
            still_falls = Some(fall / before);
            ended_early = true;
            break;
        }
        if has_modulus && fall < DONE * excess {
            still_falls = None;
            break;
        }
        still_falls = Some(fall / before);
        has_modulus |= fall < SETTLED * excess;
    }
    let unknowns = [all, cage::unknowns(&of.observable, &now.machine)].concat();
    let fitted =
        fit_whole(&of.evidence, &now, &unknowns, &prior, Limits { time_limit, ..Limits::iterations(2 * ITERATIONS) })?;
    let mut now = with_known_damping(&of.evidence, fitted, &prior, time_limit)?;
    now.machine.position = Default::default();
    let not_converged = match (time_limit.filter(TimeLimit::is_over), still_falls) {
        (Some(limit), _) => Some(format!(
            "the search does not converge because its time has ended: {} s, in round {rounds} of at most {MAX_ROUNDS}, expected more time \
             (--time-limit) or a recording that the model describes",
            limit.seconds()
        )),
        (None, Some(still_falls)) => Some(format!(
            "the search does not converge: after {MAX_ROUNDS} rounds chi-squared still falls by {:.1e} % a round",
            100.0 * still_falls
        )),
        (None, None) => None,
    };
    let chi_square_per_value = now.chi_square / now.residual.len().max(1) as f64;
    let inflation = chi_square_per_value.max(1.0).sqrt();
    let place = |unknown: &Unknown| now.unknowns.iter().position(|fitted| fitted == unknown);
    let deviation = |i: usize| now.covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt();
    let correlation = |a: &Unknown, b: &Unknown| match (place(a), place(b)) {
        (Some(i), Some(j)) => now.covariance[(i, j)] / (deviation(i) * deviation(j)),
        _ => f64::from(u8::from(a == b)),
    };
    let parameters = own
        .iter()
        .map(|(name, b, unknown)| CalibratedParameter {
            name: *name,
            bearing: b.map(|b| now.machine.bearings[b].scene.name.clone()),
            value: unknown.get(&now.machine),
            deviation: {
                let dependent = if scene_deviation(*name).is_some() { dependent.sqrt() } else { 1.0 };
                // A length of a site is known no better than the gain of its probes.
                let is_length = of.site.is_some() && unknown.is(&CLEARANCE);
                let by_gain = if is_length { GAIN_ERROR * unknown.get(&now.machine) } else { 0.0 };
                let fitted = place(unknown).map_or(prior.deviation(*unknown), |i| inflation * deviation(i));
                (dependent * fitted).hypot(by_gain)
            },
        })
        .collect();
    let correlation = own.iter().map(|(.., a)| own.iter().map(|(.., b)| correlation(a, b)).collect()).collect();
    // The errors of the readings are those beside the machine that is stored with them.
    of.remeasure(&now.machine)?;
    if of.site.is_some() {
        of.evidence.weight_for(&now.machine)?;
        now.spectra = evaluate(&of.evidence, &now.machine)?.spectra;
    }
    let mut readings = of.site.as_ref().map_or_else(Vec::new, |site| {
        site.readings(of.evidence.lines_of_sound_machine(&now.spectra), &of.evidence.motion_rms([&now.spectra; 2]))
    });
    let known = earlier.map(|calibration| calibration.readings.as_slice()).unwrap_or_default();
    readings.iter_mut().zip(known).for_each(|(readings, known)| unite(readings, known));
    let calibration = Calibration { parameters, correlation, chi_square_per_value, readings };
    let [shows_errors, shows_site] =
        [LEAST_GAP, SHOWN_GAP].map(|gap| of.site.as_ref().is_some_and(|site| site.shows_errors(gap)));
    let is_plausible = of.site.as_ref().is_none_or(SiteRecording::is_plausible);
    let not_converged = not_converged.or_else(|| {
        (!is_plausible).then(|| {
            "the search does not converge on a machine of the scene: the readings would have errors that no probe has; check units and \
             offsets of the probes, and that the bearings carry a load"
                .to_owned()
        })
    });
    Ok(Calibrated {
        calibration,
        values: now.residual.len(),
        rounds,
        not_converged,
        ended_early,
        shows_errors,
        shows_site,
        has_unknown_run_out,
        errors: of.site.as_ref().map_or_else(Vec::new, SiteRecording::outcomes),
        unexplained_rms: [unexplained_before, of.evidence.unexplained_rms(&now.spectra)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of both references keeps the larger amplitude, one of the earlier reference alone stays.
    #[test]
    fn lines_of_references_are_united() {
        let of = |lines: &[[f64; 2]]| ProbeReadings { lines: lines.to_vec(), ..ProbeReadings::default() };
        let mut readings = of(&[[2.0, 3e-8], [3.6, 1e-8]]);
        unite(&mut readings, &of(&[[3.61, 2e-8], [2.005, 1e-8], [1.2, 4e-8]]));
        assert_eq!(readings.lines, [[1.2, 4e-8], [2.0, 3e-8], [3.6, 2e-8]]);
    }
}
