//! `[rotor]`: a rigid rotor by its mass and inertia, or a flexible one by its drawing.

use super::super::bearing::STEEL_DENSITY;
use super::super::table::{Node, Read, Table};
use super::super::units::Dimension;
use super::super::{Disk, FlexibleRotor, Rotor, Section, Unbalance, load_at};
use super::bearing::{POISSONS_RATIO, YOUNGS_MODULUS};
use crate::flexible_rotor::rigid_body;

/// Standard gravity along -Y, the default of `gravity`.
const GRAVITY: [f64; 3] = [0.0, -9.806_65, 0.0];

/// Keys of a rigid rotor alone, and of a flexible one alone.
const RIGID: [&str; 3] = ["mass", "diametral_inertia", "polar_inertia"];
const FLEXIBLE: [&str; 6] = ["sections", "disks", "youngs_modulus", "poissons_ratio", "density", "modal_damping"];

/// Largest number of sections of a rotor, and of disks.
const MOST_SECTIONS: usize = 10_000;
const MOST_DISKS: usize = 1000;
/// Largest gap between two sections that is taken for rounding, m.
const ROUNDING: f64 = 1e-6;

/// Reads the rotor with stations as drawn; returns it with the station of its centre of mass, 0 of a rigid rotor.
pub fn read(node: &Node<'_>) -> Read<Rotor> {
    let table = node.table()?;
    let load = five(&table, "load")?;
    let given_station = table.optional_quantity("load_station")?;
    let mut rotor = Rotor {
        mass: 0.0,
        diametral_inertia: 0.0,
        polar_inertia: 0.0,
        damping: five(&table, "damping")?,
        proportional_damping: 0.0,
        stiffness: five(&table, "stiffness")?,
        gravity: table.read("gravity", gravity)?.unwrap_or(GRAVITY),
        load,
        unbalance: table.read("unbalance", unbalances)?.unwrap_or_default(),
        centre_of_mass: 0.0,
        flexible: None,
    };
    if table.has("sections") {
        if let Some(given) = RIGID.iter().find_map(|key| table.optional(key)) {
            return Err(given.misplaced("no mass or inertia beside sections: they follow from the drawing"));
        }
        flexible(&table, &mut rotor, given_station)?;
    } else {
        if let Some(given) = FLEXIBLE.iter().chain(&["coordinates"]).find_map(|key| table.optional(key)) {
            return Err(given.misplaced("only with sections, the drawing of a flexible rotor"));
        }
        rotor.mass = table.quantity("mass")?;
        (rotor.diametral_inertia, rotor.polar_inertia) = inertias(&table)?;
        rotor.proportional_damping = table.optional_quantity("proportional_damping")?.unwrap_or(0.0);
        rotor.load = load_at(load, given_station.unwrap_or(0.0));
    }
    Ok(rotor)
}

/// Reads a drawing and moves its stations to the centre of mass.
fn flexible(table: &Table<'_>, rotor: &mut Rotor, load_station: Option<f64>) -> Read<()> {
    let expected = "a list of tables { from, to, outer_diameter }";
    let sections = sections(&table.required("sections", expected)?, expected)?;
    let ratio = "0 or more and below 0.5";
    let density = table.optional_quantity("density")?.unwrap_or(STEEL_DENSITY);
    let damping = table.read("proportional_damping", proportional_damping)?.unwrap_or_default();
    let share = "0 or more and below 1 (of the critical damping)";
    let mut drawn = FlexibleRotor {
        disks: table.read("disks", |n| disks(n, &sections, density))?.unwrap_or_default(),
        sections,
        youngs_modulus: table.optional_quantity("youngs_modulus")?.unwrap_or(YOUNGS_MODULUS),
        poissons_ratio: table.read("poissons_ratio", |n| n.number(ratio))?.unwrap_or(POISSONS_RATIO),
        density,
        proportional_damping: damping,
        modal_damping: table.read("modal_damping", |n| n.number(share))?.unwrap_or(0.0),
        load_station: 0.0,
        coordinates: table
            .read("coordinates", |n| n.integer("a whole number from 7 to 31"))?
            .and_then(|n| usize::try_from(n).ok()),
    };
    let [mass, centre, diametral, polar] = rigid_body(&drawn);
    drawn.load_station = load_station.unwrap_or(centre);
    let drawn = drawn.moved(-centre);
    (rotor.mass, rotor.diametral_inertia, rotor.polar_inertia) = (mass, diametral, polar);
    rotor.centre_of_mass = centre;
    rotor.load = load_at(rotor.load, drawn.load_station);
    rotor.unbalance.iter_mut().for_each(|u| u.station -= centre);
    rotor.flexible = Some(drawn);
    Ok(())
}

fn sections(node: &Node<'_>, expected: &str) -> Read<Vec<Section>> {
    let list = limited(node.list(expected)?, MOST_SECTIONS, node, "sections")?;
    let mut sections: Vec<Section> = Vec::new();
    for node in &list {
        let table = node.table()?;
        let from = table.quantity("from")?;
        let beyond = Dimension::Length.expected(&format!("beyond from, {} mm", from * 1e3));
        let to = table.required("to", &beyond)?.limited(&beyond, |to| to > from)?;
        let bore = table.optional_quantity("inner_diameter")?.unwrap_or(0.0);
        let above = Dimension::Length.expected(&format!("above the inner diameter, {} mm", bore * 1e3));
        let diameter = |n: &Node<'_>| n.limited(&above, |d| d > bore);
        let outer = diameter(&table.required("outer_diameter", &above)?)?;
        let end = table.read("outer_diameter_to", diameter)?.unwrap_or(outer);
        if let Some(last) = sections.last() {
            let [before, here] = [last.to, from].map(|z| z * 1e3);
            if (from - last.to).abs() > ROUNDING {
                let what = if from > last.to { "a gap" } else { "an overlap" };
                return Err(table.required("from", "")?.fail(
                    format!("{what}: from {here} mm after a section to {before} mm"),
                    format!("{before} mm, the end of the section before"),
                ));
            }
        }
        let from = sections.last().map_or(from, |last| last.to);
        sections.push(Section { from, to, outer_diameter: outer, outer_diameter_to: end, inner_diameter: bore });
    }
    if sections.is_empty() {
        return Err(node.refuse(expected));
    }
    Ok(sections)
}

/// Returns the list if it has at most `most` entries.
fn limited<T>(list: Vec<T>, most: usize, node: &Node<'_>, what: &str) -> Read<Vec<T>> {
    if list.len() > most {
        return Err(node.fail(format!("{} {what}", list.len()), format!("at most {most}")));
    }
    Ok(list)
}

fn disks(node: &Node<'_>, sections: &[Section], density: f64) -> Read<Vec<Disk>> {
    let list = node.list("a list of tables { station, mass, diametral_inertia, polar_inertia }")?;
    let list = limited(list, MOST_DISKS, node, "disks")?;
    list.iter().map(|node| disk(node, sections, density)).collect()
}

fn disk(node: &Node<'_>, sections: &[Section], shaft_density: f64) -> Read<Disk> {
    let by_size = ["outer_diameter", "width", "density"];
    let table = node.table()?;
    let station = station(&table, "station", sections)?;
    if table.has("mass") {
        if let Some(given) = by_size.iter().find_map(|key| table.optional(key)) {
            return Err(given.misplaced("either mass and inertias, or outer_diameter and width"));
        }
        let mass = table.quantity("mass")?;
        let (diametral_inertia, polar_inertia) = inertias(&table)?;
        return Ok(Disk { station, mass, diametral_inertia, polar_inertia, size: None });
    }
    if !table.has("outer_diameter") {
        return Err(table.missing("mass", "mass and inertias, or outer_diameter and width"));
    }
    if let Some(given) = ["diametral_inertia", "polar_inertia"].iter().find_map(|key| table.optional(key)) {
        return Err(given.misplaced("no inertia beside outer_diameter and width, from which it follows"));
    }
    let bore =
        sections.iter().find(|s| s.from <= station && station <= s.to).map_or(0.0, |s| s.outer_diameter_at(station));
    let above = Dimension::Length.expected(&format!("above that of the shaft, {} mm", bore * 1e3));
    let outer = table.required("outer_diameter", &above)?.limited(&above, |d| d > bore)?;
    let width = table.quantity("width")?;
    let density = table.optional_quantity("density")?.unwrap_or(shaft_density);
    let mass = 0.25 * std::f64::consts::PI * (outer * outer - bore * bore) * width * density;
    let squares = outer * outer + bore * bore;
    Ok(Disk {
        station,
        mass,
        diametral_inertia: mass * (squares / 16.0 + width * width / 12.0),
        polar_inertia: mass * squares / 8.0,
        size: Some([outer, width]),
    })
}

/// Reads a station between the ends of the shaft.
fn station(table: &Table<'_>, key: &str, sections: &[Section]) -> Read<f64> {
    let (from, to) = (sections.first().map_or(0.0, |s| s.from), sections.last().map_or(0.0, |s| s.to));
    let range =
        Dimension::Length.expected(&format!("between the ends of the shaft, {} and {} mm", from * 1e3, to * 1e3));
    table.required(key, &range)?.limited(&range, |z| (from - ROUNDING..=to + ROUNDING).contains(&z))
}

/// Reads the factors of mass and stiffness; a plain number is that of the stiffness.
fn proportional_damping(node: &Node<'_>) -> Read<[f64; 2]> {
    if !node.is_table() {
        return Ok([0.0, node.quantity()?]);
    }
    let table = node.table()?;
    let mass = table.optional_quantity("mass")?.unwrap_or(0.0);
    let stiffness = table.optional_quantity("stiffness")?.unwrap_or(0.0);
    Ok([mass, stiffness])
}

/// Reads diametral and polar moment. No body has a polar moment above twice its diametral one: the mass would need a negative
/// spread along the axis. The two are most often swapped.
fn inertias(table: &Table<'_>) -> Read<(f64, f64)> {
    let diametral = table.quantity("diametral_inertia")?;
    let polar = table.quantity("polar_inertia")?;
    if polar <= 2.0 * diametral {
        return Ok((diametral, polar));
    }
    let most = format!("at most twice diametral_inertia, here {} kg m^2 (are the two swapped?)", 2.0 * diametral);
    let node = table.required("polar_inertia", &most)?;
    Err(node.invalid(node.shown_quantity(Dimension::Inertia), most))
}

/// Reads three values along X, Y, Z and two about X, Y; zeros where the key is absent.
fn five(table: &Table<'_>, key: &str) -> Read<[f64; 5]> {
    let values = table.read(key, |node| {
        let [along, about] = [0, 3].map(|i| node.expected_of_entry(i));
        node.array(&format!("a list of 5: along X, Y, Z each {along} and about X, Y each {about}"))
    })?;
    Ok(values.unwrap_or_default())
}

fn gravity(node: &Node<'_>) -> Read<[f64; 3]> {
    let expected = "a list of 3: the acceleration of gravity along X, Y, Z, such as [0, -9.81, 0]";
    node.array(expected)
}

fn unbalances(node: &Node<'_>) -> Read<Vec<Unbalance>> {
    let list = node.list("a list of tables { moment, angle, station }")?;
    list.iter().map(unbalance).collect()
}

fn unbalance(node: &Node<'_>) -> Read<Unbalance> {
    let table = node.table()?;
    Ok(Unbalance {
        moment: table.quantity("moment")?,
        angle: table.quantity("angle")?,
        station: table.quantity("station")?,
    })
}
