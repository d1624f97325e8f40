//! Model `roller`: rollers by laminae, both contacts in series.

use crate::bearing::{Bearing, Model};
use crate::model::{BlobArray, Constants};
use crate::pointer;
use ballrace::bearing::roller::{LaminaRoller, RollerConstants};
use ballrace::bearing::{CageFrame, ElementPosition, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact};

/// One lamina of a roller.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Lamina {
    /// Position of its centre along the axis of the roller, m.
    pub position: f32,
    /// Profile drop at both contacts together, m.
    pub drop: f32,
}

// The kernel reads an array of laminae in place.
const _: () = {
    type KernelLamina = ballrace::bearing::roller::Lamina<f32>;
    assert!(size_of::<Lamina>() == size_of::<KernelLamina>() && align_of::<Lamina>() == align_of::<KernelLamina>());
    assert!(core::mem::offset_of!(Lamina, drop) == core::mem::offset_of!(KernelLamina, drop));
};

/// A cylindrical, needle or tapered roller bearing by laminae.
///
/// Models: `ballrace_roller_model`, and `ballrace_roller_mirrored_model` for a bearing that carries thrust towards -Z.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Roller {
    /// Head.
    pub head: Bearing,
    /// K/n, stiffness of one lamina with both contacts in series, N/m^(10/9).
    pub stiffness: f32,
    /// R, pitch radius, m.
    pub arm: f32,
    /// Cosine of the contact angle.
    pub axis_cos: f32,
    /// Sine of the contact angle.
    pub axis_sin: f32,
    /// Radial play times the cosine of the contact angle, m; negative is preload.
    pub play: f32,
    /// Number of laminae.
    pub lamina_count: u32,
    /// Laminae of each roller.
    pub laminae: *const Lamina,
}

// SAFETY: `repr(C)` with the head first.
unsafe impl Constants for Roller {
    type Bearing<'a> =
        LaminaRoller<f32, Exact, &'a [ElementPosition<f32>], &'a [ballrace::bearing::roller::Lamina<f32>]>;

    const WORDS: u32 = 6;
    const ARRAY: Option<BlobArray> = Some(BlobArray { offset: core::mem::offset_of!(Roller, laminae), numbers: 2 });

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let constants = RollerConstants {
            stiffness: self.stiffness,
            arm: self.arm,
            axis: [self.axis_cos, self.axis_sin],
            play: self.play,
        };
        // SAFETY: the pointers are valid by the contract of the function; a `Lamina` has the layout of the kernel's.
        let (positions, laminae) = unsafe {
            (
                self.head.positions(),
                pointer::slice(self.laminae.cast::<ballrace::bearing::roller::Lamina<f32>>(), self.lamina_count),
            )
        };
        LaminaRoller::from_constants(positions, constants, laminae)
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction_inlined(u, at)
    }
}

/// Model of `ballrace_roller`, which carries thrust where the inner ring moves towards +Z.
#[unsafe(no_mangle)]
pub static ballrace_roller_model: Model = Model::of::<Roller>();

/// As `ballrace_roller_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_roller_mirrored_model: Model = Model::mirrored::<Roller>();
