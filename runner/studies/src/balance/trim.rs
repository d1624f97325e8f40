//! Trim runs: the vectors with the masses that are mounted, against what the other runs expect of them, and the probable error where they
//! are not those of the stated masses.

use super::correction::degrees;
use super::departure::Measured;
use super::error::BalanceError;
use super::runs::{Runs, determined};
use super::table::{C, VectorTable};
use super::vectors::Vectors;
use serde::Serialize;

/// Vector of a trim run at a probe.
#[derive(Debug, Clone, Serialize)]
pub struct TrimVector {
    /// Probe.
    pub probe: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Measured vector: size and angle in degrees.
    pub measured: [f64; 2],
    /// Vector that the other runs expect with the mounted masses: size, angle in degrees and standard deviation; `None` where they do not determine
    /// it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<[f64; 3]>,
}

/// Last trim run.
#[derive(Debug, Clone, Serialize)]
pub struct Trim {
    /// Condition.
    pub condition: String,
    /// Mounted moment of each plane: size in g mm and angle in degrees.
    pub mounted: Vec<[f64; 2]>,
    /// Its vectors.
    pub vectors: Vec<TrimVector>,
    /// Chi-squared of the vectors less the expected ones over its largest value by errors alone: above 1 they disagree; `None` where the other
    /// runs do not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misfit: Option<f64>,
}

impl Runs {
    /// Compares the last trim run with what the other runs expect of it; `None` without a trim run.
    ///
    /// # Errors
    /// Returns an error where other masses than the stated ones explain its vectors.
    pub(super) fn trim(&self, table: &VectorTable) -> Result<Option<Trim>, BalanceError> {
        let Some(&condition) = self.trims.last() else { return Ok(None) };
        let mounted = self.mounted();
        let measured = Measured::new(self, condition);
        let others = self.without(condition);
        let is_determined = determined(&others).is_ok() || self.prior.is_some();
        let learned = if is_determined { others.learned(&others.drift_times()) } else { None };
        let (mut expected, mut misfit) = (None, None);
        if let Some((drift, solution)) = &learned {
            let of = Vectors::new(&others, table, drift, solution.clone());
            misfit = measured.misfit(&of, &mounted, &measured.response);
            if misfit.is_some_and(|misfit| misfit > 1.0)
                && let Some(probable) = self.probable_error(table, (condition, &measured), &of, &mounted)
            {
                return Err(probable.error);
            }
            expected = Some(measured.expected(&of, &mounted));
        }
        let vector = |i: usize| TrimVector {
            probe: table.probes[measured.channels[i] % self.probes].clone(),
            speed_rpm: self.speeds[measured.channels[i] / self.probes],
            measured: [measured.response[i].norm(), degrees(measured.response[i])],
            expected: expected.as_ref().map(|of: &Vec<(C, f64)>| [of[i].0.norm(), degrees(of[i].0), of[i].1]),
        };
        Ok(Some(Trim {
            condition: self.conditions[condition].clone(),
            mounted: mounted.iter().map(|moment| [moment.norm(), degrees(*moment)]).collect(),
            vectors: (0..measured.channels.len()).map(vector).collect(),
            misfit,
        }))
    }
}
