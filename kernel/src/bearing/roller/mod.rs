//! Model `roller`: rollers divided into laminae between two rigid rings (`docs/src/models.md#rollers-by-laminae`).
//!
//! Both contacts of a lamina are in series; its deflection at the azimuth `phi` is
//!
//! ```text
//! delta_k = (u cos phi + v sin phi) cos a + (w + R (thu sin phi - thv cos phi)) sin a
//!         + x_k (thv cos phi - thu sin phi) - gamma cos a - 2 P(x_k)
//! ```
//!
//! with the contact angle `a`, the pitch radius `R`, the radial play `gamma` and the profile drop `P`. Its load is `q_k = (K/n)
//! delta_k^(10/9)` for `delta_k > 0`. The force on the ring has a potential; its stiffness is symmetric.
//!
//! [`QuasiStaticRoller`] has the equilibrium of each roller with its centrifugal force.
//!
//! Source: ISO/TS 16281:2008, with the line contact of Palmgren; de Mul, Vree and Maas, Journal of Tribology 111 (1989).

mod equilibrium;
mod lamina;

pub use equilibrium::{DEFAULT_ROLLER_STEPS, QuasiStaticRoller, RollerInertia};
pub use lamina::{CYLINDRICAL_PROFILE, Lamina, RollerProfile, TAPERED_PROFILE, laminae};

use super::element_position::{BLOCK_SIZE, ElementBlock, ElementLayout, PaddedGroup, padded_groups};
use super::elements::CageFrame;
use super::geometry::{InvalidParameter, check};
use super::ring::{CageRotation, Contact, Motion, Ring, StiffnessSum, TiltingStiffness, WrenchSum, to_cage_frame};
use super::surface::{Smooth, Surface};
use super::{Reaction, bearing_in_cage};
use crate::contact::law::{LineContactLaw, LoadDeflectionLaw};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::Lanes;
use crate::phase::Phase;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Parameters of a roller bearing, without its elements and laminae.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RollerBearingParams {
    /// d_m, pitch diameter, m, above 0.
    pub pitch_diameter: f64,
    /// a, contact angle, rad, 0 or more, below pi/2; of tapered rollers, that of the outer race.
    pub contact_angle: f64,
    /// gamma, radial play, m: half the diametral clearance; negative is preload.
    pub radial_play: f64,
    /// K, stiffness of one roller with both contacts in series, N/m^(10/9), above 0:
    /// [`roller_stiffness`](crate::contact::line::roller_stiffness) of steel.
    pub stiffness: f64,
}

/// Precomputed constants of a [`LaminaRoller`] bearing, without elements and laminae.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollerConstants<T> {
    /// K/n, stiffness of one lamina with both contacts in series, N/m^(10/9).
    pub stiffness: T,
    /// R, pitch radius, m.
    pub arm: T,
    /// `cos a` and `sin a`.
    pub axis: [T; 2],
    /// `gamma cos a`, play along the line of contact, m.
    pub play: T,
}

impl RollerConstants<f64> {
    /// Computes the constants of rollers with `count` laminae. For set-up.
    ///
    /// # Errors
    /// A parameter outside its range; no lamina.
    pub fn try_new(params: &RollerBearingParams, count: usize) -> Result<Self, InvalidParameter> {
        let &RollerBearingParams { pitch_diameter, contact_angle, radial_play, stiffness } = params;
        check(count > 0, "laminae", count as f64, "1 or more")?;
        check(pitch_diameter > 0.0, "pitch_diameter", pitch_diameter, "above 0 m")?;
        let allowed = (0.0..core::f64::consts::FRAC_PI_2).contains(&contact_angle);
        check(allowed, "contact_angle", contact_angle, "0 or more, below pi/2 rad")?;
        check(true, "radial_play", radial_play, "a finite length")?;
        check(stiffness > 0.0, "stiffness", stiffness, "above 0 N/m^(10/9)")?;
        let axis = [libm::cos(contact_angle), libm::sin(contact_angle)];
        let [cos, _] = axis;
        Ok(Self { stiffness: stiffness / count as f64, arm: 0.5 * pitch_diameter, axis, play: radial_play * cos })
    }

    /// Returns the constants in another precision.
    #[must_use]
    pub fn rounded<T: Scalar>(&self) -> RollerConstants<T> {
        RollerConstants {
            stiffness: T::from_f64(self.stiffness),
            arm: T::from_f64(self.arm),
            axis: self.axis.map(T::from_f64),
            play: T::from_f64(self.play),
        }
    }
}

/// Load of one contact of a roller.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RollerContact<T> {
    /// Sum of the loads of the laminae, N.
    pub load: T,
    /// `sum x_k q_k`, moment of the loads about the centre of the roller, N m.
    pub moment: T,
    /// Largest load of a lamina, N.
    pub largest_lamina_load: T,
}

/// Both contacts of a roller.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RollerState<T> {
    /// At the inner race.
    pub inner: RollerContact<T>,
    /// At the outer race.
    pub outer: RollerContact<T>,
    /// Tilt of the roller relative to the outer ring, rad; in series half of that of the inner ring.
    pub tilt: T,
}

/// A bearing with rollers by laminae `A`, both contacts in series. Cost per lamina: one ninth root.
///
/// With an array of laminae the number is a constant; a slice or a vector has it at run time. Waviness and damage change the
/// deflection of all laminae of a roller alike.
///
/// ```
/// use ballrace::bearing::roller::{RollerBearingParams, RollerProfile, laminae};
/// use ballrace::bearing::{Bearing, evenly_spaced};
/// use ballrace::contact::line::roller_stiffness;
/// use ballrace::{Displacement, Phase, RollerBearing};
///
/// // NU205-like: 13 rollers of 7.5 mm, ISO/TS 16281 profile, tilted by 0.5 mrad.
/// let params = RollerBearingParams {
///     pitch_diameter: 38.5e-3,
///     contact_angle: 0.0,
///     radial_play: 10e-6,
///     stiffness: roller_stiffness(7.5e-3),
/// };
/// let slices = laminae(7.5e-3, &RollerProfile::Logarithmic { coefficient: 0.00035 * 7.5e-3 })?;
/// let bearing = RollerBearing::<f64, 13, 21>::try_new(&params, evenly_spaced(Phase::ZERO), slices)?;
/// let tilted = Displacement { u: 25e-6, thv: 0.5e-3, ..Displacement::default() };
/// let force = bearing.reaction(&tilted, &Phase::ZERO.into()).wrench;
/// assert!(force.fx < 0.0 && force.my < 0.0);
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LaminaRoller<T, M, P, A, S = Smooth> {
    ring: Ring<T, P>,
    law: LineContactLaw<T>,
    axis: [T; 2],
    play: T,
    laminae: A,
    surface: S,
    math: PhantomData<M>,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync> LaminaRoller<T, M, P, A> {
    /// Creates the bearing from its parameters, positions and laminae. For set-up.
    ///
    /// # Errors
    /// As [`RollerConstants::try_new`].
    pub fn try_new(params: &RollerBearingParams, positions: P, laminae: A) -> Result<Self, InvalidParameter> {
        let constants = RollerConstants::try_new(params, laminae.as_ref().len())?;
        Ok(Self::from_constants(positions, constants.rounded(), laminae))
    }

    /// Creates the bearing from precomputed constants without checks.
    pub fn from_constants(positions: P, constants: RollerConstants<T>, laminae: A) -> Self {
        let RollerConstants { stiffness, arm, axis, play } = constants;
        let law = LineContactLaw { stiffness };
        let scale = <LineContactLaw<T> as LoadDeflectionLaw<T, M>>::scale(&law);
        Self { ring: Ring { positions, arm, scale }, law, axis, play, laminae, surface: Smooth, math: PhantomData }
    }

    /// Returns the bearing with surface deviations.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> LaminaRoller<T, M, P, A, S> {
        LaminaRoller {
            ring: self.ring,
            law: self.law,
            axis: self.axis,
            play: self.play,
            laminae: self.laminae,
            surface,
            math: PhantomData,
        }
    }
}

/// Displacement of the inner ring at a roller. With `Lanes`: of several rollers.
#[derive(Debug, Clone, Copy)]
struct RollerMotion<L> {
    /// Approach of the rings at the centre of the roller along the line of contact, less the play, m.
    approach: L,
    /// `thv cos phi - thu sin phi`, tilt in the plane of the roller, rad.
    tilt: L,
}

/// Unscaled sums over the laminae of a contact.
#[derive(Debug, Clone, Copy)]
struct LaminaSum<L> {
    load: L,
    moment: L,
    largest: L,
}

impl<T: Scalar, const K: usize> LaminaSum<Lanes<T, K>> {
    #[inline(always)]
    fn new() -> Self {
        let nothing = Lanes::splat(T::NEGATIVE_ZERO);
        Self { load: nothing, moment: nothing, largest: Lanes::splat(T::ZERO) }
    }

    #[inline(always)]
    fn add(&mut self, position: Lanes<T, K>, load: Lanes<T, K>) {
        self.load = self.load + load;
        self.moment = self.moment + position * load;
        self.largest = self.largest.larger(load);
    }

    /// Returns the contact of each roller in newtons.
    #[inline(always)]
    fn scaled(self, scale: T) -> [RollerContact<T>; K] {
        let mut contacts = [RollerContact::default(); K];
        let mut i = 0;
        while i < K {
            contacts[i] = RollerContact {
                load: scale * self.load.0[i],
                moment: scale * self.moment.0[i],
                largest_lamina_load: scale * self.largest.0[i],
            };
            i += 1;
        }
        contacts
    }
}

/// Moments of a stiffness along the roller: `sum k_k`, `sum x_k k_k`, `sum x_k^2 k_k`.
#[derive(Debug, Clone, Copy)]
struct LaminaStiffness<T> {
    load: T,
    cross: T,
    tilting: T,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>>
    LaminaRoller<T, M, P, A, S>
{
    /// Writes the state of each roller in order, as many as `states` takes.
    pub fn roller_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [RollerState<T>]) {
        let mut states = states.iter_mut();
        self.for_each_group::<BLOCK_SIZE>(&to_cage_frame(u, M::sin_cos(at.cage)), at, |group, motion| {
            let contacts = self.contacts(motion).scaled(self.ring.scale);
            for ((_, &contact), tilt) in group.without_padding().iter().zip(&contacts).zip(motion.tilt.0) {
                if let Some(state) = states.next() {
                    *state = RollerState { inner: contact, outer: contact, tilt: T::HALF * tilt };
                }
            }
        });
    }

    /// Writes the loads of the laminae of roller `index` in order, N, as many as `loads` takes.
    pub fn lamina_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, index: usize, loads: &mut [T]) {
        let Some(position) = self.ring.positions.all().nth(index) else { return };
        let motion = self.motion(&[position], &to_cage_frame(u, M::sin_cos(at.cage)), at);
        for (lamina, load) in self.laminae.as_ref().iter().zip(loads) {
            let Lanes([unscaled]) = self.unscaled_load(self.deflection(lamina, motion));
            *load = self.ring.scale * unscaled;
        }
    }

    /// Returns the displacement of the inner ring at rollers side by side, with `u` in the cage frame.
    #[inline(always)]
    fn motion<const K: usize>(
        &self,
        positions: &[super::ElementPosition<T>; K],
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> RollerMotion<Lanes<T, K>> {
        let all = Lanes::<T, K>::splat;
        let block = ElementBlock::of(positions);
        let rim = Motion::of_block(&block, &self.ring.at_rim(u), at, &self.surface).with_waviness();
        let [cos, sin] = self.axis;
        let along = all(cos) * rim.radial + all(sin) * rim.axial + (rim.deviation.inner + rim.deviation.outer);
        RollerMotion { approach: along - all(self.play), tilt: all(u.thv) * block.cos - all(u.thu) * block.sin }
    }

    #[inline(always)]
    fn for_each_group<const K: usize>(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        mut each: impl FnMut(&PaddedGroup<T, K>, RollerMotion<Lanes<T, K>>),
    ) {
        for group in padded_groups::<T, P, K>(&self.ring.positions) {
            each(&group, self.motion(&group.positions, u, at));
        }
    }

    #[inline(always)]
    fn deflection<const K: usize>(&self, lamina: &Lamina<T>, motion: RollerMotion<Lanes<T, K>>) -> Lanes<T, K> {
        motion.approach + Lanes::splat(lamina.position) * motion.tilt - Lanes::splat(lamina.drop)
    }

    #[inline(always)]
    fn unscaled_load<const K: usize>(&self, deflection: Lanes<T, K>) -> Lanes<T, K> {
        let twice = deflection.twice_positive_part();
        Lanes(<LineContactLaw<T> as LoadDeflectionLaw<T, M>>::unscaled_load(&self.law, twice.0))
    }

    #[inline(always)]
    fn contacts<const K: usize>(&self, motion: RollerMotion<Lanes<T, K>>) -> LaminaSum<Lanes<T, K>> {
        let mut sum = LaminaSum::new();
        for lamina in self.laminae.as_ref() {
            sum.add(Lanes::splat(lamina.position), self.unscaled_load(self.deflection(lamina, motion)));
        }
        sum
    }

    /// Returns contact and stiffness of one roller, both unscaled.
    #[inline(always)]
    fn contact_and_stiffness(&self, motion: RollerMotion<Lanes<T, 1>>) -> (LaminaSum<Lanes<T, 1>>, LaminaStiffness<T>) {
        let nothing = T::NEGATIVE_ZERO;
        let (mut sum, mut k) = (LaminaSum::new(), LaminaStiffness { load: nothing, cross: nothing, tilting: nothing });
        for lamina in self.laminae.as_ref() {
            let Lanes([deflection]) = self.deflection(lamina, motion);
            let (load, slope) = <LineContactLaw<T> as LoadDeflectionLaw<T, M>>::unscaled_load_and_slope(
                &self.law,
                deflection.twice_positive_part(),
            );
            let x = lamina.position;
            sum.add(Lanes([x]), Lanes([load]));
            k.load += slope;
            k.cross += x * slope;
            k.tilting += x * x * slope;
        }
        (sum, k)
    }

    /// Returns the force of a roller on the ring, with the moment in place of the force at the lever arm.
    #[inline(always)]
    fn contact_of(&self, load: T, moment: T) -> Contact<T> {
        let [cos, sin] = self.axis;
        let axial = sin * load;
        Contact { radial: cos * load, axial, tilting: self.ring.arm * axial - moment, load }
    }

    /// Returns the stiffness of a roller by the displacement of the ring.
    #[inline(always)]
    fn stiffness_of(&self, k: &LaminaStiffness<T>) -> TiltingStiffness<T> {
        let [cos, sin] = self.axis;
        let lever = self.ring.arm * sin;
        // The deflection changes with the tilt by R sin(a) - x_k.
        let tilting = lever * k.load - k.cross;
        TiltingStiffness {
            radial: cos * cos * k.load,
            radial_axial: cos * sin * k.load,
            radial_tilting: cos * tilting,
            axial: sin * sin * k.load,
            axial_tilting: sin * tilting,
            tilting: lever * (tilting - k.cross) + k.tilting,
        }
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>> CageFrame<T>
    for LaminaRoller<T, M, P, A, S>
{
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<T> {
        M::sin_cos(cage)
    }

    #[inline(always)]
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.reaction_and_loads_in_cage_frame(u, at, &mut [])
    }

    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        let scale = self.ring.scale;
        let (mut sum, mut loads) = (WrenchSum::new(), loads.iter_mut());
        self.for_each_group::<BLOCK_SIZE>(
            u,
            at,
            #[inline(always)]
            |group, motion| {
                let LaminaSum { load: Lanes(load), moment: Lanes(moment), .. } = self.contacts(motion);
                for ((position, load), moment) in group.without_padding().iter().zip(load).zip(moment) {
                    sum.add(position, &self.contact_of(load, moment));
                    if let Some(entry) = loads.next() {
                        *entry = scale * load;
                    }
                }
            },
        );
        sum.finish(T::ONE, scale)
    }

    #[inline]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (mut sum, mut stiffness) = (WrenchSum::new(), StiffnessSum::new());
        for position in self.ring.positions.all() {
            let (contact, k) = self.contact_and_stiffness(self.motion(&[position], u, at));
            let LaminaSum { load: Lanes([load]), moment: Lanes([moment]), .. } = contact;
            sum.add(&position, &self.contact_of(load, moment));
            stiffness.add_tilting(&position, &self.stiffness_of(&k));
        }
        (sum.finish(T::ONE, self.ring.scale), stiffness.finish(T::ONE, self.ring.scale, turn))
    }

    #[inline(always)]
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.reaction_and_loads_in_cage_frame(u, at, loads);
    }
}

bearing_in_cage!(
    LaminaRoller<T, M, P, A, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, A: AsRef<[Lamina<T>]> + Send + Sync, S: Surface<T>
);
