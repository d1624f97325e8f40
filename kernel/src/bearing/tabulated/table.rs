//! Table of the force of one ball over the positions of its groove centres and the speed.
//!
//! The table stores smooth quantities instead of the force: the component `P` of the inner contact's load along the line of groove
//! centres (negative in a gap), the tangent of the angle from that line to the contact, and the component of the friction across the
//! line. The force then takes no root. Interpolation uses quadratic B-splines along
//! approach and contact angle and is linear along the speed; results and their derivatives are continuous where contact
//! begins and ends.
//!
//! The approach `s = l - A` is that of groove centres `l` apart; `e = (l^2 - A^2) / (2 A) = s (1 + s / (2 A))` differs from it little and
//! takes no root. The coordinate is `x = sqrt(|e| / (|e| + a))` with the sign of `e`, and the table holds `P / (|e| + a)^(3/2)`. The
//! Hertz load is then nearly proportional to `x^3`, smooth also at the begin of contact; a ball wedged between both races
//! by the centrifugal force moves sideways by the root of the clearance. The error is a share of the load at `a` below, and of the
//! load itself above, up to the largest that a bearing bears.
//!
//! The coordinate of the speed `w` is `w (w + b)`. Inertia loads are proportional to its square: about one speed, `b = 0` is the
//! best. Down to standstill, loads of balls without preload rise with a lower power, and a `b` above the highest speed is better.

use crate::math::Math;
use crate::math::lanes::{Lanes, LatticeIndices};
use crate::scalar::{LatticeIndex, Scalar};

/// One node: half of the load along the line of groove centres divided by `(|e| + a)^(3/2)` (N/m^(3/2); twice the positive part needs no
/// branch), the tangent of the angle from that line to the contact, and with `F = 3` the friction at the inner contact across that line, N
/// (0 without gyroscopic moment, or if the outer race carries all of it). With `F =
/// 4` the last number is unused: SIMD registers of four numbers load such a node at once.
pub type Node<T, const F: usize> = [T; F];

/// One coordinate of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis<T> {
    /// Number of nodes.
    pub count: usize,
    /// Coordinate of node 0.
    pub origin: T,
    /// Nodes per unit.
    pub density: T,
    /// Least and greatest coordinate of the domain.
    pub range: [T; 2],
}

/// Grid of a table. The nodes are stored separately: the approach varies fastest, then the angle, then the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<T> {
    /// a, approach up to which the nodes are close, m.
    pub scale: T,
    /// Coordinate of the approach, -1 to 1, see the module.
    pub approach: Axis<T>,
    /// Sine of the angle of the line of groove centres.
    pub angle: Axis<T>,
    /// b, rad/s.
    pub speed_scale: T,
    /// Coordinate of the speed, (rad/s)^2.
    pub speed: Axis<T>,
}

impl<T: Scalar> Axis<T> {
    /// Returns a number that is not negative within the range.
    #[inline(always)]
    fn inside<const K: usize>(&self, x: Lanes<T, K>) -> Lanes<T, K> {
        let [low, high] = self.range;
        (x - Lanes::splat(low)) * (Lanes::splat(high) - x)
    }

    #[inline(always)]
    fn coordinate<const K: usize>(&self, x: Lanes<T, K>) -> Lanes<T, K> {
        (x - Lanes::splat(self.origin)) * Lanes::splat(self.density)
    }

    /// Returns the first of the three nodes around each `x`, and the distance from the lower boundary of the middle cell.
    #[inline(always)]
    fn around<const K: usize>(&self, x: Lanes<T, K>, last: LatticeIndex<T>) -> (LatticeIndices<T, K>, Lanes<T, K>) {
        let coordinate = self.coordinate(x) - Lanes::splat(T::HALF);
        let first = coordinate.clamped_floor(last);
        (first, coordinate - first.numbers)
    }

    /// Returns the last node that is the first of three.
    #[inline(always)]
    fn last(&self) -> LatticeIndex<T> {
        LatticeIndex::new(self.count.wrapping_sub(3) as u32)
    }

    /// Returns the first of the two nodes around `x` and their weights.
    #[inline(always)]
    fn linear(&self, x: T) -> (u32, [T; 2]) {
        let Lanes([coordinate]) = self.coordinate(Lanes([x]));
        let first = coordinate.clamped_floor(LatticeIndex::new(self.count.saturating_sub(2) as u32));
        let t = coordinate - first.number;
        (first.count, [T::ONE - t, t])
    }
}

/// Weights of the three nodes around each of `K` balls along one axis.
#[derive(Debug, Clone, Copy)]
struct Weights<T, const K: usize> {
    before: Lanes<T, K>,
    middle: Lanes<T, K>,
    after: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> Weights<T, K> {
    /// Returns the weights of a quadratic B-spline at the distance `after` from the lower boundary of the middle cell.
    #[inline(always)]
    fn quadratic(after: Lanes<T, K>) -> Self {
        let [half, one] = [T::HALF, T::ONE].map(Lanes::splat);
        let before = one - after;
        let (before, after) = (half * before * before, half * after * after);
        Self { before, middle: one - before - after, after }
    }

    /// Returns the derivatives of these weights.
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

/// Cells of `K` balls in the table: the first of the nine nodes around each, and their weights.
#[derive(Debug, Clone, Copy)]
// SIMD stores across two cache lines, and more so across two pages, take many times as long.
#[cfg_attr(target_pointer_width = "64", repr(align(64)))]
pub struct CellPositions<T, const K: usize> {
    by_angle: Weights<T, K>,
    by_approach: Weights<T, K>,
    first: [usize; K],
}

/// The nodes from the first, second and third row of the angle on, in slices of equal length: one bounds check serves all
/// three.
#[derive(Clone, Copy)]
pub struct Rows<'a, T, const F: usize> {
    before: &'a [Node<T, F>],
    middle: &'a [Node<T, F>],
    after: &'a [Node<T, F>],
    length: LatticeIndex<T>,
    last_angle: LatticeIndex<T>,
    last_approach: LatticeIndex<T>,
}

/// A grid with its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<T, A, const F: usize> {
    grid: Grid<T>,
    nodes: A,
}

/// Speed of one evaluation, common to all balls.
#[derive(Clone, Copy)]
pub struct AtSpeed<T> {
    /// First node of the lower layer.
    first: u32,
    weights: [T; 2],
    inside: T,
}

impl<T: Scalar> AtSpeed<T> {
    /// Returns a number whose sign bit is set outside the domain of speeds.
    #[inline(always)]
    pub(super) fn inside(&self) -> T {
        self.inside
    }
}

impl<T: Scalar, A: AsRef<[Node<T, F>]>, const F: usize> Table<T, A, F> {
    /// Creates the table from a grid and its nodes.
    ///
    /// Missing nodes read as 0 and are flagged as outside the domain.
    pub const fn new(grid: Grid<T>, nodes: A) -> Self {
        Self { grid, nodes }
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid<T> {
        &self.grid
    }

    /// Returns the spline coefficients.
    pub fn nodes(&self) -> &[Node<T, F>] {
        self.nodes.as_ref()
    }

    #[inline(always)]
    pub(super) fn at_speed(&self, speed: T) -> AtSpeed<T> {
        let axis = &self.grid.speed;
        let x = speed * (speed + self.grid.speed_scale);
        let Lanes([inside]) = axis.inside(Lanes([x]));
        let (layer, weights) = if axis.count == 1 { (0, [T::ONE, T::ZERO]) } else { axis.linear(x) };
        AtSpeed { first: layer.wrapping_mul(self.layer()), weights, inside }
    }

    /// Returns the number of nodes per speed.
    #[inline(always)]
    fn layer(&self) -> u32 {
        (self.grid.approach.count as u32).wrapping_mul(self.grid.angle.count as u32)
    }

    /// Returns the coordinate of approaches `e`, and `sqrt(|e| + a)`, of whose cube the table's load is a multiple.
    #[inline(always)]
    pub(super) fn approach_coordinate<const K: usize, M: Math<T>>(&self, e: Lanes<T, K>) -> (Lanes<T, K>, Lanes<T, K>) {
        let size = e.abs();
        let root = (size + Lanes::splat(self.grid.scale)).sqrt::<M>();
        ((size.sqrt::<M>() / root).xor_sign(e), root)
    }

    /// Returns the derivative of the coordinate `x` by `e`, `a / (2 |x| (|e| + a)^2)`; a large number at 0.
    #[inline(always)]
    pub(super) fn coordinate_slope<const K: usize>(&self, x: Lanes<T, K>, root: Lanes<T, K>) -> Lanes<T, K> {
        let sum = root * root;
        Lanes::splat(T::HALF * self.grid.scale) / ((x.abs() + Lanes::splat_f64(1e-9)) * sum * sum)
    }

    /// Returns a number whose sign bit is set where coordinates `x` of the approach or sines `sin` of the angle are
    /// outside the domain; [`AtSpeed::inside`] tests the speed.
    #[inline(always)]
    pub(super) fn inside<const K: usize>(&self, x: Lanes<T, K>, sin: Lanes<T, K>) -> Lanes<T, K> {
        self.grid.approach.inside(x).or_sign(self.grid.angle.inside(sin))
    }

    /// Returns the cells of balls from sines of the angle and coordinates `x` of the approach.
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

    /// Returns the nodes by rows.
    #[inline(always)]
    pub(super) fn rows<'a>(&'a self) -> Rows<'a, T, F> {
        // Indices of 32 bits cannot overflow on 64 bits: one comparison per ball suffices.
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

    /// Returns true for a table of one speed.
    #[inline(always)]
    pub(super) fn is_of_one_speed(&self) -> bool {
        self.grid.speed.count == 1
    }

    /// Interpolates the quantities at `cells` in a table of `SPEEDS` speeds, or (0) of any number; the sign bit of the
    /// second result is set where nodes are missing. Balls before `overlap` give 0.
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

    /// Returns the derivatives of the quantities by the sine of the angle and the coordinate of the approach.
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

    /// Returns the weighted sum of the nodes around ball `i`, of both speed layers where there are two, or `None` past the
    /// end.
    #[inline(always)]
    fn value<const SPEEDS: usize, const K: usize>(
        &self,
        at: &AtSpeed<T>,
        rows: &Rows<'_, T, F>,
        cells: &CellPositions<T, K>,
        i: usize,
    ) -> Option<Node<T, F>> {
        let first = cells.first[i] as u32;
        let (by_angle, by_approach) = (cells.by_angle.of(i), cells.by_approach.of(i));
        let mut sum = [T::NEGATIVE_ZERO; F];
        if SPEEDS == 1 || (SPEEDS == 0 && self.is_of_one_speed()) {
            rows.add(&mut sum, first, by_angle, by_approach)?;
            return Some(sum);
        }
        let [below, above] = at.weights;
        let first = at.first.wrapping_add(first);
        // Six rows into one sum: in this form the compiler keeps the numbers of a node side by side.
        rows.add(&mut sum, first, by_angle.map(|w| below * w), by_approach)?;
        rows.add(&mut sum, first.wrapping_add(self.layer()), by_angle.map(|w| above * w), by_approach)?;
        Some(sum)
    }
}

impl<T: Scalar, const F: usize> Rows<'_, T, F> {
    /// Adds the weighted sum of the nine nodes of one speed from `first` on; returns `None` past the end.
    #[inline(always)]
    fn add(&self, sum: &mut Node<T, F>, first: u32, by_angle: [T; 3], by_approach: [T; 3]) -> Option<()> {
        // Indices of 32 bits cannot overflow on 64 bits: one comparison per ball suffices.
        let first = first as usize;
        let three = first..first.wrapping_add(3);
        let along = |nodes: &[Node<T, F>]| Some(combined(by_approach, *nodes.get(three.clone())?.first_chunk()?));
        for (row, w) in [along(self.before)?, along(self.middle)?, along(self.after)?].into_iter().zip(by_angle) {
            for (s, value) in sum.iter_mut().zip(row) {
                *s += w * value;
            }
        }
        Some(())
    }
}

/// Returns the values by quantity instead of by ball.
#[inline(always)]
fn transposed<T: Scalar, const F: usize, const K: usize>(balls: &[Node<T, F>; K]) -> [Lanes<T, K>; F] {
    let mut fields = [Lanes::splat(T::ZERO); F];
    let mut field = 0;
    while field < F {
        fields[field] = Lanes::gather(balls, |node| node[field]);
        field += 1;
    }
    fields
}

/// Returns the sum of nodes times weights.
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
