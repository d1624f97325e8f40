//! Results of the examples of the kernel balance.

use std::process::Command;

/// Compiles an example as `tests/run kernel` has compiled it.
const COMMAND: &str = "run --locked --release --config tests/checked.toml -p ballrace --features serde --example";

/// Returns the lines that an example of the kernel prints, as names and numbers.
fn example(name: &str) -> Vec<(String, Vec<f64>)> {
    let output = Command::new(env!("CARGO"))
        .args(COMMAND.split(' '))
        .arg(name)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
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
