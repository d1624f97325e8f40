//! Shaft angle from a keyphasor: pulses are checked, counted, smoothed, and samples placed between them.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::count::Counter;
use super::edges::{Edges, Instant, Levels, UsedThreshold, range};
use super::fit::{Fit, Progress, Pulse, SIDE};
use super::gap::{Gap, Interval};
use super::surplus::SurplusPulses;
use super::total::Total;
use super::{LONGEST_WAIT, Motion, Output, RotationError};
use crate::Row;
use crate::flaws::{Flaw, Position};
use crate::status::SampleStatus;
use ballrace_scene::{KeyphasorSignal, PulseDetection};

/// Number of samples before the first search for the levels; it is repeated each time their number has grown by a quarter.
const FIRST_LOOK: usize = 1024;

/// Number of intervals without a pulse after which the shaft is at standstill.
const STANDSTILL: f64 = 20.0;

/// Number of intervals without a pulse after which the signal may have left its levels, as after a step of the gap; the levels are
/// looked for again each time that number has grown by a half.
const LEFT: f64 = 6.0;

/// Number of intervals after the last pulse of a recording beyond which the keyphasor counts as failed.
const DEAD: f64 = 2.5;

/// An interval this much shorter than expected ends in a pulse too many: after two pulses, when a shaft that
/// starts from rest may be at 0.41, and when the trend is known.
const TOO_SHORT: (f64, f64) = (0.4, 0.6);

/// Largest difference of an interval from a whole multiple of the expected one for which missed pulses are counted, in intervals.
const WHOLE_TOLERANCE: f64 = 0.2;

/// Excess of the second interval of all over the first, in samples and in parts of the first, from which the first pulse may be no mark: more
/// than two edges are off by sampling. Where it is none, the third interval differs from the second by less than a part of that excess.
const FIRST_SHORT: (f64, f64) = (2.5, 0.03);
const THIRD_EVEN: f64 = 0.25;

/// Largest relative difference of the second interval of all from one between teeth where the first was over the gap of the wheel.
const GAP_FIRST: f64 = 0.3;

/// Largest number of pulses whose trend predicts the next one.
const TREND: usize = 6;

/// Samples waiting for their angle, and the pulses that give it.
pub(super) struct Keyphasor {
    column: String,
    pulses_per_turn: u32,
    /// Sampling rate, Hz.
    rate: f64,
    reversed: bool,
    /// Most samples that wait.
    pub(super) longest_wait: usize,
    /// Rows that wait for their angle.
    pub(super) waiting: VecDeque<Row>,
    next_look: usize,
    detector: Detector,
    /// The gap of a toothed wheel.
    gap: Option<Gap>,
    /// Up to `2 * SIDE` before the one at `left`, and all since.
    pulses: VecDeque<Pulse>,
    /// The pulse before the first sample that waits (after it, at the start).
    left: usize,
    left_fit: Option<Fit>,
    counted: u64,
    /// Samples with a reading since the last pulse.
    quiet: u64,
    /// Intervals without a pulse after which the levels are looked for again.
    patience: f64,
    last_pulse: Position,
    /// The third pulse of all where it is not known yet whether the first one is a mark.
    third: Option<(Instant, Position)>,
    /// The first pulse of all.
    first_pulse: Position,
    last_reading: Option<u64>,
    /// Sample in the middle of a signal loss since the last pulse that was longer than the interval of pulses.
    lost: Option<u64>,
    surplus: SurplusPulses,
}

/// Finder of pulses in the readings.
enum Detector {
    /// By two levels, which are known after the first samples.
    Pulses(PulseDetection, Option<Edges>),
    /// By their count.
    Count(Counter),
    /// By their instants, this number of pulses apart: a reading is the number of samples since the last instant, where that comes after the
    /// sample before.
    Instants(u64),
}

impl Detector {
    const fn is_ready(&self) -> bool {
        matches!(self, Self::Pulses(_, Some(_)) | Self::Count(_) | Self::Instants(_))
    }
}

impl Keyphasor {
    pub(super) fn new(
        column: &str,
        (pulses_per_turn, missing): (u32, u32),
        signal: &KeyphasorSignal,
        rate: f64,
        reversed: bool,
    ) -> Self {
        let detector = match signal {
            KeyphasorSignal::Pulses(given) => Detector::Pulses(*given, None),
            KeyphasorSignal::Count => Detector::Count(Counter::new(pulses_per_turn)),
            KeyphasorSignal::Instants { .. } => {
                Detector::Instants(KeyphasorSignal::instant_spacing(pulses_per_turn, missing).into())
            }
        };
        Self {
            column: column.into(),
            pulses_per_turn: pulses_per_turn.max(1),
            rate,
            reversed,
            longest_wait: LONGEST_WAIT,
            waiting: VecDeque::new(),
            next_look: FIRST_LOOK,
            detector,
            gap: (missing > 0).then(|| Gap::new(pulses_per_turn, missing)),
            pulses: VecDeque::new(),
            left: 0,
            left_fit: None,
            counted: 0,
            quiet: 0,
            patience: LEFT,
            last_pulse: Position::default(),
            third: None,
            first_pulse: Position::default(),
            last_reading: None,
            lost: None,
            surplus: SurplusPulses::default(),
        }
    }

    /// Returns the number of accepted pulses.
    pub(super) const fn counted(&self) -> u64 {
        self.counted
    }

    /// Returns the threshold in use; none before the levels are known, and for a count.
    pub(super) fn threshold(&self) -> Option<UsedThreshold> {
        match &self.detector {
            Detector::Pulses(given, edges) => edges.as_ref().map(|edges| edges.used(given)),
            Detector::Count(_) | Detector::Instants(_) => None,
        }
    }

    /// Returns true for instants in place of a signal.
    pub(super) const fn has_instants(&self) -> bool {
        matches!(self.detector, Detector::Instants(_))
    }

    /// Returns the width in bits at which a count was found to wrap.
    pub(super) const fn count_bits(&self) -> Option<u32> {
        match &self.detector {
            Detector::Count(counter) => counter.bits(),
            Detector::Pulses(..) | Detector::Instants(_) => None,
        }
    }

    pub(super) fn push(&mut self, row: Row, output: &mut Output) -> Result<(), RotationError> {
        self.waiting.push_back(row);
        if self.detector.is_ready() {
            self.see_from(self.waiting.len() - 1, output)?;
            self.release(output);
            return Ok(());
        }
        if self.waiting.len() >= self.next_look {
            self.next_look += self.next_look / 4;
            self.look(false, output)?;
        }
        if !self.detector.is_ready() && self.waiting.len() >= self.longest_wait {
            // A slow shaft has few pulses.
            self.look(true, output)?;
            return if self.detector.is_ready() { Ok(()) } else { Err(self.no_pulse()) };
        }
        Ok(())
    }

    pub(super) fn finish(&mut self, output: &mut Output) -> Result<(), RotationError> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        if !self.detector.is_ready() {
            self.look(true, output)?;
        }
        if let Some((third, at)) = self.third.take() {
            self.take(third, at, output)?;
        }
        match self.pulses.len() {
            0 => return Err(self.no_pulse()),
            1 => return Err(RotationError::OnePulse { column: self.column.clone(), line: self.last_pulse.line }),
            _ => {}
        }
        if let Some(gap) = self.gap.as_ref().filter(|gap| gap.origin().is_none()) {
            return Err(gap.absent(&self.column, self.counted));
        }
        while self.left + 1 < self.pulses.len() {
            self.release_interval(output);
        }
        let last = self.left_fit.unwrap_or_else(|| self.fit(self.left));
        let measured = self.measured_until(&last);
        let dead = |row: &Row| row.index > measured;
        let lost = self.waiting.iter().filter(|row| dead(row)).count() as u64;
        if let Some(first) = self.waiting.iter().find(|row| dead(row)) {
            output.ledger.record(Flaw::DeadKeyphasor, Some(&self.column), Position::from(first), lost);
        }
        while let Some(row) = self.waiting.pop_front() {
            let motion = self.motion(&last, last.progress(Instant::sample(row.index)));
            let status = SampleStatus::ANGLE_NOT_MEASURED.when(dead(&row));
            output.deliver_with(row, motion, status);
        }
        Ok(())
    }

    /// Returns the last sample whose angle the pulses determine: all where the recording ends within [`DEAD`] intervals of
    /// the last pulse, else the one at which the next pulse was due.
    fn measured_until(&self, last: &Fit) -> u64 {
        let end = self.waiting.back().map_or(0, |row| row.index);
        let period = self.spacing() * last.pulse.period;
        if Instant::sample(end).since(last.pulse.at) <= DEAD * period {
            return end;
        }
        last.pulse.at.index.saturating_add(period.ceil() as u64)
    }

    /// Looks for the levels in all samples so far, and then for the pulses.
    fn look(&mut self, end: bool, output: &mut Output) -> Result<(), RotationError> {
        let Detector::Pulses(given, edges) = &mut self.detector else { return Ok(()) };
        let gap = self.gap.as_ref().map_or(1.0, |gap| gap.intervals() as f64);
        let readings = self.waiting.iter().map(|row| row.rotation);
        let Some(levels) = Levels::learn(readings, given, gap, end) else { return Ok(()) };
        *edges = Some(Edges::new(levels));
        for row in self.waiting.iter_mut().filter(|row| levels.is_spike(row.rotation)) {
            output.ledger.record(Flaw::SpuriousPulse, Some(&self.column), Position::from(&*row), 1);
            row.rotation = f64::NAN;
        }
        self.see_from(0, output)?;
        self.release(output);
        Ok(())
    }

    /// Looks for other levels in the samples since the interval after the last pulse; returns the place in `waiting` from which
    /// the pulses are to be looked for again, if there are any.
    fn look_again(&mut self, period: f64) -> Option<usize> {
        let Detector::Pulses(given, Some(edges)) = &mut self.detector else { return None };
        let from = self.last_pulse.index.saturating_add(period.ceil().max(1.0) as u64);
        let first = self.waiting.partition_point(|row| row.index < from);
        let gap = self.gap.as_ref().map_or(1.0, |gap| gap.intervals() as f64);
        let readings = self.waiting.range(first..).map(|row| row.rotation);
        edges.continue_with(Levels::learn_again(readings, given, gap, edges.height())?);
        (self.quiet, self.patience) = (0, f64::INFINITY);
        Some(first)
    }

    /// Processes the samples in `waiting` from `place` on.
    fn see_from(&mut self, mut place: usize, output: &mut Output) -> Result<(), RotationError> {
        // A restart is an interval after a pulse that was found since the restart before, so this ends.
        while let Some(row) = self.waiting.get(place) {
            let (at, reading) = (Position::from(row), row.rotation);
            place = self.see(at, reading, output)?.unwrap_or(place + 1);
        }
        Ok(())
    }

    /// Processes a sample; returns the place in `waiting` from which samples are processed again, if other levels were found.
    fn see(&mut self, at: Position, reading: f64, output: &mut Output) -> Result<Option<usize>, RotationError> {
        if reading.is_nan() {
            return Ok(None);
        }
        let last_reading = self.last_reading.replace(at.index).unwrap_or(at.index);
        let period = self.period();
        if at.index.saturating_sub(last_reading) as f64 > period {
            self.lost = Some(last_reading + at.index.saturating_sub(last_reading) / 2);
        }
        self.quiet += 1;
        match &mut self.detector {
            Detector::Pulses(_, edges) => {
                if let Some(start) = edges.as_mut().and_then(|edges| edges.see(at.index, reading)) {
                    self.find(start, at, output)?;
                }
            }
            Detector::Count(counter) => {
                if let Some((start, steps)) = counter.see(at, reading, &self.column)? {
                    self.take_counted(start, steps, at);
                }
            }
            Detector::Instants(spacing) if reading >= 0.0 => {
                let (start, steps) = (Instant { index: at.index, fraction: -reading }, *spacing);
                if steps == 1 {
                    self.find(start, at, output)?;
                } else {
                    self.take_counted(start, steps, at);
                }
            }
            Detector::Instants(_) => {}
        }
        // Two pulses alone may be less than a turn apart.
        if self.pulses.len() > 2 && self.quiet as f64 > self.patience * period {
            self.patience *= 1.5;
            if let Some(first) = self.look_again(period) {
                return Ok(Some(first));
            }
        }
        let patience = if self.pulses.len() > 2 { STANDSTILL * self.spacing() * period } else { f64::INFINITY };
        if self.quiet as f64 > patience.min(self.longest_wait as f64) {
            return Err(if self.pulses.is_empty() { self.no_pulse() } else { self.standstill() });
        }
        Ok(None)
    }

    /// Adds the last of several pulses of a count, which need no check.
    fn take_counted(&mut self, start: Instant, steps: u64, at: Position) {
        self.lost = None;
        let Some(last) = self.pulses.back().copied() else {
            return self.add(Pulse { number: 0, at: start, period: 1.0, lost: None }, at);
        };
        let period = start.since(last.at) / steps as f64;
        if self.pulses.len() == 1 {
            self.pulses[0].period = period;
        }
        self.counted += steps - 1;
        self.add(Pulse { number: last.number.saturating_add(steps), at: start, period, lost: None }, at);
    }

    /// Takes a pulse, after a decision on the first one: two equal intervals after a shorter one show that the first pulse is no mark, such
    /// as where the recording began within a pulse. As a mark, it would make every turn one with missed pulses.
    fn find(&mut self, start: Instant, at: Position, output: &mut Output) -> Result<(), RotationError> {
        if let Some((third, third_at)) = self.third.take() {
            let [first, second] = [0, 1].map(|i| self.pulses[i].at);
            let interval = third.since(second);
            let excess = interval - second.since(first);
            if self.lost.is_none() && (start.since(third) - interval).abs() < THIRD_EVEN * excess {
                output.ledger.record(Flaw::SpuriousPulse, Some(&self.column), self.first_pulse, 1);
                self.pulses.clear();
                self.counted -= 2;
                for (number, at, position) in [(0, second, self.last_pulse), (1, third, third_at)] {
                    self.add(Pulse { number, at, period: interval, lost: None }, position);
                }
            } else {
                self.take(third, third_at, output)?;
            }
        } else if let ([first, second], None, None) = (self.pulses.make_contiguous(), &self.gap, self.lost)
            && self.left == 0
            && self.surplus.is_empty()
            && let first_interval = second.at.since(first.at)
            && start.since(second.at) - first_interval > FIRST_SHORT.0.max(FIRST_SHORT.1 * first_interval)
        {
            self.third = Some((start, at));
            self.quiet = 0;
            return Ok(());
        }
        self.take(start, at, output)
    }

    /// Checks a pulse against those before it and counts it.
    ///
    /// # Errors
    /// A toothed wheel without the gap of the scene.
    fn take(&mut self, start: Instant, at: Position, output: &mut Output) -> Result<(), RotationError> {
        let first = Pulse { number: 0, at: start, period: 1.0, lost: None };
        let Some(mut last) = self.pulses.back().copied() else {
            self.add(first, at);
            return Ok(());
        };
        if self.pulses.len() == 1 && self.lost.is_some() {
            // The pulse period is unknown yet, so lost pulses cannot be counted: the count begins here.
            self.lost = None;
            self.pulses.clear();
            self.add(first, at);
            return Ok(());
        }
        let interval = start.since(last.at);
        if self.is_gap_first(interval) {
            last = self.number_first_gap(last);
        }
        let (plain, trend) = self.passed(&last, start);
        let short = if trend.is_some() { TOO_SHORT.1 } else { TOO_SHORT.0 };
        if self.lost.is_none() && plain.max(trend.unwrap_or(plain)) < short && !self.surplus.is_twice_as_fast() {
            self.surplus.omit(start);
            output.ledger.record(Flaw::SpuriousPulse, Some(&self.column), at, 1);
            return Ok(());
        }
        let passed = trend.filter(|trend| (0.4..2.5).contains(&(trend / plain))).unwrap_or(plain);
        let whole = passed.round().max(1.0);
        let steps = if self.lost.is_some() || (passed - whole).abs() <= WHOLE_TOLERANCE { whole } else { 1.0 };
        let steps = match self.over_gap(last.number, passed, at, output)? {
            Some(steps) => steps,
            None => {
                if steps > 1.0 {
                    output.ledger.record(Flaw::MissedPulse, Some(&self.column), at, steps as u64 - 1);
                }
                steps
            }
        };
        let number = last.number.saturating_add(steps as u64);
        let period = interval / steps;
        if self.pulses.len() == 1 {
            // The sense of the count was not known before.
            self.pulses[0].period = period;
        }
        self.surplus.end_interval(last.at, interval);
        let lost = self.lost.take();
        self.add(Pulse { number, at: start, period, lost }, at);
        Ok(())
    }

    /// Returns the intervals in the gap of a toothed wheel where this one, `passed` intervals between teeth long, is the gap.
    fn over_gap(
        &mut self,
        last: u64,
        passed: f64,
        at: Position,
        output: &mut Output,
    ) -> Result<Option<f64>, RotationError> {
        let Some(gap) = &mut self.gap else { return Ok(None) };
        if self.lost.is_some() {
            gap.doubt();
            return Ok(None);
        }
        Ok(match gap.judge(last, passed, &self.column)? {
            Interval::Gap(steps) => Some(steps as f64),
            Interval::Plain => None,
            Interval::Unexpected => {
                output.ledger.record(Flaw::ToothInGap, Some(&self.column), at, 1);
                None
            }
        })
    }

    /// Returns true where the first interval of all was over the gap of a toothed wheel, which this second one shows.
    fn is_gap_first(&self, interval: f64) -> bool {
        let Some(gap) = self.gap.as_ref().filter(|gap| gap.origin().is_none()) else { return false };
        let (2, Some(last)) = (self.pulses.len(), self.pulses.back()) else { return false };
        (interval * gap.intervals() as f64 / last.period - 1.0).abs() < GAP_FIRST
    }

    /// Numbers the second pulse of all, after the gap; returns it.
    fn number_first_gap(&mut self, mut last: Pulse) -> Pulse {
        let Some(gap) = &mut self.gap else { return last };
        last.number = gap.intervals();
        last.period /= gap.intervals() as f64;
        gap.begins_at_once();
        self.pulses[0].period = last.period;
        self.pulses[1] = last;
        last
    }

    fn add(&mut self, pulse: Pulse, at: Position) {
        if self.pulses.is_empty() {
            self.first_pulse = at;
        }
        self.pulses.push_back(pulse);
        self.counted += 1;
        self.quiet = 0;
        self.patience = LEFT;
        self.last_pulse = at;
    }

    /// Returns the expected number of pulses from the last one until `start`: by the interval before, and by the trend
    /// of several where it is known.
    fn passed(&self, last: &Pulse, start: Instant) -> (f64, Option<f64>) {
        let count = self.pulses.len();
        if count < 2 {
            return (1.0, None);
        }
        let plain = start.since(last.at) / last.period;
        let trend: Vec<Pulse> = self.pulses.range(count.saturating_sub(TREND)..).copied().collect();
        let broken = self.lost.is_some() || trend.iter().skip(1).any(|pulse| pulse.lost.is_some());
        if trend.len() < 4 || broken {
            return (plain, None);
        }
        (plain, Fit::through(&trend, *last).map(|fit| fit.progress(start).pulses))
    }

    /// Returns the number of samples per pulse; none where it is not known yet.
    fn period(&self) -> f64 {
        match (self.pulses.len(), self.pulses.back()) {
            (0, _) | (_, None) => f64::INFINITY,
            (1, _) => self.quiet.max(1) as f64,
            (_, Some(last)) => last.period,
        }
    }

    /// Returns the number of pulses from one instant to the next: more than one in a count.
    const fn spacing(&self) -> f64 {
        match &self.detector {
            Detector::Count(counter) => counter.spacing() as f64,
            Detector::Instants(spacing) => *spacing as f64,
            Detector::Pulses(..) => 1.0,
        }
    }

    /// Delivers the samples of every interval whose pulses on both sides are known.
    fn release(&mut self, output: &mut Output) {
        if self.gap.as_ref().is_some_and(|gap| gap.origin().is_none()) {
            return;
        }
        let known = |place: usize| place.max(SIDE) + SIDE;
        while self.pulses.len() > known(self.left + 1)
            || (self.waiting.len() >= self.longest_wait && self.pulses.len() > self.left + 1)
        {
            self.release_interval(output);
        }
    }

    /// Delivers the samples up to the pulse after `left`.
    fn release_interval(&mut self, output: &mut Output) {
        let before = self.left_fit.unwrap_or_else(|| self.fit(self.left));
        let after = self.fit(self.left + 1);
        while let Some(row) = self.waiting.front() {
            let at = Instant::sample(row.index);
            if at.since(after.pulse.at) >= 0.0 {
                break;
            }
            let progress = between(&before, &after, at);
            let motion = self.motion(&before, progress);
            if let Some(row) = self.waiting.pop_front() {
                output.deliver(row, motion);
            }
        }
        self.left_fit = Some(after);
        self.left += 1;
        while self.left > 2 * SIDE {
            self.pulses.pop_front();
            self.left -= 1;
        }
    }

    /// Returns the fit through the pulses about `place` that have no signal loss between them.
    fn fit(&mut self, place: usize) -> Fit {
        let pulses = self.pulses.make_contiguous();
        let from = (1..=place).rev().find(|other| pulses[*other].lost.is_some()).unwrap_or(0);
        let to = (place + 1..pulses.len()).find(|other| pulses[*other].lost.is_some()).unwrap_or(pulses.len());
        Fit::around(&pulses[from..to], place - from)
    }

    /// Returns the motion of the shaft; `progress` counts from the pulse of `fit`.
    fn motion(&self, fit: &Fit, progress: Progress) -> Motion {
        let per_turn = f64::from(self.pulses_per_turn);
        // Whole turns go apart before anything is rounded.
        let origin = self.gap.as_ref().and_then(Gap::origin).unwrap_or(0);
        let number = fit.pulse.number.wrapping_sub(origin) as i64;
        let count = i64::from(self.pulses_per_turn);
        let (turns, part) = (number.div_euclid(count), number.rem_euclid(count));
        let total = Total::beyond(turns, (part as f64 + progress.pulses) / per_turn);
        let sign = if self.reversed { -1.0 } else { 1.0 };
        let unit = sign * TAU / per_turn * self.rate;
        Motion {
            total: if self.reversed { total.reversed() } else { total },
            speed: unit * progress.slope,
            acceleration: unit * self.rate * progress.bend,
        }
    }

    fn no_pulse(&self) -> RotationError {
        let (low, high) = range(self.waiting.iter().map(|row| row.rotation));
        let (column, samples) = (self.column.clone(), self.waiting.len());
        match &self.detector {
            Detector::Count(_) => RotationError::NoCount { column, samples, low },
            Detector::Instants(_) => RotationError::NoInstant { column, samples },
            Detector::Pulses(PulseDetection { threshold: Some(threshold), .. }, _) => {
                RotationError::NoCrossing { column, samples, low, high, threshold: *threshold }
            }
            Detector::Pulses(..) => RotationError::NoPulse { column, samples, low, high },
        }
    }

    fn standstill(&self) -> RotationError {
        let Position { line, time, .. } = self.last_pulse;
        RotationError::Standstill { column: self.column.clone(), samples: self.quiet, line, time }
    }
}

/// Returns the progress between two fits, blended linearly over time and counted from the pulse of the first. Over a signal loss the
/// first fit applies up to its middle, the second one after it.
fn between(before: &Fit, after: &Fit, at: Instant) -> Progress {
    let one = before.progress(at);
    let way = at.since(before.pulse.at) / after.pulse.at.since(before.pulse.at);
    let share = match after.pulse.lost {
        Some(middle) => f64::from(u8::from(at.index >= middle)),
        None => way.clamp(0.0, 1.0),
    };
    if share == 0.0 {
        return one;
    }
    let other = after.progress(at);
    let apart = after.pulse.number.wrapping_sub(before.pulse.number) as f64;
    let mix = |from: f64, to: f64| from + share * (to - from);
    Progress {
        pulses: mix(one.pulses, other.pulses + apart),
        slope: mix(one.slope, other.slope),
        bend: mix(one.bend, other.bend),
    }
}
