//! JSON schema of scenes, with which editors complete and check them.
//!
//! It accepts every scene that [`read`](crate::read) accepts. Conditions between tables, such as bearings that stand on the shaft, are
//! not in it.

use crate::key::{Bounds, Choice, Keys, Kind};
use crate::read::keys::SCENE;
use crate::units::Dimension;
use serde_json::{Map, Value, json};
use std::ops::Bound;

/// A number at the start of a quantity, without its sign.
const NUMBER: &str = r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?";

/// Returns the schema of a scene file (JSON Schema, draft 2020-12).
#[must_use]
pub fn json_schema() -> Value {
    let mut definitions = Map::new();
    let mut schema = table(&SCENE, &mut definitions);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("ballrace scene");
    schema["description"] = json!("A rotating machine, its bearings and the columns of its recording.");
    schema["$defs"] = Value::Object(definitions);
    schema
}

fn table(keys: &'static Keys, definitions: &mut Map<String, Value>) -> Value {
    let properties: Map<String, Value> = keys
        .all()
        .map(|key| {
            let mut property = of_kind(&key.kind, definitions);
            let range = if key.range.is_empty() { String::new() } else { format!(" ({})", key.range) };
            let example = if key.example.is_empty() { String::new() } else { format!(" Example: `{}`.", key.example) };
            let text = format!("{}{range}. Default: {}.{example}", capitalised(key.meaning), key.default);
            let text = text.replace(&format!(" Default: {}.", crate::key::REQUIRED), " Required.");
            if property.get("$ref").is_some() {
                // Editors show no description beside a reference.
                property = json!({ "anyOf": [property] });
            }
            property["description"] = json!(without_links(&text));
            (key.name.to_owned(), property)
        })
        .collect();
    let required: Vec<&str> = keys.all().filter(|key| key.is_required()).map(|key| key.name).collect();
    let mut schema = json!({
        "title": keys.name,
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    add_choices(keys, &mut schema);
    schema
}

/// Adds the conditions of several keys, without `allOf`, below which editors find no properties.
fn add_choices(keys: &Keys, schema: &mut Value) {
    let mut excluded: Vec<Value> = Vec::new();
    for choice in keys.choices {
        match choice {
            Choice::One(sets) => {
                let alternative = |set: &&[&str]| {
                    let others = sets.iter().copied().flatten().filter(|key| !set.contains(key));
                    let absent: Map<String, Value> = others.map(|key| ((*key).to_owned(), json!(false))).collect();
                    json!({ "required": set, "properties": absent })
                };
                schema["oneOf"] = sets.iter().map(alternative).collect();
            }
            Choice::Any(sets) => schema["anyOf"] = sets.iter().map(|set| json!({ "required": set })).collect(),
            Choice::AtMostOne(keys) => {
                let pairs =
                    keys.iter().enumerate().flat_map(|(i, key)| keys.iter().take(i).map(move |other| [other, key]));
                excluded.extend(pairs.map(|pair| json!({ "required": pair })));
            }
        }
    }
    if !excluded.is_empty() {
        schema["not"] = json!({ "anyOf": excluded });
    }
}

fn of_kind(kind: &'static Kind, definitions: &mut Map<String, Value>) -> Value {
    match kind {
        Kind::Text(what) => json!({ "title": what, "type": "string", "pattern": r"\S" }),
        Kind::Boolean => json!({ "type": "boolean" }),
        Kind::Integer(least, most) => json!({ "type": "integer", "minimum": least, "maximum": most }),
        Kind::Number(bounds) => number(*bounds),
        Kind::NumberIn(unit, bounds) => {
            let unit: String =
                unit.chars().map(|c| if "()^".contains(c) { format!("\\{c}") } else { c.into() }).collect();
            json!({ "anyOf": [number(*bounds), text(&format!(r"[+-]?{NUMBER}\s*{unit}"))] })
        }
        Kind::Temperature => text(&format!(r"[+-]?{NUMBER} (degC|K|degF)")),
        Kind::Words(words) => json!({ "enum": words() }),
        Kind::Unit(dimension) => text(&dimension.unit_pattern()),
        Kind::Quantity(dimension, bounds) => {
            let (name, schema) = quantity(*dimension, *bounds);
            defined(&name, definitions, |_| schema)
        }
        Kind::Table(keys) => defined(keys.name, definitions, |definitions| table(keys, definitions)),
        Kind::List(entry) => json!({ "type": "array", "items": of_kind(entry, definitions) }),
        Kind::Tuple(entries) => {
            let schemas: Vec<Value> = entries.iter().map(|entry| of_kind(entry, definitions)).collect();
            json!({ "type": "array", "prefixItems": schemas, "minItems": entries.len(), "maxItems": entries.len() })
        }
        Kind::Either(kinds) => {
            json!({ "anyOf": kinds.iter().map(|kind| of_kind(kind, definitions)).collect::<Vec<_>>() })
        }
    }
}

/// Returns a reference to a definition, which is added where it is absent.
fn defined(
    name: &str,
    definitions: &mut Map<String, Value>,
    schema: impl FnOnce(&mut Map<String, Value>) -> Value,
) -> Value {
    if !definitions.contains_key(name) {
        let schema = schema(definitions);
        definitions.insert(name.to_owned(), schema);
    }
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// Returns name and schema of a number in SI or a text with number and unit.
fn quantity(dimension: Dimension, bounds: Bounds) -> (String, Value) {
    let (sign, range) = match bounds.0 {
        Bound::Unbounded => ("[+-]?", ""),
        Bound::Included(_) => (r"\+?", "of 0 or more"),
        Bound::Excluded(_) => (r"\+?", "above 0"),
    };
    let mut bare = number(bounds);
    if let Some((limit, _)) = dimension.bare_limit() {
        bare["maximum"] = json!(limit);
        if bounds.0 == Bound::Unbounded {
            bare["minimum"] = json!(-limit);
        }
    }
    let (unit, expected) = match dimension {
        Dimension::ContactStiffness(_) => {
            ("N/m^n".to_owned(), "a contact stiffness, such as \"1.2e10 N/m^1.5\"".to_owned())
        }
        _ => (dimension.si_unit(), dimension.expected(range)),
    };
    let schema = json!({
        "description": format!("{}; a number is in {unit}.", capitalised(&expected)),
        "anyOf": [bare, text(&format!(r"{sign}{NUMBER}\s*{}", dimension.unit_pattern()))],
    });
    (format!("{} {range}", dimension.name()).trim().replace(' ', "-"), schema)
}

fn number((least, most): Bounds) -> Value {
    let mut schema = json!({ "type": "number" });
    for (bound, including, excluding) in [(least, "minimum", "exclusiveMinimum"), (most, "maximum", "exclusiveMaximum")]
    {
        match bound {
            Bound::Included(x) => schema[including] = json!(x),
            Bound::Excluded(x) => schema[excluding] = json!(x),
            Bound::Unbounded => {}
        }
    }
    schema
}

/// Returns the schema of a text that matches a pattern, with spaces around it.
fn text(pattern: &str) -> Value {
    json!({ "type": "string", "pattern": format!(r"^\s*{pattern}\s*$") })
}

/// Returns the text with a capital letter at its start.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns Markdown with the texts of its links in their place.
fn without_links(text: &str) -> String {
    let mut parts = text.split("](");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |mut all, part| {
        if let Some(at) = all.rfind('[') {
            all.remove(at);
        }
        all + part.split_once(')').map_or("", |(_, rest)| rest)
    })
}
