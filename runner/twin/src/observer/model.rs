//! The rotor on its bearings as a sampled linear system with an unknown load, from which the gains are computed.

use super::riccati::{Sampled, Steady};
use crate::error::Result;
use crate::plant::{Plant, PlantError};
use nalgebra::DMatrix;

/// Coordinates of a rigid rotor.
const D: usize = 5;

/// q, q', d, r of the kernel's observer.
const STATES: usize = 4 * D;

/// Measurement noise and process noise of the filter.
pub struct Uncertainty<'a> {
    /// Rms noise of each probe, m.
    pub noise: &'a [f64],
    /// Process noise of the unknown force, N per root second; that of the moment is multiplied by the root mean square of the bearing stations, m.
    pub process_noise: f64,
    /// Process noise of the unknown force that rotates with the shaft, N per root second.
    pub turning_process_noise: f64,
}

impl<'a> Uncertainty<'a> {
    /// Returns the uncertainty of a rotor with this weight (N), whose unbalance changes slowly.
    #[must_use]
    pub fn new(noise: &'a [f64], process_noise: f64, weight: f64) -> Self {
        Self { noise, process_noise, turning_process_noise: 1e-3 * weight }
    }
}

/// Time constant with which an unknown load decays without corrections, s.
const MEMORY: f64 = 10.0;

/// Returns the factor by which an unknown load decays over `period` (s).
#[must_use]
pub fn memory(period: f64) -> f64 {
    (-period / MEMORY).exp()
}

/// Returns units in which all states are of similar size: um, um at the bearings, their rates, N.
fn scales(plant: &Plant) -> [f64; STATES] {
    let lever = lever(plant);
    std::array::from_fn(|i| {
        let by = if i % D < 3 { 1.0 } else { lever };
        match i / D {
            0 => 1e-6 / by,
            1 => 1e-3 / by,
            _ => by,
        }
    })
}

/// Returns the rms distance of the bearings from the centre of mass, m.
pub fn lever(plant: &Plant) -> f64 {
    let squares: f64 = plant.bearings.iter().map(|s| s.station * s.station).sum();
    let lever = (squares / plant.bearings.len().max(1) as f64).sqrt();
    if lever > 0.0 { lever } else { 0.05 }
}

/// Returns the weight of the rotor, N, the scale of unknown forces.
#[must_use]
pub fn weight(plant: &Plant) -> f64 {
    plant.rotor().map_or(1.0, |r| r.mass) * 9.80665
}

/// Computes the steady filter at `speed` (rad/s), in SI units.
///
/// # Errors
/// As [`Sampled::steady`].
pub fn steady(plant: &Plant, rows: &[[f64; D]], speed: f64, period: f64, of: &Uncertainty) -> Result<Steady> {
    let scale = scales(plant);
    let (transition, disturbance) = sampled(plant, speed, period, of, &scale)?;
    // Readings in um.
    let probes = DMatrix::from_fn(rows.len(), STATES, |p, i| if i < D { rows[p][i] * scale[i] * 1e6 } else { 0.0 });
    let noise = DMatrix::from_fn(rows.len(), rows.len(), |i, j| if i == j { (of.noise[i] * 1e6).powi(2) } else { 0.0 });
    let mut found = Sampled { transition, probes, disturbance, noise }.steady()?;
    for (i, unit) in scale.iter().enumerate() {
        found.gain.row_mut(i).scale_mut(unit * 1e6);
    }
    found.whitening *= 1e6;
    Ok(found)
}

/// Computes `A` and `Q` over one period by the matrix exponential of the continuous system (Van Loan 1978).
fn sampled(
    plant: &Plant,
    speed: f64,
    period: f64,
    of: &Uncertainty,
    scale: &[f64; STATES],
) -> Result<(DMatrix<f64>, DMatrix<f64>)> {
    let system = plant.scales()?;
    let inverse = system.mass.try_inverse().ok_or(PlantError::SingularMass)?;
    let by_position = -&inverse * &plant.stiffness;
    let by_rate = -&inverse * (system.damping + system.gyroscopic * speed);
    let mut f = DMatrix::<f64>::zeros(STATES, STATES);
    for i in 0..D {
        f[(i, D + i)] = 1.0;
        f[(2 * D + i, 2 * D + i)] = -1.0 / MEMORY;
        for j in 0..D {
            f[(D + i, j)] = by_position[(i, j)];
            f[(D + i, D + j)] = by_rate[(i, j)];
            f[(D + i, 2 * D + j)] = inverse[(i, j)];
            f[(D + i, 3 * D + j)] = inverse[(i, j)];
        }
        f[(3 * D + i, 3 * D + i)] = -1.0 / MEMORY;
    }
    for (x, y) in [(3 * D, 3 * D + 1), (3 * D + 3, 3 * D + 4)] {
        (f[(x, y)], f[(y, x)]) = (-speed, speed);
    }
    for (i, to) in scale.iter().enumerate() {
        for (j, from) in scale.iter().enumerate() {
            f[(i, j)] *= from / to;
        }
    }
    let n = STATES;
    let mut both = DMatrix::<f64>::zeros(2 * n, 2 * n);
    both.view_mut((0, 0), (n, n)).copy_from(&(-&f * period));
    both.view_mut((n, n), (n, n)).copy_from(&(f.transpose() * period));
    for i in 2 * D..n {
        // The unit of moments contains the lever. The rotating load has no axial component.
        let process_noise = match i {
            _ if i < 3 * D => of.process_noise,
            _ if i == 3 * D + 2 => 0.0,
            _ => of.turning_process_noise,
        };
        both[(i, n + i)] = process_noise * process_noise * period;
    }
    let e = both.exp();
    let transition = e.view((n, n), (n, n)).transpose();
    let disturbance = &transition * e.view((0, n), (n, n));
    Ok((transition, 0.5 * (&disturbance + disturbance.transpose())))
}
