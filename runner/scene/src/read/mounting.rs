//! `fit` and `temperatures` of a bearing: its operating clearance.

use super::super::model::{choice_of, models_with};
use super::super::mounting::{Mounting, PartMaterial, RingFit, Temperatures};
use super::super::table::{Node, Read, Table};
use super::super::units::Dimension;
use super::super::{Bearing, ModelInput};
use super::bearing::{POISSONS_RATIO, YOUNGS_MODULUS};

/// Thermal expansion of bearing steel, 1/K.
const EXPANSION: f64 = 12e-6;
/// Temperature of the assembly where none is given, K: 20 degrees Celsius, the reference temperature of ISO 1.
const ASSEMBLED: f64 = 293.15;
/// Upper limit of accepted temperatures, K; bearing steel melts far above it.
const HOTTEST: f64 = 1000.0;

/// Reads the mounting of a bearing and sets its operating clearance.
pub(super) fn read(table: &Table<'_>, bearing: &mut Bearing) -> Read<()> {
    let (fit, temperatures) = (table.optional("fit"), table.optional("temperatures"));
    let Some(node) = fit.as_ref().or(temperatures.as_ref()) else {
        return match ["inner_raceway_diameter", "outer_raceway_diameter"].iter().find_map(|key| table.optional(key)) {
            Some(node) => Err(node.misplaced("only with fit or temperatures; remove it")),
            None => Ok(()),
        };
    };
    let Some(unmounted_clearance) = bearing.clearance().filter(|_| bearing.model.has_elements()) else {
        let springs = choice_of(models_with(|of| of.input == ModelInput::Stiffness));
        let expected = format!(
            "a bearing with a clearance: diametral_clearance, contact_angle or radial_play, and not model = {springs}"
        );
        return Err(node.misplaced(expected));
    };
    let (temperatures, expansion) = match &temperatures {
        Some(node) => read_temperatures(node).map(|(t, expansion)| (Some(t), expansion))?,
        None => (None, EXPANSION),
    };
    let ring_material = PartMaterial {
        youngs_modulus: bearing.geometry.map_or(YOUNGS_MODULUS, |g| g.youngs_modulus),
        poissons_ratio: bearing.geometry.map_or(POISSONS_RATIO, |g| g.poissons_ratio),
        expansion,
    };
    let raceways = raceways(table, bearing)?;
    let fits = fit.as_ref().map(|node| read_fit(node, bearing, raceways, ring_material)).transpose()?;
    let mounting = Mounting { unmounted_clearance, raceways, ring_material, fits, temperatures };
    let operating = mounting.operating();
    if operating.value() < 0.0 && bearing.model.has_contact_angle() {
        let found = format!("operating clearance of {:.1} um", operating.value() * 1e6);
        let expected = format!(
            "0 or more with this model: {:.1} um before mounting, less {:.1} um by the fits and {:.1} um by temperature",
            operating.unmounted * 1e6,
            operating.by_fits * 1e6,
            operating.by_temperature * 1e6
        );
        return Err(node.invalid(found, expected));
    }
    bearing.set_clearance(operating.value());
    bearing.mounting = Some(mounting);
    Ok(())
}

/// Reads the diameters of the raceways: given, of the geometry, or of the catalogue.
fn raceways(table: &Table<'_>, bearing: &Bearing) -> Read<[f64; 2]> {
    let geometry = bearing.geometry.map(|g| (g.pitch_diameter, g.ball_diameter));
    let entry = bearing.catalogue.as_ref().map(|used| used.listed.entry);
    let parts = geometry.or(entry.map(|e| (e.pitch_diameter * 1e-3, e.element_diameter * 1e-3)));
    let diameter = |key: &str, sign: f64| match (table.optional(key), parts) {
        (Some(node), _) => node.quantity(),
        (None, Some((pitch, element))) => Ok(pitch + sign * element),
        (None, None) => Err(table.missing(key, "a length, such as \"31 mm\"; or ball_diameter and pitch_diameter")),
    };
    let [inner, outer] = [diameter("inner_raceway_diameter", -1.0)?, diameter("outer_raceway_diameter", 1.0)?];
    if outer <= inner {
        let given = ["outer_raceway_diameter", "inner_raceway_diameter"].iter().find_map(|key| table.optional(key));
        let expected =
            format!("an outer raceway ({:.2} mm) larger than the inner one ({:.2} mm)", outer * 1e3, inner * 1e3);
        return Err(
            given.map_or_else(|| table.fail("raceways", expected.clone()), |node| node.refuse(expected.clone()))
        );
    }
    Ok([inner, outer])
}

fn read_fit(node: &Node<'_>, bearing: &Bearing, raceways: [f64; 2], rings: PartMaterial) -> Read<[RingFit; 2]> {
    let table = node.table()?;
    let entry = bearing.catalogue.as_ref().map(|used| used.listed.entry);
    let diameter_of = |key: &str, listed: Option<f64>, range: &str, ok: &dyn Fn(f64) -> bool| {
        let expected = Dimension::Length.expected(range);
        match (table.optional(key), listed.map(|mm| mm * 1e-3).filter(|d| ok(*d))) {
            (Some(node), _) => node.limited(&expected, ok),
            (None, Some(listed)) => Ok(listed),
            (None, None) => Err(table.missing(key, &expected)),
        }
    };
    let [inner, outer] = raceways;
    let below = format!("above 0 and below the inner raceway ({:.2} mm)", inner * 1e3);
    let above = format!("above the outer raceway ({:.2} mm)", outer * 1e3);
    let bore = diameter_of("bore", entry.map(|e| e.bore), &below, &|d| d > 0.0 && d < inner)?;
    let outside = diameter_of("outside_diameter", entry.map(|e| e.outer_diameter), &above, &|d| d > outer)?;
    let interference = |key: &str, other: f64| {
        let most = 0.01 * other;
        let range = format!("of at most {:.2} mm; negative is a loose fit", most * 1e3);
        let read = |n: &Node<'_>| n.within(&range, |x| x.abs() <= most);
        Ok(table.read(key, read)?.unwrap_or(0.0))
    };
    if !table.has("shaft_interference") && !table.has("housing_interference") {
        return Err(table.missing("shaft_interference", "a length, such as \"10 um\"; or housing_interference"));
    }
    let shaft_bore = table.read("shaft_bore", |n| {
        let range = format!("of 0 or more and below the bore of the bearing ({:.2} mm)", bore * 1e3);
        n.within(&range, |d| d >= 0.0 && d < bore)
    })?;
    let housing_diameter = table.read("housing_diameter", |n| {
        let range = format!("above the outside diameter of the bearing ({:.2} mm)", outside * 1e3);
        n.within(&range, |d| d > outside)
    })?;
    let part = |key: &str| Ok(table.read(key, |n| material(n, rings))?.unwrap_or(rings));
    Ok([
        RingFit {
            interference: interference("shaft_interference", bore)?,
            diameter: bore,
            free_diameter: shaft_bore.unwrap_or(0.0),
            material: part("shaft_material")?,
        },
        RingFit {
            interference: interference("housing_interference", outside)?,
            diameter: outside,
            free_diameter: housing_diameter.unwrap_or(f64::INFINITY),
            material: part("housing_material")?,
        },
    ])
}

/// Reads a material; keys that are absent are those of the rings.
fn material(node: &Node<'_>, rings: PartMaterial) -> Read<PartMaterial> {
    let table = node.table()?;
    let modulus = table.optional_quantity("youngs_modulus")?;
    let ratio = |n: &Node<'_>| n.number("0 or more and below 0.5");
    Ok(PartMaterial {
        youngs_modulus: modulus.unwrap_or(rings.youngs_modulus),
        poissons_ratio: table.read("poissons_ratio", ratio)?.unwrap_or(rings.poissons_ratio),
        expansion: table.read("expansion", thermal_expansion)?.unwrap_or(rings.expansion),
    })
}

fn read_temperatures(node: &Node<'_>) -> Read<(Temperatures, f64)> {
    let table = node.table()?;
    let required = |key: &str| table.required(key, TEMPERATURE).and_then(|node| temperature(&node));
    let temperatures = Temperatures {
        inner: required("inner")?,
        outer: required("outer")?,
        assembled: table.read("assembled", temperature)?.unwrap_or(ASSEMBLED),
    };
    Ok((temperatures, table.read("expansion", thermal_expansion)?.unwrap_or(EXPANSION)))
}

/// Values expected of a temperature.
const TEMPERATURE: &str = "a temperature with its unit, such as \"60 degC\", \"333 K\" or \"140 degF\"";

/// Reads a temperature in K. A bare number has no unit and is rejected.
pub(super) fn temperature(node: &Node<'_>) -> Read<f64> {
    let parsed = node.text(TEMPERATURE)?.trim().rsplit_once(' ').and_then(|(number, unit)| {
        let (scale, zero) = temperature_unit(unit)?;
        Some(number.trim().parse::<f64>().ok()? * scale + zero)
    });
    parsed.filter(|kelvin| *kelvin > 0.0 && *kelvin < HOTTEST).ok_or_else(|| node.refuse(TEMPERATURE))
}

/// Returns kelvins for one unit, and the temperature of its zero in K.
pub(super) fn temperature_unit(name: &str) -> Option<(f64, f64)> {
    TEMPERATURE_UNITS.iter().find(|(unit, _)| *unit == name).map(|(_, scale)| *scale)
}

/// Units of temperature with kelvins for one, and the temperature of its zero in K.
pub(super) const TEMPERATURE_UNITS: [(&str, (f64, f64)); 3] =
    [("degC", (1.0, 273.15)), ("K", (1.0, 0.0)), ("degF", (5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0))];

/// Reads a coefficient of linear expansion, 1/K.
fn thermal_expansion(node: &Node<'_>) -> Read<f64> {
    let expected = "a linear expansion from 0 to 1e-4 1/K, such as \"23e-6 1/K\"";
    node.number_in_unit(expected)
}
