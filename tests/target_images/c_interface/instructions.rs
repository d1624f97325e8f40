//! Instructions, stack and flash of the calls beside those of the kernel in Rust, held in `kernel/c/README.md`.

use super::image::{Abi, Image};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A figure may differ by this share from the documented one.
const MARGIN: f64 = 0.02;

/// Calls of C that take no more than 5 % more instructions than the kernel in Rust with the number of elements in the type.
/// The number of elements at run time costs the others more: their loops are not unrolled.
const WITHIN_5_PERCENT: [(&str, &str); 17] = [
    ("linear", "force"),
    ("linear", "force and tangent"),
    ("radial 3/2, 8", "force"),
    ("radial 3/2, 8", "force and tangent"),
    ("radial 3/2, 9", "force and tangent"),
    ("radial 10/9, 8", "force"),
    ("radial 10/9, 9", "force"),
    ("radial, any power, 8", "force"),
    ("radial, any power, 9", "force"),
    ("radial and axial 3/2, 8", "force and tangent"),
    ("angular, 8", "force"),
    ("angular, 8", "force and tangent"),
    ("angular, 9", "force"),
    ("angular, 9", "force and tangent"),
    ("tabulated, 8", "force"),
    ("tabulated, 8", "force, input checked"),
    ("force orders, 4 harmonics", "sample"),
];

/// One line of the measuring image.
struct Row {
    name: String,
    function: String,
    least: u32,
    most: u32,
    stack: u32,
}

fn rows() -> Vec<Row> {
    let image =
        Image::new(Abi::Hard).sources(&["counts.c", "blocks.c", "inputs.c", "subjects.c", "machine.c"]).link("counts");
    let printed = image.run();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(';').collect();
        let [name, function, figures @ ..] = &cells[..] else { panic!("five cells: {line}") };
        let [least, most, stack] = figures else { panic!("five cells: {line}") };
        let number = |text: &str| text.parse().expect("a number");
        // A table in floats needs the speed; all others cost the same without it.
        let needs_speed = name.starts_with("tabulated") && !name.contains("fixed-point");
        let function = match (needs_speed, *function) {
            (true, "force" | "force, input checked") | (false, "force at speed" | "force at speed, input checked") => {
                return None;
            }
            (_, function) => function.replace(" at speed", ""),
        };
        Some(Row { name: (*name).to_owned(), function, least: number(least), most: number(most), stack: number(stack) })
    };
    printed.lines().filter_map(row).collect()
}

/// Instructions of the kernel in Rust by subject and function, from the table of the performance chapter.
fn in_rust() -> BTreeMap<(String, String), u32> {
    let text = std::fs::read_to_string(super::super::root().join("docs/src/performance.md")).expect("the chapter");
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [name, elements, "f32", "exact", function, instructions, ..] = &cells[..] else { return None };
        let name = if matches!(*elements, "0") { (*name).to_owned() } else { format!("{name}, {elements}") };
        Some(((name, (*function).to_owned()), instructions.parse().ok()?))
    };
    text.lines().filter_map(row).collect()
}

const README: &str = "README.md";
const BEGIN: &str = "<!-- figures: BALLRACE_WRITE=1 rewrites them -->\n";
const END: &str = "<!-- end of the figures -->\n";

fn section(rows: &[Row], rust: &BTreeMap<(String, String), u32>) -> String {
    let mut text = "| subject, elements | call | instructions | in Rust | ratio | stack, bytes |\n\
                    | --- | --- | --: | --: | --: | --: |\n"
        .to_owned();
    for Row { name, function, most, stack, .. } in rows {
        let of_rust = rust.get(&(name.clone(), function.clone()));
        let [figure, ratio] = of_rust.map_or(["".to_owned(), "".to_owned()], |&count| {
            [count.to_string(), format!("{:.2}", f64::from(*most) / f64::from(count))]
        });
        writeln!(text, "| {name} | {function} | {most} | {figure} | {ratio} | {stack} |").expect("a text grows");
    }
    text += "\n| image with one model | flash, bytes |\n| --- | --: |\n";
    for (model, bytes) in super::links::flash() {
        writeln!(text, "| {} | {bytes} |", model.replace('_', " ")).expect("a text grows");
    }
    text
}

/// The number of instructions is constant and equals the documented one.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn calls_take_a_constant_number_of_instructions() {
    let (rows, rust) = (rows(), in_rust());
    assert!(rows.len() > 80, "{} rows", rows.len());
    for Row { name, function, least, most, .. } in &rows {
        assert_eq!(least, most, "{name}, {function}: the count depends on the input");
    }
    for (name, function) in WITHIN_5_PERCENT {
        let row = rows.iter().find(|row| row.name == name && row.function == function).expect(name);
        let of_rust = rust[&(name.to_owned(), function.to_owned())];
        assert!(
            f64::from(row.most) <= 1.05 * f64::from(of_rust),
            "{name}, {function}: {} in C, {of_rust} in Rust",
            row.most
        );
    }
    let found = section(&rows, &rust);
    let path = super::folder().join(README);
    let text = std::fs::read_to_string(&path).expect(README);
    let (before, rest) = text.split_once(BEGIN).expect("the begin of the figures");
    let (stated, after) = rest.split_once(END).expect("the end of the figures");
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        return std::fs::write(path, format!("{before}{BEGIN}{found}{END}{after}")).expect("the figures are written");
    }
    assert_eq!(stated.lines().count(), found.lines().count(), "{README} lists other calls");
    for (stated, found) in stated.lines().zip(found.lines()) {
        for (stated_cell, found_cell) in stated.split('|').zip(found.split('|')) {
            let numbers = [stated_cell, found_cell].map(|cell| cell.trim().parse::<f64>());
            let same = match numbers {
                // Two compilers of C pass arguments with a few instructions more or less.
                [Ok(stated), Ok(found)] => (found - stated).abs() <= 4.0 + MARGIN * stated,
                _ => stated_cell == found_cell,
            };
            assert!(same, "{README} has\n{stated}\nmeasured\n{found}\nBALLRACE_WRITE=1 rewrites the table");
        }
    }
}
