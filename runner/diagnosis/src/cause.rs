//! Causes of a departure from the healthy machine.

use super::machine::Machine;
use super::surface::Component;

/// Cause of a departure from the healthy machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    Unbalance,
    Load,
    Clearance(usize),
    Misalignment(usize),
    Spall(usize, Component),
    Waviness(usize, Component, u32),
}

impl Cause {
    /// Returns the bearing whose cage angle the fault makes observable. Waviness that all elements share does not.
    pub fn shows_cage(self) -> Option<usize> {
        match self {
            Self::Spall(b, _) | Self::Waviness(b, Component::Outer | Component::Inner, _) => Some(b),
            _ => None,
        }
    }

    /// Returns the index at which `machine` takes a further spall or first wave of this cause.
    pub fn next_index(self, machine: &Machine) -> usize {
        match self {
            Self::Spall(b, _) => machine.bearings[b].scene.defect.len(),
            Self::Waviness(b, ..) => machine.bearings[b].scene.waviness.len(),
            _ => 0,
        }
    }
}
