//! Pointers of the host.

use std::ffi::{CStr, c_char};

/// Returns the `count` values at `pointer`.
///
/// # Safety
/// `pointer` is null or has `count` values that nothing writes meanwhile.
pub unsafe fn values<'a, T>(name: &str, pointer: *const T, count: usize) -> Result<&'a [T], String> {
    check(name, pointer, count)?;
    // SAFETY: not null, aligned, of a size that an address space can have; the rest is the caller's.
    Ok(if count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(pointer, count) } })
}

/// Returns the `count` places at `pointer`.
///
/// # Safety
/// `pointer` is null or has `count` initialised values that nothing else uses meanwhile.
pub unsafe fn places<'a, T>(name: &str, pointer: *mut T, count: usize) -> Result<&'a mut [T], String> {
    check(name, pointer, count)?;
    // SAFETY: as in `values`.
    Ok(if count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(pointer, count) } })
}

fn check<T>(name: &str, pointer: *const T, count: usize) -> Result<(), String> {
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if count > 0 && pointer.is_null() {
        return Err(format!("{name}: null, expected {count} values"));
    }
    if count > 0 && (!pointer.is_aligned() || count > most) {
        return Err(format!("{name}: no place of {count} values"));
    }
    Ok(())
}

/// Returns the text at `pointer`.
///
/// # Safety
/// `pointer` is null or a text that ends with a 0 and that nothing writes meanwhile.
pub unsafe fn text<'a>(name: &str, pointer: *const c_char) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("{name}: null, expected a text"));
    }
    // SAFETY: not null; the rest is the caller's.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| format!("{name}: bytes that are not UTF-8 text"))
}

/// Writes a value where there is a place.
///
/// # Safety
/// `place` is null or writable.
pub unsafe fn store<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: the caller's.
        unsafe { place.write_unaligned(value) };
    }
}
