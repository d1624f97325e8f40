//! States that the caller stores, with a word that identifies their type and version.

use crate::ABI_VERSION;

/// A struct of C that stores a value of the library.
///
/// # Safety
/// The struct is large enough and aligned for a [`Versioned`] value, which [`assert_fits`] checks.
pub unsafe trait Opaque {
    /// Value that the struct stores.
    type Value;

    /// Number that differs from that of every other state.
    const KIND: u32;

    /// First word of an initialised state.
    const MAGIC: u32 = 0xba11_0000 | Self::KIND << 8 | ABI_VERSION;
}

/// A value after its first word.
#[repr(C)]
pub struct Versioned<T> {
    magic: u32,
    value: T,
}

/// Fails to compile where the value of a state does not fit.
pub const fn assert_fits<S: Opaque>() {
    assert!(size_of::<Versioned<S::Value>>() <= size_of::<S>());
    assert!(align_of::<Versioned<S::Value>>() <= align_of::<S>());
}

/// Initialises a state.
///
/// # Safety
/// `state` points to a struct.
#[inline(always)]
pub unsafe fn write<S: Opaque>(state: *mut S, value: S::Value) {
    const { assert_fits::<S>() };
    // SAFETY: the value fits the struct.
    unsafe { state.cast::<Versioned<S::Value>>().write(Versioned { magic: S::MAGIC, value }) };
}

/// Returns the value of a state, or `None` for one that is not initialised by this version.
///
/// # Safety
/// `state` points to a struct that nothing else accesses during `'a`.
#[inline(always)]
pub unsafe fn get<'a, S: Opaque>(state: *mut S) -> Option<&'a mut S::Value> {
    let state = state.cast::<Versioned<S::Value>>();
    // SAFETY: any word is a valid number; a state with the right first word was written by `write`.
    unsafe { if (*state).magic == S::MAGIC { Some(&mut (*state).value) } else { None } }
}

/// As [`get`], for reading.
///
/// # Safety
/// `state` points to a struct that nothing writes during `'a`.
#[inline(always)]
pub unsafe fn read<'a, S: Opaque>(state: *const S) -> Option<&'a S::Value> {
    let state = state.cast::<Versioned<S::Value>>();
    // SAFETY: as in `get`.
    unsafe { if (*state).magic == S::MAGIC { Some(&(*state).value) } else { None } }
}
