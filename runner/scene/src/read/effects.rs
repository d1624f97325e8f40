//! Keys of effects of the quasi-static and tabulated models, and of preload.

use super::super::model::{choice_of, models_with};
use super::super::table::{Node, Read, Table};
use super::super::{
    Effects, FrictionSharing, InletHeating, Lubricant, Model, ModelInput, Preload, PreloadAmount, PreloadState,
    RaceControl, TableRange,
};

/// The values of `effects`.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Effect {
    Centrifugal,
    Gyroscopic,
    Film,
}

/// `effects`
pub(super) const EFFECTS: [(&str, Effect); 3] =
    [("centrifugal", Effect::Centrifugal), ("gyroscopic", Effect::Gyroscopic), ("film", Effect::Film)];
/// `race_control`
pub(super) const RACE_CONTROLS: [(&str, RaceControl); 2] =
    [("outer", RaceControl::Outer), ("inner", RaceControl::Inner)];
/// `friction_sharing`
pub(super) const FRICTION_SHARINGS: [(&str, FrictionSharing); 3] = [
    ("outer", FrictionSharing::Outer),
    ("equal", FrictionSharing::Equal),
    ("proportional", FrictionSharing::Proportional),
];

/// Reads `effects`, `race_control`, `friction_sharing` and `lubricant`.
pub(super) fn read(table: &Table<'_>, model: Model) -> Read<Effects> {
    if model == Model::QuasiStaticRoller {
        return of_rollers(table);
    }
    if !model.properties().effects {
        // Bodies have their inertia, and a film that is reported.
        let bodies = model.properties().bodies;
        let keys = ["effects", "race_control", "friction_sharing", "lubricant"];
        return match keys.iter().filter(|key| !bodies || **key != "lubricant").find_map(|key| table.optional(key)) {
            Some(node) => {
                let models = choice_of(models_with(|of| of.effects));
                Err(node.misplaced(format!("only with model = {models}; remove it")))
            }
            None => Ok(Effects { centrifugal: bodies, gyroscopic: bodies, ..Effects::default() }),
        };
    }
    let named = table.read("effects", effects)?.unwrap_or_default();
    let has = |effect| named.contains(&effect);
    let control = table.read("race_control", |n| n.choice(&RACE_CONTROLS));
    Ok(Effects {
        centrifugal: has(Effect::Centrifugal),
        gyroscopic: has(Effect::Gyroscopic),
        film: film(table, has(Effect::Film))?,
        control: control?.unwrap_or_default(),
        sharing: table.read("friction_sharing", |n| n.choice(&FRICTION_SHARINGS))?.unwrap_or_default(),
    })
}

/// Reads `effects` of rollers in equilibrium: their centrifugal force, which is one of their equations in any case.
fn of_rollers(table: &Table<'_>) -> Read<Effects> {
    let named = table.read("effects", effects)?.unwrap_or_default();
    match table.optional("effects").filter(|_| named.iter().any(|effect| *effect != Effect::Centrifugal)) {
        Some(node) => Err(node.refuse("[\"centrifugal\"] with rollers")),
        None => Ok(Effects { centrifugal: true, ..Effects::default() }),
    }
}

fn effects(node: &Node<'_>) -> Read<Vec<Effect>> {
    let expected = "a list of \"centrifugal\", \"gyroscopic\" and \"film\"";
    let mut effects = Vec::new();
    for entry in node.list(expected)? {
        let effect = entry.choice(&EFFECTS)?;
        if effects.contains(&effect) {
            return Err(entry.repeated("each effect once"));
        }
        effects.push(effect);
    }
    Ok(effects)
}

/// Reads the oil of the film. It is checked wherever it is given, and required with the effect `film`.
fn film(table: &Table<'_>, named: bool) -> Read<Option<Lubricant>> {
    let oil = lubricant(table)?;
    let expected = "{ viscosity = \"0.04 Pa s\", pressure_viscosity = \"2.2e-8 1/Pa\" }, the oil of the film";
    match (named, oil) {
        (true, None) => Err(table.missing("lubricant", expected)),
        (true, oil) => Ok(oil),
        (false, _) => Ok(None),
    }
}

/// `lubricant`, which may be known where its film is omitted.
pub(super) fn lubricant(table: &Table<'_>) -> Read<Option<Lubricant>> {
    table.read("lubricant", |node| {
        let table = node.table()?;
        Ok(Lubricant {
            viscosity: table.quantity("viscosity")?,
            pressure_viscosity: table.quantity("pressure_viscosity")?,
            roughness: table.optional_quantity("roughness")?,
            inlet_heating: table.read("inlet_heating", inlet_heating)?,
        })
    })
}

/// Keys that are absent are those of mineral oils.
fn inlet_heating(node: &Node<'_>) -> Read<InletHeating> {
    let table = node.table()?;
    let mineral = InletHeating::MINERAL_OIL;
    let expected = "a relative decrease of the viscosity from 1e-3 to 0.2 1/K, such as \"0.04 1/K\"";
    let coefficient = |n: &Node<'_>| n.number_in_unit(expected);
    let range = "a thermal conductivity from 0.01 to 10 W/(m K), such as \"0.14 W/(m K)\"";
    let conductivity = |n: &Node<'_>| n.number_in_unit(range);
    Ok(InletHeating {
        temperature_coefficient: table
            .read("temperature_coefficient", coefficient)?
            .unwrap_or(mineral.temperature_coefficient),
        conductivity: table.read("conductivity", conductivity)?.unwrap_or(mineral.conductivity),
    })
}

/// `preload`, for the models that carry thrust by a contact angle.
pub(super) fn preload(table: &Table<'_>, model: Model) -> Read<Option<Preload>> {
    let Some(node) = table.optional("preload") else {
        return Ok(None);
    };
    if !model.has_contact_angle() && !model.properties().inclined_rollers {
        let models = choice_of(models_with(|of| of.input == ModelInput::ContactAngle || of.inclined_rollers));
        let expected = format!("only with model = {models} (lumped: a negative radial_play); remove it");
        return Err(node.misplaced(expected));
    }
    let inner = node.table()?;
    let amount = match (inner.optional("force"), inner.optional("displacement")) {
        (Some(_), None) => PreloadAmount::Force(inner.quantity("force")?),
        (None, Some(_)) => PreloadAmount::Displacement(inner.quantity("displacement")?),
        _ => return Err(node.refuse("exactly one of { force = \"500 N\" } and { displacement = \"10 um\" }")),
    };
    let set = inner.read("set", |n| n.choice(&PreloadState::ALL))?.unwrap_or_default();
    Ok(Some(Preload { amount, set }))
}

/// `table` of the tabulated model (and of the quasi-static one, from which a table can be computed).
pub(super) fn table_range(table: &Table<'_>, model: Model) -> Read<Option<TableRange>> {
    let Some(node) = table.optional("table") else {
        return Ok(None);
    };
    if !model.properties().effects {
        let models = choice_of(models_with(|of| of.effects).rev());
        return Err(node.misplaced(format!("only with model = {models}; remove it")));
    }
    let inner = node.table()?;
    let pair = |key: &str| {
        inner.read(key, |n| {
            let range: [f64; 2] = n.array("a list of two: the least and the greatest")?;
            if range[0] <= range[1] { Ok(range) } else { Err(n.refuse("the least first, then the greatest")) }
        })
    };
    let intervals = inner.read("intervals", |n| {
        let expected =
            "a list of three whole numbers: from 4 to 1000 along approach and angle, from 1 to 1000 along the speed";
        let list = n.list(expected)?;
        let count = |n: &Node<'_>| n.integer(expected).map(|i| usize::try_from(i).unwrap_or(4));
        match list.as_slice() {
            [a, b, c] => Ok([count(a)?, count(b)?, count(c)?]),
            _ => Err(n.refuse(expected)),
        }
    })?;
    Ok(Some(TableRange { approach: pair("approach")?, angle: pair("angle")?, speed: pair("speed")?, intervals }))
}
