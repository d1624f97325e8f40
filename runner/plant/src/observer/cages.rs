//! Angle and speed of the cages as states of the observer.
//!
//! The angle of a cage is `c = c_0 + r turns + offset`, with `c_0` and `r` of the scene; `offset` and the deviation of the speed are
//! states `x = (offset, deviation)` of each bearing, a random walk of the speed. They are estimated by a Kalman filter from the
//! innovations `e` of the observer, whitened by `W`: with the slope `s = W de/d(offset)` the measurement of each sample is
//! `W e = -s (true offset - offset) + noise of variance 1`. The slope is the difference of two observers whose cages differ by
//! [`DISPLACEMENT`]: it contains the whole dynamics of rotor and observer (recursive prediction error method, Ljung and
//! Soderstrom 1983, chapter 3).
//!
//! The innovations are processed one after the other: no matrix is inverted, and the cost is fixed.

use crate::{MAX_BEARINGS, Plant};
use ballrace_scene::Bearing;
use std::f64::consts::TAU;

/// Difference of the cage angle between the two observers, revolutions.
pub(crate) const DISPLACEMENT: f64 = 1e-6;
/// Random walk of the slip, per root second: it changes by 1 %, the spread of slips in practice, within a quarter of an hour.
const SLIP_WALK: f64 = 3e-4;
/// Time constant of the slip that is reported, s.
const REPORTED: f64 = 2.0;
/// Standard deviation of a cage that a diagnosis has found: angle in pitches, slip.
const FOUND: [f64; 2] = [0.03, 2e-4];
/// Standard deviation of the angle, in pitches, above which a cage is not followed: the innovations are linear in the angle within
/// a small part of a pitch only.
const LOST: f64 = 0.1;
/// Difference from a diagnosis, in pitches, at and beyond which the tracker takes the position of the diagnosis.
const FAR: f64 = 0.15;

/// Position and speed of one cage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CagePosition {
    /// Angle, revolutions, up to whole pitches.
    pub revolutions: f64,
    /// Cage speed over shaft speed.
    pub ratio: f64,
}

/// Innovations of one sample and their changes by the angle of each cage.
#[derive(Debug, Clone, Default)]
pub struct CageEvidence {
    /// Whitened innovations.
    pub white: Vec<f64>,
    /// Change of each whitened innovation per revolution of each cage; empty for one that is not followed.
    pub slopes: Vec<Vec<f64>>,
}

/// State of one cage.
#[derive(Debug, Clone)]
struct TrackedCage {
    elements: f64,
    /// Cage speed over shaft speed by the scene.
    ratio: f64,
    /// Cage speed over shaft speed in pure rolling.
    rolling: f64,
    /// Cage speed over shaft speed beyond that of the scene.
    deviation: f64,
    /// Mean slip of the last seconds, and its lowest and highest value while the cage was followed.
    mean_slip: f64,
    slips: Option<[f64; 2]>,
}

impl TrackedCage {
    fn slip(&self) -> f64 {
        1.0 - (self.ratio + self.deviation) / self.rolling
    }
}

/// Tracks the cages of a machine.
#[derive(Debug, Clone)]
pub struct CageTracker {
    cages: Vec<TrackedCage>,
    /// Angle of each cage beyond that of the scene, revolutions.
    offsets: Vec<f64>,
    /// True for each cage that is followed: its angle is known.
    followed: Vec<bool>,
    /// Covariance of offset and deviation of every cage, row by row.
    covariance: Vec<f64>,
    /// Number of losses of the shaft angle.
    interruptions: u64,
}

impl CageTracker {
    /// Creates a tracker that follows no cage yet.
    #[must_use]
    pub fn new(plant: &Plant) -> Self {
        let cage = |of: &crate::MountedBearing| TrackedCage {
            elements: of.elements as f64,
            ratio: of.kinematics.cage_ratio,
            rolling: of.kinematics.rolling_cage_ratio,
            deviation: 0.0,
            mean_slip: 0.0,
            slips: None,
        };
        let n = plant.bearings.len();
        Self {
            cages: plant.bearings.iter().map(cage).collect(),
            covariance: vec![0.0; 4 * n * n],
            offsets: vec![0.0; n],
            followed: vec![false; n],
            interruptions: 0,
        }
    }

    /// Returns true if the cage of a bearing can be followed: if the bearing has no spall in the scene.
    ///
    /// The force of a spall changes within a part of a degree of the cage: the innovations are not linear in the cage angle.
    #[must_use]
    pub fn can_follow(bearing: &Bearing) -> bool {
        bearing.defect.is_empty()
    }

    /// Returns the number of losses of the shaft angle; a position from before the last loss is invalid.
    #[must_use]
    pub const fn interruptions(&self) -> u64 {
        self.interruptions
    }

    /// Returns which cages are followed.
    #[must_use]
    pub fn followed(&self) -> &[bool] {
        &self.followed
    }

    /// Returns lowest and highest slip of each cage while it was followed; `None` for a cage that was never followed.
    #[must_use]
    pub fn slips(&self) -> Vec<Option<[f64; 2]>> {
        self.cages.iter().map(|cage| cage.slips).collect()
    }

    /// Returns the angle of every cage beyond that of the scene, revolutions.
    #[must_use]
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    /// Returns the position of every cage at `turns`, the total revolutions of the shaft.
    #[must_use]
    pub fn positions(&self, turns: f64) -> Vec<CagePosition> {
        let position = |(cage, offset): (&TrackedCage, &f64)| CagePosition {
            revolutions: cage.ratio * turns + offset,
            ratio: cage.ratio + cage.deviation,
        };
        self.cages.iter().zip(&self.offsets).map(position).collect()
    }

    /// Follows a cage that has the position of the scene.
    pub fn follow(&mut self, b: usize) {
        if let Some(cage) = self.cages.get_mut(b) {
            self.followed[b] = true;
            cage.mean_slip = cage.slip();
            cage.slips = Some([cage.mean_slip; 2]);
            self.forget(b);
        }
    }

    /// Takes over the position `found` of cage `b` from a diagnosis at the total revolutions `then`; the shaft is at `now`.
    ///
    /// `before` is the position of the tracker at `then`. A cage that is followed keeps its own position if the two are near.
    pub fn take(&mut self, b: usize, found: &CagePosition, before: &CagePosition, [then, now]: [f64; 2]) {
        let Some(cage) = self.cages.get_mut(b) else { return };
        // Within half a pitch: the elements are alike.
        let elements = cage.elements;
        let nearest = |revolutions: f64| revolutions - (revolutions * elements).round() / elements;
        if self.followed[b] && nearest(found.revolutions - before.revolutions).abs() * elements < FAR {
            return;
        }
        let offset = found.revolutions + found.ratio * (now - then) - cage.ratio * now;
        self.offsets[b] += nearest(offset - self.offsets[b]);
        cage.deviation = found.ratio - cage.ratio;
        self.followed[b] = true;
        cage.mean_slip = cage.slip();
        cage.slips.get_or_insert([cage.mean_slip; 2]);
        self.forget(b);
    }

    /// Sets the uncertainty of a cage to that of one just found.
    fn forget(&mut self, b: usize) {
        let (n, cage) = (2 * self.cages.len(), &self.cages[b]);
        let deviations = [FOUND[0] / cage.elements, FOUND[1] * cage.rolling];
        for (i, deviation) in [2 * b, 2 * b + 1].into_iter().zip(deviations) {
            for j in 0..n {
                (self.covariance[i * n + j], self.covariance[j * n + i]) = (0.0, 0.0);
            }
            self.covariance[i * n + i] = deviation * deviation;
        }
    }

    /// Stops following every cage after an interruption of the shaft angle.
    pub fn interrupt(&mut self) {
        self.interruptions += 1;
        self.followed.fill(false);
    }

    /// Advances by `turns` revolutions of the shaft in `time`, s.
    pub fn advance(&mut self, turns: f64, time: f64) {
        let n = 2 * self.cages.len();
        for (b, cage) in self.cages.iter_mut().enumerate() {
            self.offsets[b] += cage.deviation * turns;
            if !self.followed[b] {
                continue;
            }
            // P <- F P F^T + Q with F = [1 turns; 0 1] for this cage.
            let (offset, deviation) = (2 * b, 2 * b + 1);
            for j in 0..n {
                self.covariance[offset * n + j] += turns * self.covariance[deviation * n + j];
            }
            for i in 0..n {
                self.covariance[i * n + offset] += turns * self.covariance[i * n + deviation];
            }
            self.covariance[deviation * n + deviation] += (SLIP_WALK * cage.rolling).powi(2) * time;
            let pitches = self.covariance[offset * n + offset].max(0.0).sqrt() * cage.elements;
            self.followed[b] = pitches < LOST;
            cage.mean_slip += (cage.slip() - cage.mean_slip) * (time / REPORTED).min(1.0);
            let [low, high] = cage.slips.get_or_insert([cage.mean_slip; 2]);
            (*low, *high) = (low.min(cage.mean_slip), high.max(cage.mean_slip));
        }
    }

    /// Corrects by the innovations of a sample, which have `variance` instead of 1.
    pub fn correct(&mut self, evidence: &CageEvidence, variance: f64) {
        let n = 2 * self.cages.len();
        let slope_of = |b: usize, i: usize| evidence.slopes.get(b).and_then(|s| s.get(i)).copied().unwrap_or(0.0);
        let (mut moved, mut gain) = ([0.0; 2 * MAX_BEARINGS], [0.0; 2 * MAX_BEARINGS]);
        for (i, white) in evidence.white.iter().enumerate() {
            // P h, with h = -slope at each offset.
            for (row, gain) in gain.iter_mut().enumerate().take(n) {
                *gain = (0..self.cages.len()).map(|b| -slope_of(b, i) * self.covariance[row * n + 2 * b]).sum();
            }
            let along: f64 = (0..self.cages.len()).map(|b| -slope_of(b, i) * gain[2 * b]).sum();
            let expected: f64 = (0..self.cages.len()).map(|b| -slope_of(b, i) * moved[2 * b]).sum();
            let scale = 1.0 / (along + variance);
            let error = white - expected;
            if !(scale * error).is_finite() {
                continue;
            }
            for (row, (moved, of_row)) in moved.iter_mut().zip(&gain).enumerate().take(n) {
                *moved += of_row * scale * error;
                for (column, of_column) in gain.iter().enumerate().take(n) {
                    self.covariance[row * n + column] -= of_row * of_column * scale;
                }
            }
        }
        for (b, cage) in self.cages.iter_mut().enumerate().filter(|(b, _)| self.followed[*b]) {
            self.offsets[b] += moved[2 * b];
            cage.deviation += moved[2 * b + 1];
        }
    }
}

/// Returns the position at `turns` of a cage with the azimuth `azimuth` of its first element at shaft angle 0; the scene has `of_scene`
/// (both rad).
#[must_use]
pub fn found_position(ratio: f64, azimuth: f64, of_scene: f64, turns: f64) -> CagePosition {
    CagePosition { revolutions: (azimuth - of_scene) / TAU + ratio * turns, ratio }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    /// Revolutions of the shaft and time of a sample, s.
    const TURNS: f64 = 0.05;
    const PERIOD: f64 = 1e-3;

    fn tracker() -> CageTracker {
        let scene = read_str(include_str!("../../../demo/healthy.toml"), Path::new("scene.toml")).unwrap();
        CageTracker::new(&Plant::try_new(&scene).unwrap())
    }

    /// Follows the first cage, whose slip grows by 0.01 % per second, for 20 s; `slope` is the amplitude of the change of one whitened
    /// innovation per revolution of it. Returns the error of its angle in pitches.
    fn followed(tracker: &mut CageTracker, slope: f64) -> f64 {
        tracker.follow(0);
        let rolling = tracker.cages[0].rolling;
        let mut noise = fastrand::Rng::with_seed(3);
        let (mut truth, mut slip) = (0.0, 0.0);
        for i in 0..20_000 {
            slip += 1e-4 * PERIOD;
            truth -= slip * rolling * TURNS;
            tracker.advance(TURNS, PERIOD);
            let s = slope * (0.7 * f64::from(i)).cos();
            // Uniform noise of variance 1.
            let white = -s * (truth - tracker.offsets()[0]) + 12.0_f64.sqrt() * (noise.f64() - 0.5);
            tracker.correct(&CageEvidence { white: vec![white], slopes: vec![vec![s], vec![]] }, 1.0);
        }
        (truth - tracker.offsets()[0]) * tracker.cages[0].elements
    }

    #[test]
    fn a_drifting_cage_is_followed() {
        let mut tracker = tracker();
        let error = followed(&mut tracker, 500.0);
        assert!(error.abs() < 0.05, "{error}");
        assert_eq!(tracker.followed(), [true, false]);
        let [low, high] = tracker.slips()[0].unwrap();
        assert!(low.abs() < 5e-4 && (high - 2e-3).abs() < 5e-4, "{low} {high}");
        assert_eq!((tracker.slips()[1], tracker.offsets()[1]), (None, 0.0));
    }

    #[test]
    fn a_cage_that_shows_too_little_is_lost() {
        let mut tracker = tracker();
        followed(&mut tracker, 0.01);
        assert_eq!(tracker.followed(), [false, false]);
    }

    /// A diagnosis of samples up to revolution 100 is taken at revolution 160, and kept where the cage is near.
    #[test]
    fn a_found_cage_is_taken_over() {
        let mut tracker = tracker();
        let pitch = 1.0 / tracker.cages[0].elements;
        let before = tracker.positions(100.0)[0];
        let found = CagePosition { revolutions: before.revolutions + 7.3 * pitch, ratio: before.ratio - 1e-4 };
        tracker.take(0, &found, &before, [100.0, 160.0]);
        let expected = 0.3 * pitch - 1e-4 * 60.0;
        assert!((tracker.offsets()[0] - expected).abs() < 1e-9, "{}", tracker.offsets()[0]);
        assert!((tracker.positions(160.0)[0].ratio - found.ratio).abs() < 1e-12);
        let before = tracker.positions(160.0)[0];
        let near = CagePosition { revolutions: before.revolutions - 2.1 * pitch, ..before };
        tracker.take(0, &near, &before, [160.0, 160.0]);
        assert!((tracker.offsets()[0] - expected).abs() < 1e-9);
        tracker.interrupt();
        assert_eq!((tracker.followed(), tracker.interruptions()), (&[false, false][..], 1));
    }
}
