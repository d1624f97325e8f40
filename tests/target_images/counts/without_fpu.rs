//! Instructions of a sample on cores without a floating-point unit, held in `docs/src/performance.md`: on counts, the same for every input, and in
//! software floats.

use super::{CHAPTER, MARGIN, Name, SLACK, Subject, chapter, compiler, hold_known};
use crate::{Board, COUNTING, RISC_V, build, printed};
use std::fmt::Write;

const BEGIN: &str = "<!-- without-fpu:begin -->\n";
const END: &str = "<!-- without-fpu:end -->";
const HEAD: &str = "| model | N | Cortex-M4 without FPU | Cortex-M0+ | RV32IMAC |\n| --- | --: | --: | --: | --: |\n";
/// Table that the runner reads, target and board of each column. The board of the Cortex-M0+ has a Cortex-M3, which runs its code as it is.
const CORES: [(&str, &str, Board); 3] = [
    ("cortex-m4", "thumbv7em-none-eabi", Board::arm("mps2-an386")),
    ("cortex-m0plus", "thumbv6m-none-eabi", Board::arm("mps2-an385")),
    ("rv32imac", "riscv32imac-unknown-none-elf", RISC_V),
];

fn measured() -> Vec<Vec<Subject>> {
    let targets = CORES.map(|(_, target, _)| target);
    let images = build("images", "release", &["counts"], &targets, &["--bin", "without_fpu"]);
    let run = |(_, target, board): (&str, &str, Board)| {
        let image = images.join(target).join("release/without_fpu");
        let text = String::from_utf8(printed(board.command(&image).args(COUNTING))).expect("text");
        text.lines().map(Subject::parse).collect()
    };
    CORES.into_iter().map(run).collect()
}

/// The force on counts, and a sample in software floats as an interrupt calls it.
fn is_shown(name: &Name) -> bool {
    name.precision == "Q31" || name.function == "force, input checked" && name.elements != 9
}

fn section(cores: &[Vec<Subject>]) -> String {
    let mut text = HEAD.to_owned();
    for (row, subject) in cores[0].iter().enumerate().filter(|(_, subject)| is_shown(&subject.name)) {
        let of_core = |core: &Vec<Subject>| {
            let Subject { name, least, most, .. } = &core[row];
            assert!(*name == subject.name, "the cores count the same");
            assert!(
                name.precision != "Q31" || least == most,
                "{name}: {least} to {most}: the count depends on the input"
            );
            if least == most { most.to_string() } else { format!("{least} to {most}") }
        };
        let Name { what, elements, precision, .. } = &subject.name;
        let of = if precision == "Q31" { "fixed-point" } else { "`f32` in software" };
        let cells: Vec<String> = cores.iter().map(of_core).collect();
        writeln!(text, "| {what}, {of} | {elements} | {} |", cells.join(" | ")).expect("a string takes it");
    }
    text
}

/// All numbers of a row.
fn numbers(line: &str) -> Vec<f64> {
    line.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse().ok()).collect()
}

#[test]
#[ignore = "needs qemu-system-arm, qemu-system-misc and three targets; tests/run runs it"]
fn fixed_point_takes_a_constant_number_of_instructions_without_a_floating_point_unit() {
    let text = std::fs::read_to_string(chapter()).expect(CHAPTER);
    let begin = text.find(BEGIN).expect("a mark where the table begins") + BEGIN.len();
    let end = begin + text[begin..].find(END).expect("a mark where the table ends");
    let measured = measured();
    for ((core, ..), subjects) in CORES.into_iter().zip(&measured) {
        hold_known(core, subjects);
    }
    let found = section(&measured);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(chapter(), format!("{}{found}{}", &text[..begin], &text[end..])).expect(CHAPTER);
        return;
    }
    if !text.contains(&format!("Compiled by {},", compiler())) {
        println!("{CHAPTER}: figures of another compiler than {}: not compared", compiler());
        return;
    }
    let stated = &text[begin..end];
    assert_eq!(stated.lines().count(), found.lines().count(), "BALLRACE_WRITE=1 rewrites the table of {CHAPTER}");
    for (stated, found) in stated.lines().zip(found.lines()) {
        let (a, b) = (numbers(stated), numbers(found));
        let is_held = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (b - a).abs() <= MARGIN * a + SLACK);
        assert!(is_held, "{found}; {CHAPTER} has {stated}: BALLRACE_WRITE=1 rewrites it");
    }
}
