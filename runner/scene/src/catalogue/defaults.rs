//! Keys of a scene's `[[bearing]]` for a bearing of the catalogue.

use super::clearance::range;
use super::{BearingKind, Listed, Provenance};
use crate::RollerKind;
use ballrace::contact::line::roller_stiffness;

/// Conformity of both races: makers use 0.515 to 0.53 and do not publish it.
const CONFORMITY: f64 = 0.52;
/// Diametral clearance of a needle bearing in operation over the diameter of the shaft.
const NEEDLE_CLEARANCE: f64 = 1e-3;

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
    keys(listed, true)
}

/// Returns the scene keys of a bearing whose cylindrical rollers are line contacts.
pub(crate) fn line_contact_keys(listed: &Listed) -> Vec<SceneKey> {
    keys(listed, false)
}

fn keys(listed: &Listed, by_laminae: bool) -> Vec<SceneKey> {
    let Listed { entry, class } = listed;
    let mut keys = Vec::new();
    let mut add = |key, value: String, origin: &str, is_estimated| {
        keys.push(SceneKey { key, value, origin: origin.to_owned(), is_estimated });
    };
    let (source, estimated) = (entry.source, matches!(entry.status, Provenance::Ratings | Provenance::Dimensions));
    let middle = range(entry, *class).map(|[least, most]| 0.5 * (least + most));
    let clearance = |[least, most]: [f64; 2]| {
        format!("class {}, {:.0} to {:.0} um before mounting (ISO 5753-1)", class.name(), least * 1e6, most * 1e6)
    };
    let clearance = range(entry, *class).map_or_else(String::new, clearance);
    if let Some(kind) = entry.kind.rollers().filter(|kind| by_laminae || *kind != RollerKind::Cylindrical) {
        let length = entry.roller_length.unwrap_or(0.0);
        add("model", "\"roller\"".to_owned(), "kind of the bearing", false);
        add("kind", format!("\"{}\"", kind.name()), "kind of the bearing", false);
        add("elements", entry.elements.to_string(), source, estimated);
        add("roller_diameter", mm(entry.element_diameter), source, estimated);
        add("roller_length", format!("\"{length:.2} mm\""), "effective length, from the width of the bearing", true);
        add("pitch_diameter", mm(entry.pitch_diameter), source, estimated);
        if !kind.is_radial() {
            let is_standard = kind == RollerKind::Tapered;
            add("contact_angle", format!("\"{} deg\"", entry.contact_angle), source, !is_standard);
        } else if let Some(middle) = middle {
            add("radial_play", um(0.5 * middle), &format!("half of the mean of {clearance}"), true);
        } else {
            let play = 0.5 * NEEDLE_CLEARANCE * entry.bore * 1e-3;
            add("radial_play", um(play), "half of a clearance of a thousandth of the shaft, mounted", true);
        }
        return keys;
    }
    let is_roller = entry.kind == BearingKind::CylindricalRoller;
    add("model", if is_roller { "\"lumped\"" } else { "\"angular\"" }.to_owned(), "kind of the bearing", false);
    add("elements", entry.elements.to_string(), source, estimated);
    if is_roller {
        let length = entry.roller_length.unwrap_or(0.0);
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
