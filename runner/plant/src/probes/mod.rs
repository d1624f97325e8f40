//! Displacement probes: their readings of the shaft's position, and the position from their readings.
//!
//! A radial probe at station `z` looking along the angle `a` reads `(u + z thv) cos a + (v - z thu) sin a`, an axial probe
//! reads `w`. Two planes with two directions each determine `u, v, thu, thv` by least squares.

mod plane;

pub use plane::{Plane, planes};

use ballrace::Displacement;
use ballrace_outcome::Observation;
use ballrace_scene::{Direction, Probe};
use nalgebra::{DMatrix, DVector};

/// Returns the change of a probe's reading per unit of each coordinate of a rigid shaft.
#[must_use]
pub fn row(probe: &Probe) -> [f64; 5] {
    match probe.direction {
        Direction::Axial => [0.0, 0.0, 1.0, 0.0, 0.0],
        Direction::Radial(angle) => {
            let (s, c) = angle.sin_cos();
            [c, s, 0.0, -probe.station * s, probe.station * c]
        }
    }
}

/// Returns the reading of a probe at `coordinates`, m; `row` is its change per unit of each.
#[must_use]
pub fn reading(row: &[f64], coordinates: &[f64]) -> f64 {
    row.iter().zip(coordinates).map(|(a, x)| a * x).sum()
}

/// Error returned for probes that do not determine the displacement of the shaft.
#[derive(Debug, thiserror::Error)]
#[error(
    "recording.probes: probes that do not determine the shaft's position: {reason}, expected two planes, each with two \
     directions that are not parallel"
)]
pub struct UnobservableError {
    /// Reason found in the arrangement of the probes.
    pub reason: String,
}

/// Least-squares solution for the position, `q = matrix * readings`, with the matrix computed once.
pub struct PoseSolver {
    inverse: Vec<[f64; 5]>,
    has_axial_probe: bool,
    /// Conditioning of the least-squares problem.
    pub observation: Observation,
}

impl PoseSolver {
    /// Creates the solver for these probes. `bearings` are the stations (m) at which the noise gain is evaluated.
    ///
    /// # Errors
    /// Probes that do not determine a radial or tilt coordinate.
    pub fn try_new(probes: &[Probe], bearings: &[f64]) -> Result<Self, UnobservableError> {
        let rows: Vec<[f64; 5]> = probes.iter().map(row).collect();
        let has_axial_probe = probes.iter().any(|p| p.direction == Direction::Axial);
        let span = length_scale(probes);
        let active: Vec<usize> = (0..5).filter(|&i| i != 2 || has_axial_probe).collect();
        // Tilts times the probes' distance: all unknowns are lengths, so that the condition number is independent of units.
        let scale = |i: usize| if i < 3 { 1.0 } else { span };
        let matrix = DMatrix::from_fn(rows.len(), active.len(), |i, j| rows[i][active[j]] / scale(active[j]));
        let svd = matrix.svd(true, true);
        let largest = svd.singular_values.max();
        let smallest = svd.singular_values.min();
        let unknowns = active.len();
        if rows.len() < unknowns || smallest <= 1e-9 * largest {
            return Err(unobservable(probes));
        }
        let pseudo = svd.pseudo_inverse(0.0).map_err(|_| unobservable(probes))?;
        let inverse: Vec<[f64; 5]> = (0..rows.len())
            .map(|k| {
                let mut column = [0.0; 5];
                for (j, &i) in active.iter().enumerate() {
                    column[i] = pseudo[(j, k)] / scale(i);
                }
                column
            })
            .collect();
        let observation = Observation {
            condition_number: largest / smallest,
            noise_gain: noise_gain(&inverse, bearings),
            supplied_by_twin: if has_axial_probe { vec![] } else { vec!["w".to_owned()] },
        };
        Ok(Self { inverse, has_axial_probe, observation })
    }

    /// Returns the position from readings (m), with the axial coordinate `w` where there is no axial probe.
    #[must_use]
    pub fn pose(&self, readings: &[f64], w: f64) -> Displacement<f64> {
        let mut q = [0.0; 5];
        for (column, reading) in self.inverse.iter().zip(readings) {
            for (entry, a) in q.iter_mut().zip(column) {
                *entry += a * reading;
            }
        }
        if !self.has_axial_probe {
            q[2] = w;
        }
        Displacement::from_array(q)
    }

    /// Returns the change of the position per metre of one probe's reading.
    #[must_use]
    pub fn column(&self, probe: usize) -> Displacement<f64> {
        Displacement::from_array(self.inverse.get(probe).copied().unwrap_or_default())
    }
}

/// Returns the rms distance (m) of the radial probes from their mean station, or 1 m where there is none.
fn length_scale(probes: &[Probe]) -> f64 {
    let stations: Vec<f64> = probes.iter().filter(|p| p.direction != Direction::Axial).map(|p| p.station).collect();
    let n = stations.len().max(1) as f64;
    let mean = stations.iter().sum::<f64>() / n;
    let spread = (stations.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n).sqrt();
    if spread > 0.0 { spread } else { 1.0 }
}

/// Returns the largest ratio of a bearing's radial position error to the probe noise that causes it.
fn noise_gain(inverse: &[[f64; 5]], bearings: &[f64]) -> f64 {
    bearings
        .iter()
        .flat_map(|&z| {
            let along = |f: fn(&Displacement<f64>) -> f64| {
                let parts = inverse.iter().map(|c| f(&Displacement::from_array(*c).at_station(z)));
                DVector::from_iterator(inverse.len(), parts).norm()
            };
            [along(|d| d.u), along(|d| d.v)]
        })
        .fold(0.0, f64::max)
}

fn unobservable(probes: &[Probe]) -> UnobservableError {
    let radial: Vec<(f64, f64)> = probes.iter().filter_map(|p| Some((p.station, p.direction.angle()?))).collect();
    let mut planes: Vec<f64> = radial.iter().map(|r| r.0).collect();
    planes.sort_by(f64::total_cmp);
    planes.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let first = radial.first().map_or(0.0, |r| r.1);
    let parallel = radial.iter().all(|r| (r.1 - first).sin().abs() < 1e-6);
    let reason = if radial.is_empty() {
        "there is no radial probe".to_owned()
    } else if parallel {
        format!(
            "all {} radial probes measure along {:.1} deg, so the motion across it is not observable",
            radial.len(),
            first.to_degrees()
        )
    } else if planes.len() < 2 {
        format!("all radial probes are in one plane at {:.1} mm, so the tilt is not observable", planes[0] * 1e3)
    } else {
        format!("{} radial probes do not determine the motion", radial.len())
    };
    UnobservableError { reason }
}
