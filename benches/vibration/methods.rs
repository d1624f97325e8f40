//! The three methods of Smith and Randall 2015, Rolling element bearing diagnostics using the Case Western Reserve
//! University data: a benchmark study, Mechanical Systems and Signal Processing 64-65, each with the squared envelope
//! spectrum of the whole recording:
//!
//! 1. of the raw signal over the full band,
//! 2. of the signal after cepstrum pre-whitening, over the full band,
//! 3. the benchmark method: after discrete/random separation, in the band with the highest spectral kurtosis
//!    (kurtogram).
//!
//! The paper judges by eye. Here a component's level is the mean, in dB over the local median, of the first three
//! harmonics of its order, at the slip within 1.5 % that makes it greatest, averaged over the sensors. The component
//! with the greatest level is named where it exceeds a threshold. One threshold a method is set on the recordings
//! themselves, so that the most answers are right: the best case for the methods.

use crate::labels::Recording;
use crate::program::scene;
use crate::score::Score;
use ballrace_twin::recording::{Reader, Row};
use ballrace_twin::scene::read::read_str;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::error::Error;
use std::path::Path;

/// Names of the methods.
pub const METHODS: [&str; 3] = ["raw envelope", "pre-whitened", "kurtogram"];
/// Kinds in the order of the levels.
const KINDS: [&str; 3] = ["outer-race", "inner-race", "element"];
const HARMONICS: usize = 3;
/// Largest slip, and steps of its search.
const SLIP: f64 = 0.015;
const SLIP_STEPS: i32 = 30;
/// Half the range of the background of a line, orders.
const BACKGROUND_ORDERS: f64 = 0.75;
/// Length of a segment of the discrete/random separation, samples, and the delay between its inputs.
const SEGMENT: usize = 8192;
const DELAY: usize = 500;
/// Numbers of bands of the kurtogram.
const PARTS: [usize; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 24];

type Signal = Vec<Complex<f64>>;

/// Levels of the components in each method, dB.
pub type Levels = [[f64; KINDS.len()]; METHODS.len()];

/// Computes the levels of a recording.
pub fn levels(data: &Path, recording: &Recording) -> Result<Levels, Box<dyn Error>> {
    let mut levels = Levels::default();
    let sensors = signals(data, recording)?;
    let mut planner = FftPlanner::new();
    for signal in &sensors {
        let residual = without_discrete(signal, &mut planner);
        let ways = [
            full_band(signal, false, &mut planner),
            full_band(signal, true, &mut planner),
            most_kurtosis(&residual, &mut planner),
        ];
        for (sums, squares) in levels.iter_mut().zip(&ways) {
            let spectrum = spectrum(squares, &mut planner);
            for (sum, order) in sums.iter_mut().zip(recording.orders()) {
                *sum += level(&spectrum, order, recording, signal.len()) / sensors.len() as f64;
            }
        }
    }
    Ok(levels)
}

/// Names the component of each recording by a method, with the threshold that makes the most answers right; returns it
/// too.
pub fn answers(recordings: &[Recording], levels: &[Levels], method: usize) -> (f64, Vec<Vec<String>>) {
    let strongest = |levels: &Levels| {
        let all = levels[method].iter().zip(KINDS);
        all.max_by(|a, b| a.0.total_cmp(b.0)).map_or((0.0, ""), |(level, kind)| (*level, kind))
    };
    let found: Vec<(f64, &str)> = levels.iter().map(strongest).collect();
    let at = |threshold: f64| -> Vec<Vec<String>> {
        let named = |(level, kind): &(f64, &str)| (*level >= threshold).then(|| (*kind).to_owned());
        found.iter().map(|one| named(one).into_iter().collect()).collect()
    };
    let right = |threshold: f64| {
        recordings.iter().zip(at(threshold)).filter(|(recording, kinds)| Score::is_right(recording, kinds)).count()
    };
    let threshold = found.iter().map(|one| one.0).max_by_key(|threshold| right(*threshold)).unwrap_or(0.0);
    (threshold, at(threshold))
}

/// Reads the sensors of a recording, less their means.
pub fn signals(data: &Path, recording: &Recording) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let scene = read_str(&scene(data, recording), Path::new("scene.toml"))?;
    let description = scene.recording.as_ref().ok_or("the scene has no recording")?;
    let mut reader = Reader::open(&data.join(&recording.file), description)?;
    let mut signals = vec![vec![]; recording.channels];
    let mut row = Row { sensors: vec![f64::NAN; recording.channels], ..Row::default() };
    while reader.next_row(&mut row)? {
        for (signal, reading) in signals.iter_mut().zip(&row.sensors) {
            signal.push(*reading);
        }
    }
    for signal in &mut signals {
        let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
        signal.iter_mut().for_each(|x| *x -= mean);
    }
    Ok(signals)
}

/// Returns the bins of a signal.
pub fn transformed(signal: &[f64], planner: &mut FftPlanner<f64>) -> Signal {
    let mut bins: Signal = signal.iter().map(|x| Complex::new(*x, 0.0)).collect();
    planner.plan_fft_forward(bins.len()).process(&mut bins);
    bins
}

/// Returns the squared envelope of the bins of a band.
fn squared_envelope(bins: &[Complex<f64>], count: usize, planner: &mut FftPlanner<f64>) -> Vec<f64> {
    let mut analytic = vec![Complex::default(); count];
    analytic.iter_mut().zip(bins).for_each(|(to, from)| *to = *from);
    planner.plan_fft_inverse(count).process(&mut analytic);
    analytic.iter().map(Complex::norm_sqr).collect()
}

fn full_band(signal: &[f64], is_whitened: bool, planner: &mut FftPlanner<f64>) -> Vec<f64> {
    let mut bins = transformed(signal, planner);
    bins.truncate(signal.len() / 2);
    if is_whitened {
        bins.iter_mut().for_each(|bin| *bin /= bin.norm().max(f64::MIN_POSITIVE));
    }
    squared_envelope(&bins, signal.len(), planner)
}

/// Returns the signal without its discrete lines, which a delayed copy of it predicts (Antoni and Randall 2004,
/// Unsupervised noise cancellation for vibration signals: part II).
fn without_discrete(signal: &[f64], planner: &mut FftPlanner<f64>) -> Vec<f64> {
    let window: Vec<f64> =
        (0..SEGMENT).map(|i| 0.5 * (1.0 - (std::f64::consts::TAU * i as f64 / SEGMENT as f64).cos())).collect();
    if signal.len() < 2 * SEGMENT + DELAY {
        return signal.to_vec();
    }
    let delay = SEGMENT + DELAY;
    let part = |from: usize, planner: &mut FftPlanner<f64>| {
        let windowed: Vec<f64> = signal[from..from + SEGMENT].iter().zip(&window).map(|(x, w)| x * w).collect();
        transformed(&windowed, planner)
    };
    let starts = || (delay..=signal.len() - SEGMENT).step_by(SEGMENT / 2);
    let (mut cross, mut power) = (vec![Complex::default(); SEGMENT], vec![0.0; SEGMENT]);
    for start in starts() {
        let (now, before) = (part(start, planner), part(start - delay, planner));
        for (k, (a, b)) in now.iter().zip(&before).enumerate() {
            cross[k] += a * b.conj();
            power[k] += b.norm_sqr();
        }
    }
    let filter: Signal = cross.iter().zip(&power).map(|(c, p)| c / p.max(f64::MIN_POSITIVE)).collect();
    let mut residual = signal.to_vec();
    for start in starts() {
        let mut predicted: Signal = part(start - delay, planner).iter().zip(&filter).map(|(x, h)| x * h).collect();
        planner.plan_fft_inverse(SEGMENT).process(&mut predicted);
        // Half-overlapping Hann windows add up to 1.
        for (x, y) in residual[start..].iter_mut().zip(&predicted) {
            *x -= y.re / SEGMENT as f64;
        }
    }
    residual
}

/// Returns the squared envelope of the band whose envelope has the highest kurtosis.
fn most_kurtosis(signal: &[f64], planner: &mut FftPlanner<f64>) -> Vec<f64> {
    let bins = transformed(signal, planner);
    let half = signal.len() / 2;
    let mut best = (f64::NEG_INFINITY, 0..half);
    for parts in PARTS {
        for i in 0..parts {
            let band = i * half / parts..(i + 1) * half / parts;
            let squares = squared_envelope(&bins[band.clone()], (2 * band.len()).next_power_of_two(), planner);
            let moment = |power: i32| squares.iter().map(|x| x.powi(power)).sum::<f64>() / squares.len() as f64;
            let kurtosis = moment(2) / moment(1).powi(2).max(f64::MIN_POSITIVE) - 2.0;
            if kurtosis > best.0 {
                best = (kurtosis, band);
            }
        }
    }
    squared_envelope(&bins[best.1], signal.len(), planner)
}

fn spectrum(squares: &[f64], planner: &mut FftPlanner<f64>) -> Vec<f64> {
    let n = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / n;
    let window = |i: usize| 0.5 * (1.0 - (std::f64::consts::TAU * i as f64 / n).cos());
    let windowed: Vec<f64> = squares.iter().enumerate().map(|(i, x)| (x - mean) * window(i)).collect();
    let bins = transformed(&windowed, planner);
    bins.iter().take(squares.len() / 2).map(Complex::norm_sqr).collect()
}

fn level(spectrum: &[f64], order: f64, recording: &Recording, samples: usize) -> f64 {
    let per_order = recording.rpm / 60.0 * samples as f64 / recording.rate_hz;
    let reach = (BACKGROUND_ORDERS * per_order) as usize + 2;
    let line = |order: f64| {
        let at = (order * per_order).round() as usize;
        let within = |half: usize| spectrum.get(at.saturating_sub(half)..at + half + 1).unwrap_or_default();
        // The shaft's own lines are no bearing's.
        if (order - order.round()).abs() * per_order < 1.6 {
            return 0.0;
        }
        let peak = within(1).iter().copied().fold(0.0, f64::max);
        let mut around = within(reach).to_vec();
        around.sort_by(f64::total_cmp);
        let median = around.get(around.len() / 2).copied().unwrap_or(0.0);
        10.0 * (peak / median.max(f64::MIN_POSITIVE)).max(1.0).log10()
    };
    let at = |slip: f64| (1..=HARMONICS).map(|k| line(k as f64 * order * (1.0 + slip))).sum::<f64>() / HARMONICS as f64;
    (-SLIP_STEPS..=SLIP_STEPS).map(|i| at(SLIP * f64::from(i) / f64::from(SLIP_STEPS))).fold(0.0, f64::max)
}
