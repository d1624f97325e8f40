//! The twin that the readings are compared with.

use serde::Serialize;

/// The twin that the readings are compared with.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComparedTwin {
    /// The twin starts each sample period at the state that the observer estimates; otherwise it runs freely from its start.
    pub synchronised: bool,
    /// Difference of two twins of the scene that started a turn apart; none where they end in the same motion.
    pub spread: Option<TwinSpread>,
}

impl ComparedTwin {
    /// Returns true where the residual has a meaning: the scene determines the motion, or the twin is synchronised.
    #[must_use]
    pub(crate) const fn is_comparable(&self) -> bool {
        self.synchronised || self.spread.is_none()
    }
}

/// Difference of two twins that started a turn apart.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TwinSpread {
    /// Probe at which they differ most over its noise.
    pub probe: String,
    /// Their rms difference there over the last turn.
    pub difference_um: f64,
    /// Time from the start of the earlier one.
    pub time_s: f64,
}
