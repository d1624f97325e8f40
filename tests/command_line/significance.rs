//! The predicted significance of effects: of what the scene names, at every point of a sweep.

use crate::support::{DEMO_SCENE, Desk, scene};
use serde_json::Value;

const OIL: &str =
    "poissons_ratio = 0.3\nlubricant = { viscosity = \"0.04 Pa s\", pressure_viscosity = \"2.2e-8 1/Pa\" }";

fn effect<'a>(found: &'a Value, name: &str) -> Option<&'a Value> {
    found["effect_significance"].as_array().unwrap().iter().find(|need| need["effect"] == name)
}

#[test]
fn a_film_is_predicted_only_with_a_lubricant() {
    let desk = Desk::empty();
    desk.put("dry.toml", DEMO_SCENE);
    let balls = "model = \"quasi-static\"";
    desk.put("oiled.toml", scene(&[("model = \"angular\"", balls), ("poissons_ratio = 0.3", OIL)]));
    for command in [&["equilibrium", "dry.toml"][..], &["campbell", "dry.toml", "--speeds", "3000rpm"]] {
        let text = desk.done(command).out;
        assert!(!text.contains("film 4") && !text.contains("film 5"), "{text}");
        assert_eq!(text.matches("film is not considered: the scene has no lubricant").count(), 1, "{text}");
    }
    let json: Value = desk.done(&["equilibrium", "dry.toml", "--format", "json"]).json();
    assert_eq!(effect(&json, "film"), None);
    let text = desk.done(&["equilibrium", "oiled.toml"]).out;
    // Its first bearing names an oil, the other one does not.
    assert!(text.contains("DE: WARNING: film is omitted"), "{text}");
    assert!(text.contains("\nNDE: film is not considered: the scene has no lubricant"), "{text}");
}

/// The alternative to a contact angle that turns is a fixed one, the mean angle under this load, not 0.
#[test]
fn the_contact_angle_of_a_deep_groove_bearing_is_compared_with_its_mean() {
    let desk = Desk::empty();
    desk.put("scene.toml", DEMO_SCENE);
    let json: Value = desk.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    let change = effect(&json, "contact-angle").unwrap()["change"].as_f64().unwrap();
    // All balls press within 0.02 degrees of each other, at 11.56 degrees.
    assert!((0.0..0.01).contains(&change), "{change}");
    // A moment turns the angles of opposite balls apart: a fixed angle carries none of it.
    let args = ["--bearing", "DE", "--load", "0,-300,60,3,0", "--format", "json"];
    let json: Value = desk.done(&[&["equilibrium", "scene.toml"], &args[..]].concat()).json();
    let change = effect(&json, "contact-angle").unwrap()["change"].as_f64().unwrap();
    assert!((0.01..1.0).contains(&change), "{change}");
}

#[test]
fn a_sweep_warns_about_its_worst_point() {
    let desk = Desk::empty();
    desk.put("scene.toml", DEMO_SCENE);
    let args = ["sweep", "scene.toml", "--over", "shaft.speed=500rpm,12000rpm", "--settle", "20 ms", "--periods", "16"];
    let text = desk.done(&[&args[..], &["-o", "a"]].concat()).out;
    let warned = |line: &&str| line.starts_with("DE: WARNING: centrifugal is omitted");
    let line = text.lines().find(warned).unwrap_or_else(|| panic!("{text}"));
    assert!(line.contains("at shaft.speed = 12000 rpm"), "{line}");
    // The same from what the journal of a stopped sweep holds.
    desk.done(&[&args[..], &["-o", "b", "--shard", "1/1"]].concat());
    let merged = desk.done(&[&args[..], &["-o", "b", "--merge"]].concat()).out;
    assert_eq!(merged.lines().find(warned), Some(line), "{merged}");
    let json: Value = desk.done(&[&args[..], &["-o", "c", "--format", "json"]].concat()).json();
    assert!(effect(&json, "centrifugal").unwrap()["change"].as_f64().unwrap() > 0.03, "{json}");
}
