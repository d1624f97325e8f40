//! `ballrace balance`: trim runs with masses that stay mounted, weights of a stock, holes that are taken, and planes that act alike.

use crate::balance::{Pair, Rotor, apart, at, moment, plus};
use crate::support::Sandbox;
use serde_json::Value;
use std::fmt::Write;

/// A rotor whose stated masses differ from those that act.
struct Machine {
    sandbox: Sandbox,
    rotor: Rotor,
    table: String,
}

impl Machine {
    fn new(planes: usize, probes: usize) -> Self {
        let mut table = "id,set,speed_rpm".to_owned();
        (1..=planes).for_each(|k| write!(table, ",p{k}_g_mm,p{k}_deg").unwrap());
        (1..=probes).for_each(|p| write!(table, ",s{p}_re_um,s{p}_im_um").unwrap());
        table.push('\n');
        Self { sandbox: Sandbox::empty(), rotor: Rotor::new(planes, probes, 0.02), table }
    }

    /// A machine with a repeated baseline and a trial in each of two planes and in both.
    fn with_trials() -> Self {
        let mut machine = Self::new(2, 4);
        let zero = [0.0, 0.0];
        machine.measure("BASE", "baseline", &[zero, zero], &[zero, zero]);
        for (name, masses) in
            [("T1", [at(40.0, 0.0), zero]), ("T2", [zero, at(40.0, 90.0)]), ("T3", [at(40.0, 120.0), at(40.0, 200.0)])]
        {
            machine.measure(name, "trial", &masses, &masses);
        }
        machine.measure("AGAIN", "baseline", &[zero, zero], &[zero, zero]);
        machine
    }

    fn measure(&mut self, id: &str, set: &str, stated: &[Pair], acting: &[Pair]) {
        for repeat in 1..=2 {
            write!(self.table, "{id}_N1_{repeat},{set},3000").unwrap();
            for [x, y] in stated {
                write!(self.table, ",{},{}", x.hypot(*y), y.atan2(*x).to_degrees()).unwrap();
            }
            for [re, im] in self.rotor.vectors(acting) {
                write!(self.table, ",{re:.6},{im:.6}").unwrap();
            }
            self.table.push('\n');
        }
    }

    fn balance(&self, args: &[&str]) -> Value {
        self.sandbox.put("vectors.csv", &self.table);
        self.sandbox.done(&[&["balance", "--vectors", "vectors.csv", "--format", "json"], args].concat()).json()
    }

    fn text(&self, args: &[&str]) -> String {
        self.sandbox.put("vectors.csv", &self.table);
        self.sandbox.done(&[&["balance", "--vectors", "vectors.csv"], args].concat()).out
    }
}

fn moments(out: &Value) -> Vec<Pair> {
    out["correction"]["planes"].as_array().unwrap().iter().map(moment).collect()
}

fn deviations(out: &Value) -> Vec<f64> {
    let of = |plane: &Value| plane["deviation_g_mm"].as_f64().unwrap();
    out["correction"]["planes"].as_array().unwrap().iter().map(of).collect()
}

fn size(a: Pair) -> f64 {
    a[0].hypot(a[1])
}

fn sums(a: &[Pair], b: &[Pair]) -> Vec<Pair> {
    a.iter().zip(b).map(|(a, b)| plus(*a, *b)).collect()
}

/// The masses of a first correction are mounted with errors of 2 %: a trim run shows them, the next masses remove what they left, the
/// intervals shrink, and after the second trim run nothing is left to add.
#[test]
fn a_trim_run_gives_the_next_masses() {
    let mut machine = Machine::with_trials();
    let optimum = machine.rotor.optimum();
    let first = machine.balance(&[]);
    let stated = moments(&first);
    let error = [at(0.02 * size(stated[0]), 40.0), at(0.015 * size(stated[1]), 110.0)];
    let acting = sums(&stated, &error);
    machine.measure("C1", "trim", &stated, &acting);
    let second = machine.balance(&[]);
    let trim = &second["trim"];
    assert!(trim["condition"] == "C1" && trim["misfit"].as_f64().unwrap() < 1.0, "{trim}");
    for one in trim["vectors"].as_array().unwrap() {
        let [measured, expected] =
            ["measured", "expected"].map(|of| at(one[of][0].as_f64().unwrap(), one[of][1].as_f64().unwrap()));
        // Twenty to one and more.
        assert!(apart(measured, expected) < 3.0 * one["expected"][2].as_f64().unwrap(), "{one}");
    }
    let (next, widths) = (moments(&second), deviations(&second));
    let (mut left, mut all) = (0.0_f64, 0.0_f64);
    for k in 0..2 {
        let wanted = [optimum[k][0] - acting[k][0], optimum[k][1] - acting[k][1]];
        (left, all) = (left.hypot(apart(next[k], wanted)), all.hypot(size(wanted)));
        assert!(apart(next[k], wanted) < 2.5 * widths[k], "{k}: {:?} {wanted:?} {}", next[k], widths[k]);
        assert!(widths[k] < deviations(&first)[k], "{k}: {widths:?} {:?}", deviations(&first));
    }
    assert!(all > 2.0 && left < 0.4 * all, "{left} {all}");
    // The mounted masses may be taken off instead: the correction is then the whole one.
    for (whole, optimum) in moments(&machine.balance(&["--replace"])).iter().zip(&optimum) {
        assert!(apart(*whole, *optimum) < 0.02 * size(*optimum), "{whole:?} {optimum:?}");
    }
    let text = machine.text(&[]);
    assert!(
        text.contains("TRIM RUN C1, mounted: p1 ") && text.contains("CORRECTION beside the masses of C1"),
        "{text}"
    );
    machine.measure("C2", "trim", &sums(&stated, &next), &sums(&acting, &next));
    let text = machine.text(&["--report", "trim.html"]);
    assert!(
        text.contains("TRIM RUN C2") && text.contains("do not show that further masses lower the vibration"),
        "{text}"
    );
    let page = machine.sandbox.read("trim.html");
    assert!(page.contains("Trim run C2") && page.contains("Mounted: p1 ") && page.contains("Plane p1"), "{page}");
}

/// Other masses than the stated ones are named.
#[test]
fn masses_that_are_not_those_stated() {
    let zero = [0.0, 0.0];
    let stated = [at(90.0, 20.0), at(50.0, 260.0)];
    let turned = stated.map(|[x, y]| [-x, -y]);
    let left = [plus(stated[0], at(40.0, 0.0)), stated[1]];
    for (acting, message) in [
        (
            [zero, zero],
            "C1: the vectors agree with the other runs only with no mass mounted, expected the masses that are mounted",
        ),
        (turned, "with the masses half a turn from the stated angles"),
        ([stated[0], zero], "with no mass in plane p2"),
        ([stated[1], stated[0]], "with the masses of planes p1 and p2 exchanged"),
        ([at(90.0, 340.0), at(50.0, 100.0)], "with the angles of the masses counted the other way"),
        (left, "with the masses of T1 mounted besides"),
    ] {
        let mut machine = Machine::with_trials();
        machine.measure("C1", "trim", &stated, &acting);
        machine.sandbox.put("vectors.csv", &machine.table);
        let output = machine.sandbox.run(&["balance", "--vectors", "vectors.csv"]);
        assert!(output.code == Some(2) && output.err.contains(message), "{message}: {}{}", output.out, output.err);
    }
    // A cause that is none of these.
    let mut machine = Machine::with_trials();
    machine.measure("C1", "trim", &stated, &[at(60.0, 80.0), at(70.0, 10.0)]);
    assert!(machine.text(&[]).contains("other masses or angles than stated, or a machine that has changed"));
    let output = Machine::with_trials();
    output.sandbox.put("vectors.csv", &output.table);
    let output = output.sandbox.run(&["balance", "--vectors", "vectors.csv", "--replace"]);
    assert!(
        output.code == Some(2)
            && output.err.contains("vectors.csv: no trim run, expected one whose masses are taken off"),
        "{output:?}"
    );
}

/// One run more than coefficients tells the scatter about: it neither vanishes nor grows without end.
#[test]
fn one_run_to_spare() {
    let mut machine = Machine::new(2, 4);
    let zero = [0.0, 0.0];
    for (name, set, masses) in [
        ("BASE", "baseline", [zero, zero]),
        ("T1", "trial", [at(40.0, 0.0), zero]),
        ("T2", "trial", [zero, at(40.0, 90.0)]),
        ("T3", "trial", [at(120.0, 120.0), at(110.0, 200.0)]),
    ] {
        machine.measure(name, set, &masses, &masses);
    }
    for one in machine.balance(&[])["influence"].as_array().unwrap() {
        // The noise has a standard deviation of 0.016 um.
        assert!((0.001..0.2).contains(&one["drift"].as_f64().unwrap()), "{one}");
    }
}

/// Weights of a stock of which there are few, in holes of which some are taken: no hole and no weight is used twice, and the vibration that
/// the output states is that of the weights.
#[test]
fn weights_of_a_stock() {
    let machine = Machine::with_trials();
    let holes = ["--holes", "16", "--radius", "30 mm"];
    let stock = ["--stock", "1 x 1 g,2 x 2 g,1 x 4 g,0.5 g", "--weights", "3", "--taken", "p1 9,p2 3"];
    let out = machine.balance(&[&holes[..], &stock].concat());
    let mut used = std::collections::BTreeMap::<String, usize>::new();
    for plane in out["correction"]["planes"].as_array().unwrap() {
        let masses = plane["holes"].as_array().unwrap();
        let mut sum = [0.0, 0.0];
        for mass in masses {
            let grams = mass["mass_g"].as_f64().unwrap();
            sum = plus(sum, at(30.0 * grams, mass["angle_deg"].as_f64().unwrap()));
            *used.entry(format!("{grams:.1}")).or_default() += 1;
            let taken = if plane["plane"] == "p1" { 9 } else { 3 };
            assert_ne!(mass["hole"], taken, "{plane}");
        }
        assert!(masses.len() <= 3, "{plane}");
        let left = apart(sum, moment(plane));
        assert!((left - plane["left_g_mm"].as_f64().unwrap()).abs() < 1e-6, "{plane}: {left}");
    }
    for (mass, most) in [("1.0", 1), ("2.0", 2), ("4.0", 1)] {
        assert!(used.get(mass).is_none_or(|count| *count <= most), "{used:?}");
    }
    let choice = &out["correction"]["stock"];
    assert_eq!(choice["added"], choice["bound"], "{choice}");
    // More weights and kinds add less.
    let few = machine.balance(&[&holes[..], &["--stock", "4 g", "--weights", "1"]].concat());
    let more = machine.balance(&[&holes[..], &["--stock", "1 g,2 g,4 g,0.5 g", "--weights", "3"]].concat());
    let added = |out: &Value| out["correction"]["stock"]["added"].as_f64().unwrap();
    assert!(
        added(&more) <= added(&out) && added(&out) < added(&few),
        "{} {} {}",
        added(&more),
        added(&out),
        added(&few)
    );
    let text = machine.text(&[&holes[..], &stock].concat());
    assert!(text.contains("The weights of the stock add ") && text.contains("no other choice adds less"), "{text}");
    for (args, message) in [
        (&["--stock", "0 x 1 g"][..], "expected a number of weights above 0"),
        (&["--stock", "1 g", "--weights", "5"], "5 is not in 1..=4"),
        (&["--taken", "p3 1"], "--taken: unknown hole: \"p3 1\", expected a plane (p1, p2) and a hole from 1 to 16"),
        (&["--taken", "p1 17"], "--taken: unknown hole: \"p1 17\""),
    ] {
        let output = machine.sandbox.run(&[&["balance", "--vectors", "vectors.csv"], &holes[..], args].concat());
        assert!(output.code == Some(2) && output.err.contains(message), "{message}: {}", output.err);
    }
}

/// Two planes side by side: the combination that the probes do not show stays 0, so that the moments are the smallest that balance the rotor,
/// and the output states how far the planes lie apart.
#[test]
fn planes_that_act_alike_get_the_smallest_moments() {
    let mut machine = Machine::with_trials();
    machine = Machine { rotor: Rotor::new(2, 4, 0.02), ..machine };
    for row in &mut machine.rotor.coefficients {
        row[1] = [1.0005 * row[0][0], 1.0005 * row[0][1]];
    }
    let header = machine.table.lines().next().unwrap().to_owned() + "\n";
    machine.table = header;
    let zero = [0.0, 0.0];
    for (name, set, masses) in [
        ("BASE", "baseline", [zero, zero]),
        ("T1", "trial", [at(40.0, 0.0), zero]),
        ("T2", "trial", [zero, at(40.0, 90.0)]),
        ("T3", "trial", [at(40.0, 120.0), at(40.0, 200.0)]),
        ("AGAIN", "baseline", [zero, zero]),
    ] {
        machine.measure(name, set, &masses, &masses);
    }
    let out = machine.balance(&[]);
    assert_eq!(out["correction"]["not_observed"], 1, "{out}");
    let found = moments(&out);
    // The same moment in both planes.
    assert!(apart(found[0], found[1]) < 0.05 * size(found[0]), "{found:?}");
    let text = machine.text(&[]);
    assert!(
        text.contains("act alike on these probes (condition number") && text.contains("1 of 2 combinations"),
        "{text}"
    );
}
