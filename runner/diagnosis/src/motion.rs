//! The measured motion of the rotor over a stretch of a recording, and its spectra under a window.

use ballrace::{Displacement, Phase};
use ballrace_plant::probes::PoseSolver;
use ballrace_recording::Sample;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Number of coordinates of a rigid rotor.
pub const D: usize = 5;
/// Complex amplitude.
pub type C = Complex<f64>;

/// Displacement of the rotor and motion of the shaft, sample by sample.
#[derive(Clone)]
pub struct Motion {
    /// Sample period, s.
    pub period: f64,
    /// Pose: displacement of the centre of mass of a rigid shaft with these readings. The axial coordinate is an estimate where no
    /// probe measures it.
    pub q: Vec<Displacement<f64>>,
    /// Total revolutions of the shaft.
    pub turns: Vec<f64>,
    /// Shaft angle.
    pub angle: Vec<Phase>,
    /// Shaft speed, rad/s.
    pub speed: Vec<f64>,
    /// Shaft acceleration, rad/s^2.
    pub acceleration: Vec<f64>,
    mean_speed: f64,
    /// Total revolutions in the middle of the record.
    pub middle: f64,
}

impl Motion {
    /// Returns the force along X and Y of a unit unbalance at angle 0, sample by sample.
    pub(crate) fn unit_unbalance(&self) -> Vec<[f64; 2]> {
        let force = |t: usize| {
            let (s, c) = self.angle[t].radians().sin_cos();
            let (w2, a) = (self.speed[t] * self.speed[t], self.acceleration[t]);
            [w2 * c + a * s, w2 * s - a * c]
        };
        (0..self.len()).map(force).collect()
    }

    /// Returns cosine and sine of a multiple of the shaft angle, sample by sample.
    pub(crate) fn harmonic(&self, order: usize) -> Vec<[f64; 2]> {
        let of = |angle: &Phase| {
            let (s, c) = (order as f64 * angle.radians()).sin_cos();
            [c, s]
        };
        self.angle.iter().map(of).collect()
    }

    /// Returns true where the measured speed changes.
    pub(crate) fn is_turning_unevenly(&self) -> bool {
        const ROUNDING: f64 = 1e-9;
        self.speed.iter().any(|speed| (speed - self.mean_speed).abs() > ROUNDING * self.mean_speed.abs())
    }

    /// Returns the motion at a shaft angle that is larger by `error`, rad, sample by sample.
    pub(crate) fn turned(&self, error: &dyn Fn(usize) -> f64) -> Self {
        let error = |t: usize| error(t) / TAU;
        Self {
            turns: self.turns.iter().enumerate().map(|(t, turns)| turns + error(t)).collect(),
            angle: self
                .angle
                .iter()
                .enumerate()
                .map(|(t, angle)| angle.wrapping_add(Phase::from_revolutions(error(t))))
                .collect(),
            ..self.clone()
        }
    }

    /// Returns the motion of consecutive samples with a reading of every probe; the axial coordinate is `axial` where no probe
    /// measures it.
    pub fn new(samples: &[Sample], period: f64, solver: &PoseSolver, axial: f64) -> Self {
        let mut motion = Self {
            period,
            q: vec![],
            turns: vec![],
            angle: vec![],
            speed: vec![],
            acceleration: vec![],
            mean_speed: samples.iter().map(|s| s.speed).sum::<f64>() / samples.len().max(1) as f64,
            middle: samples.get(samples.len() / 2).map_or(0.0, Sample::total_revolutions),
        };
        for sample in samples {
            motion.q.push(solver.pose(&sample.row.probes, axial));
            motion.turns.push(sample.total_revolutions());
            motion.angle.push(sample.angle);
            motion.speed.push(sample.speed);
            motion.acceleration.push(sample.acceleration);
        }
        motion
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.q.len()
    }

    /// Mean shaft speed, rad/s.
    pub fn mean_speed(&self) -> f64 {
        self.mean_speed
    }
}

/// Windowed Fourier transforms of a record.
pub struct Transform {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Window and its first two derivatives by time.
    window: [Vec<f64>; 3],
    /// Angular frequency of each line in use, rad/s.
    pub lines: Vec<f64>,
    /// Sum of the squares of the window.
    pub power: f64,
}

impl Transform {
    /// Creates the transform of `n` samples at `period` (s) for lines up to `highest` (rad/s).
    ///
    /// The window begins after the share `lead` of the record and rises over the share `taper`; it falls in the same way.
    pub fn new(n: usize, period: f64, highest: f64, [lead, taper]: [f64; 2]) -> Self {
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        let length = n as f64 * period;
        let rise = taper * length;
        // sin^4: value and first three derivatives vanish at the ends.
        let k = 0.5 * PI / rise;
        let value = |i: usize| {
            let t = (i as f64 + 0.5) * period;
            let (edge, sign) = if t < 0.5 * length { (t, 1.0) } else { (length - t, -1.0) };
            let edge = edge - lead * length;
            if edge <= 0.0 {
                return [0.0; 3];
            }
            if edge >= rise {
                return [1.0, 0.0, 0.0];
            }
            let (s, c) = (k * edge).sin_cos();
            [s.powi(4), sign * 4.0 * k * s.powi(3) * c, 4.0 * k * k * s * s * (3.0 * c * c - s * s)]
        };
        let values: Vec<[f64; 3]> = (0..n).map(value).collect();
        let window = [0, 1, 2].map(|order| values.iter().map(|v| v[order]).collect::<Vec<f64>>());
        let bin = TAU / length;
        let lines = (0..n / 2).map(|k| k as f64 * bin).take_while(|w| *w <= highest).collect();
        let power = window[0].iter().map(|w| w * w).sum();
        Self { forward, inverse, window, lines, power }
    }

    /// Returns the transforms of as many samples without a window, forward and inverse.
    pub fn plans(&self) -> [Arc<dyn Fft<f64>>; 2] {
        [self.forward.clone(), self.inverse.clone()]
    }

    /// Returns the window at a share of the record.
    pub(crate) fn window_at(&self, share: f64) -> f64 {
        let window = &self.window[0];
        window[((share * window.len() as f64) as usize).min(window.len() - 1)]
    }

    /// Returns the sum of the window.
    pub fn sum(&self) -> f64 {
        self.window[0].iter().sum()
    }

    /// Transforms two real series under derivative `order` of the window.
    pub fn pair(&self, order: usize, a: impl Fn(usize) -> f64, b: impl Fn(usize) -> f64) -> [Vec<C>; 2] {
        let n = self.window[0].len();
        let mut both: Vec<C> = (0..n).map(|i| C::new(a(i), b(i)) * self.window[order][i]).collect();
        self.forward.process(&mut both);
        let m = self.lines.len();
        let (mut first, mut second) = (Vec::with_capacity(m), Vec::with_capacity(m));
        for k in 0..m {
            let (x, y) = (both[k], both[(n - k) % n].conj());
            first.push(0.5 * (x + y));
            second.push(C::new(0.0, -0.5) * (x - y));
        }
        [first, second]
    }

    /// Transforms a complex series: all lines, positive and negative.
    pub fn full(&self, of: impl Fn(usize) -> C) -> Vec<C> {
        let mut all: Vec<C> = self.window[0].iter().enumerate().map(|(t, w)| of(t) * *w).collect();
        self.forward.process(&mut all);
        all
    }

    /// Transforms the third and the fourth of five real series, as [`Transform::five`] does.
    pub fn axial_pair(&self, order: usize, of: impl Fn(usize) -> [f64; D]) -> [Vec<C>; 2] {
        self.pair(order, |i| of(i)[2], |i| of(i)[3])
    }

    /// Transforms five real series under derivative `order` of the window.
    pub fn five(&self, order: usize, of: impl Fn(usize) -> [f64; D]) -> [Vec<C>; D] {
        let [a, b] = self.pair(order, |i| of(i)[0], |i| of(i)[1]);
        let [c, d] = self.axial_pair(order, &of);
        let [e, _] = self.pair(order, |i| of(i)[4], |_| 0.0);
        [a, b, c, d, e]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transform of the derivative of a motion, without differentiating it.
    #[test]
    fn derivatives_by_the_window() {
        let (n, period, w) = (4096, 1e-4, 300.0);
        let transform = Transform::new(n, period, 2000.0, [0.0, 0.12]);
        let q = |t: usize| (w * t as f64 * period).sin();
        let five =
            |order: usize, of: &dyn Fn(usize) -> f64| transform.five(order, |t| [of(t), 0.0, 0.0, 0.0, 0.0])[0].clone();
        let [s0, s1, s2] = [0, 1, 2].map(|order| five(order, &q));
        let rate = five(0, &|t| w * (w * t as f64 * period).cos());
        let acceleration = five(0, &|t| -w * w * q(t));
        let size = rate.iter().map(|x| x.norm()).fold(0.0, f64::max);
        for (k, line) in transform.lines.iter().enumerate() {
            let first = C::new(0.0, *line) * s0[k] - s1[k];
            let second = -line * line * s0[k] - C::new(0.0, 2.0 * line) * s1[k] + s2[k];
            assert!((first - rate[k]).norm() < 1e-4 * size, "{line}: {}", (first - rate[k]).norm() / size);
            assert!(
                (second - acceleration[k]).norm() < 1e-4 * size * w,
                "{line}: {}",
                (second - acceleration[k]).norm() / (size * w)
            );
        }
    }
}
