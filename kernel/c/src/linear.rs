//! Model `linear`.

use crate::bearing::{Bearing, Model};
use crate::model::{Constants, stiffness_of};
use ballrace::bearing::{Bearing as _, Reaction};
use ballrace::{BearingKinematicState, Displacement, Wrench};

/// Springs about a reference state: `f = force - stiffness (u - reference)`. The head has no elements.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Linear {
    /// Head with `&ballrace_linear_model`, NULL, 0.
    pub head: Bearing,
    /// Stiffness row by row: entry `5 i + j` is the force or moment `i` per unit of displacement `j`, SI units.
    pub stiffness: [f32; 25],
    /// Displacement of the reference state, m and rad.
    pub reference: [f32; 5],
    /// Force in the reference state, N and N m.
    pub force: [f32; 5],
}

// SAFETY: `repr(C)` with the head first.
unsafe impl Constants for Linear {
    type Bearing<'a> = ballrace::bearing::linear::Linear<f32>;

    const WORDS: u32 = 35;

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let [reference, force] = [self.reference, self.force];
        ballrace::bearing::linear::Linear::about(
            stiffness_of(&self.stiffness),
            Displacement::from_array(reference),
            Wrench::from_array(force),
        )
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction(u, at)
    }
}

/// Model of `ballrace_linear`.
#[unsafe(no_mangle)]
pub static ballrace_linear_model: Model = Model::of::<Linear>();
