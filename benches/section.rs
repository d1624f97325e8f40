//! A table between two marks in a Markdown file: written from measurements, checked against the list of subjects.

use crate::marks::Marks;
use crate::subjects::{COLUMNS, Subject};
use std::process;

const NOT_MEASURED: &str = "–";

/// A table between `<!-- name:begin -->` and `<!-- name:end -->`.
pub struct Section {
    pub name: &'static str,
    pub first_column: &'static str,
}

impl Section {
    fn marks(&self) -> [String; 2] {
        Marks(self.name).pair()
    }

    /// The table's first two lines.
    pub fn header(&self) -> String {
        format!(
            "{}\n{}",
            line(self.first_column, COLUMNS.map(str::to_owned)),
            line("---", COLUMNS.map(|_| "--:".into()))
        )
    }

    /// Text between the marks, if they exist.
    pub fn content<'a>(&self, text: &'a str) -> Option<&'a str> {
        let [begin, end] = self.marks();
        Some(text.split_once(&begin)?.1.split_once(&end)?.0)
    }

    /// `text` with the section's content replaced, if it has the section.
    pub fn replaced(&self, text: &str, content: &str) -> Option<String> {
        Marks(self.name).replaced(text, content)
    }

    /// The section is there, and its rows and columns are those expected.
    pub fn check(&self, text: &str, expected: &[&str]) -> Result<(), String> {
        let content = self.content(text).ok_or(format!("no {}", self.marks().join(" and ")))?;
        let table: Vec<&str> = content.lines().filter(|line| line.starts_with('|')).collect();
        let header = line(self.first_column, COLUMNS.map(str::to_owned));
        if table.first() != Some(&header.as_str()) {
            return Err(format!("the table does not begin with {header}"));
        }
        let found: Vec<&str> = table.iter().skip(2).filter_map(|line| line.split('|').nth(1)).map(str::trim).collect();
        let missing = expected.iter().find(|row| !found.contains(row)).map(|row| format!("lacks \"{row}\""));
        let unknown = found.iter().find(|row| !expected.contains(row)).map(|row| format!("has an unknown \"{row}\""));
        let order = (found != expected).then(|| "has its rows in another order or twice".to_owned());
        missing.or(unknown).or(order).map_or(Ok(()), |fault| Err(format!("the table {fault}; write it anew")))
    }
}

/// Names of the rows; the subjects of one row stand side by side.
pub fn rows(subjects: &[Subject]) -> Vec<&str> {
    let mut rows: Vec<&str> = subjects.iter().map(|subject| subject.row.as_str()).collect();
    rows.dedup();
    rows
}

/// One line a row, with the value of each subject by its index.
pub fn rows_of(subjects: &[Subject], value: impl Fn(usize) -> Option<f64>, digits: usize) -> String {
    let place = |row: &str, column: &str| subjects.iter().position(|s| s.row == row && s.column == column);
    let line_of = |row: &&str| line(row, COLUMNS.map(|column| cell(place(row, column).and_then(&value), digits)));
    rows(subjects).iter().map(line_of).collect::<Vec<_>>().join("\n")
}

/// One line of the table.
pub fn line(name: &str, cells: [String; COLUMNS.len()]) -> String {
    format!("| {name} | {} |", cells.join(" | "))
}

/// One cell; a dash where nothing was measured.
pub fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(NOT_MEASURED.to_owned(), |value| format!("{value:.digits$}"))
}

/// `rustc 1.95.0 (...)`.
pub fn compiler() -> String {
    let answer = process::Command::new("rustc").arg("--version").output().ok();
    let version = answer.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    version.unwrap_or_else(|| "unknown rustc".to_owned())
}
