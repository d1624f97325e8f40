//! The recording of a site: the motion of the shaft without the errors of the readings that a machine does not explain.

use super::machine::Machine;
use super::measurement::{
    self, COEFFICIENTS, DRIFT, GAP, HARMONICS, Knowledge, ReadingBasis, ReadingError, harmonic, mains,
};
use super::motion::Motion;
use super::residual::site::{SiteKnowledge, divided, orders_of_bearing};
use super::residual::{Evidence, Weighting};
use super::{DiagnosisInput, Result};
use ballrace_outcome::{ProbeReadings, ReadingOutcome};
use ballrace_plant::probes;
use ballrace_scene::{Direction, Probe};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Rounds in which the errors are found: each evaluates the bearings at the motion without those found before.
const ROUNDS: usize = 5;
/// Largest change of what is subtracted as a gap at which the rounds end, m.
const CLOSE: f64 = 3e-8;
/// Standard deviation of a scene's unbalance over it, and of that of a baseline.
pub const UNBALANCE_ERROR: f64 = 0.3;
const UNBALANCE_LATER: f64 = 0.0;

/// Standard deviations of a gap between recordings beyond which the shaft may have moved.
const MOVED_GAPS: f64 = 2.0;

/// Standard deviations of an unmeasured reading from which its error is none of a probe.
const IMPLAUSIBLE: f64 = 5.0;

/// Distance of two lines from which a record tells them apart, over the inverse of its duration.
pub const RESOLUTION: f64 = 3.0;

/// Least drift over the record, and run-out that show a site, m, and the multiples of the shaft angle of which so many have it. The
/// first is also that of an unbalance.
const SHOWN_DRIFT: f64 = 2e-6;
const SHOWN_RUN_OUT: f64 = 0.15e-6;
const SHOWN_MULTIPLES: (RangeInclusive<usize>, usize) = (2..=8, 3);

/// Readings of a site with their errors.
#[derive(Clone)]
pub struct SiteRecording<'a> {
    input: DiagnosisInput<'a>,
    weighting: Arc<Weighting>,
    highest: f64,
    /// Motion by the readings.
    raw: Motion,
    /// What was known of the readings before.
    knowledge: Knowledge,
    known: SiteKnowledge<'a>,
    /// Standard deviation of the coefficients of each probe's error before the recording.
    deviations: Vec<ReadingError>,
    /// Errors known from the baseline.
    centre: Vec<ReadingError>,
    /// Errors beyond them.
    errors: Vec<ReadingError>,
    basis: Option<Arc<ReadingBasis>>,
    /// The first evidence of the record: the others differ in the displacement alone.
    first: Option<Arc<Evidence<'a>>>,
}

impl<'a> SiteRecording<'a> {
    pub fn new(input: DiagnosisInput<'a>, weighting: Arc<Weighting>, highest: f64, raw: Motion) -> Self {
        let learned = input.calibration.map(|calibration| calibration.readings.as_slice()).unwrap_or_default();
        let is_measured = input.scene.recording.as_ref().is_some_and(|recording| recording.run_out.is_some());
        let knowledge = match (learned.is_empty(), is_measured) {
            (false, _) => Knowledge::Baseline,
            (true, true) => Knowledge::SlowRoll,
            (true, false) => Knowledge::First,
        };
        let count = input.probes.len();
        let mut centre = vec![[0.0; COEFFICIENTS]; count];
        let known = if input.is_corrected { &[] } else { learned };
        for (centre, learned) in centre.iter_mut().zip(known) {
            centre[GAP] = learned.gap;
            for (order, parts) in (1..=HARMONICS).zip(&learned.run_out) {
                for (part, x) in parts.iter().enumerate() {
                    centre[harmonic(order, part)] = *x;
                }
            }
        }
        let mut errors = vec![[0.0; COEFFICIENTS]; count];
        if learned.is_empty() {
            // The rotor rests where its bearings carry the load.
            let rest = input.plant.pose(&input.plant.rest).to_array();
            let n = raw.len().max(1) as f64;
            let mean: [f64; 5] = std::array::from_fn(|i| raw.q.iter().map(|q| q.to_array()[i]).sum::<f64>() / n);
            for (error, probe) in errors.iter_mut().zip(input.probes) {
                let row = probes::row(probe);
                error[GAP] = (0..5).filter(|i| *i != 2).map(|i| row[i] * (mean[i] - rest[i])).sum();
            }
        }
        let deviations: Vec<ReadingError> =
            input.probes.iter().map(|probe| knowledge.deviations(probe.direction)).collect();
        let known = SiteKnowledge { deviations: deviations.clone(), learned };
        Self { input, weighting, highest, raw, knowledge, known, deviations, centre, errors, basis: None, first: None }
    }

    /// Returns true where no error of a reading is beyond what a probe and the surface of a shaft may have.
    pub fn is_plausible(&self) -> bool {
        let is_plausible = |(error, probe): (&ReadingError, &Probe)| {
            let usual = Knowledge::First.deviations(probe.direction);
            error.iter().zip(usual).all(|(x, deviation)| x.abs() < IMPLAUSIBLE * deviation)
        };
        self.errors.iter().zip(self.input.probes).all(is_plausible)
    }

    /// Returns true where the mean of a radial probe has moved against the baseline by more than gaps do.
    pub fn has_moved(&self) -> bool {
        let moved = |(error, probe): (&ReadingError, &Probe)| {
            probe.direction != Direction::Axial
                && error[GAP].abs() > MOVED_GAPS * self.knowledge.deviations(probe.direction)[GAP]
        };
        self.knowledge == Knowledge::Baseline && self.errors.iter().zip(self.input.probes).any(moved)
    }

    /// Returns true where neither a slow roll nor a baseline tells the run-out from the motion of the shaft.
    pub fn has_unknown_run_out(&self) -> bool {
        self.knowledge == Knowledge::First
    }

    /// Returns the recording for a machine, after the errors that the machine does not explain have been found; `None` if the rotor cannot be
    /// diagnosed. The next call must be [`Evidence::weight_for`].
    pub fn evidence(&mut self, machine: &Machine) -> Result<Option<Evidence<'a>>> {
        let unbalance = if self.known.learned.is_empty() { UNBALANCE_ERROR } else { UNBALANCE_LATER };
        for round in 0..ROUNDS {
            let Some((mut e, counting)) = self.without_errors()? else { return Ok(None) };
            self.first.get_or_insert_with(|| Arc::new(e.clone()));
            let basis = self.basis.get_or_insert_with(|| Arc::new(ReadingBasis::new(&e.transform, &self.raw))).clone();
            e.refer_to(machine)?;
            let [_, unknown] = divided(&self.errors, &self.known);
            let removed = sums(&counting, &unknown);
            self.known.deviations.clone_from(&self.deviations);
            for (deviations, error) in self.known.deviations.iter_mut().zip(&self.errors) {
                // A probe that drifts in the record has drifted before it.
                deviations[GAP] = deviations[GAP].hypot(error[DRIFT]);
            }
            let mut found = e.reading_errors(machine, &self.known, &basis, &removed, unbalance)?;
            // A hum beside a line of a bearing may be that line: it stays in the noise alone.
            let hidden = self.hidden_hums();
            found.iter_mut().for_each(|error| hidden.iter().for_each(|j| error[*j] = 0.0));
            self.errors = found;
            let [counting, unknown] = divided(&self.errors, &self.known);
            let next = sums(&counting, &unknown);
            let moved = next.iter().zip(&removed).map(|(new, old)| (new[GAP] - old[GAP]).abs()).fold(0.0, f64::max);
            if round > 0 && moved < CLOSE {
                break;
            }
        }
        let Some((mut e, counting)) = self.without_errors()? else { return Ok(None) };
        if let Some(basis) = &self.basis {
            e.set_site(&self.known, basis.clone(), &self.errors, &counting);
        }
        Ok(Some(e))
    }

    /// Returns the coefficients of the hums that lie within the resolution of the record beside a line that a bearing may have.
    fn hidden_hums(&self) -> Vec<usize> {
        let speed = self.raw.mean_speed().abs().max(f64::MIN_POSITIVE);
        let apart = RESOLUTION * TAU / (self.raw.len() as f64 * self.raw.period * speed);
        let is_hidden = |frequency: f64| {
            let order = TAU * frequency / speed;
            let lines = self.input.plant.bearings.iter().flat_map(orders_of_bearing);
            lines.into_iter().any(|(_, [low, high])| (low - apart..=high + apart).contains(&order))
        };
        mains().filter(|(frequency, _)| is_hidden(*frequency)).flat_map(|(_, j)| [j, j + 1]).collect()
    }

    /// Returns the recording without the errors of which nothing is known, but with those that count against their prior: a machine with a
    /// fault that moves the shaft is not to be evaluated at the position of the sound one. The next call must be
    /// [`Evidence::weight_for`].
    pub fn with_counting_errors(&self) -> Result<Option<Evidence<'a>>> {
        let [counting, unknown] = divided(&self.errors, &self.known);
        let none = vec![[0.0; COEFFICIENTS]; counting.len()];
        let Some(mut e) = self.without(&unknown)? else { return Ok(None) };
        if let Some(basis) = &self.basis {
            e.set_site(&self.known, basis.clone(), &self.errors, &none);
        }
        Ok(Some(e))
    }

    /// Returns the recording without the errors of the readings as they are known, with those that count against their prior.
    fn without_errors(&self) -> Result<Option<(Evidence<'a>, Vec<ReadingError>)>> {
        let [counting, unknown] = divided(&self.errors, &self.known);
        Ok(self.without(&sums(&counting, &unknown))?.map(|e| (e, counting)))
    }

    /// Returns the recording without the errors of the baseline and some beyond them.
    fn without(&self, errors: &[ReadingError]) -> Result<Option<Evidence<'a>>> {
        let mut motion = self.raw.clone();
        measurement::subtract(&mut motion, &self.weighting.solver, &sums(&self.centre, errors));
        if let Some(first) = &self.first {
            return Ok(Some(first.with_motion(motion)));
        }
        let DiagnosisInput { scene, plant, .. } = self.input;
        Evidence::new(scene, plant, motion, self.highest, self.weighting.clone())
    }

    /// Returns true where the readings have errors that no machine of the scene explains: a gap of at least so much, drift, or a
    /// run-out of several multiples of the shaft angle.
    pub fn shows_errors(&self, least_gap: f64) -> bool {
        self.errors.iter().any(|error| {
            let amplitude = |order: usize| error[harmonic(order, 0)].hypot(error[harmonic(order, 1)]);
            let (orders, count) = SHOWN_MULTIPLES;
            error[GAP].abs() > least_gap
                || error[DRIFT].abs() > SHOWN_DRIFT
                || orders.filter(|order| amplitude(*order) > SHOWN_RUN_OUT).count() >= count
        })
    }

    /// Returns the errors of the readings with those of the baseline, and how a sound machine moves: `lines` are those that its model leaves.
    pub fn readings(&self, lines: Vec<Vec<[f64; 2]>>, motion_rms: &[f64]) -> Vec<ProbeReadings> {
        let with = |(readings, (lines, motion_rms))| ProbeReadings { lines, motion_rms, ..readings };
        self.with_baseline(&self.errors)
            .into_iter()
            .zip(lines.into_iter().zip(motion_rms.iter().copied()))
            .map(with)
            .collect()
    }

    /// Returns the ratio of a motion at each probe to that of the sound machine, as far as it is known.
    pub fn growth(&self, motion_rms: &[f64]) -> Vec<f64> {
        let known = self.known.learned.iter().zip(motion_rms);
        known.map(|(learned, now)| if learned.motion_rms > 0.0 { now / learned.motion_rms } else { 0.0 }).collect()
    }

    /// Returns the same limited to what is plausible beside the baseline: beyond it, a fault may be the cause.
    pub fn plausible_readings(&self) -> Vec<ProbeReadings> {
        let [counting, unknown] = divided(&self.errors, &self.known);
        self.with_baseline(&sums(&counting, &unknown))
    }

    fn with_baseline(&self, errors: &[ReadingError]) -> Vec<ProbeReadings> {
        let probe = |p: usize| {
            let sum = |j: usize| self.centre[p][j] + errors[p][j];
            ProbeReadings {
                column: self.input.probes[p].column.clone(),
                gap: sum(GAP),
                run_out: (1..=HARMONICS).map(|order| [0, 1].map(|part| sum(harmonic(order, part)))).collect(),
                ..ProbeReadings::default()
            }
        };
        (0..errors.len()).map(probe).collect()
    }

    /// Returns the errors of the readings beyond those of the baseline, probe by probe.
    pub fn outcomes(&self) -> Vec<ReadingOutcome> {
        let probe = |(probe, error): (&Probe, &ReadingError)| {
            let amplitude = |j: usize| 1e6 * error[j].hypot(error[j + 1]);
            let hums = mains().map(|(frequency, j)| (frequency, amplitude(j)));
            let (hum_hz, hum_um) = hums.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
            let square: f64 = (1..=HARMONICS).map(|order| amplitude(harmonic(order, 0)).powi(2)).sum();
            ReadingOutcome {
                probe: probe.column.clone(),
                gap_um: 1e6 * error[GAP],
                drift_um: 1e6 * error[DRIFT],
                run_out_um: (0.5 * square).sqrt(),
                hum_um,
                hum_hz,
            }
        };
        self.input.probes.iter().zip(&self.errors).map(probe).collect()
    }
}

fn sums(a: &[ReadingError], b: &[ReadingError]) -> Vec<ReadingError> {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|j| a[j] + b[j])).collect()
}
