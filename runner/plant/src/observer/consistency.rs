//! Consistency of an observer with the machine: the gate of one sample and the test over a window of samples.
//!
//! With a true model and true noise the normalised innovation squared is chi-square distributed with `p` degrees of freedom,
//! `p` the number of probes (Bar-Shalom, Li, Kirubarajan 2001, sections 5.4.2 and 5.4.3). Three bounds follow from it:
//!
//! - A sample above the quantile at `1 - 1e-9` corrects nothing ([`gate`]).
//! - [`REJECTED_IN_A_ROW`] consecutive samples of this kind are no outliers: the observer restarts at the measured
//!   displacement.
//! - The mean over a window of some [`WINDOW`] samples stays below [`LARGEST_RATIO`] times `p`. At that bound the error of
//!   the model in the innovations has three times the variance of the noise, so the displacement that the probes show is
//!   closer to the shaft than the observer is: forces then come from the displacement. By chance the mean gets there with a
//!   probability below 1e-100, because its standard deviation is `sqrt(p/WINDOW)`.

/// Largest probability that the gate rejects a sample of a true model.
const FALSE_ALARM: f64 = 1e-9;
/// Number of consecutive rejected samples that restarts the observer.
const REJECTED_IN_A_ROW: u32 = 8;
/// Time constant of the mean of the normalised innovation squared, samples.
const WINDOW: f64 = 128.0;
/// Mean over the number of probes above which forces come from the displacement.
const LARGEST_RATIO: f64 = 4.0;
/// Mean over the number of probes below which the observer is trusted again.
const SETTLED_RATIO: f64 = 2.0;
/// Samples after a restart in which the gate is open and the observer is not trusted.
const SETTLING: u32 = 256;

/// Returns the largest normalised innovation squared that corrects an observer of `probes` probes: the chi-square quantile at
/// `1 - 1e-9`, for an odd number of degrees of freedom that of the next even one.
///
/// Solves `exp(-y) sum_{k < n} y^k/k! = 1e-9` for `y = x/2` with `2 n` degrees of freedom (Abramowitz, Stegun 26.4.5).
#[must_use]
pub fn gate(probes: usize) -> f64 {
    let terms = probes.max(1).div_ceil(2);
    let mut y = -FALSE_ALARM.ln();
    for _ in 0..100 {
        let powers = (1..terms).scan(1.0, |term, k| {
            *term *= y / k as f64;
            Some(*term)
        });
        y = -FALSE_ALARM.ln() + (1.0 + powers.sum::<f64>()).ln();
    }
    2.0 * y
}

/// Returns the gate where the motion does not repeat: an impact enlarges the error of a prediction, which the gains do not have, and a
/// rejected sample lets it grow. An error of the model up to the bound at which forces still come from the observer passes.
#[must_use]
pub fn wide_gate(probes: usize) -> f64 {
    LARGEST_RATIO * gate(probes)
}

/// Result of the consistency test at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConsistencyState {
    /// The observer is consistent with the machine.
    Trusted,
    /// The observer is not consistent: forces come from the displacement.
    Distrusted,
    /// As [`Distrusted`](Self::Distrusted), and the observer has to restart.
    Restart,
}

/// Consistency test of one observer over time.
#[derive(Debug, Clone)]
pub struct Consistency {
    probes: f64,
    gate: f64,
    /// Exponential mean of the normalised innovation squared.
    mean: f64,
    rejected: u32,
    settling: u32,
    trusted: bool,
}

impl Consistency {
    /// Creates the test of an observer with `probes` probes and a gate, see [`gate`] and [`wide_gate`].
    #[must_use]
    pub fn new(probes: usize, gate: f64) -> Self {
        let degrees = probes.max(1) as f64;
        Self { probes: degrees, gate, mean: degrees, rejected: 0, settling: 0, trusted: true }
    }

    /// Creates the test of an observer that has just restarted: the gate is open and the observer is not trusted until it has
    /// settled.
    #[must_use]
    pub fn restarted(probes: usize, gate: f64) -> Self {
        Self { settling: SETTLING, trusted: false, ..Self::new(probes, gate) }
    }

    /// Returns a normalised innovation squared for statistics, at most the gate: beyond the gate its size means nothing.
    #[must_use]
    pub fn bounded(&self, nis: f64) -> f64 {
        if nis <= self.gate { nis } else { self.gate }
    }

    /// Returns the gate of the next sample.
    #[must_use]
    pub fn gate(&self) -> f64 {
        if self.settling > 0 { f64::INFINITY } else { self.gate }
    }

    /// Tests one sample with a reading of every probe: `nis` is its normalised innovation squared, `is_possible` is false where
    /// the bearings do not allow the estimated displacement.
    pub fn test(&mut self, nis: f64, is_possible: bool) -> ConsistencyState {
        self.mean += (self.bounded(nis) - self.mean) / WINDOW;
        self.rejected = if nis <= self.gate || self.settling > 0 { 0 } else { self.rejected + 1 };
        self.settling = self.settling.saturating_sub(1);
        if !is_possible || self.rejected >= REJECTED_IN_A_ROW {
            (self.rejected, self.settling, self.trusted) = (0, SETTLING, false);
            return ConsistencyState::Restart;
        }
        let ratio = self.ratio();
        self.trusted = match self.trusted {
            true => ratio <= LARGEST_RATIO,
            false => self.settling == 0 && ratio < SETTLED_RATIO,
        };
        if self.trusted { ConsistencyState::Trusted } else { ConsistencyState::Distrusted }
    }

    /// Returns the mean of the normalised innovation squared over the number of probes; 1 where model and noise are true.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.mean / self.probes
    }

    /// Returns true where forces come from the observer.
    #[must_use]
    pub(crate) const fn is_trusted(&self) -> bool {
        self.trusted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gates_are_chi_square_quantiles() {
        // Survival functions of 2, 4 and 6 degrees of freedom in closed form.
        let survival = [|_: f64| 1.0, |y: f64| 1.0 + y, |y: f64| 1.0 + y + 0.5 * y * y];
        for (n, sum) in survival.iter().enumerate() {
            for probes in [2 * n + 1, 2 * n + 2] {
                let y = 0.5 * gate(probes);
                assert!(((-y).exp() * sum(y) / 1e-9 - 1.0).abs() < 1e-6, "{probes}");
            }
        }
    }

    #[test]
    fn one_outlier_changes_nothing() {
        let mut test = Consistency::new(5, gate(5));
        assert!((0..1000).all(|_| test.test(5.0, true) == ConsistencyState::Trusted));
        assert_eq!(test.test(1e300, true), ConsistencyState::Trusted);
        assert_eq!(test.test(f64::NAN, true), ConsistencyState::Trusted);
        assert!((0..1000).all(|_| test.test(5.0, true) == ConsistencyState::Trusted));
    }

    #[test]
    fn repeated_rejection_restarts_and_is_trusted_again_after_settling() {
        let mut test = Consistency::new(5, gate(5));
        let verdicts: Vec<ConsistencyState> = (0..8).map(|_| test.test(1e6, true)).collect();
        assert_eq!(verdicts.last(), Some(&ConsistencyState::Restart));
        assert!(test.gate().is_infinite());
        let settled = (1..2000).find(|_| test.test(5.0, true) == ConsistencyState::Trusted);
        assert!(settled.is_some_and(|n| n >= SETTLING), "{settled:?}");
        assert!(test.gate().is_finite());
    }

    #[test]
    fn a_steady_excess_is_distrusted_without_a_restart() {
        let mut test = Consistency::new(5, gate(5));
        assert!((0..2000).all(|_| test.test(30.0, true) != ConsistencyState::Restart));
        assert!(!test.is_trusted());
        assert_eq!(test.test(5.0, false), ConsistencyState::Restart);
    }
}
