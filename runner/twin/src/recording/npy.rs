//! NPY files as recordings: the columns of an array, `c0`, `c1`, ..., or the fields of its structure by their names.

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, Seek};
use std::path::Path;

use super::error::RecordingError;
use super::numbers::{Kind, Lane, Layout, Number, Numbers, Run};
use super::table::Table;
use crate::npy_header::{ElementType, Field, NpyHeader, PlainType};
use crate::scene::FileLayout;

const EXPECTED: &str = "an NPY file of one row for each sample, of integers or of floats with 32 or 64 bits";

/// Largest number of columns.
const MOST: u64 = 1 << 16;

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path, _layout: FileLayout) -> Result<Box<dyn Table>, RecordingError> {
    let layout = read(&mut file).map_err(|cause| {
        let found = match cause.kind() {
            io::ErrorKind::UnexpectedEof => "a header that is cut short".into(),
            _ => cause.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
        };
        RecordingError::Format { file: path.into(), found, expected: EXPECTED }
    })?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

fn read(file: &mut File) -> io::Result<Layout> {
    let header = NpyHeader::read(file)?;
    let start = file.stream_position()?;
    let (rows, columns) = match header.shape.as_slice() {
        [rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        other => return Err(io::Error::other(format!("an array of {} dimensions", other.len()))),
    };
    let lanes = match header.element {
        ElementType::Structure(fields) if header.shape.len() == 1 => structure(fields, start, rows)?,
        ElementType::Structure(fields) => {
            return Err(io::Error::other(format!("{columns} columns of structures of {} fields", fields.len())));
        }
        ElementType::Plain(kind) if columns > MOST => {
            return Err(io::Error::other(format!("{columns} columns of type {}", kind.text)));
        }
        ElementType::Plain(kind) => {
            let number = number(&kind).ok_or_else(|| io::Error::other(format!("numbers of type {}", kind.text)))?;
            array(number, start, [rows, columns], header.is_fortran)
        }
    };
    Ok(Layout { lanes, torn: false, expected: EXPECTED })
}

fn number(kind: &PlainType) -> Option<Number> {
    let bytes = u8::try_from(kind.bytes?).ok()?;
    let kind_of = match (kind.kind, bytes) {
        ('f', 4 | 8) => Kind::Float,
        ('i', 1 | 2 | 4 | 8) => Kind::Signed,
        ('u', 1 | 2 | 4 | 8) | ('b', 1) => Kind::Unsigned,
        _ => return None,
    };
    Some(Number::new(kind_of, bytes, kind.is_big_endian))
}

fn array(number: Number, start: u64, [rows, columns]: [u64; 2], is_fortran: bool) -> Vec<Lane> {
    let size = u64::from(number.bytes);
    // The product of a hostile shape saturates, and the comparison with the length of the file rejects it.
    let [first, stride] =
        if is_fortran { [rows.saturating_mul(size), size] } else { [size, columns.saturating_mul(size)] };
    let run = |column: u64| Run::once(number, start.saturating_add(column.saturating_mul(first)), stride, rows);
    (0..columns).map(|column| Lane::even(format!("c{column}"), run(column))).collect()
}

fn structure(fields: Vec<Field>, start: u64, rows: u64) -> io::Result<Vec<Lane>> {
    let size = |field: &Field| field.shape.iter().try_fold(field.plain.bytes?, |size, n| size.checked_mul(*n));
    let sizes: Option<Vec<u64>> = fields.iter().map(size).collect();
    let width = sizes.as_ref().and_then(|sizes| sizes.iter().try_fold(0_u64, |sum, size| sum.checked_add(*size)));
    let (Some(sizes), Some(width)) = (sizes, width) else {
        return Err(io::Error::other("fields without a size"));
    };
    let mut at = start;
    let mut lanes = Vec::new();
    for (Field { name, plain, shape }, size) in fields.into_iter().zip(sizes) {
        let own = if shape.is_empty() { number(&plain) } else { None };
        let kind = if shape.is_empty() { format!("type {}", plain.text) } else { "arrays".to_owned() };
        let refused = own.is_none().then(|| format!("is of {kind}"));
        let runs = own.map(|number| Run::once(number, at, width, rows)).into_iter().collect();
        lanes.push(Lane { name, unit: None, rate: None, runs, refused });
        at = at.saturating_add(size);
    }
    Ok(lanes)
}
