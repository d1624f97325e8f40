//! Measures every subject and writes the table in `docs/src/performance.md`: `cargo bench -p ballrace-benches --bench table`.
//!
//! With `-- --check` it measures nothing and checks that the table has one row for each subject.

mod load_states;
mod marks;
mod measure;
mod section;
mod subjects;

use load_states::Load;
use measure::{ROUNDS, Times};
use section::Section;
use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};
use subjects::balls::{COLD, COLD_WIDE, LOOKED_UP, PLAIN_C, WARM, WARM_WIDE};
use subjects::chain::{CHAIN, CHAIN_C, CHAIN_WIDE};
use subjects::{BATCH, BATCH_PRELOADED, COLUMNS, ROOTS, Subject};

/// The file that holds the table, from the root of the repository.
const CHAPTER: &str = "docs/src/performance.md";
const SECTION: Section = Section { name: "bench", first_column: "ns per call" };

/// Rows of ratios: the name, what is above, what is below.
const RATIOS: [(&str, &str, &str); 10] = [
    ("ratio: force from the force before to tuned C (aim: at most 1)", CHAIN, CHAIN_C),
    ("ratio: force from the force before, widest registers, to tuned C (aim: at most 1)", CHAIN_WIDE, CHAIN_C),
    ("ratio: quasi-static cold, widest registers, to plain C (aim: at most 0.35)", COLD_WIDE, PLAIN_C),
    ("ratio: quasi-static from the last sample, widest registers, to plain C (aim: at most 0.12)", WARM_WIDE, PLAIN_C),
    ("ratio: quasi-static cold to plain C (aim: below 1)", COLD, PLAIN_C),
    ("ratio: quasi-static from the last sample to cold (aim: at most 0.5)", WARM, COLD),
    ("ratio: tabulated to quasi-static cold (aim: at most 0.1)", LOOKED_UP, COLD),
    ("ratio: batch with play to square roots (aim: at most 1.5)", BATCH, ROOTS),
    ("ratio: batch with preload to square roots", BATCH_PRELOADED, ROOTS),
    ("ratio: batch with play to single evaluations", BATCH, "lumped, point contact, N = 8: force"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let given = |option: &str| env::args().any(|argument| argument == option);
    let subjects = subjects::all()?;
    if given("--check") {
        let text = fs::read_to_string(chapter()).map_err(|error| format!("{CHAPTER}: {error}"))?;
        let of_states = state_ratios();
        let expected: Vec<&str> = section::rows(&subjects)
            .into_iter()
            .chain(RATIOS.map(|(name, ..)| name))
            .chain(of_states.iter().map(|(name, ..)| name.as_str()))
            .collect();
        SECTION.check(&text, &expected).map_err(|fault| format!("{CHAPTER}: {fault}"))?;
        println!("{CHAPTER}: the benchmark table has all its rows");
    } else if given("--bench") {
        write(subjects)?;
    } else {
        // Without the option that `cargo bench` gives, this is `cargo test`: everything runs, nothing is written.
        let of_states = load_states::all()?.into_iter().map(|state| state.subject);
        for mut subject in subjects.into_iter().chain(of_states) {
            (subject.run)();
        }
    }
    Ok(())
}

fn chapter() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "..", CHAPTER].iter().collect()
}

fn write(subjects: Vec<Subject>) -> Result<(), Box<dyn Error>> {
    let count = subjects.len();
    let (states, of_states): (Vec<_>, Vec<_>) =
        load_states::all()?.into_iter().map(|state| ((state.model, state.load), state.subject)).unzip();
    let mut subjects: Vec<Subject> = subjects.into_iter().chain(of_states).collect();
    let times = measure::times(&mut subjects);
    let (subjects, of_states) = subjects.split_at(count);
    let state = |model: &str, load: Load, column: &str| {
        let is_it = |(of, subject): (&(&str, Load), &Subject)| *of == (model, load) && subject.column == column;
        Some(count + states.iter().zip(of_states).position(is_it)?)
    };
    let body = body(subjects, &times, &state);
    println!("{body}");
    let old = fs::read_to_string(chapter())?;
    let new = SECTION.replaced(&old, &body).ok_or(format!("{CHAPTER} has no marks for the table"))?;
    fs::write(chapter(), new)?;
    Ok(())
}

/// Rows of the ratios of load states: the name, the model, and the state whose time is divided by that with all elements loaded.
fn state_ratios() -> Vec<(String, &'static str, Load)> {
    let of = |model: &'static str| {
        [(Load::None, "no element"), (Load::Half, "half of the elements")]
            .map(|(load, words)| (format!("ratio: {words} loaded to all (aim: 0.9 to 1.1): {model}"), model, load))
    };
    load_states::MODELS.into_iter().flat_map(of).collect()
}

/// The section without its marks; `state` returns the index of a load state in a column.
fn body(subjects: &[Subject], times: &Times, state: &dyn Fn(&str, Load, &str) -> Option<usize>) -> String {
    let place = |row: &str, column: &str| subjects.iter().position(|s| s.row == row && s.column == column);
    let rows = section::rows_of(subjects, |i| times.median(i), 1);
    let mut lines = vec![preamble(), String::new(), SECTION.header(), rows];
    for (name, above, below) in RATIOS {
        let ratio = |column| times.ratio(place(above, column)?, place(below, column)?);
        lines.push(section::line(name, COLUMNS.map(|column| section::cell(ratio(column), 2))));
    }
    for (name, model, load) in state_ratios() {
        let ratio = |column| times.ratio(state(model, load, column)?, state(model, Load::All, column)?);
        lines.push(section::line(&name, COLUMNS.map(|column| section::cell(ratio(column), 2))));
    }
    lines.join("\n")
}

fn preamble() -> String {
    format!(
        "{}, {} with {}, {}.\n\
         Median of {ROUNDS} rounds; the rows alternate within a round. Calls follow each other without a pause; a call of a batch is one sample.\n\
         Times change with machine, compiler and load. The ratios, each taken within a round, repeat within some percent.",
        processor(),
        env::consts::ARCH,
        vector_unit(),
        section::compiler(),
    )
}

fn processor() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(':'));
    model.map_or("unknown processor".to_owned(), |(_, name)| name.trim().to_owned())
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
