//! Instructions, modelled cycles, stack and flash of every subject, beside hand-written C, held in `docs/src/performance.md`.

mod cores;
mod fast;
mod listing;
mod path;
mod table;
mod without_fpu;
pub mod yardstick;

use listing::Listing;
use std::path::PathBuf;
use table::Row;

/// A figure may rise by this share before the test fails, and fall by it before it asks for a new table.
const MARGIN: f64 = 0.02;
/// Instructions, cycles or bytes by which a figure differs beside that wherever the compiler allots registers anew; the constants at the end of
/// a function begin at a multiple of four bytes.
const SLACK: f64 = 4.0;

/// Identity of a subject.
#[derive(Clone, PartialEq)]
struct Name {
    what: String,
    elements: u32,
    precision: String,
    math: String,
    function: String,
}

/// One line of the measuring image.
struct Subject {
    name: Name,
    least: u32,
    most: u32,
    stack: u32,
    address: u32,
}

/// Folder of the tables that the runner reads.
const KNOWN: &str = "runner/studies/src/trade/cores";

/// Writes the table of a core, or compares it with what was counted. It has no cycles, and no stack of a core whose stack is not painted.
fn hold_known(core: &str, subjects: &[Subject]) {
    let path = super::root().join(KNOWN).join(format!("{core}.csv"));
    let floats: Vec<&Subject> = subjects.iter().filter(|subject| subject.name.precision == "f32").collect();
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        let lines: String = floats.iter().map(|subject| subject.known()).collect();
        return std::fs::write(path, lines).expect("the runner takes it");
    }
    let stated = std::fs::read_to_string(chapter()).expect(CHAPTER);
    if !stated.contains(&format!("Compiled by {},", compiler())) {
        return;
    }
    let known = std::fs::read_to_string(path).expect("a table");
    assert_eq!(known.lines().count(), floats.len(), "{core}: BALLRACE_WRITE=1 rewrites its table");
    for (line, found) in known.lines().zip(floats) {
        let cells: Vec<&str> = line.split(';').collect();
        let (name, [most, ..]) = Name::parse(&cells[..9]);
        let (most, found_most) = (f64::from(number(most)), f64::from(found.most));
        let is_held = name == found.name && (found_most - most).abs() <= MARGIN * most + SLACK;
        assert!(
            is_held,
            "{core}: {}: {found_most} instructions, its table has {line}: BALLRACE_WRITE=1 rewrites it",
            found.name
        );
    }
}

fn number(text: &str) -> u32 {
    text.parse().expect("a number")
}

impl Name {
    /// From the first five of nine cells, and the other four.
    fn parse<'a>(cells: &[&'a str]) -> (Self, [&'a str; 4]) {
        let [what, elements, precision, math, function, rest @ ..] = cells else { panic!("nine cells: {cells:?}") };
        let [what, precision, math, function] = [what, precision, math, function].map(|text| (*text).to_owned());
        (Self { what, elements: number(elements), precision, math, function }, rest.try_into().expect("nine cells"))
    }

    /// In the arithmetic that firmware takes.
    fn is_hot(&self) -> bool {
        self.precision == "f32" && self.math == "exact"
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Self { what, elements, precision, math, function } = self;
        write!(f, "{what} | {elements} | {precision} | {math} | {function}")
    }
}

impl Subject {
    /// As the runner reads it: the most instructions, no cycles, the stack, no flash, and the least instructions where they differ.
    fn known(&self) -> String {
        let Self { name: Name { what, elements, precision, math, function }, least, most, stack, .. } = self;
        let stack = if *stack == 0 { String::new() } else { stack.to_string() };
        let least = if least == most { String::new() } else { format!(";{least}") };
        format!("{what};{elements};{precision};{math};{function};{most};;{stack};{least}\n")
    }

    fn parse(line: &str) -> Self {
        let (name, figures) = Name::parse(&line.split(';').collect::<Vec<_>>());
        let [least, most, stack, address] = figures.map(number);
        Self { name, least, most, stack, address }
    }
}

fn subjects(image: &str, arguments: &[&str]) -> Vec<Subject> {
    super::run_with(image, arguments).lines().map(Subject::parse).collect()
}

/// Measures everything: counts over all inputs by one image, path and size of each function by its twin.
fn measured() -> Vec<Row> {
    let counted = subjects("counts", super::COUNTING);
    let (traced, visited) = path::traced();
    assert_eq!(counted.len(), traced.len(), "both images measure the same");
    let listing = Listing::of(&super::images().join("trace"));
    let mut rows = Vec::new();
    for (count, trace) in counted.iter().zip(&traced) {
        let name = &count.name;
        let path = path::of_call(&visited, trace.address, name);
        if name.precision == "f32" {
            assert_eq!(count.least, count.most, "{name}: the count depends on the input");
            // The bracket around the call is known to a few instructions: the call itself and its arguments.
            let around = i64::from(count.most) - path.len() as i64;
            assert!((0..=16).contains(&around), "{name}: {} counted, {} on its path", count.most, path.len());
        }
        rows.push(Row {
            name: name.clone(),
            least: count.least,
            most: count.most,
            cycles: listing.cycles(path),
            stack: count.stack,
            flash: listing.flash(trace.address),
        });
    }
    rows
}

/// The file that holds the tables, from the root of the repository.
const CHAPTER: &str = "docs/src/performance.md";

fn chapter() -> PathBuf {
    super::root().join(CHAPTER)
}

/// Compilers differ in what they make of the same source: figures are held for the one that wrote the table.
fn compiler() -> String {
    let output = std::process::Command::new("rustc").arg("--version").output().expect("rustc runs");
    String::from_utf8_lossy(&output.stdout).split(" (").next().unwrap_or_default().trim().to_owned()
}

/// The number of instructions is constant over 700 inputs, with NaN, infinities, subnormals, lost contact.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn figures_do_not_depend_on_the_input_and_match_the_documented_tables() {
    let rows = measured();
    assert!(rows.len() >= 150, "{} subjects", rows.len());
    let text = std::fs::read_to_string(chapter()).expect(CHAPTER);
    let (before, stated, after) = table::split(&text);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        let section = table::section(&compiler(), &rows, &yardstick::rows(), &fast::errors());
        std::fs::write(chapter(), format!("{before}{section}{after}")).expect(CHAPTER);
        let known: String = rows.iter().map(Row::known).collect();
        std::fs::write(super::root().join(KNOWN).join("cortex-m4f.csv"), known).expect("the runner takes it");
        return;
    }
    if !stated.contains(&format!("Compiled by {},", compiler())) {
        println!("{CHAPTER}: figures of another compiler than {}: not compared", compiler());
        return;
    }
    let held = table::read(stated);
    assert_eq!(held.len(), rows.len(), "{CHAPTER} lists other functions: BALLRACE_WRITE=1 rewrites it");
    for (stated, found) in held.iter().zip(&rows) {
        compare(stated, found);
    }
    let derived = table::section(&compiler(), &held, &yardstick::rows(), &fast::errors());
    assert_eq!(stated, derived, "the short tables are those of the full one: BALLRACE_WRITE=1 rewrites them");
}

fn compare(stated: &Row, found: &Row) {
    assert!(stated.name == found.name, "BALLRACE_WRITE=1 rewrites the table of {CHAPTER}");
    for ((what, stated), (_, found_figure)) in stated.figures().into_iter().zip(found.figures()) {
        let (change, allowed) = (f64::from(found_figure) - f64::from(stated), MARGIN * f64::from(stated) + SLACK);
        let says = format!("{}: {found_figure} {what}, {CHAPTER} has {stated}", found.name);
        assert!(change <= allowed, "{says}");
        assert!(change >= -allowed, "{says}, more than it takes now: BALLRACE_WRITE=1 rewrites it");
    }
}
