//! A system given by its matrices.

use crate::scene::{Coordinates, Scene, System, matrix};
use anyhow::{Result, bail};
use ballrace::rotor::Matrices;
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
    /// Of each bearing: its five extended vectors.
    pub extended: Vec<[Vec<f64>; 5]>,
}

impl Given {
    /// Reads the files.
    ///
    /// # Errors
    /// A file that is no matrix, matrices of different sizes, coordinates that the system does not have.
    pub fn read(scene: &Scene, system: &System) -> Result<Self> {
        let mass = matrix::read(&system.mass)?;
        let n = mass.nrows();
        let square = |path: &PathBuf, matrix: DMatrix<f64>| {
            if matrix.shape() == (n, n) && n > 0 {
                return Ok(matrix);
            }
            let (rows, columns) = matrix.shape();
            bail!(
                "{}: found {rows} x {columns}, allowed: {n} x {n}, square and as large as the mass matrix",
                path.display()
            )
        };
        let optional = |path: &Option<PathBuf>| match path {
            Some(path) => square(path, matrix::read(path)?),
            None => Ok(DMatrix::zeros(n, n)),
        };
        let load = match &system.load {
            None => vec![0.0; n],
            Some(path) => {
                let load = matrix::read(path)?;
                if load.len() != n {
                    bail!("{}: found {} numbers, allowed: {n}, one a coordinate", path.display(), load.len());
                }
                load.iter().copied().collect()
            }
        };
        for unbalance in &system.unbalance {
            if let Some(most) = unbalance.at.iter().find(|at| **at >= n) {
                bail!("{}: system.unbalance: found coordinate {}, allowed: 1 to {n}", scene.path.display(), most + 1);
            }
        }
        let extended = |bearing: &crate::scene::Bearing| {
            let fault = |found: i64| {
                anyhow::anyhow!(
                    "{}: bearing {}: coordinates: found {found}, allowed: -{n} to {n}",
                    scene.path.display(),
                    bearing.name
                )
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
            damping: optional(&system.damping)?,
            gyroscopic: optional(&system.gyroscopic)?,
            stiffness: square(&system.stiffness, matrix::read(&system.stiffness)?)?,
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

    /// As the kernel takes them, the coordinates past the system's own idle.
    #[must_use]
    pub fn matrices<const D: usize>(&self) -> Matrices<D> {
        let mut all = Matrices::<D>::idle();
        let n = self.order().min(D);
        for i in 0..n {
            for j in 0..n {
                all.mass[(i, j)] = self.mass[(i, j)];
                all.damping[(i, j)] = self.damping[(i, j)];
                all.gyroscopic[(i, j)] = self.gyroscopic[(i, j)];
                all.stiffness[(i, j)] = self.stiffness[(i, j)];
            }
        }
        for (entry, &load) in all.load.iter_mut().zip(&self.load) {
            *entry = load;
        }
        self.system.unbalance.iter().fold(all, |all, u| all.with_unbalance((u.at[0], u.at[1]), u.moment, u.angle))
    }
}
