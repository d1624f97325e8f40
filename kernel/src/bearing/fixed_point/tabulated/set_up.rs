//! Integers of a bearing from its table in floats. For set-up: uses `f64` and `libm`.

use super::{Coordinate, Friction, Lines, ONE, TabulatedElements};
use crate::bearing::ElementLayout;
use crate::bearing::fixed_point::arithmetic::{Direction, direction};
use crate::bearing::geometry::{InvalidParameter, check};
use crate::bearing::quasi_static::TableConstants;
use crate::bearing::tabulated::{Axis, Grid, Node, Table, Tabulated};
use crate::math::Math;
use crate::scalar::Scalar;

/// Parameters of a bearing on counts beside its table.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TabulatedParams {
    /// Speed of the ring over whose speed the table is, rad/s: the nodes are those of this speed.
    pub speed: f64,
    /// Displacement of 2^31 counts, m: the largest that the converter delivers, 2 to 100 times the distance of the groove centres.
    pub range: f64,
    /// True for a bearing that carries thrust towards -Z: the table is that of the bearing within [`crate::bearing::Mirrored`].
    pub mirrored: bool,
}

/// 2^29, 2^30 and 2^50.
const HALF: f64 = 0.5 * ONE as f64;
const WHOLE: f64 = ONE as f64;
const OF_NODES: f64 = 1024.0 * WHOLE * 1024.0;

impl Coordinate {
    /// Creates the map of an axis whose coordinate is in units of 2^-`bits`.
    fn of(axis: &Axis<f64>, bits: i32) -> Result<Self, InvalidParameter> {
        let Axis { origin, density, .. } = *axis;
        check(density > 0.0 && density < 1000.0, "density", density, "above 0, below 1000 nodes per unit")?;
        check(origin.abs() <= 1.5, "origin", origin, "-1.5 to 1.5")?;
        let begin = libm::round(-(origin * density + 0.5) * OF_NODES) as i64;
        Ok(Self { density: libm::round(libm::scalbn(density, 50 - bits)) as i32, begin })
    }
}

/// Returns a power of 2 by which a number lies between 2^`bits` and its half.
fn exponent_below(x: f64, bits: i32) -> i32 {
    bits - libm::frexp(x).1
}

/// Units of the lines of groove centres.
struct Units {
    lines: Lines,
    /// `sqrt(2^31)` units of the approach, to the third power, m^1.5.
    cube: f64,
}

impl Units {
    fn of(constants: &TableConstants<f64>, grid: &Grid<f64>, range: f64) -> Result<Self, InvalidParameter> {
        let TableConstants { distance, axis, offset, .. } = *constants;
        check(
            range >= 2.0 * distance && range <= 100.0 * distance,
            "range",
            range,
            "2 to 100 times the distance of the groove centres",
        )?;
        check(
            offset.abs() <= 0.25 * distance,
            "offset",
            offset,
            "at most a quarter of the distance of the groove centres",
        )?;
        let norm = libm::hypot(axis[0], axis[1]);
        check((norm - 1.0).abs() < 1e-3, "axis", norm, "a direction of length 1")?;
        let unit = range / HALF;
        let rest = axis.map(|part| libm::round(distance * part / unit) as i32);
        let rest_squared = rest.iter().map(|&part| i64::from(part) * i64::from(part)).sum::<i64>();
        let [low, high] = grid.approach.range;
        check(low > -1.0 && high < 1.0 && low < high, "approach", high, "a coordinate from -1 to 1")?;
        let [low, high] = [low, high].map(|x| grid.scale * x * x.abs() / (1.0 - x * x));
        check(low >= -0.37 * distance, "approach", low, "-0.37 times the distance of the groove centres or more")?;
        let highest = 0.45 * distance;
        check(
            high > 0.0 && high <= highest,
            "approach",
            high,
            "above 0, at most 0.45 times the distance of the groove centres",
        )?;
        let largest = low.abs().max(high.abs()) + grid.scale;
        check(grid.scale > 0.0 && largest < distance, "scale", grid.scale, "below the distance of the groove centres")?;
        let component_shift = exponent_below(distance / unit, 29);
        // e = (l^2 - A^2) / (2 A), in units of squares.
        let squares = 2.0 * distance * libm::scalbn(1.0, 2 * component_shift - 29) / (unit * unit);
        let approach_shift = exponent_below(largest * squares, 31);
        let approach_unit = libm::scalbn(1.0 / squares, -approach_shift);
        let whole = approach_unit * 2.0 * WHOLE;
        let lines = Lines {
            offset: libm::round(offset / unit) as i32,
            rest,
            longest: libm::round(1.4 * distance / unit) as i32,
            component_shift: component_shift as u32,
            rest_squared: rest_squared << (2 * component_shift),
            domain: [low, high].map(|e| libm::round(e * squares) as i32),
            approach_shift: approach_shift as u32,
            scale: libm::round(grid.scale / approach_unit) as u32,
        };
        Ok(Self { lines, cube: whole * libm::sqrt(whole) })
    }
}

/// Nodes of a table at one speed.
struct AtSpeed<'a, T, const F: usize> {
    layers: [&'a [Node<T, F>]; 2],
    /// Weight of the second layer.
    above: f64,
}

impl<'a, T: Scalar, const F: usize> AtSpeed<'a, T, F> {
    fn of<B: AsRef<[Node<T, F>]>>(
        table: &'a Table<T, B, F>,
        grid: &Grid<f64>,
        speed: f64,
    ) -> Result<Self, InvalidParameter> {
        let Axis { count, origin, density, range: [low, high] } = grid.speed;
        let x = speed.abs() * (speed.abs() + grid.speed_scale);
        check(x >= low && x <= high, "speed", speed, "within the table")?;
        let last = count.saturating_sub(2);
        let at = if count > 1 { ((x - origin) * density).max(0.0) } else { 0.0 };
        let layer = (at as usize).min(last);
        let length = grid.approach.count.saturating_mul(grid.angle.count);
        let from =
            |layer: usize| table.nodes().get(layer.saturating_mul(length)..).and_then(|nodes| nodes.get(..length));
        let (below, next) = (from(layer), from(layer + usize::from(count > 1)));
        let found = table.nodes().len() as f64;
        let (Some(below), Some(next)) = (below, next) else {
            return Err(InvalidParameter { name: "nodes", found, expected: "as many as the grid has" });
        };
        Ok(Self { layers: [below, next], above: at - layer as f64 })
    }

    fn node(&self, i: usize) -> [f64; F] {
        let [below, above] = self.layers.map(|layer| layer.get(i).copied().unwrap_or([T::ZERO; F]));
        core::array::from_fn(|k| below[k].to_f64() + self.above * (above[k].to_f64() - below[k].to_f64()))
    }

    /// Returns the largest size of each number of a node.
    fn largest(&self) -> [f64; F] {
        let mut largest = [0.0_f64; F];
        for i in 0..self.layers[0].len() {
            for (most, x) in largest.iter_mut().zip(self.node(i)) {
                // NaN stays.
                *most = if x.abs() <= *most { *most } else { x.abs() };
            }
        }
        largest
    }
}

/// Returns the directions of the balls of a bearing with the cage at angle 0. Those of a bearing within [`crate::bearing::Mirrored`] are as the
/// machine has them.
pub fn directions<T: Scalar, M: Math<T>, P: ElementLayout<T>, B: AsRef<[Node<T, F>]> + Send + Sync, const F: usize>(
    of: &Tabulated<T, M, P, B, F>,
    mirrored: bool,
) -> impl Iterator<Item = Direction> + '_ {
    of.positions().all().map(move |position| {
        let azimuth = if mirrored { position.mirrored().azimuth } else { position.azimuth };
        direction(azimuth, 0, 1)
    })
}

impl<const N: usize, A: AsRef<[[i32; F]]> + AsMut<[[i32; F]]>, const F: usize> TabulatedElements<[Direction; N], A, F> {
    /// Creates the bearing from one in floats, with its nodes in `nodes`.
    ///
    /// # Errors
    /// As [`TabulatedElements::with_directions`], and where the bearing has another number of balls than `N`.
    pub fn try_new<T: Scalar, M: Math<T>, P: ElementLayout<T>, B: AsRef<[Node<T, F>]> + Send + Sync>(
        of: &Tabulated<T, M, P, B, F>,
        params: &TabulatedParams,
        nodes: A,
    ) -> Result<Self, InvalidParameter> {
        let count = of.positions().all().count();
        check(count == N, "elements", count as f64, "the number in the type")?;
        let mut all = directions(of, params.mirrored);
        let directions = core::array::from_fn(|_| all.next().unwrap_or_default());
        drop(all);
        Self::with_directions(directions, of, params, nodes)
    }
}

impl<D: AsRef<[Direction]>, A: AsRef<[[i32; F]]> + AsMut<[[i32; F]]>, const F: usize> TabulatedElements<D, A, F> {
    /// Creates the bearing from the table of one in floats, with balls in these directions and its nodes in `nodes`: as many as approach and angle
    /// have.
    ///
    /// # Errors
    /// A speed outside the table; a range, offset, approach or number of nodes that the integers do not hold; another length of `nodes`; no or more
    /// than 64 elements; two or three numbers in a node only.
    pub fn with_directions<T: Scalar, M: Math<T>, P: ElementLayout<T>, B: AsRef<[Node<T, F>]> + Send + Sync>(
        directions: D,
        of: &Tabulated<T, M, P, B, F>,
        params: &TabulatedParams,
        mut nodes: A,
    ) -> Result<Self, InvalidParameter> {
        let TabulatedParams { speed, range, mirrored } = *params;
        let (grid, constants) = (of.table().grid().rounded::<f64>(), of.constants().rounded::<f64>());
        let Units { lines, cube } = Units::of(&constants, &grid, range)?;
        let [least, most] = grid.angle.range;
        check((-1.01..=most).contains(&least) && most <= 1.01, "angle", most, "sines from -1 to 1")?;
        check(constants.arm >= 0.0, "arm", constants.arm, "0 m or more")?;
        let table = AtSpeed::of(of.table(), &grid, speed)?;
        let length = nodes.as_ref().len();
        check(
            length == table.layers[0].len(),
            "nodes",
            length as f64,
            "nodes along the approach times those along the angle",
        )?;
        let count = directions.as_ref().len();
        check((1..=64).contains(&count), "elements", count as f64, "1 to 64")?;
        let scales = Scales::of(&table.largest(), cube, count)?;
        for (i, node) in nodes.as_mut().iter_mut().enumerate() {
            for (k, (entry, x)) in node.iter_mut().zip(table.node(i)).enumerate() {
                *entry = libm::round(x * scales.per_unit(k)) as i32;
            }
        }
        let tangent_shift = 30 - scales.tangent_exponent;
        Ok(Self {
            directions,
            nodes,
            lines,
            approach: Coordinate::of(&grid.approach, 30)?,
            angle: Coordinate::of(&grid.angle, 29)?,
            sines: grid.angle.range.map(|sine| libm::round(sine * HALF) as i32),
            columns: grid.approach.count,
            load_shift: 2 + scales.count_exponent,
            tangent_shift,
            largest_across: 1 << (27 - scales.count_exponent),
            friction: scales.friction(constants.couple)?,
            sense: if mirrored { -1 } else { 1 },
            metres_per_count: 0.5 * range / WHOLE,
            newtons_per_count: scales.newtons_per_count(),
            arm: constants.arm,
        })
    }
}

/// Units of the numbers of a node.
struct Scales {
    /// Load at the largest number of a node and the largest approach, N.
    load: f64,
    largest: [f64; 3],
    /// Powers of 2 that no tangent and no number of balls exceeds.
    tangent_exponent: u32,
    count_exponent: u32,
}

impl Scales {
    fn of<const F: usize>(largest: &[f64; F], cube: f64, count: usize) -> Result<Self, InvalidParameter> {
        check(F == 2 || F == 3, "numbers of a node", F as f64, "2 or 3")?;
        let of = |k: usize| largest.get(k).copied().unwrap_or(0.0);
        let largest = core::array::from_fn(of);
        let [half_load, tangent, friction] = largest;
        let load = 2.0 * half_load * cube;
        check(load > 0.0 && load.is_finite(), "load", load, "above 0 N and finite")?;
        check((0.0..128.0).contains(&tangent), "tangent", tangent, "below 128")?;
        check((0.0..=load / 16.0).contains(&friction), "friction", friction, "at most 1/16 of the largest load")?;
        let tangent_exponent = (1..8).find(|&bits| tangent < f64::from(1 << bits)).unwrap_or(7);
        // With 16 or more, a load of 2^27 counts over their number times the largest tangent is below 2^31.
        let count_exponent = count.next_power_of_two().trailing_zeros().max(4);
        Ok(Self { load, largest, tangent_exponent, count_exponent })
    }

    fn newtons_per_count(&self) -> f64 {
        libm::scalbn(self.load, self.count_exponent as i32 - 27)
    }

    /// Returns 2^30 over the unit of number `k` of a node.
    fn per_unit(&self, k: usize) -> f64 {
        let unit = match k {
            1 => f64::from(1 << self.tangent_exponent),
            _ => self.largest.get(k).copied().filter(|most| *most > 0.0).unwrap_or(1.0),
        };
        WHOLE / unit
    }

    fn friction(&self, couple: f64) -> Result<Friction, InvalidParameter> {
        let root = couple * core::f64::consts::SQRT_2 * f64::from(1 << self.tangent_exponent);
        check(root.abs() < 32.0, "couple", couple, "below 32 with the largest tangent")?;
        let [.., friction] = self.largest;
        Ok(Friction {
            largest: libm::round(friction / self.newtons_per_count()) as i32,
            one: 1 << (30 - 2 * self.tangent_exponent),
            couple: libm::round(libm::scalbn(root, 20)) as i32,
        })
    }
}
