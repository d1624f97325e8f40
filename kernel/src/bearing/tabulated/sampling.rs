//! Sampling of the quasi-static model into a table. For set-up on the desktop.

use super::table::{Axis, Grid, Node};
use crate::bearing::element_position::ElementLayout;
use crate::bearing::geometry::{InvalidParameter, check};
use crate::bearing::quasi_static::QuasiStatic;
use crate::bearing::quasi_static::film::Film;
use crate::bearing::quasi_static::inertia::Inertia;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::scalar::Scalar;

/// Domain and resolution of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableDomain {
    /// Least and greatest approach of the rings along the line of groove centres, m; negative with clearance.
    pub approach: [f64; 2],
    /// Approach up to which the nodes are close, m, above 0: that of the most loaded ball in service. Above it the spacing
    /// grows with the power 3/2 of the approach.
    pub scale: f64,
    /// Least and greatest angle of that line, rad.
    pub angle: [f64; 2],
    /// Least and greatest speed, rad/s: of the inner ring, or of the outer ring if the inner ring is fixed.
    pub speed: [f64; 2],
    /// Speed far below which the spacing of speeds is uniform and far above which that of their squares is, rad/s; 0 or more.
    pub speed_scale: f64,
    /// Speeds of inner and outer ring divided by that speed: 1 and 0 for a rotating inner ring.
    pub speed_ratios: [f64; 2],
    /// Intervals along approach, angle and speed; 0 along the speed for a single speed.
    pub intervals: [usize; 3],
}

/// Least number of intervals along approach and angle: the slope at an end is that of five nodes.
const MIN_INTERVALS: usize = 4;
/// Coefficients beyond the domain on both sides.
const MARGIN: usize = 1;

/// Relative rounding of a coordinate and of the range in `f32`: the ends of the domain are inside.
const ROUNDING: f64 = 2.5e-7;

/// Least cosine of the angle from the line of groove centres to the contact: beyond, a ball lies in a gap, and the tangent stays finite.
const MIN_COSINE: f64 = 0.01;

fn axis([low, high]: [f64; 2], intervals: usize, margin: usize) -> Axis<f64> {
    let step = if high > low && intervals > 0 { (high - low) / intervals as f64 } else { 1.0 };
    let slack = 1e-9 * step + ROUNDING * low.abs().max(high.abs());
    Axis {
        count: intervals + 1 + 2 * margin,
        origin: low - margin as f64 * step,
        density: 1.0 / step,
        range: [low - slack, high + slack],
    }
}

impl TableDomain {
    /// Returns the grid of the table of a bearing with its groove centres `distance` (A, m) apart where the rings just touch the balls.
    ///
    /// # Errors
    /// A range that is empty or reversed, too few intervals.
    pub fn grid(&self, distance: f64) -> Result<Grid<f64>, InvalidParameter> {
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
        for (count, least) in [(nx, MIN_INTERVALS), (na, MIN_INTERVALS), (nv, 0)] {
            check(
                (least..=4096).contains(&count),
                "intervals",
                count as f64,
                "4 to 4096, or 0 to 4096 along the speed",
            )?;
        }
        let scale = self.scale;
        check(scale > 0.0 && scale.is_finite(), "scale", scale, "an approach above 0 m")?;
        check(low > -distance, "approach", low, "a gap below the distance of the groove centres, m")?;
        let coordinate = |s: f64| {
            let e = s * (1.0 + 0.5 * s / distance);
            libm::copysign(libm::sqrt(e.abs() / (e.abs() + scale)), e)
        };
        let speed_scale = self.speed_scale;
        check(speed_scale >= 0.0 && speed_scale.is_finite(), "speed_scale", speed_scale, "a speed of 0 rad/s or more")?;
        Ok(Grid {
            scale,
            speed_scale,
            approach: axis([coordinate(low), coordinate(high)], nx, MARGIN),
            angle: axis([libm::sin(self.angle[0]), libm::sin(self.angle[1])], na, MARGIN),
            speed: axis(self.speed.map(|speed| speed * (speed + speed_scale)), nv, 0),
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
}

impl<S: Scalar> Grid<S> {
    /// Returns the grid in another precision.
    #[must_use]
    pub fn rounded<T: Scalar>(&self) -> Grid<T> {
        let rounded = |x: S| T::from_f64(x.to_f64());
        let axis = |a: &Axis<S>| Axis {
            count: a.count,
            origin: rounded(a.origin),
            density: rounded(a.density),
            range: a.range.map(rounded),
        };
        Grid {
            scale: rounded(self.scale),
            speed_scale: rounded(self.speed_scale),
            approach: axis(&self.approach),
            angle: axis(&self.angle),
            speed: axis(&self.speed),
        }
    }
}

fn coordinate(axis: &Axis<f64>, i: usize) -> f64 {
    axis.origin + i as f64 / axis.density
}

/// Fills `nodes` (as many as the grid has; further ones stay unchanged) from the balls of the bearing.
///
/// Returns the number of nodes within the domain that did not converge.
pub fn fill_table<M, P, I, L, S, const F: usize>(
    bearing: &QuasiStatic<f64, M, P, I, L, S>,
    domain: &TableDomain,
    grid: &Grid<f64>,
    nodes: &mut [Node<f64, F>],
) -> usize
where
    M: Math<f64>,
    P: ElementLayout<f64>,
    I: Inertia<f64>,
    L: Film<f64>,
    S: crate::bearing::surface::Surface<f64>,
{
    let (mut open, distance) = (0, bearing.table_constants().distance);
    let rows = nodes.chunks_mut(grid.approach.count).enumerate().take(grid.angle.count * grid.speed.count);
    for (r, row) in rows {
        let (layer, k) = (r / grid.angle.count, r % grid.angle.count);
        let Some(sin) = sampled(&grid.angle, k) else { continue };
        // The force of a ball does not depend on the sense of rotation.
        let half = 0.5 * grid.speed_scale;
        let speed = libm::sqrt(half * half + coordinate(&grid.speed, layer).max(0.0)) - half;
        let at = BearingKinematicState {
            inner_speed: speed * domain.speed_ratios[0],
            outer_speed: speed * domain.speed_ratios[1],
            ..BearingKinematicState::default()
        };
        for (i, node) in row.iter_mut().enumerate() {
            let Some(x) = sampled(&grid.approach, i) else { continue };
            let e = grid.scale * x * x.abs() / (1.0 - x * x);
            let root = libm::sqrt(e.abs() + grid.scale);
            let approach = 2.0 * e / (1.0 + libm::sqrt(1.0 + 2.0 * e / distance));
            let ([load, turn, friction], settled) = bearing.ball_at(approach, sin, &at);
            let cosine = libm::sqrt(1.0 - turn * turn).max(MIN_COSINE);
            let fields = [0.5 * cosine * load / (root * root * root), turn / cosine, cosine * friction];
            for (entry, field) in node.iter_mut().zip(fields) {
                *entry = field;
            }
            open += usize::from(!settled);
        }
    }
    prefilter(grid, nodes);
    open
}

/// Returns the coordinate of node `i`; `None` for the node beyond each end of the domain.
fn sampled(axis: &Axis<f64>, i: usize) -> Option<f64> {
    let [low, high] = axis.range;
    (i > 0 && i + 1 < axis.count).then(|| coordinate(axis, i).clamp(low, high))
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

/// Number of pivots after which the elimination of [`interpolation_coefficients`] has that of an infinite line, to the last
/// bit.
const PIVOTS: usize = 16;

/// Solves `c[k-1] + 6 c[k] + c[k+1] = 8 f[k]` in place along one line of `count` nodes by elimination; the first and the last
/// are beyond the domain and have no `f`.
///
/// The slope of the spline at both ends of the domain is that of the polynomial through five nodes.
fn interpolation_coefficients<const F: usize>(nodes: &mut [Node<f64, F>], start: usize, stride: usize, count: usize) {
    const MIDDLE: f64 = 6.0;
    // The other coefficient of the first and the last equation, into which those beyond the domain are inserted.
    const BESIDE_END: f64 = 2.0;
    let mut pivots = [MIDDLE; PIVOTS];
    let (mut last_pivot, mut beside) = (MIDDLE, BESIDE_END);
    for pivot in pivots.iter_mut().skip(1) {
        last_pivot = MIDDLE - beside / last_pivot;
        (*pivot, beside) = (last_pivot, 1.0);
    }
    let pivot = |k: usize| pivots.get(k).copied().unwrap_or(last_pivot);
    let at = |k: usize| start + k * stride;
    let last = count.saturating_sub(2);
    for field in 0..F {
        let value = |nodes: &mut [Node<f64, F>], k: usize| entry(nodes, at(k), field).map_or(0.0, |f| *f);
        let mut slope = |end: usize, inward: isize| {
            let terms = [25.0, -48.0, 36.0, -16.0, 3.0].into_iter().zip(0_isize..);
            terms.map(|(weight, k)| weight * value(nodes, end.saturating_add_signed(k * inward))).sum::<f64>() / 6.0
        };
        // Outward, times two intervals.
        let [first_slope, last_slope] = [slope(1, 1), slope(last, -1)];
        let mut before = 0.0;
        for k in 1..=last {
            let beyond = if k == 1 { first_slope } else { 0.0 } + if k == last { last_slope } else { 0.0 };
            let (lower, size) =
                if k == last { (BESIDE_END, MIDDLE - BESIDE_END / pivot(k - 2)) } else { (1.0, pivot(k - 1)) };
            if let Some(f) = entry(nodes, at(k), field) {
                before = (8.0 * *f - beyond - lower * before) / size;
                *f = before;
            }
        }
        for k in (1..last).rev() {
            let after = value(nodes, k + 1);
            let upper = if k == 1 { BESIDE_END } else { 1.0 };
            if let Some(c) = entry(nodes, at(k), field) {
                *c -= upper / pivot(k - 1) * after;
            }
        }
        for (outer, inner, slope) in [(0, 2, first_slope), (last + 1, last - 1, last_slope)] {
            let within = value(nodes, inner);
            if let Some(c) = entry(nodes, at(outer), field) {
                *c = within + slope;
            }
        }
    }
}

fn entry<const F: usize>(nodes: &mut [Node<f64, F>], i: usize, field: usize) -> Option<&mut f64> {
    nodes.get_mut(i).and_then(|node| node.get_mut(field))
}
