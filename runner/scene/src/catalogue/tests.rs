use super::*;
use std::collections::HashSet;

#[test]
fn entries_are_complete_and_distinct() {
    let mut seen = HashSet::new();
    let reference = include_str!("../../../../docs/src/scene.md");
    assert!(reference.contains(&format!("The catalogue has {} bearings", all().len())), "{}", all().len());
    for entry in all() {
        let name = entry.designation;
        assert!(seen.insert(name), "{name} twice");
        assert!(entry.bore < entry.pitch_diameter && entry.pitch_diameter < entry.outer_diameter, "{entry:?}");
        let mean = 0.5 * (entry.bore + entry.outer_diameter);
        assert!((entry.pitch_diameter / mean - 1.0).abs() < 0.06, "{name}: pitch diameter far from {mean}");
        assert!(entry.element_diameter < 0.5 * (entry.outer_diameter - entry.bore), "{entry:?}");
        // The elements fit on the pitch circle.
        let circle = std::f64::consts::PI * entry.pitch_diameter;
        assert!(entry.elements >= 3 && entry.elements as f64 * entry.element_diameter < circle, "{entry:?}");
        assert!(!entry.source.is_empty(), "{name}");
        let inclined = [BearingKind::AngularContact, BearingKind::TaperedRoller, BearingKind::SphericalRoller];
        assert_eq!(entry.contact_angle > 0.0, inclined.contains(&entry.kind), "{name}");
        assert_eq!(entry.roller_length.is_some(), entry.kind.rollers().is_some(), "{name}");
    }
}

/// The frequencies that makers publish are those of the geometry.
#[test]
fn published_frequencies() {
    let mut checked = 0;
    for entry in all() {
        let Some(published) = &entry.published else {
            assert_ne!(entry.status, Provenance::Derived, "{}: derived from nothing", entry.designation);
            continue;
        };
        let orders = entry.orders();
        let pairs = [
            (published.cage, orders.cage),
            (published.outer_race, orders.outer_race),
            (published.inner_race, orders.inner_race),
            (published.ball_spin, orders.ball_spin),
        ];
        for (maker, own) in pairs.into_iter().filter_map(|(maker, own)| Some((maker?, own))) {
            // Makers print three or four digits.
            assert!((own / maker - 1.0).abs() < 3e-3, "{}: {own}, {} has {maker}", entry.designation, published.source);
            checked += 1;
        }
    }
    assert!(checked >= 100, "{checked}");
}

#[test]
fn designations() {
    for (text, entry, class) in [
        ("6205", "6205", ClearanceClass::Normal),
        ("SKF 6205-2RS1/C3", "6205", ClearanceClass::C3),
        ("6205 2Z C4", "6205", ClearanceClass::C4),
        ("fag 6309 CN", "6309", ClearanceClass::Normal),
        ("7206 BEP", "7206B", ClearanceClass::Normal),
        ("FAG 7206-B-XL-TVP", "7206B", ClearanceClass::Normal),
        ("SKF 7206 ACD", "7206A5", ClearanceClass::Normal),
        ("7206A", "7206A", ClearanceClass::Normal),
        ("NJ 206 ECP/C3", "NU206", ClearanceClass::C3),
        ("N206", "NU206", ClearanceClass::Normal),
        ("NSK 6805ZZ", "61805", ClearanceClass::Normal),
        ("61805", "61805", ClearanceClass::Normal),
        ("SKF 32008 X/Q", "32008", ClearanceClass::Normal),
        ("22210 EK/C3", "22210", ClearanceClass::C3),
        ("HK 2020", "HK2020", ClearanceClass::Normal),
    ] {
        let listed = find(text).unwrap();
        assert_eq!((listed.entry.designation, listed.class), (entry, class), "{text}");
    }
    for text in ["", "62", "62055", "x6205", "7206", "NU", "\u{1b}[31m6205"] {
        assert!(find(text).is_err(), "{text}");
    }
    assert!(find("6399").unwrap_err().to_string().contains("ballrace new --list"));
}

#[test]
fn clearance_of_the_classes() {
    // ISO 5753-1 as makers print it, bore 25 mm: C2 1 to 11, normal 5 to 20, C3 13 to 28 um.
    let middle = |designation: &str| {
        let keys = scene_keys(&find(designation).unwrap());
        keys.into_iter().find(|key| key.key == "diametral_clearance").unwrap().value
    };
    assert_eq!(middle("6205"), "\"12.5 um\"");
    assert_eq!(middle("6205 C2"), "\"6.0 um\"");
    assert_eq!(middle("6205 C3"), "\"20.5 um\"");
}

#[test]
fn every_entry_gives_a_scene() {
    use crate::read::read_str;
    for entry in all() {
        let text = format!(
            "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nstation = 0\nbearing = \"{}\"\n",
            entry.designation
        );
        let scene = read_str(&text, std::path::Path::new("listed.toml")).unwrap();
        assert_eq!(scene.bearings[0].elements, entry.elements, "{}", entry.designation);
        if let Some(kind) = entry.kind.rollers() {
            let text = text.clone() + "model = \"roller\"\n";
            let scene = read_str(&text, std::path::Path::new("rollers.toml")).unwrap();
            let rollers = scene.bearings[0].rollers.as_ref().unwrap();
            assert_eq!(rollers.kind, kind, "{}", entry.designation);
            // Both models have the same length of the rollers, but for the digits of the stiffness.
            let law = scene.bearings[0].law.unwrap();
            assert!((rollers.length * 1e3 - entry.roller_length.unwrap()).abs() < 0.006, "{}", entry.designation);
            assert!(law.radial_play.unwrap() > 0.0 || rollers.contact_angle > 0.0, "{}", entry.designation);
        }
    }
}

/// The designation of a cylindrical-roller bearing gives rollers by laminae, and a line contact where the scene names it or a key of it.
#[test]
fn cylindrical_rollers_are_laminae_unless_the_scene_has_a_line_contact() {
    use crate::Model;
    use crate::read::read_str;
    let axial = "axial = { stiffness = 1e9, play = 0, radius = \"15 mm\" }";
    for (keys, model) in [
        ("", Model::Roller),
        ("stiffness = 4e8", Model::Roller),
        ("model = \"quasi-static\"", Model::QuasiStaticRoller),
        ("model = \"lumped\"", Model::Lumped),
        (axial, Model::Lumped),
        ("exponent = 1.1", Model::Lumped),
    ] {
        let text = format!("shaft.speed = 100\n[[bearing]]\nname = \"A\"\nbearing = \"NU205\"\n{keys}\n");
        let scene = read_str(&text, std::path::Path::new("nu.toml")).unwrap();
        assert_eq!(scene.bearings[0].model, model, "{keys}");
    }
}
