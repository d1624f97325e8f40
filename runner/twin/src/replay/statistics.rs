//! Statistics over a whole recording in one pass: mean, extremes, rms, 1X vector.
//!
//! The kernel's `Statistics` has the higher moments of a short block for a condition indicator. These sums have none, cost a
//! sixth per value, and hold what a block does not: extremes, and a joint fit of mean and 1X.

use crate::outcome::{Motion, phase_lag_deg};
use nalgebra::{Matrix3, Vector3};

const UM: f64 = 1e6;

/// Sums of one signal with the shaft angle.
#[derive(Debug, Clone, Default)]
pub struct Sums {
    n: f64,
    /// First reading, subtracted from all, so that a large mean costs no digits.
    origin: f64,
    min: f64,
    max: f64,
    square: f64,
    /// Products of the signal with (1, cos, sin).
    signal: Vector3<f64>,
    /// Products of (1, cos, sin) with itself.
    basis: Matrix3<f64>,
}

impl Sums {
    /// Adds one sample of the signal (m) at a shaft angle given by (sin, cos).
    pub fn add(&mut self, signal: f64, (sin, cos): (f64, f64)) {
        if self.n == 0.0 {
            (self.origin, self.min, self.max) = (signal, signal, signal);
        }
        let y = signal - self.origin;
        let basis = Vector3::new(1.0, cos, sin);
        self.n += 1.0;
        self.min = self.min.min(signal);
        self.max = self.max.max(signal);
        self.square += y * y;
        self.signal += basis * y;
        self.basis += basis * basis.transpose();
    }

    /// Returns the mean, m.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.origin + self.signal[0] / self.n.max(1.0)
    }

    /// Returns the root mean square about zero, m.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.rms_about_mean().powi(2) + self.mean().powi(2)).sqrt()
    }

    /// Returns the root mean square about the mean, m.
    #[must_use]
    pub fn rms_about_mean(&self) -> f64 {
        let n = self.n.max(1.0);
        (self.square / n - (self.signal[0] / n).powi(2)).max(0.0).sqrt()
    }

    /// Returns cosine and sine of a least-squares fit of mean and 1X, m, and the rms of its residual.
    #[must_use]
    pub fn one_x(&self) -> ((f64, f64), f64) {
        let Some(inverse) = self.basis.try_inverse() else { return ((0.0, 0.0), self.rms_about_mean()) };
        let fit = inverse * self.signal;
        let left = (self.square - fit.dot(&self.signal)) / self.n.max(1.0);
        ((fit[1], fit[2]), left.max(0.0).sqrt())
    }

    /// Returns the motion for the report, um.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let ((cos, sin), _) = self.one_x();
        Motion {
            mean_um: self.mean() * UM,
            peak_to_peak_um: (self.max - self.min) * UM,
            rms_um: self.rms_about_mean() * UM,
            one_x_um: cos.hypot(sin) * UM,
            one_x_phase_lag_deg: phase_lag_deg(cos, sin),
        }
    }
}

/// Running mean, extremes and mean square of a quantity.
#[derive(Debug, Clone, Copy, Default)]
pub struct Running {
    n: f64,
    mean: f64,
    min: f64,
    max: f64,
    square: f64,
}

impl Running {
    /// Adds a value.
    pub fn add(&mut self, x: f64) {
        if self.n == 0.0 {
            (self.min, self.max) = (x, x);
        }
        self.n += 1.0;
        self.mean += (x - self.mean) / self.n;
        self.square += (x * x - self.square) / self.n;
        self.min = self.min.min(x);
        self.max = self.max.max(x);
    }

    /// Returns the number of values.
    #[must_use]
    pub fn count(&self) -> f64 {
        self.n
    }

    /// Returns the mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Returns the root mean square about zero.
    #[must_use]
    pub fn rms(&self) -> f64 {
        self.square.max(0.0).sqrt()
    }

    /// Returns the smallest and the largest value.
    #[must_use]
    pub fn extremes(&self) -> (f64, f64) {
        (self.min, self.max)
    }
}
