//! `ballrace trade`: its figures are those of `force`, its front is a Pareto front, the chosen model meets the goal.

use crate::support::{Sandbox, list, number, numbers, swap};
use serde_json::Value;

/// Two angular-contact bearings under preload at speed; damped so that its transient is short.
const SPINDLE: &str = r#"
name = "spindle"
[shaft]
speed = "12000 rpm"
[rotor]
mass = "2 kg"
diametral_inertia = 4e-3
polar_inertia = 2e-3
damping = [4000, 4000, 4000, 4, 4]
load = [150, 0, 100, 0, 0]
unbalance = [{ moment = "2 g mm", angle = "17 deg", station = "20 mm" }]
[[bearing]]
name = "A"
station = "-50 mm"
facing = "+z"
model = "quasi-static"
elements = 8
ball_diameter = "7 mm"
pitch_diameter = "38.5 mm"
inner_conformity = 0.52
outer_conformity = 0.52
contact_angle = "25 deg"
effects = ["centrifugal", "gyroscopic"]
preload = { force = "500 N" }
[[bearing]]
name = "B"
station = "50 mm"
facing = "-z"
model = "quasi-static"
elements = 8
ball_diameter = "7 mm"
pitch_diameter = "38.5 mm"
inner_conformity = 0.52
outer_conformity = 0.52
contact_angle = "25 deg"
effects = ["centrifugal", "gyroscopic"]
preload = { force = "500 N" }
"#;

/// Springs of balls, nothing that could be solved.
const LUMPED: &str = r#"
name = "lumped"
[shaft]
speed = "3000 rpm"
[rotor]
mass = "6 kg"
diametral_inertia = 0.03
polar_inertia = 0.006
damping = [4000, 4000, 4000, 4, 4]
stiffness = [0, 0, 1e7, 0, 0]
[[bearing]]
name = "A"
station = "-100 mm"
model = "lumped"
elements = 9
cage_ratio = 0.4
stiffness = 8e9
radial_play = "2 um"
[[bearing]]
name = "B"
station = "100 mm"
model = "lumped"
elements = 9
cage_ratio = 0.4
stiffness = 8e9
radial_play = "2 um"
"#;

fn sandbox(scene: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene);
    sandbox
}

fn figure(one: &Value, path: &[&str]) -> f64 {
    path.iter().fold(one, |value, key| &value[key]).as_f64().unwrap_or_else(|| panic!("{path:?} of {one}"))
}

fn find<'a>(all: &'a Value, model: &str, precision: &str, math: &str) -> &'a Value {
    let all = all["candidates"].as_array().unwrap();
    let same = |c: &&Value| {
        c["model"] == model && c["arithmetic"]["precision"] == precision && c["arithmetic"]["math"] == math
    };
    all.iter().find(same).unwrap_or_else(|| panic!("{model} {precision} {math}"))
}

#[test]
fn the_models_on_a_spindle() {
    let sandbox = sandbox(SPINDLE);
    let all = sandbox.done(&["trade", "scene.toml", "--format", "json"]).json::<Value>();
    assert_eq!((all["motion"].as_str(), all["poses"].as_u64()), (Some("simulation"), Some(512)));
    assert_eq!(all["truth"], "quasi-static, centrifugal, gyroscopic");
    let candidates = all["candidates"].as_array().unwrap();
    for c in candidates {
        let (found, modelling, rounding) = (
            figure(c, &["error", "largest"]),
            figure(c, &["modelling", "largest"]),
            figure(c, &["rounding", "largest"]),
        );
        assert!(found <= (modelling + rounding) * (1.0 + 1e-9), "{c}");
        assert!(figure(c, &["error", "median"]) <= figure(c, &["error", "most_99"]));
        // A candidate on the front is beaten by none in both error and cost.
        let cost = |c: &Value| c["cortex"]["cycles"].as_f64();
        if let (Some(own), Some(true)) = (cost(c), c["front_cortex"].as_bool()) {
            let beaten = candidates.iter().any(|o| {
                cost(o).is_some_and(|other| other < own)
                    && figure(o, &["error", "most_99"]) < figure(c, &["error", "most_99"])
            });
            assert!(!beaten, "{c}");
        }
    }
    let error = |model: &str, precision: &str| figure(find(&all, model, precision, "exact"), &["error", "most_99"]);
    // The most expensive model is the truth but for its last steps; single precision costs its rounding only.
    assert!(error("quasi-static, centrifugal, gyroscopic", "f64") < 1e-10);
    assert!((1e-9..1e-5).contains(&error("quasi-static, centrifugal, gyroscopic", "f32")));
    // Each effect omitted and each coarser table is further off.
    let [full, centrifugal, none] =
        ["quasi-static, centrifugal, gyroscopic", "quasi-static, centrifugal", "quasi-static, no effects"]
            .map(|model| error(model, "f64"));
    assert!(full < 0.1 * centrifugal && centrifugal < none, "{full:e} {centrifugal:e} {none:e}");
    let tables = ["8 x 8", "16 x 16", "24 x 24", "32 x 32"].map(|size| error(&format!("tabulated {size}"), "f64"));
    assert!(tables.windows(2).all(|pair| pair[1] < pair[0]), "{tables:?}");
    // Balls solved one by one without inertia are the closed form.
    assert!((error("angular", "f64") / none - 1.0).abs() < 1e-6);
    // The model with the smaller error of force has the smaller error of motion.
    let left = |model: &str| {
        let all = all["responses"].as_array().unwrap();
        let usual = |r: &&Value| r["model"] == model && r["usual"] == true && r["precision"] == "f64";
        figure(all.iter().find(usual).unwrap(), &["error", "residual"])
    };
    assert!(left("quasi-static, centrifugal, gyroscopic") < 0.1 * left("tabulated 8 x 8"));
    assert!(left("tabulated 32 x 32") < left("angular"));
    let why = all["impossible"].as_array().unwrap();
    assert_eq!(why.iter().map(|w| w["model"].as_str().unwrap()).collect::<Vec<_>>(), ["linear", "lumped"]);
    assert!(why.iter().all(|w| w["why"].as_str().unwrap().contains("preload")), "{why:?}");
    let page = sandbox.read("ballrace-trade.html");
    assert_eq!(page.matches("<svg").count(), 3);
}

#[test]
fn the_chosen_model_meets_the_goal() {
    let sandbox = sandbox(SPINDLE);
    let out = sandbox.done(&["trade", "scene.toml", "--forces-only", "--error", "0.1%"]).out;
    assert!(out.contains("scene-chosen.toml"), "{out}");
    let chosen = sandbox.read("scene-chosen.toml");
    assert!(chosen.contains("model = \"tabulated\"") && chosen.contains("[16, 16, 2]"), "{chosen}");
    // Independent check: forces of both scenes at displacements beside the motion, within twice the goal.
    sandbox.put("u.csv", "u,v,w,thu,thv\n1e-6,0,1.2e-5,0,0\n0,1e-6,1.1e-5,0,0\n");
    let force = |scene: &str| {
        let args = ["force", scene, "--displacements", "u.csv", "--bearing", "A", "--format", "csv"];
        numbers(&sandbox.done(&args).out.replace(",ok", "")).1
    };
    for (near, right) in force("scene-chosen.toml").iter().zip(&force("scene.toml")) {
        let apart = near.iter().zip(right).take(3).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert!(apart < 0.002 * right.iter().take(3).map(|f| f * f).sum::<f64>().sqrt(), "{near:?} {right:?}");
    }
    let args = [
        "trade",
        "scene.toml",
        "--forces-only",
        "--deadline",
        "20 us at 168 MHz",
        "-o",
        "fast.toml",
        "--format",
        "json",
    ];
    let choice = sandbox.done(&args).json::<Value>()["choice"].clone();
    assert!(figure(&choice, &["seconds"]) <= 20e-6 && choice["model"] == "angular", "{choice}");
    assert!(
        sandbox.read("fast.toml").contains("model = \"angular\"") && !sandbox.read("fast.toml").contains("effects")
    );
    let longer = [
        "trade",
        "scene.toml",
        "--forces-only",
        "--deadline",
        "1 ms at 168 MHz",
        "-o",
        "true.toml",
        "--format",
        "json",
    ];
    let choice = sandbox.done(&longer).json::<Value>()["choice"].clone();
    assert!(
        choice["model"].as_str().unwrap().starts_with("quasi-static, centrifugal, gyroscopic")
            && figure(&choice, &["error"]) < 1e-6,
        "{choice}"
    );
    sandbox.refused(
        &["trade", "scene.toml", "--forces-only", "--deadline", "1 us at 16 MHz"],
        2,
        &["--deadline: no model is so fast: 1.000 us at 16 MHz"],
    );
}

#[test]
fn lumped_model_has_no_costlier_reference() {
    let sandbox = sandbox(LUMPED);
    let all = sandbox.done(&["trade", "scene.toml", "--format", "json"]).json::<Value>();
    assert_eq!(all["truth"], "lumped");
    let cost = &find(&all, "lumped", "f32", "exact")["cortex"];
    // Twice the row of the target's table.
    assert_eq!(cost["counted"], true);
    let table = include_str!("../../runner/studies/src/trade/cores/cortex-m4f.csv");
    let row = table.lines().find(|line| line.starts_with("radial 3/2;9;f32;exact;force, input checked;")).unwrap();
    let instructions: f64 = row.split(';').nth(5).unwrap().parse().unwrap();
    assert_eq!(figure(cost, &["instructions"]), 2.0 * instructions);
    assert!(figure(find(&all, "linear", "f64", "exact"), &["error", "most_99"]) > 0.01);
    let csv = sandbox.done(&["trade", "scene.toml", "--format", "csv"]).out;
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
}

#[test]
fn an_absent_cost_has_a_reason_and_an_empty_column_is_left_out() {
    let text = |scene: &str| sandbox(scene).done(&["trade", "scene.toml", "--forces-only"]).out;
    let smooth = text(LUMPED);
    assert!(smooth.contains("instr.") && !smooth.contains("bearings with waviness"), "{smooth}");
    let wavy = LUMPED.replace(
        "radial_play = \"2 um\"\n",
        "radial_play = \"2 um\"\nwaviness = [{ surface = \"outer\", order = 9, amplitude = \"0.1 um\" }]\n",
    );
    let wavy = text(&wavy);
    let reason = "bearings with waviness, defects, a displaced housing or a bending outer ring are not counted.";
    assert!(!wavy.contains("instr.") && wavy.contains(reason), "{wavy}");
}

#[test]
fn invalid_goals_are_rejected() {
    let sandbox = sandbox(LUMPED);
    let refused = |more: &[&str], words: &[&str]| {
        sandbox.refused(&[&["trade", "scene.toml"], more].concat(), 2, words);
    };
    for error in ["--error=some", "--error=-1%", "--error=0"] {
        let answer = sandbox.run(&["trade", "scene.toml", error]);
        assert!(answer.code == Some(2) && answer.err.contains("expected a fraction above 0"), "{answer:?}");
    }
    refused(&["--deadline", "20 us"], &["--deadline", "20 us at 168 MHz"]);
    refused(&["--deadline", "20 um at 168 MHz"], &["--deadline"]);
    refused(&["-o", "a.toml"], &["--output", "--error or --deadline"]);
    refused(&["--error", "1%", "-o", "scene.toml"], &["--output"]);
}

/// Bearings without a rotor have no motion: their forces are compared about the preload.
#[test]
fn a_bearing_alone_is_traded() {
    let sandbox = Sandbox::empty();
    let (before, rest) = LUMPED.split_once("[rotor]").unwrap();
    sandbox.put("alone.toml", format!("{before}[[bearing]]{}", rest.split("[[bearing]]").nth(1).unwrap()));
    let outcome: Value = sandbox.done(&["trade", "alone.toml", "--format", "json"]).json();
    assert_eq!(outcome["motion"], "displacements about the preload");
    assert_eq!((number(&outcome, "/poses"), list(&outcome, "responses").len()), (512.0, 0));
    let exact = |precision: &'static str| {
        list(&outcome, "candidates").iter().find(move |one| {
            one["model"] == "lumped"
                && one["arithmetic"]["precision"] == precision
                && one["arithmetic"]["math"] == "exact"
        })
    };
    let single = exact("f32").unwrap();
    assert!(number(single, "/rounding/largest") < 1e-5 && number(single, "/rounding/largest") > 0.0, "{single}");
    assert!(number(single, "/cortex/cycles") > 100.0, "{single}");
    let text = sandbox.done(&["trade", "alone.toml", "--deadline", "100 us at 84 MHz"]).out;
    assert!(text.contains("512 poses of each bearing from the displacements about the preload"), "{text}");
    assert!(text.contains("for one sample of every bearing") && text.contains("alone-chosen.toml"), "{text}");
}

/// A method whose motion overflows is named and on no front; a model is recommended only where a motion with it does not.
#[test]
fn motions_that_overflow_are_named() {
    // Damping that an explicit method with the default step does not bear, the implicit one does.
    let damped = swap(LUMPED, "[[bearing]]", "[integration]\nmethod = \"newmark\"\n[[bearing]]");
    let damping = LUMPED.lines().find(|line| line.starts_with("damping")).unwrap();
    let damped = swap(&damped, damping, "damping = [5e5, 5e5, 5e5, 0, 0]");
    let sandbox = sandbox(&damped);
    let json: Value = sandbox.done(&["trade", "scene.toml", "--error", "10%", "--format", "json"]).json();
    let responses = json["responses"].as_array().unwrap();
    let (overflowed, sound): (Vec<&Value>, Vec<&Value>) =
        responses.iter().partition(|response| response["overflow"].is_string());
    assert!(!overflowed.is_empty() && !sound.is_empty(), "{responses:?}");
    for response in &overflowed {
        assert!(response["front"] == false && response["error"]["residual"].is_null(), "{response}");
        assert!(response["overflow"].as_str().unwrap().starts_with("the motion overflows: "), "{response}");
    }
    assert!(sound.iter().any(|response| response["method"] == "newmark"), "{sound:?}");
    assert!(json["choice"]["model"].is_string(), "{json}");
    let text = sandbox.done(&["trade", "scene.toml"]).out;
    assert_eq!(text.matches("  the motion overflows").count(), overflowed.len(), "{text}");
    assert!(sandbox.read("ballrace-trade.html").contains("the motion overflows: "));
    let csv = sandbox.done(&["trade", "scene.toml", "--format", "csv"]).out;
    assert_eq!(csv.matches("the motion overflows: ").count(), overflowed.len(), "{csv}");

    // The motion with which all others are compared.
    let coarse = LUMPED.to_owned() + "[integration]\nstep = \"1 s\"\n";
    sandbox.put("coarse.toml", swap(&coarse, damping, "damping = [5e5, 5e5, 5e5, 0, 0]"));
    sandbox.refused(&["trade", "coarse.toml"], 1, &["the motion overflows: "]);
}
