//! `[[limit]]`: events with their start, end and worst value, and exit code 3.

use serde_json::Value;

use crate::support::{DIAGNOSED, Sandbox, head, recorded};

fn sandbox(scene: &str, limits: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    let text = std::fs::read_to_string(recorded(&format!("{scene}.toml"))).unwrap();
    let folder = recorded("");
    sandbox.put("scene.toml", text.replace("file = \"", &format!("file = \"{folder}")) + limits);
    sandbox
}

fn events(sandbox: &Sandbox, code: i32, args: &[&str]) -> Vec<Value> {
    let all = [&["replay", "scene.toml", "--report", "r.html", "--format", "json"], args].concat();
    let run = sandbox.run(&all);
    assert_eq!(run.code, Some(code), "{run:?}");
    serde_json::from_str::<Value>(&run.out).unwrap()["events"].as_array().unwrap().clone()
}

/// Four times the unbalance: the 1X crosses its limit in every block, that of a sound machine does not.
#[test]
fn unbalance_exceeds_a_1x_limit() {
    let limit = "\n[[limit]]\nindicator = \"1X\"\nmax = \"0.25 um\"\nprobe = \"DE_Y_um\"\nduration = \"0.1 s\"\n";
    assert!(events(&sandbox("healthy", limit), 0, &[]).is_empty());
    let found = events(&sandbox("healthy", limit), 3, &["--recording", &recorded("unbalanced.csv")]);
    let [event] = &found[..] else { panic!("{found:?}") };
    assert_eq!((event["indicator"].as_str(), event["probe"].as_str()), (Some("1X"), Some("DE_Y_um")));
    assert!(event["start_s"].as_f64().unwrap() < 0.01 && event["end_s"].is_null(), "{event}");
    // The residual of a healthy twin stands at 0.40 um there; healthy motion adds or takes a quarter of it.
    let worst = event["worst"].as_f64().unwrap();
    assert!((0.3..0.7).contains(&worst), "{event}");
    assert!(event["sentence"].as_str().unwrap().contains("1X at DE_Y_um up to 0."), "{event}");
}

/// Through the run-up the swing grows and falls: one event with a start and an end for each crossing, none that is
/// shorter than its duration.
#[test]
fn events_begin_and_end() {
    let limit = |max: &str, duration: &str| {
        format!(
            "\n[[limit]]\nindicator = \"peak-to-peak\"\nmax = \"{max}\"\nprobe = \"DE_X_um\"\nduration = \"{duration}\"\n"
        )
    };
    let most = events(&sandbox("run-up", &limit("0.001 um", "0 s")), 3, &[]);
    let [event] = &most[..] else { panic!("{most:?}") };
    let largest = event["worst"].as_f64().unwrap();
    let at = event["worst_s"].as_f64().unwrap();
    let some = events(&sandbox("run-up", &limit(&format!("{} um", 0.8 * largest), "0 s")), 3, &[]);
    assert!(!some.is_empty());
    assert!(
        some.iter().any(|e| {
            let end = e["end_s"].as_f64().unwrap_or(f64::INFINITY);
            e["start_s"].as_f64().unwrap() < at && at <= end && (e["worst"].as_f64().unwrap() - largest).abs() < 1e-9
        }),
        "{some:?}"
    );
    assert!(events(&sandbox("run-up", &limit(&format!("{} um", 0.8 * largest), "10 s")), 0, &[]).is_empty());
}

/// Against a baseline: the outer race's line has grown, by 20 dB and far more, on the damaged bearing.
#[test]
fn growth_over_a_baseline() {
    let limits = "\n[[limit]]\nindicator = \"outer-race\"\nbearing = \"DE\"\ngrowth_db = 20\n";
    let sandbox = sandbox("healthy", "");
    for name in ["healthy.csv", "outer-spall.csv"] {
        let text = std::fs::read_to_string(recorded(name)).unwrap();
        sandbox.put(name, head(&text, DIAGNOSED));
    }
    sandbox.replay("scene.toml", &["--recording", "healthy.csv", "--learn", "b.json"]);
    sandbox.put("scene.toml", sandbox.read("scene.toml") + limits);
    assert!(events(&sandbox, 0, &["--baseline", "b.json", "--recording", "healthy.csv"]).is_empty());
    let found = events(&sandbox, 3, &["--baseline", "b.json", "--recording", "outer-spall.csv"]);
    assert!(found.iter().any(|e| e["bearing"] == "DE" && e["probe"] == "DE_Y_um"), "{found:?}");
    let run = sandbox.run(&["replay", "scene.toml", "--report", "r.html"]);
    assert!(
        run.code == Some(2) && run.err.contains("limit: growth_db: no baseline, expected replay with --baseline"),
        "{run:?}"
    );
}

#[test]
fn limits_are_checked() {
    for (limit, says) in [
        ("indicator = \"3X\"\nmax = \"1 um\"", "peak-to-peak"),
        ("indicator = \"1X\"", "one of them"),
        ("indicator = \"1X\"\nmax = \"1 um\"\ngrowth_db = 6", "one of them"),
        ("indicator = \"1X\"\nmax = 1e-6\nbearing = \"DE\"", "only there"),
        ("indicator = \"outer-race\"\nmax = \"1 um\"", "only there"),
        (
            "indicator = \"outer-race\"\nmax = \"1 um\"\nbearing = \"X\"",
            "no such bearing: \"X\", expected the name of a [[bearing]]",
        ),
        ("indicator = \"kurtosis\"\ngrowth_db = 6", "misplaced key: 6, expected only with indicator"),
        ("indicator = \"rms\"\nmax = \"1 um\"\nprobe = \"Z\"", "no such probe: \"Z\", expected a probe of [recording]"),
        ("indicator = \"rms\"\nmax = \"1 um\"\nhysteresis = 1", "below 1"),
    ] {
        let sandbox = sandbox("healthy", &format!("\n[[limit]]\n{limit}\n"));
        let run = sandbox.run(&["replay", "scene.toml", "--report", "r.html"]);
        assert!(run.code == Some(2) && run.err.contains(says), "{limit}: {run:?}");
    }
}
