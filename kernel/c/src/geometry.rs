//! Geometry and material of a ball bearing, and the report of an invalid parameter.

use crate::pointer::check_pointers;
use crate::status;
use ballrace::bearing::geometry::BallBearingGeometry;
use core::ffi::c_char;

/// Elastic constants of one body.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Material {
    /// Young's modulus, Pa; 206e9 for bearing steel.
    pub youngs_modulus: f64,
    /// Poisson's ratio; 0.3 for bearing steel.
    pub poissons_ratio: f64,
}

/// Geometry and material of a ball bearing.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Geometry {
    /// D, ball diameter, m.
    pub ball_diameter: f64,
    /// d_m, pitch diameter, m.
    pub pitch_diameter: f64,
    /// f_i, inner groove radius divided by D, above 0.5.
    pub inner_conformity: f64,
    /// f_o, outer groove radius divided by D, above 0.5.
    pub outer_conformity: f64,
    /// alpha_0, free contact angle, 0 to pi/3 rad.
    pub contact_angle: f64,
    /// Material of the balls.
    pub ball: Material,
    /// Material of both races.
    pub race: Material,
}

/// Report of a parameter outside its range. The texts are not terminated by NUL: print them with `%.*s`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct InvalidParameter {
    /// Name of the parameter.
    pub name: *const c_char,
    /// Allowed range.
    pub allowed: *const c_char,
    /// Length of the name.
    pub name_length: u32,
    /// Length of the allowed range.
    pub allowed_length: u32,
    /// Value found.
    pub found: f64,
}

impl From<ballrace::bearing::geometry::InvalidParameter> for InvalidParameter {
    fn from(error: ballrace::bearing::geometry::InvalidParameter) -> Self {
        Self {
            name: error.name.as_ptr().cast(),
            allowed: error.allowed.as_ptr().cast(),
            name_length: error.name.len() as u32,
            allowed_length: error.allowed.len() as u32,
            found: error.found,
        }
    }
}

/// Reports an error of the kernel; returns the status of the call.
///
/// # Safety
/// `invalid` points to a struct or is null.
pub(crate) unsafe fn report(
    error: ballrace::bearing::geometry::InvalidParameter,
    invalid: *mut InvalidParameter,
) -> u32 {
    if !invalid.is_null() {
        // SAFETY: points to a struct by the contract of the function.
        unsafe { invalid.write(error.into()) };
    }
    status::INVALID_ARGUMENT
}

/// Returns true and reports the parameter unless `condition` holds and `found` is finite.
///
/// # Safety
/// As [`report`].
pub(crate) unsafe fn check(
    condition: bool,
    name: &'static str,
    found: f64,
    allowed: &'static str,
    invalid: *mut InvalidParameter,
) -> bool {
    let fails = !(condition && found.is_finite());
    if fails {
        // SAFETY: by the contract of the function.
        unsafe { report(ballrace::bearing::geometry::InvalidParameter { name, found, allowed }, invalid) };
    }
    fails
}

impl From<Material> for ballrace::contact::hertz::Material {
    fn from(of: Material) -> Self {
        Self { youngs_modulus: of.youngs_modulus, poissons_ratio: of.poissons_ratio }
    }
}

impl From<&Geometry> for BallBearingGeometry {
    fn from(of: &Geometry) -> Self {
        Self {
            ball_diameter: of.ball_diameter,
            pitch_diameter: of.pitch_diameter,
            inner_conformity: of.inner_conformity,
            outer_conformity: of.outer_conformity,
            contact_angle: of.contact_angle,
            ball: of.ball.into(),
            race: of.race.into(),
        }
    }
}

/// Sets the free contact angle to that of a diametral clearance `s` in m: `cos(alpha_0) = 1 - s/(2 A)`. For set-up.
///
/// Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a clearance below 0 or above A.
///
/// # Safety
/// `geometry` points to a struct, `invalid` to one or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_geometry_set_clearance(
    geometry: *mut Geometry,
    diametral_clearance: f64,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(geometry);
    // SAFETY: by the contract of the function.
    unsafe {
        match BallBearingGeometry::from(&*geometry).with_clearance(diametral_clearance) {
            Ok(with) => {
                (*geometry).contact_angle = with.contact_angle;
                status::OK
            }
            Err(error) => report(error, invalid),
        }
    }
}
