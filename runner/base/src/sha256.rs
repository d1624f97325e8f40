//! SHA-256 of a file.

use sha2::{Digest, Sha256};
use std::io::{self, Read};

/// Bytes that are read at a time.
const BLOCK: usize = 1 << 16;

/// Returns the SHA-256 of all bytes of `reader`, in hexadecimal digits, and their number.
pub fn of(mut reader: impl Read) -> io::Result<(String, u64)> {
    let (mut hash, mut bytes, mut block) = (Sha256::new(), 0, vec![0; BLOCK]);
    loop {
        match reader.read(&mut block)? {
            0 => return Ok((hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect(), bytes)),
            count => {
                hash.update(block.get(..count).unwrap_or_default());
                bytes += count as u64;
            }
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    #[test]
    fn the_hash_is_that_of_the_standard() {
        // FIPS 180-4, example with one block.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(super::of(&b"abc"[..]).unwrap(), (expected.to_owned(), 3));
    }
}
