//! Coordinates and matrices of a scene's system.

use super::error::{PlantError, Result, rejected};
use super::{Given, MOST_BEARINGS, MountedBearing};
use crate::scene::{Bearing as BearingScene, Rotor, Scene, Support, build};
use ballrace::rotor::{Attachment, RotorParams, SystemMatrices, supported_rotor};
use nalgebra::{DMatrix, SMatrix};
use std::sync::Arc;

/// Coordinates of a rigid rotor.
pub const RIGID: usize = 5;

/// The coordinates in order: five of the rotor, two of each support, one of each moving ball.
#[derive(Clone)]
pub struct Layout {
    /// First coordinate of each bearing's support, where it has one.
    pub housings: Vec<Option<usize>>,
    /// First coordinate of each bearing's moving balls, where it has them.
    pub balls: Vec<Option<usize>>,
    /// Number of coordinates.
    pub order: usize,
    /// The system, where the scene gives its matrices instead of a rotor.
    pub given: Option<Arc<Given>>,
    supports: Vec<Support>,
}

impl Layout {
    /// Creates the layout of a scene with a rigid rotor.
    pub fn new(bearings: &[BearingScene], mounted: &[MountedBearing]) -> Self {
        let mut order = RIGID;
        let mut next = |count: usize| {
            let first = order;
            order += count;
            first
        };
        let housings = bearings.iter().map(|b| b.support.map(|_| next(2))).collect();
        let balls = mounted.iter().map(|s| s.balls.as_ref().map(|_| next(s.elements))).collect();
        let supports = bearings.iter().filter_map(|b| b.support).collect();
        Self { housings, balls, order, given: None, supports }
    }

    /// Creates the layout of a scene with matrices.
    pub fn given(given: Given, bearings: usize) -> Self {
        let none = vec![None; bearings];
        let order = given.order();
        Self { housings: none.clone(), balls: none, order, given: Some(Arc::new(given)), supports: vec![] }
    }

    /// Returns true for the five coordinates of a rigid rotor alone.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.order == RIGID && self.given.is_none()
    }

    /// Returns the names of the coordinates: `u v w thu thv`, `DE_support_u`, `DE_element_1`; of given matrices `q1`, `q2`.
    #[must_use]
    pub fn names(&self, mounted: &[MountedBearing]) -> Vec<String> {
        if self.given.is_some() {
            return (1..=self.order).map(|i| format!("q{i}")).collect();
        }
        let mut names: Vec<String> = ["u", "v", "w", "thu", "thv"].map(str::to_owned).to_vec();
        for (mounted, housing) in mounted.iter().zip(&self.housings) {
            if housing.is_some() {
                names.extend(["u", "v"].map(|along| format!("{}_support_{along}", mounted.name)));
            }
        }
        for (mounted, first) in mounted.iter().zip(&self.balls) {
            if first.is_some() {
                names.extend((1..=mounted.elements).map(|j| format!("{}_element_{j}", mounted.name)));
            }
        }
        names
    }

    /// Returns the attachment of bearing `i` at `station`.
    #[must_use]
    pub fn attachment<const D: usize>(&self, i: usize, station: f64) -> Attachment<f64, D> {
        if let Some(extended) = self.given.as_ref().and_then(|given| given.extended.get(i)) {
            let row = |k: usize| std::array::from_fn(|j| extended[k].get(j).copied().unwrap_or(0.0));
            return Attachment::new(&std::array::from_fn(row));
        }
        Attachment::on_rigid_rotor(station, self.housings.get(i).copied().flatten())
    }

    /// Returns the system's matrices for `D` coordinates, with the damping matrix `extra` besides the scene's own.
    /// Coordinates beyond the system's are idle: a mass of 1 and nothing else.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter or the system has more coordinates.
    pub fn matrices<const D: usize>(
        &self,
        rotor: Option<&Rotor>,
        mounted: &[MountedBearing],
        extra: &DMatrix<f64>,
    ) -> Result<SystemMatrices<D, OnHeap<D>>> {
        if self.order > D {
            return Err(PlantError::Coordinates { found: self.order, most: D });
        }
        let scales = self.scales(rotor, mounted, extra)?;
        Ok(SystemMatrices {
            mass: on_heap(&scales.mass, 1.0),
            damping: on_heap(&scales.damping, 0.0),
            gyroscopic: on_heap(&scales.gyroscopic, 0.0),
            stiffness: on_heap(&scales.stiffness, 0.0),
            load: array(&scales.load),
            unbalance: array(&scales.unbalance),
        })
    }

    /// Returns the system's matrices in its own size.
    ///
    /// # Errors
    /// As [`Layout::matrices`].
    pub fn scales(&self, rotor: Option<&Rotor>, mounted: &[MountedBearing], extra: &DMatrix<f64>) -> Result<Scales> {
        let mut scales = match (&self.given, rotor) {
            (Some(given), _) => given.scales(),
            (None, Some(rotor)) => self.rigid_rotor_in_supports(rotor)?,
            (None, None) => return Err(PlantError::NoSystem),
        };
        for (mounted, first) in mounted.iter().zip(&self.balls) {
            let (Some(balls), Some(first)) = (&mounted.balls, *first) else { continue };
            for i in first..first + mounted.elements {
                scales.mass[(i, i)] = balls.params.ball_mass;
                scales.damping[(i, i)] = balls.damping;
            }
        }
        scales.damping += extra;
        Ok(scales)
    }

    fn rigid_rotor_in_supports(&self, rotor: &Rotor) -> Result<Scales> {
        /// Coordinates of a rigid rotor with a support under each of its bearings.
        const MOST: usize = RIGID + 2 * MOST_BEARINGS;
        let supports: Vec<ballrace::rotor::Support> = self.supports.iter().map(build::support).collect();
        let params: RotorParams = build::rotor_params(rotor);
        let all: SystemMatrices<MOST> =
            supported_rotor(&params, &build::unbalances(rotor), &supports).map_err(rejected("[rotor]"))?;
        let part = |from: &SMatrix<f64, MOST, MOST>, idle: f64| {
            let entry = |i, j| from.get((i, j)).map_or(if i == j { idle } else { 0.0 }, |&x: &f64| x);
            DMatrix::from_fn(self.order, self.order, entry)
        };
        let (mut load, mut unbalance) = (all.load.to_vec(), all.unbalance.to_vec());
        load.resize(self.order, 0.0);
        unbalance.resize(self.order, [0.0; 2]);
        Ok(Scales {
            mass: part(&all.mass, 1.0),
            damping: part(&all.damping, 0.0),
            gyroscopic: part(&all.gyroscopic, 0.0),
            stiffness: part(&all.stiffness, 0.0),
            load,
            unbalance,
        })
    }
}

/// A matrix of the kernel on the heap: with 128 coordinates it has 128 KiB.
pub type OnHeap<const D: usize> = Box<SMatrix<f64, D, D>>;

/// Returns the matrix `from` with `idle` on the rest of its diagonal. Not inlined, so that the stack of its caller does not hold
/// several matrices at once.
#[inline(never)]
fn on_heap<const D: usize>(from: &DMatrix<f64>, idle: f64) -> OnHeap<D> {
    let entry = |i, j| from.get((i, j)).map_or(if i == j { idle } else { 0.0 }, |&x: &f64| x);
    Box::new(SMatrix::from_fn(entry))
}

/// Matrices of a system.
pub struct Scales {
    /// M.
    pub mass: DMatrix<f64>,
    /// B with the proportional damping.
    pub damping: DMatrix<f64>,
    /// G.
    pub gyroscopic: DMatrix<f64>,
    /// K without the bearings.
    pub stiffness: DMatrix<f64>,
    /// Weight and constant load on each coordinate.
    pub load: Vec<f64>,
    /// Unbalance on each coordinate, as in [`SystemMatrices::unbalance`].
    pub unbalance: Vec<[f64; 2]>,
}

/// Rejects a scene whose system has more than the five coordinates of a rigid rotor.
///
/// # Errors
/// Such a scene.
pub fn only_rigid(scene: &Scene, command: &str) -> Result<()> {
    if scene.system.is_some() {
        return Err(PlantError::SystemNotRigid { file: scene.path.clone(), command: command.to_owned() });
    }
    let more = |b: &&BearingScene| b.support.is_some() || b.model == crate::scene::Model::Dynamic;
    match scene.bearings.iter().find(more) {
        Some(b) => Err(PlantError::BearingNotRigid {
            file: scene.path.clone(),
            bearing: b.name.clone(),
            command: command.to_owned(),
        }),
        None => Ok(()),
    }
}

/// Returns the first `N` of `all`, the rest zero.
pub(super) fn array<A: Copy + Default, const N: usize>(all: &[A]) -> [A; N] {
    std::array::from_fn(|i| all.get(i).copied().unwrap_or_default())
}
