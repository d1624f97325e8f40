//! Fits, temperatures and temperature channels.

use super::*;
use crate::Ring;

const STEEL: &str = "fit = { shaft_interference = \"10 um\", bore = \"30 mm\", outside_diameter = \"72 mm\" }";
const WARM: &str = "temperatures = { inner = \"60 degC\", outer = \"45 degC\" }";

fn mounted(keys: &str) -> String {
    MINIMAL.replace("contact_angle = \"15 deg\"", &format!("diametral_clearance = \"20 um\"\n{keys}"))
}

fn clearance(keys: &str) -> f64 {
    read(&mounted(keys)).unwrap().bearings[0].clearance().unwrap() * 1e6
}

/// Raceways of 40 and 60 mm.
#[test]
fn operating_clearance() {
    assert!((clearance("") - 20.0).abs() < 1e-9);
    assert!((clearance(STEEL) - (20.0 - 10.0 * 30.0 / 40.0)).abs() < 1e-9);
    // 12e-6 1/K, pitch diameter of 50 mm, 15 K.
    assert!((clearance(WARM) - 11.0).abs() < 1e-9);
    assert!((clearance(&format!("{STEEL}\n{WARM}")) - 3.5).abs() < 1e-9);
    assert!((clearance(&WARM.replace("60 degC", "140 degF").replace("45 degC", "318.15 K")) - 11.0).abs() < 1e-9);
    let ceramic = WARM.replace(" }", ", expansion = \"6e-6 1/K\" }");
    assert!((clearance(&ceramic) - 15.5).abs() < 1e-9);
    let given = format!("{STEEL}\ninner_raceway_diameter = \"38 mm\"");
    assert!((clearance(&given) - (20.0 - 10.0 * 30.0 / 38.0)).abs() < 1e-9);
}

/// A contact angle of 15 degrees is a clearance of 34.1 um, from which the fit takes 7.5 um.
#[test]
fn a_fit_changes_the_contact_angle() {
    let free = read(MINIMAL).unwrap().bearings[0].geometry.unwrap();
    let tight =
        read(&MINIMAL.replace("15 deg\"", &format!("15 deg\"\n{STEEL}"))).unwrap().bearings[0].geometry.unwrap();
    assert!((free.clearance() - tight.clearance() - 7.5e-6).abs() < 1e-12);
    assert!(matches!(tight.fit, FreeAngle::ContactAngle(angle) if (angle.to_degrees() - 13.237).abs() < 0.01));
}

/// Bore and outside diameter of a bearing of the catalogue.
#[test]
fn the_catalogue_has_the_fit_diameters() {
    let scene = "[shaft]\nspeed = 1\n[[bearing]]\nname = \"A\"\nbearing = \"6205\"\nstation = 0\n\
                 fit = { shaft_interference = \"5 um\" }\n";
    let mounting = read(scene).unwrap().bearings[0].mounting.unwrap();
    let diameters = mounting.fits.unwrap().map(|fit| fit.diameter);
    assert!((diameters[0] - 25e-3).abs() < 1e-12 && (diameters[1] - 52e-3).abs() < 1e-12, "{diameters:?}");
    let growth = 5e-6 * 25e-3 / mounting.raceways[0];
    assert!((mounting.operating().by_fits - growth).abs() < 1e-15);
}

#[test]
#[rustfmt::skip] // a table
fn fits_and_temperatures_out_of_range() {
    let text = mounted(&format!("{STEEL}\n{WARM}"));
    assert_refused(&text, &[
        ("shaft_interference = \"10 um\", ", "", &["bearing[0].fit.shaft_interference: missing key", "or housing_interference"]),
        ("\"10 um\"", "\"10 mm\"", &["fit.shaft_interference: invalid value: \"10 mm\"", "of at most 0.30 mm; negative is a loose fit"]),
        ("\"10 um\"", "\"10 um\", tolerance = \"k6\"", &["fit.tolerance"]),
        ("bore = \"30 mm\", ", "", &["bearing[0].fit.bore: missing key", "above 0 and below the inner raceway (40.00 mm)"]),
        ("\"30 mm\"", "\"40 mm\"", &["bearing[0].fit.bore: invalid value: \"40 mm\"", "below the inner raceway (40.00 mm)"]),
        ("\"72 mm\"", "\"60 mm\"", &["bearing[0].fit.outside_diameter: invalid value: \"60 mm\"", "above the outer raceway (60.00 mm)"]),
        ("\"72 mm\"", "\"72 mm\", shaft_bore = \"31 mm\"", &["fit.shaft_bore: invalid value", "below the bore of the bearing (30.00 mm)"]),
        ("\"72 mm\"", "\"72 mm\", housing_diameter = \"70 mm\"", &["fit.housing_diameter: invalid value", "above the outside diameter of the bearing (72.00 mm)"]),
        ("\"72 mm\"", "\"72 mm\", housing_interference = 1", &["fit.housing_interference: invalid value: 1"]),
        ("\"72 mm\"", "\"72 mm\", shaft_material = { youngs_modulus = 0 }", &["shaft_material.youngs_modulus", "a pressure above 0"]),
        ("\"72 mm\"", "\"72 mm\", shaft_material = { poissons_ratio = 0.5 }", &["shaft_material.poissons_ratio", "below 0.5"]),
        ("\"72 mm\"", "\"72 mm\", housing_material = { expansion = \"23 um\" }", &["housing_material.expansion: invalid value: \"23 um\", expected a linear expansion from 0 to 1e-4 1/K"]),
        ("inner = \"60 degC\", ", "", &["bearing[0].temperatures.inner: missing key"]),
        ("\"60 degC\"", "60", &["temperatures.inner: invalid value: 60, expected a temperature with its unit, such as \"60 degC\""]),
        ("\"60 degC\"", "\"60 C\"", &["temperatures.inner: invalid value: \"60 C\""]),
        ("\"45 degC\"", "\"45 degC\", assembled = \"-300 degC\"", &["temperatures.assembled: invalid value"]),
        ("\"60 degC\"", "\"90 degC\"", &["operating clearance of -14.5 um", "20.0 um before mounting, less 7.5 um by the fits and 27.0 um by temperature"]),
        ("fit =", "inner_raceway_diameter = \"70 mm\"\nfit =", &["inner_raceway_diameter: invalid value: \"70 mm\"", "larger than the inner one (70.00 mm)"]),
    ]);
    let alone = refusal(&mounted("inner_raceway_diameter = \"40 mm\""));
    assert!(alone.contains("inner_raceway_diameter: misplaced key") && alone.contains("only with fit or temperatures"), "{alone}");
}

#[test]
#[rustfmt::skip] // a table
fn temperature_channels_out_of_range() {
    let channel = "temperature = [{ column = \"T\", unit = \"degC\", bearing = \"A\", ring = \"outer\" }]\n";
    let text = format!("{}{RECORDING}{channel}", mounted(WARM));
    let channels = read(&text).unwrap().recording.unwrap().temperatures;
    assert!(channels.len() == 1 && channels[0].ring == Ring::Outer && (channels[0].zero - 273.15).abs() < 1e-12);
    assert_refused(&text, &[
        (channel, "temperature = []\n", &["recording.temperature: invalid value: [], expected a list of at least one temperature"]),
        ("\"degC\"", "\"C\"", &["temperature[0].unit: invalid value: \"C\", expected the unit of the column: degC, K or degF"]),
        ("bearing = \"A\"", "bearing = \"B\"", &["temperature[0].bearing: invalid value: \"B\", expected the name of a [[bearing]]"]),
        ("ring = \"outer\"", "ring = \"cage\"", &["temperature[0].ring: invalid value: \"cage\""]),
        ("column = \"T\"", "column = \"x\"", &["a column of its own (a probe has this one)"]),
        (WARM, "", &["temperature[0].bearing: invalid value: \"A\", expected a bearing with temperatures"]),
    ]);
    let twice = text.replace("ring = \"outer\" }]", "ring = \"outer\" }, { column = \"U\", unit = \"K\", bearing = \"A\", ring = \"outer\" }]");
    assert!(refusal(&twice).contains("one temperature of each ring"), "{}", refusal(&twice));
    let sensors = text.replace("probes = [{ column = \"x\", unit = \"um\", station = 0, angle = 0 }]", "sensors = [{ column = \"x\", unit = \"g\" }]");
    assert!(refusal(&sensors).contains("recording.temperature: misplaced key"), "{}", refusal(&sensors));
}
