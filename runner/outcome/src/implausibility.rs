//! Reasons why a recording cannot be one of the scene's machine.

use serde::Serialize;
use std::fmt::{Display, Formatter, Result};

/// Something that is not plausible.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Implausibility {
    /// Key or column that it concerns.
    pub subject: String,
    /// Observation, with numbers.
    pub found: String,
    /// Probable cause.
    pub cause: String,
    /// Change that would remove it.
    pub remedy: String,
}

impl Display for Implausibility {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { subject, found, cause, remedy } = self;
        write!(f, "{subject}: {found} (probable cause: {cause}; remedy: {remedy})")
    }
}
