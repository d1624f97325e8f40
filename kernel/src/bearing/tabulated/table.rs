//! What one ball does to the inner ring, as a table over where its groove centres are and how fast the rings turn.
//!
//! Smooth quantities are stored, not the force: the load of the inner contact (below 0 where there is a gap), the sine of
//! the angle from the line of groove centres to the contact, and the friction. They are interpolated by quadratic
//! B-splines along the approach and the contact angle, linearly along the speed: continuous with their slopes where
//! contact begins and ends. Approach is stored over its signed square root, because a ball that the centrifugal force
//! wedges between both races moves sideways by the root of what the rings leave it, and because over it the load of Hertz is
//! a cubic, smooth also where contact begins.

use crate::scalar::Scalar;

/// One entry of the table: load (N) and sine of the turn, and with `F = 3` the friction, which is 0 at the inner
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

/// Place on an axis: the first of the nodes concerned, the way to the next, and whether it is within the range.
#[derive(Clone, Copy)]
pub struct Spot<T, const W: usize> {
    pub first: usize,
    pub weights: [T; W],
    pub slopes: [T; W],
    pub inside: bool,
}

impl<T: Scalar> Axis<T> {
    #[inline(always)]
    fn is_inside(&self, x: T) -> bool {
        let [low, high] = self.range;
        (low <= x) & (x <= high)
    }

    /// Weights of a quadratic B-spline on the three nodes around `x`.
    #[inline(always)]
    pub fn quadratic(&self, x: T) -> Spot<T, 3> {
        let place = (x - self.origin) * self.density;
        let nearest = T::index(place + T::HALF, self.count.wrapping_sub(2)).max(1);
        let t = place - T::from_index(nearest);
        let (before, after) = (T::HALF - t, T::HALF + t);
        let outer = [T::HALF * before * before, T::HALF * after * after];
        Spot {
            first: nearest.wrapping_sub(1),
            weights: [outer[0], T::ONE - outer[0] - outer[1], outer[1]],
            slopes: [-before * self.density, (before - after) * self.density, after * self.density],
            inside: self.is_inside(x),
        }
    }

    /// Weights of the two nodes around `x`.
    #[inline(always)]
    pub fn linear(&self, x: T) -> Spot<T, 2> {
        let place = (x - self.origin) * self.density;
        let first = T::index(place, self.count.wrapping_sub(2));
        let t = place - T::from_index(first);
        Spot { first, weights: [T::ONE - t, t], slopes: [-self.density, self.density], inside: self.is_inside(x) }
    }
}

/// The quantities at one place, and whether that is within the declared ranges.
#[derive(Clone, Copy)]
pub struct Value<T, const F: usize> {
    pub fields: Node<T, F>,
    pub inside: bool,
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
    spot: Spot<T, 2>,
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
        AtSpeed { spot: self.grid.speed.linear(speed) }
    }

    /// Weighted sum of the nodes around a spot.
    #[inline(always)]
    fn sum(
        &self,
        at: &AtSpeed<T>,
        (angle, by_angle): (usize, [T; 3]),
        (approach, by_approach): (usize, [T; 3]),
    ) -> (Node<T, F>, bool) {
        let (nx, na) = (self.grid.approach.count, self.grid.angle.count);
        let nodes = self.nodes.as_ref();
        let start = at.spot.first.wrapping_mul(na).wrapping_add(angle).wrapping_mul(nx).wrapping_add(approach);
        let mut sum = [T::ZERO; F];
        let mut there = true;
        for (k, by_speed) in at.spot.weights.into_iter().enumerate() {
            let layer = start.wrapping_add(k.wrapping_mul(na).wrapping_mul(nx));
            for (j, weight) in by_angle.into_iter().enumerate() {
                let row = layer.wrapping_add(j.wrapping_mul(nx));
                let Some(three) = nodes.get(row..).and_then(<[Node<T, F>]>::first_chunk::<3>) else {
                    there = false;
                    continue;
                };
                let mut along = [T::ZERO; F];
                for (node, w) in three.iter().zip(by_approach) {
                    for (s, value) in along.iter_mut().zip(node) {
                        *s += w * *value;
                    }
                }
                let weight = by_speed * weight;
                for (s, value) in sum.iter_mut().zip(along) {
                    *s += weight * value;
                }
            }
        }
        (sum, there)
    }

    /// At the signed root `x` of the approach and the sine `sin` of the angle.
    #[inline(always)]
    pub(super) fn value(&self, at: &AtSpeed<T>, x: T, sin: T) -> Value<T, F> {
        let (approach, angle) = (self.grid.approach.quadratic(x), self.grid.angle.quadratic(sin));
        let (fields, there) = self.sum(at, (angle.first, angle.weights), (approach.first, approach.weights));
        Value { fields, inside: there & at.spot.inside & approach.inside & angle.inside }
    }

    /// Slopes of the quantities along `x` and along `sin`.
    #[inline(always)]
    pub(super) fn slopes(&self, at: &AtSpeed<T>, x: T, sin: T) -> (Node<T, F>, Node<T, F>) {
        let (approach, angle) = (self.grid.approach.quadratic(x), self.grid.angle.quadratic(sin));
        let (along, _) = self.sum(at, (angle.first, angle.weights), (approach.first, approach.slopes));
        let (across, _) = self.sum(at, (angle.first, angle.slopes), (approach.first, approach.weights));
        (along, across)
    }
}
