//! `ballrace bake`: the constants that the firmware of `tests/target/baked` compiles in.

use ballrace::bearing::Bearing;
use ballrace::{BearingKinematicState, Displacement, Phase};
use serde_json::Value;

use crate::support::{DEMO_SCENE, Sandbox, changed, numbers, short_recording, swap};

#[path = "../target/baked/src/bearings.rs"]
#[rustfmt::skip]
mod bearings;
#[path = "../target/baked/src/log.rs"]
mod log;

const SCENE: &str = include_str!("../target/baked/scene.toml");
/// Every model that C has, in both facings, with a preload and a title that a comment has to escape.
pub const EVERY_MODEL_OF_C: &str = include_str!("../target/c/every_model.toml");
/// A scene of firmware, and the files of `tests/target` that are baked from it.
const BAKED: [(&str, &str, &[&str]); 4] = [
    ("scene.toml", SCENE, &["baked/src/bearings.rs"]),
    ("scene.toml", FLEXIBLE, &["baked/src/flexible.rs"]),
    ("every_model.toml", EVERY_MODEL_OF_C, &["c/every_model.h", "c/every_model.c"]),
    ("every_model.toml", EVERY_MODEL_OF_C, &["c/every_model.blob"]),
];

#[test]
fn the_firmware_has_the_constants_of_its_scene() {
    for (name, scene, files) in BAKED {
        let sandbox = Sandbox::empty();
        sandbox.put(name, scene);
        let own = |file: &'static str| file.rsplit('/').next().unwrap();
        // Constants in C are baked into a header, the source of its name beside it.
        sandbox.done(&["bake", name, "-o", own(files[0])]);
        for file in files {
            let fresh = std::fs::read(sandbox.path(own(file))).unwrap();
            let path = format!("{}/target/{file}", env!("CARGO_MANIFEST_DIR"));
            if std::env::var_os("BALLRACE_WRITE").is_some() {
                std::fs::write(path, fresh).unwrap();
                continue;
            }
            let kept = std::fs::read(&path).unwrap();
            assert!(fresh == kept, "{path} differs from its baked scene: BALLRACE_WRITE=1 writes it");
        }
    }
}

/// `ballrace force` computes the bits of the log of the firmware from the columns of its input. A test of the target holds that the
/// image prints these rows.
#[test]
fn force_computes_the_log_of_the_firmware() {
    fn rows(bearing: &impl Bearing<f32>, mirrored: bool) -> Vec<String> {
        let row = |i| {
            let u = log::displacement(i);
            let u = if mirrored { u.mirrored() } else { u };
            log::Row::new(bearing, &u, &log::rotation(i)).to_string()
        };
        (0..log::SAMPLES).map(row).collect()
    }
    let logs =
        [("DE", rows(&bearings::bearing_de::bearing(), false)), ("NDE", rows(&bearings::bearing_nde::bearing(), true))];
    for (name, rows) in logs {
        let columns = log::INPUT.split(',').count();
        let (mut input, mut forces) = (format!("{}\n", log::INPUT), "FX,FY,FZ,MX,MY,status\n".to_owned());
        for row in rows {
            let cells: Vec<&str> = row.split(',').collect();
            let (displacement, force) = cells.split_at(columns);
            input += &format!("{}\n", displacement.join(","));
            forces += &format!("{}\n", force.join(","));
        }
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", SCENE);
        sandbox.put("log.csv", input);
        let args = ["force", "scene.toml", "--bearing", name, "--precision", "f32", "--bits", "--format", "csv"];
        assert_eq!(sandbox.done(&[&args[..], &["--displacements", "log.csv"]].concat()).out, forces, "{name}");
    }
}

#[test]
fn constants_give_the_forces_of_the_scene() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let rows = ["1e-6,2e-6,1e-5,0,0", "-3e-6,0,8e-6,1e-4,-5e-5", "0,5e-6,4e-6,0,2e-4", "2e-5,0,1e-5,0,0"];
    sandbox.put("u.csv", format!("u,v,w,thu,thv\n{}\n", rows.join("\n")));
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", "DE", "--precision", "f32"];
    let (_, forces) = numbers(
        &sandbox.done(&[&args[..], &["--format", "csv"]].concat()).out.replace(",ok", "").replace(",out-of-table", ""),
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

/// Baked constants compile without `std` and give the bits of `force --precision f32`.
#[test]
fn every_model_of_firmware_is_baked() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DIRECT);
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    let rows = ["1e-6,2e-6,1e-5,0.0,0.0", "-3e-6,4e-6,-8e-6,1e-4,-5e-5", "2e-5,0.0,-1e-5,0.0,2e-4"];
    let lines: String = rows.iter().map(|row| format!("[{row}],")).collect();
    let calls: String = ["a", "b", "c", "d"].map(|name| format!("told(&bearing_{name}::bearing());")).concat();
    let mut found = sandbox.compiled(&format!(
            "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\nuse ballrace::{{Bearing, Displacement, Phase}};\nuse bearings::*;\n\
             fn told(bearing: &impl Bearing<f32>) {{ for u in [{lines}] {{\n\
             let f = bearing.reaction(&Displacement::from_array(u), &Phase::ZERO.into()).wrench.to_array();\n\
             println!(\"{{}}\", f.map(|x: f32| (x + 0.0).to_bits().to_string()).join(\",\")); }} }}\nfn main() {{ {calls} }}\n"));
    sandbox.put("u.csv", format!("u,v,w,thu,thv\n{}\n", rows.join("\n")));
    for name in ["A", "B", "C", "D"] {
        let args = ["force", "scene.toml", "--displacements", "u.csv", "--bearing", name, "--precision", "f32"];
        let out = sandbox.done(&[&args[..], &["--format", "csv"]].concat()).out;
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
fn scenes_without_firmware_constants_are_rejected() {
    let sandbox = Sandbox::empty();
    let displaced = format!("housing_displacement = [{}]", ["[0, 0, 0]"; 9].join(", "));
    for ring in [&displaced, "outer_ring = { radius = \"30 mm\", width = \"15 mm\", thickness = \"4 mm\" }"] {
        let scene = DIRECT.replacen("radial_play = \"2 um\"", &format!("radial_play = \"2 um\"\n{ring}"), 1);
        let scene = scene.lines().filter(|line| !line.starts_with("defect")).collect::<Vec<_>>().join("\n");
        sandbox.put("scene.toml", scene);
        let message = "bearing A: an outer ring that is displaced or bends has no constants in bake: model lumped, expected a rigid one";
        sandbox.refused(&["bake", "scene.toml", "-o", "out.rs"], 2, &[message]);
    }
    for (keys, message) in [
        (
            "bearing = \"22210\"",
            "two rows of rollers have no constants in bake: model roller, expected model = \"linear\" with linearise = \"roller\"",
        ),
        (
            "bearing = \"NU210\"\nmodel = \"quasi-static\"",
            "rollers in equilibrium have no constants in bake: model quasi-static-roller, expected model = \"roller\"",
        ),
    ] {
        sandbox.put("scene.toml", format!("shaft.speed = \"1500 rpm\"\n[[bearing]]\nname = \"A\"\n{keys}\n"));
        sandbox.refused(&["bake", "scene.toml", "-o", "out.rs"], 2, &[&format!("bearing A: {message}")]);
    }
    assert!(!sandbox.files().contains(&"out.rs".to_owned()));
}

/// The observer in `f32` from what was baked stands where that of `replay` does at the end of a recording.
#[test]
fn the_observer_is_baked() {
    let sandbox = Sandbox::empty();
    let samples = 1024;
    sandbox.put("healthy.csv", short_recording(samples));
    sandbox.put("scene.toml", format!("{DEMO_SCENE}\n[observer]\nprocess_noise = 0.2\n"));
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    sandbox.replay("scene.toml", &["--forces", "forces.csv"]);
    let (_, told) = numbers(&sandbox.read("forces.csv"));
    let (head, rows) = numbers(&sandbox.read("healthy.csv"));
    assert_eq!(head[1..=5].join(","), "DE_X_um,DE_Y_um,NDE_X_um,NDE_Y_um,axial_um");
    let readings: String =
        rows.iter().map(|row| format!("{:?},", row[1..=5].iter().map(|x| x * 1e-6).collect::<Vec<_>>())).collect();
    let found = sandbox.compiled(&format!(
        "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\n\
         use ballrace::rotor::*; use ballrace::twin::*; use ballrace::*;\nuse bearings::{{*, observer::*}};\n\
         const READINGS: [[f32; 5]; {samples}] = [{readings}];\n\
         fn main() {{\n\
         let rotor = RigidRotor::<f32, Exact>::try_new(&ROTOR, &UNBALANCES).unwrap();\n\
         let speed_ratios = SpeedRatios::new(bearing_de::CAGE_RATIO);\n\
         let bearings = [BearingAtStation {{ bearing: bearing_de::bearing(), station: bearing_de::STATION, speed_ratios }}, BearingAtStation {{ bearing: bearing_nde::bearing(), station: bearing_nde::STATION, speed_ratios }}];\n\
         let step = PERIOD / SUBSTEPS as f32;\n\
         let observer = Observer {{ system: RotorBearingSystem {{ rotor, bearings }}, integrator: RungeKuttaNystrom {{ step }}, step, substeps: SUBSTEPS, probes: PROBES, gains: &GAINS, speeds: SPEEDS, load_retention: MEMORY, gate: GATE }};\n\
         let first = READINGS[0]; let _ = first;\n\
         let start = Displacement {{ u: 0.5 * (first[0] + first[2]), v: 0.5 * (first[1] + first[3]), w: first[4], thu: 0.0, thv: 0.0 }};\n\
         let mut state = ObserverState::new(RotorState::stationary(start, Phase::ZERO, [Phase::ZERO; 2]));\n\
         let mut nis = 0.0;\n\
         for (i, readings) in READINGS.iter().enumerate().skip(1) {{\n\
         let drive = ShaftMotion {{ angle: Phase::from_revolutions((i - 1) as f64 / 256.0), speed: 314.159_27, acceleration: 0.0 }};\n\
         let estimate = observer.sample::<Exact>(&mut state, &drive, readings);\n\
         if i > 768 {{ nis += estimate.nis / 255.0; }} }}\n\
         let at = observer.system.bearings[0].speed_ratios.kinematic_state(state.motion.component_angles[0], &ShaftMotion {{ angle: state.motion.shaft_angle, speed: 314.159_27, acceleration: 0.0 }});\n\
         let f = observer.system.bearings[0].bearing.reaction(&state.motion.displacement().at_station(bearing_de::STATION), &at).wrench.to_array();\n\
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

/// The constants of a checksum compile and give the value of the certificate, in every model.
#[test]
fn the_checksum_of_every_model_is_that_of_the_certificate() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DIRECT);
    let baked: Value = sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs", "--format", "json"]).json();
    let calls = ["a", "b", "c", "d"].map(|name| {
        format!("println!(\"{{:#018x}} {{:#018x}}\", bearing_{name}::checksum(), bearing_{name}::CHECKSUM);")
    });
    let found = sandbox.compiled(&format!(
        "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\nuse bearings::*;\nfn main() {{ {} }}\n",
        calls.concat()
    ));
    let expected: String = baked
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["checksum"].as_str().unwrap())
        .fold(String::new(), |text, checksum| text + checksum + " " + checksum + "\n");
    assert_eq!(found, expected);
}

/// A rotor that bends, on bearings of which one has a support.
const FLEXIBLE: &str = include_str!("../target/baked/flexible.toml");

/// Integrates the baked system in `f32` from the motion of `simulate`, and observes that motion from a displaced state.
const FLEXIBLE_FIRMWARE: &str = r#"
fn main() {
    let ratio = SpeedRatios::new(bearing_de::CAGE_RATIO);
    let [de, nde] = bearings::rotor::attachments();
    let on_coordinates = [
        AttachedBearing { bearing: bearing_de::bearing(), attachment: de, speed_ratios: ratio },
        AttachedBearing { bearing: bearing_nde::bearing(), attachment: nde, speed_ratios: ratio },
    ];
    let system = RotorBearingSystem { rotor: bearings::rotor::rotor().unwrap(), bearings: on_coordinates };
    let step = PERIOD / SUBSTEPS as f32;
    let integrator = Verlet { step };
    let drive = |i: usize| {
        let angle = Phase::from_revolutions(i as f64 / 256.0);
        ShaftMotion { angle, speed: 314.159_27, acceleration: 0.0 }
    };
    let mut state = RotorState::stationary(MOTION[0], Phase::ZERO, [Phase::ZERO; 2]);
    let observer = Observer {
        system, integrator, step, substeps: SUBSTEPS, probes: PROBES, gains: &GAINS, speeds: SPEEDS, load_retention: MEMORY,
        gate: f32::INFINITY,
    };
    let mut observed = ObserverState::new(RotorState { q: MOTION[0].map(|x| 0.9 * x), ..state });
    for i in 1..MOTION.len() {
        for k in 0..SUBSTEPS {
            integrator.step(&observer.system, &mut state, &drive(i - 1).after(k as f32 * step));
        }
        let readings = PROBES.map(|row| row.iter().zip(&MOTION[i]).map(|(c, q)| c * q).sum());
        observer.sample::<Exact>(&mut observed, &drive(i - 1), &readings);
    }
    for q in [&state.q, &observed.motion.q] {
        println!("{}", q.map(|x| x.to_string()).join(","));
    }
}
"#;

/// The baked equations of a flexible rotor on a support move as in `simulate`, and the baked observer follows that motion.
#[test]
fn a_flexible_rotor_and_its_observer_are_baked() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", FLEXIBLE);
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    sandbox.done(&["simulate", "scene.toml", "--duration", "0.1 s", "--rate", "12.8 kHz", "-o", "motion.csv"]);
    let (head, rows) = numbers(&sandbox.read("motion.csv"));
    let order = head.iter().position(|name| name == "u_dot").unwrap() - 1;
    assert_eq!(head[1..=order].join(","), "u,v,w,thu,thv,bending_1_x,bending_1_y,NDE_support_u,NDE_support_v");
    let motion: String = rows.iter().map(|row| format!("{:?},", &row[1..=order])).collect();
    let found = sandbox.compiled(&format!(
        "#![allow(dead_code, unused_imports)]\n#[path = \"../bearings.rs\"]\nmod bearings;\n\
         use ballrace::rotor::*; use ballrace::twin::*; use ballrace::*;\nuse bearings::{{bearing_de, bearing_nde, observer::*}};\n\
         const MOTION: [[f32; bearings::rotor::COORDINATES]; {}] = [{motion}];\n{FLEXIBLE_FIRMWARE}",
        rows.len()
    ));
    let last = &rows.last().unwrap()[1..=order];
    for (what, line) in ["integrated", "observed"].into_iter().zip(found.lines()) {
        let q: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(q.len(), order);
        for ((name, q), expected) in head[1..].iter().zip(q).zip(last) {
            // A thousandth of the motion, in m and rad.
            assert!((q - expected).abs() < 2e-9, "{what}: {name}: {q} {expected}");
        }
    }
}

/// Nothing certifies a rotor that its bearings do not hold, a load beyond the static rating, or the gap of the probes as a position.
#[test]
fn nonsense_is_not_certified() {
    let sandbox = Sandbox::empty();
    let (bare, _) = DEMO_SCENE.split_once("[recording]").unwrap();
    sandbox.put("sound.toml", bare);
    // The lumped model carries no axial load.
    sandbox.put("unsupported.toml", bare.replace("model = \"angular\"", "model = \"lumped\""));
    sandbox.put("overload.toml", bare.replace("\"60 N\"", "\"60 kN\""));
    let bake = |scene: &str, parts: &[&str]| sandbox.refused(&["bake", scene, "-o", "out.rs"], 2, parts);
    bake("unsupported.toml", &["unsupported.toml: no equilibrium: ", "expected at most 1e-6 in bake"]);
    bake("overload.toml", &["overload.toml: bearing ", "on an element", "the static limit of ISO 76"]);
    // A motion that overflows has no poses, of which the error could be stated.
    let coarse = swap(bare, "\"3000 rpm\"", "\"200 rpm\"") + "[integration]\nstep = \"1 ms\"\n";
    sandbox.put("coarse.toml", coarse);
    sandbox.refused(&["bake", "coarse.toml", "-o", "out.rs"], 1, &["the motion overflows: ", "us is beyond "]);
    assert!(!sandbox.files().contains(&"out.rs".to_owned()));
    sandbox.done(&["bake", "sound.toml", "-o", "sound.rs"]);
    let verify = |scene: &str, part: &str| sandbox.refused(&["verify", "sound.rs", "--scene", scene], 2, &[part]);
    verify("unsupported.toml", "no equilibrium");
    verify("overload.toml", "static limit");

    let gap = changed(2048, |_, k, x| if (1..5).contains(&k) { x + 55.0 } else { x });
    let sandbox = Sandbox::with(DEMO_SCENE, &gap);
    let parts = ["healthy.csv: bearing DE: median force of ", "10 times the loads on the rotor", "(offset)"];
    sandbox.refused(&["bake", "scene.toml", "-o", "out.rs"], 2, &parts);
}

/// The language of the constants is that of the name of their file.
#[test]
fn the_name_of_the_file_gives_the_language() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    sandbox.put("healthy.csv", crate::support::HEALTHY_RECORDING);
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.h"]);
    assert!(sandbox.read("bearings.h").contains("#include") && sandbox.read("bearings.c").contains("bearings.h"));
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    assert!(sandbox.read("bearings.rs").contains("// language: rust"));
    sandbox.refused(
        &["bake", "scene.toml", "-o", "bearings.txt"],
        2,
        &["--output: no language for this name: bearings.txt, expected a name that ends in .rs, .h, .c or .blob"],
    );
    sandbox.refused(
        &["bake", "scene.toml", "--language", "rust", "-o", "one.h"],
        2,
        &["--output: invalid name for --language rust: one.h"],
    );
}

/// A bearing whose contact angle follows the displacement needs w: `bake` states it where no probe of the scene is axial, with the force that is
/// lost, which is that of `ballrace force`. Lumped elements need no w, and have a path of constant time on a core without an FPU.
#[test]
fn what_firmware_needs_beside_the_constants() {
    let sandbox = Sandbox::rig();
    let bake = |scene: &str, core: &str| -> Value {
        sandbox.put("needs.toml", scene);
        sandbox.done(&["bake", "needs.toml", "-o", "needs.rs", "--core", core, "--format", "json"]).json()
    };
    let demo = sandbox.read("scene.toml");
    let axial = demo.lines().find(|line| line.contains("axial = true")).unwrap();
    assert!(bake(&demo, "cortex-m4f")[0].get("unmeasured_axial").is_none());
    let radial = swap(&demo, axial, "");
    let out = bake(&radial, "cortex-m4f");
    let needs = &out[0]["unmeasured_axial"];
    let number = |of: &str| needs[of].as_f64().unwrap();
    // The rotor's weight is on two bearings, and 60 N along the shaft.
    assert!(number("force_without_n") < 1e-9 && (35.0..50.0).contains(&number("force_n")), "{needs}");
    let equilibrium: Value = sandbox.done(&["equilibrium", "needs.toml", "--format", "json"]).json();
    let w = 1e6 * equilibrium["displacement"][2].as_f64().unwrap();
    assert!((number("w_um") - w).abs() < 1e-3 * w.abs(), "{w}: {needs}");
    let text = sandbox.done(&["bake", "needs.toml", "-o", "needs.rs"]).out;
    assert!(
        text.contains("no probe of the scene measures w: with u and v alone the force at rest is 0.0 N in place of"),
        "{text}"
    );

    let scenes = sandbox.done(&["scenes", "tiwari-balanced"]).out;
    let out = bake(&scenes, "cortex-m0plus");
    let path = &out[0]["fixed_point"];
    assert_eq!((path["exponent"].as_f64(), path["has_axial"].as_bool()), (Some(1.5), Some(false)), "{out}");
    assert!(out[0].get("unmeasured_axial").is_none(), "{out}");
    let law = sandbox.read("needs.rs");
    let stiffness = path["stiffness"].as_f64().unwrap() as f32;
    assert!(law.contains(&format!("stiffness: {stiffness:?}")), "{path}");
    assert!(bake(&scenes, "cortex-m4f")[0].get("fixed_point").is_none());
    let text = sandbox.done(&["bake", "needs.toml", "-o", "needs.rs", "--core", "cortex-m0plus"]).out;
    assert!(text.contains("bearing::fixed_point takes a constant one: stiffness "), "{text}");
    assert!(bake(&radial, "cortex-m0plus")[0].get("fixed_point").is_none());

    // A table: twice the distance of the groove centres, and the nodes of one speed, of which the flash has one or several.
    let table = swap(&radial, "model = \"angular\"", "model = \"tabulated\"");
    let out = bake(&table, "cortex-m0plus");
    let path = &out[0]["fixed_point"];
    let (memory, flash) = (path["node_bytes"].as_u64().unwrap(), out[0]["bytes"].as_u64().unwrap());
    assert!(memory > 1000 && flash.is_multiple_of(memory), "{memory} {flash}");
    let source = sandbox.read("needs.rs");
    let distance: f64 = source.split("distance: ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    let range = path["least_range"].as_f64().unwrap();
    assert!((range / distance - 2.0).abs() < 1e-6, "{path}");
    let text = sandbox.done(&["bake", "needs.toml", "-o", "needs.rs", "--core", "cortex-m0plus"]).out;
    assert!(
        text.contains(&format!(
            "`Tabulated` from these constants, {memory} bytes of memory for the nodes of one speed"
        )),
        "{text}"
    );
}
