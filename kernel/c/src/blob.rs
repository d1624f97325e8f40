//! Bearings from a blob that `ballrace bake SCENE -o F.blob` writes: its elements, tables and laminae are used in place.

use crate::bearing::Bearing;
use crate::checksum::ChecksumRange;
use crate::pointer::{self, check_bearing, check_pointers};
use crate::status;
use ballrace::blob::{self, Blob, InvalidBlob};
use core::ffi::{CStr, c_char};

/// State of the check of a blob; 0 before it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlobCheck {
    /// Number of checked bytes.
    pub checked: u32,
    /// Their CRC-32.
    pub crc: u32,
}

/// Constants of a bearing in a blob besides those of its struct.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlobConstants {
    /// Angle of the cage over that of the shaft.
    pub cage_ratio: f64,
    /// Angle of a ball about its axis over that of the shaft.
    pub ball_ratio: f64,
    /// Angle of the outer ring over that of the shaft.
    pub outer_ratio: f64,
    /// `ballrace_checksum` of the bearing, as the desktop computes it.
    pub checksum: u64,
    /// Displacements and speeds of the checksum.
    pub checksum_range: ChecksumRange,
    /// Displacement by preload, to be added to every displacement, m and rad.
    pub offset: [f32; 5],
    /// Station along Z from the rotor's centre of mass, m.
    pub station: f32,
}

/// Returns the bit of a reason.
fn bit_of(reason: InvalidBlob) -> u32 {
    match reason {
        InvalidBlob::Checksum => status::BLOB_CHECKSUM,
        InvalidBlob::NoBearing => status::BLOB_BEARING,
        InvalidBlob::Model(_) => status::BLOB_MODEL,
        _ => status::BLOB_FORMAT,
    }
}

/// Checks `count` further bytes of a blob in `length` bytes, which may be more than its own: the page of flash that it lies in. Returns
/// `BALLRACE_INCOMPLETE` until all are checked, so that a watchdog can be reset between the calls; then `BALLRACE_OK`, `BALLRACE_BLOB_FORMAT`
/// or `BALLRACE_BLOB_CHECKSUM`. A CRC-32 tells damage, not intent: the signature of a blob is the bootloader's.
///
/// # Safety
/// `blob` points to `length` bytes, `check` to a state that is 0 before the first call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_blob_check(blob: *const u8, length: u32, check: *mut BlobCheck, count: u32) -> u32 {
    check_pointers!(blob, check);
    // SAFETY: by the contract of the function.
    let (bytes, state) = unsafe { (pointer::slice(blob, length), &mut *check) };
    let mut check = blob::BlobCheck { checked: state.checked, crc: state.crc };
    let found = check.advance(bytes, count as usize);
    *state = BlobCheck { checked: check.checked, crc: check.crc };
    match found {
        None => status::INCOMPLETE,
        Some(Ok(_)) => status::OK,
        Some(Err(reason)) => bit_of(reason),
    }
}

/// Reads the bearing of this name from a blob that `ballrace_blob_check` found right. `bearing->model` is set before the call:
/// `BALLRACE_BLOB_MODEL` for a bearing of another model. The blob must exist as long as the bearing, which uses its elements and its table.
///
/// # Safety
/// `blob` points to `length` bytes, `name` to a text, `bearing` to the head of a struct of its model, `constants` to a struct or nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_blob_bearing(
    blob: *const u8,
    length: u32,
    name: *const c_char,
    bearing: *mut Bearing,
    constants: *mut BlobConstants,
) -> u32 {
    check_bearing!(bearing, blob, name);
    // SAFETY: by the contract of the function.
    let (bytes, name) = unsafe { (pointer::slice(blob, length), CStr::from_ptr(name).to_bytes()) };
    let found = match Blob::checked_before(bytes) {
        Ok(blob) => blob.bearings().find(|bearing| bearing.name() == name),
        Err(reason) => return bit_of(reason),
    };
    let Some(found) = found else { return status::BLOB_BEARING };
    // SAFETY: by the contract of the function.
    let shape = unsafe { (*(*bearing).model).blob };
    if found.code() != shape.code {
        return status::BLOB_MODEL;
    }
    let (words, _) = found.constants().as_chunks::<4>();
    let table = found.table();
    let entries = words.last().map_or(0, |word| u32::from_le_bytes(*word));
    let fits =
        shape.array == 0 || entries.checked_mul(shape.numbers).is_some_and(|count| count as usize == table.len());
    if words.len() != shape.words as usize || !fits {
        return status::BLOB_FORMAT;
    }
    // SAFETY: the struct has `words` members of 4 bytes after its head, and a pointer at `array`.
    unsafe {
        (*bearing).elements = found.elements().as_ptr().cast();
        (*bearing).element_count = found.elements().len() as u32;
        core::ptr::copy_nonoverlapping(words.as_ptr(), bearing.add(1).cast(), words.len());
        if shape.array != 0 {
            bearing.byte_add(shape.array as usize).cast::<*const f32>().write(table.as_ptr());
        }
    }
    let range = found.checksum_range();
    let [cage_ratio, ball_ratio, outer_ratio] = found.ratios();
    if !constants.is_null() {
        let constants_of = BlobConstants {
            cage_ratio,
            ball_ratio,
            outer_ratio,
            checksum: found.checksum(),
            checksum_range: ChecksumRange {
                centre: range.centre.to_array(),
                amplitude: range.amplitude.to_array(),
                inner_speed: range.inner_speed,
                outer_speed: range.outer_speed,
            },
            offset: found.offset().to_array(),
            station: found.station(),
        };
        // SAFETY: by the contract of the function.
        unsafe { constants.write(constants_of) };
    }
    status::OK
}
