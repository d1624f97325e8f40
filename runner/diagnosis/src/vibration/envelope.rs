//! Envelope spectra: amplitude modulation of the frequency bands of a vibration signal.
//!
//! A damaged race causes impacts at its ball-pass frequency, and each impact excites a resonance of the structure. The resonance
//! is not known beforehand, so all bands are evaluated: the range up to Nyquist is divided into halves and thirds repeatedly.
//! The spectrum is that of the squared envelope, `|x_a|^2` of the band's analytic signal over its mean, averaged over blocks
//! (Welch). An amplitude of 1 is a modulation from zero to twice the mean.
//!
//! Where the shaft speed varies, the squared envelope is resampled at equal steps of the shaft angle (order tracking), and the
//! frequencies of its spectrum are orders times the mean speed. The bands stay those of the structure, in Hz.
//!
//! The kernel's `Envelope` follows one known band sample by sample; this search needs the whole recording, from which it finds
//! the band that the kernel's constructor takes.
//!
//! Sources: Randall and Antoni 2011, Rolling element bearing diagnostics - a tutorial, Mechanical Systems and Signal
//! Processing 25; the tree of bands: Antoni 2007, Fast computation of the kurtogram, ibid. 21.

use super::shaft::Revolutions;
use ballrace_plant::spectrum::WindowedTransform;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::collections::HashMap;

/// Number of bands at each level.
const PARTS: [usize; 9] = [2, 3, 4, 6, 8, 12, 16, 24, 32];
/// Revolutions of one block: lines a sixteenth of an order apart are resolved.
const BLOCK_TURNS: f64 = 16.0;
/// Range of the background on either side of a line, orders.
const BACKGROUND_TURNS: f64 = 1.0;
/// Smallest range of the background, bins: a line under the Hann window has four bins, which must not be part of its background.
const MIN_BACKGROUND: usize = 8;

/// The envelope spectrum of one band.
#[derive(Clone)]
pub(crate) struct BandEnvelope {
    /// Lower and upper limit of the band, Hz.
    pub band: [f64; 2],
    /// Squared amplitudes, averaged over the blocks.
    power: Vec<f64>,
    /// Bin width, Hz.
    bin: f64,
    /// Mean speed, rev/s.
    turn_hz: f64,
    /// Signals in the average.
    signals: f64,
}

/// Transforms of the lengths used so far.
#[derive(Default)]
pub(crate) struct Transforms {
    planner: Option<FftPlanner<f64>>,
    windowed: HashMap<usize, WindowedTransform>,
}

/// A line of an envelope spectrum.
#[derive(Debug, Clone, Copy, Default)]
pub struct Line {
    /// Level over the median around the line, dB.
    pub level_db: f64,
    /// Amplitude over the mean square of the band.
    pub modulation: f64,
    /// Frequency of the peak, Hz.
    pub frequency: f64,
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

/// Returns the spectra of all bands of `signal` that begin above `lowest` (Hz) and are wide enough for lines up to `highest` (Hz).
#[must_use]
pub fn envelopes(
    signal: &[f64],
    rate: f64,
    rotation: Rotation<'_>,
    [lowest, highest]: [f64; 2],
    transforms: &mut Transforms,
) -> Vec<BandEnvelope> {
    let n = signal.len();
    let Transforms { planner, windowed } = transforms;
    let planner = planner.get_or_insert_with(FftPlanner::new);
    let mean = signal.iter().sum::<f64>() / n.max(1) as f64;
    let mut spectrum: Vec<Complex<f64>> = signal.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    planner.plan_fft_forward(n).process(&mut spectrum);
    let mut all = Vec::new();
    for parts in PARTS {
        let width = 0.5 * rate / parts as f64;
        for i in 0..parts {
            let band = [i as f64 * width, (i + 1) as f64 * width];
            if width >= highest && band[0] >= lowest {
                all.extend(envelope(&spectrum, rate, rotation, band, (&mut *planner, &mut *windowed)));
            }
        }
    }
    all
}

fn envelope(
    spectrum: &[Complex<f64>],
    rate: f64,
    rotation: Rotation<'_>,
    band: [f64; 2],
    (planner, windowed): (&mut FftPlanner<f64>, &mut HashMap<usize, WindowedTransform>),
) -> Option<BandEnvelope> {
    let n = spectrum.len();
    let bin_of = |f: f64| (f * n as f64 / rate).ceil() as usize;
    let inside = spectrum.get(bin_of(band[0])..bin_of(band[1]).min(n / 2))?;
    // The band is shifted to 0 Hz: the envelope stays the same and needs fewer samples.
    // Interpolation of the envelope between its samples needs a further factor of 2.
    let oversampling = if rotation.revolutions.is_some() { 4 } else { 2 };
    let count = (oversampling * inside.len()).next_power_of_two();
    let mut analytic = vec![Complex::new(0.0, 0.0); count];
    for (to, from) in analytic.iter_mut().zip(inside) {
        *to = *from;
    }
    planner.plan_fft_inverse(count).process(&mut analytic);
    let mut squares: Vec<f64> = analytic.iter().map(Complex::norm_sqr).collect();
    let (turn_hz, own_rate) = (rotation.turn_hz, count as f64 / n as f64 * rate);
    if let Some(revolutions) = rotation.revolutions {
        squares = order_tracked(&squares, n, revolutions, turn_hz / own_rate);
    }
    let count = squares.len();
    let mean = squares.iter().sum::<f64>() / count.max(1) as f64;
    let length = ((BLOCK_TURNS / turn_hz * own_rate) as usize).min(count);
    if mean <= 0.0 || length < 64 {
        return None;
    }
    let transform = windowed.entry(length).or_insert_with(|| WindowedTransform::new(length));
    let mut power = vec![0.0; length / 2];
    let mut blocks = 0.0;
    for block in (0..=count - length).step_by((length / 2).max(1)).filter_map(|s| squares.get(s..s + length)) {
        for (sum, bin) in power.iter_mut().zip(transform.bins(block)) {
            *sum += bin.norm_sqr();
        }
        blocks += 1.0;
    }
    let weight = 4.0 / (blocks * mean * mean);
    power.iter_mut().for_each(|p| *p *= weight);
    Some(BandEnvelope { band, power, bin: own_rate / length as f64, turn_hz, signals: 1.0 })
}

/// Returns a squared envelope at steps of `step` revolutions; it spans a signal of `samples` samples.
fn order_tracked(squares: &[f64], samples: usize, revolutions: &Revolutions, step: f64) -> Vec<f64> {
    let per_sample = squares.len() as f64 / samples as f64;
    revolutions
        .positions(step, (samples - 1) as f64)
        .map(|position| interpolated(squares, position * per_sample))
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

/// Averages the spectra of a further signal of the same length and rotation into `averaged`, band by band. Powers are averaged, so the
/// signals need no common time.
pub fn average(averaged: &mut Vec<BandEnvelope>, further: &[BandEnvelope]) {
    if averaged.is_empty() {
        averaged.extend_from_slice(further);
        return;
    }
    for one in further {
        let same = |mean: &&mut BandEnvelope| mean.band == one.band && mean.power.len() == one.power.len();
        let Some(mean) = averaged.iter_mut().find(same) else { continue };
        mean.signals += 1.0;
        for (mean_power, power) in mean.power.iter_mut().zip(&one.power) {
            *mean_power += (power - *mean_power) / mean.signals;
        }
    }
}

impl BandEnvelope {
    /// Returns the variance of the squared envelope over the square of its mean: 1 for noise.
    #[must_use]
    pub(crate) fn total_modulation(&self) -> f64 {
        // The Hann window spreads each line over 1.5 bins.
        self.power.iter().sum::<f64>() / 3.0
    }

    /// Returns the bin width (Hz) and the amplitudes up to `highest` (Hz).
    #[must_use]
    pub fn spectrum(&self, highest: f64) -> (f64, Vec<f64>) {
        let count = (highest / self.bin).ceil() as usize + 1;
        (self.bin, self.power.iter().take(count).map(|p| p.sqrt()).collect())
    }

    /// Returns the line at `frequency` (Hz), the largest of three bins; a zero line at a multiple of the shaft frequency.
    #[must_use]
    pub fn line(&self, frequency: f64) -> Option<Line> {
        let at = (frequency / self.bin).round() as usize;
        let first = at.checked_sub(1).filter(|&i| i > 0)?;
        let near = self.power.get(first..at + 2)?;
        let (place, peak) = near.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map(|(i, p)| (first + i, *p))?;
        // Multiples of the shaft frequency belong to the shaft, not to a bearing.
        let order = place as f64 * self.bin / self.turn_hz;
        if (order - order.round()).abs() < 0.6 * self.bin / self.turn_hz {
            return Some(Line::default());
        }
        let reach = ((BACKGROUND_TURNS * self.turn_hz / self.bin) as usize).max(MIN_BACKGROUND);
        let mut around =
            self.power.get(at.saturating_sub(reach).max(2)..(at + reach + 1).min(self.power.len()))?.to_vec();
        around.sort_by(f64::total_cmp);
        let median = around.get(around.len() / 2).copied().filter(|m| *m > 0.0)?;
        Some(Line {
            level_db: 10.0 * (peak / median).log10(),
            modulation: peak.sqrt(),
            frequency: place as f64 * self.bin,
        })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A tone with amplitude modulation at 20 Hz: the line has the same amplitude in every band that holds the tone, as the squared
    /// envelope `(1 + m cos)^2` has the line `2m/(1 + m^2/2)`.
    #[test]
    fn a_modulated_tone() {
        let (rate, m) = (8000.0, 0.25);
        let wave = |i: usize| {
            let t = i as f64 / rate;
            (1.0 + m * (TAU * 20.0 * t).cos()) * (TAU * 1337.0 * t).sin()
        };
        let signal: Vec<f64> = (0..40_000).map(wave).collect();
        let rotation = Rotation { turn_hz: 4.7, fastest_hz: 4.7, revolutions: None };
        let all = envelopes(&signal, rate, rotation, [100.0, 100.0], &mut Transforms::default());
        let holding: Vec<&BandEnvelope> = all.iter().filter(|e| e.band[0] < 1300.0 && e.band[1] > 1374.0).collect();
        assert!(holding.len() >= 4);
        for envelope in holding {
            let line = envelope.line(20.0).unwrap();
            assert!((line.modulation - 2.0 * m / (1.0 + 0.5 * m * m)).abs() < 0.01, "{line:?} {:?}", envelope.band);
            assert!(line.level_db > 40.0);
            assert!(envelope.line(31.0).unwrap().modulation < 0.01);
            // Two lines: (2m cos + m^2/2 cos 2)/(1 + m^2/2), half the sum of their squares.
            let lines = [2.0 * m, 0.5 * m * m].map(|a| a / (1.0 + 0.5 * m * m));
            let variance = 0.5 * lines.iter().map(|a| a * a).sum::<f64>();
            assert!(
                (envelope.total_modulation() / variance - 1.0).abs() < 0.02,
                "{} {variance}",
                envelope.total_modulation()
            );
        }
    }
}
