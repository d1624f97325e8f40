//! `ballrace balance`: runs of a table that are not what they are stated to be, each named by its probable error, and planes that no probe shows.

use crate::balance::{Pair, Rotor, Run, at, plus};
use crate::support::Sandbox;
use std::fmt::Write;

const ZERO: Pair = [0.0, 0.0];

/// A mistake: condition, change of its masses or vectors, words of the error.
type Mistake<T> = (&'static str, fn(&mut T), &'static str);

/// Seven known conditions of two planes: condition, set, stated masses.
fn runs() -> [(&'static str, &'static str, [Pair; 2]); 7] {
    [
        ("BASE", "baseline", [ZERO, ZERO]),
        ("T1", "trial", [at(40.0, 20.0), ZERO]),
        ("T2", "trial", [ZERO, at(40.0, 90.0)]),
        ("T3", "trial", [at(40.0, 120.0), at(40.0, 200.0)]),
        ("T4", "trial", [at(40.0, 250.0), ZERO]),
        ("T5", "trial", [ZERO, at(40.0, 310.0)]),
        ("AGAIN", "baseline", [ZERO, ZERO]),
    ]
}

/// Writes the table of a rotor of four probes; `acting` changes the masses of a condition, `read` its vectors.
fn table(acting: impl Fn(&str, &mut [Pair; 2]), read: impl Fn(&str, &mut Vec<Pair>)) -> String {
    let mut rotor = Rotor::new(2, 4, 0.02);
    let mut out = "id,set,speed_rpm".to_owned();
    (1..=2).for_each(|k| write!(out, ",p{k}_g_mm,p{k}_deg").unwrap());
    (1..=4).for_each(|p| write!(out, ",s{p}_re_um,s{p}_im_um").unwrap());
    for (id, set, stated) in runs() {
        for repeat in 1..=2 {
            let mut masses = stated;
            acting(id, &mut masses);
            let mut vectors = rotor.vectors(&masses);
            read(id, &mut vectors);
            write!(out, "\n{id}_N1_{repeat},{set},3000").unwrap();
            stated.iter().for_each(|[x, y]| write!(out, ",{},{}", x.hypot(*y), y.atan2(*x).to_degrees()).unwrap());
            vectors.iter().for_each(|[re, im]| write!(out, ",{re:.6},{im:.6}").unwrap());
        }
    }
    out + "\n"
}

/// Masses that are not those stated.
#[test]
fn a_run_with_other_masses_is_named() {
    let sandbox = Sandbox::empty();
    let cases: [Mistake<[Pair; 2]>; 6] = [
        ("T1", |u| *u = [ZERO, ZERO], "T1: the vectors agree with the other runs only with no mass mounted"),
        (
            "T4",
            |u| *u = u.map(|[x, y]| [-x, -y]),
            "T4: the vectors agree with the other runs only with the masses half a turn",
        ),
        (
            "T2",
            |u| u.swap(0, 1),
            "only with the masses of planes p1 and p2 exchanged, expected the masses that are mounted",
        ),
        ("T3", |u| *u = u.map(|[x, y]| [x, -y]), "only with the angles of the masses counted the other way"),
        (
            "T5",
            |u| *u = u.map(|u| u.map(|x| 10.0 * x)),
            "T5: the vectors agree with the other runs only with the masses in g cm",
        ),
        (
            "AGAIN",
            |u| u[1] = plus(u[1], at(40.0, 90.0)),
            "AGAIN: the vectors agree with the other runs only with the masses of T2 mounted besides",
        ),
    ];
    for (id, change, message) in cases {
        let acting = |condition: &str, masses: &mut [Pair; 2]| {
            if condition == id {
                change(masses);
            }
        };
        sandbox.put("vectors.csv", table(acting, |_, _| {}));
        let output = sandbox.run(&["balance", "--vectors", "vectors.csv"]);
        assert!(output.code == Some(2) && output.err.contains(message), "{message}: {}{}", output.out, output.err);
    }
}

/// Vectors of other probes, in another unit or direction.
#[test]
fn a_run_with_other_vectors_is_named() {
    let sandbox = Sandbox::empty();
    let cases: [Mistake<Vec<Pair>>; 4] = [
        ("T1", |y| y.swap(1, 3), "T1: the vectors agree with the other runs only with probes s2 and s4 exchanged"),
        (
            "T2",
            |y| y.iter_mut().for_each(|y| *y = y.map(|x| x / 25.4)),
            "T2: the vectors agree with the other runs only with vectors in mil in place of um, expected one unit",
        ),
        (
            "BASE",
            |y| y.iter_mut().for_each(|y| *y = y.map(|x| 2.0 * x)),
            "BASE: the vectors agree with the other runs only with vectors in peak-to-peak in place of peak",
        ),
        (
            "T4",
            |y| y.iter_mut().for_each(|[_, im]| *im = -*im),
            "T4: the vectors agree with the other runs only with the angles of the vectors counted the other way",
        ),
    ];
    for (id, change, message) in cases {
        let read = |condition: &str, vectors: &mut Vec<Pair>| {
            if condition == id {
                change(vectors);
            }
        };
        sandbox.put("vectors.csv", table(|_, _| {}, read));
        let output = sandbox.run(&["balance", "--vectors", "vectors.csv"]);
        assert!(output.code == Some(2) && output.err.contains(message), "{message}: {}{}", output.out, output.err);
    }
}

/// Vectors of another cause are no error: the output and the report name the run. All as stated, nothing is said.
#[test]
fn a_run_of_another_cause_is_told() {
    let sandbox = Sandbox::empty();
    let read = |condition: &str, vectors: &mut Vec<Pair>| {
        if condition == "T3" {
            vectors.iter_mut().zip([3.0, -2.0, 5.0, 1.0]).for_each(|(y, off)| *y = plus(*y, [off, 0.5 * off]));
        }
    };
    sandbox.put("vectors.csv", table(|_, _| {}, read));
    let args = ["balance", "--vectors", "vectors.csv", "--report", "report.html"];
    let sentence = "The vectors of T3 are ";
    let text = sandbox.done(&args).out;
    assert!(text.contains(sentence) && text.contains("check its masses, angles and probes, or repeat it"), "{text}");
    assert!(sandbox.read("report.html").contains(sentence));
    sandbox.put("vectors.csv", table(|_, _| {}, |_, _| {}));
    let text = sandbox.done(&args).out;
    assert!(!text.contains("repeat it") && !text.contains("do not show the masses"), "{text}");
}

/// A plane whose trial masses no probe shows, where nothing else tells: it is named, and it stays empty.
#[test]
fn a_plane_that_no_probe_shows_is_named() {
    let sandbox = Sandbox::empty();
    let full = table(
        |id, masses| {
            if id == "T2" {
                *masses = [ZERO, ZERO]
            }
        },
        |_, _| {},
    );
    let kept = |line: &&str| ["id", "BASE", "T1", "T2"].iter().any(|name| line.starts_with(name));
    sandbox.put("vectors.csv", full.lines().filter(kept).fold(String::new(), |all, line| all + line + "\n"));
    let text = sandbox.done(&["balance", "--vectors", "vectors.csv"]).out;
    let sentence =
        "The probes do not show the masses of p2 above drift and errors: make a trial with a larger mass there";
    assert!(text.contains(sentence), "{text}");
}

/// More planes than vectors: as many combinations as vectors balance the rotor.
#[test]
fn more_planes_than_vectors() {
    let sandbox = Sandbox::empty();
    let mut rotor = Rotor::new(3, 2, 0.01);
    let mut runs: Vec<Run> = vec![("BASE", "baseline", vec![(0.0, 0.0); 3])];
    for (plane, name) in ["T1", "T2", "T3"].into_iter().enumerate() {
        let mass = |k: usize| if k == plane { (40.0, 70.0 * plane as f64) } else { (0.0, 0.0) };
        runs.push((name, "trial", (0..3).map(mass).collect()));
    }
    runs.push(("AGAIN", "baseline", vec![(0.0, 0.0); 3]));
    sandbox.put("vectors.csv", rotor.table(&runs));
    let args = ["balance", "--vectors", "vectors.csv", "--format", "json"];
    for further in [&[][..], &["--holes", "16", "--radius", "30 mm", "--stock", "1 g,2 g"]] {
        let out: serde_json::Value = sandbox.done(&[&args[..], further].concat()).json();
        assert_eq!(out["correction"]["not_observed"], 1, "{out}");
        for one in out["correction"]["predicted"].as_array().unwrap() {
            let [before, after] = ["before", "after"].map(|of| one[of].as_f64().unwrap());
            assert!(after < if further.is_empty() { 1e-9 } else { 0.2 } * before, "{one}");
        }
    }
}
