//! `ballrace balance SCENE`: masses of a rotor with a known unbalance from recordings of it, against the closed form of a rigid rotor on two
//! linear bearings, and wrong runs.

use crate::support::{Sandbox, swap};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Complex number.
#[derive(Clone, Copy)]
struct C(f64, f64);

impl C {
    fn at(size: f64, degrees: f64) -> Self {
        let (s, c) = degrees.to_radians().sin_cos();
        Self(size * c, size * s)
    }
    fn plus(self, b: Self) -> Self {
        Self(self.0 + b.0, self.1 + b.1)
    }
    fn less(self, b: Self) -> Self {
        Self(self.0 - b.0, self.1 - b.1)
    }
    fn times(self, b: Self) -> Self {
        Self(self.0 * b.0 - self.1 * b.1, self.0 * b.1 + self.1 * b.0)
    }
    fn over(self, b: Self) -> Self {
        let square = b.0 * b.0 + b.1 * b.1;
        Self((self.0 * b.0 + self.1 * b.1) / square, (self.1 * b.0 - self.0 * b.1) / square)
    }
    fn size(self) -> f64 {
        self.0.hypot(self.1)
    }
}

const SPEED: f64 = 3000.0 / 60.0 * TAU;
const MASS: f64 = 6.0;
const DIAMETRAL: f64 = 0.03;
const POLAR: f64 = 0.006;
/// Stiffness along X and Y of both bearings, and their stations.
const STIFFNESS: [f64; 2] = [2e7, 3e7];
const BEARINGS: [f64; 2] = [-0.1, 0.1];
const DAMPING: [f64; 2] = [400.0, 0.4];
/// Stations and directions of the probes.
const PROBES: [(f64, bool); 4] = [(-0.12, false), (-0.12, true), (0.12, false), (0.12, true)];

const SCENE: &str = r#"name = "fan"
[shaft]
speed = "3000 rpm"
[rotor]
mass = "6 kg"
diametral_inertia = "0.030 kg m^2"
polar_inertia = "0.006 kg m^2"
damping = ["400 N s/m", "400 N s/m", "400 N s/m", "0.4 N m s/rad", "0.4 N m s/rad"]
unbalance = [{ moment = "40 g mm", angle = "70 deg", station = "20 mm" }, { moment = "15 g mm", angle = "250 deg", station = "-60 mm" }]
[[bearing]]
name = "DE"
station = "-100 mm"
model = "linear"
elements = 8
stiffness_matrix = [[2e7,0,0,0,0],[0,3e7,0,0,0],[0,0,1e7,0,0],[0,0,0,0,0],[0,0,0,0,0]]
[[bearing]]
name = "NDE"
station = "100 mm"
model = "linear"
elements = 8
stiffness_matrix = [[2e7,0,0,0,0],[0,3e7,0,0,0],[0,0,1e7,0,0],[0,0,0,0,0],[0,0,0,0,0]]
[recording]
file = "before.csv"
rate = "12.8 kHz"
probes = [
  { column = "DE_X", unit = "um", station = "-120 mm", angle = "0 deg" },
  { column = "DE_Y", unit = "um", station = "-120 mm", angle = "90 deg" },
  { column = "NDE_X", unit = "um", station = "120 mm", angle = "0 deg" },
  { column = "NDE_Y", unit = "um", station = "120 mm", angle = "90 deg" },
]
keyphasor = { column = "keyphasor", pulses_per_turn = 1 }
"#;

/// The unbalance of the scene: station in m, g mm, degrees.
const OWN: [(f64, f64, f64); 2] = [(0.02, 40.0, 70.0), (-0.06, 15.0, 250.0)];

/// Readings of the probes in um by a moment of 1 g mm at a station: `u v thu thv` of the centre of mass from the equations of
/// Newton and Euler, by elimination.
fn closed_form(station: f64) -> Vec<C> {
    let (i, square) = (C(0.0, 1.0), SPEED * SPEED);
    let real = |x: f64| C(x, 0.0);
    let mut rows = vec![vec![real(0.0); 5]; 4];
    let inertia = [MASS, MASS, DIAMETRAL, DIAMETRAL];
    for k in 0..4 {
        rows[k][k] = real(-square * inertia[k]).plus(i.times(real(SPEED * DAMPING[k / 2])));
    }
    // The tilts are coupled by the spin.
    rows[2][3] = i.times(real(SPEED * SPEED * POLAR));
    rows[3][2] = i.times(real(-SPEED * SPEED * POLAR));
    for z in BEARINGS {
        let [kx, ky] = STIFFNESS;
        // x = u + z thv and y = v - z thu at a bearing; moments are -z Fy and z Fx.
        for (row, column, k) in [(0, 0, kx), (0, 3, z * kx), (3, 0, z * kx), (3, 3, z * z * kx)] {
            rows[row][column] = rows[row][column].plus(real(k));
        }
        for (row, column, k) in [(1, 1, ky), (1, 2, -z * ky), (2, 1, -z * ky), (2, 2, z * z * ky)] {
            rows[row][column] = rows[row][column].plus(real(k));
        }
    }
    // 1 g mm at angle 0: the force turns from X to Y, which is a quarter of a turn later.
    let [fx, fy] = [real(1e-6 * square), C(0.0, -1e-6 * square)];
    let z = real(station);
    for (k, force) in [fx, fy, C(0.0, 0.0).less(z.times(fy)), z.times(fx)].into_iter().enumerate() {
        rows[k][4] = force;
    }
    for k in 0..4 {
        let pivot = rows[k].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(j, _)| *j != k) {
            let factor = row[k].over(pivot[k]);
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x = x.less(factor.times(*p)));
        }
    }
    let q: Vec<C> = (0..4).map(|k| rows[k][4].over(rows[k][k])).collect();
    let reading = |(z, is_y): &(f64, bool)| {
        let moved = if *is_y { q[1].less(real(*z).times(q[2])) } else { q[0].plus(real(*z).times(q[3])) };
        moved.times(real(1e6))
    };
    PROBES.iter().map(reading).collect()
}

/// A recording by the closed form: the own unbalance and further masses, with a run-out of the shaft and noise, um.
fn recording(masses: &[(f64, f64, f64)], run_out: f64, turns: usize) -> String {
    let mut vectors = vec![C(0.0, 0.0); 4];
    for (station, moment, angle) in OWN.iter().chain(masses) {
        for (sum, one) in vectors.iter_mut().zip(closed_form(*station)) {
            *sum = sum.plus(one.times(C::at(*moment, *angle)));
        }
    }
    written(&vectors, run_out, 256, turns)
}

fn written(vectors: &[C], run_out: f64, samples_per_turn: usize, turns: usize) -> String {
    let mut out = "DE_X,DE_Y,NDE_X,NDE_Y,keyphasor\n".to_owned();
    let mut random = 20_261_128_u64;
    for sample in 0..samples_per_turn * turns {
        // The mark passes between two samples.
        let angle = TAU * (sample as f64 - 100.5) / samples_per_turn as f64;
        for (p, C(re, im)) in vectors.iter().enumerate() {
            random = random * 48_271 % 0x7fff_ffff;
            let noise = 2e-4 * (random as f64 / 2_147_483_647.0 - 0.5);
            let own = run_out * (angle + p as f64).cos() + 0.3 * run_out * (2.0 * angle).sin();
            write!(out, "{:.6},", re * angle.cos() - im * angle.sin() + own + noise + 3.0 * p as f64).unwrap();
        }
        let of_turn = angle.rem_euclid(TAU) / TAU;
        writeln!(out, "{}", u8::from(of_turn < 0.05)).unwrap();
    }
    out
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("fan.toml", SCENE);
    sandbox.put("before.csv", recording(&[], 0.0, 40));
    sandbox.put("trial1.csv", recording(&[(-0.06, 20.0, 30.0)], 0.0, 40));
    sandbox.put("trial2.csv", recording(&[(0.02, 20.0, 200.0)], 0.0, 40));
    sandbox
}

const ONE: [&str; 2] = ["--trial", "trial1.csv: -60 mm 20 g mm at 30 deg"];
const TWO: [&str; 2] = ["--trial", "trial2.csv: 20 mm 20 g mm at 200 deg"];
const BEFORE: [&str; 4] = ["balance", "fan.toml", "--run", "before.csv"];

fn json(sandbox: &Sandbox, args: &[&[&str]]) -> Value {
    sandbox.done(&[&args.concat()[..], &["--format", "json"]].concat()).json()
}

/// Checks that the correction is the opposite of the own unbalance within `share` of it and within its interval.
fn assert_corrected(out: &Value, share: f64) {
    for plane in out["correction"]["planes"].as_array().unwrap() {
        let at = |(station, ..): &&(f64, f64, f64)| plane["plane"] == format!("{} mm", station * 1e3);
        let (_, moment, angle) = OWN.iter().find(at).unwrap_or_else(|| panic!("{plane}"));
        let found = C::at(plane["moment_g_mm"].as_f64().unwrap(), plane["angle_deg"].as_f64().unwrap());
        let off = found.plus(C::at(*moment, *angle)).size();
        assert!(off < share * moment, "{plane}: {moment} at {angle}");
        assert!(off < 2.0 * plane["deviation_g_mm"].as_f64().unwrap(), "{plane}: {moment} at {angle}");
    }
}

#[test]
fn coefficients_of_the_twin_are_those_of_the_closed_form() {
    let out = json(&sandbox(), &[&BEFORE]);
    let of_station = [-0.06, 0.02].map(closed_form);
    for (p, row) in out["influence"].as_array().unwrap().iter().enumerate() {
        for (k, expected) in of_station.iter().enumerate() {
            let [size, angle, deviation] = [0, 1, 2].map(|i| row["coefficients"][k][i].as_f64().unwrap());
            let off = C::at(size, angle).less(expected[p]).size();
            assert!(off < 1e-6 * expected[p].size(), "{row}: plane {k}, {off}");
            // 20 % of the stiffness of each bearing.
            assert!((0.03..0.4).contains(&(deviation / size)), "{row}: plane {k}");
        }
    }
    // The masses without a trial.
    assert_corrected(&out, 0.03);
    assert_eq!(out["twin"]["used"], true, "{out}");
    assert!(out["twin"]["misfit"].as_f64().unwrap() < 1.0, "{}", out["twin"]);
}

#[test]
fn masses_from_trials_and_from_one_trial_with_the_twin() {
    let sandbox = sandbox();
    let both = json(&sandbox, &[&BEFORE, &ONE, &TWO]);
    assert_corrected(&both, 0.01);
    let one = json(&sandbox, &[&BEFORE, &ONE, &["--plane", "-60 mm,20 mm"]]);
    assert_corrected(&one, 0.03);
    assert!(one["proof"]["mean_error_g_mm"].as_f64().unwrap() < 3.0, "{}", one["proof"]);
    let alone = json(&sandbox, &[&BEFORE]);
    let widths = [&both, &one, &alone].map(|out| out["correction"]["planes"][0]["deviation_g_mm"].as_f64().unwrap());
    assert!(widths[0] < widths[1] && widths[1] < widths[2], "{widths:?}");
    let text = sandbox.done(&[&BEFORE[..], &ONE, &TWO].concat()).out;
    assert!(text.contains("The coefficients are those of the twin of the scene and of the trials together."), "{text}");
    assert!(text.contains("CORRECTION") && text.contains(" g mm at "), "{text}");
    let table = sandbox.done(&[&BEFORE[..], &ONE, &TWO, &["--format", "csv"]].concat()).out;
    assert!(table.starts_with("plane,moment_g_mm,deviation_g_mm,angle_deg\n'-60 mm,15.0"), "{table}");
}

/// A twin of another machine does not spoil trials that suffice.
#[test]
fn a_wrong_twin_is_not_used() {
    let sandbox = sandbox();
    sandbox.put("fan.toml", SCENE.replace("[2e7,0", "[1e6,0").replace("3e7", "1.5e6"));
    let both = json(&sandbox, &[&BEFORE, &ONE, &TWO]);
    assert_eq!(both["twin"]["used"], false, "{}", both["twin"]);
    assert_corrected(&both, 0.01);
    let text = sandbox.done(&[&BEFORE[..], &ONE, &TWO].concat()).out;
    assert!(text.contains("The trials disagree with the twin of the scene"), "{text}");
    let output = sandbox.run(&[&BEFORE[..], &ONE, &["--plane", "-60 mm,20 mm"]].concat());
    assert_eq!(output.code, Some(2), "{}", output.out);
    assert!(output.err.contains("as far from the coefficients of the twin as"), "{}", output.err);
}

/// The run-out of the shaft, twenty times the vibration, is subtracted by the slow roll of the scene.
#[test]
fn run_out_is_subtracted() {
    let sandbox = sandbox();
    for (name, masses) in
        [("before.csv", &[][..]), ("trial1.csv", &[(-0.06, 20.0, 30.0)]), ("trial2.csv", &[(0.02, 20.0, 200.0)])]
    {
        sandbox.put(name, recording(masses, 2.0, 40));
    }
    sandbox.put("slow.csv", written(&[C(0.0, 0.0); 4], 2.0, 3200, 8));
    sandbox.put("fan.toml", swap(SCENE, "rate = \"12.8 kHz\"", "rate = \"12.8 kHz\"\nrun_out = \"slow.csv\""));
    assert_corrected(&json(&sandbox, &[&BEFORE, &ONE, &TWO]), 0.02);
}

/// The readings of `simulate`, with the noise of the probes, of a rotor on linear bearings and of one on ball bearings with clearance.
#[test]
fn simulated_recordings() {
    let own = "unbalance = [";
    let trial = "unbalance = [{ moment = \"60 g mm\", angle = \"90 deg\", station = \"20 mm\" }, ";
    for scene in [SCENE, crate::support::DEMO_SCENE] {
        let sandbox = Sandbox::empty();
        sandbox.put("fan.toml", scene);
        sandbox.put("trial.toml", swap(scene, own, trial));
        for (file, name) in [("fan.toml", "before.csv"), ("trial.toml", "trial.csv")] {
            let args = ["simulate", file, "--duration", "0.5 s", "--settle", "0.5 s", "--as-recording", "-o", name];
            sandbox.done(&args);
        }
        let args = ["--trial", "trial.csv: 20 mm 60 g mm at 90 deg"];
        let is_fan = scene == SCENE;
        let planes: &[&str] = if is_fan { &["--plane", "-60 mm,20 mm"] } else { &[] };
        for (trials, most) in [(&args[..], 0.03), (&[], if is_fan { 0.05 } else { 0.1 })] {
            let out = json(&sandbox, &[&BEFORE, trials, planes]);
            let planes = out["correction"]["planes"].as_array().unwrap();
            let found = planes.iter().find(|plane| plane["plane"] == "20 mm").unwrap();
            let (moment, angle) = if is_fan { (40.0, 70.0) } else { (120.0, 0.3_f64.to_degrees()) };
            let at = C::at(found["moment_g_mm"].as_f64().unwrap(), found["angle_deg"].as_f64().unwrap());
            let off = at.plus(C::at(moment, angle)).size();
            assert!(off < most * moment, "{found}: {moment} at {angle}");
            assert!(off < 2.0 * found["deviation_g_mm"].as_f64().unwrap(), "{found}: {moment} at {angle}");
        }
    }
}

/// A recording by an independent program: 480 g mm at 1.2 rad on ball bearings with clearance, without a trial.
#[test]
fn recording_of_another_program() {
    let sandbox = Sandbox::empty();
    let [scene, run] = ["unbalanced.toml", "unbalanced.csv"].map(crate::support::recorded);
    let out: Value = sandbox.done(&["balance", &scene, "--run", &run, "--format", "json"]).json();
    let plane = &out["correction"]["planes"][0];
    let found = C::at(plane["moment_g_mm"].as_f64().unwrap(), plane["angle_deg"].as_f64().unwrap());
    assert!(found.plus(C::at(480.0, 1.2_f64.to_degrees())).size() < 0.03 * 480.0, "{plane}");
    assert!(out["twin"]["misfit"].as_f64().unwrap() < 1.0, "{}", out["twin"]);
}

/// Runs at two speeds are used together.
#[test]
fn several_speeds() {
    let sandbox = Sandbox::empty();
    let trial = "unbalance = [{ moment = \"20 g mm\", angle = \"30 deg\", station = \"20 mm\" }, ";
    sandbox.put("fan.toml", SCENE);
    for (speed, names) in [("3000 rpm", ["before.csv", "trial1.csv"]), ("2000 rpm", ["before2.csv", "trial2.csv"])] {
        let at_speed = swap(SCENE, "3000 rpm", speed);
        for (text, name) in [at_speed.clone(), swap(&at_speed, "unbalance = [", trial)].iter().zip(names) {
            sandbox.put("run.toml", text);
            sandbox.done(&[
                "simulate",
                "run.toml",
                "--duration",
                "0.5 s",
                "--settle",
                "0.5 s",
                "--as-recording",
                "-o",
                name,
            ]);
        }
    }
    let trials = ["trial1.csv: 20 mm 20 g mm at 30 deg", "trial2.csv: 20 mm 20 g mm at 30 deg"];
    let args = ["--run", "before2.csv", "--trial", trials[0], "--trial", trials[1], "--plane", "-60 mm,20 mm"];
    let out = json(&sandbox, &[&BEFORE, &args]);
    assert_eq!(out["influence"].as_array().unwrap().len(), 8, "{out}");
    assert_corrected(&out, 0.02);
}

/// Simulates a recording of a scene with its speed and further unbalances replaced.
fn simulated(sandbox: &Sandbox, scene: &str, speed: &str, trial: &str, [duration, name]: [&str; 2]) {
    let moving = swap(scene, "speed = \"3000 rpm\"", &format!("speed = {speed}"));
    sandbox.put("run.toml", swap(&moving, "unbalance = [", &format!("unbalance = [{trial}")));
    sandbox.done(&["simulate", "run.toml", "--duration", duration, "--as-recording", "-o", name]);
}

/// Run-ups through the resonance of a soft rotor: one recording has vectors at several speeds, and a recording at one speed has its own.
#[test]
fn vectors_of_a_run_up() {
    let sandbox = Sandbox::empty();
    let soft = SCENE.replace("[2e7,0", "[4e5,0").replace("3e7", "5e5");
    sandbox.put("fan.toml", &soft);
    let up = "{ from = \"200 rpm\", to = \"5500 rpm\", over = \"8 s\" }";
    let trials = ["-60 mm 20 g mm at 30 deg", "20 mm 20 g mm at 200 deg"];
    let of = ["30 deg\", station = \"-60 mm", "200 deg\", station = \"20 mm"]
        .map(|at| format!("{{ moment = \"20 g mm\", angle = \"{at}\" }}, "));
    simulated(&sandbox, &soft, up, "", ["8 s", "before.csv"]);
    simulated(&sandbox, &soft, up, &of[0], ["8 s", "trial1.csv"]);
    simulated(&sandbox, &soft, up, &of[1], ["8 s", "trial2.csv"]);
    let trial = [format!("trial1.csv: {}", trials[0]), format!("trial2.csv: {}", trials[1])];
    let args = ["--trial", &trial[0], "--trial", &trial[1]];
    let out = json(&sandbox, &[&BEFORE, &args]);
    assert_eq!(out["influence"].as_array().unwrap().len(), 4 * 8, "{out}");
    assert_corrected(&out, 0.03);
    // The speeds are spread over the resonance at 3500 rpm.
    let speeds: Vec<f64> =
        out["influence"].as_array().unwrap().iter().map(|one| one["speed_rpm"].as_f64().unwrap()).collect();
    assert!(speeds[0] < 2000.0 && speeds[31] > 4500.0, "{speeds:?}");
    // A recording at one speed beside the run-ups.
    let own = "\"2500 rpm\"";
    simulated(&sandbox, &soft, own, "", ["1 s", "steady.csv"]);
    let out = json(&sandbox, &[&BEFORE, &["--run", "steady.csv"], &args]);
    let has_own = |one: &Value| (one["speed_rpm"].as_f64().unwrap() - 2500.0).abs() < 1.0;
    assert_eq!(out["influence"].as_array().unwrap().iter().filter(|one| has_own(one)).count(), 4, "{out}");
    assert_corrected(&out, 0.04);
    let fast = "{ from = \"1500 rpm\", to = \"5500 rpm\", over = \"0.25 s\" }";
    simulated(&sandbox, &soft, fast, "", ["0.25 s", "fast.csv"]);
    let output = sandbox.run(&["balance", "fan.toml", "--run", "fast.csv"]);
    assert!(output.err.contains("fast.csv: speed changes by") && output.err.contains("a slower run-up"), "{output:?}");
    let other = "{ from = \"700 rpm\", to = \"1000 rpm\", over = \"8 s\" }";
    simulated(&sandbox, &soft, other, &of[1], ["8 s", "trial2.csv"]);
    let output = sandbox.run(&[&BEFORE[..], &args].concat());
    assert!(output.err.contains("no speed in common with the other run-ups"), "{output:?}");
}

/// A trim run of recordings: the masses of a first correction, mounted 3 g mm too heavy in one plane.
#[test]
fn trim_run_of_recordings() {
    let sandbox = sandbox();
    sandbox.put("trim.csv", recording(&[(-0.06, 15.0, 70.0), (0.02, 37.0, 250.0)], 0.0, 40));
    let trim = ["--trim", "trim.csv: -60 mm 15 g mm at 70 deg, 20 mm 37 g mm at 250 deg"];
    let out = json(&sandbox, &[&BEFORE, &ONE, &TWO, &trim]);
    let plane = &out["correction"]["planes"][1];
    let next = C::at(plane["moment_g_mm"].as_f64().unwrap(), plane["angle_deg"].as_f64().unwrap());
    assert!(next.less(C::at(3.0, 250.0)).size() < 0.5, "{plane}");
    assert!(out["correction"]["planes"][0]["moment_g_mm"].as_f64().unwrap() < 0.5, "{out}");
    let wrong = ["--trim", "trim.csv: -60 mm 15 g mm at 250 deg, 20 mm 37 g mm at 70 deg"];
    let err = sandbox.run(&[&BEFORE[..], &ONE, &TWO, &wrong].concat()).err;
    assert!(err.contains("trim.csv: the vectors agree with the other runs only with the masses half a turn"), "{err}");
    let err = sandbox.run(&[&BEFORE[..], &["--trim", "trim.csv"]].concat()).err;
    assert!(err.contains("--trim: no \": \" in \"trim.csv\""), "{err}");
}

#[test]
fn balance_quality() {
    let sandbox = sandbox();
    let out = json(&sandbox, &[&BEFORE, &ONE, &TWO, &["--grade", "G2.5"]]);
    let quality = &out["quality"];
    let near = |value: &Value, expected: f64, share: f64| {
        assert!((value.as_f64().unwrap() / expected - 1.0).abs() < share, "{value}: {expected}: {quality}");
    };
    // 9549 G m / n, half for each bearing.
    near(&quality["permissible_g_mm"], 9549.3 * 2.5 * 6.0 / 3000.0, 1e-4);
    // Unbalances of the bearing planes by the levers of the two planes.
    let at = |shares: [f64; 2]| C::at(40.0 * shares[0], 70.0).plus(C::at(15.0 * shares[1], 250.0)).size();
    let worst = at([0.6, 0.2]);
    near(&quality["planes"][0]["permissible_g_mm"], 9549.3 * 2.5 * 6.0 / 3000.0 / 2.0, 1e-4);
    near(&quality["planes"][0]["before_g_mm"], at([0.4, 0.8]), 0.1);
    near(&quality["planes"][1]["before_g_mm"], worst, 0.02);
    near(&quality["before"], worst / 3.0 * 1e-6 * SPEED * 1e3, 0.02);
    assert!(quality["after_high"].as_f64().unwrap() < 2.5, "{quality}");
    let text = sandbox.done(&[&BEFORE[..], &ONE, &TWO, &["--grade", "G2.5"]].concat()).out;
    assert!(text.contains("BALANCE QUALITY by ISO 21940-11") && text.contains("within G 2.5."), "{text}");
    // A table has no mass, and its planes are those of the tolerance.
    sandbox.put("vectors.csv", include_str!("../../docs/src/vectors.csv"));
    let table = ["balance", "--vectors", "vectors.csv", "--grade", "G6.3"];
    let output = sandbox.run(&table);
    assert!(output.code == Some(2) && output.err.contains("--mass: missing"), "{output:?}");
    let table = json(&sandbox, &[&table, &["--mass", "12 kg", "--service-speed", "1500 rpm"]]);
    near(&table["quality"]["permissible_g_mm"], 9549.3 * 6.3 * 12.0 / 1500.0, 1e-4);
}

/// Full holes pass the rest on, drilled holes lie opposite, and the page has a plot of each probe.
#[test]
fn holes_and_report() {
    let sandbox = sandbox();
    let holes = ["--holes", "12", "--radius", "30 mm", "--hole-limit", "0.5 g", "--remove", "--report", "balance.html"];
    let out = json(&sandbox, &[&BEFORE, &ONE, &TWO, &holes]);
    let planes = out["correction"]["planes"].as_array().unwrap();
    for plane in planes {
        let masses = plane["holes"].as_array().unwrap();
        let of = |mass: &Value| {
            let grams = mass["mass_g"].as_f64().unwrap();
            assert!(grams <= 0.5 + 1e-9, "{plane}");
            C::at(30.0 * grams, mass["angle_deg"].as_f64().unwrap() + 180.0)
        };
        let sum = masses.iter().map(of).fold(C(0.0, 0.0), C::plus);
        let moment = C::at(plane["moment_g_mm"].as_f64().unwrap(), plane["angle_deg"].as_f64().unwrap());
        assert!(sum.less(moment).size() < 1e-6 * moment.size(), "{plane}");
    }
    assert!(planes[1]["holes"].as_array().unwrap().len() > 2, "{}", planes[1]);
    let page = sandbox.read("balance.html");
    assert!(page.contains("NDE_Y at 3000 rpm") && page.contains("Moment to remove"), "{page}");
    let text = sandbox.done(&[&BEFORE[..], &ONE, &TWO, &holes].concat()).out;
    assert!(
        text.contains("remove") && text.contains(" from hole ") && text.contains("Written: balance.html"),
        "{text}"
    );
    let output =
        sandbox.run(&[&BEFORE[..], &["--holes", "12", "--radius", "30 mm", "--stock", "1 g", "--remove"]].concat());
    assert_eq!(output.code, Some(2), "{output:?}");
}

#[test]
fn wrong_runs_have_one_clear_error() {
    let sandbox = sandbox();
    let error = |args: &[&[&str]]| {
        let output = sandbox.run(&args.concat());
        assert!(matches!(output.code, Some(1 | 2)), "{}{}", output.out, output.err);
        output.err
    };
    let swapped = |name: &str| {
        let text = sandbox.read(name);
        sandbox.put(&format!("swapped-{name}"), swap(&text, "DE_X,DE_Y", "DE_Y,DE_X"));
    };
    let in_mil = |name: &str, new: &str| {
        let converted = |line: &str| -> String {
            let cells = line.split(',').enumerate().map(|(column, cell)| match cell.parse::<f64>() {
                Ok(um) if column < 4 => format!("{}", um / 25.4),
                _ => cell.to_owned(),
            });
            cells.collect::<Vec<_>>().join(",") + "\n"
        };
        sandbox.put(new, sandbox.read(name).lines().map(converted).collect::<String>());
    };
    in_mil("trial1.csv", "mil.csv");
    swapped("before.csv");
    swapped("trial1.csv");
    sandbox.put("short.csv", recording(&[], 0.0, 3));
    sandbox.put("same.csv", recording(&[], 0.0, 40));
    let slower = closed_form(0.02);
    sandbox.put("slower.csv", written(&slower, 0.0, 300, 40));
    let with = |trial: &'static str| [&BEFORE[..], &["--trial", trial]].concat();
    let planes = ["--plane", "-60 mm,20 mm"];
    for (args, message) in [
        (with("trial1.csv"), "--trial: no \": \" in \"trial1.csv\", expected FILE: PLANE MOMENT at ANGLE"),
        (with("trial1.csv: DE 20 g mm"), "expected PLANE MOMENT at ANGLE, such as \"DE 5 g mm at 30 deg\""),
        (with("trial1.csv: DE 20 at 30 deg"), "\"20\" (has no unit), expected"),
        (with("trial1.csv: DE 20 g at 30 deg"), "expected"),
        (with("trial1.csv: DE 20 g mm at 30"), "\"30\" (has no unit), expected an angle"),
        (
            with("trial1.csv: fan 20 g mm at 30 deg"),
            "unknown plane: \"fan\", expected a bearing (DE, NDE) or a station",
        ),
        (with("nothing.csv: DE 20 g mm at 30 deg"), "nothing.csv"),
        (with("before.csv: DE 20 g mm at 30 deg"), "before.csv stands twice, expected a recording of its own"),
        (with("short.csv: DE 20 g mm at 30 deg"), "short.csv: no 1X vector, expected at least 5 turns"),
        (
            with("slower.csv: DE 20 g mm at 30 deg"),
            "slower.csv: 2560.0 rpm, expected a speed of the runs without masses: 3000.0 rpm",
        ),
        (with("same.csv: 20 mm 20 g mm at 30 deg"), "change no probe by more than its scatter"),
        (
            [&with("trial1.csv: 20 mm 20 g mm at 30 deg")[..], &planes].concat(),
            "planes -60 mm and 20 mm look exchanged",
        ),
        (
            [&with("same.csv: 20 mm 20 g mm at 30 deg")[..], &planes].concat(),
            "same.csv: the vectors agree with the twin only with no mass mounted, expected the masses that are mounted, or a scene",
        ),
        (
            [&with("trial1.csv: DE 20 g mm at 30 deg")[..], &planes].concat(),
            "mass in plane DE, expected one of the planes -60 mm, 20 mm",
        ),
        (
            [&with("swapped-trial1.csv: -60 mm 20 g mm at 30 deg")[..], &planes].concat(),
            "swapped-trial1.csv: the vectors agree with the twin only with probes DE_X and DE_Y exchanged",
        ),
        (
            [&with("trial1.csv: -60 mm 20 g mm at 210 deg")[..], &planes].concat(),
            "trial1.csv: the vectors agree with the twin only with the masses half a turn from the stated angles",
        ),
        (
            [&with("trial1.csv: -60 mm 2 g mm at 30 deg")[..], &planes].concat(),
            "trial1.csv: the vectors agree with the twin only with the masses in g cm",
        ),
        (
            [&with("mil.csv: -60 mm 20 g mm at 30 deg")[..], &planes].concat(),
            "mil.csv: the vectors agree with the twin only with vectors in mil in place of um",
        ),
        (["balance", "fan.toml", "--run", "swapped-before.csv"].to_vec(), "probes DE_X and DE_Y look exchanged"),
        (["balance", "fan.toml"].to_vec(), "--run"),
        (["balance", "--run", "before.csv"].to_vec(), "<SCENE>"),
        ([&BEFORE[..], &["--vectors", "vectors.csv"]].concat(), "cannot be used with"),
        ([&BEFORE[..], &["--grade", "2.5"]].concat(), "expected a grade of ISO 21940-11, such as G2.5"),
    ] {
        let err = error(&[&args]);
        assert!(err.contains(message), "{args:?}: {message}: {err}");
    }
    // Angles counted against the rotation.
    let mirrored =
        ["--trial", "trial1.csv: -60 mm 20 g mm at 330 deg", "--trial", "trial2.csv: 20 mm 20 g mm at 160 deg"];
    assert!(error(&[&BEFORE, &mirrored]).contains("the vectors turn against the masses"));
    // Without a mark on the shaft no angle compares.
    let marked = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    sandbox.put("fan.toml", swap(SCENE, marked, ""));
    assert!(error(&[&BEFORE]).contains("fan.toml: recording: no mark on the shaft"));
}

/// The twin alone hardly knows the stiffness of a lightly loaded bearing with clearance: the masses are not recommended without a trial.
#[test]
fn masses_that_are_hardly_known_ask_for_a_trial() {
    let sandbox = Sandbox::rig();
    let text = sandbox.done(&["balance", "scene.toml", "--run", "healthy.csv"]).out;
    assert!(text.contains("known to no better than half of itself: make a trial"), "{text}");
    // The reason: 5 um more clearance in one of two bearings that share an axial load.
    let coefficient = |scene: &str| {
        let sandbox = Sandbox::with(scene, crate::support::HEALTHY_RECORDING);
        // A further plane, so that a scene that does not explain the vectors is no error.
        let out = json(&sandbox, &[&["balance", "scene.toml", "--run", "healthy.csv", "--plane", "20 mm,-60 mm"]]);
        out["influence"][0]["coefficients"][0][0].as_f64().unwrap()
    };
    let [from, to] = ["diametral_clearance = \"10 um\"", "diametral_clearance = \"15 um\""];
    let ratio =
        coefficient(&crate::support::DEMO_SCENE.replacen(from, to, 1)) / coefficient(crate::support::DEMO_SCENE);
    assert!((3.0..8.0).contains(&ratio), "{ratio}");
}

/// The report of a machine with an unbalance ends with the mass to add: with it the vibration falls to a twentieth.
#[test]
fn a_replay_of_an_unbalanced_machine_ends_with_the_masses_to_add() {
    let sandbox = Sandbox::empty();
    let demo = crate::support::DEMO_SCENE;
    sandbox.put("scene.toml", demo);
    let replayed = |masses: &str, name: &str| -> Value {
        sandbox.put("run.toml", swap(demo, "unbalance = [", &format!("unbalance = [{masses}")));
        let args = ["simulate", "run.toml", "--duration", "0.6 s", "--settle", "0.4 s", "--as-recording", "-o", name];
        sandbox.done(&args);
        let output = sandbox.run(&["replay", "scene.toml", "--recording", name, "--format", "json"]);
        output.json()
    };
    let of = |moment: f64, angle: f64, station: f64| {
        format!("{{ moment = \"{moment} g mm\", angle = \"{angle} deg\", station = \"{station} mm\" }}, ")
    };
    let unbalance = of(500.0, 40.0, 20.0);
    let before = replayed(&unbalance, "before.csv");
    let found = &before["findings"][0];
    let sentence = found["sentence"].as_str().unwrap();
    let (place, _) = sentence.split_once(" there balance it").unwrap_or_else(|| panic!("{sentence}"));
    let masses = place.rsplit_once("; ").unwrap().1;
    let numbers: Vec<f64> = masses.split(' ').filter_map(|word| word.parse().ok()).collect();
    let added = of(numbers[0], numbers[1], found["station_mm"]["value"].as_f64().unwrap());
    let after = replayed(&(unbalance + &added), "after.csv");
    let largest = |outcome: &Value| {
        let probes = outcome["probes"].as_array().unwrap().iter();
        let of = |probe: &Value| probe["measured"]["one_x_um"].as_f64().unwrap();
        probes.filter(|probe| probe["name"] != "axial_um").map(of).fold(0.0, f64::max)
    };
    assert!(largest(&before) > 0.4 && largest(&after) < 0.05 * largest(&before), "{sentence}: {}", largest(&after));
}

/// Vectors that the twin's unbalance does not explain, without a trial, are not taken for vectors in a larger unit, in which nothing of them is seen: the
/// mass is as uncertain as it is.
#[test]
fn vectors_that_the_twin_does_not_explain_are_in_no_other_unit() {
    let sandbox = Sandbox::with(crate::support::DEMO_SCENE, "");
    let unbalanced = crate::support::recorded("unbalanced.csv");
    let out = sandbox.done(&["balance", "scene.toml", "--run", &unbalanced]).out;
    let says = ["does not explain the vectors", "known to no better than half of itself: make a trial"];
    assert!(says.iter().all(|says| out.contains(says)), "{out}");
}
