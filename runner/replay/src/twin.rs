//! Twin stage: the digital twin follows the shaft angle from sample to sample.

use ballrace::Phase;
use ballrace::rotor::{ComponentAngles, ShaftMotion};
use ballrace_plant::error::{ReplayError, Result};
use ballrace_plant::{MountedBearing, Plant, Twin};
use ballrace_recording::Sample;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Number of consecutive samples with a held twin after which it restarts.
const LONGEST_HOLD: u32 = 64;
/// Gaps longer than this many revolutions restart the twin.
const LONGEST_COAST_TURNS: f64 = 200.0;
/// Gaps longer than this many seconds restart the twin, unless it takes longer to settle.
const LONGEST_COAST: f64 = 2.0;

/// Start of the twin at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TwinStart {
    /// At the first sample of the recording.
    First,
    /// After a gap or a hold.
    Restart,
}

/// Interval from one sample to the next.
#[derive(Default)]
pub(super) struct SampleInterval {
    /// Shaft at the earlier sample.
    from: ShaftMotion<f64>,
    /// Number of sample periods; more than 1 over a gap, 0 where the twin starts at the later sample.
    steps: u64,
    /// Sample period, s.
    period: f64,
    /// Revolutions of the shaft.
    pub(super) revolutions: f64,
    /// Start of the twin at the later sample.
    pub(super) start: Option<TwinStart>,
}

impl SampleInterval {
    /// Returns the motion of the shaft at the start of each sample period.
    pub(super) fn motion(&self) -> impl Iterator<Item = ShaftMotion<f64>> + use<> {
        let (from, period) = (self.from, self.period);
        (0..self.steps).map(move |i| from.after(i as f64 * period))
    }

    /// Returns the angles of a bearing's parts at the end of the interval, where the shaft angle is `end`.
    fn parts(&self, parts: ComponentAngles, bearing: &MountedBearing, end: Phase) -> ComponentAngles {
        if self.steps > 1 {
            let turned = bearing.kinematics.parts_at(self.revolutions);
            return ComponentAngles {
                cage: parts.cage.wrapping_add(turned.cage),
                ball: parts.ball.wrapping_add(turned.ball),
                outer: parts.outer.wrapping_add(turned.outer),
            };
        }
        bearing.kinematics.speed_ratios().advance(parts, end.since(self.from.angle))
    }
}

/// The twin of a replay.
pub(super) struct TwinStage {
    plant: Arc<Plant>,
    /// Samples per second.
    rate: f64,
    /// Settling time of the plant, s.
    settling_time: f64,
    state: Option<TwinState>,
    /// The twin has followed a sample.
    has_run: bool,
    held_samples: u64,
    /// Number of gaps that restarted the twin, and the line after the first.
    gap_restarts: (u64, u64),
    /// Time of the last restart of a held twin, s.
    last_hold_restart: f64,
}

/// Twin and bearing parts at the last sample.
struct TwinState {
    twin: Box<dyn Twin>,
    /// Number of consecutive samples in which the twin was held.
    held: u32,
    parts: Vec<ComponentAngles>,
    /// Angle of each cage beyond that of the scene, revolutions.
    cage_offsets: Vec<f64>,
    shaft: ShaftMotion<f64>,
    index: u64,
}

impl TwinStage {
    pub(super) fn new(plant: Arc<Plant>, rate: f64) -> Self {
        Self {
            settling_time: plant.settling_time(),
            plant,
            rate,
            state: None,
            has_run: false,
            held_samples: 0,
            gap_restarts: (0, 0),
            last_hold_restart: f64::NEG_INFINITY,
        }
    }

    /// Returns true where the twin starts at the sample `index`: it does not run, or the gap before the sample is too long.
    pub(super) fn starts_at(&self, index: u64) -> bool {
        let Some(state) = &self.state else { return true };
        let steps = index.saturating_sub(state.index) as f64;
        let coasted = state.shaft.speed * steps / self.rate / TAU;
        let longest = self.settling_time.max(LONGEST_COAST) * self.rate;
        coasted.abs() > LONGEST_COAST_TURNS || steps > longest
    }

    /// Returns the interval from the last sample to this one. Where the twin starts here, `start` returns it.
    pub(super) fn interval(
        &mut self,
        sample: &Sample,
        start: impl FnOnce() -> Result<Box<dyn Twin>>,
    ) -> Result<SampleInterval> {
        let (shaft, period) = (sample.shaft_motion(), 1.0 / self.rate);
        if self.starts_at(sample.row.index) {
            let twin = start()?;
            if self.state.is_some() {
                let (count, line) = self.gap_restarts;
                self.gap_restarts = (count + 1, if count == 0 { sample.row.line } else { line });
            }
            let revolutions = sample.total_revolutions();
            let parts: Vec<ComponentAngles> =
                self.plant.bearings.iter().map(|b| b.kinematics.parts_at(revolutions)).collect();
            let cage_offsets = vec![0.0; parts.len()];
            let index = sample.row.index;
            self.state = Some(TwinState { twin, held: 0, parts, cage_offsets, shaft, index });
            let start = if self.has_run { TwinStart::Restart } else { TwinStart::First };
            return Ok(SampleInterval { from: shaft, steps: 0, period, revolutions: 0.0, start: Some(start) });
        }
        let state = self.state.as_ref().ok_or(ReplayError::NotStarted)?;
        let steps = sample.row.index.saturating_sub(state.index);
        let coasted = state.shaft.speed * steps as f64 / self.rate / TAU;
        // Over one period the difference of the angles counts; over a gap its whole revolutions come from the speed.
        let fraction = shaft.angle.since(state.shaft.angle).radians::<f64>() / TAU;
        let revolutions = fraction + (coasted - fraction).round();
        Ok(SampleInterval { from: state.shaft, steps, period, revolutions, start: None })
    }

    /// Advances the twin and the bearing parts to `sample`.
    pub(super) fn advance(&mut self, sample: &Sample, interval: &SampleInterval) {
        let Some(state) = &mut self.state else { return };
        for shaft in interval.motion() {
            let is_held = state.twin.step(&shaft).is_held();
            self.held_samples += u64::from(is_held);
            state.held = if is_held { state.held + 1 } else { 0 };
        }
        for (parts, bearing) in state.parts.iter_mut().zip(&self.plant.bearings) {
            *parts = interval.parts(*parts, bearing, sample.angle);
        }
        (state.shaft, state.index) = (sample.shaft_motion(), sample.row.index);
        self.has_run = true;
    }

    /// Sets the angle of each cage beyond that of the scene, revolutions.
    pub(super) fn set_cage_offsets(&mut self, offsets: &[f64]) {
        let Some(TwinState { twin, parts, cage_offsets, .. }) = &mut self.state else { return };
        for (i, ((offset, before), parts)) in offsets.iter().zip(cage_offsets).zip(parts).enumerate() {
            let by = offset - std::mem::replace(before, *offset);
            if by == 0.0 {
                continue;
            }
            let by = Phase::from_revolutions(by);
            parts.cage = parts.cage.wrapping_add(by);
            twin.turn_cage(i, by);
        }
    }

    /// Places the twin at a state.
    pub(super) fn place(&mut self, coordinates: &[f64], rates: &[f64]) {
        if let Some(state) = &mut self.state {
            state.twin.place(coordinates, rates);
        }
    }

    /// Returns the coordinates of the twin now; empty before it starts.
    pub(super) fn coordinates(&self) -> &[f64] {
        self.state.as_ref().map_or(&[], |state| state.twin.coordinates())
    }

    /// Returns the rates of the coordinates; empty before it starts.
    pub(super) fn rates(&self) -> &[f64] {
        self.state.as_ref().map_or(&[], |state| state.twin.rates())
    }

    /// Returns the angles of the parts of every bearing; empty before the twin starts.
    pub(super) fn parts(&self) -> &[ComponentAngles] {
        self.state.as_ref().map_or(&[], |state| &state.parts)
    }

    /// Returns the motion of the shaft at the last sample; none before the twin starts.
    pub(super) fn shaft(&self) -> Option<ShaftMotion<f64>> {
        self.state.as_ref().map(|state| state.shaft)
    }

    /// Returns true where the motion of the twin overflowed in the last step, so that its last state is held.
    pub(super) fn is_held(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.held > 0)
    }

    /// Returns true once the twin has followed a sample.
    pub(super) const fn has_run(&self) -> bool {
        self.has_run
    }

    /// Stops the twin: it starts again with the next sample.
    pub(super) fn stop(&mut self) {
        self.state = None;
    }

    /// Stops a twin that has been held for too long; returns true where it did.
    ///
    /// For as long as its run-in takes, the twin is not stopped again, so that work stays bounded where it overflows at once.
    pub(super) fn stop_if_stuck(&mut self, time: f64) -> bool {
        let is_stuck = self.state.as_ref().is_some_and(|state| state.held >= LONGEST_HOLD);
        if !is_stuck || time - self.last_hold_restart <= 1.0 + self.settling_time {
            return false;
        }
        self.last_hold_restart = time;
        self.stop();
        true
    }

    /// Returns the notes of the report.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        match self.gap_restarts {
            (0, _) => {}
            (1, line) => notes.push(format!("The twin restarted after the gap before line {line}.")),
            (count, line) => {
                notes.push(format!("The twin restarted after {count} gaps, the first before line {line}."));
            }
        }
        if self.held_samples > 0 {
            notes.push(format!("The twin's motion overflowed and was held for {} samples.", self.held_samples));
        }
        notes
    }
}
