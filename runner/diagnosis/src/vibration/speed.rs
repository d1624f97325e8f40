//! Shaft speed from the vibration, where it is not measured.
//!
//! The speed of a scene is that of a name plate. Each speed within 10 % of it is compared by the multiples of the
//! shaft speed in the signal and in its envelope, and by the family of lines that fits best at this speed, whatever
//! its order: its side bands are at distances of the shaft speed, and lines at multiples of the shaft speed belong to
//! no family. The geometry of the bearings does not enter, so a wrong bearing cannot move the speed to where it fits.
//! A speed whose multiples do not stand out, or that is left with a wide interval, is not determined: a component that
//! fits one of these speeds is not named.

use super::envelope::SensorSpectra;
use super::family::Lines;
use super::spectrum::{LineField, Spectrum, is_of_mains};

/// Range of the search about the speed of the scene, and its step. Name plates are 6 % off, and asynchronous motors
/// slip.
const RANGE: f64 = 0.10;
const STEP: f64 = 0.000_25;
/// Multiples of the shaft speed that are looked for.
const MULTIPLES: usize = 10;
/// Ratio to the noise from which a line counts: of the signal one in 10^5 bins of noise, of the averaged envelope as
/// rare.
const LEAST_RATIO: f64 = 12.0;
const LEAST_ENVELOPE_RATIO: f64 = 6.0;
/// Greatest logarithm of a line, and what an absent multiple costs.
const GREATEST: f64 = 8.0;
const ABSENT: f64 = 0.5;
/// Greatest evidence of all multiples over that of 1X and 2X.
const OF_LOWEST: f64 = 3.0;
/// Error of the frequency of a line, bins.
const ERROR_BINS: f64 = 0.35;
/// Weight of the multiples in the signal and in the envelope. Multiples of one shaft come together, so they are not
/// independent.
const OF_SIGNAL: f64 = 0.5;
const OF_ENVELOPE: f64 = 0.25;
/// Standard deviation of the speed about that of the scene, and the least logarithm of its probability: speeds that
/// are 4 to 6 % off occur.
const SCENE_DEVIATION: f64 = 0.01;
const LEAST_PRIOR: f64 = -3.0;
/// Logarithm of the likelihood that a speed may be below the likeliest: 95 % of a normal distribution are within 2;
/// the multiples of coarse spectra need more.
const WITHIN: f64 = 3.0;
/// Speeds farther below the likeliest without a family have none with it.
const HOPELESS: f64 = 25.0;
/// Evidence of multiples over their median from which the speed is confirmed: odds of 50.
const CONFIRMED: f64 = 4.0;
/// Widest interval of a speed that is determined. Slip and contact angle move an order by up to 2.5 %: what lies 4 %
/// beside it must stay beyond both.
const DETERMINED: f64 = 0.02;
/// Speeds of the search of which one is tried where the speed is not determined: the side bands then move by less than
/// the error of a line.
const COARSE: usize = 4;
/// Orders of the families that are tried.
const FAMILY_ORDERS: [f64; 2] = [0.85, 9.0];
/// Strength of a line from which it may be a carrier's harmonic, and the harmonics that it may be.
const CARRIER: f64 = 1.0;
const CARRIER_HARMONICS: [f64; 3] = [1.0, 2.0, 3.0];
/// Side bands of a family of unknown origin, orders.
const SIDE_BANDS: [f64; 2] = [1.0, 2.0];

/// A family of lines of any order.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Family {
    /// Evidence, at least 0.
    pub evidence: f64,
    /// Frequency of its carrier, Hz; 0 of none.
    pub carrier_hz: f64,
}

/// A shaft speed with the evidence for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    /// Speed, rev/s.
    pub turn_hz: f64,
    /// Logarithm of the likelihood.
    likelihood: f64,
    /// Logarithm by which the likeliest speed is likelier.
    pub deficit: f64,
}

/// Speeds that the vibration allows.
#[derive(Debug, Clone)]
pub(crate) struct Speeds {
    /// In rising order.
    pub candidates: Vec<Candidate>,
    /// Likeliest speed, rev/s.
    pub likeliest_hz: f64,
    /// It is measured, or its multiples show it within an interval of 2 %.
    pub is_determined: bool,
}

impl Speeds {
    /// Returns the speeds about `turn_hz`, which the scene states, or exactly `turn_hz` where it is measured.
    pub fn new(spectra: &[&SensorSpectra], lines: &Lines, turn_hz: f64, is_measured: bool) -> Self {
        if is_measured {
            let candidates = vec![Candidate { turn_hz, likelihood: 0.0, deficit: 0.0 }];
            return Self { candidates, likeliest_hz: turn_hz, is_determined: true };
        }
        let half = (RANGE / STEP) as i32;
        let speeds: Vec<f64> = (-half..=half).map(|i| turn_hz * (1.0 + STEP * f64::from(i))).collect();
        let mut multiples = vec![0.0; speeds.len()];
        for (weight, least, of) in [
            (OF_SIGNAL, LEAST_RATIO, (|s| &s.raw) as fn(&SensorSpectra) -> &Spectrum),
            (OF_ENVELOPE, LEAST_ENVELOPE_RATIO, SensorSpectra::envelope),
        ] {
            let field = comb(spectra.iter().map(|s| of(s)), least, turn_hz);
            for (sum, speed) in multiples.iter_mut().zip(&speeds) {
                let strengths: Vec<f64> = (1..=MULTIPLES).filter_map(|k| field.at(k as f64 * speed)).collect();
                let all = strengths.iter().map(|strength| strength - ABSENT).sum::<f64>();
                // Harmonics of a ball pass near 3X or 5X are multiples of no shaft that has neither 1X nor 2X.
                *sum += weight * all.min(OF_LOWEST * strengths.iter().take(2).sum::<f64>());
            }
        }
        let mut sorted = multiples.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let prior = |speed: f64| {
            let deviation = (speed / turn_hz - 1.0) / SCENE_DEVIATION;
            (-0.5 * deviation * deviation).max(LEAST_PRIOR)
        };
        let alone: Vec<f64> = speeds.iter().zip(&multiples).map(|(speed, m)| m + prior(*speed)).collect();
        let greatest = alone.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let carriers = carriers(lines, turn_hz);
        let mut candidates: Vec<(Candidate, f64)> = vec![];
        for ((speed, alone), multiples) in speeds.iter().zip(&alone).zip(&multiples) {
            if *alone > greatest - HOPELESS {
                let family = best_family(lines, &carriers, *speed).evidence;
                candidates.push((Candidate { turn_hz: *speed, likelihood: alone + family, deficit: 0.0 }, *multiples));
            }
        }
        let likeliest = candidates.iter().max_by(|a, b| a.0.likelihood.total_cmp(&b.0.likelihood)).copied();
        let Some((best, multiples)) = likeliest else {
            return Self { candidates: vec![], likeliest_hz: turn_hz, is_determined: false };
        };
        let is_confirmed = multiples > median + CONFIRMED;
        let deficit = |c: Candidate| Candidate { deficit: best.likelihood - c.likelihood, ..c };
        let all = candidates.into_iter().map(|(candidate, _)| deficit(candidate));
        let candidates: Vec<Candidate> =
            if is_confirmed { all.filter(|c| c.deficit < WITHIN).collect() } else { all.step_by(COARSE).collect() };
        let mut speeds =
            Self { candidates, likeliest_hz: if is_confirmed { best.turn_hz } else { turn_hz }, is_determined: false };
        let [least, greatest] = speeds.interval();
        speeds.is_determined = is_confirmed && greatest / least - 1.0 <= DETERMINED;
        speeds
    }

    /// Returns the least and the greatest speed that the vibration allows, rev/s.
    pub fn interval(&self) -> [f64; 2] {
        let ends = [self.candidates.first(), self.candidates.last()];
        ends.map(|candidate| candidate.map_or(self.likeliest_hz, |c| c.turn_hz))
    }
}

/// Returns the lines of the spectra of all sensors, without multiples of the supply frequency.
fn comb<'a>(spectra: impl Iterator<Item = &'a Spectrum>, least_ratio: f64, turn_hz: f64) -> LineField {
    let spectra: Vec<&Spectrum> = spectra.collect();
    let bin_hz = spectra.first().map_or(1.0, |s| s.bin_hz);
    let mut field = LineField::new(0.1 * bin_hz, (MULTIPLES as f64 + 1.0) * (1.0 + RANGE) * turn_hz);
    for spectrum in &spectra {
        let peaks = spectrum.peaks(least_ratio);
        let lines = peaks.iter().filter(|peak| !is_of_mains(peak.hz, bin_hz));
        field.add(lines.map(|peak| (peak.hz, peak.ratio.ln().min(GREATEST), ERROR_BINS * bin_hz)));
    }
    field.close(spectra.len());
    field
}

/// Returns the family that fits best at a speed, whatever its order.
pub(crate) fn strongest_family(lines: &Lines, turn_hz: f64) -> Family {
    best_family(lines, &carriers(lines, turn_hz), turn_hz)
}

/// Returns the frequencies that may be carriers of a family, Hz.
fn carriers(lines: &Lines, turn_hz: f64) -> Vec<f64> {
    let [least, greatest] = FAMILY_ORDERS.map(|order| order * turn_hz);
    let mut all: Vec<f64> = lines
        .field
        .maxima(CARRIER)
        .flat_map(|hz| CARRIER_HARMONICS.map(|k| hz / k))
        .filter(|hz| *hz > least && *hz < greatest)
        .collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Returns the best family at a speed.
fn best_family(lines: &Lines, carriers: &[f64], turn_hz: f64) -> Family {
    let of = |hz: &f64| Family { evidence: lines.evidence(*hz, &SIDE_BANDS, turn_hz), carrier_hz: *hz };
    let best = carriers.iter().map(of).max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    best.filter(|family| family.evidence > 0.0).unwrap_or_default()
}
