//! Header of an NPY file: a Python dictionary with the type, the order and the shape of an array.
//!
//! Format: NumPy Enhancement Proposal 1, and the documentation of `numpy.lib.format`.

use std::io::{Error, ErrorKind, Read, Result};

/// First bytes of a file.
pub const MAGIC: &[u8] = b"\x93NUMPY";
/// Maximum length of the dictionary, bytes; a dictionary of a thousand fields has a tenth of it.
const LONGEST: u64 = 1 << 18;
/// Maximum nesting depth of brackets: the dictionary, the list of a structure, one of its fields, the field's shape.
const DEEPEST: usize = 4;
/// Longest description of a number, such as `<f8`.
const LONGEST_TYPE: usize = 32;

/// Type, order and shape of an array.
#[derive(Debug, PartialEq)]
pub struct NpyHeader {
    /// Type of an element.
    pub element: ElementType,
    /// Columns are stored one after the other.
    pub is_fortran: bool,
    /// Number of elements along each dimension.
    pub shape: Vec<u64>,
}

/// Type of an element of the array.
#[derive(Debug, PartialEq)]
pub enum ElementType {
    /// A number or a text.
    Plain(PlainType),
    /// A structure of named fields.
    Structure(Vec<Field>),
}

/// Field of a structure.
#[derive(Debug, PartialEq)]
pub struct Field {
    /// Name in the file.
    pub name: String,
    /// Type.
    pub plain: PlainType,
    /// Shape of an array in the field; empty for one element.
    pub shape: Vec<u64>,
}

/// Type of a number or of a text.
#[derive(Debug, PartialEq)]
pub struct PlainType {
    /// As in the file, for example `<f8`.
    pub text: String,
    /// Kind of type, for example `f`.
    pub kind: char,
    /// Bytes of an element; none where the type has no size.
    pub bytes: Option<u64>,
    /// The byte of most weight is first.
    pub is_big_endian: bool,
}

impl NpyHeader {
    /// Reads the header; the numbers follow.
    ///
    /// # Errors
    /// Another format, a header that is truncated, longer than any in use, or not of an array of plain elements or structures.
    pub fn read(file: &mut impl Read) -> Result<Self> {
        let mut first = [0; 10];
        file.read_exact(&mut first)?;
        if !first.starts_with(MAGIC) {
            return Err(Error::other("no NPY file"));
        }
        let mut length = u64::from(u16::from_le_bytes([first[8], first[9]]));
        if first[6] > 1 {
            let mut high = [0; 2];
            file.read_exact(&mut high)?;
            length += u64::from(u16::from_le_bytes(high)) << 16;
        }
        if length > LONGEST {
            return Err(Error::other(format!("a header of {length} bytes")));
        }
        let mut text = Vec::new();
        file.take(length).read_to_end(&mut text)?;
        if (text.len() as u64) < length {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let text = String::from_utf8(text).map_err(|_| Error::other("a header that is not text"))?;
        Self::parse(&text)
    }

    fn parse(text: &str) -> Result<Self> {
        let mut parser = Parser { rest: text, depth: 0 };
        let Value::Dictionary(entries) = parser.value()? else { return Err(malformed()) };
        let (mut element, mut is_fortran, mut shape) = (None, None, None);
        for (key, value) in entries {
            match (key.as_str(), value) {
                ("descr", value) => element = Some(element_type(value)?),
                ("fortran_order", Value::Bool(given)) => is_fortran = Some(given),
                ("shape", value) => shape = Some(numbers(value)?),
                _ => return Err(malformed()),
            }
        }
        match (element, is_fortran, shape) {
            (Some(element), Some(is_fortran), Some(shape)) => Ok(Self { element, is_fortran, shape }),
            _ => Err(malformed()),
        }
    }
}

fn malformed() -> Error {
    Error::other("a malformed header")
}

fn element_type(value: Value) -> Result<ElementType> {
    match value {
        Value::Text(text) => plain_type(text).map(ElementType::Plain),
        Value::List(fields) => fields.into_iter().map(field).collect::<Result<_>>().map(ElementType::Structure),
        _ => Err(malformed()),
    }
}

fn field(value: Value) -> Result<Field> {
    let Value::Tuple(parts) = value else { return Err(malformed()) };
    let mut parts = parts.into_iter();
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(Value::Text(name)), Some(Value::Text(text)), shape, None) => {
            let shape = shape.map_or(Ok(vec![]), numbers)?;
            Ok(Field { name, plain: plain_type(text)?, shape })
        }
        (_, Some(Value::List(_)), ..) => Err(Error::other("a structure within a structure")),
        _ => Err(malformed()),
    }
}

/// Returns the numbers of a tuple, or a single number as a list.
fn numbers(value: Value) -> Result<Vec<u64>> {
    let one = |value| if let Value::Number(number) = value { Ok(number) } else { Err(malformed()) };
    match value {
        Value::Tuple(all) => all.into_iter().map(one).collect(),
        value => Ok(vec![one(value)?]),
    }
}

fn plain_type(text: String) -> Result<PlainType> {
    let unknown = || Error::other("an unknown type of numbers");
    let mut letters = text.chars();
    let order = letters.next().filter(|order| "<>|=".contains(*order) && text.len() <= LONGEST_TYPE);
    let (Some(order), Some(kind)) = (order, letters.next().filter(char::is_ascii_alphabetic)) else {
        return Err(unknown());
    };
    // Times end with their unit.
    let digits = letters.as_str().split('[').next().unwrap_or_default();
    let size = match digits {
        "" => None,
        digits => Some(digits.parse::<u64>().map_err(|_| unknown())?),
    };
    // The size of a Unicode text is a number of characters of 4 bytes.
    let bytes = size.and_then(|size| size.checked_mul(if kind == 'U' { 4 } else { 1 }));
    let is_big_endian = order == '>' || (order == '=' && cfg!(target_endian = "big"));
    Ok(PlainType { text, kind, bytes, is_big_endian })
}

/// Python literal.
enum Value {
    Text(String),
    Number(u64),
    Bool(bool),
    Tuple(Vec<Self>),
    List(Vec<Self>),
    Dictionary(Vec<(String, Self)>),
}

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
}

impl Parser<'_> {
    fn value(&mut self) -> Result<Value> {
        self.skip_blanks();
        match self.rest.chars().next() {
            Some('\'' | '"') => self.text().map(Value::Text),
            Some('0'..='9') => self.number().map(Value::Number),
            Some('(') => self.list(')', Self::value).map(Value::Tuple),
            Some('[') => self.list(']', Self::value).map(Value::List),
            Some('{') => self.list('}', Self::entry).map(Value::Dictionary),
            _ if self.take("True") => Ok(Value::Bool(true)),
            _ if self.take("False") => Ok(Value::Bool(false)),
            _ => Err(malformed()),
        }
    }

    fn entry(&mut self) -> Result<(String, Value)> {
        let key = self.text()?;
        self.skip_blanks();
        if self.take(":") { Ok((key, self.value()?)) } else { Err(malformed()) }
    }

    /// Parses items up to `end`, separated by commas; a trailing comma is allowed.
    fn list<X>(&mut self, end: char, mut item: impl FnMut(&mut Self) -> Result<X>) -> Result<Vec<X>> {
        self.rest = self.rest.get(1..).unwrap_or_default();
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Error::other("a structure within a structure"));
        }
        let mut all = Vec::new();
        loop {
            self.skip_blanks();
            if self.take(end.encode_utf8(&mut [0; 4])) {
                break;
            }
            all.push(item(self)?);
            self.skip_blanks();
            if !self.take(",") && !self.rest.starts_with(end) {
                return Err(malformed());
            }
        }
        self.depth -= 1;
        Ok(all)
    }

    fn number(&mut self) -> Result<u64> {
        let end = self.rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(end);
        // Python 2 writes a long integer with the suffix `L`.
        self.rest = rest.strip_prefix('L').unwrap_or(rest);
        digits.parse().map_err(|_| malformed())
    }

    fn text(&mut self) -> Result<String> {
        let mut letters = self.rest.chars();
        let quote = letters.next().filter(|quote| matches!(quote, '\'' | '"')).ok_or_else(malformed)?;
        let mut text = String::new();
        loop {
            match letters.next() {
                Some(letter) if letter == quote => break,
                Some('\\') => match letters.next() {
                    Some(letter @ ('\\' | '\'' | '"')) => text.push(letter),
                    Some('x') => text.push(code(&mut letters, 2)?),
                    Some('u') => text.push(code(&mut letters, 4)?),
                    _ => return Err(malformed()),
                },
                Some(letter) => text.push(letter),
                None => return Err(malformed()),
            }
        }
        self.rest = letters.as_str();
        Ok(text)
    }

    fn skip_blanks(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn take(&mut self, token: &str) -> bool {
        match self.rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }
}

/// Returns the character of the next `count` hexadecimal digits.
fn code(letters: &mut std::str::Chars<'_>, count: usize) -> Result<char> {
    let digit = |letters: &mut std::str::Chars<'_>| letters.next().and_then(|digit| digit.to_digit(16));
    let number = (0..count).try_fold(0, |number, _| digit(letters).map(|digit| 16 * number + digit));
    number.and_then(char::from_u32).ok_or_else(malformed)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn headers_of_numpy() {
        let header = NpyHeader::parse("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }   \n").unwrap();
        let f8 = || PlainType { text: "<f8".to_owned(), kind: 'f', bytes: Some(8), is_big_endian: false };
        assert_eq!(header, NpyHeader { element: ElementType::Plain(f8()), is_fortran: false, shape: vec![3, 4] });
        // Python 2, another order of keys, no blanks.
        let header = NpyHeader::parse("{\"shape\":(30L,),\"fortran_order\":True,\"descr\":\"<f8\"}").unwrap();
        assert_eq!((header.shape.as_slice(), header.is_fortran), ([30].as_slice(), true));
        assert!(NpyHeader::parse("{'descr': '|b1', 'fortran_order': False, 'shape': ()}").unwrap().shape.is_empty());
        let text = "{'descr': [('it\\'s \\u00e4', '<f8'), ('n', '<U5', (2,)), ('t', '<M8[ns]')], 'fortran_order': False, 'shape': (1,)}";
        let ElementType::Structure(fields) = NpyHeader::parse(text).unwrap().element else { unreachable!() };
        assert_eq!(fields[0], Field { name: "it's \u{e4}".to_owned(), plain: f8(), shape: vec![] });
        assert_eq!((fields[1].plain.bytes, fields[1].shape.as_slice()), (Some(20), [2].as_slice()));
        assert_eq!((fields[2].plain.kind, fields[2].plain.bytes), ('M', Some(8)));
    }

    #[test]
    fn malformed_headers_are_refused() {
        let whole = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }";
        for end in 0..whole.len() {
            assert!(NpyHeader::parse(&whole[..end]).is_err(), "{end}");
        }
        for (from, to) in [
            ("'<f8'", "'f8'"),
            ("'<f8'", "'<8'"),
            ("'<f8'", "'<f-8'"),
            ("'<f8'", "8"),
            ("'<f8'", "[['<f8']]"),
            ("'<f8'", "'<\\q'"),
            ("False", "None"),
            ("(3, 4)", "(3 4)"),
            ("(3, 4)", "(-3, 4)"),
            ("(3, 4)", "('3', 4)"),
            ("(3, 4)", "(99999999999999999999,)"),
            ("'shape'", "'form'"),
        ] {
            assert!(NpyHeader::parse(&whole.replacen(from, to, 1)).is_err(), "{to}");
        }
        assert!(NpyHeader::parse(&"[".repeat(100_000)).is_err());
    }
}
