//! Model `angular`: a ball bearing with variable contact angle.

use crate::bearing::{Bearing, Element, Model};
use crate::geometry::{Geometry, InvalidParameter, check, report};
use crate::model::Constants;
use crate::pointer::check_pointers;
use crate::status;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::angular::{AngularConstants, DisplacementDatum};
use ballrace::bearing::{CageFrame, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact};

/// Zero displacement: the rings just touch the balls at the contact angle. For angular-contact bearings.
pub const DATUM_TOUCHING: u32 = 0;
/// Zero displacement: the rings are concentric and centred axially. For deep-groove bearings.
pub const DATUM_CENTRED: u32 = 1;

/// A ball bearing whose contact angles follow the displacement.
///
/// Models: `ballrace_angular_model`, and `ballrace_angular_mirrored_model` for a bearing that carries thrust towards -Z.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Angular {
    /// Head.
    pub head: Bearing,
    /// K_n, stiffness of both contacts in series, N/m^1.5.
    pub stiffness: f32,
    /// A, distance of the groove centres with the rings just touching the balls, m.
    pub distance: f32,
    /// A^2, m^2.
    pub distance_squared: f32,
    /// A_r, radial distance of the groove centres at zero displacement, m.
    pub unloaded_radial: f32,
    /// A_z, axial distance of the groove centres at zero displacement, m.
    pub unloaded_axial: f32,
    /// A_r^2 + A_z^2 - A^2, m^2.
    pub excess: f32,
    /// R_i, lever arm, m.
    pub arm: f32,
}

// SAFETY: `repr(C)` with the head first.
unsafe impl Constants for Angular {
    type Bearing<'a> = ballrace::bearing::angular::Angular<f32, Exact, &'a [ElementPosition<f32>]>;

    const WORDS: u32 = 7;

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let constants = AngularConstants {
            stiffness: self.stiffness,
            distance: [self.distance, self.distance_squared],
            unloaded: [self.unloaded_radial, self.unloaded_axial],
            excess: self.excess,
            arm: self.arm,
        };
        // SAFETY: the pointers are valid by the contract of the function.
        ballrace::bearing::angular::Angular::from_constants(unsafe { self.head.positions() }, constants)
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction_inlined(u, at)
    }
}

/// Model of `ballrace_angular`, which carries thrust where the inner ring moves towards +Z.
#[unsafe(no_mangle)]
pub static ballrace_angular_model: Model = Model::of::<Angular>();

/// As `ballrace_angular_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_angular_mirrored_model: Model = Model::mirrored::<Angular>();

/// Initialises a bearing from its geometry, with `&ballrace_angular_model`. For set-up: uses `double`; about 1000
/// operations. `datum` is `BALLRACE_DATUM_TOUCHING` or `BALLRACE_DATUM_CENTRED`.
///
/// For a bearing that carries thrust towards -Z, mirror the elements with `ballrace_elements_mirror` and set `head.model`
/// to `&ballrace_angular_mirrored_model` afterwards.
///
/// Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range; the
/// bearing is then unchanged.
///
/// # Safety
/// `bearing` and `geometry` point to structs, `elements` to `element_count` entries that exist as long as the bearing,
/// `invalid` to a struct or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_angular_init(
    bearing: *mut Angular,
    geometry: *const Geometry,
    datum: u32,
    elements: *const Element,
    element_count: u32,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(bearing, geometry, elements);
    // SAFETY: valid or null by the contract of the function.
    let fails = |ok, name, found, expected| unsafe { check(ok, name, found, expected, invalid) };
    if fails(datum <= DATUM_CENTRED, "datum", f64::from(datum), "0 (touching) or 1 (centred)")
        || fails((3..=32).contains(&element_count), "element_count", f64::from(element_count), "3 to 32")
    {
        return status::INVALID_ARGUMENT;
    }
    let datum = if datum == DATUM_CENTRED { DisplacementDatum::Centred } else { DisplacementDatum::Touching };
    // SAFETY: by the contract of the function.
    let geometry = unsafe { &*geometry };
    let constants = match AngularConstants::try_new(geometry.into(), datum) {
        Ok(constants) => constants.rounded::<f32>(),
        // SAFETY: valid or null by the contract of the function.
        Err(error) => return unsafe { report(error, invalid) },
    };
    let AngularConstants {
        stiffness,
        distance: [distance, distance_squared],
        unloaded: [unloaded_radial, unloaded_axial],
        excess,
        arm,
    } = constants;
    let head = Bearing { model: &raw const ballrace_angular_model, elements, element_count };
    let made = Angular { head, stiffness, distance, distance_squared, unloaded_radial, unloaded_axial, excess, arm };
    // SAFETY: by the contract of the function.
    unsafe { bearing.write(made) };
    status::OK
}
