//! The kernel's overview and examples: instruction counts are those of the chapter, results balance.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

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

/// Returns the lines that an example of the kernel prints, as names and numbers.
fn example(name: &str) -> Vec<(String, Vec<f64>)> {
    let output = Command::new(env!("CARGO"))
        .args(["run", "--release", "-p", "ballrace", "--example", name])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let line = |line: &str| {
        let (name, numbers) = line.split_once(',').unwrap();
        (name.to_owned(), numbers.split(',').map(|x| x.parse().unwrap()).collect())
    };
    text.lines().map(line).collect()
}

fn row<'a>(rows: &'a [(String, Vec<f64>)], name: &str) -> &'a [f64] {
    &rows.iter().find(|row| row.0 == name).unwrap_or_else(|| panic!("no row {name}: {rows:?}")).1
}

#[test]
fn the_example_of_an_equilibrium_balances_its_load() {
    let rows = example("equilibrium");
    let force = row(&rows, "force_N");
    for (force, load) in force.iter().zip([1000.0, 0.0, 200.0]) {
        assert!((force + load).abs() < 1e-6, "{rows:?}");
    }
    let loads: Vec<f64> = rows.iter().filter(|row| row.0 == "ball").map(|row| row.1[1]).collect();
    assert_eq!(loads.len(), 9);
    // The ball in the direction of the load carries most; the load zone is symmetric.
    assert!(loads[1..].iter().all(|load| *load < loads[0]), "{loads:?}");
    assert!((loads[1] - loads[8]).abs() < 1e-6, "{loads:?}");
}

#[test]
fn the_example_of_a_rotor_carries_weight_and_load() {
    let rows = example("rotor");
    assert_eq!(row(&rows, "held_steps"), [0.0]);
    let force = row(&rows, "mean_force_N");
    for (force, expected) in force.iter().zip([0.0, 6.0 * 9.806_65, -100.0]) {
        assert!((force - expected).abs() < 0.5, "{rows:?}");
    }
    assert!(row(&rows, "peak_to_peak_um").iter().all(|um| (0.01..100.0).contains(um)), "{rows:?}");
}
