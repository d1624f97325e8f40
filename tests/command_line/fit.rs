//! `ballrace fit`: the rig's facts from its recording.

use serde_json::Value;

use crate::observer::{TURN, motion, recording, rotor};
use crate::support::{Sandbox, demonstrated, list, number, numbers, scene, swap};

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
fn fit_finds_the_parameters_of_the_rig() {
    let sandbox = Sandbox::rig();
    sandbox.put("healthy.csv", crate::support::HEALTHY_RECORDING);
    sandbox.put("wrong.toml", wrong());
    let found = sandbox.done(&["fit", "wrong.toml", "--turns", "40", "--format", "json"]);
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
    // Useful intervals, where the recording determines the parameter.
    for (name, width) in [("unbalance: moment", 10.0), ("DE: diametral_clearance", 3.0), ("damping of tilt", 0.2)] {
        let [low, _, high] = interval(&found, name);
        assert!(high - low < width, "{name}: {low} to {high}");
    }
    // A transient that decays in a tenth of the recording determines the radial damping poorly, and the report states this.
    let notes = found["notes"].to_string();
    assert!(notes.contains("damping along X and Y is not identifiable"), "{notes}");
    let outcome = sandbox.replay("wrong-fitted.toml", &[]);
    for i in 0..5 {
        // The recording begins with a transient, which a replay does not know: see tests/recordings/README.md.
        let left = number(&outcome, &format!("/probes/{i}/residual_rms_um"));
        assert!(left < 0.036, "probe {i}: {left} um");
    }
}

/// Cage speed over shaft speed of the rotor's bearings, 0.5 % below pure rolling at the free contact angle.
const SLIPPING: f64 = 0.380_434_48 * 0.995;
/// Cage angles of A and B at the start of the simulation, deg. The scene to fit states none.
const CAGE_ANGLES: [f64; 2] = [17.0, -31.0];
const ELEMENTS: f64 = 8.0;

/// The rotor with an axial load that leaves the passing of the elements visible; `of_bearings` are lines of A and B.
fn light_rotor(of_bearings: [&str; 2]) -> String {
    let text = swap(&rotor("angular", of_bearings[0], "Z"), "load = [0, 0, 100, 0, 0]", "load = [0, 0, 20, 0, 0]");
    swap(&text, "name = \"B\"\n", &format!("name = \"B\"\n{}", of_bearings[1]))
}

/// 40 turns of the rotor with slipping cages; `defect` is a line of bearing A. Young's modulus in the scene to fit is wrong.
fn slipping(defect: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    let [a, b] = CAGE_ANGLES.map(|deg| format!("cage_ratio = {SLIPPING}\nfirst_element_azimuth = \"{deg} deg\"\n"));
    sandbox.put("generating.toml", light_rotor([&(a + defect), &b]));
    sandbox.put("scene.toml", light_rotor(["youngs_modulus = \"195 GPa\"\n", "youngs_modulus = \"215 GPa\"\n"]));
    sandbox.put("recording.csv", recording(&motion(&sandbox, "generating.toml", 20..60), TURN));
    sandbox
}

#[test]
fn cages_that_slip_at_an_unknown_angle_leave_the_stiffness_right() {
    let found: Value =
        slipping("").done(&["fit", "scene.toml", "--only", "stiffness,unbalance", "--format", "json"]).json();
    assert_eq!(found["consistent"], true, "{found:#}");
    let pitch = 360.0 / ELEMENTS;
    for (bearing, start) in ["A", "B"].iter().zip(CAGE_ANGLES) {
        let [low, value, high] = interval(&found, &format!("{bearing}: youngs_modulus"));
        assert!((low..=high).contains(&206.0) && high - low < 2.0, "{bearing}: {value} GPa, {low} to {high}");
        let [low, value, high] = interval(&found, &format!("{bearing}: cage_ratio"));
        assert!((low..=high).contains(&SLIPPING) && high - low < 1e-4, "{bearing}: {value}, {low} to {high}");
        // The recording begins 20 turns after the simulation.
        let truth = start + 20.0 * 360.0 * SLIPPING;
        let [low, value, high] = interval(&found, &format!("{bearing}: first_element_azimuth"));
        let off = (value - truth + 0.5 * pitch).rem_euclid(pitch) - 0.5 * pitch;
        assert!(off.abs() <= 0.5 * (high - low) && high - low < 1.0, "{bearing}: {value} deg, {truth} is true");
    }
}

/// A spall that the scene does not have: chi-squared per reading is above what noise causes, though below 2.
#[test]
fn a_recording_that_the_model_does_not_describe_gets_no_intervals() {
    let spall = "defect = [{ surface = \"outer\", azimuth = \"-70 deg\", half_width = \"2.5 deg\", depth = \"0.05 um\", shape = \"half-sine\" }]\n";
    let found: Value =
        slipping(spall).done(&["fit", "scene.toml", "--only", "stiffness,unbalance", "--format", "json"]).json();
    let [chi_square, largest] = ["", "largest_"].map(|s| number(&found, &format!("/{s}chi_square_per_reading")));
    assert!((1.0..1.1).contains(&largest) && largest < chi_square && chi_square < 2.0, "{chi_square}, {largest}");
    assert_eq!(found["consistent"], false);
    for p in list(&found, "parameters") {
        assert!(p["value"].is_f64() && p["low"].is_null() && p["high"].is_null(), "{p}");
    }
}

/// The demonstration's axial load hides the passing of its elements; eight turns are too few to search it.
#[test]
fn cages_that_cannot_be_estimated_are_named() {
    let sandbox = Sandbox::rig();
    let notes = |sandbox: &Sandbox| {
        let found: Value =
            sandbox.done(&["fit", "scene.toml", "--turns", "4", "--only", "clearance", "--format", "json"]).json();
        found["notes"].to_string()
    };
    let short = notes(&sandbox);
    assert!(short.contains("The cages are not estimated: 8.0 revolutions in a row"), "{short}");
    sandbox.put("healthy.csv", crate::support::HEALTHY_RECORDING);
    let whole = notes(&sandbox);
    for bearing in ["DE", "NDE"] {
        assert!(whole.contains(&format!("{bearing}: the cage is not observable in this recording")), "{whole}");
    }
}

#[test]
fn parameters_that_cannot_be_fitted_are_rejected() {
    let sandbox = Sandbox::rig();
    let scene = wrong();
    sandbox.put("bare.toml", scene.split("[recording]").next().unwrap());
    sandbox.put("scene.toml", &scene);
    let (before, after) = scene.split_once("probes = [").unwrap();
    let after = after.split_once("\n]").unwrap().1;
    sandbox.put("deaf.toml", format!("{before}sensors = [{{ column = \"DE_X_um\", unit = \"g\" }}]{after}"));
    for (args, says) in [
        (&["fit", "deaf.toml"][..], "[recording]: no probes, expected probes in fit"),
        (&["fit", "bare.toml"][..], "[recording]"),
        (&["fit", "scene.toml", "--turns", "0"][..], "--turns"),
        (&["fit", "scene.toml", "-o", "scene.toml"][..], "--output"),
        (&["fit", "scene.toml", "--only", "weight"][..], "possible values"),
    ] {
        let run = sandbox.run(args);
        assert!(run.code == Some(2) && run.err.contains(says), "{args:?}: {run:?}");
    }
}

/// The demonstration's sound machine by a scene that is wrong in every number: the truth is in the intervals, the errors of the readings are
/// those of `demonstration.rs`, and the fitted scene describes the machine.
#[test]
fn a_recording_of_a_site_is_fitted_with_the_errors_of_its_readings() {
    let sandbox = Sandbox::empty();
    sandbox.put("healthy.csv", std::fs::read(demonstrated("healthy.csv")).unwrap());
    let unbalance = "unbalance = [{ moment = \"90 g mm\", angle = \"0.1 rad\", station = \"15 mm\" }]";
    let text = swap(&wrong(), "unbalance = []", unbalance);
    sandbox.put("site.toml", text.replace("14 um", "12 um"));
    let found: Value = sandbox.done(&["fit", "site.toml", "--format", "json"]).json();
    assert_eq!(found["consistent"], true, "{found:#}");
    let facts = [
        ("unbalance: moment", 120.0),
        ("DE: diametral_clearance", 10.0),
        ("NDE: diametral_clearance", 10.0),
        ("DE: youngs_modulus", 206.0),
        ("NDE: youngs_modulus", 206.0),
        ("damping along X and Y", 400.0),
        ("damping of tilt", 0.4),
    ];
    for (name, fact) in facts {
        let [low, value, high] = interval(&found, name);
        assert!((low..=high).contains(&fact), "{name}: {value}, {fact} not in {low} to {high}");
    }
    let errors = list(&found, "errors");
    for (error, gap) in errors.iter().zip([11.3, -6.4, 3.7, -14.2]) {
        assert!((number(error, "/gap_um") - gap).abs() < 0.6, "{error}, {gap} um is true");
    }
    assert!(
        (number(&errors[1], "/hum_um") - 0.15).abs() < 0.02 && number(&errors[1], "/hum_hz") == 50.0,
        "{}",
        errors[1]
    );
    // 2.5 um as a sine of 25 s, over a second.
    assert!((number(&errors[2], "/drift_um") - 0.62).abs() < 0.2, "{}", errors[2]);
    let notes = found["notes"].to_string();
    assert!(notes.contains("the unbalance is not told from the run-out"), "{notes}");
    let outcome = sandbox.replay("site-fitted.toml", &[]);
    assert!(list(&outcome, "findings").is_empty(), "{:#}", outcome["findings"]);
    let text = sandbox.done(&["fit", "site.toml", "--only", "clearance", "--report", "fit.html"]).out;
    assert!(
        text.contains("errors of reading") && !text.contains("youngs_modulus") && !text.contains("offset"),
        "{text}"
    );
    assert!(sandbox.read("fit.html").contains("Errors of the readings"));
}

/// A fit that does not converge on the readings of a site, in its time or on any machine of the scene, writes nothing.
#[test]
fn a_fit_at_a_site_without_a_minimum_writes_nothing() {
    let sandbox = Sandbox::empty();
    let recorded = String::from_utf8(std::fs::read(demonstrated("healthy.csv")).unwrap()).unwrap();
    sandbox.put("healthy.csv", &recorded);
    sandbox.put("site.toml", wrong());
    let late = sandbox.run(&["fit", "site.toml", "--time-limit", "0.01 s"]);
    let is_late = late.err.contains("healthy.csv: the fit does not converge because its time has ended: 0.01 s, over ");
    assert!(late.code == Some(1) && is_late && late.out.is_empty(), "{late:?}");
    assert!(!sandbox.path("site-fitted.toml").exists());
}

/// Gaps alone are offsets of the scene: the fit along the time finds them, and the parameters as exactly as without them.
#[test]
fn gaps_alone_are_offsets() {
    const GAPS: [f64; 5] = [3.0, -2.5, 4.0, -6.0, 2.0];
    let (names, rows) = numbers(crate::support::HEALTHY_RECORDING);
    let mut text = format!("time_s,{}\n", names[names.len() - 6..].join(","));
    for (i, row) in rows.iter().enumerate() {
        let [readings @ .., keyphasor] = &row[row.len() - 6..] else { panic!("{row:?}") };
        text += &format!("{:.7}", i as f64 / 12_800.0);
        readings.iter().zip(GAPS).for_each(|(reading, gap)| text += &format!(",{:.4}", reading + gap));
        text += &format!(",{keyphasor}\n");
    }
    let sandbox = Sandbox::rig();
    sandbox.put("healthy.csv", text);
    let found: Value = sandbox.done(&["fit", "scene.toml", "--turns", "20", "--format", "json"]).json();
    assert!(found["consistent"] == true && found["errors"].is_null(), "{found:#}");
    for (column, gap) in ["DE_X_um", "DE_Y_um", "NDE_X_um", "NDE_Y_um", "axial_um"].iter().zip(GAPS) {
        let [low, value, high] = interval(&found, &format!("{column}: offset"));
        assert!((low..=high).contains(&gap), "{column}: {value}, {gap} um not in {low} to {high}");
    }
}
