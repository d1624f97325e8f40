//! `[[bearing]]` without `model`: number, diameters and contact angle, or the orders of a data sheet.

use super::super::table::{Node, Read, Table};
use super::pitch_circle::{ELEMENTS, check_fit_on_pitch_circle, contact_angle, elements, pitch_diameter};
use crate::model::choice_of;
use crate::{KinematicData, Model};
use ballrace::bearing::kinematics::Orders;

/// Keys from which orders follow.
const SOURCES: [&str; 6] =
    ["elements", "ball_diameter", "roller_diameter", "pitch_diameter", "contact_angle", "orders"];
/// Further keys that a bearing may have without `model`.
const OTHERS: [&str; 4] = ["name", "station", "facing", "cage_ratio"];
/// Keys that `orders` replace.
const DIAMETERS: [&str; 4] = ["ball_diameter", "roller_diameter", "pitch_diameter", "contact_angle"];

/// Keys of a bearing without `model`, for messages.
const WITHOUT_MODEL: &str = "for vibration alone no model, but elements, ball_diameter or roller_diameter, pitch_diameter and \
                             contact_angle, or orders";
/// Values of `orders`, for messages.
const EXAMPLE: &str = "such as orders = { outer = 3.585, inner = 5.415, element = 2.357, cage = 0.398 }";

/// Largest distance of `outer + inner` from a whole number: data sheets round to two decimals or more.
const SUM_ERROR: f64 = 0.02;
/// Largest relative deviation of `cage` from `outer` over the number of elements.
const CAGE_ERROR: f64 = 0.01;
/// Largest relative excess of `element` over the spin at a contact angle of 0.
const SPIN_ERROR: f64 = 0.03;

/// Checks that a bearing without `model` has no key that needs one.
///
/// # Errors
/// A missing `model`.
pub(super) fn check_without_model(table: &Table<'_>) -> Read<()> {
    let needs_model = table.keys().find(|key| !SOURCES.contains(key) && !OTHERS.contains(key));
    if needs_model.is_none() && SOURCES.iter().any(|key| table.has(key)) {
        return Ok(());
    }
    let reason = needs_model.map_or_else(String::new, |key| format!(" because of {key}"));
    let models = choice_of(Model::with_forces());
    Err(table.missing("model", &format!("{models}{reason}; {WITHOUT_MODEL}")))
}

/// Reads number of elements and kinematics of a bearing without model; none with one.
pub(super) fn read(table: &Table<'_>, model: Model) -> Read<Option<(usize, KinematicData)>> {
    if model.has_forces() {
        return match table.optional("orders") {
            Some(node) => Err(node.misplaced("only without model and bearing; remove it or those")),
            None => Ok(None),
        };
    }
    match table.optional("orders") {
        Some(node) => of_data_sheet(table, &node).map(Some),
        None => of_diameters(table).map(Some),
    }
}

fn of_diameters(table: &Table<'_>) -> Read<(usize, KinematicData)> {
    if let (Some(_), Some(roller)) = (table.optional("ball_diameter"), table.optional("roller_diameter")) {
        return Err(roller.misplaced("either ball_diameter or roller_diameter; remove one of them"));
    }
    let key = if table.has("roller_diameter") { "roller_diameter" } else { "ball_diameter" };
    let keys = ["elements", key, "pitch_diameter", "contact_angle"];
    let missing: Vec<&str> = keys.into_iter().filter(|key| !table.has(key)).collect();
    if let Some(first) = missing.first() {
        let expected = format!(
            "all of {} (missing here: {}), or orders; forces need a model",
            keys.join(", "),
            missing.join(", ")
        );
        return Err(table.missing(first, &expected));
    }
    let elements = elements(table)?;
    let element = table.quantity(key)?;
    let pitch = pitch_diameter(table, (key, element))?;
    let contact_angle = contact_angle(&table.required("contact_angle", "an angle from 0 to 60 deg")?)?;
    check_fit_on_pitch_circle(table, elements, (key, element), pitch)?;
    Ok((elements, KinematicData::Diameters { element, pitch, contact_angle }))
}

/// Reads orders and checks that a bearing can have them. With the outer ring at rest and pure rolling
/// `outer + inner = N`, `cage = outer/N`, and with `gamma = (inner - outer)/N` the spin of an element is
/// `cos(alpha) (1 - gamma^2)/(2 gamma)`, `alpha` from 0 to 60 degrees.
fn of_data_sheet(table: &Table<'_>, node: &Node<'_>) -> Read<(usize, KinematicData)> {
    if let Some(key) = DIAMETERS.into_iter().chain(["cage_ratio"]).find_map(|key| table.optional(key)) {
        return Err(key.misplaced("not together with orders, which replace it; remove one of them"));
    }
    let own = node.table()?;
    let number =
        |key: &str| own.required(key, EXAMPLE)?.number(&format!("a number per revolution of the shaft, {EXAMPLE}"));
    let [outer, inner, element, cage] = [number("outer")?, number("inner")?, number("element")?, number("cage")?];
    let (sum, count) = (outer + inner, (outer + inner).round());
    if (sum - count).abs() > SUM_ERROR || !ELEMENTS.contains(&(count as i64)) {
        let expected = "the number of rolling elements, a whole number from 3 to 64";
        return Err(node.invalid(format!("outer + inner = {sum:.3}"), expected));
    }
    if outer >= inner {
        return Err(node.invalid(format!("outer = {outer}, inner = {inner}"), "outer below inner"));
    }
    if table.has("elements") && elements(table)? != count as usize {
        let found = format!("outer + inner = {sum:.3} with elements = {}", elements(table)?);
        return Err(node.invalid(found, "their sum to be the number of elements"));
    }
    let elements = count as usize;
    if (cage * count / outer - 1.0).abs() > CAGE_ERROR {
        let expected = format!("{:.3}, which is outer over {elements} elements", outer / count);
        return Err(node.invalid(format!("cage = {cage}"), expected));
    }
    let gamma = (inner - outer) / count;
    let greatest = (1.0 - gamma * gamma) / (2.0 * gamma);
    if element > greatest * (1.0 + SPIN_ERROR) || element < 0.5 * greatest {
        let expected = format!(
            "{:.3} to {greatest:.3} with these outer and inner: the spin of an element about its own axis (BSF), not the \
             double, with which its damage strikes both races",
            0.5 * greatest
        );
        return Err(node.invalid(format!("element = {element}"), expected));
    }
    // The mean of both races, each of which is rounded.
    let cage = 0.5 * (1.0 - gamma);
    let orders = Orders { cage, outer_race: count * cage, inner_race: count * (1.0 - cage), ball_spin: element };
    Ok((elements, KinematicData::Orders(orders)))
}
