//! Force stage: the forces of the bearings at the measured displacement, at the observer's and at the twin's.

use super::statistics::{LoadSums, Running, RunningTogether};
use ballrace::bearing::{Bearing, LastValidWrench};
use ballrace::rotor::{ComponentAngles, ShaftMotion};
use ballrace::{BearingKinematicState, Displacement, Phase, Status};
use ballrace_outcome::options::Source;
use ballrace_outcome::{BearingOrders, BearingOutcome, ForceFigures};
use ballrace_plant::MountedBearing;
use ballrace_recording::status::SampleStatus;
use ballrace_scene::Probe;
use ballrace_studies::recorded_life::RecordedLife;

/// Number of azimuth bins around the ring for element loads.
pub(crate) const AZIMUTH_BINS: usize = 72;
/// Largest rate of samples with evaluated forces in live operation, Hz; a quarter of them enters the figures.
pub(crate) const LIVE_FORCE_RATE: f64 = 3200.0;
/// Decimation factor of the noise-band computation after the first revolutions, which the figures show; a prime number, so that it meets
/// all angles of the shaft.
const NOISE_BAND_DECIMATION: u64 = 31;
/// Decimation factor of the loads that make the life; a prime number as that of the noise band.
const LIFE_DECIMATION: u64 = 31;

/// Forces of one bearing at one sample: FX, FY, FZ (N), MX, MY (N m) on the inner ring.
#[derive(Clone, Copy, Default)]
pub(crate) struct EvaluatedForce {
    /// At the measured displacement.
    pub measured: [f64; 5],
    /// At the displacement of the twin.
    pub twin: [f64; 5],
    /// At the displacement of the observer; `measured` where the observer is not trusted.
    pub estimated: [f64; 5],
    /// That of the figures: `measured`, or the observer's where the displacement is not on a straight line; none where that is missing.
    pub shown: Option<[f64; 5]>,
    /// Standard deviation of `measured` due to probe noise; NaN where unknown.
    pub sigma: [f64; 5],
    /// Status flags of `measured`; the loss of contact is that of `shown`.
    pub status: Status,
}

impl EvaluatedForce {
    /// Returns the force of a source.
    pub(super) const fn of(&self, source: Source) -> [f64; 5] {
        match source {
            Source::Observer => self.estimated,
            Source::Displacement => self.measured,
        }
    }
}

/// Displacements of one bearing at one sample, inner ring against outer ring.
#[derive(Clone, Copy)]
pub(super) struct Displacements {
    /// From the probes, on a straight line between their planes; NaN where a reading is missing.
    pub(super) measured: Displacement<f64>,
    /// In the twin.
    pub(super) twin: Displacement<f64>,
    /// As the observer estimates it; none where it is not trusted.
    pub(super) observer: Option<Displacement<f64>>,
    /// In the twin on the straight line between its own readings; only where its error is due.
    pub(super) straightened: Option<Displacement<f64>>,
}

impl Displacements {
    /// Returns the displacement of a source; the measured one where the observer is not trusted.
    pub(super) fn of(&self, source: Source) -> Displacement<f64> {
        match source {
            Source::Observer => self.observer.unwrap_or(self.measured),
            Source::Displacement => self.measured,
        }
    }
}

/// Evaluates the forces of a replay and accumulates them.
pub(super) struct ForceStage {
    bearings: Vec<BearingForces>,
    /// Lives of the bearings; none where the contacts of a bearing are not known.
    lives: Vec<Option<RecordedLife>>,
    /// Forces of the current sample; empty where the sample is skipped.
    evaluated: Vec<EvaluatedForce>,
    /// Decimation factor of the forces at the measured displacement.
    force_decimation: u64,
    /// Decimation factor of all forces and their sums, a multiple of `force_decimation`.
    report_decimation: u64,
    /// The displacements are on a straight line between the planes of the probes.
    is_straight: bool,
}

impl ForceStage {
    /// Creates the stage. `straight`: the displacements of the bearings are on a straight line between the planes of the probes, or are not derived
    /// from one; `decimated` limits the work in live operation.
    pub(super) fn new(
        bearings: &[MountedBearing],
        lives: Vec<Option<RecordedLife>>,
        rate: f64,
        straight: bool,
        decimated: bool,
    ) -> Self {
        let force_decimation = if decimated { (rate / LIVE_FORCE_RATE).ceil() as u64 } else { 1 };
        Self {
            bearings: bearings.iter().map(|b| BearingForces::new(b.elements, straight)).collect(),
            lives,
            evaluated: Vec::new(),
            force_decimation,
            report_decimation: force_decimation * if decimated { 4 } else { 1 },
            is_straight: straight,
        }
    }

    /// Evaluates the forces of the sample `index` at `displacements`, which are empty where none are due; returns the status flags of all bearings.
    pub(super) fn evaluate(
        &mut self,
        index: u64,
        bearings: &[MountedBearing],
        parts: &[ComponentAngles],
        shaft: &ShaftMotion<f64>,
        displacements: &[Displacements],
    ) -> SampleStatus {
        self.evaluated.clear();
        let mut status = SampleStatus::default();
        let with_all = self.is_reported(index);
        let all = bearings.iter().zip(&mut self.bearings).zip(parts).zip(displacements);
        for (((bearing, forces), &parts), displacements) in all {
            let force = forces.evaluate(bearing, displacements, with_all, &bearing.rotation(parts, shaft));
            status = status.and(force.status.into());
            self.evaluated.push(force);
        }
        status
    }

    /// Returns true where the forces of the sample `index` at the measured displacement are evaluated.
    pub(super) const fn is_due(&self, index: u64) -> bool {
        index.is_multiple_of(self.force_decimation)
    }

    /// Returns true where all forces of the sample `index` are evaluated and enter the sums.
    pub(super) const fn is_reported(&self, index: u64) -> bool {
        index.is_multiple_of(self.report_decimation)
    }

    /// Returns true where the displacements are on a straight line between the planes of the probes.
    pub(super) const fn is_straight(&self) -> bool {
        self.is_straight
    }

    /// Returns true where the noise band of the sample `index` is due after the first revolutions.
    pub(super) const fn is_noise_band_due(index: u64) -> bool {
        index.is_multiple_of(NOISE_BAND_DECIMATION)
    }

    /// Forces of the current sample; empty where the sample is skipped.
    pub(super) fn evaluated(&self) -> &[EvaluatedForce] {
        &self.evaluated
    }

    /// Adds the forces of bearing `i` to its sums; returns the forces and the load on element 1.
    ///
    /// The noise band is computed where `noise` contains the probes and the change of the displacement per metre of the reading of each.
    pub(super) fn accumulate(
        &mut self,
        i: usize,
        bearing: &MountedBearing,
        displacements: &Displacements,
        at: &BearingKinematicState<f64>,
        noise: Option<(&[Probe], &[Displacement<f64>])>,
    ) -> Option<(&EvaluatedForce, f64)> {
        let (force, forces) = (self.evaluated.get_mut(i)?, self.bearings.get_mut(i)?);
        if let Some(noise) = noise
            && !force.status.is_held()
            && let Some(sigma) = noise_band(bearing, noise, &displacements.measured, at)
        {
            force.sigma = sigma;
        }
        let first_load = forces.add(bearing, force, at.cage);
        Some((force, first_load))
    }

    /// Returns true where the sample `index` enters the lives.
    pub(super) const fn is_life_due(index: u64) -> bool {
        index.is_multiple_of(LIFE_DECIMATION)
    }

    /// Adds the loads of bearing `i` to its life: those at the observer's displacement, or at the measured one where the observer is not trusted.
    pub(super) fn add_life(
        &mut self,
        i: usize,
        bearing: &MountedBearing,
        displacements: &Displacements,
        at: &BearingKinematicState<f64>,
    ) {
        let displacement = displacements.of(Source::Observer);
        if let (Some(Some(life)), Some(force)) = (self.lives.get_mut(i), self.evaluated.get(i))
            && displacement.is_finite()
        {
            life.add(&(displacement + bearing.offset), &force.of(Source::Observer), at);
        }
    }

    /// Returns the sums of every bearing.
    pub(super) fn bearings(&self) -> &[BearingForces] {
        &self.bearings
    }

    /// Returns the outcome of every bearing.
    pub(super) fn outcomes(&self, bearings: &[MountedBearing]) -> Vec<BearingOutcome> {
        let life = |life: &Option<RecordedLife>| life.as_ref().and_then(RecordedLife::outcome);
        let all = self.bearings.iter().zip(&self.lives).zip(bearings);
        all.map(|((forces, of), bearing)| BearingOutcome { life: life(of), ..forces.outcome(bearing) }).collect()
    }
}

/// Forces of one bearing over the recording.
pub struct BearingForces {
    held: LastValidWrench<f64>,
    measured: RunningTogether<5>,
    twin: RunningTogether<5>,
    estimated: RunningTogether<5>,
    sigma: [Running; 5],
    contact_lost: u64,
    /// Number of samples with `EvaluatedForce::shown`.
    evaluated: u64,
    /// Number of samples in which the bearing carries no load in the twin.
    twin_contact_lost: u64,
    held_samples: u64,
    /// The displacement is on a straight line between the planes of the probes.
    is_straight: bool,
    /// Error of the force on the straight line in the twin.
    straight_line_error: [Running; 5],
    /// Loads of the elements at the present sample, at the displacement of `EvaluatedForce::shown` and in the twin.
    loads: [Vec<f64>; 2],
    /// Loads by azimuth.
    pub around: Vec<LoadSums>,
}

impl BearingForces {
    fn new(elements: usize, is_straight: bool) -> Self {
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
            is_straight,
            straight_line_error: Default::default(),
            loads: [vec![0.0; elements], vec![0.0; elements]],
            around: vec![LoadSums::default(); AZIMUTH_BINS],
        }
    }

    /// Evaluates the forces of a sample: those at the measured displacement, and with `with_all` the others too (else 0). Where a
    /// reading is missing, the last valid force is repeated; where the observer is not trusted, the measured force replaces its
    /// force.
    fn evaluate(
        &mut self,
        bearing: &MountedBearing,
        displacements: &Displacements,
        with_all: bool,
        at: &BearingKinematicState<f64>,
    ) -> EvaluatedForce {
        let none = EvaluatedForce { sigma: [f64::NAN; 5], ..EvaluatedForce::default() };
        if !with_all {
            let (measured, status) = bearing.bearing.sample(&mut self.held, &displacements.measured, at);
            return EvaluatedForce { measured: measured.to_array(), status, ..none };
        }
        let [loads, twin_loads] = &mut self.loads;
        let (measured, mut status) = self.held.update(displacements.measured.is_finite(), || {
            bearing.bearing.reaction_and_loads(&displacements.measured, at, loads)
        });
        let measured = measured.to_array();
        let twin = bearing.bearing.reaction_and_loads(&displacements.twin, at, twin_loads).wrench.to_array();
        if self.is_straight {
            let estimated = displacements.observer.map_or(measured, |q| force_at(bearing, &q, at));
            let shown = (!status.is_held()).then_some(measured);
            return EvaluatedForce { measured, twin, estimated, shown, status, ..none };
        }
        let observer = displacements.observer.map(|q| bearing.bearing.reaction_and_loads(&q, at, loads));
        let is_lost = observer.as_ref().is_some_and(|force| force.status.contains(Status::CONTACT_LOST));
        status =
            Status::from_bits(status.bits() & !Status::CONTACT_LOST.bits()).union(Status::CONTACT_LOST.when(is_lost));
        if let Some(straightened) = &displacements.straightened {
            let force = force_at(bearing, straightened, at);
            self.straight_line_error.iter_mut().zip(force).zip(twin).for_each(|((sum, f), twin)| sum.add(f - twin));
        }
        let shown = observer.map(|force| force.wrench.to_array());
        EvaluatedForce { measured, twin, estimated: shown.unwrap_or(measured), shown, status, ..none }
    }

    /// Adds a sample and the loads of its evaluation to the sums; returns the load on element 1.
    fn add(&mut self, bearing: &MountedBearing, sample: &EvaluatedForce, cage: Phase) -> f64 {
        self.contact_lost += u64::from(sample.status.contains(Status::CONTACT_LOST));
        self.evaluated += u64::from(sample.shown.is_some());
        self.twin_contact_lost += u64::from(sample.twin == [0.0; 5]);
        self.held_samples += u64::from(sample.status.is_held());
        self.twin.add(&sample.twin);
        if self.is_straight || sample.shown.is_some() {
            self.estimated.add(&sample.estimated);
        }
        if !sample.status.is_held() {
            self.measured.add(&sample.measured);
            for (sum, sigma) in self.sigma.iter_mut().zip(sample.sigma).filter(|(_, sigma)| sigma.is_finite()) {
                sum.add(sigma);
            }
        }
        self.add_element_loads(bearing, sample, cage);
        let first = self.loads[usize::from(sample.shown.is_none())].first();
        first.copied().unwrap_or(0.0)
    }

    /// Returns the shares of samples in which no element carries load, at the displacement of `EvaluatedForce::shown` and in the twin.
    #[must_use]
    pub(crate) fn unloaded_shares(&self) -> [f64; 2] {
        let twin = self.twin.of(0).count();
        [self.contact_lost as f64 / self.evaluated.max(1) as f64, self.twin_contact_lost as f64 / twin.max(1.0)]
    }

    /// Adds the loads of the last evaluation by azimuth: those in the twin and those of `EvaluatedForce::shown`.
    fn add_element_loads(&mut self, bearing: &MountedBearing, sample: &EvaluatedForce, cage: Phase) {
        let ([loads, twin_loads], is_shown) = (&self.loads, sample.shown.is_some());
        for ((&load, &twin_load), azimuth) in loads.iter().zip(twin_loads).zip(bearing.azimuths(cage)) {
            let at = &mut self.around[((u128::from(azimuth.0) * AZIMUTH_BINS as u128) >> 64) as usize];
            at.add_twin(twin_load);
            if is_shown {
                at.add(load);
            }
        }
    }

    /// Returns the outcome of the bearing.
    fn outcome(&self, bearing: &MountedBearing) -> BearingOutcome {
        let figures = |running: Running, sigma: Option<&Running>| ForceFigures {
            mean: running.mean(),
            min: running.extremes().0,
            max: running.extremes().1,
            noise_sigma: sigma.map(Running::rms).filter(|s| *s > 0.0),
        };
        let orders = bearing.kinematics.orders;
        BearingOutcome {
            name: bearing.name.clone(),
            model: bearing.description.clone(),
            station_mm: bearing.station * 1e3,
            orders: BearingOrders {
                cage: orders.cage,
                outer_race: orders.outer_race,
                inner_race: orders.inner_race,
                ball_spin: bearing.kinematics.spin_known.then_some(orders.ball_spin),
            },
            force_measured: std::array::from_fn(|i| figures(self.measured.of(i), Some(&self.sigma[i]))),
            force_estimated: std::array::from_fn(|i| figures(self.estimated.of(i), None)),
            force_twin: std::array::from_fn(|i| figures(self.twin.of(i), None)),
            straight_line_error: (!self.is_straight).then(|| self.straight_line_error.each_ref().map(Running::rms)),
            largest_element_load_n: self.around.iter().map(LoadSums::largest).fold(0.0, f64::max),
            contact_lost_samples: self.contact_lost,
            held_samples: self.held_samples,
            life: None,
        }
    }
}

/// Returns azimuth (rad) and load (N) of every element.
#[must_use]
pub fn element_loads(
    bearing: &MountedBearing,
    displacement: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
) -> Vec<(f64, f64)> {
    let mut loads = vec![0.0; bearing.elements];
    bearing.bearing.element_loads(displacement, at, &mut loads);
    bearing.azimuths(at.cage).map(Phase::radians).zip(loads).collect()
}

/// Returns the standard deviation of the force due to independent probe noise; `columns` are the changes of the displacement per metre of
/// the reading of each probe. None where the noise of a probe is not given.
///
/// Each reading is moved by one standard deviation either way, and the larger change counts, so that the band also holds at the
/// edge of contact, where the tangent is zero on one side.
fn noise_band(
    bearing: &MountedBearing,
    (probes, columns): (&[Probe], &[Displacement<f64>]),
    displacement: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
) -> Option<[f64; 5]> {
    let here = force_at(bearing, displacement, at);
    let mut variance = [0.0; 5];
    for (probe, column) in probes.iter().zip(columns) {
        let noise = probe.noise?;
        let column = column.to_array();
        let moved = |sign: f64| {
            let mut q = displacement.to_array();
            for (x, c) in q.iter_mut().zip(column) {
                *x += sign * noise * c;
            }
            force_at(bearing, &Displacement::from_array(q), at)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        for (k, sum) in variance.iter_mut().enumerate() {
            let change = (up[k] - here[k]).abs().max((down[k] - here[k]).abs());
            *sum += change * change;
        }
    }
    Some(variance.map(f64::sqrt))
}

fn force_at(bearing: &MountedBearing, displacement: &Displacement<f64>, at: &BearingKinematicState<f64>) -> [f64; 5] {
    bearing.bearing.reaction(displacement, at).wrench.to_array()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::f64::consts::TAU;
    use std::path::Path;

    /// A bearing with three elements, of which the second is at 90 degrees and not at 120, plus `more`.
    fn bearing(more: &str) -> MountedBearing {
        let text = format!(
            "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\nelements = 3\n\
             facing = \"both\"\nstiffness = 1e10\nradial_play = 0\ncage_ratio = 0.4\nelement_azimuths = [\"0 deg\", \"90 deg\", \"200 deg\"]\n\
             axial = {{ stiffness = 1e9, exponent = 1.5, play = 0, radius = 0.02 }}\n{more}\n"
        );
        let scene = read_str(&text, Path::new("scene.toml")).unwrap();
        MountedBearing::new(&scene, &scene.bearings[0]).unwrap()
    }

    /// Returns the azimuth of the element with the largest load when the ring moves along `direction`, the cage being at
    /// `cage`, all in degrees: in the snapshot, and as the bins of the report.
    fn loaded_azimuths(bearing: &MountedBearing, direction: f64, cage: f64) -> [f64; 2] {
        let (v, u) = direction.to_radians().sin_cos();
        let displacement = Displacement { u: 1e-5 * u, v: 1e-5 * v, ..Displacement::default() };
        let at = BearingKinematicState::from(Phase::from_radians(cage.to_radians()));
        let loads = element_loads(bearing, &displacement, &at);
        let (azimuth, _) = loads.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let mut forces = BearingForces::new(bearing.elements, true);
        let displacements =
            Displacements { measured: displacement, twin: Displacement::default(), observer: None, straightened: None };
        let force = forces.evaluate(bearing, &displacements, true, &at);
        forces.add(bearing, &force, at.cage);
        let load = |bin: &usize| forces.around[*bin].mean();
        let bin = (0..AZIMUTH_BINS).max_by(|a, b| load(a).total_cmp(&load(b))).unwrap();
        [azimuth.rem_euclid(TAU).to_degrees(), (bin as f64 + 0.5) * 360.0 / AZIMUTH_BINS as f64]
    }

    /// The element that lies in the direction of the displacement carries the load, and the load is shown at its azimuth.
    #[test]
    fn loads_are_shown_at_the_azimuths_of_the_scene() {
        for (cage, direction) in [(0.0, 90.0), (5.0, 95.0), (0.0, 200.0), (30.0, 230.0)] {
            let [azimuth, bin] = loaded_azimuths(&bearing(""), direction, cage);
            assert!((azimuth - direction).abs() < 1e-9, "{azimuth} deg instead of {direction} deg");
            assert!((bin - direction).abs() <= 5.0, "{bin} deg instead of {direction} deg");
        }
    }

    /// A cage run-out displaces the elements, `-offset/radius sin(azimuth - angle)`.
    #[test]
    fn loads_are_shown_at_azimuths_with_cage_runout() {
        let runout = "cage_runout = { offset = \"1 mm\", angle = \"0 deg\", radius = \"20 mm\" }";
        let expected = 90.0 - 0.05_f64.to_degrees();
        let [azimuth, bin] = loaded_azimuths(&bearing(runout), expected, 0.0);
        assert!((azimuth - expected).abs() < 1e-9, "{azimuth} deg instead of {expected} deg");
        assert!((bin - expected).abs() <= 5.0, "{bin} deg instead of {expected} deg");
    }
}
