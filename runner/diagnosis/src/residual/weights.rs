//! Noise of a residual: the weights by which forces become displacements at the probes in units of their noise.

use super::super::Result;
use super::super::dynamics::{Square, Tangent};
use super::super::machine::{Evaluated, Machine};
use super::super::motion::{C, D, Motion};
use super::super::parameter::{ForceSource, Unknown};
use super::site::half_width;
use super::{Direction, ELASTICITY_ERROR, Evidence, MEAN_LINES, MeanStiffness, Spectra, Weighting, whitened};
use ballrace::Displacement;
use ballrace_base::least_squares::dot;
use ballrace_base::parallel;
use ballrace_plant::probes;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::sync::Arc;

/// Lines on each side over which the noise is estimated.
const NEIGHBOURS: usize = 6;
/// Number of sets of simulated noise from which the noise of the residual is estimated.
const DRAWS: usize = 3;
/// Square of the change of the residual, in units of the noise, below which the uncertainty of a parameter is neglected.
const MIN_TOLERANCE: f64 = 1e-3;

/// Standard deviation of the instant of a mark, in samples: it lies anywhere between two of them.
const INSTANT_ERROR: f64 = 0.289;

/// Marks through which the shaft angle is smoothed.
const MARKS: usize = 11;

/// Share of the deviation of a learned parameter by which it moves the residual of a later recording of a site: what a wrong parameter moves
/// in the baseline as well is part of the gaps and lines that are learned with it.
const LEFT_BY_BASELINE: f64 = 0.1;

impl Evidence<'_> {
    /// Sets the mean stiffness at which forces and displacements are converted.
    pub(super) fn set_reference(&mut self, mean: MeanStiffness) {
        let lines = self.transform.lines.iter().enumerate();
        self.reference_lines = Arc::new(lines.map(|(k, w)| self.dynamic_stiffness(&mean, k, *w)).collect());
        self.reference = mean;
    }

    /// Weights residuals by the noise that they have with this machine.
    pub(crate) fn weight_for(&mut self, machine: &Machine) -> Result<()> {
        self.refer_to(machine)?;
        self.whitening = self.whitening_of(&self.reference);
        self.whiten_bearings();
        self.rows = self.whitening.first().map_or(0, Vec::len);
        self.noise_scale = vec![vec![1.0; self.rows]; self.whitening.len()];
        self.narrowing.clear();
        self.tolerance.clear();
        self.scale_noise(machine)?;
        let spectra = self.spectra(machine)?;
        if self.site.is_some() {
            self.whiten_bearings();
            self.narrow(&spectra);
        }
        self.whiten_bearings();
        self.tolerate(machine, &spectra)
    }
    /// Converts the weights of forces about the centre of mass to forces at each bearing.
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

    /// Sets the parameters that are known with a covariance, so that their errors are not diagnosed as faults. The next call must be
    /// [`Evidence::weight_for`].
    pub(crate) fn set_uncertain(&mut self, (unknowns, covariance): (Vec<Unknown>, DMatrix<f64>)) {
        let deviations: Vec<f64> = (0..unknowns.len()).map(|i| covariance[(i, i)].sqrt()).collect();
        let correlation = DMatrix::from_fn(unknowns.len(), unknowns.len(), |i, j| {
            covariance[(i, j)] / (deviations[i] * deviations[j])
        });
        let root = correlation.cholesky().map_or_else(|| DMatrix::identity(unknowns.len(), unknowns.len()), |c| c.l());
        let root = DMatrix::from_fn(unknowns.len(), unknowns.len(), |i, j| deviations[i] * root[(i, j)]);
        self.uncertain = Some((unknowns, root));
    }

    /// Takes the uncertain parameters of the same recording. The next call must be [`Evidence::weight_for`].
    pub fn uncertain_as(&mut self, other: &Self) {
        self.uncertain.clone_from(&other.uncertain);
    }

    /// Weights residuals for the sizes of the faults of a machine, whose model has a relative error at their lines: the error also has the motion
    /// that they add, and of that no baseline knows the parameters.
    pub(crate) fn weight_for_sizes(&mut self, machine: &Machine, error: f64) -> Result<()> {
        self.error_at_fault = Some(error);
        self.weight_for(machine)
    }

    /// Returns the share of the deviations of the uncertain parameters that a baseline leaves, line by line.
    fn left_by_baseline(&self) -> Vec<f64> {
        let speed = self.motion.mean_speed().abs().max(f64::MIN_POSITIVE);
        let apart = self.transform.lines.get(1).map_or(1.0, |w| w / speed);
        // The mean and the harmonics of the shaft.
        let is_of_baseline = |k: usize| {
            let order = k as f64 * apart;
            k < MEAN_LINES || (order - order.round()).abs() <= half_width(k) as f64 * apart
        };
        let is_learned = self.site.is_some() && !self.is_without_baseline();
        let is_left = |k: usize| is_learned && (self.error_at_fault.is_none() || is_of_baseline(k));
        (0..self.transform.lines.len()).map(|k| if is_left(k) { LEFT_BY_BASELINE } else { 1.0 }).collect()
    }

    /// Returns the change of the residual by each parameter that is not exactly known, without what a baseline has of it, before anything is
    /// tolerated: at a site the rotor moves with it.
    pub(super) fn slopes_of_uncertain(
        &self,
        spectra: &Spectra,
        machine: &Machine,
        unknowns: &[Unknown],
    ) -> Result<Vec<Vec<f64>>> {
        let mut slopes = self.force_slopes(spectra, machine, unknowns)?;
        // Damping and unbalance have no mean force.
        let is_of_bearing = |unknown: &Unknown| matches!(unknown.part(), ForceSource::Bearing(_));
        let of_bearings = slopes.iter_mut().zip(unknowns).filter(|(_, unknown)| is_of_bearing(unknown));
        self.keep_mean_forces(spectra, machine, of_bearings.map(|(slope, _)| slope))?;
        let left = self.left_by_baseline();
        Ok(parallel::map(&slopes, |slope| {
            let mut slope = whitened(&self.whitening, slope);
            slope
                .chunks_mut(2 * self.rows)
                .zip(&left)
                .for_each(|(line, left)| line.iter_mut().for_each(|x| *x *= left));
            slope
        }))
    }

    /// Finds the directions of the residual along which the uncertain parameters move it.
    ///
    /// With `U = S L` the changes by one deviation of each independent parameter (S the slopes, `L L^T` the covariance) the
    /// covariance of the residual is `1 + U U^T`. From the eigenvalues `d^2` of `U^T U` its inverse root is
    /// `1 - sum q q^T (1 - 1 / sqrt(1 + d^2))`, q the unit vectors `U v / d`.
    fn tolerate(&mut self, machine: &Machine, spectra: &Spectra) -> Result<()> {
        let none = (vec![], DMatrix::zeros(0, 0));
        let (unknowns, known) = self.uncertain.as_ref().unwrap_or(&none);
        let mut slopes = self.slopes_of_uncertain(spectra, machine, unknowns)?;
        let of_uncertain = slopes.clone();
        slopes.extend(self.elasticity_slope(spectra, machine)?);
        slopes.extend(self.instant_slope(spectra, machine)?);
        let n = slopes.len();
        if n == 0 {
            return Ok(());
        }
        // Elasticity and instants are independent of the rest, their slopes those of one deviation.
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
        self.tolerance = (0..n).filter(|&j| eigen.eigenvalues[j] > MIN_TOLERANCE).map(direction).collect();
        self.uncertain_slopes = Arc::new(of_uncertain);
        Ok(())
    }

    /// Returns the change of the residual by a shaft that is stiffer by one deviation; `None` for a rigid rotor.
    fn elasticity_slope(&self, spectra: &Spectra, machine: &Machine) -> Result<Option<Vec<f64>>> {
        let Some(stiffer) = &self.stiffer else { return Ok(None) };
        let mut other = Self { shaft: stiffer.clone(), ..self.clone() };
        other.displace(machine)?;
        let changed = other.residual(&other.spectra(machine)?);
        Ok(Some(changed.iter().zip(self.residual(spectra)).map(|(a, b)| a - b).collect()))
    }

    /// Returns the change of the residual by the unbalance at a shaft angle that is larger by one deviation: the instant at which the mark passes the
    /// keyphasor is known to a sample. The angle of a cage is an unknown of its own. `None` at a site, whose unbalance is less known than that.
    fn instant_slope(&self, spectra: &Spectra, machine: &Machine) -> Result<Option<Vec<f64>>> {
        if self.site.is_some() {
            return Ok(None);
        }
        let error = self.instant_error();
        let unit = self.motion.turned(&|_| error).unit_unbalance();
        let lines = self.transform.pair(0, |t| unit[t][0], |t| unit[t][1]);
        let other = Self { unit_unbalance_lines: Arc::new(lines), ..self.clone() };
        let changed = other.residual(&other.changed(spectra, machine, ForceSource::Rotor)?);
        Ok(Some(changed.iter().zip(self.residual(spectra)).map(|(a, b)| a - b).collect()))
    }

    /// Returns the standard deviation of the shaft angle by the instant of one mark, rad.
    fn instant_error(&self) -> f64 {
        INSTANT_ERROR * self.motion.mean_speed() * self.motion.period
    }

    /// Returns the motion at a shaft angle with errors as the instants of the marks leave them where the speed is no divisor of the rate: each is
    /// smoothed with its neighbours and interpolated between them. `None` at a speed without any change: all marks are off by the same.
    fn motion_by_instants(&self, normal: &mut Normal) -> Option<Motion> {
        if !self.motion.is_turning_unevenly() {
            return None;
        }
        let turns = &self.motion.turns;
        let first = turns.iter().copied().fold(f64::INFINITY, f64::min);
        let last = turns.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let marks: Vec<f64> =
            (0..(last - first) as usize + 1 + MARKS).map(|_| self.instant_error() * normal.next()).collect();
        let smooth: Vec<f64> = marks.windows(MARKS).map(|marks| marks.iter().sum::<f64>() / MARKS as f64).collect();
        Some(self.motion.turned(&|t| {
            let at = turns[t] - first;
            let (mark, share) = (at as usize, at.fract());
            smooth[mark] * (1.0 - share) + smooth[mark + 1] * share
        }))
    }

    pub(super) fn own_whitening(&self, own: &MeanStiffness) -> Vec<Vec<[C; D]>> {
        let mut whitening = self.whitening_of(own);
        for (rows, scales) in whitening.iter_mut().zip(&self.noise_scale) {
            for (row, scale) in rows.iter_mut().zip(scales) {
                row.iter_mut().for_each(|a| *a /= scale);
            }
        }
        self.narrow_weights(&mut whitening);
        whitening
    }

    /// Computes the mean tangent stiffness along the motion.
    pub(super) fn mean_stiffness(&self, machine: &Machine) -> Result<MeanStiffness> {
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

    /// Returns the force that a displacement at line `k`, the angular frequency `w` (rad/s), requires, by the mean stiffness.
    pub(super) fn dynamic_stiffness(&self, of: &MeanStiffness, k: usize, w: f64) -> Square {
        self.shaft.dynamics.stiffness(k, w, &of.damping, &of.tangents)
    }

    /// Returns the rows that convert a pose to displacements in units of the noise of the probes.
    pub(super) fn rows_of_pose(&self) -> Vec<[f64; D]> {
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
        measured.iter().map(|&i| std::array::from_fn(|k| root[(i, k)] * scale[k] / unit)).collect()
    }

    /// Returns the weight of the lines of the mean.
    pub(super) fn mean_weight(&self) -> f64 {
        // The offset of a probe is not known better than its noise, however long the record, and the line of a shaft that bends under its
        // weight no better than its elasticity.
        let least = self.weighting.noise.iter().copied().fold(f64::INFINITY, f64::min);
        let offset = (ELASTICITY_ERROR * self.shaft.dynamics.sag(&self.given.1, &self.gravity) / least).hypot(1.0);
        1.0 / (1.0 + 2.0 * self.motion.len() as f64 * offset * offset).sqrt()
    }

    /// Returns the weights that convert a force to the displacement that it causes at the mean stiffness, divided by its noise.
    fn whitening_of(&self, of: &MeanStiffness) -> Vec<Vec<[C; D]>> {
        let map = self.rows_of_pose();
        let whitening = |(k, w): (usize, &f64)| {
            let inverse = self.held(self.dynamic_stiffness(of, k, *w)).try_inverse().unwrap_or_else(Square::zeros);
            let row = |row: &[f64; D]| std::array::from_fn(|j| (0..D).map(|k| inverse[(k, j)] * row[k]).sum::<C>());
            map.iter().map(row).collect()
        };
        let mut all: Vec<Vec<[C; D]>> = self.transform.lines.iter().enumerate().map(whitening).collect();
        let mean = self.mean_weight();
        for rows in all.iter_mut().take(MEAN_LINES) {
            rows.iter_mut().flatten().for_each(|a| *a *= mean);
        }
        all
    }

    /// Holds the axial coordinate where nothing determines it.
    pub(super) fn held(&self, mut stiffness: Square) -> Square {
        if !self.weighting.has_axial_probe && !self.is_axially_free {
            (0..D).for_each(|i| (stiffness[(2, i)], stiffness[(i, 2)]) = (C::new(0.0, 0.0), C::new(0.0, 0.0)));
            stiffness[(2, 2)] = C::new(1e30, 0.0);
        }
        stiffness
    }

    /// Scales the noise of each probe, line by line, to that of the residual of a true machine: the noise of the probes also
    /// enters the displacement at which the bearing forces are evaluated, and resonances amplify it there.
    ///
    /// The residual of several sets of simulated noise is averaged over neighbouring lines.
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
                // The odd part of the change is the noise of the force, the even part its bias.
                let passed = &passed[b];
                let [with, against] = [1.0, -1.0].map(|sign| {
                    let error = |t: usize| Displacement::from_array(passed[t].to_array().map(|x| sign * x));
                    one.forces_with(&self.motion, &error)
                });
                let change = |t: usize| {
                    let (with, against, without) = (&with[t], &against[t], &exact[b][t]);
                    let mut odd = linear(b, t, &rest[b][t]);
                    let mut even = [0.0; D];
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
            if self.site.is_none()
                && let Some(motion) = self.motion_by_instants(&mut normal)
            {
                let (with, without) = (motion.unit_unbalance(), self.motion.unit_unbalance());
                let lines = self.transform.pair(0, |t| with[t][0] - without[t][0], |t| with[t][1] - without[t][1]);
                for (sum, part) in force.iter_mut().zip(self.shaft.dynamics.unbalance(machine.unbalance, &lines)) {
                    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
                }
                for (b, one) in evaluated.iter().enumerate() {
                    let forces = one.forces(&motion);
                    add(&mut force, b, &|t| std::array::from_fn(|i| forces[t][i] - exact[b][t][i]));
                }
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
}

/// Generator of normally distributed numbers, the same in every run (xorshift and Box-Muller).
pub struct Normal {
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
