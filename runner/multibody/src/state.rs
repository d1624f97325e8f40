//! State of balls and cage as numbers, and their motion.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Numbers of the state of one body: position, velocity, orientation, angular velocity.
pub(crate) const BODY: usize = 13;

/// A rigid body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    /// Position, m.
    pub position: Vector3<f64>,
    /// m/s
    pub velocity: Vector3<f64>,
    /// From its own frame to the fixed one.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity in the fixed frame, rad/s.
    pub spin: Vector3<f64>,
}

impl Body {
    /// Reads a body from its numbers; zeros for those that are absent.
    pub fn read(numbers: &[f64]) -> Self {
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        let vector = |i: usize| Vector3::new(at(i), at(i + 1), at(i + 2));
        let orientation = UnitQuaternion::new_unchecked(Quaternion::new(at(6), at(7), at(8), at(9)));
        Self { position: vector(0), velocity: vector(3), orientation, spin: vector(10) }
    }

    /// Writes the body to its numbers, with an orientation of length 1.
    pub fn write(&self, numbers: &mut [f64]) {
        let q = UnitQuaternion::new_normalize(*self.orientation.quaternion());
        let orientation = [q.w, q.i, q.j, q.k];
        let values = self.position.iter().chain(&self.velocity).chain(&orientation).chain(&self.spin);
        numbers.iter_mut().zip(values).for_each(|(number, value)| *number = *value);
    }

    /// Writes the rates of the numbers for an acceleration (m/s^2) and an angular acceleration (rad/s^2).
    pub fn write_rates(&self, rates: &mut [f64], acceleration: &Vector3<f64>, angular: &Vector3<f64>) {
        let q = self.orientation.quaternion();
        let turning = Quaternion::new(0.0, self.spin.x, self.spin.y, self.spin.z) * q * 0.5;
        let orientation = [turning.w, turning.i, turning.j, turning.k];
        let values = self.velocity.iter().chain(acceleration).chain(&orientation).chain(angular);
        rates.iter_mut().zip(values).for_each(|(rate, value)| *rate = *value);
    }

    /// Returns the body turned about Z.
    pub fn turned(&self, by: &UnitQuaternion<f64>) -> Self {
        Self {
            position: by * self.position,
            velocity: by * self.velocity,
            orientation: by * self.orientation,
            spin: by * self.spin,
        }
    }
}

/// Motion and contacts of one ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BallMotion {
    /// Azimuth of the centre, rad, from -pi to pi.
    pub azimuth: f64,
    /// Angular velocity of the centre about the axis of the bearing, rad/s.
    pub orbital_speed: f64,
    /// Angular velocity of the ball: outward, along the orbit and along Z, rad/s.
    pub spin: [f64; 3],
    /// Load at the inner and outer race, N.
    pub load: [f64; 2],
    /// Contact angle at the inner and outer race, rad; that of the centre of the groove without contact.
    pub contact_angle: [f64; 2],
    /// Slip speed of the ball's surface against the inner and outer race at the centre of the contact along the orbit, m/s; 0 without contact.
    pub slip: [f64; 2],
    /// Speed of rotation about the contact's normal of the ball against the inner and outer race, rad/s; 0 without contact.
    pub contact_spin: [f64; 2],
    /// Central thickness of the oil film at the inner and outer race, m; 0 without load or `lubricant`.
    pub film: [f64; 2],
    /// Force of the cage along the orbit, N; negative against it.
    pub pocket_force: f64,
}

/// Motion of the cage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CageMotion {
    /// Angular velocity about the axis of the bearing, rad/s.
    pub speed: f64,
    /// Centre against that of the ring that guides it, else of the outer ring, m.
    pub centre: [f64; 3],
    /// Angle between its axis and Z, rad.
    pub tilt: f64,
    /// Force of the lands of both rings, N.
    pub land_force: f64,
}

/// Balls and cage of one bearing at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ElementMotion {
    /// The balls in the order of the scene.
    pub balls: Vec<BallMotion>,
    /// The cage.
    pub cage: CageMotion,
    /// Power lost by traction on the races, by damping of contacts, at the cage, by drag, W.
    pub loss: [f64; 4],
    /// Orbital speed of balls that roll at their mean contact angles between the rings as they turn, rad/s.
    pub rolling_speed: f64,
}

/// Name and unit of a number of a ball.
const OF_BALL: [(&str, &str); 17] = [
    ("azimuth", "rad"),
    ("orbital_speed", "rad/s"),
    ("spin_outward", "rad/s"),
    ("spin_orbital", "rad/s"),
    ("spin_axial", "rad/s"),
    ("inner_load", "N"),
    ("outer_load", "N"),
    ("inner_angle", "rad"),
    ("outer_angle", "rad"),
    ("inner_slip", "m/s"),
    ("outer_slip", "m/s"),
    ("inner_spin", "rad/s"),
    ("outer_spin", "rad/s"),
    ("inner_film", "m"),
    ("outer_film", "m"),
    ("pocket_force", "N"),
    ("slip_ratio", "1"),
];
/// Name and unit of a number of the cage.
const OF_CAGE: [(&str, &str); 11] = [
    ("cage_speed", "rad/s"),
    ("cage_slip", "1"),
    ("cage_x", "m"),
    ("cage_y", "m"),
    ("cage_z", "m"),
    ("cage_tilt", "rad"),
    ("land_force", "N"),
    ("traction_loss", "W"),
    ("damping_loss", "W"),
    ("cage_loss", "W"),
    ("drag_loss", "W"),
];

impl ElementMotion {
    /// Returns name and unit of each of [`ElementMotion::values`] for a bearing with `elements` balls.
    pub fn columns(elements: usize) -> impl Iterator<Item = (String, &'static str)> {
        let balls =
            (1..=elements).flat_map(|j| OF_BALL.iter().map(move |(name, unit)| (format!("ball_{j}_{name}"), *unit)));
        OF_CAGE.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).chain(balls)
    }

    /// Returns the numbers of cage and balls.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        let CageMotion { speed, centre: [x, y, z], tilt, land_force } = self.cage;
        let [traction, damping, cage, drag] = self.loss;
        let of_cage = [speed, self.cage_slip(), x, y, z, tilt, land_force, traction, damping, cage, drag];
        let of_ball = |ball: &BallMotion| {
            let ([a, b, c], [load_i, load_o]) = (ball.spin, ball.load);
            let ([angle_i, angle_o], [slip_i, slip_o]) = (ball.contact_angle, ball.slip);
            let ([spin_i, spin_o], [film_i, film_o]) = (ball.contact_spin, ball.film);
            let slip_ratio = self.slip_ratio(ball);
            [
                ball.azimuth,
                ball.orbital_speed,
                a,
                b,
                c,
                load_i,
                load_o,
                angle_i,
                angle_o,
                slip_i,
                slip_o,
                spin_i,
                spin_o,
                film_i,
                film_o,
                ball.pocket_force,
                slip_ratio,
            ]
        };
        of_cage.into_iter().chain(self.balls.iter().flat_map(of_ball))
    }

    /// Returns the slip of a ball: how much slower its centre moves than in pure rolling, over that speed; 0 where nothing turns.
    fn slip_ratio(&self, ball: &BallMotion) -> f64 {
        if self.rolling_speed == 0.0 { 0.0 } else { 1.0 - ball.orbital_speed / self.rolling_speed }
    }

    /// Returns the slip of the cage: how much slower it turns than in pure rolling, over that speed; 0 where nothing turns.
    #[must_use]
    pub fn cage_slip(&self) -> f64 {
        if self.rolling_speed == 0.0 { 0.0 } else { 1.0 - self.cage.speed / self.rolling_speed }
    }
}
