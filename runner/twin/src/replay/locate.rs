//! Which of two bearings of the same shape a line comes from.
//!
//! Their lines have the same frequency, and a rigid rotor shakes at both ends whichever bearing pushes, so the size of
//! the motion does not tell. Forces do: at a line the rotor's motion needs the force `(-w^2 M + i w (B + W G) + K) Q`,
//! the model gives another one from the same displacement, and the difference, split between the two bearings by the
//! balance of force and moment, stands at the bearing whose model is wrong.

use super::comparison::{Angles, followed};
use super::forces::Evaluated;
use super::lines::{Demodulator, Line};
use crate::plant::Plant;
use ballrace::Displacement;

/// Amplitudes of cosine and sine.
type Phasor = [f64; 2];

/// Unexplained force of two bearings, line by line.
pub struct Locator {
    demodulator: Demodulator,
    stations: [f64; 2],
    ratios: Vec<f64>,
    /// Sum over blocks of the squared unexplained force of each bearing, by line as in `followed`.
    power: Vec<[f64; 2]>,
    signals: Vec<f64>,
    /// Revolutions since the last sample with forces.
    arc: f64,
}

impl Locator {
    /// None unless the plant has two bearings.
    #[must_use]
    pub fn new(plant: &Plant) -> Option<Self> {
        let [a, b] = plant.bearings.as_slice() else { return None };
        let lines: Vec<Line> = followed(&plant.bearings);
        Some(Self {
            power: vec![[0.0; 2]; lines.len()],
            // Pose (5), then both bearings' wrenches moved to the centre of mass (5).
            demodulator: Demodulator::new(lines, 10),
            stations: [a.station, b.station],
            ratios: plant.bearings.iter().map(|s| s.kinematics.cage_ratio).collect(),
            signals: Vec::with_capacity(10),
            arc: 0.0,
        })
    }

    /// One sample: the measured pose and the forces that the model gives from it; nothing but the way where there are none.
    pub fn add(&mut self, plant: &Plant, pose: &Displacement<f64>, forces: &[Evaluated], angles: Angles, speed: f64) {
        self.arc += angles.arc;
        if forces.is_empty() {
            return;
        }
        let angles = Angles { arc: std::mem::take(&mut self.arc), ..angles };
        self.signals.clear();
        self.signals.extend(pose.to_array());
        let mut whole = [0.0; 5];
        for (force, z) in forces.iter().zip(self.stations) {
            let [fx, fy, fz, mx, my] = force.measured;
            for (sum, part) in whole.iter_mut().zip([fx, fy, fz, mx - z * fy, my + z * fx]) {
                *sum += part;
            }
        }
        self.signals.extend(whole);
        if self.demodulator.add(&self.signals, angles) {
            self.close(plant, speed);
        }
    }

    fn close(&mut self, plant: &Plant, speed: f64) {
        let lines: Vec<Line> = self.demodulator.lines().to_vec();
        for (i, line) in lines.iter().enumerate() {
            let omega = line.order(&self.ratios) * speed;
            let block = self.demodulator.block(i);
            let pose: [Phasor; 5] = std::array::from_fn(|k| block[k]);
            let needed = plant.force_for(&pose, omega, speed);
            let missing: [Phasor; 5] =
                std::array::from_fn(|k| [needed[k][0] - block[5 + k][0], needed[k][1] - block[5 + k][1]]);
            let split = self.split(&missing);
            for (sum, part) in self.power[i].iter_mut().zip(split) {
                *sum += part;
            }
        }
    }

    /// Squared force at each bearing that makes up the missing force and moment.
    fn split(&self, missing: &[Phasor; 5]) -> [f64; 2] {
        let [a, b] = self.stations;
        let span = b - a;
        let mut squares = [0.0; 2];
        let [fx, fy, _, mx, my] = missing;
        for ((fx, fy), (mx, my)) in fx.iter().zip(fy).zip(mx.iter().zip(my)) {
            // X: f_a + f_b = fx, z_a f_a + z_b f_b = my. Y: the same with -mx.
            for (force, moment) in [(*fx, *my), (*fy, -mx)] {
                let at_b = (moment - a * force) / span;
                squares[0] += (force - at_b).powi(2);
                squares[1] += at_b.powi(2);
            }
        }
        squares
    }

    /// Unexplained force of each bearing over all lines of a family (indices as in `followed`), N, root of the sum of
    /// squares; None before a whole block was seen.
    #[must_use]
    pub fn unexplained(&self, lines: impl Iterator<Item = usize>) -> Option<[f64; 2]> {
        let sum = lines.filter_map(|i| self.power.get(i)).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        (sum[0] + sum[1] > 0.0).then(|| sum.map(f64::sqrt))
    }
}

impl Plant {
    /// Force that bearings have to give for the motion `pose` at the angular frequency `omega`: phasors in, phasors out.
    fn force_for(&self, pose: &[Phasor; 5], omega: f64, speed: f64) -> [Phasor; 5] {
        let Some(rotor) = self.rotor() else { return *pose };
        let masses = [rotor.mass, rotor.mass, rotor.mass, rotor.diametral_inertia, rotor.diametral_inertia];
        // The rate of A cos + B sin is w (B cos - A sin).
        let rate: [Phasor; 5] = pose.map(|[a, b]| [omega * b, -omega * a]);
        let damping = self.damping();
        let spin = rotor.polar_inertia * speed;
        std::array::from_fn(|k| {
            let mut force = pose[k].map(|x| (rotor.stiffness[k] - omega * omega * masses[k]) * x);
            for (part, f) in force.iter_mut().enumerate() {
                *f += rotor.damping[k] * rate[k][part];
                *f += (0..5).map(|j| damping[(k, j)] * rate[j][part]).sum::<f64>();
                *f += match k {
                    3 => spin * rate[4][part],
                    4 => -spin * rate[3][part],
                    _ => 0.0,
                };
            }
            force
        })
    }
}
