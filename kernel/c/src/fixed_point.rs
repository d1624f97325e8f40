//! Radial and axial elements in fixed-point arithmetic, for cores without a floating-point unit.

use crate::geometry::{InvalidParameter, check, report};
use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::Phase;
use ballrace::bearing::fixed_point::{AxialElements, AxialParams, Direction, RadialElements, RadialParams, direction};

/// Largest number of elements.
pub(crate) const MAX_ELEMENTS: usize = 32;

/// A bearing of radial elements between rigid rings.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedRadialParams {
    /// K, N/m^n.
    pub stiffness: f64,
    /// n, 1 to 2: 3/2 of balls, 10/9 of rollers.
    pub exponent: f64,
    /// Radial play, m: half the diametral clearance; negative is preload.
    pub radial_play: f64,
    /// Displacement of 2^31 counts, m: the largest that the converter delivers.
    pub range: f64,
    /// Azimuth of the first element with the cage at angle 0, 2^-64 revolutions.
    pub first: u64,
    /// Number of evenly spaced elements, 3 to 32.
    pub element_count: u32,
}

/// A radial bearing on counts. Opaque: `ballrace_fixed_radial_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct FixedRadial {
    /// Private.
    pub words: [u64; 118],
}

/// Axial elements between rigid rings, loaded where the inner ring moves towards +Z.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedAxialParams {
    /// K, N/m^n.
    pub stiffness: f64,
    /// n, 1 to 2: 3/2 of balls, 10/9 of rollers.
    pub exponent: f64,
    /// Axial play, m; negative is preload.
    pub axial_play: f64,
    /// Radius at which the elements act, m.
    pub radius: f64,
    /// Displacement of 2^31 counts, m.
    pub range: f64,
    /// Azimuth of the first element with the cage at angle 0, 2^-64 revolutions.
    pub first: u64,
    /// Number of evenly spaced elements, 3 to 32.
    pub element_count: u32,
}

/// Axial elements on counts. Opaque: `ballrace_fixed_axial_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct FixedAxial {
    /// Private.
    pub words: [u64; 120],
}

/// Force and moment of axial elements on the inner ring, in counts; a count of a moment is that of the force times the radius.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FixedAxialForce {
    /// Force along Z.
    pub fz: i32,
    /// Moment about X.
    pub mx: i32,
    /// Moment about Y.
    pub my: i32,
}

/// Force on the inner ring, in counts.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FixedForce {
    /// Force along X.
    pub fx: i32,
    /// Force along Y.
    pub fy: i32,
    /// Sum of the element loads.
    pub load: i32,
}

/// Directions of a number of elements that is known at run time.
pub(crate) struct Directions {
    count: usize,
    all: [Direction; MAX_ELEMENTS],
}

impl AsRef<[Direction]> for Directions {
    #[inline(always)]
    fn as_ref(&self) -> &[Direction] {
        self.all.get(..self.count).unwrap_or_default()
    }
}

impl Directions {
    /// Returns evenly spaced ones, at most [`MAX_ELEMENTS`].
    fn evenly_spaced(first: u64, count: u32) -> Self {
        let count = count as usize;
        Self { count, all: core::array::from_fn(|j| direction(Phase(first), j, count)) }
    }

    /// Returns these ones, at most [`MAX_ELEMENTS`].
    pub(crate) fn from_each(each: impl Iterator<Item = Direction>) -> Self {
        let (mut count, mut all) = (0, [Direction::default(); MAX_ELEMENTS]);
        for (direction, found) in all.iter_mut().zip(each) {
            *direction = found;
            count += 1;
        }
        Self { count, all }
    }
}

impl Stored for RadialElements<Directions> {
    const KIND: u32 = 7;
}

impl Stored for AxialElements<Directions> {
    const KIND: u32 = 8;
}

/// Initialises a bearing. For set-up: uses `double`. `invalid` may be NULL. Writes what a count of the displacement is in m, and a count of the
/// force in N.
///
/// # Safety
/// `bearing` and `params` point to structs, `invalid` to a struct or nothing, `metres_per_count` and `newtons_per_count` to numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_radial_init(
    bearing: *mut FixedRadial,
    params: *const FixedRadialParams,
    metres_per_count: *mut f64,
    newtons_per_count: *mut f64,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(bearing, params, metres_per_count, newtons_per_count);
    // SAFETY: by the contract of the function.
    unsafe {
        let FixedRadialParams { stiffness, exponent, radial_play, range, first, element_count } = *params;
        let of = RadialParams { stiffness, exponent, radial_play, range };
        init(bearing, (first, element_count), invalid, |directions| {
            let value = RadialElements::with_directions(directions, &of)?;
            (*metres_per_count, *newtons_per_count) = (value.metres_per_count(), value.newtons_per_count());
            Ok(value)
        })
    }
}

/// Stores elements in evenly spaced directions, or reports the parameter that is out of its range.
///
/// # Safety
/// `bearing` points to a struct of the elements, `invalid` to a struct or nothing.
unsafe fn init<V: Stored, S>(
    bearing: *mut S,
    (first, element_count): (u64, u32),
    invalid: *mut InvalidParameter,
    create: impl FnOnce(Directions) -> Result<V, ballrace::bearing::geometry::InvalidParameter>,
) -> u32 {
    let found = f64::from(element_count);
    // SAFETY: by the contract of the function.
    unsafe {
        if check((3..=32).contains(&element_count), "element_count", found, "3 to 32", invalid) {
            return status::INVALID_ARGUMENT;
        }
        match create(Directions::evenly_spaced(first, element_count)) {
            Ok(value) => state::write(bearing, value),
            Err(error) => return report(error, invalid),
        }
    }
    status::OK
}

/// Computes the force on the inner ring at the displacement `u` along X and `v` along Y, in counts; any counts are valid. `BALLRACE_CONTACT_LOST`
/// where no element carries load. Without floating-point numbers: a constant number of instructions on every core.
///
/// # Safety
/// `bearing` points to an initialised bearing, `force` to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_radial_force(
    bearing: *const FixedRadial,
    u: i32,
    v: i32,
    cage_phase: u64,
    force: *mut FixedForce,
) -> u32 {
    check_pointers!(bearing, force);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(bearing) = state::read::<RadialElements<Directions>, _>(bearing) else {
            return status::STATE_INVALID;
        };
        let found = bearing.reaction(u, v, Phase(cage_phase));
        *force = FixedForce { fx: found.fx, fy: found.fy, load: found.load };
        u32::from(found.status.bits())
    }
}

/// Initialises axial elements, as `ballrace_fixed_radial_init`.
///
/// # Safety
/// As `ballrace_fixed_radial_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_axial_init(
    bearing: *mut FixedAxial,
    params: *const FixedAxialParams,
    metres_per_count: *mut f64,
    newtons_per_count: *mut f64,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(bearing, params, metres_per_count, newtons_per_count);
    // SAFETY: by the contract of the function.
    unsafe {
        let FixedAxialParams { stiffness, exponent, axial_play, radius, range, first, element_count } = *params;
        let of = AxialParams { stiffness, exponent, axial_play, radius, range };
        init(bearing, (first, element_count), invalid, |directions| {
            let value = AxialElements::with_directions(directions, &of)?;
            (*metres_per_count, *newtons_per_count) = (value.metres_per_count(), value.newtons_per_count());
            Ok(value)
        })
    }
}

/// Computes force and moment on the inner ring at the displacement `w` along Z and the tilts about X and Y times the radius, in counts; any counts
/// are valid. As `ballrace_fixed_radial_force`.
///
/// # Safety
/// `bearing` points to initialised elements, `force` to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_axial_force(
    bearing: *const FixedAxial,
    w: i32,
    tilt_x: i32,
    tilt_y: i32,
    cage_phase: u64,
    force: *mut FixedAxialForce,
) -> u32 {
    check_pointers!(bearing, force);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(bearing) = state::read::<AxialElements<Directions>, _>(bearing) else {
            return status::STATE_INVALID;
        };
        let found = bearing.reaction(w, tilt_x, tilt_y, Phase(cage_phase));
        *force = FixedAxialForce { fz: found.fz, mx: found.mx, my: found.my };
        u32::from(found.status.bits())
    }
}
