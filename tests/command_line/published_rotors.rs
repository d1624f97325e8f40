//! Rotors of the book of Friswell et al. and of ROSS, with the numbers that both print, against `campbell`.
//!
//! Source: Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), examples 5.9.1 to 5.9.9, as ROSS checks itself against
//! (`ross/tests/test_examples.py` at commit 631a249a, MIT licence), and the example of ROSS's own documentation
//! (`Rotor.run_critical_speed`). The shaft is 1.5 m long, of 50 mm diameter; disks are 70 mm wide.

use crate::support::{Sandbox, list};
use serde_json::Value;
use std::f64::consts::TAU;

/// Stiffness along X and Y and damping of both bearings.
struct Support {
    stiffness: [f64; 2],
    damping: f64,
}

const ISOTROPIC: Support = Support { stiffness: [1e6, 1e6], damping: 0.0 };
const TWO_DISKS: &[[f64; 2]] = &[[500.0, 280.0], [1000.0, 350.0]];

/// Returns the scene of a shaft with disks (station and diameter, mm) on bearings at two stations.
fn scene(disks: &[[f64; 2]], bearings: [f64; 2], of: &Support) -> String {
    let disk =
        |[z, d]: &[f64; 2]| format!("{{ station = \"{z} mm\", outer_diameter = \"{d} mm\", width = \"70 mm\" }}");
    let bearing = |(i, z): (usize, &f64)| {
        let [x, y] = of.stiffness;
        // A damped bearing is a support below a stiff one.
        let (x, y, support) = match of.damping {
            0.0 => (x, y, String::new()),
            c => (
                1e12,
                1e12,
                format!("support = {{ mass = \"1 g\", stiffness_x = {x}, stiffness_y = {y}, damping = {c} }}\n"),
            ),
        };
        // One bearing holds the rotor along the axis, far stiffer than the modes compared.
        let z_stiffness = if i == 0 { 1e9 } else { 0.0 };
        format!(
            "[[bearing]]\nname = \"{i}\"\nstation = \"{z} mm\"\nmodel = \"linear\"\nelements = 8\nstiffness_matrix = [[{x}, 0, 0, 0, 0], \
             [0, {y}, 0, 0, 0], [0, 0, {z_stiffness}, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]\n{support}"
        )
    };
    // Shear modulus 81.2 GPa.
    format!(
        "name = \"published\"\n[shaft]\nspeed = \"4000 rpm\"\n[rotor]\nyoungs_modulus = \"211 GPa\"\npoissons_ratio = {}\ndensity = 7810\n\
         sections = [{{ from = \"0 mm\", to = \"1500 mm\", outer_diameter = \"50 mm\" }}]\ndisks = [{}]\n{}",
        211.0 / (2.0 * 81.2) - 1.0,
        disks.iter().map(disk).collect::<Vec<_>>().join(", "),
        bearings.iter().enumerate().map(bearing).collect::<String>()
    )
}

/// Returns damped frequency (rad/s) and damping ratio of each mode at 0 and 4000 rpm.
fn modes(scene: String) -> [Vec<[f64; 2]>; 2] {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene);
    let answer: Value =
        sandbox.done(&["campbell", "scene.toml", "--speeds", "0rpm,4000rpm", "--format", "json"]).json();
    [0, 1].map(|speed| {
        let number = |mode: &Value, key: &str| mode[key].as_f64().unwrap();
        let mode = |mode: &Value| [TAU * number(mode, "frequency_hz"), number(mode, "damping_ratio")];
        list(&answer[speed], "modes").iter().map(mode).collect()
    })
}

/// Largest relative difference of the lowest frequencies.
fn difference(found: impl Iterator<Item = f64>, published: &[f64]) -> f64 {
    found.zip(published).map(|(found, published)| (found / published - 1.0).abs()).fold(0.0, f64::max)
}

/// ROSS prints a torsional mode of 650.41 rad/s among these, which a shaft that turns at a given speed has not.
#[test]
fn natural_frequencies_of_friswell() {
    let anisotropic = Support { stiffness: [1e6, 8e5], damping: 0.0 };
    let stiff = Support { stiffness: [1e7, 1e7], damping: 0.0 };
    type Example<'a> = (&'a str, &'a [[f64; 2]], [f64; 2], &'a Support, [&'a [f64]; 2]);
    let examples: [Example; 3] = [
        (
            "5.9.1, isotropic",
            TWO_DISKS,
            [0.0, 1500.0],
            &ISOTROPIC,
            [&[86.66, 86.66, 274.31, 274.31, 716.78], &[85.39, 87.80, 251.78, 294.71, 600.18]],
        ),
        (
            "5.9.2, anisotropic",
            TWO_DISKS,
            [0.0, 1500.0],
            &anisotropic,
            [&[82.65, 86.66, 254.52, 274.31, 679.49], &[82.33, 86.86, 239.64, 287.25, 583.49]],
        ),
        (
            "5.9.9, overhung",
            &[[1500.0, 350.0]],
            [0.0, 1000.0],
            &stiff,
            [&[90.14, 90.14, 630.73, 630.73, 830.43, 830.43], &[76.19, 103.91, 565.99, 634.23, 647.75, 1174.2]],
        ),
    ];
    for (name, disks, bearings, support, published) in examples {
        let found = modes(scene(disks, bearings, support));
        for (speed, (found, published)) in found.iter().zip(published).enumerate() {
            let off = difference(found.iter().map(|mode| mode[0]), published);
            println!("{name}, speed {speed}: {:.3} %", 100.0 * off);
            assert!(off < 6e-4, "{name}: {off} {found:?}");
        }
    }
}

/// Example 5.9.5: dampers of 3 kN s/m at the bearings. ROSS prints natural and damped frequencies in Hz with four digits.
#[test]
fn damped_frequencies_of_friswell() {
    let damped = Support { damping: 3e3, ..ISOTROPIC };
    let natural: [&[f64]; 2] = [&[13.91, 13.91, 48.18, 48.18, 137.06], &[13.70, 14.09, 43.61, 52.18, 122.37]];
    let oscillating: [&[f64]; 2] = [&[13.89, 13.89, 46.54, 46.54, 103.22], &[13.68, 14.07, 41.98, 50.65, 104.25]];
    let found = modes(scene(TWO_DISKS, [0.0, 1500.0], &damped));
    for (speed, found) in found.iter().enumerate() {
        let undamped = found.iter().map(|[omega, ratio]| omega / (1.0 - ratio * ratio).sqrt() / TAU);
        let off = difference(undamped, natural[speed])
            .max(difference(found.iter().map(|mode| mode[0] / TAU), oscillating[speed]));
        println!("5.9.5, speed {speed}: {:.3} %", 100.0 * off);
        assert!(off < 1.5e-3, "{off} {found:?}");
    }
}

/// Critical speeds of ROSS's example rotor in rpm: the lowest two from whole rad/s, without its torsional one at 7394 rpm.
#[test]
fn critical_speeds_of_the_example_of_ross() {
    let support = Support { stiffness: [1e6, 8e5], damping: 0.0 };
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene(&[[500.0, 280.0], [1000.0, 280.0]], [0.0, 1500.0], &support));
    let text = sandbox.done(&["campbell", "scene.toml", "--speeds", "0rpm..9000rpm:31"]).out;
    let once_per_turn = text.lines().filter(|line| line.contains(" rpm  1X "));
    let found: Vec<f64> = once_per_turn.map(|line| line.split_whitespace().next().unwrap().parse().unwrap()).collect();
    let rpm = 60.0 / TAU;
    let published =
        [(92.0 * rpm, 0.5 * rpm), (96.0 * rpm, 0.5 * rpm), (2590.0, 0.5), (2868.0, 0.5), (6074.0, 0.5), (8278.0, 0.5)];
    assert_eq!(found.len(), published.len(), "{text}");
    for (found, (published, digit)) in found.into_iter().zip(published) {
        println!("{found} against {published:.0} rpm: {:.3} %", 100.0 * (found / published - 1.0).abs());
        assert!((found - published).abs() < digit + 1e-3 * published, "{found} rpm instead of {published} rpm");
    }
}
