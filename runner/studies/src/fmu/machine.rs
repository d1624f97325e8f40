//! The machine in a unit: one bearing, or the rotor on its bearings.

use super::Content;
use super::variable::{Causality, DIRECTIONS, Variable, forces, identifier};
use crate::force::bearing_model;
use ballrace::bearing::LastValidWrench;
use ballrace::{Displacement, Status};
use ballrace_models::build::{self, AnyBearing};
use ballrace_models::handle::ForceModel as _;
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result};
use ballrace_plant::motion::Response;
use ballrace_scene::{Bearing, Scene};
use std::f64::consts::TAU;

/// Content of a unit.
pub(super) enum Machine {
    /// A bearing without mass.
    Bearing(Box<BearingForce>),
    /// A rotor with its motion.
    Rotor(Box<RotorMotion>),
}

/// Force of one bearing.
#[derive(Clone)]
pub(super) struct BearingForce {
    scene: Scene,
    bearing: Bearing,
    model: AnyBearing<f64>,
    held: LastValidWrench<f64>,
}

/// Motion of a rotor.
pub(super) struct RotorMotion {
    scene: Scene,
    plant: Plant,
    rate: f64,
    /// Displacement along each external force per unit of each coordinate.
    rows: Vec<Vec<f64>>,
    response: Response,
    /// Motion and forces of the present sample, which are computed once: the solution of a bearing starts from its last one.
    row: Vec<f64>,
    status: Status,
}

impl Machine {
    pub fn try_new(scene: &Scene, content: &Content) -> Result<Self> {
        Ok(match content {
            Content::Bearing { name } => {
                let bearing = build::pick(scene, Some(name)).map_err(Error::setup)?;
                build::check_has_forces(scene, bearing)?;
                let model = bearing_model(scene, bearing, bearing.model)?;
                let (scene, bearing) = (scene.clone(), bearing.clone());
                Self::Bearing(Box::new(BearingForce { scene, bearing, model, held: LastValidWrench::new() }))
            }
            Content::Rotor { rate } => Self::Rotor(Box::new(RotorMotion::try_new(scene, *rate)?)),
        })
    }

    /// Returns the variables: time, inputs, outputs, status.
    pub fn variables(&self) -> Vec<Variable> {
        let mut variables = vec![Variable::time()];
        match self {
            Self::Bearing(bearing) => variables.extend(bearing.variables()),
            Self::Rotor(rotor) => rotor.add_variables(&mut variables),
        }
        variables.push(Variable::status());
        variables
    }

    pub fn internal_step(&self) -> Option<f64> {
        match self {
            Self::Bearing(_) => None,
            Self::Rotor(rotor) => Some(rotor.response.period()),
        }
    }

    pub fn reset(&mut self) -> Result<()> {
        match self {
            Self::Bearing(bearing) => bearing.held = LastValidWrench::new(),
            Self::Rotor(rotor) => rotor.restart(Response::start(&rotor.scene, &rotor.plant, rotor.rate)?),
        }
        Ok(())
    }

    pub fn copy(&self) -> Self {
        match self {
            Self::Bearing(bearing) => Self::Bearing(bearing.clone()),
            Self::Rotor(rotor) => Self::Rotor(Box::new(rotor.copy())),
        }
    }

    /// Computes the outputs at these inputs.
    pub fn evaluate(&mut self, inputs: &[f64], time: f64, outputs: &mut Vec<f64>) -> Result<()> {
        match self {
            Self::Bearing(bearing) => bearing.evaluate(inputs, time, outputs),
            Self::Rotor(rotor) => {
                rotor.write(outputs);
                Ok(())
            }
        }
    }

    /// Advances by internal steps and computes the outputs; returns the time, s.
    pub fn advance(&mut self, inputs: &[f64], steps: u64, outputs: &mut Vec<f64>) -> Result<f64> {
        let Self::Rotor(rotor) = self else { return Ok(0.0) };
        rotor.set_load(inputs);
        rotor.status = Status::OK;
        for _ in 0..steps {
            rotor.status = rotor.status.union(rotor.response.advance()?);
            rotor.sample();
        }
        rotor.write(outputs);
        Ok(rotor.response.now().time)
    }
}

impl BearingForce {
    fn variables(&self) -> Vec<Variable> {
        let input = |name: &str, unit, meaning: String| Variable::new(Causality::Input, name, Some(unit), meaning);
        let displacements = DIRECTIONS.map(|(name, _, along, unit, _)| {
            input(name, unit, format!("{} of the inner ring against the outer ring", motion_along(unit, along)))
        });
        let angle = input("angle", "rad", "Angle of the shaft from that at time 0, of any number of turns".to_owned());
        let speed = input("speed", "rad/s", "Speed of the shaft".to_owned());
        let speed = Variable { start: self.scene.shaft.speed.nominal(), ..speed };
        displacements.into_iter().chain([angle, speed]).chain(forces("", &self.bearing.name)).collect()
    }

    fn evaluate(&mut self, inputs: &[f64], time: f64, outputs: &mut Vec<f64>) -> Result<()> {
        let &[u, v, w, thu, thv, angle, speed] = inputs else { return Ok(()) };
        // The kernel's angles are finite by type: where an angle is not, the displacement is marked instead.
        let is_turned = angle.is_finite() && speed.is_finite();
        let u = if is_turned { [u, v, w, thu, thv] } else { [f64::NAN; 5] };
        let shaft = if is_turned { (angle / TAU, speed) } else { (0.0, 0.0) };
        let at = build::rotation(&self.scene, &self.bearing, shaft, time)?;
        let (wrench, status) = self.model.sample(&mut self.held, &Displacement::from_array(u), &at);
        outputs.clear();
        outputs.extend(wrench.to_array());
        outputs.push(status.bits().into());
        Ok(())
    }
}

impl RotorMotion {
    fn try_new(scene: &Scene, rate: f64) -> Result<Self> {
        let plant = Plant::try_new(scene).map_err(Error::setup)?;
        let (rows, response) = (plant.external_rows(), Response::start(scene, &plant, rate)?);
        let (scene, row) = (scene.clone(), vec![]);
        let mut rotor = Self { scene, plant, rate, rows, response, row, status: Status::OK };
        rotor.sample();
        Ok(rotor)
    }

    fn restart(&mut self, response: Response) {
        (self.response, self.status) = (response, Status::OK);
        self.sample();
    }

    fn copy(&self) -> Self {
        let (scene, plant, response) = (self.scene.clone(), self.plant.clone(), self.response.copy());
        Self { scene, plant, response, rows: self.rows.clone(), row: self.row.clone(), ..*self }
    }

    fn sample(&mut self) {
        self.row.clear();
        let now = self.response.now();
        self.row.extend(now.row().skip(1));
        if self.has_load_place() {
            // Displacement, then rate, of the place of the external force.
            for coordinates in [now.twin.coordinates(), now.twin.rates()] {
                let at = |along: &Vec<f64>| along.iter().zip(coordinates).map(|(row, q)| row * q).sum::<f64>();
                self.row.extend(self.rows.iter().map(at));
            }
        }
    }

    /// Returns true where the place of the external force moves apart from the centre of mass: on a rotor that bends.
    fn has_load_place(&self) -> bool {
        self.plant.layout.flexible().is_some()
    }

    fn write(&self, outputs: &mut Vec<f64>) {
        outputs.clone_from(&self.row);
        outputs.push(self.status.bits().into());
    }

    fn set_load(&mut self, inputs: &[f64]) {
        let mut load = vec![0.0; self.plant.layout.order];
        for (row, force) in self.rows.iter().zip(inputs) {
            load.iter_mut().zip(row).for_each(|(load, along)| *load += along * force);
        }
        self.response.twin().set_load(&load);
    }

    fn add_variables(&self, variables: &mut Vec<Variable>) {
        let (names, mounted) = (self.plant.layout.names(&self.plant.bearings), &self.plant.bearings);
        if self.plant.layout.is_given() {
            variables.extend(names.iter().zip(1..).map(|(name, i)| {
                let meaning = format!("External force along the coordinate {name}");
                Variable::new(Causality::Input, format!("F{i}"), None, meaning)
            }));
        } else {
            variables.extend(DIRECTIONS.map(|(_, name, along, _, unit)| {
                let kind = if unit == "N" { "force" } else { "moment" };
                let meaning = format!("External {kind} {along} on the rotor where the scene's load acts");
                Variable::new(Causality::Input, name, Some(unit), meaning)
            }));
        }
        let first = variables.len();
        let coordinates: Vec<Coordinate> = names.iter().enumerate().map(|(i, name)| self.coordinate(i, name)).collect();
        for Coordinate { name, units, meaning } in &coordinates {
            let unit = units.map(|[unit, _]| unit);
            variables.push(Variable::new(Causality::Output, name.as_str(), unit, meaning.as_str()));
        }
        for (i, Coordinate { name, units, meaning }) in coordinates.iter().enumerate() {
            let (unit, meaning) = (units.map(|[_, unit]| unit), format!("Rate: {meaning}"));
            let rate = Variable::new(Causality::Output, format!("der({name})"), unit, meaning);
            variables.push(Variable { rate_of: Some(first + i), ..rate });
        }
        variables.extend(mounted.iter().flat_map(|one| forces(&format!("{}.", identifier(&one.name)), &one.name)));
        if self.has_load_place() {
            let first = variables.len();
            for (name, _, along, unit, _) in DIRECTIONS {
                let meaning = format!("{} where the external force acts", motion_along(unit, along));
                variables.push(Variable::new(Causality::Output, format!("load.{name}"), Some(unit), meaning));
            }
            for (i, (name, _, along, unit, _)) in DIRECTIONS.into_iter().enumerate() {
                let meaning = format!("Rate: {} where the external force acts", motion_along(unit, along));
                let unit = if unit == "m" { "m/s" } else { "rad/s" };
                let rate = Variable::new(Causality::Output, format!("der(load.{name})"), Some(unit), meaning);
                variables.push(Variable { rate_of: Some(first + i), ..rate });
            }
        }
    }

    /// Describes the coordinate `i` with this name in the plant: those of the centre of mass are first, then those of bending, which
    /// have no unit, of supports and of balls.
    fn coordinate(&self, i: usize, name: &str) -> Coordinate {
        let (length, angle) = (["m", "m/s"], ["rad", "rad/s"]);
        let (units, meaning) = match DIRECTIONS.get(i).filter(|_| !self.plant.layout.is_given()) {
            Some(&(_, _, along, unit, _)) => {
                let units = if unit == "m" { length } else { angle };
                (Some(units), format!("{} of the centre of mass", motion_along(unit, along)))
            }
            None => {
                let is_length = i >= self.plant.layout.rotor_order();
                (is_length.then_some(length), format!("Coordinate {name}"))
            }
        };
        Coordinate { name: identifier(name), units, meaning }
    }
}

/// Names a displacement in a direction, or a rotation about it.
fn motion_along(unit: &str, along: &str) -> String {
    format!("{} {along}", if unit == "m" { "Displacement" } else { "Rotation" })
}

/// One coordinate of a rotor.
struct Coordinate {
    name: String,
    /// Units of the coordinate and of its rate.
    units: Option<[&'static str; 2]>,
    meaning: String,
}
