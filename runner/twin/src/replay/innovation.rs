//! Whether the observer's innovations are what its noise and model say.

use super::outcome::ObserverOutcome;
use super::statistics::Running;
use crate::observer::{TunedObserver, Verdict, gate};
use ballrace::Status;

/// Standard deviations of a mean that chance leaves in 1 case of 100.
const BAND: f64 = 2.576;
const UM: f64 = 1e6;

/// Sums over the samples in which every probe had a reading.
#[derive(Default)]
pub struct Innovation {
    squares: Running,
    load: [Running; 5],
    rejected: u64,
    restarts: u64,
    distrusted: u64,
}

impl Innovation {
    /// One sample: the normalised square, bounded, with its status, and the verdict on the observer.
    pub fn add(&mut self, nis: f64, status: Status, verdict: Verdict) {
        self.rejected += u64::from(status.contains(Status::INNOVATION_REJECTED));
        self.restarts += u64::from(verdict == Verdict::Restart);
        self.distrusted += u64::from(verdict != Verdict::Trusted);
        self.squares.add(nis);
    }

    /// The unknown load of an observer that is trusted.
    pub fn add_load(&mut self, load: [f64; 5]) {
        for (running, entry) in self.load.iter_mut().zip(load) {
            running.add(entry);
        }
    }

    /// Restarts so far.
    #[must_use]
    pub const fn restarts(&self) -> u64 {
        self.restarts
    }

    /// The figures; none without a sample in which every probe had a reading. Over n samples the mean of the squares, chi-square distributed with p degrees of freedom, has the
    /// variance `2 p/n`.
    #[must_use]
    pub fn outcome(&self, of: &TunedObserver) -> Option<ObserverOutcome> {
        if self.squares.count() == 0.0 {
            return None;
        }
        let expected = of.noise.len() as f64;
        let band = BAND * (2.0 * expected / self.squares.count().max(1.0)).sqrt();
        let (mean, bounds) = (self.squares.mean(), [expected - band, expected + band]);
        let about = |r: &Running| (r.rms().powi(2) - r.mean().powi(2)).max(0.0).sqrt();
        Some(ObserverOutcome {
            nis_mean: mean,
            nis_expected: expected,
            nis_bounds: bounds,
            consistent: (bounds[0]..=bounds[1]).contains(&mean) && self.distrusted == 0,
            gate: gate(of.noise.len()),
            rejected_samples: self.rejected,
            restarts: self.restarts,
            distrusted_samples: self.distrusted,
            wander_n_per_root_s: of.wander,
            noise_um: of.noise.iter().map(|n| n * UM).collect(),
            unknown_load_mean: self.load.each_ref().map(Running::mean),
            unknown_load_rms: self.load.each_ref().map(about),
        })
    }
}

/// The same for people.
#[must_use]
pub fn words(of: &ObserverOutcome) -> String {
    let judged = if of.consistent {
        "consistent with model and noise"
    } else if of.nis_mean < of.nis_expected {
        "smaller than model and noise predict: the noise is less than assumed"
    } else {
        "larger than model and noise predict: there is motion that neither explains"
    };
    let [x, y, z, ..] = of.unknown_load_rms;
    let distrusted = match (of.rejected_samples, of.restarts, of.distrusted_samples) {
        (0, 0, 0) => String::new(),
        (rejected, restarts, samples) => format!(
            " Samples beyond the gate of {:.0}: {rejected}, which corrected nothing; restarts of the observer: {restarts}; samples in which the force comes from the displacement instead: {samples}.",
            of.gate
        ),
    };
    format!(
        "Observer: the innovations are {judged} (mean normalised square {:.2}, expected {:.0}, 99 % range {:.2} to {:.2}); the unknown force on the rotor is {:.2} N rms about its mean.{distrusted} --forces writes the estimated forces.",
        of.nis_mean,
        of.nis_expected,
        of.nis_bounds[0],
        of.nis_bounds[1],
        (x * x + y * y + z * z).sqrt()
    )
}
