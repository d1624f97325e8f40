//! Kinematics of a bearing whose outer ring turns: cage speed and ball-pass lines are the same in every command.

use crate::support::{HEALTHY_RECORDING, Sandbox, edited_recording, number, numbers, scene};
use serde_json::Value;
use std::f64::consts::TAU;

/// The demonstration with an outer ring that turns against the shaft, and a line added to each bearing.
fn turning_outer_ring(bearing_line: &str) -> String {
    let elements = format!("elements = 9\n{bearing_line}");
    let text = scene(&[("speed = \"3000 rpm\"", "speed = \"3000 rpm\"\nouter_speed = \"-600 rpm\"")]);
    text.replace("elements = 9", &elements)
}

/// `cage_ratio` is the cage speed over the shaft speed in `force` as in `simulate` and `equilibrium`, also where the outer ring
/// turns.
#[test]
fn a_given_cage_ratio_holds_with_a_turning_outer_ring() {
    // With a small axial load few elements carry the weight, so the force depends on the cage angle.
    let text = turning_outer_ring("cage_ratio = 0.38").replace("\"60 N\"", "\"5 N\"");
    let sandbox = Sandbox::with(&text, HEALTHY_RECORDING);
    sandbox.done(&["simulate", "scene.toml", "--duration", "30 ms", "--rate", "12.8 kHz", "-o", "motion.csv"]);
    let (_, rows) = numbers(&sandbox.read("motion.csv"));
    let mut displacements = "t,u,v,w,thu,thv\n".to_owned();
    for row in &rows {
        let [t, u, v, w, thu, thv] = std::array::from_fn(|i| row[i]);
        displacements += &format!("{t:e},{:e},{:e},{w:e},{thu:e},{thv:e}\n", u - 0.1 * thv, v + 0.1 * thu);
    }
    sandbox.put("u.csv", displacements);
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", "DE", "--format", "json"];
    let forces: Vec<Value> = sandbox.done(&args).json();
    assert_eq!(forces.len(), rows.len());
    for (force, row) in forces.iter().zip(&rows) {
        for (component, simulated) in ["FX", "FY", "FZ"].iter().zip(&row[11..14]) {
            let force = force[component].as_f64().unwrap();
            assert!((force - simulated).abs() < 1e-6, "t = {} s, {component}: {force} N, {simulated} N", row[0]);
        }
    }
    let settled: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    assert!((number(&settled, "/bearings/0/orders/cage") - 0.38).abs() < 1e-12);
    assert!((number(&settled, "/bearings/0/orders/outer_race") - 9.0 * 0.58).abs() < 1e-12);
}

/// The amplitude of the outer ball pass is that of the line at its order, `N |cage - outer ring|`.
#[test]
fn the_outer_ball_pass_is_followed_at_its_order() {
    let scene = turning_outer_ring("");
    let recording = |amplitude_um: f64, order: f64| {
        edited_recording(|line, row| {
            if line == 1 {
                return vec![row.to_owned()];
            }
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            let angle = TAU * (line - 2) as f64 / 256.0;
            cells[1] = (cells[1].parse::<f64>().unwrap() + amplitude_um * (order * angle).sin()).to_string();
            vec![cells.join(",")]
        })
    };
    let sandbox = Sandbox::with(&scene, &recording(0.0, 0.0));
    let outcome = sandbox.replay("scene.toml", &[]);
    let order = number(&outcome, "/probes/0/ball_pass/0/order");
    let cage = number(&outcome, "/bearings/0/orders/cage");
    assert!((order - 9.0 * (cage + 0.2)).abs() < 1e-12, "{order} {cage}");
    sandbox.put("healthy.csv", recording(2.0, order));
    let outcome = sandbox.replay("scene.toml", &[]);
    let measured = number(&outcome, "/probes/0/ball_pass/0/measured_um");
    assert!((measured - 2.0).abs() < 0.2, "{measured} um at order {order}");
}

/// A roller bearing of the catalogue between two shafts: the cage by pure rolling, `(w_i (1 - gamma) + w_o (1 + gamma))/2`, also where the
/// outer ring is the faster.
#[test]
fn the_cage_of_a_roller_bearing_follows_a_turning_outer_ring() {
    // NU204: 11 rollers; cage at rest of the outer ring 0.3902.
    for (outer, cage, outer_race) in [(0.5, 0.695, 2.143), (-1.2, -0.343, 9.431), (1.2, 1.122, 0.858)] {
        let text = format!(
            "[shaft]\nspeed = \"3000 rpm\"\nouter_speed = \"{} rpm\"\n[[bearing]]\nname = \"inter-shaft\"\nstation = 0\n\
             bearing = \"NU204\"\n",
            3000.0 * outer
        );
        let found = Sandbox::with(&text, "").done(&["check", "scene.toml", "--format", "json"]).json::<Value>();
        let order = |i: usize| number(&found, &format!("/bearings/0/orders/{i}"));
        assert!((order(2) - cage).abs() < 1e-3, "{outer}: cage {}", order(2));
        assert!((order(0) - outer_race).abs() < 2e-3, "{outer}: outer race {}", order(0));
        assert!((order(1) - 11.0 * (1.0 - order(2)).abs()).abs() < 1e-9, "{outer}: inner race {}", order(1));
    }
    // The same in firmware.
    let scene = "[shaft]\nspeed = \"3000 rpm\"\nouter_speed = \"3600 rpm\"\n[rotor]\nmass = 1\ndiametral_inertia = 1e-3\n\
                 polar_inertia = 1e-3\nstiffness = [0, 0, 1e6, 1e4, 1e4]\n[[bearing]]\nname = \"a\"\nstation = 0\nbearing = \"NU204\"\n";
    let sandbox = Sandbox::with(scene, "");
    sandbox.done(&["bake", "scene.toml", "-o", "a.h", "--language", "c"]);
    let header = sandbox.read("a.h");
    let ratio = header.lines().find_map(|line| line.split_once("CAGE_RATIO (")).unwrap().1;
    let ratio: f64 = ratio.trim_end_matches(')').parse().unwrap();
    assert!((ratio - 1.122).abs() < 1e-3, "{ratio}");
}

/// A roller bearing of the catalogue is linearised at the equilibrium of the lumped model.
#[test]
fn a_roller_bearing_of_the_catalogue_is_linearised() {
    let scene = |model: &str| {
        let bearing = |name: &str, station: &str| {
            format!("[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nbearing = \"NU204\"\n{model}\n")
        };
        "[shaft]\nspeed = \"3000 rpm\"\n[rotor]\nmass = \"10 kg\"\ndiametral_inertia = 0.05\npolar_inertia = 0.02\n\
         load = [0, \"-900 N\", 0, 0, 0]\nstiffness = [0, 0, 1e6, 0, 0]\n"
            .to_owned()
            + &bearing("A", "-100")
            + &bearing("B", "100")
    };
    let stiffness = |model: &str| {
        let found =
            Sandbox::with(&scene(model), "").done(&["equilibrium", "scene.toml", "--format", "json"]).json::<Value>();
        [0, 1].map(|i| number(&found, &format!("/bearings/0/stiffness/{i}/{i}")))
    };
    let (linear, lumped) = (stiffness("model = \"linear\"\nlinearise = \"lumped\""), stiffness("model = \"lumped\""));
    // The springs are the mean over the cage's positions, of which the lumped model shows one: across the load they differ more.
    for (linear, lumped, most) in [(linear[0], lumped[0], 0.6), (linear[1], lumped[1], 0.1)] {
        assert!((linear / lumped - 1.0).abs() < most, "{linear} N/m, {lumped} N/m lumped");
    }
}
