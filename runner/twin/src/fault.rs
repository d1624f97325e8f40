//! Whose fault a failure is.

/// The command or the scene is wrong, as opposed to work that could not be done.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SceneFault(pub String);

/// Marks whatever went wrong as the command's or the scene's fault.
#[must_use]
pub fn scene_fault(error: &anyhow::Error) -> anyhow::Error {
    SceneFault(format!("{error:#}")).into()
}
