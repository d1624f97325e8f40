//! A flexible rotor on the command line: `equilibrium` and `campbell` with their pages.

use serde_json::Value;

use crate::support::{Sandbox, list, number};

/// A shaft from 100 mm to 600 mm with a disk, on two ball bearings.
fn scene() -> String {
    let bearing = |name: &str, station: f64| {
        format!(
            "[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nfacing = \"both\"\nmodel = \"angular\"\nelements = 8\n\
             ball_diameter = \"12.3 mm\"\npitch_diameter = \"52 mm\"\ninner_conformity = 0.52\nouter_conformity = 0.525\n\
             diametral_clearance = \"5 um\"\n"
        )
    };
    format!(
        "name = \"pump\"\n[shaft]\nspeed = \"3000 rpm\"\n[rotor]\n\
         sections = [{{ from = \"100 mm\", to = \"600 mm\", outer_diameter = \"30 mm\", inner_diameter = \"10 mm\" }}]\n\
         disks = [{{ station = \"250 mm\", outer_diameter = \"150 mm\", width = \"30 mm\" }}]\n\
         proportional_damping = {{ mass = \"60 1/s\", stiffness = \"2e-6 s\" }}\nload = [0, 0, 60, 0, 0]\n\
         unbalance = [{{ moment = \"200 g mm\", angle = \"30 deg\", station = \"250 mm\" }}]\n{}{}",
        bearing("DE", 130.0),
        bearing("NDE", 570.0)
    )
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene());
    sandbox
}

#[test]
fn equilibrium_states_rotor_reduction_and_bending() {
    let sandbox = sandbox();
    let outcome: Value =
        sandbox.done(&["equilibrium", "scene.toml", "--report", "page.html", "--format", "json"]).json();
    let steel = 7800.0 * std::f64::consts::FRAC_PI_4;
    let (shaft, disk) =
        (steel * (0.03_f64.powi(2) - 0.01_f64.powi(2)) * 0.5, steel * (0.15_f64.powi(2) - 0.03_f64.powi(2)) * 0.03);
    let centre = (350.0 * shaft + 250.0 * disk) / (shaft + disk);
    assert!((number(&outcome, "/rotor/mass_kg") / (shaft + disk) - 1.0).abs() < 0.01);
    assert!((number(&outcome, "/rotor/centre_of_mass_mm") - centre).abs() < 0.5);
    assert!(number(&outcome, "/rotor/diametral_inertia_kg_m2") > number(&outcome, "/rotor/polar_inertia_kg_m2"));
    let coordinates =
        ["coordinates", "finite_element_coordinates"].map(|key| number(&outcome, &format!("/rotor/{key}")));
    assert!(coordinates[0] >= 7.0 && coordinates[1] > coordinates[0], "{coordinates:?}");
    for key in ["frequency", "deflection", "response"] {
        let error = number(&outcome, &format!("/rotor/{key}_error_percent"));
        assert!((0.0..5.0).contains(&error), "{key}: {error} %");
    }
    let bending: Vec<&Value> =
        list(&outcome, "effect_significance").iter().filter(|need| need["effect"] == "bending").collect();
    assert_eq!(bending.len(), 2, "one for each bearing");
    assert!(bending.iter().all(|need| need["modelled"] == true && need["change"].as_f64().unwrap() > 0.0));
    let page = sandbox.page("page.html");
    for there in ["Mode shapes at 3000 rpm", "centre of mass", "DE, 130.0 mm", "NDE, 570.0 mm", "200 g mm, 30°"] {
        assert!(page.contains(there), "{there}");
    }
    let text = sandbox.done(&["equilibrium", "scene.toml"]).out;
    for there in ["Rotor:", "Reduced model:", "bending: first bending frequency on the bearings"] {
        assert!(text.contains(there), "{there} is not in\n{text}");
    }
}

#[test]
fn campbell_draws_diagram_mode_shapes_and_rotor() {
    let sandbox = sandbox();
    sandbox.done(&["campbell", "scene.toml", "--speeds", "0rpm..6000rpm:3", "--report", "page.html"]);
    let page = sandbox.page("page.html");
    assert_eq!(page.matches("<svg").count(), 3);
    for there in ["Campbell diagram", "Mode shapes at 3000 rpm", "Station Z, mm"] {
        assert!(page.contains(there), "{there}");
    }
}

/// The page of a rigid rotor has a bar and no mode shapes.
#[test]
fn a_rigid_rotor_is_a_bar() {
    let sandbox = Sandbox::rig();
    sandbox.done(&["campbell", "scene.toml", "--speeds", "3000rpm,6000rpm", "--report", "page.html"]);
    let page = sandbox.page("page.html");
    assert!(page.contains("Not to scale") && !page.contains("Mode shapes"));
    let outcome: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    assert!(outcome.get("rotor").is_none());
}

/// A shaft with an overhung disk, at `rpm`; `more` are further lines of the rotor.
fn overhung(rpm: u32, more: &str) -> Sandbox {
    let bearing = |name: &str, station: f64, [x, y]: [&str; 2]| {
        format!(
            "[[bearing]]\nname = \"{name}\"\nstation = {station}\nmodel = \"linear\"\nelements = 9\nstiffness_matrix = \
             [[{x}, 0, 0, 0, 0], [0, {y}, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]\n"
        )
    };
    let sandbox = Sandbox::empty();
    sandbox.put(
        "scene.toml",
        format!(
            "name = \"overhung\"\n[shaft]\nspeed = \"{rpm} rpm\"\n[rotor]\nsections = [\n\
             {{ from = 0, to = 0.7, outer_diameter = 0.040 }},\n{{ from = 0.7, to = 0.9, outer_diameter = 0.030 }},\n]\n\
             disks = [\n{{ station = 0.35, mass = 15, diametral_inertia = 0.06, polar_inertia = 0.115 }},\n\
             {{ station = 0.88, mass = 6, diametral_inertia = 0.018, polar_inertia = 0.034 }},\n]\n\
             youngs_modulus = 211e9\npoissons_ratio = 0.3\ndensity = 7810\ngravity = [0, 0, 0]\n{more}\n\
             proportional_damping = {{ stiffness = 2e-5 }}\n\
             unbalance = [{{ moment = \"100 g mm\", angle = \"30 deg\", station = 0.35 }}]\n{}{}",
            bearing("a", 0.05, ["2e7", "3e7"]),
            bearing("b", 0.65, ["5e7", "4e7"])
        ),
    );
    sandbox
}

/// An overhung disk turns about its diameter: the reduction is within its stated error at speed, with the gyroscopic effect, and every
/// command states the error.
#[test]
fn a_rotor_with_an_overhung_disk_is_reduced_by_its_error_at_speed() {
    let sandbox = overhung(2400, "");
    let few: Value = sandbox.done(&["campbell", "scene.toml", "--speeds", "2400rpm", "--format", "json"]).json();
    assert!(number(&few, "/0/rotor/frequency_error_percent") <= 0.5, "{}", few[0]["rotor"]);
    assert!(number(&few, "/0/rotor/coordinates") > 15.0, "{}", few[0]["rotor"]);
    let fast: Value = sandbox.done(&["campbell", "scene.toml", "--speeds", "12000rpm", "--format", "json"]).json();
    let finest = overhung(2400, "coordinates = 31");
    let many: Value =
        finest.done(&["campbell", "scene.toml", "--speeds", "2400rpm,12000rpm", "--format", "json"]).json();
    // Overdamped pairs of many coordinates are no whirl.
    let whirling = |found: &Value| -> Vec<f64> {
        let modes = list(found, "modes").iter().filter(|mode| number(mode, "/damping_ratio") < 0.9);
        modes.map(|mode| number(mode, "/frequency_hz")).take(6).collect()
    };
    for (few, many) in [(&few[0], &many[0]), (&fast[0], &many[1])] {
        for (few, many) in whirling(few).iter().zip(whirling(many)) {
            assert!((few / many - 1.0).abs() < 5e-3, "{few} {many} Hz");
        }
    }
    for arguments in [
        &["campbell", "scene.toml", "--speeds", "2400rpm"][..],
        &["check", "scene.toml"],
        &["simulate", "scene.toml", "--duration", "1 ms", "--rate", "10 kHz", "--output", "r.csv"],
    ] {
        let text = sandbox.done(arguments).out;
        assert!(text.contains("Reduced model: "), "{arguments:?}: {text}");
        assert!(!text.contains("by more than allowed"), "{arguments:?}: {text}");
    }
}

/// Too few coordinates are named with their error.
#[test]
fn too_few_coordinates_are_a_warning() {
    let sandbox = overhung(2400, "coordinates = 9");
    for arguments in [
        &["campbell", "scene.toml", "--speeds", "2400rpm"][..],
        &["check", "scene.toml"],
        &["equilibrium", "scene.toml"],
        &["simulate", "scene.toml", "--duration", "1 ms", "--rate", "10 kHz", "--output", "r.csv"],
    ] {
        let text = sandbox.done(arguments).out.replace('\n', " ");
        assert!(text.contains("The reduced rotor of 9 coordinates differs"), "{arguments:?}: {text}");
    }
}
