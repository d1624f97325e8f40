//! Tables of default size against the model that they are made from, over the motion of light and heavy rotors.

use super::force::in_precision;
use super::poses::{self, Pose};
use ballrace::{Exact, Status, Wrench};
use ballrace_models::build::{DESKTOP_TABLE, FIRMWARE_TABLE, TableSize, of_table, solved_in, table};
use ballrace_models::handle::{AnyForceModel, ForceModel};
use ballrace_plant::Plant;
use ballrace_scene::Scene;
use ballrace_scene::read::read_str;
use std::path::Path;

fn scene(speed: &str, [mass, thrust]: [f64; 2], bearing: &str) -> Scene {
    let facing = if bearing.contains("contact_angle") { ["+z", "-z"] } else { ["both"; 2] };
    let bearing = |name: &str, station: i32, facing: &str| {
        format!(
            "[[bearing]]\nname = '{name}'\nstation = '{station} mm'\nfacing = '{facing}'\nmodel = 'tabulated'\nelements = 9\n\
             ball_diameter = '7.94 mm'\npitch_diameter = '39.04 mm'\ninner_conformity = 0.52\nouter_conformity = 0.52\n{bearing}\n"
        )
    };
    let text = format!(
        "name = 'rotor'\n[shaft]\nspeed = {speed}\n[rotor]\nmass = '{mass} kg'\ndiametral_inertia = 0.03\npolar_inertia = 0.006\n\
         damping = [400, 400, 400, 0.4, 0.4]\ngravity = [0, -9.81, 0]\nload = [0, 0, {thrust}, 0, 0]\n\
         unbalance = [{{ moment = '8 g mm', angle = '17 deg', station = '20 mm' }}]\n{}{}",
        bearing("DE", -100, facing[0]),
        bearing("NDE", 100, facing[1])
    );
    read_str(&text, Path::new("rotor.toml")).unwrap()
}

/// Returns the largest error of the forces of one bearing, from the table of `tabulated_scene`, over the motion of `scene`, relative to the
/// largest force.
fn error(tabulated_scene: &Scene, scene: &Scene, size: TableSize) -> f64 {
    let of = &scene.bearings[0];
    let made = table(tabulated_scene, &tabulated_scene.bearings[0], size).unwrap();
    assert!(4 * made.fields() * made.nodes.len() <= size.bytes);
    let plant = Plant::try_new(scene).unwrap();
    let poses = poses::computed(scene, &plant).unwrap();
    let offset = plant.bearings[0].offset;
    let tabulated = of_table::<f32, Exact, AnyForceModel<f32>>(of, &made).unwrap();
    let exact = solved_in(of, 20).unwrap();
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for pose in &poses[0] {
        let pose = Pose { u: pose.u + offset, at: pose.at };
        let (rounded, at) = in_precision(&pose);
        let found = tabulated.reaction(&rounded, &at);
        assert!(!found.status.contains(Status::OUT_OF_TABLE));
        let expected = exact.reaction(&pose.u, &pose.at).wrench;
        let size = |w: Wrench<f64>| w.fx.hypot(w.fy).hypot(w.fz);
        let found = found.wrench.to_array().map(f64::from);
        let apart = std::array::from_fn(|i| found[i] - expected.to_array()[i]);
        error = error.max(size(Wrench::from_array(apart)));
        largest = largest.max(size(expected));
    }
    error / largest
}

#[test]
fn tables_of_default_size_have_a_small_error_relative_to_the_load_in_service() {
    let effects = "effects = ['centrifugal', 'gyroscopic']\n";
    let deep_groove = format!("diametral_clearance = '10 um'\n{effects}");
    let pair = format!("contact_angle = '25 deg'\npreload = {{ force = '100 N' }}\n{effects}");
    let friction = format!("{pair}friction_sharing = 'proportional'\n");
    let film = pair.replace("'gyroscopic'", "'gyroscopic', 'film'");
    let film = format!("{film}lubricant = {{ viscosity = '0.04 Pa s', pressure_viscosity = '2.2e-8 1/Pa' }}\n");
    let slow = "'3000 rpm'";
    let run_up = "{ from = '1000 rpm', to = '12000 rpm', over = '2 s' }";
    let cases = [
        ("without inertia", scene(slow, [9.0, 60.0], "diametral_clearance = '10 um'"), [1e-4; 2]),
        ("9 kg", scene(slow, [9.0, 60.0], &deep_groove), [1e-4; 2]),
        ("9 kg, light thrust", scene(slow, [9.0, 10.0], &deep_groove), [1e-4, 2e-4]),
        ("200 kg", scene(slow, [200.0, 60.0], &deep_groove), [1e-4; 2]),
        ("15 000 rpm", scene("'15000 rpm'", [9.0, 60.0], &deep_groove), [1e-4, 3e-4]),
        ("preloaded pair", scene("'12000 rpm'", [9.0, 0.0], &pair), [1e-4; 2]),
        ("friction at both races", scene("'12000 rpm'", [9.0, 0.0], &friction), [1e-4, 3e-4]),
        ("run-up", scene(run_up, [9.0, 0.0], &pair), [4e-4, 1e-3]),
        ("run-up, high preload", scene(run_up, [9.0, 0.0], &pair.replace("100 N", "500 N")), [1e-4, 2e-4]),
        ("run-up with film", scene(run_up, [9.0, 0.0], &film), [2e-4, 4e-4]),
    ];
    for (name, scene, limits) in &cases {
        for (size, limit) in [DESKTOP_TABLE, FIRMWARE_TABLE].into_iter().zip(limits) {
            let found = error(scene, scene, size);
            println!("{name}, {} kB: {found:.1e}", size.bytes >> 10);
            assert!(found < *limit, "{name}, {} kB: {found:e}", size.bytes >> 10);
        }
    }
}

/// A constant speed of a scene is a node of its table; machines run some percent beside it.
#[test]
fn tables_between_their_speeds() {
    let pair = "contact_angle = '25 deg'\npreload = { force = '100 N' }\neffects = ['centrifugal', 'gyroscopic']\n";
    let at = |rpm: f64| scene(&format!("'{rpm} rpm'"), [9.0, 0.0], pair);
    let beside = [0.82, 0.85, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.15];
    let found = beside.map(|part| error(&at(12_000.0), &at(part * 12_000.0), DESKTOP_TABLE));
    println!("{}", found.map(|e| format!("{e:.1e}")).join(" "));
    let largest = found.into_iter().fold(0.0, f64::max);
    assert!((5e-4..2e-3).contains(&largest), "{found:?}");
}

/// Small loads on fast deep-groove bearings, whose balls change sides between the nodes, and a run-up of such a bearing.
#[test]
fn tables_of_hardly_loaded_and_fast_bearings() {
    let deep_groove = "diametral_clearance = '10 um'\neffects = ['centrifugal', 'gyroscopic']\n";
    for speed in ["'6000 rpm'", "'15000 rpm'"] {
        for (mass, thrust) in [(9.0, 0.0), (9.0, 5.0), (9.0, 20.0), (30.0, 0.0)] {
            let scene = scene(speed, [mass, thrust], deep_groove);
            let found = error(&scene, &scene, DESKTOP_TABLE);
            println!("{speed}, {mass} kg, {thrust} N: {found:.1e}");
            assert!(found < 1e-3, "{speed}, {mass} kg, {thrust} N: {found:e}");
        }
    }
    let run_up = scene("{ from = '1000 rpm', to = '12000 rpm', over = '2 s' }", [9.0, 60.0], deep_groove);
    let found = error(&run_up, &run_up, DESKTOP_TABLE);
    println!("run-up: {found:.1e}");
    assert!(found < 2e-3, "{found:e}");
}
