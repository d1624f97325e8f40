//! Simpler predictors of the signal at a probe, and how the twin compares.

use crate::field::NumericField;
use serde::Serialize;

/// Comparison of the twin with a simpler predictor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// The residual of the twin is more than 2 % smaller.
    Better,
    /// The residuals are within 2 % of each other.
    #[default]
    Same,
    /// The residual of the twin is more than 2 % larger, and more than 0.1 % of the motion.
    Worse,
}

/// One simpler predictor of the same signal.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimplePredictor {
    /// Rms of its residual.
    pub residual_rms_um: f64,
    /// The twin in comparison.
    pub twin_is: Standing,
}

impl SimplePredictor {
    /// Creates the comparison from the residuals of the predictor and of the twin, and the rms of the signal about its mean.
    #[must_use]
    pub fn new(residual_rms_um: f64, twin_rms_um: f64, signal_rms_um: f64) -> Self {
        const MARGIN: f64 = 0.02;
        // What integration and the digits of a file leave of a motion that is predicted exactly.
        const EXACT: f64 = 1e-3;
        let twin_is = if twin_rms_um < (1.0 - MARGIN) * residual_rms_um {
            Standing::Better
        } else if twin_rms_um > (1.0 + MARGIN) * residual_rms_um && twin_rms_um > EXACT * signal_rms_um {
            Standing::Worse
        } else {
            Standing::Same
        };
        Self { residual_rms_um, twin_is }
    }
}

/// Simpler predictors of the signal at a probe.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimplePredictors {
    /// Mean of the signal.
    pub mean: SimplePredictor,
    /// Previous sample.
    pub persistence: SimplePredictor,
    /// Mean and 1X fitted to the recording.
    pub one_x: SimplePredictor,
    /// The same rotor on linear springs.
    pub linear: SimplePredictor,
}

impl SimplePredictors {
    /// The predictors, each with its residual.
    pub const FIELDS: [NumericField<Self, SimplePredictor>; 4] = [
        NumericField::new("mean", "Mean", "um rms", |of| of.mean),
        NumericField::new("persistence", "Previous sample", "um rms", |of| of.persistence),
        NumericField::new("one_x", "Mean and 1X", "um rms", |of| of.one_x),
        NumericField::new("linear", "Linear springs", "um rms", |of| of.linear),
    ];

    /// Returns the predictors in the order of the tables.
    #[must_use]
    pub fn all(&self) -> [SimplePredictor; 4] {
        Self::FIELDS.map(|field| (field.value)(self))
    }

    /// Returns the comparison of the twin with the best of them.
    #[must_use]
    pub fn worst(&self) -> Standing {
        self.all().map(|b| b.twin_is).into_iter().max().unwrap_or_default()
    }
}
