//! Errors of building kernel types from a scene.

use ballrace::bearing::geometry::InvalidParameter;
use std::path::PathBuf;

/// Error returned when the kernel's types cannot be built from a scene.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A value of a bearing that is invalid with its model, or missing.
    #[error("bearing {bearing}: {key}: found {found}, allowed: {expected}")]
    Value {
        /// Name of the bearing.
        bearing: String,
        /// Key of the scene.
        key: String,
        /// Value found.
        found: String,
        /// Values allowed.
        expected: String,
    },
    /// A parameter that the kernel rejects.
    #[error("bearing {bearing}: {error}")]
    Parameter {
        /// Name of the bearing.
        bearing: String,
        /// The kernel's error.
        error: InvalidParameter,
    },
    /// A load that the kernel rejects.
    #[error(transparent)]
    Load(#[from] InvalidParameter),
    /// A cage that is not slower than the shaft.
    #[error(
        "{}: bearing {bearing}: found a cage that turns {found:.3} times as fast as the shaft, allowed: slower than the \
         shaft", file.display()
    )]
    CageRatio {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Cage speed over shaft speed.
        found: f64,
    },
    /// A rotating outer ring without a constant ratio of the ring speeds.
    #[error(
        "{}: shaft.outer_speed: found {found} rad/s with a shaft speed that changes or is 0, allowed: an outer speed only \
         with one constant shaft speed", file.display()
    )]
    OuterSpeed {
        /// Scene file.
        file: PathBuf,
        /// Speed of the outer ring, rad/s.
        found: f64,
    },
    /// A preload that the bearing does not carry.
    #[error(
        "{}: bearing {bearing}: preload: found {found} N, which the bearing does not carry along its axis, allowed: a \
         force that it can carry", file.display()
    )]
    Preload {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Preload force, N.
        found: f64,
    },
    /// A table with states in which a ball has no equilibrium.
    #[error(
        "{}: bearing {bearing}: table: found {found} of {states} states in which a ball has no equilibrium, allowed: none; \
         a smaller approach, angle or speed range in table = {{ ... }} leaves them out", file.display()
    )]
    Table {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Number of such states.
        found: usize,
        /// Number of all states.
        states: usize,
    },
    /// A bearing that is not in the scene, or no selection among several.
    #[error("--bearing: {}", match found {
        Some(name) => format!("found {name:?}, allowed in {}: {names}", file.display()),
        None => format!("found none, allowed: one of {names} ({} has several)", file.display()),
    })]
    Selection {
        /// Scene file.
        file: PathBuf,
        /// Name given.
        found: Option<String>,
        /// Names of the scene's bearings.
        names: String,
    },
}
