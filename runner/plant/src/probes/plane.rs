//! Planes of two radial probes: readings to X and Y.

use ballrace_scene::Probe;
use std::ops::{Add, Mul};

/// Two radial probes that are not parallel, at one station or at the same coordinates of a `[system]`, with the matrix from their
/// readings to X and Y.
#[derive(Debug, Clone)]
pub struct Plane {
    /// Indices of the two probes.
    pub probes: [usize; 2],
    /// Station along Z, m.
    pub station: f64,
    inverse: [[f64; 2]; 2],
}

/// Returns the planes of the radial probes: at each station, or coordinates, the first two probes that are not parallel.
#[must_use]
pub fn planes(probes: &[Probe]) -> Vec<Plane> {
    let radial: Vec<(usize, &Probe, f64)> =
        probes.iter().enumerate().filter_map(|(i, p)| Some((i, p, p.direction.angle()?))).collect();
    let is_beside = |a: &Probe, b: &Probe| (a.station - b.station).abs() < 1e-9 && a.coordinates == b.coordinates;
    let mut planes: Vec<Plane> = Vec::new();
    for (n, &(i, probe, a)) in radial.iter().enumerate() {
        if planes.iter().any(|plane| is_beside(&probes[plane.probes[0]], probe)) {
            continue;
        }
        let partner = radial[n + 1..].iter().find(|(_, other, b)| is_beside(other, probe) && (b - a).sin().abs() > 0.1);
        if let Some(&(k, _, b)) = partner {
            let det = (b - a).sin();
            let inverse = [[b.sin() / det, -a.sin() / det], [-b.cos() / det, a.cos() / det]];
            planes.push(Plane { probes: [i, k], station: probe.station, inverse });
        }
    }
    planes
}

impl Plane {
    /// Returns X and Y from the readings of all probes.
    #[must_use]
    pub fn xy(&self, readings: &[f64]) -> (f64, f64) {
        self.xy_from(readings[self.probes[0]], readings[self.probes[1]])
    }

    /// Returns X and Y from the readings of the two probes of the plane.
    #[must_use]
    pub fn xy_from<T: Copy + Add<Output = T> + Mul<f64, Output = T>>(&self, a: T, b: T) -> (T, T) {
        let row = |r: [f64; 2]| a * r[0] + b * r[1];
        (row(self.inverse[0]), row(self.inverse[1]))
    }
}
