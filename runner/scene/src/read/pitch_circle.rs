//! Number and diameter of the elements, pitch diameter and contact angle of a `[[bearing]]`.

use super::super::table::{Node, Read, Table};
use super::super::units::Dimension;
use std::f64::consts::{FRAC_PI_3, PI};

/// Numbers of rolling elements that the kernel supports.
pub(super) const ELEMENTS: std::ops::RangeInclusive<i64> = 3..=64;

/// The key whose presence makes the elements of a bearing rollers.
pub(super) const ROLLER_DIAMETER: &str = "roller_diameter";

/// Reads the number of elements.
pub(super) fn elements(table: &Table<'_>) -> Read<usize> {
    let expected = "a whole number from 3 to 64 (rolling elements)";
    let node = table.required("elements", expected)?;
    let number = node.integer(expected)?;
    usize::try_from(number).map_err(|_| node.refuse(expected))
}

/// Reads the pitch diameter, which is above the diameter of an element with this key.
pub(super) fn pitch_diameter(table: &Table<'_>, (key, diameter): (&str, f64)) -> Read<f64> {
    let range = format!("above {key} ({} mm)", (diameter * 1e9).round() / 1e6);
    let expected = Dimension::Length.expected(&range);
    let node = table.required("pitch_diameter", &expected)?;
    node.within(&range, |x| x > diameter)
}

/// Reads the free contact angle.
pub(super) fn contact_angle(node: &Node<'_>) -> Read<f64> {
    // 60 degrees converted may be a rounding above pi/3.
    let angle = node.within("from 0 to 60 deg", |x| (0.0..=FRAC_PI_3 * (1.0 + 1e-12)).contains(&x))?;
    Ok(angle.min(FRAC_PI_3))
}

/// Rejects elements that touch each other on the pitch circle, which leave no room for a cage, and overlapping ones.
pub(super) fn check_fit_on_pitch_circle(
    table: &Table<'_>,
    elements: usize,
    (key, diameter): (&str, f64),
    pitch: f64,
) -> Read<()> {
    let fits = |n: i64| pitch * (PI / n as f64).sin() > diameter;
    // The chord between neighbours shrinks with their number from 3 on.
    let most = ELEMENTS.rev().find(|n| fits(*n)).unwrap_or(0);
    if usize::try_from(most).is_ok_and(|most| elements <= most) {
        return Ok(());
    }
    let elements_of = if key == ROLLER_DIAMETER { "rollers" } else { "balls" };
    let expected = if most == 0 {
        format!("a larger pitch_diameter or smaller {elements_of}: not even 3 of this {key} fit on the pitch circle")
    } else {
        format!("3 to {most}: more {elements_of} of this {key} do not fit on the pitch circle")
    };
    Err(table.required("elements", &expected)?.refuse(expected))
}
