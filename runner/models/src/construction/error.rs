//! Errors of building kernel types from a scene.

use ballrace::bearing::geometry::InvalidParameter;
use std::path::PathBuf;

/// Error returned when the kernel's types cannot be built from a scene.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A value of a bearing that is invalid with its model, or missing.
    #[error("bearing {bearing}: {key}: {found}, expected {expected}")]
    Value {
        /// Name of the bearing.
        bearing: String,
        /// Key of the scene.
        key: String,
        /// Problem, with the value found.
        found: String,
        /// Values expected.
        expected: String,
    },
    /// A bearing without model, whose forces are not known.
    #[error(
        "{}: bearing {bearing}: no forces without a model: missing keys {missing}, expected for everything but the diagnosis of \
         vibration sensors", file.display()
    )]
    NoForces {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Missing keys.
        missing: &'static str,
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
    /// A cage that is not slower than the faster ring.
    #[error(
        "{}: bearing {bearing}: cage too fast: {found:.3} times the shaft speed, expected less than the speed of the faster ring",
        file.display()
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
        "{}: shaft.outer_speed: outer speed with a shaft speed that changes or is 0: {found} rad/s, expected an outer \
         speed only with one constant shaft speed", file.display()
    )]
    OuterSpeed {
        /// Scene file.
        file: PathBuf,
        /// Speed of the outer ring, rad/s.
        found: f64,
    },
    /// A preload that the bearing does not carry.
    #[error(
        "{}: bearing {bearing}: preload: more than the bearing carries along its axis: {found} N, expected a force that it \
         can carry", file.display()
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
        "{}: bearing {bearing}: table: states in which a ball has no equilibrium: {found} of {states}, expected none; a \
         smaller approach, angle or speed range in table = {{ ... }} leaves them out", file.display()
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
    #[error("{}, expected one of {names}", match found {
        Some(name) => format!("no such bearing in {}: {name:?}", file.display()),
        None => format!("no bearing selected in {}", file.display()),
    })]
    Selection {
        /// Scene file.
        file: PathBuf,
        /// Name given.
        found: Option<String>,
        /// Names of the scene's bearings.
        names: String,
    },
    /// A text that cannot be formatted.
    #[error(transparent)]
    Text(#[from] std::fmt::Error),
}

#[cfg(test)]
#[expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::build;
    use ballrace_scene::read::read_str;
    use ballrace_scene::{Model, Scene};
    use std::path::Path;

    fn scene() -> Scene {
        let text = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"DE\"\nstation = 0\nmodel = \"lumped\"\nelements = 9\n\
                    stiffness = 1e10\nradial_play = 0\ncage_ratio = 0.4\n";
        read_str(text, Path::new("pump.toml")).unwrap()
    }

    #[test]
    fn a_missing_geometry_names_bearing_key_and_expected_values() {
        let scene = scene();
        let error = build::bearing(&scene, &scene.bearings[0], Model::Angular).err().unwrap();
        let BuildError::Value { bearing, key, found, expected } = &error else { panic!("{error:?}") };
        assert_eq!((bearing.as_str(), key.as_str(), found.as_str()), ("DE", "model angular", "no geometry"));
        assert!(expected.contains("pitch_diameter"), "{expected}");
        assert!(error.to_string().starts_with("bearing DE: model angular: no geometry, expected ball_diameter, "));
    }

    #[test]
    fn a_selection_names_the_bearings_of_the_scene() {
        let scene = scene();
        let error = build::pick(&scene, Some("NDE")).err().unwrap();
        assert_eq!(error.to_string(), "no such bearing in pump.toml: \"NDE\", expected one of DE");
        let BuildError::Selection { file, found, names } = error else { panic!() };
        assert_eq!((file.as_path(), found.as_deref(), names.as_str()), (Path::new("pump.toml"), Some("NDE"), "DE"));
    }
}
