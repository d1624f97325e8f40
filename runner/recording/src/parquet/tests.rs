use std::sync::Arc;

use ::parquet::basic::{Compression, GzipLevel, ZstdLevel};
use ::parquet::data_type::{
    BoolType, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type, Int96, Int96Type,
};
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::parser::parse_message_type;

use crate::harness::{Trial, cut_short, damaged, error, recording, values};
use ballrace_scene::{Clock, Recording};

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

/// A file with time stamps of this type at 1 kHz and a column `x`.
fn timed<T: DataType>(kind: &str, stamps: &[T::T]) -> Vec<u8> {
    let schema = format!("message schema {{ REQUIRED {kind}; REQUIRED DOUBLE x; }}");
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let mut out = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut out, schema, Arc::default()).unwrap();
    for stamps in stamps.chunks(100) {
        let mut columns = writer.next_row_group().unwrap();
        let mut column = columns.next_column().unwrap().unwrap();
        column.typed::<T>().write_batch(stamps, None, None).unwrap();
        column.close().unwrap();
        let mut column = columns.next_column().unwrap().unwrap();
        let x: Vec<f64> = (0..stamps.len()).map(|i| i as f64).collect();
        column.typed::<DoubleType>().write_batch(&x, None, None).unwrap();
        column.close().unwrap();
        columns.close().unwrap();
    }
    writer.close().unwrap();
    out
}

#[test]
fn timestamps() {
    let start = 1_795_687_872_000_000_123_i64;
    let nanoseconds: Vec<i64> = (0..300).map(|i| start + 1_000_000 * i).collect();
    let divided = |unit: i64| nanoseconds.iter().map(|stamp| stamp / unit).collect::<Vec<_>>();
    let wide = |stamp: &i64| {
        let (day, time) = (stamp.div_euclid(86_400_000_000_000), stamp.rem_euclid(86_400_000_000_000) as u64);
        let mut value = Int96::new();
        value.set_data(time as u32, (time >> 32) as u32, (day + 2_440_588) as u32);
        value
    };
    let wide: Vec<Int96> = nanoseconds.iter().map(wide).collect();
    let of = Recording { clock: Clock::column("t"), ..recording(&["x"]) };
    for file in [
        timed::<Int64Type>("INT64 t (TIMESTAMP(NANOS, true))", &nanoseconds),
        timed::<Int64Type>("INT64 t (TIMESTAMP(MICROS, false))", &divided(1000)),
        timed::<Int64Type>("INT64 t (TIMESTAMP(MILLIS, true))", &divided(1_000_000)),
        timed::<Int64Type>("INT64 t (TIMESTAMP_MICROS)", &divided(1000)),
        timed::<Int96Type>("INT96 t", &wide),
    ] {
        let (rows, flaws) = Trial::new().read(&file, &of).unwrap();
        assert!(rows.len() == 300 && flaws.is_empty(), "{flaws:?}");
        assert!(rows.iter().enumerate().all(|(i, row)| (row.time - i as f64 / 1e3).abs() < 1e-9), "{:?}", rows[299]);
    }
    // A plain number of another unit, such as a duration of pandas.
    let said = error(&timed::<Int64Type>("INT64 t", &nanoseconds), &of);
    assert!(
        said.contains("nanoseconds since 1970, expected seconds, or time = { column = \"t\", unit = \"ns\" }"),
        "{said}"
    );
    let unit = Recording { clock: Clock::Column { name: "t".into(), seconds: Some(1e-9) }, ..recording(&["x"]) };
    assert_eq!(Trial::new().read(&timed::<Int64Type>("INT64 t", &nanoseconds), &unit).unwrap().0.len(), 300);
}

#[test]
fn short_and_damaged_files() {
    cut_short(&file(Compression::UNCOMPRESSED), &["x"], &[]);
    for compression in compressions() {
        damaged(&file(compression), &["x", "y", "small", "large", "on"]);
    }
}
