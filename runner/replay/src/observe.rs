//! Observer stage: the Kalman filter follows the readings, and its innovations are summed.

use super::locate::LocationStage;
use super::notices::Notices;
use super::statistics::Running;
use super::twin::{SampleInterval, TwinStage, TwinStart};
use ballrace::Status;
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_outcome::ObserverOutcome;
use ballrace_plant::error::Result;
use ballrace_plant::observer::{
    CageTracker, Consistency, ConsistencyState, InitialState, RunningObserver, TunedObserver, estimator,
};
use ballrace_plant::probes::reading;
use ballrace_plant::{AXIAL, Plant};
use ballrace_recording::Sample;
use ballrace_recording::status::SampleStatus;

/// Two-sided 99 % quantile of the normal distribution.
const QUANTILE_99: f64 = 2.576;
const UM: f64 = 1e6;

/// Observer of a replay, where it has one.
pub(super) struct ObserverStage {
    /// Reading of each probe per unit of each coordinate.
    rows: Vec<Vec<f64>>,
    tuned: Option<TunedObserver>,
    running: Option<RunningObserver>,
    innovations: Innovations,
    distrust: DistrustedShare,
    /// The unknown load acts on the centre of mass of a rotor; on the coordinates of a given system it has no resultant.
    has_resultant: bool,
}

/// Result of the observer at one sample.
pub(super) struct ObserverSample {
    pub(super) status: SampleStatus,
    /// Normalised innovation squared; none where a reading is missing.
    pub(super) nis: Option<f64>,
}

impl ObserverStage {
    pub(super) fn new(rows: Vec<Vec<f64>>, has_resultant: bool) -> Self {
        let distrust = DistrustedShare::default();
        Self { rows, tuned: None, running: None, innovations: Innovations::default(), distrust, has_resultant }
    }

    /// Sets the observer that the search found.
    pub(super) fn set_tuned(&mut self, tuned: Option<TunedObserver>) {
        self.tuned = tuned;
    }

    /// Starts the observer at `sample`: at the identified state at first, later at the state of the twin.
    pub(super) fn start(
        &mut self,
        plant: &Plant,
        twin: &TwinStage,
        start: TwinStart,
        sample: &Sample,
        period: f64,
        cages: &CageTracker,
    ) -> Result<()> {
        let Some(tuned) = &self.tuned else { return Ok(()) };
        let probes = self.rows.len();
        let (state, consistency) = match start {
            TwinStart::First => (tuned.start.clone(), Consistency::new(probes, tuned.gate)),
            TwinStart::Restart => {
                (InitialState::new(twin.coordinates(), twin.rates()), Consistency::restarted(probes, tuned.gate))
            }
        };
        let estimator = estimator(plant, &self.rows, &tuned.gains, state, sample, period)?;
        let mut running = RunningObserver::new(estimator, consistency, period);
        running.set_cage_offsets(cages.offsets());
        self.running = Some(running);
        Ok(())
    }

    /// Advances the observer over `interval` to `sample` with `readings`, NaN where missing or out of range. It restarts at the motion of the twin, displaced to the readings.
    pub(super) fn advance(
        &mut self,
        (sample, readings, interval): (&Sample, &[f64], &SampleInterval),
        twin: &TwinStage,
        range: &ReadingRange,
        location: &LocationStage,
        notices: &mut Notices,
        cages: &mut CageTracker,
    ) -> ObserverSample {
        let untrusted = SampleStatus::FROM_DISPLACEMENT;
        let Some(running) = &mut self.running else {
            return ObserverSample { status: untrusted, nis: None };
        };
        let rows = &self.rows;
        let is_possible = |q: &[f64]| {
            let axial = q.get(AXIAL).copied().unwrap_or_default();
            range.allows(rows.iter().map(|row| reading(row, q)), axial)
        };
        let restart_state = || (location.displaced(readings, twin.coordinates()), twin.rates().to_vec());
        let (flags, correction) = running.step(interval.motion(), readings, is_possible, restart_state, cages);
        let mut status = SampleStatus::from(flags);
        if let Some(correction) = correction {
            self.innovations.add(correction.nis, correction.status, correction.verdict);
            status = status.and(SampleStatus::RESTARTED.when(correction.verdict == ConsistencyState::Restart));
            if self.distrust.add(correction.verdict != ConsistencyState::Trusted) {
                let (ratio, restarts) = (correction.ratio, self.innovations.restarts);
                notices.add("observer-not-consistent", sample.row.time, || {
                    format!("The observer does not describe the motion: normalised innovation squared {ratio:.1} times what is expected, {restarts} restarts so far. Forces come from the displacement.")
                });
            }
        }
        if let Some(load) = running.load().filter(|_| self.has_resultant) {
            self.innovations.add_load(load);
        }
        status = status.and(untrusted.when(running.coordinates().is_none()));
        ObserverSample { status, nis: correction.map(|c| c.nis) }
    }

    /// Returns true where the scene has an observer.
    pub(super) const fn is_tuned(&self) -> bool {
        self.tuned.is_some()
    }

    /// Returns the estimated coordinates and their rates, also where the observer is not trusted; none before it starts.
    pub(super) fn state(&self) -> Option<(&[f64], &[f64])> {
        self.running.as_ref().map(RunningObserver::state)
    }

    /// Returns the estimated coordinates; none where the observer is not trusted.
    pub(super) fn coordinates(&self) -> Option<&[f64]> {
        self.running.as_ref().and_then(RunningObserver::coordinates)
    }

    /// Returns the outcome; none without an observer or without a sample in which every probe had a reading.
    pub(super) fn outcome(&self) -> Option<ObserverOutcome> {
        self.tuned.as_ref().and_then(|tuned| self.innovations.outcome(tuned))
    }
}

/// Share of the last samples in which the observer was not trusted.
///
/// A spall or a jolt that is not in the scene makes the observer restart now and then: it is trusted again within some hundred samples, which
/// their flags and the counts of the outcome show. An event is due where forces come from the displacement for long, or again and again.
#[derive(Debug, Default)]
struct DistrustedShare {
    /// Exponential mean.
    share: f64,
    is_reported: bool,
}

impl DistrustedShare {
    /// Time constant of the mean, samples: 16 times the settling time of an observer after a restart.
    const WINDOW: f64 = 4096.0;
    /// Share that is reported: two restarts in a row, or 550 samples without trust.
    const REPORTED: f64 = 0.125;

    /// Adds a sample; returns true where the share becomes so large that it is reported. It is reported again once it has halved.
    fn add(&mut self, is_distrusted: bool) -> bool {
        self.share += (f64::from(u8::from(is_distrusted)) - self.share) / Self::WINDOW;
        let is_new = !self.is_reported && self.share > Self::REPORTED;
        self.is_reported = is_new || self.is_reported && self.share > 0.5 * Self::REPORTED;
        is_new
    }
}

/// Sums over the samples in which every probe had a reading.
#[derive(Default)]
struct Innovations {
    squares: Running,
    load: [Running; 5],
    rejected: u64,
    restarts: u64,
    distrusted: u64,
}

impl Innovations {
    fn add(&mut self, nis: f64, status: Status, verdict: ConsistencyState) {
        self.rejected += u64::from(status.contains(Status::INNOVATION_REJECTED));
        self.restarts += u64::from(verdict == ConsistencyState::Restart);
        self.distrusted += u64::from(verdict != ConsistencyState::Trusted);
        self.squares.add(nis);
    }

    fn add_load(&mut self, load: [f64; 5]) {
        for (running, entry) in self.load.iter_mut().zip(load) {
            running.add(entry);
        }
    }

    /// Returns the outcome. Over `n` samples the mean of the squares, chi-square distributed with `p` degrees of freedom, has
    /// the variance `2 p/n`.
    fn outcome(&self, tuned: &TunedObserver) -> Option<ObserverOutcome> {
        if self.squares.count() == 0.0 {
            return None;
        }
        let expected = tuned.noise.len() as f64;
        let band = QUANTILE_99 * (2.0 * expected / self.squares.count().max(1.0)).sqrt();
        let (mean, bounds) = (self.squares.mean(), [expected - band, expected + band]);
        let rms_about_mean = |r: &Running| (r.rms().powi(2) - r.mean().powi(2)).max(0.0).sqrt();
        let known = |r: &Running, x: f64| if r.count() > 0.0 { x } else { f64::NAN };
        Some(ObserverOutcome {
            nis_mean: mean,
            nis_expected: expected,
            nis_bounds: bounds,
            consistent: (bounds[0]..=bounds[1]).contains(&mean) && self.distrusted == 0,
            gate: tuned.gate,
            rejected_samples: self.rejected,
            restarts: self.restarts,
            distrusted_samples: self.distrusted,
            process_noise_n_per_root_s: tuned.process_noise,
            noise_um: tuned.noise.iter().map(|n| n * UM).collect(),
            unknown_load_mean: self.load.each_ref().map(|r| known(r, r.mean())),
            unknown_load_rms: self.load.each_ref().map(|r| known(r, rms_about_mean(r))),
        })
    }
}

/// Returns the outcome of the observer as a sentence.
pub(super) fn sentence(observer: &ObserverOutcome) -> String {
    let judged = if observer.consistent {
        "the measured motion departs from its prediction as far as the noise of the probes explains"
    } else if observer.nis_mean < observer.nis_expected {
        "the measured motion departs less from its prediction than the noise of the probes explains, so the noise is less than assumed"
    } else {
        "the measured motion departs further from its prediction than the noise of the probes explains"
    };
    let [x, y, z, ..] = observer.unknown_load_rms;
    let distrusted = match (observer.rejected_samples, observer.restarts, observer.distrusted_samples) {
        (0, 0, 0) => String::new(),
        (rejected, restarts, samples) => format!(
            " {rejected} samples were rejected (normalised innovation squared above {:.0}); restarts of the observer: {restarts}; for {samples} samples the force is computed from the measured displacement instead.",
            observer.gate
        ),
    };
    let force = (x * x + y * y + z * z).sqrt();
    let unknown = if force.is_nan() {
        String::new()
    } else {
        format!("; the force on the rotor that the scene does not have is {force:.2} N rms about its mean")
    };
    format!(
        "Observer: {judged} (mean normalised square of the departure {:.2}, expected {:.0}, 99 % range {:.2} to {:.2}){unknown}.{distrusted} --forces writes the estimated forces.",
        observer.nis_mean, observer.nis_expected, observer.nis_bounds[0], observer.nis_bounds[1],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_restart_is_not_reported_and_lasting_distrust_is() {
        let reports = |is_distrusted: &dyn Fn(u32) -> bool| {
            let mut share = DistrustedShare::default();
            (0..100_000).filter(|i| share.add(is_distrusted(*i))).collect::<Vec<u32>>()
        };
        // The settling time after a restart is 256 samples.
        assert!(reports(&|i| i % 20_000 < 256).is_empty());
        let lasting = reports(&|i| i >= 10_000);
        assert!(lasting.len() == 1 && (10_400..10_700).contains(&lasting[0]), "{lasting:?}");
        let repeated = reports(&|i| i >= 10_000 && i % 1000 < 256);
        assert!(repeated.len() == 1 && repeated[0] < 14_000, "{repeated:?}");
        // Each of two long times is reported.
        assert_eq!(reports(&|i| i % 50_000 < 2000).len(), 2);
    }
}
