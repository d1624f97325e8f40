//! Friction of a bearing and the power that it costs, by the equations of Palmgren and the spin of balls in their contacts.
//!
//! Sources: Palmgren, Grundlagen der Waelzlagertechnik; factors by Harris and Kotzalas, Rolling Bearing Analysis, chapter on friction (`f1` of
//! needles: ISO 15312). They are means over makers: the moment of one bearing may differ by a third, and `f0` and `f1` of its catalogue are
//! better.

use crate::life::BearingLife;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::contact::hertz::Race;
use ballrace_models::build::{self, BuildError};
use ballrace_scene::{Bearing, LubricationMethod, RaceControl, RollerKind};
use serde::Serialize;
use std::f64::consts::TAU;

/// Friction of one bearing at its speed, load and temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BearingFriction {
    /// Temperature of the lubricant, K.
    pub temperature: f64,
    /// Kinematic viscosity of the oil at this temperature, m^2/s.
    pub viscosity: f64,
    /// Moment by the viscosity of the oil and its churning, `M_0`, N m.
    pub viscous_moment: f64,
    /// Moment by the load: hysteresis and sliding in the contacts, `M_1`, N m.
    pub load_moment: f64,
    /// Moment by the spin of the balls in their contacts, N m; 0 without contact angle.
    pub spin_moment: f64,
    /// Sum of the moments, N m.
    pub moment: f64,
    /// Power that becomes heat, W.
    pub power: f64,
}

/// Contacts of one ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BallContacts {
    /// Loads at the inner and at the outer race, N.
    pub loads: [f64; 2],
    /// Contact angles there, rad.
    pub angles: [f64; 2],
}

/// Kind of a bearing in the tables.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    DeepGroove,
    AngularContact,
    Rollers(RollerKind),
}

impl Kind {
    /// `f0` with grease, oil mist, oil bath and oil jet; the mean where the source has a range by series.
    const fn viscous(self, method: LubricationMethod) -> f64 {
        let [grease, mist, bath, jet] = match self {
            Self::DeepGroove => [1.35, 1.0, 2.0, 4.0],
            Self::AngularContact => [2.0, 1.7, 3.3, 6.6],
            Self::Rollers(RollerKind::Cylindrical) => [0.8, 2.1, 3.1, 3.1],
            Self::Rollers(RollerKind::Needle) => [12.0, 6.0, 12.0, 24.0],
            Self::Rollers(RollerKind::Tapered) => [6.0, 3.0, 6.0, 9.0],
            Self::Rollers(RollerKind::Spherical) => [5.2, 2.6, 5.2, 10.5],
        };
        match method {
            LubricationMethod::Grease => grease,
            LubricationMethod::OilMist => mist,
            LubricationMethod::OilBath => bath,
            LubricationMethod::OilJet => jet,
        }
    }

    /// `f1`: `z (P_0/C_0)^y` of balls, from the share of the static rating.
    fn load(self, share: f64) -> f64 {
        match self {
            Self::DeepGroove => 5e-4 * share.powf(0.55),
            Self::AngularContact => 1e-3 * share.powf(0.33),
            Self::Rollers(RollerKind::Cylindrical) => 3e-4,
            Self::Rollers(RollerKind::Needle) => 5e-4,
            Self::Rollers(RollerKind::Tapered) => 4e-4,
            Self::Rollers(RollerKind::Spherical) => 4.5e-4,
        }
    }
}

/// Contact angle in degrees and `Y_0` of single-row angular-contact ball bearings, `X_0 = 0.5` (ISO 76:2006, table 3).
const STATIC: [[f64; 2]; 7] =
    [[15.0, 0.46], [20.0, 0.42], [25.0, 0.38], [30.0, 0.33], [35.0, 0.29], [40.0, 0.26], [45.0, 0.22]];
/// Product of viscosity, mm^2/s, and speed, rpm, below which the viscous moment is constant.
const SLOW: f64 = 2000.0;

impl BearingFriction {
    /// Computes the friction under the force on the inner ring, at the speeds of inner and outer ring, rad/s; `None` without lubrication or
    /// where the ratings are not known. `balls`: those with a load at both races and a contact angle.
    ///
    /// # Errors
    /// A geometry that the kernel rejects.
    pub(crate) fn of(
        of: &Bearing,
        balls: &[BallContacts],
        force: &[f64; 5],
        life: Option<&BearingLife>,
        speeds: [f64; 2],
    ) -> Result<Option<Self>, BuildError> {
        let (Some(oil), Some((temperature, viscosity)), Some(life)) = (of.lubrication, of.oil(), life) else {
            return Ok(None);
        };
        let Some([_, pitch]) = of.diameters().or_else(|| listed_diameters(of)) else { return Ok(None) };
        let geometry = build::geometry(of)?;
        let turning = (speeds[0] - speeds[1]).abs();
        let (radial, axial) = (force[0].hypot(force[1]), force[2].abs());
        let (kind, angle) = kind(of);
        let share = equivalent_static(kind, angle, radial, axial) / life.static_rating;
        let by_load = oil.load_factor.unwrap_or_else(|| kind.load(share));
        let load_moment = by_load * driving(kind, angle, radial, axial) * pitch;
        // The equations have mm^2/s, rpm, mm and N mm.
        let (millimetres, drive) = (1e3 * pitch, 1e6 * viscosity * turning * 60.0 / TAU);
        let by_oil = oil.viscous_factor.unwrap_or_else(|| kind.viscous(oil.method));
        let flow = if drive < SLOW { 160.0 } else { drive.powf(2.0 / 3.0) };
        // At rest there is no viscous moment.
        let moves = if turning > 0.0 { 1.0 } else { 0.0 };
        let viscous_moment = moves * 1e-3 * 1e-7 * by_oil * flow * millimetres.powi(3);
        let lost = geometry.map_or(0.0, |g| {
            balls.iter().map(|ball| oil.sliding_friction * spin_loss(ball, &g, of.effects.control)).sum()
        });
        let spin_moment = moves * lost;
        let moment = viscous_moment + load_moment + spin_moment;
        let power = moment * turning;
        Ok(Some(Self { temperature, viscosity, viscous_moment, load_moment, spin_moment, moment, power }))
    }
}

/// Returns element and pitch diameter of the catalogue, m.
fn listed_diameters(of: &Bearing) -> Option<[f64; 2]> {
    let entry = of.catalogue.as_ref()?.listed.entry;
    Some([entry.element_diameter, entry.pitch_diameter].map(|mm| 1e-3 * mm))
}

/// Returns the kind of a bearing and its nominal contact angle, rad.
fn kind(of: &Bearing) -> (Kind, f64) {
    let listed = of.catalogue.as_ref().map(|used| used.listed.entry);
    let rollers = of.rollers.as_ref().map(|rollers| (rollers.kind, rollers.contact_angle));
    let of_entry = || listed.and_then(|entry| Some((entry.kind.rollers()?, entry.contact_angle.to_radians())));
    if let Some((kind, angle)) = rollers.or_else(of_entry) {
        return (Kind::Rollers(kind), angle);
    }
    match crate::life::angular_contact(of) {
        Some(angle) => (Kind::AngularContact, angle),
        None => (Kind::DeepGroove, 0.0),
    }
}

/// Returns the load that drives the friction, N: `P_1` of Palmgren.
fn driving(kind: Kind, angle: f64, radial: f64, axial: f64) -> f64 {
    match kind {
        Kind::DeepGroove => (3.0 * axial - 0.1 * radial).max(radial),
        Kind::AngularContact => (0.9 * axial / angle.tan() - 0.1 * radial).max(radial),
        Kind::Rollers(_) if angle > 0.0 => (0.8 * axial / angle.tan()).max(radial),
        Kind::Rollers(_) => radial,
    }
}

/// Returns the static equivalent load `P_0` of ISO 76, N; only the factor of balls depends on it.
fn equivalent_static(kind: Kind, angle: f64, radial: f64, axial: f64) -> f64 {
    let combined = match kind {
        Kind::DeepGroove => 0.6 * radial + 0.5 * axial,
        Kind::AngularContact => 0.5 * radial + crate::life::interpolated(&STATIC, angle.to_degrees())[1] * axial,
        Kind::Rollers(_) => radial,
    };
    combined.max(radial)
}

/// Returns the power of the spin of one ball in its contacts, over the coefficient of friction and the speed of one ring against the other,
/// m N: `3 Q a E/8` times the speed about the normal of the contact.
fn spin_loss(ball: &BallContacts, g: &BallBearingGeometry, control: RaceControl) -> f64 {
    let [inner, outer] = ball.angles;
    let spins = spin(inner, outer, g.pitch_diameter / g.ball_diameter, control);
    let moment = |(race, load): (Race, f64)| {
        let contact = g.contact(race);
        let (major, _, _) = contact.ellipse(load);
        0.375 * load * major * contact.second_kind
    };
    let contacts = [Race::Inner, Race::Outer].into_iter().zip(ball.loads);
    contacts.zip(spins).map(|(contact, spin)| moment(contact) * spin.abs()).sum()
}

/// Returns the speeds of a ball about the normals of its inner and outer contact over the speed of the inner ring against the outer one.
/// `ratio`: pitch diameter over ball diameter. Pure rolling along both races, no spin on the one in control.
fn spin(inner: f64, outer: f64, ratio: f64, control: RaceControl) -> [f64; 2] {
    // About the axis and radially, over the speed of the race in control against the cage.
    let (along, across) = match control {
        RaceControl::Outer => (1.0 + ratio * outer.cos(), -ratio * outer.sin()),
        RaceControl::Inner => (1.0 - ratio * inner.cos(), ratio * inner.sin()),
    };
    let of_outer = (along * outer.cos() - across * outer.sin()) / (ratio + outer.cos());
    let of_inner = (across * inner.sin() - along * inner.cos()) / (ratio - inner.cos());
    let turning = of_inner - of_outer;
    let about = |angle: f64, ring: f64| (across * angle.cos() + (along - ring) * angle.sin()) / turning;
    [about(inner, of_inner), about(outer, of_outer)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without spin on the race in control; at equal angles the other race has all of it: `sin` of the angle, as both axes differ by it alone.
    #[test]
    fn spin_under_race_control() {
        let (angle, ratio) = (0.5_f64, 5.0);
        let [inner, outer] = spin(angle, angle, ratio, RaceControl::Outer);
        assert!(outer.abs() < 1e-12);
        assert!((inner.abs() - angle.sin()).abs() < 1e-12, "{inner}");
        let [inner, outer] = spin(angle, angle, ratio, RaceControl::Inner);
        assert!(inner.abs() < 1e-12 && (outer.abs() - angle.sin()).abs() < 1e-12);
        assert_eq!(spin(0.0, 0.0, ratio, RaceControl::Outer), [0.0, 0.0]);
        // Angles that differ: the axes of ball and rings give the relative speed of the normals.
        let [inner, outer] = spin(0.7, 0.4, ratio, RaceControl::Outer);
        assert!(outer.abs() < 1e-12 && inner.abs() > 0.7_f64.sin() * 0.9);
    }

    #[test]
    fn loads_of_palmgren() {
        assert_eq!(driving(Kind::DeepGroove, 0.0, 100.0, 0.0), 100.0);
        assert_eq!(driving(Kind::DeepGroove, 0.0, 100.0, 1000.0), 2990.0);
        let angle = 40_f64.to_radians();
        assert!((driving(Kind::AngularContact, angle, 0.0, 1000.0) - 900.0 / angle.tan()).abs() < 1e-9);
        assert!((equivalent_static(Kind::AngularContact, angle, 0.0, 1000.0) - 260.0).abs() < 1e-9);
        assert_eq!(equivalent_static(Kind::DeepGroove, 0.0, 100.0, 10.0), 100.0);
    }
}
