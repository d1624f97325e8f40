//! Recordings as a site gives them: gaps, run-out, hum and drift in the readings, and an imperfect sound bearing. None of these is a fault
//! of a bearing or of the rotor, and a fault is found beside them.

use crate::observer::{TURN, motion, recording, rotor};
use crate::support::{Sandbox, list, number, swap};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

const TURNS: usize = 30;
const RATE: f64 = 12_800.0;
/// Reading of each radial probe with the shaft in the middle, um.
const GAPS: [f64; 4] = [7.0, -11.0, 3.0, 14.0];
/// Amplitude of each multiple of the shaft angle in the run-out, um.
const RUN_OUT: [f64; 5] = [3.0, 1.0, 0.6, 0.5, 0.2];
/// What a sound bearing has: waves of its races, at angles of its own.
const WAVES: &str = "waviness = [{ surface = \"outer\", order = 8, amplitude = \"0.05 um\", phase = \"40 deg\" }, \
                     { surface = \"inner\", order = 7, amplitude = \"0.05 um\", phase = \"110 deg\" }]\n";
const CAGE: &str = "cage_ratio = 0.37739\nfirst_element_azimuth = \"17 deg\"\n";

/// The readings of a site: those of the motion and `more` (um) by time, probe and shaft angle; `speed` is a share of that of the machine.
fn readings(motion: &[Vec<f64>], more: impl Fn(f64, usize, f64) -> f64) -> String {
    let text = recording(motion, TURN);
    let mut lines = text.lines();
    let mut out = lines.next().unwrap_or_default().to_owned() + "\n";
    for (i, line) in lines.enumerate() {
        let (time, angle) = (i as f64 / RATE, TAU * (i % TURN) as f64 / TURN as f64);
        let cells = line.split(',').enumerate().map(|(column, cell)| match cell.parse::<f64>() {
            Ok(x) if column < GAPS.len() => {
                let run_out = |(k, a): (usize, &f64)| a * ((k + 1) as f64 * angle + (k * column) as f64).cos();
                let site = GAPS[column] + RUN_OUT.iter().enumerate().map(run_out).sum::<f64>();
                format!("{:.5}", x + site + more(time, column, angle))
            }
            _ => cell.to_owned(),
        });
        out += &cells.collect::<Vec<_>>().join(",");
        out.push('\n');
    }
    out
}

/// The scene of a site, and that of its machine.
fn scenes() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", rotor("angular", "", "Z"));
    sandbox.put("sound.toml", rotor("angular", &format!("{CAGE}{WAVES}"), "Z"));
    sandbox
}

/// A site with its baseline in `b.json`, from a sound recording; all tests share the one that is learned.
fn site() -> Sandbox {
    static BASELINE: OnceLock<String> = OnceLock::new();
    let baseline = BASELINE.get_or_init(|| {
        let sandbox = scenes();
        sandbox.put("recording.csv", readings(&motion(&sandbox, "sound.toml", 20..20 + TURNS), |_, _, _| 0.0));
        let run = sandbox.run(&["replay", "scene.toml", "--no-report", "--learn", "b.json", "--format", "json"]);
        assert!(run.code == Some(0), "{run:?}");
        sandbox.read("b.json")
    });
    let sandbox = scenes();
    sandbox.put("b.json", baseline);
    sandbox
}

/// The outcome of the recording against the baseline.
fn outcome(sandbox: &Sandbox) -> Value {
    sandbox.replay("scene.toml", &["--no-report", "--baseline", "b.json"])
}

fn kinds(outcome: &Value) -> Vec<&str> {
    list(outcome, "findings").iter().filter_map(|one| one["kind"].as_str()).collect()
}

#[test]
fn what_a_measurement_adds_is_no_fault() {
    let sandbox = site();
    let baseline: Value = serde_json::from_str(&sandbox.read("b.json")).unwrap();
    let probes = list(&baseline["calibration"], "readings");
    for (probe, (gap, run_out)) in probes.iter().zip(GAPS.iter().zip([RUN_OUT; 4])) {
        // At order 1, unbalance and run-out are not told apart without a slow roll.
        let [c, s] = [0, 1].map(|part| number(probe, &format!("/run_out/1/{part}")));
        assert!((1e6 * c.hypot(s) - run_out[1]).abs() < 0.1, "{probe}");
        assert!((1e6 * number(probe, "/gap") - gap).abs() < 4.0, "{gap}: {probe}");
    }
    let moved = motion(&sandbox, "sound.toml", 33..33 + TURNS);
    let of = |more: &dyn Fn(f64, usize, f64) -> f64| {
        sandbox.put("recording.csv", readings(&moved, more));
        outcome(&sandbox)
    };
    let none: [&str; 0] = [];
    assert_eq!(kinds(&of(&|_, _, _| 0.0)), none);
    assert_eq!(kinds(&of(&|_, probe, _| [0.4, -0.6, 0.2, 0.5][probe])), none, "gaps after a new start");
    let drifting = of(&|time, probe, _| if probe == 3 { 6.0 * time } else { 0.0 });
    assert_eq!(kinds(&drifting), none, "drift");
    let verdict = drifting["verdict"].as_str().unwrap();
    let column = list(&drifting, "probes")[3]["name"].as_str().unwrap();
    assert!(
        verdict.starts_with("No fault is found") && verdict.contains(&format!("{column} drifts by +3.")),
        "{verdict}"
    );
    // The gaps of the baseline are no residual of the twin.
    for (probe, gap) in list(&drifting, "probes").iter().zip(GAPS) {
        assert!(number(probe, "/residual_bias_um").abs() < 2.0, "{gap} um: {probe:#}");
    }
    let hum = |time: f64, probe: usize, _: f64| if probe == 1 { 0.8 * (TAU * 50.0 * time).sin() } else { 0.0 };
    // 50 Hz is the speed of the shaft here: this hum is a run-out.
    let with_hum = of(&hum);
    assert!(kinds(&with_hum).iter().all(|kind| *kind == "run-out"), "{}", with_hum["findings"]);
}

/// A motion that is far larger than that of the baseline is no machine in good order, whatever the model takes it for.
#[test]
fn a_motion_that_has_grown_is_not_decided() {
    let sandbox = site();
    sandbox.put("recording.csv", readings(&motion(&sandbox, "sound.toml", 33..33 + TURNS), |_, _, _| 0.0));
    let learned: Value = serde_json::from_str(&sandbox.read("b.json")).unwrap();
    let of = |times: f64| {
        let mut smaller = learned.clone();
        let motion = &mut smaller["calibration"]["readings"][2]["motion_rms"];
        *motion = (motion.as_f64().unwrap() / times).into();
        sandbox.put("b.json", smaller.to_string());
        outcome(&sandbox)
    };
    assert!(kinds(&of(2.3)).is_empty());
    let grown = of(2.7);
    assert_eq!(kinds(&grown), ["other"]);
    let column = list(&grown, "probes")[2]["name"].as_str().unwrap();
    let verdict = grown["verdict"].as_str().unwrap();
    assert!(
        verdict.contains(&format!("Not decided: the motion at {column} is 2.7 times that of the baseline")),
        "{verdict}"
    );
}

/// Place and size of a spall are known to the error of the model at its lines: the interval of each contains the truth.
#[test]
fn a_spall_is_found_beside_it() {
    let sandbox = site();
    let (azimuth, half_width, depth) = (-90.0, 2.5, 6.0);
    for (surface, kind) in [("outer", "outer-race"), ("inner", "inner-race")] {
        let spall = format!(
            "defect = [{{ surface = \"{surface}\", azimuth = \"{azimuth} deg\", half_width = \"{half_width} deg\", depth = \"{depth} um\", \
             shape = \"half-sine\" }}]\n"
        );
        let spalled = swap(&sandbox.read("sound.toml"), "name = \"A\"\n", &format!("name = \"A\"\n{spall}"));
        sandbox.put("spalled.toml", spalled);
        sandbox.put("recording.csv", readings(&motion(&sandbox, "spalled.toml", 20..20 + TURNS), |_, _, _| 0.0));
        let outcome = outcome(&sandbox);
        let findings = list(&outcome, "findings");
        assert_eq!(kinds(&outcome), [kind], "{findings:#?}");
        assert_eq!(findings[0]["bearing"], "A", "{findings:#?}");
        for (key, truth) in [("azimuth_deg", azimuth + 360.0), ("half_width_deg", half_width), ("depth_um", depth)] {
            let [low, high] = ["/low", "/high"].map(|end| number(&findings[0][key], end));
            assert!(low < truth && truth < high, "{surface}: {key} {}", findings[0][key]);
        }
    }
}

/// A machine that was never recorded in good order has the errors of its scene, and none of them is a fault.
#[test]
fn errors_of_a_scene_without_a_baseline_are_no_fault() {
    let sandbox = scenes();
    let scene = sandbox.read("scene.toml");
    // A clearance 10 % larger bends the shape of all lines as a tilt would.
    let turns = TURNS + 10;
    sandbox.put("recording.csv", readings(&motion(&sandbox, "sound.toml", 33..33 + turns), |_, _, _| 0.0));
    let factors = if ballrace_tests::runs_all() { &[0.9, 1.1][..] } else { &[1.1] };
    for factor in factors {
        let clearance = |um: f64| format!("diametral_clearance = \"{um} um\"");
        sandbox.put("scene.toml", scene.replace(&clearance(10.0), &clearance(10.0 * factor)));
        let outcome = sandbox.replay("scene.toml", &["--no-report"]);
        assert!(kinds(&outcome).iter().all(|kind| *kind == "other"), "{factor}: {:#}", outcome["findings"]);
    }
}

/// The gaps are unknown, so that a clearance and the position of the rotor are found together: what is learned from a scene that is off holds the
/// true clearance in its interval.
#[test]
fn a_learned_clearance_is_no_surer_than_the_position() {
    let sandbox = scenes();
    let of = |text: &str, um: f64| {
        let text = swap(text, "mass = \"20 kg\"", "mass = \"4.5 kg\"");
        text.replace("diametral_clearance = \"10 um\"", &format!("diametral_clearance = \"{um} um\""))
    };
    let scene = sandbox.read("scene.toml");
    sandbox.put("sound.toml", of(&sandbox.read("sound.toml"), 16.0));
    sandbox.put("recording.csv", readings(&motion(&sandbox, "sound.toml", 20..20 + TURNS), |_, _, _| 0.0));
    for factor in [0.85, 1.15] {
        sandbox.put("scene.toml", of(&scene, 16.0 * factor));
        let learned = sandbox.replay("scene.toml", &["--no-report", "--learn", "b.json"]);
        let all = list(&learned["learning"], "parameters");
        let is_clearance = |one: &&Value| one["name"].as_str().is_some_and(|name| name.ends_with("clearance"));
        for one in all.iter().filter(is_clearance) {
            let [low, high] = ["/low", "/high"].map(|end| number(one, end));
            assert!(low < 16.0 && 16.0 < high, "{factor}: {one}");
        }
    }
}

/// A wave that the baseline has not shown, but that a sound bearing may have, is part of the sound machine, and is named.
#[test]
fn a_wave_of_a_sound_bearing_is_no_fault() {
    let sandbox = site();
    let wave = "{ surface = \"outer\", order = 17, amplitude = \"0.12 um\", phase = \"70 deg\" },";
    let wavy = sandbox.read("sound.toml").replacen("waviness = [", &format!("waviness = [{wave}"), 1);
    sandbox.put("wavy.toml", &wavy);
    sandbox.put("recording.csv", readings(&motion(&sandbox, "wavy.toml", 33..33 + TURNS), |_, _, _| 0.0));
    let outcome = outcome(&sandbox);
    assert!(kinds(&outcome).is_empty(), "{:#}", outcome["findings"]);
    let notes = list(&outcome, "notes");
    let named =
        |note: &Value| note.as_str().is_some_and(|note| note.ends_with("waviness of order 17 on outer race of A."));
    assert!(notes.iter().any(named), "{notes:#?}");
}

/// A foot that is loose lets the housing of a bearing move: the support is named with its stiffness, and no bearing.
#[test]
fn a_yielding_support_is_no_fault_of_a_bearing() {
    let sandbox = site();
    let support = |y: &str| {
        format!(
            "name = \"A\"\nsupport = {{ mass = \"2 kg\", stiffness_x = \"8e8 N/m\", stiffness_y = \"{y}\", damping = \"300 N s/m\" }}\n"
        )
    };
    sandbox.put("loose.toml", swap(&sandbox.read("sound.toml"), "name = \"A\"\n", &support("2e7 N/m")));
    sandbox.put("recording.csv", readings(&motion(&sandbox, "loose.toml", 33..33 + TURNS), |_, _, _| 0.0));
    let outcome = outcome(&sandbox);
    let findings = list(&outcome, "findings");
    assert_eq!(kinds(&outcome), ["support"], "{findings:#?}");
    assert_eq!(findings[0]["bearing"], "A", "{findings:#?}");
    let stiffness = &findings[0]["support_stiffness_n_um"];
    let [low, high] = ["/low", "/high"].map(|end| number(stiffness, end));
    assert!(low < 20.0 && 20.0 < high && high < 2.0 * low, "{stiffness}");
}

/// Waves of sound races move a rotor on a light axial load along its axis, where its bearings are soft: without a baseline, their lines beside a large
/// clearance are no damage.
#[test]
fn a_worn_bearing_without_a_baseline_has_no_spall() {
    let sandbox = site();
    let worn = sandbox.read("sound.toml").replacen("clearance = \"10 um\"", "clearance = \"24 um\"", 1);
    sandbox.put("worn.toml", worn);
    sandbox.put("recording.csv", readings(&motion(&sandbox, "worn.toml", 33..33 + TURNS), |_, _, _| 0.0));
    let outcome = sandbox.replay("scene.toml", &["--no-report"]);
    assert!(kinds(&outcome).iter().all(|kind| ["clearance", "other"].contains(kind)), "{:#}", outcome["findings"]);
}

/// The lines of bearings of one kind coincide: a wave is named on the bearing that has it.
#[test]
fn a_wave_is_named_on_its_bearing() {
    let sandbox = site();
    let sound = sandbox.read("sound.toml");
    let wave = "{ surface = \"outer\", order = 9, amplitude = \"0.8 um\", phase = \"70 deg\" },";
    let of_a = sound.replacen("waviness = [", &format!("waviness = [{wave}"), 1);
    let of_b = swap(&sound, "name = \"B\"\n", &format!("name = \"B\"\nwaviness = [{wave}]\n"));
    for (bearing, wavy) in [("A", of_a), ("B", of_b)] {
        sandbox.put("wavy.toml", wavy);
        sandbox.put("recording.csv", readings(&motion(&sandbox, "wavy.toml", 33..33 + TURNS), |_, _, _| 0.0));
        let outcome = outcome(&sandbox);
        let findings = list(&outcome, "findings");
        assert_eq!(kinds(&outcome), ["outer-race"], "{bearing}: {findings:#?}");
        assert_eq!(findings[0]["bearing"], bearing, "{findings:#?}");
        // Normal to the race: 0.8 um along the radius.
        let [low, high] = ["/low", "/high"].map(|end| number(&findings[0]["amplitude_um"], end));
        assert!(low < 0.8 && 0.75 < high && high < 2.0 * low, "{}", findings[0]["amplitude_um"]);
    }
}

/// Tilted rings of the simulated rotor, with their sizes and axes.
#[test]
fn a_tilted_ring_is_found() {
    let sandbox = site();
    for [about_x, about_y] in [[0.6_f64, 0.9_f64], [-1.5, 1.5], [1.25, -2.16]] {
        let tilt = format!("outer_ring_tilt = [\"{about_x} mrad\", \"{about_y} mrad\"]\n");
        sandbox.put("tilted.toml", rotor("angular", &format!("{CAGE}{WAVES}{tilt}"), "Z"));
        sandbox.put("recording.csv", readings(&motion(&sandbox, "tilted.toml", 20..20 + TURNS), |_, _, _| 0.0));
        let outcome = outcome(&sandbox);
        let findings = list(&outcome, "findings");
        assert_eq!(kinds(&outcome), ["misalignment"], "{findings:#?}");
        assert_eq!(findings[0]["bearing"], "A", "{findings:#?}");
        let axis = about_y.atan2(about_x).to_degrees().rem_euclid(360.0);
        for (key, truth) in [("tilt_mrad", about_x.hypot(about_y)), ("axis_deg", axis)] {
            let [low, high] = ["low", "high"].map(|end| number(&findings[0], &format!("/{key}/{end}")));
            assert!((low..=high).contains(&truth), "{key}: {truth} not in {low} to {high}");
        }
    }
}

/// A ring that is tilted by a minute of arc moves the shaft by more than its gaps are known: it is found in the readings that the tilt itself would leave.
/// Recordings of an independent simulator, where they are beside the project.
#[test]
fn a_tilted_ring_is_found_where_the_means_have_moved() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/recordings/site/rig00");
    let Ok(scene) = fs::read_to_string(folder.join("scene-rough.toml")) else { return };
    let sandbox = Sandbox::empty();
    for name in ["healthy", "misaligned", "slow-roll"] {
        let file = format!("{name}.npy.gz");
        sandbox.put(&file, fs::read(folder.join(&file)).unwrap());
        sandbox.put(&format!("{name}.toml"), scene.replace("RECORDING", &file));
    }
    sandbox.done(&["replay", "healthy.toml", "--no-report", "--learn", "b.json"]);
    let outcome = sandbox.replay("misaligned.toml", &["--no-report", "--baseline", "b.json"]);
    let findings = list(&outcome, "findings");
    assert_eq!(kinds(&outcome), ["misalignment"], "{findings:#?}");
    assert_eq!(findings[0]["bearing"], "NDE", "{findings:#?}");
    for (key, truth) in [("tilt_mrad", 1.066), ("axis_deg", 153.3)] {
        let [low, high] = ["low", "high"].map(|end| number(&findings[0], &format!("/{key}/{end}")));
        assert!((low..=high).contains(&truth), "{key}: {truth} not in {low} to {high}");
    }
}
