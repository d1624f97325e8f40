//! Motion of the rotor between probes, bearings and unbalance, line by line.
//!
//! The probes measure a pose: the straight line through their planes. With `q` the coordinates of the rotor without its bearings,
//! `Z q = sum T_i^T F_i` and `alpha = Z^-1`, the pose is `S q`. A force and moment `f` about the centre of mass that acts through two
//! bearings, `q = alpha P f`, moves it by `alpha_5 f`, with `alpha_5 = S alpha P`. So
//!
//! - `Z_5 = alpha_5^-1` is the force that a pose requires,
//! - `Z_5 S alpha T^T` converts a force at another station to the force with the same effect on the pose,
//! - `T alpha P Z_5` is the displacement at a bearing by the pose, and `T alpha (1 - P Z_5 S alpha) T_s^T` that by a load at s while the
//!   pose stays.
//!
//! For a rigid rotor on fixed bearings all of these are constant but for the inertia.

use super::motion::{C, D};
use ballrace::Displacement;
use ballrace_plant::probes::PoseSolver;
use ballrace_plant::{Layout, Plant, PlantError, Rows, unbalance_planes};
use ballrace_scene::{Probe, Rotor, Scene, load_at};
use nalgebra::{DMatrix, SMatrix, SVector};
use rustfft::FftPlanner;

pub type Square = SMatrix<C, D, D>;
/// Stiffness of one bearing at its own station.
pub type Tangent = SMatrix<f64, D, D>;

/// Elastic coordinates in each plane: modes up to several times the highest line.
const ELASTIC: usize = 10;
/// Lowest frequency over the distance of the lines: a free rotor has no static compliance.
const LOWEST: f64 = 0.1;
/// Step of a derivative, over the distance of the lines.
const STEP: f64 = 1e-3;

/// Force of a misaligned coupling on the shaft, once and twice per turn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CouplingForce {
    /// Once and twice per turn: cosine and sine along X, then along Y, N.
    pub force: [[f64; 4]; 2],
    /// Station from the centre of mass, m.
    pub station: f64,
}

/// A matrix by line, or one for all lines of a rigid rotor.
type ByLine = Vec<Square>;

/// Force and displacement relations between stations of the rotor.
pub struct Dynamics {
    /// Effect of a wrench at each bearing as one about the centre of mass.
    bearings: Vec<ByLine>,
    /// Displacement of each bearing by the pose.
    by_pose: Vec<ByLine>,
    inertia: Inertia,
    /// Terms of a rotor that is flexible or on elastic supports.
    elastic: Option<Elastic>,
}

/// Force that a pose requires.
enum Inertia {
    Rigid {
        mass: [f64; D],
        polar_speed: f64,
        stiffness: [f64; D],
    },
    /// By line: of the transform, and of the first and second derivative of its window.
    Lines(Vec<[Square; 3]>),
}

/// Displacement by a unit unbalance at angle 0 and at a quarter of a revolution: for each bearing and plane, sample by sample.
pub(crate) type UnitResponses = Vec<[[Vec<Displacement<f64>>; 2]; 2]>;

struct Elastic {
    /// Stations of two planes at which unbalance is taken to change, m.
    planes: [f64; 2],
    /// Effect of a wrench at each plane, and at the load's station.
    at_planes: [ByLine; 2],
    at_load: ByLine,
    /// Displacement of each bearing at a steady pose by a wrench at each plane, at each bearing, at the load's station and at the
    /// centre of mass (weight).
    by_plane: Vec<[ByLine; 2]>,
    by_bearing: Vec<Vec<ByLine>>,
    by_load: Vec<Square>,
    by_weight: Vec<Square>,
    load_station: f64,
}

fn at(of: &[Square], line: usize) -> &Square {
    &of[line.min(of.len() - 1)]
}

/// Returns the displacement at `station` of a rigid shaft by its pose.
fn rigid_rows(station: f64) -> Square {
    let mut rows = Square::identity();
    rows[(0, 4)] = C::from(station);
    rows[(1, 3)] = C::from(-station);
    rows
}

impl Dynamics {
    /// Creates the relations for `lines` (rad/s) at a mean shaft speed (rad/s); `None` if the rotor cannot be diagnosed.
    ///
    /// # Errors
    /// Returns an error if the rotor cannot be reduced.
    pub fn new(
        scene: &Scene,
        plant: &Plant,
        (probes, solver): (&[Probe], &PoseSolver),
        lines: &[f64],
        speed: f64,
    ) -> Result<Option<Self>, PlantError> {
        let Some(rotor) = &scene.rotor else { return Ok(None) };
        if plant.layout.is_rigid() {
            return Ok(Some(Self::rigid(rotor, plant, speed)));
        }
        let layout = plant.finer_layout(scene, ELASTIC)?;
        Lines::new(rotor, plant, &layout, (probes, solver), speed)?.map(|all| all.dynamics(lines)).transpose()
    }

    fn rigid(rotor: &Rotor, plant: &Plant, speed: f64) -> Self {
        let stations: Vec<f64> = plant.bearings.iter().map(|b| b.station).collect();
        let place = |z: &f64| vec![rigid_rows(*z).transpose()];
        let mass = [rotor.mass, rotor.mass, rotor.mass, rotor.diametral_inertia, rotor.diametral_inertia];
        Self {
            bearings: stations.iter().map(place).collect(),
            by_pose: stations.iter().map(|z| vec![rigid_rows(*z)]).collect(),
            inertia: Inertia::Rigid { mass, polar_speed: rotor.polar_inertia * speed, stiffness: rotor.stiffness },
            elastic: None,
        }
    }

    /// Returns true where unbalance and load move the bearings while the pose stays.
    pub const fn is_elastic(&self) -> bool {
        self.elastic.is_some()
    }

    /// Returns the effect of a wrench at bearing `b` as one about the centre of mass.
    pub(crate) fn to_centre(&self, b: usize, line: usize) -> &Square {
        at(&self.bearings[b], line)
    }

    /// Adds `spectra` of a wrench at bearing `b` to `sum` about the centre of mass.
    pub fn add(&self, b: usize, spectra: &[Vec<C>; D], sum: &mut [Vec<C>; D]) {
        add(&self.bearings[b], spectra, sum);
    }

    /// Returns the force that a pose with these spectra (under the window and its first two derivatives) requires, with the opposite sign;
    /// `damping` is that of a rigid rotor.
    pub fn required(&self, lines: &[f64], damping: &[f64; D], [q, q1, q2]: &[[Vec<C>; D]; 3]) -> [Vec<C>; D] {
        let mut out: [Vec<C>; D] = std::array::from_fn(|_| vec![C::new(0.0, 0.0); lines.len()]);
        match &self.inertia {
            Inertia::Rigid { mass, polar_speed, stiffness } => {
                for (k, w) in lines.iter().enumerate() {
                    let rate = |i: usize| C::new(0.0, *w) * q[i][k] - q1[i][k];
                    for i in 0..D {
                        let acceleration = -w * w * q[i][k] - C::new(0.0, 2.0 * w) * q1[i][k] + q2[i][k];
                        out[i][k] -= acceleration * mass[i] + rate(i) * damping[i] + q[i][k] * stiffness[i];
                    }
                    let (thu, thv) = (rate(3), rate(4));
                    out[3][k] -= thv * *polar_speed;
                    out[4][k] += thu * *polar_speed;
                }
            }
            Inertia::Lines(all) => {
                for (k, matrices) in all.iter().enumerate() {
                    for (matrix, spectra) in matrices.iter().zip([q, q1, q2]) {
                        for (i, out) in out.iter_mut().enumerate() {
                            out[k] -= (0..D).map(|j| matrix[(i, j)] * spectra[j][k]).sum::<C>();
                        }
                    }
                }
            }
        }
        out
    }

    /// Returns the force that a pose requires on bearings with these mean tangents.
    pub fn stiffness(&self, line: usize, w: f64, damping: &[f64; D], tangents: &[Tangent]) -> Square {
        let mut sum = match &self.inertia {
            Inertia::Rigid { mass, polar_speed, stiffness } => {
                let mut g = Square::from_diagonal(&SVector::<C, D>::from_fn(|i, _| {
                    C::new(stiffness[i] - w * w * mass[i], w * damping[i])
                }));
                let spin = w * polar_speed;
                g[(3, 4)] += C::new(0.0, spin);
                g[(4, 3)] -= C::new(0.0, spin);
                g
            }
            Inertia::Lines(all) => all[line][0],
        };
        for (b, tangent) in tangents.iter().enumerate() {
            sum += at(&self.bearings[b], line) * tangent.map(C::from) * at(&self.by_pose[b], line);
        }
        sum
    }

    /// Returns the displacement of each bearing by a pose, sample by sample.
    pub fn displacements(&self, pose: &[[f64; D]]) -> Vec<Vec<Displacement<f64>>> {
        self.by_pose.iter().map(|matrices| mapped(pose, matrices, Beyond::First)).collect()
    }

    /// Returns the force of an unbalance as spectra about the centre of mass; `unit` are the spectra of the force along X and Y of a unit
    /// unbalance at angle 0.
    pub fn unbalance(&self, [ex, ey, cx, cy]: [f64; 4], unit: &[Vec<C>; 2]) -> [Vec<C>; D] {
        let turned = |x: f64, y: f64| -> [Vec<C>; 2] {
            let pair = unit[0].iter().zip(&unit[1]);
            pair.map(|(p, q)| (x * p - y * q, x * q + y * p)).unzip::<C, C, Vec<C>, Vec<C>>().into()
        };
        let Some(elastic) = &self.elastic else {
            return about_centre(turned(ex, ey), turned(cx, cy));
        };
        let none = || vec![C::new(0.0, 0.0); unit[0].len()];
        let mut sum: [Vec<C>; D] = std::array::from_fn(|_| none());
        for (place, [x, y]) in elastic.at_planes.iter().zip(elastic.in_planes([ex, ey, cx, cy])) {
            let [fx, fy] = turned(x, y);
            add(place, &[fx, fy, none(), none(), none()], &mut sum);
        }
        sum
    }

    /// Returns the force of a coupling on a rigid rotor as spectra about the centre of mass; `harmonics` are the spectra of cosine and sine of
    /// the shaft angle and of twice that.
    pub(crate) fn coupling(of: &CouplingForce, harmonics: &[[Vec<C>; 2]; 2]) -> [Vec<C>; D] {
        let along = |direction: usize| {
            let mut sum = vec![C::new(0.0, 0.0); harmonics[0][0].len()];
            for (force, [cosine, sine]) in of.force.iter().zip(harmonics) {
                let parts = cosine.iter().zip(sine);
                let [c, s] = [force[2 * direction], force[2 * direction + 1]];
                sum.iter_mut().zip(parts).for_each(|(sum, (p, q))| *sum += c * p + s * q);
            }
            sum
        };
        let force = [along(0), along(1)];
        let moment = force.clone().map(|f| f.into_iter().map(|f| f * of.station).collect());
        about_centre(force, moment)
    }

    /// Returns the force of a constant load and weight as spectra about the centre of mass; `constant` is the spectrum of 1.
    pub fn load(&self, load: &[f64; D], weight: &[f64; D], constant: &[C]) -> [Vec<C>; D] {
        let spectra = |of: &[f64; D]| of.map(|f| constant.iter().map(|c| c * f).collect::<Vec<C>>());
        let Some(elastic) = &self.elastic else {
            return spectra(&std::array::from_fn(|i| load[i] + weight[i]));
        };
        let mut sum = spectra(weight);
        add(&elastic.at_load, &spectra(&elastic.local_load(load)), &mut sum);
        sum
    }

    /// Returns the displacement of every bearing by a unit unbalance in each plane while the pose stays; `None` for a rigid rotor.
    ///
    /// `unit` is the force along X and Y of a unit unbalance at angle 0, sample by sample.
    pub(crate) fn unit_responses(&self, unit: &[[f64; 2]]) -> Option<UnitResponses> {
        let elastic = self.elastic.as_ref()?;
        let ahead: Vec<[f64; D]> = unit.iter().map(|[p, q]| [*p, *q, 0.0, 0.0, 0.0]).collect();
        let behind: Vec<[f64; D]> = unit.iter().map(|[p, q]| [-q, *p, 0.0, 0.0, 0.0]).collect();
        let of = |matrices: &Vec<Square>| [&ahead, &behind].map(|force| mapped(force, matrices, Beyond::None));
        Some(elastic.by_plane.iter().map(|planes| planes.each_ref().map(of)).collect())
    }

    /// Returns the displacement of bearing `b` by unbalance, load and weight while the pose stays; `None` for a rigid rotor.
    pub(crate) fn by_loads(
        &self,
        b: usize,
        unbalance: [f64; 4],
        [load, weight]: [&[f64; D]; 2],
        unit: Option<&UnitResponses>,
    ) -> Option<Vec<Displacement<f64>>> {
        let elastic = self.elastic.as_ref()?;
        let of_planes = &unit?[b];
        let mut sum = vec![elastic.by_steady_loads(b, load, weight); of_planes[0][0].len()];
        for (responses, moments) in of_planes.iter().zip(elastic.in_planes(unbalance)) {
            for (response, moment) in responses.iter().zip(moments).filter(|(_, moment)| *moment != 0.0) {
                for (sum, part) in sum.iter_mut().zip(response) {
                    *sum = *sum + Displacement::from_array(part.to_array().map(|x| moment * x));
                }
            }
        }
        Some(sum)
    }

    /// Returns the largest static displacement of a bearing across the axis by load and weight while the pose stays, m.
    pub(crate) fn sag(&self, load: &[f64; D], weight: &[f64; D]) -> f64 {
        let Some(elastic) = &self.elastic else { return 0.0 };
        let of = |b: usize| {
            let moved = elastic.by_steady_loads(b, load, weight);
            moved.u.hypot(moved.v)
        };
        (0..elastic.by_load.len()).map(of).fold(0.0, f64::max)
    }

    /// Adds the displacement of every bearing by `wrenches` of the bearings, sample by sample, while the pose stays.
    pub(crate) fn add_by_bearings(&self, wrenches: &[Vec<[f64; D]>], displacements: &mut [Vec<Displacement<f64>>]) {
        let Some(elastic) = &self.elastic else { return };
        for (b, displaced) in displacements.iter_mut().enumerate() {
            for (wrench, matrices) in wrenches.iter().zip(&elastic.by_bearing[b]) {
                for (sum, part) in displaced.iter_mut().zip(mapped(wrench, matrices, Beyond::None)) {
                    *sum = *sum + part;
                }
            }
        }
    }
}

/// Returns a force along X and Y on a rigid rotor, with its first moment along Z, as one about the centre of mass.
fn about_centre([fx, fy]: [Vec<C>; 2], [mx, my]: [Vec<C>; 2]) -> [Vec<C>; D] {
    let axial = vec![C::new(0.0, 0.0); fx.len()];
    [fx, fy, axial, my.into_iter().map(|m| -m).collect(), mx]
}

fn add(place: &ByLine, spectra: &[Vec<C>; D], sum: &mut [Vec<C>; D]) {
    for k in 0..sum[0].len() {
        let matrix = at(place, k);
        for (i, sum) in sum.iter_mut().enumerate() {
            sum[k] += (0..D).map(|j| matrix[(i, j)] * spectra[j][k]).sum::<C>();
        }
    }
}

impl Elastic {
    /// Distributes static and couple unbalance over the two planes.
    fn in_planes(&self, [ex, ey, cx, cy]: [f64; 4]) -> [[f64; 2]; 2] {
        let [a, b] = self.planes;
        let span = a - b;
        let pair = |e: f64, c: f64| [(c - b * e) / span, (a * e - c) / span];
        let ([xa, xb], [ya, yb]) = (pair(ex, cx), pair(ey, cy));
        [[xa, ya], [xb, yb]]
    }

    /// Converts a load about the centre of mass to its own station.
    fn local_load(&self, load: &[f64; D]) -> [f64; D] {
        load_at(*load, -self.load_station)
    }

    /// Returns the displacement of bearing `b` by load and weight while the pose stays.
    fn by_steady_loads(&self, b: usize, load: &[f64; D], weight: &[f64; D]) -> Displacement<f64> {
        let vector = |x: &[f64; D]| SVector::from(x.map(C::from));
        let moved = self.by_load[b] * vector(&self.local_load(load)) + self.by_weight[b] * vector(weight);
        Displacement::from_array(std::array::from_fn(|i| moved[i].re))
    }
}

/// Share of a record at each end over which a series rises before it is mapped line by line. A step there would excite a free
/// vibration that lasts into the record; a rise over many periods does not.
pub(crate) const LEAD: f64 = 0.08;

/// Treatment of the lines beyond the last matrix.
#[derive(Clone, Copy, PartialEq)]
enum Beyond {
    /// The first matrix maps them.
    First,
    /// They are omitted.
    None,
}

/// Maps a series line by line; its straight line is mapped by the first matrix. Exact between the leads.
fn mapped(series: &[[f64; D]], matrices: &[Square], beyond: Beyond) -> Vec<Displacement<f64>> {
    let n = series.len();
    let first = matrices[0];
    let real = |row: usize, x: &[f64; D]| (0..D).map(|j| first[(row, j)].re * x[j]).sum();
    if matrices.len() == 1 {
        return series.iter().map(|x| Displacement::from_array(std::array::from_fn(|i| real(i, x)))).collect();
    }
    let trends: [[f64; 2]; D] = std::array::from_fn(|i| trend(series, i));
    let line = |t: usize| std::array::from_fn(|i| trends[i][0] + trends[i][1] * t as f64);
    let rise = |t: usize| {
        let from_end = (t.min(n - 1 - t) as f64 + 0.5) / (LEAD * n as f64);
        if from_end < 1.0 { (0.25 * std::f64::consts::TAU * from_end).sin().powi(4) } else { 1.0 }
    };
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let spectra: [Vec<C>; D] = std::array::from_fn(|i| {
        let mut lines: Vec<C> = (0..n).map(|t| C::from(rise(t) * (series[t][i] - line(t)[i]))).collect();
        forward.process(&mut lines);
        lines
    });
    let mut out: Vec<[f64; D]> = (0..n).map(|t| std::array::from_fn(|i| real(i, &line(t)))).collect();
    for i in 0..D {
        let mut lines = vec![C::from(0.0); n];
        for k in 0..=n / 2 {
            let matrix = match matrices.get(k) {
                Some(matrix) => matrix,
                None if beyond == Beyond::First => &first,
                None => break,
            };
            let value = (0..D).map(|j| matrix[(i, j)] * spectra[j][k]).sum::<C>() / n as f64;
            lines[k] = value;
            if k > 0 && 2 * k < n {
                lines[n - k] = value.conj();
            }
        }
        inverse.process(&mut lines);
        out.iter_mut().zip(&lines).for_each(|(out, x)| out[i] += x.re);
    }
    out.into_iter().map(Displacement::from_array).collect()
}

/// Returns value at sample 0 and slope of the least-squares line through component `i`.
fn trend(series: &[[f64; D]], i: usize) -> [f64; 2] {
    let n = series.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = series.iter().map(|x| x[i]).sum::<f64>() / n;
    let moment: f64 = series.iter().enumerate().map(|(t, x)| (t as f64 - middle) * x[i]).sum();
    let slope = 12.0 * moment / (n * (n * n - 1.0)).max(1.0);
    [mean - slope * middle, slope]
}

/// The rotor in all its coordinates.
struct Lines {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    /// Pose by coordinates.
    pose: DMatrix<C>,
    /// Coordinates by a wrench about the centre of mass that acts through the outermost bearings.
    through_bearings: DMatrix<C>,
    bearings: Vec<DMatrix<C>>,
    planes: [f64; 2],
    at_planes: [DMatrix<C>; 2],
    load_station: f64,
    at_load: DMatrix<C>,
    weight: DMatrix<C>,
}

fn matrix(rows: &Rows) -> DMatrix<C> {
    DMatrix::from_fn(D, rows[0].len(), |i, j| C::from(rows[i][j]))
}

impl Lines {
    fn new(
        rotor: &Rotor,
        plant: &Plant,
        layout: &Layout,
        (probes, solver): (&[Probe], &PoseSolver),
        speed: f64,
    ) -> Result<Option<Self>, PlantError> {
        let n = layout.order;
        let scales = layout.scales(plant.rotor(), &plant.bearings, &DMatrix::zeros(n, n))?;
        let mut pose = DMatrix::from_element(D, n, C::from(0.0));
        let mut has_axial_probe = false;
        for (p, probe) in probes.iter().enumerate() {
            let (column, row) = (solver.column(p).to_array(), layout.probe_row(probe));
            has_axial_probe |= column[2] != 0.0;
            for (i, x) in column.iter().enumerate() {
                for (j, y) in row.iter().enumerate() {
                    pose[(i, j)] += C::from(x * y);
                }
            }
        }
        if !has_axial_probe {
            pose[(2, 2)] = C::from(1.0);
        }
        let bearings: Vec<DMatrix<C>> =
            (0..plant.bearings.len()).filter_map(|b| layout.attached(b)).map(matrix).collect();
        let [first, second] = bearings.as_slice() else { return Ok(None) };
        let [z1, z2] = [plant.bearings[0].station, plant.bearings[1].station];
        if z1 == z2 {
            return Ok(None);
        }
        // Force at the first of two bearings with the resultant f: along X F1 = (m_y - z2 f_x) / (z1 - z2),
        // along Y F1 = (-m_x - z2 f_y) / (z1 - z2).
        let span = z1 - z2;
        let mut through_bearings = DMatrix::from_element(n, D, C::from(0.0));
        for j in 0..n {
            let (x1, x2, y1, y2) = (first[(0, j)], second[(0, j)], first[(1, j)], second[(1, j)]);
            through_bearings[(j, 0)] = (x2 * z1 - x1 * z2) / span;
            through_bearings[(j, 4)] = (x1 - x2) / span;
            through_bearings[(j, 1)] = (y2 * z1 - y1 * z2) / span;
            through_bearings[(j, 3)] = (y2 - y1) / span;
        }
        through_bearings[(2, 2)] = C::from(1.0);
        let planes = unbalance_planes(rotor, [z1, z2]);
        let (load_station, _) = rotor.local_load();
        let mut weight = DMatrix::from_element(D, n, C::from(0.0));
        for i in 0..D {
            weight[(i, i)] = C::from(1.0);
        }
        // The weight of a support, over that of the rotor.
        for j in layout.rotor_order()..n {
            weight[((j - layout.rotor_order()) % 2, j)] = C::from(scales.mass[(j, j)] / rotor.mass);
        }
        Ok(Some(Self {
            damping: scales.damping + speed * scales.gyroscopic,
            mass: scales.mass,
            stiffness: scales.stiffness,
            pose,
            through_bearings,
            at_planes: planes.map(|z| matrix(&layout.rows(z))),
            planes,
            at_load: matrix(&layout.rows(load_station)),
            load_station,
            weight,
            bearings,
        }))
    }

    /// Returns the compliance of the free rotor at the angular frequency `w`, rad/s; `None` if its dynamic stiffness is singular.
    fn alpha(&self, w: f64) -> Option<DMatrix<C>> {
        let n = self.mass.nrows();
        let z = DMatrix::from_fn(n, n, |i, j| {
            C::new(self.stiffness[(i, j)] - w * w * self.mass[(i, j)], w * self.damping[(i, j)])
        });
        z.try_inverse()
    }

    /// Returns the force that a pose requires, from the compliance.
    fn required(&self, alpha: &DMatrix<C>) -> Option<Square> {
        let alpha = &self.pose * alpha * &self.through_bearings;
        Square::from_fn(|i, j| alpha[(i, j)]).try_inverse()
    }

    fn dynamics(&self, lines: &[f64]) -> Result<Dynamics, PlantError> {
        let bin = lines.get(1).copied().unwrap_or(1.0);
        let step = STEP * bin;
        let small = |m: &DMatrix<C>| Square::from_fn(|i, j| m[(i, j)]);
        let count = self.bearings.len();
        let mut required = vec![];
        let mut to_pose = vec![vec![]; count];
        let mut by_pose = vec![vec![]; count];
        let mut at_planes = [vec![], vec![]];
        let mut at_load = vec![];
        let mut by_plane = vec![[vec![], vec![]]; count];
        let mut by_bearing = vec![vec![vec![]; count]; count];
        let (mut by_load, mut by_weight) = (vec![], vec![]);
        for (k, w) in lines.iter().enumerate() {
            let w = w.max(LOWEST * bin);
            let all = || -> Option<_> {
                let alpha = self.alpha(w)?;
                let beside = |w: f64| self.required(&self.alpha(w)?);
                Some((beside(w - step)?, self.required(&alpha)?, beside(w + step)?, alpha))
            };
            let Some((before, z, after, alpha)) = all() else { return Err(PlantError::SingularMass) };
            let (slope, bend) =
                ((after - before) / C::from(2.0 * step), (after - z * C::from(2.0) + before) / C::from(step * step));
            required.push([z, slope * C::i(), bend * C::from(-0.5)]);
            let z = DMatrix::from_fn(D, D, |i, j| z[(i, j)]);
            // Effect of a force on the coordinates: the equivalent wrench, and the remaining motion at a steady pose.
            let equivalent = &z * &self.pose * &alpha;
            let left = &alpha - &alpha * &self.through_bearings * &equivalent;
            let by_motion = &alpha * &self.through_bearings * &z;
            for (b, rows) in self.bearings.iter().enumerate() {
                to_pose[b].push(small(&(&equivalent * rows.transpose())));
                by_pose[b].push(small(&(rows * &by_motion)));
                let left = rows * &left;
                for (p, plane) in self.at_planes.iter().enumerate() {
                    by_plane[b][p].push(small(&(&left * plane.transpose())));
                }
                for (other, place) in self.bearings.iter().enumerate() {
                    by_bearing[b][other].push(small(&(&left * place.transpose())));
                }
                if k == 0 {
                    by_load.push(small(&(&left * self.at_load.transpose())));
                    by_weight.push(small(&(&left * self.weight.transpose())));
                }
            }
            for (p, plane) in self.at_planes.iter().enumerate() {
                at_planes[p].push(small(&(&equivalent * plane.transpose())));
            }
            at_load.push(small(&(&equivalent * self.at_load.transpose())));
        }
        Ok(Dynamics {
            bearings: to_pose,
            by_pose,
            inertia: Inertia::Lines(required),
            elastic: Some(Elastic {
                planes: self.planes,
                at_planes,
                at_load,
                by_plane,
                by_bearing,
                by_load,
                by_weight,
                load_station: self.load_station,
            }),
        })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    /// A shaft on two bearings with two probe planes; a modulus so large that it does not bend.
    const SCENE: &str = r#"
        [shaft]
        speed = "3000 rpm"
        [rotor]
        sections = [{ from = "0 mm", to = "400 mm", outer_diameter = "30 mm" }]
        disks = [{ station = "180 mm", mass = "4 kg", diametral_inertia = 0.007, polar_inertia = 0.012 }]
        youngs_modulus = "206e6 GPa"
        unbalance = [{ moment = "50 g mm", angle = "17 deg", station = "180 mm" }]
        [[bearing]]
        name = "DE"
        station = "20 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 6e7, 0, 0, 0], [0, 0, 1e5, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]
        [[bearing]]
        name = "NDE"
        station = "380 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 6e7, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]
        [recording]
        file = "none.csv"
        rate = "12.8 kHz"
        probes = [
          { column = "AX", unit = "um", station = "60 mm", angle = "0 deg" },
          { column = "AY", unit = "um", station = "60 mm", angle = "90 deg" },
          { column = "BX", unit = "um", station = "340 mm", angle = "0 deg" },
          { column = "BY", unit = "um", station = "340 mm", angle = "90 deg" },
          { column = "Z", unit = "um", axial = true },
        ]
    "#;

    /// A shaft that does not bend has the relations of a rigid rotor: forces about the centre of mass, displacements on the straight
    /// line, inertia and gyroscopic moments, and no motion of the bearings while the pose stays.
    #[test]
    fn a_shaft_that_does_not_bend_is_a_rigid_rotor() {
        let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
        let plant = Plant::try_new(&scene).unwrap();
        let probes = &scene.recording.as_ref().unwrap().probes;
        let stations: Vec<f64> = plant.bearings.iter().map(|b| b.station).collect();
        let solver = PoseSolver::try_new(probes, &stations).unwrap();
        let lines: Vec<f64> = (0..60).map(|k| 20.0 * f64::from(k)).collect();
        let speed = 314.0;
        let elastic = Dynamics::new(&scene, &plant, (probes, &solver), &lines, speed).unwrap().unwrap();
        let rigid = Dynamics::rigid(scene.rotor.as_ref().unwrap(), &plant, speed);
        let near = |found: &Square, expected: &Square, what: &str| {
            let off = (found - expected).map(|x| x.norm()).max();
            assert!(off < 1e-3 * expected.map(|x| x.norm()).max(), "{what}: {found} {expected}");
        };
        for k in [1, 7, 30, 59] {
            for b in 0..2 {
                near(elastic.to_centre(b, k), rigid.to_centre(b, k), "force");
                near(at(&elastic.by_pose[b], k), at(&rigid.by_pose[b], k), "displacement");
            }
            let tangents = [Tangent::zeros(); 2];
            let required = |of: &Dynamics| of.stiffness(k, lines[k], &[0.0; D], &tangents);
            near(&required(&elastic), &required(&rigid), "inertia");
        }
        let of_elastic = elastic.elastic.as_ref().unwrap();
        let weight = [0.0, -50.0, 0.0, 0.0, 0.0];
        // The shaft of steel sags by some um.
        assert!(elastic.sag(&[0.0; D], &weight) < 1e-10, "{}", elastic.sag(&[0.0; D], &weight));
        // An unbalance is distributed over the two planes without a change of its sum and couple.
        let [[xa, _], [xb, _]] = of_elastic.in_planes([3e-5, 0.0, 1e-6, 0.0]);
        let [a, b] = of_elastic.planes;
        assert!((xa + xb - 3e-5).abs() < 1e-15 && (a * xa + b * xb - 1e-6).abs() < 1e-15);
    }
}
