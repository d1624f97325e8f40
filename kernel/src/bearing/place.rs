//! Where the elements stand in the cage: any places, or opposite pairs.

use crate::lanes::Lanes;
use crate::scalar::Scalar;
use crate::turn::Turn;

/// One element's place in the cage's frame: where it is when the cage is at angle 0, ready for the hot path.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Place<T> {
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) azimuth: Turn,
}

/// The places of `N` elements; the count is a constant of the type.
///
/// The bearings take any `AsRef<[Place<T>]>`: an array here, a heap slice where the count is only known at run time.
pub type Places<T, const N: usize> = [Place<T>; N];

/// The places of `H` elements and of those opposite to them, `2 H` in all.
///
/// What opposite elements have in common is computed once: their directions differ by the sign, and where there is
/// no preload at most one of the two is loaded. Element `j` and `j + H` stand opposite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pairs<T, const H: usize>(Places<T, H>);

impl<T: Scalar> Place<T> {
    /// At an azimuth. Tables by `libm` in `f64`, rounded once. Set-up time.
    #[must_use]
    pub fn at(azimuth: Turn) -> Self {
        let p = azimuth.radians();
        Self { cos: T::from_f64(libm::cos(p)), sin: T::from_f64(libm::sin(p)), azimuth }
    }

    /// From numbers made ready elsewhere: cosine and sine of the azimuth. No arithmetic, so that firmware with constants
    /// in flash links none of what [`Place::at`] needs.
    #[must_use]
    pub const fn ready(cos: T, sin: T, azimuth: Turn) -> Self {
        Self { cos, sin, azimuth }
    }

    /// Number `j` of `count` evenly spaced ones, number 0 at `first`.
    #[must_use]
    pub fn even(first: Turn, j: usize, count: usize) -> Self {
        Self::at(first.plus(Turn((((j as u128) << 64) / (count.max(1) as u128)) as u64)))
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
    pub fn azimuth(&self) -> Turn {
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
pub fn even_places<T: Scalar, const N: usize>(first: Turn) -> Places<T, N> {
    core::array::from_fn(|j| Place::even(first, j, N))
}

/// `2 H` evenly spaced places, the first at `first`.
#[must_use]
pub fn even_pairs<T: Scalar, const H: usize>(first: Turn) -> Pairs<T, H> {
    Pairs(core::array::from_fn(|j| Place::even(first, j, 2 * H)))
}

impl<T: Scalar, const H: usize> Pairs<T, H> {
    /// From the places of one element of each pair.
    #[must_use]
    pub const fn new(half: Places<T, H>) -> Self {
        Self(half)
    }

    /// Seen from the frame turned by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self(self.0.map(Place::mirrored))
    }
}

/// How the elements stand; implemented for slices, arrays and vectors of places, and for [`Pairs`].
pub trait Arrangement<T: Scalar>: Send + Sync {
    /// Whether each entry of the table stands for itself and the element opposite to it.
    const PAIRS: bool;

    /// What the hot path goes through.
    fn table(&self) -> &[Place<T>];

    /// The `part`-th `ABREAST` elements side by side; nothing where there are no more, or fewer than that in all.
    #[inline(always)]
    fn abreast(&self, part: usize) -> Option<Abreast<T, ABREAST>> {
        let (table, begin) = (self.table(), part * ABREAST);
        if begin >= table.len() {
            return None;
        }
        // The last reach back where they would not be all.
        let from = begin.min(table.len().wrapping_sub(ABREAST));
        let places = table.get(from..)?.first_chunk()?;
        Some(Abreast { from, known: begin - from, ..Abreast::of(places) })
    }

    /// Every element in order.
    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = Place<T>> {
        let opposite = if Self::PAIRS { self.table() } else { &[] };
        self.table().iter().copied().chain(opposite.iter().map(|place| place.opposite()))
    }
}

impl<T: Scalar, A: AsRef<[Place<T>]> + Send + Sync> Arrangement<T> for A {
    const PAIRS: bool = false;
    #[inline(always)]
    fn table(&self) -> &[Place<T>] {
        self.as_ref()
    }
}

impl<T: Scalar, const H: usize> Arrangement<T> for Pairs<T, H> {
    const PAIRS: bool = true;
    #[inline(always)]
    fn table(&self) -> &[Place<T>] {
        &self.0
    }
}

/// Elements side by side: cosines, sines and azimuths of their places.
#[derive(Debug, Clone, Copy)]
// What wide registers read lies within cache lines.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct Abreast<T, const K: usize> {
    pub(super) cos: Lanes<T, K>,
    pub(super) sin: Lanes<T, K>,
    pub(super) azimuths: [Turn; K],
    /// The first's number in the table.
    pub(super) from: usize,
    /// How many of them were among the ones before.
    pub(super) known: usize,
}

impl<T: Scalar, const K: usize> Abreast<T, K> {
    #[inline(always)]
    pub(super) fn of(places: &[Place<T>; K]) -> Self {
        let (cos, sin) = (Lanes::of(places, |place| place.cos), Lanes::of(places, |place| place.sin));
        Self { cos, sin, azimuths: places.each_ref().map(|place| place.azimuth), from: 0, known: 0 }
    }
}

/// Places that are kept side by side too, as a desktop processor reads them: the same answers, sooner from
/// [`super::tabulated`].
///
/// ```
/// use ballrace::Turn;
/// use ballrace::bearing::{Arrangement, Places, SideBySide, even_places};
///
/// let nine: Places<f64, 9> = even_places(Turn::ZERO);
/// let kept = SideBySide::<_, Vec<_>>::new(nine);
/// assert_eq!(kept.table(), nine);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct SideBySide<P, G> {
    places: P,
    groups: G,
}

impl<P, G> SideBySide<P, G> {
    /// Of these places. Set-up time.
    pub fn new<T: Scalar>(places: P) -> Self
    where
        P: Arrangement<T>,
        G: FromIterator<Abreast<T, ABREAST>>,
    {
        let groups = (0..).map_while(|part| places.abreast(part)).collect();
        Self { places, groups }
    }
}

impl<T: Scalar, P, G> Arrangement<T> for SideBySide<P, G>
where
    P: Arrangement<T>,
    G: AsRef<[Abreast<T, ABREAST>]> + Send + Sync,
{
    const PAIRS: bool = P::PAIRS;
    #[inline(always)]
    fn table(&self) -> &[Place<T>] {
        self.places.table()
    }
    #[inline(always)]
    fn abreast(&self, part: usize) -> Option<Abreast<T, ABREAST>> {
        self.groups.as_ref().get(part).copied()
    }
}

/// Elements that are computed side by side: on the desktop as many as keep its units busy, on a microcontroller one.
pub const ABREAST: usize = if cfg!(target_pointer_width = "64") { 4 } else { 1 };

/// Up to `K` places, the last repeated where there are fewer.
pub(super) struct Group<T, const K: usize> {
    pub places: [Place<T>; K],
    count: usize,
}

impl<T, const K: usize> Group<T, K> {
    /// Without the repetitions.
    pub fn real(&self) -> &[Place<T>] {
        self.places.get(..self.count).unwrap_or_default()
    }
}

pub(super) fn groups<T: Scalar, const K: usize>(places: &impl Arrangement<T>) -> impl Iterator<Item = Group<T, K>> {
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
