//! Diagnosis from envelope spectra: the component of the bearing to which the lines belong.

use super::envelope::{BandEnvelope, Line, Rotation, Transforms, envelopes};
use super::picture;
use super::suspect::Suspect;
use ballrace_outcome::baseline::{Baseline, BaselineSensor};
use ballrace_outcome::{
    Diagnosis, EnvelopeSpectrum, EvidenceSource, FaultFigures, FaultKind, FaultParameters, LineLevel, VibrationLine,
};
use ballrace_scene::Sensor;

/// Largest slip against pure rolling in either direction, and number of steps of its search.
const SLIP: f64 = 0.015;
const SLIP_STEPS: i32 = 6;
/// Number of harmonics of a line that are evaluated.
const HARMONICS: usize = 3;
/// Smallest level of a line, and of all its harmonics together, dB.
const MIN_DB: f64 = 12.0;
const MIN_TOGETHER_DB: f64 = 28.0;
/// Level to which each harmonic is limited in the sum, dB.
const MAX_DB: f64 = 30.0;
/// Smallest modulation of a band.
const MIN_MODULATION: f64 = 0.25;
/// Smallest growth of a line against the baseline, dB.
const MIN_GROWTH_DB: f64 = 6.0;
/// Lower limit of the bands over the highest line: below it the lines are motion and not impacts.
const LOWEST: f64 = 3.0;
/// Smallest score of a family over that of the strongest.
const MIN_OF_STRONGEST: f64 = 0.7;

/// Components whose lines are looked for.
const KINDS: [FaultKind; 4] = [FaultKind::OuterRace, FaultKind::InnerRace, FaultKind::Element, FaultKind::Cage];

/// One part of one bearing.
#[derive(Clone, Copy)]
struct Family {
    kind: FaultKind,
    bearing: usize,
    order: f64,
}

/// A family's best band.
#[derive(Clone)]
struct Found {
    family: Family,
    lines: [Line; HARMONICS],
    band: [f64; 2],
    score: f64,
}

impl Found {
    /// Returns the frequency of the line, Hz, from its highest significant harmonic, which resolves it best.
    fn frequency(&self) -> f64 {
        let mut significant = self.lines.iter().enumerate().filter(|(_, l)| l.level_db > MIN_DB);
        significant.next_back().map_or(self.lines[0].frequency, |(k, l)| l.frequency / (k + 1) as f64)
    }
}

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
}

impl FaultDetector<'_> {
    /// Returns the diagnoses of all sensors, strongest first, and the baseline and the figure of each sensor.
    pub fn all<'s>(
        &self,
        signals: impl Iterator<Item = (&'s Sensor, &'s [f64])>,
    ) -> (Vec<Diagnosis>, Vec<BaselineSensor>, Vec<EnvelopeSpectrum>) {
        let mut transforms = Transforms::default();
        self.of_bands(signals.map(|(sensor, signal)| (sensor, self.bands(signal, &mut transforms))))
    }

    /// Returns the diagnoses from the envelopes of all bands of each sensor, as [`all`](Self::all).
    pub(crate) fn of_bands<'s>(
        &self,
        sensors: impl Iterator<Item = (&'s Sensor, Vec<BandEnvelope>)>,
    ) -> (Vec<Diagnosis>, Vec<BaselineSensor>, Vec<EnvelopeSpectrum>) {
        let (mut diagnoses, mut learned, mut drawn): (Vec<(f64, Diagnosis)>, _, _) = (vec![], vec![], vec![]);
        for (i, (sensor, bands)) in sensors.enumerate() {
            let found = self.sensor(sensor, &bands);
            let modulations = found.iter().map(|f| f.as_ref().map_or(0.0, |f| f.lines[0].modulation)).collect();
            learned.push(BaselineSensor { name: sensor.column.clone(), modulations });
            let evaluated = |(k, f): (usize, &Option<Found>)| {
                let found = f.as_ref()?;
                self.diagnosis(found, sensor, (i, k)).map(|(score, diagnosis)| (score, diagnosis, found.band))
            };
            let judged: Vec<(f64, Diagnosis, [f64; 2])> = found.iter().enumerate().filter_map(evaluated).collect();
            let strongest = judged.iter().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, _, band)| *band);
            let measured: Vec<&Suspect> = self.measured_by(sensor).collect();
            drawn.extend(picture::envelope(
                sensor,
                &measured,
                [self.rotation.turn_hz, self.range()],
                &bands,
                strongest,
            ));
            diagnoses.extend(judged.into_iter().map(|(score, diagnosis, _)| (score, diagnosis)));
        }
        diagnoses.sort_by(|a, b| b.0.total_cmp(&a.0));
        let strongest = diagnoses.first().map_or(0.0, |f| f.0);
        diagnoses.retain(|(score, _)| *score >= MIN_OF_STRONGEST * strongest);
        let mut distinct: Vec<Diagnosis> = vec![];
        for (_, diagnosis) in diagnoses {
            if !distinct.iter().any(|f| f.kind == diagnosis.kind && f.bearing == diagnosis.bearing) {
                distinct.push(diagnosis);
            }
        }
        (distinct, learned, drawn)
    }

    fn families(&self) -> Vec<Family> {
        let of = |(bearing, s): (usize, &Suspect)| KINDS.map(|kind| Family { kind, bearing, order: s.order(kind) });
        self.suspects.iter().enumerate().flat_map(of).collect()
    }

    /// Returns the envelopes of all bands that are high and wide enough.
    pub fn bands(&self, signal: &[f64], transforms: &mut Transforms) -> Vec<BandEnvelope> {
        let fastest = self.rotation.fastest_hz;
        let (lowest, highest) = (LOWEST * self.highest_order(), self.highest_line());
        envelopes(signal, self.rate, self.rotation, [lowest * fastest, highest * fastest], transforms)
    }

    /// Returns the level of each line that the sensor measures, in the band where that is the greatest.
    pub fn levels(&self, sensor: &Sensor, bands: &[BandEnvelope]) -> Vec<LineLevel> {
        let level = |found: Found| LineLevel {
            bearing: self.suspects[found.family.bearing].name.clone(),
            component: found.family.kind,
            level_db: found.score / HARMONICS as f64,
        };
        self.sensor(sensor, bands).into_iter().flatten().map(level).collect()
    }

    /// Returns the highest frequency at which lines are searched, Hz.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.highest_line() * self.rotation.turn_hz
    }

    /// Returns the highest order of a line that is looked for, harmonics included.
    #[must_use]
    pub fn highest_line(&self) -> f64 {
        (HARMONICS as f64 + 0.5) * self.highest_order()
    }

    fn highest_order(&self) -> f64 {
        self.families().iter().map(|f| f.order).fold(0.0, f64::max)
    }

    /// Returns the smallest sampling rate that has a band with lines, Hz.
    #[must_use]
    pub(crate) fn least_rate(&self) -> f64 {
        // The upper half of the range up to Nyquist is the band that needs the least rate.
        4.0 * self.highest_line() * self.rotation.fastest_hz
    }

    /// Returns the bearings that a sensor measures.
    pub(crate) fn measured_by(&self, sensor: &Sensor) -> impl Iterator<Item = &Suspect> {
        self.suspects.iter().filter(|s| sensor.bearing.as_ref().is_none_or(|name| *name == s.name))
    }

    /// Returns the lines of each family in the band with the highest score; `None` for a family that the sensor does not measure
    /// or that no band contains.
    fn sensor(&self, sensor: &Sensor, all: &[BandEnvelope]) -> Vec<Option<Found>> {
        let families = self.families();
        let own = |f: &Family| sensor.bearing.as_ref().is_none_or(|name| *name == self.suspects[f.bearing].name);
        families.iter().map(|family| if own(family) { self.best(all, *family) } else { None }).collect()
    }

    fn best(&self, all: &[BandEnvelope], family: Family) -> Option<Found> {
        let found = all.iter().flat_map(|envelope| {
            (-SLIP_STEPS..=SLIP_STEPS).filter_map(move |i| {
                let slip = SLIP * f64::from(i) / f64::from(SLIP_STEPS);
                let frequency = family.order * self.rotation.turn_hz * (1.0 + slip);
                let mut lines = [Line::default(); HARMONICS];
                for (k, line) in lines.iter_mut().enumerate() {
                    *line = envelope.line((k + 1) as f64 * frequency)?;
                }
                let score = lines.iter().map(|l| l.level_db.clamp(0.0, MAX_DB)).sum();
                Some(Found { family, lines, band: envelope.band, score })
            })
        });
        found.max_by(|a, b| a.score.total_cmp(&b.score))
    }

    fn diagnosis(&self, found: &Found, sensor: &Sensor, (i, k): (usize, usize)) -> Option<(f64, Diagnosis)> {
        let line = found.lines[0];
        let usual = self.baseline.map(|b| b.modulation(i, k).max(1e-6));
        let growth = usual.map(|usual| 20.0 * (line.modulation / usual).log10());
        let stands_out = line.level_db >= MIN_DB && found.score >= MIN_TOGETHER_DB && line.modulation >= MIN_MODULATION;
        if !stands_out || growth.is_some_and(|g| g < MIN_GROWTH_DB) {
            return None;
        }
        let order = found.frequency() / self.rotation.turn_hz;
        let bearing = self.suspects[found.family.bearing].name.clone();
        let is_not_excluded = |s: &&Suspect| {
            let is_same_line = (order / s.order(found.family.kind) - 1.0).abs() <= SLIP;
            sensor.bearing.is_none() && s.name != bearing && is_same_line
        };
        let others: Vec<String> = self.suspects.iter().filter(is_not_excluded).map(|s| s.name.clone()).collect();
        let level_db = growth.unwrap_or(line.level_db);
        let over = if growth.is_some() { "the baseline" } else { "its surroundings" };
        let sentence = format!(
            "{} of {bearing}: the envelope of {:.0} to {:.0} Hz at {} has its line at {:.1} Hz, {order:.2} per turn, \
             {level_db:.0} dB above {over}, with {} of its multiples; the level in the band is modulated by {:.0} %.{}",
            component_name(found.family.kind),
            found.band[0],
            found.band[1],
            sensor.column,
            found.frequency(),
            found.lines[1..].iter().filter(|l| l.level_db > 6.0).count(),
            100.0 * line.modulation,
            if others.is_empty() {
                String::new()
            } else {
                format!(" The sensors do not exclude {}.", others.join(" or "))
            }
        );
        let confidence = (found.score / (HARMONICS as f64 * MAX_DB)).min(1.0).sqrt();
        let diagnosis = Diagnosis {
            kind: found.family.kind,
            bearing: Some(bearing),
            line_hz: found.frequency(),
            order,
            level_db,
            confidence,
            evidence: vec![EvidenceSource::Vibration],
            vibration: Some(VibrationLine {
                sensor: sensor.column.clone(),
                band_hz: found.band,
                line_hz: found.frequency(),
                order,
                modulation: line.modulation,
                level_db,
                not_excluded: others,
            }),
            sentence,
            parameters: FaultParameters::default(),
            lines: vec![],
            figures: FaultFigures::default(),
        };
        Some((found.score, diagnosis))
    }
}

fn component_name(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::OuterRace => "Outer race",
        FaultKind::InnerRace => "Inner race",
        FaultKind::Element => "A rolling element",
        _ => "Cage",
    }
}
