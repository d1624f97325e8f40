//! Mode tracking over the shaft speed, and critical speeds.

use super::{AtSpeed, Mode, Whirl};
use serde::Serialize;

/// Orders per revolution whose crossings with a mode are critical speeds.
const ORDERS: [f64; 2] = [1.0, 2.0];
/// Penalty added to the relative change of frequency if forward becomes backward or the reverse.
const OPPOSITE_WHIRL: f64 = 0.5;
/// Penalty added if only one of the two is straight, such as every mode of a symmetric rotor at zero speed.
const OTHER_WHIRL: f64 = 0.05;

/// One mode over the speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeBranch {
    /// Number by frequency at the lowest speed, from 1.
    pub number: usize,
    /// Points in the order of increasing speed.
    pub points: Vec<BranchPoint>,
}

/// A mode at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchPoint {
    /// Shaft speed.
    pub speed_rpm: f64,
    /// Frequency, damping and whirl.
    pub mode: Mode,
}

/// Speed at which a mode crosses an order of the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CriticalSpeed {
    /// Number of the mode, as [`ModeBranch::number`].
    pub mode: usize,
    /// Order per revolution.
    pub order: f64,
    /// Shaft speed.
    pub speed_rpm: f64,
    /// Natural frequency there.
    pub frequency_hz: f64,
    /// Damping over critical damping there.
    pub damping_ratio: f64,
    /// Direction of whirl there.
    pub whirl: Whirl,
}

impl ModeBranch {
    /// Returns the name of the mode, such as "N2".
    #[must_use]
    pub fn name(&self) -> String {
        format!("N{}", self.number)
    }

    /// Returns the frequency (Hz) expected at a speed: that of the line through the last two points.
    fn predicted(&self, speed_rpm: f64) -> f64 {
        match self.points.as_slice() {
            [.., a, b] if b.speed_rpm > a.speed_rpm => {
                let slope = (b.mode.frequency_hz - a.mode.frequency_hz) / (b.speed_rpm - a.speed_rpm);
                b.mode.frequency_hz + slope * (speed_rpm - b.speed_rpm)
            }
            [.., last] => last.mode.frequency_hz,
            [] => f64::NAN,
        }
    }

    /// Returns the mismatch of `mode` as the continuation of this branch: relative change of frequency plus penalty for a change of whirl.
    fn mismatch(&self, speed_rpm: f64, mode: &Mode) -> f64 {
        let expected = self.predicted(speed_rpm);
        let size = expected.abs().max(mode.frequency_hz).max(f64::MIN_POSITIVE);
        let whirl = match (self.points.last().map(|point| point.mode.whirl), mode.whirl) {
            (Some(last), whirl) if last == whirl => 0.0,
            (Some(Whirl::Forward), Whirl::Backward) | (Some(Whirl::Backward), Whirl::Forward) => OPPOSITE_WHIRL,
            _ => OTHER_WHIRL,
        };
        (mode.frequency_hz - expected).abs() / size + whirl
    }
}

/// Connects the modes of all speeds to branches.
///
/// Each mode continues the branch whose whirl and extrapolated frequency are nearest. A mode without a free branch starts a new one.
#[must_use]
pub fn branches(diagram: &[AtSpeed]) -> Vec<ModeBranch> {
    let mut speeds: Vec<&AtSpeed> = diagram.iter().collect();
    speeds.sort_by(|a, b| a.speed_rpm.total_cmp(&b.speed_rpm));
    let mut branches: Vec<ModeBranch> = Vec::new();
    for at in speeds {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, branch) in branches.iter().enumerate() {
            pairs.extend(at.modes.iter().enumerate().map(|(k, mode)| (branch.mismatch(at.speed_rpm, mode), i, k)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut continued, mut taken) = (vec![false; branches.len()], vec![false; at.modes.len()]);
        for (_, i, k) in pairs {
            if !continued[i] && !taken[k] {
                (continued[i], taken[k]) = (true, true);
                branches[i].points.push(BranchPoint { speed_rpm: at.speed_rpm, mode: at.modes[k] });
            }
        }
        for (mode, _) in at.modes.iter().zip(&taken).filter(|(_, taken)| !**taken) {
            let points = vec![BranchPoint { speed_rpm: at.speed_rpm, mode: *mode }];
            branches.push(ModeBranch { number: branches.len() + 1, points });
        }
    }
    branches
}

/// Returns the speeds at which modes cross 1X and 2X, by linear interpolation between the speeds of the diagram, slowest first.
#[must_use]
pub fn critical_speeds(branches: &[ModeBranch]) -> Vec<CriticalSpeed> {
    let mut all: Vec<CriticalSpeed> = Vec::new();
    for branch in branches {
        for order in ORDERS {
            for pair in branch.points.windows(2) {
                all.extend(crossing(branch.number, order, &pair[0], &pair[1]));
            }
        }
    }
    all.sort_by(|a, b| a.speed_rpm.total_cmp(&b.speed_rpm));
    all
}

fn crossing(mode: usize, order: f64, a: &BranchPoint, b: &BranchPoint) -> Option<CriticalSpeed> {
    let above = |point: &BranchPoint| point.mode.frequency_hz - order * point.speed_rpm.abs() / 60.0;
    let (before, after) = (above(a), above(b));
    // A crossing at the end of an interval belongs to the next one.
    if !(before == 0.0 || before * after < 0.0) {
        return None;
    }
    let share = before / (before - after);
    let between = |from: f64, to: f64| from + share * (to - from);
    let nearer = if share < 0.5 { a } else { b };
    Some(CriticalSpeed {
        mode,
        order,
        speed_rpm: between(a.speed_rpm, b.speed_rpm),
        frequency_hz: between(a.mode.frequency_hz, b.mode.frequency_hz),
        damping_ratio: between(a.mode.damping_ratio, b.mode.damping_ratio),
        whirl: nearer.mode.whirl,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A backward mode that falls from 60 Hz, a forward mode that rises from there, and a straight one at 65 Hz that the forward mode
    /// crosses.
    fn crossing_modes() -> Vec<AtSpeed> {
        let at = |i: u32| {
            let speed = 600.0 * f64::from(i);
            let mode = |frequency_hz: f64, whirl| Mode { frequency_hz, damping_ratio: 0.01, whirl };
            let whirl = |whirl| if i == 0 { Whirl::Straight } else { whirl };
            let mut modes = vec![
                mode(60.0 - 0.002 * speed, whirl(Whirl::Backward)),
                mode(60.0 + 0.002 * speed, whirl(Whirl::Forward)),
                mode(65.0, Whirl::Straight),
            ];
            modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
            AtSpeed { speed_rpm: speed, modes, rotor: None }
        };
        (0..=10).map(at).collect()
    }

    #[test]
    fn modes_are_followed_through_a_crossing() {
        let branches = branches(&crossing_modes());
        assert_eq!(branches.len(), 3);
        for branch in &branches {
            assert_eq!(branch.points.len(), 11);
            let whirls: Vec<Whirl> = branch.points[1..].iter().map(|point| point.mode.whirl).collect();
            assert!(whirls.iter().all(|whirl| *whirl == whirls[0]), "{branch:?}");
        }
    }

    #[test]
    fn critical_speeds_are_the_crossings() {
        let critical = critical_speeds(&branches(&crossing_modes()));
        let first: Vec<&CriticalSpeed> = critical.iter().filter(|one| one.order == 1.0).collect();
        // 60 -+ 0.002 n = n / 60, and 65 = n / 60.
        let expected = [60.0 / (1.0 / 60.0 + 0.002), 3900.0, 60.0 / (1.0 / 60.0 - 0.002)];
        assert_eq!(first.len(), 3);
        for (one, expected) in first.iter().zip(expected) {
            assert!((one.speed_rpm - expected).abs() < 1e-6 && (one.frequency_hz - expected / 60.0).abs() < 1e-9);
        }
        assert_eq!(
            first.iter().map(|one| one.whirl).collect::<Vec<_>>(),
            [Whirl::Backward, Whirl::Straight, Whirl::Forward]
        );
    }

    #[test]
    fn a_mode_that_appears_begins_a_branch() {
        let mode = |frequency_hz: f64| Mode { frequency_hz, damping_ratio: 0.0, whirl: Whirl::Straight };
        let diagram = [
            AtSpeed { speed_rpm: 0.0, modes: vec![mode(10.0)], rotor: None },
            AtSpeed { speed_rpm: 60.0, modes: vec![mode(10.1), mode(40.0)], rotor: None },
        ];
        let lengths: Vec<usize> = branches(&diagram).iter().map(|branch| branch.points.len()).collect();
        assert_eq!(lengths, [2, 1]);
        assert!(branches(&[]).is_empty() && critical_speeds(&[]).is_empty());
    }
}
