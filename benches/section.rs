//! The README's section between two marks: written from measurements, checked against the list of subjects.

use crate::measure::{ROUNDS, Times};
use crate::subjects::{BATCH, BATCH_PRELOADED, COLUMNS, ROOTS, Subject};
use std::{fs, process};

/// First line of the section.
pub const BEGIN: &str = "<!-- bench:begin -->";
/// Last line of the section.
pub const END: &str = "<!-- bench:end -->";

const FIRST_COLUMN: &str = "ns a call";
const NOT_MEASURED: &str = "–";

/// Rows of ratios: the name, what is above, what is below.
const RATIOS: [(&str, &str, &str); 3] = [
    ("ratio: batch with play to square roots (aim: at most 1.5)", BATCH, ROOTS),
    ("ratio: batch with preload to square roots", BATCH_PRELOADED, ROOTS),
    ("ratio: batch with play to single evaluations", BATCH, "lumped, point contact, N = 8: force"),
];

/// The section without its marks.
pub fn text(subjects: &[Subject], times: &Times) -> String {
    let place = |row: &str, column: &str| subjects.iter().position(|s| s.row == row && s.column == column);
    let mut lines = vec![preamble(), String::new(), line(FIRST_COLUMN, COLUMNS.map(str::to_owned))];
    lines.push(line("---", COLUMNS.map(|_| "--:".to_owned())));
    for row in rows(subjects) {
        lines.push(line(row, COLUMNS.map(|column| cell(place(row, column).and_then(|i| times.median(i)), 1))));
    }
    for (name, above, below) in RATIOS {
        let ratio = |column| times.ratio(place(above, column)?, place(below, column)?);
        lines.push(line(name, COLUMNS.map(|column| cell(ratio(column), 2))));
    }
    lines.join("\n")
}

/// `text` with the section's content replaced, if it has the section.
pub fn replaced(text: &str, content: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{content}\n{END}{after}"))
}

/// The section is there, and its rows and columns are those of the list.
pub fn check(text: &str, subjects: &[Subject]) -> Result<(), String> {
    let after = text.split_once(BEGIN).ok_or(format!("README.md: no {BEGIN}"))?.1;
    let content = after.split_once(END).ok_or(format!("README.md: no {END}"))?.0;
    let table: Vec<&str> = content.lines().filter(|line| line.starts_with('|')).collect();
    let header = line(FIRST_COLUMN, COLUMNS.map(str::to_owned));
    if table.first() != Some(&header.as_str()) {
        return Err(format!("README.md: the benchmark table does not begin with {header}"));
    }
    let found: Vec<&str> = table.iter().skip(2).filter_map(|line| line.split('|').nth(1)).map(str::trim).collect();
    let expected: Vec<&str> = rows(subjects).into_iter().chain(RATIOS.map(|(name, ..)| name)).collect();
    let missing = expected.iter().find(|row| !found.contains(row)).map(|row| format!("lacks \"{row}\""));
    let unknown = found.iter().find(|row| !expected.contains(row)).map(|row| format!("has an unknown \"{row}\""));
    let order = (found != expected).then(|| "has its rows in another order or twice".to_owned());
    match missing.or(unknown).or(order) {
        Some(fault) => Err(format!("README.md: the benchmark table {fault}; run the table benchmark anew")),
        None => Ok(()),
    }
}

/// Names of the rows; the subjects of one row stand side by side.
fn rows(subjects: &[Subject]) -> Vec<&str> {
    let mut rows: Vec<&str> = subjects.iter().map(|subject| subject.row.as_str()).collect();
    rows.dedup();
    rows
}

fn line(name: &str, cells: [String; COLUMNS.len()]) -> String {
    format!("| {name} | {} |", cells.join(" | "))
}

fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(NOT_MEASURED.to_owned(), |value| format!("{value:.digits$}"))
}

fn preamble() -> String {
    format!(
        "{}, {} with {}, {}.\n\
         Median of {ROUNDS} rounds in which all rows take turns; calls one after another, a call of a batch being one sample.\n\
         The times are an indication: they change with machine, compiler and load. The ratios, each taken within a round, are\n\
         the result.",
        processor(),
        std::env::consts::ARCH,
        vector_unit(),
        compiler(),
    )
}

fn processor() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(':'));
    model.map_or("unknown processor".to_owned(), |(_, name)| name.trim().to_owned())
}

fn compiler() -> String {
    let answer = process::Command::new("rustc").arg("--version").output().ok();
    let version = answer.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    version.unwrap_or_else(|| "unknown rustc".to_owned())
}

/// The widest vector instructions that the compiler was allowed to use.
fn vector_unit() -> &'static str {
    let units = [
        ("AVX-512", cfg!(target_feature = "avx512f")),
        ("AVX2", cfg!(target_feature = "avx2")),
        ("AVX", cfg!(target_feature = "avx")),
        ("SSE2", cfg!(target_feature = "sse2")),
        ("NEON", cfg!(target_feature = "neon")),
    ];
    units.into_iter().find(|(_, there)| *there).map_or("no vector unit", |(name, _)| name)
}
