//! The predicted significance of effects: of what the scene names, at every point of a sweep.

use crate::support::{DEMO_SCENE, Sandbox, scene};
use serde_json::Value;

const OIL: &str =
    "poissons_ratio = 0.3\nlubricant = { viscosity = \"0.04 Pa s\", pressure_viscosity = \"2.2e-8 1/Pa\" }";

fn effect<'a>(found: &'a Value, name: &str) -> Option<&'a Value> {
    found["effect_significance"].as_array().unwrap().iter().find(|need| need["effect"] == name)
}

#[test]
fn a_film_is_predicted_only_with_a_lubricant() {
    let sandbox = Sandbox::empty();
    sandbox.put("dry.toml", DEMO_SCENE);
    let balls = "model = \"quasi-static\"";
    sandbox.put("oiled.toml", scene(&[("model = \"angular\"", balls), ("poissons_ratio = 0.3", OIL)]));
    for command in [&["equilibrium", "dry.toml"][..], &["campbell", "dry.toml", "--speeds", "3000rpm"]] {
        let text = sandbox.done(command).out;
        assert!(!text.contains("film 4") && !text.contains("film 5"), "{text}");
        assert_eq!(text.matches("film is not considered: the scene has no lubricant").count(), 1, "{text}");
    }
    let json: Value = sandbox.done(&["equilibrium", "dry.toml", "--format", "json"]).json();
    assert_eq!(effect(&json, "film"), None);
    let text = sandbox.done(&["equilibrium", "oiled.toml"]).out;
    // Its first bearing names an oil, the other one does not.
    assert!(text.contains("DE: WARNING: film is omitted"), "{text}");
    assert!(text.contains("\nNDE: film is not considered: the scene has no lubricant"), "{text}");
}

/// An isothermal film at a high speed is far too thick: the heating of its inlet is named where it changes the force.
#[test]
fn heating_of_the_inlet_is_named_at_high_speed() {
    let oil = OIL.replace("0.04 Pa s", "0.1 Pa s") + "\neffects = [\"film\"]";
    for (speed, is_large) in [("300 rpm", false), ("30000 rpm", true)] {
        let sandbox = Sandbox::empty();
        let edits = [("model = \"angular\"", "model = \"quasi-static\""), ("poissons_ratio = 0.3", oil.as_str())];
        sandbox.put("scene.toml", scene(&edits).replace("3000 rpm", speed));
        let json: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
        let heating = effect(&json, "inlet-heating").unwrap();
        assert_eq!(heating["modelled"], false);
        let text = sandbox.done(&["equilibrium", "scene.toml"]).out;
        let warned = text.contains("WARNING: inlet-heating is omitted");
        assert_eq!(warned, is_large, "{speed}: {text}");
        if is_large {
            // L = 0.1 Pa s 0.04 1/K (28.4 m/s)^2 / 0.14 W/(m K) = 23: 1/(1 + 0.213 L^0.64) = 0.39, less 1 to 25 % by the pressure.
            let (_, share) = text.split_once("heating of the inlet reduces the film of a mineral oil to ").unwrap();
            let share: f64 = share.split_whitespace().next().unwrap().parse().unwrap();
            assert!((28.0..40.0).contains(&share), "{share} %");
        }
    }
}

/// With the properties of the oil the heating is part of the model, solved and tabulated alike: the films are thinner by its share.
#[test]
fn heating_of_the_inlet_thins_the_film() {
    let oil = OIL.replace("0.04 Pa s", "0.1 Pa s") + "\neffects = [\"film\"]";
    let heated = oil.replace("}", ", inlet_heating = { temperature_coefficient = \"0.04 1/K\" } }");
    let solved = |oil: &str, model: &str| -> Value {
        let sandbox = Sandbox::empty();
        let edits = [("model = \"angular\"", model), ("poissons_ratio = 0.3", oil)];
        sandbox.put("scene.toml", scene(&edits).replace("3000 rpm", "30000 rpm"));
        sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json()
    };
    let film = |json: &Value| json["elements"][0]["inner_film"].as_f64().unwrap();
    let [cold, warm] = [&oil, &heated].map(|oil| solved(oil, "model = \"quasi-static\""));
    assert_eq!(effect(&warm, "inlet-heating").unwrap()["modelled"], true);
    let share = film(&warm) / film(&cold);
    assert!((0.25..0.45).contains(&share), "{share}: {} m, {} m", film(&warm), film(&cold));
    // The table holds the heated film: the rotor rests where it does with balls that are solved.
    let looked_up = solved(&heated, "model = \"tabulated\"");
    let at = |json: &Value| json["displacement"][1].as_f64().unwrap();
    assert!((at(&looked_up) / at(&warm) - 1.0).abs() < 0.01, "{} m, {} m", at(&looked_up), at(&warm));
    assert!((at(&cold) / at(&warm) - 1.0).abs() > 0.01, "{} m, {} m", at(&cold), at(&warm));
}

/// The alternative to a contact angle that turns is a fixed one, the mean angle under this load, not 0.
#[test]
fn the_contact_angle_of_a_deep_groove_bearing_is_compared_with_its_mean() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    let json: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    let change = effect(&json, "contact-angle").unwrap()["change"].as_f64().unwrap();
    // All balls press within 0.02 degrees of each other, at 11.56 degrees.
    assert!((0.0..0.01).contains(&change), "{change}");
    // A moment turns the angles of opposite balls apart: a fixed angle carries none of it.
    let args = ["--bearing", "DE", "--load", "0,-300,60,3,0", "--format", "json"];
    let json: Value = sandbox.done(&[&["equilibrium", "scene.toml"], &args[..]].concat()).json();
    let change = effect(&json, "contact-angle").unwrap()["change"].as_f64().unwrap();
    assert!((0.01..1.0).contains(&change), "{change}");
}

#[test]
fn a_sweep_warns_about_its_worst_point() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    let args = ["sweep", "scene.toml", "--over", "shaft.speed=500rpm,12000rpm", "--settle", "20 ms", "--periods", "16"];
    let text = sandbox.done(&[&args[..], &["-o", "a"]].concat()).out;
    let warned = |line: &&str| line.starts_with("DE: WARNING: centrifugal is omitted");
    let line = text.lines().find(warned).unwrap_or_else(|| panic!("{text}"));
    assert!(line.contains("at shaft.speed = 12000 rpm"), "{line}");
    // The same from what the journal of a stopped sweep holds.
    sandbox.done(&[&args[..], &["-o", "b", "--shard", "1/1"]].concat());
    let merged = sandbox.done(&[&args[..], &["-o", "b", "--merge"]].concat()).out;
    assert_eq!(merged.lines().find(warned), Some(line), "{merged}");
    let json: Value = sandbox.done(&[&args[..], &["-o", "c", "--format", "json"]].concat()).json();
    assert!(effect(&json, "centrifugal").unwrap()["change"].as_f64().unwrap() > 0.03, "{json}");
}

/// The demonstration's machine on a ramp, and in a diagram over the speed.
#[test]
fn a_ramp_warns_about_its_worst_speed() {
    let sandbox = Sandbox::empty();
    sandbox.put("fast.toml", scene(&[("speed = \"3000 rpm\"", "speed = \"12000 rpm\"")]));
    let ramp = "speed = { from = \"100 rpm\", to = \"12000 rpm\", over = \"2 s\" }";
    sandbox.put("ramp.toml", scene(&[("speed = \"3000 rpm\"", ramp)]));
    sandbox.put("slow.toml", DEMO_SCENE);
    let centrifugal = |args: &[&str]| {
        let json: Value = sandbox.done(&[args, &["--format", "json"]].concat()).json();
        let found = effect(&json, "centrifugal").unwrap();
        (found["change"].as_f64().unwrap(), found["at"].as_str().map(str::to_owned))
    };
    let (at_end, none) = centrifugal(&["equilibrium", "fast.toml"]);
    let (over_ramp, place) = centrifugal(&["equilibrium", "ramp.toml"]);
    assert!(at_end > 0.03 && none.is_none(), "{at_end} {none:?}");
    assert!((over_ramp / at_end - 1.0).abs() < 1e-9, "{over_ramp} {at_end}");
    assert_eq!(place.as_deref(), Some("shaft.speed = 12000 rpm"));
    let simulate = ["simulate", "ramp.toml", "--duration", "10 ms", "--rate", "1 kHz", "-o", "motion.csv"];
    assert_eq!(centrifugal(&simulate), (over_ramp, place));
    let warned = |line: &&str| line.starts_with("DE: WARNING: centrifugal is omitted");
    let text = sandbox.done(&["campbell", "slow.toml", "--speeds", "0rpm..12000rpm:3"]).out;
    let line = text.lines().find(warned).unwrap_or_else(|| panic!("{text}"));
    assert!(line.contains("at shaft.speed = 12000 rpm"), "{line}");
    // An effect that is the same at every speed names none.
    let (_, listed) = text.split_once("\nDE: effects of this scene").unwrap();
    assert!(!listed.lines().next().unwrap().contains("contact-angle 0 % at"), "{text}");
    sandbox.put("u.csv", "u,v,w,thu,thv,t\n1e-5,0,6e-5,0,0,0\n1e-5,0,6e-5,0,0,2\n");
    let force = ["force", "ramp.toml", "--bearing", "DE", "--displacements", "u.csv"];
    assert!(sandbox.done(&force).out.lines().any(|line| warned(&line)));
}

/// A preloaded lumped bearing without load: its balls press each other, and the play is the scene's.
const PRELOADED: &str = r#"
shaft.speed = "3000 rpm"
[rotor]
mass = "1 kg"
diametral_inertia = "0.001 kg m^2"
polar_inertia = "0.0005 kg m^2"
stiffness = [0, 0, 1e6, 0, 0]
[[bearing]]
name = "A"
station = "0 mm"
model = "lumped"
elements = 6
ball_diameter = "6 mm"
pitch_diameter = "20 mm"
inner_conformity = 0.515
outer_conformity = 0.515
contact_angle = "0 deg"
radial_play = "-13 um"
"#;

#[test]
fn effects_on_a_preloaded_bearing_use_its_play() {
    let sandbox = Sandbox::empty();
    let pair = PRELOADED.split_once("[[bearing]]").unwrap();
    let second = pair.1.replace("\"A\"", "\"B\"").replace("\"0 mm\"", "\"50 mm\"");
    let first = pair.1.replace("\"0 mm\"", "\"-50 mm\"");
    sandbox.put("scene.toml", format!("{}[[bearing]]{first}[[bearing]]{second}", pair.0));
    // By hand: a ball of 0.88 g at 10 mm and 0.35 of the speed has 0.107 N, and 13 um give about 400 N.
    let found = |name: &str| {
        let text = sandbox.done(&["equilibrium", name]).out;
        assert!(!text.contains("WARNING"), "{text}");
        let json: Value = sandbox.done(&["equilibrium", name, "--format", "json"]).json();
        let centrifugal = effect(&json, "centrifugal").unwrap();
        assert_eq!(centrifugal["because"], "centrifugal force 0.03 % of the load of a ball", "{text}");
        centrifugal["change"].as_f64().unwrap()
    };
    // The weight is carried by all balls, and the centrifugal forces of opposite balls balance each other.
    assert!(found("scene.toml") < 1e-6);
    // Without weight no force is left, and the change is that of the loads.
    sandbox.put("light.toml", sandbox.read("scene.toml").replace("[rotor]", "[rotor]\ngravity = [0, 0, 0]"));
    let change = found("light.toml");
    assert!((5e-5..5e-4).contains(&change), "{change}");
}

/// Almost no load: the change is a multiple, with its reason.
#[test]
fn large_changes_are_multiples_with_a_reason() {
    let sandbox = Sandbox::empty();
    let weightless = ("mass = \"6 kg\"", "mass = \"6 kg\"\ngravity = [0, 0, 0]");
    sandbox.put("scene.toml", scene(&[("\"60 N\"", "\"0.01 N\""), weightless]));
    let text = sandbox.done(&["equilibrium", "scene.toml"]).out;
    let line =
        text.lines().find(|line| line.starts_with("DE: WARNING: centrifugal")).unwrap_or_else(|| panic!("{text}"));
    assert!(
        line.contains(" times the load of a ball; the bearing carries only ") && line.contains(" times ("),
        "{line}"
    );
    let words = text
        .lines()
        .filter(|line| line.contains("WARNING") || line.contains("effects of"))
        .flat_map(str::split_whitespace);
    for number in words.filter_map(|word| word.trim_start_matches('(').parse::<f64>().ok()) {
        assert!(number.abs() <= 1000.0, "{number}: {text}");
    }
}
