//! Balls and cage as bodies: motion, files, page, reference of `trade`, errors.

use crate::support::{Sandbox, number, numbers, swap};
use serde_json::Value;

const SCENE: &str = include_str!("../../runner/scenes/skidding-spindle.toml");

/// The shipped scene at its last speed, with another thrust.
fn steady(thrust: &str) -> String {
    let text =
        swap(SCENE, "speed = { from = \"1000 rpm\", to = \"20000 rpm\", over = \"0.2 s\" }", "speed = \"20000 rpm\"");
    swap(&text, "\"10 N\"", thrust)
}

fn simulated(sandbox: &Sandbox, more: &[&str]) -> Value {
    let arguments = ["simulate", "scene.toml", "--rate", "5 kHz", "-o", "motion.csv", "--format", "json"];
    sandbox.done(&[&arguments, more].concat()).json()
}

/// A thrust of 300 N: the cage rolls, the balances hold, two runs agree to the bit, and files and page have the balls.
#[test]
fn balls_roll_under_load_and_their_files_agree() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", steady("\"300 N\""));
    let more = ["--duration", "10 ms", "--settle", "10 ms", "--elements", "elements.csv", "--report", "page.html"];
    let found = simulated(&sandbox, &more);
    let one = |key: &str| number(&found, &format!("/multibody/bearings/0/{key}"));
    assert!(one("mean_cage_slip").abs() < 0.01, "{found}");
    assert!(
        one("energy_error") < 1e-4 && one("momentum_error") < 1e-12 && one("angular_momentum_error") < 1e-8,
        "{found}"
    );
    let (names, rows) = numbers(&sandbox.read("elements.csv"));
    assert_eq!((names.len(), rows.len()), (1 + 11 + 9 * 17, 50));
    let column = |name: &str| names.iter().position(|column| column == name).unwrap();
    // The forces on the inner ring are those of its balls; the traction against the gyroscopic moment takes a part of the thrust.
    let (of_motion, motion) = numbers(&sandbox.read("motion.csv"));
    let axial = of_motion.iter().position(|name| name == "front_FZ").unwrap();
    for (row, whole) in rows.iter().zip(&motion) {
        let thrust: f64 = (1..=9)
            .map(|j| {
                let of = |name: &str| row[column(&format!("front_ball_{j}_{name}"))];
                of("inner_load") * of("inner_angle").sin()
            })
            .sum();
        assert!((thrust / -whole[axial] - 1.0).abs() < 0.06, "{thrust} {}", whole[axial]);
    }
    let page = sandbox.page("page.html");
    for title in [
        "Slip of the cage against pure rolling",
        "Orbit of the cage, guided by the outer ring",
        "Load on the inner race",
    ] {
        assert!(page.contains(title), "{title}");
    }
    let first = [sandbox.read("motion.csv"), sandbox.read("elements.csv")];
    simulated(&sandbox, &more);
    assert_eq!(first, [sandbox.read("motion.csv"), sandbox.read("elements.csv")]);
    let parquet = ["--duration", "2 ms", "--elements", "elements.parquet"];
    simulated(&sandbox, &parquet);
    assert!(sandbox.files().contains(&"elements.parquet".to_owned()));
}

/// The least load against skidding: with 5 N the balls slide on the inner race.
#[test]
fn balls_slide_without_load() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", steady("\"5 N\""));
    let found = simulated(&sandbox, &["--duration", "20 ms", "--settle", "60 ms"]);
    let slip = number(&found, "/multibody/bearings/0/mean_cage_slip");
    assert!((0.1..0.9).contains(&slip), "{found}");
}

/// The cage falls back by 8 % at 10 000 rpm under 10 N. What the gallery states of the whole run-up and of 100 N, its test reads.
#[test]
fn the_shipped_spindle_skids_as_the_gallery_states() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    simulated(&sandbox, &["--duration", "0.1 s", "--elements", "elements.csv"]);
    let (names, rows) = numbers(&sandbox.read("elements.csv"));
    let cage = names.iter().position(|column| column == "front_cage_slip").unwrap();
    let slip = rows[480..500].iter().map(|row| row[cage]).sum::<f64>() / 20.0;
    assert!((slip - 0.08).abs() < 0.01, "{slip}");
}

/// At moderate load the motion of balls in equilibrium is that of bodies, and `trade` measures the rest.
#[test]
fn trade_takes_bodies_as_its_reference() {
    let sandbox = Sandbox::empty();
    let three = swap(&swap(&steady("\"300 N\""), "elements = 9", "elements = 3"), "20000 rpm", "30000 rpm");
    sandbox.put("scene.toml", three);
    let found: Value = sandbox.done(&["trade", "scene.toml", "--format", "json"]).json();
    assert_eq!(found["motion_truth"], "multibody", "{found}");
    let responses = found["responses"].as_array().unwrap();
    let of = |model: &str| responses.iter().find(|one| one["model"] == model && one["usual"] == true).unwrap();
    assert_eq!(number(of("multibody"), "/error/residual"), 0.0);
    let solved = "quasi-static, centrifugal, gyroscopic";
    assert!(number(of(solved), "/error/peak_to_peak") < number(of("linear"), "/error/peak_to_peak"), "{responses:?}");
}

/// The static equilibrium of bodies is that of the quasi-static model.
#[test]
fn equilibrium_is_that_of_balls_with_inertia() {
    let sandbox = Sandbox::empty();
    let of = |scene: &str| {
        sandbox.put("scene.toml", scene);
        sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json::<Value>()["elements"].clone()
    };
    let bodies = steady("\"300 N\"");
    let own = "outer_land_clearance = \"0.4 mm\"\nmixture_density = \"100 kg/m^3\"\n";
    let solved =
        swap(&swap(&bodies, "\"multibody\"", "\"quasi-static\""), own, "effects = [\"centrifugal\", \"gyroscopic\"]\n");
    let elements = of(&bodies);
    assert!(elements.as_array().unwrap().len() == 9 && number(&elements, "/0/inner_load") > 10.0, "{elements}");
    assert_eq!(elements, of(&solved));
}

#[test]
fn keys_that_do_not_fit_are_refused() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let refused = |line: &str, parts: &[&str]| {
        sandbox.put("wrong.toml", format!("{SCENE}{line}\n"));
        sandbox.refused(&["check", "wrong.toml"], 2, parts);
    };
    refused("traction_limit = 0.1", &["traction_limit: invalid value: 0.1", "expected at most traction_peak, 0.06"]);
    refused("stiffness = 1e9", &["stiffness"]);
    refused("cage_ratio = 0.4", &["cage_ratio", "the speed of the cage is a result"]);
    refused("effects = [\"film\"]", &["effects", "only with model"]);
    refused("race_control = \"inner\"", &["race_control", "only with model"]);
    refused("[integration]\nmethod = \"verlet\"", &["integration", "chooses its steps by step_error"]);
    refused("cage_friction = 0.7", &["cage_friction", "0.7"]);
    sandbox.put(
        "plain.toml",
        swap(
            &swap(SCENE, "\"multibody\"", "\"angular\""),
            "outer_land_clearance = \"0.4 mm\"\nmixture_density = \"100 kg/m^3\"\n",
            "",
        ),
    );
    let arguments = ["simulate", "plain.toml", "--duration", "1 ms", "--rate", "5 kHz", "-o", "motion.csv"];
    for option in ["--elements", "--report"] {
        let parts = [option, "no bearing with model = \"multibody\"", "expected one"];
        sandbox.refused(&[&arguments[..], &[option, "out.csv"]].concat(), 2, &parts);
    }
    sandbox.put("negative.toml", swap(SCENE, "mixture_density = \"100 kg/m^3\"", "pocket_clearance = \"-1 mm\""));
    sandbox.refused(&["check", "negative.toml"], 2, &["pocket_clearance", "-1 mm"]);
}
