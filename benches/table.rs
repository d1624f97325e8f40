//! Measures every subject and writes the table in the README: `cargo bench -p ballrace-benches --bench table`.
//!
//! With `-- --check` it measures nothing and only says whether the README's table has the rows it should have.

mod measure;
mod section;
mod subjects;

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};
use subjects::Subject;

fn main() -> Result<(), Box<dyn Error>> {
    let given = |option: &str| env::args().any(|argument| argument == option);
    let mut subjects = subjects::all()?;
    if given("--check") {
        let text = fs::read_to_string(readme()).map_err(|error| format!("README.md: {error}"))?;
        section::check(&text, &subjects)?;
        println!("README.md: the benchmark table has all its rows");
    } else if given("--bench") {
        write(&mut subjects)?;
    } else {
        // Without the option that `cargo bench` gives, this is `cargo test`: everything runs, nothing is written.
        for subject in &mut subjects {
            (subject.run)();
        }
    }
    Ok(())
}

fn readme() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "..", "README.md"].iter().collect()
}

fn write(subjects: &mut [Subject]) -> Result<(), Box<dyn Error>> {
    let times = measure::times(subjects);
    let body = section::text(subjects, &times);
    println!("{body}");
    match fs::read_to_string(readme()).ok().and_then(|old| section::replaced(&old, &body)) {
        Some(new) => fs::write(readme(), new)?,
        None => println!("no README.md with {} and {}: nothing written", section::BEGIN, section::END),
    }
    Ok(())
}
