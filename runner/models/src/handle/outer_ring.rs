//! Outer ring that bends under the forces of the elements (Hajzman's coupled outer race): a thin ring in inextensional bending and
//! uniform expansion, `w(phi) = c_0 + sum over n of c_n cos(n phi) + s_n sin(n phi)` radially outward.
//!
//! Its energy is `pi E A c_0^2/R + sum over n of pi E I (n^2 - 1)^2 (c_n^2 + s_n^2)/(2 R^3)` (Timoshenko, Vibration Problems in
//! Engineering). The order 1 is a displacement of the whole ring, which belongs to the housing. The ring has no inertia: its shape is
//! that in which it is in equilibrium with the elements, found for every displacement of the inner ring.

use ballrace::bearing::Reaction;
use ballrace::bearing::flexible::HousingPoint;
use ballrace::{Phase, Scalar, Stiffness};
use ballrace_scene::OuterRing;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use std::iter;

/// Largest number of Newton steps, and of parts of one.
const STEPS: usize = 60;
const PARTS: usize = 40;
/// Share of the force along a step that may remain, with the other sign, at its end.
const OVERSHOOT: f64 = 0.5;
/// Unbalanced force over load, in units of the precision, at which a shape is in equilibrium.
const BALANCED: f64 = 8.0;

/// A ring with the elements on it.
#[derive(Debug, Clone)]
pub struct BendingRing {
    /// Azimuth of each element with the cage at angle 0.
    azimuths: Vec<Phase>,
    /// Stiffness of `c_0, c_2, s_2, c_3, s_3, ...`, N/m.
    stiffness: DVector<f64>,
}

/// Direction of an element, and the shapes of the ring there.
struct Place {
    sin: f64,
    cos: f64,
    basis: DVector<f64>,
}

/// A ring of some shape, with the elements on it.
pub struct LoadedRing<T> {
    /// The ring at every element.
    pub points: Vec<HousingPoint<T>>,
    /// Force on the inner ring.
    pub reaction: Reaction<T>,
    shape: DVector<f64>,
    /// Generalised force that is not in balance, N, and its tangent, N/m.
    unbalanced: DVector<f64>,
    tangent: DMatrix<f64>,
    /// Sum of the forces of the elements, N.
    load: f64,
}

impl BendingRing {
    /// Creates the ring below elements at `azimuths`.
    #[must_use]
    pub fn new(ring: &OuterRing, azimuths: Vec<Phase>) -> Self {
        let (radius, modulus) = (ring.radius, ring.youngs_modulus);
        let expansion = 2.0 * PI * modulus * ring.width * ring.thickness / radius;
        let second_moment = ring.width * ring.thickness.powi(3) / 12.0;
        let bending = |n: usize| PI * modulus * second_moment / radius.powi(3) * ((n * n) as f64 - 1.0).powi(2);
        let all = iter::once(expansion).chain((2..=ring.orders).flat_map(|n| [bending(n); 2]));
        Self { azimuths, stiffness: DVector::from_vec(all.collect()) }
    }

    /// Returns the ring in equilibrium with the elements. `evaluate` computes the force on the inner ring and adds reaction and radial
    /// stiffness to every point. The energy of ring and contacts is convex: there is one such shape, and damped Newton steps reach it.
    /// Cost: one evaluation of all elements and one factorisation per step.
    pub fn loaded<T: Scalar>(
        &self,
        cage: Phase,
        evaluate: impl Fn(&mut [HousingPoint<T>]) -> Reaction<T>,
    ) -> LoadedRing<T> {
        let precision = precision::<T>();
        let places = self.places(cage);
        let at = |shape: DVector<f64>| self.with_shape(shape, &places, &evaluate);
        let mut now = at(DVector::zeros(self.stiffness.len()));
        for _ in 0..STEPS {
            let before = now.unbalanced.norm();
            if before <= BALANCED * precision * now.load || !before.is_finite() {
                break;
            }
            let Some(factor) = now.tangent.clone().cholesky() else { break };
            let step = -factor.solve(&now.unbalanced);
            let slope = now.unbalanced.dot(&step);
            let mut part = 1.0;
            let mut next = at(&now.shape + &step);
            for _ in 0..PARTS {
                let end = next.unbalanced.dot(&step);
                if end.is_nan() || end <= OVERSHOOT * slope.abs() {
                    break;
                }
                part *= slope / (slope - end);
                next = at(&now.shape + part * &step);
            }
            // Near the end only rounding keeps a step from getting nearer.
            if next.unbalanced.norm() >= before && before <= precision.sqrt() * now.load {
                break;
            }
            now = next;
        }
        now
    }

    /// Returns the ring with the given shape.
    fn with_shape<T: Scalar>(
        &self,
        shape: DVector<f64>,
        places: &[Place],
        evaluate: &impl Fn(&mut [HousingPoint<T>]) -> Reaction<T>,
    ) -> LoadedRing<T> {
        let point = |Place { sin, cos, basis }: &Place| {
            let displacement = basis.dot(&shape);
            let along = [displacement * cos, displacement * sin, 0.0].map(T::from_f64);
            HousingPoint { displacement: along, ..HousingPoint::default() }
        };
        let mut points: Vec<_> = places.iter().map(point).collect();
        let reaction = evaluate(&mut points);
        let mut unbalanced = self.stiffness.component_mul(&shape);
        let mut tangent = DMatrix::from_diagonal(&self.stiffness);
        let mut load = 0.0;
        for (point, Place { sin, cos, basis }) in points.iter().zip(places) {
            let [x, y, _] = point.reaction.map(T::to_f64);
            let force = x * cos + y * sin;
            unbalanced.axpy(-force, basis, 1.0);
            tangent.ger(point.radial_stiffness.to_f64(), basis, basis, 1.0);
            load += force.abs();
        }
        LoadedRing { points, reaction, shape, unbalanced, tangent, load }
    }

    /// Returns the tangent `-d(wrench)/du` of a loaded ring, whose shape follows the inner ring, from that with the shape held.
    pub fn tangent<T: Scalar>(&self, loaded: &LoadedRing<T>, cage: Phase, held: Stiffness<T>) -> Stiffness<T> {
        let mut coupling = DMatrix::zeros(self.stiffness.len(), 2);
        for (point, Place { sin, cos, basis }) in loaded.points.iter().zip(self.places(cage)) {
            coupling.ger(point.radial_stiffness.to_f64(), &basis, &DVector::from_vec(vec![cos, sin]), 1.0);
        }
        let mut tangent = held;
        if let Some(factor) = loaded.tangent.clone().cholesky() {
            let softer = coupling.transpose() * factor.solve(&coupling);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                tangent[(i, j)] = T::from_f64(held[(i, j)].to_f64() - softer[(i, j)]);
            }
        }
        tangent
    }

    /// Returns the place of every element.
    fn places(&self, cage: Phase) -> Vec<Place> {
        let place = |azimuth: &Phase| {
            let angle = azimuth.wrapping_add(cage).radians();
            let (sin, cos) = angle.sin_cos();
            Place { sin, cos, basis: basis(self.stiffness.len(), angle) }
        };
        self.azimuths.iter().map(place).collect()
    }
}

/// Returns the first `count` of `1, cos 2 phi, sin 2 phi, cos 3 phi, ...`.
fn basis(count: usize, angle: f64) -> DVector<f64> {
    DVector::from_fn(count, |i, _| {
        let (sin, cos) = (i.div_ceil(2) as f64 * angle + if i > 0 { angle } else { 0.0 }).sin_cos();
        if i % 2 == 0 && i > 0 { sin } else { cos }
    })
}

/// Returns the distance of 1 to the next number.
fn precision<T: Scalar>() -> f64 {
    let is_double = T::from_f64(1.0 + 1e-10).to_f64() > 1.0;
    if is_double { f64::EPSILON } else { f64::from(f32::EPSILON) }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::build;
    use crate::handle::AnyBearing;
    use ballrace::bearing::Bearing;
    use ballrace::{BearingKinematicState, Displacement};
    use ballrace_scene::read;
    use std::f64::consts::TAU;

    const RING: OuterRing =
        OuterRing { radius: 50e-3, width: 18e-3, thickness: 5e-3, youngs_modulus: 206e9, orders: 24 };

    /// Two opposite forces flatten a ring by `(pi/4 - 2/pi) F R^3/(E I)` (Timoshenko, Strength of Materials; Roark, case 1 of circular rings).
    #[test]
    fn two_opposite_forces_flatten_a_ring() {
        let places = vec![Phase::ZERO, Phase::from_revolutions(0.5)];
        let expand = 2.0 * PI * RING.youngs_modulus * RING.width * RING.thickness / RING.radius;
        let second_moment = RING.width * RING.thickness.powi(3) / 12.0;
        let force = 300.0;
        let loaded = BendingRing::new(&RING, places).loaded(Phase::ZERO, |points: &mut [HousingPoint<f64>]| {
            points[0].reaction = [force, 0.0, 0.0];
            points[1].reaction = [-force, 0.0, 0.0];
            Reaction::default()
        });
        let change: f64 = 2.0 * (loaded.points[0].displacement[0] - 2.0 * force / expand);
        let expected = (PI / 4.0 - 2.0 / PI) * force * RING.radius.powi(3) / (RING.youngs_modulus * second_moment);
        assert!((change / expected - 1.0).abs() < 1e-4, "{change:e} m, expected {expected:e}");
    }

    fn bearing(more: &str) -> AnyBearing<f64> {
        let text = format!(
            "[shaft]\nspeed = \"1500 rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\nelements = 9\n\
             cage_ratio = 0.4\nstiffness = 6e8\nexponent = 1.1111\nradial_play = \"2 um\"\n\
             axial = {{ stiffness = 1e9, play = \"-1 um\", radius = \"20 mm\" }}\n{more}\n"
        );
        let scene = read::read_str(&text, std::path::Path::new("scene.toml")).unwrap();
        build::bearing(&scene, &scene.bearings[0], scene.bearings[0].model).unwrap()
    }

    fn ring(thickness: &str, modulus: &str) -> AnyBearing<f64> {
        bearing(&format!(
            "outer_ring = {{ radius = \"50 mm\", width = \"18 mm\", thickness = \"{thickness}\", youngs_modulus = \"{modulus}\" }}"
        ))
    }

    fn soft(thickness: &str) -> AnyBearing<f64> {
        ring(thickness, "206 GPa")
    }

    fn displaced(u: f64, v: f64) -> Displacement<f64> {
        Displacement { u, v, w: 1e-6, thu: 1e-5, thv: -2e-5 }
    }

    fn at(cage: f64) -> BearingKinematicState<f64> {
        Phase::from_radians(cage).into()
    }

    /// The tangent is the derivative of the force, with a ring so soft that it takes most of the displacement.
    #[test]
    fn the_tangent_is_the_derivative_of_the_force() {
        for (thickness, cage) in [("2 mm", 0.0), ("4 mm", 0.3), ("12 mm", 4.0)] {
            let bearing = soft(thickness);
            for (u, v) in [(12e-6, -5e-6), (3e-6, 1e-6), (-40e-6, 20e-6)] {
                let (_, k) = bearing.reaction_and_stiffness(&displaced(u, v), &at(cage));
                let h = 1e-10;
                for axis in 0..5 {
                    let mut step = [0.0; 5];
                    step[axis] = h;
                    let moved = |sign: f64| {
                        let [a, b, c, d, e] = step.map(|s| sign * s);
                        let more = Displacement { u: a, v: b, w: c, thu: d, thv: e };
                        bearing.reaction(&(displaced(u, v) + more), &at(cage)).wrench.to_array()
                    };
                    let (up, down) = (moved(1.0), moved(-1.0));
                    for row in 0..5 {
                        let derivative = -(up[row] - down[row]) / (2.0 * h);
                        let error = (k[(row, axis)] - derivative).abs() / k.amax();
                        assert!(
                            error < 1e-5,
                            "{thickness}, ({row}, {axis}): {}, expected {derivative}",
                            k[(row, axis)]
                        );
                    }
                }
            }
        }
    }

    /// A stiff ring is a rigid one; a soft one spreads the load over more elements and yields.
    #[test]
    fn a_soft_ring_spreads_the_load() {
        let u = Displacement { u: 20e-6, ..Displacement::default() };
        let loads = |bearing: &AnyBearing<f64>| {
            let mut loads = [0.0; 9];
            bearing.element_loads(&u, &at(0.0), &mut loads);
            loads
        };
        let (rigid, thick, thin) = (bearing(""), ring("10 mm", "1e9 GPa"), soft("3 mm"));
        let force = |bearing: &AnyBearing<f64>| -bearing.reaction(&u, &at(0.0)).wrench.fx;
        assert!((force(&thick) / force(&rigid) - 1.0).abs() < 1e-5, "{} N, {} N", force(&thick), force(&rigid));
        assert!(force(&thin) < 0.5 * force(&rigid), "{} N, {} N", force(&thin), force(&rigid));
        let share = |bearing: &AnyBearing<f64>| loads(bearing)[0] / force(bearing);
        assert!(share(&thin) < 0.95 * share(&rigid), "{} {}", share(&thin), share(&rigid));
    }

    /// On a closed path of the inner ring the force does no work.
    #[test]
    fn the_force_has_a_potential() {
        let bearing = soft("3 mm");
        let steps = 4000;
        let on_path = |i: i32| {
            let angle = TAU * f64::from(i) / f64::from(steps);
            Displacement { u: 8e-6 + 10e-6 * angle.cos(), v: 15e-6 * angle.sin(), ..Displacement::default() }
        };
        let (mut work, mut size) = (0.0, 0.0);
        for i in 0..steps {
            let force = bearing.reaction(&on_path(i), &at(0.2)).wrench;
            let (from, to) = (on_path(i - 1), on_path(i + 1));
            let part = 0.5 * (force.fx * (to.u - from.u) + force.fy * (to.v - from.v));
            work += part;
            size += part.abs();
        }
        assert!(work.abs() < 1e-5 * size, "{work:e} J of {size:e}");
    }

    /// The force turned by one pitch of the elements is that of the turned displacement: the ring has no places of its own.
    #[test]
    fn the_ring_is_the_same_all_round() {
        let bearing = soft("3 mm");
        let force = |angle: f64, cage: f64| {
            let u = Displacement { u: 20e-6 * angle.cos(), v: 20e-6 * angle.sin(), ..Displacement::default() };
            let wrench = bearing.reaction(&u, &at(cage)).wrench;
            (wrench.fx.hypot(wrench.fy), wrench.fy.atan2(wrench.fx))
        };
        let (size, direction) = force(0.3, 0.7);
        let (other, turned) = force(1.3, 1.7);
        assert!((size / other - 1.0).abs() < 1e-9, "{size} N, {other} N");
        assert!(((turned - direction).rem_euclid(TAU) - 1.0).abs() < 1e-9);
    }
}
