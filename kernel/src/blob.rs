//! Bearings from a binary file: `ballrace bake SCENE -o F.blob` writes it, firmware checks it and uses it in place.
//!
//! A blob has the constants of the bearings of a scene, so that a device takes those of another machine without a new image. Its
//! elements, tables and laminae stay where the blob is; the other constants of a bearing are read once.
//! The bits of the forces are those of the constants that `bake` writes in C.
//!
//! A CRC-32 tells damage, not intent: a device that takes parameters over the air leaves their signature to its bootloader.
//!
//! # Layout
//!
//! Little-endian, aligned to 8 bytes.
//!
//! | bytes | content |
//! | --- | --- |
//! | 0 to 3 | `BRBL` |
//! | 4, 5 | version of the layout, [`VERSION`] |
//! | 6, 7 | number of bearings |
//! | 8 to 11 | length of the blob, bytes, a multiple of 8 |
//! | 12 to 15 | 0 |
//! | from 16 | the bearings |
//! | last 8 | 0, and the CRC-32 of all bytes before it |
//!
//! | bytes of a bearing | content |
//! | --- | --- |
//! | 0 to 3 | length, bytes, a multiple of 8 |
//! | 4 to 7 | model: [`FromBlob::CODE`] |
//! | 8 to 19 | numbers of elements, of numbers in the table, and of the other constants |
//! | 20 to 23 | station along Z from the rotor's centre of mass, m |
//! | 24 to 47 | name in UTF-8, filled with 0 |
//! | 48 to 71 | angle of cage, ball and outer ring over that of the shaft, `f64` |
//! | 72 to 79 | checksum of 1024 forces |
//! | 80 to 155 | displacement by preload; range of the checksum: centre, amplitude, speeds |
//! | from 160 | elements of 16 bytes, table, other constants in the order of the C struct, all of 4 bytes |
// Tables are read in place.
#![allow(unsafe_code)]

use crate::bearing::angular::{Angular, AngularConstants};
use crate::bearing::checksum::ChecksumRange;
use crate::bearing::linear::Linear;
use crate::bearing::lumped::{Axial, Combined, Radial};
use crate::bearing::quasi_static::TableConstants;
use crate::bearing::roller::{Lamina, LaminaRoller, RollerConstants};
use crate::bearing::tabulated::{Axis, Grid, Node, Table, Tabulated};
use crate::bearing::{ElementPosition, Mirrored};
use crate::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use crate::log::continued_crc32;
use crate::{Displacement, Exact, Stiffness, Wrench};
use core::fmt;

/// First bytes of a blob.
pub const MAGIC: [u8; 4] = *b"BRBL";
/// Version of the layout.
pub const VERSION: u16 = 1;
/// Alignment, bytes.
pub const ALIGNMENT: usize = 8;
/// Length before the first bearing, bytes.
pub const HEADER: usize = 16;
/// Length after the last bearing, bytes.
pub const TRAILER: usize = 8;
/// Length of a bearing before its elements, bytes.
pub const BEARING_HEADER: usize = 160;
/// Longest name of a bearing, bytes.
pub const LONGEST_NAME: usize = 24;
/// Bit of [`FromBlob::CODE`] of a bearing that carries thrust towards -Z.
pub const MIRRORED: u32 = 0x100;

/// Reason why a blob is of no use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InvalidBlob {
    /// The address is no multiple of 8.
    NotAligned,
    /// The bytes do not begin as a blob.
    NotABlob,
    /// The layout has this version instead of [`VERSION`].
    Version(u16),
    /// The blob is longer than the bytes, or shorter than its bearings: this length.
    Length(u32),
    /// The CRC-32 is another one: the blob is damaged.
    Checksum,
    /// No bearing has this name.
    NoBearing,
    /// The bearing has the model of this code.
    Model(u32),
}

impl fmt::Display for InvalidBlob {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAligned => write!(f, "blob at an address that is no multiple of {ALIGNMENT}"),
            Self::NotABlob => f.write_str("no blob: other first bytes than BRBL"),
            Self::Version(found) => write!(f, "layout of version {found}, expected {VERSION}"),
            Self::Length(found) => write!(f, "length of {found} bytes does not fit"),
            Self::Checksum => f.write_str("damaged: another CRC-32"),
            Self::NoBearing => f.write_str("no bearing of this name"),
            Self::Model(found) => write!(f, "bearing of another model: code {found:#x}"),
        }
    }
}

impl core::error::Error for InvalidBlob {}

/// Bytes at an aligned address, for a blob that is part of the image: `Aligned(*include_bytes!("F.blob"))`.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(8))]
pub struct Aligned<const N: usize>(pub [u8; N]);

/// A blob whose CRC-32 is right.
///
/// ```
/// use ballrace::blob::{Blob, InvalidBlob};
///
/// assert_eq!(Blob::try_new(&[]).err(), Some(InvalidBlob::NotABlob));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Blob<'a> {
    bearings: &'a [u8],
}

impl<'a> Blob<'a> {
    /// Checks a blob at the beginning of `bytes`. Cost: linear in its length; [`BlobCheck`] takes it in parts.
    ///
    /// # Errors
    /// A reason that is no missing bearing or model.
    pub fn try_new(bytes: &'a [u8]) -> Result<Self, InvalidBlob> {
        BlobCheck::default().advance(bytes, bytes.len()).unwrap_or(Err(InvalidBlob::Checksum))
    }

    /// Takes a blob without its CRC-32, which an earlier call has checked.
    ///
    /// # Errors
    /// A reason that shows in the first bytes.
    pub fn checked_before(bytes: &'a [u8]) -> Result<Self, InvalidBlob> {
        let (content, _) = parts(bytes)?;
        Ok(Self { bearings: content.get(HEADER..).unwrap_or_default() })
    }

    /// Returns the bearing of this name.
    ///
    /// # Errors
    /// [`InvalidBlob::NoBearing`]
    pub fn bearing(&self, name: &str) -> Result<BlobBearing<'a>, InvalidBlob> {
        self.bearings().find(|bearing| bearing.name() == name.as_bytes()).ok_or(InvalidBlob::NoBearing)
    }

    /// Returns the bearings in the order of the scene.
    pub fn bearings(&self) -> impl Iterator<Item = BlobBearing<'a>> + use<'a> {
        let mut rest = self.bearings;
        core::iter::from_fn(move || {
            let length = usize::try_from(word(rest, 0)?).ok()?;
            let (bearing, after) = rest.split_at_checked(length)?;
            rest = after;
            BlobBearing::of(bearing)
        })
    }
}

/// State of a check in parts, so that firmware resets its watchdog between them.
///
/// ```
/// use ballrace::blob::{Blob, BlobCheck, InvalidBlob};
///
/// fn check(bytes: &[u8]) -> Result<Blob<'_>, InvalidBlob> {
///     let mut check = BlobCheck::default();
///     loop {
///         if let Some(blob) = check.advance(bytes, 256) {
///             return blob;
///         }
///         // Reset the watchdog here.
///     }
/// }
/// assert_eq!(check(b"no blob").err(), Some(InvalidBlob::NotABlob));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlobCheck {
    /// Number of checked bytes.
    pub checked: u32,
    /// Their CRC-32.
    pub crc: u32,
}

impl BlobCheck {
    /// Checks further bytes, `count` or the rest, of a blob at the beginning of `bytes`, the same in every call. Returns the blob or the
    /// reason at the end.
    pub fn advance<'a>(&mut self, bytes: &'a [u8], count: usize) -> Option<Result<Blob<'a>, InvalidBlob>> {
        let (content, expected) = match parts(bytes) {
            Ok(parts) => parts,
            Err(reason) => return Some(Err(reason)),
        };
        let rest = content.get(self.checked as usize..).unwrap_or_default();
        let part = rest.get(..count).unwrap_or(rest);
        self.crc = continued_crc32(self.crc, part);
        self.checked = self.checked.saturating_add(part.len() as u32);
        if part.len() < rest.len() {
            return None;
        }
        let bearings = content.get(HEADER..).unwrap_or_default();
        Some(if self.crc == expected { Ok(Blob { bearings }) } else { Err(InvalidBlob::Checksum) })
    }
}

/// Returns the bytes before the CRC-32 of a blob, and the CRC-32 that it states.
fn parts(bytes: &[u8]) -> Result<(&[u8], u32), InvalidBlob> {
    if !bytes.starts_with(&MAGIC) {
        return Err(InvalidBlob::NotABlob);
    }
    if !bytes.as_ptr().addr().is_multiple_of(ALIGNMENT) {
        return Err(InvalidBlob::NotAligned);
    }
    let version = word(bytes, 4).unwrap_or(0) as u16;
    if version != VERSION {
        return Err(InvalidBlob::Version(version));
    }
    let length = word(bytes, 8).unwrap_or(0);
    let blob = bytes.get(..length as usize).filter(|blob| blob.len() >= HEADER + TRAILER);
    let (content, crc) = blob.and_then(<[u8]>::split_last_chunk).ok_or(InvalidBlob::Length(length))?;
    Ok((content, u32::from_le_bytes(*crc)))
}

/// One bearing of a blob.
#[derive(Debug, Clone, Copy)]
pub struct BlobBearing<'a> {
    header: &'a [u8; BEARING_HEADER],
    elements: &'a [ElementPosition<f32>],
    table: &'a [u8],
    constants: &'a [u8],
}

/// Numbers of four bytes at which any bits are valid, and arrays of them.
///
/// # Safety
/// Any bytes at an address that is a multiple of 8 are a valid value.
unsafe trait Plain {}

// SAFETY: numbers without invalid bits, in `repr(C)` without padding.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for ElementPosition<f32> {}
// SAFETY: as above.
unsafe impl Plain for Lamina<f32> {}

/// Returns the values that bytes contain; none where their address is not aligned.
fn values<T: Plain>(bytes: &[u8]) -> &[T] {
    if !bytes.as_ptr().addr().is_multiple_of(align_of::<T>()) {
        return &[];
    }
    // SAFETY: the bytes have the length and the alignment of these values, for which any bits are valid.
    unsafe { core::slice::from_raw_parts(bytes.as_ptr().cast(), bytes.len() / size_of::<T>()) }
}

/// Returns the number of four bytes at an offset.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}

impl<'a> BlobBearing<'a> {
    /// Returns the bearing in the bytes that its length includes.
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let (header, rest) = bytes.split_first_chunk()?;
        let elements = usize::try_from(word(header, 8)?).ok()?.checked_mul(size_of::<ElementPosition<f32>>())?;
        let (elements, rest) = rest.split_at_checked(elements)?;
        let numbers = |offset| usize::try_from(word(header, offset)?).ok()?.checked_mul(4);
        let (table, rest) = rest.split_at_checked(numbers(12)?)?;
        let constants = rest.get(..numbers(16)?)?;
        Some(Self { header, elements: values(elements), table, constants })
    }

    /// Returns the name in UTF-8.
    #[must_use]
    pub fn name(&self) -> &'a [u8] {
        let name = self.header.get(24..24 + LONGEST_NAME).unwrap_or_default();
        let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
        name.get(..end).unwrap_or_default()
    }

    /// Returns the code of its model.
    #[must_use]
    pub fn code(&self) -> u32 {
        word(self.header, 4).unwrap_or(0)
    }

    /// Returns the elements.
    #[must_use]
    pub fn elements(&self) -> &'a [ElementPosition<f32>] {
        self.elements
    }

    /// Returns the table: nodes of a tabulated bearing, position and drop of the laminae of rollers, else nothing.
    #[must_use]
    pub fn table(&self) -> &'a [f32] {
        values(self.table)
    }

    /// Returns the other constants, 4 bytes each.
    #[must_use]
    pub fn constants(&self) -> &'a [u8] {
        self.constants
    }

    /// Returns the station along Z from the rotor's centre of mass, m.
    #[must_use]
    pub fn station(&self) -> f32 {
        self.single(20)
    }

    /// Returns the angles of cage, ball and outer ring over that of the shaft.
    #[must_use]
    pub fn ratios(&self) -> [f64; 3] {
        core::array::from_fn(|i| {
            let ratio = self.header.get(48 + 8 * i..).and_then(<[u8]>::first_chunk);
            ratio.map_or(0.0, |ratio| f64::from_le_bytes(*ratio))
        })
    }

    /// Returns the displacement by preload, to be added to every displacement.
    #[must_use]
    pub fn offset(&self) -> Displacement<f32> {
        self.displacement(80)
    }

    /// Returns the displacements and speeds of [`BlobBearing::checksum`].
    #[must_use]
    pub fn checksum_range(&self) -> ChecksumRange {
        ChecksumRange {
            centre: self.displacement(100),
            amplitude: self.displacement(120),
            inner_speed: [self.single(140), self.single(144)],
            outer_speed: [self.single(148), self.single(152)],
        }
    }

    /// Returns the checksum of 1024 forces that the desktop computed: that of [`ChecksumRange::checksum`] on every target.
    #[must_use]
    pub fn checksum(&self) -> u64 {
        self.header.get(72..).and_then(<[u8]>::first_chunk).map_or(0, |checksum| u64::from_le_bytes(*checksum))
    }

    /// Returns the bearing.
    ///
    /// # Errors
    /// [`InvalidBlob::Model`] for another model, [`InvalidBlob::Length`] where constants are missing.
    pub fn bearing<B: FromBlob<'a>>(&self) -> Result<B, InvalidBlob> {
        if self.code() != B::CODE {
            return Err(InvalidBlob::Model(self.code()));
        }
        let mut constants = ConstantReader(self.constants);
        B::read(self, &mut constants).ok_or(InvalidBlob::Length(word(self.header, 0).unwrap_or(0)))
    }

    fn single(&self, offset: usize) -> f32 {
        f32::from_bits(word(self.header, offset).unwrap_or(0))
    }

    fn displacement(&self, offset: usize) -> Displacement<f32> {
        Displacement::from_array(core::array::from_fn(|i| self.single(offset + 4 * i)))
    }
}

/// Reads constants one after the other.
#[derive(Debug)]
pub struct ConstantReader<'a>(&'a [u8]);

impl ConstantReader<'_> {
    /// Returns the next constant as an integer.
    fn integer(&mut self) -> Option<u32> {
        let (next, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*next))
    }

    fn number(&mut self) -> Option<f32> {
        self.integer().map(f32::from_bits)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    fn axis(&mut self) -> Option<Axis<f32>> {
        let count = usize::try_from(self.integer()?).ok()?;
        let [origin, density, least, greatest] = self.numbers()?;
        Some(Axis { count, origin, density, range: [least, greatest] })
    }
}

/// A bearing that a blob contains, with its elements in the blob.
pub trait FromBlob<'a>: Sized {
    /// Code of the model.
    const CODE: u32;

    /// Returns the bearing; none where constants are missing.
    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self>;
}

/// A load-deflection law of a blob, with its stiffness and exponent.
pub trait BlobLaw: LoadDeflectionLaw<f32, Exact> {
    /// Part of the code of a model.
    const CODE: u32;

    /// Creates the law; one of a fixed exponent ignores it.
    fn new(stiffness: f32, exponent: f32) -> Self;
}

impl BlobLaw for PointContactLaw<f32> {
    const CODE: u32 = 1;
    #[inline(always)]
    fn new(stiffness: f32, _exponent: f32) -> Self {
        Self { stiffness }
    }
}

impl BlobLaw for LineContactLaw<f32> {
    const CODE: u32 = 2;
    #[inline(always)]
    fn new(stiffness: f32, _exponent: f32) -> Self {
        Self { stiffness }
    }
}

impl BlobLaw for PowerLaw<f32> {
    const CODE: u32 = 3;
    #[inline(always)]
    fn new(stiffness: f32, exponent: f32) -> Self {
        Self { stiffness, exponent }
    }
}

type Elements<'a> = &'a [ElementPosition<f32>];

impl<'a> FromBlob<'a> for Linear<f32> {
    const CODE: u32 = 0x10;

    fn read(_: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let stiffness: [f32; 25] = constants.numbers()?;
        let (reference, force) = (constants.numbers()?, constants.numbers()?);
        let entry = |i: usize, j: usize| stiffness.get(5 * i + j).copied().unwrap_or(0.0);
        let columns: [[f32; 5]; 5] = core::array::from_fn(|j| core::array::from_fn(|i| entry(i, j)));
        let stiffness = Stiffness::from(columns);
        Some(Self::about(stiffness, Displacement::from_array(reference), Wrench::from_array(force)))
    }
}

impl<'a, L: BlobLaw> FromBlob<'a> for Radial<f32, Exact, L, Elements<'a>> {
    const CODE: u32 = 0x20 + L::CODE;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let [stiffness, exponent, play] = constants.numbers()?;
        Some(Self::from_constants(bearing.elements, L::new(stiffness, exponent), play))
    }
}

/// Radial elements, then axial ones with the same law.
impl<'a, L: BlobLaw> FromBlob<'a>
    for Combined<Radial<f32, Exact, L, Elements<'a>>, Axial<f32, Exact, L, Elements<'a>>>
{
    const CODE: u32 = 0x30 + L::CODE;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let radial = FromBlob::read(bearing, constants)?;
        let [stiffness, exponent, play, radius] = constants.numbers()?;
        let axial = Axial::from_constants(bearing.elements, L::new(stiffness, exponent), play, radius);
        Some(Self(radial, axial))
    }
}

impl<'a> FromBlob<'a> for Angular<f32, Exact, Elements<'a>> {
    const CODE: u32 = 0x40;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let [stiffness, distance, squared, radial, axial, excess, arm] = constants.numbers()?;
        let (distance, unloaded) = ([distance, squared], [radial, axial]);
        Some(Self::from_constants(bearing.elements, AngularConstants { stiffness, distance, unloaded, excess, arm }))
    }
}

/// `F` numbers a node.
impl<'a, const F: usize> FromBlob<'a> for Tabulated<f32, Exact, Elements<'a>, &'a [Node<f32, F>], F> {
    const CODE: u32 = 0x50 + F as u32;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let [couple, distance, cos, sin, offset, arm] = constants.numbers()?;
        let [scale, speed_scale] = constants.numbers()?;
        let (approach, angle, speed) = (constants.axis()?, constants.axis()?, constants.axis()?);
        let by_outer = constants.integer()? != 0;
        let (nodes, _) = bearing.table().as_chunks();
        let count = approach.count.checked_mul(angle.count)?.checked_mul(speed.count)?;
        if constants.integer()? as usize != nodes.len() || nodes.len() != count {
            return None;
        }
        let grid = Grid { scale, speed_scale, approach, angle, speed };
        let others = TableConstants { couple, distance, axis: [cos, sin], offset, arm };
        Some(Self::new(bearing.elements, others, Table::new(grid, nodes), by_outer))
    }
}

impl<'a> FromBlob<'a> for LaminaRoller<f32, Exact, Elements<'a>, &'a [Lamina<f32>]> {
    const CODE: u32 = 0x60;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        let [stiffness, arm, cos, sin, play] = constants.numbers()?;
        let laminae: &[Lamina<f32>] = values(bearing.table);
        if constants.integer()? as usize != laminae.len() {
            return None;
        }
        let others = RollerConstants { stiffness, arm, axis: [cos, sin], play };
        Some(Self::from_constants(bearing.elements, others, laminae))
    }
}

impl<'a, B: FromBlob<'a>> FromBlob<'a> for Mirrored<B> {
    const CODE: u32 = B::CODE | MIRRORED;

    fn read(bearing: &BlobBearing<'a>, constants: &mut ConstantReader<'a>) -> Option<Self> {
        B::read(bearing, constants).map(Self)
    }
}
