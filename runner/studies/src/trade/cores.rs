//! Cost of a sample, a force with its check of the input, on the cores of microcontrollers: the tables that the tests of the target measure and
//! check, and their interpolation for element counts and solver steps between their rows.

use ballrace_models::bearing_model;
pub use ballrace_models::model::NotCounted;
use ballrace_scene::Bearing;
use serde::Serialize;

/// Newton steps of the table's cold and warm rows.
const COLD_STEPS: f64 = 8.0;
const WARM_STEPS: f64 = 3.0;

/// Processor core with a table of measured costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Core {
    /// Arm Cortex-M4 with its floating-point unit: cycles are modelled too.
    CortexM4f,
    /// Arm Cortex-M33 with its floating-point unit.
    CortexM33,
    /// Arm Cortex-M7 with its floating-point unit.
    CortexM7,
    /// RISC-V RV32IMAFC.
    Rv32imafc,
    /// Arm Cortex-M4 without a floating-point unit.
    CortexM4,
    /// Arm Cortex-M0+.
    CortexM0plus,
    /// RISC-V RV32IMAC.
    Rv32imac,
}

impl Core {
    /// All cores by their names.
    pub const ALL: [(&'static str, Self); 7] = [
        ("cortex-m4f", Self::CortexM4f),
        ("cortex-m33", Self::CortexM33),
        ("cortex-m7", Self::CortexM7),
        ("rv32imafc", Self::Rv32imafc),
        ("cortex-m4", Self::CortexM4),
        ("cortex-m0plus", Self::CortexM0plus),
        ("rv32imac", Self::Rv32imac),
    ];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }

    /// Returns true for a core with a floating-point unit: a force takes a constant number of instructions.
    #[must_use]
    pub const fn has_fpu(self) -> bool {
        !matches!(self, Self::CortexM4 | Self::CortexM0plus | Self::Rv32imac)
    }

    /// Returns lines of bearing, N, precision, math, function, instructions, cycles, bytes of stack and bytes of flash between semicolons, and of the
    /// least instructions where they depend on the input, written by the tests that count them. Empty is not measured.
    const fn table(self) -> &'static str {
        match self {
            Self::CortexM4f => include_str!("cores/cortex-m4f.csv"),
            Self::CortexM33 => include_str!("cores/cortex-m33.csv"),
            Self::CortexM7 => include_str!("cores/cortex-m7.csv"),
            Self::Rv32imafc => include_str!("cores/rv32imafc.csv"),
            Self::CortexM4 => include_str!("cores/cortex-m4.csv"),
            Self::CortexM0plus => include_str!("cores/cortex-m0plus.csv"),
            Self::Rv32imac => include_str!("cores/rv32imac.csv"),
        }
    }

    fn rows(self) -> Vec<Row> {
        let row = |line: &'static str| {
            let mut cells = line.split(';');
            let mut next = || cells.next();
            let (what, elements, precision, math, function) =
                (next()?, next()?.parse().ok()?, next()?, next()?, next()?);
            let mut number = || cells.next()?.parse().ok();
            let [instructions, cycles, stack, flash, least_instructions] = std::array::from_fn(|_| number());
            let cost = Cost { instructions: instructions?, least_instructions, cycles, stack, flash, counted: true };
            Some(Row { what, elements, precision, math, function, cost })
        };
        self.table().lines().filter_map(row).collect()
    }
}

/// Cost of one sample on a core.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Cost {
    /// Instructions, the most where they depend on the input.
    pub instructions: f64,
    /// The least instructions that were counted, where they depend on the input.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_instructions: Option<f64>,
    /// Modelled cycles, without wait states; `None` for a core that is not modelled.
    pub cycles: Option<f64>,
    /// Stack, bytes; `None` where it was not measured.
    pub stack: Option<f64>,
    /// Flash memory of the code without tables, bytes; `None` where it was not measured.
    pub flash: Option<f64>,
    /// True where the table has this row; else the cost is interpolated or extrapolated.
    pub counted: bool,
}

impl Cost {
    /// Returns the cost of two evaluations, one after the other, by the same code.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let both = |f: fn(f64, f64) -> f64, part: fn(&Self) -> Option<f64>| Some(f(part(&self)?, part(&other)?));
        let sum = |a: f64, b: f64| a + b;
        Self {
            instructions: self.instructions + other.instructions,
            least_instructions: self.plus_least(&other),
            cycles: both(sum, |cost| cost.cycles),
            stack: both(f64::max, |cost| cost.stack),
            flash: both(f64::max, |cost| cost.flash),
            counted: self.counted && other.counted,
        }
    }

    /// Returns the sum of the least instructions, where one of the two costs depends on the input.
    fn plus_least(&self, other: &Self) -> Option<f64> {
        self.least_instructions.or(other.least_instructions)?;
        let least = |cost: &Self| cost.least_instructions.unwrap_or(cost.instructions);
        Some(least(self) + least(other))
    }

    /// Returns the cost whose figures are those of this one, each changed.
    fn map(self, change: impl Fn(fn(&Self) -> Option<f64>, f64) -> f64) -> Self {
        let changed = |part: fn(&Self) -> Option<f64>| Some(change(part, part(&self)?));
        Self {
            instructions: changed(|cost| Some(cost.instructions)).unwrap_or(self.instructions),
            least_instructions: changed(|cost| cost.least_instructions),
            cycles: changed(|cost| cost.cycles),
            counted: false,
            ..self
        }
    }

    fn mixed(self, other: &Self, part: f64) -> Self {
        let mix = |of: fn(&Self) -> Option<f64>, a: f64| a + part * (of(other).unwrap_or(a) - a);
        let bytes = |of: fn(&Self) -> Option<f64>| of(&self).map(|a| mix(of, a));
        Self { stack: bytes(|cost| cost.stack), flash: bytes(|cost| cost.flash), ..self.map(mix) }
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

/// Name of a force, and of the force with its input checked, in the table: what `Bearing::sample` does in an interrupt.
const FORCE: &str = "force";
const SAMPLE: &str = "force, input checked";

/// Returns the cost of one sample of the bearing: as counted, else that of a force and the largest of a check that was counted.
///
/// # Errors
/// Returns the reason where the table has no similar bearing.
pub fn sample(core: Core, of: &Bearing, precision: &str, math: &str) -> Result<Cost, NotCounted> {
    let all = core.rows();
    let counted = all.iter().find(|row| {
        let is_same = name(of).is_ok_and(|what| what == row.what) && (row.elements == of.elements || row.elements == 0);
        is_same && row.precision == precision && row.math == math && row.function == SAMPLE
    });
    match counted {
        Some(row) => Ok(row.cost),
        None => Ok(force(&all, of, precision, math)?.plus(check_of_input(&all))),
    }
}

/// Returns the largest cost of a check of the input: of a sample less that of its force.
fn check_of_input(all: &[Row]) -> Cost {
    let checked = all.iter().filter(|row| row.function == SAMPLE);
    let pairs = checked.filter_map(|row| {
        let same = |other: &&Row| {
            let key = |row: &Row| (row.what, row.elements, row.precision, row.math);
            other.function == FORCE && key(other) == key(row)
        };
        all.iter().find(same).map(|force| (row.cost, force.cost))
    });
    let none = Cost { cycles: Some(0.0), stack: Some(0.0), flash: Some(0.0), ..Cost::default() };
    pairs.fold(none, |most, (checked, force)| Cost {
        instructions: most.instructions.max(checked.instructions - force.instructions),
        cycles: most
            .cycles
            .zip(checked.cycles.zip(force.cycles))
            .map(|(most, (checked, force))| most.max(checked - force)),
        ..most
    })
}

/// Returns the cost of one force of the bearing.
fn force(all: &[Row], of: &Bearing, precision: &str, math: &str) -> Result<Cost, NotCounted> {
    let what = name(of)?;
    // Only exact single precision is counted for balls in equilibrium.
    let cold = at(all, what, of.elements, precision, math).ok_or(NotCounted::Arithmetic)?;
    let Some(steps) = of.own("solver_steps") else { return Ok(cold) };
    let find = |function: &str| {
        let row = all.iter().find(|r| r.what == "quasi-static, gyroscopic" && r.function == function);
        row.ok_or(NotCounted::Arithmetic)
    };
    let (full, few) = (find(FORCE)?.cost, find("force, 3 steps from the last")?.cost);
    // Every step costs the same; its share of the cost is that of the counted bearing.
    let share = |cold: f64, few: f64| 1.0 - (COLD_STEPS - steps) / (COLD_STEPS - WARM_STEPS) * (1.0 - few / cold);
    Ok(cold.map(|part, cost| cost * part(&full).zip(part(&few)).map_or(1.0, |(full, few)| share(full, few))))
}

/// Returns the name of this bearing in the table.
fn name(of: &Bearing) -> Result<&'static str, NotCounted> {
    let smooth = of.waviness.is_empty() && of.defect.is_empty() && of.has_rigid_outer_ring();
    if !smooth {
        return Err(NotCounted::Surface);
    }
    bearing_model(of.model).counted_row(of)
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
            Some(near.cost.mixed(&far.cost, part))
        }
        [only] => {
            // The part independent of the elements is the transformation to the cage frame and back.
            let fixed =
                |function| all.iter().find(|r| r.what == "angular" && r.elements == 8 && r.function == function);
            let (all_of_it, inside) = (fixed(FORCE)?.cost, fixed("force, in the cage's frame")?.cost);
            let part = elements as f64 / only.elements as f64;
            Some(only.cost.map(|figure, cost| {
                let fixed = figure(&all_of_it).zip(figure(&inside)).map_or(0.0, |(all, inside)| all - inside);
                fixed + part * (cost - fixed)
            }))
        }
        [] => None,
    }
}
