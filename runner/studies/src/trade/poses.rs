//! Poses of the scene's bearings: over its motion, measured or computed, or about the preload of bearings without a rotor.

use ballrace::bearing::checksum::{CHECKSUM_SAMPLES, ChecksumRange};
use ballrace::{BearingKinematicState, Displacement};
use ballrace_models::build;
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result, TradeError};
use ballrace_plant::motion::{self, Span};
use ballrace_plant::probes::PoseSolver;
use ballrace_recording::Reader;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_scene::{Bearing, Recording, Scene};
use std::f64::consts::TAU;

/// Number of samples per revolution of a computed motion.
pub(crate) const SAMPLES_PER_REVOLUTION: f64 = 128.0;
/// Number of revolutions of a computed motion.
pub const TURNS: f64 = 16.0;
/// Largest number of poses of a bearing.
const MAX_POSES: usize = 512;
/// Samples per second at standstill.
const STILL_RATE: f64 = 10e3;

/// First and last speed over a constant shaft speed; both are inside a table's default range.
const SPEEDS: [f64; 2] = [0.9, 1.1];
/// Elastic approach over ball diameter, for a scene without poses.
const RELATIVE_APPROACH: f64 = 5e-4;
/// Approach, m, and radius of the elements' circle, m, of a bearing without geometry.
const SMALL: f64 = 10e-6;
const RADIUS: f64 = 20e-3;

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

/// Returns poses of bearings without a rotor: displacements about that by preload, at and beyond which contact is made and lost.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn about_preload(scene: &Scene) -> Result<Poses> {
    let of_bearing = |of: &Bearing| {
        let offset = build::offset_as_mounted(scene, of)?;
        let (centre, amplitude) = about_offset(of, &offset);
        let range = ChecksumRange {
            centre: Displacement::from_array(centre.map(three_digits)),
            amplitude: Displacement::from_array(amplitude.map(three_digits)),
            inner_speed: speeds(scene.shaft.speed.range()),
            outer_speed: [three_digits(scene.shaft.outer_speed), 0.0],
        };
        let stride = usize::from(CHECKSUM_SAMPLES).div_ceil(MAX_POSES);
        Ok(range.samples().step_by(stride).map(|sample| pose_of_sample(&sample, &offset)).collect())
    };
    scene.bearings.iter().map(of_bearing).collect()
}

/// Centre and amplitude of a range.
pub(crate) type Extent = ([f64; 5], [f64; 5]);

/// Returns centre and amplitudes about the displacement by preload, for a scene without poses.
pub(crate) fn about_offset(of: &Bearing, offset: &Displacement<f64>) -> Extent {
    let play = build::law(of).map_or(0.0, |(_, _, play)| play.abs());
    let elastic = of.diameters().map_or(SMALL, |[element, _]| RELATIVE_APPROACH * element);
    let approach = of.table.and_then(|table| table.approach).map_or(elastic, |[_, most]| 0.4 * most);
    let along = approach + play;
    let tilt = 0.3 * along / radius(of);
    let centre = offset.to_array();
    let mut amplitude = [along, along, along, tilt, tilt];
    // The displacement 0, at which preloaded rings do not touch, is inside.
    for (x, by_preload) in amplitude.iter_mut().zip(centre) {
        *x = x.max(1.2 * by_preload.abs());
    }
    (centre, amplitude)
}

pub(crate) fn radius(of: &Bearing) -> f64 {
    of.diameters().map_or(RADIUS, |[_, pitch]| 0.5 * pitch)
}

/// Returns the speed of the first sample and its increment.
pub(crate) fn speeds((low, high): (f64, f64)) -> [f32; 2] {
    let [first, last] = if low == high { SPEEDS.map(|part| part * low) } else { [low, high] };
    [three_digits(first), three_digits((last - first) / f64::from(CHECKSUM_SAMPLES))]
}

/// Returns the number rounded to three digits, the same on every desktop.
pub(crate) fn three_digits(x: f64) -> f32 {
    format!("{x:.2e}").parse().unwrap_or(0.0)
}

pub(crate) fn pose_of_sample(
    (u, at): &(Displacement<f32>, BearingKinematicState<f32>),
    offset: &Displacement<f64>,
) -> Pose {
    let mut rotor = u.to_array().map(f64::from);
    for (x, by_preload) in rotor.iter_mut().zip(offset.to_array()) {
        *x -= by_preload;
    }
    let at = BearingKinematicState {
        cage: at.cage,
        inner: at.inner,
        outer: at.outer,
        ball: at.ball,
        inner_speed: f64::from(at.inner_speed),
        outer_speed: f64::from(at.outer_speed),
    };
    Pose { u: Displacement::from_array(rotor), at }
}
