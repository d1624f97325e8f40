//! What one ball does to the inner ring, as a table over where its groove centres are and how fast the rings turn.
//!
//! Smooth quantities are stored, not the force: the load of the inner contact (below 0 where there is a gap), the sine of
//! the angle from the line of groove centres to the contact, and the friction. They are interpolated by quadratic
//! B-splines along the approach and the contact angle, linearly along the speed: continuous with their slopes where
//! contact begins and ends. Approach is stored over its signed square root, because a ball that the centrifugal force
//! wedges between both races moves sideways by the root of what the rings leave it, and because over it the load of Hertz is
//! a cubic, smooth also where contact begins.

use crate::lanes::{Lanes, LatticeIndices};
use crate::scalar::{LatticeIndex, Scalar};

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
        (x - Lanes::splat(low)) * (Lanes::splat(high) - x)
    }

    #[inline(always)]
    fn coordinate<const K: usize>(&self, x: Lanes<T, K>) -> Lanes<T, K> {
        (x - Lanes::splat(self.origin)) * Lanes::splat(self.density)
    }

    /// The first of the three nodes around each `x`, and how far it lies from half before to half after the middle one.
    #[inline(always)]
    fn around<const K: usize>(&self, x: Lanes<T, K>, last: LatticeIndex<T>) -> (LatticeIndices<T, K>, Lanes<T, K>) {
        let coordinate = self.coordinate(x) - Lanes::splat(T::HALF);
        let first = coordinate.clamped_floor(last);
        (first, coordinate - first.numbers)
    }

    /// The last of the nodes that are the first of three.
    #[inline(always)]
    fn last(&self) -> LatticeIndex<T> {
        LatticeIndex::new(self.count.wrapping_sub(3) as u32)
    }

    /// The first of the two nodes around `x` and their weights; of a single node all of it.
    #[inline(always)]
    fn linear(&self, x: T) -> (u32, [T; 2]) {
        let Lanes([coordinate]) = self.coordinate(Lanes([x]));
        let first = coordinate.clamped_floor(LatticeIndex::new(self.count.saturating_sub(2) as u32));
        let t = coordinate - first.number;
        (first.count, [T::ONE - t, t])
    }
}

/// What the three nodes around each of `K` balls count along one axis.
#[derive(Debug, Clone, Copy)]
struct Weights<T, const K: usize> {
    before: Lanes<T, K>,
    middle: Lanes<T, K>,
    after: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> Weights<T, K> {
    /// In a quadratic B-spline, of balls that lie `after` from half before to half after the middle node.
    #[inline(always)]
    fn quadratic(after: Lanes<T, K>) -> Self {
        let [half, one] = [T::HALF, T::ONE].map(Lanes::splat);
        let before = one - after;
        let (before, after) = (half * before * before, half * after * after);
        Self { before, middle: one - before - after, after }
    }

    /// Slopes of these weights.
    #[inline(always)]
    fn slopes(after: Lanes<T, K>, density: T) -> Self {
        let density = Lanes::splat(density);
        let before = Lanes::splat(T::ONE) - after;
        Self { before: -before * density, middle: (before - after) * density, after: after * density }
    }

    #[inline(always)]
    fn of(&self, i: usize) -> [T; 3] {
        [self.before.0[i], self.middle.0[i], self.after.0[i]]
    }
}

/// Places of `K` balls in the table: the first of the nine nodes around each, and what these count.
#[derive(Debug, Clone, Copy)]
// What a wide register writes across two cache lines, and more so across two pages, takes many times as long.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct CellPositions<T, const K: usize> {
    by_angle: Weights<T, K>,
    by_approach: Weights<T, K>,
    first: [usize; K],
}

/// The nodes from the first, second and third row of the angle on, as many of each: where there is one of the last there is
/// one of all.
#[derive(Clone, Copy)]
pub struct Rows<'a, T, const F: usize> {
    before: &'a [Node<T, F>],
    middle: &'a [Node<T, F>],
    after: &'a [Node<T, F>],
    length: LatticeIndex<T>,
    last_angle: LatticeIndex<T>,
    last_approach: LatticeIndex<T>,
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
        self.grid.approach.inside(x).or_sign(self.grid.angle.inside(sin))
    }

    /// Where balls are in the table, from sines of the angle and signed roots `x` of the approach.
    #[inline(always)]
    pub(super) fn cells<const K: usize>(
        &self,
        rows: &Rows<'_, T, F>,
        sin: Lanes<T, K>,
        x: Lanes<T, K>,
    ) -> CellPositions<T, K> {
        let (row, by_angle) = self.grid.angle.around(sin, rows.last_angle);
        let (column, by_approach) = self.grid.approach.around(x, rows.last_approach);
        CellPositions {
            by_angle: Weights::quadratic(by_angle),
            by_approach: Weights::quadratic(by_approach),
            first: row.entries(rows.length, &column),
        }
    }

    /// The nodes as balls are looked up in them.
    #[inline(always)]
    pub(super) fn rows<'a>(&'a self) -> Rows<'a, T, F> {
        // From 32 bits, so that on 64 nothing overflows and one comparison a ball is enough.
        let (angle, approach) = (&self.grid.angle, &self.grid.approach);
        let length = LatticeIndex::new(approach.count as u32);
        let row = length.count as usize;
        let from = |nodes: &'a [Node<T, F>]| nodes.get(row..).unwrap_or_default();
        let nodes = self.nodes.as_ref();
        let middle = from(nodes);
        let after = from(middle);
        let [before, middle] = [nodes, middle].map(|nodes| nodes.get(..after.len()).unwrap_or_default());
        Rows { before, middle, after, length, last_angle: angle.last(), last_approach: approach.last() }
    }

    /// Whether it is of one speed.
    #[inline(always)]
    pub(super) fn is_of_one_speed(&self) -> bool {
        self.grid.speed.count == 1
    }

    /// The quantities at `cells` of a table of one speed, mixed from two, or (0) as the table is, and the sign bit set where
    /// nodes are missing; 0 of balls before `overlap`.
    #[inline(always)]
    pub(super) fn fields<const SPEEDS: usize, const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        cells: &CellPositions<T, K>,
        overlap: usize,
    ) -> ([Lanes<T, K>; F], T) {
        let (mut nodes, mut missing) = ([[T::ZERO; F]; K], T::ZERO);
        let mut i = 0;
        while i < K {
            if i >= overlap {
                match self.value::<SPEEDS, K>(at, rows, cells, i) {
                    Some(node) => nodes[i] = node,
                    None => missing = T::NEGATIVE_ZERO,
                }
            }
            i += 1;
        }
        (transposed(&nodes), missing)
    }

    /// Slopes of the quantities along sines `sin` of the angle and signed roots `x` of the approach.
    #[inline(always)]
    pub(super) fn slopes<const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        sin: Lanes<T, K>,
        x: Lanes<T, K>,
    ) -> [[Lanes<T, K>; F]; 2] {
        let (angle, approach) = (&self.grid.angle, &self.grid.approach);
        let (row, across) = angle.around(sin, rows.last_angle);
        let (column, along) = approach.around(x, rows.last_approach);
        let first = row.entries(rows.length, &column);
        let (by_angle, by_approach) = (Weights::quadratic(across), Weights::quadratic(along));
        let across = CellPositions { first, by_angle: Weights::slopes(across, angle.density), by_approach };
        let along = CellPositions { first, by_angle, by_approach: Weights::slopes(along, approach.density) };
        [self.fields::<0, K>(at, rows, &across, 0).0, self.fields::<0, K>(at, rows, &along, 0).0]
    }

    /// Weighted sum of the nodes around ball `i` in each of the two layers about the speed, or in the one; nothing where they
    /// end before.
    #[inline(always)]
    fn value<const SPEEDS: usize, const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        cells: &CellPositions<T, K>,
        i: usize,
    ) -> Option<Node<T, F>> {
        let first = cells.first[i] as u32;
        if SPEEDS == 1 || (SPEEDS == 0 && self.is_of_one_speed()) {
            return rows.weighted_sum(first, cells, i);
        }
        let first = at.first.wrapping_add(first);
        let below = rows.weighted_sum(first, cells, i)?;
        let above = rows.weighted_sum(first.wrapping_add(self.layer()), cells, i)?;
        Some(combined(at.weights, [below, above]))
    }
}

impl<T: Scalar, const F: usize> Rows<'_, T, F> {
    /// Weighted sum of the nine nodes of one speed from `first` on; nothing where the table ends before them.
    #[inline(always)]
    fn weighted_sum<const K: usize>(&self, first: u32, cells: &CellPositions<T, K>, i: usize) -> Option<Node<T, F>> {
        // From 32 bits, so that on 64 nothing overflows and one comparison a ball is enough.
        let first = first as usize;
        let three = first..first.wrapping_add(3);
        // Read here, where the compiler knows `i`: the closure may become a function of its own.
        let [by_angle, by_approach] = [cells.by_angle.of(i), cells.by_approach.of(i)];
        let along = |nodes: &[Node<T, F>]| Some(combined(by_approach, *nodes.get(three.clone())?.first_chunk()?));
        Some(combined(by_angle, [along(self.before)?, along(self.middle)?, along(self.after)?]))
    }
}

/// Quantity by quantity instead of ball by ball.
#[inline(always)]
pub(super) fn transposed<T: Scalar, const F: usize, const K: usize>(balls: &[Node<T, F>; K]) -> [Lanes<T, K>; F] {
    let mut fields = [Lanes::splat(T::ZERO); F];
    let mut field = 0;
    while field < F {
        fields[field] = Lanes::gather(balls, |node| node[field]);
        field += 1;
    }
    fields
}

/// Sum of nodes times weights.
#[inline(always)]
fn combined<T: Scalar, const F: usize, const W: usize>(weights: [T; W], nodes: [Node<T, F>; W]) -> Node<T, F> {
    let mut sum = [T::NEGATIVE_ZERO; F];
    for (node, w) in nodes.into_iter().zip(weights) {
        for (s, value) in sum.iter_mut().zip(node) {
            *s += w * value;
        }
    }
    sum
}
