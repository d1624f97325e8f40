//! Growth of an indicator over snapshots, and the snapshot at which it begins.

use ballrace_base::statistics::median;

/// Probability of an onset in a recording whose indicators do not change.
const FALSE_ALARM: f64 = 1e-3;

/// Growth over snapshots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// Median of the first tenth.
    pub first: f64,
    /// Median of the last tenth.
    pub last: f64,
    /// Number of the first value of those that stay above the first tenth, where chance does not explain them.
    pub onset: Option<usize>,
}

/// Returns the number of values in a tenth, at least 1.
pub const fn tenth(count: usize) -> usize {
    let tenth = count.div_ceil(10);
    if tenth == 0 { 1 } else { tenth }
}

/// Returns the growth of an indicator, one of `indicators` that are tested together; none without a value.
///
/// The last L values all exceed the n values of the first tenth. Where nothing changes, all orders of the n + L values
/// are equally probable, whatever their distribution, so that the probability of this order is `n! L!/(n + L)!`. The
/// onset is the first of the L values where that probability times `indicators` is below 1/1000 (Bonferroni).
pub fn growth(values: &[f64], indicators: usize) -> Option<Growth> {
    let count = tenth(values.len());
    let (first, last) = (values.get(..count)?, values.get(values.len() - count..)?);
    let limit = first.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let onset = values.iter().rposition(|value| value.is_nan() || *value <= limit).map_or(0, |last| last + 1);
    let above = (values.len() - onset) as f64;
    let probability: f64 = (1..=count).map(|i| i as f64 / (above + i as f64)).product();
    let is_significant = above > 0.0 && probability * indicators as f64 <= FALSE_ALARM;
    Some(Growth { first: median(first)?, last: median(last)?, onset: is_significant.then_some(onset) })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Uniform numbers, 0 to 1.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn noise_has_no_onset_and_a_step_has_one() {
        for seed in 0..200 {
            assert_eq!(growth(&noise(seed, 300), 1).unwrap().onset, None, "{seed}");
        }
        let mut values = noise(1, 300);
        values.iter_mut().skip(200).for_each(|value| *value += 1.0);
        let found = growth(&values, 20).unwrap();
        assert_eq!(found.onset, Some(200));
        assert!(found.last > found.first + 0.8);
    }

    #[test]
    fn few_values_show_no_onset() {
        assert_eq!(growth(&[], 1), None);
        assert_eq!(growth(&[1.0], 1).unwrap().onset, None);
        assert_eq!(growth(&[1.0, 2.0, 3.0], 1).unwrap().onset, None);
        let rising: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(growth(&rising, 1).unwrap().onset, Some(10));
        assert_eq!(growth(&[rising, vec![f64::NAN]].concat(), 1).unwrap().onset, None);
    }
}
