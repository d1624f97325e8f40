//! State of the machine as JSON for the page.

use super::HttpOptions;
use crate::live::address::Address;
use crate::live::alarms::Alarm;
use crate::live::status::Status;
use crate::live::view::{MonitorState, View};
use ballrace_report as report;
use ballrace_twin::outcome::SourceFigures;
use ballrace_twin::record::{EventRecord, now};
use ballrace_twin::replay::limits::LimitStatus;
use ballrace_twin::replay::second::Second;
use ballrace_twin::scene::Scene;
use serde::Serialize;
use std::sync::Arc;

/// Number of events on the page.
const MAX_EVENTS: usize = 20;

/// Data that do not change during a run.
#[derive(Serialize)]
pub struct Description {
    machine: String,
    source: String,
    version: &'static str,
    can_acknowledge: bool,
    also: Vec<String>,
}

#[derive(Serialize)]
struct State<'a> {
    #[serde(flatten)]
    description: &'a Description,
    /// Time of day at which the state was written.
    at: String,
    time_s: f64,
    monitor: MonitorState,
    starting_s: f64,
    status: Status,
    alarms: &'a [Alarm],
    limits: &'a [LimitStatus],
    diagnoses: Vec<DiagnosisText>,
    second: Option<&'a Second>,
    events: Vec<&'a EventRecord>,
    counts: &'a SourceFigures,
    deadline_misses: u64,
}

/// A diagnosis in words.
#[derive(Serialize)]
struct DiagnosisText {
    title: String,
    details: String,
    action: &'static str,
}

impl Description {
    /// Creates the description of a monitor.
    pub fn new(scene: &Scene, source: &Address, http: &HttpOptions, can_acknowledge: bool) -> Self {
        Self {
            machine: scene.name.clone(),
            source: source.to_string(),
            version: env!("CARGO_PKG_VERSION"),
            can_acknowledge,
            also: http.also.clone(),
        }
    }

    /// Returns the state as JSON without line breaks.
    pub fn state(&self, view: &View) -> String {
        let diagnoses = view.diagnoses.iter().map(|diagnosis| {
            let [title, details] = report::diagnosis(diagnosis);
            DiagnosisText { title, details, action: diagnosis.action() }
        });
        let state = State {
            description: self,
            at: now(),
            time_s: view.time_s,
            monitor: view.state,
            starting_s: view.pacing.starting_s,
            status: Status::of(view),
            alarms: view.alarms.alarms(),
            limits: &view.limits,
            diagnoses: diagnoses.collect(),
            second: view.seconds.back().map(Arc::as_ref),
            events: view.events.iter().rev().take(MAX_EVENTS).map(Arc::as_ref).collect(),
            counts: &view.source,
            deadline_misses: view.pacing.deadline_misses,
        };
        // The serialisation does not fail: numbers that are not finite become null.
        serde_json::to_string(&state).unwrap_or_default()
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_one_line_of_json_whatever_the_names() {
        let description = Description {
            machine: "<b>\n\"rig\"".to_owned(),
            source: "tcp:1".to_owned(),
            version: "1",
            can_acknowledge: false,
            also: vec![],
        };
        let mut view = View::default();
        view.add_second(&Second { time_s: f64::NAN, ..Second::default() });
        let text = description.state(&view);
        assert!(!text.contains('\n'), "{text}");
        let state: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(state["machine"], "<b>\n\"rig\"");
        assert_eq!((&state["status"]["word"], &state["monitor"]), (&"NO DATA".into(), &"waiting".into()));
        assert!(state["second"]["time_s"].is_null());
    }
}
