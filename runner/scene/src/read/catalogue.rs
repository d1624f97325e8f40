//! `bearing = "6309"` in `[[bearing]]`: values of the catalogue for the keys that the scene does not have.

use super::super::table::{Read, Table};
use super::bearing::{self, DESIGNATION, LUMPED};
use super::pitch_circle::ROLLER_DIAMETER;
use super::rollers::ROLLERS;
use crate::FromCatalogue;
use crate::catalogue::{find, line_contact_keys, scene_keys};
use toml_edit::Value;

/// Exactly one of these defines the fit of a bearing.
const FIT: [&str; 2] = ["contact_angle", "diametral_clearance"];

/// One of these defines the play of rollers.
const PLAY: [&str; 2] = ["radial_play", "diametral_clearance"];

/// Keys that the lumped model has and rollers by laminae do not have: with one of them a cylindrical-roller bearing is a line contact.
const OF_LINE_CONTACT: [&str; 4] = ["exponent", "axial", "housing_displacement", "outer_ring"];

/// A bearing of the catalogue and the keys that it stands for.
pub(super) struct Expansion {
    pub used: FromCatalogue,
    pub defaults: toml_edit::Table,
}

/// Returns the entry of each `[[bearing]]`, or none where it has no key `bearing`.
pub(super) fn of_bearings(root: &Table<'_>) -> Read<Vec<Option<Expansion>>> {
    let expected = "at least one table [[bearing]], in double brackets";
    let Some(node) = root.optional(DESIGNATION) else { return Ok(vec![]) };
    node.list(expected)?.iter().map(|node| expansion(&bearing::table(node)?)).collect()
}

fn expansion(table: &Table<'_>) -> Read<Option<Expansion>> {
    let Some(node) = table.optional(DESIGNATION) else { return Ok(None) };
    let designation = node.text("a designation, such as \"6309\" or \"NU205 C3\"")?;
    let listed = find(designation).map_err(|unknown| node.refuse(unknown.expected()))?;
    // A model, a fit or a law of the scene's own replaces the keys of the catalogue that do not go together with it.
    let has_one_of = |keys: &[&str]| keys.iter().any(|key| table.has(key));
    let has_fit = has_one_of(&FIT);
    let is = |key: &str, name: &str| table.read(key, |node| Ok(node.text("").is_ok_and(|text| text == name)));
    let is_lumped = is("model", "lumped")?.unwrap_or(true) || is("linearise", "lumped")? == Some(true);
    let (mut defaults, mut estimated) = (toml_edit::Table::new(), Vec::new());
    let names_rollers = ["roller", "quasi-static", "quasi-static-roller"].iter().any(|name| {
        [is("model", name), is("linearise", name)].into_iter().any(|is| is.is_ok_and(|is| is == Some(true)))
    });
    let is_default = !table.has("model") && !has_one_of(&OF_LINE_CONTACT);
    let by_laminae = names_rollers || has_one_of(&ROLLERS) || is_default;
    let keys = if by_laminae { scene_keys(&listed) } else { line_contact_keys(&listed) };
    let is_roller = keys.iter().any(|key| key.key == ROLLER_DIAMETER);
    let has_play = has_one_of(&PLAY);
    for key in keys {
        let is_replaced = if is_roller {
            has_play && PLAY.contains(&key.key)
        } else {
            has_fit && FIT.contains(&key.key) || !is_lumped && LUMPED.contains(&key.key)
        };
        if !is_replaced && let Ok(value) = key.value.parse::<Value>() {
            defaults.insert(key.key, value.into());
            if key.is_estimated && !table.has(key.key) {
                estimated.push(format!("{} = {}", key.key, key.value));
            }
        }
    }
    Ok(Some(Expansion { used: FromCatalogue { listed, estimated }, defaults }))
}
