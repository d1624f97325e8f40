//! Whether the readings can be those of the twin's machine, and whether enough is measured for a verdict.

use super::force::BearingForces;
use ballrace_outcome::{Implausibility, Motion, ProbeOutcome};
use ballrace_plant::MountedBearing;
use ballrace_recording::status::SampleStatus;

/// Readings smaller than this multiple of the twin's at every probe have another unit.
const TOO_SMALL: f64 = 0.01;
/// Largest share of samples without load on any element of a bearing that is loaded in the twin.
const MAX_UNLOADED: f64 = 1.0 / 3.0;
/// Largest share of samples that lack a quantity needed for the verdict.
const MAX_NOT_MEASURED: f64 = 0.1;

/// Counts of samples over a recording.
#[derive(Default)]
pub struct Counts {
    samples: u64,
    angle_not_measured: u64,
    out_of_range: u64,
    twin_held: u64,
    twin_is_held: bool,
}

impl Counts {
    /// Adds a sample.
    pub fn add(&mut self, status: SampleStatus) {
        self.samples += 1;
        self.angle_not_measured += u64::from(status.has(SampleStatus::ANGLE_NOT_MEASURED));
        self.out_of_range += u64::from(status.has(SampleStatus::READING_OUT_OF_RANGE));
        self.twin_is_held = status.has(SampleStatus::TWIN_HELD);
        self.twin_held += u64::from(self.twin_is_held);
    }

    /// Adds a sample without a shaft angle.
    pub(crate) const fn add_without_angle(&mut self) {
        self.samples += 1;
        self.angle_not_measured += 1;
    }

    /// Returns true where the motion of the twin overflowed at the end or in more than a few samples, so that its figures have no meaning.
    #[must_use]
    pub(crate) fn has_overflowed(&self) -> bool {
        self.share(self.twin_held) > MAX_NOT_MEASURED || self.twin_is_held
    }

    /// Returns the reason why there is no motion of the twin to compare with, where it overflowed.
    #[must_use]
    pub fn overflow(&self) -> Option<Implausibility> {
        let share = self.share(self.twin_held);
        (share > MAX_NOT_MEASURED).then(|| Implausibility {
            subject: "twin".to_owned(),
            found: format!("the motion of the twin overflowed and was held in {:.0} % of the samples", 100.0 * share),
            cause: "a step in [integration] that is too long, or a rotor that is not stable".to_owned(),
            remedy: "omit the step, or give the rotor damping and supports".to_owned(),
        })
    }

    fn share(&self, count: u64) -> f64 {
        count as f64 / self.samples.max(1) as f64
    }

    /// Returns the number of samples with a reading out of range.
    #[must_use]
    pub const fn out_of_range(&self) -> u64 {
        self.out_of_range
    }

    /// Returns the reasons why there is no verdict although the recording is plausible; `compared` samples have every reading.
    #[must_use]
    pub fn not_judged(&self, compared: u64) -> Vec<String> {
        let mut reasons = Vec::new();
        let mut beyond = |count: u64, what: &str| {
            if self.share(count) > MAX_NOT_MEASURED {
                reasons.push(format!("{what} in {:.0} % of the samples", 100.0 * self.share(count)));
            }
        };
        beyond(self.angle_not_measured, "the shaft angle is not measured");
        beyond(self.out_of_range, "a reading is out of range");
        beyond(self.twin_held, "the motion of the twin overflowed and was held");
        if reasons.is_empty() && self.twin_is_held {
            reasons.push("the motion of the twin overflowed and is held at the end".to_owned());
        }
        if reasons.is_empty() && compared == 0 {
            reasons.push("no sample has a reading of every probe".to_owned());
        }
        reasons
    }
}

/// Returns the reasons why the readings cannot be of the scene's machine when they are compared with the motion of its twin.
#[must_use]
pub(crate) fn unlike_twin(
    probes: &[ProbeOutcome],
    bearings: &[BearingForces],
    mounted: &[MountedBearing],
) -> Vec<Implausibility> {
    let unloaded = bearings.iter().zip(mounted).filter_map(unloaded);
    too_small(probes).into_iter().chain(unloaded).collect()
}

fn too_small(probes: &[ProbeOutcome]) -> Option<Implausibility> {
    let total = |m: &Motion| m.mean_um.hypot(m.rms_um);
    let small = |p: &&ProbeOutcome| total(&p.measured) < TOO_SMALL * total(&p.twin);
    let radial = || probes.iter().filter(|p| p.angle_deg.is_some());
    let first = radial().next()?;
    radial().all(|p| small(&p)).then(|| Implausibility {
        subject: first.name.clone(),
        found: format!(
            "the readings are {:.1e} um in size where the scene's motion is {:.1e} um, and likewise at every radial probe",
            total(&first.measured),
            total(&first.twin)
        ),
        cause: "another unit or sensitivity".to_owned(),
        remedy: "check the units of the probes".to_owned(),
    })
}

fn unloaded((sums, bearing): (&BearingForces, &MountedBearing)) -> Option<Implausibility> {
    let [measured, twin] = sums.unloaded_shares();
    (measured > MAX_UNLOADED && twin < 0.5 * measured).then(|| Implausibility {
        subject: format!("bearing {}", bearing.name),
        found: format!(
            "no element carries load in {:.0} % of the samples, in the scene's motion in {:.0} %",
            100.0 * measured,
            100.0 * twin
        ),
        cause: "another unit or offset of the probes, another clearance, or damage that lifts the rotor".to_owned(),
        remedy: "check unit and offset of the probes and the clearance of the bearing; with --force it is diagnosed all the same".to_owned(),
    })
}
