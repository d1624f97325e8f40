//! Endless inputs and extreme numbers: rejected at once, in bounded memory.

use crate::support::{DEMO_SCENE, Sandbox, scene, swap};
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(10);

fn shipped(name: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", sandbox.done(&["scenes", name]).out);
    sandbox
}

/// Runs with at most 2 GB of memory; the command has to end with `code` and one line that has all `parts`.
#[cfg(unix)]
fn refused_in_bounds(sandbox: &Sandbox, args: &[&str], code: i32, parts: &[&str]) {
    let before = sandbox.files();
    let answer = sandbox.run_in_memory(2_000_000, LIMIT, args);
    assert_eq!(answer.code, Some(code), "{answer:?}");
    assert!(answer.err.starts_with("ballrace: ") && answer.err.lines().count() == 1, "{answer:?}");
    for part in parts {
        assert!(answer.err.contains(part), "{part:?} is missing: {answer:?}");
    }
    assert_eq!(sandbox.files(), before, "files left behind: {answer:?}");
}

#[test]
#[cfg(unix)]
fn a_sweep_of_too_many_points_is_refused() {
    let sandbox = shipped("tiwari-balanced");
    let over = |ranges: &[&str]| {
        let mut args = vec!["sweep", "scene.toml", "-o", "a"];
        ranges.iter().for_each(|range| args.extend(["--over", range]));
        refused_in_bounds(&sandbox, &args, 2, &["--over: too many points", "expected at most"]);
    };
    let speeds = "shaft.speed=1000rpm..2000rpm:100000";
    let plays = "bearing[0].radial_play=1um..2um:100000";
    over(&[speeds, plays, "bearing[0].elements=7,8"]);
    // 65536^4 is 2^64: a product that wraps is no count.
    let wide = |key: &str| format!("{key}=1..2:65536");
    let keys = ["shaft.speed", "bearing[0].radial_play", "rotor.mass", "bearing[0].stiffness"].map(wide);
    over(&keys.each_ref().map(String::as_str));
}

#[test]
fn a_settling_time_beyond_every_simulation_is_refused() {
    let sandbox = shipped("tiwari-balanced");
    for time in ["1e300 s", "1e12 s"] {
        let args = ["sweep", "scene.toml", "-o", "a", "--over", "shaft.speed=1000rpm,2000rpm", "--settle", time];
        sandbox.refused(&args, 2, &["--settle: too many samples", "expected at most"]);
    }
}

#[test]
#[cfg(unix)]
fn an_endless_displacement_file_is_refused() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    let args = ["force", "scene.toml", "--bearing", "DE", "--displacements", "/dev/zero"];
    refused_in_bounds(&sandbox, &args, 1, &["/dev/zero", "pipe or a device", "expected a regular file"]);
}

#[test]
#[cfg(unix)]
fn an_endless_matrix_file_is_refused() {
    let sandbox = Sandbox::empty();
    let (head, rest) = DEMO_SCENE.split_once("[rotor]").unwrap();
    let (_, bearings) = rest.split_once("[[bearing]]").unwrap();
    let (bearings, _) = bearings.split_once("[recording]").unwrap();
    let bearings = swap(bearings, "station = \"-100 mm\"", "coordinates = [1, 3, 5, 0, 0]");
    let bearings = swap(&bearings, "station = \"100 mm\"", "coordinates = [2, 4, 5, 0, 0]");
    let system = "[system]\nmass = \"/dev/zero\"\nstiffness = \"/dev/zero\"\n\n";
    sandbox.put("scene.toml", format!("{head}{system}[[bearing]]{bearings}"));
    refused_in_bounds(&sandbox, &["equilibrium", "scene.toml"], 2, &["/dev/zero", "regular file"]);
}

#[test]
#[cfg(unix)]
fn other_endless_files_are_refused() {
    let sandbox = Sandbox::rig();
    refused_in_bounds(
        &sandbox,
        &["replay", "scene.toml", "--baseline", "/dev/zero"],
        2,
        &["/dev/zero", "regular file"],
    );
    let page = ["replay", "scene.toml", "--paced", "--http", "0", "--http-token-file", "/dev/zero"];
    refused_in_bounds(&sandbox, &page, 1, &["/dev/zero", "regular file"]);
    std::fs::create_dir(sandbox.path("state")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", sandbox.path("state/state.json")).unwrap();
    let state = ["replay", "scene.toml", "--paced", "--state", "state"];
    refused_in_bounds(&sandbox, &state, 1, &["state.json", "regular file"]);
    std::fs::create_dir(sandbox.path("trend")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", sandbox.path("trend/indicators.journal")).unwrap();
    let indicators = ["replay", "scene.toml", "--paced", "--indicators", "trend"];
    refused_in_bounds(&sandbox, &indicators, 1, &["indicators.journal", "no regular file"]);
    refused_in_bounds(&sandbox, &["fleet", "/dev/zero", "-o", "fleet"], 2, &["/dev/zero", "regular file"]);
}

/// A pipe without a writer in the place of a file blocks no command; a fleet evaluates its other machines.
#[test]
#[cfg(unix)]
fn a_pipe_in_the_place_of_a_file_is_refused() {
    let sandbox = Sandbox::rig();
    assert!(std::process::Command::new("mkfifo").arg(sandbox.path("pipe.csv")).status().unwrap().success());
    let refused = |args: &[&str], code: i32| refused_in_bounds(&sandbox, args, code, &["pipe.csv", "regular file"]);
    refused(&["replay", "scene.toml", "--recording", "pipe.csv"], 1);
    refused(&["check", "scene.toml", "--recording", "pipe.csv"], 1);
    refused(&["check", "pipe.csv"], 2);
    refused(&["new", "--bearing", "6205", "--recording", "pipe.csv"], 1);
    refused(&["force", "scene.toml", "--bearing", "DE", "--displacements", "pipe.csv"], 1);
    refused(&["verify", "pipe.csv"], 2);
    refused(&["fleet", "pipe.csv", "-o", "out"], 2);
    sandbox.put("piped.toml", DEMO_SCENE.replace("healthy.csv", "pipe.csv"));
    let table =
        "machine,scene,recording,baseline\na,scene.toml,,\nb,piped.toml,,\nc,pipe.csv,,\nd,scene.toml,,pipe.csv\n";
    sandbox.put("machines.csv", table);
    let args = ["fleet", "machines.csv", "-o", "out", "--jobs", "1", "--format", "json", "--no-report"];
    let answer = sandbox.run_within(Duration::from_secs(60), &args);
    assert_eq!(answer.code, Some(0), "{answer:?}");
    let rows: Vec<serde_json::Value> = answer.json();
    assert_eq!(rows.iter().map(|row| row["state"].as_str().unwrap()).filter(|state| *state == "error").count(), 3);
    assert!(rows[1]["error"].as_str().unwrap().contains("regular file"), "{rows:?}");
}

#[test]
fn two_columns_of_one_name_are_refused() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    let force = ["force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv"];
    for (header, name) in [("u,v,w,thu,thv,u", "\"u\""), ("t,u,v,w,thu,thv,t", "\"t\"")] {
        let row = header.split(',').map(|_| "1e-6").collect::<Vec<_>>().join(",");
        sandbox.put("u.csv", format!("{header}\n{row}\n"));
        sandbox.refused(&force, 2, &["u.csv:1: two columns are named", name]);
    }
    // Columns that the command does not read may repeat.
    sandbox.put("u.csv", "note,u,v,w,thu,thv,note\n1,1e-6,0,6e-5,0,0,2\n");
    sandbox.done(&force);
}

/// A rotor that nothing holds along an axis of its load has no equilibrium: it is printed, and the exit code is 1.
#[test]
fn no_equilibrium_exits_with_one_and_prints() {
    let sandbox = Sandbox::empty();
    // A radial model without an axial spring under 60 N along Z.
    let lumped = "model = \"lumped\"\nstiffness = 1e10\nradial_play = \"5 um\"";
    let text = scene(&[]).replace("model = \"angular\"", lumped);
    sandbox.put("scene.toml", text);
    for (format, part) in [("text", "NOT IN EQUILIBRIUM"), ("json", "\"residual\"")] {
        let answer = sandbox.run(&["equilibrium", "scene.toml", "--format", format]);
        assert_eq!(answer.code, Some(1), "{answer:?}");
        assert!(answer.out.contains(part), "{answer:?}");
        assert!(answer.err.starts_with("ballrace: ") && answer.err.contains("no equilibrium"), "{answer:?}");
        assert_eq!(answer.err.lines().count(), 1, "{answer:?}");
    }
}

/// A sample period that needs more integration steps than are taken is refused, not integrated beyond stability.
#[test]
fn a_sample_period_of_too_many_steps_is_refused() {
    let sandbox = Sandbox::rig();
    let args = ["simulate", "scene.toml", "--duration", "2 s", "--rate", "1 Hz", "-o", "m.csv"];
    sandbox.refused(&args, 2, &["integration steps", "expected at most 10000", "rate"]);
    sandbox.put("fine.toml", DEMO_SCENE.to_owned() + "\n[integration]\nstep = \"0.001 us\"\n");
    let args = ["simulate", "fine.toml", "--duration", "10 ms", "--rate", "1 kHz", "-o", "m.csv"];
    sandbox.refused(&args, 2, &["integration steps", "expected at most 10000", "step"]);
}
