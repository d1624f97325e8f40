//! The tables of `docs/src/performance.md`: two short ones and the full one, which the test reads back.

use super::fast::Errors;
use super::yardstick::Compiled;
use super::{Name, number};
use std::fmt::Write;

const BEGIN: &str = "<!-- counts:begin -->\n";
const END: &str = "<!-- counts:end -->";
const FULL: &str = "| what | N | precision | math | function | instructions | cycles | stack | flash |";
const ELEMENTS: [u32; 4] = [4, 8, 9, 16];

/// One subject's figures.
pub struct Row {
    pub name: Name,
    pub least: u32,
    pub most: u32,
    pub cycles: u32,
    pub stack: u32,
    pub flash: u32,
}

/// Name of the size of a function.
pub const FLASH: &str = "bytes of flash";

impl Row {
    pub fn figures(&self) -> [(&'static str, u32); 4] {
        [("instructions", self.most), ("cycles", self.cycles), ("bytes of stack", self.stack), (FLASH, self.flash)]
    }

    fn instructions(&self) -> String {
        if self.least == self.most { self.most.to_string() } else { format!("{} to {}", self.least, self.most) }
    }

    fn line(&self) -> String {
        let Self { cycles, stack, flash, .. } = self;
        format!("| {} | {} | {cycles} | {stack} | {flash} |", self.name, self.instructions())
    }

    /// As the runner reads it.
    pub fn known(&self) -> String {
        let Self { name: Name { what, elements, precision, math, function }, most, cycles, stack, flash, .. } = self;
        format!("{what};{elements};{precision};{math};{function};{most};{cycles};{stack};{flash}\n")
    }

    fn parse(line: &str) -> Self {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let (name, [instructions, cycles, stack, flash]) = Name::parse(&cells);
        let (least, most) = instructions.split_once(" to ").unwrap_or((instructions, instructions));
        let [least, most, cycles, stack, flash] = [least, most, cycles, stack, flash].map(number);
        Self { name, least, most, cycles, stack, flash }
    }
}

/// The text before the section, the section, the text after it.
pub fn split(chapter: &str) -> (&str, &str, &str) {
    let begin = chapter.find(BEGIN).expect("a mark where the figures begin") + BEGIN.len();
    let end = begin + chapter[begin..].find(END).expect("a mark where the figures end");
    (&chapter[..begin], &chapter[begin..end], &chapter[end..])
}

/// The rows of the full table.
pub fn read(section: &str) -> Vec<Row> {
    let rows = section.lines().skip_while(|line| *line != FULL).skip(2);
    rows.take_while(|line| line.starts_with('|')).map(Row::parse).collect()
}

/// The whole section.
pub fn section(compiler: &str, rows: &[Row], yardstick: &Compiled, errors: &Errors) -> String {
    let mut text = format!("Compiled by {compiler}, optimised for speed. Cycles are modelled.\n\n");
    text += &by_elements(rows);
    text += &functions(rows, yardstick);
    text += &format!(
        "`Fast`, by micromath, is off by at most {:.2} % in the square root, {:.2} % in the radial and {:.2} % in the angular \
         force.\n\n",
        100.0 * errors.root,
        100.0 * errors.radial,
        100.0 * errors.angular
    );
    text += "<details><summary>Every model, number of elements, precision and math</summary>\n\n";
    text += &format!("{FULL}\n| --- | --: | --- | --- | --- | --: | --: | --: | --: |\n");
    for row in rows {
        writeln!(text, "{}", row.line()).expect("a string takes it");
    }
    text + "\n</details>\n"
}

/// Force of each model over the number of elements.
fn by_elements(rows: &[Row]) -> String {
    let mut text = "| force, f32: instructions (cycles) |".to_owned();
    for n in ELEMENTS {
        write!(text, " N = {n} |").expect("a string takes it");
    }
    text += "\n| --- | --: | --: | --: | --: |\n";
    let force = |row: &&Row| row.name.is_hot() && row.name.function == "force" && row.name.elements > 0;
    let mut done: Vec<&str> = Vec::new();
    for row in rows.iter().filter(force) {
        if done.contains(&row.name.what.as_str()) {
            continue;
        }
        done.push(&row.name.what);
        write!(text, "| {} |", row.name.what).expect("a string takes it");
        for n in ELEMENTS {
            let cell =
                rows.iter().filter(force).find(|other| other.name.what == row.name.what && other.name.elements == n);
            let cell = cell.map_or("–".to_owned(), |row| format!("{} ({})", row.most, row.cycles));
            write!(text, " {cell} |").expect("a string takes it");
        }
        text += "\n";
    }
    text + "\n"
}

/// What else is asked of 8 or 9 elements, and the yardstick.
fn functions(rows: &[Row], yardstick: &Compiled) -> String {
    let mut text = "| f32 | instructions | cycles | stack | flash |\n| --- | --: | --: | --: | --: |\n".to_owned();
    let other = |name: &Name| name.function != "force" || name.elements == 0;
    let shown = |row: &&Row| row.name.is_hot() && other(&row.name) && row.name.elements != 8;
    let in_cage = |row: &&Row| row.name.is_hot() && row.name.function.contains("frame");
    for row in rows.iter().filter(in_cage).chain(rows.iter().filter(shown)) {
        let Row { name: Name { what, elements, function, .. }, most, cycles, stack, flash, .. } = row;
        let what = if *elements == 0 { what.clone() } else { format!("{what}, N = {elements}") };
        writeln!(text, "| {what}: {function} | {most} | {cycles} | {stack} | {flash} |").expect("a string takes it");
    }
    for function in &yardstick.functions {
        let (name, instructions) = (&function.name, function.instructions);
        writeln!(text, "| C by {}, N = 8, tables ready: {name} | {instructions} | – | – | – |", yardstick.compiler)
            .expect("a string takes it");
    }
    text + "\n"
}
