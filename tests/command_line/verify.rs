//! `ballrace verify`: the certificate of `ballrace bake` computed again.

use crate::support::{DEMO_SCENE, SHORT, Sandbox, short_recording, swap};
use serde_json::Value;

/// A small scene: a bearing with a table and one without.
const SCENE: &str = r#"name = "two bearings"

[shaft]
speed = "12000 rpm"

[rotor]
mass = "3 kg"
diametral_inertia = 0.01
polar_inertia = 0.004
damping = [400, 400, 400, 0.4, 0.4]
load = [0, "-30 N", "90 N", 0, 0]

[[bearing]]
name = "DE"
station = "-50 mm"
facing = "+z"
model = "tabulated"
elements = 8
ball_diameter = "7 mm"
pitch_diameter = "38.5 mm"
inner_conformity = 0.52
outer_conformity = 0.52
contact_angle = "25 deg"
effects = ["centrifugal", "gyroscopic"]
table = { intervals = [16, 8, 6], approach = ["-5 um", "20 um"] }

[[bearing]]
name = "NDE"
station = "50 mm"
model = "lumped"
elements = 9
cage_ratio = 0.4
stiffness = 8e9
radial_play = "2 um"   # \ ends no comment: \
"#;

/// A sandbox with the scene and its constants in both languages.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs"]);
    sandbox.done(&["bake", "scene.toml", "--language", "c", "-o", "bearings.h"]);
    sandbox
}

/// Runs `verify` on a file that differs and returns its output.
fn different(sandbox: &Sandbox, args: &[&str]) -> String {
    let answer = sandbox.run(&[&["verify"], args].concat());
    assert_eq!(answer.code, Some(1), "{answer:?}");
    assert!(answer.err.contains("constants differ from the scene: "), "{answer:?}");
    answer.out
}

/// The text with the digit after the last of `marks`, each found after the one before, changed.
fn with_digit_changed(text: &str, marks: &[&str]) -> String {
    let after = marks.iter().fold(0, |at, mark| at + text[at..].find(mark).unwrap() + mark.len());
    let digit = after + text[after..].find(|c: char| matches!(c, '1'..='8')).unwrap();
    let next = char::from(text.as_bytes()[digit] + 1);
    format!("{}{next}{}", &text[..digit], &text[digit + 1..])
}

#[test]
fn baked_constants_are_equal_to_their_scene_without_it() {
    let sandbox = sandbox();
    std::fs::remove_file(sandbox.path("scene.toml")).unwrap();
    for file in ["bearings.rs", "bearings.h", "bearings.c"] {
        let out = sandbox.done(&["verify", file]).out;
        assert!(out.contains("equal to its scene") && out.contains("Bearing DE: checksum 0x"), "{file}: {out}");
        let json: Value = sandbox.done(&["verify", file, "--format", "json"]).json();
        assert_eq!(json["differences"].as_array().unwrap().len(), 0);
        assert!(json["fields"].as_u64().unwrap() > 30 && json["constants"].as_u64().unwrap() > 20, "{json}");
        assert_eq!(sandbox.done(&["verify", file, "--format", "csv"]).out, "file,part,name,line,found,expected\n");
    }
    // White space and commas before closing brackets, as a formatter changes them, do not count.
    let rust = sandbox.read("bearings.rs");
    let (constants, scene) = rust.split_once("// Text of the scene.").unwrap();
    let formatted = ('0'..='9').fold(constants.replace("], [", "],\n["), |text, digit| {
        text.replace(&format!("{digit} }}"), &format!("{digit},\n }}"))
    });
    let formatted = formatted + "// Text of the scene." + scene;
    sandbox.put("formatted.rs", formatted);
    sandbox.done(&["verify", "formatted.rs"]);
}

#[test]
fn one_bearing_is_verified_alone() {
    let sandbox = sandbox();
    sandbox.done(&["bake", "scene.toml", "--bearing", "NDE", "-o", "one.rs"]);
    assert!(!sandbox.read("one.rs").contains("bearing_de"));
    let out = sandbox.done(&["verify", "one.rs"]).out;
    assert!(out.contains("NDE") && !out.contains("Bearing DE"), "{out}");
}

#[test]
fn one_changed_digit_names_the_constant() {
    let sandbox = sandbox();
    let rust = sandbox.read("bearings.rs");
    let changed = with_digit_changed(&rust, &["pub static NODES", "= [", ", ["]);
    let line = 1 + rust.lines().zip(changed.lines()).position(|(a, b)| a != b).unwrap();
    sandbox.put("changed.rs", &changed);
    let out = different(&sandbox, &["changed.rs"]);
    assert!(out.starts_with(&format!("changed.rs:{line}: constant bearing_de::NODES: ")), "{out}");
    assert_eq!(out.lines().count(), 1, "{out}");

    sandbox.put("changed.rs", with_digit_changed(&rust, &["mod bearing_nde", "fn bearing", "stiffness"]));
    assert!(different(&sandbox, &["changed.rs"]).contains("constant bearing_nde::bearing: "));

    sandbox.put("changed.h", sandbox.read("bearings.h").replace("BEARINGS_H", "CHANGED_H"));
    let c = sandbox.read("bearings.c").replace("bearings.h", "changed.h");
    sandbox.put("changed.c", with_digit_changed(&c, &["bearing_nde = {", ".play"]));
    let json = sandbox.run(&["verify", "changed.h", "--format", "json"]);
    assert_eq!(json.code, Some(1));
    let differences = json.json::<Value>()["differences"].clone();
    assert_eq!(differences.as_array().unwrap().len(), 1, "{differences}");
    assert_eq!(differences[0]["name"], "bearing_nde");
    assert_eq!(differences[0]["file"], "changed.c");
    assert_eq!([&differences[0]["found"], &differences[0]["expected"]], ["3e-6f", "2e-6f"]);
    // Either file of the pair stands for both.
    assert!(different(&sandbox, &["changed.c"]).contains("changed.c:"));
}

#[test]
fn a_removed_and_an_added_constant_are_named() {
    let sandbox = sandbox();
    let rust = sandbox.read("bearings.rs");
    let (before, after) = rust.split_once("    pub const STATION").unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    sandbox.put("changed.rs", format!("{before}    pub const OTHER: u8 = 1;\n{after}"));
    let out = different(&sandbox, &["changed.rs"]);
    assert!(out.contains("changed.rs: constant bearing_de::STATION: nothing, expected "), "{out}");
    assert!(out.contains("constant bearing_de::OTHER: pub const OTHER : u8 = 1 ;, expected nothing"), "{out}");
}

#[test]
fn every_field_that_differs_is_named() {
    let sandbox = sandbox();
    let rust = sandbox.read("bearings.rs");
    for (from, to, name) in [
        ("bearing_de instructions: ", "bearing_de instructions: 1", "bearing_de instructions"),
        ("bearing_nde largest error: ", "bearing_nde largest error: 1", "bearing_nde largest error"),
        ("scene SHA-256: ", "scene SHA-256: 0", "scene SHA-256"),
        ("bearing_nde checksum: 0x", "bearing_nde checksum: 0xf", "bearing_nde checksum"),
    ] {
        sandbox.put("changed.rs", swap(&rust, from, to));
        let out = different(&sandbox, &["changed.rs"]);
        assert!(out.starts_with(&format!("changed.rs: field {name}: ")), "{out}");
        assert_eq!(out.lines().count(), 1, "{out}");
    }
    let version = env!("CARGO_PKG_VERSION");
    sandbox.put("changed.rs", swap(&rust, &format!("program: ballrace {version}"), "program: ballrace 0.0.9"));
    let out = different(&sandbox, &["changed.rs"]);
    assert!(out.starts_with("changed.rs: written by ballrace 0.0.9, compared by ballrace "), "{out}");
}

#[test]
fn an_edited_scene_in_the_file_is_found() {
    let sandbox = sandbox();
    let rust = sandbox.read("bearings.rs");
    sandbox.put("changed.rs", swap(&rust, "// radial_play = \"2 um\"", "// radial_play = \"3 um\""));
    let out = different(&sandbox, &["changed.rs"]);
    assert!(out.contains("field scene SHA-256: ") && out.contains("constant bearing_nde::bearing: "), "{out}");
    sandbox.put("changed.rs", swap(&rust, "// model = \"lumped\"", "// model = \"other\""));
    sandbox.refused(&["verify", "changed.rs"], 2, &["changed.rs: ", "scene.toml:", "model"]);
    sandbox.put("changed.rs", swap(&rust, "// model = \"lumped\"", "model = \"lumped\""));
    sandbox.refused(&["verify", "changed.rs"], 2, &["changed.rs: no complete scene in the comments"]);
}

#[test]
fn a_scene_beside_the_file_is_compared_on_request() {
    let sandbox = sandbox();
    sandbox.put("other.toml", swap(SCENE, "stiffness = 8e9", "stiffness = 9e9"));
    sandbox.done(&["verify", "bearings.rs", "--scene", "scene.toml"]);
    let out = different(&sandbox, &["bearings.rs", "--scene", "other.toml"]);
    assert!(out.contains("field scene SHA-256: ") && out.contains("bearing_nde"), "{out}");
    sandbox.refused(&["verify", "bearings.rs", "--scene", "absent.toml"], 2, &["absent.toml", "no file of this name"]);
}

#[test]
fn files_that_bake_has_not_written_are_refused() {
    let sandbox = sandbox();
    let expected = "expected a file that bake has written";
    sandbox.put("foreign.rs", "fn main() {}\n");
    sandbox.put("bytes.rs", [0xff, 0xfe, 0x00]);
    sandbox.put("empty.rs", "");
    for file in ["foreign.rs", "bytes.rs", "empty.rs", "scene.toml"] {
        sandbox.refused(&["verify", file], 2, &[file, "no complete certificate in the comments", expected]);
    }
    sandbox.refused(&["verify", "absent.rs"], 2, &["absent.rs: this file cannot be read"]);
    // Cut within the certificate, within the constants, within the scene, before the last line.
    let rust = sandbox.read("bearings.rs");
    let cuts = [
        ("// core: ", "certificate"),
        ("NODES", "scene"),
        ("// [rotor]", "scene"),
        ("//: ballrace scene end", "scene"),
    ];
    for (mark, what) in cuts {
        sandbox.put("cut.rs", &rust[..rust.find(mark).unwrap()]);
        sandbox.refused(&["verify", "cut.rs"], 2, &[&format!("cut.rs: no complete {what} in the comments")]);
    }
    sandbox.put("bad.rs", swap(&rust, "// language: rust", "// language: ada"));
    sandbox.refused(
        &["verify", "bad.rs"],
        2,
        &["bad.rs: field \"language\" of the certificate: invalid value: \"ada\", expected rust or c or blob"],
    );
    sandbox.put("bad.rs", swap(&rust, "// core: cortex-m4f", "// core: cortex-m3"));
    sandbox.refused(
        &["verify", "bad.rs"],
        2,
        &["field \"core\" of the certificate: invalid value: \"cortex-m3\", expected cortex-m4f or cortex-m33 or "],
    );
    sandbox.put("bad.rs", swap(&rust, "// poses from: simulation\n", ""));
    sandbox.refused(&["verify", "bad.rs"], 2, &["missing field \"poses from\" of the certificate"]);
    std::fs::remove_file(sandbox.path("bearings.c")).unwrap();
    sandbox.refused(&["verify", "bearings.h"], 2, &["bearings.c: this file cannot be read"]);
}

/// The recording of a scene is part of its certificate: poses and hash.
#[test]
fn a_recording_is_found_beside_the_file_or_the_scene() {
    let sandbox = Sandbox::rig();
    let baked: Value = sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs", "--format", "json"]).json();
    assert_eq!([&baked[0]["poses_from"], &baked[1]["poses_from"]], ["recording", "recording"]);
    let text = sandbox.read("bearings.rs");
    assert!(text.contains("// healthy.csv SHA-256: "), "{text}");
    sandbox.done(&["verify", "bearings.rs"]);
    std::fs::create_dir(sandbox.path("firmware")).unwrap();
    sandbox.put("firmware/bearings.rs", &text);
    sandbox.refused(&["verify", "firmware/bearings.rs"], 2, &["firmware/bearings.rs: ", "healthy.csv"]);
    sandbox.done(&["verify", "firmware/bearings.rs", "--scene", "scene.toml"]);
    sandbox.put("healthy.csv", short_recording(SHORT - 1));
    let out = different(&sandbox, &["bearings.rs"]);
    assert!(out.contains("bearings.rs: field healthy.csv SHA-256: "), "{out}");
}

/// The certificate has what was counted on the core, and the range of a core whose floats are software.
#[test]
fn the_certificate_has_the_counts_of_its_core() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let field = |core: &str, name: &str| {
        sandbox.done(&["bake", "scene.toml", "-o", "bearings.rs", "--core", core]);
        assert!(sandbox.done(&["verify", "bearings.rs"]).out.contains("equal to its scene"));
        let text = sandbox.read("bearings.rs");
        let begin = format!("// bearing_nde {name}: ");
        text.lines().find_map(|line| line.strip_prefix(&begin)).expect("a field").to_owned()
    };
    let counted = |table: &str| {
        let row = table.lines().find(|line| line.starts_with("radial 3/2;9;f32;exact;force, input checked;")).unwrap();
        row.split(';').skip(5).map(str::to_owned).collect::<Vec<_>>()
    };
    let m4f = counted(include_str!("../../runner/studies/src/trade/cores/cortex-m4f.csv"));
    let m33 = counted(include_str!("../../runner/studies/src/trade/cores/cortex-m33.csv"));
    let m0plus = counted(include_str!("../../runner/studies/src/trade/cores/cortex-m0plus.csv"));
    assert_eq!([field("cortex-m4f", "instructions"), field("cortex-m4f", "cycles")], m4f[..2]);
    assert_eq!(field("cortex-m33", "instructions"), m33[0]);
    assert_eq!(field("cortex-m33", "cycles"), "not measured");
    assert_eq!(field("cortex-m33", "stack"), format!("{} bytes", m33[2]));
    assert_eq!(field("cortex-m0plus", "instructions"), format!("{} to {}, by the input", m0plus[4], m0plus[0]));
}

#[test]
fn a_language_or_a_core_that_does_not_exist_is_refused() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let bake = |more: &[&str]| sandbox.run(&[&["bake", "scene.toml", "-o", "bearings.h"], more].concat());
    let language = bake(&["--language", "ada"]);
    assert!(language.code == Some(2) && language.err.contains("[possible values: rust, c, blob]"), "{language:?}");
    let core = bake(&["--core", "cortex-m3"]);
    assert!(core.code == Some(2) && core.err.contains("[possible values: cortex-m4f, cortex-m33, "), "{core:?}");
    assert_eq!(sandbox.files(), ["scene.toml"]);
}

#[test]
fn models_without_a_c_struct_are_rejected() {
    let refused = |scene: &str, part: &str| {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", scene);
        sandbox.refused(&["bake", "scene.toml", "--language", "c", "-o", "bearings.h"], 2, &[part]);
    };
    let wave = "radial_play = \"2 um\"\nwaviness = [{ surface = \"inner\", order = 5, amplitude = \"0.3 um\" }]\n#";
    refused(
        &swap(SCENE, "radial_play = \"2 um\"", wave),
        "bearing NDE: waviness or damage with --language c, expected a smooth bearing, or --language rust",
    );
    refused(
        &swap(SCENE, "elements = 9", "elements = 40"),
        "bearing NDE: 40 elements with --language c, expected at most 32",
    );
    let support = "[[bearing]]\nsupport = { mass = \"2 kg\", stiffness_x = 1e8, stiffness_y = 1e8, damping = 200 }\n";
    refused(&swap(SCENE, "[[bearing]]\n", support), "[rotor]: flexible rotor or elastic support with --language c");
    refused(&swap(SCENE, "name = \"NDE\"", "name = \"de\""), "bearings DE and de: both become the module bearing_de");
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let to = |output: &str, part: &str| {
        sandbox.refused(&["bake", "scene.toml", "--language", "c", "-o", output], 2, &["--output: invalid name", part]);
    };
    to("bearings.rs", "expected a name that ends in .h");
    to("my bearings.h", "expected letters, digits");
    // One bearing of a machine on supports has constants.
    sandbox.put("scene.toml", swap(SCENE, "[[bearing]]\n", support));
    sandbox.done(&["bake", "scene.toml", "--language", "c", "--bearing", "NDE", "-o", "bearings.h"]);
}

/// The observer of a rigid rotor has constants of C.
#[test]
fn the_observer_of_a_rigid_rotor_is_baked_in_c() {
    let sandbox = Sandbox::rig();
    sandbox.put("scene.toml", format!("{DEMO_SCENE}\n[observer]\nprocess_noise = 0.2\n"));
    sandbox.done(&["bake", "scene.toml", "--language", "c", "-o", "bearings.h"]);
    assert!(sandbox.read("bearings.h").contains("#define OBSERVER_MODEL (&ballrace_observer_of_2_bearings_5_probes)"));
    sandbox.done(&["verify", "bearings.h"]);
    sandbox.put("bearings.c", with_digit_changed(&sandbox.read("bearings.c"), &["observer_gains[", "= {"]));
    assert!(different(&sandbox, &["bearings.h"]).contains("constant observer_gains: "));
}
