//! Log of a device: binary frames with a checksum, which the desktop reads as a recording.

/// Remainders of CRC-32 (IEEE 802.3, reflected polynomial 0xEDB88320) for half a byte: 64 bytes of flash.
const REMAINDERS: [u32; 16] = {
    let mut remainders = [0; 16];
    let mut half = 0;
    while half < 16 {
        let mut bit = 0;
        let mut remainder = half as u32;
        while bit < 4 {
            remainder = (remainder >> 1) ^ (0xEDB8_8320 * (remainder & 1));
            bit += 1;
        }
        remainders[half] = remainder;
        half += 1;
    }
    remainders
};

/// Returns the CRC-32 (IEEE 802.3, as in zlib) of bytes. The number of instructions depends on their number only.
///
/// ```
/// assert_eq!(ballrace::log::crc32(b"123456789"), 0xCBF4_3926);
/// ```
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    continued_crc32(0, bytes)
}

/// Returns the CRC-32 of earlier bytes, whose CRC-32 is `crc` (0 for none), and further ones.
///
/// ```
/// use ballrace::log::continued_crc32;
///
/// assert_eq!(continued_crc32(continued_crc32(0, b"1234"), b"56789"), 0xCBF4_3926);
/// ```
#[must_use]
pub fn continued_crc32(crc: u32, bytes: &[u8]) -> u32 {
    let step = |crc: u32, half: u8| {
        let [index, ..] = (crc ^ u32::from(half)).to_le_bytes();
        // The index has four bits.
        (crc >> 4) ^ REMAINDERS.get(usize::from(index & 15)).copied().unwrap_or(0)
    };
    !bytes.iter().fold(!crc, |crc, byte| step(step(crc, *byte), byte >> 4))
}

/// Returns a frame: the sequence number, the readings, and the CRC-32 of the bytes before it, all little-endian; `BYTES` = 4 (`N` + 2).
///
/// The readings are those of the columns of a recording in the order probes, sensors, keyphasor or speed, in the units of the scene; one
/// that is not finite is missing. The number counts samples and wraps.
///
/// Takes the same number of instructions whatever the readings.
///
/// ```
/// let frame: [u8; 16] = ballrace::log::frame(7, &[1.0, -2.0]);
/// assert_eq!(frame[..12], [7, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0]);
/// assert_eq!(frame[12..], ballrace::log::crc32(&frame[..12]).to_le_bytes());
/// ```
#[must_use]
pub fn frame<const N: usize, const BYTES: usize>(number: u32, readings: &[f32; N]) -> [u8; BYTES] {
    const { assert!(BYTES == 4 * (N + 2), "a frame of N readings has 4 (N + 2) bytes") };
    let mut frame = [0; BYTES];
    if let Some((content, checksum)) = frame.split_last_chunk_mut() {
        let (words, _) = content.as_chunks_mut();
        let contents = core::iter::once(number).chain(readings.iter().map(|x| x.to_bits()));
        for (word, bits) in words.iter_mut().zip(contents) {
            *word = bits.to_le_bytes();
        }
        *checksum = crc32(content).to_le_bytes();
    }
    frame
}
