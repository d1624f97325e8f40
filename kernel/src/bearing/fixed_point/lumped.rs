//! Radial and axial elements with `F = K Delta^n`, as [`crate::bearing::lumped`] has them.
//!
//! The power law is `Delta = m 2^-k` with `m` in a table of 128 straight lines: a relative error of at most `n (n - 1) / 130 000`, 5.7e-6 of a
//! ball and 1e-6 of a roller, beside the rounding to counts.

use super::arithmetic::{
    Direction, ONE, Turn, direction, normalised, positive_part, product, product_unsigned, status_at,
};
use crate::bearing::geometry::{InvalidParameter, check};
use crate::phase::Phase;
use crate::status::Status;

/// Straight lines of the power law between two powers of 2.
const LINES: usize = 128;

/// A bearing of `N` radial elements between rigid rings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RadialParams {
    /// K, N/m^n.
    pub stiffness: f64,
    /// n, 1 to 2: 3/2 of balls, 10/9 of rollers.
    pub exponent: f64,
    /// Radial play, m: half the diametral clearance; negative is preload.
    pub radial_play: f64,
    /// Displacement of 2^31 counts, m: the largest that the converter delivers, so that no reading overflows. A count of the force is that of all
    /// elements at twice the range, over 2^30.
    pub range: f64,
}

/// Radial elements on counts, `N` of them.
///
/// ```
/// use ballrace::bearing::fixed_point::{Radial, RadialParams};
/// use ballrace::{Phase, Status};
///
/// // Eight balls, 1 um of play; a ball that is pressed by 1 um carries 8e9 N/m^1.5 * (1 um)^1.5 = 8 N.
/// let params = RadialParams { stiffness: 8e9, exponent: 1.5, radial_play: 1e-6, range: 100e-6 };
/// let bearing = Radial::<8>::try_new(Phase::ZERO, &params)?;
/// let u = (2e-6 / bearing.metres_per_count()) as i32;
/// let force = bearing.reaction(u, 0, Phase::ZERO);
/// // And its neighbours by 0.41 um.
/// assert!((f64::from(force.fx) * bearing.newtons_per_count() + 11.02).abs() < 0.01);
/// assert!(force.status == Status::OK && force.fy.abs() < 10);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
///
/// Cost without a floating-point unit: `docs/src/performance.md`; about 660 bytes of constants beside 8 per element.
pub type Radial<const N: usize> = RadialElements<[Direction; N]>;

/// Radial elements with the directions `D`: an array, whose length is in the type, or what holds as many as are known at run time.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialElements<D> {
    directions: D,
    /// Play over the range, in units of 2^-30.
    play: i32,
    law: ElementLaw,
    metres_per_count: f64,
    newtons_per_count: f64,
}

/// A bearing of axial elements between rigid rings, in parallel to the radial ones of a combined bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxialParams {
    /// K, N/m^n.
    pub stiffness: f64,
    /// n, 1 to 2: 3/2 of balls, 10/9 of rollers.
    pub exponent: f64,
    /// Axial play, m; negative is preload.
    pub axial_play: f64,
    /// Radius at which the elements act, m.
    pub radius: f64,
    /// Displacement of 2^31 counts, m. A count of the force is that of all elements at four times the range, over 2^30.
    pub range: f64,
}

/// Axial elements on counts, `N` of them, loaded where the inner ring moves towards +Z.
///
/// ```
/// use ballrace::Phase;
/// use ballrace::bearing::fixed_point::{Axial, AxialParams};
///
/// let params = AxialParams { stiffness: 1e9, exponent: 1.5, axial_play: 1e-6, radius: 20e-3, range: 200e-6 };
/// let bearing = Axial::<8>::try_new(Phase::ZERO, &params)?;
/// // Without tilt all balls carry alike: 8e9 N/m^1.5 * (4 um)^1.5 = 64 N.
/// let w = (5e-6 / bearing.metres_per_count()) as i32;
/// let force = bearing.reaction(w, 0, 0, Phase::ZERO);
/// assert!((f64::from(force.fz) * bearing.newtons_per_count() + 64.0).abs() < 0.01);
/// assert!(force.mx.abs() < 10 && force.my.abs() < 10);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
pub type Axial<const N: usize> = AxialElements<[Direction; N]>;

/// Axial elements with the directions `D`.
#[derive(Debug, Clone, PartialEq)]
pub struct AxialElements<D> {
    directions: D,
    /// Play over the range, in units of 2^-29.
    play: i32,
    law: ElementLaw,
    metres_per_count: f64,
    newtons_per_count: f64,
    radius: f64,
}

/// `F = K Delta^n` of one element.
#[derive(Debug, Clone, PartialEq)]
struct ElementLaw {
    /// `m^n` at the ends of the lines, m from 1/2 to 1, in units of 2^-31.
    shape: [u32; LINES + 1],
    /// `2^(-n k)` over the number of elements for each k, in units of 2^-31.
    scale: [u32; 32],
}

/// Force of axial elements on the inner ring, in counts; the moments over the radius.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxialReaction {
    /// Force along Z.
    pub fz: i32,
    /// Moment about X, in counts of [`AxialElements::newton_metres_per_count`].
    pub mx: i32,
    /// Moment about Y, in counts of [`AxialElements::newton_metres_per_count`].
    pub my: i32,
    /// [`Status::CONTACT_LOST`] without contact.
    pub status: Status,
}

/// Force of radial elements on the inner ring, in counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reaction {
    /// Force along X.
    pub fx: i32,
    /// Force along Y.
    pub fy: i32,
    /// Sum of the element loads; 0 without contact.
    pub load: i32,
    /// [`Status::CONTACT_LOST`] without contact.
    pub status: Status,
}

impl<const N: usize> Radial<N> {
    /// Creates the bearing with evenly spaced elements, the first at `first`. For set-up: uses `f64` and `libm`.
    ///
    /// # Errors
    /// As [`RadialElements::with_directions`].
    pub fn try_new(first: Phase, of: &RadialParams) -> Result<Self, InvalidParameter> {
        Self::with_directions(core::array::from_fn(|j| direction(first, j, N)), of)
    }
}

impl<D: AsRef<[Direction]>> RadialElements<D> {
    /// Creates the bearing with elements in these directions. For set-up: uses `f64` and `libm`.
    ///
    /// # Errors
    /// A stiffness or range that is not above 0, an exponent outside 1 to 2, a play above a quarter of the range, no elements.
    pub fn with_directions(directions: D, of: &RadialParams) -> Result<Self, InvalidParameter> {
        let RadialParams { stiffness, exponent, radial_play, range } = *of;
        check(range > 0.0, "range", range, "above 0 m")?;
        check(radial_play.abs() <= 0.25 * range, "radial_play", radial_play, "at most a quarter of the range")?;
        // The deflection of 2^31 counts is twice the range.
        let (law, newtons_per_count) =
            ElementLaw::try_new((stiffness, exponent), 2.0 * range, directions.as_ref().len())?;
        let play = libm::round(radial_play / range * ONE) as i32;
        Ok(Self { directions, play, law, metres_per_count: 0.5 * range / ONE, newtons_per_count })
    }

    /// Returns the displacement of one count, m.
    #[must_use]
    pub const fn metres_per_count(&self) -> f64 {
        self.metres_per_count
    }

    /// Returns the force of one count, N.
    #[must_use]
    pub const fn newtons_per_count(&self) -> f64 {
        self.newtons_per_count
    }

    /// Computes the force on the inner ring at the displacement `u` along X and `v` along Y, in counts of [`RadialElements::metres_per_count`]; any
    /// counts are valid.
    #[must_use]
    pub fn reaction(&self, u: i32, v: i32, cage: Phase) -> Reaction {
        let turn = Turn::of(cage);
        // In the frame of the cage, and in units of 2^-30 of the range.
        let [x, y] = turn.to_cage([u, v]).map(|x| (x >> 31) as i32);
        let (mut sum_x, mut sum_y, mut load) = (0, 0, 0_u32);
        for &[cos, sin] in self.directions.as_ref() {
            let deflection = ((product(x, cos) + product(y, sin)) >> 30) as i32 - self.play;
            let of_element = self.law.load(positive_part(deflection));
            sum_x += product(of_element as i32, cos);
            sum_y += product(of_element as i32, sin);
            load += of_element;
        }
        let [fx, fy] = turn.to_housing([sum_x, sum_y].map(|x| (x >> 30) as i32)).map(|x| -(x >> 30) as i32);
        Reaction { fx, fy, load: load as i32, status: status_at(load) }
    }
}

impl<const N: usize> Axial<N> {
    /// Creates the bearing with evenly spaced elements, the first at `first`. For set-up: uses `f64` and `libm`.
    ///
    /// # Errors
    /// As [`AxialElements::with_directions`].
    pub fn try_new(first: Phase, of: &AxialParams) -> Result<Self, InvalidParameter> {
        Self::with_directions(core::array::from_fn(|j| direction(first, j, N)), of)
    }
}

impl<D: AsRef<[Direction]>> AxialElements<D> {
    /// Creates the bearing with elements in these directions. For set-up: uses `f64` and `libm`.
    ///
    /// # Errors
    /// A stiffness or range that is not above 0, an exponent outside 1 to 2, a play above a quarter of the range, a negative radius, no elements.
    pub fn with_directions(directions: D, of: &AxialParams) -> Result<Self, InvalidParameter> {
        let AxialParams { stiffness, exponent, axial_play, radius, range } = *of;
        check(range > 0.0, "range", range, "above 0 m")?;
        check(axial_play.abs() <= 0.25 * range, "axial_play", axial_play, "at most a quarter of the range")?;
        check(radius >= 0.0, "radius", radius, "0 m or more")?;
        // Displacement and tilt along one axis: the deflection of 2^31 counts is four times the range.
        let (law, newtons_per_count) =
            ElementLaw::try_new((stiffness, exponent), 4.0 * range, directions.as_ref().len())?;
        let play = libm::round(axial_play / range * 0.5 * ONE) as i32;
        Ok(Self { directions, play, law, metres_per_count: 0.5 * range / ONE, newtons_per_count, radius })
    }

    /// Returns the displacement of one count, m; that of the tilts is at the radius.
    #[must_use]
    pub const fn metres_per_count(&self) -> f64 {
        self.metres_per_count
    }

    /// Returns the force of one count, N.
    #[must_use]
    pub const fn newtons_per_count(&self) -> f64 {
        self.newtons_per_count
    }

    /// Returns the moment of one count, N m.
    #[must_use]
    pub const fn newton_metres_per_count(&self) -> f64 {
        self.newtons_per_count * self.radius
    }

    /// Computes force and moment on the inner ring at the displacement `w` along Z and the tilts about X and Y times the radius, in counts
    /// of [`AxialElements::metres_per_count`]; any counts are valid.
    #[must_use]
    pub fn reaction(&self, w: i32, tilt_x: i32, tilt_y: i32, cage: Phase) -> AxialReaction {
        let turn = Turn::of(cage);
        // In the frame of the cage, and in units of 2^-29 of the range.
        let [x, y] = turn.to_cage([tilt_x, tilt_y]).map(|x| (x >> 32) as i32);
        let from_play = (w >> 2) - self.play;
        let (mut sum_x, mut sum_y, mut load) = (0, 0, 0_u32);
        for &[cos, sin] in self.directions.as_ref() {
            let deflection = from_play + ((product(x, sin) - product(y, cos)) >> 30) as i32;
            let of_element = self.law.load(positive_part(deflection));
            sum_x += product(of_element as i32, sin);
            sum_y -= product(of_element as i32, cos);
            load += of_element;
        }
        let [mx, my] = turn.to_housing([sum_x, sum_y].map(|x| (x >> 30) as i32)).map(|x| -(x >> 30) as i32);
        AxialReaction { fz: -(load as i32), mx, my, status: status_at(load) }
    }
}

impl ElementLaw {
    /// Returns the law, and the force of all elements at the deflection `largest` over 2^30. For set-up.
    fn try_new((stiffness, exponent): (f64, f64), largest: f64, count: usize) -> Result<(Self, f64), InvalidParameter> {
        check(stiffness > 0.0, "stiffness", stiffness, "above 0")?;
        check((1.0..=2.0).contains(&exponent), "exponent", exponent, "1 to 2")?;
        let count = count as f64;
        check(count > 0.0, "elements", count, "1 or more")?;
        let force = stiffness * libm::pow(largest, exponent) * count;
        check(force.is_finite(), "stiffness", stiffness, "one whose force at the range is finite")?;
        let line = |i: usize| libm::pow(0.5 + 0.5 * i as f64 / LINES as f64, exponent);
        let step = |k: usize| libm::pow(0.5, exponent * k as f64) / count;
        let law = Self {
            shape: core::array::from_fn(|i| libm::round(line(i) * 2.0 * ONE) as u32),
            // Only the deflection 0 is shifted by 31.
            scale: core::array::from_fn(|k| if k < 31 { libm::round(step(k) * 2.0 * ONE) as u32 } else { 0 }),
        };
        Ok((law, force / ONE))
    }

    /// Returns the load of an element at a deflection below 2^31, in units of 2^-30 of all elements at 2^31.
    #[inline(always)]
    fn load(&self, deflection: u32) -> u32 {
        let (mantissa, k) = normalised(deflection);
        let line = (mantissa >> 23) as usize & (LINES - 1);
        let along = (mantissa >> 7) & 0xffff;
        let [from, to] = [self.shape[line], self.shape[line + 1]];
        let shape = from + ((((to - from) >> 9) * along) >> 7);
        (product_unsigned(shape, self.scale[k as usize & 31]) >> 32) as u32
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::bearing::fixed_point::arithmetic::numbers;
    use crate::bearing::lumped;
    use crate::bearing::{Bearing, evenly_spaced};
    use crate::contact::law::PowerLaw;
    use crate::frame::Displacement;
    use crate::math::Exact;

    /// The force is that of the model in `f64`, to the stated share of the sum of the loads and two counts per element.
    #[test]
    fn the_force_is_that_of_the_lumped_model() {
        for (exponent, stiffness, share) in [(1.5, 8e9, 6e-6), (10.0 / 9.0, 3e8, 1.5e-6), (1.0, 1e8, 3e-7)] {
            for radial_play in [5e-6, 0.0, -3e-6] {
                let params = RadialParams { stiffness, exponent, radial_play, range: 100e-6 };
                let fixed = Radial::<9>::try_new(Phase::from_revolutions(0.1), &params).unwrap();
                let positions = evenly_spaced::<f64, 9>(Phase::from_revolutions(0.1));
                let law = PowerLaw { stiffness, exponent };
                let float = lumped::Radial::<f64, Exact, _, _>::try_new(positions, law, radial_play).unwrap();
                let (mut number, per_count) = (numbers(), fixed.newtons_per_count());
                for i in 0..3000 {
                    // Motions of all sizes, up to the range.
                    let (size, angle) = (100e-6 * libm::pow(10.0, -4.0 * number()), core::f64::consts::TAU * number());
                    let counts = [libm::cos(angle), libm::sin(angle)]
                        .map(|x| (0.999 * size * x / fixed.metres_per_count()) as i32);
                    let cage = Phase::from_revolutions(number());
                    let [u, v] = counts.map(|x| f64::from(x) * fixed.metres_per_count());
                    let expected = float.reaction(&Displacement { u, v, ..Displacement::default() }, &cage.into());
                    let found = fixed.reaction(counts[0], counts[1], cage);
                    // The sine is off by 1e-8 of the displacement, which the stiffness amplifies.
                    let allowed = share * expected.load
                        + 20.0 * per_count
                        + 1e-7 * float_stiffness(stiffness, exponent, size) * size;
                    for (found, expected) in
                        [(found.fx, expected.wrench.fx), (found.fy, expected.wrench.fy), (found.load, expected.load)]
                    {
                        let found = f64::from(found) * per_count;
                        assert!((found - expected).abs() < allowed, "{i}: {size:e} m: {found} {expected} +-{allowed}");
                    }
                    let lost = expected.load == 0.0;
                    assert!(found.status.contains(Status::CONTACT_LOST) || !lost || found.load <= 9);
                }
            }
        }
    }

    /// Force and moment are those of the model in `f64`, to the share of the radial ones.
    #[test]
    fn the_axial_force_is_that_of_the_lumped_model() {
        for (exponent, stiffness, share) in [(1.5, 1e9, 6e-6), (10.0 / 9.0, 3e8, 1.5e-6)] {
            for axial_play in [5e-6, -3e-6] {
                let (radius, range) = (20e-3, 100e-6);
                let params = AxialParams { stiffness, exponent, axial_play, radius, range };
                let fixed = Axial::<9>::try_new(Phase::from_revolutions(0.1), &params).unwrap();
                let positions = evenly_spaced::<f64, 9>(Phase::from_revolutions(0.1));
                let law = PowerLaw { stiffness, exponent };
                let float = lumped::Axial::<f64, Exact, _, _>::try_new(positions, law, axial_play, radius).unwrap();
                let mut number = numbers();
                for i in 0..3000 {
                    let size = range * libm::pow(10.0, -4.0 * number());
                    let counts = [0; 3].map(|_: i32| ((2.0 * number() - 1.0) * size / fixed.metres_per_count()) as i32);
                    let cage = Phase::from_revolutions(number());
                    let [w, thu, thv] = counts.map(|x| f64::from(x) * fixed.metres_per_count());
                    let u = Displacement { w, thu: thu / radius, thv: thv / radius, ..Displacement::default() };
                    let expected = float.reaction(&u, &cage.into());
                    let [w, x, y] = counts;
                    let found = fixed.reaction(w, x, y, cage);
                    let allowed = share * expected.load
                        + 30.0 * fixed.newtons_per_count()
                        + (1e-7 * size + 4.0 * fixed.metres_per_count()) * float_stiffness(stiffness, exponent, size);
                    let (force, moment) = (fixed.newtons_per_count(), fixed.newton_metres_per_count());
                    for (found, expected, allowed) in [
                        (f64::from(found.fz) * force, expected.wrench.fz, allowed),
                        (f64::from(found.mx) * moment, expected.wrench.mx, allowed * radius),
                        (f64::from(found.my) * moment, expected.wrench.my, allowed * radius),
                    ] {
                        assert!((found - expected).abs() < allowed, "{i}: {size:e} m: {found} {expected} +-{allowed}");
                    }
                }
            }
        }
    }

    fn float_stiffness(stiffness: f64, exponent: f64, size: f64) -> f64 {
        9.0 * exponent * stiffness * libm::pow(2.0 * size, exponent - 1.0)
    }

    /// No counts overflow, and the force stays within its own.
    #[test]
    fn any_counts_have_a_force() {
        for radial_play in [25e-6, -25e-6] {
            let params = RadialParams { stiffness: 8e9, exponent: 1.5, radial_play, range: 100e-6 };
            let bearing = Radial::<1>::try_new(Phase::ZERO, &params).unwrap();
            let RadialParams { stiffness, exponent, radial_play: axial_play, range } = params;
            let params = AxialParams { stiffness, exponent, axial_play, radius: 20e-3, range };
            let axial = Axial::<1>::try_new(Phase::ZERO, &params).unwrap();
            for u in [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX] {
                for v in [i32::MIN, -1, 0, i32::MAX] {
                    for eighth in 0..8 {
                        let force = bearing.reaction(u, v, Phase(eighth << 61));
                        assert!((0..=1 << 30).contains(&force.load), "{u} {v} {eighth}: {force:?}");
                        assert_eq!(force.status == Status::CONTACT_LOST, force.load == 0);
                        for w in [i32::MIN, 0, i32::MAX] {
                            let force = axial.reaction(w, u, v, Phase(eighth << 61));
                            assert!((-(1 << 30)..=0).contains(&force.fz), "{w} {u} {v} {eighth}: {force:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_constants_have_the_documented_size() {
        assert!(size_of::<Radial<9>>().abs_diff(660 + 8 * 9) <= 8, "{}", size_of::<Radial<9>>());
    }

    #[test]
    fn impossible_parameters_are_rejected() {
        let params = RadialParams { stiffness: 8e9, exponent: 1.5, radial_play: 0.0, range: 100e-6 };
        for (params, name) in [
            (RadialParams { stiffness: f64::NAN, ..params }, "stiffness"),
            (RadialParams { stiffness: 1e308, exponent: 1.0, range: 1e6, ..params }, "stiffness"),
            (RadialParams { exponent: 0.9, ..params }, "exponent"),
            (RadialParams { range: 0.0, ..params }, "range"),
            (RadialParams { radial_play: 26e-6, ..params }, "radial_play"),
        ] {
            assert_eq!(Radial::<8>::try_new(Phase::ZERO, &params).unwrap_err().name, name);
        }
        assert_eq!(Radial::<0>::try_new(Phase::ZERO, &params).unwrap_err().name, "elements");
    }
}
