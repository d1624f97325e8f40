//! Diagnosis from envelope spectra: one joint hypothesis for the machine.
//!
//! The machine has no damaged bearing, or one component of one bearing is damaged. Each hypothesis has its whole
//! pattern: harmonics of one carrier with one slip, and side bands. A line is evidence for one hypothesis only, since
//! one is named. A hypothesis is named where
//!
//! 1. its evidence exceeds what noise and foreign lines reach by chance over all slips and speeds that are tried,
//! 2. no family of lines at another order, whatever its origin, explains clearly more: lines of another bearing or of
//!    a gear are then the cause, or the geometry is wrong,
//! 3. the envelope is modulated by more than the races of a good bearing do,
//! 4. it has grown against the baseline, where there is one.

use super::component::{KINDS, Pattern, in_words, patterns};
use super::envelope::{BLOCK_TURNS, HIGHEST_ORDER, MOST_PARTS, Rotation, SensorSpectra, Transforms};
use super::family::{HARMONIC_COUNT, Lines};
use super::picture;
use super::rotor;
use super::spectrum::{LineField, Spectrum};
use super::speed::{Speeds, strongest_family};
use super::suspect::Suspect;
use ballrace_outcome::baseline::{Baseline, BaselineSensor};
use ballrace_outcome::{
    Diagnosis, EnvelopeSpectrum, EvidenceSource, FailureMode, FaultFigures, FaultKind, FaultParameters, LineLevel,
    VibrationLine,
};
use ballrace_scene::Sensor;

/// Number of harmonics that must lie below half the rate with room for the impacts.
const HARMONICS: usize = 3;
/// Step of the search for the slip: the fifth harmonic moves by less than its error.
const SLIP_STEP: f64 = 4e-4;
/// Standard deviation of the slip.
const SLIP_DEVIATION: f64 = 0.01;
/// Ratio to the noise from which a maximum of the envelope counts: noise exceeds it in 5 % of the bins.
const LEAST_RATIO: f64 = 3.0;
/// Greatest logarithm of a line over this ratio.
const GREATEST: f64 = 9.0;
/// Steps of the field in a revolution.
const STEPS_PER_ORDER: f64 = 1000.0;
/// Error of the frequency of a line: bins, and a share by the jitter of a slipping cage.
const ERROR_BINS: f64 = 0.4;
const ERROR_SHARE: f64 = 3e-4;
/// Least evidence. The cells of slip and speed of all components are some thousands, `ln` of which is 8; less a line
/// that noise always has somewhere. Good bearings reach 5.
const LEAST_EVIDENCE: f64 = 6.0;
/// Share of the evidence of the best family of any order that a hypothesis must have.
const OF_BEST_FAMILY: f64 = 0.75;
/// Logarithm of the number of bands: what the best of several reaches by chance. The full band, in which impacts
/// usually show, has none.
const OF_SEVERAL_BANDS: f64 = 2.7;
/// Distance between two estimates of the frequency of one carrier, bins.
const SAME_BINS: f64 = 1.0;
/// Amplitude over that of the strongest line that a carrier has at least: side bands are weaker.
const OF_STRONGEST_LINE: f64 = 0.5;
/// Least order of a ball pass, and bins of a line under the Hann window.
const LOWEST_PASS: f64 = 1.5;
const LOBE_BINS: f64 = 2.0;
/// Least modulation of the whitened envelope by the harmonics of the carrier together. Its mean is 1 in every machine;
/// good bearings modulate it by up to 0.13, damaged ones by 0.3 to 2.6.
const LEAST_MODULATION: f64 = 0.2;
/// Least modulation of a levelled envelope. In a part of the range the bins of noise are fewer: lines of the same
/// significance are stronger by the root of the number of parts. Good bearings reach 0.17 of it, impacts at one
/// resonance 0.9. In a recording shorter than a block every part needs as much as the least part.
const LEAST_OF_BAND: f64 = 0.25;
/// Share of the revolutions of a block from which it is whole: the speed may be 10 % off.
const WHOLE: f64 = 0.85;
/// First bin in which a line has a level.
const FIRST_BIN: f64 = 2.0;
/// Greatest evidence of any family in the whitened envelope at which the levelled ones are asked: a stronger family has a
/// cause.
const MOST_UNSEEN: f64 = 12.0;
/// Modulation over that of another hypothesis from which the other is made of side bands: those of a full modulation
/// are as strong as the carrier.
const STRONGER: f64 = 1.5;
/// Smallest growth of the modulation against the baseline, dB.
const MIN_GROWTH_DB: f64 = 6.0;
/// Bins about a harmonic in which its amplitude is taken.
const AMPLITUDE_BINS: usize = 2;
/// Largest share of the power at multiples of the supply frequency, where no line turns with the shaft.
const MOST_MAINS: f64 = 0.5;
/// Ratio to its surroundings from which a harmonic is counted in the sentence.
const VISIBLE_RATIO: f64 = 10.0;

/// Detector of bearing faults in the envelope spectra of sensors.
pub(crate) struct FaultDetector<'a> {
    /// All bearings.
    pub suspects: &'a [Suspect],
    /// Rotation of the shaft.
    pub rotation: Rotation<'a>,
    /// Samples per second.
    pub rate: f64,
    /// Baseline of the machine in good order, where it is known.
    pub baseline: Option<&'a Baseline>,
    /// The speed is measured, not that of the scene.
    pub is_speed_measured: bool,
}

/// Result of the detector.
#[derive(Debug, Default)]
pub(crate) struct Judgement {
    /// The fault, where one is named.
    pub diagnoses: Vec<Diagnosis>,
    /// Baseline of the sensors.
    pub learned: Vec<BaselineSensor>,
    /// One envelope spectrum a sensor.
    pub envelopes: Vec<EnvelopeSpectrum>,
    /// Statement of a speed that is not measured.
    pub speed: Option<String>,
    /// Lines of the shaft that have grown against the baseline.
    pub rotor: Option<String>,
    /// Statement of a strong family of lines that no component explains.
    pub foreign: Option<String>,
    /// Reason why nothing is judged.
    pub not_judged: Option<String>,
    /// Shaft speed, rev/s.
    pub turn_hz: Option<f64>,
}

/// A component of a bearing as the cause, at the slip and the speed that fit best.
struct Hypothesis {
    pattern: Pattern,
    /// Number of the bearing.
    bearing: usize,
    /// Number of the band, and the number of bands of its width.
    band: usize,
    parts: u32,
    /// The recording has a whole block or several signals: a line that lasts is told from one of a moment.
    is_averaged: bool,
    evidence: f64,
    /// Its share of the evidence of the strongest family of any order at the same speed.
    share: f64,
    /// That family is its own: it has the same carrier, or a harmonic of it.
    is_strongest: bool,
    /// Amplitude of its strongest harmonic over that of the strongest line of any origin but the shaft.
    of_strongest: f64,
    carrier_hz: f64,
    turn_hz: f64,
    /// Modulation by the harmonics of the carrier together, for each sensor; 0 for one that does not measure the
    /// bearing.
    modulations: Vec<f64>,
    sensors: usize,
}

impl Hypothesis {
    /// Returns the least modulation by damage.
    fn least_modulation(&self) -> f64 {
        if self.band == 0 {
            LEAST_MODULATION
        } else {
            let parts = if self.is_averaged { self.parts } else { MOST_PARTS };
            LEAST_OF_BAND * f64::from(parts).sqrt()
        }
    }

    /// Returns the mean modulation of the sensors that measure the bearing.
    fn modulation(&self) -> f64 {
        self.modulations.iter().sum::<f64>() / self.sensors.max(1) as f64
    }
}

/// Largest deviation from the speed of the scene at which a component is named although the vibration does not determine it.
const SCENE_ERROR: f64 = 0.01;

/// Sensors with their spectra; none where a sensor has no usable signal.
type Sensors<'s> = [(&'s Sensor, Option<SensorSpectra>)];

impl FaultDetector<'_> {
    /// Returns the spectra of a signal.
    pub fn spectra(&self, signal: &[f64], transforms: &mut Transforms) -> Option<SensorSpectra> {
        let least_width = self.highest_line() * self.rotation.fastest_hz;
        SensorSpectra::new(signal, self.rate, self.rotation, least_width, transforms)
    }

    /// Judges the machine from the spectra of its sensors.
    pub fn judge(&self, sensors: &Sensors<'_>) -> Judgement {
        let all: Vec<&SensorSpectra> = sensors.iter().filter_map(|(_, spectra)| spectra.as_ref()).collect();
        if all.is_empty() {
            return Judgement::default();
        }
        let machine = self.lines(&all, 0);
        let speeds = Speeds::new(&all, &machine, self.rotation.turn_hz, self.is_speed_measured);
        let bands = all.iter().map(|spectra| spectra.bands.len()).min().unwrap_or(0);
        let mut hypotheses = vec![];
        for band in 0..bands {
            let machine = self.lines(&all, band);
            for (bearing, suspect) in self.suspects.iter().enumerate() {
                let is_own =
                    |i: &usize| sensors.get(*i).is_some_and(|(sensor, s)| s.is_some() && measures(sensor, suspect));
                let own: Vec<usize> = (0..sensors.len()).filter(is_own).collect();
                let spectra: Vec<&SensorSpectra> = own.iter().filter_map(|&i| sensors.get(i)?.1.as_ref()).collect();
                let lines = if own.len() == all.len() { machine.clone() } else { self.lines(&spectra, band) };
                for pattern in patterns(suspect) {
                    hypotheses.push(fit(pattern, (bearing, band), &lines, &speeds, (sensors, &own)));
                }
            }
        }
        let mains = all.iter().map(|s| s.mains).sum::<f64>() / all.len() as f64;
        let turn_hz = speeds.likeliest_hz;
        let mut judgement = Judgement {
            learned: self.learned(sensors, &hypotheses, turn_hz),
            speed: self.speed_note(&speeds),
            turn_hz: Some(turn_hz),
            ..Judgement::default()
        };
        if !speeds.is_determined && mains > MOST_MAINS {
            judgement.not_judged = Some(format!(
                "{:.0} % of the power of the sensors is at multiples of the supply frequency, and no line turns with the \
                 shaft: the machine stands still, or the sensors measure the supply",
                100.0 * mains
            ));
            return judgement;
        }
        judgement.not_judged = rotor::standstill(&judgement.learned, self.baseline);
        if judgement.not_judged.is_some() {
            return judgement;
        }
        judgement.rotor = rotor::growth(sensors, &judgement.learned, self.baseline);
        let strongest = strongest_family(&machine, turn_hz);
        let named = self.named(&hypotheses, sensors, strongest.evidence);
        let shown = named.as_ref().map(|(_, band)| *band);
        // Whitening removes regular families, which the levelled envelope shows.
        let levelled = strongest_family(&self.lines(&all, 1), turn_hz);
        let strongest = if levelled.evidence > strongest.evidence { levelled } else { strongest };
        match named {
            Some((diagnosis, _)) if speeds.is_determined || self.is_only(&diagnosis, &speeds) => {
                judgement.diagnoses.push(diagnosis);
            }
            Some((diagnosis, _)) => judgement.not_judged = Some(undetermined(&speeds, &of_component(&diagnosis))),
            None if strongest.evidence < MOST_UNSEEN => {}
            None if speeds.is_determined => judgement.foreign = Some(foreign(strongest.carrier_hz, turn_hz)),
            None => {
                let lines =
                    format!("The family of lines at {:.1} Hz is then of an unknown order", strongest.carrier_hz);
                judgement.not_judged = Some(undetermined(&speeds, &lines));
            }
        }
        for (sensor, spectra) in sensors {
            let Some(spectra) = spectra else { continue };
            let measured: Vec<&Suspect> = self.suspects.iter().filter(|suspect| measures(sensor, suspect)).collect();
            let range = [turn_hz, self.highest_line() * turn_hz];
            judgement.envelopes.extend(picture::envelope(sensor, &measured, range, spectra, shown));
        }
        judgement
    }

    /// Returns the lines of the envelopes of sensors together.
    fn lines(&self, spectra: &[&SensorSpectra], band: usize) -> Lines {
        let turn_hz = self.rotation.turn_hz;
        let spectra: Vec<&Spectrum> = spectra.iter().filter_map(|s| Some(&s.bands.get(band)?.spectrum)).collect();
        let bin_hz = spectra.first().map_or(1.0, |s| s.bin_hz);
        let mut field = LineField::new(turn_hz / STEPS_PER_ORDER, HIGHEST_ORDER * turn_hz);
        for one in &spectra {
            let strength = |ratio: f64| (ratio / LEAST_RATIO).ln().min(GREATEST);
            let error = |hz: f64| (ERROR_BINS * bin_hz).hypot(ERROR_SHARE * hz);
            let peaks = one.peaks(LEAST_RATIO);
            field.add(peaks.iter().map(|peak| (peak.hz, strength(peak.ratio), error(peak.hz))));
        }
        field.close(spectra.len());
        Lines { field, bin_hz }
    }

    /// Returns the diagnosis of the best hypothesis, where it is one, and the number of its band. `strongest` is the
    /// evidence of the strongest family of any order in the whitened envelope.
    fn named(&self, hypotheses: &[Hypothesis], sensors: &Sensors<'_>, strongest: f64) -> Option<(Diagnosis, usize)> {
        let is_significant = |h: &&Hypothesis| {
            h.evidence >= LEAST_EVIDENCE
                && h.share >= OF_BEST_FAMILY
                && h.of_strongest >= if h.is_strongest { OF_STRONGEST_LINE } else { 1.0 }
                && h.modulation() >= h.least_modulation()
        };
        // What the whitened envelope shows is decided there. The others are for regular impacts and for those of one
        // resonance, which it does not show.
        let of_group = |first: bool| hypotheses.iter().filter(move |h| (h.band == 0) == first);
        // Side bands of a strong carrier, taken for a family of their own, are weaker than the carrier.
        let is_beside_stronger = |h: &Hypothesis, first: bool| {
            let others = of_group(first).filter(is_significant).filter(|other| other.pattern.kind != h.pattern.kind);
            others.map(Hypothesis::modulation).any(|modulation| modulation > STRONGER * h.modulation())
        };
        let strongest_of = |first: bool| {
            let own = of_group(first).filter(is_significant).filter(|h| !is_beside_stronger(h, first));
            own.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
        };
        let best = strongest_of(true).or_else(|| strongest_of(false).filter(|_| strongest < MOST_UNSEEN))?;
        let usual = self.baseline.map(|baseline| {
            let k = hypotheses.iter().take_while(|h| !std::ptr::eq(*h, best)).count();
            let modulations = (0..sensors.len()).map(|i| baseline.modulation(i, k));
            modulations.sum::<f64>() / best.sensors.max(1) as f64
        });
        let growth_db = usual.map(|usual| 20.0 * (best.modulation() / usual.max(1e-6)).log10());
        // Another component, or nothing of these, as likely as the least evidence.
        let against = |kind: FaultKind| {
            let others = of_group(best.band == 0).filter(|h| h.pattern.kind == kind && kind != best.pattern.kind);
            let equal = others.filter(|h| STRONGER * h.modulation() >= best.modulation());
            equal.map(|h| (h.evidence - best.evidence).exp()).fold(0.0, f64::max)
        };
        let weights = KINDS.map(against).iter().sum::<f64>();
        let confidence = 1.0 / (1.0 + weights + (LEAST_EVIDENCE - best.evidence).exp());
        let has_grown = growth_db.is_none_or(|growth| growth >= MIN_GROWTH_DB);
        // More likely than all others together.
        let is_named = has_grown && confidence > 0.5;
        is_named.then(|| (self.diagnosis(best, sensors, growth_db, confidence), best.band))
    }

    fn diagnosis(
        &self,
        best: &Hypothesis,
        sensors: &Sensors<'_>,
        growth_db: Option<f64>,
        confidence: f64,
    ) -> Diagnosis {
        let strongest = (0..sensors.len()).max_by(|a, b| {
            best.modulations.get(*a).unwrap_or(&0.0).total_cmp(best.modulations.get(*b).unwrap_or(&0.0))
        });
        let shown = strongest.and_then(|i| Some((sensors.get(i)?.0, sensors.get(i)?.1.as_ref()?)));
        let (mut band, mut column, mut ratios) = ([0.0, 0.5 * self.rate], String::new(), vec![]);
        if let Some((sensor, envelope)) =
            shown.and_then(|(sensor, spectra)| Some((sensor, spectra.bands.get(best.band)?)))
        {
            let background = envelope.spectrum.background();
            let of =
                |k: usize| envelope.spectrum.line((k + 1) as f64 * best.carrier_hz, AMPLITUDE_BINS, &background)[1];
            ratios = (0..HARMONIC_COUNT).map(of).collect();
            (band, column) = (envelope.band, sensor.column.clone());
        }
        let bearing = self.suspects.get(best.bearing).map(|s| s.name.clone()).unwrap_or_default();
        let order = best.carrier_hz / best.turn_hz;
        let has_same_line = |s: &&Suspect| {
            let orders = patterns(s);
            let same = orders.iter().find(|p| p.kind == best.pattern.kind);
            let [least, greatest] = best.pattern.slip;
            s.name != bearing && same.is_some_and(|p| (least..=greatest).contains(&(order / p.order - 1.0)))
        };
        let is_measured_too =
            |s: &&Suspect| sensors.iter().any(|(sensor, _)| sensor.column == column && measures(sensor, s));
        let others: Vec<String> =
            self.suspects.iter().filter(has_same_line).filter(is_measured_too).map(|s| s.name.clone()).collect();
        let level_db = growth_db.unwrap_or_else(|| 10.0 * ratios.iter().copied().fold(1.0, f64::max).log10());
        let over = if growth_db.is_some() { "the baseline" } else { "its surroundings" };
        let sentence = format!(
            "{}{} of {bearing}: the whitened envelope of {:.0} to {:.0} Hz at {column} has its line at {:.1} Hz, {order:.3} per \
             turn ({:+.1} % from pure rolling), {level_db:.0} dB above {over}, with {} of its next {} multiples; they modulate the envelope by {:.0} %. Odds \
             against any other cause {:.0}.{}",
            if confidence < 0.6 { "Possibly: " } else { "" },
            best.pattern.name,
            band[0],
            band[1],
            best.carrier_hz,
            100.0 * (order / best.pattern.order - 1.0),
            ratios.iter().skip(1).filter(|ratio| **ratio > VISIBLE_RATIO).count(),
            HARMONIC_COUNT - 1,
            100.0 * best.modulation(),
            (confidence / (1.0 - confidence)).min(1e9),
            if others.is_empty() {
                String::new()
            } else {
                format!(" The sensors do not exclude {}.", others.join(" or "))
            }
        );
        Diagnosis {
            kind: best.pattern.kind,
            bearing: Some(bearing),
            failure_modes: FailureMode::of(best.pattern.kind, None).to_vec(),
            line_hz: best.carrier_hz,
            order,
            level_db,
            confidence,
            evidence: vec![EvidenceSource::Vibration],
            vibration: Some(VibrationLine {
                sensor: column,
                band_hz: band,
                line_hz: best.carrier_hz,
                order,
                modulation: best.modulation(),
                level_db,
                not_excluded: others,
            }),
            sentence,
            parameters: FaultParameters::default(),
            lines: vec![],
            figures: FaultFigures::default(),
        }
    }

    fn learned(&self, sensors: &Sensors<'_>, hypotheses: &[Hypothesis], turn_hz: f64) -> Vec<BaselineSensor> {
        let of = |(i, (sensor, spectra)): (usize, &(&Sensor, Option<SensorSpectra>))| BaselineSensor {
            name: sensor.column.clone(),
            modulations: hypotheses.iter().map(|h| h.modulations.get(i).copied().unwrap_or(0.0)).collect(),
            rms: spectra.as_ref().map_or(0.0, |spectra| spectra.rms),
            shaft_lines: spectra.as_ref().map(|spectra| rotor::amplitudes(spectra, turn_hz)).unwrap_or_default(),
        };
        sensors.iter().enumerate().map(of).collect()
    }

    /// Returns true where a line fits its component at the speed that the scene states, and no other component at any speed that the
    /// vibration allows: the speed then does not decide.
    fn is_only(&self, diagnosis: &Diagnosis, speeds: &Speeds) -> bool {
        let fitted = diagnosis.line_hz / (diagnosis.order * self.rotation.turn_hz) - 1.0;
        let [least, greatest] = speeds.interval();
        let is_other = |suspect: &Suspect, pattern: &Pattern| {
            let is_same = diagnosis.bearing.as_ref() == Some(&suspect.name) && diagnosis.kind == pattern.kind;
            let [low, high] = pattern.slip.map(|slip| pattern.order * (1.0 + slip));
            !is_same && (low * least..=high * greatest).contains(&diagnosis.line_hz)
        };
        let has_other =
            self.suspects.iter().any(|suspect| patterns(suspect).iter().any(|pattern| is_other(suspect, pattern)));
        fitted.abs() <= SCENE_ERROR && !has_other
    }

    /// States a speed that is not measured.
    fn speed_note(&self, speeds: &Speeds) -> Option<String> {
        let scene = 60.0 * self.rotation.turn_hz;
        let [least, greatest] = speeds.interval().map(|hz| 60.0 * hz);
        if self.is_speed_measured {
            return None;
        }
        Some(if speeds.is_determined {
            format!(
                "Shaft speed from the vibration: {:.1} rpm ({least:.1} to {greatest:.1}); the scene states \
                 {scene:.1} rpm.",
                60.0 * speeds.likeliest_hz
            )
        } else {
            format!(
                "Shaft speed not determined: its multiples do not decide between {least:.1} and {greatest:.1} rpm; a component is \
                 named only at the {scene:.1} rpm of the scene, where its line is that of no other at any of these speeds."
            )
        })
    }

    /// Returns the level of each line that the sensor measures.
    pub fn levels(&self, sensor: &Sensor, spectra: &SensorSpectra) -> Vec<LineLevel> {
        let backgrounds: Vec<Vec<f64>> = spectra.bands.iter().map(|band| band.spectrum.background()).collect();
        let level = |suspect: &Suspect, pattern: &Pattern| {
            let at = |slip: f64, spectrum: &Spectrum, background: &[f64]| {
                let carrier = pattern.order * (1.0 + slip) * self.rotation.turn_hz;
                let ratio = |k: usize| spectrum.line(k as f64 * carrier, 1, background)[1];
                (1..=HARMONICS).map(|k| 10.0 * ratio(k).max(1.0).log10()).sum::<f64>() / HARMONICS as f64
            };
            let bands = || spectra.bands.iter().zip(&backgrounds);
            let levels =
                slips(pattern).flat_map(|slip| bands().map(move |(band, median)| at(slip, &band.spectrum, median)));
            LineLevel { bearing: suspect.name.clone(), component: pattern.kind, level_db: levels.fold(0.0, f64::max) }
        };
        let own = self.suspects.iter().filter(|suspect| measures(sensor, suspect));
        let all = own.flat_map(|suspect| patterns(suspect).map(|pattern| (suspect, pattern)));
        // The first bins hold the mean.
        let resolved = all.filter(|(_, p)| p.order * self.rotation.turn_hz >= FIRST_BIN * spectra.envelope().bin_hz);
        resolved.map(|(suspect, pattern)| level(suspect, &pattern)).collect()
    }

    /// Returns the highest order of a line that is looked for, harmonics included.
    #[must_use]
    pub fn highest_line(&self) -> f64 {
        let orders = self.suspects.iter().flat_map(|suspect| patterns(suspect).map(|pattern| pattern.order));
        (HARMONICS as f64 + 0.5) * orders.fold(0.0, f64::max)
    }

    /// Returns the smallest sampling rate at which the impacts are resolved, Hz.
    #[must_use]
    pub(crate) fn least_rate(&self) -> f64 {
        4.0 * self.highest_line() * self.rotation.fastest_hz
    }
}

/// Returns the greatest power above the background at orders of ball passes that are no multiples of the shaft speed.
fn strongest_line(spectrum: &Spectrum, background: &[f64], turn_hz: f64) -> f64 {
    let first = (LOWEST_PASS * turn_hz / spectrum.bin_hz) as usize;
    let of = |(i, (power, background)): (usize, (&f64, &f64))| {
        let order = i as f64 * spectrum.bin_hz / turn_hz;
        let is_of_shaft = (order - order.round()).abs() * turn_hz < LOBE_BINS * spectrum.bin_hz;
        if is_of_shaft { 0.0 } else { power - background }
    };
    spectrum.power.iter().zip(background).enumerate().skip(first).map(of).fold(0.0, f64::max)
}

/// Returns the reason why the lines in the envelope are not judged; `lines` says what they are.
fn undetermined(speeds: &Speeds, lines: &str) -> String {
    let [least, greatest] = speeds.interval().map(|hz| 60.0 * hz);
    format!(
        "the speed is not determined: neither a keyphasor nor a column measures it, and its multiples in the vibration do not \
         decide between {least:.1} and {greatest:.1} rpm. {lines}. A keyphasor, a column of the speed or a longer recording decides"
    )
}

/// States of which component the line of a diagnosis would be.
fn of_component(diagnosis: &Diagnosis) -> String {
    format!(
        "At {:.1} rpm the line at {:.1} Hz would be that of the {} of {}",
        60.0 * diagnosis.line_hz / diagnosis.order,
        diagnosis.line_hz,
        in_words(diagnosis.kind),
        diagnosis.bearing.as_deref().unwrap_or("a bearing"),
    )
}

/// States a family of lines that no component explains.
fn foreign(carrier_hz: f64, turn_hz: f64) -> String {
    format!(
        "A family of lines at {carrier_hz:.1} Hz, {:.3} per turn, is of no component of these bearings: another bearing or a gear \
         is the cause, or the geometry of the scene is not that of the bearing.",
        carrier_hz / turn_hz
    )
}

fn measures(sensor: &Sensor, suspect: &Suspect) -> bool {
    sensor.bearing.as_ref().is_none_or(|name| *name == suspect.name)
}

fn slips(pattern: &Pattern) -> impl Iterator<Item = f64> + use<> {
    let [least, greatest] = pattern.slip;
    let steps = ((greatest - least) / SLIP_STEP).round() as i32;
    (0..=steps).map(move |i| least + SLIP_STEP * f64::from(i))
}

/// Returns true where a ratio of two frequencies is a whole number or the inverse of one, within `error`.
fn is_harmonic(ratio: f64, error: f64) -> bool {
    let of = |ratio: f64| (ratio - ratio.round().max(1.0)).abs() <= error * ratio;
    ratio > 0.0 && (of(ratio) || of(1.0 / ratio))
}

/// Fits slip and speed of a pattern to the lines of a band.
fn fit(
    pattern: Pattern,
    (bearing, band): (usize, usize),
    lines: &Lines,
    speeds: &Speeds,
    (sensors, own): (&Sensors<'_>, &[usize]),
) -> Hypothesis {
    let mut best = (f64::NEG_INFINITY, 0.0, 0.0, 0.0);
    for speed in &speeds.candidates {
        // The slip counts from the likeliest speed: the error of another speed is no further slip.
        let turn_hz = if speeds.is_determined { speeds.likeliest_hz } else { speed.turn_hz };
        for slip in slips(&pattern) {
            let carrier = pattern.order * (1.0 + slip) * turn_hz;
            let unlikely = 0.5 * (slip / SLIP_DEVIATION).powi(2) + speed.deficit;
            let evidence = lines.evidence(carrier, &pattern.side_bands, speed.turn_hz) - unlikely;
            if evidence > best.0 {
                best = (evidence, carrier, speed.turn_hz, unlikely);
            }
        }
    }
    let (evidence, carrier_hz, turn_hz, unlikely) = best;
    let handicap = if band == 0 { 0.0 } else { OF_SEVERAL_BANDS };
    let evidence = evidence - handicap;
    let mut modulations = vec![0.0; sensors.len()];
    let (mut parts, mut of_strongest) = (1, 0.0);
    for &i in own {
        let envelope = sensors.get(i).and_then(|(_, spectra)| spectra.as_ref()?.bands.get(band));
        let Some((envelope, modulation)) = envelope.zip(modulations.get_mut(i)) else { continue };
        parts = envelope.parts;
        let background = envelope.spectrum.background();
        let power = |k: usize| envelope.spectrum.line(k as f64 * carrier_hz, AMPLITUDE_BINS, &background)[0];
        let powers: Vec<f64> = (1..=HARMONIC_COUNT).map(power).collect();
        *modulation = powers.iter().sum::<f64>().sqrt();
        let greatest = powers.iter().copied().fold(0.0, f64::max);
        let strongest = strongest_line(&envelope.spectrum, &background, turn_hz).max(f64::MIN_POSITIVE);
        of_strongest += (greatest / strongest).sqrt() / own.len() as f64;
    }
    // A family of any order has no slip. Most hypotheses need no comparison.
    let (mut share, mut is_strongest) = (0.0, false);
    if evidence >= LEAST_EVIDENCE {
        let strongest = strongest_family(lines, turn_hz);
        share = (evidence + handicap + unlikely) / strongest.evidence.max(f64::MIN_POSITIVE);
        is_strongest = is_harmonic(strongest.carrier_hz / carrier_hz, SAME_BINS * lines.bin_hz / carrier_hz);
    }
    // Several signals are averaged as the blocks of a long one are.
    let is_averaged = turn_hz / lines.bin_hz > WHOLE * BLOCK_TURNS
        || own
            .iter()
            .any(|&i| sensors.get(i).is_some_and(|(_, s)| s.as_ref().is_some_and(SensorSpectra::is_of_several)));
    let sensors = own.len();
    Hypothesis {
        pattern,
        bearing,
        band,
        parts,
        is_averaged,
        evidence,
        share,
        is_strongest,
        of_strongest,
        carrier_hz,
        turn_hz,
        modulations,
        sensors,
    }
}
