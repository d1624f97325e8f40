//! Model `lumped`: separate radial and axial contacts with one stiffness each.

use crate::bearing::{Bearing, Element, Model};
use crate::geometry::{InvalidParameter, check};
use crate::model::Constants;
use crate::pointer::check_pointers;
use crate::status;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{CageFrame, Reaction};
use ballrace::blob::BlobLaw;
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{BearingKinematicState, Displacement, Exact};

/// A radial ball or roller bearing: `F = K delta^n` of each element.
///
/// Models: `ballrace_lumped_radial_model` (n = 3/2, balls), `ballrace_lumped_radial_line_model` (n = 10/9, rollers),
/// `ballrace_lumped_radial_power_model` (n = `exponent`).
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct LumpedRadial {
    /// Head.
    pub head: Bearing,
    /// K, N/m^n.
    pub stiffness: f32,
    /// n, 1 or more; only the model `power` reads it.
    pub exponent: f32,
    /// Radial play, half the diametral clearance, m; negative is preload.
    pub play: f32,
}

/// Separate radial and axial contacts.
///
/// Models: `ballrace_lumped_radial_axial_model` (n = 3/2 in both directions), `ballrace_lumped_radial_axial_line_model`
/// (n = 10/9 in both), `ballrace_lumped_radial_axial_power_model` (n = `exponent` and `axial_exponent`), each also
/// `mirrored`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct LumpedRadialAxial {
    /// Head.
    pub head: Bearing,
    /// Radial K, N/m^n.
    pub stiffness: f32,
    /// Radial n, 1 or more; only the model `power` reads it.
    pub exponent: f32,
    /// Radial play, half the diametral clearance, m; negative is preload.
    pub play: f32,
    /// Axial K, N/m^n.
    pub axial_stiffness: f32,
    /// Axial n, 1 or more; only the model `power` reads it.
    pub axial_exponent: f32,
    /// Axial play, m; negative is preload.
    pub axial_play: f32,
    /// Radius at which the axial contacts act, m.
    pub radius: f32,
}

/// Constants of a bearing with the load-deflection law of its model.
#[repr(transparent)]
struct WithLaw<S, L>(S, core::marker::PhantomData<L>);

type Slice<'a> = &'a [ElementPosition<f32>];
type RadialOf<'a, L> = Radial<f32, Exact, L, Slice<'a>>;
type AxialOf<'a, L> = Axial<f32, Exact, L, Slice<'a>>;

// SAFETY: `repr(transparent)` over a `repr(C)` struct with the head first.
unsafe impl<L: BlobLaw + 'static> Constants for WithLaw<LumpedRadial, L> {
    type Bearing<'a> = RadialOf<'a, L>;

    const WORDS: u32 = 3;

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let LumpedRadial { head, stiffness, exponent, play } = &self.0;
        // SAFETY: the pointers are valid by the contract of the function.
        Radial::from_constants(unsafe { head.positions() }, L::new(*stiffness, *exponent), *play)
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction_inlined(u, at)
    }
}

// SAFETY: `repr(transparent)` over a `repr(C)` struct with the head first.
unsafe impl<L: BlobLaw + 'static> Constants for WithLaw<LumpedRadialAxial, L> {
    type Bearing<'a> = Combined<RadialOf<'a, L>, AxialOf<'a, L>>;

    const WORDS: u32 = 7;

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let of = &self.0;
        // SAFETY: the pointers are valid by the contract of the function.
        let positions = unsafe { of.head.positions() };
        Combined(
            Radial::from_constants(positions, L::new(of.stiffness, of.exponent), of.play),
            Axial::from_constants(positions, L::new(of.axial_stiffness, of.axial_exponent), of.axial_play, of.radius),
        )
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction_inlined(u, at)
    }
}

/// Model of `ballrace_lumped_radial` with point contacts, n = 3/2.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_model: Model = Model::of::<WithLaw<LumpedRadial, PointContactLaw<f32>>>();

/// Model of `ballrace_lumped_radial` with line contacts, n = 10/9.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_line_model: Model = Model::of::<WithLaw<LumpedRadial, LineContactLaw<f32>>>();

/// Model of `ballrace_lumped_radial` with any exponent.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_power_model: Model = Model::of::<WithLaw<LumpedRadial, PowerLaw<f32>>>();

/// Model of `ballrace_lumped_radial_axial` with point contacts, n = 3/2, loaded where the inner ring moves towards +Z.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_model: Model = Model::of::<WithLaw<LumpedRadialAxial, PointContactLaw<f32>>>();

/// As `ballrace_lumped_radial_axial_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_mirrored_model: Model =
    Model::mirrored::<WithLaw<LumpedRadialAxial, PointContactLaw<f32>>>();

/// Model of `ballrace_lumped_radial_axial` with line contacts, n = 10/9.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_line_model: Model =
    Model::of::<WithLaw<LumpedRadialAxial, LineContactLaw<f32>>>();

/// As `ballrace_lumped_radial_axial_line_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_line_mirrored_model: Model =
    Model::mirrored::<WithLaw<LumpedRadialAxial, LineContactLaw<f32>>>();

/// Model of `ballrace_lumped_radial_axial` with any exponents.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_power_model: Model = Model::of::<WithLaw<LumpedRadialAxial, PowerLaw<f32>>>();

/// As `ballrace_lumped_radial_axial_power_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_lumped_radial_axial_power_mirrored_model: Model =
    Model::mirrored::<WithLaw<LumpedRadialAxial, PowerLaw<f32>>>();

/// Initialises a radial ball bearing (n = 3/2) with `&ballrace_lumped_radial_model` and checks its parameters. For set-up;
/// a `const` struct needs no call.
///
/// Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a stiffness that is not above 0, a play
/// that is not finite, or fewer than 3 or more than 32 elements.
///
/// # Safety
/// `bearing` points to a struct, `elements` to `element_count` entries that exist as long as the bearing, `invalid` to a
/// struct or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_lumped_radial_init(
    bearing: *mut LumpedRadial,
    stiffness: f64,
    play: f64,
    elements: *const Element,
    element_count: u32,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(bearing, elements);
    // SAFETY: valid or null by the contract of the function.
    let fails = |ok, name, found, expected| unsafe { check(ok, name, found, expected, invalid) };
    if fails(stiffness > 0.0, "stiffness", stiffness, "above 0")
        || fails(true, "play", play, "a finite length")
        || fails((3..=32).contains(&element_count), "element_count", f64::from(element_count), "3 to 32")
    {
        return status::INVALID_ARGUMENT;
    }
    let head = Bearing { model: &raw const ballrace_lumped_radial_model, elements, element_count };
    // SAFETY: by the contract of the function.
    unsafe { bearing.write(LumpedRadial { head, stiffness: stiffness as f32, exponent: 1.5, play: play as f32 }) };
    status::OK
}
