//! Copies of the state of an instance.

use crate::instance::{Instance, Mode, call};
use ballrace_studies::fmu::Unit;
use std::ffi::{c_int, c_void};

/// State of an instance at a communication point.
struct Saved {
    unit: Unit,
    mode: Mode,
}

/// Copies the state of an instance to `FMUState`, a new one where that is null.
///
/// # Safety
/// As in the [crate](crate#safety); `FMUState` is null or a place with null or a state that this function has returned.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, FMUState: *mut *mut c_void) -> c_int {
    let get = |instance: &mut Instance| {
        // SAFETY: the place of the host is null or writable.
        let Some(place) = (unsafe { FMUState.as_mut() }) else {
            return Err("FMUState: null, expected a place".to_owned());
        };
        let saved = Saved { unit: instance.unit.copy(), mode: instance.mode };
        // SAFETY: a state that the host gives is one of this library.
        match unsafe { place.cast::<Saved>().as_mut() } {
            Some(state) => *state = saved,
            None => *place = Box::into_raw(Box::new(saved)).cast(),
        }
        Ok(())
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3GetFMUState", &Mode::ALL, get) }
}

/// Returns an instance to a copied state.
///
/// # Safety
/// As in the [crate](crate#safety); `FMUState` is null or a state of [`fmi3GetFMUState`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, FMUState: *mut c_void) -> c_int {
    let set = |instance: &mut Instance| {
        // SAFETY: a state that the host gives is one of this library.
        let Some(state) = (unsafe { FMUState.cast::<Saved>().as_ref() }) else {
            return Err("FMUState: null, expected a state of fmi3GetFMUState".to_owned());
        };
        (instance.unit, instance.mode) = (state.unit.copy(), state.mode);
        Ok(())
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3SetFMUState", &Mode::ALL, set) }
}

/// Frees a copied state and writes null to its place; null is none.
///
/// # Safety
/// As in the [crate](crate#safety); `FMUState` is null or a place with null or a state of [`fmi3GetFMUState`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: *mut c_void, FMUState: *mut *mut c_void) -> c_int {
    let free = |_: &mut Instance| {
        // SAFETY: the place of the host is null or writable.
        if let Some(place) = unsafe { FMUState.as_mut() }
            && !place.is_null()
        {
            // SAFETY: a state that the host gives is one of this library, and it gives it back.
            drop(unsafe { Box::from_raw(place.cast::<Saved>()) });
            *place = std::ptr::null_mut();
        }
        Ok(())
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3FreeFMUState", &Mode::ALL, free) }
}
