//! `ballrace bake`: the constants that the firmware of `tests/target/baked` compiles in.

use ballrace::bearing::Bearing;
use ballrace::{Displacement, Rotation, Turn};

use crate::support::{Desk, numbers};

#[path = "../target/baked/src/bearings.rs"]
#[rustfmt::skip]
mod bearings;

const SCENE: &str = include_str!("../target/baked/scene.toml");
const BAKED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/baked/src/bearings.rs");

#[test]
fn the_firmware_has_what_its_scene_says() {
    let desk = Desk::empty();
    desk.put("scene.toml", SCENE);
    desk.done(&["bake", "scene.toml", "-o", "out.rs"]);
    let fresh = desk.read("out.rs");
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(BAKED, fresh).unwrap();
        return;
    }
    let kept = std::fs::read_to_string(BAKED).unwrap();
    assert!(fresh == kept, "bake the scene again: ballrace bake tests/target/baked/scene.toml -o {BAKED}");
}

#[test]
fn constants_answer_as_the_scene_does() {
    let desk = Desk::empty();
    desk.put("scene.toml", SCENE);
    let rows = ["1e-6,2e-6,1e-5,0,0", "-3e-6,0,8e-6,1e-4,-5e-5", "0,5e-6,4e-6,0,2e-4", "2e-5,0,1e-5,0,0"];
    desk.put("u.csv", format!("u,v,w,thu,thv\n{}\n", rows.join("\n")));
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", "DE", "--precision", "f32"];
    let (_, forces) = numbers(
        &desk.done(&[&args[..], &["--format", "csv"]].concat()).out.replace(",ok", "").replace(",out-of-table", ""),
    );
    let bearing = bearings::bearing_de::bearing();
    for (row, force) in rows.iter().zip(&forces) {
        let u: Vec<f32> = row.split(',').map(|x| x.parse().unwrap()).collect();
        let u = Displacement::from_array(<[f32; 5]>::try_from(u).unwrap());
        let speed = (12_000.0 * std::f64::consts::TAU / 60.0) as f32;
        let at = Rotation { inner_speed: speed, ..Rotation::from(Turn::ZERO) };
        let found = bearing.reaction(&u, &at).wrench.to_array();
        let told: Vec<f32> = force.iter().map(|f| *f as f32).collect();
        assert_eq!(found.map(f32::to_bits).to_vec(), told.iter().map(|f| f.to_bits()).collect::<Vec<_>>(), "{row}");
    }
}

#[test]
fn a_model_without_a_table_is_refused() {
    let desk = Desk::rig();
    desk.refused(&["bake", "scene.toml", "-o", "out.rs"], 2, &["bearing DE: model: found one without a table"]);
    assert!(!desk.files().contains(&"out.rs".to_owned()));
}
