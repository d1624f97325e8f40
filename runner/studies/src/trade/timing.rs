//! Repeated timings of equal work: their spread shows whether other work used the processor.

use serde::Serialize;

/// Spread of timings beyond which other work disturbed them: those of an idle machine differ by a few per cent.
const LARGEST_SPREAD: f64 = 0.1;

/// Spread of all timings of a comparison.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct TimingSpread {
    /// Upper quartile over all timings of the interquartile range of equal work, over its median.
    pub upper_quartile: f64,
    /// True where it is so large that costs which differ by less have no order.
    pub is_disturbed: bool,
}

impl TimingSpread {
    /// Creates the spread from that of each timing.
    #[must_use]
    pub fn new(mut spreads: Vec<f64>) -> Self {
        let upper_quartile = quartiles(&mut spreads)[2];
        Self { upper_quartile, is_disturbed: upper_quartile > LARGEST_SPREAD }
    }
}

/// Returns the interquartile range of times of equal work over their median; 0 for fewer than four.
pub(super) fn spread(mut times: Vec<f64>) -> f64 {
    if times.len() < 4 {
        return 0.0;
    }
    let [lower, median, upper] = quartiles(&mut times);
    if median > 0.0 { (upper - lower) / median } else { 0.0 }
}

/// Returns the quartiles of values; zeros without values.
fn quartiles(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * (values.len() as f64 - 1.0)).round() as usize).copied().unwrap_or(0.0);
    [0.25, 0.5, 0.75].map(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interrupted_work_is_disturbed_and_one_outlier_is_not() {
        let quiet: Vec<f64> = (0..32).map(|i| 1.0 + 0.001 * f64::from(i % 5)).collect();
        let one_outlier = [&quiet[1..], &[9.0]].concat();
        // Another process has the processor for as long as this one, in a third of the pieces.
        let shared: Vec<f64> = quiet.iter().enumerate().map(|(i, t)| if i % 3 == 0 { 2.0 * t } else { *t }).collect();
        let of = |times: &[f64]| TimingSpread::new(vec![spread(times.to_vec()); 8]);
        assert!(!of(&quiet).is_disturbed && !of(&one_outlier).is_disturbed, "{:?}", of(&one_outlier));
        assert!(of(&shared).is_disturbed, "{:?}", of(&shared));
        assert!(!TimingSpread::new(vec![]).is_disturbed && spread(vec![1.0, 5.0]) < f64::EPSILON);
    }
}
