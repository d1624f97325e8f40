//! Free and supported rotors against ROSS 2.3.0 (`tests/golden/rotor_fe.json`).

use crate::{Plant, response};
use ballrace::Phase;
use ballrace::rotor::ShaftMotion;
use ballrace_base::eigenvalues::eigenvalues;
use ballrace_scene::flexible_rotor::{ForceStations, FreeRotor, Mesh, ReducedRotor, rigid_body};
use ballrace_scene::read::read_str;
use ballrace_scene::{Disk, FlexibleRotor, Section};
use nalgebra::{Complex, DMatrix, DVector};
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;

const GOLDEN: &str = include_str!("../../../tests/golden/rotor_fe.json");

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
    let forces = ForceStations { radial: &bearings, axial: &[] };
    (ReducedRotor::try_new(free.into(), count, forces, 2000.0).unwrap(), centre)
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
                let found: Complex<f64> = row.iter().zip(amplitude.iter()).map(|(a, x)| x * *a).sum();
                let expected = Complex::new(number(&at["x"][i][0]), number(&at["x"][i][1]));
                let off = (found - expected).norm() / expected.norm();
                assert!(off < 5e-3, "{speed} rpm: {found} instead of {expected}");
            }
        }
    }
}

/// Run-up through the first critical speed: speeds in revolutions per second from and to, duration and sample period, s.
const RUN_UP: [f64; 4] = [85.0, 130.0, 1.0, 4e-5];
/// Damping of the rotor in proportion to its mass, 1/s: 1.5 % of critical damping in the first mode.
const MASS_DAMPING: f64 = 20.0;

/// Speed (revolutions per second), angle (revolutions) and acceleration at a time of the run-up.
fn run_up(time: f64) -> [f64; 3] {
    let [from, to, over, _] = RUN_UP;
    let acceleration = (to - from) / over;
    [from + acceleration * time, (from + 0.5 * acceleration * time) * time, acceleration]
}

/// Returns speed (revolutions per second) and size of the largest of the displacements, one for each sample of the run-up.
fn peak(displacements: impl Iterator<Item = f64>) -> [f64; 2] {
    let indexed = displacements.enumerate().map(|(i, size)| [run_up(i as f64 * RUN_UP[3])[0], size]);
    indexed.fold([0.0; 2], |peak, at| if at[1] > peak[1] { at } else { peak })
}

/// The scene of a case's rotor on springs.
fn scene(case: &Value) -> String {
    let section = |s: &Value| {
        format!("{{ from = {}, to = {}, outer_diameter = {}, inner_diameter = {} }}", s["f"], s["t"], s["od"], s["id"])
    };
    let disk = |d: &Value| {
        format!(
            "{{ station = {}, mass = {}, diametral_inertia = {}, polar_inertia = {} }}",
            d["z"], d["m"], d["Id"], d["Ip"]
        )
    };
    let stiffness = &case["on_springs"]["stiffness"];
    let bearing = |z: &Value| {
        format!(
            r#"
[[bearing]]
name = "at {z}"
station = {z}
model = "linear"
elements = 8
stiffness_matrix = [
    [{stiffness}, 0, 0, 0, 0], [0, {stiffness}, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0],
]
"#
        )
    };
    let all = |key: &str, entry: &dyn Fn(&Value) -> String, between: &str| {
        case["rotor"][key].as_array().unwrap().iter().map(entry).collect::<Vec<_>>().join(between)
    };
    let (material, unbalance) = (&case["material"], &case["on_springs"]["unbalance"]);
    format!(
        r#"
[shaft]
speed = "{} rev/s"
[rotor]
sections = [{}]
disks = [{}]
youngs_modulus = {}
poissons_ratio = {}
density = {}
gravity = [0, 0, 0]
proportional_damping = {{ mass = {MASS_DAMPING}, stiffness = 0 }}
unbalance = [{{ moment = {}, angle = {}, station = {} }}]
{}"#,
        0.5 * (RUN_UP[0] + RUN_UP[1]),
        all("sections", &section, ", "),
        all("disks", &disk, ", "),
        material["youngs_modulus"],
        material["poissons_ratio"],
        material["density"],
        unbalance["moment"],
        unbalance["angle"],
        unbalance["station"],
        all("bz", &bearing, ""),
    )
}

/// Peak of the displacement at the unbalance by the twin, whose rotor is reduced.
fn reduced_peak(case: &Value) -> [f64; 2] {
    let scene = read_str(&scene(case), Path::new("scene.toml")).unwrap();
    let plant = Plant::try_new(&scene).unwrap();
    assert!(plant.layout.order <= 32, "{} coordinates", plant.layout.order);
    let (_, centre) = drawing(case);
    let [x, y, ..] = plant.layout.rows(number(&case["on_springs"]["unbalance"]["station"]) - centre);
    let mut twin = plant.start(RUN_UP[3], 0.0).unwrap();
    peak((0..(RUN_UP[2] / RUN_UP[3]) as u32).map(|i| {
        let along = |row: &[f64]| row.iter().zip(twin.coordinates()).map(|(a, q)| a * q).sum::<f64>();
        let size = along(&x).hypot(along(&y));
        let [speed, revolutions, acceleration] = run_up(f64::from(i) * RUN_UP[3]);
        twin.step(&ShaftMotion {
            angle: Phase::from_revolutions(revolutions),
            speed: TAU * speed,
            acceleration: TAU * acceleration,
        });
        size
    }))
}

/// The same by the finite-element model. Real and imaginary part are the displacements in the two planes; Newmark's method with
/// constant average acceleration integrates them.
fn full_peak(case: &Value) -> [f64; 2] {
    let (drawn, centre) = drawing(case);
    let given = &case["on_springs"]["unbalance"];
    let bearings: Vec<f64> = case["rotor"]["bz"].as_array().unwrap().iter().map(|z| number(z) - centre).collect();
    let station = number(&given["station"]) - centre;
    let mesh = FreeRotor::try_new(&drawn, &[bearings.clone(), vec![station]].concat(), 2000.0).unwrap().mesh;
    let n = mesh.mass.nrows();
    let mut stiffness = mesh.stiffness.map(Complex::from);
    for z in bearings {
        let at = 2 * mesh.node(z);
        stiffness[(at, at)] += number(&case["on_springs"]["stiffness"]);
    }
    let step = RUN_UP[3];
    let [half, quarter] = [0.5 * step, 0.25 * step * step].map(Complex::from);
    let at = 2 * mesh.node(station);
    let mut state: [DVector<Complex<f64>>; 3] = std::array::from_fn(|_| DVector::zeros(n));
    let (mut damping, mut solver) = (DMatrix::zeros(n, n), None);
    peak((1..=(RUN_UP[2] / step) as u32).map(|i| {
        let [x, v, a] = &state;
        let size = x[at].norm();
        let [speed, revolutions, acceleration] = run_up(f64::from(i) * step).map(|of| TAU * of);
        // The speed changes by less than a thousandth in fifty steps.
        if i % 50 == 1 {
            damping = mesh.mass.zip_map(&mesh.polar, |m, p| Complex::new(MASS_DAMPING * m, -speed * p));
            solver = Some((mesh.mass.map(Complex::from) + &damping * half + &stiffness * quarter).lu());
        }
        let moved = x + v * Complex::from(step) + a * quarter;
        let faster = v + a * half;
        let mut right = -(&stiffness * &moved + &damping * &faster);
        let force = Complex::new(speed * speed, -acceleration) * number(&given["moment"]);
        right[at] += force * Complex::from_polar(1.0, revolutions + number(&given["angle"]));
        let next = solver.as_ref().unwrap().solve(&right).unwrap();
        state = [moved + &next * quarter, faster + &next * half, next];
        size
    }))
}

#[test]
fn a_reduced_rotor_passes_its_first_critical_speed_as_the_finite_element_model_does() {
    let case = &cases()[0];
    let ([speed, size], [expected_speed, expected]) = (reduced_peak(case), full_peak(case));
    println!("{size:e} m at {speed} rev/s; unreduced: {expected:e} m at {expected_speed} rev/s");
    // The critical speed is 106.65 rev/s. The peak comes later, because the speed goes on while the motion builds up.
    assert!((106.65..115.0).contains(&expected_speed), "{expected_speed}");
    assert!(expected > 10.0 * number(&case["on_springs"]["unbalance"]["moment"]) / number(&case["mass"]), "{expected}");
    assert!((speed / expected_speed - 1.0).abs() < 1e-3, "{speed} instead of {expected_speed}");
    assert!((size / expected - 1.0).abs() < 1e-3, "{size} instead of {expected}");
}

/// A shaft with a stepped contour, drawn in `pieces` sections for each step, and disks that are not at nodes of a coarse mesh.
fn stepped(pieces: usize) -> FlexibleRotor {
    let steps = [0.04, 0.05, 0.035, 0.045];
    let length = 0.25;
    let section = |i: usize| {
        let (from, to) = (i as f64 / pieces as f64 * length, (i + 1) as f64 / pieces as f64 * length);
        let diameter = steps[i / pieces];
        Section { from, to, outer_diameter: diameter, outer_diameter_to: diameter, inner_diameter: 0.01 }
    };
    let disk = |station: f64| Disk { station, mass: 4.0, diametral_inertia: 0.02, polar_inertia: 0.04, size: None };
    FlexibleRotor {
        sections: (0..steps.len() * pieces).map(section).collect(),
        disks: [0.123_456, 0.5, 0.777_7].map(disk).to_vec(),
        youngs_modulus: 2.1e11,
        poissons_ratio: 0.3,
        density: 7850.0,
        proportional_damping: [0.0; 2],
        modal_damping: 0.0,
        load_station: 0.0,
        coordinates: None,
    }
}

/// Condensed elements between the nodes: thousands of sections have the frequencies, mass and polar inertia of few, with the nodes of few.
#[test]
fn many_sections_are_condensed() {
    let kept = [0.05, 0.9];
    let few = FreeRotor::try_new(&stepped(1), &kept, 2000.0).unwrap();
    for pieces in [20, 500] {
        let rotor = stepped(pieces);
        let many = FreeRotor::try_new(&rotor, &kept, 2000.0).unwrap();
        assert!(many.mesh.stations.len() < 120, "{} nodes", many.mesh.stations.len());
        for station in kept.iter().chain(rotor.disks.iter().map(|disk| &disk.station)) {
            assert!((many.mesh.stations[many.mesh.node(*station)] - station).abs() < 1e-9);
        }
        let pairs = [(&few.bending, &many.bending, 2), (&few.axial, &many.axial, 1)];
        for (few, many, rigid) in pairs {
            for (i, (a, b)) in few.frequencies(rigid).zip(many.frequencies(rigid)).take(4).enumerate() {
                assert!((a / b - 1.0).abs() < 2e-3, "{pieces} pieces, mode {i}: {a} Hz, {b} Hz");
            }
        }
        let turned = |mesh: &Mesh| {
            let rotation =
                DVector::from_fn(mesh.polar.nrows(), |i, _| if i % 2 == 0 { mesh.stations[i / 2] } else { 1.0 });
            (rotation.transpose() * &mesh.polar * &rotation)[(0, 0)]
        };
        assert!((turned(&many.mesh) / turned(&few.mesh) - 1.0).abs() < 1e-9);
        assert!((many.mesh.axial_mass.sum() / few.mesh.axial_mass.sum() - 1.0).abs() < 1e-9);
    }
}
