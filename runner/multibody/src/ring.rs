//! A ring of a bearing that moves.

use nalgebra::Vector3;

/// Pose and motion of a ring in the frame of the bearing: origin on the axis in the plane of the ball centres of a centred bearing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RingMotion {
    /// `u v w thu thv`, m and rad.
    pub displacement: [f64; 5],
    /// Rates of the displacement, m/s and rad/s.
    pub rate: [f64; 5],
    /// Angle of the ring about its axis, for its surface: revolutions are kept by the caller.
    pub angle: ballrace::Phase,
    /// Speed about its axis, rad/s.
    pub speed: f64,
}

/// Position, velocity and tilt of a ring.
#[derive(Debug, Clone, Copy)]
pub struct Ring {
    /// Centre, m.
    pub centre: Vector3<f64>,
    /// Velocity of the centre, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub spin: Vector3<f64>,
    /// Rotation vector of the tilt, rad.
    tilt: Vector3<f64>,
}

impl Ring {
    /// Creates the ring in its pose.
    #[must_use]
    pub fn new(motion: &RingMotion) -> Self {
        let [u, v, w, thu, thv] = motion.displacement;
        let [du, dv, dw, dthu, dthv] = motion.rate;
        let tilt = Vector3::new(thu, thv, 0.0);
        let mut ring = Self { centre: Vector3::new(u, v, w), velocity: Vector3::new(du, dv, dw), spin: tilt, tilt };
        ring.spin = ring.to_fixed(&Vector3::new(0.0, 0.0, motion.speed)) + Vector3::new(dthu, dthv, 0.0);
        ring
    }

    /// Returns a vector of the fixed frame in the frame of the ring, which does not turn about its axis. To second order in the tilt.
    #[must_use]
    pub fn to_ring(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let across = self.tilt.cross(x);
        x - across + 0.5 * self.tilt.cross(&across)
    }

    /// Returns a vector of the frame of the ring in the fixed frame.
    #[must_use]
    pub fn to_fixed(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let across = self.tilt.cross(x);
        x + across + 0.5 * self.tilt.cross(&across)
    }

    /// Returns the velocity of the ring's material at `x` from its centre, m/s.
    #[must_use]
    pub fn velocity_at(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(x)
    }
}
