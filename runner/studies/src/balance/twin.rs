//! Influence coefficients from the rotor of a scene on its linearised bearings, with their uncertainty.
//!
//! A moment of 1 on a plane is the force `w^2` on the shaft there; the reading of a probe follows from `M q'' + (B + w G) q' + K q = f`
//! with the mean tangent stiffness of the bearings over a ball pitch. The unknown parameters of the scene have the deviations from which
//! `ballrace fit` starts: 20 % of the stiffness of contacts, linear bearings and supports, 5 um of clearance, a factor e of damping, a factor
//! 1.6 of preload. Each changes all coefficients together, by the slope between its two ends.

use super::plane::Plane;
use super::table::{C, VectorTable};
use crate::fit::parameters::{Group, Parameter, parameters, with};
use ballrace_base::parallel;
use ballrace_outcome::ALLOWED_REDUCTION_ERRORS;
use ballrace_plant::error::{Error, Result};
use ballrace_plant::{Plant, only_observable, only_rotor, response};
use ballrace_scene::{Clock, Direction, KeyphasorSignal, Linear, Probe, Recording, RotationSource, Scene, Speed};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Standard deviation of the logarithm of the stiffness of a linear bearing or a support, as of a contact in `ballrace fit`.
const STIFFNESS: f64 = 0.2;
/// The same of its damping.
const DAMPING: f64 = 1.0;
/// Stiffness of a ball contact under a load `F` is in proportion to `F^(1/3)`.
const LOAD_EXPONENT: f64 = 1.0 / 3.0;
/// Least coefficient of a probe over the largest of all, from which its error counts.
const LEAST_SHARE: f64 = 1e-3;
/// Relative standard deviation of the scale of a probe: API 670 allows 5 %, taken as evenly distributed.
const PROBE_SCALE: f64 = 0.05 / 1.732;

/// Assumed deviation of a coefficient over the largest of its probe, where the speed changes: a resonance follows the speed late.
const RUN_UP: f64 = 0.1;

/// Influence coefficients of a twin.
#[derive(Debug, Clone)]
pub struct TwinCoefficients {
    /// By channel (speed by speed, each with all probes) and plane, um per g mm.
    pub(super) mean: DMatrix<C>,
    /// Covariance of all; plane by plane of the first channel, then of the next.
    pub(super) covariance: DMatrix<C>,
}

/// Returns the radial probes of a recording, those that show an unbalance.
pub fn radial_probes(recording: &Recording) -> impl Iterator<Item = (usize, &Probe)> {
    let is_radial = |(_, probe): &(usize, &Probe)| matches!(probe.direction, Direction::Radial(_));
    recording.probes.iter().enumerate().filter(is_radial)
}

impl TwinCoefficients {
    /// Computes the coefficients of the radial probes of a scene for these planes at the speeds of a table.
    ///
    /// # Errors
    /// Returns an error if the scene has no rotor, bearings with moving balls, or a parameter that the kernel rejects.
    pub fn new(scene: &Scene, planes: &[Plane], table: &VectorTable) -> Result<Self> {
        let speeds = &table.speeds().1;
        only_rotor(scene, "balance")?;
        only_observable(scene, "balance")?;
        let mean = coefficients(scene, planes, speeds)?;
        let both = |ends: &[Scene; 2]| -> Result<[DMatrix<C>; 2]> {
            Ok([coefficients(&ends[0], planes, speeds)?, coefficients(&ends[1], planes, speeds)?])
        };
        // A parameter at which the machine has no equilibrium is known better than that.
        let ends = parallel::map(&disturbed(scene)?, both).into_iter().flatten();
        let mut covariance = DMatrix::zeros(mean.len(), mean.len());
        let mut add = |change: &DMatrix<C>| {
            let change = flat(change);
            covariance += &change * change.adjoint();
        };
        ends.for_each(|[low, high]| {
            // Where a clearance makes a bearing soft, the coefficients are known by a factor: the slope is that of their mean.
            let middle = (&low + &high).norm() * 0.5;
            let share = (mean.norm() / middle.max(f64::MIN_POSITIVE)).min(1.0);
            add(&((high - low) * C::new(0.5 * share, 0.0)));
        });
        let Some(recording) = &scene.recording else { return Ok(Self { mean, covariance }) };
        // A pulse is known to half a sample, evenly distributed.
        let turned = speeds.iter().map(|rpm| rpm.abs() / 60.0 * TAU).fold(0.0, f64::max) * pulse_error(recording);
        add(&(&mean * C::new(0.0, turned)));
        let probes = radial_probes(recording).count().max(1);
        for probe in 0..probes {
            let own = DMatrix::from_fn(mean.nrows(), mean.ncols(), |channel, plane| {
                let share = if channel % probes == probe { PROBE_SCALE } else { 0.0 };
                mean[(channel, plane)] * share
            });
            add(&own);
        }
        // The reduced rotor has an error of its own in each coefficient; a probe at a node of the motion has one too.
        let least = LEAST_SHARE * mean.iter().map(|c| c.norm()).fold(0.0, f64::max);
        let share = if table.has_run_ups { RUN_UP } else { ALLOWED_REDUCTION_ERRORS[2] };
        for channel in 0..mean.nrows() {
            let largest = mean.row(channel).iter().map(|c| c.norm()).fold(least, f64::max);
            for plane in 0..mean.ncols() {
                let at = channel * mean.ncols() + plane;
                covariance[(at, at)] += (share * largest).powi(2);
            }
        }
        Ok(Self { mean, covariance })
    }
}

/// Returns the coefficients channel by channel, those of the planes side by side.
pub(super) fn flat(of: &DMatrix<C>) -> DVector<C> {
    DVector::from_iterator(of.len(), of.transpose().iter().copied())
}

/// Returns the standard deviation of the instants of a keyphasor that is sampled, s.
fn pulse_error(recording: &Recording) -> f64 {
    let is_sampled = match &recording.rotation {
        RotationSource::Keyphasor { signal, .. } => !matches!(signal, KeyphasorSignal::Instants { .. }),
        _ => false,
    };
    match recording.clock {
        Clock::Rate(rate) if is_sampled => 0.5 / rate / 3.0_f64.sqrt(),
        _ => 0.0,
    }
}

/// Returns the coefficients at each speed (rpm), um per g mm, channel by channel.
fn coefficients(scene: &Scene, planes: &[Plane], speeds: &[f64]) -> Result<DMatrix<C>> {
    let mut rows: Vec<Vec<C>> = vec![];
    for rpm in speeds {
        let speed = rpm / 60.0 * TAU;
        let mut turning = scene.clone();
        turning.shaft.speed = Speed::Constant(speed);
        let plant = Plant::try_new(&turning)?;
        let plant = plant.linearised(&vec![true; plant.bearings.len()])?;
        let scales = plant.scales()?;
        let moved = |plane: &Plane| {
            let [along_x, along_y, ..] = plant.layout.rows(plane.station);
            // Unit moment at angle 0: the force turns from X towards Y.
            let unbalance: Vec<[f64; 2]> = along_x.iter().zip(&along_y).map(|(x, y)| [*x, *y]).collect();
            let matrices = [&scales.mass, &scales.damping, &scales.gyroscopic, &plant.stiffness];
            response(matrices, &unbalance, speed)
        };
        let moved: Vec<DVector<C>> = planes.iter().map(moved).collect();
        for (_, probe) in scene.recording.iter().flat_map(radial_probes) {
            let row = plant.layout.probe_row(probe);
            // um per g mm from m per kg m.
            let reading = |q: &DVector<C>| row.iter().zip(q.iter()).map(|(per_unit, q)| q * *per_unit).sum();
            rows.push(moved.iter().map(reading).collect());
        }
    }
    Ok(DMatrix::from_fn(rows.len(), planes.len(), |channel, plane| rows[channel][plane]))
}

/// Returns the scene with each unknown parameter one standard deviation below and above its value.
fn disturbed(scene: &Scene) -> Result<Vec<[Scene; 2]>> {
    let plant = Plant::try_new(scene).map_err(Error::setup)?;
    let fitted = parameters(scene, &plant, &[Group::Clearance, Group::Stiffness, Group::Damping]);
    let of_fit = fitted.iter().map(|parameter| {
        [-1.0, 1.0].map(|by| {
            let value = parameter.value(Parameter::prior_mean(parameter) + by);
            with(scene, std::slice::from_ref(parameter), &[value])
        })
    });
    let mut all: Vec<[Scene; 2]> = of_fit.collect();
    let mut both = |change: &dyn Fn(&mut Scene, f64)| {
        all.push([-1.0, 1.0].map(|by| {
            let mut changed = scene.clone();
            change(&mut changed, by);
            changed
        }));
    };
    for (i, bearing) in scene.bearings.iter().enumerate() {
        match bearing.linear {
            Some(Linear::Matrix(_)) => both(&|scene, by| {
                if let Some(Linear::Matrix(matrix)) = &mut scene.bearings[i].linear {
                    matrix.iter_mut().flatten().for_each(|k| *k *= (STIFFNESS * by).exp());
                }
            }),
            Some(Linear::TwoSpring { .. }) => both(&|scene, by| {
                if let Some(Linear::TwoSpring { static_load }) = &mut scene.bearings[i].linear {
                    *static_load *= (STIFFNESS / LOAD_EXPONENT * by).exp();
                }
            }),
            _ => {}
        }
        if bearing.support.is_some() {
            both(&|scene, by| {
                if let Some(support) = &mut scene.bearings[i].support {
                    let factor = (STIFFNESS * by).exp();
                    support.stiffness = support.stiffness.map(|k| k * factor);
                    support.cross_stiffness *= factor;
                }
            });
            both(&|scene, by| {
                if let Some(support) = &mut scene.bearings[i].support {
                    support.damping *= (DAMPING * by).exp();
                }
            });
        }
    }
    if scene.rotor.as_ref().is_some_and(|rotor| rotor.proportional_damping > 0.0 || rotor.flexible.is_some()) {
        both(&|scene, by| {
            let Some(rotor) = &mut scene.rotor else { return };
            let factor = (DAMPING * by).exp();
            rotor.proportional_damping *= factor;
            if let Some(drawn) = &mut rotor.flexible {
                drawn.proportional_damping = drawn.proportional_damping.map(|x| x * factor);
                drawn.modal_damping = (drawn.modal_damping * factor).min(0.99);
            }
        });
    }
    Ok(all)
}
