//! Where the elements stand in the cage: any places, or opposite pairs.

use crate::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// One element's place in the cage's frame: where it is when the cage is at angle 0, ready for the hot path.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ElementPosition<T> {
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) azimuth: Phase,
}

/// The places of `N` elements; the count is a constant of the type.
///
/// The bearings take any `AsRef<[ElementPosition<T>]>`: an array here, a heap slice where the count is only known at run time.
pub type ElementPositions<T, const N: usize> = [ElementPosition<T>; N];

/// The places of `H` elements and of those opposite to them, `2 H` in all.
///
/// What opposite elements have in common is computed once: their directions differ by the sign, and where there is
/// no preload at most one of the two is loaded. Element `j` and `j + H` stand opposite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpposedPairs<T, const H: usize>(ElementPositions<T, H>);

impl<T: Scalar> ElementPosition<T> {
    /// At an azimuth. Tables by `libm` in `f64`, rounded once. Set-up time.
    #[must_use]
    pub fn at(azimuth: Phase) -> Self {
        let p = azimuth.radians();
        Self { cos: T::from_f64(libm::cos(p)), sin: T::from_f64(libm::sin(p)), azimuth }
    }

    /// From numbers made ready elsewhere: cosine and sine of the azimuth. No arithmetic, so that firmware with constants
    /// in flash links none of what [`ElementPosition::at`] needs.
    #[must_use]
    pub const fn ready(cos: T, sin: T, azimuth: Phase) -> Self {
        Self { cos, sin, azimuth }
    }

    /// Number `j` of `count` evenly spaced ones, number 0 at `first`.
    #[must_use]
    pub fn even(first: Phase, j: usize, count: usize) -> Self {
        Self::at(first.plus(Phase((((j as u128) << 64) / (count.max(1) as u128)) as u64)))
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

    /// The place on the other side of the shaft.
    #[must_use]
    #[inline(always)]
    pub fn opposite(self) -> Self {
        Self { cos: -self.cos, sin: -self.sin, azimuth: self.azimuth.opposite() }
    }
}

/// `N` evenly spaced places, the first at `first`.
#[must_use]
pub fn evenly_spaced<T: Scalar, const N: usize>(first: Phase) -> ElementPositions<T, N> {
    core::array::from_fn(|j| ElementPosition::even(first, j, N))
}

/// `2 H` evenly spaced places, the first at `first`.
#[must_use]
pub fn even_pairs<T: Scalar, const H: usize>(first: Phase) -> OpposedPairs<T, H> {
    OpposedPairs(core::array::from_fn(|j| ElementPosition::even(first, j, 2 * H)))
}

impl<T: Scalar, const H: usize> OpposedPairs<T, H> {
    /// From the places of one element of each pair.
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

/// How the elements stand; implemented for slices, arrays and vectors of places, and for [`OpposedPairs`].
pub trait ElementLayout<T: Scalar>: Send + Sync {
    /// Whether each entry of the table stands for itself and the element opposite to it.
    const PAIRS: bool;

    /// What the hot path goes through.
    fn table(&self) -> &[ElementPosition<T>];

    /// The `part`-th `BLOCK` elements side by side; nothing where there are no more, or fewer than that in all.
    #[inline(always)]
    fn abreast(&self, part: usize) -> Option<ElementBlock<T, BLOCK>> {
        let (table, begin) = (self.table(), part * BLOCK);
        if begin >= table.len() {
            return None;
        }
        // The last reach back where they would not be all.
        let from = begin.min(table.len().wrapping_sub(BLOCK));
        let places = table.get(from..)?.first_chunk()?;
        Some(ElementBlock { from, known: begin - from, ..ElementBlock::of(places) })
    }

    /// Every element in order.
    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = ElementPosition<T>> {
        let opposite = if Self::PAIRS { self.table() } else { &[] };
        self.table().iter().copied().chain(opposite.iter().map(|place| place.opposite()))
    }
}

impl<T: Scalar, A: AsRef<[ElementPosition<T>]> + Send + Sync> ElementLayout<T> for A {
    const PAIRS: bool = false;
    #[inline(always)]
    fn table(&self) -> &[ElementPosition<T>] {
        self.as_ref()
    }
}

impl<T: Scalar, const H: usize> ElementLayout<T> for OpposedPairs<T, H> {
    const PAIRS: bool = true;
    #[inline(always)]
    fn table(&self) -> &[ElementPosition<T>] {
        &self.0
    }
}

/// Elements side by side: cosines, sines and azimuths of their places.
#[derive(Debug, Clone, Copy)]
// What wide registers read lies within cache lines.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct ElementBlock<T, const K: usize> {
    pub(super) cos: Lanes<T, K>,
    pub(super) sin: Lanes<T, K>,
    pub(super) azimuths: [Phase; K],
    /// The first's number in the table.
    pub(super) from: usize,
    /// How many of them were among the ones before.
    pub(super) known: usize,
}

impl<T: Scalar, const K: usize> ElementBlock<T, K> {
    #[inline(always)]
    pub(super) fn of(places: &[ElementPosition<T>; K]) -> Self {
        let (cos, sin) = (Lanes::of(places, |place| place.cos), Lanes::of(places, |place| place.sin));
        Self { cos, sin, azimuths: places.each_ref().map(|place| place.azimuth), from: 0, known: 0 }
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
/// assert_eq!(kept.table(), nine);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BlockedPositions<P, G> {
    places: P,
    groups: G,
}

impl<P, G> BlockedPositions<P, G> {
    /// Of these places. Set-up time.
    pub fn new<T: Scalar>(places: P) -> Self
    where
        P: ElementLayout<T>,
        G: FromIterator<ElementBlock<T, BLOCK>>,
    {
        let groups = (0..).map_while(|part| places.abreast(part)).collect();
        Self { places, groups }
    }
}

impl<T: Scalar, P, G> ElementLayout<T> for BlockedPositions<P, G>
where
    P: ElementLayout<T>,
    G: AsRef<[ElementBlock<T, BLOCK>]> + Send + Sync,
{
    const PAIRS: bool = P::PAIRS;
    #[inline(always)]
    fn table(&self) -> &[ElementPosition<T>] {
        self.places.table()
    }
    #[inline(always)]
    fn abreast(&self, part: usize) -> Option<ElementBlock<T, BLOCK>> {
        self.groups.as_ref().get(part).copied()
    }
}

/// Elements that are computed side by side: on the desktop as many as keep its units busy, on a microcontroller one.
pub const BLOCK: usize = if cfg!(target_pointer_width = "64") { 4 } else { 1 };

/// Up to `K` places, the last repeated where there are fewer.
pub(super) struct Group<T, const K: usize> {
    pub places: [ElementPosition<T>; K],
    count: usize,
}

impl<T, const K: usize> Group<T, K> {
    /// Without the repetitions.
    pub fn real(&self) -> &[ElementPosition<T>] {
        self.places.get(..self.count).unwrap_or_default()
    }
}

pub(super) fn groups<T: Scalar, const K: usize>(places: &impl ElementLayout<T>) -> impl Iterator<Item = Group<T, K>> {
    let mut each = places.each();
    core::iter::from_fn(move || {
        let first = each.next()?;
        let mut group = Group { places: [first; K], count: 1 };
        let mut last = first;
        for place in group.places.iter_mut().skip(1) {
            if let Some(next) = each.next() {
                last = next;
                group.count += 1;
            }
            *place = last;
        }
        Some(group)
    })
}
