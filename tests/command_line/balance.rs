//! `ballrace balance`: masses of simulated rotors against an independent least-squares program, measured vectors, and wrong tables.

use crate::support::Sandbox;
use serde_json::Value;
use std::fmt::Write;

/// Complex number as real and imaginary part.
pub type Pair = [f64; 2];

/// Pseudorandom numbers in -1 to 1 (Park and Miller).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 0x7fff_ffff;
        2.0 * self.0 as f64 / 2_147_483_647.0 - 1.0
    }
    pub fn pair(&mut self) -> Pair {
        [self.next(), self.next()]
    }
}

fn times(a: Pair, b: Pair) -> Pair {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

pub fn plus(a: Pair, b: Pair) -> Pair {
    [a[0] + b[0], a[1] + b[1]]
}

pub fn at(moment: f64, degrees: f64) -> Pair {
    let (s, c) = degrees.to_radians().sin_cos();
    [moment * c, moment * s]
}

/// A run: condition, set, and moment and angle on each plane.
pub type Run = (&'static str, &'static str, Vec<(f64, f64)>);

/// A rotor of planes and probes by its coefficients.
pub struct Rotor {
    pub baseline: Vec<Pair>,
    /// By probe, then by plane.
    pub coefficients: Vec<Vec<Pair>>,
    pub random: Random,
    pub noise: f64,
}

impl Rotor {
    pub fn new(planes: usize, probes: usize, noise: f64) -> Self {
        let mut random = Random(20_261_127);
        let baseline = (0..probes).map(|_| random.pair().map(|x| 20.0 * x)).collect();
        let coefficients = (0..probes).map(|_| (0..planes).map(|_| random.pair().map(|x| 0.1 * x)).collect()).collect();
        Self { baseline, coefficients, random, noise }
    }

    pub fn vectors(&mut self, moments: &[Pair]) -> Vec<Pair> {
        let of =
            |(b, row): (&Pair, &Vec<Pair>)| row.iter().zip(moments).fold(*b, |sum, (c, u)| plus(sum, times(*c, *u)));
        let exact: Vec<Pair> = self.baseline.iter().zip(&self.coefficients).map(of).collect();
        let noise = self.noise;
        exact.into_iter().map(|y| plus(y, self.random.pair().map(|x| noise * x))).collect()
    }

    pub fn table(&mut self, runs: &[Run]) -> String {
        let planes = self.coefficients[0].len();
        let mut out = "id,set,speed_rpm".to_owned();
        (1..=planes).for_each(|k| write!(out, ",p{k}_g_mm,p{k}_deg").unwrap());
        (1..=self.baseline.len()).for_each(|p| write!(out, ",s{p}_re_um,s{p}_im_um").unwrap());
        out.push('\n');
        for (id, set, masses) in runs {
            for repeat in 1..=2 {
                write!(out, "{id}_N1_a{repeat},{set},3000").unwrap();
                for (moment, angle) in masses {
                    match *set {
                        "blind" => out += ",,",
                        _ => write!(out, ",{moment},{angle}").unwrap(),
                    }
                }
                let moments: Vec<Pair> = masses.iter().map(|(moment, angle)| at(*moment, *angle)).collect();
                for [re, im] in self.vectors(&moments) {
                    write!(out, ",{re:.9},{im:.9}").unwrap();
                }
                out.push('\n');
            }
        }
        out
    }

    /// Returns the moments with the least sum of squares: real normal equations by Gauss elimination.
    pub fn optimum(&self) -> Vec<Pair> {
        let planes = self.coefficients[0].len();
        let n = 2 * planes;
        // Rows of the real system: the real and the imaginary part of each vector.
        let rows = self.coefficients.iter().zip(&self.baseline).flat_map(|(row, b)| {
            let re: Vec<f64> = row.iter().flat_map(|c| [c[0], -c[1]]).collect();
            let im: Vec<f64> = row.iter().flat_map(|c| [c[1], c[0]]).collect();
            [(re, b[0]), (im, b[1])]
        });
        let mut system = vec![vec![0.0; n + 1]; n];
        for (row, b) in rows {
            for i in 0..n {
                for j in 0..n {
                    system[i][j] += row[i] * row[j];
                }
                system[i][n] -= row[i] * b;
            }
        }
        for i in 0..n {
            let pivot = system[i].clone();
            for (k, row) in system.iter_mut().enumerate().filter(|(k, _)| *k != i) {
                let factor = row[i] / pivot[i];
                row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
                let _ = k;
            }
        }
        let solved: Vec<f64> = (0..n).map(|i| system[i][n] / system[i][i]).collect();
        solved.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
    }
}

const RUNS: [(&str, &str); 9] = [
    ("BASE", "baseline"),
    ("T1", "trial"),
    ("T2", "trial"),
    ("T3", "trial"),
    ("T4", "trial"),
    ("T5", "trial"),
    ("T6", "trial"),
    ("X1", "blind"),
    ("X2", "blind"),
];

/// Masses on four planes of each run.
fn runs() -> Vec<Run> {
    let masses: [[(f64, f64); 4]; 9] = [
        [(0.0, 0.0); 4],
        [(40.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)],
        [(0.0, 0.0), (40.0, 90.0), (0.0, 0.0), (0.0, 0.0)],
        [(0.0, 0.0), (0.0, 0.0), (40.0, 45.0), (0.0, 0.0)],
        [(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (40.0, 200.0)],
        [(40.0, 120.0), (0.0, 0.0), (40.0, 300.0), (0.0, 0.0)],
        [(0.0, 0.0), (40.0, 270.0), (0.0, 0.0), (40.0, 10.0)],
        [(25.0, 70.0), (0.0, 0.0), (10.0, 250.0), (0.0, 0.0)],
        [(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)],
    ];
    RUNS.iter().zip(masses).map(|((id, set), masses)| (*id, *set, masses.to_vec())).collect()
}

pub fn moment(of: &Value) -> Pair {
    at(of["moment_g_mm"].as_f64().unwrap(), of["angle_deg"].as_f64().unwrap())
}

pub fn apart(a: Pair, b: Pair) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn four_planes_and_twelve_probes_are_balanced_as_by_another_program() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(4, 12, 0.02);
    sandbox.put("vectors.csv", rotor.table(&runs()));
    let out: Value =
        sandbox.done(&["balance", "--vectors", "vectors.csv", "-o", "masses.csv", "--format", "json"]).json();
    let optimum = rotor.optimum();
    let largest = optimum.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    for (found, optimum) in out["correction"]["planes"].as_array().unwrap().iter().zip(&optimum) {
        let off = apart(moment(found), *optimum);
        assert!(off < 0.02 * largest, "{found}: {optimum:?}");
        assert!(off < 4.0 * found["deviation_g_mm"].as_f64().unwrap(), "{found}: {optimum:?}");
    }
    // The table of the blind conditions: what was put on, and what was not.
    let table = sandbox.read("masses.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0],
        ["condition", "plane", "moment_g_mm", "moment_low", "moment_high", "angle_deg", "angle_low", "angle_high"]
    );
    assert_eq!(rows.len(), 9, "{table}");
    let known = runs();
    for row in &rows[1..] {
        let (_, _, masses) = known.iter().find(|run| run.0 == row[0]).unwrap();
        let (truth, angle) = masses[row[1].parse::<usize>().unwrap() - 1];
        let [value, low, high, found, from, to]: [f64; 6] =
            row[2..].iter().map(|x| x.parse().unwrap()).collect::<Vec<_>>().try_into().unwrap();
        assert!((low..=high).contains(&truth), "{row:?}: {truth}");
        assert!((value - truth).abs() < 0.5, "{row:?}: {truth}");
        if truth > 0.0 {
            assert!(low > 0.0 && from < found && found < to, "{row:?}");
            assert!((found - angle).abs() < 3.0, "{row:?}: {angle}");
        } else {
            assert_eq!(low, 0.0, "{row:?}");
        }
    }
}

/// One record of four with a knock is named and not used: the correction is that without it.
#[test]
fn a_record_with_a_knock_is_not_used() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(4, 12, 0.02);
    let [first, again] = [rotor.table(&runs()), rotor.table(&runs()).replace("_a", "_b")];
    let table = first + again.split_once('\n').unwrap().1;
    sandbox.put("vectors.csv", &table);
    let json =
        |args: &[&str]| -> Value { sandbox.done(&[&["balance", "--vectors", "vectors.csv"], args].concat()).json() };
    let sound = json(&["--format", "json"]);
    assert!(sound["outliers"].is_null(), "{}", sound["outliers"]);
    let knocked = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[15] = (cells[15].parse::<f64>().unwrap() + 2.0).to_string();
        cells.join(",") + "\n"
    };
    let lines =
        table.lines().map(|line| if line.starts_with("T3_N1_b2") { knocked(line) } else { format!("{line}\n") });
    sandbox.put("vectors.csv", lines.collect::<String>());
    let found = json(&["--format", "json"]);
    let outliers = found["outliers"].as_array().unwrap();
    let of = |one: &Value| (one["condition"].clone(), one["record"].clone(), one["probe"].clone());
    assert_eq!(outliers.iter().map(of).collect::<Vec<_>>(), [("T3".into(), 4.into(), "s3".into())]);
    let planes = |of: &Value| of["correction"]["planes"].as_array().unwrap().iter().map(moment).collect::<Vec<_>>();
    for (found, sound) in planes(&found).into_iter().zip(planes(&sound)) {
        assert!(apart(found, sound) < 0.5, "{found:?}: {sound:?}");
    }
    let text = sandbox.done(&["balance", "--vectors", "vectors.csv"]).out;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("Record 4 of T3 is not used: at s3 and 3000 rpm it is "), "{text}");
}

/// The classical minimum: a baseline and one trial for each plane determine the correction, without a proof and with wide intervals.
#[test]
fn one_trial_for_each_plane() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(4, 12, 0.02);
    let least: Vec<_> =
        runs().into_iter().filter(|run| ["BASE", "T1", "T2", "T3", "T4", "X1"].contains(&run.0)).collect();
    sandbox.put("vectors.csv", rotor.table(&least));
    let args = ["balance", "--vectors", "vectors.csv", "--format"];
    let out: Value = sandbox.done(&[&args[..], &["json"]].concat()).json();
    assert_eq!(out["proof"]["moments"], 0, "{out}");
    let optimum = rotor.optimum();
    let largest = optimum.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    for (found, optimum) in out["correction"]["planes"].as_array().unwrap().iter().zip(&optimum) {
        assert!(apart(moment(found), *optimum) < 0.05 * largest, "{found}: {optimum:?}");
        assert!(found["deviation_g_mm"].as_f64().unwrap() > 0.005 * largest, "{found}");
    }
    let text = sandbox.done(&[&args[..], &["text"]].concat()).out;
    assert!(text.contains("No proof"), "{text}");
}

/// Holes and stock: what is put in has nearly the moment, and the predicted vibration is that of what is put in.
#[test]
fn masses_in_holes() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(4, 12, 0.02);
    sandbox.put("vectors.csv", rotor.table(&runs()));
    let args = ["balance", "--vectors", "vectors.csv", "--holes", "16", "--radius", "30 mm", "--format", "json"];
    let any: Value = sandbox.done(&args).json();
    for plane in any["correction"]["planes"].as_array().unwrap() {
        let holes = plane["holes"].as_array().unwrap();
        let of = |hole: &Value| at(30.0 * hole["mass_g"].as_f64().unwrap(), hole["angle_deg"].as_f64().unwrap());
        let sum = holes.iter().map(of).fold([0.0; 2], plus);
        assert!(apart(sum, moment(plane)) < 1e-6 * sum[0].hypot(sum[1]), "{plane}");
    }
    let stock: Value = sandbox.done(&[&args[..], &["--stock", "1 g,2 g"]].concat()).json();
    for plane in stock["correction"]["planes"].as_array().unwrap() {
        for hole in plane["holes"].as_array().unwrap() {
            assert!([1.0, 2.0].contains(&hole["mass_g"].as_f64().unwrap()), "{hole}");
        }
    }
    let text = sandbox.done(&args[..args.len() - 2]).out;
    assert!(text.contains("CORRECTION") && text.contains(" g in hole "), "{text}");
}

/// Planes of other holes: an entry with a plane in front holds for that plane, one without for the others, and the report draws each.
#[test]
fn holes_of_each_plane() {
    let sandbox = Sandbox::empty();
    sandbox.put("vectors.csv", Rotor::new(4, 12, 0.02).table(&runs()));
    let holes = ["--holes", "16,p3 9 from 15 deg", "--radius", "30 mm", "--radius", "p3 40 mm,p4 25 mm"];
    let args = [&["balance", "--vectors", "vectors.csv"], &holes[..]].concat();
    let further = ["--hole-limit", "p1 4 g", "--taken", "p3 9", "--report", "report.html"];
    let out: Value = sandbox.done(&[&args[..], &further, &["--format", "json"]].concat()).json();
    let planes = out["correction"]["planes"].as_array().unwrap();
    for (plane, (count, first, radius)) in
        planes.iter().zip([(16, 0.0, 30.0), (16, 0.0, 30.0), (9, 15.0, 40.0), (16, 0.0, 25.0)])
    {
        let circle = &plane["circle"];
        assert!(circle["number"] == count && circle["first_deg"].as_f64().unwrap() == first, "{plane}");
        let mut sum = [0.0; 2];
        for mass in plane["holes"].as_array().unwrap() {
            let number = |of: &str| mass[of].as_f64().unwrap();
            let angle = first + 360.0 / f64::from(count) * (number("hole") - 1.0);
            assert!((angle - number("angle_deg")).abs() < 1e-9, "{mass}");
            sum = plus(sum, at(radius * number("mass_g"), angle));
        }
        let exact = moment(plane);
        assert!(apart(sum, exact) < 1e-6 * exact[0].hypot(exact[1]), "{plane}");
    }
    let masses = |plane: usize| planes[plane]["holes"].as_array().unwrap().iter();
    assert!(masses(0).all(|mass| mass["mass_g"].as_f64().unwrap() < 4.0 + 1e-9), "{}", planes[0]);
    assert!(masses(2).all(|mass| mass["hole"] != 9), "{}", planes[2]);
    let sentence = "p3 9 on a radius of 40 mm, hole 1 at 15 deg; p4 16 on a radius of 25 mm";
    assert!(sandbox.done(&args).out.contains(sentence));
    let page = sandbox.read("report.html");
    assert!(
        page.contains("Holes: 9 on a radius of 40 mm, hole 1 at 15 deg; those with a cross take no mass."),
        "{page}"
    );
    // The weights of one plane fit no other.
    let stock = ["--stock", "2 g,1 g,p3 3 g", "--weights", "3", "--format", "json"];
    let out: Value = sandbox.done(&[&args[..], &stock].concat()).json();
    for (k, plane) in out["correction"]["planes"].as_array().unwrap().iter().enumerate() {
        for mass in plane["holes"].as_array().unwrap() {
            assert_eq!(mass["mass_g"].as_f64().unwrap() > 2.5, k == 2, "{plane}");
        }
    }
    for (args, message) in [
        (
            &["--holes", "p1 16", "--radius", "30 mm"][..],
            "--holes: none for plane p2, expected \"16\" for all planes, or \"p2 16\"",
        ),
        (&["--holes", "2", "--radius", "30 mm"], "--holes: \"2\", expected 3 holes or more"),
        (&["--holes", "16,p5 9", "--radius", "30 mm"], "--holes: \"p5 9\", expected 3 holes or more"),
        (&["--holes", "16", "--radius", "30 mm,p2 40"], "--radius: plane p2: \"40\" (has no unit), expected a length"),
        (&["--holes", "16", "--radius", "30 mm,40 mm"], "--radius: two values for all planes, expected one"),
        (&["--holes", "16"], "--radius"),
    ] {
        let output = sandbox.run(&[&["balance", "--vectors", "vectors.csv"], args].concat());
        assert!(output.code == Some(2) && output.err.contains(message), "{message}: {}", output.err);
    }
}

#[test]
fn wrong_tables_have_one_clear_error() {
    let sandbox = Sandbox::empty();
    let good = Rotor::new(4, 3, 0.02).table(&runs());
    let wrong = |text: &str| {
        sandbox.put("vectors.csv", text);
        let output = sandbox.run(&["balance", "--vectors", "vectors.csv"]);
        assert_eq!(output.code, Some(2), "{}{}", output.out, output.err);
        output.err
    };
    for (from, to, message) in [
        ("s2_re_um,s2_im_um", "s2_re_mil,s2_im_mil", "another unit than that of the column before"),
        ("s1_re_um", "s1_re_furlong", "unknown unit"),
        ("p1_deg", "p1_angle", "column p1_deg: missing, expected the angle of the plane's mass"),
        ("speed_rpm", "speed", "column speed_rpm: missing"),
        (
            "BASE_N1_a1,baseline,3000,0",
            "BASE_N1_a1,baseline,3000,5",
            "line 2: p1_g_mm: value out of range: \"5\", expected 0 in a baseline",
        ),
        ("T1_N1_a1,trial,3000,40", "T1_N1_a1,trial,3000,-40", "line 4: p1_g_mm: value out of range: \"-40\""),
        (
            "T1_N1_a1,trial,3000,40",
            "T1_N1_a1,test,3000,40",
            "line 4: set: value out of range: \"test\", expected baseline, trial, trim or blind",
        ),
        ("T1_N1_a1,trial,3000", "T1_N1_a1,trial,0", "line 4: speed_rpm: value out of range: \"0\""),
    ] {
        assert!(good.contains(from), "{from}");
        let err = wrong(&good.replacen(from, to, 1));
        assert!(err.contains(message), "{message}: {err}");
    }
    // Lines that end as on Windows are counted as well.
    let windows = good.replacen("T1_N1_a1,trial,3000", "T1_N1_a1,trial,0", 1).replace('\n', "\r\n");
    assert!(wrong(&windows).contains("line 4: speed_rpm"));
    // Records of one condition with other masses.
    let err = wrong(&good.replacen("T1_N1_a2,trial,3000,40", "T1_N1_a2,trial,3000,41", 1));
    assert!(err.contains("line 5: id: value out of range: \"T1_N1_a2\", expected the set and the masses"), "{err}");
    let header = good.lines().next().unwrap();
    assert!(wrong(header).contains("no record, expected a baseline and trials"));
    let without = |names: &[&str]| -> String {
        let keeps = |line: &&str| names.iter().all(|name| !line.starts_with(name));
        good.lines().filter(keeps).map(|line| format!("{line}\n")).collect()
    };
    let err = wrong(&without(&["T3", "T4", "T5", "T6"]));
    assert!(err.contains("3 conditions with known masses, expected at least 5"), "{err}");
    // Planes 3 and 4 are never loaded by themselves.
    let mut runs = runs();
    for (_, _, masses) in runs.iter_mut().filter(|run| run.1 == "trial") {
        masses[3] = masses[2];
    }
    let err = wrong(&Rotor::new(4, 3, 0.02).table(&runs));
    assert!(err.contains("do not tell the planes apart"), "{err}");
    // Angles counted against the vectors.
    let mut rotor = Rotor::new(4, 3, 0.02);
    let mirrored: Vec<_> = self::runs();
    let table = rotor.table(&mirrored);
    let turned: String = table
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            for angle in [4, 6, 8, 10] {
                if let Ok(x) = cells[angle].parse::<f64>() {
                    cells[angle] = format!("{}", (360.0 - x) % 360.0);
                }
            }
            cells.join(",") + "\n"
        })
        .collect();
    let err = wrong(&turned);
    assert!(err.contains("the vectors turn against the masses"), "{err}");
    // Masses that no probe shows.
    let mut deaf = Rotor::new(4, 3, 0.5);
    deaf.coefficients.iter_mut().flatten().for_each(|c| *c = c.map(|x| 1e-4 * x));
    let err = wrong(&deaf.table(&self::runs()));
    assert!(err.contains("change no probe by more than its scatter"), "{err}");
    let err = wrong(&good.replacen("X1_N1_a1,blind,3000", "X1_N1_a1,blind,6000", 1));
    assert!(err.contains("condition X1: no trial at 6000 rpm"), "{err}");
}

/// Vectors that no masses on the planes explain are said to be so.
#[test]
fn vectors_of_another_cause() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(2, 12, 0.02);
    let two: Vec<Run> = runs().into_iter().map(|(id, set, masses)| (id, set, masses[..2].to_vec())).collect();
    let table = rotor.table(&two);
    let mut other = Rotor { random: Random(5), ..Rotor::new(2, 12, 0.02) };
    other.baseline = (0..12).map(|_| other.random.pair().map(|x| 20.0 * x)).collect();
    let bent = other.table(&two);
    let is_bent = |line: &&str| line.starts_with("X1");
    let lines = table.lines().filter(|line| !is_bent(line)).chain(bent.lines().filter(is_bent));
    sandbox.put("vectors.csv", lines.map(|line| format!("{line}\n")).collect::<String>());
    let text = sandbox.done(&["balance", "--vectors", "vectors.csv"]).out;
    let told: Vec<&str> = text.lines().filter(|line| line.contains("no masses on these planes explain")).collect();
    assert!(told.len() == 1 && told[0].starts_with("X1"), "{text}");
}

/// Times come from a column, from a file, or from times.csv beside the table, and never from two of them.
#[test]
fn times_of_runs() {
    let sandbox = Sandbox::empty();
    let table = Rotor::new(4, 12, 0.02).table(&runs());
    sandbox.put("vectors.csv", &table);
    let args = ["balance", "--vectors", "vectors.csv"];
    assert!(sandbox.done(&args).out.contains("The runs have no times"));
    let rows = RUNS.iter().enumerate().map(|(i, (id, _))| format!("{id},N1,{}\n", 600 * i));
    let times = format!("condition,speed,unix_time_of_one_record\n{}", rows.collect::<String>());
    sandbox.put("other.csv", times.lines().take(5).map(|line| format!("{line}\n")).collect::<String>());
    let output = sandbox.run(&[&args[..], &["--times", "other.csv"]].concat());
    assert_eq!(output.code, Some(2), "{}", output.out);
    assert!(output.err.contains("other.csv: no time of condition T4 at speed N1"), "{}", output.err);
    sandbox.put("times.csv", &times);
    let beside = sandbox.done(&args).out;
    assert!(beside.contains("Times of the runs: times.csv") && beside.contains("a drift is lost within"), "{beside}");
    let timed: String = table
        .lines()
        .enumerate()
        .map(|(i, line)| if i == 0 { format!("{line},time_s\n") } else { format!("{line},{}\n", 300 * i) })
        .collect();
    sandbox.put("vectors.csv", timed);
    assert!(!sandbox.done(&args).out.contains("Times of the runs"));
    let output = sandbox.run(&[&args[..], &["--times", "times.csv"]].concat());
    assert_eq!(output.code, Some(2), "{}", output.out);
    assert!(output.err.contains("times of runs beside the column time_s"), "{}", output.err);
}

/// Measured vectors of a rotor kit with two disks, where they are at hand: the known conditions, each from the others, within 3.5 g mm and
/// 5 degrees on average, and runs without a mass said to be empty.
#[test]
fn measured_vectors_of_a_rotor_kit() {
    let vectors = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/recordings/real/rk4_rotor_kit/vectors.csv");
    if !std::path::Path::new(vectors).is_file() {
        return;
    }
    let sandbox = Sandbox::empty();
    let out: Value = sandbox.done(&["balance", "--vectors", vectors, "-o", "estimates.csv", "--format", "json"]).json();
    let proof = &out["proof"];
    assert!(proof["mean_error_g_mm"].as_f64().unwrap() < 2.5, "{proof}");
    assert!(proof["mean_angle_error_deg"].as_f64().unwrap() < 5.0, "{proof}");
    let share = proof["inside"].as_f64().unwrap() / proof["moments"].as_f64().unwrap();
    assert!((0.9..=1.0).contains(&share), "{proof}");
    assert_eq!(sandbox.read("estimates.csv").lines().count(), 21);
}
