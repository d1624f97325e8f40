//! The forces of `replay --forces` against those of the machines that made the recordings.

use crate::support::{Desk, number, numbers, recorded};

/// The truth has a row for so many samples.
const EVERY: usize = 16;
/// FX, FY, FZ, MX, MY of two bearings.
const ENTRIES: usize = 10;

/// The errors of every force, moment by moment, in units of the noise that the outcome announces for it.
fn errors(name: &str) -> Vec<Vec<f64>> {
    let desk = Desk::empty();
    let outcome = desk.replay(&recorded(&format!("{name}.toml")), &["--forces", "forces.csv"]);
    let truth = std::fs::read_to_string(recorded(&format!("{name}.truth.csv"))).unwrap();
    let ((head, found), (truth_head, truth)) = (numbers(&desk.read("forces.csv")), numbers(&truth));
    assert_eq!(head, truth_head);
    assert_eq!(found.len(), EVERY * truth.len());
    let sigma = |i: usize| number(&outcome, &format!("/bearings/{}/force_measured/{}/noise_sigma", i / 5, i % 5));
    let pairs = || truth.iter().zip(found.iter().step_by(EVERY));
    assert!(pairs().all(|(truth, found)| (truth[0] - found[0]).abs() < 1e-6), "the same moments");
    let error = |i: usize| pairs().map(|(truth, found)| (found[i + 1] - truth[i + 1]) / sigma(i)).collect();
    (0..ENTRIES).map(error).collect()
}

/// The noise band says what the errors are: neither too narrow nor too wide, and few are far outside.
fn assert_within_the_noise(name: &str) {
    let mut report = String::new();
    let mut good = true;
    for (i, errors) in errors(name).iter().enumerate() {
        let count = errors.len() as f64;
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
        let far = errors.iter().filter(|e| e.abs() > 4.0).count() as f64 / count;
        report += &format!("{name}, entry {i}: {rms:.3} sigma rms, {:.2} % beyond 4\n", 100.0 * far);
        good &= (0.8..=1.2).contains(&rms) && far <= 0.005;
    }
    print!("{report}");
    assert!(good, "{report}");
}

#[test]
fn healthy() {
    assert_within_the_noise("healthy");
}

#[test]
fn unbalanced() {
    assert_within_the_noise("unbalanced");
}

#[test]
fn outer_spall() {
    assert_within_the_noise("outer-spall");
}

#[test]
fn run_up() {
    assert_within_the_noise("run-up");
}
