//! The JSON schemas in `docs/schema` are those of the types. `BALLRACE_WRITE=1` writes them.
#![expect(clippy::panic, reason = "a test fails by panicking")]

use super::{EventRecord, SecondRecord};
use crate::second::{BearingSecond, ProbeSecond, Second, SensorSecond};
use ballrace_outcome::{
    BallPassLine, BearingOrders, FaultParameters, ForceFigures, LifeOutcome, Motion, NumericField, Outcome,
    PlaneOutcome, ProbeOutcome, SimplePredictors, SnapshotFigures, TabularList,
};
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

/// Types whose numbers have no table of fields: in sentences, which text and page share.
const IN_SENTENCES: &str = "BearingOutcome Event FlawSummary Learning LearnedParameter LineLevel Observation OutputFigures \
    Quantiles ReadingOutcome Record RotorOutcome SensorOutcome SnapshotTrend SourceFigures SpectraSettings StageTimes Timing TwinSpread \
    UnexplainedLine UnexplainedMotion VibrationLine";

/// The same: in JSON alone, or value of a field.
const IN_JSON: &str = "CageOutcome DiagnosisOutcome Estimate ObserverOutcome Occurrence RecordingFile SimplePredictor \
    SnapshotOutcome";

/// Numbers beside the fields of their type: counts, values without an interval, digits of their own.
const WITHOUT_FIELD: [(&str, &str); 2] = [
    (
        "Diagnosis",
        "confidence element explained force_direction_deg force_n level_db line_hz load_n log_likelihood_gain odds_to_next \
         order waviness_order",
    ),
    ("ForceFigures", "noise_sigma"),
];

fn keys<T, V>(fields: impl IntoIterator<Item = NumericField<T, V>>) -> Vec<&'static str> {
    fields.into_iter().map(|field| field.key).collect()
}

/// Returns the keys of the tables of fields by the name of the type in a schema.
fn tables() -> Vec<(&'static str, Vec<&'static str>)> {
    let probe = ProbeOutcome::PLACE.into_iter().chain(ProbeOutcome::RESIDUAL).chain([ProbeOutcome::NOISE]);
    vec![
        ("BallPassLine", keys(BallPassLine::FIELDS)),
        ("BearingOrders", keys(BearingOrders::FIELDS)),
        ("BearingSecond", keys(BearingSecond::FIELDS)),
        ("Diagnosis", keys(FaultParameters::FIELDS.map(|(_, field)| field))),
        ("ForceFigures", keys(ForceFigures::FIELDS)),
        ("LifeOutcome", keys(LifeOutcome::FIELDS)),
        ("Motion", keys(Motion::FIELDS)),
        ("PlaneOutcome", keys(PlaneOutcome::FIELDS)),
        ("ProbeOutcome", keys(probe)),
        ("ProbeSecond", keys(ProbeSecond::FIELDS)),
        ("SensorSecond", keys(SensorSecond::FIELDS)),
        ("SimplePredictors", keys(SimplePredictors::FIELDS)),
        ("SnapshotFigures", keys(SnapshotFigures::FIELDS)),
        ("TabularList", keys(TabularList::FIELDS)),
        ("ballrace-second-1", keys(Second::FIELDS)),
    ]
}

/// Returns the names of the numbers of each type with numbers.
fn numbers(schema: &Value) -> Vec<(String, Vec<String>)> {
    let root = schema["title"].as_str().unwrap_or_default().to_owned();
    let definitions = schema["$defs"].as_object().into_iter().flatten().map(|(name, of)| (name.clone(), of));
    let is_number = |of: &Value| {
        let text = of.to_string();
        ["\"number\"", "\"integer\"", "/Estimate\"", "/SimplePredictor\""].iter().any(|kind| text.contains(kind))
    };
    let names = |of: &Value| {
        let properties = of["properties"].as_object().into_iter().flatten();
        let mut names: Vec<String> = properties.filter(|(_, of)| is_number(of)).map(|(name, _)| name.clone()).collect();
        names.sort_unstable();
        names
    };
    let all = definitions.chain([(root, schema)]).map(|(name, of)| (name, names(of)));
    all.filter(|(_, names)| !names.is_empty()).collect()
}

/// Each number of the outcome and of a second has a field, or a reason why it has none; a field has the key of its number.
#[test]
fn every_number_is_a_field() {
    let tables = tables();
    for (name, numbers) in [schema::<Outcome>(), schema::<SecondRecord<'static>>()].iter().flat_map(numbers) {
        let Some((_, keys)) = tables.iter().find(|(known, _)| *known == name) else {
            let mut known = [IN_SENTENCES, IN_JSON].into_iter().flat_map(str::split_whitespace);
            assert!(known.any(|known| known == name), "{name} has no table of fields");
            continue;
        };
        let others = WITHOUT_FIELD.iter().filter(|(known, _)| *known == name);
        let mut known = keys.clone();
        known.extend(others.flat_map(|(_, others)| others.split_whitespace()));
        known.sort_unstable();
        assert_eq!(numbers, known, "{name}");
    }
}

/// Returns the rows of `live.md` with the columns of the indicator files and the metrics, each with its start.
fn rows_of_live() -> Vec<(String, String)> {
    let [probe, bearing, sensor] = [keys(ProbeSecond::FIELDS), keys(BearingSecond::FIELDS), keys(SensorSecond::FIELDS)];
    let row = |before: &str, keys: &[&str], of: &str| {
        let names: Vec<String> = keys.iter().map(|key| format!("`{before}{key}`")).collect();
        (format!("| {}", names[0]), format!("| {} |{of} |", names.join(", ")))
    };
    vec![
        row("PROBE_", &probe, " probe"),
        row("BEARING_", &bearing, " bearing"),
        row("SENSOR_", &sensor, " vibration sensor"),
        row("ballrace_", &keys(Second::FIELDS), ""),
        row("ballrace_probe_", &probe, " `probe`"),
        row("ballrace_sensor_", &sensor, " `sensor`, `unit`"),
        row("ballrace_bearing_", &bearing, " `bearing`"),
    ]
}

/// The documents name the numbers of a second and of a diagnosis. `BALLRACE_WRITE=1` writes the rows of a second.
#[test]
fn documents_name_the_fields() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
    let read = |file: &Path| std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let file = folder.join("live.md");
    let (live, rows) = (read(&file), rows_of_live());
    let line =
        |text: &str| rows.iter().find(|(start, _)| text.starts_with(start)).map_or(text, |(_, row)| row).to_owned();
    let written: String = live.lines().map(|text| line(text) + "\n").collect();
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(&file, &written).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    }
    assert_eq!(read(&file), written, "rows of {}", file.display());
    for (_, row) in &rows {
        assert!(written.contains(row), "{} lacks {row}", file.display());
    }
    let diagnosis = read(&folder.join("diagnosis.md"));
    let numbers = numbers(&schema::<Outcome>());
    let of_diagnosis = numbers.iter().filter(|(name, _)| name == "Diagnosis").flat_map(|(_, numbers)| numbers);
    let absent: Vec<&String> = of_diagnosis.filter(|name| !diagnosis.contains(&format!("`{name}`"))).collect();
    assert!(absent.is_empty(), "diagnosis.md lacks {absent:?}");
}
