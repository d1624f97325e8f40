//! Errors of usage, as opposed to work that could not be done.

/// The command or the scene is wrong, as opposed to work that could not be done.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

impl UsageError {
    /// Returns `error` as an error of usage, with the messages of all its causes.
    pub fn new(error: impl Into<anyhow::Error>) -> Self {
        Self(format!("{:#}", error.into()))
    }
}
