//! Statistics over a whole recording in one pass: mean, extremes, rms, 1X vector.
//!
//! The kernel's `Statistics` has the higher moments of a short block for a condition indicator. These sums have none, cost a
//! sixth per value, and hold what a block does not: extremes, and a joint fit of mean and 1X.

use ballrace_base::moments::Moments;
use ballrace_outcome::{Motion, phase_lag_deg};
use nalgebra::{Matrix3, Vector3};

const UM: f64 = 1e6;

/// Sums of cosine and sine of the shaft angle, shared by the signals of the same samples.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ShaftAngles {
    /// Products of (1, cos, sin) with itself.
    products: Matrix3<f64>,
}

impl std::ops::Add for ShaftAngles {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { products: self.products + other.products }
    }
}

impl ShaftAngles {
    /// Adds a shaft angle given by (sin, cos).
    pub fn add(&mut self, (sin, cos): (f64, f64)) {
        let basis = Vector3::new(1.0, cos, sin);
        self.products += basis * basis.transpose();
    }
}

/// Sums of a motion (m) with the shaft angle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MotionSums {
    moments: Moments,
    /// Smallest and largest value less the first.
    extremes: [f64; 2],
    /// Products of the signal with cos and sin.
    one_x: [f64; 2],
}

impl MotionSums {
    /// Adds one sample at a shaft angle given by (sin, cos).
    pub fn add(&mut self, signal: f64, (sin, cos): (f64, f64)) {
        let y = self.moments.add(signal);
        let [least, greatest] = self.extremes;
        self.extremes = [smaller(y, least), larger(y, greatest)];
        self.one_x[0] += cos * y;
        self.one_x[1] += sin * y;
    }

    /// Returns the root mean square about the mean, m.
    #[must_use]
    pub fn rms_about_mean(&self) -> f64 {
        self.moments.rms_about_mean()
    }

    /// Returns cosine and sine of a least-squares fit of mean and 1X, m, and the rms of its residual; `angles` are those of all samples.
    #[must_use]
    pub fn one_x(&self, angles: &ShaftAngles) -> ((f64, f64), f64) {
        let Some(inverse) = angles.products.try_inverse() else { return ((0.0, 0.0), self.rms_about_mean()) };
        let [cos, sin] = self.one_x;
        let [sum, squares] = self.moments.sums();
        let signal = Vector3::new(sum, cos, sin);
        let fit = inverse * signal;
        let left = (squares - fit.dot(&signal)) / self.moments.divisor();
        ((fit[1], fit[2]), left.max(0.0).sqrt())
    }

    /// Returns the motion for the report, um; `angles` are those of all samples.
    #[must_use]
    pub fn motion(&self, angles: &ShaftAngles) -> Motion {
        let ((cos, sin), _) = self.one_x(angles);
        Motion {
            mean_um: self.moments.mean() * UM,
            peak_to_peak_um: (self.extremes[1] - self.extremes[0]) * UM,
            rms_um: self.rms_about_mean() * UM,
            one_x_um: cos.hypot(sin) * UM,
            one_x_phase_lag_deg: phase_lag_deg(cos, sin),
        }
    }
}

/// Mean, extremes and mean square of a quantity.
#[derive(Debug, Clone, Copy)]
pub struct Running {
    n: f64,
    sum: f64,
    min: f64,
    max: f64,
    square: f64,
}

impl Default for Running {
    fn default() -> Self {
        RunningTogether::<1>::default().of(0)
    }
}

impl Running {
    /// Adds a value.
    pub fn add(&mut self, x: f64) {
        self.n += 1.0;
        self.sum += x;
        self.square += x * x;
        self.min = smaller(x, self.min);
        self.max = larger(x, self.max);
    }

    /// Returns the number of values.
    #[must_use]
    pub fn count(&self) -> f64 {
        self.n
    }

    /// Returns the mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.n.max(1.0)
    }

    /// Returns the root mean square about zero.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.square / self.n.max(1.0)).sqrt()
    }

    /// Returns the smallest and the largest value; 0 without values.
    #[must_use]
    pub fn extremes(&self) -> (f64, f64) {
        if self.n > 0.0 { (self.min, self.max) } else { (0.0, 0.0) }
    }
}

/// Loads of the elements at one azimuth, measured and in the twin.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LoadSums {
    count: f64,
    sum: f64,
    largest: f64,
    twin_count: f64,
    twin_sum: f64,
}

impl LoadSums {
    /// Adds the load of an element at the measured displacement.
    pub fn add(&mut self, load: f64) {
        self.count += 1.0;
        self.sum += load;
        self.largest = larger(load, self.largest);
    }

    /// Adds the load of an element in the twin.
    pub(crate) fn add_twin(&mut self, load: f64) {
        self.twin_count += 1.0;
        self.twin_sum += load;
    }

    /// Returns the mean load.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// Returns the largest load, 0 or more.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        self.largest
    }

    /// Returns the mean load in the twin.
    #[must_use]
    pub fn twin_mean(&self) -> f64 {
        self.twin_sum / self.twin_count.max(1.0)
    }
}

/// Returns the smaller of two numbers, the second where either is NaN: one instruction, unlike `f64::min`.
const fn smaller(x: f64, than: f64) -> f64 {
    if x < than { x } else { than }
}

/// Returns the larger of two numbers, the second where either is NaN.
const fn larger(x: f64, than: f64) -> f64 {
    if x > than { x } else { than }
}

/// [`Running`] of `K` quantities with a value in the same samples, side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunningTogether<const K: usize> {
    n: f64,
    sum: [f64; K],
    min: [f64; K],
    max: [f64; K],
    square: [f64; K],
}

impl<const K: usize> Default for RunningTogether<K> {
    fn default() -> Self {
        let zero = [0.0; K];
        Self { n: 0.0, sum: zero, min: [f64::INFINITY; K], max: [f64::NEG_INFINITY; K], square: zero }
    }
}

impl<const K: usize> RunningTogether<K> {
    /// Adds a value of each.
    pub fn add(&mut self, x: &[f64; K]) {
        self.n += 1.0;
        for (i, &x) in x.iter().enumerate() {
            self.sum[i] += x;
            self.square[i] += x * x;
            self.min[i] = smaller(x, self.min[i]);
            self.max[i] = larger(x, self.max[i]);
        }
    }

    /// Returns the quantity `i`, below `K`.
    #[must_use]
    pub const fn of(&self, i: usize) -> Running {
        Running { n: self.n, sum: self.sum[i], min: self.min[i], max: self.max[i], square: self.square[i] }
    }
}
