//! Filter that keeps the lines of a displacement above the noise of the probes.
//!
//! The force of a bearing is strongly nonlinear where its balls are deflected by no more than the noise: evaluated at the raw
//! readings, its mean would be biased. It is evaluated at the lines above the noise, and linearised for the rest.

use super::motion::{C, D, Motion, Transform};
use ballrace::Displacement;
use rustfft::Fft;
use std::sync::Arc;

/// Ratio of the power of a line to that of noise above which it is kept; noise alone passes in 1 of 1000 lines.
const ONE: f64 = 7.0;
/// The same ratio for the mean of a line and two neighbours on each side; noise alone passes in 1 of 200 lines.
const MEAN_OF_FIVE: f64 = 2.5;

/// Filter that keeps the lines above the noise, coordinate by coordinate.
pub(crate) struct LineFilter {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    kept: [Vec<bool>; D],
}

/// Returns the straight line through the ends of coordinate `i`: without it, the periodic continuation of the record has no jump.
fn trend(q: &[[f64; D]], i: usize) -> impl Fn(usize) -> f64 {
    let (first, last) = (q[0][i], q[q.len() - 1][i]);
    let steps = (q.len() - 1).max(1) as f64;
    move |t| first + (last - first) * t as f64 / steps
}

impl LineFilter {
    /// Finds the lines of `q` above white noise with these standard deviations, by the transforms of its length.
    pub fn new(q: &[[f64; D]], noise: [f64; D], [forward, inverse]: [Arc<dyn Fft<f64>>; 2]) -> Self {
        let n = q.len();
        let kept = std::array::from_fn(|i| {
            let trend = trend(q, i);
            let mut lines: Vec<C> = (0..n).map(|t| C::new(q[t][i] - trend(t), 0.0)).collect();
            forward.process(&mut lines);
            let unit = (n as f64 * noise[i] * noise[i]).max(f64::MIN_POSITIVE);
            let power: Vec<f64> = lines.iter().map(|x| x.norm_sqr() / unit).collect();
            let at = |k: usize, offset: usize| power[(k + n + offset - 2) % n];
            let stands_out =
                |k: usize| power[k] > ONE || (0..5).map(|offset| at(k, offset)).sum::<f64>() > 5.0 * MEAN_OF_FIVE;
            (0..n).map(stands_out).collect()
        });
        Self { forward, inverse, kept }
    }

    /// Returns the part of `q` in the kept lines.
    pub fn apply(&self, q: &[[f64; D]]) -> Vec<[f64; D]> {
        let n = q.len();
        let mut out = vec![[0.0; D]; n];
        for (i, kept) in self.kept.iter().enumerate() {
            let trend = trend(q, i);
            let mut lines: Vec<C> = (0..n).map(|t| C::new(q[t][i] - trend(t), 0.0)).collect();
            self.forward.process(&mut lines);
            for (line, kept) in lines.iter_mut().zip(kept) {
                *line = if *kept { *line / n as f64 } else { C::new(0.0, 0.0) };
            }
            self.inverse.process(&mut lines);
            for (t, (out, line)) in out.iter_mut().zip(&lines).enumerate() {
                out[i] = line.re + trend(t);
            }
        }
        out
    }
}

/// The displacement of a motion, divided into its lines above the noise of the probes and the rest.
pub(crate) struct Filtered {
    pub filter: LineFilter,
    pub q: Vec<[f64; D]>,
    pub rest: Vec<[f64; D]>,
    pub displacement: Arc<[[Vec<C>; D]; 3]>,
    pub rest_lines: Arc<[Vec<C>; D]>,
}

impl Filtered {
    /// Divides the displacement of a motion, which keeps its lines above white noise with these standard deviations.
    pub fn new(motion: &mut Motion, noise: [f64; D], transform: &Transform) -> Self {
        let whole: Vec<[f64; D]> = motion.q.iter().map(|q| q.to_array()).collect();
        let filter = LineFilter::new(&whole, noise, transform.plans());
        let q = filter.apply(&whole);
        let displacement = Arc::new(std::array::from_fn(|order| transform.five(order, |t| q[t])));
        let rest: Vec<[f64; D]> = whole.iter().zip(&q).map(|(q, f)| std::array::from_fn(|i| q[i] - f[i])).collect();
        let rest_lines = Arc::new(transform.five(0, |t| rest[t]));
        motion.q = q.iter().copied().map(Displacement::from_array).collect();
        Self { filter, q, rest, displacement, rest_lines }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::Normal;

    #[test]
    fn a_line_is_kept_and_noise_is_not() {
        let n = 4096;
        let mut normal = Normal::new();
        let pure: Vec<[f64; D]> = (0..n).map(|t| [(0.3 * t as f64).sin(), 0.0, 0.0, 1.0, 0.0]).collect();
        let noise = 0.2;
        let noisy: Vec<[f64; D]> = pure.iter().map(|q| q.map(|x| x + noise * normal.next())).collect();
        let plans = Transform::new(n, 1e-4, 1.0, [0.0, 0.12]).plans();
        let filtered = LineFilter::new(&noisy, [noise; D], plans).apply(&noisy);
        for i in 0..D {
            let rms = filtered.iter().zip(&pure).map(|(a, b)| (a[i] - b[i]).powi(2)).sum::<f64>() / n as f64;
            // The trend takes the noise of two samples.
            assert!(rms.sqrt() < noise, "{i}: {}", rms.sqrt());
        }
    }
}
