//! What a site adds to the noise of a residual: errors of the readings, waves of the races of sound bearings, error of the model.
//!
//! Each is a covariance of the lines of the displacement. The residual, white by the noise of the probes alone, becomes white by the sum of
//! both, line by line. Lines that a sound machine shows so count by how far they exceed what is expected of them.

use super::super::Result;
use super::super::machine::Machine;
use super::super::measurement::{Expected, GAP, ReadingBasis, ReadingError, Site, limited};
use super::super::motion::{C, D};
use super::{Evidence, MEAN_LINES, Spectra};
use ballrace::Displacement;
use ballrace_outcome::ProbeReadings;
use ballrace_plant::{MountedBearing, probes};
use ballrace_scene::Direction;
use nalgebra::{DMatrix, SVector};
use std::sync::Arc;

/// Relative error of the motion that a model of the machine describes, line by line.
const MODEL_ERROR: f64 = 0.02;
/// Relative error of the gain of a probe, and of its direction in rad, until a baseline has been recorded with it.
pub const GAIN_ERROR: f64 = 0.03;
/// Lines on each side over which the motion that has it is taken: the window spreads a line.
const SPREAD: usize = 3;
/// The same over the number of the line, by a speed that varies in the record.
const SPEED_SPREAD: f64 = 0.003;
/// Share of a motion that appears at other lines by an error of the model, where the stiffness changes by its own amount.
const INTERMODULATION: f64 = 0.02;
/// Least displacement over which it does, m.
const DEFLECTION: f64 = 2e-6;
/// Lines of a sound machine recur with up to this multiple of their amplitude.
const RECURRENCE: f64 = 1.5;
/// Relative change of the order of a line between recordings, by the slip of a cage.
const MOVED: f64 = 0.012;
/// Amplitude of the waves of races and of the difference of elements of a sound bearing of ordinary class, m, at order 1; it falls with the
/// order.
const WAVES: f64 = 0.5e-6;
/// The same from where it falls no more.
const ROUGHNESS: f64 = 0.01e-6;

/// Returns the amplitude of a wave of a sound race, m, by the number of waves.
pub fn sound_wave(order: f64) -> f64 {
    (WAVES / order.max(1.0)).max(ROUGHNESS)
}
/// Harmonics of a ball pass with such waves, and range of the slip of a cage.
const PASSES: usize = 20;
const SLIPS: [f64; 2] = [0.0, 0.03];

/// Returns the harmonic and the range of the order of each line that a bearing may have: by the cage's slip.
pub fn orders_of_bearing(bearing: &MountedBearing) -> impl Iterator<Item = (usize, [f64; 2])> {
    let (n, cage, ball) =
        (bearing.elements as f64, bearing.kinematics.rolling_cage_ratio, bearing.kinematics.ball_ratio());
    (1..=PASSES).flat_map(move |k| {
        let pass = |slip: f64| k as f64 * n * cage * (1.0 - slip);
        let [outer, inner] = [SLIPS.map(pass), SLIPS.map(|slip| k as f64 * n - pass(slip))];
        let spin = SLIPS.map(|slip| 2.0 * k as f64 * ball * (1.0 - slip));
        let beside = |of: [f64; 2], by: f64| of.map(|order| order + by);
        let all =
            [outer, inner, beside(inner, -1.0), beside(inner, 1.0), beside(spin, -cage), spin, beside(spin, cage)];
        all.map(|[a, b]| (k, [a.abs().min(b.abs()), a.abs().max(b.abs())]))
    })
}

/// Returns the range of the order of each line of the first harmonic.
fn first_orders_of_bearing(bearing: &MountedBearing) -> impl Iterator<Item = [f64; 2]> {
    orders_of_bearing(bearing).filter(|(harmonic, _)| *harmonic == 1).map(|(_, range)| range)
}

/// Values of a residual of a site that one error of the model changes together: those of all probes at the lines about one motion. A value
/// is evidence of so much less.
pub const DEPENDENT: f64 = 100.0;
/// Mean square of the residual, in units of its noise with what is expected, beyond which a recording of a site is not explained.
pub const UNEXPLAINED: f64 = 1.25;

/// Returns the number of lines on each side of line `k` that are of one motion.
pub(super) fn half_width(k: usize) -> usize {
    SPREAD + (SPEED_SPREAD * k as f64) as usize
}

/// Order below which a reading drifts: a cage turns at a third of the shaft speed or more.
const SLOWEST: f64 = 0.2;

/// Displacement of the rotor under its weight by the least stiffness, m: a bearing without contact has none.
const SAG: f64 = 20e-6;

/// Standard deviations of a change of a site that is significant.
const SIGNIFICANT: f64 = 4.0;

/// What is known of a site before its recording.
#[derive(Clone)]
pub struct SiteKnowledge<'a> {
    /// Standard deviation of the coefficients of each probe's error.
    pub deviations: Vec<ReadingError>,
    /// Learned from a sound machine.
    pub learned: &'a [ProbeReadings],
}

impl Evidence<'_> {
    /// Describes the site of the recording with the errors of its readings; `subtracted` are those that the motion lacks, and that count against
    /// their prior. The next call must be [`Evidence::weight_for`].
    pub fn set_site(
        &mut self,
        known: &SiteKnowledge,
        basis: Arc<ReadingBasis>,
        errors: &[ReadingError],
        subtracted: &[ReadingError],
    ) {
        let sum = self.transform.sum();
        let orders: Vec<f64> =
            self.transform.lines.iter().map(|w| w / self.motion.mean_speed().abs().max(f64::MIN_POSITIVE)).collect();
        let apart = orders.get(1).copied().unwrap_or(0.0);
        let products = self.products();
        // The first ball passes move by the whole slip: they are far from one another and hide little.
        let first: Vec<[f64; 2]> = self.plant.bearings.iter().flat_map(first_orders_of_bearing).collect();
        let moved = |order: f64| {
            let is_first = first.iter().any(|[low, high]| (low - apart..=high + apart).contains(&order));
            order * if is_first { SLIPS[1] } else { MOVED }
        };
        let probe = |(p, _): (usize, &ballrace_scene::Probe)| {
            let learned = |k: usize| {
                let near = |line: &&[f64; 2]| (line[0] - orders[k]).abs() < moved(line[0]).max(2.5 * apart);
                let lines = known.learned.get(p).map(|learned| learned.lines.as_slice()).unwrap_or_default();
                let amplitude = lines.iter().filter(near).map(|line| line[1]).fold(0.0, f64::max);
                (amplitude * 0.5 * sum).powi(2)
            };
            let mut variance = basis.variance(&known.deviations[p]);
            variance
                .iter_mut()
                .zip(&products)
                .for_each(|(variance, product)| *variance += INTERMODULATION.powi(2) * product);
            let of = |k: usize, x: &dyn Fn(usize) -> f64| if k < MEAN_LINES { 0.0 } else { x(k) };
            Expected { variance, learned: (0..orders.len()).map(|k| of(k, &learned)).collect() }
        };
        let expected = self.weighting.probes.iter().enumerate().map(probe).collect();
        let waves = |b: usize| {
            let n = self.plant.bearings[b].elements as f64;
            let mut variance = vec![0.0; orders.len()];
            for (k, [low, high]) in orders_of_bearing(&self.plant.bearings[b]) {
                let amplitude = sound_wave(k as f64 * n);
                let (low, high) = (low - 2.0 * apart, high + 2.0 * apart);
                let (first, last) = ((low / apart).ceil().max(MEAN_LINES as f64) as usize, (high / apart) as usize);
                for variance in variance.iter_mut().take(last + 1).skip(first) {
                    *variance = (amplitude * 0.5 * sum).powi(2).max(*variance);
                }
            }
            variance
        };
        let waves = if known.learned.is_empty() { (0..self.plant.bearings.len()).map(waves).collect() } else { vec![] };
        self.subtracted = Arc::new(self.pretended(&basis, subtracted));
        let gaps =
            errors.iter().zip(&known.deviations).map(|(error, deviation)| [error[GAP], deviation[GAP]]).collect();
        self.site = Some(Arc::new(Site { basis, gaps, expected, waves }));
    }

    /// Returns the square of each line that a bearing makes of others: of the second and third power of the motion over the displacement
    /// that changes its stiffness by its own amount.
    fn products(&self) -> Vec<f64> {
        let free = self.plant_clearance();
        let mut squares = vec![0.0; self.transform.lines.len()];
        for probe in self.weighting.probes.iter().filter(|probe| probe.direction != Direction::Axial) {
            let row = probes::row(probe);
            let read = |q: &Displacement<f64>| q.to_array().iter().zip(row).map(|(x, a)| x * a).sum::<f64>();
            let mean = self.motion.q.iter().map(read).sum::<f64>() / self.motion.len().max(1) as f64;
            let x: Vec<f64> = self.motion.q.iter().map(|q| read(q) - mean).collect();
            let [square, fourth] = [2, 4].map(|power| x.iter().map(|x| x.powi(power)).sum::<f64>());
            // The third power without its part along the motion: a stiffness of another amount explains that.
            let along = fourth / square.max(f64::MIN_POSITIVE);
            let third = |x: f64| x * (x * x - along) / (free * free);
            let spectra = self.transform.pair(0, |t| x[t] * x[t] / free, |t| third(x[t]));
            for spectrum in &spectra {
                squares.iter_mut().zip(spectrum).skip(MEAN_LINES).for_each(|(sum, x)| *sum += x.norm_sqr());
            }
        }
        let largest = |k: usize| {
            let lines = k.saturating_sub(SPREAD)..(k + SPREAD + 1).min(squares.len());
            squares[lines].iter().copied().fold(0.0, f64::max)
        };
        (0..squares.len()).map(largest).collect()
    }

    /// Returns the number of standard deviations that a change exceeds: 0 where the readings are those of the scene's machine.
    pub fn significant(&self) -> f64 {
        if self.site.is_some() { SIGNIFICANT } else { 0.0 }
    }

    /// Returns true at a site whose machine was not recorded in good order before.
    pub fn is_without_baseline(&self) -> bool {
        self.site.as_ref().is_some_and(|site| !site.waves.is_empty())
    }

    /// Returns the force that stands for errors of the readings: that of the mean stiffness at the displacement that they pretend.
    pub(super) fn readings(&self, errors: &[ReadingError]) -> [Vec<C>; D] {
        let Some(site) = &self.site else { return Default::default() };
        self.required_at_reference(&self.pretended(&site.basis, errors))
    }

    /// Returns the spectrum of the displacement that errors of the readings pretend.
    fn pretended(&self, basis: &ReadingBasis, errors: &[ReadingError]) -> [Vec<C>; D] {
        let mut lines: [Vec<C>; D] = std::array::from_fn(|_| vec![C::new(0.0, 0.0); self.transform.lines.len()]);
        for (p, error) in errors.iter().enumerate().filter(|(_, error)| error.iter().any(|x| *x != 0.0)) {
            let column = self.weighting.solver.column(p).to_array();
            for (k, x) in basis.spectrum(error).into_iter().enumerate() {
                lines.iter_mut().zip(column).for_each(|(line, a)| line[k] += a * x);
            }
        }
        lines
    }

    /// Returns the force that a displacement requires at the mean stiffness.
    fn required_at_reference(&self, displacement: &[Vec<C>; D]) -> [Vec<C>; D] {
        let mut force: [Vec<C>; D] = std::array::from_fn(|_| vec![C::new(0.0, 0.0); self.transform.lines.len()]);
        for (k, stiffness) in self.reference_lines.iter().enumerate() {
            let q = SVector::<C, D>::from_fn(|i, _| displacement[i][k]);
            let required = stiffness * q;
            force.iter_mut().zip(required.iter()).for_each(|(force, x)| force[k] = *x);
        }
        force
    }

    /// Prepares the evidence for [`Evidence::unexplained_readings`] alone: without the noise of the residual.
    pub fn refer_to(&mut self, machine: &Machine) -> Result<()> {
        if self.displaced.is_empty() || self.shaft.dynamics.is_elastic() {
            self.displace(machine)?;
        }
        if self.follows_axially() {
            self.follow_axially(machine)?;
        }
        self.set_reference(self.mean_stiffness(machine)?);
        Ok(())
    }

    /// Returns the least stiffness of the rotor in its bearings by which a mean force moves it, N/m and N m/rad: without contact, a bearing has
    /// none.
    pub(super) fn least_stiffness(&self) -> [f64; D] {
        let mass = self.scene.rotor.as_ref().map_or(0.0, |rotor| rotor.mass);
        let least = mass * 9.81 / SAG;
        let probes = &self.weighting.probes;
        let span = probes.iter().map(|probe| probe.station * probe.station).sum::<f64>() / probes.len().max(1) as f64;
        [least, least, least, least * span, least * span]
    }

    /// Returns the spectrum of the error of each probe's readings that would explain what a machine does not explain, the mean at a stiffness that
    /// is larger by `least`.
    pub fn unexplained_readings(&self, spectra: &Spectra, least: &[f64; D]) -> Vec<Vec<C>> {
        let force = self.force(spectra);
        let mut out = vec![Vec::with_capacity(self.transform.lines.len()); self.weighting.probes.len()];
        for k in 0..self.transform.lines.len() {
            let mut stiffness = self.held(self.reference_lines[k]);
            if k < MEAN_LINES {
                (0..D).for_each(|i| stiffness[(i, i)] += C::new(least[i], 0.0));
            }
            let force = SVector::<C, D>::from_fn(|i, _| force[i][k]);
            let caused = stiffness.lu().solve(&force).unwrap_or_else(SVector::zeros);
            for (out, probe) in out.iter_mut().zip(&self.weighting.probes) {
                let row = probes::row(probe);
                // What no probe measures is no error of one.
                let used = |i: usize| i != 2 || self.weighting.has_axial_probe;
                out.push(-(0..D).filter(|i| used(*i)).map(|i| caused[i] * row[i]).sum::<C>());
            }
        }
        out
    }

    /// Returns the sum of the squares of the motion of all probes that a machine does not explain.
    pub fn unexplained_square(&self, spectra: &Spectra) -> f64 {
        self.unexplained_readings(spectra, &[0.0; D]).iter().flatten().map(C::norm_sqr).sum()
    }

    /// Returns the posterior mean of the errors of the readings from what a machine does not explain; the motion lacks those that are
    /// `subtracted`. `uncertain_unbalance` is the standard deviation of the machine's unbalance over it.
    pub fn reading_errors(
        &self,
        machine: &Machine,
        known: &SiteKnowledge,
        basis: &ReadingBasis,
        subtracted: &[ReadingError],
        uncertain_unbalance: f64,
    ) -> Result<Vec<ReadingError>> {
        let mut unexplained = self.unexplained_readings(&self.spectra(machine)?, &self.least_stiffness());
        for (sum, subtracted) in unexplained.iter_mut().zip(subtracted) {
            sum.iter_mut().zip(basis.spectrum(subtracted)).for_each(|(sum, x)| *sum += x);
        }
        let unbalance = self.shaft.dynamics.unbalance(machine.unbalance, &self.unit_unbalance_lines);
        let unit = self.transform.power;
        let whirl: Vec<SVector<C, D>> = (0..unbalance[0].len())
            .map(|k| {
                let force = SVector::<C, D>::from_fn(|i, _| unbalance[i][k]);
                self.held(self.reference_lines[k]).lu().solve(&force).unwrap_or_else(SVector::zeros)
            })
            .collect();
        let estimate = |(p, unexplained): (usize, &Vec<C>)| {
            let row = probes::row(&self.weighting.probes[p]);
            let noise = unit * self.weighting.noise[p].powi(2);
            let read = |of: &dyn Fn(usize) -> C| (0..D).map(|i| of(i) * row[i]).sum::<C>().norm_sqr();
            let variance: Vec<f64> = (0..unexplained.len())
                .map(|k| {
                    let motion = if k < MEAN_LINES { 0.0 } else { read(&|i| self.displacement[0][i][k]) };
                    let whirl = read(&|i| whirl[k][i]);
                    2.0 * noise + MODEL_ERROR.powi(2) * motion + uncertain_unbalance.powi(2) * whirl
                })
                .collect();
            basis.estimate(unexplained, &variance, &known.deviations[p])
        };
        Ok(unexplained.iter().enumerate().map(estimate).collect())
    }

    /// Narrows the weights by what the site adds to the noise, and counts the errors that were subtracted.
    pub(super) fn narrow(&mut self, spectra: &Spectra) {
        let Some(site) = self.site.clone() else { return };
        let modelled = self.modelled_readings(spectra);
        let subtracted = self.required_at_reference(&self.subtracted);
        for (sum, part) in self.correction.iter_mut().zip(subtracted) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum -= part);
        }
        let map = self.rows_of_pose();
        let forces: Vec<[f64; D]> = self.reference.tangents.iter().map(force_of_wave).collect();
        self.narrowing = (0..self.whitening.len())
            .map(|k| {
                let rows = self.rows;
                let mean = if k < MEAN_LINES { self.mean_weight() } else { 1.0 };
                let mut covariance = DMatrix::<C>::identity(rows, rows);
                let error = if self.is_without_baseline() { MODEL_ERROR.hypot(GAIN_ERROR) } else { MODEL_ERROR };
                // One error of the model is that of the values of all probes.
                let error = self.error_at_fault.map_or(error, |at_fault| (at_fault * (rows as f64).sqrt()).max(error));
                let error = error * self.amplification(k).max(1.0);
                for (p, expected) in site.expected.iter().enumerate() {
                    let variance = expected.variance[k]
                        + error.powi(2) * modelled[p][k]
                        + (RECURRENCE * (1.0 + 5.0 * error)).powi(2) * expected.learned[k];
                    let column = self.weighting.solver.column(p).to_array();
                    let at =
                        |r: usize| (0..D).map(|i| map[r][i] * column[i]).sum::<f64>() * mean / self.noise_scale[k][r];
                    let along: Vec<f64> = (0..rows).map(at).collect();
                    for i in 0..rows {
                        for j in 0..rows {
                            covariance[(i, j)] += C::new(0.5 * variance * along[i] * along[j], 0.0);
                        }
                    }
                }
                for (b, variance) in site.waves.iter().enumerate().filter(|(_, variance)| variance[k] > 0.0) {
                    for direction in 0..D {
                        let along: Vec<C> = self.whitening_of_bearing[b][k]
                            .iter()
                            .map(|row| row[direction] * forces[b][direction])
                            .collect();
                        for i in 0..rows {
                            for j in 0..rows {
                                covariance[(i, j)] += 0.5 * variance[k] * along[i] * along[j].conj();
                            }
                        }
                    }
                }
                let root = covariance.cholesky().map(|factors| factors.l());
                root.and_then(nalgebra::Matrix::try_inverse).unwrap_or_else(|| DMatrix::identity(rows, rows))
            })
            .collect();
        let mut whitening = std::mem::take(&mut self.whitening);
        self.narrow_weights(&mut whitening);
        self.whitening = whitening;
    }

    /// Returns the square of each line of each probe's reading that the machine describes: the largest of the lines about it.
    fn modelled_readings(&self, spectra: &Spectra) -> Vec<Vec<f64>> {
        let unexplained = self.unexplained_readings(spectra, &[0.0; D]);
        let probe = |(p, unexplained): (usize, &Vec<C>)| {
            let row = probes::row(&self.weighting.probes[p]);
            let square = |k: usize| {
                let read: C = (0..D).map(|i| self.displacement[0][i][k] * row[i]).sum();
                if k < MEAN_LINES { 0.0 } else { (read - unexplained[k]).norm_sqr().min(read.norm_sqr()) }
            };
            let squares: Vec<f64> = (0..unexplained.len()).map(square).collect();
            // The lines of one motion have one error, and are compared as if each had its own: the variance of each is so much larger that
            // the error counts as one value.
            let around = |k: usize| {
                let half_width = half_width(k);
                let lines = k.saturating_sub(half_width)..(k + half_width + 1).min(squares.len());
                squares[lines].iter().sum::<f64>()
            };
            (0..squares.len()).map(around).collect()
        };
        unexplained.iter().enumerate().map(probe).collect()
    }

    /// Returns the largest radial motion of a bearing by a force there, over the static one: by so much an error of the stiffness changes the
    /// motion.
    fn amplification(&self, k: usize) -> f64 {
        let compliance = self.held(self.reference_lines[k]).try_inverse().unwrap_or_default();
        let of = |(b, tangent): (usize, &super::Tangent)| {
            let to = self.shaft.dynamics.to_centre(b, k);
            let own = to.transpose() * compliance * to;
            own[(0, 0)].norm().max(own[(1, 1)].norm()) * 0.5 * (tangent[(0, 0)] + tangent[(1, 1)])
        };
        self.reference.tangents.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    /// Returns the displacement over which the stiffness of the bearings changes by its own amount, m: half their clearance, and about the
    /// deflection under a load.
    fn plant_clearance(&self) -> f64 {
        let halves = self.scene.bearings.iter().map(|bearing| 0.5 * super::super::machine::clearance(bearing));
        halves.fold(f64::INFINITY, f64::min).max(DEFLECTION)
    }

    /// Narrows weights, line by line.
    pub(super) fn narrow_weights(&self, whitening: &mut [Vec<[C; D]>]) {
        for (rows, narrowing) in whitening.iter_mut().zip(&self.narrowing) {
            let wide = rows.clone();
            for (r, row) in rows.iter_mut().enumerate() {
                *row = std::array::from_fn(|j| (0..=r).map(|i| narrowing[(r, i)] * wide[i][j]).sum());
            }
        }
    }

    /// Returns the motion at each probe about its mean, without what drifts and without what a machine `with` deviations adds to it, m rms.
    pub fn motion_rms(&self, [with, without]: [&Spectra; 2]) -> Vec<f64> {
        let [with, without] = [with, without].map(|spectra| self.unexplained_readings(spectra, &[0.0; D]));
        let of = |(p, probe): (usize, &ballrace_scene::Probe)| {
            let row = probes::row(probe);
            let read = |k: usize| (0..D).map(|i| self.displacement[0][i][k] * row[i]).sum::<C>();
            self.rms(&|k| read(k) - without[p][k] + with[p][k])
        };
        self.weighting.probes.iter().enumerate().map(of).collect()
    }

    /// Returns the part of the motion at each probe that a machine does not explain, about its mean and without what drifts, m rms.
    pub fn unexplained_rms(&self, spectra: &Spectra) -> Vec<f64> {
        let of = |(lines, probe): (&Vec<C>, &ballrace_scene::Probe)| {
            let row = probes::row(probe);
            let read = |k: usize| (0..D).map(|i| self.displacement[0][i][k] * row[i]).sum::<C>();
            // Near a resonance, a small error of the stiffness leaves more than the motion.
            self.rms(&|k| if lines[k].norm_sqr() < read(k).norm_sqr() { lines[k] } else { read(k) })
        };
        self.unexplained_readings(spectra, &[0.0; D]).iter().zip(&self.weighting.probes).map(of).collect()
    }

    /// Returns the rms of a motion from its lines, about its mean and without what drifts.
    fn rms(&self, line: &dyn Fn(usize) -> C) -> f64 {
        let slowest = SLOWEST * self.motion.mean_speed().abs();
        let moves = |k: &usize| *k >= MEAN_LINES && self.transform.lines[*k] > slowest;
        let sum: f64 = (0..self.transform.lines.len()).filter(moves).map(|k| line(k).norm_sqr()).sum();
        // By Parseval, with the lines of negative frequency.
        (2.0 * sum / (self.motion.len() as f64 * self.transform.power)).sqrt()
    }

    /// Returns the lines of a sound machine that its model does not explain: order and amplitude (m) at each probe, those above
    /// the noise.
    pub fn lines_of_sound_machine(&self, spectra: &Spectra) -> Vec<Vec<[f64; 2]>> {
        /// Least power of a line over that of the noise.
        const CLEAR: f64 = 12.0;
        let speed = self.motion.mean_speed().abs().max(f64::MIN_POSITIVE);
        let sum = self.transform.sum();
        let apart = self.transform.lines.get(1).map_or(1.0, |w| w / speed);
        let of = |(p, unexplained): (usize, &Vec<C>)| {
            let noise = self.transform.power * self.weighting.noise[p].powi(2);
            let row = probes::row(&self.weighting.probes[p]);
            let read = |k: usize| (0..D).map(|i| self.displacement[0][i][k] * row[i]).sum::<C>();
            // Near a resonance, a small error of the stiffness leaves more than the motion.
            let power: Vec<f64> =
                unexplained.iter().enumerate().map(|(k, x)| x.norm_sqr().min(read(k).norm_sqr())).collect();
            let scale = |k: usize| self.noise_scale.get(k).map_or(1.0, |s| s.iter().copied().fold(1.0, f64::max));
            let is_line = |k: usize| power[k] > CLEAR * noise * scale(k) * scale(k);
            let is_peak = |k: usize| power[k] >= power[k - 1] && power.get(k + 1).is_none_or(|next| power[k] >= *next);
            let lines: Vec<[f64; 2]> = (MEAN_LINES..power.len())
                .filter(|&k| is_line(k) && is_peak(k))
                .map(|k| [k as f64 * apart, 2.0 * power[k].sqrt() / sum])
                .collect();
            lines
        };
        self.unexplained_readings(spectra, &[0.0; D]).iter().enumerate().map(of).collect()
    }
}

/// Returns the amplitude of force and moment of a bearing by a wave of its races over that of the wave, N/m and N: along the axis of a wave whose
/// number is that of the elements, so that all are on one point of it, across the axis and about it of one more or less.
///
/// With the stiffness `k` of each of `n` contacts at the angle `a` and radius `R`, the bearing has `n k cos(a)^2 / 2` across its axis,
/// `n k sin(a)^2` along it and `n k sin(a)^2 R^2 / 2` about the axes across. A radial deviation causes `n k cos(a)^2 / 2`, `n k cos(a) sin(a)` and
/// `n k cos(a) sin(a) R / 2`: the root of the stiffness times twice that across, or half of it.
fn force_of_wave(tangent: &super::Tangent) -> [f64; D] {
    let across = tangent[(0, 0)] + tangent[(1, 1)];
    let share = |i: usize| if i == 2 { 1.0 } else { 0.5 };
    std::array::from_fn(|i| (share(i) * across * tangent[(i, i)]).max(0.0).sqrt())
}

/// Returns the part of the errors that counts against its prior, limited to what is plausible, and the part that does not count because
/// nothing is known of it.
pub fn divided(errors: &[ReadingError], known: &SiteKnowledge) -> [Vec<ReadingError>; 2] {
    let counting = errors.iter().zip(&known.deviations).map(|(mean, deviations)| limited(mean, deviations));
    let counting: Vec<ReadingError> = counting.collect();
    let is_unknown = |x: f64| x >= UNKNOWN;
    let part = |unknown: bool| {
        let one = |(p, error): (usize, &ReadingError)| -> ReadingError {
            std::array::from_fn(|j| {
                let x = if unknown { error[j] } else { counting[p][j] };
                if is_unknown(known.deviations[p][j]) == unknown { x } else { 0.0 }
            })
        };
        errors.iter().enumerate().map(one).collect()
    };
    [part(false), part(true)]
}

/// Standard deviation from which a coefficient is unknown: it is subtracted whole, m.
const UNKNOWN: f64 = 1.5e-6;

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::Tangent;
    use super::*;
    use ballrace::bearing::Bearing as _;
    use ballrace::{BearingKinematicState, Phase};
    use ballrace_models::build;
    use ballrace_scene::read::read_str;
    use std::f64::consts::{PI, TAU};
    use std::path::Path;

    const ELEMENTS: usize = 9;
    /// Amplitude of a wave, m.
    const WAVE: f64 = 1e-9;

    /// Returns force and moment of an axially loaded bearing with a wave of an order on its outer race, and its stiffness, at an angle of the cage.
    fn wrench(order: usize, phase: f64, turns: f64) -> ([f64; D], Tangent) {
        let text = format!(
            "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"DE\"\nstation = 0\nfacing = \"both\"\nmodel = \"angular\"\n\
             elements = {ELEMENTS}\nball_diameter = \"9.525 mm\"\npitch_diameter = \"46 mm\"\ninner_conformity = 0.53\n\
             outer_conformity = 0.52\ndiametral_clearance = \"15 um\"\n\
             waviness = [{{ surface = \"outer\", order = {order}, amplitude = {WAVE:e}, phase = {phase} }}]\n"
        );
        let scene = read_str(&text, Path::new("scene.toml")).unwrap();
        let bearing = &scene.bearings[0];
        let built: build::AnyBearing<f64> = build::bearing(&scene, bearing, bearing.evaluated_model()).unwrap();
        let u = Displacement { w: 100e-6, ..Displacement::default() };
        let cage = Phase::from_revolutions(turns);
        let state = BearingKinematicState { cage, ..BearingKinematicState::default() };
        let (reaction, k) = built.reaction_and_stiffness(&u, &state);
        (reaction.wrench.to_array(), Tangent::from_fn(|i, j| k[(i, j)]))
    }

    /// Amplitudes of the force of the wave at the ball pass, from the contacts of a whole bearing. Their load adds some percent to the stiffness along the
    /// axis.
    #[test]
    fn a_wave_has_the_force_of_its_contacts() {
        let expected = force_of_wave(&wrench(ELEMENTS, 0.0, 0.0).1);
        let amplitude = |order: usize, i: usize| {
            const ANGLES: usize = 32;
            let parts = (0..ANGLES).map(|j| {
                let turns = j as f64 / (ANGLES * ELEMENTS) as f64;
                let change = wrench(order, 0.0, turns).0[i] - wrench(order, PI, turns).0[i];
                C::from_polar(change / ANGLES as f64, TAU * (ELEMENTS as f64 * turns))
            });
            parts.sum::<C>().norm() / WAVE
        };
        for (order, i) in [(ELEMENTS + 1, 0), (ELEMENTS - 1, 1), (ELEMENTS, 2), (ELEMENTS + 1, 3), (ELEMENTS - 1, 4)] {
            let found = amplitude(order, i);
            assert!((found / expected[i] - 1.0).abs() < 0.06, "{i}: {found:e} instead of {:e}", expected[i]);
        }
    }
}
