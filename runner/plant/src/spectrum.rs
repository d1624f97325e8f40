//! Amplitude spectra: the windowed transform behind every spectrum of this library, and averaged spectra of a stream of samples
//! by Welch's method with 50 % overlap.

use crate::probes::Plane;
use ballrace::math::Math;
use ballrace::twin::{OrderSums, OrderVector, RevolutionBlock};
use ballrace::{Exact, Phase};
use ballrace_outcome::SpectraSettings;
use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// Length of the longest segment, samples.
const LONGEST: usize = 4096;

/// Discrete Fourier transform of real samples about their mean, under a periodic Hann window.
pub struct WindowedTransform {
    fft: Arc<dyn RealToComplex<f64>>,
    window: Vec<f64>,
    /// Inverse of the sum of the window.
    scale: f64,
}

impl WindowedTransform {
    /// Creates the transform of `length` samples.
    pub fn new(length: usize) -> Self {
        let step = std::f64::consts::TAU / length as f64;
        let window: Vec<f64> = (0..length).map(|i| 0.5 * (1.0 - (i as f64 * step).cos())).collect();
        let scale = 1.0 / window.iter().sum::<f64>();
        Self { fft: RealFftPlanner::new().plan_fft_forward(length), window, scale }
    }

    /// Returns the number of samples.
    pub fn length(&self) -> usize {
        self.window.len()
    }

    /// Returns the bins from 0 Hz to half the rate. The magnitude of a bin is half the zero-to-peak amplitude of a sine there.
    pub fn bins(&self, samples: &[f64]) -> Vec<Complex<f64>> {
        let samples = samples.get(..self.length()).unwrap_or(samples);
        let mean = samples.iter().sum::<f64>() / samples.len().max(1) as f64;
        let mut input: Vec<f64> = samples.iter().zip(&self.window).map(|(s, w)| (s - mean) * w * self.scale).collect();
        let mut bins = self.fft.make_output_vec();
        // The lengths agree by construction; a disagreement would leave the bins at zero.
        let _ = self.fft.process(&mut input, &mut bins);
        bins
    }
}

/// Returns the squared amplitudes of the circular motions in the plane motion `x + jy`: forward (with the shaft) and reverse,
/// bin by bin.
pub fn circular_power<'a>(x: &'a [Complex<f64>], y: &'a [Complex<f64>]) -> impl Iterator<Item = [f64; 2]> + use<'a> {
    let j = Complex::new(0.0, 1.0);
    x.iter().zip(y).map(move |(x, y)| [(x + j * y).norm_sqr(), (x - j * y).norm_sqr()])
}

/// Returns the amplitude spectrum of `samples` about their mean under a Hann window: at each multiple of the sample rate
/// over their number, up to half the rate, the zero-to-peak amplitude of a sine there, in the unit of the samples.
#[must_use]
pub fn amplitudes(samples: &[f64]) -> Vec<f64> {
    WindowedTransform::new(samples.len()).bins(samples).iter().map(|bin| 2.0 * bin.norm()).collect()
}

/// Returns the amplitudes of cosine and sine of a line in `samples` about their mean, under a Hann window over all of them, by the
/// kernel's order tracking; `phases` are the phases of the line at the samples.
pub fn line(samples: &[f64], phases: impl Iterator<Item = Phase>) -> OrderVector<f64> {
    let count = samples.len().max(1) as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let share = Phase::from_revolutions(1.0 / count);
    let (mut block, mut sums) = (RevolutionBlock::<f64, f64>::new(), OrderSums::<f64, f64>::new());
    for (sample, phase) in samples.iter().zip(phases) {
        sums.add(block.window::<Exact>() * (sample - mean), Exact::sin_cos(phase));
        block.advance(share);
    }
    sums.close(block.close())
}

/// Adds the power of a transform: the square of the amplitude at each bin.
fn add_power(power: &mut [f64], bins: impl Iterator<Item = Complex<f64>>) {
    for (sum, bin) in power.iter_mut().zip(bins) {
        *sum += 4.0 * bin.norm_sqr();
    }
}

/// Averaged one-sided amplitude spectra (peak amplitude of a sine) of measured and computed readings sampled together, of their difference,
/// and full spectra of the motions in planes.
///
/// Only the readings are transformed: the transform of a difference, or of X and Y, is the same combination of their transforms.
pub struct Welch {
    transform: WindowedTransform,
    planes: Vec<Plane>,
    /// The last `LONGEST` samples of each signal: the measured readings, then the computed ones.
    pending: Vec<Vec<f64>>,
    /// Power of the measured readings, of the computed ones and of their differences.
    power: Vec<Vec<f64>>,
    /// Power of the forward and of the reverse part of each plane, measured, then computed.
    full: Vec<[Vec<f64>; 2]>,
    segments: f64,
}

impl Welch {
    /// Creates the spectra of `probes` probes, of which some form `planes`.
    #[must_use]
    pub fn new(probes: usize, planes: Vec<Plane>) -> Self {
        let mut welch = Self {
            transform: WindowedTransform::new(LONGEST),
            planes,
            pending: vec![Vec::with_capacity(LONGEST); 2 * probes],
            power: vec![],
            full: vec![],
            segments: 0.0,
        };
        welch.clear();
        welch
    }

    fn length(&self) -> usize {
        self.transform.length()
    }

    fn clear(&mut self) {
        let bins = self.length() / 2 + 1;
        self.power = vec![vec![0.0; bins]; self.pending.len() / 2 * 3];
        self.full = vec![[vec![0.0; bins], vec![0.0; bins]]; 2 * self.planes.len()];
    }

    /// Adds one sample: the measured readings, then the computed ones.
    pub fn add(&mut self, signals: &[f64]) {
        for (pending, value) in self.pending.iter_mut().zip(signals) {
            pending.push(*value);
        }
        if self.pending.first().is_some_and(|p| p.len() >= self.length()) {
            self.segment();
            let half = self.length() / 2;
            for pending in &mut self.pending {
                pending.drain(..half);
            }
        }
    }

    /// Discards the samples not yet transformed, because a segment may not extend over a gap.
    pub fn interrupt(&mut self) {
        for pending in &mut self.pending {
            pending.clear();
        }
    }

    fn segment(&mut self) {
        let spectra: Vec<Vec<Complex<f64>>> = self.pending.iter().map(|p| self.transform.bins(p)).collect();
        let (measured, computed) = spectra.split_at(spectra.len() / 2);
        for (power, spectrum) in self.power.iter_mut().zip(&spectra) {
            add_power(power, spectrum.iter().copied());
        }
        let differences = measured.iter().zip(computed).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b));
        for (power, difference) in self.power.iter_mut().skip(spectra.len()).zip(differences) {
            add_power(power, difference);
        }
        let planes =
            [measured, computed].into_iter().flat_map(|readings| self.planes.iter().map(move |p| (p, readings)));
        for ((plane, readings), [forward, reverse]) in planes.zip(&mut self.full) {
            let [Some(a), Some(b)] = plane.probes.map(|probe| readings.get(probe)) else { continue };
            let (x, y): (Vec<_>, Vec<_>) = a.iter().zip(b).map(|(&a, &b)| plane.xy_from(a, b)).unzip();
            for ((forward, reverse), power) in forward.iter_mut().zip(reverse).zip(circular_power(&x, &y)) {
                *forward += power[0];
                *reverse += power[1];
            }
        }
        self.segments += 1.0;
    }

    /// Ends the recording; one shorter segment is evaluated where there is no complete one.
    pub fn finish(&mut self) {
        let available = self.pending.first().map_or(0, Vec::len);
        if self.segments == 0.0 && available >= 16 {
            self.transform = WindowedTransform::new(1 << available.ilog2());
            self.clear();
            self.segment();
        }
    }

    /// Returns the settings of the spectra.
    #[must_use]
    pub fn settings(&self, rate: f64) -> SpectraSettings {
        SpectraSettings { lines: self.length() / 2, bin_hz: self.bin(rate), averages: self.segments as u64 }
    }

    /// Returns the bin width, Hz.
    #[must_use]
    pub fn bin(&self, rate: f64) -> f64 {
        rate / self.length() as f64
    }

    fn amplitudes(&self, power: &[f64]) -> Vec<f64> {
        let n = self.segments.max(1.0);
        power.iter().map(|p| (p / n).sqrt()).collect()
    }

    /// Returns the amplitude spectrum of a signal: of the measured readings, then of the computed ones, then of their differences.
    #[must_use]
    pub fn half(&self, signal: usize) -> Vec<f64> {
        self.power.get(signal).map(|p| self.amplitudes(p)).unwrap_or_default()
    }

    /// Returns the full spectrum of a plane, from the highest reverse to the highest forward frequency; measured planes come first, then
    /// computed ones.
    #[must_use]
    pub fn full(&self, plane: usize) -> Vec<f64> {
        let Some([forward, reverse]) = self.full.get(plane) else { return vec![] };
        let reverse = self.amplitudes(reverse).into_iter().skip(1).rev();
        reverse.chain(self.amplitudes(forward)).collect()
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::probes::planes;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    /// Spectra of differences and of planes are those of the differences and of X and Y themselves.
    #[test]
    fn combinations_of_transforms_are_transforms_of_combinations() {
        let scene = read_str(include_str!("../../demo/healthy.toml"), Path::new("scene.toml")).unwrap();
        let planes = planes(&scene.recording.as_ref().unwrap().probes);
        let mut welch = Welch::new(5, planes.clone());
        let value = |i: usize, signal: usize| {
            (0.3 * i as f64 + signal as f64).sin() + 0.1 * ((i * i + 7 * signal) as f64).cos()
        };
        let signals: Vec<Vec<f64>> = (0..10).map(|s| (0..LONGEST).map(|i| value(i, s)).collect()).collect();
        for i in 0..LONGEST {
            welch.add(&signals.iter().map(|signal| signal[i]).collect::<Vec<_>>());
        }
        let near = |found: &[f64], expected: &[f64]| {
            assert_eq!(found.len(), expected.len());
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{off:e}");
        };
        for probe in 0..5 {
            let difference: Vec<f64> = signals[probe].iter().zip(&signals[5 + probe]).map(|(a, b)| a - b).collect();
            near(&welch.half(10 + probe), &amplitudes(&difference));
        }
        assert_eq!(planes.len(), 2);
        for (k, (plane, first)) in
            [0, 5].into_iter().flat_map(|first| planes.iter().map(move |p| (p, first))).enumerate()
        {
            let xy = |i: usize| plane.xy(&signals[first..first + 5].iter().map(|signal| signal[i]).collect::<Vec<_>>());
            let (x, y): (Vec<f64>, Vec<f64>) = (0..LONGEST).map(xy).unzip();
            let [x, y] = [x, y].map(|samples| WindowedTransform::new(LONGEST).bins(&samples));
            let parts: Vec<[f64; 2]> = circular_power(&x, &y).map(|part| part.map(f64::sqrt)).collect();
            let reverse = parts.iter().skip(1).rev().map(|part| part[1]);
            near(&welch.full(k), &reverse.chain(parts.iter().map(|part| part[0])).collect::<Vec<_>>());
        }
    }
}
