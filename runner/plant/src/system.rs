//! Coordinates and matrices of a scene's system.

use super::plant_error::{PlantError, Result, rejected};
use super::{Given, MAX_BEARINGS, MountedBearing};
use ballrace::rotor::{Attachment, RotorParams, SystemMatrices, supported_rotor};
use ballrace_models::build;
use ballrace_scene::flexible_rotor::ReducedRotor;
use ballrace_scene::{Bearing as BearingScene, Probe, Rotor, Scene, Support, Unbalance};
use nalgebra::{DMatrix, SMatrix};
use std::sync::Arc;

/// Coordinates of a rigid rotor.
pub const RIGID: usize = 5;

/// The rotor without its bearings.
pub(super) enum Body {
    /// A rigid rotor.
    Rigid,
    /// A flexible rotor in a few coordinates.
    Flexible(ReducedRotor),
    /// A system that the scene gives by its matrices.
    Given(Given),
}

/// The coordinates in order: those of the rotor, two of each support, one of each moving ball.
///
/// A rotor has five coordinates of its centre of mass first, a flexible one then its elastic coordinates.
#[derive(Clone)]
pub struct Layout {
    /// First coordinate of each bearing's moving balls, where it has them.
    pub balls: Vec<Option<usize>>,
    /// Number of coordinates.
    pub order: usize,
    /// Displacement of each bearing, inner ring against outer ring, per unit of each coordinate: a row for each of `u v w thu thv`.
    attachments: Arc<Vec<Rows>>,
    /// Number of coordinates of the rotor alone.
    rotor_order: usize,
    body: Arc<Body>,
    /// First coordinate of each bearing's support, where it has one.
    housings: Vec<Option<usize>>,
    supports: Vec<Support>,
}

/// Rows of a linear map to `u v w thu thv`.
pub type Rows = [Vec<f64>; 5];

impl Layout {
    /// Creates the layout of a scene with a rotor.
    pub(super) fn new(body: Body, bearings: &[BearingScene], mounted: &[MountedBearing]) -> Self {
        let rotor_order = match &body {
            Body::Rigid => RIGID,
            Body::Flexible(rotor) => rotor.order(),
            Body::Given(given) => given.order(),
        };
        let mut layout = Self {
            housings: vec![None; mounted.len()],
            balls: vec![None; mounted.len()],
            order: rotor_order,
            rotor_order,
            attachments: Arc::default(),
            supports: vec![],
            body: Arc::new(body),
        };
        if let Body::Given(given) = &*layout.body {
            layout.attachments = Arc::new(given.extended.clone());
            return layout;
        }
        let mut next = |count: usize| {
            let first = layout.order;
            layout.order += count;
            first
        };
        layout.housings = bearings.iter().map(|b| b.support.map(|_| next(2))).collect();
        layout.balls = mounted.iter().map(|s| s.balls.as_ref().map(|_| next(s.elements))).collect();
        layout.supports = bearings.iter().filter_map(|b| b.support).collect();
        let attachments = mounted.iter().zip(&layout.housings).map(|(bearing, housing)| {
            let mut rows = layout.rows(bearing.station);
            if let Some(first) = *housing {
                rows[0][first] -= 1.0;
                rows[1][first + 1] -= 1.0;
            }
            rows
        });
        layout.attachments = Arc::new(attachments.collect());
        layout
    }

    /// Returns true for the five coordinates of a rigid rotor alone.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.order == RIGID && matches!(*self.body, Body::Rigid)
    }

    /// Returns true where the rotor does not bend and no outer ring moves: the displacement of every bearing is on the rotor's straight line.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        matches!(*self.body, Body::Rigid) && self.supports.is_empty()
    }

    /// Returns true for a system that the scene gives by its matrices; the meaning of its coordinates is unknown.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.given().is_some()
    }

    /// Returns the system that the scene gives by its matrices, where it is one.
    #[must_use]
    pub fn given(&self) -> Option<&Given> {
        match &*self.body {
            Body::Given(given) => Some(given),
            _ => None,
        }
    }

    /// Returns the flexible rotor, where it is one.
    #[must_use]
    pub fn flexible(&self) -> Option<&ReducedRotor> {
        match &*self.body {
            Body::Flexible(rotor) => Some(rotor),
            _ => None,
        }
    }

    /// Returns the number of coordinates of the rotor, without those of supports and balls.
    #[must_use]
    pub const fn rotor_order(&self) -> usize {
        self.rotor_order
    }

    /// Returns the names of the coordinates: `u v w thu thv`, `bending_1_x`, `DE_support_u`, `DE_element_1`; of given matrices
    /// `q1`, `q2`.
    #[must_use]
    pub fn names(&self, mounted: &[MountedBearing]) -> Vec<String> {
        if self.is_given() {
            return (1..=self.order).map(|i| format!("q{i}")).collect();
        }
        let mut names: Vec<String> = ["u", "v", "w", "thu", "thv"].map(str::to_owned).to_vec();
        if let Body::Flexible(rotor) = &*self.body {
            names.extend((1..=rotor.elastic()).flat_map(|j| ["x", "y"].map(|along| format!("bending_{j}_{along}"))));
            names.extend((1..=rotor.axial_stiffness.len()).map(|j| format!("axial_{j}")));
        }
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

    /// Returns the displacement of the rotor at `station` per unit of each coordinate. For a system of matrices, that of its first
    /// bearing.
    #[must_use]
    pub fn rows(&self, station: f64) -> Rows {
        match &*self.body {
            Body::Given(given) => given.extended.first().cloned().unwrap_or_default(),
            Body::Flexible(rotor) => rotor.rows(station, self.order),
            Body::Rigid => {
                let mut rows: Rows = std::array::from_fn(|i| {
                    let mut row = vec![0.0; self.order];
                    row[i] = 1.0;
                    row
                });
                (rows[0][4], rows[1][3]) = (station, -station);
                rows
            }
        }
    }

    /// Returns the change of a probe's reading per unit of each coordinate.
    #[must_use]
    pub fn probe_row(&self, probe: &Probe) -> Vec<f64> {
        probe.row(&match &*self.body {
            Body::Given(given) => given.rows(&probe.coordinates.unwrap_or_default()),
            _ => self.rows(probe.station),
        })
    }

    /// Returns the displacement of bearing `i` per unit of each coordinate.
    #[must_use]
    pub fn attached(&self, i: usize) -> Option<&Rows> {
        self.attachments.get(i)
    }

    /// Returns the first coordinate of the support of bearing `i`, where it has one.
    #[must_use]
    pub(super) fn housing(&self, i: usize) -> Option<usize> {
        self.housings.get(i).copied().flatten()
    }

    /// Returns the attachment of bearing `i`.
    #[must_use]
    pub fn attachment<const D: usize>(&self, i: usize) -> Attachment<f64, D> {
        let entry = |row: usize, j: usize| self.attached(i).and_then(|rows| rows[row].get(j)).copied().unwrap_or(0.0);
        Attachment::new(&std::array::from_fn(|row| std::array::from_fn(|j| entry(row, j))))
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
        let mut scales = match (&*self.body, rotor) {
            (Body::Given(given), _) => given.scales(),
            (Body::Rigid, Some(rotor)) => self.rigid_rotor_in_supports(rotor)?,
            (Body::Flexible(reduced), Some(rotor)) => self.flexible_rotor_in_supports(reduced, rotor),
            (_, None) => return Err(PlantError::NoSystem),
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

    fn flexible_rotor_in_supports(&self, reduced: &ReducedRotor, rotor: &Rotor) -> Scales {
        let n = self.order;
        let whole = |part: DMatrix<f64>| {
            let mut whole = DMatrix::zeros(n, n);
            whole.view_mut((0, 0), part.shape()).copy_from(&part);
            whole
        };
        let [mut mass, gyroscopic, mut stiffness] = reduced.matrices().map(whole);
        let mut damping = DMatrix::zeros(n, n);
        let mut load = vec![0.0; n];
        let mut unbalance = vec![[0.0; 2]; n];
        if let Some(drawn) = &rotor.flexible {
            let [by_mass, by_stiffness] = drawn.proportional_damping;
            damping = by_mass * &mass + by_stiffness * &stiffness;
            for i in RIGID..self.rotor_order {
                damping[(i, i)] += 2.0 * drawn.modal_damping * (mass[(i, i)] * stiffness[(i, i)]).sqrt();
            }
        }
        add_loads(rotor, |station| self.rows(station), &mut load, &mut unbalance);
        for (i, load) in load.iter_mut().enumerate().take(3) {
            *load += rotor.gravity[i] * reduced.mass;
        }
        for i in 0..RIGID {
            damping[(i, i)] += rotor.damping[i];
            stiffness[(i, i)] += rotor.stiffness[i];
        }
        for (support, first) in self.supports.iter().zip(self.housings.iter().flatten()) {
            let at = *first;
            for i in [at, at + 1] {
                mass[(i, i)] = support.mass;
                damping[(i, i)] = support.damping;
                load[i] += rotor.gravity[i - at] * support.mass;
            }
            (stiffness[(at, at)], stiffness[(at + 1, at + 1)]) = support.stiffness.into();
            (stiffness[(at, at + 1)], stiffness[(at + 1, at)]) = (support.cross_stiffness, support.cross_stiffness);
        }
        Scales { mass, damping, gyroscopic, stiffness, load, unbalance }
    }

    fn rigid_rotor_in_supports(&self, rotor: &Rotor) -> Result<Scales> {
        /// Coordinates of a rigid rotor with a support under each of its bearings.
        const MOST: usize = RIGID + 2 * MAX_BEARINGS;
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

/// Adds load and unbalance of a rotor to those on its coordinates; `rows` is the displacement at a station per unit of each.
pub(super) fn add_loads(rotor: &Rotor, rows: impl Fn(f64) -> Rows, load: &mut [f64], unbalance: &mut [[f64; 2]]) {
    let (station, local) = rotor.local_load();
    for (row, force) in rows(station).iter().zip(local) {
        load.iter_mut().zip(row).for_each(|(load, shape)| *load += shape * force);
    }
    for given in &rotor.unbalance {
        let plane = SystemMatrices::<2>::unit_mass().with_unbalance((0, 1), given.moment, given.angle);
        for (row, [cos, sin]) in rows(given.station).iter().zip(plane.unbalance) {
            for (entry, shape) in unbalance.iter_mut().zip(row) {
                *entry = [entry[0] + shape * cos, entry[1] + shape * sin];
            }
        }
    }
}

/// A matrix of the kernel on the heap: with 128 coordinates it has 128 KiB.
pub(crate) type OnHeap<const D: usize> = Box<SMatrix<f64, D, D>>;

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

/// Rejects a scene with a system instead of a rotor.
///
/// # Errors
/// [`PlantError::NoRotorButSystem`] for a scene with a system.
pub fn only_rotor(scene: &Scene, command: &str) -> Result<()> {
    if scene.system.is_some() {
        return Err(PlantError::NoRotorButSystem { file: scene.path.clone(), command: command.to_owned() });
    }
    Ok(())
}

/// Rejects a scene whose motion cannot be compared with a recording: one with moving balls.
///
/// # Errors
/// [`PlantError::MovingBalls`] for a scene with a bearing of moving balls.
pub fn only_observable(scene: &Scene, command: &str) -> Result<()> {
    match scene.bearings.iter().find(|b| b.model.properties().moving_elements) {
        Some(b) => Err(PlantError::MovingBalls {
            file: scene.path.clone(),
            bearing: b.name.clone(),
            command: command.to_owned(),
        }),
        None => Ok(()),
    }
}

/// Returns a note where the unbalances of an elastic rotor on two bearings are in other planes than the two of observer and diagnosis.
#[must_use]
pub fn unbalance_note(scene: &Scene) -> Option<String> {
    let (rotor, [first, second]) = (scene.rotor.as_ref()?, scene.bearings.as_slice()) else { return None };
    let planes = unbalance_planes(rotor, [first.station, second.station]);
    let is_elastic = rotor.flexible.is_some() || scene.bearings.iter().any(|bearing| bearing.support.is_some());
    let is_in_one = |u: &Unbalance| u.moment == 0.0 || planes.iter().any(|z| (u.station - z).abs() < SAME_PLANE);
    if !is_elastic || rotor.unbalance.iter().all(is_in_one) {
        return None;
    }
    let [a, b] = planes.map(|z| scene.drawn_station(z) * 1e3);
    Some(format!(
        "The scene has unbalances in {} planes: observer, diagnosis and calibration move them into two, at {a:.1} and {b:.1} mm.",
        stations(&rotor.unbalance)
    ))
}

/// Returns the number of planes that are out of balance.
fn stations(unbalances: &[Unbalance]) -> usize {
    let mut all: Vec<f64> = unbalances.iter().filter(|u| u.moment != 0.0).map(|u| u.station).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_PLANE);
    all.len()
}

/// Distance within which unbalances are in one plane, m.
const SAME_PLANE: f64 = 1e-6;

/// Returns two planes for the unbalance of an elastic rotor: those of its largest unbalances, else of disks, else between the bearings.
#[must_use]
pub fn unbalance_planes(rotor: &Rotor, bearings: [f64; 2]) -> [f64; 2] {
    let mut unbalances: Vec<&Unbalance> = rotor.unbalance.iter().collect();
    unbalances.sort_by(|a, b| b.moment.total_cmp(&a.moment));
    let disks = rotor.flexible.iter().flat_map(|drawn| &drawn.disks).map(|d| d.station);
    let between = [0.75, 0.25].map(|share| bearings[0] + share * (bearings[1] - bearings[0]));
    let all: Vec<f64> = unbalances.iter().map(|u| u.station).chain(disks).chain(between).collect();
    let apart = 0.05 * (bearings[1] - bearings[0]).abs();
    let first = all[0];
    [first, all.iter().copied().find(|z| (z - first).abs() > apart).unwrap_or(first + apart)]
}

/// Returns the first `N` of `all`, the rest zero.
pub fn array<A: Copy + Default, const N: usize>(all: &[A]) -> [A; N] {
    std::array::from_fn(|i| all.get(i).copied().unwrap_or_default())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    #[test]
    fn unbalances_in_more_than_two_planes_are_noted() {
        let bearing = |name: &str, station: i32| {
            format!(
                "[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nmodel = \"linear\"\nelements = 8\ntwo_spring = {{ static_load = 10 }}\nball_diameter = \"12.3 mm\"\npitch_diameter = \"52 mm\"\ninner_conformity = 0.52\nouter_conformity = 0.52\ncontact_angle = \"15 deg\"\n"
            )
        };
        let note = |body: &str, unbalances: &[(f64, i32)]| {
            let unbalance = |(moment, station): &(f64, i32)| {
                format!("{{ moment = {moment}, angle = 0, station = \"{station} mm\" }}")
            };
            let unbalances: Vec<String> = unbalances.iter().map(unbalance).collect();
            let text = format!(
                "[shaft]\nspeed = \"3000 rpm\"\n[rotor]\n{body}\nunbalance = [{}]\n{}{}",
                unbalances.join(", "),
                bearing("A", 0),
                bearing("B", 500)
            );
            unbalance_note(&read_str(&text, Path::new("scene.toml")).unwrap())
        };
        let shaft = "sections = [{ from = \"0 mm\", to = \"500 mm\", outer_diameter = \"30 mm\" }]";
        let found = note(shaft, &[(1e-4, 100), (3e-4, 200), (2e-4, 400)]).unwrap();
        assert!(found.contains("in 3 planes") && found.contains("at 200.0 and 400.0 mm"), "{found}");
        for sound in [&[][..], &[(1e-4, 100)], &[(1e-4, 100), (2e-4, 400)], &[(1e-4, 100), (2e-4, 400), (0.0, 300)]] {
            assert_eq!(note(shaft, sound), None);
        }
        let near = note(shaft, &[(1e-4, 100), (2e-4, 110)]).unwrap();
        assert!(near.contains("in 2 planes"), "two planes too close for a couple: {near}");
        let rigid = "mass = 6\ndiametral_inertia = 0.03\npolar_inertia = 0.006";
        assert_eq!(note(rigid, &[(1e-4, 100), (3e-4, 200), (2e-4, 400)]), None);
    }
}
