//! Quantiles by which estimates and residuals are judged, and the median.

/// Largest excess of chi-squared per reading over 1, in standard deviations: a true model exceeds it in one of a thousand recordings.
const LARGEST_DEVIATION: f64 = 3.09;
/// Relative standard uncertainty of the noise of a probe that is stated with two digits.
const NOISE_UNCERTAINTY: f64 = 0.01;

/// Returns the largest chi-squared per degree of freedom of a true model.
///
/// Chi-squared of `freedom` normal deviates has the variance `2 freedom`; an error of the noise changes it by twice as much.
pub fn largest_chi_square(freedom: f64) -> f64 {
    1.0 + LARGEST_DEVIATION * (2.0 / freedom).sqrt().hypot(2.0 * NOISE_UNCERTAINTY)
}

/// Returns the number of standard deviations beyond which a share `tail` of a normal distribution lies.
///
/// The error is below 4.5e-4 (Abramowitz and Stegun 1964, 26.2.23).
pub fn quantile(tail: f64) -> f64 {
    let t = (-2.0 * tail.ln()).sqrt();
    t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)))
}

/// Returns the middle one of the sorted values, the upper one of an even number; `None` without values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles() {
        for (tail, z) in [(0.025, 1.95996), (0.005, 2.57583), (0.025 / 17.0, 2.97513)] {
            assert!((quantile(tail) - z).abs() < 1e-3, "{tail}");
        }
    }

    /// The 99.9 % quantile of chi-squared by Wilson and Hilferty, and by an error of the noise of 1 % alone.
    #[test]
    fn largest_chi_squares() {
        for freedom in [5000.0_f64, 50_000.0] {
            let part = 2.0 / (9.0 * freedom);
            let by_readings = (1.0 - part + 3.0902 * part.sqrt()).powi(3) - 1.0;
            let by_noise = 3.0902 * 0.02;
            let found = largest_chi_square(freedom) - 1.0;
            assert!((found / by_readings.hypot(by_noise) - 1.0).abs() < 0.02, "{found}");
        }
    }
}
