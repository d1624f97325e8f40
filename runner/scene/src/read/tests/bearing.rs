//! Accepted and rejected keys of one `[[bearing]]`.

use super::*;
use crate::model::choice_of;
use crate::{RollerKind, RollerProfile};

#[test]
#[rustfmt::skip] // a table
fn angular_bearing_out_of_range() {
    let angle = "contact_angle = \"15 deg\"";
    assert_refused(MINIMAL, &[
        ("name = \"A\"", "", &["bearing[0].name: missing key"]),
        ("model = \"angular\"", "", &["bearing[0].model", &choice_of(Model::with_forces()), "because of inner_conformity; for vibration alone no model"]),
        ("model = \"angular\"", "model = \"anguler\"", &["invalid value: \"anguler\", expected \"linear\" or ", " or \"angular\" or "]),
        ("elements = 8", "elements = 2", &["invalid value: 2, expected a whole number from 3 to 64"]),
        ("elements = 8", "elements = 65", &["from 3 to 64"]),
        ("elements = 8", "elements = 8.0", &["invalid value: 8.0, expected a whole number"]),
        ("elements = 8", "elements = 16", &["invalid value: 16, expected 3 to 15: more balls"]),
        ("pitch_diameter = \"50 mm\"", "pitch_diameter = \"10 mm\"", &["invalid value: \"10 mm\"", "above ball_diameter (10 mm)"]),
        ("pitch_diameter = \"50 mm\"", "pitch_diameter = \"11 mm\"", &["not even 3"]),
        ("pitch_diameter = \"50 mm\"", "", &["bearing[0].pitch_diameter", "missing here: pitch_diameter)"]),
        ("ball_diameter = \"10 mm\"", "ball_diameter = \"-10 mm\"", &["a length above 0"]),
        ("ball_diameter = \"10 mm\"", "ball_diameter = [1]", &["invalid value: [1], expected a length above 0"]),
        ("inner_conformity = 0.52", "inner_conformity = 0.5", &["above 0.5"]),
        ("inner_conformity = 0.52", "inner_conformity = 1.1", &["at most 1"]),
        ("inner_conformity = 0.52", "inner_conformity = nan", &["invalid value: nan"]),
        ("inner_conformity = 0.52", "inner_conformity = \"0.52\"", &["invalid value: \"0.52\""]),
        (angle, "contact_angle = 15", &["invalid value: 15 (a bare number is in rad)", "from 0 to 60 deg"]),
        (angle, "contact_angle = \"-1 deg\"", &["from 0 to 60 deg"]),
        (angle, "", &["neither contact_angle nor diametral_clearance", "exactly one"]),
        (angle, "contact_angle = 0\ndiametral_clearance = 0", &[":13: bearing[0].diametral_clearance: both contact_angle and"]),
        (angle, "diametral_clearance = \"-1 um\"", &["from 0 to below 500 um", "only with model = \"lumped\""]),
        (angle, "diametral_clearance = \"0.5001 mm\"", &["from 0 to below 500 um"]),
        (angle, "contact_angle = 0\nyoungs_modulus = 0", &["a pressure above 0"]),
        (angle, "contact_angle = 0\npoissons_ratio = 0.5", &["below 0.5"]),
        (angle, "contact_angle = 0\ndensity = 0", &["a density above 0"]),
        (angle, "contact_angle = 0\ncage_ratio = 1", &["below 1 (cage speed / shaft speed)"]),
        (angle, "contact_angle = 0\ncage_ratio = -0.1", &["0 or more"]),
        (angle, "contact_angle = 0\nfacing = \"up\"", &["\"+z\" or \"-z\" or \"both\""]),
        (angle, "contact_angle = 0\nfirst_element_azimuth = \"1 m\"", &["(a length), expected an angle"]),
        (angle, "contact_angle = 0\nstiffness = 1e9", &["bearing[0].stiffness", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\nexponent = 1.5", &["bearing[0].exponent", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\nradial_play = 0", &["bearing[0].radial_play", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\naxial = {}", &["bearing[0].axial", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\nouter_ring = {}", &["outer_ring", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\nhousing_displacement = []", &["housing_displacement", "only with model = \"lumped\""]),
        (angle, "contact_angle = 0\nlinearise = \"angular\"", &["only with model = \"linear\""]),
    ]);
    let bare = MINIMAL.lines().take(7).collect::<Vec<_>>().join("\n");
    assert!(refusal(&bare).contains(
        "missing here: ball_diameter, pitch_diameter, inner_conformity, outer_conformity)"
    ));
    let steepest = read(&with(MINIMAL, angle, "contact_angle = \"60 deg\"")).unwrap();
    let fit = steepest.bearings.first().unwrap().geometry.unwrap().fit;
    assert!(matches!(fit, FreeAngle::ContactAngle(angle) if angle <= FRAC_PI_3 && near(angle, FRAC_PI_3)));
    assert!(read(&with(MINIMAL, angle, "diametral_clearance = 0")).is_ok());
    assert!(read(&with(MINIMAL, "elements = 8", "elements = 15")).is_ok());
}

#[test]
#[rustfmt::skip] // a table
fn lumped_bearing_out_of_range() {
    let play = "radial_play = \"5 um\"";
    assert_refused(LUMPED, &[
        ("stiffness = 1e10\n", "", &["bearing[0].stiffness: missing key", "or the geometry"]),
        ("stiffness = 1e10", "stiffness = 0", &["invalid value: 0 (a bare number is in N/m^1.5)", "above 0 in N/m^1.5"]),
        ("stiffness = 1e10", "stiffness = \"1e10 N/m\"", &["(a stiffness), expected a contact stiffness in N/m^1.5"]),
        (play, "", &["bearing[0].radial_play: missing key", "half the diametral clearance"]),
        (play, "radial_play = 0\nexponent = 0.9", &["invalid value: 0.9, expected 1 to 3"]),
        (play, "radial_play = 0\nexponent = 3.1", &["1 to 3"]),
        (play, "radial_play = 0\nexponent = 1.111\nstiffness_matrix = 3", &["only with model = \"linear\""]),
        ("cage_ratio = 0.4", "", &["bearing[0].cage_ratio", "without geometry it must be given (0 for elements at rest)"]),
        (play, "radial_play = 0\naxial = { stiffness = 1 }", &["bearing[0].axial.play: missing key"]),
        (play, "radial_play = 0\naxial = { stiffness = 1, play = 0, radius = -1 }", &["axial.radius", "of 0 or more"]),
        (play, "radial_play = 0\naxial = { stiffness = -1, play = 0, radius = 1 }", &["axial.stiffness"]),
        (play, "radial_play = 0\naxial = { exponent = 4, stiffness = 1, play = 0, radius = 1 }", &["axial.exponent"]),
        (
            play,
            "radial_play = 0\nouter_ring = { radius = \"50 mm\", width = \"18 mm\", thickness = \"30 mm\" }",
            &["outer_ring.thickness", "\"30 mm\"", "at most 20 mm"],
        ),
        (
            play,
            "radial_play = 0\nouter_ring = { radius = 1, width = 1, thickness = 0.1 }\nhousing_displacement = []",
            &["outer_ring", "not together with housing_displacement"],
        ),
        (play, "radial_play = 0\nhousing_displacement = [[0, 0, 0]]", &["housing_displacement: a list of 1", "a list of 8 entries [x, y, z]"]),
        (play, "radial_play = 0\nyoungs_modulus = 1", &["missing here: ball_diameter, pitch"]),
    ]);
    let housing = format!("{LUMPED}housing_displacement = [{}]\n", "[\"1 um\", 0, 0],".repeat(8));
    let bearing = read(&housing).unwrap().bearings.remove(0);
    assert_eq!(bearing.housing_displacement, vec![[1.0 * 1e-6, 0.0, 0.0]; 8]);
    assert!(refusal(&with(&housing, "[\"1 um\", 0, 0]", "[0, 0]")).contains("housing_displacement[0]: a list of 2"));
    assert!(read(&with(LUMPED, "cage_ratio = 0.4", "cage_ratio = 0")).is_ok());
    let roller = with(LUMPED, "stiffness = 1e10", "exponent = 1.1111\nstiffness = \"1 N/mm^1.111\"");
    let law = read(&roller).unwrap().bearings.remove(0).law.unwrap();
    assert!(near(law.stiffness.unwrap(), 1000f64.powf(1.1111)));
}

#[test]
fn lumped_bearing_from_geometry() {
    let lumped = with(MINIMAL, "\"angular\"", "\"lumped\"");
    let clearance = with(&lumped, "contact_angle = \"15 deg\"", "diametral_clearance = \"-8 um\"");
    let bearing = read(&clearance).unwrap().bearings.remove(0);
    assert_eq!((bearing.law, bearing.cage_ratio), (None, None));
    assert!(refusal(&lumped).contains("bearing[0].radial_play: missing key"));
    assert!(read(&format!("{lumped}radial_play = 0\n")).is_ok());
    assert!(read(&format!("{clearance}radial_play = 0\nstiffness = 1e9\n")).is_ok());
    let roller = format!("{clearance}exponent = 1.111\n");
    assert!(refusal(&roller).contains("exponent: invalid value: 1.111, expected 1.5, as the stiffness"));
    assert!(read(&format!("{roller}stiffness = 1e9\n")).is_ok());
    let too_tight = with(&clearance, "-8 um", "-8 mm");
    assert!(refusal(&too_tight).contains("between -500 um and 500 um"));
}

#[test]
#[rustfmt::skip] // a table
fn linear_bearing() {
    let linear = with(MINIMAL, "\"angular\"", "\"linear\"\nlinearise = \"angular\"");
    let named = "linearise = \"angular\"";
    let matrix = "stiffness_matrix = [[\"1 kN/mm\", 0, 0, 0, \"2 N/rad\"], [0, 1, 0, 3, 0], [0, 0, 1, 0, 0], [0, 3, 0, 1, 0], [2, 0, 0, 0, 1]]";
    let source = |text: &str| read(&with(&linear, named, text)).map(|mut s| s.bearings.remove(0).linear.unwrap());
    assert_eq!(source(named), Ok(Linear::Of(Model::Angular)));
    assert_eq!(source("two_spring = { static_load = \"500 N\" }"), Ok(Linear::TwoSpring { static_load: 500.0 }));
    let Linear::Matrix(read_matrix) = source(matrix).unwrap() else { unreachable!("a matrix") };
    assert!(near(read_matrix[0][0], 1e6));
    assert_eq!(read_matrix[4], [2.0, 0.0, 0.0, 0.0, 1.0]);
    assert_refused(&linear, &[
        (named, "", &["bearing[0]: model = \"linear\" with none of", "exactly one of stiffness_matrix"]),
        (named, "linearise = \"angular\"\ntwo_spring = { static_load = 1 }", &[": 2 of stiffness_matrix, two_spring, linearise"]),
        (named, "linearise = \"linear\"", &["\"angular\" or \"lumped\""]),
        (named, "linearise = \"dynamic\"", &["invalid value: \"dynamic\", expected \"angular\" or \"lumped\" or \"quasi-static\""]),
        (named, "linearise = \"lumped\"", &["bearing[0].radial_play"]),
        (named, "two_spring = { static_load = 0 }", &["two_spring.static_load", "a force above 0"]),
        (named, "two_spring = 3", &["two_spring: invalid value: 3, expected a table with the keys static_load"]),
        (named, "stiffness_matrix = [[1]]", &[": a list of 1, expected 5 rows of 5"]),
        (named, "stiffness_matrix = 1", &["invalid value: 1, expected 5 rows of 5"]),
        (named, "stiffness_matrix = [1, 2, 3, 4, 5]", &["stiffness_matrix[0]: invalid value: 1"]),
        (named, &matrix.replace("2 N/rad", "2 N/m"), &["stiffness_matrix[0][4]", "a force per angle"]),
        (named, "linearise = \"angular\"\nstiffness = 1", &["only with model = \"lumped\""]),
        (named, "linearise = \"angular\"\ndefect = []", &["bearing[0].defect", "only with a model that has rolling elements"]),
    ]);
    let sprung = with(&linear, named, "two_spring = { static_load = 500 }");
    assert_refused(&sprung, &[("elements = 8", "elements = 7", &["bearing[0].elements: invalid value: 7, expected 8 to 16 with two_spring"])]);
    let bare = "[shaft]\nspeed = 1\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"linear\"\nelements = 8\n";
    assert!(read(&format!("{bare}{matrix}\n")).is_ok());
    assert!(refusal(&format!("{bare}two_spring = {{ static_load = 1 }}\n")).contains("missing here: ball_diameter"));
}

#[test]
#[rustfmt::skip] // a table
fn supports_spacing_and_cage() {
    let text = format!(
        "{MINIMAL}support = {{ mass = \"2 kg\", stiffness_x = 1e8, stiffness_y = 4e8, stiffness_xy = 1e7, damping = 200 }}\n\
         element_azimuths = [0, 1, 2, 3, 4, 5, 5.5, 6]\ncage_runout = {{ offset = \"5 um\", angle = \"90 deg\" }}\n"
    );
    let bearing = read(&text).unwrap().bearings.remove(0);
    let support = Support { mass: 2.0, stiffness: [1e8, 4e8], cross_stiffness: 1e7, damping: 200.0 };
    assert_eq!(bearing.support, Some(support));
    assert_eq!(bearing.element_azimuths[6], 5.5);
    let cage = bearing.cage_runout.unwrap();
    assert!(near(cage.offset, 5e-6) && near(cage.radius, 0.025));
    assert_refused(&text, &[
        ("stiffness_xy = 1e7", "stiffness_xy = 3e8", &["support.stiffness_xy: invalid value: 3e8", "below 200000000 N/m in size"]),
        ("mass = \"2 kg\"", "mass = 0", &["support.mass", "above 0"]),
        ("damping = 200", "dampin = 200", &["support.dampin: unknown key (did you mean damping?)"]),
        ("[0, 1, 2, 3, 4, 5, 5.5, 6]", "[0, 1]", &["element_azimuths: a list of 2, expected a list of 8 angles"]),
        ("\"5 um\"", "\"5 mm\"", &["cage_runout.offset", "below a tenth of the elements' circle (0.025 m)"]),
        ("support", "element_damping = 1\nsupport", &["element_damping: misplaced key: 1, expected only with model = \"dynamic\""]),
    ]);
}

#[test]
#[rustfmt::skip] // a table
fn moving_elements_and_integration() {
    let text = with(MINIMAL, "contact_angle = \"15 deg\"", "diametral_clearance = \"5 um\"\nelement_damping = 30");
    let text = with(&text, "\"angular\"", "\"dynamic\"")
        + "[integration]\nmethod = \"newmark\"\nstep = \"10 us\"\nnewton_steps = 4\n";
    let scene = read(&text).unwrap();
    assert_eq!((scene.bearings[0].model, scene.bearings[0].own("element_damping")), (Model::Dynamic, Some(30.0)));
    assert_eq!(scene.integration.method, Method::Newmark { newton_steps: 4 });
    assert!(near(scene.integration.step.unwrap(), 1e-5));
    assert_refused(&text, &[
        ("element_damping = 30", "waviness = []", &["waviness: misplaced key: []", "none with model = \"dynamic\""]),
        ("\"newmark\"", "\"verlet\"", &["integration.newton_steps: misplaced key: 4, expected only with method = \"newmark\""]),
        ("\"newmark\"", "\"euler\"", &["invalid value: \"euler\", expected \"runge-kutta\" or \"newmark\" or \"verlet\""]),
        ("step = \"10 us\"", "step = 0", &["integration.step", "above 0"]),
    ]);
}

#[test]
#[rustfmt::skip] // a table
fn surfaces() {
    let defect = "defect = [{ surface = \"outer\", azimuth = 0, half_width = 0.1, depth = 1e-6, shape = \"rectangular\" }]";
    assert_refused(&format!("{MINIMAL}{defect}\n"), &[
        ("\"outer\"", "\"outer\", element = 1", &["defect[0].element: invalid value: 1, expected the number of the damaged ball, 1 to 8, only with surface = \"ball\""]),
        ("\"outer\"", "\"ball\", element = 9", &["invalid value: 9, expected the number of the damaged ball, 1 to 8"]),
        ("\"outer\"", "\"outside\"", &["invalid value: \"outside\", expected \"inner\" or \"outer\" or \"ball\""]),
        ("\"rectangular\"", "\"round\"", &["\"half-sine\" or \"rectangular\""]),
        ("half_width = 0.1", "half_width = 0", &["above 0 and at most 180 deg"]),
        ("half_width = 0.1", "half_width = 3.2", &["above 0 and at most 180 deg"]),
        ("depth = 1e-6", "depth = 0", &["a length above 0"]),
        (", shape = \"rectangular\"", "", &["defect[0].shape: missing key"]),
        ("depth = 1e-6", "deep = 1e-6", &["defect[0].deep: unknown key"]),
    ]);
    let wave = "waviness = [{ surface = \"inner\", order = 13, amplitude = \"0.1 um\" }]";
    assert_refused(&format!("{MINIMAL}{wave}\n"), &[
        ("order = 13", "order = 0", &["waviness[0].order: invalid value: 0, expected a whole number from 1 to 10000"]),
        ("\"inner\"", "\"ball\", direction = \"axial\"", &["waviness[0].direction: invalid value: \"axial\", expected \"radial\""]),
        ("\"0.1 um\"", "0", &["a length above 0"]),
        ("order = 13, ", "", &["waviness[0].order: missing key"]),
    ]);
}

#[test]
#[rustfmt::skip] // a table
fn effects_and_preload() {
    let text = with(MINIMAL, "\"angular\"", "\"quasi-static\"");
    let full = format!("{text}effects = [\"centrifugal\", \"gyroscopic\", \"film\"]\nrace_control = \"inner\"\n\
        friction_sharing = \"proportional\"\nlubricant = {{ viscosity = \"0.04 Pa s\", pressure_viscosity = \"2.2e-8 1/Pa\" }}\n\
        preload = {{ force = \"500 N\" }}\n");
    let bearing = &read(&full).unwrap().bearings[0];
    assert!(bearing.effects.centrifugal && bearing.effects.gyroscopic && bearing.effects.film.is_some());
    assert_eq!(bearing.preload.map(|preload| preload.amount), Some(crate::PreloadAmount::Force(500.0)));
    assert_refused(&full, &[
        ("\"gyroscopic\"", "\"centrifugal\"", &["effects[1]: repeated value: \"centrifugal\", expected each effect once"]),
        ("\"gyroscopic\"", "\"gyroskopic\"", &["effects[1]: invalid value: \"gyroskopic\""]),
        ("race_control = \"inner\"", "race_control = \"both\"", &["\"outer\" or \"inner\""]),
        ("viscosity = \"0.04 Pa s\"", "viscosity = \"0.04 Pa\"", &["lubricant.viscosity"]),
        ("{ force = \"500 N\" }", "{ force = \"500 N\", displacement = 0 }", &["preload: invalid value: { force", "exactly one of"]),
        ("{ force = \"500 N\" }", "{}", &["exactly one of"]),
        ("\"quasi-static\"", "\"angular\"", &["only with model = \"quasi-static\" or \"tabulated\"; remove it"]),
    ]);
}

#[test]
fn tilt_of_the_outer_ring() {
    let tilted = MINIMAL.to_owned() + "outer_ring_tilt = [\"1 mrad\", \"-0.5 mrad\"]\n";
    assert_eq!(read(&tilted).unwrap().bearings[0].outer_ring_tilt, [1e-3, -0.5e-3]);
    assert_refused(
        &tilted,
        &[
            ("\"-0.5 mrad\"", "\"-0.5 mm\"", &["outer_ring_tilt", "(a length), expected an angle"]),
            (", \"-0.5 mrad\"", "", &["outer_ring_tilt", "a list of 2 angles: about X and about Y"]),
        ],
    );
    let lumped = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nmodel = \"lumped\"\nelements = 8\ncage_ratio = 0.4\nstiffness = 1e9\nexponent = 1.5\nradial_play = 0\nouter_ring_tilt = [0, 0]\n";
    let why = refusal(lumped);
    assert!(
        why.contains("outer_ring_tilt") && why.contains("only with model = \"angular\"") && why.contains("remove it"),
        "{why}"
    );
}

/// A bearing without model, by its diameters and by the orders of a data sheet.
const DIAMETERS: &str = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nelements = 9\nball_diameter = \"7.94 mm\"\n\
                         pitch_diameter = \"39.04 mm\"\ncontact_angle = \"0 deg\"\n";
const ORDERS: &str = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\n\
                      orders = { outer = 3.585, inner = 5.415, element = 2.357, cage = 0.398 }\n";

#[test]
fn bearings_without_model_have_orders() {
    let of = |text: &str| {
        let bearing = read(text).unwrap().bearings.remove(0);
        assert_eq!((bearing.model, bearing.elements, bearing.station), (Model::Kinematics, 9, 0.0));
        assert!(bearing.geometry.is_none() && !bearing.model.has_forces());
        bearing.kinematics.unwrap().orders(bearing.elements)
    };
    let (computed, given) = (of(DIAMETERS), of(ORDERS));
    for (computed, given) in [
        (computed.outer_race, given.outer_race),
        (computed.inner_race, given.inner_race),
        (computed.ball_spin, given.ball_spin),
        (computed.cage, given.cage),
    ] {
        assert!((computed - given).abs() < 1e-3, "{computed} {given}");
    }
    let rollers = with(DIAMETERS, "ball_diameter", "roller_diameter");
    assert_eq!(of(&rollers), computed);
    of(&with(ORDERS, "name", "elements = 9\nname"));
    // A thrust angle of 40 degrees: the spin falls with its cosine.
    let angled = of(&with(DIAMETERS, "contact_angle = \"0 deg\"", "contact_angle = \"40 deg\""));
    let text = format!(
        "orders = {{ outer = {}, inner = {}, element = {}, cage = {} }}\n",
        angled.outer_race, angled.inner_race, angled.ball_spin, angled.cage
    );
    assert!(
        (of(&format!("{}{text}", ORDERS.lines().take(4).map(|line| format!("{line}\n")).collect::<String>()))
            .ball_spin
            - angled.ball_spin)
            .abs()
            < 1e-12
    );
}

#[test]
#[rustfmt::skip] // a table
fn bearings_without_model_that_are_none() {
    let angle = "contact_angle = \"0 deg\"\n";
    assert_refused(DIAMETERS, &[
        (angle, "", &["bearing[0].contact_angle: missing key", "missing here: contact_angle)", "or orders"]),
        ("ball_diameter", "# ball_diameter", &["bearing[0].ball_diameter: missing key"]),
        ("elements = 9", "elements = 16", &["invalid value: 16, expected 3 to 15"]),
        ("name", "roller_diameter = \"8 mm\"\nname", &["roller_diameter: misplaced key", "either ball_diameter or roller_diameter"]),
        ("pitch_diameter = \"39.04 mm\"", "pitch_diameter = \"7 mm\"", &["above ball_diameter (7.94 mm)"]),
        (angle, "contact_angle = \"0 deg\"\ninner_conformity = 0.52\n", &["bearing[0].model: missing key", "because of inner_conformity"]),
        (angle, "diametral_clearance = \"5 um\"\n", &["bearing[0].model: missing key", "because of diametral_clearance"]),
        (angle, "contact_angle = \"0 deg\"\ndefect = []\n", &["bearing[0].model: missing key", "because of defect"]),
        (angle, "contact_angle = \"0 deg\"\norders = {}\n", &["ball_diameter: misplaced key", "not together with orders"]),
        (angle, "contact_angle = \"0 deg\"\nmodel = \"kinematics\"\n", &["invalid value: \"kinematics\", expected \"linear\""]),
        (angle, "contact_angle = \"0 deg\"\nmodel = \"lumped\"\nroller_diameter = \"8 mm\"\n", &["ball_diameter: misplaced key", "not with rollers"]),
        (angle, "contact_angle = \"0 deg\"\n[rotor]\nmass = 1\ndiametral_inertia = 1\npolar_inertia = 1\n", &["bearing[0].station: missing key"]),
    ]);
    assert_refused(ORDERS, &[
        ("outer = 3.585", "outer = 3.7", &["bearing[0].orders: invalid value: outer + inner = 9.115", "a whole number from 3 to 64"]),
        ("outer = 3.585, inner = 5.415", "outer = 5.415, inner = 3.585", &["outer = 5.415, inner = 3.585, expected outer below inner"]),
        ("cage = 0.398", "cage = 0.602", &["cage = 0.602, expected 0.398, which is outer over 9 elements"]),
        ("element = 2.357", "element = 4.714", &["element = 4.714, expected 1.179 to 2.357", "(BSF)"]),
        ("element = 2.357, ", "", &["bearing[0].orders.element: missing key"]),
        ("element = 2.357", "ball = 2.357", &["bearing[0].orders.ball: unknown key"]),
        ("name", "elements = 8\nname", &["outer + inner = 9.000 with elements = 8"]),
        ("name", "cage_ratio = 0.4\nname", &["cage_ratio: misplaced key", "not together with orders"]),
        ("name", "bearing = \"6205\"\nname", &["orders: misplaced key", "only without model and bearing"]),
    ]);
}

const ROLLERS: &str = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nmodel = \"roller\"\nkind = \"tapered\"\nelements = 17\n\
                       roller_diameter = \"7.5 mm\"\nroller_length = \"15 mm\"\npitch_diameter = \"54 mm\"\ncontact_angle = \"14 deg\"\n";

#[test]
fn rollers_take_their_defaults_and_the_models_of_rollers() {
    let tapered = read(ROLLERS).unwrap();
    let bearing = tapered.bearings.first().unwrap();
    let rollers = bearing.rollers.as_ref().unwrap();
    assert_eq!((bearing.model, rollers.kind, rollers.laminae), (Model::Roller, RollerKind::Tapered, 30));
    assert_eq!(rollers.profile, RollerProfile::Logarithmic(0.000_45 * 7.5e-3));
    let law = bearing.law.unwrap();
    assert_eq!(law.radial_play, Some(0.0));
    // K = 35 948 L^(8/9) N/mm^(10/9), L in mm.
    assert!(near(law.stiffness.unwrap(), 35_948.0 * 15_f64.powf(8.0 / 9.0) * 1000_f64.powf(10.0 / 9.0)));

    let radial = with(ROLLERS, "contact_angle = \"14 deg\"", "diametral_clearance = \"10 um\"");
    let cylindrical = with(&radial, "kind = \"tapered\"\n", "");
    let solved = with(&cylindrical, "model = \"roller\"", "model = \"quasi-static\"\neffects = [\"centrifugal\"]");
    let line = with(&cylindrical, "model = \"roller\"", "model = \"lumped\"\nprofile = [0, \"1 um\"]");
    for (text, model) in [(cylindrical, Model::Roller), (solved, Model::QuasiStaticRoller), (line, Model::Lumped)] {
        let scene = read(&text).unwrap();
        let bearing = scene.bearings.first().unwrap();
        assert_eq!((bearing.model, bearing.rollers.as_ref().unwrap().kind), (model, RollerKind::Cylindrical));
        assert!(near(bearing.law.unwrap().radial_play.unwrap(), 5e-6));
        assert_eq!(bearing.law.unwrap().exponent, 10.0 / 9.0);
    }
}

#[test]
#[rustfmt::skip] // a table
fn rollers_out_of_range() {
    let angle = "contact_angle = \"14 deg\"";
    assert_refused(ROLLERS, &[
        ("kind = \"tapered\"", "kind = \"round\"", &["kind: invalid value: \"round\", expected \"cylindrical\" or \"needle\""]),
        ("roller_diameter = \"7.5 mm\"", "", &["roller_diameter: missing key, expected a length above 0"]),
        ("roller_diameter = \"7.5 mm\"", "roller_diameter = \"60 mm\"", &["pitch_diameter: invalid value", "above roller_diameter (60 mm)"]),
        ("roller_length = \"15 mm\"", "", &["roller_length: missing key"]),
        ("roller_length = \"15 mm\"", "roller_length = 0", &["a length above 0"]),
        ("elements = 17", "elements = 23", &["expected 3 to 22: more rollers of this roller_diameter"]),
        (angle, "", &["contact_angle: missing key, expected an angle above 0 and at most 60 deg with kind = \"tapered\""]),
        (angle, "contact_angle = 0", &["above 0 and at most 60 deg with kind = \"tapered\""]),
        ("kind = \"tapered\"", "kind = \"needle\"", &["contact_angle: invalid value", "an angle: 0 with kind = \"needle\""]),
        (angle, "contact_angle = 0.2\nlaminae = 0", &["laminae: invalid value: 0, expected a whole number from 1 to 1000"]),
        (angle, "contact_angle = 0.2\nprofile = \"round\"", &["expected \"iso\", \"straight\", { coefficient"]),
        (angle, "contact_angle = 0.2\nprofile = 3", &["expected \"iso\", \"straight\", { coefficient = \"2.6 um\" } or a list"]),
        (angle, "contact_angle = 0.2\nprofile = { coefficient = -1 }", &["profile.coefficient: invalid value", "0 or more"]),
        (angle, "contact_angle = 0.2\nprofile = { drop = 1 }", &["profile.drop"]),
        (angle, "contact_angle = 0.2\nprofile = [1e-6]\nlaminae = 3", &["a list of 1, expected a list of 3: a drop of each lamina"]),
        (angle, "contact_angle = 0.2\nprofile = []", &["a list of 0, expected a list of at least one"]),
        (angle, "contact_angle = 0.2\nprofile = [\"1 N\"]", &["profile[0]: invalid value: \"1 N\""]),
        (angle, "contact_angle = 0.2\nstiffness = \"1 N/m^1.5\"", &["expected a contact stiffness in N/m^1.1111"]),
        (angle, "contact_angle = 0.2\nradial_play = 0\ndiametral_clearance = 0", &["both radial_play and diametral_clearance"]),
        (angle, "contact_angle = 0.2\nball_diameter = 0.1", &["ball_diameter: misplaced key", "not with rollers"]),
        (angle, "contact_angle = 0.2\neffects = [\"film\"]", &["effects", "only with model"]),
        ("model = \"roller\"", "model = \"quasi-static\"", &["kind: invalid value: \"tapered\", expected \"cylindrical\" or \"needle\" with rollers in equilibrium"]),
        ("model = \"roller\"", "model = \"lumped\"", &["kind: invalid value: \"tapered\", expected \"cylindrical\" or \"needle\" with"]),
        ("model = \"roller\"", "model = \"angular\"", &["roller_diameter: misplaced key", "only with rollers"]),
    ]);
    let cylindrical = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nmodel = \"quasi-static\"\nelements = 13\n\
                       roller_diameter = \"7.5 mm\"\nroller_length = \"8 mm\"\npitch_diameter = \"39 mm\"\nradial_play = 0\n";
    assert_refused(cylindrical, &[
        ("radial_play = 0", "", &["radial_play: missing key, expected half the diametral clearance"]),
        ("radial_play = 0", "radial_play = 0\neffects = [\"gyroscopic\"]", &["effects: invalid value", "[\"centrifugal\"] with rollers"]),
        ("radial_play = 0", "radial_play = 0\nlubricant = {}", &["lubricant: misplaced key", "not with rollers"]),
    ]);
}
