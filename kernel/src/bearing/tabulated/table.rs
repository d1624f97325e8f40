//! What one ball does to the inner ring, as a table over where its groove centres are and how fast the rings turn.
//!
//! Smooth quantities are stored, not the force: the load of the inner contact (below 0 where there is a gap), the sine of
//! the angle from the line of groove centres to the contact, and the friction. They are interpolated by quadratic
//! B-splines along the approach and the contact angle, linearly along the speed: continuous with their slopes where
//! contact begins and ends. Approach is stored over its signed square root, because a ball that the centrifugal force
//! wedges between both races moves sideways by the root of what the rings leave it, and because over it the load of Hertz is
//! a cubic, smooth also where contact begins.

use crate::lanes::Lanes;
use crate::scalar::Scalar;

/// One entry of the table: half the load (N; twice a positive part needs no branch), sine of the turn, and with `F = 3` the
/// friction, which is 0 at the inner contact where there is no gyroscopic moment or the outer race carries it all. With
/// `F = 4` the last number is 0 and means nothing: processors with registers of four numbers take a node in one.
pub type Node<T, const F: usize> = [T; F];

/// One coordinate: how many nodes, and where `x` lies among them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis<T> {
    /// Nodes.
    pub count: usize,
    /// Coordinate of node 0.
    pub origin: T,
    /// Nodes per unit.
    pub density: T,
    /// Least and greatest declared coordinate.
    pub range: [T; 2],
}

/// The table's shape; the nodes are stored apart, the approach running fastest, then the angle, then the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<T> {
    /// Signed square root of the approach, sqrt(m).
    pub approach: Axis<T>,
    /// Sine of the angle of the line of groove centres.
    pub angle: Axis<T>,
    /// rad/s.
    pub speed: Axis<T>,
}

impl<T: Scalar> Axis<T> {
    /// Not below 0 within the range.
    #[inline(always)]
    fn inside<const K: usize>(&self, x: Lanes<T, K>) -> Lanes<T, K> {
        let [low, high] = self.range;
        (x - Lanes::all(low)) * (Lanes::all(high) - x)
    }

    #[inline(always)]
    fn place<const K: usize>(&self, x: Lanes<T, K>) -> Lanes<T, K> {
        (x - Lanes::all(self.origin)) * Lanes::all(self.density)
    }

    /// The first of the three nodes around each `x`, and how far it lies from half before to half after the middle one.
    #[inline(always)]
    fn around<const K: usize>(&self, x: Lanes<T, K>) -> ([u32; K], Lanes<T, K>) {
        let place = self.place(x) - Lanes::all(T::HALF);
        let (first, whole) = place.index(self.count.wrapping_sub(3) as u32);
        (first, place - whole)
    }

    /// The nodes around each `x` and their weights in a quadratic B-spline.
    #[inline(always)]
    fn quadratic<const K: usize>(&self, x: Lanes<T, K>) -> Spots<T, K> {
        let [half, one] = [T::HALF, T::ONE].map(Lanes::all);
        let (first, after) = self.around(x);
        let before = one - after;
        let (before, after) = (half * before * before, half * after * after);
        Spots { first, before, middle: one - before - after, after }
    }

    /// Slopes of these weights.
    #[inline(always)]
    fn slopes<const K: usize>(&self, x: Lanes<T, K>) -> Spots<T, K> {
        let density = Lanes::all(self.density);
        let (first, after) = self.around(x);
        let before = Lanes::all(T::ONE) - after;
        Spots { first, before: -before * density, middle: (before - after) * density, after: after * density }
    }

    /// The first of the two nodes around `x` and their weights; of a single node all of it.
    #[inline(always)]
    fn linear(&self, x: T) -> (u32, [T; 2]) {
        let place = self.place(Lanes([x]));
        let ([first], whole) = place.index(self.count.saturating_sub(2) as u32);
        let Lanes([t]) = place - whole;
        (first, [T::ONE - t, t])
    }
}

/// Places of `K` balls on an axis: the first of the three nodes around each, and what they count.
#[derive(Debug, Clone, Copy)]
// What a wide register writes across two cache lines, and more so across two pages, takes many times as long.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct Spots<T, const K: usize> {
    pub first: [u32; K],
    pub before: Lanes<T, K>,
    pub middle: Lanes<T, K>,
    pub after: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> Spots<T, K> {
    #[inline(always)]
    fn weights_of(&self, i: usize) -> [T; 3] {
        [self.before.0[i], self.middle.0[i], self.after.0[i]]
    }
}

/// The nodes from the first, second and third row of the angle on, as many of each: where there is one of the last there is
/// one of all.
#[derive(Clone, Copy)]
pub struct Rows<'a, T, const F: usize> {
    before: &'a [Node<T, F>],
    middle: &'a [Node<T, F>],
    after: &'a [Node<T, F>],
}

/// A grid and its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<T, A, const F: usize> {
    grid: Grid<T>,
    nodes: A,
}

/// Speed of a call, the same for all balls.
#[derive(Clone, Copy)]
pub struct AtSpeed<T> {
    /// First node of the layer below.
    first: u32,
    weights: [T; 2],
    inside: T,
}

impl<T: Scalar> AtSpeed<T> {
    /// Its sign bit is set outside of the declared speeds.
    #[inline(always)]
    pub(super) fn inside(&self) -> T {
        self.inside
    }
}

impl<T: Scalar, A: AsRef<[Node<T, F>]>, const F: usize> Table<T, A, F> {
    /// From a grid and as many nodes as it has.
    ///
    /// Fewer nodes are no error of the hot path: what is missing reads as 0 and is flagged as outside.
    pub const fn new(grid: Grid<T>, nodes: A) -> Self {
        Self { grid, nodes }
    }

    /// Shape of the table.
    pub fn grid(&self) -> &Grid<T> {
        &self.grid
    }

    /// The nodes, ready for interpolation.
    pub fn nodes(&self) -> &[Node<T, F>] {
        self.nodes.as_ref()
    }

    #[inline(always)]
    pub(super) fn at_speed(&self, speed: T) -> AtSpeed<T> {
        let axis = &self.grid.speed;
        let Lanes([inside]) = axis.inside(Lanes([speed]));
        let (layer, weights) = if axis.count == 1 { (0, [T::ONE, T::ZERO]) } else { axis.linear(speed) };
        AtSpeed { first: layer.wrapping_mul(self.layer()), weights, inside }
    }

    /// Nodes of one speed.
    #[inline(always)]
    fn layer(&self) -> u32 {
        (self.grid.approach.count as u32).wrapping_mul(self.grid.angle.count as u32)
    }

    /// The sign bit is set where signed roots `x` of the approach or sines `sin` of the angle are outside of the declared
    /// ranges; the speed has its own ([`AtSpeed::inside`]).
    #[inline(always)]
    pub(super) fn inside<const K: usize>(&self, x: Lanes<T, K>, sin: Lanes<T, K>) -> Lanes<T, K> {
        self.grid.approach.inside(x).either_sign(self.grid.angle.inside(sin))
    }

    /// Where sines of the angle are among the nodes: their rows.
    #[inline(always)]
    pub(super) fn at_angle<const K: usize>(&self, sin: Lanes<T, K>) -> Spots<T, K> {
        let row = self.grid.approach.count as u32;
        let mut spots = self.grid.angle.quadratic(sin);
        spots.first = spots.first.map(|first| first.wrapping_mul(row));
        spots
    }

    /// Where signed roots of the approach are in their rows.
    #[inline(always)]
    pub(super) fn at_approach<const K: usize>(&self, x: Lanes<T, K>) -> Spots<T, K> {
        self.grid.approach.quadratic(x)
    }

    /// The nodes as balls are looked up in them.
    #[inline(always)]
    pub(super) fn rows<'a>(&'a self) -> Rows<'a, T, F> {
        // From 32 bits, so that on 64 nothing overflows and one comparison a ball is enough.
        let row = self.grid.approach.count as u32 as usize;
        let from = |nodes: &'a [Node<T, F>]| nodes.get(row..).unwrap_or_default();
        let nodes = self.nodes.as_ref();
        let middle = from(nodes);
        let after = from(middle);
        let [before, middle] = [nodes, middle].map(|nodes| nodes.get(..after.len()).unwrap_or_default());
        Rows { before, middle, after }
    }

    /// The quantities at `spots` along angle and approach, and the sign bit set where nodes are missing; 0 of those before ball
    /// `known`.
    #[inline(always)]
    pub(super) fn fields<const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        (angles, approaches): (&Spots<T, K>, &Spots<T, K>),
        known: usize,
    ) -> ([Lanes<T, K>; F], T) {
        let (mut nodes, mut missing) = ([[T::ZERO; F]; K], T::ZERO);
        let mut i = 0;
        while i < K {
            if i >= known {
                let weights = [angles.weights_of(i), approaches.weights_of(i)];
                match self.value(at, rows, angles.first[i].wrapping_add(approaches.first[i]), || weights) {
                    Some(node) => nodes[i] = node,
                    None => missing = T::NEGATIVE_ZERO,
                }
            }
            i += 1;
        }
        (side_by_side(&nodes), missing)
    }

    /// Slopes of the quantities along sines `sin` of the angle and signed roots `x` of the approach.
    #[inline(always)]
    pub(super) fn slopes<const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        x: Lanes<T, K>,
        sin: Lanes<T, K>,
    ) -> [[Lanes<T, K>; F]; 2] {
        let (angles, approaches) = (self.at_angle(sin), self.at_approach(x));
        let across = Spots { first: angles.first, ..self.grid.angle.slopes(sin) };
        let along = self.grid.approach.slopes(x);
        [self.fields(at, rows, (&across, &approaches), 0).0, self.fields(at, rows, (&angles, &along), 0).0]
    }

    /// Weighted sum of the nodes from `first` on in each of the two layers about the speed; nothing where they end before.
    #[inline(always)]
    fn value(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        first: u32,
        weights: impl Fn() -> [[T; 3]; 2],
    ) -> Option<Node<T, F>> {
        let first = at.first.wrapping_add(first);
        let below = rows.patch(first, &weights)?;
        if self.grid.speed.count == 1 {
            return Some(below);
        }
        let above = rows.patch(first.wrapping_add(self.layer()), &weights)?;
        Some(mixed(at.weights, [below, above]))
    }
}

impl<T: Scalar, const F: usize> Rows<'_, T, F> {
    /// Weighted sum of the nine nodes of one speed from `first` on; nothing where the table ends before them.
    #[inline(always)]
    fn patch(&self, first: u32, weights: impl Fn() -> [[T; 3]; 2]) -> Option<Node<T, F>> {
        let first = first as usize;
        let three = first..first.wrapping_add(3);
        let [by_angle, by_approach] = weights();
        let along = |nodes: &[Node<T, F>]| Some(mixed(by_approach, *nodes.get(three.clone())?.first_chunk()?));
        Some(mixed(by_angle, [along(self.before)?, along(self.middle)?, along(self.after)?]))
    }
}

/// Quantity by quantity instead of ball by ball.
#[inline(always)]
pub(super) fn side_by_side<T: Scalar, const F: usize, const K: usize>(balls: &[Node<T, F>; K]) -> [Lanes<T, K>; F] {
    let mut fields = [Lanes::all(T::ZERO); F];
    let mut field = 0;
    while field < F {
        fields[field] = Lanes::of(balls, |node| node[field]);
        field += 1;
    }
    fields
}

/// Sum of nodes times weights.
#[inline(always)]
fn mixed<T: Scalar, const F: usize, const W: usize>(weights: [T; W], nodes: [Node<T, F>; W]) -> Node<T, F> {
    let mut sum = [T::NEGATIVE_ZERO; F];
    for (node, w) in nodes.into_iter().zip(weights) {
        for (s, value) in sum.iter_mut().zip(node) {
            *s += w * value;
        }
    }
    sum
}
