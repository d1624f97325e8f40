//! Errors of the temperatures of bearings.

use std::path::PathBuf;

/// Error returned when the temperatures of bearings cannot be found.
#[derive(Debug, thiserror::Error)]
pub enum ThermalError {
    /// No bearing has a way for its heat.
    #[error("{}: no bearing with cooling, expected `cooling`, `lubrication` and `temperatures` in a bearing", file.display())]
    NoCooling {
        /// Scene file.
        file: PathBuf,
    },
    /// The friction of a bearing is not known.
    #[error(
        "{}: bearing {bearing}: no friction: its ratings are not known, expected its geometry or a bearing of the catalogue",
        file.display()
    )]
    NoFriction {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
    },
    /// The heat has no steady temperature in the range of bearing steel.
    #[error(
        "{}: bearing {bearing}: no steady temperature: {celsius:.0} degC with {watts:.0} W of friction, expected one below 250 degC; \
         more cooling, less preload or less viscosity",
        file.display()
    )]
    TooHot {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Temperature reached, degrees Celsius.
        celsius: f64,
        /// Power of the friction, W.
        watts: f64,
    },
    /// The rings use up the clearance, below which models with a contact angle do not hold.
    #[error(
        "{}: bearing {bearing}: no steady temperature: with the inner ring at {:.0} degC and the outer ring at {:.0} degC the operating \
         clearance is {micrometres:.1} um, and the preload runs away, expected a clearance of 0 or more; more cooling, less preload or interference",
        file.display(), rings[0], rings[1]
    )]
    NoClearance {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Temperatures of inner and outer ring, degrees Celsius.
        rings: [f64; 2],
        /// Operating clearance, um.
        micrometres: f64,
    },
    /// The temperatures do not settle.
    #[error("{}: no steady temperatures within {rounds} equilibria", file.display())]
    NotSteady {
        /// Scene file.
        file: PathBuf,
        /// Number of equilibria.
        rounds: usize,
    },
}
