//! Errors with an exit code of their own, as opposed to those at run time.

use ballrace_twin::error::{Error, with_causes};
use ballrace_twin::scene::build::BuildError;

/// Error returned when the command or the scene is invalid; the exit code is 2.
#[derive(Debug)]
pub struct UsageError(pub String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

impl UsageError {
    /// Creates a usage error from `error` with the messages of all its causes.
    pub fn new(error: impl Into<anyhow::Error>) -> Self {
        Self(format!("{:#}", error.into()))
    }

    /// Creates a usage error as [`new`](Self::new), with the option's name where `--bearing` selects no bearing.
    pub fn with_bearing_option(error: impl Into<Error>) -> Self {
        let error = error.into();
        let option = if matches!(error, Error::Build(BuildError::Selection { .. })) { "--bearing: " } else { "" };
        Self(format!("{option}{}", with_causes(&error)))
    }
}

/// Error returned by a monitor that a signal ends before it has anything to report; the exit code is that of other commands after a
/// signal.
#[derive(Debug)]
pub struct Interrupted(pub String);

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Interrupted {}
