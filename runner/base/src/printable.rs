//! Text of files for a terminal: printable and bounded.
//!
//! Names, cells and units of a recording or a scene are untrusted data. An escape sequence in one of them can move the cursor,
//! a line break can forge a line of output, a name of a megabyte can hide the message.

use std::borrow::Cow;
use std::io::{self, Write};

/// Longest name in a message, in characters.
const NAME: usize = 120;
/// Longest message, in characters: thirty column names and a sentence.
const MESSAGE: usize = 4000;

/// Returns a name or cell for a message: escaped, at most 120 characters long.
#[must_use]
pub fn name(text: &str) -> String {
    escaped(&bounded(text, NAME), false).into_owned()
}

/// Returns a whole message on one line: escaped, at most 4000 characters long.
#[must_use]
pub fn message(text: &str) -> String {
    escaped(&bounded(text, MESSAGE), false).into_owned()
}

/// Returns text of several lines with everything escaped but its line breaks.
#[must_use]
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, true)
}

/// Escapes what is written to it, except for line breaks.
pub struct Printable<W>(pub W);

impl<W: Write> Write for Printable<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write_all(lines(&String::from_utf8_lossy(bytes)).as_bytes())?;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Returns a number for a message: at most six decimals, in powers of ten where it is very large or small.
#[must_use]
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e13).contains(&size) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        format!("{value:e}")
    }
}

fn bounded(text: &str, limit: usize) -> Cow<'_, str> {
    match text.char_indices().nth(limit) {
        None => text.into(),
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()).into(),
    }
}

fn escaped(text: &str, line_breaks: bool) -> Cow<'_, str> {
    let prints = |c: char| (c == '\n' && line_breaks) || !(c.is_control() || is_invisible(c));
    if text.chars().all(prints) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            _ if prints(c) => shown.push(c),
            '\t' | '\n' | '\r' => shown.extend(c.escape_default()),
            _ => shown.extend(c.escape_unicode()),
        }
    }
    shown.into()
}

/// Returns true for characters without a glyph that change how others are shown: joiners, line separators, directions, tags.
const fn is_invisible(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
        | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn controls_are_escaped_and_letters_of_any_language_stay() {
        assert_eq!(name("\u{1b}[2J\u{9b}31m\r\nDE"), "\\u{1b}[2J\\u{9b}31m\\r\\nDE");
        assert_eq!(name("a\u{202e}b\u{2028}c"), "a\\u{202e}b\\u{2028}c");
        assert_eq!(name("Wälzlager 軸受 \"A\" \\ 'B'"), "Wälzlager 軸受 \"A\" \\ 'B'");
        assert_eq!(lines("one\ntwo\u{7}"), "one\ntwo\\u{7}");
    }

    #[test]
    fn long_text_is_cut() {
        let long = "ä".repeat(1 << 20);
        assert_eq!(name(&long).chars().count(), NAME + 3);
        assert_eq!(message(&long).chars().count(), MESSAGE + 3);
        assert_eq!(name(&"x".repeat(NAME)), "x".repeat(NAME));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (200.0 + 1e-13, "200"),
            (0.0, "0"),
            (12.8, "12.8"),
            (1e12, "1000000000000"),
            (-1e308, "-1e308"),
            (1e-300, "1e-300"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn a_writer_escapes_each_piece() {
        let mut out = Printable(Vec::new());
        let _ = writeln!(out, "bearing D\u{1b}E");
        assert_eq!(out.0, b"bearing D\\u{1b}E\n");
    }
}
