//! Model `lumped`: separate radial and axial elements between a rigid inner ring and a rigid or flexible outer ring
//! (Hajzman).
//!
//! `F = K Delta^n` for `Delta > 0`, radial `Delta = t^T q - e^T q_S - gamma`, axial likewise, with the play `gamma`
//! (negative: preload) and the displacement `q_S` of the housing at the contact point of each element (Hajzman, eq. 1 to
//! 5). Exponent and math backend are types.

use super::element_position::{ElementLayout, ElementPosition};
use super::elements::{CageFrame, Elements};
use super::geometry::{InvalidParameter, check};
use super::ring::{CageRotation, Contact, ContactStiffness, Motion, RadialSum, Ring, WrenchSum, radial};
use super::surface::{ElementDeviation, Smooth, Surface};
use super::{Reaction, bearing_in_cage};
use crate::contact::law::LoadDeflectionLaw;
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;
use core::marker::PhantomData;
use core::ops::{Add, Sub};

/// Radial elements: a radial ball or roller bearing.
///
/// With [`super::OpposedPairs`] two opposed elements share one power: without preload at most one of them is loaded.
///
/// ```
/// use ballrace::bearing::{Bearing, evenly_spaced_pairs};
/// use ballrace::bearing::lumped::Radial;
/// use ballrace::contact::law::PointContactLaw;
/// use ballrace::{Displacement, Exact, Phase};
///
/// // Eight balls, 1 um of radial play. One ball is pressed by 1 um: 8e9 N/m^1.5 * (1 um)^1.5.
/// let positions = evenly_spaced_pairs::<f64, 4>(Phase::ZERO);
/// let bearing = Radial::<f64, Exact, _, _>::try_new(positions, PointContactLaw { stiffness: 8e9 }, 1e-6)?;
/// let u = Displacement { u: 2e-6, ..Displacement::default() };
/// let force = bearing.reaction(&u, &Phase::ZERO.into()).wrench;
/// assert!(force.fx < -8.0 && force.fy.abs() < 1e-12);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Radial<T, M, L, P, S = Smooth> {
    pub(super) ring: Ring<T, P>,
    pub(super) law: L,
    pub(super) play: T,
    surface: S,
    math: PhantomData<M>,
}

/// Axial elements: a thrust bearing, loaded when the inner ring moves towards +Z.
///
/// ```
/// use ballrace::bearing::{Bearing, evenly_spaced};
/// use ballrace::bearing::lumped::Axial;
/// use ballrace::contact::law::LineContactLaw;
/// use ballrace::{Displacement, Exact, Phase};
///
/// let positions = evenly_spaced::<f32, 12>(Phase::ZERO);
/// let bearing = Axial::<f32, Exact, _, _>::try_new(positions, LineContactLaw { stiffness: 3e8 }, 0.0, 20e-3)?;
/// let pushed = Displacement { w: 5e-6, ..Displacement::default() };
/// assert!(bearing.reaction(&pushed, &Phase::ZERO.into()).wrench.fz < 0.0);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Axial<T, M, L, P> {
    ring: Ring<T, P>,
    law: L,
    play: T,
    math: PhantomData<M>,
}

/// Radial and axial elements in parallel: a combined bearing, or any two bearings at one station with one cage.
#[derive(Debug, Clone, Copy)]
pub struct Combined<A, B>(pub A, pub B);

/// Checks a law by its load and slope at a deflection of 1 m, whose ratio is the exponent. For set-up.
fn check_law<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>(law: &L) -> Result<(), InvalidParameter> {
    let (load, slope) = law.unscaled_load_and_slope(T::ONE + T::ONE);
    let (stiffness, exponent) = (law.load(T::ONE).to_f64(), (slope / load).to_f64());
    check(exponent >= 1.0 - 1e-6, "exponent", exponent, "1 or more")?;
    check(stiffness > 0.0, "stiffness", stiffness, "above 0")
}

/// Largest play and interference, m: ten times the largest clearance of bearings with a bore of 1 m (ISO 5753-1, group 5).
pub const LARGEST_PLAY: f64 = 10e-3;

impl<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>> Radial<T, M, L, P> {
    /// Creates the bearing from element positions, law and radial play (m, half the diametral clearance; negative is
    /// preload).
    ///
    /// # Errors
    /// A law out of its range; a play above [`LARGEST_PLAY`]; a negative play with opposed pairs.
    pub fn try_new(positions: P, law: L, radial_play: f64) -> Result<Self, InvalidParameter> {
        check_law::<T, M, L>(&law)?;
        check(radial_play.abs() <= LARGEST_PLAY, "radial_play", radial_play, "-10 to 10 mm")?;
        check(!P::IS_PAIRED || radial_play >= 0.0, "radial_play", radial_play, "0 m or more with opposite pairs")?;
        Ok(Self::from_constants(positions, law, T::from_f64(radial_play)))
    }

    /// Creates the bearing from precomputed constants without checks.
    pub fn from_constants(positions: P, law: L, radial_play: T) -> Self {
        let ring = Ring { positions, arm: T::ZERO, scale: law.scale() };
        Self { ring, law, play: radial_play, surface: Smooth, math: PhantomData }
    }

    /// Returns the bearing with surface deviations; only radial ones have an effect.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Radial<T, M, L, P, S> {
        Radial { ring: self.ring, law: self.law, play: self.play, surface, math: PhantomData }
    }
}

impl<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>> Axial<T, M, L, P> {
    /// Creates the bearing from element positions, law, axial play (m) and the radius at which the elements act (m).
    ///
    /// # Errors
    /// A law out of its range; a play above [`LARGEST_PLAY`]; a radius that is negative or not finite.
    pub fn try_new(positions: P, law: L, axial_play: f64, radius: f64) -> Result<Self, InvalidParameter> {
        check_law::<T, M, L>(&law)?;
        check(axial_play.abs() <= LARGEST_PLAY, "axial play", axial_play, "-10 to 10 mm")?;
        check(radius >= 0.0, "axial radius", radius, "0 m or more")?;
        Ok(Self::from_constants(positions, law, T::from_f64(axial_play), T::from_f64(radius)))
    }

    /// Creates the bearing from precomputed constants without checks.
    pub fn from_constants(positions: P, law: L, axial_play: T, radius: T) -> Self {
        let ring = Ring { positions, arm: radius, scale: law.scale() };
        Self { ring, law, play: axial_play, math: PhantomData }
    }
}

/// Number of elements evaluated per iteration where they are not evaluated in stages; four independent powers hide the latency of the square
/// root.
const GROUP_SIZE: usize = 4;

impl<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>, S: Surface<T>> Radial<T, M, L, P, S> {
    /// Returns the radial displacement at which the element makes contact.
    #[inline(always)]
    fn gap(&self, azimuth: Phase, at: &BearingKinematicState<T>) -> T {
        if S::IS_SMOOTH { self.play } else { gap(self.play, self.surface.deviation(azimuth, at)) }
    }

    /// Returns twice the deflection of a stored element; of a pair, less that of the opposite element.
    #[inline(always)]
    fn signed(&self, position: &ElementPosition<T>, u: &Displacement<T>, at: &BearingKinematicState<T>) -> T {
        let radial = radial(position, u);
        let azimuth = position.azimuth.wrapping_add(at.cage);
        let here = (radial - self.gap(azimuth, at)).twice_positive_part();
        if P::IS_PAIRED { here + (radial + self.gap(azimuth.opposite(), at)).twice_negative_part() } else { here }
    }

    #[inline(always)]
    fn add_group<const K: usize>(
        &self,
        sum: &mut RadialSum<T>,
        group: &[ElementPosition<T>; K],
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) {
        let shapes = self.law.unscaled_load(group.each_ref().map(|position| self.signed(position, u, at)));
        for (position, shape) in group.iter().zip(shapes) {
            sum.add(position, shape);
        }
    }
}

/// Returns the radial displacement at which an element on an uneven surface makes contact; with `Lanes`, of several elements.
#[inline(always)]
fn gap<L: Copy + Add<Output = L> + Sub<Output = L>>(play: L, shape: ElementDeviation<L>) -> L {
    play - (shape.radial + shape.inner + shape.outer)
}

impl<T, M, L, P, S> Elements for Radial<T, M, L, P, S>
where
    T: Scalar,
    M: Math<T>,
    L: LoadDeflectionLaw<T, M>,
    P: ElementLayout<T>,
    S: Surface<T>,
{
    type Scalar = T;
    type Math = M;
    type ElementPositions = P;
    type Surface = S;
    #[inline(always)]
    fn surface(&self) -> &S {
        &self.surface
    }
    #[inline(always)]
    fn ring(&self) -> &Ring<T, P> {
        &self.ring
    }
    #[inline(always)]
    fn contacts<const K: usize>(&self, at: Motion<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let none = Lanes::splat(T::NEGATIVE_ZERO);
        let play = Lanes::splat(self.play);
        let deflection = at.radial - if S::IS_SMOOTH { play } else { gap(play, at.deviation) };
        let load = Lanes(self.law.unscaled_load(deflection.twice_positive_part().0));
        Contact { radial: load, axial: none, tilting: none, load }
    }
    #[inline(always)]
    fn contact_and_stiffness(&self, at: Motion<T>) -> (Contact<T>, ContactStiffness<T>) {
        let gap = if S::IS_SMOOTH { self.play } else { gap(self.play, at.deviation) };
        let (load, slope) = self.law.unscaled_load_and_slope((at.radial - gap).twice_positive_part());
        (
            Contact { radial: load, axial: T::NEGATIVE_ZERO, tilting: T::NEGATIVE_ZERO, load },
            ContactStiffness { radial: slope, cross: T::NEGATIVE_ZERO, axial: T::NEGATIVE_ZERO },
        )
    }
    #[inline(always)]
    fn sum(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let sum = if let Some(sum) = self.staged_sum(u, at, &mut []) {
            sum.radial()
        } else {
            let mut sum = RadialSum::new();
            let (groups, rest) = self.ring.positions.stored().as_chunks::<GROUP_SIZE>();
            for group in groups {
                self.add_group(&mut sum, group, u, at);
            }
            for position in rest {
                self.add_group(&mut sum, core::array::from_ref(position), u, at);
            }
            sum
        };
        sum.finish(self.ring.scale)
    }
    #[inline(always)]
    fn finish(&self, sum: &WrenchSum<T>) -> Reaction<T> {
        sum.radial().finish(self.ring.scale)
    }
}

impl<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>> Elements for Axial<T, M, L, P> {
    type Scalar = T;
    type Math = M;
    type ElementPositions = P;
    type Surface = Smooth;
    #[inline(always)]
    fn surface(&self) -> &Smooth {
        &Smooth
    }
    #[inline(always)]
    fn ring(&self) -> &Ring<T, P> {
        &self.ring
    }
    #[inline(always)]
    fn contacts<const K: usize>(&self, at: Motion<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let load = Lanes(self.law.unscaled_load((at.axial - Lanes::splat(self.play)).twice_positive_part().0));
        Contact { radial: Lanes::splat(T::NEGATIVE_ZERO), axial: load, tilting: load, load }
    }
    #[inline(always)]
    fn contact_and_stiffness(&self, at: Motion<T>) -> (Contact<T>, ContactStiffness<T>) {
        let (load, slope) = self.law.unscaled_load_and_slope((at.axial - self.play).twice_positive_part());
        (
            Contact { radial: T::NEGATIVE_ZERO, axial: load, tilting: load, load },
            ContactStiffness { radial: T::NEGATIVE_ZERO, cross: T::NEGATIVE_ZERO, axial: slope },
        )
    }
}

bearing_in_cage!(
    Radial<T, M, L, P, S>,
    T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>, S: Surface<T>
);
bearing_in_cage!(Axial<T, M, L, P>, T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>, P: ElementLayout<T>);
bearing_in_cage!(Combined<A, B>, T: Scalar, A: CageFrame<T> + Send + Sync, B: CageFrame<T> + Send + Sync);

impl<T: Scalar, A: CageFrame<T>, B: CageFrame<T>> CageFrame<T> for Combined<A, B> {
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<T> {
        A::cage_rotation(cage)
    }
    #[inline(always)]
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.0.reaction_in_cage_frame(u, at) + self.1.reaction_in_cage_frame(u, at)
    }
    #[inline(always)]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (a, ka) = self.0.reaction_and_stiffness_in_cage_frame(u, at, turn);
        let (b, kb) = self.1.reaction_and_stiffness_in_cage_frame(u, at, turn);
        (a + b, ka + kb)
    }
    /// Writes the loads of the first bearing only: one entry per element.
    #[inline(always)]
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.0.element_loads_in_cage_frame(u, at, loads);
    }
    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        self.0.reaction_and_loads_in_cage_frame(u, at, loads) + self.1.reaction_in_cage_frame(u, at)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::bearing::evenly_spaced;
    use crate::contact::law::{PointContactLaw, PowerLaw};

    type Point<T> = Radial<T, crate::Exact, PointContactLaw<T>, [ElementPosition<T>; 8]>;
    type Power = Radial<f32, crate::Exact, PowerLaw<f32>, [ElementPosition<f32>; 8]>;

    fn rejected<T: core::fmt::Debug>(made: Result<T, InvalidParameter>) -> &'static str {
        made.unwrap_err().name
    }

    /// What no bearing can have is an error at set-up.
    #[test]
    fn impossible_constants_are_rejected() {
        for stiffness in [0.0, -8e9, f32::NAN, f32::INFINITY] {
            let made = Point::<f32>::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness }, 2e-6);
            assert_eq!(rejected(made), "stiffness", "{stiffness}");
        }
        for play in [5.0, -0.02, f64::NAN, f64::INFINITY] {
            let made = Point::<f64>::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness: 8e9 }, play);
            assert_eq!(rejected(made), "radial_play", "{play}");
        }
        for exponent in [0.5, f32::NAN] {
            let law = PowerLaw { stiffness: 8e9, exponent };
            assert_eq!(rejected(Power::try_new(evenly_spaced(Phase::ZERO), law, 0.0)), "exponent", "{exponent}");
        }
        assert!(Power::try_new(evenly_spaced(Phase::ZERO), PowerLaw { stiffness: 8e9, exponent: 1.0 }, -1e-5).is_ok());
    }
}
