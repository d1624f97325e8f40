//! Change of single values in the text of a scene; comments and order of the text stay.

use super::read::read_str;
use super::units::Dimension;
use serde_json::Value as Json;
use std::path::Path;
use toml_edit::{Array, DocumentMut, InlineTable, Item, TableLike, Value};

/// Value of a key that the user has to fill in.
pub const UNKNOWN: &str = "?";
/// A quantity whose unit no dimension has.
const NO_UNIT: &str = "1 unit-unknown";

/// One part of a key: a name, or an index of a list.
enum Part<'a> {
    Name(&'a str),
    Index(usize),
}

fn parts(key: &str) -> Option<Vec<Part<'_>>> {
    let mut all = Vec::new();
    for word in key.split('.') {
        let (name, indices) = word.split_once('[').map_or((word, None), |(name, rest)| (name, Some(rest)));
        all.push(Part::Name(name));
        for index in indices.into_iter().flat_map(|rest| rest.split('[')) {
            all.push(Part::Index(index.strip_suffix(']')?.parse().ok()?));
        }
    }
    Some(all)
}

/// Error returned when a key leads to no place of a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "no such key in the scene: {found:?}, expected one such as shaft.speed, bearing[0].radial_play or bearing.DE.radial_play"
)]
pub struct UnknownKey {
    /// The key.
    pub found: String,
}

/// Sets the value at `key` of a scene: names and indices such as `rotor.load[1]`; a bearing by its index or its name.
///
/// # Errors
/// A key that leads to no place of the scene.
pub fn put(document: &mut DocumentMut, key: &str, value: Value) -> Result<(), UnknownKey> {
    let found = parts(key).is_some_and(|parts| in_table(document.as_table_mut(), &parts, value));
    if found { Ok(()) } else { Err(UnknownKey { found: key.to_owned() }) }
}

/// Returns the text of a scene with other values at some keys. A value is one of TOML, or a text without quotation marks.
///
/// # Errors
/// A key that leads to no place of the scene; a text that is no TOML has none.
pub fn with_values(text: &str, values: &[(&str, &str)]) -> Result<String, UnknownKey> {
    if values.is_empty() {
        return Ok(text.to_owned());
    }
    let mut document: DocumentMut = text.parse().unwrap_or_default();
    for (key, value) in values {
        let value = value.trim();
        put(&mut document, key.trim(), value.parse().unwrap_or_else(|_| Value::from(value)))?;
    }
    Ok(document.to_string())
}

/// Returns the dimension of the quantity at `key`; none where the scene reads no quantity there, or where it has other errors. Values
/// that are still open in a draft are no errors.
#[must_use]
pub fn dimension_of(text: &str, file: &Path, key: &str) -> Option<Dimension> {
    let mut document: DocumentMut = text.parse().ok()?;
    put(&mut document, key.trim(), Value::from(NO_UNIT)).ok()?;
    let open = text.matches(UNKNOWN).count();
    for _ in 0..=open {
        // The reader reports the dimension that it expects where the unit is unknown.
        let error = read_str(&document.to_string(), file).err()?;
        let dimension = Dimension::of_expected(&error.expected);
        if error.found.contains(NO_UNIT) {
            return dimension;
        }
        // A value that is still open and no quantity is a list, such as the damping of a rotor.
        let example = || Value::from([1.0; 5].into_iter().collect::<Array>());
        put(&mut document, &error.key, dimension.map_or_else(example, |one| Value::from(one.example()))).ok()?;
    }
    None
}

/// Returns a value of a scene from one of JSON; none for `null`.
#[must_use]
pub fn value_of_json(json: &Json) -> Option<Value> {
    Some(match json {
        Json::Null => return None,
        Json::Bool(x) => Value::from(*x),
        Json::Number(x) => match x.as_i64() {
            Some(whole) => Value::from(whole),
            None => Value::from(x.as_f64()?),
        },
        Json::String(x) => Value::from(x.as_str()),
        Json::Array(all) => Value::from(all.iter().map(value_of_json).collect::<Option<Array>>()?),
        Json::Object(all) => {
            let entries = all.iter().map(|(key, value)| Some((key, value_of_json(value)?)));
            Value::from(entries.collect::<Option<InlineTable>>()?)
        }
    })
}

fn in_table(table: &mut dyn TableLike, parts: &[Part<'_>], value: Value) -> bool {
    match parts {
        [Part::Name(name)] => {
            table.insert(name, Item::Value(value));
            true
        }
        [Part::Name(name), rest @ ..] => table.get_mut(name).is_some_and(|item| in_item(item, rest, value)),
        _ => false,
    }
}

fn in_item(item: &mut Item, parts: &[Part<'_>], value: Value) -> bool {
    if let Some(tables) = item.as_array_of_tables_mut() {
        let at = match parts.first() {
            Some(Part::Index(i)) => Some(*i),
            Some(Part::Name(name)) => tables.iter().position(|t| t.get("name").and_then(Item::as_str) == Some(name)),
            None => None,
        };
        let (table, rest) = (at.and_then(|i| tables.get_mut(i)), parts.get(1..).unwrap_or_default());
        return table.is_some_and(|table| in_table(table, rest, value));
    }
    if let (Some(Part::Index(_)), Some(inside)) = (parts.first(), item.as_value_mut()) {
        return in_value(inside, parts, value);
    }
    item.as_table_like_mut().is_some_and(|table| in_table(table, parts, value))
}

fn in_value(inside: &mut Value, parts: &[Part<'_>], value: Value) -> bool {
    match parts {
        [] => {
            *inside = value;
            true
        }
        [Part::Index(i), rest @ ..] => {
            inside.as_array_mut().and_then(|array| array.get_mut(*i)).is_some_and(|entry| in_value(entry, rest, value))
        }
        [Part::Name(_), ..] => inside.as_inline_table_mut().is_some_and(|table| in_table(table, parts, value)),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn keys() {
        let text = "[shaft]\nspeed = 1\n[[bearing]]\nname = \"DE\"\nradial_play = 1\nwaviness = [{ order = 3 }]\n[rotor]\nload = [0, 1, 2]\n";
        let with = |key: &str| {
            let mut document: DocumentMut = text.parse().unwrap();
            put(&mut document, key, Value::from("5 um")).map(|()| document.to_string())
        };
        for key in ["bearing[0].radial_play", "bearing.DE.radial_play"] {
            assert!(with(key).unwrap().contains("radial_play = \"5 um\""), "{key}");
        }
        assert!(with("bearing[0].waviness[0].order").unwrap().contains("[{ order = \"5 um\" }]"));
        assert!(with("rotor.load[1]").unwrap().contains("[0, \"5 um\", 2]"));
        for bad in ["bearing[1].radial_play", "bearing.NDE.radial_play", "rotor.load[9]", "rotors.mass", "[", "a["] {
            assert!(with(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn values_of_json() {
        let written = |json: &str| value_of_json(&serde_json::from_str(json).unwrap()).map(|value| value.to_string());
        assert_eq!(written("[1, 2.5, \"3 um\", true]").unwrap().trim(), "[1, 2.5, \"3 um\", true]");
        assert_eq!(written("{\"order\": 9}").unwrap().trim(), "{ order = 9 }");
        assert_eq!(written("[null]"), None);
    }
}
