//! A flexible rotor on the command line: `equilibrium` and `campbell` with their pages.

use serde_json::Value;

use crate::support::{Desk, list, number};

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

fn desk() -> Desk {
    let desk = Desk::empty();
    desk.put("scene.toml", scene());
    desk
}

#[test]
fn equilibrium_states_rotor_reduction_and_bending() {
    let desk = desk();
    let outcome: Value = desk.done(&["equilibrium", "scene.toml", "--report", "page.html", "--format", "json"]).json();
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
    let page = desk.page("page.html");
    for there in ["Mode shapes at 3000 rpm", "centre of mass", "DE, 130.0 mm", "NDE, 570.0 mm", "200 g mm, 30°"] {
        assert!(page.contains(there), "{there}");
    }
    let text = desk.done(&["equilibrium", "scene.toml"]).out;
    for there in ["Rotor:", "Reduced model:", "bending: first bending frequency on the bearings"] {
        assert!(text.contains(there), "{there} is not in\n{text}");
    }
}

#[test]
fn campbell_draws_diagram_mode_shapes_and_rotor() {
    let desk = desk();
    desk.done(&["campbell", "scene.toml", "--speeds", "0rpm..6000rpm:3", "--report", "page.html"]);
    let page = desk.page("page.html");
    assert_eq!(page.matches("<svg").count(), 3);
    for there in ["Campbell diagram", "Mode shapes at 3000 rpm", "Station Z, mm"] {
        assert!(page.contains(there), "{there}");
    }
}

/// The page of a rigid rotor has a bar and no mode shapes.
#[test]
fn a_rigid_rotor_is_a_bar() {
    let desk = Desk::rig();
    desk.done(&["campbell", "scene.toml", "--speeds", "3000rpm,6000rpm", "--report", "page.html"]);
    let page = desk.page("page.html");
    assert!(page.contains("Not to scale") && !page.contains("Mode shapes"));
    let outcome: Value = desk.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    assert!(outcome.get("rotor").is_none());
}
