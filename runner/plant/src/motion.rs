//! Time response of a scene's rotor from static equilibrium, sample by sample.

pub mod instruments;

use crate::error::{Error, LARGEST_SPEED, MotionOverflow};
use crate::{Plant, Twin};
use ballrace::Wrench;
use ballrace::rotor::ShaftMotion;
use ballrace_recording::Row;
use ballrace_recording::rotation::Tracker;
use ballrace_scene::{RotationSource, Scene};

/// Largest number of samples of one run, with those of the transient.
pub const MAX_SAMPLES: f64 = 1e9;

/// Error returned for a duration, rate and transient with too few or too many samples.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("number of samples out of range: {found}, expected 1 to {MAX_SAMPLES:e}")]
pub struct InvalidSpan {
    /// Number of samples, with those of the transient.
    pub found: f64,
}

/// Length and rate of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Samples per second.
    pub rate: f64,
    /// Number of samples of the transient, which are not returned.
    pub settle: u64,
    /// Number of samples returned.
    pub samples: u64,
}

impl Span {
    /// Creates a span of `duration` (s) at `rate` (Hz) after a transient of `settle` (s).
    ///
    /// # Errors
    /// Returns an error for a rate of 0 or less, no sample, a negative transient or more than [`MAX_SAMPLES`] samples.
    pub fn try_new(duration: f64, rate: f64, settle: f64) -> Result<Self, InvalidSpan> {
        let (samples, settle) = ((duration * rate).round(), (settle * rate).round());
        let found = samples + settle;
        if rate > 0.0 && samples >= 1.0 && settle >= 0.0 && found <= MAX_SAMPLES {
            Ok(Self { rate, settle: settle as u64, samples: samples as u64 })
        } else {
            Err(InvalidSpan { found })
        }
    }
}

/// One sample of the response.
pub struct ResponseSample<'a> {
    /// Time from the start of the scene, s.
    pub time: f64,
    /// Revolutions of the shaft since the start.
    pub turned: f64,
    /// Motion of the shaft.
    pub drive: ShaftMotion<f64>,
    /// The twin at this time.
    pub twin: &'a dyn Twin,
    /// The plant with its bearings.
    pub plant: &'a Plant,
}

impl ResponseSample<'_> {
    /// Returns the force of bearing `i` on its inner ring, N and N m.
    #[must_use]
    pub fn wrench(&self, i: usize) -> Wrench<f64> {
        self.plant.bearings.get(i).map_or_else(Wrench::default, |mounted| {
            self.twin.wrench(i, &mounted.rotation(mounted.kinematics.parts_at(self.turned), &self.drive))
        })
    }

    /// Returns the values of [`columns`].
    pub fn row(&self) -> impl Iterator<Item = f64> + '_ {
        let motion = self.twin.coordinates().iter().chain(self.twin.rates()).copied();
        let forces = (0..self.plant.bearings.len()).flat_map(|i| self.wrench(i).to_array());
        std::iter::once(self.time).chain(motion).chain(forces)
    }
}

/// Returns the names of a sample's values: time, coordinates (`u v w thu thv` first), their rates, forces of each bearing; SI.
#[must_use]
pub fn columns(plant: &Plant) -> Vec<String> {
    let names = plant.layout.names(&plant.bearings);
    let rates = names.iter().map(|name| format!("{name}_dot"));
    let forces = plant
        .bearings
        .iter()
        .flat_map(|mounted| ["FX", "FY", "FZ", "MX", "MY"].map(|component| format!("{}_{component}", mounted.name)));
    let motion = names.iter().cloned().chain(rates);
    std::iter::once("t".to_owned()).chain(motion).chain(forces).collect()
}

/// Rejects a motion that overflows: a step without a result, or a speed beyond [`LARGEST_SPEED`] after it at `time` (s).
///
/// # Errors
/// Returns [`MotionOverflow`] with its probable cause.
pub fn check_overflow(
    (plant, sample_period): (&Plant, f64),
    (twin, is_held): (&dyn Twin, bool),
    time: f64,
) -> Result<(), Error> {
    let fastest = twin.rates().iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    if !is_held && fastest <= LARGEST_SPEED {
        return Ok(());
    }
    let speed = if is_held { "a step without a result".to_owned() } else { format!("{fastest:.1e} m/s") };
    let advice = plant.unstable_step(sample_period)?;
    Err(Error::Motion(MotionOverflow {
        found: format!("{speed} at {time:.6} s"),
        advice: advice
            .unwrap_or_else(|| "A system without damping, or a step that is too long, is a usual cause.".to_owned()),
    }))
}

/// Simulates the scene's rotor from equilibrium, or from the state `start`, and passes each sample after the transient to `visit`.
/// Returns the twin at the end.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter, [`MotionOverflow`], or the first error of `visit`.
pub fn run<E: From<Error>>(
    scene: &Scene,
    plant: &Plant,
    span: Span,
    start: impl FnOnce(&mut dyn Twin),
    mut visit: impl FnMut(&ResponseSample<'_>) -> Result<(), E>,
) -> Result<Box<dyn Twin>, E> {
    let period = 1.0 / span.rate;
    let plant = &plant.for_simulation();
    let mut twin = plant.start(period, 0.0).map_err(Error::setup)?;
    start(twin.as_mut());
    // The tracker follows the scene's speed profile as for a recording without a speed column.
    let mut shaft = Tracker::new(&RotationSource::Scene, span.rate, scene.shaft.speed);
    for i in 0..span.settle + span.samples {
        let time = i as f64 * period;
        shaft.push(Row { index: i, time, ..Row::default() }).map_err(Error::from)?;
        let Some(sample) = shaft.pop() else { break };
        let drive = sample.shaft_motion();
        if i >= span.settle {
            let turned = sample.total_revolutions();
            visit(&ResponseSample { time, turned, drive, twin: twin.as_ref(), plant })?;
        }
        let is_held = twin.step(&drive).is_held();
        check_overflow((plant, period), (twin.as_ref(), is_held), (i + 1) as f64 * period)?;
    }
    Ok(twin)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::Method;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    /// `docs/src/models.md#integrators`: forces of the demonstration's twin against a fine step, in a replay and in a simulation.
    #[test]
    fn error_of_the_default_steps() {
        let scene = read_str(include_str!("../../demo/healthy.toml"), Path::new("scene.toml")).unwrap();
        let plant = Plant::try_new(&scene).unwrap();
        let span = Span::try_new(0.5, 12_800.0, 0.0).unwrap();
        let forces = |plant: &Plant| {
            let mut all: Vec<f64> = vec![];
            let add = |now: &ResponseSample<'_>| {
                all.push(now.wrench(0).fx);
                Ok::<_, Error>(())
            };
            run(&scene, plant, span, |_| {}, add).unwrap();
            all
        };
        let fine = forces(&plant.with_step(Method::RungeKutta, 0.02));
        let off = |plant: &Plant| {
            let squares = forces(plant).iter().zip(&fine).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            (squares / fine.len() as f64).sqrt()
        };
        let (replay, simulation) = (off(&plant.with_step(Method::RungeKutta, 1.0)), off(&plant));
        println!("error of FX: {replay:.4} N rms in a replay, {simulation:.4} N in a simulation");
        assert_eq!(plant.substeps(1.0 / span.rate).unwrap(), 1);
        assert_eq!(plant.for_simulation().substeps(1.0 / span.rate).unwrap(), 2);
        assert!(replay < 0.045, "{replay} N");
        assert!(simulation < 0.004, "{simulation} N");
    }
}
