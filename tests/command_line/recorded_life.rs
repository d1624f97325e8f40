//! Ratings and life of the bearings in the outcome of `replay`, beside those of `equilibrium`.

use serde_json::Value;

use crate::support::{Sandbox, list, number};

/// A rotor on a ball bearing without clearance and on a bearing whose contacts are not known, under a constant load.
fn scene(load: &str, more: &str) -> String {
    let probe = |name: &str, station: &str, angle: u32| {
        format!(
            "  {{ column = \"{name}\", unit = \"um\", station = \"{station}\", angle = \"{angle} deg\", noise = \"0.05 um\" }},\n"
        )
    };
    let probes =
        [probe("AX", "-120 mm", 0), probe("AY", "-120 mm", 90), probe("BX", "120 mm", 0), probe("BY", "120 mm", 90)];
    format!(
        "[shaft]\nspeed = \"1500 rpm\"\n[rotor]\nmass = \"12 kg\"\ndiametral_inertia = 0.05\npolar_inertia = 0.02\n\
         damping = [4000, 4000, 400, 4, 4]\nstiffness = [0, 0, \"1e6 N/m\", 0, 0]\nload = [0, \"-{load}\", 0, 0, 0]\n{more}\n\
         [[bearing]]\nname = \"A\"\nstation = \"-100 mm\"\nfacing = \"both\"\nbearing = \"6205\"\nmodel = \"lumped\"\nradial_play = 0\n\
         lubrication = {{ method = \"oil-bath\", viscosity_40 = \"68 mm^2/s\", viscosity_100 = \"8.7 mm^2/s\", temperature = \"60 degC\", \
         contamination = 0.5 }}\n\
         [[bearing]]\nname = \"B\"\nstation = \"100 mm\"\nfacing = \"both\"\nmodel = \"lumped\"\nelements = 13\nstiffness = 5.4e8\n\
         exponent = 1.1111\nradial_play = 0\ncage_ratio = 0.4\n\
         [recording]\nfile = \"recorded.csv\"\nrate = \"12.8 kHz\"\nprobes = [\n{}]\nkeyphasor = {{ column = \"key\", pulses_per_turn = 1 }}\n",
        probes.concat()
    )
}

/// Returns the life of bearing A in `equilibrium` and in `replay` of a recording of 0.5 s of the same machine, and the sandbox.
fn lives(load: &str, more: &str) -> ([Value; 2], Sandbox) {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene(load, more));
    let simulate = ["simulate", "scene.toml", "--as-recording", "-o", "recorded.csv"];
    sandbox.done(&[&simulate[..], &["--duration", "0.5 s", "--settle", "0.3 s"]].concat());
    let settled: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    let outcome = sandbox.replay("scene.toml", &[]);
    assert!(list(&outcome, "bearings")[1]["life"].is_null(), "{outcome}");
    let of = |outcome: &Value| list(outcome, "bearings")[0]["life"].clone();
    ([of(&settled), of(&outcome)], sandbox)
}

fn assert_close(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() < share, "{found} instead of {expected}");
}

/// A shaft at rest in its bearings has the life of the equilibrium, a life of ISO 281 in hours at 25 turns a second.
#[test]
fn a_constant_load_has_the_life_of_the_equilibrium() {
    let ([settled, recorded], sandbox) = lives("4 kN", "");
    let hours = |life: &str| number(&settled, life) * 1e6 / 25.0 / 3600.0;
    for (found, expected) in [
        ("/reference_life_h", hours("/reference_life")),
        ("/basic_life_h", hours("/basic_life")),
        ("/modified_life_h", hours("/modified/life")),
        ("/equivalent_load_n", number(&settled, "/equivalent_load")),
        ("/reference_load_n", number(&settled, "/reference_load")),
        ("/modification_factor", number(&settled, "/modified/factor")),
        ("/viscosity_ratio", number(&settled, "/modified/viscosity_ratio")),
    ] {
        assert_close(number(&recorded, found), expected, 0.01);
    }
    for rating in ["dynamic_rating", "static_rating"] {
        let found = number(&recorded, &format!("/{rating}_n"));
        assert_close(found, number(&settled, &format!("/{rating}")), 1e-12);
    }
    // With the weight of the rotor, 117.68 N, twice the load: without clearance an eighth of the life of balls.
    let ([_, twice], _) = lives("8117.68 N", "");
    assert_close(number(&recorded, "/reference_life_h") / number(&twice, "/reference_life_h"), 8.0, 0.01);

    let text = sandbox.done(&["replay", "scene.toml", "--report", "page.html"]).out;
    let page = sandbox.read("page.html");
    assert!(page.contains("<h2>Ratings and life</h2>"), "{text}");
    let table = text.split("RATINGS AND LIFE").nth(1).unwrap().split("For 90 %").next().unwrap();
    assert!(table.contains("a_ISO") && table.contains("\n  A "), "{text}");
    assert!(!table.contains("\n  B "), "{text}");
}

/// A load that turns with the shaft adds to the constant one: the mean of its power 3 is above the power of the mean.
#[test]
fn the_life_falls_with_the_mean_power_of_the_load() {
    let more = "unbalance = [{ moment = \"40000 g mm\", angle = 0, station = \"-100 mm\" }]";
    let ([settled, recorded], _) = lives("4 kN", more);
    // The turning force of the unbalance U is U W^2, at bearing A alone.
    let (constant, turning) = (number(&settled, "/equivalent_load"), 0.04 * (25.0 * std::f64::consts::TAU).powi(2));
    let samples = (0..360).map(|i| {
        let (sin, cos) = f64::from(i).to_radians().sin_cos();
        (constant + turning * sin).hypot(turning * cos).powi(3)
    });
    let expected = (samples.sum::<f64>() / 360.0).cbrt();
    assert!(expected > 1.1 * constant, "{expected} {constant}");
    assert_close(number(&recorded, "/equivalent_load_n"), expected, 0.01);
}
