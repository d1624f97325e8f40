//! Cost of a sample, a force with its check of the input, on a Cortex-M4F: the table that the tests of the target measure and check, and its interpolation
//! for element counts and solver steps between its rows.

use ballrace_models::bearing_model;
pub use ballrace_models::model::NotCounted;
use ballrace_scene::Bearing;
use serde::Serialize;

/// Bearing, N, precision, math, function, instructions, cycles, bytes of stack and bytes of flash between semicolons, written by
/// the test that counts them.
const TABLE: &str = include_str!("cortex-m4f.csv");
/// Newton steps of the table's cold and warm rows.
const COLD_STEPS: f64 = 8.0;
const WARM_STEPS: f64 = 3.0;

/// Cost of one sample on the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Instructions, the most where they depend on the input.
    pub instructions: f64,
    /// Modelled cycles.
    pub cycles: f64,
    /// Stack, bytes.
    pub stack: f64,
    /// Flash memory of the code without tables, bytes.
    pub flash: f64,
    /// True where the table has this row; else the cost is interpolated or extrapolated.
    pub counted: bool,
}

impl Cost {
    /// Returns the cost of two evaluations, one after the other, by the same code.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            cycles: self.cycles + other.cycles,
            stack: self.stack.max(other.stack),
            flash: self.flash.max(other.flash),
            counted: self.counted && other.counted,
        }
    }

    fn mixed(self, other: Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + part * (b - a);
        Self {
            instructions: mix(self.instructions, other.instructions),
            cycles: mix(self.cycles, other.cycles),
            stack: mix(self.stack, other.stack),
            flash: mix(self.flash, other.flash),
            counted: false,
        }
    }
}

struct Row {
    what: &'static str,
    elements: usize,
    precision: &'static str,
    math: &'static str,
    function: &'static str,
    cost: Cost,
}

fn rows() -> Vec<Row> {
    let row = |line: &'static str| {
        let mut cells = line.split(';');
        let mut next = || cells.next();
        let (what, elements, precision, math, function) = (next()?, next()?.parse().ok()?, next()?, next()?, next()?);
        let mut number = || cells.next()?.parse().ok();
        let [instructions, cycles, stack, flash] = [number()?, number()?, number()?, number()?];
        let cost = Cost { instructions, cycles, stack, flash, counted: true };
        Some(Row { what, elements, precision, math, function, cost })
    };
    TABLE.lines().filter_map(row).collect()
}

/// Name of a force, and of the force with its input checked, in the table: what `Bearing::sample` does in an interrupt.
const FORCE: &str = "force";
const SAMPLE: &str = "force, input checked";

/// Returns the cost of one sample of the bearing: as counted, else that of a force and the largest of a check that was counted.
///
/// # Errors
/// Returns the reason where the table has no similar bearing.
pub fn sample(of: &Bearing, precision: &str, math: &str) -> Result<Cost, NotCounted> {
    let all = rows();
    let counted = all.iter().find(|row| {
        let is_same = name(of).is_ok_and(|what| what == row.what) && (row.elements == of.elements || row.elements == 0);
        is_same && row.precision == precision && row.math == math && row.function == SAMPLE
    });
    match counted {
        Some(row) => Ok(row.cost),
        None => Ok(force(of, precision, math)?.plus(check_of_input(&all))),
    }
}

/// Returns the largest cost of a check of the input: of a sample less that of its force.
fn check_of_input(all: &[Row]) -> Cost {
    let least = Cost { instructions: 0.0, cycles: 0.0, stack: 0.0, flash: 0.0, counted: false };
    let checked = all.iter().filter(|row| row.function == SAMPLE);
    let pairs = checked.filter_map(|row| {
        let same = |other: &&Row| {
            let key = |row: &Row| (row.what, row.elements, row.precision, row.math);
            other.function == FORCE && key(other) == key(row)
        };
        all.iter().find(same).map(|force| (row.cost, force.cost))
    });
    pairs.fold(least, |most, (checked, force)| Cost {
        instructions: most.instructions.max(checked.instructions - force.instructions),
        cycles: most.cycles.max(checked.cycles - force.cycles),
        ..most
    })
}

/// Returns the cost of one force of the bearing.
fn force(of: &Bearing, precision: &str, math: &str) -> Result<Cost, NotCounted> {
    let all = rows();
    let what = name(of)?;
    // Only exact single precision is counted for balls in equilibrium.
    let cold = at(&all, what, of.elements, precision, math).ok_or(NotCounted::Arithmetic)?;
    let Some(steps) = of.own("solver_steps") else { return Ok(cold) };
    let find = |function: &str| {
        let row = all.iter().find(|r| r.what == "quasi-static, gyroscopic" && r.function == function);
        row.ok_or(NotCounted::Arithmetic)
    };
    let (full, few) = (find(FORCE)?.cost, find("force, 3 steps from the last")?.cost);
    // Every step costs the same; its share of the cost is that of the counted bearing.
    let share = |cold: f64, few: f64| 1.0 - (COLD_STEPS - steps) / (COLD_STEPS - WARM_STEPS) * (1.0 - few / cold);
    Ok(Cost {
        instructions: cold.instructions * share(full.instructions, few.instructions),
        cycles: cold.cycles * share(full.cycles, few.cycles),
        counted: false,
        ..cold
    })
}

/// Returns the name of this bearing in the table.
fn name(of: &Bearing) -> Result<&'static str, NotCounted> {
    let smooth = of.waviness.is_empty() && of.defect.is_empty() && of.has_rigid_outer_ring();
    if !smooth {
        return Err(NotCounted::Surface);
    }
    bearing_model(of.model).cortex_row(of)
}

/// Returns the row with this number of elements, or the linear interpolation of the two nearest.
fn at(all: &[Row], what: &str, elements: usize, precision: &str, math: &str) -> Option<Cost> {
    let same = |row: &&Row| row.what == what && row.precision == precision && row.math == math && row.function == FORCE;
    let mut found: Vec<&Row> = all.iter().filter(same).collect();
    if let Some(row) = found.iter().find(|row| row.elements == elements || row.elements == 0) {
        return Some(row.cost);
    }
    found.sort_by_key(|row| row.elements.abs_diff(elements));
    match found.as_slice() {
        [near, far, ..] => {
            let part = (elements as f64 - near.elements as f64) / (far.elements as f64 - near.elements as f64);
            Some(near.cost.mixed(far.cost, part))
        }
        [only] => {
            // The part independent of the elements is the transformation to the cage frame and back.
            let fixed =
                |function| all.iter().find(|r| r.what == "angular" && r.elements == 8 && r.function == function);
            let (all_of_it, inside) = (fixed(FORCE)?.cost, fixed("force, in the cage's frame")?.cost);
            let part = elements as f64 / only.elements as f64;
            let grown = |cost: f64, fixed: f64| fixed + part * (cost - fixed);
            Some(Cost {
                instructions: grown(only.cost.instructions, all_of_it.instructions - inside.instructions),
                cycles: grown(only.cost.cycles, all_of_it.cycles - inside.cycles),
                counted: false,
                ..only.cost
            })
        }
        [] => None,
    }
}
