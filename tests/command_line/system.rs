//! `[system]`: a rotor given by its matrices, from Matrix Market and NPY files.

use crate::support::{DEMO_SCENE, Sandbox, TURN, list, number, numbers, swap};
use std::fmt::Write;

/// The demonstration's rotor as matrices, with its two bearings at stations -0.1 and 0.1 m of a rigid body: coordinates
/// are those of two points on the axis, X and Y at each, then Z.
///
/// With `a, b` the displacements at -0.1 and 0.1 m: `u = (a + b)/2`, `thv = (b - a)/0.2`, and `thu = (c - d)/0.2` of Y.
const HALF: f64 = 0.1;
const MASS: [f64; 3] = [6.0, 0.030, 0.006];

/// `T^T diag T` for the pair of coordinates of one direction: translation and tilt.
fn pair(along: f64, tilt: f64) -> [[f64; 2]; 2] {
    let (s, t) = (along / 4.0, tilt / (4.0 * HALF * HALF));
    [[s + t, s - t], [s - t, s + t]]
}

/// 5 x 5 over X at both points, Y at both, Z.
fn whole(along: f64, tilt: f64, axial: f64) -> [[f64; 5]; 5] {
    let mut all = [[0.0; 5]; 5];
    let block = pair(along, tilt);
    for i in 0..2 {
        for j in 0..2 {
            all[i][j] = block[i][j];
            all[2 + i][2 + j] = block[i][j];
        }
    }
    all[4][4] = axial;
    all
}

/// `G[thu, thv] = I_p`: of X on Y through both tilts. thv = (b - a)/0.2, thu = (c - d)/0.2 with c, d along Y.
fn gyroscopic() -> [[f64; 5]; 5] {
    let mut all = [[0.0; 5]; 5];
    let thv = [-1.0, 1.0, 0.0, 0.0, 0.0].map(|x: f64| x / (2.0 * HALF));
    let thu = [0.0, 0.0, 1.0, -1.0, 0.0].map(|x: f64| x / (2.0 * HALF));
    for i in 0..5 {
        for j in 0..5 {
            all[i][j] = MASS[2] * (thu[i] * thv[j] - thv[i] * thu[j]);
        }
    }
    all
}

fn market(matrix: &[[f64; 5]; 5], kind: &str) -> String {
    let mut entries = String::new();
    let mut count = 0;
    for (i, row) in matrix.iter().enumerate() {
        for (j, x) in row.iter().enumerate() {
            let told = match kind {
                "symmetric" => j <= i,
                "skew-symmetric" => j < i,
                _ => true,
            };
            if told && *x != 0.0 {
                count += 1;
                writeln!(entries, "{} {} {x:e}", i + 1, j + 1).unwrap();
            }
        }
    }
    format!("%%MatrixMarket matrix coordinate real {kind}\n% of a test\n5 5 {count}\n{entries}")
}

/// NPY version 1, float64, in the order of rows.
fn npy(numbers: &[f64], shape: &str) -> Vec<u8> {
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let padded = format!("{head:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(padded.len()).unwrap().to_le_bytes());
    bytes.extend(padded.bytes());
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// The demonstration on its matrices; its unbalance of one plane is spread over the two points.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("M.mtx", market(&whole(MASS[0], MASS[1], MASS[0]), "symmetric"));
    sandbox.put("B.npy", npy(whole(400.0, 0.4, 400.0).as_flattened(), "(5, 5)"));
    sandbox.put("G.mtx", market(&gyroscopic(), "skew-symmetric"));
    sandbox.put("K.mtx", market(&[[0.0; 5]; 5], "general"));
    let weight = -6.0 * 9.80665 / 2.0;
    sandbox.put("f.npy", npy(&[0.0, 0.0, weight, weight, 60.0], "(5,)"));
    let (head, rest) = DEMO_SCENE.split_once("[rotor]").unwrap();
    let (_, bearings) = rest.split_once("[[bearing]]").unwrap();
    let (bearings, _) = bearings.split_once("[recording]").unwrap();
    // 120 g mm at 20 mm: 0.4 of it at -100 mm and 0.6 at 100 mm.
    let system = "[system]\nmass = \"M.mtx\"\ndamping = \"B.npy\"\ngyroscopic = \"G.mtx\"\nstiffness = \"K.mtx\"\nload = \"f.npy\"\n\
        unbalance = [{ moment = \"48 g mm\", angle = \"0.3 rad\", x = 1, y = 3 }, { moment = \"72 g mm\", angle = \"0.3 rad\", x = 2, y = 4 }]\n\n";
    let bearings = swap(bearings, "station = \"-100 mm\"", "coordinates = [1, 3, 5, 0, 0]");
    let bearings = swap(&bearings, "station = \"100 mm\"", "coordinates = [2, 4, 5, 0, 0]");
    sandbox.put("scene.toml", format!("{head}{system}[[bearing]]{bearings}"));
    sandbox
}

/// The same motion as the rigid rotor's in other coordinates. Tilt at the bearings is omitted here, so the
/// bearings of the other rotor are held against tilting forces of their own by looking at one that has none.
#[test]
fn a_rotor_from_matrices_moves_as_the_rigid_one() {
    let lumped = |text: &str| {
        text.replace("model = \"angular\"", "model = \"lumped\"\naxial = { stiffness = 1e9, play = 0, radius = 0 }")
    };
    let args = |out: &'static str| ["simulate", "scene.toml", "--duration", "0.1 s", "--rate", "12.8 kHz", "-o", out];
    let matrices = sandbox();
    let text = lumped(&matrices.read("scene.toml"));
    matrices.put("scene.toml", text + "\n[integration]\nstep = \"10 us\"\n");
    matrices.done(&args("m.csv"));
    let rigid = Sandbox::empty();
    let (scene, _) = DEMO_SCENE.split_once("[recording]").unwrap();
    rigid.put("scene.toml", lumped(scene) + "\n[integration]\nstep = \"10 us\"\n");
    rigid.done(&args("m.csv"));
    let ((head, mine), (_, other)) = (numbers(&matrices.read("m.csv")), numbers(&rigid.read("m.csv")));
    assert_eq!(head[..7].join(","), "t,q1,q2,q3,q4,q5,q1_dot");
    for (mine, other) in mine.iter().zip(&other) {
        let (u, v, w, thu, thv) = (other[1], other[2], other[3], other[4], other[5]);
        let expected = [u - HALF * thv, u + HALF * thv, v + HALF * thu, v - HALF * thu, w];
        for (q, x) in mine[1..6].iter().zip(expected) {
            assert!((q - x).abs() < 1e-12, "t = {}: {q} {x}", mine[0]);
        }
        // Forces on the inner rings, moments apart.
        for i in [0, 1, 2, 5, 6, 7] {
            assert!((mine[11 + i] - other[11 + i]).abs() < 1e-5, "{i}");
        }
    }
}

/// A MATLAB file of version 5 with these matrices, as `scipy.io.savemat` and MATLAB's `save -v6` write it.
fn mat(matrices: &[(&str, [i32; 2], Vec<f64>)]) -> Vec<u8> {
    let element = |kind: u32, bytes: &[u8]| {
        let mut out = [kind.to_le_bytes(), u32::try_from(bytes.len()).unwrap().to_le_bytes()].concat();
        out.extend(bytes);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let mut out = b"MATLAB 5.0 MAT-file".to_vec();
    out.resize(124, b' ');
    out.extend([0, 1, b'I', b'M']);
    for (name, size, numbers) in matrices {
        let size: Vec<u8> = size.iter().flat_map(|n| n.to_le_bytes()).collect();
        let numbers: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let flags = element(6, &[6, 0, 0, 0, 0, 0, 0, 0]);
        let parts = [flags, element(5, &size), element(1, name.as_bytes()), element(9, &numbers)];
        out.extend(element(14, &parts.concat()));
    }
    out
}

/// One MATLAB file with M, C, G, K and F gives the same motion as five files of other formats.
#[test]
fn a_matlab_file_has_all_matrices() {
    let args = ["simulate", "scene.toml", "--duration", "0.02 s", "--rate", "12.8 kHz", "-o", "m.csv"];
    let several = sandbox();
    several.done(&args);
    let one = sandbox();
    // By columns.
    let columns = |m: [[f64; 5]; 5]| (0..25).map(|i| m[i % 5][i / 5]).collect::<Vec<f64>>();
    let weight = -6.0 * 9.80665 / 2.0;
    let file = mat(&[
        ("K", [5, 5], vec![0.0; 25]),
        ("M", [5, 5], columns(whole(MASS[0], MASS[1], MASS[0]))),
        ("G", [5, 5], columns(gyroscopic())),
        ("C", [5, 5], columns(whole(400.0, 0.4, 400.0))),
        ("F", [5, 1], vec![0.0, 0.0, weight, weight, 60.0]),
    ]);
    one.put("rotor.mat", &file);
    let text = ["M.mtx", "B.npy", "G.mtx", "K.mtx", "f.npy"]
        .iter()
        .fold(one.read("scene.toml"), |text, name| swap(&text, name, "rotor.mat"));
    one.put("scene.toml", text);
    one.done(&args);
    assert_eq!(one.read("m.csv"), several.read("m.csv"));
    one.put("rotor.mat", mat(&[("M", [1, 1], vec![1.0])]));
    one.refused(&["equilibrium", "scene.toml"], 2, &["rotor.mat", "no matrix F or f among its variables: M"]);
}

/// The same from sparse matrices, as `scipy.io.savemat` writes them.
#[test]
fn a_matlab_file_has_sparse_matrices() {
    let args = ["simulate", "scene.toml", "--duration", "0.02 s", "--rate", "12.8 kHz", "-o", "m.csv"];
    let sandbox = sandbox();
    sandbox.done(&args);
    let (_, full) = numbers(&sandbox.read("m.csv"));
    sandbox.put("rotor.mat", include_bytes!("../../runner/recording/src/mat/sparse-packed.mat"));
    let text = ["M.mtx", "B.npy", "G.mtx", "K.mtx", "f.npy"]
        .iter()
        .fold(sandbox.read("scene.toml"), |text, name| swap(&text, name, "rotor.mat"));
    sandbox.put("scene.toml", text);
    sandbox.done(&args);
    for (a, b) in full.iter().zip(&numbers(&sandbox.read("m.csv")).1) {
        assert!(a[1..6].iter().zip(&b[1..6]).all(|(a, b)| (a - b).abs() < 1e-13), "{a:?} {b:?}");
    }
}

#[test]
fn bad_matrices_are_refused_by_entry() {
    let refused = |file: &str, contents: Vec<u8>, parts: &[&str]| {
        let sandbox = sandbox();
        sandbox.put(file, contents);
        sandbox.refused(&["equilibrium", "scene.toml"], 2, parts);
    };
    let mut crooked = whole(400.0, 0.4, 400.0);
    crooked[3][2] += 1.0;
    refused(
        "B.npy",
        npy(crooked.as_flattened(), "(5, 5)"),
        &["B: invalid matrix", "at row 4, column 3", "a symmetric matrix"],
    );
    refused("B.npy", npy(&[1.0; 4], "(2, 2)"), &["B.npy: wrong size of a matrix: 2 x 2, expected 5 x 5"]);
    refused("B.npy", npy(&[1.0; 20], "(5, 5)"), &["B.npy", "truncated file"]);
    // Found by the fuzzer: braces within braces.
    let nested = include_bytes!("../fuzz/corpus/matrix/nested-header").to_vec();
    refused("B.npy", nested, &["B.npy", "no NPY file of float64"]);
    refused("f.npy", npy(&[1.0; 4], "(4,)"), &["f.npy: wrong number of values: 4, expected 5"]);
    refused(
        "M.mtx",
        b"1 2 3\n".to_vec(),
        &["M.mtx: unknown format of a matrix, expected a Matrix Market, NPY or MATLAB file"],
    );
    refused(
        "M.mtx",
        market(&whole(6.0, -1.0, 6.0), "symmetric").into_bytes(),
        &["M: invalid matrix", "positive definite"],
    );
    refused(
        "G.mtx",
        market(&whole(1.0, 1.0, 1.0), "general").into_bytes(),
        &["G: invalid matrix", "a skew-symmetric matrix"],
    );
    let broken = market(&gyroscopic(), "skew-symmetric").replace("5 5", "5 x");
    refused("G.mtx", broken.into_bytes(), &["G.mtx: invalid Matrix Market file: "]);
}

#[test]
fn keys_that_a_system_excludes() {
    let refused = |from: &str, to: &str, parts: &[&str]| {
        let sandbox = sandbox();
        sandbox.put("scene.toml", swap(&sandbox.read("scene.toml"), from, to));
        sandbox.refused(&["equilibrium", "scene.toml"], 2, parts);
    };
    refused(
        "coordinates = [1, 3, 5, 0, 0]",
        "coordinates = [1, 3, 6, 0, 0]",
        &["bearing DE: coordinates: no such coordinate: 6, expected -5 to 5"],
    );
    refused(
        "coordinates = [1, 3, 5, 0, 0]",
        "station = 0",
        &["bearing[0].station: misplaced key: 0, expected no station or support on a [system]"],
    );
    refused("coordinates = [1, 3, 5, 0, 0]", "coordinates = [1, 3]", &["bearing[0].coordinates", "5 numbers"]);
    refused("x = 1, y = 3", "x = 9, y = 3", &["system.unbalance: no such coordinate: 9, expected 1 to 5"]);
    refused(
        "[system]",
        "[rotor]\nmass = 1\ndiametral_inertia = 1\npolar_inertia = 1\n[system]",
        &["both [rotor] and [system]"],
    );
}

/// The probes of a recording of the demonstration on its matrices; `skew` measures between X and Y of the second point.
const PROBES: &str = r#"
[recording]
file = "recording.csv"
rate = "12.8 kHz"
probes = [
  { column = "DE_X", unit = "um", coordinates = [1, 3, 5, 0, 0], angle = "0 deg", noise = "0.03 um" },
  { column = "DE_Y", unit = "um", coordinates = [1, 3, 5, 0, 0], angle = "90 deg", noise = "0.03 um" },
  { column = "NDE_45", unit = "um", coordinates = [2, 4, 5, 0, 0], angle = "45 deg", noise = "0.03 um" },
  { column = "NDE_135", unit = "um", coordinates = [-2, 4, 5, 0, 0], angle = "45 deg", noise = "0.03 um" },
  { column = "axial", unit = "um", coordinates = [0, 0, 5, 0, 0], axial = true, noise = "0.03 um" },
]
"#;

/// The sandbox with a recording of 40 turns, and the radial forces on both inner rings there.
fn recorded() -> (Sandbox, Vec<[f64; 4]>) {
    let sandbox = sandbox();
    // With 0.4 turns of the cage for one of the shaft, every fifth turn begins as the first.
    let text = sandbox.read("scene.toml").replace("elements = 9", "elements = 9\ncage_ratio = 0.4");
    sandbox.put("scene.toml", text + PROBES);
    let (first, turns) = (50 * TURN, 40 * TURN);
    let duration = format!("{} s", (first + turns) as f64 / 12_800.0);
    sandbox.done(&["simulate", "scene.toml", "--duration", &duration, "--rate", "12.8 kHz", "-o", "m.csv"]);
    let (head, rows) = numbers(&sandbox.read("m.csv"));
    let place = |name: &str| head.iter().position(|column| column == name).unwrap();
    let columns = ["DE_FX", "DE_FY", "NDE_FX", "NDE_FY"].map(place);
    let mut state = 1_u64;
    let mut noise = || {
        let sum: f64 = (0..12)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum();
        0.03e-6 * (sum - 6.0)
    };
    let mut text = "DE_X,DE_Y,NDE_45,NDE_135,axial\n".to_owned();
    let rows = &rows[first..first + turns];
    for row in rows {
        let (q, half) = (&row[1..6], 0.5_f64.sqrt());
        let readings = [q[0], q[2], half * (q[1] + q[3]), half * (q[3] - q[1]), q[4]];
        let cells = readings.map(|x| format!("{:.6}", 1e6 * (x + noise())));
        text += &(cells.join(",") + "\n");
    }
    sandbox.put("recording.csv", text);
    (sandbox, rows.iter().map(|row| columns.map(|column| row[column])).collect())
}

/// Probes by coordinates: the twin follows the motion within the noise of the probes, the observer's forces are those of the simulation.
#[test]
fn a_recording_of_a_system_is_replayed() {
    let (sandbox, truth) = recorded();
    let outcome = sandbox.replay("scene.toml", &["--forces", "forces.csv", "--report", "report.html"]);
    for probe in list(&outcome, "probes") {
        let residual = number(probe, "/residual_rms_um");
        assert!((0.5 * 0.03..1.5 * 0.03).contains(&residual), "{probe:#}");
        assert!(probe["station_mm"].is_null(), "{probe:#}");
    }
    assert_eq!(list(&outcome, "planes").len(), 1, "two probes are at the same coordinates: {outcome:#}");
    assert!(outcome["observer"]["consistent"].as_bool().unwrap(), "{}", outcome["observer"]);
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("The shaft motion is not diagnosed: a [system] has no stations"), "{notes}");
    let (head, forces) = numbers(&sandbox.read("forces.csv"));
    let place = |name: &str| head.iter().position(|column| column.starts_with(name)).unwrap();
    for (i, name) in ["DE_FX", "DE_FY", "NDE_FX", "NDE_FY"].into_iter().enumerate() {
        let rms = |of: &dyn Fn(usize) -> f64| {
            let late = TURN..truth.len();
            (late.clone().map(|t| of(t).powi(2)).sum::<f64>() / late.len() as f64).sqrt()
        };
        let size = rms(&|t| truth[t][i]);
        let off = rms(&|t| forces[t][place(name)] - truth[t][i]);
        assert!(off < 0.02 * size, "{name}: {off} of {size} N");
    }
    let page = sandbox.page("report.html");
    assert!(page.contains("DE_X, 0 deg") && page.contains("that of the [system]") && !page.contains("NaN"));
}

/// Limits, baselines and live operation work on the probes of a system.
#[test]
fn a_system_is_monitored() {
    let (sandbox, _) = recorded();
    sandbox.done(&["replay", "scene.toml", "--learn", "good.json"]);
    let limits = "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X\"\nmax = \"0.1 um\"\n\
                  [[limit]]\nindicator = \"residual\"\ngrowth_db = 6\n";
    sandbox.put("limited.toml", sandbox.read("scene.toml") + limits);
    for more in [&[][..], &["--paced"]] {
        let args = [&["replay", "limited.toml", "--baseline", "good.json", "--format", "json"][..], more].concat();
        let answer = sandbox.run(&args);
        assert_eq!(answer.code, Some(3), "{answer:?}");
        let outcome: serde_json::Value = answer.json();
        let events = list(&outcome, "events");
        assert_eq!(events.len(), 1, "{events:#?}");
        assert_eq!(events[0]["probe"], "DE_X", "{events:#?}");
    }
}

#[test]
fn probes_of_a_system_have_coordinates_that_exist() {
    let sandbox = sandbox();
    let text = sandbox.read("scene.toml") + PROBES;
    sandbox.put("recording.csv", "DE_X,DE_Y,NDE_45,NDE_135,axial\n0,0,0,0,0\n");
    let refused = |from: &str, to: &str, parts: &[&str]| {
        sandbox.put("scene.toml", swap(&text, from, to));
        sandbox.refused(&["replay", "scene.toml"], 2, parts);
    };
    refused(
        "[-2, 4, 5, 0, 0], angle",
        "[-2, 6, 5, 0, 0], angle",
        &["scene.toml: probe NDE_135: coordinates: no such coordinate: 6, expected -5 to 5"],
    );
    refused("coordinates = [-2, 4, 5, 0, 0], ", "", &["missing", "recording.probes[3].coordinates", "5 numbers"]);
    refused("[-2, 4, 5, 0, 0]", "[-2, 4]", &["recording.probes[3].coordinates", "5 numbers"]);
    refused(
        "coordinates = [-2, 4, 5, 0, 0]",
        "station = 0",
        &["recording.probes[3].station: misplaced key: 0, expected no station on a [system]"],
    );
    refused(
        "[0, 0, 5, 0, 0]",
        "[1, 3, 0, 0, 0]",
        &["probe axial: no coordinate along its measuring direction: [1, 3, 0, 0, 0], expected u or v that is not 0"],
    );
    sandbox.put("scene.toml", &text);
    sandbox.refused(&["fit", "scene.toml", "-o", "fitted.toml"], 2, &["[system]: matrices in fit, expected a [rotor]"]);
    let (rotor, probe) = (
        swap(
            DEMO_SCENE,
            "station = \"-120 mm\", angle = \"0 deg\"",
            "coordinates = [1, 2, 0, 0, 0], angle = \"0 deg\"",
        ),
        "recording.probes[0]",
    );
    sandbox.put("scene.toml", rotor);
    sandbox.refused(&["replay", "scene.toml"], 2, &[probe]);
}
