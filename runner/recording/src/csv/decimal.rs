//! The decimal mark of a file: a point, or a comma where another character separates the cells.

/// Rows in which the decimal mark of a file is searched.
pub(super) const ROWS: usize = 1000;

/// Values expected where a comma separates thousands or decimals.
pub(super) const EXPECTED: &str = "a decimal point, or a decimal comma that is no separator of thousands: \
                                   a cell such as `1,5` or `0,250` in one of the first 1000 rows";
/// Values expected after cells with a decimal comma.
pub(super) const EXPECTED_COMMA: &str = "a number with a decimal comma, as in the cells before";

/// Words of loggers and spreadsheets in place of a reading: overload, absence, and what printing makes of numbers that are not
/// finite. `NaN` and `Inf` are read as numbers.
const MISSING: [&[u8]; 17] = [
    b"OVL",
    b"OL",
    b"OVLD",
    b"OVR",
    b"OVER",
    b"OVERLOAD",
    b"OVERRANGE",
    b"OVERFLOW",
    b"NA",
    b"N/A",
    b"#N/A",
    b"#NV",
    b"#NUM!",
    b"#VALUE!",
    b"#DIV/0!",
    b"NULL",
    b"NONE",
];

/// Character between the whole number and its decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecimalMark {
    /// No cell had one so far.
    Unknown,
    Point,
    Comma,
}

/// A comma may separate thousands or decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ambiguity;

impl DecimalMark {
    /// Returns the decimal mark that the cells of a row have.
    pub(super) fn of<'a>(cells: impl Iterator<Item = &'a [u8]>) -> Result<Self, Ambiguity> {
        let mut mark = Ok(Self::Unknown);
        for cell in cells {
            if cell.contains(&b'.') && Self::Point.number(cell).is_some() {
                return Ok(Self::Point);
            }
            if is_ambiguous(cell) {
                mark = Err(Ambiguity);
            } else if cell.contains(&b',') && Self::Comma.number(cell).is_some() {
                return Ok(Self::Comma);
            }
        }
        mark
    }

    /// Reads a finite number, or NaN for nothing, infinity and a word such as `OVL`: the reading is missing.
    pub(super) fn number(self, text: &[u8]) -> Option<f64> {
        let text = text.trim_ascii();
        if text.is_empty() || is_not_finite(text) || MISSING.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            return Some(f64::NAN);
        }
        let text = str::from_utf8(text).ok()?;
        let number = match self {
            Self::Comma => match text.split_once(',') {
                _ if text.contains('.') => return None,
                Some((whole, decimals)) => format!("{whole}.{decimals}").parse::<f64>().ok()?,
                None => text.parse::<f64>().ok()?,
            },
            _ => text.parse::<f64>().ok()?,
        };
        // Digits that overflow are no reading of a logger.
        if number.is_infinite() && text.bytes().any(|byte| byte.is_ascii_digit()) {
            return None;
        }
        Some(if number.is_finite() { number } else { f64::NAN })
    }
}

/// Returns true for text such as `1.#INF00` or `-1.#IND`, with which older C libraries print what is not finite.
fn is_not_finite(text: &[u8]) -> bool {
    let digits = text.strip_prefix(b"-").unwrap_or(text);
    [b"1.#INF".as_slice(), b"1.#IND", b"1.#QNAN", b"1.#SNAN"].iter().any(|printed| digits.starts_with(printed))
}

/// Returns true for a cell such as `1,234`: one to three digits without a leading zero, a comma, three digits.
pub(super) fn is_ambiguous(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    let digits = cell.strip_prefix(b"-").or_else(|| cell.strip_prefix(b"+")).unwrap_or(cell);
    let Some(comma) = digits.iter().position(|byte| *byte == b',') else { return false };
    let (whole, decimals) = digits.split_at(comma);
    let are_digits = |text: &[u8]| text.iter().all(u8::is_ascii_digit);
    (1..=3).contains(&whole.len())
        && !whole.starts_with(b"0")
        && are_digits(whole)
        && decimals.len() == 4
        && are_digits(&decimals[1..])
}
