//! Plausibility: whether the recording can be one of the scene's machine, and whether enough is measured for a verdict.

use super::force::BearingForces;
use super::range::ReadingRange;
use crate::outcome::ProbeOutcome;
use crate::plant::MountedBearing;
use crate::recording::status::SampleStatus;
use crate::scene::{RotationSource, Speed};
use std::f64::consts::TAU;

/// Speeds within this factor of the scene's are plausible.
const SPEED_FACTOR: f64 = 1.5;
/// Least share of samples with a plausible speed.
const LEAST_AT_SPEED: f64 = 0.1;
/// Largest share of a probe's readings out of range.
const MOST_OUT_OF_RANGE: f64 = 0.5;
/// Readings smaller than this multiple of the twin's at every probe have another unit.
const TOO_SMALL: f64 = 0.01;
/// Largest share of samples without load on any element of a bearing that is loaded in the twin.
const MOST_UNLOADED: f64 = 1.0 / 3.0;
/// Largest share of samples that lack a quantity needed for the verdict.
const MOST_NOT_MEASURED: f64 = 0.1;

const UM: f64 = 1e6;

/// Counts of samples over a recording.
#[derive(Default)]
pub struct Counts {
    samples: u64,
    at_speed: u64,
    angle_not_measured: u64,
    out_of_range: u64,
    twin_held: u64,
    twin_is_held: bool,
}

impl Counts {
    /// Adds a sample at this shaft speed, rad/s.
    pub fn add(&mut self, status: SampleStatus, speed: f64, scene: Speed) {
        let measured = !status.has(SampleStatus::ANGLE_NOT_MEASURED);
        let plausible = is_in_range(speed, scene);
        self.samples += 1;
        self.at_speed += u64::from(measured && plausible);
        self.angle_not_measured += u64::from(!measured);
        self.out_of_range += u64::from(status.has(SampleStatus::READING_OUT_OF_RANGE));
        self.twin_is_held = status.has(SampleStatus::TWIN_HELD);
        self.twin_held += u64::from(self.twin_is_held);
    }

    /// Adds a sample without a shaft angle.
    pub const fn add_without_angle(&mut self) {
        self.samples += 1;
        self.angle_not_measured += 1;
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
            if self.share(count) > MOST_NOT_MEASURED {
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

/// Returns true where a speed is within a factor of [`SPEED_FACTOR`] of the scene's. Magnitudes only, because a keyphasor gives no sign.
fn is_in_range(speed: f64, scene: Speed) -> bool {
    let (a, b) = scene.range();
    let (slow, fast) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
    (slow / SPEED_FACTOR..=fast * SPEED_FACTOR).contains(&speed.abs())
}

/// Returns true where a measured speed can be one of the scene's shaft, rad/s.
#[must_use]
pub fn is_near(speed: f64, scene: Speed) -> bool {
    scene.range() == (0.0, 0.0) || is_in_range(speed, scene)
}

/// Returns the reason why a mean speed is not one of the scene's shaft, rad/s.
#[must_use]
pub fn wrong_speed(mean_speed: f64, scene: Speed) -> String {
    let (low, high) = scene.range();
    let rpm = |w: f64| w * 60.0 / TAU;
    let scene =
        if low == high { format!("{:.0} rpm", rpm(low)) } else { format!("{:.0} to {:.0} rpm", rpm(low), rpm(high)) };
    format!(
        "mean shaft speed {:.0} rpm, the scene's is {scene}; expected within a factor of {SPEED_FACTOR} (check pulses_per_turn, the unit of the speed and [shaft] speed)",
        rpm(mean_speed)
    )
}

/// Data compared with the scene.
pub struct Evidence<'a> {
    /// Counts over the recording.
    pub counts: &'a Counts,
    /// Source of the shaft angle.
    pub rotation: &'a RotationSource,
    /// The scene's shaft speed.
    pub scene_speed: Speed,
    /// Mean measured speed, rad/s.
    pub mean_speed: f64,
    /// Ranges of the probes.
    pub range: &'a ReadingRange,
    /// Figures of the probes.
    pub probes: &'a [ProbeOutcome],
    /// Forces of the bearings.
    pub bearings: &'a [BearingForces],
    /// The same bearings.
    pub mounted: &'a [MountedBearing],
}

/// Returns the reasons why the recording cannot be one of the scene's machine; empty where it can.
#[must_use]
pub fn implausible(of: &Evidence) -> Vec<String> {
    let unloaded = of.bearings.iter().zip(of.mounted).filter_map(unloaded);
    speed(of).into_iter().chain(size(of)).chain(unloaded).collect()
}

fn speed(of: &Evidence) -> Option<String> {
    let (low, high) = of.scene_speed.range();
    let measured = !matches!(of.rotation, RotationSource::Scene);
    let counts = of.counts;
    let judged = counts.samples - counts.angle_not_measured;
    let at_speed = counts.at_speed as f64 / judged.max(1) as f64;
    if !measured || (low == 0.0 && high == 0.0) || judged == 0 || at_speed >= LEAST_AT_SPEED {
        return None;
    }
    Some(wrong_speed(of.mean_speed, of.scene_speed))
}

fn size(of: &Evidence) -> Option<String> {
    if let Some((column, share, largest)) = of.range.mostly_outside(MOST_OUT_OF_RANGE).next() {
        return Some(format!(
            "{column}: {:.0} % of the readings are farther from zero than {:.0} um, which the bearings allow (check unit and offset)",
            100.0 * share,
            largest * UM
        ));
    }
    let total = |m: &crate::outcome::Motion| m.mean_um.hypot(m.rms_um);
    let small = |p: &&ProbeOutcome| total(&p.measured) < TOO_SMALL * total(&p.twin);
    let radial = || of.probes.iter().filter(|p| p.angle_deg.is_some());
    let first = radial().next()?;
    radial().all(|p| small(&p)).then(|| {
        format!(
            "{}: the readings are {:.1e} um in size where the scene's motion is {:.1e} um, and likewise at every radial probe (check the unit)",
            first.name,
            total(&first.measured),
            total(&first.twin)
        )
    })
}

fn unloaded((sums, bearing): (&BearingForces, &MountedBearing)) -> Option<String> {
    let [measured, twin] = sums.unloaded_shares();
    (measured > MOST_UNLOADED && twin < 0.5 * measured).then(|| {
        format!(
            "bearing {}: no element carries load in {:.0} % of the samples, in the scene's motion in {:.0} % (check unit, offset and clearance)",
            bearing.name,
            100.0 * measured,
            100.0 * twin
        )
    })
}
