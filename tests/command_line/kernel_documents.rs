//! The kernel's overview: its instruction counts are those of the chapter.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn cells(row: &str) -> Vec<&str> {
    row.trim().trim_matches('|').split('|').map(str::trim).collect()
}

/// Returns the figure of the performance chapter for a model: instructions and cycles of a force with eight elements.
fn figure(chapter: &str, model: &str) -> String {
    let (_, counts) = chapter.split_once("<!-- counts:begin -->").expect("the mark of the counts");
    let row = counts.lines().map(cells).find(|row| row[0] == model && row.len() == 5);
    let row = row.unwrap_or_else(|| panic!("docs/src/performance.md has no row {model:?}"));
    // The table by element count has N = 4 first; the table of single functions has instructions and cycles.
    if row[2].contains('(') { row[2].to_owned() } else { format!("{} ({})", row[1], row[2]) }
}

/// `BALLRACE_WRITE=1` copies the figures from the chapter.
#[test]
fn the_kernel_overview_has_the_instruction_counts_of_the_chapter() {
    let path = root().join("kernel/README.md");
    let (chapter, text) =
        (fs::read_to_string(root().join("docs/src/performance.md")).unwrap(), fs::read_to_string(&path).unwrap());
    let rows = text.lines().skip_while(|line| !line.starts_with("| model |")).skip(2);
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    assert!(rows.len() >= 10, "{rows:?}");
    let mut current = text.clone();
    for row in rows {
        let row_cells = cells(row);
        let stated = row_cells[3];
        current = current
            .replace(row, &row.replace(&format!("| {stated} |"), &format!("| {} |", figure(&chapter, row_cells[0]))));
    }
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        fs::write(path, current).unwrap();
    } else {
        assert_eq!(text, current, "BALLRACE_WRITE=1 copies the figures");
    }
}
