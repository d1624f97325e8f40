//! State of the machine in one word and one sentence, for the terminal and the live page.

use super::view::{MonitorState, View};
use ballrace_twin::replay::DiagnosisState;
use ballrace_twin::replay::outcome::Diagnosis;
use serde::Serialize;

/// Urgency of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// A limit is exceeded or a fault is found.
    Alarm,
    /// The state requires the attention of a user.
    Warning,
    /// No verdict is possible yet.
    Unknown,
    /// No action is required.
    Normal,
}

/// State of the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Status {
    /// One or two words.
    pub word: &'static str,
    /// Urgency.
    pub level: Level,
    /// The most urgent alarm in a few words, with the number of others; empty without an alarm.
    pub title: String,
    /// Diagnosis as a sentence.
    pub sentence: String,
    /// Recommended action; empty where no action is required.
    pub action: String,
    /// Time of day since which the state lasts, RFC 3339 in UTC; empty before the first sample.
    pub since: String,
}

/// Returns what the first diagnosis waits for, and how far it is.
fn first_diagnosis(view: &View) -> String {
    match view.diagnosis {
        DiagnosisState::Collecting { collected_s, required_s } => format!(
            "The first diagnosis requires {required_s:.1} s of samples without a gap: {collected_s:.1} s so far."
        ),
        DiagnosisState::Computing { time_s } => format!(
            "The first diagnosis, of the samples up to {time_s:.1} s, is computed; the recording is at {:.1} s.",
            view.time_s
        ),
        _ => "The first diagnosis waits for the first samples that the twin follows.".to_owned(),
    }
}

impl Status {
    /// Returns the state that a view shows.
    #[must_use]
    pub fn of(view: &View) -> Self {
        let status = |word, level, sentence: &str, action: &str| Self {
            word,
            level,
            title: String::new(),
            sentence: sentence.to_owned(),
            action: action.to_owned(),
            since: view.state_since.clone(),
        };
        if let Some(conclusion) = &view.conclusion {
            let is_faulty = conclusion.diagnoses.iter().any(Diagnosis::is_of_machine);
            let level = if is_faulty { Level::Alarm } else { Level::Unknown };
            return status("ENDED", level, &conclusion.verdict, "");
        }
        if let Some(status) = Self::of_alarms(view) {
            return status;
        }
        let has_limits = !view.limits.is_empty();
        let limits = if has_limits { "All values are within their limits" } else { "The scene has no limits" };
        match (view.state, &view.diagnosis) {
            (MonitorState::Waiting, _) => status(
                "NO DATA",
                Level::Warning,
                "The monitor waits for the first sample of its source.",
                "Check that the source runs and sends to this monitor.",
            ),
            (MonitorState::Silent, _) => status(
                "NO DATA",
                Level::Warning,
                "The source sends no data.",
                "Check the source, its connection and its power supply.",
            ),
            (MonitorState::Ended, _) => status("ENDED", Level::Unknown, "The monitor has ended.", ""),
            (MonitorState::Starting, _) => {
                let within = if has_limits { "All values are within their limits. " } else { "" };
                let sentence = format!(
                    "{within}The twin is starting: {:.0} s so far. The first diagnosis follows when it runs.",
                    view.pacing.starting_s
                );
                status("STARTING", Level::Unknown, &sentence, "")
            }
            (MonitorState::Running, DiagnosisState::Implausible { sentence }) => status(
                "NOT PLAUSIBLE",
                Level::Warning,
                sentence,
                "Check probes, wiring and scene: the samples cannot be those of this machine.",
            ),
            (MonitorState::Running, DiagnosisState::Made { time_s }) => {
                let sentence = format!("No fault found in the samples up to {time_s:.1} s. {limits}.");
                status("NORMAL", Level::Normal, &sentence, "")
            }
            (
                MonitorState::Running,
                DiagnosisState::NotMade | DiagnosisState::Collecting { .. } | DiagnosisState::Computing { .. },
            ) => {
                let waits_for = first_diagnosis(view);
                match has_limits {
                    true => status("WITHIN LIMITS", Level::Normal, &format!("{limits}. {waits_for}"), ""),
                    false => status("NO VERDICT YET", Level::Unknown, &waits_for, ""),
                }
            }
            (MonitorState::Running, DiagnosisState::Ended { sentence }) => {
                let (word, level) =
                    if has_limits { ("WITHIN LIMITS", Level::Normal) } else { ("NO VERDICT", Level::Warning) };
                status(word, level, &format!("{limits}. {sentence}"), "")
            }
        }
    }

    /// Returns the state of a machine with alarms.
    fn of_alarms(view: &View) -> Option<Self> {
        let alarms = view.alarms.alarms();
        let active = || alarms.iter().filter(|alarm| alarm.is_active());
        // A new alarm is more urgent than an acknowledged one.
        let first = active().find(|alarm| alarm.is_unacknowledged()).or_else(|| active().next());
        let (alarm, word, level) = match first {
            Some(alarm) if alarm.is_unacknowledged() => (alarm, "ALARM", Level::Alarm),
            Some(alarm) => (alarm, "ALARM, ACKNOWLEDGED", Level::Alarm),
            None => (alarms.first()?, "ALARM ENDED", Level::Warning),
        };
        let others = match alarms.len() - 1 {
            0 => String::new(),
            1 => ", and one more alarm".to_owned(),
            count => format!(", and {count} more alarms"),
        };
        let silence = if view.state == MonitorState::Silent { " The source sends no data." } else { "" };
        Some(Self {
            word,
            level,
            title: format!("{}{others}", alarm.title),
            sentence: format!("{}{silence}", alarm.sentence),
            action: alarm.action.clone(),
            since: alarm.ended_at.as_ref().unwrap_or(&alarm.raised_at).clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_twin::replay::outcome::Pacing;

    #[test]
    fn the_wait_for_the_first_diagnosis_is_reported_with_its_progress() {
        let sentence = |state, diagnosis| {
            let pacing = Pacing { starting_s: 4.0, ..Pacing::default() };
            let view = View { state, diagnosis, time_s: 12.3, pacing, ..View::default() };
            let status = Status::of(&view);
            (status.word, status.sentence)
        };
        let collecting = DiagnosisState::Collecting { collected_s: 23.04, required_s: 60.0 };
        assert_eq!(
            sentence(MonitorState::Running, collecting.clone()),
            (
                "NO VERDICT YET",
                "The first diagnosis requires 60.0 s of samples without a gap: 23.0 s so far.".to_owned()
            )
        );
        let (_, computing) = sentence(MonitorState::Running, DiagnosisState::Computing { time_s: 1.6 });
        assert!(computing.contains("up to 1.6 s") && computing.contains("at 12.3 s"), "{computing}");
        let (word, starting) = sentence(MonitorState::Starting, collecting);
        assert!(word == "STARTING" && starting.contains("4 s so far"), "{word}: {starting}");
    }
}
