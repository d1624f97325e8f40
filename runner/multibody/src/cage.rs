//! Contacts of the cage: balls in its pockets, its lands on the rings.

use crate::parameters::CageParams;
use crate::ring::Ring;
use crate::state::Body;
use nalgebra::Vector3;

/// Slip speed below which friction falls to zero with the slip, m/s.
const STICKING: f64 = 0.01;

/// Contact of the cage with a ball or a ring.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CageContact {
    /// Approach of the surfaces, m; negative with a gap.
    pub approach: f64,
    /// Normal force, N.
    pub load: f64,
    /// Force on the ball or the ring, N.
    pub force: Vector3<f64>,
    /// Point of contact, m.
    pub point: Vector3<f64>,
    /// Energy of the deformation, J.
    pub energy: f64,
    /// Power lost by friction and damping, W.
    pub loss: f64,
}

impl CageParams {
    /// Evaluates the contact of a ball with its pocket, a cylinder whose axis is the direction `axis` from the centre of the cage.
    pub(crate) fn pocket(&self, cage: &Body, ball: &Body, axis: &Vector3<f64>, ball_radius: f64) -> CageContact {
        let from_cage = ball.position - cage.position;
        let across = from_cage - axis * from_cage.dot(axis);
        let distance = across.norm();
        let approach = distance - 0.5 * self.pocket_clearance;
        if approach <= 0.0 {
            return CageContact { approach, ..CageContact::default() };
        }
        let direction = across / distance;
        let point = ball.position + direction * ball_radius;
        let velocity = ball.velocity + ball.spin.cross(&(direction * ball_radius));
        self.contact(approach, &-direction, &point, &(velocity - velocity_of(cage, &point)))
    }

    /// Evaluates the contact of one edge of the cage, at `side` times half of its width, with the land of a ring. The force is that on the ring.
    pub(crate) fn land(&self, cage: &Body, ring: &Ring, which: usize, side: f64) -> CageContact {
        let none = CageContact { approach: -1.0, ..CageContact::default() };
        let (Some(clearance), Some(radius)) =
            (self.land_clearance.get(which).copied().flatten(), self.land_radius.get(which))
        else {
            return none;
        };
        let edge = cage.position + cage.orientation * Vector3::new(0.0, 0.0, side * self.half_width);
        let mut local = ring.to_ring(&(edge - ring.centre));
        let axial = local.z;
        local.z = 0.0;
        let distance = local.norm();
        let approach = distance - 0.5 * clearance;
        if approach <= 0.0 {
            return CageContact { approach, ..none };
        }
        let direction = local / distance;
        // The cage touches the outer ring on the side to which it is displaced, the inner ring on the other one.
        let outward = if which == 0 { -1.0 } else { 1.0 };
        let mut touched = direction * (outward * radius);
        touched.z = axial;
        let point = ring.centre + ring.to_fixed(&touched);
        let slip = ring.velocity_at(&(point - ring.centre)) - velocity_of(cage, &point);
        self.contact(approach, &ring.to_fixed(&direction), &point, &slip)
    }

    /// Returns the contact with the force on the other body along `normal`, away from the cage, and the friction against its slip.
    fn contact(&self, approach: f64, normal: &Vector3<f64>, point: &Vector3<f64>, slip: &Vector3<f64>) -> CageContact {
        let rate = -slip.dot(normal);
        let elastic = self.stiffness * approach;
        let load = (elastic * (1.0 + self.damping * rate)).max(0.0);
        let along = slip + normal * rate;
        let speed = along.norm_squared();
        let friction = self.friction * load / (speed + STICKING * STICKING).sqrt();
        CageContact {
            approach,
            load,
            force: normal * load - along * friction,
            point: *point,
            energy: 0.5 * elastic * approach,
            loss: friction * speed + (load - elastic) * rate,
        }
    }
}

/// Returns the velocity of a body's material at a point, m/s.
fn velocity_of(body: &Body, point: &Vector3<f64>) -> Vector3<f64> {
    body.velocity + body.spin.cross(&(point - body.position))
}
