//! Poses of the scene's bearings over its motion, measured or computed.

use ballrace::{BearingKinematicState, Displacement};
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result, TradeError};
use ballrace_plant::motion::{self, Span};
use ballrace_plant::probes::PoseSolver;
use ballrace_recording::Reader;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_scene::{Recording, Scene};
use std::f64::consts::TAU;

/// Number of samples per revolution of a computed motion.
pub(crate) const SAMPLES_PER_REVOLUTION: f64 = 128.0;
/// Number of revolutions of a computed motion.
pub const TURNS: f64 = 16.0;
/// Largest number of poses of a bearing.
const MAX_POSES: usize = 512;
/// Samples per second at standstill.
const STILL_RATE: f64 = 10e3;

/// Displacement and kinematic state of one bearing at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// Displacement by the rotor's motion.
    pub u: Displacement<f64>,
    /// Angles and speeds of the components.
    pub at: BearingKinematicState<f64>,
}

/// Poses of every bearing in the scene's order, at most `MAX_POSES` of each.
pub type Poses = Vec<Vec<Pose>>;

/// Returns rate and length of a computed motion.
#[must_use]
pub fn span(scene: &Scene, plant: &Plant) -> Span {
    let turning = [scene.shaft.speed.at(0.0), scene.shaft.speed.nominal(), scene.shaft.speed.at(f64::MAX)];
    let fastest = turning.into_iter().map(f64::abs).filter(|w| w.is_finite()).fold(0.0, f64::max) / TAU;
    let rate = if fastest > 0.0 { fastest * SAMPLES_PER_REVOLUTION } else { STILL_RATE };
    // The transient after a change of model has then decayed to a thousandth.
    let settle = 0.6 * plant.settling_time() * rate;
    let ramp = match scene.shaft.speed {
        ballrace_scene::Speed::Ramp { over, .. } => over.min(TURNS / fastest.max(1e-9) * 8.0) * rate,
        _ => 0.0,
    };
    Span { rate, settle: settle.ceil() as u64, samples: (TURNS * SAMPLES_PER_REVOLUTION).max(ramp.ceil()) as u64 }
}

/// Returns the poses of the motion that the plant computes.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn computed(scene: &Scene, plant: &Plant) -> Result<Poses> {
    computed_over(scene, plant, span(scene, plant))
}

/// Returns the poses of the motion that the plant computes over `span`.
///
/// # Errors
/// As [`computed`].
pub(crate) fn computed_over(scene: &Scene, plant: &Plant, span: Span) -> Result<Poses> {
    let stride = span.samples.div_ceil(MAX_POSES as u64).max(1);
    let mut poses = vec![Vec::new(); plant.bearings.len()];
    let mut count = 0;
    motion::run(
        scene,
        plant,
        span,
        |_| {},
        |now| {
            if count % stride == 0 {
                for (i, (poses, mounted)) in poses.iter_mut().zip(&plant.bearings).enumerate() {
                    let u = plant.displacement(i, now.twin.coordinates());
                    poses.push(Pose { u, at: mounted.rotation(mounted.kinematics.parts_at(now.turned), &now.drive) });
                }
            }
            count += 1;
            Ok::<_, Error>(())
        },
    )?;
    Ok(poses)
}

/// Returns the poses of the scene's recording; samples with a missing reading are omitted. The axial position is that of the
/// static equilibrium where no probe measures it. Reads at most `most_rows` rows.
///
/// # Errors
/// Returns an error if the recording cannot be read or the probes do not determine the position.
pub fn measured(scene: &Scene, plant: &Plant, recording: &Recording, most_rows: usize) -> Result<Poses> {
    let path = &recording.file;
    let mut reader = Reader::open(path, recording)?;
    let stations: Vec<f64> = plant.bearings.iter().map(|s| s.station).collect();
    let solver = PoseSolver::try_new(&recording.probes, &stations).map_err(Error::in_file(&scene.path))?;
    let mut tracker = Tracker::of(recording, reader.rate(), scene.shaft.speed).with_run_out(RunOut::of(scene)?);
    let mut all = vec![Vec::new(); plant.bearings.len()];
    let rest = plant.pose(&plant.rest);
    let mut take = |tracker: &mut Tracker| {
        while let Some(sample) = tracker.pop() {
            let pose = solver.pose(&sample.row.probes, rest.w);
            let drive = sample.shaft_motion();
            let turned = sample.total_revolutions();
            if pose.is_finite() {
                for (poses, mounted) in all.iter_mut().zip(&plant.bearings) {
                    let at = mounted.rotation(mounted.kinematics.parts_at(turned), &drive);
                    poses.push(Pose { u: pose.at_station(mounted.station), at });
                }
            }
            tracker.recycle(sample.row);
        }
    };
    for _ in 0..most_rows {
        let mut row = tracker.blank();
        if !reader.next_row(&mut row)? {
            break;
        }
        tracker.push(row)?;
        take(&mut tracker);
    }
    tracker.finish()?;
    take(&mut tracker);
    let thinned: Poses = all
        .iter()
        .map(|poses: &Vec<Pose>| poses.iter().step_by(poses.len().div_ceil(MAX_POSES).max(1)).copied().collect())
        .collect();
    if thinned.iter().any(Vec::is_empty) {
        return Err(TradeError::NoSample { file: path.clone() }.into());
    }
    Ok(thinned)
}
