//! One point of a sweep: the steady-state motion of the scene's rotor and its measures.

use crate::effect_significance::{self, EffectSignificance};
use ballrace::Phase;
use ballrace_plant::error::{Error, MotionOverflow, Result, SweepError};
use ballrace_plant::motion::{self, MAX_SAMPLES, ResponseSample, Span};
use ballrace_plant::spectrum::{amplitudes, line};
use ballrace_plant::{Plant, Twin};
use ballrace_scene::Scene;
use serde::{Deserialize, Deserializer, Serialize};
use std::f64::consts::TAU;

/// Number of samples in one section period.
const A_PERIOD: usize = 128;
/// Longest period that is detected, in section periods.
const LONGEST_PERIOD: usize = 12;
/// Largest distance after one period of a motion that repeats, over its size.
const SAME: f64 = 2e-3;
/// Contraction of neighbouring motions after which a transient has died out.
const DIED_OUT: f64 = 1e-5;
/// Longest transient that is awaited, in multiples of its estimate by the damping.
const LONGEST_TRANSIENT: u64 = 20;
/// Number of values of the spectrum for the waterfall, and the section frequencies that they span.
const SPECTRUM: (usize, f64) = (160, 4.0);
/// Distance of the neighbouring motion for the Lyapunov exponent, over the motion's size.
const NEIGHBOUR: f64 = 1e-7;

/// Options of every point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measure {
    /// Transient at the start, s; where absent, that of the damping, and longer until neighbouring motions have contracted.
    pub settle: Option<f64>,
    /// Number of section periods.
    pub periods: usize,
    /// True where the section is taken once a revolution of the shaft instead of once a ball pass.
    pub by_shaft: bool,
    /// True where the largest Lyapunov exponent is computed.
    pub lyapunov: bool,
}

/// Measures of the motion at one point; NaN where it overflows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Shaft speed, rpm.
    pub speed_rpm: f64,
    /// Error of a motion that overflows.
    #[serde(default)]
    pub overflow: Option<String>,
    /// Peak-to-peak displacement along X, Y, Z, um.
    #[serde(deserialize_with = "three")]
    pub peak_to_peak: [f64; 3],
    /// Mean displacement along X, Y, Z, um.
    #[serde(deserialize_with = "three")]
    pub mean: [f64; 3],
    /// Amplitudes along X and Y, um: at the shaft's speed, at the ball pass, at a half and at a third of the section's
    /// frequency.
    #[serde(deserialize_with = "four_pairs")]
    pub lines: [[f64; 2]; 4],
    /// Period of the motion in section periods; none where it does not repeat within twelve.
    pub period: Option<usize>,
    /// Largest Lyapunov exponent, 1/s.
    pub lyapunov: Option<f64>,
    /// X and Y at each section, um.
    pub section: Vec<[f64; 2]>,
    /// Amplitude along X over multiples of the section's frequency, um: the highest of each strip.
    pub spectrum: Vec<f64>,
    /// Predicted change of force by each effect; empty in journals of older versions.
    #[serde(default)]
    pub effects: Vec<EffectChange>,
}

/// Reads three numbers; JSON has null for NaN.
fn three<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(from)?.map(|x| x.unwrap_or(f64::NAN)))
}

/// Reads four pairs of numbers as [`three`].
fn four_pairs<'de, D: Deserializer<'de>>(from: D) -> Result<[[f64; 2]; 4], D::Error> {
    Ok(<[[Option<f64>; 2]; 4]>::deserialize(from)?.map(|pair| pair.map(|x| x.unwrap_or(f64::NAN))))
}

/// Predicted change of a bearing's force when an effect is omitted (see [`crate::effect_significance::EffectSignificance`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectChange {
    /// The scene's name of the bearing.
    pub bearing: String,
    /// Name of the effect, as in `EffectSignificance::effect`.
    pub effect: String,
    /// Change of the force divided by the force.
    pub change: f64,
}

impl From<EffectSignificance> for EffectChange {
    fn from(effect: EffectSignificance) -> Self {
        Self { bearing: effect.bearing, effect: effect.effect.to_owned(), change: effect.change }
    }
}

/// State at the end of a run, from which the next may start.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    coordinates: Vec<f64>,
    rates: Vec<f64>,
}

/// Returns the frequency of the section, Hz, and the ball-pass frequency of the first bearing that has one.
fn frequencies(scene: &Scene, plant: &Plant, by_shaft: bool) -> (f64, f64) {
    let shaft = scene.shaft.speed.nominal().abs() / TAU;
    let pass = plant.bearings.iter().map(|s| s.kinematics.orders.outer_race * shaft).find(|f| *f > 0.0);
    let section = if by_shaft { shaft } else { pass.unwrap_or(shaft) };
    (section, pass.unwrap_or(0.0))
}

/// Runs one point, from rest or from `start`; a motion that overflows has no measures and no end.
///
/// # Errors
/// Returns an error if the shaft is at standstill or the kernel rejects a parameter.
pub fn measure(scene: &Scene, options: &Measure, start: Option<&State>) -> Result<(Figures, Option<State>)> {
    let plant = Plant::try_new(scene)?;
    let (section, pass) = frequencies(scene, &plant, options.by_shaft);
    if section <= 0.0 {
        return Err(SweepError::Standstill { file: scene.path.clone() }.into());
    }
    let rate = section * A_PERIOD as f64;
    let settle = options.settle.unwrap_or_else(|| plant.settling_time());
    // Whole periods, so that the section is taken at the same place at every point.
    let settle = (settle * section).ceil() * A_PERIOD as f64;
    if settle > MAX_SAMPLES {
        return Err(SweepError::Samples { found: settle, rate, most: MAX_SAMPLES }.into());
    }
    let settle = settle as u64;
    let mut settling = options.settle.is_none().then(|| Settling::new(settle));
    // The contraction is measured on samples that are visited.
    let (hidden, visible) = if settling.is_some() { (0, settle * LONGEST_TRANSIENT) } else { (settle, 0) };
    let measured = options.periods * A_PERIOD;
    let span = Span { rate, settle: hidden, samples: visible + measured as u64 + 1 };
    let mut path = Path::default();
    let mut neighbour = Neighbour::default();
    let begin = |twin: &mut dyn Twin| {
        if let Some(state) = start {
            twin.place(&state.coordinates, &state.rates);
        }
    };
    let mut end = None;
    let found = motion::run(scene, &plant, span, begin, |now| {
        if let Some(transient) = &mut settling {
            if transient.goes_on(now, 1.0 / rate)? {
                return Ok(());
            }
            settling = None;
        }
        if path.len() == measured {
            let (coordinates, rates) = (now.twin.coordinates().to_vec(), now.twin.rates().to_vec());
            end = Some(State { coordinates, rates });
            return Err(Stop::Measured);
        }
        path.add(now);
        if options.lyapunov { Ok(neighbour.follow(now, 1.0 / rate)?) } else { Ok(()) }
    });
    let speed_rpm = scene.shaft.speed.nominal() / TAU * 60.0;
    let effects: Vec<EffectChange> =
        effect_significance::at_rest(scene, &plant)?.into_iter().map(EffectChange::from).collect();
    let end = match (found, end) {
        (_, Some(end)) => end,
        (Err(Stop::Failed(Error::Motion(overflow))), None) => {
            return Ok((Figures::overflowed(speed_rpm, &overflow, effects), None));
        }
        (Err(Stop::Failed(error)), None) => return Err(error),
        (Ok(twin), None) => State { coordinates: twin.coordinates().to_vec(), rates: twin.rates().to_vec() },
        (Err(Stop::Measured), None) => return Err(SweepError::Standstill { file: scene.path.clone() }.into()),
    };
    let shaft = scene.shaft.speed.nominal() / TAU;
    let figures = Figures {
        speed_rpm,
        overflow: None,
        peak_to_peak: path.along.each_ref().map(|x| spread(x)),
        mean: path.along.each_ref().map(|x| x.iter().sum::<f64>() / x.len().max(1) as f64),
        lines: [shaft.abs(), pass, section / 2.0, section / 3.0].map(|hz| path.line(hz / rate)),
        period: path.period(),
        lyapunov: options.lyapunov.then(|| neighbour.exponent()),
        section: path.section(),
        spectrum: path.spectrum(options.periods),
        effects,
    };
    Ok((figures, Some(end)))
}

impl Figures {
    /// Returns the figures of a motion that overflows.
    fn overflowed(speed_rpm: f64, overflow: &MotionOverflow, effects: Vec<EffectChange>) -> Self {
        Self {
            speed_rpm,
            overflow: Some(overflow.to_string()),
            peak_to_peak: [f64::NAN; 3],
            mean: [f64::NAN; 3],
            lines: [[f64::NAN; 2]; 4],
            period: None,
            lyapunov: None,
            section: vec![],
            spectrum: vec![],
            effects,
        }
    }
}

/// Reason why a run ends before its span.
enum Stop {
    /// All periods are measured.
    Measured,
    Failed(Error),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// Transient at the start: over where neighbouring motions have contracted, or do not contract.
struct Settling {
    neighbour: Neighbour,
    /// Samples of the estimate by the damping.
    estimate: u64,
    samples: u64,
    /// Growth of the distance at the end of the last estimate.
    grown: f64,
}

impl Settling {
    fn new(estimate: u64) -> Self {
        Self { neighbour: Neighbour { along: 2, ..Neighbour::default() }, estimate, samples: 0, grown: 0.0 }
    }

    /// Returns true where the sample belongs to the transient.
    fn goes_on(&mut self, now: &ResponseSample<'_>, period: f64) -> Result<bool> {
        let is_section = self.samples.is_multiple_of(A_PERIOD as u64);
        if self.samples >= self.estimate && is_section {
            let grown = self.neighbour.grown;
            let has_died_out = grown <= DIED_OUT.ln();
            // A motion that does not contract over the estimate, such as a chaotic one, has no transient that dies out.
            let ends = self.samples.is_multiple_of(self.estimate);
            let is_lasting = ends && grown >= self.grown;
            if ends {
                self.grown = grown;
            }
            if has_died_out || is_lasting || self.samples >= self.estimate * LONGEST_TRANSIENT {
                return Ok(false);
            }
        }
        self.neighbour.follow(now, period)?;
        self.samples += 1;
        Ok(true)
    }
}

fn spread(x: &[f64]) -> f64 {
    let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(low, high), &x| (low.min(x), high.max(x)));
    if x.is_empty() { 0.0 } else { high - low }
}

/// The motion of the centre of mass, um.
#[derive(Default)]
struct Path {
    along: [Vec<f64>; 3],
}

impl Path {
    fn add(&mut self, now: &ResponseSample<'_>) {
        for (along, x) in self.along.iter_mut().zip(now.plant.pose(now.twin.coordinates()).to_array()) {
            along.push(x * 1e6);
        }
    }

    fn len(&self) -> usize {
        self.along[0].len()
    }

    /// Returns the amplitude along X and Y at a frequency in cycles a sample, under a Hann window.
    fn line(&self, frequency: f64) -> [f64; 2] {
        let phases = || (0..).map(|i| Phase::from_revolutions(frequency * f64::from(i)));
        let amplitude = |x: &[f64]| {
            let [cosine, sine] = line(x, phases());
            cosine.hypot(sine)
        };
        if frequency > 0.0 { [amplitude(&self.along[0]), amplitude(&self.along[1])] } else { [0.0; 2] }
    }

    fn section(&self) -> Vec<[f64; 2]> {
        let [x, y, _] = &self.along;
        x.iter().zip(y).step_by(A_PERIOD).map(|(x, y)| [*x, *y]).collect()
    }

    fn period(&self) -> Option<usize> {
        let [x, y, _] = &self.along;
        let size = spread(x).max(spread(y));
        (1..=LONGEST_PERIOD).find(|&k| {
            let apart = |x: &[f64]| {
                let later = x.get(k * A_PERIOD..).unwrap_or_default();
                x.iter().zip(later).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
            };
            apart(x).max(apart(y)) <= SAME * size
        })
    }

    fn spectrum(&self, periods: usize) -> Vec<f64> {
        let output = amplitudes(&self.along[0]);
        let (count, span) = SPECTRUM;
        let bin = |k: usize| (k as f64 / count as f64 * span * periods as f64).round() as usize;
        let strip = |k: usize| {
            let strip = output.get(bin(k)..bin(k + 1).max(bin(k) + 1)).unwrap_or_default();
            strip.iter().copied().fold(0.0, f64::max)
        };
        (0..count).map(strip).collect()
    }
}

/// A second twin close to the first, rescaled to its initial distance every period (Benettin's method for the largest
/// Lyapunov exponent).
#[derive(Default)]
struct Neighbour {
    twin: Option<Box<dyn Twin>>,
    steps: usize,
    grown: f64,
    time: f64,
    size: f64,
    /// Number of coordinates in which the second twin starts away from the first, at least 1.
    along: usize,
    /// Frequency by which rates are divided to compare them with displacements, rad/s.
    frequency: f64,
}

impl Neighbour {
    /// Advances the second twin by one step; called before the first twin takes the step that `now` drives.
    fn follow(&mut self, now: &ResponseSample<'_>, period: f64) -> Result<()> {
        let Some(twin) = &mut self.twin else {
            let mut twin = now.plant.start(period, now.turned)?;
            self.frequency = now.plant.highest_frequency();
            self.size = now.twin.coordinates().iter().fold(0.0_f64, |most, x| most.max(x.abs())).max(1e-9);
            let mut coordinates = now.twin.coordinates().to_vec();
            for coordinate in coordinates.iter_mut().take(self.along.max(1)) {
                *coordinate += NEIGHBOUR * self.size;
            }
            twin.place(&coordinates, now.twin.rates());
            twin.step(&now.drive);
            self.twin = Some(twin);
            return Ok(());
        };
        self.steps += 1;
        if self.steps.is_multiple_of(A_PERIOD) {
            let frequency = self.frequency;
            let away = |mine: &[f64], other: &[f64], scale: f64| -> Vec<f64> {
                mine.iter().zip(other).map(|(a, b)| (a - b) * scale).collect()
            };
            let q = away(twin.coordinates(), now.twin.coordinates(), 1.0);
            let v = away(twin.rates(), now.twin.rates(), 1.0 / frequency);
            let distance = q.iter().chain(&v).map(|x| x * x).sum::<f64>().sqrt();
            let back = NEIGHBOUR * self.size / distance.max(f64::MIN_POSITIVE);
            self.grown -= back.ln();
            self.time += A_PERIOD as f64 * period;
            let near = |other: &[f64], away: &[f64], scale: f64| -> Vec<f64> {
                other.iter().zip(away).map(|(x, d)| x + d * back * scale).collect()
            };
            twin.place(&near(now.twin.coordinates(), &q, 1.0), &near(now.twin.rates(), &v, frequency));
        }
        twin.step(&now.drive);
        Ok(())
    }

    fn exponent(&self) -> f64 {
        if self.time > 0.0 { self.grown / self.time } else { 0.0 }
    }
}
