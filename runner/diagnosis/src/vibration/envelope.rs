//! Squared envelope of a pre-whitened vibration signal, and its spectrum.
//!
//! A damaged race causes impacts at its ball-pass frequency, and each impact excites resonances of the structure that
//! are not known beforehand. Cepstrum pre-whitening sets the magnitude of every bin of the signal's transform to 1 and
//! keeps its phase (the real cepstrum is zero but for its first value): resonances and discrete lines of shaft, gears
//! and supply weigh as much as any other frequency, and what remains is the timing of the impacts over the full band.
//! The mean square of the envelope is 1, so that an amplitude of its spectrum is a modulation, which can be compared
//! between machines: 1 is a modulation from zero to twice the mean.
//!
//! Where the shaft speed varies, the squared envelope is resampled at equal steps of the shaft angle (order tracking),
//! and the frequencies of its spectrum are orders times the mean speed.
//!
//! Sources: Borghesani, Pennacchi, Randall, Sawalhi and Ricci 2013, Application of cepstrum pre-whitening for the
//! diagnosis of bearing faults under variable speed conditions, Mechanical Systems and Signal Processing 36; Smith and
//! Randall 2015, Rolling element bearing diagnostics using the Case Western Reserve University data: a benchmark
//! study, ibid. 64-65.

use super::shaft::Revolutions;
use super::spectrum::{Spectrum, is_of_mains};
use ballrace_plant::spectrum::WindowedTransform;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::collections::HashMap;

/// Revolutions of one block of the envelope: lines a hundredth of an order apart are resolved, and a cage slips less
/// within it than in a long recording.
pub(crate) const BLOCK_TURNS: f64 = 128.0;
/// Revolutions of one block of the signal itself, whose lines turn with the shaft exactly.
const RAW_TURNS: f64 = 512.0;
/// Greatest number of bands of equal width.
pub(crate) const MOST_PARTS: u32 = 8;
/// Highest order of the envelope spectrum, and of the spectrum of the signal.
pub(crate) const HIGHEST_ORDER: f64 = 30.0;
const HIGHEST_RAW_ORDER: f64 = 17.0;
/// Half the range of the background of a line, orders.
const BACKGROUND_ORDERS: f64 = 0.75;
/// Smallest such range, bins: a line under the Hann window has four bins, which must not dominate its background.
const MIN_BACKGROUND: usize = 12;

/// Spectrum of the squared envelope of one band of the whitened signal.
#[derive(Debug, Clone)]
pub(crate) struct BandEnvelope {
    /// Limits, Hz.
    pub band: [f64; 2],
    /// Number of bands of this width.
    pub parts: u32,
    pub spectrum: Spectrum,
}

/// Spectra of one sensor.
#[derive(Debug, Clone)]
pub(crate) struct SensorSpectra {
    /// Envelopes, that of the full band first.
    pub bands: Vec<BandEnvelope>,
    /// Of the signal.
    pub raw: Spectrum,
    /// Root mean square of the signal about its mean.
    pub rms: f64,
    /// Share of the power of the signal that is at multiples of the supply frequency.
    pub mains: f64,
    /// Signals in the average.
    signals: f64,
}

/// Transforms of the lengths used so far.
#[derive(Default)]
pub(crate) struct Transforms {
    planner: Option<FftPlanner<f64>>,
    windowed: HashMap<usize, WindowedTransform>,
}

impl Transforms {
    /// Returns the planner of transforms of any length.
    pub fn planner(&mut self) -> &mut FftPlanner<f64> {
        self.planner.get_or_insert_with(FftPlanner::new)
    }
}

/// Rotation of the shaft during a signal.
#[derive(Clone, Copy)]
pub struct Rotation<'a> {
    /// Mean speed, rev/s.
    pub turn_hz: f64,
    /// Largest speed, rev/s.
    pub fastest_hz: f64,
    /// Revolutions over the samples; none where the speed is constant.
    pub revolutions: Option<&'a Revolutions>,
}

impl SensorSpectra {
    /// Computes the spectra of a signal, with the bands that are at least `least_width` (Hz) wide; none of a constant
    /// or too short signal.
    pub fn new(
        signal: &[f64],
        rate: f64,
        rotation: Rotation<'_>,
        least_width: f64,
        transforms: &mut Transforms,
    ) -> Option<Self> {
        let bins = transformed(signal, transforms)?;
        let turn_hz = rotation.turn_hz;
        let flat = whitened(&bins);
        // Over twice the orders of the lines, so that those of regular impacts stay.
        let smooth = levelled(&bins, (2.0 * least_width / rate * signal.len() as f64) as usize);
        let mut bands = vec![];
        for (whitened, parts) in [(&flat, 1), (&smooth, 1), (&smooth, 2), (&smooth, 4), (&smooth, MOST_PARTS)] {
            let width = 0.5 * rate / f64::from(parts);
            if parts > 1 && width < least_width {
                break;
            }
            let count = whitened.len() / parts as usize;
            for (i, inside) in whitened.chunks_exact(count.max(1)).take(parts as usize).enumerate() {
                let (squares, own_rate) = squared_envelope(inside, (signal.len(), rate), rotation, transforms)?;
                let spectrum = averaged(&squares, own_rate, (turn_hz, BLOCK_TURNS, HIGHEST_ORDER), transforms)?;
                bands.push(BandEnvelope { band: [i as f64 * width, (i + 1) as f64 * width], parts, spectrum });
            }
        }
        let tracked = rotation.revolutions.map(|turned| order_tracked(signal, signal.len(), turned, turn_hz / rate));
        let (raw, mains) = raw_spectrum(tracked.as_deref().unwrap_or(signal), rate, turn_hz, transforms)?;
        let count = signal.len() as f64;
        let mean = signal.iter().sum::<f64>() / count;
        let rms = (signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
        Some(Self { bands, raw, rms, mains, signals: 1.0 })
    }

    /// Returns the spectrum of the envelope of the full band.
    pub fn envelope(&self) -> &Spectrum {
        self.bands.first().map_or(&self.raw, |band| &band.spectrum)
    }

    /// Returns true where the spectra are the average of several signals.
    pub fn is_of_several(&self) -> bool {
        self.signals > 1.0
    }

    /// Adds the spectra of a further signal of the same length and rotation to the average. Powers are averaged, so
    /// the signals need no common time.
    pub fn average(averaged: &mut Option<Self>, further: &Self) {
        let Some(mean) = averaged else {
            *averaged = Some(further.clone());
            return;
        };
        mean.signals += 1.0;
        for (mean_band, band) in mean.bands.iter_mut().zip(&further.bands) {
            mean_band.spectrum.average(&band.spectrum, mean.signals);
        }
        mean.raw.average(&further.raw, mean.signals);
        mean.mains += (further.mains - mean.mains) / mean.signals;
        mean.rms = (mean.rms.powi(2) + (further.rms.powi(2) - mean.rms.powi(2)) / mean.signals).sqrt();
    }
}

/// Returns the bins of a signal up to half the rate; none of a constant signal.
pub(crate) fn transformed(signal: &[f64], transforms: &mut Transforms) -> Option<Vec<Complex<f64>>> {
    let planner = transforms.planner();
    let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
    let mut bins: Vec<Complex<f64>> = signal.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    planner.plan_fft_forward(bins.len()).process(&mut bins);
    bins.truncate(signal.len() / 2);
    *bins.first_mut()? = Complex::new(0.0, 0.0);
    bins.iter().any(|bin| bin.norm_sqr() > 0.0).then_some(bins)
}

/// Returns bins with magnitude 1.
fn whitened(bins: &[Complex<f64>]) -> Vec<Complex<f64>> {
    bins.iter().map(|bin| bin / bin.norm().max(f64::MIN_POSITIVE)).collect()
}

/// Returns bins over the root mean square of those within `reach` of them.
pub(crate) fn levelled(bins: &[Complex<f64>], reach: usize) -> Vec<Complex<f64>> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for bin in bins {
        sum += bin.norm_sqr();
        sums.push(sum);
    }
    let level = |i: usize| {
        let (first, end) = (i.saturating_sub(reach), (i + reach + 1).min(bins.len()));
        let power = sums.get(end).unwrap_or(&0.0) - sums.get(first).unwrap_or(&0.0);
        (power / (end - first) as f64).sqrt().max(f64::MIN_POSITIVE)
    };
    bins.iter().enumerate().map(|(i, bin)| bin / level(i)).collect()
}

/// Returns the squared envelope of a band, `count` values over the length of the signal.
pub(crate) fn squares(inside: &[Complex<f64>], count: usize, transforms: &mut Transforms) -> Vec<f64> {
    let mut analytic = vec![Complex::default(); count];
    analytic.iter_mut().zip(inside).for_each(|(to, from)| *to = *from);
    transforms.planner().plan_fft_inverse(count).process(&mut analytic);
    analytic.iter().map(Complex::norm_sqr).collect()
}

/// Returns the squared envelope of a band of a signal of `samples` samples over its mean, less 1, and its rate.
fn squared_envelope(
    inside: &[Complex<f64>],
    (samples, rate): (usize, f64),
    rotation: Rotation<'_>,
    transforms: &mut Transforms,
) -> Option<(Vec<f64>, f64)> {
    // The band is shifted to 0 Hz: the envelope stays the same and needs fewer samples.
    // Interpolation of the envelope between its samples needs a further factor of 2.
    let oversampling = if rotation.revolutions.is_some() { 4 } else { 2 };
    let count = (oversampling * inside.len()).next_power_of_two();
    let mut squares = squares(inside, count, transforms);
    let own_rate = count as f64 / samples as f64 * rate;
    if let Some(revolutions) = rotation.revolutions {
        squares = order_tracked(&squares, samples, revolutions, rotation.turn_hz / own_rate);
    }
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    squares.iter_mut().for_each(|square| *square = *square / mean - 1.0);
    (mean > 0.0).then_some((squares, own_rate))
}

/// Returns the spectrum of `signal`, averaged over half-overlapping blocks (Welch), up to a highest order.
pub(crate) fn averaged(
    signal: &[f64],
    rate: f64,
    (turn_hz, turns, highest_order): (f64, f64, f64),
    transforms: &mut Transforms,
) -> Option<Spectrum> {
    let length = ((turns / turn_hz * rate) as usize).min(signal.len());
    if length < 64 {
        return None;
    }
    let transform = transforms.windowed.entry(length).or_insert_with(|| WindowedTransform::new(length));
    let bin_hz = rate / length as f64;
    let count = ((highest_order * turn_hz / bin_hz) as usize + 1).min(length / 2);
    let mut power = vec![0.0; count];
    let mut blocks = 0.0;
    for block in (0..=signal.len() - length).step_by((length / 2).max(1)).filter_map(|s| signal.get(s..s + length)) {
        for (sum, bin) in power.iter_mut().zip(transform.bins(block)) {
            *sum += 4.0 * bin.norm_sqr();
        }
        blocks += 1.0;
    }
    power.iter_mut().for_each(|p| *p /= blocks);
    let reach = ((BACKGROUND_ORDERS * turn_hz / bin_hz) as usize).max(MIN_BACKGROUND);
    Some(Spectrum { power, bin_hz, reach })
}

/// Returns the spectrum of the signal itself, and the share of its power at multiples of the supply frequency.
fn raw_spectrum(signal: &[f64], rate: f64, turn_hz: f64, transforms: &mut Transforms) -> Option<(Spectrum, f64)> {
    let mut spectrum = averaged(signal, rate, (turn_hz, RAW_TURNS, 0.5 * rate / turn_hz), transforms)?;
    // A line under the Hann window has bins on either side.
    let is_mains =
        |i: usize| [-1.0, 0.0, 1.0].iter().any(|j| is_of_mains((i as f64 + j) * spectrum.bin_hz, spectrum.bin_hz));
    let (mut total, mut of_mains, mut bins_of_mains) = (f64::MIN_POSITIVE, 0.0, 0.0);
    for (i, power) in spectrum.power.iter().enumerate().skip(2) {
        total += power;
        if is_mains(i) {
            of_mains += power;
            bins_of_mains += 1.0;
        }
    }
    // Noise has its share of these bins.
    let chance = bins_of_mains / spectrum.power.len().max(1) as f64;
    let mains = ((of_mains / total - chance) / (1.0 - chance).max(f64::MIN_POSITIVE)).max(0.0);
    spectrum.power.truncate((HIGHEST_RAW_ORDER * turn_hz / spectrum.bin_hz) as usize + 1);
    Some((spectrum, mains))
}

/// Returns values at steps of `step` revolutions; they span a signal of `samples` samples.
fn order_tracked(values: &[f64], samples: usize, revolutions: &Revolutions, step: f64) -> Vec<f64> {
    let per_sample = values.len() as f64 / samples as f64;
    revolutions
        .positions(step, (samples - 1) as f64)
        .map(|position| interpolated(values, position * per_sample))
        .collect()
}

/// Returns a value between samples by the cubic through the four nearest (Lagrange).
fn interpolated(values: &[f64], at: f64) -> f64 {
    let first = (at.max(0.0) as usize).saturating_sub(1).min(values.len().saturating_sub(4));
    let Some(&[a, b, c, d]) = values.get(first..first + 4) else { return 0.0 };
    let t = at - first as f64;
    let [t1, t2, t3] = [t - 1.0, t - 2.0, t - 3.0];
    -a * t1 * t2 * t3 / 6.0 + b * t * t2 * t3 / 2.0 - c * t * t1 * t3 / 2.0 + d * t * t1 * t2 / 6.0
}
