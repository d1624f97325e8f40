//! Time response of a scene's rotor from static equilibrium, sample by sample.

pub mod instruments;

use crate::error::{Error, LARGEST_SPEED, MotionOverflow};
use crate::{Plant, Twin};
use ballrace::rotor::ShaftMotion;
use ballrace::{Phase, Status, Wrench};
use ballrace_recording::Row;
use ballrace_recording::rotation::Tracker;
use ballrace_scene::{RotationSource, Scene, Speed};

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

/// Time response of a scene's rotor, advanced sample by sample.
pub struct Response {
    plant: Plant,
    twin: Box<dyn Twin>,
    speed: Speed,
    /// Follows the scene's speed profile as for a recording without a speed column.
    shaft: Tracker,
    /// Samples per second.
    rate: f64,
    /// Number of the present sample, from 0.
    index: u64,
    /// Revolutions of the shaft at the present sample.
    turned: f64,
    drive: ShaftMotion<f64>,
}

impl Response {
    /// Starts at time 0 in static equilibrium, with `rate` samples per second (Hz).
    ///
    /// # Errors
    /// Returns an error if a sample takes too many integration steps or the kernel rejects a parameter.
    pub fn start(scene: &Scene, plant: &Plant, rate: f64) -> Result<Self, Error> {
        let (plant, speed) = (plant.for_simulation(), scene.shaft.speed);
        let twin = plant.start(1.0 / rate, 0.0).map_err(Error::setup)?;
        let drive = ShaftMotion { angle: Phase::ZERO, speed: 0.0, acceleration: 0.0 };
        let mut response = Self { plant, twin, speed, shaft: follow(speed, rate), rate, index: 0, turned: 0.0, drive };
        response.turn_shaft()?;
        Ok(response)
    }

    /// Returns a copy that moves by itself, as [`Twin::copy`].
    #[must_use]
    pub fn copy(&self) -> Self {
        let (plant, twin, shaft) = (self.plant.clone(), self.twin.copy(), follow(self.speed, self.rate));
        Self { plant, twin, shaft, ..*self }
    }

    /// Returns the present sample.
    #[must_use]
    pub fn now(&self) -> ResponseSample<'_> {
        let (time, twin) = (self.index as f64 * self.period(), self.twin.as_ref());
        ResponseSample { time, turned: self.turned, drive: self.drive, twin, plant: &self.plant }
    }

    /// Returns the twin.
    pub fn twin(&mut self) -> &mut dyn Twin {
        self.twin.as_mut()
    }

    /// Returns the sample period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        1.0 / self.rate
    }

    /// Advances by one sample period.
    ///
    /// # Errors
    /// [`MotionOverflow`].
    pub fn advance(&mut self) -> Result<Status, Error> {
        let status = self.twin.step(&self.drive);
        self.index += 1;
        let end = self.index as f64 * self.period();
        check_overflow((&self.plant, self.period()), (self.twin.as_ref(), status.is_held()), end)?;
        self.turn_shaft()?;
        Ok(status)
    }

    /// Turns the shaft to the present sample.
    fn turn_shaft(&mut self) -> Result<(), Error> {
        let time = self.index as f64 * self.period();
        self.shaft.push(Row { index: self.index, time, ..Row::default() })?;
        if let Some(sample) = self.shaft.pop() {
            (self.turned, self.drive) = (sample.total_revolutions(), sample.shaft_motion());
        }
        Ok(())
    }
}

fn follow(speed: Speed, rate: f64) -> Tracker {
    Tracker::new(&RotationSource::Scene, rate, speed)
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
    let mut response = Response::start(scene, plant, span.rate)?;
    start(response.twin());
    for i in 0..span.settle + span.samples {
        if i >= span.settle {
            visit(&response.now())?;
        }
        response.advance()?;
    }
    Ok(response.twin)
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
