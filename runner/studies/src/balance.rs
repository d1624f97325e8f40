//! Masses of a rotor from vibration vectors: influence coefficients from trial runs, and the moments that other runs carry.
//!
//! The once-per-turn vector of probe `p` at a speed is `y_p = B_p + sum_k C_pk u_k + d_p(t) + e`, with the moment `u_k` on each plane, the
//! influence coefficients `C`, the vector `B` of the rotor without added masses, and a drift that moves all probes and speeds
//! together. Trial runs give `B`, `C` and the drift; the moments of a blind run follow by least squares.
//!
//! Coefficients of planes that lie side by side are nearly in proportion, and single moments then known far less than their sum. What a
//! run carries is one of all choices of loaded planes, each as likely before as any other and with moments of the size of the trial
//! masses: an estimate and its interval are those of all choices together, weighted by their evidence. An empty plane so gets an interval
//! from 0.
//!
//! The twin of a machine has coefficients of its own, with the uncertainty of its parameters. They stand for trials that were not made,
//! and beside those that were: what is known of the coefficients before the trials.
//!
//! Source of influence coefficients: ISO 21940-12; of the evidence of choices: MacKay, Information Theory, Inference, and Learning
//! Algorithms, chapter 28.

mod agreement;
mod condition;
mod correction;
mod departure;
mod drift;
mod error;
mod hole_options;
mod holes;
mod moments;
mod outlier;
mod placement;
mod plane;
mod quality;
mod runs;
mod stock;
pub mod table;
mod trim;
mod twin;
mod vectors;

pub use agreement::Agreement;
use ballrace_base::parallel;
pub use condition::{Condition, Proof};
pub use correction::{Correction, PlaneCorrection, Predicted};
pub use departure::Departure;
pub use error::BalanceError;
pub use hole_options::{HoleOptions, OptionError};
pub use holes::{HoleCircle, HoleMass, Holes, PlaneHoles, Weight};
pub use moments::MomentEstimate;
pub use outlier::Outlier;
pub use placement::Placement;
pub use plane::{MassesError, Plane, masses};
pub use quality::{PlaneQuality, Quality, Requirement, TolerancePlane};
use runs::{Runs, determined};
use serde::Serialize;
pub use stock::{MOST_WEIGHTS, StockChoice};
use table::{C, VectorTable};
pub use trim::{Trim, TrimVector};
pub use twin::{TwinCoefficients, radial_probes};
use vectors::Vectors;

/// Runs that differ by less in speed are of one speed.
pub const SAME_SPEED: f64 = 0.03;
/// Logarithm of the likelihood ratio from which the angles are taken to be counted the other way: odds of 1000.
const MIRRORED: f64 = 7.0;

/// A channel of the vectors: probe and speed.
#[derive(Debug, Clone, Serialize)]
pub struct Influence {
    /// Probe.
    pub probe: String,
    /// Mean speed of the runs, rpm.
    pub speed_rpm: f64,
    /// Vector without added masses: size and angle in degrees.
    pub baseline: [f64; 2],
    /// Standard deviation of a further vector without added masses: by the estimate, the drift and the error of a run.
    pub baseline_deviation: f64,
    /// Influence coefficient of each plane per g mm: size, angle in degrees and standard deviation.
    pub coefficients: Vec<[f64; 3]>,
    /// Standard deviation of the drift, and of the error of a run.
    pub drift: f64,
    /// The same of the error of a run beside the drift.
    pub error: f64,
}

/// Result of an estimate.
#[derive(Debug, Clone, Serialize)]
pub struct Balance {
    /// Names of the planes.
    pub planes: Vec<String>,
    /// Unit of the vectors.
    pub unit: String,
    /// Records that are not used: each departs from the others of its condition.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outliers: Vec<Outlier>,
    /// Influence coefficients, by speed and probe.
    pub influence: Vec<Influence>,
    /// Largest over least singular value of the coefficients in units of their errors: how far the planes lie apart.
    pub condition_number: f64,
    /// Time within which the drift is lost, s; `None` where the runs have no times.
    pub drift_time_s: Option<f64>,
    /// Moments of the blind conditions, in the order of the table.
    pub conditions: Vec<Condition>,
    /// Each known condition estimated from the others.
    pub proof: Proof,
    /// Known condition whose vectors are not those that the others expect of it; `None` where all agree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure: Option<Departure>,
    /// Last trim run against what the other runs expect of it; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trim: Option<Trim>,
    /// Correction of the rotor: with the masses of the last trim run, else without added masses.
    pub correction: Correction,
    /// Agreement of the vectors with the coefficients of the twin; `None` without a twin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin: Option<Agreement>,
    /// Balance quality before and after the correction; `None` where none is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<Quality>,
}

/// Estimates influence coefficients, the moments of the blind conditions of a table, and the correction of the rotor without added masses.
/// `twin` has the coefficients of a scene for the planes, probes and speeds of the table.
///
/// # Errors
/// Returns an error if trials and twin do not determine the coefficients of every plane at every speed, or do not agree, if a trim run has other
/// masses than stated, and for a stock of too many choices.
pub fn balance(
    table: &VectorTable,
    twin: Option<&TwinCoefficients>,
    placement: &Placement,
) -> Result<Balance, BalanceError> {
    let (used, outliers) = outlier::without_outliers(table);
    let mut runs = Runs::new(&used);
    if placement.replaces && runs.trims.is_empty() {
        return Err(BalanceError::NoTrim);
    }
    let is_determined = determined(&runs);
    if twin.is_none() {
        is_determined?;
    } else if is_determined.is_ok() {
        agreement::response(&runs, table)?;
    }
    let agreement = twin.map(|twin| runs.agreement(table, twin)).transpose()?;
    if let (Some(twin), Some(Agreement { used: true, .. })) = (twin, agreement) {
        let singular = || BalanceError::Dependent { speed: runs.speeds.first().copied().unwrap_or_default() };
        runs = runs.with_twin(twin).ok_or_else(singular)?;
    }
    let speed = runs.speeds.first().copied().unwrap_or_default();
    let dependent = || BalanceError::Dependent { speed };
    let (drift, solution) = runs.learned(&runs.drift_times()).ok_or_else(dependent)?;
    // A single run with a probable error makes the masses of all look mirrored now and then.
    let departure = runs.departure(table, drift.time)?;
    let mirrored = runs.mirrored().learned(&[drift.time]);
    if mirrored.is_some_and(|(_, other)| other.log_likelihood > solution.log_likelihood + MIRRORED) {
        return Err(BalanceError::Mirrored);
    }
    let trim = runs.trim(table)?;
    let (drift, solution) = if runs.trims.is_empty() {
        (drift, solution)
    } else {
        runs = runs.with_errors_of_masses(&solution.theta);
        runs.learned(&runs.drift_times()).ok_or_else(dependent)?
    };
    let theta = solution.theta.clone();
    let vectors = Vectors::new(&runs, table, &drift, solution);
    let singular = vectors.weighted().singular_values();
    if singular.max() < correction::OBSERVED {
        return Err(BalanceError::NoResponse);
    }
    let polar = |x: C| [x.norm(), x.arg().to_degrees().rem_euclid(360.0)];
    let of_baseline = vectors.errors(&vec![C::new(0.0, 0.0); runs.planes]);
    let influence = |channel: usize| Influence {
        probe: vectors.probe(channel).to_owned(),
        speed_rpm: vectors.speed(channel),
        baseline: polar(vectors.baseline(channel)),
        baseline_deviation: of_baseline[(channel, channel)].re.max(0.0).sqrt(),
        coefficients: (0..runs.planes)
            .map(|k| {
                let [size, angle] = polar(vectors.coefficient(channel, k));
                [size, angle, vectors.deviation(channel, k)]
            })
            .collect(),
        drift: drift.covariance[(channel, channel)].re.sqrt(),
        error: drift.variance[channel].sqrt(),
    };
    let is_blind = |condition: &usize| runs.all.iter().any(|run| run.condition == *condition && run.moments.is_none());
    let blind: Vec<usize> = (0..runs.conditions.len()).filter(is_blind).collect();
    let conditions = parallel::map(&blind, |condition| runs.moments(&drift, &theta, *condition));
    Ok(Balance {
        planes: table.planes.clone(),
        unit: table.unit.clone(),
        outliers,
        influence: (0..runs.channels()).map(influence).collect(),
        condition_number: singular.max() / singular.min().max(f64::MIN_POSITIVE),
        drift_time_s: runs.has_times.then_some(drift.time),
        conditions: conditions.into_iter().collect::<Option<_>>().ok_or_else(dependent)?,
        proof: runs.proof(drift.time),
        departure,
        trim,
        correction: correction::correction(&vectors, placement)?,
        twin: agreement,
        quality: None,
    })
}
