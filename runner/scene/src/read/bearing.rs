//! One `[[bearing]]`: which keys go together with which model, and whether its parts can exist.

use std::f64::consts::PI;

use super::super::bearing::STEEL_DENSITY;
use super::super::key::Key;
use super::super::model::{ModelProperties, choice_of, models_with};
use super::super::multibody;
use super::super::table::{Node, Read, Table};
use super::super::units::Dimension;
use super::super::{
    Axial, Bearing, CageRunout, Coordinates, Defect, DefectShape, Facing, FreeAngle, Geometry, Law, Linear, Model,
    ModelInput, OuterRing, Support, Surface, Wave,
};
use super::kinematics;
use super::pitch_circle::{ROLLER_DIAMETER, check_fit_on_pitch_circle, contact_angle, elements, pitch_diameter};
use super::rollers;

/// `facing`
pub(super) const FACINGS: [(&str, Facing); 3] = [("+z", Facing::PlusZ), ("-z", Facing::MinusZ), ("both", Facing::Both)];
/// `surface` of damage and waves
pub(super) const SURFACES: [(&str, Surface); 4] =
    [("inner", Surface::Inner), ("outer", Surface::Outer), ("ball", Surface::Ball(0)), ("element", Surface::Ball(0))];
/// `shape` of damage
pub(super) const DEFECT_SHAPES: [(&str, DefectShape); 2] =
    [("half-sine", DefectShape::HalfSine), ("rectangular", DefectShape::Rectangular)];
/// `direction` of waves: axial or not
pub(super) const WAVE_DIRECTIONS: [(&str, bool); 2] = [("radial", false), ("axial", true)];

/// Any of these starts a geometry, which then needs the first four and one of the next two.
const GEOMETRY: [&str; 9] = [
    "ball_diameter",
    "pitch_diameter",
    "inner_conformity",
    "outer_conformity",
    "contact_angle",
    "diametral_clearance",
    "youngs_modulus",
    "poissons_ratio",
    "density",
];

/// The key that names a bearing of the catalogue.
pub(super) const DESIGNATION: &str = "bearing";

/// Keys of the lumped model alone.
pub(super) const LUMPED: [&str; 6] =
    ["stiffness", "exponent", "radial_play", "axial", "housing_displacement", "outer_ring"];

/// The three sources of a linear bearing.
const LINEAR: [&str; 3] = ["stiffness_matrix", "two_spring", "linearise"];

/// Young's modulus of bearing steel, Pa.
pub(super) const YOUNGS_MODULUS: f64 = 206e9;
/// Poisson's ratio of bearing steel.
pub(super) const POISSONS_RATIO: f64 = 0.3;
/// Exponent of the point contact of Hertz, which is also the default of a law given directly.
const HERTZ_EXPONENT: f64 = 1.5;
/// Largest thickness of a thin ring over its radius.
const THIN: f64 = 0.4;
/// Highest order of the shape of an outer ring that bends, where the scene gives none. The stiffness grows with the fourth power: higher ones
/// hardly take part.
const RING_ORDERS: usize = 6;

/// Number of rolling elements for which the two-spring formula has its ratios.
const TWO_SPRING_ELEMENTS: std::ops::RangeInclusive<usize> = 8..=16;

/// Returns the table of a bearing after a check of its keys.
pub(super) fn table<'a>(node: &Node<'a>) -> Read<Table<'a>> {
    node.table()
}

/// Reads and checks one bearing.
pub(super) fn read(table: &Table<'_>, root: &Table<'_>) -> Read<Bearing> {
    let expected = "a name, such as \"DE\"";
    let on_system = root.has("system");
    let model = model(table)?;
    let (elements, kinematics) = match kinematics::read(table, model)? {
        Some((elements, kinematics)) => (elements, Some(kinematics)),
        None => (elements(table)?, None),
    };
    let linear = linear(table, model)?;
    let required = required_input(model, linear.as_ref());
    let evaluated = if let Some(Linear::Of(source)) = linear { source } else { model };
    let (rollers, geometry, law) = if rollers::has_rollers(table, required) {
        let (rollers, law) = rollers::read(table, evaluated, elements)?;
        (Some(rollers), None, Some(law))
    } else {
        rollers::check_without_rollers(table, required)?;
        let (geometry, law) = (geometry(table, required)?, law(table, required)?);
        check_law(table, required, geometry.as_ref(), law.as_ref())?;
        (None, geometry, law)
    };
    check_two_spring(table, elements, linear.as_ref())?;
    if let Some(Geometry { ball_diameter, pitch_diameter, .. }) = geometry {
        check_fit_on_pitch_circle(table, elements, ("ball_diameter", ball_diameter), pitch_diameter)?;
    }
    check_moving_elements(table, model, geometry.as_ref())?;
    Ok(Bearing {
        name: table.required("name", expected)?.text(expected)?.to_owned(),
        station: station(table, root)?,
        facing: table.read("facing", facing)?.unwrap_or(Facing::Both),
        model,
        elements,
        first_element_azimuth: table.optional_quantity("first_element_azimuth")?.unwrap_or(0.0),
        cage_ratio: cage_ratio(table, model, geometry.is_some() || rollers.is_some() || table.has(DESIGNATION))?,
        kinematics,
        rollers,
        axial: table.read("axial", axial)?,
        outer_ring: outer_ring(table)?,
        housing_displacement: table.read("housing_displacement", |n| housing(n, elements))?.unwrap_or_default(),
        defect: defects(table, model, elements)?,
        waviness: waviness(table, model)?,
        effects: super::effects::read(table, model)?,
        lubricant: super::effects::lubricant(table)?,
        preload: super::effects::preload(table, model)?,
        outer_ring_tilt: outer_ring_tilt(table, model)?,
        table: super::effects::table_range(table, model)?,
        coordinates: coordinates(table, "coordinates", on_system)?,
        housing_coordinates: coordinates(table, "housing_coordinates", on_system)?,
        support: table.read("support", support)?,
        element_azimuths: table.read("element_azimuths", |n| azimuths(n, elements))?.unwrap_or_default(),
        cage_runout: table.read("cage_runout", |n| cage_runout(n, geometry.as_ref()))?,
        own: own(table, model)?,
        geometry,
        law,
        linear,
        catalogue: None,
        mounting: None,
        ratings: [table.optional_quantity("dynamic_rating")?, table.optional_quantity("static_rating")?],
        lubrication: None,
        cooling: None,
    })
}

/// `model`
pub(super) fn all_models() -> Vec<(&'static str, Model)> {
    Model::with_forces().map(|model| (model.name(), model)).collect()
}

fn model(table: &Table<'_>) -> Read<Model> {
    match table.optional("model") {
        Some(node) => {
            let model = node.choice(&all_models())?;
            Ok(if table.has(ROLLER_DIAMETER) { model.for_rollers() } else { model })
        }
        None => kinematics::check_without_model(table).map(|()| Model::Kinematics),
    }
}

fn facing(node: &Node<'_>) -> Read<Facing> {
    node.choice(&FACINGS)
}

/// Returns the values that determine required and rejected keys.
fn required_input(model: Model, linear: Option<&Linear>) -> ModelInput {
    match linear {
        None | Some(Linear::Matrix(_)) => model.properties().input,
        Some(Linear::TwoSpring { .. }) => ModelInput::ContactAngle,
        Some(Linear::Of(source)) => source.properties().input,
    }
}

/// Rejects keys that other models take: those whose properties pass `has`.
fn check_only_with(table: &Table<'_>, keys: &[&str], model: Model, has: impl Fn(&ModelProperties) -> bool) -> Read<()> {
    if has(model.properties()) {
        return Ok(());
    }
    table.check_without(keys, &format!("only with model = {}; remove it", choice_of(models_with(has))))
}

/// Returns the models with a load-deflection law of their own keys.
fn models_with_law() -> String {
    choice_of(models_with(|of| of.input == ModelInput::Law && !of.moving_elements))
}

fn linear(table: &Table<'_>, model: Model) -> Read<Option<Linear>> {
    let has_stiffness = |of: &ModelProperties| of.input == ModelInput::Stiffness;
    check_only_with(table, &LINEAR, model, has_stiffness)?;
    if !has_stiffness(model.properties()) {
        return Ok(None);
    }
    check_one_source(table)?;
    if let Some(matrix) = table.read("stiffness_matrix", stiffness_matrix)? {
        return Ok(Some(Linear::Matrix(matrix)));
    }
    if let Some(two_spring) = table.read("two_spring", two_spring)? {
        return Ok(Some(two_spring));
    }
    let source = table.read("linearise", |n| n.choice(&linearised_models()))?;
    Ok(source.map(|of| Linear::Of(if table.has(ROLLER_DIAMETER) { of.for_rollers() } else { of })))
}

/// `linearise`
pub(super) fn linearised_models() -> Vec<(&'static str, Model)> {
    let mut models: Vec<_> = models_with(|of| of.linearise).map(|model| (model.name(), model)).collect();
    models.sort_unstable_by_key(|(name, _)| *name);
    models
}

/// Checks that a linear bearing has exactly one source of its stiffness. None is the default: each means another stiffness.
fn check_one_source(table: &Table<'_>) -> Read<()> {
    let choice = "exactly one of stiffness_matrix = [5 rows of 5], \
                  two_spring = { static_load = \"500 N\" } and linearise = \"angular\" or \"lumped\"";
    let given: Vec<Node<'_>> = LINEAR.iter().filter_map(|key| table.optional(key)).collect();
    match given.as_slice() {
        [_] => Ok(()),
        [] => {
            let found = format!("model = \"linear\" with none of {}", LINEAR.join(", "));
            Err(table.fail(found, choice))
        }
        [_, second, ..] => {
            let found = format!("{} of {}", given.len(), LINEAR.join(", "));
            Err(second.fail(found, choice))
        }
    }
}

fn stiffness_matrix(node: &Node<'_>) -> Read<[[f64; 5]; 5]> {
    let expected = "5 rows of 5: force along X, Y, Z and moment about X, Y per displacement along X, Y, Z and rotation \
                 about X, Y, in N/m, N, N/rad and N m/rad";
    let rows = node.list(expected)?;
    if rows.len() != 5 {
        return Err(node.fail(format!("a list of {}", rows.len()), expected));
    }
    let mut matrix = [[0.0; 5]; 5];
    for (slot, row) in matrix.iter_mut().zip(&rows) {
        *slot = row.array(expected)?;
    }
    Ok(matrix)
}

fn two_spring(node: &Node<'_>) -> Read<Linear> {
    let table = node.table()?;
    Ok(Linear::TwoSpring { static_load: table.quantity("static_load")? })
}

fn check_two_spring(table: &Table<'_>, elements: usize, linear: Option<&Linear>) -> Read<()> {
    if !matches!(linear, Some(Linear::TwoSpring { .. })) || TWO_SPRING_ELEMENTS.contains(&elements) {
        return Ok(());
    }
    let expected = "8 to 16 with two_spring, where its formula has its ratios";
    Err(table.required("elements", expected)?.refuse(expected))
}

fn geometry(table: &Table<'_>, required: ModelInput) -> Read<Option<Geometry>> {
    let is_absent = required != ModelInput::ContactAngle && !GEOMETRY.iter().any(|key| table.has(key));
    if is_absent || required == ModelInput::Orders {
        return Ok(None);
    }
    check_complete(table)?;
    let ball_diameter = table.quantity("ball_diameter")?;
    let pitch_diameter = pitch_diameter(table, ("ball_diameter", ball_diameter))?;
    let inner_conformity = conformity(table, "inner_conformity")?;
    let outer_conformity = conformity(table, "outer_conformity")?;
    let groove_centres = (inner_conformity + outer_conformity - 1.0) * ball_diameter;
    Ok(Some(Geometry {
        ball_diameter,
        pitch_diameter,
        inner_conformity,
        outer_conformity,
        fit: fit(table, required, groove_centres)?,
        youngs_modulus: table.optional_quantity("youngs_modulus")?.unwrap_or(YOUNGS_MODULUS),
        poissons_ratio: table
            .read("poissons_ratio", |n| n.number("0 or more and below 0.5"))?
            .unwrap_or(POISSONS_RATIO),
        density: table.optional_quantity("density")?.unwrap_or(STEEL_DENSITY),
    }))
}

/// Rejects an incomplete geometry; the error lists all missing keys.
fn check_complete(table: &Table<'_>) -> Read<()> {
    let (always, _) = GEOMETRY.split_at(4);
    let missing: Vec<&str> = always.iter().copied().filter(|key| !table.has(key)).collect();
    let Some(first) = missing.first() else {
        return Ok(());
    };
    let expected = format!(
        "a complete geometry: all of {} and one of contact_angle and diametral_clearance (missing here: {})",
        always.join(", "),
        missing.join(", ")
    );
    Err(table.missing(first, &expected))
}

fn conformity(table: &Table<'_>, key: &str) -> Read<f64> {
    let range = "a number above 0.5 and at most 1 (groove radius / ball diameter), usually 0.51 to 0.54";
    table.required(key, range)?.number(range)
}

/// `groove_centres` is the distance A of the groove centres at first contact.
fn fit(table: &Table<'_>, required: ModelInput, groove_centres: f64) -> Read<FreeAngle> {
    let choice = "exactly one of contact_angle (such as \"40 deg\") \
                  and diametral_clearance (such as \"10 um\")";
    match (table.optional("contact_angle"), table.optional("diametral_clearance")) {
        (Some(angle), None) => contact_angle(&angle).map(FreeAngle::ContactAngle),
        (None, Some(clearance)) => {
            diametral_clearance(&clearance, required, groove_centres).map(FreeAngle::DiametralClearance)
        }
        (Some(_), Some(clearance)) => Err(clearance.fail("both contact_angle and diametral_clearance", choice)),
        (None, None) => Err(table.fail("neither contact_angle nor diametral_clearance", choice)),
    }
}

/// The clearance s gives the free contact angle by `cos(alpha_0) = 1 - s/(2 A)`; s below A keeps it below 60 degrees,
/// and a negative one, an interference, leaves none.
fn diametral_clearance(node: &Node<'_>, required: ModelInput, groove_centres: f64) -> Read<f64> {
    let most = format!("{} um", micrometres(groove_centres));
    let (least, range) = if required == ModelInput::ContactAngle {
        let range = format!("from 0 to below {most} (an interference only with model = {})", models_with_law());
        (0.0, range)
    } else {
        (-groove_centres, format!("between -{most} and {most}"))
    };
    let expected = format!("a length {range}, as {most} is the distance of the groove centres");
    node.limited(&expected, |s| s >= least && s < groove_centres)
}

/// Returns a length in um, rounded to 0.1 um, for messages.
fn micrometres(metres: f64) -> f64 {
    (metres * 1e7).round() / 10.0
}

fn law(table: &Table<'_>, required: ModelInput) -> Read<Option<Law>> {
    if required != ModelInput::Law {
        let models = models_with_law();
        let why = format!("only with model = {models} (or linearise = {models}); remove it");
        return table.check_without(&LUMPED, &why).map(|()| None);
    }
    if !LUMPED.iter().take(3).any(|key| table.has(key)) {
        return Ok(None);
    }
    let exponent = exponent(table)?;
    let contact = Dimension::ContactStiffness(exponent);
    Ok(Some(Law {
        stiffness: table.read("stiffness", |n| n.quantity_in(contact))?,
        exponent,
        radial_play: table.optional_quantity("radial_play")?,
    }))
}

fn exponent(table: &Table<'_>) -> Read<f64> {
    let range = "1 to 3, 1.5 for balls (F = stiffness * deflection^exponent)";
    let exponent = table.read("exponent", |n| n.number(range))?;
    Ok(exponent.unwrap_or(HERTZ_EXPONENT))
}

/// The lumped model takes stiffness and play from the law, and from geometry what the law does not give.
fn check_law(table: &Table<'_>, required: ModelInput, geometry: Option<&Geometry>, law: Option<&Law>) -> Read<()> {
    if required != ModelInput::Law {
        return Ok(());
    }
    if law.and_then(|l| l.stiffness).is_none() {
        check_stiffness_from_geometry(table, geometry, law)?;
    }
    let from_clearance = geometry.is_some_and(|g| matches!(g.fit, FreeAngle::DiametralClearance(_)));
    if law.and_then(|l| l.radial_play).is_none() && !from_clearance {
        let expected = "half the diametral clearance, such as \"5 um\" (negative is preload); or the geometry of the \
                     bearing with diametral_clearance";
        return Err(table.missing("radial_play", expected));
    }
    Ok(())
}

fn check_stiffness_from_geometry(table: &Table<'_>, geometry: Option<&Geometry>, law: Option<&Law>) -> Read<()> {
    let exponent = law.map_or(HERTZ_EXPONENT, |l| l.exponent);
    let stiffness = Dimension::ContactStiffness(exponent).expected("above 0");
    if geometry.is_none() {
        let expected = format!("{stiffness}; or the geometry of the bearing: ball_diameter and so on");
        return Err(table.missing("stiffness", &expected));
    }
    if exponent == HERTZ_EXPONENT {
        return Ok(());
    }
    let expected = "1.5, as the stiffness comes from the geometry by Hertz; or give stiffness as well";
    Err(table.required("exponent", expected)?.refuse(expected))
}

fn axial(node: &Node<'_>) -> Read<Axial> {
    let table = node.table()?;
    let exponent = exponent(&table)?;
    let contact = Dimension::ContactStiffness(exponent);
    Ok(Axial {
        stiffness: table.required("stiffness", &contact.expected("above 0"))?.quantity_in(contact)?,
        exponent,
        play: table.quantity("play")?,
        radius: table.quantity("radius")?,
    })
}

fn housing(node: &Node<'_>, elements: usize) -> Read<Vec<[f64; 3]>> {
    let expected = format!(
        "a list of {elements} entries [x, y, z], the displacement of the outer ring where each rolling element is with the \
         cage at angle 0, such as [\"1 um\", 0, 0]"
    );
    let list = node.list(&expected)?;
    if list.len() != elements {
        return Err(node.fail(format!("a list of {}", list.len()), expected));
    }
    list.iter().map(|entry| entry.array("a list of 3 lengths: along X, Y, Z")).collect()
}

/// Tilt of the outer ring, in models that have moments by it.
fn outer_ring_tilt(table: &Table<'_>, model: Model) -> Read<[f64; 2]> {
    let Some(node) = table.optional("outer_ring_tilt") else { return Ok([0.0; 2]) };
    let reacts = |of: &ModelProperties| {
        matches!(of.input, ModelInput::ContactAngle | ModelInput::Rollers) && !of.moving_elements
    };
    if !reacts(model.properties()) {
        let expected = format!("only with model = {}; remove it", choice_of(models_with(reacts)));
        return Err(node.misplaced(expected));
    }
    node.array("a list of 2 angles: about X and about Y")
}

/// A ring that bends; its form when it is not loaded is round.
fn outer_ring(table: &Table<'_>) -> Read<Option<OuterRing>> {
    let Some(node) = table.optional("outer_ring") else {
        return Ok(None);
    };
    if table.has("housing_displacement") {
        return Err(
            node.misplaced("not together with housing_displacement, which gives the ring a form; remove one of them")
        );
    }
    let ring = node.table()?;
    let range = "a whole number from 2 to 12 (highest order of the shape of the ring)";
    let orders = ring.read("orders", |n| n.integer(range))?.and_then(|orders| usize::try_from(orders).ok());
    let radius = ring.quantity("radius")?;
    let most = micrometres(THIN * radius) / 1e3;
    let thin = format!("a length above 0 and at most {most} mm, {THIN} of the radius: the ring is a thin one");
    Ok(Some(OuterRing {
        radius,
        width: ring.quantity("width")?,
        thickness: ring
            .required("thickness", &thin)?
            .limited(&thin, |thickness| thickness > 0.0 && thickness <= THIN * radius)?,
        youngs_modulus: ring.optional_quantity("youngs_modulus")?.unwrap_or(YOUNGS_MODULUS),
        orders: orders.unwrap_or(RING_ORDERS),
    }))
}

fn cage_ratio(table: &Table<'_>, model: Model, has_rolling_speed: bool) -> Read<Option<f64>> {
    let range = "0 or more and below 1 (cage speed / shaft speed)";
    let given = table.read("cage_ratio", |n| n.number(range))?;
    if given.is_some() || has_rolling_speed || !model.has_elements() {
        return Ok(given);
    }
    let expected = format!("{range}; without geometry it must be given (0 for elements at rest)");
    Err(table.missing("cage_ratio", &expected))
}

/// Reads the station along a rotor; on a system the coordinates define the position.
fn station(table: &Table<'_>, root: &Table<'_>) -> Read<f64> {
    if root.has("rotor") {
        return table.quantity("station");
    }
    if !root.has("system") {
        return Ok(table.optional_quantity("station")?.unwrap_or(0.0));
    }
    let why = "no station or support on a [system], whose matrices contain the supports and whose coordinates define the position; remove it";
    table.check_without(&["station", "support"], why)?;
    table.required("coordinates", COORDINATES)?;
    Ok(0.0)
}

/// Values expected of the coordinates of a system.
pub(super) const COORDINATES: &str = "5 numbers of coordinates, for the displacement along X, Y, Z and the tilt about X, Y: 1 is the \
                           first, a negative one counts the other way, 0 is none; such as [5, 6, 0, -8, 7]";

/// Reads coordinates of a system.
pub(super) fn coordinates(table: &Table<'_>, key: &str, on_system: bool) -> Read<Option<Coordinates>> {
    let Some(node) = table.optional(key) else { return Ok(None) };
    if !on_system {
        return Err(node.misplaced("only with a [system]; remove it"));
    }
    let list = node.list(COORDINATES)?;
    let numbers: Vec<i64> = list.iter().map(|entry| entry.integer(COORDINATES)).collect::<Read<_>>()?;
    <Coordinates>::try_from(numbers).map(Some).map_err(|_| node.refuse(COORDINATES))
}

fn support(node: &Node<'_>) -> Read<Support> {
    let table = node.table()?;
    let stiffness = [table.quantity("stiffness_x")?, table.quantity("stiffness_y")?];
    let most = (stiffness[0] * stiffness[1]).sqrt();
    let range = format!("below {most} N/m in size, or the support is unstable in some direction");
    let cross = table.read("stiffness_xy", |n| n.within(&range, |k| k.abs() < most))?;
    Ok(Support {
        mass: table.quantity("mass")?,
        stiffness,
        cross_stiffness: cross.unwrap_or(0.0),
        damping: table.optional_quantity("damping")?.unwrap_or(0.0),
    })
}

fn azimuths(node: &Node<'_>, elements: usize) -> Read<Vec<f64>> {
    let expected = format!("a list of {elements} angles, the azimuth of each rolling element at shaft angle 0");
    let list = node.list(&expected)?;
    if list.len() != elements {
        return Err(node.fail(format!("a list of {}", list.len()), expected));
    }
    list.iter().map(|entry| entry.quantity()).collect()
}

fn cage_runout(node: &Node<'_>, geometry: Option<&Geometry>) -> Read<CageRunout> {
    let table = node.table()?;
    let given = table.optional_quantity("radius")?;
    let Some(radius) = given.or(geometry.map(|g| 0.5 * g.pitch_diameter)) else {
        return Err(table.missing("radius", "the radius of the elements' circle, or the bearing's geometry"));
    };
    let range = format!("0 or more and below a tenth of the elements' circle ({radius} m)");
    let expected = Dimension::Length.expected(&range);
    Ok(CageRunout {
        offset: table.required("offset", &expected)?.within(&range, |e| (0.0..0.1 * radius).contains(&e))?,
        angle: table.optional_quantity("angle")?.unwrap_or(0.0),
        radius,
    })
}

/// Reads the keys that only `model` takes, and rejects those of other models.
fn own(table: &Table<'_>, model: Model) -> Read<Vec<(&'static str, f64)>> {
    for key in Model::ALL.into_iter().flat_map(|other| other.properties().own_keys) {
        check_only_with(table, &[key.name], model, |of| of.own_keys.iter().any(|own| own.name == key.name))?;
    }
    let read = |key: &'static Key| Ok(table.read(key.name, Node::any_number)?.map(|value| (key.name, value)));
    model.properties().own_keys.iter().filter_map(|key| read(key).transpose()).collect()
}

/// Balls with a mass need their geometry, and move in the plane of the bearing on round races.
fn check_moving_elements(table: &Table<'_>, model: Model, geometry: Option<&Geometry>) -> Read<()> {
    if !model.properties().moving_elements {
        return Ok(());
    }
    let name = model.name();
    if model.properties().bodies {
        let why = format!("none with model = \"{name}\", where the speed of the cage is a result; remove it");
        table.check_without(&["cage_ratio", "cage_runout"], &why)?;
        return check_traction(table);
    }
    if geometry.is_none() {
        let expected = format!(
            "the geometry of the bearing, from which model = \"{name}\" has mass and contact stiffness of a ball"
        );
        return Err(table.missing("ball_diameter", &expected));
    }
    let keys =
        ["stiffness", "exponent", "axial", "housing_displacement", "outer_ring", "defect", "waviness", "preload"];
    let why = format!("none with model = \"{name}\", whose balls move in one plane on round races; remove it");
    table.check_without(&keys, &why)
}

/// Checks that the traction does not grow beyond its peak.
fn check_traction(table: &Table<'_>) -> Read<()> {
    let (Some(limit), peak) = (table.optional("traction_limit"), table.read("traction_peak", Node::any_number)?) else {
        return Ok(());
    };
    let peak = peak.unwrap_or(multibody::TRACTION_PEAK);
    let expected = format!("at most traction_peak, {peak}");
    let found = limit.any_number()?;
    if found > peak { Err(limit.invalid(found.to_string(), expected)) } else { Ok(()) }
}

fn defects(table: &Table<'_>, model: Model, elements: usize) -> Read<Vec<Defect>> {
    let Some(node) = table.optional("defect") else {
        return Ok(Vec::new());
    };
    check_has_surfaces(&node, model)?;
    let list = node.list("a list of tables { surface, azimuth, half_width, depth, shape }")?;
    list.iter().map(|node| defect(node, elements)).collect()
}

/// Rejects damage and waviness of a linear bearing, whose springs have no surfaces.
fn check_has_surfaces(node: &Node<'_>, model: Model) -> Read<()> {
    if model.has_elements() {
        return Ok(());
    }
    let expected = format!("only with a model that has rolling elements, not with \"{}\"; remove it", model.name());
    Err(node.misplaced(expected))
}

fn defect(node: &Node<'_>, elements: usize) -> Read<Defect> {
    let table = node.table()?;
    let shapes = "\"half-sine\" or \"rectangular\"";
    Ok(Defect {
        surface: damaged_surface(&table, elements)?,
        azimuth: table.quantity("azimuth")?,
        half_width: half_width(&table)?,
        depth: table.quantity("depth")?,
        shape: table.required("shape", shapes)?.choice(&DEFECT_SHAPES)?,
    })
}

fn surface(table: &Table<'_>) -> Read<Surface> {
    table.required("surface", "\"inner\", \"outer\" or \"ball\"")?.choice(&SURFACES)
}

/// `surface`, and for a ball which one is damaged: `element`, 1 for the first.
fn damaged_surface(table: &Table<'_>, elements: usize) -> Read<Surface> {
    let surface = surface(table)?;
    let Some(node) = table.optional("element") else {
        return Ok(surface);
    };
    let range = format!("the number of the damaged ball, 1 to {elements}, only with surface = \"ball\"");
    let number = node.integer_within(1, elements as i64, &range)?;
    match (surface, usize::try_from(number)) {
        (Surface::Ball(_), Ok(number)) => Ok(Surface::Ball(number - 1)),
        _ => Err(node.refuse(&range)),
    }
}

fn waviness(table: &Table<'_>, model: Model) -> Read<Vec<Wave>> {
    let Some(node) = table.optional("waviness") else {
        return Ok(Vec::new());
    };
    check_has_surfaces(&node, model)?;
    let list = node.list("a list of tables { surface, direction, order, amplitude, phase }")?;
    list.iter().map(wave).collect()
}

fn wave(node: &Node<'_>) -> Read<Wave> {
    let table = node.table()?;
    let surface = surface(&table)?;
    let axial = table.read("direction", |n| n.choice(&WAVE_DIRECTIONS))?.unwrap_or(false);
    if axial && matches!(surface, Surface::Ball(_)) {
        let expected = "\"radial\" (a ball's waviness is along its contacts); or leave it out";
        return Err(table.required("direction", expected)?.refuse(expected));
    }
    let range = "a whole number from 1 to 10000 (waves around the surface)";
    let order = table.required("order", range)?;
    let order = u32::try_from(order.integer(range)?).map_err(|_| order.refuse(range))?;
    Ok(Wave {
        surface,
        axial,
        order,
        amplitude: table.quantity("amplitude")?,
        phase: table.optional_quantity("phase")?.unwrap_or(0.0),
    })
}

fn half_width(table: &Table<'_>) -> Read<f64> {
    let range = "above 0 and at most 180 deg";
    let node = table.required("half_width", &Dimension::Angle.expected(range))?;
    node.within(range, |x| x > 0.0 && x <= PI)
}
