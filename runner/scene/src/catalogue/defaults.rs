//! Keys of a scene's `[[bearing]]` for a bearing of the catalogue.

use super::clearance::range;
use super::{BearingKind, Listed, Provenance};
use ballrace::contact::line::roller_stiffness;

/// Conformity of both races: makers use 0.515 to 0.53 and do not publish it.
const CONFORMITY: f64 = 0.52;
/// Length of a cylindrical roller over the width of the bearing, and its effective share without the rounded edges.
const ROLLER_LENGTH: [f64; 2] = [0.62, 0.9];

/// A key of `[[bearing]]` with its value in TOML.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneKey {
    /// The key.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// Origin of the value.
    pub origin: String,
    /// True where the value is estimated.
    pub is_estimated: bool,
}

/// Returns the least and the greatest diametral clearance of a bearing before mounting, m; none without a class of clearance.
#[must_use]
pub fn clearance_range(listed: &Listed) -> Option<[f64; 2]> {
    range(listed.entry, listed.class)
}

/// Returns the scene keys of a bearing of the catalogue before mounting.
#[must_use]
pub fn scene_keys(listed: &Listed) -> Vec<SceneKey> {
    let Listed { entry, class } = listed;
    let mut keys = Vec::new();
    let mut add = |key, value: String, origin: &str, is_estimated| {
        keys.push(SceneKey { key, value, origin: origin.to_owned(), is_estimated });
    };
    let (source, estimated) = (entry.source, entry.status == Provenance::Ratings);
    let middle = range(entry, *class).map(|[least, most]| 0.5 * (least + most));
    let clearance = |[least, most]: [f64; 2]| {
        format!("class {}, {:.0} to {:.0} um before mounting (ISO 5753-1)", class.name(), least * 1e6, most * 1e6)
    };
    let clearance = range(entry, *class).map_or_else(String::new, clearance);
    let is_roller = entry.kind == BearingKind::CylindricalRoller;
    add("model", if is_roller { "\"lumped\"" } else { "\"angular\"" }.to_owned(), "kind of the bearing", false);
    add("elements", entry.elements.to_string(), source, estimated);
    if is_roller {
        let [share, effective] = ROLLER_LENGTH;
        let length = share * entry.width * effective;
        let stiffness = roller_stiffness(length * 1e-3);
        let origin =
            format!("Palmgren, rollers of an effective length of {length:.1} mm, from the width of the bearing");
        add("stiffness", format!("{stiffness:.3e}"), &origin, true);
        add("exponent", "1.1111".to_owned(), "line contact, 10/9", false);
        if let Some(middle) = middle {
            add("radial_play", um(0.5 * middle), &format!("half of the mean of {clearance}"), true);
        }
        return keys;
    }
    add("ball_diameter", mm(entry.element_diameter), source, estimated);
    add("pitch_diameter", mm(entry.pitch_diameter), source, estimated);
    for key in ["inner_conformity", "outer_conformity"] {
        add(key, CONFORMITY.to_string(), "usually 0.515 to 0.53; makers do not publish it", true);
    }
    if entry.kind == BearingKind::AngularContact {
        add("contact_angle", format!("\"{} deg\"", entry.contact_angle), source, false);
    } else if let Some(middle) = middle {
        add("diametral_clearance", um(middle), &format!("mean of {clearance}"), true);
    }
    keys
}

fn mm(length: f64) -> String {
    format!("\"{length} mm\"")
}

fn um(length: f64) -> String {
    format!("\"{:.1} um\"", length * 1e6)
}
