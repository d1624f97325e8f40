//! Diagnosis of kind, bearing, position and size of faults from the measured displacement of the shaft (`docs/src/diagnosis.md`).
//!
//! The displacement determines the force that the rotor's motion requires; the bearing models, evaluated at the same
//! displacement, give the force of the machine under a hypothesis. Their difference is noise alone if the hypothesis is true.
//! The difference is computed at the probes, in units of their noise, over the lines of a windowed Fourier transform, so that its
//! sum of squares is a chi-squared. No equation of motion is integrated: a diagnosis is also valid for a chaotic motion.
//!
//! The modules in the order of a diagnosis: `block` collects samples, `motion` is their displacement and its spectra,
//! `machine` a hypothesis with its `parameter`s, `residual` the force that it leaves unexplained, `fit` the fit of its unknowns, `means`
//! that of faults which move the shaft to lines and gaps, `cage`
//! angle and slip of the cages, `surface` spalls and waves from their lines, `faults` the faults that the machine may have and the
//! search for them, `hypothesis` the choice among them, `estimates` their sizes with intervals, `result` the reported
//! result with the data of its figures in `fault_figures` and `force_rose`, `calibration` the fit of the healthy machine.
#![forbid(unsafe_code)]

pub mod block;
mod cage;
mod calibration;
mod decimation;
mod dynamics;
mod estimates;
mod fault_figures;
mod faults;
mod filter;
mod fit;
mod force_rose;
mod hypothesis;
mod machine;
mod means;
mod measurement;
mod motion;
mod parameter;
pub mod plausibility;
mod residual;
mod result;
mod site;
mod surface;
mod unexplained;
pub mod vibration;

pub use calibration::{Calibrated, CalibrationPlan, MAX_ROUNDS, calibrated_scene};
pub use result::{CageEstimate, DiagnosisResult};

use ballrace_models::build::BuildError;
use ballrace_outcome::Calibration;
use ballrace_plant::Plant;
use ballrace_plant::probes::PoseSolver;
use ballrace_recording::Sample;
use ballrace_scene::{Direction, Probe, Scene};
use faults::AnyFault;
use fit::Fitted;
use hypothesis::MAX_FAULTS;
use machine::Machine;
use motion::Motion;
use nalgebra::DMatrix;
use parameter::Unknown;
use residual::{Evidence, Weighting};
use site::SiteRecording;
use std::f64::consts::TAU;
use std::sync::Arc;
use surface::Baseband;

/// Result of a diagnosis step.
type Result<T> = std::result::Result<T, BuildError>;

/// Smallest number of shaft revolutions in a block.
pub(crate) const MIN_REVOLUTIONS: f64 = 16.0;
/// Highest line over the highest natural frequency: above it the rotor's inertia leaves less of a force than noise.
const HIGHEST_OVER_NATURAL: f64 = 3.0;
/// Highest line over the sampling rate: the force is evaluated at the samples, so its spectrum repeats at the rate.
const HIGHEST_OVER_RATE: f64 = 0.16;
/// Least gap that shows a site, m: a fault may move the shaft by less.
const SHOWN_GAP: f64 = 10e-6;
/// Band about a carrier, in orders of the shaft.
const BAND_ORDERS: f64 = 3.5;

/// Scene, plant and samples of a diagnosis.
#[derive(Clone, Copy)]
pub struct DiagnosisInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its plant.
    pub plant: &'a Plant,
    /// Its probes.
    pub probes: &'a [Probe],
    /// Consecutive samples with a reading of every probe.
    pub samples: &'a [Sample],
    /// Sample period, s.
    pub period: f64,
    /// Calibration from which the scene has its parameters.
    pub calibration: Option<&'a Calibration>,
    /// The readings are without the errors that the calibration has of them.
    pub is_corrected: bool,
}

/// Prepared recording, with the healthy machine fitted to it.
struct Prepared<'a> {
    evidence: Evidence<'a>,
    band: Baseband,
    healthy: Fitted,
    /// Deviations of sound machines that the healthy machine has.
    deviations: Vec<AnyFault>,
    observable: Vec<bool>,
    /// The recording with the errors of the readings that count against their prior, at a site.
    shifted: Option<Evidence<'a>>,
    /// The readings, in a recording of a site.
    site: Option<SiteRecording<'a>>,
}

/// What the readings of the probes are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum World {
    /// The motion of the shaft of the scene's machine, and noise.
    Exact,
    /// Besides it the errors of a site, and the imperfections of sound bearings.
    Site,
}

/// Returns the reason why a scene cannot be diagnosed; `None` if it can.
#[must_use]
pub fn not_applicable(scene: &Scene, samples: &[Sample]) -> Option<String> {
    if scene.system.is_some() {
        return Some(
            "a [system] has no stations, and a diagnosis of unbalance, misalignment and bearings requires them"
                .to_owned(),
        );
    }
    if scene.rotor.is_none() || scene.bearings.iter().any(|b| !b.element_azimuths.is_empty()) {
        return Some("the scene has no rotor on evenly filled bearings".to_owned());
    }
    let is_elastic = scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_some())
        || scene.bearings.iter().any(|b| b.support.is_some());
    if is_elastic && scene.bearings.len() != 2 {
        return Some("a rotor that bends or has supports is diagnosed on two bearings only".to_owned());
    }
    if scene.shaft.outer_speed != 0.0 {
        return Some("the outer rings turn".to_owned());
    }
    let revolutions = match samples {
        [first, .., last] => (last.total_revolutions() - first.total_revolutions()).abs(),
        _ => 0.0,
    };
    (revolutions < MIN_REVOLUTIONS).then(|| {
        format!(
            "{revolutions:.1} revolutions in a row have a reading of every probe, expected {MIN_REVOLUTIONS:.0} or more"
        )
    })
}

/// Share of a probe's motion to which scale and instant of its readings are known where nothing states their noise: API 670 allows 5 % of scale,
/// and half a sample of the keyphasor is 1 % of a line with 300 samples per period. A residual below it is none of the machine.
const SCALE_KNOWN: f64 = 0.01;

/// Returns the rms of the readings of a probe about their mean, m.
fn scatter(samples: &[Sample], probe: usize) -> f64 {
    let readings = || samples.iter().filter_map(|sample| sample.row.probes.get(probe)).filter(|x| x.is_finite());
    let count = readings().count().max(1) as f64;
    let mean = readings().sum::<f64>() / count;
    (readings().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

impl<'a> Prepared<'a> {
    /// Prepares a recording; `uncertain` are the parameters whose errors no fault explains, with their covariance.
    fn new(
        of: &DiagnosisInput<'a>,
        machine: &Machine,
        world: World,
        uncertain: Option<(Vec<Unknown>, DMatrix<f64>)>,
    ) -> Result<Option<Self>> {
        let stations: Vec<f64> = of.plant.bearings.iter().map(|b| b.station).collect();
        let Ok(solver) = PoseSolver::try_new(of.probes, &stations) else { return Ok(None) };
        let noise: Vec<f64> = of
            .probes
            .iter()
            .enumerate()
            .map(|(p, probe)| {
                let given = if world == World::Site { None } else { probe.noise };
                let noise = ballrace_plant::observer::noise(of.samples, p, given);
                if world == World::Exact && given.is_none() {
                    noise.max(SCALE_KNOWN * scatter(of.samples, p))
                } else {
                    noise
                }
            })
            .collect();
        let axial = of.plant.pose(&of.plant.rest).w;
        let motion = Motion::new(of.samples, of.period, &solver, axial);
        let rate = TAU / of.period;
        let highest = (HIGHEST_OVER_NATURAL * of.plant.highest_frequency()).min(HIGHEST_OVER_RATE * rate);
        let weighting = Arc::new(Weighting {
            probes: of.probes.to_vec(),
            noise,
            solver,
            has_axial_probe: of.probes.iter().any(|p| p.direction == Direction::Axial),
        });
        let mut site = None;
        let evidence = match world {
            World::Exact => Evidence::new(of.scene, of.plant, motion, highest, weighting)?,
            World::Site => site.insert(SiteRecording::new(*of, weighting, highest, motion)).evidence(machine)?,
        };
        let Some(mut evidence) = evidence else { return Ok(None) };
        if let Some(uncertain) = uncertain {
            evidence.set_uncertain(uncertain);
        }
        evidence.weight_for(machine)?;
        let band = Baseband::new(&evidence, BAND_ORDERS);
        let (mut healthy, mut observable) = cage::fit_cages_together(&evidence, &band, machine, cage::SLIPS)?;
        if evidence.follows_axially() {
            // The cages move the rotor axially.
            evidence.weight_for(&healthy.machine)?;
            (healthy, observable) = cage::fit_cages_together(&evidence, &band, &healthy.machine, cage::SLIPS)?;
        }
        let mut shifted = site.as_ref().map(SiteRecording::with_counting_errors).transpose()?.flatten();
        if let Some(shifted) = &mut shifted {
            shifted.uncertain_as(&evidence);
            shifted.weight_for(&healthy.machine)?;
        }
        Ok(Some(Self { evidence, band, healthy, deviations: vec![], observable, shifted, site }))
    }
}

impl<'a> Prepared<'a> {
    /// Returns true at a site whose gaps are known from a baseline.
    fn has_known_gaps(&self) -> bool {
        self.site.is_some() && !self.evidence.is_without_baseline()
    }

    /// Returns the recording weighted for a machine; the readings of a site lack the errors that this machine leaves.
    fn weighted_for(&self, machine: &Machine) -> Result<Evidence<'a>> {
        let measured = self.site.as_ref().map(|site| site.clone().evidence(machine)).transpose()?;
        let mut evidence = measured.flatten().unwrap_or_else(|| self.evidence.clone());
        evidence.uncertain_as(&self.evidence);
        evidence.weight_for(machine)?;
        Ok(evidence)
    }

    /// Finds the errors of the readings of a site anew for a machine. The next call must be [`Evidence::weight_for`].
    fn remeasure(&mut self, machine: &Machine) -> Result<()> {
        let Some(site) = &mut self.site else { return Ok(()) };
        if let Some(evidence) = site.evidence(machine)? {
            self.evidence = evidence;
        }
        Ok(())
    }
}

/// Diagnoses a recording; `None` if the rotor or its probes do not allow it.
///
/// `progress` receives the completed share of the work.
///
/// # Errors
/// Returns an error if a bearing cannot be built.
pub fn diagnose(
    of: &DiagnosisInput,
    progress: &dyn Fn(f64),
) -> std::result::Result<Option<DiagnosisResult>, BuildError> {
    // A baseline of a site is compared with recordings of that site; without one, an exact world must explain everything, or the readings
    // must show the errors of a site.
    if world(of) == World::Site {
        return diagnose_in(World::Site, of, (MAX_FAULTS, None), progress);
    }
    let exact = diagnose_in(World::Exact, of, (MAX_FAULTS, None), &|share| progress(0.5 * share))?;
    if exact.as_ref().is_none_or(DiagnosisResult::explains) {
        return Ok(exact);
    }
    // What accuses without a proof is no reason to disregard a site.
    let least_gap = exact.as_ref().filter(|exact| !exact.accuses_without_proof()).map(|_| SHOWN_GAP);
    let site = diagnose_in(World::Site, of, (MAX_FAULTS, least_gap), &|share| progress(0.5 + 0.5 * share))?;
    Ok(site.or(exact))
}

/// Returns the parameters that are known with a deviation, and their covariance: those of a baseline, or those of the scene of a site.
fn uncertain(of: &DiagnosisInput, machine: &Machine, world: World) -> Option<(Vec<Unknown>, DMatrix<f64>)> {
    match of.calibration {
        Some(calibration) => Some(calibration::covariance(calibration, machine)),
        None if world == World::Site => Some(calibration::covariance_of_scene(machine)),
        None => None,
    }
}

/// Returns the world of a baseline.
fn world(of: &DiagnosisInput) -> World {
    let is_site = of.calibration.is_some_and(|calibration| !calibration.readings.is_empty());
    if is_site { World::Site } else { World::Exact }
}

/// Diagnoses a recording in a world with at most `most` faults; `None` as well where the readings show no errors of a site, with a gap of
/// `least_gap` or another one, that they have to.
fn diagnose_in(
    world: World,
    of: &DiagnosisInput,
    (most, least_gap): (usize, Option<f64>),
    progress: &dyn Fn(f64),
) -> Result<Option<DiagnosisResult>> {
    let Some(machine) = Machine::new(of.scene) else { return Ok(None) };
    let Some(mut prepared) = Prepared::new(of, &machine, world, uncertain(of, &machine, world))? else {
        return Ok(None);
    };
    progress(0.1);
    if let (Some(site), Some(least_gap)) = (&prepared.site, least_gap)
        && !site.shows_errors(least_gap)
    {
        return Ok(None);
    }
    let faults = hypothesis::diagnose(&mut prepared, most, progress)?;
    Ok(Some(result::diagnosis(of, &prepared, &faults)?))
}

/// Estimates angle and slip of every cage, without a search for faults; `None` if the rotor or its probes do not allow it.
///
/// # Errors
/// Returns an error if a bearing cannot be built.
pub fn cages(of: &DiagnosisInput) -> std::result::Result<Option<Vec<CageEstimate>>, BuildError> {
    let Some(machine) = Machine::new(of.scene) else { return Ok(None) };
    let Some(prepared) = Prepared::new(of, &machine, world(of), uncertain(of, &machine, world(of)))? else {
        return Ok(None);
    };
    Ok(Some(result::cages(&prepared.evidence, &prepared.healthy, &prepared.observable)))
}

/// Sets the observable cages of a scene to their estimates at `turns`, the total revolutions of a sample.
pub fn set_cages(scene: &mut Scene, cages: &[CageEstimate], turns: f64) {
    for (bearing, cage) in scene.bearings.iter_mut().zip(cages).filter(|(_, cage)| cage.observable) {
        let (ratio, azimuth) = cage.tangent(turns);
        bearing.cage_ratio = Some(ratio);
        bearing.first_element_azimuth = azimuth.rem_euclid(TAU / bearing.elements as f64);
    }
}

/// Calibrates the scene with the recording of a healthy machine; `None` if the rotor or its probes do not allow it.
///
/// # Errors
/// Returns an error if a bearing cannot be built.
pub fn calibrate(
    of: &DiagnosisInput,
    plan: &CalibrationPlan<'_>,
) -> std::result::Result<Option<Calibrated>, BuildError> {
    let in_world = |world: World, to_end: bool| calibrate_in(world, of, plan, to_end);
    if world(of) == World::Site {
        return in_world(World::Site, true);
    }
    let exact = in_world(World::Exact, false)?;
    if exact.as_ref().is_none_or(|calibrated| calibrated.learning(of.scene).taken) {
        return Ok(exact);
    }
    // Computed anew only where it has ended early.
    let exact_to_end = |exact: Option<Calibrated>| match &exact {
        Some(calibrated) if calibrated.ended_early => in_world(World::Exact, true),
        _ => Ok(exact),
    };
    let site = in_world(World::Site, true)?;
    let Some(calibrated) = site.as_ref().filter(|calibrated| calibrated.learning(of.scene).taken) else {
        return exact_to_end(exact);
    };
    if !calibrated.shows_errors {
        return exact_to_end(exact);
    }
    if calibrated.shows_site {
        return Ok(site);
    }
    // One fault of the scene's machine is no site: its recording is learned with the fault.
    let alone = DiagnosisInput { calibration: None, ..*of };
    let with_fault = diagnose_in(World::Exact, &alone, (1, None), &|_| {})?;
    if with_fault.is_some_and(|result| result.explains()) { exact_to_end(exact) } else { Ok(site) }
}

fn calibrate_in(
    world: World,
    of: &DiagnosisInput,
    plan: &CalibrationPlan<'_>,
    to_end: bool,
) -> Result<Option<Calibrated>> {
    let Some(machine) = Machine::new(of.scene) else { return Ok(None) };
    let alone = DiagnosisInput { calibration: None, ..*of };
    let Some(mut prepared) = Prepared::new(&alone, &machine, world, None)? else { return Ok(None) };
    calibration::calibrate(&mut prepared, of.calibration, plan, to_end).map(Some)
}

/// Calibrates the scene of a site with a recording whose readings have errors that no machine of the scene explains; `None` for another
/// recording, or where rotor or probes do not allow it.
///
/// # Errors
/// Returns an error if a bearing cannot be built.
pub fn calibrate_site(
    of: &DiagnosisInput,
    plan: &CalibrationPlan<'_>,
) -> std::result::Result<Option<Calibrated>, BuildError> {
    let Some(machine) = Machine::new(of.scene) else { return Ok(None) };
    let prepared = Prepared::new(of, &machine, World::Site, uncertain(of, &machine, World::Site))?;
    let shows_errors = |site: SiteRecording| site.shows_errors(calibration::LEAST_GAP);
    if !prepared.and_then(|prepared| prepared.site).is_some_and(shows_errors) {
        return Ok(None);
    }
    // A machine that is not the scene's may show the same.
    let exact = calibrate_in(World::Exact, of, plan, false)?;
    if exact.is_none_or(|calibrated| calibrated.explains()) {
        return Ok(None);
    }
    let site = calibrate_in(World::Site, of, plan, true)?;
    Ok(site.filter(|calibrated| calibrated.shows_errors))
}
