//! Events of a monitor.

use ballrace_outcome::Event;
use serde::Serialize;
use std::time::SystemTime;

/// Kind and text of an event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EventMessage {
    /// Identifier for programs, such as `source-connected`.
    pub kind: &'static str,
    /// Description for users.
    pub sentence: String,
}

/// Event with its times, as in the log and in MQTT messages. The tag is the version of its JSON schema.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "schema", rename = "ballrace-event-1")]
pub struct EventRecord {
    /// Time of day, RFC 3339 in UTC.
    pub at: String,
    /// Time of the recording, s.
    pub time_s: f64,
    /// Identifier for programs, such as `limit-crossed`.
    pub kind: &'static str,
    /// Description for users.
    pub sentence: String,
    /// Details of an exceeded limit.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub limit: Option<Event>,
    /// Identifier of the alarm that a user acknowledged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<String>,
}

impl EventRecord {
    /// Creates the record of an exceeded limit.
    #[must_use]
    pub fn limit(mut event: Event) -> Self {
        let kind = if event.end_s.is_some() { "limit-ended" } else { "limit-crossed" };
        let time_s = event.end_s.unwrap_or(event.start_s);
        // The flattened event must not repeat the key `sentence`.
        let sentence = std::mem::take(&mut event.sentence);
        Self { at: now(), time_s, kind, sentence, limit: Some(event), alarm: None }
    }

    /// Creates the record of an event of the source, an output or the monitor.
    #[must_use]
    pub fn new(message: EventMessage, time_s: f64) -> Self {
        Self { at: now(), time_s, kind: message.kind, sentence: message.sentence, limit: None, alarm: None }
    }

    /// Creates the record of an acknowledged alarm.
    #[must_use]
    pub fn acknowledgement(alarm: String, alarm_sentence: &str, time_s: f64) -> Self {
        let sentence = format!("Acknowledged: {alarm_sentence}");
        Self { alarm: Some(alarm), ..Self::new(EventMessage { kind: "alarm-acknowledged", sentence }, time_s) }
    }

    /// Returns `true` for an event that changes the monitor's state: a limit, a fault or an acknowledgement.
    #[must_use]
    pub fn changes_state(&self) -> bool {
        self.limit.is_some() || self.alarm.is_some() || self.kind.starts_with("fault-")
    }
}

/// Returns the time of day, RFC 3339 in UTC.
#[must_use]
pub fn now() -> String {
    humantime::format_rfc3339_millis(SystemTime::now()).to_string()
}
