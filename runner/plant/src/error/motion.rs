//! Errors of a computed motion and of an equilibrium.

use std::path::PathBuf;

/// Speed of sound in steel, m/s: a motion that is faster has no physical meaning, and is that of an unstable system or step.
pub const LARGEST_SPEED: f64 = 5000.0;

/// Error returned when a computed motion overflows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the motion overflows: {found}, expected at most {LARGEST_SPEED} m/s. {advice}")]
pub struct MotionOverflow {
    /// Speed and time.
    pub found: String,
    /// Probable cause.
    pub advice: String,
}

/// Error returned for a single bearing without a load.
#[derive(Debug, thiserror::Error)]
#[error(
    "{}: bearing {bearing}: neither a rotor, a preload nor --load, expected one of them as a load for the equilibrium",
    file.display()
)]
pub struct NoLoad {
    /// Scene file.
    pub file: PathBuf,
    /// Name of the bearing.
    pub bearing: String,
}
