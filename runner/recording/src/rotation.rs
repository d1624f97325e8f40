//! Shaft angle, speed and acceleration of the rows of a recording.
//!
//! - **Keyphasor**: the first pulse is angle 0, on a toothed wheel with a gap the first one after the gap. A pulse begins where
//!   the signal, drawn straight from sample to sample or through the samples within the hysteresis, passes half way between its
//!   two levels, which are followed; the rarer level is the pulse. A count of pulses gives the same instants. A pulse recorded as a step is
//!   known to half a sample only, so the angle follows parabolas through up to 11 pulses, blended from pulse to
//!   pulse; where those cannot follow the shaft, through fewer. A missing pulse is interpolated and a spurious one is left
//!   out; both are counted as flaws. A sample is delayed by up to 6 pulses, by 11 at the start.
//! - **Speed column**: its integral from 0 by the trapezium rule.
//! - **Neither**: the closed form of the scene's speed, from angle 0 at the first sample.

mod count;
mod edges;
mod fit;
mod gap;
mod given;
mod keyphasor;
mod surplus;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
mod total;

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;

use self::given::{SceneSpeed, SpeedColumn};
use self::keyphasor::Keyphasor;
use self::total::Total;
use super::average::Average;
use super::flaws::FlawLedger;
use super::run_out::RunOut;
use super::status::SampleStatus;
use super::{Row, Sample};
use ballrace_base::printable::number;
use ballrace_scene::{Recording, RotationSource, Speed};

/// Largest number of samples that wait for a pulse or a speed.
const LONGEST_WAIT: usize = 4_000_000;

/// Ratio to the scene's fastest speed above which a speed reading is implausible.
pub(crate) const SPEED_MARGIN: f64 = 3.0;
/// Largest speed of any rolling bearing, rad/s: 1e6 rpm.
const FASTEST: f64 = 1.05e5;

/// Error returned when the shaft angle cannot be determined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RotationError {
    /// There is no pulse.
    #[error("column {column}: no keyphasor pulses in {samples} samples: {}, expected two levels that alternate once per pulse", stays(*.low, *.high))]
    NoPulse {
        /// Column of the keyphasor.
        column: String,
        /// Number of samples.
        samples: usize,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
    /// One pulse gives no speed.
    #[error(
        "column {column}: one keyphasor pulse only, at line {line}: the recording is shorter than a turn, expected two pulses or more"
    )]
    OnePulse {
        /// Column of the keyphasor.
        column: String,
        /// Line of the pulse.
        line: u64,
    },
    /// A threshold of the scene that the signal does not pass.
    #[error("column {column}: no keyphasor pulses in {samples} samples: {}, expected crossings of the threshold {threshold} by the hysteresis", stays(*.low, *.high))]
    NoCrossing {
        /// Column of the keyphasor.
        column: String,
        /// Number of samples.
        samples: usize,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
        /// The threshold, in the same unit.
        threshold: f64,
    },
    /// A count that does not rise.
    #[error("column {column}: the count of pulses stays at {low} for {samples} samples, expected a count that rises")]
    NoCount {
        /// Column of the keyphasor.
        column: String,
        /// Number of samples.
        samples: usize,
        /// The count.
        low: f64,
    },
    /// Instants outside the recording.
    #[error(
        "column {column}: no instant of a pulse within {samples} samples, expected instants in the time of the samples: from 0 at the first \
         one, or in that of `time`"
    )]
    NoInstant {
        /// Column of the keyphasor.
        column: String,
        /// Number of samples.
        samples: usize,
    },
    /// A count of pulses that is no whole number.
    #[error("column {column}: line {line}: no count of pulses: {found}, expected whole numbers with kind = \"count\"")]
    NotACount {
        /// Column of the keyphasor.
        column: String,
        /// Line of the reading.
        line: u64,
        /// The reading.
        found: f64,
    },
    /// A count of pulses that falls.
    #[error(
        "column {column}: line {line}: the count of pulses falls from {from} to {to}, expected a count that rises or wraps at 2^16 or 2^32"
    )]
    CountFalls {
        /// Column of the keyphasor.
        column: String,
        /// Line of the lower count.
        line: u64,
        /// Count before.
        from: f64,
        /// The lower count.
        to: f64,
    },
    /// A toothed wheel without the gap of the scene.
    #[error("column {column}: no gap of {gap} intervals in {pulses} pulses{}, expected one in each turn (missing = {})", other_gap(*.other), gap - 1)]
    NoGap {
        /// Column of the keyphasor.
        column: String,
        /// Pulses so far.
        pulses: u64,
        /// Intervals between teeth in the gap of the scene.
        gap: u64,
        /// Intervals in another gap.
        other: Option<u64>,
    },
    /// A toothed wheel with another number of teeth.
    #[error(
        "column {column}: {found} pulses from gap to gap, expected {expected}; the wheel has pulses_per_turn = {pulses_per_turn}"
    )]
    GapSpacing {
        /// Column of the keyphasor.
        column: String,
        /// Pulses from gap to gap.
        found: u64,
        /// Pulses from gap to gap by the scene.
        expected: u64,
        /// Teeth and absent teeth of the wheel.
        pulses_per_turn: u64,
    },
    /// The pulses end.
    #[error(
        "column {column}: no keyphasor pulse in {samples} samples after line {line} ({time:.6} s): the shaft is at standstill or the keyphasor is dead"
    )]
    Standstill {
        /// Column of the keyphasor.
        column: String,
        /// Samples without a pulse.
        samples: u64,
        /// Line of the last pulse.
        line: u64,
        /// Time of the last pulse, s.
        time: f64,
    },
    /// A speed column without a number.
    #[error("column {column}: no speed in {samples} samples from the start, expected a number")]
    NoSpeed {
        /// Column of the speed.
        column: String,
        /// Number of samples.
        samples: usize,
    },
    /// A speed column without a speed that the scene's machine can have.
    #[error(
        "column {column}: no plausible speed in {rejected} readings: first {:.3e} rpm, expected speeds within {:.0} rpm, {SPEED_MARGIN} times the scene's fastest", found * 60.0 / TAU, fastest * 60.0 / TAU
    )]
    ImplausibleSpeed {
        /// Column of the speed.
        column: String,
        /// Readings beyond the limit.
        rejected: u64,
        /// The first of them, rad/s.
        found: f64,
        /// The limit, rad/s.
        fastest: f64,
    },
}

fn stays(low: f64, high: f64) -> String {
    if low <= high {
        format!("it stays between {} and {}", number(low), number(high))
    } else {
        String::from("it has no value")
    }
}

fn other_gap(intervals: Option<u64>) -> String {
    intervals.map_or_else(String::new, |found| format!(", but one of {found} intervals"))
}

/// Maximum number of rows whose memory is kept for reuse.
const SPARE_ROWS: usize = 1 << 12;

/// Tracker of the shaft angle. [`push`](Self::push) adds a row; [`pop`](Self::pop) returns samples in the same order as soon
/// as their angle is known, the last ones after [`finish`](Self::finish).
pub struct Tracker {
    rotation: RotationSource,
    source: Source,
    output: Output,
    average: Average,
    /// Run-out to subtract.
    run_out: Option<Arc<RunOut>>,
    ended: bool,
    spare: Vec<Row>,
}

enum Source {
    Keyphasor(Box<Keyphasor>),
    Column(Box<SpeedColumn>),
    Scene(SceneSpeed),
}

/// Motion of the shaft at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Motion {
    total: Total,
    speed: f64,
    acceleration: f64,
}

/// Finished samples, and the statistics of all.
#[derive(Default)]
struct Output {
    ready: VecDeque<Sample>,
    ledger: FlawLedger,
    count: u64,
    sum: f64,
    range: Option<(f64, f64)>,
}

impl Output {
    /// Adds a sample at a measured angle.
    fn deliver(&mut self, row: Row, motion: Motion) {
        self.deliver_with(row, motion, SampleStatus::default());
    }

    /// Adds a sample whose angle has these flags.
    fn deliver_with(&mut self, row: Row, motion: Motion, status: SampleStatus) {
        let Motion { total, speed, acceleration } = motion;
        self.count += 1;
        self.sum += speed;
        let (low, high) = self.range.unwrap_or((speed, speed));
        self.range = Some((low.min(speed), high.max(speed)));
        let (angle, revolution) = (total.angle(), total.revolution());
        self.ready.push_back(Sample { row, angle, revolution, speed, acceleration, status });
    }
}

impl Tracker {
    /// Creates the tracker of a recording sampled at `rate`, Hz. A keyphasor does not measure the sense of rotation, which is
    /// that of the scene's `speed`.
    #[must_use]
    pub fn new(rotation: &RotationSource, rate: f64, speed: Speed) -> Self {
        let source = match rotation {
            RotationSource::Keyphasor { column, pulses_per_turn, missing, signal } => {
                let wheel = (*pulses_per_turn, *missing);
                Source::Keyphasor(Box::new(Keyphasor::new(column, wheel, signal, rate, is_reversed(speed))))
            }
            RotationSource::SpeedColumn { column, .. } => Source::Column(Box::new(SpeedColumn::new(column, rate))),
            RotationSource::Synchronous => Source::Column(Box::new(SpeedColumn::synchronous(rate, is_reversed(speed)))),
            RotationSource::Scene => Source::Scene(SceneSpeed::new(speed, rate)),
        };
        let rotation = rotation.clone();
        Self {
            rotation,
            source,
            output: Output::default(),
            average: Average::new(1, rate),
            run_out: None,
            ended: false,
            spare: Vec::new(),
        }
    }

    /// Creates the tracker of `recording`, with its averaging.
    #[must_use]
    pub fn of(recording: &Recording, rate: f64, speed: Speed) -> Self {
        let average = Average::new(recording.average, rate);
        let mut tracker = Self { average, ..Self::new(&recording.rotation, rate, speed) };
        if let Source::Column(column) = &mut tracker.source {
            column.fastest = largest_speed(speed);
        }
        tracker
    }

    /// Subtracts a run-out from the readings of every sample, before they are averaged.
    #[must_use]
    pub fn with_run_out(mut self, run_out: Option<Arc<RunOut>>) -> Self {
        self.run_out = run_out;
        self
    }

    /// Limits the number of samples that wait for a pulse; 1024 or more.
    #[must_use]
    pub fn waiting_at_most(mut self, samples: usize) -> Self {
        if let Source::Keyphasor(keyphasor) = &mut self.source {
            keyphasor.longest_wait = samples.clamp(1024, LONGEST_WAIT);
        }
        self
    }

    /// Returns an empty row to read into, with the memory of a recycled one where there is one.
    #[must_use]
    pub fn blank(&mut self) -> Row {
        self.spare.pop().unwrap_or_default()
    }

    /// Recycles the memory of a row. After a backlog the memory of most of its rows is freed.
    pub fn recycle(&mut self, row: Row) {
        if self.spare.len() < SPARE_ROWS {
            self.spare.push(row);
        }
    }

    /// Adds the next row. The indices of rows rise.
    ///
    /// # Errors
    /// No pulse, or none any more, within 4 million samples or 20 turns' time; no speed within 4 million samples.
    pub fn push(&mut self, row: Row) -> Result<(), RotationError> {
        match &mut self.source {
            Source::Keyphasor(keyphasor) => keyphasor.push(row, &mut self.output),
            Source::Column(column) => column.push(row, &mut self.output),
            Source::Scene(scene) => {
                let motion = scene.motion(row.index);
                self.output.deliver(row, motion);
                Ok(())
            }
        }
    }

    /// Ends the recording: computes the angle of every sample that still waits.
    ///
    /// # Errors
    /// Fewer than two pulses, or no speed, in the whole recording.
    pub fn finish(&mut self) -> Result<(), RotationError> {
        self.ended = true;
        match &mut self.source {
            Source::Keyphasor(keyphasor) => keyphasor.finish(&mut self.output),
            Source::Column(column) => column.finish(&mut self.output),
            Source::Scene(_) => Ok(()),
        }
    }

    /// Removes and returns the next row that waits for an angle, after an error of [`push`](Self::push) or [`finish`](Self::finish).
    pub fn abandon(&mut self) -> Option<Row> {
        match &mut self.source {
            Source::Keyphasor(keyphasor) => keyphasor.waiting.pop_front(),
            Source::Column(column) => column.waiting.pop_front(),
            Source::Scene(_) => None,
        }
    }

    /// Returns the next sample whose angle is known.
    pub fn pop(&mut self) -> Option<Sample> {
        while let Some(mut sample) = self.output.ready.pop_front() {
            if let Some(run_out) = &self.run_out {
                run_out.subtract(sample.angle, &mut sample.row.probes);
            }
            let (done, spare) = self.average.take(sample);
            self.spare.extend(spare);
            if done.is_some() {
                return done;
            }
        }
        if self.ended { self.average.close() } else { None }
    }

    /// Returns the number of measured keyphasor pulses so far, without spurious ones; 0 without a keyphasor.
    #[must_use]
    pub fn pulses(&self) -> u64 {
        match &self.source {
            Source::Keyphasor(keyphasor) => keyphasor.counted(),
            Source::Column(_) | Source::Scene(_) => 0,
        }
    }

    /// Returns how the pulses of a keyphasor are found: threshold, hysteresis and slope of a signal, the width of a count, or instants; none
    /// without a keyphasor or before its levels are known.
    fn detection(&self) -> Option<String> {
        let Source::Keyphasor(keyphasor) = &self.source else { return None };
        if keyphasor.has_instants() {
            return Some("their instants".to_owned());
        }
        let used = keyphasor.threshold().map(|used| used.to_string());
        used.or_else(|| Some(format!("a count that wraps at 2^{}", keyphasor.count_bits()?)))
    }

    /// Describes the source of the shaft angle.
    #[must_use]
    pub fn source(&self) -> String {
        match &self.rotation {
            RotationSource::Keyphasor { column, pulses_per_turn, missing, .. } => {
                let missing = if *missing > 0 { format!(" with {missing} missing") } else { String::new() };
                let found = self.detection().map_or_else(String::new, |found| format!("; {found}"));
                let pulses = self.pulses();
                format!(
                    "keyphasor in column {column}, {pulses} pulses, {pulses_per_turn} per revolution{missing}{found}"
                )
            }
            RotationSource::SpeedColumn { column, .. } => {
                format!("speed in column {column}, angle 0 at the first sample")
            }
            RotationSource::Synchronous => "samples synchronous with the shaft, angle 0 at the first sample".to_owned(),
            RotationSource::Scene => "the scene's shaft speed, angle 0 at the first sample".to_owned(),
        }
    }

    /// Returns the mean speed over the delivered samples, rad/s; `None` before the first.
    #[must_use]
    pub fn mean_speed(&self) -> Option<f64> {
        (self.output.count > 0).then(|| self.output.sum / self.output.count as f64)
    }

    /// Returns the lowest speed over the delivered samples, rad/s.
    #[must_use]
    pub fn min_speed(&self) -> Option<f64> {
        self.output.range.map(|range| range.0)
    }

    /// Returns the highest speed over the delivered samples, rad/s.
    #[must_use]
    pub fn max_speed(&self) -> Option<f64> {
        self.output.range.map(|range| range.1)
    }

    /// Returns the flaws of the keyphasor or the speed column so far, such as missing and spurious pulses.
    #[must_use]
    pub const fn flaws(&self) -> &FlawLedger {
        &self.output.ledger
    }
}

/// Returns the largest plausible magnitude of a reading of a speed column, rad/s: [`SPEED_MARGIN`] times the scene's fastest
/// speed, or [`FASTEST`] where the scene's shaft stands still.
fn largest_speed(speed: Speed) -> f64 {
    let (slow, fast) = speed.range();
    let scene = slow.abs().max(fast.abs());
    if scene > 0.0 { SPEED_MARGIN * scene } else { FASTEST }
}

/// Returns true where the shaft turns about -Z for the most part.
fn is_reversed(speed: Speed) -> bool {
    match speed {
        Speed::Constant(speed) => speed < 0.0,
        Speed::Ramp { from, to, .. } => from + to < 0.0,
        Speed::Fluctuating { mean, .. } => mean < 0.0,
    }
}
