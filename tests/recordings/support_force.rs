//! The envelope of a faulty miniature bearing stands at the inner-race order that the kinematics give.

use ballrace::bearing::kinematics::orders;
use rustfft::{FftPlanner, num_complex::Complex};

const RATE: f64 = 6400.0;
const SPEED_HZ: f64 = 306.0 / 60.0;

/// Amplitude spectrum of the envelope of the band 100 to 300 Hz, where the support resounds.
fn envelope_spectrum(signal: &[f64]) -> Vec<f64> {
    let n = signal.len();
    let mean = signal.iter().sum::<f64>() / n as f64;
    let mut spectrum: Vec<Complex<f64>> = signal.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(n).process(&mut spectrum);
    // The analytic signal of the band: its positive frequencies alone.
    for (i, bin) in spectrum.iter_mut().enumerate() {
        let hz = i as f64 * RATE / n as f64;
        *bin *= if (100.0..300.0).contains(&hz) { 2.0 / n as f64 } else { 0.0 };
    }
    planner.plan_fft_inverse(n).process(&mut spectrum);
    let envelope: Vec<f64> = spectrum.iter().map(|z| z.norm()).collect();
    let mean = envelope.iter().sum::<f64>() / n as f64;
    let mut lines: Vec<Complex<f64>> = envelope.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    planner.plan_fft_forward(n).process(&mut lines);
    lines.iter().take(n / 2).map(|z| 2.0 * z.norm() / n as f64).collect()
}

#[test]
fn the_inner_race_line_has_the_order_of_the_geometry() {
    let samples = super::columns::<2>(include_str!("real/support_force_306rpm_6400Hz.csv"));
    let force: Vec<f64> = samples.iter().map(|row| row[1]).collect();
    let spectrum = envelope_spectrum(&force);
    let bin = RATE / force.len() as f64;
    let ratio = 2.770 / 10.514;
    let expected = orders(7, ratio, ratio).inner_race * SPEED_HZ;
    assert!((expected - 22.55).abs() < 0.01, "{expected}");
    let from = (15.0 / bin) as usize;
    let to = (30.0 / bin) as usize;
    let highest = (from..to).max_by(|a, b| spectrum[*a].total_cmp(&spectrum[*b])).unwrap();
    let found = highest as f64 * bin;
    println!("envelope line at {found:.2} Hz, {expected:.2} Hz by geometry");
    assert!((found / expected - 1.0).abs() < 0.015, "{found}");
}
