//! What a measurement adds to the motion of the shaft: gap, drift, run-out and hum of each probe, as parameters with a prior.
//!
//! The error of a reading is `x = sum of c_j b_j(t)`, with 1, a ramp over the record, cosine and sine of the multiples of the shaft angle and
//! of the mains as `b_j`. No coefficient is known; each has a normal distribution about 0, or about its value in the baseline. They are
//! marginalised: their covariance is part of the noise of a line. Where they are larger than the noise, their means are subtracted from
//! the readings first, because a bearing force is not linear in them.

use super::motion::{C, Motion, Transform};
use ballrace_plant::probes::PoseSolver;
use ballrace_scene::Direction;
use std::f64::consts::TAU;

/// Multiples of the shaft angle.
pub const HARMONICS: usize = 20;
/// Frequencies of the mains, Hz, and multiples of each.
const MAINS: [f64; 2] = [50.0, 60.0];
const MULTIPLES: usize = 4;
/// Index of the first coefficient of the run-out, and of the hum.
pub const GAP: usize = 0;
pub const DRIFT: usize = 1;
const RUN_OUT: usize = 2;
const HUM: usize = RUN_OUT + 2 * HARMONICS;
/// Coefficients of one probe.
pub const COEFFICIENTS: usize = HUM + 2 * MAINS.len() * MULTIPLES;

/// Coefficients of the error of one probe's readings, m.
pub type ReadingError = [f64; COEFFICIENTS];

/// Standard deviation of a gap before the first recording, and between recordings of one installation, m.
const GAP_FIRST: f64 = 20e-6;
const GAP_LATER: f64 = 1e-6;
/// The same along the axis: 5 K lengthen 0.2 m of a shaft so much.
const AXIAL_GAP_LATER: f64 = 12e-6;
/// Standard deviation of the drift over a record, m: some micrometres a minute at worst, more while a probe warms up.
const DRIFT_DEVIATION: f64 = 4e-6;
/// Standard deviation of the first multiple of the mains, m; further ones fall with their number.
const HUM_DEVIATION: f64 = 1e-6;
/// Standard deviation of the run-out at order 1, m, falling with the order: not measured, measured at slow roll (what the rotor moves
/// there is in it), and between recordings of one installation.
const RUN_OUT_UNKNOWN: f64 = 5e-6;
const RUN_OUT_SLOW_ROLL: f64 = 0.15e-6;
const RUN_OUT_LATER: f64 = 0.05e-6;
/// Largest part of a mean that is subtracted, in standard deviations of its prior: beyond it, a fault may be its cause.
const SUBTRACTED: f64 = 2.0;

/// What a site adds to the noise of the probes.
pub struct Site {
    pub basis: std::sync::Arc<ReadingBasis>,
    /// Expected of each probe.
    pub expected: Vec<Expected>,
    /// Per bearing: variance of each line of the waves of its races, where no sound machine has been recorded.
    pub waves: Vec<Vec<f64>>,
}

/// Squares of the lines of a probe's reading.
pub struct Expected {
    /// Variance by the errors of the readings.
    pub variance: Vec<f64>,
    /// Line of a sound machine that its model does not explain.
    pub learned: Vec<f64>,
}

/// What is known of the readings before a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knowledge {
    /// Nothing is known.
    First,
    /// The run-out has been measured at slow roll.
    SlowRoll,
    /// The errors are those of the baseline, but for what changes between recordings.
    Baseline,
}

impl Knowledge {
    /// Returns the standard deviation of each coefficient of an axial or a radial probe.
    pub fn deviations(self, direction: Direction) -> ReadingError {
        let gap_later = if direction == Direction::Axial { AXIAL_GAP_LATER } else { GAP_LATER };
        let (gap, run_out) = match self {
            Self::First => (GAP_FIRST, RUN_OUT_UNKNOWN),
            Self::SlowRoll => (GAP_FIRST, RUN_OUT_SLOW_ROLL),
            Self::Baseline => (gap_later, RUN_OUT_LATER),
        };
        std::array::from_fn(|j| match j {
            GAP => gap,
            DRIFT => DRIFT_DEVIATION,
            RUN_OUT..HUM => run_out / ((j - RUN_OUT) / 2 + 1) as f64,
            _ => HUM_DEVIATION / ((j - HUM) / 2 % MULTIPLES + 1) as f64,
        })
    }
}

/// Returns the index of cosine (0) or sine (1) of a multiple of the shaft angle, from 1.
pub const fn harmonic(order: usize, part: usize) -> usize {
    RUN_OUT + 2 * (order - 1) + part
}

/// Returns the frequency (Hz) of each multiple of the mains with the index of its cosine; the sine follows.
pub fn mains() -> impl Iterator<Item = (f64, usize)> {
    let of = |i: usize| (MAINS[i / MULTIPLES] * (i % MULTIPLES + 1) as f64, HUM + 2 * i);
    (0..MAINS.len() * MULTIPLES).map(of)
}

/// Functions of time that the errors of readings consist of, for a record.
pub struct ReadingBasis {
    /// Spectra of each function under the window.
    pub spectra: Vec<Vec<C>>,
}

/// Returns function `j` at sample `t`.
fn function(motion: &Motion, j: usize, t: usize) -> f64 {
    match j {
        GAP => 1.0,
        DRIFT => (t as f64 + 0.5) / motion.len() as f64 - 0.5,
        RUN_OUT..HUM => {
            let (order, part) = ((j - RUN_OUT) / 2 + 1, (j - RUN_OUT) % 2);
            let (s, c) = (order as f64 * motion.angle[t].radians()).sin_cos();
            if part == 0 { c } else { s }
        }
        _ => {
            let (i, part) = ((j - HUM) / 2, (j - HUM) % 2);
            let frequency = MAINS[i / MULTIPLES] * (i % MULTIPLES + 1) as f64;
            let (s, c) = (TAU * (frequency * t as f64 * motion.period).fract()).sin_cos();
            if part == 0 { c } else { s }
        }
    }
}

impl ReadingBasis {
    /// Transforms the functions over a record.
    pub fn new(transform: &Transform, motion: &Motion) -> Self {
        let pair = |i: usize| {
            let (a, b) = (2 * i, 2 * i + 1);
            transform.pair(0, |t| function(motion, a, t), |t| function(motion, b, t))
        };
        Self { spectra: (0..COEFFICIENTS / 2).flat_map(pair).collect() }
    }

    /// Returns the spectrum of an error.
    pub fn spectrum(&self, error: &ReadingError) -> Vec<C> {
        let mut sum = vec![C::new(0.0, 0.0); self.spectra.first().map_or(0, Vec::len)];
        for (x, spectrum) in error.iter().zip(&self.spectra).filter(|(x, _)| **x != 0.0) {
            sum.iter_mut().zip(spectrum).for_each(|(sum, b)| *sum += *x * *b);
        }
        sum
    }

    /// Returns the variance of each line by independent coefficients.
    ///
    /// The lines of one function are one value, and are compared as if they were independent: the variance of each is so much larger that
    /// a coefficient that deviates by its standard deviation counts as one value.
    pub fn variance(&self, deviations: &ReadingError) -> Vec<f64> {
        let mut sum = vec![0.0; self.spectra.first().map_or(0, Vec::len)];
        for (deviation, spectrum) in deviations.iter().zip(&self.spectra) {
            let (square, fourth) = spectrum.iter().fold((0.0, 0.0), |(square, fourth), x| {
                let power = x.norm_sqr();
                (square + power, fourth + power * power)
            });
            let lines = if fourth > 0.0 { square * square / fourth } else { 1.0 };
            sum.iter_mut().zip(spectrum).for_each(|(sum, x)| *sum += deviation * deviation * x.norm_sqr() * lines);
        }
        sum
    }

    /// Returns the posterior mean of the coefficients from the displacement that a machine does not explain at a probe, the variance of its
    /// lines without the error, and the prior.
    pub fn estimate(&self, unexplained: &[C], variance: &[f64], deviations: &ReadingError) -> ReadingError {
        let mut normal = nalgebra::DMatrix::<f64>::zeros(COEFFICIENTS, COEFFICIENTS);
        let mut right = nalgebra::DVector::<f64>::zeros(COEFFICIENTS);
        // In units of the deviations, so that the matrix is well conditioned.
        for i in 0..COEFFICIENTS {
            let a = &self.spectra[i];
            for j in 0..=i {
                let b = &self.spectra[j];
                let sum: f64 = a.iter().zip(b).zip(variance).map(|((a, b), v)| (a.re * b.re + a.im * b.im) / v).sum();
                normal[(i, j)] = sum * deviations[i] * deviations[j];
                normal[(j, i)] = normal[(i, j)];
            }
            normal[(i, i)] += 1.0;
            let along = a.iter().zip(unexplained).zip(variance).map(|((a, x), v)| (a.re * x.re + a.im * x.im) / v);
            right[i] = along.sum::<f64>() * deviations[i];
        }
        let Some(solution) = normal.cholesky().map(|factors| factors.solve(&right)) else { return [0.0; COEFFICIENTS] };
        std::array::from_fn(|j| solution[j] * deviations[j])
    }
}

/// Limits the part of a mean that is subtracted from the readings.
pub fn limited(mean: &ReadingError, deviations: &ReadingError) -> ReadingError {
    std::array::from_fn(|j| mean[j].clamp(-SUBTRACTED * deviations[j], SUBTRACTED * deviations[j]))
}

/// Subtracts the errors of the probes' readings from a motion.
pub fn subtract(motion: &mut Motion, solver: &PoseSolver, errors: &[ReadingError]) {
    let used: Vec<usize> = (0..COEFFICIENTS).filter(|j| errors.iter().any(|error| error[*j] != 0.0)).collect();
    let columns: Vec<_> = (0..errors.len()).map(|p| solver.column(p).to_array()).collect();
    for t in 0..motion.len() {
        let functions: Vec<(usize, f64)> = used.iter().map(|&j| (j, function(motion, j, t))).collect();
        let mut q = motion.q[t].to_array();
        for (error, column) in errors.iter().zip(&columns) {
            let x: f64 = functions.iter().map(|(j, f)| error[*j] * f).sum();
            q.iter_mut().zip(column).for_each(|(q, a)| *q -= x * a);
        }
        motion.q[t] = ballrace::Displacement::from_array(q);
    }
}
