//! Whose fault a failure is.

/// The command or the scene is wrong, as opposed to work that could not be done.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Marks whatever went wrong as the command's or the scene's fault.
#[must_use]
pub fn usage_error(error: &anyhow::Error) -> anyhow::Error {
    UsageError(format!("{error:#}")).into()
}
