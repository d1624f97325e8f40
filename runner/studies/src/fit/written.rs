//! Writes fitted values into the text of a scene.

use super::Fitted;
use super::parameters::{ParameterKind, planes, two_planes};
use ballrace_plant::error::FitError;
use ballrace_scene::{PreloadAmount, PreloadState, Scene, Unbalance};
use toml_edit::{Array, DocumentMut, InlineTable, Item, TableLike, Value, value};

/// Returns `text`, the scene's file, with the fitted numbers; parameters that are not identifiable keep their value.
///
/// # Errors
/// Returns an error if the text is not TOML or its tables have another form than the fitted values require.
pub fn written(fitted: &Fitted, scene: &Scene, text: &str) -> Result<String, FitError> {
    let form = |expected| FitError::Form { file: scene.path.clone(), expected };
    let syntax = |source| FitError::Syntax { file: scene.path.clone(), source };
    let mut document: DocumentMut = text.parse().map_err(syntax)?;
    let (mut force, mut couple) = ([0.0; 2], [0.0; 2]);
    let mut turned = false;
    for (parameter, found) in &fitted.values {
        let (_, unit, size) = parameter.kind.name(scene);
        let reduction = match parameter.kind {
            ParameterKind::Clearance(b) => reduction(scene, b),
            ParameterKind::Play(b) => 0.5 * reduction(scene, b),
            _ => 0.0,
        };
        let shown = value(format!("{:.6} {unit}", (found + reduction) / size));
        match parameter.kind {
            ParameterKind::Unbalance(i) => (force[i], turned) = (*found, true),
            ParameterKind::Couple(i) => (couple[i], turned) = (*found, true),
            ParameterKind::Damping(k) => damping(&mut document, k, *found).map_err(form)?,
            ParameterKind::Clearance(b) => put(&mut document, b, "diametral_clearance", shown).map_err(form)?,
            ParameterKind::Play(b) => put(&mut document, b, "radial_play", shown).map_err(form)?,
            ParameterKind::Modulus(b) => put(&mut document, b, "youngs_modulus", shown).map_err(form)?,
            ParameterKind::CageAngle(b) => put(&mut document, b, "first_element_azimuth", shown).map_err(form)?,
            ParameterKind::CageRatio(b) => put(&mut document, b, "cage_ratio", value(*found)).map_err(form)?,
            ParameterKind::Stiffness(b) => put(&mut document, b, "stiffness", value(*found)).map_err(form)?,
            ParameterKind::Preload(b) => {
                let key = match scene.bearings.get(b).and_then(|b| b.preload).map(|preload| preload.amount) {
                    Some(PreloadAmount::Force(_)) => "force",
                    _ => "displacement",
                };
                let mut table = InlineTable::new();
                table.insert(key, Value::from(format!("{:.6} {unit}", found / size)));
                let set = scene.bearings.get(b).and_then(|b| b.preload).map(|preload| preload.set);
                if let Some(set) = set.filter(|set| *set != PreloadState::default()) {
                    table.insert("set", Value::from(set.name()));
                }
                put(&mut document, b, "preload", value(table)).map_err(form)?;
            }
            ParameterKind::Offset(p) => {
                let probes = document.get_mut("recording").and_then(|r| r.get_mut("probes"));
                let probe = probes.and_then(Item::as_array_mut).and_then(|all| all.get_mut(p));
                let probe =
                    probe.and_then(Value::as_inline_table_mut).ok_or_else(|| form("each probe as an inline table"))?;
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
            table.insert("station", Value::from(format!("{:.6} mm", scene.drawn_station(one.station) * 1e3)));
            list.push(table);
        }
        let rotor = document.get_mut("rotor").and_then(Item::as_table_like_mut).ok_or_else(|| form("[rotor]"))?;
        rotor.insert("unbalance", value(list));
    }
    Ok(document.to_string())
}

/// Returns the reduction of the clearance by fits and temperatures, m: the scene file has the clearance before mounting.
fn reduction(scene: &Scene, bearing: usize) -> f64 {
    let mounting = scene.bearings.get(bearing).and_then(|bearing| bearing.mounting);
    mounting.map_or(0.0, |mounting| mounting.operating().reduction())
}

/// Sets a key in the table of a bearing; the error is the expected form.
fn put(document: &mut DocumentMut, bearing: usize, key: &str, item: Item) -> Result<(), &'static str> {
    let tables = document.get_mut("bearing").and_then(Item::as_array_of_tables_mut);
    let table = tables.and_then(|tables| tables.iter_mut().nth(bearing)).ok_or("bearings as [[bearing]]")?;
    table.insert(key, item);
    Ok(())
}

/// Sets a damping in the rotor's list; the error is the expected form.
fn damping(document: &mut DocumentMut, group: usize, found: f64) -> Result<(), &'static str> {
    let rotor: &mut dyn TableLike = document.get_mut("rotor").and_then(Item::as_table_like_mut).ok_or("[rotor]")?;
    let zeros = || value(Array::from_iter([0.0; 5]));
    let list = rotor.entry("damping").or_insert_with(zeros).as_array_mut().ok_or("rotor.damping as a list")?;
    for i in [0..2, 2..3, 3..5][group].clone() {
        list.replace(i, found);
    }
    Ok(())
}
