//! Notices of live operation: rejected readings, restarts, an observer that is not trusted.

use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_recording::Sample;
use ballrace_recording::status::SampleStatus;

/// Shortest interval between two notices of one kind in the recording's time, s.
const INTERVAL: f64 = 10.0;

/// A notice.
#[derive(Debug, Clone)]
pub struct Notice {
    /// Kind, as in the event log.
    pub kind: &'static str,
    /// Time of the recording, s.
    pub time_s: f64,
    /// The notice as a sentence.
    pub sentence: String,
}

/// Notices of a recording, at most one of a kind every 10 s, so that a lasting fault does not flood the log.
#[derive(Default)]
pub(crate) struct Notices {
    last: Vec<(&'static str, f64)>,
    waiting: Vec<Notice>,
}

impl Notices {
    /// Adds a notice unless there was one of the same kind within the interval.
    pub fn add(&mut self, kind: &'static str, time_s: f64, sentence: impl FnOnce() -> String) {
        let last = self.last.iter_mut().find(|(of, _)| *of == kind);
        match last {
            Some((_, last)) if time_s - *last < INTERVAL => return,
            Some((_, last)) => *last = time_s,
            None => self.last.push((kind, time_s)),
        }
        self.waiting.push(Notice { kind, time_s, sentence: sentence() });
    }

    /// Adds a notice, whatever came before.
    pub(crate) fn add_always(&mut self, kind: &'static str, time_s: f64, sentence: String) {
        self.waiting.push(Notice { kind, time_s, sentence });
    }

    /// Returns the notices since the last call.
    pub fn take(&mut self) -> Vec<Notice> {
        std::mem::take(&mut self.waiting)
    }
}

/// Checks the readings of a sample, sets its status flags and reports what is out of range.
pub(super) fn check_sample(range: &mut ReadingRange, sample: &mut Sample, notices: &mut Notices) {
    let status = range.check(&mut sample.row);
    if status != SampleStatus::default() {
        let count = range.count();
        notices.add("reading-out-of-range", sample.row.time, || {
            format!("A reading is farther from zero than the bearings allow; {count} so far. It is omitted.")
        });
    }
    if sample.status.has(SampleStatus::ANGLE_NOT_MEASURED) {
        notices.add("angle-not-measured", sample.row.time, || {
            "The shaft speed is out of range; the speed before it is held.".to_owned()
        });
    }
    sample.status = sample.status.and(status);
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_reported_once_in_ten_seconds() {
        let mut notices = Notices::default();
        (0..250).for_each(|i| notices.add("a", 0.1 * f64::from(i), String::new));
        notices.add("b", 25.0, String::new);
        let kinds: Vec<&str> = notices.take().iter().map(|n| n.kind).collect();
        assert_eq!(kinds, ["a", "a", "a", "b"]);
        assert!(notices.take().is_empty());
    }
}
