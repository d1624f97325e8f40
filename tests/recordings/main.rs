//! Recordings of real machines by others, as far as they fit (README.md here).

mod rotor_kit;
mod support_force;

/// Columns of a small CSV file with a header.
fn columns<const N: usize>(text: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let mut values = [0.0; N];
        for (value, cell) in values.iter_mut().zip(line.split(',')) {
            *value = cell.trim().parse().expect("a number");
        }
        values
    };
    text.lines().skip(1).filter(|l| !l.trim().is_empty()).map(row).collect()
}
