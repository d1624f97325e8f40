//! The time response of a scene's rotor from its rest position, sample by sample.

use crate::error::Error;
use crate::plant::{Plant, Twin};
use crate::recording::Row;
use crate::recording::rotation::Tracker;
use crate::scene::{RotationSource, Scene};
use ballrace::Wrench;
use ballrace::rotor::ShaftMotion;

/// Most samples of one run, with those that are left out at the start.
pub const MOST_SAMPLES: f64 = 1e9;

/// How long and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Samples per second.
    pub rate: f64,
    /// Samples that are left out at the start.
    pub settle: u64,
    /// Number of samples returned.
    pub samples: u64,
}

/// One sample of the response.
pub struct ResponseSample<'a> {
    /// s from the start of the scene.
    pub time: f64,
    /// Revolutions of the shaft since then.
    pub turned: f64,
    /// How the shaft moves.
    pub drive: ShaftMotion<f64>,
    /// Where the rotor is.
    pub twin: &'a dyn Twin,
    /// Its bearings.
    pub plant: &'a Plant,
}

impl ResponseSample<'_> {
    /// Force of bearing `i` on its inner ring.
    #[must_use]
    pub fn wrench(&self, i: usize) -> Wrench<f64> {
        self.plant.bearings.get(i).map_or_else(Wrench::default, |mounted| {
            self.twin.wrench(i, &mounted.rotation(mounted.kinematics.parts_at(self.turned), &self.drive))
        })
    }
}

/// Simulates the scene's rotor from equilibrium, or from the state `start`, and passes each sample after the transient to `visit`.
/// Returns how many steps overflowed and were held, and the twin at the end.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter, and the error of `visit`.
pub fn run<E: From<Error>>(
    scene: &Scene,
    plant: &Plant,
    span: Span,
    start: impl FnOnce(&mut dyn Twin),
    mut visit: impl FnMut(&ResponseSample<'_>) -> Result<(), E>,
) -> Result<(u64, Box<dyn Twin>), E> {
    let period = 1.0 / span.rate;
    let mut twin = plant.start(period, 0.0).map_err(Error::setup)?;
    start(twin.as_mut());
    let mut held = 0;
    // The scene's speed profile as a recording without columns would follow it.
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
        held += u64::from(twin.step(&drive).is_held());
    }
    Ok((held, twin))
}
