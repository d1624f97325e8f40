//! States that the caller stores, with a word that identifies their type and version.

use crate::ABI_VERSION;

/// A value that is stored in a struct of C.
pub trait Stored {
    /// Number that differs from that of every other stored type.
    const KIND: u32;

    /// First word of an initialised struct.
    const MAGIC: u32 = 0xba00_0000 | Self::KIND << 8 | ABI_VERSION;
}

/// A value, preceded by the word that identifies its type and version.
#[repr(C)]
struct Versioned<V> {
    magic: u32,
    value: V,
}

/// Returns true if a value with its first word fits a struct.
pub const fn fits<V, S>() -> bool {
    size_of::<Versioned<V>>() <= size_of::<S>() && align_of::<Versioned<V>>() <= align_of::<S>()
}

/// Stores a value.
///
/// # Safety
/// `state` points to a struct.
#[inline(always)]
pub unsafe fn write<V: Stored, S>(state: *mut S, value: V) {
    const { assert!(fits::<V, S>()) };
    // SAFETY: the value fits the struct.
    unsafe { write_to(state.cast(), value) };
}

/// Stores a value in memory of the caller.
///
/// # Safety
/// `state` points to memory that is aligned to 8 bytes and large enough for the value with its first word.
#[inline(always)]
pub unsafe fn write_to<V: Stored>(state: *mut u64, value: V) {
    // SAFETY: by the contract of the function; no value has an alignment above that of `u64`.
    unsafe { state.cast::<Versioned<V>>().write(Versioned { magic: V::MAGIC, value }) };
}

/// Returns the value of a struct, or `None` for one that is not initialised by this version.
///
/// # Safety
/// `state` points to a struct of at least the size of a [`fits`] value, which nothing else accesses during `'a`.
#[inline(always)]
pub unsafe fn get<'a, V: Stored, S>(state: *mut S) -> Option<&'a mut V> {
    let state = state.cast::<Versioned<V>>();
    // SAFETY: any word is a valid number; a struct with the right first word was written by `write`.
    unsafe { if (*state).magic == V::MAGIC { Some(&mut (*state).value) } else { None } }
}

/// As [`get`], for reading.
///
/// # Safety
/// As [`get`], but nothing writes the struct during `'a`.
#[inline(always)]
pub unsafe fn read<'a, V: Stored, S>(state: *const S) -> Option<&'a V> {
    let state = state.cast::<Versioned<V>>();
    // SAFETY: as in `get`.
    unsafe { if (*state).magic == V::MAGIC { Some(&(*state).value) } else { None } }
}
