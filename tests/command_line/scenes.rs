//! The scenes that come with the program, each against the rule that its own comment gives (confirmed by other programs).

use crate::support::{Sandbox, numbers, swap};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// A scene as the program itself hands it out, with pieces of its text replaced.
fn shipped(name: &str, swaps: &[(&str, &str)]) -> String {
    let text = Sandbox::empty().done(&["scenes", name]).out;
    swaps.iter().fold(text, |text, (from, to)| swap(&text, from, to))
}

/// A response: samples per second and one column a coordinate.
struct Response {
    rate: f64,
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Response {
    /// Simulates at `rate` for `samples` after `settle` seconds.
    fn of(scene: &str, rate: f64, samples: usize, settle: f64) -> Self {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", scene);
        let duration = format!("{:.17e}", samples as f64 / rate);
        let (rate_text, settle) = (format!("{rate:.17e}"), format!("{settle}"));
        let args = ["simulate", "scene.toml", "--duration", &duration, "--rate", &rate_text, "--settle", &settle];
        sandbox.done(&[&args[..], &["-o", "out.csv"]].concat());
        let (header, rows) = numbers(&sandbox.read("out.csv"));
        Self { rate, header, rows }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}: {:?}", self.header));
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// Peak to peak along X and Y and the mean along X, um.
    fn figures(&self) -> [f64; 3] {
        let (u, v) = (self.column("u"), self.column("v"));
        let spread = |x: &[f64]| x.iter().fold(f64::MIN, |m, &x| m.max(x)) - x.iter().fold(f64::MAX, |m, &x| m.min(x));
        [spread(&u), spread(&v), u.iter().sum::<f64>() / u.len() as f64].map(|x| x * 1e6)
    }

    /// Amplitude of a column at a frequency, um, under a Hann window.
    fn line(&self, column: &str, hz: f64) -> f64 {
        let x = self.column(column);
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, x) in x.iter().enumerate() {
            let window = 1.0 - (TAU * i as f64 / n).cos();
            let (sin, cos) = (TAU * hz * i as f64 / self.rate).sin_cos();
            re += window * (x - mean) * cos;
            im += window * (x - mean) * sin;
        }
        2.0 / n * re.hypot(im) * 1e6
    }
}

const ORDER_H: f64 = 9.0 * 0.398_723_404;
const ORDER_6306: f64 = 8.0 * 0.385_576_923;

/// The scene of Lioulios without its fluctuation, at another speed and play.
fn set_h(rpm: f64, play_um: f64) -> String {
    let speed = format!("speed = \"{rpm} rpm\"");
    let play = format!("radial_play = \"{play_um} um\"");
    let text = shipped("lioulios-fluctuation", &[("radial_play = \"2.5 um\"", &play)]);
    swap(&text, "speed = { mean = \"2000 rpm\", fluctuation = 0.02, frequency = \"7 Hz\" }", &speed)
}

fn set_6306(rpm: f64, play_um: f64) -> String {
    let (speed, play) = (format!("\"{rpm} rpm\""), format!("\"{play_um} um\""));
    shipped("tiwari-balanced", &[("\"1500 rpm\"", &speed), ("\"3 um\"", &play)])
}

/// Samples of one ball-pass period.
const A_PERIOD: usize = 400;

fn settled(scene: &str, order: f64, rpm: f64, periods: usize, settle: f64) -> Response {
    let rate = A_PERIOD as f64 * order * rpm / 60.0;
    Response::of(scene, rate, periods * A_PERIOD, settle)
}

/// By a second program: peak to peak along X and Y and mean along X, to the digits given.
#[test]
fn planar_rotors_with_clearance() {
    let cases = [
        (set_h(2000.0, 2.5), ORDER_H, 2000.0, 2.0, [0.09304, 0.09431, 3.32027]),
        (set_h(2000.0, 10.0), ORDER_H, 2000.0, 4.0, [0.72348, 3.81989, 11.04372]),
        (set_h(8000.0, 20.0), ORDER_H, 8000.0, 2.0, [2.1637, 0.58115, 21.19736]),
        (set_6306(1500.0, 3.0), ORDER_6306, 1500.0, 2.0, [0.05206, 0.79116, 7.54058]),
        (set_6306(3000.0, 10.0), ORDER_6306, 3000.0, 2.0, [1.42036, 1.94705, 15.27785]),
    ];
    for (scene, order, rpm, settle, expected) in cases {
        // Five times as fine as elsewhere: balls that strike cost an integrator its order.
        let rate = 5.0 * A_PERIOD as f64 * order * rpm / 60.0;
        let found = Response::of(&scene, rate, 5 * A_PERIOD, settle).figures();
        println!("{rpm} rpm: {found:.5?}, expected {expected:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 6e-6 + 3e-5 * expected, "{rpm} rpm: {found} {expected}");
        }
    }
}

/// After how many ball-pass periods the motion repeats, none within 12.
fn period(response: &Response) -> Option<usize> {
    let (u, v) = (response.column("u"), response.column("v"));
    let size = u.iter().fold(f64::MIN, |m, &x| m.max(x)) - u.iter().fold(f64::MAX, |m, &x| m.min(x));
    (1..=12).find(|&k| {
        let far = |x: &[f64]| x.iter().zip(&x[k * A_PERIOD..]).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        far(&u).max(far(&v)) < 1e-3 * size
    })
}

/// By a second program: with 10 um of play the response is of period 6, 4, 2, 1 at 3000 to 6000 rpm; with 20 um aperiodic at 10 000.
#[test]
fn windows_of_subharmonic_motion() {
    for (rpm, play, expected) in [
        (3000.0, 10.0, Some(6)),
        (4000.0, 10.0, Some(4)),
        (5000.0, 10.0, Some(2)),
        (6000.0, 10.0, Some(1)),
        (10_000.0, 20.0, None),
    ] {
        let found = period(&settled(&set_h(rpm, play), ORDER_H, rpm, 24, 5.0));
        assert_eq!(found, expected, "{rpm} rpm, {play} um");
    }
}

/// Tiwari: unbalance adds the shaft's line and the combinations with the ball-pass line.
#[test]
fn unbalance_combines_with_the_ball_pass() {
    let (shaft, pass) = (25.0, 25.0 * ORDER_6306);
    let at = |name| Response::of(&shipped(name, &[]), 12_800.0, 65_536, 1.0);
    let (plain, unbalanced) = (at("tiwari-balanced"), at("tiwari-unbalanced"));
    assert!(plain.line("v", pass) > 100.0 * plain.line("v", 1.37 * pass), "one line and its multiples");
    for hz in [shaft, pass - shaft, pass + shaft] {
        let (with, without) = (unbalanced.line("v", hz), plain.line("v", hz));
        assert!(with > 20.0 * without && with > 0.01, "{hz} Hz: {with} {without}");
    }
}

/// Harsha: balls with a mass of their own; as it vanishes the motion becomes that of the lumped model.
#[test]
fn moving_balls_without_mass_move_as_the_lumped_model() {
    let heavy = shipped("harsha-clearance", &[]);
    let lumped = swap(&swap(&heavy, "\"dynamic\"", "\"lumped\""), "element_damping = 20\n", "");
    let at = |scene: &str| settled(scene, 9.0 * 0.398_680_851, 2000.0, 2, 0.3).figures();
    let (lumped, normal) = (at(&lumped), at(&heavy));
    let light = swap(&heavy, "element_damping = 20\n", "element_damping = 0.2\ndensity = 100\n");
    let light = at(&light);
    println!("lumped {lumped:.5?}, steel balls {normal:.5?}, balls of 100 kg/m3 {light:.5?}");
    assert!((light[2] - lumped[2]).abs() < 2e-3 * lumped[2], "{light:?} {lumped:?}");
    for i in 0..2 {
        assert!((light[i] - lumped[i]).abs() < 0.03 * lumped[i], "{i}: {light:?} {lumped:?}");
    }
}

/// Harsha: waves next to the number of balls shake the rotor, others do not.
#[test]
fn waviness_selects_its_orders() {
    let shaken = |order: u32| {
        let order = format!("order = {order}");
        let response = Response::of(
            &shipped("harsha-waviness", &[("order = 8", &order), ("\"6 N\"", "0")]),
            51_200.0,
            25_600,
            0.3,
        );
        response.figures()[0]
    };
    let (eight, ten, five) = (shaken(8), shaken(10), shaken(5));
    println!("um peak to peak: order 8 {eight:.4}, 10 {ten:.4}, 5 {five:.6}");
    assert!(eight > 50.0 * five && ten > 50.0 * five);
}

/// Harsha: a cage beside its centre brings every multiple of the cage's speed.
#[test]
fn cage_runout_brings_side_bands() {
    let cage = 50.0 * 0.398_723_404;
    let at = |offset: &str| {
        let response = Response::of(&shipped("harsha-cage-runout", &[("\"50 um\"", offset)]), 25_600.0, 102_400, 1.0);
        ([7, 8, 9, 10, 11].map(|k| response.line("v", f64::from(k) * cage)), response.line("u", cage))
    };
    let ((round, _), (beside, at_cage)) = (at("0"), at("\"50 um\""));
    println!("lines at 7 to 11 times the cage, um: round {round:.6?}, beside {beside:.6?}");
    assert!(round[2] > 1e3 * round[1] && round[2] > 1e3 * round[3], "{round:?}");
    for i in [1, 3] {
        assert!(beside[i] > 100.0 * round[i] && beside[i] > 1e-4 * beside[2], "{beside:?}");
        assert!(at_cage > 5.0 * beside[i], "{at_cage} um at the cage speed, {beside:?}");
    }
}

/// Harsha: more balls make the varying compliance smaller and faster.
#[test]
fn more_balls_vibrate_less() {
    let at = |balls: u32| {
        let count = format!("elements = {balls}");
        let scene = shipped("harsha-number-of-balls", &[("elements = 9", &count)]);
        settled(&scene, f64::from(balls) * 0.398_723_404, 600.0, 1, 1.0).figures()[1]
    };
    let all = [7, 9, 11, 13].map(at);
    println!("um peak to peak across the load with 7, 9, 11, 13 balls: {all:.5?}");
    assert!(all.windows(2).all(|pair| pair[1] < 0.8 * pair[0]), "{all:?}");
}

/// Tomovic: an unloaded rotor rocks in the polygon that its balls leave it.
#[test]
fn an_unloaded_rotor_rocks_in_a_polygon() {
    let order = 9.0 * 0.4;
    let rate = 80_000.0 * order / 60.0 * 0.5;
    let [along, across, mean] = Response::of(&shipped("tomovic-unloaded", &[]), rate, 80_000, 10.0).figures();
    let g = 20.0;
    let (up, side) = (g * (1.0 / (PI / 9.0).cos() - 1.0), 2.0 * g * (PI / 9.0).tan());
    println!("along {along:.4} um (geometry {up:.4}), across {across:.4} ({side:.4}), mean {mean:.3}");
    assert!((along - up).abs() < 0.1 * up, "{along} {up}");
    assert!((across - side).abs() < 0.05 * side, "{across} {side}");
}

/// Lioulios: the fluctuation modulates the ball-pass line; without it the side bands are gone.
#[test]
fn speed_fluctuation_modulates_the_ball_pass() {
    let pass = 2000.0 / 60.0 * ORDER_H;
    let at = |scene: &str| {
        let response = Response::of(scene, 12_800.0, 128_000, 1.0);
        [pass, pass - 7.0, pass + 7.0, pass + 14.0].map(|hz| response.line("v", hz))
    };
    let (swinging, steady) = (at(&shipped("lioulios-fluctuation", &[])), at(&set_h(2000.0, 2.5)));
    println!("line and bands, um: fluctuating {swinging:.6?}, steady {steady:.6?}");
    // J_1/J_0 of the index of phase modulation.
    let index: f64 = ORDER_H * 0.02 * (2000.0 / 60.0) / 7.0;
    let ratio = 0.5 * index * (1.0 - index * index / 8.0) / (1.0 - index * index / 4.0);
    for band in [1, 2] {
        assert!(swinging[band] > 100.0 * steady[band], "{swinging:?} {steady:?}");
        let found = swinging[band] / swinging[0];
        assert!((found - ratio).abs() < 0.15 * ratio, "{found} {ratio}");
    }
}

fn equilibrium(scene: &str, more: &[&str]) -> Value {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene);
    sandbox.done(&[&["equilibrium", "scene.toml", "--format", "json"], more].concat()).json()
}

fn loads(settled: &Value) -> Vec<f64> {
    settled["elements"].as_array().unwrap().iter().map(|e| e["inner_load"].as_f64().unwrap()).collect()
}

/// Hajzman: the squeezed ring loads the elements at its short axis; housing points that follow the shaft load nothing.
#[test]
fn a_squeezed_ring_loads_its_short_axis() {
    let weightless = [("stiffness = [0, 0, 1e6, 1e4, 1e4]", "stiffness = [0, 0, 1e6, 1e4, 1e4]\ngravity = [0, 0, 0]")];
    let squeezed = loads(&equilibrium(&shipped("hajzman-flexible-ring", &weightless), &[]));
    // Points at 0 and 180 degrees stand 5 um inwards, play is 2 um; at 90 and 270 they stand outwards.
    let expected = 6e8 * 3e-6_f64.powf(10.0 / 9.0);
    assert!(
        (squeezed[0] - expected).abs() < 1e-3 * expected && (squeezed[4] - expected).abs() < 1e-3 * expected,
        "{squeezed:?}"
    );
    assert!(squeezed[2] == 0.0 && squeezed[6] == 0.0, "{squeezed:?}");
}

/// Hajzman: a thin ring hands the load of the heaviest roller to its neighbours, as the scene says; one of a much stiffer material is
/// almost rigid.
#[test]
fn a_bending_ring_spreads_the_load() {
    const RING: &str = "outer_ring = { radius = \"75 mm\", width = \"25 mm\", thickness = \"8 mm\" }";
    let thick = RING.replace("8 mm", "24 mm");
    let stiff = thick.replace("\" }", "\", youngs_modulus = \"20600 GPa\" }");
    let [bending, thick, stiff, rigid] = [RING, &thick, &stiff, ""].map(|ring| {
        let settled = equilibrium(&shipped("hajzman-bending-ring", &[(RING, ring)]), &[]);
        let loads = loads(&settled);
        let carrying = loads.iter().filter(|load| **load > 0.0).count();
        let largest = loads.into_iter().fold(0.0, f64::max);
        (largest, carrying, settled["stiffness"][1][1].as_f64().unwrap())
    });
    assert!(bending.0 < 0.9 * rigid.0 && bending.1 >= rigid.1, "{bending:?} {rigid:?}");
    assert!(bending.2 < 0.9 * rigid.2, "{bending:?} {rigid:?}");
    assert_eq!([bending.0, thick.0, rigid.0].map(f64::round), [662.0, 694.0, 932.0]);
    assert!((stiff.0 / rigid.0 - 1.0).abs() < 0.02, "{stiff:?} {rigid:?}");
}

/// Two springs: natural frequencies by hand, and a response without any ball-pass line.
#[test]
fn two_springs_have_the_frequencies_of_springs() {
    let settled = equilibrium(&shipped("two-spring-rotor", &[]), &[]);
    let found: Vec<f64> =
        settled["natural_frequencies_hz"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect();
    // As ROSS computes it: 1.00906269e8 N/m along the load, 0.46 of it across.
    let along = (2.0 * 1.009_062_69e8 / 100.0_f64).sqrt() / TAU;
    let has = |hz: f64| found.iter().any(|f| (f - hz).abs() < 2e-3 * hz);
    assert!(has(along) && has(along * 0.46_f64.sqrt()), "{found:?} {along}");
}

/// Jones: contact angles of Harris' 218 at speed, confirmed by three programs.
#[test]
fn contact_angles_part_at_speed() {
    let settled = equilibrium(&shipped("jones-1960", &[]), &[]);
    for element in settled["elements"].as_array().unwrap() {
        let angle = |key: &str| element[key].as_f64().unwrap().to_degrees();
        assert!((angle("inner_angle") - 49.9546).abs() < 1e-3, "{element}");
        assert!((angle("outer_angle") - 31.3329).abs() < 1e-3, "{element}");
    }
}

/// Wang: preload raises the stiffness about as its cube root; unbalance and waviness their lines in proportion.
#[test]
fn preload_unbalance_and_waviness_of_the_angular_pair() {
    // Rigid supports and no film or inertia, where the cube root is the theory.
    let still = |force: &str| {
        let swaps = [("\"500 N\"", force), ("\"500 N\"", force)];
        let mut text = shipped("wang-angular-pair", &swaps);
        for _ in 0..2 {
            text = swap(
                &text,
                "effects = [\"centrifugal\", \"gyroscopic\", \"film\"]\nlubricant = { viscosity = \"0.04 Pa s\", pressure_viscosity = \"2.2e-8 1/Pa\" }\n",
                "",
            );
            text =
                swap(&text, "support = { mass = \"1 kg\", stiffness_x = 2e8, stiffness_y = 2e8, damping = 500 }\n", "");
        }
        let frequencies = equilibrium(&text, &[])["natural_frequencies_hz"].clone();
        // Lowest first: the axial one, then the two radial ones, whose contact angle changes least.
        frequencies[1].as_f64().unwrap()
    };
    // Stiffness grows as the cube root, frequency as its root.
    let slope = (still("\"1000 N\"") / still("\"250 N\"")).log2() / 2.0;
    println!("the radial frequency grows as preload^{slope:.3}");
    assert!((slope - 1.0 / 6.0).abs() < 0.04, "{slope}");

    let lines = |swaps: &[(&str, &str)]| {
        let response = Response::of(&shipped("wang-angular-pair", swaps), 12_800.0, 2_560, 0.1);
        assert_eq!(response.header.len(), 1 + 2 * 9 + 10, "nine coordinates");
        // Order 15 = N + 1 of the inner race, seen from the fixed frame: N (f_i - f_c) + f_i along X.
        let cage = 100.0 * 0.5 * (1.0 - 7.0 / 38.5 * 25_f64.to_radians().cos());
        [response.line("u", 100.0), response.line("u", 14.0 * (100.0 - cage) + 100.0)]
    };
    let base = lines(&[]);
    let double = lines(&[("\"2 g mm\"", "\"4 g mm\"")]);
    let wavier = lines(&[("\"0.05 um\"", "\"0.1 um\""), ("\"0.05 um\"", "\"0.1 um\"")]);
    println!("1X and wave line, um: {base:.5?}, twice the unbalance {double:.5?}, twice the waviness {wavier:.5?}");
    assert!((double[0] / base[0] - 2.0).abs() < 0.02 && (double[1] / base[1] - 1.0).abs() < 0.02);
    assert!((wavier[0] / base[0] - 1.0).abs() < 0.02 && (wavier[1] / base[1] - 2.0).abs() < 0.05);
}

/// Every scene is listed, read and simulated (or, without a rotor, brought to equilibrium).
#[test]
fn all_of_them_run() {
    let listed: Value = Sandbox::empty().done(&["scenes", "--format", "json"]).json();
    let listed = listed.as_array().unwrap();
    assert_eq!(listed.len(), 17);
    for one in listed {
        let name = one["name"].as_str().unwrap();
        assert!(one["shows"].as_str().unwrap().len() > 20, "{one}");
        let text = shipped(name, &[]);
        let first = text.lines().next().unwrap();
        assert!(first.starts_with("# "), "{first}");
        assert!(equilibrium(&text, &[])["residual"].as_f64().unwrap() < 1e-6, "{name}");
        if text.contains("[rotor]") {
            assert_eq!(Response::of(&text, 25_600.0, 256, 0.01).rows.len(), 256, "{name}");
        }
    }
    Sandbox::empty().refused(&["scenes", "tiwary"], 2, &["unknown scene: \"tiwary\"", "tiwari-balanced"]);
}

/// Force of a bearing by its name.
fn force_of(settled: &Value, name: &str) -> [f64; 5] {
    let bearings = settled["bearings"].as_array().unwrap();
    let bearing = bearings.iter().find(|bearing| bearing["name"] == name).unwrap();
    std::array::from_fn(|i| bearing["force"][i].as_f64().unwrap())
}

/// Tapered pair: equilibrium of the thrusts; preload raises stiffness and the load of the relieved bearing.
#[test]
fn preload_of_the_tapered_pair() {
    let preloads = ["2 um", "8 um", "20 um"].map(|preload| {
        let preload = format!("\"{preload}\"");
        let swaps = [("\"8 um\"", preload.as_str()); 2];
        let settled = equilibrium(&shipped("tapered-32008-pair", &swaps), &[]);
        let (left, right) = (force_of(&settled, "left"), force_of(&settled, "right"));
        assert!((left[2] + right[2] + 800.0).abs() < 1e-3, "{left:?} {right:?}");
        assert!((left[0] + right[0] + 2000.0).abs() < 1e-3 && left[2] > 0.0 && right[2] < 0.0);
        let stiffness = settled["stiffness"][0][0].as_f64().unwrap();
        [stiffness, left[2], -settled["displacement"][4].as_f64().unwrap().abs()]
    });
    for pair in preloads.windows(2) {
        assert!(pair[0].iter().zip(&pair[1]).all(|(less, more)| less < more), "{preloads:?}");
    }
}

/// Spherical rollers: no moment by tilt; one row carries the thrust.
#[test]
fn spherical_rollers_align_themselves() {
    let settled = equilibrium(&shipped("spherical-22210-fan", &[]), &[]);
    let rows = |settled: &Value| {
        let load = |element: &Value| element["inner_load"].as_f64().unwrap();
        let de: Vec<f64> =
            settled["elements"].as_array().unwrap().iter().filter(|e| e["bearing"] == "DE").map(load).collect();
        assert_eq!(de.len(), 34);
        let (first, second) = de.split_at(17);
        [first.iter().sum::<f64>(), second.iter().sum::<f64>()]
    };
    let [first, second] = rows(&settled);
    assert!(first > 0.0 && second == 0.0, "{first} {second}");
    let force = force_of(&settled, "DE");
    assert!(force[3].abs() < 1e-9 && force[4].abs() < 1e-9, "{force:?}");
    let without = equilibrium(&shipped("spherical-22210-fan", &[("[0, 0, \"400 N\", 0, 0]", "[0, 0, 0, 0, 0]")]), &[]);
    let [first, second] = rows(&without);
    assert!((first / second - 1.0).abs() < 0.02, "{first} {second}");
    // A tilted ring has the same force.
    let scene = shipped("spherical-22210-fan", &[]);
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", &scene);
    sandbox.put("u.csv", "u,v,w,thu,thv\n5e-6,-2e-5,1e-5,0,0\n5e-6,-2e-5,1e-5,2e-3,-3e-3\n");
    let args = ["force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv", "--format", "csv"];
    let out = sandbox.done(&args).out;
    let rows: Vec<&str> = out.lines().skip(1).collect();
    assert_eq!(rows[0], rows[1]);
}
