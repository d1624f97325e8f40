//! Displacement from the probes, and figures of the observer.

use serde::Serialize;

/// Least-squares problem from probes to the shaft's pose.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Observation {
    /// Condition number of the probe matrix, tilts scaled by the probe span; 1 is perfect, above 100 the probes are badly placed.
    pub condition_number: f64,
    /// Largest ratio of the noise of a displacement at a bearing to the noise of a probe.
    pub noise_gain: f64,
    /// Coordinates that no probe measures and the twin supplies (`w` without an axial probe).
    pub supplied_by_twin: Vec<String>,
}

/// Figures of the observer.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ObserverOutcome {
    /// Mean of the innovations' normalised squares.
    pub nis_mean: f64,
    /// Expected value where model and noise are true: the number of probes.
    pub nis_expected: f64,
    /// 99 % confidence limits of the mean.
    pub nis_bounds: [f64; 2],
    /// The mean is between them and no sample is distrusted.
    pub consistent: bool,
    /// Largest normalised square that corrects the observer.
    pub gate: f64,
    /// Samples beyond it.
    pub rejected_samples: u64,
    /// Restarts after repeated rejection.
    pub restarts: u64,
    /// Samples in which the force comes from the displacement because the observer is not consistent.
    pub distrusted_samples: u64,
    /// Process noise of the unknown force, N per root second.
    pub process_noise_n_per_root_s: f64,
    /// Noise of each probe in the filter, rms.
    pub noise_um: Vec<f64>,
    /// The unknown load on the rotor: mean and rms about it, N (three) and N m (two); not numbers on a `[system]`.
    pub unknown_load_mean: [f64; 5],
    /// rms about the mean
    pub unknown_load_rms: [f64; 5],
}
