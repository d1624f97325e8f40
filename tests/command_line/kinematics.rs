//! Kinematics of a bearing whose outer ring turns: cage speed and ball-pass lines are the same in every command.

use crate::support::{DEMO_RECORDING, Desk, edited_recording, number, numbers, scene};
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
    let desk = Desk::with(&text, DEMO_RECORDING);
    desk.done(&["simulate", "scene.toml", "--duration", "30 ms", "--rate", "12.8 kHz", "-o", "motion.csv"]);
    let (_, rows) = numbers(&desk.read("motion.csv"));
    let mut displacements = "t,u,v,w,thu,thv\n".to_owned();
    for row in &rows {
        let [t, u, v, w, thu, thv] = std::array::from_fn(|i| row[i]);
        displacements += &format!("{t:e},{:e},{:e},{w:e},{thu:e},{thv:e}\n", u - 0.1 * thv, v + 0.1 * thu);
    }
    desk.put("u.csv", displacements);
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", "DE", "--format", "json"];
    let forces: Vec<Value> = desk.done(&args).json();
    assert_eq!(forces.len(), rows.len());
    for (force, row) in forces.iter().zip(&rows) {
        for (component, simulated) in ["FX", "FY", "FZ"].iter().zip(&row[11..14]) {
            let force = force[component].as_f64().unwrap();
            assert!((force - simulated).abs() < 1e-6, "t = {} s, {component}: {force} N, {simulated} N", row[0]);
        }
    }
    let settled: Value = desk.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
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
    let desk = Desk::with(&scene, &recording(0.0, 0.0));
    let outcome = desk.replay("scene.toml", &[]);
    let order = number(&outcome, "/probes/0/ball_pass/0/order");
    let cage = number(&outcome, "/bearings/0/orders/cage");
    assert!((order - 9.0 * (cage + 0.2)).abs() < 1e-12, "{order} {cage}");
    desk.put("healthy.csv", recording(2.0, order));
    let outcome = desk.replay("scene.toml", &[]);
    let measured = number(&outcome, "/probes/0/ball_pass/0/measured_um");
    assert!((measured - 2.0).abs() < 0.2, "{measured} um at order {order}");
}
