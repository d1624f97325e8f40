//! A unit for co-simulation by FMI 3.0: the rotor of a scene, or one of its bearings, with named variables.
//!
//! Another program exchanges the variables at communication points: displacement in and force out of a bearing, external force in
//! and motion out of a rotor. The motion is that of [`motion`](ballrace_plant::motion), bit for bit.

mod description;
mod machine;
mod resources;
mod variable;

pub use description::model_description;
pub use resources::{Resources, platform};
pub use variable::{Causality, Variable};

use ballrace_plant::error::{Result, UnitError};
use ballrace_scene::Scene;
use machine::Machine;
use std::path::Path;

/// Largest deviation of a communication step from a multiple of the internal step, over the step, and of a communication point from
/// the time of the unit, over the point: rounding of the sums of a host.
const ROUNDING: f64 = 1e-9;
/// Largest deviation of a communication point from the time of the unit, over the internal step.
const NEAR: f64 = 0.01;

/// What a unit contains.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// The rotor on its bearings, with this number of internal steps per second, Hz.
    Rotor {
        /// Above 0.
        rate: f64,
    },
    /// The bearing of this name.
    Bearing {
        /// Name in the scene.
        name: String,
    },
}

/// A running unit.
pub struct Unit {
    variables: Vec<Variable>,
    machine: Machine,
    /// Time at which the unit starts, s.
    start: f64,
    /// Time beyond which it is not stepped, s; infinite without end.
    stop: f64,
    /// Time since then, s.
    elapsed: f64,
    inputs: Vec<f64>,
    /// Outputs, with the status last.
    outputs: Vec<f64>,
    /// True where inputs were set after the outputs were computed.
    is_stale: bool,
}

impl Unit {
    /// Opens a unit from the folder of its resources.
    ///
    /// # Errors
    /// A file that cannot be read or is invalid, a `token` that is not that of the files and of this version.
    pub fn open(folder: &Path, token: &str) -> Result<Self> {
        let (scene, content) = resources::open(folder, token)?;
        Self::try_new(&scene, &content)
    }

    /// Creates the unit at time 0.
    ///
    /// # Errors
    /// A scene without rotor or without such a bearing, a parameter that the kernel rejects.
    pub fn try_new(scene: &Scene, content: &Content) -> Result<Self> {
        let machine = Machine::try_new(scene, content)?;
        let variables = machine.variables();
        let mut unit = Self {
            variables,
            machine,
            start: 0.0,
            stop: f64::INFINITY,
            elapsed: 0.0,
            inputs: vec![],
            outputs: vec![],
            is_stale: true,
        };
        unit.inputs = unit.start_values();
        Ok(unit)
    }

    fn start_values(&self) -> Vec<f64> {
        self.variables.iter().filter(|variable| variable.causality == Causality::Input).map(|v| v.start).collect()
    }

    /// Returns the variables; the value reference of each is its index. Time is first, then inputs, outputs, and the status.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Returns the internal step, s; none where a step has any length.
    #[must_use]
    pub fn internal_step(&self) -> Option<f64> {
        self.machine.internal_step()
    }

    /// Returns true where each output depends on the inputs of the same time.
    #[must_use]
    pub const fn is_direct(&self) -> bool {
        matches!(self.machine, Machine::Bearing(_))
    }

    /// Returns the unit to its state after [`Unit::try_new`].
    ///
    /// # Errors
    /// As [`Unit::try_new`].
    pub fn reset(&mut self) -> Result<()> {
        self.machine.reset()?;
        self.inputs = self.start_values();
        (self.start, self.stop, self.elapsed, self.is_stale) = (0.0, f64::INFINITY, 0.0, true);
        self.outputs.clear();
        Ok(())
    }

    /// Sets the time at which the unit starts, time 0 of the scene, and the time beyond which it is not stepped, s.
    pub const fn run_from(&mut self, start: f64, stop: f64) {
        (self.start, self.stop) = (start, stop);
    }

    /// Returns a copy that goes on as this unit does, bit for bit.
    #[must_use]
    pub fn copy(&self) -> Self {
        let (variables, machine) = (self.variables.clone(), self.machine.copy());
        let (inputs, outputs) = (self.inputs.clone(), self.outputs.clone());
        Self { variables, machine, inputs, outputs, ..*self }
    }

    /// Returns the time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.start + self.elapsed
    }

    /// Returns the variable of this value reference.
    ///
    /// # Errors
    /// No such variable.
    pub fn variable(&self, reference: u32) -> Result<&Variable, UnitError> {
        let found = usize::try_from(reference).ok().and_then(|i| self.variables.get(i));
        found.ok_or(UnitError::Reference { found: reference, most: self.variables.len() - 1 })
    }

    /// Returns the value of a variable.
    ///
    /// # Errors
    /// No such variable; a bearing that the kernel rejects.
    pub fn get(&mut self, reference: u32) -> Result<f64> {
        let causality = self.variable(reference)?.causality;
        let place = (reference as usize).saturating_sub(1);
        Ok(match causality {
            Causality::Independent => self.time(),
            Causality::Input => self.inputs.get(place).copied().unwrap_or(0.0),
            Causality::Output => {
                if self.is_stale {
                    self.machine.evaluate(&self.inputs, self.elapsed, &mut self.outputs)?;
                    self.is_stale = false;
                }
                self.outputs.get(place - self.inputs.len()).copied().unwrap_or(0.0)
            }
        })
    }

    /// Returns the input of this value reference.
    ///
    /// # Errors
    /// No such input.
    pub fn input(&self, reference: u32) -> Result<&Variable, UnitError> {
        let variable = self.variable(reference)?;
        if variable.causality != Causality::Input {
            return Err(UnitError::NotAnInput { name: variable.name.clone() });
        }
        Ok(variable)
    }

    /// Sets an input.
    ///
    /// # Errors
    /// No such input.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), UnitError> {
        self.input(reference)?;
        if let Some(input) = self.inputs.get_mut((reference as usize).saturating_sub(1)) {
            *input = value;
        }
        self.is_stale = true;
        Ok(())
    }

    /// Advances from the communication point `point` by `length`, s, with the present inputs.
    ///
    /// # Errors
    /// Another point than the present time, a length that is no whole number of internal steps, a motion that overflows.
    pub fn step(&mut self, point: f64, length: f64) -> Result<()> {
        let internal = self.internal_step();
        let expected = self.time();
        let allowed = NEAR * internal.unwrap_or(length) + ROUNDING * point.abs();
        if !point.is_finite() || (point - expected).abs() > allowed {
            return Err(UnitError::Point { found: point, expected }.into());
        }
        if !(length > 0.0 && length.is_finite()) {
            return Err(UnitError::NoLength { found: length }.into());
        }
        if point + length > self.stop + allowed {
            return Err(UnitError::Beyond { found: point + length, stop: self.stop }.into());
        }
        let Some(internal) = internal else {
            (self.elapsed, self.is_stale) = (point - self.start + length, true);
            return Ok(());
        };
        let steps = (length / internal).round().max(1.0);
        if (length - steps * internal).abs() > ROUNDING * length {
            return Err(UnitError::Step { found: length, internal, near: steps * internal }.into());
        }
        self.elapsed = self.machine.advance(&self.inputs, steps as u64, &mut self.outputs)?;
        self.is_stale = false;
        Ok(())
    }
}
