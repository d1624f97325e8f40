//! NPY files as recordings: the columns of an array, `c0`, `c1`, ..., or the fields of its structure by their names.

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};

use super::error::RecordingError;
use super::numbers::{Kind, Lane, Layout, Number, Numbers, Run};
use super::table::Table;

const ALLOWED: &str = "an NPY file of one row for each sample, of integers or of floats with 32 or 64 bits";

/// Longest header; one of a thousand fields takes a tenth.
const LONGEST_HEADER: u64 = 1 << 18;
/// Deepest nesting of a header: the list of a structure has tuples of tuples. The parser needs exponential time beyond it.
const DEEPEST: usize = 4;
/// Largest number of columns.
const MOST: u64 = 1 << 16;

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let layout = read(&mut file).map_err(|cause| {
        let found = match cause.kind() {
            io::ErrorKind::UnexpectedEof => "a header that is cut short".into(),
            _ => cause.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
        };
        RecordingError::Format { file: path.into(), found, allowed: ALLOWED }
    })?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

fn read(file: &mut File) -> io::Result<Layout> {
    let text = header(file)?;
    let header = NpyHeader::from_reader(text.as_slice())?;
    let start = file.stream_position()?;
    let (rows, columns) = match header.shape() {
        [rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        other => return Err(io::Error::other(format!("an array of {} dimensions", other.len()))),
    };
    let lanes = match header.dtype() {
        DType::Record(fields) if columns == 1 && header.shape().len() == 1 => {
            let fields = fields.into_iter().map(|field| (field.name, field.dtype)).collect();
            structure(fields, start, rows)?
        }
        DType::Plain(kind) if columns <= MOST => {
            let number = number(&kind).ok_or_else(|| io::Error::other(format!("numbers of type {kind}")))?;
            array(number, start, [rows, columns], header.order())
        }
        other => return Err(io::Error::other(format!("{columns} columns of {}", described(&other)))),
    };
    Ok(Layout { lanes, torn: false, allowed: ALLOWED })
}

/// The bytes before the numbers, short and simple enough for the parser.
fn header(file: &mut File) -> io::Result<Vec<u8>> {
    let mut text = vec![0; 10];
    file.read_exact(&mut text)?;
    if !text.starts_with(b"\x93NUMPY") {
        return Err(io::Error::other("no NPY file"));
    }
    let mut length = u64::from(u16::from_le_bytes([text[8], text[9]]));
    if text[6] > 1 {
        let mut high = [0; 2];
        file.read_exact(&mut high)?;
        text.extend(high);
        length += u64::from(u16::from_le_bytes(high)) << 16;
    }
    if length > LONGEST_HEADER {
        return Err(io::Error::other(format!("a header of {length} bytes")));
    }
    let before = text.len() as u64;
    file.take(length).read_to_end(&mut text)?;
    if (text.len() as u64) < before + length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let (mut depth, mut deepest) = (0_usize, 0);
    for byte in &text {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    if deepest > DEEPEST {
        return Err(io::Error::other("a structure within a structure"));
    }
    Ok(text)
}

fn number(kind: &npyz::TypeStr) -> Option<Number> {
    let bytes = u8::try_from(kind.size_field()).ok()?;
    let kind_of = match (kind.type_char(), bytes) {
        (TypeChar::Float, 4 | 8) => Kind::Float,
        (TypeChar::Int, 1 | 2 | 4 | 8) => Kind::Signed,
        (TypeChar::Uint, 1 | 2 | 4 | 8) | (TypeChar::Bool, 1) => Kind::Unsigned,
        _ => return None,
    };
    Some(Number::new(kind_of, bytes, kind.endianness() == Endianness::Big))
}

fn described(kind: &DType) -> String {
    match kind {
        DType::Plain(plain) => format!("type {plain}"),
        DType::Array(..) => "arrays".into(),
        DType::Record(fields) => format!("structures of {} fields", fields.len()),
    }
}

fn array(number: Number, start: u64, [rows, columns]: [u64; 2], order: Order) -> Vec<Lane> {
    let size = u64::from(number.bytes);
    // The product of a hostile shape saturates, and the comparison with the length of the file rejects it.
    let [first, stride] = match order {
        Order::C => [size, columns.saturating_mul(size)],
        Order::Fortran => [rows.saturating_mul(size), size],
    };
    let run = |column: u64| Run::once(number, start.saturating_add(column.saturating_mul(first)), stride, rows);
    (0..columns).map(|column| Lane::even(format!("c{column}"), run(column))).collect()
}

fn structure(fields: Vec<(String, DType)>, start: u64, rows: u64) -> io::Result<Vec<Lane>> {
    let sizes = fields.iter().map(|(_, kind)| kind.num_bytes().and_then(|size| u64::try_from(size).ok()));
    let sizes: Option<Vec<u64>> = sizes.collect();
    let width = sizes.as_ref().and_then(|sizes| sizes.iter().try_fold(0_u64, |sum, size| sum.checked_add(*size)));
    let (Some(sizes), Some(width)) = (sizes, width) else {
        return Err(io::Error::other("fields without a size"));
    };
    let mut at = start;
    let mut lanes = Vec::new();
    for ((name, kind), size) in fields.into_iter().zip(sizes) {
        let own = if let DType::Plain(plain) = &kind { number(plain) } else { None };
        let refused = own.is_none().then(|| format!("is of {}", described(&kind)));
        let runs = own.map(|number| Run::once(number, at, width, rows)).into_iter().collect();
        lanes.push(Lane { name, unit: None, rate: None, runs, refused });
        at = at.saturating_add(size);
    }
    Ok(lanes)
}
