//! `ballrace bake`: the constants that the firmware of `tests/target/baked` compiles in.

use ballrace::bearing::Bearing;
use ballrace::{BearingKinematicState, Displacement, Phase};

use crate::support::{DEMO_SCENE, Desk, numbers, short_recording};

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
        let at = BearingKinematicState { inner_speed: speed, ..BearingKinematicState::from(Phase::ZERO) };
        let found = bearing.reaction(&u, &at).wrench.to_array();
        let told: Vec<f32> = force.iter().map(|f| *f as f32).collect();
        assert_eq!(found.map(f32::to_bits).to_vec(), told.iter().map(|f| f.to_bits()).collect::<Vec<_>>(), "{row}");
    }
}

/// Every model that firmware can have, from one rotor: lumped with damage, lumped with axial elements, angular and
/// mirrored, springs linearised from it.
const DIRECT: &str = r#"
[shaft]
speed = "3000 rpm"
[rotor]
mass = "6 kg"
diametral_inertia = 0.03
polar_inertia = 0.006
damping = [400, 400, 400, 0.4, 0.4]
load = [0, 0, 60, 0, 0]
[[bearing]]
name = "A"
station = "-100 mm"
model = "lumped"
elements = 9
cage_ratio = 0.4
stiffness = 8e9
radial_play = "2 um"
defect = [{ surface = "outer", azimuth = "-90 deg", half_width = "3 deg", depth = "1 um", shape = "half-sine" }]
[[bearing]]
name = "B"
station = "-50 mm"
model = "lumped"
elements = 12
cage_ratio = 0.4
stiffness = 3e8
exponent = 1.1111
radial_play = "-1 um"
axial = { stiffness = 1e9, exponent = 1.4, play = "0 um", radius = "20 mm" }
[[bearing]]
name = "C"
station = "50 mm"
model = "angular"
facing = "-z"
elements = 14
ball_diameter = "7 mm"
pitch_diameter = "38.5 mm"
inner_conformity = 0.52
outer_conformity = 0.52
contact_angle = "25 deg"
[[bearing]]
name = "D"
station = "100 mm"
model = "linear"
linearise = "angular"
elements = 9
ball_diameter = "7.94 mm"
pitch_diameter = "39.04 mm"
inner_conformity = 0.52
outer_conformity = 0.52
diametral_clearance = "10 um"
"#;

/// What is baked compiles without `std` and answers with the bits of `force --precision f32`.
#[test]
fn every_model_of_firmware_is_baked() {
    let desk = Desk::empty();
    desk.put("scene.toml", DIRECT);
    desk.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    let rows = ["1e-6,2e-6,1e-5,0.0,0.0", "-3e-6,4e-6,-8e-6,1e-4,-5e-5", "2e-5,0.0,-1e-5,0.0,2e-4"];
    let lines: String = rows.iter().map(|row| format!("[{row}],")).collect();
    let calls: String = ["a", "b", "c", "d"].map(|name| format!("told(&bearing_{name}::bearing());")).concat();
    let mut found = desk.compiled(&format!(
            "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\nuse ballrace::{{Bearing, Displacement, Phase}};\nuse bearings::*;\n\
             fn told(bearing: &impl Bearing<f32>) {{ for u in [{lines}] {{\n\
             let f = bearing.reaction(&Displacement::from_array(u), &Phase::ZERO.into()).wrench.to_array();\n\
             println!(\"{{}}\", f.map(|x: f32| (x + 0.0).to_bits().to_string()).join(\",\")); }} }}\nfn main() {{ {calls} }}\n"));
    desk.put("u.csv", format!("u,v,w,thu,thv\n{}\n", rows.join("\n")));
    for name in ["A", "B", "C", "D"] {
        let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", name, "--precision", "f32"];
        let out = desk.done(&[&args[..], &["--format", "csv"]].concat()).out;
        let words = |line: &str| line.rsplit_once(',').unwrap().0.to_owned();
        for line in out.lines().skip(1).map(words) {
            let bits: Vec<String> =
                line.split(',').map(|x| (x.parse::<f32>().unwrap() + 0.0).to_bits().to_string()).collect();
            let (first, rest) = found.split_once('\n').unwrap();
            assert_eq!(first, bits.join(","), "{name}: {line}");
            found = rest.to_owned();
        }
    }
}

#[test]
fn what_firmware_has_no_constants_for_is_refused() {
    let desk = Desk::empty();
    let displaced: Vec<&str> = vec!["[0, 0, 0]"; 9];
    let housing = format!("radial_play = \"2 um\"\nhousing_displacement = [{}]", displaced.join(", "));
    let scene = DIRECT.replacen("radial_play = \"2 um\"", &housing, 1);
    let scene = scene.lines().filter(|line| !line.starts_with("defect")).collect::<Vec<_>>().join("\n");
    desk.put("scene.toml", scene);
    desk.refused(
        &["bake", "scene.toml", "-o", "out.rs"],
        2,
        &["bearing A: model: found lumped with a displaced housing"],
    );
    assert!(!desk.files().contains(&"out.rs".to_owned()));
}

/// The observer in `f32` from what was baked stands where that of `replay` does at the end of a recording.
#[test]
fn the_observer_is_baked() {
    let desk = Desk::empty();
    let samples = 1024;
    desk.put("healthy.csv", short_recording(samples));
    desk.put("scene.toml", format!("{DEMO_SCENE}\n[observer]\nwander = 0.2\n"));
    desk.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    desk.replay("scene.toml", &["--forces", "forces.csv"]);
    let (_, told) = numbers(&desk.read("forces.csv"));
    let (head, rows) = numbers(&desk.read("healthy.csv"));
    assert_eq!(head[1..=5].join(","), "DE_X_um,DE_Y_um,NDE_X_um,NDE_Y_um,axial_um");
    let readings: String =
        rows.iter().map(|row| format!("{:?},", row[1..=5].iter().map(|x| x * 1e-6).collect::<Vec<_>>())).collect();
    let found = desk.compiled(&format!(
        "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\n\
         use ballrace::rotor::*; use ballrace::twin::*; use ballrace::*;\nuse bearings::{{*, observer::*}};\n\
         const READINGS: [[f32; 5]; {samples}] = [{readings}];\n\
         fn main() {{\n\
         let rotor = RigidRotor::<f32, Exact>::try_new(&ROTOR, &UNBALANCES).unwrap();\n\
         let gear = SpeedRatios::new(bearing_de::CAGE_RATIO);\n\
         let bearings = [Mounted {{ bearing: bearing_de::bearing(), station: bearing_de::STATION, gear }}, Mounted {{ bearing: bearing_nde::bearing(), station: bearing_nde::STATION, gear }}];\n\
         let step = PERIOD / SUBSTEPS as f32;\n\
         let observer = Observer {{ machine: RotorBearingSystem {{ rotor, bearings }}, integrator: RungeKutta4 {{ step }}, step, substeps: SUBSTEPS, probes: PROBES, gains: &GAINS, speeds: SPEEDS, memory: MEMORY, gate: GATE }};\n\
         let first = READINGS[0]; let _ = first;\n\
         let start = Displacement {{ u: 0.5 * (first[0] + first[2]), v: 0.5 * (first[1] + first[3]), w: first[4], thu: 0.0, thv: 0.0 }};\n\
         let mut state = ObserverState::new(RotorState::at_rest(start, Phase::ZERO, [Phase::ZERO; 2]));\n\
         let mut nis = 0.0;\n\
         for (i, readings) in READINGS.iter().enumerate().skip(1) {{\n\
         let drive = ShaftMotion {{ angle: Phase::from_revolutions((i - 1) as f64 / 256.0), speed: 314.159_27, acceleration: 0.0 }};\n\
         let estimate = observer.sample::<Exact>(&mut state, &drive, readings);\n\
         if i > 768 {{ nis += estimate.nis / 255.0; }} }}\n\
         let at = observer.machine.bearings[0].gear.rotation(state.motion.parts[0], &ShaftMotion {{ angle: state.motion.shaft, speed: 314.159_27, acceleration: 0.0 }});\n\
         let f = observer.machine.bearings[0].bearing.reaction(&state.motion.displacement().at_station(bearing_de::STATION), &at).wrench.to_array();\n\
         println!(\"{{}},{{}},{{}},{{nis}}\", f[0], f[1], f[2]);\n\
         }}\n"
    ));
    let found: Vec<f64> = found.trim().split(',').map(|x| x.parse().unwrap()).collect();
    let last = &told[samples - 1];
    for i in 0..3 {
        assert!((found[i] - last[i + 1]).abs() < 3.0, "{found:?} {:?}", &last[1..4]);
    }
    assert!((3.0..8.0).contains(&found[3]), "{found:?}");
}
