//! Access to the memory of the caller.

use ballrace::{Displacement, Wrench};

/// Returns from the calling function with `INVALID_ARGUMENT` where a pointer is null, in a library with checks.
macro_rules! check_pointers {
    ($($pointer:expr),+ $(,)?) => {
        #[cfg(any(debug_assertions, feature = "checks"))]
        if [$($pointer.is_null()),+].contains(&true) {
            return $crate::status::INVALID_ARGUMENT;
        }
    };
}
pub(crate) use check_pointers;

/// As `check_pointers`, for a bearing and other pointers.
macro_rules! check_bearing {
    ($bearing:expr $(, $pointer:expr)* $(,)?) => {
        #[cfg(any(debug_assertions, feature = "checks"))]
        // SAFETY: the contract of every call with a bearing: null, or the head of a struct.
        if $bearing.is_null() || unsafe { (*$bearing).model.is_null() } $(|| $pointer.is_null())* {
            return $crate::status::INVALID_ARGUMENT;
        }
    };
}
pub(crate) use check_bearing;

/// Reads a displacement.
///
/// # Safety
/// `entries` points to five floats.
#[inline(always)]
pub unsafe fn displacement(entries: *const f32) -> Displacement<f32> {
    // SAFETY: five floats by the contract of the function; an array has the alignment of its entries.
    Displacement::from_array(unsafe { *entries.cast::<[f32; 5]>() })
}

/// Writes a wrench.
///
/// # Safety
/// `entries` points to five floats.
#[inline(always)]
pub unsafe fn write_wrench(entries: *mut f32, wrench: &Wrench<f32>) {
    // SAFETY: five floats by the contract of the function; an array has the alignment of its entries.
    unsafe { *entries.cast::<[f32; 5]>() = wrench.to_array() };
}

/// Returns the slice of `count` items at `first`; an empty one where `count` is 0, whatever the pointer.
///
/// # Safety
/// `first` points to `count` items that nothing changes during `'a`, or `count` is 0.
#[inline(always)]
pub unsafe fn slice<'a, T>(first: *const T, count: u32) -> &'a [T] {
    // SAFETY: by the contract of the function; models without elements do not call it.
    unsafe { core::slice::from_raw_parts(first, count as usize) }
}
