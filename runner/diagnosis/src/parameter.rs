//! Parameters of a machine that a fit varies: steps, bounds and value. Those of a fault are in its file.

use super::machine::{Machine, MachineBearing};
use super::motion::Motion;

/// A kind of parameter. Its unknowns are one of each bearing, of each spall, of each direction.
pub struct Parameter {
    /// Step of a difference quotient, in the unit of the parameter.
    pub step: f64,
    /// Returns the longest step within which the residual is about linear, from the number of elements of the bearing and of
    /// revolutions of the record.
    pub longest_step: fn(f64, f64) -> f64,
    /// True if the mean stiffness or damping of the machine depends on it.
    pub changes_stiffness: bool,
    pub access: Access,
}

/// Reads the parameter with an index, and sets it to the nearest value within its bounds.
pub enum Access {
    Bearing {
        get: fn(&MachineBearing, usize) -> f64,
        set: fn(&mut MachineBearing, usize, f64),
    },
    Rotor {
        get: fn(&Machine, usize) -> f64,
        set: fn(&mut Machine, usize, f64),
    },
    /// Reading of a probe, whose index stands for that of a bearing.
    Reading,
}

/// Longest step of a parameter on which the residual depends linearly.
pub const LINEAR: fn(f64, f64) -> f64 = |_, _| f64::INFINITY;

impl Parameter {
    pub const fn of_bearing(&'static self, bearing: usize) -> Unknown {
        self.of_bearing_at(bearing, 0)
    }

    pub(crate) const fn of_bearing_at(&'static self, bearing: usize, index: usize) -> Unknown {
        Unknown { parameter: self, bearing, index }
    }

    pub(crate) const fn of_rotor(&'static self, index: usize) -> Unknown {
        Unknown { parameter: self, bearing: 0, index }
    }
}

/// A parameter that a hypothesis varies.
#[derive(Clone, Copy)]
pub struct Unknown {
    pub parameter: &'static Parameter,
    /// 0 where the parameter is the rotor's, the probe where it is of a reading.
    pub bearing: usize,
    index: usize,
}

impl PartialEq for Unknown {
    fn eq(&self, other: &Self) -> bool {
        self.is(other.parameter) && (self.bearing, self.index) == (other.bearing, other.index)
    }
}

/// Part of the machine whose force a parameter changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ForceSource {
    Bearing(usize),
    Rotor,
    Readings,
}

impl Unknown {
    pub fn is(self, parameter: &'static Parameter) -> bool {
        std::ptr::eq(self.parameter, parameter)
    }

    /// Returns true for the angle and the speed of a cage.
    pub(crate) fn is_of_cage(self) -> bool {
        [&CAGE_PHASE, &CAGE_SLIP, &CAGE_DRIFT].into_iter().any(|parameter| self.is(parameter))
    }

    /// Returns the revolutions of a cage per unit of its angle, slip or drift at `turns` revolutions of the shaft; `rolling` is the speed of a
    /// cage that rolls over the shaft speed.
    pub(crate) fn turns_of_cage(self, rolling: f64, turns: f64, motion: &Motion) -> f64 {
        if self.is(&CAGE_SLIP) {
            -rolling * turns
        } else if self.is(&CAGE_DRIFT) {
            0.5 * (turns - motion.middle).powi(2)
        } else {
            1.0
        }
    }

    pub fn part(self) -> ForceSource {
        match self.parameter.access {
            Access::Bearing { .. } => ForceSource::Bearing(self.bearing),
            Access::Rotor { .. } => ForceSource::Rotor,
            Access::Reading => ForceSource::Readings,
        }
    }

    pub fn get(self, machine: &Machine) -> f64 {
        match self.parameter.access {
            Access::Bearing { get, .. } => get(&machine.bearings[self.bearing], self.index),
            Access::Rotor { get, .. } => get(machine, self.index),
            Access::Reading => machine.readings[self.bearing][self.index],
        }
    }

    pub fn set(self, machine: &mut Machine, x: f64) {
        match self.parameter.access {
            Access::Bearing { set, .. } => set(&mut machine.bearings[self.bearing], self.index, x),
            Access::Rotor { set, .. } => set(machine, self.index, x),
            Access::Reading => machine.readings[self.bearing][self.index] = x,
        }
    }
}

/// Returns `first` with those of `others` that it has not.
pub fn union(mut first: Vec<Unknown>, others: &[Unknown]) -> Vec<Unknown> {
    for unknown in others {
        if !first.contains(unknown) {
            first.push(*unknown);
        }
    }
    first
}

/// Least value of a positive parameter after a step, over the one before: no step makes a stiffness or a damping negative.
const LEAST_OF_BEFORE: f64 = 1e-3;

/// Angle of a cage.
pub(crate) static CAGE_PHASE: Parameter = Parameter {
    step: 1e-6,
    longest_step: |elements, _| 0.1 / elements,
    changes_stiffness: false,
    access: Access::Bearing { get: |bearing, _| bearing.cage.phase, set: |bearing, _, x| bearing.cage.phase = x },
};

/// Cage speed below pure rolling.
pub(crate) static CAGE_SLIP: Parameter = Parameter {
    step: 1e-8,
    longest_step: |elements, turns| 0.2 / (elements * 0.4 * turns),
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, _| bearing.cage.slip,
        set: |bearing, _, x| bearing.cage.slip = x.clamp(-0.02, 0.08),
    },
};

/// Change of the cage speed; the longest step is that at the ends of the record.
pub(crate) static CAGE_DRIFT: Parameter = Parameter {
    step: 1e-10,
    longest_step: |elements, turns| 0.1 / (elements * 0.125 * turns * turns),
    changes_stiffness: false,
    access: Access::Bearing { get: |bearing, _| bearing.cage.drift, set: |bearing, _, x| bearing.cage.drift = x },
};

/// Ball spin below pure rolling.
pub(crate) static SPIN_SLIP: Parameter = Parameter {
    step: 1e-8,
    longest_step: |elements, turns| 0.2 / (elements * 0.4 * turns),
    changes_stiffness: false,
    access: Access::Bearing {
        get: |bearing, _| bearing.cage.spin_slip,
        set: |bearing, _, x| bearing.cage.spin_slip = x.clamp(-0.05, 0.05),
    },
};

/// Young's modulus of a bearing.
pub(crate) static MODULUS: Parameter = Parameter {
    step: 1e6,
    longest_step: |_, _| 2e10,
    changes_stiffness: true,
    access: Access::Bearing {
        get: |bearing, _| bearing.scene.geometry.map_or(0.0, |g| g.youngs_modulus),
        set: |bearing, _, x| {
            if let Some(g) = &mut bearing.scene.geometry {
                g.youngs_modulus = x.max(LEAST_OF_BEFORE * g.youngs_modulus);
            }
        },
    },
};

/// Damping of the translations (0) or rotations (1) of the rotor.
pub static DAMPING: Parameter = Parameter {
    step: 0.01,
    longest_step: |_, _| 1e3,
    changes_stiffness: true,
    access: Access::Rotor {
        get: |machine, i| machine.damping[3 * i],
        set: |machine, i, x| {
            let range = if i == 0 { 0..3 } else { 3..5 };
            let before = machine.damping[3 * i];
            let factor = x.max(LEAST_OF_BEFORE * before) / before;
            machine.damping[range].iter_mut().for_each(|c| *c *= factor);
        },
    },
};
