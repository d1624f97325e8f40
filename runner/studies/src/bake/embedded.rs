//! Text inside the comments of a source file: one comment per line between two marks.

/// Start of a comment line, in both languages.
const COMMENT: &str = "//";

/// A block of comments.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    begin: &'static str,
    end: &'static str,
}

/// The fields of the certificate.
pub const CERTIFICATE: Block = Block { begin: "//: ballrace certificate begin", end: "//: ballrace certificate end" };
/// The text of the scene.
pub const SCENE: Block = Block { begin: "//: ballrace scene begin", end: "//: ballrace scene end" };

impl Block {
    /// Returns the block with `text`, each line as a comment.
    #[must_use]
    pub fn write(self, text: &str) -> String {
        let mut out = format!("{}\n", self.begin);
        for line in text.split('\n') {
            let space = if line.is_empty() { "" } else { " " };
            out += &format!("{COMMENT}{space}{}\n", escaped(line));
        }
        out + self.end + "\n"
    }

    /// Returns the text of the block in a source file; `None` if a mark is absent or a line is not a comment.
    #[must_use]
    pub fn read(self, source: &str) -> Option<String> {
        let mut lines = source.lines().skip_while(|line| line.trim_end() != self.begin).skip(1);
        let mut text: Vec<String> = Vec::new();
        loop {
            let line = lines.next()?;
            if line.trim_end() == self.end {
                return Some(text.join("\n"));
            }
            let content = line.strip_prefix(COMMENT)?;
            text.push(unescaped(content.strip_prefix(' ').unwrap_or(content))?);
        }
    }

    /// Returns true if a line is in the block, its marks included; `inside` is the state from line to line.
    pub fn contains(self, line: &str, inside: &mut bool) -> bool {
        let line = line.trim_end();
        *inside |= line == self.begin;
        let contains = *inside;
        *inside &= line != self.end;
        contains
    }
}

/// Returns true for a character that changes a comment or its display: a backslash at the end of a line continues a comment of C,
/// `??/` is such a backslash, control and bidirectional characters are rejected by compilers.
fn is_escaped(c: char, next: Option<char>) -> bool {
    let is_bidirectional = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let is_separator = matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}');
    c == '\\' || c.is_control() && c != '\t' || is_bidirectional || is_separator || c == '?' && next == Some('?')
}

/// Returns a line with `\u{...}` in place of characters that a comment cannot hold.
pub fn escaped(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        if is_escaped(c, characters.peek().copied()) {
            out += &format!("\\u{{{:x}}}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

fn unescaped(line: &str) -> Option<String> {
    let mut parts = line.split("\\u{");
    let mut out = parts.next()?.to_owned();
    for part in parts {
        let (code, rest) = part.split_once('}')?;
        out.push(char::from_u32(u32::from_str_radix(code, 16).ok()?)?);
        out += rest;
    }
    Some(out)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::{CERTIFICATE, SCENE, escaped};

    #[test]
    fn any_text_returns_from_its_comments() {
        let texts = [
            "",
            "\n",
            "name = \"a\"\n",
            "a\r\nb\\\nc ??/\n?? \t\u{202e}\u{0}\u{2028}\n\nballrace scene end\n: ballrace scene end\n",
            "\u{feff}a \u{3bc}m\n  b  ",
        ];
        for text in texts {
            let source = format!("{}fn f() {{}}\n{}", CERTIFICATE.write("x: 1"), SCENE.write(text));
            assert_eq!(SCENE.read(&source).as_deref(), Some(text), "{source}");
            assert_eq!(CERTIFICATE.read(&source).as_deref(), Some("x: 1"));
            assert!(source.lines().all(|line| !line.ends_with('\\') && !line.contains("??")), "{source}");
            let mut inside = false;
            let outside = source.lines().filter(|line| !SCENE.contains(line, &mut inside));
            assert_eq!(outside.count(), 4);
        }
        assert_eq!(escaped("a\\b"), "a\\u{5c}b");
    }

    #[test]
    fn a_block_without_its_end_is_none() {
        let source = SCENE.write("a = 1");
        assert_eq!(SCENE.read(source.trim_end().rsplit_once('\n').unwrap().0), None);
        assert_eq!(SCENE.read("fn f() {}\n"), None);
        assert_eq!(SCENE.read(&source.replace("// a", "a")), None);
        assert_eq!(SCENE.read(&source.replace("a = 1", "\\u{zz}")), None);
    }
}
