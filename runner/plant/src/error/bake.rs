//! Errors of baked constants, and of their verification.

use std::path::PathBuf;

/// Error returned when a scene cannot be written as constants.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// A model without constants.
    #[error(
        "{}: bearing {bearing}: {what}: model {found}, expected {expected}",
        file.display()
    )]
    Model {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Part of the bearing that has none.
        what: &'static str,
        /// Its model.
        found: &'static str,
        /// Scene that has constants.
        expected: &'static str,
    },
    /// Content of a scene for which the library of C has no struct and a blob no constants.
    #[error("{}: {place}: {found} with --language {language}, expected {expected}", file.display())]
    NotInC {
        /// Scene file.
        file: PathBuf,
        /// Language of the constants.
        language: &'static str,
        /// Part of the scene.
        place: String,
        /// Its content.
        found: String,
        /// Content that C has.
        expected: &'static str,
    },
    /// Two bearings whose names give one module.
    #[error(
        "{}: bearings {} and {}: both become the module {module}, expected names that differ in letters or digits",
        file.display(), bearings[0], bearings[1]
    )]
    SameModule {
        /// Scene file.
        file: PathBuf,
        /// Name of the module.
        module: String,
        /// Names of the bearings.
        bearings: [String; 2],
    },
    /// A rotor that its bearings do not support.
    #[error(
        "{}: no equilibrium: {residual:.2e} of the load is not balanced, expected at most {most:.0e} in bake",
        file.display()
    )]
    NoEquilibrium {
        /// Scene file.
        file: PathBuf,
        /// Residual of the equilibrium over the load.
        residual: f64,
        /// Largest residual.
        most: f64,
    },
    /// A displacement or force that is no number.
    #[error("{}: bearing {bearing}: {figure} out of the range of numbers, expected finite values in bake", file.display())]
    NotFinite {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Name of the value.
        figure: &'static str,
    },
    /// A motion with loads beyond the static rating.
    #[error(
        "{}: bearing {bearing}: load of {found:.2e} N on an element, expected at most {most:.2e} N, the static limit of ISO 76",
        file.display()
    )]
    Overload {
        /// Scene or recording.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Largest load on an element, N.
        found: f64,
        /// Load on an element at the permissible static contact pressure, N.
        most: f64,
    },
    /// A recording whose position is not that of the shaft in its bearings.
    #[error(
        "{}: bearing {bearing}: median force of {found:.2e} N at the recorded position, expected at most {most:.2e} N, the static force and \
         {factor} times the loads on the rotor: the gap of the probes is in the readings (offset)",
        file.display()
    )]
    Position {
        /// The recording.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Median of the magnitude of the force, N.
        found: f64,
        /// Largest force, N.
        most: f64,
        /// Largest force over the loads on the rotor.
        factor: f64,
    },
    /// An observer whose gains the scene does not determine.
    #[error("{}: [observer]: {found} in bake, expected {expected}", file.display())]
    Observer {
        /// Scene file.
        file: PathBuf,
        /// Content of the scene.
        found: &'static str,
        /// Content that determines the gains.
        expected: &'static str,
    },
}

/// Error returned when a file of baked constants cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// A file cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A blob without its certificate.
    #[error("{}: no certificate beside this blob ({found}): {} is missing, expected both files that bake has written, or --scene", file.display(), certificate.display())]
    NoCertificate {
        /// The blob.
        file: PathBuf,
        /// File of the certificate.
        certificate: PathBuf,
        /// Content of the blob.
        found: String,
    },
    /// A file without a block of comments.
    #[error("{}: no complete {what} in the comments, expected a file that bake has written", file.display())]
    NoBlock {
        /// The file.
        file: PathBuf,
        /// Name of the block.
        what: &'static str,
    },
    /// A certificate without a field.
    #[error("{}: missing field {name:?} of the certificate, expected a file that bake has written", file.display())]
    NoField {
        /// The file.
        file: PathBuf,
        /// Name of the field.
        name: &'static str,
    },
    /// A field of a certificate is invalid.
    #[error("{}: field {name:?} of the certificate: invalid value: {found:?}, expected {expected}", file.display())]
    Field {
        /// The file.
        file: PathBuf,
        /// Name of the field.
        name: &'static str,
        /// Its value.
        found: String,
        /// Values expected.
        expected: String,
    },
}
