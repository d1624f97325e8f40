//! Subjects of the benchmarks: every model, the batch beside its limit, one step of the rotor.

mod arrays;
pub mod balls;
pub mod chain;
mod models;
mod rotor;
mod yardstick;

use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry, InvalidParameter};
use ballrace::{Displacement, Exact, Fast, Phase, Scalar};
use std::time::Duration;

/// One thing to measure, in one precision and with one math backend.
pub struct Subject {
    /// Name; the table has one row for each.
    pub row: String,
    /// In which numbers; one of [`COLUMNS`].
    pub column: &'static str,
    /// Calls that one run makes.
    pub calls: u32,
    /// Makes them. Inputs differ from call to call, so nothing can be taken out of the loop. Returns the processor time of another process
    /// that made them.
    pub run: Box<dyn FnMut() -> Option<Duration>>,
}

impl Subject {
    /// Creates a subject that runs in this process.
    pub fn new(row: impl Into<String>, column: &'static str, calls: u32, mut run: impl FnMut() + 'static) -> Self {
        let run = Box::new(move || {
            run();
            None
        });
        Self { row: row.into(), column, calls, run }
    }
}

/// Precision and math backend.
pub const COLUMNS: [&str; 4] = ["f64", "f64 Fast", "f32", "f32 Fast"];

/// The batch of evaluations with radial play: opposite elements share a square root.
pub const BATCH: &str = "batch over samples: lumped, point contact, N = 8, play";
/// The same bearing preloaded: every element takes its own.
pub const BATCH_PRELOADED: &str = "batch over samples: lumped, point contact, N = 8, preload";
/// Reference of the batches.
pub const ROOTS: &str = "8 square roots over arrays";

/// All of them, those of one row side by side.
pub fn all() -> Result<Vec<Subject>, InvalidParameter> {
    let [double, double_fast, single, single_fast] = COLUMNS;
    let mut subjects = models::linear::<f64>(double)?;
    subjects.extend(models::linear::<f32>(single)?);
    subjects.extend(models::moving::<f64, Exact>(double)?);
    subjects.extend(models::moving::<f64, Fast>(double_fast)?);
    subjects.extend(models::moving::<f32, Exact>(single)?);
    subjects.extend(models::moving::<f32, Fast>(single_fast)?);
    subjects.extend(arrays::batches_and_limit::<f64>(double, f64::sqrt)?);
    subjects.extend(arrays::batches_and_limit::<f32>(single, f32::sqrt)?);
    subjects.extend(chain::all()?);
    subjects.extend(balls::all()?);
    subjects.extend(rotor::steps::<f64>(double)?);
    subjects.extend(rotor::steps::<f32>(single)?);
    subjects.extend(rotor::lines(double)?);
    Ok(side_by_side(subjects))
}

/// Sorted by row, the rows in the order of their first appearance.
fn side_by_side(subjects: Vec<Subject>) -> Vec<Subject> {
    let mut rows: Vec<Vec<Subject>> = Vec::new();
    for subject in subjects {
        match rows.iter_mut().find(|row| row.iter().any(|other| other.row == subject.row)) {
            Some(row) => row.push(subject),
            None => rows.push(vec![subject]),
        }
    }
    rows.into_iter().flatten().collect()
}

pub const RADIAL_PLAY: f64 = 5e-6;
pub const ROLLER_LENGTH: f64 = 8e-3;

/// Number of different inputs.
pub const INPUTS: u32 = 64;

/// Lengths and angles that jump about their range from `i` to `i`, -1 to 1.
pub fn scattered(i: u32, stride: f64) -> f64 {
    2.0 * (f64::from(i) * stride).fract() - 1.0
}

/// Poses of a running bearing: some elements loaded, some not, the cage anywhere.
fn poses<T: Scalar>() -> Vec<(Displacement<T>, Phase)> {
    let pose = |i| {
        let [u, v, w] = [0.618, 0.414, 0.732].map(|stride| T::from_f64(20e-6 * scattered(i, stride)));
        let [thu, thv] = [0.236, 0.303].map(|stride| T::from_f64(1e-4 * scattered(i, stride)));
        (Displacement { u, v, w, thu, thv }, Phase::from_revolutions(scattered(i, 0.577)))
    };
    (0..INPUTS).map(pose).collect()
}

/// A 6205-size ball bearing with 10 micrometres of clearance.
pub fn geometry() -> Result<BallBearingGeometry, InvalidParameter> {
    let concentric = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    concentric.with_clearance(10e-6)
}
