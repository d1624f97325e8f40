//! Instructions of what firmware takes on other cores than the Cortex-M4F, held in `docs/src/performance.md`.

use super::{CHAPTER, MARGIN, Name, SLACK, Subject, chapter, compiler, hold_known, table};
use crate::{Board, COUNTING, FPU, RISC_V, build, printed};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- cores:begin -->\n";
const END: &str = "<!-- cores:end -->";
const HEAD: &str =
    "| f32 | N | Cortex-M4F | Cortex-M33 | Cortex-M7 | RV32IMAFC |\n| --- | --: | --: | --: | --: | --: |\n";
const M33: &str = "thumbv8m.main-none-eabihf";
const RISC_V_TARGET: &str = "riscv32imafc-unknown-none-elf";
/// The target's code as the compiler writes it for a Cortex-M7, which predicts branches.
const FOR_M7: [&str; 2] = ["--config", "target.thumbv7em-none-eabihf.rustflags=[\"-Ctarget-cpu=cortex-m7\"]"];

/// Builds the image for each core.
fn images() -> [PathBuf; 3] {
    let bin = ["--bin", "cores"];
    let both = build("images", "release", &["counts"], &[M33, RISC_V_TARGET], &bin);
    let m7 = build("images-m7", "release", &["counts"], &[FPU], &[&bin[..], &FOR_M7].concat());
    [(&both, M33), (&m7, FPU), (&both, RISC_V_TARGET)].map(|(folder, target)| folder.join(target).join("release/cores"))
}

fn subjects(board: Board, image: &Path) -> Vec<Subject> {
    let text = String::from_utf8(printed(board.command(image).args(COUNTING))).expect("text");
    text.lines().map(Subject::parse).collect()
}

/// Returns the name of each row and its cells.
fn rows(m4f: &[table::Row]) -> Vec<(Name, [String; 4])> {
    let [m33, m7, risc_v] = images();
    let m33 = subjects(Board::arm("mps2-an505"), &m33);
    let m7 = subjects(Board::arm("mps2-an500"), &m7);
    let risc_v = subjects(RISC_V, &risc_v);
    for (core, subjects) in [("cortex-m33", &m33), ("cortex-m7", &m7), ("rv32imafc", &risc_v)] {
        hold_known(core, subjects);
    }
    let wanted = m33.iter().zip(&m7).zip(&risc_v).filter(|((subject, _), _)| ![4, 16].contains(&subject.name.elements));
    wanted
        .map(|((m33, m7), risc_v)| {
            assert!(m33.name == m7.name && m33.name == risc_v.name, "the cores count the same: {}", m33.name);
            assert_eq!(m33.least, m33.most, "{}: the count depends on the input", m33.name);
            let m4f = m4f.iter().find(|row| row.name == m33.name).map_or(0, |row| row.most);
            (m33.name.clone(), [m4f.to_string(), m33.most.to_string(), range(m7), range(risc_v)])
        })
        .collect()
}

/// Returns the counts over the inputs. Selections by short branches may change them a little.
fn range(Subject { name, least, most, .. }: &Subject) -> String {
    assert!(f64::from(*most) / f64::from(*least) < 1.1, "{name}: {least} to {most}");
    if least == most { most.to_string() } else { format!("{least} to {most}") }
}

fn section(rows: &[(Name, [String; 4])]) -> String {
    let mut text = HEAD.to_owned();
    for (Name { what, elements, function, .. }, cells) in rows {
        writeln!(text, "| {what}: {function} | {elements} | {} |", cells.join(" | ")).expect("a string takes it");
    }
    text
}

/// The numbers of a row, by the last of each cell.
fn counts(line: &str) -> Vec<f64> {
    let cells = line.trim_matches('|').split('|').skip(2);
    cells.filter_map(|cell| cell.split_whitespace().last()?.parse().ok()).collect()
}

#[test]
#[ignore = "needs qemu-system-arm, qemu-system-misc and two targets; tests/run runs it"]
fn counts_on_other_cores_match_the_documented_table() {
    let text = std::fs::read_to_string(chapter()).expect(CHAPTER);
    let (_, stated, _) = table::split(&text);
    let rows = rows(&table::read(stated));
    let begin = text.find(BEGIN).expect("a mark where the table begins") + BEGIN.len();
    let end = begin + text[begin..].find(END).expect("a mark where the table ends");
    let found = section(&rows);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(chapter(), format!("{}{found}{}", &text[..begin], &text[end..])).expect(CHAPTER);
        return;
    }
    if !stated.contains(&format!("Compiled by {},", compiler())) {
        println!("{CHAPTER}: figures of another compiler than {}: not compared", compiler());
        return;
    }
    let stated = &text[begin..end];
    assert_eq!(stated.lines().count(), found.lines().count(), "BALLRACE_WRITE=1 rewrites the table of {CHAPTER}");
    for (stated, found) in stated.lines().zip(found.lines()).skip(2) {
        for (a, b) in counts(stated).into_iter().zip(counts(found)) {
            assert!(
                (b - a).abs() <= MARGIN * a + SLACK,
                "{found}; {CHAPTER} has {stated}: BALLRACE_WRITE=1 rewrites it"
            );
        }
    }
}
