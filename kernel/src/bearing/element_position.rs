//! Positions of the elements in the cage: any positions, or opposed pairs.

use crate::math::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Position of one element in the cage frame: its azimuth with the cage at angle 0, with cosine and sine.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
// The C interface reads positions from structs of C.
#[repr(C)]
pub struct ElementPosition<T> {
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) azimuth: Phase,
}

/// Positions of `N` elements.
///
/// The models take any `AsRef<[ElementPosition<T>]>`: this array, or a slice on the heap where the count is known only at
/// run time.
pub type ElementPositions<T, const N: usize> = [ElementPosition<T>; N];

/// Positions of `2 H` elements in opposed pairs: element `j + H` is opposite to element `j`.
///
/// A pair shares its computation: the directions differ by the sign, and without preload at most one of the two elements is
/// loaded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpposedPairs<T, const H: usize>(ElementPositions<T, H>);

impl<T: Scalar> ElementPosition<T> {
    /// Creates a position from its azimuth. For set-up: cosine and sine by `libm` in `f64`, rounded once.
    #[must_use]
    pub fn from_azimuth(azimuth: Phase) -> Self {
        let p = azimuth.radians();
        Self { cos: T::from_f64(libm::cos(p)), sin: T::from_f64(libm::sin(p)), azimuth }
    }

    /// Creates a position from precomputed constants: cosine and sine of the azimuth, and the azimuth. No arithmetic:
    /// firmware with constants in flash links no trigonometry.
    #[must_use]
    pub const fn from_constants(cos: T, sin: T, azimuth: Phase) -> Self {
        Self { cos, sin, azimuth }
    }

    /// Creates position `j` of `count` evenly spaced ones; position 0 is at `first`.
    #[must_use]
    pub fn evenly_spaced(first: Phase, j: usize, count: usize) -> Self {
        Self::from_azimuth(first.wrapping_add(Phase((((j as u128) << 64) / (count.max(1) as u128)) as u64)))
    }

    /// Returns the position in the frame rotated by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { cos: self.cos, sin: -self.sin, azimuth: self.azimuth.reversed() }
    }

    /// Returns cosine and sine of the azimuth.
    #[must_use]
    pub fn direction(&self) -> (T, T) {
        (self.cos, self.sin)
    }

    /// Returns the azimuth with the cage at angle 0.
    #[must_use]
    pub fn azimuth(&self) -> Phase {
        self.azimuth
    }

    /// Returns the position on the opposite side of the shaft.
    #[must_use]
    #[inline(always)]
    pub fn opposite(self) -> Self {
        Self { cos: -self.cos, sin: -self.sin, azimuth: self.azimuth.opposite() }
    }
}

/// Returns `N` evenly spaced positions, the first at `first`.
#[must_use]
pub fn evenly_spaced<T: Scalar, const N: usize>(first: Phase) -> ElementPositions<T, N> {
    core::array::from_fn(|j| ElementPosition::evenly_spaced(first, j, N))
}

/// Returns `2 H` evenly spaced positions in opposed pairs, the first at `first`.
#[must_use]
pub fn evenly_spaced_pairs<T: Scalar, const H: usize>(first: Phase) -> OpposedPairs<T, H> {
    OpposedPairs(core::array::from_fn(|j| ElementPosition::evenly_spaced(first, j, 2 * H)))
}

impl<T: Scalar, const H: usize> OpposedPairs<T, H> {
    /// Creates the pairs from one position of each.
    #[must_use]
    pub const fn new(half: ElementPositions<T, H>) -> Self {
        Self(half)
    }

    /// Returns the positions in the frame rotated by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self(self.0.map(ElementPosition::mirrored))
    }
}

/// Layout of the elements: implemented for slices, arrays and vectors of positions, and for [`OpposedPairs`].
pub trait ElementLayout<T: Scalar>: Send + Sync {
    /// True if each stored position represents a pair of opposed elements.
    const IS_PAIRED: bool;

    /// Returns the stored positions: all elements, or one of each pair.
    fn stored(&self) -> &[ElementPosition<T>];

    /// Returns block `index` of `BLOCK_SIZE` stored positions, or `None` past the end or with fewer positions than a block.
    ///
    /// The last block overlaps the one before where the count is no multiple of the block size.
    #[inline(always)]
    fn block(&self, index: usize) -> Option<ElementBlock<T, BLOCK_SIZE>> {
        let (stored, begin) = (self.stored(), index * BLOCK_SIZE);
        if begin >= stored.len() {
            return None;
        }
        let first = begin.min(stored.len().wrapping_sub(BLOCK_SIZE));
        let positions = stored.get(first..)?.first_chunk()?;
        Some(ElementBlock { first, overlap: begin - first, ..ElementBlock::of(positions) })
    }

    /// Returns all positions in order.
    #[inline(always)]
    fn all(&self) -> impl Iterator<Item = ElementPosition<T>> {
        let opposite = if Self::IS_PAIRED { self.stored() } else { &[] };
        self.stored().iter().copied().chain(opposite.iter().map(|position| position.opposite()))
    }
}

impl<T: Scalar, A: AsRef<[ElementPosition<T>]> + Send + Sync> ElementLayout<T> for A {
    const IS_PAIRED: bool = false;
    #[inline(always)]
    fn stored(&self) -> &[ElementPosition<T>] {
        self.as_ref()
    }
}

impl<T: Scalar, const H: usize> ElementLayout<T> for OpposedPairs<T, H> {
    const IS_PAIRED: bool = true;
    #[inline(always)]
    fn stored(&self) -> &[ElementPosition<T>] {
        &self.0
    }
}

/// Positions of `K` elements side by side.
#[derive(Debug, Clone, Copy)]
// SIMD loads stay within cache lines.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct ElementBlock<T, const K: usize> {
    pub(super) cos: Lanes<T, K>,
    pub(super) sin: Lanes<T, K>,
    pub(super) azimuths: [Phase; K],
    /// Index of the first of them.
    pub(super) first: usize,
    /// Number of them that the block before also contains.
    pub(super) overlap: usize,
}

impl<T: Scalar, const K: usize> ElementBlock<T, K> {
    #[inline(always)]
    pub(super) fn of(positions: &[ElementPosition<T>; K]) -> Self {
        let (cos, sin) =
            (Lanes::gather(positions, |position| position.cos), Lanes::gather(positions, |position| position.sin));
        Self { cos, sin, azimuths: positions.each_ref().map(|position| position.azimuth), first: 0, overlap: 0 }
    }
}

/// Positions that are also stored in SIMD blocks: same results, faster with [`super::tabulated`] on a desktop processor.
///
/// ```
/// use ballrace::Phase;
/// use ballrace::bearing::{ElementLayout, ElementPositions, BlockedPositions, evenly_spaced};
///
/// let nine: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
/// let kept = BlockedPositions::<_, Vec<_>>::new(nine);
/// assert_eq!(kept.stored(), nine);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BlockedPositions<P, G> {
    positions: P,
    blocks: G,
}

impl<P, G> BlockedPositions<P, G> {
    /// Creates the blocks. For set-up.
    pub fn new<T: Scalar>(positions: P) -> Self
    where
        P: ElementLayout<T>,
        G: FromIterator<ElementBlock<T, BLOCK_SIZE>>,
    {
        let blocks = (0..).map_while(|index| positions.block(index)).collect();
        Self { positions, blocks }
    }
}

impl<T: Scalar, P, G> ElementLayout<T> for BlockedPositions<P, G>
where
    P: ElementLayout<T>,
    G: AsRef<[ElementBlock<T, BLOCK_SIZE>]> + Send + Sync,
{
    const IS_PAIRED: bool = P::IS_PAIRED;
    #[inline(always)]
    fn stored(&self) -> &[ElementPosition<T>] {
        self.positions.stored()
    }
    #[inline(always)]
    fn block(&self, index: usize) -> Option<ElementBlock<T, BLOCK_SIZE>> {
        self.blocks.as_ref().get(index).copied()
    }
}

/// Number of elements that are evaluated side by side: four on 64-bit processors to use their parallel units, one on a
/// microcontroller.
pub const BLOCK_SIZE: usize = if cfg!(target_pointer_width = "64") { 4 } else { 1 };

/// Up to `K` positions, padded with the last one.
pub(super) struct PaddedGroup<T, const K: usize> {
    pub positions: [ElementPosition<T>; K],
    count: usize,
}

impl<T, const K: usize> PaddedGroup<T, K> {
    /// Returns the positions without padding.
    pub fn without_padding(&self) -> &[ElementPosition<T>] {
        self.positions.get(..self.count).unwrap_or_default()
    }
}

/// Returns the positions in groups of `K`.
pub(super) fn padded_groups<T: Scalar, P: ElementLayout<T>, const K: usize>(
    layout: &P,
) -> impl Iterator<Item = PaddedGroup<T, K>> {
    let (mut complete, mut each) = (layout.stored().chunks_exact(K), layout.all());
    let is_copied = K > 1 && !P::IS_PAIRED;
    core::iter::from_fn(
        #[inline(always)]
        move || {
            if is_copied && let Some(group) = complete.next() {
                each.nth(K - 1)?;
                return Some(PaddedGroup { positions: *group.first_chunk()?, count: K });
            }
            let first = each.next()?;
            let mut group = PaddedGroup { positions: [first; K], count: 1 };
            let mut last = first;
            for position in group.positions.iter_mut().skip(1) {
                if let Some(next) = each.next() {
                    last = next;
                    group.count += 1;
                }
                *position = last;
            }
            Some(group)
        },
    )
}
