//! Balls whose force is interpolated in a table, as [`crate::bearing::tabulated`] has them.

mod set_up;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

pub use set_up::{TabulatedParams, directions};

use super::arithmetic::{Direction, Turn, positive_part, product, product_unsigned, status_at};
use super::root::Root;
use crate::phase::Phase;
use crate::status::Status;

/// One in units of 2^-30.
const ONE: i32 = 1 << 30;

/// A ball bearing on counts, its nodes at one speed in `A`: loads and tangents, and with `F = 3` the friction.
///
/// ```
/// # use ballrace::bearing::angular::DisplacementDatum;
/// # use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
/// # use ballrace::bearing::quasi_static::QuasiStatic;
/// # use ballrace::bearing::tabulated::{self, Table, TableDomain, fill_table};
/// # use ballrace::bearing::{Bearing, evenly_spaced};
/// # use ballrace::{BearingKinematicState, Displacement, Exact};
/// use ballrace::Phase;
/// use ballrace::bearing::fixed_point::{Tabulated, TabulatedParams};
///
/// # let geometry = BallBearingGeometry {
/// #     ball_diameter: 7e-3,
/// #     pitch_diameter: 38.5e-3,
/// #     inner_conformity: 0.52,
/// #     outer_conformity: 0.52,
/// #     contact_angle: 0.436,
/// #     ball: BEARING_STEEL,
/// #     race: BEARING_STEEL,
/// # };
/// # let solved = QuasiStatic::<f64, Exact, _>::try_new(geometry, evenly_spaced::<_, 8>(Phase::ZERO), DisplacementDatum::Touching)?;
/// # let constants = solved.table_constants();
/// # let grid = TableDomain {
/// #     approach: [-5e-6, 20e-6],
/// #     scale: 5e-6,
/// #     angle: [0.1, 0.8],
/// #     speed: [0.0, 2000.0],
/// #     speed_scale: 0.0,
/// #     speed_ratios: [1.0, 0.0],
/// #     intervals: [16, 8, 0],
/// # };
/// # let (domain, grid) = (grid, grid.grid(constants.distance)?);
/// # let mut nodes = [[0.0; 2]; 19 * 11];
/// # fill_table(&solved, &domain, &grid, &mut nodes);
/// # let bearing = tabulated::Tabulated::<_, Exact, _, _, 2>::new(evenly_spaced::<_, 8>(Phase::ZERO), constants, Table::new(grid, nodes), false);
/// // Set-up from a bearing with a table in floats: 16 and 8 intervals, 1 mm at 2^31 counts.
/// let params = TabulatedParams { speed: 1256.0, range: 1e-3, mirrored: false };
/// let fixed = Tabulated::<8, _, 2>::try_new(&bearing, &params, [[0; 2]; 19 * 11])?;
/// // Per sample: integers alone.
/// let w = (10e-6 / fixed.metres_per_count()) as i32;
/// let force = fixed.reaction(0, 0, w, 0, 0, Phase::ZERO);
/// let thrust = f64::from(force.fz) * fixed.newtons_per_count();
/// # let expected = bearing.reaction(&Displacement { w: 10e-6, ..Displacement::default() }, &BearingKinematicState::default());
/// # assert!((thrust - expected.wrench.fz).abs() < 0.01 && thrust < -100.0, "{thrust} {expected:?}");
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub type Tabulated<const N: usize, A, const F: usize> = TabulatedElements<[Direction; N], A, F>;

/// Balls with the directions `D` and the nodes `A`.
///
/// Lengths are in units of 2^-29 of the range, the directions of lines in 2^-29, all other numbers from -1 to 1 in 2^-30.
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedElements<D, A, const F: usize> {
    directions: D,
    nodes: A,
    lines: Lines,
    approach: Coordinate,
    angle: Coordinate,
    /// Range of the sine of the angle of the line of groove centres.
    sines: [i32; 2],
    /// Nodes along the approach.
    columns: usize,
    /// Shift of the load of a ball to counts of all.
    load_shift: u32,
    /// Shift of a product with a tangent, and the largest product after it: the load of a ball where its load is the largest.
    tangent_shift: u32,
    largest_across: i32,
    friction: Friction,
    /// -1 where the bearing carries thrust towards -Z, else 1.
    sense: i32,
    metres_per_count: f64,
    newtons_per_count: f64,
    arm: f64,
}

/// Lines of groove centres. Squares are in units of 2^29 squared lengths after the shift of components, in which an approach is
/// `(l^2 - A^2) / (2 A)`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lines {
    /// Radial displacement of the inner groove centres at zero displacement.
    offset: i32,
    /// Vector from the outer to the inner groove centres with the rings just touching the balls.
    rest: [i32; 2],
    /// Largest component of a line, and the shift to the left that makes its length about 2^29.
    longest: i32,
    component_shift: u32,
    /// Squared length of the line at rest, after that shift.
    rest_squared: i64,
    /// Least and greatest `l^2 - A^2` of the table.
    domain: [i32; 2],
    /// Shift to the left of an approach, and the scale of the table after it.
    approach_shift: u32,
    scale: u32,
}

/// Number of a node from a coordinate, in units of 2^-50: `x density + begin`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coordinate {
    density: i32,
    begin: i64,
}

/// Friction at the inner contact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Friction {
    /// Counts of the largest friction.
    largest: i32,
    /// 1 in units of the squared tangent.
    one: u32,
    /// Lever of the couple over the lever arm and the root of the secant, in units of 2^-20.
    couple: i32,
}

/// Force and moment on the inner ring, in counts; the moments over the lever arm.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TabulatedReaction {
    /// Force along X.
    pub fx: i32,
    /// Force along Y.
    pub fy: i32,
    /// Force along Z.
    pub fz: i32,
    /// Moment about X, in counts of [`TabulatedElements::newton_metres_per_count`].
    pub mx: i32,
    /// Moment about Y, in counts of [`TabulatedElements::newton_metres_per_count`].
    pub my: i32,
    /// [`Status::CONTACT_LOST`] without contact; [`Status::OUT_OF_TABLE`] where a ball is outside the table: its load is then that at the edge.
    pub status: Status,
}

/// Line of groove centres of one ball.
struct Line {
    /// Cosine and sine of its angle.
    direction: [i32; 2],
    /// Coordinate of the approach.
    x: i32,
    /// `(|e| + a)^(3/2)` over its largest, in units of 2^-31.
    cube: u32,
    /// All bits set outside the table.
    outside: i32,
}

/// Force of one ball, in counts.
struct Contact {
    radial: i32,
    axial: i32,
    tilting: i32,
    along: u32,
}

/// Returns a number within a range, and all bits set where it was outside. The differences do not overflow. By sums of positive parts: the compiler
/// makes branches of a choice.
#[inline(always)]
fn clamped(x: i32, [low, high]: [i32; 2]) -> (i32, i32) {
    let (above_low, below_high) = (x.wrapping_sub(low), high.wrapping_sub(x));
    let from_low = low + positive_part(above_low) as i32;
    (high - positive_part(high - from_low) as i32, (above_low | below_high) >> 31)
}

impl Coordinate {
    /// Returns the first of the three nodes around `x`, and their weights: a quadratic B-spline.
    #[inline(always)]
    fn around(&self, x: i32) -> (usize, [i32; 3]) {
        let at = product(x, self.density) + self.begin;
        let after = ((at >> 20) as i32) & (ONE - 1);
        let before = ONE - after;
        let [before, after] = [before, after].map(|t| (product(t, t) >> 31) as i32);
        ((at >> 50) as usize, [before, ONE - before - after, after])
    }
}

impl Lines {
    /// Returns the line of a ball whose inner groove centre is displaced by `radial` and `axial`, and the sine of its angle within the table.
    #[inline(always)]
    fn line(&self, radial: i32, axial: i32, sines: [i32; 2]) -> (Line, i32) {
        let [rest_r, rest_z] = self.rest;
        let [r, z] = [rest_r + radial, rest_z + axial]
            .map(|component| clamped(component, [-self.longest, self.longest]).0 << self.component_shift);
        let difference = product(r, r) + product(z, z) - self.rest_squared;
        let (difference, outside) = clamped((difference >> 29) as i32, self.domain);
        let length = Root::of(((self.rest_squared >> 29) as i32 + difference) as u32);
        let per_length = (length.inverse >> (3 - length.shift)) as i32;
        let direction = [r, z].map(|component| (product(component, per_length) >> 28) as i32);
        let sign = difference >> 31;
        let size = (((difference ^ sign) - sign) as u32) << self.approach_shift;
        let (part, whole) = (Root::of(size), Root::of(size + self.scale));
        let x = (product_unsigned(part.mantissa, whole.inverse) >> 30) as i32 >> (part.shift - whole.shift);
        let cube = (product_unsigned(size + self.scale, whole.value()) >> 30) as u32;
        let (sine, aside) = clamped(direction[1], sines);
        (Line { direction, x: (x ^ sign) - sign, cube, outside: outside | aside }, sine)
    }
}

impl<D: AsRef<[Direction]>, A: AsRef<[[i32; F]]>, const F: usize> TabulatedElements<D, A, F> {
    /// Returns the displacement of one count, m; that of the tilts is at the lever arm.
    #[must_use]
    pub const fn metres_per_count(&self) -> f64 {
        self.metres_per_count
    }

    /// Returns the lever arm, m: a count of a tilt is [`Self::metres_per_count`] over it, in rad.
    #[must_use]
    pub const fn arm(&self) -> f64 {
        self.arm
    }

    /// Returns the force of one count, N.
    #[must_use]
    pub const fn newtons_per_count(&self) -> f64 {
        self.newtons_per_count
    }

    /// Returns the moment of one count, N m.
    #[must_use]
    pub const fn newton_metres_per_count(&self) -> f64 {
        self.newtons_per_count * self.arm
    }

    /// Computes force and moment on the inner ring at the displacements `u`, `v`, `w` along X, Y, Z and the tilts about X and Y times the lever arm,
    /// in counts of [`Self::metres_per_count`]; any counts are valid.
    #[must_use]
    pub fn reaction(&self, u: i32, v: i32, w: i32, tilt_x: i32, tilt_y: i32, cage: Phase) -> TabulatedReaction {
        let turn = Turn::of(cage);
        let [x, y] = turn.to_cage([u, v]).map(|x| (x >> 32) as i32);
        let [tilt_x, tilt_y] = turn.to_cage([tilt_x, tilt_y]).map(|x| self.sense * (x >> 32) as i32);
        let w = self.sense * (w >> 2);
        let (mut sums, mut axial, mut load, mut outside) = ([0; 4], 0, 0, 0);
        for &[cos, sin] in self.directions.as_ref() {
            let radial = ((product(x, cos) + product(y, sin)) >> 30) as i32 + self.lines.offset;
            let tilt = ((product(tilt_x, sin) - product(tilt_y, cos)) >> 30) as i32;
            let (line, sine) = self.lines.line(radial, w + tilt, self.sines);
            let (contact, missing) = self.contact(&line, sine);
            let along = [(contact.radial, cos), (contact.radial, sin), (contact.tilting, cos), (contact.tilting, sin)];
            for (sum, (force, direction)) in sums.iter_mut().zip(along) {
                *sum += product(force, direction);
            }
            axial += contact.axial;
            load += contact.along;
            outside |= line.outside | missing;
        }
        let [x, y, tilting_cos, tilting_sin] = sums.map(|x| (x >> 30) as i32);
        let [fx, fy] = turn.to_housing([x, y]).map(|x| -(x >> 30) as i32);
        let moments = [tilting_sin, -tilting_cos].map(|x| self.sense * x);
        let [mx, my] = turn.to_housing(moments).map(|x| -(x >> 30) as i32);
        let of_table = Status::from_bits(Status::OUT_OF_TABLE.bits() & outside as u8);
        TabulatedReaction { fx, fy, fz: -self.sense * axial, mx, my, status: status_at(load) | of_table }
    }

    /// Returns the force of a ball, and all bits set where nodes are missing.
    #[inline(always)]
    fn contact(&self, line: &Line, sine: i32) -> (Contact, i32) {
        let Some(fields) = self.fields(line.x, sine) else {
            return (Contact { radial: 0, axial: 0, tilting: 0, along: 0 }, -1);
        };
        let field = |k: usize| fields.get(k).copied().unwrap_or(0);
        let along = (product_unsigned(positive_part(field(0)), line.cube) >> 32) as u32 >> self.load_shift;
        let (mut r, mut z) = (along as i32, self.times_tangent(along as i32, field(1)));
        let mut couple = 0;
        if F > 2 {
            let friction = (product(field(2), self.friction.largest) >> 30) as i32;
            r += self.times_tangent(friction, field(1));
            z -= friction;
            couple = self.friction.couple(friction, field(1));
        }
        let [cos, sin] = line.direction;
        let radial = ((product(r, cos) - product(z, sin)) >> 29) as i32;
        let axial = ((product(r, sin) + product(z, cos)) >> 29) as i32;
        (Contact { radial, axial, tilting: axial + couple, along }, 0)
    }

    #[inline(always)]
    fn times_tangent(&self, force: i32, tangent: i32) -> i32 {
        let across = (product(force, tangent) >> self.tangent_shift) as i32;
        clamped(across, [-self.largest_across, self.largest_across]).0
    }

    /// Interpolates the nodes; `None` past their end.
    #[inline(always)]
    fn fields(&self, x: i32, sine: i32) -> Option<[i32; F]> {
        let (column, by_approach) = self.approach.around(x);
        let (row, by_angle) = self.angle.around(sine);
        let mut rows = self.nodes.as_ref().get(row.wrapping_mul(self.columns).wrapping_add(column)..)?;
        let mut sums = [0; F];
        for (i, weight) in by_angle.into_iter().enumerate() {
            if i > 0 {
                rows = rows.get(self.columns..)?;
            }
            let nodes: &[[i32; F]; 3] = rows.first_chunk()?;
            for (k, sum) in sums.iter_mut().enumerate() {
                let along = nodes.iter().zip(by_approach).map(|(node, weight)| product(node[k], weight)).sum::<i64>();
                *sum += product((along >> 30) as i32, weight);
            }
        }
        Some(sums.map(|sum| (sum >> 30) as i32))
    }
}

impl Friction {
    /// Returns the couple of a friction over the lever arm: it acts across the contact, whose angle from the line has this tangent.
    #[inline(always)]
    fn couple(&self, friction: i32, tangent: i32) -> i32 {
        let secant = Root::of(self.one + (product(tangent, tangent) >> 30) as u32).value();
        let lever = (product(secant as i32, self.couple) >> 25) as i32;
        (product(friction, clamped(lever, [-(1 << 26), 1 << 26]).0) >> 25) as i32
    }
}
