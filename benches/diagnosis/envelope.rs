//! The alternative without a model: envelope spectrum of every radial probe, lines at the ball-pass orders, and the change of
//! the 1X amplitude.
//!
//! Band-pass about the 20 orders with the highest energy above 5 times the shaft speed, envelope as magnitude of the analytic
//! signal, its amplitude spectrum under a Hann window. The level of a component is the mean, in dB over the local median, of
//! three harmonics of its ball-pass order and of their sidebands (1X for the inner race, cage order for a ball), with the cage
//! slip between 0 and 2 % that gives the highest level, at the probes nearest to the bearing. The component and the
//! bearing whose level is highest over the threshold are named. A change of the 1X amplitude from that of the
//! machine in good order by more than 25 % names unbalance.
//!
//! The thresholds are set with the recordings of the machines in good order, so that none of them has a diagnosis: the best case
//! for this method.

use crate::fleet::{Fleet, HEALTHY, Recording};
use crate::program::Diagnosis;
use ballrace_twin::recording::{Reader, Row};
use ballrace_twin::scene::build::kinematics;
use ballrace_twin::scene::{Direction, Probe, Scene};
use ballrace_twin::{scene, spectrum};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::error::Error;

/// Lower end of the band, orders of the shaft.
const FIRST_ORDER: f64 = 5.0;
/// Width of the band, orders.
const BAND_ORDERS: f64 = 20.0;
/// Harmonics of a ball-pass order.
const HARMONICS: usize = 3;
/// Highest cage slip, and the steps of its scan.
const HIGHEST_SLIP: f64 = 0.02;
const SLIPS: usize = 40;
/// Half the width, in orders, about a line whose median is its background.
const BACKGROUND_ORDERS: f64 = 0.8;
/// Change of the 1X amplitude that names unbalance, as a share.
const SIGNIFICANT_CHANGE: f64 = 0.25;
/// The kinds of bearing faults, in the order of the levels.
const KINDS: [&str; 3] = ["outer-race", "inner-race", "element"];

/// Lines of one bearing in the envelope spectra of the probes nearest to it, by component.
#[derive(Debug, Clone)]
struct BearingLines {
    name: String,
    /// Mean level over the background, dB.
    levels: [f64; KINDS.len()],
}

/// Levels found in the envelope spectra of a recording.
#[derive(Debug, Clone)]
pub struct Signature {
    /// Amplitude at the shaft speed of each radial probe, m.
    one_x: Vec<f64>,
    bearings: Vec<BearingLines>,
}

/// Amplitude spectrum against orders of the shaft.
struct OrderSpectrum {
    amplitudes: Vec<f64>,
    bins_per_order: f64,
}

impl OrderSpectrum {
    /// Returns the level of the line at `order` over the median about it, dB.
    fn level(&self, order: f64) -> f64 {
        let at = order * self.bins_per_order;
        let within = |half: f64| {
            let last = self.amplitudes.len().saturating_sub(1) as f64;
            &self.amplitudes
                [(at - half).clamp(0.0, last).round() as usize..=(at + half).clamp(0.0, last).round() as usize]
        };
        let peak = within(1.0).iter().copied().fold(0.0, f64::max);
        let mut around = within(BACKGROUND_ORDERS * self.bins_per_order).to_vec();
        around.sort_by(f64::total_cmp);
        let ratio = peak / around[around.len() / 2].max(f64::MIN_POSITIVE);
        20.0 * ratio.max(f64::MIN_POSITIVE).log10()
    }

    /// Returns the mean level of the harmonics of `order` and of their sidebands, dB.
    fn family(&self, order: f64, sideband: Option<f64>) -> f64 {
        let lines = (1..=HARMONICS).flat_map(|k| {
            let carrier = k as f64 * order;
            [Some(carrier), sideband.map(|s| carrier - s), sideband.map(|s| carrier + s)].into_iter().flatten()
        });
        let levels: Vec<f64> = lines.map(|line| self.level(line)).collect();
        levels.iter().sum::<f64>() / levels.len() as f64
    }
}

/// Readings of the radial probes, and the shaft speed in revolutions per sample.
struct Readings {
    signals: Vec<Vec<f64>>,
    speed: f64,
}

/// Reads the radial probes of a recording.
fn readings(fleet: &Fleet, scene: &Scene, recording: &Recording) -> Result<Readings, Box<dyn Error>> {
    let description = scene.recording.as_ref().ok_or("the scene has no recording")?;
    let mut reader = Reader::open(&fleet.file(&recording.rig, &recording.recording), description)?;
    let (mut signals, mut pulses) = (vec![vec![]; description.probes.len()], vec![]);
    let mut row = Row { probes: vec![f64::NAN; description.probes.len()], ..Row::default() };
    let mut was_high = true;
    while reader.next_row(&mut row)? {
        for (signal, reading) in signals.iter_mut().zip(&row.probes) {
            signal.push(*reading);
        }
        let is_high = row.rotation > 0.5;
        if is_high && !was_high {
            pulses.push(row.index);
        }
        was_high = is_high;
    }
    let (Some(first), Some(last)) = (pulses.first(), pulses.last()) else {
        return Err("found no keyphasor pulse".into());
    };
    let speed = (pulses.len() - 1) as f64 / (last - first) as f64;
    let radial = signals.into_iter().zip(&description.probes).filter(|(_, probe)| is_radial(probe));
    Ok(Readings { signals: radial.map(|(signal, _)| signal).collect(), speed })
}

fn is_radial(probe: &Probe) -> bool {
    matches!(probe.direction, Direction::Radial { .. })
}

/// Returns the envelope of the band with the highest energy.
fn envelope(signal: &[f64], revolutions_per_sample: f64) -> Vec<f64> {
    let n = signal.len();
    let mean = signal.iter().sum::<f64>() / n as f64;
    let mut bins: Vec<Complex<f64>> = signal.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(n).process(&mut bins);
    let bin = |order: f64| ((order * revolutions_per_sample * n as f64).round() as usize).min(n / 2);
    let energy = |from: f64| bins[bin(from)..bin(from + BAND_ORDERS)].iter().map(Complex::norm_sqr).sum::<f64>();
    let highest = 0.5 / revolutions_per_sample;
    let starts = std::iter::successors(Some(FIRST_ORDER), |from| Some(from + 1.0));
    let starts = starts.take_while(|from| *from == FIRST_ORDER || from + BAND_ORDERS <= highest);
    let from = starts.max_by(|a, b| energy(*a).total_cmp(&energy(*b))).unwrap_or(FIRST_ORDER);
    let band = bin(from)..bin(from + BAND_ORDERS);
    for (i, value) in bins.iter_mut().enumerate() {
        if !band.contains(&i) {
            *value = Complex::default();
        }
    }
    planner.plan_fft_inverse(n).process(&mut bins);
    bins.iter().map(|value| 2.0 * value.norm() / n as f64).collect()
}

impl Signature {
    /// Computes the envelope spectra of a recording.
    pub fn new(fleet: &Fleet, recording: &Recording) -> Result<Self, Box<dyn Error>> {
        let scene = scene::read::read_file(&fleet.scene(&recording.rig, false))?;
        let Readings { signals, speed } = readings(fleet, &scene, recording)?;
        let order_spectrum = |signal: &[f64]| OrderSpectrum {
            amplitudes: spectrum::amplitudes(signal),
            bins_per_order: signal.len() as f64 * speed,
        };
        let one_x = signals.iter().map(|signal| {
            let OrderSpectrum { amplitudes, bins_per_order } = order_spectrum(signal);
            amplitudes[bins_per_order.round() as usize]
        });
        let one_x = one_x.collect();
        let spectra: Vec<OrderSpectrum> =
            signals.iter().map(|signal| order_spectrum(&envelope(signal, speed))).collect();
        let probes = scene.recording.iter().flat_map(|recording| &recording.probes).filter(|probe| is_radial(probe));
        let stations: Vec<f64> = probes.map(|probe| probe.station).collect();
        let mut bearings = vec![];
        for bearing in &scene.bearings {
            let distance = |station: &f64| (station - bearing.station).abs();
            let nearest = stations.iter().map(distance).fold(f64::INFINITY, f64::min);
            let near = spectra.iter().zip(&stations).filter(|(_, station)| distance(station) < nearest + 1e-6);
            let near: Vec<&OrderSpectrum> = near.map(|(spectrum, _)| spectrum).collect();
            let rolling = kinematics(&scene, bearing)?.orders;
            let n = bearing.elements as f64;
            let mut levels = [f64::NEG_INFINITY; KINDS.len()];
            for step in 0..=SLIPS {
                let rate = 1.0 - HIGHEST_SLIP * step as f64 / SLIPS as f64;
                let cage = rolling.cage * rate;
                let orders =
                    [(n * cage, None), (n * (1.0 - cage), Some(1.0)), (2.0 * rolling.ball_spin * rate, Some(cage))];
                for (level, (order, sideband)) in levels.iter_mut().zip(orders) {
                    *level = near.iter().map(|spectrum| spectrum.family(order, sideband)).fold(*level, f64::max);
                }
            }
            bearings.push(BearingLines { name: bearing.name.clone(), levels });
        }
        Ok(Self { one_x, bearings })
    }

    /// Largest change of a 1X amplitude, as a share of that of another recording.
    fn change(&self, reference: &Self) -> f64 {
        let changes = self.one_x.iter().zip(&reference.one_x).map(|(a, b)| (a / b - 1.0).abs());
        changes.fold(0.0, f64::max)
    }
}

/// Returns the alternative's diagnoses for each recording.
pub fn diagnoses(recordings: &[Recording], signatures: &[Option<Signature>]) -> Vec<Vec<Diagnosis>> {
    let known = || recordings.iter().zip(signatures).filter_map(|(recording, s)| Some((recording, s.as_ref()?)));
    let change = |recording: &Recording, signature: &Signature| {
        let reference = known().find(|(r, _)| r.rig == recording.rig && r.recording == HEALTHY);
        reference.map_or(0.0, |(_, reference)| signature.change(reference))
    };
    let mut thresholds = [f64::NEG_INFINITY; KINDS.len()];
    let mut significant = SIGNIFICANT_CHANGE;
    for (recording, signature) in known().filter(|(recording, _)| recording.faults().is_empty()) {
        for bearing in &signature.bearings {
            thresholds = std::array::from_fn(|i| thresholds[i].max(bearing.levels[i]));
        }
        significant = significant.max(change(recording, signature));
    }
    let diagnosis = |recording: &Recording, signature: &Signature| {
        let is_unbalanced = change(recording, signature) > significant;
        let unbalance = || Diagnosis { kind: "unbalance".to_owned(), ..Diagnosis::default() };
        if is_unbalanced { Some(unbalance()) } else { name(signature, &thresholds) }
    };
    let diagnoses = recordings.iter().zip(signatures).map(|(recording, signature)| {
        signature.as_ref().and_then(|signature| diagnosis(recording, signature)).into_iter().collect()
    });
    diagnoses.collect()
}

/// Names the component and the bearing whose level is highest over its threshold.
fn name(signature: &Signature, thresholds: &[f64; KINDS.len()]) -> Option<Diagnosis> {
    let components =
        signature.bearings.iter().flat_map(|b| (0..KINDS.len()).map(move |i| (b.levels[i] - thresholds[i], i, b)));
    let (excess, component, bearing) = components.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let diagnosis =
        || Diagnosis { kind: KINDS[component].to_owned(), bearing: Some(bearing.name.clone()), ..Diagnosis::default() };
    (excess > 0.0).then(diagnosis)
}
