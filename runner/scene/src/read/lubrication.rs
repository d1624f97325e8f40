//! `lubrication` and `cooling` of a bearing.

use super::super::lubrication::{Cooling, Lubrication, LubricationMethod, OilFlow, reference_conductances};
use super::super::table::{Node, Read, Table};
use super::super::{Bearing, ModelInput};
use super::mounting::temperature;

/// Coefficient of friction of a full film of mineral oil (SKF, Rolling bearings, chapter on friction).
const SLIDING_FRICTION: f64 = 0.05;
const OF_MODEL: &str = "only with a model that has rolling elements; remove it";
const OF_MOUNTING: &str = "only with lubrication and temperatures, from which the rings start; or remove it";

/// Reads lubrication and cooling of a bearing whose mounting is known.
pub(super) fn read(table: &Table<'_>, bearing: &mut Bearing) -> Read<()> {
    let (oil, cooling) = (table.optional("lubrication"), table.optional("cooling"));
    let is_spring = matches!(bearing.model.properties().input, ModelInput::Stiffness | ModelInput::Orders);
    if let Some(node) = oil.as_ref().or(cooling.as_ref()).filter(|_| is_spring) {
        return Err(node.misplaced(OF_MODEL));
    }
    let temperatures = bearing.mounting.and_then(|mounting| mounting.temperatures);
    bearing.lubrication = oil.as_ref().map(|node| lubrication(node, temperatures.is_some())).transpose()?;
    bearing.cooling = match cooling {
        Some(node) if oil.is_none() || temperatures.is_none() => return Err(node.misplaced(OF_MOUNTING)),
        Some(node) => Some(read_cooling(&node, bearing)?),
        None => None,
    };
    Ok(())
}

fn lubrication(node: &Node<'_>, has_temperatures: bool) -> Read<Lubrication> {
    let table = node.table()?;
    let viscosity_40 = table.quantity("viscosity_40")?;
    let range = format!("above 0 and below {} mm^2/s, that at 40 degC", 1e6 * viscosity_40);
    let below = |n: &Node<'_>| n.within(&range, |nu| nu > 0.0 && nu < viscosity_40);
    let temperature = table.read("temperature", temperature)?;
    if temperature.is_none() && !has_temperatures {
        return Err(
            table.missing("temperature", "that of the oil in the bearing, such as \"50 degC\"; or temperatures")
        );
    }
    let factor = |key: &str, expected: &str| table.read(key, |n| n.number(expected));
    Ok(Lubrication {
        method: table.required("method", "how the lubricant comes to the bearing")?.choice(&LubricationMethod::ALL)?,
        viscosity_40,
        viscosity_100: table
            .required("viscosity_100", "a kinematic viscosity, such as \"5.4 mm^2/s\"")
            .and_then(|n| below(&n))?,
        temperature,
        contamination: factor("contamination", "a number above 0 and at most 1 (1: extreme cleanliness)")?,
        viscous_factor: factor("f0", "a number above 0 and at most 50")?,
        load_factor: factor("f1", "a number above 0 and at most 0.1")?,
        sliding_friction: factor("sliding_friction", "a number from 0 to 0.3")?.unwrap_or(SLIDING_FRICTION),
    })
}

fn read_cooling(node: &Node<'_>, bearing: &Bearing) -> Read<Cooling> {
    let table = node.table()?;
    let entry = bearing.catalogue.as_ref().map(|used| used.listed.entry);
    let reference = entry.map(|entry| {
        let [bore, outside, width] = [entry.bore, entry.outer_diameter, entry.width].map(|mm| 1e-3 * mm);
        reference_conductances(bore, outside, width)
    });
    let expected = "a conductance from 0 to 1e4 W/K, such as \"2.5 W/K\"";
    let conductance = |key: &str| table.read(key, |n| n.number_in_unit(expected));
    let or_reference = |key: &str, place: usize| {
        let given = conductance(key)?.or(reference.and_then(|both| both.get(place).copied()));
        given.ok_or_else(|| table.missing(key, &format!("{expected}; or a bearing of the catalogue")))
    };
    let oil = match (table.optional("oil_flow"), table.optional("oil_inlet")) {
        (Some(flow), Some(inlet)) => {
            let litres = flow.number_in_unit("a flow above 0 and at most 1000 l/min, such as \"0.5 l/min\"")?;
            Some(OilFlow { flow: litres * 1e-3 / 60.0, inlet: temperature(&inlet)? })
        }
        (Some(_), None) => {
            return Err(table.missing("oil_inlet", "the temperature at which the oil enters, such as \"40 degC\""));
        }
        (None, Some(_)) => return Err(table.missing("oil_flow", "the flow of the oil, such as \"0.5 l/min\"")),
        (None, None) => None,
    };
    let seat = "a conductance above 0 and at most 1e4 W/K, such as \"20 W/K\"";
    let (shaft, housing) = (or_reference("shaft", 0)?, or_reference("housing", 1)?);
    let elements = conductance("elements")?.unwrap_or(0.0);
    // Half of the heat arises at each ring: each needs a way, of its own, through the elements or with the oil.
    let has_way = |own: f64, other: f64| own > 0.0 || (elements > 0.0 && other > 0.0) || oil.is_some();
    if !(has_way(shaft, housing) && has_way(housing, shaft)) {
        return Err(node.refuse(
            "a way for the heat of each ring: shaft and housing above 0, or one of them with elements, or oil_flow",
        ));
    }
    Ok(Cooling {
        ambient: temperature(&table.required("ambient", "the temperature of the surroundings, such as \"20 degC\"")?)?,
        shaft,
        housing,
        seat: table.read("seat", |n| n.number_in_unit(seat))?,
        elements,
        oil,
    })
}
