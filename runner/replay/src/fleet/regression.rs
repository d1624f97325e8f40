//! Straight line through points by ordinary least squares, with Student's t.

use std::f64::consts::FRAC_2_PI;

/// Probability of the two-sided intervals.
const PROBABILITY: f64 = 0.9;

/// Line `value = mean_value + slope (x - mean_x)` through at least three points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    mean_x: f64,
    mean_value: f64,
    /// Slope.
    pub(super) slope: f64,
    /// Half the width of the 90 % interval of the slope.
    pub(super) slope_half_width: f64,
    /// Half the width of the 90 % interval of the mean value.
    mean_half_width: f64,
}

impl Line {
    /// Fits the line; `None` for fewer than three points or for points at one `x`.
    pub(super) fn fit(points: &[(f64, f64)]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let n = points.len() as f64;
        let mean_x = points.iter().map(|p| p.0).sum::<f64>() / n;
        let mean_value = points.iter().map(|p| p.1).sum::<f64>() / n;
        let sum = |of: fn(f64, f64) -> f64| points.iter().map(|p| of(p.0 - mean_x, p.1 - mean_value)).sum::<f64>();
        let sxx = sum(|dx, _| dx * dx);
        let slope = sum(|dx, dv| dx * dv) / sxx;
        let squares: f64 = points.iter().map(|p| (p.1 - mean_value - slope * (p.0 - mean_x)).powi(2)).sum();
        // Rounding errors of the sums must not give a constant a significant slope.
        let deviation = (squares / (n - 2.0)).sqrt().max(4.0 * f64::EPSILON * mean_value.abs());
        let t = student_t(points.len() - 2);
        let line = Self {
            mean_x,
            mean_value,
            slope,
            slope_half_width: t * deviation / sxx.sqrt(),
            mean_half_width: t * deviation / n.sqrt(),
        };
        (sxx > 0.0 && slope.is_finite() && line.slope_half_width.is_finite()).then_some(line)
    }

    /// Returns true where the slope is above 0 at a significance of 5 %: the lower end of its two-sided 90 % interval is.
    pub(super) fn rises(&self) -> bool {
        self.slope > self.slope_half_width
    }

    /// Returns the `x` at which a rising line reaches `value`, with its 90 % interval by Fieller's theorem: where the confidence band of
    /// the line contains `value`. `None` if the slope is not significantly above 0, because the interval is then infinite.
    pub(super) fn reaches(&self, value: f64) -> Option<[f64; 3]> {
        if !self.rises() {
            return None;
        }
        let (rise, slope) = (value - self.mean_value, self.slope);
        // The band contains `value` where (rise - slope d)^2 <= mean_half_width^2 + (slope_half_width d)^2.
        let a = slope * slope - self.slope_half_width * self.slope_half_width;
        let root = (rise * rise * self.slope_half_width * self.slope_half_width
            + a * self.mean_half_width * self.mean_half_width)
            .sqrt();
        let [low, high] = [-root, root].map(|root| self.mean_x + (rise * slope + root) / a);
        let at = self.mean_x + rise / slope;
        [at, low, high].iter().all(|x| x.is_finite()).then_some([at, low, high])
    }
}

/// Returns the `t` that a variable of Student's distribution exceeds in magnitude with the probability `1 - PROBABILITY`.
fn student_t(freedom: usize) -> f64 {
    // Beyond, the quantile of the normal distribution is within 1e-4.
    let freedom = freedom.min(20_000);
    let (mut low, mut high) = (1.6, 6.5);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if probability_within(middle, freedom) < PROBABILITY { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}

/// Returns the probability of a magnitude below `t` (Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.3 and 26.7.4).
fn probability_within(t: f64, freedom: usize) -> f64 {
    let angle = (t / (freedom as f64).sqrt()).atan();
    let (sin, cos) = angle.sin_cos();
    let is_odd = !freedom.is_multiple_of(2);
    // The sum of the terms with cos^k, k up to `freedom - 2`.
    let (mut term, mut sum) = (if is_odd { cos } else { 1.0 }, 0.0);
    let mut power = if is_odd { 1 } else { 0 };
    while power + 2 <= freedom {
        sum += term;
        power += 2;
        let k = power as f64;
        term *= cos * cos * (k - 1.0) / k;
    }
    if is_odd { FRAC_2_PI * (angle + sin * sum) } else { sin * sum }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Published two-sided 90 % quantiles.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        let published =
            [(1, 6.313_752), (2, 2.919_986), (3, 2.353_363), (4, 2.131_847), (5, 2.015_048), (8, 1.859_548)];
        let more = [(10, 1.812_461), (30, 1.697_261), (100, 1.660_234), (1000, 1.646_379), (20_000, 1.644_930)];
        for (freedom, expected) in published.into_iter().chain(more) {
            let found = student_t(freedom);
            assert!((found - expected).abs() < 2e-6, "{freedom}: {found}, expected {expected}");
        }
    }

    #[test]
    fn exact_line_has_no_interval() {
        let points: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), 3.0 + 0.5 * f64::from(i))).collect();
        let line = Line::fit(&points).unwrap();
        assert!((line.slope - 0.5).abs() < 1e-14 && line.slope_half_width < 1e-13);
        let [at, low, high] = line.reaches(10.0).unwrap();
        assert!((at - 14.0).abs() < 1e-12 && (low - 14.0).abs() < 1e-12 && (high - 14.0).abs() < 1e-12);
    }

    #[test]
    fn a_constant_does_not_rise() {
        let points: Vec<(f64, f64)> = (0..10).map(|i| (f64::from(i), 0.026_627_826_8)).collect();
        assert!(!Line::fit(&points).unwrap().rises());
    }

    #[test]
    fn no_line_without_three_points_at_two_places() {
        assert!(Line::fit(&[(0.0, 1.0), (1.0, 2.0)]).is_none());
        assert!(Line::fit(&[(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]).is_none());
        assert!(Line::fit(&[(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)]).is_none());
    }

    /// Closed form of three points at -1, 0, 1 with values 0, 1, 5.
    #[test]
    fn intervals_follow_the_closed_form() {
        let line = Line::fit(&[(-1.0, 0.0), (0.0, 1.0), (1.0, 5.0)]).unwrap();
        // Residuals 0.5, -1, 0.5: variance 1.5 with one degree of freedom; sxx = 2.
        assert!((line.slope - 2.5).abs() < 1e-14);
        assert!((line.slope_half_width - 6.313_751_514_675 * (1.5_f64 / 2.0).sqrt()).abs() < 1e-9);
        assert!(!line.rises() && line.reaches(10.0).is_none());
    }

    /// Standard normal deviates by Box and Muller, from a linear congruential generator.
    fn normal(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((*state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let (a, b) = (uniform(), uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// Both intervals contain the true value in 85 to 95 of a hundred series of ten points with known noise.
    #[test]
    fn intervals_cover_the_true_value_as_often_as_stated() {
        const SERIES: u64 = 2000;
        let (slope, limit, sigma) = (0.2, 4.0, 0.3);
        let (mut slopes, mut crossings, mut risen) = (0, 0, 0);
        for seed in 0..SERIES {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let points: Vec<(f64, f64)> =
                (0..10).map(|i| (f64::from(i), 1.0 + slope * f64::from(i) + sigma * normal(&mut state))).collect();
            let line = Line::fit(&points).unwrap();
            slopes += u64::from((line.slope - slope).abs() <= line.slope_half_width);
            if let Some([_, low, high]) = line.reaches(limit) {
                risen += 1;
                crossings += u64::from((low..=high).contains(&((limit - 1.0) / slope)));
            }
        }
        let [slopes, crossings] = [slopes as f64 / SERIES as f64, crossings as f64 / f64::from(risen)];
        println!("coverage: slope {slopes:.3}, crossing {crossings:.3} of {risen}");
        assert!((0.85..=0.95).contains(&slopes) && (0.85..=0.95).contains(&crossings), "{slopes} {crossings}");
        assert!(f64::from(risen) > 0.99 * SERIES as f64);
    }

    /// A slope of 0 is found to rise in 5 of a hundred series.
    #[test]
    fn noise_alone_rises_in_one_of_twenty_series() {
        let rises = |seed: u64| {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let points: Vec<(f64, f64)> = (0..8).map(|i| (f64::from(i), normal(&mut state))).collect();
            Line::fit(&points).unwrap().rises()
        };
        let share = (0..2000).filter(|seed| rises(*seed)).count() as f64 / 2000.0;
        assert!((0.035..0.065).contains(&share), "{share}");
    }
}
