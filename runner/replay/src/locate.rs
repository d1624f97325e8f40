//! Location stage: the displacement of the rotor from the readings of its probes.

use ballrace::Displacement;
use ballrace_outcome::Observation;
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result};
use ballrace_plant::probes::{PoseSolver, reading};
use ballrace_scene::{Probe, Scene};
use nalgebra::{DMatrix, DVector};

/// Solver for the measured displacement. Readings are NaN where they are missing or out of range.
pub(super) struct LocationStage {
    solver: Solver,
    /// Reading of each probe per unit of each coordinate.
    rows: Vec<Vec<f64>>,
    observation: Observation,
}

/// Motion that the readings determine.
enum Solver {
    /// That of a straight line between the planes of the probes.
    Straight(PoseSolver),
    /// The coordinates of a given system per metre of each reading: the deflection of least strain energy.
    Deflection(DMatrix<f64>),
}

/// Position of the rotor at a sample.
pub(super) enum Position {
    /// On a straight line.
    Straight(Displacement<f64>),
    /// By coordinates.
    Coordinates(Vec<f64>),
}

impl Position {
    /// Returns the displacement of bearing `i`.
    pub(super) fn at_bearing(&self, plant: &Plant, i: usize) -> Displacement<f64> {
        match self {
            Self::Straight(line) => line.at_station(plant.bearings.get(i).map_or(0.0, |bearing| bearing.station)),
            Self::Coordinates(coordinates) => plant.displacement(i, coordinates),
        }
    }
}

impl LocationStage {
    /// Creates the stage for probes with these rows.
    ///
    /// # Errors
    /// Probes that do not determine the position of a rotor, a system whose stiffness has no inverse.
    pub(super) fn try_new(scene: &Scene, plant: &Plant, probes: &[Probe], rows: Vec<Vec<f64>>) -> Result<Self> {
        let (solver, observation) = if plant.layout.is_given() {
            let by_reading = plant.deflections(&rows)?;
            let observation = observation(plant, &rows, &by_reading);
            (Solver::Deflection(by_reading), observation)
        } else {
            let stations: Vec<f64> = plant.bearings.iter().map(|b| b.station).collect();
            let solver = PoseSolver::try_new(probes, &stations).map_err(Error::in_file(&scene.path))?;
            let observation = solver.observation.clone();
            (Solver::Straight(solver), observation)
        };
        Ok(Self { solver, rows, observation })
    }

    /// Returns the position at `readings`; the twin, at `coordinates`, supplies the rest: the axial position `w` without an axial probe, on a given
    /// system the shape to which the deflection is added. The position is not a number where a reading is missing.
    pub(super) fn position(&self, readings: &[f64], coordinates: &[f64], w: f64) -> Position {
        match &self.solver {
            Solver::Straight(solver) => Position::Straight(solver.pose(readings, w)),
            Solver::Deflection(_) => Position::Coordinates(self.displaced(readings, coordinates)),
        }
    }

    /// Returns `coordinates` with the motion added that brings the readings of the probes to `readings`.
    pub(super) fn displaced(&self, readings: &[f64], coordinates: &[f64]) -> Vec<f64> {
        let off = readings.iter().zip(&self.rows).map(|(y, row)| y - reading(row, coordinates));
        let off: Vec<f64> = off.collect();
        let moved = match &self.solver {
            Solver::Straight(solver) => solver.pose(&off, 0.0).to_array().to_vec(),
            Solver::Deflection(by_reading) => (by_reading * DVector::from_vec(off)).as_slice().to_vec(),
        };
        let mut displaced = coordinates.to_vec();
        displaced.iter_mut().zip(moved).for_each(|(entry, by)| *entry += by);
        displaced
    }

    /// Returns the change of the displacement of bearing `i` per metre of one probe's reading.
    pub(super) fn column(&self, plant: &Plant, i: usize, probe: usize) -> Displacement<f64> {
        match &self.solver {
            Solver::Straight(solver) => Position::Straight(solver.column(probe)).at_bearing(plant, i),
            Solver::Deflection(by_reading) if probe < by_reading.ncols() => {
                plant.displacement(i, by_reading.column(probe).as_slice())
            }
            Solver::Deflection(_) => Displacement::default(),
        }
    }

    /// Returns how the probes determine the motion.
    pub(super) const fn observation(&self) -> &Observation {
        &self.observation
    }

    /// Returns the note on the part of the position that the twin supplies; none where the probes determine all of it.
    pub(super) fn note(&self) -> Option<&'static str> {
        match &self.solver {
            Solver::Deflection(_) => Some(
                "The scene has a [system]: the position behind the measured forces is the twin's, with the deflection of least strain energy that brings it to the readings.",
            ),
            Solver::Straight(_) if !self.observation.supplied_by_twin.is_empty() => {
                Some("No axial probe: the axial position behind the measured forces is the twin's.")
            }
            Solver::Straight(_) => None,
        }
    }
}

/// Returns how the readings determine the deflection of a given system.
fn observation(plant: &Plant, rows: &[Vec<f64>], by_reading: &DMatrix<f64>) -> Observation {
    let matrix = DMatrix::from_fn(rows.len(), plant.layout.order, |p, i| rows[p][i]);
    let singular = matrix.singular_values();
    let gain = |i: usize| {
        let columns = by_reading.column_iter().map(|column| plant.displacement(i, column.as_slice()));
        columns.fold([0.0; 2], |[x, y], d| [x + d.u * d.u, y + d.v * d.v])
    };
    Observation {
        condition_number: singular.max() / singular.min(),
        noise_gain: (0..plant.bearings.len()).flat_map(gain).fold(0.0, f64::max).sqrt(),
        supplied_by_twin: vec![],
    }
}
