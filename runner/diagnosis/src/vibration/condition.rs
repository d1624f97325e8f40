//! Signals from which nothing can be judged: constant, at the resolution of the converter, clipped.

/// Readings of which the steps of the converter are taken.
const LOOKED_AT: usize = 1 << 16;
/// Least rms of a signal, steps of its converter: below it the rounding is the signal.
const LEAST_STEPS: f64 = 1.5;
/// Share of readings at the limits of the range from which a signal is clipped, and from which it cannot be judged.
/// Whitening keeps the timing of impacts of which the peaks are cut off: 60 recordings clipped at twice their rms, 5 %
/// of the readings, have the verdicts of the whole ones.
const CLIPPED: f64 = 0.002;
const MOST_CLIPPED: f64 = 0.08;
/// A reading is at a limit if it is within this share of the range.
const AT_LIMIT: f64 = 1e-5;

/// Returns the reason why a signal cannot be judged, as the end of a sentence about its sensor.
pub(crate) fn unusable(signal: &[f64]) -> Option<String> {
    let [low, high] = extremes(signal);
    if high <= low || signal.is_empty() {
        return Some("is constant".to_owned());
    }
    let count = signal.len() as f64;
    let mean = signal.iter().sum::<f64>() / count;
    let rms = (signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    if let Some(step) = converter_step(signal, high - low)
        && rms < LEAST_STEPS * step
    {
        let levels = ((high - low) / step).round() + 1.0;
        return Some(format!(
            "has {levels:.0} levels only, rms {:.1} steps of its converter: the machine stands still, or the \
             range is too large",
            rms / step
        ));
    }
    let share = at_limits(signal, [low, high]);
    (share > MOST_CLIPPED)
        .then(|| format!("is clipped: {:.0} % of its readings are at the limits {low:.4} and {high:.4}", 100.0 * share))
}

/// Returns the restriction of a signal that is clipped and can be judged, as the end of a sentence about its sensor.
pub(crate) fn clipped(signal: &[f64]) -> Option<String> {
    let share = at_limits(signal, extremes(signal));
    (share > CLIPPED).then(|| {
        format!(
            "is clipped: {:.1} % of its readings are at the limits of its range, so its levels are too low",
            100.0 * share
        )
    })
}

fn extremes(signal: &[f64]) -> [f64; 2] {
    signal.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
}

/// Returns the share of the readings at the limits.
fn at_limits(signal: &[f64], [low, high]: [f64; 2]) -> f64 {
    let near = AT_LIMIT * (high - low);
    let is_at_limit = |x: &&f64| **x - low <= near || high - **x <= near;
    signal.iter().filter(is_at_limit).count() as f64 / signal.len().max(1) as f64
}

/// Returns the step of the converter: the least difference of two readings; none where they are too fine to have one.
fn converter_step(signal: &[f64], range: f64) -> Option<f64> {
    let mut levels: Vec<f64> = signal.iter().take(LOOKED_AT).copied().collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let differences = levels.windows(2).filter_map(|pair| if let [a, b] = pair { Some(b - a) } else { None });
    // Rounding of decimals separates equal readings by less than a millionth.
    let step = differences.filter(|d| *d > 1e-6 * range).fold(f64::INFINITY, f64::min);
    (step.is_finite() && levels.len() < LOOKED_AT / 64).then_some(step)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn wave(amplitude: f64) -> impl Fn(i32) -> f64 {
        move |i| amplitude * (0.37 * f64::from(i)).sin() + 0.3 * amplitude * (1.91 * f64::from(i)).sin()
    }

    #[test]
    fn signals_without_a_verdict_are_named() {
        let of = |f: &dyn Fn(i32) -> f64| unusable(&(0..20_000).map(f).collect::<Vec<_>>());
        assert_eq!(of(&|_| 0.3).unwrap(), "is constant");
        let steps = of(&|i| (wave(0.9)(i)).round() * 0.001).unwrap();
        assert!(steps.starts_with("has 3 levels only"), "{steps}");
        let cut = of(&|i| wave(1.0)(i).clamp(-0.8, 0.8)).unwrap();
        assert!(cut.starts_with("is clipped") && cut.contains("-0.8000 and 0.8000"), "{cut}");
        assert_eq!(of(&|i| wave(1.0)(i)), None);
        let signal = |limit: f64| (0..20_000).map(|i| wave(1.0)(i).clamp(-limit, limit)).collect::<Vec<_>>();
        assert_eq!((unusable(&signal(1.25)), clipped(&signal(2.0))), (None, None));
        assert!(clipped(&signal(1.25)).unwrap().starts_with("is clipped: "));
        // A converter of 12 bit that the signal uses.
        assert_eq!(of(&|i| (wave(1.0)(i) * 200.0).round() / 200.0), None);
    }
}
