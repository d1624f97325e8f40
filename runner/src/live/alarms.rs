//! Alarms of a monitor: limits that are exceeded and faults that are found, until they have ended and are acknowledged
//! (IEC 62682).

use ballrace_report as report;
use ballrace_twin::outcome::{Diagnosis, Event};
use ballrace_twin::record::now;
use ballrace_twin::replay::limits::LimitStatus;
use serde::{Deserialize, Serialize};

/// An alarm.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alarm {
    /// Identifier: the limit or the fault.
    pub id: String,
    /// The limit or the fault in a few words.
    pub title: String,
    /// Description for users.
    pub sentence: String,
    /// Recommended action.
    pub action: String,
    /// Time of day at which it was raised, RFC 3339 in UTC.
    pub raised_at: String,
    /// Time of day at which it ended; none of an active alarm.
    pub ended_at: Option<String>,
    /// Time of day at which a user acknowledged it.
    pub acknowledged_at: Option<String>,
}

impl Alarm {
    /// Returns `true` while its limit is exceeded or its fault is found.
    #[must_use]
    pub const fn is_active(&self) -> bool {
        self.ended_at.is_none()
    }

    /// Returns `true` until a user acknowledges it.
    #[must_use]
    pub const fn is_unacknowledged(&self) -> bool {
        self.acknowledged_at.is_none()
    }
}

/// Alarms that are active or not acknowledged, oldest first.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct AlarmList(Vec<Alarm>);

/// Start of the identifier of a limit's alarm.
const LIMIT: &str = "limit";
/// Start of the identifier of a fault's alarm.
const FAULT: &str = "fault";

impl AlarmList {
    /// Returns the alarms.
    #[must_use]
    pub fn alarms(&self) -> &[Alarm] {
        &self.0
    }

    /// Raises or ends the alarm of a limit.
    pub fn limit_event(&mut self, event: &Event, sentence: &str) {
        let id = limit_id(event.indicator, event.bearing.as_deref(), &event.probe);
        self.raise(id.clone(), &limit_title(&id), sentence, report::EVENT_ACTION);
        if event.end_s.is_some() {
            self.end(|alarm| alarm.id == id);
        }
    }

    /// Compares the alarms with the limits of a restarted monitor: alarms of limits that are not exceeded end, and limits
    /// that are exceeded without an alarm raise one.
    pub fn restore_limits(&mut self, limits: &[LimitStatus]) {
        let exceeded = || limits.iter().filter(|limit| limit.exceeded_since_s.is_some());
        let id = |limit: &LimitStatus| limit_id(limit.indicator, limit.bearing.as_deref(), &limit.probe);
        let ids: Vec<String> = exceeded().map(id).collect();
        self.end(|alarm| alarm.id.starts_with(LIMIT) && !ids.contains(&alarm.id));
        for (limit, id) in exceeded().zip(ids.clone()) {
            let LimitStatus { indicator, probe, limit, unit, .. } = limit;
            let sentence = format!("Limit crossed: {indicator} at {probe}, limit {limit:.3} {unit}");
            if !self.0.iter().any(|alarm| alarm.id == id) {
                let title = limit_title(&id);
                self.raise(id, &title, sentence.trim_end(), report::EVENT_ACTION);
            }
        }
    }

    /// Raises the alarms of the present faults and ends those of faults that are no longer found.
    pub fn update_faults(&mut self, diagnoses: &[Diagnosis]) {
        let ids: Vec<String> = diagnoses.iter().map(fault_id).collect();
        for (diagnosis, id) in diagnoses.iter().zip(&ids) {
            let [title, _] = report::diagnosis(diagnosis);
            self.raise(id.clone(), &title, &diagnosis.sentence, diagnosis.action());
        }
        self.end(|alarm| alarm.id.starts_with(FAULT) && !ids.contains(&alarm.id));
    }

    /// Acknowledges an alarm; returns its sentence, or `None` if there is no such alarm or it is acknowledged already.
    pub fn acknowledge(&mut self, id: &str) -> Option<String> {
        let alarm = self.0.iter_mut().find(|alarm| alarm.id == id && alarm.is_unacknowledged())?;
        alarm.acknowledged_at = Some(now());
        let sentence = alarm.sentence.clone();
        self.remove_finished();
        Some(sentence)
    }

    /// Raises an alarm. An active alarm gets the new sentence; it stays acknowledged.
    fn raise(&mut self, id: String, title: &str, sentence: &str, action: &str) {
        if let Some(alarm) = self.0.iter_mut().find(|alarm| alarm.id == id && alarm.is_active()) {
            sentence.clone_into(&mut alarm.sentence);
            return;
        }
        self.0.retain(|alarm| alarm.id != id);
        let [title, sentence, action] = [title, sentence, action].map(str::to_owned);
        self.0.push(Alarm { id, title, sentence, action, raised_at: now(), ..Alarm::default() });
    }

    fn end(&mut self, has_ended: impl Fn(&Alarm) -> bool) {
        for alarm in self.0.iter_mut().filter(|alarm| alarm.is_active() && has_ended(alarm)) {
            alarm.ended_at = Some(now());
        }
        self.remove_finished();
    }

    fn remove_finished(&mut self) {
        self.0.retain(|alarm| alarm.is_active() || alarm.is_unacknowledged());
    }
}

fn limit_id(indicator: &str, bearing: Option<&str>, probe: &str) -> String {
    match bearing {
        Some(bearing) => format!("{LIMIT} {indicator} of {bearing} at {probe}"),
        None => format!("{LIMIT} {indicator} at {probe}"),
    }
}

/// Returns the title of a limit's alarm.
fn limit_title(id: &str) -> String {
    format!("Above its limit: {}", id.strip_prefix(LIMIT).unwrap_or(id).trim_start())
}

/// Returns the identifier of a fault, which does not depend on its size.
fn fault_id(diagnosis: &Diagnosis) -> String {
    let name = |value: Result<serde_json::Value, _>| match value {
        Ok(serde_json::Value::String(name)) => Some(name),
        _ => None,
    };
    let form = diagnosis.parameters.form.and_then(|form| name(serde_json::to_value(form)));
    let kind = name(serde_json::to_value(diagnosis.kind));
    let parts = [Some(FAULT.to_owned()), form, kind, diagnosis.bearing.as_ref().map(|bearing| format!("of {bearing}"))];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn event(probe: &str, end_s: Option<f64>) -> Event {
        Event {
            indicator: "rms",
            probe: probe.to_owned(),
            bearing: None,
            start_s: 1.0,
            end_s,
            worst: 2.0,
            worst_s: 1.0,
            limit: 1.0,
            unit: "um",
            sentence: String::new(),
        }
    }

    fn status(exceeded_since_s: Option<f64>) -> LimitStatus {
        LimitStatus {
            indicator: "rms",
            probe: "X".to_owned(),
            bearing: None,
            unit: "um",
            value: Some(2.0),
            limit: 1.0,
            exceeded_since_s,
        }
    }

    #[test]
    fn an_alarm_stays_until_it_has_ended_and_is_acknowledged() {
        let mut alarms = AlarmList::default();
        alarms.limit_event(&event("X", None), "X is high.");
        alarms.limit_event(&event("Y", None), "Y is high.");
        assert_eq!(alarms.acknowledge("limit rms at X").as_deref(), Some("X is high."));
        assert_eq!(alarms.acknowledge("limit rms at X"), None);
        assert_eq!(alarms.acknowledge("limit rms at Z"), None);
        // The acknowledged one disappears at its end, the other one when it is acknowledged.
        for probe in ["X", "Y"] {
            alarms.limit_event(&event(probe, Some(2.0)), "ended");
        }
        let ids: Vec<&str> = alarms.alarms().iter().map(|alarm| alarm.id.as_str()).collect();
        assert_eq!(ids, ["limit rms at Y"]);
        assert!(alarms.acknowledge("limit rms at Y").is_some() && alarms.alarms().is_empty());
    }

    #[test]
    fn an_alarm_that_returns_has_to_be_acknowledged_again() {
        let mut alarms = AlarmList::default();
        for _ in 0..2 {
            alarms.limit_event(&event("X", None), "high");
            assert!(alarms.acknowledge("limit rms at X").is_some());
            alarms.limit_event(&event("X", Some(2.0)), "ended");
        }
        assert!(alarms.alarms().is_empty());
    }

    #[test]
    fn a_restart_keeps_the_acknowledgement_of_a_limit_that_is_still_exceeded() {
        let mut alarms = AlarmList::default();
        alarms.limit_event(&event("X", None), "high");
        alarms.acknowledge("limit rms at X").unwrap();
        let text = serde_json::to_string(&alarms).unwrap();
        let mut restored: AlarmList = serde_json::from_str(&text).unwrap();
        restored.restore_limits(&[status(Some(1.0))]);
        assert_eq!(restored, alarms);
        restored.restore_limits(&[status(None)]);
        assert!(restored.alarms().is_empty());
        // A state without alarms.
        restored.restore_limits(&[status(Some(1.0))]);
        assert_eq!(restored.alarms()[0].id, "limit rms at X");
    }
}
