//! What a measurement adds to the motion of the shaft: gap, drift, run-out and hum of each probe, as parameters with a prior.
//!
//! The error of a reading is `x = sum of c_j b_j(t)`, with 1, a ramp over the record, cosine and sine of the multiples of the shaft angle and
//! of the mains as `b_j`. No coefficient is known; each has a normal distribution about 0, or about its value in the baseline. They are
//! marginalised: their covariance is part of the noise of a line. Where they are larger than the noise, their means are subtracted from
//! the readings first, because a bearing force is not linear in them.

use super::motion::{C, Motion, Transform};
use ballrace_base::least_squares::dot;
use ballrace_plant::probes::PoseSolver;
use ballrace_scene::Direction;
use nalgebra::{DMatrix, DVector};
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
pub const GAP_FIRST: f64 = 20e-6;
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
    /// Gap of each probe beyond that of the baseline, m: value and standard deviation.
    pub gaps: Vec<[f64; 2]>,
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

/// Returns all functions at sample `t`.
fn functions(motion: &Motion, t: usize) -> ReadingError {
    let mut all = [0.0; COEFFICIENTS];
    all[GAP] = 1.0;
    all[DRIFT] = (t as f64 + 0.5) / motion.len() as f64 - 0.5;
    let mut multiples = |from: usize, count: usize, angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        let turn = C::new(cosine, sine);
        let mut power = turn;
        for pair in all[from..from + 2 * count].chunks_exact_mut(2) {
            pair.copy_from_slice(&[power.re, power.im]);
            power *= turn;
        }
    };
    multiples(RUN_OUT, HARMONICS, motion.angle[t].radians());
    for (i, frequency) in MAINS.into_iter().enumerate() {
        let angle = TAU * (frequency * t as f64 * motion.period).fract();
        multiples(HUM + 2 * MULTIPLES * i, MULTIPLES, angle);
    }
    all
}

impl ReadingBasis {
    /// Transforms the functions over a record.
    pub fn new(transform: &Transform, motion: &Motion) -> Self {
        let functions: Vec<ReadingError> = (0..motion.len()).map(|t| functions(motion, t)).collect();
        let pair = |i: usize| {
            let (a, b) = (2 * i, 2 * i + 1);
            transform.pair(0, |t| functions[t][a], |t| functions[t][b])
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
        let weight: Vec<f64> = variance.iter().map(|variance| variance.sqrt().recip()).collect();
        let values = |of: &[C], scale: f64| -> Vec<f64> {
            of.iter().zip(&weight).flat_map(|(x, weight)| [x.re, x.im].map(|x| scale * weight * x)).collect()
        };
        // In units of the deviations, so that the matrix is well conditioned.
        let columns: Vec<f64> = self
            .spectra
            .iter()
            .zip(deviations)
            .flat_map(|(spectrum, deviation)| values(spectrum, *deviation))
            .collect();
        let columns = DMatrix::from_vec(2 * weight.len(), COEFFICIENTS, columns);
        let rows = columns.transpose();
        let mut normal = &rows * &columns;
        (0..COEFFICIENTS).for_each(|i| normal[(i, i)] += 1.0);
        let right = rows * DVector::from_vec(values(unexplained, 1.0));
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
    let columns: Vec<_> = (0..errors.len()).map(|p| solver.column(p).to_array()).collect();
    for t in 0..motion.len() {
        let functions = functions(motion, t);
        let mut q = motion.q[t].to_array();
        for (error, column) in errors.iter().zip(&columns) {
            let x = dot(error, &functions);
            q.iter_mut().zip(column).for_each(|(q, a)| *q -= x * a);
        }
        motion.q[t] = ballrace::Displacement::from_array(q);
    }
}
