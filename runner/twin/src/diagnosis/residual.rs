//! The force that a machine leaves unexplained, as a residual at the probes in units of their noise.

use super::Result;
use super::dynamics::{Dynamics, LEAD, Square, Tangent, UnitResponses};
use super::filter::LineFilter;
use super::fit::dot;
use super::machine::{Evaluated, Machine, MachineBearing, Part, Unknown};
use super::motion::{C, D, Motion, Transform};
use crate::plant::Plant;
use crate::probes::{self, PoseSolver};
use crate::scene::{Probe, Scene};
use ballrace::Displacement;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::sync::Arc;

/// Lead and rise of the window, as shares of the record. A rotor that bends vibrates freely for some time with its probes at rest: the
/// window changes little in that time.
const RIGID_WINDOW: [f64; 2] = [0.0, 0.12];
const ELASTIC_WINDOW: [f64; 2] = [LEAD, 0.4];
/// Lines over which the window spreads a mean.
pub const MEAN_LINES: usize = 5;
/// Lines on each side over which the noise is estimated.
const NEIGHBOURS: usize = 6;
/// Sets of made-up noise from which the noise of the residual is estimated.
const DRAWS: usize = 3;
/// Relative standard deviation of a shaft's elasticity: Young's modulus of steels differs by 2 %, shrunk-on parts stiffen the shaft.
const ELASTICITY_ERROR: f64 = 0.02;
/// Rounds in which moments and displacements of the bearings of an elastic rotor are found.
const MOMENT_ROUNDS: usize = 2;
/// Square of the change of the residual, in units of the noise, below which a parameter is certain enough.
const LEAST_TOLERANCE: f64 = 1e-3;

/// How residuals are weighted: probes with their noise.
pub(super) struct Weighting {
    pub probes: Vec<Probe>,
    /// Rms noise of each probe, m.
    pub noise: Vec<f64>,
    pub solver: PoseSolver,
    /// Without one, the axial coordinate is not measured and its equation of motion is left out.
    pub has_axial_probe: bool,
}

impl Weighting {
    /// Standard deviation of each coordinate of a pose by the noise of the probes.
    fn pose_noise(&self) -> [f64; D] {
        let mut square = [0.0; D];
        for p in 0..self.noise.len() {
            let alone: Vec<f64> = self.noise.iter().enumerate().map(|(i, n)| if i == p { *n } else { 0.0 }).collect();
            for (sum, x) in square.iter_mut().zip(self.solver.pose(&alone, 0.0).to_array()) {
                *sum += x * x;
            }
        }
        square.map(f64::sqrt)
    }
}

/// Everything of a recording that hypotheses are held against, weighted for one machine.
#[derive(Clone)]
pub(super) struct Evidence<'a> {
    pub scene: &'a Scene,
    pub plant: &'a Plant,
    pub motion: Arc<Motion>,
    pub transform: Arc<Transform>,
    /// Spectra of q, w' q and w'' q, with q the lines that stand out.
    displacement: Arc<[[Vec<C>; D]; 3]>,
    weighting: Arc<Weighting>,
    shaft: Shaft,
    /// The same rotor with a stiffer shaft, by [`ELASTICITY_ERROR`]; none for a rigid one.
    stiffer: Option<Shaft>,
    /// The same with unbalance, load and moments of the machine by which the residual is weighted.
    displaced: Vec<Arc<Vec<Displacement<f64>>>>,
    /// Unbalance and load of that machine.
    given: ([f64; 4], [f64; D]),
    /// Spectra of the force along X and Y of a unit unbalance at angle 0.
    unit_unbalance_lines: Arc<[Vec<C>; 2]>,
    /// Spectrum of 1.
    constant: Arc<Vec<C>>,
    /// Per line: whitened displacement per unit of force about the centre of mass.
    whitening: Vec<Vec<[C; D]>>,
    /// The same per unit of force at each bearing.
    pub whitening_of_bearing: Vec<Vec<Vec<[C; D]>>>,
    /// Per line and row: noise of the whitened residual over that of the displacement.
    noise_scale: Vec<Vec<f64>>,
    /// Parameters that are not exactly known, with a root of their covariance.
    uncertain: Option<(Vec<Unknown>, DMatrix<f64>)>,
    /// Directions of the whitened residual that they lead to.
    tolerance: Vec<Direction>,
    /// Mean dynamic stiffness of the machine by which the residual is weighted.
    reference: MeanStiffness,
    /// Values of a residual per line.
    pub rows: usize,
    filter: Arc<LineFilter>,
    /// The part of the displacement that the filter took, and its spectrum.
    rest: Arc<Vec<[f64; D]>>,
    rest_lines: Arc<[Vec<C>; D]>,
    /// Forces that `rest` requires and causes in the machine by which the residual is weighted, linearised, less the mean change of
    /// the force by noise that passes the filter. It is mostly noise, which must not depend on the unknowns of a fit: a fit would
    /// lower the noise by less damping.
    correction: [Vec<C>; D],
    gravity: [f64; D],
}

/// Relations of the rotor's places, applied to a motion.
#[derive(Clone)]
struct Shaft {
    dynamics: Arc<Dynamics>,
    /// Displacement of the rotor at each bearing by the pose alone.
    by_pose: Arc<Vec<Vec<Displacement<f64>>>>,
    /// Displacement of the bearings by a unit unbalance.
    unit_responses: Option<Arc<UnitResponses>>,
}

impl Shaft {
    /// Returns none where the rotor does not allow it.
    fn new(
        scene: &Scene,
        plant: &Plant,
        weighting: &Weighting,
        transform: &Transform,
        (motion, pose): (&Motion, &[[f64; D]]),
    ) -> Option<Self> {
        let of_probes = (weighting.probes.as_slice(), &weighting.solver);
        // A rotor that the plant is made of can be reduced.
        let dynamics = Dynamics::new(scene, plant, of_probes, &transform.lines, motion.mean_speed()).ok()??;
        Some(Self {
            by_pose: Arc::new(dynamics.displacements(pose)),
            unit_responses: dynamics.unit_responses(&motion.unit_unbalance()).map(Arc::new),
            dynamics: Arc::new(dynamics),
        })
    }
}

/// A direction of the whitened residual with the share of it that is taken from a residual.
#[derive(Clone)]
struct Direction {
    unit: Vec<f64>,
    share: f64,
}

/// Mean tangent stiffness of each bearing along a motion, and damping of the rotor.
#[derive(Clone, Default)]
struct MeanStiffness {
    tangents: Vec<Tangent>,
    damping: [f64; D],
}

/// Spectrum of the forces of each part of a machine, and their sum as a residual.
#[derive(Clone)]
pub struct Spectra {
    bearings: Vec<[Vec<C>; D]>,
    rotor: [Vec<C>; D],
}

impl Spectra {
    /// Returns the spectra with another force of one bearing.
    pub fn replaced(&self, bearing: usize, force: [Vec<C>; D]) -> Self {
        let mut spectra = self.clone();
        spectra.bearings[bearing] = force;
        spectra
    }
}

impl<'a> Evidence<'a> {
    /// Returns none where the rotor cannot be diagnosed. [`Evidence::weight_for`] comes next.
    ///
    /// # Errors
    /// A bearing that cannot be built, a rotor that cannot be reduced.
    pub fn new(
        scene: &'a Scene,
        plant: &'a Plant,
        mut motion: Motion,
        highest: f64,
        weighting: Weighting,
    ) -> Result<Option<Self>> {
        let Some(rotor) = scene.rotor.as_ref() else { return Ok(None) };
        let transform = Transform::new(
            motion.len(),
            motion.period,
            highest,
            if plant.layout.is_rigid() { RIGID_WINDOW } else { ELASTIC_WINDOW },
        );
        let q: Vec<[f64; D]> = motion.q.iter().map(|q| q.to_array()).collect();
        let filter = LineFilter::new(&q, weighting.pose_noise());
        let filtered = filter.apply(&q);
        let displacement = std::array::from_fn(|order| transform.five(order, |t| filtered[t]));
        let rest: Vec<[f64; D]> = q.iter().zip(&filtered).map(|(q, f)| std::array::from_fn(|i| q[i] - f[i])).collect();
        let [gx, gy, gz] = rotor.gravity;
        let gravity = [gx * rotor.mass, gy * rotor.mass, gz * rotor.mass, 0.0, 0.0];
        let unit_unbalance = motion.unit_unbalance();
        let Some(shaft) = Shaft::new(scene, plant, &weighting, &transform, (&motion, &filtered)) else {
            return Ok(None);
        };
        let mut stiffer = None;
        if let Some(drawn) = &rotor.flexible {
            let youngs_modulus = drawn.youngs_modulus * (1.0 + ELASTICITY_ERROR);
            let mut scene = scene.clone();
            scene
                .rotor
                .iter_mut()
                .flat_map(|r| &mut r.flexible)
                .for_each(|drawn| drawn.youngs_modulus = youngs_modulus);
            stiffer = Shaft::new(&scene, plant, &weighting, &transform, (&motion, &filtered));
        }
        motion.q = filtered.into_iter().map(Displacement::from_array).collect();
        Ok(Some(Self {
            scene,
            plant,
            rest_lines: Arc::new(transform.five(0, |t| rest[t])),
            unit_unbalance_lines: Arc::new(transform.pair(0, |t| unit_unbalance[t][0], |t| unit_unbalance[t][1])),
            constant: Arc::new(transform.pair(0, |_| 1.0, |_| 0.0)[0].clone()),
            motion: Arc::new(motion),
            transform: Arc::new(transform),
            displacement: Arc::new(displacement),
            weighting: Arc::new(weighting),
            shaft,
            stiffer,
            displaced: vec![],
            given: ([0.0; 4], [0.0; D]),
            whitening: vec![],
            whitening_of_bearing: vec![],
            noise_scale: vec![],
            uncertain: None,
            tolerance: vec![],
            reference: MeanStiffness::default(),
            rows: 0,
            filter: Arc::new(filter),
            rest: Arc::new(rest),
            correction: Default::default(),
            gravity,
        }))
    }

    /// Finds the displacement of the bearings with unbalance and load of a machine, and with the moments of its bearings, which no pair of
    /// forces replaces.
    fn displace(&mut self, machine: &Machine) -> Result<()> {
        let mut displaced = (*self.shaft.by_pose).clone();
        for (b, displaced) in displaced.iter_mut().enumerate() {
            let by_loads = self.shaft.dynamics.by_loads(
                b,
                machine.unbalance,
                [&machine.load, &self.gravity],
                self.shaft.unit_responses.as_deref(),
            );
            for (sum, part) in displaced.iter_mut().zip(by_loads.into_iter().flatten()) {
                *sum = *sum + part;
            }
        }
        self.displaced = displaced.iter().cloned().map(Arc::new).collect();
        self.given = (machine.unbalance, machine.load);
        let rounds = if self.shaft.dynamics.is_elastic() { MOMENT_ROUNDS } else { 0 };
        for _ in 0..rounds {
            let moments = (0..machine.bearings.len())
                .map(|b| {
                    let of = |[_, _, _, mx, my]: [f64; D]| [0.0, 0.0, 0.0, mx, my];
                    Ok(self.evaluated(machine, b)?.forces(&self.motion).into_iter().map(of).collect())
                })
                .collect::<Result<Vec<Vec<[f64; D]>>>>()?;
            let mut next = displaced.clone();
            self.shaft.dynamics.add_by_bearings(&moments, &mut next);
            self.displaced = next.into_iter().map(Arc::new).collect();
        }
        Ok(())
    }

    /// Returns bearing `b` of a machine along the motion.
    pub fn evaluated(&self, machine: &Machine, b: usize) -> Result<Evaluated> {
        self.evaluated_as(machine, b, &machine.bearings[b])
    }

    /// Returns another bearing in the place of bearing `b` of a machine.
    pub fn evaluated_as(&self, machine: &Machine, b: usize, of: &MachineBearing) -> Result<Evaluated> {
        Evaluated::new(self.scene, self.plant, b, of, self.displaced(machine, b))
    }

    /// Displacement of the rotor at bearing `b`: unbalance and load of the machine bend an elastic rotor.
    fn displaced(&self, machine: &Machine, b: usize) -> Arc<Vec<Displacement<f64>>> {
        let (unbalance, load) = &self.given;
        if (machine.unbalance, machine.load) == (*unbalance, *load) {
            return self.displaced[b].clone();
        }
        let more_unbalance = std::array::from_fn(|i| machine.unbalance[i] - unbalance[i]);
        let more_load: [f64; D] = std::array::from_fn(|i| machine.load[i] - load[i]);
        match self.shaft.dynamics.by_loads(
            b,
            more_unbalance,
            [&more_load, &[0.0; D]],
            self.shaft.unit_responses.as_deref(),
        ) {
            Some(more) => Arc::new(self.displaced[b].iter().zip(more).map(|(u, more)| *u + more).collect()),
            None => self.displaced[b].clone(),
        }
    }

    /// Weights residuals by the noise that they have with this machine.
    pub fn weight_for(&mut self, machine: &Machine) -> Result<()> {
        if self.displaced.is_empty() || self.shaft.dynamics.is_elastic() {
            self.displace(machine)?;
        }
        self.reference = self.mean_stiffness(machine)?;
        self.whitening = self.whitening_of(&self.reference);
        self.whiten_bearings();
        self.rows = self.whitening.first().map_or(0, Vec::len);
        self.noise_scale = vec![vec![1.0; self.rows]; self.whitening.len()];
        self.tolerance.clear();
        self.scale_noise(machine)?;
        self.whiten_bearings();
        self.tolerate(machine)
    }

    /// Returns true where unbalance and load move the bearings while the probes stay.
    pub fn is_elastic(&self) -> bool {
        self.shaft.dynamics.is_elastic()
    }

    /// Brings the weights of forces about the centre of mass to forces at each bearing.
    fn whiten_bearings(&mut self) {
        let of = |b: usize| {
            let line = |(k, rows): (usize, &Vec<[C; D]>)| {
                let from = self.shaft.dynamics.to_centre(b, k);
                let row = |row: &[C; D]| std::array::from_fn(|j| (0..D).map(|i| row[i] * from[(i, j)]).sum());
                rows.iter().map(row).collect()
            };
            self.whitening.iter().enumerate().map(line).collect()
        };
        self.whitening_of_bearing = (0..self.plant.bearings.len()).map(of).collect();
    }

    /// Sets the parameters that are known with a covariance: what they may be off explains no fault. [`Evidence::weight_for`] comes next.
    pub fn set_uncertain(&mut self, (unknowns, covariance): (Vec<Unknown>, DMatrix<f64>)) {
        let deviations: Vec<f64> = (0..unknowns.len()).map(|i| covariance[(i, i)].sqrt()).collect();
        let correlation = DMatrix::from_fn(unknowns.len(), unknowns.len(), |i, j| {
            covariance[(i, j)] / (deviations[i] * deviations[j])
        });
        let root = correlation.cholesky().map_or_else(|| DMatrix::identity(unknowns.len(), unknowns.len()), |c| c.l());
        let root = DMatrix::from_fn(unknowns.len(), unknowns.len(), |i, j| deviations[i] * root[(i, j)]);
        self.uncertain = Some((unknowns, root));
    }

    /// Finds the directions of the residual along which the uncertain parameters move it.
    ///
    /// With `U = S L` the changes by one deviation of each independent parameter (S the slopes, `L L^T` the covariance) the
    /// covariance of the residual is `1 + U U^T`. From the eigenvalues `d^2` of `U^T U` its inverse root is
    /// `1 - sum q q^T (1 - 1 / sqrt(1 + d^2))`, q the unit vectors `U v / d`.
    fn tolerate(&mut self, machine: &Machine) -> Result<()> {
        let none = (vec![], DMatrix::zeros(0, 0));
        let (unknowns, known) = self.uncertain.as_ref().unwrap_or(&none);
        let spectra = self.spectra(machine)?;
        let mut slopes = unknowns.iter().map(|u| self.slope(&spectra, machine, *u)).collect::<Result<Vec<_>>>()?;
        slopes.extend(self.elasticity_slope(&spectra, machine)?);
        let n = slopes.len();
        if n == 0 {
            return Ok(());
        }
        // The elasticity is independent of the rest, its slope that of one deviation.
        let root = DMatrix::from_fn(n, n, |i, j| known.get((i, j)).copied().unwrap_or(if i == j { 1.0 } else { 0.0 }));
        let root = &root;
        let products = DMatrix::from_fn(n, n, |i, j| if i <= j { dot(&slopes[i], &slopes[j]) } else { 0.0 });
        let products = DMatrix::from_fn(n, n, |i, j| products[(i.min(j), i.max(j))]);
        let eigen = (root.transpose() * products * root).symmetric_eigen();
        let direction = |j: usize| {
            let square = eigen.eigenvalues[j];
            let vector = root * eigen.eigenvectors.column(j);
            let mut unit = vec![0.0; self.rows * self.whitening.len() * 2];
            for (slope, weight) in slopes.iter().zip(vector.iter()) {
                unit.iter_mut().zip(slope).for_each(|(sum, x)| *sum += weight / square.sqrt() * x);
            }
            Direction { unit, share: 1.0 - 1.0 / (1.0 + square).sqrt() }
        };
        self.tolerance = (0..n).filter(|&j| eigen.eigenvalues[j] > LEAST_TOLERANCE).map(direction).collect();
        Ok(())
    }

    /// Returns the change of the residual by a shaft that is stiffer by one deviation; none for a rigid rotor.
    fn elasticity_slope(&self, spectra: &Spectra, machine: &Machine) -> Result<Option<Vec<f64>>> {
        let Some(stiffer) = &self.stiffer else { return Ok(None) };
        let mut other = Self { shaft: stiffer.clone(), ..self.clone() };
        other.displace(machine)?;
        let changed = other.residual(&other.spectra(machine)?);
        Ok(Some(changed.iter().zip(self.residual(spectra)).map(|(a, b)| a - b).collect()))
    }

    /// Returns the residual of a machine with these spectra in the weights of its own.
    ///
    /// In these the noise of the probes does not depend on the machine, so that the fit of a machine as a whole has no advantage
    /// from less damping or stiffness. The noise of the bearing forces over that of the probes is taken from the machine by which
    /// the residual is weighted.
    pub fn own_residual(&self, machine: &Machine, spectra: &Spectra) -> Result<Vec<f64>> {
        let own = self.mean_stiffness(machine)?;
        let mut force = self.force(spectra);
        self.stiffen(&mut force, &own);
        Ok(whitened(&self.own_whitening(&own), &force))
    }

    /// Returns the changes of [`Evidence::own_residual`] by each unknown. With `d` the displacement that the unexplained force
    /// causes, the change of the weights is that of the mean dynamic stiffness times `-d`.
    pub fn own_slopes(&self, spectra: &Spectra, machine: &Machine, unknowns: &[Unknown]) -> Result<Vec<Vec<f64>>> {
        let own = self.mean_stiffness(machine)?;
        let whitening = self.own_whitening(&own);
        let mut force = self.force(spectra);
        self.stiffen(&mut force, &own);
        let moved = |(k, w): (usize, &f64)| {
            let unexplained = SVector::<C, D>::from_fn(|i, _| force[i][k]);
            let caused = self.dynamic_stiffness(&own, k, *w).lu().solve(&unexplained).unwrap_or_else(SVector::zeros);
            caused + SVector::<C, D>::from_fn(|i, _| self.rest_lines[i][k])
        };
        let moved: Vec<SVector<C, D>> = self.transform.lines.iter().enumerate().map(moved).collect();
        let slope = |unknown: &Unknown| {
            let mut slope = self.force_slope(spectra, machine, *unknown)?;
            if matches!(unknown, Unknown::Clearance(_) | Unknown::Modulus(_) | Unknown::Damping(_)) {
                let mut other = machine.clone();
                let h = unknown.step();
                unknown.set(&mut other, unknown.get(machine) + h);
                let other = self.mean_stiffness(&other)?;
                for ((k, w), moved) in self.transform.lines.iter().enumerate().zip(&moved) {
                    let change = self.dynamic_stiffness(&other, k, *w) - self.dynamic_stiffness(&own, k, *w);
                    let by_stiffness = change * moved / C::new(h, 0.0);
                    slope.iter_mut().zip(by_stiffness.iter()).for_each(|(slope, x)| slope[k] -= x);
                }
            }
            Ok(whitened(&whitening, &slope))
        };
        unknowns.iter().map(slope).collect()
    }

    /// Adds what another mean stiffness requires for the part of the displacement that the filter took.
    fn stiffen(&self, force: &mut [Vec<C>; D], own: &MeanStiffness) {
        for (k, w) in self.transform.lines.iter().enumerate() {
            let change = self.dynamic_stiffness(own, k, *w) - self.dynamic_stiffness(&self.reference, k, *w);
            for (i, force) in force.iter_mut().enumerate() {
                force[k] -= (0..D).map(|j| change[(i, j)] * self.rest_lines[j][k]).sum::<C>();
            }
        }
    }

    fn own_whitening(&self, own: &MeanStiffness) -> Vec<Vec<[C; D]>> {
        let mut whitening = self.whitening_of(own);
        for (rows, scales) in whitening.iter_mut().zip(&self.noise_scale) {
            for (row, scale) in rows.iter_mut().zip(scales) {
                row.iter_mut().for_each(|a| *a /= scale);
            }
        }
        whitening
    }

    /// Mean tangent stiffness along the motion.
    fn mean_stiffness(&self, machine: &Machine) -> Result<MeanStiffness> {
        let stride = (self.motion.len() / 500).max(1);
        let count = self.motion.len().div_ceil(stride) as f64;
        let tangents = (0..machine.bearings.len())
            .map(|b| {
                let evaluated = self.evaluated(machine, b)?;
                let all = (0..self.motion.len()).step_by(stride).map(|t| evaluated.tangent(&self.motion, t));
                Ok(all.fold(Tangent::zeros(), |sum, tangent| sum + tangent) / count)
            })
            .collect::<Result<_>>()?;
        Ok(MeanStiffness { tangents, damping: machine.damping })
    }

    /// Force that a displacement at line `k`, the angular frequency `w`, requires, by the mean stiffness.
    fn dynamic_stiffness(&self, of: &MeanStiffness, k: usize, w: f64) -> Square {
        self.shaft.dynamics.stiffness(k, w, &of.damping, &of.tangents)
    }

    /// A force is brought to the displacement that it causes at the mean stiffness, which is then divided by its noise.
    fn whitening_of(&self, of: &MeanStiffness) -> Vec<Vec<[C; D]>> {
        let unit = (0.5 * self.transform.power).sqrt();
        // Information on the displacement, and its square root: rows that all have the noise 1.
        let mut information = SMatrix::<f64, D, D>::zeros();
        for (probe, noise) in self.weighting.probes.iter().zip(&self.weighting.noise) {
            let row = SVector::<f64, D>::from_row_slice(&probes::row(probe));
            information += row * row.transpose() / (noise * noise);
        }
        let measured: Vec<usize> = (0..D).filter(|&i| i != 2 || self.weighting.has_axial_probe).collect();
        if !self.weighting.has_axial_probe {
            information[(2, 2)] = 1.0;
        }
        // Lengths of the unit of translations and tilts differ: the square root is taken with a unit diagonal.
        let scale: Vec<f64> = (0..D).map(|i| information[(i, i)].max(1e-300).sqrt()).collect();
        let scaled = SMatrix::<f64, D, D>::from_fn(|i, j| information[(i, j)] / (scale[i] * scale[j]));
        let root = scaled.cholesky().map_or_else(SMatrix::<f64, D, D>::identity, |c| c.l().transpose());
        let whitening = |(k, w): (usize, &f64)| {
            let inverse = self.held(self.dynamic_stiffness(of, k, *w)).try_inverse().unwrap_or_else(Square::zeros);
            let row = |&i: &usize| {
                std::array::from_fn(|j| (0..D).map(|k| inverse[(k, j)] * (root[(i, k)] * scale[k] / unit)).sum::<C>())
            };
            measured.iter().map(row).collect()
        };
        let mut all: Vec<Vec<[C; D]>> = self.transform.lines.iter().enumerate().map(whitening).collect();
        // The offset of a probe is not known better than its noise, however long the record, and the line of a shaft that bends under its
        // weight no better than its elasticity.
        let least = self.weighting.noise.iter().copied().fold(f64::INFINITY, f64::min);
        let offset = (ELASTICITY_ERROR * self.shaft.dynamics.sag(&self.given.1, &self.gravity) / least).hypot(1.0);
        let mean = 1.0 / (1.0 + 2.0 * self.motion.len() as f64 * offset * offset).sqrt();
        for rows in all.iter_mut().take(MEAN_LINES) {
            rows.iter_mut().flatten().for_each(|a| *a *= mean);
        }
        all
    }

    /// Holds the axial coordinate where it is not measured.
    fn held(&self, mut stiffness: Square) -> Square {
        if !self.weighting.has_axial_probe {
            (0..D).for_each(|i| (stiffness[(2, i)], stiffness[(i, 2)]) = (C::new(0.0, 0.0), C::new(0.0, 0.0)));
            stiffness[(2, 2)] = C::new(1e30, 0.0);
        }
        stiffness
    }

    /// Scales the noise of each probe, line by line, to that of the residual of a true machine: the noise of the probes also
    /// enters the displacement at which the bearing forces are evaluated, and resonances amplify it there.
    ///
    /// The residual of several sets of made-up noise is averaged over neighbouring lines.
    fn scale_noise(&mut self, machine: &Machine) -> Result<()> {
        let Weighting { noise, solver, .. } = &*self.weighting;
        let lines = self.whitening.len();
        let mut square = vec![vec![0.0; self.rows]; lines];
        let evaluated: Vec<Evaluated> =
            (0..machine.bearings.len()).map(|b| self.evaluated(machine, b)).collect::<Result<_>>()?;
        let tangents: Vec<Vec<Tangent>> = evaluated
            .iter()
            .map(|one| (0..self.motion.len()).map(|t| one.tangent(&self.motion, t)).collect())
            .collect();
        // Force of a bearing by a small displacement.
        let linear = |b: usize, t: usize, x: &Displacement<f64>| -> [f64; D] {
            let force = tangents[b][t] * SVector::from(x.to_array());
            std::array::from_fn(|i| -force[i])
        };
        let inertia = |series: &[[f64; D]]| {
            let spectra = std::array::from_fn(|order| self.transform.five(order, |t| series[t]));
            self.shaft.dynamics.required(&self.transform.lines, &machine.damping, &spectra)
        };
        let add = |sum: &mut [Vec<C>; D], b: usize, of: &dyn Fn(usize) -> [f64; D]| {
            self.shaft.dynamics.add(b, &self.transform.five(0, of), sum);
        };
        let mut correction = inertia(&self.rest);
        for (b, rest) in self.shaft.dynamics.displacements(&self.rest).iter().enumerate() {
            add(&mut correction, b, &|t| linear(b, t, &rest[t]));
        }
        let exact: Vec<Vec<[f64; D]>> = evaluated.iter().map(|one| one.forces(&self.motion)).collect();
        let mut normal = Normal::new();
        for _ in 0..DRAWS {
            let error: Vec<[f64; D]> = (0..self.motion.len())
                .map(|_| solver.pose(&noise.iter().map(|n| n * normal.next()).collect::<Vec<_>>(), 0.0).to_array())
                .collect();
            let passed = self.filter.apply(&error);
            let rest: Vec<[f64; D]> =
                error.iter().zip(&passed).map(|(e, p)| std::array::from_fn(|i| e[i] - p[i])).collect();
            let (passed, rest) = (self.shaft.dynamics.displacements(&passed), self.shaft.dynamics.displacements(&rest));
            let mut force = inertia(&error);
            for (b, one) in evaluated.iter().enumerate() {
                // Odd and even part of the change: the noise of the force, and what is left of it in the mean.
                let change = |t: usize| {
                    let mut odd = linear(b, t, &rest[b][t]);
                    let mut even = [0.0; D];
                    let [with, against] = [1.0, -1.0]
                        .map(|sign| Displacement::from_array(passed[b][t].to_array().map(|x| sign * x)))
                        .map(|error| one.force_with(&self.motion, t, &error));
                    let without = exact[b][t];
                    for i in 0..D {
                        odd[i] += with[i] - without[i];
                        even[i] += 0.5 * (with[i] + against[i]) - without[i];
                    }
                    (odd, even)
                };
                let changes: Vec<([f64; D], [f64; D])> = (0..self.motion.len()).map(change).collect();
                add(&mut force, b, &|t| changes[t].0);
                add(&mut correction, b, &|t| changes[t].1.map(|x| -x / DRAWS as f64));
            }
            let residual = self.at_probes(&force);
            for (k, squares) in square.iter_mut().enumerate() {
                for (p, square) in squares.iter_mut().enumerate() {
                    let at = 2 * (k * self.rows + p);
                    *square += 0.5 * (residual[at].powi(2) + residual[at + 1].powi(2)) / DRAWS as f64;
                }
            }
        }
        for (k, rows) in self.whitening.iter_mut().enumerate().skip(MEAN_LINES) {
            let around = &square[k.saturating_sub(NEIGHBOURS).max(MEAN_LINES)..(k + NEIGHBOURS + 1).min(lines)];
            for (p, row) in rows.iter_mut().enumerate() {
                // The mean of the inverse of a sum of n squares is n / (n - 2) times the inverse of its mean.
                let values = 2.0 * (around.len() * DRAWS) as f64;
                let mean = around.iter().map(|squares| squares[p]).sum::<f64>() / around.len() as f64 * values
                    / (values - 2.0);
                self.noise_scale[k][p] = mean.sqrt();
                row.iter_mut().for_each(|a| *a /= mean.sqrt());
            }
        }
        self.correction = correction;
        Ok(())
    }

    /// Returns the spectra of a machine.
    pub fn spectra(&self, machine: &Machine) -> Result<Spectra> {
        let bearings = (0..machine.bearings.len()).map(|i| self.bearing(machine, i)).collect::<Result<_>>()?;
        Ok(Spectra { bearings, rotor: self.rotor(machine) })
    }

    /// Returns the spectra of a force at bearing `b`, sample by sample, as one about the centre of mass.
    pub fn about_centre(&self, b: usize, of: &dyn Fn(usize) -> [f64; D]) -> [Vec<C>; D] {
        let mut sum: [Vec<C>; D] = std::array::from_fn(|_| vec![C::new(0.0, 0.0); self.transform.lines.len()]);
        self.shaft.dynamics.add(b, &self.transform.five(0, of), &mut sum);
        sum
    }

    fn bearing(&self, machine: &Machine, i: usize) -> Result<[Vec<C>; D]> {
        let evaluated = self.evaluated(machine, i)?;
        let forces = evaluated.forces(&self.motion);
        let mut spectra = self.transform.five(0, |t| forces[t]);
        if let Some(pulses) = evaluated.pulses(&self.motion) {
            for (sum, part) in spectra.iter_mut().zip(self.transform.five_fine(&pulses)) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
        }
        let mut about_centre: [Vec<C>; D] = std::array::from_fn(|_| vec![C::new(0.0, 0.0); spectra[0].len()]);
        self.shaft.dynamics.add(i, &spectra, &mut about_centre);
        Ok(about_centre)
    }

    /// Load, unbalance, inertia and damping: what the rotor's motion requires, as a force with the opposite sign.
    fn rotor(&self, machine: &Machine) -> [Vec<C>; D] {
        let mut sum = self.shaft.dynamics.required(&self.transform.lines, &machine.damping, &self.displacement);
        for part in [
            self.shaft.dynamics.unbalance(machine.unbalance, &self.unit_unbalance_lines),
            self.shaft.dynamics.load(&machine.load, &self.gravity, &self.constant),
        ] {
            for (sum, part) in sum.iter_mut().zip(part) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
        }
        sum
    }

    /// Returns the spectra of `machine`, which differs from that of `from` in one part only.
    pub fn changed(&self, from: &Spectra, machine: &Machine, part: Part) -> Result<Spectra> {
        let mut spectra = from.clone();
        match part {
            Part::Bearing(i) => spectra.bearings[i] = self.bearing(machine, i)?,
            Part::Rotor => {
                spectra.rotor = self.rotor(machine);
                if self.shaft.dynamics.is_elastic() {
                    for i in 0..machine.bearings.len() {
                        spectra.bearings[i] = self.bearing(machine, i)?;
                    }
                }
            }
        }
        Ok(spectra)
    }

    /// Returns the unexplained force.
    pub fn force(&self, spectra: &Spectra) -> [Vec<C>; D] {
        let mut sum = spectra.rotor.clone();
        for (sum, part) in sum.iter_mut().zip(&self.correction) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        for bearing in &spectra.bearings {
            for (sum, part) in sum.iter_mut().zip(bearing) {
                for (sum, part) in sum.iter_mut().zip(part) {
                    *sum += part;
                }
            }
        }
        sum
    }

    /// Returns the displacement that a force causes at the mean stiffness, over the noise scale of its line; the axial coordinate
    /// is held where it is not measured.
    ///
    /// The stiffness changes along the motion: at a resonance of its mean, the displacement alone would be too large.
    pub fn displacement_by(&self, force: &[Vec<C>; D]) -> [Vec<C>; D] {
        let mut out: [Vec<C>; D] = Default::default();
        for (k, w) in self.transform.lines.iter().enumerate() {
            let stiffness = self.held(self.dynamic_stiffness(&self.reference, k, *w));
            let force = SVector::<C, D>::from_fn(|i, _| force[i][k]);
            let caused = stiffness.lu().solve(&force).unwrap_or_else(SVector::zeros);
            let scale = self.noise_scale[k].iter().sum::<f64>() / self.rows.max(1) as f64;
            out.iter_mut().zip(caused.iter()).for_each(|(out, x)| out.push(*x / scale));
        }
        out
    }

    /// Returns a force as a residual at the probes in units of their noise: line by line, probe by probe, real and imaginary
    /// part.
    pub fn at_probes(&self, force: &[Vec<C>; D]) -> Vec<f64> {
        let mut residual = whitened(&self.whitening, force);
        for Direction { unit, share } in &self.tolerance {
            let along = share * dot(unit, &residual);
            residual.iter_mut().zip(unit).for_each(|(r, unit)| *r -= along * unit);
        }
        residual
    }

    /// Returns the residual of a machine.
    pub fn residual(&self, spectra: &Spectra) -> Vec<f64> {
        self.at_probes(&self.force(spectra))
    }

    /// Returns the longest step of an unknown within which the residual is about linear.
    pub fn longest_step(&self, unknown: Unknown) -> f64 {
        let turns = (self.motion.turns[self.motion.len() - 1] - self.motion.turns[0]).abs();
        match unknown {
            Unknown::CagePhase(b) => 0.1 / self.plant.bearings[b].elements as f64,
            Unknown::CageSlip(b) | Unknown::SpinSlip(b) => 0.2 / (self.plant.bearings[b].elements as f64 * 0.4 * turns),
            Unknown::SpallAzimuth(..) => 0.1,
            Unknown::SpallWidth(..) => 0.01,
            Unknown::SpallDepth(..) => 5e-7,
            Unknown::Clearance(_) => 5e-6,
            Unknown::Tilt(..) => 2e-4,
            Unknown::Modulus(_) => 2e10,
            Unknown::Damping(_) => 1e3,
            _ => f64::INFINITY,
        }
    }

    /// Returns the change of the residual by one unknown.
    pub fn slope(&self, spectra: &Spectra, machine: &Machine, unknown: Unknown) -> Result<Vec<f64>> {
        Ok(self.at_probes(&self.force_slope(spectra, machine, unknown)?))
    }

    fn force_slope(&self, spectra: &Spectra, machine: &Machine, unknown: Unknown) -> Result<[Vec<C>; D]> {
        let mut other = machine.clone();
        let h = unknown.step();
        unknown.set(&mut other, unknown.get(machine) + h);
        let changed = self.changed(spectra, &other, unknown.part())?;
        let mut difference: [Vec<C>; D] = Default::default();
        let pairs = changed.bearings.iter().zip(&spectra.bearings);
        let all = match unknown.part() {
            Part::Bearing(i) => vec![(&changed.bearings[i], &spectra.bearings[i])],
            Part::Rotor if self.shaft.dynamics.is_elastic() => {
                pairs.chain(std::iter::once((&changed.rotor, &spectra.rotor))).collect()
            }
            Part::Rotor => vec![(&changed.rotor, &spectra.rotor)],
        };
        for (i, difference) in difference.iter_mut().enumerate() {
            *difference = vec![C::new(0.0, 0.0); self.transform.lines.len()];
            for (after, before) in &all {
                let parts = after[i].iter().zip(&before[i]);
                difference.iter_mut().zip(parts).for_each(|(d, (a, b))| *d += (a - b) / h);
            }
        }
        Ok(difference)
    }
}

/// Returns a force in whitened displacements: line by line, row by row, real and imaginary part.
fn whitened(whitening: &[Vec<[C; D]>], force: &[Vec<C>; D]) -> Vec<f64> {
    let rows = whitening.first().map_or(0, Vec::len);
    let mut out = Vec::with_capacity(whitening.len() * rows * 2);
    for (k, rows) in whitening.iter().enumerate() {
        for row in rows {
            let sum: C = row.iter().zip(force).map(|(a, f)| a * f[k]).sum();
            out.push(sum.re);
            out.push(sum.im);
        }
    }
    out
}

/// Normally distributed numbers, the same in every run (xorshift and Box-Muller).
pub(super) struct Normal {
    state: u64,
}

impl Normal {
    pub fn new() -> Self {
        Self { state: 0x9e37_79b9_7f4a_7c15 }
    }

    fn uniform(&mut self) -> f64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        ((self.state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub fn next(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}
