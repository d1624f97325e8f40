//! Mean and root mean square of the values of a signal in one pass.

/// Number, mean and mean square of values. They are summed about the first one, so that a large mean costs no digits.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moments {
    count: u64,
    first: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    /// Adds a value; returns it less the first one.
    pub fn add(&mut self, value: f64) -> f64 {
        if self.count == 0 {
            self.first = value;
        }
        let off = value - self.first;
        self.count += 1;
        self.sum += off;
        self.squares += off * off;
        off
    }

    /// Returns the number of values.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Returns the number of values, at least 1, as a divisor.
    #[must_use]
    pub fn divisor(&self) -> f64 {
        self.count.max(1) as f64
    }

    /// Returns the sums of the values less the first one, and of their squares.
    #[must_use]
    pub const fn sums(&self) -> [f64; 2] {
        [self.sum, self.squares]
    }

    /// Returns the mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.first + self.sum / self.divisor()
    }

    /// Returns the root mean square about zero.
    #[must_use]
    pub fn rms(&self) -> f64 {
        self.rms_about_mean().hypot(self.mean())
    }

    /// Returns the root mean square about the mean.
    #[must_use]
    pub fn rms_about_mean(&self) -> f64 {
        (self.squares / self.divisor() - (self.sum / self.divisor()).powi(2)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 1 um on an offset a thousand times as large keeps its digits.
    #[test]
    fn a_large_mean_costs_no_digits() {
        let mut moments = Moments::default();
        for i in 0..51_200 {
            moments.add(1e-3 + 1e-6 * (std::f64::consts::TAU * f64::from(i) / 100.0).sin());
        }
        assert_eq!(moments.count(), 51_200);
        assert!((moments.mean() - 1e-3).abs() < 1e-15, "{moments:?}");
        assert!((moments.rms_about_mean() / (1e-6 / 2_f64.sqrt()) - 1.0).abs() < 1e-10, "{moments:?}");
        assert!((moments.rms() - 1e-3_f64.hypot(1e-6 / 2_f64.sqrt())).abs() < 1e-15, "{moments:?}");
    }
}
