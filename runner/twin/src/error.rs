//! Errors of usage, as opposed to work that could not be done.

/// The command or the scene is wrong, as opposed to work that could not be done.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

impl UsageError {
    /// Turns any error into one of the command or the scene, with the same message.
    pub fn new(error: impl Into<anyhow::Error>) -> Self {
        Self(format!("{:#}", error.into()))
    }
}

/// Marks an error as the command's or the scene's fault.
#[must_use]
pub fn usage_error(error: &anyhow::Error) -> anyhow::Error {
    UsageError(format!("{error:#}")).into()
}
