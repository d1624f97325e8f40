//! Masses that come nearest to the moments of a correction: at any angle, in holes, or weights of a stock.

use super::error::BalanceError;
use super::holes::{HoleMass, Holes};
use super::stock::{self, StockChoice};
use super::table::C;
use nalgebra::DMatrix;

/// How masses are placed.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    /// Holes of each plane; `None` for masses at any angle.
    pub holes: Option<Holes>,
    /// Masses are removed, as by drilling, opposite to those that would be added.
    pub removes: bool,
    /// The masses that are mounted are taken off first.
    pub replaces: bool,
}

/// Masses in the holes of each plane.
pub(super) struct Placed {
    /// Masses of each plane; none without holes.
    pub(super) masses: Vec<Vec<HoleMass>>,
    /// Moments that act with them, g mm.
    pub(super) moments: Vec<C>,
    /// What a choice of weights of the stock leaves.
    pub(super) choice: Option<StockChoice>,
}

impl Placement {
    /// Returns the masses that come nearest to the wanted moments (g mm) in the squares of `channels` vectors: a departure `e` adds `e^H M e` with
    /// the metric `M`.
    ///
    /// # Errors
    /// Returns an error if the stock has more choices than can be compared.
    pub(super) fn place(&self, wanted: &[C], metric: &DMatrix<C>, channels: usize) -> Result<Placed, BalanceError> {
        let Some(holes) = &self.holes else {
            return Ok(Placed { masses: vec![vec![]; wanted.len()], moments: wanted.to_vec(), choice: None });
        };
        let sign = if self.removes { -1.0 } else { 1.0 };
        let turned: Vec<C> = wanted.iter().map(|moment| moment * sign).collect();
        let (masses, choice) = if holes.stock.is_empty() {
            (holes.filled(&turned, metric), None)
        } else {
            let (masses, choice) = stock::nearest(holes, &turned, metric, channels)?;
            (masses, Some(choice))
        };
        let moments = holes.moments(&masses).into_iter().map(|moment| moment * sign).collect();
        Ok(Placed { moments, masses: holes.named(&masses), choice })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::holes::{HoleCircle, squares};
    use super::*;

    fn circle(limit: Option<f64>) -> HoleCircle {
        HoleCircle { count: 16, radius: 0.03, limit, ..HoleCircle::default() }
    }

    fn holes(circles: &[HoleCircle]) -> Holes {
        Holes { circles: circles.to_vec(), stock: vec![], most: 2 }
    }

    fn placed(holes: Holes, removes: bool, wanted: &[C], metric: &DMatrix<C>) -> Placed {
        Placement { holes: Some(holes), removes, replaces: false }.place(wanted, metric, 1).unwrap()
    }

    fn one() -> DMatrix<C> {
        DMatrix::identity(1, 1)
    }

    #[test]
    fn masses_in_two_holes_have_the_moment() {
        for angle in [0.0, 10.0, 22.5, 100.0, 359.0_f64] {
            let moment = C::from_polar(48.0, angle.to_radians());
            let found = placed(holes(&[circle(None)]), false, &[moment], &one());
            assert!((found.moments[0] - moment).norm() < 1e-9, "{angle}: {:?}", found.masses);
            assert!(found.masses[0].len() <= 2, "{angle}: {:?}", found.masses);
        }
    }

    /// A moment of two full holes and more goes to those beside them; a hole that is taken stays empty.
    #[test]
    fn full_holes_pass_the_rest_to_their_neighbours() {
        let moment = C::from_polar(50.0, 1.0);
        let found = placed(holes(&[circle(Some(0.5e-3))]), false, &[moment], &one());
        assert!(found.masses[0].len() > 2 && (found.moments[0] - moment).norm() < 1e-6, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| mass.mass_g <= 0.5 + 1e-9), "{:?}", found.masses);
        let free = HoleCircle { taken: vec![2], ..circle(None) };
        let found = placed(holes(&[free]), false, &[moment], &one());
        assert!((found.moments[0] - moment).norm() < 1e-6, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| mass.hole != 3), "{:?}", found.masses);
    }

    /// Moments beyond the holes: no small change of one hole lowers the squares (the conditions of Karush, Kuhn and Tucker), and the other
    /// plane takes over what the full one cannot hold.
    #[test]
    fn full_planes_leave_the_least_squares() {
        let metric =
            DMatrix::from_row_slice(2, 2, &[C::new(2.0, 0.0), C::new(1.2, 0.9), C::new(1.2, -0.9), C::new(1.5, 0.0)]);
        let wanted = [C::from_polar(500.0, 1.0), C::from_polar(10.0, 4.0)];
        let other = HoleCircle { count: 9, radius: 0.05, first: 0.2, ..circle(Some(0.4e-3)) };
        let of = holes(&[circle(Some(0.5e-3)), other]);
        let masses = of.filled(&wanted, &metric);
        let squares = |masses: &[Vec<f64>]| {
            let errors: Vec<C> = of.moments(masses).iter().zip(&wanted).map(|(moment, u)| moment - u).collect();
            squares(&metric, &errors)
        };
        let least = squares(&masses);
        for plane in 0..2 {
            for hole in 0..of.circles[plane].count {
                for step in [-1e-6, 1e-6] {
                    let mut other = masses.clone();
                    other[plane][hole] = (other[plane][hole] + step).clamp(0.0, of.circles[plane].room(hole));
                    assert!(squares(&other) >= least * (1.0 - 1e-9), "{plane} {hole} {step}");
                }
            }
        }
        let alone: Vec<Vec<f64>> = of.circles.iter().zip(&wanted).map(|(circle, u)| circle.fill(*u)).collect();
        assert!(least < 0.98 * squares(&alone), "{least}: {}", squares(&alone));
    }

    #[test]
    fn what_is_removed_acts_as_the_opposite() {
        let moment = C::from_polar(12.0, 0.3);
        let found = placed(holes(&[HoleCircle { count: 12, ..circle(None) }]), true, &[moment], &one());
        assert!((found.moments[0] - moment).norm() < 1e-9, "{:?}", found.masses);
        assert!(found.masses[0].iter().all(|mass| (180.0..=211.0).contains(&mass.angle_deg)), "{:?}", found.masses);
    }

    /// Each plane has holes of its own: the first one of a circle at any angle, masses by the radius.
    #[test]
    fn planes_have_holes_of_their_own() {
        let coupling = HoleCircle { count: 8, radius: 0.06, first: 22.5_f64.to_radians(), ..circle(None) };
        let wanted = [C::from_polar(30.0, 0.0), C::from_polar(30.0, 0.0)];
        let found = placed(holes(&[circle(None), coupling]), false, &wanted, &DMatrix::identity(2, 2));
        let [fan, coupling] = [&found.masses[0], &found.masses[1]];
        assert!(fan.len() == 1 && fan[0].hole == 1 && (fan[0].mass_g - 1.0).abs() < 1e-9, "{fan:?}");
        // 30 g mm half by each of two holes 22.5 degrees to both sides.
        let each = 0.25 / 22.5_f64.to_radians().cos();
        let expected = [(1, 22.5, each), (8, 337.5, each)];
        for (mass, (hole, angle, grams)) in coupling.iter().zip(expected) {
            assert!(mass.hole == hole && (mass.angle_deg - angle).abs() < 1e-9, "{mass:?}");
            assert!((mass.mass_g - grams).abs() < 1e-9, "{mass:?}");
        }
        assert!(found.moments.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).norm() < 1e-9));
    }
}
