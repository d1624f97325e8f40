//! Flexible rotors: from the drawing of a rotor to a small system of equations (`docs/src/models.md`, section "Flexible rotor").
//!
//! `element` has the matrices of a Timoshenko element, `mesh` assembles the rotor, `modes` solves for its natural modes, and
//! [`ReducedRotor`] keeps a few coordinates: the rigid motion of the centre of mass, and the elastic shapes that matter at the bearings.

mod drawing;
mod element;
mod mesh;
mod modes;

pub use drawing::{Disk, FlexibleRotor, Section};
pub use mesh::{Mesh, rigid_body};
pub use modes::Modes;

use ballrace_base::eigenvalues::EigenvalueError;
use nalgebra::{DMatrix, DVector};
use std::iter;
use std::sync::Arc;

/// Relative change of the natural frequencies by halving the elements, below which the mesh is fine enough.
const MESH_ERROR: f64 = 1e-3;
/// First and largest number of elements over the length of the rotor.
const ELEMENTS: [f64; 2] = [20.0, 160.0];

/// A free flexible rotor as a mesh with its modes in a plane.
pub struct FreeRotor {
    /// The finite-element model.
    pub mesh: Mesh,
    /// Modes in a plane; the first two are rigid.
    pub bending: Modes,
    /// Modes along the axis; the first is rigid.
    pub axial: Modes,
}

/// Number of rigid modes in a plane.
const RIGID: usize = 2;

impl FreeRotor {
    /// Creates the model with nodes at the stations `kept`, fine enough for lines up to `highest` (Hz).
    ///
    /// # Errors
    /// Returns an error if the modes cannot be computed.
    pub fn try_new(rotor: &FlexibleRotor, kept: &[f64], highest: f64) -> Result<Self, EigenvalueError> {
        let mut elements = ELEMENTS[0];
        let mut last = Self::with_elements(rotor, kept, elements)?;
        while elements < ELEMENTS[1] {
            elements *= 2.0;
            let next = Self::with_elements(rotor, kept, elements)?;
            let of_interest = next.bending.frequencies(RIGID).take_while(|f| *f < highest).count().max(1);
            let pairs = last.bending.frequencies(RIGID).zip(next.bending.frequencies(RIGID)).take(of_interest);
            let change = pairs.map(|(coarse, fine)| (coarse / fine - 1.0).abs()).fold(0.0, f64::max);
            if change < MESH_ERROR {
                // The coarse mesh is within the error.
                return Ok(last);
            }
            last = next;
        }
        Ok(last)
    }

    fn with_elements(rotor: &FlexibleRotor, kept: &[f64], elements: f64) -> Result<Self, EigenvalueError> {
        let mesh = Mesh::new(rotor, kept, rotor.length() / elements);
        let bending = Modes::try_new(&mesh.mass, &mesh.stiffness)?;
        let axial = Modes::try_new(&mesh.axial_mass, &mesh.axial_stiffness)?;
        Ok(Self { mesh, bending, axial })
    }

    /// Returns those of the `stations` that are at different nodes: forces at one node have one shape.
    fn distinct(&self, stations: &[f64]) -> Vec<f64> {
        let nodes: Vec<usize> = stations.iter().map(|station| self.mesh.node(*station)).collect();
        let is_first = |i: &usize| nodes.iter().position(|node| *node == nodes[*i]) == Some(*i);
        (0..stations.len()).filter(is_first).map(|i| stations[i]).collect()
    }

    /// Returns the shape under a unit force (`moment` false) or moment at `station`, in a plane, without the rigid motion and without
    /// the first `without` elastic modes: the residual flexibility of these modes.
    fn residual_shape(&self, station: f64, moment: bool, without: usize) -> DVector<f64> {
        let at = 2 * self.mesh.node(station) + usize::from(moment);
        let mut shape = DVector::zeros(2 * self.mesh.stations.len());
        for j in RIGID + without..self.bending.squares.len() {
            let mode = self.bending.shapes.column(j);
            shape += mode * (mode[at] / self.bending.squares[j]);
        }
        shape
    }

    /// Returns shapes along the axis, rigid and elastic with the modal mass `mass`, and the stiffness of the elastic ones: the modes below
    /// `highest` (Hz), and residual shapes of forces at `forces`.
    fn along_axis(&self, mass: f64, forces: &[f64], highest: f64) -> Result<(DMatrix<f64>, Vec<f64>), EigenvalueError> {
        let modes = self.axial.frequencies(1).take_while(|f| *f < highest).count();
        let mode = |j: usize| self.axial.shapes.column(j).into_owned();
        let mut columns: Vec<DVector<f64>> = (1..=modes).map(mode).collect();
        let mut squares: Vec<f64> = self.axial.squares.iter().skip(1).take(modes).copied().collect();
        if !forces.is_empty() {
            for station in forces {
                let at = self.mesh.node(*station);
                let rest = 1 + modes..self.axial.squares.len();
                let shape: DVector<f64> =
                    rest.map(|j| mode(j) * (self.axial.shapes[(at, j)] / self.axial.squares[j])).sum();
                let size = shape.dot(&(&self.mesh.axial_mass * &shape)).sqrt();
                columns.push(shape / size.max(f64::MIN_POSITIVE));
            }
            let basis = DMatrix::from_columns(&columns);
            let small = |m: &DMatrix<f64>| basis.transpose() * m * &basis;
            let own = Modes::try_new(&small(&self.mesh.axial_mass), &small(&self.mesh.axial_stiffness))?;
            columns = (&basis * &own.shapes).column_iter().map(|column| column.into_owned()).collect();
            squares = own.squares.iter().copied().collect();
        }
        let rigid = DVector::from_element(self.mesh.stations.len(), 1.0);
        let all: Vec<_> = iter::once(rigid).chain(columns.into_iter().map(|column| column * mass.sqrt())).collect();
        Ok((DMatrix::from_columns(&all), squares.into_iter().map(|square| square * mass).collect()))
    }
}

/// Stations at which forces of bearings act on a rotor, m.
#[derive(Debug, Clone, Copy, Default)]
pub struct ForceStations<'a> {
    /// Stations of radial forces and moments.
    pub radial: &'a [f64],
    /// Stations of axial forces whose flexibility counts.
    pub axial: &'a [f64],
}

/// Equations of a rotor in a few coordinates.
///
/// In each plane: displacement and tilt of the centre of mass, and amplitudes of elastic shapes, all with the mass of the rotor.
pub struct ReducedRotor {
    /// The free rotor that is reduced.
    pub free: Arc<FreeRotor>,
    /// Mass of the rotor, kg.
    pub mass: f64,
    /// Diametral inertia about the centre of mass, kg m^2.
    pub diametral_inertia: f64,
    /// Shapes in a plane: columns for the displacement of the centre of mass, its tilt, and each elastic coordinate.
    pub shapes: DMatrix<f64>,
    /// Stiffness of each elastic coordinate, N/m.
    pub stiffness: Vec<f64>,
    /// Polar inertia in these coordinates.
    pub polar: DMatrix<f64>,
    /// Shapes along the axis: rigid, and each elastic coordinate.
    pub axial_shapes: DMatrix<f64>,
    /// Stiffness of each elastic coordinate along the axis, N/m.
    pub axial_stiffness: Vec<f64>,
    /// Stations of axial forces that have residual shapes.
    pub axial_forces: Vec<f64>,
}

impl ReducedRotor {
    /// Reduces `free` to `count` elastic coordinates in each plane: as many natural modes as are left beside the residual shapes of
    /// radial forces; along the axis the modes below `highest` (Hz) and the residual shapes of axial forces.
    ///
    /// Source: residual flexibility, Rubin 1975, AIAA Journal 13, and MacNeal 1971, Computers and Structures 1.
    ///
    /// # Errors
    /// Returns an error if the modes cannot be computed.
    pub fn try_new(
        free: Arc<FreeRotor>,
        count: usize,
        forces: ForceStations<'_>,
        highest: f64,
    ) -> Result<Self, EigenvalueError> {
        let [forces, axial_forces] = [forces.radial, forces.axial].map(|stations| free.distinct(stations));
        let nodes = free.mesh.stations.len();
        let count = count.min(free.bending.squares.len() - RIGID);
        let mut rigid = DMatrix::zeros(2 * nodes, RIGID);
        for (i, z) in free.mesh.stations.iter().enumerate() {
            rigid[(2 * i, 0)] = 1.0;
            (rigid[(2 * i, 1)], rigid[(2 * i + 1, 1)]) = (*z, 1.0);
        }
        let inertia = rigid.transpose() * &free.mesh.mass * &rigid;
        let mass = inertia[(0, 0)];
        let loads: Vec<(f64, bool)> =
            [false, true].into_iter().flat_map(|m| forces.iter().map(move |z| (*z, m))).collect();
        // Moments of rolling bearings are small: their shapes are used only if a mode is left beside all of them.
        let residual = if count > loads.len() { loads.len() } else { forces.len().min(count.saturating_sub(1)) };
        let modes = count - residual;
        let mut columns: Vec<DVector<f64>> =
            (0..modes).map(|j| free.bending.shapes.column(RIGID + j).into_owned()).collect();
        columns.extend(loads.iter().take(residual).map(|(z, moment)| free.residual_shape(*z, *moment, modes)));
        for column in &mut columns {
            let size = column.dot(&(&free.mesh.mass * &*column)).sqrt();
            *column /= size.max(f64::MIN_POSITIVE);
        }
        let basis = if columns.is_empty() { DMatrix::zeros(2 * nodes, 0) } else { DMatrix::from_columns(&columns) };
        let (mut shapes, mut stiffness) = (rigid, vec![]);
        if count > 0 {
            let small = |m: &DMatrix<f64>| basis.transpose() * m * &basis;
            let own = Modes::try_new(&small(&free.mesh.mass), &small(&free.mesh.stiffness))?;
            // The modal mass is the mass of the rotor.
            let elastic = &basis * &own.shapes * mass.sqrt();
            shapes = DMatrix::from_columns(&shapes.column_iter().chain(elastic.column_iter()).collect::<Vec<_>>());
            stiffness = own.squares.iter().map(|square| square * mass).collect();
        }
        let polar = shapes.transpose() * &free.mesh.polar * &shapes;
        let (axial_shapes, axial_stiffness) = free.along_axis(mass, &axial_forces, highest)?;
        Ok(Self {
            mass,
            diametral_inertia: inertia[(1, 1)],
            shapes,
            stiffness,
            polar,
            axial_shapes,
            axial_stiffness,
            axial_forces,
            free,
        })
    }

    /// Returns the number of elastic coordinates in each plane.
    #[must_use]
    pub fn elastic(&self) -> usize {
        self.stiffness.len()
    }

    /// Returns the number of coordinates: five of the rigid motion, the elastic ones along X and Y in pairs, those along Z.
    #[must_use]
    pub fn order(&self) -> usize {
        5 + 2 * self.elastic() + self.axial_stiffness.len()
    }

    /// Returns the coordinates along X and Y of coordinate `j` of a plane with their signs: a tilt about X is a negative slope along Y.
    pub fn at(j: usize) -> [(usize, f64); 2] {
        match j {
            0 => [(0, 1.0), (1, 1.0)],
            1 => [(4, 1.0), (3, -1.0)],
            _ => [(2 * j + 1, 1.0), (2 * j + 2, 1.0)],
        }
    }

    /// Returns the displacement of the shaft at `station` per unit of each of `order` coordinates: one row for each of `u v w thu thv`.
    #[must_use]
    pub fn rows(&self, station: f64, order: usize) -> [Vec<f64>; 5] {
        let node = self.free.mesh.node(station);
        let mut rows: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; order]);
        for j in 0..self.shapes.ncols() {
            let (shape, slope) = (self.shapes[(2 * node, j)], self.shapes[(2 * node + 1, j)]);
            let [(x, along_x), (y, along_y)] = Self::at(j);
            rows[0][x] += along_x * shape;
            rows[4][x] += along_x * slope;
            rows[1][y] += along_y * shape;
            rows[3][y] -= along_y * slope;
        }
        rows[2][2] = 1.0;
        let first = 5 + 2 * self.elastic();
        for j in 1..self.axial_shapes.ncols() {
            rows[2][first + j - 1] = self.axial_shapes[(node, j)];
        }
        rows
    }

    /// Returns mass, gyroscopic matrix and stiffness of the free rotor.
    #[must_use]
    pub fn matrices(&self) -> [DMatrix<f64>; 3] {
        let n = self.order();
        let mut mass = DMatrix::from_diagonal_element(n, n, self.mass);
        mass[(3, 3)] = self.diametral_inertia;
        mass[(4, 4)] = self.diametral_inertia;
        let mut stiffness = DMatrix::zeros(n, n);
        for (j, k) in self.stiffness.iter().enumerate() {
            for (at, _) in Self::at(j + RIGID) {
                stiffness[(at, at)] = *k;
            }
        }
        for (j, k) in self.axial_stiffness.iter().enumerate() {
            let at = 5 + 2 * self.elastic() + j;
            stiffness[(at, at)] = *k;
        }
        let mut gyroscopic = DMatrix::zeros(n, n);
        for i in 0..self.polar.nrows() {
            for j in 0..self.polar.ncols() {
                let [(xi, sx), (yi, sy)] = Self::at(i);
                let [(xj, tx), (yj, ty)] = Self::at(j);
                gyroscopic[(xi, yj)] += sx * ty * self.polar[(i, j)];
                gyroscopic[(yi, xj)] -= sy * tx * self.polar[(i, j)];
            }
        }
        [mass, gyroscopic, stiffness]
    }
}
