//! `ballrace simulate`: what it writes, where it starts, and that it is the same twin as that of `replay`.

use std::f64::consts::TAU;

use serde_json::Value;

use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, list, number, numbers, recorded, scene, swap};

/// Turns of the demonstration's shaft a second.
const SPEED: f64 = 50.0;
const RATE: f64 = 12_800.0;

/// Columns of the displacement, of its rate, and of the forces of the two bearings.
const POSE: usize = 1;
const VELOCITY: usize = 6;
const FORCES: usize = 11;

/// Header and rows of a simulation at [`RATE`].
fn simulated(sandbox: &Sandbox, duration: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    sandbox.done(&["simulate", "scene.toml", "--duration", duration, "--rate", "12.8 kHz", "-o", "motion.csv"]);
    numbers(&sandbox.read("motion.csv"))
}

#[test]
fn header_and_rows() {
    let sandbox = Sandbox::rig();
    let (header, rows) = simulated(&sandbox, "20 ms");
    let pose = "t,u,v,w,thu,thv,u_dot,v_dot,w_dot,thu_dot,thv_dot";
    let forces = "DE_FX,DE_FY,DE_FZ,DE_MX,DE_MY,NDE_FX,NDE_FY,NDE_FZ,NDE_MX,NDE_MY";
    assert_eq!(header.join(","), format!("{pose},{forces}"));
    assert_eq!(rows.len(), 256);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row.len(), header.len());
        assert!((row[0] - i as f64 / RATE).abs() < 1e-9 && row.iter().all(|x| x.is_finite()), "{row:?}");
    }
    assert_eq!(sandbox.files(), ["healthy.csv", "motion.csv", "scene.toml"]);
}

#[test]
fn starts_from_static_equilibrium() {
    let (_, rows) = simulated(&Sandbox::rig(), "1 ms");
    let first = &rows[0];
    assert_eq!(first[VELOCITY..FORCES], [0.0; 5]);
    let sum = |i: usize| first[FORCES + i] + first[FORCES + 5 + i];
    // 6 kg along -Y and 60 N along Z are carried by the bearings.
    for (found, carried) in [(sum(0), 0.0), (sum(1), 6.0 * 9.80665), (sum(2), -60.0)] {
        assert!((found - carried).abs() < 1e-4, "{found} N instead of {carried} N");
    }
}

#[test]
fn stays_in_equilibrium_without_excitation() {
    let still = scene(&[("speed = \"3000 rpm\"", "speed = 0"), ("unbalance = [", "unbalance = [] # [")]);
    let (_, rows) = simulated(&Sandbox::with(&still, HEALTHY_RECORDING), "50 ms");
    let away = |row: &Vec<f64>| (POSE..POSE + 3).map(|i| (row[i] - rows[0][i]).abs()).fold(0.0, f64::max);
    let most = rows.iter().map(away).fold(0.0, f64::max);
    assert!(most < 1e-11, "{most} m");
}

/// The forces that the simulation writes are those that `force` gives for its displacements.
#[test]
fn forces_are_those_of_the_force_command() {
    assert_forces_of_the_force_command(&Sandbox::rig());
}

/// The quasi-static bearings of the twin start from the last positions of their balls: the forces are those of a cold start.
#[test]
fn warm_started_balls_equal_a_cold_start() {
    let solved = DEMO_SCENE.replace("\"angular\"", "\"quasi-static\"\neffects = [\"centrifugal\", \"gyroscopic\"]");
    assert_forces_of_the_force_command(&Sandbox::with(&solved, HEALTHY_RECORDING));
}

fn assert_forces_of_the_force_command(sandbox: &Sandbox) {
    let (_, rows) = simulated(sandbox, "30 ms");
    for (place, (bearing, station)) in [("DE", -0.1), ("NDE", 0.1)].into_iter().enumerate() {
        let mut text = "t,u,v,w,thu,thv\n".to_owned();
        for row in &rows {
            let [t, u, v, w, thu, thv] = std::array::from_fn(|i| row[i]);
            text += &format!("{t:e},{:e},{:e},{w:e},{thu:e},{thv:e}\n", u + station * thv, v - station * thu);
        }
        sandbox.put("u.csv", text);
        let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", bearing, "--format", "json"];
        let forces: Vec<Value> = sandbox.done(&args).json();
        assert_eq!(forces.len(), rows.len());
        for (force, row) in forces.iter().zip(&rows) {
            for (i, entry) in ["FX", "FY", "FZ", "MX", "MY"].iter().enumerate() {
                let written = row[FORCES + 5 * place + i];
                let given = force[entry].as_f64().unwrap();
                assert!((given - written).abs() < 1e-6, "{bearing} {entry}: {given} {written}");
            }
        }
    }
}

/// Amplitude and phase lag in degrees of a signal that goes round with the shaft, over whole turns.
fn one_x(signal: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut count, mut along, mut across) = (0.0, 0.0, 0.0);
    for (time, value) in signal {
        let (sin, cos) = (TAU * SPEED * time).sin_cos();
        (count, along, across) = (count + 1.0, along + value * cos, across + value * sin);
    }
    (2.0 / count * f64::hypot(along, across), across.atan2(along).to_degrees().rem_euclid(360.0))
}

#[test]
fn transient_decays_to_the_motion_of_the_twin() {
    let sandbox = Sandbox::with(DEMO_SCENE, HEALTHY_RECORDING);
    let outcome = sandbox.replay("scene.toml", &[]);
    let (_, rows) = simulated(&sandbox, "2 s");
    let settled = &rows[12_800..];
    assert_eq!(settled.len(), 12_800, "50 turns");
    for probe in list(&outcome, "probes") {
        let (z, angle) = (number(probe, "/station_mm") * 1e-3, probe["angle_deg"].as_f64());
        let reading = |row: &Vec<f64>| {
            let [u, v, w, thu, thv] = std::array::from_fn(|i| row[POSE + i]);
            angle.map_or(w, |a| {
                let (sin, cos) = a.to_radians().sin_cos();
                (u + z * thv) * cos + (v - z * thu) * sin
            })
        };
        let (size, lag) = one_x(settled.iter().map(|row| (row[0], reading(row))));
        let (twin, twin_lag) = (number(probe, "/twin/one_x_um"), number(probe, "/twin/one_x_phase_lag_deg"));
        println!("{}: {:.5} um, {lag:.2} deg; twin {twin:.5} um, {twin_lag:.2} deg", probe["name"], size * 1e6);
        assert!((size * 1e6 / twin - 1.0).abs() < 0.02, "{probe:#}");
        // The keyphasor of the recording resolves the angle to half a sample, 0.7 degrees.
        assert!(((lag - twin_lag + 180.0).rem_euclid(360.0) - 180.0).abs() < 2.0, "{probe:#}");
    }
}

#[test]
fn summary_in_three_formats() {
    let sandbox = Sandbox::rig();
    let args = ["simulate", "scene.toml", "--duration", "0.1", "--rate", "5000", "-o", "motion.csv", "--format"];
    let of = |format: &str| sandbox.done(&[&args[..], &[format]].concat());
    let summary: Value = of("json").json();
    assert_eq!((number(&summary, "/samples"), number(&summary, "/rate_hz")), (500.0, 5000.0));
    assert_eq!(summary["output"], "motion.csv");
    let (head, rows) = numbers(&of("csv").out);
    assert_eq!((head[0].as_str(), rows.len(), rows[0][0]), ("samples", 1, 500.0));
    let text = of("text").out;
    assert!(text.contains("500 samples") && text.contains("Written: motion.csv"), "{text}");
}

/// Reading of each of the rig's five probes at a row of the simulation, um.
fn probes(row: &[f64]) -> [f64; 5] {
    let (u, v, w, thu, thv) = (row[POSE], row[POSE + 1], row[POSE + 2], row[POSE + 3], row[POSE + 4]);
    let at = |z: f64| [u + z * thv, v - z * thu];
    let ([a, b], [c, d]) = (at(-0.12), at(0.12));
    [a, b, c, d, w].map(|x| x * 1e6)
}

/// Amplitude at a frequency under a Hann window.
fn line(x: &[f64], hz: f64) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let (mut re, mut im) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let window = 1.0 - (TAU * i as f64 / n).cos();
        let (sin, cos) = (TAU * hz * i as f64 / RATE).sin_cos();
        (re, im) = (re + window * (x - mean) * cos, im + window * (x - mean) * sin);
    }
    2.0 / n * re.hypot(im)
}

/// The rig's facts alone give the statistics of its recordings: mean, peak to peak, 1X and ball-pass amplitude of every
/// probe within 2 % or the probes' noise of 0.03 um.
#[test]
fn statistics_of_the_rig() {
    const SIGMA: f64 = 0.03;
    // By the balls' rolling at their free contact angle: cos = 1 - s/(2 A).
    const COS: f64 = 1.0 - 10e-6 / (2.0 * 0.04 * 7.94e-3);
    const PASS: f64 = SPEED * 9.0 * 0.5 * (1.0 - 7.94 / 39.04 * COS);
    for name in ["healthy", "unbalanced", "outer-spall"] {
        let sandbox = Sandbox::empty();
        let scene = recorded(&format!("{name}.toml"));
        sandbox.done(&[
            "simulate",
            &scene,
            "--settle",
            "1 s",
            "--duration",
            "1 s",
            "--rate",
            "12.8 kHz",
            "-o",
            "m.csv",
        ]);
        let (_, rows) = numbers(&sandbox.read("m.csv"));
        let recording = match name {
            "healthy" => HEALTHY_RECORDING.to_owned(),
            name => std::fs::read_to_string(recorded(&format!("{name}.csv"))).unwrap(),
        };
        let (_, measured) = numbers(&recording);
        // The recordings begin with a start that has not died out.
        let measured = &measured[measured.len() / 2..];
        for probe in 0..5 {
            let mine: Vec<f64> = rows.iter().map(|row| probes(row)[probe]).collect();
            let other: Vec<f64> = measured.iter().map(|row| row[1 + probe]).collect();
            let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
            let spread =
                |x: &[f64]| x.iter().fold(f64::MIN, |m, &x| m.max(x)) - x.iter().fold(f64::MAX, |m, &x| m.min(x));
            let near = |what: &str, mine: f64, other: f64, noise: f64| {
                println!("{name}, probe {probe}: {what} {mine:.4} um, recorded {other:.4}");
                assert!(
                    (mine - other).abs() < (0.02 * other.abs()).max(noise),
                    "{name} {probe} {what}: {mine} {other}"
                );
            };
            let few = SIGMA * (2.0 / other.len() as f64).sqrt();
            near("mean", mean(&mine), mean(&other), 4.0 * few);
            // Noise raises both ends: by four sigma each over so many samples, by less where the motion is large.
            near("peak to peak", spread(&mine), spread(&other), 8.0 * SIGMA);
            near("1X", line(&mine, SPEED), line(&other, SPEED), 4.0 * few);
            near("ball pass", line(&mine, PASS), line(&other, PASS), 4.0 * few);
        }
    }
}

/// A motion that overflows is an error, not a result; the warning is about the step that is taken, not about the one given.
#[test]
fn an_overflow_is_an_error() {
    let sandbox = Sandbox::rig();
    let args = |rate| ["simulate", "coarse.toml", "--duration", "0.05 s", "--rate", rate, "-o", "o.csv"];
    sandbox.put("coarse.toml", DEMO_SCENE.to_owned() + "\n[integration]\nstep = \"1 ms\"\n");
    sandbox.refused(&args("1 kHz"), 1, &["the motion overflows", "The step of 1000.000 us is beyond"]);
    assert!(!sandbox.files().contains(&"o.csv".to_owned()), "{:?}", sandbox.files());
    // One step a sample at most: 78 us.
    assert!(!sandbox.done(&args("12.8 kHz")).out.contains("beyond"));
}

/// The number of steps in the summary is that of the simulation, which takes half the step of a replay.
#[test]
fn steps_in_the_summary_are_those_taken() {
    let args =
        ["simulate", "scene.toml", "--duration", "10 ms", "--rate", "12.8 kHz", "-o", "m.csv", "--format", "json"];
    let summary: Value = Sandbox::rig().done(&args).json();
    assert_eq!(number(&summary, "/steps_per_sample"), 2.0, "{summary}");
}

/// Newmark's method is of order 2 from the first step: its first acceleration is that of the equation of motion.
#[test]
fn newmark_is_of_second_order_from_its_start() {
    let spring = |name: &str, station: f64| {
        format!(
            "[[bearing]]\nname = \"{name}\"\nstation = {station}\nmodel = \"linear\"\nelements = 9\nstiffness_matrix = \
             [[1e7, 0, 0, 0, 0], [0, 1e7, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]\n"
        )
    };
    let end = |method: &str, step: f64| -> Vec<f64> {
        let sandbox = Sandbox::empty();
        let rotor = "[rotor]\nmass = 6\ndiametral_inertia = 0.03\npolar_inertia = 0.006\ngravity = [0, 0, 0]\n\
                     unbalance = [{ moment = \"300 g mm\", angle = 0.3, station = 0.02 }]\n";
        let integration = format!("[integration]\nmethod = \"{method}\"\nstep = {step:e}\n");
        let bearings = spring("front", -0.1) + &spring("rear", 0.1);
        sandbox.put("scene.toml", format!("[shaft]\nspeed = \"6000 rpm\"\n{rotor}{bearings}{integration}"));
        sandbox.done(&["simulate", "scene.toml", "--duration", "6 ms", "--rate", "1 kHz", "-o", "m.csv"]);
        numbers(&sandbox.read("m.csv")).1[5][POSE..POSE + 2].to_vec()
    };
    let exact = end("runge-kutta", 1e-5);
    let error = |step: f64| {
        let off: Vec<f64> = end("newmark", step).iter().zip(&exact).map(|(a, b)| a - b).collect();
        off[0].hypot(off[1])
    };
    let order = (error(6.25e-5) / error(3.125e-5)).log2();
    assert!((1.9..2.1).contains(&order), "order {order}");
}

/// Balls pressed flat are stated, and steps within the integrator's limit are not.
#[test]
fn values_out_of_range_are_reported() {
    let sandbox = Sandbox::rig();
    let args = ["simulate", "coarse.toml", "--duration", "0.05 s", "--rate", "1 kHz", "-o", "o.csv"];
    sandbox.put("coarse.toml", DEMO_SCENE.to_owned() + "\n[integration]\nmethod = \"verlet\"\nstep = \"20 us\"\n");
    assert!(!sandbox.done(&args).out.contains("beyond"));
    let heavy = swap(DEMO_SCENE, "[\"0 N\", \"0 N\", \"60 N\"", "[\"0 N\", \"-60 kN\", \"60 N\"");
    sandbox.put("coarse.toml", &heavy);
    assert!(sandbox.done(&args).out.contains("beyond 4.2 GPa, the static limit of ISO 76"));
    let settled = sandbox.done(&["equilibrium", "coarse.toml"]).out;
    assert!(settled.contains("BEYOND YIELD"), "{settled}");
}

/// The scenes behind the documented speeds run as documented: with Verlet at 25.6 kHz, without a note on the step.
#[test]
fn scenes_of_the_documented_speeds_run() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../benches/speed");
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let expected = ["angular", "flexible", "lumped-radial", "lumped", "quasi-static", "tabulated"];
    assert_eq!(names, expected.map(|name| format!("{name}.toml")));
    let sandbox = Sandbox::empty();
    for name in names {
        let scene = format!("{folder}/{name}");
        let answer = sandbox.done(&["simulate", &scene, "--duration", "0.1 s", "--rate", "256 Hz", "-o", "motion.csv"]);
        assert!(answer.out.contains("times real time") && !answer.out.contains("beyond"), "{name}: {answer:?}");
    }
}

/// The twin follows a recording of its own simulation down to the noise of the probes.
#[test]
fn a_simulated_recording_is_replayed() {
    let args = ["simulate", "scene.toml", "--duration", "0.5 s", "--settle", "0.4 s", "--as-recording", "-o"];
    let volts = |text: &str| {
        let text = text.replace(
            "\"DE_X_um\", unit = \"um\"",
            "\"DE_X_um\", unit = \"V\", sensitivity = \"7.87 mV/um\", offset = \"-9.5 V\"",
        );
        text.replace("pulses_per_turn = 1", "pulses_per_turn = 60, missing = 2").replace("\"12.8 kHz\"", "\"25.6 kHz\"")
    };
    for (scene, file) in
        [(DEMO_SCENE.to_owned(), "r.npy"), (volts(DEMO_SCENE), "r.csv"), (volts(DEMO_SCENE), "r.parquet")]
    {
        let sandbox = Sandbox::with(&scene, "");
        let summary: Value =
            sandbox.done(&[&args[..], &[file, "--resolution", "5 nm", "--format", "json"]].concat()).json();
        assert_eq!((summary["recording"].as_str(), summary["output"].as_str()), (Some(file), Some("r-truth.csv")));
        let (header, truth) = numbers(&sandbox.read("r-truth.csv"));
        assert_eq!((header[0].as_str(), truth.len()), ("t", number(&summary, "/samples") as usize));
        let outcome = sandbox.replay("scene.toml", &["--recording", file]);
        assert!(list(&outcome, "findings").is_empty(), "{outcome:#}");
        assert!((number(&outcome, "/record/mean_speed_rpm") - 3000.0).abs() < 1.0);
        for probe in list(&outcome, "probes") {
            let residual = number(probe, "/residual_rms_um");
            assert!((0.029..0.033).contains(&residual), "{file}: {probe}");
        }
    }
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    let simulated = |seed: &str| {
        sandbox.done(&[&args[..], &["r.csv", "--seed", seed]].concat());
        sandbox.read("r.csv")
    };
    assert_eq!(simulated("1"), simulated("1"));
    assert_ne!(simulated("1"), simulated("2"));
}

/// After a settling time of no whole number of turns the first mark is the first pulse.
#[test]
fn the_first_pulse_is_a_mark() {
    let scene = swap(DEMO_SCENE, "speed = \"3000 rpm\"", "speed = \"2950 rpm\"");
    let sandbox = Sandbox::with(&scene, "");
    let args = ["simulate", "scene.toml", "--duration", "1 s", "--settle", "0.4 s", "--as-recording", "-o", "r.csv"];
    sandbox.done(&args);
    let (header, rows) = numbers(&sandbox.read("r.csv"));
    let key = header.iter().position(|name| name == "keyphasor").unwrap();
    let pulses: Vec<f64> = (0..rows.len()).filter(|i| rows[*i][key] > 0.5).map(|i| i as f64).collect();
    let turn = 12_800.0 * 60.0 / 2950.0;
    // 0.4 s are 19 turns and two thirds.
    assert!((pulses[0] - turn / 3.0).abs() < 2.0, "{}", pulses[0]);
    let outcome = sandbox.replay("scene.toml", &["--recording", "r.csv"]);
    assert!(list(&outcome, "flaws").is_empty(), "{}", outcome["flaws"]);
    assert!((number(&outcome, "/record/max_speed_rpm") - 2950.0).abs() < 3.0);
}

/// A fault of the simulated machine is found by the twin of the sound one.
#[test]
fn a_simulated_fault_is_found() {
    let spall = "diametral_clearance = \"10 um\"\ndefect = [{ surface = \"outer\", azimuth = \"-90 deg\", half_width = \"2.9 deg\", depth = \"3 um\", shape = \"half-sine\" }]";
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    sandbox.put("spalled.toml", swap(DEMO_SCENE, "diametral_clearance = \"10 um\"", spall));
    sandbox.done(&[
        "simulate",
        "spalled.toml",
        "--duration",
        "2 s",
        "--settle",
        "0.4 s",
        "--as-recording",
        "-o",
        "r.parquet",
    ]);
    let outcome = sandbox.replay("scene.toml", &["--recording", "r.parquet"]);
    let first = &list(&outcome, "findings")[0];
    assert_eq!((first["kind"].as_str(), first["bearing"].as_str()), (Some("outer-race"), Some("DE")), "{outcome:#}");
}

#[test]
fn recordings_that_cannot_be_simulated() {
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    let args = ["simulate", "scene.toml", "--duration", "1 s", "-o"];
    sandbox.refused(&[&args[..], &["r.csv"]].concat(), 2, &["--rate"]);
    sandbox.refused(&[&args[..], &["r.wav", "--as-recording"]].concat(), 1, &["r.wav", ".csv, .npy or .parquet"]);
    sandbox.refused(
        &[&args[..], &["r.csv", "--as-recording", "--rate", "10 kHz"]].concat(),
        2,
        &["--rate", "12800 Hz"],
    );
    sandbox.refused(
        &[&args[..], &["r.csv", "--as-recording", "--resolution", "5 kg"]].concat(),
        2,
        &["--resolution", "5 kg"],
    );
    sandbox.refused(
        &[&args[..], &["r.csv", "--as-recording", "--resolution", "5"]].concat(),
        2,
        &["--resolution: no unit: \"5\", expected \"5 um\" or \"5 mm\""],
    );
    let bare = DEMO_SCENE.split("[recording]").next().unwrap().to_owned();
    sandbox.put("bare.toml", bare);
    let args = ["simulate", "bare.toml", "--duration", "1 s", "--rate", "10 kHz", "--as-recording", "-o", "r.csv"];
    sandbox.refused(&args, 2, &["bare.toml", "[recording]"]);
    assert!(
        !sandbox.files().iter().any(|file| file.starts_with("r.") || file.starts_with("r-")),
        "{:?}",
        sandbox.files()
    );
}
