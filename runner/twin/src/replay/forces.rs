//! Forces of the bearings: from the measured displacement, and the twin's beside them.

use super::outcome::{BearingOrders, BearingOutcome, ForceFigures};
use super::pose::PoseSolver;
use super::statistics::Running;
use crate::plant::MountedBearing;
use crate::scene::Probe;
use ballrace::bearing::{Bearing, LastValidWrench};
use ballrace::{BearingKinematicState, Displacement, Phase, Status};

/// Bins around the ring in which element loads are gathered.
pub const AZIMUTH_BINS: usize = 72;

/// What one bearing did in one sample.
#[derive(Clone, Copy, Default)]
pub struct Evaluated {
    /// From the measured displacement: the force on the inner ring.
    pub measured: [f64; 5],
    /// The twin's.
    pub twin: [f64; 5],
    /// At the observer's position; `measured` where the observer is not trusted.
    pub estimated: [f64; 5],
    /// What probe noise alone puts on `measured`, one standard deviation; NaN when unknown.
    pub sigma: [f64; 5],
    /// Flags of `measured`.
    pub status: Status,
}

/// Sums of one bearing over the recording.
pub struct BearingSums {
    held: LastValidWrench<f64>,
    measured: [Running; 5],
    twin: [Running; 5],
    estimated: [Running; 5],
    sigma: [Running; 5],
    contact_lost: u64,
    /// Samples with a force from the displacement, and those in which the twin carries no load.
    evaluated: u64,
    twin_contact_lost: u64,
    held_samples: u64,
    largest: f64,
    loads: Vec<f64>,
    /// Load by azimuth: measured mean and largest, twin mean.
    pub around: Vec<[Running; 2]>,
}

impl BearingSums {
    /// For a bearing of so many elements.
    #[must_use]
    pub fn new(elements: usize) -> Self {
        Self {
            held: LastValidWrench::new(),
            measured: Default::default(),
            twin: Default::default(),
            estimated: Default::default(),
            sigma: Default::default(),
            contact_lost: 0,
            evaluated: 0,
            twin_contact_lost: 0,
            held_samples: 0,
            largest: 0.0,
            loads: vec![0.0; elements],
            around: vec![Default::default(); AZIMUTH_BINS],
        }
    }

    /// The forces from the measured pose (NaN where a reading is missing: the last good force is held), and where they are
    /// given, from the twin's and the observer's (0 where not). An observer without a pose is one that is not trusted: the
    /// measured force takes its place.
    pub fn evaluate(
        &mut self,
        seat: &MountedBearing,
        pose: &Displacement<f64>,
        others: Option<(&Displacement<f64>, Option<&Displacement<f64>>)>,
        at: &BearingKinematicState<f64>,
    ) -> Evaluated {
        let (wrench, status) = seat.bearing.sample(&mut self.held, &pose.at_station(seat.station), at);
        let measured = wrench.to_array();
        let (twin, estimated) = others.map_or(([0.0; 5], [0.0; 5]), |(twin, observed)| {
            (force_at(seat, twin, at), observed.map_or(measured, |pose| force_at(seat, pose, at)))
        });
        Evaluated { measured, twin, estimated, sigma: [f64::NAN; 5], status }
    }

    /// Adds a sample to the sums; returns the load on element 1.
    pub fn add(
        &mut self,
        seat: &MountedBearing,
        sample: &Evaluated,
        poses: [&Displacement<f64>; 2],
        at: &BearingKinematicState<f64>,
    ) -> f64 {
        self.contact_lost += u64::from(sample.status.contains(Status::CONTACT_LOST));
        self.evaluated += u64::from(!sample.status.is_held());
        self.twin_contact_lost += u64::from(sample.twin == [0.0; 5]);
        self.held_samples += u64::from(sample.status.is_held());
        for i in 0..5 {
            self.twin[i].add(sample.twin[i]);
            self.estimated[i].add(sample.estimated[i]);
            if !sample.status.is_held() {
                self.measured[i].add(sample.measured[i]);
                if sample.sigma[i].is_finite() {
                    self.sigma[i].add(sample.sigma[i]);
                }
            }
        }
        let twin_first = self.gather(seat, poses[1], at, 1);
        if sample.status.is_held() { twin_first } else { self.gather(seat, poses[0], at, 0) }
    }

    /// Shares of the samples in which no element carries load: at the measured displacement and in the twin.
    #[must_use]
    pub fn unloaded_shares(&self) -> [f64; 2] {
        let twin = self.twin.first().map_or(0.0, Running::count);
        [self.contact_lost as f64 / self.evaluated.max(1) as f64, self.twin_contact_lost as f64 / twin.max(1.0)]
    }

    fn gather(
        &mut self,
        seat: &MountedBearing,
        pose: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
        which: usize,
    ) -> f64 {
        self.loads.fill(0.0);
        seat.bearing.element_loads(&pose.at_station(seat.station), at, &mut self.loads);
        let n = self.loads.len() as f64;
        for (j, &load) in self.loads.iter().enumerate() {
            let azimuth = at
                .cage
                .wrapping_add(Phase::from_revolutions(seat.first_azimuth / std::f64::consts::TAU + j as f64 / n));
            let bin = (azimuth.revolutions() * AZIMUTH_BINS as f64) as usize % AZIMUTH_BINS;
            self.around[bin][which].add(load);
            if which == 0 {
                self.largest = self.largest.max(load);
            }
        }
        self.loads.first().copied().unwrap_or(0.0)
    }

    /// The figures.
    #[must_use]
    pub fn outcome(&self, seat: &MountedBearing) -> BearingOutcome {
        let figures = |running: &Running, sigma: Option<&Running>| ForceFigures {
            mean: running.mean(),
            min: running.extremes().0,
            max: running.extremes().1,
            noise_sigma: sigma.map(Running::rms).filter(|s| *s > 0.0),
        };
        let orders = seat.kinematics.orders;
        BearingOutcome {
            name: seat.name.clone(),
            model: seat.description.clone(),
            station_mm: seat.station * 1e3,
            orders: BearingOrders {
                cage: orders.cage,
                outer_race: orders.outer_race,
                inner_race: orders.inner_race,
                ball_spin: seat.kinematics.spin_known.then_some(orders.ball_spin),
            },
            force_measured: std::array::from_fn(|i| figures(&self.measured[i], Some(&self.sigma[i]))),
            force_estimated: std::array::from_fn(|i| figures(&self.estimated[i], None)),
            force_twin: std::array::from_fn(|i| figures(&self.twin[i], None)),
            largest_element_load_n: self.largest,
            contact_lost_samples: self.contact_lost,
            held_samples: self.held_samples,
        }
    }
}

/// Azimuth (rad) and load (N) of every element.
#[must_use]
pub fn loads(seat: &MountedBearing, pose: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Vec<(f64, f64)> {
    let mut loads = vec![0.0; seat.elements];
    seat.bearing.element_loads(&pose.at_station(seat.station), at, &mut loads);
    let n = loads.len() as f64;
    let azimuth = |j: usize| at.cage.radians() + seat.first_azimuth + j as f64 / n * std::f64::consts::TAU;
    loads.into_iter().enumerate().map(|(j, load)| (azimuth(j), load)).collect()
}

/// Standard deviation of the force that independent probe noise puts on it, by moving each probe's reading one
/// standard deviation either way: the larger change of the two, so that the band also holds at the edge of contact,
/// where the tangent is zero on one side. None where a probe's noise is not given.
#[must_use]
pub fn noise_band(
    seat: &MountedBearing,
    solver: &PoseSolver,
    probes: &[Probe],
    pose: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
) -> Option<[f64; 5]> {
    let here = force_at(seat, pose, at);
    let mut variance = [0.0; 5];
    for (i, probe) in probes.iter().enumerate() {
        let noise = probe.noise?;
        let column = solver.column(i).to_array();
        let moved = |sign: f64| {
            let mut q = pose.to_array();
            for (x, c) in q.iter_mut().zip(column) {
                *x += sign * noise * c;
            }
            force_at(seat, &Displacement::from_array(q), at)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        for (k, sum) in variance.iter_mut().enumerate() {
            let change = (up[k] - here[k]).abs().max((down[k] - here[k]).abs());
            *sum += change * change;
        }
    }
    Some(variance.map(f64::sqrt))
}

fn force_at(seat: &MountedBearing, pose: &Displacement<f64>, at: &BearingKinematicState<f64>) -> [f64; 5] {
    seat.bearing.reaction(&pose.at_station(seat.station), at).wrench.to_array()
}
