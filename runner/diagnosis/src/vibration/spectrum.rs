//! Lines of a power spectrum: local maxima over the median around them.

/// Multiples of these frequencies belong to the electrical supply, Hz.
const MAINS: [f64; 2] = [50.0, 60.0];
/// Largest distance of a line from a multiple of the supply frequency that counts as one, bins.
const MAINS_BINS: f64 = 0.6;

/// Power spectrum, from 0 Hz.
#[derive(Debug, Clone, Default)]
pub(crate) struct Spectrum {
    /// Squares of the amplitudes, averaged over the blocks.
    pub power: Vec<f64>,
    /// Hz between two bins.
    pub bin_hz: f64,
    /// Half the range of bins whose median is the background of a line.
    pub reach: usize,
}

/// A local maximum of a spectrum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peak {
    /// Frequency, interpolated between the bins, Hz.
    pub hz: f64,
    /// Power over the mean of the noise around it.
    pub ratio: f64,
}

impl Spectrum {
    /// Returns the median of the bins around each bin.
    pub fn background(&self) -> Vec<f64> {
        let (n, reach) = (self.power.len(), self.reach);
        let mut window: Vec<f64> = self.power.iter().take(reach).copied().collect();
        window.sort_by(f64::total_cmp);
        let at = |window: &[f64], value: f64| window.partition_point(|x| x.total_cmp(&value).is_lt());
        let mut medians = Vec::with_capacity(n);
        for i in 0..n {
            if let Some(&entering) = self.power.get(i + reach) {
                window.insert(at(&window, entering), entering);
            }
            if let Some(&leaving) = i.checked_sub(reach + 1).and_then(|j| self.power.get(j)) {
                window.remove(at(&window, leaving));
            }
            medians.push(window.get(window.len() / 2).copied().unwrap_or(0.0));
        }
        medians
    }

    /// Returns the maxima whose power is at least `least_ratio` times the mean of the noise around them. A bin counts
    /// where it exceeds two neighbours on either side: the flank of a strong line is no line.
    pub fn peaks(&self, least_ratio: f64) -> Vec<Peak> {
        let background = self.background();
        let peak = |(i, near): (usize, &[f64])| {
            let &[a, b, c, d, e] = near else { return None };
            // The power of noise has an exponential distribution, whose mean is its median over ln 2.
            let mean = background.get(i + 2)? / std::f64::consts::LN_2;
            let ratio = c / mean;
            let is_peak = c > a && c > b && c >= d && c > e && ratio >= least_ratio && ratio.is_finite();
            is_peak.then(|| {
                // A line between two bins under the Hann window.
                let side = if d > b { d } else { b };
                let quotient = (side / c).sqrt();
                let shift = (2.0 * quotient - 1.0) / (quotient + 1.0);
                let shift = if d > b { shift } else { -shift };
                Peak { hz: (i as f64 + 2.0 + shift) * self.bin_hz, ratio }
            })
        };
        self.power.windows(5).enumerate().filter_map(peak).collect()
    }

    /// Returns the largest power within `bins` of a frequency, less the background, and its ratio to the background.
    pub fn line(&self, hz: f64, bins: usize, background: &[f64]) -> [f64; 2] {
        let at = (hz / self.bin_hz).round() as usize;
        let near = self.power.get(at.saturating_sub(bins)..(at + bins + 1).min(self.power.len())).unwrap_or_default();
        let greatest = near.iter().copied().fold(0.0, f64::max);
        let below = background.get(at).copied().unwrap_or(0.0);
        [(greatest - below).max(0.0), if below > 0.0 { greatest / below } else { 0.0 }]
    }

    /// Adds the spectrum of a further signal, the `count`-th, to the average.
    pub fn average(&mut self, further: &Self, count: f64) {
        for (mean, power) in self.power.iter_mut().zip(&further.power) {
            *mean += (power - *mean) / count;
        }
    }
}

/// Returns true where a frequency is a multiple of a supply frequency.
pub(crate) fn is_of_mains(hz: f64, bin_hz: f64) -> bool {
    MAINS.iter().any(|mains| (hz - (hz / mains).round() * mains).abs() < MAINS_BINS * bin_hz)
}

/// Strength of the lines over frequency: the logarithm of the ratio of a line to the noise, spread over the error of
/// its frequency.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineField {
    step_hz: f64,
    values: Vec<f64>,
    /// Mean of the values: what a line anywhere finds by chance.
    pub mean: f64,
}

impl LineField {
    /// Creates a field without lines up to `highest_hz`.
    pub fn new(step_hz: f64, highest_hz: f64) -> Self {
        Self { step_hz, values: vec![0.0; (highest_hz / step_hz) as usize + 2], mean: 0.0 }
    }

    /// Adds lines. Where two lie closer than their error, the stronger one counts.
    pub fn add(&mut self, lines: impl Iterator<Item = (f64, f64, f64)>) {
        let mut own = vec![0.0_f64; self.values.len()];
        for (hz, strength, error_hz) in lines {
            let (middle, reach) = ((hz / self.step_hz) as usize, (3.0 * error_hz / self.step_hz) as usize + 1);
            let first = middle.saturating_sub(reach);
            for (j, value) in own.iter_mut().enumerate().skip(first).take(2 * reach + 1) {
                let distance = (j as f64 * self.step_hz - hz) / error_hz;
                *value = value.max(strength * (-0.5 * distance * distance).exp());
            }
        }
        self.values.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
    }

    /// Ends the sum over `count` sensors. Their noise is independent, so the sum is over the root of their number.
    pub fn close(&mut self, count: usize) {
        let scale = 1.0 / (count.max(1) as f64).sqrt();
        self.values.iter_mut().for_each(|value| *value *= scale);
        self.mean = self.values.iter().sum::<f64>() / self.values.len().max(1) as f64;
    }

    /// Returns the strength at a frequency; none above the highest.
    pub fn at(&self, hz: f64) -> Option<f64> {
        self.values.get((hz.abs() / self.step_hz + 0.5) as usize).copied()
    }

    /// Returns the frequencies of the maxima above `least`, Hz.
    pub fn maxima(&self, least: f64) -> impl Iterator<Item = f64> {
        let is_maximum = move |near: &[f64]| matches!(near, &[a, b, c] if b > a && b >= c && b > least);
        let step = self.step_hz;
        let found = self.values.windows(3).enumerate().filter(move |(_, near)| is_maximum(near));
        found.map(move |(i, _)| (i + 1) as f64 * step)
    }
}
