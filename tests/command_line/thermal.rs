//! `ballrace equilibrium`: friction, modified life and the temperatures that friction and cooling keep.

use crate::support::{Sandbox, number, swap};
use serde_json::Value;

const SPINDLE: &str = include_str!("../../runner/scenes/spindle-thermal.toml");

fn solved(scene: &str, more: &[&str]) -> Value {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene);
    sandbox.done(&[&["equilibrium", "scene.toml", "--format", "json"], more].concat()).json()
}

/// A bearing of the catalogue under a load, with oil.
fn lubricated(designation: &str, oil: &str) -> String {
    format!(
        "shaft.speed = \"3000 rpm\"\n[[bearing]]\nname = \"A\"\nbearing = \"{designation}\"\n\
         lubrication = {{ viscosity_40 = \"32 mm^2/s\", viscosity_100 = \"5.4 mm^2/s\", temperature = \"40 degC\", {oil} }}\n"
    )
}

/// A 6205 in an oil bath at 3000 rpm and a tapered bearing with grease, by hand: `M_0 = 1e-7 f0 (nu n)^(2/3) d_m^3`, `M_1 = f1 P_1 d_m`.
#[test]
fn friction_by_the_equations_of_palmgren() {
    let found = solved(&lubricated("6205", "method = \"oil-bath\""), &["--load", "1000,0,0,0,0"]);
    let one = |found: &Value, key: &str| number(found, &format!("/bearings/0/friction/{key}"));
    // 96 000^(2/3) = 2096.5 and the pitch diameter of the catalogue of 39.04 mm.
    let expected = 1e-7 * 2.0 * 96_000_f64.powf(2.0 / 3.0) * 39.04_f64.powi(3) * 1e-3;
    assert!((one(&found, "viscous_moment") / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    let at_rest = number(&found, "/bearings/0/life/static_rating");
    let expected = 5e-4 * (1000.0 / at_rest).powf(0.55) * 1000.0 * 39.04e-3;
    assert!((one(&found, "load_moment") / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    let sum = one(&found, "viscous_moment") + one(&found, "load_moment") + one(&found, "spin_moment");
    assert!((one(&found, "moment") / sum - 1.0).abs() < 1e-12);
    assert!((one(&found, "power") / (sum * 100.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    // The factors of a maker in place of the means, and below 2000 mm^2/s rpm a moment that does not depend on the speed.
    let slow = swap(&lubricated("6205", "method = \"grease\", f0 = 3, f1 = 0.0004"), "3000 rpm", "50 rpm");
    let found = solved(&slow, &["--load", "1000,0,0,0,0"]);
    assert!((one(&found, "viscous_moment") / (160e-7 * 3.0 * 39.04_f64.powi(3) * 1e-3) - 1.0).abs() < 1e-9);
    assert!((one(&found, "load_moment") / (4e-4 * 1000.0 * 39.04e-3) - 1.0).abs() < 1e-9);
}

/// The spin of balls that all have one load and one angle, by hand from what is printed: on the inner race alone, `sin` of the angle times the speed.
#[test]
fn the_spin_of_balls_under_thrust() {
    let scene = lubricated("7010C", "method = \"oil-mist\", sliding_friction = 0.06")
        + "model = \"quasi-static\"\nfacing = \"+z\"\n";
    let found = solved(&scene, &["--load", "0,0,500,0,0"]);
    let [load, angle] = ["inner_load", "inner_angle"].map(|key| number(&found, &format!("/elements/0/{key}")));
    let pressure = number(&found, "/elements/0/inner_pressure");
    let elements = found["elements"].as_array().unwrap().len() as f64;
    let moment = number(&found, "/bearings/0/friction/spin_moment");
    // `3 a E/8` with `p = 3 Q/(2 pi a b)`, the axes and `E` by the approximations of Hamrock and Brewe, good to 3 %: `a/b = 1.0339 r^0.636`,
    // `E = 1.0003 + 0.5968/r`, `r` the ratio of the radii across and along.
    let (ball, pitch, conformity) = (8.7312_f64, 65.0, 0.52);
    let along = 2.0 / ball / (1.0 - ball / pitch * angle.cos());
    let across = 2.0 / ball - 1.0 / (conformity * ball);
    let ratio: f64 = along / across;
    let large = (1.5 * load / (std::f64::consts::PI * pressure) * 1.0339 * ratio.powf(0.636)).sqrt();
    let expected = elements * 0.06 * load * 0.375 * large * (1.0003 + 0.5968 / ratio) * angle.sin();
    assert!((moment / expected - 1.0).abs() < 0.04, "{moment} {expected}");
    let double = solved(&swap(&scene, "0.06", "0.12"), &["--load", "0,0,500,0,0"]);
    assert!((number(&double, "/bearings/0/friction/spin_moment") / moment - 2.0).abs() < 1e-9);
}

/// `a_ISO` by hand at three viscosity ratios, one in each range of ISO 281, from the printed life and limit; 50 is the most, below 0.1 there is none.
#[test]
fn the_life_modified_by_lubrication_and_contamination() {
    let at = |designation: &str, viscosity: f64, load: &str| {
        let oil = format!("{viscosity} mm^2/s");
        let scene = swap(&lubricated(designation, "method = \"oil-bath\", contamination = 0.3"), "32 mm^2/s", &oil);
        let scene = swap(&scene, "5.4 mm^2/s", &format!("{} mm^2/s", 0.2 * viscosity));
        solved(&scene, &["--load", load])["bearings"][0]["life"].clone()
    };
    let by_hand = |life: &Value, is_ball: bool, (c, d): (f64, f64)| {
        let kappa = number(life, "/modified/viscosity_ratio");
        let stress = 0.3 * number(life, "/modified/fatigue_limit") / number(life, "/reference_load");
        if is_ball {
            0.1 * (1.0 - (2.5671 - c / kappa.powf(d)).powf(0.83) * stress.powf(1.0 / 3.0)).powf(-9.3)
        } else {
            0.1 * (1.0 - (1.5859 - c / kappa.powf(d)) * stress.powf(0.4)).powf(-9.185)
        }
    };
    // 3000 rpm and 39.04 mm: the reference viscosity is 4500/sqrt(3000 * 39.04) = 13.15 mm^2/s.
    for (viscosity, constants) in [(3.0, (2.2649, 0.054_381)), (9.0, (1.9987, 0.190_87)), (30.0, (1.9987, 0.071_739))] {
        let life = at("6205", viscosity, "3000,0,0,0,0");
        assert!((number(&life, "/modified/viscosity_ratio") / (viscosity / 13.1495) - 1.0).abs() < 1e-4, "{life}");
        let limit = number(&life, "/static_rating") / 22.0;
        assert!((number(&life, "/modified/fatigue_limit") / limit - 1.0).abs() < 1e-12);
        let factor = number(&life, "/modified/factor");
        assert!((factor / by_hand(&life, true, constants) - 1.0).abs() < 1e-9, "{viscosity}: {life}");
        assert!((number(&life, "/modified/life") / (factor * number(&life, "/reference_life")) - 1.0).abs() < 1e-12);
    }
    let rollers = at("NU205", 9.0, "6000,0,0,0,0");
    assert!((number(&rollers, "/modified/factor") / by_hand(&rollers, false, (1.2348, 0.190_87)) - 1.0).abs() < 1e-9);
    assert_eq!(number(&at("6205", 60.0, "100,0,0,0,0"), "/modified/factor"), 50.0);
    assert!(at("6205", 1.2, "3000,0,0,0,0")["modified"]["factor"].is_null());
}

/// The ratings of a maker's catalogue in place of those of the geometry: lives follow with the power of the load, and the text states the difference.
#[test]
fn ratings_of_the_maker() {
    let plain = lubricated("6205", "method = \"oil-bath\"");
    let given = plain.clone() + "dynamic_rating = \"14.8 kN\"\nstatic_rating = \"7.8 kN\"\n";
    let life = |scene: &str| solved(scene, &["--load", "2000,0,0,0,0"])["bearings"][0]["life"].clone();
    let (of_geometry, of_maker) = (life(&plain), life(&given));
    assert_eq!((number(&of_maker, "/dynamic_rating"), number(&of_maker, "/static_rating")), (14_800.0, 7800.0));
    assert_eq!(number(&of_maker, "/geometry_ratings/0"), number(&of_geometry, "/dynamic_rating"));
    let ratio = 14_800.0 / number(&of_geometry, "/dynamic_rating");
    for kind in ["/basic_life", "/reference_life"] {
        assert!((number(&of_maker, kind) / number(&of_geometry, kind) / ratio.powi(3) - 1.0).abs() < 1e-9, "{kind}");
    }
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", given);
    let text = sandbox.done(&["equilibrium", "scene.toml", "--load", "2000,0,0,0,0"]).out;
    assert!(text.contains("C 14.80 kN, C0 7.80 kN, as given; the geometry gives C 1"), "{text}");
}

/// At the temperatures found, the friction of this equilibrium leaves by shaft, housing and oil; they are those of the network by hand.
#[test]
fn heat_that_arises_is_heat_that_leaves() {
    let more = "elements = \"1 W/K\", seat = \"30 W/K\", oil_flow = \"0.1 l/min\", oil_inlet = \"25 degC\"";
    let with_oil = SPINDLE.replace("elements = \"1 W/K\"", more);
    for scene in [SPINDLE.to_owned(), with_oil] {
        let found = solved(&scene, &["--thermal"]);
        for i in 0..2 {
            let of = |key: &str| number(&found, &format!("/bearings/{i}/{key}"));
            let [shaft, housing, oil] =
                ["through_shaft", "through_housing", "with_oil"].map(|key| of(&format!("temperatures/{key}")));
            let power = of("friction/power");
            assert!(((shaft + housing + oil) / power - 1.0).abs() < 1e-3, "{found}");
            let [inner, outer, walls] =
                ["inner", "outer", "housing"].map(|key| of(&format!("temperatures/{key}")) - 273.15);
            assert!((shaft - 4.0 * (inner - 22.0)).abs() < 1e-6 && (housing - 10.0 * (walls - 22.0)).abs() < 1e-6);
            // The inner ring has half of the heat less what the elements and the oil take.
            let carried = if scene.contains("oil_flow") { 0.1e-3 / 60.0 * 1.67e6 } else { 0.0 };
            let balance = shaft + (inner - outer) + 0.5 * carried * (inner - 25.0);
            assert!((balance / (0.5 * power) - 1.0).abs() < 1e-3, "{balance} {power}");
            // Clearance and viscosity are those of these temperatures.
            let lost = of("operating_clearance/by_temperature_um");
            assert!((lost - 12e-6 * 65e3 * (inner - outer)).abs() < 0.01, "{lost}");
            assert!((of("friction/temperature") - 273.15 - 0.5 * (inner + outer)).abs() < 0.01);
        }
        // Without the option the rings have the temperatures of the scene.
        let cold = solved(&scene, &[]);
        // Ratings are those of the bearing as delivered, whatever the clearance that the rings leave.
        for rating in ["dynamic_rating", "static_rating"] {
            let of = |found: &Value| number(found, &format!("/bearings/0/life/{rating}"));
            assert!((of(&found) / of(&cold) - 1.0).abs() < 1e-9, "{rating}");
        }
        assert!(
            number(&cold, "/bearings/0/friction/temperature") == 303.15
                && cold.pointer("/bearings/0/temperatures").is_none()
        );
    }
}

/// A locked preload grows with the speed and runs away; that of a spring stays. What is set at standstill does not depend on the speed.
#[test]
fn a_locked_preload_runs_away() {
    let sandbox = Sandbox::empty();
    sandbox.put("locked.toml", SPINDLE);
    let over = "shaft.speed=3000rpm..15000rpm:4";
    let table = |scene: &str| {
        let args = ["equilibrium", scene, "--thermal", "--over", over, "--format", "json", "--report", "r.html"];
        let all: Value = sandbox.done(&args).json();
        all["points"].as_array().unwrap().clone()
    };
    let locked = table("locked.toml");
    let force = |point: &Value| number(point, "/bearings/0/1/0");
    assert!(force(&locked[1]) > 1.5 * force(&locked[0]) && force(&locked[2]) > 1.5 * force(&locked[1]), "{locked:?}");
    let reason = locked[3]["failure"].as_str().unwrap();
    assert!(reason.contains("no steady temperature") && reason.contains("the preload runs away"), "{reason}");
    sandbox.put("springs.toml", SPINDLE.replace("unmounted", "operating"));
    let springs = table("springs.toml");
    assert!((force(&springs[3]) / force(&springs[0]) - 1.0).abs() < 0.05, "{springs:?}");
    let page = sandbox.read("r.html");
    assert!(page.contains("Temperature of the inner ring") && page.contains("Reference life L10r"));
    sandbox.refused(
        &["equilibrium", "locked.toml", "--thermal", "--over", "shaft.speed=14000rpm,15000rpm"],
        1,
        &["no equilibrium at any of 2 points"],
    );
}

/// The preload of springs at a speed at which the balls lie at the bottom of the outer groove: the solver finds the displacement that carries it.
#[test]
fn a_light_preload_at_a_high_speed() {
    let scene = SPINDLE.replace("unmounted", "operating");
    for rpm in [16_000, 17_000, 18_000, 20_000, 25_000, 30_000] {
        let found = solved(&swap(&scene, "9000 rpm", &format!("{rpm} rpm")), &["--bearing", "rear"]);
        let force = number(&found, "/bearings/0/force/2");
        assert!((force + 150.0).abs() < 1e-3, "{rpm}: {force}");
    }
}

#[test]
fn wrong_lubrication_and_cooling_are_one_error_each() {
    for (from, to, expected) in [
        ("viscosity_100 = \"4.3 mm^2/s\"", "viscosity_100 = \"54 mm^2/s\"", "below 22 mm^2/s, that at 40 degC"),
        ("\"oil-mist\"", "\"oil\"", "lubrication.method: invalid value: \"oil\""),
        ("\"22 mm^2/s\"", "\"0.04 Pa s\"", "lubrication.viscosity_40: invalid value"),
        ("contamination = 0.8", "contamination = 2", "a number above 0 and at most 1"),
        ("ambient = \"22 degC\"", "ambient = 22", "cooling.ambient: invalid value: 22"),
        ("shaft = \"4 W/K\"", "shaft = \"4 W\"", "a conductance from 0 to 1e4 W/K"),
        ("elements = \"1 W/K\"", "oil_flow = \"1 l/min\"", "cooling.oil_inlet: missing key"),
        ("temperatures = { inner = \"30 degC\", outer = \"30 degC\" }\n", "", "lubrication.temperature: missing key"),
        ("shaft = \"4 W/K\", housing = \"10 W/K\"", "shaft = 0, housing = 0", "a way for the heat of each ring"),
        (
            "shaft = \"4 W/K\", housing = \"10 W/K\", elements = \"1 W/K\"",
            "shaft = 0, housing = \"10 W/K\"",
            "a way for the heat of each ring",
        ),
    ] {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", SPINDLE.replacen(from, to, 1));
        sandbox.refused(&["equilibrium", "scene.toml", "--thermal"], 2, &[expected]);
    }
    let sandbox = Sandbox::empty();
    let without: String =
        SPINDLE.lines().filter(|line| !line.starts_with("cooling")).map(|line| format!("{line}\n")).collect();
    sandbox.put("scene.toml", &without);
    sandbox.refused(&["equilibrium", "scene.toml", "--thermal"], 2, &["no bearing with cooling"]);
    let cooling_alone: String =
        SPINDLE.lines().filter(|line| !line.starts_with("lubrication")).map(|line| format!("{line}\n")).collect();
    sandbox.put("scene.toml", cooling_alone);
    sandbox.refused(&["check", "scene.toml"], 2, &["cooling: misplaced key", "only with lubrication and temperatures"]);
    let seats = swap(SPINDLE, "shaft = \"4 W/K\", housing = \"10 W/K\", elements", "elements");
    assert!(number(&solved(&seats, &["--thermal"]), "/bearings/0/temperatures/inner") > 300.0, "seats of ISO 15312");
}

/// Heat without enough cooling, a bearing whose ratings are not known, too many points.
#[test]
fn what_has_no_temperatures_or_figures_says_why() {
    let sandbox = Sandbox::empty();
    let warm = "temperatures = { inner = \"30 degC\", outer = \"30 degC\" }\n";
    let weak = "cooling = { ambient = \"20 degC\", shaft = \"0.01 W/K\", housing = \"0.01 W/K\" }\n";
    let hot = lubricated("6309", "method = \"oil-jet\", f1 = 0.1") + warm + weak + "model = \"lumped\"\n";
    sandbox.put("hot.toml", swap(&hot, "temperature = \"40 degC\", ", ""));
    let load = ["--load", "5000,0,0,0,0"];
    sandbox.refused(
        &[&["equilibrium", "hot.toml", "--thermal"], &load[..]].concat(),
        1,
        &["expected one below 250 degC"],
    );
    let law = "elements = 9\nmodel = \"lumped\"\nstiffness = 1e10\nradial_play = 0\ncage_ratio = 0.4\n\
               inner_raceway_diameter = \"31 mm\"\nouter_raceway_diameter = \"47 mm\"\n";
    sandbox.put(
        "law.toml",
        swap(&hot, "bearing = \"6309\"\n", law)
            .replace("model = \"lumped\"\n", "")
            .replace("elements = 9\n", "elements = 9\nmodel = \"lumped\"\n"),
    );
    sandbox.refused(
        &[&["equilibrium", "law.toml", "--thermal"], &load[..]].concat(),
        2,
        &["no friction: its ratings are not known"],
    );
    sandbox.put("spindle.toml", SPINDLE);
    let over = ["--over", "shaft.speed=1000rpm..9000rpm:1000", "--over", "bearing.front.preload.force=100N..200N:1000"];
    sandbox.refused(
        &[&["equilibrium", "spindle.toml"], &over[..]].concat(),
        2,
        &["too many points: 1000 x 1000, expected at most 100000"],
    );
}
