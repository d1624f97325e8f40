//! `ballrace fit`: intervals only where the scene describes the recording, and a search within physical bounds.

use crate::support::{Sandbox, number, scene};
use serde_json::Value;

const UNBALANCE: &str = "unbalance = [{ moment = \"120 g mm\", angle = \"0.3 rad\", station = \"20 mm\" }]";

fn fitted(sandbox: &Sandbox, more: &[&str]) -> Value {
    sandbox.done(&[&["fit", "scene.toml", "--turns", "4", "--format", "json"], more].concat()).json()
}

#[test]
fn no_intervals_where_the_model_does_not_describe_the_data() {
    let sandbox = Sandbox::rig();
    // An unbalance that is not there, and only the clearance is free: the twin cannot follow.
    sandbox.put("scene.toml", scene(&[(UNBALANCE, "unbalance = []")]));
    let found = fitted(&sandbox, &["--only", "clearance"]);
    assert!(number(&found, "/chi_square_per_reading") > 2.0, "{found}");
    assert_eq!(found["consistent"], false);
    let parameters = found["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 2);
    for p in parameters {
        assert!(p["value"].is_f64() && p["low"].is_null() && p["high"].is_null(), "{p}");
    }
    let text = sandbox.done(&["fit", "scene.toml", "--turns", "4", "--only", "clearance"]).out;
    assert!(text.contains("WARNING: the scene does not describe the recording: chi-squared per reading"), "{text}");
    assert!(text.contains("No intervals are given") && !text.contains("95 of 100"), "{text}");
    let csv = sandbox.done(&["fit", "scene.toml", "--turns", "4", "--only", "clearance", "--format", "csv"]).out;
    assert!(csv.lines().nth(1).unwrap().contains(",,"), "{csv}");
}

#[test]
fn intervals_where_it_does() {
    let sandbox = Sandbox::rig();
    sandbox.put("scene.toml", scene(&[("diametral_clearance = \"10 um\"", "diametral_clearance = \"14 um\"")]));
    let found = fitted(&sandbox, &["--only", "clearance"]);
    assert_eq!(found["consistent"], true);
    for p in found["parameters"].as_array().unwrap() {
        let [low, high] = ["/low", "/high"].map(|key| number(p, key));
        assert!((low..=high).contains(&10.0), "{p}");
    }
}

/// Differences and steps stay within what a bearing can have: no clearance below 0, none beyond the groove distance.
#[test]
fn a_search_at_the_bound_of_the_clearance_goes_on() {
    let sandbox = Sandbox::rig();
    let clearance = "diametral_clearance = \"10 um\"";
    for start in ["0 um", "1 nm", "300 um"] {
        let other = format!("diametral_clearance = \"{start}\"");
        sandbox.put("scene.toml", scene(&[(clearance, &other), (clearance, &other)]));
        let answer = sandbox.run(&["fit", "scene.toml", "--turns", "2", "--only", "clearance", "--format", "json"]);
        assert_eq!(answer.code, Some(0), "{start}: {answer:?}");
        let found: Value = answer.json();
        for p in found["parameters"].as_array().unwrap() {
            assert!((0.0..317.6).contains(&number(p, "/value")), "{start}: {p}");
        }
    }
    // The true clearance is found from the bound.
    sandbox.put("scene.toml", scene(&[(clearance, "diametral_clearance = \"0 um\""); 2]));
    let found = fitted(&sandbox, &["--only", "clearance"]);
    for p in found["parameters"].as_array().unwrap() {
        assert!((number(p, "/value") - 10.0).abs() < 0.1, "{p}");
    }
}

/// The opposite case: a recording of a bearing without clearance leads the search to the bound from above.
#[test]
fn a_bearing_without_clearance_is_fitted_at_the_bound() {
    let sandbox = Sandbox::rig();
    let clearance = "diametral_clearance = \"10 um\"";
    sandbox.put("truth.toml", scene(&[(clearance, "diametral_clearance = \"0 um\""); 2]));
    // The tightest bearing that the twin can be: its probes at the truth's own displacements.
    sandbox.done(&[
        "simulate",
        "truth.toml",
        "--settle",
        "0.5 s",
        "--duration",
        "80 ms",
        "--rate",
        "12.8 kHz",
        "-o",
        "m.csv",
    ]);
    let (header, rows) = crate::support::numbers(&sandbox.read("m.csv"));
    assert_eq!(header[1..6].join(","), "u,v,w,thu,thv");
    let table = sandbox.read("healthy.csv");
    let mut lines = table.lines();
    let head = lines.next().unwrap();
    let mut out = format!("{head}\n");
    for (i, (line, row)) in lines.zip(&rows).enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let [u, v, w, thu, thv] = [1, 2, 3, 4, 5].map(|k| row[k]);
        // Noise of 0.03 um that is the same everywhere; 1 um is taken off along the axis: tighter than any clearance.
        let noise = |p: usize| 0.05 * (((i * 7 + p * 3) as f64 * 0.618_034).fract() - 0.5);
        let probes = [u - 0.12 * thv, v + 0.12 * thu, u + 0.12 * thv, v - 0.12 * thu, w - 0.3e-6];
        for (p, x) in probes.iter().enumerate() {
            cells[1 + p] = format!("{:.5}", x * 1e6 + noise(p));
        }
        out += &(cells.join(",") + "\n");
    }
    sandbox.put("healthy.csv", out);
    sandbox.put("scene.toml", scene(&[(clearance, "diametral_clearance = \"2 um\""); 2]));
    let answer = sandbox.run(&["fit", "scene.toml", "--turns", "4", "--only", "clearance", "--format", "json"]);
    assert_eq!(answer.code, Some(0), "{answer:?}");
    let found: Value = answer.json();
    for p in found["parameters"].as_array().unwrap() {
        assert!(number(p, "/value") >= 0.0, "{p}");
        assert!(p["low"].is_null() || number(p, "/low") >= 0.0, "{p}");
    }
}
