use std::sync::Arc;

use ::parquet::basic::{Compression, GzipLevel, ZstdLevel};
use ::parquet::data_type::{BoolType, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::parser::parse_message_type;

use crate::recording::harness::{Trial, cut_short, damaged, error, recording, values};

const SCHEMA: &str = "message schema {
    REQUIRED DOUBLE x; OPTIONAL FLOAT y; REQUIRED INT32 small (INTEGER(32, false)); OPTIONAL INT64 large;
    REQUIRED BOOLEAN on; REQUIRED BYTE_ARRAY note (UTF8); REQUIRED INT64 day (TIMESTAMP(MICROS, true));
    REQUIRED group inner { REQUIRED DOUBLE z; } }";

/// Two row groups of 30 rows.
fn file(compression: Compression) -> Vec<u8> {
    let properties = WriterProperties::builder().set_compression(compression).build();
    let schema = Arc::new(parse_message_type(SCHEMA).unwrap());
    let mut out = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut out, schema, Arc::new(properties)).unwrap();
    for group in 0..2 {
        let rows = 30 * group..30 * group + 30;
        let mut columns = writer.next_row_group().unwrap();
        macro_rules! column {
            ($kind:ty, $values:expr, $levels:expr) => {
                let mut column = columns.next_column().unwrap().unwrap();
                column.typed::<$kind>().write_batch(&$values, $levels, None).unwrap();
                column.close().unwrap();
            };
        }
        let levels: Vec<i16> = rows.clone().map(|i| i16::from(i % 3 != 0)).collect();
        let there = rows.clone().filter(|i| i % 3 != 0);
        column!(DoubleType, rows.clone().map(|i| f64::from(i) * 0.1).collect::<Vec<_>>(), None);
        column!(FloatType, there.clone().map(|i| i as f32 * 0.1).collect::<Vec<_>>(), Some(&levels));
        column!(Int32Type, rows.clone().map(|i| -1 - i).collect::<Vec<_>>(), None);
        column!(Int64Type, there.map(i64::from).collect::<Vec<_>>(), Some(&levels));
        column!(BoolType, rows.clone().map(|i| i % 2 == 0).collect::<Vec<_>>(), None);
        column!(ByteArrayType, rows.clone().map(|_| "a note".into()).collect::<Vec<_>>(), None);
        column!(Int64Type, rows.clone().map(i64::from).collect::<Vec<_>>(), None);
        column!(DoubleType, rows.map(f64::from).collect::<Vec<_>>(), None);
        columns.close().unwrap();
    }
    writer.close().unwrap();
    out
}

fn compressions() -> [Compression; 5] {
    let gzip = Compression::GZIP(GzipLevel::default());
    [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        gzip,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::LZ4_RAW,
    ]
}

#[test]
fn numbers_are_exact_however_packed() {
    for compression in compressions() {
        let rows = values(&file(compression), &["on", "x", "small"]);
        assert_eq!(rows.len(), 60);
        for (row, i) in rows.iter().zip(0_u32..) {
            assert_eq!(*row, [f64::from(u8::from(i % 2 == 0)), f64::from(i) * 0.1, f64::from(u32::MAX - i)]);
        }
    }
}

#[test]
fn nulls_are_missing_readings() {
    let (rows, flaws) = Trial::new().read(&file(Compression::SNAPPY), &recording(&["y", "large"])).unwrap();
    for (row, i) in rows.iter().zip(0_u16..) {
        let number = |x: f64| if i % 3 == 0 { f64::NAN } else { x };
        let expected = [number(f64::from(f32::from(i) * 0.1)), number(f64::from(i))];
        assert!(row.probes.iter().zip(expected).all(|(own, x)| own.to_bits() == x.to_bits()), "{row:?}");
    }
    assert_eq!(flaws.iter().map(|flaw| flaw.samples_affected).collect::<Vec<_>>(), [20, 20]);
}

#[test]
fn named_text_that_is_no_number_is_rejected() {
    let refused = |column: &str| error(&file(Compression::SNAPPY), &recording(&[column]));
    assert!(
        refused("note")
            .starts_with(": unreadable file: `note`: is of type BYTE_ARRAY, expected a Parquet file with flat")
    );
    assert!(refused("inner").contains("`inner`: is nested"));
    assert!(refused("day").contains("`day`: is of type Timestamp"), "{}", refused("day"));
    assert!(refused("X").starts_with(": no such column: `X` (did you mean `x`?), expected one of `x`, `y`, `small`"));
}

#[test]
fn short_and_damaged_files() {
    cut_short(&file(Compression::UNCOMPRESSED), &["x"], &[]);
    for compression in compressions() {
        damaged(&file(compression), &["x", "y", "small", "large", "on"]);
    }
}
