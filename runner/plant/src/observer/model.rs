//! The rotor on its bearings as a sampled linear system with an unknown load, from which the gains are computed.

use super::riccati::{Sampled, Steady};
use crate::error::Result;
use crate::{AXIAL, Given, Plant, PlantError, unbalance_planes};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Number of unknown loads: force and moment on a rigid rotor, or forces at two bearings of another one.
pub(crate) const LOADS: usize = 5;

/// Measurement noise and process noise of the filter.
pub struct Uncertainty<'a> {
    /// Rms noise of each probe, m.
    pub noise: &'a [f64],
    /// Process noise of the unknown force, N per root second; that of the moment is multiplied by the root mean square of the bearing
    /// stations, m.
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

impl Uncertainty<'_> {
    /// Returns the uncertainty of a rotor with an unknown unbalance of the force of its weight (N): the standard deviation of a load that
    /// decays and is driven by noise.
    #[must_use]
    pub fn with_unbalance(self, weight: f64) -> Self {
        Self { turning_process_noise: weight * (2.0 / MEMORY).sqrt(), ..self }
    }
}

/// Least axial natural frequency of the rotor in the gains where no probe measures the axial coordinate, Hz. Bearings without an axial
/// stiffness leave it free: nothing moves it, no reading depends on it, and a steady filter requires that it is held.
const LOWEST_AXIAL: f64 = 1.0;

/// Time constant with which an unknown load decays without corrections, s.
const MEMORY: f64 = 10.0;

/// Returns the factor by which an unknown load decays over `period` (s).
#[must_use]
pub fn memory(period: f64) -> f64 {
    (-period / MEMORY).exp()
}

/// Returns the force on each coordinate by each unknown load.
///
/// The unknown loads of a rigid rotor, also on supports, act on its five coordinates. Those of a flexible rotor act along X and Y at
/// the two outermost bearings and along Z, where the forces of faults act; those of a given system, at its first and its last bearing.
#[must_use]
pub fn loads(plant: &Plant) -> DMatrix<f64> {
    let n = plant.layout.order;
    if plant.layout.is_given() {
        let last = plant.bearings.len().saturating_sub(1);
        let (Some(first), Some(second)) = (plant.layout.attached(0), plant.layout.attached(last)) else {
            return DMatrix::zeros(n, LOADS);
        };
        // One bearing alone takes moments instead.
        let [x, y] = if last > 0 { [&second[0], &second[1]] } else { [&first[3], &first[4]] };
        let rows = [&first[0], &first[1], &first[2], x, y];
        return DMatrix::from_fn(n, LOADS, |i, j| rows[j][i]);
    }
    let by_station = |a: &&crate::MountedBearing, b: &&crate::MountedBearing| a.station.total_cmp(&b.station);
    let ends = (plant.bearings.iter().min_by(by_station), plant.bearings.iter().max_by(by_station));
    match ends {
        (Some(first), Some(last)) if plant.layout.flexible().is_some() && last.station > first.station => {
            let (first, last) = (plant.layout.rows(first.station), plant.layout.rows(last.station));
            let rows = [&first[0], &first[1], &first[2], &last[0], &last[1]];
            DMatrix::from_fn(n, LOADS, |i, j| rows[j][i])
        }
        _ => DMatrix::identity(n, LOADS),
    }
}

/// Returns the force on each coordinate by each unknown load that rotates with the shaft.
///
/// The loads of a flexible rotor act along X and Y in two planes of unbalance; those of a given system, on the coordinates of its
/// unbalance; all others as [`loads`].
#[must_use]
pub(crate) fn rotating_loads(plant: &Plant) -> DMatrix<f64> {
    if let Some(planes) = plant.layout.given().map(Given::unbalance_planes).filter(|planes| !planes.is_empty()) {
        let mut loads = DMatrix::zeros(plant.layout.order, LOADS);
        for (plane, first) in planes.iter().zip([0, 3]) {
            (loads[(plane[0], first)], loads[(plane[1], first + 1)]) = (1.0, 1.0);
        }
        return loads;
    }
    let (Some(rotor), [first, second]) = (plant.rotor(), plant.bearings.as_slice()) else { return loads(plant) };
    if plant.layout.flexible().is_none() || first.station == second.station {
        return loads(plant);
    }
    let planes = unbalance_planes(rotor, [first.station, second.station]).map(|z| plant.layout.rows(z));
    let rows = [&planes[0][0], &planes[0][1], &planes[0][2], &planes[1][0], &planes[1][1]];
    DMatrix::from_fn(plant.layout.order, LOADS, |i, j| rows[j][i])
}

/// Returns units in which all states are of similar size: um, um at the bearings, their rates, N.
fn scales(plant: &Plant) -> Result<Vec<f64>> {
    let Levers { coordinates, loads } = Levers::new(plant)?;
    let lengths = |size: f64| coordinates.iter().map(move |lever| size / lever);
    Ok(lengths(1e-6).chain(lengths(1e-3)).chain(loads).chain(loads).collect())
}

/// Levers by which tilts become lengths and forces moments, m; 1 for lengths and forces.
pub(crate) struct Levers {
    /// By coordinates.
    pub coordinates: Vec<f64>,
    /// By unknown loads.
    pub loads: [f64; LOADS],
}

impl Levers {
    /// Returns the levers of a plant. On coordinates of an unknown kind, a lever is the root of the coordinate's share in the largest mass.
    ///
    /// # Errors
    /// Returns the errors of [`Plant::scales`].
    pub fn new(plant: &Plant) -> Result<Self> {
        let n = plant.layout.order;
        if plant.layout.is_given() {
            let mass = plant.scales()?.mass.diagonal();
            let largest = mass.max();
            return Ok(Self { coordinates: mass.iter().map(|m| (m / largest).sqrt()).collect(), loads: [1.0; LOADS] });
        }
        let lever = lever(plant);
        let by = |i: usize| if i == 3 || i == 4 { lever } else { 1.0 };
        let are_moments = plant.layout.flexible().is_none();
        let loads = std::array::from_fn(|i| if are_moments { by(i) } else { 1.0 });
        Ok(Self { coordinates: (0..n).map(by).collect(), loads })
    }
}

/// Returns the rms distance of the bearings from the centre of mass, m.
fn lever(plant: &Plant) -> f64 {
    let squares: f64 = plant.bearings.iter().map(|s| s.station * s.station).sum();
    let lever = (squares / plant.bearings.len().max(1) as f64).sqrt();
    if lever > 0.0 { lever } else { 0.05 }
}

/// Returns the weight of the rotor, N, which is the scale of unknown forces.
///
/// For a given system, it is the sum of its loads or, without loads, half the sum of its masses along each coordinate times gravity.
///
/// # Errors
/// Returns the errors of [`Plant::scales`].
pub fn weight(plant: &Plant) -> Result<f64> {
    const GRAVITY: f64 = 9.80665;
    if let Some(rotor) = plant.rotor() {
        return Ok(rotor.mass * GRAVITY);
    }
    let scales = plant.scales()?;
    let load: f64 = scales.load.iter().map(|load| load.abs()).sum();
    Ok(if load > 0.0 { load } else { 0.5 * scales.mass.trace() * GRAVITY })
}

/// Computes the steady filter at `speed` (rad/s), in SI units.
///
/// # Errors
/// Returns the errors of [`Sampled::steady`].
pub fn steady(plant: &Plant, rows: &[Vec<f64>], speed: f64, period: f64, of: &Uncertainty) -> Result<Steady> {
    let scale = scales(plant)?;
    let (transition, disturbance) = sampled(plant, &held(plant, rows)?, speed, period, of, &scale)?;
    let n = plant.layout.order;
    // Readings in um.
    let probes =
        DMatrix::from_fn(rows.len(), scale.len(), |p, i| if i < n { rows[p][i] * scale[i] * 1e6 } else { 0.0 });
    let noise = DMatrix::from_fn(rows.len(), rows.len(), |i, j| if i == j { (of.noise[i] * 1e6).powi(2) } else { 0.0 });
    let mut found = Sampled { transition, probes, disturbance, noise }.steady()?;
    for (i, unit) in scale.iter().enumerate() {
        found.gain.row_mut(i).scale_mut(unit * 1e6);
    }
    found.whitening *= 1e6;
    Ok(found)
}

/// Returns true where the rotor has an axial coordinate that no probe measures; `rows` are the readings per unit of each coordinate.
#[must_use]
pub(crate) fn is_axially_unmeasured(plant: &Plant, rows: &[Vec<f64>]) -> bool {
    let measures = |row: &Vec<f64>| row.get(AXIAL).is_some_and(|axial| *axial != 0.0);
    !plant.layout.is_given() && !rows.iter().any(measures)
}

/// Returns the stiffness for the gains, in which an axial coordinate that no probe measures is held (see [`LOWEST_AXIAL`]).
fn held(plant: &Plant, rows: &[Vec<f64>]) -> Result<DMatrix<f64>> {
    let mut stiffness = plant.stiffness.clone();
    if is_axially_unmeasured(plant, rows) {
        let least = plant.scales()?.mass[(AXIAL, AXIAL)] * (TAU * LOWEST_AXIAL).powi(2);
        stiffness[(AXIAL, AXIAL)] = stiffness[(AXIAL, AXIAL)].max(least);
    }
    Ok(stiffness)
}

/// Computes `A` and `Q` over one period by the matrix exponential of the continuous system (Van Loan 1978).
fn sampled(
    plant: &Plant,
    stiffness: &DMatrix<f64>,
    speed: f64,
    period: f64,
    of: &Uncertainty,
    scale: &[f64],
) -> Result<(DMatrix<f64>, DMatrix<f64>)> {
    let system = plant.scales()?;
    let inverse = system.mass.try_inverse().ok_or(PlantError::SingularMass)?;
    let by_position = -&inverse * stiffness;
    let by_rate = -&inverse * (system.damping + system.gyroscopic * speed);
    let by_load = &inverse * loads(plant);
    let (order, n) = (plant.layout.order, scale.len());
    let (load, rotating) = (2 * order, 2 * order + LOADS);
    let mut f = DMatrix::<f64>::zeros(n, n);
    f.view_mut((0, order), (order, order)).fill_with_identity();
    f.view_mut((order, 0), (order, order)).copy_from(&by_position);
    f.view_mut((order, order), (order, order)).copy_from(&by_rate);
    f.view_mut((order, load), (order, LOADS)).copy_from(&by_load);
    f.view_mut((order, rotating), (order, LOADS)).copy_from(&(&inverse * rotating_loads(plant)));
    for i in load..n {
        f[(i, i)] = -1.0 / MEMORY;
    }
    for (x, y) in [(rotating, rotating + 1), (rotating + 3, rotating + 4)] {
        (f[(x, y)], f[(y, x)]) = (-speed, speed);
    }
    for (i, to) in scale.iter().enumerate() {
        for (j, from) in scale.iter().enumerate() {
            f[(i, j)] *= from / to;
        }
    }
    let mut both = DMatrix::<f64>::zeros(2 * n, 2 * n);
    both.view_mut((0, 0), (n, n)).copy_from(&(-&f * period));
    both.view_mut((n, n), (n, n)).copy_from(&(f.transpose() * period));
    for i in load..n {
        // The unit of moments contains the lever. The rotating load has no axial component.
        let process_noise = match i {
            _ if i < rotating => of.process_noise,
            _ if i == rotating + 2 => 0.0,
            _ => of.turning_process_noise,
        };
        both[(i, n + i)] = process_noise * process_noise * period;
    }
    let e = both.exp();
    let transition = e.view((n, n), (n, n)).transpose();
    let disturbance = &transition * e.view((0, n), (n, n));
    Ok((transition, 0.5 * (&disturbance + disturbance.transpose())))
}
