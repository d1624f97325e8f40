//! Location stage: the displacement of the rotor from the readings of its probes.

use super::range::ReadingRange;
use crate::outcome::Observation;
use crate::probes::{PoseSolver, reading};
use crate::recording::Sample;
use ballrace::Displacement;

/// Solver for the measured displacement, with the readings of the current sample.
pub(super) struct LocationStage {
    solver: PoseSolver,
    /// Readings of the sample, NaN where missing or out of range.
    readings: Vec<f64>,
}

impl LocationStage {
    pub(super) const fn new(solver: PoseSolver) -> Self {
        Self { solver, readings: Vec::new() }
    }

    /// Stores the readings of a sample.
    pub(super) fn set_sample(&mut self, range: &ReadingRange, sample: &Sample) {
        range.within(&sample.row.probes, &mut self.readings);
    }

    /// Returns the readings of the sample, NaN where missing or out of range.
    pub(super) fn readings(&self) -> &[f64] {
        &self.readings
    }

    /// Returns the displacement, with the axial coordinate `w` where there is no axial probe. It is not a number where a
    /// reading is missing.
    pub(super) fn displacement(&self, w: f64) -> Displacement<f64> {
        self.solver.pose(&self.readings, w)
    }

    /// Returns `coordinates` with the rigid motion added that brings the readings of the probes to those of the sample; `rows`
    /// are the readings per unit of each coordinate.
    pub(super) fn displaced(&self, coordinates: &[f64], rows: &[Vec<f64>]) -> Vec<f64> {
        let off: Vec<f64> = self.readings.iter().zip(rows).map(|(y, row)| y - reading(row, coordinates)).collect();
        let mut moved = coordinates.to_vec();
        for (entry, by) in moved.iter_mut().zip(self.solver.pose(&off, 0.0).to_array()) {
            *entry += by;
        }
        moved
    }

    pub(super) const fn solver(&self) -> &PoseSolver {
        &self.solver
    }

    /// Returns how the probes determine the motion.
    pub(super) const fn observation(&self) -> &Observation {
        &self.solver.observation
    }
}
