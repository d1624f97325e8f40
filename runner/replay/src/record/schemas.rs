//! The JSON schemas in `docs/schema` are those of the types. `BALLRACE_WRITE=1` writes them.
#![expect(clippy::panic, reason = "a test fails by panicking")]

use super::{EventRecord, SecondRecord};
use ballrace_outcome::Outcome;
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Allows `null` for numbers, as which JSON has those that are not finite, and rejects unknown keys.
#[derive(Clone)]
struct Strict;

impl Transform for Strict {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        let is_object = schema.get("properties").is_some();
        let has_parts = schema.get("allOf").is_some() || schema.get("anyOf").is_some() || schema.get("$ref").is_some();
        match schema.get("type") {
            Some(Value::String(kind)) if kind == "number" => {
                schema.insert("type".to_owned(), json!(["number", "null"]));
            }
            _ if is_object && has_parts => {
                schema.insert("unevaluatedProperties".to_owned(), Value::Bool(false));
            }
            _ if is_object => {
                schema.insert("additionalProperties".to_owned(), Value::Bool(false));
            }
            _ => {}
        }
    }
}

fn schema<T: JsonSchema>() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().with_transform(Strict).into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    // The tag of a structure, which the generator leaves out, is the name of its type.
    let id = schema["title"].clone();
    schema["properties"]["schema"] = json!({ "const": id, "description": "Version of this schema." });
    schema["required"].as_array_mut().into_iter().for_each(|required| required.insert(0, json!("schema")));
    schema
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema").join(format!("{name}.schema.json"))
}

#[test]
fn the_published_schemas_are_those_of_the_types() {
    let all = [
        ("outcome", schema::<Outcome>()),
        ("event", schema::<EventRecord>()),
        ("second", schema::<SecondRecord<'static>>()),
    ];
    for (name, schema) in all {
        let id = schema["properties"]["schema"]["const"].as_str().unwrap_or_else(|| panic!("no version: {schema:#}"));
        assert!(id.starts_with(&format!("ballrace-{name}-")), "{id}");
        let text = format!("{schema:#}\n");
        let file = file(name);
        if std::env::var_os("BALLRACE_WRITE").is_some() {
            std::fs::write(&file, &text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        }
        let published = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let place = published.lines().zip(text.lines()).position(|(a, b)| a != b);
        assert!(published == text, "{} is not that of the type from line {place:?}", file.display());
    }
}
