//! The fitted scene, as a scene.

use super::Fitted;
use super::parameters::{Place, planes, two_planes};
use crate::scene::{Preload, Scene, Unbalance};
use anyhow::{Context, Result};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, TableLike, Value, value};

/// Returns `text`, the scene's file, with the fitted numbers; parameters that are not identifiable keep their value.
///
/// # Errors
/// A text that is no scene.
pub fn written(fitted: &Fitted, scene: &Scene, text: &str) -> Result<String> {
    let mut document: DocumentMut = text.parse().context("found no TOML")?;
    let (mut force, mut couple) = ([0.0; 2], [0.0; 2]);
    let mut turned = false;
    for (parameter, found) in &fitted.values {
        let (_, unit, size) = parameter.place.name(scene);
        let shown = value(format!("{:.6} {unit}", found / size));
        match parameter.place {
            Place::Unbalance(i) => (force[i], turned) = (*found, true),
            Place::Couple(i) => (couple[i], turned) = (*found, true),
            Place::Damping(k) => damping(&mut document, k, *found)?,
            Place::Clearance(b) => put(&mut document, b, "diametral_clearance", shown)?,
            Place::Play(b) => put(&mut document, b, "radial_play", shown)?,
            Place::Modulus(b) => put(&mut document, b, "youngs_modulus", shown)?,
            Place::Stiffness(b) => put(&mut document, b, "stiffness", value(*found))?,
            Place::Preload(b) => {
                let key = match scene.bearings.get(b).and_then(|b| b.preload) {
                    Some(Preload::Force(_)) => "force",
                    _ => "displacement",
                };
                let mut table = InlineTable::new();
                table.insert(key, Value::from(format!("{:.6} {unit}", found / size)));
                put(&mut document, b, "preload", value(table))?;
            }
            Place::Offset(p) => {
                let probes = document.get_mut("recording").and_then(|r| r.get_mut("probes"));
                let probe = probes.and_then(Item::as_array_mut).and_then(|all| all.get_mut(p));
                let probe = probe.and_then(Value::as_inline_table_mut).context("a probe in one line")?;
                probe.insert("offset", Value::from(format!("{:.6} {unit}", found / size)));
            }
        }
    }
    if turned {
        let unbalances: Vec<Unbalance> = if fitted.one_plane {
            let amount = force[0].hypot(force[1]);
            let station =
                if amount > 0.0 { (couple[0] * force[0] + couple[1] * force[1]) / (amount * amount) } else { 0.0 };
            vec![Unbalance { moment: amount, angle: force[1].atan2(force[0]), station }]
        } else {
            two_planes(force, couple, planes(scene)).to_vec()
        };
        let mut list = Array::new();
        for one in unbalances {
            let mut table = InlineTable::new();
            table.insert("moment", Value::from(format!("{:.6} g mm", one.moment * 1e6)));
            table.insert("angle", Value::from(format!("{:.6} rad", one.angle)));
            table.insert("station", Value::from(format!("{:.6} mm", one.station * 1e3)));
            list.push(table);
        }
        let rotor = document.get_mut("rotor").and_then(Item::as_table_like_mut).context("a [rotor]")?;
        rotor.insert("unbalance", value(list));
    }
    Ok(document.to_string())
}

fn put(document: &mut DocumentMut, bearing: usize, key: &str, item: Item) -> Result<()> {
    let tables: &mut ArrayOfTables =
        document.get_mut("bearing").and_then(Item::as_array_of_tables_mut).context("[[bearing]]")?;
    tables.iter_mut().nth(bearing).context("a [[bearing]]")?.insert(key, item);
    Ok(())
}

fn damping(document: &mut DocumentMut, group: usize, found: f64) -> Result<()> {
    let rotor: &mut dyn TableLike = document.get_mut("rotor").and_then(Item::as_table_like_mut).context("a [rotor]")?;
    let zeros = || value(Array::from_iter([0.0; 5]));
    let list = rotor.entry("damping").or_insert_with(zeros).as_array_mut().context("rotor.damping as a list")?;
    for i in [0..2, 2..3, 3..5][group].clone() {
        list.replace(i, found);
    }
    Ok(())
}
