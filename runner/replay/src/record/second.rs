//! Indicators of one second with their time of day, as messages and as rows.

use crate::second::{Second, SecondFigure};
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
        let mut columns: Vec<(ColumnName, f64)> = vec![];
        let mut add = |owner: &str, figures: &[SecondFigure], unit: Option<&str>| {
            columns.extend(figures.iter().map(|figure| {
                let name = if owner.is_empty() { figure.name.to_owned() } else { format!("{owner}_{}", figure.name) };
                let unit = unit.filter(|_| matches!(figure.name, "rms" | "peak")).map(str::to_owned);
                (ColumnName { name, unit }, figure.value)
            }));
        };
        add("", &second.figures(), None);
        let since_1970 = self.at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let at = SecondFigure { name: TIME_OF_DAY, help: "Time of day.", value: since_1970.as_millis() as f64 };
        add("", &[at], None);
        second.probes.iter().for_each(|probe| add(&probe.name, &probe.figures(), None));
        second.bearings.iter().for_each(|bearing| add(&bearing.name, &bearing.figures(), None));
        second.sensors.iter().for_each(|sensor| add(&sensor.name, &sensor.figures(), Some(&sensor.unit)));
        columns.into_iter().unzip()
    }
}
