use std::f64::consts::{PI, TAU};

use super::*;

fn assert_is(text: &str, dimension: Dimension, wanted: f64) {
    let value = parse(text, dimension).unwrap();
    assert!((value - wanted).abs() <= 1e-12 * wanted.abs(), "{text}: {value} is not {wanted}");
}

#[test]
#[rustfmt::skip] // a table
fn units_of_the_scene_format() {
    use Dimension::*;
    for (text, dimension, wanted) in [
        ("12.7 mm", Length, 12.7e-3),
        ("5 um", Length, 5e-6),
        ("5 \u{b5}m", Length, 5e-6),
        ("5\u{3bc}m", Length, 5e-6),
        ("-1 mil", Length, -25.4e-6),
        ("2.5e-3 m", Length, 2.5e-3),
        ("2 in", Length, 0.0508),
        ("40 deg", Angle, 40.0 * PI / 180.0),
        ("-90\u{b0}", Angle, -PI / 2.0),
        ("0.25 turn", Angle, PI / 2.0),
        ("3000 rpm", Speed, 100.0 * PI),
        ("+314 rad/s", Speed, 314.0),
        ("50 rev/s", Speed, 100.0 * PI),
        ("3000 r/min", Speed, 100.0 * PI),
        ("30 g mm", Unbalance, 30e-6),
        ("30 g\u{b7}mm", Unbalance, 30e-6),
        ("30 g*mm", Unbalance, 30e-6),
        ("30 gmm", Unbalance, 30e-6),
        ("0.04 Pa s", Viscosity, 0.04),
        ("32 mm^2/s", KinematicViscosity, 32e-6),
        ("32 cSt", KinematicViscosity, 32e-6),
        ("2.2e-8 1/Pa", PressureViscosity, 2.2e-8),
        ("2.2e-8 /Pa", PressureViscosity, 2.2e-8),
        ("2.2e-8 Pa^-1", PressureViscosity, 2.2e-8),
        ("22 1/GPa", PressureViscosity, 22e-9),
        ("25.6 kHz", Frequency, 25.6e3),
        ("400 N s/m", Damping, 400.0),
        ("0.4 N s/mm", Damping, 400.0),
        ("0.4 N m s/rad", AngularDamping, 0.4),
        ("0.4 N m s", AngularDamping, 0.4),
        ("0.4 Nm s", AngularDamping, 0.4),
        ("1 N m/rad", AngularStiffness, 1.0),
        ("1 N m", AngularStiffness, 1.0),
        ("1 N m/deg", AngularStiffness, 180.0 / PI),
        ("7 N/rad", CrossStiffness, 7.0),
        ("7 N", CrossStiffness, 7.0),
        ("1e8 N/m", Stiffness, 1e8),
        ("0.1 kN/um", Stiffness, 1e8),
        ("0.030 kg m^2", Inertia, 0.030),
        ("0.030 kg m\u{b2}", Inertia, 0.030),
        ("206 GPa", Pressure, 206e9),
        ("206000 N/mm^2", Pressure, 206e9),
        ("9.81 m/s^2", Acceleration, 9.81),
        ("9.81 m s^-2", Acceleration, 9.81),
        ("7.8 g/cm^3", Density, 7800.0),
        ("2 s", Time, 2.0),
        ("6 kg", Mass, 6.0),
        ("60 N", Force, 60.0),
        ("-9.5 V", Voltage, -9.5),
        ("7.87 mV/um", Sensitivity, 7870.0),
        ("7.87 V/mm", Sensitivity, 7870.0),
        ("200 mV/mil", Sensitivity, 0.2 / 25.4e-6),
        ("2 Nm", Moment, 2.0),
        ("1.2e10 N/m^1.5", ContactStiffness(1.5), 1.2e10),
        ("1 N/mm^1.5", ContactStiffness(1.5), 1000f64.powf(1.5)),
        ("1 kN/mm^1.5", ContactStiffness(1.5), 1000f64.powf(2.5)),
        ("1 N mm^-1.5", ContactStiffness(1.5), 1000f64.powf(1.5)),
        ("1 N/mm^1.111", ContactStiffness(10.0 / 9.0), 1000f64.powf(10.0 / 9.0)),
        ("5 N/m", ContactStiffness(1.0), 5.0),
    ] {
        assert_is(text, dimension, wanted);
    }
}

fn refusal(text: &str, dimension: Dimension) -> String {
    parse(text, dimension).unwrap_err().to_string()
}

#[test]
fn wrong_dimension_reports_the_value_found_and_the_values_expected() {
    assert_eq!(
        refusal("40 deg", Dimension::Length),
        "invalid value: \"40 deg\" (an angle), expected a length, such as \"12.7 mm\" or \"5 um\""
    );
    assert_eq!(
        refusal("50 Hz", Dimension::Speed),
        "invalid value: \"50 Hz\" (a frequency), expected a speed of rotation, such as \"3000 rpm\" \
         (rpm, rev/s or rad/s; Hz is not taken)"
    );
    assert!(refusal("3000 1/min", Dimension::Speed).contains("a frequency"));
    assert!(refusal("3000 rpm", Dimension::Frequency).contains("a speed of rotation"));
    assert!(refusal("1 g", Dimension::Acceleration).contains("a mass"));
    assert!(refusal("1 N m/rad", Dimension::Moment).contains("a stiffness of rotation"));
    assert!(refusal("1 kg m^3", Dimension::Mass).contains("a quantity in m^3 kg"));
    assert!(refusal("1 m/m", Dimension::Mass).contains("a number without dimension"));
    assert!(refusal("1 1", Dimension::Mass).contains("a number without dimension"));
}

#[test]
fn contact_stiffness_requires_the_exponent_of_its_law() {
    assert_eq!(
        refusal("1 N/m^1.111", Dimension::ContactStiffness(1.5)),
        "invalid value: \"1 N/m^1.111\" (a contact stiffness in N/m^1.111), expected a contact stiffness in N/m^1.5 \
         (the exponent is 1.5), such as \"1.2e10 N/m^1.5\""
    );
    assert!(refusal("1 N/m", Dimension::ContactStiffness(1.5)).contains("(a stiffness),"));
    assert!(refusal("1 N/m^1.12", Dimension::ContactStiffness(10.0 / 9.0)).contains("1.1111"));
}

#[test]
fn text_that_is_no_quantity_is_refused() {
    let length = |text| refusal(text, Dimension::Length);
    assert!(length("").contains("does not start with a number"));
    assert!(length("mm").contains("does not start with a number"));
    assert!(length("nan mm").contains("does not start with a number"));
    assert!(length("inf mm").contains("does not start with a number"));
    assert!(length(". mm").contains("does not start with a number"));
    assert!(length("12").contains("has no unit"));
    assert!(length("12,7 mm").contains("comma"));
    assert!(length("12 bananas").contains("\"bananas\" is no known unit"));
    assert!(length("12 MM").contains("did you mean \"mm\"?"));
    assert!(length("12 m/s/s").contains("more than one \"/\""));
    assert!(length("12 m/").contains("nothing follows"));
    assert!(length("12 m^").contains("not by a power"));
    assert!(length("12 m^nan").contains("not by a power"));
    assert!(length("12 m^1e9").contains("not by a power"));
    assert!(length("1e999 mm").contains("too large"));
    assert!(length("5 e").contains("\"e\" is no known unit"));
    let long = format!("1 {}", "x".repeat(1000));
    assert!(length(&long).len() < 300);
    assert!(!length("1 m\nm").contains('\n'));
}

#[test]
fn columns_of_recordings() {
    assert!((length_column("um").unwrap() - 1e-6).abs() < 1e-20);
    assert!((length_column("\u{b5}m").unwrap() - 1e-6).abs() < 1e-20);
    assert!((length_column("mil").unwrap() - 25.4e-6).abs() < 1e-18);
    assert!((length_column("mm").unwrap() - 1e-3).abs() < 1e-17);
    assert_eq!(length_column("m"), Ok(1.0));
    assert!((speed_column("rpm").unwrap() - TAU / 60.0).abs() < 1e-15);
    assert_eq!(speed_column("rad/s"), Ok(1.0));
    let hertz = speed_column("Hz").unwrap_err().to_string();
    assert_eq!(hertz, "invalid value: \"Hz\" (a frequency), expected a unit of speed of rotation: rpm, rev/s or rad/s");
    assert!(length_column("").is_err());
    assert!(length_column("V").is_err());
    assert!(length_column("1").is_err());
    assert!(length_column("mm/s").is_err());
}

#[test]
fn units_of_files_against_the_scene() {
    for (said, meant) in
        [("um", "mm"), ("m/s^2", "g"), ("mm/s", "m/s"), ("Pa", "N"), ("s", "um"), ("N", "V"), ("ms", "s")]
    {
        assert!(contradict(said, meant), "{said} {meant}");
    }
    let same = [("\u{b5}m", "um"), (" mils", "mil"), ("m/s\u{b2}", "m/s^2"), ("g", "g"), ("rev/min", "rpm")];
    let unknown = [("", "um"), ("V", "um"), ("Furlong", "mm"), ("V", "V")];
    for (said, meant) in same.into_iter().chain(unknown) {
        assert!(!contradict(said, meant), "{said} {meant}");
    }
    assert_eq!(
        [1e-6, 25.4e-6, 1e-3, 1.0, 0.123].map(length_name),
        [Some("um"), Some("mil"), Some("mm"), Some("m"), None]
    );
    assert_eq!(speed_name(1.0), Some("rad/s"));
    assert_eq!(speed_name(speed_column("rpm").unwrap()), Some("rpm"));
}

#[test]
fn every_name_is_unique_and_every_example_reads() {
    let atoms = UNITS;
    for (i, (name, factor, _)) in atoms.iter().enumerate() {
        assert!(factor.is_finite() && *factor > 0.0);
        assert!(atoms.iter().skip(i + 1).all(|(other, ..)| other != name));
    }
    for dimension in FIXED {
        let row = dimension.row();
        assert!(parse(row.example, dimension).is_ok(), "{}", row.example);
        assert!(parse(&format!("1 {}", row.si), dimension) == Ok(1.0), "{}", row.si);
    }
}
