//! The recordings in `runner/demo` are those that a site would take of the demonstration's machine. Its scene is what the owner knows. The machine
//! has also what no owner knows: races out of round, unequal balls, cages that slip, another speed; and the probes have gaps, gains, drift,
//! run-out of the shaft and hum.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;
use std::fs;

use crate::support::{DEMO_SCENE, Sandbox, demonstrated, numbers, swap};

/// Speed of the machine, rpm, in place of the nominal one.
const SPEED: f64 = 2965.0;
const RATE: f64 = 12_800.0;
/// Time before the first sample, s.
const SETTLE: f64 = 0.5;
const LAST_KEY_OF_BEARING: &str = "poissons_ratio = 0.3\n";
/// The spall, on the first bearing.
const SPALL: &str = "{ surface = \"outer\", azimuth = \"-90 deg\", half_width = \"0.05 rad\", depth = \"3 um\", shape = \"half-sine\" }";
/// Speed of each cage over that of the shaft, 0.6 % and 1.1 % below pure rolling.
const CAGE_RATIOS: [f64; 2] = [0.3966, 0.3946];
/// Orders of the waves of the races, and the amplitude (um) at order 1, from which it falls with the order.
const WAVE_ORDERS: [u32; 6] = [2, 3, 5, 9, 13, 19];
const WAVE: f64 = 0.2;
/// Radius of each ball below that of the largest one, um.
const BALLS: [f64; 9] = [0.02, 0.04, 0.0, 0.03, 0.05, 0.01, 0.03, 0.01, 0.04];
/// Radians from one phase to the next where none is like another: the golden angle.
const GOLDEN: f64 = 2.399_963;

/// Errors of the readings of a probe.
struct Errors {
    /// um
    gap: f64,
    gain: f64,
    /// Swing of a slow drift, um.
    drift: f64,
    /// 50 Hz, um.
    hum: f64,
    /// Angle at which the probe sees the surface of the shaft, rad, and the surface.
    angle: f64,
    surface: usize,
}

/// Errors of all probes, in their order in the scene.
const ERRORS: [Errors; 5] = [
    Errors { gap: 11.3, gain: 1.02, drift: 0.1, hum: 0.02, angle: 0.0, surface: 0 },
    Errors { gap: -6.4, gain: 0.985, drift: -0.2, hum: 0.15, angle: FRAC_PI_2, surface: 0 },
    Errors { gap: 3.7, gain: 1.01, drift: 2.5, hum: 0.03, angle: 0.0, surface: 1 },
    Errors { gap: -14.2, gain: 0.99, drift: 0.2, hum: 0.02, angle: FRAC_PI_2, surface: 1 },
    Errors { gap: 8.8, gain: 1.0, drift: -0.1, hum: 0.02, angle: 0.0, surface: 2 },
];
/// Period of the drift, s.
const DRIFT_PERIOD: f64 = 25.0;
/// Frequency of the mains, Hz.
const MAINS: f64 = 50.0;
/// Run-out of each surface at order 1, um, falling with the order to the power of 3/2, and its harmonics.
const RUN_OUT: [f64; 3] = [2.4, 1.6, 0.5];
const RUN_OUT_HARMONICS: u32 = 12;
/// Step of the converter, um.
const STEP: f64 = 0.02;

impl Errors {
    /// Returns what the probe reads of a `motion` (um) after `turns` of the shaft at `time` (s).
    fn read(&self, motion: f64, turns: f64, time: f64) -> f64 {
        let harmonic = |order: u32| {
            let phase = f64::from(order) * (TAU * turns - self.angle) + GOLDEN * f64::from(order * order);
            RUN_OUT[self.surface] / f64::from(order).powf(1.5) * phase.cos()
        };
        let run_out: f64 = (1..=RUN_OUT_HARMONICS).map(harmonic).sum();
        let drift = self.drift * (TAU * time / DRIFT_PERIOD).sin();
        let reading = self.gap + self.gain * (motion + run_out) + drift + self.hum * (TAU * MAINS * time).sin();
        (reading / STEP).round() * STEP
    }
}

/// Returns the keys of a bearing that its owner does not know.
fn imperfections(bearing: usize, spall: Option<&str>) -> String {
    let waves = ["inner", "outer"].into_iter().flat_map(|surface| WAVE_ORDERS.map(|order| (surface, order)));
    let wave = |(i, (surface, order)): (usize, (&str, u32))| {
        let phase = (GOLDEN * (i * i + bearing) as f64).rem_euclid(TAU);
        let amplitude = WAVE / f64::from(order);
        format!("{{ surface = \"{surface}\", order = {order}, amplitude = \"{amplitude:.4} um\", phase = {phase:.4} }}")
    };
    let ball = |(i, depth): (usize, &f64)| {
        // The other bearing has them in another order.
        let element = (i * (bearing + 1)) % BALLS.len() + 1;
        format!(
            "{{ surface = \"ball\", element = {element}, azimuth = 0, half_width = \"180 deg\", depth = \"{depth} um\", shape = \"rectangular\" }}"
        )
    };
    let waves: Vec<String> = waves.enumerate().map(wave).collect();
    let smaller = BALLS.iter().enumerate().filter(|(_, depth)| **depth > 0.0).map(ball);
    let defects: Vec<String> = smaller.chain(spall.map(str::to_owned)).collect();
    let (ratio, azimuth) = (CAGE_RATIOS[bearing], 0.4 + bearing as f64);
    format!(
        "cage_ratio = {ratio}\nfirst_element_azimuth = {azimuth}\nwaviness = [{}]\ndefect = [{}]\n",
        waves.join(", "),
        defects.join(", ")
    )
}

/// Returns the scene of the machine.
fn machine(is_spalled: bool) -> String {
    let text = swap(DEMO_SCENE, "3000 rpm", &format!("{SPEED} rpm"));
    let mut parts = text.split(LAST_KEY_OF_BEARING);
    let mut all = parts.next().unwrap().to_owned();
    for (bearing, part) in parts.enumerate() {
        let spall = Some(SPALL).filter(|_| is_spalled && bearing == 0);
        all += LAST_KEY_OF_BEARING;
        all += &imperfections(bearing, spall);
        all += part;
    }
    all + "\n[integration]\nstep = \"20 us\"\n"
}

/// Returns the recording of a second.
fn recorded(is_spalled: bool) -> String {
    let sandbox = Sandbox::empty();
    sandbox.put("machine.toml", machine(is_spalled));
    let settle = format!("{SETTLE} s");
    sandbox.done(&[
        "simulate",
        "machine.toml",
        "--duration",
        "1 s",
        "--settle",
        &settle,
        "--as-recording",
        "-o",
        "r.csv",
    ]);
    let (names, rows) = numbers(&sandbox.read("r.csv"));
    let mut text = format!("time_s,{}\n", names.join(","));
    for (i, row) in rows.iter().enumerate() {
        let time = i as f64 / RATE;
        write!(text, "{time:.7}").unwrap();
        for (errors, motion) in ERRORS.iter().zip(row) {
            write!(text, ",{:.2}", errors.read(*motion, (SETTLE + time) * SPEED / 60.0, time)).unwrap();
        }
        writeln!(text, ",{}", row[ERRORS.len()]).unwrap();
    }
    text
}

/// `BALLRACE_WRITE=1` writes them. Another processor may round to the next step.
#[test]
fn its_recordings_are_those_of_a_site() {
    for (name, is_spalled) in [("healthy.csv", false), ("outer-spall.csv", true)] {
        let simulated = recorded(is_spalled);
        if std::env::var_os("BALLRACE_WRITE").is_some() {
            fs::write(demonstrated(name), &simulated).unwrap();
        }
        let stored = fs::read_to_string(demonstrated(name)).unwrap();
        let ((columns, stored), (own_columns, own)) = (numbers(&stored), numbers(&simulated));
        assert_eq!((columns, stored.len()), (own_columns, own.len()), "{name}");
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > 1.5 * STEP;
        let other = stored.iter().zip(&own).find(|(a, b)| a.iter().zip(*b).any(differ));
        assert!(other.is_none(), "{name}: {other:?}");
    }
}
