//! Sampling of the quasi-static model into a table. For set-up on the desktop.

use super::table::{Axis, Grid, Node};
use crate::bearing::element_position::ElementLayout;
use crate::bearing::geometry::{InvalidParameter, check};
use crate::bearing::quasi_static::QuasiStatic;
use crate::bearing::quasi_static::film::Film;
use crate::bearing::quasi_static::inertia::Inertia;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Exact;

/// Domain and resolution of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableDomain {
    /// Least and greatest approach of the rings along the line of groove centres, m; negative with clearance.
    pub approach: [f64; 2],
    /// Least and greatest angle of that line, rad.
    pub angle: [f64; 2],
    /// Least and greatest speed, rad/s: of the inner ring, or of the outer ring if the inner ring is fixed.
    pub speed: [f64; 2],
    /// Speeds of inner and outer ring divided by that speed: 1 and 0 for a rotating inner ring.
    pub speed_ratios: [f64; 2],
    /// Intervals along approach, angle and speed; 0 along the speed for a single speed.
    pub intervals: [usize; 3],
}

/// Nodes beyond the domain on both sides, so that the boundary conditions of the splines do not matter.
const MARGIN: usize = 4;

fn axis([low, high]: [f64; 2], intervals: usize, margin: usize) -> Axis<f64> {
    let step = if high > low && intervals > 0 { (high - low) / intervals as f64 } else { 1.0 };
    let slack = 1e-9 * step;
    Axis {
        count: intervals + 1 + 2 * margin,
        origin: low - margin as f64 * step,
        density: 1.0 / step,
        range: [low - slack, high + slack],
    }
}

impl TableDomain {
    /// Returns the grid of the table.
    ///
    /// # Errors
    /// A range that is empty or reversed, too few intervals.
    pub fn grid(&self) -> Result<Grid<f64>, InvalidParameter> {
        let [low, high] = self.approach;
        check(low < high, "approach", low, "below the greatest approach")?;
        check(self.angle[0] <= self.angle[1], "angle", self.angle[0], "at most the greatest angle")?;
        check(self.angle[0].abs().max(self.angle[1].abs()) < 1.5, "angle", self.angle[1], "below 86 degrees in size")?;
        check(
            self.speed[0] >= 0.0 && self.speed[0] <= self.speed[1],
            "speed",
            self.speed[0],
            "0 or more, at most the greatest",
        )?;
        let [nx, na, nv] = self.intervals;
        for (count, least) in [(nx, 1), (na, 1), (nv, 0)] {
            check((least..=4096).contains(&count), "intervals", count as f64, "1 to 4096, 0 only along the speed")?;
        }
        let root = |s: f64| if s < 0.0 { -libm::sqrt(-s) } else { libm::sqrt(s) };
        Ok(Grid {
            approach: axis([root(low), root(high)], nx, MARGIN),
            angle: axis([libm::sin(self.angle[0]), libm::sin(self.angle[1])], na, MARGIN),
            speed: axis(self.speed, nv, 0),
        })
    }
}

impl Grid<f64> {
    /// Returns the number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.approach.count * self.angle.count * self.speed.count
    }

    /// Returns false: a grid always has nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the grid in another precision.
    #[must_use]
    pub fn rounded<T: crate::Scalar>(&self) -> Grid<T> {
        let axis = |a: &Axis<f64>| Axis {
            count: a.count,
            origin: T::from_f64(a.origin),
            density: T::from_f64(a.density),
            range: a.range.map(T::from_f64),
        };
        Grid { approach: axis(&self.approach), angle: axis(&self.angle), speed: axis(&self.speed) }
    }
}

fn coordinate(axis: &Axis<f64>, i: usize) -> f64 {
    axis.origin + i as f64 / axis.density
}

/// Fills `nodes` (as many as the grid has; further ones stay unchanged) from the balls of the bearing.
///
/// Returns the number of nodes within the domain that did not converge.
pub fn fill_table<P, I, L, S, const F: usize>(
    bearing: &QuasiStatic<f64, Exact, P, I, L, S>,
    domain: &TableDomain,
    grid: &Grid<f64>,
    nodes: &mut [Node<f64, F>],
) -> usize
where
    P: ElementLayout<f64>,
    I: Inertia<f64>,
    L: Film<f64>,
    S: crate::bearing::surface::Surface<f64>,
{
    let mut open = 0;
    let rows = nodes.chunks_mut(grid.approach.count).enumerate().take(grid.angle.count * grid.speed.count);
    for (r, row) in rows {
        // The force of a ball does not depend on the sense of rotation.
        let speed = coordinate(&grid.speed, r / grid.angle.count).abs();
        let sin = coordinate(&grid.angle, r % grid.angle.count).clamp(-0.999, 0.999);
        let at = BearingKinematicState {
            inner_speed: speed * domain.speed_ratios[0],
            outer_speed: speed * domain.speed_ratios[1],
            ..BearingKinematicState::default()
        };
        for (i, node) in row.iter_mut().enumerate() {
            let x = coordinate(&grid.approach, i);
            let ([load, turn, friction], settled) = bearing.ball_at(x * x.abs(), sin, &at);
            let fields = [0.5 * load, turn, friction];
            for (entry, field) in node.iter_mut().zip(fields) {
                *entry = field;
            }
            let [low, high] = grid.approach.range;
            open += usize::from(!settled && (low..=high).contains(&x));
        }
    }
    prefilter(grid, nodes);
    open
}

/// Converts values at the nodes to the coefficients of interpolating splines along approach and angle.
fn prefilter<const F: usize>(grid: &Grid<f64>, nodes: &mut [Node<f64, F>]) {
    let (nx, na, nv) = (grid.approach.count, grid.angle.count, grid.speed.count);
    for row in 0..na * nv {
        interpolation_coefficients(nodes, row * nx, 1, nx);
    }
    for layer in 0..nv {
        for column in 0..nx {
            interpolation_coefficients(nodes, layer * nx * na + column, nx, na);
        }
    }
}

/// Solves `(c[k-1] + 6 c[k] + c[k+1])/8 = f[k]` in place along one line of nodes by two recursions.
///
/// Values beyond the ends are taken as constant; the margin keeps the effect outside the domain. Source: Unser, Splines: a
/// perfect fit for signal and image processing (1999).
fn interpolation_coefficients<const F: usize>(nodes: &mut [Node<f64, F>], start: usize, stride: usize, count: usize) {
    /// sqrt(8) - 3
    const POLE: f64 = -0.171_572_875_253_809_9;
    const GAIN: f64 = 8.0;
    for field in 0..F {
        let mut before: Option<f64> = None;
        for k in 0..count {
            if let Some(c) = entry(nodes, start + k * stride, field) {
                *c = before.map_or(*c / (1.0 - POLE), |before| *c + POLE * before);
                before = Some(*c);
            }
        }
        let mut after: Option<f64> = None;
        for k in (0..count).rev() {
            if let Some(c) = entry(nodes, start + k * stride, field) {
                let sum = after.map_or(-POLE / (1.0 - POLE) * *c, |after| POLE * (after - *c));
                after = Some(sum);
                *c = GAIN * sum;
            }
        }
    }
}

fn entry<const F: usize>(nodes: &mut [Node<f64, F>], i: usize, field: usize) -> Option<&mut f64> {
    nodes.get_mut(i).and_then(|node| node.get_mut(field))
}
