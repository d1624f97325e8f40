//! The forces of `replay --forces` against those of the machines that made the recordings.

use std::fmt::Write;

use crate::support::{HEALTHY_RECORDING, Sandbox, head, list, number, numbers, recorded, sound};

/// Samples per row of the truth.
const EVERY: usize = 16;
/// Samples whose forces by the observer are usually compared: 15 turns, fewer than a diagnosis takes, which would need more time than the forces.
const COMPARED: usize = 3840;
/// FX, FY, FZ, MX, MY of two bearings.
const ENTRIES: usize = 10;

/// Errors of every force, moment by moment.
fn off(sandbox: &Sandbox, name: &str) -> Vec<Vec<f64>> {
    let truth = std::fs::read_to_string(recorded(&format!("{name}.truth.csv"))).unwrap();
    let ((head, found), (truth_head, truth)) = (numbers(&sandbox.read("forces.csv")), numbers(&truth));
    // The truth has no units in its header and no status.
    let plain: Vec<&str> = head.iter().map(|name| name.trim_end_matches("_Nm").trim_end_matches("_N")).collect();
    assert_eq!(
        plain.split_last(),
        Some((&"status", truth_head.iter().map(String::as_str).collect::<Vec<_>>().as_slice()))
    );
    let truth = &truth[..found.len() / EVERY];
    assert!(found.len() == EVERY * truth.len() && truth.len() >= COMPARED / EVERY);
    let pairs = || truth.iter().zip(found.iter().step_by(EVERY));
    assert!(pairs().all(|(truth, found)| (truth[0] - found[0]).abs() < 1e-6), "the same moments");
    (1..=ENTRIES).map(|i| pairs().map(|(truth, found)| found[i] - truth[i]).collect()).collect()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Forces straight from the displacement: the noise band agrees with their errors,
/// and few are far outside. The scene of a recording explains it, without a finding.
fn assert_within_the_noise(name: &str) {
    let sandbox = Sandbox::empty();
    let args = ["--forces", "forces.csv", "--force-source", "displacement"];
    let outcome = sandbox.replay(&recorded(&format!("{name}.toml")), &args);
    assert!(list(&outcome, "findings").is_empty(), "{name}: {:#}", outcome["findings"]);
    let (mut report, mut good) = (String::new(), true);
    for (i, errors) in off(&sandbox, name).iter().enumerate() {
        let sigma = number(&outcome, &format!("/bearings/{}/force_measured/{}/noise_sigma", i / 5, i % 5));
        let of_sigma = rms(errors) / sigma;
        let far = errors.iter().filter(|e| e.abs() > 4.0 * sigma).count() as f64 / errors.len() as f64;
        writeln!(report, "{name}, entry {i}: {of_sigma:.3} sigma rms, {:.2} % beyond 4", 100.0 * far).unwrap();
        good &= (0.8..=1.2).contains(&of_sigma) && far <= 0.005;
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

/// Probe noise of the recordings, um rms.
const RECORDED: f64 = 0.03;

/// The recording with white noise up to `noise` (um) on every probe.
fn noisier(recording: &str, noise: f64) -> String {
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut normal = move || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let more = (noise * noise - RECORDED * RECORDED).max(0.0).sqrt();
    let mut lines = recording.lines();
    let head = lines.next().unwrap();
    let probes: Vec<bool> = head.split(',').map(|name| name.ends_with("_um")).collect();
    let mut text = format!("{head}\n");
    for line in lines {
        let cells = line.split(',').zip(&probes);
        let cells = cells.map(|(cell, probe)| match probe {
            true => format!("{:.5}", cell.parse::<f64>().unwrap() + more * normal()),
            false => cell.to_owned(),
        });
        writeln!(text, "{}", cells.collect::<Vec<_>>().join(",")).unwrap();
    }
    text
}

/// How many times closer to the truth the observer's forces are than those straight from the displacement: the worst of
/// all forces and moments, and of the forces together; with the scene of `scene` on the recording `name`.
fn closer(name: &str, scene: &str, noise: f64) -> [f64; 2] {
    let sandbox = Sandbox::empty();
    let recording = match name {
        "healthy" => HEALTHY_RECORDING.to_owned(),
        _ => std::fs::read_to_string(recorded(&format!("{name}.csv"))).unwrap(),
    };
    let samples = if ballrace_tests::runs_all() { usize::MAX - 1 } else { COMPARED };
    sandbox.put("noisy.csv", noisier(&head(&recording, samples), noise));
    let text = std::fs::read_to_string(recorded(&format!("{scene}.toml"))).unwrap();
    sandbox.put("scene.toml", text.replace("noise = \"0.03 um\"", &format!("noise = \"{noise} um\"")));
    let errors = |source: &str| {
        sandbox.replay("scene.toml", &["--recording", "noisy.csv", "--forces", "forces.csv", "--force-source", source]);
        off(&sandbox, name)
    };
    let (observed, straight) = (errors("observer"), errors("displacement"));
    let worst = observed.iter().zip(&straight).map(|(o, s)| rms(s) / rms(o)).fold(f64::INFINITY, f64::min);
    let forces = |all: &[Vec<f64>]| {
        all.iter().enumerate().filter(|(i, _)| i % 5 < 3).map(|(_, e)| rms(e).powi(2)).sum::<f64>().sqrt()
    };
    let found = [worst, forces(&straight) / forces(&observed)];
    println!(
        "{name} by the scene of {scene}, {noise} um: {:.1} (forces together {:.1}) times closer",
        found[0], found[1]
    );
    found
}

/// At least three times closer, at every noise from 0.03 to 1 um, also where the scene does not know the unbalance.
#[test]
fn the_observer_is_closer_than_the_displacement() {
    let all = [
        ("healthy", "healthy", 0.03),
        ("healthy", "healthy", 0.1),
        ("healthy", "healthy", 1.0),
        ("healthy", "healthy", 0.3),
        ("unbalanced", "unbalanced", 0.03),
        ("unbalanced", "unbalanced", 1.0),
        ("outer-spall", "outer-spall", 1.0),
        ("outer-spall", "outer-spall", 0.03),
        ("run-up", "run-up", 0.03),
        ("run-up", "run-up", 1.0),
        ("unbalanced", "healthy", 1.0),
        ("unbalanced", "healthy", 0.03),
    ];
    // Usually every second one: each is replayed twice.
    let step = if ballrace_tests::runs_all() { 1 } else { 2 };
    let tried = all.iter().step_by(step);
    let far: Vec<_> = tried.filter(|(name, scene, noise)| closer(name, scene, *noise)[0] < 3.0).collect();
    assert!(far.is_empty(), "not three times closer: {far:?}");
}

/// Innovations agree with noise and model.
#[test]
fn innovations_are_consistent() {
    let outcome = sound();
    let [low, high] = [0, 1].map(|i| number(outcome, &format!("/observer/nis_bounds/{i}")));
    let mean = number(outcome, "/observer/nis_mean");
    assert!((low..=high).contains(&mean), "{mean} not in {low} to {high}");
    assert!(low < 5.0 && 5.0 < high && high - low < 0.2);
}
