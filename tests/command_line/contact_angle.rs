//! One definition of the contact angle that the orders use, printed beside the angle under load.

use crate::support::{Sandbox, number};
use serde_json::Value;

/// A deep-groove bearing with radial clearance under a radial load alone: it presses at 0 degrees.
const RADIAL: &str = "name = \"6204\"\n[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\n\
     facing = \"both\"\nmodel = \"angular\"\nelements = 8\nball_diameter = \"7.94 mm\"\npitch_diameter = \"33.5 mm\"\n\
     inner_conformity = 0.52\nouter_conformity = 0.52\ndiametral_clearance = \"10 um\"\n";

#[test]
fn equilibrium_states_the_angle_of_the_orders_and_that_under_load() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", RADIAL);
    let args = ["equilibrium", "scene.toml", "--load", "0,-500,0,0,0"];
    let json: Value = sandbox.done(&[&args[..], &["--format", "json"]].concat()).json();
    let bearing = &json["bearings"][0];
    // cos(alpha_0) = 1 - s/(2 A), A = 0.04 * 7.94 mm.
    let free = (1.0 - 10e-6_f64 / (2.0 * 0.04 * 7.94e-3)).acos();
    let order = |angle: f64| 4.0 * (1.0 - 7.94 / 33.5 * angle.cos());
    assert!((number(bearing, "/contact_angle/free") - free).abs() < 1e-12);
    assert!(number(bearing, "/contact_angle/loaded").abs() < 1e-9);
    assert!((number(bearing, "/orders/outer_race") - order(free)).abs() < 1e-12);
    assert!((number(bearing, "/orders_under_load/outer_race") - order(0.0)).abs() < 1e-9);
    let text = sandbox.done(&args).out;
    let (free_order, loaded_order) = (order(free), order(0.0));
    for part in [
        format!("free contact angle {:.2} deg, used for cage speed and orders", free.to_degrees()),
        format!("outer race {free_order:.3}"),
        "mean angle under load 0.00 deg".to_owned(),
        format!("outer race {loaded_order:.3}"),
    ] {
        assert!(text.contains(&part), "{part}: {text}");
    }
}

/// `cage_ratio` of the scene overrides the angle, and the text states this.
#[test]
fn a_cage_ratio_of_the_scene_is_stated() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", format!("{RADIAL}cage_ratio = 0.39\n"));
    let args = ["equilibrium", "scene.toml", "--load", "0,-500,0,0,0"];
    let text = sandbox.done(&args).out;
    assert!(text.contains("cage_ratio 0.39 of the scene, used for cage speed and orders"), "{text}");
    assert!(text.contains("outer race 3.120"), "{text}");
}
