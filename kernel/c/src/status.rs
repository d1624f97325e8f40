//! Status bits: those of the kernel in the low byte, those of the C interface above.

use ballrace::Status;
use ballrace::bearing::Reaction;

/// No flag.
pub const OK: u32 = 0;
/// An input is NaN or infinite; the result is the last valid value.
pub const INPUT_NOT_FINITE: u32 = 1;
/// The inputs are finite and the result is not; the result is the last valid value.
pub const RESULT_NOT_FINITE: u32 = 2;
/// No element carries load.
pub const CONTACT_LOST: u32 = 4;
/// An element has not reached equilibrium; the force is inaccurate.
pub const NOT_CONVERGED: u32 = 8;
/// The friction that balances the gyroscopic moment exceeds the traction limit of a contact.
pub const GYROSCOPIC_SLIP: u32 = 16;
/// The state of an element is outside the domain of the table.
pub const OUT_OF_TABLE: u32 = 32;
/// The normalised innovation squared exceeds the gate of the observer; the sample corrects nothing.
pub const INNOVATION_REJECTED: u32 = 64;
/// A reading is outside the linear range of its probe or does not change; the probe has its last valid displacement.
pub const INPUT_NOT_OK: u32 = 128;
/// A state was not initialised, or by another version of the library. The call has no effect.
pub const STATE_INVALID: u32 = 256;
/// A parameter is outside its range, or a pointer is NULL. The call has no effect.
pub const INVALID_ARGUMENT: u32 = 512;
/// A block is complete and its results are written.
pub const BLOCK_COMPLETE: u32 = 1024;
/// Not the beginning of a blob at an address that is a multiple of 8, a blob of another version, or a length that does not fit.
pub const BLOB_FORMAT: u32 = 2048;
/// Damaged blob: another CRC-32.
pub const BLOB_CHECKSUM: u32 = 4096;
/// No bearing of this name in the blob.
pub const BLOB_BEARING: u32 = 8192;
/// The bearing in the blob has another model.
pub const BLOB_MODEL: u32 = 16384;
/// The check of a blob or of forces has more parts.
pub const INCOMPLETE: u32 = 32768;

// The bits are those of the kernel.
const _: () = {
    assert!(OK == Status::OK.bits() as u32);
    assert!(INPUT_NOT_FINITE == Status::INPUT_NOT_FINITE.bits() as u32);
    assert!(RESULT_NOT_FINITE == Status::RESULT_NOT_FINITE.bits() as u32);
    assert!(CONTACT_LOST == Status::CONTACT_LOST.bits() as u32);
    assert!(NOT_CONVERGED == Status::NOT_CONVERGED.bits() as u32);
    assert!(GYROSCOPIC_SLIP == Status::GYROSCOPIC_SLIP.bits() as u32);
    assert!(OUT_OF_TABLE == Status::OUT_OF_TABLE.bits() as u32);
    assert!(INNOVATION_REJECTED == Status::INNOVATION_REJECTED.bits() as u32);
    assert!(INPUT_NOT_OK == Status::INPUT_NOT_OK.bits() as u32);
};

/// Returns the bits of a reaction, among them that of lost contact.
#[inline(always)]
pub(crate) fn of_reaction(reaction: &Reaction<f32>) -> u32 {
    u32::from(reaction.status.union(Status::CONTACT_LOST.when(reaction.load == 0.0)).bits())
}

/// Returns the reaction with this wrench whose bits [`of_reaction`] returned.
#[inline(always)]
pub(crate) fn to_reaction(wrench: [f32; 5], bits: u32) -> Reaction<f32> {
    let load = if bits & CONTACT_LOST == 0 { 1.0 } else { 0.0 };
    Reaction {
        wrench: ballrace::Wrench::from_array(wrench),
        load,
        status: Status::from_bits((bits & !CONTACT_LOST) as u8),
    }
}
