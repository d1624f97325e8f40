//! The common head of all bearings and the calls that take any model.

use crate::last_valid::LastValid;
use crate::pointer::{check_bearing, check_pointers};
use ballrace::bearing::ElementPosition;
use ballrace::{BearingKinematicState, Phase};

/// One rolling element: cosine and sine of its azimuth with the cage at angle 0, and that azimuth in 2^-64 revolutions.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Element {
    /// Cosine of the azimuth.
    pub cos: f32,
    /// Sine of the azimuth.
    pub sin: f32,
    /// Azimuth, 2^-64 revolutions.
    pub azimuth: u64,
}

// The kernel reads an array of elements in place.
const _: () = {
    type Position = ElementPosition<f32>;
    assert!(size_of::<Element>() == 16 && size_of::<Position>() == 16);
    assert!(align_of::<Element>() == align_of::<Position>());
    assert!(core::mem::offset_of!(Element, sin) == 4 && core::mem::offset_of!(Element, azimuth) == 8);
};

/// Angles and speeds of the components of a bearing. Unused angles and speeds are 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct KinematicState {
    /// Angle of the cage, 2^-64 revolutions.
    pub cage: u64,
    /// Angle of the inner ring, 2^-64 revolutions.
    pub inner: u64,
    /// Angle of the outer ring, 2^-64 revolutions.
    pub outer: u64,
    /// Angle of the balls about their own axes, 2^-64 revolutions.
    pub ball: u64,
    /// Speed of the inner ring about +Z, rad/s.
    pub inner_speed: f32,
    /// Speed of the outer ring about +Z, rad/s.
    pub outer_speed: f32,
}

// The kernel reads a state in place.
const _: () = {
    type State = BearingKinematicState<f32>;
    assert!(size_of::<KinematicState>() == size_of::<State>() && align_of::<KinematicState>() == align_of::<State>());
    assert!(core::mem::offset_of!(KinematicState, inner) == core::mem::offset_of!(State, inner));
    assert!(core::mem::offset_of!(KinematicState, outer) == core::mem::offset_of!(State, outer));
    assert!(core::mem::offset_of!(KinematicState, ball) == core::mem::offset_of!(State, ball));
    assert!(core::mem::offset_of!(KinematicState, inner_speed) == core::mem::offset_of!(State, inner_speed));
    assert!(core::mem::offset_of!(KinematicState, outer_speed) == core::mem::offset_of!(State, outer_speed));
};

impl KinematicState {
    /// Returns this state as the type of the kernel.
    #[inline(always)]
    pub fn of_kernel(&self) -> &BearingKinematicState<f32> {
        // SAFETY: both types have the same layout.
        unsafe { &*core::ptr::from_ref(self).cast() }
    }

    /// Returns a state of the kernel as the type of the C interface.
    #[inline(always)]
    pub fn from_kernel(state: &BearingKinematicState<f32>) -> &Self {
        // SAFETY: both types have the same layout.
        unsafe { &*core::ptr::from_ref(state).cast() }
    }
}

/// Functions of one bearing model. The library exports one constant per model; a program uses only their addresses.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Model {
    /// Implementation of `ballrace_force`.
    pub force: unsafe extern "C" fn(
        bearing: *const Bearing,
        displacement: *const f32,
        cage_phase: u64,
        wrench: *mut f32,
    ) -> u32,
    /// Implementation of `ballrace_force_at`.
    pub force_at: unsafe extern "C" fn(
        bearing: *const Bearing,
        displacement: *const f32,
        state: *const KinematicState,
        wrench: *mut f32,
    ) -> u32,
    /// Implementation of `ballrace_sample`.
    pub sample: unsafe extern "C" fn(
        bearing: *const Bearing,
        last_valid: *mut LastValid,
        displacement: *const f32,
        cage_phase: u64,
        wrench: *mut f32,
    ) -> u32,
    /// Implementation of `ballrace_sample_at`.
    pub sample_at: unsafe extern "C" fn(
        bearing: *const Bearing,
        last_valid: *mut LastValid,
        displacement: *const f32,
        state: *const KinematicState,
        wrench: *mut f32,
    ) -> u32,
    /// As `force_at`, with `BALLRACE_CONTACT_LOST` where no element carries load: for rotors.
    pub force_and_contact: unsafe extern "C" fn(
        bearing: *const Bearing,
        displacement: *const f32,
        state: *const KinematicState,
        wrench: *mut f32,
    ) -> u32,
    /// Implementation of `ballrace_force_and_stiffness`.
    pub force_and_stiffness: unsafe extern "C" fn(
        bearing: *const Bearing,
        displacement: *const f32,
        state: *const KinematicState,
        wrench: *mut f32,
        stiffness: *mut f32,
    ) -> u32,
    /// Implementation of `ballrace_element_loads`.
    pub element_loads: unsafe extern "C" fn(
        bearing: *const Bearing,
        displacement: *const f32,
        state: *const KinematicState,
        loads: *mut f32,
    ) -> u32,
    /// Constants of the struct in a blob.
    pub blob: BlobShape,
}

/// Constants of the struct of a model in a blob.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct BlobShape {
    /// Code of the model.
    pub code: u32,
    /// Number of members of 4 bytes after the head.
    pub words: u32,
    /// Offset in the struct of the pointer to its table or laminae, bytes; 0 where it has none.
    pub array: u32,
    /// Numbers of a node or lamina.
    pub numbers: u32,
}

/// First member of every bearing. `&bearing.head` is the argument of all calls.
///
/// A bearing and its elements are constant: they may be in flash and shared by threads and interrupts.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Bearing {
    /// Model of the struct that this is the first member of: `&ballrace_..._model`.
    pub model: *const Model,
    /// Elements, in the frame rotated by pi about X for a mirrored model; NULL for `ballrace_linear`.
    pub elements: *const Element,
    /// Number of elements, 3 to 32; 0 for `ballrace_linear`.
    pub element_count: u32,
}

/// Computes the force and moment on the inner ring.
///
/// `displacement` is that of the inner relative to the outer ring: `u v w` along X, Y, Z in m, tilts about X and Y in rad.
/// `wrench` receives `FX FY FZ` in N and `MX MY` in N m. `cage_phase` is the angle of the cage in 2^-64 revolutions; all
/// speeds are 0.
///
/// Returns status bits. The displacement must be finite; `ballrace_sample` also takes others, and reports lost contact.
/// Constant number of instructions for one bearing.
///
/// # Safety
/// `bearing` is the head of a struct of its model; the arrays have five entries.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force(
    bearing: *const Bearing,
    displacement: *const f32,
    cage_phase: u64,
    wrench: *mut f32,
) -> u32 {
    check_bearing!(bearing, displacement, wrench);
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe { ((*(*bearing).model).force)(bearing, displacement, cage_phase, wrench) }
}

/// Computes the force as `ballrace_force` for components at these angles and speeds: for tables over the speed.
///
/// # Safety
/// As `ballrace_force`; `state` points to a state.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force_at(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    check_bearing!(bearing, displacement, state, wrench);
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe { ((*(*bearing).model).force_at)(bearing, displacement, state, wrench) }
}

/// Computes the force for one sample of a stream.
///
/// As `ballrace_force`, but a sample that is NaN, infinite or overflows is flagged, counted and replaced by the last
/// valid force. Same number of instructions for every sample. For an interrupt: one state per stream.
///
/// # Safety
/// As `ballrace_force`; `last_valid` points to an initialised state that no other thread or interrupt uses.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_sample(
    bearing: *const Bearing,
    last_valid: *mut LastValid,
    displacement: *const f32,
    cage_phase: u64,
    wrench: *mut f32,
) -> u32 {
    check_bearing!(bearing, last_valid, displacement, wrench);
    // SAFETY: by the contract of the function.
    unsafe { ((*(*bearing).model).sample)(bearing, last_valid, displacement, cage_phase, wrench) }
}

/// As `ballrace_sample` for components at these angles and speeds.
///
/// # Safety
/// As `ballrace_sample`; `state` points to a state.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_sample_at(
    bearing: *const Bearing,
    last_valid: *mut LastValid,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    check_bearing!(bearing, last_valid, displacement, state, wrench);
    // SAFETY: by the contract of the function.
    unsafe { ((*(*bearing).model).sample_at)(bearing, last_valid, displacement, state, wrench) }
}

/// Computes the force and the tangent stiffness `-d(wrench)/d(displacement)`: row by row, `stiffness[5 * i + j]` is the
/// negative derivative of entry `i` of the wrench by entry `j` of the displacement.
///
/// # Safety
/// As `ballrace_force_at`; `stiffness` has 25 entries.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5], [stiffness; 25]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force_and_stiffness(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
    stiffness: *mut f32,
) -> u32 {
    check_bearing!(bearing, displacement, state, wrench, stiffness);
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe { ((*(*bearing).model).force_and_stiffness)(bearing, displacement, state, wrench, stiffness) }
}

/// Computes the load on each element in N: `element_count` entries of `loads`; of a radial and axial bearing, the radial
/// loads. A linear bearing writes nothing.
///
/// # Safety
/// As `ballrace_force_at`; `loads` has `element_count` entries.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_element_loads(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    loads: *mut f32,
) -> u32 {
    check_bearing!(bearing, displacement, state, loads);
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe { ((*(*bearing).model).element_loads)(bearing, displacement, state, loads) }
}

/// Computes `count` evenly spaced elements, the first at the azimuth `first` in 2^-64 revolutions. For set-up: uses
/// `double`.
///
/// # Safety
/// `elements` has `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_elements_evenly_spaced(elements: *mut Element, count: u32, first: u64) -> u32 {
    check_pointers!(elements);
    for j in 0..count as usize {
        let position = ElementPosition::<f32>::evenly_spaced(Phase(first), j, count as usize);
        // SAFETY: entry `j` of `count` entries.
        unsafe { *elements.add(j) = Element::from(position) };
    }
    crate::status::OK
}

/// Changes elements to those in the frame rotated by pi about X, for a mirrored model.
///
/// # Safety
/// `elements` has `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_elements_mirror(elements: *mut Element, count: u32) -> u32 {
    check_pointers!(elements);
    for j in 0..count as usize {
        // SAFETY: entry `j` of `count` entries.
        let element = unsafe { &mut *elements.add(j) };
        element.sin = -element.sin;
        element.azimuth = element.azimuth.wrapping_neg();
    }
    crate::status::OK
}

impl From<ElementPosition<f32>> for Element {
    fn from(position: ElementPosition<f32>) -> Self {
        let (cos, sin) = position.direction();
        Self { cos, sin, azimuth: position.azimuth().0 }
    }
}
