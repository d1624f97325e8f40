//! Effect of flaws of a recording on force and verdict: noise, coarse steps, clipping, lost rows, jitter, a wrong rate.

use crate::support::{DEMO_SCENE, DIAGNOSED, HEALTHY_RECORDING, Sandbox, numbers};
use serde_json::Value;

/// Numbers that look random and are the same everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// A normal number with unit variance, by the sum of twelve.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// Rows of the demonstration in the usual run, long enough for a diagnosis; `tests/run --all` takes all.
const ROWS: usize = DIAGNOSED;

/// The demonstration's rows: time, five probes in um, keyphasor.
fn rows() -> (String, Vec<[f64; 7]>) {
    let (header, rows) = numbers(HEALTHY_RECORDING);
    let count = if ballrace_tests::runs_all() { rows.len() } else { ROWS };
    let rows = rows[..count].iter().map(|row| <[f64; 7]>::try_from(row.as_slice()).unwrap()).collect();
    (header.join(","), rows)
}

fn written(header: &str, rows: &[[f64; 7]]) -> String {
    let line = |row: &[f64; 7]| {
        let [t, a, b, c, d, e, key] = row;
        format!("{t:.7},{a:.4},{b:.4},{c:.4},{d:.4},{e:.4},{key}\n")
    };
    header.to_owned() + "\n" + &rows.iter().map(line).collect::<String>()
}

/// Each probe's reading changed.
fn probes(rows: &mut [[f64; 7]], mut change: impl FnMut(usize, f64) -> f64) {
    for row in rows {
        for (k, x) in row[1..6].iter_mut().enumerate() {
            *x = change(k, *x);
        }
    }
}

struct Verdict {
    force: Vec<[f64; 2]>,
    diagnoses: Vec<String>,
    flaws: usize,
}

/// Replays; the radial force on DE at every sample, and what is found.
fn verdict(scene: &str, recording: &str) -> Option<Verdict> {
    let sandbox = Sandbox::with(scene, recording);
    let answer = sandbox.run(&["replay", "scene.toml", "--forces", "f.csv", "--format", "json"]);
    if answer.code != Some(0) {
        assert!(answer.code == Some(1) && answer.err.lines().count() == 1, "{answer:?}");
        return None;
    }
    let outcome: Value = answer.json();
    let (header, rows) = numbers(&sandbox.read("f.csv"));
    let [x, y] = ["DE_FX_N", "DE_FY_N"].map(|name| header.iter().position(|h| h == name).unwrap());
    let diagnoses = outcome["findings"].as_array().unwrap().iter().map(|f| f["kind"].as_str().unwrap().to_owned());
    let flaws = outcome["flaws"].as_array().map_or(0, Vec::len);
    Some(Verdict { force: rows.iter().map(|row| [row[x], row[y]]).collect(), diagnoses: diagnoses.collect(), flaws })
}

/// Root mean square of the difference of forces over the mean force.
fn off(found: &[[f64; 2]], right: &[[f64; 2]]) -> f64 {
    let n = found.len().min(right.len()) as f64;
    let square: f64 = found.iter().zip(right).map(|(f, r)| (f[0] - r[0]).powi(2) + (f[1] - r[1]).powi(2)).sum();
    let size: f64 = right.iter().map(|r| r[0].hypot(r[1])).sum::<f64>() / right.len() as f64;
    (square / n).sqrt() / size
}

#[test]
fn flaws_of_a_recording_and_their_effects() {
    let (header, clean) = rows();
    let right = verdict(DEMO_SCENE, &written(&header, &clean)).unwrap();
    assert!(right.diagnoses.is_empty() && right.flaws == 0);
    println!("| recording | force off, rms | diagnoses | flaws told |");
    let mut table = Vec::new();
    let mut judge = |name: &str, scene: &str, rows: &[[f64; 7]], same_samples: bool| {
        let found = verdict(scene, &written(&header, rows));
        let row = match &found {
            None => (f64::NAN, "refused".to_owned(), 0),
            Some(v) => {
                let error = if same_samples { off(&v.force, &right.force) } else { f64::NAN };
                (error, if v.diagnoses.is_empty() { "none".to_owned() } else { v.diagnoses.join(", ") }, v.flaws)
            }
        };
        println!("| {name} | {:.2} % | {} | {} |", row.0 * 100.0, row.1, row.2);
        table.push((name.to_owned(), row.0, row.1, row.2));
    };
    let levels = [0.03, 0.1, 0.3, 1.0, 3.0].into_iter();
    for noise in levels.chain(ballrace_tests::runs_all().then_some(10.0)) {
        let mut rows = clean.clone();
        let mut random = Random(0x1357_9bdf_2468_ace0);
        probes(&mut rows, |_, x| x + noise * random.normal());
        judge(&format!("noise of {noise} um added"), DEMO_SCENE, &rows, true);
    }
    let spread: Vec<f64> = (1..6).map(|k| clean.iter().fold(0.0_f64, |most, row| most.max(row[k].abs()))).collect();
    let mut rows = clean.clone();
    probes(&mut rows, |k, x| (x / (2.0 * spread[k] / 256.0)).round() * (2.0 * spread[k] / 256.0));
    judge("8 bits over each probe's range", DEMO_SCENE, &rows, true);
    let mut rows = clean.clone();
    probes(&mut rows, |k, x| if k == 0 { x.clamp(-0.2 * spread[0], 0.2 * spread[0]) } else { x });
    judge("one probe clipped at a fifth of its range", DEMO_SCENE, &rows, true);
    let mut random = Random(99);
    let lost: Vec<[f64; 7]> = clean.iter().filter(|_| random.unit() > 0.02).copied().collect();
    judge("2 % of the rows lost", &with_time(), &lost, false);
    let mut rows = clean.clone();
    for row in &mut rows {
        row[0] += 10e-6 * random.normal();
    }
    judge("time stamps off by 10 us", &with_time(), &rows, true);
    judge("rate stated 1 % too high", &DEMO_SCENE.replace("12.8 kHz", "12.928 kHz"), &clean, true);
    let at = |name: &str| table.iter().find(|row| row.0.contains(name)).unwrap_or_else(|| panic!("{name}"));
    // The error of force is proportional to the noise, as the band of the report states, and noise alone is no fault.
    for (small, large) in [("0.1 um", "0.3 um"), ("0.3 um", "1 um"), ("1 um", "3 um")] {
        let ratio = at(&format!("noise of {large}")).1 / at(&format!("noise of {small}")).1;
        assert!((2.0..5.0).contains(&ratio), "{small} to {large}: {ratio}");
    }
    for row in table.iter().filter(|row| row.0.contains("noise") && !row.0.contains("10 um")) {
        assert_eq!(row.2, "none", "{}: noise is called a fault", row.0);
    }
    assert!(at("8 bits").1 < 0.3 && at("8 bits").2 == "none");
    assert!(at("clipped").3 > 0, "a clipped probe is told");
    assert!(at("lost").3 > 0 || at("lost").2 == "refused", "lost rows are told");
    assert!(at("rate stated").1 < 0.05, "forces do not depend on the rate");
}

/// The demonstration with its time column believed instead of a rate.
fn with_time() -> String {
    DEMO_SCENE.replace("rate = \"12.8 kHz\"", "time = \"time_s\"")
}
