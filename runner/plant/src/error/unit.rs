//! Errors of units for co-simulation.

use std::path::PathBuf;

/// Error returned when a co-simulation unit cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum UnitError {
    /// A file of the unit cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file with the content of the unit is none.
    #[error("{}: invalid content of a unit, expected bearing = \"NAME\" or rate = a number above 0, Hz", file.display())]
    Content {
        /// The file.
        file: PathBuf,
    },
    /// The token is not that of the unit's files and this version.
    #[error("instantiationToken: {found:?}, expected {expected:?}, that of these resources and of ballrace {version}")]
    Token {
        /// Token of the host.
        found: String,
        /// Token of the unit.
        expected: String,
        /// Version of this library.
        version: &'static str,
    },
    /// No variable has this value reference.
    #[error("value reference {found}: no such variable, expected 0 to {most}")]
    Reference {
        /// The value reference.
        found: u32,
        /// Largest value reference.
        most: usize,
    },
    /// A variable that is no input is set.
    #[error("{name}: this variable is no input")]
    NotAnInput {
        /// Name of the variable.
        name: String,
    },
    /// A communication point is not the time of the unit.
    #[error("communication point {found} s, expected {expected} s, the end of the last step")]
    Point {
        /// Time of the host, s.
        found: f64,
        /// Time of the unit, s.
        expected: f64,
    },
    /// A step beyond the end of the simulation.
    #[error("end of the communication step {found} s, expected at most the stop time of {stop} s")]
    Beyond {
        /// End of the step, s.
        found: f64,
        /// Stop time, s.
        stop: f64,
    },
    /// A step without length.
    #[error("communication step {found} s, expected a step above 0 s")]
    NoLength {
        /// Length of the step, s.
        found: f64,
    },
    /// A communication step is no whole number of internal steps.
    #[error("communication step {found} s, expected a multiple of the internal step of {internal} s, such as {near} s")]
    Step {
        /// Length of the step, s.
        found: f64,
        /// Internal step, s.
        internal: f64,
        /// Nearest multiple, s.
        near: f64,
    },
}
