//! Answers against labels.

use crate::labels::Recording;

/// Kinds of diagnosis that accuse a bearing.
const OF_BEARING: [&str; 4] = ["outer-race", "inner-race", "element", "cage"];

/// Share of recordings for which a statement holds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    pub count: usize,
    pub of: usize,
}

impl Share {
    fn add(&mut self, holds: bool) {
        self.count += usize::from(holds);
        self.of += 1;
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = 100.0 * self.count as f64 / self.of.max(1) as f64;
        write!(f, "{} of {} ({percent:.0} %)", self.count, self.of)
    }
}

/// Counts of a table.
#[derive(Debug, Clone, Copy, Default)]
pub struct Score {
    /// That component and no other.
    pub races_exact: Share,
    pub races_wrong_first: Share,
    /// Healthy, unbalance, misalignment, bent shaft.
    pub good_accused: Share,
    pub more_than_one: Share,
    pub balls_named: Share,
    pub balls_wrong: Share,
}

/// Rows of the table.
pub const ROWS: [(&str, fn(&Score) -> Share); 6] = [
    ("damaged races exactly right", |s| s.races_exact),
    ("damaged races with a wrong component first", |s| s.races_wrong_first),
    ("good bearings accused", |s| s.good_accused),
    ("more than one component named", |s| s.more_than_one),
    ("damaged balls named", |s| s.balls_named),
    ("damaged balls with a wrong component first", |s| s.balls_wrong),
];

impl Score {
    /// Adds the kinds of the diagnoses of a recording, strongest first.
    pub fn add(&mut self, recording: &Recording, kinds: &[String]) {
        let accused: Vec<&str> = kinds.iter().map(String::as_str).filter(|kind| OF_BEARING.contains(kind)).collect();
        self.more_than_one.add(accused.len() > 1);
        match recording.damage() {
            None => self.good_accused.add(!accused.is_empty()),
            Some("element") => {
                self.balls_named.add(accused == ["element"]);
                self.balls_wrong.add(accused.first().is_some_and(|kind| *kind != "element"));
            }
            Some(damage) => {
                self.races_exact.add(accused == [damage]);
                self.races_wrong_first.add(accused.first().is_some_and(|kind| *kind != damage));
            }
        }
    }

    /// Returns true where the kinds are as they should be.
    pub fn is_right(recording: &Recording, kinds: &[String]) -> bool {
        let accused: Vec<&str> = kinds.iter().map(String::as_str).filter(|kind| OF_BEARING.contains(kind)).collect();
        accused == recording.damage().into_iter().collect::<Vec<_>>()
    }
}

/// Returns true where a bearing is accused.
pub fn is_accused(kinds: &[String]) -> bool {
    kinds.iter().any(|kind| OF_BEARING.contains(&kind.as_str()))
}
