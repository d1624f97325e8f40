//! Where the elements stand in the cage: any positions, or opposite pairs.

use crate::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// One element's position in the cage's frame: where it is when the cage is at angle 0, ready for the hot path.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ElementPosition<T> {
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) azimuth: Phase,
}

/// The positions of `N` elements; the count is a constant of the type.
///
/// The bearings take any `AsRef<[ElementPosition<T>]>`: an array here, a heap slice where the count is only overlap at run time.
pub type ElementPositions<T, const N: usize> = [ElementPosition<T>; N];

/// The positions of `H` elements and of those opposite to them, `2 H` in all.
///
/// What opposite elements have in common is computed once: their directions differ by the sign, and where there is
/// no preload at most one of the two is loaded. Element `j` and `j + H` stand opposite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpposedPairs<T, const H: usize>(ElementPositions<T, H>);

impl<T: Scalar> ElementPosition<T> {
    /// At an azimuth. Tables by `libm` in `f64`, rounded once. Set-up time.
    #[must_use]
    pub fn from_azimuth(azimuth: Phase) -> Self {
        let p = azimuth.radians();
        Self { cos: T::from_f64(libm::cos(p)), sin: T::from_f64(libm::sin(p)), azimuth }
    }

    /// From numbers made ready elsewhere: cosine and sine of the azimuth. No arithmetic, so that firmware with constants
    /// in flash links none of what [`ElementPosition::from_azimuth`] needs.
    #[must_use]
    pub const fn from_constants(cos: T, sin: T, azimuth: Phase) -> Self {
        Self { cos, sin, azimuth }
    }

    /// Number `j` of `count` evenly spaced ones, number 0 at `first`.
    #[must_use]
    pub fn evenly_spaced(first: Phase, j: usize, count: usize) -> Self {
        Self::from_azimuth(first.wrapping_add(Phase((((j as u128) << 64) / (count.max(1) as u128)) as u64)))
    }

    /// Seen from the frame turned by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { cos: self.cos, sin: -self.sin, azimuth: self.azimuth.reversed() }
    }

    /// Cosine and sine of the azimuth.
    #[must_use]
    pub fn direction(&self) -> (T, T) {
        (self.cos, self.sin)
    }

    /// Azimuth with the cage at angle 0.
    #[must_use]
    pub fn azimuth(&self) -> Phase {
        self.azimuth
    }

    /// The position on the other side of the shaft.
    #[must_use]
    #[inline(always)]
    pub fn opposite(self) -> Self {
        Self { cos: -self.cos, sin: -self.sin, azimuth: self.azimuth.opposite() }
    }
}

/// `N` evenly spaced positions, the first at `first`.
#[must_use]
pub fn evenly_spaced<T: Scalar, const N: usize>(first: Phase) -> ElementPositions<T, N> {
    core::array::from_fn(|j| ElementPosition::evenly_spaced(first, j, N))
}

/// `2 H` evenly spaced positions, the first at `first`.
#[must_use]
pub fn evenly_spaced_pairs<T: Scalar, const H: usize>(first: Phase) -> OpposedPairs<T, H> {
    OpposedPairs(core::array::from_fn(|j| ElementPosition::evenly_spaced(first, j, 2 * H)))
}

impl<T: Scalar, const H: usize> OpposedPairs<T, H> {
    /// From the positions of one element of each pair.
    #[must_use]
    pub const fn new(half: ElementPositions<T, H>) -> Self {
        Self(half)
    }

    /// Seen from the frame turned by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self(self.0.map(ElementPosition::mirrored))
    }
}

/// How the elements stand; implemented for slices, arrays and vectors of positions, and for [`OpposedPairs`].
pub trait ElementLayout<T: Scalar>: Send + Sync {
    /// Whether each entry of the stored stands for itself and the element opposite to it.
    const IS_PAIRED: bool;

    /// What the hot path goes through.
    fn stored(&self) -> &[ElementPosition<T>];

    /// The `index`-th `BLOCK_SIZE` elements side by side; nothing where there are no more, or fewer than that in all.
    #[inline(always)]
    fn block(&self, index: usize) -> Option<ElementBlock<T, BLOCK_SIZE>> {
        let (stored, begin) = (self.stored(), index * BLOCK_SIZE);
        if begin >= stored.len() {
            return None;
        }
        // The last reach back where they would not be all.
        let first = begin.min(stored.len().wrapping_sub(BLOCK_SIZE));
        let positions = stored.get(first..)?.first_chunk()?;
        Some(ElementBlock { first, overlap: begin - first, ..ElementBlock::of(positions) })
    }

    /// Every element in order.
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

/// Elements side by side: cosines, sines and azimuths of their positions.
#[derive(Debug, Clone, Copy)]
// What wide registers read lies within cache lines.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct ElementBlock<T, const K: usize> {
    pub(super) cos: Lanes<T, K>,
    pub(super) sin: Lanes<T, K>,
    pub(super) azimuths: [Phase; K],
    /// The first's number in the stored.
    pub(super) first: usize,
    /// How many of them were among the ones before.
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

/// Places that are kept side by side too, as a desktop processor reads them: the same answers, sooner from
/// [`super::tabulated`].
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
    /// Of these positions. Set-up time.
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

/// Elements that are computed side by side: on the desktop as many as keep its units busy, on a microcontroller one.
pub const BLOCK_SIZE: usize = if cfg!(target_pointer_width = "64") { 4 } else { 1 };

/// Up to `K` positions, the last repeated where there are fewer.
pub(super) struct PaddedGroup<T, const K: usize> {
    pub positions: [ElementPosition<T>; K],
    count: usize,
}

impl<T, const K: usize> PaddedGroup<T, K> {
    /// Without the repetitions.
    pub fn without_padding(&self) -> &[ElementPosition<T>] {
        self.positions.get(..self.count).unwrap_or_default()
    }
}

pub(super) fn padded_groups<T: Scalar, const K: usize>(
    positions: &impl ElementLayout<T>,
) -> impl Iterator<Item = PaddedGroup<T, K>> {
    let mut each = positions.all();
    core::iter::from_fn(move || {
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
    })
}
