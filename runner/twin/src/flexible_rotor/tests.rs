//! Free and supported rotors against ROSS 2.3.0 (`tests/golden/rotor_fe.json`).

use super::{FreeRotor, ReducedRotor, rigid_body};
use crate::eigenvalues::eigenvalues;
use crate::plant::response;
use crate::scene::{Disk, FlexibleRotor, Section};
use nalgebra::DMatrix;
use serde_json::Value;
use std::f64::consts::TAU;

const GOLDEN: &str = include_str!("../../../../tests/golden/rotor_fe.json");

/// Elastic coordinates in each plane: enough that only the mesh limits the accuracy.
const MODES: usize = 14;

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap()
}

/// Returns the drawing about its centre of mass, and the station of that as drawn.
fn drawing(case: &Value) -> (FlexibleRotor, f64) {
    let (rotor, material) = (&case["rotor"], &case["material"]);
    let section = |s: &Value| Section {
        from: number(&s["f"]),
        to: number(&s["t"]),
        outer_diameter: number(&s["od"]),
        outer_diameter_to: number(&s["od"]),
        inner_diameter: number(&s["id"]),
    };
    let disk = |d: &Value| Disk {
        station: number(&d["z"]),
        mass: number(&d["m"]),
        diametral_inertia: number(&d["Id"]),
        polar_inertia: number(&d["Ip"]),
        size: None,
    };
    let drawn = FlexibleRotor {
        sections: rotor["sections"].as_array().unwrap().iter().map(section).collect(),
        disks: rotor["disks"].as_array().unwrap().iter().map(disk).collect(),
        youngs_modulus: number(&material["youngs_modulus"]),
        poissons_ratio: number(&material["poissons_ratio"]),
        density: number(&material["density"]),
        proportional_damping: [0.0; 2],
        modal_damping: 0.0,
        load_station: 0.0,
        coordinates: None,
    };
    let [mass, centre, _, polar] = rigid_body(&drawn);
    assert!((mass / number(&case["mass"]) - 1.0).abs() < 1e-9);
    assert!((centre / number(&case["centre_of_mass"]) - 1.0).abs() < 1e-9);
    if let Some(expected) = case["polar_inertia"].as_f64() {
        assert!((polar / expected - 1.0).abs() < 1e-9, "{polar} {expected}");
    }
    (drawn.moved(-centre), centre)
}

fn cases() -> Vec<Value> {
    let golden: Value = serde_json::from_str(GOLDEN).unwrap();
    golden["cases"].as_array().unwrap().clone()
}

#[test]
fn free_rotors_have_the_frequencies_of_ross() {
    for case in cases() {
        let (drawn, _) = drawing(&case);
        let free = FreeRotor::try_new(&drawn, &[], 3000.0).unwrap();
        let expected: Vec<f64> = case["free_free_hz"].as_array().unwrap().iter().step_by(2).map(number).collect();
        for (found, expected) in free.bending.frequencies(2).zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }
}

/// Matrices of the reduced rotor on the springs and dampers of a case: mass, damping, gyroscopic matrix, stiffness.
fn on_springs(rotor: &ReducedRotor, case: &Value, centre: f64) -> [DMatrix<f64>; 4] {
    let [mass, gyroscopic, mut stiffness] = rotor.matrices();
    let n = rotor.order();
    let mut damping = DMatrix::zeros(n, n);
    let springs = &case["on_springs"];
    let (k, c) = (number(&springs["stiffness"]), number(&springs["damping"]));
    for z in case["rotor"]["bz"].as_array().unwrap() {
        let rows = rotor.rows(number(z) - centre, n);
        for row in &rows[..2] {
            for i in 0..n {
                for j in 0..n {
                    stiffness[(i, j)] += k * row[i] * row[j];
                    damping[(i, j)] += c * row[i] * row[j];
                }
            }
        }
    }
    // The axial coordinate is held.
    stiffness[(2, 2)] = 1e9;
    [mass, damping, gyroscopic, stiffness]
}

/// Reduces with nodes at all stations of a case.
fn reduced(case: &Value, count: usize) -> (ReducedRotor, f64) {
    let (drawn, centre) = drawing(case);
    let bearings: Vec<f64> = case["rotor"]["bz"].as_array().unwrap().iter().map(|z| number(z) - centre).collect();
    let mut kept = bearings.clone();
    kept.push(number(&case["on_springs"]["unbalance"]["station"]) - centre);
    kept.extend(case["on_springs"]["x_response"].as_array().unwrap().iter().map(|r| number(&r["station"]) - centre));
    let free = FreeRotor::try_new(&drawn, &kept, 2000.0).unwrap();
    (ReducedRotor::try_new(free.into(), count, &bearings, 2000.0).unwrap(), centre)
}

#[test]
fn rotors_on_springs_have_the_frequencies_of_ross() {
    for case in cases() {
        let (rotor, centre) = reduced(&case, MODES);
        let [mass, damping, gyroscopic, stiffness] = on_springs(&rotor, &case, centre);
        let n = rotor.order();
        let inverse = mass.try_inverse().unwrap();
        for (speed, modes) in case["on_springs"]["modes_by_rpm"].as_object().unwrap() {
            let speed = speed.parse::<f64>().unwrap() * TAU / 60.0;
            let mut state = DMatrix::zeros(2 * n, 2 * n);
            state.view_mut((0, n), (n, n)).fill_with_identity();
            state.view_mut((n, 0), (n, n)).copy_from(&(-&inverse * &stiffness));
            state.view_mut((n, n), (n, n)).copy_from(&(-&inverse * (&damping + speed * &gyroscopic)));
            let found: Vec<f64> =
                eigenvalues(&state).unwrap().iter().filter(|e| e.im > 0.0).map(|e| e.im / TAU).collect();
            for mode in modes.as_array().unwrap() {
                // A mode without damping is a torsional one.
                if number(&mode["log_dec"]).abs() < 1e-6 {
                    continue;
                }
                let expected = number(&mode["hz"]);
                let nearest = found.iter().map(|f| (f / expected - 1.0).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-3, "{expected} Hz at {speed} rad/s: off by {nearest}");
            }
        }
    }
}

#[test]
fn rotors_on_springs_have_the_unbalance_response_of_ross() {
    for case in cases() {
        let (rotor, centre) = reduced(&case, MODES);
        let [mass, damping, gyroscopic, stiffness] = on_springs(&rotor, &case, centre);
        let n = rotor.order();
        let given = &case["on_springs"]["unbalance"];
        let (sin, cos) = number(&given["angle"]).sin_cos();
        let rows = rotor.rows(number(&given["station"]) - centre, n);
        let moment = number(&given["moment"]);
        let unbalance: Vec<[f64; 2]> = (0..n)
            .map(|i| {
                let (x, y) = (moment * rows[0][i], moment * rows[1][i]);
                [x * cos + y * sin, -x * sin + y * cos]
            })
            .collect();
        let speeds = case["on_springs"]["speeds_rpm"].as_array().unwrap();
        for (i, speed) in speeds.iter().enumerate() {
            let amplitude =
                response([&mass, &damping, &gyroscopic, &stiffness], &unbalance, number(speed) * TAU / 60.0);
            for at in case["on_springs"]["x_response"].as_array().unwrap() {
                let row = &rotor.rows(number(&at["station"]) - centre, n)[0];
                let found: nalgebra::Complex<f64> = row.iter().zip(amplitude.iter()).map(|(a, x)| x * *a).sum();
                let expected = nalgebra::Complex::new(number(&at["x"][i][0]), number(&at["x"][i][1]));
                let off = (found - expected).norm() / expected.norm();
                assert!(off < 5e-3, "{speed} rpm: {found} instead of {expected}");
            }
        }
    }
}
