//! The bearings of `tests/target/c/every_model.toml` from a blob in flash: its check and their checksums in parts, as a device with a watchdog
//! computes them.

use ballrace::Exact;
use ballrace::bearing::angular::Angular;
use ballrace::bearing::checksum::Checksum;
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::tabulated::{Node, Tabulated};
use ballrace::bearing::{Bearing, ElementPosition, Mirrored};
use ballrace::blob::{Aligned, Blob, BlobCheck, FromBlob, InvalidBlob};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use core::fmt;

/// The blob, as it would lie in a page of flash.
pub static BLOB: Aligned<{ include_bytes!("../../c/every_model.blob").len() }> =
    Aligned(*include_bytes!("../../c/every_model.blob"));

type Elements = &'static [ElementPosition<f32>];
type RadialElements<L> = Radial<f32, Exact, L, Elements>;
type Both<L> = Combined<RadialElements<L>, Axial<f32, Exact, L, Elements>>;
type Table<const F: usize> = Tabulated<f32, Exact, Elements, &'static [Node<f32, F>], F>;

/// Bytes and forces between two resets of the watchdog.
const PART: u16 = 100;

/// Name of a bearing, its checksum, and the one that the blob states.
pub struct Row(&'static str, Result<[u64; 2], InvalidBlob>);

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.1 {
            Ok([computed, stated]) => write!(f, "{},{computed:#018x},{stated:#018x}", self.0),
            Err(reason) => write!(f, "{},{reason}", self.0),
        }
    }
}

/// Returns the blob after its check in parts.
pub fn checked(bytes: &[u8]) -> Result<Blob<'_>, InvalidBlob> {
    let mut check = BlobCheck::default();
    loop {
        if let Some(blob) = check.advance(bytes, usize::from(PART)) {
            return blob;
        }
    }
}

/// Passes the row of every bearing to `print`.
pub fn run(print: impl Fn(Row)) -> Result<(), InvalidBlob> {
    let blob = checked(&BLOB.0)?;
    print(row::<RadialElements<PointContactLaw<f32>>>(&blob, "radial"));
    print(row::<Both<PowerLaw<f32>>>(&blob, "mixed"));
    print(row::<Mirrored<Both<LineContactLaw<f32>>>>(&blob, "lines"));
    print(row::<Mirrored<Angular<f32, Exact, Elements>>>(&blob, "angular"));
    print(row::<Linear<f32>>(&blob, "springs"));
    print(row::<Mirrored<Table<3>>>(&blob, "friction"));
    print(row::<Table<2>>(&blob, "balls"));
    // Another model and another name.
    print(row::<Table<3>>(&blob, "balls"));
    print(row::<Table<2>>(&blob, "ball"));
    Ok(())
}

fn row<B: Bearing<f32> + FromBlob<'static>>(blob: &Blob<'static>, name: &'static str) -> Row {
    Row(name, checksums::<B>(blob, name))
}

fn checksums<B: Bearing<f32> + FromBlob<'static>>(blob: &Blob<'static>, name: &str) -> Result<[u64; 2], InvalidBlob> {
    let record = blob.bearing(name)?;
    let bearing: B = record.bearing()?;
    let mut checksum = Checksum::begin(&record.checksum_range());
    loop {
        if let Some(computed) = checksum.advance(&bearing, PART) {
            return Ok([computed, record.checksum()]);
        }
    }
}
