//! Measurement of the run-out of the shaft under each probe, from a recording of the slowly turning rotor.
//!
//! At slow speed the rotor does not move, and the readings are the run-out. Each whole revolution gives the harmonics of each probe
//! by least squares; those that repeat from revolution to revolution are the run-out. Their mean, the gap, is not part of it.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::error::RecordingError;
use super::rotation::{RotationError, Tracker};
use super::run_out::{Harmonics, ProbeRunOut, RunOut};
use super::{Reader, Row, Sample};
use ballrace_scene::{Recording, Scene, Speed};

/// Highest order. The tip of a probe, some millimetres wide, averages over finer errors of a surface of some hundred millimetres'
/// circumference.
const HIGHEST: usize = 32;
/// Least number of samples per revolution and harmonic.
const SAMPLES_PER_HARMONIC: usize = 8;
/// Least number of samples in a revolution.
const MIN_SAMPLES: usize = 64;
/// Least number of whole revolutions, from which the scatter of a harmonic is known.
const MIN_TURNS: usize = 4;
/// Largest number of revolutions that are used.
const MAX_TURNS: usize = 64;
/// Largest share of the machine's speed at which the rotor does not move: forces of unbalance are a hundredth there.
const SLOW: f64 = 0.1;
/// Standard errors by which a harmonic differs from 0: noise reaches that once in 200 of four revolutions.
const CLEAR: f64 = 4.0;

/// Error returned when a run-out cannot be determined.
#[derive(Debug, thiserror::Error)]
pub enum RunOutError {
    /// The recording cannot be read.
    #[error("recording.run_out: {0}")]
    Recording(RecordingError),
    /// The recording has no shaft angle.
    #[error("recording.run_out: {file}: {cause}")]
    Rotation {
        /// The recording.
        file: PathBuf,
        /// Reason. Not a `source`: the message contains it.
        cause: RotationError,
    },
    /// The shaft is fast enough to move.
    #[error("recording.run_out: {file}: shaft too fast: {found:.1} rpm, expected at most {most:.1} rpm, {} % of the scene's fastest speed", SLOW * 100.0)]
    Fast {
        /// The recording.
        file: PathBuf,
        /// Fastest revolution, rpm.
        found: f64,
        /// Largest speed, rpm.
        most: f64,
    },
    /// The recording is too short.
    #[error(
        "recording.run_out: {file}: too short: {found} whole revolutions with a reading of every probe, expected at least {MIN_TURNS}"
    )]
    Short {
        /// The recording.
        file: PathBuf,
        /// Whole revolutions.
        found: usize,
    },
    /// The sampling is too coarse.
    #[error("recording.run_out: {file}: too few samples: {found} in a revolution, expected at least {MIN_SAMPLES}")]
    Coarse {
        /// The recording.
        file: PathBuf,
        /// Samples in a revolution.
        found: usize,
    },
}

impl RunOutError {
    /// Returns true where the scene is wrong.
    #[must_use]
    pub const fn is_scene_fault(&self) -> bool {
        match self {
            Self::Recording(error) => error.is_scene_fault(),
            _ => true,
        }
    }
}

impl RunOut {
    /// Reads the run-out of a scene; none where it names none.
    ///
    /// # Errors
    /// A recording that cannot be read, has no shaft angle, is too fast, too short or too coarse.
    pub fn of(scene: &Scene) -> Result<Option<Arc<Self>>, RunOutError> {
        let Some(recording) = &scene.recording else { return Ok(None) };
        let Some(file) = &recording.run_out else { return Ok(None) };
        let slow = Recording { file: file.clone(), run_out: None, average: 1, ..recording.clone() };
        let reader = Reader::open(file, &slow).map_err(RunOutError::Recording)?;
        Self::measure(reader, &slow, scene.shaft.speed).map(Arc::new).map(Some)
    }

    /// Determines the run-out from a slow-roll recording; `speed` is that of the machine.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn measure(mut reader: Reader<'_>, recording: &Recording, speed: Speed) -> Result<Self, RunOutError> {
        let file = recording.file.clone();
        let mut tracker = Tracker::of(recording, reader.rate(), speed);
        let mut turns = Revolutions::new(recording.probes.len());
        let rotation = |cause| RunOutError::Rotation { file: file.clone(), cause };
        let mut row = Row::default();
        let mut goes_on = true;
        while goes_on && turns.done.len() < MAX_TURNS {
            goes_on = reader.next_row(&mut row).map_err(RunOutError::Recording)?;
            if goes_on {
                let next = tracker.blank();
                tracker.push(std::mem::replace(&mut row, next)).map_err(rotation)?;
            } else {
                tracker.finish().map_err(rotation)?;
            }
            while let Some(sample) = tracker.pop() {
                turns.add(sample).map_err(|found| RunOutError::Coarse { file: file.clone(), found })?;
            }
        }
        let found = turns.done.len();
        if found < MIN_TURNS {
            return Err(RunOutError::Short { file, found });
        }
        let (low, high) = speed.range();
        let to_rpm = 60.0 / TAU;
        let most = SLOW * low.abs().max(high.abs()) * to_rpm;
        let fastest = turns.done.iter().map(|turn| turn.speed.abs()).fold(0.0, f64::max) * to_rpm;
        if fastest > most {
            return Err(RunOutError::Fast { file, found: fastest, most });
        }
        let speed_rpm = turns.done.iter().map(|turn| turn.speed.abs()).sum::<f64>() / found as f64 * to_rpm;
        let probe = |(i, probe): (usize, &ballrace_scene::Probe)| ProbeRunOut {
            column: probe.column.clone(),
            gap: 0.0,
            harmonics: turns.repeated(i),
        };
        let probes: Vec<ProbeRunOut> = recording.probes.iter().enumerate().map(probe).collect();
        let each: Vec<String> =
            probes.iter().map(|probe| format!("{} {:.3} um", probe.column, probe.rms() * 1e6)).collect();
        let note = format!(
            "The run-out in {}, {found} revolutions at {speed_rpm:.1} rpm, is subtracted from the readings; rms: {}.",
            file.display(),
            each.join(", ")
        );
        Ok(Self { probes, notes: vec![note] })
    }
}

/// Harmonics of one revolution.
struct Revolution {
    /// Mean speed, rad/s.
    speed: f64,
    /// Its number in the recording.
    number: i64,
    /// Mean of each probe, m.
    means: Vec<f64>,
    /// By probe, m.
    harmonics: Vec<Harmonics>,
}

/// Whole revolutions of a recording.
struct Revolutions {
    probes: usize,
    /// Number of the revolution in progress; the first one is not whole.
    number: Option<i64>,
    is_whole: bool,
    samples: Vec<Sample>,
    orders: usize,
    done: Vec<Revolution>,
}

impl Revolutions {
    const fn new(probes: usize) -> Self {
        Self { probes, number: None, is_whole: false, samples: vec![], orders: 0, done: vec![] }
    }

    /// Adds a sample; returns the samples of a revolution where they are too few.
    fn add(&mut self, sample: Sample) -> Result<(), usize> {
        if self.number != Some(sample.revolution) {
            let follows = self.number.is_some_and(|number| (sample.revolution - number).abs() == 1);
            if self.is_whole && follows {
                self.close()?;
            }
            self.samples.clear();
            self.is_whole = follows;
            self.number = Some(sample.revolution);
        }
        self.samples.push(sample);
        Ok(())
    }

    /// Evaluates the samples of a whole revolution; one with missing readings is omitted.
    fn close(&mut self) -> Result<(), usize> {
        let count = self.samples.len();
        if count < MIN_SAMPLES {
            return Err(count);
        }
        if self.samples.iter().any(|sample| sample.row.probes.iter().any(|reading| !reading.is_finite())) {
            return Ok(());
        }
        if self.orders == 0 {
            self.orders = (count / SAMPLES_PER_HARMONIC).min(HIGHEST);
        }
        let gaps = self.samples.windows(2).map(|pair| pair[1].row.index - pair[0].row.index);
        if gaps.max().is_some_and(|gap| gap > 1) || count < 4 * self.orders {
            return Ok(());
        }
        if let (Some((means, harmonics)), Some(number)) = (self.fit(), self.number) {
            let speed = self.samples.iter().map(|sample| sample.speed).sum::<f64>() / count as f64;
            self.done.push(Revolution { speed, number, means, harmonics });
        }
        Ok(())
    }

    /// Returns mean and harmonics of the samples of each probe by least squares.
    fn fit(&self) -> Option<(Vec<f64>, Vec<Harmonics>)> {
        let size = 2 * self.orders + 1;
        let mut normal = DMatrix::zeros(size, size);
        let mut right = DMatrix::zeros(size, self.probes);
        let mut terms = DVector::zeros(size);
        for sample in &self.samples {
            let (sine, cosine) = sample.angle.radians().sin_cos();
            let (mut c, mut s) = (cosine, sine);
            terms[0] = 1.0;
            for order in 0..self.orders {
                (terms[2 * order + 1], terms[2 * order + 2]) = (c, s);
                (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
            }
            normal.syger(1.0, &terms, &terms, 1.0);
            for (i, reading) in sample.row.probes.iter().enumerate().take(self.probes) {
                right.column_mut(i).axpy(*reading, &terms, 1.0);
            }
        }
        let solved = normal.cholesky()?.solve(&right);
        let of = |i: usize| (0..self.orders).map(|k| [solved[(2 * k + 1, i)], solved[(2 * k + 2, i)]]).collect();
        Some((0..self.probes).map(|i| (solved[(0, i)], of(i))).unzip())
    }

    /// Returns the drift of the mean of probe `i` in a revolution, m per turn of the angle, from those beside it.
    fn drift(&self, i: usize, turn: usize) -> f64 {
        let beside = [turn.saturating_sub(1), turn + 1].map(|other| other.min(self.done.len().saturating_sub(1)));
        let [Some(from), Some(to)] = beside.map(|other| self.done.get(other)) else { return 0.0 };
        let mean = |of: &Revolution| of.means.get(i).copied().unwrap_or_default();
        let turns = (to.number - from.number) as f64;
        if turns == 0.0 { 0.0 } else { (mean(to) - mean(from)) / turns }
    }

    /// Returns the mean harmonics of probe `i` up to the last one that repeats; those between that do not are 0.
    fn repeated(&self, i: usize) -> Harmonics {
        let count = self.done.len() as f64;
        let drifts: Vec<f64> = (0..self.done.len()).map(|turn| self.drift(i, turn)).collect();
        let mean = |order: usize| {
            let one = |(turn, drift): (&Revolution, &f64)| {
                let [a, b] = turn.harmonics.get(i)?.get(order)?;
                // A ramp by d in a turn has the harmonics -d / (pi h) sin(h angle).
                Some([*a, b + drift / (PI * (order + 1) as f64)])
            };
            let all = || self.done.iter().zip(&drifts).filter_map(one);
            let [a, b] = all().fold([0.0; 2], |[a, b], [c, d]| [a + c / count, b + d / count]);
            let squares: f64 = all().map(|[c, d]| (c - a).powi(2) + (d - b).powi(2)).sum();
            let error = squares / (count * (count - 1.0));
            if a * a + b * b > CLEAR * CLEAR * error { [a, b] } else { [0.0; 2] }
        };
        let mut harmonics: Harmonics = (0..self.orders).map(mean).collect();
        while harmonics.last() == Some(&[0.0; 2]) {
            harmonics.pop();
        }
        harmonics
    }
}
