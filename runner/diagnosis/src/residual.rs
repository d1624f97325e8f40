//! The force that a machine leaves unexplained, as a residual at the probes in units of their noise; `weights` has that noise.

mod axial;
mod position;
pub mod site;
mod weights;

use super::Result;
use super::dynamics::{Dynamics, LEAD, Square, Tangent, UnitResponses};
use super::filter::{Filtered, LineFilter};
use super::machine::{Evaluated, Machine, MachineBearing};
use super::measurement::Site;
use super::motion::{C, D, Motion, Transform};
use super::parameter::{CAGE_PHASE, ForceSource, Unknown};
use ballrace::Displacement;
use ballrace_base::least_squares::dot;
use ballrace_base::parallel;
use ballrace_plant::Plant;
use ballrace_plant::probes::PoseSolver;
use ballrace_scene::{Probe, Scene};
use nalgebra::{DMatrix, SVector};
use std::sync::Arc;
#[cfg(test)]
pub(super) use weights::Normal;

/// Lead and rise of the window, as shares of the record. A flexible rotor vibrates freely for some time without motion at its probes:
/// the window changes little in that time.
const RIGID_WINDOW: [f64; 2] = [0.0, 0.12];
const ELASTIC_WINDOW: [f64; 2] = [LEAD, 0.4];
/// Lines over which the window spreads a mean.
pub(crate) const MEAN_LINES: usize = 5;
/// Relative standard deviation of a shaft's elasticity: Young's modulus of steels differs by 2 %, shrunk-on parts stiffen the shaft.
const ELASTICITY_ERROR: f64 = 0.02;
/// Rounds in which moments and displacements of the bearings of an elastic rotor are found.
const MOMENT_ROUNDS: usize = 2;

/// Weighting of residuals: probes with their noise.
pub(super) struct Weighting {
    pub probes: Vec<Probe>,
    /// Rms noise of each probe, m.
    pub noise: Vec<f64>,
    pub solver: PoseSolver,
    /// Without one, the axial coordinate of a rigid rotor is computed from the forces of the bearings at the measured radial motion.
    pub has_axial_probe: bool,
}

impl Weighting {
    /// Returns the standard deviation of each coordinate of a pose by the noise of the probes.
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

    /// Returns the standard deviation that the noise of the probes causes in the reading of the pose by a probe with this row.
    fn reading_noise(&self, row: &[f64; D]) -> f64 {
        let by = |p: usize| {
            let alone: Vec<f64> = self.noise.iter().enumerate().map(|(i, n)| if i == p { *n } else { 0.0 }).collect();
            row.iter().zip(self.solver.pose(&alone, 0.0).to_array()).map(|(a, x)| a * x).sum::<f64>().powi(2)
        };
        (0..self.noise.len()).map(by).sum::<f64>().sqrt()
    }
}

/// Recording to which hypotheses are compared, weighted for one machine.
#[derive(Clone)]
pub(super) struct Evidence<'a> {
    pub scene: &'a Scene,
    pub plant: &'a Plant,
    pub motion: Arc<Motion>,
    pub transform: Arc<Transform>,
    /// Spectra of q, w' q and w'' q, with q the lines above the noise and w the window.
    displacement: Arc<[[Vec<C>; D]; 3]>,
    weighting: Arc<Weighting>,
    shaft: Shaft,
    /// The same rotor with a stiffer shaft, by [`ELASTICITY_ERROR`]; `None` for a rigid rotor.
    stiffer: Option<Shaft>,
    /// Displacement of the rotor at each bearing, with unbalance, load and moments of the machine by which the residual is weighted.
    displaced: Vec<Arc<Vec<Displacement<f64>>>>,
    /// Unbalance and load of that machine.
    given: ([f64; 4], [f64; D]),
    /// Spectra of the force along X and Y of a unit unbalance at angle 0.
    unit_unbalance_lines: Arc<[Vec<C>; 2]>,
    /// Spectra of cosine and sine of the shaft angle, and of twice that.
    harmonic_lines: Arc<[[Vec<C>; 2]; 2]>,
    /// Spectrum of 1.
    constant: Arc<Vec<C>>,
    /// Per line: whitened displacement per unit of force about the centre of mass.
    whitening: Vec<Vec<[C; D]>>,
    /// The same per unit of force at each bearing.
    pub whitening_of_bearing: Vec<Vec<Vec<[C; D]>>>,
    /// Per line and row: noise of the whitened residual over that of the displacement.
    noise_scale: Vec<Vec<f64>>,
    /// No probe measures the axial coordinate, and the bearings have an axial stiffness.
    is_axially_free: bool,
    /// Parameters that are not exactly known, with a root of their covariance.
    uncertain: Option<(Vec<Unknown>, DMatrix<f64>)>,
    /// Changes of the whitened residual of the machine by which it is weighted, by each of them.
    uncertain_slopes: Arc<Vec<Vec<f64>>>,
    /// Relative error of the model at the lines of a fault whose size is estimated; `None` while faults are searched.
    error_at_fault: Option<f64>,
    /// Directions of the whitened residual that they lead to.
    tolerance: Vec<Direction>,
    /// Mean stiffness of the machine by which the residual is weighted, and its dynamic stiffness line by line.
    reference: MeanStiffness,
    reference_lines: Arc<Vec<Square>>,
    /// Values of a residual per line.
    pub rows: usize,
    filter: Arc<LineFilter>,
    /// The part of the displacement that the filter removed, and its spectrum.
    rest: Arc<Vec<[f64; D]>>,
    rest_lines: Arc<[Vec<C>; D]>,
    /// Forces that `rest` requires and causes in the machine by which the residual is weighted, linearised, less the mean change of
    /// the force by noise that passes the filter. It is mostly noise, which must not depend on the unknowns of a fit: a fit would
    /// lower the noise by less damping.
    correction: [Vec<C>; D],
    gravity: [f64; D],
    /// Errors of the readings, in a recording of a site.
    pub site: Option<Arc<Site>>,
    /// Spectrum of the displacement that was subtracted as errors of the readings; empty without a site.
    subtracted: Arc<[Vec<C>; D]>,
    /// Per line: inverse root of the covariance of the whitened residual by what a site adds to the noise; empty without a site.
    narrowing: Vec<DMatrix<C>>,
}

/// Relations between the rotor's stations, applied to a motion.
#[derive(Clone)]
struct Shaft {
    dynamics: Arc<Dynamics>,
    /// Displacement of the rotor at each bearing by the pose alone.
    by_pose: Arc<Vec<Vec<Displacement<f64>>>>,
    /// Displacement of the bearings by a unit unbalance.
    unit_responses: Option<Arc<UnitResponses>>,
}

impl Shaft {
    /// Creates the relations; `None` if the rotor cannot be diagnosed.
    fn new(
        scene: &Scene,
        plant: &Plant,
        weighting: &Weighting,
        transform: &Transform,
        (motion, pose): (&Motion, &[[f64; D]]),
    ) -> Option<Self> {
        let of_probes = (weighting.probes.as_slice(), &weighting.solver);
        // The plant is built from this rotor, so that it can be reduced.
        let dynamics = Dynamics::new(scene, plant, of_probes, &transform.lines, motion.mean_speed()).ok()??;
        Some(Self {
            by_pose: Arc::new(dynamics.displacements(pose)),
            unit_responses: dynamics.unit_responses(&motion.unit_unbalance()).map(Arc::new),
            dynamics: Arc::new(dynamics),
        })
    }

    /// Returns the relations applied to another pose in the same motion of the shaft.
    fn moved(&self, pose: &[[f64; D]]) -> Self {
        Self { by_pose: Arc::new(self.dynamics.displacements(pose)), ..self.clone() }
    }
}

/// A direction of the whitened residual with the share of it that is subtracted from a residual.
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

/// Forces of a bearing on the rotor: sample by sample, and their spectra about the centre of mass.
#[derive(Clone)]
pub(crate) struct BearingForces {
    samples: Arc<Vec<[f64; D]>>,
    spectra: [Vec<C>; D],
}

/// Spectra of the forces of each part of a machine, and their sum as a residual.
#[derive(Clone)]
pub struct Spectra {
    bearings: Vec<BearingForces>,
    rotor: [Vec<C>; D],
    /// What errors of the readings that a machine has stand for; nothing without them.
    readings: [Vec<C>; D],
}

impl Spectra {
    /// Returns the spectra with another force of one bearing.
    pub fn replaced(&self, bearing: usize, force: BearingForces) -> Self {
        let mut spectra = self.clone();
        spectra.bearings[bearing] = force;
        spectra
    }
}

impl<'a> Evidence<'a> {
    /// Creates the evidence; `None` if the rotor cannot be diagnosed. The next call must be [`Evidence::weight_for`].
    ///
    /// # Errors
    /// Returns an error if a bearing cannot be built or the rotor cannot be reduced.
    pub fn new(
        scene: &'a Scene,
        plant: &'a Plant,
        mut motion: Motion,
        highest: f64,
        weighting: Arc<Weighting>,
    ) -> Result<Option<Self>> {
        let Some(rotor) = scene.rotor.as_ref() else { return Ok(None) };
        let transform = Transform::new(
            motion.len(),
            motion.period,
            highest,
            if plant.layout.is_rigid() { RIGID_WINDOW } else { ELASTIC_WINDOW },
        );
        let filtered = Filtered::new(&mut motion, weighting.pose_noise(), &transform);
        let [gx, gy, gz] = rotor.gravity;
        let gravity = [gx * rotor.mass, gy * rotor.mass, gz * rotor.mass, 0.0, 0.0];
        let unit_unbalance = motion.unit_unbalance();
        let harmonic_lines = [1, 2].map(|order| {
            let of = motion.harmonic(order);
            transform.pair(0, |t| of[t][0], |t| of[t][1])
        });
        let Some(shaft) = Shaft::new(scene, plant, &weighting, &transform, (&motion, &filtered.q)) else {
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
            stiffer = Shaft::new(&scene, plant, &weighting, &transform, (&motion, &filtered.q));
        }
        Ok(Some(Self {
            scene,
            plant,
            rest_lines: filtered.rest_lines,
            unit_unbalance_lines: Arc::new(transform.pair(0, |t| unit_unbalance[t][0], |t| unit_unbalance[t][1])),
            harmonic_lines: Arc::new(harmonic_lines),
            constant: Arc::new(transform.pair(0, |_| 1.0, |_| 0.0)[0].clone()),
            motion: Arc::new(motion),
            transform: Arc::new(transform),
            displacement: filtered.displacement,
            weighting,
            shaft,
            stiffer,
            displaced: vec![],
            given: ([0.0; 4], [0.0; D]),
            whitening: vec![],
            whitening_of_bearing: vec![],
            noise_scale: vec![],
            is_axially_free: false,
            uncertain: None,
            uncertain_slopes: Arc::default(),
            error_at_fault: None,
            tolerance: vec![],
            reference: MeanStiffness::default(),
            reference_lines: Arc::default(),
            rows: 0,
            filter: Arc::new(filtered.filter),
            rest: Arc::new(filtered.rest),
            correction: Default::default(),
            gravity,
            site: None,
            subtracted: Arc::default(),
            narrowing: vec![],
        }))
    }

    /// Returns the evidence of the same record with another displacement in the same motion of the shaft. The next call must be
    /// [`Evidence::weight_for`].
    pub fn with_motion(&self, mut motion: Motion) -> Self {
        let Filtered { filter, q, rest, displacement, rest_lines } =
            Filtered::new(&mut motion, self.weighting.pose_noise(), &self.transform);
        Self {
            motion: Arc::new(motion),
            displacement,
            shaft: self.shaft.moved(&q),
            stiffer: self.stiffer.as_ref().map(|stiffer| stiffer.moved(&q)),
            displaced: vec![],
            filter: Arc::new(filter),
            rest: Arc::new(rest),
            rest_lines,
            ..self.clone()
        }
    }

    /// Returns true if a probe measures the axial motion.
    pub fn has_axial_probe(&self) -> bool {
        self.weighting.has_axial_probe
    }

    /// Returns true if the axial motion is computed: no probe measures it, and the rotor is rigid.
    pub(crate) fn follows_axially(&self) -> bool {
        !self.weighting.has_axial_probe && !self.is_elastic()
    }

    /// Returns the standard deviation that the noise of the probes causes in the reading of the pose by a probe with this row.
    pub(crate) fn reading_noise(&self, row: &[f64; D]) -> f64 {
        self.weighting.reading_noise(row)
    }

    /// Applies a changed axial coordinate of the motion of a rigid rotor.
    fn set_axial_motion(&mut self) {
        let q: Vec<[f64; D]> = self.motion.q.iter().map(|q| q.to_array()).collect();
        let mut displacement = (*self.displacement).clone();
        for (order, displacement) in displacement.iter_mut().enumerate() {
            [displacement[2], displacement[3]] = self.transform.axial_pair(order, |t| q[t]);
        }
        self.displacement = Arc::new(displacement);
        self.shaft.by_pose = Arc::new(self.shaft.dynamics.displacements(&q));
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
    pub(crate) fn evaluated_as(&self, machine: &Machine, b: usize, of: &MachineBearing) -> Result<Evaluated> {
        Evaluated::new(self.scene, self.plant, b, of, self.displaced(machine, b))
    }

    /// Returns the displacement of the rotor at bearing `b`: unbalance and load of the machine bend an elastic rotor.
    fn displaced(&self, machine: &Machine, b: usize) -> Arc<Vec<Displacement<f64>>> {
        let displaced = self.displaced_by_loads(machine, b);
        if machine.position == [0.0; D] {
            return displaced;
        }
        let moved = self.shaft.dynamics.displacements(&[machine.position])[b][0];
        Arc::new(displaced.iter().map(|u| *u + moved).collect())
    }

    fn displaced_by_loads(&self, machine: &Machine, b: usize) -> Arc<Vec<Displacement<f64>>> {
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

    /// Returns true where unbalance and load move the bearings while the probes stay.
    pub fn is_elastic(&self) -> bool {
        self.shaft.dynamics.is_elastic()
    }

    /// Returns the residual of a machine with these spectra in the weights of its own.
    ///
    /// In these the noise of the probes does not depend on the machine, so that the fit of a machine as a whole has no advantage
    /// from less damping or stiffness. The noise of the bearing forces over that of the probes is taken from the machine by which
    /// the residual is weighted.
    pub(crate) fn own_residual(&self, machine: &Machine, spectra: &Spectra) -> Result<Vec<f64>> {
        let own = self.mean_stiffness(machine)?;
        let mut force = self.force(spectra);
        self.stiffen(&mut force, &own);
        Ok(whitened(&self.own_whitening(&own), &force))
    }

    /// Returns the changes of [`Evidence::own_residual`] by each unknown. With `d` the displacement that the unexplained force
    /// causes, the change of the weights is that of the mean dynamic stiffness times `-d`.
    pub(crate) fn own_slopes(
        &self,
        spectra: &Spectra,
        machine: &Machine,
        unknowns: &[Unknown],
    ) -> Result<Vec<Vec<f64>>> {
        let own = self.mean_stiffness(machine)?;
        let whitening = self.own_whitening(&own);
        let mut force = self.force(spectra);
        self.stiffen(&mut force, &own);
        let moved = |(k, w): (usize, &f64)| {
            let unexplained = SVector::<C, D>::from_fn(|i, _| force[i][k]);
            let caused = self.dynamic_stiffness(&own, k, *w).lu().solve(&unexplained).unwrap_or_else(SVector::zeros);
            caused
                + SVector::<C, D>::from_fn(|i, _| {
                    self.rest_lines[i][k] + self.subtracted[i].get(k).copied().unwrap_or_default()
                })
        };
        let moved: Vec<SVector<C, D>> = self.transform.lines.iter().enumerate().map(moved).collect();
        let mut force_slopes = self.force_slopes(spectra, machine, unknowns)?;
        let moved_by = self.keep_mean_forces(spectra, machine, force_slopes.iter_mut())?;
        let all: Vec<usize> = (0..unknowns.len()).collect();
        let slope = |&i: &usize| {
            let (unknown, mut slope) = (unknowns[i], force_slopes[i].clone());
            if unknown.parameter.changes_stiffness {
                let mut other = machine.clone();
                let h = unknown.parameter.step;
                unknown.set(&mut other, unknown.get(machine) + h);
                other.position.iter_mut().zip(moved_by[i]).for_each(|(x, moved)| *x += h * moved);
                let other = self.mean_stiffness(&other)?;
                for ((k, w), moved) in self.transform.lines.iter().enumerate().zip(&moved) {
                    let change = self.dynamic_stiffness(&other, k, *w) - self.dynamic_stiffness(&own, k, *w);
                    let by_stiffness = change * moved / C::new(h, 0.0);
                    slope.iter_mut().zip(by_stiffness.iter()).for_each(|(slope, x)| slope[k] -= x);
                }
            }
            Ok(whitened(&whitening, &slope))
        };
        parallel::map(&all, slope).into_iter().collect()
    }

    /// Adds the force that another mean stiffness requires for the part of the displacement that the filter removed.
    fn stiffen(&self, force: &mut [Vec<C>; D], own: &MeanStiffness) {
        for (k, w) in self.transform.lines.iter().enumerate() {
            let change = self.dynamic_stiffness(own, k, *w) - self.reference_lines[k];
            for (i, force) in force.iter_mut().enumerate() {
                let rest = |j: usize| self.rest_lines[j][k] + self.subtracted[j].get(k).copied().unwrap_or_default();
                force[k] -= (0..D).map(|j| change[(i, j)] * rest(j)).sum::<C>();
            }
        }
    }

    /// Returns the spectra of a machine.
    pub fn spectra(&self, machine: &Machine) -> Result<Spectra> {
        let bearings = (0..machine.bearings.len()).map(|i| self.bearing(machine, i)).collect::<Result<_>>()?;
        Ok(Spectra { bearings, rotor: self.rotor(machine), readings: self.readings(&machine.readings) })
    }

    /// Returns a force at bearing `b` with its spectra.
    pub(crate) fn at_bearing(&self, b: usize, samples: Vec<[f64; D]>) -> BearingForces {
        BearingForces { spectra: self.about_centre(b, |t| samples[t]), samples: Arc::new(samples) }
    }

    /// Returns the spectra of a force at bearing `b`, sample by sample, as one about the centre of mass.
    fn about_centre(&self, b: usize, of: impl Fn(usize) -> [f64; D]) -> [Vec<C>; D] {
        let mut sum = self.no_force();
        self.shaft.dynamics.add(b, &self.transform.five(0, of), &mut sum);
        sum
    }

    fn no_force(&self) -> [Vec<C>; D] {
        std::array::from_fn(|_| vec![C::new(0.0, 0.0); self.transform.lines.len()])
    }

    fn bearing(&self, machine: &Machine, i: usize) -> Result<BearingForces> {
        Ok(self.at_bearing(i, self.evaluated(machine, i)?.all_forces(&self.motion)))
    }

    /// Returns load and unbalance, and the force that inertia and damping of the rotor's motion require with the opposite sign.
    fn rotor(&self, machine: &Machine) -> [Vec<C>; D] {
        let mut sum = self.shaft.dynamics.required(&self.transform.lines, &machine.damping, &self.displacement);
        for part in [
            self.shaft.dynamics.unbalance(machine.unbalance, &self.unit_unbalance_lines),
            self.shaft.dynamics.load(&machine.load, &self.gravity, &self.constant),
            Dynamics::coupling(&machine.coupling, &self.harmonic_lines),
        ] {
            for (sum, part) in sum.iter_mut().zip(part) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
        }
        sum
    }

    /// Returns the spectra of `machine`, which differs from that of `from` in one part only.
    pub fn changed(&self, from: &Spectra, machine: &Machine, part: ForceSource) -> Result<Spectra> {
        let mut spectra = from.clone();
        match part {
            ForceSource::Bearing(i) => spectra.bearings[i] = self.bearing(machine, i)?,
            ForceSource::Readings => spectra.readings = self.readings(&machine.readings),
            ForceSource::Rotor => {
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
        for part in [&self.correction, &spectra.readings] {
            for (sum, part) in sum.iter_mut().zip(part) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
        }
        for bearing in &spectra.bearings {
            for (sum, part) in sum.iter_mut().zip(&bearing.spectra) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
        }
        sum
    }

    /// Returns the displacement that a force causes at the mean stiffness, over the noise scale of its line; the axial coordinate
    /// is held where it is not measured.
    ///
    /// The stiffness changes along the motion: at a resonance of its mean, the displacement alone would be too large.
    pub(crate) fn displacement_by(&self, force: &[Vec<C>; D]) -> [Vec<C>; D] {
        let mut out: [Vec<C>; D] = Default::default();
        for (k, stiffness) in self.reference_lines.iter().enumerate() {
            let stiffness = self.held(*stiffness);
            let force = SVector::<C, D>::from_fn(|i, _| force[i][k]);
            let caused = stiffness.lu().solve(&force).unwrap_or_else(SVector::zeros);
            let scale = self.noise_scale[k].iter().sum::<f64>() / self.rows.max(1) as f64;
            out.iter_mut().zip(caused.iter()).for_each(|(out, x)| out.push(*x / scale));
        }
        out
    }

    /// Returns a force as a residual at the probes in units of their noise: line by line, probe by probe, real and imaginary
    /// part.
    pub(crate) fn at_probes(&self, force: &[Vec<C>; D]) -> Vec<f64> {
        self.tolerated(whitened(&self.whitening, force))
    }

    /// Subtracts from a residual the part that the uncertain parameters explain.
    fn tolerated(&self, mut residual: Vec<f64>) -> Vec<f64> {
        for Direction { unit, share } in &self.tolerance {
            let along = share * dot(unit, &residual);
            residual.iter_mut().zip(unit).for_each(|(r, unit)| *r -= along * unit);
        }
        residual
    }

    /// Returns the change of the residual of a machine by one deviation of each independent uncertain parameter, less the change that
    /// is subtracted from every residual: the same fault has another force where the bearing is stiffer.
    pub(crate) fn uncertain_changes(&self, spectra: &Spectra, machine: &Machine) -> Result<Vec<Vec<f64>>> {
        let Some((unknowns, root)) = &self.uncertain else { return Ok(vec![]) };
        let slopes = self.slopes_of_uncertain(spectra, machine, unknowns)?;
        let differs = |(mut slope, reference): (Vec<f64>, &Vec<f64>)| {
            slope.iter_mut().zip(reference).for_each(|(slope, x)| *slope -= x);
            self.tolerated(slope)
        };
        let slopes: Vec<Vec<f64>> = slopes.into_iter().zip(self.uncertain_slopes.iter()).map(differs).collect();
        let change = |column: usize| {
            let mut sum = vec![0.0; slopes.first().map_or(0, Vec::len)];
            for (slope, weight) in slopes.iter().zip(root.column(column).iter()) {
                sum.iter_mut().zip(slope).for_each(|(sum, x)| *sum += weight * x);
            }
            sum
        };
        Ok((0..unknowns.len()).map(change).collect())
    }

    /// Returns the residual of a machine.
    pub fn residual(&self, spectra: &Spectra) -> Vec<f64> {
        self.at_probes(&self.force(spectra))
    }

    /// Returns the longest step of an unknown within which the residual is about linear.
    pub fn longest_step(&self, unknown: Unknown) -> f64 {
        let turns = (self.motion.turns[self.motion.len() - 1] - self.motion.turns[0]).abs();
        let elements = self.plant.bearings.get(unknown.bearing).map_or(0, |bearing| bearing.elements);
        (unknown.parameter.longest_step)(elements as f64, turns)
    }

    /// Returns the change of the residual by each unknown.
    pub fn slopes(&self, spectra: &Spectra, machine: &Machine, unknowns: &[Unknown]) -> Result<Vec<Vec<f64>>> {
        let slopes = self.force_slopes(spectra, machine, unknowns)?;
        Ok(parallel::map(&slopes, |slope| self.at_probes(slope)))
    }

    /// Returns the standard deviation to which a parameter was known before; 0 where it is taken as exact.
    pub fn known_deviation(&self, unknown: Unknown) -> f64 {
        let Some((unknowns, root)) = &self.uncertain else { return 0.0 };
        unknowns.iter().position(|own| *own == unknown).map_or(0.0, |i| root.row(i).norm())
    }

    /// Returns the change of the unexplained force by each unknown.
    fn force_slopes(&self, spectra: &Spectra, machine: &Machine, unknowns: &[Unknown]) -> Result<Vec<[Vec<C>; D]>> {
        let turned: Vec<usize> = (0..machine.bearings.len())
            .filter(|b| unknowns.iter().any(|u| u.is_of_cage() && u.bearing == *b))
            .collect();
        let by_angle = |b: &usize| Ok((*b, self.change_by_cage_angle(spectra, machine, *b)?));
        let by_angle: Vec<(usize, Vec<[f64; D]>)> =
            parallel::map(&turned, by_angle).into_iter().collect::<Result<_>>()?;
        let slope = |u: &Unknown| {
            let changes = by_angle.iter().find(|(b, _)| u.is_of_cage() && *b == u.bearing);
            let Some((b, changes)) = changes else { return self.force_slope(spectra, machine, *u) };
            let rolling = self.plant.bearings[*b].kinematics.cage_ratio;
            let slope = |t: usize| {
                let turned = u.turns_of_cage(rolling, self.motion.turns[t], &self.motion);
                changes[t].map(|x| x * turned)
            };
            Ok(self.about_centre(*b, slope))
        };
        parallel::map(unknowns, slope).into_iter().collect()
    }

    /// Returns the change of the force of a bearing per revolution of its cage at every sample: angle, slip and drift of the cage all turn it.
    fn change_by_cage_angle(&self, spectra: &Spectra, machine: &Machine, b: usize) -> Result<Vec<[f64; D]>> {
        let mut turned = machine.bearings[b].clone();
        let step = CAGE_PHASE.step;
        turned.cage.phase += step;
        let after = self.evaluated_as(machine, b, &turned)?.all_forces(&self.motion);
        let before = spectra.bearings[b].samples.iter();
        Ok(after.iter().zip(before).map(|(a, b)| std::array::from_fn(|i| (a[i] - b[i]) / step)).collect())
    }

    fn force_slope(&self, spectra: &Spectra, machine: &Machine, unknown: Unknown) -> Result<[Vec<C>; D]> {
        let mut other = machine.clone();
        let h = unknown.parameter.step;
        unknown.set(&mut other, unknown.get(machine) + h);
        let changed = self.changed(spectra, &other, unknown.part())?;
        let pair = |i: usize| (&changed.bearings[i].spectra, &spectra.bearings[i].spectra);
        let rotor = (&changed.rotor, &spectra.rotor);
        let all = match unknown.part() {
            ForceSource::Bearing(i) => vec![pair(i)],
            ForceSource::Rotor if self.shaft.dynamics.is_elastic() => {
                (0..spectra.bearings.len()).map(pair).chain([rotor]).collect()
            }
            ForceSource::Rotor => vec![rotor],
            ForceSource::Readings => vec![(&changed.readings, &spectra.readings)],
        };
        let mut difference = self.no_force();
        for (i, difference) in difference.iter_mut().enumerate() {
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
