//! Errors of assembling a rotor on its bearings.

use super::matrix::MatrixError;
use super::{MAX_BEARINGS, MAX_SUBSTEPS};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::rotor::InvalidMatrix;
use ballrace_base::eigenvalues::EigenvalueError;
use ballrace_models::build::BuildError;
use ballrace_scene::Coordinates;
use std::path::PathBuf;

/// Result of assembling or evaluating a plant.
pub type Result<T, E = PlantError> = std::result::Result<T, E>;

/// Error returned when the equations of motion of a scene cannot be assembled or solved.
#[derive(Debug, thiserror::Error)]
pub enum PlantError {
    /// The scene has neither rotor nor system.
    #[error("{}: missing table [rotor] or [system], without which there is no motion to compute", file.display())]
    NoRotor {
        /// Scene file.
        file: PathBuf,
    },
    /// The scene has too many bearings.
    #[error("{}: bearing: too many bearings: {found}, expected at most {MAX_BEARINGS}", file.display())]
    Bearings {
        /// Scene file.
        file: PathBuf,
        /// Number of bearings.
        found: usize,
    },
    /// No mounted bearing has this name.
    #[error("no such bearing on the rotor: {name:?}")]
    NotMounted {
        /// Name of the bearing.
        name: String,
    },
    /// A bearing cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The kernel rejects a parameter of the rotor, the system or a bearing.
    #[error("{part}")]
    Parameter {
        /// Table of the scene, or the bearing.
        part: String,
        /// The kernel's error.
        source: InvalidParameter,
    },
    /// The kernel rejects a matrix of the system.
    #[error("[system]")]
    System(#[source] InvalidMatrix),
    /// A matrix file is invalid.
    #[error(transparent)]
    Matrix(#[from] MatrixError),
    /// A matrix has another size than the mass matrix.
    #[error(
        "{}: wrong size of a matrix: {rows} x {columns}, expected {expected} x {expected}, square and as large as the mass \
         matrix",
        file.display()
    )]
    MatrixSize {
        /// Matrix file.
        file: PathBuf,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
        /// Number of coordinates.
        expected: usize,
    },
    /// A load vector has another length than the mass matrix.
    #[error("{}: wrong number of values: {found}, expected {expected}, one a coordinate", file.display())]
    LoadLength {
        /// File of the load.
        file: PathBuf,
        /// Count of numbers.
        found: usize,
        /// Number of coordinates.
        expected: usize,
    },
    /// An unbalance acts on a coordinate that does not exist.
    #[error("{}: system.unbalance: no such coordinate: {found}, expected 1 to {most}", file.display())]
    UnbalanceCoordinate {
        /// Scene file.
        file: PathBuf,
        /// Coordinate, from 1.
        found: usize,
        /// Number of coordinates.
        most: usize,
    },
    /// A bearing or a probe is on a coordinate that does not exist.
    #[error("{}: {part}: coordinates: no such coordinate: {found}, expected -{most} to {most}", file.display())]
    Coordinate {
        /// Scene file.
        file: PathBuf,
        /// Bearing or probe, with its name.
        part: String,
        /// Coordinate with sign, from 1.
        found: i64,
        /// Number of coordinates.
        most: usize,
    },
    /// A probe has no coordinate along its measuring direction.
    #[error(
        "{}: probe {probe}: no coordinate along its measuring direction: {found:?}, expected u or v that is not 0, or w \
         with axial = true", file.display()
    )]
    BlindProbe {
        /// Scene file.
        file: PathBuf,
        /// Column of the probe.
        probe: String,
        /// Its coordinates.
        found: Coordinates,
    },
    /// The system has too many coordinates.
    #[error("too many coordinates of the system: {found}, expected at most {most}")]
    Coordinates {
        /// Number of coordinates.
        found: usize,
        /// Largest number of coordinates.
        most: usize,
    },
    /// The plant has neither rotor nor system.
    #[error("missing table [rotor] or [system]")]
    NoSystem,
    /// The command needs a rotor, the scene has a system of matrices.
    #[error("{}: [system]: matrices in {command}, expected a [rotor]; simulate and replay take them", file.display())]
    NoRotorButSystem {
        /// Scene file.
        file: PathBuf,
        /// Name of the command.
        command: String,
    },
    /// The command needs bearings without coordinates of their own.
    #[error(
        "{}: bearing {bearing}: model = \"dynamic\" in {command}, expected another model; simulate takes it",
        file.display()
    )]
    MovingBalls {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Name of the command.
        command: String,
    },
    /// The mass matrix has no inverse.
    #[error("singular mass matrix")]
    SingularMass,
    /// The stiffness matrix has no inverse.
    #[error("singular stiffness matrix at rest")]
    SingularStiffness,
    /// Eigenvalues cannot be computed.
    #[error(transparent)]
    Eigenvalues(#[from] EigenvalueError),
    /// A natural frequency exceeds the range of numbers.
    #[error(
        "natural frequency beyond the range of numbers: {found} (rad/s)^2, expected masses, inertias and \
         stiffnesses within it"
    )]
    Frequency {
        /// Square of the frequency, (rad/s)^2.
        found: f64,
    },
    /// A sample period takes too many integration steps.
    #[error(
        "too many integration steps per sample: {found:.0} of {step:.3e} s, expected at most {MAX_SUBSTEPS}: a sampling \
         rate of {:.3e} Hz or more{}", 1.0 / (step * f64::from(MAX_SUBSTEPS)),
        if *is_given { " or a longer [integration] step" } else { "" }
    )]
    Substeps {
        /// Number of steps.
        found: f64,
        /// Step, s.
        step: f64,
        /// Whether the scene gives the step.
        is_given: bool,
    },
}

impl PlantError {
    /// Returns true where the command line or the scene is wrong, in every command.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        matches!(self, Self::Substeps { .. } | Self::Build(BuildError::NoForces { .. }))
    }
}

/// Returns a function that adds the part of the scene to an error of the kernel.
pub(super) fn rejected(part: &str) -> impl FnOnce(InvalidParameter) -> PlantError {
    move |source| PlantError::Parameter { part: part.to_owned(), source }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::PlantError;
    use crate::Plant;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    #[test]
    fn a_plant_without_a_rotor_names_the_scene() {
        let text = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"DE\"\nstation = 0\nmodel = \"lumped\"\nelements = 9\n\
                    stiffness = 1e10\nradial_play = 0\ncage_ratio = 0.4\n";
        let scene = read_str(text, Path::new("pump.toml")).unwrap();
        let Err(PlantError::NoRotor { file }) = Plant::try_new(&scene) else { panic!() };
        assert_eq!(file, Path::new("pump.toml"));
    }
}
