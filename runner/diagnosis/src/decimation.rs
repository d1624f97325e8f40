//! Low pass from several values per sample to one.

use super::HIGHEST_OVER_RATE;
use std::f64::consts::{PI, TAU};

/// Attenuation beyond the stop band, dB.
const ATTENUATION: f64 = 90.0;
/// End of the pass band and begin of the stop band, over the sampling rate: what the stop band leaves appears below the pass band's end.
const PASS: f64 = HIGHEST_OVER_RATE;
const STOP: f64 = 1.0 - PASS;

/// A windowed sinc (Kaiser) without delay.
pub struct Decimation {
    /// Values per sample.
    parts: usize,
    /// Taps from the middle one to the last; the others are their mirror image.
    taps: Vec<f64>,
}

impl Decimation {
    /// Creates the low pass for `parts` values per sample. Its gain is 1 within 0.01 % up to [`HIGHEST_OVER_RATE`].
    pub fn new(parts: usize) -> Self {
        let rate = parts as f64;
        let width = TAU * (STOP - PASS) / rate;
        // Kaiser's formulas for length and shape of the window.
        let reach = (0.5 * (ATTENUATION - 7.95) / (2.285 * width)).ceil();
        let shape = 0.1102 * (ATTENUATION - 8.7);
        let cut = (PASS + STOP) / rate;
        let tap = |k: usize| {
            let k = k as f64;
            let sinc = if k == 0.0 { cut } else { (PI * cut * k).sin() / (PI * k) };
            sinc * bessel_i0(shape * (1.0 - (k / (reach + 1.0)).powi(2)).sqrt())
        };
        let taps: Vec<f64> = (0..=reach as usize).map(tap).collect();
        let sum = 2.0 * taps.iter().sum::<f64>() - taps[0];
        Self { parts, taps: taps.into_iter().map(|tap| tap / sum).collect() }
    }

    /// Adds the value at `part` of the values of all samples to those of the samples about it.
    pub fn add<const N: usize>(&self, part: usize, value: &[f64; N], sums: &mut [[f64; N]]) {
        let reach = self.taps.len() - 1;
        let first = part.saturating_sub(reach).div_ceil(self.parts);
        let last = (part + reach) / self.parts;
        for (t, sum) in sums.iter_mut().enumerate().take(last + 1).skip(first) {
            let tap = self.taps[(t * self.parts).abs_diff(part)];
            sum.iter_mut().zip(value).for_each(|(sum, x)| *sum += tap * x);
        }
    }
}

/// Modified Bessel function of the first kind and order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (0.5 * x / k).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cosine in the pass band stays as it is; of one in the stop band, which would appear as a line in use, nothing is left.
    #[test]
    fn lines_pass_unchanged_and_do_not_fold() {
        const SAMPLES: usize = 400;
        let low_pass = Decimation::new(4);
        let largest_error = |frequency: f64, expected: f64| {
            let cosine = |t: f64| (TAU * frequency * t).cos();
            let mut sums = vec![[0.0]; SAMPLES];
            for part in 0..4 * SAMPLES {
                low_pass.add(part, &[cosine(part as f64 / 4.0)], &mut sums);
            }
            let error = |t: usize| (sums[t][0] - expected * cosine(t as f64)).abs();
            (20..SAMPLES - 20).map(error).fold(0.0, f64::max)
        };
        for frequency in [0.0, 0.02, 0.1, 0.16] {
            assert!(largest_error(frequency, 1.0) < 1e-4, "{frequency}: {}", largest_error(frequency, 1.0));
        }
        for frequency in [0.84, 0.95, 1.0, 1.07, 1.9] {
            assert!(largest_error(frequency, 0.0) < 1e-4, "{frequency}: {}", largest_error(frequency, 0.0));
        }
    }
}
