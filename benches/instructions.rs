//! Counts the instructions of every subject on this machine, by callgrind, and writes the table in `benches/README.md`:
//! `cargo bench -p ballrace-benches --bench instructions`.
//!
//! With `-- --check` it holds the table instead: a rise of more than 2 % fails, so does a fall (write the table anew).

mod marks;
mod section;
mod subjects;

use section::Section;
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use subjects::balls::PLAIN_C;
use subjects::chain::CHAIN_C;
use subjects::{COLUMNS, Subject};

/// Start of the text before the table.
const COMPILED_BY: &str = "Compiled by ";
const SECTION: Section = Section { name: "callgrind", first_column: "instructions per call" };
/// Given to the copy of this program that runs under callgrind.
const COUNTED: &str = "--counted";
/// A count may change by this share.
const MARGIN: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let given = |option: &str| env::args().any(|argument| argument == option);
    let mut subjects = subjects::all()?;
    // Another program's instructions are not counted.
    subjects.retain(|subject| ![PLAIN_C, CHAIN_C].contains(&subject.row.as_str()));
    if given(COUNTED) || !given("--bench") && !given("--check") {
        subjects.iter_mut().for_each(counted);
    } else if given("--check") {
        check(&subjects)?;
    } else {
        write(&subjects)?;
    }
    Ok(())
}

/// Function that callgrind measures, found by this name.
#[inline(never)]
fn counted(subject: &mut Subject) {
    black_box(&mut subject.run)();
}

/// Instructions a call of every subject.
fn counts(subjects: &[Subject]) -> Result<Vec<f64>, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("count");
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no", "--toggle-collect=instructions::counted"])
        .arg("--dump-after=instructions::counted")
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(env::current_exe()?)
        .arg(COUNTED)
        .output()
        .map_err(|error| format!("missing: valgrind ({error}); type: apt-get install -y valgrind"))?;
    if !run.status.success() {
        return Err(format!("valgrind: {}", String::from_utf8_lossy(&run.stderr)).into());
    }
    let count = |(i, subject): (usize, &Subject)| Ok(total(&out, i + 1)? / f64::from(subject.calls));
    subjects.iter().enumerate().map(count).collect()
}

/// The total of dump number `i`.
fn total(out: &Path, i: usize) -> Result<f64, Box<dyn Error>> {
    let text = fs::read_to_string(format!("{}.{i}", out.display()))?;
    let total = text.lines().find_map(|line| line.strip_prefix("totals:").or(line.strip_prefix("summary:")));
    Ok(total.ok_or("a dump without a total")?.trim().parse()?)
}

fn readme() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "README.md"].iter().collect()
}

fn write(subjects: &[Subject]) -> Result<(), Box<dyn Error>> {
    let counts = counts(subjects)?;
    let rows = section::rows_of(subjects, |i| counts.get(i).copied(), 0);
    let body = format!("{COMPILED_BY}{}, {}.\n\n{}\n{rows}", section::compiler(), env::consts::ARCH, SECTION.header());
    println!("{body}");
    let old = fs::read_to_string(readme())?;
    fs::write(readme(), SECTION.replaced(&old, &body).ok_or("benches/README.md has no place for the table")?)?;
    Ok(())
}

fn check(subjects: &[Subject]) -> Result<(), Box<dyn Error>> {
    let text = fs::read_to_string(readme())?;
    let stated = SECTION.content(&text).ok_or("benches/README.md has no table")?;
    SECTION.check(&text, &section::rows(subjects))?;
    if !stated.contains(&format!("{COMPILED_BY}{}, {}.", section::compiler(), env::consts::ARCH)) {
        println!("benches/README.md: the counts are of another compiler or machine: not compared");
        return Ok(());
    }
    for (subject, count) in subjects.iter().zip(counts(subjects)?) {
        let held = stated_count(stated, subject).ok_or(format!("no count of {}", subject.row))?;
        // The table is rounded to whole instructions.
        if (count - held).abs() > MARGIN * held + 0.5 {
            let Subject { row, column, .. } = subject;
            return Err(format!("{row}, {column}: {count:.0} instructions, benches/README.md says {held:.0}").into());
        }
    }
    println!("benches/README.md: every count within {:.0} %", 100.0 * MARGIN);
    Ok(())
}

fn stated_count(content: &str, subject: &Subject) -> Option<f64> {
    let line = content.lines().find(|line| line.split('|').nth(1).is_some_and(|name| name.trim() == subject.row))?;
    let column = COLUMNS.iter().position(|column| *column == subject.column)?;
    line.split('|').nth(2 + column)?.trim().parse().ok()
}
