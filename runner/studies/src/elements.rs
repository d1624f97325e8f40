//! Load, angle, pressure and film of each rolling element at a displacement of the inner ring.

use crate::friction::BallContacts;
use crate::life::ElementLoads;
use ballrace::bearing::Bearing;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::BallState;
use ballrace::bearing::quasi_static::film::{minimum_film, thermal_reduction};
use ballrace::bearing::roller::RollerState;
use ballrace::contact::hertz::Race;
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_models::build::{self, AnyBearing, BearingRollers, ElementContact, Solved, rolling_speed};
use ballrace_plant::error::Result;
use ballrace_scene::{Bearing as BearingScene, Effects, Lubricant, Scene};
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::Arc;

/// One rolling element.
#[derive(Debug, Clone, Serialize)]
pub struct Element {
    /// Name of the bearing.
    pub bearing: String,
    /// Number of the element, from 1.
    pub number: usize,
    /// Azimuth from +X towards +Y, rad.
    pub azimuth: f64,
    /// Load of the inner-race contact, N.
    pub inner_load: f64,
    /// Load of the outer-race contact, N.
    pub outer_load: f64,
    /// Contact angle at the inner race, rad; `None` without load or contact angle.
    pub inner_angle: Option<f64>,
    /// Contact angle at the outer race, rad; `None` without load or contact angle.
    pub outer_angle: Option<f64>,
    /// Maximum Hertzian pressure at the inner race, Pa; `None` where the contact is not known.
    pub inner_pressure: Option<f64>,
    /// Maximum Hertzian pressure at the outer race, Pa; `None` where the contact is not known.
    pub outer_pressure: Option<f64>,
    /// Central film thickness at the inner race, m.
    pub inner_film: f64,
    /// Central film thickness at the outer race, m.
    pub outer_film: f64,
    /// Smaller ratio of minimum film thickness to roughness (lambda) of both contacts; `None` without a roughness in the scene.
    pub film_ratio: Option<f64>,
    /// Centrifugal force, N.
    pub centrifugal: f64,
    /// Gyroscopic moment, N m.
    pub gyroscopic_moment: f64,
    /// Distribution of the load along a roller; `None` for other elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roller: Option<RollerLoads>,
}

impl Element {
    /// Returns its contacts; `None` without load or contact angle.
    pub(crate) fn contacts(&self) -> Option<BallContacts> {
        let angles = [self.inner_angle?, self.outer_angle?];
        Some(BallContacts { loads: [self.inner_load, self.outer_load], angles })
    }

    /// Returns its loads along its length. Centrifugal force loads all laminae of the outer race alike.
    pub(crate) fn loads(&self) -> ElementLoads {
        let Some(roller) = &self.roller else {
            return ElementLoads { row: 1, races: [vec![self.inner_load], vec![self.outer_load]] };
        };
        let further = (self.outer_load - self.inner_load) / roller.lamina_loads.len().max(1) as f64;
        let outer = roller.lamina_loads.iter().map(|load| load + further).collect();
        ElementLoads { row: roller.row, races: [roller.lamina_loads.clone(), outer] }
    }
}

/// Distribution of the load along a roller at the inner race.
#[derive(Debug, Clone, Serialize)]
pub struct RollerLoads {
    /// Row of the roller, from 1.
    pub row: usize,
    /// Tilt of the roller relative to the outer ring, rad.
    pub tilt: f64,
    /// Moment of the loads about the centre of the roller, N m.
    pub moment: f64,
    /// Largest load of a lamina, N.
    pub largest_lamina_load: f64,
    /// Load of each lamina in the order of +Z, N.
    pub lamina_loads: Vec<f64>,
    /// Maximum Hertzian pressure of each lamina in the order of +Z, Pa.
    pub lamina_pressures: Vec<f64>,
}

/// The elements of a bearing, whose states are computed at any displacement.
pub(crate) struct BearingElements {
    of: BearingScene,
    bearing: AnyBearing<f64>,
    geometry: Option<BallBearingGeometry>,
    contact: Option<ElementContact>,
    states: ElementStates,
}

/// Model of the states of the elements.
enum ElementStates {
    /// Rollers by laminae.
    Rollers(BearingRollers),
    /// Balls with their own contacts at the inner and the outer race.
    Balls(Arc<dyn Solved<f64>>),
    /// Elements with the same load at both races.
    Loads,
}

impl BearingElements {
    /// Returns the elements of `of`; `bearing` is its model without preload.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of the model or the kernel rejects one.
    pub(crate) fn try_new(scene: &Scene, of: &BearingScene, bearing: &AnyBearing<f64>) -> Result<Self> {
        let states = match build::roller_states(scene, of)? {
            Some(rollers) => ElementStates::Rollers(rollers),
            None if of.model.has_contact_angle() => ElementStates::Balls(build::quasi_static(of)?),
            None => ElementStates::Loads,
        };
        let (geometry, contact) = (build::geometry(of)?, ElementContact::of(of)?);
        Ok(Self { of: of.clone(), bearing: bearing.clone(), geometry, contact, states })
    }

    /// Returns load, angle, pressure and film of each element for the ring displacement `u`, which contains the preload.
    pub(crate) fn at(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Vec<Element> {
        let of = &self.of;
        let states = match &self.states {
            ElementStates::Rollers(rollers) => return self.rollers(rollers, u, at),
            ElementStates::Balls(solved) => {
                let mut states = vec![BallState::default(); of.elements];
                solved.ball_states(u, at, &mut states);
                Some(states)
            }
            ElementStates::Loads => None,
        };
        let mut loads = vec![0.0; of.elements];
        self.bearing.element_loads(u, at, &mut loads);
        let element = |(j, &load): (usize, &f64)| {
            let state = states.as_ref().and_then(|states| states.get(j));
            let azimuth = build::place::<f64>(of, j).azimuth().wrapping_add(at.cage).radians();
            element(of, (j + 1, azimuth), load, state, (self.geometry.as_ref(), self.contact.as_ref()), at)
        };
        loads.iter().enumerate().map(element).collect()
    }

    /// Returns the loads of each element for the ring displacement `u`, as [`Self::at`] and without its angles and pressures: where nothing but the
    /// races acts on the elements, they follow from the model of the bearing and no ball is solved for.
    pub(crate) fn loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Vec<ElementLoads> {
        if matches!(self.states, ElementStates::Rollers(_)) || self.of.effects != Effects::default() {
            return self.at(u, at).iter().map(Element::loads).collect();
        }
        let mut loads = vec![0.0; self.of.elements];
        self.bearing.element_loads(u, at, &mut loads);
        loads.iter().map(|&load| ElementLoads { row: 1, races: [vec![load], vec![load]] }).collect()
    }

    /// Returns the rollers by laminae, those of a second row after the first.
    fn rollers(
        &self,
        BearingRollers { count, states: bearing }: &BearingRollers,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> Vec<Element> {
        let (of, contact) = (&self.of, self.contact.as_ref());
        let laminae = of.rollers.as_ref().map_or(0, |rollers| rollers.laminae);
        let mut states = vec![RollerState::default(); *count];
        bearing.roller_states(u, at, &mut states);
        // A lamina has its share of the length.
        let pressure = |race, load: f64| contact.map(|contact| contact.pressure(race, laminae as f64 * load));
        let half_pitch = PI / of.elements.max(1) as f64;
        let roller = |(j, state): (usize, &RollerState<f64>)| {
            let (row, place) = (j / of.elements.max(1), j % of.elements.max(1));
            let azimuth = build::place::<f64>(of, place).azimuth().wrapping_add(at.cage);
            let azimuth = azimuth.wrapping_add(Phase::from_radians(row as f64 * half_pitch)).radians();
            let mut loads = vec![0.0; laminae];
            bearing.lamina_loads(u, at, j, &mut loads);
            let lamina_pressures = loads.iter().filter_map(|load| pressure(Race::Inner, *load)).collect();
            let (inner_load, outer_load) = (state.inner.load, state.outer.load);
            Element {
                outer_load,
                inner_pressure: pressure(Race::Inner, state.inner.largest_lamina_load),
                outer_pressure: pressure(Race::Outer, state.outer.largest_lamina_load),
                centrifugal: outer_load - inner_load,
                roller: Some(RollerLoads {
                    tilt: state.tilt,
                    moment: state.inner.moment,
                    largest_lamina_load: state.inner.largest_lamina_load,
                    row: row + 1,
                    lamina_loads: loads,
                    lamina_pressures,
                }),
                ..element(of, (j + 1, azimuth), inner_load, None, (None, None), at)
            }
        };
        states.iter().enumerate().map(roller).collect()
    }
}

fn element(
    of: &BearingScene,
    (number, azimuth): (usize, f64),
    load: f64,
    state: Option<&BallState<f64>>,
    (geometry, contact): (Option<&BallBearingGeometry>, Option<&ElementContact>),
    at: &BearingKinematicState<f64>,
) -> Element {
    let (inner_load, outer_load) = state.map_or((load, load), |s| (s.inner_load, s.outer_load));
    let pressure = |race, load: f64| contact.map(|contact| contact.pressure(race, load));
    let angle = |load: f64, [cos, sin]: [f64; 2]| (load > 0.0).then(|| sin.atan2(cos));
    Element {
        bearing: of.name.clone(),
        number,
        azimuth,
        inner_load,
        outer_load,
        inner_angle: state.and_then(|s| angle(inner_load, s.inner_direction)),
        outer_angle: state.and_then(|s| angle(outer_load, s.outer_direction)),
        inner_pressure: pressure(Race::Inner, inner_load),
        outer_pressure: pressure(Race::Outer, outer_load),
        inner_film: state.map_or(0.0, |s| s.inner_film),
        outer_film: state.map_or(0.0, |s| s.outer_film),
        film_ratio: state.zip(geometry).zip(of.effects.film).and_then(|((s, g), oil)| film_ratio(s, g, oil, at)),
        centrifugal: state.map_or(0.0, |s| s.centrifugal),
        gyroscopic_moment: state.map_or(0.0, |s| s.gyroscopic_moment),
        roller: None,
    }
}

/// Returns the smallest ratio of film to roughness of both contacts (`docs/src/models.md#oil-film`).
fn film_ratio(
    s: &BallState<f64>,
    g: &BallBearingGeometry,
    lubricant: Lubricant,
    at: &BearingKinematicState<f64>,
) -> Option<f64> {
    let roughness = lubricant.roughness?;
    let oil = lubricant.for_film();
    let (gamma, ratio) = (g.gamma(), g.ball_diameter / g.pitch_diameter);
    let half = 0.5 * g.pitch_diameter;
    // A massless ball has the speed of the ideal cage.
    let ideal = rolling_speed(gamma, at.inner_speed, at.outer_speed);
    let orbital = if s.centrifugal > 0.0 { s.orbital_speed } else { ideal };
    let near = (at.inner_speed - orbital).abs() * half * (1.0 - ratio * s.inner_direction[0]);
    let far = (orbital - at.outer_speed).abs() * half * (1.0 + ratio * s.outer_direction[0]);
    let least = |race, along: f64, speed, load: f64| {
        let contact = g.contact(race);
        let left = lubricant.inlet_heating.map_or(1.0, |heating| {
            let pressure = contact.ellipse(load).2 / contact.effective_modulus;
            thermal_reduction(oil.viscosity, heating.of_film(), speed, pressure)
        });
        (load > 0.0).then(|| left * minimum_film(oil, &contact, along, speed, load))
    };
    let inner = least(Race::Inner, 0.5 * g.ball_diameter * (1.0 - gamma), near, s.inner_load);
    let outer = least(Race::Outer, 0.5 * g.ball_diameter * (1.0 + gamma), far, s.outer_load);
    [inner, outer].into_iter().flatten().reduce(f64::min).map(|h| h / roughness)
}
