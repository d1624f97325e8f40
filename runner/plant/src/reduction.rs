//! Number of elastic coordinates of a flexible rotor: the fewest with an allowed error.

use super::plant_error::Result;
use super::system::{Body, Rows, add_loads};
use super::{Layout, MAX_OBSERVED, MountedBearing, Plant};
use ballrace_base::eigenvalues::eigenvalues;
use ballrace_outcome::ALLOWED_REDUCTION_ERRORS;
use ballrace_scene::flexible_rotor::{ForceStations, FreeRotor, Modes, ReducedRotor};
use ballrace_scene::{Direction, FlexibleRotor, Rotor, Scene};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Largest number of elastic coordinates in each plane.
const MAX_ELASTIC: usize = 13;
/// Number of elastic coordinates in each plane that a rotor may have beside any number of supports and balls.
const ALWAYS_ELASTIC: usize = 5;
/// Natural frequency below which a direction is not held, Hz.
const HELD: f64 = 1.0;
/// Error over the error with one elastic coordinate less, above which that coordinate has changed nothing.
const UNCHANGED: f64 = 0.999;
/// Modes of the finite-element model in which the gyroscopic effect is computed: those up to this multiple of the highest line ...
const GYROSCOPIC_RANGE: f64 = 4.0;
/// ... and as many more.
const GYROSCOPIC_MODES: usize = 20;
/// Highest line of interest: harmonics of the shaft speed, and of the balls' pass over the inner race.
const SHAFT_HARMONICS: f64 = 20.0;
const PASS_HARMONICS: f64 = 3.0;

/// Error of a reduced rotor against its finite-element model, on the tangent stiffness of its bearings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReductionError {
    /// Number of coordinates of the finite-element model.
    pub full_coordinates: usize,
    /// Highest line of interest, Hz.
    pub highest_line: f64,
    /// Largest relative error of the natural frequencies up to it, at rest, at the nominal and at the highest speed.
    pub frequency: f64,
    /// Frequency below which all natural frequencies are within the allowed error, Hz.
    pub accurate_to: f64,
    /// Largest error of the static displacement of bearings and probes over the largest displacement.
    pub deflection: f64,
    /// Largest error of the response to the unbalance at the nominal speed, over the largest response.
    pub response: f64,
}

impl ReductionError {
    fn is_allowed(&self) -> bool {
        let all = [self.frequency, self.deflection, self.response];
        all.iter().zip(ALLOWED_REDUCTION_ERRORS).all(|(error, allowed)| *error <= allowed)
    }
}

/// Returns the reduction with the fewest elastic coordinates, or with those that the scene gives.
pub(super) fn first(scene: &Scene, rotor: &FlexibleRotor, mounted: &[MountedBearing]) -> Result<ReducedRotor> {
    let count = rotor.coordinates.map_or(1, |n| n.saturating_sub(5) / 2);
    reduced(scene, free(scene, rotor, mounted)?, mounted, (count, &[]))
}

/// Returns the reduction with the coordinates of another one of the same rotor.
pub(super) fn alike(
    scene: &Scene,
    rotor: &FlexibleRotor,
    mounted: &[MountedBearing],
    like: &ReducedRotor,
) -> Result<ReducedRotor> {
    reduced(scene, free(scene, rotor, mounted)?, mounted, (like.elastic(), &like.axial_forces))
}

/// Reduces the mesh of a rotor to `count` elastic coordinates in each plane, and one for the axial force at each of the stations `axial`.
fn reduced(
    scene: &Scene,
    free: Arc<FreeRotor>,
    mounted: &[MountedBearing],
    (count, axial): (usize, &[f64]),
) -> Result<ReducedRotor> {
    let radial: Vec<f64> = mounted.iter().map(|b| b.station).collect();
    let forces = ForceStations { radial: &radial, axial };
    Ok(ReducedRotor::try_new(free, count, forces, highest_line(scene, mounted))?)
}

/// Meshes a rotor.
fn free(scene: &Scene, rotor: &FlexibleRotor, mounted: &[MountedBearing]) -> Result<Arc<FreeRotor>> {
    Ok(Arc::new(FreeRotor::try_new(rotor, &stations(scene, rotor), highest_line(scene, mounted))?))
}

/// Returns the stations at which the displacement or a force is needed.
fn stations(scene: &Scene, rotor: &FlexibleRotor) -> Vec<f64> {
    let mut all: Vec<f64> = scene.bearings.iter().map(|b| b.station).collect();
    all.extend(scene.rotor.iter().flat_map(|r| &r.unbalance).map(|u| u.station));
    all.extend(radial_probes(scene));
    all.push(rotor.load_station);
    all
}

fn radial_probes(scene: &Scene) -> impl Iterator<Item = f64> {
    let probes = scene.recording.iter().flat_map(|r| &r.probes);
    probes.filter(|p| matches!(p.direction, Direction::Radial(_))).map(|p| p.station)
}

/// Returns the highest line of interest at the highest speed, Hz.
fn highest_line(scene: &Scene, mounted: &[MountedBearing]) -> f64 {
    let (from, to) = scene.shaft.speed.range();
    let orders = mounted.iter().map(|b| PASS_HARMONICS * b.kinematics.orders.inner_race.abs());
    let order = orders.fold(SHAFT_HARMONICS, f64::max);
    order * from.abs().max(to.abs()) / TAU
}

impl Plant {
    /// Returns the layout with `elastic` elastic coordinates in each plane of a flexible rotor; for another rotor the unchanged layout.
    ///
    /// # Errors
    /// A rotor that cannot be reduced.
    pub fn finer_layout(&self, scene: &Scene, elastic: usize) -> Result<Layout> {
        let Some(drawn) = scene.rotor.as_ref().and_then(|r| r.flexible.as_ref()) else {
            return Ok(self.layout.clone());
        };
        let free = free(scene, drawn, &self.bearings)?;
        let axial = self.layout.flexible().map_or(&[][..], |rotor| &rotor.axial_forces);
        let body = Body::Flexible(reduced(scene, free, &self.bearings, (elastic, axial))?);
        Ok(Layout::new(body, &scene.bearings, &self.bearings))
    }

    /// Adds elastic coordinates to a flexible rotor until its error is small.
    pub(super) fn refine(&mut self, scene: &Scene) -> Result<()> {
        let Some(drawn) = scene.rotor.as_ref().and_then(|r| r.flexible.as_ref()) else { return Ok(()) };
        let mut known = None;
        let mut axial = vec![];
        let mut before = f64::INFINITY;
        loop {
            let Some(rotor) = self.layout.flexible() else { return Ok(()) };
            let error = self.reduction_error(scene, rotor, &mut known)?;
            self.reduction = Some(error);
            let mut count = rotor.elastic();
            if drawn.coordinates.is_some() || error.is_allowed() {
                return Ok(());
            }
            // Coordinates of bending that leave the frequencies as they were do not help an axial motion.
            let held = self.axially_held(known.as_ref());
            if axial.is_empty() && !held.is_empty() && error.frequency > UNCHANGED * before {
                axial = held;
                count = count.saturating_sub(2);
            } else if count >= self.most_elastic(count) {
                return Ok(());
            }
            before = error.frequency;
            let free = rotor.free.clone();
            let body = Body::Flexible(reduced(scene, free, &self.bearings, (count + 1, &axial))?);
            self.layout = Layout::new(body, &scene.bearings, &self.bearings);
            self.damping = DMatrix::zeros(self.layout.order, self.layout.order);
            self.settle()?;
        }
    }

    /// Returns the stations of the bearings that hold the rotor along its axis.
    fn axially_held(&self, known: Option<&KnownModes>) -> Vec<f64> {
        let attached = self.bearings.iter().enumerate().filter(|(i, _)| self.layout.attached(*i).is_some());
        let tangents = known.into_iter().flat_map(|known| &known.tangents);
        let held = attached.zip(tangents).filter(|(_, tangent)| tangent[(2, 2)] > 0.0);
        held.map(|((_, bearing), _)| bearing.station).collect()
    }

    /// Returns the largest number of elastic coordinates in each plane, of which the plant has `count`: more would be too many for an
    /// observer.
    fn most_elastic(&self, count: usize) -> usize {
        let others = self.layout.order - 2 * count;
        (MAX_OBSERVED.saturating_sub(others) / 2).clamp(ALWAYS_ELASTIC, MAX_ELASTIC)
    }

    /// Compares the reduced rotor with the finite-element model, both on the bearings' tangents at equilibrium.
    ///
    /// The modes of the finite-element model in `known` are used again where the tangents of the bearings have hardly changed.
    fn reduction_error(
        &self,
        scene: &Scene,
        rotor: &ReducedRotor,
        known: &mut Option<KnownModes>,
    ) -> Result<ReductionError> {
        let full = Full::new(self, scene, rotor)?;
        let scales = self.scales()?;
        let highest_line = highest_line(scene, &self.bearings);
        let n = self.layout.order;
        let small = [&scales.mass, &self.stiffness].map(symmetric);
        let few = Modes::try_new(&small[0], &small[1])?;
        let many = match known.take().filter(|known| known.are_near(&full.tangents)) {
            Some(known) => known,
            None => {
                let whole = [&full.mass, &full.stiffness].map(symmetric);
                KnownModes { modes: Modes::try_new(&whole[0], &whole[1])?, tangents: full.tangents.clone() }
            }
        };
        let many = &known.insert(many).modes;
        let (from, to) = scene.shaft.speed.range();
        let mut speeds = vec![0.0, self.speed.abs(), from.abs().max(to.abs())];
        speeds.dedup();
        let (mut frequency, mut accurate_to) = (0.0_f64, highest_line);
        for speed in speeds {
            let whirl =
                |modes: &Modes, gyroscopic: &DMatrix<f64>| whirl_frequencies(modes, gyroscopic, speed, highest_line);
            let (few, many) = (whirl(&few, &scales.gyroscopic)?, whirl(many, &full.gyroscopic)?);
            let of_interest = many.iter().take_while(|of_full| **of_full < highest_line).enumerate();
            // A mode that the reduced rotor lacks has no frequency.
            for (i, of_full) in of_interest {
                let error = few.get(i).map_or(1.0, |few| (few / of_full - 1.0).abs());
                frequency = frequency.max(error);
                if error > ALLOWED_REDUCTION_ERRORS[0] {
                    accurate_to = accurate_to.min(*of_full);
                }
            }
        }
        let load = DVector::from_vec(scales.load.clone());
        let deflected = self.stiffness.clone().lu().solve(&load).unwrap_or_else(|| DVector::zeros(n));
        let deflected_full = full.stiffness.clone().lu().solve(&full.load);
        let deflection = deflected_full.map_or(0.0, |all| {
            let points = full.points.iter().zip(&full.observed);
            let radial = |rows: &Rows, q: &DVector<f64>| [0, 1].map(|i| product(&rows[i], q));
            difference(points.flat_map(|(whole, own)| {
                let (whole, own) = (radial(whole, &all), radial(own, &deflected));
                [0, 1].map(|i| (Complex::from(whole[i]), Complex::from(own[i])))
            }))
        });
        let speed = self.speed;
        let small_response =
            response([&scales.mass, &scales.damping, &scales.gyroscopic, &self.stiffness], &scales.unbalance, speed);
        let full_response =
            response([&full.mass, &full.damping, &full.gyroscopic, &full.stiffness], &full.unbalance, speed);
        let response = difference(full.points.iter().zip(&full.observed).flat_map(|(whole, own)| {
            [0, 1].map(|i| (complex_product(&whole[i], &full_response), complex_product(&own[i], &small_response)))
        }));
        Ok(ReductionError {
            full_coordinates: full.mass.nrows() - (n - self.layout.rotor_order()),
            highest_line,
            frequency,
            accurate_to,
            deflection,
            response,
        })
    }
}

/// Returns the natural frequencies of the held directions with the gyroscopic effect at `speed` (rad/s), Hz, lowest first.
///
/// The system of `modes` is projected on those up to a multiple of `highest` (Hz), because the others hardly change them.
fn whirl_frequencies(modes: &Modes, gyroscopic: &DMatrix<f64>, speed: f64, highest: f64) -> Result<Vec<f64>> {
    let n = modes.squares.len();
    let near = modes.frequencies(0).take_while(|f| *f < GYROSCOPIC_RANGE * highest).count();
    let kept = n.min(near + GYROSCOPIC_MODES);
    if speed == 0.0 {
        return Ok(modes.frequencies(0).take(kept).filter(|f| *f > HELD).collect());
    }
    let shapes = modes.shapes.columns(0, kept);
    let coupling = speed * shapes.transpose() * gyroscopic * shapes;
    let mut system = DMatrix::zeros(2 * kept, 2 * kept);
    system.view_mut((0, kept), (kept, kept)).fill_with_identity();
    for i in 0..kept {
        system[(kept + i, i)] = -modes.squares[i];
    }
    system.view_mut((kept, kept), (kept, kept)).copy_from(&(-coupling));
    let mut all: Vec<f64> = eigenvalues(&system)?.iter().map(|value| value.im / TAU).filter(|f| *f > HELD).collect();
    all.sort_by(f64::total_cmp);
    Ok(all)
}

/// Returns the largest difference of the pairs over the largest of their first values.
fn difference(pairs: impl Iterator<Item = (Complex<f64>, Complex<f64>)>) -> f64 {
    let (mut off, mut largest) = (0.0, 0.0);
    for (whole, own) in pairs {
        (off, largest) = (f64::max(off, (whole - own).norm()), f64::max(largest, whole.norm()));
    }
    if largest > 0.0 { off / largest } else { 0.0 }
}

fn product(row: &[f64], q: &DVector<f64>) -> f64 {
    row.iter().zip(q.iter()).map(|(a, x)| a * x).sum()
}

fn complex_product(row: &[f64], q: &DVector<Complex<f64>>) -> Complex<f64> {
    row.iter().zip(q.iter()).map(|(a, x)| x * *a).sum()
}

fn symmetric(m: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (m + m.transpose())
}

/// Returns the complex amplitude of the response to the unbalance at `speed` (rad/s).
pub fn response(
    [mass, damping, gyroscopic, stiffness]: [&DMatrix<f64>; 4],
    unbalance: &[[f64; 2]],
    speed: f64,
) -> DVector<Complex<f64>> {
    let n = mass.nrows();
    let dynamic = DMatrix::from_fn(n, n, |i, j| {
        Complex::new(
            stiffness[(i, j)] - speed * speed * mass[(i, j)],
            speed * (damping[(i, j)] + speed * gyroscopic[(i, j)]),
        )
    });
    // w^2 (c cos + s sin) is the real part of w^2 (c - i s) e^(i w t).
    let force = DVector::from_fn(n, |i, _| speed * speed * Complex::new(unbalance[i][0], -unbalance[i][1]));
    dynamic.lu().solve(&force).unwrap_or_else(|| DVector::zeros(n))
}

/// Modes of the finite-element model on the bearings' tangents.
struct KnownModes {
    modes: Modes,
    tangents: Vec<DMatrix<f64>>,
}

impl KnownModes {
    /// Returns true where `tangents` change the frequencies by less than a hundredth of the allowed error.
    fn are_near(&self, tangents: &[DMatrix<f64>]) -> bool {
        // A frequency changes by at most half as much as its stiffness.
        let share = 2.0 * 0.01 * ALLOWED_REDUCTION_ERRORS[0];
        self.tangents.len() == tangents.len()
            && self.tangents.iter().zip(tangents).all(|(a, b)| (a - b).norm() <= share * b.norm())
    }
}

/// The finite-element model on the tangents of the bearings: coordinates of both planes, along the axis, then supports and balls.
struct Full {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    gyroscopic: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    load: DVector<f64>,
    unbalance: Vec<[f64; 2]>,
    /// Displacement at bearings and radial probes by its coordinates, and by those of the reduced rotor.
    points: Vec<Rows>,
    observed: Vec<Rows>,
    /// Tangent stiffness of each bearing.
    tangents: Vec<DMatrix<f64>>,
}

impl Full {
    fn new(plant: &Plant, scene: &Scene, reduced: &ReducedRotor) -> Result<Self> {
        let mesh = &reduced.free.mesh;
        let nodes = mesh.stations.len();
        let (own, first) = (5 * nodes, plant.layout.rotor_order());
        let n = own + plant.layout.order - first;
        let scales = plant.scales()?;
        // Supports and balls have the same equations in both models.
        let whole = |part: &DMatrix<f64>| {
            let mut whole = DMatrix::zeros(n, n);
            let rest = plant.layout.order - first;
            whole.view_mut((own, own), (rest, rest)).copy_from(&part.view((first, first), (rest, rest)));
            whole
        };
        let [mut mass, mut damping, mut gyroscopic] = [&scales.mass, &scales.damping, &scales.gyroscopic].map(whole);
        let mut stiffness = whole(&scales.stiffness);
        for (i, j) in (0..2 * nodes).flat_map(|i| (0..2 * nodes).map(move |j| (i, j))) {
            for plane in [0, 2 * nodes] {
                mass[(plane + i, plane + j)] = mesh.mass[(i, j)];
                stiffness[(plane + i, plane + j)] = mesh.stiffness[(i, j)];
            }
            gyroscopic[(i, 2 * nodes + j)] = mesh.polar[(i, j)];
            gyroscopic[(2 * nodes + i, j)] = -mesh.polar[(i, j)];
        }
        for (i, j) in (0..nodes).flat_map(|i| (0..nodes).map(move |j| (i, j))) {
            mass[(4 * nodes + i, 4 * nodes + j)] = mesh.axial_mass[(i, j)];
            stiffness[(4 * nodes + i, 4 * nodes + j)] = mesh.axial_stiffness[(i, j)];
        }
        let rows = |station: f64| {
            let node = mesh.node(station);
            let mut rows: Rows = std::array::from_fn(|_| vec![0.0; n]);
            (rows[0][2 * node], rows[4][2 * node + 1]) = (1.0, 1.0);
            (rows[1][2 * nodes + 2 * node], rows[3][2 * nodes + 2 * node + 1]) = (1.0, -1.0);
            rows[2][4 * nodes + node] = 1.0;
            rows
        };
        let mut load = DVector::zeros(n);
        let mut unbalance = vec![[0.0; 2]; n];
        if let Some(rotor) = &scene.rotor
            && let Some(drawn) = &rotor.flexible
        {
            let [by_mass, by_stiffness] = drawn.proportional_damping;
            for (i, j) in (0..own).flat_map(|i| (0..own).map(move |j| (i, j))) {
                damping[(i, j)] = by_mass * mass[(i, j)] + by_stiffness * stiffness[(i, j)];
            }
            let mut uniform = [DVector::zeros(n), DVector::zeros(n), DVector::zeros(n)];
            for node in 0..nodes {
                uniform[0][2 * node] = rotor.gravity[0];
                uniform[1][2 * nodes + 2 * node] = rotor.gravity[1];
                uniform[2][4 * nodes + node] = rotor.gravity[2];
            }
            for one in uniform {
                load += &mass * one;
            }
            add_loads(rotor, rows, load.as_mut_slice(), &mut unbalance);
            add_own(reduced, rotor, drawn, &mass, [&mut damping, &mut stiffness]);
        }
        let rest = plant.layout.order - first;
        load.rows_mut(own, rest).copy_from_slice(&scales.load[first..]);
        let mut points = vec![];
        let mut observed = vec![];
        let mut tangents = vec![];
        for (i, bearing) in plant.bearings.iter().enumerate() {
            let mut at = rows(bearing.station);
            let Some(own_rows) = plant.layout.attached(i) else { continue };
            for (row, of) in at.iter_mut().zip(own_rows) {
                row[own..].copy_from_slice(&of[first..]);
            }
            let u = plant.displacement(i, &plant.rest);
            let state = plant.resting(bearing, ballrace::Phase::ZERO);
            let (_, tangent) = ballrace::bearing::Bearing::reaction_and_stiffness(&bearing.bearing, &u, &state);
            let map = DMatrix::from_fn(at.len(), n, |i, j| at[i][j]);
            let tangent = DMatrix::from_fn(at.len(), at.len(), |i, j| tangent[(i, j)]);
            stiffness += map.transpose() * &tangent * &map;
            tangents.push(tangent);
            points.push(at);
            observed.push(own_rows.clone());
        }
        for station in radial_probes(scene) {
            points.push(rows(station));
            observed.push(plant.layout.rows(station));
        }
        Ok(Self { mass, damping, gyroscopic, stiffness, load, unbalance, points, observed, tangents })
    }
}

/// Adds modal damping, and the rotor's own dampers and springs on its rigid motion, to a finite-element model: matrices on the
/// amplitudes `a = M phi x / m` of shapes with the modal mass `m`.
fn add_own(
    reduced: &ReducedRotor,
    rotor: &Rotor,
    drawn: &FlexibleRotor,
    mass: &DMatrix<f64>,
    [damping, stiffness]: [&mut DMatrix<f64>; 2],
) {
    let (free, nodes) = (&reduced.free, reduced.free.mesh.stations.len());
    let n = mass.nrows();
    let mut add = |shape: DVector<f64>, modal: f64, [c, k]: [f64; 2]| {
        let momentum = mass * shape / modal;
        let square = &momentum * momentum.transpose();
        *damping += c * &square;
        *stiffness += k * square;
    };
    // A shape of one plane, along X (0) or Y (1), and of the axis.
    let in_plane = |plane: usize, of: &dyn Fn(usize) -> f64| {
        DVector::from_fn(n, |i, _| i.checked_sub(2 * nodes * plane).filter(|i| *i < 2 * nodes).map_or(0.0, of))
    };
    let along = |of: &dyn Fn(usize) -> f64| {
        DVector::from_fn(n, |i, _| i.checked_sub(4 * nodes).filter(|i| *i < nodes).map_or(0.0, of))
    };
    let ratio = 2.0 * drawn.modal_damping;
    if ratio > 0.0 {
        for (j, square) in free.bending.squares.iter().enumerate().skip(2) {
            for plane in [0, 1] {
                add(in_plane(plane, &|i| free.bending.shapes[(i, j)]), 1.0, [ratio * square.sqrt(), 0.0]);
            }
        }
        for (j, square) in free.axial.squares.iter().enumerate().skip(1) {
            add(along(&|i| free.axial.shapes[(i, j)]), 1.0, [ratio * square.sqrt(), 0.0]);
        }
    }
    let own = |i: usize| [rotor.damping[i], rotor.stiffness[i]];
    let moved = |i: usize| if i.is_multiple_of(2) { 1.0 } else { 0.0 };
    let turned = |i: usize| if i.is_multiple_of(2) { free.mesh.stations[i / 2] } else { 1.0 };
    for (i, plane) in [(0, 0), (1, 1)] {
        add(in_plane(plane, &moved), reduced.mass, own(i));
    }
    add(along(&|_| 1.0), reduced.mass, own(2));
    // The tilt about X is along Y.
    for (i, plane) in [(4, 0), (3, 1)] {
        add(in_plane(plane, &turned), reduced.diametral_inertia, own(i));
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    const SCENE: &str = r#"
        [shaft]
        speed = "3400 rpm"
        [rotor]
        sections = [
          { from = "0 mm", to = "60 mm", outer_diameter = "25 mm" },
          { from = "60 mm", to = "420 mm", outer_diameter = "30 mm" },
          { from = "420 mm", to = "480 mm", outer_diameter = "25 mm" },
        ]
        disks = [{ station = "200 mm", mass = "5 kg", diametral_inertia = 0.008, polar_inertia = 0.014 }]
        proportional_damping = { mass = "60 1/s", stiffness = "2e-6 s" }
        unbalance = [{ moment = "50 g mm", angle = "30 deg", station = "200 mm" }]
        [[bearing]]
        name = "DE"
        station = "30 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 6e7, 0, 0, 0], [0, 0, 1e5, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]
        [[bearing]]
        name = "NDE"
        station = "450 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 6e7, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]
    "#;

    fn error(coordinates: &str) -> (ReductionError, usize) {
        let text = SCENE.replace("unbalance =", &format!("{coordinates}\nunbalance ="));
        let plant = Plant::try_new(&read_str(&text, Path::new("scene.toml")).unwrap()).unwrap();
        (plant.reduction.unwrap(), plant.layout.order)
    }

    /// The fewest coordinates with the allowed error are taken, and more of them have a smaller one.
    #[test]
    fn as_many_coordinates_as_the_scene_requires() {
        let (chosen, order) = error("");
        assert!(chosen.is_allowed(), "{chosen:?}");
        let (fewer, _) = error(&format!("coordinates = {}", order - 2));
        assert!(!fewer.is_allowed(), "{fewer:?}");
        assert!(
            fewer.accurate_to < fewer.highest_line && chosen.accurate_to == chosen.highest_line,
            "{fewer:?} {chosen:?}"
        );
        let (more, _) = error("coordinates = 25");
        assert!(more.frequency < chosen.frequency && more.frequency < 1e-4, "{more:?}");
        assert!(more.deflection < 2e-3 && more.response < 2e-3, "{more:?}");
    }

    /// A slender overhung shaft that two bearings hold along its axis: where coordinates of bending do not help, the axial motion has some.
    #[test]
    fn an_axial_motion_has_coordinates_of_its_own() {
        let text = r#"
            [shaft]
            speed = "600 rpm"
            [rotor]
            sections = [
              { from = 0, to = 0.7, outer_diameter = 0.025 },
              { from = 0.7, to = 0.9, outer_diameter = 0.030 },
            ]
            disks = [
              { station = 0.35, mass = 15, diametral_inertia = 0.06, polar_inertia = 0.115 },
              { station = 0.88, mass = 6, diametral_inertia = 0.018, polar_inertia = 0.034 },
            ]
            [[bearing]]
            name = "a"
            station = 0.05
            model = "linear"
            elements = 9
            stiffness_matrix = [[2e7,0,0,0,0],[0,3e7,0,0,0],[0,0,1e7,0,0],[0,0,0,0,0],[0,0,0,0,0]]
            [[bearing]]
            name = "b"
            station = 0.65
            model = "linear"
            elements = 9
            stiffness_matrix = [[5e7,0,0,0,0],[0,4e7,0,0,0],[0,0,1e7,0,0],[0,0,0,0,0],[0,0,0,0,0]]
        "#;
        let plant = Plant::try_new(&read_str(text, Path::new("scene.toml")).unwrap()).unwrap();
        let error = plant.reduction.unwrap();
        assert!(error.frequency < 1e-3 && error.is_allowed(), "{error:?}");
        assert!(!plant.layout.flexible().unwrap().axial_stiffness.is_empty());
    }

    /// Two bearings beside each other at one station, as a pair or two rows are often drawn.
    #[test]
    fn bearings_at_one_station_are_one_place() {
        let (_, second) = SCENE.rsplit_once("[[bearing]]").unwrap();
        let text = format!("{SCENE}\n[[bearing]]{}", second.replace("\"NDE\"", "\"other\""));
        let plant = Plant::try_new(&read_str(&text, Path::new("scene.toml")).unwrap()).unwrap();
        assert!(plant.reduction.unwrap().is_allowed());
    }

    /// Damping of the modes and springs and dampers on the rotor are in the finite-element model too: with many coordinates no error is
    /// left.
    #[test]
    fn dampers_and_springs_of_the_rotor_are_in_both_models() {
        for own in [
            "modal_damping = 0.02",
            "damping = [\"3e3 N s/m\", \"3e3 N s/m\", 0, \"30 N m s/rad\", \"30 N m s/rad\"]",
            "stiffness = [\"2e7 N/m\", \"1e7 N/m\", \"1e5 N/m\", \"1e5 N m/rad\", \"2e5 N m/rad\"]",
        ] {
            let (error, _) = error(&format!("coordinates = 25\n{own}"));
            assert!(error.frequency < 1e-3 && error.deflection < 2e-3 && error.response < 2e-3, "{own}: {error:?}");
        }
    }

    /// Returns the largest displacement of the disk about its static position (m), the speed at which it occurs, and the lowest
    /// natural frequency above 50 Hz (rad/s), in a run from 50 to 200 Hz over 3 s.
    fn run_up(coordinates: &str) -> (f64, [f64; 2]) {
        const PERIOD: f64 = 1.0 / 12_800.0;
        let text = SCENE.replace("unbalance =", &format!("{coordinates}\nunbalance ="));
        // Implicit with a given step: the highest frequencies of many coordinates do not limit it.
        let text = format!("{text}\n[integration]\nmethod = \"newmark\"\nstep = \"78.125 us\"\n");
        let scene = read_str(&text, Path::new("scene.toml")).unwrap();
        let plant = Plant::try_new(&scene).unwrap();
        let [from, to] = [50.0, 200.0].map(|hz: f64| hz * TAU);
        let frequencies = plant.frequency_squares().unwrap().into_iter().map(|square| square.re.max(0.0).sqrt());
        let lowest = frequencies.filter(|frequency| *frequency > from).fold(f64::INFINITY, f64::min);
        let disk = plant.layout.rows(scene.rotor.as_ref().unwrap().unbalance[0].station);
        let mut twin = plant.start(PERIOD, 0.0).unwrap();
        let acceleration = (to - from) / 3.0;
        let mut shaft = ballrace::rotor::ShaftMotion { angle: ballrace::Phase::ZERO, speed: from, acceleration };
        let mut peak = (0.0, from);
        while shaft.speed < to {
            twin.step(&shaft);
            shaft = shaft.after(PERIOD);
            let moved: Vec<f64> = twin.coordinates().iter().zip(&plant.rest).map(|(q, rest)| q - rest).collect();
            let [x, y] = [0, 1].map(|i: usize| disk[i].iter().zip(&moved).map(|(row, q)| row * q).sum::<f64>());
            let radius = x.hypot(y);
            if radius > peak.0 {
                peak = (radius, shaft.speed);
            }
        }
        (peak.0, [peak.1, lowest])
    }

    #[test]
    fn a_reduced_rotor_passes_its_first_critical_speed_as_one_of_31_coordinates_does() {
        let (few, [speed, lowest]) = run_up("");
        let (many, [speed_of_many, _]) = run_up("coordinates = 31");
        assert!((few / many - 1.0).abs() < 0.01, "{few} {many} m");
        assert!((speed / speed_of_many - 1.0).abs() < 0.01, "{speed} {speed_of_many} rad/s");
        // A few percent above it, by damping and by the acceleration.
        assert!((0.98..1.1).contains(&(speed / lowest)), "{speed} {lowest} rad/s");
        assert!(few > 1e-5, "{few} m");
    }
}
