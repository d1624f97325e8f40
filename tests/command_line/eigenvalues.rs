//! Natural frequencies of badly scaled systems: an answer or an error, always within seconds.

use crate::support::{Sandbox, list, swap};
use serde_json::Value;
use std::f64::consts::TAU;
use std::time::Duration;

/// Time after which a command counts as hung.
const LIMIT: Duration = Duration::from_secs(10);

/// The shipped scene with moving balls, with another rotor mass.
fn moving_balls(mass: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    let text = sandbox.done(&["scenes", "harsha-clearance"]).out;
    let from = text.lines().find(|line| line.starts_with("mass = ")).unwrap().to_owned();
    sandbox.put("scene.toml", swap(&text, &from, &format!("mass = \"{mass}\"")));
    sandbox
}

/// 0.4 g of ball stand beside the rotor, and the undamped state matrix has a zero diagonal: the plain Schur iteration never
/// ends.
#[test]
fn natural_frequencies_with_moving_balls() {
    for (mass, kilograms) in [("1 g", 1e-3_f64), ("1 kg", 1.0), ("100 kg", 100.0)] {
        let sandbox = moving_balls(mass);
        let answer = sandbox.run_within(LIMIT, &["equilibrium", "scene.toml", "--format", "json"]);
        assert_eq!(answer.code, Some(0), "{mass}: {answer:?}");
        let found: Value = answer.json();
        let frequencies = list(&found, "natural_frequencies_hz");
        let frequencies: Vec<f64> = frequencies.iter().map(|f| f.as_f64().unwrap()).collect();
        // Five of the rotor and one of each of the nine balls.
        assert_eq!(frequencies.len(), 14, "{mass}: {frequencies:?}");
        // Along the axis nothing but the scene's spring of 1e5 N/m holds the rotor; its tilts are two more of
        // sqrt(1e2 N m/rad / 1e-3 kg m^2), split by the gyroscopic moment: their product is the square of that.
        let has = |hz: f64| frequencies.iter().any(|f| (f / hz - 1.0).abs() < 1e-9);
        assert!(has((1e5 / kilograms).sqrt() / TAU), "{mass}: {frequencies:?}");
        let tilt = 1e5_f64.sqrt() / TAU;
        let half = 0.5 * 0.1 * 2000.0 / 60.0;
        let split = [1.0, -1.0].map(|side| (tilt * tilt + half * half).sqrt() + side * half);
        assert!(split.into_iter().all(has), "{mass}: {split:?} {frequencies:?}");
    }
}

#[test]
fn every_command_on_such_a_scene_ends() {
    let sandbox = moving_balls("1 kg");
    for args in [
        &["campbell", "scene.toml", "--speeds", "0rpm..3000rpm:4"][..],
        &["simulate", "scene.toml", "--duration", "10 ms", "--rate", "10 kHz", "-o", "m.csv"],
        &["sweep", "scene.toml", "--over", "shaft.speed=30000rpm", "--settle", "1 ms", "--periods", "16", "-o", "s"],
    ] {
        let answer = sandbox.run_within(LIMIT, args);
        assert_eq!(answer.code, Some(0), "{answer:?}");
    }
}

/// Both ends of the range of a scene's numbers: frequencies or one error, no panic.
#[test]
fn masses_of_any_size_end_in_frequencies_or_in_an_error() {
    for mass in ["1e-12 kg", "1e12 kg", "1e-300 kg", "1e300 kg"] {
        let sandbox = moving_balls(mass);
        let answer = sandbox.run_within(LIMIT, &["equilibrium", "scene.toml"]);
        let ended = match answer.code {
            Some(0) => answer.out.contains("Natural frequencies"),
            Some(1 | 2) => answer.err.starts_with("ballrace: ") && answer.err.lines().count() == 1,
            _ => false,
        };
        assert!(ended && !answer.err.contains("panicked"), "{mass}: {answer:?}");
    }
}
