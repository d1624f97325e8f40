//! Width of a spall from the time between the entry of an element and its impact at the exit.
//!
//! The autocovariance of the logarithm of the envelope has a maximum at that time, beside those at multiples of the ball
//! pass. An element that rests on both edges of a deep and narrow spall strikes halfway across (Sawalhi and Randall 2011,
//! Vibration response of spalled rolling element bearings, Mechanical Systems and Signal Processing 25); one that rolls on the
//! ground of a wide one strikes at its end. The time is thus between half the passage and the whole of it: the width is 1 to 2
//! times the angle that an element rolls in that time, and no closer interval is given.
//!
//! Two resonances beat, and structures echo. A time counts where several bands of the signal show the same one, where it is long
//! against the resolution of a band, and where it does not repeat, as pulses of the supply do.

use super::envelope::{Transforms, levelled, squares, transformed};
use ballrace_outcome::{Diagnosis, Estimate, FaultKind};
use rustfft::num_complex::Complex;

/// Bands of equal width, and the fewest that agree.
const BANDS: usize = 4;
const LEAST_BANDS: usize = 2;
/// Shortest time, over the resolution of a band: the inverse of its width.
const LEAST_RESOLUTIONS: f64 = 8.0;
/// Longest time, ball passes: a wider spall is under two elements at a time for most of it.
const LONGEST: f64 = 0.25;
/// Prominence of a maximum, standard deviations of the autocovariance of noise.
const SIGNIFICANT: f64 = 3.0;
/// Prominence at the double of a time over that at the time, above which it repeats.
const REPEATED: f64 = 0.5;
/// Share by which the double of a time may be off.
const SEARCHED: f64 = 0.05;
/// Lowest frequency over the rate.
const LOWEST: f64 = 0.005;
/// Half the range over which the spectrum is levelled, Hz.
const LEVELLED_HZ: f64 = 500.0;
/// Floor of the envelope over its mean, below which its logarithm is noise.
const FLOOR: f64 = 0.05;

/// Adds the width of the damage to the diagnosis of a race.
pub(crate) fn add(
    diagnosis: &mut Diagnosis,
    (signal, rate): (&[f64], f64),
    elements: usize,
    transforms: &mut Transforms,
) {
    if !matches!(diagnosis.kind, FaultKind::OuterRace | FaultKind::InnerRace) {
        return;
    }
    diagnosis.parameters.half_width_deg = half_width(signal, rate, (diagnosis.line_hz, elements), transforms);
    diagnosis.sentence += &match diagnosis.parameters.half_width_deg {
        Some(Estimate { low, high, .. }) => {
            format!(" Its width along the race is {:.1} to {:.1} deg.", 2.0 * low, 2.0 * high)
        }
        None => " Its width is not determined.".to_owned(),
    };
}

/// Returns half the width of a spall on a race, degrees along the race; none where the signal does not show it. `pass_hz` is the
/// ball-pass frequency of the race.
pub(crate) fn half_width(
    signal: &[f64],
    rate: f64,
    (pass_hz, elements): (f64, usize),
    transforms: &mut Transforms,
) -> Option<Estimate> {
    let width_hz = 0.5 * rate / BANDS as f64;
    if LONGEST * width_hz / pass_hz <= LEAST_RESOLUTIONS {
        return None;
    }
    let mut bins = transformed(signal, transforms)?;
    bins.iter_mut().take((LOWEST * signal.len() as f64) as usize).for_each(|bin| *bin = Complex::default());
    let bins = levelled(&bins, (LEVELLED_HZ / rate * signal.len() as f64) as usize);
    let of = (signal.len() as f64 / rate, width_hz, pass_hz);
    let band = |inside: &[Complex<f64>]| time(inside, of, transforms);
    let mut times: Vec<f64> = bins.chunks_exact((bins.len() / BANDS).max(1)).take(BANDS).filter_map(band).collect();
    times.sort_by(f64::total_cmp);
    let median = times.get(times.len() / 2).copied()?;
    if times.len() < LEAST_BANDS || times.iter().any(|time| (time - median).abs() > 1.0 / width_hz) {
        return None;
    }
    let error = 0.5 / width_hz;
    // An element passes the race by one spacing of the elements in a ball pass.
    let degrees = |time: f64| time * pass_hz * 360.0 / elements as f64;
    let [low, high] = [0.5 * degrees(median - error), degrees(median + error)];
    Some(Estimate { value: 0.5 * (low + high), low, high })
}

/// Returns the time between two impacts of a passage in one band, s; `seconds` is the duration of the signal.
fn time(
    inside: &[Complex<f64>],
    (seconds, width_hz, pass_hz): (f64, f64, f64),
    transforms: &mut Transforms,
) -> Option<f64> {
    let envelope = squares(inside, (8 * inside.len()).next_power_of_two(), transforms);
    let rate = envelope.len() as f64 / seconds;
    let [first, end] = [LEAST_RESOLUTIONS / width_hz, LONGEST / pass_hz].map(|time| (time * rate) as usize);
    let covariance = autocovariance(&envelope, 3 * end, (rate / width_hz) as usize, transforms);
    let maxima = (first..end).filter(|i| matches!(covariance.get(i - 1..i + 2), Some(&[a, b, c]) if b > a && b >= c));
    let prominences = maxima.map(|i| (i, prominence(&covariance, i)));
    let (best, height) = prominences.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let reach = (SEARCHED * best as f64) as usize + 1;
    let at = |i: &usize| covariance.get(*i).copied().unwrap_or(f64::NEG_INFINITY);
    let double = (2 * best - reach..=2 * best + reach).max_by(|a, b| at(a).total_cmp(&at(b)))?;
    let noise = 1.0 / (seconds * width_hz).sqrt();
    let is_single = prominence(&covariance, double) < REPEATED * height;
    (height >= SIGNIFICANT * noise && is_single).then_some(best as f64 / rate)
}

/// Returns the height of a maximum above the lowest values within half its lag on either side, the higher one of both.
fn prominence(covariance: &[f64], at: usize) -> f64 {
    let lowest = |part: Option<&[f64]>| part.unwrap_or_default().iter().copied().fold(f64::INFINITY, f64::min);
    let before = lowest(covariance.get(at / 2..=at));
    let after = lowest(covariance.get(at..(at + at / 2 + 1).min(covariance.len())));
    covariance.get(at).map_or(0.0, |value| value - before.max(after))
}

/// Returns the autocovariance of the logarithm of an envelope over its variance at the first `count` lags, averaged over `smooth` lags.
fn autocovariance(envelope: &[f64], count: usize, smooth: usize, transforms: &mut Transforms) -> Vec<f64> {
    let floor = FLOOR * envelope.iter().sum::<f64>() / envelope.len().max(1) as f64;
    let logarithms: Vec<f64> = envelope.iter().map(|square| (square + floor).ln()).collect();
    let mean = logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64;
    let mut bins: Vec<Complex<f64>> = logarithms.iter().map(|value| Complex::new(value - mean, 0.0)).collect();
    // As many zeros: the lags of a transform are cyclic.
    bins.resize(2 * envelope.len(), Complex::default());
    let planner = transforms.planner();
    planner.plan_fft_forward(bins.len()).process(&mut bins);
    bins.iter_mut().for_each(|bin| *bin = Complex::new(bin.norm_sqr(), 0.0));
    planner.plan_fft_inverse(bins.len()).process(&mut bins);
    let variance = bins.first().map_or(1.0, |bin| bin.re).max(f64::MIN_POSITIVE);
    let smooth = smooth.max(1);
    let windows = bins.windows(smooth).take(count);
    let means = windows.map(|window| window.iter().map(|bin| bin.re).sum::<f64>() / (variance * smooth as f64));
    // The mean of a window is that of its middle.
    std::iter::repeat_n(1.0, smooth / 2).chain(means).take(count).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE: f64 = 51_200.0;
    const PASS_HZ: f64 = 36.0;

    /// Impacts on four resonances at each ball pass, a second one after `gap` seconds, in noise.
    fn impacts(gap: f64) -> Vec<f64> {
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut signal: Vec<f64> = (0..200_000).map(|_| uniform() - 0.5).collect();
        for k in 1..130 {
            // Elements slip: without jitter a comb of lines repeats at every multiple of the time.
            let start = (f64::from(k) + 0.02 * uniform()) / PASS_HZ;
            for (at, height) in [(start, 3.0), (start + gap, 4.0)] {
                let first = (at * RATE) as usize;
                for (i, x) in signal.iter_mut().enumerate().skip(first).take(200) {
                    let time = (i - first) as f64 / RATE;
                    let rings = [2_100.0, 8_300.0, 15_200.0, 21_900.0].map(|hz| (TAU * hz * time).sin());
                    *x += height * (-time * 3_000.0).exp() * rings.iter().sum::<f64>();
                }
            }
        }
        signal
    }

    #[test]
    fn the_time_between_two_impacts_is_a_width() {
        let of = |gap| half_width(&impacts(gap), RATE, (PASS_HZ, 9), &mut Transforms::default());
        // In 3 ms an element rolls by 0.003 x 36 x 40 deg = 4.3 deg: the whole width or half of it.
        let found = of(3e-3).unwrap();
        assert!((found.low - 2.16).abs() < 0.15 && (found.high - 4.32).abs() < 0.3, "{found:?}");
        // One impact, and two closer than a band resolves.
        assert_eq!((of(0.0), of(5e-4)), (None, None));
    }

    #[test]
    fn a_low_rate_has_no_width() {
        let signal: Vec<f64> = impacts(3e-3).into_iter().step_by(4).collect();
        assert_eq!(half_width(&signal, RATE / 4.0, (PASS_HZ, 9), &mut Transforms::default()), None);
    }
}
