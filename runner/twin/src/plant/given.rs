//! A system given by its matrices.

use super::Scales;
use super::error::{PlantError, Result};
use crate::scene::{Coordinates, Scene, System, matrix};
use ballrace::rotor::SystemMatrices;
use nalgebra::DMatrix;
use std::path::PathBuf;

/// The matrices of a scene's `[system]`, and how its bearings are attached.
#[derive(Clone)]
pub struct Given {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    gyroscopic: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    load: Vec<f64>,
    system: System,
    /// Five extended vectors of each bearing.
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
        let extended = |bearing: &crate::scene::Bearing| {
            let fault = |found: i64| PlantError::BearingCoordinate {
                file: scene.path.clone(),
                bearing: bearing.name.clone(),
                found,
                most: n,
            };
            let mut rows: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; n]);
            let mut add = |coordinates: &Coordinates, side: f64| -> Result<()> {
                for (row, &coordinate) in rows.iter_mut().zip(coordinates) {
                    let Some(at) = usize::try_from(coordinate.abs()).ok().and_then(|c| c.checked_sub(1)) else {
                        continue;
                    };
                    *row.get_mut(at).ok_or_else(|| fault(coordinate))? += side * coordinate.signum() as f64;
                }
                Ok(())
            };
            add(&bearing.coordinates.unwrap_or_default(), 1.0)?;
            add(&bearing.housing_coordinates.unwrap_or_default(), -1.0)?;
            Ok(rows)
        };
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

    /// Number of coordinates.
    #[must_use]
    pub fn order(&self) -> usize {
        self.mass.nrows()
    }

    /// Its matrices, load and unbalance.
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
