//! Planes of the rotor of a scene, and the masses that a trial run adds to them.

use super::table::C;
use ballrace_scene::Scene;
use ballrace_scene::units::{Dimension, parse};

/// kg m in a g mm.
const G_MM: f64 = 1e-6;
/// Distance within which two stations are one plane, m.
const SAME_PLANE: f64 = 1e-6;
/// Share of the distance of the outermost bearings by which the default planes of a rigid rotor are inside of them.
const INSIDE: f64 = 0.25;

/// A plane of a rotor in which masses are added.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Name of a bearing, or the station as drawn.
    pub name: String,
    /// Station from the centre of mass, m.
    pub station: f64,
}

/// Error of a text that names planes and masses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{found}, expected {expected}")]
pub struct MassesError {
    /// What was found.
    pub found: String,
    /// What is expected.
    pub expected: String,
}

impl Plane {
    /// Returns the plane of a station from the centre of mass, m.
    fn at(scene: &Scene, station: f64) -> Self {
        let drawn = (scene.drawn_station(station) * 1e6).round() / 1e3;
        Self { name: format!("{} mm", drawn + 0.0), station }
    }

    /// Returns the plane of a text: the name of a bearing, or a station as the scene draws it, such as `310 mm`.
    ///
    /// # Errors
    /// Returns an error for another text, and for a station beyond the ends of a drawn shaft.
    pub fn named(scene: &Scene, text: &str) -> Result<Self, MassesError> {
        let text = text.trim();
        if let Some(bearing) = scene.bearings.iter().find(|bearing| bearing.name == text) {
            return Ok(Self { name: bearing.name.clone(), station: bearing.station });
        }
        let names: Vec<&str> = scene.bearings.iter().map(|bearing| bearing.name.as_str()).collect();
        let Ok(drawn) = parse(text, Dimension::Length) else {
            let expected = format!("a bearing ({}) or a station with a unit, such as \"310 mm\"", names.join(", "));
            return Err(MassesError { found: format!("unknown plane: {text:?}"), expected });
        };
        let station = drawn - scene.drawn_station(0.0);
        let shaft = scene.rotor.as_ref().and_then(|rotor| rotor.flexible.as_ref()).map(|drawn| &drawn.sections);
        if let Some((first, last)) = shaft.and_then(|sections| sections.first().zip(sections.last()))
            && !(first.from - SAME_PLANE..=last.to + SAME_PLANE).contains(&station)
        {
            let [from, to] = [first.from, last.to].map(|end| scene.drawn_station(end) * 1e3);
            let expected = format!("a station on the shaft, {from:.1} to {to:.1} mm");
            return Err(MassesError { found: format!("plane {text:?}: beyond the shaft"), expected });
        }
        Ok(Self::at(scene, station))
    }

    /// Returns true for the same plane under whichever name.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        (self.station - other.station).abs() < SAME_PLANE
    }

    /// Returns the planes of a scene: those of its unbalances, else of its disks, else two between its outermost bearings.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Vec<Self> {
        let Some(rotor) = &scene.rotor else { return vec![] };
        let unbalances = rotor.unbalance.iter().map(|unbalance| unbalance.station);
        let disks = rotor.flexible.iter().flat_map(|drawn| &drawn.disks).map(|disk| disk.station);
        let ends = scene.bearings.iter().map(|bearing| bearing.station);
        let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
        let between = [INSIDE, 1.0 - INSIDE].map(|share| low + share * (high - low));
        let first = |stations: Vec<f64>, other: Vec<f64>| if stations.is_empty() { other } else { stations };
        let stations = first(unbalances.collect(), first(disks.collect(), between.to_vec()));
        let mut planes: Vec<Self> = vec![];
        for station in stations {
            let plane = Self::at(scene, station);
            if !planes.iter().any(|other| other.is_same(&plane)) {
                planes.push(plane);
            }
        }
        planes.sort_by(|a, b| a.station.total_cmp(&b.station));
        planes
    }
}

/// Reads the masses of a trial: `PLANE MOMENT at ANGLE`, several separated by commas, such as `DE 5 g mm at 30 deg`. Angles count from the
/// keyphasor mark in the direction of positive rotation. Returns moments in g mm.
///
/// # Errors
/// Returns an error for another text, an unknown plane, a quantity without a unit or of another dimension, or a moment of 0 or less.
pub fn masses(scene: &Scene, text: &str) -> Result<Vec<(Plane, C)>, MassesError> {
    text.split(',').map(|one| mass(scene, one.trim())).collect()
}

fn mass(scene: &Scene, text: &str) -> Result<(Plane, C), MassesError> {
    let form = || "PLANE MOMENT at ANGLE, such as \"DE 5 g mm at 30 deg\"".to_owned();
    let Some((left, angle)) = text.rsplit_once(" at ") else {
        return Err(MassesError { found: format!("{text:?}: no \" at \""), expected: form() });
    };
    let of_units = |mismatch: ballrace_scene::units::Mismatch| MassesError {
        found: format!("{text:?}: {}", mismatch.found),
        expected: mismatch.expected,
    };
    let angle = parse(angle, Dimension::Angle).map_err(of_units)?;
    // The plane may be a quantity too: the moment is the longest end of the text that is one.
    let spaces = left.char_indices().filter(|(_, c)| c.is_whitespace()).map(|(at, _)| at);
    let parts = spaces.map(|at| (&left[..at], left[at..].trim()));
    let found = parts.clone().find_map(|(plane, moment)| Some((plane, parse(moment, Dimension::Unbalance).ok()?)));
    let Some((plane, moment)) = found else {
        if parse(left, Dimension::Unbalance).is_ok() {
            return Err(MassesError { found: format!("{text:?}: no plane"), expected: form() });
        }
        // The first number after the plane is what was meant.
        let number = parts.clone().find(|(_, rest)| rest.starts_with(|c: char| c.is_ascii_digit()));
        let mismatch = number.and_then(|(_, moment)| parse(moment, Dimension::Unbalance).err());
        let none = || MassesError { found: format!("{text:?}: no moment"), expected: form() };
        return Err(mismatch.map_or_else(none, of_units));
    };
    if moment <= 0.0 {
        let expected = Dimension::Unbalance.expected("above 0");
        return Err(MassesError { found: format!("{text:?}: value out of range"), expected });
    }
    Ok((Plane::named(scene, plane)?, C::from_polar(moment / G_MM, angle)))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    fn scene() -> Scene {
        let bearing = |name: &str, station: i32| {
            format!(
                "[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nmodel = \"lumped\"\nelements = 9\nstiffness = 1e10\nradial_play = 0\ncage_ratio = 0.4\n"
            )
        };
        let text = format!(
            "[shaft]\nspeed = \"3000 rpm\"\n[rotor]\nmass = 6\ndiametral_inertia = 0.03\npolar_inertia = 0.006\n{}{}",
            bearing("DE", -100),
            bearing("NDE", 100)
        );
        read_str(&text, Path::new("rig.toml")).unwrap()
    }

    #[test]
    fn masses_of_a_trial() {
        let found = masses(&scene(), "DE 5 g mm at 30 deg, 20 mm 0.1 g m at -1.5 rad").unwrap();
        assert_eq!(found[0].0, Plane { name: "DE".to_owned(), station: -0.1 });
        assert!((found[0].1 - C::from_polar(5.0, 30_f64.to_radians())).norm() < 1e-9);
        assert_eq!(found[1].0, Plane { name: "20 mm".to_owned(), station: 0.02 });
        assert!((found[1].1 - C::from_polar(100.0, -1.5)).norm() < 1e-9);
    }

    #[test]
    fn wrong_masses_have_one_clear_error() {
        for (text, expected) in [
            ("DE 5 g mm", "no \" at \", expected PLANE MOMENT at ANGLE"),
            ("DE 5 g mm at 30", "has no unit"),
            ("DE 5 g mm at 30 mm", "an angle"),
            ("DE 5 at 30 deg", "has no unit"),
            ("DE 5 g at 30 deg", "expected a"),
            ("5 g mm at 30 deg", "no plane"),
            ("DE at 30 deg", "no moment"),
            ("XY 5 g mm at 30 deg", "unknown plane: \"XY\", expected a bearing (DE, NDE) or a station"),
            ("DE -5 g mm at 30 deg", "value out of range"),
        ] {
            let error = masses(&scene(), text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn planes_of_a_rigid_rotor_lie_between_its_bearings() {
        let planes = Plane::of_scene(&scene());
        assert_eq!(planes.iter().map(|plane| plane.name.as_str()).collect::<Vec<_>>(), ["-50 mm", "50 mm"]);
    }
}
