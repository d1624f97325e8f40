//! Log of a device: binary frames with a checksum, which the desktop reads as a recording.

use crate::pointer::{self, check_pointers};
use crate::status;
use ballrace::log::crc32;

/// Writes a frame of `4 (count + 2)` bytes: the sequence number, the readings, and the CRC-32 (IEEE 802.3, as in zlib) of the bytes before it,
/// all little-endian.
///
/// The readings are those of the columns of a recording in the order probes, sensors, keyphasor or speed, in the units of the scene; one that is
/// not finite is missing. The number counts samples and wraps. The number of instructions depends on `count` only.
///
/// # Safety
/// `readings` has `count` entries, `frame` has `4 (count + 2)` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_log_frame(number: u32, readings: *const f32, count: u32, frame: *mut u8) -> u32 {
    check_pointers!(readings, frame);
    // SAFETY: by the contract of the function; bytes have no alignment.
    unsafe {
        let word = frame.cast::<[u8; 4]>();
        *word = number.to_le_bytes();
        for i in 0..count as usize {
            *word.add(i + 1) = (*readings.add(i)).to_bits().to_le_bytes();
        }
        let content = 4 * (count + 1);
        *word.add(count as usize + 1) = crc32(pointer::slice(frame, content)).to_le_bytes();
    }
    status::OK
}
