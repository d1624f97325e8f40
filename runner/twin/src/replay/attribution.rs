//! Attribution of a line to one of two bearings of the same shape.
//!
//! Their lines have the same frequency, and a rigid rotor vibrates at both ends whichever bearing is excited, so amplitudes do
//! not separate them. Forces do: at a line the motion `Q` of the rotor requires the force
//! `(-w^2 M + i w (B + W G) + K) Q`, and the bearing models give another force from the same displacement. The difference,
//! divided between the two bearings by the balance of force and moment, is at the bearing whose model is wrong.

use super::force::EvaluatedForce;
use super::lines::{Angles, Demodulator, followed, followed_orders};
use crate::plant::Plant;
use ballrace::Displacement;

/// Amplitudes of cosine and sine.
type Phasor = [f64; 2];

/// Unexplained force of two bearings, line by line.
pub struct LineAttribution {
    demodulator: Demodulator,
    stations: [f64; 2],
    /// Order of each line.
    orders: Vec<f64>,
    /// Sum over blocks of the squared unexplained force of each bearing, by line as in `followed`.
    power: Vec<[f64; 2]>,
    signals: Vec<f64>,
    /// Revolutions since the last sample with forces.
    revolutions: f64,
}

impl LineAttribution {
    /// Creates the attribution; none unless the plant has two bearings.
    #[must_use]
    pub fn new(plant: &Plant) -> Option<Self> {
        let [a, b] = plant.bearings.as_slice() else { return None };
        let lines = followed(&plant.bearings);
        Some(Self {
            power: vec![[0.0; 2]; lines.len()],
            // Pose (5), then both bearings' wrenches moved to the centre of mass (5).
            demodulator: Demodulator::new(lines, 10),
            stations: [a.station, b.station],
            orders: followed_orders(&plant.bearings),
            signals: Vec::with_capacity(10),
            revolutions: 0.0,
        })
    }

    /// Adds the measured displacement and the forces that the models compute from it. `forces` is empty where a sample is
    /// skipped.
    pub fn add(
        &mut self,
        plant: &Plant,
        displacement: &Displacement<f64>,
        forces: &[EvaluatedForce],
        angles: Angles,
        speed: f64,
    ) {
        self.revolutions += angles.revolutions;
        if forces.is_empty() {
            return;
        }
        let angles = Angles { revolutions: std::mem::take(&mut self.revolutions), ..angles };
        self.signals.clear();
        self.signals.extend(displacement.to_array());
        let mut total = [0.0; 5];
        for (force, z) in forces.iter().zip(self.stations) {
            let [fx, fy, fz, mx, my] = force.measured;
            for (sum, part) in total.iter_mut().zip([fx, fy, fz, mx - z * fy, my + z * fx]) {
                *sum += part;
            }
        }
        self.signals.extend(total);
        if self.demodulator.add(&self.signals, angles) {
            self.close(plant, speed);
        }
    }

    fn close(&mut self, plant: &Plant, speed: f64) {
        for i in 0..self.orders.len() {
            let omega = self.orders[i] * speed;
            let block = self.demodulator.block(i);
            let displacement: [Phasor; 5] = std::array::from_fn(|k| block[k]);
            let required = plant.required_force(&displacement, omega, speed);
            let missing: [Phasor; 5] =
                std::array::from_fn(|k| [required[k][0] - block[5 + k][0], required[k][1] - block[5 + k][1]]);
            let split = self.split(&missing);
            for (sum, part) in self.power[i].iter_mut().zip(split) {
                *sum += part;
            }
        }
    }

    /// Returns the squared force at each bearing that is equivalent to the missing force and moment.
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

    /// Returns the unexplained force of each bearing over all lines of a family (indices as in `followed`), N, root of the sum
    /// of squares; none before the first complete block.
    #[must_use]
    pub fn unexplained(&self, lines: impl Iterator<Item = usize>) -> Option<[f64; 2]> {
        let sum = lines.filter_map(|i| self.power.get(i)).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        (sum[0] + sum[1] > 0.0).then(|| sum.map(f64::sqrt))
    }
}

impl Plant {
    /// Returns the phasor of the bearing force that the motion `displacement` at the angular frequency `omega` requires.
    fn required_force(&self, displacement: &[Phasor; 5], omega: f64, speed: f64) -> [Phasor; 5] {
        let Some(rotor) = self.rotor() else { return *displacement };
        let masses = [rotor.mass, rotor.mass, rotor.mass, rotor.diametral_inertia, rotor.diametral_inertia];
        // The rate of A cos + B sin is w (B cos - A sin).
        let rate: [Phasor; 5] = displacement.map(|[a, b]| [omega * b, -omega * a]);
        let damping = self.damping();
        let spin = rotor.polar_inertia * speed;
        std::array::from_fn(|k| {
            let mut force = displacement[k].map(|x| (rotor.stiffness[k] - omega * omega * masses[k]) * x);
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
