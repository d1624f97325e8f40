//! `ballrace fit`: the rig's facts from its recording.

use serde_json::Value;

use crate::support::{Desk, number, scene};

/// The rig's scene without its unbalance and with another clearance, modulus and damping.
fn wrong() -> String {
    scene(&[
        ("unbalance = [{ moment = \"120 g mm\", angle = \"0.3 rad\", station = \"20 mm\" }]", "unbalance = []"),
        ("diametral_clearance = \"10 um\"", "diametral_clearance = \"14 um\""),
        ("youngs_modulus = \"206 GPa\"", "youngs_modulus = \"190 GPa\""),
        ("youngs_modulus = \"206 GPa\"", "youngs_modulus = \"190 GPa\""),
        ("0.4 N m s/rad", "0.3 N m s/rad"),
        ("0.4 N m s/rad", "0.3 N m s/rad"),
    ])
}

fn interval(found: &Value, name: &str) -> [f64; 3] {
    let all = found["parameters"].as_array().unwrap();
    let one = all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name} in {all:?}"));
    ["low", "value", "high"].map(|key| one[key].as_f64().unwrap())
}

/// From a scene that is wrong in every number: each fact of the rig is within the interval found for it, and the fitted
/// scene leaves the probes' noise.
#[test]
fn the_rigs_facts_are_found() {
    let desk = Desk::rig();
    desk.put("healthy.csv", crate::support::DEMO_RECORDING);
    desk.put("wrong.toml", wrong());
    let found = desk.done(&["fit", "wrong.toml", "--turns", "40", "--format", "json"]);
    let found: Value = serde_json::from_str(&found.out).unwrap();
    let facts = [
        ("unbalance: moment", 120.0),
        ("unbalance: angle", 0.3_f64.to_degrees()),
        ("unbalance: station", 20.0),
        ("DE: diametral_clearance", 10.0),
        ("NDE: diametral_clearance", 10.0),
        ("DE: youngs_modulus", 206.0),
        ("NDE: youngs_modulus", 206.0),
        ("damping along X and Y", 400.0),
        ("damping along Z", 400.0),
        ("damping of tilt", 0.4),
        ("DE_X_um: offset", 0.0),
        ("DE_Y_um: offset", 0.0),
        ("NDE_X_um: offset", 0.0),
        ("NDE_Y_um: offset", 0.0),
        ("axial_um: offset", 0.0),
    ];
    for (name, fact) in facts {
        let [low, value, high] = interval(&found, name);
        println!("{name}: {value:.4} from {low:.4} to {high:.4}, fact {fact:.4}");
        assert!((low..=high).contains(&fact), "{name}: {fact} not in {low} to {high}");
    }
    // Useful intervals, where the recording can tell.
    for (name, width) in [("unbalance: moment", 10.0), ("DE: diametral_clearance", 3.0), ("damping of tilt", 0.2)] {
        let [low, _, high] = interval(&found, name);
        assert!(high - low < width, "{name}: {low} to {high}");
    }
    // A start that dies out in a tenth of the recording says little of the radial damping, and the report says so.
    let notes = found["notes"].to_string();
    assert!(notes.contains("damping along X and Y is not identifiable"), "{notes}");
    let outcome = desk.replay("wrong-fitted.toml", &[]);
    for i in 0..5 {
        // The recording begins with a transient, which a replay does not know: see tests/recordings/README.md.
        let left = number(&outcome, &format!("/probes/{i}/residual_rms_um"));
        assert!(left < 0.036, "probe {i}: {left} um");
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let desk = Desk::rig();
    let scene = wrong();
    desk.put("bare.toml", scene.split("[recording]").next().unwrap());
    desk.put("scene.toml", &scene);
    let (before, after) = scene.split_once("probes = [").unwrap();
    let after = after.split_once("\n]").unwrap().1;
    desk.put("deaf.toml", format!("{before}sensors = [{{ column = \"DE_X_um\", unit = \"g\" }}]{after}"));
    for (args, says) in [
        (&["fit", "deaf.toml"][..], "allowed with fit: probes"),
        (&["fit", "bare.toml"][..], "[recording]"),
        (&["fit", "scene.toml", "--turns", "0"][..], "--turns"),
        (&["fit", "scene.toml", "-o", "scene.toml"][..], "--output"),
        (&["fit", "scene.toml", "--only", "weight"][..], "possible values"),
    ] {
        let run = desk.run(args);
        assert!(run.code == Some(2) && run.err.contains(says), "{args:?}: {run:?}");
    }
}
