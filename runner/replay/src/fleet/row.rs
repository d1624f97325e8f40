//! One row of the table of outcomes.

use ballrace_outcome::{FaultForm, FaultKind};
use ballrace_recording::Time;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};

/// State of a machine by one recording, worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// A limit of the scene was crossed; exit code 3 of `replay`.
    Limit,
    /// A fault is diagnosed.
    #[serde(alias = "finding")]
    Fault,
    /// The recording is not plausible for the scene; exit code 4 of `replay`.
    Implausible,
    /// Scene, recording or baseline cannot be used.
    Error,
    /// The recording allows no verdict, such as that of a shaft at standstill.
    NotJudged,
    /// No limit is crossed and no fault is diagnosed.
    Normal,
}

impl State {
    /// All states, worst first.
    pub const ALL: [Self; 6] =
        [Self::Limit, Self::Fault, Self::Implausible, Self::Error, Self::NotJudged, Self::Normal];

    /// Returns its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Fault => "fault",
            Self::Implausible => "implausible",
            Self::Error => "error",
            Self::NotJudged => "not-judged",
            Self::Normal => "normal",
        }
    }
}

impl Display for State {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Key of a row.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// Name of the machine.
    pub machine: String,
    /// Recording as the table names it; empty where it is that of the scene.
    pub recording: String,
}

/// Diagnosis of a fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiagnosisRow {
    /// Kind of fault.
    pub fault: FaultKind,
    /// Form of a surface fault.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<FaultForm>,
    /// Bearing, where the fault has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Size in `size_unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// Lower end of the 95 % interval of the size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_low: Option<f64>,
    /// Upper end of the interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_high: Option<f64>,
    /// Unit of the size: um, mrad or g mm; empty without a size.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub size_unit: String,
    /// Level of the evidence, as [`Diagnosis::level_db`](ballrace_outcome::Diagnosis::level_db).
    pub level_db: f64,
    /// Confidence, 0 to 1.
    pub confidence: f64,
    /// The diagnosis as a sentence.
    pub sentence: String,
}

/// Value of an indicator.
///
/// With a limit it is the largest value of a block of 16 revolutions, which is compared with the limit, otherwise that of
/// the whole recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndicatorValue {
    /// Name, as `indicator` of a limit in a scene.
    pub name: String,
    /// Unit: um, or empty for a dimensionless value.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Column of the probe or sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe: Option<String>,
    /// Bearing, for the line of a race.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// The value.
    pub value: f64,
    /// Limit of the scene, the lowest where it has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// True where the limit was crossed, for at least its duration.
    #[serde(default)]
    pub crossed: bool,
}

impl IndicatorValue {
    /// Returns value over limit.
    #[must_use]
    pub fn utilisation(&self) -> Option<f64> {
        self.limit.map(|limit| self.value / limit)
    }

    /// Returns the name with bearing and probe, such as `outer-race of DE at DE_X`.
    #[must_use]
    pub fn label(&self) -> String {
        let bearing = self.bearing.as_ref().map_or_else(String::new, |bearing| format!(" of {bearing}"));
        let probe = self.probe.as_ref().map_or_else(String::new, |probe| format!(" at {probe}"));
        format!("{}{bearing}{probe}", self.name)
    }
}

/// Outcome of one machine by one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the machine.
    pub machine: String,
    /// Recording as the table of machines names it; empty where it is that of the scene.
    pub recording: String,
    /// Time of the recording.
    pub time: Option<Time>,
    /// State.
    pub state: State,
    /// Verdict as a sentence; empty where there is an error instead.
    pub verdict: String,
    /// Diagnoses, strongest first.
    pub diagnoses: Vec<DiagnosisRow>,
    /// Indicators of each probe.
    pub indicators: Vec<IndicatorValue>,
    /// Further columns of the table of machines.
    pub tags: BTreeMap<String, String>,
    /// Reason why there is no outcome.
    pub error: Option<String>,
    /// Duration of the recording.
    pub duration_s: Option<f64>,
    /// Mean shaft speed.
    pub mean_speed_rpm: Option<f64>,
    /// Fingerprint of the inputs: of the row of the table, and of size and modification time of its files.
    pub inputs: String,
}

impl Row {
    /// Returns the key of the row.
    #[must_use]
    pub fn key(&self) -> Key {
        Key { machine: self.machine.clone(), recording: self.recording.clone() }
    }

    /// Returns the indicator with the largest value over its limit, a crossed one first; `None` without limits.
    #[must_use]
    pub fn worst_indicator(&self) -> Option<&IndicatorValue> {
        let limited = self.indicators.iter().filter(|one| one.limit.is_some());
        limited.max_by(|a, b| {
            let share = |one: &IndicatorValue| one.utilisation().unwrap_or(0.0);
            a.crossed.cmp(&b.crossed).then(share(a).total_cmp(&share(b)))
        })
    }
}

impl DiagnosisRow {
    /// Returns the name of the fault with its form, such as `outer-race spall`.
    #[must_use]
    pub fn name(&self) -> String {
        let fault = self.fault.key();
        match self.form {
            Some(FaultForm::Spall) => format!("{fault} spall"),
            Some(FaultForm::Waviness) => format!("{fault} waviness"),
            None => fault.to_owned(),
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
pub(super) mod tests {
    use super::*;

    pub fn row(machine: &str, state: State) -> Row {
        Row {
            machine: machine.to_owned(),
            recording: String::new(),
            time: None,
            state,
            verdict: String::new(),
            diagnoses: vec![],
            indicators: vec![],
            tags: BTreeMap::new(),
            error: None,
            duration_s: Some(1.0),
            mean_speed_rpm: None,
            inputs: String::new(),
        }
    }

    /// A row with an indicator of this value and a limit of 1 um.
    pub fn limited(machine: &str, value: f64) -> Row {
        let crossed = value > 1.0;
        let (name, unit, probe) = ("1X".to_owned(), "um".to_owned(), Some("DE_X".to_owned()));
        let indicator = IndicatorValue { name, unit, probe, bearing: None, value, limit: Some(1.0), crossed };
        Row { indicators: vec![indicator], ..row(machine, if crossed { State::Limit } else { State::Normal }) }
    }

    pub(crate) fn with_diagnosis(machine: &str, level_db: f64) -> Row {
        let diagnosis = DiagnosisRow {
            fault: FaultKind::OuterRace,
            form: Some(FaultForm::Spall),
            bearing: Some("DE".to_owned()),
            size: Some(level_db / 10.0),
            size_low: None,
            size_high: None,
            size_unit: "um".to_owned(),
            level_db,
            confidence: 1.0,
            sentence: "Damage of the outer race of DE.".to_owned(),
        };
        Row { diagnoses: vec![diagnosis], ..row(machine, State::Fault) }
    }

    #[test]
    fn rows_of_a_former_version_are_read() {
        let stored = serde_json::to_string(&row("fan", State::Fault)).unwrap().replace("\"fault\"", "\"finding\"");
        assert_eq!(serde_json::from_str::<Row>(&stored).unwrap().state, State::Fault);
    }
}
