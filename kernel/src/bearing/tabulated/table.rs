//! What one ball does to the inner ring, as a table over where its groove centres are and how fast the rings turn.
//!
//! Smooth quantities are stored, not the force: the load of the inner contact (below 0 where there is a gap), the sine of
//! the angle from the line of groove centres to the contact, and the friction. They are interpolated by quadratic
//! B-splines along the approach and the contact angle, linearly along the speed: continuous with their slopes where
//! contact begins and ends. Approach is stored over its signed square root, because a ball that the centrifugal force
//! wedges between both races moves sideways by the root of what the rings leave it, and because over it the load of Hertz is
//! a cubic, smooth also where contact begins.

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

/// Place on an axis: the first of the nodes concerned, their weights and slopes, and a number that is below 0 outside of
/// the range: signs can be gathered without a branch.
#[derive(Clone, Copy)]
pub struct Spot<T, const W: usize> {
    pub first: usize,
    pub weights: [T; W],
    pub slopes: [T; W],
    pub inside: T,
}

impl<T: Scalar> Axis<T> {
    /// Not below 0 within the range.
    #[inline(always)]
    fn inside(&self, x: T) -> T {
        let [low, high] = self.range;
        (x - low) * (high - x)
    }

    /// Weights of a quadratic B-spline on the three nodes around `x`.
    #[inline(always)]
    pub fn quadratic(&self, x: T) -> Spot<T, 3> {
        let place = (x - self.origin) * self.density;
        let first = T::index(place - T::HALF, self.count.wrapping_sub(3));
        // From half before to half after the middle one of the three.
        let after = place - T::HALF - T::from_index(first);
        let before = T::ONE - after;
        let outer = [T::HALF * before * before, T::HALF * after * after];
        Spot {
            first,
            weights: [outer[0], T::ONE - outer[0] - outer[1], outer[1]],
            slopes: [-before * self.density, (before - after) * self.density, after * self.density],
            inside: self.inside(x),
        }
    }

    /// Weights of the two nodes around `x`.
    #[inline(always)]
    pub fn linear(&self, x: T) -> Spot<T, 2> {
        let place = (x - self.origin) * self.density;
        let first = T::index(place, self.count.wrapping_sub(2));
        let t = place - T::from_index(first);
        Spot { first, weights: [T::ONE - t, t], slopes: [-self.density, self.density], inside: self.inside(x) }
    }
}

/// The quantities at one place, and whether that is within the declared ranges.
#[derive(Clone, Copy)]
pub struct Value<T, const F: usize> {
    pub fields: Node<T, F>,
    /// Its sign bit is set outside; the speed has its own ([`AtSpeed::inside`]).
    pub inside: T,
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

impl<T: Scalar> AtSpeed<T> {
    /// Its sign bit is set outside of the declared speeds.
    #[inline(always)]
    pub(super) fn inside(&self) -> T {
        self.spot.inside
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
        AtSpeed { spot: self.grid.speed.linear(speed) }
    }

    /// Weighted sum of the nodes around a spot.
    #[inline(always)]
    fn sum(
        &self,
        at: &AtSpeed<T>,
        (angle, by_angle): (usize, [T; 3]),
        (approach, by_approach): (usize, [T; 3]),
    ) -> (Node<T, F>, T) {
        let (nx, na) = (self.grid.approach.count, self.grid.angle.count);
        let layer = at.spot.first.wrapping_mul(na).wrapping_add(angle).wrapping_mul(nx).wrapping_add(approach);
        let next = layer.wrapping_add(na.wrapping_mul(nx));
        let [slow, fast] = at.spot.weights;
        let both = self.patch(layer, by_angle, by_approach).zip(self.patch(next, by_angle, by_approach));
        match both {
            Some((below, above)) => (mixed([slow, fast], [below, above]), T::ZERO),
            None => ([T::ZERO; F], T::NEGATIVE_ZERO),
        }
    }

    /// Weighted sum of the nine nodes of one speed from `start` on; nothing where the table ends before them.
    #[inline(always)]
    fn patch(&self, start: usize, by_angle: [T; 3], by_approach: [T; 3]) -> Option<Node<T, F>> {
        let nx = self.grid.approach.count;
        let near = self.nodes.as_ref().get(start..)?;
        let middle = near.get(nx..)?;
        let far = middle.get(nx..)?;
        let along = |row: &[Node<T, F>]| row.first_chunk::<3>().map(|three| mixed(by_approach, *three));
        Some(mixed(by_angle, [along(near)?, along(middle)?, along(far)?]))
    }

    /// At the signed root `x` of the approach and the sine `sin` of the angle.
    #[inline(always)]
    pub(super) fn value(&self, at: &AtSpeed<T>, x: T, sin: T) -> Value<T, F> {
        let (approach, angle) = (self.grid.approach.quadratic(x), self.grid.angle.quadratic(sin));
        let (fields, there) = self.sum(at, (angle.first, angle.weights), (approach.first, approach.weights));
        let inside = there.with_sign_of(approach.inside).with_sign_of(angle.inside);
        Value { fields, inside }
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
