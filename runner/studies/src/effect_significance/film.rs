//! Oil film between balls and races: change of the force, and what the heating of the inlet of the contacts leaves of it.

use super::{Ball, Balls, EffectSignificance, share};
use ballrace::BearingKinematicState;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::film::{central_film, thermal_reduction};
use ballrace::contact::hertz::{PointContact, Race};
use ballrace_models::build::point_contact_load;
use ballrace_scene::{Bearing as BearingScene, InletHeating, Lubricant};

/// Name of the effect of a film that is thinner than the isothermal one.
pub(super) const INLET_HEATING: &str = "inlet-heating";
/// Number of iterations of load and film; each reduces the error by a factor of about ten.
const FILM_ROUNDS: usize = 8;

/// Returns the least share of the films that the heating of their inlets leaves, as a part of a sentence.
pub(super) fn heating_sentence(
    balls: &Balls,
    geometry: &BallBearingGeometry,
    oil: Lubricant,
    at: &BearingKinematicState<f64>,
) -> String {
    let left = |ball: &Ball| {
        let [radial, axial] = ball.heated_film(geometry, oil, at);
        ball.heating(geometry, oil, at, ball.load + radial.hypot(axial))
    };
    let left = balls.0.iter().map(left).fold(1.0, f64::min);
    let of_oil = if oil.inlet_heating.is_some() { "" } else { " of a mineral oil" };
    format!(
        "heating of the inlet reduces the film{of_oil} to {} of the isothermal one; starvation, which is not predicted, reduces it further",
        share(left)
    )
}

/// Returns the significance of a film between balls and races that do not touch without it; empty without such a film.
pub(super) fn film_alone(
    of: &BearingScene,
    balls: &Balls,
    geometry: &BallBearingGeometry,
    at: &BearingKinematicState<f64>,
) -> Vec<EffectSignificance> {
    let Some(oil) = of.effects.film.filter(|_| of.model.properties().effects) else {
        return vec![];
    };
    let carried = |force: &dyn Fn(&Ball) -> [f64; 2]| balls.0.iter().map(force).map(|[x, y]| x.hypot(y)).sum::<f64>();
    let cold = carried(&|ball| ball.film(geometry, oil, at));
    let warm = carried(&|ball| ball.heated_film(geometry, oil, at));
    if cold <= 0.0 {
        return vec![];
    }
    let entry = |effect, change, modelled, because| EffectSignificance {
        bearing: of.name.clone(),
        effect,
        change,
        modelled,
        because,
        at: None,
    };
    vec![
        entry("film", 1.0, true, "the balls carry their load by the film alone".to_owned()),
        entry(
            INLET_HEATING,
            (cold - warm) / cold,
            oil.inlet_heating.is_some(),
            heating_sentence(balls, geometry, oil, at),
        ),
    ]
}

impl Ball {
    /// Returns the speed at which both surfaces enter a contact, m/s, and the ratio of the diameters.
    fn entrainment(&self, g: &BallBearingGeometry, at: &BearingKinematicState<f64>) -> (f64, f64) {
        let gamma = g.ball_diameter / g.pitch_diameter * self.angle.cos();
        (0.25 * g.pitch_diameter * (at.inner_speed - at.outer_speed).abs() * (1.0 - gamma * gamma), gamma)
    }

    /// Returns the share of the isothermal film that the heating of the inlet leaves, at the contact under the larger pressure.
    fn heating(&self, g: &BallBearingGeometry, oil: Lubricant, at: &BearingKinematicState<f64>, load: f64) -> f64 {
        let (speed, _) = self.entrainment(g, at);
        let pressure = [Race::Inner, Race::Outer].map(|race| {
            let contact = g.contact(race);
            if load > 0.0 { contact.ellipse(load).2 / contact.effective_modulus } else { 0.0 }
        });
        let heating = oil.inlet_heating.unwrap_or(InletHeating::MINERAL_OIL);
        thermal_reduction(oil.viscosity, heating.of_film(), speed, pressure[0].max(pressure[1]))
    }

    /// Returns the sum of the central films of both contacts under `load`, m.
    pub(super) fn films(
        &self,
        g: &BallBearingGeometry,
        oil: Lubricant,
        at: &BearingKinematicState<f64>,
        load: f64,
    ) -> f64 {
        let (slide, gamma) = self.entrainment(g, at);
        if slide <= 0.0 {
            return 0.0;
        }
        let film = |race, along: f64| {
            let PointContact { effective_modulus, ellipticity, .. } = g.contact(race);
            central_film(oil.for_film(), effective_modulus, along, ellipticity, slide, load)
        };
        let half = 0.5 * g.ball_diameter;
        film(Race::Inner, half * (1.0 - gamma)) + film(Race::Outer, half * (1.0 + gamma))
    }

    /// Returns the change of the force on the inner ring by the films, whose thickness depends on the load.
    pub(super) fn film(&self, g: &BallBearingGeometry, oil: Lubricant, at: &BearingKinematicState<f64>) -> [f64; 2] {
        self.separated(|load| self.films(g, oil, at, load))
    }

    /// Returns the same by films whose inlet is heated.
    pub(super) fn heated_film(
        &self,
        g: &BallBearingGeometry,
        oil: Lubricant,
        at: &BearingKinematicState<f64>,
    ) -> [f64; 2] {
        self.separated(|load| self.films(g, oil, at, load) * self.heating(g, oil, at, load))
    }

    /// Returns the change of the force on the inner ring by films of the thickness `films` under a load, m.
    fn separated(&self, films: impl Fn(f64) -> f64) -> [f64; 2] {
        let pressed = |load: f64| point_contact_load(self.constants[2], self.approach + films(load));
        let more = (0..FILM_ROUNDS).fold(self.load, |load, _| pressed(load)) - self.load;
        let (sin, cos) = self.angle.sin_cos();
        [more * cos, more * sin]
    }
}
