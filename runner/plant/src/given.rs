//! A system given by its matrices.

use super::matrix;
use super::plant_error::{PlantError, Result};
use super::{Rows, Scales};
use ballrace::rotor::SystemMatrices;
use ballrace_scene::{Coordinates, Scene, System};
use nalgebra::DMatrix;
use std::path::PathBuf;

/// Smallest reading of a probe per unit of a coordinate; smaller values are rounding errors of the probe's angle.
const MIN_READING: f64 = 1e-9;

/// The matrices of a scene's `[system]`, and how its bearings are attached.
#[derive(Clone)]
pub struct Given {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    gyroscopic: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    load: Vec<f64>,
    system: System,
    /// Displacement of each bearing, inner ring against outer ring, per unit of each coordinate.
    pub extended: Vec<[Vec<f64>; 5]>,
}

impl Given {
    /// Reads the files.
    ///
    /// # Errors
    /// A file that is no matrix, matrices of different sizes, coordinates that the system does not have.
    pub fn read(scene: &Scene, system: &System) -> Result<Self> {
        let mass = matrix::read(&system.mass, &["M"])?;
        let n = mass.nrows();
        let square = |path: &PathBuf, matrix: DMatrix<f64>| {
            if matrix.shape() == (n, n) && n > 0 {
                return Ok(matrix);
            }
            let (rows, columns) = matrix.shape();
            Err(PlantError::MatrixSize { file: path.clone(), rows, columns, expected: n })
        };
        let optional = |path: &Option<PathBuf>, variables: &[&str]| match path {
            Some(path) => square(path, matrix::read(path, variables)?),
            None => Ok(DMatrix::zeros(n, n)),
        };
        let load = match &system.load {
            None => vec![0.0; n],
            Some(path) => {
                let load = matrix::read(path, &["F", "f"])?;
                if load.len() != n {
                    return Err(PlantError::LoadLength { file: path.clone(), found: load.len(), expected: n });
                }
                load.iter().copied().collect()
            }
        };
        for unbalance in &system.unbalance {
            if let Some(most) = unbalance.at.iter().find(|at| **at >= n) {
                return Err(PlantError::UnbalanceCoordinate { file: scene.path.clone(), found: most + 1, most: n });
            }
        }
        let check = |coordinates: &Coordinates, part: &str, name: &str| match coordinates
            .iter()
            .find(|c| c.unsigned_abs() > n as u64)
        {
            Some(&found) => {
                let (file, part) = (scene.path.clone(), format!("{part} {name}"));
                Err(PlantError::Coordinate { file, part, found, most: n })
            }
            None => Ok(()),
        };
        let extended = |bearing: &ballrace_scene::Bearing| {
            let [inner, outer] = [bearing.coordinates, bearing.housing_coordinates].map(Option::unwrap_or_default);
            check(&inner, "bearing", &bearing.name)?;
            check(&outer, "bearing", &bearing.name)?;
            let mut rows = rows(&inner, n);
            for (row, outer) in rows.iter_mut().zip(self::rows(&outer, n)) {
                row.iter_mut().zip(outer).for_each(|(inner, outer)| *inner -= outer);
            }
            Ok(rows)
        };
        for probe in scene.recording.iter().flat_map(|recording| &recording.probes) {
            let found = probe.coordinates.unwrap_or_default();
            check(&found, "probe", &probe.column)?;
            if probe.row(&rows(&found, n)).iter().all(|x| x.abs() < MIN_READING) {
                return Err(PlantError::BlindProbe { file: scene.path.clone(), probe: probe.column.clone(), found });
            }
        }
        Ok(Self {
            mass: square(&system.mass, mass.clone())?,
            damping: optional(&system.damping, &["C", "B"])?,
            gyroscopic: optional(&system.gyroscopic, &["G"])?,
            stiffness: square(&system.stiffness, matrix::read(&system.stiffness, &["K"])?)?,
            load,
            extended: scene.bearings.iter().map(extended).collect::<Result<_>>()?,
            system: system.clone(),
        })
    }

    /// Returns the displacement at these coordinates per unit of each.
    #[must_use]
    pub fn rows(&self, coordinates: &Coordinates) -> Rows {
        rows(coordinates, self.order())
    }

    /// Returns the coordinates of up to two planes of unbalance, along X and Y of each.
    #[must_use]
    pub fn unbalance_planes(&self) -> Vec<[usize; 2]> {
        let mut planes: Vec<[usize; 2]> = self.system.unbalance.iter().map(|unbalance| unbalance.at).collect();
        planes.dedup();
        planes.truncate(2);
        planes
    }

    /// Returns the number of coordinates.
    #[must_use]
    pub fn order(&self) -> usize {
        self.mass.nrows()
    }

    /// Returns the matrices, the load and the unbalance of the system.
    #[must_use]
    pub fn scales(&self) -> Scales {
        let mut unbalance = vec![[0.0; 2]; self.order()];
        for given in &self.system.unbalance {
            let plane = SystemMatrices::<2>::unit_mass().with_unbalance((0, 1), given.moment, given.angle);
            for (at, [cos, sin]) in given.at.iter().zip(plane.unbalance) {
                if let Some(entry) = unbalance.get_mut(*at) {
                    *entry = [entry[0] + cos, entry[1] + sin];
                }
            }
        }
        Scales {
            mass: self.mass.clone(),
            damping: self.damping.clone(),
            gyroscopic: self.gyroscopic.clone(),
            stiffness: self.stiffness.clone(),
            load: self.load.clone(),
            unbalance,
        }
    }
}

/// Returns the displacement at these coordinates per unit of each of `n`; coordinates that do not exist are omitted.
fn rows(coordinates: &Coordinates, n: usize) -> Rows {
    coordinates.map(|coordinate| {
        let mut row = vec![0.0; n];
        let at = usize::try_from(coordinate.unsigned_abs()).ok().and_then(|c| c.checked_sub(1));
        if let Some(entry) = at.and_then(|at| row.get_mut(at)) {
            *entry = coordinate.signum() as f64;
        }
        row
    })
}
