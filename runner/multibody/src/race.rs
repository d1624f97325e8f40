//! Contact of a ball with the groove of a race.

use crate::ring::Ring;
use crate::state::Body;
use crate::traction::TractionCurve;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::contact::hertz::{PointContact, Race};
use nalgebra::Vector3;

/// Points along the major axis of a contact ellipse, of Gauss's formula on -1 to 1.
const POINTS: [f64; 9] = [
    -0.968_160_239_507_626_1,
    -0.836_031_107_326_635_8,
    -0.613_371_432_700_590_4,
    -0.324_253_423_403_808_9,
    0.0,
    0.324_253_423_403_808_9,
    0.613_371_432_700_590_4,
    0.836_031_107_326_635_8,
    0.968_160_239_507_626_1,
];
/// Weights of [`POINTS`].
const WEIGHTS: [f64; 9] = [
    0.081_274_388_361_574_4,
    0.180_648_160_694_857_4,
    0.260_610_696_402_935_5,
    0.312_347_077_040_002_9,
    0.330_239_355_001_259_8,
    0.312_347_077_040_002_9,
    0.260_610_696_402_935_5,
    0.180_648_160_694_857_4,
    0.081_274_388_361_574_4,
];

/// Groove of a race and its contact with a ball.
#[derive(Debug, Clone, Copy)]
pub struct RaceContact {
    /// 1 at the inner race, -1 at the outer.
    side: f64,
    /// Radius of the circle of groove centres, m.
    radius: f64,
    /// Axial position of that circle in the frame of the ring, m.
    axial: f64,
    /// Distance of the ball's centre from the groove's centre at which they touch, m: `(f - 1/2) D`.
    distance: f64,
    /// K, N/m^1.5.
    stiffness: f64,
    /// Semi-major axis under 1 N, m: it grows with the third root of the load.
    unit_axis: f64,
    /// Radius of the deformed surface, m: `2 f D / (2 f + 1)` (Harris).
    deformed_radius: f64,
    /// Radius of the ball, m.
    ball_radius: f64,
    /// 3/2 alpha of Hunt and Crossley, s/m.
    damping: f64,
    traction: TractionCurve,
}

/// Deviation of the surfaces at a contact, m.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Deviation {
    /// Outward displacement of the groove's centre.
    pub radial: f64,
    /// Displacement of the groove's centre towards +Z.
    pub axial: f64,
    /// Additional approach: height of the surfaces.
    pub approach: f64,
}

/// A contact of a ball with a race.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Contact {
    /// Approach of the surfaces, m; negative with a gap.
    pub approach: f64,
    /// Load, N.
    pub load: f64,
    /// Force on the ball, N.
    pub force: Vector3<f64>,
    /// Moment of the force about the ball's centre, N m.
    pub moment: Vector3<f64>,
    /// Cosine and sine of the contact angle, which is positive where the inner ring pushes the ball towards +Z.
    pub direction: [f64; 2],
    /// Slip along the orbit at the centre of the contact, m/s.
    pub slip: f64,
    /// Relative rotation about the normal, rad/s.
    pub spin: f64,
    /// Energy of the deformation, J.
    pub energy: f64,
    /// Power lost by traction, W.
    pub traction_loss: f64,
    /// Power lost by damping, W.
    pub damping_loss: f64,
}

/// Vector in the plane of the axis (outward, along Z) and along the orbit.
struct Cylindrical {
    outward: f64,
    orbital: f64,
    axial: f64,
}

impl RaceContact {
    /// Creates the contact at `race`; `facing` is 1 where the bearing carries thrust along +Z, -1 along -Z, 0 where its rings are centred at
    /// zero displacement; `damping` is alpha of Hunt and Crossley, s/m.
    #[must_use]
    pub fn new(geometry: &BallBearingGeometry, race: Race, facing: f64, damping: f64, traction: TractionCurve) -> Self {
        let (conformity, side) = match race {
            Race::Inner => (geometry.inner_conformity, 1.0),
            Race::Outer => (geometry.outer_conformity, -1.0),
        };
        let (sin, cos) = geometry.contact_angle.sin_cos();
        let diameter = geometry.ball_diameter;
        let distance = (conformity - 0.5) * diameter;
        let contact: PointContact = geometry.contact(race);
        Self {
            side,
            radius: 0.5 * geometry.pitch_diameter + side * distance * cos,
            axial: side * facing * distance * sin,
            distance,
            stiffness: contact.stiffness,
            unit_axis: contact.ellipse(1.0).0,
            deformed_radius: 2.0 * conformity * diameter / (2.0 * conformity + 1.0),
            ball_radius: 0.5 * diameter,
            damping: 1.5 * damping,
            traction,
        }
    }

    /// Returns radius and axial position of the circle of groove centres, and the distance of centres at which ball and groove touch, m.
    #[must_use]
    pub const fn groove(&self) -> [f64; 3] {
        [self.radius, self.axial, self.distance]
    }

    /// Returns the stiffness K, N/m^1.5.
    #[must_use]
    pub const fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Returns the direction from the ball's centre to the contact on smooth surfaces.
    pub(crate) fn direction(&self, ball: &Body, ring: &Ring) -> Vector3<f64> {
        let local = ring.to_ring(&(ball.position - ring.centre));
        let rho = length(local.x, local.y);
        let outward = (self.radius - rho) / rho;
        let to_groove = Vector3::new(local.x * outward, local.y * outward, self.axial - local.z);
        -ring.to_fixed(&to_groove).normalize()
    }

    /// Evaluates the contact.
    pub(crate) fn evaluate(&self, ball: &Body, ring: &Ring, deviation: &Deviation) -> Contact {
        let from_centre = ball.position - ring.centre;
        let local = ring.to_ring(&from_centre);
        let rho = length(local.x, local.y);
        let [cos, sin] = [local.x / rho, local.y / rho];
        let outward = self.radius + deviation.radial - rho;
        let axial = self.axial + deviation.axial - local.z;
        let distance = length(outward, axial);
        let approach = distance - self.distance + deviation.approach;
        // Normal, from the contact through the ball's centre to the groove's centre.
        let normal = [outward / distance, axial / distance];
        let direction = [self.side * normal[0], self.side * normal[1]];
        if approach <= 0.0 {
            return Contact { approach, direction, ..Contact::default() };
        }
        let cylindrical = |x: Vector3<f64>| Cylindrical {
            outward: x.x * cos + x.y * sin,
            orbital: x.y * cos - x.x * sin,
            axial: x.z,
        };
        let velocity = cylindrical(ring.to_ring(&(ball.velocity - ring.velocity_at(&from_centre))));
        let spin = cylindrical(ring.to_ring(&(ball.spin - ring.spin)));
        let rate = -(velocity.outward * normal[0] + velocity.axial * normal[1]);
        let elastic = self.stiffness * approach * approach.sqrt();
        let load = (elastic * (1.0 + self.damping * rate)).max(0.0);
        // Basis of the contact: along the major axis `(n_z, -n_r)`, along the orbit, normal.
        let across = velocity.outward * normal[1] - velocity.axial * normal[0];
        let about_across = spin.outward * normal[1] - spin.axial * normal[0];
        let about_normal = spin.outward * normal[0] + spin.axial * normal[1];
        let axis = self.unit_axis * load.cbrt();
        let Slipping { force: [f_across, f_orbital], moment: [m_across, m_orbital, m_normal], loss, height } =
            self.traction(load, axis, [across, velocity.orbital], [about_across, spin.orbital, about_normal]);
        let to_fixed = |a: f64, o: f64, n: f64| {
            let (r, z) = (a * normal[1] + n * normal[0], n * normal[1] - a * normal[0]);
            ring.to_fixed(&Vector3::new(r * cos - o * sin, r * sin + o * cos, z))
        };
        Contact {
            approach,
            load,
            force: to_fixed(f_across, f_orbital, load),
            moment: to_fixed(m_across, m_orbital, m_normal),
            direction,
            slip: velocity.orbital + height * about_across,
            spin: about_normal,
            energy: 0.4 * elastic * approach,
            traction_loss: loss,
            damping_loss: (load - elastic) * rate,
        }
    }

    /// Integrates the traction over the major axis. `velocity` is that of the ball's centre against the ring there, across and along the orbit,
    /// `spin` the relative rotation about the axes of the contact.
    fn traction(&self, load: f64, axis: f64, velocity: [f64; 2], spin: [f64; 3]) -> Slipping {
        let bulge = 0.5 / self.deformed_radius;
        let height = self.ball_radius - axis * axis * (0.5 / self.ball_radius - bulge);
        let mut sum = Slipping { height, ..Slipping::default() };
        for (point, weight) in POINTS.iter().zip(WEIGHTS) {
            // Share of the load of Hertz's pressure, integrated across the ellipse.
            let load = 0.75 * weight * (1.0 - point * point) * load;
            let x = point * axis;
            let h = height - x * x * bulge;
            let slip = [velocity[0] - h * spin[1], velocity[1] + x * spin[2] + h * spin[0]];
            let squared = slip[0] * slip[0] + slip[1] * slip[1];
            let ratio = -load * self.traction.ratio(squared.sqrt());
            let force = [ratio * slip[0], ratio * slip[1]];
            sum.force[0] += force[0];
            sum.force[1] += force[1];
            sum.moment[0] += h * force[1];
            sum.moment[1] -= h * force[0];
            sum.moment[2] += x * force[1];
            sum.loss -= ratio * squared;
        }
        sum
    }
}

/// Returns the length of a vector whose size is far from the limits of numbers.
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

impl Contact {
    /// Returns the contact angle, rad.
    pub fn angle(&self) -> f64 {
        let [cos, sin] = self.direction;
        sin.atan2(cos)
    }
}

/// Traction of a contact in its own basis.
#[derive(Default)]
struct Slipping {
    /// Across and along the orbit, N.
    force: [f64; 2],
    /// About the major axis, the orbit, the normal, N m.
    moment: [f64; 3],
    /// W
    loss: f64,
    /// Distance of the contact's centre from the ball's centre, m.
    height: f64,
}
