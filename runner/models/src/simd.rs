//! Code compiled twice, for every processor of the target and for processors with AVX2, and selected at run time.
//!
//! Both forms execute the same operations in the same order, on four values at a time instead of two, so the results are
//! bitwise equal. The solver of the quasi-static model ends here as soon as a block of balls has converged, and begins in `f32` where there is no
//! film: its forces are the same on all desktops and those of the kernel's fixed number of steps within 1e-10 of the load.

use ballrace::bearing::{Bearing, CageFrame, Reaction};
use ballrace::{BearingKinematicState, Displacement, Math, Phase, Scalar, Stiffness};
use std::marker::PhantomData;

/// Instruction sets of this processor, detected at run time.
#[derive(Debug, Clone, Copy)]
pub struct SimdDispatch {
    #[cfg(target_arch = "x86_64")]
    avx2: Option<pulp::x86::V3>,
}

impl SimdDispatch {
    /// Detects the instruction sets of the processor.
    #[must_use]
    pub fn detect() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            avx2: pulp::x86::V3::try_new(),
        }
    }

    /// Returns the choice of no instruction set beyond those of every processor of the target.
    #[must_use]
    pub fn none() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            avx2: None,
        }
    }

    /// Runs `work`, with AVX2 where the processor has it. Only code that the compiler inlines into this function uses AVX2.
    #[inline(always)]
    pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            return avx2.vectorize(work);
        }
        work()
    }
}

/// Number of displacements whose forces are computed together, see [`Bearing::reactions`].
pub const SIDE_BY_SIDE: usize = 16;

/// A bearing whose force is computed with the instruction sets of the processor.
pub struct Dispatched<B> {
    bearing: B,
    registers: SimdDispatch,
}

impl<B> Dispatched<B> {
    /// Wraps `bearing` and detects the instruction sets of the processor.
    pub fn new(bearing: B) -> Self {
        Self { bearing, registers: SimdDispatch::detect() }
    }

    /// Returns the reaction on the inner ring.
    #[inline(always)]
    pub fn force<T: Scalar>(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>
    where
        B: CageFrame<T>,
    {
        self.registers.run(
            #[inline(always)]
            || self.bearing.reaction_inlined(u, at),
        )
    }
}

impl<T: Scalar, B: Bearing<T> + CageFrame<T>> Bearing<T> for Dispatched<B> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.force(u, at)
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        self.bearing.reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.reaction_and_loads(u, at, loads);
    }
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        self.registers.run(
            #[inline(always)]
            || self.bearing.reaction_and_loads_inlined(u, at, loads),
        )
    }
    fn reactions(&self, u: &[Displacement<T>], at: &[BearingKinematicState<T>], reactions: &mut [Reaction<T>]) {
        let count = u.len().min(at.len()).min(reactions.len());
        let (u, other_u) = u[..count].as_chunks::<SIDE_BY_SIDE>();
        let (at, other_at) = at[..count].as_chunks();
        let (reactions, others) = reactions[..count].as_chunks_mut();
        self.registers.run(
            #[inline(always)]
            || {
                for ((u, at), reactions) in u.iter().zip(at).zip(reactions) {
                    *reactions = self.bearing.reactions_inlined(u, at);
                }
            },
        );
        for ((u, at), reaction) in other_u.iter().zip(other_at).zip(others) {
            *reaction = self.reaction(u, at);
        }
    }
}

/// The math backend `M` on the widest registers of the processor, see [`SimdDispatch`].
#[derive(Debug, Clone, Copy, Default)]
pub struct OnWideRegisters<M>(PhantomData<M>);

impl<T: Scalar, M: Math<T>> Math<T> for OnWideRegisters<M> {
    type Single = OnWideRegisters<M::Single>;
    const STOPS_EARLY: bool = true;
    #[inline(always)]
    fn sqrt(x: T) -> T {
        M::sqrt(x)
    }
    #[inline(always)]
    fn sqrt_each<const K: usize>(x: [T; K]) -> [T; K] {
        M::sqrt_each(x)
    }
    #[inline(always)]
    fn three_halves<const K: usize>(x: [T; K]) -> [T; K] {
        M::three_halves(x)
    }
    #[inline(always)]
    fn powf(x: T, n: T) -> T {
        M::powf(x, n)
    }
    #[inline(always)]
    fn ninth_root(x: T) -> T {
        // Most laminae of a loaded roller bearing carry nothing: a branch costs less than their roots.
        if x > T::ZERO { M::ninth_root(x) } else { M::ninth_root(T::ZERO) }
    }
    #[inline(always)]
    fn sin_cos(angle: Phase) -> (T, T) {
        M::sin_cos(angle)
    }
    #[inline(always)]
    fn on_registers<R>(work: impl FnOnce() -> R) -> R {
        SimdDispatch::detect().run(work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handle::{AnyBearing, AnyForceModel, BearingHandle, ForceModel};
    use ballrace::Exact;
    use ballrace::bearing::angular::{Angular, DisplacementDatum};
    use ballrace::bearing::geometry::InvalidParameter;
    use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
    use ballrace::bearing::lumped::Radial;
    use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl, SelectedInertia};
    use ballrace::bearing::quasi_static::{BallPosition, QuasiStatic};
    use ballrace::bearing::tabulated::{Table, TableDomain, Tabulated, fill_table};
    use ballrace::bearing::{BlockedPositions, ElementPosition, ElementPositions, evenly_spaced};
    use ballrace::contact::law::PointContactLaw;

    const SPEED: f64 = 314.0;

    fn pose(i: u32) -> Displacement<f64> {
        let [u, v, w, thu, thv] =
            [0.618, 0.414, 0.732, 0.236, 0.303].map(|stride| 2.0 * (f64::from(i) * stride).fract() - 1.0);
        Displacement { u: 6e-6 * u, v: 6e-6 * v, w: 8e-6 + 6e-6 * w, thu: 2e-4 * thu, thv: 2e-4 * thv }
    }

    fn same_bits<B: Bearing<f64> + CageFrame<f64> + Clone + 'static>(name: &str, bearing: &B) {
        let dispatched = AnyBearing::dispatched(bearing.clone());
        let force_alone = AnyForceModel::dispatched(bearing.clone());
        let mut loaded = 0;
        for i in 0..500 {
            let (u, at) = (
                pose(i),
                BearingKinematicState { inner_speed: SPEED, ..Phase::from_revolutions(0.013 * f64::from(i)).into() },
            );
            let plain = bearing.reaction(&u, &at);
            assert_eq!(force_alone.reaction(&u, &at), plain, "{name}, pose {i}");
            let dispatched = Bearing::reaction(&dispatched, &u, &at);
            let bits = |reaction: &Reaction<f64>| reaction.wrench.to_array().map(f64::to_bits);
            assert_eq!(bits(&plain), bits(&dispatched), "{name}, pose {i}");
            assert_eq!(
                (plain.load.to_bits(), plain.status),
                (dispatched.load.to_bits(), dispatched.status),
                "{name}, pose {i}"
            );
            loaded += u32::from(plain.load > 0.0);
        }
        let states = |i: u32| BearingKinematicState::from(Phase::from_revolutions(0.013 * f64::from(i)));
        let (u, at): (Vec<_>, Vec<_>) = (0..23).map(|i| (pose(i), states(i))).unzip();
        let mut together = vec![Reaction::default(); u.len() + SIDE_BY_SIDE];
        Bearing::reactions(&dispatched, &u, &at, &mut together);
        for ((u, at), found) in u.iter().zip(&at).zip(&together) {
            let alone = bearing.reaction(u, at);
            let bits =
                |reaction: &Reaction<f64>| (reaction.wrench.to_array().map(f64::to_bits), reaction.load.to_bits());
            assert_eq!((bits(&alone), alone.status), (bits(found), found.status), "{name}, {u:?}");
        }
        assert!(loaded > 100, "{name}: loaded in {loaded} of 500 poses");
    }

    #[test]
    fn the_wide_form_gives_the_same_bits_for_any_count_of_balls() -> Result<(), InvalidParameter> {
        let geometry = BallBearingGeometry {
            ball_diameter: 7.94e-3,
            pitch_diameter: 39.04e-3,
            inner_conformity: 0.52,
            outer_conformity: 0.52,
            contact_angle: 0.2,
            ball: BEARING_STEEL,
            race: BEARING_STEEL,
        };
        let sixteen: ElementPositions<f64, 16> = evenly_spaced(Phase::ZERO);
        for count in 1..=16 {
            let places: Vec<ElementPosition<f64>> = sixteen.iter().copied().take(count).collect();
            same_bits(
                "angular",
                &Angular::<f64, Exact, _>::try_new(geometry, places.clone(), DisplacementDatum::Touching)?,
            );
            let law = PointContactLaw { stiffness: 1e10 };
            same_bits("lumped", &Radial::<f64, Exact, _, _>::try_new(places.clone(), law, -10e-6)?);
            let solved = QuasiStatic::<f64, Exact, _>::try_new(geometry, places.clone(), DisplacementDatum::Touching)?;
            let domain = TableDomain {
                approach: [-20e-6, 40e-6],
                scale: 10e-6,
                speed_scale: 0.0,
                angle: [-0.2, 0.6],
                speed: [0.5 * SPEED, 2.0 * SPEED],
                speed_ratios: [1.0, 0.0],
                intervals: [16, 8, if count % 2 == 0 { 2 } else { 0 }],
            };
            looked_up::<2>(&solved, &domain, &places)?;
            looked_up::<4>(&solved, &domain, &places)?;
        }
        Ok(())
    }

    fn looked_up<const F: usize>(
        solved: &QuasiStatic<f64, Exact, Vec<ElementPosition<f64>>>,
        domain: &TableDomain,
        places: &[ElementPosition<f64>],
    ) -> Result<(), InvalidParameter> {
        let grid = domain.grid(solved.table_constants().distance)?;
        let mut nodes = vec![[0.0; F]; grid.len()];
        fill_table(solved, domain, &grid, &mut nodes);
        let (table, mounted) = (Table::new(grid, nodes), solved.table_constants());
        let places = BlockedPositions::<_, Vec<_>>::new(places.to_vec());
        same_bits("tabulated", &Tabulated::<f64, Exact, _, _, F>::new(places, mounted, table, false));
        Ok(())
    }

    type Solved<M> = QuasiStatic<f64, M, Vec<ElementPosition<f64>>, SelectedInertia<f64>>;

    fn solved<M: Math<f64>>(
        geometry: BallBearingGeometry,
        places: &[ElementPosition<f64>],
        params: &InertiaParams,
    ) -> Result<Solved<M>, InvalidParameter> {
        let datum = DisplacementDatum::Touching;
        QuasiStatic::<f64, M, _>::try_new(geometry, places.to_vec(), datum)?.with_selected_inertia(params)
    }

    #[test]
    fn balls_in_equilibrium_on_wide_registers_stop_at_the_same_forces() -> Result<(), InvalidParameter> {
        let geometry = BallBearingGeometry {
            ball_diameter: 7.94e-3,
            pitch_diameter: 39.04e-3,
            inner_conformity: 0.52,
            outer_conformity: 0.52,
            contact_angle: 0.3,
            ball: BEARING_STEEL,
            race: BEARING_STEEL,
        };
        let heavy = InertiaParams {
            density: 7800.0,
            centrifugal: true,
            gyroscopic: true,
            race_control: RaceControl::Outer,
            friction_sharing: FrictionSharing::Outer,
        };
        let inner = InertiaParams { race_control: RaceControl::Inner, ..heavy };
        let variants = [
            InertiaParams { centrifugal: false, gyroscopic: false, ..heavy },
            InertiaParams { gyroscopic: false, ..heavy },
            heavy,
            InertiaParams { friction_sharing: FrictionSharing::Equal, ..inner },
            InertiaParams { friction_sharing: FrictionSharing::Proportional, ..inner },
        ];
        let mut worst = 0.0_f64;
        let twenty: ElementPositions<f64, 20> = evenly_spaced(Phase::ZERO);
        for (params, count) in variants.iter().flat_map(|params| [1, 4, 8, 9, 16, 20].map(|count| (params, count))) {
            let places: Vec<ElementPosition<f64>> = twenty.iter().copied().take(count).collect();
            let plain = solved::<Exact>(geometry, &places, params)?;
            let wide = solved::<OnWideRegisters<Exact>>(geometry, &places, params)?;
            let mut balls = vec![BallPosition::default(); count];
            for (i, speed) in (0..200).zip([0.0, 0.3 * SPEED, 3.0 * SPEED, 10.0 * SPEED].into_iter().cycle()) {
                let cage = Phase::from_revolutions(0.0137 * f64::from(i));
                let at = BearingKinematicState { cage, inner_speed: speed, ..Default::default() };
                let u = pose(i);
                let [a, b] = [plain.reaction(&u, &at), wide.reaction(&u, &at)];
                assert_eq!(a.status, b.status, "{params:?}, {count} balls, pose {i}");
                // From balls that have moved by some nanometres since the last sample.
                plain.initial_ball_positions(&u, &at, &mut balls);
                let moved = Displacement { u: u.u + 3e-9, w: u.w - 2e-9, ..u };
                let c = plain.warm_started_reaction(&moved, &at, &mut balls.clone());
                let d = wide.warm_started_reaction(&moved, &at, &mut balls);
                assert_eq!(c.status, d.status, "{params:?}, {count} balls, moved from pose {i}");
                for [a, b] in [[a, b], [c, d]] {
                    let difference =
                        (a.wrench.to_array().into_iter().zip(b.wrench.to_array())).map(|(a, b)| (a - b).abs());
                    let difference = difference.fold((a.load - b.load).abs(), f64::max) / a.load.max(1.0);
                    assert!(difference < 1e-10, "{params:?}, {count} balls, pose {i}: {difference:e}");
                    worst = worst.max(difference);
                }
            }
        }
        assert!(worst > 0.0, "the same solver twice");
        Ok(())
    }
}
