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

/// One entry of the table: half the load (N; twice a positive part needs no branch) and sine of the turn, and with `F = 3` the friction, which is 0 at the inner
/// contact where there is no gyroscopic moment or the outer race carries it all.
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

/// Places on an axis: the first of the nodes concerned, their weights and slopes, and a number that is below 0 outside of
/// the range: signs can be gathered without a branch.
#[derive(Clone, Copy)]
pub struct Spots<T, const W: usize, const K: usize> {
    pub first: [u32; K],
    pub weights: [Lanes<T, K>; W],
    pub slopes: [Lanes<T, K>; W],
    pub inside: Lanes<T, K>,
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

    /// Weights of a quadratic B-spline on the three nodes around each `x`.
    #[inline(always)]
    fn quadratic<const K: usize>(&self, x: Lanes<T, K>) -> Spots<T, 3, K> {
        let [half, one, density] = [T::HALF, T::ONE, self.density].map(Lanes::all);
        let place = self.place(x) - half;
        let (first, whole) = place.index(self.count.wrapping_sub(3) as u32);
        // From half before to half after the middle one of the three.
        let after = place - whole;
        let before = one - after;
        let outer = [half * before * before, half * after * after];
        Spots {
            first,
            weights: [outer[0], one - outer[0] - outer[1], outer[1]],
            slopes: [-before * density, (before - after) * density, after * density],
            inside: self.inside(x),
        }
    }

    /// Weights of the two nodes around `x`; of a single node all of it.
    #[inline(always)]
    fn linear(&self, x: T) -> Spots<T, 2, 1> {
        let place = self.place(Lanes([x]));
        let (first, whole) = place.index(self.count.saturating_sub(2) as u32);
        let t = place - whole;
        let density = Lanes::all(self.density);
        let x = Lanes([x]);
        Spots { first, weights: [Lanes::all(T::ONE) - t, t], slopes: [-density, density], inside: self.inside(x) }
    }
}

/// The quantities of `K` balls, and whether they are within the declared ranges.
#[derive(Clone, Copy)]
pub struct Values<T, const F: usize, const K: usize> {
    pub fields: [Lanes<T, K>; F],
    /// The sign bit is set outside; the speed has its own ([`AtSpeed::inside`]).
    pub inside: Lanes<T, K>,
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
    layer: u32,
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
        let Spots { first: [layer], weights, inside: Lanes([inside]), .. } = self.grid.speed.linear(speed);
        AtSpeed { layer, weights: weights.map(|Lanes([w])| w), inside }
    }

    /// Weighted sums of the nodes around `K` places.
    #[inline(always)]
    fn sum<const K: usize>(
        &self,
        at: &AtSpeed<T>,
        (angles, by_angle): (&[u32; K], &[Lanes<T, K>; 3]),
        (approaches, by_approach): (&[u32; K], &[Lanes<T, K>; 3]),
    ) -> Values<T, F, K> {
        let nothing = Lanes::all(T::ZERO);
        let mut values = Values { fields: [nothing; F], inside: nothing };
        let mut i = 0;
        while i < K {
            let weights = [by_angle.map(|w| w.0[i]), by_approach.map(|w| w.0[i])];
            match self.at(at, angles[i], approaches[i], &weights) {
                Some(node) => {
                    for (field, value) in values.fields.iter_mut().zip(node) {
                        field.0[i] = value;
                    }
                }
                None => values.inside.0[i] = T::NEGATIVE_ZERO,
            }
            i += 1;
        }
        values
    }

    /// Weighted sum of the nodes around one place; nothing where the table ends before them.
    #[inline(always)]
    fn at(&self, at: &AtSpeed<T>, angle: u32, approach: u32, weights: &[[T; 3]; 2]) -> Option<Node<T, F>> {
        let (nx, na) = (self.grid.approach.count as u32, self.grid.angle.count as u32);
        let layer = at.layer.wrapping_mul(na).wrapping_add(angle).wrapping_mul(nx).wrapping_add(approach);
        let below = self.patch(layer, weights)?;
        if self.grid.speed.count == 1 {
            return Some(below);
        }
        let above = self.patch(layer.wrapping_add(na.wrapping_mul(nx)), weights)?;
        Some(mixed(at.weights, [below, above]))
    }

    /// Weighted sum of the nine nodes of one speed from `start` on; nothing where the table ends before them.
    #[inline(always)]
    fn patch(&self, start: u32, [by_angle, by_approach]: &[[T; 3]; 2]) -> Option<Node<T, F>> {
        // From 32 bits, so that the end cannot overflow: one comparison where an address has 64.
        let (start, row) = (start as usize, self.grid.approach.count as u32 as usize);
        let nodes = self.nodes.as_ref().get(start..start.wrapping_add(row.wrapping_mul(2)).wrapping_add(3))?;
        let rows = [nodes.first_chunk()?, nodes.get(row..)?.first_chunk()?, nodes.last_chunk()?];
        Some(mixed(*by_angle, rows.map(|row| mixed(*by_approach, *row))))
    }

    /// At the signed roots `x` of the approach and the sines `sin` of the angle.
    #[inline(always)]
    pub(super) fn values<const K: usize>(&self, at: &AtSpeed<T>, x: Lanes<T, K>, sin: Lanes<T, K>) -> Values<T, F, K> {
        let (approach, angle) = (self.grid.approach.quadratic(x), self.grid.angle.quadratic(sin));
        let values = self.sum(at, (&angle.first, &angle.weights), (&approach.first, &approach.weights));
        let inside = values.inside.either_sign(approach.inside).either_sign(angle.inside);
        Values { inside, ..values }
    }

    /// Slopes of the quantities along `x` and along `sin`.
    #[inline(always)]
    pub(super) fn slopes<const K: usize>(
        &self,
        at: &AtSpeed<T>,
        x: Lanes<T, K>,
        sin: Lanes<T, K>,
    ) -> [[Lanes<T, K>; F]; 2] {
        let (approach, angle) = (self.grid.approach.quadratic(x), self.grid.angle.quadratic(sin));
        let along = self.sum(at, (&angle.first, &angle.weights), (&approach.first, &approach.slopes));
        let across = self.sum(at, (&angle.first, &angle.slopes), (&approach.first, &approach.weights));
        [along.fields, across.fields]
    }
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
