//! Bearings compiled twice: for every processor of the target, and for one with wide registers, taken where there is one.
//!
//! The same operations in the same order, four numbers at a time instead of two: the answers are the same bits.

use super::{AnyBearing, Shared};
use ballrace::Scalar;
use ballrace::bearing::{Bearing, InCage};
use std::sync::Arc;

/// A bearing behind a shared pointer, in the form that suits this processor best.
#[cfg(not(target_arch = "x86_64"))]
pub fn shared<T: Scalar, B: Bearing<T> + InCage<T> + 'static>(bearing: B) -> AnyBearing<T> {
    Shared(Arc::new(bearing))
}

#[cfg(target_arch = "x86_64")]
pub use x86_64::shared;

#[cfg(target_arch = "x86_64")]
mod x86_64 {
    use super::*;
    use ballrace::bearing::Reaction;
    use ballrace::{Displacement, Rotation, Stiffness};
    use pulp::NullaryFnOnce;
    use pulp::x86::V3;

    /// A bearing behind a shared pointer, in the form that suits this processor best.
    pub fn shared<T: Scalar, B: Bearing<T> + InCage<T> + 'static>(bearing: B) -> AnyBearing<T> {
        match V3::try_new() {
            Some(processor) => Shared(Arc::new(Wide { bearing, processor })),
            None => Shared(Arc::new(bearing)),
        }
    }

    /// A bearing, and the proof that the processor has the wide registers.
    struct Wide<B> {
        bearing: B,
        processor: V3,
    }

    /// What is compiled for the wide registers.
    struct Task<'a, T, B> {
        bearing: &'a B,
        u: &'a Displacement<T>,
        at: &'a Rotation<T>,
    }

    impl<T: Scalar, B: InCage<T>> NullaryFnOnce for Task<'_, T, B> {
        type Output = Reaction<T>;
        #[inline(always)]
        fn call(self) -> Reaction<T> {
            self.bearing.reaction_inlined(self.u, self.at)
        }
    }

    impl<T: Scalar, B: Bearing<T> + InCage<T>> Bearing<T> for Wide<B> {
        fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
            self.processor.vectorize(Task { bearing: &self.bearing, u, at })
        }
        fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
            self.bearing.reaction_and_stiffness(u, at)
        }
        fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
            self.bearing.element_loads(u, at, loads);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace::bearing::angular::{Angular, Zero};
    use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
    use ballrace::bearing::lumped::Radial;
    use ballrace::bearing::quasi_static::QuasiStatic;
    use ballrace::bearing::tabulated::{Domain, Table, Tabulated, fill};
    use ballrace::bearing::{Place, Places, even_places};
    use ballrace::contact::law::Point;
    use ballrace::{Displacement, Exact, Rotation, Turn};

    const SPEED: f64 = 314.0;

    fn pose(i: u32) -> Displacement<f64> {
        let [u, v, w, thu, thv] =
            [0.618, 0.414, 0.732, 0.236, 0.303].map(|stride| 2.0 * (f64::from(i) * stride).fract() - 1.0);
        Displacement { u: 6e-6 * u, v: 6e-6 * v, w: 8e-6 + 6e-6 * w, thu: 2e-4 * thu, thv: 2e-4 * thv }
    }

    fn same_bits<B: Bearing<f64> + InCage<f64> + Clone + 'static>(name: &str, bearing: &B) {
        let wide = shared(bearing.clone());
        let mut loaded = 0;
        for i in 0..500 {
            let (u, at) =
                (pose(i), Rotation { inner_speed: SPEED, ..Turn::from_revolutions(0.013 * f64::from(i)).into() });
            let (plain, wide) = (bearing.reaction(&u, &at), wide.reaction(&u, &at));
            let bits = |reaction: &ballrace::bearing::Reaction<f64>| reaction.wrench.to_array().map(f64::to_bits);
            assert_eq!(bits(&plain), bits(&wide), "{name}, pose {i}");
            assert_eq!((plain.load.to_bits(), plain.status), (wide.load.to_bits(), wide.status), "{name}, pose {i}");
            loaded += u32::from(plain.load > 0.0);
        }
        assert!(loaded > 100, "{name}: loaded in {loaded} of 500 poses");
    }

    #[test]
    fn the_wide_form_gives_the_same_bits_for_any_count_of_balls() -> anyhow::Result<()> {
        let geometry = BallBearingGeometry {
            ball_diameter: 7.94e-3,
            pitch_diameter: 39.04e-3,
            inner_conformity: 0.52,
            outer_conformity: 0.52,
            contact_angle: 0.2,
            ball: BEARING_STEEL,
            race: BEARING_STEEL,
        };
        let sixteen: Places<f64, 16> = even_places(Turn::ZERO);
        for count in 1..=16 {
            let places: Vec<Place<f64>> = sixteen.iter().copied().take(count).collect();
            same_bits("angular", &Angular::<f64, Exact, _>::try_new(geometry, places.clone(), Zero::Touching)?);
            let law = Point { stiffness: 1e10 };
            same_bits("lumped", &Radial::<f64, Exact, _, _>::try_new(places.clone(), law, -10e-6)?);
            let solved = QuasiStatic::<f64, Exact, _>::try_new(geometry, places.clone(), Zero::Touching)?;
            let domain = Domain {
                approach: [-20e-6, 40e-6],
                angle: [-0.2, 0.6],
                speed: [0.5 * SPEED, 2.0 * SPEED],
                turning: [1.0, 0.0],
                intervals: [16, 8, if count % 2 == 0 { 2 } else { 0 }],
            };
            let grid = domain.grid()?;
            let mut nodes = vec![[0.0; 3]; grid.len()];
            fill(&solved, &domain, &grid, &mut nodes);
            let table = Table::new(grid, nodes);
            same_bits("tabulated", &Tabulated::<f64, Exact, _, _, 3>::new(places, solved.table_seat(), table, false));
        }
        Ok(())
    }
}
