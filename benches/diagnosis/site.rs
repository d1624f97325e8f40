//! What a recording of a site has beside the motion of the machine: gaps of the probes, their drift, gain and direction, run-out of
//! the shaft's surface, hum, steps of the converter, another speed in every recording; and what a sound bearing has beside smooth
//! races and equal balls.

use crate::generate::{COLUMNS, Readings};
use crate::random::Random;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

/// Number of probes: four radial ones, one axial.
const PROBES: usize = COLUMNS.len() - 1;
const RADIAL: usize = 4;
/// Largest gap of a probe, and its change between recordings (rms), um.
const GAP: f64 = 20.0;
const GAP_CHANGE: f64 = 0.4;
/// Drift of a probe in a recording (rms), um.
const DRIFT: f64 = 0.1;
/// Errors of gain (rms), and of direction (rms), rad.
const GAIN_ERROR: f64 = 0.015;
const DIRECTION_ERROR: f64 = 0.012;
/// Harmonics of the shaft in its run-out, and the largest of order 1, um.
const RUN_OUT_HARMONICS: usize = 12;
const RUN_OUT: f64 = 6.0;
/// Steps of the converter, um.
pub const STEP: f64 = 0.05;
/// Frequency of the mains, Hz, and hum in every recording, um.
const MAINS: f64 = 50.0;
const HUM: f64 = 0.03;
/// Speed of the recording at slow roll over that of the machine, and its turns.
const SLOW_ROLL: f64 = 0.06;
const SLOW_ROLL_TURNS: f64 = 16.5;
/// Difference of the speed between recordings (rms), and its largest change within one.
pub const SPEED_ERROR: f64 = 0.002;
const SPEED_CHANGE: f64 = 0.002;
/// Waves of a sound race: orders, and amplitude of order 2, um, falling with the order as that of ground races does (slope of -1).
const WAVES: [u32; 9] = [2, 3, 4, 5, 7, 9, 13, 19, 31];
const WAVE: f64 = 0.25;
/// Difference between balls of a sound bearing (rms), um.
const BALL_DIFFERENCE: f64 = 0.05;

/// Smallest effect of a fault on a probe (rms), um: less is hidden by what a sound machine does.
pub const VISIBLE: f64 = 0.15;

/// What a recording has of its own.
#[derive(Clone, Copy, PartialEq)]
pub enum Disturbance {
    None,
    /// 50 Hz on one probe.
    Hum,
    /// One probe drifts.
    Drift,
    /// New run-out at one probe.
    Scratch,
}

/// The probes of a machine.
pub struct Site {
    gaps: [f64; PROBES],
    gains: [f64; PROBES],
    directions: [f64; 2],
    /// Amplitude and phase of each harmonic of the shaft, at the two planes and on the shaft's end.
    run_out: [Vec<(f64, f64)>; 3],
}

impl Site {
    pub fn random(random: &mut Random) -> Self {
        let mut surface = |largest: f64| {
            let first = largest * random.between(0.2, 1.0);
            (1..=RUN_OUT_HARMONICS)
                .map(|k| (first * random.between(0.2, 1.0) / (k as f64).powf(1.5), random.angle()))
                .collect()
        };
        let run_out = [surface(RUN_OUT), surface(RUN_OUT), surface(RUN_OUT / 5.0)];
        Self {
            gaps: std::array::from_fn(|_| random.between(-GAP, GAP)),
            gains: std::array::from_fn(|_| 1.0 + GAIN_ERROR * random.normal()),
            directions: std::array::from_fn(|_| DIRECTION_ERROR * random.normal()),
            run_out,
        }
    }

    /// The surface of the shaft at a probe, um, when the shaft is at `angle`.
    fn surface(&self, probe: usize, angle: f64, probe_angle: f64) -> f64 {
        let harmonics = &self.run_out[probe / 2];
        let angle = if probe < RADIAL { angle - probe_angle } else { angle };
        harmonics.iter().zip(1..).map(|((a, phase), k)| a * (f64::from(k) * angle + phase).cos()).sum()
    }

    /// The recording at slow roll.
    pub fn slow_roll(&self, mean: [f64; PROBES], (rpm, probe_angle, rate): (f64, f64, f64)) -> Readings {
        let per_sample = SLOW_ROLL * rpm / 60.0 / rate;
        let turn = |i: usize| i as f64 * per_sample;
        let row = |i: usize| {
            let mut row = [0.0; COLUMNS.len()];
            for (probe, reading) in row[..PROBES].iter_mut().enumerate() {
                let surface = self.surface(probe, TAU * turn(i), angle_of(probe, probe_angle));
                *reading = self.gaps[probe] + self.gains[probe] * (mean[probe] + surface);
            }
            row[PROBES] = f64::from(u8::from(i == 0 || turn(i).floor() > turn(i - 1).floor()));
            row
        };
        (0..(SLOW_ROLL_TURNS / per_sample) as usize).map(row).collect()
    }

    /// Readings of the probes of a motion at `rpm`: the motion in um at each probe, with a keyphasor.
    pub fn read(
        &self,
        motion: &Readings,
        (rpm, probe_angle, rate): (f64, f64, f64),
        disturbance: Disturbance,
        random: &mut Random,
    ) -> Readings {
        let duration = motion.len() as f64 / rate;
        let gaps = self.gaps.map(|gap| gap + GAP_CHANGE * random.normal());
        let mut drifts: [f64; PROBES] = std::array::from_fn(|_| DRIFT * random.normal());
        let mut hums: [f64; PROBES] = std::array::from_fn(|_| HUM * random.between(0.0, 1.0));
        let disturbed = random.choice(&[0, 1, 2, 3]);
        let mut scratch = vec![];
        match disturbance {
            Disturbance::None => {}
            Disturbance::Hum => hums[disturbed] = random.between(0.3, 1.0),
            Disturbance::Drift => drifts[disturbed] = random.between(2.0, 5.0) * random.choice(&[-1.0, 1.0]),
            Disturbance::Scratch => {
                let depth = random.between(0.5, 2.0);
                scratch = (1..=RUN_OUT_HARMONICS).map(|k| (depth / k as f64, random.angle())).collect();
            }
        }
        let [swing, phase] = [SPEED_CHANGE * random.between(0.2, 1.0), random.angle()];
        let hum_phase = random.angle();
        let (sin, cos): (Vec<f64>, Vec<f64>) = self.directions.map(f64::sin_cos).into_iter().unzip();
        let mut last = -1.0;
        let mut rows = vec![];
        for i in 0..motion.len() {
            let t = i as f64 / rate;
            // The machine is a little faster and slower: a time that runs so.
            let warped = t + swing * duration / TAU * ((TAU * t / duration + phase).sin() - phase.sin());
            let Some((moved, key_turns)) = at(motion, warped * rate, rpm / 60.0 / rate) else { break };
            let mut row = [0.0; COLUMNS.len()];
            for probe in 0..PROBES {
                let along = if probe < RADIAL {
                    let plane = probe / 2;
                    let other = if probe % 2 == 0 { moved[probe + 1] } else { -moved[probe - 1] };
                    moved[probe] * cos[plane] + other * sin[plane]
                } else {
                    moved[probe]
                };
                let angle = TAU * key_turns;
                let mut surface = self.surface(probe, angle, angle_of(probe, probe_angle));
                if probe == disturbed {
                    surface +=
                        scratch.iter().zip(1..).map(|((a, p), k)| a * (f64::from(k) * angle + p).cos()).sum::<f64>();
                }
                let electric = drifts[probe] * t / duration + hums[probe] * (TAU * MAINS * t + hum_phase).sin();
                row[probe] = gaps[probe] + self.gains[probe] * (along + surface) + electric;
            }
            row[PROBES] = f64::from(u8::from(key_turns.floor() > last));
            last = key_turns.floor();
            rows.push(row);
        }
        if let Some(first) = rows.first_mut() {
            first[PROBES] = 0.0;
        }
        rows
    }
}

/// Angle of a radial probe from the first, rad.
fn angle_of(probe: usize, first: f64) -> f64 {
    first * PI / 180.0 + (probe % 2) as f64 * 0.5 * PI
}

/// Motion and turns of the shaft at a time in samples, by cubic interpolation; `step` turns a sample.
fn at(motion: &Readings, time: f64, step: f64) -> Option<([f64; PROBES], f64)> {
    let i = (time.floor().max(1.0) as usize).min(motion.len().saturating_sub(3));
    let points: &[[f64; COLUMNS.len()]; 4] = motion.get(i - 1..i + 3)?.try_into().ok()?;
    let x = time - i as f64;
    let weights = [
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    ];
    let value = |probe: usize| points.iter().zip(weights).map(|(point, weight)| weight * point[probe]).sum();
    // The last column of a motion is the shaft's turns at its first sample.
    Some((std::array::from_fn(value), motion[0][PROBES] + time * step))
}

/// Keys of a sound bearing that is not smooth: waves of both races, one ball unlike the others as spalls all around it.
pub fn imperfections(elements: usize, random: &mut Random) -> (Vec<String>, Vec<String>) {
    let mut waves = vec![];
    for surface in ["inner", "outer"] {
        for order in WAVES {
            let amplitude = 1e-6 * WAVE * random.between(0.3, 1.0) * 2.0 / f64::from(order);
            let mut entry = String::new();
            _ = write!(
                entry,
                "{{ surface = \"{surface}\", order = {order}, amplitude = {amplitude:e}, phase = {:e} }}",
                random.angle()
            );
            waves.push(entry);
        }
    }
    let ball = |element: usize, random: &mut Random| {
        let depth = 1e-6 * BALL_DIFFERENCE * (random.normal().abs() + 0.01);
        format!(
            "{{ surface = \"ball\", element = {element}, azimuth = 0, half_width = \"180 deg\", depth = {depth:e}, shape = \"rectangular\" }}"
        )
    };
    (waves, (1..=elements).map(|element| ball(element, random)).collect())
}
