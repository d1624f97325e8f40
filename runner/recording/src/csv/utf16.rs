//! Text in UTF-16, as spreadsheets write "Unicode text": converted to UTF-8 while it is read.

use std::io::{self, Cursor, Read};

/// Marks of the byte order at the beginning of a text.
const LITTLE_ENDIAN: [u8; 2] = [0xFF, 0xFE];
const BIG_ENDIAN: [u8; 2] = [0xFE, 0xFF];
/// Bytes of UTF-16 that are converted at once.
const BLOCK: usize = 1 << 14;

/// Returns the text in UTF-8, and true where it is in UTF-16 by its byte order mark.
pub(super) fn decoded(mut reader: Box<dyn Read + Send>) -> io::Result<(Box<dyn Read + Send>, bool)> {
    let mut mark = Vec::new();
    reader.by_ref().take(2).read_to_end(&mut mark)?;
    let is_big_endian = mark == BIG_ENDIAN;
    if is_big_endian || mark == LITTLE_ENDIAN {
        let text = Decoder { inner: reader, is_big_endian, odd: None, high: None, ready: Cursor::default() };
        return Ok((Box::new(text), true));
    }
    Ok((Box::new(Cursor::new(mark).chain(reader)), false))
}

/// A text in UTF-16 as one in UTF-8. A half of a pair without the other is U+FFFD.
struct Decoder<R> {
    inner: R,
    is_big_endian: bool,
    /// First byte of a unit whose second one is not read yet.
    odd: Option<u8>,
    /// First half of a pair.
    high: Option<u16>,
    /// Converted text.
    ready: Cursor<Vec<u8>>,
}

impl<R: Read> Decoder<R> {
    /// Converts the next block; false at the end.
    fn convert(&mut self) -> io::Result<bool> {
        let mut block: Vec<u8> = self.odd.take().into_iter().collect();
        let before = block.len();
        // One call of `read`: a live source returns what has arrived.
        block.resize(before + BLOCK, 0);
        let count = self.inner.read(block.get_mut(before..).unwrap_or_default())?;
        block.truncate(before + count);
        if count == 0 {
            let is_cut = !block.is_empty() || self.high.take().is_some();
            self.ready = Cursor::new(if is_cut { "\u{FFFD}".into() } else { vec![] });
            return Ok(is_cut);
        }
        let (pairs, rest) = block.as_chunks::<2>();
        self.odd = rest.first().copied();
        let order = if self.is_big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
        let mut units: Vec<u16> = self.high.take().into_iter().chain(pairs.iter().map(|pair| order(*pair))).collect();
        self.high = units.pop_if(|last| (0xD800..0xDC00).contains(last));
        let text: String =
            char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        self.ready = Cursor::new(text.into_bytes());
        Ok(true)
    }
}

impl<R: Read> Read for Decoder<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = self.ready.read(buffer)?;
            if count > 0 || buffer.is_empty() || !self.convert()? {
                return Ok(count);
            }
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// A source that returns one byte at a time.
    struct Slow(Cursor<Vec<u8>>);

    impl Read for Slow {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = buffer.len().min(1);
            self.0.read(&mut buffer[..count])
        }
    }

    fn text_of(bytes: &[u8]) -> (Vec<u8>, bool) {
        let read = |source: Box<dyn Read + Send>| {
            let (mut reader, is_utf16) = decoded(source).unwrap();
            let mut text = Vec::new();
            reader.read_to_end(&mut text).unwrap();
            (text, is_utf16)
        };
        let whole = read(Box::new(Cursor::new(bytes.to_vec())));
        assert_eq!(whole, read(Box::new(Slow(Cursor::new(bytes.to_vec())))));
        whole
    }

    #[test]
    fn both_byte_orders_are_converted() {
        let text = "t,x \u{b5}m\r\n1,2\u{1F600}\n".repeat(3000);
        for is_big_endian in [false, true] {
            let order = if is_big_endian { u16::to_be_bytes } else { u16::to_le_bytes };
            let bytes: Vec<u8> = "\u{FEFF}".encode_utf16().chain(text.encode_utf16()).flat_map(order).collect();
            assert_eq!(text_of(&bytes), (text.clone().into_bytes(), true));
        }
    }

    #[test]
    fn other_texts_are_unchanged() {
        for text in ["", "a", "ab", "\u{FEFF}x,y\n", "x,y\n1,2\n"] {
            assert_eq!(text_of(text.as_bytes()), (text.as_bytes().to_vec(), false));
        }
    }

    #[test]
    fn damaged_text_has_replacement_characters() {
        let cut = |bytes: &[u8]| String::from_utf8(text_of(bytes).0).unwrap();
        assert_eq!(cut(b"\xFF\xFEa\0b"), "a\u{FFFD}");
        assert_eq!(cut(b"\xFF\xFEa\0\x00\xD8"), "a\u{FFFD}");
        assert_eq!(cut(b"\xFF\xFE\x00\xDCa\0"), "\u{FFFD}a");
        assert_eq!(cut(b"\xFF\xFE"), "");
    }
}
