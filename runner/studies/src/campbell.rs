//! Natural frequencies, damping and whirl of a scene's rotor over the shaft speed, linearised at the static equilibrium of
//! each speed.

mod branch;
mod mode_shape;

pub use branch::{BranchPoint, CriticalSpeed, ModeBranch, branches, critical_speeds};
pub use mode_shape::{ModeShape, ModeShapePoint, mode_shapes, nominal_mode_shapes};

use ballrace_base::eigenvalues::{eigenvalues, resolution};
use ballrace_outcome::RotorOutcome;
use ballrace_plant::{Plant, PlantError, Result};
use ballrace_scene::{Scene, Speed};
use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;
use std::f64::consts::TAU;

/// Modes at one speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AtSpeed {
    /// Shaft speed.
    pub speed_rpm: f64,
    /// Modes, lowest frequency first; unsupported directions have none.
    pub modes: Vec<Mode>,
    /// The flexible rotor and the error of its reduced model at this speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<RotorOutcome>,
}

/// One mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mode {
    /// Damped natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping over critical damping.
    pub damping_ratio: f64,
    /// Direction of whirl.
    pub whirl: Whirl,
}

/// Direction of whirl of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Whirl {
    /// In the positive sense of shaft rotation.
    Forward,
    /// Against it.
    Backward,
    /// Along a line.
    Straight,
}

impl Whirl {
    /// Returns the name as in JSON and CSV.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
            Self::Straight => "straight",
        }
    }
}

/// Relative distance below which two modes are a degenerate pair, whose whirl is undefined.
const PAIR: f64 = 1e-7;
/// Lever by which tilts are compared with displacements, m.
const LEVER: f64 = 0.1;
/// Real parts below this share of the largest eigenvalue are rounding errors.
const ROUNDING: f64 = 1e-13;
/// Ratio of the whirl to the motion below which the mode is a straight line.
const ROUND: f64 = 1e-3;

/// Computes the modes at each speed (rad/s).
///
/// # Errors
/// Returns an error if the scene has no rotor, the kernel rejects a parameter or eigenvalues cannot be computed.
pub fn campbell(scene: &Scene, speeds: &[f64]) -> Result<Vec<AtSpeed>> {
    let at_speed = |speed: f64| {
        let mut turning = scene.clone();
        turning.shaft.speed = Speed::Constant(speed);
        turning
    };
    // Every speed uses the coordinates that the highest speed requires, so that the curves do not jump.
    let highest = speeds.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
    let of_highest = Plant::try_new(&at_speed(highest))?;
    let at = |&speed: &f64| -> Result<AtSpeed> {
        let turning = at_speed(speed);
        let plant = Plant::alike(&turning, &of_highest)?;
        let modes = modes(&plant, speed, true)?;
        Ok(AtSpeed { speed_rpm: speed * 60.0 / TAU, modes, rotor: plant.rotor_outcome(&turning) })
    };
    speeds.iter().map(at).collect()
}

/// Computes the modes of `M q'' + (B + w G) q' + K q = 0`, lowest frequency first.
///
/// `w` is the shaft speed `speed`, rad/s. The damping matrix `B` is zero unless `damped`.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter or eigenvalues cannot be computed.
pub fn modes(plant: &Plant, speed: f64, damped: bool) -> Result<Vec<Mode>> {
    let system = state_matrix(plant, speed, damped)?;
    Ok(modes_of(&system, plant)?.into_iter().map(|(mode, _)| mode).collect())
}

/// Returns the matrix `A` of `z' = A z` with `z = [q q']`.
fn state_matrix(plant: &Plant, speed: f64, damped: bool) -> Result<DMatrix<f64>> {
    let (scales, n) = (plant.scales()?, plant.layout.order);
    let inverse = scales.mass.try_inverse().ok_or(PlantError::SingularMass)?;
    let stiffness = &inverse * &plant.stiffness;
    let damping = &inverse * (scales.damping * f64::from(u8::from(damped)) + scales.gyroscopic * speed);
    let mut system = DMatrix::<f64>::zeros(2 * n, 2 * n);
    system.view_mut((0, n), (n, n)).fill_with_identity();
    system.view_mut((n, 0), (n, n)).copy_from(&(-stiffness));
    system.view_mut((n, n), (n, n)).copy_from(&(-damping));
    Ok(system)
}

/// Returns the modes with their eigenvalues, lowest frequency first.
fn modes_of(system: &DMatrix<f64>, plant: &Plant) -> Result<Vec<(Mode, Complex<f64>)>> {
    let all = eigenvalues(system)?;
    let least = resolution(&all);
    let mut values: Vec<Complex<f64>> = all.into_iter().filter(|value| value.im > least).collect();
    values.sort_by(|a, b| a.im.total_cmp(&b.im));
    let alone = |i: usize| {
        let near = |j: Option<usize>| {
            j.and_then(|j| values.get(j)).zip(values.get(i)).is_some_and(|(a, b)| (a - b).norm() < PAIR * b.norm())
        };
        !near(i.checked_sub(1)) && !near(i.checked_add(1))
    };
    let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let decay = |value: &Complex<f64>| if value.re.abs() > ROUNDING * largest { -value.re } else { 0.0 };
    let mode = |(i, value): (usize, &Complex<f64>)| {
        let mode = Mode {
            frequency_hz: value.im / TAU,
            damping_ratio: decay(value) / value.norm(),
            whirl: if alone(i) { whirl(system, *value, plant) } else { Whirl::Straight },
        };
        (mode, *value)
    };
    Ok(values.iter().enumerate().map(mode).collect())
}

/// Computes the eigenvector of an eigenvalue by inverse iteration; `None` if the shifted matrix is singular.
fn eigenvector(system: &DMatrix<f64>, value: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let size = system.nrows();
    let shift = value * Complex::new(1.0 + 1e-8, 1e-9);
    let shifted = DMatrix::from_fn(size, size, |i, j| {
        Complex::from(system[(i, j)]) - if i == j { shift } else { Complex::from(0.0) }
    });
    let factors = shifted.lu();
    let mut shape = DVector::from_fn(size, |i, _| Complex::new(1.0, 0.37 * i as f64));
    for _ in 0..4 {
        let next = factors.solve(&shape)?;
        shape = next.unscale(next.norm().max(f64::MIN_POSITIVE));
    }
    Some(shape)
}

/// Returns the direction of whirl from the mode shape.
fn whirl(system: &DMatrix<f64>, value: Complex<f64>, plant: &Plant) -> Whirl {
    let Some(shape) = eigenvector(system, value) else { return Whirl::Straight };
    // A vector (x, y) e^(i w t) turns forward where x y* has a positive imaginary part; tilts turn as (thv, -thu) does.
    let turning = |x: Complex<f64>, y: Complex<f64>| ((x * y.conj()).im, x.norm_sqr() + y.norm_sqr());
    let part = |of: fn(&Complex<f64>) -> f64| plant.pose(&shape.iter().map(of).collect::<Vec<f64>>()).to_array();
    let (re, im) = (part(|z| z.re), part(|z| z.im));
    let at = |i: usize| Complex::new(re[i], im[i]);
    let [along, tilting] = [turning(at(0), at(1)), turning(at(4), -at(3))];
    let share = |(turn, all): (f64, f64)| if all > 0.0 { 2.0 * turn / all } else { 0.0 };
    let larger = if along.1 > tilting.1 * LEVER * LEVER { along } else { tilting };
    // An axial mode has no whirl.
    let round = if at(2).norm_sqr() > along.1.max(tilting.1 * LEVER * LEVER) { 0.0 } else { share(larger) };
    match round {
        turn if turn > ROUND => Whirl::Forward,
        turn if turn < -ROUND => Whirl::Backward,
        _ => Whirl::Straight,
    }
}
