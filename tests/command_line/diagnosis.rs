//! The diagnosis of the release binary: nothing on a machine in good order, cause, place and size of a spall. The scene to
//! diagnose has neither cage slip nor cage angle nor the spall.

use crate::frames_source::signal;
use crate::observer::{TURN, motion, recording, rotor};
use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, changed, list, number, recorded, short_recording, swap};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;
use std::time::Duration;

/// Cages of A and B: 0.8 % and 1.5 % slower than pure rolling, at angles that the scene to diagnose does not state.
const CAGES: [&str; 2] = [
    "cage_ratio = 0.37739\nfirst_element_azimuth = \"17 deg\"\n",
    "cage_ratio = 0.37472\nfirst_element_azimuth = \"-31 deg\"\n",
];
/// Turns of a recording, enough for every finding here.
const TURNS: usize = 28;
const AZIMUTH: f64 = -70.0;
const DEPTH: f64 = 3.0;

/// `scene.toml` and a recording of `turns` of the rotor with slipping cages; `defect` is a line of bearing A.
fn sandbox(defect: &str, turns: usize) -> Sandbox {
    let sandbox = Sandbox::empty();
    let generating = rotor("angular", &format!("{}{defect}", CAGES[0]), "Z");
    let of_b = format!("name = \"B\"\n{}", CAGES[1]);
    sandbox.put("generating.toml", swap(&generating, "name = \"B\"\n", &of_b));
    sandbox.put("scene.toml", rotor("angular", "", "Z"));
    sandbox.put("recording.csv", recording(&motion(&sandbox, "generating.toml", 20..20 + turns), TURN));
    sandbox
}

/// The diagnoses on these turns, and the HTML report.
fn diagnoses(defect: &str) -> (Vec<Value>, String) {
    let sandbox = sandbox(defect, TURNS);
    let diagnoses = list(&sandbox.replay("scene.toml", &["--report", "report.html"]), "findings").to_vec();
    (diagnoses, sandbox.read("report.html"))
}

/// A spall on the outer race.
fn spall() -> String {
    format!(
        "defect = [{{ surface = \"outer\", azimuth = \"{AZIMUTH} deg\", half_width = \"2.5 deg\", depth = \"{DEPTH} um\", shape = \"half-sine\" }}]\n"
    )
}

#[test]
fn a_machine_in_good_order_with_slipping_cages_has_no_diagnosis() {
    let (diagnoses, report) = diagnoses("");
    assert!(diagnoses.is_empty(), "{diagnoses:#?}");
    assert!(!report.contains("<h2>Diagnosis</h2>"));
}

#[test]
fn a_spall_on_the_outer_race_is_named_with_bearing_azimuth_and_depth() {
    let (diagnoses, report) = diagnoses(&spall());
    let [diagnosis] = &diagnoses[..] else { panic!("expected one diagnosis: {diagnoses:#?}") };
    assert_eq!(
        (&diagnosis["kind"], &diagnosis["bearing"], &diagnosis["form"]),
        (&"outer-race".into(), &"A".into(), &"spall".into())
    );
    let error = |azimuth: f64| ((azimuth - AZIMUTH + 180.0).rem_euclid(360.0) - 180.0).abs();
    let azimuth = number(diagnosis, "/azimuth_deg/value");
    assert!(error(azimuth) < 3.0, "{azimuth}: {diagnosis:#}");
    let depth = number(diagnosis, "/depth_um/value");
    assert!((depth / DEPTH - 1.0).abs() < 0.25, "{depth}: {diagnosis:#}");
    // The force rose points at the spall.
    let direction = number(diagnosis, "/force_direction_deg");
    assert!(error(direction) < 5.0, "{direction}: {diagnosis:#}");
    assert!(number(diagnosis, "/force_n") > 0.0, "{diagnosis:#}");
    let place = format!("Bearing A: Spall on the outer race at {azimuth:.0} deg");
    for figure in ["<h2>Diagnosis</h2>", &place, "Unexplained force at A", "with and without the fault"] {
        assert!(report.contains(figure), "{figure} is not in the report");
    }
    assert!(report.len() < 3_000_000, "{}", report.len());
    // The figures of one probe and those of all agree, and have a name of their own beside the residual of the twin.
    let unexplained = &diagnosis["unexplained_motion"];
    let [without, with, noise] = ["without_um", "with_um", "noise_um"].map(|key| unexplained[key].as_f64().unwrap());
    assert!(with < 0.2 * without && noise < 0.2 * without, "{unexplained}");
    let (here, everywhere) = (unexplained["explained"].as_f64().unwrap(), number(diagnosis, "/explained"));
    assert!(here > 0.95 && (here - everywhere).abs() < 0.05, "{here} at the probe, {everywhere} in all");
    let note = format!("Unexplained motion at {} over all samples", unexplained["probe"].as_str().unwrap());
    assert!(report.contains(&note) && !report.contains("twin with the fault"), "{note}");
}

/// The unbalance moves the rotor axially by 1.4 um, which no probe measures.
#[test]
fn axial_motion_that_is_not_measured_is_no_fault() {
    let sandbox = sandbox("", 40);
    let changed = |scene: &str| {
        let heavier = swap(&sandbox.read(scene), "moment = \"200 g mm\"", "moment = \"1200 g mm\"");
        swap(&heavier, "load = [0, 0, 100, 0, 0]", "load = [0, 0, 60, 0, 0]")
    };
    sandbox.put("generating.toml", changed("generating.toml"));
    sandbox.put("recording.csv", recording(&motion(&sandbox, "generating.toml", 20..60), TURN));
    let axial = "{ column = \"Z\", unit = \"um\", axial = true, noise = \"0.03 um\" }";
    sandbox.put("scene.toml", swap(&changed("scene.toml"), axial, ""));
    let outcome = sandbox.replay("scene.toml", &[]);
    assert!(list(&outcome, "findings").is_empty(), "{outcome:#}");
    assert!(number(&outcome, "/diagnosis/chi_square_before") < 1.5, "{outcome:#}");
}

/// A spall moves two preloaded bearings axially, near their axial natural frequency, and no probe measures it.
#[test]
fn a_spall_of_preloaded_bearings_without_an_axial_probe_is_one_fault() {
    let scene = crate::repeatability::loose(["7208A5", "7208A5"], "");
    let preloaded = |station: &str, facing: &str| {
        format!("station = \"{station} mm\"\nfacing = \"{facing}\"\npreload = {{ force = \"200 N\" }}\n")
    };
    let scene = swap(&scene, "station = \"-150 mm\"\n", &preloaded("-150", "+z"));
    let scene = swap(&scene, "station = \"180 mm\"\n", &preloaded("180", "-z"));
    let spall = "defect = [{ surface = \"inner\", azimuth = \"70 deg\", half_width = \"2.5 deg\", depth = \"4 um\", shape = \"half-sine\" }]\n";
    let outcome =
        crate::repeatability::outcome(&swap(&scene, "name = \"DE\"\n", &format!("name = \"DE\"\n{spall}")), &scene);
    let [diagnosis] = list(&outcome, "findings") else { panic!("expected one diagnosis: {}", outcome["findings"]) };
    assert_eq!(
        [&diagnosis["kind"], &diagnosis["bearing"], &diagnosis["form"]],
        [&Value::from("inner-race"), &"DE".into(), &"spall".into()]
    );
    let (azimuth, depth) = (number(diagnosis, "/azimuth_deg/value"), number(diagnosis, "/depth_um/value"));
    assert!((azimuth - 70.0).abs() < 3.0 && (depth / 4.0 - 1.0).abs() < 0.25, "{azimuth} deg, {depth} um");
    assert!(number(diagnosis, "/explained") > 0.98, "{diagnosis}");
}

/// A wave that the scene has is no fault, and is not taken for the one that is.
#[test]
fn a_wave_beside_one_of_the_scene_has_its_own_size() {
    let wave = |order: i32, amplitude: f64| {
        format!("{{ surface = \"outer\", order = {order}, amplitude = \"{amplitude} um\", phase = \"40 deg\" }}")
    };
    let sandbox = sandbox(&format!("waviness = [{}, {}]\n", wave(9, 0.1), wave(16, 0.4)), TURNS);
    sandbox.put("scene.toml", rotor("angular", &format!("waviness = [{}]\n", wave(9, 0.1)), "Z"));
    let outcome = sandbox.replay("scene.toml", &[]);
    let [diagnosis] = list(&outcome, "findings") else { panic!("expected one diagnosis: {outcome:#}") };
    assert_eq!((&diagnosis["form"], &diagnosis["waviness_order"]), (&"waviness".into(), &16.into()), "{diagnosis:#}");
    // Normal to the race: the free contact angle of 10 um clearance is 9.7 deg.
    let amplitude = number(diagnosis, "/amplitude_um/value");
    assert!((amplitude / (0.4 * 0.986) - 1.0).abs() < 0.02, "{diagnosis:#}");
}

/// 9 waves on the inner race have the line of 15 on the outer race, for a cage 1 % slower, and the load hides the ball pass.
#[test]
fn waves_whose_lines_coincide_are_not_decided() {
    let (diagnoses, _) =
        diagnoses("waviness = [{ surface = \"inner\", order = 9, amplitude = \"0.3 um\", phase = \"40 deg\" }]\n");
    let [diagnosis] = &diagnoses[..] else { panic!("expected one diagnosis: {diagnoses:#?}") };
    assert_eq!((&diagnosis["kind"], &diagnosis["bearing"]), (&"other".into(), &"A".into()), "{diagnosis:#}");
    let sentence = diagnosis["sentence"].as_str().unwrap();
    for cause in ["waviness of order 9 on inner race of A", "waviness of order 15 on outer race of A", "Not decided: "]
    {
        assert!(sentence.contains(cause), "{sentence}");
    }
    let odds = number(diagnosis, "/odds_to_next");
    assert!((1.0..19.0).contains(&odds), "{odds}");
    assert!(diagnosis.get("amplitude_um").is_none() && !list(diagnosis, "lines").is_empty(), "{diagnosis:#}");
}

/// A wave of the balls has one line, which is no ball pass of another number of balls.
#[test]
fn waves_of_the_balls_are_plausible() {
    let (diagnoses, _) = diagnoses("waviness = [{ surface = \"ball\", order = 2, amplitude = \"0.4 um\" }]\n");
    let [diagnosis] = &diagnoses[..] else { panic!("expected one diagnosis: {diagnoses:#?}") };
    assert_eq!(
        [&diagnosis["kind"], &diagnosis["bearing"], &diagnosis["form"], &diagnosis["waviness_order"]],
        [&"element".into(), &"A".into(), &"waviness".into(), &Value::from(2)],
        "{diagnosis:#}"
    );
}

/// Both bearings are damaged: the cages that the healthy machine shows are wrong at first.
#[test]
fn spalls_on_both_outer_races_are_named() {
    let sandbox = sandbox(&spall(), TURNS);
    let of_b = spall().replace(&format!("azimuth = \"{AZIMUTH} deg\""), "azimuth = \"60 deg\"");
    sandbox.put("generating.toml", swap(&sandbox.read("generating.toml"), CAGES[1], &format!("{}{of_b}", CAGES[1])));
    sandbox.put("recording.csv", recording(&motion(&sandbox, "generating.toml", 20..20 + TURNS), TURN));
    let outcome = sandbox.replay("scene.toml", &[]);
    let mut named: Vec<(&str, &str, f64)> = list(&outcome, "findings")
        .iter()
        .map(|of| (of["bearing"].as_str().unwrap(), of["kind"].as_str().unwrap(), number(of, "/azimuth_deg/value")))
        .collect();
    named.sort_by(|a, b| a.0.cmp(b.0));
    let [("A", "outer-race", of_a), ("B", "outer-race", of_b)] = named[..] else { panic!("{named:?}") };
    let error = |azimuth: f64, truth: f64| ((azimuth - truth + 180.0).rem_euclid(360.0) - 180.0).abs();
    assert!(error(of_a, AZIMUTH) < 3.0 && error(of_b, 60.0) < 3.0, "{named:?}");
}

/// Deviations of the calibrated parameters in a baseline.
fn deviations(sandbox: &Sandbox, baseline: &str) -> Vec<f64> {
    let baseline: Value = serde_json::from_str(&sandbox.read(baseline)).unwrap();
    list(&baseline["calibration"], "parameters").iter().map(|p| number(p, "/deviation")).collect()
}

#[test]
fn a_further_recording_refines_the_calibration_of_a_baseline() {
    let sandbox = sandbox("", TURNS);
    sandbox.done(&["replay", "scene.toml", "--learn", "first.json"]);
    sandbox.done(&["replay", "scene.toml", "--baseline", "first.json", "--learn", "second.json"]);
    let (first, second) = (deviations(&sandbox, "first.json"), deviations(&sandbox, "second.json"));
    assert!(first.len() == 10 && first.len() == second.len());
    // Two recordings of the same content halve the variance; the damping, which they determine to 17 %, stays that of the scene.
    let ratios: Vec<f64> = first.iter().zip(&second).map(|(first, second)| second / first).collect();
    let expected = |i: usize| if i == 4 || i == 5 { 1.0 } else { 0.5_f64.sqrt() };
    assert!(ratios.iter().enumerate().all(|(i, ratio)| (ratio - expected(i)).abs() < 0.05), "{ratios:?}");
    let outcome = sandbox.replay("scene.toml", &["--baseline", "second.json"]);
    assert!(list(&outcome, "findings").is_empty(), "{outcome:#}");
}

/// Clearances a quarter larger than those of the machine, with which no ball touches its race, and another modulus and damping.
#[test]
fn a_rough_scene_is_calibrated() {
    let sandbox = sandbox("", TURNS);
    let rough = sandbox
        .read("scene.toml")
        .replace("diametral_clearance = \"10 um\"", "diametral_clearance = \"12.5 um\"\nyoungs_modulus = \"190 GPa\"")
        .replace("damping = [800, 800, 800, 2, 2]", "damping = [560, 560, 560, 1.4, 1.4]");
    sandbox.put("rough.toml", rough);
    sandbox.done(&["replay", "rough.toml", "--learn", "baseline.json"]);
    let baseline: Value = serde_json::from_str(&sandbox.read("baseline.json")).unwrap();
    let calibration = &baseline["calibration"];
    assert!(number(calibration, "/chi_square_per_value") < 1.1, "{calibration:#}");
    let truth = [("diametral_clearance", 10e-6), ("youngs_modulus", 206e9), ("translation_damping", 800.0)];
    let error = |p: &Value| {
        let (_, truth) = truth.iter().find(|(name, _)| p["name"] == *name)?;
        Some((number(p, "/value") - truth) / number(p, "/deviation"))
    };
    let errors: Vec<f64> = list(calibration, "parameters").iter().filter_map(error).collect();
    assert!(errors.len() == 5 && errors.iter().all(|e| e.abs() < 4.0), "{errors:?} {calibration:#}");
}

/// 6 s at 3000 rpm from a source that then is silent, ended by the event, however long the diagnosis takes.
#[test]
fn a_spall_is_reported_while_the_monitor_runs() {
    let sandbox = sandbox(&spall(), 300);
    let mut monitor = sandbox
        .command(
            &[
                &["replay", "scene.toml", "--paced", "--source", "-", "--events", "events.jsonl"][..],
                &["--format", "json"],
            ]
            .concat(),
        )
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut source = monitor.stdin.take().unwrap();
    source.write_all(sandbox.read("recording.csv").as_bytes()).unwrap();
    let found = loop {
        let log = std::fs::read_to_string(sandbox.path("events.jsonl")).unwrap_or_default();
        let whole = log.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        let mut events = whole.map(|line| serde_json::from_str::<Value>(line).unwrap());
        if let Some(found) = events.find(|event| event["kind"] == "fault-found") {
            break found;
        }
        assert!(monitor.try_wait().unwrap().is_none(), "no fault was found: {log}");
        std::thread::sleep(Duration::from_millis(100));
    };
    assert!(found["sentence"].as_str().unwrap().starts_with("Outer race of A: a spall"), "{found:#}");
    // The report of a monitor that is stopped has its last diagnosis. Its source does not end before it.
    signal(&monitor, "TERM");
    let report: Value = serde_json::from_slice(&monitor.wait_with_output().unwrap().stdout).unwrap();
    drop(source);
    assert!(
        list(&report, "findings")[0]["sentence"].as_str().unwrap().starts_with("Outer race of A: a spall"),
        "{report:#}"
    );
    let says = |note: &Value| note.as_str().unwrap().ends_with("the last before the stop.");
    assert!(list(&report, "notes").iter().any(says), "{report:#}");
}

/// Ten revolutions are too few, and the note gives their number.
#[test]
fn a_short_recording_is_not_diagnosed() {
    let text = short_recording(2560);
    let outcome = Sandbox::with(DEMO_SCENE, &text).replay("scene.toml", &[]);
    let notes = list(&outcome, "notes");
    let said = |note: &Value| {
        note.as_str().unwrap().starts_with("The shaft motion is not diagnosed: 10.0 revolutions in a row")
    };
    assert!(notes.iter().any(said), "{notes:#?}");
}

/// A force that turns backward at 2.37 times the shaft speed at one end is no fault of a bearing or of the rotor.
#[test]
fn an_unexplained_line_has_order_bearing_precession_and_frame() {
    const ORDER: f64 = 2.37;
    let recording = changed(20 * TURN, |i, column, value| {
        let angle = std::f64::consts::TAU * ORDER * i as f64 / TURN as f64;
        match column {
            1 => value + 0.5 * angle.cos(),
            2 => value - 0.5 * angle.sin(),
            _ => value,
        }
    });
    let sandbox = Sandbox::with(DEMO_SCENE, &recording);
    let outcome = sandbox.replay("scene.toml", &[]);
    let [diagnosis] = list(&outcome, "findings") else { panic!("expected one diagnosis: {outcome:#}") };
    assert_eq!(diagnosis["kind"], "other", "{diagnosis:#}");
    let lines = list(diagnosis, "lines");
    assert_eq!(lines.len(), 5, "{diagnosis:#}");
    let strongest = &lines[0];
    assert!((number(strongest, "/order") - ORDER).abs() < 0.05, "{diagnosis:#}");
    assert!((number(strongest, "/line_hz") - 50.0 * ORDER).abs() < 2.5, "{diagnosis:#}");
    assert_eq!(
        (&strongest["bearing"], &strongest["precession"], &strongest["frame"]),
        (&"DE".into(), &"backward".into(), &"fixed".into()),
        "{diagnosis:#}"
    );
    assert!(number(strongest, "/force_n") > 1.0, "{diagnosis:#}");
}

/// A machine in good order whose probes are far quieter than the instants of its marks, known to a sample only: at speeds that divide the rate
/// and that do not, and with a rotor that rattles.
#[test]
fn the_instant_of_a_mark_is_no_fault() {
    for (moment, load, speed) in [("3000", "-3000", "3000"), ("6000", "0", "2987"), ("1000", "-3000", "2987")] {
        let swaps = [
            ("120 g mm", format!("{moment} g mm")),
            ("load = [\"0 N\", \"0 N\"", format!("load = [\"0 N\", \"{load} N\"")),
            ("speed = \"3000 rpm\"", format!("speed = \"{speed} rpm\"")),
        ];
        let scene = swaps.iter().fold(DEMO_SCENE.to_owned(), |text, (from, to)| swap(&text, from, to));
        let sandbox = Sandbox::with(&scene.replace("noise = \"0.03 um\"", "noise = \"0.002 um\""), HEALTHY_RECORDING);
        assert!(sandbox.read("scene.toml").contains("0.002 um"));
        let outcome = replay_of_simulation(&sandbox);
        let findings = &outcome["findings"];
        assert_eq!(list(&outcome, "findings").len(), 0, "{moment} g mm, {load} N, {speed} rpm: {findings:#}");
    }
}

/// Replays a simulated recording of the sandbox's scene.
fn replay_of_simulation(sandbox: &Sandbox) -> Value {
    let recorded = ["--settle", "0.5 s", "--duration", "0.5 s", "--as-recording", "-o", "sound.csv"];
    sandbox.done(&[&["simulate", "scene.toml"], &recorded[..]].concat());
    sandbox.done(&["replay", "scene.toml", "--recording", "sound.csv", "--format", "json"]).json()
}

/// A simulated recording of the machine in good order without noise, and a scene that states none: what remains is the integration, no fault. A
/// fault is found without a stated noise too.
#[test]
fn a_recording_without_noise_is_sound() {
    let silent = DEMO_SCENE.replace(", noise = \"0.03 um\"", "");
    let sandbox = Sandbox::with(&silent, HEALTHY_RECORDING);
    let sound = replay_of_simulation(&sandbox);
    assert_eq!(list(&sound, "findings").len(), 0, "{:#}", sound["findings"]);
    assert!(sound["verdict"].as_str().unwrap().starts_with("The twin follows the machine"), "{}", sound["verdict"]);
    let spall = recorded("outer-spall.csv");
    let found: Value = sandbox.done(&["replay", "scene.toml", "--recording", &spall, "--format", "json"]).json();
    assert_eq!(found["findings"][0]["kind"], "outer-race", "{:#}", found["findings"]);
}
