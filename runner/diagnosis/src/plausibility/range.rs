//! Range check: the readings that the bearings allow at each probe.
//!
//! A bearing reaches its limit in a direction where its most loaded element has the contact pressure of the static limit of
//! ISO 76 (clearance plus elastic deflection), or, where contact pressures are not known, where its force is
//! `LARGEST_FORCE` times the loads on the rotor. A rigid shaft between two bearings cannot be farther from zero than
//! their limits allow at the probe's station. `MARGIN` leaves room for zero errors and damaged races. Probes of a `[system]` have no
//! station: nothing bounds them.

use super::ReadingLimits;
use ballrace::bearing::Bearing as _;
use ballrace::{Displacement, Phase};
use ballrace_models::build;
use ballrace_models::build::BuildError;
use ballrace_plant::{MountedBearing, Plant};
use ballrace_recording::Row;
use ballrace_recording::flaws::{Flaw, FlawLedger, Position};
use ballrace_recording::status::SampleStatus;
use ballrace_scene::{Direction, Probe, Scene};

/// Factor on the limit of the bearings up to which readings are accepted.
const MARGIN: f64 = 3.0;
/// Force of a bearing with unknown contact pressure at its limit, over the loads on the rotor.
const LARGEST_FORCE: f64 = 1000.0;
/// Axial force over the loads on the rotor up to which the observer's axial position is accepted without an axial probe.
pub const LARGEST_UNSEEN_FORCE: f64 = 10.0;
/// m/s^2
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// First and last displacement of the search, m.
const SEARCH: (f64, f64) = (1e-7, 1e-2);
/// Ratio of successive displacements of the search.
const STRIDE: f64 = 1.1;
/// Number of consecutive readings out of range up to which they are removed as a spike; later ones stay.
const SUSTAINED: u32 = 16;

/// Ranges of a scene's probes, and the readings found outside.
pub struct ReadingRange {
    /// Largest magnitude of each reading, m; infinite where nothing bounds it.
    largest: Vec<f64>,
    /// Largest magnitude of an estimated axial position, m; infinite with an axial probe.
    axial: f64,
    names: Vec<String>,
    /// Number of consecutive readings out of range.
    runs: Vec<u32>,
    /// Total number of readings out of range.
    outside: Vec<u64>,
    /// Total number of finite readings.
    readings: Vec<u64>,
    ledger: FlawLedger,
}

impl ReadingRange {
    /// Computes the ranges of the probes.
    ///
    /// # Errors
    /// A bearing geometry that the kernel rejects.
    pub fn try_new(scene: &Scene, plant: &Plant, probes: &[Probe]) -> Result<Self, BuildError> {
        let new = |largest: Vec<f64>, axial: f64| Self {
            axial,
            names: probes.iter().map(|p| p.column.clone()).collect(),
            runs: vec![0; largest.len()],
            outside: vec![0; largest.len()],
            readings: vec![0; largest.len()],
            largest,
            ledger: FlawLedger::default(),
        };
        if plant.layout.is_given() {
            return Ok(new(vec![f64::INFINITY; probes.len()], f64::INFINITY));
        }
        let loads = loads(scene);
        let limits = scene.bearings.iter().zip(&plant.bearings).map(|(bearing, mounted)| {
            let element_load = build::geometry(bearing)?.and(build::static_limit(bearing)?);
            Ok(Limit::new(plant, mounted, element_load, LARGEST_FORCE * loads))
        });
        let limits = limits.collect::<Result<Vec<_>, BuildError>>()?;
        let largest = probes.iter().map(|probe| MARGIN * at_probe(&limits, probe)).collect();
        Ok(new(largest, unseen_axial(plant, probes, loads)))
    }

    /// Checks the readings of a row. A short run of readings out of range is removed from it; a longer one stays, flagged.
    pub fn check(&mut self, row: &mut Row) -> SampleStatus {
        let at = Position::from(&*row);
        let mut any = false;
        for (i, reading) in row.probes.iter_mut().enumerate().take(self.largest.len()) {
            if reading.is_nan() {
                continue;
            }
            self.readings[i] += 1;
            if reading.abs() <= self.largest[i] {
                self.runs[i] = 0;
                continue;
            }
            any = true;
            self.outside[i] += 1;
            self.runs[i] = self.runs[i].saturating_add(1);
            self.ledger.record_reading(Flaw::ReadingOutOfRange, &self.names[i], at, 1, *reading);
            if self.runs[i] <= SUSTAINED {
                *reading = f64::NAN;
            }
        }
        SampleStatus::READING_OUT_OF_RANGE.when(any)
    }

    /// Copies readings, NaN in the place of those out of range.
    pub fn within(&self, readings: &[f64], into: &mut Vec<f64>) {
        into.clear();
        let limited = readings.iter().zip(&self.largest);
        into.extend(limited.map(|(&y, &largest)| if y.abs() <= largest { y } else { f64::NAN }));
    }

    /// Returns true where the bearings allow these readings and this axial position of an estimate.
    pub fn allows(&self, readings: impl Iterator<Item = f64>, axial: f64) -> bool {
        axial.abs() <= self.axial && readings.zip(&self.largest).all(|(y, &largest)| y.abs() <= largest)
    }

    /// Returns the limits with the share of the readings beyond them.
    pub fn limits(&self) -> ReadingLimits {
        let shares = self.outside.iter().zip(&self.readings).map(|(o, n)| *o as f64 / (*n).max(1) as f64);
        ReadingLimits { largest: self.largest.clone(), outside: shares.collect() }
    }

    /// Returns the number of readings out of range over all probes.
    pub fn count(&self) -> u64 {
        self.outside.iter().sum()
    }

    /// Returns the readings out of range for the report.
    pub const fn flaws(&self) -> &FlawLedger {
        &self.ledger
    }
}

/// Largest displacement of one bearing's inner ring, m and rad; infinite where the bearing does not resist.
struct Limit {
    station: f64,
    radial: f64,
    axial: f64,
    tilt: f64,
}

impl Limit {
    fn new(plant: &Plant, bearing: &MountedBearing, element_load: Option<f64>, force: f64) -> Self {
        let at = plant.resting(bearing, Phase::ZERO);
        let mut loads = vec![0.0; bearing.elements];
        let mut beyond = |u: &Displacement<f64>| match element_load {
            Some(limit) if bearing.elements > 0 => {
                loads.fill(0.0);
                bearing.bearing.element_loads(u, &at, &mut loads);
                loads.iter().any(|load| load.is_nan() || *load >= limit)
            }
            _ => {
                let [x, y, z, ..] = bearing.bearing.reaction(u, &at).wrench.to_array();
                let square = x * x + y * y + z * z;
                square.is_nan() || square >= force * force
            }
        };
        let mut reach = |along: fn(f64) -> Displacement<f64>, unit: f64| {
            let mut size = SEARCH.0;
            while size < SEARCH.1 {
                if beyond(&along(size * unit)) {
                    return size * unit.abs();
                }
                size *= STRIDE;
            }
            f64::INFINITY
        };
        // A bearing that carries thrust in one direction limits that direction only; its partner limits the other.
        let in_one_direction = |a: f64, b: f64| if a.is_infinite() || b.is_infinite() { a.min(b) } else { a.max(b) };
        let u = |x| Displacement { u: x, ..Displacement::default() };
        let v = |x| Displacement { v: x, ..Displacement::default() };
        let w = |x| Displacement { w: x, ..Displacement::default() };
        let tilt = |x| Displacement { thu: x, ..Displacement::default() };
        let radial = [reach(u, 1.0), reach(u, -1.0), reach(v, 1.0), reach(v, -1.0)];
        Self {
            station: bearing.station,
            radial: radial.into_iter().fold(0.0, f64::max),
            axial: in_one_direction(reach(w, 1.0), reach(w, -1.0)),
            tilt: in_one_direction(reach(tilt, 10.0), reach(tilt, -10.0)),
        }
    }
}

/// Returns the largest plausible force on bearing `i` over a recording, N: that of the static equilibrium, in which a preload counts, and
/// [`LARGEST_UNSEEN_FORCE`] times the loads on the rotor or its weight; infinite without a rotor.
pub fn plausible_force(scene: &Scene, plant: &Plant, i: usize) -> f64 {
    let weight = scene.rotor.as_ref().map_or(0.0, |rotor| rotor.mass * STANDARD_GRAVITY);
    let Some(bearing) = plant.bearings.get(i).filter(|_| weight > 0.0) else { return f64::INFINITY };
    let (u, at) = (plant.displacement(i, &plant.rest), plant.resting(bearing, Phase::ZERO));
    let [x, y, z, ..] = bearing.bearing.reaction(&u, &at).wrench.to_array();
    x.hypot(y).hypot(z) + LARGEST_UNSEEN_FORCE * loads(scene).max(weight)
}

/// Returns the largest magnitude of each probe's mean reading under the [`plausible_force`] of the bearings, m; infinite where nothing
/// bounds it.
pub fn positions(scene: &Scene, plant: &Plant, probes: &[Probe]) -> Vec<f64> {
    if plant.layout.is_given() || scene.rotor.is_none() {
        return vec![f64::INFINITY; probes.len()];
    }
    let limit = |(i, bearing)| Limit::new(plant, bearing, None, plausible_force(scene, plant, i));
    let limits: Vec<Limit> = plant.bearings.iter().enumerate().map(limit).collect();
    probes.iter().map(|probe| at_probe(&limits, probe)).collect()
}

/// Returns the largest magnitude of an axial position without an axial probe. Innovations do not correct it, so it may diverge
/// where the rotor differs from the scene.
fn unseen_axial(plant: &Plant, probes: &[Probe], loads: f64) -> f64 {
    if loads == 0.0 || probes.iter().any(|probe| probe.direction == Direction::Axial) {
        return f64::INFINITY;
    }
    let limits =
        plant.bearings.iter().map(|bearing| Limit::new(plant, bearing, None, LARGEST_UNSEEN_FORCE * loads).axial);
    let largest = limits.filter(|x| x.is_finite()).reduce(f64::max).unwrap_or(f64::INFINITY);
    plant.pose(&plant.rest).w.abs() + largest
}

/// Returns the largest magnitude of a probe's reading that the limits of the bearings allow.
fn at_probe(limits: &[Limit], probe: &Probe) -> f64 {
    if probe.direction == Direction::Axial {
        // Each direction of thrust may be carried by another bearing: the larger limit counts.
        let finite = limits.iter().map(|l| l.axial).filter(|x| x.is_finite());
        return finite.reduce(f64::max).unwrap_or(f64::INFINITY);
    }
    let z = probe.station;
    let mut least = limits.iter().map(|l| l.radial + (z - l.station).abs() * l.tilt).fold(f64::INFINITY, f64::min);
    for (i, a) in limits.iter().enumerate() {
        for b in limits.iter().skip(i + 1).filter(|b| b.station != a.station) {
            let share = (z - a.station) / (b.station - a.station);
            least = least.min((1.0 - share).abs() * a.radial + share.abs() * b.radial);
        }
    }
    least
}

/// Returns the magnitude of weight, load and unbalance force on the rotor at the highest speed of the scene, N.
fn loads(scene: &Scene) -> f64 {
    let Some(rotor) = &scene.rotor else { return 0.0 };
    let (slow, fast) = scene.shaft.speed.range();
    let speed = slow.abs().max(fast.abs());
    let unbalance: f64 = build::unbalances(rotor).iter().map(|u| u.moment.abs() * speed * speed).sum();
    let length = |x: [f64; 3]| x.iter().map(|a| a * a).sum::<f64>().sqrt();
    let [x, y, z, ..] = rotor.load;
    rotor.mass * length(rotor.gravity) + length([x, y, z]) + unbalance
}
