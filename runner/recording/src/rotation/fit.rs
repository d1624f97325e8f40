//! A line or parabola through keyphasor pulses: shaft angle, speed and acceleration near one of them.

use super::edges::Instant;

/// Largest scatter, in samples, that is taken for rounding of pulses to whole samples (0.29 samples rms): above,
/// it is a motion that a parabola cannot follow, and fewer pulses are looked at.
const ROUNDING: f64 = 0.45;

/// Multiple of the mean square of the residuals by which a parabola must reduce their sum to be accepted: three standard
/// deviations of its bend. A line is far steadier, above all beyond the first and the last pulse.
const CLEAR: f64 = 9.0;

/// Numbers of pulses on each side of the pulse of a fit, from the smoothest fit to the one that follows changes fastest.
const SIDES: [usize; 4] = [SIDE, 3, 2, 1];

/// Largest number of pulses on each side of the pulse of a fit.
pub(super) const SIDE: usize = 5;

/// A pulse with its place in the count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pulse {
    /// Counted from 0, pulses that were missed among them.
    pub(super) number: u64,
    pub(super) at: Instant,
    /// Samples a pulse in the interval before.
    pub(super) period: f64,
    /// Sample in the middle of a signal loss before this pulse that was so long that the count of pulses is estimated; `None` without
    /// such a loss.
    pub(super) lost: Option<u64>,
}

/// Pulses passed as a parabola over the samples since one pulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub(super) pulse: Pulse,
    at_pulse: f64,
    slope: f64,
    bend: f64,
    /// Standard deviation of the residuals, in samples; 0 without residuals.
    scatter: f64,
}

/// Pulses since one pulse, and the first two derivatives of that by samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Progress {
    pub(super) pulses: f64,
    pub(super) slope: f64,
    pub(super) bend: f64,
}

impl Fit {
    /// Returns the fit for pulse `place` of `pulses`, which have no signal loss between them.
    pub(super) fn around(pulses: &[Pulse], place: usize) -> Self {
        let pulse = pulses[place];
        let mut best = Self::line(pulse, 1.0 / pulse.period);
        for side in SIDES {
            let window = window(pulses.len(), place, side);
            best = Self::through(&pulses[window.0..window.1], pulse).unwrap_or(best);
            if best.scatter <= ROUNDING {
                break;
            }
        }
        best
    }

    /// Returns the line through the pulses, or the parabola where it fits significantly better.
    pub(super) fn through(pulses: &[Pulse], pulse: Pulse) -> Option<Self> {
        if pulses.len() < 2 {
            return None;
        }
        let line = Self::least_squares(pulses, pulse, false);
        if pulses.len() == 2 || (pulses.len() == 3 && line.scatter <= ROUNDING) {
            return Some(line);
        }
        let parabola = Self::least_squares(pulses, pulse, true);
        let count = pulses.len() as f64;
        let gain = (count - 2.0) * line.scatter.powi(2) - (count - 3.0) * parabola.scatter.powi(2);
        Some(if gain > CLEAR * parabola.scatter.powi(2) { parabola } else { line })
    }

    const fn line(pulse: Pulse, slope: f64) -> Self {
        Self { pulse, at_pulse: 0.0, slope, bend: 0.0, scatter: 0.0 }
    }

    /// Returns the least-squares line through two or more pulses, or the parabola through three or more.
    fn least_squares(pulses: &[Pulse], pulse: Pulse, parabola: bool) -> Self {
        let point = |other: &Pulse| {
            let number = other.number.wrapping_sub(pulse.number) as i64 as f64;
            (other.at.since(pulse.at) / pulse.period, number)
        };
        let count = pulses.len() as f64;
        let middle = pulses.iter().map(|other| point(other).0).sum::<f64>() / count;
        // Moments about the middle, where the one of first order is 0.
        let (mut m2, mut m3, mut m4) = (0.0, 0.0, 0.0);
        let (mut y0, mut y1, mut y2) = (0.0, 0.0, 0.0);
        for (x, y) in pulses.iter().map(point) {
            let x = x - middle;
            let square = x * x;
            (m2, m3, m4) = (m2 + square, m3 + square * x, m4 + square * square);
            (y0, y1, y2) = (y0 + y, y1 + x * y, y2 + square * y);
        }
        let bend =
            if parabola { (y2 - m2 * y0 / count - m3 * y1 / m2) / (m4 - m2 * m2 / count - m3 * m3 / m2) } else { 0.0 };
        let slope = (y1 - m3 * bend) / m2;
        let mean = (y0 - m2 * bend) / count;
        let residual = |(x, y): (f64, f64)| y - (mean + (x - middle) * (slope + bend * (x - middle)));
        let squares: f64 = pulses.iter().map(|other| residual(point(other)).powi(2)).sum();
        let spare = count - if parabola { 3.0 } else { 2.0 };
        let scatter = if spare > 0.0 { (squares / spare).sqrt() / slope.abs() * pulse.period } else { 0.0 };
        Self {
            pulse,
            at_pulse: mean - middle * (slope - bend * middle),
            slope: (slope - 2.0 * bend * middle) / pulse.period,
            bend: bend / (pulse.period * pulse.period),
            scatter,
        }
    }

    /// Returns the number of pulses passed since the pulse of the fit. Beyond the vertex of a parabola, outside the fitted pulses, the
    /// shaft is taken to be at standstill.
    pub(super) fn progress(&self, at: Instant) -> Progress {
        let x = at.since(self.pulse.at);
        let slope = self.slope + 2.0 * self.bend * x;
        if slope > 0.0 || self.bend == 0.0 {
            return Progress { pulses: self.at_pulse + x * (self.slope + x * self.bend), slope, bend: 2.0 * self.bend };
        }
        let pulses = self.at_pulse - 0.25 * self.slope * self.slope / self.bend;
        Progress { pulses, slope: 0.0, bend: 0.0 }
    }
}

/// Returns the first index and the end (excluded) of a window of `2 side + 1` pulses around `place`, shifted at the ends of the
/// `count` pulses.
fn window(count: usize, place: usize, side: usize) -> (usize, usize) {
    let width = (2 * side + 1).min(count);
    let from = place.saturating_sub(side).min(count - width);
    (from, from + width)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulses(instants: &[f64]) -> Vec<Pulse> {
        let pulse = |(number, at): (usize, &f64)| Pulse {
            number: (1 << 50) + number as u64,
            at: Instant { index: (1 << 60) + at.floor() as u64, fraction: at.fract() },
            period: 100.0,
            lost: None,
        };
        instants.iter().enumerate().map(pulse).collect()
    }

    #[test]
    fn windows() {
        assert_eq!(window(20, 10, 5), (5, 16));
        assert_eq!(window(20, 2, 5), (0, 11));
        assert_eq!(window(20, 18, 5), (9, 20));
        assert_eq!(window(3, 1, 5), (0, 3));
    }

    #[test]
    fn uniform_acceleration_is_exact() {
        // pulses = 0.01 t + 1e-5 t^2, far out in the recording
        let at = |n: f64| ((1e-4 + 4e-5 * n).sqrt() - 0.01) / 2e-5;
        let instants: Vec<f64> = (0..11).map(|n| at(f64::from(n))).collect();
        let pulses = pulses(&instants);
        for place in [0, 5, 10] {
            let fit = Fit::around(&pulses, place);
            let x = 0.3 * instants[4] + 0.7 * instants[5];
            let progress = fit.progress(Instant { index: (1 << 60) + x.floor() as u64, fraction: x.fract() });
            let true_pulses = 0.01 * x + 1e-5 * x * x - place as f64;
            assert!((progress.pulses - true_pulses).abs() < 1e-9);
            assert!((progress.slope - 0.01 - 2e-5 * x).abs() < 1e-11);
            assert!((progress.bend - 2e-5).abs() < 1e-13);
        }
    }

    #[test]
    fn standstill_ends_an_extrapolation() {
        // Speeding up from rest at sample 0: pulses = (t / 100)^2
        let instants: Vec<f64> = (1..6).map(|n| 100.0 * f64::from(n).sqrt()).collect();
        let mut pulses = pulses(&instants);
        for pulse in &mut pulses {
            pulse.at.index -= 1 << 59;
        }
        let fit = Fit::around(&pulses, 0);
        let before = fit.progress(Instant::sample((1 << 59) - 500));
        assert!((before.pulses + 1.0).abs() < 1e-9 && before.slope == 0.0 && before.bend == 0.0);
    }
}
