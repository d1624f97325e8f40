//! Indicators of one second with their time of day, as messages and as rows.

use crate::second::{BearingSecond, ProbeSecond, Second, SensorSecond};
use ballrace_outcome::{NumericField, UNIT_OF_SENSOR};
use serde::{Serialize, Serializer};
use std::time::{SystemTime, UNIX_EPOCH};

/// Second with the time of day at which it was evaluated, as in MQTT messages. The tag is the version of its JSON schema.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "schema", rename = "ballrace-second-1")]
pub struct SecondRecord<'a> {
    /// Time of day, RFC 3339 in UTC.
    #[serde(serialize_with = "rfc3339")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub at: SystemTime,
    /// Indicators.
    #[serde(flatten)]
    pub second: &'a Second,
}

fn rfc3339<S: Serializer>(at: &SystemTime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&humantime::format_rfc3339_millis(*at))
}

/// Name of the column with the time of day.
pub const TIME_OF_DAY: &str = "at";

/// Column of the indicator files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnName {
    /// Name.
    pub name: String,
    /// Unit, where it is not the end of the name.
    pub unit: Option<String>,
}

impl SecondRecord<'_> {
    /// Returns the names and the values of the columns: figures of the machine, time of day in ms since 1970, then the figures of
    /// each probe, bearing and sensor.
    #[must_use]
    pub fn columns(&self) -> (Vec<ColumnName>, Vec<f64>) {
        let second = self.second;
        let since_1970 = self.at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let at = ColumnName { name: TIME_OF_DAY.to_owned(), unit: None };
        let mut columns = columns_of("", second, &Second::FIELDS, "");
        columns.push((at, since_1970.as_millis() as f64));
        columns.extend(second.probes.iter().flat_map(|of| columns_of(&of.name, of, &ProbeSecond::FIELDS, "")));
        columns.extend(second.bearings.iter().flat_map(|of| columns_of(&of.name, of, &BearingSecond::FIELDS, "")));
        columns.extend(second.sensors.iter().flat_map(|of| columns_of(&of.name, of, &SensorSecond::FIELDS, &of.unit)));
        columns.into_iter().unzip()
    }
}

/// Returns names and values of the columns of one object; fields in the unit of a sensor have `sensor_unit`.
fn columns_of<T>(owner: &str, of: &T, fields: &[NumericField<T>], sensor_unit: &str) -> Vec<(ColumnName, f64)> {
    let column = |field: &NumericField<T>| {
        let name = if owner.is_empty() { field.key.to_owned() } else { format!("{owner}_{}", field.key) };
        let unit = (field.unit == UNIT_OF_SENSOR).then(|| sensor_unit.to_owned());
        (ColumnName { name, unit }, (field.value)(of))
    };
    fields.iter().map(column).collect()
}
