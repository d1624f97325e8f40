//! Functions of a model, generic over its constants.

use crate::bearing::{Bearing, BlobShape, KinematicState, Model};
use crate::last_valid::LastValid;
use crate::{pointer, state, status};
use ballrace::bearing::{Bearing as _, ElementPosition, LastValidWrench, Reaction};
use ballrace::blob::{FromBlob, MIRRORED};
use ballrace::frame::mirrored_stiffness;
use ballrace::{BearingKinematicState, Displacement, Phase, Stiffness, Wrench};

/// Array to which the last member of a struct points; the member before is the number of its entries.
pub struct BlobArray {
    /// Offset of the pointer in the struct, bytes.
    pub offset: usize,
    /// Numbers of an entry.
    pub numbers: u32,
}

/// A struct of C with the constants of a model.
///
/// # Safety
/// The type is `repr(C)`, and its first member is a [`Bearing`].
pub unsafe trait Constants: 'static {
    /// Bearing of the kernel with these constants.
    type Bearing<'a>: ballrace::Bearing<f32> + FromBlob<'a>;

    /// Number of members of 4 bytes after the head.
    const WORDS: u32;

    /// The pointer after these members, in a struct that has one.
    const ARRAY: Option<BlobArray> = None;

    /// True if the force depends on angles or speeds beside the cage angle.
    const USES_SPEED: bool = false;

    /// Returns the bearing of the kernel.
    ///
    /// # Safety
    /// The pointers in the struct are valid.
    unsafe fn bearing(&self) -> Self::Bearing<'_>;

    /// Computes the reaction, inlined into the functions of a model that call it.
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32>;
}

impl Bearing {
    /// Returns the positions of the elements.
    ///
    /// # Safety
    /// The pointers in the struct are valid.
    #[inline(always)]
    pub unsafe fn positions(&self) -> &[ElementPosition<f32>] {
        // SAFETY: an `Element` has the layout of an `ElementPosition<f32>`.
        unsafe { pointer::slice(self.elements.cast(), self.element_count) }
    }
}

impl BlobShape {
    const fn of<C: Constants>(mirrored: u32) -> Self {
        let code = <C::Bearing<'static> as FromBlob<'static>>::CODE | mirrored;
        let (array, numbers) = match C::ARRAY {
            Some(BlobArray { offset, numbers }) => (offset as u32, numbers),
            None => (0, 0),
        };
        Self { code, words: C::WORDS, array, numbers }
    }
}

impl Model {
    /// Returns the functions of a model.
    pub const fn of<C: Constants>() -> Self {
        Self {
            force: force::<C>,
            force_at: force_at::<C>,
            sample: sample::<C, false>,
            sample_at: sample_at::<C, false>,
            force_and_contact: force_and_contact::<C>,
            force_and_stiffness: force_and_stiffness::<C>,
            element_loads: element_loads::<C>,
            blob: BlobShape::of::<C>(0),
        }
    }

    /// Returns the functions of a model for bearings that carry thrust towards -Z: the model in the frame rotated by pi
    /// about X.
    pub const fn mirrored<C: Constants>() -> Self {
        Self {
            force: mirrored_force::<C>,
            force_at: mirrored_force_at::<C>,
            sample: sample::<C, true>,
            sample_at: sample_at::<C, true>,
            force_and_contact: mirrored_force_and_contact::<C>,
            force_and_stiffness: mirrored_force_and_stiffness::<C>,
            element_loads: mirrored_element_loads::<C>,
            blob: BlobShape::of::<C>(MIRRORED),
        }
    }
}

/// Returns the bearing of the kernel.
///
/// # Safety
/// `bearing` is the head of a `C` with valid pointers.
#[inline(always)]
unsafe fn bearing_of<'a, C: Constants>(bearing: *const Bearing) -> C::Bearing<'a> {
    // SAFETY: a pointer to the first member of a `repr(C)` struct points to the struct.
    unsafe { (*bearing.cast::<C>()).bearing() }
}

/// Computes and returns the reaction, and writes its wrench.
///
/// # Safety
/// As `ballrace_force`, with the head of a `C`.
#[inline(always)]
unsafe fn evaluate<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    at: &BearingKinematicState<f32>,
    wrench: *mut f32,
) -> Reaction<f32> {
    // SAFETY: the pointers are valid by the contract of the function.
    unsafe {
        let reaction = C::reaction(&bearing_of::<C>(bearing), &pointer::displacement(displacement), at);
        pointer::write_wrench(wrench, &reaction.wrench);
        reaction
    }
}

// Never inlined: the mirrored model shares the code.
#[inline(never)]
unsafe extern "C" fn force<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    cage_phase: u64,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force`.
    unsafe {
        if C::USES_SPEED {
            let state = KinematicState { cage: cage_phase, ..KinematicState::default() };
            return force_at::<C>(bearing, displacement, &raw const state, wrench);
        }
        // The sum of the loads is not read: only the lost-contact flag needs it.
        u32::from(evaluate::<C>(bearing, displacement, &Phase(cage_phase).into(), wrench).status.bits())
    }
}

#[inline(never)]
unsafe extern "C" fn force_at<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_at`.
    unsafe {
        if C::USES_SPEED {
            return force_and_contact::<C>(bearing, displacement, state, wrench) & !status::CONTACT_LOST;
        }
        force::<C>(bearing, displacement, (*state).cage, wrench)
    }
}

/// Writes the new or the last valid force; returns the status bits.
///
/// # Safety
/// As `ballrace_sample`, with the head of a `C`.
#[inline(always)]
unsafe fn hold(
    last_valid: *mut LastValid,
    displacement: *const f32,
    wrench: *mut f32,
    reaction: impl FnOnce(&Displacement<f32>) -> Reaction<f32>,
) -> u32 {
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(last_valid) = state::get::<LastValidWrench<f32>, _>(last_valid) else { return status::STATE_INVALID };
        let u = pointer::displacement(displacement);
        let (held, status) = last_valid.update(u.is_finite(), || reaction(&u));
        pointer::write_wrench(wrench, &held);
        u32::from(status.bits())
    }
}

#[inline(never)]
unsafe extern "C" fn sample<C: Constants, const MIRRORED: bool>(
    bearing: *const Bearing,
    last_valid: *mut LastValid,
    displacement: *const f32,
    cage_phase: u64,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_sample`.
    unsafe {
        if C::USES_SPEED {
            let state = KinematicState { cage: cage_phase, ..KinematicState::default() };
            return sample_at::<C, MIRRORED>(bearing, last_valid, displacement, &raw const state, wrench);
        }
        let at = Phase(if MIRRORED { cage_phase.wrapping_neg() } else { cage_phase }).into();
        hold(last_valid, displacement, wrench, |u| reaction::<C, MIRRORED>(bearing, u, &at))
    }
}

#[inline(never)]
unsafe extern "C" fn sample_at<C: Constants, const MIRRORED: bool>(
    bearing: *const Bearing,
    last_valid: *mut LastValid,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_sample_at`.
    unsafe {
        if !C::USES_SPEED {
            return sample::<C, MIRRORED>(bearing, last_valid, displacement, (*state).cage, wrench);
        }
        if MIRRORED {
            let at = reversed(state);
            return hold(last_valid, displacement, wrench, |u| reaction::<C, true>(bearing, u, at.of_kernel()));
        }
        let at = (*state).of_kernel();
        hold(last_valid, displacement, wrench, |u| reaction::<C, false>(bearing, u, at))
    }
}

/// Computes the reaction; `at` of a mirrored bearing is in the frame rotated by pi about X.
///
/// # Safety
/// `bearing` is the head of a `C` with valid pointers.
#[inline(always)]
unsafe fn reaction<C: Constants, const MIRRORED: bool>(
    bearing: *const Bearing,
    u: &Displacement<f32>,
    at: &BearingKinematicState<f32>,
) -> Reaction<f32> {
    // SAFETY: by the contract of the function.
    let bearing = unsafe { bearing_of::<C>(bearing) };
    if MIRRORED {
        let local = C::reaction(&bearing, &u.mirrored(), at);
        return Reaction { wrench: local.wrench.mirrored(), ..local };
    }
    C::reaction(&bearing, u, at)
}

#[inline(never)]
unsafe extern "C" fn force_and_contact<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_at`.
    unsafe {
        if C::USES_SPEED {
            return status::of_reaction(&evaluate::<C>(bearing, displacement, (*state).of_kernel(), wrench));
        }
        // Only the cage angle has an effect.
        status::of_reaction(&evaluate::<C>(bearing, displacement, &Phase((*state).cage).into(), wrench))
    }
}

#[inline(never)]
unsafe extern "C" fn force_and_stiffness<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
    stiffness: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_and_stiffness`.
    unsafe {
        let at = (*state).of_kernel();
        let (reaction, k) = bearing_of::<C>(bearing).reaction_and_stiffness(&pointer::displacement(displacement), at);
        pointer::write_wrench(wrench, &reaction.wrench);
        write_stiffness(stiffness, &k);
        u32::from(reaction.status.bits())
    }
}

#[inline(never)]
unsafe extern "C" fn element_loads<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    loads: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_element_loads`.
    unsafe {
        let count = (*bearing).element_count as usize;
        let loads: &mut [f32] = if count == 0 { &mut [] } else { core::slice::from_raw_parts_mut(loads, count) };
        bearing_of::<C>(bearing).element_loads(&pointer::displacement(displacement), (*state).of_kernel(), loads);
    }
    status::OK
}

/// Writes a stiffness row by row.
///
/// # Safety
/// `entries` points to 25 floats.
#[inline(always)]
unsafe fn write_stiffness(entries: *mut f32, k: &Stiffness<f32>) {
    for (j, column) in k.data.0.iter().enumerate() {
        for (i, &entry) in column.iter().enumerate() {
            // SAFETY: one of 25 floats by the contract of the function.
            unsafe { *entries.add(5 * i + j) = entry };
        }
    }
}

/// Returns the stiffness matrix whose entries `rows` contains row by row.
#[inline(always)]
pub fn stiffness_of(rows: &[f32; 25]) -> Stiffness<f32> {
    Stiffness::from_row_slice(rows)
}

/// Rotates a wrench in place by pi about X.
///
/// # Safety
/// `entries` points to five floats.
#[inline(always)]
unsafe fn mirror(entries: *mut f32) {
    // SAFETY: five floats by the contract of the function.
    unsafe {
        let local = Wrench::from_array(*entries.cast::<[f32; 5]>());
        pointer::write_wrench(entries, &local.mirrored());
    }
}

/// Returns the state in the frame rotated by pi about X.
///
/// # Safety
/// `state` points to a state.
#[inline(always)]
unsafe fn reversed(state: *const KinematicState) -> KinematicState {
    // SAFETY: by the contract of the function.
    *KinematicState::from_kernel(&unsafe { (*state).of_kernel() }.reversed())
}

unsafe extern "C" fn mirrored_force<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    cage_phase: u64,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force`.
    unsafe {
        let u = pointer::displacement(displacement).mirrored().to_array();
        let status = force::<C>(bearing, u.as_ptr(), cage_phase.wrapping_neg(), wrench);
        mirror(wrench);
        status
    }
}

unsafe extern "C" fn mirrored_force_at<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_at`.
    unsafe {
        let (u, at) = (pointer::displacement(displacement).mirrored().to_array(), reversed(state));
        let status = force_at::<C>(bearing, u.as_ptr(), &raw const at, wrench);
        mirror(wrench);
        status
    }
}

unsafe extern "C" fn mirrored_force_and_contact<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_at`.
    unsafe {
        let (u, at) = (pointer::displacement(displacement).mirrored().to_array(), reversed(state));
        let status = force_and_contact::<C>(bearing, u.as_ptr(), &raw const at, wrench);
        mirror(wrench);
        status
    }
}

unsafe extern "C" fn mirrored_force_and_stiffness<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    wrench: *mut f32,
    stiffness: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_and_stiffness`.
    unsafe {
        let (u, at) = (pointer::displacement(displacement).mirrored().to_array(), reversed(state));
        let status = force_and_stiffness::<C>(bearing, u.as_ptr(), &raw const at, wrench, stiffness);
        mirror(wrench);
        let local = stiffness_of(&*stiffness.cast::<[f32; 25]>());
        write_stiffness(stiffness, &mirrored_stiffness(&local));
        status
    }
}

unsafe extern "C" fn mirrored_element_loads<C: Constants>(
    bearing: *const Bearing,
    displacement: *const f32,
    state: *const KinematicState,
    loads: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_element_loads`.
    unsafe {
        let (u, at) = (pointer::displacement(displacement).mirrored().to_array(), reversed(state));
        element_loads::<C>(bearing, u.as_ptr(), &raw const at, loads)
    }
}
