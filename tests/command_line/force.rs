//! `ballrace force`: golden values through scene files, and the forms of its output.

use serde_json::Value;

use ballrace_tests::compare::relative_to_largest;
use ballrace_tests::lumped::{Axial, Case, cases};

use crate::support::{DEMO_SCENE, Sandbox, scene};

/// A case as a scene, with element 1 back by `back` rad.
fn case_scene(case: &Case, back: f64) -> String {
    let Case { elements, exponent, stiffness, radial_play, .. } = case;
    let azimuth = case.azimuth_of_first_element - back;
    let mut text = format!(
        "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\n\
         cage_ratio = 0.4\nelements = {elements}\nexponent = {exponent:?}\nstiffness = {stiffness:?}\n\
         radial_play = {radial_play:?}\nfirst_element_azimuth = {azimuth:?}\n"
    );
    if let Some(Axial { exponent, stiffness, play, radius }) = &case.axial {
        text += &format!(
            "axial = {{ exponent = {exponent:?}, stiffness = {stiffness:?}, play = {play:?}, radius = {radius:?} }}\n"
        );
    }
    if let Some(housing) = &case.housing_displacement {
        text += &format!("housing_displacement = {housing:?}\n");
    }
    text
}

fn displacements(case: &Case) -> String {
    case.displacement.map(|x| format!("{x:?}")).join(",")
}

/// Content of one row of `--format csv`: numbers with checked digits, and status.
fn row(line: &str, digits: usize) -> ([f64; 5], &str) {
    let cells: Vec<&str> = line.split(',').collect();
    assert_eq!(cells.len(), 6, "{line}");
    let number = |i: usize| {
        let (mantissa, exponent) = cells[i].split_once('e').unwrap_or_else(|| panic!("{line}"));
        assert_eq!(mantissa.chars().filter(char::is_ascii_digit).count(), digits, "significant digits: {line}");
        exponent.parse::<i32>().unwrap();
        cells[i].parse().unwrap()
    };
    (std::array::from_fn(number), cells[5])
}

/// Forces of `force --format csv` for displacements with their header line.
fn forces(sandbox: &Sandbox, displacements: &str, digits: usize, more: &[&str]) -> Vec<([f64; 5], String)> {
    sandbox.put("u.csv", displacements);
    let args = [&["force", "scene.toml", "--displacements", "u.csv", "--format", "csv"], more].concat();
    let out = sandbox.done(&args).out;
    let (header, rows) = out.split_once('\n').unwrap();
    assert_eq!(header, "FX,FY,FZ,MX,MY,status");
    rows.lines().map(|line| row(line, digits)).map(|(force, status)| (force, status.to_owned())).collect()
}

/// The largest error of `cases` in the program, with the cage turned by `cage` rad and element 1 back by as much.
fn largest_error(cases: &[&Case], cage: f64, digits: usize, options: &[&str]) -> f64 {
    let error = |case: &&Case| {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", case_scene(case, cage));
        let rows = format!("u,v,w,thu,thv,cage_angle\n{},{cage:?}\n", displacements(case));
        let found = forces(&sandbox, &rows, digits, options);
        assert_eq!(found.len(), 1);
        relative_to_largest(&found[0].0, &case.force)
    };
    cases.iter().map(error).fold(0.0, f64::max)
}

/// The points of a housing do not turn with the cage.
fn is_golden_at(case: &Case, cage: f64) -> bool {
    case.housing_displacement.is_none() || cage == 0.0
}

/// A housing squeezed to an ellipse at points that are fixed in it is an outer race with two waves: also for balls between the points.
#[test]
fn balls_pass_the_points_of_a_housing() {
    let [wave, housing] = [false, true].map(|is_housing| {
        let amplitude = 5e-6;
        let shape = if is_housing {
            let point = |j: i32| {
                let (sin, cos) = (f64::from(j) * std::f64::consts::FRAC_PI_4).sin_cos();
                let outward = amplitude * (cos * cos - sin * sin);
                format!("[{:?}, {:?}, 0]", outward * cos, outward * sin)
            };
            format!("housing_displacement = [{}]", (0..8).map(point).collect::<Vec<_>>().join(", "))
        } else {
            format!("waviness = [{{ surface = \"outer\", order = 2, amplitude = {amplitude:?} }}]")
        };
        let sandbox = Sandbox::empty();
        sandbox.put(
            "scene.toml",
            format!(
                "[shaft]\nspeed = \"1500 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\nelements = 8\n\
                 cage_ratio = 0.4\nstiffness = 6e8\nexponent = 1.1111\nradial_play = \"2 um\"\n{shape}\n"
            ),
        );
        let row = |angle: f64| format!("1e-6,-2e-6,0,0,0,{angle:?}\n");
        let rows: String = (0..12).map(|i| row(0.13 * f64::from(i))).collect();
        forces(&sandbox, &format!("u,v,w,thu,thv,cage_angle\n{rows}"), 17, &["--precision", "f64"])
    });
    assert_eq!(wave.len(), 12);
    for ((wave, _), (housing, _)) in wave.iter().zip(&housing) {
        let error = relative_to_largest(housing, wave);
        assert!(error < 1e-9, "{housing:?}, expected {wave:?}");
    }
    let change = (wave[0].0[0] - wave[3].0[0]).abs() / wave[0].0[0].abs().max(1.0);
    assert!(change > 0.1, "the force depends on the angle of the cage: {change}");
}

/// A bending outer ring in a scene: the heaviest loaded balls are relieved, and both precisions agree.
#[test]
fn an_outer_ring_bends() {
    let sandbox = Sandbox::empty();
    let scene = |ring: &str| {
        format!(
            "[shaft]\nspeed = \"1500 rpm\"\n[rotor]\nmass = \"300 kg\"\ndiametral_inertia = 2\npolar_inertia = 1\n\
             stiffness = [0, 0, 1e6, 1e6, 1e6]\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\nelements = 14\n\
             cage_ratio = 0.4\nstiffness = 6e8\nexponent = 1.1111\nradial_play = \"2 um\"\n{ring}\n"
        )
    };
    let ring = "outer_ring = { radius = \"60 mm\", width = \"22 mm\", thickness = \"6 mm\" }";
    let loads = [("rigid.toml", ""), ("bending.toml", ring)].map(|(name, ring)| {
        sandbox.put(name, scene(ring));
        let json: Value = sandbox.done(&["equilibrium", name, "--format", "json"]).json();
        let elements = json["elements"].as_array().unwrap_or_else(|| panic!("{json}"));
        elements.iter().map(|element| element["inner_load"].as_f64().unwrap()).fold(0.0, f64::max)
    });
    assert!(loads[1] < 0.95 * loads[0], "{loads:?}");
    let rows = "u,v,w,thu,thv,cage_angle\n0,-30e-6,0,0,0,0.1\n10e-6,-12e-6,0,0,0,2.3\n";
    sandbox.put("scene.toml", scene(ring));
    let [double, single] = [("f64", 17), ("f32", 9)]
        .map(|(precision, digits)| forces(&sandbox, rows, digits, &["--precision", precision]));
    for ((double, _), (single, _)) in double.iter().zip(&single) {
        let error = relative_to_largest(single, double);
        assert!(error < 1e-5, "{single:?}, expected {double:?}");
    }
}

#[test]
fn golden_cases_in_double_precision() {
    let all = cases();
    assert_eq!(all.len(), 120);
    for cage in [0.0, 2.25] {
        let all: Vec<&Case> = all.iter().filter(|case| is_golden_at(case, cage)).collect();
        let error = largest_error(&all, cage, 17, &["--precision", "f64"]);
        println!("force, f64, cage at {cage} rad: {error:.2e}");
        assert!(error < 1e-12, "{error:e}");
    }
}

#[test]
fn golden_cases_in_single_precision() {
    let all = cases();
    for cage in [0.0, 2.25] {
        let all: Vec<&Case> = all.iter().filter(|case| is_golden_at(case, cage)).collect();
        let error = largest_error(&all, cage, 9, &["--precision", "f32"]);
        println!("force, f32, cage at {cage} rad: {error:.2e}");
        assert!(error < 5e-6, "{error:e}");
    }
}

#[test]
fn fast_math_is_within_two_percent() {
    let all = cases();
    let point: Vec<&Case> = all.iter().filter(|case| case.exponent == 1.5).collect();
    assert!(point.len() > 30);
    for (precision, digits) in [("f64", 17), ("f32", 9)] {
        let error = largest_error(&point, 0.0, digits, &["--math", "fast", "--precision", precision]);
        println!("force, {precision}, fast math: {error:.2e}");
        assert!(error < 0.02, "{error:e}");
    }
}

const HEAD: &str = "u,v,w,thu,thv";

/// Two displacements of a bearing of the demonstration that load it differently.
const GOOD: [&str; 2] = ["1e-6,-2e-6,6.4e-5,1e-5,-2e-5", "-3e-6,1e-6,6.6e-5,0,1e-5"];

fn rig() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    sandbox
}

fn table(rows: &[&str]) -> String {
    format!("{HEAD}\n{}\n", rows.join("\n"))
}

#[test]
fn displacement_that_is_no_number_holds_the_last_force() {
    let (first, second) = (GOOD[0], GOOD[1]);
    let (gone, infinite) = ("0,NaN,0,0,0", "0,0,0,-inf,0");
    let rows = table(&[gone, first, gone, infinite, second, gone]);
    let found = forces(&rig(), &rows, 17, &["--bearing", "DE"]);
    let status: Vec<&str> = found.iter().map(|row| row.1.as_str()).collect();
    let lost = "input-not-finite";
    assert_eq!(status, [lost, "ok", lost, lost, "ok", lost]);
    assert_eq!(found[0].0, [0.0; 5], "nothing to hold yet");
    assert!(found[1].0.iter().any(|f| f.abs() > 1.0));
    assert_eq!([found[2].0, found[3].0], [found[1].0; 2]);
    assert_ne!(found[4].0, found[1].0);
    assert_eq!(found[5].0, found[4].0);
}

#[test]
fn time_or_cage_angle_that_is_no_number_holds_the_last_force() {
    for column in ["t", "cage_angle"] {
        let rows = format!("{HEAD},{column}\n{0},0\n{1},NaN\n{1},inf\n{1},0\n", GOOD[0], GOOD[1]);
        let found = forces(&rig(), &rows, 17, &["--bearing", "DE"]);
        assert_eq!(found.iter().map(|row| row.1.as_str()).collect::<Vec<_>>()[1..3], ["input-not-finite"; 2]);
        assert_eq!([found[1].0, found[2].0], [found[0].0; 2]);
        assert_eq!(found[3].1, "ok");
    }
}

#[test]
fn displacement_that_overflows() {
    let found = forces(&rig(), &table(&[GOOD[0], "1e300,1e300,1e300,1e300,1e300"]), 17, &["--bearing", "DE"]);
    assert_eq!(found[1], (found[0].0, "result-not-finite".to_owned()));
}

#[test]
fn no_contact_no_force() {
    let lumped = "\"lumped\"\nstiffness = 1e10\nradial_play = \"5 um\"";
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene(&[("\"angular\"", lumped)]));
    let found = forces(&sandbox, &table(&["1e-6,0,0,0,0", "8e-6,0,0,0,0"]), 17, &["--bearing", "DE"]);
    assert_eq!(found[0], ([0.0; 5], "contact-lost".to_owned()));
    assert_eq!(found[1].1, "ok");
    assert!(found[1].0[0] < -1.0, "a spring pushes back: {:?}", found[1].0);
}

#[test]
fn the_cage_rotates_with_time() {
    // 3000 rpm and a cage at 0.4 of that: a tenth of a turn after 5 ms.
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene(&[("elements = 9", "elements = 9\ncage_ratio = 0.4")]));
    let options = ["--bearing", "DE"];
    let timed = forces(&sandbox, &format!("{HEAD},t\n{},5e-3\n", GOOD[0]), 17, &options);
    let tenth = std::f64::consts::TAU / 10.0;
    let turned = forces(&sandbox, &format!("{HEAD},cage_angle\n{},{tenth:?}\n", GOOD[0]), 17, &options);
    let still = forces(&sandbox, &table(&[GOOD[0]]), 17, &options);
    assert!(relative_to_largest(&timed[0].0, &turned[0].0) < 1e-11);
    assert!(relative_to_largest(&timed[0].0, &still[0].0) > 1e-4, "the elements have moved on");
}

#[test]
fn order_of_columns_does_not_matter() {
    let plain = forces(&rig(), &table(&[GOOD[0]]), 17, &["--bearing", "DE"]);
    let [u, v, w, thu, thv]: [&str; 5] = GOOD[0].split(',').collect::<Vec<_>>().try_into().unwrap();
    let mixed = format!("thv, note ,w,u,thu,v\r\n{thv},good,{w},{u},{thu},{v}\r\n");
    assert_eq!(forces(&rig(), &mixed, 17, &["--bearing", "DE"]), plain);
}

#[test]
fn both_bearings_and_other_models() {
    let rows = table(&GOOD);
    let of = |options: &[&str]| forces(&rig(), &rows, 17, options);
    assert_eq!(of(&["--bearing", "DE"]), of(&["--bearing", "NDE"]), "two bearings of one make");
    assert_eq!(of(&["--bearing", "DE"]), of(&["--bearing", "DE", "--model", "angular"]));
    assert_ne!(of(&["--bearing", "DE"]), of(&["--bearing", "DE", "--model", "lumped"]));
}

#[test]
fn the_three_formats_agree() {
    let sandbox = rig();
    let rows = table(&[GOOD[0], "NaN,0,0,0,0", GOOD[1]]);
    let csv = forces(&sandbox, &rows, 17, &["--bearing", "DE"]);
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", "DE", "--format"];
    let json: Vec<Value> = sandbox.done(&[&args[..], &["json"]].concat()).json();
    let text = sandbox.done(&[&args[..], &["text"]].concat()).out;
    assert_eq!(text, sandbox.done(&args[..6]).out, "text is the default");
    let (table, needs): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| !line.starts_with("DE: "));
    assert_eq!((json.len(), table.len()), (3, 4));
    assert!(needs[0].starts_with("DE: effects of this scene, as change of force if omitted: contact-angle"), "{text}");
    let head: Vec<&str> = text.lines().next().unwrap().split_whitespace().collect();
    assert_eq!(head.join(" "), "row FX N FY N FZ N MX N m MY N m status");
    for (i, ((force, status), line)) in csv.iter().zip(text.lines().skip(1)).enumerate() {
        let said = ["FX", "FY", "FZ", "MX", "MY"].map(|entry| json[i][entry].as_f64().unwrap());
        assert_eq!((said, json[i]["status"].as_str()), (*force, Some(status.as_str())));
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!((cells[0], cells[6]), ((i + 1).to_string().as_str(), status.as_str()));
        for (cell, f) in cells[1..6].iter().zip(force) {
            assert!((cell.parse::<f64>().unwrap() - f).abs() < 1e-4, "{line}");
        }
    }
}

#[test]
fn no_rows_give_no_forces() {
    assert_eq!(forces(&rig(), &format!("{HEAD}\n"), 17, &["--bearing", "DE"]), []);
}

/// Text of a number as its bits in single precision.
fn bits(x: f32) -> String {
    format!("{:#010x}", x.to_bits())
}

/// A log of a device has angles that no decimal number of radians has, and numbers as bits.
#[test]
fn a_log_of_bits_gives_the_bits_of_the_kernel() {
    use ballrace::{Bearing, BearingKinematicState, Displacement, LumpedRadial, Phase};
    let sandbox = Sandbox::empty();
    sandbox.put(
        "scene.toml",
        "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\ncage_ratio = 0.4\n\
         elements = 9\nstiffness = 8e9\nradial_play = \"2 um\"\n",
    );
    let bearing = LumpedRadial::<f32, 9>::try_new(
        ballrace::bearing::evenly_spaced(Phase::ZERO),
        ballrace::contact::law::PointContactLaw { stiffness: 8e9 },
        2e-6,
    )
    .unwrap();
    let (mut log, mut expected) = ("u,v,w,thu,thv,cage_phase,inner_speed\n".to_owned(), String::new());
    for i in 0..64_u64 {
        let phase = Phase(i.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let u = Displacement { u: 1e-7 * i as f32, v: 1e-6 - 1e-7 * i as f32, ..Displacement::default() };
        let displacement = u.to_array().map(bits).join(",");
        // The last column in decimal digits, some angles too.
        let angle = if i % 2 == 0 { format!("{:#018x}", phase.0) } else { phase.0.to_string() };
        log += &format!("{displacement},{angle},314.25\n");
        let at = BearingKinematicState { inner_speed: 314.25, ..BearingKinematicState::from(phase) };
        let reaction = bearing.reaction(&u, &at);
        let status = if reaction.load == 0.0 { "0x04" } else { "0x00" };
        expected += &format!("{},{status}\n", reaction.wrench.to_array().map(bits).join(","));
    }
    assert!(expected.contains("0x04") && expected.contains("0x00\n"));
    sandbox.put("log.csv", log);
    let args = ["force", "scene.toml", "--displacements", "log.csv", "--precision", "f32", "--bits"];
    let out = sandbox.done(&[&args[..], &["--format", "csv"]].concat()).out;
    assert_eq!(out, format!("FX,FY,FZ,MX,MY,status\n{expected}"));
    let json: Value = sandbox.done(&[&args[..], &["--format", "json"]].concat()).json();
    let first: Vec<&str> = expected.lines().next().unwrap().split(',').collect();
    assert_eq!([&json[0]["FX"], &json[0]["FY"], &json[0]["status"]], [first[0], first[1], first[5]]);
    // Double precision has sixteen digits.
    let args = ["force", "scene.toml", "--displacements", "log.csv", "--bits", "--format", "csv"];
    assert_eq!(sandbox.done(&args).out.lines().nth(1).unwrap().split(',').next().unwrap().len(), 18);
}

#[test]
fn invalid_cells_of_a_log_are_refused() {
    let sandbox = Sandbox::rig();
    let refused = |text: &str, code: i32, part: &str| {
        sandbox.put("u.csv", text);
        let args = ["force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv"];
        sandbox.refused(&args, code, &["u.csv:", part]);
    };
    let header = "u,v,w,thu,thv,cage_phase\n";
    for phase in ["-1", "0.5", "0x", "0x1g", "18446744073709551616", ""] {
        refused(&format!("{header}0,0,0,0,0,{phase}\n"), 1, "column cage_phase: invalid value");
    }
    for cell in ["0x123", "0x123456789", "0xzzzzzzzz"] {
        refused(&format!("{header}{cell},0,0,0,0,1\n"), 1, "column u: invalid value");
    }
    let both = "u,v,w,thu,thv,cage_phase,cage_angle\n0,0,0,0,0,0,0\n";
    refused(both, 2, "both cage_angle and cage_phase are given, expected at most one");
}

/// A golden case of rollers as a scene.
fn roller_scene(case: &ballrace_tests::rollers::Case) -> String {
    let ballrace_tests::rollers::Case {
        model,
        kind,
        elements,
        roller_diameter,
        roller_length,
        pitch_diameter,
        contact_angle,
        laminae,
        profile,
        radial_play,
        first_azimuth,
        stiffness,
        speed,
        ..
    } = case;
    format!(
        "[shaft]\nspeed = {speed:?}\n[[bearing]]\nname = \"A\"\nmodel = {model:?}\nkind = {kind:?}\nelements = {elements}\n\
         roller_diameter = {roller_diameter:?}\nroller_length = {roller_length:?}\npitch_diameter = {pitch_diameter:?}\n\
         contact_angle = {contact_angle:?}\nlaminae = {laminae}\nprofile = {{ coefficient = {profile:?} }}\n\
         radial_play = {radial_play:?}\nfirst_element_azimuth = {first_azimuth:?}\nstiffness = {stiffness:?}\n"
    )
}

#[test]
fn golden_forces_of_rollers() {
    let precisions =
        [("f64", "exact", 17, [1e-12, 1e-9]), ("f32", "exact", 9, [5e-6, 2e-4]), ("f32", "fast", 9, [5e-6, 2e-4])];
    for (precision, math, digits, tolerances) in precisions {
        let mut worst = [0.0_f64; 2];
        for case in ballrace_tests::rollers::cases() {
            let sandbox = Sandbox::empty();
            sandbox.put("scene.toml", roller_scene(&case));
            let u = format!("u,v,w,thu,thv\n{}\n", case.displacement.map(|x| format!("{x:?}")).join(","));
            let rows = forces(&sandbox, &u, digits, &["--precision", precision, "--math", math]);
            let error = relative_to_largest(&rows[0].0, &case.force);
            let worst = &mut worst[usize::from(case.is_in_equilibrium())];
            *worst = worst.max(error);
        }
        assert!(worst[0] <= tolerances[0] && worst[1] <= tolerances[1], "{precision} {math}: {worst:?}");
    }
}
